//! The light of the sky around the camera, and the radiance for which images of it are exposed.
//!
//! In: the air around the camera, a light, and the directions in which the frame shows the sky. Out: the mean radiance of the sky in these directions, and the
//! radiance for which the light meter exposes. The brightness of the sky by direction and height is that of `sky_brightness`. High in the air, after sunset, an
//! arch low above the place of the Sun is up to a hundred times as bright as the sky elsewhere: one mean over the entire sky would be far too bright for
//! most views.

use crate::ephemeris::angle_rad;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::atmosphere::sky_brightness::{SkyDome, luminance_above_light};
use crate::scene::numeric::smooth_rise;
use glam::{DVec3, FloatExt};

/// Altitudes of the Sun in degrees, each with the radiance for which images of ground and sky on the Earth are exposed, per irradiance of the Sun: the light
/// meter uses it in place of the sky's mean radiance: an image shows it at half of white (`AUTO_EXPOSED_MEAN`), or darker in dusk. A view from
/// the equator across the direction of the Sun, 30 degrees above the horizon, is shown at 0.09 of white by day, at 0.054 with the Sun 4 degrees below the
/// horizon, at 0.022, 0.013 and 0.0099 at 6, 8 and 12 degrees (tests/atmosphere/night_sky.rs), and at last by the limit of night photographs (`DARKEST_EV`):
/// the darker a sky, the darker it is shown. By day it is 4 times the true
/// mean, in dusk some 10 times. Between altitudes the logarithm of the radiance is linear.
const EXPOSURE_BY_ALTITUDE: [(f64, f64); 10] = [
    (-18.0, 1.2e-8),
    (-14.0, 6e-8),
    (-12.0, 4e-7),
    (-10.0, 4e-6),
    (-8.0, 4.6e-5),
    (-5.0, 1.5e-3),
    (0.0, 0.045),
    (5.0, 0.12),
    (30.0, 0.25),
    (90.0, 0.3),
];

/// [`EXPOSURE_BY_ALTITUDE`] at an altitude of the Sun on the Earth.
fn exposure_per_irradiance(altitude_on_earth_deg: f64) -> f64 {
    let table = &EXPOSURE_BY_ALTITUDE;
    let index_below = table.iter().rposition(|(deg, _)| *deg <= altitude_on_earth_deg).unwrap_or(0);
    let ((deg0, radiance0), (deg1, radiance1)) = (table[index_below.min(table.len() - 2)], table[(index_below + 1).min(table.len() - 1)]);
    let fraction = ((altitude_on_earth_deg - deg0) / (deg1 - deg0)).clamp(0.0, 1.0);
    (radiance0.ln() + fraction * (radiance1 / radiance0).ln()).exp()
}

/// Altitude of the Sun below which the sky high in the air is exposed as a dusk; half of this, in stops, at half of this altitude. A choice: the ground below
/// a camera that is half of the air's height above it is in full daylight until sunset, and an exposure for the dark sky above would make it white.
const DUSK_ALTITUDE_DEG: f64 = -5.0;

/// Angles from a light, degrees, at which its aureole is evaluated; between them it is interpolated.
const AUREOLE_ANGLES_DEG: [f64; 8] = [0.0, 2.5, 5.0, 8.0, 12.0, 17.0, 24.0, 36.0];
/// Angles between which the aureole gives way to the light of a [`SkyDome`], whose nearest rays are 22.5 degrees in azimuth from the light.
const AUREOLE_FADES_DEG: (f64, f64) = (22.5, 36.0);
/// Altitudes of a light, degrees, between which its aureole sets in. Of a light at the horizon most of it is in the lowest degrees of the sky.
const AUREOLE_SETS_IN_DEG: (f64, f64) = (0.0, 5.0);

/// Azimuth of a direction from that of a light, 0 to pi.
fn azimuth_from_light_rad(up: DVec3, direction: DVec3, towards: DVec3) -> f64 {
    let [direction, towards] = [direction, towards].map(|v| v - up * v.dot(up));
    angle_rad(direction, towards)
}

