//! Multiply scattered light in the shadow of an eclipse. It is not zero in the umbra, because it comes from the sunlit air and ground around the umbra.
//!
//! In: a body with its atmosphere, and the occluders' outlines from an eclipse's uniforms. Out: for each occluder the square roots of [`FACTORS_PER_OCCLUDER`]
//! factors. A factor is the fraction of a value of [`multi_scatter_table`] that remains in the occluder's shadow. Each of [`HEIGHTS`] heights has a row of
//! factors by the distance from the occluder's limb in solar radii; one more row is for the irradiance of level ground by the entire sky.
//!
//! Method: light of the second order comes from the sunlit air and ground on straight paths through the air. Paths in all directions are integrated, and their
//! light is binned by the distance of its source along the ground. The light from each distance is multiplied by the fraction of the Sun's disc that is visible
//! at this distance, averaged over azimuths. Each further order spreads the light once more, and the orders form a geometric series (S. Hillaire, EGSR
//! 2020), unlike those of [`multi_scatter_table`]. Always: factors are between 0 and 1, and 1 more than `MAX_SPREAD_KM` outside the penumbra. Not modelled:
//! - phase functions: all scattering is isotropic;
//! - the side of the shadow on which a place lies: the umbra is treated as a circle across the light (under a low Sun, an ellipse on the ground), and a factor
//!   depends only on the distance from its limb;
//! - the change of the Sun's altitude within the shadow;
//! - the curvature of the ground below a path's far end;
//! - the overlap of two occluders' shadows, where the shader multiplies the factors of both.
//!
//! Error: within 40 % of a photon simulation in air without aerosol, 2 km above the ground in the middle of umbras of 40 to 130 km radius
//! (tests/eclipse/twilight.rs).

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::air_sphere::{GROUND_CLEARANCE_KM, ground_albedo, row_height_km};
use crate::scene::atmosphere::extinction::{coefficient, column_above_km, extinction, scattering};
use crate::scene::atmosphere::multi_scatter_table;
use crate::scene::camera;
use crate::scene::draw::{EclipseUniforms, MAX_OCCLUDERS};
use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Number of heights: the lowest ones of [`multi_scatter_table`], which are 0, 2, 8 and 18 km in the Earth's 100 km of air. The values of
/// the last height apply to all greater ones.
pub use crate::scene::constants::IN_SHADOW_HEIGHTS as HEIGHTS;
/// Number of rows: one per height, then one for the irradiance of level ground.
pub(crate) const ROWS: usize = HEIGHTS + 1;
/// Number of columns: distances from the occluder's limb, densest in the middle of the shadow.
pub use crate::scene::constants::IN_SHADOW_COLUMNS as COLUMNS;
/// Number of factors of one occluder.
pub const FACTORS_PER_OCCLUDER: usize = ROWS * COLUMNS;
/// Index of the first of the vec4s with the range of each occluder's columns (see [`tables`]).
pub(crate) const COLUMN_RANGES_START: usize = FACTORS_PER_OCCLUDER * MAX_OCCLUDERS as usize;
/// Number of vec4s in the table: the factors and the column ranges of all occluders.
pub const VECTORS: usize = COLUMN_RANGES_START + MAX_OCCLUDERS as usize;

