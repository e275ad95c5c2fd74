//! Comets: the head as a point of light, a tail of dust and a tail of ions.
//!
//! In: the catalog's comets, the camera, what is white. Out: [`Comets`]: sprites for shaders/entry/point.wesl and pieces of ribbons for shaders/entry/comet_tail.wesl. The head has the total
//! magnitude M1 + 5 log d + K1 log r. Ions blow with the solar wind and lag by the comet's own velocity; grains of dust go on from where they left, under a gravity that the
//! pressure of sunlight weakens by beta. Directions follow from that alone; the lengths of tails and their part of the light are chosen by what observers draw, with no measurement
//! behind them. All in f64; only clip coordinates are narrowed. Left out: jets, outbursts, disconnections, anti-tails of large grains, the wind's changes.

use super::minor_planets::{MARK_LEVEL, NEAR_AU};
use super::star_colour::star_colour;
use crate::catalog::small_bodies::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, SmallBody};
use crate::ephemeris::State;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::conic::{ConicState, heliocentric_state};
use crate::scene::annotation::orbits::{self, Conic, OrbitArc};
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{Camera, narrow, narrow_scalar, narrow2};
use crate::scene::decision::Decision;
use crate::scene::draw::{PixelView, StarSprite};
use crate::scene::light::photometry::irradiance_of_magnitude;
use crate::scene::numeric::smoothstep;
use crate::scene::point::{point_peak, point_radius_px};
use crate::scene::request::view_request::ViewRequest;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S, luminance};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// Speed of the solar wind, km/s: the slow wind near the ecliptic (McComas et al. 2000, J. Geophys. Res. 105, 10419).
pub const SOLAR_WIND_KM_S: f64 = 400.0;
/// Sunlight's pressure over gravity, of the grains that are followed: from 20 micrometres down to half a micrometre (Burns, Lamy and Soter 1979, Icarus 40, 1).
const BETA_LEAST: f64 = 0.03;
const BETA_MOST: f64 = 1.0;
/// Grains' paths that are followed.
const LINES: usize = 14;
/// Speed at which grains leave, au a day: 0.2 km/s.
const GRAIN_SPEED_AU_DAY: f64 = 0.2 * SECONDS_PER_DAY / KM_PER_AU;
/// Grains left the comet up to so long ago, days.
const OLDEST_DAYS: f64 = 60.0;
/// Stations along a ribbon.
const STATIONS: usize = 24;
/// Light of the tails over that of the head, while ice sublimes.
const DUST_PART: f64 = 0.4;
const ION_PART: f64 = 0.12;
/// From the Sun, au, where tails begin to grow as a comet comes in, and where they are whole.
const TAILS_AU: (f64, f64) = (3.0, 1.5);
/// Of white: what is fainter is left out.
const LEAST_LEVEL: f64 = 1.0 / 4096.0;
/// Opacity of a comet's orbit beside it.
const ORBIT_STRENGTH: f64 = 0.6;
/// Length of the ions' tail at 10^30 molecules of water a second, and the longest, au.
const ION_LENGTH_AU: f64 = 0.25;
const ION_LONGEST_AU: f64 = 0.8;
/// Radius of the dense part of a coma, au (80 000 km), and tangent of half the angle at which the ions spread.
const COMA_AU: f64 = 80_000.0 / KM_PER_AU;
const ION_SPREAD: f64 = 0.03;
/// Integral of the ribbon's profile from edge to edge.
const PROFILE: f64 = 0.839_4;
/// The same of a patch of dust, over the patch's width.
const SOFT_PROFILE: f64 = 0.5;
/// Linear RGB of CO+, whose bands lie from 400 to 500 nm, and of a coma with the green of C2; scaled to luminance 1. By eye.
const ION_RGB: [f64; 3] = [0.30, 0.55, 1.0];
const COMA_RGB: [f64; 3] = [0.85, 1.05, 0.8];

