//! The vertex stage: runs the vertex program over batches of vertices, and sets up the triangles.
//!
//! In: a draw's vertices, instances and vertex program. Out: the draw's raster triangles in order, each with its source triangle (the triangle before
//! clipping). Always: the program runs once for each vertex of each instance, however many triangles share the vertex.

use super::RenderError;
use super::exec::LaneMask;
use super::math::Real;
use super::program::{LaneInput, LaneOutput};
use super::raster::setup::{Interpolation, RasterGeometry, RasterState, VertexGrid, set_up};
use super::stage::{LANES, LaneRun, LaneStage};
use crate::render::plan::{Attribute, Cull, FrontFace, PlanDraw, Vertices};
use rayon::prelude::*;
use std::time::Instant;

/// Number of triangles that a thread processes at a time; their vertices stay in its cache.
const TRIANGLES_PER_PART: usize = 1024;

/// The triangles of one draw, and the time that it took to prepare them.
#[derive(Clone, Debug)]
pub(crate) struct AssembledDraw {
    pub geometry: RasterGeometry,
    /// Number of triangles before clipping and culling.
    pub submitted_triangles: usize,
    /// Wall time of the vertex program.
    pub vertex_seconds: f64,
    /// Wall time of clipping and set-up.
    pub setup_seconds: f64,
}

/// A varying of the fragment program: the vertex output that it reads, and how it is interpolated.
#[derive(Clone, Copy, Debug)]
struct Varying {
    vertex_output: usize,
    interpolation: Interpolation,
}

/// The varyings that the fragment program reads, in the order of `fragment_inputs`. `outputs`: those of the vertex program. `label`: the draw's label, for the
/// error.
///
/// # Errors
/// A varying that the vertex program does not write.
fn link_varyings(label: &str, outputs: &[LaneOutput], fragment_inputs: &[LaneInput]) -> Result<Vec<Varying>, RenderError> {
    let mut varyings = Vec::new();
    for input in fragment_inputs {
        let LaneInput::Location { index, component, flat } = *input else { continue };
        let found =
            outputs.iter().position(|o| matches!(*o, LaneOutput::Location { index: i, component: c, .. } if (i, c) == (index, component)));
        let vertex_output = found.ok_or_else(|| RenderError::Varying { draw: label.to_owned(), location: index, component })?;
        varyings.push(Varying { vertex_output, interpolation: if flat { Interpolation::Flat } else { Interpolation::Perspective } });
    }
    Ok(varyings)
}

/// The source of one lane input of the vertex program.
enum VertexInputSource<'a> {
    VertexIndex,
    InstanceIndex,
    /// `stride`: number of floats per element (a vertex, or an instance if `is_per_instance`); `component`: position of the float in its element.
    Attribute {
        values: &'a [f32],
        stride: usize,
        component: usize,
        is_per_instance: bool,
    },
    Constant(f64),
}

/// The source of an input of the vertex program. Locations count the vertex attributes first, then the instance attributes.
///
/// # Errors
/// The draw has no attribute for the location.
fn input_source<'a>(
    draw: &'a PlanDraw,
    vertex_attributes: &'a [Attribute],
    input: &LaneInput,
) -> Result<VertexInputSource<'a>, RenderError> {
    Ok(match *input {
        LaneInput::VertexIndex => VertexInputSource::VertexIndex,
        LaneInput::InstanceIndex => VertexInputSource::InstanceIndex,
        LaneInput::Location { index, component, .. } => {
            let location = index as usize;
            let (attribute, is_per_instance) = match vertex_attributes.get(location) {
                Some(a) => (Some(a), false),
                None => (draw.instances.attributes.get(location - vertex_attributes.len()), true),
            };
            let attribute = attribute.ok_or_else(|| RenderError::Attribute { draw: draw.label.clone(), location: index })?;
            if component < attribute.components {
                let (stride, component) = (attribute.components as usize, component as usize);
                VertexInputSource::Attribute { values: &attribute.values, stride, component, is_per_instance }
            } else {
                // Missing components read as (0, 0, 0, 1), as on a GPU.
                VertexInputSource::Constant(if component == 3 { 1.0 } else { 0.0 })
            }
        }
        // These inputs do not occur in a vertex stage.
        LaneInput::FragCoord { .. } | LaneInput::FrontFacing | LaneInput::SampleIndex => VertexInputSource::Constant(0.0),
    })
}

