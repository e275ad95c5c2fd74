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
    /// A lane value for each scalar of the named value, assigned anew wherever the name gets a value.
    pub scalars: Vec<SsaValue>,
}

/// The named values captured so far.
#[derive(Debug, Default)]
pub(crate) struct NamedValueCapture {
    pub captured: Vec<CapturedValue>,
    /// Index in `captured` by name.
    pub index_of: HashMap<String, usize>,
    /// By the caller's call path and the callee's name: the addresses of the call statements, in order of first appearance. An address identifies a call even
    /// if a loop around it is lowered several times.
    pub calls: HashMap<(String, String), Vec<usize>>,
    /// Names of the functions being inlined, outermost first.
    pub call_path: Vec<String>,
}

impl NamedValueCapture {
    /// Initialises every captured value with NaN.
    pub(crate) fn initialise(&self, builder: &mut SsaBuilder) {
        let nan = builder.float(f64::NAN);
        let copies = self.scalars().map(|dst| SsaInstr::Op { dst, op: Op::Copy, args: smallvec::smallvec![nan] }).collect::<Vec<_>>();
        builder.lane_instrs.splice(0..0, copies);
    }
    /// The scalars of all named values, in the order of their outputs.
    pub(crate) fn scalars(&self) -> impl Iterator<Item = SsaValue> {
        self.captured.iter().flat_map(|c| c.scalars.iter().copied())
    }
    /// One output for each of [`Self::scalars`], in the same order.
    pub(crate) fn outputs(&self) -> impl Iterator<Item = LaneOutput> {
        (0..self.scalars().count()).map(|k| LaneOutput::Location { index: FIRST_NAMED_LOCATION + k as u32, component: 0, flat: false })
    }
}
