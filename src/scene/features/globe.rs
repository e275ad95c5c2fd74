//! The uniforms shared by all draws of a body's globe and of the shells around it.
//!
//! In: the inputs of the decisions about a body, the placement and the rectangle of the draw, its maps, and its lights besides the Sun. Out: [`DrawUniforms`].
//! Not here: uniforms of eclipse, rings and overlays, which [`super::decide`] sets.

use crate::catalog::{Body, Map, NaifId, Photometry};
use crate::scene::atmosphere::{air, clouds};
use crate::scene::camera::{self, AnchorForm, Camera, ClipRect};
use crate::scene::draw::features::{MapSet, PixelView};
use crate::scene::draw::uniforms::{DrawUniforms, EclipseUniforms, Light};
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::DecisionInputs;
use crate::scene::light::city_lights;
use crate::scene::light::disc_light;
use crate::scene::light::lights::{self, IncidentLight};
use crate::scene::request::effects::Effect;
use crate::scene::surface::{crescent, detail};
use crate::scene::thresholds::NIGHT_MAP_WHITE_RADIANCE;
use glam::DVec3;

/// Mean square slope of the sea's waves in a wind of 5 m/s (Cox and Munk 1954: 0.003 + 0.00512 per m/s).
const WAVE_SLOPE_SQ: f64 = 0.0286;

/// The uniforms of a draw of the globe, or of a shell that has its own placement.
pub(crate) fn uniforms(
    inputs: &DecisionInputs<'_, '_>,
    placement: &camera::Placement,
    rect: ClipRect,
    maps: MapSet,
    secondary_lights: &[IncidentLight],
) -> DrawUniforms {
    uniforms_of_fraction(inputs, placement, rect, maps, secondary_lights, inputs.drawn_fraction())
}

/// Lower limit of the widths of pixels on a body's ground, as fractions of its circumference; 0 for a body with a shape model, parts of which are nearer than
/// the ellipsoid.
fn min_pixel_width(camera: &Camera, placement: &camera::Placement, body: &Body) -> f64 {
    if body.mesh.is_some() {
        return 0.0;
    }
    let no_map = None;
    let (deg_per_px_below_camera, _limit) = detail::ground_deg_per_px(camera, placement, no_map);
    // At an angle a from the axis of the image a pixel spans cos^2 a times the angle that it spans on the axis, or more.
    deg_per_px_below_camera / 360.0 / (1.0 + camera.tan_half_fov.length_squared())
}

/// The factor on the colour of a draw that shows a body's light times `light_factor`; both factors are linear RGB. For a body that shines by itself the result
/// is `light_factor`. For others it is 1: the lights that fall on them are dimmed instead. Dimmed lights also dim the glint and the light scattered by
/// air, which do not depend on the colour.
pub(crate) fn colour_factor(body: &Body, light_factor: DVec3) -> DVec3 {
    if matches!(body.photometry, Photometry::Emissive { .. }) { light_factor } else { DVec3::ONE }
}

/// The factor by which the atmosphere around the camera reddens the light of a body outside it (see [`air::SurroundingAir::tint`]), linear RGB; 1 without such
/// an atmosphere.
pub(crate) fn tint(inputs: &DecisionInputs<'_, '_>) -> DVec3 {
    inputs.frame.air.filter(|a| a.body.id != inputs.body().id).map_or(DVec3::ONE, |a| a.tint(inputs.placed.placement.centre_km))
}

