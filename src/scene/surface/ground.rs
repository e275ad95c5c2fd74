//! The ground of a body: its shape and its maps.
//!
//! Relief, sun glint and cloud shadows are visible at every size of a disc: averaged over a pixel they still change its light by several levels. They are
//! left out if no sunlit ground is in view.

use crate::scene::draw::features::{Detail, MapSet};
use crate::scene::features::case::{Case, Decisions};
use crate::scene::features::choice::{Capabilities, flattening};
use crate::scene::light::{lights, night_lights};
use crate::scene::request::effects::Effect;
use crate::scene::surface::detail;

/// Decides whether the body's oblateness shows, and which of its maps.
pub(crate) fn decide<'c>(case: &Case<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    let (body, least) = (case.body(), case.threshold());
    let log = &mut so_far.log;
    let available = Capabilities::of(body);
    let lean = flattening(body);
    // A tilted normal changes the cosine of incidence by as much, and so the light of white ground at the terminator.
    let changed = lean * lights::sunlight(case.placed.sun_from_body_km).irradiance.max_element();
    let reason = format!("its normals lean {lean:.2e} rad from a sphere's: at the terminator {}", least.description(changed));
    so_far.chosen.ellipsoid = available.ellipsoid && log.effect(Effect::Ellipsoid, least.is_exceeded_by(changed), reason);
    if !available.ellipsoid {
        log.note(Effect::Ellipsoid.name(), false, "its axes are equal".into());
    }
    let albedo = log.map(Effect::Albedo, body.maps.albedo.as_ref(), || (true, format!("a disc of {:.1} px is drawn", case.diameter_px)));
    let mut maps = MapSet { albedo, ..MapSet::default() };
    if available.custom_surface > 0 {
        so_far.chosen.custom_surface = log.effect(Effect::CustomSurface, true, "by --surface".into());
    }
    if available.emissive {
        log.note("lights", false, "it emits light".into());
        so_far.chosen.maps = maps;
        return so_far;
    }
    // Relief is visible in moonlight and planet-shine, too.
    maps.normal = log.map(Effect::Normal, body.maps.normal.as_ref(), || (true, "slopes show at every size of a disc".into()));
    let lit = lit_ground(case);
    maps.specular = log.map(Effect::Specular, body.maps.specular.as_ref(), || if lit.0 { lit.clone() } else { moonlit(case) });
    maps.night = log.map(Effect::Night, body.maps.night.as_ref(), || {
        let most = night_lights::brightest(body);
        (least.is_exceeded_by(most), format!("brightest city lights {}", least.description(most)))
    });
    if let Some(c) = &body.clouds {
        let no_clouds = log.is_switched_off(Effect::Clouds);
        let visibility = || if no_clouds { (false, "the clouds are switched off".into()) } else { lit.clone() };
        maps.cloud_shadow = log.map(Effect::CloudShadow, Some(&c.map), visibility);
    }
    if available.detail != Detail::None {
        // The fragment measures its texels on the first of these that the draw has.
        let map = body.maps.albedo.as_ref().filter(|_| maps.albedo).or(body.maps.normal.as_ref().filter(|_| maps.normal));
        let (span, most) = detail::ground_deg_per_px(case.frame.camera, &case.placed.placement, map);
        let reason = format!("{}; a pixel spans {span:.4} degrees of the nearest ground against {most:.4}", detail::law(available.detail));
        so_far.chosen.detail = so_far.log.effect(Effect::Detail, span < most, reason);
    }
    so_far.chosen.maps = maps;
    so_far
}

/// Upper limit of the ratio of a light's glint on the sea to the radiance of ground: 1 / (4 times the waves' mean square slope and the cosine of a grazing
/// emission angle).
const GLINT_OVER_GROUND: f64 = 100.0;

/// Whether the glint of another body's light is visible if no sunlit ground is in view.
fn moonlit(case: &Case<'_, '_>) -> (bool, String) {
    let (p, least) = (case.placed, case.threshold());
    let shines = case.effects().override_of(Effect::PlanetShine) != Some(false);
    let strongest = lights::planet_shine(case.body(), p.position_km, case.frame.reflectors, |_| false).1.filter(|_| shines);
    let most = strongest.map_or(0.0, |(_, radiance)| radiance * GLINT_OVER_GROUND);
    (
        least.is_exceeded_by(most),
        format!("no sunlit ground is in sight; the glint of other bodies' light gives {} at most", least.description(most)),
    )
}

/// Margin beyond the terminator for the Sun's radius at Mercury and refraction, degrees.
const LIT_BEYOND_DEG: f64 = 2.0;

/// Whether sunlit ground is in view: the angular distances of the horizon from the sub-camera point and of the terminator from the sub-solar point together
/// exceed the angle between these points.
fn lit_ground(case: &Case<'_, '_>) -> (bool, String) {
    let (body, p) = (case.body(), case.placed);
    let seen_deg = (body.radii_km.min_element() / p.distance_km).min(1.0).acos().to_degrees();
    let (apart_deg, reach_deg) = (p.alpha.to_degrees(), 90.0 + seen_deg + LIT_BEYOND_DEG);
    (
        apart_deg < reach_deg,
        format!("the Sun stands {apart_deg:.1} degrees from the camera's zenith; lit ground is in sight up to {reach_deg:.1}"),
    )
}
