//! Curves in space as line segments on the screen.
//!
//! In: a curve as a function of one parameter, with bounds on its derivatives. Out: [`LineSegment`]s in clip space, clipped to the frame, whose ends meet
//! exactly. Each span between two parameters is halved until its chord deviates from the arc by less than `MAX_CHORD_ERROR_PX`, or the span is outside the
//! frame. The result is a few hundred segments, however much of the curve is outside. All computation is in f64; only clip coordinates are narrowed to f32.

use crate::scene::camera::{Camera, NEAR_DEPTH_KM, narrow, narrow_scalar, narrow2};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::FRAC_PI_2;

/// Largest deviation of a chord from its arc, pixels.
pub(crate) const MAX_CHORD_ERROR_PX: f64 = 0.1;
/// Margin around the frame in which segments are kept, pixels: more than half the width of a line.
pub(crate) const MARGIN_PX: f64 = 4.0;
/// Maximum number of halvings of a span: a span of a curve of 100 au is then some tens of metres long.
const MAX_HALVINGS: u32 = 40;
/// Longest span, in units of the parameter, that may be replaced by its chord. The limit is needed because opacity is interpolated linearly along a chord.
const MAX_SPAN: f64 = 0.2;

/// A straight segment of a line on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSegment {
    /// x and y from -1 to 1 across the frame (y up), reversed depth.
    pub ends: [Vec3; 2],
    /// Unit normal of the line in the image (x right, y up) at each end. Adjacent segments share it.
    pub normals: [Vec2; 2],
    /// Opacity at each end.
    pub opacity: [f32; 2],
    /// Linear RGB.
    pub colour: Vec3,
}

/// A curve as seen from the camera.
pub(crate) struct Curve<'a> {
    pub camera: &'a Camera,
    /// Position relative to the camera, ICRF; kilometres, or a unit vector for points infinitely far away.
    pub point: &'a dyn Fn(f64) -> DVec3,
    /// Upper limit of the lengths of the first and the second derivative of `point` with respect to its parameter.
    pub derivative_bound: f64,
    /// Factor on [`MAX_CHORD_ERROR_PX`]: 1, or for points infinitely far away [`tolerance_factor_at_corners`].
    pub tolerance_factor: f64,
}

/// Pixel size at the corners of the image divided by the pixel size in its middle, both as angles at the camera. In a wide view the corners are magnified.
pub(crate) fn tolerance_factor_at_corners(camera: &Camera) -> f64 {
    1.0 / (1.0 + camera.tan_half_fov.length_squared())
}

/// Parameters that divide a range of angles, of at most two turns, into spans of at most a quarter turn, radians. The bounding sphere of such a span of a
/// circle is no larger than the circle.
pub(crate) fn split_into_quarter_turns([from, to]: [f64; 2]) -> Vec<f64> {
    let spans = ((to - from) / FRAC_PI_2).ceil().clamp(1.0, 8.0);
    (0..=spans as usize).map(|k| from + (to - from) * k as f64 / spans).collect()
}

/// Reversed depth of a point in camera axes, km.
pub(crate) fn reversed_depth(point: DVec3) -> f64 {
    (NEAR_DEPTH_KM / point.z).min(1.0)
}

/// A point of a curve.
#[derive(Clone, Copy)]
pub(crate) struct CurvePoint {
    /// Camera axes (right, up, forward); unit as in [`Curve::point`].
    pub position: DVec3,
    pub parameter: f64,
}

/// A part of a curve inside the frame (a run), as a polyline.
pub(crate) type Polyline = Vec<CurvePoint>;

/// Subdivides a curve and collects its parts inside the frame.
struct StrokeSubdivision<'a> {
    curve: &'a Curve<'a>,
    runs: Vec<Polyline>,
}

impl Curve<'_> {
    /// The point at a parameter.
    fn at(&self, parameter: f64) -> CurvePoint {
        CurvePoint { position: self.camera.in_axes((self.point)(parameter)), parameter }
    }

    /// The parts of the curve inside the frame. Each span between consecutive parameters is subdivided separately.
    pub(crate) fn runs(&self, parameters: &[f64]) -> Vec<Polyline> {
        let mut subdivision = StrokeSubdivision { curve: self, runs: Vec::new() };
        for span in parameters.windows(2) {
            let halvings = 0;
            subdivision.arc(self.at(span[0]), self.at(span[1]), halvings);
        }
        subdivision.runs
    }
}

