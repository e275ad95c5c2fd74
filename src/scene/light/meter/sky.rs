//! Meters the sky of the body whose air surrounds the camera.
//!
//! In: the metered frame. Out: the sky as a subject; the *exposure radiances* of the sky and of the ground below it, for which images of them are exposed, and
//! which are equal near the ground; and how much darker surroundings are shown in dusk. From the sky's exposure radiance follow its weight and the contrast of
//! what is behind it; from the ground's, the light on the ground. Both are greater than the radiance that is drawn, the more so the darker the sky is
//! (`SurroundingAir::exposure_radiance`), so a darker sky is shown at a lower level. The subject states the radiance that is drawn in the frame's part of the
//! sky, and this level. Whatever else is in the frame, the exposure shows neither the mean of its sky nor the Sun's aureole too bright (`least_white_for_sky`).
//! Always: continuous in time (tests/atmosphere/dusk.rs) and in height (tests/atmosphere/top_of_air.rs); no sky is shown at a higher level because its light is
//! less (dusk.rs, with the camera at eye level).

use super::geometry::{angle_from_frame_rad, ray_and_limb, visible_fraction_behind_body};
use super::{FRAME_RAYS, LogMean, MeteredFrame, MeteredSubject};
use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::atmosphere::sky_in_view::LightOfSky;
use crate::scene::camera::Placement;
use crate::scene::light::exposure::{AUTO_EXPOSED_MEAN, CD_M2_PER_RADIANCE};
use crate::scene::light::lights;
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// Luminance of the sky around sunset, cd/m2. Below it, images of sky and ground are made darker by so many stops per factor of ten in luminance, up to a
/// maximum. The three values are judged by eye: photographers reduce the exposure by one stop in civil twilight, and by two to three at night. The moonlit
/// Earth seen from orbit is then drawn at 0.03 to 0.04 of white, as on photographs from the International Space Station, and its cities are crisp.
const SUNSET_SKY_CD_M2: f64 = 300.0;
const DUSK_STOPS_PER_DECADE: f64 = 0.6;
const MAX_DUSK_STOPS: f64 = 3.0;
/// Share of the frame from which on its light counts fully for the exposure of a sky near the top of the air.
const FULL_SKY_SHARE: f64 = 0.1;
/// Highest levels, as fractions of white, of the sky in the frame: of its mean without the aureole, and of the aureole [`AUREOLE_DEG`] from the Sun. In dusk
/// both are lowered by [`dusk_factor`]. Chosen: the meter exposes the sky by day for a table made for the Earth, which shows the mean of its sky at 0.1 to 0.3
/// of white. Dust that scatters forwards would be white around the Sun, as would be a sky over dark ground that is the target.
const MAX_SKY_LEVEL: f64 = 0.4;
const MAX_AUREOLE_LEVEL: f64 = 0.75;
/// Angle from the Sun, degrees, within which the aureole may be white.
const AUREOLE_DEG: f64 = 6.0;
/// Least radiance of a sky, far below that of any night. With 0, the subject's white (radiance / level) would be 0 / 0.
const MIN_SKY_RADIANCE: f64 = 1e-30;

/// Fractions of the sunlight in the air around the camera that the shadows of other bodies leave: 1 without an eclipse.
#[derive(Clone, Copy, Debug)]
pub(super) struct SunlightInAir {
    /// Of that which the frame's part of the sky scatters to the camera.
    pub frame: f64,
    /// Of that which the entire sky scatters to the ground.
    pub entire_sky: f64,
}

impl SunlightInAir {
    pub(super) const FULL: Self = Self { frame: 1.0, entire_sky: 1.0 };
}

/// Factor by which the target level of surroundings, sky or ground, is reduced: a photograph of dusk or night that is as bright as one of noon looks like day.
/// `radiance_per_sun`: their radiance, divided by the Sun's irradiance on the body relative to that at 1 au: far from the Sun a day is as dark as a dusk of
/// the Earth, but is shown as a day. The factor is 1 above [`SUNSET_SKY_CD_M2`]; below, it falls by [`DUSK_STOPS_PER_DECADE`] stops per factor of ten in
/// luminance, by at most [`MAX_DUSK_STOPS`].
pub(super) fn dusk_factor(radiance_per_sun: f64) -> f64 {
    // The limit of 1e-30 cd/m2 avoids a division by 0.
    let decades = (SUNSET_SKY_CD_M2 / (radiance_per_sun * CD_M2_PER_RADIANCE).max(1e-30)).log10().max(0.0);
    (-(DUSK_STOPS_PER_DECADE * decades).min(MAX_DUSK_STOPS)).exp2()
}

