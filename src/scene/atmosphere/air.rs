//! The atmosphere of a body: when it is drawn, its uniforms, and its transmittance to light from beyond it.
//!
//! In: the catalog's atmosphere of a body. Out: whether and with which model it is drawn; transmittance and brightness of the air around the camera; uniforms
//! of one gas with Rayleigh's phase function, one aerosol (haze) and one absorption layer; lengths are in equatorial radii, in the frame where the ground is
//! the unit sphere. The light along a ray is integrated in shaders/lib/air.

use crate::catalog::{Atmosphere, Body, Species};
use crate::message::{Reason, reason};
use crate::scene::atmosphere::extinction::{density, extinction, opacity_above, optical_depth, scattering};
use crate::scene::atmosphere::rim;
use crate::scene::atmosphere::sky_brightness::{SkyBrightness, SkyBrightnessCache};
use crate::scene::atmosphere::species::{absorption_layer, mie, rayleigh, vertical_optical_depth, vertical_scattering_depth};
use crate::scene::atmosphere::{height_above_unit_sphere, radius_sq_minus_1};
use crate::scene::camera::{self, Placement};
use crate::scene::draw::{AtmosphereModel, AtmosphereUniforms, DrawUniforms};
use crate::scene::light::exposure::CD_M2_PER_RADIANCE;
use crate::scene::numeric::smooth_rise;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::Threshold;
use crate::scene::request::view_request::Quality;
use crate::scene::thresholds::VISIBLE_CHANGE;
use glam::{DVec3, DVec4, Vec2, Vec3};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Fraction of scattered light that reaches the ground as skylight: Rayleigh scattering sends half downwards and half upwards.
const DOWNWARD_FRACTION: f64 = 0.5;
/// Mean luminance of the night's light from beyond the air: 75 S10 units, of which zodiacal light contributes 60 and starlight 15. One S10 unit, one star of
/// tenth magnitude per square degree, is 8.3e-7 cd/m2. With 145 units of airglow, the sum of 220 is the darkest sky of the Earth, 21.9 magnitudes per square
/// arc second. The luminance varies by a factor of two over the sky and between the planets, because zodiacal light is fainter farther from the Sun.
const LIGHT_FROM_BEYOND_CD_M2: f64 = 75.0 * 8.3e-7;

/// Radiances of the moonless night sky without city lights: airglow, and the mean of the light from beyond the air (zodiacal light and starlight); 0 for air
/// without optical depth.
fn night_radiances(air: &Atmosphere) -> [f64; 2] {
    if vertical_optical_depth(air).max_element() <= 0.0 {
        return [0.0; 2];
    }
    [air.airglow_cd_m2.unwrap_or(0.0), LIGHT_FROM_BEYOND_CD_M2].map(|luminance| luminance / CD_M2_PER_RADIANCE)
}

/// Radiance of the moonless night sky as it lights the ground.
pub(crate) fn night_radiance(air: &Atmosphere) -> f64 {
    night_radiances(air).iter().sum()
}

/// Sets the light of the night sky in a draw of the sky. In other draws `night_radiance` is the sum of that light ([`uniforms_of`]), which all falls on the
/// ground. In the sky's draw it is the airglow alone, because zodiacal light, Milky Way and stars are drawn behind the air by layers of their own;
/// `light_from_beyond` is all light from beyond the air, of which the shader takes the part that the air scatters. `fraction_above`: [`night_sky_above`].
pub(crate) fn set_night_sky(uniforms: &mut AtmosphereUniforms, air: &Atmosphere, fraction_above: f64) {
    let [airglow, from_beyond] = night_radiances(air).map(|radiance| camera::narrow_scalar(radiance * fraction_above));
    (uniforms.night_radiance, uniforms.light_from_beyond) = (airglow, from_beyond);
}

/// Integration steps of the transmittance towards a body beyond the air; the result is within 1e-4 of that of 1000 steps.
const TRANSMITTANCE_STEPS: usize = 64;

/// Every model that a draw of the body can have: for a body without air only [`AtmosphereModel::None`].
pub(crate) fn possible_models(body: &Body) -> BTreeSet<AtmosphereModel> {
    let drawn = AtmosphereModel::CHOICES.into_iter().filter(|_| body.atmosphere.is_some());
    drawn.chain([AtmosphereModel::None]).collect()
}

