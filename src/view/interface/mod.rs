//! Everything the window shows, as egui draws it: the sky with its marks, the panels around it.
//!
//! In: the studio's drawings, egui's input. Out: shapes, and orders for the next picture. Always: the panels change nothing but the [`Viewer`]
//! and their own folds; a picture that could not be drawn leaves the last good one and says why. It works without a window, so tests press its
//! buttons by name.

mod browse;
mod clock;
mod effects;
mod keys;
mod sky;

use super::marks::{Lettering, Mark, marks};
use super::sight::Sight;
use super::studio::{Drawing, Order, Studio};
use super::tempo::Tempo;
use super::viewer::{Action, Places, Viewer};
use crate::catalog::NaifId;
use crate::render::plan::Fineness;
use crate::scene::request::{Quality, ViewRequest};
use crate::session::Session;
use crate::time::Instant;
use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use glam::{DMat3, DVec3};

/// What the right side shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    Effects,
}

impl Tab {
    pub const ALL: [Self; 1] = [Self::Effects];

    pub fn title(self) -> &'static str {
        match self {
            Self::Effects => "Effects",
        }
    }
}

/// Names, markers and the like, over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    pub names: bool,
    pub markers: bool,
}

/// After this long without input a whole frame replaces the coarse one.
const STILL_AFTER_S: f64 = 0.18;
/// While time runs no faster than the clock, a picture a second is enough.
const CALM_INTERVAL_S: f64 = 1.0;

/// The state of the interface: the viewer and what is unfolded.
pub struct Interface {
    pub viewer: Viewer,
    pub layers: Layers,
    /// What the right side shows, if anything.
    pub tab: Option<Tab>,
    pub bodies_shown: bool,
    pub help_shown: bool,
    /// Someone asked to leave.
    pub quits: bool,
    /// The last thing worth saying, for the line below the sky.
    pub message: String,
    browse: browse::Browse,
    clock: clock::Clock,
    sky: Sky,
}

/// The picture on screen and how it came there.
struct Sky {
    texture: Option<TextureHandle>,
    drawing: Option<Drawing>,
    ordered: Option<Order>,
    ordered_s: f64,
    moved_s: f64,
    last_s: f64,
    tempo: Tempo,
    /// Pixels of the sky's part of the window.
    size_px: [u32; 2],
    marks: Vec<Mark>,
}

impl Interface {
    pub fn new(viewer: Viewer) -> Self {
        Self {
            viewer,
            layers: Layers { names: true, markers: true },
            tab: None,
            bodies_shown: true,
            help_shown: false,
            quits: false,
            message: String::new(),
            browse: browse::Browse::default(),
            clock: clock::Clock::default(),
            sky: Sky {
                texture: None,
                drawing: None,
                ordered: None,
                ordered_s: f64::NEG_INFINITY,
                moved_s: f64::NEG_INFINITY,
                last_s: f64::NAN,
                tempo: Tempo::default(),
                size_px: [1, 1],
                marks: Vec::new(),
            },
        }
    }

    /// The last good picture.
    pub fn drawing(&self) -> Option<&Drawing> {
        self.sky.drawing.as_ref()
    }

    /// One turn: time passes, pictures arrive, panels are shown, the next picture is ordered.
    pub fn ui(&mut self, ui: &mut egui::Ui, studio: &dyn Studio) {
        let now_s = ui.input(|i| i.time);
        let passed_s = if self.sky.last_s.is_nan() { 0.0 } else { now_s - self.sky.last_s };
        self.sky.last_s = now_s;
        self.viewer.pass(passed_s);
        self.receive(ui.ctx(), studio);
        let mut actions = Vec::new();
        keys::pressed(self, ui.ctx(), &mut actions);
        self.top(ui, studio, &mut actions);
        if self.bodies_shown {
            egui::Panel::left("bodies").default_size(190.0).show(ui, |ui| browse::tree(self, ui, &mut actions));
        }
        if let Some(tab) = self.tab {
            egui::Panel::right("inspector").default_size(330.0).show(ui, |ui| {
                ui.heading(tab.title());
                match tab {
                    Tab::Effects => effects::panel(self, ui),
                }
            });
        }
        egui::CentralPanel::no_frame().show(ui, |ui| sky::show(self, ui, &mut actions));
        if self.help_shown {
            keys::help(self, ui.ctx());
        }
        let height_px = f64::from(self.sky.size_px[1]);
        let places = SessionPlaces(studio.session());
        if !actions.is_empty() {
            self.sky.moved_s = now_s;
        }
        for action in actions {
            self.viewer.apply(action, height_px, &places);
        }
        self.order(ui.ctx(), studio, now_s);
    }

