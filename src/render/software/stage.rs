//! The interface between the rasteriser and a shader stage: lanes in, lanes out.
//!
//! The rasteriser does not depend on the tape, the compiled form of a shader stage. A [`LaneStage`] is one entry point bound to one draw's uniforms and
//! textures; each thread creates its own [`LaneRun`], fills the inputs of a batch, runs it and reads the outputs. `tape_stage` runs lowered programs; tests
//! supply hand-written stages, so that they check coverage, interpolation and blending without a shader compiler.

use super::exec::{ExecutionCounts, LaneMask, TextureUnit};
use super::math::Real;
use super::program::{LaneInput, LaneOutput};
use super::texel_marks::TexelMarks;
use super::tone_map::ToneMapUniforms;

pub use super::exec::LANES;

/// One entry point with its uniforms and textures bound.
pub trait LaneStage<R: Real>: Sync {
    /// What each lane input contains: entry `k` describes input `k` of a run.
    fn inputs(&self) -> &[LaneInput];
    /// What each lane output contains: entry `k` describes output `k` of a run.
    fn outputs(&self) -> &[LaneOutput];
    /// Whether the stage reads input `k`. The caller need not fill an input that the stage does not read.
    fn reads_input(&self, _k: usize) -> bool {
        true
    }
    /// Whether lanes may be discarded; if so, depth is tested after shading.
    fn uses_discard(&self) -> bool;
    /// Whether the stage reads the size of a texture once per draw: the texture must then be bound before the stage is created.
    fn reads_texture_size_per_draw(&self) -> bool {
        false
    }
    /// Whether the result at a pixel depends only on the texels loaded at that pixel, and not on the pixel's position.
    fn is_position_independent(&self) -> bool {
        false
    }
    /// The uniforms of the tone map, if the entry point is the shipped (not edited) tone map.
    fn tone_map(&self) -> Option<ToneMapUniforms> {
        None
    }
    /// Marks of texels of an earlier pass's image, if the stage discards the pixels whose four nearest texels are all marked (see `texel_marks`).
    fn marks(&self) -> Option<&TexelMarks> {
        None
    }
    /// Creates the working state of one thread.
    fn new_run(&self) -> Box<dyn LaneRun<R> + Send + '_>;
}

/// The working state of one thread in one stage.
pub trait LaneRun<R: Real> {
    /// The lanes of input `k`, to be filled before every run if the stage reads it.
    fn input(&mut self, k: usize) -> &mut [R; LANES];
    /// Runs the batch; `active` consists of complete quads. Returns the active lanes that did not discard.
    fn run(&mut self, active: LaneMask) -> LaneMask;
    /// Like [`LaneRun::run`], with `textures` in place of the bound textures; a stage that reads no texture ignores them.
    fn run_with_textures(&mut self, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        let _ = textures;
        self.run(active)
    }
    /// The lanes of output `k` after a run; unspecified in lanes that are not active.
    fn output(&self, k: usize) -> &[R; LANES];
    /// Instructions and texture reads of the last run, if the stage counts them.
    fn counts(&self) -> ExecutionCounts {
        ExecutionCounts::default()
    }
}
