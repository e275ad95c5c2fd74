//! The Moon's heights, four times finer than the map of heights: smoothed where noise prevails, with craters in the shape that is known from photographs.
//!
//! In: a map of heights in 8-bit levels ([`METRES_PER_LEVEL`]), and the gazetteer's craters. Out: heights, in which only this is finer than the map: the
//! difference between the profile of a fresh crater and its means over the map's texels, for each crater that the map shows with or without a name, and in
//! proportion to its depth there. Nothing is random, and no crater is where the map has none.
//! Profile: depth, height of the rim and width of the floor by the laws that Pike (1977, Impact and Explosion Cratering, 489) fitted to fresh craters.

use super::heights::Heights;
use super::{Feature, smoothstep};
use image::GrayImage;
use std::f64::consts::PI;

pub(super) const RADIUS_KM: f64 = 1737.4;
/// Height of a grey level: that for which the Moon's centre of figure lies 1.935 km from its centre of mass, as measured by LOLA (Smith et al. 2010). The map's
/// own offset points in the same direction within 0.2 degrees, and each of its three components alone gives 77.4 to 78.1.
const METRES_PER_LEVEL: f64 = 77.5;
/// Noise of the map, levels: rounding and JPEG, measured as the smallest differences from the smoothed map, in the most level seas.
const NOISE_LEVELS: f64 = 0.35;

/// A crater that the map of heights shows. Its position: degrees, east from -180 to 180.
struct Crater {
    lat_deg: f64,
    lon_deg: f64,
    diameter_km: f64,
    /// Factor on the profile of a fresh crater.
    freshness: f64,
    /// Height of the central peak above the floor, metres; 0: none is resolved.
    peak_m: f64,
    /// Correlation of the profile with the heights, -1 to 1.
    correlation: f64,
}

/// Distance from the centre, in radii of the rim, at which the flank outside has ended.
const FLANK_END: f64 = 2.5;
/// The same distance up to which heights are compared with the profile.
const COMPARED: f64 = 1.5;
/// Smallest diameter of craters whose central peak the map of heights resolves: a fifth of it is a texel.
const PEAK_FROM_KM: f64 = 55.0;
/// A crater is used if the profile explains its heights as well as this, and if it is at least this deep.
const MIN_CORRELATION: f64 = 0.5;
const MIN_FRESHNESS: f64 = 0.15;
/// Unnamed craters must be clearer, and deeper. With these limits some two thirds as many craters from 20 km are found as there are on LOLA's heights, 5185
/// (Head et al. 2010, Science 329, 1504).
const MIN_UNNAMED_CORRELATION: f64 = 0.9;
const MIN_UNNAMED_FRESHNESS: f64 = 0.35;
/// Craters fresher than this have none of [`UNNAMED_DIAMETERS_KM`] on their floors: hollows there lie between the wall and the peak.
const YOUNG: f64 = 0.8;
/// Diameters that are tried for craters without a name, km: from a size below two texels of the heights to one that they show well.
const UNNAMED_DIAMETERS_KM: [f64; 8] = [18.0, 22.0, 27.0, 33.0, 40.0, 49.0, 60.0, 73.0];

/// Height of a fresh crater's ground over that around it, metres, at a distance from its centre. Pike's laws for diameters of 15 km or more.
fn profile_m(diameter_km: f64, distance_km: f64) -> f64 {
    let d = diameter_km;
    let rim_radius = d / 2.0;
    let (depth, rim) = (1.044 * d.powf(0.301), 0.236 * d.powf(0.399));
    let floor_radius = (0.187 * d.powf(1.249) / 2.0).min(0.8 * rim_radius);
    let t = distance_km / rim_radius;
    let km = if t < 1.0 {
        rim - depth * (1.0 - smoothstep(floor_radius, rim_radius, distance_km))
    } else {
        // Ejecta thin out with the cube of the distance (McGetchin et al. 1973).
        rim * t.powi(-3) * ((FLANK_END - t) / (FLANK_END - 1.5)).clamp(0.0, 1.0)
    };
    1000.0 * km
}

/// A central peak of height 1; its foot is about a fifth of the crater wide (Hale & Head 1979).
fn peak(diameter_km: f64, distance_km: f64) -> f64 {
    (-0.5 * (distance_km / (0.055 * diameter_km)).powi(2)).exp()
}

/// Distance over the ground between two places, km. Latitudes and the difference of longitudes in radians.
fn distance_km(lat: f64, other_lat: f64, longitude_difference: f64) -> f64 {
    let haversine = ((lat - other_lat) / 2.0).sin().powi(2) + lat.cos() * other_lat.cos() * (longitude_difference / 2.0).sin().powi(2);
    2.0 * RADIUS_KM * haversine.sqrt().min(1.0).asin()
}

