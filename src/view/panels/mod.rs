//! The complete user interface, drawn with egui: the viewport with its labels, and the panels around it.
//!
//! In: finished images, answers to queries, egui's input. Out: egui shapes, jobs for the next image, and queries. Always: the panels change only
//! the [`Viewer`], the settings and their own state; they change the session only by queries; after a failure the last valid image stays visible,
//! together with the reason of the failure. The interface runs without a window, so that tests can press its buttons by name.

mod accessible;
mod angle;
mod body_browser;
mod camera_controls;
mod clock_end;
mod compare;
mod composition;
mod dropped;
mod effects;
mod events;
mod fact;
mod icons;
mod information;
mod input_order;
mod layers;
mod moments;
mod notice;
mod number_field;
mod performance;
mod render_loop;
mod search;
mod shader;
mod share;
mod shortcuts;
mod side_panels;
mod sky_object;
mod star;
mod tab;
mod table;
mod telescope;
mod theme;
mod time_bar;
mod timeline;
mod top_bar;
mod tour;
mod viewport;
mod warning;
mod what_to_see_now;

use self::render_loop::Viewport;
pub use self::share::dialog::{FileDialog, FileRequest};
use crate::scene::effects::Effect;
use crate::scene::request::WarpMesh;
use crate::view::app::body_positions::SessionPositions;
use crate::view::app::exposure_adaptation::ExposureAdaptation;
use crate::view::app::settings::{Settings, scale_within};
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::{Action, Viewer};
use crate::view::language::dates::{minute_in_digits, minute_text};
use crate::view::language::{self, Language, text};
use crate::view::worker::render_worker::RenderWorker;
use parking_lot::Mutex;
use std::sync::Arc;

/// Largest number of lines of the notice (the last messages of the session), and of the reply about dropped files.
const MAX_MESSAGE_LINES: usize = 5;
/// Maximum number of characters of a typed text that an error message quotes.
const MAX_ECHO_CHARS: usize = 60;
/// How long the reply to a user's action is shown, seconds: long enough to read a path.
const REPLY_DURATION_S: f64 = 20.0;

/// How long the message about hidden bars is shown, seconds: it is over the image that the user wants without them.
const IMAGE_ONLY_MESSAGE_S: f64 = 6.0;

/// Declares [`Tab`] with the list of its variants and their names.
macro_rules! tabs {
    ($($tab:ident),* $(,)?) => {
        /// A panel at a side of the viewport. `tab.rs` has a row for each panel, in the same order; docs/panel.md says how to add one.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Tab {
            $($tab),*
        }

        impl Tab {
            /// All panels: digit key `k` opens the panel at index `k - 1`.
            pub const ALL: [Self; [$(stringify!($tab)),*].len()] = [$(Self::$tab),*];

            /// The name under which the settings store the panel. It is the variant's, so that a renamed variant is another panel to old settings.
            fn name(self) -> &'static str {
                match self {
                    $(Self::$tab => stringify!($tab)),*
                }
            }
        }
    };
}

tabs!(Moments, Events, Effects, Shader, Compare, Information, Performance, Share);

/// What a reply is about, which decides what ends it before its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum ReplyKind {
    #[default]
    Other,
    /// It says why a view is not shown; see [`Interface::refuse_view()`].
    RefusedView,
    /// It says why a typed number does not count; empty if the number counts.
    TypedNumber,
    /// It says how the hidden controls come back.
    HiddenControls,
}