/// Number of elements of an attribute array.
fn element_count(attribute: &Attribute) -> usize {
    attribute.values.len() / (attribute.components as usize).max(1)
}

/// Outputs of the vertex program for every vertex of every instance.
pub(crate) struct ShadedVertices {
    /// One row per vertex, as written by [`VertexShading::shade_batch`].
    values: Vec<f64>,
    /// Number of values in a row: the four components of the clip-space position, and the varyings.
    row_length: usize,
    vertices_per_instance: usize,
}

impl ShadedVertices {
    /// Clip-space position and varyings of a vertex.
    fn row(&self, instance: usize, vertex: usize) -> &[f64] {
        &self.values[(instance * self.vertices_per_instance + vertex) * self.row_length..][..self.row_length]
    }

    /// Clip-space position of a vertex of the first instance; `None` if the index is out of range.
    pub(crate) fn position(&self, vertex: u32) -> Option<[f64; 4]> {
        // A draw without instances has no values.
        ((vertex as usize) < self.vertices_per_instance && !self.values.is_empty()).then(|| {
            let row = self.row(0, vertex as usize);
            [row[0], row[1], row[2], row[3]]
        })
    }
}

/// The clip-space positions of a draw's vertices: runs the vertex program, but sets up no triangles.
///
/// # Errors
/// As [`assemble`].
pub(crate) fn clip_positions<R: Real>(draw: &PlanDraw, vertex_stage: &dyn LaneStage<R>) -> Result<ShadedVertices, RenderError> {
    let no_varyings = &[];
    VertexShading::new(draw, vertex_stage, no_varyings)?.shade_all()
}

/// A draw's vertex stage, with a source for each of its inputs.
struct VertexShading<'a, R: Real> {
    stage: &'a dyn LaneStage<R>,
    sources: Vec<VertexInputSource<'a>>,
    /// Indices of the stage's outputs that make up a vertex's row: clip-space position, then the varyings.
    outputs: Vec<usize>,
    vertices_per_instance: usize,
    /// Number of vertices of all instances.
    total_vertices: usize,
}

impl<'a, R: Real> VertexShading<'a, R> {
    fn new(draw: &'a PlanDraw, stage: &'a dyn LaneStage<R>, varyings: &[Varying]) -> Result<Self, RenderError> {
        let position_outputs =
            [0, 1, 2, 3].map(|k| stage.outputs().iter().position(|o| matches!(*o, LaneOutput::Position { component } if component == k)));
        let [Some(px), Some(py), Some(pz), Some(pw)] = position_outputs else {
            return Err(RenderError::NoPosition { draw: draw.label.clone() });
        };
        let (vertex_attributes, vertices_per_instance) = match &draw.vertices {
            Vertices::Count(n) => (&[][..], *n as usize),
            Vertices::Mesh { attributes, indices } => {
                let count = attributes.iter().map(element_count).min().unwrap_or(0);
                if let Some(index) = indices.iter().find(|i| **i as usize >= count) {
                    return Err(RenderError::Index { draw: draw.label.clone(), index: *index, vertices: count });
                }
                (attributes.as_slice(), count)
            }
        };
        let instance_count = draw.instances.count as usize;
        if let Some(k) = draw.instances.attributes.iter().position(|a| element_count(a) < instance_count) {
            let location = (vertex_attributes.len() + k) as u32;
            return Err(RenderError::Instances { draw: draw.label.clone(), location, count: draw.instances.count });
        }
        let sources = stage.inputs().iter().map(|i| input_source(draw, vertex_attributes, i)).collect::<Result<Vec<_>, _>>()?;
        let outputs = [px, py, pz, pw].into_iter().chain(varyings.iter().map(|v| v.vertex_output)).collect();
        let total_vertices = vertices_per_instance.saturating_mul(instance_count);
        Ok(Self { stage, sources, outputs, vertices_per_instance, total_vertices })
    }

