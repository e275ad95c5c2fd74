//! Diffuse light behind all bodies: the Milky Way or the user's panorama, and zodiacal light.
//!
//! In: the camera, the apparent Sun, the threshold, the panorama's frame and radiance. Out: [`SkyBackground`], the uniforms of
//! shaders/entry/sky_background.wesl, and the reasons. Always: the background is behind everything else; the draw of the air in front dims it; each of
//! the two parts is left out if it is below the threshold. Rotations are f64; only the view's axes are narrowed. Left out:
//! aberration of diffuse light (0.3 arcmin), its tint by air, and the parallax of the Milky Way.

use crate::catalog::NaifId;
use crate::message::{Reason, reason};
use crate::scene::camera::{Camera, narrow, narrow_scalar, narrow4};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::Threshold;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::frames::ecliptic_pole;
use crate::scene::sky::map::SkyMap;
use crate::scene::sky::zodiacal;
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::units::KM_PER_AU;
use glam::{DVec2, DVec3, DVec4, Vec3, Vec4};
use std::f64::consts::TAU;

/// Uniforms of the background.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyBackground {
    /// `None`: no panorama.
    pub map_file: Option<String>,
    /// View ray of depth 1 through the middle of the image, and its change from there to the right edge and to the upper edge. All directions of this struct
    /// are in the axes of the panorama's frame.
    pub middle: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// Radiance of the panorama's linear value 1; 0 if it is not drawn.
    pub map_radiance: f32,
    /// A second panorama, whose light is added to the first (`SkyMap::bright`), and the radiance of its linear value 1; 0 without it.
    pub bright_file: Option<String>,
    pub bright_radiance: f32,
    /// Mip level of the panorama.
    pub map_level: f32,
    /// `zodiacal::unit_radiance`, with the user's boost; 0 if zodiacal light is not drawn.
    pub zodiacal_radiance: f32,
    /// Unit vectors towards the Sun and the ecliptic's north pole.
    pub to_sun: Vec3,
    pub ecliptic_pole: Vec3,
    /// `zodiacal::LAW`.
    pub zodiacal_law: [Vec4; 5],
    /// `zodiacal::LOG_OFFSET`, and the cosines of `zodiacal::CORONA_BLEND_DEG`; see the shader.
    pub log_offset: f32,
    pub inner_cosine: f32,
    pub outer_cosine: f32,
    /// 1: zodiacal light fades out where the corona replaces it; 0: it continues up to the Sun.
    pub fades_into_corona: f32,
}

/// Number of rays along each side of the grid that samples the frame for its brightest zodiacal light.
const GRID_RAYS: u32 = 17;

/// The brightest zodiacal light in the frame, radiance.
fn brightest_zodiacal(camera: &Camera, to_sun: DVec3, unit_radiance: f64) -> f64 {
    // As in the shader: closer to the Sun the law keeps its value at the inner elongation.
    let (inner_deg, _) = zodiacal::CORONA_BLEND_DEG;
    let max_cosine = inner_deg.to_radians().cos();
    let clip = |k: u32| 2.0 * f64::from(k) / f64::from(GRID_RAYS - 1) - 1.0;
    let brightness_at = |k: u32| {
        let ray = camera.ray(DVec2::new(clip(k % GRID_RAYS), clip(k / GRID_RAYS))).normalize();
        zodiacal::brightness(ray.dot(to_sun).min(max_cosine), ray.dot(ecliptic_pole()))
    };
    (0..GRID_RAYS * GRID_RAYS).map(brightness_at).fold(0.0, f64::max) * unit_radiance
}