/// A light of the sky around the camera, with the brightness that it gives to some directions of this sky. Computed once for each light of a frame.
pub(crate) struct LightOfSky {
    /// Vector from the body to the light, ICRF, of any length.
    pub towards: DVec3,
    pub irradiance: f64,
    /// Mean luminance of the directions per irradiance, for a camera on the ground and for this one.
    luminance_on_ground: f64,
    luminance: f64,
}

impl LightOfSky {
    /// The mean radiance that the air scatters from this light in the directions, without the aureole and the light of the night sky: the channels weighted as
    /// for a luminance, but in units of radiance, not cd/m2. `irradiance`: of the light, less than its own in an eclipse.
    pub(crate) fn scattered_radiance(&self, irradiance: f64) -> f64 {
        irradiance * self.luminance
    }

    /// The part of their light on the ground that the directions have at the camera's height, at most 1: a sky that is brighter in high haze is exposed as on
    /// the ground.
    fn light_part(&self) -> f64 {
        (self.luminance / self.luminance_on_ground.max(f64::MIN_POSITIVE)).min(1.0)
    }
}

impl SurroundingAir<'_> {
    /// The radiance for which an image of ground under this sky is exposed: [`EXPOSURE_BY_ALTITUDE`] times the light's `irradiance` and
    /// [`SurroundingAir::sky_weight`]. That table is for the Earth. For a low light it is read at the altitude at which the Earth's sky is as dark, relative to
    /// its day, as this sky is relative to its own, because high haze stays lit long after sunset.
    /// `towards`: vector from the body to the light.
    pub(crate) fn exposure_radiance(&self, towards: DVec3, irradiance: f64) -> f64 {
        let altitude_deg = self.sky_brightness().altitude_on_earth_deg(self.altitude_deg(towards));
        self.sky_weight() * irradiance * exposure_per_irradiance(altitude_deg)
    }

    /// The radiance for which an image of the sky itself is exposed: on the ground, and at every height by day, [`Self::exposure_radiance`], so that the sky
    /// of a day darkens with height. In dusk, where nothing is lit but the sky, these directions have a part of the light that they have on the ground, and the
    /// exposure is that of a dusk with this part of the light, where this is less. The part may be small: most light of a dusk comes from air below the camera,
    /// and what is above it is in the shadow of the body except towards the Sun.
    /// Near the top of the air this falls faster than the light, so that it does not matter there ([`Self::sky_weight`]).
    /// `irradiance`: see [`LightOfSky::scattered_radiance`]; `towards_sun`: vector from the body to the Sun.
    pub(crate) fn exposure_radiance_of_sky(&self, light: &LightOfSky, irradiance: f64, towards_sun: DVec3) -> f64 {
        let (sky, altitude_deg) = (self.sky_brightness(), self.altitude_deg(light.towards));
        let dusk = (self.altitude_deg(towards_sun) / DUSK_ALTITUDE_DEG).clamp(0.0, 1.0);
        let [undimmed, dimmed] =
            [1.0, light.light_part().powf(dusk)].map(|part| exposure_per_irradiance(sky.altitude_of_dimmed_sky_deg(altitude_deg, part)));
        let per_irradiance = exposure_per_irradiance(sky.altitude_on_earth_deg(altitude_deg));
        irradiance * per_irradiance * (dimmed / undimmed).min(self.sky_weight())
    }

    /// The radiance for which an image of the sky is exposed that shows it as bright as on the ground. `irradiance`: see [`LightOfSky::scattered_radiance`].
    pub(crate) fn exposure_radiance_as_on_ground(&self, light: &LightOfSky, irradiance: f64) -> f64 {
        let altitude_deg = self.sky_brightness().altitude_on_earth_deg(self.altitude_deg(light.towards));
        irradiance * exposure_per_irradiance(altitude_deg) * light.light_part()
    }

    /// The radiance of the sky at an angle above a light, per irradiance of the light, as in [`LightOfSky::scattered_radiance`]. `towards`: vector from the
    /// body to the light.
    pub(crate) fn radiance_above_light(&self, towards: DVec3, angle_deg: f64) -> f64 {
        let height_km = self.height_part() * self.air.top_km;
        luminance_above_light(self.air, self.body.radii_km.x, height_km, self.altitude_deg(towards), angle_deg)
    }

    /// What the aureole around a light adds to the mean radiance of directions ([`LightOfSky::scattered_radiance`]), per irradiance of the light. In each it is
    /// that above the light at the same angle. `directions`: see [`Self::light_of_sky`]. From noon until sunset on Mars, sky and aureole in views of 20 to 80
    /// degrees around the Sun are 0.8 to 1.25 times as bright as drawn; without the aureole, 0.3 to 0.8.
    pub(crate) fn mean_aureole(&self, towards: DVec3, directions: &[(DVec3, f64)]) -> f64 {
        let (altitude_deg, up) = (self.altitude_deg(towards), self.up());
        let set_in = smooth_rise(AUREOLE_SETS_IN_DEG, altitude_deg);
        let with_angle_deg =
            directions.iter().map(|(direction, weight)| (*direction, *weight, angle_rad(*direction, towards).to_degrees()));
        let near: Vec<(DVec3, f64, f64)> = with_angle_deg.filter(|(.., angle_deg)| *angle_deg < AUREOLE_FADES_DEG.1).collect();
        if set_in <= 0.0 || near.is_empty() {
            return 0.0;
        }
        let by_angle = AUREOLE_ANGLES_DEG.map(|angle_deg| self.radiance_above_light(towards, angle_deg));
        let dome: SkyDome = self.sky_brightness().dome(altitude_deg, self.height_part());
        let added = |(direction, weight, angle_deg): (DVec3, f64, f64)| {
            let next = AUREOLE_ANGLES_DEG.partition_point(|deg| *deg <= angle_deg).clamp(1, AUREOLE_ANGLES_DEG.len() - 1);
            let (from_deg, to_deg) = (AUREOLE_ANGLES_DEG[next - 1], AUREOLE_ANGLES_DEG[next]);
            let luminance = by_angle[next - 1].lerp(by_angle[next], (angle_deg - from_deg) / (to_deg - from_deg));
            let of_dome = dome.luminance(direction.dot(up), azimuth_from_light_rad(up, direction, towards));
            weight * (1.0 - smooth_rise(AUREOLE_FADES_DEG, angle_deg)) * (luminance - of_dome).max(0.0)
        };
        let total_weight: f64 = directions.iter().map(|(_, weight)| weight).sum();
        set_in * near.into_iter().map(added).sum::<f64>() / total_weight
    }

    /// A light of this sky. `towards`: vector from the body to the light; `directions`: of the sky, ICRF, unit vectors, each with its weight in the mean; if
    /// there are none, the mean over the entire sky.
    pub(crate) fn light_of_sky(&self, towards: DVec3, irradiance: f64, directions: &[(DVec3, f64)]) -> LightOfSky {
        let on_ground = 0.0;
        let [luminance_on_ground, luminance] = self.mean_luminances([on_ground, self.height_part()], towards, directions);
        LightOfSky { towards, irradiance, luminance_on_ground, luminance }
    }

    /// The mean luminances of directions per irradiance of a light, for cameras at two heights, fractions of the air's height.
    fn mean_luminances(&self, height_parts: [f64; 2], towards: DVec3, directions: &[(DVec3, f64)]) -> [f64; 2] {
        let (sky, altitude_deg) = (self.sky_brightness(), self.altitude_deg(towards));
        if directions.is_empty() {
            return height_parts.map(|part| sky.luminance(altitude_deg, part));
        }
        let (domes, up) = (height_parts.map(|part| sky.dome(altitude_deg, part)), self.up());
        let (mut sums, mut total_weight) = ([0.0; 2], 0.0);
        for (direction, weight) in directions {
            let azimuth_rad = azimuth_from_light_rad(up, *direction, towards);
            for (sum, dome) in sums.iter_mut().zip(&domes) {
                *sum += weight * dome.luminance(direction.dot(up), azimuth_rad);
            }
            total_weight += weight;
        }
        sums.map(|sum| sum / total_weight)
    }
}
