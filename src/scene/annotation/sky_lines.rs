//! Lines on the sky, infinitely far away: grids, and the figures and boundaries of constellations, with their labels.
//!
//! In: the requested layers, the viewer, and the local horizon if the viewer stands on a body. Out: `AnnotationLines`: line segments in drawing order, which
//! all bodies hide; their labels; and a decision about each layer. Always: a vertex of a figure is at the drawn position of its star; a grid line is where
//! the probe query `project` puts its coordinates. Both include the viewer's aberration, except the horizontal grid, which belongs to the ground.

use crate::catalog::constellations::{Constellation, Constellations, FigureVertex, icrf_from_b1875};
use crate::catalog::stars::StarCatalog;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::orientation::true_of_date_from_gcrs;
use crate::message::{Reason, reason};
use crate::scene::annotation::grids::{
    ANY_LATITUDE_DEG, Cap, GridLine, GridLineKind, MIN_LABELLED_OPACITY, angle_text, azimuth_text, grid_lines, hours_text, mean_pixel_deg,
    signed_angle_text,
};
use crate::scene::annotation::line_texts::UnplacedText;
use crate::scene::annotation::strokes::{Curve, LineSegment, Polyline, segments, split_into_quarter_turns, tolerance_factor_at_corners};
use crate::scene::camera::Camera;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::decision::Decision;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::frames::{SkyFrame, unit_vector};
use crate::scene::sky::stars::StarPlacer;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Lines with their labels and decisions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AnnotationLines {
    pub segments: Vec<LineSegment>,
    pub texts: Vec<UnplacedText>,
    pub decisions: Vec<Decision>,
}

/// Colour (linear RGB) and opacity of a layer's lines.
#[derive(Clone, Copy)]
struct LineStyle {
    colour: DVec3,
    opacity: f64,
}

const fn style(red: f64, green: f64, blue: f64, opacity: f64) -> LineStyle {
    LineStyle { colour: DVec3::new(red, green, blue), opacity }
}

const EQUATORIAL: LineStyle = style(0.25, 0.55, 1.0, 0.5);
const EQUATORIAL_OF_DATE: LineStyle = style(0.2, 0.85, 0.9, 0.5);
const ECLIPTIC: LineStyle = style(1.0, 0.65, 0.2, 0.5);
const GALACTIC: LineStyle = style(0.85, 0.35, 1.0, 0.5);
const HORIZON: LineStyle = style(0.3, 1.0, 0.4, 0.5);
const FIGURE: LineStyle = style(0.45, 0.65, 1.0, 0.75);
const BOUNDARY: LineStyle = style(1.0, 0.35, 0.3, 0.45);

/// Smallest vertical field of view in which constellations are named.
const NAMES_MIN_FOV_DEG: f64 = 4.0;

/// Bound of the lengths of the first and second derivatives of a great circle on the unit sphere with respect to its angle in radians. They are 1; aberration
/// changes them by about 1e-4.
const DERIVATIVE_BOUND: f64 = 1.001;

/// Radius of the cap, about the camera's direction, of all places on the sky that aberration may move into the frame.
fn cap_radius_deg(camera: &Camera, velocity_km_s: DVec3) -> f64 {
    let aberration_deg = (velocity_km_s.length() / SPEED_OF_LIGHT_KM_S).to_degrees();
    // A hundredth of a degree allows for rounding and for the second order of the aberration.
    camera.corner_rad().to_degrees() + aberration_deg + 0.01
}

/// Collects the lines of the sky.
struct SkyLineBuilder<'a> {
    camera: &'a Camera,
    /// Velocity for the aberration of the sky, relative to the solar system barycentre, ICRF.
    velocity_km_s: DVec3,
    output: AnnotationLines,
}