/// Number of altitude angles of the paths.
const ALTITUDES: usize = 32;
/// Integration steps along a path.
const STEPS: usize = 24;
/// Number of bins of distance along the ground. The first contains all distances up to [`FIRST_BIN_KM`], each further one ends at sqrt(2) times the end of the
/// one before, and the last contains all greater distances.
const BINS: usize = 18;
const FIRST_BIN_KM: f64 = 2.0;
/// Number of azimuths over which the light from a distance is averaged.
const AZIMUTHS: usize = 12;
/// Number of iterations that spread the light of the orders after the second.
const SPREAD_ITERATIONS: usize = 4;
/// Upper limit of the fraction of light that scatters again, so that the geometric series of orders converges.
const MAX_RESCATTERED: f64 = 0.98;
/// Distance from the penumbra, outwards and inwards, over which the factors vary: about seven mean free paths of red light at the Earth's
/// ground, of 87 km with aerosol.
pub(crate) const MAX_SPREAD_KM: f64 = 600.0;
/// Lower limit of the cosine of the Sun's zenith angle; under a lower Sun the shadow leaves the planet.
const MIN_SUN_COSINE: f64 = 0.05;
/// Number of samples of the visible fraction of the Sun across the occluder's limb.
const PENUMBRA_NODES: usize = 96;
/// Number of annuli into which the Sun's disc is divided.
const SUN_ANNULI: usize = 40;

/// The shadow of one occluder: the distances of the columns, and the visible fraction of the Sun. Its unit of length is the solar radius: a step of this length
/// across the light moves the occluder on the sky by the Sun's angular radius.
struct Shadow {
    /// Radius of the occluder in solar radii.
    occluder_radius: f64,
    /// Kilometres per solar radius, perpendicular to the light.
    km_per_solar_radius: f64,
    /// Cosine of the Sun's zenith angle.
    sun_cosine: f64,
    /// Distances of the first and the last column from the occluder's limb, solar radii; negative on the occluder.
    first_from_limb: f64,
    last_from_limb: f64,
    /// Visible fraction of the Sun's light per channel, at [`PENUMBRA_NODES`] distances from -1 to 1 solar radii from the occluder's limb.
    visible_sun_samples: Vec<DVec3>,
    /// See [`azimuths`].
    azimuths: [(DVec2, DVec2); AZIMUTHS],
}

impl Shadow {
    /// The shadow of the occluder `index`; `None` if there is none, or if it is not between the body and the Sun.
    fn of(body: &Body, eclipse: &EclipseUniforms, index: usize) -> Option<Self> {
        // In the body's equatorial radii. `position`: the occluder's centre across the axis (xy) and along it (z); `outline`: the semi-axes (zw).
        let (position, outline) = (eclipse.occluder_positions.get(index)?.as_dvec4(), eclipse.occluder_outlines.get(index)?.as_dvec4());
        let offset_across = position.truncate().truncate();
        // The coordinate along the axis of the point where the shadow's centre line meets the ground, or 0 if the line misses. On the unit sphere it is also
        // the cosine of the Sun's zenith angle.
        let axis_z = (1.0 - offset_across.length_squared()).max(0.0).sqrt();
        let to_occluder = position.z - axis_z;
        // Solar radii per equatorial radius of the lit body, at the occluder's distance: the cotangent of the Sun's angular radius as the lit point sees it,
        // over the distance. `perpendicular_axes[0].w`: this cotangent at the body's centre; `axis.w`: 1 / the Sun's distance from there.
        let solar_radii_per_radius = f64::from(eclipse.perpendicular_axes[0].w) * (1.0 - axis_z * f64::from(eclipse.axis.w)) / to_occluder;
        if !(to_occluder > 0.0 && solar_radii_per_radius > 0.0 && solar_radii_per_radius.is_finite()) {
            return None;
        }
        let occluder_radius = (outline.z * outline.w).sqrt() * solar_radii_per_radius;
        let km_per_solar_radius = body.radii_km.x / solar_radii_per_radius;
        let margin = MAX_SPREAD_KM / km_per_solar_radius;
        let limb_darkening = eclipse.limb_darkening.map(|l| l.truncate().as_dvec3());
        let visible_sun_samples = (0..PENUMBRA_NODES)
            .map(|k| visible_sun_fraction(occluder_radius, -1.0 + 2.0 * k as f64 / (PENUMBRA_NODES - 1) as f64, &limb_darkening))
            .collect();
        let sun_cosine = axis_z.max(MIN_SUN_COSINE);
        Some(Self {
            occluder_radius,
            km_per_solar_radius,
            sun_cosine,
            first_from_limb: (-1.0 - margin).max(-occluder_radius),
            last_from_limb: 1.0 + margin,
            visible_sun_samples,
            azimuths: azimuths(sun_cosine),
        })
    }

