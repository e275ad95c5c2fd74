//! Inspects one draw at one pixel: returns the colour that the draw computes there and every named value of its module. A named value is bound to a name in
//! the WGSL (`let`, `var`); its last assignment counts.
//!
//! In: a plan's draw, its modules, a pixel. Out: [`PixelValues`], computed in the renderer's precision. Of a mesh, only the nearest triangle that shades the
//! pixel is drawn. Triangles of another draw, such as the sprites of stars, are blended in their order. The module is lowered again (compiled to a tape, see
//! [`lower`](super::lower)) with its named values as outputs; rasteriser, kernels and textures are the same as for images.

use super::RenderError;
use super::blend::blend_pixel;
use super::exec::{ExecutionCounts, LaneMask};
use super::lower::{FIRST_NAMED_LOCATION, lower_for_inspection};
use super::math::Real;
use super::nearest_triangle::nearest_triangles;
use super::pass::{DrawStages, PassImage, execute};
use super::program::{LaneInput, LaneOutput, Program};
use super::raster::setup::VertexGrid;
use super::renderer::{BoundStages, EntryPoints, Precision, SoftwareRenderer, check_loop_limits};
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

/// What a draw computes at a pixel, before it is blended with other draws.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelValues {
    /// Red, green and blue, premultiplied by alpha, and alpha; NaN for a component that the program does not write. If several triangles shade the pixel, their
    /// colours are blended as the draw blends them: the light of overlapping stars is the sum of their light.
    pub colour: [f64; 4],
    /// If several triangles shade the pixel: the values of the last, which lies over the others.
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
        let mut fragments = Vec::new();
        for vertices in vertices_in_turn {
            fragments = fragment_outputs(PlanDraw { vertices, ..draw.clone() }, &bound, self.options().vertex_grid, size, pixel)?;
            if !fragments.is_empty() {
                break;
            }
        }
        let Some(last) = fragments.last() else { return Ok(None) };
        let colour_outputs = [0, 1, 2, 3].map(|c| {
            let is_component = |o: &LaneOutput| matches!(*o, LaneOutput::Location { index: 0, component, .. } if component == c);
            entry_points.fragment.program.outputs.iter().position(is_component)
        });
        let value = |fragment: &[f64], k: usize| fragment.get(k).copied().unwrap_or(f64::NAN);
        let colour_of = |fragment: &Vec<f64>| colour_outputs.map(|output| output.map_or(f64::NAN, |k| value(fragment, k)));
        let over = |below: [f64; 4], above: [f64; 4]| blend_pixel(draw.blend, above, below);
        let colour = fragments.iter().map(colour_of).reduce(over).unwrap_or([f64::NAN; 4]);
        let value_of_output = |k: usize| value(last, k);
        let named_value = |(name, outputs): (String, Range<usize>)| NamedValue { name, numbers: outputs.map(value_of_output).collect() };
        Ok(Some(PixelValues { colour, named: fragment.names.into_iter().map(named_value).collect() }))
    }
}

/// The outputs of a draw's fragment program at the centre of a pixel, once for each triangle that shades it, in the order of drawing. Empty if the draw does
/// not shade the pixel, or if the last triangle computes NaN for its red. `vertex_grid`: the grid to which the rasteriser moves vertices.
fn fragment_outputs<R: Real>(
    draw: PlanDraw,
    bound: &BoundStages<'_, R>,
    vertex_grid: VertexGrid,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> Result<Vec<Vec<f64>>, RenderError> {
    let single_pixel = PlanDraw {
        scissor: [x, y, x + 1, y + 1],
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        depth: DepthState { test: false, write: false },
        ..draw
    };
    // A pass whose image is f32, and NaN where nothing is drawn.
    let pass = Pass::of_numbers("pixel", width, height, vec![single_pixel]);
    // The scissor leaves the same quad of each triangle that covers the pixel. The quads fill a batch in the order of drawing, then the next batch.
    let lane_of_quad = (y % 2 * 2 + x % 2) as usize;
    let recording = RecordingStage { inner: &bound.fragment, lane_of_quad, recorded: Mutex::default() };
    let (image, _) = execute(&pass, &[DrawStages { vertex: &bound.vertex, vertex_grid, fragment: &recording }])?;
    check_loop_limits(&pass, std::slice::from_ref(bound))?;
    let PassImage::Float(pixels) = image else { return Ok(Vec::new()) };
    // Red is still the NaN of the clear colour: the pixel was not covered, or was discarded. If the draw computes NaN for red, the result is the same.
    if pixels.get((y * width + x) as usize).is_none_or(|p| p[0].is_nan()) {
        return Ok(Vec::new());
    }
    Ok(recording.recorded.into_inner())
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

/// A fragment stage that records the outputs of one lane of each quad, unless the lane is inactive or discarded.
struct RecordingStage<'a, R: Real> {
    inner: &'a dyn LaneStage<R>,
    /// 0 to 3: the lane, counted from the first of its quad.
    lane_of_quad: usize,
    /// The outputs of each recorded lane, in the order of the runs and of their quads.
    recorded: Mutex<Vec<Vec<f64>>>,
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
        for lane in (self.stage.lane_of_quad..LANES).step_by(4).filter(|lane| undiscarded >> lane & 1 == 1) {
            let outputs = (0..self.stage.inner.outputs().len()).map(|k| self.inner.output(k)[lane].to_f64()).collect();
            self.stage.recorded.lock().push(outputs);
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
