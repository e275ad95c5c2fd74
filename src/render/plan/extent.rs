//! Bounds of the pixels that a body's draw can change, so that a renderer may skip the others: the outline of its ellipsoid on the screen, and an image
//! that marks pixels which the draw discards ([`MarkedImage`]).
//!
//! A *form* is a quadratic polynomial of the position on the screen that is positive inside an outline. In: the uniforms of a body's draw, with its silhouette
//! form, a polynomial of the position (u, v) in the draw's rectangle. The silhouette form is |ray|^2 (1 - q^2), in the unit-sphere frame: the ray is
//! `ray_origin` + u `ray_du` + v `ray_dv`, and q is its distance from the body's centre. Out: forms in pixel coordinates. Always: each outline is an ellipse,
//! so its form is concave: over a rectangle it is least at a corner, and nowhere above its tangent plane at the middle.

use crate::scene::camera::silhouette::PADDING_PX;
use crate::scene::draw::{BodyPart, Draw, DrawUniforms, Shape};
use glam::{DVec3, DVec4};

/// The pixels that a draw may change: those inside one outline, outside a second one if there is one, and not discarded by marks ([`MarkedImage`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    inside: Ellipse,
    /// For the sky: the outline of the ground, which hides the sky except behind its antialiased edge.
    outside: Option<Ellipse>,
    /// For clouds: where all four texels around a pixel are marked, the ground's draw shows the clouds.
    pub(crate) marked: Option<MarkedImage>,
}

/// An image whose texels lie on the screen at every `pixels_per_texel`-th corner of pixels. Some texels are marked (alpha 1). The draw discards each pixel
/// whose four nearest texels are marked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkedImage {
    /// Binding of the image in the draw's module.
    pub binding: u32,
    /// Distance between neighbouring texels, in pixels.
    pub pixels_per_texel: u32,
    /// Column and row of the texel at the screen's top left corner: the image has a border, and may hold other images above this one.
    pub first_texel: [u32; 2],
}

impl MarkedImage {
    /// The rectangle of texels that surround a rectangle of pixels. Both are given by left, top, right and bottom edge, the last two exclusive.
    pub(crate) fn texels_around(&self, [left, top, right, bottom]: [u32; 4]) -> [u32; 4] {
        let [x, y] = self.first_texel;
        let texel_before = |pixel: u32| pixel / self.pixels_per_texel;
        // The last pixel lies between the texel `texel_before` and the next; the exclusive edge is one further: hence 2.
        let [last_column, last_row] = [right, bottom].map(|edge| edge.saturating_sub(1));
        [x + texel_before(left), y + texel_before(top), x + texel_before(last_column) + 2, y + texel_before(last_row) + 2]
    }
}

/// Coefficients of 1, x, y, x^2, xy, y^2 for a position in pixels; the form is positive inside the ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ellipse([f64; 6]);

impl Extent {
    /// The extent of a body's draw on a screen of this size in pixels; `None` if no bound tighter than the draw's rectangle is known. `marked`: for the clouds'
    /// draw, if the ground's draw also shows clouds, the image that marks where.
    pub(super) fn of(draw: &Draw, screen: [u32; 2], marked: Option<MarkedImage>) -> Option<Self> {
        let (features, uniforms) = (&draw.features, &draw.uniforms);
        // The outline of a mesh, or of a limb with terrain, is no ellipse.
        if features.shape == Shape::Mesh || features.limb_heights {
            return None;
        }
        let outline = |form| Ellipse::over_pixels(form, uniforms, screen);
        match draw.part {
            BodyPart::Globe | BodyPart::Clouds => {
                let inside = outline(uniforms.silhouette_form.map(|row| row.as_dvec4()))?;
                Some(Self { inside, outside: None, marked })
            }
            // `depth_row.w` is positive if the body's centre is in front of the camera. If it is behind, the form is also positive for rays that meet the
            // ellipsoid behind the camera.
            BodyPart::Sky if uniforms.depth_row.w > 0.0 => {
                let ground = uniforms.silhouette_form.map(|row| row.as_dvec4());
                Some(Self { inside: outline(air_top_form(ground, uniforms))?, outside: Some(outline(ground)?), marked: None })
            }
            // The sky of a body whose centre is behind the camera, and parts without a silhouette form.
            _ => None,
        }
    }

