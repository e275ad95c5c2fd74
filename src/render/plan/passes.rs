//! The types of a render plan: passes, draws, bindings. They are plain values, which the other files of this folder make and the renderers read.

use super::extent::Extent;
use crate::image::SharedTexture;
use crate::scene::draw::DrawFeatures;
use crate::shader::ModuleId;
use crate::shader::{ShaderError, ShaderLibrary, ShaderModule};
use std::sync::Arc;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AddressMode {
    Repeat,
    ClampToEdge,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SamplerState {
    pub address_u: AddressMode,
    pub address_v: AddressMode,
    /// Trilinear when true, nearest when false.
    pub is_trilinear: bool,
}

/// The image that a texture binding reads.
#[derive(Clone, Debug)]
pub enum TextureSource {
    /// An image in CPU memory.
    Image(SharedTexture),
    /// An image in CPU memory that its owner keeps from frame to frame until another image replaces it, so that a renderer may recognise its copy of the image
    /// by the address.
    Persistent(SharedTexture),
    /// The resolved colour target of an earlier pass, by pass index.
    PassOutput(usize),
    /// The final image of an earlier plan, in the memory of the GPU that drew it.
    OnGpu(GpuImage),
}

/// A handle to a finished image, which stays in the memory of the GPU that drew it at least until the last handle is dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuImage {
    /// Unique in this process. All handles of an image share the `Arc`, so its count tells whether a handle is left.
    pub id: Arc<u64>,
    pub width: u32,
    pub height: u32,
}

#[derive(Clone, Debug)]
pub struct TextureBinding {
    /// Number of the binding in group 0.
    pub binding: u32,
    pub source: TextureSource,
}

#[derive(Clone, Debug)]
pub struct SamplerBinding {
    /// Number of the binding in group 0.
    pub binding: u32,
    pub state: SamplerState,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    Replace,
    /// dst = src + dst * (1 - src.a); src premultiplied.
    PremultipliedOver,
    Add,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cull {
    None,
    Back,
}

/// The winding of a draw's front faces on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrontFace {
    #[default]
    CounterClockwise,
    /// In a mirrored image.
    Clockwise,
}

/// Depth is reversed: a greater value is nearer, and the clear value 0 is infinitely far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DepthState {
    pub test: bool,
    pub write: bool,
}

/// The points at which a draw's fragments are shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ShadingRate {
    /// Each pixel's centre.
    #[default]
    PerPixel,
    /// The draw adds light without fine structure. A renderer may interpolate it between fewer points where the error is at most about a 500th of the light
    /// that the draw adds to the pixel.
    Interpolated,
}

/// The source of a draw's vertices. Attribute `k` is `@location(k)`.
#[derive(Clone, Debug)]
pub enum Vertices {
    /// This many vertices, computed by the shader from `@builtin(vertex_index)` alone.
    Count(u32),
    /// Indexed triangles; each attribute has `components` f32 per vertex.
    Mesh { attributes: Vec<Attribute>, indices: Arc<Vec<u32>> },
}

/// Values of an attribute, per vertex or per instance.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Number of values per vertex or instance, 1 to 4.
    pub components: u32,
    pub values: Arc<Vec<f32>>,
}

/// Per-instance attributes, numbered after the vertex attributes.
#[derive(Clone, Debug)]
pub struct Instances {
    pub count: u32,
    pub attributes: Vec<Attribute>,
}

/// One draw: triangles that a module shades into the pass's target. The uniform block is at group 0, binding 0.
#[derive(Clone, Debug)]
pub struct PlanDraw {
    pub label: String,
    pub module: ModuleId,
    pub uniform_bytes: Vec<u8>,
    pub textures: Vec<TextureBinding>,
    pub samplers: Vec<SamplerBinding>,
    pub vertices: Vertices,
    pub instances: Instances,
    pub blend: Blend,
    pub shading_rate: ShadingRate,
    pub cull: Cull,
    pub front_face: FrontFace,
    pub depth: DepthState,
    /// Pixels that may be drawn: x0, y0, x1, y1 (the last two exclusive).
    pub scissor: [u32; 4],
    /// Bounds, if known, of the pixels in `scissor` that the draw can change; a renderer may skip the others.
    pub extent: Option<Extent>,
}

