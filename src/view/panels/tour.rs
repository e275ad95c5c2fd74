//! Playback of a tour: its text over the viewport, and buttons to pause it, to go from stop to stop, to record it, and to end it.
//!
//! In: a [`Tour`], elapsed time. Out: the view, and a line of text with controls over the viewport's lower edge. Always: moving the view by hand
//! or changing what it shows pauses the tour and keeps the view; the tour does not change the user's quality and panels. Not here: camera paths and views
//! ([`crate::view::app::tour`]).

use super::Interface;
use super::icons::{self, Icon};
use super::share::named;
use crate::files::read_text;
use crate::session::Session;
use crate::view::app::tour::{MAX_BYTES, Tour};
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::{catalog_entry_text, catalog_text, text};
use crate::wording::echo;
use egui::{Align2, Button, Color32, Frame, Label, ProgressBar, Rect, RichText, Vec2};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The open tour, which is playing or paused, and the field for tour files.
#[derive(Default)]
pub(crate) struct TourPlayer {
    /// `None` if no tour is open.
    playback: Option<TourPlayback>,
    /// The file name in the field of *Open tour*.
    pub file_name: String,
    /// Whether a tour was started in this frame; its first view is then among the frame's actions.
    pub has_started: bool,
}

/// An open tour and its state.
struct TourPlayback {
    tour: Arc<Tour>,
    /// Position in the tour, real seconds from its start.
    elapsed_s: f64,
    is_paused: bool,
    /// Whether the user has changed the view since the tour last set it.
    is_view_changed: bool,
}

/// Interval between frames while nothing moves, so that the progress bar advances.
const IDLE_INTERVAL: Duration = Duration::from_millis(200);
/// Largest width of the stop's text, points.
const MAX_TEXT_WIDTH: f32 = 560.0;
/// Smallest width of the stop's text, points; if it were less, the bar would be higher than a small viewport.
const MIN_TEXT_WIDTH: f32 = 260.0;

impl TourPlayer {
    /// Whether a tour is open, be it playing or paused.
    pub(crate) fn is_open(&self) -> bool {
        self.playback.is_some()
    }

    /// Whether a tour is playing, that is, sets the view in each frame.
    pub(crate) fn is_playing(&self) -> bool {
        self.playback.as_ref().is_some_and(|playback| !playback.is_paused)
    }

    /// Pauses the tour; called when the user moves the view or changes what it shows.
    pub(crate) fn pause(&mut self) {
        if let Some(playback) = &mut self.playback {
            playback.is_paused = true;
            playback.is_view_changed = true;
        }
    }

    /// Pauses a playing tour, or continues a paused one. A tour at its end, or whose view the user has changed, does not continue. Returns whether the
    /// tour was paused or continued.
    pub(crate) fn toggle(&mut self) -> bool {
        let Some(playback) = &mut self.playback else { return false };
        if playback.is_paused && (playback.is_view_changed || playback.elapsed_s >= playback.tour.length_s()) {
            return false;
        }
        playback.is_paused = !playback.is_paused;
        playback.is_view_changed = false;
        true
    }

    /// The open tour.
    pub(crate) fn current_tour(&self) -> Option<Arc<Tour>> {
        self.playback.as_ref().map(|playback| Arc::clone(&playback.tour))
    }

    /// Ends the tour and keeps the view; returns whether a tour was open.
    pub(crate) fn end(&mut self) -> bool {
        self.playback.take().is_some()
    }
}

/// Starts a tour, with time paused; *Back* returns to the view before the tour.
pub(crate) fn play(interface: &mut Interface, tour: Tour, actions: &mut Vec<Action>) {
    let first_view = with_quality_of(&interface.viewer.view, tour.at(0.0).view);
    actions.push(Action::Show(Box::new(ViewState { paused: Some(true), ..first_view })));
    interface.tour.playback = Some(TourPlayback { tour: Arc::new(tour), elapsed_s: 0.0, is_paused: false, is_view_changed: false });
    interface.tour.has_started = true;
}

/// Starts a tour given as JSON.
pub(crate) fn start(interface: &mut Interface, session: &Session, json: &str, actions: &mut Vec<Action>) {
    match Tour::parse(json, session, interface.viewer.now()) {
        Ok(tour) => play(interface, tour, actions),
        Err(e) => interface.refuse_view(error_text(&e)),
    }
}

/// Starts the tour in the file that the user named.
pub(crate) fn open(interface: &mut Interface, session: &Session, actions: &mut Vec<Action>) {
    let read = |name: &str| read_text(Path::new(name), MAX_BYTES).map_err(|e| format!("{}: {}", echo(name), error_text(&e)));
    match named(&interface.tour.file_name).and_then(read) {
        Ok(json) => start(interface, session, &json, actions),
        Err(why) => interface.refuse_view(why),
    }
}

/// A tour's view with the quality of the current view, and without a setting of whether time is paused.
fn with_quality_of(current: &ViewState, view: ViewState) -> ViewState {
    ViewState { quality: current.quality, paused: None, ..view }
}

