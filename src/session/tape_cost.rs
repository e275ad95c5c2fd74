//! Counts the operations of a module on the software renderer.
//!
//! In: a module with its tapes: the lists of operations that the software renderer runs, each on many pixels or vertices (lanes) at once. Out: counts that do
//! not depend on the machine.

use crate::render::software::lower::programs_from_bytes;
use crate::render::software::program::{ProgramError, ShaderStage};
use crate::render::software::tape::Instr;
use crate::shader::ShaderModule;
use std::collections::BTreeMap;

/// Counts of the operations in the program of one stage. Operations in a loop are counted once, not per iteration.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TapeCost {
    /// `vertex` or `fragment`.
    pub stage: &'static str,
    /// Operations per lane by kind, without texture reads and jumps.
    pub operations: BTreeMap<String, usize>,
    /// Operations that run once per draw.
    pub uniform_operations: usize,
    /// Texture samples and loads.
    pub texture_reads: usize,
    /// Jump instructions of branches and loops.
    pub jumps: usize,
    /// Largest number of values per lane that are live at the same time.
    pub slots: u32,
    /// Number of values that all lanes share: constants, per-draw values, loop counters.
    pub registers: u32,
}

/// The cost of each stage of a module, vertex stage first. `ShaderModule::tape` holds a program for each stage; a program has a tape that runs once per draw,
/// and one that runs per batch of lanes.
///
/// # Errors
/// The module has no tape, or its tape is unreadable.
pub fn tape_costs(module: &ShaderModule) -> Result<Vec<TapeCost>, ProgramError> {
    let mut costs: Vec<TapeCost> = programs_from_bytes(&module.tape)?
        .iter()
        .map(|p| TapeCost {
            stage: if p.stage == ShaderStage::Vertex { "vertex" } else { "fragment" },
            operations: p.op_statistics().into_iter().map(|(op, n)| (format!("{op:?}").to_lowercase(), n)).collect(),
            uniform_operations: p.draw_tape.len(),
            texture_reads: p.lane_tape.iter().filter(|i| matches!(i, Instr::Texture { .. })).count(),
            jumps: p.lane_tape.iter().filter(|i| i.target().is_some()).count(),
            slots: p.slot_count,
            registers: p.register_count,
        })
        .collect();
    costs.sort_by_key(|c| c.stage != "vertex");
    Ok(costs)
}