/// A piece of a ribbon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TailPiece {
    /// Clip x and y, reversed depth.
    pub ends: [Vec3; 2],
    /// From each end to the ribbon's edge, pixels, x right, y up.
    pub edges: [Vec2; 2],
    /// In the ribbon's middle.
    pub radiance: [f32; 2],
    /// 1: a Gaussian across; 0: what overlaps with its neighbours to an even sheet.
    pub softness: f32,
    /// Linear RGB of luminance 1.
    pub colour: Vec3,
}

/// The comets of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comets {
    pub heads: Vec<StarSprite>,
    pub tails: Vec<TailPiece>,
    /// Of comets in the frame that are near enough to the Sun for tails, where orbits are wanted.
    pub orbits: Vec<OrbitArc>,
}

/// Direction in which the ions go from a comet of that heliocentric state (au, au a day): the wind as the comet meets it.
pub fn ion_direction(state: &ConicState) -> DVec3 {
    let wind = SOLAR_WIND_KM_S * SECONDS_PER_DAY / KM_PER_AU;
    (state.position.normalize() * wind - state.velocity).normalize()
}

/// Heliocentric place, au, of a grain that left the comet `age` days before `days`.
pub fn grain(orbit: &HeliocentricOrbit, days: f64, age: f64, beta: f64) -> DVec3 {
    let left = heliocentric_state(orbit, days - age);
    // Without any gravity left it flies straight on.
    let gm = GAUSS_CONSTANT * GAUSS_CONSTANT * (1.0 - beta);
    if gm > 0.0 { left.after(gm, age).position } else { left.position + left.velocity * age }
}

/// Total magnitude at a distance from the viewer and the Sun, au.
pub fn total_magnitude(law: BrightnessLaw, distance_au: f64, from_sun_au: f64) -> Option<f64> {
    match law {
        BrightnessLaw::Comet { m1, k1 } => Some(m1 + 5.0 * distance_au.log10() + k1 * from_sun_au.log10()),
        _ => None,
    }
}

/// Molecules of water a second over 10^30, by the heliocentric magnitude (Jorda, Crovisier and Green 2008, Asteroids, Comets, Meteors, 8046).
fn water(heliocentric_magnitude: f64) -> f64 {
    10.0_f64.powf(30.675 - 0.2453 * heliocentric_magnitude - 30.0)
}

fn of_luminance_1(rgb: [f64; 3]) -> DVec3 {
    DVec3::from_array(rgb) / luminance(rgb)
}

/// What places comets in a frame.
struct Sight<'a> {
    camera: &'a Camera,
    /// The camera from the Sun, au.
    camera_au: DVec3,
    velocity_km_s: DVec3,
}

/// A place in the picture.
#[derive(Clone, Copy, Debug)]
struct Station {
    px: DVec2,
    depth: f64,
    /// Flux of a unit of irradiance there: pi over a pixel's solid angle.
    gain: f64,
    /// Pixels of an au across the line of sight.
    px_per_au: f64,
}

