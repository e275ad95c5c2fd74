//! The ground of a body: its shape and its maps.

use crate::scene::atmosphere::clouds;
use crate::scene::draw::features::MapSet;
use crate::scene::features::case::{Case, Decided};
use crate::scene::features::choice::{Capabilities, flattening};
use crate::scene::light::night_lights;
use crate::scene::request::effects::Effect;
use crate::scene::surface::detail;

/// Ground that a pixel may span for relief to show: slopes average out over more.
const RELIEF_DEG_PER_PX: f64 = 2.5;
/// Disc at which the Sun's glint, some 20 degrees of ground, covers a pixel.
const GLINT_DIAMETER_PX: f64 = 8.0;

/// Decides whether the body's oblateness shows, and which of its maps.
pub(crate) fn decide<'c>(case: &Case<'c, '_>, mut so_far: Decided<'c>) -> Decided<'c> {
    let (body, least, diameter_px) = (case.body(), case.bound(), case.diameter_px);
    let log = &mut so_far.log;
    let available = Capabilities::of(body);
    let lean = flattening(body);
    let bound = format!("its normals lean {lean:.2e} rad from a sphere's against {:.2e}", least.least_part());
    so_far.chosen.ellipsoid = available.ellipsoid && log.effect(Effect::Ellipsoid, least.counts_part(lean), bound);
    if !available.ellipsoid {
        log.note(Effect::Ellipsoid.name(), false, "its axes are equal".into());
    }
    let albedo = log.map(Effect::Albedo, body.maps.albedo.as_ref(), || (true, format!("a disc of {diameter_px:.1} px is drawn")));
    let mut maps = MapSet { albedo, ..MapSet::default() };
    if available.emissive {
        log.note("lights", false, "it emits light".into());
        so_far.chosen.maps = maps;
        return so_far;
    }
    let ground_per_px = case.ground_deg_per_px();
    maps.normal = log.map(Effect::Normal, body.maps.normal.as_ref(), || {
        let on = ground_per_px < RELIEF_DEG_PER_PX || least.is_linear();
        (on, format!("a pixel spans {ground_per_px:.2} degrees of ground against {RELIEF_DEG_PER_PX}"))
    });
    maps.specular = log.map(Effect::Specular, body.maps.specular.as_ref(), || {
        let on = diameter_px > GLINT_DIAMETER_PX || least.is_linear();
        (on, format!("{diameter_px:.1} px across against {GLINT_DIAMETER_PX} for the Sun's glint"))
    });
    maps.night = log.map(Effect::Night, body.maps.night.as_ref(), || {
        let most = night_lights::brightest(body);
        (least.counts(most), format!("brightest city lights {}", least.description(most)))
    });
    if let Some(c) = &body.clouds {
        maps.cloud_shadow = log.map(Effect::CloudShadow, Some(&c.map), || clouds::shadow_bound(body, c, diameter_px, least));
    }
    if available.detail {
        let (span, most) =
            detail::ground_deg_per_px(case.frame.camera, &case.placed.placement, available.maps.albedo || available.maps.normal);
        let reason = format!("{}; a pixel spans {span:.4} degrees of the nearest ground against {most}", detail::LAW);
        so_far.chosen.detail = so_far.log.effect(Effect::Detail, span < most, reason);
    }
    so_far.chosen.maps = maps;
    so_far
}
