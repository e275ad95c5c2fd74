//! The shipped maps: total size, resolution as stated, known features at their positions, colours as published, sources.

use orrery::catalog::{Catalog, InventedRelief, NaifId};
use orrery::image::{ImageError, MapDecoding, MapOrigin, MapStore, TexelFormat, Texture};

/// Mean over a square around a position (degrees), `half_deg` to each side. Longitude 0 is at the map's centre, and east to the right.
/// `decode` converts bytes.
fn mean_of(map: &Texture, lat_deg: f64, lon_deg: f64, half_deg: f64, decode: impl Fn(u8) -> f64) -> [f64; 3] {
    let level = &map.levels[0];
    let (w, h) = (f64::from(level.width), f64::from(level.height));
    let lon_deg = (lon_deg + 180.0).rem_euclid(360.0) - 180.0;
    let (x, y) = ((0.5 + lon_deg / 360.0) * w, (0.5 - lat_deg / 180.0) * h);
    let half_px = (half_deg / 180.0 * h).max(0.5);
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for row in (y - half_px) as i64..=(y + half_px) as i64 {
        for column in (x - half_px) as i64..=(x + half_px) as i64 {
            let row = row.clamp(0, i64::from(level.height) - 1);
            let at = (row * i64::from(level.width) + column.rem_euclid(i64::from(level.width))) as usize * 4;
            for (total, byte) in sum.iter_mut().zip(&level.bytes()[at..]) {
                *total += decode(*byte);
            }
            count += 1.0;
        }
    }
    sum.map(|s| s / count)
}

/// Mean linear colour of a colour map.
fn mean_colour(map: &Texture, lat_deg: f64, lon_deg: f64, half_deg: f64) -> [f64; 3] {
    mean_of(map, lat_deg, lon_deg, half_deg, |b| {
        let v = f64::from(b) / 255.0;
        if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    })
}

fn brightness(map: &Texture, lat_deg: f64, lon_deg: f64, half_deg: f64) -> f64 {
    mean_colour(map, lat_deg, lon_deg, half_deg).iter().sum::<f64>() / 3.0
}

/// Mean of a normal map's normals: the components to the east and to the north.
fn slope(map: &Texture, lat_deg: f64, lon_deg: f64, half_deg: f64) -> [f64; 2] {
    let [east, north, _] = mean_of(map, lat_deg, lon_deg, half_deg, |b| f64::from(b) / 127.5 - 1.0);
    [east, north]
}

fn map(name: &str) -> std::sync::Arc<Texture> {
    MapStore::new(None).get(name, TexelFormat::Rgba8Srgb).unwrap()
}

fn linear_map(name: &str) -> std::sync::Arc<Texture> {
    MapStore::new(None).get(name, TexelFormat::Rgba8Unorm).unwrap()
}

#[test]
fn all_maps_of_the_catalog_are_embedded_within_the_budget() {
    let store = MapStore::new(None);
    for b in Catalog::embedded().bodies() {
        for m in [&b.maps.albedo, &b.maps.normal, &b.maps.specular, &b.maps.night].into_iter().flatten() {
            assert_eq!(store.origin(&m.file), MapOrigin::Embedded, "{}: {}", b.name, m.file);
        }
    }
    // Widths in the catalog are those of the files. They determine where procedural detail begins.
    let mut stated_widths = 0;
    for b in Catalog::embedded().bodies() {
        let cloud_map = b.clouds.as_ref().map(|c| &c.map);
        for m in [&b.maps.albedo, &b.maps.normal].into_iter().flatten().chain(cloud_map) {
            let columns = store.get(&m.file, TexelFormat::Rgba8Srgb).expect("embedded").levels[0].width;
            stated_widths += u32::from(m.columns.is_some());
            assert!(m.columns.is_none_or(|stated| stated == columns), "{}: {:?} columns, the file has {columns}", m.file, m.columns);
            let has_detail = b.invented_relief != InventedRelief::None || Some(m) == cloud_map;
            assert!(m.columns.is_some() || columns == 512 || !has_detail, "{}: state its {columns} columns in the catalog", m.file);
        }
    }
    assert!(stated_widths >= 6, "{stated_widths}");
    let total: usize = MapStore::embedded().map(|(_, bytes)| bytes).sum();
    assert!(total <= 12_000_000, "{total} bytes");
}

