//! The GPU renderer for tests. If there is none, the reason is printed in one line and the test is skipped.
//!
//! `ORRERY_REQUIRE_GPU=1` makes a missing GPU a failure; .ci/run sets it if it finds a driver.

use super::switch;
use orrery::render::gpu::GpuRenderer;

/// The value, if opening succeeded; otherwise `None` and a printed reason, or a panic if a GPU is required.
pub fn or_skipped<T>(opened: Result<T, impl std::fmt::Display>) -> Option<T> {
    match opened {
        Ok(opened) => Some(opened),
        Err(error) if switch::is_on("ORRERY_REQUIRE_GPU") => panic!("ORRERY_REQUIRE_GPU is set, and no GPU draws this: {error}"),
        Err(error) => {
            println!("skipped: {error}");
            None
        }
    }
}

/// The renderer on any adapter, including software drivers.
pub fn gpu() -> Option<GpuRenderer> {
    let renderer = or_skipped(GpuRenderer::open(true))?;
    println!("on {}", renderer.facts());
    Some(renderer)
}
