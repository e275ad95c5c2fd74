//! A reading of the light meter: everything in the frame once, and then the bodies with city lights once more.
//!
//! In: the light meter. Whether city lights count depends on the exposure without them, so they are added to a first reading. Out: [`MeterReading`], which
//! keeps what city lights do not change: the light in front of the bodies ([`FrameLight`]), the bodies without such lights, and all other subjects. Always: a
//! reading to which city lights were added is the same as if everything had been metered with them.

use super::highlights::Highlights;
use super::log_mean::LogMean;
use super::sky::{self, SunlightInAir};
use super::sun_glare::FrameGlare;
use super::{DARK_SKY_WEIGHT, Meter, MeteredFrame, MeteredSubject, TARGET_WEIGHT, area_px, far_weight};
use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::atmosphere::sky_in_view::LightOfSky;
use crate::scene::light::exposure::AUTO_EXPOSED_MEAN;
use crate::scene::light::glare::VeilingGlare;
use crate::scene::light::lights;
use crate::scene::placed::PlacedBody;
use glam::DVec3;

/// The light in front of the bodies and around the camera, an input of all parts of a reading.
pub(super) struct FrameLight {
    /// The Sun's glare as it would be without air; `None` if the Sun is far outside the image or the user switched the glare off.
    pub glare: Option<VeilingGlare>,
    /// Transmittance of the air in front of the Sun and its glare.
    pub sun_transmittance: f64,
    /// The rays of the frame that show the sky around the camera: [`MeteredFrame::rays_above_limb`].
    pub sky_rays: Vec<(DVec3, f64)>,
    pub sunlight_in_air: SunlightInAir,
    /// The lights of the sky around the camera: [`MeteredFrame::lights_of_sky`].
    pub lights_of_sky: Vec<LightOfSky>,
    /// The radiances for which images of the sky around the camera, and of the ground under it, are exposed; 0 without such a sky.
    pub sky_exposure_radiance: f64,
    pub ground_exposure_radiance: f64,
}

/// What the meter found in the frame.
pub(crate) struct MeterReading {
    pub subjects: Vec<MeteredSubject>,
    pub glare: FrameGlare,
    /// The least radiance that may be white ([`MeteredFrame::least_white_for_sky`]).
    pub least_white_for_sky: f64,
    /// The highlights among all bodies but the Sun.
    pub highlights: Highlights,
    light: FrameLight,
    /// The mean radiance of each body but the Sun, rings included, in the order of [`Meter::bodies`].
    means: Vec<LogMean>,
    /// The other subjects: Sun, corona, refracted limbs, comets, sky and dark sky.
    others: Vec<MeteredSubject>,
}

impl<'a> Meter<'_, 'a> {
    /// The placed bodies but the Sun.
    fn bodies(&self) -> impl Iterator<Item = &PlacedBody<'a>> {
        self.placed.iter().filter(|p| p.body.id != NaifId::SUN)
    }

    fn frame(&self, light: FrameLight) -> MeteredFrame<'_, 'a> {
        MeteredFrame { meter: self, light, resolved_bodies: self.placed.iter().filter(|p| area_px(self.camera, p) > 1.0).collect() }
    }

    /// Meters everything in the frame. `night_white`: the radiance that an image of the dark sky shows as white.
    pub(crate) fn read(&self, night_white: f64) -> MeterReading {
        let sun = self.placed.iter().find(|p| p.body.id == NaifId::SUN);
        let mut frame = self.frame(FrameLight {
            glare: VeilingGlare::unless_switched_off(self.context.request, self.camera, self.placed),
            sun_transmittance: self.air.zip(sun).map_or(1.0, |(air, sun)| air.mean_transmittance(sun.placement.centre_km)),
            sky_rays: Vec::new(),
            sunlight_in_air: SunlightInAir::FULL,
            lights_of_sky: Vec::new(),
            sky_exposure_radiance: 0.0,
            ground_exposure_radiance: 0.0,
        });
        // These read fields that are set before, and none that is set later.
        frame.light.sky_rays = frame.rays_above_limb();
        frame.light.sunlight_in_air = frame.sunlight_in_air();
        frame.light.lights_of_sky = frame.lights_of_sky();
        frame.light.sky_exposure_radiance = frame.sky_exposure_radiance();
        frame.light.ground_exposure_radiance = frame.ground_exposure_radiance();
        // A share of the frame.
        let (mut means, mut share_of_bodies_in_sky) = (Vec::new(), 0.0);
        for p in self.bodies() {
            let (mean, share) = frame.body_with_rings(p);
            // The ground of the body whose air surrounds the camera is below the horizon and covers nothing of the sky.
            if self.air.is_none_or(|a| a.body.id != p.body.id) {
                share_of_bodies_in_sky += share;
            }
            means.push(mean);
        }
        let limb_lights = sun.map(|sun| self.limb_lights(sun)).unwrap_or_default();
        let around_sun = [frame.sun(&limb_lights), frame.corona(), frame.outer_corona(), frame.refracted_limbs(&limb_lights)];
        let mut others: Vec<MeteredSubject> = around_sun.into_iter().chain([frame.comets()]).flatten().collect();
        frame.darken_in_dusk(&mut others);
        let least_sky_radiance = frame.least_sky_exposure_radiance();
        others.extend(frame.sky(share_of_bodies_in_sky, least_sky_radiance));
        others.push(MeteredSubject {
            name: reason!("subject-dark-sky").into(),
            body: None,
            radiance: least_sky_radiance.max(night_white * AUTO_EXPOSED_MEAN),
            target_level: AUTO_EXPOSED_MEAN,
            weight: DARK_SKY_WEIGHT,
            drawn_part: 1.0,
            is_of_bodies: false,
        });
        let subjects = frame.subjects(&means, &others);
        let least_white_for_sky = frame.least_white_for_sky();
        let highlights = highlights_of(&means);
        MeterReading { subjects, glare: frame.frame_glare(), least_white_for_sky, highlights, light: frame.light, means, others }
    }

    /// The reading with city lights: `reading` is one of the same frame without them. The share of the frame that a body covers does not depend on them.
    pub(crate) fn add_city_lights(&self, reading: MeterReading) -> MeterReading {
        let MeterReading { glare, least_white_for_sky, light, mut means, others, .. } = reading;
        let frame = self.frame(light);
        for (p, mean) in self.bodies().zip(&mut means) {
            if self.context.resources.night_lights.contains_key(&p.body.id) {
                (*mean, _) = frame.body_with_rings(p);
            }
        }
        let (subjects, highlights) = (frame.subjects(&means, &others), highlights_of(&means));
        MeterReading { subjects, glare, least_white_for_sky, highlights, light: frame.light, means, others }
    }
}

