//! The light that a body's ground reflects towards the camera, for the light meter.
//!
//! In: a placed body, its lights, the effects of the request. Out: radiance at points of the ground, computed with the mean albedo of the whole planet, clouds
//! included, and with its bright and dark sides, as the harmonics of its map give them. Exception: if the body's map shows the ground alone
//! (`clear_sky_albedo`), the mean over the ground and the air in front of it is used, unless the camera is above drawn clouds or the disc is small. Between the
//! two albedos the change is smooth. Near the camera, ground brighter than the mean counts with a part of its brightness (`bright_ground`).

use crate::catalog::{Body, InventedRelief, Map};
use crate::scene::atmosphere::air;
use crate::scene::constants::MAX_RELIEF_DIP;
use crate::scene::draw::tables::RingShine;
use crate::scene::eclipse::approximate_shadow::ApproximateShadow;
use crate::scene::light::bright_ground::BrightGround;
use crate::scene::light::night_lights::{self, NightLights};
use crate::scene::light::{disc_light, photometry};
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::point::drawn_disc_fraction;
use crate::scene::request::effects::{Effect, EffectOverrides};
use glam::{DVec3, FloatExt};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Heights of the camera, relative to that of the clouds, between which the logarithm of the albedo changes smoothly from that of the ground and air alone to
/// that of the whole planet. The clouds come into view all at once when the camera rises through them. If the exposure were still that of the ground then, a
/// closed deck would be a white area without detail. So the exposure changes before, which only darkens the ground during the last few hundred metres.
const GROUND_TO_PLANET_CLOUD_HEIGHTS: (f64, f64) = (0.9, 1.0);

/// Irradiance of level ground by a clear sky, divided by the radiance that the light meter takes for that sky (`SurroundingAir::exposure_radiance`). An
/// estimate without a source, within a factor of 1.5 by day; in twilight the ratio is smaller. The estimate gives some 13 klx under a high Sun (the Sun
/// itself gives 128 klx), and 4 klx for a Sun at an altitude of 5 degrees.
const CLEAR_SKY_IRRADIANCE_PER_RADIANCE: f64 = 0.3;

/// Root mean square, in one direction, of the slope (rise over run) of the relief that the meter assumes on ground without air: that of the Moon's map of
/// normals times its gain, 0.067 to the east and 0.065 to the north (tests/image/shipped_maps.rs). Under a low Sun slopes that face it have several times
/// the light of smooth ground, which would have none from a Sun below the horizon. For altitudes of the Sun from -2 to 8 degrees the metered radiance is within
/// a factor of 5 of the mean over a dozen places of the Moon's drawn ground; single places scatter more: after sunset level ones have no sunlight.
pub const RELIEF_SLOPE_RMS: f64 = 0.066;
/// Slopes towards the Sun by which the meter represents the relief, as multiples of [`RELIEF_SLOPE_RMS`]: the middles of seven equal parts of a normal
/// distribution, scaled to a root mean square of 1.
const RELIEF_SLOPES: [f64; 7] = [-1.608, -0.869, -0.402, 0.0, 0.402, 0.869, 1.608];
/// For ground under a higher Sun, sine of its altitude, the slopes fade to 0: there they change the light by less than a third.
const SLOPES_FADE_SINES: (f64, f64) = (0.3, 0.5);
/// Steepest slope in the mean for the light of other bodies: slopes evenly distributed up to it have the same root mean square.
const MAX_RELIEF_SLOPE: f64 = 1.732 * RELIEF_SLOPE_RMS;
/// Height of the camera, in radii of the body, at which the weight of invented relief has fallen to 0: it is drawn where the ground is magnified.
const RELIEF_HEIGHT_RADII: f64 = 0.02;

/// Height of the camera, in radii of the body, at which the weight of bright ground has fallen to 0. From higher up the frame shows ground of all kinds, unless
/// its field of view is narrow.
const BRIGHT_GROUND_HEIGHT_RADII: f64 = 0.1;