/// Numbers of samples along a ray, in a draw of the ground or the sky: first the smaller one, by day along rays that only rise or only fall, then the larger
/// one, along all other rays. They repeat QUADRATURE_NODES and AIR_SAMPLES of shaders/lib/air/sample_counts.wesl.
pub(crate) fn sample_counts(model: AtmosphereModel) -> (u32, u32) {
    match model {
        AtmosphereModel::None => (0, 0),
        AtmosphereModel::Vertex => (4, 5),
        AtmosphereModel::Pixel8 => (6, 8),
        AtmosphereModel::Pixel16 | AtmosphereModel::Table => (8, 16),
        AtmosphereModel::Pixel32 => (16, 32),
    }
}

/// Distance from the body's centre, in equatorial radii, within which draft quality includes multiple scattering. The fraction of the Earth's light that is
/// scattered more than once in the air is 14 % as seen from 3 radii, and up to 29 % in a view of the limb from 400 km (1.06 radii) or of a clear sky with a low
/// Sun (`orrery measure --choice air --choice air-near`). Draft quality may leave out up to 16 %, so the limit is between these distances.
const NEAR_RADII: f64 = 1.25;

/// Vertical optical depth that all channels must exceed for draft quality to include multiple scattering at any distance: about a fifth of the light of such
/// air is scattered more than once. In the catalog only the air of Titan (depth 2.6) and of Mars (0.5) exceeds it (tests/atmosphere/draft.rs). The giant
/// planets' air is thinner, because the colours of their maps already include their gas.
const THICK_DEPTH: f64 = 0.4;

/// Why draft quality includes multiple scattering, that is, uses [`AtmosphereModel::Table`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WhyTableInDrafts {
    /// The camera is in the air or near the body.
    Near,
    /// The air is thick.
    Thick,
}

/// Why draft quality includes multiple scattering, if it contributes enough light; `None` if draft quality leaves it out. `shell`: the top of the air.
pub(crate) fn why_table_in_drafts(placed: &PlacedBody<'_>, air: &Atmosphere, shell: &Placement) -> Option<WhyTableInDrafts> {
    if shell.camera_is_inside() || placed.distance_km < NEAR_RADII * placed.body.radii_km.max_element() {
        return Some(WhyTableInDrafts::Near);
    }
    is_thick(air).then_some(WhyTableInDrafts::Thick)
}

/// Whether the air is thicker than [`THICK_DEPTH`] in all channels.
fn is_thick(air: &Atmosphere) -> bool {
    vertical_optical_depth(air).min_element() > THICK_DEPTH
}

/// The model of the atmosphere, and why. Where the reason names two sample counts, the smaller applies to rays that only rise or only fall, by day.
/// `requested`: the user's choice; `None`: automatic. `why_in_drafts`: see [`why_table_in_drafts`].
pub(crate) fn model(
    requested: Option<AtmosphereModel>,
    quality: Quality,
    why_in_drafts: Option<WhyTableInDrafts>,
) -> (AtmosphereModel, Reason) {
    let model = requested.unwrap_or(match quality {
        Quality::Draft if why_in_drafts.is_none() => AtmosphereModel::Pixel8,
        _ => AtmosphereModel::Table,
    });
    let (few, many) = sample_counts(model);
    let reason = match (model, requested, why_in_drafts.filter(|_| quality == Quality::Draft)) {
        (AtmosphereModel::None, ..) => reason!("air-none"),
        (AtmosphereModel::Pixel8, None, _) => reason!("air-samples-draft", few = few, many = many),
        (AtmosphereModel::Table, None, Some(WhyTableInDrafts::Near)) => reason!("air-samples-table-near", few = few, many = many),
        (AtmosphereModel::Table, None, Some(WhyTableInDrafts::Thick)) => reason!("air-samples-table-thick", few = few, many = many),
        (AtmosphereModel::Table, Some(_), _) => reason!("air-samples-table-chosen", few = few, many = many),
        (AtmosphereModel::Table, None, None) => reason!("air-samples-table", few = few, many = many),
        _ => reason!("air-samples-chosen", few = few, many = many),
    };
    (model, reason)
}

