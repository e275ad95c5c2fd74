//! Gets pixels into the window: from the GPU that renders the images, or from the CPU, which needs no driver.
//!
//! In: egui's tessellated meshes. Out: the window's next image. Always: a GPU displays the window only while it renders the images too, so that
//! none is read back. A window that a GPU has displayed is never painted by the CPU: some systems would not show that, so a new window replaces it.

use crate::render::plan::GpuImage;
use crate::session::{DeviceSurface, DisplayPreference, PresenterChoice, Session};
use crate::view::window::cpu_painter::{Canvas, Painter};
use crate::view::window::primitives::pieces;
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
pub struct Presenter {
    window: Arc<Window>,
    /// `None` only during a change of backend.
    way: Option<PresentBackend>,
    /// A GPU failed to present in this window and is not tried again.
    refused: bool,
}

/// Why a window cannot be presented.
pub enum Unshown {
    /// The GPU failed, with the reason if it is new; the CPU can present a new window.
    ByDevice(Option<String>),
    /// The CPU failed too.
    AtAll(String),
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
    pub fn new(window: &Arc<Window>, refused: bool) -> Result<Self, String> {
        Ok(Self { window: window.clone(), way: Some(of_processor(window)?), refused })
    }

    /// Whether images may stay on the GPU.
    pub fn is_on_gpu(&self) -> bool {
        matches!(self.way, Some(PresentBackend::Device(_)))
    }

    /// Whether an image on a GPU can be presented: it must be on the GPU that presents this window.
    pub fn holds(&self, picture: &GpuImage) -> bool {
        matches!(&self.way, Some(PresentBackend::Device(screen)) if screen.holds(picture))
    }

    /// Follows the renderer and the preference: the GPU that draws should also present. Returns a message, if any.
    ///
    /// # Errors
    /// The GPU no longer draws, or should no longer present.
    pub fn follow(&mut self, session: &Session, preference: DisplayPreference) -> Result<Option<String>, Unshown> {
        let screen = match &self.way {
            Some(PresentBackend::Device(screen)) => Some(&**screen),
            _ => None,
        };
        match session.shown_by(screen, preference) {
            PresenterChoice::AsBefore => return Ok(None),
            PresenterChoice::Processor => return Err(Unshown::ByDevice(None)),
            PresenterChoice::AnotherDevice if self.refused => return Ok(None),
            PresenterChoice::AnotherDevice => {}
        }
        // Only one backend at a time can own the window's surface.
        let was_on_device = self.is_on_gpu();
        self.way = None;
        match session.screen(self.window.clone()) {
            Some(Ok(screen)) => {
                self.way = Some(PresentBackend::Device(Box::new(screen)));
                Ok(None)
            }
            Some(Err(why)) if was_on_device => Err(Unshown::ByDevice(Some(why.to_string()))),
            Some(Err(why)) => {
                self.refused = true;
                self.way = Some(of_processor(&self.window).map_err(Unshown::AtAll)?);
                Ok(Some(format!("{why}: displaying via the CPU")))
            }
            None if was_on_device => Err(Unshown::ByDevice(None)),
            None => {
                self.way = Some(of_processor(&self.window).map_err(Unshown::AtAll)?);
                Ok(None)
            }
        }
    }

    /// Presents the interface, with the sky's image if it is on the GPU. False: the system accepts no frame at present.
    ///
    /// # Errors
    /// Why it failed.
    pub fn show(
        &mut self,
        session: &Session,
        painter: &Painter,
        [width, height]: [NonZeroU32; 2],
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
        sky: Option<&GpuImage>,
    ) -> Result<bool, Unshown> {
        match &mut self.way {
            Some(PresentBackend::Device(screen)) => {
                let size = [width.get(), height.get()];
                let pieces = pieces(painter, size, pixels_per_point, primitives, sky);
                // On Wayland the next frame waits for the presentation of this one: after a frame that is never sent there would be no other.
                let about_to_show = || self.window.pre_present_notify();
                session.show(screen, pieces, size, about_to_show).map_err(|why| Unshown::ByDevice(Some(why.to_string())))
            }
            Some(PresentBackend::Processor(surface)) => {
                let failed = |e: softbuffer::SoftBufferError| Unshown::AtAll(e.to_string());
                surface.resize(width, height).map_err(failed)?;
                let mut buffer = surface.buffer_mut().map_err(failed)?;
                buffer.fill(0);
                let mut canvas = Canvas { width: width.get() as usize, height: height.get() as usize, pixels: &mut buffer };
                painter.paint(&mut canvas, pixels_per_point, primitives);
                self.window.pre_present_notify();
                buffer.present().map_err(failed)?;
                Ok(true)
            }
            None => Err(Unshown::ByDevice(None)),
        }
    }
}