/// The part of the metered light of ground and clouds that images show, where clouds are drawn over a map of the bare ground: that of the Earth by phase angle
/// in degrees, the mean over a rotation seen from 60 radii, measured on drawn discs (tests/scene/metered_light.rs compares). The Earth is metered with its
/// published albedo, because white clouds on a dark sea need a darker image than their mean: with the drawn light as the mean, the clouds would be white areas.
/// At large phase angles air and glint, which are drawn in full, give most of the light; on the thinnest crescents the meter gives ground and air too much.
const DRAWN_PART_WITH_CLOUDS: [(f64, f64); 13] = [
    (0.0, 0.475),
    (30.0, 0.463),
    (60.0, 0.434),
    (90.0, 0.453),
    (105.0, 0.526),
    (120.0, 0.713),
    (135.0, 0.938),
    (150.0, 1.32),
    (155.0, 1.4),
    (160.0, 1.28),
    (165.0, 0.62),
    (170.0, 0.125),
    (175.0, 0.02),
];

/// [`DRAWN_PART_WITH_CLOUDS`] at a phase angle.
fn drawn_part_with_clouds(phase_angle_rad: f64) -> f64 {
    let (table, phase_deg) = (&DRAWN_PART_WITH_CLOUDS, phase_angle_rad.to_degrees());
    let next = table.partition_point(|(deg, _)| *deg <= phase_deg).clamp(1, table.len() - 1);
    let ((from_deg, part), (to_deg, next_part)) = (table[next - 1], table[next]);
    part.lerp(next_part, ((phase_deg - from_deg) / (to_deg - from_deg)).clamp(0.0, 1.0))
}

/// How much the clouds that are drawn hide the ground from the camera, 0 to 1: see [`GROUND_TO_PLANET_CLOUD_HEIGHTS`].
fn cloudiness(p: &PlacedBody<'_>, effects: &EffectOverrides) -> f64 {
    let clouds = p.body.clouds.as_ref().filter(|_| effects.override_of_body(p.body, Effect::Clouds) != Some(false));
    clouds.map_or(0.0, |c| smooth_rise(GROUND_TO_PLANET_CLOUD_HEIGHTS, air::camera_height_km(p.body, &p.placement) / c.height_km))
}

/// Weight of bright ground in the metered radiance, from 0 (all ground is metered as the mean) to 1.
pub(crate) fn bright_ground_weight(p: &PlacedBody<'_>, effects: &EffectOverrides) -> f64 {
    let height_radii = air::camera_height_km(p.body, &p.placement) / p.body.radii_km.x;
    (1.0 - smoothstep(height_radii / BRIGHT_GROUND_HEIGHT_RADII)) * (1.0 - cloudiness(p, effects))
}

/// Weight of relief in the radiance of a body's ground, from 0 (smooth ground) to 1. Relief counts if the ground is drawn with a map of normals or with
/// procedural relief. `far_weight`: 1 for a camera so far away that half of the globe is in view, most of it under a higher Sun; there relief does not count.
pub(crate) fn relief_weight(p: &PlacedBody<'_>, effects: &EffectOverrides, far_weight: f64) -> f64 {
    let body = p.body;
    let is_on = |effect: Effect| effects.override_of_body(body, effect) != Some(false);
    let is_mapped = body.maps.normal.is_some() && is_on(Effect::Normal);
    let is_invented = body.invented_relief != InventedRelief::None && is_on(Effect::Detail);
    // Beyond the terminator the ground has more light from air than from the Sun on its slopes.
    let has_air = body.atmosphere.is_some() || body.clouds.is_some();
    if has_air || !(is_mapped || is_invented) {
        return 0.0;
    }
    let near = 1.0 - far_weight;
    let of_invented = 1.0 - smoothstep(air::camera_height_km(body, &p.placement) / body.radii_km.x / RELIEF_HEIGHT_RADII);
    if is_mapped { near } else { near * of_invented }
}