/// Advances the tour by elapsed real time, unless the tour is paused, and sets the view.
pub(crate) fn advance(interface: &mut Interface, ctx: &egui::Context, elapsed_real_s: f64) {
    interface.viewer.is_tour_moving = false;
    let Some(playback) = interface.tour.playback.as_mut().filter(|p| !p.is_paused) else { return };
    playback.elapsed_s += elapsed_real_s.max(0.0);
    let current = playback.tour.at(playback.elapsed_s);
    playback.is_paused = playback.elapsed_s >= playback.tour.length_s();
    interface.viewer.view = with_quality_of(&interface.viewer.view, current.view);
    interface.viewer.is_tour_moving = current.is_changing && !playback.is_paused;
    ctx.request_repaint_after(if current.is_changing { Duration::ZERO } else { IDLE_INTERVAL });
}

/// Pauses the tour if the user has changed the view with a control, such as the switch of a layer: otherwise the next frame would undo the change. A
/// change of the quality does not pause the tour, which keeps the user's quality. `view_of_tour`: the view that a playing tour has set in this frame.
pub(crate) fn pause_after_change(interface: &mut Interface, view_of_tour: Option<ViewState>) {
    let view = &interface.viewer.view;
    if view_of_tour.is_some_and(|of_tour| ViewState { quality: view.quality, ..of_tour } != *view) {
        interface.tour.pause();
    }
}

/// Shows the text and the controls over the viewport's lower edge.
pub(crate) fn show(interface: &mut Interface, ui: &egui::Ui, viewport: Rect) {
    let Some(playback) = &mut interface.tour.playback else { return };
    let stop_index = playback.tour.at(playback.elapsed_s).stop_index;
    let mut chosen_stop = None;
    let (mut end_clicked, mut record_clicked) = (false, false);
    let is_busy = interface.share.is_busy();
    let area = egui::Area::new(ui.scope_id().with("tour")).order(egui::Order::Middle).pivot(Align2::CENTER_BOTTOM);
    let bottom = viewport.center_bottom() - Vec2::new(0.0, 16.0 + interface.viewport.caption_height);
    let shown = area.fixed_pos(bottom).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((viewport.width() - 40.0).clamp(MIN_TEXT_WIDTH, MAX_TEXT_WIDTH));
            ui.add(Label::new(
                RichText::new(text!(
                    "tour-stop",
                    tour = catalog_text("tour", &playback.tour.title),
                    stop = stop_index + 1,
                    stops = playback.tour.stop_count()
                ))
                .small(),
            ));
            let stop_text = catalog_entry_text("tour", &playback.tour.title, &(stop_index + 1).to_string(), playback.tour.text(stop_index));
            let text_label = ui.label(stop_text);
            // Screen readers announce the text although it has no focus.
            ui.ctx().accesskit_node_builder(text_label.id, |node| node.set_live(egui::accesskit::Live::Polite));
            let progress = playback.elapsed_s / playback.tour.length_s().max(1e-9);
            ui.horizontal_wrapped(|ui| {
                let button = |ui: &mut egui::Ui, is_enabled: bool, name: &str, hover: &str| {
                    ui.add_enabled(is_enabled, Button::new(name)).on_hover_text(hover).clicked()
                };
                if button(ui, stop_index > 0, text!("tour-previous"), text!("tour-previous-hint")) {
                    chosen_stop = Some(stop_index - 1);
                }
                let (name, hover) = if playback.is_paused {
                    (text!("tour-play"), text!("tour-play-hint"))
                } else {
                    (text!("tour-pause"), text!("tour-pause-hint"))
                };
                let is_enabled = true;
                if button(ui, is_enabled, name, hover) {
                    playback.is_paused = !playback.is_paused;
                    playback.is_view_changed = false;
                    if playback.elapsed_s >= playback.tour.length_s() {
                        playback.elapsed_s = 0.0;
                    }
                }
                if button(ui, stop_index + 1 < playback.tour.stop_count(), text!("tour-next"), text!("tour-next-hint")) {
                    chosen_stop = Some(stop_index + 1);
                }
                let record = icons::button(ui, Icon::Record, text!("tour-record"));
                let hover = text!("tour-record-hint");
                record_clicked = ui.add_enabled(!is_busy, record).on_hover_text(hover).clicked();
                end_clicked = button(ui, is_enabled, text!("tour-end"), text!("tour-end-hint"));
                let width = ui.available_size_before_wrap().x.max(40.0);
                let bar = ProgressBar::new(progress.clamp(0.0, 1.0) as f32).desired_width(width).desired_height(6.0);
                ui.add(bar.fill(Color32::from_gray(140))).accessible_name(text!("tour-progress"));
            });
        });
    });
    interface.viewport.overlays.push(shown.response.rect);
    if let Some(stop) = chosen_stop {
        playback.elapsed_s = playback.tour.arrival_s(stop);
        playback.is_paused = false;
    }
    if record_clicked {
        playback.is_paused = true;
        interface.share.record_tour();
    }
    if end_clicked {
        interface.tour.end();
    }
}
