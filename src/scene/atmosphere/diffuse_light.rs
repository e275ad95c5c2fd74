//! Diffuse light of all orders of scattering in a spherical atmosphere, averaged over azimuths: a radiance for each level (height) and stream (zenith angle).
//!
//! In: an [`AirSphere`]; the direction of the Sun. Out: [`Field`]. Method: successive orders of scattering (H. C. van de Hulst, Multiple Light Scattering,
//! 1980, ch. 4.3; discrete streams as of Chandrasekhar, Radiative Transfer, 1960). Light scattered once, and sunlight reflected by the ground, are integrated
//! with the Sun's true zenith angle at each point of a ray. Each further order is the previous one, scattered by each species with its phase function or
//! reflected by the ground, and collected along rays through the spherical air. For these orders it is assumed that the Sun has the same zenith angle
//! everywhere. The levels resolve air up to an optical depth of some 10 (the catalog's thickest has 6).

use crate::scene::atmosphere::air_sphere::{AirSphere, GROUND_CLEARANCE_KM, direction, row_height_km, scattering_in_draws};
use crate::scene::atmosphere::extinction::density;
use crate::scene::atmosphere::phase;
use crate::scene::constants::MULTI_SCATTER_HEIGHTS as TABLE_HEIGHTS;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of levels from one row (height) of the table of multiple scattering to the next.
const LEVELS_PER_ROW: usize = 3;
/// Number of levels: the first is on the ground, the last at the top of the air.
const LEVELS: usize = LEVELS_PER_ROW * (TABLE_HEIGHTS - 1) + 1;
/// The three positive abscissas of the six-point Gauss-Legendre rule on -1 to 1, and their weights (Abramowitz & Stegun 1964, table 25.4).
const GAUSS_ABSCISSAS: [f64; 3] = [0.238_619_186_083_196_9, 0.661_209_386_466_264_5, 0.932_469_514_203_152_1];
const GAUSS_WEIGHTS: [f64; 3] = [0.467_913_934_572_691_0, 0.360_761_573_048_138_6, 0.171_324_492_379_170_4];
/// Number of streams: six zenith angles in the sky and six below the horizon, each six by their own Gauss-Legendre rule.
const STREAMS: usize = 12;
/// Number of nodes: pairs of a level and a stream.
const NODES: usize = LEVELS * STREAMS;
/// Steps along the rays that collect the orders after the first.
const STEPS: usize = 32;
/// Azimuths over which a phase function is averaged.
const PHASE_AZIMUTHS: u32 = 64;
/// Orders are added until the largest radiance of the last one is at most this fraction of the largest radiance of the sum.
const LAST_ORDER_FRACTION: f64 = 1e-4;
/// Upper limit of the number of orders. Air of optical depth 1000 that absorbs nothing needs fewer.
const MAX_ORDERS: usize = 500;

/// Number of azimuths, and of steps along each ray, with which light scattered once is integrated.
#[derive(Clone, Copy)]
pub(super) struct SampleCounts {
    pub(super) azimuths: u32,
    pub(super) steps: usize,
}

/// All directions near one zenith angle.
#[derive(Clone, Copy, Default)]
struct Stream {
    /// Cosine of the zenith angle of the direction from which the light comes: positive in the sky, negative below the horizon.
    cosine: f64,
    /// Fraction of all directions that the stream represents.
    weight: f64,
}

/// The streams in ascending order of their cosines.
fn streams() -> [Stream; STREAMS] {
    let half = STREAMS / 2;
    let mut streams = [Stream::default(); STREAMS];
    for k in 0..half {
        // The abscissas of the rule in ascending order: the negative ones from the outermost inwards, then the positive ones.
        let from_middle = if k < half / 2 { half / 2 - 1 - k } else { k - half / 2 };
        let abscissa = if k < half / 2 { -GAUSS_ABSCISSAS[from_middle] } else { GAUSS_ABSCISSAS[from_middle] };
        // From the range -1 to 1 to that of the cosines in the sky, 0 to 1. The rule's weights have the sum 2, those of all streams the sum 1.
        let stream = Stream { cosine: 0.5 * (1.0 + abscissa), weight: 0.25 * GAUSS_WEIGHTS[from_middle] };
        streams[half + k] = stream;
        streams[half - 1 - k] = Stream { cosine: -stream.cosine, weight: stream.weight };
    }
    streams
}

/// The two grid indices around a position, with their weights for linear interpolation. `count`: number of grid points.
fn interpolation_weights(position: f64, count: usize) -> [(usize, f64); 2] {
    let position = position.clamp(0.0, (count - 1) as f64);
    let below = (position as usize).min(count - 2);
    let fraction = position - below as f64;
    [(below, 1.0 - fraction), (below + 1, fraction)]
}