    /// Visible fraction of the Sun's light, per channel, at a distance from the occluder's centre in solar radii.
    fn visible_sun(&self, distance: f64) -> DVec3 {
        let from_limb = distance - self.occluder_radius;
        if from_limb >= 1.0 {
            return DVec3::ONE;
        }
        let node_position = (0.5 * (from_limb + 1.0)).max(0.0) * (PENUMBRA_NODES - 1) as f64;
        let k = (node_position as usize).min(PENUMBRA_NODES - 2);
        self.visible_sun_samples[k].lerp(self.visible_sun_samples[k + 1], node_position - k as f64)
    }

    /// Distance of a column from the occluder's centre, solar radii.
    fn column_distance(&self, column: usize) -> f64 {
        let fraction = (column as f64 / (COLUMNS - 1) as f64).powi(2);
        self.occluder_radius + self.first_from_limb + (self.last_from_limb - self.first_from_limb) * fraction
    }

    /// The position between columns at which a distance lies; from the occluder's centre, in solar radii. The inverse of [`Self::column_distance`].
    fn column_position(&self, distance: f64) -> ColumnPosition {
        let column = ((distance - self.occluder_radius - self.first_from_limb) / (self.last_from_limb - self.first_from_limb))
            .clamp(0.0, 1.0)
            .sqrt()
            * (COLUMNS - 1) as f64;
        let below = (column as usize).min(COLUMNS - 2);
        ColumnPosition { below, fraction: column - below as f64 }
    }

    /// For each azimuth, the distance from the occluder's centre to a source that lies `path_km` from a place, measured along the ground. `distance`: from the
    /// occluder's centre to the place. Both distances in solar radii.
    fn distances_around(&self, distance: f64, path_km: f64) -> [f64; AZIMUTHS] {
        let path = path_km / self.km_per_solar_radius;
        self.azimuths.map(|(to_place, to_source)| (to_place * distance + to_source * path).length())
    }
}

/// A position between two neighbouring columns.
#[derive(Clone, Copy)]
struct ColumnPosition {
    below: usize,
    /// 0 at the column `below`, 1 at the next.
    fraction: f64,
}

impl ColumnPosition {
    /// Interpolates a row of square roots, and squares the result.
    fn interpolate_squared(self, row: &[DVec3; COLUMNS]) -> DVec3 {
        let root = row[self.below].lerp(row[self.below + 1], self.fraction);
        root * root
    }
}