/// Calls `visit` with the column and row of each texel of a map within `reach_km` of a place (and some beyond).
fn texels_around((width, height): (usize, usize), lat_deg: f64, lon_deg: f64, reach_km: f64, mut visit: impl FnMut(usize, usize)) {
    let reach = reach_km / RADIUS_KM;
    let rows = reach / PI * height as f64;
    let middle = (90.0 - lat_deg) / 180.0 * height as f64;
    let cos_farthest = (lat_deg.abs().to_radians() + reach).min(PI / 2.0).cos().max(1e-3);
    let columns = (reach / (2.0 * PI) * width as f64 / cos_farthest).min(0.5 * width as f64 - 1.0);
    let centre = (lon_deg + 180.0) / 360.0 * width as f64;
    for row in (middle - rows).max(0.0) as usize..=((middle + rows) as usize).min(height - 1) {
        for column in (centre - columns).floor() as i64..=(centre + columns).floor() as i64 {
            visit(column.rem_euclid(width as i64) as usize, row);
        }
    }
}

/// Values at the same places, each with its weight.
struct Column(Vec<f64>);

impl Column {
    fn dot(&self, other: &Self) -> f64 {
        self.0.iter().zip(&other.0).map(|(a, b)| a * b).sum()
    }

    /// Takes out the part that is proportional to `other`, and returns the factor of proportion.
    fn remove(&mut self, other: &Self) -> f64 {
        let factor = self.dot(other) / other.dot(other).max(1e-12);
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a -= factor * b);
        factor
    }
}

/// The crater of this place and size, as the heights show it: a least-squares fit of the profile and of a plane. `None` if too few texels lie in it.
fn fit(heights: &Heights, lat_deg: f64, lon_deg: f64, diameter_km: f64) -> Option<Crater> {
    let (width, height) = (heights.width, heights.height);
    let (lat, radius_km) = (lat_deg.to_radians(), diameter_km / 2.0);
    // For each texel: weight 1, position north and east, the profile, the peak, and the height. The roots of the areas weight them.
    let mut columns: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::new());
    texels_around((width, height), lat_deg, lon_deg, COMPARED * radius_km, |x, y| {
        // Of the place, in the texel from -0.5 to 0.5 to each side of its middle.
        let place = |across: f64, down: f64| {
            let row_lat = (0.5 - (y as f64 + 0.5 + down) / height as f64) * PI;
            let east_deg = (x as f64 + 0.5 + across) / width as f64 * 360.0 - 180.0 - lon_deg;
            (row_lat, (east_deg - 360.0 * (east_deg / 360.0).round()).to_radians())
        };
        let (row_lat, east) = place(0.0, 0.0);
        if distance_km(lat, row_lat, east) > COMPARED * radius_km {
            return;
        }
        // The map holds the mean height of each texel.
        let (mut bowl, mut peak_height) = (0.0, 0.0);
        for step in 0..9 {
            let (row_lat, east) = place(f64::from(step % 3 - 1) / 3.0, f64::from(step / 3 - 1) / 3.0);
            let distance = distance_km(lat, row_lat, east);
            bowl += profile_m(diameter_km, distance) / 9.0;
            peak_height += peak(diameter_km, distance) / 9.0;
        }
        let weight = row_lat.cos().max(0.0).sqrt();
        let values = [1.0, row_lat - lat, east * lat.cos(), bowl, peak_height, heights.at(x as i64, y as i64)];
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(weight * value));
    });
    if columns[0].len() < 6 {
        return None;
    }
    let [one, mut north, mut east, mut bowl, mut peak_height, mut measured] = columns.map(Column);
    north.remove(&one);
    for c in [&one, &north] {
        east.remove(c);
    }
    for c in [&one, &north, &east] {
        bowl.remove(c);
        measured.remove(c);
    }
    let correlation = measured.dot(&bowl) / (measured.dot(&measured) * bowl.dot(&bowl)).sqrt().max(1e-12);
    let freshness = measured.remove(&bowl);
    for c in [&one, &north, &east, &bowl] {
        peak_height.remove(c);
    }
    let peak_m = if diameter_km < PEAK_FROM_KM { 0.0 } else { measured.remove(&peak_height) };
    // No peak is higher than half the depth (Hale & Grieve 1982).
    let peak_m = peak_m.clamp(0.0, 0.5 * freshness.max(0.0) * -profile_m(diameter_km, 0.0));
    Some(Crater { lat_deg, lon_deg, diameter_km, freshness: freshness.min(1.2), peak_m, correlation })
}

/// The gazetteer's craters that the heights show.
fn named(heights: &Heights, list: &[Feature]) -> Vec<Crater> {
    let shown = |c: &Crater| c.correlation >= MIN_CORRELATION && c.freshness >= MIN_FRESHNESS;
    list.iter().filter_map(|f| fit(heights, f.lat_deg, f.lon_deg, f.diameter_km)).filter(shown).collect()
}

