//! Inspects one draw at one pixel: returns the colour that the draw computes there and every named value of its module. A named value is bound to a name in
//! the WGSL (`let`, `var`); its last assignment counts.
//!
//! In: a plan's draw, its modules, a pixel. Out: [`PixelValues`], computed in the renderer's precision. Of a mesh, only the nearest triangle that shades the
//! pixel is drawn. The module is lowered again (compiled to a tape, see [`lower`](super::lower)) with its named values as outputs; rasteriser, kernels and
//! textures are the same as for images.

use super::RenderError;
use super::exec::{ExecutionCounts, LaneMask};
use super::lower::{FIRST_NAMED_LOCATION, lower_for_inspection};
use super::math::Real;
use super::nearest_triangle::nearest_triangles;
use super::pass::{DrawStages, PassImage, execute};
use super::program::{LaneInput, LaneOutput, Program};
use super::raster::setup::VertexGrid;
use super::renderer::{BoundStages, EntryPoints, Precision, SoftwareRenderer};
use super::stage::{LANES, LaneRun, LaneStage};
use crate::render::plan::{Blend, DepthState, ModuleProvider, Pass, PlanDraw, ShadingRate};
use parking_lot::Mutex;
use std::ops::Range;

/// A value bound to a name in a module's WGSL, after its last assignment: a scalar, or the components of a vector or matrix. NaN if the pixel's control flow
/// does not reach the value.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedValue {
    pub name: String,
    pub numbers: Vec<f64>,
}

/// What a draw computes at a pixel, before any blending.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelValues {
    /// Red, green and blue, premultiplied by alpha, and alpha; NaN for a component that the program does not write.
    pub colour: [f64; 4],
    pub named: Vec<NamedValue>,
}

impl SoftwareRenderer {
    /// Runs a draw of an image of `size` (width and height in pixels) at the centre of one pixel (column and row, from the top left). `None` if the draw does
    /// not shade the pixel or computes NaN for its red.
    ///
    /// # Errors
    /// As [`SoftwareRenderer::render`]; also if the draw reads the image of another pass, because no other pass is executed.
    pub fn pixel_values(
        &self,
        draw: &PlanDraw,
        modules: &impl ModuleProvider,
        size: [u32; 2],
        pixel: [u32; 2],
    ) -> Result<Option<PixelValues>, RenderError> {
        // `install`: on the renderer's threads.
        match self.options().precision {
            Precision::F32 => self.install(|| self.values_at::<f32>(draw, modules, size, pixel)),
            Precision::F64 => self.install(|| self.values_at::<f64>(draw, modules, size, pixel)),
        }
    }

    /// As [`SoftwareRenderer::pixel_values`], with lanes of type `R`.
    fn values_at<R: Real>(
        &self,
        draw: &PlanDraw,
        modules: &impl ModuleProvider,
        size: [u32; 2],
        pixel @ [x, y]: [u32; 2],
    ) -> Result<Option<PixelValues>, RenderError> {
        let module_error = |what: String| RenderError::Module { draw: draw.label.clone(), what };
        let module = modules.module(&draw.module).map_err(|e| module_error(e.to_string()))?;
        let lower = |entry: &str| lower_for_inspection(&module.module, &module.info, entry).map_err(|e| module_error(e.to_string()));
        let (vertex, fragment) = (lower("vertex_main")?.program, lower("fragment_main")?);
        let [x0, y0, x1, y1] = draw.scissor;
        if !(x0..x1).contains(&x) || !(y0..y1).contains(&y) {
            return Ok(None);
        }
        let entry_points = EntryPoints { vertex: without_named_outputs(vertex).into(), fragment: fragment.program.into(), tone_map: None };
        let bound = self.bind::<R>(draw, &entry_points, &[])?;
        // Of a mesh, one triangle at a time, the nearest first; of another draw, all vertices at once.
        let vertices_in_turn = nearest_triangles(draw, &bound.vertex, size, pixel)?.unwrap_or_else(|| vec![draw.vertices.clone()]);
        let mut recorded = None;
        for vertices in vertices_in_turn {
            recorded = fragment_outputs(PlanDraw { vertices, ..draw.clone() }, &bound, self.options().vertex_grid, size, pixel)?;
            if recorded.is_some() {
                break;
            }
        }
        let Some(recorded) = recorded else { return Ok(None) };
        let value_of_output = |k: usize| recorded.get(k).copied().unwrap_or(f64::NAN);
        let colour = [0, 1, 2, 3].map(|c| {
            let is_component = |o: &LaneOutput| matches!(*o, LaneOutput::Location { index: 0, component, .. } if component == c);
            entry_points.fragment.program.outputs.iter().position(is_component).map_or(f64::NAN, value_of_output)
        });
        let named_value = |(name, outputs): (String, Range<usize>)| NamedValue { name, numbers: outputs.map(value_of_output).collect() };
        Ok(Some(PixelValues { colour, named: fragment.names.into_iter().map(named_value).collect() }))
    }
}

