//! Finding a body: search with completion, and the tree of the system.
//!
//! In: what is typed, clicks. Out: actions. Always: the row that is pressed is the row that is selected, and nothing unfolds while a button is held; a failed search
//! says so at its field and is replaced by what is typed next. It moves nothing but its own rows.

use super::Interface;
use crate::catalog::{BodyKind, NaifId};
use crate::scene::effects::EffectOverrides;
use crate::time::Instant;
use crate::view::app::viewer::{Action, Subject};
use crate::wording::{did_you_mean, echo_within};
use egui::collapsing_header::CollapsingState;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Id, Key, ScrollArea, TextEdit, UiBuilder};

/// Characters of what was typed that a failed search repeats.
const MAX_ECHO_CHARS: usize = 60;
/// Completions shown at once.
const COMPLETIONS: usize = 8;

#[derive(Default)]
pub struct BodyBrowser {
    wanted: String,
    /// Of the completions.
    highlighted: usize,
    /// The search field wants the keyboard.
    pub focus: bool,
    /// Why what was searched is not found, until it is changed.
    failure: Option<String>,
    /// The selection for which the list was last unfolded.
    unfolded_for: Option<NaifId>,
    /// The list itself made that selection: it need not scroll to it.
    clicked: Option<NaifId>,
    /// Scrolled to until its fold has opened.
    shown: Option<NaifId>,
}

impl BodyBrowser {
    /// Leaves the search; what it completes to goes with the text. False: there was nothing to leave.
    pub fn give_up(&mut self) -> bool {
        let had_any = !self.wanted.is_empty() || self.failure.is_some();
        self.wanted.clear();
        self.failure = None;
        had_any
    }
}

/// All of a field's text is selected: what is typed next takes its place.
fn select_all(ctx: &egui::Context, field: Id, text: &str) {
    let mut state = TextEditState::load(ctx, field).unwrap_or_default();
    state.cursor.set_char_range(Some(CCursorRange::two(CCursor::new(0), CCursor::new(text.chars().count()))));
    state.store(ctx, field);
}

/// The search field, with what it completes to below it, or why it found nothing.
pub fn search(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let field = TextEdit::singleline(&mut interface.browse.wanted).hint_text("Search (/)").desired_width(150.0);
    let response = ui.add(field).on_hover_text("Search for a body");
    let is_wanted = std::mem::take(&mut interface.browse.focus);
    if is_wanted {
        response.request_focus();
    }
    if is_wanted || response.gained_focus() {
        select_all(ui.ctx(), response.id, &interface.browse.wanted);
    }
    if response.changed() {
        interface.browse.highlighted = 0;
        interface.browse.failure = None;
    }
    let found: Vec<(NaifId, String)> =
        interface.viewer.completions(&interface.browse.wanted, COMPLETIONS).iter().map(|s| (s.id, s.name.clone())).collect();
    let mut chosen = None;
    let entered = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    if response.has_focus() || entered {
        let (down, up) = ui.input(|i| (i.key_pressed(Key::ArrowDown), i.key_pressed(Key::ArrowUp)));
        let last = found.len().saturating_sub(1);
        interface.browse.highlighted = (interface.browse.highlighted + usize::from(down)).saturating_sub(usize::from(up)).min(last);
    }
    if entered && !interface.browse.wanted.trim().is_empty() {
        chosen = found.get(interface.browse.highlighted).map(|f| f.0);
        match command(interface, actions) {
            Some(Ok(())) => {
                interface.browse.give_up();
                chosen = None;
            }
            Some(Err(why)) => interface.browse.failure = Some(why),
            None if chosen.is_none() => {
                interface.browse.failure = Some(not_found(interface.viewer.subjects(), interface.browse.wanted.trim()));
            }
            None => {}
        }
        if interface.browse.failure.is_some() {
            // Whoever mistyped types again.
            chosen = None;
            response.request_focus();
            select_all(ui.ctx(), response.id, &interface.browse.wanted);
        }
    }
    below(interface, ui, response.rect, &found, &mut chosen);
    if let Some(id) = chosen {
        interface.browse.give_up();
        actions.push(Action::FlyTo(id));
    }
}

/// Why a name is of no body, and which bodies it may have meant.
fn not_found(bodies: &[Subject], typed: &str) -> String {
    let names = bodies.iter().flat_map(|b| std::iter::once(&b.name).chain(&b.aliases)).map(String::as_str);
    let hint = did_you_mean(typed, names).map_or(String::new(), |hint| format!("; {hint}"));
    format!("No body is called “{}”{hint}", echo_within(typed, MAX_ECHO_CHARS))
}

