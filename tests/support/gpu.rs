//! The GPU renderer for tests. If there is none, the reason is printed in one line and the test is skipped.
//!
//! `ORRERY_REQUIRE_GPU=1` makes a missing GPU a failure; .ci/run sets it if it finds a driver.

use orrery::render::gpu::GpuRenderer;

fn is_required(value: Option<&str>) -> bool {
    !matches!(value, None | Some("" | "0"))
}

/// The value, if opening succeeded; otherwise `None` and a printed reason, or a panic if a GPU is required.
pub fn or_skipped<T>(opened: Result<T, impl std::fmt::Display>) -> Option<T> {
    let required = std::env::var("ORRERY_REQUIRE_GPU").ok();
    match opened {
        Ok(opened) => Some(opened),
        Err(error) if is_required(required.as_deref()) => panic!("ORRERY_REQUIRE_GPU is set, and no GPU draws this: {error}"),
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

#[test]
fn a_gpu_is_required_by_any_value_but_zero() {
    assert_eq!([None, Some(""), Some("0"), Some("1"), Some("yes")].map(is_required), [false, false, false, true, true]);
}
