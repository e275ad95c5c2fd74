//! The event loop: passes winit events to egui and presents egui's output through a `Presenter`.
//!
//! In: an [`Interface`] and a session. Out: a window until the user closes it; its placement is recorded in the settings. Always: the
//! window is redrawn only for input, for a finished image or answer, or at the time for which the interface has asked; images are rendered
//! on a separate thread; nothing is drawn into a window of size zero.

pub mod cpu_painter;
pub mod file_dialog;
mod frame_log;
pub mod night_colours;
mod painter_texture;
pub mod placement;
pub mod presenter;
pub mod primitives;
mod settings_writer;
pub mod shader_watcher;

use crate::files::{WriteError, remove_unfinished};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::session::{Readiness, Session};
use crate::view::app::settings::Settings;
use crate::view::panels::Interface;
use crate::view::window::cpu_painter::Painter;
use crate::view::window::frame_log::{FrameLog, PresentedFrame};
use crate::view::window::placement::{Monitor, WindowPlacement};
use crate::view::window::presenter::{PresentError, Presenter};
use crate::view::window::settings_writer::{SettingsSender, write_changes};
use crate::view::window::shader_watcher::ShaderWatcher;
use crate::view::worker::render_worker::{RenderWorker, ThreadedWorker};
use egui_winit::accesskit_winit;
use parking_lot::Mutex;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant as WallInstant};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalPosition};
use winit::event::{StartCause, TouchPhase, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::monitor::MonitorHandle;
use winit::window::{Fullscreen, Window, WindowAttributes, WindowId};

/// Why the window could not be opened, or why it stopped.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WindowError {
    #[error("no window can be opened here ({0}); to draw to a file: orrery render --target earth -o earth.png")]
    NoDisplay(String),
    #[error("the window stopped: {0}")]
    Stopped(String),
    /// The settings could not be saved when the window was closed.
    #[error(transparent)]
    SettingsNotSaved(WriteError),
}

/// Largest side of a texture that egui may create, texels: the largest possible image must fit.
const MAX_TEXTURE_SIDE: usize = MAX_IMAGE_PX as usize;
/// Time until the next attempt to present a frame, if the system accepted none.
const RETRY_DELAY: Duration = Duration::from_millis(250);
/// Time for which a redraw waits for an image that is being rendered: two frames at 60 Hz. The image will cause a redraw anyway, so that one redraw can
/// serve both.
const IMAGE_WAIT: Duration = Duration::from_millis(33);
/// Longest time for which the program waits for work that is still running when the window is closed.
const SHUTDOWN_GRACE: Duration = Duration::from_millis(250);
/// Interval between checks, within [`SHUTDOWN_GRACE`], whether this work has finished.
const SHUTDOWN_CHECK_INTERVAL: Duration = Duration::from_millis(5);

/// Events that wake the loop, other than winit's window events.
enum Wake {
    /// An image or the answer to a query has arrived.
    Ready,
    Accessibility(accesskit_winit::Event),
}

impl From<accesskit_winit::Event> for Wake {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::Accessibility(event)
    }
}

