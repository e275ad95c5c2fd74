//! Shadows of what stands before the Sun of the target: their outlines and paths on its ground, and their cones in space.
//!
//! In: the target as it is seen, and who is between it and the Sun. Out: pieces of lines and decisions. Always: the geometry is that of the drawn shadow
//! (`eclipse::shadow_cone`); what the Sun does not see of the ground has no line. Cones are drawn among the bodies, which hide what is behind or inside of them. Left out: relief and
//! shape models.

use crate::scene::annotation::body_lines::Sheet;
use crate::scene::annotation::strokes::{Curve, LineSegment, segments};
use crate::scene::camera::{Camera, NEAR_DEPTH_KM};
use crate::scene::decision::Decision;
use crate::scene::eclipse::before_sun;
use crate::scene::eclipse::occluders::{Axis, Receiver};
use crate::scene::eclipse::shadow_cone::{Edge, ShadowCone};
use crate::scene::placed::PlacedBody;
use crate::scene::resources::Context;
use glam::DVec3;
use std::f64::consts::TAU;

const UMBRA: DVec3 = DVec3::new(1.0, 0.2, 0.1);
const PENUMBRA: DVec3 = DVec3::new(1.0, 0.75, 0.2);
const PATH: DVec3 = DVec3::new(0.3, 0.9, 1.0);
/// Of lines on the ground.
const OUTLINE_OPACITY: f64 = 0.95;
const PENUMBRA_OPACITY: f64 = 0.9;
const LIMIT_OPACITY: f64 = 0.75;
/// Of cones: many lines lie over each other.
const CONE_OPACITY: f64 = 0.4;
/// Sides that a cone is drawn with, and rings between its ends.
const CONE_SIDES: u32 = 8;
const CONE_RINGS: u32 = 3;

/// Outlines now, and the paths of the passages that are near.
pub(super) fn on_ground(sheet: &mut Sheet<'_, '_>, context: Context<'_>) {
    const FEATURE: &str = "eclipse-path";
    let Some((receiver, sun, candidates)) = before_sun::receiver(context, sheet.p) else {
        return sheet.decide(FEATURE, false, "it has no Sun".into());
    };
    let mut said = Vec::new();
    for occluder in candidates {
        let Some(axis) = Axis::of(receiver, sun) else { continue };
        let cone = ShadowCone::of(axis, occluder, receiver);
        let name = &occluder.body.name;
        if let Some(path) = context.caches.shadow_paths.of(context.ephemeris, sun, receiver, occluder) {
            let limits = path.limits.iter().map(|line| (line, LIMIT_OPACITY));
            for (line, opacity) in path.centre_line.iter().map(|line| (line, OUTLINE_OPACITY)).chain(limits) {
                sheet.through(line, opacity, PATH);
            }
            if path.centre_line.is_some() || !path.limits.is_empty() {
                said.push(format!("path of {name}'s shadow, in its middle at {}", path.middle.to_utc_iso()));
            }
        }
        for (edge, colour, opacity, what) in
            [(Edge::Penumbra, PENUMBRA, PENUMBRA_OPACITY, "penumbra"), (Edge::Umbra, UMBRA, OUTLINE_OPACITY, "umbra")]
        {
            let lines = cone.outline(edge);
            lines.iter().for_each(|line| sheet.through(line, opacity, colour));
            if !lines.is_empty() {
                let behind_apex = edge == Edge::Umbra && cone.is_antumbra();
                said.push(format!("{name}'s {}", if behind_apex { "antumbra" } else { what }));
            }
        }
    }
    let on = !said.is_empty();
    let reason = if on { said.join("; ") } else { "no shadow on its ground within six hours".into() };
    sheet.decide(FEATURE, on, reason);
}

/// What draws the cones of one body.
struct Cones<'a, 'b> {
    camera: &'a Camera,
    p: &'a PlacedBody<'b>,
    pieces: Vec<LineSegment>,
}

