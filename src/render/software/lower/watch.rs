//! The named values that a program shall output, as far as they have been lowered.

use super::builder::Builder;
use super::step::{Step, Val};
use crate::render::software::program::LaneOutput;
use crate::render::software::tape::Op;
use std::collections::HashMap;

/// One named value.
#[derive(Debug)]
pub struct Kept {
    pub name: String,
    pub lanes: Vec<Val>,
}

/// What has been named so far.
#[derive(Debug, Default)]
pub struct NamedValueCapture {
    pub kept: Vec<Kept>,
    pub known: HashMap<String, usize>,
    /// Calls by caller's path and callee, in order of first appearance: a loop's body is lowered several times.
    pub calls: HashMap<(String, String), Vec<usize>>,
    pub path: Vec<String>,
}

impl NamedValueCapture {
    /// Gives every kept value its start.
    pub fn begin(&self, b: &mut Builder) {
        let unknown = b.float(f64::NAN);
        let starts = self.values().map(|dst| Step::Op { dst, op: Op::Copy, args: smallvec::smallvec![unknown] }).collect::<Vec<_>>();
        b.code.splice(0..0, starts);
    }
    pub fn values(&self) -> impl Iterator<Item = Val> {
        self.kept.iter().flat_map(|k| k.lanes.iter().copied())
    }
    /// Locations that no target has.
    pub fn outputs(&self) -> impl Iterator<Item = LaneOutput> {
        (0..self.values().count()).map(|k| LaneOutput::Location { index: 1000 + k as u32, component: 0, flat: false })
    }
}
