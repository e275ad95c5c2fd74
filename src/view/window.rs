//! The event loop: winit events in, egui between, pixels out by a [`Presenter`].
//!
//! In: an [`Interface`] and a session. Out: a window, until it is closed. Always: the window is redrawn only when input, a finished picture or
//! running time asks for it; a thread of its own draws the pictures; a window shrunk to nothing draws nothing.

use super::interface::Interface;
use super::paint::Painter;
use super::present::{Presenter, Unshown};
use super::studio::{Studio, Threaded};
use super::watch::Watch;
use crate::session::Session;
use egui_winit::accesskit_winit;
use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant as Moment};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{StartCause, TouchPhase, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Fullscreen, Window, WindowAttributes, WindowId};

/// The window could not be opened or lost what it needs.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    #[error("no window can be opened here ({0}); to draw to a file: orrery render --target earth -o earth.png")]
    NoDisplay(String),
    #[error("the window stopped: {0}")]
    Stopped(String),
}

/// What wakes the loop besides input.
enum Wake {
    /// A picture or an answer is there.
    Ready,
    Access(accesskit_winit::Event),
}

impl From<accesskit_winit::Event> for Wake {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::Access(event)
    }
}

/// Opens the window and runs until it is closed. `watch`: fragments that are read again when they change.
pub fn run(interface: &mut Interface, session: &Session, watch: Option<&Watch>) -> Result<(), WindowError> {
    let event_loop = EventLoop::with_user_event().build().map_err(|e| WindowError::NoDisplay(plain(&e.to_string())))?;
    let proxy: EventLoopProxy<Wake> = event_loop.create_proxy();
    let bell = Mutex::new(proxy.clone());
    let studio = Threaded::new(session, move || {
        // A loop that has ended wants no waking.
        let _ = bell.lock().unwrap_or_else(PoisonError::into_inner).send_event(Wake::Ready);
    });
    std::thread::scope(|scope| {
        scope.spawn(|| studio.draw());
        scope.spawn(|| studio.answer());
        if let Some(watch) = watch {
            scope.spawn(|| watch.work(&studio, || studio.is_closed()));
        }
        let mut app = App {
            interface,
            studio: &studio,
            proxy,
            egui: egui::Context::default(),
            painter: Painter::default(),
            shown: None,
            refused: false,
            due: None,
            failure: None,
        };
        let ended = event_loop.run_app(&mut app).map_err(|e| WindowError::Stopped(e.to_string()));
        let failure = app.failure.take();
        // The window goes at once; a picture or a driver's compiler that is at work is waited for without it.
        drop(app);
        studio.close();
        ended.and(failure.map_or(Ok(()), Err))
    })
}

/// winit puts its own source line before the reason: the reason alone is for people.
fn plain(message: &str) -> String {
    let after_place = message.rsplit_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(message, |(_, reason)| reason);
    after_place.trim_end_matches('.').to_owned()
}

/// The size to begin with: no larger than the screen, whose scale may leave little room.
fn first_size(event_loop: &ActiveEventLoop) -> LogicalSize<f64> {
    let wished = LogicalSize::new(1280.0, 800.0);
    let screen = event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next());
    let room = screen.map(|s| s.size().to_logical::<f64>(s.scale_factor())).filter(|r| r.width > 0.0 && r.height > 0.0);
    room.map_or(wished, |r| LogicalSize::new(wished.width.min(r.width), wished.height.min(r.height)))
}

/// Tells the desktop which program the window is of, as its desktop file does.
#[cfg(target_os = "linux")]
fn named(attributes: WindowAttributes) -> WindowAttributes {
    winit::platform::wayland::WindowAttributesExtWayland::with_name(attributes, "orrery", "orrery")
}

#[cfg(not(target_os = "linux"))]
fn named(attributes: WindowAttributes) -> WindowAttributes {
    attributes
}

/// On Wayland egui drops the first movement of two fingers, and what it has not used when they are lifted: there each movement counts alike.
fn scrolled_whole(event: WindowEvent) -> Option<WindowEvent> {
    match event {
        WindowEvent::MouseWheel { device_id, delta, phase: TouchPhase::Started } if cfg!(target_os = "linux") => {
            Some(WindowEvent::MouseWheel { device_id, delta, phase: TouchPhase::Moved })
        }
        WindowEvent::MouseWheel { phase: TouchPhase::Ended | TouchPhase::Cancelled, .. } if cfg!(target_os = "linux") => None,
        event => Some(event),
    }
}

struct Shown {
    presenter: Presenter,
    window: Arc<Window>,
    input: egui_winit::State,
    title: String,
    /// As the interface last asked; a desktop may have its own way to it.
    fullscreen: bool,
}

struct App<'a> {
    interface: &'a mut Interface,
    studio: &'a Threaded<'a>,
    proxy: EventLoopProxy<Wake>,
    egui: egui::Context,
    /// The interface's textures, which outlive a window.
    painter: Painter,
    shown: Option<Shown>,
    /// A device was asked to show a window and could not.
    refused: bool,
    /// When the interface wants its next turn.
    due: Option<Moment>,
    failure: Option<WindowError>,
}

