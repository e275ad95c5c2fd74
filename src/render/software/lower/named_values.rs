//! The named values captured so far while a program is lowered for inspection, and the additional outputs that they become. `capture.rs` fills this list.

use super::builder::SsaBuilder;
use super::ssa::{SsaInstr, SsaValue};
use crate::render::software::program::LaneOutput;
use crate::render::software::tape::Op;
use std::collections::HashMap;

/// The first location of the outputs for named values; no render target has such a location.
pub(crate) const FIRST_NAMED_LOCATION: u32 = 1000;

/// One named value.
#[derive(Debug)]
pub(crate) struct CapturedValue {
    pub name: String,
    /// One output for each scalar of the named value. Unlike other SSA values it is written several times: with NaN at the start of the program, then wherever
    /// the name gets a value.
    pub output_variables: Vec<SsaValue>,
}

/// The named values captured so far.
#[derive(Debug, Default)]
pub(crate) struct NamedValueCapture {
    pub captured: Vec<CapturedValue>,
    /// Index in `captured` by name.
    pub index_of: HashMap<String, usize>,
    /// By the caller's call path (joined by slashes) and the callee's name: the memory addresses of the naga statements that call it, in order of first
    /// appearance. This order numbers the calls in names (`name#2/`). An address identifies a call even if a loop around it is lowered several times.
    pub call_sites: HashMap<(String, String), Vec<usize>>,
    /// Names of the functions being inlined, outermost first.
    pub call_path: Vec<String>,
}

impl NamedValueCapture {
    /// Initialises every captured value with NaN, at the start of the program.
    pub(crate) fn initialise_with_nan(&self, builder: &mut SsaBuilder) {
        let nan = builder.float(f64::NAN);
        let copies =
            self.output_variables().map(|dst| SsaInstr::Op { dst, op: Op::Copy, args: smallvec::smallvec![nan] }).collect::<Vec<_>>();
        builder.lane_instrs.splice(0..0, copies);
    }
    /// The output variables of all named values, in the order of their locations.
    pub(crate) fn output_variables(&self) -> impl Iterator<Item = SsaValue> {
        self.captured.iter().flat_map(|c| c.output_variables.iter().copied())
    }
    /// One location for each of [`Self::output_variables`], in the same order.
    pub(crate) fn outputs(&self) -> impl Iterator<Item = LaneOutput> {
        (0..self.output_variables().count()).map(|k| LaneOutput::Location {
            index: FIRST_NAMED_LOCATION + k as u32,
            component: 0,
            flat: false,
        })
    }
}
