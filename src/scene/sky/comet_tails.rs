//! The light of a comet that is no point: the coma, the tail of dust and the tail of ions, as soft elliptical patches.
//!
//! In: the comet's orbit and state, its irradiance, the camera. Out: [`LightPatch`]es for shaders/entry/comet_tail.wesl. Ions move with the solar wind and lag
//! by the comet's own velocity. Dust grains move on orbits of their own from the point of release; radiation pressure reduces the Sun's gravity on them by the
//! fraction beta (Finson and Probstein 1968, Astrophys. J. 154, 327). A patch has the grains of one cell of the grid of beta and age, or a piece of the ion
//! tail: it covers the cell's extent as seen by the camera, and the spread of velocities. The directions of tails follow from this alone; the shares of the
//! light, the weights of sizes and ages and the ion tail's length are chosen to resemble photographs, not measured. Each patch is lit in proportion to
//! 1 / (its own distance)^2. The dust of a patch scatters by the patch's own phase angle; apart from this a tail's surface brightness does not depend on where
//! the camera is. Left out: jets, disconnections, anti-tails of large grains, variations of the solar wind.

use super::minor_planets::NEAR_AU;
use super::star_colour::star_colour;
use crate::catalog::small_bodies::{GAUSS_CONSTANT, HeliocentricOrbit};
use crate::ephemeris::angle_rad;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::conic::{ConicState, heliocentric_state};
use crate::scene::atmosphere::tint_table::TintTable;
use crate::scene::camera::{Camera, narrow, narrow_scalar, narrow2};
use crate::scene::light::phase_laws::comet_dust_law;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, luminance};
use glam::{DQuat, DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// Speed of the solar wind, km/s: the slow wind near the ecliptic (McComas et al. 2000, J. Geophys. Res. 105, 10419).
pub const SOLAR_WIND_KM_S: f64 = 400.0;
/// Range of beta, the ratio of radiation pressure to gravity, of the simulated grains: from 6 micrometres down to the largest beta of absorbing grains (Burns,
/// Lamy and Soter 1979, Icarus 40, 1). Larger grains stay in the coma's image or near the orbit, and have a small part of the scattering area.
const MIN_BETA: f64 = 0.1;
const MAX_BETA: f64 = 2.5;
/// Scattering area per interval of ln(beta) grows as this power of beta, up to [`FALLING_FROM_BETA`]: numbers of grains that fall as the power -3.75 of their
/// radius, between -3.5 (collisions) and -4 (Fulle 2004, Comets II, 565).
const AREA_EXPONENT: f64 = 0.75;
/// Beta from which the area falls: grains smaller than the wavelength scatter little.
const FALLING_FROM_BETA: f64 = 1.5;
/// Cells of beta, evenly spaced in its logarithm, and cells of age. `dust` merges cells of beta by divisors of their number.
const BETA_CELLS: usize = 12;
const AGE_CELLS: usize = 56;
/// Speed at which grains with a beta of 1 leave the coma in all directions, au per day: 0.3 km/s. It is proportional to the square root of beta.
const GRAIN_SPEED_AU_PER_DAY: f64 = 0.3 * SECONDS_PER_DAY / KM_PER_AU;
/// Largest age of grains since their release, and the time in which their light falls by e, days.
const MAX_AGE_DAYS: f64 = 120.0;
const AGE_SCALE_DAYS: f64 = 60.0;
/// Pieces of the ion tail.
const ION_PIECES: usize = 32;
/// Length of the ion tail at a production of 10^30 water molecules per second, and the maximum of its length, au. The length grows with the square root of the
/// production.
const ION_LENGTH_AU: f64 = 0.25;
const MAX_ION_LENGTH_AU: f64 = 0.8;
/// Standard deviation of the ion tail's width divided by the distance from the head.
const ION_SIGMA_TANGENT: f64 = 0.015;
/// Radius of the coma at a production of 10^28 water molecules per second: 100,000 km. It grows as the power 0.3 of the production, which gives the visible
/// comas of Wirtanen in 2018 (1 degree), Hyakutake in 1996 (2 degrees) and Hale-Bopp in 1997 (half a degree).
const COMA_RADIUS_AU: f64 = 100_000.0 / KM_PER_AU;
const COMA_EXPONENT: f64 = 0.3;
/// Standard deviation of the width with which tails leave the head, in radii of the coma.
const ROOT_SIGMA: f64 = 0.15;
/// Standard deviation of a patch along a cell's side, in sides: neighbouring patches overlap to a sheet that is even within some percent.
const CELL_SIGMA: f64 = 0.6;
/// Radius of a patch in standard deviations of its profile (1 - r^2)^3.
const RADIUS_SIGMAS: f64 = 3.162_277_660_168_379_5;
/// Smallest standard deviation of a patch, pixels. A narrower patch would miss the pixels' centres.
const MIN_SIGMA_PX: f64 = 0.6;
/// Smallest radius of the core of a coma: in pixels, and in radii of the coma.
const MIN_CORE_PX: f64 = 0.7;
const MIN_CORE: f64 = 0.02;
/// Largest tangent of a patch's angular radius. A patch that would look larger, because the camera is in it or near it, is cut off there.
const MAX_TANGENT: f64 = 1.5;
/// Linear RGB of the ion tail (CO+, whose bands lie from 400 to 500 nm) and of the coma (with the green bands of C2), chosen by eye; [`of_luminance_1`] scales
/// them.
const ION_RGB: [f64; 3] = [0.30, 0.55, 1.0];
pub(super) const COMA_RGB: [f64; 3] = [0.85, 1.05, 0.8];

/// A soft elliptical patch of light, across the line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPatch {
    /// Direction of the centre: clip x and y times view depth, and view depth, at the distance 1.
    pub centre: Vec3,
    /// From the centre to the rim, along two perpendicular axes, in the same coordinates.
    pub axes: [Vec3; 2],
    /// Lengths of the two axes at the distance 1: tangents of the angular radii.
    pub radii: Vec2,
    /// Radiance at the centre.
    pub radiance: f32,
    /// Radius of a coma's core in units of the patch's; 0: a piece of a tail.
    pub core: f32,
    /// Reversed depth.
    pub depth: f32,
    /// Linear RGB: of luminance 1, times the transmittance of the air.
    pub colour: Vec3,
}

