//! Grids of longitude and latitude: which lines an image gets, and their coordinates as text.
//!
//! In: the size of a pixel and the visible part of a sphere. Out: `GridLine`s with an opacity that varies continuously with the field of view and along the
//! line: a line fades in as its neighbours move apart, and a meridian fades out towards the poles, where meridians would crowd. The direction of view does
//! not affect the opacity, so no line flickers when the camera pans. Not here: the orientation of the sphere, and drawing.

use crate::message::TextLanguage;
use crate::scene::numeric::smooth_rise;
use std::f64::consts::FRAC_PI_2;

/// Grid steps from 90 degrees down to an arcsecond, each a multiple of the next.
const STEPS_DEG: [f64; 11] = [90.0, 30.0, 10.0, 5.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 30.0, 1.0 / 60.0, 1.0 / 360.0, 1.0 / 3600.0];
/// Distance between neighbouring lines, in pixels, up to which a line is invisible, and from which it has its full opacity.
const SPACING_FADE_PX: (f64, f64) = (60.0, 130.0);

/// Largest latitude of a parallel: nearer to a pole the parallel would be a point.
const MAX_PARALLEL_DEG: f64 = 89.999_999;
/// The argument of [`GridLine::opacity`] for a parallel, whose opacity does not depend on it.
pub(crate) const ANY_LATITUDE_DEG: f64 = 0.0;
/// A line's coordinate is written if its opacity is greater than this.
pub(crate) const MIN_LABELLED_OPACITY: f64 = 0.5;

/// A parallel, or a meridian from pole to pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GridLine {
    pub kind: GridLineKind,
    /// Latitude of a parallel, or longitude of a meridian from 0 to 360.
    pub coordinate_deg: f64,
    /// Step of the coarsest grid that contains the line.
    step_deg: f64,
}

/// The kind of a grid line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GridLineKind {
    /// A circle of constant latitude.
    Parallel,
    /// A half circle of constant longitude.
    Meridian,
}

/// The part of a sphere that may be in view: a spherical cap about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cap {
    pub longitude_deg: f64,
    pub latitude_deg: f64,
    pub radius_deg: f64,
}

/// Opacity of lines at this distance from each other. `pixel_deg`: degrees per pixel.
fn opacity_at_spacing(spacing_deg: f64, pixel_deg: f64) -> f64 {
    smooth_rise(SPACING_FADE_PX, spacing_deg / pixel_deg)
}

impl GridLine {
    /// Opacity at a latitude, 0 to 1; `latitude_deg` has no effect on a parallel. `pixel_deg`: degrees per pixel.
    pub(crate) fn opacity(&self, latitude_deg: f64, pixel_deg: f64) -> f64 {
        let spacing_factor = match self.kind {
            GridLineKind::Parallel => 1.0,
            // The meridians of the coarsest step do not fade towards the poles.
            GridLineKind::Meridian if self.step_deg == STEPS_DEG[0] => 1.0,
            GridLineKind::Meridian => latitude_deg.to_radians().cos(),
        };
        opacity_at_spacing(self.step_deg * spacing_factor, pixel_deg)
    }

    /// For a meridian: the range of latitudes, from south to north, in which it is visible. `pixel_deg`: degrees per pixel.
    pub(crate) fn latitude_range_deg(&self, pixel_deg: f64) -> [f64; 2] {
        // Of the latitude; 0 if `pixel_deg` is 0.
        let min_cosine = SPACING_FADE_PX.0 * pixel_deg / self.step_deg;
        let max_deg = if self.step_deg == STEPS_DEG[0] || min_cosine <= 0.0 { 90.0 } else { min_cosine.min(1.0).acos().to_degrees() };
        [-max_deg, max_deg]
    }
}

