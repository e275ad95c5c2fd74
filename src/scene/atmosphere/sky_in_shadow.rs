//! The light that is left to the sky around the camera in the shadow of another body: for the exposure of images in an eclipse.
//!
//! In: the air around the camera, the directions in which the frame shows the sky, and the visible part of the Sun at points of the air. Out: the fraction of
//! the sky's light that is left. Method: sunlight that the air scatters once into the rays of the frame, each point of a ray in its own sunlight. Added is
//! light that is scattered at least twice: the mean light that arrives at one place of representative height, from the air and the ground in sight of it, as a
//! source that is the same along all rays; further orders form a geometric series with it, as in `multi_scatter_in_shadow`. In the middle of a wide umbra this
//! light is all that is left. What decides is the sunlight beyond the umbra: much beyond a narrow penumbra (Jupiter's moons), little in the wide one of the
//! Moon on the Earth. Always: 1 where no point in sight lies in the shadow, and at night, when the body's own shadow covers all that is in sight; continuous in
//! place, time and direction. Not modelled: the phase function and the colour of light scattered twice; limb darkening; sunlight refracted into the shadow.
//! Error: the median luminance of views that leave out the lowest 6 degrees is metered 0.25 to 3.5 times as bright as it is drawn, in the umbras of Jupiter's
//! moons, of Titan on Saturn, of Charon on Pluto and of the Moon on the Earth, at heights up to a third of the air's (tests/atmosphere/sky_in_umbra.rs).

use crate::catalog::Species;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::atmosphere::air_sphere::{AirSphere, GROUND_CLEARANCE_KM, ground_albedo};
use crate::scene::atmosphere::constituent::{Constituent, dark_from_rad, visible_source_fraction};
use crate::scene::atmosphere::extinction::{column_above_km, density};
use crate::scene::atmosphere::phase;
use crate::scene::numeric::gauss_legendre;
use crate::units::luminance;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Integration steps along a ray.
const STEPS: usize = 12;
/// Paths on which light arrives at the representative place: altitudes above and below the horizon, and azimuths. Light of the lit air beyond an umbra comes
/// from within a degree of the horizon, where the altitudes are densest. With twice as many altitudes the light differs by 7 % at most.
const ALTITUDES: usize = 8;
const AZIMUTHS: usize = 6;
/// Directions that stand for the entire sky: altitudes and azimuths.
const SKY_ALTITUDES: usize = 4;
const SKY_AZIMUTHS: usize = 8;
/// Sine of the altitude, 10 degrees, below which a direction counts as this high. Lower down shines the air beyond the umbra: a bright band, which like the
/// arch of dusk is not what the sky is exposed for.
const LOWEST_SINE: f64 = 0.17;
/// Height of the representative place above the camera, in scale heights of the air above the camera: the mean over a rising ray of the light that arrives at
/// its points, which increases with height faster than linearly, is that at this height.
const PLACE_SCALE_HEIGHTS: f64 = 1.5;
/// Greatest height of that place, as a fraction of the air's. The drawn light is the same at all heights above the highest row of its table
/// (`multi_scatter_in_shadow`), 0.18 of the air's height; with a quarter, the factors between metered and drawn light are evenly spread about 1.
const MAX_PLACE_HEIGHT: f64 = 0.25;
/// Upper limit of the fraction of light that is scattered again, so that the geometric series converges.
const MAX_RESCATTERED: f64 = 0.98;
/// Lower limit of the fraction of light that is left in a direction, relative to that of the sum over all directions: for the logarithm.
const LEAST_LEFT: f64 = 1e-3;
/// The fraction of light that is left where no sunlight is in sight.
const NONE_MISSING: f64 = 1.0;
/// Margin for rounding where air in sight is taken to be dark, radians.
const DARK_MARGIN_RAD: f64 = 1e-6;

/// Light, per irradiance of the Sun, as a luminance.
#[derive(Clone, Copy, Debug, Default)]
struct Light {
    without_shadow: f64,
    in_shadow: f64,
}

impl Light {
    /// Adds light whose source sees a part of the Sun.
    fn add(&mut self, light: f64, visible_sun: impl FnOnce() -> f64) {
        if light > 0.0 {
            self.without_shadow += light;
            self.in_shadow += light * visible_sun();
        }
    }

    fn times(self, factor: f64) -> Self {
        Self { without_shadow: self.without_shadow * factor, in_shadow: self.in_shadow * factor }
    }
}