/// Opens the window and runs until it is closed. `watcher`: watches a folder of shader sources, which are reloaded when they change. `save_settings` is
/// called after changes of the settings, and once more at the end, even if work is still running then. If the window ends with an error, it is called
/// at the end only if the settings have changed.
pub(crate) fn run(
    interface: &mut Interface,
    session: &Session,
    watcher: Option<&ShaderWatcher>,
    save_settings: impl Fn(&Settings) -> Result<(), WriteError> + Sync,
) -> Result<(), WindowError> {
    let event_loop = EventLoop::with_user_event().build().map_err(|e| WindowError::NoDisplay(without_source_location(&e.to_string())))?;
    let proxy: EventLoopProxy<Wake> = event_loop.create_proxy();
    let event_proxy = Mutex::new(proxy.clone());
    let worker = ThreadedWorker::new(session, move || {
        // Fails only if the loop has ended.
        let _ = event_proxy.lock().send_event(Wake::Ready);
    });
    std::thread::scope(|scope| {
        let loaded_settings = interface.settings.clone();
        let (settings_sender, changes) = SettingsSender::new(&loaded_settings);
        let save_settings = &save_settings;
        let writer = scope.spawn(move || {
            // A failure is reported only once, because on a full disk every write would fail.
            let mut is_reported = false;
            write_changes(&changes, |settings| {
                if let Err(e) = save_settings(settings)
                    && !std::mem::replace(&mut is_reported, true)
                {
                    session.notify(&format!("the settings could not be saved: {e}"));
                }
            });
        });
        let workers = [scope.spawn(|| worker.render_until_closed()), scope.spawn(|| worker.run_tasks_until_closed())];
        interface.request_first_image(&worker);
        if let Some(watcher) = watcher {
            scope.spawn(|| watcher.watch_until(&worker, || worker.is_closed()));
        }
        let egui = egui::Context::default();
        interface.style(&egui);
        let mut app = App {
            interface,
            worker: &worker,
            proxy,
            egui,
            painter: Painter::default(),
            opened: None,
            gpu_failed: false,
            next_redraw: None,
            failure: None,
            settings_sender,
            frame_log: FrameLog::of_environment(),
        };
        let loop_result = event_loop.run_app(&mut app).map_err(|e| WindowError::Stopped(e.to_string()));
        let failure = app.failure.take();
        drop(app);
        let _ = writer.join();
        worker.close();
        let result = loop_result.and(failure.map_or(Ok(()), Err));
        // Changes that the settings writer has not written are saved after an error, too. But if no window could be opened, the file stays as it is.
        let must_save = result.is_ok() || interface.settings != loaded_settings;
        let saved = if must_save { save_settings(&interface.settings).map_err(WindowError::SettingsNotSaved) } else { Ok(()) };
        result.and(saved)?;
        let is_work_running = || workers.iter().any(|w| !w.is_finished()) || session.readiness() == Readiness::Preparing;
        let closed_at = WallInstant::now();
        while is_work_running() && closed_at.elapsed() < SHUTDOWN_GRACE {
            std::thread::sleep(SHUTDOWN_CHECK_INTERVAL);
        }
        if is_work_running() && !interface.is_saving() {
            exit_now();
        }
        Ok(())
    })
}

/// Exits the process at once. Called if an image is still being rendered, a query is still being answered, or a driver is still compiling. A normal exit
/// would have to wait for this work, because a driver's exit handlers free memory that the driver's compiler uses. No file is left incomplete: files are
/// written atomically, and temporary ones are removed here.
fn exit_now() -> ! {
    remove_unfinished();
    #[cfg(unix)]
    // SAFETY: `_exit` accepts any status, runs no exit handlers and does not return.
    unsafe {
        libc::_exit(0)
    }
    #[cfg(not(unix))]
    std::process::exit(0)
}

/// Removes the location in winit's source from the start of a message, and the full stop from its end.
fn without_source_location(message: &str) -> String {
    let after_location = message.rsplit_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(message, |(_, reason)| reason);
    after_location.trim_end_matches('.').to_owned()
}

/// All monitors, the primary one first.
fn monitors(event_loop: &ActiveEventLoop) -> Vec<Monitor> {
    let primary = event_loop.primary_monitor();
    let others = event_loop.available_monitors().filter(|m| primary.as_ref() != Some(m));
    primary.iter().cloned().chain(others).map(|m| monitor_info(&m)).collect()
}

fn monitor_info(monitor: &MonitorHandle) -> Monitor {
    Monitor { corner_px: monitor.position().into(), size_px: monitor.size().into(), scale: monitor.scale_factor() }
}

