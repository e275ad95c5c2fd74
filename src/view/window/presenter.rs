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

/// The way in which one window is shown.
pub struct Presenter {
    window: Arc<Window>,
    /// `None` only while one way is exchanged for another.
    way: Option<PresentBackend>,
    /// A device could not show this window: it is not asked again.
    refused: bool,
}

/// Why a window shows nothing.
pub enum Unshown {
    /// The device cannot, for this reason if it is news: the processor can, in a new window.
    ByDevice(Option<String>),
    /// Nothing can.
    AtAll(String),
}

fn of_processor(window: &Arc<Window>) -> Result<PresentBackend, String> {
    let context = Context::new(window.clone()).map_err(|e| e.to_string())?;
    Ok(PresentBackend::Processor(Surface::new(&context, window.clone()).map_err(|e| e.to_string())?))
}

impl Presenter {
    /// By the processor at first: that waits for no driver.
    ///
    /// # Errors
    /// Why the system takes no pixels.
    pub fn new(window: &Arc<Window>, refused: bool) -> Result<Self, String> {
        Ok(Self { window: window.clone(), way: Some(of_processor(window)?), refused })
    }

    /// Whether pictures may stay on the device.
    pub fn is_on_gpu(&self) -> bool {
        matches!(self.way, Some(PresentBackend::Device(_)))
    }

    /// Whether a picture that stayed on a device can be shown: it lies on the one that shows this window.
    pub fn holds(&self, picture: &GpuImage) -> bool {
        matches!(&self.way, Some(PresentBackend::Device(screen)) if screen.holds(picture))
    }

    /// Follows the renderer and the wish: the device that draws shall show, too. Answers a line worth saying.
    ///
    /// # Errors
    /// The device draws no more, or shall not show.
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
        // A window has one owner of its pixels at a time.
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

    /// Shows the interface, with the sky's picture where that lies on the device. False: the system takes no picture just now.
    ///
    /// # Errors
    /// Why not.
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
                // On Wayland the next turn waits until the system has shown this one: a picture that is never sent would be the last.
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
