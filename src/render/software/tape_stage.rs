//! Shader stages that run the tapes of a lowered module.
//!
//! In: a [`Program`] (a lowered entry point), a draw's uniform bytes and textures. Out: a [`LaneStage`], the
//! rasteriser's view of a shader stage. Always: after a batch was stopped at a loop limit, no further batch runs. Not here: how a tape is executed (`exec`).

use super::exec::{BoundProgram, DrawTapeValues, ExecutionCounts, Executor, LaneMask, TextureUnit};
use super::kernels::KernelClass;
use super::math::Real;
use super::program::{LaneInput, LaneOutput, Program};
use super::stage::{LANES, LaneRun, LaneStage};
use super::texel_marks::TexelMarks;
use super::tone_map::ToneMapUniforms;
use super::tone_map_run::ToneMapRun;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// An entry point of a lowered module, bound to a draw.
pub(crate) struct TapeStage<'a, R: Real> {
    program: &'a Program,
    /// The program's uniforms, and the values that it computes from them once per draw.
    draw_values: DrawTapeValues<R>,
    textures: Box<dyn TextureUnit<R> + Sync + 'a>,
    /// The program's lane tape, bound to kernels.
    bound_program: Arc<BoundProgram<R>>,
    /// If set, the native tone map with these uniforms runs in place of the program.
    tone_map: Option<ToneMapUniforms>,
    /// Marks of texels of an earlier pass's image: the program discards the pixels whose four nearest texels are all marked (see `texel_marks`). `None`: the
    /// program decides for each pixel.
    marks: Option<TexelMarks>,
    /// A batch was stopped at a loop limit; no further batch is run.
    hit_loop_limit: AtomicBool,
}

impl<'a, R: Real> TapeStage<'a, R> {
    /// `bound_program`: the program, bound to the kernels of `class`.
    pub(crate) fn new(
        program: &'a Program,
        bound_program: Arc<BoundProgram<R>>,
        uniform_bytes: &[u8],
        textures: Box<dyn TextureUnit<R> + Sync + 'a>,
        class: KernelClass,
    ) -> Self {
        let draw_values = program.run_draw_tape(uniform_bytes, class, textures.as_ref());
        Self { program, draw_values, textures, bound_program, tone_map: None, marks: None, hit_loop_limit: AtomicBool::new(false) }
    }

    /// Replaces the program by the native tone map with these uniforms, if they are given and the lanes are f32.
    pub(crate) fn with_tone_map(self, tone_map: Option<ToneMapUniforms>) -> Self {
        let lanes_are_f32 = R::as_f32(&[]).is_some();
        Self { tone_map: tone_map.filter(|_| lanes_are_f32), ..self }
    }

    /// Sets the marks of texels, by which the rasteriser can leave out pixels that the program would discard.
    pub(crate) fn with_marks(self, marks: Option<TexelMarks>) -> Self {
        Self { marks, ..self }
    }

    /// Whether a batch was stopped at a loop limit: the image is then incomplete.
    pub(crate) fn hit_loop_limit(&self) -> bool {
        self.hit_loop_limit.load(Ordering::Relaxed)
    }
}

impl<R: Real> LaneStage<R> for TapeStage<'_, R> {
    fn inputs(&self) -> &[LaneInput] {
        &self.program.inputs
    }
    fn outputs(&self) -> &[LaneOutput] {
        &self.program.outputs
    }
    fn reads_input(&self, k: usize) -> bool {
        // Also correct for the native tone map, which reads the same input as the program that it replaces: the position.
        self.bound_program.reads_input(k)
    }
    fn uses_discard(&self) -> bool {
        self.program.uses_discard
    }
    fn reads_texture_size_per_draw(&self) -> bool {
        // An instruction that runs once per draw can read the size of a texture, but no texels.
        self.program.draw_tape.iter().any(|instr| instr.texture().is_some())
    }
    fn is_position_independent(&self) -> bool {
        // A program that uses the pixel's position only to select the texels that it loads counts as independent.
        self.program.is_position_independent()
    }
    fn tone_map(&self) -> Option<ToneMapUniforms> {
        self.tone_map
    }
    fn marks(&self) -> Option<&TexelMarks> {
        self.marks.as_ref()
    }
    fn new_run(&self) -> Box<dyn LaneRun<R> + Send + '_> {
        let native = self.tone_map.and_then(|t| ToneMapRun::new(t, &self.program.inputs, &self.program.outputs, self.textures.as_ref()));
        if let Some(run) = native {
            return Box::new(run);
        }
        Box::new(TapeRun { stage: self, executor: Executor::of(Arc::clone(&self.bound_program)) })
    }
}

/// The state of one thread that runs the tape.
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
        self.run_with_textures(active, stage.textures.as_ref())
    }
    fn run_with_textures(&mut self, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        if self.stage.hit_loop_limit() {
            // No lane is left.
            return 0;
        }
        let undiscarded = self.executor.run(&self.stage.draw_values, active, textures);
        if self.executor.hit_loop_limit() {
            self.stage.hit_loop_limit.store(true, Ordering::Relaxed);
        }
        undiscarded
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        self.executor.output(k)
    }
    fn counts(&self) -> ExecutionCounts {
        self.executor.counts()
    }
}