/// The monitor that shows the largest part of a window; `None` if the system does not report the window's position. (winit's own function is out of date
/// on X11: it returns the monitor at the last move event.)
fn monitor_of(window: &Window) -> Option<MonitorHandle> {
    let (corner, size) = (window.outer_position().ok()?.into(), window.outer_size().into());
    let visible_pixels = |m: &MonitorHandle| monitor_info(m).visible_pixel_count(corner, size);
    window.available_monitors().filter(|m| visible_pixels(m) > 0).max_by_key(visible_pixels)
}

/// Sets the application name by which the desktop associates the window with the program's desktop file.
#[cfg(target_os = "linux")]
fn with_app_name(attributes: WindowAttributes) -> WindowAttributes {
    winit::platform::wayland::WindowAttributesExtWayland::with_name(attributes, "orrery", "orrery")
}

#[cfg(not(target_os = "linux"))]
fn with_app_name(attributes: WindowAttributes) -> WindowAttributes {
    attributes
}

/// An event as egui should see it, or `None` if egui should not see it. On Linux, the start of a scroll becomes a movement, and its end is left out.
/// Otherwise egui would lose movements of a two-finger scroll on Wayland: the first one, and those still pending when the fingers are lifted.
fn without_scroll_start_and_end(event: WindowEvent) -> Option<WindowEvent> {
    match event {
        WindowEvent::MouseWheel { device_id, delta, phase: TouchPhase::Started } if cfg!(target_os = "linux") => {
            Some(WindowEvent::MouseWheel { device_id, delta, phase: TouchPhase::Moved })
        }
        WindowEvent::MouseWheel { phase: TouchPhase::Ended | TouchPhase::Cancelled, .. } if cfg!(target_os = "linux") => None,
        event => Some(event),
    }
}

/// The window and what belongs to it.
struct OpenWindow {
    presenter: Presenter,
    window: Arc<Window>,
    input: egui_winit::State,
    title: String,
    /// Whether the interface last requested fullscreen. The desktop may have changed the actual state since.
    requested_fullscreen: bool,
    placement: WindowPlacement,
}

impl OpenWindow {
    /// Records the window's placement. While the window is maximised, fullscreen or minimised, the recorded position and size stay those to which the window
    /// returns.
    fn record_placement(&mut self) {
        let size = self.window.inner_size().to_logical::<f64>(self.window.scale_factor());
        self.placement.maximised = self.window.is_maximized();
        let is_fullscreen_or_minimised = self.window.fullscreen().is_some() || self.window.is_minimized() == Some(true);
        if self.placement.maximised || is_fullscreen_or_minimised || size.width < 1.0 || size.height < 1.0 {
            return;
        }
        self.placement.corner_px = self.window.outer_position().ok().map(Into::into);
        self.placement.size = [size.width, size.height];
    }
}

/// The handler of the event loop.
struct App<'a> {
    interface: &'a mut Interface,
    worker: &'a ThreadedWorker<'a>,
    proxy: EventLoopProxy<Wake>,
    egui: egui::Context,
    /// Stores the interface's textures, which are kept when the window is replaced.
    painter: Painter,
    /// `None` before the window is opened and while it is being replaced.
    opened: Option<OpenWindow>,
    /// Whether a GPU has failed to present; the CPU then presents all later windows.
    gpu_failed: bool,
    /// When the interface needs its next frame.
    next_redraw: Option<WallInstant>,
    /// Why the loop was ended, if not by the user.
    failure: Option<WindowError>,
    settings_sender: SettingsSender,
    frame_log: Option<FrameLog>,
}

