//! What GPU drivers expect of an X display.
//!
//! In: a window's display handle. Out: whether a driver of NVIDIA may be asked about the window. Always: other display systems, and displays that do not
//! answer, count as usable. Not here: creating surfaces.

use wgpu::rwh::{HasDisplayHandle, RawDisplayHandle};

/// Whether the window is on an X display without the GLX extension. NVIDIA's Vulkan driver (580.159, found on an H100 under Xvfb without GLX) then calls a null
/// pointer as soon as it is asked for the formats of a surface, which ends the program.
pub(super) fn lacks_glx(window: &impl HasDisplayHandle) -> bool {
    let is_x11 = window.display_handle().is_ok_and(|d| matches!(d.as_raw(), RawDisplayHandle::Xlib(_) | RawDisplayHandle::Xcb(_)));
    is_x11 && has_glx() == Some(false)
}

/// Whether the display that the environment names has the GLX extension; `None` if it does not answer.
#[cfg(all(unix, not(target_os = "macos")))]
fn has_glx() -> Option<bool> {
    use x11rb::connection::RequestConnection;
    let (connection, _) = x11rb::connect(None).ok()?;
    connection.extension_information("GLX").ok().map(|found| found.is_some())
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn has_glx() -> Option<bool> {
    None
}
