//! The program under test.

/// The environment variable that names a program without the optional features. `.ci/run` sets it, so that the same tests drive that program too.
const WITHOUT_FEATURES: &str = "ORRERY_PROGRAM_WITHOUT_FEATURES";

fn without_features() -> Option<String> {
    std::env::var(WITHOUT_FEATURES).ok()
}

/// The program that was built with these tests, or the one without the optional features.
pub fn path() -> String {
    without_features().unwrap_or_else(|| env!("CARGO_BIN_EXE_orrery").into())
}

/// Whether the program under test has the window.
pub fn has_view() -> bool {
    cfg!(feature = "view") && without_features().is_none()
}

/// Whether the program under test has the GPU renderer.
pub fn has_gpu() -> bool {
    cfg!(feature = "gpu") && without_features().is_none()
}