/// Height of the camera above a body's ground: the height in the unit-sphere frame times the equatorial radius; 0 below the ground.
pub(crate) fn camera_height_km(body: &Body, placement: &Placement) -> f64 {
    ((placement.camera_in_unit_sphere().length() - 1.0) * body.radii_km.x).max(0.0)
}

/// Fraction of the air's vertical opacity that is below a camera at this height: 1 for a camera above the air. A fraction up to [`VISIBLE_CHANGE`] (tens of
/// metres on the Earth) cannot be seen and counts as exactly 0; from there the result rises continuously.
pub(crate) fn opacity_below(air: &Atmosphere, height_km: f64) -> f64 {
    if height_km >= air.top_km {
        return 1.0;
    }
    let below = 1.0 - opacity_above(air, height_km) / opacity_above(air, 0.0).max(1e-30);
    ((below - VISIBLE_CHANGE) / (1.0 - VISIBLE_CHANGE)).max(0.0)
}

/// Height of the camera, relative to the top of the air, from which the night sky fades: the Earth's airglow shines between 85 and 100 km, the top of its air.
const NIGHT_SKY_FADE_FROM: f64 = 0.85;

/// Height of the camera, relative to the top of the air, from which the light meter gives the daylight sky less and less weight.
const METERED_SKY_FADE_FROM: f64 = 0.5;

/// Natural logarithm of the weight that the light meter gives the daylight sky when the camera is at the top of the air: exp(-23) is 1e-10. In the meter's
/// average the daylight sky then counts less than a tenth of what the dark sky beyond the air counts, so that the exposure does not jump where the air ends.
const METERED_SKY_LOG_WEIGHT_AT_TOP: f64 = -23.0;

/// Fraction of the night sky's light that comes from above a camera at this height: 1 in most of the air, 0 above the air.
pub(crate) fn night_sky_above(air: &Atmosphere, height_km: f64) -> f64 {
    1.0 - smooth_rise((NIGHT_SKY_FADE_FROM, 1.0), height_km / air.top_km)
}

/// Fraction of sunlight that clear air scatters back upwards, in the channel where this is largest. Seen from above, the air counts as a surface with this
/// reflectance.
pub(crate) fn backscatter(air: &Atmosphere) -> f64 {
    (1.0 - DOWNWARD_FRACTION) * -(-vertical_scattering_depth(air).max_element()).exp_m1()
}

/// The placement of the top of the atmosphere: the ground's ellipsoid scaled up. `None` for a body without air.
pub(crate) fn shell(body: &Body, placement: &Placement) -> Option<Placement> {
    let air = body.atmosphere.as_ref()?;
    Some(Placement { radii_km: placement.radii_km * (1.0 + air.top_km / body.radii_km.x), ..*placement })
}

/// Largest fraction of light that the air removes along a vertical ray, over the channels.
pub(crate) fn max_removed_fraction(air: &Atmosphere) -> f64 {
    1.0 - (-vertical_optical_depth(air).max_element()).exp()
}

/// Whether the atmosphere can change the image, with the reason. `camera_is_inside`: the air. `diameter_px`: of the body's disc.
pub(crate) fn is_significant(
    body: &Body,
    air: &Atmosphere,
    camera_is_inside: bool,
    diameter_px: f64,
    threshold: Threshold,
) -> (bool, Reason) {
    if camera_is_inside {
        return (true, reason!("air-camera-inside", height = air.top_km));
    }
    let rim_px = rim::height_px(body, air, diameter_px);
    let change = max_removed_fraction(air);
    let change_text = threshold.change_description(change);
    let reason = reason!("air-rim", height = format_args!("{rim_px:.2}"), threshold = rim::ALWAYS_DRAWN_RIM_PX, light = change_text);
    // Air that dims the ground is drawn on discs of a pixel or more; smaller bodies are points.
    (rim_px >= rim::ALWAYS_DRAWN_RIM_PX || (threshold.is_exceeded_by_change(change) && diameter_px >= 1.0), reason)
}

/// Uniforms of the atmosphere above a floor, the ground or the cloud shell: the body's ellipsoid scaled by `floor_scale`, 1 for the ground. Lengths are in the
/// floor's equatorial radii.
pub(crate) fn uniforms(body: &Body, floor_scale: f64) -> AtmosphereUniforms {
    body.atmosphere.as_ref().map_or_else(AtmosphereUniforms::default, |air| uniforms_of(air, body.radii_km.x, floor_scale))
}

