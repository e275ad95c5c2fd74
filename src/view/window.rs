//! The event loop: winit events in, software frames out through softbuffer. No GPU library is loaded.
//!
//! In: a [`Painter`] that answers a [`Look`] with pixels. Always: the window is redrawn only when something changed or time runs;
//! while the mouse or time moves frames are small, and a full one follows when all is still. A window shrunk to nothing draws nothing.

use super::controls::{Action, Controls, Look};
use softbuffer::{Context, Surface};
use std::num::NonZeroU32;
use std::rc::Rc;
use std::time::{Duration, Instant as Moment};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalPosition};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

/// Pixels of one finished picture, top row first, RGBA.
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<[u8; 4]>,
}

/// What draws for the window.
pub trait Painter {
    /// The picture of a look at this size, or one clear line.
    fn paint(&mut self, look: &Look, width: u32, height: u32) -> Result<Picture, String>;
    /// A line about the look for the title bar.
    fn title(&self, look: &Look) -> String;
}

/// The window could not be opened or lost what it needs.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    #[error("no window can be opened here ({0}); to draw to a file: orrery render --target earth -o earth.png")]
    NoDisplay(String),
    #[error("the window stopped: {0}")]
    Stopped(String),
}

/// After this long without input a full-size frame replaces the small one.
const STILL_AFTER: Duration = Duration::from_millis(180);
/// While moving, frames are drawn at this part of the width and height.
const MOVING_SCALE: u32 = 2;

/// Opens the window and runs until it is closed.
pub fn run(controls: Controls, painter: &mut dyn Painter) -> Result<(), WindowError> {
    let event_loop = EventLoop::new().map_err(|e| WindowError::NoDisplay(plain(&e.to_string())))?;
    let mut app = App {
        controls,
        painter,
        shown: None,
        cursor: PhysicalPosition::new(0.0, 0.0),
        dragging: false,
        last_input: Moment::now(),
        last_tick: Moment::now(),
        last_frame: Moment::now(),
        small: false,
        failure: None,
    };
    event_loop.run_app(&mut app).map_err(|e| WindowError::Stopped(e.to_string()))?;
    app.failure.map_or(Ok(()), Err)
}

/// winit puts its own source line before the reason: the reason alone is for people.
fn plain(message: &str) -> String {
    let after_place = message.rsplit_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(message, |(_, reason)| reason);
    after_place.trim_end_matches('.').to_owned()
}

struct Shown {
    window: Rc<Window>,
    surface: Surface<Rc<Window>, Rc<Window>>,
}

struct App<'a> {
    controls: Controls,
    painter: &'a mut dyn Painter,
    shown: Option<Shown>,
    cursor: PhysicalPosition<f64>,
    dragging: bool,
    last_input: Moment,
    last_tick: Moment,
    last_frame: Moment,
    /// The frame on screen is a small one.
    small: bool,
    failure: Option<WindowError>,
}

fn open(event_loop: &ActiveEventLoop) -> Result<Shown, String> {
    let attributes = Window::default_attributes().with_title("Orrery").with_inner_size(LogicalSize::new(1280, 800));
    let window = Rc::new(event_loop.create_window(attributes).map_err(|e| e.to_string())?);
    let context = Context::new(window.clone()).map_err(|e| e.to_string())?;
    let surface = Surface::new(&context, window.clone()).map_err(|e| e.to_string())?;
    Ok(Shown { window, surface })
}

impl App<'_> {
    fn moved(&mut self) {
        self.last_input = Moment::now();
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn is_moving(&self) -> bool {
        self.dragging || self.controls.time_races() || self.last_input.elapsed() < STILL_AFTER
    }

    fn redraw(&mut self) -> Result<(), String> {
        let moving = self.is_moving();
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let size = shown.window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else { return Ok(()) };
        let scale = if moving { MOVING_SCALE } else { 1 };
        let look = self.controls.look();
        let (w, h) = (width.get().div_ceil(scale), height.get().div_ceil(scale));
        let picture = self.painter.paint(&look, w, h)?;
        shown.surface.resize(width, height).map_err(|e| e.to_string())?;
        let mut buffer = shown.surface.buffer_mut().map_err(|e| e.to_string())?;
        enlarge(&picture, width.get(), height.get(), &mut buffer);
        shown.window.pre_present_notify();
        buffer.present().map_err(|e| e.to_string())?;
        shown.window.set_title(&self.painter.title(&look));
        self.small = scale > 1;
        self.last_frame = Moment::now();
        Ok(())
    }
}

