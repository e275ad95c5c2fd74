//! Creates textures/ from a folder of source maps: `cargo run --release --features bake --example bake_textures -- SOURCE [OUT]`.
//!
//! In: SOURCE/textures and SOURCE/catalogs/nomenclature_usgs.csv, which textures/README.md names and credits. Out: the files of textures/,
//! and on standard output each colour map's gain for the catalog. The only randomness is a fixed hash, so the same sources give the same
//! files.

use image::{GrayImage, Luma, Rgb, RgbImage, imageops::FilterType};
use lunar::moon_heights;
use orrery::catalog::Catalog;
use orrery::image::{TexelFormat, Texture};
use orrery::units::{linear_to_srgb, luminance, srgb_to_linear};
use painted::{callisto, iapetus, phobos, triton};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;

mod heights;
mod lunar;
mod painted;

/// (source under textures/, our name): maps that are copied unchanged.
const COPIED: &[(&str, &str)] = &[
    ("moon_4096.jpg", "moon.jpg"),
    ("sss_mercurymap.jpg", "mercury.jpg"),
    ("sss_earthspec2k.jpg", "earth_water.jpg"),
    ("sss_earthcloudmapspec.jpg", "earth_clouds.jpg"),
];

/// Bodies whose map, 512 texels wide, is copied unchanged.
const SMALL_MAPS: &[&str] = &[
    "ariel",
    "charon",
    "deimos",
    "dione",
    "enceladus",
    "epimetheus",
    "europa",
    "hyperion",
    "mimas",
    "miranda",
    "rhea",
    "tethys",
    "titania",
    "umbriel",
    "vesta",
];

/// (source under textures/, our name, saturation): maps in enhanced colours, of which only this part of the differences in hue is kept.
const MUTED: &[(&str, &str, f64)] = &[
    // Grey and faintly reddish, hues within some percent (Dawn); the source has blue and green ground.
    ("moons/ceres_512.jpg", "ceres.jpg", 0.2),
    // Grey-brown ground, whiter rays and poles (Galileo, natural colour); the source has olive plains and pink poles.
    ("moons/ganymede_512.jpg", "ganymede.jpg", 0.5),
];

/// Size of the flattened and the painted maps, texels.
const WIDTH: u32 = 1024;
const HEIGHT: u32 = 512;

/// The brightest cities of the source have a fifth of white, in linear light.
const CITY_LIGHTS_SCALE: f64 = 5.0;

type Colour = [f64; 3];

/// Parameters for converting a stylised map to published colours. With one gain per channel its exaggerated hues would come out wrong: where
/// the map is less red than its mean, the result would be blue. So only the brightness and the order of hues are kept.
struct Recolouring {
    /// File below the source's textures/.
    source_file: &'static str,
    /// File name in textures/.
    output_file: &'static str,
    /// Relative reflectances (red, green, blue) of the map's reddest and bluest ground.
    warm: Colour,
    cool: Colour,
    /// Quantiles of the map's ln(blue/red) over the sphere that become `warm` and `cool`.
    span: [f64; 2],
    /// Exponent applied to the map's brightness relative to its mean.
    contrast: f64,
    /// Fraction kept of the variation of red/green that is uncorrelated with blue/red, such as the red rings on Io.
    red_kept: f64,
    /// Colour of ground that is bright and white in the map; `None`: no ice.
    ice: Option<Colour>,
    /// Whether only the mean of each parallel is kept, smoothed over latitudes ([`zonal`]).
    is_zonal: bool,
}

/// A recolouring without red kept, ice or smoothing. Each map replaces the other fields.
const PLAIN: Recolouring = Recolouring {
    source_file: "",
    output_file: "",
    warm: [1.0; 3],
    cool: [1.0; 3],
    span: [0.0, 1.0],
    contrast: 1.0,
    red_kept: 0.0,
    ice: None,
    is_zonal: false,
};

/// Standard deviation of the latitudes over which zonal maps are smoothed.
const ZONAL_SMOOTHING_DEG: f64 = 12.0;

