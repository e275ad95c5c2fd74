//! How bright the sky is that the air scatters, by the altitude of the light source (the Sun, or a body that shines by reflected sunlight), the height of the
//! camera and the direction in the sky: for the exposure of images under that sky.
//!
//! In: the atmosphere of a body. Out: [`SkyBrightness`], at six heights of the camera the luminance (the weighted sum of the channels' radiances) of the sky
//! above the horizon, per irradiance of the source: in 16 directions ([`SkyDome`]) and in the mean; and the altitude of the Sun at which the Earth's sky is as
//! dark, compared with its day, as this sky is compared with its own ([`SkyBrightness::altitude_on_earth_deg`]).
//! Method: light of the source that the air scatters once is summed along rays over the whole sky. What the air scatters out of such a ray is not all lost:
//! scattered again, a part of it still comes down. A two-stream approximation (one stream up, one down) adds this part. Left out: light that the ground
//! reflects. When the source is so far below the horizon that only light scattered twice is left, the logarithm of the mean continues to fall at the rate that
//! it has reached. Light scattered twice also comes from where the air is in the body's shadow: an estimated fraction of the mean luminance is taken to be
//! the same in every direction ([`TwoStreamSky::isotropic_fraction`]). For views in several directions, at heights up to half the height of the air, the mean
//! over the sky in the view is within a factor of 3 of that of a rendered image (tests/atmosphere/dusk_at_height.rs). Excepted are the lowest 3 degrees, below
//! the lowest rays, where an arch of dusk is up to 20 times brighter. Computed once for each air, in some 50 ms: [`SkyBrightnessCache`] keeps the result from
//! frame to frame.

use crate::catalog::{Atmosphere, Species};
use crate::memo::{Memo, NumbersKey};
use crate::scene::atmosphere::air_sphere::direction;
use crate::scene::atmosphere::constituent::{Constituent, visible_source_fraction};
use crate::scene::atmosphere::extinction::{column_above_km, density, quadrature};
use crate::scene::atmosphere::phase;
use crate::scene::numeric::gauss_legendre;
use crate::units::luminance;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Zenith angles and azimuths of the rays, and steps along each. With six zenith angles, six azimuths and 64 steps, the radiance differs by less than 25 % at
/// all altitudes of the source at which it exceeds 1e-3 of the radiance by day.
const ZENITH_ANGLES: usize = 4;
const AZIMUTHS: usize = 4;
const STEPS: usize = 32;
const RAYS: usize = ZENITH_ANGLES * AZIMUTHS;
/// Altitude of the lowest rays, degrees.
const LOWEST_RAY_DEG: f64 = 4.0;

/// Altitudes of the light source, degrees: in steps of one degree from the first to the second number, then in steps of 15 up to the zenith.
const FINE_ALTITUDES_DEG: (f64, f64) = (-45.0, 15.0);
const COARSE_STEP_DEG: f64 = 15.0;
/// Number of altitudes: 61 in the fine steps, 5 in the coarse ones.
const ALTITUDES: usize = 66;
/// Heights of the camera as fractions of the air's height. Above the last one, what is left of the air is about a scale height or less: its light is taken to
/// be proportional to its thickness.
const HEIGHT_PARTS: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95];
const LAST_HEIGHT_PART: f64 = HEIGHT_PARTS[HEIGHT_PARTS.len() - 1];

/// Lower limit of the luminances per irradiance, for their logarithms.
const MIN_LUMINANCE: f64 = 1e-30;
/// The fraction of the mean luminance that is isotropic, for a camera on the ground in thin air. All three constants are chosen so that the views of
/// tests/atmosphere/dusk_at_height.rs agree with rendered images; most of the light of those away from the Sun in dusk is isotropic. On Jupiter, Saturn and
/// Venus (scattering optical depths 0.01 to 0.03) a tenth fits, on Mars (0.5) half of the mean, on Titan (3) all of it.
const ISOTROPIC_FRACTION_OF_THIN_AIR: f64 = 0.1;
/// The scattering optical depth of the air above the ground at which the fraction is half-way between that of thin air and 1.
const ISOTROPIC_HALF_DEPTH: f64 = 0.5;
/// Above the ground the fraction is proportional to this power of the scattering optical depth of the air above the camera.
const ISOTROPIC_COLUMN_EXPONENT: f64 = 0.4;