/// The catalog's gain scales each map's mean over the sphere to colour times albedo; for the Moon, whose published albedo is that of its near side, times the
/// catalog's `relative_mean`.
#[test]
fn gains_bring_each_map_to_its_published_colour() {
    let mut maps = 0;
    let store = MapStore::new(None);
    for b in Catalog::embedded().bodies() {
        let Some(m) = &b.maps.albedo else { continue };
        maps += 1;
        let mean = store.get(&m.file, TexelFormat::Rgba8Srgb).unwrap().mean_over_sphere();
        let target = b.mean_reflectance();
        for c in 0..3 {
            let ratio = mean[c] * m.gain[c] / (target[c] * m.relative_mean);
            assert!((ratio - 1.0).abs() < 0.01, "{} channel {c}: {ratio}", m.file);
        }
    }
    assert!(maps > 8, "only {maps} bodies have a map");
    let mercury = Catalog::embedded().body(NaifId(199)).unwrap().clone();
    let raw = map("mercury.jpg").mean_over_sphere();
    assert!((raw[0] / mercury.mean_reflectance()[0] - 1.0).abs() > 0.1, "without its gain, the stylised raw map must fail this test");
}

/// The Moon's published albedo is measured from the Earth: at full phase its near side has it. A Lommel-Seeliger surface at full phase reflects in proportion
/// to its area as seen from the viewer.
#[test]
fn the_near_side_of_the_moon_has_its_published_albedo() {
    let catalog = Catalog::embedded();
    let body = catalog.body(NaifId::MOON).unwrap();
    let (moon, gain, target) = (map("moon.jpg"), body.maps.albedo.as_ref().unwrap().gain, body.mean_reflectance());
    // Brightness relative to the published albedo, by places 3 degrees apart on the side that faces a longitude.
    let relative = |facing_deg: f64| {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (row, column) in (0..60).flat_map(|row| (0..60).map(move |column| (row, column))) {
            let [latitude_deg, longitude_deg] = [row, column].map(|k| 3.0 * (f64::from(k) + 0.5) - 90.0);
            let weight = latitude_deg.to_radians().cos().powi(2) * longitude_deg.to_radians().cos();
            let colour = mean_colour(&moon, latitude_deg, facing_deg + longitude_deg, 0.5);
            (0..3).for_each(|c| sum[c] += weight * colour[c]);
            weights += weight;
        }
        [0, 1, 2].map(|c| sum[c] / weights * gain[c] / target[c])
    };
    let (near, far) = (relative(0.0), relative(180.0));
    println!("near side {near:.3?}, far side {far:.3?}");
    assert!(near.iter().all(|ratio| (ratio - 1.0).abs() < 0.02), "{near:?}");
    // The far side, which has no seas, must fail.
    assert!(far.iter().all(|ratio| *ratio > 1.4), "{far:?}");
}

/// Mean of a value at eight points on a circle around a position.
fn around(m: &Texture, lat_deg: f64, lon_deg: f64, radius_deg: f64, value: impl Fn(&Texture, f64, f64) -> f64) -> f64 {
    let ring = (0..8).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4);
    ring.map(|a| value(m, lat_deg + radius_deg * a.sin(), lon_deg + radius_deg * a.cos() / lat_deg.to_radians().cos())).sum::<f64>() / 8.0
}

/// Ratio of two colour channels in a square 3 degrees wide.
fn ratio(m: &Texture, lat_deg: f64, lon_deg: f64, channels: [usize; 2]) -> f64 {
    let c = mean_colour(m, lat_deg, lon_deg, 1.5);
    c[channels[0]] / c[channels[1]]
}

