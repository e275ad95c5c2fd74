//! The air beyond the limb of a body seen from afar, for the light meter: most of the light of a body in front of the Sun is in this ring.
//!
//! In: a body with air, the direction of the Sun. Out: parts of the ring with their area and radiance. Always: continuous in position and time. The radiance
//! agrees with that of the drawn rim within a factor of 3 for Titan, Pluto and Mars, and of 8 for the Earth in small images (tests/scene/rims.rs). Left out:
//! shadows of a planet's rings on the air, absorbing layers, and the ring of air around a near body, only a part of which is in view (`FAR_RADII`). A disc of a
//! few pixels, which the frame gradually draws as a point, cannot be told from its ring: the point, with the light of both, is metered in place of the ring.

use super::MeteredFrame;
use super::geometry::{entire_disc_weight, outline_position_weight};
use crate::catalog::{Atmosphere, Species};
use crate::scene::atmosphere::extinction::{density, extinction};
use crate::scene::atmosphere::{air, rim};
use crate::scene::eclipse::approximate_shadow::ApproximateShadow;
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Phase angles between which the ring's weight rises from 0 to 1. Beside a disc that is more than half lit the ring's light does not matter.
const COUNTED_FROM_PHASE_RAD: (f64, f64) = (FRAC_PI_2, 0.75 * PI);
/// Number of position angles on half of the limb, and of heights, at which the ring is sampled.
const POSITION_ANGLE_COUNT: u32 = 12;
const HEIGHT_COUNT: u32 = 24;

/// Column of a species of exponential profile from a height towards the Sun, in km at the density of the ground; infinite if the ground hides the Sun. By the
/// approximation of Chapman's function c / ((c - 1) cos z + 1), with c = sqrt(pi x / 2), the radius x in scale heights and the Sun's zenith angle z.
/// `sin_altitude`: sine of the Sun's altitude.
fn column_towards_sun_km(s: &Species, radius_km: f64, height_km: f64, sin_altitude: f64) -> f64 {
    let scale_height_km = s.scale_height_km;
    // c, the value of Chapman's function for a horizontal ray.
    let horizontal = (FRAC_PI_2 * radius_km / scale_height_km).sqrt();
    let upwards_km = scale_height_km * horizontal / ((horizontal - 1.0) * sin_altitude.abs() + 1.0) * density(s, height_km);
    if sin_altitude >= 0.0 {
        return upwards_km;
    }
    // The ray first descends to its lowest point. A line through this point has the column of a horizontal ray on either side; the part behind the ray's start
    // is subtracted.
    let lowest_km = (radius_km + height_km) * (1.0 - sin_altitude * sin_altitude).sqrt() - radius_km;
    if lowest_km < 0.0 {
        return f64::INFINITY;
    }
    2.0 * scale_height_km * horizontal * density(s, lowest_km) - upwards_km
}

/// Fraction of sunlight that reaches a height of the limb, per channel. `sin_altitude`: sine of the Sun's altitude there.
fn sunlight(air: &Atmosphere, radius_km: f64, height_km: f64, sin_altitude: f64) -> DVec3 {
    let depth: DVec3 =
        rim::exponential(air).map(|s| extinction(s) * column_towards_sun_km(s, radius_km, height_km, sin_altitude).min(1e30)).sum();
    (-depth).exp()
}

/// A body's ring of air.
pub(super) struct RimOfAir<'p> {
    air: &'p Atmosphere,
    radius_km: f64,
    /// Sine and cosine of the phase angle.
    phase_sin_cos: (f64, f64),
    /// Sine and cosine of the angle at the body's centre between the limb and the plane perpendicular to the line of sight; the angle is 0 for a far camera.
    limb_tilt_sin_cos: (f64, f64),
    /// How much of the ring continues the disc's colour, by [`rim::continued_part`]; 0 if the body's colours exclude the air, or if the air is visible over the
    /// disc.
    continued_part: f64,
    /// Opacity along the limb, the mean of the channels.
    limb_opacity: f64,
    /// Radiance of the ground under a Sun in the zenith, per irradiance: the disc's colour, which an opaque rim continues.
    disc_albedo: f64,
}