/// At and above this altitude of the Sun, degrees, images under a sky are exposed as by day, for the sunlit ground.
const DAY_ALTITUDE_DEG: f64 = 5.0;
/// The sum along rays is used as it is down to this fraction of the sky's radiance at [`DAY_ALTITUDE_DEG`]. A darker sky is taken to show light that
/// has been scattered more than once, which the sum leaves out.
const MIN_TRUSTED_RELATIVE_RADIANCE: f64 = 3e-4;
/// The sky of the Earth, seen from the ground: altitude of the Sun in degrees, and radiance relative to that at [`DAY_ALTITUDE_DEG`]. Computed by this module
/// from the catalog's air. Between altitudes the logarithm is linear.
const EARTH_SKY: [(f64, f64); 17] = [
    (-18.0, 1.295e-8),
    (-10.0, 3.880e-5),
    (-9.0, 1.055e-4),
    (-8.0, 2.870e-4),
    (-7.0, 7.808e-4),
    (-6.0, 2.187e-3),
    (-5.0, 6.123e-3),
    (-4.0, 0.01667),
    (-3.0, 0.04213),
    (-2.0, 0.09407),
    (-1.0, 0.1855),
    (0.0, 0.3092),
    (1.0, 0.4410),
    (2.0, 0.5875),
    (3.0, 0.7362),
    (4.0, 0.8755),
    (DAY_ALTITUDE_DEG, 1.0),
];

/// The number of airs whose brightness is kept: more than the catalog has.
const CACHE_CAPACITY: usize = 16;

/// The altitude of an element of a row, in degrees. A row ([`HeightRow`]) has one value for each of the [`ALTITUDES`].
fn altitude_deg(index: usize) -> f64 {
    let (lowest, coarse_from) = FINE_ALTITUDES_DEG;
    let fine = lowest + index as f64;
    if fine <= coarse_from { fine } else { coarse_from + COARSE_STEP_DEG * (fine - coarse_from) }
}

/// The inverse of [`altitude_deg`]: a fractional index.
fn position_in_row(altitude_deg: f64) -> f64 {
    let (lowest, coarse_from) = FINE_ALTITUDES_DEG;
    let above = altitude_deg - coarse_from;
    coarse_from - lowest + if above <= 0.0 { above } else { above / COARSE_STEP_DEG }
}

/// Index of the element of a row below an altitude, and the fraction of the way from it to the next element. Below the first altitude the index is 0 and the
/// fraction negative, so that the row continues linearly.
fn index_and_fraction(altitude_deg: f64) -> (usize, f64) {
    let position = position_in_row(altitude_deg);
    let below = (position.max(0.0) as usize).min(ALTITUDES - 2);
    (below, position - below as f64)
}

/// The mean over the sky of values for its rays.
fn mean_of_rays(values: &[f64; RAYS]) -> f64 {
    let means = values.chunks_exact(AZIMUTHS).map(|at_zenith_angle| at_zenith_angle.iter().sum::<f64>() / AZIMUTHS as f64);
    means.zip(gauss_legendre(ZENITH_ANGLES)).map(|(mean, (_, weight))| mean * weight).sum()
}

/// A spherical atmosphere, with the brightness of its sky by single scattering and the two-stream approximation.
struct TwoStreamSky<'a> {
    radius_km: f64,
    top_km: f64,
    constituents: Vec<Constituent<'a>>,
}