impl App<'_> {
    /// Opens the window at its recorded placement, presented by the CPU at first. The error is the reason as text.
    fn open(&self, event_loop: &ActiveEventLoop) -> Result<OpenWindow, String> {
        let placement = self.interface.settings.window_placement.unwrap_or_default().fitted_to(&monitors(event_loop));
        let [width, height] = placement.size;
        // The window is created hidden, because accessibility must be set up before it is shown.
        let mut attributes = with_app_name(Window::default_attributes()).with_title("Orrery").with_visible(false);
        let [min_width, min_height] = placement.min_size();
        attributes =
            attributes.with_inner_size(LogicalSize::new(width, height)).with_min_inner_size(LogicalSize::new(min_width, min_height));
        if let Some([x, y]) = placement.corner_px {
            attributes = attributes.with_position(PhysicalPosition::new(x, y));
        }
        let window = Arc::new(event_loop.create_window(attributes).map_err(|e| e.to_string())?);
        let presenter = Presenter::new(&window, self.gpu_failed)?;
        let scale = Some(window.scale_factor() as f32);
        let mut input =
            egui_winit::State::new(self.egui.clone(), egui::ViewportId::ROOT, &*window, scale, window.theme(), Some(MAX_TEXTURE_SIDE));
        input.init_accesskit(event_loop, &window, self.proxy.clone());
        window.set_visible(true);
        // Window managers can maximise only a visible window.
        if placement.maximised {
            window.set_maximized(true);
        }
        Ok(OpenWindow { presenter, window, input, title: String::new(), requested_fullscreen: false, placement })
    }

    /// Records the window's placement and ends the loop, unless the interface refuses to quit.
    fn close(&mut self, event_loop: &ActiveEventLoop) {
        if !self.interface.may_quit() {
            return self.request_redraw();
        }
        if let Some(opened) = &mut self.opened {
            opened.record_placement();
            self.interface.settings.window_placement = Some(opened.placement);
        }
        event_loop.exit();
    }

    /// Runs one frame of the interface, presents it, and sets the time of the next redraw.
    fn redraw(&mut self) -> Result<(), PresentError> {
        let Some(opened) = &mut self.opened else { return Ok(()) };
        let size = opened.window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else { return Ok(()) };
        if let Some(message) = opened.presenter.update_backend(self.worker.session(), self.interface.settings.presenter_preference)? {
            self.worker.session().notify(&message);
        }
        self.interface.presents_on_gpu = opened.presenter.is_on_gpu();
        let input = opened.input.take_egui_input(&opened.window);
        let start = WallInstant::now();
        let mut output = self.egui.run_ui(input, |ui| self.interface.ui(ui, self.worker));
        opened.input.handle_platform_output(&opened.window, std::mem::take(&mut output.platform_output));
        let mut textures = std::mem::take(&mut output.textures_delta);
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.painter.set_texture(id, delta);
            }
        }
        let mut primitives = self.egui.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        if self.interface.settings.is_red {
            night_colours::make_red(&mut primitives);
        }
        // The image may be on a GPU that does not present this window (any more).
        let is_image_lost = self.interface.gpu_image().is_some_and(|image| !opened.presenter.holds(image));
        if is_image_lost {
            self.interface.drop_gpu_image();
        }
        let scene_image = self.interface.gpu_image();
        let presented =
            opened.presenter.show(self.worker.session(), &self.painter, [width, height], output.pixels_per_point, &primitives, scene_image);
        self.interface.record_interface_time(start.elapsed());
        for id in textures.free.drain() {
            self.painter.free_texture(id);
        }
        self.interface.settings.window_placement = Some(opened.placement);
        self.settings_sender.send_if_changed(&self.interface.settings);
        let is_shown = presented?;
        if let Some(log) = &mut self.frame_log {
            let image = self.interface.shown().map(|rendered| ([rendered.width, rendered.height], rendered.render_ms));
            log.record(&PresentedFrame { images_shown: self.interface.images_shown(), image, took: start.elapsed() });
        }
        let title = self.interface.title();
        if title != opened.title {
            opened.window.set_title(&title);
            opened.title = title;
        }
        if self.interface.fullscreen != opened.requested_fullscreen {
            opened.requested_fullscreen = self.interface.fullscreen;
            opened.window.set_fullscreen(opened.requested_fullscreen.then(|| Fullscreen::Borderless(monitor_of(&opened.window))));
        }
        let repaint_delay = output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        let delay = if is_image_lost {
            Duration::ZERO
        } else if !is_shown {
            repaint_delay.min(RETRY_DELAY)
        } else if self.worker.is_drawing() {
            repaint_delay.max(IMAGE_WAIT)
        } else {
            repaint_delay
        };
        self.next_redraw = WallInstant::now().checked_add(delay);
        Ok(())
    }

    /// Opens a new window in place of one into which a GPU has presented. The CPU presents the new one at first. `why`: the failure of the GPU; `None` if the
    /// GPU has not failed, or if its failure was reported already.
    fn reopen(&mut self, event_loop: &ActiveEventLoop, why: Option<String>) -> Result<(), String> {
        if let Some(why) = why {
            self.gpu_failed = true;
            self.worker.session().notify(&format!("{why}: displaying via the CPU"));
        }
        if let Some(mut opened) = self.opened.take() {
            opened.record_placement();
            self.interface.settings.window_placement = Some(opened.placement);
        }
        self.interface.presents_on_gpu = false;
        self.opened = Some(self.open(event_loop)?);
        self.request_redraw();
        Ok(())
    }

    /// Requests a redraw after the pointer has moved: at once, or, while an image is being rendered, when that image arrives, at the latest after
    /// [`IMAGE_WAIT`].
    fn redraw_with_image(&mut self) {
        if !self.worker.is_drawing() {
            self.request_redraw();
            return;
        }
        let latest = WallInstant::now() + IMAGE_WAIT;
        self.next_redraw = Some(self.next_redraw.map_or(latest, |planned| planned.min(latest)));
    }

    fn request_redraw(&self) {
        if let Some(opened) = &self.opened {
            opened.window.request_redraw();
        }
    }
}

