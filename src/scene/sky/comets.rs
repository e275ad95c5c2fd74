//! Comets: the head as a point of light, a tail of dust and a tail of ions.
//!
//! In: the catalog's comets, the camera, the radiance displayed as white. Out: [`Comets`]: sprites for shaders/entry/point.wesl, ribbon segments for
//! shaders/entry/comet_tail.wesl, and arcs of orbits. The head has the total magnitude M1 + 5 log d + K1 log r, with the distances d from the viewer
//! and r from the Sun in au, and M1 and K1 from the catalog. Ions move with the solar wind and lag by the comet's own velocity. Dust grains move on
//! orbits of their own from the point of release; radiation pressure reduces the Sun's gravity on them by the fraction beta. The directions of tails
//! follow from this alone; their lengths and their shares of the light are chosen to resemble drawings by observers, not measured. Values are
//! computed in f64 and narrowed in the result. Left out: jets, outbursts, disconnections, anti-tails of large grains, variations of the solar wind.

use super::minor_planets::{MARKER_LEVEL, NEAR_AU};
use super::star_colour::star_colour;
use crate::catalog::small_bodies::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, SmallBody};
use crate::ephemeris::State;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::conic::{ConicState, heliocentric_state};
use crate::message::{Reason, reason};
use crate::scene::annotation::orbit_arcs::{self, Conic, OrbitArc};
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{Camera, narrow, narrow_scalar, narrow2};
use crate::scene::decision::Decision;
use crate::scene::draw::{PixelView, StarSprite};
use crate::scene::light::photometry::irradiance_of_magnitude;
use crate::scene::numeric::smoothstep;
use crate::scene::point::{pixel_sr, point_peak, point_radius_px};
use crate::scene::request::view_request::ViewRequest;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S, luminance};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// Speed of the solar wind, km/s: the slow wind near the ecliptic (McComas et al. 2000, J. Geophys. Res. 105, 10419).
pub const SOLAR_WIND_KM_S: f64 = 400.0;
/// Range of beta, the ratio of radiation pressure to gravity, of the simulated grains. It corresponds to sizes from 20 micrometres down to half a micrometre
/// (Burns, Lamy and Soter 1979, Icarus 40, 1).
const MIN_BETA: f64 = 0.03;
const MAX_BETA: f64 = 1.0;
/// Number of values of beta for which grains are computed; the grains of one beta form a line, a syndyne.
const SYNDYNE_COUNT: usize = 14;
/// Speed at which grains leave the coma in all directions, which widens the dust tail, au per day: 0.2 km/s.
const GRAIN_SPEED_AU_PER_DAY: f64 = 0.2 * SECONDS_PER_DAY / KM_PER_AU;
/// Largest age of grains since their release, days.
const MAX_AGE_DAYS: f64 = 60.0;
/// Number of stations, the points along the centre line of a ribbon.
const STATION_COUNT: usize = 24;
/// Irradiance of each tail divided by the irradiance of the head, for tails that are complete (see [`TAILS_AU`]).
const DUST_FRACTION: f64 = 0.4;
const ION_FRACTION: f64 = 0.12;
/// Heliocentric distances, au, at which an approaching comet's tails start to grow, and at which they are complete.
const TAILS_AU: (f64, f64) = (3.0, 1.5);
/// Fraction of the radiance of white below which a tail, or a segment of it, is left out. In sRGB encoding it is 0.8 of an 8-bit level.
const MIN_LEVEL: f64 = 1.0 / 4096.0;
/// Opacity of a comet's orbit at the comet.
const ORBIT_OPACITY: f64 = 0.6;
/// Length of the ion tail at a production of 10^30 water molecules per second, and the maximum of its length, au. The length grows with the square root of the
/// production.
const ION_LENGTH_AU: f64 = 0.25;
const MAX_ION_LENGTH_AU: f64 = 0.8;
/// Radius of the dense part of a coma: 80 000 km.
const COMA_RADIUS_AU: f64 = 80_000.0 / KM_PER_AU;
/// Tangent of the ion tail's half opening angle.
const ION_HALF_ANGLE_TANGENT: f64 = 0.03;
/// Integral over x from -1 to 1, the edges, of an ion ribbon's cross profile, (1 - x^2)^2 exp(-2 x^2).
const RIBBON_PROFILE_INTEGRAL: f64 = 0.839_4;
/// Mean over x from -1 to 1, the edges, of a dust patch's cross profile, 1 - x^2 (3 - 2 |x|).
const PATCH_PROFILE_MEAN: f64 = 0.5;
/// Linear RGB of the ion tail (CO+, whose bands lie from 400 to 500 nm) and of the coma (with the green bands of C2), chosen by eye; [`of_luminance_1`] scales
/// them.
const ION_RGB: [f64; 3] = [0.30, 0.55, 1.0];
const COMA_RGB: [f64; 3] = [0.85, 1.05, 0.8];