impl Sight<'_> {
    fn station(&self, heliocentric_au: DVec3) -> Option<Station> {
        let seen = heliocentric_au - self.camera_au;
        let distance = seen.length();
        let apparent = aberrated(seen / distance, self.velocity_km_s) * distance;
        let clip = self.camera.clip(apparent)?;
        let depth_au = apparent.dot(self.camera.forward);
        let cos = (depth_au / distance).max(1e-3);
        let pixel = self.camera.pixel_tangent();
        let px = clip * self.camera.half_size();
        (depth_au > NEAR_AU).then(|| Station {
            px,
            depth: NEAR_AU / depth_au,
            gain: PI / (pixel * pixel * cos.powi(3)),
            px_per_au: 1.0 / (depth_au * pixel),
        })
    }

    fn clip(&self, s: &Station) -> Vec3 {
        narrow((s.px / self.camera.half_size()).extend(s.depth))
    }

    /// Whether a piece lies outside of the frame, with its width.
    fn is_beside(&self, a: &Station, b: &Station, half_px: f64) -> bool {
        let reach = self.camera.half_size() + DVec2::splat(half_px);
        let beyond = |v: DVec2| v.cmpgt(reach);
        (beyond(a.px) & beyond(b.px)).any() || (beyond(-a.px) & beyond(-b.px)).any()
    }

    /// A ribbon through stations; `irradiance`: of the piece that begins at each, `half_px`: its half width there.
    fn ribbon(&self, stations: &[Option<Station>], irradiance: &[f64], half_px: &[f64], colour: DVec3, into: &mut Vec<TailPiece>) {
        let length = |k: usize| match (stations.get(k).copied().flatten(), stations.get(k + 1).copied().flatten()) {
            (Some(a), Some(b)) => a.px.distance(b.px),
            _ => 0.0,
        };
        let way = |k: usize| {
            let [before, after] = [k.saturating_sub(1), (k + 1).min(stations.len() - 1)].map(|j| stations[j].or(stations[k]));
            before.zip(after).and_then(|(a, b)| (b.px - a.px).try_normalize()).unwrap_or(DVec2::X)
        };
        let radiance = |k: usize, s: &Station| {
            let around = [k.checked_sub(1), Some(k)].into_iter().flatten().filter(|j| *j + 1 < stations.len());
            let (light, long) = around.fold((0.0, 0.0), |(light, long), j| (light + irradiance[j], long + length(j)));
            // What hides in the coma is not drawn out to a needle.
            narrow_scalar(light * s.gain / (long.max(half_px[k]) * half_px[k] * PROFILE))
        };
        for k in 0..stations.len() - 1 {
            let (Some(a), Some(b)) = (stations[k], stations[k + 1]) else { continue };
            if self.is_beside(&a, &b, half_px[k].max(half_px[k + 1])) {
                continue;
            }
            let edge = |k: usize| narrow2(way(k).perp() * half_px[k]);
            into.push(TailPiece {
                ends: [self.clip(&a), self.clip(&b)],
                edges: [edge(k), edge(k + 1)],
                radiance: [radiance(k, &a), radiance(k + 1, &b)],
                softness: 1.0,
                colour: narrow(colour),
            });
        }
    }

    /// The dust of a comet of total irradiance `light`: patches between grains of neighbouring beta and age.
    fn dust(&self, orbit: &HeliocentricOrbit, days: f64, light: f64, into: &mut Vec<TailPiece>) {
        // Close together where grains have just left.
        let age = |k: usize| OLDEST_DAYS * (k as f64 / (STATIONS - 1) as f64).powi(2);
        // As much in each factor of beta, and nothing at both ends.
        let part = |line: usize| line as f64 / (LINES - 1) as f64;
        let beta = |line: usize| BETA_LEAST * (BETA_MOST / BETA_LEAST).powf(part(line));
        let fan: Vec<Vec<DVec3>> = (0..LINES).map(|line| (0..STATIONS).map(|k| grain(orbit, days, age(k), beta(line))).collect()).collect();
        let seen: Vec<Vec<Option<Station>>> = fan.iter().map(|line| line.iter().map(|p| self.station(*p)).collect()).collect();
        // A comet gives off more the nearer it is to the Sun, and its old grains have spread and are lit less.
        let shed = |k: usize| {
            let (then, now) = (heliocentric_state(orbit, days - age(k)).position.length(), fan[0][k].length());
            (age(k + 1) - age(k)) / (then * then * now * now) * (-age(k) / (0.4 * OLDEST_DAYS)).exp()
        };
        let shed: Vec<f64> = (0..STATIONS - 1).map(shed).collect();
        let of_beta: Vec<f64> = (0..LINES - 1).map(|line| (PI * 0.5 * (part(line) + part(line + 1))).sin().powi(2)).collect();
        let whole = shed.iter().sum::<f64>() * of_beta.iter().sum::<f64>();
        // A patch's middle line and edges, with what grains have spread by their own speed.
        let side = |line: usize, k: usize| -> Option<(DVec2, DVec2, Station)> {
            let (a, b) = (seen[line][k]?, seen[line + 1][k]?);
            let [before, after] = [k.saturating_sub(1), (k + 1).min(STATIONS - 1)].map(|j| seen[line][j].unwrap_or(a));
            let spread = (0.5 * COMA_AU + GRAIN_SPEED_AU_DAY * age(k)) * a.px_per_au;
            // Each reaches to the middle of the next.
            let gap = b.px - a.px;
            let across = gap.try_normalize().or_else(|| (after.px - before.px).perp().try_normalize()).unwrap_or(DVec2::X);
            Some((0.5 * (a.px + b.px), gap + across * spread, Station { px: 0.5 * (a.px + b.px), ..a }))
        };
        let radiance = |line: usize, k: usize| -> Option<f64> {
            let (a, b) = (side(line, k)?, side(line, k + 1)?);
            let along = (b.0 - a.0).length().max(0.5 * COMA_AU * a.2.px_per_au);
            let wide = 2.0 * 0.5 * (a.1.length() + b.1.length());
            Some(light * shed[k] * of_beta[line] / whole * a.2.gain / (along * wide * SOFT_PROFILE))
        };
        // Of the patches that meet in a grain.
        let mean = |line: usize, k: usize| {
            let around = [k.checked_sub(1), (k + 1 < STATIONS).then_some(k)].into_iter().flatten().filter_map(|k| radiance(line, k));
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), r| (sum + r, count + 1.0));
            if count > 0.0 { narrow_scalar(sum / count) } else { 0.0 }
        };
        let colour = narrow(star_colour(Some(0.8)));
        for line in 0..LINES - 1 {
            for k in 0..STATIONS - 1 {
                let (Some(a), Some(b)) = (side(line, k), side(line, k + 1)) else { continue };
                if self.is_beside(&a.2, &b.2, a.1.length().max(b.1.length())) {
                    continue;
                }
                into.push(TailPiece {
                    ends: [self.clip(&a.2), self.clip(&b.2)],
                    edges: [narrow2(a.1), narrow2(b.1)],
                    radiance: [mean(line, k), mean(line, k + 1)],
                    softness: 0.0,
                    colour,
                });
            }
        }
    }

    /// The line on which a comet of that heliocentric state goes.
    fn orbit(&self, state: &ConicState) -> Vec<OrbitArc> {
        let km = State { pos_km: state.position * KM_PER_AU, vel_km_s: state.velocity * (KM_PER_AU / SECONDS_PER_DAY) };
        let gm_km3_s2 = GAUSS_CONSTANT.powi(2) * KM_PER_AU.powi(3) / SECONDS_PER_DAY.powi(2);
        let seen = state.position - self.camera_au;
        let apparent_km = aberrated(seen.normalize(), self.velocity_km_s) * seen.length() * KM_PER_AU;
        let conic = Conic::of(&km, gm_km3_s2);
        conic.map_or_else(Vec::new, |conic| orbits::arcs(self.camera, &conic, apparent_km, ORBIT_STRENGTH, of_luminance_1(COMA_RGB)))
    }

    fn ions(&self, state: &ConicState, light: f64, length_au: f64, into: &mut Vec<TailPiece>) {
        let direction = ion_direction(state);
        let along = |k: usize| length_au * (k as f64 / (STATIONS - 1) as f64).powf(1.5);
        let stations: Vec<_> = (0..STATIONS).map(|k| self.station(state.position + direction * along(k))).collect();
        let half = |k: usize| stations[k].map_or(1.0, |s: Station| (0.4 * COMA_AU + ION_SPREAD * along(k)) * s.px_per_au + 0.7);
        let left = |k: usize| (-3.0 * along(k) / length_au).exp() - (-3.0_f64).exp();
        let irradiance: Vec<f64> = (0..STATIONS - 1).map(|k| light * (left(k) - left(k + 1)) / left(0)).collect();
        self.ribbon(&stations, &irradiance, &(0..STATIONS).map(half).collect::<Vec<_>>(), of_luminance_1(ION_RGB), into);
    }
}