impl LightPatch {
    /// Light at a squared distance from the centre, in radii, relative to that at the centre: the profile of shaders/entry/comet_tail.wesl.
    pub(crate) fn profile(&self, distance_sq: f64) -> f64 {
        let (rim_fade, core) = ((1.0 - distance_sq).max(0.0), f64::from(self.core));
        if core > 0.0 { core * rim_fade.powi(2) / (distance_sq + core * core).sqrt() } else { rim_fade.powi(3) }
    }
}

/// Direction of the ion tail of a comet with a heliocentric state (au, au per day): the solar wind relative to the comet.
pub fn ion_direction(state: &ConicState) -> DVec3 {
    let wind = SOLAR_WIND_KM_S * SECONDS_PER_DAY / KM_PER_AU;
    (state.position.normalize() * wind - state.velocity).normalize()
}

/// A grain after `age_days` that had the comet's state when it was released. `beta`: ratio of radiation pressure to gravity; above 1 the Sun repels the grain.
fn drifted_au(released: &ConicState, age_days: f64, beta: f64) -> DVec3 {
    released.propagated(GAUSS_CONSTANT * GAUSS_CONSTANT * (1.0 - beta), age_days).position
}

/// Heliocentric position, au, at the time `days` past J2000, of a grain that the comet released `age_days` before. `beta`: ratio of radiation pressure to
/// gravity.
pub fn grain_position_au(orbit: &HeliocentricOrbit, days: f64, age_days: f64, beta: f64) -> DVec3 {
    drifted_au(&heliocentric_state(orbit, days - age_days), age_days, beta)
}

/// Water production in units of 10^30 molecules per second, by the heliocentric magnitude, which is the total magnitude at 1 au from the viewer (Jorda,
/// Crovisier and Green 2008, Asteroids, Comets, Meteors, 8046).
pub(super) fn water_production(heliocentric_magnitude: f64) -> f64 {
    10.0_f64.powf(30.675 - 0.2453 * heliocentric_magnitude - 30.0)
}

