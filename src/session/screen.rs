//! A window that the drawing device shows itself.
//!
//! In: a window's handle, and the interface's pieces. Out: what the window shows. Always: a screen belongs to the device that draws the pictures; when that is another
//! one, or none, the window is told so before it shows anything.

use super::Session;
use crate::render::plan::{PictureOnDevice, Piece};

#[cfg(not(feature = "gpu"))]
pub use none::{DeviceScreen, Showable};
#[cfg(feature = "gpu")]
pub use some::{DeviceScreen, Showable};

/// What the user wishes a window to be shown by, where a device draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShowWish {
    /// By a device that is hardware. A driver on the processor would let the window wait for each picture, as long as that takes to draw.
    #[default]
    Auto,
    /// By any device that draws.
    Device,
    Processor,
}

/// What a window is to be shown by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownBy {
    /// As it is now.
    AsBefore,
    /// A device draws, for which the window has no screen yet.
    AnotherDevice,
    /// Software draws, and the processor shows it.
    Processor,
}

#[cfg(feature = "gpu")]
mod some {
    use super::{PictureOnDevice, Piece, Session, ShowWish, ShownBy};
    pub use crate::render::gpu::Showable;
    use crate::render::gpu::{AdapterKind, GpuRenderer, GpuScreen};
    use crate::render::plan;
    use crate::session::gpu_device::Standing;
    use std::sync::Arc;

    pub struct DeviceScreen {
        renderer: Arc<GpuRenderer>,
        screen: GpuScreen,
    }

    impl DeviceScreen {
        /// Whether the picture lies on this screen's device, and can be shown.
        pub fn holds(&self, picture: &PictureOnDevice) -> bool {
            self.renderer.holds(picture)
        }
    }

    impl Session {
        /// What a window with this screen, or none, is to be shown by. Never waits.
        pub fn shown_by(&self, screen: Option<&DeviceScreen>, wish: ShowWish) -> ShownBy {
            let shall = |renderer: &GpuRenderer| match wish {
                ShowWish::Auto => renderer.facts().kind != AdapterKind::Software,
                ShowWish::Device => true,
                ShowWish::Processor => false,
            };
            let standing = match self.devices.standing() {
                Standing::Open(renderer) if !shall(&renderer) => Standing::Software,
                standing => standing,
            };
            match (standing, screen) {
                (Standing::Open(renderer), Some(screen)) if Arc::ptr_eq(&renderer, &screen.renderer) => ShownBy::AsBefore,
                (Standing::Open(renderer), _) if self.is_ready_for_windows(&renderer) => ShownBy::AnotherDevice,
                // What the window's own frames need is being made beside the picture's.
                (Standing::Open(_), _) => ShownBy::AsBefore,
                (Standing::Unchanged, _) | (Standing::Software, None) => ShownBy::AsBefore,
                (Standing::Software, Some(_)) => ShownBy::Processor,
            }
        }

        fn is_ready_for_windows(&self, renderer: &GpuRenderer) -> bool {
            plan::smallest_interface(self).is_ok_and(|plan| renderer.is_ready_for_windows(&plan) == Some(true))
        }

        /// A screen of the device that draws; `None`: none draws just now.
        ///
        /// # Errors
        /// Why the device cannot show anything in this window, in one line.
        pub fn screen(&self, window: impl Showable) -> Option<Result<DeviceScreen, String>> {
            let Standing::Open(renderer) = self.devices.standing() else { return None };
            Some(match renderer.screen(window) {
                Ok(screen) => Ok(DeviceScreen { renderer, screen }),
                Err(e) => Err(e.to_string()),
            })
        }

        /// Shows the interface in the window; false where the system takes no picture just now. `about_to_show` is called only if it does.
        ///
        /// # Errors
        /// Why it cannot, in one line; the screen is of no more use.
        pub fn show(
            &self,
            on: &mut DeviceScreen,
            pieces: Vec<Piece>,
            size: [u32; 2],
            about_to_show: impl FnOnce(),
        ) -> Result<bool, String> {
            let plan = plan::interface(pieces, size, self).map_err(|e| e.to_string())?;
            on.renderer.show(&mut on.screen, &plan, &self.library, about_to_show).map_err(|e| e.to_string())
        }
    }
}

/// Without a GPU renderer there is no such screen.
#[cfg(not(feature = "gpu"))]
mod none {
    use super::{PictureOnDevice, Piece, Session, ShowWish, ShownBy};

    pub enum DeviceScreen {}
    pub trait Showable {}
    impl<T> Showable for T {}

    impl DeviceScreen {
        /// There is no such screen.
        pub fn holds(&self, _: &PictureOnDevice) -> bool {
            match *self {}
        }
    }

    impl Session {
        /// What a window is to be shown by: the processor, as ever.
        pub fn shown_by(&self, _: Option<&DeviceScreen>, _: ShowWish) -> ShownBy {
            ShownBy::AsBefore
        }

        /// No device draws.
        pub fn screen(&self, _: impl Showable) -> Option<Result<DeviceScreen, String>> {
            None
        }

        /// Nothing to show on.
        ///
        /// # Errors
        /// None: there is no such screen.
        pub fn show(&self, on: &mut DeviceScreen, _: Vec<Piece>, _: [u32; 2], _: impl FnOnce()) -> Result<bool, String> {
            match *on {}
        }
    }
}