/// Asserts that a feature is at a position, and not where a mirrored or rotated map would show it.
fn assert_only_here(lat_deg: f64, lon_deg: f64, feature: &str, is_at: impl Fn(f64, f64) -> bool) {
    assert!(is_at(lat_deg, lon_deg), "{feature} is missing at {lat_deg} N, {lon_deg} E");
    for (y, x) in [(lat_deg, -lon_deg), (-lat_deg, lon_deg), (lat_deg, lon_deg + 180.0)] {
        assert!(!is_at(y, x), "{feature} is visible at {y} N, {x} E too");
    }
}

#[test]
fn the_moon_shows_tycho_and_mare_crisium() {
    let moon = map("moon.jpg");
    let bright = |m: &Texture, y, x| brightness(m, y, x, 1.5);
    assert_only_here(-43.3, 348.6, "Tycho", |y, x| brightness(&moon, y, x, 1.5) > 1.15 * around(&moon, y, x, 10.0, bright));
    assert_only_here(17.0, 59.1, "Mare Crisium", |y, x| brightness(&moon, y, x, 2.0) < 0.42 * around(&moon, y, x, 13.0, bright));
}

#[test]
fn mars_shows_olympus_mons_valles_marineris_and_syrtis_major() {
    let mars = map("mars.jpg");
    let bright = |m: &Texture, y, x| brightness(m, y, x, 1.0);
    // The dusty summit against the darker lava and aureole deposits 410 km away.
    assert_only_here(18.65, 226.2, "Olympus Mons", |y, x| brightness(&mars, y, x, 1.2) > 1.25 * around(&mars, y, x, 7.0, bright));
    // A trough from west to east, here over 8 degrees: its north wall slopes to the south, its south wall to the north.
    let normal = linear_map("mars_normal.jpg");
    assert_only_here(-13.0, 300.0, "Valles Marineris", |y, x| {
        let wall = |side: f64| (-4..=4).map(|k| slope(&normal, y + 1.5 * side, x + f64::from(k), 0.4)[1]).sum::<f64>() / 9.0;
        wall(1.0) - wall(-1.0) < -0.06
    });
    // Dark basalt is grey-brown, not blue (Bell et al. 1990: 0.10 to 0.15 in red, 0.04 to 0.06 in blue); dust is bright.
    let gain = Catalog::embedded().body(NaifId(499)).unwrap().maps.albedo.as_ref().unwrap().gain;
    let reflectance = |y, x| {
        let c = mean_colour(&mars, y, x, 2.0);
        [c[0] * gain[0], c[1] * gain[1], c[2] * gain[2]]
    };
    let (dark, bright) = (reflectance(8.0, 69.0), reflectance(20.0, 25.0));
    assert!((0.095..0.15).contains(&dark[0]) && (0.04..0.06).contains(&dark[2]), "Syrtis Major {dark:?}");
    assert!(bright[0] > 2.0 * dark[0] && bright[0] > 2.0 * bright[2], "Arabia {bright:?}");
}

/// The Great Red Spot drifts; in this map it is at 48 W of System III.
#[test]
fn jupiter_shows_the_great_red_spot_white_zones_and_brown_belts() {
    let jupiter = map("jupiter.jpg");
    let red = |m: &Texture, y, x| ratio(m, y, x, [0, 2]);
    assert_only_here(-21.0, 312.0, "the Great Red Spot", |y, x| red(&jupiter, y, x) > 1.5 * around(&jupiter, y, x, 20.0, red));
    let gain = Catalog::embedded().body(NaifId(599)).unwrap().maps.albedo.as_ref().unwrap().gain;
    let zonal = |y: f64| -> [f64; 3] {
        std::array::from_fn(|c| (0..72).map(|k| mean_colour(&jupiter, y, f64::from(k) * 5.0, 1.5)[c] * gain[c]).sum::<f64>() / 72.0)
    };
    let (zone, belt) = (zonal(3.0), zonal(13.0));
    // The zone is cream: as much red as green, slightly less blue. The belt is brown-orange: more red than green, and more green than blue.
    assert!((0.8..0.97).contains(&(zone[2] / zone[1])) && (zone[0] / zone[1] - 1.0).abs() < 0.06, "zone {zone:?}");
    assert!(belt[0] > 1.1 * belt[1] && belt[1] > 1.3 * belt[2] && belt[1] < 0.75 * zone[1], "belt {belt:?}");
}

