//! The targets under libFuzzer: `ORRERY_FUZZ=catalog cargo +nightly fuzz run --features coverage any`. The variable chooses the target.
#![no_main]

use orrery_fuzz::{TARGETS, Target};
use std::sync::LazyLock;

static TARGET: LazyLock<&Target> = LazyLock::new(|| {
    let name = std::env::var("ORRERY_FUZZ").unwrap_or_default();
    let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
    TARGETS.iter().find(|t| t.name == name).unwrap_or_else(|| panic!("ORRERY_FUZZ is one of {}", names.join(", ")))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGET.run)(bytes));
