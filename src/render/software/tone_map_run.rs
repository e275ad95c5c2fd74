//! The shipped (not edited) tone map as a fragment stage in native code: for a tone-map pass that is not fused with the HDR pass before it
//! (pass_fusion.rs), and for those tiles of a fused tone-map pass that other draws, such as labels, cover in part.
//!
//! In: the tone map with its uniforms, the inputs and outputs of the program that it replaces, the HDR image. Out: a [`LaneRun`]. Always: the colours are
//! the bytes of [`ToneMapUniforms::map_to_bytes`], divided by 255. Not here: the mapping itself (`tone_map`).

use super::exec::{ExecutionCounts, LaneMask, TextureUnit};
use super::math::Real;
use super::program::{LaneInput, LaneOutput};
use super::stage::{LANES, LaneRun};
use super::tone_map::ToneMapUniforms;

/// The working state of one thread.
pub(super) struct ToneMapRun<'a, R> {
    tone_map: ToneMapUniforms,
    textures: &'a (dyn TextureUnit<R> + Sync),
    inputs: Vec<[R; LANES]>,
    /// Indices of the inputs that contain the pixel's x and y.
    position_inputs: [usize; 2],
    /// Per output, the index of its component of the colour.
    components: Vec<usize>,
    colour: [[R; LANES]; 4],
}

impl<'a, R: Real> ToneMapRun<'a, R> {
    /// `None` if the lanes are not f32, if the program does not read the pixel's position, or if it has outputs other than the components of one colour.
    pub(super) fn new(
        tone_map: ToneMapUniforms,
        inputs: &[LaneInput],
        outputs: &[LaneOutput],
        textures: &'a (dyn TextureUnit<R> + Sync),
    ) -> Option<Self> {
        // `as_f32` returns something only if R is f32.
        R::as_f32(&[])?;
        let position_input = |axis: u32| inputs.iter().position(|i| matches!(*i, LaneInput::FragCoord { component } if component == axis));
        let component = |output: &LaneOutput| match *output {
            LaneOutput::Location { index: 0, component, .. } if component < 4 => Some(component as usize),
            _ => None,
        };
        Some(Self {
            tone_map,
            textures,
            inputs: vec![[R::ZERO; LANES]; inputs.len()],
            position_inputs: [position_input(0)?, position_input(1)?],
            components: outputs.iter().map(component).collect::<Option<_>>()?,
            colour: [[R::ZERO; LANES], [R::ZERO; LANES], [R::ZERO; LANES], [R::ONE; LANES]],
        })
    }
}

impl<R: Real> LaneRun<R> for ToneMapRun<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        &mut self.inputs[k]
    }
    fn run(&mut self, active: LaneMask) -> LaneMask {
        self.run_with_textures(active, self.textures)
    }
    fn run_with_textures(&mut self, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        // The position is that of the pixel's centre; truncation gives the pixel's column and row.
        let [x, y] = self.position_inputs.map(|k| self.inputs[k].map(|v| R::from_lane_bits(v.to_i32() as u32)));
        let mut light = [[R::ZERO; LANES]; 4];
        // The HDR image is the program's only texture.
        textures.load(0, &x, &y, &[R::ZERO], active, light.each_mut().map(|plane| plane.as_mut_slice()));
        let planes = [0, 1, 2].map(|k: usize| R::as_f32(&light[k]).and_then(|plane| plane.first_chunk::<LANES>()));
        let [Some(r), Some(g), Some(b)] = planes else { return 0 };
        // RGBA, red in the lowest byte.
        let mut packed = [0; LANES];
        self.tone_map.map_to_bytes([r, g, b], &mut packed);
        for (k, plane) in self.colour.iter_mut().take(3).enumerate() {
            for (to, word) in plane.iter_mut().zip(packed) {
                *to = R::from_f32_bits(((word >> (8 * k) & 0xff) as f32 / 255.0).to_bits());
            }
        }
        active
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        &self.colour[self.components[k]]
    }
    fn counts(&self) -> ExecutionCounts {
        ExecutionCounts::default()
    }
}