/// The format of a pass's target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColourFormat {
    /// Linear HDR target. The GPU renderer stores it in half floats if it returns only the display image.
    Hdr,
    /// Linear HDR target that needs f32, because some of its radiances are outside the range of half floats: below it, such as those of a night sky; or above
    /// it, such as those of lines shown in white at an exposure so short that even the Sun's disc would appear darker than white.
    HdrF32,
    /// Bytes that the shader has already encoded: display values, or masks.
    Rgba8Unorm,
}

/// Draws into one target, which is cleared first.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Name of the target (of the resource in the frame graph).
    pub name: &'static str,
    pub width: u32,
    pub height: u32,
    pub format: ColourFormat,
    /// Samples per pixel, 1 or 4.
    pub samples: u8,
    /// Clear colour, in the encoding of the target.
    pub clear: [f32; 4],
    /// Whether the pass has a depth buffer.
    pub has_depth: bool,
    pub draws: Vec<PlanDraw>,
}

impl Pass {
    /// A pass whose fragments are numbers instead of colours: one sample per pixel, without depth; NaN where nothing is drawn. The numbers are kept as f32: by
    /// the software renderer always, by the GPU renderer if [`FrameImages::DisplayAndHdr`] is requested.
    pub(crate) fn of_numbers(name: &'static str, width: u32, height: u32, draws: Vec<PlanDraw>) -> Self {
        Self { name, width, height, format: ColourFormat::Hdr, samples: 1, clear: [f32::NAN; 4], has_depth: false, draws }
    }
}

/// Which images a renderer returns in its [`Frame`](crate::render::frame::Frame).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameImages {
    /// The display image.
    Display,
    /// The display image, and the linear HDR image from which it is made.
    DisplayAndHdr,
}

/// Passes in order; the last one is the final image.
#[derive(Clone, Debug)]
pub struct Plan {
    pub passes: Vec<Pass>,
}

/// The uniforms of one draw of a simple shader (a fixed module, as opposed to the generated ones of bodies).
#[derive(Clone, Debug, PartialEq)]
pub struct SimpleDraw {
    pub module: &'static str,
    /// Names the draw and its pass.
    pub label: String,
    pub uniform_bytes: Vec<u8>,
}

impl Plan {
    /// The modules of the plan's draws, each once.
    pub fn modules(&self) -> Vec<ModuleId> {
        let mut all: Vec<ModuleId> = self.passes.iter().flat_map(|p| &p.draws).map(|d| d.module.clone()).collect();
        all.sort();
        all.dedup();
        all
    }

    /// The features with which bodies are drawn, each once.
    pub(crate) fn features_of_bodies(&self) -> Vec<DrawFeatures> {
        let features = |module: ModuleId| match module {
            ModuleId::Keyed(key) => Some(*key.features()),
            _ => None,
        };
        self.modules().into_iter().filter_map(features).collect()
    }

    /// The draws of simple shaders, in order.
    pub(crate) fn simple_draws(&self) -> Vec<SimpleDraw> {
        let simple_draw_of = |pass: &Pass, d: &PlanDraw| match d.module {
            ModuleId::Simple(module) => {
                let label = format!("{}, for {}", d.label, pass.name);
                Some(SimpleDraw { module, label, uniform_bytes: d.uniform_bytes.clone() })
            }
            _ => None,
        };
        self.passes.iter().flat_map(|p| p.draws.iter().filter_map(move |d| simple_draw_of(p, d))).collect()
    }
}

/// Supplies the compiled modules of a plan.
pub trait ModuleProvider: Sync {
    /// # Errors
    /// A module that does not exist or does not compile.
    fn module(&self, id: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError>;
}

impl ModuleProvider for ShaderLibrary {
    fn module(&self, id: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        self.get(id)
    }
}