    /// Whether the outlines exclude every pixel of a rectangle: left, top, right and bottom edge (the last two exclusive). Marks are not considered.
    pub(crate) fn misses(&self, pixels: [u32; 4]) -> bool {
        self.inside.is_outside(pixels) || self.outside.is_some_and(|o| o.contains(pixels))
    }

    /// Whether the outlines exclude no pixel of a rectangle, so that none of them crosses it. Marks are not considered.
    pub(crate) fn covers(&self, pixels: [u32; 4]) -> bool {
        self.inside.contains(pixels) && self.outside.is_none_or(|o| o.is_outside(pixels))
    }
}

impl Ellipse {
    /// Converts a form over the draw's rectangle to pixel coordinates; `None` if its outline is not an ellipse: one branch of a
    /// hyperbola would belong to rays behind the camera.
    fn over_pixels(form: [DVec4; 2], uniforms: &DrawUniforms, screen: [u32; 2]) -> Option<Self> {
        let form = form_over_pixels(form, uniforms, screen);
        let [_, _, _, xx, xy, yy] = form;
        (form.iter().all(|c| c.is_finite()) && xx < 0.0 && yy < 0.0 && 4.0 * xx * yy > xy * xy).then_some(Self(form))
    }

    /// Whether the rectangle, with a margin, is entirely inside: a concave function is least at a corner.
    fn contains(&self, pixels: [u32; 4]) -> bool {
        let ([x, y], [half_x, half_y]) = middle_and_padded_half_sides(pixels);
        [-half_x, half_x].iter().all(|dx| [-half_y, half_y].iter().all(|dy| self.value_at(x + dx, y + dy) > 0.0))
    }

    /// Whether the rectangle, with a margin, is entirely outside: a concave function lies below its tangent plane.
    fn is_outside(&self, pixels: [u32; 4]) -> bool {
        let ([middle_x, middle_y], [half_x, half_y]) = middle_and_padded_half_sides(pixels);
        let [_, linear_x, linear_y, xx, xy, yy] = self.0;
        let slope_x = linear_x + 2.0 * xx * middle_x + xy * middle_y;
        let slope_y = linear_y + 2.0 * yy * middle_y + xy * middle_x;
        self.value_at(middle_x, middle_y) + slope_x.abs() * half_x + slope_y.abs() * half_y < 0.0
    }

    /// The value of the form.
    fn value_at(&self, px: f64, py: f64) -> f64 {
        let [constant, linear_x, linear_y, xx, xy, yy] = self.0;
        constant + px * (linear_x + xx * px + xy * py) + py * (linear_y + yy * py)
    }
}

/// The middle of a rectangle, and half its sides plus a margin: an antialiased edge extends half a pixel beyond the outline, and shaders run on quads of 2 x 2
/// pixels.
fn middle_and_padded_half_sides(pixels: [u32; 4]) -> ([f64; 2], [f64; 2]) {
    let [left, top, right, bottom] = pixels.map(f64::from);
    ([0.5 * (left + right), 0.5 * (top + bottom)], [0.5 * (right - left) + PADDING_PX, 0.5 * (bottom - top) + PADDING_PX])
}

/// The form of the top of the air, |ray|^2 (r^2 - q^2), from that of the ground, |ray|^2 (1 - q^2); r is the radius of the top.
fn air_top_form(ground: [DVec4; 2], uniforms: &DrawUniforms) -> [DVec4; 2] {
    let [origin, du, dv] = [uniforms.ray_origin, uniforms.ray_du, uniforms.ray_dv].map(|v| v.as_dvec3());
    // |ray|^2, coefficients in the order of `form_over_pixels`.
    let length_sq =
        [DVec3::new(origin.dot(origin), 2.0 * origin.dot(du), 2.0 * origin.dot(dv)), DVec3::new(du.dot(du), 2.0 * du.dot(dv), dv.dot(dv))];
    let top_radius_sq_minus_1 = f64::from(uniforms.air.top_radius_sq_minus_1);
    [0, 1].map(|row: usize| ground[row] + top_radius_sq_minus_1 * length_sq[row].extend(0.0))
}