/// Cosine of incidence on a slope towards the light, from the cosine on smooth ground, times the factor by which `horizon_factor` of
/// shaders/lib/reflected.wesl reduces the light of a low Sun, for the greatest height of relief: not at all from a `cos_smooth` of [`MAX_RELIEF_DIP`] on, to
/// nothing at -[`MAX_RELIEF_DIP`].
fn cosine_on_slope(cos_smooth: f64, slope: f64) -> f64 {
    let above_horizon = (0.5 + 0.5 * cos_smooth / MAX_RELIEF_DIP).clamp(0.0, 1.0);
    let on_slope = (cos_smooth + slope * (1.0 - cos_smooth * cos_smooth).max(0.0).sqrt()) / slope.hypot(1.0);
    on_slope.max(0.0) * above_horizon
}

/// The albedo map whose bright and dark sides count, if it is drawn. Not that of a body whose map shows its ground alone, without its clouds.
pub(crate) fn map_of_sides<'b>(body: &'b Body, effects: &EffectOverrides) -> Option<&'b Map> {
    let is_drawn = effects.override_of_body(body, Effect::Albedo) != Some(false);
    body.maps.albedo.as_ref().filter(|_| is_drawn && body.clear_sky_albedo.is_none())
}

/// Mean cosine of incidence on relief, from the cosine on smooth ground: the mean of max(0, `cos_smooth` + slope) over slopes towards the light that are evenly
/// distributed from -[`MAX_RELIEF_SLOPE`] to +[`MAX_RELIEF_SLOPE`]. The mean is reduced as in [`cosine_on_slope`].
fn mean_cosine_on_relief(cos_smooth: f64) -> f64 {
    if cos_smooth.abs() >= MAX_RELIEF_SLOPE {
        return cos_smooth.max(0.0);
    }
    (cos_smooth + MAX_RELIEF_SLOPE).powi(2) / (4.0 * MAX_RELIEF_SLOPE) * (0.5 + 0.5 * cos_smooth / MAX_RELIEF_DIP).clamp(0.0, 1.0)
}

/// Factors from light to the radiance of a body's ground, brightest channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Albedo {
    /// For a light at the phase angle for which the albedo was computed: factor on irradiance times [`photometry::reflectance`].
    pub of_lights: f64,
    /// For skylight: factor on the radiance that the light meter takes for the sky (`SurroundingAir::exposure_radiance`). Over a whole planet the sky counts as
    /// uniform, so that its irradiance equals its radiance, and the factor is the geometric albedo. A clear sky's irradiance is only
    /// [`CLEAR_SKY_IRRADIANCE_PER_RADIANCE`] times its radiance.
    pub of_sky: f64,
    /// The ground's part of `of_lights`, 0 to 1; the rest is the air in front of it.
    pub ground_fraction: f64,
    /// See [`bright_ground_weight`].
    pub bright_ground_weight: f64,
    /// The part of `of_lights` that images show: [`DRAWN_PART_WITH_CLOUDS`], or 1.
    pub drawn_part: f64,
    /// The same at a phase angle of 90 degrees.
    pub drawn_part_at_terminator: f64,
}