    fn top(&mut self, ui: &mut egui::Ui, studio: &dyn Studio, actions: &mut Vec<Action>) {
        egui::Panel::top("top").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.toggle_value(&mut self.bodies_shown, "Bodies").on_hover_text("The list of bodies (b)");
                browse::search(self, ui, actions);
                if ui.add_enabled(self.viewer.can_go_back(), egui::Button::new("⏴")).on_hover_text("Back (Backspace)").clicked() {
                    actions.push(Action::Back);
                }
                if ui.add_enabled(self.viewer.can_go_ahead(), egui::Button::new("⏵")).on_hover_text("Ahead").clicked() {
                    actions.push(Action::Ahead);
                }
                ui.separator();
                for tab in Tab::ALL {
                    if ui.selectable_label(self.tab == Some(tab), tab.title()).clicked() {
                        self.tab = if self.tab == Some(tab) { None } else { Some(tab) };
                    }
                }
                ui.toggle_value(&mut self.layers.names, "Names").on_hover_text("Names of bodies over the picture (n)");
                ui.toggle_value(&mut self.layers.markers, "Markers").on_hover_text("Markers of small bodies (m)");
                ui.toggle_value(&mut self.help_shown, "?").on_hover_text("Keys and mouse (?)");
            });
        });
        egui::Panel::bottom("time").show(ui, |ui| clock::bar(self, ui, studio, actions));
    }

    /// Takes a finished picture.
    fn receive(&mut self, ctx: &egui::Context, studio: &dyn Studio) {
        match studio.take() {
            None => {}
            Some(Err(why)) => self.message = why,
            Some(Ok(mut drawing)) => {
                self.message.clear();
                let pixels = u64::from(drawing.width) * u64::from(drawing.height);
                if drawing.order.fineness == Fineness::of(Quality::Draft) {
                    self.sky.tempo.learn(pixels, drawing.took_ms);
                }
                let image = colour_image(drawing.width, drawing.height, std::mem::take(&mut drawing.rgba));
                match &mut self.sky.texture {
                    Some(texture) => texture.set(image, TextureOptions::LINEAR),
                    none => *none = Some(ctx.load_texture("sky", image, TextureOptions::LINEAR)),
                }
                self.sky.drawing = Some(drawing);
            }
        }
    }

    fn refresh_marks(&mut self, lettering: &Lettering) {
        let Some(drawing) = &self.sky.drawing else { return };
        let parent = |id: NaifId| self.viewer.subject(id).and_then(|s| s.parent);
        self.sky.marks = marks(&drawing.scene, self.viewer.selected, parent, lettering);
    }

    /// Asks for the picture of the view as it is now, coarse while things move.
    fn order(&mut self, ctx: &egui::Context, studio: &dyn Studio, now_s: f64) {
        let moving = self.viewer.races() || now_s - self.sky.moved_s < STILL_AFTER_S;
        let [width, height] = self.sky.size_px;
        let divisor = if moving { self.sky.tempo.divisor(u64::from(width) * u64::from(height)) } else { 1 };
        let session = studio.session();
        let sight = &self.viewer.sight;
        let request = sight.request(session.catalog(), session.ephemeris(), width.div_ceil(divisor), height.div_ceil(divisor));
        let mut request = match request {
            Ok(r) => r,
            Err(why) => {
                self.message = why;
                return;
            }
        };
        if moving {
            request.quality = Quality::Draft;
        }
        let order = Order { fineness: Fineness::of(request.quality), request };
        let calm = !moving && now_s - self.sky.ordered_s < CALM_INTERVAL_S;
        let stale = self.sky.ordered.as_ref().is_none_or(|last| last.fineness != order.fineness || differs(&last.request, &order.request, calm));
        if stale {
            self.sky.ordered = Some(order.clone());
            self.sky.ordered_s = now_s;
            studio.order(order);
        }
        let waits = [
            self.viewer.frame_interval_s(),
            (moving && !self.viewer.races()).then_some(STILL_AFTER_S - (now_s - self.sky.moved_s) + 0.005),
        ];
        if let Some(wait) = waits.into_iter().flatten().reduce(f64::min) {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(wait.max(0.0)));
        }
    }

    /// For the window's title bar.
    pub fn title(&self) -> String {
        let sight = &self.viewer.sight;
        format!("{} · {} · {} · Orrery", self.viewer.name(sight.target), sight.time().to_utc_iso(), self.viewer.pace.label())
    }

    /// Shows a kept view.
    pub fn show(&mut self, sight: Sight, studio: &dyn Studio) {
        let places = SessionPlaces(studio.session());
        self.viewer.apply(Action::Show(Box::new(sight)), f64::from(self.sky.size_px[1]), &places);
    }
}

/// What drew the picture, how fast.
fn studio_line(interface: &Interface, studio: &dyn Studio) -> String {
    let Some(d) = interface.drawing() else { return "drawing the first picture".into() };
    let _ = studio;
    format!("{} · {}×{} · {:.0} ms", d.by.renderer, d.width, d.height, d.took_ms)
}

/// Whether a new picture is wanted. `calm`: that time alone went on is no reason.
fn differs(last: &ViewRequest, new: &ViewRequest, calm: bool) -> bool {
    if !calm {
        return last != new;
    }
    let at_last = ViewRequest { time: last.time, ..new.clone() };
    let leap_s = new.time.tdb_seconds_past_j2000() - last.time.tdb_seconds_past_j2000();
    *last != at_last || leap_s.abs() > 2.0 * CALM_INTERVAL_S
}

/// Opaque display bytes as egui's picture.
pub(super) fn colour_image(width: u32, height: u32, rgba: Vec<[u8; 4]>) -> ColorImage {
    let pixels = rgba.into_iter().map(|[r, g, b, _]| Color32::from_rgb(r, g, b)).collect();
    ColorImage::new([width as usize, height as usize], pixels)
}

/// The places of a session's ephemeris.
pub struct SessionPlaces<'a>(pub &'a Session);

impl Places for SessionPlaces<'_> {
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3> {
        self.0.ephemeris().state(to, from, time, None).ok().map(|a| a.state.pos_km)
    }
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3> {
        self.0.ephemeris().body_from_icrf(body, time).ok()
    }
}
