//! The part of the Key page that compares two keys (a key names a generated shader module): their images of the sample body (a fixed body, see
//! `session::sample_body`), their costs, and the changed source lines by feature. It also tells whether any view of the catalog's bodies can need the displayed
//! key.
//!
//! In: the drawn key, with which the view is drawn; the displayed key, which is the drawn key or one that the user changed by hand; the pinned keys. Out: egui
//! shapes. Always: a difference is the change from the first key to the second; between equal keys none is shown.

use super::module_text::{feature_colour, layout_job};
use super::queries::{KeySwap, LoadedModule, ModuleFailure, ShaderQueries};
use super::{Inspected, PIN_NAMES, ShaderPanel};
use crate::scene::request::ViewRequest;
use crate::shader::ModuleId;
use crate::shader::compare::FeatureDiff;
use crate::shader::key::ShaderKey;
use crate::view::language::{decimal, text};
use crate::view::panels::accessible;
use crate::view::panels::compare::pair::{Pair, PairView};
use crate::view::panels::theme::SMALL_TEXT_POINTS;
use crate::view::worker::render_worker::RenderWorker;
use egui::{CollapsingHeader, Grid, RichText, TextStyle};
use std::sync::Arc;

/// State of the comparison of two keys.
#[derive(Default)]
pub(crate) struct KeyComparison {
    /// Whether to show the current view drawn with the drawn key and with the displayed key.
    shows_view: bool,
    pair_view: PairView,
    /// The last pair of images of the view, and the key with which its second image was drawn.
    last_pair: Option<(ShaderKey, Result<Arc<Pair>, String>)>,
}

impl KeyComparison {
    /// Drops an error, whose text is in the language in which the pair was asked for.
    pub(super) fn forget_failure(&mut self) {
        self.last_pair.take_if(|(_, pair)| pair.is_err());
    }
}

/// The two compared keys and their labels. With two pins: the pinned keys. With one: the pinned key and the displayed key. Without pins: the drawn
/// key and the displayed key. `None` if there is no drawn or no displayed key.
fn compared_keys(panel: &ShaderPanel, inspected: &Inspected<'_>) -> Option<([ShaderKey; 2], [&'static str; 2])> {
    let (drawn_key, key) = (inspected.drawn_key?, inspected.key()?);
    Some(match panel.pins {
        [Some(a), Some(b)] => ([a, b], ["A", "B"]),
        [Some(a), None] => ([a, key], ["A", text!("change-this-key")]),
        [None, Some(b)] => ([key, b], [text!("change-this-key"), "B"]),
        [None, None] => ([drawn_key, key], [text!("change-drawn-key"), text!("change-this-key")]),
    })
}

/// Shows whether any view can need the displayed key, the pinned keys, and a summary of the difference in one line. `has_failure`: whether the page shows
/// already why there is no module of the displayed key.
pub(crate) fn summary(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, has_failure: bool) {
    let Some((keys, names)) = compared_keys(panel, inspected) else { return };
    if let (Some(key), Some(reachable)) = (inspected.key(), panel.queries.reachable_keys(inspected.worker)) {
        let reachable_count = reachable.len();
        match reachable.contains(&key) {
            true => ui.label(text!("change-reachable", of = reachable_count)),
            false => ui.label(text!("change-unreachable", of = reachable_count)),
        };
    }
    for (pin, name) in panel.pins.iter_mut().zip(PIN_NAMES) {
        let Some(key) = *pin else { continue };
        ui.horizontal_wrapped(|ui| {
            ui.label(text!("change-pinned", name = name));
            ui.add(egui::Label::new(RichText::new(key.to_string()).monospace().size(SMALL_TEXT_POINTS)).wrap());
            if ui.small_button(text!("change-unpin", name = name)).on_hover_text(text!("change-unpin-hint")).clicked() {
                *pin = None;
            }
        });
    }
    if keys[0] == keys[1] {
        ui.weak(text!("change-nothing"));
        return;
    }
    let ids = keys.map(ModuleId::Keyed);
    let [first, second] = match both_modules(&mut panel.queries, inspected.worker, &ids) {
        Some(Ok(modules)) => modules,
        // One failure is enough: most often the same mistake makes all modules invalid.
        Some(Err(_)) if has_failure => return,
        Some(Err(failure)) => return super::show_failure(ui, &failure),
        None => {
            accessible::spinner(ui, text!("change-loading"));
            return;
        }
    };
    let lines = match panel.queries.difference(inspected.worker, &ids) {
        Some(Ok(feature_diffs)) => lines_text(&feature_diffs),
        Some(Err(why)) => why,
        None => {
            accessible::spinner(ui, text!("change-loading"));
            return;
        }
    };
    let [a, b] = names;
    let change = |label: &str, count: fn(&LoadedModule) -> usize| format!("{label} {}", change_text(count(&first), count(&second)));
    let costs = [
        change(text!("change-operations"), lane_operations),
        change(text!("cost-texture-reads"), |m| m.ir.texture_reads as usize),
        change(text!("cost-slots"), slots_and_registers),
    ];
    ui.label(RichText::new(text!("change-summary", a = a, b = b, lines = lines, costs = costs.join(", "))).strong());
}

