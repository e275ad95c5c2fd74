//! Eclipse lines: outlines and paths of shadows on the ground of a body, and the target's shadow cones in space.
//!
//! In: a placed body and the bodies between it and the Sun. Out: line segments and decisions. Always: the geometry is that of the drawn shadow
//! (`eclipse::shadow_cone`); outlines are on the day side, and so is each point of a path at the time when the shadow passes it. Cones
//! are depth-tested against the bodies. Ignores relief and shape models.

use crate::message::{Argument, reason};
use crate::scene::annotation::body_lines::GroundLineBuilder;
use crate::scene::annotation::strokes::{Curve, LineSegment, reversed_depth, segments};
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::eclipse::occluders::{Axis, Receiver};
use crate::scene::eclipse::shadow_cone::{ConeKind, ShadowCone};
use crate::scene::eclipse::sun_occluders;
use crate::scene::placed::PlacedBody;
use crate::scene::resources::Context;
use glam::DVec3;
use std::f64::consts::TAU;

// Colours: linear RGB.
const UMBRA_COLOUR: DVec3 = DVec3::new(1.0, 0.2, 0.1);
const PENUMBRA_COLOUR: DVec3 = DVec3::new(1.0, 0.75, 0.2);
const PATH_COLOUR: DVec3 = DVec3::new(0.3, 0.9, 1.0);
// Opacities of lines on the ground.
const UMBRA_OPACITY: f64 = 0.95;
const CENTRE_LINE_OPACITY: f64 = 0.95;
const PENUMBRA_OPACITY: f64 = 0.9;
/// Opacity of the northern and southern limits of a path.
const LIMIT_OPACITY: f64 = 0.75;
/// Opacity of cones, whose many lines overlap.
const CONE_OPACITY: f64 = 0.4;
/// Number of generators with which a cone is drawn.
const CONE_GENERATORS: u32 = 8;
/// Number of cross sections with which a cone is drawn.
const CONE_SECTIONS: u32 = 4;

/// The current shadow outlines, and the paths of shadows that cross the ground close to the current time.
pub(super) fn on_ground(builder: &mut GroundLineBuilder<'_, '_>, context: Context<'_>) {
    const EFFECT: &str = "eclipse-path";
    let Some((receiver, sun, candidates)) = sun_occluders::receiver_and_candidates(context, builder.placed) else {
        return builder.record_decision(EFFECT, false, reason!("lines-no-sun"));
    };
    let mut descriptions = Vec::new();
    for occluder in candidates {
        let Some(axis) = Axis::of(receiver, sun) else { continue };
        let cone = ShadowCone::of(axis, occluder, receiver);
        let name = &occluder.body.name;
        if let Some(path) = context.caches.shadow_paths.of(context.ephemeris, sun, receiver, occluder) {
            let limits = path.limits.iter().map(|line| (line, LIMIT_OPACITY));
            for (line, opacity) in path.centre_line.iter().map(|line| (line, CENTRE_LINE_OPACITY)).chain(limits) {
                builder.draw_line(line, opacity, PATH_COLOUR);
            }
            if path.centre_line.is_some() || !path.limits.is_empty() {
                let middle = Argument::Time(path.middle.to_utc_iso());
                descriptions.push(reason!("lines-shadow-path", body = name, time = middle));
            }
        }
        for (kind, colour, opacity) in
            [(ConeKind::Penumbra, PENUMBRA_COLOUR, PENUMBRA_OPACITY), (ConeKind::Umbra, UMBRA_COLOUR, UMBRA_OPACITY)]
        {
            let lines = cone.edge_on_ground(kind);
            for line in &lines {
                builder.draw_line(line, opacity, colour);
            }
            if !lines.is_empty() {
                descriptions.push(match kind {
                    ConeKind::Penumbra => reason!("lines-penumbra", body = name),
                    ConeKind::Umbra if cone.is_antumbra() => reason!("lines-antumbra", body = name),
                    ConeKind::Umbra => reason!("lines-umbra", body = name),
                });
            }
        }
    }
    let on = !descriptions.is_empty();
    let reason = if on { descriptions.into_iter().collect() } else { reason!("lines-no-shadow") };
    builder.record_decision(EFFECT, on, reason);
}

/// Collects the lines of the shadow cones at one body.
struct ConeBuilder<'a, 'b> {
    camera: &'a Camera,
    placed: &'a PlacedBody<'b>,
    segments: Vec<LineSegment>,
}

