//! Tables that the user sorts by a column: the headings, the order of the rows, columns of numbers aligned at the right, and rows that are clicked.
//!
//! In: the titles of the columns, clicks on them, and the values of the rows. Out: headings in a grid, and the rows in order. Always: rows without a value
//! in the chosen column come last in both directions; rows with equal values keep their order; a click counts for the row that was pressed.

use crate::view::language::text;
use egui::accesskit::SortDirection;
use egui::{Id, Response, Ui, UiBuilder};
use std::cmp::Ordering;
use std::fmt::Debug;
use std::hash::Hash;

/// The value of a row in one column.
#[derive(Clone, Debug)]
pub(super) enum SortValue {
    /// NaN: the row has no value in this column, also if the other rows have texts.
    Number(f64),
    Text(String),
}

/// The column by which a table is sorted, and the direction; a field of the panel's state. By default: the first column, ascending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SortOrder {
    /// The index of the column's title.
    column: usize,
    is_descending: bool,
}

impl Default for SortOrder {
    fn default() -> Self {
        Self::by(0)
    }
}

impl SortOrder {
    /// By a column, ascending.
    pub(super) fn by(column: usize) -> Self {
        Self { column, is_descending: false }
    }

    /// What a click on the heading of a column does: sorts by this column, ascending; if the table is sorted by it already, reverses the direction.
    fn click(&mut self, column: usize) {
        let is_descending = self.column == column && !self.is_descending;
        *self = Self { column, is_descending };
    }

    /// The rows in this order. `value`: the value of a row in the column with this index.
    pub(super) fn sorted<T>(self, rows: impl IntoIterator<Item = T>, value: impl Fn(&T, usize) -> SortValue) -> Vec<T> {
        let mut with_values: Vec<(SortValue, T)> = rows.into_iter().map(|row| (value(&row, self.column), row)).collect();
        with_values.sort_by(|(a, _), (b, _)| self.compare(a, b));
        with_values.into_iter().map(|(_, row)| row).collect()
    }

    fn compare(self, a: &SortValue, b: &SortValue) -> Ordering {
        let is_missing = |value: &SortValue| matches!(value, SortValue::Number(number) if number.is_nan());
        if is_missing(a) || is_missing(b) {
            return is_missing(a).cmp(&is_missing(b));
        }
        let ascending = match (a, b) {
            (SortValue::Number(a), SortValue::Number(b)) => a.total_cmp(b),
            (SortValue::Text(a), SortValue::Text(b)) => a.cmp(b),
            (SortValue::Number(_), SortValue::Text(_)) => Ordering::Less,
            (SortValue::Text(_), SortValue::Number(_)) => Ordering::Greater,
        };
        if self.is_descending { ascending.reverse() } else { ascending }
    }
}

/// Adds a heading for each title to the current row of a grid. The caller may add headings of columns that do not sort after them, and ends the row.
pub(super) fn headings(ui: &mut Ui, order: &mut SortOrder, titles: &[&str]) {
    for (column, title) in titles.iter().copied().enumerate() {
        let is_sorted = order.column == column;
        let (shown, hint) = match (is_sorted, order.is_descending) {
            // The figure space is as wide as an arrow, so that columns keep their width.
            (false, _) => (format!("{title} \u{2007}"), text!("table-sort-hint")),
            (true, false) => (format!("{title} ▲"), text!("table-ascending-hint")),
            (true, true) => (format!("{title} ▼"), text!("table-descending-hint")),
        };
        let heading = ui.selectable_label(is_sorted, shown).on_hover_text(hint).accessible_name(title);
        if is_sorted {
            let direction = if order.is_descending { SortDirection::Descending } else { SortDirection::Ascending };
            ui.ctx().accesskit_node_builder(heading.id, |node| node.set_sort_direction(direction));
        }
        if heading.clicked() {
            order.click(column);
        }
    }
}