/// For each azimuth: the unit vector from the shadow's axis to a place, and the unit vector along the ground from the place to a source; both projected on the
/// plane perpendicular to the light, which shortens the second.
fn azimuths(sun_cosine: f64) -> [(DVec2, DVec2); AZIMUTHS] {
    std::array::from_fn(|k| {
        // The place may be on any side of the axis; half a turn suffices by symmetry. Its angle advances by the golden ratio, so that the pairs of angles are
        // distributed evenly.
        let (sin, cos) = (TAU * (k as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
        (DVec2::from_angle(PI * (k as f64 * 0.618_033_988_749).fract()), DVec2::new(sun_cosine * cos, sin))
    })
}

/// Visible fraction of the Sun's light, per channel, behind a circle of radius `occluder_radius`. `from_limb`: distance of the circle's limb from the Sun's
/// centre, negative if the circle covers the centre. Lengths in solar radii.
fn visible_sun_fraction(occluder_radius: f64, from_limb: f64, limb_darkening: &[DVec3; 3]) -> DVec3 {
    let separation = (occluder_radius + from_limb).max(0.0);
    let (mut visible, mut total) = (DVec3::ZERO, DVec3::ZERO);
    for k in 0..SUN_ANNULI {
        let r = (k as f64 + 0.5) / SUN_ANNULI as f64;
        let mu = (1.0 - r * r).sqrt();
        // `limb_darkening`: coefficients of 1, mu and mu².
        let intensity = limb_darkening[0] + limb_darkening[1] * mu + limb_darkening[2] * (mu * mu);
        // Cosine of half the angle that the occluder covers of the annulus, as seen from the Sun's centre.
        let cosine = (r * r + separation * separation - occluder_radius * occluder_radius) / (2.0 * r * separation).max(1e-12);
        let visible_part = 1.0 - cosine.clamp(-1.0, 1.0).acos() / PI;
        visible += intensity * (TAU * r * visible_part / SUN_ANNULI as f64);
        total += intensity * (TAU * r / SUN_ANNULI as f64);
    }
    (visible / total.max(DVec3::splat(1e-12))).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Light binned by the distance of its source along the ground.
#[derive(Clone)]
struct Sources {
    light: [DVec3; BINS],
    /// Sums of the sources' distances, weighted by the green channel of `light`.
    path_sums_km: [f64; BINS],
}

impl Sources {
    const NONE: Self = Self { light: [DVec3::ZERO; BINS], path_sums_km: [0.0; BINS] };

    /// Adds light from a source `path_km` along the ground away.
    fn add(&mut self, path_km: f64, light: DVec3) {
        let bin = (2.0 * (path_km / FIRST_BIN_KM).max(1.0).log2()).ceil().min((BINS - 1) as f64) as usize;
        self.light[bin] += light;
        self.path_sums_km[bin] += path_km * light.y;
    }

    fn total(&self) -> DVec3 {
        self.light.iter().copied().sum()
    }

    /// The bins that hold light: their light, and the distance of its sources in km.
    fn lit_bins(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let bins = self.light.iter().zip(&self.path_sums_km).filter(|(light, _)| light.max_element() > 0.0);
        bins.map(|(light, path_sum_km)| (*light, path_sum_km / light.y.max(1e-300)))
    }

    /// The light that arrives at a place if each source is multiplied by `factor` of its distance from the occluder's centre. `distance`: that of the place
    /// from this centre. Distances in solar radii.
    fn arriving(&self, shadow: &Shadow, distance: f64, factor: impl Fn(f64) -> DVec3) -> DVec3 {
        let mean = |path_km| shadow.distances_around(distance, path_km).map(&factor).iter().sum::<DVec3>() / AZIMUTHS as f64;
        self.lit_bins().map(|(light, path_km)| light * mean(path_km)).sum()
    }

    /// For each column: the sources of the light that arrives at the column's distance.
    fn at_columns(&self, shadow: &Shadow) -> Vec<ColumnSources> {
        let positions = |distance, path_km| shadow.distances_around(distance, path_km).map(|d| shadow.column_position(d));
        let at = |distance| ColumnSources { bins: self.lit_bins().map(|(light, path_km)| (light, positions(distance, path_km))).collect() };
        (0..COLUMNS).map(|c| at(shadow.column_distance(c))).collect()
    }
}

/// The sources of the light that arrives at one column, by their positions between the columns. The positions are the same for every order of scattering, so
/// they are computed once.
struct ColumnSources {
    /// The light of each bin, and for each azimuth the position of its source.
    bins: Vec<(DVec3, [ColumnPosition; AZIMUTHS])>,
}

impl ColumnSources {
    /// The light that arrives if each source is multiplied by the factor at its position. `row`: the factors' square roots.
    fn arriving(&self, row: &[DVec3; COLUMNS]) -> DVec3 {
        let mean = |around: &[ColumnPosition; AZIMUTHS]| around.iter().map(|p| p.interpolate_squared(row)).sum::<DVec3>() / AZIMUTHS as f64;
        self.bins.iter().map(|(light, around)| *light * mean(around)).sum()
    }
}

/// A body's air and ground, the sources of the light.
struct AirAndGround<'a> {
    radius_km: f64,
    air: &'a Atmosphere,
    /// Linear RGB.
    ground_albedo: DVec3,
}

impl AirAndGround<'_> {
    /// A coefficient summed over all species, per km. `of_species`: [`scattering`] or [`extinction`].
    fn coefficient(&self, height_km: f64, of_species: fn(&crate::catalog::Species) -> DVec3) -> DVec3 {
        coefficient(self.air, height_km, of_species)
    }

    /// Transmittance from a height towards the Sun, as in a plane-parallel atmosphere.
    fn sunlight(&self, height_km: f64, sun_cosine: f64) -> DVec3 {
        let depth: DVec3 = self.air.species.iter().map(|s| extinction(s) * column_above_km(s, height_km)).sum();
        depth.map(|d| (-d / sun_cosine).exp())
    }

    /// Integrates along a path that starts at the height `start_height_km`. Calls `add_scattering` for each step with: the distance along the ground in km, the
    /// height in km, and the fraction of the light at the step that is scattered into the path and reaches the path's start. Returns the distance along the
    /// ground at which the path meets the ground, and the transmittance from the ground to the start; `None` for a path that leaves the air at its top.
    fn integrate_path(
        &self,
        start_height_km: f64,
        altitude_sine: f64,
        mut add_scattering: impl FnMut(f64, f64, DVec3),
    ) -> Option<(f64, DVec3)> {
        let start_radius_km = self.radius_km + start_height_km.max(GROUND_CLEARANCE_KM);
        // Positions on the path are counted from the point of its line that is nearest to the centre. The line enters a sphere half a chord before this point,
        // and leaves it half a chord after it.
        let start_km = start_radius_km * altitude_sine;
        let nearest_sq = start_radius_km * start_radius_km * (1.0 - altitude_sine * altitude_sine);
        let half_ground_chord_sq = self.radius_km * self.radius_km - nearest_sq;
        let hits_ground = altitude_sine < 0.0 && half_ground_chord_sq > 0.0;
        let half_top_chord_sq = (self.radius_km + self.air.top_km).powi(2) - nearest_sq;
        let path_km =
            if hits_ground { -start_km - half_ground_chord_sq.sqrt() } else { -start_km + half_top_chord_sq.max(0.0).sqrt() }.max(0.0);
        let altitude_cosine = (1.0 - altitude_sine * altitude_sine).sqrt();
        let ground_distance_km = |s_km: f64| self.radius_km * (s_km * altitude_cosine).atan2(start_radius_km + s_km * altitude_sine);
        let mut transmittance = DVec3::ONE;
        for k in 0..STEPS {
            let u = (k as f64 + 0.5) / STEPS as f64;
            // Midpoints in u, of which the distance from the start is the square: steps are shortest at the start.
            let (s_km, step_km) = (path_km * u * u, path_km * 2.0 * u / STEPS as f64);
            let height_km = ((nearest_sq + (start_km + s_km).powi(2)).sqrt() - self.radius_km).max(0.0);
            let depth = self.coefficient(height_km, extinction) * step_km;
            // Mean transmittance from the start of the step to its points.
            let mean_transmittance = depth.map(|d| if d > 1e-6 { -(-d).exp_m1() / d } else { 1.0 });
            let scattered = transmittance * self.coefficient(height_km, scattering) * mean_transmittance * step_km;
            add_scattering(ground_distance_km(s_km), height_km, scattered);
            transmittance *= depth.map(|d| (-d).exp());
        }
        hits_ground.then(|| (ground_distance_km(path_km), transmittance))
    }

    /// The sources of the light that arrives at the height of a row. First those of the light that scatters there as second order: mean radiance over all
    /// directions, per irradiance of the Sun. Then those of a further order: the same mean if all air had the radiance 1 per scattering optical depth; their
    /// total is the ratio of the geometric series. The ground is only among the first.
    fn sources(&self, row: usize, sun_cosine: f64) -> (Sources, Sources) {
        let (mut second, mut rescattered) = (Sources::NONE, Sources::NONE);
        for (altitude_sine, weight) in altitude_sines() {
            let ground = self.integrate_path(row_height_km(self.air, row as f64), altitude_sine, |path_km, height_km, scattered| {
                // Isotropic scattering: 1 / (4 pi) per steradian.
                second.add(path_km, scattered * self.sunlight(height_km, sun_cosine) * (weight / (4.0 * PI)));
                rescattered.add(path_km, scattered * weight);
            });
            if let Some((path_km, transmittance)) = ground {
                let ground_height_km = 0.0;
                let sunlight = self.sunlight(ground_height_km, sun_cosine);
                // A Lambert surface: 1 / pi per steradian.
                second.add(path_km, transmittance * self.ground_albedo * sunlight * (weight * sun_cosine / PI));
            }
        }
        (second, rescattered)
    }
}

/// Sines of altitude from nadir to zenith, densest at the horizon, with weights that sum to 1.
fn altitude_sines() -> impl Iterator<Item = (f64, f64)> {
    let half = ALTITUDES / 2;
    (0..half).flat_map(move |k| {
        let u = (k as f64 + 0.5) / half as f64;
        let weight = u / half as f64;
        [(u * u, weight), (-u * u, weight)]
    })
}

/// The tables of all occluders that a draw may have: [`FACTORS_PER_OCCLUDER`] square roots each, then for each occluder the distance of its first column from
/// the limb (x) and one over the range of its columns (y). Without an atmosphere, and for absent occluders, all values are 1.
pub fn tables(body: &Body, eclipse: &EclipseUniforms) -> Vec<Vec4> {
    let mut all = vec![Vec4::ONE; VECTORS];
    for index in 0..eclipse.occluder_positions.len().min(usize::from(MAX_OCCLUDERS)) {
        let shadow = body.atmosphere.as_ref().and_then(|air| Some((air, Shadow::of(body, eclipse, index)?)));
        let Some((air, shadow)) = shadow else { continue };
        let air_and_ground = AirAndGround { radius_km: body.radii_km.x, air, ground_albedo: ground_albedo(body) };
        for (vector, root) in all[index * FACTORS_PER_OCCLUDER..].iter_mut().zip(factor_roots(&air_and_ground, &shadow)) {
            *vector = camera::narrow(root).extend(0.0);
        }
        let column_range = DVec3::new(shadow.first_from_limb, 1.0 / (shadow.last_from_limb - shadow.first_from_limb), 0.0);
        all[COLUMN_RANGES_START + index] = camera::narrow(column_range).extend(0.0);
    }
    all
}

/// The [`FACTORS_PER_OCCLUDER`] square roots of one occluder.
fn factor_roots(air_and_ground: &AirAndGround<'_>, shadow: &Shadow) -> Vec<DVec3> {
    let sources: Vec<(Sources, Sources)> = (0..HEIGHTS).into_par_iter().map(|row| air_and_ground.sources(row, shadow.sun_cosine)).collect();
    let rows: Vec<[DVec3; COLUMNS]> = sources.par_iter().map(|(second, rescattered)| height_row(shadow, second, rescattered)).collect();
    let ground = ground_row(air_and_ground, shadow, &sources, &rows);
    let mut all: Vec<DVec3> = rows.into_iter().flatten().chain(ground.into_iter().map(square_root)).collect();
    // The last column is beyond the shadow's blurred edge, where all light remains.
    for last in (0..ROWS).map(|r| (r + 1) * COLUMNS - 1) {
        all[last] = DVec3::ONE;
    }
    all
}

/// Square roots of fractions. These are clamped first, because rounding may have moved them beyond 0 or 1.
fn square_root(v: DVec3) -> DVec3 {
    v.map(|x| x.clamp(0.0, 1.0).sqrt())
}

/// The square roots of the factors at one height. They start with the factors of the second order. With the ratio r of the geometric series, each iteration
/// replaces a factor by (1 - r) * second order + r * mean of the factors around, and so includes one more order.
fn height_row(shadow: &Shadow, second: &Sources, rescattered: &Sources) -> [DVec3; COLUMNS] {
    let rescattered_fraction = rescattered.total().map(|a| a.min(MAX_RESCATTERED));
    let second_total = second.total().max(DVec3::splat(1e-300));
    let second_order: [DVec3; COLUMNS] =
        std::array::from_fn(|c| second.arriving(shadow, shadow.column_distance(c), |d| shadow.visible_sun(d)) / second_total);
    let rescattered_at = rescattered.at_columns(shadow);
    let rescattered_total = rescattered.total().max(DVec3::splat(1e-300));
    let mut row = second_order.map(square_root);
    for _ in 0..SPREAD_ITERATIONS {
        let next = |c: usize| {
            let arriving = rescattered_at[c].arriving(&row) / rescattered_total;
            square_root(second_order[c] * (DVec3::ONE - rescattered_fraction) + arriving * rescattered_fraction)
        };
        row = std::array::from_fn(next);
    }
    row
}

/// For each column: the fraction that remains of the irradiance of level ground by the entire sky. `rows`: the square roots at each height. `sources`: those of
/// [`AirAndGround::sources`] at each height.
fn ground_row(air_and_ground: &AirAndGround<'_>, shadow: &Shadow, sources: &[(Sources, Sources)], rows: &[[DVec3; COLUMNS]]) -> Vec<DVec3> {
    // At each height: the radiance, per unit of scattering, of the second and all further orders, as a geometric series.
    let multiple_scattering: Vec<DVec3> = sources
        .iter()
        .map(|(second, rescattered)| second.total() / (DVec3::ONE - rescattered.total().map(|a| a.min(MAX_RESCATTERED))))
        .collect();
    // The sources of the skylight: those of sunlight scattered once, and for each row those of light scattered more often near the row's height.
    let mut single = Sources::NONE;
    let mut further = vec![Sources::NONE; HEIGHTS];
    for (altitude_sine, weight) in altitude_sines().filter(|(altitude_sine, _)| *altitude_sine > 0.0) {
        // Light from this direction contributes to the irradiance in proportion to the sine of its altitude.
        let weight = weight * altitude_sine;
        let add_scattering = |path_km: f64, height_km: f64, scattered: DVec3| {
            single.add(path_km, scattered * air_and_ground.sunlight(height_km, shadow.sun_cosine) * (weight / (4.0 * PI)));
            // The inverse of `row_height_km`, limited to this table's rows.
            let row_position =
                ((height_km / air_and_ground.air.top_km).sqrt() * (multi_scatter_table::HEIGHTS - 1) as f64).min((HEIGHTS - 1) as f64);
            let below = (row_position as usize).min(HEIGHTS - 2);
            let fraction = row_position - below as f64;
            further[below].add(path_km, scattered * multiple_scattering[below] * (weight * (1.0 - fraction)));
            further[below + 1].add(path_km, scattered * multiple_scattering[below + 1] * (weight * fraction));
        };
        let start_height_km = 0.0;
        air_and_ground.integrate_path(start_height_km, altitude_sine, add_scattering);
    }
    let total = single.total() + further.iter().map(Sources::total).sum::<DVec3>();
    let remaining = |c: usize| {
        let distance = shadow.column_distance(c);
        let further_at = |r: usize| further[r].arriving(shadow, distance, |d| shadow.column_position(d).interpolate_squared(&rows[r]));
        let light = single.arriving(shadow, distance, |d| shadow.visible_sun(d)) + (0..HEIGHTS).map(further_at).sum::<DVec3>();
        light / total.max(DVec3::splat(1e-300))
    };
    (0..COLUMNS).into_par_iter().map(remaining).collect()
}