const RECOLOURED: [Recolouring; 8] = [
    // Bright dust and dark basalt, Bell et al. 1990 and Mustard & Bell 1994. With the mean of Mallama 2017, Syrtis Major gets 0.10 in red
    // and 0.047 in blue. Water ice at the poles.
    Recolouring {
        source_file: "sss_marsmap2k.jpg",
        output_file: "mars.jpg",
        warm: [0.32, 0.20, 0.095],
        cool: [0.125, 0.09, 0.054],
        span: [0.3, 0.97],
        contrast: 0.62,
        ice: Some([1.0, 0.97, 0.9]),
        ..PLAIN
    },
    // Brown-orange belts, cream white zones.
    Recolouring {
        source_file: "sss_jupitermap.jpg",
        output_file: "jupiter.jpg",
        warm: [1.5, 1.0, 0.5],
        cool: [1.02, 1.0, 0.89],
        span: [0.01, 0.6],
        contrast: 0.75,
        ..PLAIN
    },
    // Pale gold from pole to pole.
    Recolouring {
        source_file: "sss_saturnmap.jpg",
        output_file: "saturn.jpg",
        warm: [1.2, 1.0, 0.69],
        cool: [1.19, 1.0, 0.73],
        span: [0.05, 0.95],
        contrast: 0.7,
        ..PLAIN
    },
    // Pale yellow plains, orange-brown poles, Pele's red ring.
    Recolouring {
        source_file: "moons/io_512.jpg",
        output_file: "io.jpg",
        warm: [1.4, 1.0, 0.40],
        cool: [1.1, 1.0, 0.76],
        span: [0.03, 0.97],
        contrast: 0.5,
        red_kept: 0.6,
        ..PLAIN
    },
    // Nearly uniform cream: the markings of the source are from ultraviolet images and faint to the eye.
    Recolouring {
        source_file: "moons/venus_512.jpg",
        output_file: "venus_clouds.jpg",
        warm: [1.06, 1.0, 0.85],
        cool: [1.02, 1.0, 0.9],
        span: [0.05, 0.95],
        contrast: 0.25,
        ..PLAIN
    },
    // Dark red-brown along the equator, pale elsewhere (New Horizons: Olkin et al. 2017).
    Recolouring {
        source_file: "moons/pluto_512.jpg",
        output_file: "pluto.jpg",
        warm: [1.7, 1.0, 0.55],
        cool: [1.1, 1.0, 0.86],
        span: [0.05, 0.7],
        contrast: 0.6,
        ..PLAIN
    },
    // Haze without bands or spirals, which belong to images in the near infrared. The southern half is brighter, most in blue, as in Cassini's first years
    // (after published descriptions); in nature this changes with the season.
    Recolouring {
        source_file: "moons/titan_512.jpg",
        output_file: "titan.jpg",
        warm: [1.23, 1.0, 0.61],
        cool: [1.15, 1.0, 0.70],
        span: [0.02, 0.98],
        contrast: 0.4,
        is_zonal: true,
        ..PLAIN
    },
    // Grey, faintly reddish (Voyager 2); the source is pink, so that with a gain per channel bright rays came out cyan.
    Recolouring {
        source_file: "moons/oberon_512.jpg",
        output_file: "oberon.jpg",
        warm: [1.06, 1.0, 0.94],
        cool: [1.0, 1.0, 0.99],
        span: [0.05, 0.95],
        contrast: 0.8,
        ..PLAIN
    },
];

