//! The vertex stage: attributes to lanes, lanes to triangles.
//!
//! In: a draw's vertices and instances and its vertex program. Out: the draw's raster triangles in order, with the source_triangles they are parts
//! of. Each vertex of each instance is run once, however many triangles share it.

use super::RenderError;
use super::exec::LaneMask;
use super::math::Real;
use super::program::{LaneInput, LaneOutput};
use super::raster::setup::{Bounds, Geometry, Interpolation, set_up};
use super::stage::{LANES, LaneProgram};
use crate::render::plan::{Attribute, Cull, PlanDraw, Vertices};
use rayon::prelude::*;
use std::time::Instant;

/// Triangles that one thread sets up at a time.
const SETUP_CHUNK: usize = 4096;

/// The triangles of one draw, and the time that they took.
#[derive(Clone, Debug)]
pub(crate) struct Assembled {
    pub geometry: Geometry,
    /// Triangles before clipping and culling.
    pub given: usize,
    /// Wall time of the vertex program, and of clipping and set-up.
    pub vertex_seconds: f64,
    pub setup_seconds: f64,
}

/// Where a fragment program's varying comes from.
#[derive(Clone, Copy, Debug)]
struct Varying {
    vertex_output: usize,
    interpolation: Interpolation,
}

/// The varyings that the fragment program reads, in the order of its location inputs.
fn link(label: &str, outputs: &[LaneOutput], fragment_inputs: &[LaneInput]) -> Result<Vec<Varying>, RenderError> {
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

/// One lane input of the vertex program.
enum Source<'a> {
    VertexIndex,
    InstanceIndex,
    Attribute { values: &'a [f32], stride: usize, component: usize, per_instance: bool },
    Constant(f64),
}

fn source<'a>(draw: &'a PlanDraw, vertex_attributes: &'a [Attribute], input: &LaneInput) -> Result<Source<'a>, RenderError> {
    Ok(match *input {
        LaneInput::VertexIndex => Source::VertexIndex,
        LaneInput::InstanceIndex => Source::InstanceIndex,
        LaneInput::Location { index, component, .. } => {
            let k = index as usize;
            let (attribute, per_instance) = match vertex_attributes.get(k) {
                Some(a) => (Some(a), false),
                None => (draw.instances.attributes.get(k - vertex_attributes.len()), true),
            };
            let attribute = attribute.ok_or_else(|| RenderError::Attribute { draw: draw.label.clone(), location: index })?;
            if component < attribute.components {
                let (stride, component) = (attribute.components as usize, component as usize);
                Source::Attribute { values: &attribute.values, stride, component, per_instance }
            } else {
                // Missing components read as (0, 0, 0, 1), as on a GPU.
                Source::Constant(if component == 3 { 1.0 } else { 0.0 })
            }
        }
        LaneInput::FragCoord { .. } | LaneInput::FrontFacing | LaneInput::SampleIndex => Source::Constant(0.0),
    })
}

/// Number of elements of an attribute array.
fn element_count(attribute: &Attribute) -> usize {
    attribute.values.len() / (attribute.components as usize).max(1)
}

/// Outputs of the vertex program for every vertex of every instance.
pub(crate) struct ShadedVertices {
    /// For each vertex its clip position, then the varyings.
    values: Vec<f64>,
    varyings: usize,
    /// Vertices of one instance.
    count: usize,
}

impl ShadedVertices {
    /// Clip position and varyings of a vertex.
    fn row(&self, instance: usize, vertex: usize) -> &[f64] {
        let stride = 4 + self.varyings;
        &self.values[(instance * self.count + vertex) * stride..][..stride]
    }

    /// Clip position of a vertex of the first instance; `None` where there is no such vertex.
    pub(crate) fn position(&self, vertex: u32) -> Option<[f64; 4]> {
        ((vertex as usize) < self.count && !self.values.is_empty()).then(|| {
            let row = self.row(0, vertex as usize);
            [row[0], row[1], row[2], row[3]]
        })
    }
}

/// Runs the vertex program alone, for the clip positions of a draw's vertices.
///
/// # Errors
/// As [`assemble`].
pub(crate) fn clip_positions<R: Real>(draw: &PlanDraw, vertex: &dyn LaneProgram<R>) -> Result<ShadedVertices, RenderError> {
    shade(draw, vertex, &[])
}

/// Runs the vertex program on every vertex of every instance.
fn shade<R: Real>(draw: &PlanDraw, vertex: &dyn LaneProgram<R>, varyings: &[Varying]) -> Result<ShadedVertices, RenderError> {
    let position =
        [0, 1, 2, 3].map(|k| vertex.outputs().iter().position(|o| matches!(*o, LaneOutput::Position { component } if component == k)));
    let [Some(px), Some(py), Some(pz), Some(pw)] = position else {
        return Err(RenderError::NoPosition { draw: draw.label.clone() });
    };
    let (vertex_attributes, vertex_count) = match &draw.vertices {
        Vertices::Count(n) => (&[][..], *n as usize),
        Vertices::Mesh { attributes, indices } => {
            let count = attributes.iter().map(element_count).min().unwrap_or(0);
            if let Some(index) = indices.iter().find(|i| **i as usize >= count) {
                return Err(RenderError::Index { draw: draw.label.clone(), index: *index, vertices: count });
            }
            (attributes.as_slice(), count)
        }
    };
    let instances = draw.instances.count as usize;
    if let Some(k) = draw.instances.attributes.iter().position(|a| element_count(a) < instances) {
        let location = (vertex_attributes.len() + k) as u32;
        return Err(RenderError::Instances { draw: draw.label.clone(), location, count: draw.instances.count });
    }
    let sources = vertex.inputs().iter().map(|i| source(draw, vertex_attributes, i)).collect::<Result<Vec<_>, _>>()?;

    let total = vertex_count.saturating_mul(instances);
    let scalars = 4 + varyings.len();
    // Per vertex: clip position, then the varyings.
    let mut shaded = super::try_vec(total.saturating_mul(scalars), 0.0_f64, "the vertices")?;
    shaded.par_chunks_mut(LANES * scalars).enumerate().for_each_init(
        || vertex.start(),
        |run, (batch, out)| {
            let first = batch * LANES;
            let count = out.len() / scalars;
            for (k, source) in sources.iter().enumerate() {
                let lanes = run.input(k);
                for (lane, value) in lanes.iter_mut().enumerate() {
                    // Lanes past the end repeat the last vertex.
                    let at = first + lane.min(count - 1);
                    let (instance, vertex) = (at / vertex_count, at % vertex_count);
                    *value = match source {
                        Source::VertexIndex => R::from_int(vertex as u32),
                        Source::InstanceIndex => R::from_int(instance as u32),
                        Source::Attribute { values, stride, component, per_instance } => {
                            let row = if *per_instance { instance } else { vertex };
                            R::from_f64(values[row * stride + component].into())
                        }
                        Source::Constant(value) => R::from_f64(*value),
                    };
                }
            }
            run.run(LaneMask::MAX);
            for (k, output) in [px, py, pz, pw].into_iter().chain(varyings.iter().map(|v| v.vertex_output)).enumerate() {
                let values = run.output(output);
                for lane in 0..count {
                    out[lane * scalars + k] = values[lane].f64();
                }
            }
        },
    );
    Ok(ShadedVertices { values: shaded, varyings: varyings.len(), count: vertex_count })
}

/// Runs the vertex program and sets up the draw's triangles for a target of the given size.
///
/// # Errors
/// Attributes or varyings that do not fit the programs, an index beyond the vertices, or too little memory.
pub(crate) fn assemble<R: Real>(
    draw: &PlanDraw,
    vertex: &dyn LaneProgram<R>,
    fragment_inputs: &[LaneInput],
    width: u32,
    height: u32,
) -> Result<Assembled, RenderError> {
    let varyings = link(&draw.label, vertex.outputs(), fragment_inputs)?;
    let start = Instant::now();
    let shaded = shade(draw, vertex, &varyings)?;
    let vertex_seconds = start.elapsed().as_secs_f64();

    let indices = match &draw.vertices {
        Vertices::Count(_) => None,
        Vertices::Mesh { indices, .. } => Some(indices.as_slice()),
    };
    let instances = draw.instances.count as usize;
    let start = Instant::now();
    let [x0, y0, x1, y1] = draw.scissor;
    let bounds = Bounds { width, height, scissor: [x0, y0, x1.min(width), y1.min(height)], cull_back: draw.cull == Cull::Back };
    let corners = indices.map_or(shaded.count, <[u32]>::len);
    let per_instance = corners / 3;
    let set_up_range = |range: std::ops::Range<usize>| {
        let mut geometry = Geometry::default();
        for triangle in range {
            let (instance, first) = (triangle / per_instance, triangle % per_instance * 3);
            let rows = [first, first + 1, first + 2].map(|c| shaded.row(instance, indices.map_or(c, |i| i[c] as usize)));
            let positions = rows.map(|r| [r[0], r[1], r[2], r[3]]);
            let interpolated = varyings.iter().enumerate().map(|(k, v)| (v.interpolation, rows.map(|r| r[4 + k])));
            geometry.reserve(varyings.len())?;
            set_up(positions, interpolated, &bounds, &mut geometry);
        }
        Ok(geometry)
    };
    let count = per_instance.saturating_mul(instances);
    let geometry = if count <= SETUP_CHUNK {
        set_up_range(0..count)?
    } else {
        // Chunks are set up in any order on any thread, and appended in drawing order.
        let part = |k: usize| k * SETUP_CHUNK..((k + 1) * SETUP_CHUNK).min(count);
        let parts = (0..count.div_ceil(SETUP_CHUNK)).into_par_iter().map(|k| set_up_range(part(k))).collect::<Result<Vec<_>, _>>()?;
        let mut all = Geometry::default();
        for part in &parts {
            all.append(part)?;
        }
        all
    };
    Ok(Assembled { given: count, geometry, vertex_seconds, setup_seconds: start.elapsed().as_secs_f64() })
}
