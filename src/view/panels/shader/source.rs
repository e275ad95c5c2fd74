//! The Source page: source text with line numbers, syntax colours, the feature of each line, and search.
//!
//! In: the text of the displayed module in the chosen language. Out: egui shapes. Always: only visible lines are laid out, so that a text of a hundred
//! thousand lines scrolls as fast as a short text; the list of lines is a single Tab stop, and arrow keys move between its lines; the search finds only lines
//! that the list shows, and the current match is in view, in a frame; until the text of another module has arrived, the last one stays; the search field stays
//! also if there is no text.

use super::module_text::{ModuleLine, ModuleText, feature_colour, find_all, layout_job};
use super::queries::ModuleFailure;
use super::{Inspected, ShaderPanel, show_failure};
use crate::shader::translate::Language;
use crate::view::language::text;
use crate::view::panels::accessible;
use crate::view::panels::theme::{CODE_TEXT_POINTS, MIN_LIST_HEIGHT, SMALL_TEXT_POINTS};
use egui::text::CCursor;
use egui::{FontId, Key, Rangef, RichText, ScrollArea, Sense, TextEdit, Ui, Vec2, vec2};
use std::sync::Arc;

/// Width of the margin left of the source, points. The margin shows the feature of each line: its name and a coloured stripe.
const MARGIN_POINTS: f32 = 112.0;
/// Width of the stripe at the right edge of the margin, points.
const STRIPE_POINTS: f32 = 4.0;
/// Opacity of the feature's colour over the margin of the lines of the highlighted feature.
const HIGHLIGHT_OPACITY: f32 = 0.14;
/// Size of the font of the source, points.
const FONT_POINTS: f32 = CODE_TEXT_POINTS;
/// When the list is scrolled to a line, this number of rows stays visible above it.
const ROWS_ABOVE: f32 = 3.0;
/// Distance between the margin and the line, points.
const MARGIN_GAP: f32 = 4.0;
/// When the list is scrolled sideways to a match, this width stays visible right of it, points. It includes the scroll bar.
const WIDTH_AFTER_MATCH: f32 = 32.0;

/// The result of a search.
struct FoundLines {
    /// The source that was searched.
    text: Arc<ModuleText>,
    /// The text that was sought.
    needle: String,
    /// The feature whose lines were searched; `None`: all lines.
    only_feature: Option<usize>,
    /// The lines (from 0) that contain it.
    lines: Vec<u32>,
}

/// State of the Source page.
#[derive(Default)]
pub(crate) struct SourcePage {
    /// The chosen language; `None`: WGSL.
    language: Option<Language>,
    /// The name of the feature to highlight.
    feature: Option<String>,
    /// Whether only the lines of the highlighted feature are shown.
    shows_only_feature: bool,
    /// Whether the margin shows only stripes, without names.
    hides_names: bool,
    /// Whether the legend also lists negated features. The lines of `not eclipse`, for example, are in the module because the draw has no eclipse.
    shows_negated: bool,
    /// The text that was shown last.
    last_text: Option<Arc<ModuleText>>,
    /// The text in the search field.
    needle: String,
    /// Index of the current match in the lines of `found`.
    match_index: usize,
    /// The last search.
    found: Option<FoundLines>,
    /// The name of a feature requested by another panel, until the user chooses a feature.
    requested: Option<String>,
    /// The source in which the page has already jumped to the requested feature.
    jumped_in: Option<Arc<ModuleText>>,
    /// The first line (from 0) of the last run jumped to. A run is a group of consecutive lines of one feature.
    run_start: Option<usize>,
    /// A line (from 0) to scroll to.
    scroll_line: Option<u32>,
    /// The line (from 0) that the arrow keys selected.
    cursor_line: usize,
    /// The list of lines, once it was shown.
    pub(super) lines_id: Option<egui::Id>,
}

