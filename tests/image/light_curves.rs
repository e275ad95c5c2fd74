//! Bright and dark sides of bodies: the catalog's harmonics of each albedo map against the map, the rotational light curve against sums over the disc, and
//! against published magnitudes.

use crate::support::folds::{larger, smaller};
use glam::DVec3;
use orrery::catalog::{AlbedoHarmonics, Body, Catalog, Map, NaifId};
use orrery::image::{MapStore, TexelFormat, Texture};
use orrery::scene::photometry::{light_curve, magnitude, reflectance};
use std::f64::consts::{PI, TAU};

/// For each cell of a grid of 2 degrees: the direction of its middle, the mean of the map's green channel in it relative to that of the sphere, and its solid
/// angle.
fn cells(map: &Texture) -> Vec<(DVec3, f64, f64)> {
    let level = &map.levels[0];
    let (width, height) = (level.width as usize, level.height as usize);
    let decoded = |byte: u8| orrery::units::srgb_to_linear(f64::from(byte) / 255.0);
    let mut cells = Vec::new();
    let (columns, rows) = (180, 90);
    for row in 0..rows {
        let latitude = PI * (0.5 - (row as f64 + 0.5) / rows as f64);
        for column in 0..columns {
            let longitude = TAU * ((column as f64 + 0.5) / columns as f64 - 0.5);
            let texels = |from: usize, count: usize, of: usize| from * of / count..((from + 1) * of / count).max(from * of / count + 1);
            let (mut sum, mut count) = (0.0, 0.0);
            for y in texels(row, rows, height) {
                for x in texels(column, columns, width) {
                    sum += decoded(level.bytes()[(y * width + x) * 4 + 1]);
                    count += 1.0;
                }
            }
            let direction = DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
            cells.push((direction, sum / count, latitude.cos()));
        }
    }
    let mean = cells.iter().map(|(_, value, area)| value * area).sum::<f64>() / cells.iter().map(|(_, _, area)| area).sum::<f64>();
    let total_area: f64 = cells.iter().map(|(_, _, area)| area).sum();
    cells.into_iter().map(|(direction, value, area)| (direction, value / mean, area * 4.0 * PI / total_area)).collect()
}

/// The harmonics of a map: for each basis function the integral of map times function, over that of the function squared.
fn harmonics(cells: &[(DVec3, f64, f64)]) -> AlbedoHarmonics {
    let integral = |basis: &dyn Fn(DVec3) -> f64| {
        let (mut product, mut square) = (0.0, 0.0);
        for (direction, value, area) in cells {
            let f = basis(*direction);
            (product, square) = (product + f * value * area, square + f * f * area);
        }
        product / square
    };
    AlbedoHarmonics {
        degree_1: std::array::from_fn(|k| integral(&|n| AlbedoHarmonics::basis_of_degree_1(n)[k])),
        degree_2: std::array::from_fn(|k| integral(&|n| AlbedoHarmonics::basis_of_degree_2(n)[k])),
    }
}

/// The bodies with harmonics, and their maps: bodies whose published light curve the map repeats (many maps have more contrast than the body), and the Moon,
/// whose published albedo is that of one side.
fn bodies_with_sides(catalog: &Catalog) -> Vec<(&Body, AlbedoHarmonics, std::sync::Arc<Texture>)> {
    let store = MapStore::new(None);
    let of_body = |body| {
        let map: &Map = body_map(body)?;
        Some((body, map.harmonics?, store.get(&map.file, TexelFormat::Rgba8Srgb).expect("embedded")))
    };
    let bodies: Vec<_> = catalog.bodies().iter().filter_map(of_body).collect();
    assert!(!bodies.is_empty());
    bodies
}

fn body_map(body: &Body) -> Option<&Map> {
    body.maps.albedo.as_ref()
}