impl TwoStreamSky<'_> {
    /// Radiance of the sky along a ray that leaves the air at its top, per irradiance of the light source; in the shaders' unit of radiance, that is,
    /// multiplied by pi. `from`: start of the ray relative to the body's centre, km; `along`: the ray's direction, `light`: the direction towards the source,
    /// unit vectors; `zenith_cosine`: of the ray at its start.
    fn radiance_along(&self, from: DVec3, along: DVec3, zenith_cosine: f64, light: DVec3) -> DVec3 {
        // Positions on the ray are counted from the point of its line that is nearest to the centre. The line leaves the air half a chord after this point.
        let start_km = from.dot(along);
        let half_chord_sq = (self.radius_km + self.top_km).powi(2) - (from.length_squared() - start_km * start_km);
        let length_km = half_chord_sq.max(0.0).sqrt() - start_km;
        // Light that a constituent scatters into the ray, per kilometre at density 1 and per irradiance.
        let into_ray_of = |c: &Constituent<'_>| c.scattering * phase::per_steradian(c.species.phase, along.dot(light)) * PI;
        let into_ray: Vec<DVec3> = self.constituents.iter().map(into_ray_of).collect();
        // Optical depths from the start of the ray: of absorption, and of reduced scattering.
        let (mut absorption_depth, mut reduced_scattering_depth, mut radiance) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (fraction, weight) in quadrature(STEPS) {
            let point = from + along * (length_km * fraction);
            let from_centre_km = point.length();
            let height_km = from_centre_km - self.radius_km;
            let cosine = point.dot(light) / from_centre_km;
            let visible_fraction = visible_source_fraction(self.radius_km, self.top_km, from_centre_km, cosine);
            let (mut step_absorption, mut step_reduced_scattering) = (DVec3::ZERO, DVec3::ZERO);
            let (mut scattered_into_ray, mut depth_to_light) = (DVec3::ZERO, DVec3::ZERO);
            for (c, into_ray) in self.constituents.iter().zip(&into_ray) {
                let column_km = density(c.species, height_km) * length_km * weight;
                step_absorption += (c.extinction - c.scattering) * column_km;
                step_reduced_scattering += c.scattering * c.reduced_scattering_factor * column_km;
                scattered_into_ray += *into_ray * column_km;
                if visible_fraction > 0.0 {
                    depth_to_light += c.extinction * c.column_to_light_km(self.radius_km, from_centre_km, cosine);
                }
            }
            // Depths up to the middle of the step.
            let (absorption_here, reduced_scattering_here) =
                (absorption_depth + step_absorption * 0.5, reduced_scattering_depth + step_reduced_scattering * 0.5);
            (absorption_depth, reduced_scattering_depth) =
                (absorption_depth + step_absorption, reduced_scattering_depth + step_reduced_scattering);
            if visible_fraction > 0.0 {
                let direct_transmittance = (-(absorption_here + reduced_scattering_here)).exp();
                let vertical_reduced_scattering = reduced_scattering_here * zenith_cosine;
                // The two-stream transmittance of the vertical depth t is 1 / (1 + 3/4 t). Of it, exp(-t) is subtracted: light that arrives without being
                // scattered again is in `direct_transmittance` already.
                let by_streams = (-absorption_here * zenith_cosine).exp()
                    * ((vertical_reduced_scattering * 0.75 + 1.0).recip() - (-vertical_reduced_scattering).exp());
                // The streams carry the light of a horizontal layer, whose thickness is the step's length times `zenith_cosine`.
                radiance +=
                    scattered_into_ray * (direct_transmittance + by_streams * zenith_cosine) * (-depth_to_light).exp() * visible_fraction;
            }
        }
        radiance
    }

    /// Luminance along each ray above the horizon of a camera at this height: [`AZIMUTHS`] rays at each of the zenith angles, those near the horizon first.
    fn ray_luminances(&self, height_km: f64, altitude_deg: f64) -> [f64; RAYS] {
        let azimuth_rad = 0.0;
        let light = direction(altitude_deg.to_radians().sin(), azimuth_rad);
        let from = DVec3::Z * (self.radius_km + height_km);
        let mut luminances = [0.0; RAYS];
        for (at_zenith_angle, (cosine, _)) in luminances.chunks_exact_mut(AZIMUTHS).zip(gauss_legendre(ZENITH_ANGLES)) {
            // The sky is symmetric about the vertical plane through the source.
            for (k, value) in at_zenith_angle.iter_mut().enumerate() {
                let along = direction(cosine, PI * (k as f64 + 0.5) / AZIMUTHS as f64);
                *value = luminance(self.radiance_along(from, along, cosine, light).to_array());
            }
        }
        luminances
    }

    /// The fraction of a sky's mean luminance that is the same in every direction, because the air has scattered this light more than once. It decreases with
    /// the air above the camera.
    fn isotropic_fraction(&self, height_km: f64) -> f64 {
        let depth_above = |height_km: f64| {
            let depth: DVec3 = self.constituents.iter().map(|c| c.scattering * column_above_km(c.species, height_km)).sum();
            luminance(depth.to_array())
        };
        let depth_above_ground = depth_above(0.0);
        let on_ground = ISOTROPIC_FRACTION_OF_THIN_AIR
            + (1.0 - ISOTROPIC_FRACTION_OF_THIN_AIR) * depth_above_ground / (depth_above_ground + ISOTROPIC_HALF_DEPTH);
        on_ground * (depth_above(height_km) / depth_above_ground.max(f64::MIN_POSITIVE)).powf(ISOTROPIC_COLUMN_EXPONENT)
    }

    /// The sky of a camera at this height, at all altitudes of the source. At altitudes of the source at which the mean is darker than
    /// [`MIN_TRUSTED_RELATIVE_RADIANCE`], the mean's logarithm falls from each altitude to the next lower one by at most as much as in the step before.
    fn row(&self, height_km: f64) -> HeightRow {
        let by_sum: Vec<[f64; RAYS]> = (0..ALTITUDES).map(|k| self.ray_luminances(height_km, altitude_deg(k))).collect();
        let mut means: Vec<f64> = by_sum.iter().map(|rays| mean_of_rays(rays).max(MIN_LUMINANCE).ln()).collect();
        let min_trusted_ln = ln_between(&means, DAY_ALTITUDE_DEG) + MIN_TRUSTED_RELATIVE_RADIANCE.ln();
        let last_fine = position_in_row(FINE_ALTITUDES_DEG.1) as usize;
        for k in (0..last_fine - 1).rev() {
            if means[k + 1] < min_trusted_ln {
                means[k] = means[k].max(2.0 * means[k + 1] - means[k + 2]);
            }
        }
        let isotropic_fraction = self.isotropic_fraction(height_km);
        let at_altitude = |(mean_ln, by_sum): (&f64, &[f64; RAYS])| {
            let isotropic = isotropic_fraction * mean_ln.exp();
            by_sum.map(|luminance| (isotropic + (1.0 - isotropic_fraction) * luminance).max(MIN_LUMINANCE).ln())
        };
        let rays = means.iter().zip(&by_sum).map(at_altitude).collect();
        HeightRow { means, rays }
    }
}