#[test]
fn saturn_is_pale_gold_from_pole_to_pole() {
    let saturn = map("saturn.jpg");
    let gain = Catalog::embedded().body(NaifId(699)).unwrap().maps.albedo.as_ref().unwrap().gain;
    for lat_deg in [-80.0, -60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0] {
        let c = mean_colour(&saturn, lat_deg, 0.0, 2.0);
        let (r, b) = (c[0] * gain[0] / (c[1] * gain[1]), c[2] * gain[2] / (c[1] * gain[1]));
        assert!((1.12..1.28).contains(&r) && (0.62..0.8).contains(&b), "{lat_deg}: red {r}, blue {b} of green");
    }
}

/// The deposits around Pele's vent (18.7 S, 255.3 W), inside a ring of 600 km radius, are red.
#[test]
fn io_shows_pele() {
    let io = map("io.jpg");
    let red = |m: &Texture, y, x| ratio(m, y, x, [0, 1]);
    assert_only_here(-18.7, 104.7, "Pele", |y, x| around(&io, y, x, 13.0, red) > 1.08 * around(&io, y, x, 35.0, red));
}

#[test]
fn europa_callisto_iapetus_pluto_and_ceres_show_their_features() {
    let bright = |m: &Texture, y, x| brightness(m, y, x, 1.5);
    let europa = map("europa.jpg");
    assert!(brightness(&europa, -25.2, 88.6, 2.0) > 1.05 * around(&europa, -25.2, 88.6, 15.0, bright), "Pwyll");
    let callisto = map("callisto.jpg");
    assert_only_here(14.7, 304.0, "Valhalla", |y, x| brightness(&callisto, y, x, 3.0) > 1.3 * around(&callisto, y, x, 25.0, bright));
    // Cassini Regio covers the leading side around 90 W; poles and trailing side are bright.
    let iapetus = map("iapetus.jpg");
    let pole = brightness(&iapetus, 85.0, -90.0, 3.0);
    let is_dark = |x: f64| brightness(&iapetus, 0.0, x, 10.0) * 5.0 < brightness(&iapetus, 0.0, -x, 10.0).min(pole);
    assert!(is_dark(-90.0) && !is_dark(90.0));
    let pluto = map("pluto.jpg");
    let sputnik = |y: f64, x: f64| brightness(&pluto, y, x, 6.0) > 1.35 * around(&pluto, y, x, 35.0, bright);
    assert!(sputnik(25.0, 175.0) && !sputnik(-25.0, 175.0) && !sputnik(25.0, -5.0), "Sputnik Planitia");
    let ceres = map("ceres.jpg");
    assert_only_here(19.8, 239.3, "Occator", |y, x| brightness(&ceres, y, x, 0.5) > 3.0 * around(&ceres, y, x, 8.0, bright));
}

/// How much single texels differ from the four degrees around them: root mean square of their relative difference, within 12 degrees of a position.
fn roughness(m: &Texture, lat_deg: f64, lon_deg: f64) -> f64 {
    let difference = |(north, east): (i32, i32)| {
        let (lat_deg, lon_deg) = (lat_deg + f64::from(north), lon_deg + f64::from(east));
        brightness(m, lat_deg, lon_deg, 0.0) / brightness(m, lat_deg, lon_deg, 2.0) - 1.0
    };
    let places: Vec<_> = (-12..=12).flat_map(|north| (-12..=12).map(move |east| (north, east))).collect();
    (places.iter().map(|place| difference(*place).powi(2)).sum::<f64>() / places.len() as f64).sqrt()
}