/// State of the interface: the viewer and the panels.
pub struct Interface {
    /// The view, the rate of time, flights and the history of views.
    pub viewer: Viewer,
    pub settings: Settings,
    /// The language of all texts from the next frame on.
    pub language: Language,
    /// The open panel, if any.
    pub tab: Option<Tab>,
    /// A second panel, if the user keeps one open on the other side of the viewport.
    pub kept_tab: Option<Tab>,
    /// Whether the panel with the list of bodies is open.
    pub body_browser_shown: bool,
    /// Whether the window had room for that panel beside the others when no edge of a panel was dragged.
    bodies_have_room: bool,
    pub help_shown: bool,
    /// Whether the switches of the Effects panel apply to the selected body only.
    pub edits_selected_body_only: bool,
    /// Whether the user asked to quit.
    pub quit_requested: bool,
    /// Whether the window should be fullscreen.
    pub fullscreen: bool,
    /// Whether only the image is shown, without bars, panels and hints, as for a projector.
    pub image_only: bool,
    /// Whether the GPU that renders the images also presents the window, so that images need not be copied to the CPU.
    pub presents_on_gpu: bool,
    /// An error from before the window opened, which is why the window shows the default view; `None` once the user has closed the message.
    pub warning: Option<String>,
    /// The warp mesh for a projector, if there is one.
    pub warp: Option<Arc<WarpMesh>>,
    /// Function that opens a file dialog of the desktop, if available.
    pub file_dialog: Option<FileDialog>,
    /// The language of the previous frame.
    last_language: Language,
    /// Whether the styles of both themes have been applied to the egui context.
    is_styled: bool,
    /// The control that had the keyboard focus at the end of the last frame.
    last_focus: Option<egui::Id>,
    /// The control that had the keyboard focus in the last frame in which no menu or list was open.
    focused_before_menu: Option<egui::Id>,
    /// The reply to the user's last action, shown over the viewport's lower edge; see [`Self::show_reply()`].
    reply: String,
    /// When the reply disappears, in egui's time (`InputState::time`); `None` from [`Self::show_reply()`] until the next frame, which sets it.
    reply_until_s: Option<f64>,
    reply_kind: ReplyKind,
    /// Why there is no image of the current view.
    failure_reason: Option<String>,
    /// New messages of the session, for example that the renderer has changed, or that a map cannot be read.
    pub session_messages: Arc<Mutex<Vec<String>>>,
    notice: notice::Notice,
    body_browser: body_browser::BodyBrowser,
    search: search::SearchField,
    time_bar: time_bar::TimeBar,
    timeline: timeline::Timeline,
    shader: shader::ShaderPanel,
    compare: compare::ComparePanel,
    information: information::InformationPanel,
    moments: moments::MomentsPanel,
    now_thumbnails: what_to_see_now::NowThumbnails,
    tour: tour::TourPlayer,
    events: events::EventsPanel,
    typed_place: camera_controls::TypedPlace,
    effect_costs: effects::EffectCosts,
    /// The effects in the upper part of the Effects panel; `None` until it is first shown.
    first_effects: Option<Vec<Effect>>,
    performance: performance::PerformancePanel,
    share: share::SharePanel,
    angle: angle::MeasuredAngle,
    viewport: Viewport,
    dropped: dropped::DroppedFiles,
    /// The automatic exposure, which changes smoothly from image to image.
    adaptation: ExposureAdaptation,
}

impl Interface {
    pub fn new(viewer: Viewer, settings: Settings) -> Self {
        let panel_named = |name: Option<&str>| Tab::ALL.into_iter().find(|tab| name == Some(tab.name()));
        let tab = panel_named(settings.panels.open_panel.as_deref());
        Self {
            viewer,
            information: information::InformationPanel::from_settings(&settings),
            tab,
            // No panel is on both sides, whatever the settings file says.
            kept_tab: panel_named(settings.panels.kept_panel.as_deref()).filter(|kept| tab != Some(*kept)),
            body_browser_shown: settings.panels.bodies_shown,
            bodies_have_room: true,
            help_shown: false,
            edits_selected_body_only: false,
            quit_requested: false,
            fullscreen: false,
            image_only: false,
            presents_on_gpu: false,
            warning: None,
            warp: None,
            file_dialog: None,
            is_styled: false,
            last_focus: None,
            focused_before_menu: None,
            reply: String::new(),
            reply_until_s: None,
            reply_kind: ReplyKind::default(),
            failure_reason: None,
            session_messages: Arc::default(),
            language: settings.language.unwrap_or_default(),
            last_language: settings.language.unwrap_or_default(),
            settings,
            notice: notice::Notice::default(),
            body_browser: body_browser::BodyBrowser::default(),
            search: search::SearchField::default(),
            time_bar: time_bar::TimeBar::default(),
            timeline: timeline::Timeline::default(),
            shader: shader::ShaderPanel::default(),
            compare: compare::ComparePanel::default(),
            moments: moments::MomentsPanel::default(),
            now_thumbnails: what_to_see_now::NowThumbnails::default(),
            tour: tour::TourPlayer::default(),
            events: events::EventsPanel::default(),
            typed_place: camera_controls::TypedPlace::default(),
            effect_costs: effects::EffectCosts::default(),
            first_effects: None,
            performance: performance::PerformancePanel::default(),
            share: share::SharePanel::default(),
            angle: angle::MeasuredAngle::default(),
            viewport: Viewport::default(),
            dropped: dropped::DroppedFiles::default(),
            adaptation: ExposureAdaptation::default(),
        }
    }