impl ApplicationHandler<Wake> for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.opened.is_some() {
            return;
        }
        match self.open(event_loop) {
            Ok(opened) => {
                self.opened = Some(opened);
                self.request_redraw();
            }
            Err(e) => {
                self.failure = Some(WindowError::NoDisplay(e));
                event_loop.exit();
            }
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.next_redraw = None;
            self.request_redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        if let Wake::Accessibility(event) = wake {
            match event.window_event {
                accesskit_winit::WindowEvent::InitialTreeRequested => self.egui.enable_accesskit(),
                accesskit_winit::WindowEvent::ActionRequested(request) => {
                    if let Some(opened) = &mut self.opened {
                        opened.input.on_accesskit_action_request(request);
                    }
                }
                accesskit_winit::WindowEvent::AccessibilityDeactivated => self.egui.disable_accesskit(),
            }
        }
        self.request_redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if matches!(event, WindowEvent::RedrawRequested) {
            let result = match self.redraw() {
                Err(PresentError::ReplaceWindow(why)) => self.reopen(event_loop, why),
                Err(PresentError::Cpu(why)) => Err(why),
                Ok(()) => Ok(()),
            };
            if let Err(e) = result {
                self.failure = Some(WindowError::Stopped(e));
                event_loop.exit();
            }
            if self.interface.quit_requested {
                self.close(event_loop);
            }
            return;
        }
        let Some(opened) = &mut self.opened else { return };
        let Some(event) = without_scroll_start_and_end(event) else { return };
        let needs_repaint = opened.input.on_window_event(&opened.window, &event).repaint;
        if matches!(event, WindowEvent::Resized(_) | WindowEvent::Moved(_)) {
            opened.record_placement();
        }
        match event {
            WindowEvent::CloseRequested => self.close(event_loop),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.request_redraw(),
            WindowEvent::CursorMoved { .. } if needs_repaint => self.redraw_with_image(),
            _ if needs_repaint => self.request_redraw(),
            _ => {}
        }
    }

    /// Drops the window and its presenter while the connection to the display server is still open; afterwards a driver's surface could crash the
    /// process.
    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.opened = None;
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        event_loop.set_control_flow(self.next_redraw.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_source_location_is_removed_from_a_message() {
        assert_eq!(without_source_location("os error at /a/winit/src/linux/mod.rs:765: neither A nor B is set."), "neither A nor B is set");
        assert_eq!(without_source_location("no such thing"), "no such thing");
    }
}
