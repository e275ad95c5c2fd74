//! What a module costs on the software renderer, by its tapes. In: a module. Out: counts that do not depend on the machine.

use crate::render::software::lower::programs_from_bytes;
use crate::render::software::program::{ProgramError, Stage};
use crate::render::software::tape::Instr;
use crate::shader::ShaderModule;
use std::collections::BTreeMap;

/// One entry point's tape. Operations of a loop count once.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TapeCost {
    /// `vertex` or `fragment`.
    pub stage: &'static str,
    /// Operations over lanes, by kind.
    pub operations: BTreeMap<String, usize>,
    /// Instructions that run once a draw.
    pub uniform_operations: usize,
    /// Samples and loads of textures.
    pub texture_reads: usize,
    /// Of branches and loops.
    pub jumps: usize,
    /// Values of one lane kept at a time.
    pub slots: u32,
    /// Values of all lanes: constants, per-draw values, loop counters.
    pub registers: u32,
}

/// The tapes of a module, vertex stage first.
///
/// # Errors
/// One line: the module has no tape, or one that cannot be read.
pub fn tape_costs(module: &ShaderModule) -> Result<Vec<TapeCost>, ProgramError> {
    let mut costs: Vec<TapeCost> = programs_from_bytes(&module.tape)?
        .iter()
        .map(|p| TapeCost {
            stage: if p.stage == Stage::Vertex { "vertex" } else { "fragment" },
            operations: p.op_statistics().into_iter().map(|(op, n)| (format!("{op:?}").to_lowercase(), n)).collect(),
            uniform_operations: p.draw_tape.len(),
            texture_reads: p.lane_tape.iter().filter(|i| matches!(i, Instr::Texture { .. })).count(),
            jumps: p.lane_tape.iter().filter(|i| i.target().is_some()).count(),
            slots: p.slots,
            registers: p.registers,
        })
        .collect();
    costs.sort_by_key(|c| c.stage != "vertex");
    Ok(costs)
}
