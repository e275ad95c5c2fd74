//! Maps at the poles: after the pole filter, no map of the catalog has radial streaks, a cone or a dot at a pole.
//!
//! Measure of streaks: in a band of latitude, the energy of the gradient along rows divided by that across rows. It is at most 1 for a
//! function that is smooth at the pole (terms r^p cos(m phi) with p >= m), and 1/cos² of the latitude for white noise in the texels.

use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::{Body, Catalog, Map, NaifId};
use orrery::image::{MapDecoding, MapStore, PoleFilter, TexelFormat, Texture};
use orrery::render::plan::{ResourceProvider, SamplingQuality, map_decoding};
use orrery::scene::draw::{MapFiles, MapRole, PixelView, Shape};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;
use std::f64::consts::{PI, TAU};

/// The maps of a body with their roles.
fn maps(b: &Body) -> Vec<(MapRole, &Map)> {
    let surface_maps = [
        (MapRole::Albedo, &b.maps.albedo),
        (MapRole::Normal, &b.maps.normal),
        (MapRole::Specular, &b.maps.specular),
        (MapRole::Night, &b.maps.night),
    ];
    let surface_maps = surface_maps.into_iter().filter_map(|(role, map)| Some((role, map.as_ref()?)));
    surface_maps.chain(b.clouds.as_ref().map(|c| (MapRole::Clouds, &c.map))).collect()
}

/// Rows from a pole to half way to the equator, in levels of 255. `has_slopes`: east and north slopes are rotated into a frame that does
/// not turn with longitude.
fn rows(map: &Texture, is_north: bool, has_slopes: bool) -> Vec<Vec<[f64; 3]>> {
    let level = &map.levels[0];
    let (w, h) = (level.width as usize, level.height as usize);
    let row = |k: usize| {
        let y = if is_north { k } else { h - 1 - k };
        let texel = |x: usize| {
            let t = &level.bytes()[(y * w + x) * 4..][..3];
            let t = [0, 1, 2].map(|c| f64::from(t[c]));
            if !has_slopes {
                return t;
            }
            let (sin, cos) = ((x as f64 + 0.5) / w as f64 * TAU).sin_cos();
            let (east, north_slope) = (t[0] - 127.5, (t[1] - 127.5) * if is_north { -1.0 } else { 1.0 });
            [north_slope * cos - east * sin, east * cos + north_slope * sin, t[2]]
        };
        (0..w).map(texel).collect()
    };
    (0..h / 4).map(row).collect()
}

/// The measure of streaks between two latitudes. Differences of up to one level are rounding, and are ignored.
fn along_over_across(rows: &[Vec<[f64; 3]>], from_deg: f64, to_deg: f64) -> f64 {
    let height = rows.len() * 4;
    let lat = |k: usize| (0.5 - (k as f64 + 0.5) / height as f64) * PI;
    let visible_energy = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| ((a[c] - b[c]).abs() - 1.0).max(0.0).powi(2)).sum::<f64>();
    let (mut along, mut across) = (0.0, 0.0);
    for (k, row) in rows.iter().enumerate().filter(|(k, _)| (from_deg..to_deg).contains(&lat(*k).to_degrees())) {
        let Some(next) = rows.get(k + 1) else { continue };
        let (w, cos) = (row.len(), lat(k).cos());
        // Distance between texels of a row, relative to the distance between rows.
        let step = TAU / w as f64 * cos * height as f64 / PI;
        along += cos * (0..w).map(|x| visible_energy(&row[x], &row[(x + 1) % w])).sum::<f64>() / w as f64 / (step * step);
        across += cos * (0..w).map(|x| visible_energy(&row[x], &next[x])).sum::<f64>() / w as f64;
    }
    // The constant keeps invisible differences from dominating the ratio.
    along / (across + 0.5)
}

/// Measured: at most 2 for the shipped maps, except 3.4 for Janus, whose map has long painted rays.
const MAX_RATIO: f64 = 3.6;
const BANDS: [(f64, f64); 4] = [(60.0, 72.0), (72.0, 80.0), (80.0, 85.0), (85.0, 90.0)];

