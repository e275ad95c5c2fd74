//! The part of a body's disc that nearer bodies hide.
//!
//! In: placed bodies. Out: the visible fraction of a disc's light, exactly 0 if the entire disc is hidden and exactly 1 if no part of it is; and the limbs of
//! nearer bodies as uniforms of shaders/lib/foreground_limb.wesl. Nearer bodies are ellipsoids, the hidden body is a sphere. A point's flux is multiplied by
//! its visible fraction (`points`); a depth test cannot hide a point partly, because a sprite has a single depth. Not here: transmittance of rings and air,
//! and shadows (eclipse). The light is summed over [`CHORD_COUNT`] chords of the disc, each with a closed-form integral. The error is below 1e-4 of the disc's
//! light: a sum over 6000 chords differs by at most 7e-5, for one round body of 0.01 to 4 radii of the disc (computed outside this program).
//! tests/eclipse/overlapping_limbs.rs compares images with the closed forms of shaders/lib/eclipse.

use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::{Camera, Placement, narrow_scalar, narrow2};
use crate::scene::decision::Decision;
use crate::scene::draw::{BodyPart, Draw, Shape, Surface};
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::placed::PlacedBody;
use crate::scene::visibility::lunar_limb;
use crate::scene::visibility::order::is_in_front;
use glam::{DVec2, DVec3, Vec4};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

/// The limb of a body on a plane of view rays `ray + x dx + y dy`, as a quadratic form F and a linear form L of x and y. With the ray d and the camera's
/// position c, both in the unit-sphere frame: F = |d|^2 - |c x d|^2, L = -c.d, each up to a positive factor. A point of the plane is inside if F > 0 and L > 0.
/// See shaders/lib/foreground_limb.wesl.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limb {
    /// Coefficients of F: 1, x, y, x², xy, y².
    quadratic: [f64; 6],
    /// Coefficients of L: 1, x, y.
    linear: [f64; 3],
}

impl Limb {
    /// The limb on the plane of the view rays `ray + x dx + y dy`, ICRF.
    fn on_plane(placement: &Placement, ray: DVec3, dx: DVec3, dy: DVec3) -> Self {
        let camera = placement.camera_in_unit_sphere();
        let towards_centre = placement.centre_km.normalize();
        // The camera's position is parallel to the direction of the body's centre, so a ray's component along this direction has no part in the cross
        // product. The component is removed first, because it would cause rounding errors.
        let [d0, d1, d2] = [ray, dx, dy].map(|v| placement.direction_in_unit_sphere(v));
        let [n0, n1, n2] =
            [ray, dx, dy].map(|v| camera.cross(placement.direction_in_unit_sphere(v - towards_centre * v.dot(towards_centre))));
        let linear = [-camera.dot(d0), -camera.dot(d1), -camera.dot(d2)];
        // The scale of F and L is arbitrary but must suit f32. Dividing by L at `ray` would fail: L is not positive if `ray` points away from the body, as
        // it may above a horizon.
        let unit = 1.0 / (camera.length() * d0.length());
        Self {
            quadratic: [
                d0.dot(d0) - n0.dot(n0),
                2.0 * (d0.dot(d1) - n0.dot(n1)),
                2.0 * (d0.dot(d2) - n0.dot(n2)),
                d1.dot(d1) - n1.dot(n1),
                2.0 * (d1.dot(d2) - n1.dot(n2)),
                d2.dot(d2) - n2.dot(n2),
            ]
            .map(|v| v * unit * unit),
            linear: linear.map(|v| v * unit),
        }
    }

    /// Whether a point of the plane is inside the limb.
    fn contains(&self, x: f64, y: f64) -> bool {
        let [c, gx, gy, xx, xy, yy] = self.quadratic;
        let quadratic = c + gx * x + gy * y + xx * x * x + xy * x * y + yy * y * y;
        quadratic > 0.0 && self.linear[0] + self.linear[1] * x + self.linear[2] * y > 0.0
    }

