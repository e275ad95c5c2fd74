//! Comets: the head as a point of light or as a coma, a tail of dust and a tail of ions.
//!
//! In: the catalog's comets, the camera, the air around it, the radiance displayed as white. Out: [`Comets`]: sprites for shaders/entry/point.wesl, patches of
//! light for shaders/entry/comet_tail.wesl (`comet_tails`), and arcs of orbits. A comet has the total magnitude M1 + 5 log d + K1 log r - 2.5 log p, with the
//! distances d from the viewer and r from the Sun in au, and M1 and K1 from the catalog; p is the brightness at its phase angle, relative to that at 90
//! degrees: dust scatters forwards. The head and its tails together have this light, as seen from far away; dust at another phase angle than the comet's has
//! less or more. The head is a point while the coma is a few pixels wide. The air around the camera dims and reddens all of it. Values are computed in f64 and
//! narrowed in the result.
//! Left out: outbursts, and what comet_tails leaves out.

use super::comet_tails::{COMA_RGB, CometView, LightPatch, Sight, coma_radius_au, of_luminance_1, water_production};
use super::minor_planets::MARKER_LEVEL;
use crate::catalog::small_bodies::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, ORDINARY_DUST_TO_GAS, SmallBodies};
use crate::ephemeris::conic::{ConicState, heliocentric_state};
use crate::ephemeris::{State, angle_rad};
use crate::message::{Reason, reason};
use crate::scene::annotation::orbit_arcs::{self, Conic, OrbitArc};
use crate::scene::atmosphere::tint_table::FrameTints;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::{PixelView, StarSprite};
use crate::scene::light::phase_laws::comet_law;
use crate::scene::light::photometry::irradiance_of_magnitude;
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::point::{pixel_sr, point_peak, point_radius_px};
use crate::scene::request::view_request::ViewRequest;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S, luminance};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Shares of an ordinary comet's light at 90 degrees in the tail of dust and in that of ions, for tails that are complete (see [`TAILS_AU`]). In photographs of
/// dusty comets the dust tail is several times as bright as the ion tail over its first degrees. A comet with less dust in its coma has a smaller share in the
/// tail of dust.
const DUST_SHARE: f64 = 0.5;
const ION_SHARE: f64 = 0.025;
/// Heliocentric distances, au, at which an approaching comet's tails start to grow, and at which they are complete.
const TAILS_AU: (f64, f64) = (3.0, 1.5);
/// Fraction of the radiance of white below which a comet's tails are left out. In sRGB encoding it is 0.8 of an 8-bit level.
const MIN_LEVEL: f64 = 1.0 / 4096.0;
/// As [`MIN_LEVEL`], for one patch: some ten overlap.
const MIN_PATCH_LEVEL: f64 = 0.1 * MIN_LEVEL;
/// Radii of a coma, pixels, from which it replaces the point, and from which only the coma is left.
const COMA_PX: (f64, f64) = (2.0, 8.0);
/// Opacity of a comet's orbit at the comet.
const ORBIT_OPACITY: f64 = 0.6;

/// The comets of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comets {
    pub heads: Vec<StarSprite>,
    /// Comas and tails.
    pub patches: Vec<LightPatch>,
    /// Orbits of the comets in the frame that have tails, if orbits are switched on.
    pub orbits: Vec<OrbitArc>,
}

/// Total magnitude of a comet at the given distances from the viewer and from the Sun, au; `None` for a body with another brightness law. `phase_angle_rad`:
/// angle at the comet between the viewer and the Sun.
pub fn total_magnitude(law: BrightnessLaw, distance_au: f64, sun_distance_au: f64, phase_angle_rad: f64) -> Option<f64> {
    let BrightnessLaw::Comet { m1, k1, dust_to_gas } = law else { return None };
    let phase_magnitude = -2.5 * comet_law(dust_to_gas, phase_angle_rad).log10();
    Some(m1 + 5.0 * distance_au.log10() + k1 * sun_distance_au.log10() + phase_magnitude)
}

