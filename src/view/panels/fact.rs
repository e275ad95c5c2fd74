//! A row of a two-column grid of facts: a label, and a value in a monospaced font. Also numbers with thousands separators.

use crate::view::language::numbers::{group_mark, localised};

/// Adds one row to the grid.
pub(super) fn line(ui: &mut egui::Ui, what: &str, value: impl Into<String>) {
    ui.label(what);
    ui.add(egui::Label::new(egui::RichText::new(value.into()).monospace()).wrap());
    ui.end_row();
}

/// A number with `digits` decimals and thousands separators.
pub(super) fn grouped(value: f64, digits: usize) -> String {
    let text = format!("{:.digits$}", value.abs());
    let (whole, rest) =
        text.split_once('.').map_or((text.as_str(), String::new()), |(whole, decimals)| (whole, localised(format!(".{decimals}"))));
    let groups: Vec<&str> = whole.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    format!("{}{}{rest}", if value < 0.0 { "-" } else { "" }, groups.join(group_mark()))
}