    /// Values of x where the limb may cross a line of constant y: the two roots of F, then the root of L.
    fn crossings(&self, y: f64) -> [f64; 3] {
        let [c, gx, gy, xx, xy, yy] = self.quadratic;
        let (a, b, c) = (xx, gx + xy * y, c + gy * y + yy * y * y);
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
        let q = -0.5 * (b + root.copysign(b));
        // Infinite roots are filtered by the caller.
        [q / a, c / q, -(self.linear[0] + self.linear[2] * y) / self.linear[1]]
    }
}

/// Number of chords into which a disc is divided.
const CHORD_COUNT: usize = 720;

/// For each chord, its distance from the middle of the disc and half its length, in radii of the disc. The ends of all chords are evenly spaced along the
/// disc's limb.
static CHORD_SIZES: LazyLock<[(f64, f64); CHORD_COUNT]> =
    LazyLock::new(|| std::array::from_fn(|k| (PI * ((k as f64 + 0.5) / CHORD_COUNT as f64 - 0.5)).sin_cos()));

/// Integral of a limb-darkened disc's radiance along a chord of half length h, from the chord's middle to x; see shaders/lib/ring/body_shadow.wesl.
fn radiance_along_chord(x: f64, h: f64, u1: DVec3, u2: DVec3) -> DVec3 {
    if u1 == DVec3::ZERO && u2 == DVec3::ZERO {
        return DVec3::splat(x);
    }
    let mu = (h * h - x * x).max(0.0).sqrt();
    let of_mu = 0.5 * (x * mu + h * h * (x / h).clamp(-1.0, 1.0).asin());
    let of_mu_squared = x * (h * h - x * x / 3.0);
    (DVec3::ONE - u1 - u2) * x + (u1 + 2.0 * u2) * of_mu - u2 * of_mu_squared
}

/// The limbs of the occluding bodies on the disc of the body `farther`, in radii of this disc, and the axes of the disc: chords run along the first axis.
/// `None` without occluding bodies.
fn limbs_on_disc(occluding: &[&PlacedBody<'_>], farther: &PlacedBody<'_>) -> Option<(Vec<Limb>, [DVec3; 2])> {
    let first = occluding.first()?;
    let towards = farther.placement.centre_km / farther.distance_km;
    let radius_tan = farther.angular_radius_rad().tan();
    // Chords run towards the centre of the first occluding body, so that they cross the last thin crescent and resolve it.
    let perpendicular = first.placement.centre_km - towards * towards.dot(first.placement.centre_km);
    let along = perpendicular.try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
    let across = towards.cross(along);
    let limbs = occluding.iter().map(|p| Limb::on_plane(&p.placement, towards, along * radius_tan, across * radius_tan)).collect();
    Some((limbs, [along, across]))
}

/// Calls `visit` for each visible part of each chord. Its arguments, in radii of the disc: the chord's distance from the disc's middle, half the chord's
/// length, and where the part begins and ends.
fn visit_visible_parts(limbs: &[Limb], mut visit: impl FnMut(f64, f64, f64, f64)) {
    // The ends of the current chord, and where limbs may cross it.
    let mut breaks = Vec::new();
    for &(y, h) in &*CHORD_SIZES {
        breaks.clear();
        breaks.push(-h);
        breaks.extend(limbs.iter().flat_map(|l| l.crossings(y)).filter(|x| x.abs() < h));
        breaks.push(h);
        breaks.sort_by(f64::total_cmp);
        // Adjacent visible intervals are one interval.
        let mut from = -h;
        for pair in breaks.windows(2) {
            if limbs.iter().any(|l| l.contains(0.5 * (pair[0] + pair[1]), y)) {
                if from < pair[0] {
                    visit(y, h, from, pair[0]);
                }
                from = pair[1];
            }
        }
        if from < h {
            visit(y, h, from, h);
        }
    }
}

/// The middle of the visible part of a disc, in radii of the disc from its own middle, as a vector across the line of sight. The limbs of the bodies in front
/// are smooth here. If they cover the disc, some light may remain in valleys of the Moon's limb; the result is then the point of the disc's limb that is
/// farthest from the largest body.
pub(crate) fn visible_middle(placed: &[PlacedBody<'_>], farther: &PlacedBody<'_>) -> DVec3 {
    let margin_rad = 0.0;
    let occluding = bodies_in_front_of(placed, farther, margin_rad);
    let Some((limbs, [along, across])) = limbs_on_disc(&occluding, farther) else { return DVec3::ZERO };
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    visit_visible_parts(&limbs, |y, h, from, to| {
        // Chords are evenly spaced in angle, so the distance between them is proportional to h.
        let part_area = (to - from) * h;
        area += part_area;
        moment += part_area * DVec2::new(0.5 * (from + to), y);
    });
    let middle = if area > 0.0 { moment / area } else { DVec2::NEG_X };
    along * middle.x + across * middle.y
}

/// Whether the gap between the discs of two bodies is less than `margin_rad`; the gap between overlapping discs is negative.
pub(super) fn gap_is_below(a: &PlacedBody<'_>, b: &PlacedBody<'_>, margin_rad: f64) -> bool {
    // Most pairs are far apart, which needs no trigonometry to see: the chord between two directions is at most the angle, and asin(x) is at most x pi/2. The
    // factor 1.001 covers the rounding of directions.
    let chord = a.placement.centre_km / a.distance_km - b.placement.centre_km / b.distance_km;
    let radius_bound = |p: &PlacedBody<'_>| FRAC_PI_2 * p.body.radii_km.max_element() / p.distance_km;
    let bound = (radius_bound(a) + radius_bound(b) + margin_rad) * 1.001;
    if chord.length_squared() > bound * bound {
        return false;
    }
    crate::ephemeris::angle_rad(a.placement.centre_km, b.placement.centre_km) < a.angular_radius_rad() + b.angular_radius_rad() + margin_rad
}

/// Bodies in front of the body `farther` and within `margin_rad` of its disc, in order of decreasing angular radius.
fn bodies_in_front_of<'p, 'a>(placed: &'p [PlacedBody<'a>], farther: &PlacedBody<'_>, margin_rad: f64) -> Vec<&'p PlacedBody<'a>> {
    let is_occluding = |p: &&PlacedBody<'_>| {
        p.body.id != farther.body.id
            && p.distance_km > 0.0
            && !p.placement.camera_is_inside()
            && is_in_front(p, farther)
            && gap_is_below(p, farther, margin_rad)
    };
    let mut found: Vec<_> = placed.iter().filter(is_occluding).collect();
    found.sort_by(|a, b| b.angular_radius_rad().total_cmp(&a.angular_radius_rad()));
    found
}