/// The outputs of a draw's fragment program at the centre of a pixel; `None` if the draw does not shade the pixel, or computes NaN for its red. `vertex_grid`:
/// the grid to which the rasteriser moves vertices.
fn fragment_outputs<R: Real>(
    draw: PlanDraw,
    bound: &BoundStages<'_, R>,
    vertex_grid: VertexGrid,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> Result<Option<Vec<f64>>, RenderError> {
    let single_pixel = PlanDraw {
        scissor: [x, y, x + 1, y + 1],
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        depth: DepthState { test: false, write: false },
        ..draw
    };
    // A pass whose image is f32, and NaN where nothing is drawn.
    let pass = Pass::of_numbers("pixel", width, height, vec![single_pixel]);
    // The scissor leaves one quad of each triangle. That of the first triangle is the first of its batch, so the pixel is one of the first four lanes. If
    // further triangles of the draw cover the pixel, they take other lanes of the batch, which are not recorded.
    let lane = (y % 2 * 2 + x % 2) as usize;
    let recording = RecordingStage { inner: &bound.fragment, lane, recorded: Mutex::default() };
    let (image, _) = execute(&pass, &[DrawStages { vertex: &bound.vertex, vertex_grid, fragment: &recording }])?;
    let PassImage::Float(pixels) = image else { return Ok(None) };
    // Red is still the NaN of the clear colour: the pixel was not covered, or was discarded. If the draw computes NaN for red, the result is the same.
    if pixels.get((y * width + x) as usize).is_none_or(|p| p[0].is_nan()) {
        return Ok(None);
    }
    Ok(Some(recording.recorded.into_inner()))
}

/// The program without the outputs that were added for named values.
fn without_named_outputs(mut program: Program) -> Program {
    // They follow the program's own outputs.
    let output_count =
        program.outputs.iter().take_while(|o| !matches!(o, LaneOutput::Location { index: FIRST_NAMED_LOCATION.., .. })).count();
    program.outputs.truncate(output_count);
    program.output_operands.truncate(output_count);
    program
}

/// A fragment stage that records the outputs of one lane in the last run in which the lane was neither inactive nor discarded.
struct RecordingStage<'a, R: Real> {
    inner: &'a dyn LaneStage<R>,
    lane: usize,
    recorded: Mutex<Vec<f64>>,
}

impl<R: Real> LaneStage<R> for RecordingStage<'_, R> {
    fn inputs(&self) -> &[LaneInput] {
        self.inner.inputs()
    }
    fn outputs(&self) -> &[LaneOutput] {
        self.inner.outputs()
    }
    fn uses_discard(&self) -> bool {
        self.inner.uses_discard()
    }
    fn new_run(&self) -> Box<dyn LaneRun<R> + Send + '_> {
        Box::new(RecordingRun { stage: self, inner: self.inner.new_run() })
    }
}

struct RecordingRun<'a, R: Real> {
    stage: &'a RecordingStage<'a, R>,
    inner: Box<dyn LaneRun<R> + Send + 'a>,
}

impl<R: Real> LaneRun<R> for RecordingRun<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        self.inner.input(k)
    }
    fn run(&mut self, active: LaneMask) -> LaneMask {
        let undiscarded = self.inner.run(active);
        if (undiscarded >> self.stage.lane) & 1 == 1 {
            let outputs = (0..self.stage.inner.outputs().len()).map(|k| self.inner.output(k)[self.stage.lane].to_f64()).collect();
            *self.stage.recorded.lock() = outputs;
        }
        undiscarded
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        self.inner.output(k)
    }
    fn counts(&self) -> ExecutionCounts {
        self.inner.counts()
    }
}