impl SkyLineBuilder<'_> {
    /// Draws an arc on the unit sphere between two parameters in radians, with first and second derivatives of at most `derivative_bound`. `point`: direction
    /// (ICRF) at a parameter; `opacity_factor`: factor on the style's opacity at a parameter. Returns the runs, its connected parts inside the frame.
    fn arc(
        &mut self,
        point: &dyn Fn(f64) -> DVec3,
        range_rad: [f64; 2],
        derivative_bound: f64,
        opacity_factor: impl Fn(f64) -> f64,
        style: LineStyle,
    ) -> Vec<Polyline> {
        let curve = Curve { camera: self.camera, point, derivative_bound, tolerance_factor: tolerance_factor_at_corners(self.camera) };
        let runs = curve.runs(&split_into_quarter_turns(range_rad));
        for run in &runs {
            // Reversed depth 0 is infinitely far away, behind all bodies.
            self.output.segments.extend(segments(self.camera, run, |_| 0.0, |t| style.opacity * opacity_factor(t), style.colour));
        }
        runs
    }

    /// The shorter arc of a great circle between two directions.
    fn great_circle(&mut self, from: DVec3, to: DVec3, style: LineStyle) {
        let angle = crate::ephemeris::angle_rad(from, to);
        let Some(perpendicular) = (to - from * from.dot(to)).try_normalize() else { return };
        let opacity_factor = |_: f64| 1.0;
        self.arc(&|t: f64| from * t.cos() + perpendicular * t.sin(), [0.0, angle], DERIVATIVE_BOUND, opacity_factor, style);
    }

    /// Records the decision about one layer. `effect`: the layer's name.
    fn record_decision(&mut self, effect: &'static str, on: bool, reason: Reason) {
        self.output.decisions.push(Decision { effect, on, reason, stated_error: None });
    }

    /// Draws a grid and its coordinates. `effect`: the layer's name; `velocity_km_s`: velocity for the aberration, zero for none; `longitude_text`: the text of
    /// a longitude in degrees.
    fn grid(
        &mut self,
        effect: &'static str,
        icrf_from_frame: DMat3,
        velocity_km_s: DVec3,
        style: LineStyle,
        longitude_text: impl Fn(f64) -> String,
    ) {
        let camera = self.camera;
        let pixel_deg = mean_pixel_deg(camera.tan_half_fov.y, camera.height);
        let forward_in_frame = icrf_from_frame.transpose() * camera.forward;
        let radius_deg = cap_radius_deg(camera, velocity_km_s);
        let longitude_deg = forward_in_frame.y.atan2(forward_in_frame.x).to_degrees();
        let cap = Cap { longitude_deg, latitude_deg: forward_in_frame.z.clamp(-1.0, 1.0).asin().to_degrees(), radius_deg };
        let apparent =
            |longitude_deg: f64, latitude_deg: f64| aberrated(icrf_from_frame * unit_vector(longitude_deg, latitude_deg), velocity_km_s);
        let mut count = 0;
        for line in grid_lines(cap, pixel_deg) {
            let runs = self.grid_line(&line, cap, pixel_deg, &apparent, style);
            count += usize::from(!runs.is_empty());
            let text = match line.kind {
                GridLineKind::Parallel => signed_angle_text(line.coordinate_deg),
                GridLineKind::Meridian => longitude_text(line.coordinate_deg),
            };
            self.label_grid_line(&line, &runs, pixel_deg, text, style);
        }
        self.record_decision(effect, count > 0, reason!("lines-count", count = count));
    }

    /// Draws a grid line; returns its runs inside the frame. `apparent`: direction in which a longitude and latitude (degrees) appear.
    fn grid_line(
        &mut self,
        line: &GridLine,
        cap: Cap,
        pixel_deg: f64,
        apparent: &dyn Fn(f64, f64) -> DVec3,
        style: LineStyle,
    ) -> Vec<Polyline> {
        let coordinate_deg = line.coordinate_deg;
        match line.kind {
            GridLineKind::Parallel => {
                let opacity = line.opacity(ANY_LATITUDE_DEG, pixel_deg);
                let derivative_bound = DERIVATIVE_BOUND * coordinate_deg.to_radians().cos() + 1e-9;
                // Starts opposite the middle of the image, so that no end is visible.
                let from = (cap.longitude_deg + 180.0).to_radians();
                if opacity <= 0.0 {
                    Vec::new()
                } else {
                    self.arc(&|t: f64| apparent(t.to_degrees(), coordinate_deg), [from, from + TAU], derivative_bound, |_| opacity, style)
                }
            }
            GridLineKind::Meridian => {
                let [from, to] = line.latitude_range_deg(pixel_deg).map(f64::to_radians);
                let opacity = |t: f64| line.opacity(t.to_degrees(), pixel_deg);
                self.arc(&|t: f64| apparent(coordinate_deg, t.to_degrees()), [from, to], DERIVATIVE_BOUND, opacity, style)
            }
        }
    }

    /// Writes the coordinate of a grid line at the end nearest to the left edge of the frame (parallels) or to its lower edge (meridians), unless the line is
    /// too faint there.
    fn label_grid_line(&mut self, line: &GridLine, runs: &[Polyline], pixel_deg: f64, text: String, style: LineStyle) {
        let half_size_px = self.camera.half_size_px();
        let pixel = |p: DVec3| self.camera.pixel_from_clip(DVec2::new(p.x, p.y) / (p.z * self.camera.tan_half_fov));
        let ends = runs.iter().filter_map(|run| Some([run.first()?, run.last()?])).flatten();
        let distance_to_edge_px = |px: DVec2| match line.kind {
            GridLineKind::Parallel => px.x,
            GridLineKind::Meridian => 2.0 * half_size_px.y - px.y,
        };
        let opacity_at = |parameter: f64| match line.kind {
            GridLineKind::Parallel => line.opacity(ANY_LATITUDE_DEG, pixel_deg),
            GridLineKind::Meridian => line.opacity(parameter.to_degrees(), pixel_deg),
        };
        let ends_px = ends.map(|end| (pixel(end.position), end.parameter));
        let best = ends_px.min_by(|(a, _), (b, _)| distance_to_edge_px(*a).total_cmp(&distance_to_edge_px(*b)));
        if let Some((px, _)) = best.filter(|(_, parameter)| opacity_at(*parameter) > MIN_LABELLED_OPACITY) {
            self.output.texts.push(UnplacedText { text, centre_px: px, colour: style.colour, is_grid_coordinate: true });
        }
    }
}