    /// Runs one frame: advances time, receives images, shows panels, requests the next image.
    pub fn ui(&mut self, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
        self.apply_language(worker);
        let now_s = ui.input(|i| i.time);
        let elapsed_s = if self.viewport.frame_start_s.is_nan() { 0.0 } else { now_s - self.viewport.frame_start_s };
        self.viewport.frame_start_s = now_s;
        let before_tdb_s = self.viewer.view.tdb_s;
        self.viewer.advance(elapsed_s);
        clock_end::stop(self, before_tdb_s, worker);
        tour::advance(self, ui.ctx(), elapsed_s);
        let view_of_tour = self.tour.is_playing().then(|| self.viewer.view.clone());
        // Messages about drivers appear in the Performance panel, not over the image.
        let (about_drivers, other_messages): (Vec<_>, Vec<_>) =
            self.session_messages.lock().drain(..).partition(|line| performance::is_about_drivers(line));
        self.performance.messages.extend(about_drivers);
        self.notice.add(other_messages, now_s);
        // Escape takes back what was typed or chosen, so that the reason why it was refused is about nothing any more.
        let is_about_input = matches!(self.reply_kind, ReplyKind::RefusedView | ReplyKind::TypedNumber);
        let is_withdrawn = is_about_input && number_field::is_escape_pressed(ui);
        if *self.reply_until_s.get_or_insert(now_s + REPLY_DURATION_S) <= now_s || is_withdrawn {
            self.reply.clear();
        }
        self.notice.update(!self.reply.is_empty(), now_s);
        self.receive(ui.ctx(), worker);
        self.style(ui.ctx());
        let theme_preference = match self.settings.dark {
            _ if self.settings.is_red => egui::ThemePreference::Dark,
            Some(true) => egui::ThemePreference::Dark,
            Some(false) => egui::ThemePreference::Light,
            None => egui::ThemePreference::System,
        };
        ui.ctx().set_theme(theme_preference);
        let window_size_at_scale_1 = ui.ctx().content_rect().size() * ui.ctx().zoom_factor();
        let ui_scale = scale_within(self.settings.ui_scale, window_size_at_scale_1.into());
        // The scale changes only while no button is pressed; otherwise its slider would move away from the pointer during a drag.
        if !ui.input(|i| i.pointer.any_down()) && (ui.ctx().zoom_factor() - ui_scale).abs() > 1e-3 {
            ui.ctx().set_zoom_factor(ui_scale);
        }
        let mut actions = Vec::new();
        let panels_before = what_to_see_now::open_panels(self);
        shortcuts::handle_keys(self, ui.ctx(), &mut actions);
        share::update(self, ui.ctx(), worker);
        dropped::update(self, ui.ctx(), worker, &mut actions);
        events::update(self, worker);
        if self.image_only {
            time_bar::update_hidden(self, worker, &mut actions);
        } else {
            egui::Panel::top("top").show(ui, |ui| top_bar::bar(self, ui, worker, &mut actions));
            egui::Panel::bottom("time").show(ui, |ui| time_bar::bar(self, ui, worker, &mut actions));
            side_panels::show(self, ui, worker, &mut actions);
        }
        if let Some(reply) = number_field::take_reply(ui.ctx()) {
            self.show_reply(reply);
            self.reply_kind = ReplyKind::TypedNumber;
        }
        egui::CentralPanel::no_frame().show(ui, |ui| viewport::show(self, ui, worker, &mut actions));
        if self.help_shown && !self.image_only {
            shortcuts::help(self, ui.ctx());
        }
        warning::show(self, ui.ctx());
        what_to_see_now::hide_after_input(self, ui.ctx(), panels_before, &actions);
        tour::pause_after_change(self, view_of_tour);
        let starts_tour = std::mem::take(&mut self.tour.has_started);
        self.last_focus = ui.memory(|m| m.focused());
        let height_px = f64::from(self.viewport.size_px[1]);
        let positions = SessionPositions(worker.session());
        // Every action except a selection may move the view, so the next image is coarse. After a selection the image keeps its full resolution.
        if actions.iter().any(|action| !matches!(action, Action::Select(_))) {
            self.viewport.last_motion_s = now_s;
            if !starts_tour {
                self.tour.pause();
            }
        }
        if actions.iter().any(chooses_view) {
            self.time_bar.forget_search();
            // A reply of this frame, whose time is not set yet, may say why the view that these actions choose is shown in place of another one.
            if self.reply_kind == ReplyKind::RefusedView && self.reply_until_s.is_some() {
                self.reply.clear();
            }
        }
        for action in actions {
            match action {
                Action::Turn(..) | Action::LookAround(..) if !self.viewer.can_turn() => self.show_reply(text!("drag-at-centre")),
                Action::Turn(..) | Action::LookAround(..) => self.settings.hints_followed.drag = true,
                Action::Zoom(_) | Action::ChangeFov(_) => self.settings.hints_followed.scroll = true,
                _ => {}
            }
            if matches!(action, Action::FlyTo(_) | Action::Show(_) | Action::ShowPreset(..)) {
                let view = self.viewer.view_after_flight();
                let name = self.name_of_view(&view);
                self.settings.add_recent(name, view);
            }
            self.viewer.apply(action, height_px, &positions);
        }
        self.request_image(ui.ctx(), worker, now_s);
        ui.ctx().accesskit_node_builder(egui::accesskit_root_id(), |window| window.set_label(self.spoken_title()));
    }