/// How each order of scattering in one body's air follows from the previous one; the same for every position of the Sun.
pub(super) struct DiffuseLight<'a> {
    sphere: &'a AirSphere<'a>,
    streams: [Stream; STREAMS],
    /// Matrix of `NODES` x `NODES`. Element `node * NODES + source`: the fraction of the radiance at the node `source` that arrives at `node` after one more
    /// scattering or reflection.
    next_order: Vec<DVec3>,
}

/// Diffuse light for one position of the Sun: radiances divided by the irradiance of the Sun, per steradian (not times pi, unlike the shaders' radiance).
pub(super) struct Field {
    /// Radiance of light scattered once; index: level * `STREAMS` + stream.
    once: Vec<DVec3>,
    /// Radiance of light of all orders, including light reflected by the ground; same index.
    all: Vec<DVec3>,
}

impl<'a> DiffuseLight<'a> {
    /// Computes how orders follow from each other.
    pub(super) fn of(sphere: &'a AirSphere<'a>) -> Self {
        let streams = streams();
        let phase_means: Vec<Vec<DVec3>> = sphere.air.species.iter().map(|s| phase_means(s.phase, &streams)).collect();
        let mut diffuse = Self { sphere, streams, next_order: Vec::new() };
        diffuse.next_order = (0..NODES).into_par_iter().flat_map_iter(|node| diffuse.sources_of(node, &phase_means)).collect();
        diffuse
    }

    /// Where the rays of a level start: a point at the level's height, on the z axis.
    fn start(&self, level: usize) -> DVec3 {
        let height_km = row_height_km(self.sphere.air, level as f64 / LEVELS_PER_ROW as f64);
        DVec3::Z * (self.sphere.radius_km + height_km.max(GROUND_CLEARANCE_KM))
    }

    /// The row of `next_order` of a node: along its ray, where the light comes from and how much of it is scattered into the ray.
    fn sources_of(&self, node: usize, phase_means: &[Vec<DVec3>]) -> Vec<DVec3> {
        let (sphere, species) = (self.sphere, &self.sphere.air.species);
        // The streams are averages over azimuths, so any azimuth will do.
        let azimuth_rad = 0.0;
        let along = direction(self.streams[node % STREAMS].cosine, azimuth_rad);
        // The scattering optical depth along the ray, times the transmittance to the ray's start: by species, and by the level and the ray's zenith angle
        // there.
        let mut scattered = vec![DVec3::ZERO; species.len() * NODES];
        // `transmitted_km`: length of the step times its mean transmittance to the start of the ray.
        // `ground`: where the ray meets the ground, if it does.
        let ground = sphere.follow(self.start(node / STREAMS), along, STEPS, |p, transmitted_km| {
            let height_km = sphere.height_km(p);
            // The inverse of `start`: heights grow with the square of the level.
            let level_position = (height_km / sphere.air.top_km).sqrt() * (LEVELS - 1) as f64;
            let stream_position = self.stream_position(along.dot(p.normalize()));
            for (k, s) in species.iter().enumerate() {
                // Without the light that draws treat as absorbed.
                let light = transmitted_km * scattering_in_draws(s) * density(s, height_km);
                for (level, level_weight) in interpolation_weights(level_position, LEVELS) {
                    for (stream, stream_weight) in interpolation_weights(stream_position, STREAMS) {
                        scattered[(k * LEVELS + level) * STREAMS + stream] += light * (level_weight * stream_weight);
                    }
                }
            }
        });
        let mut row = vec![DVec3::ZERO; NODES];
        for (k, means) in phase_means.iter().enumerate() {
            for level in 0..LEVELS {
                for to in 0..STREAMS {
                    let light = scattered[(k * LEVELS + level) * STREAMS + to];
                    for from in 0..STREAMS {
                        row[level * STREAMS + from] += light * means[to * STREAMS + from];
                    }
                }
            }
        }
        if let Some(ground) = ground {
            // The radiance of a Lambert surface is its albedo times the irradiance over pi. A stream's solid angle is 4 pi times its weight.
            // The light is that of the lowest level, whose index is 0.
            for (from, stream) in self.streams.iter().enumerate().filter(|(_, stream)| stream.cosine > 0.0) {
                row[from] += ground.transmittance * sphere.ground_albedo * (4.0 * stream.weight * stream.cosine);
            }
        }
        row
    }

    /// The position of a zenith cosine between the streams, as a fractional index.
    fn stream_position(&self, cosine: f64) -> f64 {
        let index_above = self.streams.iter().position(|s| s.cosine > cosine).unwrap_or(STREAMS - 1).max(1);
        let (lower, upper) = (self.streams[index_above - 1].cosine, self.streams[index_above].cosine);
        (index_above - 1) as f64 + ((cosine - lower) / (upper - lower)).clamp(0.0, 1.0)
    }