/// Converts a form over the draw's rectangle to pixel coordinates. `linear`: coefficients of 1, u, v; `quadratic`: of u^2, uv, v^2; their w is unused. u and v
/// are 0 to 1 over the rectangle, v from the top. Returns the coefficients of [`Ellipse`].
fn form_over_pixels([linear, quadratic]: [DVec4; 2], uniforms: &DrawUniforms, [width, height]: [u32; 2]) -> [f64; 6] {
    let rect = uniforms.rect_in_clip.as_dvec4();
    // u = u0 + du x, and v = v0 + dv y. The rectangle is left, top, right, bottom; clip y points up.
    let (du, dv) = (2.0 / (f64::from(width) * (rect.z - rect.x)), -2.0 / (f64::from(height) * (rect.w - rect.y)));
    let (u0, v0) = ((-1.0 - rect.x) / (rect.z - rect.x), (1.0 - rect.y) / (rect.w - rect.y));
    let constant = linear.x + u0 * (linear.y + u0 * quadratic.x + v0 * quadratic.y) + v0 * (linear.z + v0 * quadratic.z);
    let slope_u = linear.y + 2.0 * u0 * quadratic.x + v0 * quadratic.y;
    let slope_v = linear.z + 2.0 * v0 * quadratic.z + u0 * quadratic.y;
    [constant, slope_u * du, slope_v * dv, quadratic.x * du * du, quadratic.y * du * dv, quadratic.z * dv * dv]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle around (128, 128) on a screen of 256 pixels, given over a rectangle that is not the screen.
    fn circle(radius: f64) -> Ellipse {
        // Over the rectangle from pixel 16 to 240: radius^2 - (224 u - 112)^2 - (224 v - 112)^2.
        let slope = 2.0 * 224.0 * 112.0;
        let form =
            [DVec4::new(radius * radius - 2.0 * 112.0 * 112.0, slope, slope, 0.0), DVec4::new(-224.0 * 224.0, 0.0, -224.0 * 224.0, 0.0)];
        let clip = |px: f32| px / 128.0 - 1.0;
        let rect_in_clip = glam::Vec4::new(clip(16.0), -clip(16.0), clip(240.0), -clip(240.0));
        Ellipse::over_pixels(form, &DrawUniforms { rect_in_clip, ..DrawUniforms::default() }, [256, 256]).expect("an ellipse")
    }

    #[test]
    fn a_block_is_left_out_only_if_each_of_its_pixels_is_beyond_an_outline() {
        let extents = [
            Extent { inside: circle(100.0), outside: None, marked: None },
            Extent { inside: circle(110.0), outside: Some(circle(90.0)), marked: None },
        ];
        // `min` and `max`: distances from the centre between which the extent shows pixels; -1 is no inner limit.
        for (extent, [min, max]) in extents.iter().zip([[-1.0, 100.0], [90.0, 110.0]]) {
            let (mut missed, mut covered) = (0, 0);
            for (x, y) in (0..256).step_by(16).flat_map(|x| (0..256).step_by(8).map(move |y| (x, y))) {
                let distance = |px: u32, py: u32| (f64::from(px) + 0.5 - 128.0).hypot(f64::from(py) + 0.5 - 128.0);
                let all = |test: &dyn Fn(f64) -> bool| (x..x + 16).all(|px| (y..y + 8).all(|py| test(distance(px, py))));
                let block = [x, y, x + 16, y + 8];
                let shown = |d: f64| d > min - 1.0 && d < max + 1.0;
                if extent.misses(block) {
                    assert!(all(&|d| !shown(d)), "{block:?}");
                    missed += 1;
                } else {
                    // The bounds are conservative, but not beyond these distances.
                    assert!(!all(&|d| d > max + 25.0 || d < min - 4.0), "{block:?} is far beyond");
                }
                if extent.covers(block) {
                    assert!(all(&shown) && !extent.misses(block), "{block:?}");
                    covered += 1;
                }
            }
            // Of 512 blocks, 208 are inside the circle of radius 100, and its edge crosses 76 (counted by their corners). The second extent, a ring 20 pixels
            // wide, may cover none.
            assert!(missed > 150 && (covered > 160 || min > 0.0), "{missed} {covered}");
        }
    }

    #[test]
    fn an_open_outline_bounds_nothing() {
        let hyperbola = [DVec4::new(1.0, 0.0, 0.0, 0.0), DVec4::new(-1.0, 0.0, 1.0, 0.0)];
        let rect_in_clip = glam::Vec4::new(-1.0, 1.0, 1.0, -1.0);
        assert_eq!(Ellipse::over_pixels(hyperbola, &DrawUniforms { rect_in_clip, ..DrawUniforms::default() }, [64, 64]), None);
    }
}