/// Both modules once both have arrived, or the first failure that has arrived.
fn both_modules(
    queries: &mut ShaderQueries,
    worker: &dyn RenderWorker,
    ids: &[ModuleId; 2],
) -> Option<Result<[Arc<LoadedModule>; 2], Arc<ModuleFailure>>> {
    // Request both before waiting for either.
    match [queries.module(worker, &ids[0]), queries.module(worker, &ids[1])] {
        [Some(Err(failure)), _] | [_, Some(Err(failure))] => Some(Err(failure)),
        [Some(Ok(first)), Some(Ok(second))] => Some(Ok([first, second])),
        _ => None,
    }
}

/// The number of changed features, and the numbers of lines that only the first module and only the second module has.
fn lines_text(feature_diffs: &[FeatureDiff]) -> String {
    let sum = |lines: fn(&FeatureDiff) -> usize| feature_diffs.iter().map(lines).sum::<usize>();
    let (gone, new) = (sum(|d| d.only_first.len()), sum(|d| d.only_second.len()));
    text!("change-lines", features = feature_diffs.len(), gone = gone, new = new)
}

/// Formats two counts with the signed difference between them.
fn change_text(first: usize, second: usize) -> String {
    if first == second {
        text!("change-unchanged", to = second)
    } else {
        text!("change-from-to", from = first, to = second, by = format!("{:+}", second as i64 - first as i64))
    }
}

/// Number of operations per lane (a pixel or a vertex) in the software renderer's tapes (lists of operations), vertex and fragment stage together.
fn lane_operations(module: &LoadedModule) -> usize {
    module.tapes.iter().flat_map(|t| t.operations.values()).sum()
}

/// Number of slots (values with one element per lane) and registers (values that all lanes share) of the fragment stage's tape.
fn slots_and_registers(module: &LoadedModule) -> usize {
    module.tapes.iter().filter(|t| t.stage == "fragment").map(|t| (t.slots + t.registers) as usize).sum()
}

/// Shows images, cost and source of both keys.
pub(crate) fn details(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let Some((keys, names)) = compared_keys(panel, inspected) else { return };
    if keys[0] == keys[1] {
        return;
    }
    let ids = keys.map(ModuleId::Keyed);
    sample_images(panel, ui, inspected, &keys, names);
    pair_in_view(panel, ui, inspected);
    let Some(Ok([first, second])) = both_modules(&mut panel.queries, inspected.worker, &ids) else { return };
    CollapsingHeader::new(text!("change-cost")).default_open(true).show(ui, |ui| {
        cost_table(ui, "cost of both", &[(names[0], &first), (names[1], &second)]);
        timings(&mut panel.queries, ui, inspected.worker, &ids, names);
    });
    if let Some(Ok(feature_diffs)) = panel.queries.difference(inspected.worker, &ids) {
        CollapsingHeader::new(text!("change-source")).default_open(true).show(ui, |ui| {
            feature_diffs.iter().for_each(|diff| changed_lines(ui, diff));
        });
    }
}

/// Shows the images of the sample body that the modules of both keys draw.
fn sample_images(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, keys: &[ShaderKey; 2], names: [&str; 2]) {
    ui.horizontal(|ui| {
        for (key, name) in keys.iter().zip(names) {
            ui.vertical(|ui| {
                super::gallery::sample_button(&mut panel.queries, ui, inspected.worker, key, &text!("change-sample", name = name));
                ui.weak(name);
            });
        }
        ui.add(egui::Label::new(text!("change-sample-about")).wrap());
    });
}

/// If the displayed key was changed by hand, shows the current view twice: with the drawn key, and with the displayed key in its place.
fn pair_in_view(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let (Some(draw), Some(key), true) = (inspected.draw, inspected.key(), inspected.is_changed()) else { return };
    ui.checkbox(&mut panel.key_comparison.shows_view, text!("change-in-view")).on_hover_text(text!("change-in-view-hint"));
    if !panel.key_comparison.shows_view {
        return;
    }
    let swap = KeySwap { body: draw.body, part: draw.part.name(), key, image_number: inspected.image_number };
    let request = reduced_request(&inspected.rendered.job.request);
    let comparison = &mut panel.key_comparison;
    if let Some(pair) = panel.queries.swap(inspected.worker, &swap, &request) {
        comparison.last_pair = Some((key, pair));
    }
    let show_error_bounds = None;
    // The last pair of this key stays until the next one arrives.
    match comparison.last_pair.as_ref().filter(|(last_key, _)| *last_key == key) {
        Some((_, Ok(pair))) => {
            comparison.pair_view.show(ui, pair, [text!("change-drawn-key"), text!("change-this-key")], show_error_bounds);
        }
        Some((_, Err(why))) => drop(ui.colored_label(ui.visuals().warn_fg_color, why)),
        None => drop(accessible::spinner(ui, text!("compare-coming"))),
    }
}

