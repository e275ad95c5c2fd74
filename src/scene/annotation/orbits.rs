//! The line of an orbit: the osculating conic of a body about its parent, its colour, and the sizes at which it fades.
//!
//! In: a placed body and its parent. Out: the conic's arcs (`orbit_arcs`) and a decision. An orbit has a few dozen arcs, whether the camera is a metre or a
//! hundred au away from it. Perturbations are not modelled; the lines of past motion (`traces`) show them.

use crate::catalog::Body;
use crate::ephemeris::{BEST_SOURCE, Ephemeris};
use crate::message::{Reason, reason};
use crate::scene::annotation::orbit_arcs::{Conic, FADE_PX, OrbitArc, arcs, size_on_screen_px};
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::numeric::smooth_rise;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};

/// The name of the decision about an orbit.
pub(super) const EFFECT: &str = "orbit";
/// Half the width of a line, pixels.
pub(crate) const HALF_WIDTH_PX: f32 = 0.6;
/// Radiance of a white line relative to the radiance that is shown as white.
pub(crate) const RELATIVE_RADIANCE: f32 = 0.3;
/// Power to which the components of a body's colour are raised for its orbit.
const HUE_POWER: f64 = 3.0;
/// Fraction of white mixed into an orbit's colour.
const WHITE_FRACTION: f64 = 0.3;
/// Ratios of the orbit's size ([`Conic::size_km`]: an ellipse's semi-major axis) to half the frame's diagonal at the target's distance: at the first the
/// orbit starts to fade, from the second it is invisible. The second is also a ratio of distances: an orbit does not fade if its body is in the frame and
/// nearer than this multiple of the target's distance.
const SIZE_FADE: (f64, f64) = (8.0, 32.0);
/// Opacity of a line at its body.
const OPACITY: f64 = 0.9;

/// The fraction of an orbit's opacity that remains in a view of the target, and the ratio that [`SIZE_FADE`] limits. `body_km`: the body's position from the
/// camera, ICRF. `target_distance_km`: `None` without a target; then no orbit fades.
fn remaining_opacity_and_size_ratio(camera: &Camera, conic: &Conic, body_km: DVec3, target_distance_km: Option<f64>) -> (f64, f64) {
    let Some(distance_km) = target_distance_km else { return (1.0, 0.0) };
    let size_ratio = conic.size_km() / (distance_km * camera.tan_half_fov.length());
    let is_near = body_km.length() < SIZE_FADE.1 * distance_km;
    let in_frame = is_near && camera.clip(body_km).is_some_and(|clip: DVec2| clip.abs().max_element() < 1.0);
    (if in_frame { 1.0 } else { 1.0 - smooth_rise(SIZE_FADE, size_ratio) }, size_ratio)
}

/// The colour of a body's orbit and trace: the body's hue, exaggerated so that the orbits of neighbours differ, and some white. Linear RGB.
pub(crate) fn line_colour(body: &Body) -> DVec3 {
    let colour = body.colour.as_dvec3() / f64::from(body.colour.max_element());
    colour.powf(HUE_POWER).lerp(DVec3::ONE, WHITE_FRACTION)
}

/// The orbit of one body and the decision about it. `None`: the body has no parent, or the parent is not in the catalog. `target_distance_km`: distance of the
/// target from the camera, if there is one.
pub(crate) fn orbit_line(
    camera: &Camera,
    ephemeris: &Ephemeris,
    placed: &PlacedBody<'_>,
    target_distance_km: Option<f64>,
) -> Option<(Vec<OrbitArc>, Decision)> {
    let parent = placed.catalog.body(placed.body.parent?)?;
    let not_drawn = |reason: Reason| Some((Vec::new(), Decision { effect: EFFECT, on: false, reason, stated_error: None }));
    let state = match ephemeris.state(placed.body.id, parent.id, placed.emitted_at, BEST_SOURCE) {
        Ok(answer) => answer.state,
        Err(e) => return not_drawn(reason!("quoted", text = &e.to_string())),
    };
    let gm_km3_s2 = parent.gm_km3_s2.unwrap_or(0.0) + placed.body.gm_km3_s2.unwrap_or(0.0);
    let Some(conic) = Conic::of(&state, gm_km3_s2) else { return not_drawn(reason!("orbit-no-conic", body = &parent.name)) };
    let (remaining, size_ratio) = remaining_opacity_and_size_ratio(camera, &conic, placed.placement.centre_km, target_distance_km);
    if remaining <= 0.0 {
        return not_drawn(reason!("orbit-large", times = format_args!("{size_ratio:.0}"), limit = SIZE_FADE.1));
    }
    let all = arcs(camera, &conic, placed.placement.centre_km, OPACITY * remaining, line_colour(placed.body));
    let size_px = size_on_screen_px(camera, &conic, placed.placement.centre_km);
    let (invisible_below_px, _) = FADE_PX;
    let reason = match all.len() {
        0 if size_px < invisible_below_px => reason!("orbit-small", size = format_args!("{size_px:.1}"), threshold = invisible_below_px),
        0 => reason!("outside-frame"),
        n => reason!("orbit-arcs", body = &parent.name, size = format_args!("{size_px:.0}"), count = n),
    };
    let on = !all.is_empty();
    Some((all, Decision { effect: EFFECT, on, reason, stated_error: None }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::two_body;

    #[test]
    fn orbits_of_neighbouring_planets_differ_in_colour() {
        let colour = |name: &str| line_colour(crate::Catalog::embedded().body_named(name).expect("in the catalog"));
        let planets = ["Mercury", "Venus", "Earth", "Mars", "Jupiter", "Saturn", "Uranus", "Neptune"].map(colour);
        for pair in planets.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|c| c.map(|v| 255.0 * crate::units::linear_to_srgb(v)));
            assert!((a - b).abs().max_element() > 10.0, "{a} and {b} of 255");
        }
        assert!(planets.iter().all(|c| c.max_element() == 1.0 && c.min_element() >= WHITE_FRACTION));
    }

    /// An orbit thousands of times as large as the frame at the target is left out unless its body is in the frame.
    #[test]
    fn orbits_far_larger_than_the_view_are_left_out() {
        const SUN_GM_KM3_S2: f64 = 1.327e11;
        let (semi_major_axis_km, eccentricity, mean_motion_per_s) = (1.5e9, 0.2, 6.8e-9);
        let [inclination_rad, node_rad, argument_of_periapsis_rad, mean_anomaly_rad] = [0.4, 1.0, 2.0, 0.7];
        let state = two_body::state_in_frame(
            semi_major_axis_km,
            eccentricity,
            inclination_rad,
            node_rad,
            argument_of_periapsis_rad,
            mean_anomaly_rad,
            mean_motion_per_s,
        );
        let conic = Conic::of(&state, SUN_GM_KM3_S2).expect("a conic");
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 45.0, 800, 600);
        let at = |body_km: DVec3, target_km: f64| remaining_opacity_and_size_ratio(&camera, &conic, body_km, Some(target_km)).0;
        // Bodies behind the camera, which are not in the frame, and one straight ahead.
        assert_eq!((at(DVec3::NEG_X, 1e6), at(DVec3::X, 1e6), at(DVec3::NEG_X, 1e9)), (0.0, 1.0, 1.0));
        assert_eq!(remaining_opacity_and_size_ratio(&camera, &conic, DVec3::NEG_X, None).0, 1.0);
    }
}