/// A feature of the gazetteer.
struct Feature {
    lat_deg: f64,
    /// Positive east, -180 to 180.
    lon_deg: f64,
    diameter_km: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().ok_or("usage: bake_textures SOURCE [OUT]")?;
    let out = arguments.next().unwrap_or_else(|| "textures".into());
    let (source, out) = (Path::new(&source), Path::new(&out));
    std::fs::create_dir_all(out)?;
    for (from, to) in COPIED {
        std::fs::copy(source.join("textures").join(from), out.join(to))?;
    }
    for name in SMALL_MAPS {
        std::fs::copy(source.join(format!("textures/moons/{name}_512.jpg")), out.join(format!("{name}.jpg")))?;
    }
    let open = |name: &str| image::open(source.join("textures").join(name)).map(|i| i.into_rgb8());
    // Of these stylised maps only the brightness pattern is kept, at about the contrast that the eye would see; the catalog's gain gives the
    // colour.
    // The source of Janus is a relief that is shaded strongly; the moon is about equally bright everywhere.
    for (from, to, contrast) in [
        ("sss_uranusmap.jpg", "uranus.jpg", 0.15),
        ("sss_neptunemap.jpg", "neptune.jpg", 0.15),
        ("sss_sunmap.jpg", "sun.jpg", 0.04),
        ("moons/janus_512.jpg", "janus.jpg", 0.4),
    ] {
        save(&flatten(&open(from)?, contrast), &out.join(to))?;
    }
    for (from, to, saturation) in MUTED {
        save(&muted(&open(from)?, *saturation), &out.join(to))?;
    }
    // Not as JPEG: at the exposures of nights its noise beside lights shows.
    city_lights(&open("earth_night_4096.jpg")?).save(out.join("earth_night.png"))?;
    let catalog = Catalog::embedded();
    for recolouring in &RECOLOURED {
        let body = catalog
            .bodies()
            .iter()
            .find(|b| b.maps.albedo.as_ref().is_some_and(|m| m.file == recolouring.output_file))
            .ok_or("no body has this map")?;
        let map = open(recolouring.source_file)?;
        let map = if recolouring.is_zonal { zonal(&map) } else { map };
        save(&recolour(&map, recolouring, body.mean_reflectance()), &out.join(recolouring.output_file))?;
    }
    save(&natural_water(&open("earth_day_flatocean_2048.jpg")?), &out.join("earth_day.jpg"))?;
    // A grey level of this map is 25 m of height.
    let elevation = image::imageops::resize(&open("earth_elevation_2048_u8.png")?, 2048, 1024, FilterType::Triangle);
    let metres = |x: u32, y: u32| f64::from(elevation.get_pixel(x, y)[0]) * 25.0;
    // Mean radius in metres, and exaggeration of the slopes, chosen so that relief shows from space.
    save(&normals_from_elevation(elevation.dimensions(), metres, 6_371_000.0, 12.0), &out.join("earth_normal.jpg"))?;
    let mola = image::open(source.join("textures/mars_elevation_1440x720_u16.png"))?.into_luma16();
    let metres = |x: u32, y: u32| f64::from(mola.get_pixel(x, y)[0]);
    save(&normals_from_elevation(mola.dimensions(), metres, 3_389_500.0, 8.0), &out.join("mars_normal.jpg"))?;
    let gazetteer = std::fs::read_to_string(source.join("catalogs/nomenclature_usgs.csv"))?;
    let craters = |body: &str| features(&gazetteer, body, "AA");
    let rings = features(&gazetteer, "Callisto", "LG");
    let moon = moon_heights(&image::open(source.join("textures/moon_elevation_1024_u8.jpg"))?.into_luma8(), &craters("Moon"));
    let metres = |x: u32, y: u32| moon.at(i64::from(x), i64::from(y));
    // Exaggerated, because the steps of 8-bit normals would show in the level seas; the catalog's gain takes it back.
    let normals = normals_from_elevation((moon.width as u32, moon.height as u32), metres, 1000.0 * lunar::RADIUS_KM, 4.0);
    // Half as fine: in a JPEG of the same size its blocks would show where the Sun is low.
    save_with_quality(&image::imageops::thumbnail(&normals, 2048, 1024), &out.join("moon_normal.jpg"), 92)?;
    save(&callisto(&craters("Callisto"), &rings), &out.join("callisto.jpg"))?;
    save(&iapetus(&craters("Iapetus")), &out.join("iapetus.jpg"))?;
    save(&triton(), &out.join("triton.jpg"))?;
    save(&phobos(&craters("Phobos")), &out.join("phobos.jpg"))?;
    for body in catalog.bodies() {
        if let Some(map) = &body.maps.albedo {
            let texture = Texture::decode(&map.file, &std::fs::read(out.join(&map.file))?, TexelFormat::Rgba8Srgb)?;
            let mean = texture.mean_over_sphere();
            let target = body.mean_reflectance().map(|channel| channel * map.relative_mean);
            let gain: Vec<String> = (0..3).map(|c| format!("{:.4}", target[c] / mean[c])).collect();
            println!("{} gain = [{}]", map.file, gain.join(", "));
        }
    }
    Ok(())
}

fn save(map: &RgbImage, path: &Path) -> Result<(), Box<dyn Error>> {
    save_with_quality(map, path, 90)
}

fn save_with_quality(map: &RgbImage, path: &Path, quality: u8) -> Result<(), Box<dyn Error>> {
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(map)?;
    Ok(std::fs::write(path, bytes)?)
}