/// Largest width of the images of the pair.
const MAX_PAIR_WIDTH_PX: u32 = 480;

/// The request for an image scaled down by an integer, so that it is at most [`MAX_PAIR_WIDTH_PX`] wide.
fn reduced_request(request: &ViewRequest) -> ViewRequest {
    let divisor = request.width.div_ceil(MAX_PAIR_WIDTH_PX).max(1);
    ViewRequest { width: request.width.div_ceil(divisor), height: request.height.div_ceil(divisor), ..request.clone() }
}

/// Shows a button that times both modules, and the times once they are known.
fn timings(queries: &mut ShaderQueries, ui: &mut egui::Ui, worker: &dyn RenderWorker, ids: &[ModuleId; 2], names: [&str; 2]) {
    if ui.button(text!("change-time")).on_hover_text(text!("change-time-hint")).clicked() {
        ids.iter().for_each(|id| queries.start_timing(worker, id));
    }
    for (id, name) in ids.iter().zip(names) {
        match queries.timing(id) {
            Some(Ok(Some(ms))) => drop(ui.label(text!("change-timed", name = name, ms = decimal(ms, 1)))),
            // This module cannot draw the sample body.
            Some(Ok(None)) => drop(ui.label(text!("change-not-timed", name = name))),
            Some(Err(e)) => drop(ui.label(e)),
            None => {}
        }
    }
}

/// Shows the lines of one feature that only one of the two modules has.
fn changed_lines(ui: &mut egui::Ui, diff: &FeatureDiff) {
    let is_dark = ui.visuals().dark_mode;
    let title = text!("change-feature", feature = diff.feature, gone = diff.only_first.len(), new = diff.only_second.len());
    let title = RichText::new(title).color(feature_colour(&diff.feature, is_dark));
    CollapsingHeader::new(title).id_salt(&diff.feature).default_open(false).show(ui, |ui| {
        let font = TextStyle::Monospace.resolve(ui.style());
        let (without_number, no_needle) = (0, "");
        for (sign, lines) in [("-", &diff.only_first), ("+", &diff.only_second)] {
            for line in lines {
                let job = layout_job(without_number, &format!("{sign} {}", line.text), no_needle, &font, is_dark);
                ui.add(egui::Label::new(job).truncate()).on_hover_text(format!("shaders/{}:{}", line.fragment, line.line));
            }
        }
    });
}

/// The label of a count, and the function that computes it.
type CostRow = (&'static str, fn(&LoadedModule) -> usize);

/// The rows of the table of costs.
fn cost_rows() -> [CostRow; 10] {
    let per_pixel = |m: &LoadedModule| m.tapes.iter().find(|t| t.stage == "fragment").map_or(0, |t| t.operations.values().sum());
    let per_vertex = |m: &LoadedModule| m.tapes.iter().find(|t| t.stage == "vertex").map_or(0, |t| t.operations.values().sum());
    [
        (text!("cost-lines"), |m| m.ir.lines as usize),
        (text!("cost-functions"), |m| m.ir.functions as usize),
        (text!("cost-branches"), |m| m.ir.branches as usize),
        (text!("cost-ir-operations"), |m| m.ir.operations.values().sum::<u32>() as usize),
        (text!("cost-texture-reads"), |m| m.ir.texture_reads as usize),
        (text!("cost-uniform-bytes"), |m| m.ir.uniform_bytes as usize),
        (text!("cost-per-pixel"), per_pixel),
        (text!("cost-per-vertex"), per_vertex),
        (text!("cost-per-draw"), |m| m.tapes.iter().map(|t| t.uniform_operations).sum()),
        (text!("cost-slots"), slots_and_registers),
    ]
}

/// Shows the costs of one module, or of two modules with their difference. `grid_id`: egui's id of the table. `modules`: each with the heading of its
/// column.
pub(crate) fn cost_table(ui: &mut egui::Ui, grid_id: &str, modules: &[(&str, &Arc<LoadedModule>)]) {
    Grid::new(grid_id).num_columns(modules.len() + 2).striped(true).spacing([16.0, 3.0]).show(ui, |ui| {
        ui.label("");
        modules.iter().for_each(|(name, _)| drop(ui.strong(*name)));
        ui.end_row();
        for (label, count) in cost_rows() {
            ui.label(label);
            let counts: Vec<usize> = modules.iter().map(|(_, m)| count(m)).collect();
            counts.iter().for_each(|n| drop(ui.monospace(n.to_string())));
            if let [first, second] = counts[..] {
                ui.monospace(if first == second { String::new() } else { format!("{:+}", second as i64 - first as i64) });
            }
            ui.end_row();
        }
    });
}
