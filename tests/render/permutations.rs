//! Every pair of dimension values is drawn: each key of the covering set draws the same small body in f32 and in f64.
//!
//! Values must be finite and not negative, coverage between 0 and 1, and f32 within half a level of 256 of f64. Each image must also look
//! as recorded: tests/pairs.png contains a small tile per key, with the keys stored in the file. `ORRERY_RECORD_GOLDEN=1 cargo test --test
//! main render::permutations` records the sheet; look at it before committing. The pixel view of shading cost has no tiles, because every improved
//! kernel changes it.

use crate::support::folds::larger;
use crate::support::sweep;
use orrery::FrameImages;
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::{Options, Precision, SoftwareRenderer, lowering};
use orrery::scene::draw::{DrawFeatures, PixelView};
use orrery::session::{SAMPLE_HALF_SIDE_WITH_LIMB, sample_body_plan};
use orrery::shader::ModuleId;
use orrery::shader::ShaderLibrary;
use orrery::shader::key::{ShaderKey, covering_keys};
use rayon::prelude::*;
use std::sync::LazyLock;

static LIBRARY: LazyLock<ShaderLibrary> = LazyLock::new(|| ShaderLibrary::in_memory(lowering()));
const SIDE: u32 = 40;

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { threads: 1, precision, ..Options::default() }).expect("a renderer")
}

fn image(renderer: &SoftwareRenderer, key: &ShaderKey) -> Result<Vec<[f32; 4]>, String> {
    let plan = sample_body_plan(&LIBRARY, key, SIDE, SAMPLE_HALF_SIDE_WITH_LIMB).map_err(|e| e.to_string())?;
    let (frame, _) = renderer.render(&plan, &*LIBRARY, FrameImages::DisplayAndHdr).map_err(|e| e.to_string())?;
    Ok(frame.hdr)
}

/// Half a level of 256.
const MAX_DIFFERENCE: f32 = 1.0 / 512.0;
/// The same where the opacity of the clouds above decides how much of a pixel at a thin limb is ground, and the greatest number of such pixels that exceed
/// half a level: in one key two pixels, mirror images of each other, where the clouds' opacity is read by another footprint in f32 than in f64. Without the
/// shadow of the clouds, or without the thin limb, the greatest difference of this key is 3e-6.
const MAX_DIFFERENCE_AT_CLOUDED_LIMB: f32 = 1.0 / 32.0;
const MAX_PIXELS_AT_CLOUDED_LIMB: usize = 2;

fn check_key(in_f32: &SoftwareRenderer, in_f64: &SoftwareRenderer, key: &ShaderKey) -> Result<(), String> {
    let (single, double) = (image(in_f32, key)?, image(in_f64, key)?);
    let features = key.features();
    let mut at_clouded_limb = 0;
    for (k, (a, b)) in single.iter().zip(&double).enumerate() {
        let is_at_limb = (0.01..0.99).contains(&b[3]);
        let is_clouded_limb = is_at_limb && features.thin_limb && features.maps.cloud_shadow;
        let pixel_name = format!("pixel {},{}", k as u32 % SIDE, k as u32 / SIDE);
        if !a.iter().chain(b).all(|v| v.is_finite()) {
            return Err(format!("{pixel_name}: {a:?} in f32, {b:?} in f64"));
        }
        if a[..3].iter().chain(&b[..3]).any(|v| *v < 0.0) || !(0.0..=1.0).contains(&a[3]) {
            return Err(format!("{pixel_name}: {a:?} has negative light or a coverage outside 0 to 1"));
        }
        let greatest_difference = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
        if is_clouded_limb && (MAX_DIFFERENCE..MAX_DIFFERENCE_AT_CLOUDED_LIMB).contains(&greatest_difference) {
            at_clouded_limb += 1;
        } else if greatest_difference > MAX_DIFFERENCE {
            return Err(format!("{pixel_name}: f32 and f64 are {greatest_difference} apart: {a:?}, {b:?}"));
        }
    }
    if at_clouded_limb > MAX_PIXELS_AT_CLOUDED_LIMB {
        return Err(format!("f32 and f64 differ in {at_clouded_limb} pixels at the limb below clouds"));
    }
    Ok(())
}

#[test]
fn every_pair_of_values_draws_finite_light_and_f32_agrees_with_f64() {
    let (in_f32, in_f64) = (renderer(Precision::F32), renderer(Precision::F64));
    let keys = covering_keys(2);
    assert!(keys.len() >= 10 * 8, "the two largest dimensions have ten and eight values: {} keys", keys.len());
    let chosen: Vec<_> = keys.iter().enumerate().filter(|(k, _)| sweep::runs(*k, 4)).map(|(_, key)| key).collect();
    let failures: Vec<String> =
        chosen.par_iter().filter_map(|k| check_key(&in_f32, &in_f64, k).err().map(|e| format!("{k}: {e}"))).collect();
    assert!(
        failures.is_empty(),
        "{} of {} keys; the first of them:\n{}",
        failures.len(),
        chosen.len(),
        failures[..failures.len().min(20)].join("\n")
    );
}