/// The map with the same luminance in linear light, and the ratios between the channels of each texel to the power `saturation`.
fn muted(map: &RgbImage, saturation: f64) -> RgbImage {
    let mut map = map.clone();
    for p in map.pixels_mut() {
        // The addend keeps the ratios of nearly black texels finite.
        let colour: Colour = p.0.map(|byte| to_linear(byte) + 1e-4);
        let hue: Colour = colour.map(|v| (v / luminance(colour)).powf(saturation));
        *p = Rgb(hue.map(|v| to_byte(v * luminance(colour) / luminance(hue) - 1e-4)));
    }
    map
}

/// City lights in one channel, as the sensor saw them, times [`CITY_LIGHTS_SCALE`] in linear light. The source shows them in orange and white on blue land: a
/// texel is light if its red is not far below its blue; land, ice and sea become black.
fn city_lights(map: &RgbImage) -> GrayImage {
    GrayImage::from_fn(map.width(), map.height(), |x, y| {
        let [red, _, blue] = map.get_pixel(x, y).0;
        let (red_level, blue_level) = (f64::from(red), f64::from(blue).max(1.0));
        let light_fraction = smoothstep(0.45, 0.75, red_level / blue_level) * smoothstep(20.0, 44.0, red_level);
        Luma([to_byte(CITY_LIGHTS_SCALE * light_fraction * to_linear(red))])
    })
}

/// The gazetteer's features of one body and one type. `type_code`: AA for craters, LG for large ringed features.
fn features(csv: &str, body: &str, type_code: &str) -> Vec<Feature> {
    csv.lines()
        .filter_map(|line| {
            let fields: Vec<&str> = line.rsplitn(5, ',').collect();
            // From the end of the line; the rest begins with the body's name.
            let [diameter, lon, lat, line_type, head] = fields[..] else { return None };
            if line_type != type_code || head.split(',').next() != Some(body) {
                return None;
            }
            let lon: f64 = lon.parse().ok()?;
            let lon_deg = if lon > 180.0 { lon - 360.0 } else { lon };
            Some(Feature { lat_deg: lat.parse().ok()?, lon_deg, diameter_km: diameter.parse().ok()? })
        })
        .collect()
}

/// The linear value of an sRGB-encoded byte.
fn to_linear(byte: u8) -> f64 {
    srgb_to_linear(f64::from(byte) / 255.0)
}

/// The sRGB-encoded byte of a linear value.
fn to_byte(v: f64) -> u8 {
    (linear_to_srgb(v.clamp(0.0, 1.0)) * 255.0).round() as u8
}

/// The value below which a fraction of the weight lies.
fn quantile(values: &[f64], weights: &[f64], fraction: f64) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let limit = fraction * weights.iter().sum::<f64>();
    let mut weight_so_far = 0.0;
    for &i in &order {
        weight_so_far += weights[i];
        if weight_so_far >= limit {
            return values[i];
        }
    }
    order.last().map_or(0.0, |&i| values[i])
}