/// A body's air in a shadow. Positions are relative to the body's centre, km; directions are unit vectors, ICRF.
struct ShadedAir<'a, F> {
    sphere: AirSphere<'a>,
    constituents: Vec<Constituent<'a>>,
    /// Scattering coefficient of each constituent where its density is 1, per km.
    scattering: Vec<DVec3>,
    /// Position of the camera.
    camera: DVec3,
    /// Directions at the camera: to the zenith, and two horizontal ones.
    up: DVec3,
    across: [DVec3; 2],
    /// Towards the Sun.
    sun: DVec3,
    /// Visible part of the Sun at a point whose position is relative to the camera, km.
    visible_sun: F,
}

impl<F: Fn(DVec3) -> f64> ShadedAir<'_, F> {
    /// A direction by the sine of its altitude at the camera and its azimuth.
    fn direction(&self, sine: f64, azimuth_rad: f64) -> DVec3 {
        let (sin, cos) = azimuth_rad.sin_cos();
        self.up * sine + (self.across[0] * cos + self.across[1] * sin) * (1.0 - sine * sine).max(0.0).sqrt()
    }

    /// The same azimuth, not lower than [`LOWEST_SINE`].
    fn raised(&self, direction: DVec3) -> DVec3 {
        let sine = direction.dot(self.up);
        if sine >= LOWEST_SINE {
            return direction;
        }
        let horizontal = (direction - self.up * sine).try_normalize().unwrap_or(self.across[0]);
        self.up * LOWEST_SINE + horizontal * (1.0 - LOWEST_SINE * LOWEST_SINE).sqrt()
    }

    /// Transmittance towards the Sun, 0 in the body's own shadow.
    fn sun_transmittance(&self, point: DVec3) -> f64 {
        let (ground_km, from_centre_km) = (self.sphere.radius_km, point.length());
        let cosine = point.dot(self.sun) / from_centre_km;
        let lit = visible_source_fraction(ground_km, self.sphere.air.top_km, from_centre_km, cosine);
        if lit <= 0.0 {
            return 0.0;
        }
        let depth: DVec3 = self.constituents.iter().map(|c| c.extinction * c.column_to_light_km(ground_km, from_centre_km, cosine)).sum();
        lit * luminance((-depth).exp().to_array())
    }

    /// Sums over the constituents at a point. `of_constituents`: for each sum the value of each constituent where its density is 1.
    fn sums_at<const N: usize>(&self, point: DVec3, of_constituents: [&[DVec3]; N]) -> [DVec3; N] {
        let (height_km, mut sums) = (self.sphere.height_km(point), [DVec3::ZERO; N]);
        for (k, c) in self.constituents.iter().enumerate() {
            let density_here = density(c.species, height_km);
            for (sum, values) in sums.iter_mut().zip(of_constituents) {
                *sum += values[k] * density_here;
            }
        }
        sums
    }

    /// Whether sunlight may reach air or ground in sight of the camera or of a place above it. If not, it is night: all that is in sight is in the body's own
    /// shadow, and no sunlight is there to be lost. `place_height_km`: height of the place.
    fn may_be_lit(&self, place_height_km: f64) -> bool {
        let (ground_km, top_km) = (self.sphere.radius_km, self.sphere.air.top_km);
        let highest_km = ground_km + place_height_km.max(self.sphere.height_km(self.camera));
        // At the body's centre, between the place and the farthest point in sight: up to where the ray touches the ground, and on to the top of the air.
        let sight_rad = (ground_km / highest_km).acos() + (ground_km / (ground_km + top_km)).acos();
        let zenith_angle_rad = self.up.dot(self.sun).clamp(-1.0, 1.0).acos();
        zenith_angle_rad - sight_rad < dark_from_rad(ground_km, top_km) + DARK_MARGIN_RAD
    }

    fn visible_sun_at(&self, point: DVec3) -> f64 {
        (self.visible_sun)(point - self.camera)
    }

    /// Height of the representative place.
    fn place_height_km(&self, camera_height_km: f64) -> f64 {
        let green = |of_species: fn(&Species, f64) -> f64| {
            self.constituents.iter().map(|c| c.scattering.y * of_species(c.species, camera_height_km)).sum::<f64>()
        };
        let scale_height_km = green(column_above_km) / green(density).max(f64::MIN_POSITIVE);
        let highest_km = MAX_PLACE_HEIGHT * self.sphere.air.top_km;
        (camera_height_km + PLACE_SCALE_HEIGHTS * scale_height_km).min(highest_km).max(GROUND_CLEARANCE_KM)
    }

    /// The mean light over all directions that arrives at a place above the camera's, per steradian, with the light of all further orders of scattering.
    fn arriving_at(&self, height_km: f64) -> Light {
        let from_centre_km = self.sphere.radius_km + height_km;
        let place = self.up * from_centre_km;
        let horizon_sine = -(1.0 - (self.sphere.radius_km / from_centre_km).powi(2)).max(0.0).sqrt();
        let (mut light, mut rescattered) = (Light::default(), 0.0_f64);
        // Towards the zenith, then towards the nadir.
        for end_sine in [1.0, -1.0] {
            for k in 0..ALTITUDES {
                // Sines as the third power of equal steps.
                let u = (k as f64 + 0.5) / ALTITUDES as f64;
                let sine = horizon_sine + (end_sine - horizon_sine) * u * u * u;
                // Fraction of all directions. Their sines have a range of 2.
                let weight = 0.5 * (end_sine - horizon_sine).abs() * 3.0 * u * u / (ALTITUDES * AZIMUTHS) as f64;
                for n in 0..AZIMUTHS {
                    let along = self.direction(sine, TAU * (n as f64 + 0.5) / AZIMUTHS as f64);
                    let ground = self.sphere.follow(place, along, STEPS, |point, transmitted_km| {
                        let [scattering] = self.sums_at(point, [&self.scattering]);
                        let scattered = weight * luminance((scattering * transmitted_km).to_array());
                        rescattered += scattered;
                        light.add(scattered * self.sun_transmittance(point) / (4.0 * PI), || self.visible_sun_at(point));
                    });
                    if let Some(hit) = ground {
                        let cosine = hit.point_km.normalize().dot(self.sun).max(0.0);
                        let reflected = luminance((self.sphere.ground_albedo * hit.transmittance).to_array()) * cosine / PI;
                        light.add(weight * reflected * self.sun_transmittance(hit.point_km), || self.visible_sun_at(hit.point_km));
                    }
                }
            }
        }
        light.times(1.0 / (1.0 - rescattered.min(MAX_RESCATTERED)))
    }

    /// The light of the sky in a direction. `arriving`: [`Self::arriving_at`] the representative place.
    fn sky_light(&self, along: DVec3, arriving: Light) -> Light {
        let into_ray_of = |c: &Constituent<'_>| c.scattering * phase::per_steradian(c.species.phase, along.dot(self.sun));
        let into_ray: Vec<DVec3> = self.constituents.iter().map(into_ray_of).collect();
        let mut light = Light::default();
        self.sphere.follow(self.camera, along, STEPS, |point, transmitted_km| {
            let [once, again] = self.sums_at(point, [&into_ray, &self.scattering]);
            let once = luminance((once * transmitted_km).to_array()) * self.sun_transmittance(point);
            light.add(once, || self.visible_sun_at(point));
            let again = luminance((again * transmitted_km).to_array());
            light.without_shadow += again * arriving.without_shadow;
            light.in_shadow += again * arriving.in_shadow;
        });
        light
    }

    /// The fraction of the light from a part of the sky that is left: the geometric mean over its directions, as the light meter averages. In the arithmetic
    /// mean the air beyond the umbra would decide, a bright band along the horizon. `directions`, `arriving`: see
    /// [`SurroundingAir::light_left_in_shadow`] and [`Self::sky_light`].
    fn light_left(&self, directions: &[(DVec3, f64)], arriving: Light) -> f64 {
        let mut lights: Vec<(Light, f64)> = Vec::new();
        let mut add = |along: DVec3, weight: f64| lights.push((self.sky_light(along, arriving), weight));
        if directions.is_empty() {
            for (sine, weight) in gauss_legendre(SKY_ALTITUDES) {
                for k in 0..SKY_AZIMUTHS {
                    add(self.raised(self.direction(sine, TAU * (k as f64 + 0.5) / SKY_AZIMUTHS as f64)), weight);
                }
            }
        } else {
            directions.iter().for_each(|(direction, weight)| add(self.raised(*direction), *weight));
        }
        let sum = |of: fn(&Light) -> f64| lights.iter().map(|(light, weight)| weight * of(light)).sum::<f64>();
        let (without_shadow, in_shadow) = (sum(|light| light.without_shadow), sum(|light| light.in_shadow));
        // Where there is no sunlight at all, none is missing.
        if without_shadow <= 0.0 {
            return NONE_MISSING;
        }
        let least = LEAST_LEFT * in_shadow / without_shadow;
        if least <= 0.0 {
            return 0.0;
        }
        let (mut log_sum, mut weight_sum) = (0.0, 0.0);
        for (light, weight) in lights.iter().filter(|(light, _)| light.without_shadow > 0.0) {
            log_sum += weight * (light.in_shadow / light.without_shadow).max(least).ln();
            weight_sum += weight;
        }
        (log_sum / weight_sum).exp()
    }
}

