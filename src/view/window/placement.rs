//! Position and size of the window, saved between runs and fitted to the monitors that are connected now.
//!
//! In: the saved placement and the monitors. Out: the placement at which to open the window. Always: the window is not larger than its monitor; its
//! position is kept only if the user can see and move the window at this position. Not here: access to the window itself.

use serde::{Deserialize, Serialize};

/// A window's placement on the desktop: its position and size while it is neither maximised nor fullscreen, and whether it is maximised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowPlacement {
    /// Upper left corner of the window frame, desktop pixels; `None` if the system does not report it.
    pub corner_px: Option<[i32; 2]>,
    /// Width and height without the frame, points.
    pub size: [f64; 2],
    pub maximised: bool,
}

impl Default for WindowPlacement {
    fn default() -> Self {
        Self { corner_px: None, size: [1280.0, 800.0], maximised: false }
    }
}

/// A monitor of the desktop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Monitor {
    /// Upper left corner, desktop pixels.
    pub corner_px: [i32; 2],
    pub size_px: [u32; 2],
    /// Pixels per point.
    pub scale: f64,
}

/// Smallest width and height of a window, unless its monitor is smaller: in less, the bars wrap until little is left of the image, and the user can no longer
/// scroll to each control of a panel.
pub(crate) const MIN_SIZE_POINTS: [f64; 2] = [600.0, 340.0];
/// Width and height reserved for a window's frame and a taskbar.
const DECORATIONS_POINTS: [f64; 2] = [16.0, 64.0];
/// Smallest side of a monitor whose reported size is used: a system without monitors may report one of a single pixel.
const MIN_MONITOR_SIDE_POINTS: f64 = 64.0;
/// Distance of the middle of the title bar from the window's upper edge.
const TITLE_BAR_MIDDLE_POINTS: f64 = 8.0;

impl Monitor {
    /// Whether a point of the desktop is on this monitor.
    fn contains(&self, point_px: [f64; 2]) -> bool {
        (0..2).all(|axis| {
            let start_px = f64::from(self.corner_px[axis]);
            (start_px..start_px + f64::from(self.size_px[axis])).contains(&point_px[axis])
        })
    }

    /// The number of pixels on this monitor of a window with this upper left corner and size.
    pub(crate) fn visible_pixel_count(&self, corner_px: [i32; 2], size_px: [u32; 2]) -> i64 {
        let overlap_px = |axis: usize| {
            let [window_start, monitor_start] = [corner_px[axis], self.corner_px[axis]].map(i64::from);
            let overlap_end = (window_start + i64::from(size_px[axis])).min(monitor_start + i64::from(self.size_px[axis]));
            (overlap_end - window_start.max(monitor_start)).max(0)
        };
        overlap_px(0) * overlap_px(1)
    }

    /// Largest size of a window without its frame, points; `None` if the reported size is unusable.
    fn available_size(&self) -> Option<[f64; 2]> {
        let size = self.size_px.map(|side| f64::from(side) / self.scale);
        let is_usable = size.iter().all(|side| side.is_finite() && *side >= MIN_MONITOR_SIDE_POINTS);
        is_usable.then(|| [0, 1].map(|axis| (size[axis] - DECORATIONS_POINTS[axis]).max(MIN_MONITOR_SIDE_POINTS)))
    }
}