/// The luminance of the sky at an angle above a light source, in the vertical plane through it, per irradiance of the source, as in
/// [`TwoStreamSky::ray_luminances`]; not lower than the lowest rays. Between the rays of a [`SkyDome`], which are 45 degrees apart in azimuth, the bright
/// aureole around the source is lost: in the dust of Mars it is three times as bright 6 degrees from the Sun as at 20 degrees. All scattering takes light from
/// the aureole, also forwards by some degrees: with the reduced scattering it would be up to five times too bright. So it is 0.7 to 1 times that of drawn
/// images on Mars, from noon until sunset (computed in another language, not a test).
pub(crate) fn luminance_above_light(air: &Atmosphere, radius_km: f64, height_km: f64, altitude_deg: f64, angle_deg: f64) -> f64 {
    let constituent = |species| Constituent { reduced_scattering_factor: DVec3::ONE, ..Constituent::of(species) };
    let sky = TwoStreamSky { radius_km, top_km: air.top_km, constituents: air.species.iter().map(constituent).collect() };
    let (sin, cos) = altitude_deg.to_radians().sin_cos();
    // Beyond the zenith the altitude exceeds 90 degrees.
    let (sin_ray, cos_ray) = (altitude_deg + angle_deg).clamp(LOWEST_RAY_DEG, 180.0 - LOWEST_RAY_DEG).to_radians().sin_cos();
    let from = DVec3::Z * (radius_km + height_km.clamp(0.0, air.top_km));
    let radiance = sky.radiance_along(from, DVec3::new(cos_ray, 0.0, sin_ray), sin_ray, DVec3::new(cos, 0.0, sin));
    luminance(radiance.to_array())
}