#[test]
fn no_map_has_streaks_around_its_poles() {
    let raw = MapStore::new(None);
    let mut files_with_streaks = 0;
    for body in Catalog::embedded().bodies() {
        let cloud_texel_bits = body.clouds.as_ref().map(|c| [c.clear_texel, c.closed_texel].map(|texel| (texel as f32).to_bits()));
        let files = MapFiles { cloud_texel_bits, ..MapFiles::default() };
        for (role, map) in maps(body) {
            let decoding = map_decoding(role, &files, Shape::Ellipsoid);
            let drawn = SESSION.map(&map.file, decoding).expect("a map");
            let unfiltered = raw.get(&map.file, decoding.format).expect("a map");
            let mut worst: f64 = 0.0;
            for is_north in [true, false] {
                let hemisphere = |t: &Texture| rows(t, is_north, decoding.poles == PoleFilter::Normals);
                let (drawn, unfiltered) = (hemisphere(&drawn), hemisphere(&unfiltered));
                for (from, to) in BANDS {
                    let ratio = along_over_across(&drawn, from, to);
                    assert!(ratio < MAX_RATIO, "{} between {from} and {to} degrees (north: {is_north}): {ratio:.2}", map.file);
                    worst = worst.max(along_over_across(&unfiltered, from, to));
                }
            }
            files_with_streaks += i32::from(worst > MAX_RATIO);
        }
    }
    assert!(files_with_streaks > 20, "the measure must detect the streaks of the unfiltered files: {files_with_streaks}");
}

/// The mean slope towards the pole, within 3 degrees of it, is at most half the standard deviation around 80 degrees, plus two levels.
#[test]
fn no_relief_has_a_cone_at_its_pole() {
    for body in Catalog::embedded().bodies() {
        let Some(map) = &body.maps.normal else { continue };
        for poles in [PoleFilter::Normals, PoleFilter::None] {
            let texture = SESSION.map(&map.file, MapDecoding { poles, ..MapDecoding::plain(TexelFormat::Rgba8Unorm) }).expect("a map");
            let level = &texture.levels[0];
            let (w, h) = (level.width as usize, level.height as usize);
            // Mean and standard deviation of the northward slope between two latitudes, in levels.
            let slope = |from_deg: f64, to_deg: f64, is_north: bool| {
                let row = |deg: f64| ((if is_north { 90.0 - deg } else { 90.0 + deg }) / 180.0 * h as f64) as usize;
                let (first, end) = (row(from_deg).min(row(to_deg)), row(from_deg).max(row(to_deg)).min(h));
                let values: Vec<f64> = (first * w..end * w).map(|i| f64::from(level.bytes()[i * 4 + 1]) - 127.5).collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
            };
            for is_north in [true, false] {
                let (mean, _) = slope(87.0, 90.0, is_north);
                let (_, deviation) = slope(75.0, 85.0, is_north);
                assert!(mean.abs() < 0.5 * deviation + 2.0, "{} (north: {is_north}): {mean:.1} levels against {deviation:.1}", map.file);
            }
        }
    }
}

/// The pixel at the pole matches its neighbours, so it is not read from a coarser mip level.
#[test]
fn no_map_has_a_dot_at_its_pole() {
    let time = Instant::parse("2025-01-10T00:00:00Z").expect("a time");
    let mut poles_with_features = 0;
    for body in Catalog::embedded().bodies().iter().filter(|b| b.maps.albedo.is_some() && b.id != NaifId::SUN) {
        for sign in [1.0, -1.0] {
            // So close that a texel covers several pixels, and the image is smooth.
            let height_km = 0.05 * body.radii_km.z;
            let request = ViewRequest {
                width: 41,
                height: 41,
                position: Position::Ground { body: body.id, latitude_deg: 90.0 * sign, longitude_deg: 0.0, height_km },
                fov_deg: Some(20.0),
                pixel_view: PixelView::Albedo,
                exposure: ExposureRequest::Stops(0.0),
                effects: EffectOverrides::parse("-normal,-clouds,-rings,-atmosphere").expect("effects"),
                ..ViewRequest::of(body.id, time)
            };
            let hdr =
                SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("draws").frame.hdr;
            let at = |x: i32, y: i32| hdr[(y * 41 + x) as usize][1];
            let ring = |radius_px: i32| {
                let angles = (0..12).map(|k| f64::from(k) * TAU / 12.0);
                angles
                    .map(|a| at(20 + (f64::from(radius_px) * a.cos()).round() as i32, 20 + (f64::from(radius_px) * a.sin()).round() as i32))
                    .collect::<Vec<_>>()
            };
            let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
            let spread = |v: &[f32]| v.iter().map(|x| (x - mean(v)).abs()).fold(0.0, f32::max);
            let (inner, outer) = (ring(2), ring(6));
            let difference = (at(20, 20) - mean(&inner)).abs();
            // At most 2 %, plus the differences within the inner ring and between the rings.
            let allowed = 0.02 * mean(&inner) + spread(&inner) + (mean(&outer) - mean(&inner)).abs();
            assert!(difference <= allowed, "{} at {}: {difference} beside {}, allowed {allowed}", body.name, 90.0 * sign, mean(&inner));
            poles_with_features += i32::from(spread(&outer) > 0.0);
        }
    }
    assert!(poles_with_features > 30, "{poles_with_features} poles have visible features");
}
