//! Gets pixels into the window: from the GPU that renders the images, or from the CPU, which needs no driver.
//!
//! In: egui's tessellated meshes. Out: the window's next image. Always: a GPU displays the window only while it renders the images too, so that
//! none is read back. A window that a GPU has displayed is never painted by the CPU: some systems would not show that, so a new window replaces it.

use crate::render::plan::GpuImage;
use crate::session::{DeviceSurface, DisplayPreference, PresenterChoice, Session};
use crate::view::window::cpu_painter::{Canvas, Painter};
use crate::view::window::primitives::ui_primitives;
use egui::ClippedPrimitive;
use softbuffer::{Context, Surface};
use std::num::NonZeroU32;
use std::sync::Arc;
use winit::window::Window;

type Pixels = Surface<Arc<Window>, Arc<Window>>;

enum PresentBackend {
    Processor(Pixels),
    Device(Box<DeviceSurface>),
}

/// The presentation of one window.
pub(crate) struct Presenter {
    window: Arc<Window>,
    /// `None` only during a change of backend.
    backend: Option<PresentBackend>,
    /// A GPU failed to present in this window and is not tried again.
    gpu_failed: bool,
}

/// Why a window cannot be presented.
pub(crate) enum PresentError {
    /// The GPU failed, with the reason if it is new; the CPU can present a new window.
    Gpu(Option<String>),
    /// The CPU failed too.
    Cpu(String),
}

fn of_processor(window: &Arc<Window>) -> Result<PresentBackend, String> {
    let context = Context::new(window.clone()).map_err(|e| e.to_string())?;
    Ok(PresentBackend::Processor(Surface::new(&context, window.clone()).map_err(|e| e.to_string())?))
}

impl Presenter {
    /// Starts with the CPU, which needs no driver.
    ///
    /// # Errors
    /// Why the system accepts no pixels.
    pub(crate) fn new(window: &Arc<Window>, gpu_failed: bool) -> Result<Self, String> {
        Ok(Self { window: window.clone(), backend: Some(of_processor(window)?), gpu_failed })
    }

    /// Whether images may stay on the GPU.
    pub(crate) fn is_on_gpu(&self) -> bool {
        matches!(self.backend, Some(PresentBackend::Device(_)))
    }

    /// Whether an image on a GPU can be presented: it must be on the GPU that presents this window.
    pub(crate) fn holds(&self, picture: &GpuImage) -> bool {
        matches!(&self.backend, Some(PresentBackend::Device(screen)) if screen.holds(picture))
    }

    /// Follows the renderer and the preference: the GPU that draws should also present. Returns a message, if any.
    ///
    /// # Errors
    /// The GPU no longer draws, or should no longer present.
    pub(crate) fn follow(&mut self, session: &Session, preference: DisplayPreference) -> Result<Option<String>, PresentError> {
        let screen = match &self.backend {
            Some(PresentBackend::Device(screen)) => Some(&**screen),
            _ => None,
        };
        match session.presenter_choice(screen, preference) {
            PresenterChoice::Unchanged => return Ok(None),
            PresenterChoice::Cpu => return Err(PresentError::Gpu(None)),
            PresenterChoice::OtherGpu if self.gpu_failed => return Ok(None),
            PresenterChoice::OtherGpu => {}
        }
        // Only one backend at a time can own the window's surface.
        let was_on_device = self.is_on_gpu();
        self.backend = None;
        match session.window_surface(self.window.clone()) {
            Some(Ok(screen)) => {
                self.backend = Some(PresentBackend::Device(Box::new(screen)));
                Ok(None)
            }
            Some(Err(why)) if was_on_device => Err(PresentError::Gpu(Some(why.to_string()))),
            Some(Err(why)) => {
                self.gpu_failed = true;
                self.backend = Some(of_processor(&self.window).map_err(PresentError::Cpu)?);
                Ok(Some(format!("{why}: displaying via the CPU")))
            }
            None if was_on_device => Err(PresentError::Gpu(None)),
            None => {
                self.backend = Some(of_processor(&self.window).map_err(PresentError::Cpu)?);
                Ok(None)
            }
        }
    }

    /// Presents the interface, with the sky's image if it is on the GPU. False: the system accepts no frame at present.
    ///
    /// # Errors
    /// Why it failed.
    pub(crate) fn show(
        &mut self,
        session: &Session,
        painter: &Painter,
        [width, height]: [NonZeroU32; 2],
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
        sky: Option<&GpuImage>,
    ) -> Result<bool, PresentError> {
        match &mut self.backend {
            Some(PresentBackend::Device(screen)) => {
                let size = [width.get(), height.get()];
                let ui_primitives = ui_primitives(painter, size, pixels_per_point, primitives, sky);
                // On Wayland the next frame waits for the presentation of this one: after a frame that is never sent there would be no other.
                let before_present = || self.window.pre_present_notify();
                session.show(screen, ui_primitives, size, before_present).map_err(|why| PresentError::Gpu(Some(why.to_string())))
            }
            Some(PresentBackend::Processor(surface)) => {
                let failed = |e: softbuffer::SoftBufferError| PresentError::Cpu(e.to_string());
                surface.resize(width, height).map_err(failed)?;
                let mut buffer = surface.buffer_mut().map_err(failed)?;
                buffer.fill(0);
                let mut canvas = Canvas { width: width.get() as usize, height: height.get() as usize, pixels: &mut buffer };
                painter.paint(&mut canvas, pixels_per_point, primitives);
                self.window.pre_present_notify();
                buffer.present().map_err(failed)?;
                Ok(true)
            }
            None => Err(PresentError::Gpu(None)),
        }
    }
}
