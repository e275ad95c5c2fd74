//! Tables that the user sorts by a column: the headings, the order of the rows, and columns of numbers aligned at the right.
//!
//! In: the titles of the columns, clicks on them, and the values of the rows. Out: headings in a grid, and the rows in order. Always: rows without a value
//! in the chosen column come last in both directions; rows with equal values keep their order.

use crate::view::language::text;
use egui::Ui;
use egui::accesskit::SortDirection;
use std::cmp::Ordering;

/// The value of a row in one column.
#[derive(Clone, Debug)]
pub(super) enum SortValue {
    /// NaN: the row has no value in this column, also if the other rows have texts.
    Number(f64),
    Text(String),
}

/// The column by which a table is sorted, and the direction; a field of the panel's state. At first: the first column, ascending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SortOrder {
    /// The index of the column's title.
    column: usize,
    is_descending: bool,
}

impl SortOrder {
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
    }

    #[test]
    fn cells_are_as_wide_as_the_longest_of_their_column() {
        assert_eq!(aligned(["-", "384 400 km", "12 µm"].map(str::to_owned)), ["         -", "384 400 km", "     12 µm"]);
        assert!(aligned(Vec::new()).is_empty());
    }
}
