//! The bodies of a frame: the draws, points and lines that result from the decisions about them, and the report of each body.
//!
//! In: the placed bodies of a [`SceneBuilder`]. Out: [`BodiesInFrame`]: draws in catalog order, points, orbits, traces, and one report per body of the catalog.
//! Not here: light around the Sun (`light_around_sun`), and the order of the draws (`visibility::order`).

use super::SceneBuilder;
use crate::catalog::{Body, NaifId};
use crate::ephemeris::angle_rad;
use crate::message::{Reason, reason};
use crate::scene::annotation::orbit_arcs::OrbitArc;
use crate::scene::annotation::orbits;
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::traces;
use crate::scene::body_report::{Appearance, BodyReport, InventedData, SubPoint};
use crate::scene::camera::{Placement, narrow_scalar};
use crate::scene::decision::{Decision, invented_text};
use crate::scene::draw::features::{Detail, PixelView, Shape};
use crate::scene::draw::{Draw, Point};
use crate::scene::features::inputs::{FrameContext, diameter_px};
use crate::scene::features::{self, DecidedBody};
use crate::scene::light::{glare, magnitude};
use crate::scene::placed::PlacedBody;
use crate::scene::point;
use crate::scene::resources::{Context, Resources};
use crate::scene::surface::detail;
use crate::scene::visibility::{hidden, lunar_limb, points};
use glam::{DMat3, DVec3, Vec3};

/// The contribution of the bodies of a frame to its scene.
pub(super) struct BodiesInFrame {
    /// One report per body of the catalog, in its order.
    pub reports: Vec<BodyReport>,
    pub draws: Vec<Draw>,
    pub points: Vec<Point>,
    pub orbits: Vec<OrbitArc>,
    pub traces: Vec<LineSegment>,
}

impl BodiesInFrame {
    /// Decides on every effect of every placed body, and on its orbit and trace.
    pub(super) fn decide(builder: &SceneBuilder<'_>, frame: &FrameContext<'_>) -> Self {
        let (request, placed) = (builder.request, &builder.placed);
        let is_final = request.pixel_view == PixelView::Final;
        let is_target = |p: &&PlacedBody<'_>| request.target == Some(p.body.id) && !builder.camera_is_at_centre_of(p.body);
        let target_distance_km = placed.iter().find(is_target).map(|p| p.distance_km);
        let trace_centre = request.target.unwrap_or(NaifId::SUN);
        let (mut draws, mut points, mut orbit_arcs, mut trace_segments) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut placed_reports = placed.iter().map(|p| {
            // The request with the effects that the user set for this one body.
            let own_request = request.for_body(p.body);
            let own_context = Context { request: own_request.as_ref().unwrap_or(request), ..frame.context };
            let mut decided = features::decide(&FrameContext { context: own_context, ..*frame }, p, builder.camera_is_at_centre_of(p.body));
            let (own_draws, own_points) = (std::mem::take(&mut decided.draws), [decided.point.take(), decided.disc_glare.take()]);
            let mut report = report(p, decided, &own_draws, magnitude::magnitude(frame.context, p, placed));
            let orbit =
                (request.layers.orbits && is_final).then(|| orbits::orbit_line(frame.camera, builder.ephemeris, p, target_distance_km));
            if let Some((arcs, decision)) = orbit.flatten() {
                orbit_arcs.extend(arcs);
                report.decisions.push(decision);
            }
            let trace = (request.layers.traces && is_final).then(|| traces::trace(frame.camera, builder.ephemeris, p, trace_centre));
            if let Some((segments, decision)) = trace.flatten() {
                trace_segments.extend(segments);
                report.decisions.push(decision);
            }
            draws.extend(own_draws);
            points.extend(own_points.into_iter().flatten());
            report
        });
        // `unplaced_reports` has an entry for each body of the catalog; it is `None` for a placed body.
        let reports = builder.unplaced_reports.iter().filter_map(|unplaced| unplaced.clone().or_else(|| placed_reports.next())).collect();
        drop(placed_reports);
        Self { reports, draws, points, orbits: orbit_arcs, traces: trace_segments }
    }