/// The highlights of all bodies together. Unlike in the mean, the target counts by its area alone.
fn highlights_of(means: &[LogMean]) -> Highlights {
    let mut all = Highlights::default();
    means.iter().for_each(|mean| all.merge(&mean.highlights));
    all
}

/// Factor on the target level of a body with the mean radiance `mean`: dark ground around or below the camera is shown as at night, from the ground as from
/// orbit. From afar a body is a subject before the sky, and shown as bright as any other, also in a shadow or in the light of a planet.
fn night_factor(p: &PlacedBody<'_>, mean: &LogMean) -> f64 {
    let nearness = 1.0 - far_weight(p);
    if nearness <= 0.0 || mean.weight <= 0.0 {
        return 1.0;
    }
    sky::dusk_factor(mean.radiance() / lights::sunlight(p.body_to_sun_km).irradiance.x).powf(nearness)
}

impl MeteredFrame<'_, '_> {
    /// The mean radiance of a body with its rings, and the body's share of the frame ([`Self::body`]).
    fn body_with_rings(&self, p: &PlacedBody<'_>) -> (LogMean, f64) {
        let (mut mean, share) = self.body(p);
        self.add_rings(p, &mut mean);
        (mean, share)
    }

    /// All subjects of the frame: the target, all other bodies as one subject, and `others`. `means`: of the bodies.
    fn subjects(&self, means: &[LogMean], others: &[MeteredSubject]) -> Vec<MeteredSubject> {
        let target = self.meter.context.request.target;
        let (mut mean_of_target, mut mean_of_others) = (LogMean::default(), LogMean::default());
        // `dominant`: of the bodies other than the target, the one with the greatest weight, which gives their common subject its name.
        let (mut target_name, mut dominant, mut max_weight) = ("", None, 0.0);
        // Of the others, the sum of the weights times the logarithms of the night factors.
        let (mut night_factor_of_target, mut log_night_factors) = (1.0, 0.0);
        for (p, mean) in self.meter.bodies().zip(means) {
            let night_factor = night_factor(p, mean);
            if Some(p.body.id) == target {
                mean_of_target = mean.times(TARGET_WEIGHT);
                target_name = &p.body.name;
                night_factor_of_target = night_factor;
            } else {
                mean_of_others.merge(mean);
                log_night_factors += mean.weight * night_factor.ln();
                if mean.weight > max_weight {
                    (max_weight, dominant) = (mean.weight, Some(p.body));
                }
            }
        }
        let level_of_target = AUTO_EXPOSED_MEAN * night_factor_of_target;
        let of_target = mean_of_target.metered(target_name, target, level_of_target);
        let level_of_others = AUTO_EXPOSED_MEAN * (log_night_factors / mean_of_others.weight).exp();
        let of_others = mean_of_others.metered(dominant.map_or("", |b| &b.name), dominant.map(|b| b.id), level_of_others);
        let of_bodies = of_target.into_iter().chain(of_others);
        let mut subjects: Vec<MeteredSubject> = of_bodies.map(|m| MeteredSubject { is_of_bodies: true, ..m }).collect();
        subjects.extend_from_slice(others);
        subjects
    }

    /// Lowers the target levels of subjects in the air around the camera, such as refracted light at its limb, in dusk as that of the sky, less so near the top
    /// of the air.
    fn darken_in_dusk(&self, subjects: &mut [MeteredSubject]) {
        let Some(air) = self.meter.air else { return };
        let (sky_weight, irradiance) = (air.sky_weight(), self.sun_irradiance_around_camera());
        let around = subjects.iter_mut().filter(|m| m.body == Some(air.body.id));
        around.for_each(|m| m.target_level *= sky::dusk_factor(m.radiance / irradiance).powf(sky_weight));
    }
}
