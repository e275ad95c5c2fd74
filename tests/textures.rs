//! The maps that ship: within the budget, each where the catalog says, oriented by known places, coloured as published.

use orrery::catalog::{Catalog, NaifId};
use orrery::image::{ImageError, MapOrigin, MapStore, TexelFormat, Texture};

/// Mean linear brightness in a square of `half` degrees around a place, longitude 0 at the map's centre and east to the right.
fn brightness(map: &Texture, lat: f64, lon: f64, half: f64) -> f64 {
    let level = &map.levels[0];
    let (w, h) = (f64::from(level.width), f64::from(level.height));
    let lon = if lon > 180.0 { lon - 360.0 } else { lon };
    let (x, y) = ((0.5 + lon / 360.0) * w, (0.5 - lat / 180.0) * h);
    let reach = (half / 180.0 * h).max(0.5);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in (y - reach) as i64..=(y + reach) as i64 {
        for column in (x - reach) as i64..=(x + reach) as i64 {
            let row = row.clamp(0, i64::from(level.height) - 1);
            let at = (row * i64::from(level.width) + column.rem_euclid(i64::from(level.width))) as usize * 4;
            sum += level.bytes[at..at + 3].iter().map(|&b| (f64::from(b) / 255.0).powf(2.2)).sum::<f64>() / 3.0;
            count += 1.0;
        }
    }
    sum / count
}

fn map(name: &str) -> std::sync::Arc<Texture> {
    MapStore::new(None).get(name, TexelFormat::Rgba8Srgb).unwrap()
}

#[test]
fn all_maps_of_the_catalog_are_embedded_within_the_budget() {
    let store = MapStore::new(None);
    for b in Catalog::embedded().bodies() {
        for m in [&b.maps.albedo, &b.maps.normal, &b.maps.specular, &b.maps.night].into_iter().flatten() {
            assert_eq!(store.origin(&m.file), MapOrigin::Embedded, "{}: {}", b.name, m.file);
        }
    }
    let total: usize = MapStore::embedded().map(|(_, bytes)| bytes).sum();
    assert!(total <= 12_000_000, "{total} bytes");
}

/// The catalog's gain brings each map's mean over the sphere to colour times albedo.
#[test]
fn gains_bring_each_map_to_its_published_colour() {
    let store = MapStore::new(None);
    for b in Catalog::embedded().bodies() {
        let Some(m) = &b.maps.albedo else { continue };
        let mean = store.get(&m.file, TexelFormat::Rgba8Srgb).unwrap().mean_over_sphere();
        let target = b.map_target();
        for c in 0..3 {
            let ratio = mean[c] * m.gain[c] / target[c];
            assert!((ratio - 1.0).abs() < 0.01, "{} channel {c}: {ratio}", m.file);
        }
    }
    let mars = Catalog::embedded().body(NaifId(499)).unwrap().clone();
    let raw = map("mars.jpg").mean_over_sphere();
    assert!((raw[0] / mars.map_target()[0] - 1.0).abs() > 0.1, "the raw map is stylised: without its gain this test must fail");
}

/// Places of the IAU gazetteer that stand out against their surroundings; the mirrored map fails.
#[test]
fn maps_are_turned_the_right_way() {
    let around = |m: &Texture, lat: f64, lon: f64, r: f64| {
        (0..8)
            .map(|k| {
                let a = f64::from(k) * std::f64::consts::FRAC_PI_4;
                brightness(m, lat + r * a.sin(), lon + r * a.cos(), 1.5)
            })
            .sum::<f64>()
            / 8.0
    };
    let moon = map("moon.jpg");
    // Tycho's rays shine, Mare Crisium (17.0 N, 59.1 E) is dark.
    assert!(brightness(&moon, -43.3, 348.8, 1.5) > 1.15 * around(&moon, -43.3, 348.8, 12.0));
    assert!(brightness(&moon, 17.0, 59.1, 2.0) < 0.7 * around(&moon, 17.0, 59.1, 13.0));
    assert!(brightness(&moon, -43.3, 11.2, 1.5) < 1.15 * around(&moon, -43.3, 11.2, 12.0));
    // Europa's Pwyll (25.2 S, 88.6 E) is bright.
    let europa = map("europa.jpg");
    assert!(brightness(&europa, -25.2, 88.6, 2.0) > 1.05 * around(&europa, -25.2, 88.6, 15.0));
    // Earth: the Sahara against the Atlantic to its west; the Pacific is dark.
    let earth = map("earth_day.jpg");
    assert!(brightness(&earth, 23.0, 10.0, 3.0) > 5.0 * brightness(&earth, 23.0, -40.0, 3.0));
    // Iapetus: dark about 90 W, bright about 90 E and at the poles. Callisto: Valhalla's bright centre.
    let iapetus = map("iapetus.jpg");
    assert!(
        brightness(&iapetus, 0.0, -90.0, 10.0) * 5.0 < brightness(&iapetus, 0.0, 90.0, 10.0).min(brightness(&iapetus, 85.0, -90.0, 3.0))
    );
    let callisto = map("callisto.jpg");
    assert!(brightness(&callisto, 14.7, 304.0, 3.0) > 1.3 * around(&callisto, 14.7, 304.0, 25.0));
}

#[test]
fn a_folder_comes_first_and_a_missing_map_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    orrery::image::write_png(&mut bytes, 2, 1, &[[9, 8, 7, 255]; 2], &[]).unwrap();
    std::fs::write(folder.path().join("mars.jpg"), &bytes).unwrap();
    std::fs::write(folder.path().join("moon.jpg"), b"no picture").unwrap();
    let store = MapStore::new(Some(folder.path().to_owned()));
    assert_eq!(store.get("mars.jpg", TexelFormat::Rgba8Srgb).unwrap().levels[0].bytes[..4], [9, 8, 7, 255]);
    assert!(matches!(store.get("moon.jpg", TexelFormat::Rgba8Srgb), Err(ImageError::Unreadable { .. })));
    let missing = store.get("vulcan.jpg", TexelFormat::Rgba8Srgb).unwrap_err().to_string();
    assert!(missing.contains("vulcan.jpg") && missing.contains("--textures") && !missing.contains('\n'), "{missing}");
    let both = store.get_all(&[("mars.jpg", TexelFormat::Rgba8Srgb), ("vulcan.jpg", TexelFormat::Rgba8Srgb)]);
    assert!(both[0].is_ok() && both[1].is_err());
}