    /// On the first call, sets fonts and styles and registers the plugin [`input_order::InputOrder`]. If this happens before the context's first
    /// frame, egui does not rasterise the glyphs of its default fonts in vain.
    pub(crate) fn style(&mut self, ctx: &egui::Context) {
        if !std::mem::replace(&mut self.is_styled, true) {
            theme::apply(ctx);
            ctx.add_plugin(input_order::InputOrder::default());
        }
    }

    /// Shows the reply to an action of the user, for its full time even if it repeats the last reply.
    pub fn show_reply(&mut self, text: impl Into<String>) {
        self.reply = text.into();
        self.reply_until_s = None;
        self.reply_kind = ReplyKind::Other;
    }

    /// Hides all bars, panels and hints, or shows them again. For some seconds a message says how they come back.
    pub(crate) fn toggle_image_only(&mut self, ctx: &egui::Context) {
        if self.show_controls() {
            return;
        }
        self.image_only = true;
        egui::Popup::close_all(ctx);
        // A control that is not shown has no focus.
        ctx.memory_mut(|m| m.focused().into_iter().for_each(|control| m.surrender_focus(control)));
        self.show_reply(text!("image-only"));
        self.reply_kind = ReplyKind::HiddenControls;
        self.reply_until_s = Some(ctx.input(|i| i.time) + IMAGE_ONLY_MESSAGE_S);
    }

    /// Shows the bars, panels and hints again; returns whether they were hidden.
    pub(crate) fn show_controls(&mut self) -> bool {
        let were_hidden = std::mem::take(&mut self.image_only);
        if were_hidden && self.reply_kind == ReplyKind::HiddenControls {
            self.reply.clear();
        }
        were_hidden
    }

    /// Replies why the view that the user asked for is not shown. The reply ends when the user chooses another view, because it would seem to be about that
    /// one.
    pub(crate) fn refuse_view(&mut self, why: impl Into<String>) {
        self.show_reply(why);
        self.reply_kind = ReplyKind::RefusedView;
    }

    /// The reply to the user's last action; empty if there is none, or once it has disappeared.
    pub fn reply_text(&self) -> &str {
        &self.reply
    }

