//! What the rasteriser asks of a shader stage: lanes in, lanes out.
//!
//! The rasteriser knows no tape. A [`LaneProgram`] is one entry point bound to one draw's uniforms and textures; each thread takes its own
//! [`LaneRun`], fills the inputs of a batch, runs it and reads the outputs. [`TapeStage`] is the real one; tests bring hand-written
//! ones, so that coverage, interpolation and blending are checked without any shader compiler.

use super::exec::{ExecutionCounts, Executor, LaneMask, Prepared, TextureUnit};
use super::kernels::KernelClass;
use super::math::Real;
use super::program::{LaneInput, LaneOutput, Program};
use std::sync::atomic::{AtomicBool, Ordering};

pub use super::exec::LANES;

/// One entry point with its uniforms and textures bound.
pub trait LaneProgram<R: Real>: Sync {
    fn inputs(&self) -> &[LaneInput];
    fn outputs(&self) -> &[LaneOutput];
    /// Lanes may end dead: depth is then tested after shading.
    fn uses_discard(&self) -> bool;
    /// Every lane computes a function of the texels under its own pixel alone, wherever that pixel is.
    fn is_same_everywhere(&self) -> bool {
        false
    }
    /// A thread's own working state.
    fn start(&self) -> Box<dyn LaneRun<R> + Send + '_>;
}

/// The working state of one thread in one program.
pub trait LaneRun<R: Real> {
    /// The lanes of input `k`, to be filled before every run.
    fn input(&mut self, k: usize) -> &mut [R; LANES];
    /// Runs the batch; `active` holds whole quads. Returns the active lanes that did not discard.
    fn run(&mut self, active: LaneMask) -> LaneMask;
    /// The same with other textures than those that were bound; a stage that reads none takes no notice.
    fn run_reading(&mut self, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        let _ = textures;
        self.run(active)
    }
    /// The lanes of output `k` after a run; undefined in lanes that are not active.
    fn output(&self, k: usize) -> &[R; LANES];
    /// What the run executed, where it is counted.
    fn work(&self) -> ExecutionCounts {
        ExecutionCounts::default()
    }
}

/// An entry point of a lowered module, bound to a draw.
pub struct TapeStage<'a, R: Real> {
    program: &'a Program,
    prepared: Prepared<R>,
    textures: Box<dyn TextureUnit<R> + Sync + 'a>,
    class: KernelClass,
    /// A batch was stopped in a loop that took too long: no other batch is begun.
    gave_up: AtomicBool,
}

impl<'a, R: Real> TapeStage<'a, R> {
    /// # Errors
    /// A program that is not whole, or kernels that this machine lacks.
    pub fn new(
        program: &'a Program,
        uniform_bytes: &[u8],
        textures: Box<dyn TextureUnit<R> + Sync + 'a>,
        class: KernelClass,
    ) -> Result<Self, String> {
        Executor::<R>::with_class(program, class)?;
        Ok(Self { program, prepared: program.prepare_for(uniform_bytes, class), textures, class, gave_up: AtomicBool::new(false) })
    }

    /// Whether a loop took too long: what was drawn is then no picture.
    pub fn gave_up(&self) -> bool {
        self.gave_up.load(Ordering::Relaxed)
    }
}

impl<R: Real> LaneProgram<R> for TapeStage<'_, R> {
    fn inputs(&self) -> &[LaneInput] {
        &self.program.inputs
    }
    fn outputs(&self) -> &[LaneOutput] {
        &self.program.outputs
    }
    fn uses_discard(&self) -> bool {
        self.program.uses_discard
    }
    fn is_same_everywhere(&self) -> bool {
        self.program.is_same_everywhere()
    }
    fn start(&self) -> Box<dyn LaneRun<R> + Send + '_> {
        match Executor::with_class(self.program, self.class) {
            Ok(executor) => Box::new(TapeRun { stage: self, executor }),
            Err(what) => unreachable!("bound once already: {what}"),
        }
    }
}

struct TapeRun<'a, R: Real> {
    stage: &'a TapeStage<'a, R>,
    executor: Executor<R>,
}

impl<R: Real> LaneRun<R> for TapeRun<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        self.executor.input_mut(k)
    }
    fn run(&mut self, active: LaneMask) -> LaneMask {
        let stage = self.stage;
        self.run_reading(active, stage.textures.as_ref())
    }
    fn run_reading(&mut self, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        if self.stage.gave_up() {
            return 0;
        }
        let alive = self.executor.run(&self.stage.prepared, active, textures);
        if self.executor.gave_up() {
            self.stage.gave_up.store(true, Ordering::Relaxed);
        }
        alive
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        self.executor.output(k)
    }
    fn work(&self) -> ExecutionCounts {
        self.executor.work()
    }
}