    /// Applies the lunar limb profile to the Moon, removes draws and points that other bodies hide, widens the sprites of bright points, and dims that of a
    /// Sun beside the image. `white`: radiance shown as white. `corona_flux`: see [`points::apply`].
    pub(super) fn apply_visibility(&mut self, frame: &FrameContext<'_>, placed: &[PlacedBody<'_>], white: f64, corona_flux: Vec3) {
        let camera = frame.camera;
        lunar_limb::apply_to_moon(placed, camera, &mut self.draws, &mut self.reports);
        points::apply(frame, placed, &self.draws, corona_flux, &mut self.points, &mut self.reports);
        hidden::apply(placed, camera, &mut self.draws, &mut self.reports);
        lunar_limb::update_features(&self.draws, &mut self.reports);
        let sun = placed.iter().find(|p| p.body.id == NaifId::SUN);
        for p in self.points.iter_mut().filter(|p| !p.is_disc_glare()) {
            point::set_sprite_radius(p, white);
            // The sprite of a Sun beside the image fades as the veil does (`light::glare`). It keeps its radius: a sprite that shrank would end beside the edge.
            if let Some(sun) = sun.filter(|s| s.body.id == p.body) {
                p.flux *= narrow_scalar(glare::entered_fraction(camera, sun));
            }
        }
        let has_effect = |p: &Point| p.flux != Vec3::ZERO || p.covered_px > 0.0;
        self.points.retain(|p| has_effect(p) && point::reaches_frame(camera, p.centre.truncate().as_dvec2(), p.radius_px.into()));
    }
}

impl SceneBuilder<'_> {
    /// One report per body of the catalog, in its order, with the values that the viewer sees, but without decisions and draws.
    pub(crate) fn values_of_bodies(&self, resources: &Resources) -> Vec<BodyReport> {
        let mut of_placed = self.placed.iter().map(|p| self.values_of(p, resources));
        self.unplaced_reports.iter().filter_map(|unplaced| unplaced.clone().or_else(|| of_placed.next())).collect()
    }

    /// The report of one body as [`Self::values_of_bodies`] has it, and the part of its light that comes from the globe ([`Irradiance::globe_fraction`]);
    /// `None` for a body that is not placed.
    ///
    /// [`Irradiance::globe_fraction`]: crate::scene::light::brightness::Irradiance::globe_fraction
    pub(crate) fn values_of_body(&self, id: NaifId, resources: &Resources) -> Option<(BodyReport, f64)> {
        let p = self.placed.iter().find(|p| p.body.id == id)?;
        Some((self.values_of(p, resources), p.irradiance.globe_fraction()))
    }

    /// The report of a placed body without decisions and draws.
    fn values_of(&self, p: &PlacedBody<'_>, resources: &Resources) -> BodyReport {
        let undecided = DecidedBody {
            appearance: Appearance::NotShown,
            diameter_px: diameter_px(&self.viewer.camera, p),
            decisions: Vec::new(),
            draws: Vec::new(),
            point: None,
            disc_glare: None,
        };
        report(p, undecided, &[], magnitude::magnitude(self.context(resources), p, &self.placed))
    }
}

/// The report of a placed body.
fn report(placed: &PlacedBody<'_>, decided: DecidedBody, draws: &[Draw], magnitude: Option<f64>) -> BodyReport {
    let to_viewer = placed.placement.body_from_icrf * -placed.placement.centre_km;
    let to_sun = (placed.body.id != NaifId::SUN).then(|| placed.body_from_icrf * placed.body_to_sun_km);
    BodyReport {
        id: placed.body.id,
        name: placed.body.name.clone(),
        appearance: decided.appearance,
        distance_km: placed.distance_km,
        angular_diameter_deg: 2.0 * placed.angular_radius_rad().to_degrees(),
        diameter_px: decided.diameter_px,
        phase_angle_deg: placed.phase_angle_rad.to_degrees(),
        magnitude,
        sub_observer: SubPoint::of(to_viewer),
        sub_solar: to_sun.map(SubPoint::of),
        sun_altitude_deg: to_sun.and_then(|to_sun| altitude_at_sub_observer_deg(to_viewer, to_sun, placed.body.radii_km)),
        placement: placed.placement,
        features: draws.iter().map(|d| d.features).collect(),
        invented: invented(placed.body, draws),
        decisions: decided.decisions,
    }
}

/// Altitude of a target, degrees, at the sub-observer point of an ellipsoid. The horizon there is perpendicular to the ellipsoid's normal, not to the line from
/// the centre to the viewer. `viewer_km`, `target_km`: from the centre, body axes. `None` if the viewer is at the centre.
fn altitude_at_sub_observer_deg(viewer_km: DVec3, target_km: DVec3, radii_km: DVec3) -> Option<f64> {
    let in_unit_sphere = (viewer_km / radii_km).try_normalize()?;
    let up = in_unit_sphere / radii_km;
    let to_target_km = target_km - in_unit_sphere * radii_km;
    Some(90.0 - angle_rad(up, to_target_km).to_degrees())
}