/// Fraction of the light of the body `farther` that nearer bodies leave visible, per channel; computed once per placed body. `placed`: all bodies of the frame,
/// `farther` among them.
pub(crate) fn visible_fraction(placed: &[PlacedBody<'_>], farther: &PlacedBody<'_>) -> DVec3 {
    *farther.visible_fraction.get_or_init(|| compute_visible_fraction(placed, farther))
}

/// As [`visible_fraction`], but ground below the camera hides nothing: the Sun below the horizon is not eclipsed.
pub(crate) fn visible_fraction_past_other_bodies(placed: &[PlacedBody<'_>], farther: &PlacedBody<'_>) -> DVec3 {
    let margin_rad = 0.0;
    let mut occluding = bodies_in_front_of(placed, farther, margin_rad);
    occluding.retain(|p| !p.is_ground_below_camera());
    light_past(&occluding, farther)
}

fn compute_visible_fraction(placed: &[PlacedBody<'_>], farther: &PlacedBody<'_>) -> DVec3 {
    let margin_rad = 0.0;
    light_past(&bodies_in_front_of(placed, farther, margin_rad), farther)
}

/// Fraction of the light of the body `farther` that the bodies `occluding` leave visible, per channel. `occluding`: from [`bodies_in_front_of`].
fn light_past(occluding: &[&PlacedBody<'_>], farther: &PlacedBody<'_>) -> DVec3 {
    let Some(first) = occluding.first() else { return DVec3::ONE };
    // A quick test: a body's inscribed sphere covers the entire disc, for example far below the horizon.
    let covers_disc = |p: &PlacedBody<'_>| {
        let inscribed_rad = (p.body.radii_km.min_element() / p.distance_km).min(1.0).asin();
        crate::ephemeris::angle_rad(p.placement.centre_km, farther.placement.centre_km) + farther.angular_radius_rad() < inscribed_rad
    };
    if occluding.iter().any(|p| covers_disc(p) && p.limb_profile.is_none()) {
        return DVec3::ZERO;
    }
    let Some((limbs, _)) = limbs_on_disc(occluding, farther) else { return DVec3::ONE };
    let (u1, u2) = limb_darkening(farther.body);
    // Chords are evenly spaced in angle, so the distance between them is proportional to h.
    let light = |h: f64, from: f64, to: f64| (radiance_along_chord(to, h, u1, u2) - radiance_along_chord(from, h, u1, u2)) * h;
    let total: DVec3 = CHORD_SIZES.iter().map(|(_, h)| light(*h, -h, *h)).sum();
    let mut visible = DVec3::ZERO;
    visit_visible_parts(&limbs, |_, h, from, to| visible += light(h, from, to));
    let visible = (visible / total).clamp(DVec3::ZERO, DVec3::ONE);
    // The lunar limb profile applies if the Moon is the only body in front of the Sun.
    match (occluding, first.limb_profile.as_deref()) {
        ([moon], Some(profile)) if farther.body.id == NaifId::SUN => lunar_limb::visible_sunlight(profile, moon, farther, visible),
        _ => visible,
    }
}

/// Records as a decision the fraction of a body's light that nearer bodies leave visible, in the green channel; the decision is on if they hide all light. Does
/// nothing if all light is visible or a fraction is recorded already.
pub(super) fn record_visible_fraction(bodies: &mut [BodyReport], body: NaifId, visible: DVec3) {
    if visible == DVec3::ONE {
        return;
    }
    let visible_part = visible.y;
    let reason = reason!("hidden", part = format_args!("{visible_part:.6}"));
    let decision = Decision { effect: "hidden", on: visible == DVec3::ZERO, reason, stated_error: None };
    let is_unrecorded = |b: &&mut BodyReport| b.id == body && b.decisions.iter().all(|d| d.effect != decision.effect);
    bodies.iter_mut().filter(is_unrecorded).for_each(|b| b.decisions.push(decision.clone()));
}

/// Stores the limbs of nearer bodies in the draws of emissive discs, and records the visible fractions as decisions.
pub(crate) fn apply(placed: &[PlacedBody<'_>], camera: &Camera, draws: &mut [Draw], bodies: &mut [BodyReport]) {
    let placed_body = |id: NaifId| placed.iter().find(|p| p.body.id == id);
    let drawn: Vec<_> = draws.iter().filter(|d| d.part == BodyPart::Globe).map(|d| (d.body, d.features.shape)).collect();
    let moon_profile_uniforms = draws.iter().find(|d| d.features.limb_heights).map(|d| d.uniforms.limb.clone());
    for draw in draws.iter_mut().filter(|d| d.part == BodyPart::Globe && d.features.surface == Surface::Emissive) {
        let Some(farther) = placed_body(draw.body) else { continue };
        let Some(middle) = camera.clip(farther.placement.centre_km) else { continue };
        let margin_rad = 2.0 * camera.pixel_tangent();
        let occluding = bodies_in_front_of(placed, farther, margin_rad);
        let shape = |p: &PlacedBody<'_>| drawn.iter().find(|(id, _)| *id == p.body.id).map(|(_, shape)| *shape);
        // A mesh's outline differs from the outline of its ellipsoid, so meshes are left out.
        let mut nearer: Vec<_> = occluding.into_iter().filter(|p| shape(p) != Some(Shape::Mesh)).collect();
        if nearer.is_empty() {
            continue;
        }
        let visible = visible_fraction(placed, farther);
        record_visible_fraction(bodies, farther.body.id, visible);
        // A nearer body that is drawn only as a point needs no limb here, because the point's sprite hides the body's part of the farther disc (`points`).
        // Exception: if nothing of the farther disc is visible, the body stays, so that all of the disc is hidden (kind 2 below).
        nearer.retain(|p| visible == DVec3::ZERO || shape(p).is_some());
        if nearer.is_empty() {
            continue;
        }
        // The origin of positions in the limb's forms. It is rounded to f32 first, so that the shader subtracts exactly this pixel position.
        let origin_px = narrow2(camera.pixel_from_clip(middle));
        let ray = |px: DVec2| camera.ray(camera.clip_from_pixel(px));
        let origin_ray = ray(origin_px.as_dvec2());
        let (dx, dy) = (ray(origin_px.as_dvec2() + DVec2::X) - origin_ray, ray(origin_px.as_dvec2() + DVec2::Y) - origin_ray);
        for (p, rows) in nearer.iter().zip(draw.uniforms.foreground_limbs.rows.as_chunks_mut::<3>().0) {
            let limb = Limb::on_plane(&p.placement, origin_ray, dx, dy);
            // Kinds and rows as in shaders/lib/foreground_limb.wesl, which has rows for the two largest bodies. Kinds: 1 for a body drawn over the disc,
            // 2 if nothing of the disc is visible.
            let kind = if visible == DVec3::ZERO { 2.0 } else { 1.0 };
            let row = |values: [f64; 4]| Vec4::from_array(values.map(narrow_scalar));
            let [c, gx, gy, xx, xy, yy] = limb.quadratic;
            *rows = [row([c, gx, gy, kind]), row([xx, xy, yy, 0.0]), row([limb.linear[0], limb.linear[1], limb.linear[2], 0.0])];
        }
        let moon_index = nearer.iter().take(2).position(|p| p.limb_profile.is_some());
        if let (Some(k), Some(uniforms)) = (moon_index, &moon_profile_uniforms) {
            lunar_limb::apply_to_sun(draw, uniforms, nearer[k], camera, 3 * k, [origin_ray, dx, dy]);
        }
        // The last row of each of the two bodies has a free w.
        let rows = &mut draw.uniforms.foreground_limbs.rows;
        (rows[2].w, rows[5].w) = (origin_px.x, origin_px.y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, EulerRot};

    fn meets(body: &Placement, towards: DVec3) -> bool {
        let (c, d) = (body.camera_in_unit_sphere(), body.direction_in_unit_sphere(towards).normalize());
        c.dot(d) < 0.0 && c.cross(d).length() < 1.0
    }

    /// For an elongated body, from 3 km above its ground to a telescope's distance: of the rays around a point of its limb, the limb contains exactly those
    /// that meet the body.
    #[test]
    fn a_limb_contains_the_rays_that_meet_the_body() {
        let radii_km = DVec3::new(13.0, 11.4, 9.1);
        for (k, distance_km) in [(0.0, 13.001), (1.0, 14.0), (2.0, 20.0), (3.0, 99.0), (4.0, 1e6), (5.0, 1e9)] {
            let body_from_icrf = DMat3::from_euler(EulerRot::XYZ, 0.3 + k, 1.1, 0.7 * k);
            let body = Placement { centre_km: DVec3::X * distance_km, body_from_icrf, radii_km };
            let (mut inside, mut outside) = (0, 0);
            for n in 0..12 {
                let perpendicular = DVec3::new(0.0, f64::from(n).cos(), f64::from(n).sin());
                let at = |angle: f64| DVec3::X * angle.cos() + perpendicular * angle.sin();
                // The angle of the limb, by bisection.
                let (mut from, mut to) = (0.0, 1.6);
                for _ in 0..60 {
                    let middle = 0.5 * (from + to);
                    if meets(&body, at(middle)) { from = middle } else { to = middle }
                }
                let ray = at(from);
                let unit = 0.1 * from;
                let (dx, dy) = (perpendicular * unit, DVec3::X.cross(perpendicular) * unit);
                let limb = Limb::on_plane(&body, ray, dx, dy);
                for (x, y) in [(0.01, 0.0), (-0.01, 0.0), (0.5, 0.4), (-0.5, 0.9), (0.9, -0.9), (-2.0, 0.1), (2.0, 0.3)] {
                    let expected = meets(&body, ray + dx * x + dy * y);
                    assert_eq!(limb.contains(x, y), expected, "{distance_km} km, {n}: {x} {y}");
                    (inside, outside) = (inside + u32::from(expected), outside + u32::from(!expected));
                }
                // One of the crossings on this line is the limb itself.
                let nearest = limb.crossings(0.0).into_iter().map(f64::abs).fold(f64::MAX, f64::min);
                assert!(nearest < 1e-6, "{distance_km} km, {n}: {nearest}");
            }
            assert!(inside > 10 && outside > 10, "{distance_km} km: {inside} {outside}");
        }
    }
}