/// Interpolates a row of logarithms at an altitude of the source; below its first altitude it continues linearly.
fn ln_between(row: &[f64], altitude_deg: f64) -> f64 {
    let (below, fraction) = index_and_fraction(altitude_deg);
    row[below] + fraction * (row[below + 1] - row[below])
}

/// The sky of a camera at one height: natural logarithms of luminances per irradiance of the source, at all altitudes of the source, lowest first.
#[derive(Debug)]
struct HeightRow {
    /// Of the mean over the sky.
    means: Vec<f64>,
    /// Along each ray, as in [`TwoStreamSky::ray_luminances`].
    rays: Vec<[f64; RAYS]>,
}

/// The luminance of the sky by direction, for one altitude of the light source and one height of the camera.
pub(crate) struct SkyDome {
    /// Natural logarithms, as in [`TwoStreamSky::ray_luminances`].
    rays: [f64; RAYS],
    /// Of the rays, ascending.
    zenith_cosines: [f64; ZENITH_ANGLES],
}

impl SkyDome {
    /// The luminance in a direction: between rays the logarithm is linear in the zenith cosine and in the azimuth. Lower than the lowest rays, which are 4
    /// degrees above the horizon, and higher than the highest ones it is that of the nearest ray. `azimuth_rad`: from the light source's, 0 to pi.
    pub(crate) fn luminance(&self, zenith_cosine: f64, azimuth_rad: f64) -> f64 {
        let cosines = &self.zenith_cosines;
        let lower = cosines.iter().rposition(|cosine| *cosine <= zenith_cosine).unwrap_or(0).min(ZENITH_ANGLES - 2);
        let rise = ((zenith_cosine - cosines[lower]) / (cosines[lower + 1] - cosines[lower])).clamp(0.0, 1.0);
        let azimuth = (azimuth_rad / PI * AZIMUTHS as f64 - 0.5).clamp(0.0, (AZIMUTHS - 1) as f64);
        let first = (azimuth as usize).min(AZIMUTHS - 2);
        let turn = azimuth - first as f64;
        let [ln_lower, ln_upper] = [lower, lower + 1].map(|zenith_angle| {
            let [ln_first, ln_second] = [first, first + 1].map(|k| self.rays[zenith_angle * AZIMUTHS + k]);
            ln_first + turn * (ln_second - ln_first)
        });
        (ln_lower + rise * (ln_upper - ln_lower)).exp()
    }
}

/// The sky's luminance, by the light source's altitude and the camera's height.
#[derive(Debug)]
pub(crate) struct SkyBrightness {
    /// One row for each of [`HEIGHT_PARTS`].
    rows: [HeightRow; HEIGHT_PARTS.len()],
}

impl SkyBrightness {
    /// `radius_km`: of the ground.
    fn of(air: &Atmosphere, radius_km: f64) -> Self {
        let constituents = air.species.iter().map(Constituent::of).collect();
        let sky = TwoStreamSky { radius_km, top_km: air.top_km, constituents };
        Self { rows: HEIGHT_PARTS.map(|part| sky.row(part * air.top_km)) }
    }

