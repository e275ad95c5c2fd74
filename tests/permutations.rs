//! Every pair of dimension values, run: each key of the covering set draws the same small body in f32 and in f64.
//!
//! Finite everywhere, no negative light, coverage between 0 and 1, and f32 within half a level of 256 of f64. Failures are gathered.

use orrery::render::software::{Options, Precision, SoftwareRenderer, lowering};
use orrery::scene::draw::{Needs, PixelView};
use orrery::session::{WITH_LIMB, sample_plan};
use orrery::shader::Library;
use orrery::shader::key::{ShaderKey, covering};
use rayon::prelude::*;
use std::sync::LazyLock;

static LIBRARY: LazyLock<Library> = LazyLock::new(|| Library::in_memory(lowering()));
const SIDE: u32 = 40;

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { threads: 1, precision, ..Options::default() }).expect("a renderer")
}

fn picture(renderer: &SoftwareRenderer, key: &ShaderKey) -> Result<Vec<[f32; 4]>, String> {
    let plan = sample_plan(&LIBRARY, key, SIDE, WITH_LIMB).map_err(|e| e.to_string())?;
    let (frame, _) = renderer.render(&plan, &*LIBRARY, true).map_err(|e| e.to_string())?;
    Ok(frame.hdr)
}

/// Half a level of 256: what a display can tell.
const DIFFERENCE: f32 = 1.0 / 512.0;

fn checked(f32s: &SoftwareRenderer, f64s: &SoftwareRenderer, key: &ShaderKey) -> Result<(), String> {
    let (single, double) = (picture(f32s, key)?, picture(f64s, key)?);
    for (k, (a, b)) in single.iter().zip(&double).enumerate() {
        let place = format!("pixel {},{}", k as u32 % SIDE, k as u32 / SIDE);
        if !a.iter().chain(b).all(|v| v.is_finite()) {
            return Err(format!("{place}: {a:?} in f32, {b:?} in f64"));
        }
        if a[..3].iter().chain(&b[..3]).any(|v| *v < 0.0) || !(0.0..=1.0).contains(&a[3]) {
            return Err(format!("{place}: {a:?} is no light"));
        }
        let apart = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
        if apart > DIFFERENCE {
            return Err(format!("{place}: f32 and f64 are {apart} apart: {a:?}, {b:?}"));
        }
    }
    Ok(())
}

#[test]
fn every_pair_of_values_draws_finite_light_that_f32_gets_right() {
    let (f32s, f64s) = (renderer(Precision::F32), renderer(Precision::F64));
    let keys = covering(2);
    assert!(keys.len() >= 10 * 8, "two dimensions have ten and eight values: {}", keys.len());
    let failures: Vec<String> = keys.par_iter().filter_map(|k| checked(&f32s, &f64s, k).err().map(|e| format!("{k}: {e}"))).collect();
    assert!(
        failures.is_empty(),
        "{} of {} keys; the first of them:\n{}",
        failures.len(),
        keys.len(),
        failures[..failures.len().min(20)].join("\n")
    );
}

/// The test above can fail: a body lit ten times as bright differs from itself by more than the bound.
#[test]
fn another_picture_is_told_apart() {
    let renderer = renderer(Precision::F32);
    let key = |lights: u8| ShaderKey::for_draw(&Needs { lights, view: PixelView::Shaded, ..Needs::LEAST });
    let (one, two) = (picture(&renderer, &key(1)).expect("draws"), picture(&renderer, &key(2)).expect("draws"));
    let apart = one.iter().zip(&two).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart > DIFFERENCE, "{apart}");
}