/// Like [`uniforms`], for air over a ground of this equatorial radius.
pub(crate) fn uniforms_of(air: &Atmosphere, ground_radius_km: f64, floor_scale: f64) -> AtmosphereUniforms {
    let floor_radius_km = ground_radius_km * floor_scale;
    let floor_height_km = floor_radius_km - ground_radius_km;
    let top_height = ((air.top_km - floor_height_km) / floor_radius_km).max(0.0);
    // A missing species gets the scale height of the other one, so that the quadrature fits the one that exists; without both it is 1.
    let scale_height = |s: Option<&Species>| camera::narrow_scalar(s.map_or(floor_radius_km, |s| s.scale_height_km) / floor_radius_km);
    let coefficient = |s: Option<&Species>, of_species: fn(&Species) -> DVec3| {
        // The catalog's coefficient is for a density of 1. The uniform is for the density at the floor or, of a triangular layer, for the density at its peak:
        // 1.
        let uniform_density = s.map_or(0.0, |s| if s.tent_centre_km.is_some() { 1.0 } else { density(s, floor_height_km) });
        camera::narrow(s.map_or(DVec3::ZERO, of_species) * uniform_density * floor_radius_km)
    };
    // A triangular layer has its peak at the height `tent_centre_km`; its `scale_height_km` is half its width.
    let triangle = absorption_layer(air).and_then(|s| Some((s.tent_centre_km? - floor_height_km, s.scale_height_km)));
    // Without a layer, edges in ascending order, so that nothing divides by 0; the layer's extinction is 0.
    let layer_edges = triangle.map_or(DVec3::new(1.0, 2.0, 3.0), |(centre_km, half_width_km)| {
        DVec3::new(centre_km - half_width_km, centre_km, centre_km + half_width_km) / floor_radius_km
    });
    AtmosphereUniforms {
        top_radius_sq_minus_1: camera::narrow_scalar(radius_sq_minus_1(top_height)),
        // `set_ends` sets them. Until then: for a camera above the air and rays to the ground.
        end_heights: Vec2::new(camera::narrow_scalar(top_height), 0.0),
        rayleigh_scale_height: scale_height(rayleigh(air).or(mie(air))),
        rayleigh_scattering: coefficient(rayleigh(air), scattering),
        rayleigh_extinction: coefficient(rayleigh(air), extinction),
        // Of the light that the air removes, the fraction that it scatters down to the ground.
        skylight_fraction: camera::narrow(
            DOWNWARD_FRACTION * vertical_scattering_depth(air) / vertical_optical_depth(air).max(DVec3::splat(1e-30)),
        ),
        mie_scale_height: scale_height(mie(air).or(rayleigh(air))),
        mie_phase_parameters: camera::narrow4(
            mie(air).and_then(Species::aerosol_phase).map_or(DVec4::ZERO, |phase| phase.parameters().into()),
        ),
        mie_scattering: coefficient(mie(air), scattering),
        mie_extinction: coefficient(mie(air), extinction),
        absorption_layer: camera::narrow(layer_edges.map(radius_sq_minus_1)),
        absorption_extinction: coefficient(absorption_layer(air), extinction),
        optical_depth_above_ground: Default::default(),
        // `scene::features` sets these two.
        blend_mode: 0.0,
        map_weight: 0.0,
        night_radiance: camera::narrow_scalar(night_radiance(air)),
        light_from_beyond: 0.0,
        // Irradiance by another body's light relative to the Sun's; `scene::features` sets it.
        second_light_irradiance: Vec3::ZERO,
        // Of the sky's draw; `decision` sets it.
        rim_is_thin: 0.0,
        // Accepted errors of interpolation in the coarse image; `air_pass::set_error_bounds` sets them.
        max_coarse_error: Vec2::ZERO,
        coarse_first_row: 0.0,
        // (x, y): (height above the floor + x) * y is the height above the ground as a fraction of the height of the multiple-scattering table, that is, of the
        // top of the air.
        multi_scatter_heights: camera::narrow(DVec3::new(floor_height_km / floor_radius_km, floor_radius_km / air.top_km, 0.0)).truncate(),
        multi_scatter: Arc::default(),
    }
}

