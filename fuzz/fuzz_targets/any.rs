//! The targets under libFuzzer: `ORRERY_FUZZ=catalog cargo +nightly fuzz run --dev --features coverage any -- -print_funcs=0`.
//!
//! The variable chooses the target. Without the last option libFuzzer looks up the name of each new function, which takes longer than the runs.
#![no_main]

use orrery_fuzz::{TARGETS, Target};
use std::sync::LazyLock;

static TARGET: LazyLock<&Target> = LazyLock::new(|| {
    let name = std::env::var("ORRERY_FUZZ").unwrap_or_default();
    let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
    TARGETS.iter().find(|t| t.name == name).unwrap_or_else(|| panic!("ORRERY_FUZZ is one of {}", names.join(", ")))
});

libfuzzer_sys::fuzz_target!(
    init: {
        // Loads what all runs share, so that the first timed run does not include it.
        if let Some(seed) = (TARGET.seeds)().first() {
            (TARGET.run)(seed);
        }
    },
    |bytes: &[u8]| (TARGET.run)(bytes)
);