    /// Runs the program on one batch of vertices and writes one row per vertex to `rows`. `first`: index of the first vertex, counted over all instances.
    fn shade_batch(&self, run: &mut dyn LaneRun<R>, first: usize, rows: &mut [f64]) {
        let row_length = self.outputs.len();
        let count = rows.len() / row_length;
        // Instance and vertex of each lane; lanes past the end repeat the last vertex.
        let [mut instances, mut vertices] = [[0_u32; LANES]; 2];
        let (mut instance, mut vertex) = (first / self.vertices_per_instance, first % self.vertices_per_instance);
        for (lane, (instance_of_lane, vertex_of_lane)) in instances.iter_mut().zip(&mut vertices).enumerate() {
            (*instance_of_lane, *vertex_of_lane) = (instance as u32, vertex as u32);
            if lane + 1 < count {
                vertex += 1;
                if vertex == self.vertices_per_instance {
                    (instance, vertex) = (instance + 1, 0);
                }
            }
        }
        for (k, source) in self.sources.iter().enumerate() {
            let lanes = run.input(k);
            match *source {
                VertexInputSource::VertexIndex => {
                    lanes.iter_mut().zip(&vertices).for_each(|(lane, vertex)| *lane = R::from_lane_bits(*vertex))
                }
                VertexInputSource::InstanceIndex => {
                    lanes.iter_mut().zip(&instances).for_each(|(lane, instance)| *lane = R::from_lane_bits(*instance))
                }
                VertexInputSource::Constant(value) => lanes.fill(R::from_f64(value)),
                VertexInputSource::Attribute { values, stride, component, is_per_instance: false } => {
                    for (lane, vertex) in lanes.iter_mut().zip(&vertices) {
                        *lane = R::from_f32_bits(values[*vertex as usize * stride + component].to_bits());
                    }
                }
                VertexInputSource::Attribute { values, stride, component, is_per_instance: true } => {
                    // The vertices of an instance are consecutive; the last instance also fills the lanes past the end.
                    let mut from = 0;
                    while from < LANES {
                        let vertices_left = self.vertices_per_instance - vertices[from] as usize;
                        let to = if instances[from] == instances[LANES - 1] { LANES } else { from + vertices_left };
                        let value = R::from_f32_bits(values[instances[from] as usize * stride + component].to_bits());
                        lanes[from..to].fill(value);
                        from = to;
                    }
                }
            }
        }
        // Lanes past the end run, too; their outputs are not copied.
        run.run(LaneMask::MAX);
        for (k, output) in self.outputs.iter().enumerate() {
            for (row, value) in rows.chunks_exact_mut(row_length).zip(run.output(*output)) {
                row[k] = value.to_f64();
            }
        }
    }

    /// Runs the program on every vertex of every instance.
    fn shade_all(&self) -> Result<ShadedVertices, RenderError> {
        let row_length = self.outputs.len();
        let mut values = super::try_vec(self.total_vertices.saturating_mul(row_length), 0.0_f64, "the vertices")?;
        values
            .par_chunks_mut(LANES * row_length)
            .enumerate()
            .for_each_init(|| self.stage.new_run(), |run, (batch, rows)| self.shade_batch(run.as_mut(), batch * LANES, rows));
        Ok(ShadedVertices { values, row_length, vertices_per_instance: self.vertices_per_instance })
    }
}

/// Sets up triangles of a draw from the rows of their vertices.
struct TriangleSetup<'a> {
    raster_state: RasterState,
    varyings: &'a [Varying],
    /// How many of the varyings are flat.
    flat_count: usize,
}