    /// Interpolates between the rows below and above a height, a fraction of the air's height. `ln_at`: reads the logarithm to
    /// be interpolated from a row.
    fn ln_at_height(&self, height_part: f64, ln_at: impl Fn(&HeightRow) -> f64) -> f64 {
        let below = HEIGHT_PARTS.iter().rposition(|part| *part <= height_part).unwrap_or(0).min(HEIGHT_PARTS.len() - 2);
        let rows = [&self.rows[below], &self.rows[below + 1]];
        let fraction = ((height_part - HEIGHT_PARTS[below]) / (HEIGHT_PARTS[below + 1] - HEIGHT_PARTS[below])).clamp(0.0, 1.0);
        let [lower, upper] = rows.map(ln_at);
        let thickness = ((1.0 - height_part) / (1.0 - LAST_HEIGHT_PART)).clamp(f64::MIN_POSITIVE, 1.0);
        lower + fraction * (upper - lower) + thickness.ln()
    }

    /// The mean luminance of the sky under a source of irradiance 1 at this altitude, in the shaders' unit of radiance. `height_part`: the camera's height as a
    /// fraction of the air's height.
    pub(crate) fn luminance(&self, altitude_deg: f64, height_part: f64) -> f64 {
        self.ln_at_height(height_part, |row| ln_between(&row.means, altitude_deg)).exp()
    }

    /// The same by direction.
    pub(crate) fn dome(&self, altitude_deg: f64, height_part: f64) -> SkyDome {
        let (below, fraction) = index_and_fraction(altitude_deg);
        let ln_ray = |row: &HeightRow, k: usize| row.rays[below][k] + fraction * (row.rays[below + 1][k] - row.rays[below][k]);
        let nodes = gauss_legendre(ZENITH_ANGLES);
        SkyDome {
            rays: std::array::from_fn(|k| self.ln_at_height(height_part, |row| ln_ray(row, k))),
            zenith_cosines: std::array::from_fn(|k| nodes[k].0),
        }
    }

    /// The equivalent altitude of the Sun on the Earth: there the Earth's sky has the same relative radiance as this sky under a source at `altitude_deg`, both
    /// seen from the ground. The relative radiance of each sky is that divided by the radiance with the source at [`DAY_ALTITUDE_DEG`]. At and above
    /// [`DAY_ALTITUDE_DEG`] the result is `altitude_deg` itself. The result is at least -18 degrees, where night begins.
    pub(crate) fn altitude_on_earth_deg(&self, altitude_deg: f64) -> f64 {
        if altitude_deg >= DAY_ALTITUDE_DEG { altitude_deg } else { self.altitude_of_dimmed_sky_deg(altitude_deg, 1.0) }
    }

    /// The same for a dimmed sky. `light_fraction`: its radiance divided by that of the sky seen from the ground under the same source, 0 to 1. The result is
    /// at most [`DAY_ALTITUDE_DEG`], also for a higher source.
    pub(crate) fn altitude_of_dimmed_sky_deg(&self, altitude_deg: f64, light_fraction: f64) -> f64 {
        let [HeightRow { means, .. }, ..] = &self.rows;
        let undimmed_ln = ln_between(means, altitude_deg.min(DAY_ALTITUDE_DEG)) - ln_between(means, DAY_ALTITUDE_DEG);
        let relative_ln = undimmed_ln + light_fraction.max(f64::MIN_POSITIVE).ln();
        let table = &EARTH_SKY;
        let below = table.iter().rposition(|(_, relative)| relative.ln() <= relative_ln).unwrap_or(0).min(table.len() - 2);
        let ((deg0, relative0), (deg1, relative1)) = (table[below], table[below + 1]);
        let fraction = ((relative_ln - relative0.ln()) / (relative1 / relative0).ln()).clamp(0.0, 1.0);
        deg0 + fraction * (deg1 - deg0)
    }
}

/// The brightness of skies, kept from frame to frame.
#[derive(Debug)]
pub(crate) struct SkyBrightnessCache(Memo<NumbersKey, Arc<SkyBrightness>>);

impl Default for SkyBrightnessCache {
    fn default() -> Self {
        Self(Memo::with_capacity(CACHE_CAPACITY))
    }
}