/// Craters of [`UNNAMED_DIAMETERS_KM`] that the heights show and `known` lacks. Each begins as a texel lower than its neighbours; place and size are those for
/// which the profile explains the heights best. Of craters that overlap by more than walls, the one with the better fit is kept.
fn unnamed(heights: &Heights, known: &[Crater]) -> Vec<Crater> {
    let (width, height) = (heights.width as i64, heights.height as i64);
    let mut found: Vec<Crater> = Vec::new();
    for (x, y) in (1..height - 1).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let level = heights.at(x, y);
        if !(0..9).all(|k| level <= heights.at(x + k % 3 - 1, y + k / 3 - 1)) {
            continue;
        }
        // The larger of two craters that fit equally well explains more heights.
        let merit = |c: &Crater| c.correlation + 0.02 * c.diameter_km.ln();
        let fitted = |across: f64, down: f64| {
            let lat_deg = 90.0 - (y as f64 + 0.5 + down) / height as f64 * 180.0;
            let lon_deg = (x as f64 + 0.5 + across) / width as f64 * 360.0 - 180.0;
            move |diameter_km: f64| fit(heights, lat_deg, lon_deg, diameter_km)
        };
        let best_of = |a: Option<Crater>, b: Crater| if a.as_ref().is_some_and(|a| merit(a) >= merit(&b)) { a } else { Some(b) };
        let mut best = UNNAMED_DIAMETERS_KM.into_iter().filter_map(fitted(0.0, 0.0)).fold(None, best_of);
        if best.as_ref().is_none_or(|c| c.correlation < MIN_UNNAMED_CORRELATION - 0.15) {
            continue;
        }
        // To places up to half a texel away, where the crater of this size fits better.
        for step in (0..25).filter(|step| *step != 12) {
            let place = fitted(0.25 * f64::from(step % 5 - 2), 0.25 * f64::from(step / 5 - 2));
            let diameter_km = best.as_ref().map_or(UNNAMED_DIAMETERS_KM[0], |c| c.diameter_km);
            if let Some(c) = place(diameter_km) {
                best = best_of(best, c);
            }
        }
        found.extend(best.filter(|c| c.correlation >= MIN_UNNAMED_CORRELATION && c.freshness >= MIN_UNNAMED_FRESHNESS));
    }
    found.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    let mut kept: Vec<Crater> = Vec::new();
    for c in found {
        let is_same = |other: &Crater| {
            let apart = distance_km(c.lat_deg.to_radians(), other.lat_deg.to_radians(), (c.lon_deg - other.lon_deg).to_radians());
            let ratio = c.diameter_km / other.diameter_km;
            let is_on_young_floor = other.freshness > YOUNG && apart < 0.5 * other.diameter_km;
            apart < 0.35 * c.diameter_km.min(other.diameter_km) && (0.4..2.5).contains(&ratio)
                || apart < 0.15 * other.diameter_km
                || is_on_young_floor
        };
        if !known.iter().chain(&kept).any(is_same) {
            kept.push(c);
        }
    }
    kept
}

/// Adds the profile of a crater to heights.
fn add(heights: &mut Heights, crater: &Crater) {
    let (width, height) = (heights.width, heights.height);
    let Crater { lat_deg, lon_deg, diameter_km, freshness, peak_m, .. } = *crater;
    texels_around((width, height), lat_deg, lon_deg, FLANK_END * diameter_km / 2.0, |x, y| {
        let lat = (0.5 - (y as f64 + 0.5) / height as f64) * PI;
        let east = ((x as f64 + 0.5) / width as f64 * 360.0 - 180.0 - lon_deg).to_radians();
        let distance = distance_km(lat_deg.to_radians(), lat, east);
        heights.metres[y * width + x] += freshness * profile_m(diameter_km, distance) + peak_m * peak(diameter_km, distance);
    });
}

/// The Moon's heights from the levels of a map and the gazetteer's craters.
pub(super) fn moon_heights(levels: &GrayImage, gazetteer: &[Feature]) -> Heights {
    let (width, height) = (levels.width() as usize, levels.height() as usize);
    let measured = Heights::from_fn(width, height, |x, y| METRES_PER_LEVEL * f64::from(levels.get_pixel(x as u32, y as u32)[0]));
    let mut craters = named(&measured, gazetteer);
    let named_count = craters.len();
    craters.extend(unnamed(&measured, &craters));
    println!("moon_normal.jpg: craters shown by the heights: {named_count} with a name, {} without", craters.len() - named_count);
    let heights = measured.denoised(NOISE_LEVELS * METRES_PER_LEVEL).finer();
    let mut profiles = Heights::from_fn(heights.width, heights.height, |_, _| 0.0);
    craters.iter().for_each(|crater| add(&mut profiles, crater));
    let coarse_profiles = profiles.coarser().finer();
    heights.combined(&profiles.combined(&coarse_profiles, |a, b| a - b), |a, b| a + b)
}