impl TriangleSetup<'_> {
    /// Reserves memory for `count` triangles.
    fn reserve(&self, count: usize, geometry: &mut RasterGeometry) -> Result<(), RenderError> {
        geometry.reserve(count, self.varyings.len() - self.flat_count, self.flat_count)
    }

    /// Sets up one triangle. `rows`: one for each vertex, the clip-space position and then the varyings.
    fn add(&self, rows: [&[f64]; 3], geometry: &mut RasterGeometry) -> Result<(), RenderError> {
        let positions = rows.map(|r| [r[0], r[1], r[2], r[3]]);
        let varyings = self.varyings.iter().enumerate().map(|(k, v)| (v.interpolation, rows.map(|r| r[4 + k])));
        self.reserve(1, geometry)?;
        set_up(positions, varyings, &self.raster_state, geometry);
        Ok(())
    }
}

/// A part of a draw, and the time that one thread took for it.
struct DrawPart {
    geometry: RasterGeometry,
    /// Time of the vertex program; 0 if it ran for the whole draw before.
    vertex_seconds: f64,
    setup_seconds: f64,
}

/// Runs the vertex program and sets up the draw's triangles for a target of `width` x `height` pixels. `vertex_grid`: the grid of vertex positions.
///
/// # Errors
/// Attributes or varyings that do not fit the programs, an index beyond the vertices, or too little memory.
pub(crate) fn assemble<R: Real>(
    draw: &PlanDraw,
    vertex_stage: &dyn LaneStage<R>,
    fragment_inputs: &[LaneInput],
    [width, height]: [u32; 2],
    vertex_grid: VertexGrid,
) -> Result<AssembledDraw, RenderError> {
    let start = Instant::now();
    let varyings = link_varyings(&draw.label, vertex_stage.outputs(), fragment_inputs)?;
    let shading = VertexShading::new(draw, vertex_stage, &varyings)?;
    let [x0, y0, x1, y1] = draw.scissor;
    let scissor = [x0, y0, x1.min(width), y1.min(height)];
    let raster_state = RasterState {
        width,
        height,
        scissor,
        culls_back_faces: draw.cull == Cull::Back,
        front_faces_are_clockwise: draw.front_face == FrontFace::Clockwise,
        vertex_grid,
    };
    let flat_count = varyings.iter().filter(|v| v.interpolation == Interpolation::Flat).count();
    let setup = TriangleSetup { raster_state, varyings: &varyings, flat_count };
    let instance_count = draw.instances.count as usize;
    // Wall time of the vertex program, if it ends before the first triangle is set up.
    let mut separate_vertex_seconds = None;
    let (submitted_triangles, mut parts) = match &draw.vertices {
        Vertices::Mesh { indices, .. } => {
            let shaded = shading.shade_all()?;
            let triangles_per_instance = indices.len() / 3;
            let submitted_triangles = triangles_per_instance.saturating_mul(instance_count);
            separate_vertex_seconds = Some(start.elapsed().as_secs_f64());
            let process_part = |range: std::ops::Range<usize>| -> Result<DrawPart, RenderError> {
                let (start, mut geometry) = (Instant::now(), RasterGeometry::default());
                setup.reserve(range.len(), &mut geometry)?;
                for triangle in range {
                    let (instance, first_index) = (triangle / triangles_per_instance, triangle % triangles_per_instance * 3);
                    let row = |corner: usize| shaded.row(instance, indices[first_index + corner] as usize);
                    setup.add([row(0), row(1), row(2)], &mut geometry)?;
                }
                Ok(DrawPart { geometry, vertex_seconds: 0.0, setup_seconds: start.elapsed().as_secs_f64() })
            };
            (submitted_triangles, map_parts(submitted_triangles, || (), |(), range| process_part(range))?)
        }
        // No vertex is shared, so the triangles of a part are set up while its vertices are in the cache.
        Vertices::Count(_) => {
            let triangles_per_instance = shading.vertices_per_instance / 3;
            let submitted_triangles = triangles_per_instance.saturating_mul(instance_count);
            let row_length = shading.outputs.len();
            let process_part = |(run, rows): &mut (Box<dyn LaneRun<R> + Send + '_>, Vec<f64>), range: std::ops::Range<usize>| {
                let (start, mut geometry) = (Instant::now(), RasterGeometry::default());
                // Vertices that do not form a complete triangle are skipped.
                let first_vertex = |triangle: usize| {
                    triangle / triangles_per_instance * shading.vertices_per_instance + triangle % triangles_per_instance * 3
                };
                let Some(last) = range.clone().last() else {
                    return Ok(DrawPart { geometry, vertex_seconds: 0.0, setup_seconds: 0.0 });
                };
                let vertices = first_vertex(range.start)..first_vertex(last) + 3;
                let value_count = vertices.len() * row_length;
                if rows.len() < value_count {
                    super::try_grow(rows, value_count - rows.len(), "the vertices")?;
                    rows.resize(value_count, 0.0);
                }
                let rows = &mut rows[..value_count];
                for (batch, rows) in rows.chunks_mut(LANES * row_length).enumerate() {
                    shading.shade_batch(run.as_mut(), vertices.start + batch * LANES, rows);
                }
                let vertex_seconds = start.elapsed().as_secs_f64();
                setup.reserve(range.len(), &mut geometry)?;
                for triangle in range {
                    let from = (first_vertex(triangle) - vertices.start) * row_length;
                    let (a, rest) = rows[from..from + 3 * row_length].split_at(row_length);
                    let (b, c) = rest.split_at(row_length);
                    setup.add([a, b, c], &mut geometry)?;
                }
                Ok(DrawPart { geometry, vertex_seconds, setup_seconds: start.elapsed().as_secs_f64() - vertex_seconds })
            };
            (submitted_triangles, map_parts(submitted_triangles, || (vertex_stage.new_run(), Vec::new()), process_part)?)
        }
    };
    let total_vertex_seconds: f64 = parts.iter().map(|part| part.vertex_seconds).sum();
    let total_seconds: f64 = parts.iter().map(|part| part.vertex_seconds + part.setup_seconds).sum();
    let geometry = match &mut parts[..] {
        [only] => std::mem::take(&mut only.geometry),
        parts => RasterGeometry::joined(parts.iter().map(|part| &part.geometry))?,
    };
    let wall_seconds = start.elapsed().as_secs_f64();
    // If each part processed its vertices and then its triangles, the vertex program's share of the wall time is its share of the sum over all threads.
    let proportional_seconds = if total_seconds > 0.0 { wall_seconds * total_vertex_seconds / total_seconds } else { 0.0 };
    let vertex_seconds = separate_vertex_seconds.unwrap_or(proportional_seconds);
    Ok(AssembledDraw { geometry, submitted_triangles, vertex_seconds, setup_seconds: wall_seconds - vertex_seconds })
}

/// Processes a draw's triangles in parts, in parallel, and returns the parts in drawing order. `create_buffers` creates the buffers of one thread;
/// `process_part` processes a range of triangles.
fn map_parts<B>(
    triangle_count: usize,
    create_buffers: impl Fn() -> B + Sync + Send,
    process_part: impl Fn(&mut B, std::ops::Range<usize>) -> Result<DrawPart, RenderError> + Sync + Send,
) -> Result<Vec<DrawPart>, RenderError> {
    let range = |k: usize| k * TRIANGLES_PER_PART..((k + 1) * TRIANGLES_PER_PART).min(triangle_count);
    if triangle_count <= TRIANGLES_PER_PART {
        return Ok(vec![process_part(&mut create_buffers(), 0..triangle_count)?]);
    }
    (0..triangle_count.div_ceil(TRIANGLES_PER_PART))
        .into_par_iter()
        .map_init(create_buffers, |buffers, k| process_part(buffers, range(k)))
        .collect()
}