#[test]
fn the_catalogs_harmonics_are_those_of_the_maps() {
    let catalog = Catalog::embedded();
    let mut wrong = Vec::new();
    for (body, written, map) in bodies_with_sides(&catalog) {
        let expected = harmonics(&cells(&map));
        let differs = |a: &[f64], b: &[f64]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 2e-3);
        if differs(&written.degree_1, &expected.degree_1) || differs(&written.degree_2, &expected.degree_2) {
            let numbers: Vec<String> = expected.degree_1.iter().chain(&expected.degree_2).map(|c| format!("{c:.3}")).collect();
            wrong.push(format!("{}: harmonics = [{}]", body.name, numbers.join(", ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Brightness of a disc by a sum over the cells of its map, relative to that of a disc of the map's mean.
fn summed(body: &Body, cells: &[(DVec3, f64, f64)], sun: DVec3, viewer: DVec3) -> f64 {
    let (mut light, mut even) = (0.0, 0.0);
    for (normal, value, area) in cells {
        let (mu0, mu) = (normal.dot(sun), normal.dot(viewer));
        let weight = if mu0 > 0.0 && mu > 0.0 { reflectance(&body.photometry, mu0, mu, sun.dot(viewer)) * mu * area } else { 0.0 };
        (light, even) = (light + weight * value, even + weight);
    }
    light / even
}

/// Without harmonics a body is equally bright from all sides: as bright as the mean of its map, which its disc shows.
#[test]
fn a_map_without_harmonics_has_the_brightness_of_its_mean() {
    let shipped = Catalog::embedded().body(NaifId::MOON).expect("the Moon").clone();
    let mut moon = shipped.clone();
    let map = moon.maps.albedo.as_mut().expect("a map");
    (map.harmonics, map.relative_mean) = (None, 1.25);
    for (sun, viewer) in [(DVec3::X, DVec3::Y), (DVec3::X, DVec3::X), (DVec3::NEG_X, DVec3::NEG_X), (DVec3::Z, DVec3::Z)] {
        assert_eq!(light_curve(&moon, sun, viewer), 1.25, "lit from {sun}, seen from {viewer}");
    }
    // Negative control: with its harmonics the near side and the far side differ.
    let [near, far] = [DVec3::X, DVec3::NEG_X].map(|side| light_curve(&shipped, side, side));
    assert!((near - far).abs() > 0.3, "near side {near}, far side {far}");
}

/// At full phase and at phase angles of 30, 60 and 100 degrees, from all sides.
#[test]
fn the_light_curve_is_that_of_the_disc() {
    let catalog = Catalog::embedded();
    let mut largest = [0.0f64; 4];
    let mut without = 0.0f64;
    for (body, _, map) in bodies_with_sides(&catalog) {
        let (cells, relative_mean) = (cells(&map), body_map(body).expect("a map").relative_mean);
        let mut of_body = [0.0f64; 4];
        for (error, phase_deg) in of_body.iter_mut().zip([0.0, 30.0, 60.0, 100.0]) {
            for longitude_deg in (0..360).step_by(40) {
                for latitude_deg in [-50.0, 0.0, 20.0] {
                    let at = |longitude: f64, latitude: f64| {
                        let (longitude, latitude) = (longitude.to_radians(), latitude.to_radians());
                        DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin())
                    };
                    let viewer = at(f64::from(longitude_deg), latitude_deg);
                    let aside = DVec3::Z.cross(viewer).normalize();
                    let sun = viewer * f64::to_radians(phase_deg).cos() + aside * f64::to_radians(phase_deg).sin();
                    let (disc, curve) = (relative_mean * summed(body, &cells, sun, viewer), light_curve(body, sun, viewer));
                    *error = larger(*error, (curve / disc - 1.0).abs());
                    if phase_deg == 0.0 {
                        without = larger(without, (1.0 / disc - 1.0).abs());
                    }
                }
            }
        }
        println!("{}: {:.3?}", body.name, of_body);
        for (largest, of_body) in largest.iter_mut().zip(of_body) {
            *largest = larger(*largest, of_body);
        }
    }
    // The relative error is greatest on the dark side.
    let bounds = [0.13, 0.15, 0.25, 0.4];
    assert!(largest.iter().zip(bounds).all(|(error, bound)| *error < bound), "{largest:?}");
    assert!(without > 0.3, "without sides, the brightness would be wrong: {without}");
}

/// At the mean opposition: Iapetus has 10.2 mag at its western elongation from Saturn, where its bright trailing side is seen, and 11.9 at its eastern
/// elongation, where its dark leading side is seen (Morrison, Jones, Cruikshank & Murphy 1975, Icarus 24, 157).
#[test]
fn iapetus_has_its_published_magnitudes() {
    let catalog = Catalog::embedded();
    let iapetus = catalog.body(NaifId(608)).expect("Iapetus");
    let (sun_au, viewer_au) = (9.54, 8.54);
    let irradiance = iapetus.geometric_albedo * (iapetus.radii_km.x / (viewer_au * orrery::units::KM_PER_AU) / sun_au).powi(2);
    // The leading side faces the direction of the orbital motion, -y; Saturn is at longitude 0, +x.
    let of_side = |n: DVec3| magnitude(irradiance * light_curve(iapetus, n, n));
    let (leading, trailing) = (of_side(DVec3::NEG_Y), of_side(DVec3::Y));
    println!("leading {leading:.2}, trailing {trailing:.2}");
    assert!((trailing - 10.2).abs() < 0.2 && (leading - 11.9).abs() < 0.3, "trailing {trailing:.2}, leading {leading:.2}");
}

/// From the equator at full phase the brightness changes over a rotation by the published range, in magnitudes: Pluto 0.33 and Charon 0.08 (Buie, Tholen &
/// Wasserman 1997, Icarus 125, 233), Vesta 0.12 to 0.15, and Triton by less than 0.05 (as seen from the Earth before 1990; Voyager 2's images in green).
/// Pluto's north, in sunlight since 1987, is brighter than its equator. Negative control: without the harmonics there is no range.
#[test]
fn light_curves_have_their_published_ranges() {
    let catalog = Catalog::embedded();
    let range = |body: &Body| {
        let at = |degrees: i32| {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            light_curve(body, DVec3::new(cos, sin, 0.0), DVec3::new(cos, sin, 0.0))
        };
        let magnitudes: Vec<f64> = (0..360).step_by(10).map(|degrees| magnitude(at(degrees))).collect();
        magnitudes.iter().copied().fold(f64::NEG_INFINITY, larger) - magnitudes.iter().copied().fold(f64::INFINITY, smaller)
    };
    for (id, published) in [(999, 0.26..0.38), (901, 0.05..0.13), (2_000_004, 0.10..0.20), (801, 0.0..0.05)] {
        let body = catalog.body(NaifId(id)).expect("a body");
        let found = range(body);
        println!("{}: {found:.3}", body.name);
        assert!(published.contains(&found), "{}: {found}", body.name);
        let mut even = body.clone();
        even.maps.albedo.as_mut().expect("a map").harmonics = None;
        assert_eq!(range(&even), 0.0, "{}", body.name);
    }
    let pluto = catalog.body(NaifId(999)).expect("Pluto");
    let [north, equator] = [DVec3::Z, DVec3::X].map(|side| light_curve(pluto, side, side));
    assert!(north > 1.2 * equator, "{north} {equator}");
}