/// The lines of the sky that a request selects. `horizon`: [`horizon_axes`] of a viewer on the ground; `None` for any other viewer.
pub(crate) fn sky_lines(request: &ViewRequest, viewer: &Viewer, horizon: Option<DMat3>) -> AnnotationLines {
    let layers = request.layers;
    let camera = &viewer.camera;
    let mut builder = SkyLineBuilder { camera, velocity_km_s: viewer.sky_aberration_velocity_km_s, output: AnnotationLines::default() };
    let language = request.language;
    let hours = |longitude_deg| language.number(&hours_text(longitude_deg));
    for (is_requested, effect, frame, style, text) in [
        (layers.grid_galactic, "grid-galactic", SkyFrame::Galactic, GALACTIC, &angle_text as &dyn Fn(f64) -> String),
        (layers.grid_ecliptic, "grid-ecliptic", SkyFrame::Ecliptic, ECLIPTIC, &angle_text as &dyn Fn(f64) -> String),
        (layers.grid_equatorial, "grid-equatorial", SkyFrame::Equatorial, EQUATORIAL, &hours),
    ] {
        if is_requested {
            builder.grid(effect, frame.icrf_from_frame(), viewer.sky_aberration_velocity_km_s, style, text);
        }
    }
    if layers.grid_equatorial_date {
        let icrf_from_date = true_of_date_from_gcrs(request.time).transpose();
        builder.grid("grid-equatorial-date", icrf_from_date, viewer.sky_aberration_velocity_km_s, EQUATORIAL_OF_DATE, hours);
    }
    if layers.grid_horizon {
        match horizon {
            Some(axes) => builder.grid("grid-horizon", axes, DVec3::ZERO, HORIZON, |azimuth| azimuth_text(azimuth, language)),
            None => builder.record_decision("grid-horizon", false, reason!("lines-no-ground")),
        }
    }
    if layers.boundaries {
        boundaries(&mut builder);
    }
    if layers.constellations {
        constellations(&mut builder, request, viewer);
    }
    builder.output
}

/// Axes of the local horizon as columns in ICRF: north, east, zenith. In this frame longitude is the azimuth, from north through east, and latitude is
/// the altitude. `zenith`, `pole`: unit vectors of the zenith and of the body's north pole, ICRF. At a pole of the body east is arbitrary.
pub(crate) fn horizon_axes(zenith: DVec3, pole: DVec3) -> DMat3 {
    let east = pole.cross(zenith).try_normalize().unwrap_or_else(|| zenith.any_orthonormal_vector());
    DMat3::from_cols(zenith.cross(east), east, zenith)
}