impl<'p> RimOfAir<'p> {
    /// `None` for a body without air. `disc_albedo`: see the field.
    pub(super) fn of(p: &PlacedBody<'p>, disc_albedo: f64) -> Option<Self> {
        let air = p.body.atmosphere.as_ref()?;
        let radius_km = p.body.radii_km.max_element();
        let ground_height_km = 0.0;
        let limb_opacity = rim::opacity_along_limb(air, radius_km, ground_height_km);
        let continued_part = if rim::continues_disc(p.body, air) { rim::continued_part(limb_opacity) } else { 0.0 };
        let limb_tilt_sin_cos = (radius_km / p.distance_km).min(1.0).asin().sin_cos();
        let phase_sin_cos = p.phase_angle_rad.sin_cos();
        Some(Self { air, radius_km, phase_sin_cos, limb_tilt_sin_cos, continued_part, limb_opacity, disc_albedo })
    }

    /// Radiance per irradiance, brightest channel, at a height over the limb. `cos_position_angle`: cosine of the angle around the disc's centre from the
    /// direction of the Sun.
    fn radiance(&self, height_km: f64, cos_position_angle: f64) -> f64 {
        let ((sin_phase, cos_phase), (sin_tilt, cos_tilt)) = (self.phase_sin_cos, self.limb_tilt_sin_cos);
        // The Sun's components towards the camera and away from the disc's centre, as seen from the limb, whose normal is tilted towards the camera.
        let (towards_camera, outwards) = (cos_phase, sin_phase * cos_position_angle);
        let sin_altitude = outwards * cos_tilt + towards_camera * sin_tilt;
        let cos_scattering = outwards * sin_tilt - towards_camera * cos_tilt;
        let (depth, scattered) = rim::tangent_ray(self.air, self.radius_km, height_km, cos_scattering);
        let opacity = DVec3::ONE - (-depth).exp();
        let sunlight = sunlight(self.air, self.radius_km, height_km, sin_altitude);
        let once_scattered = scattered * opacity / depth.max(DVec3::splat(1e-12)) * sunlight;
        let of_scattering = rim::ALL_ORDERS_TO_SINGLE_RATIO * once_scattered.max_element();
        let continued = self.disc_albedo * sin_altitude.max(0.0) * opacity.element_sum() / 3.0 / self.limb_opacity.max(1e-12);
        of_scattering + (continued - of_scattering) * self.continued_part
    }

    /// Calls `add` with the area of each part of the ring, relative to that of the disc, and its radiance per irradiance. `height_px`: height of the ring's
    /// bright part; a ring lower than a pixel is spread over a pixel. `places`: the two places of the limb at a position angle, on either side of the direction
    /// of the Sun; for each its weight and the part of sunlight that shadows leave there.
    fn sum(&self, height_px: f64, places: impl Fn(f64) -> [[f64; 2]; 2], mut add: impl FnMut(f64, f64)) {
        let pixel_fraction = height_px.clamp(1e-6, 1.0);
        let step_km = self.air.top_km / f64::from(HEIGHT_COUNT);
        let midpoint = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
        for n in 0..POSITION_ANGLE_COUNT {
            let position_angle = PI * midpoint(n, POSITION_ANGLE_COUNT);
            let places = places(position_angle);
            for k in 0..HEIGHT_COUNT {
                let height_km = self.air.top_km * midpoint(k, HEIGHT_COUNT);
                // The ring has the circumference 2 pi R and the disc the area pi R squared; each of the two places has half of the ring.
                let area = (1.0 + height_km / self.radius_km) * step_km / self.radius_km / f64::from(POSITION_ANGLE_COUNT);
                let radiance = self.radiance(height_km, position_angle.cos());
                for [weight, sunlit] in places {
                    add(weight * area / pixel_fraction, sunlit * radiance * pixel_fraction);
                }
            }
        }
    }
}

impl MeteredFrame<'_, '_> {
    /// How much the light of the air beyond a body's limb counts, apart from the size of its disc: 0 if the body has no air, its air is not drawn, or the disc
    /// is more than half lit.
    pub(super) fn rim_weight(&self, p: &PlacedBody<'_>, diameter_px: f64) -> f64 {
        let request = self.meter.context.request;
        let user_choice = request.effects.override_of_body(p.body, Effect::Atmosphere);
        let Some(air) = p.body.atmosphere.as_ref().filter(|_| user_choice != Some(false)) else { return 0.0 };
        // As in `air::is_significant`: a low rim of air that removes no visible light is not drawn unless the user demands it.
        let is_left_out_if_low = user_choice != Some(true) && air::max_removed_fraction(air) <= request.purpose.min_change();
        let height_px = rim::height_px(p.body, air, diameter_px);
        let of_height = if is_left_out_if_low { smoothstep(height_px / rim::ALWAYS_DRAWN_RIM_PX - 1.0) } else { 1.0 };
        of_height * smooth_rise(COUNTED_FROM_PHASE_RAD, p.phase_angle_rad)
    }