/// A comet's heliocentric state when the light left, and when that was in days past J2000.
fn when_light_left(orbit: &HeliocentricOrbit, days: f64, camera_au: DVec3) -> (ConicState, f64) {
    let mut then = days;
    for _ in 0..3 {
        let distance_au = (heliocentric_state(orbit, then).position - camera_au).length();
        then = days - distance_au * KM_PER_AU / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY;
    }
    (heliocentric_state(orbit, then), then)
}

/// The comets of a frame, and why they are there or not; `None` where the picture shows a number. `sun_km`: barycentric.
pub(crate) fn comets(
    request: &ViewRequest,
    all: impl FnOnce() -> Vec<SmallBody>,
    viewer: &Viewer,
    sun_km: Option<DVec3>,
    white: f64,
) -> (Comets, Option<Decision>) {
    let decided = |on: bool, reason: String| Some(Decision { feature: "comets", on, reason, tier: None });
    if request.pixel_view != PixelView::Final {
        return (Comets::default(), None);
    }
    if !request.layers.comets {
        return (Comets::default(), decided(false, "off unless you ask for it: faint ones are marks".into()));
    }
    let Some(sun_km) = sun_km else {
        return (Comets::default(), decided(false, "no source knows where the Sun is at this time".into()));
    };
    let (camera, days) = (&viewer.camera, request.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
    let sight = Sight { camera, camera_au: (camera.position_km - sun_km) / KM_PER_AU, velocity_km_s: viewer.velocity_km_s };
    let mut found = Comets::default();
    let (mut brightest, mut shown) = (None::<(f64, String)>, 0);
    for comet in all() {
        let (state, then) = when_light_left(&comet.orbit, days, sight.camera_au);
        let (from_sun, distance) = (state.position.length(), state.position.distance(sight.camera_au));
        let Some(magnitude) = total_magnitude(comet.brightness, distance, from_sun) else { continue };
        let light = irradiance_of_magnitude(magnitude);
        let head = sight.station(state.position);
        let growth = smoothstep((TAILS_AU.0 - from_sun) / (TAILS_AU.0 - TAILS_AU.1));
        // The head is brighter than any place of its tails.
        let shows = light * PI / camera.pixel_tangent().powi(2) * point_peak() > white * LEAST_LEVEL;
        if growth > 0.0 && shows {
            let length_au = (ION_LENGTH_AU * water(magnitude - 5.0 * distance.log10()).sqrt()).min(ION_LONGEST_AU);
            sight.dust(&comet.orbit, then, DUST_PART * growth * light, &mut found.tails);
            sight.ions(&state, ION_PART * growth * light, length_au, &mut found.tails);
        }
        let Some(head) = head else { continue };
        let flux = (light * head.gain).max(MARK_LEVEL * white / point_peak());
        let radius_px = point_radius_px(flux * point_peak() / white);
        if head.px.abs().cmpgt(camera.half_size() + radius_px).any() {
            continue;
        }
        shown += 1;
        if growth > 0.0 && request.layers.orbits {
            found.orbits.extend(sight.orbit(&state));
        }
        if brightest.as_ref().is_none_or(|(least, _)| magnitude < *least) {
            brightest = Some((magnitude, comet.full_name()));
        }
        let colour = narrow(of_luminance_1(COMA_RGB) * flux);
        found.heads.push(StarSprite { centre: sight.clip(&head), radius_px: narrow_scalar(radius_px), flux: colour, star: None });
    }
    // A tail that no level of the display shows costs time alone.
    let least = narrow_scalar(white * LEAST_LEVEL);
    found.tails.retain(|t| t.radiance[0].max(t.radiance[1]) > least);
    let reason = match brightest {
        Some((magnitude, name)) => {
            format!("{shown} in the frame, the brightest {name} of magnitude {magnitude:.1}; {} pieces of tails", found.tails.len())
        }
        None => format!("none in the frame; {} pieces of tails", found.tails.len()),
    };
    let on = shown > 0 || !found.tails.is_empty();
    (found, decided(on, reason))
}