impl StrokeSubdivision<'_> {
    /// Halves a span until its chord is accurate enough, and appends the chords.
    fn arc(&mut self, from: CurvePoint, to: CurvePoint, halvings: u32) {
        let middle = self.curve.at(0.5 * (from.parameter + to.parameter));
        let span = to.parameter - from.parameter;
        // No point of the arc is farther from its middle than this.
        let radius = 0.5 * self.curve.derivative_bound * span;
        if !self.curve.camera.sphere_may_be_in_frame(middle.position, radius, MARGIN_PX) {
            return;
        }
        // Upper limit of the distance between the arc and its chord.
        let deviation = self.curve.derivative_bound * span * span / 8.0;
        let nearest = (middle.position.length() - radius).max(NEAR_DEPTH_KM);
        let max_deviation = MAX_CHORD_ERROR_PX * self.curve.tolerance_factor * self.curve.camera.pixel_tangent() * nearest;
        if halvings >= MAX_HALVINGS || (span < MAX_SPAN && deviation < max_deviation) {
            return self.chord(from, to);
        }
        self.arc(from, middle, halvings + 1);
        self.arc(middle, to, halvings + 1);
    }

    /// Appends the part of a chord that is inside the frame.
    fn chord(&mut self, from: CurvePoint, to: CurvePoint) {
        let Some([enter, leave]) = clipped_to_frame(self.curve.camera, from.position, to.position) else { return };
        let at = |fraction: f64| {
            if fraction == 0.0 {
                from
            } else if fraction == 1.0 {
                to
            } else {
                CurvePoint {
                    position: from.position.lerp(to.position, fraction),
                    parameter: from.parameter + fraction * (to.parameter - from.parameter),
                }
            }
        };
        let last_point = self.runs.last().and_then(|run| run.last());
        let continues_last_run = enter == 0.0 && last_point.is_some_and(|last| last.parameter == from.parameter);
        if !continues_last_run {
            self.runs.push(vec![at(enter)]);
        }
        if let Some(run) = self.runs.last_mut() {
            run.push(at(leave));
        }
    }
}

/// Clips a segment between two points in camera axes to the frustum of the frame and its margin (Liang and Barsky 1984): the fractions of the segment at
/// which it enters and leaves; `None` if the segment is outside.
pub(crate) fn clipped_to_frame(camera: &Camera, from: DVec3, to: DVec3) -> Option<[f64; 2]> {
    let tan = camera.tan_half_fov * (1.0 + MARGIN_PX / camera.half_size_px());
    // For each plane of the frustum a multiple of the signed distance, positive inside. The near plane is at twice the near depth, so that rounding moves no
    // end nearer than the near depth.
    let planes = |p: DVec3| [p.z - 2.0 * NEAR_DEPTH_KM, tan.x * p.z - p.x, tan.x * p.z + p.x, tan.y * p.z - p.y, tan.y * p.z + p.y];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (a, b) in planes(from).into_iter().zip(planes(to)) {
        match (a < 0.0, b < 0.0) {
            (true, true) => return None,
            (true, false) => enter = enter.max(a / (a - b)),
            (false, true) => leave = leave.min(a / (a - b)),
            (false, false) => {}
        }
    }
    (enter < leave).then_some([enter, leave])
}

/// Converts a run to line segments. `depth`: reversed depth of a point in camera axes; `opacity`: opacity at a parameter; `colour`: linear RGB.
pub(crate) fn segments(
    camera: &Camera,
    run: &[CurvePoint],
    depth: impl Fn(DVec3) -> f64,
    opacity: impl Fn(f64) -> f64,
    colour: DVec3,
) -> Vec<LineSegment> {
    let to_screen = |p: DVec3| DVec2::new(p.x, p.y) / (p.z * camera.tan_half_fov) * camera.half_size_px();
    let screen: Vec<DVec2> = run.iter().map(|point| to_screen(point.position)).collect();
    let direction = |k: usize| (screen[k + 1] - screen[k]).try_normalize().unwrap_or(DVec2::X);
    let normal = |k: usize| {
        let mean = match k {
            0 => direction(0),
            k if k + 1 == screen.len() => direction(k - 1),
            k => (direction(k - 1) + direction(k)).try_normalize().unwrap_or(direction(k)),
        };
        narrow2(DVec2::new(-mean.y, mean.x))
    };
    let end = |k: usize| {
        let clip = screen[k] / camera.half_size_px();
        narrow(DVec3::new(clip.x, clip.y, depth(run[k].position)))
    };
    let opacity_of_point = |k: usize| narrow_scalar(opacity(run[k].parameter));
    let segment = |k: usize| LineSegment {
        ends: [end(k), end(k + 1)],
        normals: [normal(k), normal(k + 1)],
        opacity: [opacity_of_point(k), opacity_of_point(k + 1)],
        colour: narrow(colour),
    };
    (0..screen.len().saturating_sub(1)).map(segment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An arc inside the frame is one polyline, however its parameters are spaced; where it leaves the frame, the polyline ends.
    #[test]
    fn a_curve_is_cut_only_at_the_frame() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 800, 600);
        let point = |t: f64| DVec3::new(t.cos(), t.sin(), 0.0);
        let curve = Curve { camera: &camera, point: &point, derivative_bound: 1.0, tolerance_factor: 1.0 };
        let runs = |parameters: &[f64]| curve.runs(parameters).len();
        assert_eq!(runs(&[-0.3, 0.0, 0.3]), 1);
        assert_eq!(runs(&[0.0, 0.1, 0.2]), 1);
        // Two turns pass the camera's axis three times: at -2 pi, 0 and 2 pi.
        assert_eq!(runs(&[-2.0 * std::f64::consts::PI - 0.1, 0.0, 2.0 * std::f64::consts::PI + 0.1]), 3);
    }
}
