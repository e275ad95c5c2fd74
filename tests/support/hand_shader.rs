//! Shader stages written as closures over one lane, to test the rasteriser without the shader compiler.

use orrery::render::plan::{Attribute, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, Pass, PlanDraw, ShadingRate, Vertices};
use orrery::render::software::VertexGrid;
use orrery::render::software::math::Real;
use orrery::render::software::pass::{DrawStages, PassImage, execute};
use orrery::render::software::program::{LaneInput, LaneOutput};
use orrery::render::software::stage::{LANES, LaneRun, LaneStage};
use orrery::shader::ModuleId;
use std::sync::Arc;

/// Maps the inputs of one lane, in order, to its outputs; `None` discards the lane.
pub type PerLane<R> = dyn Fn(&[R]) -> Option<Vec<R>> + Sync;

/// Maps the inputs of a 2x2 quad to its outputs, for derivatives; discards no lane.
pub type PerQuad<R> = dyn Fn(&[Vec<R>; 4]) -> [Vec<R>; 4] + Sync;

pub enum LaneFunction<'a, R> {
    Lane(&'a PerLane<R>),
    Quad(&'a PerQuad<R>),
}

pub struct HandShader<'a, R> {
    pub inputs: Vec<LaneInput>,
    pub outputs: Vec<LaneOutput>,
    pub discards: bool,
    pub function: LaneFunction<'a, R>,
}

struct HandRun<'a, R> {
    shader: &'a HandShader<'a, R>,
    inputs: Vec<[R; LANES]>,
    outputs: Vec<[R; LANES]>,
}

impl<R: Real> LaneStage<R> for HandShader<'_, R> {
    fn inputs(&self) -> &[LaneInput] {
        &self.inputs
    }
    fn outputs(&self) -> &[LaneOutput] {
        &self.outputs
    }
    fn uses_discard(&self) -> bool {
        self.discards
    }
    fn new_run(&self) -> Box<dyn LaneRun<R> + Send + '_> {
        let lanes = |n: usize| vec![[R::ZERO; LANES]; n];
        Box::new(HandRun { shader: self, inputs: lanes(self.inputs.len()), outputs: lanes(self.outputs.len()) })
    }
}

impl<R: Real> LaneRun<R> for HandRun<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        &mut self.inputs[k]
    }
    fn run(&mut self, mut active: u128) -> u128 {
        let gather = |lane: usize| self.inputs.iter().map(|i| i[lane]).collect::<Vec<_>>();
        for quad in 0..LANES / 4 {
            match self.shader.function {
                LaneFunction::Lane(f) => {
                    for lane in quad * 4..quad * 4 + 4 {
                        match f(&gather(lane)) {
                            Some(values) => values.into_iter().enumerate().for_each(|(k, v)| self.outputs[k][lane] = v),
                            None => active &= !(1 << lane),
                        }
                    }
                }
                LaneFunction::Quad(f) => {
                    let of_corners = f(&std::array::from_fn(|corner| gather(quad * 4 + corner)));
                    for (corner, values) in of_corners.into_iter().enumerate() {
                        values.into_iter().enumerate().for_each(|(k, v)| self.outputs[k][quad * 4 + corner] = v);
                    }
                }
            }
        }
        active
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        &self.outputs[k]
    }
}

pub fn location(index: u32, component: u32) -> LaneInput {
    LaneInput::Location { index, component, flat: false }
}

pub fn colour_outputs() -> Vec<LaneOutput> {
    (0..4).map(|component| LaneOutput::Location { index: 0, component, flat: false }).collect()
}

/// A vertex shader that returns attribute 0 (four components) as the position, and `scalars` components of attribute 1 as location 0.
pub fn pass_through<R: Real>(scalars: u32) -> HandShader<'static, R> {
    let mut inputs: Vec<_> = (0..4).map(|c| location(0, c)).collect();
    inputs.extend((0..scalars).map(|c| location(1, c)));
    let mut outputs: Vec<_> = (0..4).map(|component| LaneOutput::Position { component }).collect();
    outputs.extend((0..scalars).map(|component| LaneOutput::Location { index: 0, component, flat: false }));
    HandShader { inputs, outputs, discards: false, function: LaneFunction::Lane(&|v| Some(v.to_vec())) }
}

/// A fragment shader whose function maps these inputs of a lane to its colour.
pub fn fragment<'a, R: Real>(inputs: Vec<LaneInput>, f: &'a PerLane<R>) -> HandShader<'a, R> {
    HandShader { inputs, outputs: colour_outputs(), discards: false, function: LaneFunction::Lane(f) }
}

/// Triangles from clip space positions, each vertex with its varyings.
pub fn mesh(vertices: &[[f32; 4]], varyings: &[Vec<f32>]) -> Vertices {
    let attribute = |components: usize, values: Vec<f32>| Attribute { components: components as u32, values: Arc::new(values) };
    let mut attributes = vec![attribute(4, vertices.concat())];
    if let Some(first) = varyings.first() {
        attributes.push(attribute(first.len(), varyings.concat()));
    }
    Vertices::Mesh { attributes, indices: Arc::new((0..vertices.len() as u32).collect()) }
}

pub fn draw(vertices: Vertices, blend: Blend) -> PlanDraw {
    PlanDraw {
        label: "test".into(),
        module: ModuleId::Simple("tone_map"),
        uniform_bytes: Vec::new(),
        textures: Vec::new(),
        samplers: Vec::new(),
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        blend,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: false, write: false },
        scissor: [0, 0, u32::MAX, u32::MAX],
        extent: None,
    }
}

pub fn pass(width: u32, height: u32, samples: u8, draws: Vec<PlanDraw>) -> Pass {
    Pass { name: "test", width, height, format: ColourFormat::Hdr, samples, clear: [0.0; 4], has_depth: true, draws }
}

/// Renders a pass; `stages` has the vertex and the fragment shader of each draw.
pub fn render<R: Real>(pass: &Pass, stages: &[(&HandShader<'_, R>, &HandShader<'_, R>)]) -> Vec<[f32; 4]> {
    let stages: Vec<_> = stages
        .iter()
        .map(|(vertex, fragment)| DrawStages { vertex: *vertex, vertex_grid: VertexGrid::Fine, fragment: *fragment })
        .collect();
    match execute(pass, &stages).expect("the pass renders").0 {
        PassImage::Float(image) => image,
        PassImage::Unorm(_) => panic!("the pass must render floats"),
    }
}