impl WindowPlacement {
    /// The smallest size that the user can give to a window that opens here, points.
    pub(crate) fn min_size(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.size[axis].min(MIN_SIZE_POINTS[axis]))
    }

    /// The placement at which to open the window. If the middle of the title bar is on one of the monitors, the position is kept and the size fits that
    /// monitor; otherwise the position is dropped and the size fits the first monitor.
    pub(crate) fn fitted_to(&self, monitors: &[Monitor]) -> Self {
        let shows_title_bar = |monitor: &Monitor, [x, y]: [i32; 2]| {
            monitor.contains([f64::from(x) + 0.5 * self.size[0] * monitor.scale, f64::from(y) + TITLE_BAR_MIDDLE_POINTS * monitor.scale])
        };
        let containing_monitor = self.corner_px.and_then(|corner| monitors.iter().find(|monitor| shows_title_bar(monitor, corner)));
        let available_size = containing_monitor.or(monitors.first()).and_then(Monitor::available_size).unwrap_or([f64::INFINITY; 2]);
        let default_size = Self::default().size;
        let size = [0, 1].map(|axis| {
            let wanted = if self.size[axis].is_finite() { self.size[axis].max(MIN_SIZE_POINTS[axis]) } else { default_size[axis] };
            wanted.min(available_size[axis])
        });
        Self { corner_px: self.corner_px.filter(|_| containing_monitor.is_some()), size, maximised: self.maximised }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEFT: Monitor = Monitor { corner_px: [0, 0], size_px: [1500, 1200], scale: 1.0 };
    const RIGHT: Monitor = Monitor { corner_px: [1500, 0], size_px: [1500, 1200], scale: 1.0 };
    const BELOW: Monitor = Monitor { corner_px: [0, 1200], size_px: [1280, 720], scale: 2.0 };

    fn at(x: i32, y: i32) -> WindowPlacement {
        WindowPlacement { corner_px: Some([x, y]), size: [1000.0, 700.0], maximised: false }
    }

    #[test]
    fn a_visible_placement_is_kept() {
        for place in [at(0, 0), at(1600, 300), at(1200, 50), at(-400, 1000)] {
            assert_eq!(place.fitted_to(&[LEFT, RIGHT]), place);
        }
        let maximised = WindowPlacement { maximised: true, ..at(1700, 0) };
        assert_eq!(maximised.fitted_to(&[LEFT, RIGHT]), maximised);
    }

    #[test]
    fn off_screen_placements_lose_their_position_but_keep_their_size() {
        let without_position = WindowPlacement { corner_px: None, ..at(0, 0) };
        // The right monitor was disconnected, or the window's upper edge is above, below or beside all monitors.
        for (place, monitors) in [
            (at(1600, 300), &[LEFT][..]),
            (at(100, -200), &[LEFT, RIGHT]),
            (at(100, 1195), &[LEFT, RIGHT]),
            (at(2600, 100), &[LEFT, RIGHT]),
            (at(-600, 100), &[LEFT, RIGHT]),
            (at(100, 100), &[]),
        ] {
            assert_eq!(place.fitted_to(monitors), without_position, "{place:?}");
        }
    }

    #[test]
    fn no_window_is_larger_than_its_monitor_or_too_small_to_see() {
        let sized = |size, corner_px| WindowPlacement { size, corner_px, maximised: false };
        let everywhere = [LEFT, RIGHT, BELOW];
        // The monitor with two pixels per point has room for 640 by 360 points including the window frame.
        assert_eq!(sized([1000.0, 700.0], Some([0, 1200])).fitted_to(&everywhere).size, [624.0, 296.0]);
        assert_eq!(sized([9000.0, 700.0], None).fitted_to(&everywhere).size, [1484.0, 700.0]);
        assert_eq!(sized([-5.0, 0.0], None).fitted_to(&everywhere).size, MIN_SIZE_POINTS);
        assert_eq!(sized([f64::NAN, f64::INFINITY], None).fitted_to(&everywhere).size, [1280.0, 800.0]);
        assert_eq!(sized([9000.0, 700.0], None).fitted_to(&everywhere).min_size(), MIN_SIZE_POINTS);
        // A monitor with less room than that.
        assert_eq!(sized([1000.0, 700.0], Some([0, 1200])).fitted_to(&everywhere).min_size(), [600.0, 296.0]);
        let unknown_size = Monitor { size_px: [1, 1], ..LEFT };
        assert_eq!(sized([1000.0, 700.0], None).fitted_to(&[unknown_size]).size, [1000.0, 700.0]);
        assert_eq!(sized([1000.0, 700.0], None).fitted_to(&[Monitor { scale: 0.0, ..LEFT }]).size, [1000.0, 700.0]);
    }

    #[test]
    fn visible_pixels_are_counted_per_monitor() {
        let shown = |corner, size| [LEFT, RIGHT, BELOW].map(|monitor| monitor.visible_pixel_count(corner, size));
        assert_eq!(shown([100, 100], [200, 100]), [20_000, 0, 0]);
        assert_eq!(shown([1400, -50], [200, 100]), [5_000, 5_000, 0]);
        assert_eq!(shown([-100, 1150], [200, 100]), [5_000, 0, 5_000]);
        assert_eq!(shown([i32::MIN, 0], [u32::MAX, 1]), [1500, 1500, 0]);
    }

    #[test]
    fn a_saved_placement_is_restored() {
        let placement = WindowPlacement { maximised: true, ..at(-3, 17) };
        let json = serde_json::to_string(&placement).expect("text");
        assert_eq!(serde_json::from_str::<WindowPlacement>(&json).expect("a placement"), placement);
        assert_eq!(
            serde_json::from_str::<WindowPlacement>("{\"size\":[700.0,500.0]}").expect("a placement"),
            WindowPlacement { size: [700.0, 500.0], ..WindowPlacement::default() }
        );
    }
}