/// The report of a body that the ephemeris could not place.
pub(super) fn not_placed(body: &Body, reason: Reason) -> BodyReport {
    BodyReport {
        id: body.id,
        name: body.name.clone(),
        appearance: Appearance::NotShown,
        distance_km: f64::NAN,
        angular_diameter_deg: f64::NAN,
        diameter_px: 0.0,
        phase_angle_deg: f64::NAN,
        magnitude: None,
        sub_observer: SubPoint { lat_centric_deg: f64::NAN, lon_east_deg: f64::NAN },
        sub_solar: None,
        sun_altitude_deg: None,
        placement: Placement { centre_km: DVec3::NAN, body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km },
        decisions: vec![Decision { effect: "visible", on: false, reason, stated_error: None }],
        features: Vec::new(),
        invented: Vec::new(),
    }
}

/// What a body's draws show that is invented, not measured.
fn invented(body: &Body, draws: &[Draw]) -> Vec<InventedData> {
    let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
    let maps = maps.chain(body.clouds.as_ref().map(|c| &c.map)).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    let is_shown = |file: &String| draws.iter().any(|d| d.map_files.by_role().any(|(_, f)| f == file));
    let has_mesh = draws.iter().any(|d| d.features.shape == Shape::Mesh);
    let details = draws.iter().map(|d| d.features.detail).filter(|d| *d != Detail::None);
    let details = details.map(|d| InventedData { source: "detail".to_owned(), how_made: detail::description(d) });
    let shape = body.mesh.iter().filter(|_| has_mesh).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    maps.filter(|(file, _)| is_shown(file))
        .chain(shape)
        .map(|(file, how)| InventedData { source: file.clone(), how_made: reason!("quoted", text = invented_text(how)) })
        .chain(details)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUN_KM: f64 = 1.4e9;

    #[test]
    fn the_sun_is_at_the_zenith_of_the_sub_solar_point_and_at_the_nadir_of_its_antipode() {
        let sphere = DVec3::splat(3000.0);
        let towards_sun = DVec3::new(2.0, -1.0, 0.5).normalize();
        let (sun, aside) = (SUN_KM * towards_sun, towards_sun.any_orthonormal_vector());
        let altitude = |viewer: DVec3| altitude_at_sub_observer_deg(viewer, sun, sphere).expect("a sub-observer point");
        assert!((altitude(sun) - 90.0).abs() < 1e-6 && (altitude(1e-5 * sun) - 90.0).abs() < 1e-6);
        assert!((altitude(-sun) + 90.0).abs() < 1e-6);
        // At the terminator the centre of the Sun is lower by the angle under which the radius is seen from the Sun.
        let dip_deg = (3000.0 / SUN_KM).to_degrees();
        assert!((altitude(1e6 * aside) + dip_deg).abs() < 1e-9, "{}", altitude(1e6 * aside));
        assert!((altitude(sun + SUN_KM * aside) - 45.0).abs() < 2.0 * dip_deg);
    }

    /// On an oblate body the vertical is not the line from the centre. The reference is the published relation between planetographic and planetocentric
    /// latitude, tan(graphic) = (a / c)² tan(centric).
    #[test]
    fn the_horizon_of_an_oblate_body_is_normal_to_the_ellipsoid() {
        let saturn = DVec3::new(60268.0, 60268.0, 54364.0);
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let towards = DVec3::new(cos, 0.0, sin);
        let altitude = altitude_at_sub_observer_deg(1e6 * towards, 1e15 * towards, saturn).expect("a sub-observer point");
        let lat_graphic_deg = ((60268.0_f64 / 54364.0).powi(2) * sin / cos).atan().to_degrees();
        assert!((altitude - (90.0 - (lat_graphic_deg - 30.0))).abs() < 1e-6, "{altitude} {lat_graphic_deg}");
        // Negative control: with the line from the centre as the vertical the Sun would be overhead.
        assert!(altitude < 86.0, "{altitude}");
    }

    #[test]
    fn a_viewer_at_the_centre_has_no_sub_observer_point() {
        assert_eq!(altitude_at_sub_observer_deg(DVec3::ZERO, SUN_KM * DVec3::X, DVec3::splat(3000.0)), None);
        assert_eq!(altitude_at_sub_observer_deg(DVec3::NAN, SUN_KM * DVec3::X, DVec3::splat(3000.0)), None);
    }
}