impl App<'_> {
    fn open(&self, event_loop: &ActiveEventLoop) -> Result<Shown, String> {
        // Screen readers are served from before the window shows.
        let attributes =
            named(Window::default_attributes()).with_title("Orrery").with_inner_size(first_size(event_loop)).with_visible(false);
        let window = Arc::new(event_loop.create_window(attributes).map_err(|e| e.to_string())?);
        let presenter = Presenter::new(&window, self.refused)?;
        let scale = Some(window.scale_factor() as f32);
        let mut input = egui_winit::State::new(self.egui.clone(), egui::ViewportId::ROOT, &*window, scale, window.theme(), Some(16_384));
        input.init_accesskit(event_loop, &window, self.proxy.clone());
        window.set_visible(true);
        Ok(Shown { presenter, window, input, title: String::new(), fullscreen: false })
    }

    fn redraw(&mut self) -> Result<(), Unshown> {
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let size = shown.window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else { return Ok(()) };
        if let Some(line) = shown.presenter.follow(self.studio.session())? {
            self.interface.hear(line);
        }
        self.interface.on_device = shown.presenter.is_on_device();
        let input = shown.input.take_egui_input(&shown.window);
        let start = Moment::now();
        let mut output = self.egui.run_ui(input, |ui| self.interface.ui(ui, self.studio));
        shown.input.handle_platform_output(&shown.window, std::mem::take(&mut output.platform_output));
        let mut textures = std::mem::take(&mut output.textures_delta);
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.painter.set_texture(id, &delta);
            }
        }
        let primitives = self.egui.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let sky = self.interface.picture_on_device();
        let drawn = shown.presenter.show(self.studio.session(), &self.painter, [width, height], output.pixels_per_point, &primitives, sky);
        self.interface.note_painting(start.elapsed());
        for id in textures.free.drain() {
            self.painter.free_texture(id);
        }
        drawn?;
        let title = self.interface.title();
        if title != shown.title {
            shown.window.set_title(&title);
            shown.title = title;
        }
        if self.interface.fullscreen != shown.fullscreen {
            shown.fullscreen = self.interface.fullscreen;
            shown.window.set_fullscreen(shown.fullscreen.then_some(Fullscreen::Borderless(None)));
        }
        let wait = output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        self.due = Moment::now().checked_add(wait);
        Ok(())
    }

    /// A window that the processor shows takes the place of one that the device showed.
    fn open_anew(&mut self, event_loop: &ActiveEventLoop, why: Option<String>) -> Result<(), String> {
        if let Some(why) = why {
            self.refused = true;
            self.interface.hear(format!("{why}: pictures are shown by the processor"));
        }
        self.shown = None;
        self.interface.on_device = false;
        self.shown = Some(self.open(event_loop)?);
        self.ask_redraw();
        Ok(())
    }

    fn ask_redraw(&self) {
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }
}

impl ApplicationHandler<Wake> for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match self.open(event_loop) {
            Ok(shown) => {
                self.shown = Some(shown);
                self.ask_redraw();
            }
            Err(e) => {
                self.failure = Some(WindowError::NoDisplay(e));
                event_loop.exit();
            }
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.due = None;
            self.ask_redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        if let Wake::Access(event) = wake {
            match event.window_event {
                accesskit_winit::WindowEvent::InitialTreeRequested => self.egui.enable_accesskit(),
                accesskit_winit::WindowEvent::ActionRequested(request) => {
                    if let Some(shown) = &mut self.shown {
                        shown.input.on_accesskit_action_request(request);
                    }
                }
                accesskit_winit::WindowEvent::AccessibilityDeactivated => self.egui.disable_accesskit(),
            }
        }
        self.ask_redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if matches!(event, WindowEvent::RedrawRequested) {
            let shown = match self.redraw() {
                Err(Unshown::ByDevice(why)) => self.open_anew(event_loop, why),
                Err(Unshown::AtAll(why)) => Err(why),
                Ok(()) => Ok(()),
            };
            if let Err(e) = shown {
                self.failure = Some(WindowError::Stopped(e));
                event_loop.exit();
            }
            if self.interface.quits {
                event_loop.exit();
            }
            return;
        }
        let Some(shown) = &mut self.shown else { return };
        let Some(event) = scrolled_whole(event) else { return };
        let wants = shown.input.on_window_event(&shown.window, &event).repaint;
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.ask_redraw(),
            _ if wants => self.ask_redraw(),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        event_loop.set_control_flow(self.due.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_loses_its_source_line() {
        assert_eq!(plain("os error at /a/winit/src/linux/mod.rs:765: neither A nor B is set."), "neither A nor B is set");
        assert_eq!(plain("no such thing"), "no such thing");
    }
}