/// The test above must be able to fail: a body under two lights differs from one under a single light by more than the bound.
#[test]
fn a_different_image_is_detected() {
    let renderer = renderer(Precision::F32);
    let key = |lights: u8| ShaderKey::for_draw(&DrawFeatures { lights, view: PixelView::Final, ..DrawFeatures::MINIMAL });
    let (one, two) = (image(&renderer, &key(1)).expect("draws"), image(&renderer, &key(2)).expect("draws"));
    let greatest_difference = one.iter().zip(&two).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(greatest_difference > MAX_DIFFERENCE, "{greatest_difference}");
}

/// Side of a tile in pixels, and number of tiles in a row of the sheet.
const TILE: usize = 24;
const TILES_PER_ROW: usize = 16;
/// A tile agrees if at most `MAX_DIFFERING_PIXELS` of its 576 pixels differ by more than `MAX_LEVEL_DIFFERENCE` levels: rounding of the
/// last bit may move an edge.
const MAX_LEVEL_DIFFERENCE: u8 = 3;
const MAX_DIFFERING_PIXELS: usize = 4;

/// A tile for each key, in display bytes.
struct Sheet {
    names: Vec<String>,
    tiles: Vec<Vec<[u8; 3]>>,
}

fn drawn_sheet() -> Sheet {
    let options = Options { threads: 1, kernel_class: KernelClass::Portable, ..Options::default() };
    let renderer = SoftwareRenderer::new(options).expect("a renderer");
    // Without the views of the cost, which count instructions.
    let keys: Vec<ShaderKey> = covering_keys(2).into_iter().filter(|k| k.instructions_per_read().is_none()).collect();
    let tile = |key: &ShaderKey| {
        let plan = sample_body_plan(&LIBRARY, key, TILE as u32, SAMPLE_HALF_SIDE_WITH_LIMB).unwrap_or_else(|e| panic!("{key}: {e}"));
        let (frame, _) = renderer.render(&plan, &*LIBRARY, FrameImages::DisplayAndHdr).unwrap_or_else(|e| panic!("{key}: {e}"));
        // A plain power law suffices, since only changes matter.
        frame.hdr.iter().map(|p| [p[0], p[1], p[2]].map(|v| (255.0 * v.clamp(0.0, 1.0).powf(0.4545)).round() as u8)).collect()
    };
    Sheet { names: keys.iter().map(ToString::to_string).collect(), tiles: keys.par_iter().map(tile).collect() }
}

fn sheet_path() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pairs.png")
}

/// Where the sheet stores a pixel of a tile.
fn byte_offset(tile: usize, pixel: usize) -> usize {
    let row = tile / TILES_PER_ROW * TILE + pixel / TILE;
    let column = tile % TILES_PER_ROW * TILE + pixel % TILE;
    3 * (row * TILES_PER_ROW * TILE + column)
}