/// The cells of Triton's cantaloupe terrain are in Bubembe Regio (18 N, 335 E), not in the smooth plains of Monad Regio (20 N, 37 E), nor on the side that no
/// spacecraft has seen well.
#[test]
fn triton_has_its_cells_in_bubembe_regio() {
    let triton = map("triton.jpg");
    let in_bubembe = roughness(&triton, 18.0, 335.0);
    assert!(in_bubembe > 0.015, "{in_bubembe}");
    for lon_deg in [40.0, 95.0, 155.0, 180.0, 215.0, 265.0] {
        let elsewhere = roughness(&triton, 20.0, lon_deg);
        assert!(elsewhere < 0.012, "{elsewhere} at {lon_deg} E");
    }
}

#[test]
fn the_earth_has_its_continents() {
    let (water, earth) = (linear_map("earth_water.jpg"), map("earth_day.jpg"));
    let is_water = |lat_deg, lon_deg| brightness(&water, lat_deg, lon_deg, 2.0) > 0.5;
    // The Congo and Brazil are land, and the Atlantic between them is water. A mirrored map has water where the Congo is.
    assert!(!is_water(0.0, 22.0) && !is_water(-10.0, -50.0) && is_water(-10.0, -25.0) && is_water(0.0, 0.0));
    assert!(is_water(0.0, -22.0) && is_water(10.0, -22.0) && is_water(0.0, -158.0));
    assert!(
        brightness(&earth, 23.0, 10.0, 3.0) > 5.0 * brightness(&earth, 23.0, -40.0, 3.0),
        "the Sahara against the Atlantic to its west"
    );
}

/// Lakes, shallow and silty water are dark, too.
#[test]
fn the_albedo_of_water_is_below_a_tenth_everywhere() {
    let (water, earth) = (linear_map("earth_water.jpg"), map("earth_day.jpg"));
    let gain = Catalog::embedded().body(NaifId::EARTH).unwrap().maps.albedo.as_ref().unwrap().gain;
    // Lake Victoria, the north of the Caspian, the Persian Gulf, the Sea of Azov, the mouth of the Amazon.
    for (lat_deg, lon_deg) in [(-1.0, 33.0), (45.5, 49.5), (27.0, 51.5), (46.0, 36.5), (2.0, -49.5)] {
        let c = mean_colour(&earth, lat_deg, lon_deg, 0.3);
        let brightest = (0..3).map(|k| c[k] * gain[k]).fold(0.0, f64::max);
        assert!(brightest < 0.1, "{lat_deg}, {lon_deg}: {brightest}");
    }
    let (mut brightest_water, mut places): (f64, u32) = (0.0, 0);
    for lat_deg in -60..=60 {
        for lon_deg in (-180..180).filter(|lon_deg| brightness(&water, f64::from(lat_deg), f64::from(*lon_deg), 0.3) > 0.9) {
            let c = mean_colour(&earth, f64::from(lat_deg), f64::from(lon_deg), 0.1);
            // Skips sea ice, which is white.
            if c[2] > 1.3 * c[0] {
                brightest_water = brightest_water.max(c[1] * gain[1]);
                places += 1;
            }
        }
    }
    assert!(brightest_water < 0.1 && places > 1000, "{brightest_water} at {places} places");
    // Negative control: the Sahara.
    assert!(mean_colour(&earth, 23.0, 10.0, 0.3)[1] * gain[1] > 0.1);
}

