//! Evaluates many queries of `probe` with one shader module. The software renderer draws a small target in which each query is a column.
//!
//! In: a shader module that imports lib/probe_query.wesl, its uniform bytes and textures, twelve numbers per query. Out: the result rows of each query, one
//! pixel of four numbers each. Each input goes to the shader as two f32 whose sum is the f64 value to 1e-14, relative; outputs are f32 (relative
//! rounding 6e-8).

use super::ProbeError;
use crate::render::plan::{
    Attribute, Blend, Cull, DepthState, FrameImages, FrontFace, Instances, Pass, Plan, PlanDraw, SamplerBinding, ShadingRate,
    TextureBinding, Vertices,
};
use crate::render::software::SoftwareRenderer;
use crate::shader::ModuleId;
use crate::shader::ShaderLibrary;
use std::sync::Arc;

/// Maximum number of queries in one target: the width of the widest image that the renderer draws.
const MAX_QUERIES_PER_TARGET: usize = 16_384;

/// The argument `map_taps` of [`uniform_bytes`](crate::render::plan::uniform_bytes) for probe modules: any value will do. It limits the reads per anisotropic
/// read of a map, and sets the number of intervals over which a ring is averaged; probe modules have no such reads and average no ring.
pub(super) const MAP_TAPS: u8 = 1;

/// A probe module with its uniforms, textures and samplers, which evaluates any number of queries.
pub struct PreparedProbe {
    /// The module that answers the queries.
    pub module: ModuleId,
    /// The bytes of the module's uniform block; empty if it has none.
    pub uniform_bytes: Vec<u8>,
    pub textures: Vec<TextureBinding>,
    pub samplers: Vec<SamplerBinding>,
    /// Number of result rows per query, each of four numbers.
    pub rows: u32,
}

/// Inputs of one query; unused numbers are 0.
pub(crate) type ProbeInputs = [f64; 12];

/// Two f32 numbers: the f32 nearest to the value, and the remainder. Their sum is the value to 1e-14, relative, for magnitudes from about 1e-30 to 1e38.
fn split(value: f64) -> (f32, f32) {
    let high = value as f32;
    let low = (value - f64::from(high)) as f32;
    // Infinities and values beyond f32 have no remainder.
    (high, if low.is_finite() { low } else { 0.0 })
}

impl PreparedProbe {
    /// A module without uniforms, textures and samplers.
    pub fn without_bindings(module: ModuleId, rows: u32) -> Self {
        Self { module, uniform_bytes: Vec::new(), textures: Vec::new(), samplers: Vec::new(), rows }
    }

    /// For each query, in order, its result rows.
    ///
    /// # Errors
    /// The error is one line: the module cannot be compiled, or needs other bindings than this probe's.
    pub fn results(
        &self,
        renderer: &SoftwareRenderer,
        library: &ShaderLibrary,
        queries: &[ProbeInputs],
    ) -> Result<Vec<Vec<[f32; 4]>>, ProbeError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MAX_QUERIES_PER_TARGET) {
            let (frame, _timings) = renderer.render(&self.plan(chunk), library, FrameImages::DisplayAndHdr)?;
            // The only pass has a linear target: its numbers are in `hdr`, and `display` is empty.
            let width = chunk.len();
            for column in 0..width {
                let row = |r: usize| frame.hdr.get(r * width + column).copied().ok_or("the target is smaller than its rows");
                all.push((0..self.rows as usize).map(row).collect::<Result<Vec<_>, _>>()?);
            }
        }
        Ok(all)
    }

    /// A plan that draws each query as an instance that covers one column of the target.
    fn plan(&self, queries: &[ProbeInputs]) -> Plan {
        let count = queries.len();
        // The left edge of column `k`, x in clip space.
        let column_edge_x = |k: usize| 2.0 * k as f32 / count as f32 - 1.0;
        let attribute = |components: u32, values: Vec<f32>| Attribute { components, values: Arc::new(values) };
        let numbers = |group: usize, part: fn((f32, f32)) -> f32| {
            attribute(4, queries.iter().flat_map(|q| q[4 * group..4 * group + 4].iter().map(|v| part(split(*v)))).collect())
        };
        // The edges of the column; then the twelve numbers in groups of four, their high parts before their low parts.
        let mut attributes = vec![attribute(2, (0..count).flat_map(|k| [column_edge_x(k), column_edge_x(k + 1)]).collect())];
        attributes.extend((0..3).map(|group| numbers(group, |(high, _)| high)));
        attributes.extend((0..3).map(|group| numbers(group, |(_, low)| low)));
        let (width, height) = (count as u32, self.rows);
        let draw = PlanDraw {
            label: "queries".into(),
            module: self.module.clone(),
            uniform_bytes: self.uniform_bytes.clone(),
            textures: self.textures.clone(),
            samplers: self.samplers.clone(),
            vertices: Vertices::Count(6),
            instances: Instances { count: width, attributes },
            blend: Blend::Replace,
            shading_rate: ShadingRate::PerPixel,
            cull: Cull::None,
            front_face: FrontFace::default(),
            depth: DepthState { test: false, write: false },
            scissor: [0, 0, width, height],
            extent: None,
        };
        Plan { passes: vec![Pass::of_numbers("queries", width, height, vec![draw])] }
    }
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn the_sum_of_both_parts_is_the_value_to_1e_14() {
        for value in [0.1, -1.0 / 3.0, 149_597_870.7, 1e-30, 0.0] {
            let (high, low) = split(value);
            assert!((f64::from(high) + f64::from(low) - value).abs() <= 1e-14 * value.abs(), "{value}");
        }
        assert_eq!(split(f64::INFINITY), (f32::INFINITY, 0.0));
    }
}