/// Fills 0RGB pixels by nearest neighbour.
fn enlarge(picture: &Picture, width: u32, height: u32, out: &mut [u32]) {
    for (y, row) in out.chunks_exact_mut(width as usize).enumerate().take(height as usize) {
        let sy = (y as u64 * u64::from(picture.height) / u64::from(height)) as usize;
        let source = &picture.rgba[sy * picture.width as usize..(sy + 1) * picture.width as usize];
        for (x, pixel) in row.iter_mut().enumerate() {
            let sx = (x as u64 * u64::from(picture.width) / u64::from(width)) as usize;
            let [r, g, b, _] = source[sx];
            *pixel = u32::from_be_bytes([0, r, g, b]);
        }
    }
}

fn action_of(key: &Key) -> Option<Action> {
    Some(match key {
        Key::Named(NamedKey::Escape) => Action::Quit,
        Key::Named(NamedKey::Space) => Action::TogglePause,
        Key::Named(NamedKey::ArrowRight) => Action::Turn(24.0, 0.0),
        Key::Named(NamedKey::ArrowLeft) => Action::Turn(-24.0, 0.0),
        Key::Named(NamedKey::ArrowUp) => Action::Turn(0.0, 24.0),
        Key::Named(NamedKey::ArrowDown) => Action::Turn(0.0, -24.0),
        Key::Named(NamedKey::PageUp) => Action::PreviousBody,
        Key::Named(NamedKey::PageDown | NamedKey::Tab) => Action::NextBody,
        Key::Character(c) => match c.as_str() {
            "q" => Action::Quit,
            "n" => Action::NextBody,
            "p" => Action::PreviousBody,
            "+" | "=" => Action::Zoom(1.0),
            "-" => Action::Zoom(-1.0),
            "." => Action::Faster,
            "," => Action::Slower,
            "l" => Action::Forward,
            "j" => Action::Backward,
            "t" => Action::Now,
            _ => return None,
        },
        _ => return None,
    })
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match open(event_loop) {
            Ok(shown) => {
                self.shown = Some(shown);
                self.moved();
            }
            Err(e) => {
                self.failure = Some(WindowError::NoDisplay(e));
                event_loop.exit();
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.moved(),
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => match action_of(&event.logical_key) {
                Some(Action::Quit) => event_loop.exit(),
                Some(action) => {
                    self.controls.apply(action, self.height_px());
                    self.moved();
                }
                None => {}
            },
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.dragging = state == ElementState::Pressed;
                self.moved();
            }
            WindowEvent::CursorMoved { position, .. } => {
                let (dx, dy) = (position.x - self.cursor.x, position.y - self.cursor.y);
                self.cursor = position;
                if self.dragging {
                    self.controls.apply(Action::Turn(dx, dy), self.height_px());
                    self.moved();
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, y) => f64::from(y),
                    MouseScrollDelta::PixelDelta(p) => p.y / 40.0,
                };
                self.controls.apply(Action::Zoom(notches), self.height_px());
                self.moved();
            }
            WindowEvent::RedrawRequested => {
                if let Err(e) = self.redraw() {
                    self.failure = Some(WindowError::Stopped(e));
                    event_loop.exit();
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let passed = self.last_tick.elapsed().as_secs_f64();
        self.last_tick = Moment::now();
        self.controls.pass(passed);
        let Some(shown) = &self.shown else { return };
        // What is still to come: the next tick of time, or the full frame once all is still.
        let settle = self.small.then_some(STILL_AFTER);
        let tick = self.controls.frame_interval_s().map(Duration::from_secs_f64);
        let Some(wait) = settle.into_iter().chain(tick).min() else {
            event_loop.set_control_flow(ControlFlow::Wait);
            return;
        };
        if self.last_frame.elapsed() >= wait && (tick.is_some_and(|t| self.last_frame.elapsed() >= t) || !self.is_moving()) {
            shown.window.request_redraw();
        }
        event_loop.set_control_flow(ControlFlow::WaitUntil(Moment::now() + wait.min(Duration::from_millis(40))));
    }
}

impl App<'_> {
    fn height_px(&self) -> f64 {
        self.shown.as_ref().map_or(1.0, |s| f64::from(s.window.inner_size().height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_fills_the_window() {
        let picture = Picture { width: 2, height: 1, rgba: vec![[255, 0, 0, 255], [0, 0, 255, 255]] };
        let mut out = vec![0; 5 * 3];
        enlarge(&picture, 5, 3, &mut out);
        assert_eq!(&out[..5], &[0xff0000, 0xff0000, 0xff0000, 0x0000ff, 0x0000ff]);
        assert_eq!(&out[10..], &out[..5]);
    }

    #[test]
    fn a_reason_loses_its_source_line() {
        assert_eq!(plain("os error at /a/winit/src/linux/mod.rs:765: neither A nor B is set."), "neither A nor B is set");
        assert_eq!(plain("no such thing"), "no such thing");
    }

    #[test]
    fn keys_have_actions_and_others_none() {
        assert_eq!(action_of(&Key::Character("n".into())), Some(Action::NextBody));
        assert_eq!(action_of(&Key::Character("§".into())), None);
    }
}
