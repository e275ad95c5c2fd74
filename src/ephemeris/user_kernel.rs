//! The kernel of the user.
//!
//! In: an ephemeris and the bytes of an SPK. Out: the ephemeris with this kernel, which has precedence over the shipped one. Always: the first segments of
//! all pairs of target and centre form no cycle, neither among themselves nor with the origins that other sources give; in a cycle, no chain of origins would
//! end at the solar system's barycentre.

use super::{BEST_SOURCE, Ephemeris, EphemerisError, spk};
use crate::catalog::NaifId;
use crate::time::Instant;
use std::collections::BTreeMap;

impl Ephemeris {
    /// Adds the user's SPK (bytes of the file) with precedence over the shipped kernel.
    ///
    /// # Errors
    /// The bytes are not an SPK that can be read, or its centres form a cycle.
    pub fn with_kernel(mut self, name: &str, bytes: Vec<u8>) -> Result<Self, EphemerisError> {
        let kernel = spk::Spk::parse(name, &bytes)?;
        // The first span of each pair of target and centre, because a kernel may have 100,000 segments. A cycle that only later spans form is found when a
        // state is asked for.
        let mut spans = BTreeMap::new();
        for segment in kernel.segments() {
            spans.entry((segment.target, segment.center)).or_insert((segment.start_s, segment.end_s));
        }
        self.kernels.insert(0, kernel);
        for ((target, _), (start_s, end_s)) in spans {
            for tdb_s in [0.5 * (start_s + end_s), start_s, end_s] {
                if let Some(cycle) = self.cycle_of_centres(NaifId(target), Instant::from_tdb_seconds_past_j2000(tdb_s)) {
                    return Err(EphemerisError::other(format!("kernel {name}: its segments lead to a cycle of centres: {cycle}")));
                }
            }
        }
        Ok(self)
    }

    /// The cycle that the origins above a target form at `t`, such as `Earth relative to Moon relative to Earth`.
    fn cycle_of_centres(&self, target: NaifId, t: Instant) -> Option<String> {
        let mut passed = Vec::new();
        for (_, current) in self.chain(target, t, BEST_SOURCE).targets() {
            if let Some(first) = passed.iter().position(|earlier| *earlier == current) {
                let names: Vec<String> = passed[first..].iter().chain([&current]).map(|id| self.name_of(*id)).collect();
                return Some(names.join(" relative to "));
            }
            passed.push(current);
        }
        None
    }
}