/// Like [`uniforms`], but for a draw that shows `fraction` of the body's light.
pub(crate) fn uniforms_of_fraction(
    inputs: &DecisionInputs<'_, '_>,
    placement: &camera::Placement,
    rect: ClipRect,
    maps: MapSet,
    secondary_lights: &[IncidentLight],
    fraction: f64,
) -> DrawUniforms {
    let (camera, placed, body) = (inputs.frame.camera, inputs.placed, inputs.body());
    let light_factor = tint(inputs) * fraction;
    let rays = camera.view_rays(placement, rect, AnchorForm::Auto);
    let gain = |map: &Option<Map>| map.as_ref().map_or(DVec3::ONE, |m| DVec3::from_array(m.gain));
    let is_emissive = matches!(body.photometry, Photometry::Emissive { .. });
    let reflectance = match (maps.albedo, is_emissive) {
        (true, _) => gain(&body.maps.albedo),
        (false, true) => body.colour.as_dvec3(),
        (false, false) => body.colour.as_dvec3() * body.geometric_albedo,
    };
    let (u1, u2) = limb_darkening(body);
    let photometric_parameter = match body.photometry {
        Photometry::LunarLambert { lunar_weight } => lunar_weight,
        Photometry::OrenNayar { roughness_deg } => roughness_deg.to_radians().powi(2),
        _ => 0.0,
    };
    // The albedo includes the phase correction for sunlight. Light from another body has a different phase angle, so its irradiance is multiplied by the ratio
    // of the two corrections.
    let sun_phase_correction = placed.phase_brightness();
    let phase_ratio = |l: &IncidentLight| {
        let phase_angle_rad = crate::ephemeris::angle_rad(l.direction, -placed.placement.centre_km);
        disc_light::phase_correction(body, phase_angle_rad, placed.distance_km / body.radii_km.x) / sun_phase_correction.max(1e-6)
    };
    let irradiance_factor = |l: &IncidentLight| {
        if inputs.pixel_view() == PixelView::Sunlight {
            // This view shows the irradiance of the ground, which depends neither on the phase angle nor on what is between the ground and the camera.
            DVec3::ONE
        } else if l.from == NaifId::SUN {
            light_factor
        } else {
            light_factor * phase_ratio(l)
        }
    };
    let to_body_frame = |l: &IncidentLight| Light {
        direction_in_body: camera::narrow((placed.body_from_icrf * l.direction).normalize()),
        irradiance: camera::narrow(l.irradiance * irradiance_factor(l)),
    };
    let lights = if is_emissive {
        Vec::new()
    } else {
        std::iter::once(&lights::sunlight(placed.body_to_sun_km)).chain(secondary_lights).map(to_body_frame).collect()
    };
    let shows_clouds = inputs.effects().override_of(Effect::Clouds) != Some(false);
    // Clouds hide a part of the glint.
    let glint_factor =
        if shows_clouds { disc_light::glint_factor(body, placed.phase_angle_rad, placed.distance_km / body.radii_km.x) } else { 1.0 };
    let floor_scale = 1.0;
    let mut uniforms = DrawUniforms {
        axis_ratios: camera::narrow(body.radii_km / body.radii_km.x),
        albedo: camera::narrow(reflectance * placed.radiance_scale() * colour_factor(body, light_factor)),
        lights,
        photometric_parameter: camera::narrow_scalar(photometric_parameter),
        limb_darkening_u1: camera::narrow(u1),
        limb_darkening_u2: camera::narrow(u2),
        averaged_part: camera::narrow_scalar(crescent::averaged_part(inputs.diameter_px, placed.phase_angle_rad)),
        map_stretch: camera::narrow2(body.map_stretch()),
        map_pixel: camera::narrow_scalar(min_pixel_width(camera, placement, body)),
        camera_height: camera::narrow_scalar(placement.camera_in_unit_sphere().length() - 1.0),
        night_radiance: camera::narrow(gain(&body.maps.night) * NIGHT_MAP_WHITE_RADIANCE * light_factor * city_lights::factor(placed)),
        specular_strength: camera::narrow_scalar(gain(&body.maps.specular).x * glint_factor),
        wave_slope_sq: camera::narrow_scalar(WAVE_SLOPE_SQ),
        normal_strength: camera::narrow_scalar(gain(&body.maps.normal).x),
        clouds: clouds::uniforms(body),
        eclipse: EclipseUniforms::default(),
        air: air::uniforms(body, floor_scale),
        camera_in_unit_sphere: rays.camera_in_unit_sphere,
        pixel_size: camera.clip_per_pixel(),
        detail: detail::uniforms(BodyCapabilities::of(body).detail, camera, placement, &rays),
        ..DrawUniforms::of_rays(&rays)
    };
    air::set_ends(&mut uniforms, air::FarEnd::Ground);
    uniforms
}