/// A segment of a ribbon. Tails are drawn as ribbons: strips along a line, which fade towards both edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TailSegment {
    /// Clip x and y, from -1 to 1 across the frame; reversed depth.
    pub ends: [Vec3; 2],
    /// Vectors from each end to the ribbon's edge, pixels, x right, y up.
    pub edges: [Vec2; 2],
    /// Radiance on the ribbon's centre line, at each end.
    pub radiance: [f32; 2],
    /// 1: a cross profile like a Gaussian; 0: a profile such that overlapping neighbours add up to a uniform sheet.
    pub softness: f32,
    /// Linear RGB of luminance 1.
    pub colour: Vec3,
}

/// The comets of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comets {
    pub heads: Vec<StarSprite>,
    pub tails: Vec<TailSegment>,
    /// Orbits of the comets in the frame that have tails, if orbits are switched on.
    pub orbits: Vec<OrbitArc>,
}

/// Direction of the ion tail of a comet with a heliocentric state (au, au per day): the solar wind relative to the comet.
pub fn ion_direction(state: &ConicState) -> DVec3 {
    let wind = SOLAR_WIND_KM_S * SECONDS_PER_DAY / KM_PER_AU;
    (state.position.normalize() * wind - state.velocity).normalize()
}

/// Heliocentric position, au, at the time `days` past J2000, of a grain that the comet released `age_days` before. `beta`: ratio of radiation pressure to
/// gravity.
pub fn grain_position_au(orbit: &HeliocentricOrbit, days: f64, age_days: f64, beta: f64) -> DVec3 {
    let released = heliocentric_state(orbit, days - age_days);
    // Without net gravity the grain moves in a straight line.
    let gm = GAUSS_CONSTANT * GAUSS_CONSTANT * (1.0 - beta);
    if gm > 0.0 { released.propagated(gm, age_days).position } else { released.position + released.velocity * age_days }
}

/// Total magnitude of a comet at the given distances from the viewer and from the Sun, au; `None` for a body with another brightness law.
pub fn total_magnitude(law: BrightnessLaw, distance_au: f64, sun_distance_au: f64) -> Option<f64> {
    match law {
        BrightnessLaw::Comet { m1, k1 } => Some(m1 + 5.0 * distance_au.log10() + k1 * sun_distance_au.log10()),
        _ => None,
    }
}

/// Water production in units of 10^30 molecules per second, by the heliocentric magnitude, which is the total magnitude at 1 au from the viewer (Jorda,
/// Crovisier and Green 2008, Asteroids, Comets, Meteors, 8046).
fn water_production(heliocentric_magnitude: f64) -> f64 {
    10.0_f64.powf(30.675 - 0.2453 * heliocentric_magnitude - 30.0)
}

/// The colour scaled to a luminance of 1.
fn of_luminance_1(rgb: [f64; 3]) -> DVec3 {
    DVec3::from_array(rgb) / luminance(rgb)
}

/// Projects heliocentric positions into the frame.
struct CometProjection<'a> {
    camera: &'a Camera,
    /// Heliocentric position of the camera, au.
    camera_au: DVec3,
    /// Velocity of the viewer, for aberration.
    velocity_km_s: DVec3,
}

/// A projected point.
#[derive(Clone, Copy, Debug)]
struct ProjectedPoint {
    /// From the middle of the frame, x right, y up.
    px: DVec2,
    /// Reversed depth.
    depth: f64,
    /// Flux per irradiance: pi divided by the pixel's solid angle.
    flux_per_irradiance: f64,
    /// Pixels per au across the line of sight.
    px_per_au: f64,
}