impl Sheet {
    fn save(&self, path: &std::path::Path) {
        let rows = self.tiles.len().div_ceil(TILES_PER_ROW);
        let (width, height) = (TILES_PER_ROW * TILE, rows * TILE);
        let mut bytes = vec![0; width * height * 3];
        for (n, tile) in self.tiles.iter().enumerate() {
            for (k, pixel) in tile.iter().enumerate() {
                let at = byte_offset(n, k);
                bytes[at..at + 3].copy_from_slice(pixel);
            }
        }
        let file = std::fs::File::create(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut encoder = png::Encoder::new(file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.add_ztxt_chunk("Keys".into(), self.names.join(" ")).expect("a text");
        encoder.write_header().and_then(|mut w| w.write_image_data(&bytes)).expect("written");
    }

    /// The recorded sheet; `Err` says why it cannot be read.
    fn load(path: &std::path::Path) -> Result<Self, String> {
        let file = std::fs::File::open(path).map_err(|e| format!("no recorded sheet {}: {e}", path.display()))?;
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().map_err(|e| e.to_string())?;
        let keys = reader.info().compressed_latin1_text.iter().find(|t| t.keyword == "Keys").ok_or("no names in the sheet")?;
        let names: Vec<String> = keys.get_text().map_err(|e| e.to_string())?.split(' ').map(Into::into).collect();
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
        reader.next_frame(&mut bytes).map_err(|e| e.to_string())?;
        let pixel = |n: usize, k: usize| {
            let at = byte_offset(n, k);
            bytes.get(at..at + 3).map_or([0; 3], |p| [p[0], p[1], p[2]])
        };
        Ok(Self { tiles: (0..names.len()).map(|n| (0..TILE * TILE).map(|k| pixel(n, k)).collect()).collect(), names })
    }

    /// Descriptions of the differences from the recorded sheet, each beginning with its key.
    fn differences(&self, recorded: &Self) -> Vec<String> {
        let mut all = Vec::new();
        for name in recorded.names.iter().filter(|n| !self.names.contains(n)) {
            all.push(format!("{name}: recorded, but no longer in the set"));
        }
        for (name, tile) in self.names.iter().zip(&self.tiles) {
            let Some(n) = recorded.names.iter().position(|r| r == name) else {
                all.push(format!("{name}: has no recorded tile"));
                continue;
            };
            let differing = tile
                .iter()
                .zip(&recorded.tiles[n])
                .filter(|(a, b)| a.iter().zip(*b).any(|(x, y)| x.abs_diff(*y) > MAX_LEVEL_DIFFERENCE))
                .count();
            if differing > MAX_DIFFERING_PIXELS {
                all.push(format!(
                    "{name}: {differing} of {} pixels are not as recorded (tile {} of row {})",
                    TILE * TILE,
                    n % TILES_PER_ROW,
                    n / TILES_PER_ROW
                ));
            }
        }
        all
    }
}

#[test]
fn every_pair_of_values_looks_as_recorded() {
    let mut drawn = drawn_sheet();
    if std::env::var_os("ORRERY_RECORD_GOLDEN").is_some_and(|v| v == "1") {
        drawn.save(&sheet_path());
    }
    let recorded = Sheet::load(&sheet_path()).unwrap_or_else(|e| panic!("{e}\nORRERY_RECORD_GOLDEN=1 records one"));
    let differences = drawn.differences(&recorded);
    if !differences.is_empty() {
        let new = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("pairs.png");
        drawn.save(&new);
        panic!("{}\nthe new sheet is {}", differences.join("\n"), new.display());
    }
    // The comparison must be able to fail: for a tile that is a twentieth darker, a missing tile, and a missing sheet.
    let lit = drawn.tiles.iter().position(|t| t.iter().filter(|p| p[1] > 100).count() > 50).expect("a lit tile");
    drawn.tiles[lit].iter_mut().flatten().for_each(|v| *v -= *v / 20);
    assert!(drawn.differences(&recorded)[0].starts_with(&drawn.names[lit]));
    drawn.names.pop();
    assert!(drawn.differences(&recorded).iter().any(|d| d.contains("no longer")));
    assert!(Sheet::load(std::path::Path::new("tests/no-such-sheet.png")).is_err_and(|e| e.contains("no recorded sheet")));
}

/// Compares the standard scenes as they are displayed. A failure names the pixel, and the keys of the draws that cover it.
#[test]
fn standard_scenes_in_f32_agree_with_those_in_f64() {
    use orrery::render::plan::SamplingQuality;
    use orrery::session::standard_scenes;
    let session = &*crate::support::session::SESSION;
    let renderers = [Precision::F32, Precision::F64]
        .map(|p| SoftwareRenderer::new(Options { precision: p, ..Options::default() }).expect("a renderer"));
    let mut failures = Vec::new();
    for standard in standard_scenes(256, 256) {
        let (scene, plan) = session.plan(&standard.request, SamplingQuality { samples: 1, anisotropy: 8 }).expect("a plan");
        let [single, double] =
            renderers.each_ref().map(|r| r.render(&plan, session.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr);
        // The sRGB value from 0 to 1 that the display shows.
        let shown = |v: f32| {
            let linear = (f64::from(v) * scene.exposure.factor()).clamp(0.0, 1.0);
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
        };
        let difference = |k: usize| {
            let of_channels = [0, 1, 2].map(|c: usize| (shown(single[k][c]) - shown(double[k][c])).abs());
            of_channels.into_iter().reduce(larger).expect("three channels")
        };
        // In this order NaN is greater than any number.
        let mut beyond_bound: Vec<(f64, usize)> =
            (0..single.len()).map(|k| (difference(k), k)).filter(|(d, _)| d.total_cmp(&f64::from(MAX_DIFFERENCE)).is_gt()).collect();
        beyond_bound.sort_by(|a, b| b.0.total_cmp(&a.0));
        let greatest = (0..single.len()).map(difference).fold(0.0, larger);
        println!("{}: at most {greatest:.2e} of the display's range, {} pixels beyond the bound", standard.name, beyond_bound.len());
        for (d, k) in beyond_bound.iter().take(5) {
            let (x, y) = (*k as u32 % 256, *k as u32 / 256);
            let covers_pixel = |s: [u32; 4]| (s[0]..s[2]).contains(&x) && (s[1]..s[3]).contains(&y);
            let draws = plan.passes[0].draws.iter().filter(|d| covers_pixel(d.scissor));
            let keys: Vec<String> = draws.filter(|d| matches!(d.module, ModuleId::Keyed(_))).map(|d| d.module.to_string()).collect();
            failures.push(format!(
                "{} pixel {x},{y}: {d:.2e}, {:?} and {:?}, by {}",
                standard.name,
                single[*k],
                double[*k],
                keys.join(", ")
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