impl ConeBuilder<'_, '_> {
    /// Draws a curve in space. `point`: position relative to the target's centre, body axes, equatorial radii, at a parameter from 0 to 1; `spans`: number of
    /// parts that are subdivided separately; `derivative_bound`: upper bound of the lengths of the first and second derivative, equatorial radii.
    fn draw_line(&mut self, point: &dyn Fn(f64) -> DVec3, spans: u32, derivative_bound: f64, colour: DVec3) {
        let placement = &self.placed.placement;
        let radius_km = placement.radii_km.x;
        let in_icrf = |t: f64| placement.centre_km + placement.body_from_icrf.transpose() * (point(t) * radius_km);
        let curve = Curve { camera: self.camera, point: &in_icrf, derivative_bound: derivative_bound * radius_km, tolerance_factor: 1.0 };
        let parameters: Vec<f64> = (0..=spans).map(|k| f64::from(k) / f64::from(spans)).collect();
        for run in curve.runs(&parameters) {
            self.segments.extend(segments(self.camera, &run, reversed_depth, |_| CONE_OPACITY, colour));
        }
    }

    /// Draws a cone from the body that casts the shadow. `length`: length of a generator, in equatorial radii of the target, at its angle (radians) as in
    /// [`ShadowCone::generator_at`].
    fn draw_cone(&mut self, cone: &ShadowCone, kind: ConeKind, length: &dyn Fn(f64) -> f64, colour: DVec3) {
        let point_at = |turns: f64, fraction: f64| {
            let angle = TAU * turns;
            let line = cone.generator_at(kind, angle);
            line.origin + line.direction * (fraction * length(angle))
        };
        for k in 0..CONE_GENERATORS {
            let turns = f64::from(k) / f64::from(CONE_GENERATORS);
            let spans = 1;
            self.draw_line(&|t| point_at(turns, t), spans, length(TAU * turns), colour);
        }
        for k in 0..CONE_SECTIONS {
            let fraction = f64::from(k) / f64::from(CONE_SECTIONS);
            // A section is nearly a circle, and its parameter is in turns: the second derivative, the larger one, is about (2 pi)^2 times the radius.
            // The factor 1.2 allows for the deviation from a circle.
            let middle = 0.5 * (point_at(0.0, fraction) + point_at(0.5, fraction));
            let radius = (0..8).map(|eighth| point_at(f64::from(eighth) / 8.0, fraction).distance(middle)).fold(0.0, f64::max);
            let spans = 8;
            self.draw_line(&|t| point_at(t, fraction), spans, 1.2 * TAU * TAU * radius, colour);
        }
    }
}

/// Shadow cones in space: the cone of each body whose penumbra meets the target, drawn up to the target, and the target's own cone.
pub(crate) fn in_space(context: Context<'_>, camera: &Camera, placed: &PlacedBody<'_>) -> (Vec<LineSegment>, Decision) {
    let decided = |on, reason| Decision { effect: "eclipse-cones", on, reason, stated_error: None };
    let shadow_setup = sun_occluders::receiver_and_candidates(context, placed)
        .and_then(|(receiver, sun, candidates)| Some((receiver, Axis::of(receiver, sun)?, candidates)));
    let Some((receiver, axis, candidates)) = shadow_setup else { return (Vec::new(), decided(false, reason!("lines-no-sun"))) };
    let mut cones = ConeBuilder { camera, placed, segments: Vec::new() };
    let mut body_names = vec![receiver.body.name.clone()];
    target_shadow(&mut cones, axis, receiver);
    for occluder in candidates {
        let cone = ShadowCone::of(axis, occluder, receiver);
        // The penumbra misses the target, whose equatorial radius is 1.
        if occluder.offset_across.length() > 1.0 + cone.radius(ConeKind::Penumbra) {
            continue;
        }
        body_names.push(occluder.body.name.clone());
        for (kind, colour) in [(ConeKind::Penumbra, PENUMBRA_COLOUR), (ConeKind::Umbra, UMBRA_COLOUR)] {
            let to_target_centre = occluder.distance_along;
            let length = |angle: f64| {
                let line = cone.generator_at(kind, angle);
                // The ground point is converted from the unit sphere to equatorial radii.
                cone.ground_point(line)
                    .map_or(to_target_centre, |ground| (ground * placed.body.radii_km / receiver.radius_km()).distance(line.origin))
            };
            cones.draw_cone(&cone, kind, &length, colour);
        }
    }
    let on = !cones.segments.is_empty();
    let reason = if on { reason!("lines-cones", bodies = body_names) } else { reason!("lines-cones-outside", bodies = body_names) };
    (cones.segments, decided(on, reason))
}

/// The target's own shadow, to the apex of its umbra; nothing if the umbra has no apex.
fn target_shadow(cones: &mut ConeBuilder<'_, '_>, axis: Axis, receiver: &Receiver<'_>) {
    let cone = ShadowCone::own_shadow(axis, receiver);
    let length = cone.umbra_length();
    if length.is_finite() {
        cones.draw_cone(&cone, ConeKind::Penumbra, &|_| length, PENUMBRA_COLOUR);
        cones.draw_cone(&cone, ConeKind::Umbra, &|_| length, UMBRA_COLOUR);
    }
}
