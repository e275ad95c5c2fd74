//! The Source page: line numbers, syntax colours, the feature of each line, search.
//!
//! Always: only visible lines are laid out, so that a text of a hundred thousand lines scrolls like a short one; Tab stops once for
//! the whole list, and arrow keys move between its lines.

use super::text::{Text, feature_colour, find_all, layout_job};
use super::{Inspected, ShaderPanel};
use crate::shader::translate::Language;
use crate::view::language::text;
use crate::view::panels::accessible;
use crate::view::panels::theme::{CODE, SMALL};
use egui::{Key, RichText, ScrollArea, Sense, TextEdit, Ui, Vec2, vec2};
use std::sync::Arc;

const MARGIN_POINTS: f32 = 112.0;
const FONT_POINTS: f32 = CODE;
const STRIPE_POINTS: f32 = 4.0;

#[derive(Default)]
pub(crate) struct SourcePage {
    language: Option<Language>,
    /// The feature to highlight.
    feature: Option<String>,
    /// Show only its lines.
    only: bool,
    no_margin: bool,
    needle: String,
    /// Index of the current search result.
    at: usize,
    found: Option<(Arc<Text>, String, Vec<u32>)>,
    /// A feature requested from outside, until another is chosen; and the text in which it was last shown.
    asked: Option<String>,
    asked_in: Option<Arc<Text>>,
    /// The last line of the feature that was jumped to.
    at_line: Option<usize>,
    /// A line (from 0) to scroll to.
    jump: Option<u32>,
    /// The line (from 0) of the keyboard cursor.
    at_keys: usize,
}

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

pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut Ui, inspected: &Inspected<'_>) {
    let page = &mut panel.source;
    let language = page.language.unwrap_or(Language::Wgsl);
    ui.horizontal_wrapped(|ui| {
        for l in Language::ALL {
            let (name, about) = language_name(l);
            if ui.selectable_label(l == language, name).on_hover_text(about).clicked() {
                page.language = Some(l);
            }
        }
    });
    let text = match panel.queries.text(inspected.worker, &inspected.id, language) {
        Some(Ok(text)) => text,
        Some(Err(why)) => return drop(ui.colored_label(ui.visuals().warn_fg_color, why)),
        None => return drop(accessible::coming(ui, text!("source-coming"))),
    };
    page.show_requested(&text);
    page.find(ui, &text);
    if !text.features.is_empty() {
        page.legend(ui, &text);
    }
    ui.separator();
    page.lines(ui, &text);
}