/// The far end of rays that only rise or only fall: the ground, or in a draw of the sky the top of the atmosphere.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum FarEnd {
    Ground,
    Top,
}

/// Sets the heights of the ends of rays that only rise or only fall. The near end is the camera, or the top of the atmosphere if the camera is above it (an
/// anchor that is not the camera means that the camera is far from the body).
pub(crate) fn set_ends(uniforms: &mut DrawUniforms, far_end: FarEnd) {
    // `height_above_unit_sphere` in f32.
    let height = |radius_sq_minus_1: f32| radius_sq_minus_1 / (1.0 + (1.0 + radius_sq_minus_1).sqrt());
    let top = height(uniforms.air.top_radius_sq_minus_1);
    let camera = if uniforms.anchor_is_camera > 0.5 { height(uniforms.anchor_radius_sq_minus_1.max(0.0)).min(top) } else { top };
    let far = match far_end {
        FarEnd::Ground => 0.0,
        FarEnd::Top => top,
    };
    uniforms.air.end_heights = Vec2::new(camera, far);
}

/// The atmosphere around the camera.
pub(crate) struct SurroundingAir<'a> {
    pub body: &'a Body,
    pub(super) air: &'a Atmosphere,
    pub(super) placement: Placement,
    skies: &'a SkyBrightnessCache,
}

/// A transmittance divided by its mean over the channels.
pub(super) fn tint_of(transmittance: DVec3) -> DVec3 {
    let mean = transmittance.element_sum() / 3.0;
    // Where practically no light passes: red, with a mean of 1.
    if mean > 1e-12 { transmittance / mean } else { DVec3::new(3.0, 0.0, 0.0) }
}

impl<'a> SurroundingAir<'a> {
    /// `None` if the camera is not in the body's air.
    pub(crate) fn of(body: &'a Body, placement: &Placement, skies: &'a SkyBrightnessCache) -> Option<Self> {
        let air = body.atmosphere.as_ref()?;
        // A camera inside the body, such as one at its centre, sees neither the body nor its air.
        if placement.camera_is_inside() {
            return None;
        }
        shell(body, placement)?.camera_is_inside().then_some(Self { body, air, placement: *placement, skies })
    }

    /// Tint of light from beyond the air, for objects that are drawn before the air: transmittance per channel divided by its mean. The draw of the sky is
    /// blended over them and dims them by the mean. Light from many directions gets its tints from `atmosphere::tint_table`. `direction`: towards the light,
    /// ICRF.
    pub(crate) fn tint(&self, direction: DVec3) -> DVec3 {
        tint_of(self.transmittance(direction))
    }

    /// Unit vector at the camera, away from the body's centre.
    pub(crate) fn up(&self) -> DVec3 {
        -self.placement.centre_km.normalize()
    }

    /// Whether the air is dense enough for a daylight sky.
    pub(crate) fn is_bright(&self) -> bool {
        vertical_optical_depth(self.air).max_element() > VISIBLE_CHANGE
    }

    /// Weight of the sky's light for the light meter: 1 in the lower half of the air, and 1e-10 at its top, above which the meter ignores the sky. The weight's
    /// logarithm, and with it the exposure, changes gradually. For comparison, 80 km above the Earth the weight is 2.5e-4, and gas and sky have about 2e-5 of
    /// their density and light at the ground.
    pub(crate) fn sky_weight(&self) -> f64 {
        // 0 where the fading begins, 1 at the top.
        let fade_position = ((self.height_part() - METERED_SKY_FADE_FROM) / (1.0 - METERED_SKY_FADE_FROM)).max(0.0);
        (METERED_SKY_LOG_WEIGHT_AT_TOP * fade_position * fade_position).exp()
    }

    /// Height of the camera as a fraction of the air's height.
    pub(super) fn height_part(&self) -> f64 {
        camera_height_km(self.body, &self.placement) / self.air.top_km
    }

    /// The brightness of the body's sky; computed when it is first needed.
    pub(super) fn sky_brightness(&self) -> Arc<SkyBrightness> {
        self.skies.of(self.air, self.body.radii_km.x)
    }

    /// Altitude of a light above the horizon of the camera, degrees. `towards`: vector from the body to the light, ICRF, of any length.
    pub(super) fn altitude_deg(&self, towards: DVec3) -> f64 {
        self.up().dot(towards.normalize()).clamp(-1.0, 1.0).asin().to_degrees()
    }