impl<'a> MeteredFrame<'_, 'a> {
    /// The body whose air surrounds the camera.
    fn body_with_air(&self) -> Option<&PlacedBody<'a>> {
        let air = self.meter.air?;
        self.meter.placed.iter().find(|p| p.body.id == air.body.id)
    }

    /// Irradiance of the Sun on the body whose air surrounds the camera, relative to that at 1 au; 1 without such air.
    pub(super) fn sun_irradiance_around_camera(&self) -> f64 {
        self.body_with_air().map_or(1.0, |p| lights::sunlight(p.body_to_sun_km).irradiance.x)
    }

    /// [`dusk_factor`] of the sky around the camera, less near the top of the air.
    fn dusk_factor_of_sky(&self, air: &SurroundingAir<'_>) -> f64 {
        dusk_factor(self.light.sky_exposure_radiance / self.sun_irradiance_around_camera()).powf(air.sky_weight())
    }

    /// The radiance for which images of the ground under the sky around the camera are exposed.
    pub(super) fn ground_exposure_radiance(&self) -> f64 {
        self.sum_over_lights_of_sky(self.light.sunlight_in_air.entire_sky, |air, light, irradiance| {
            air.exposure_radiance(light.towards, irradiance)
        })
    }

    /// The radiance for which images are exposed that show the sky around the camera as this frame does.
    pub(super) fn sky_exposure_radiance(&self) -> f64 {
        // Whether it is day or dusk depends on the Sun, also for the light of a moon.
        let Some(towards_sun) = self.body_with_air().map(|p| p.body_to_sun_km) else { return 0.0 };
        self.sum_over_lights_of_sky(self.light.sunlight_in_air.frame, |air, light, irradiance| {
            air.exposure_radiance_of_sky(light, irradiance, towards_sun)
        })
    }

    /// How much sunlight the shadows of other bodies leave to the sky around the camera. A sky dims in proportion to the sunlight until some thousandths are
    /// left, as measured up to an obscuration of 99.8 % (Sharp, Silverman and Lloyd 1971, Applied Optics 10, 1207); in totality its light comes from outside
    /// the umbra.
    pub(super) fn sunlight_in_air(&self) -> SunlightInAir {
        let (Some(air), Some(p)) = (self.meter.air, self.body_with_air()) else { return SunlightInAir::FULL };
        let eclipses_are_on = self.meter.context.request.effects.override_of_body(air.body, Effect::Eclipse) != Some(false);
        // `None`, so that nothing dims sunlight, if the user has switched eclipses off.
        let Some(sun) = self.meter.placed.iter().find(|s| s.body.id == NaifId::SUN && eclipses_are_on) else { return SunlightInAir::FULL };
        let (sun_radius_rad, sight_km) = (sun.angular_radius_rad(), air.sight_km());
        // A body hides a part of the Sun from some point of the air in sight, or nearly so.
        let casts_shadow_in_sight = |o: &&PlacedBody<'_>| {
            let separation_rad = crate::ephemeris::angle_rad(o.placement.centre_km, sun.placement.centre_km);
            let shift_rad = sight_km.atan2((o.distance_km - sight_km).max(0.0));
            separation_rad < o.angular_radius_rad() + sun_radius_rad + 2.0 * shift_rad
        };
        let is_in_front = |o: &&PlacedBody<'_>| o.body.id != air.body.id && o.body.id != NaifId::SUN && o.distance_km < sun.distance_km;
        let occluders: Vec<&PlacedBody<'_>> = self.meter.placed.iter().filter(is_in_front).filter(casts_shadow_in_sight).collect();
        if occluders.is_empty() {
            return SunlightInAir::FULL;
        }
        // Where several bodies cover the Sun, as if independently.
        let visible_sun = |offset_km: DVec3| {
            let towards_sun = (sun.placement.centre_km - offset_km).normalize();
            let seen = |o: &&PlacedBody<'_>| Placement { centre_km: o.placement.centre_km - offset_km, ..o.placement };
            occluders.iter().map(|o| visible_fraction_behind_body(&seen(o), towards_sun, sun_radius_rad)).product::<f64>()
        };
        let entire_sky: &[(DVec3, f64)] = &[];
        if self.light.sky_rays.is_empty() {
            // Without sky in the frame, its part is the entire sky.
            let [entire_sky] = air.light_left_in_shadow(p.body_to_sun_km, [entire_sky], visible_sun);
            return SunlightInAir { frame: entire_sky, entire_sky };
        }
        let [entire_sky, frame] = air.light_left_in_shadow(p.body_to_sun_km, [entire_sky, &self.light.sky_rays], visible_sun);
        SunlightInAir { frame, entire_sky }
    }

    /// The lights of the sky around the camera: first the Sun, then the body that gives the most light besides the Sun. Images show the light of one other body
    /// in the air. Empty without such a sky.
    pub(super) fn lights_of_sky(&self) -> Vec<LightOfSky> {
        let (Some(air), Some(p)) = (self.meter.air, self.body_with_air()) else { return Vec::new() };
        // Of planet-shine the green channel counts.
        let sunlight = (p.body_to_sun_km, self.sun_irradiance_on(p));
        let planet_shine = self.planet_shine_on(p).first().map(|l| (l.direction, l.irradiance.y));
        let lights = [sunlight].into_iter().chain(planet_shine);
        lights.map(|(towards, irradiance)| air.light_of_sky(towards, irradiance, &self.light.sky_rays)).collect()
    }

    /// A sum over the lights of the sky around the camera. An eclipse leaves `sunlight_fraction` of the sunlight. `by_light`: a function of the air, a light,
    /// and the irradiance that is left of it.
    fn sum_over_lights_of_sky(&self, sunlight_fraction: f64, by_light: impl Fn(&SurroundingAir<'_>, &LightOfSky, f64) -> f64) -> f64 {
        let Some((air, (sunlight, others))) = self.meter.air.zip(self.light.lights_of_sky.split_first()) else { return 0.0 };
        let by_sunlight = by_light(air, sunlight, sunlight.irradiance * sunlight_fraction);
        by_sunlight + others.first().map_or(0.0, |l| by_light(air, l, l.irradiance))
    }

    /// The rays of the frame that pass the limb of the body whose air surrounds the camera: ICRF, unit vectors, each with the part of it that is above the
    /// limb.
    pub(super) fn rays_above_limb(&self) -> Vec<(DVec3, f64)> {
        let Some(p) = self.body_with_air() else { return Vec::new() };
        // Angle between neighbouring rays along the frame's diagonal, in its middle.
        let spacing_rad = 2.0 * self.meter.camera.tan_half_fov.length() / f64::from(FRAME_RAYS);
        // `inside_rad` is negative above the limb. Around it, a ray's part above falls from 1 to 0 over one spacing.
        let part_above = |ray: DVec3| 1.0 - smoothstep(0.5 + ray_and_limb(&p.placement, ray).inside_rad / spacing_rad);
        let rays = self.sample_frame(|ray| (ray.normalize(), part_above(ray)));
        rays.into_iter().filter(|(_, part)| *part > 0.0).collect()
    }

    /// Fraction of the frame above the horizon of the body whose air surrounds the camera.
    pub(super) fn sky_fraction(&self) -> f64 {
        self.light.sky_rays.iter().map(|(_, part)| part).sum::<f64>() / f64::from(FRAME_RAYS * FRAME_RAYS)
    }

    /// The least radiance for which images are exposed that show the sky around the camera as this frame does: then it is not shown brighter than on the
    /// ground. Falls to 0 at the top of the air, and as the sky leaves the frame.
    pub(super) fn least_sky_exposure_radiance(&self) -> f64 {
        let part_of_frame = smoothstep(self.sky_fraction() / FULL_SKY_SHARE);
        let exposure_radiance = self.sum_over_lights_of_sky(self.light.sunlight_in_air.frame, |air, light, irradiance| {
            air.exposure_radiance_as_on_ground(light, irradiance)
        });
        part_of_frame * exposure_radiance
    }

    /// Meters the sky around the camera, without the share of the frame that bodies in the sky cover. The subject's weight follows from the exposure radiance,
    /// its white from this or from `least_radiance` ([`Self::least_sky_exposure_radiance`]); its `radiance` is the drawn one, the mean over the frame's sky.
    pub(super) fn sky(&self, share_of_bodies_in_sky: f64, least_radiance: f64) -> Option<MeteredSubject> {
        let air = self.meter.air?;
        let mut mean = LogMean::default();
        let no_foreground = 0.0;
        mean.add((self.sky_fraction() - share_of_bodies_in_sky).max(0.0), self.light.sky_exposure_radiance, no_foreground);
        // Darker in dusk; near the top of the air, where `sky_weight` is almost 0, not.
        let exposed_level = AUTO_EXPOSED_MEAN * self.dusk_factor_of_sky(air);
        let by_weight = mean.metered(reason!("subject-sky-of", body = &air.body.name), Some(air.body.id), exposed_level)?;
        let exposed = MeteredSubject { radiance: by_weight.radiance.max(least_radiance), ..by_weight };
        Some(with_drawn_radiance(exposed, self.sky_radiance_without_aureole(air) + self.aureole_radiance(air)))
    }

    /// What the Sun's aureole adds to the mean radiance of the frame's part of the sky.
    fn aureole_radiance(&self, air: &SurroundingAir<'_>) -> f64 {
        let Some(sunlight) = self.light.lights_of_sky.first() else { return 0.0 };
        let left = self.light.sunlight_in_air.frame;
        // It comes from air near the camera. In a deep eclipse that is darker than the sky in the mean, which has light from outside the shadow: so the part of
        // the sunlight that is left counts twice. While much of the Sun is visible, this makes the aureole too dark, by that part.
        sunlight.irradiance * left * left * air.mean_aureole(sunlight.towards, &self.light.sky_rays)
    }

    /// The mean radiance that is drawn in the frame's part of the sky, without the Sun's aureole.
    fn sky_radiance_without_aureole(&self, air: &SurroundingAir<'_>) -> f64 {
        let scattered =
            self.sum_over_lights_of_sky(self.light.sunlight_in_air.frame, |_, light, irradiance| light.scattered_radiance(irradiance));
        scattered + air.night_sky_radiance()
    }

    /// The least radiance that may be white, so that the sky in the frame is not brighter than [`MAX_SKY_LEVEL`] and [`MAX_AUREOLE_LEVEL`], whatever the image
    /// is exposed for; 0 without a sky. Falls to 0 as the sky leaves the frame.
    pub(super) fn least_white_for_sky(&self) -> f64 {
        let (Some(air), Some(sunlight)) = (self.meter.air, self.light.lights_of_sky.first()) else { return 0.0 };
        let part_of_frame = smoothstep(self.sky_fraction() / FULL_SKY_SHARE);
        if part_of_frame <= 0.0 {
            return 0.0;
        }
        // Of the sky in the frame, that nearest to the Sun is the brightest part of the aureole.
        let angle_deg = angle_from_frame_rad(self.meter.camera, sunlight.towards).to_degrees().max(AUREOLE_DEG);
        let aureole = sunlight.irradiance * self.light.sunlight_in_air.frame * air.radiance_above_light(sunlight.towards, angle_deg);
        part_of_frame / self.dusk_factor_of_sky(air)
            * (self.sky_radiance_without_aureole(air) / MAX_SKY_LEVEL).max(aureole / MAX_AUREOLE_LEVEL)
    }
}