/// What hangs below the search field: completions, or why there are none.
fn below(interface: &Interface, ui: &egui::Ui, field: egui::Rect, found: &[(NaifId, String)], chosen: &mut Option<NaifId>) {
    let failure = interface.browse.failure.as_ref();
    if found.is_empty() && failure.is_none() {
        return;
    }
    let area = egui::Area::new(ui.scope_id().with("completions")).fixed_pos(field.left_bottom()).order(egui::Order::Foreground);
    area.show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            if let Some(why) = failure {
                let line = ui.colored_label(ui.visuals().warn_fg_color, why);
                // Read out by a screen reader while the keyboard stays in the field.
                ui.ctx().accesskit_node_builder(line.id, |node| node.set_live(egui::accesskit::Live::Polite));
            }
            for (i, (id, name)) in found.iter().enumerate() {
                if ui.selectable_label(i == interface.browse.highlighted, name).clicked() {
                    *chosen = Some(*id);
                }
            }
        });
    });
}

/// What is typed besides names: effects as `--effects` takes them, and dates. `None`: it is neither.
fn command(interface: &mut Interface, actions: &mut Vec<Action>) -> Option<Result<(), String>> {
    let typed = interface.browse.wanted.trim().to_owned();
    if typed.starts_with(['+', '-']) && typed.contains(char::is_alphabetic) {
        let view = &mut interface.viewer.view;
        let both = format!("{},{typed}", view.effects.to_text());
        return Some(EffectOverrides::parse(&both).map(|overrides| view.effects = overrides).map_err(|e| e.to_string()));
    }
    match Instant::parse(&typed) {
        Ok(time) if typed.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
            actions.push(Action::SetTime(time));
            Some(Ok(()))
        }
        _ => None,
    }
}

/// The Sun, its planets each with its moons, then the rest.
pub fn tree(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let news = to_unfold(interface, ui);
    let before = actions.len();
    let mut is_opening = false;
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
        let subjects = interface.viewer.subjects();
        let top = |s: &&Subject| s.kind != BodyKind::Moon;
        for body in subjects.iter().filter(top) {
            let moons: Vec<&Subject> = subjects.iter().filter(|s| s.kind == BodyKind::Moon && s.parent == Some(body.id)).collect();
            if moons.is_empty() {
                entry(interface, ui, body, actions);
                continue;
            }
            let id = ui.make_persistent_id(("moons of", body.id.0));
            let mut fold = CollapsingState::load_with_default_open(ui.ctx(), id, false);
            if news.is_some_and(|selected| selected == body.id || moons.iter().any(|m| m.id == selected)) {
                fold.set_open(true);
            }
            is_opening |= fold.is_open() && fold.openness(ui.ctx()) < 1.0;
            let is_open = fold.is_open();
            let (arrow, ..) = fold.show_header(ui, |ui| entry(interface, ui, body, actions)).body(|ui| {
                for moon in moons {
                    entry(interface, ui, moon, actions);
                }
            });
            // An arrow alone says nothing to who cannot see it.
            let name = format!("Moons of {}", body.name);
            arrow.widget_info(|| egui::WidgetInfo::selected(egui::Role::DisclosureTriangle, true, is_open, &name));
        }
    });
    if !is_opening {
        interface.browse.shown = None;
    }
    if let Some(Action::Select(id) | Action::FlyTo(id)) = actions[before..].last() {
        interface.browse.clicked = Some(*id);
    }
}

/// A selection that is news to the list: its moons unfold, or those beside it, once, so that an arrow stays as a hand leaves it. From press to release
/// the list stands still: what is selected meanwhile is unfolded after it.
fn to_unfold(interface: &mut Interface, ui: &egui::Ui) -> Option<NaifId> {
    let selected = interface.viewer.selected;
    let browse = &mut interface.browse;
    if browse.unfolded_for == Some(selected) {
        return None;
    }
    if ui.input(|i| i.pointer.any_down() || i.pointer.any_released()) {
        ui.ctx().request_repaint();
        return None;
    }
    browse.unfolded_for = Some(selected);
    browse.shown = (browse.clicked.take() != Some(selected)).then_some(selected);
    Some(selected)
}

fn entry(interface: &Interface, ui: &mut egui::Ui, body: &Subject, actions: &mut Vec<Action>) {
    // A row is known by its body: known by its place it would be another one as soon as rows unfold above it, and the click that pressed it would be that one's.
    let row = UiBuilder::new().scope_id(Id::unique(("body in the list", body.id.0)));
    let is_selected = interface.viewer.selected == body.id;
    let response = ui.scope_builder(row, |ui| ui.selectable_label(is_selected, &body.name)).inner;
    if interface.browse.shown == Some(body.id) {
        response.scroll_to_me(None);
    }
    if response.double_clicked() {
        actions.push(Action::FlyTo(body.id));
    } else if response.clicked() {
        actions.push(Action::Select(body.id));
    }
    response.on_hover_text("Click to select, double-click to fly there");
}
