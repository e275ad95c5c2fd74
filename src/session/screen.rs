//! A window that the drawing device shows itself.
//!
//! In: a window's handle, and the interface's pieces. Out: what the window shows. Always: a screen belongs to the device that draws the pictures; when that is another
//! one, or none, the window is told so before it shows anything.

use super::Session;
#[cfg(feature = "gpu")]
use crate::render::gpu::GpuError;
use crate::render::plan::{GpuImage, PlanError, UiPrimitive};

#[cfg(not(feature = "gpu"))]
pub use none::{DeviceSurface, WindowHandle};
#[cfg(feature = "gpu")]
pub use some::{DeviceSurface, WindowHandle};

/// What the user wishes a window to be shown by, where a device draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DisplayPreference {
    /// By a device that is hardware. A driver on the processor would let the window wait for each picture, as long as that takes to draw.
    #[default]
    Auto,
    /// By any device that draws.
    Device,
    /// By the CPU, whatever draws.
    Processor,
}

/// What a window is to be shown by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresenterChoice {
    /// As it is now.
    AsBefore,
    /// A device draws, for which the window has no screen yet.
    AnotherDevice,
    /// Software draws, and the processor shows it.
    Processor,
}

/// Why a device shows nothing in a window.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The interface's plan cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device, or the window's surface, refuses.
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

    /// A window that a device can show pictures in.
    pub trait WindowHandle: gpu::WindowHandle {}
    impl<T: gpu::WindowHandle> WindowHandle for T {}

    /// What a window shows, and the device that shows it.
    pub struct DeviceSurface {
        renderer: Arc<GpuRenderer>,
        screen: GpuSurface,
    }

    impl DeviceSurface {
        /// Whether the picture lies on this screen's device, and can be shown.
        pub fn holds(&self, picture: &GpuImage) -> bool {
            self.renderer.holds(picture)
        }
    }

    impl Session {
        /// What a window with this screen, or none, is to be shown by. Never waits.
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
                // What the window's own frames need is being made beside the picture's.
                (DeviceState::Open(_), _) => PresenterChoice::AsBefore,
                (DeviceState::Unchanged, _) | (DeviceState::Software, None) => PresenterChoice::AsBefore,
                (DeviceState::Software, Some(_)) => PresenterChoice::Processor,
            }
        }

        fn is_ready_for_windows(&self, renderer: &GpuRenderer) -> bool {
            plan::warm_up_interface(self).is_ok_and(|plan| renderer.is_ready_for_windows(&plan) == Some(true))
        }

        /// A screen of the device that draws; `None`: none draws just now.
        ///
        /// # Errors
        /// Why the device cannot show anything in this window, in one line.
        pub fn screen(&self, window: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            let DeviceState::Open(renderer) = self.devices.standing() else { return None };
            Some(match renderer.create_surface(window) {
                Ok(screen) => Ok(DeviceSurface { renderer, screen }),
                Err(e) => Err(e.into()),
            })
        }

        /// Shows the interface in the window; false where the system takes no picture just now. `about_to_show` is called only if it does.
        ///
        /// # Errors
        /// Why it cannot, in one line; the screen is of no more use.
        pub fn show(
            &self,
            on: &mut DeviceSurface,
            pieces: Vec<UiPrimitive>,
            size: [u32; 2],
            about_to_show: impl FnOnce(),
        ) -> Result<bool, DisplayError> {
            let plan = plan::interface(pieces, size, self)?;
            Ok(on.renderer.present(&mut on.screen, &plan, &self.library, about_to_show)?)
        }
    }
}

/// Without a GPU renderer there is no such screen.
#[cfg(not(feature = "gpu"))]
mod none {
    use super::{DisplayError, DisplayPreference, GpuImage, PresenterChoice, Session, UiPrimitive};

    /// There is none.
    pub enum DeviceSurface {}
    /// Any window.
    pub trait WindowHandle {}
    impl<T> WindowHandle for T {}

    impl DeviceSurface {
        /// There is no such screen.
        pub fn holds(&self, _: &GpuImage) -> bool {
            match *self {}
        }
    }

    impl Session {
        /// What a window is to be shown by: the processor, as ever.
        pub fn shown_by(&self, _: Option<&DeviceSurface>, _: DisplayPreference) -> PresenterChoice {
            PresenterChoice::AsBefore
        }

        /// No device draws.
        pub fn screen(&self, _: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            None
        }

        /// Nothing to show on.
        ///
        /// # Errors
        /// None: there is no such screen.
        pub fn show(&self, on: &mut DeviceSurface, _: Vec<UiPrimitive>, _: [u32; 2], _: impl FnOnce()) -> Result<bool, DisplayError> {
            match *on {}
        }
    }
}