/// Name and tooltip of a language.
fn language_name(language: Language) -> (&'static str, &'static str) {
    match language {
        Language::Wgsl => ("WGSL", text!("language-wgsl")),
        Language::Hlsl => ("HLSL", text!("language-hlsl")),
        Language::Glsl => ("GLSL", text!("language-glsl")),
        Language::Msl => ("MSL", text!("language-msl")),
        Language::Spirv => ("SPIR-V", text!("language-spirv")),
        Language::Assembly => (text!("language-spirv-text-name"), text!("language-spirv-text")),
        Language::Ir => ("IR", text!("language-ir")),
    }
}

/// Shows the page. `failure`: why there is no module.
pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut Ui, inspected: &Inspected<'_>, failure: Option<&ModuleFailure>) {
    let page = &mut panel.source;
    let language = page.language.unwrap_or(Language::Wgsl);
    let answer = panel.queries.text(inspected.worker, &inspected.id, language);
    ui.horizontal_wrapped(|ui| {
        for choice in Language::ALL {
            let (name, tooltip) = language_name(choice);
            if ui.selectable_label(choice == language, name).on_hover_text(tooltip).clicked() {
                page.language = Some(choice);
            }
        }
        if answer.is_none() {
            accessible::spinner(ui, text!("source-coming"));
        }
    });
    // The last text stays until the new one has arrived.
    let last_text = page.last_text.take().filter(|last| last.language == language);
    let (text, why) = match answer {
        Some(Ok(text)) => (Some(text), None),
        Some(Err(why)) => (None, Some(why)),
        None => (last_text, None),
    };
    page.last_text = text.filter(|_| failure.is_none());
    let text = page.last_text.clone();
    if let Some(text) = &text {
        page.show_requested(text);
    }
    page.search(ui, text.as_ref());
    let Some(text) = text else {
        match (failure, why) {
            (Some(failure), _) => show_failure(ui, failure),
            (None, Some(why)) => drop(ui.colored_label(ui.visuals().warn_fg_color, why)),
            (None, None) => {}
        }
        return;
    };
    if !text.features.is_empty() {
        page.legend(ui, &text);
    }
    ui.separator();
    page.lines(ui, &text);
}