impl Cones<'_, '_> {
    /// Draws a line through space: body axes, equatorial radii; `length`: bound of its derivatives.
    fn line(&mut self, point: &dyn Fn(f64) -> DVec3, parts: u32, length: f64, colour: DVec3) {
        let placement = &self.p.placement;
        let radius_km = placement.radii_km.x;
        let in_icrf = |t: f64| placement.centre_km + placement.body_from_icrf.transpose() * (point(t) * radius_km);
        let curve = Curve { camera: self.camera, point: &in_icrf, size: length * radius_km, finer: 1.0 };
        let parameters: Vec<f64> = (0..=parts).map(|k| f64::from(k) / f64::from(parts)).collect();
        for run in curve.runs(&parameters, 0) {
            let depth = |p: DVec3| (NEAR_DEPTH_KM / p.z).min(1.0);
            self.pieces.extend(segments(self.camera, &run, depth, |_| CONE_OPACITY, colour));
        }
    }

    /// Draws a cone from the body that casts it, each side as long as it says.
    fn cone(&mut self, cone: &ShadowCone, edge: Edge, length: &dyn Fn(f64) -> f64, colour: DVec3) {
        let at = |turns: f64, part: f64| {
            let angle = TAU * turns;
            let side = cone.side(edge, angle);
            side.from + side.along * (part * length(angle))
        };
        for k in 0..CONE_SIDES {
            let turns = f64::from(k) / f64::from(CONE_SIDES);
            self.line(&|t| at(turns, t), 1, length(TAU * turns), colour);
        }
        for k in 0..=CONE_RINGS {
            let part = f64::from(k) / f64::from(CONE_RINGS + 1);
            // A ring is as long as its bounds say: from the farthest of its points to its middle.
            let middle = 0.5 * (at(0.0, part) + at(0.5, part));
            let reach = (0..8).map(|k| at(f64::from(k) / 8.0, part).distance(middle)).fold(0.0, f64::max);
            self.line(&|t| at(t, part), 8, 1.2 * TAU * TAU * reach, colour);
        }
    }
}

/// Cones of shadow in space: of each body whose penumbra meets the target, to the target, and the target's own.
pub(crate) fn in_space(context: Context<'_>, camera: &Camera, p: &PlacedBody<'_>) -> (Vec<LineSegment>, Decision) {
    let decided = |on, reason| Decision { feature: "eclipse-cones", on, reason, tier: None };
    let lit = before_sun::receiver(context, p).and_then(|(receiver, sun, all)| Some((receiver, Axis::of(receiver, sun)?, all)));
    let Some((receiver, axis, candidates)) = lit else { return (Vec::new(), decided(false, "it has no Sun".into())) };
    let mut cones = Cones { camera, p, pieces: Vec::new() };
    let mut casters = vec![receiver.body.name.as_str()];
    own(&mut cones, axis, receiver);
    for occluder in candidates {
        let cone = ShadowCone::of(axis, occluder, receiver);
        if occluder.across.length() > 1.0 + cone.radius(Edge::Penumbra) {
            continue;
        }
        casters.push(&occluder.body.name);
        for (edge, colour) in [(Edge::Penumbra, PENUMBRA), (Edge::Umbra, UMBRA)] {
            let to_middle = occluder.along;
            let length = |angle: f64| {
                let side = cone.side(edge, angle);
                cone.meets(side).map_or(to_middle, |at| (at * p.body.radii_km / receiver.radius_km()).distance(side.from))
            };
            cones.cone(&cone, edge, &length, colour);
        }
    }
    let on = !cones.pieces.is_empty();
    let reason = format!("shadows of {}{}", casters.join(", "), if on { "" } else { ": outside of the frame" });
    (cones.pieces, decided(on, reason))
}

/// The shadow behind the target, to the apex of its umbra.
fn own(cones: &mut Cones<'_, '_>, axis: Axis, receiver: &Receiver<'_>) {
    let cone = ShadowCone::behind(axis, receiver);
    let length = cone.umbra_length();
    if length.is_finite() {
        cones.cone(&cone, Edge::Penumbra, &|_| length, PENUMBRA);
        cones.cone(&cone, Edge::Umbra, &|_| length, UMBRA);
    }
}