/// Radius of the coma, au, by the production as in [`water_production`].
pub(super) fn coma_radius_au(production: f64) -> f64 {
    COMA_RADIUS_AU * (100.0 * production).powf(COMA_EXPONENT)
}

/// The colour scaled to a luminance of 1.
pub(super) fn of_luminance_1(rgb: [f64; 3]) -> DVec3 {
    DVec3::from_array(rgb) / luminance(rgb)
}

/// How the camera sees heliocentric positions.
pub(super) struct CometView<'a> {
    pub camera: &'a Camera,
    /// Heliocentric position of the camera, au.
    pub camera_au: DVec3,
    /// Velocity of the viewer, for aberration.
    pub velocity_km_s: DVec3,
    /// Transmittances of the air around the camera.
    pub air: Option<&'a TintTable>,
}

/// A position as the camera sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub distance_au: f64,
    /// Unit vector without aberration, ICRF.
    true_direction: DVec3,
    /// Unit vector with aberration, ICRF.
    pub direction: DVec3,
    /// Reversed depth; 1 for a position behind the near plane.
    pub depth: f64,
    /// Linear RGB.
    pub transmittance: DVec3,
}

/// Light before it is projected.
struct Cloud {
    position_au: DVec3,
    /// Sides of the cell that the light fills.
    sides_au: [DVec3; 2],
    /// Standard deviation of its further spread, the same in all directions.
    sigma_au: f64,
    /// Irradiance at a distance of 1 au.
    irradiance_at_1_au: f64,
}

