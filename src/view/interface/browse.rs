//! Finding a body: search with completion, and the tree of the system.

use super::Interface;
use crate::catalog::{Kind, NaifId};
use crate::scene::effects::EffectOverrides;
use crate::time::Instant;
use crate::view::viewer::{Action, Subject};
use egui::{Key, ScrollArea, TextEdit};

/// Completions shown at once.
const COMPLETIONS: usize = 8;

#[derive(Default)]
pub struct Browse {
    wanted: String,
    /// Of the completions.
    highlighted: usize,
    /// The search field wants the keyboard.
    pub focus: bool,
}

impl Browse {
    /// Leaves the search; what it completes to goes with the text.
    pub fn give_up(&mut self) {
        self.wanted.clear();
    }
}

/// The search field, with what it completes to below it.
pub fn search(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let field = TextEdit::singleline(&mut interface.browse.wanted).hint_text("Search (/)").desired_width(150.0);
    let response = ui.add(field).on_hover_text("Search a body by name");
    if std::mem::take(&mut interface.browse.focus) {
        response.request_focus();
    }
    if response.changed() {
        interface.browse.highlighted = 0;
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
    if entered && command(interface, actions) {
        interface.browse.wanted.clear();
    } else if entered {
        chosen = found.get(interface.browse.highlighted).map(|f| f.0);
        if chosen.is_none() && !interface.browse.wanted.trim().is_empty() {
            interface.message = format!("no body is called `{}`", interface.browse.wanted.trim());
        }
    }
    if !found.is_empty() {
        let below = response.rect.left_bottom();
        egui::Area::new(ui.scope_id().with("completions")).fixed_pos(below).order(egui::Order::Foreground).show(ui.ctx(), |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                for (i, (id, name)) in found.iter().enumerate() {
                    if ui.selectable_label(i == interface.browse.highlighted, name).clicked() {
                        chosen = Some(*id);
                    }
                }
            });
        });
    }
    if let Some(id) = chosen {
        interface.browse.wanted.clear();
        actions.push(Action::FlyTo(id));
    }
}

/// What is typed besides names: effects as `--effects` takes them, and dates.
fn command(interface: &mut Interface, actions: &mut Vec<Action>) -> bool {
    let typed = interface.browse.wanted.trim().to_owned();
    if typed.starts_with(['+', '-']) && typed.contains(char::is_alphabetic) {
        let sight = &mut interface.viewer.sight;
        let both = if sight.effects.is_empty() { typed } else { format!("{},{typed}", sight.effects) };
        match EffectOverrides::parse(&both) {
            Ok(overrides) => sight.effects = overrides.to_text(),
            Err(e) => interface.message = e.to_string(),
        }
        return true;
    }
    match Instant::parse(&typed) {
        Ok(time) if typed.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
            actions.push(Action::SetTime(time));
            true
        }
        _ => false,
    }
}

/// The Sun, its planets each with its moons, then the rest.
pub fn tree(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
        let subjects = interface.viewer.subjects();
        let top = |s: &&Subject| s.kind != Kind::Moon;
        for body in subjects.iter().filter(top) {
            let moons: Vec<&Subject> = subjects.iter().filter(|s| s.kind == Kind::Moon && s.parent == Some(body.id)).collect();
            if moons.is_empty() {
                entry(interface, ui, body, actions);
                continue;
            }
            let id = ui.make_persistent_id(("moons of", body.id.0));
            let open = interface.viewer.selected == body.id || moons.iter().any(|m| m.id == interface.viewer.selected);
            let mut fold = egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, false);
            if open && !fold.is_open() && ui.input(|i| i.pointer.any_released()) {
                fold.set_open(true);
            }
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
}

fn entry(interface: &Interface, ui: &mut egui::Ui, body: &Subject, actions: &mut Vec<Action>) {
    let response = ui.selectable_label(interface.viewer.selected == body.id, &body.name);
    if response.double_clicked() {
        actions.push(Action::FlyTo(body.id));
    } else if response.clicked() {
        actions.push(Action::Select(body.id));
    }
    response.on_hover_text("Click selects, double-click flies there");
}
