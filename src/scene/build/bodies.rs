//! The bodies of a frame: the draws, points and lines that result from the decisions about them, and the report of each body.
//!
//! In: the placed bodies of a [`SceneBuilder`]. Out: [`BodiesInFrame`]: draws in catalog order, points, orbits, traces, and one report per body of the catalog.
//! Not here: light around the Sun (`sunlight`), and the order of the draws (`visibility`).

use super::SceneBuilder;
use crate::catalog::{Body, NaifId};
use crate::message::{Reason, reason};
use crate::scene::annotation::orbit_arcs::OrbitArc;
use crate::scene::annotation::orbits;
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::traces;
use crate::scene::camera::{Camera, Placement};
use crate::scene::decision::{Decision, invented_text};
use crate::scene::draw::features::{Detail, PixelView, Shape};
use crate::scene::draw::{Draw, Point};
use crate::scene::features::inputs::FrameContext;
use crate::scene::features::{self, DecidedBody};
use crate::scene::in_view::{Appearance, BodyInView, SubPoint};
use crate::scene::light::magnitude;
use crate::scene::placed::PlacedBody;
use crate::scene::point;
use crate::scene::resources::Context;
use crate::scene::surface::detail;
use crate::scene::visibility::{hidden, lunar_limb};
use glam::{DMat3, DVec3};

/// The contribution of the bodies of a frame to its scene.
pub(super) struct BodiesInFrame {
    /// One report per body of the catalog, in its order.
    pub reports: Vec<BodyInView>,
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
        let is_target = |p: &&PlacedBody<'_>| request.target == Some(p.body.id) && !builder.is_inside(p.body);
        let target_distance_km = placed.iter().find(is_target).map(|p| p.distance_km);
        let trace_centre = request.target.unwrap_or(NaifId::SUN);
        let (mut draws, mut points, mut orbit_arcs, mut trace_segments) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut placed_reports = placed.iter().map(|p| {
            let own_request = builder.own_request(p.body);
            let own_context = Context { request: own_request.as_ref().unwrap_or(request), ..frame.context };
            let mut decided = features::decide(&FrameContext { context: own_context, ..*frame }, p, builder.is_inside(p.body));
            let (own_draws, point) = (std::mem::take(&mut decided.draws), decided.point.take());
            let mut report = report(p, decided, &own_draws, magnitude::magnitude(frame.context, p, placed));
            let orbit = (request.layers.orbits && is_final).then(|| orbits::line(frame.camera, builder.ephemeris, p, target_distance_km));
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
            points.extend(point);
            report
        });
        let reports = builder.unplaced.iter().filter_map(|unplaced| unplaced.clone().or_else(|| placed_reports.next())).collect();
        drop(placed_reports);
        Self { reports, draws, points, orbits: orbit_arcs, traces: trace_segments }
    }

    /// Applies the lunar limb profile to the Moon, removes draws and points that other bodies hide, and widens the sprites of bright points. `white`:
    /// radiance shown as white.
    pub(super) fn apply_visibility(&mut self, placed: &[PlacedBody<'_>], camera: &Camera, white: f64) {
        lunar_limb::apply_to_moon(placed, camera, &mut self.draws, &mut self.reports);
        hidden::apply(placed, camera, &mut self.draws, &mut self.points, &mut self.reports);
        lunar_limb::update_features(&self.draws, &mut self.reports);
        self.points.iter_mut().for_each(|p| point::set_sprite_radius(p, white));
    }
}

/// The report of a placed body.
fn report(placed: &PlacedBody<'_>, decided: DecidedBody, draws: &[Draw], magnitude: Option<f64>) -> BodyInView {
    let to_viewer = placed.placement.body_from_icrf * -placed.placement.centre_km;
    BodyInView {
        id: placed.body.id,
        name: placed.body.name.clone(),
        appearance: decided.appearance,
        distance_km: placed.distance_km,
        angular_diameter_deg: 2.0 * (placed.body.radii_km.max_element() / placed.distance_km).min(1.0).asin().to_degrees(),
        diameter_px: decided.diameter_px,
        phase_angle_deg: placed.phase_angle.to_degrees(),
        magnitude,
        sub_observer: SubPoint::of(to_viewer),
        sub_solar: (placed.body.id != NaifId::SUN).then(|| SubPoint::of(placed.body_from_icrf * placed.sun_from_body_km)),
        placement: placed.placement,
        features: draws.iter().map(|d| d.features).collect(),
        invented: invented(placed.body, draws),
        decisions: decided.decisions,
    }
}

/// The report of a body that the ephemeris could not place.
pub(super) fn not_placed(body: &Body, reason: Reason) -> BodyInView {
    BodyInView {
        id: body.id,
        name: body.name.clone(),
        appearance: Appearance::NotShown,
        distance_km: f64::NAN,
        angular_diameter_deg: f64::NAN,
        diameter_px: 0.0,
        phase_angle_deg: f64::NAN,
        magnitude: None,
        sub_observer: SubPoint { latitude_deg: f64::NAN, longitude_deg: f64::NAN },
        sub_solar: None,
        placement: Placement { centre_km: DVec3::NAN, body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km },
        decisions: vec![Decision { effect: "visible", on: false, reason, stated_error: None }],
        features: Vec::new(),
        invented: Vec::new(),
    }
}

/// The maps, shape and detail shown in a body's draws that are invented, not measured: each with its file and the method of its invention.
fn invented(body: &Body, draws: &[Draw]) -> Vec<(String, Reason)> {
    let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
    let maps = maps.chain(body.clouds.as_ref().map(|c| &c.map)).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    let is_shown = |file: &String| draws.iter().any(|d| d.map_files.by_role().any(|(_, f)| f == file));
    let has_mesh = draws.iter().any(|d| d.features.shape == Shape::Mesh);
    let details = draws.iter().map(|d| d.features.detail).filter(|d| *d != Detail::None);
    let details = details.map(|d| ("detail".to_owned(), detail::description(d)));
    let shape = body.mesh.iter().filter(|_| has_mesh).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    maps.filter(|(file, _)| is_shown(file))
        .chain(shape)
        .map(|(file, how)| (file.clone(), reason!("quoted", text = invented_text(how))))
        .chain(details)
        .collect()
}