impl Albedo {
    /// The albedo of what the camera sees of a body. `effects`: those of the request; `diameter_px`: of the body's disc; `phase_angle_rad`: of the light. The
    /// published phase law, part of the albedo, may give a thousandth for the Sun behind a new Moon, and almost 1 for the light of the Earth on it.
    pub(crate) fn of(p: &PlacedBody<'_>, effects: &EffectOverrides, diameter_px: f64, phase_angle_rad: f64) -> Self {
        let body = p.body;
        let is_off = |effect: Effect| effects.override_of_body(body, effect) == Some(false);
        let haze_factor = || disc_light::meter_gain_for_haze(body, phase_angle_rad, p.distance_km / body.radii_km.x);
        // One channel is enough: the channels of this scale differ only for emissive bodies.
        let of_model = photometry::albedo_normalisation(body).x * p.phase_brightness_of_light(phase_angle_rad);
        let scale = of_model * if is_off(Effect::Atmosphere) { 1.0 } else { haze_factor() };
        let whole = Self {
            of_lights: scale * body.geometric_albedo * f64::from(body.colour.max_element()),
            of_sky: body.geometric_albedo,
            ground_fraction: 1.0,
            bright_ground_weight: bright_ground_weight(p, effects),
            drawn_part: 1.0,
            drawn_part_at_terminator: 1.0,
        };
        let Some(clear_sky_albedo) = body.clear_sky_albedo else { return whole };
        let height_km = air::camera_height_km(body, &p.placement);
        let ground = scale * clear_sky_albedo * f64::from(body.clear_sky_colour.unwrap_or(body.colour).max_element());
        let air = body.atmosphere.as_ref().filter(|_| !is_off(Effect::Atmosphere));
        let air_light = air.map_or(0.0, |a| air::backscatter(a) * air::opacity_below(a, height_km));
        let clear_of_lights = ground + air_light;
        let clear_of_sky = CLEAR_SKY_IRRADIANCE_PER_RADIANCE * ground;
        // A body drawn as a point has the light of the whole planet.
        let (cloudiness, disc_fraction) =
            (cloudiness(p, effects), drawn_disc_fraction(effects.override_of_body(body, Effect::Points), p, diameter_px));
        let weight = (1.0 - cloudiness) * disc_fraction;
        let drawn_part = |phase_angle_rad: f64| drawn_part_with_clouds(phase_angle_rad).powf(cloudiness * disc_fraction);
        let blend = |whole: f64, clear: f64| whole.powf(1.0 - weight) * clear.powf(weight);
        Self {
            of_lights: blend(whole.of_lights, clear_of_lights),
            of_sky: blend(whole.of_sky, clear_of_sky),
            // Without any light of the ground the fraction does not matter.
            ground_fraction: ground / clear_of_lights.max(f64::MIN_POSITIVE),
            drawn_part: drawn_part(phase_angle_rad),
            drawn_part_at_terminator: drawn_part(FRAC_PI_2),
            ..whole
        }
    }

    /// Irradiance times albedo.
    pub(crate) fn lit_by(&self, irradiance: f64) -> GroundRadiance {
        let metered = self.of_lights * irradiance;
        GroundRadiance { metered, drawn: metered * self.drawn_part }
    }

    /// The radiance of air over the ground in twilight. Images show all of it; it is metered as the ground is by day beside it, so that the level does not rise
    /// at sunset.
    pub(crate) fn twilight(&self, radiance: f64) -> GroundRadiance {
        GroundRadiance { metered: radiance / self.drawn_part_at_terminator, drawn: radiance }
    }

    /// Factors on `of_lights` and on `of_sky` at ground that is metered as `relative` times as bright as ground of mean reflectance.
    fn local_factors(&self, relative: f64) -> [f64; 2] {
        [1.0 + self.ground_fraction * (relative - 1.0), relative].map(|factor| factor.powf(self.bright_ground_weight))
    }
}

/// Radiance of ground: as it counts for the exposure, and as images show it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundRadiance {
    pub metered: f64,
    pub drawn: f64,
}

impl GroundRadiance {
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { metered: self.metered * factor, drawn: self.drawn * factor }
    }

    /// Light that counts as it is drawn.
    pub(crate) fn as_drawn(radiance: f64) -> Self {
        Self { metered: radiance, drawn: radiance }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { metered: self.metered + other.metered, drawn: self.drawn + other.drawn }
    }
}

