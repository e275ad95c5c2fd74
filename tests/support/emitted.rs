//! Evaluates a function of an emitted module in f64, so that tests can compare it with the same formula in Rust.
//!
//! In: a module, and a WGSL expression over the inputs of a query. Out: four numbers per query. The expression becomes a fragment entry
//! point appended to the module's own text, which is parsed, validated and lowered as in the software renderer.

use orrery::image::SharedTexture;
use orrery::render::plan::{AddressMode, SamplerState, uniform_bytes};
use orrery::render::software::exec::{Executor, LANES, LaneMask};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::lower::lower;
use orrery::render::software::math::Real;
use orrery::render::software::program::{LaneInput, Program};
use orrery::render::software::sample::texels::Texels;
use orrery::render::software::sample::{BoundTexture, Textures};
use orrery::scene::draw::DrawUniforms;
use orrery::shader::emit::emit_module;
use orrery::shader::{Layout, ModuleId};
use std::sync::Arc;

/// The components of `p`, then those of `q`: the inputs of the expression for one query.
pub type EvalInput = [f64; 8];

/// Maximum number of taps on a map; with one tap, filtering is isotropic.
const MAP_TAPS: u8 = 1;

pub struct Emitted {
    program: Program,
    layout: Layout,
    /// Whether the module draws a body. Other modules have uniforms of their own, which are filled with zeros here.
    is_keyed_module: bool,
}

impl Emitted {
    /// `value`: a WGSL expression of type `vec4f` in `p` and `q`, both `vec4f`.
    pub fn new(module: &str, value: &str) -> Self {
        Self::edited(module, value, |text| text)
    }

    /// [`Emitted::new`] with the module's text edited.
    pub fn edited(module: &str, value: &str, edit: impl Fn(String) -> String) -> Self {
        let id: ModuleId = module.parse().expect("a module");
        let text = edit(emit_module(&id).expect("emits").wgsl);
        let entry =
            format!("@fragment fn formula_main(@location(0) p: vec4f, @location(1) q: vec4f) -> @location(0) vec4f {{ return {value}; }}");
        let parsed = naga::front::wgsl::parse_str(&format!("{text}\n{entry}\n")).unwrap_or_else(|e| panic!("{module}: {e}"));
        let info = orrery::shader::module::validate(&parsed).expect("valid");
        let is_keyed_module = matches!(id, ModuleId::Keyed(_));
        Self {
            is_keyed_module,
            program: lower(&parsed, &info, "formula_main").expect("lowers"),
            layout: Layout::of(&parsed).expect("a layout"),
        }
    }

    /// Results with the given uniforms. `texture` is bound at every texture binding; it is needed only if the program has one.
    pub fn evaluate(&self, uniforms: &DrawUniforms, texture: Option<SharedTexture>, inputs: &[EvalInput]) -> Vec<[f64; 4]> {
        self.evaluate_in::<f64>(uniforms, texture, inputs)
    }

    /// [`Emitted::evaluate`] in f32, as when frames are drawn, or in f64.
    pub fn evaluate_in<R: Real>(&self, uniforms: &DrawUniforms, texture: Option<SharedTexture>, inputs: &[EvalInput]) -> Vec<[f64; 4]> {
        let uniform_bytes = match self.is_keyed_module {
            true => uniform_bytes(&self.layout, uniforms, MAP_TAPS).expect("uniforms"),
            false => vec![0; self.layout.uniform_size as usize],
        };
        let class = KernelClass::in_use();
        let state = SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, is_trilinear: true };
        let texels = texture.as_ref().map(|t| Arc::new(Texels::of_texture(t).expect("complete levels")));
        let bound = self
            .program
            .textures
            .iter()
            .map(|t| BoundTexture { texels: Arc::clone(texels.as_ref().expect("a texture")), sampler: t.sampler_binding.map(|_| state) });
        let textures = Textures::new(bound.collect(), class);
        let draw_values = self.program.run_draw_tape::<R>(&uniform_bytes, class, &textures);
        let mut executor = Executor::<R>::with_class(&self.program, class).expect("binds");
        let mut results = Vec::with_capacity(inputs.len());
        for chunk in inputs.chunks(LANES) {
            for (k, input) in self.program.inputs.iter().enumerate() {
                let LaneInput::Location { index, component, .. } = *input else { panic!("{input:?}") };
                for (lane, v) in executor.input_mut(k).iter_mut().enumerate() {
                    // The last query also fills the unused lanes.
                    *v = R::from_f64(chunk[lane.min(chunk.len() - 1)][(4 * index + component) as usize]);
                }
            }
            executor.run(&draw_values, LaneMask::MAX, &textures);
            results.extend((0..chunk.len()).map(|lane| std::array::from_fn(|k| executor.output(k)[lane].to_f64())));
        }
        results
    }
}
