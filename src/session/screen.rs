//! Presentation of the window by the GPU that draws.
//!
//! In: a window's handle, and the primitives of the interface. Out: the presented frame. Always: a surface belongs to the device that draws the pictures; when another device
//! draws, or none, the window learns of it before it presents anything.

use super::Session;
#[cfg(feature = "gpu")]
use crate::render::gpu::GpuError;
use crate::render::plan::{GpuImage, PlanError, UiPrimitive};

#[cfg(not(feature = "gpu"))]
pub use none::{DeviceSurface, WindowHandle};
#[cfg(feature = "gpu")]
pub use some::{DeviceSurface, WindowHandle};

/// The user's preference for presenting the window, where a GPU draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DisplayPreference {
    /// By a hardware GPU. With a software driver the window would block for each frame until it is drawn.
    #[default]
    Auto,
    /// By any GPU that draws.
    Device,
    /// By the CPU, whatever draws.
    Processor,
}

/// How the window is to be presented from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresenterChoice {
    /// No change.
    AsBefore,
    /// By a GPU for which the window has no surface yet.
    AnotherDevice,
    /// By the CPU, because the software renderer draws.
    Processor,
}

/// Why the GPU cannot present in a window.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// No plan for the interface.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device, or the window's surface, failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

#[cfg(feature = "gpu")]
mod some {
    use super::{DisplayError, DisplayPreference, GpuImage, PresenterChoice, Session, UiPrimitive};
    use crate::render::gpu::{self, AdapterKind, GpuRenderer, GpuSurface};
    use crate::render::plan;
    use crate::session::gpu_device::DeviceState;
    use std::sync::Arc;

    /// A window in which a GPU can present.
    pub trait WindowHandle: gpu::WindowHandle {}
    impl<T: gpu::WindowHandle> WindowHandle for T {}

    /// A window's surface and the GPU renderer that it belongs to.
    pub struct DeviceSurface {
        renderer: Arc<GpuRenderer>,
        screen: GpuSurface,
    }

    impl DeviceSurface {
        /// Whether the image is on this surface's device and can be presented.
        pub fn holds(&self, picture: &GpuImage) -> bool {
            self.renderer.holds(picture)
        }
    }

    impl Session {
        /// How a window with this surface, or none, is to be presented. Never blocks.
        pub fn shown_by(&self, screen: Option<&DeviceSurface>, preference: DisplayPreference) -> PresenterChoice {
            let shall = |renderer: &GpuRenderer| match preference {
                DisplayPreference::Auto => renderer.facts().kind != AdapterKind::Software,
                DisplayPreference::Device => true,
                DisplayPreference::Processor => false,
            };
            let standing = match self.devices.standing() {
                DeviceState::Open(renderer) if !shall(&renderer) => DeviceState::Software,
                standing => standing,
            };
            match (standing, screen) {
                (DeviceState::Open(renderer), Some(screen)) if Arc::ptr_eq(&renderer, &screen.renderer) => PresenterChoice::AsBefore,
                (DeviceState::Open(renderer), _) if self.is_ready_for_windows(&renderer) => PresenterChoice::AnotherDevice,
                // The pipelines of the window's own frames are being compiled beside those of the picture.
                (DeviceState::Open(_), _) => PresenterChoice::AsBefore,
                (DeviceState::Unchanged, _) | (DeviceState::Software, None) => PresenterChoice::AsBefore,
                (DeviceState::Software, Some(_)) => PresenterChoice::Processor,
            }
        }

        fn is_ready_for_windows(&self, renderer: &GpuRenderer) -> bool {
            plan::warm_up_interface(self).is_ok_and(|plan| renderer.is_ready_for_windows(&plan) == Some(true))
        }

        /// A surface of the GPU that draws; `None`: no GPU draws at present.
        ///
        /// # Errors
        /// Why the device cannot present in this window, in one line.
        pub fn screen(&self, window: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            let DeviceState::Open(renderer) = self.devices.standing() else { return None };
            Some(match renderer.screen(window) {
                Ok(screen) => Ok(DeviceSurface { renderer, screen }),
                Err(e) => Err(e.into()),
            })
        }

        /// Presents the interface in the window; false if the system accepts no frame at present. `before_present` is called only if it does.
        ///
        /// # Errors
        /// Why it failed, in one line; the surface must be dropped.
        pub fn show(
            &self,
            on: &mut DeviceSurface,
            pieces: Vec<UiPrimitive>,
            size: [u32; 2],
            about_to_show: impl FnOnce(),
        ) -> Result<bool, DisplayError> {
            let plan = plan::interface(pieces, size, self)?;
            Ok(on.renderer.show(&mut on.screen, &plan, &self.library, about_to_show)?)
        }
    }
}

/// A build without the GPU renderer has no such surface.
#[cfg(not(feature = "gpu"))]
mod none {
    use super::{DisplayError, DisplayPreference, GpuImage, PresenterChoice, Session, UiPrimitive};

    /// Has no values.
    pub enum DeviceSurface {}
    /// Any window.
    pub trait WindowHandle {}
    impl<T> WindowHandle for T {}

    impl DeviceSurface {
        /// Never called: there is no such surface.
        pub fn holds(&self, _: &GpuImage) -> bool {
            match *self {}
        }
    }

    impl Session {
        /// Always the CPU.
        pub fn shown_by(&self, _: Option<&DeviceSurface>, _: DisplayPreference) -> PresenterChoice {
            PresenterChoice::AsBefore
        }

        /// Always `None`.
        pub fn screen(&self, _: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            None
        }

        /// Never called: there is no such surface.
        ///
        /// # Errors
        /// None: there is no such screen.
        pub fn show(&self, on: &mut DeviceSurface, _: Vec<UiPrimitive>, _: [u32; 2], _: impl FnOnce()) -> Result<bool, DisplayError> {
            match *on {}
        }
    }
}
