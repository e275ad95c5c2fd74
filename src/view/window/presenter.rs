//! Presents the window's content, either on the GPU that renders the images or from CPU memory, which needs no graphics driver.
//!
//! In: egui's tessellated meshes. Out: the window's next frame. Always: a GPU presents the window only while it also renders the images, so
//! that no image is read back. Once a GPU has presented into a window, the CPU never paints into it, because some systems would not show the
//! result; a new window replaces it.

use crate::render::plan::GpuImage;
use crate::session::{DeviceSurface, DisplayPreference, PresenterChange, Session};
use crate::view::window::cpu_painter::{Canvas, Painter};
use crate::view::window::primitives::ui_primitives;
use egui::ClippedPrimitive;
use softbuffer::{Context, Surface};
use std::num::NonZeroU32;
use std::sync::Arc;
use winit::window::Window;

type CpuSurface = Surface<Arc<Window>, Arc<Window>>;

/// What presents a window, with its surface.
enum PresentBackend {
    Cpu(CpuSurface),
    Gpu(Box<DeviceSurface>),
}

/// Presents one window, by the CPU or by a GPU.
pub(crate) struct Presenter {
    window: Arc<Window>,
    /// `None` while the backend changes, and after such a change has failed.
    backend: Option<PresentBackend>,
    /// Whether a GPU has failed to present; this window then tries none again.
    gpu_failed: bool,
}

/// Why a window cannot be presented.
pub(crate) enum PresentError {
    /// The GPU failed or should no longer present. A new window must replace this one; the CPU presents it at first. The text is the failure of the GPU,
    /// if it was not reported yet.
    ReplaceWindow(Option<String>),
    /// The CPU failed to present.
    Cpu(String),
}

/// A backend that presents from CPU memory. The error is the reason as text.
fn cpu_backend(window: &Arc<Window>) -> Result<PresentBackend, String> {
    let context = Context::new(window.clone()).map_err(|e| e.to_string())?;
    Ok(PresentBackend::Cpu(Surface::new(&context, window.clone()).map_err(|e| e.to_string())?))
}

impl Presenter {
    /// A presenter that uses the CPU at first. `gpu_failed`: whether a GPU has failed to present in an earlier window; then none is tried.
    ///
    /// # Errors
    /// If the system provides no pixel buffer; the text is the reason.
    pub(crate) fn new(window: &Arc<Window>, gpu_failed: bool) -> Result<Self, String> {
        Ok(Self { window: window.clone(), backend: Some(cpu_backend(window)?), gpu_failed })
    }

    /// Whether a GPU presents this window, so that images may stay on it.
    pub(crate) fn is_on_gpu(&self) -> bool {
        matches!(self.backend, Some(PresentBackend::Gpu(_)))
    }

    /// Whether an image is on the GPU that presents this window, so that it can be presented.
    pub(crate) fn holds(&self, image: &GpuImage) -> bool {
        matches!(&self.backend, Some(PresentBackend::Gpu(surface)) if surface.holds(image))
    }

    /// Selects the backend that matches the renderer and the user's preference: the GPU that renders should also present. Returns a message
    /// for the user, if any.
    ///
    /// # Errors
    /// [`PresentError::ReplaceWindow`]: the GPU that presents no longer renders or should no longer present, or the GPU that takes over cannot
    /// present in this window. [`PresentError::Cpu`]: no GPU can present, and the system provides no pixel buffer.
    pub(crate) fn update_backend(&mut self, session: &Session, preference: DisplayPreference) -> Result<Option<String>, PresentError> {
        let surface = match &self.backend {
            Some(PresentBackend::Gpu(surface)) => Some(&**surface),
            _ => None,
        };
        match session.presenter_change(surface, preference) {
            PresenterChange::Unchanged => return Ok(None),
            PresenterChange::Cpu => return Err(PresentError::ReplaceWindow(None)),
            PresenterChange::NewGpu if self.gpu_failed => return Ok(None),
            PresenterChange::NewGpu => {}
        }
        // Only one backend at a time can own the window's surface.
        let was_on_gpu = self.is_on_gpu();
        self.backend = None;
        match session.window_surface(self.window.clone()) {
            Some(Ok(surface)) => {
                self.backend = Some(PresentBackend::Gpu(Box::new(surface)));
                Ok(None)
            }
            Some(Err(why)) if was_on_gpu => Err(PresentError::ReplaceWindow(Some(why.to_string()))),
            Some(Err(why)) => {
                self.gpu_failed = true;
                self.backend = Some(cpu_backend(&self.window).map_err(PresentError::Cpu)?);
                Ok(Some(format!("{why}: displaying via the CPU")))
            }
            None if was_on_gpu => Err(PresentError::ReplaceWindow(None)),
            None => {
                self.backend = Some(cpu_backend(&self.window).map_err(PresentError::Cpu)?);
                Ok(None)
            }
        }
    }

    /// Presents the interface. `scene_image`: the rendered view, if it is on the GPU. Returns false if the system accepts no frame at the
    /// moment.
    ///
    /// # Errors
    /// If the backend fails.
    pub(crate) fn show(
        &mut self,
        session: &Session,
        painter: &Painter,
        [width, height]: [NonZeroU32; 2],
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
        scene_image: Option<&GpuImage>,
    ) -> Result<bool, PresentError> {
        match &mut self.backend {
            Some(PresentBackend::Gpu(surface)) => {
                let size = [width.get(), height.get()];
                let ui_primitives = ui_primitives(painter, size, pixels_per_point, primitives, scene_image);
                // After this notification, Wayland delays the next redraw until this frame has been presented. If the frame were then not
                // sent, no redraw would ever follow, so the notification is sent right before presentation.
                let before_present = || self.window.pre_present_notify();
                session.show(surface, ui_primitives, size, before_present).map_err(|why| PresentError::ReplaceWindow(Some(why.to_string())))
            }
            Some(PresentBackend::Cpu(surface)) => {
                let cpu_error = |e: softbuffer::SoftBufferError| PresentError::Cpu(e.to_string());
                surface.resize(width, height).map_err(cpu_error)?;
                let mut buffer = surface.buffer_mut().map_err(cpu_error)?;
                let mut canvas = Canvas { width: width.get() as usize, height: height.get() as usize, pixels: &mut buffer };
                painter.paint(&mut canvas, pixels_per_point, primitives);
                self.window.pre_present_notify();
                buffer.present().map_err(cpu_error)?;
                Ok(true)
            }
            None => Err(PresentError::ReplaceWindow(None)),
        }
    }
}