/// Each map has a row in the list of sources. Maps made for this program, and maps whose source is partly invented, are declared as
/// invented in the catalog.
#[test]
fn every_map_has_its_source_and_invented_maps_are_declared() {
    let readme = include_str!("../../textures/README.md");
    let row_of = |file: &str| {
        let stem = file.trim_end_matches(".jpg");
        let names = |row: &str| row.split('|').nth(1).is_some_and(|c| c.split([',', ' ']).any(|n| n == file || n == stem));
        readme.lines().filter(|l| l.starts_with('|')).find(|row| names(row))
    };
    let mut made_for_this_program = 0;
    for b in Catalog::embedded().bodies() {
        let maps = [&b.maps.albedo, &b.maps.normal, &b.maps.specular, &b.maps.night].into_iter().flatten();
        for m in maps.chain(b.clouds.as_ref().map(|c| &c.map)) {
            let row = row_of(&m.file).unwrap_or_else(|| panic!("{} has no row in textures/README.md", m.file));
            let made_here = row.contains("made here");
            let is_partly_invented = ["ariel", "miranda", "oberon", "titania", "umbriel"].iter().any(|n| m.file.starts_with(n));
            assert_eq!(made_here || is_partly_invented, m.invented.is_some(), "{}: {row}", m.file);
            assert!(m.invented.as_ref().is_none_or(|how| how.len() > 20), "{}: state what is invented, and how", m.file);
            made_for_this_program += i32::from(made_here);
        }
    }
    assert_eq!(made_for_this_program, 4, "Callisto, Iapetus, Triton, Phobos");
    assert!(row_of("vulcan.jpg").is_none());
}

/// Craters of the Moon: name, latitude, longitude and radius in degrees, from the IAU gazetteer.
const LUNAR_CRATERS: [(&str, f64, f64, f64); 7] = [
    ("Copernicus", 9.62, 339.92, 1.58),
    ("Tycho", -43.3, 348.79, 1.41),
    ("Langrenus", -8.86, 61.04, 2.18),
    ("Plato", 51.62, 350.62, 1.66),
    ("Clavius", -58.62, 345.27, 3.81),
    ("Ptolemaeus", -9.16, 358.16, 2.53),
    ("Theophilus", -11.45, 26.29, 1.63),
];

/// Mean over a circle around a position of what `value` returns for a place and for the azimuth (from east to north) in which it lies.
fn mean_on_circle(lat_deg: f64, lon_deg: f64, radius_deg: f64, value: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let ring = (0..64).map(|k| f64::from(k) * std::f64::consts::PI / 32.0);
    ring.map(|a| value(lat_deg + radius_deg * a.sin(), lon_deg + radius_deg * a.cos() / lat_deg.to_radians().cos(), a)).sum::<f64>() / 64.0
}

/// The ground slopes inwards inside a crater's rim and outwards outside it, so both channels of the normal map have the right sign and
/// position.
#[test]
fn craters_have_raised_rims_in_both_channels_of_the_normal_map() {
    let normal = linear_map("moon_normal.jpg");
    // Outward slope outside the rim minus that inside it, by one channel alone: 0 is east, 1 is north.
    let rim_slope = |axis: usize, lat_deg: f64, lon_deg: f64, radius_deg: f64| {
        let outward_slope = |distance_deg: f64| {
            mean_on_circle(lat_deg, lon_deg, distance_deg, |y, x, a| slope(&normal, y, x, 0.25)[axis] * [a.cos(), a.sin()][axis])
        };
        outward_slope(1.25 * radius_deg) - outward_slope(0.85 * radius_deg)
    };
    for (name, y, x, r) in LUNAR_CRATERS {
        for axis in [0, 1] {
            let [unflipped, mirrored, upside_down] = [(y, x), (y, -x), (-y, x)].map(|(y, x)| rim_slope(axis, y, x, r));
            println!("{name}, axis {axis}: {unflipped:.3}; {mirrored:.3} and {upside_down:.3}");
            assert!(unflipped > 0.09, "{name}, axis {axis}: {unflipped}; an inverted channel gives the negative");
            assert!(mirrored < 0.06 && upside_down < 0.06, "{name}, axis {axis}: {mirrored} and {upside_down} where no crater is");
        }
    }
}

