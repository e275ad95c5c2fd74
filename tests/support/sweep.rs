//! How much of a long sweep a run does: all of it with `ORRERY_FULL_SWEEPS=1`, which `.ci/run` sets; otherwise a part, chosen by the process id.

use super::switch;

/// Whether every sweep runs in full.
pub fn in_full() -> bool {
    switch::is_on("ORRERY_FULL_SWEEPS")
}

/// Whether this case of a sweep runs: every case in a full run, otherwise one case in `parts`, chosen by the process id.
pub fn runs(case: usize, parts: usize) -> bool {
    in_full() || case % parts == std::process::id() as usize % parts
}