/// A body's ground with all lights on it: the inputs of the ground's radiance.
pub(crate) struct Ground<'g> {
    pub body: &'g Body,
    /// City lights; `None` if the body has none, or if their weight is 0.
    pub night_lights: Option<&'g NightLights>,
    /// Factor on the radiance of the night map: the weight of city lights, times the part that a camera at this height sees.
    pub city_light_weight: f64,
    /// For sunlight and skylight.
    pub albedo: Albedo,
    /// See [`map_of_sides`].
    pub albedo_map: Option<&'g Map>,
    /// Ground brighter than the mean; `None` if all ground is metered as the mean.
    pub bright_ground: Option<&'g BrightGround>,
    /// See [`relief_weight`].
    pub relief_weight: f64,
    /// Unit vector towards the Sun, body axes.
    pub sun: DVec3,
    pub sun_irradiance: f64,
    /// Planet-shine: unit vector towards each body that gives it, body axes; [`Albedo::lit_by`] its irradiance, for its phase angle.
    pub secondary_lights: Vec<(DVec3, GroundRadiance)>,
    /// Radiance that the light meter takes for the sky above the ground, if the camera is in the body's air; else 0.
    pub sky_exposure_radiance: f64,
    /// The table of ring-shine relative to the Sun's irradiance, and the ground's radiance where this ratio is 1; `None` where ring-shine does not count:
    /// without rings, if only the day side is visible, in a body drawn as a point, or if it is switched off.
    pub ring_shine: Option<(Arc<RingShine>, f64)>,
}