/// Whether a feature's name is a word or begins with it: `eclipse.1` belongs to `eclipse`.
fn is_of(name: &str, word: &str) -> bool {
    name.strip_prefix(word).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

impl SourcePage {
    /// Jumps to the lines of a feature once a module that has it is shown, and again when a finer picture has another module.
    pub(crate) fn ask_for(&mut self, feature: &str) {
        (self.language, self.feature, self.only) = (None, None, false);
        (self.asked, self.asked_in) = (Some(feature.to_owned()), None);
    }

    /// Jumps to the requested feature, if this module has it.
    fn show_requested(&mut self, text: &Arc<Text>) {
        if self.asked_in.as_ref().is_some_and(|met| Arc::ptr_eq(met, text)) {
            return;
        }
        let found = self.asked.as_ref().and_then(|asked| text.features.iter().position(|(name, lines)| is_of(name, asked) && *lines > 0));
        if let Some(feature) = found {
            self.asked_in = Some(Arc::clone(text));
            self.go_to(text, feature, false);
        }
    }

    /// The search field with the position of the current result.
    fn find(&mut self, ui: &mut Ui, text: &Arc<Text>) {
        let mut step = 0;
        ui.horizontal(|ui| {
            let label = ui.label(text!("source-find"));
            let response = ui.add(TextEdit::singleline(&mut self.needle).desired_width(150.0)).labelled_by(label.id);
            let response = response.on_hover_text(text!("source-find-hint"));
            if response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter)) {
                step = 1;
                response.request_focus();
            }
            if !text.features.is_empty() {
                let mut margin = !self.no_margin;
                ui.checkbox(&mut margin, text!("source-features")).on_hover_text(text!("source-features-hint"));
                self.no_margin = !margin;
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
            let current = self.found.as_ref().is_some_and(|(of, needle, _)| Arc::ptr_eq(of, text) && *needle == self.needle);
            if !current {
                let holds = |line: &str| !find_all(line, &self.needle).is_empty();
                let lines = (0..).zip(&text.lines).filter(|(_, l)| holds(&l.text)).map(|(i, _)| i).collect::<Vec<u32>>();
                self.at = 0;
                self.jump = lines.first().copied();
                self.found = Some((Arc::clone(text), self.needle.clone(), lines));
            }
            let Some((_, _, lines)) = &self.found else { return };
            if lines.is_empty() {
                ui.weak(text!("source-no-match"));
                return;
            }
            if step != 0 {
                self.at = (self.at as i64 + step).rem_euclid(lines.len() as i64) as usize;
                self.jump = lines.get(self.at).copied();
            }
            ui.weak(text!("source-match", at = self.at + 1, count = lines.len()));
        });
    }

    /// Every feature with its colour and its number of lines.
    fn legend(&mut self, ui: &mut Ui, text: &Text) {
        let dark = ui.visuals().dark_mode;
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing = vec2(2.0, 0.0);
            ui.spacing_mut().button_padding = vec2(5.0, 1.0);
            ui.spacing_mut().interact_size.y = 16.0;
            ui.horizontal_wrapped(|ui| {
                let mut all: Vec<_> = text.features.iter().enumerate().filter(|(_, f)| f.1 > 0).collect();
                // Lines of negated features come last.
                all.sort_by_key(|(_, (name, _))| name.starts_with("not "));
                for (k, (name, lines)) in all {
                    let chosen = self.feature.as_ref() == Some(name);
                    let words = RichText::new(format!("{name} {lines}")).size(SMALL).color(feature_colour(name, dark));
                    let hover = text!("source-feature-hint", lines = lines, name = name);
                    if ui.selectable_label(chosen, words).on_hover_text(hover).clicked() {
                        self.asked = None;
                        self.go_to(text, k, chosen);
                    }
                }
            });
        });
        ui.horizontal(|ui| {
            // Another module may lack it.
            if let Some(feature) = self.feature.clone().filter(|f| text.features.iter().any(|t| t.0 == *f)) {
                ui.checkbox(&mut self.only, text!("source-only", feature = feature)).on_hover_text(text!("source-only-hint"));
                if ui.small_button(text!("source-all")).on_hover_text(text!("source-all-hint")).clicked() {
                    (self.feature, self.only, self.asked) = (None, false, None);
                }
            }
        });
    }

    /// Jumps to the longest run of a feature's lines, or to its next run.
    fn go_to(&mut self, text: &Text, feature: usize, again: bool) {
        let of = |i: usize| text.lines.get(i).is_some_and(|l| usize::from(l.feature) == feature);
        let starts: Vec<usize> = (0..text.lines.len()).filter(|i| of(*i) && (*i == 0 || !of(i - 1))).collect();
        let length = |start: usize| (start..text.lines.len()).take_while(|i| of(*i)).count();
        let next = match self.at_line.filter(|_| again) {
            Some(here) => starts.iter().find(|s| **s > here).or(starts.first()),
            // The first lines of a feature are declarations; its longest run is its code.
            None => starts.iter().rev().max_by_key(|s| length(**s)),
        };
        self.feature = text.features.get(feature).map(|f| f.0.clone());
        self.at_line = next.copied();
        self.jump = next.map(|n| *n as u32);
    }

    fn lines(&mut self, ui: &mut Ui, text: &Text) {
        let wanted = self.feature.as_ref().and_then(|name| text.features.iter().position(|f| f.0 == *name));
        let rows: Option<Vec<usize>> = wanted
            .filter(|_| self.only)
            .map(|feature| (0..text.lines.len()).filter(|i| usize::from(text.lines[*i].feature) == feature).collect());
        let count = rows.as_ref().map_or(text.lines.len(), Vec::len);
        let font = egui::FontId::monospace(FONT_POINTS);
        ui.spacing_mut().item_spacing.y = 0.0;
        // Rows have the height of a text line without spacing.
        let height = ui.ctx().fonts_mut(|f| f.row_height(&font)).ceil();
        ui.spacing_mut().interact_size.y = height;
        let mut area = ScrollArea::both().auto_shrink(false).id_salt(("source", text.language.to_string()));
        let row_of = |line: usize| rows.as_ref().map_or(line, |r| r.partition_point(|i| *i < line));
        if let Some(line) = self.jump.take() {
            self.at_keys = line as usize;
            area = area.vertical_scroll_offset((row_of(line as usize) as f32 * height - 3.0 * height).max(0.0));
        }
        let margin = !text.features.is_empty();
        let mut clicked = None;
        let stop = ui.interact(ui.available_rect_before_wrap(), ui.scope_id().with("lines"), Sense::focusable_noninteractive());
        let about = text!("source-lines");
        stop.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ListBox, true, about));
        let (at_keys, moved) = keys(ui, &stop, row_of(self.at_keys).min(count.saturating_sub(1)), count);
        if moved {
            self.at_keys = rows.as_ref().map_or(at_keys, |r| r[at_keys]);
        }
        if stop.has_focus() && ui.input(|i| i.key_pressed(Key::Enter)) {
            clicked = text.lines.get(self.at_keys).filter(|_| margin).map(|line| usize::from(line.feature));
        }
        area.show_rows(ui, height, count, |ui, range| {
            let dark = ui.visuals().dark_mode;
            if moved {
                // Scrolls vertically as far as needed, never horizontally.
                let top = ui.max_rect().top() + (at_keys as f32 - range.start as f32) * height;
                let row = egui::Rect::from_x_y_ranges(ui.clip_rect().x_range(), top..=top + height);
                ui.scroll_to_rect_animation(row, None, egui::style::ScrollAnimation::none());
                ui.ctx().request_repaint();
            }
            for row in range.clone() {
                let i = rows.as_ref().map_or(row, |r| r[row]);
                let Some(line) = text.lines.get(i) else { continue };
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 4.0;
                    if margin {
                        let above = (row > range.start).then(|| rows.as_ref().map_or(row - 1, |r| r[row - 1]));
                        let first = above.and_then(|a| text.lines.get(a)).is_none_or(|a| a.feature != line.feature);
                        if self.margin(ui, text, i, height, first, wanted) {
                            clicked = Some(usize::from(line.feature));
                        }
                    }
                    let shown = ui.add(egui::Label::new(layout_job(i + 1, &line.text, &self.needle, &font, dark)).extend());
                    if stop.has_focus() && row == at_keys {
                        ui.painter().rect_stroke(shown.rect, 2.0, ui.visuals().selection.stroke, egui::StrokeKind::Outside);
                        ui.ctx().accesskit_node_builder(stop.id, |list| list.set_active_descendant(shown.id.accesskit_id()));
                        let feature = text.features.get(usize::from(line.feature)).filter(|_| margin);
                        if let Some((feature, _)) = feature {
                            ui.ctx().accesskit_node_builder(shown.id, |node| {
                                node.set_description(text!("source-needed-by", feature = feature))
                            });
                        }
                    }
                });
            }
        });
        if let Some(feature) = clicked {
            self.feature = text.features.get(feature).map(|f| f.0.clone());
        }
    }

    /// The feature of a line, named at the start of its run; returns whether it was clicked.
    fn margin(&self, ui: &mut Ui, text: &Text, i: usize, height: f32, first: bool, wanted: Option<usize>) -> bool {
        let Some(line) = text.lines.get(i) else { return false };
        let Some((name, _)) = text.features.get(usize::from(line.feature)) else { return false };
        let width = if self.no_margin { STRIPE_POINTS } else { MARGIN_POINTS };
        // Not a Tab stop of its own: the list is.
        let (rect, response) = ui.allocate_exact_size(Vec2::new(width, height), Sense::CLICK);
        let colour = feature_colour(name, ui.visuals().dark_mode);
        let stripe = egui::Rect::from_min_size(egui::pos2(rect.right() - STRIPE_POINTS, rect.top()), vec2(STRIPE_POINTS, height));
        ui.painter().rect_filled(stripe, 0.0, colour);
        if wanted == Some(usize::from(line.feature)) {
            ui.painter().rect_filled(rect, 0.0, colour.gamma_multiply(0.14));
        }
        if first {
            if !self.no_margin {
                let names = egui::Rect::from_min_max(rect.min, stripe.left_bottom());
                let font = egui::FontId::proportional(SMALL);
                let painter = ui.painter().with_clip_rect(names.intersect(ui.clip_rect()));
                painter.text(names.left_center(), egui::Align2::LEFT_CENTER, name, font, colour);
            }
            let said = text!("source-line", line = i + 1, name = name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &said));
        }
        response.on_hover_text(format!("{name}\n{}", line.origin)).clicked()
    }
}

/// The row to which the keys move from `row`, while the list has the focus, and whether they did.
fn keys(ui: &Ui, stop: &egui::Response, row: usize, count: usize) -> (usize, bool) {
    const PAGE: usize = 20;
    if !stop.has_focus() || count == 0 {
        return (row, false);
    }
    let arrows = egui::EventFilter { vertical_arrows: true, ..egui::EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(stop.id, arrows));
    let last = count - 1;
    let steps = [
        (Key::ArrowDown, (row + 1).min(last)),
        (Key::ArrowUp, row.saturating_sub(1)),
        (Key::PageDown, (row + PAGE).min(last)),
        (Key::PageUp, row.saturating_sub(PAGE)),
        (Key::Home, 0),
        (Key::End, last),
    ];
    let pressed = steps.into_iter().find(|(key, _)| ui.input(|i| i.key_pressed(*key)));
    pressed.map_or((row, false), |(_, to)| (to, true))
}
