//! The ground of a body: its shape and its maps.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions. Relief, sun glint and cloud shadows are visible at every size of a disc:
//! averaged over a pixel they still change its light by several levels. Cloud shadows are left out if no sunlit ground is in view. What water mirrors is left
//! out if, in addition, both the light of other bodies and the sky are too dark for it to be visible.

use crate::message::{Reason, reason};
use crate::scene::atmosphere::air;
use crate::scene::draw::features::{Detail, MapSet};
use crate::scene::features::choice::{BodyCapabilities, ellipsoid_flattening};
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::{city_lights, lights};
use crate::scene::request::effects::Effect;
use crate::scene::surface::detail;

/// Decides whether the body's oblateness is drawn, and which of its maps.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (body, threshold) = (inputs.body(), inputs.threshold());
    let log = &mut decisions.log;
    let available = BodyCapabilities::of(body);
    let normal_tilt_rad = ellipsoid_flattening(body);
    // A normal tilted by an angle changes the cosine of incidence by at most this angle; the change is visible first on white ground at the terminator.
    let max_change = normal_tilt_rad * lights::sunlight(inputs.placed.body_to_sun_km).irradiance.max_element();
    let light = threshold.radiance_description(max_change);
    let reason = reason!("ellipsoid-lean", lean = format_args!("{normal_tilt_rad:.2e}"), light = light);
    decisions.chosen.ellipsoid =
        available.is_flattened && log.record_effect(Effect::Ellipsoid, threshold.is_exceeded_by_radiance(max_change), reason);
    if !available.is_flattened {
        log.record(Effect::Ellipsoid.name(), false, reason!("axes-equal"));
    }
    let always_drawn = || (true, reason!("albedo-disc", size = format_args!("{:.1}", inputs.diameter_px)));
    let albedo = log.record_effect_with_map(Effect::Albedo, body.maps.albedo.as_ref(), always_drawn);
    let mut maps = MapSet { albedo, ..MapSet::default() };
    if available.custom_surface > 0 {
        decisions.chosen.custom_surface = log.record_effect(Effect::CustomSurface, true, reason!("by-surface"));
    }
    if available.is_emissive {
        log.record("lights", false, reason!("emits-light"));
        decisions.chosen.maps = maps;
        return decisions;
    }
    // Relief is drawn without sunlight too, because it is visible in planet-shine.
    maps.normal = log.record_effect_with_map(Effect::Normal, body.maps.normal.as_ref(), || (true, reason!("slopes-show")));
    let sunlit_ground = sunlit_ground_in_view(inputs);
    let is_sunlit_ground_in_view = sunlit_ground.0;
    let mirrored = || if is_sunlit_ground_in_view { sunlit_ground.clone() } else { mirrored_without_sunlight(inputs) };
    maps.specular = log.record_effect_with_map(Effect::Specular, body.maps.specular.as_ref(), mirrored);
    maps.night = log.record_effect_with_map(Effect::Night, body.maps.night.as_ref(), || {
        let white = city_lights::drawn_white_radiance(inputs.placed);
        let reason = reason!("city-lights", light = threshold.radiance_description(white));
        (threshold.is_exceeded_by_radiance(white), city_lights::with_height_note(reason, inputs.placed))
    });
    if let Some(c) = &body.clouds {
        let clouds_are_off = log.is_switched_off(Effect::Clouds);
        let visibility = || if clouds_are_off { (false, reason!("clouds-off")) } else { sunlit_ground.clone() };
        maps.cloud_shadow = log.record_effect_with_map(Effect::CloudShadow, Some(&c.map), visibility);
    }
    if available.detail != Detail::None {
        // The shader uses the texel size of the albedo map or, if there is none, of the normal map.
        let map = body.maps.albedo.as_ref().filter(|_| maps.albedo).or(body.maps.normal.as_ref().filter(|_| maps.normal));
        let (span_deg, max_span_deg) = detail::ground_deg_per_px(inputs.frame.camera, &inputs.placed.placement, map);
        let sizes = reason!("detail-span", span = format_args!("{span_deg:.4}"), threshold = format_args!("{max_span_deg:.4}"));
        let reason = detail::description(available.detail).and(sizes);
        decisions.chosen.detail = decisions.log.record_effect(Effect::Detail, span_deg < max_span_deg, reason);
    }
    decisions.chosen.maps = maps;
    decisions
}

