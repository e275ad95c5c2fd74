//! The heavy fragment shader (heavy.wgsl) as a plan for the software renderer. In: the side of the square image in pixels. Out: plan and module, ready to run.
//! Also a plan of the tone map, and functions that measure time.

#[cfg(target_arch = "x86_64")]
pub mod lanes;

use orrery::image::{Level, TexelFormat, Texture};
use orrery::render::plan::ModuleProvider;
use orrery::render::plan::{
    AddressMode, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, Pass, Plan, PlanDraw, SamplerBinding, SamplerState,
    ShadingRate, TextureBinding, TextureSource, Vertices,
};
use orrery::render::software::lowering;
use orrery::shader::ModuleId;
use orrery::shader::reflect::Layout;
use orrery::shader::{ShaderError, ShaderModule, SourceMap};
use std::sync::Arc;

pub const WGSL: &str = include_str!("heavy.wgsl");

/// The uniform block of heavy.wgsl: the Sun's direction; centre and radius of the occluder; scale height and scattering coefficients (red, green, blue) of the
/// air. Lengths are in body radii.
pub const UNIFORMS: [[f32; 4]; 3] = [[0.6, 0.3, 0.741_62, 0.0], [9.0, 4.6, 11.3, 0.9], [0.01, 6.0, 13.0, 30.0]];

/// A map of 1024 x 512 texels, sRGB: gradients in red and green, noise in blue.
pub fn map() -> Texture {
    let (width, height) = (1024u32, 512u32);
    let mut rgba = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let noise = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 24;
            rgba.extend([(x >> 2) as u8, (y >> 1) as u8, noise as u8, 255]);
        }
    }
    Texture::from_rgba8(width, height, rgba, TexelFormat::Rgba8Srgb).expect("a texture of this size")
}

/// A provider that returns its one module for every id.
pub struct SingleModule(pub Arc<ShaderModule>);

impl ModuleProvider for SingleModule {
    fn module(&self, _: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        Ok(Arc::clone(&self.0))
    }
}

/// A module from a complete WGSL text, without emission. Its id is only a placeholder.
pub fn module(wgsl: &str) -> SingleModule {
    let module = naga::front::wgsl::parse_str(wgsl).expect("the bench's shader parses");
    let info = orrery::shader::module::validate(&module).expect("the bench's shader is valid");
    let tape = (lowering().lower)(&module, &info).expect("the bench's shader can be lowered");
    let layout = Layout::of(&module).expect("the plan can fill the shader's bindings");
    SingleModule(Arc::new(ShaderModule {
        id: ModuleId::Simple("tone_map"),
        wgsl: wgsl.into(),
        module,
        info,
        layout,
        source_map: SourceMap::default(),
        tape,
    }))
}

/// The program's simple shader of this name.
pub fn simple_module(name: &'static str) -> SingleModule {
    SingleModule(Arc::new(ShaderModule::build(&ModuleId::Simple(name), &lowering()).expect("a simple module builds")))
}

/// Plan of one pass in which the heavy shader fills an image of `side_px` x `side_px` pixels.
pub fn plan(side_px: u32) -> Plan {
    let uniform_bytes = UNIFORMS.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    let draw = PlanDraw {
        label: "heavy".into(),
        // The provider ignores the id.
        module: ModuleId::Simple("tone_map"),
        uniform_bytes,
        textures: vec![TextureBinding { binding: 1, source: TextureSource::Image(Arc::new(map())) }],
        samplers: vec![SamplerBinding { binding: 8, state }],
        vertices: Vertices::Count(3),
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: false, write: false },
        scissor: [0, 0, side_px, side_px],
        extent: None,
    };
    let pass = Pass {
        name: "heavy",
        width: side_px,
        height: side_px,
        format: ColourFormat::Hdr,
        samples: 1,
        clear: [0.0; 4],
        has_depth: false,
        draws: vec![draw],
    };
    Plan { passes: vec![pass] }
}

/// Plan of the tone map of an image of `side_px` x `side_px` pixels with values up to ten times white.
pub fn tone_map_plan(side_px: u32) -> Plan {
    let mut bytes = Vec::new();
    for k in 0..side_px * side_px {
        // A value from 0 to 1.
        let value = |factor: u32| (k.wrapping_mul(factor) >> 8) as f32 / (1 << 24) as f32;
        let pixel = [value(0x9e37_79b9), 10.0 * value(0x85eb_ca6b).powi(3), value(0xc2b2_ae35).powi(2), 1.0];
        bytes.extend(pixel.iter().flat_map(|v| v.to_le_bytes()));
    }
    let hdr = Texture { format: TexelFormat::Rgba32Float, levels: vec![Level::new(side_px, side_px, bytes)] };
    let mut plan = plan(side_px);
    let pass = &mut plan.passes[0];
    (pass.name, pass.format) = ("tone map", ColourFormat::Rgba8Unorm);
    let draw = &mut pass.draws[0];
    // Exposure, and the exposed light up to which the tone curve is the identity.
    draw.uniform_bytes = [1.0_f32, 0.8].iter().flat_map(|v| v.to_le_bytes()).collect();
    draw.textures = vec![TextureBinding { binding: 1, source: TextureSource::Image(Arc::new(hdr)) }];
    draw.samplers.clear();
    plan
}

/// CPU time of the process, all threads, seconds.
pub fn cpu_seconds() -> f64 {
    orrery::session::process_cpu().expect("this system reports a process's CPU time").as_secs_f64()
}

/// The median; the upper one of an even number of values.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
