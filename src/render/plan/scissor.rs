//! Converts a rectangle in clip space to a scissor rectangle, in pixels of the target.

use glam::Vec4;

/// The smallest rectangle of pixels (x0, y0, x1, y1; the last two exclusive) that contains a rectangle in clip space (left, top, right, bottom), limited to
/// the target. For a rectangle outside the target it is empty: x0 >= x1 or y0 >= y1.
pub(super) fn scissor(rect: Vec4, width: u32, height: u32) -> [u32; 4] {
    let to_px = |clip: f32, size: u32| f64::from(clip).mul_add(0.5, 0.5) * f64::from(size);
    let (x0, x1) = (to_px(rect.x, width), to_px(rect.z, width));
    let (y0, y1) = (to_px(-rect.y, height), to_px(-rect.w, height));
    // `as` saturates, so negative values become 0.
    [x0.floor() as u32, y0.floor() as u32, (x1.ceil() as u32).min(width), (y1.ceil() as u32).min(height)]
}