    /// Sets the language for this frame. If the language has changed, discards or rewrites the stored texts.
    fn apply_language(&mut self, worker: &dyn RenderWorker) {
        language::set(self.language);
        if std::mem::replace(&mut self.last_language, self.language) != self.language {
            self.timeline.rewrite_texts(worker.session().catalog());
            self.now_thumbnails = what_to_see_now::NowThumbnails::default();
            // Of the replies only this one can be written again without what it is about.
            let says_how_controls_return = self.reply_kind == ReplyKind::HiddenControls && !self.reply.is_empty();
            self.reply = if says_how_controls_return { text!("image-only").to_owned() } else { String::new() };
            self.notice.rewrite_text();
            // Why there is no image is written anew when the image is requested again.
            self.viewport.requested.take_if(|_| self.failure_reason.is_some());
            self.search.forget_failure();
            self.information.forget_report();
            self.shader.forget_failures();
            self.compare.forget_failures();
            self.events.rewrite_texts(worker.session().catalog());
        }
    }

    /// Records the time that a frame of the interface itself took, including painting.
    pub(crate) fn record_interface_time(&mut self, duration: std::time::Duration) {
        self.performance.interface_ms = duration.as_secs_f64() * 1e3;
    }

    /// The message over the viewport's lower edge: the reason why there is no image, else the reply to the last action, else the last
    /// messages of the session.
    pub fn message_line(&self) -> &str {
        match (&self.failure_reason, self.reply.as_str()) {
            (Some(why), _) => why,
            (None, "") => self.notice.text(),
            (None, reply) => reply,
        }
    }

    /// Whether an image, a sequence or an animation is being exported.
    pub fn is_saving(&self) -> bool {
        self.share.is_busy()
    }

    /// Whether the program may quit. During an export the first request is refused, with a message, because the rest of the export would be lost.
    pub fn may_quit(&mut self) -> bool {
        let may_quit = self.share.may_quit();
        if !may_quit {
            self.quit_requested = false;
            self.show_reply(text!("export-quit"));
        }
        may_quit
    }

    /// The name of a recent view, and of a bookmark that the user has not named.
    fn name_of_view(&self, view: &ViewState) -> String {
        format!("{} {}", self.viewer.name(view.target), minute_in_digits(view.time()))
    }

    /// The text of the window's title bar.
    pub(crate) fn title(&self) -> String {
        let view = &self.viewer.view;
        format!(
            "{} · {} · {} · Orrery",
            self.viewer.name(view.target),
            minute_text(view.time(), self.settings.time_zone),
            self.viewer.time_rate.label()
        )
    }

    /// The title for screen readers, without the time, because a screen reader would announce each change.
    fn spoken_title(&self) -> String {
        format!("{} · {} · Orrery", self.viewer.name(self.viewer.view.target), self.viewer.time_rate.label())
    }

    /// Shows a saved view.
    pub fn show(&mut self, view: ViewState, worker: &dyn RenderWorker) {
        let positions = SessionPositions(worker.session());
        self.viewer.apply(Action::Show(Box::new(view)), f64::from(self.viewport.size_px[1]), &positions);
    }
}

/// Whether an action shows a view or an instant that the user has chosen, and does not only move the camera or the clock from where they are.
fn chooses_view(action: &Action) -> bool {
    match action {
        Action::FlyAlongList(_)
        | Action::FlyTo(_)
        | Action::StandOn(..)
        | Action::LookAt(_)
        | Action::LookFrom(_)
        | Action::SetTime(_)
        | Action::Now
        | Action::PreviousView
        | Action::NextView
        | Action::Show(_)
        | Action::ShowPreset(..) => true,
        Action::Select(_)
        | Action::Turn(..)
        | Action::LookAround(..)
        | Action::Roll(_)
        | Action::Zoom(_)
        | Action::ChangeFov(_)
        | Action::RotateWithBody(_)
        | Action::Track(_)
        | Action::FaceBody
        | Action::Step(_)
        | Action::RunAt(_)
        | Action::SetSpeed(_)
        | Action::Faster
        | Action::Slower
        | Action::TimeForward
        | Action::TimeBackward
        | Action::TogglePause => false,
    }
}