/// Shows the name of a row, in a table or another list, as a button. `key`: what the row is about, such as `("moon in the table", 606)`; no other button of the
/// window has it. The button's id follows from the key. egui's own ids, also those of `push_id`, follow from the place, so that a row which moves
/// between press and release would lose the click to another one.
pub(super) fn row_button(ui: &mut Ui, key: impl Hash + Debug, is_selected: bool, name: &str) -> Response {
    let row = UiBuilder::new().scope_id(Id::unique(key));
    ui.scope_builder(row, |ui| ui.selectable_label(is_selected, name)).inner
}

/// The cells of a column of numbers, padded at the left to the width of the longest: aligned at the right in a monospaced font.
pub(super) fn aligned(cells: impl IntoIterator<Item = String>) -> Vec<String> {
    let cells: Vec<String> = cells.into_iter().collect();
    let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    cells.into_iter().map(|cell| format!("{cell:>width$}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_in_both_directions_and_missing_values_stay_last() {
        let rows = [("b", 2.0), ("d", f64::NAN), ("a", 2.0), ("c", 1.0)];
        let value = |row: &(&str, f64), column: usize| match column {
            0 => SortValue::Text(row.0.to_owned()),
            _ => SortValue::Number(row.1),
        };
        let mut order = SortOrder::default();
        let names = |order: SortOrder| order.sorted(rows, value).into_iter().map(|row| row.0).collect::<String>();
        assert_eq!(names(order), "abcd");
        order.click(0);
        assert_eq!(names(order), "dcba");
        order.click(1);
        assert_eq!(names(order), "cbad");
        order.click(1);
        assert_eq!(names(order), "bacd", "equal values keep their order");
        order.click(0);
        assert_eq!(order, SortOrder::default());
        assert_eq!((names(SortOrder::by(1)), names(SortOrder::by(0))), ("cbad".to_owned(), "abcd".to_owned()));
    }

    /// The rows that get a click if the pointer presses on the first of two rows, the rows then change places, and the pointer is released where it is.
    fn clicked_after_a_change(button: fn(&mut Ui, &str) -> Response) -> Vec<&'static str> {
        let ctx = egui::Context::default();
        let (mut clicked, mut first_row) = (Vec::new(), egui::Pos2::ZERO);
        let mut frame = |rows: [&'static str; 2], events: Vec<egui::Event>| {
            let input = egui::RawInput { events, ..Default::default() };
            let mut output = ctx.run_ui(input, |ui| {
                for (place, row) in rows.into_iter().enumerate() {
                    let response = button(ui, row);
                    if place == 0 {
                        first_row = response.rect.center();
                    }
                    if response.clicked() {
                        clicked.push(row);
                    }
                }
            });
            output.textures_delta.clear();
            first_row
        };
        let pos = frame(["a", "b"], Vec::new());
        let primary = |pressed| {
            let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
            egui::Event::PointerButton { pos, button, pressed, modifiers }
        };
        frame(["a", "b"], vec![egui::Event::PointerMoved(pos)]);
        frame(["a", "b"], vec![primary(true)]);
        frame(["b", "a"], Vec::new());
        frame(["b", "a"], vec![primary(false)]);
        clicked
    }

    #[test]
    fn a_click_counts_for_the_row_that_was_pressed() {
        assert_eq!(clicked_after_a_change(|ui, row| row_button(ui, ("row of a test", row), false, row)), ["a"]);
        // Negative control: with egui's own ids, the row that has moved under the pointer gets the click.
        assert_eq!(clicked_after_a_change(|ui, row| ui.selectable_label(false, row)), ["b"]);
    }

    #[test]
    fn cells_are_as_wide_as_the_longest_of_their_column() {
        assert_eq!(aligned(["-", "384 400 km", "12 µm"].map(str::to_owned)), ["         -", "384 400 km", "     12 µm"]);
        assert!(aligned(Vec::new()).is_empty());
    }
}