impl SurroundingAir<'_> {
    /// Greatest distance from the camera of a point of the air in sight, km.
    pub(crate) fn sight_km(&self) -> f64 {
        let (radius_km, top_km) = (self.body.radii_km.x, self.air.top_km);
        2.0 * (top_km * (2.0 * radius_km + top_km)).sqrt()
    }

    /// The fractions of the sunlight from parts of the sky that are left in the shadow of other bodies. `towards_sun`: vector from the body; `parts`: the
    /// directions of each part, ICRF, unit vectors, each with its weight; without directions, the part is the entire sky. `visible_sun`: the visible part of
    /// the Sun at a point whose position is relative to the camera, ICRF, km.
    pub(crate) fn light_left_in_shadow<const N: usize>(
        &self,
        towards_sun: DVec3,
        parts: [&[(DVec3, f64)]; N],
        visible_sun: impl Fn(DVec3) -> f64,
    ) -> [f64; N] {
        let shaded = self.shaded(towards_sun, visible_sun);
        let place_height_km = shaded.place_height_km(self.height_part() * self.air.top_km);
        if !shaded.may_be_lit(place_height_km) {
            return [NONE_MISSING; N];
        }
        let arriving = shaded.arriving_at(place_height_km);
        parts.map(|directions| shaded.light_left(directions, arriving))
    }

    /// This air in a shadow; arguments as in [`Self::light_left_in_shadow`].
    fn shaded<F: Fn(DVec3) -> f64>(&self, towards_sun: DVec3, visible_sun: F) -> ShadedAir<'_, F> {
        let (air, up, height_km) = (self.air, self.up(), self.height_part() * self.air.top_km);
        let sphere = AirSphere { radius_km: self.body.radii_km.x, air, ground_albedo: ground_albedo(self.body) };
        let east = self.placement.body_from_icrf.row(2).cross(up).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
        let constituents: Vec<Constituent<'_>> = air.species.iter().map(Constituent::of).collect();
        ShadedAir {
            scattering: constituents.iter().map(|c| c.scattering).collect(),
            constituents,
            camera: up * (sphere.radius_km + height_km.max(GROUND_CLEARANCE_KM)),
            sphere,
            up,
            across: [east, up.cross(east)],
            sun: towards_sun.normalize(),
            visible_sun,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Body, Catalog, NaifId};
    use crate::scene::atmosphere::sky_brightness::SkyBrightnessCache;
    use crate::scene::camera::Placement;
    use glam::DMat3;
    use std::cell::Cell;

    /// A camera at eye level, on the x axis of the body.
    fn on_the_ground(body: &Body) -> Placement {
        Placement { centre_km: -DVec3::X * (body.radii_km.x + 0.002), body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km }
    }

    /// The light left to the sky on the ground of a body, and to the lowest 20 degrees of it on one side, under a high Sun.
    fn light_left(body: NaifId, visible_sun: impl Fn(DVec3) -> f64) -> [f64; 2] {
        let catalog = Catalog::embedded();
        let body = catalog.body(body).expect("a body");
        let place = on_the_ground(body);
        let skies = SkyBrightnessCache::default();
        let air = SurroundingAir::of(body, &place, &skies).expect("air");
        let low = [(DVec3::new(0.1, 1.0, 0.0).normalize(), 1.0), (DVec3::new(0.3, 1.0, 0.2).normalize(), 1.0)];
        let entire_sky: [(DVec3, f64); 0] = [];
        air.light_left_in_shadow(towards_sun(), [&entire_sky[..], &low[..]], visible_sun)
    }

    fn towards_sun() -> DVec3 {
        DVec3::new(0.9, 0.3, 0.2) * 1e8
    }

    /// Parts of the sky that are asked for together have the light that each has alone. The light that arrives at the representative place is computed once
    /// for all of them.
    #[test]
    fn parts_of_the_sky_share_the_light_that_is_scattered_twice() {
        let catalog = Catalog::embedded();
        let body = catalog.body(NaifId(399)).expect("a body");
        let place = on_the_ground(body);
        let skies = SkyBrightnessCache::default();
        let air = SurroundingAir::of(body, &place, &skies).expect("air");
        let evaluations = Cell::new(0_u32);
        let visible_sun = |point: DVec3| {
            evaluations.set(evaluations.get() + 1);
            f64::from(point.y < 1.0)
        };
        let low = [(DVec3::new(0.3, 1.0, 0.2).normalize(), 1.0)];
        let entire_sky: &[(DVec3, f64)] = &[];
        let [] = air.light_left_in_shadow(towards_sun(), [], visible_sun);
        let of_place = evaluations.take();
        let [entire] = air.light_left_in_shadow(towards_sun(), [entire_sky], visible_sun);
        let of_entire_sky = evaluations.take();
        let [beside] = air.light_left_in_shadow(towards_sun(), [&low[..]], visible_sun);
        let of_beside = evaluations.take();
        let both = air.light_left_in_shadow(towards_sun(), [entire_sky, &low[..]], visible_sun);
        assert_eq!(both, [entire, beside]);
        assert!(of_place > 100 && beside < entire, "{of_place} {beside} {entire}");
        assert_eq!(evaluations.take(), of_entire_sky + of_beside - of_place);
    }

    /// Where it is taken to be night, no light is in sight, with or without a shadow. On the Earth this is so from some altitude of the Sun on, not by day.
    #[test]
    fn at_night_no_light_is_missing() {
        let catalog = Catalog::embedded();
        let skies = SkyBrightnessCache::default();
        for body in catalog.bodies().iter().filter(|b| b.atmosphere.is_some()) {
            let place = on_the_ground(body);
            let air = SurroundingAir::of(body, &place, &skies).expect("air");
            let is_night = |altitude_deg: f64| {
                let (sin, cos) = altitude_deg.to_radians().sin_cos();
                let shaded = air.shaded(DVec3::new(sin, 0.8 * cos, 0.6 * cos), |_| 0.0);
                let place_height_km = shaded.place_height_km(0.002);
                let arriving = shaded.arriving_at(place_height_km);
                let is_night = !shaded.may_be_lit(place_height_km);
                let left = shaded.light_left(&[], arriving);
                assert!(!is_night || (arriving.without_shadow == 0.0 && left == 1.0), "{} at {altitude_deg} degrees: {left}", body.name);
                is_night
            };
            let nights: Vec<bool> = (0..=30).map(|k| is_night(-3.0 * f64::from(k))).collect();
            assert!(!nights[0] && nights.is_sorted(), "{}: {nights:?}", body.name);
            assert!(body.id != NaifId(399) || (!nights[6] && nights[10]), "{nights:?}");
        }
    }

    #[test]
    fn light_is_left_in_proportion_to_a_sun_that_is_dimmed_everywhere() {
        for body in [399, 499, 599, 606, 999] {
            for (visible, tolerance) in [(0.0, 0.0), (0.25, 1e-12), (1.0, 0.0)] {
                let left = light_left(NaifId(body), |_| visible);
                assert!(left.iter().all(|l| (l - visible).abs() <= tolerance), "{body}: {left:?} of {visible}");
            }
        }
    }

    /// Umbras without penumbra around the camera: the wider, the less light is left. An umbra that covers all that is in sight leaves none, one beside the
    /// camera dims the sky on its side more than the entire sky.
    #[test]
    fn a_wider_umbra_leaves_less_light() {
        let from_axis_km = |point: DVec3| point.reject_from_normalized(towards_sun().normalize()).length();
        for body in [399, 599] {
            let umbra = |radius_km: f64| light_left(NaifId(body), |point| f64::from(from_axis_km(point) > radius_km));
            let [narrow, middle, wide, all] = [10.0, 100.0, 500.0, 1e5].map(umbra);
            for k in [0, 1] {
                let is_less = narrow[k] < 1.0 && middle[k] < narrow[k] && wide[k] < middle[k] && wide[k] > 0.0 && all[k] == 0.0;
                assert!(is_less, "{body}: {narrow:?}, {middle:?}, {wide:?}, {all:?}");
            }
            let [entire_sky, beside] = light_left(NaifId(body), |point| f64::from(point.y < 1.0));
            assert!(beside < entire_sky && entire_sky < 1.0, "{body}: {beside} of {entire_sky}");
        }
    }
}
