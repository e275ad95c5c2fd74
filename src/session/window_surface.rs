//! Presents the window with the GPU that renders the images.
//!
//! In: a window's handle, and the primitives of the interface. Out: the presented frame. Always: a surface belongs to the device that renders the images.
//! When another device or the CPU takes over rendering, [`Session::presenter_change`] tells the window to change how it presents.

use super::Session;
#[cfg(feature = "gpu")]
use crate::render::gpu::GpuError;
use crate::render::plan::{GpuImage, PlanError, UiPrimitive};

#[cfg(feature = "gpu")]
pub use with_gpu::{DeviceSurface, WindowHandle};
#[cfg(not(feature = "gpu"))]
pub use without_gpu::{DeviceSurface, WindowHandle};

/// The user's preference for presenting the window while a GPU renders the images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DisplayPreference {
    /// Present with the GPU that renders the images, unless it is a software driver, with which the window would block until each frame is drawn.
    #[default]
    Auto,
    /// Present with the GPU that renders the images, even a software driver.
    #[serde(rename = "device")]
    Gpu,
    /// Present with the CPU, whichever renderer draws.
    #[serde(rename = "processor")]
    Cpu,
}

/// The change, if any, in how the window is presented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresenterChange {
    /// No change.
    Unchanged,
    /// Present with a GPU for which the window has no surface yet.
    NewGpu,
    /// Present with the CPU, because the software renderer draws or the user prefers the CPU.
    Cpu,
}

/// Why the GPU cannot present in a window.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The interface cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device, or the window's surface, failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

#[cfg(feature = "gpu")]
mod with_gpu {
    use super::{DisplayError, DisplayPreference, GpuImage, PresenterChange, Session, UiPrimitive};
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
        window_surface: GpuSurface,
    }

    impl DeviceSurface {
        /// Whether the image is on this surface's device and can be presented.
        pub fn holds(&self, image: &GpuImage) -> bool {
            self.renderer.holds(image)
        }
    }

    impl Session {
        /// Whether and how presentation changes in a window with this surface, or with no surface. Never blocks.
        pub fn presenter_change(&self, window_surface: Option<&DeviceSurface>, preference: DisplayPreference) -> PresenterChange {
            let may_present = |renderer: &GpuRenderer| match preference {
                DisplayPreference::Auto => renderer.facts().kind != AdapterKind::Software,
                DisplayPreference::Gpu => true,
                DisplayPreference::Cpu => false,
            };
            let device_state = match self.devices.device_state() {
                // For presenting, a GPU that may only render counts as no GPU.
                DeviceState::Open(renderer) if !may_present(&renderer) => DeviceState::Software,
                device_state => device_state,
            };
            match (device_state, window_surface) {
                (DeviceState::Open(renderer), Some(window_surface)) if Arc::ptr_eq(&renderer, &window_surface.renderer) => {
                    PresenterChange::Unchanged
                }
                (DeviceState::Open(renderer), _) if self.is_ready_for_windows(&renderer) => PresenterChange::NewGpu,
                // The pipelines of the window's interface are still being compiled, together with those of the images.
                (DeviceState::Open(_), _) => PresenterChange::Unchanged,
                // `DeviceState::Unchanged`: the state of the device is not known now.
                (DeviceState::Unchanged, _) | (DeviceState::Software, None) => PresenterChange::Unchanged,
                (DeviceState::Software, Some(_)) => PresenterChange::Cpu,
            }
        }

        /// Whether the pipelines of the interface are compiled. Also false while the renderer draws a window, because it then answers `None`.
        fn is_ready_for_windows(&self, renderer: &GpuRenderer) -> bool {
            plan::warm_up_interface(self).is_ok_and(|plan| renderer.is_ready_for_windows(&plan) == Some(true))
        }

        /// A surface of the GPU that renders the images; `None` if no GPU renders at the moment.
        ///
        /// # Errors
        /// The reason why the device cannot present in this window, in one line.
        pub fn window_surface(&self, window: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            let DeviceState::Open(renderer) = self.devices.device_state() else { return None };
            Some(match renderer.create_surface(window) {
                Ok(window_surface) => Ok(DeviceSurface { renderer, window_surface }),
                Err(e) => Err(e.into()),
            })
        }

        /// Presents the interface in the window. Returns false if the system accepts no frame at the moment; otherwise `before_present` is called right
        /// before the frame is presented.
        ///
        /// # Errors
        /// The reason for the failure, in one line; the surface must be dropped.
        pub fn show(
            &self,
            device_surface: &mut DeviceSurface,
            primitives: Vec<UiPrimitive>,
            size: [u32; 2],
            before_present: impl FnOnce(),
        ) -> Result<bool, DisplayError> {
            let plan = plan::interface(primitives, size, self)?;
            Ok(device_surface.renderer.present(&mut device_surface.window_surface, &plan, &self.library, before_present)?)
        }
    }
}

/// The same items for a build without the GPU renderer, where no surface exists.
#[cfg(not(feature = "gpu"))]
mod without_gpu {
    use super::{DisplayError, DisplayPreference, GpuImage, PresenterChange, Session, UiPrimitive};

    /// No value of this type exists.
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
        /// No change, since the CPU always presents.
        pub fn presenter_change(&self, _: Option<&DeviceSurface>, _: DisplayPreference) -> PresenterChange {
            PresenterChange::Unchanged
        }

        /// Always `None`.
        pub fn window_surface(&self, _: impl WindowHandle) -> Option<Result<DeviceSurface, DisplayError>> {
            None
        }

        /// Never called: there is no such surface.
        ///
        /// # Errors
        /// None: there is no such surface.
        pub fn show(
            &self,
            device_surface: &mut DeviceSurface,
            _: Vec<UiPrimitive>,
            _: [u32; 2],
            _: impl FnOnce(),
        ) -> Result<bool, DisplayError> {
            match *device_surface {}
        }
    }
}