    /// The field along the z axis, which points to the zenith. `sun`: unit vector to the Sun, in the x-z plane.
    pub(super) fn field(&self, sun: DVec3, counts: SampleCounts) -> Field {
        let (mut once, mut all) = (Vec::with_capacity(NODES), Vec::with_capacity(NODES));
        // The field is symmetric about the Sun's vertical: the azimuths on one side are enough, each with twice its solid angle.
        let azimuths_rad = (0..counts.azimuths).map(|k| PI * (f64::from(k) + 0.5) / f64::from(counts.azimuths));
        let rays_of = |stream: &Stream| {
            let (cosine, solid_angle) = (stream.cosine, 4.0 * PI * stream.weight / f64::from(counts.azimuths));
            azimuths_rad.clone().map(move |azimuth_rad| (direction(cosine, azimuth_rad), solid_angle))
        };
        // Factors that normalise the phase functions over these directions.
        let norms = self.sphere.phase_norms(sun, self.streams.iter().flat_map(rays_of));
        for node in 0..NODES {
            let (mut scattered, mut reflected) = (DVec3::ZERO, DVec3::ZERO);
            for (along, _solid_angle) in rays_of(&self.streams[node % STREAMS]) {
                let (light, ground) = self.sphere.single_scattering(self.start(node / STREAMS), along, counts.steps, sun, &norms);
                scattered += light;
                reflected += ground.map_or(DVec3::ZERO, |g| g.transmittance * self.sphere.reflected(g.point_km, sun));
            }
            once.push(scattered / f64::from(counts.azimuths));
            all.push((scattered + reflected) / f64::from(counts.azimuths));
        }
        // The radiance of the latest order; the first order also has the sunlight that the ground reflects.
        let mut order = all.clone();
        for _ in 0..MAX_ORDERS {
            let next = |row: &[DVec3]| row.iter().zip(&order).map(|(fraction, light)| *fraction * *light).sum::<DVec3>();
            order = self.next_order.chunks_exact(NODES).map(next).collect();
            let (mut max_of_order, mut max_of_sum) = (DVec3::ZERO, DVec3::ZERO);
            for (sum, light) in all.iter_mut().zip(&order) {
                *sum += *light;
                (max_of_order, max_of_sum) = (max_of_order.max(*light), max_of_sum.max(*sum));
            }
            if max_of_order.cmple(max_of_sum * LAST_ORDER_FRACTION).all() {
                break;
            }
        }
        Field { once, all }
    }

    /// Mean radiance over all directions at the height of a row of the table, in the unit of [`Field`]. Row 0: on the ground.
    pub(super) fn mean_radiance(&self, field: &Field, row: usize) -> DVec3 {
        let level = &field.all[row * LEVELS_PER_ROW * STREAMS..][..STREAMS];
        level.iter().zip(&self.streams).map(|(light, stream)| *light * stream.weight).sum()
    }

    /// Irradiance of level ground by skylight of the second and all further orders, divided by the irradiance of the Sun.
    pub(super) fn irradiance_by_further_orders(&self, field: &Field) -> DVec3 {
        let light = field.all[..STREAMS].iter().zip(&field.once);
        let in_sky = light.zip(&self.streams).filter(|(_, stream)| stream.cosine > 0.0);
        in_sky.map(|((all, once), stream)| (*all - *once) * (4.0 * PI * stream.weight * stream.cosine)).sum()
    }
}

/// For each pair of streams and each channel: the radiance that a scattering optical depth of 1 sends into the stream `to`, divided by the radiance of the
/// stream `from`. The index is `to` * STREAMS + `from`. For an isotropic phase function the value is the weight of `from`. The values are scaled so that all
/// light of a stream is scattered into some stream; otherwise the narrow peak of a forward-scattering aerosol would be lost between the streams' angles.
fn phase_means(phase: crate::catalog::PhaseFunction, streams: &[Stream; STREAMS]) -> Vec<DVec3> {
    let mean = |to: &Stream, from: &Stream| {
        let to_azimuth_rad = 0.0;
        let at = |k: u32| {
            let from_azimuth_rad = PI * (f64::from(k) + 0.5) / f64::from(PHASE_AZIMUTHS);
            phase::per_steradian(phase, direction(to.cosine, to_azimuth_rad).dot(direction(from.cosine, from_azimuth_rad)))
        };
        4.0 * PI * (0..PHASE_AZIMUTHS).map(at).sum::<DVec3>() / f64::from(PHASE_AZIMUTHS)
    };
    let mut means = vec![DVec3::ZERO; STREAMS * STREAMS];
    for (from, from_stream) in streams.iter().enumerate() {
        let into: Vec<DVec3> = streams.iter().map(|to| mean(to, from_stream)).collect();
        let total: DVec3 = into.iter().zip(streams).map(|(mean, to)| *mean * to.weight).sum();
        for (to, mean) in into.iter().enumerate() {
            means[to * STREAMS + from] = *mean * from_stream.weight / total;
        }
    }
    means
}