/// Ratio of the radiance of a light's glint on the sea, at its brightest, to the radiance of ground under the same light. It is 1 / (4 s c), for waves
/// that are perfect mirrors and do not hide each other. Here s is their mean square slope (0.0286, `WAVE_SLOPE_SQ`), and c the cosine of a grazing emission
/// angle, chosen as 85 degrees. The ratio is not a bound: by the formulas of shaders/lib/glint.wesl, evaluated in steps of 0.2 degrees, the glint of a light
/// that is 5 degrees high reaches 112 times the radiance of white ground, on the horizon. Moreover, the ground here has the body's albedo.
const GLINT_TO_GROUND_RATIO: f64 = 100.0;

/// Upper limit of the radiance that water mirrors of the sky, relative to the mean over the sky, where the Sun has set. On the Earth it is up to 7, towards the
/// place of the Sun 10 degrees below the horizon; times that mean's error of a factor of 3 (tests/atmosphere/dusk_at_height.rs).
const MIRRORED_TO_MEAN_SKY: f64 = 25.0;

/// Whether the light that water mirrors is visible if no sunlit ground is in view: the glint of another body's light, or the sky.
fn mirrored_without_sunlight(inputs: &DecisionInputs<'_, '_>) -> (bool, Reason) {
    let (placed, threshold) = (inputs.placed, inputs.threshold());
    let has_planet_shine = inputs.effects().override_of(Effect::PlanetShine) != Some(false);
    let (_, strongest) = lights::planet_shine(inputs.body(), placed.position_km, inputs.frame.reflectors, |_| false);
    let glint = strongest.filter(|_| has_planet_shine).map_or(0.0, |(_, radiance)| radiance * GLINT_TO_GROUND_RATIO);
    let sky = mirrored_sky(inputs);
    (
        threshold.is_exceeded_by_radiance(glint.max(sky)),
        reason!("no-lit-ground")
            .and(reason!("glint-of-others", light = threshold.radiance_description(glint)))
            .and(reason!("mirrored-sky", light = threshold.radiance_description(sky))),
    )
}

/// Upper limit of the radiance of the sky that water in view mirrors, where the Sun has set; 0 without an atmosphere.
fn mirrored_sky(inputs: &DecisionInputs<'_, '_>) -> f64 {
    let (body, placed) = (inputs.body(), inputs.placed);
    let has_air = inputs.effects().override_of(Effect::Atmosphere) != Some(false);
    let Some(atmosphere) = body.atmosphere.as_ref().filter(|_| has_air) else {
        return 0.0;
    };
    // The Sun's altitude above the ground in view that is nearest to the terminator.
    let altitude_deg = 90.0 + horizon_deg(inputs) - placed.phase_angle_rad.to_degrees();
    let sky = inputs.frame.context.caches.sky_brightness.of(atmosphere, body.radii_km.x);
    let irradiance = lights::sunlight(placed.body_to_sun_km).irradiance.max_element();
    let on_ground = 0.0;
    MIRRORED_TO_MEAN_SKY * irradiance * sky.luminance(altitude_deg, on_ground) + air::night_radiance(atmosphere)
}

/// Margin beyond the terminator for the Sun's angular radius at Mercury and for refraction, degrees.
const TERMINATOR_MARGIN_DEG: f64 = 2.0;

/// Angle at the body's centre between the point below the observer and the horizon, degrees.
fn horizon_deg(inputs: &DecisionInputs<'_, '_>) -> f64 {
    (inputs.body().radii_km.min_element() / inputs.placed.distance_km).min(1.0).acos().to_degrees()
}

/// Whether sunlit ground is in view: whether the angle between sub-observer and sub-solar point is less than the sum of two angles, that from the sub-observer
/// point to the horizon and that from the sub-solar point to the terminator with its margin.
fn sunlit_ground_in_view(inputs: &DecisionInputs<'_, '_>) -> (bool, Reason) {
    let (separation_deg, max_separation_deg) =
        (inputs.placed.phase_angle_rad.to_degrees(), 90.0 + horizon_deg(inputs) + TERMINATOR_MARGIN_DEG);
    (
        separation_deg < max_separation_deg,
        reason!("sun-from-zenith", degrees = format_args!("{separation_deg:.1}"))
            .and(reason!("lit-ground-up-to", degrees = format_args!("{max_separation_deg:.1}"))),
    )
}