/// Draws the boundaries of the constellations. Each border runs along a parallel or a meridian of the equinox B1875.
fn boundaries(builder: &mut SkyLineBuilder<'_>) {
    let icrf_from_b1875 = icrf_from_b1875();
    let count_before = builder.output.segments.len();
    let velocity = builder.velocity_km_s;
    for border in &Constellations::embedded().borders {
        // Right ascension (x) and declination (y), radians.
        let [from, to] = border.ends.map(DVec2::from_array);
        let max_cosine = from.y.cos().max(to.y.cos());
        // The border's length in radians, above 0 because it divides.
        let length = ((to.x - from.x) * max_cosine).hypot(to.y - from.y).max(1e-9);
        let point = |t: f64| {
            let ra_dec = from.lerp(to, t / length);
            aberrated(icrf_from_b1875 * unit_vector(ra_dec.x.to_degrees(), ra_dec.y.to_degrees()), velocity)
        };
        let opacity_factor = |_: f64| 1.0;
        // Along a parallel, right ascension changes by 1 / cosine per radian of arc, and the derivatives are at most this large.
        builder.arc(&point, [0.0, length], DERIVATIVE_BOUND / max_cosine.max(1e-3), opacity_factor, BOUNDARY);
    }
    let count = builder.output.segments.len() - count_before;
    builder.record_decision("boundaries", count > 0, if count > 0 { reason!("lines-borders") } else { reason!("lines-no-border") });
}

/// Draws the figures and names of the constellations.
fn constellations(builder: &mut SkyLineBuilder<'_>, request: &ViewRequest, viewer: &Viewer) {
    let stars = StarCatalog::embedded();
    let placer = StarPlacer::of_stars(&stars, viewer, request);
    let apparent = |vertex: &FigureVertex| match vertex.star {
        Some(index) => placer.place(&stars.stars()[index]).direction,
        None => aberrated(vertex.direction, viewer.sky_aberration_velocity_km_s),
    };
    let camera = builder.camera;
    let mut abbreviations = Vec::new();
    for constellation in &Constellations::embedded().all {
        let count_before = builder.output.segments.len();
        for line in &constellation.figure {
            let directions: Vec<DVec3> = line.iter().map(apparent).collect();
            for ends in directions.windows(2) {
                builder.great_circle(ends[0], ends[1], FIGURE);
            }
        }
        if builder.output.segments.len() > count_before {
            abbreviations.push(constellation.abbreviation.clone());
        }
    }
    if 2.0 * camera.tan_half_fov.y.atan().to_degrees() > NAMES_MIN_FOV_DEG {
        builder.output.texts.extend(constellation_names(camera));
    }
    let on = !abbreviations.is_empty();
    let reason = if on { reason!("lines-figures", names = abbreviations) } else { reason!("lines-no-figure") };
    builder.record_decision("constellations", on, reason);
}

/// The names of the constellations whose label positions are in an image.
pub(crate) fn constellation_names(image: &dyn ImageProjection) -> Vec<UnplacedText> {
    let size = image.size_px();
    let name = |constellation: &Constellation| {
        let centre_px = image.pixel_of(constellation.label_direction)?;
        let is_inside = centre_px.cmpgt(DVec2::ZERO).all() && centre_px.cmplt(size).all();
        let text = || UnplacedText { text: constellation.name.clone(), centre_px, colour: FIGURE.colour, is_grid_coordinate: false };
        is_inside.then(text)
    };
    Constellations::embedded().all.iter().filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::angle_rad;

    /// At its perihelion Mercury moves at 59 km/s, so aberration moves a place by up to 41 arcsec: in a narrow view, from far outside the frame into its
    /// corner.
    #[test]
    fn the_grid_reaches_the_corners_of_a_narrow_view_in_spite_of_aberration() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 0.02, 400, 400);
        let velocity_km_s = 59.0 * (camera.right + camera.up).normalize();
        let corner = camera.ray(DVec2::NEG_ONE).normalize();
        // Aberration by the opposite velocity restores the place to second order.
        let place_deg = angle_rad(camera.forward, aberrated(corner, -velocity_km_s)).to_degrees();
        assert!(place_deg < cap_radius_deg(&camera, velocity_km_s), "{place_deg}");
        // Negative control: the frame's half diagonal and a hundredth of a degree do not suffice.
        assert!(place_deg > cap_radius_deg(&camera, DVec3::ZERO), "{place_deg}");
    }
}