/// Slopes are those of the ground: summed up from the centre to the rim of young craters they give 0.7 to 1.1 of the depth of fresh craters, 1.044 D^0.301 km
/// (Pike 1977); Plato and Ptolemaeus, which lava has filled, have less than half of it.
#[test]
fn lunar_craters_are_as_deep_as_published() {
    let moon = Catalog::embedded().body(NaifId::MOON).expect("the Moon").clone();
    let drawn = moon.maps.normal.expect("a map of normals");
    let map = linear_map(&drawn.file);
    let km_per_deg = moon.radii_km.x.to_radians();
    // From the lowest ground inside to the rim.
    let depth_km = |lat_deg: f64, lon_deg: f64, radius_deg: f64| {
        let step_deg = 1.3 * radius_deg / 60.0;
        let (mut height_km, mut lowest_km, mut highest_km) = (0.0, 0.0_f64, 0.0_f64);
        for k in 0..60 {
            let rise = mean_on_circle(lat_deg, lon_deg, (f64::from(k) + 0.5) * step_deg, |y, x, a| {
                let [east, north, up] = mean_of(&map, y, x, 0.0, |b| f64::from(b) / 127.5 - 1.0);
                // As `tilted_normal` of shaders/lib/relief.wesl. The normal leans away from rising ground.
                -drawn.gain[0] * (east * a.cos() + north * a.sin()) / up.max(0.05)
            });
            height_km += rise * step_deg * km_per_deg;
            lowest_km = lowest_km.min(height_km);
            highest_km = highest_km.max(height_km);
        }
        highest_km - lowest_km
    };
    let part_of_fresh = |name: &str, flip_lon: f64| {
        let (_, y, x, r) = LUNAR_CRATERS.into_iter().find(|crater| crater.0 == name).expect("listed");
        depth_km(y, flip_lon * x, r) / (1.044 * (2.0 * r * km_per_deg).powf(0.301))
    };
    for name in ["Copernicus", "Tycho", "Langrenus", "Theophilus"] {
        let (part, mirrored) = (part_of_fresh(name, 1.0), part_of_fresh(name, -1.0));
        println!("{name}: {part:.2}, mirrored {mirrored:.2}");
        assert!((0.7..1.1).contains(&part), "{name}: {part}");
        assert!(mirrored < 0.6, "{name}: {mirrored} where a mirrored map would have it");
    }
    for name in ["Plato", "Ptolemaeus"] {
        let part = part_of_fresh(name, 1.0);
        assert!(part < 0.5, "{name}: {part}");
    }
}

/// Highlands are rough and seas level: median slopes over some 5 km of 2 to 5 and of less than 0.6 degrees. LOLA's medians, from memory: 7.5 and 2 degrees over
/// 17 m, less over longer distances (Rosenburg et al. 2011). Neither JPEG nor the steps of the map of heights roughen the seas: there noise of 0.3 degrees would be
/// visible where the Sun is low.
#[test]
fn the_highlands_of_the_moon_are_rough_and_its_seas_level() {
    let catalog = Catalog::embedded();
    let drawn = catalog.body(NaifId::MOON).and_then(|moon| moon.maps.normal.as_ref()).expect("a map of normals");
    let map = linear_map(&drawn.file);
    let median_slope_deg = |lat_deg: std::ops::Range<i32>, lon_deg: std::ops::Range<i32>| {
        let places = lat_deg.flat_map(|y| lon_deg.clone().map(move |x| (f64::from(y), f64::from(x))));
        let mut slopes: Vec<f64> = places
            .flat_map(|(y, x)| [(0.0, 0.0), (0.25, 0.5), (0.5, 0.25), (0.75, 0.75)].map(|(north, east)| (y + north, x + east)))
            .map(|(y, x)| {
                let [east, north, up] = mean_of(&map, y, x, 0.0, |b| f64::from(b) / 127.5 - 1.0);
                (drawn.gain[0] * east.hypot(north) / up.max(0.05)).atan().to_degrees()
            })
            .collect();
        slopes.sort_by(f64::total_cmp);
        slopes[slopes.len() / 2]
    };
    for (name, lat_deg, lon_deg, expected) in [
        ("far side", 0..30, 150..180, 2.5..5.0),
        ("southern highlands", -50..-20, 0..30, 2.0..4.5),
        ("Mare Imbrium", 28..42, -25..-10, 0.0..0.3),
        ("Mare Serenitatis", 22..32, 13..24, 0.0..0.3),
        ("Oceanus Procellarum", 15..25, -58..-50, 0.0..0.6),
    ] {
        let median_deg = median_slope_deg(lat_deg, lon_deg);
        println!("{name}: {median_deg:.2} degrees");
        assert!(expected.contains(&median_deg), "{name}: {median_deg} degrees");
    }
}