impl CometView<'_> {
    /// A position as the camera sees it; `None` at the camera itself.
    pub(super) fn sight(&self, heliocentric_au: DVec3) -> Option<Sight> {
        let from_camera = heliocentric_au - self.camera_au;
        let distance_au = from_camera.length();
        if distance_au <= NEAR_AU {
            return None;
        }
        let true_direction = from_camera / distance_au;
        let direction = aberrated(true_direction, self.velocity_km_s);
        let view_depth_au = direction.dot(self.camera.forward) * distance_au;
        let depth = if view_depth_au > NEAR_AU { NEAR_AU / view_depth_au } else { 1.0 };
        let transmittance = self.air.map_or(DVec3::ONE, |air| air.transmittance(direction));
        Some(Sight { distance_au, true_direction, direction, depth, transmittance })
    }

    /// Clip x and y times view depth, and view depth, of a vector (ICRF).
    fn in_clip(&self, v: DVec3) -> Vec3 {
        let camera = self.camera;
        narrow(DVec3::new(v.dot(camera.right) / camera.tan_half_fov.x, v.dot(camera.up) / camera.tan_half_fov.y, v.dot(camera.forward)))
    }

    /// Whether a patch of this angular radius may be in the frame.
    fn may_show(&self, direction: DVec3, radius_tangent: f64) -> bool {
        let margin_rad = self.camera.pixel_tangent();
        direction.dot(self.camera.forward).clamp(-1.0, 1.0).acos() < self.camera.corner_rad() + (1.5 * radius_tangent).atan() + margin_rad
    }

    /// A patch, if it may be in the frame. `axes`: perpendicular unit vectors across the line of sight.
    fn patch(&self, sight: &Sight, axes: [DVec3; 2], radii: DVec2, radiance: f64, core: f64, colour: DVec3) -> Option<LightPatch> {
        let radii = radii.min(DVec2::splat(MAX_TANGENT));
        self.may_show(sight.direction, radii.max_element()).then(|| LightPatch {
            centre: self.in_clip(sight.direction),
            axes: [self.in_clip(axes[0] * radii.x), self.in_clip(axes[1] * radii.y)],
            radii: narrow2(radii),
            radiance: narrow_scalar(radiance),
            core: narrow_scalar(core),
            depth: narrow_scalar(sight.depth),
            colour: narrow(colour * sight.transmittance),
        })
    }

    /// The patch of a cloud: a Gaussian with the covariance of the cloud as seen from the camera.
    fn patch_of(&self, cloud: &Cloud, colour: DVec3) -> Option<LightPatch> {
        let sight = self.sight(cloud.position_au)?;
        let (x, y) = sight.true_direction.any_orthonormal_pair();
        let [a, b] = cloud.sides_au.map(|side| DVec2::new(side.dot(x), side.dot(y)) * (CELL_SIGMA / sight.distance_au));
        let spread_sq = (cloud.sigma_au / sight.distance_au).powi(2) + (MIN_SIGMA_PX * self.camera.pixel_tangent()).powi(2);
        // The covariance is [[xx, xy], [xy, yy]] plus `spread_sq` in all directions; its eigenvalues are `mean` +- `root`, and the axis of the greater one has
        // the angle `axis_rad` from x.
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, half_difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let root = half_difference.hypot(xy);
        let axis_rad = 0.5 * xy.atan2(half_difference);
        let radii = DVec2::new(mean + root + spread_sq, (mean - root).max(0.0) + spread_sq).map(f64::sqrt) * RADIUS_SIGMAS;
        // Aberration turns the axes with the direction.
        let turn = DQuat::from_rotation_arc(sight.true_direction, sight.direction);
        let (sin, cos) = axis_rad.sin_cos();
        let axes = [turn * (x * cos + y * sin), turn * (y * cos - x * sin)];
        // The integral of (1 - r^2)^3 over the ellipse is a quarter of its area. A radiance L in the solid angle w gives the irradiance L w / pi.
        let irradiance = cloud.irradiance_at_1_au / sight.distance_au.powi(2);
        self.patch(&sight, axes, radii, 4.0 * irradiance / (radii.x * radii.y), 0.0, colour)
    }

    /// The coma, whose light falls as 1 / (distance from the nucleus) and fades to nothing at its radius.
    pub(super) fn coma(&self, sight: &Sight, irradiance: f64, radius_au: f64) -> Option<LightPatch> {
        let full_radius = radius_au / sight.distance_au;
        let radius = full_radius.min(MAX_TANGENT);
        let core = (MIN_CORE_PX * self.camera.pixel_tangent() / radius).max(MIN_CORE);
        // Integral of the shader's profile, core (1 - r^2)^2 / sqrt(r^2 + core^2), over the unit circle: with a = 1 + core^2 and s^2 = r^2 + core^2 it is
        // 2 pi core times that of (a - s^2)^2 over s from the core's radius to the root of a.
        let a = 1.0 + core * core;
        let primitive = |s: f64| s * (a * a - 2.0 / 3.0 * a * s * s + 0.2 * s.powi(4));
        let integral = 2.0 * PI * core * (primitive(a.sqrt()) - primitive(core));
        // The light within a distance is nearly proportional to that distance, so a coma that is cut off loses light in the same proportion.
        let radiance = irradiance * (radius / full_radius) * PI / (integral * radius * radius);
        let (x, y) = sight.direction.any_orthonormal_pair();
        self.patch(sight, [x, y], DVec2::splat(radius), radiance, core, of_luminance_1(COMA_RGB))
    }

    /// Adds the dust tail. `days`: time past J2000; `irradiance_at_1_au`: of the entire tail, at a distance of 1 au, if all dust had the comet's phase angle;
    /// `production`: see [`water_production`].
    pub(super) fn dust(
        &self,
        orbit: &HeliocentricOrbit,
        days: f64,
        irradiance_at_1_au: f64,
        production: f64,
        patches: &mut Vec<LightPatch>,
    ) {
        let root_sigma_au = ROOT_SIGMA * coma_radius_au(production);
        // Corners of the cells. Ages are more densely spaced for recently released grains.
        let age_days = |k: f64| MAX_AGE_DAYS * (k / AGE_CELLS as f64).powf(1.75);
        let beta = |line: f64| MIN_BETA * (MAX_BETA / MIN_BETA).powf(line / BETA_CELLS as f64);
        let released: Vec<ConicState> = (0..=AGE_CELLS).map(|k| heliocentric_state(orbit, days - age_days(k as f64))).collect();
        let syndyne =
            |line: usize| (0..=AGE_CELLS).map(|k| drifted_au(&released[k], age_days(k as f64), beta(line as f64))).collect::<Vec<_>>();
        let grains: Vec<Vec<DVec3>> = (0..=BETA_CELLS).map(syndyne).collect();
        // Of one cell: relative scattering area.
        let area = |line: usize| {
            let beta = beta(line as f64 + 0.5);
            beta.powf(AREA_EXPONENT) * (-(beta / FALLING_FROM_BETA).powi(2)).exp()
        };
        let mut clouds = Vec::with_capacity(AGE_CELLS * BETA_CELLS);
        for k in 0..AGE_CELLS {
            let age = age_days(k as f64 + 0.5);
            let sigma_au = |beta: f64| root_sigma_au + GRAIN_SPEED_AU_PER_DAY * beta.sqrt() * age;
            // Cells of beta are drawn as one patch if they differ less than the spread of each.
            let extent_au = |count: usize| grains[BETA_CELLS][k + 1].distance(grains[BETA_CELLS - count][k + 1]);
            let merged_count = [BETA_CELLS, 6, 4, 3, 2].into_iter().find(|count| extent_au(*count) < sigma_au(1.0)).unwrap_or(1);
            // Grains are produced and lit in inverse proportion to the squared distance from the Sun. The exponential, lowered to 0 at the largest age,
            // thins out old grains (they break up and disperse), so that the tail has no visible end.
            let released_au_sq = released[k].position.length() * released[k + 1].position.length();
            let left = (-age / AGE_SCALE_DAYS).exp() - (-MAX_AGE_DAYS / AGE_SCALE_DAYS).exp();
            let light = (age_days(k as f64 + 1.0) - age_days(k as f64)) * left / released_au_sq;
            for line in (0..BETA_CELLS).step_by(merged_count) {
                let next = line + merged_count;
                let [a, b, c, d] = [grains[line][k], grains[line][k + 1], grains[next][k], grains[next][k + 1]];
                let position_au = 0.25 * (a + b + c + d);
                clouds.push(Cloud {
                    position_au,
                    sides_au: [0.5 * (c + d - a - b), 0.5 * (b + d - a - c)],
                    sigma_au: sigma_au(beta(0.5 * (line + next) as f64)),
                    irradiance_at_1_au: (line..next).map(area).sum::<f64>() * light / position_au.length_squared(),
                });
            }
        }
        // Light that the dust at a place scatters to the camera, relative to that at a phase angle of 90 degrees.
        let scattered = |position_au: DVec3| comet_dust_law(angle_rad(self.camera_au - position_au, -position_au));
        let scattered_at_comet = scattered(released[0].position);
        let total: f64 = clouds.iter().map(|c| c.irradiance_at_1_au).sum();
        // A B-V of 0.8 is slightly redder than sunlight.
        let colour = star_colour(Some(0.8));
        for cloud in clouds {
            let share = cloud.irradiance_at_1_au / total * scattered(cloud.position_au) / scattered_at_comet;
            patches.extend(self.patch_of(&Cloud { irradiance_at_1_au: irradiance_at_1_au * share, ..cloud }, colour));
        }
    }

    /// Adds the ion tail, which is straight. `irradiance_at_1_au`: of the entire tail, at a distance of 1 au; `production`: see [`water_production`].
    pub(super) fn ions(&self, state: &ConicState, irradiance_at_1_au: f64, production: f64, patches: &mut Vec<LightPatch>) {
        let direction = ion_direction(state);
        let length_au = (ION_LENGTH_AU * production.sqrt()).min(MAX_ION_LENGTH_AU);
        // Distance of a piece's end from the comet; pieces are shorter near the comet.
        let end_au = |k: usize| length_au * (k as f64 / ION_PIECES as f64).powf(1.5);
        // Relative light of the part of the tail beyond a distance: an exponential that falls by e^3 over the length, lowered to 0 at the end.
        let light_beyond = |distance_au: f64| (-3.0 * distance_au / length_au).exp() - (-3.0_f64).exp();
        let colour = of_luminance_1(ION_RGB);
        for k in 0..ION_PIECES {
            let (start, end) = (end_au(k), end_au(k + 1));
            let middle = 0.5 * (start + end);
            let cloud = Cloud {
                position_au: state.position + direction * middle,
                sides_au: [direction * (end - start), DVec3::ZERO],
                sigma_au: ROOT_SIGMA * coma_radius_au(production) + ION_SIGMA_TANGENT * middle,
                irradiance_at_1_au: irradiance_at_1_au * (light_beyond(start) - light_beyond(end)) / light_beyond(0.0),
            };
            patches.extend(self.patch_of(&cloud, colour));
        }
    }
}
