//! Recognises X displays on which NVIDIA's driver would crash.
//!
//! In: an adapter and a window's display handle. Out: whether the driver would crash if asked about the window. Always: other display systems, and displays
//! that do not answer, count as usable. Not here: creating surfaces.

use super::AdapterFacts;
use wgpu::rwh::{HasDisplayHandle, RawDisplayHandle};

/// Whether NVIDIA's own driver would be used on an X display without the GLX extension. The driver (580.159, found under Xvfb) then calls a null pointer as
/// soon as it is asked for the formats of a surface, which ends the program. Mesa's driver for the same adapters (NVK) does not need the extension.
pub(super) fn may_crash(adapter: &AdapterFacts, window: &impl HasDisplayHandle) -> bool {
    let is_x11 = || window.display_handle().is_ok_and(|d| matches!(d.as_raw(), RawDisplayHandle::Xlib(_) | RawDisplayHandle::Xcb(_)));
    let default_display = None;
    is_nvidia_driver(adapter) && is_x11() && has_glx(default_display) == Some(false)
}

/// Whether NVIDIA's own driver drives the adapter, not Mesa's.
fn is_nvidia_driver(adapter: &AdapterFacts) -> bool {
    adapter.driver.contains("NVIDIA")
}

/// Whether an X display has the GLX extension; `None` if it does not answer. `display`: its name; `None`: the one in the environment variable `DISPLAY`.
#[cfg(all(unix, not(target_os = "macos")))]
fn has_glx(display: Option<&str>) -> Option<bool> {
    use x11rb::connection::RequestConnection;
    let (connection, _) = x11rb::connect(display).ok()?;
    connection.extension_information("GLX").ok().map(|found| found.is_some())
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn has_glx(_display: Option<&str>) -> Option<bool> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::gpu::AdapterKind;

    #[test]
    fn only_the_driver_of_nvidia_needs_glx() {
        let adapter = |name: &str, driver: &str| AdapterFacts {
            name: name.into(),
            backend: "vulkan".into(),
            kind: AdapterKind::Hardware,
            driver: driver.into(),
        };
        assert!(is_nvidia_driver(&adapter("NVIDIA H200", "NVIDIA 580.159.04")));
        assert!(is_nvidia_driver(&adapter("NVIDIA H100 80GB HBM3/PCIe/SSE2", "3.3.0 NVIDIA 580.159.04")));
        assert!(!is_nvidia_driver(&adapter("NVIDIA GeForce RTX 3060 (NVK GA106)", "NVK Mesa 25.1")));
    }

    #[test]
    fn a_display_that_does_not_answer_counts_as_usable() {
        assert_eq!(has_glx(Some("not a display")), None);
    }
}