impl SkyBrightnessCache {
    /// The brightness of the sky of this air, over ground of this radius.
    pub(crate) fn of(&self, air: &Atmosphere, radius_km: f64) -> Arc<SkyBrightness> {
        let key = [radius_km, air.top_km].into_iter().chain(air.species.iter().flat_map(Species::optical_numbers)).collect();
        self.0.get(key, || Arc::new(SkyBrightness::of(air, radius_km)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// What to do if a result exceeds a limit that was set from this module's own results, not from observations.
    const REMEDY: &str =
        "if this air was changed, set the limit a fifth beyond the new value, also in the comment; if the value jumps, find the cause";

    fn brightness(catalog: &Catalog, id: NaifId) -> SkyBrightness {
        let body = catalog.body(id).expect("a body");
        SkyBrightness::of(body.atmosphere.as_ref().expect("air"), body.radii_km.x)
    }

    /// [`EARTH_SKY`] agrees with this module's result for the catalog's air to 1 % (0.014 stops), so that on the Earth `altitude_on_earth_deg` returns its
    /// argument. For the same air over a ground with the radius of Mars, some value differs by more than half.
    #[test]
    fn the_sky_of_the_earth_is_that_of_its_air() {
        let catalog = Catalog::embedded();
        let earth = catalog.body(NaifId::EARTH).expect("the Earth");
        let air = earth.atmosphere.as_ref().expect("air");
        let on_ground = 0.0;
        let relative = |sky: &SkyBrightness, deg: f64| sky.luminance(deg, on_ground) / sky.luminance(DAY_ALTITUDE_DEG, on_ground);
        let errors = |sky: &SkyBrightness| EARTH_SKY.map(|(deg, expected)| (relative(sky, deg) / expected - 1.0).abs());
        let error = |sky: &SkyBrightness| errors(sky).into_iter().fold(0.0, f64::max);
        let [sky, on_mars] = [earth.radii_km.x, 3400.0].map(|radius_km| SkyBrightness::of(air, radius_km));
        let rows = EARTH_SKY.map(|(deg, _)| format!("    ({deg:?}, {:.3e}),\n", relative(&sky, deg))).concat();
        assert!(error(&sky) < 0.01, "the rows of EARTH_SKY in src/scene/atmosphere/sky_brightness.rs should be\n{rows}");
        assert!(error(&on_mars) > 0.5, "the check above does not distinguish the Earth from Mars");
        for deg in [-17.9, -12.5, -9.5, -3.3, 0.7, 4.9, 5.1, 60.0] {
            let found = sky.altitude_on_earth_deg(deg);
            assert!((found - deg).abs() < 0.02, "{deg} degrees: {found}");
        }
        assert_eq!(sky.altitude_on_earth_deg(-60.0), -18.0);
    }

    /// Where most light is scattered once, the mean over the dome's directions is the mean luminance of the sky. High in the air, in dusk, the sky away
    /// from the source is much darker than the mean, on the ground it is not. From direction to direction there is no jump, also through the zenith and to the
    /// horizon.
    #[test]
    fn the_dome_is_the_sky_by_direction() {
        let catalog = Catalog::embedded();
        let sky = brightness(&catalog, NaifId::EARTH);
        for (deg, height_part) in [(10.0, 0.0), (0.0, 0.05), (-3.0, 0.5)] {
            let dome = sky.dome(deg, height_part);
            let mean = mean_of_rays(&dome.rays.map(f64::exp));
            assert!((mean / sky.luminance(deg, height_part) - 1.0).abs() < 1e-9, "{deg} degrees, {height_part}: {mean}");
            assert!((mean / sky.luminance(deg, height_part + 0.1) - 1.0).abs() > 0.01, "the check above cannot fail");
        }
        let zenith_cosine = 50_f64.to_radians().sin();
        let away = |height_part: f64| sky.dome(-8.0, height_part).luminance(zenith_cosine, PI) / sky.luminance(-8.0, height_part);
        assert!((0.2..0.35).contains(&away(0.0)) && away(0.2) < 0.15, "{} and {}; {REMEDY}", away(0.0), away(0.2));
        let dome = sky.dome(-5.0, 0.2);
        let steps = (0..=100).map(|k| 0.01 * f64::from(k)).flat_map(|part| {
            let ln = |zenith_cosine: f64, azimuth_rad: f64| dome.luminance(zenith_cosine, azimuth_rad).ln();
            [ln(part + 0.01, 1.0) - ln(part, 1.0), ln(0.5, PI * (part + 0.01)) - ln(0.5, PI * part)]
        });
        let largest = steps.map(f64::abs).fold(0.0, f64::max);
        assert!(largest < 0.15, "{largest}; {REMEDY}");
    }

    /// On the Earth, a sky with half its light is the sky of a lower Sun. With all its light it is the sky of the same Sun, or of one at [`DAY_ALTITUDE_DEG`]
    /// if that is lower.
    #[test]
    fn a_dimmed_sky_is_that_of_a_lower_sun() {
        let sky = brightness(&Catalog::embedded(), NaifId::EARTH);
        for (deg, undimmed) in [(-3.0, -3.0), (4.0, 4.0), (40.0, 5.0)] {
            let [all, half, none] = [1.0, 0.5, 0.0].map(|part| sky.altitude_of_dimmed_sky_deg(deg, part));
            assert!((all - undimmed).abs() < 0.02 && half < all - 0.5 && none == -18.0, "{deg} degrees: {all}, {half}, {none}");
        }
    }

    /// The sky of every body darkens as the source sinks (a sum over a few rays of thin air may brighten by 1 %), without a jump. Nor is there a jump as the
    /// camera rises. Where the air is tall relative to the body (Mars, Titan, Pluto) the sky darkens more slowly than the Earth's, where it is shallow
    /// (Jupiter) faster.
    #[test]
    fn skies_darken_steadily() {
        let catalog = Catalog::embedded();
        for body in catalog.bodies().iter().filter(|b| b.atmosphere.is_some()) {
            let sky = brightness(&catalog, body.id);
            let ln = |deg: f64, height_part: f64| sky.luminance(deg, height_part).max(1e-200).ln();
            for k in -400..50 {
                let (lower, upper) = (0.1 * f64::from(k), 0.1 * f64::from(k + 1));
                let rise = ln(lower, 0.0) - ln(upper, 0.0);
                assert!(rise <= 0.01, "{} at {lower} degrees: {rise}; {REMEDY}", body.name);
                let step = sky.altitude_on_earth_deg(upper) - sky.altitude_on_earth_deg(lower);
                assert!((-0.1..0.8).contains(&step), "{} at {lower} degrees: {step} degrees on the Earth; {REMEDY}", body.name);
            }
            // Higher up, too. The sum over a few rays of thin air may brighten, by 5 % at most while the source sinks by five degrees.
            for height_part in [0.1, 0.35, 0.65, 0.8, 0.9, 0.99] {
                for k in -40..=0 {
                    let (lower, upper) = (f64::from(k - 5), f64::from(k));
                    let rise = ln(lower, height_part) - ln(upper, height_part);
                    assert!(rise <= 0.05, "{} at {height_part}, {lower} degrees: {rise}; {REMEDY}", body.name);
                }
            }
            // In the last twentieth the light falls to 0.
            for k in 0..95 {
                let step = ln(-3.0, 0.01 * f64::from(k + 1)) - ln(-3.0, 0.01 * f64::from(k));
                assert!(step.abs() < 0.5, "{} at {k} hundredths of the height: {step}; {REMEDY}", body.name);
            }
        }
        for id in [499, 606, 999] {
            let found = brightness(&catalog, NaifId(id)).altitude_on_earth_deg(-10.0);
            assert!((-8.0..5.0).contains(&found), "{id}: {found} degrees; {REMEDY}");
        }
        let shallow_air = brightness(&catalog, NaifId(599)).altitude_on_earth_deg(-6.0);
        assert!(shallow_air < -8.0, "{shallow_air} degrees; {REMEDY}");
    }
}