/// Whether a feature's name is `requested`, or `requested` with a suffix: `eclipse.1` belongs to `eclipse`.
fn belongs_to(name: &str, requested: &str) -> bool {
    name.strip_prefix(requested).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

impl SourcePage {
    /// Requests a jump to the lines of a feature as soon as a module with this feature is shown. If a later image uses another module, for example
    /// because it is finer, the page jumps again.
    pub(crate) fn request_feature(&mut self, feature: &str) {
        (self.language, self.feature, self.shows_only_feature) = (None, None, false);
        (self.requested, self.jumped_in) = (Some(feature.to_owned()), None);
    }

    /// Jumps to the requested feature, if this module has it.
    fn show_requested(&mut self, text: &Arc<ModuleText>) {
        if self.jumped_in.as_ref().is_some_and(|jumped_in| Arc::ptr_eq(jumped_in, text)) {
            return;
        }
        let found = self
            .requested
            .as_ref()
            .and_then(|requested| text.features.iter().position(|(name, line_count)| belongs_to(name, requested) && *line_count > 0));
        if let Some(feature_index) = found {
            self.jumped_in = Some(Arc::clone(text));
            let last_start = None;
            self.go_to(text, feature_index, last_start);
        }
    }

    /// The highlighted feature of this module.
    fn highlighted_feature(&self, text: &ModuleText) -> Option<usize> {
        self.feature.as_ref().and_then(|chosen| text.features.iter().position(|(name, _)| name == chosen))
    }

    /// The feature to whose lines the list is limited; `None`: it shows all lines.
    fn only_feature(&self, text: &ModuleText) -> Option<usize> {
        self.highlighted_feature(text).filter(|_| self.shows_only_feature)
    }

    /// The line (from 0) of the current match.
    fn matching_line(&self) -> Option<u32> {
        self.found.as_ref().filter(|_| !self.needle.is_empty()).and_then(|found| found.lines.get(self.match_index)).copied()
    }

    /// Searches the lines that the list shows, unless it has done so. The first match becomes current; if only the lines have changed, the next match after
    /// the current one, which as with the buttons is the first match if none follows.
    fn update_found(&mut self, text: &Arc<ModuleText>) {
        let only_feature = self.only_feature(text);
        let last = self.found.as_ref().filter(|found| Arc::ptr_eq(&found.text, text) && found.needle == self.needle);
        if last.is_some_and(|last| last.only_feature == only_feature) {
            return;
        }
        let last_line = last.and(self.matching_line());
        let is_shown = |line: &ModuleLine| only_feature.is_none_or(|feature| usize::from(line.feature_index) == feature);
        let is_match = |line: &ModuleLine| is_shown(line) && !find_all(&line.text, &self.needle).is_empty();
        let lines = (0..).zip(&text.lines).filter(|(_, line)| is_match(line)).map(|(index, _)| index).collect::<Vec<u32>>();
        let next_index = last_line.and_then(|last_line| lines.iter().position(|line| *line >= last_line));
        self.match_index = next_index.unwrap_or(0);
        // Once the search is empty, the list goes back to the beginnings of the lines.
        let is_emptied = self.needle.is_empty() && self.found.as_ref().is_some_and(|found| !found.needle.is_empty());
        self.scroll_line = lines.get(self.match_index).copied().or(is_emptied.then_some(self.cursor_line as u32));
        self.found = Some(FoundLines { text: Arc::clone(text), needle: self.needle.clone(), only_feature, lines });
    }

    /// Shows the search field and the number of the current match, without a text only the field. Scrolls to the current match when another match becomes
    /// current.
    fn search(&mut self, ui: &mut Ui, text: Option<&Arc<ModuleText>>) {
        // 1 to go to the next match, -1 to go to the previous one.
        let mut step = 0;
        ui.horizontal(|ui| {
            let label = ui.label(text!("source-find"));
            let field = TextEdit::singleline(&mut self.needle).id_salt("search in the source").desired_width(150.0);
            let response = ui.add(field).labelled_by(label.id);
            let response = response.on_hover_text(text!("source-find-hint"));
            if response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter)) {
                step = 1;
                response.request_focus();
            }
            let Some(text) = text else { return };
            if !text.features.is_empty() {
                let mut shows_names = !self.hides_names;
                ui.checkbox(&mut shows_names, text!("source-features")).on_hover_text(text!("source-features-hint"));
                self.hides_names = !shows_names;
            }
            if self.needle.is_empty() {
                ui.weak(text!("source-count", count = text.lines.len()));
                return;
            }
            if ui.small_button(text!("source-previous")).on_hover_text(text!("source-previous-hint")).clicked() {
                step = -1;
            }
            if ui.small_button(text!("source-next")).on_hover_text(text!("source-next-hint")).clicked() {
                step = 1;
            }
            self.update_found(text);
            let count = self.found.as_ref().map_or(0, |found| found.lines.len());
            if count == 0 {
                ui.weak(text!("source-no-match"));
                return;
            }
            if step != 0 {
                self.match_index = (self.match_index as i64 + step).rem_euclid(count as i64) as usize;
                self.scroll_line = self.matching_line();
            }
            ui.weak(text!("source-match", at = self.match_index + 1, count = count));
        });
    }

    /// Shows every feature that has lines, with its colour and its number of lines, and a switch that hides all lines except those of the chosen
    /// feature.
    fn legend(&mut self, ui: &mut Ui, text: &ModuleText) {
        let is_dark = ui.visuals().dark_mode;
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing = vec2(2.0, 0.0);
            ui.spacing_mut().button_padding = vec2(5.0, 1.0);
            ui.spacing_mut().interact_size.y = 16.0;
            ui.horizontal_wrapped(|ui| {
                let mut features_with_lines: Vec<_> =
                    text.features.iter().enumerate().filter(|(_, (_, line_count))| *line_count > 0).collect();
                // Negated features come last, and only on request.
                let is_negated = |name: &str| name.starts_with("not ");
                features_with_lines.sort_by_key(|(_, (name, _))| is_negated(name));
                let negated_count = features_with_lines.iter().filter(|(_, (name, _))| is_negated(name)).count();
                self.shows_negated |= self.feature.as_deref().is_some_and(is_negated);
                for (feature_index, (name, line_count)) in features_with_lines {
                    if is_negated(name) && !self.shows_negated {
                        continue;
                    }
                    let is_chosen = self.feature.as_ref() == Some(name);
                    let label = RichText::new(format!("{name} {line_count}")).size(SMALL_TEXT_POINTS).color(feature_colour(name, is_dark));
                    let hover = text!("source-feature-hint", lines = line_count, name = name);
                    if ui.selectable_label(is_chosen, label).on_hover_text(hover).clicked() {
                        self.requested = None;
                        let last_start = self.run_start.filter(|_| is_chosen);
                        self.go_to(text, feature_index, last_start);
                    }
                }
                if negated_count > 0 {
                    let label = RichText::new(text!("source-negated", count = negated_count)).size(SMALL_TEXT_POINTS);
                    ui.toggle_value(&mut self.shows_negated, label).on_hover_text(text!("source-negated-hint"));
                }
            });
        });
        ui.horizontal(|ui| {
            // This module may lack the highlighted feature, if the user chose it in another module.
            if let Some(feature) = self.feature.clone().filter(|f| text.features.iter().any(|(name, _)| name == f)) {
                ui.checkbox(&mut self.shows_only_feature, text!("source-only", feature = feature)).on_hover_text(text!("source-only-hint"));
                if ui.small_button(text!("source-all")).on_hover_text(text!("source-all-hint")).clicked() {
                    (self.feature, self.shows_only_feature, self.requested) = (None, false, None);
                }
            }
        });
    }

    /// Highlights a feature and jumps to its longest run of consecutive lines. With `last_start`, the first line of a run, jumps to the feature's next run
    /// instead.
    fn go_to(&mut self, text: &ModuleText, feature_index: usize, last_start: Option<usize>) {
        let has_feature = |line: usize| text.lines.get(line).is_some_and(|l| usize::from(l.feature_index) == feature_index);
        let starts: Vec<usize> = (0..text.lines.len()).filter(|i| has_feature(*i) && (*i == 0 || !has_feature(i - 1))).collect();
        let length = |start: usize| (start..text.lines.len()).take_while(|i| has_feature(*i)).count();
        let next = match last_start {
            Some(last_start) => starts.iter().find(|start| **start > last_start).or(starts.first()),
            // The first lines of a feature are usually declarations; its longest run is its code. Of runs of equal length, the first is taken.
            None => starts.iter().rev().max_by_key(|start| length(**start)),
        };
        self.feature = text.features.get(feature_index).map(|(name, _)| name.clone());
        self.run_start = next.copied();
        self.scroll_line = next.map(|start| *start as u32);
    }

    /// Shows the list of lines, and handles its keys.
    fn lines(&mut self, ui: &mut Ui, text: &ModuleText) {
        let highlighted_index = self.highlighted_feature(text);
        // The lines that are rows of the list; `None`: all lines.
        let rows: Option<Vec<usize>> = self
            .only_feature(text)
            .map(|index| (0..text.lines.len()).filter(|line| usize::from(text.lines[*line].feature_index) == index).collect());
        let row_count = rows.as_ref().map_or(text.lines.len(), Vec::len);
        let matching_line = self.matching_line().map(|line| line as usize);
        let font = FontId::monospace(FONT_POINTS);
        ui.spacing_mut().item_spacing.y = 0.0;
        // A row is as high as a line of text.
        let row_height = ui.ctx().fonts_mut(|f| f.row_height(&font)).ceil();
        ui.spacing_mut().interact_size.y = row_height;
        let mut area =
            ScrollArea::both().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).id_salt(("source", text.language.to_string()));
        let row_of = |line: usize| rows.as_ref().map_or(line, |r| r.partition_point(|l| *l < line));
        if let Some(line) = self.scroll_line.take() {
            self.cursor_line = line as usize;
            area = area.vertical_scroll_offset((row_of(line as usize) as f32 * row_height - ROWS_ABOVE * row_height).max(0.0));
            // A jump elsewhere than to a match goes back to the beginnings of the lines.
            let matching_line = matching_line.filter(|matching| *matching == self.cursor_line);
            area = area.horizontal_scroll_offset(matching_line.map_or(0.0, |line| self.offset_of_match(ui, text, line, &font)));
        }
        let has_margin = !text.features.is_empty();
        let mut chosen_index = None;
        let mut list_rect = ui.available_rect_before_wrap();
        list_rect.set_height(list_rect.height().max(MIN_LIST_HEIGHT));
        let tab_stop = ui.interact(list_rect, ui.scope_id().with("lines"), Sense::focusable_noninteractive());
        self.lines_id = Some(tab_stop.id);
        let accessible_name = text!("source-lines");
        tab_stop.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ListBox, true, accessible_name));
        let (cursor_row, cursor_moved) =
            navigation_keys(ui, &tab_stop, row_of(self.cursor_line).min(row_count.saturating_sub(1)), row_count);
        if cursor_moved {
            self.cursor_line = rows.as_ref().map_or(cursor_row, |r| r[cursor_row]);
        }
        if tab_stop.has_focus() && ui.input(|i| i.key_pressed(Key::Enter)) {
            chosen_index = text.lines.get(self.cursor_line).filter(|_| has_margin).map(|line| usize::from(line.feature_index));
        }
        area.show_rows(ui, row_height, row_count, |ui, range| {
            let is_dark = ui.visuals().dark_mode;
            if cursor_moved {
                // Scroll vertically as far as needed, never horizontally.
                let top = ui.max_rect().top() + (cursor_row as f32 - range.start as f32) * row_height;
                let row = egui::Rect::from_x_y_ranges(ui.clip_rect().x_range(), top..=top + row_height);
                ui.scroll_to_rect_animation(row, None, egui::style::ScrollAnimation::none());
                ui.ctx().request_repaint();
            }
            for row in range.clone() {
                let line_index = rows.as_ref().map_or(row, |r| r[row]);
                let Some(line) = text.lines.get(line_index) else { continue };
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = MARGIN_GAP;
                    if has_margin {
                        let index_above = (row > range.start).then(|| rows.as_ref().map_or(row - 1, |r| r[row - 1]));
                        let line_above = index_above.and_then(|above| text.lines.get(above));
                        let is_first = line_above.is_none_or(|above| above.feature_index != line.feature_index);
                        if self.margin(ui, text, line_index, row_height, is_first, highlighted_index) {
                            chosen_index = Some(usize::from(line.feature_index));
                        }
                    }
                    let label = ui.add(egui::Label::new(layout_job(line_index + 1, &line.text, &self.needle, &font, is_dark)).extend());
                    if matching_line == Some(line_index) {
                        let frame = egui::Rect::from_x_y_ranges(ui.clip_rect().x_range(), label.rect.y_range());
                        let stroke = egui::Stroke::new(1.0, ui.visuals().warn_fg_color);
                        ui.painter().rect_stroke(frame, 2.0, stroke, egui::StrokeKind::Inside);
                    }
                    if tab_stop.has_focus() && row == cursor_row {
                        ui.painter().rect_stroke(label.rect, 2.0, ui.visuals().selection.stroke, egui::StrokeKind::Outside);
                        ui.ctx().accesskit_node_builder(tab_stop.id, |list| list.set_active_descendant(label.id.accesskit_id()));
                        let feature = text.features.get(usize::from(line.feature_index)).filter(|_| has_margin);
                        if let Some((name, _)) = feature {
                            ui.ctx()
                                .accesskit_node_builder(label.id, |node| node.set_description(text!("source-needed-by", feature = name)));
                        }
                    }
                });
            }
        });
        if let Some(index) = chosen_index {
            self.feature = text.features.get(index).map(|(name, _)| name.clone());
        }
    }

    /// The horizontal scroll offset of the list that brings the first match of a line into view, points: 0 if it is in view without scrolling.
    fn offset_of_match(&self, ui: &Ui, text: &ModuleText, line_index: usize, font: &FontId) -> f32 {
        let Some(line) = text.lines.get(line_index) else { return 0.0 };
        let Some(first_match) = find_all(&line.text, &self.needle).into_iter().next() else { return 0.0 };
        let galley = ui.painter().layout_job(layout_job(line_index + 1, &line.text, &self.needle, font, ui.visuals().dark_mode));
        // The line's number precedes the line.
        let number_bytes = galley.text().len() - line.text.len();
        let x_of_byte = |byte: usize| {
            let chars_before = galley.text().get(..number_bytes + byte).map_or(0, |before| before.chars().count());
            galley.pos_from_cursor(CCursor::new(chars_before)).left()
        };
        let margin_width = if self.hides_names { STRIPE_POINTS } else { MARGIN_POINTS };
        let line_left = if text.features.is_empty() { 0.0 } else { margin_width + MARGIN_GAP };
        let place = Rangef::new(line_left + x_of_byte(first_match.start), line_left + x_of_byte(first_match.end));
        // A match that is wider than the list begins at its left edge.
        (place.max + WIDTH_AFTER_MATCH - ui.available_width()).clamp(0.0, place.min)
    }

    /// Shows the feature of a line in the margin. `height`: of the line, points. `is_first`: whether the line is the first visible line of its run, so that
    /// the margin also shows the feature's name, unless names are hidden. `highlighted_index`: of the highlighted feature. Returns whether the margin was
    /// clicked.
    fn margin(
        &self,
        ui: &mut Ui,
        text: &ModuleText,
        line_index: usize,
        height: f32,
        is_first: bool,
        highlighted_index: Option<usize>,
    ) -> bool {
        let Some(line) = text.lines.get(line_index) else { return false };
        let Some((name, _)) = text.features.get(usize::from(line.feature_index)) else { return false };
        let width = if self.hides_names { STRIPE_POINTS } else { MARGIN_POINTS };
        // The list is the Tab stop, so the margin of a line is not.
        let (rect, response) = ui.allocate_exact_size(Vec2::new(width, height), Sense::CLICK);
        let colour = feature_colour(name, ui.visuals().dark_mode);
        let stripe = egui::Rect::from_min_size(egui::pos2(rect.right() - STRIPE_POINTS, rect.top()), vec2(STRIPE_POINTS, height));
        ui.painter().rect_filled(stripe, 0.0, colour);
        if highlighted_index == Some(usize::from(line.feature_index)) {
            ui.painter().rect_filled(rect, 0.0, colour.gamma_multiply(HIGHLIGHT_OPACITY));
        }
        if is_first {
            if !self.hides_names {
                let name_rect = egui::Rect::from_min_max(rect.min, stripe.left_bottom());
                let font = FontId::proportional(SMALL_TEXT_POINTS);
                let painter = ui.painter().with_clip_rect(name_rect.intersect(ui.clip_rect()));
                painter.text(name_rect.left_center(), egui::Align2::LEFT_CENTER, name, font, colour);
            }
            let accessible_name = text!("source-line", line = line_index + 1, name = name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &accessible_name));
        }
        response.on_hover_text(format!("{name}\n{}", line.origin)).clicked()
    }
}

/// Handles arrow keys, Page Up, Page Down, Home and End while the list has the focus. `row`: the row of the cursor. Returns the
/// new row of the cursor, and whether a key was pressed.
fn navigation_keys(ui: &Ui, tab_stop: &egui::Response, row: usize, row_count: usize) -> (usize, bool) {
    /// Rows by which Page Up and Page Down move.
    const PAGE_ROWS: usize = 20;
    if !tab_stop.has_focus() || row_count == 0 {
        return (row, false);
    }
    let arrows = egui::EventFilter { vertical_arrows: true, ..egui::EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(tab_stop.id, arrows));
    let last = row_count - 1;
    let targets = [
        (Key::ArrowDown, (row + 1).min(last)),
        (Key::ArrowUp, row.saturating_sub(1)),
        (Key::PageDown, (row + PAGE_ROWS).min(last)),
        (Key::PageUp, row.saturating_sub(PAGE_ROWS)),
        (Key::Home, 0),
        (Key::End, last),
    ];
    let pressed = targets.into_iter().find(|(key, _)| ui.input(|i| i.key_pressed(*key)));
    pressed.map_or((row, false), |(_, target)| (target, true))
}