/// The background of a frame (`None` if neither of its parts is drawn) with the decisions about its parts; no background and no decisions in pixel views other
/// than the final image. `has_corona`: whether the frame draws the Sun's corona.
pub(crate) fn background(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    threshold: Threshold,
    map: &SkyMap,
    is_map_unreadable: bool,
    has_corona: bool,
) -> (Option<SkyBackground>, Vec<Decision>) {
    if request.pixel_view != PixelView::Final {
        return (None, Vec::new());
    }
    let boost = request.stars_boost_stops.exp2();
    let decided = |effect, on: bool, reason: Reason| Decision { effect, on, reason, stated_error: None };
    let comparison = |radiance: f64| match threshold.is_linear() {
        true => threshold.radiance_description(radiance),
        false => {
            let light = threshold.relative_to_white(radiance);
            reason!("of-white", light = format_args!("{light:.1e}"), threshold = format_args!("{VISIBLE_LIGHT:.1e}"))
        }
    };
    let max_map_radiance = map.brightest_radiance() * boost;
    let milky_way = if !request.layers.milky_way {
        decided("milky-way", false, reason!("set-by-you"))
    } else if is_map_unreadable {
        decided("milky-way", false, reason!("cannot-be-read", file = &map.file))
    } else {
        let light = comparison(max_map_radiance);
        let reason =
            if map.is_milky_way { reason!("milky-way-clouds", light = light) } else { reason!("milky-way-panorama", light = light) };
        decided("milky-way", threshold.is_exceeded_by_radiance(max_map_radiance), reason)
    };
    // Without a Sun its distance counts as 0, so no zodiacal light is drawn.
    let sun = placed.iter().find(|p| p.body.id == NaifId::SUN);
    let (to_sun, sun_au) = sun.map_or((DVec3::X, 0.0), |s| (s.placement.centre_km / s.distance_km, s.distance_km / KM_PER_AU));
    let zodiacal_unit = zodiacal::unit_radiance(sun_au.max(zodiacal::NEAREST_AU)) * boost;
    let max_zodiacal_radiance = brightest_zodiacal(camera, to_sun, zodiacal_unit);
    let zodiacal_light = if !request.layers.zodiacal_light {
        decided("zodiacal-light", false, reason!("set-by-you"))
    } else if sun_au < zodiacal::NEAREST_AU {
        decided("zodiacal-light", false, reason!("zodiacal-near-sun", distance = zodiacal::NEAREST_AU))
    } else {
        decided(
            "zodiacal-light",
            threshold.is_exceeded_by_radiance(max_zodiacal_radiance),
            reason!("zodiacal-at-most", light = comparison(max_zodiacal_radiance)),
        )
    };
    let (draws_map, draws_zodiacal) = (milky_way.on, zodiacal_light.on);
    let map_from_icrf = map.frame.icrf_from_frame().transpose();
    let texel_rad = TAU / f64::from(map.width);
    let axis = |v: DVec3| narrow(map_from_icrf * v);
    let (inner_deg, outer_deg) = zodiacal::CORONA_BLEND_DEG;
    let bright = map.bright.as_ref().filter(|_| draws_map);
    let background = SkyBackground {
        map_file: draws_map.then(|| map.file.clone()),
        middle: axis(camera.forward),
        right: axis(camera.right * camera.tan_half_fov.x),
        up: axis(camera.up * camera.tan_half_fov.y),
        map_radiance: narrow_scalar(if draws_map { map.unit_radiance * boost } else { 0.0 }),
        bright_file: bright.map(|b| b.file.clone()),
        bright_radiance: narrow_scalar(bright.map_or(0.0, |b| b.unit_radiance * boost)),
        map_level: narrow_scalar((camera.pixel_tangent() / texel_rad).log2().max(0.0)),
        zodiacal_radiance: narrow_scalar(if draws_zodiacal { zodiacal_unit } else { 0.0 }),
        to_sun: axis(to_sun),
        ecliptic_pole: axis(ecliptic_pole()),
        zodiacal_law: zodiacal::LAW.map(|row| narrow4(DVec4::from_array(row))),
        log_offset: narrow_scalar(zodiacal::LOG_OFFSET),
        inner_cosine: narrow_scalar(inner_deg.to_radians().cos()),
        outer_cosine: narrow_scalar(outer_deg.to_radians().cos()),
        // The corona is not boosted, so a blend from boosted zodiacal light into it would be visible: the zodiacal light then continues up to the Sun.
        fades_into_corona: if has_corona && request.stars_boost_stops == 0.0 { 1.0 } else { 0.0 },
    };
    ((draws_map || draws_zodiacal).then_some(background), vec![milky_way, zodiacal_light])
}
