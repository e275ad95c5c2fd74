//! The line below the sky: date and time, their pace, steps, and what there is to say.

use super::Interface;
use super::renderer_line;
use crate::time::Instant;
use crate::view::app::viewer::Action;
use egui::{Key, TextEdit};

#[derive(Default)]
pub struct TimeBar {
    /// What is being typed; empty while the field shows the view's time.
    typed: Option<String>,
}

const DAY_S: f64 = 86_400.0;
/// Steps that a button takes: seconds and name.
const STEPS: [(f64, &str); 4] = [(60.0, "min"), (3600.0, "h"), (DAY_S, "d"), (365.25 * DAY_S, "yr")];

pub fn bar(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        entry(interface, ui, actions);
        if ui.button("Now").on_hover_text("Current time, in real time (t)").clicked() {
            actions.push(Action::Now);
        }
        ui.separator();
        let paused = interface.viewer.time_rate.is_paused();
        let backward = interface.viewer.time_rate.rate() < 0.0;
        if ui.button("Slower").on_hover_text("Slower (,)").clicked() {
            actions.push(Action::Slower);
        }
        if ui.selectable_label(backward, "Reverse").on_hover_text("Run time backward (j)").clicked() {
            actions.push(Action::Backward);
        }
        if ui.selectable_label(paused, "Pause").on_hover_text("Pause (Space)").clicked() {
            actions.push(Action::TogglePause);
        }
        if ui.selectable_label(!paused && !backward, "Play").on_hover_text("Run time forward (l)").clicked() {
            actions.push(Action::Forward);
        }
        if ui.button("Faster").on_hover_text("Faster (.)").clicked() {
            actions.push(Action::Faster);
        }
        ui.label(interface.viewer.time_rate.label());
        ui.separator();
        for (seconds, name) in STEPS {
            for (sign, way) in [(-1.0, "-"), (1.0, "+")] {
                if ui.small_button(format!("{way}{name}")).on_hover_text(format!("Step time by {way}1 {name}")).clicked() {
                    actions.push(Action::Step(sign * seconds));
                }
            }
        }
        day_of_year(interface, ui, actions);
        ui.separator();
        ui.label(renderer_line(interface));
    });
}

fn entry(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let shown = interface.viewer.view.time().to_utc_iso();
    let mut text = interface.clock.typed.clone().unwrap_or_else(|| shown.clone());
    let response = ui.add(TextEdit::singleline(&mut text).desired_width(185.0)).on_hover_text("Date and time, UTC (ISO 8601)");
    if response.has_focus() && (interface.clock.typed.is_some() || text != shown) {
        interface.clock.typed = Some(text.clone());
    }
    if response.lost_focus() {
        let typed = interface.clock.typed.take();
        if ui.input(|i| i.key_pressed(Key::Enter)) {
            match Instant::parse(typed.as_deref().unwrap_or(&text).trim()) {
                Ok(time) => actions.push(Action::SetTime(time)),
                Err(e) => interface.message = e.to_string(),
            }
        }
    }
}

/// A slider over the days of the year that is shown.
fn day_of_year(interface: &Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let now = interface.viewer.view.time();
    let iso = now.to_utc_iso();
    // The sign of a year before 0 is not a separator.
    let year_end = iso.get(1..).and_then(|rest| rest.find('-')).map_or(0, |at| at + 1);
    let Ok(start) = Instant::parse(&format!("{}-01-01T00:00:00Z", &iso[..year_end])) else { return };
    // In whole minutes: a screen reader is told of each change, and time runs in seconds.
    let minutes = ((now.tdb_seconds_past_j2000() - start.tdb_seconds_past_j2000()) / 60.0).round();
    let mut day = minutes * 60.0 / DAY_S;
    let before = day;
    let slider = egui::Slider::new(&mut day, 0.0..=365.99).show_value(false);
    if ui.add(slider).on_hover_text("Day of the year").changed() {
        actions.push(Action::Step((day - before) * DAY_S));
    }
}