/// The tail of dust of a complete comet: its share of the comet's light. `dust_to_gas`: in the coma.
fn dust_share(dust_to_gas: f64) -> f64 {
    let dust_fraction = |ratio: f64| ratio / (1.0 + ratio);
    DUST_SHARE * (dust_fraction(dust_to_gas) / dust_fraction(ORDINARY_DUST_TO_GAS)).min(1.0)
}

/// The orbit line of a comet, from its heliocentric state.
fn orbit_line(view: &CometView<'_>, state: &ConicState, sight: &Sight) -> Vec<OrbitArc> {
    let state_km = State { pos_km: state.position * KM_PER_AU, vel_km_s: state.velocity * (KM_PER_AU / SECONDS_PER_DAY) };
    let gm_km3_s2 = GAUSS_CONSTANT.powi(2) * KM_PER_AU.powi(3) / SECONDS_PER_DAY.powi(2);
    let apparent_km = sight.direction * sight.distance_au * KM_PER_AU;
    let conic = Conic::of(&state_km, gm_km3_s2);
    conic.map_or_else(Vec::new, |conic| orbit_arcs::arcs(view.camera, &conic, apparent_km, ORBIT_OPACITY, of_luminance_1(COMA_RGB)))
}

/// The head: the sprite of the part of its light that is no coma; `None` outside the frame or behind the camera. `is_marked`: whether the sprite is at least as
/// bright as a marker.
fn head(view: &CometView<'_>, sight: &Sight, irradiance: f64, is_marked: bool, white: f64) -> Option<StarSprite> {
    let clip = view.camera.clip(sight.direction).filter(|_| sight.depth < 1.0)?;
    let colour = of_luminance_1(COMA_RGB) * sight.transmittance;
    // The air dims the light to this fraction; a marker is not dimmed.
    let transmitted = luminance(colour.to_array());
    let flux = irradiance * transmitted * PI / pixel_sr(view.camera, sight.direction);
    let marker_flux = MARKER_LEVEL * white / point_peak();
    let rgb_flux = match is_marked && flux < marker_flux {
        true => of_luminance_1(COMA_RGB) * marker_flux,
        false => colour * (flux / transmitted.max(f64::MIN_POSITIVE)),
    };
    let radius_px = point_radius_px(luminance(rgb_flux.to_array()) * point_peak() / white);
    let limit_px = view.camera.half_size_px() + radius_px;
    let is_in_frame = (clip * view.camera.half_size_px()).abs().cmple(limit_px).all();
    let centre = narrow(clip.extend(sight.depth));
    is_in_frame.then(|| StarSprite { centre, radius_px: narrow_scalar(radius_px), stretch: 1.0, flux: narrow(rgb_flux), star: None })
}

/// A comet's heliocentric state at the time of emission, and that time in days past J2000. `days`: the time at the camera, past J2000.
fn state_at_emission(orbit: &HeliocentricOrbit, days: f64, camera_au: DVec3) -> (ConicState, f64) {
    let mut emission_days = days;
    for _ in 0..3 {
        let distance_au = (heliocentric_state(orbit, emission_days).position - camera_au).length();
        emission_days = days - distance_au * KM_PER_AU / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY;
    }
    (heliocentric_state(orbit, emission_days), emission_days)
}