impl CometProjection<'_> {
    /// The projection of a position, with aberration; `None` behind the near plane.
    fn project(&self, heliocentric_au: DVec3) -> Option<ProjectedPoint> {
        let from_camera = heliocentric_au - self.camera_au;
        let distance = from_camera.length();
        let direction = aberrated(from_camera / distance, self.velocity_km_s);
        let clip = self.camera.clip(direction)?;
        let depth_au = direction.dot(self.camera.forward) * distance;
        let px = clip * self.camera.half_size_px();
        (depth_au > NEAR_AU).then(|| ProjectedPoint {
            px,
            depth: NEAR_AU / depth_au,
            flux_per_irradiance: PI / pixel_sr(self.camera, direction),
            px_per_au: 1.0 / (depth_au * self.camera.pixel_tangent()),
        })
    }

    /// Clip x and y, from -1 to 1 across the frame; reversed depth.
    fn clip(&self, point: &ProjectedPoint) -> Vec3 {
        narrow((point.px / self.camera.half_size_px()).extend(point.depth))
    }

    /// Whether a segment of this half width is outside the frame.
    fn is_outside(&self, a: &ProjectedPoint, b: &ProjectedPoint, half_px: f64) -> bool {
        let limit_px = self.camera.half_size_px() + DVec2::splat(half_px);
        let is_beyond = |v: DVec2| v.cmpgt(limit_px);
        (is_beyond(a.px) & is_beyond(b.px)).any() || (is_beyond(-a.px) & is_beyond(-b.px)).any()
    }

    /// Adds a ribbon through stations. For each station: `irradiance` is that of the segment that starts there (the last station has none), `half_px` is the
    /// ribbon's half width.
    fn ribbon(
        &self,
        stations: &[Option<ProjectedPoint>],
        irradiance: &[f64],
        half_px: &[f64],
        colour: DVec3,
        segments: &mut Vec<TailSegment>,
    ) {
        // 0 for a segment with an end behind the near plane.
        let segment_length_px = |k: usize| match (stations.get(k).copied().flatten(), stations.get(k + 1).copied().flatten()) {
            (Some(a), Some(b)) => a.px.distance(b.px),
            _ => 0.0,
        };
        let tangent = |k: usize| {
            let [previous, next] = [k.saturating_sub(1), (k + 1).min(stations.len() - 1)].map(|j| stations[j].or(stations[k]));
            previous.zip(next).and_then(|(a, b)| (b.px - a.px).try_normalize()).unwrap_or(DVec2::X)
        };
        let radiance = |k: usize, s: &ProjectedPoint| {
            // The segments that end and start at the station.
            let adjacent = [k.checked_sub(1), Some(k)].into_iter().flatten().filter(|j| *j + 1 < stations.len());
            let (total_irradiance, length_px) = adjacent.fold((0.0, 0.0), |(sum, px), j| (sum + irradiance[j], px + segment_length_px(j)));
            // The lower limit on the length prevents a ribbon seen end-on from becoming a bright needle.
            narrow_scalar(total_irradiance * s.flux_per_irradiance / (length_px.max(half_px[k]) * half_px[k] * RIBBON_PROFILE_INTEGRAL))
        };
        for k in 0..stations.len() - 1 {
            let (Some(a), Some(b)) = (stations[k], stations[k + 1]) else { continue };
            if self.is_outside(&a, &b, half_px[k].max(half_px[k + 1])) {
                continue;
            }
            let edge = |k: usize| narrow2(tangent(k).perp() * half_px[k]);
            segments.push(TailSegment {
                ends: [self.clip(&a), self.clip(&b)],
                edges: [edge(k), edge(k + 1)],
                radiance: [radiance(k, &a), radiance(k + 1, &b)],
                softness: 1.0,
                colour: narrow(colour),
            });
        }
    }

    /// Adds the dust tail: patches between grains of neighbouring beta and age. The patches between two syndynes form a strip. `days`: time past J2000;
    /// `irradiance`: irradiance of the entire tail.
    fn dust(&self, orbit: &HeliocentricOrbit, days: f64, irradiance: f64, segments: &mut Vec<TailSegment>) {
        // `line`: index of a syndyne; `k`: index of an age. Ages are more densely spaced for recently released grains.
        let age_days = |k: usize| MAX_AGE_DAYS * (k as f64 / (STATION_COUNT - 1) as f64).powi(2);
        // The values of beta are evenly spaced in the logarithm; the light per value falls to zero at both ends of the range.
        let log_beta_fraction = |line: usize| line as f64 / (SYNDYNE_COUNT - 1) as f64;
        let beta = |line: usize| MIN_BETA * (MAX_BETA / MIN_BETA).powf(log_beta_fraction(line));
        let syndynes: Vec<Vec<DVec3>> = (0..SYNDYNE_COUNT)
            .map(|line| (0..STATION_COUNT).map(|k| grain_position_au(orbit, days, age_days(k), beta(line))).collect())
            .collect();
        let projected: Vec<Vec<Option<ProjectedPoint>>> =
            syndynes.iter().map(|grains| grains.iter().map(|p| self.project(*p)).collect()).collect();
        // Grains are produced and lit in inverse proportion to the squared distance from the Sun. The exponential thins out old grains, so that the tail has
        // no visible end; its time scale is chosen. For all values of beta, the present distance from the Sun is taken from the grains with the smallest beta.
        let production = |k: usize| {
            let (release_au, current_au) = (heliocentric_state(orbit, days - age_days(k)).position.length(), syndynes[0][k].length());
            let old_grains_factor = (-age_days(k) / (0.4 * MAX_AGE_DAYS)).exp();
            (age_days(k + 1) - age_days(k)) / (release_au * release_au * current_au * current_au) * old_grains_factor
        };
        let production: Vec<f64> = (0..STATION_COUNT - 1).map(production).collect();
        let beta_weight: Vec<f64> =
            (0..SYNDYNE_COUNT - 1).map(|line| (PI * 0.5 * (log_beta_fraction(line) + log_beta_fraction(line + 1))).sin().powi(2)).collect();
        let total = production.iter().sum::<f64>() * beta_weight.iter().sum::<f64>();
        // A cross-section of the strip between two syndynes: its centre, and the vector in pixels from there to the strip's edge.
        let section = |line: usize, k: usize| -> Option<(ProjectedPoint, DVec2)> {
            let (a, b) = (projected[line][k]?, projected[line + 1][k]?);
            let [previous, next] = [k.saturating_sub(1), (k + 1).min(STATION_COUNT - 1)].map(|j| projected[line][j].unwrap_or(a));
            // The speed of release widens the strip with age. At the age 0 the width added on each side is half the radius of the coma.
            let spread_px = (0.5 * COMA_RADIUS_AU + GRAIN_SPEED_AU_PER_DAY * age_days(k)) * a.px_per_au;
            // Each strip extends to the centre line of the next, so that neighbours overlap.
            let gap = b.px - a.px;
            let across_strip = gap.try_normalize().or_else(|| (next.px - previous.px).perp().try_normalize()).unwrap_or(DVec2::X);
            Some((ProjectedPoint { px: 0.5 * (a.px + b.px), ..a }, gap + across_strip * spread_px))
        };
        let radiance = |line: usize, k: usize| -> Option<f64> {
            let ((a, edge_a), (b, edge_b)) = (section(line, k)?, section(line, k + 1)?);
            // As in `ribbon`, the lower limit on the length prevents a bright needle.
            let length_px = (b.px - a.px).length().max(0.5 * COMA_RADIUS_AU * a.px_per_au);
            // The edges are half widths, so their sum is the mean width.
            let width_px = edge_a.length() + edge_b.length();
            let effective_area_px = length_px * width_px * PATCH_PROFILE_MEAN;
            Some(irradiance * production[k] * beta_weight[line] / total * a.flux_per_irradiance / effective_area_px)
        };
        // Mean radiance of the patches before and after a section.
        let mean_radiance = |line: usize, k: usize| {
            let adjacent = [k.checked_sub(1), (k + 1 < STATION_COUNT).then_some(k)].into_iter().flatten().filter_map(|k| radiance(line, k));
            let (sum, count) = adjacent.fold((0.0, 0.0), |(sum, count), r| (sum + r, count + 1.0));
            if count > 0.0 { narrow_scalar(sum / count) } else { 0.0 }
        };
        // A B-V of 0.8 is slightly redder than sunlight.
        let colour = narrow(star_colour(Some(0.8)));
        for line in 0..SYNDYNE_COUNT - 1 {
            for k in 0..STATION_COUNT - 1 {
                let (Some((a, edge_a)), Some((b, edge_b))) = (section(line, k), section(line, k + 1)) else { continue };
                if self.is_outside(&a, &b, edge_a.length().max(edge_b.length())) {
                    continue;
                }
                segments.push(TailSegment {
                    ends: [self.clip(&a), self.clip(&b)],
                    edges: [narrow2(edge_a), narrow2(edge_b)],
                    radiance: [mean_radiance(line, k), mean_radiance(line, k + 1)],
                    softness: 0.0,
                    colour,
                });
            }
        }
    }

    /// The orbit line of a comet, from its heliocentric state.
    fn orbit(&self, state: &ConicState) -> Vec<OrbitArc> {
        let state_km = State { pos_km: state.position * KM_PER_AU, vel_km_s: state.velocity * (KM_PER_AU / SECONDS_PER_DAY) };
        let gm_km3_s2 = GAUSS_CONSTANT.powi(2) * KM_PER_AU.powi(3) / SECONDS_PER_DAY.powi(2);
        let from_camera = state.position - self.camera_au;
        let apparent_km = aberrated(from_camera.normalize(), self.velocity_km_s) * from_camera.length() * KM_PER_AU;
        let conic = Conic::of(&state_km, gm_km3_s2);
        conic.map_or_else(Vec::new, |conic| orbit_arcs::arcs(self.camera, &conic, apparent_km, ORBIT_OPACITY, of_luminance_1(COMA_RGB)))
    }

    /// Adds the ion tail: a straight ribbon. `irradiance`: irradiance of the entire tail.
    fn ions(&self, state: &ConicState, irradiance: f64, length_au: f64, segments: &mut Vec<TailSegment>) {
        let direction = ion_direction(state);
        // Distance of a station from the comet; stations are denser near the comet.
        let distance_au = |k: usize| length_au * (k as f64 / (STATION_COUNT - 1) as f64).powf(1.5);
        let stations: Vec<_> = (0..STATION_COUNT).map(|k| self.project(state.position + direction * distance_au(k))).collect();
        // The tail starts narrower than the coma and is at least 1.4 pixels wide, so that the drawn line has no gaps.
        let half_px = |k: usize| {
            stations[k]
                .map_or(1.0, |s: ProjectedPoint| (0.4 * COMA_RADIUS_AU + ION_HALF_ANGLE_TANGENT * distance_au(k)) * s.px_per_au + 0.7)
        };
        // Relative light of the part of the tail beyond a station: an exponential that falls by e^3 over the length, lowered to 0 at the end.
        let light_beyond = |k: usize| (-3.0 * distance_au(k) / length_au).exp() - (-3.0_f64).exp();
        let segment_irradiance: Vec<f64> =
            (0..STATION_COUNT - 1).map(|k| irradiance * (light_beyond(k) - light_beyond(k + 1)) / light_beyond(0)).collect();
        self.ribbon(
            &stations,
            &segment_irradiance,
            &(0..STATION_COUNT).map(half_px).collect::<Vec<_>>(),
            of_luminance_1(ION_RGB),
            segments,
        );
    }
}