/// The map in reflectances, scaled so that its brightest value is at most 1 (1 in a zonal map, whose gradients need fine steps). Its mean over the sphere has
/// the hue of `target`, the body's mean reflectance.
fn recolour(map: &RgbImage, how: &Recolouring, target: Colour) -> RgbImage {
    let (w, h) = map.dimensions();
    // Black texels have no hue, so a thousandth of the reddest ground's colour is added.
    let added_colour = how.warm.map(|v| 1e-3 * v / luminance(how.warm));
    let linear: Vec<Colour> = map.pixels().map(|p| std::array::from_fn(|c| to_linear(p[c]) + added_colour[c])).collect();
    let weights: Vec<f64> = (0..w * h).map(|i| ((f64::from(i / w) + 0.5) / f64::from(h) * PI).sin()).collect();
    let total: f64 = weights.iter().sum();
    let mean_of = |values: &[f64]| values.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / total;
    let channel = |list: &[Colour], c: usize| list.iter().map(|p| p[c]).collect::<Vec<_>>();
    let mean: Colour = std::array::from_fn(|c| mean_of(&channel(&linear, c)));
    // The hue is ln(blue/red).
    let hue: Vec<f64> = linear.iter().map(|p| (p[2] / p[0]).ln()).collect();
    let hue_range = how.span.map(|fraction| quantile(&hue, &weights, fraction));
    let redness: Vec<f64> = linear.iter().map(|p| (p[0] / p[1]).ln()).collect();
    // The part of the redness that is uncorrelated with the hue is the residual of a least-squares line.
    let clamped_hue: Vec<f64> = hue.iter().map(|k| k.clamp(hue_range[0], hue_range[1])).collect();
    let (mean_clamped_hue, mean_redness) = (mean_of(&clamped_hue), mean_of(&redness));
    let covariance = |a: &[f64], b: &[f64], (mean_a, mean_b): (f64, f64)| {
        mean_of(&a.iter().zip(b).map(|(x, y)| (x - mean_a) * (y - mean_b)).collect::<Vec<_>>())
    };
    let slope = covariance(&clamped_hue, &redness, (mean_clamped_hue, mean_redness))
        / covariance(&clamped_hue, &clamped_hue, (mean_clamped_hue, mean_clamped_hue));
    let of_luminance_1 = |c: Colour| c.map(|v| v / luminance(c));
    let (warm, cool) = (of_luminance_1(how.warm), of_luminance_1(how.cool));
    let painted: Vec<Colour> = (0..linear.len())
        .map(|i| {
            let coolness = (clamped_hue[i] - hue_range[0]) / (hue_range[1] - hue_range[0]);
            let mut colour: Colour = std::array::from_fn(|c| warm[c].powf(1.0 - coolness) * cool[c].powf(coolness));
            colour[0] *= (how.red_kept * (redness[i] - mean_redness - slope * (clamped_hue[i] - mean_clamped_hue)).clamp(-0.4, 0.4)).exp();
            colour = of_luminance_1(colour);
            if let Some(ice) = how.ice.map(of_luminance_1) {
                // Ice is bright in green, and hardly redder than blue.
                let ice_fraction = smoothstep(-1.0, -0.3, hue[i]) * smoothstep(0.25, 0.5, linear[i][1]);
                colour = std::array::from_fn(|c| colour[c] + ice_fraction * (ice[c] - colour[c]));
            }
            let brightness = luminance(std::array::from_fn(|c| linear[i][c] / mean[c])).powf(how.contrast);
            colour.map(|v| v * brightness)
        })
        .collect();
    let gain: Colour = std::array::from_fn(|c| target[c] / mean_of(&channel(&painted, c)));
    let at_least = if how.is_zonal { 0.0 } else { 1.0 };
    let brightest = painted.iter().flat_map(|p| (0..3).map(move |c| p[c] * gain[c])).fold(at_least, f64::max);
    let texels: Vec<u8> = painted.iter().flat_map(|p| (0..3).map(|c| to_byte(p[c] * gain[c] / brightest)).collect::<Vec<_>>()).collect();
    RgbImage::from_raw(w, h, texels).unwrap_or_else(|| map.clone())
}

/// The map with the mean of each parallel in place of its texels, smoothed over latitudes. Each channel is scaled so that its greatest value is 1, which leaves
/// hues and brightness relative to their means as they are, with finer steps of the 8-bit levels.
fn zonal(map: &RgbImage) -> RgbImage {
    let (w, h) = map.dimensions();
    let mean_of_row = |y: u32| {
        let sum: Colour = (0..w).fold([0.0; 3], |sum, x| std::array::from_fn(|c| sum[c] + to_linear(map.get_pixel(x, y)[c])));
        sum.map(|s| s / f64::from(w))
    };
    let rows: Vec<Colour> = (0..h).map(mean_of_row).collect();
    let sigma = ZONAL_SMOOTHING_DEG / 180.0 * f64::from(h);
    let reach = (4.0 * sigma) as i64;
    let smoothed = |y: i64| {
        let (mut sum, mut total): (Colour, f64) = ([0.0; 3], 0.0);
        for offset in -reach..=reach {
            // Beyond a pole the latitudes come again.
            let row = y + offset;
            let row = if row < 0 { -1 - row } else { row.min(2 * i64::from(h) - 1 - row) };
            let weight = (-0.5 * (offset as f64 / sigma).powi(2)).exp();
            sum = std::array::from_fn(|c| sum[c] + weight * rows[row as usize][c]);
            total += weight;
        }
        sum.map(|s| s / total)
    };
    let parallels: Vec<Colour> = (0..i64::from(h)).map(smoothed).collect();
    let greatest: Colour = std::array::from_fn(|c| parallels.iter().map(|p| p[c]).fold(0.0, f64::max));
    RgbImage::from_fn(w, h, |_, y| Rgb(std::array::from_fn(|c| to_byte(parallels[y as usize][c] / greatest[c]))))
}