/// The lines that may be visible in a cap of the sphere, where a pixel spans `pixel_deg`.
pub(crate) fn grid_lines(cap: Cap, pixel_deg: f64) -> Vec<GridLine> {
    let [south_deg, north_deg] = [cap.latitude_deg - cap.radius_deg, cap.latitude_deg + cap.radius_deg].map(|lat| lat.clamp(-90.0, 90.0));
    // Cosine of the cap's latitude nearest to the equator, where meridians are farthest apart.
    let largest_cosine = if south_deg * north_deg <= 0.0 { 1.0 } else { south_deg.abs().min(north_deg.abs()).to_radians().cos() };
    // Half the range of longitudes that the cap covers: at the meridian that touches the cap, sin(half width) = sin(radius) / cos(latitude). There is no such
    // meridian if the cap contains a pole; then the sine is at least 1, or the radius at least a quarter turn.
    let half_width_deg = {
        let (radius, latitude) = (cap.radius_deg.to_radians(), cap.latitude_deg.to_radians());
        let sine = radius.sin() / latitude.cos().max(1e-12);
        if radius >= FRAC_PI_2 || sine >= 1.0 { 180.0 } else { sine.asin().to_degrees() }
    };
    let mut lines = Vec::new();
    for (k, step_deg) in STEPS_DEG.into_iter().enumerate() {
        // The next coarser grid contains the lines of all coarser ones, because each step is a multiple of the next.
        let is_in_no_coarser_grid = |n: i64| k == 0 || !is_multiple(n as f64 * step_deg, STEPS_DEG[k - 1]);
        // The integers n for which n steps lie in a range of degrees.
        let indices = |from: f64, to: f64| ((from / step_deg).ceil() as i64)..=((to / step_deg).floor() as i64);
        if opacity_at_spacing(step_deg, pixel_deg) > 0.0 {
            let parallels =
                indices(south_deg, north_deg).filter(|n| is_in_no_coarser_grid(*n) && (*n as f64 * step_deg).abs() < MAX_PARALLEL_DEG);
            lines.extend(parallels.map(|n| GridLine { kind: GridLineKind::Parallel, coordinate_deg: n as f64 * step_deg, step_deg }));
        }
        // The meridians of the coarsest step do not fade towards the poles.
        let spacing_factor = if k == 0 { 1.0 } else { largest_cosine };
        if opacity_at_spacing(step_deg * spacing_factor, pixel_deg) > 0.0 {
            let range = if half_width_deg >= 180.0 {
                0..=((360.0 / step_deg).round() as i64 - 1)
            } else {
                indices(cap.longitude_deg - half_width_deg, cap.longitude_deg + half_width_deg)
            };
            let meridians = range.filter(|n| is_in_no_coarser_grid(*n));
            lines.extend(meridians.map(|n| GridLine {
                kind: GridLineKind::Meridian,
                coordinate_deg: (n as f64 * step_deg).rem_euclid(360.0),
                step_deg,
            }));
        }
    }
    lines
}

/// Whether a value is a multiple of the step, except for rounding.
fn is_multiple(value: f64, step: f64) -> bool {
    let ratio = value / step;
    (ratio - ratio.round()).abs() < 1e-6
}

/// An angle in degrees, minutes and seconds, without the smaller units that are zero: `-20°`, `-20°30'`, `1°0'5"`.
pub(crate) fn angle_text(degrees: f64) -> String {
    angle_text_with("", degrees)
}

/// [`angle_text`] with a plus sign if the angle is positive.
pub(crate) fn signed_angle_text(degrees: f64) -> String {
    angle_text_with("+", degrees)
}

/// [`angle_text`] with this text in front if the angle is positive.
fn angle_text_with(plus: &str, degrees: f64) -> String {
    let seconds = (degrees.abs() * 3600.0).round();
    let sign = match () {
        () if seconds == 0.0 => "",
        () if degrees < 0.0 => "-",
        () => plus,
    };
    sexagesimal_text(sign, (100.0 * seconds) as u64, ["°", "'", "\""])
}