/// The subject with the radiance that is drawn, and with the level of this radiance in an image that is exposed for the subject.
fn with_drawn_radiance(exposed: MeteredSubject, radiance: f64) -> MeteredSubject {
    let radiance = radiance.max(MIN_SKY_RADIANCE);
    MeteredSubject { radiance, target_level: radiance / exposed.white(), ..exposed }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The level falls with the luminance of sky and ground without a step, from day to night by three stops; half of it at 1 cd/m2.
    #[test]
    fn the_level_falls_steadily_from_day_to_night() {
        let at = |cd_m2: f64| dusk_factor(cd_m2 / CD_M2_PER_RADIANCE);
        assert_eq!((at(3e4), at(301.0), at(1e-3), at(0.0)), (1.0, 1.0, 0.125, 0.125));
        assert!((0.3..0.4).contains(&at(1.0)), "{}", at(1.0));
        let steps: Vec<f64> = (0..700).map(|k| 1e3 * 10.0_f64.powf(-0.01 * f64::from(k))).map(at).collect();
        assert!(steps.windows(2).all(|w| w[1] <= w[0] && (w[0] / w[1]).log2() < 0.0061), "{steps:?}");
    }

    /// The white stays that for which the image is exposed, also of a sky that has no light: NaN would spoil the exposure of the entire frame.
    #[test]
    fn the_drawn_radiance_does_not_change_the_white() {
        let (share, radiance, no_foreground) = (0.5, 0.01, 0.0);
        let mut mean = LogMean::default();
        mean.add(share, radiance, no_foreground);
        for drawn in [1e-3, 1e-9, 0.0] {
            let exposed = mean.metered("", None, 0.2).expect("a subject");
            let white = exposed.white();
            let metered = with_drawn_radiance(exposed, drawn);
            assert!((metered.white() / white - 1.0).abs() < 1e-12, "{drawn}: {metered:?}");
            assert!((metered.radiance - drawn).abs() <= MIN_SKY_RADIANCE, "{drawn}: {metered:?}");
        }
    }
}