    /// Calls `add` with the area of each part of the ring of air around a body, relative to that of its disc and times the part's weight, and its radiance.
    /// Parts outside the frame have no weight. Does nothing if the ring does not count ([`Self::rim_weight`]), or if the frame draws no disc.
    pub(super) fn sum_rim(
        &self,
        p: &PlacedBody<'_>,
        disc_albedo: f64,
        shadow: Option<&ApproximateShadow<'_>>,
        diameter_px: f64,
        mut add: impl FnMut(f64, f64),
    ) {
        let weight = self.rim_weight(p, diameter_px) * self.disc_fraction(p, diameter_px);
        let Some(rim) = RimOfAir::of(p, disc_albedo).filter(|_| weight > 0.0) else { return };
        let height_px = rim::height_px(p.body, rim.air, diameter_px);
        let viewer = (p.placement.body_from_icrf * -p.placement.centre_km).normalize();
        let sun = (p.body_from_icrf * p.body_to_sun_km).normalize();
        let across = (sun - viewer * sun.dot(viewer)).try_normalize().unwrap_or_else(|| viewer.any_orthonormal_vector());
        let up = viewer.cross(across);
        let (sin_tilt, cos_tilt) = rim.limb_tilt_sin_cos;
        let outline_weight = outline_position_weight(self.meter.camera, p);
        let disc_weight = entire_disc_weight(self.meter.camera, p, diameter_px);
        let places = |position_angle: f64| {
            let (sin, cos) = position_angle.sin_cos();
            [sin, -sin].map(|sin| {
                let normal = (across * cos + up * sin) * cos_tilt + viewer * sin_tilt;
                let sunlit = shadow.map_or(1.0, |s| s.sunlight_fraction(normal * p.body.radii_km / p.body.radii_km.x).max(0.0));
                let from_camera_km = p.placement.centre_km + p.placement.body_from_icrf.transpose() * (normal * p.body.radii_km);
                [self.part_position_weight(from_camera_km, outline_weight, disc_weight), sunlit]
            })
        };
        let irradiance = self.sun_irradiance_on(p);
        rim.sum(height_px, places, |area, radiance| add(weight * area, radiance * irradiance));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// The column towards the Sun against a sum over the ray, for the Earth, within 15 %; and it is continuous at the horizon.
    #[test]
    fn the_column_towards_the_sun_is_that_along_the_ray() {
        let catalog = Catalog::embedded();
        let body = catalog.body(NaifId::EARTH).expect("the Earth");
        let air = body.atmosphere.as_ref().expect("air");
        let gas = rim::exponential(air).next().expect("gas");
        let radius_km = body.radii_km.x;
        for (height_km, altitude_deg) in [(0.0, 90.0), (5.0, 30.0), (10.0, 5.0), (20.0, 0.0), (20.0, -1.0), (30.0, -3.0), (50.0, -5.0)] {
            let sin_altitude = f64::to_radians(altitude_deg).sin();
            let from_centre_km = radius_km + height_km;
            let (step_km, mut expected) = (0.5, 0.0);
            for k in 0..8000 {
                let length_km = (f64::from(k) + 0.5) * step_km;
                let height_km = (from_centre_km * from_centre_km + length_km * length_km + 2.0 * from_centre_km * length_km * sin_altitude)
                    .sqrt()
                    - radius_km;
                expected += density(gas, height_km) * step_km;
            }
            let found = column_towards_sun_km(gas, radius_km, height_km, sin_altitude);
            assert!((found / expected - 1.0).abs() < 0.15, "{height_km} km, {altitude_deg} degrees: {found} km, not {expected}");
        }
        assert_eq!(column_towards_sun_km(gas, radius_km, 20.0, f64::to_radians(-6.0).sin()), f64::INFINITY);
        let [above, below] = [1e-9, -1e-9].map(|sine| column_towards_sun_km(gas, radius_km, 20.0, sine));
        assert!((above / below - 1.0).abs() < 1e-6, "{above} {below}");
    }
}