/// A right ascension, given in degrees, as text in hours, minutes and seconds, without the smaller units that are zero. Seconds have up to two decimals,
/// because the finest grid has a meridian every 1/15 second.
pub(crate) fn hours_text(degrees: f64) -> String {
    const HUNDREDTHS_PER_HOUR: f64 = 360_000.0;
    let hundredths = (degrees.rem_euclid(360.0) / 15.0 * HUNDREDTHS_PER_HOUR).round() as u64 % (24 * HUNDREDTHS_PER_HOUR as u64);
    sexagesimal_text("", hundredths, ["h", "m", "s"])
}

/// A number of degrees or hours, given in hundredths of a second, without the smaller units that are zero. `sign`: `+`, `-` or nothing; the array: the symbols
/// of the units.
fn sexagesimal_text(sign: &str, hundredths: u64, [whole_symbol, minute_symbol, second_symbol]: [&str; 3]) -> String {
    let seconds = hundredths / 100;
    let (wholes, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match (minutes, seconds, hundredths % 100) {
        (0, 0, 0) => format!("{sign}{wholes}{whole_symbol}"),
        (_, 0, 0) => format!("{sign}{wholes}{whole_symbol}{minutes}{minute_symbol}"),
        (_, _, 0) => format!("{sign}{wholes}{whole_symbol}{minutes}{minute_symbol}{seconds}{second_symbol}"),
        (_, _, decimals) => {
            let seconds = format!("{seconds}.{decimals:02}");
            format!("{sign}{wholes}{whole_symbol}{minutes}{minute_symbol}{}{second_symbol}", seconds.trim_end_matches('0'))
        }
    }
}

/// The name of the compass point if the azimuth is a multiple of 45 degrees, else the azimuth as an angle.
pub(crate) fn azimuth_text(degrees: f64, language: TextLanguage) -> String {
    const POINTS: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
    let eighths_of_circle = degrees / 45.0;
    let point = ((eighths_of_circle.round() as i64).rem_euclid(8)) as usize;
    if (eighths_of_circle - eighths_of_circle.round()).abs() < 1e-9 {
        language.name("compass", POINTS[point]).to_owned()
    } else {
        angle_text(degrees)
    }
}

/// Degrees per pixel, the mean over the image's height; in a wide view, a pixel in the middle spans more than this, and one at the edge less. `tan_half_fov`:
/// tangent of half the vertical field of view.
pub(crate) fn mean_pixel_deg(tan_half_fov: f64, height_px: u32) -> f64 {
    2.0 * tan_half_fov.atan().to_degrees() / f64::from(height_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE_SPHERE: Cap = Cap { longitude_deg: 0.0, latitude_deg: 0.0, radius_deg: 180.0 };

    /// Each line occurs once, even if its coordinate is a multiple of several steps, and no more parallels are visible than fit at the least visible spacing.
    #[test]
    fn every_line_occurs_once() {
        for pixel_deg in [0.3, 0.09, 0.044, 0.01] {
            let all = grid_lines(WHOLE_SPHERE, pixel_deg);
            for (k, a) in all.iter().enumerate() {
                assert!(all[k + 1..].iter().all(|b| a.kind != b.kind || (a.coordinate_deg - b.coordinate_deg).abs() > 1e-7), "{a:?}");
            }
            let visible =
                all.iter().filter(|l| l.kind == GridLineKind::Parallel && l.opacity(ANY_LATITUDE_DEG, pixel_deg) > 0.0).count() as f64;
            assert!(visible <= 180.0 / (pixel_deg * SPACING_FADE_PX.0) + 1.0, "{pixel_deg}: {visible}");
        }
    }

    /// A cap with a radius of 500 pixels has at least one line with an opacity above one half and fewer than 4000 lines, from degrees down to arcseconds, also
    /// at the poles.
    #[test]
    fn views_of_any_size_have_visible_lines() {
        for (longitude_deg, latitude_deg) in [(10.2, 5.1), (359.9, -70.3), (120.0, 89.95), (3.0, -90.0)] {
            for radius_deg in [40.0, 3.0, 0.2, 0.005, 0.0005] {
                let lines = grid_lines(Cap { longitude_deg, latitude_deg, radius_deg }, radius_deg / 500.0);
                assert!((1..4000).contains(&lines.len()), "{longitude_deg} {latitude_deg} {radius_deg}: {}", lines.len());
                let strongest = lines.iter().map(|l| l.opacity(latitude_deg, radius_deg / 500.0)).fold(0.0, f64::max);
                assert!(strongest > 0.5, "{longitude_deg} {latitude_deg} {radius_deg}: {strongest}");
            }
        }
    }

    /// Where even the coarsest grid would be too dense, such as on a body of a few dozen pixels, there are no lines, hence no coordinates. At a pole the
    /// coarsest meridians are there at any zoom.
    #[test]
    fn invisible_lines_are_left_out() {
        assert!(grid_lines(WHOLE_SPHERE, 90.0 / (SPACING_FADE_PX.0 - 1.0)).is_empty());
        assert!(!grid_lines(WHOLE_SPHERE, 90.0 / (SPACING_FADE_PX.0 + 1.0)).is_empty());
        // A quarter turn is 180 pixels long.
        let pole = Cap { longitude_deg: 0.0, latitude_deg: 90.0, radius_deg: 0.1 };
        assert!(grid_lines(pole, 0.5).iter().any(|l| l.kind == GridLineKind::Meridian && l.opacity(90.0, 0.5) > 0.0));
    }

    /// Opacity changes continuously with the field of view, and is zero where a line ends.
    #[test]
    fn lines_fade_without_a_step() {
        let pixel_deg = 0.02;
        for line in grid_lines(WHOLE_SPHERE, pixel_deg) {
            let equator_deg = 0.0;
            // In each step a pixel grows by 0.3 %.
            let mut last = line.opacity(equator_deg, pixel_deg);
            for k in 1..=2000 {
                let next = line.opacity(equator_deg, pixel_deg * 1.003_f64.powi(k));
                assert!((next - last).abs() < 0.02 && next <= last, "{line:?}");
                last = next;
            }
            let [from, to] = line.latitude_range_deg(pixel_deg);
            // Meridians of the coarsest step end at the poles, without a fade.
            if line.kind == GridLineKind::Meridian && to < 89.0 {
                assert!(line.opacity(to, pixel_deg) < 1e-6 && line.opacity(from, pixel_deg) < 1e-6, "{line:?}");
            }
        }
    }

    #[test]
    fn coordinates_are_written_as_charts_write_them() {
        assert_eq!((signed_angle_text(-20.5).as_str(), signed_angle_text(20.0).as_str()), ("-20°30'", "+20°"));
        assert_eq!((signed_angle_text(0.0).as_str(), angle_text(1.0 + 5.0 / 3600.0).as_str()), ("0°", "1°0'5\""));
        assert_eq!((hours_text(90.0).as_str(), hours_text(82.5).as_str(), hours_text(360.0).as_str()), ("6h", "5h30m", "0h"));
        assert_eq!(hours_text(1.0 / 3600.0 * 7.5), "0h0m0.5s");
        assert_eq!((hours_text(-1e-9).as_str(), hours_text(359.999_999_99).as_str()), ("0h", "0h"));
        // Neighbouring meridians of the finest grid, an arcsecond apart, have different texts.
        assert_eq!([1.0, 2.0, 10.0].map(|arcsec| hours_text(arcsec / 3600.0)), ["0h0m0.07s", "0h0m0.13s", "0h0m0.67s"]);
        assert_eq!(([315.0, 30.0, 360.0, 90.0].map(|degrees| azimuth_text(degrees, TextLanguage::English))), ["NW", "30°", "N", "E"]);
    }
}