impl Ground<'_> {
    /// Calls `add` with each part of the ground at a point, as a fraction, and its radiance: one part, or one for each slope of the relief where that matters.
    /// Arguments: see [`Self::radiance`].
    pub(crate) fn for_each_slope(
        &self,
        [point, normal, viewer]: [DVec3; 3],
        shadow: Option<&ApproximateShadow<'_>>,
        ring_transmittance: f64,
        mut add: impl FnMut(f64, GroundRadiance),
    ) {
        let sin_altitude = normal.dot(self.sun);
        let steepness = RELIEF_SLOPE_RMS * (1.0 - smooth_rise(SLOPES_FADE_SINES, sin_altitude));
        let has_slopes = self.relief_weight > 0.0 && steepness > 0.0 && sin_altitude > -MAX_RELIEF_DIP;
        let slopes: &[f64] = if has_slopes { &RELIEF_SLOPES } else { &[0.0] };
        for slope in slopes {
            add(1.0 / slopes.len() as f64, self.radiance([point, normal, viewer], steepness * slope, shadow, ring_transmittance));
        }
    }

    /// Radiance of the ground at a point (unit-sphere frame) in the direction of the viewer. `[point, normal, viewer]`: the last two are unit vectors, body
    /// axes. `slope`: of the relief, towards the Sun. `shadow`: of other bodies, if any. `ring_transmittance`: the fraction of sunlight that the body's rings
    /// leave.
    fn radiance(
        &self,
        [point, normal, viewer]: [DVec3; 3],
        slope: f64,
        shadow: Option<&ApproximateShadow<'_>>,
        ring_transmittance: f64,
    ) -> GroundRadiance {
        let body = self.body;
        // `cos_on_relief`: the cosine of incidence on relief, from that on smooth ground.
        let reflectance = |towards: DVec3, cos_on_relief: &dyn Fn(f64) -> f64| {
            let cos_smooth = normal.dot(towards).max(0.0);
            let cos_incidence = cos_smooth + self.relief_weight * (cos_on_relief(normal.dot(towards)) - cos_smooth);
            // A positive cosine of emission, because `reflectance` is 0 at the limb.
            photometry::reflectance(&body.photometry, cos_incidence, normal.dot(viewer).max(1e-3), towards.dot(viewer))
        };
        let sunlight_fraction = match shadow {
            // Elsewhere the ground reflects no sunlight, so the fraction does not matter.
            Some(shadow) if normal.dot(self.sun) > 0.0 || self.relief_weight > 0.0 => {
                // From the unit-sphere frame to equatorial radii.
                shadow.brightest_sunlight_fraction(point * body.radii_km / body.radii_km.x).max(0.0)
            }
            _ => 1.0,
        };
        let sunlight = self.sun_irradiance * sunlight_fraction * ring_transmittance;
        let of_sun = self.albedo.lit_by(sunlight).times(reflectance(self.sun, &|cos| cosine_on_slope(cos, slope)));
        let of_secondary = |(towards, light): &(DVec3, GroundRadiance)| light.times(reflectance(*towards, &mean_cosine_on_relief));
        let by_lights = self.secondary_lights.iter().map(of_secondary).fold(of_sun, GroundRadiance::plus);
        let night_weight = night_lights::lit_fraction(normal.dot(self.sun)) * self.city_light_weight;
        let night_lights = self.night_lights.map_or(0.0, |l| if night_weight > 0.0 { night_weight * l.radiance_at(point) } else { 0.0 });
        let ring_shine = self.ring_shine.as_ref().map_or(0.0, |(shine, radiance)| radiance * shine.irradiance(point, self.sun));
        let [lights_factor, sky_factor] =
            self.bright_ground.map_or([1.0; 2], |map| self.albedo.local_factors(map.relative_radiance(point)));
        let relative_albedo = self.albedo_map.map_or(1.0, |map| photometry::relative_albedo(map, point));
        let others = sky_factor * self.albedo.of_sky * self.sky_exposure_radiance + night_lights + ring_shine;
        by_lights.times(relative_albedo * lights_factor).plus(GroundRadiance::as_drawn(others))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relief is lit up to 2.9 degrees beyond the terminator (the arc sine of 0.05), and changes nothing where the Sun is higher than its slopes. There is no
    /// jump: over a step of 1e-4 the mean cosine changes by less than three steps.
    #[test]
    fn relief_is_lit_beyond_the_terminator() {
        let at = |deg: f64| mean_cosine_on_relief(deg.to_radians().sin());
        assert_eq!((at(-2.9), at(-90.0)), (0.0, 0.0));
        // The formula gives 0.0041.
        assert!(at(-1.5) > 0.002 && at(-1.5) < 0.02, "{}", at(-1.5));
        for deg in [10.0, 30.0, 90.0] {
            assert_eq!(at(deg), f64::to_radians(deg).sin());
        }
        let steps =
            (-2000..2000).map(|k| (mean_cosine_on_relief(1e-4 * f64::from(k + 1)) - mean_cosine_on_relief(1e-4 * f64::from(k))).abs());
        assert!(steps.fold(0.0, f64::max) < 3e-4);
    }

    /// The slopes have a mean of 0 and a root mean square of 1; their mean light is that of the mean cosine within a quarter where the Sun is at 2 degrees or
    /// more, and the slopes that face it most have some three times the light of smooth ground at 3 degrees.
    #[test]
    fn slopes_stand_for_the_relief() {
        let count = RELIEF_SLOPES.len() as f64;
        let moment = |power: i32| RELIEF_SLOPES.iter().map(|slope| slope.powi(power)).sum::<f64>() / count;
        assert!(moment(1).abs() < 1e-12 && (moment(2) - 1.0).abs() < 2e-3, "{} {}", moment(1), moment(2));
        let on_slope = |deg: f64, slope: f64| cosine_on_slope(deg.to_radians().sin(), RELIEF_SLOPE_RMS * slope);
        for deg in [2.0, 3.0, 6.0, 12.0] {
            let mean = RELIEF_SLOPES.iter().map(|slope| on_slope(deg, *slope)).sum::<f64>() / count;
            let ratio = mean / mean_cosine_on_relief(deg.to_radians().sin());
            assert!((ratio - 1.0).abs() < 0.25, "{deg} degrees: {ratio}");
        }
        let brightest = on_slope(3.0, 1.608) / f64::to_radians(3.0).sin();
        assert!((2.5..5.0).contains(&brightest), "{brightest}");
        assert_eq!(on_slope(-3.0, 1.608), 0.0);
    }
}