    /// The radiance of the moonless night sky as its draw has it: airglow, and the scattered light from beyond the air.
    pub(crate) fn night_sky_radiance(&self) -> f64 {
        let height_km = camera_height_km(self.body, &self.placement);
        let [airglow, from_beyond] = night_radiances(self.air);
        night_sky_above(self.air, height_km) * (airglow + from_beyond * opacity_above(self.air, height_km))
    }

    /// Transmittance to light from beyond the air, the mean of the channels. `direction`: towards the light, ICRF.
    pub(crate) fn mean_transmittance(&self, direction: DVec3) -> f64 {
        self.transmittance(direction).element_sum() / 3.0
    }

    /// Transmittance to light from beyond the air, per channel, for objects that are drawn after the air. `direction`: towards the light, ICRF. Where a ray
    /// runs through the ground, the air is taken to have its density at the ground.
    pub(crate) fn transmittance(&self, direction: DVec3) -> DVec3 {
        let radius_km = self.body.radii_km.x;
        let along = self.placement.direction_in_unit_sphere(direction).normalize();
        let km_per_unit = (along * self.placement.radii_km).length();
        // Positions on the ray are counted from its point nearest to the centre.
        let camera = self.placement.camera_in_unit_sphere();
        let start = camera.dot(along);
        let nearest_sq_minus_1 = camera.length_squared() - 1.0 - start * start;
        let end = (radius_sq_minus_1(self.air.top_km / radius_km) - nearest_sq_minus_1).max(0.0).sqrt();
        // Steps are shortest at the camera, where a rising ray meets the densest air; the depth of a ray that first descends is less accurate.
        let depth = optical_depth(self.air, (end - start) * km_per_unit, TRANSMITTANCE_STEPS, |s_km| {
            let s = start + s_km / km_per_unit;
            let radius_sq_minus_1 = (nearest_sq_minus_1 + s * s).max(0.0);
            height_above_unit_sphere(radius_sq_minus_1) * radius_km
        });
        (-depth).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use glam::DMat3;

    #[test]
    fn the_zenith_has_the_vertical_depth_and_the_low_sun_is_red() {
        let catalog = Catalog::embedded();
        let earth = catalog.body(crate::catalog::NaifId(399)).expect("the Earth");
        let up = DVec3::X;
        let place = Placement { centre_km: -up * (earth.radii_km.x + 0.002), body_from_icrf: DMat3::IDENTITY, radii_km: earth.radii_km };
        let skies = SkyBrightnessCache::default();
        let around = SurroundingAir::of(earth, &place, &skies).expect("two metres up is in the air");
        let to_zenith = around.transmittance(up);
        let expected = (-vertical_optical_depth(earth.atmosphere.as_ref().expect("air"))).exp();
        assert!((to_zenith - expected).abs().max_element() < 2e-3, "{to_zenith} for {expected}");
        // A direction on the horizon: `up` is the x axis.
        let low_sun = around.tint(DVec3::new(0.0, 1.0, 0.01));
        assert!(low_sun.x > 2.0 && low_sun.y < 0.9 && low_sun.z < 0.01, "{low_sun}");
        let far = Placement { centre_km: -up * 1e6, ..place };
        assert!(SurroundingAir::of(earth, &far, &skies).is_none());
        let centre = Placement { centre_km: DVec3::ZERO, ..place };
        assert!(SurroundingAir::of(earth, &centre, &skies).is_none());
    }

    /// The air of Titan and that of Mars with its dust are thick. Drafts use the table only in thick air or near a body, standard quality
    /// always.
    #[test]
    fn the_air_of_titan_and_of_mars_is_thick() {
        let catalog = Catalog::embedded();
        let thick = catalog.bodies().iter().filter(|b| b.atmosphere.as_ref().is_some_and(is_thick)).map(|b| b.name.as_str());
        assert_eq!(thick.collect::<Vec<_>>(), ["Mars", "Titan"]);
        let not_requested = None;
        let model_of = |quality, why_in_drafts| model(not_requested, quality, why_in_drafts).0;
        for why_in_drafts in [None, Some(WhyTableInDrafts::Near), Some(WhyTableInDrafts::Thick)] {
            let expected = if why_in_drafts.is_some() { AtmosphereModel::Table } else { AtmosphereModel::Pixel8 };
            assert_eq!(model_of(Quality::Draft, why_in_drafts), expected);
            assert_eq!(model_of(Quality::Standard, why_in_drafts), AtmosphereModel::Table);
        }
    }

    /// On the ground, and 1.7 m above it, none of the air counts as below the camera, at the top all; in between the part grows and does not jump: by less than
    /// 0.15 per hundredth of the height. The light of the night sky above the camera decreases only from 0.85 of the height on.
    #[test]
    fn the_air_below_the_camera_grows_from_nothing_to_all() {
        let catalog = Catalog::embedded();
        for body in catalog.bodies() {
            let Some(air) = body.atmosphere.as_ref() else { continue };
            let at = |part: f64| opacity_below(air, part * air.top_km);
            assert_eq!([opacity_below(air, 0.0017), at(1.0), at(1.1)], [0.0, 1.0, 1.0], "{}", body.name);
            assert!((1.0 - at(1.0 - 1e-6)).abs() < 1e-6, "{}", body.name);
            let steps = (0..100).map(|k| at(0.01 * f64::from(k + 1)) - at(0.01 * f64::from(k)));
            let [least, greatest] = steps.fold([1.0_f64, 0.0], |[least, greatest], s| [least.min(s), greatest.max(s)]);
            assert!(least >= 0.0 && greatest > 0.0 && greatest < 0.15, "{}: {least} to {greatest}", body.name);
            let night = |part: f64| night_sky_above(air, part * air.top_km);
            assert!([night(0.0), night(0.85), night(1.0)] == [1.0, 1.0, 0.0] && night(0.9) < 1.0, "{}", body.name);
        }
    }

    #[test]
    fn sample_counts_are_those_of_the_shaders() {
        let wesl = include_str!("../../../shaders/lib/air/sample_counts.wesl");
        let conditions =
            [("vertex", AtmosphereModel::Vertex), ("pixel_8", AtmosphereModel::Pixel8), ("pixel_32", AtmosphereModel::Pixel32)];
        for (condition, model) in conditions {
            let (few, many) = sample_counts(model);
            assert!(wesl.contains(&format!("@if(air_{condition}) const AIR_SAMPLES = {many}u;")), "{condition}");
            assert!(wesl.contains(&format!("@if(!surface_cloud && air_{condition}) const QUADRATURE_NODES = {few}u;")), "{condition}");
        }
        let (few, many) = sample_counts(AtmosphereModel::Table);
        assert!(wesl.contains(&format!("@if(air_pixel_16 || air_table) const AIR_SAMPLES = {many}u;")));
        assert!(wesl.contains(&format!("@if(!surface_cloud && (air_pixel_16 || air_table)) const QUADRATURE_NODES = {few}u;")));
    }

    #[test]
    fn every_atmosphere_of_the_catalog_has_valid_uniforms() {
        let catalog = Catalog::embedded();
        for body in catalog.bodies().iter().filter(|b| b.atmosphere.is_some()) {
            let (ground_scale, raised_floor_scale) = (1.0, 1.002);
            let a = uniforms(body, ground_scale);
            // Above a raised floor there is less air, and its top is nearer.
            let above = uniforms(body, raised_floor_scale);
            assert!(
                above.top_radius_sq_minus_1 < a.top_radius_sq_minus_1
                    && above.rayleigh_scattering.max_element() <= a.rayleigh_scattering.max_element(),
                "{}",
                body.name
            );
            assert!(a.top_radius_sq_minus_1 > 0.0 && a.rayleigh_scale_height > 0.0 && a.mie_scale_height > 0.0, "{}", body.name);
            assert!(a.absorption_layer.x < a.absorption_layer.y && a.absorption_layer.y < a.absorption_layer.z, "{}", body.name);
            for c in 0..3 {
                assert!(
                    a.rayleigh_extinction[c] >= a.rayleigh_scattering[c] && a.mie_extinction[c] >= a.mie_scattering[c],
                    "{}",
                    body.name
                );
                assert!((0.0..=0.5 + 1e-6).contains(&a.skylight_fraction[c]), "{}", body.name);
            }
        }
    }
}