/// The comets of a frame and the decision about them; no decision in pixel views other than the final image. `sun_position_km`: barycentric.
/// `white`: the radiance displayed as white. `tints`: of the air around the camera.
pub(crate) fn comets(
    request: &ViewRequest,
    small_bodies: impl FnOnce() -> Arc<SmallBodies>,
    viewer: &Viewer,
    sun_position_km: Option<DVec3>,
    white: f64,
    tints: &FrameTints<'_>,
) -> (Comets, Option<Decision>) {
    let decided = |on: bool, reason: Reason| Some(Decision { effect: "comets", on, reason, stated_error: None });
    if request.pixel_view != PixelView::Final {
        return (Comets::default(), None);
    }
    if !request.layers.comets {
        return (Comets::default(), decided(false, reason!("comets-off")));
    }
    let Some(sun_position_km) = sun_position_km else {
        return (Comets::default(), decided(false, reason!("no-sun-known")));
    };
    let (camera, days) = (&viewer.camera, request.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
    let camera_au = (camera.position_km - sun_position_km) / KM_PER_AU;
    let view = CometView { camera, camera_au, velocity_km_s: viewer.velocity_km_s, air: tints.table() };
    let (start_au, complete_au) = TAILS_AU;
    let mut in_frame = Comets::default();
    let (mut brightest, mut shown_head_count, mut uncertain_count) = (None::<(f64, String)>, 0, 0);
    for comet in &small_bodies().comets {
        let orbit = comet.orbit_at(days);
        let (state, emission_days) = state_at_emission(orbit, days, camera_au);
        let Some(sight) = view.sight(state.position) else { continue };
        let (sun_distance_au, distance_au) = (state.position.length(), sight.distance_au);
        let phase_angle_rad = angle_rad(camera_au - state.position, -state.position);
        let law = comet.brightness_at(days);
        let (BrightnessLaw::Comet { dust_to_gas, .. }, Some(magnitude)) =
            (law, total_magnitude(law, distance_au, sun_distance_au, phase_angle_rad))
        else {
            continue;
        };
        let irradiance = irradiance_of_magnitude(magnitude);
        let phase_factor = comet_law(dust_to_gas, phase_angle_rad);
        // By the magnitude at 90 degrees.
        let production = water_production(magnitude - 5.0 * distance_au.log10() + 2.5 * phase_factor.log10());
        let tail_growth = smoothstep((start_au - sun_distance_au) / (start_au - complete_au));
        // The tails are fainter than the entire light in one point would be. The head may be outside the frame, so that point is taken to be in the middle.
        let peak_radiance = irradiance * PI / camera.pixel_tangent().powi(2) * point_peak();
        let is_visible = peak_radiance > white * MIN_LEVEL;
        // Ions scatter no light forwards.
        let (dust_share, ion_share) = (tail_growth * dust_share(dust_to_gas), tail_growth * ION_SHARE / phase_factor);
        if tail_growth > 0.0 && is_visible {
            let at_1_au = irradiance * distance_au.powi(2);
            view.dust(orbit, emission_days, dust_share * at_1_au, production, &mut in_frame.patches);
            view.ions(&state, ion_share * at_1_au, production, &mut in_frame.patches);
        }
        let head_irradiance = irradiance * (1.0 - dust_share - ion_share);
        let radius_au = coma_radius_au(production);
        let coma_fraction = smooth_rise(COMA_PX, radius_au / distance_au / camera.pixel_tangent());
        let coma = (coma_fraction > 0.0 && is_visible).then(|| view.coma(&sight, coma_fraction * head_irradiance, radius_au)).flatten();
        // A head too faint for the exposure is drawn as a marker.
        let is_marked = coma.is_none_or(|c| f64::from(c.radiance) * luminance(sight.transmittance.to_array()) < MARKER_LEVEL * white);
        let point = head(&view, &sight, (1.0 - coma_fraction) * head_irradiance, is_marked, white);
        in_frame.patches.extend(coma);
        let Some(point) = point else { continue };
        shown_head_count += 1;
        uncertain_count += usize::from(comet.is_between_apparitions(days));
        if tail_growth > 0.0 && request.layers.orbits {
            in_frame.orbits.extend(orbit_line(&view, &state, &sight));
        }
        if brightest.as_ref().is_none_or(|(brightest_so_far, _)| magnitude < *brightest_so_far) {
            brightest = Some((magnitude, comet.full_name()));
        }
        in_frame.heads.push(point);
    }
    // Patches that are too faint to be visible would only cost time.
    let min_radiance = narrow_scalar(white * MIN_PATCH_LEVEL);
    in_frame.patches.retain(|p| p.radiance * p.colour.max_element() > min_radiance);
    let heads_reason = match brightest {
        Some((magnitude, name)) => {
            reason!("comets-brightest", count = shown_head_count, comet = &name, magnitude = format_args!("{magnitude:.1}"))
        }
        None => reason!("comets-none"),
    };
    let mut reason = heads_reason.and(reason!("comets-tails", count = in_frame.patches.len()));
    if uncertain_count > 0 {
        reason = reason.and(reason!("comets-uncertain", count = uncertain_count));
    }
    let on = shown_head_count > 0 || !in_frame.patches.is_empty();
    (in_frame, decided(on, reason))
}