/// A comet's heliocentric state at the time of emission, and that time in days past J2000. `days`: the time at the camera, past J2000.
fn state_at_emission(orbit: &HeliocentricOrbit, days: f64, camera_au: DVec3) -> (ConicState, f64) {
    let mut emission_days = days;
    for _ in 0..3 {
        let distance_au = (heliocentric_state(orbit, emission_days).position - camera_au).length();
        emission_days = days - distance_au * KM_PER_AU / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY;
    }
    (heliocentric_state(orbit, emission_days), emission_days)
}

/// The comets of a frame and the decision about them; no decision in pixel views other than the final image. `sun_position_km`: barycentric.
/// `white`: the radiance displayed as white.
pub(crate) fn comets(
    request: &ViewRequest,
    catalog_comets: impl FnOnce() -> Vec<SmallBody>,
    viewer: &Viewer,
    sun_position_km: Option<DVec3>,
    white: f64,
) -> (Comets, Option<Decision>) {
    let decided = |on: bool, reason: Reason| Some(Decision { effect: "comets", on, reason, stated_error: None });
    if request.pixel_view != PixelView::Final {
        return (Comets::default(), None);
    }
    if !request.layers.comets {
        return (Comets::default(), decided(false, reason!("comets-off")));
    }
    let Some(sun_position_km) = sun_position_km else {
        return (Comets::default(), decided(false, reason!("no-sun-known")));
    };
    let (camera, days) = (&viewer.camera, request.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
    let projection =
        CometProjection { camera, camera_au: (camera.position_km - sun_position_km) / KM_PER_AU, velocity_km_s: viewer.velocity_km_s };
    let (start_au, complete_au) = TAILS_AU;
    let mut in_frame = Comets::default();
    let (mut brightest, mut shown_head_count) = (None::<(f64, String)>, 0);
    for comet in catalog_comets() {
        let (state, emission_days) = state_at_emission(&comet.orbit, days, projection.camera_au);
        let (sun_distance_au, distance_au) = (state.position.length(), state.position.distance(projection.camera_au));
        let Some(magnitude) = total_magnitude(comet.brightness, distance_au, sun_distance_au) else { continue };
        let head_irradiance = irradiance_of_magnitude(magnitude);
        let head = projection.project(state.position);
        let tail_growth = smoothstep((start_au - sun_distance_au) / (start_au - complete_au));
        // Tails are visible only if the head is, because the head is brighter than any part of its tails. The head may be outside the frame, so its peak
        // radiance is computed for the middle of the frame.
        let peak_radiance = head_irradiance * PI / camera.pixel_tangent().powi(2) * point_peak();
        let is_visible = peak_radiance > white * MIN_LEVEL;
        if tail_growth > 0.0 && is_visible {
            let heliocentric_magnitude = magnitude - 5.0 * distance_au.log10();
            let length_au = (ION_LENGTH_AU * water_production(heliocentric_magnitude).sqrt()).min(MAX_ION_LENGTH_AU);
            projection.dust(&comet.orbit, emission_days, DUST_FRACTION * tail_growth * head_irradiance, &mut in_frame.tails);
            projection.ions(&state, ION_FRACTION * tail_growth * head_irradiance, length_au, &mut in_frame.tails);
        }
        let Some(head) = head else { continue };
        // A head too faint for the exposure is drawn as a marker.
        let flux = (head_irradiance * head.flux_per_irradiance).max(MARKER_LEVEL * white / point_peak());
        let radius_px = point_radius_px(flux * point_peak() / white);
        if head.px.abs().cmpgt(camera.half_size_px() + radius_px).any() {
            continue;
        }
        shown_head_count += 1;
        if tail_growth > 0.0 && request.layers.orbits {
            in_frame.orbits.extend(projection.orbit(&state));
        }
        if brightest.as_ref().is_none_or(|(brightest_so_far, _)| magnitude < *brightest_so_far) {
            brightest = Some((magnitude, comet.full_name()));
        }
        let rgb_flux = narrow(of_luminance_1(COMA_RGB) * flux);
        let (centre, radius_px) = (projection.clip(&head), narrow_scalar(radius_px));
        in_frame.heads.push(StarSprite { centre, radius_px, stretch: 1.0, flux: rgb_flux, star: None });
    }
    // Segments that are too faint to be visible would only cost time.
    let min_radiance = narrow_scalar(white * MIN_LEVEL);
    in_frame.tails.retain(|t| t.radiance[0].max(t.radiance[1]) > min_radiance);
    let heads_reason = match brightest {
        Some((magnitude, name)) => {
            reason!("comets-brightest", count = shown_head_count, comet = &name, magnitude = format_args!("{magnitude:.1}"))
        }
        None => reason!("comets-none"),
    };
    let reason = heads_reason.and(reason!("comets-tails", count = in_frame.tails.len()));
    let on = shown_head_count > 0 || !in_frame.tails.is_empty();
    (in_frame, decided(on, reason))
}