/// A grey map of mean level 200 with `contrast` times the relative contrast of the original, at most [`WIDTH`] texels wide.
fn flatten(map: &RgbImage, contrast: f64) -> RgbImage {
    let (width, height) = (WIDTH.min(map.width()), HEIGHT.min(map.height()));
    let grey = image::imageops::resize(&image::imageops::grayscale(map), width, height, FilterType::Triangle);
    let mean = grey.pixels().map(|p| f64::from(p[0])).sum::<f64>() / f64::from(width * height);
    RgbImage::from_fn(width, height, |x, y| {
        let v = 200.0 * (1.0 + contrast * (f64::from(grey.get_pixel(x, y)[0]) / mean - 1.0));
        Rgb([v.clamp(0.0, 255.0).round() as u8; 3])
    })
}

/// The Blue Marble shows shallow and murky water as a bright turquoise (Lake Victoria, the north of the Caspian, the Persian Gulf): up to
/// 0.45 of green light, where water reflects a few hundredths. The brightness of water is compressed smoothly to at most 0.05, and bright
/// water becomes greyer.
fn natural_water(map: &RgbImage) -> RgbImage {
    // 5 % of green light, in the map's linear texels, whose gain in the catalog is about 0.53.
    const MAX_WATER: f64 = 0.05 / 0.53;
    let mut map = map.clone();
    for p in map.pixels_mut() {
        let c: Colour = std::array::from_fn(|k| to_linear(p[k]));
        // In water both green and blue are well above red; leaves reflect little blue, and ice as much red.
        let water_fraction = smoothstep(1.15, 1.45, c[1].min(c[2]) / c[0].max(1e-3));
        let brightness = c[1].max(c[2]);
        let compressed = MAX_WATER * (1.0 - (-brightness / MAX_WATER).exp());
        let factor = 1.0 + water_fraction * (compressed / brightness.max(1e-9) - 1.0);
        // Murky water is greyer than the turquoise of the map.
        let greyness = 0.35 * water_fraction * smoothstep(MAX_WATER, 3.0 * MAX_WATER, brightness);
        let mean = (c[0] + c[1] + c[2]) / 3.0;
        *p = Rgb(c.map(|v| to_byte((v + greyness * (mean - v)) * factor)));
    }
    map
}

/// Tangent-space normals (red east, green north, blue outwards) from heights in metres; slopes are exaggerated.
fn normals_from_elevation((w, h): (u32, u32), metres: impl Fn(u32, u32) -> f64, radius_m: f64, exaggeration: f64) -> RgbImage {
    // Beyond a pole, the meridian continues as the opposite one.
    let height = |x: i64, y: i64| {
        let beyond_pole = y < 0 || y >= i64::from(h);
        let x = if beyond_pole { x + i64::from(w / 2) } else { x };
        let y = if y < 0 { -1 - y } else { y.min(2 * i64::from(h) - 1 - y) };
        metres(x.rem_euclid(i64::from(w)) as u32, y as u32)
    };
    let row_height_m = radius_m * PI / f64::from(h);
    RgbImage::from_fn(w, h, |x, y| {
        let cos_lat = ((f64::from(y) + 0.5) / f64::from(h) * PI).sin();
        // Differences in longitude reach about a row height to either side, so that noise does not grow towards the poles.
        let reach = (1.0 / cos_lat).round().clamp(1.0, f64::from(w) / 8.0) as i64;
        let (x, y) = (i64::from(x), i64::from(y));
        let east = exaggeration * (height(x + reach, y) - height(x - reach, y)) / (2.0 * reach as f64 * row_height_m * cos_lat);
        let north = exaggeration * (height(x, y - 1) - height(x, y + 1)) / (2.0 * row_height_m);
        let length = (east * east + north * north + 1.0).sqrt();
        Rgb([-east / length, -north / length, 1.0 / length].map(|v| ((v * 0.5 + 0.5) * 255.0).round() as u8))
    })
}

/// 0 below `a`, 1 above `b`, smooth in between.
fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