#[test]
fn maps_in_the_users_folder_take_precedence_and_missing_maps_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    orrery::image::write_png(&mut bytes, 2, 1, &[[9, 8, 7, 255]; 2], &[]).unwrap();
    std::fs::write(folder.path().join("mars.jpg"), &bytes).unwrap();
    std::fs::write(folder.path().join("moon.jpg"), b"no image").unwrap();
    let store = MapStore::new(Some(folder.path().to_owned()));
    assert_eq!(store.get("mars.jpg", TexelFormat::Rgba8Srgb).unwrap().levels[0].bytes()[..4], [9, 8, 7, 255]);
    assert!(matches!(store.get("moon.jpg", TexelFormat::Rgba8Srgb), Err(ImageError::Unreadable { .. })));
    let missing = store.get("vulcan.jpg", TexelFormat::Rgba8Srgb).unwrap_err().to_string();
    assert!(missing.contains("vulcan.jpg") && missing.contains("--textures") && !missing.contains('\n'), "{missing}");
    std::fs::write(folder.path().join("own.jpg"), &bytes).unwrap();
    let colour = MapDecoding::plain(TexelFormat::Rgba8Srgb);
    store.prefetch(&[("own.jpg", colour), ("vulcan.jpg", colour)]);
    std::fs::remove_file(folder.path().join("own.jpg")).unwrap();
    assert!(store.get("own.jpg", TexelFormat::Rgba8Srgb).is_ok(), "it was loaded before its file was removed");
    assert!(store.get("vulcan.jpg", TexelFormat::Rgba8Srgb).is_err());
}

/// The slope that the light meter assumes on ground without air is that of the Moon's map of normals, drawn with its gain: the root mean square of the
/// components to the east and to the north, within 60 degrees of the equator, within 10 %.
#[test]
fn the_light_meter_knows_the_slopes_of_the_moon() {
    let catalog = Catalog::embedded();
    let drawn = catalog.body(NaifId::MOON).and_then(|moon| moon.maps.normal.as_ref()).expect("a map of normals");
    let map = linear_map(&drawn.file);
    let level = &map.levels[0];
    let (width, height) = (level.width as usize, level.height as usize);
    let (mut sum, mut weights) = (0.0, 0.0);
    for row in height / 6..height - height / 6 {
        let cos_latitude = (std::f64::consts::PI * ((row as f64 + 0.5) / height as f64 - 0.5)).cos();
        for texel in level.bytes()[row * width * 4..(row + 1) * width * 4].chunks_exact(4) {
            let [east, north, up] = [0, 1, 2].map(|c| f64::from(texel[c]) / 127.5 - 1.0);
            // As `tilted_normal` of shaders/lib/relief.wesl.
            let [east, north] = [east, north].map(|slope| drawn.gain[0] * slope / up.max(0.05));
            sum += 0.5 * cos_latitude * (east * east + north * north);
            weights += cos_latitude;
        }
    }
    let rms = (sum / weights).sqrt();
    let expected = orrery::scene::RELIEF_SLOPE_RMS;
    assert!(
        (rms / expected - 1.0).abs() < 0.1,
        "RELIEF_SLOPE_RMS of src/scene/light/meter/ground.rs is {expected}, that of the map is {rms:.3}"
    );
}
