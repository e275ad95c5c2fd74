//! The difference of two keys: whether views can need them, source by feature, cost, pictures.

use super::queries::{KeySwap, LoadedModule, ShaderQueries};
use super::text::{feature_colour, layout_job};
use super::{Inspected, ShaderPanel};
use crate::scene::request::ViewRequest;
use crate::shader::ModuleId;
use crate::shader::compare::FeatureDiff;
use crate::shader::key::ShaderKey;
use crate::view::panels::accessible;
use crate::view::panels::compare::pair::{Pair, PairView};
use crate::view::panels::theme::SMALL;
use crate::view::worker::render_worker::RenderWorker;
use egui::{CollapsingHeader, Grid, RichText, TextStyle};
use std::sync::Arc;

#[derive(Default)]
pub(crate) struct ChangeView {
    /// The comparison is of the current view.
    in_view: bool,
    pair: PairView,
    last: Option<(ShaderKey, Result<Arc<Pair>, String>)>,
}

/// The two compared keys and their labels.
fn compared_keys(panel: &ShaderPanel, inspected: &Inspected<'_>) -> Option<([ShaderKey; 2], [&'static str; 2])> {
    let (drawn, key) = (inspected.drawn?, inspected.key()?);
    Some(match panel.pins {
        [Some(a), Some(b)] => ([a, b], ["A", "B"]),
        [Some(a), None] => ([a, key], ["A", "this key"]),
        [None, Some(b)] => ([key, b], ["this key", "B"]),
        [None, None] => ([drawn, key], ["the drawn key", "this key"]),
    })
}

/// Whether a view can need the key, and the change in a line or two.
pub(crate) fn summary(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let Some((keys, names)) = compared_keys(panel, inspected) else { return };
    if let (Some(key), Some(reachable)) = (inspected.key(), panel.queries.reachable(inspected.worker)) {
        let of = reachable.len();
        match reachable.contains(&key) {
            true => ui.label(format!("Reachable: one of {of} keys that views of this catalog can need.")),
            false => ui.label(format!("Not reachable: none of the {of} keys that views of this catalog can need.")),
        };
    }
    for (pin, name) in panel.pins.iter_mut().zip(["A", "B"]) {
        let Some(key) = *pin else { continue };
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{name} is pinned:"));
            ui.add(egui::Label::new(RichText::new(key.to_string()).monospace().size(SMALL)).wrap());
            if ui.small_button(format!("Unpin {name}")).on_hover_text("Forget the key that was kept for comparison").clicked() {
                *pin = None;
            }
        });
    }
    if keys[0] == keys[1] {
        ui.weak("Change a dimension to see what would change in source, cost and picture.");
        return;
    }
    let ids = keys.map(ModuleId::Planet);
    let Some((first, second)) = both(&mut panel.queries, inspected.worker, &ids) else {
        accessible::coming(ui, "Loading both modules");
        return;
    };
    let lines = match panel.queries.difference(inspected.worker, &ids) {
        Some(Ok(by_feature)) => lines_text(&by_feature),
        Some(Err(e)) => e,
        None => String::new(),
    };
    let [a, b] = names;
    let change = |what: &str, of: fn(&LoadedModule) -> usize| format!("{what} {}", signed(of(&first), of(&second)));
    let costs =
        [change("operations", lane_operations), change("texture reads", |m| m.ir.texture_reads as usize), change("registers", registers)];
    ui.label(RichText::new(format!("From {a} to {b}: {lines}; {}.", costs.join(", "))).strong());
}

fn both(queries: &mut ShaderQueries, worker: &dyn RenderWorker, ids: &[ModuleId; 2]) -> Option<(Arc<LoadedModule>, Arc<LoadedModule>)> {
    // Request both before waiting for either.
    let [first, second] = [queries.whole(worker, &ids[0]), queries.whole(worker, &ids[1])];
    Some((first?, second?))
}

fn lines_text(by_feature: &[FeatureDiff]) -> String {
    let count = |of: fn(&FeatureDiff) -> usize| by_feature.iter().map(of).sum::<usize>();
    let (gone, new) = (count(|d| d.only_first.len()), count(|d| d.only_second.len()));
    format!("{} features differ, {gone} lines removed, {new} added", by_feature.len())
}

/// `from` and `to` with the difference between them.
fn signed(from: usize, to: usize) -> String {
    if from == to { format!("{to} (unchanged)") } else { format!("{from} to {to} ({:+})", to as i64 - from as i64) }
}

/// Lane operations of the software renderer's tapes.
pub(crate) fn lane_operations(m: &LoadedModule) -> usize {
    m.tapes.iter().flat_map(|t| t.operations.values()).sum()
}

/// Live values of the fragment stage: slots of a lane and registers of all.
pub(crate) fn registers(m: &LoadedModule) -> usize {
    m.tapes.iter().filter(|t| t.stage == "fragment").map(|t| (t.slots + t.registers) as usize).sum()
}

/// Cost, pictures and source of both keys.
pub(crate) fn details(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let Some((keys, names)) = compared_keys(panel, inspected) else { return };
    if keys[0] == keys[1] {
        return;
    }
    let ids = keys.map(ModuleId::Planet);
    pictures(panel, ui, inspected, &keys, names);
    in_view(panel, ui, inspected);
    let Some((first, second)) = both(&mut panel.queries, inspected.worker, &ids) else { return };
    CollapsingHeader::new("Cost of both").default_open(true).show(ui, |ui| {
        grid(ui, "cost of both", &[(names[0], &first), (names[1], &second)]);
        timing(&mut panel.queries, ui, inspected.worker, &ids, names);
    });
    if let Some(Ok(by_feature)) = panel.queries.difference(inspected.worker, &ids) {
        CollapsingHeader::new("Source by feature").default_open(true).show(ui, |ui| {
            by_feature.iter().for_each(|d| feature(ui, d));
        });
    }
}

fn pictures(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, keys: &[ShaderKey; 2], names: [&str; 2]) {
    ui.horizontal(|ui| {
        for (key, name) in keys.iter().zip(names) {
            ui.vertical(|ui| {
                super::gallery::sample(&mut panel.queries, ui, inspected.worker, key, &format!("The sample body drawn by {name}"));
                ui.weak(name);
            });
        }
        ui.add(egui::Label::new("The sample body: slightly flattened, lit from the side, the same maps for every key.").wrap());
    });
}

/// The current view with this key in place of the drawn one.
fn in_view(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let (Some(draw), Some(key), true) = (inspected.draw, inspected.key(), inspected.is_changed()) else { return };
    ui.checkbox(&mut panel.change.in_view, "Draw in this view").on_hover_text("Draw the current view with this key in place of its own");
    if !panel.change.in_view {
        return;
    }
    let swap = KeySwap { body: draw.body, part: draw.part.name(), key, view: inspected.view };
    let request = reduced_request(&inspected.drawing.job.request);
    let change = &mut panel.change;
    if let Some(drawn) = panel.queries.swap(inspected.worker, &swap, &request) {
        change.last = Some((key, drawn));
    }
    // The last picture of this key stays until the next one arrives.
    match change.last.as_ref().filter(|(of, _)| *of == key) {
        Some((_, Ok(pair))) => change.pair.show(ui, pair, ["the drawn key", "this key"], None),
        Some((_, Err(why))) => drop(ui.colored_label(ui.visuals().warn_fg_color, why)),
        None => drop(accessible::coming(ui, "Drawing both images")),
    }
}

/// At most 480 pixels wide.
fn reduced_request(request: &ViewRequest) -> ViewRequest {
    let divisor = request.width.div_ceil(480).max(1);
    ViewRequest { width: request.width.div_ceil(divisor), height: request.height.div_ceil(divisor), ..request.clone() }
}

fn timing(queries: &mut ShaderQueries, ui: &mut egui::Ui, worker: &dyn RenderWorker, ids: &[ModuleId; 2], names: [&str; 2]) {
    if ui.button("Time both").on_hover_text("Draw a megapixel of the sample body with each key, in software").clicked() {
        ids.iter().for_each(|id| queries.time(worker, id));
    }
    for (id, name) in ids.iter().zip(names) {
        match queries.timed(id) {
            Some(Ok(Some(ms))) => drop(ui.label(format!("{name}: {ms:.1} ms per megapixel in software"))),
            Some(Ok(None)) => drop(ui.label(format!("{name}: not timed (only ray-traced bodies are)"))),
            Some(Err(e)) => drop(ui.label(e)),
            None => {}
        }
    }
}

fn feature(ui: &mut egui::Ui, d: &FeatureDiff) {
    let dark = ui.visuals().dark_mode;
    let title = format!("{}: {} lines removed, {} added", d.feature, d.only_first.len(), d.only_second.len());
    let title = RichText::new(title).color(feature_colour(&d.feature, dark));
    CollapsingHeader::new(title).id_salt(&d.feature).default_open(false).show(ui, |ui| {
        let font = TextStyle::Monospace.resolve(ui.style());
        for (sign, lines) in [("-", &d.only_first), ("+", &d.only_second)] {
            for line in lines {
                let shown = layout_job(0, &format!("{sign} {}", line.text), "", &font, dark);
                ui.add(egui::Label::new(shown).truncate()).on_hover_text(format!("shaders/{}:{}", line.fragment, line.line));
            }
        }
    });
}

/// A label, and the function that counts.
type CostRow = (&'static str, fn(&LoadedModule) -> usize);

/// Rows of a table of costs.
pub(crate) fn cost_rows() -> [CostRow; 10] {
    let fragment = |m: &LoadedModule| m.tapes.iter().find(|t| t.stage == "fragment").map_or(0, |t| t.operations.values().sum());
    let vertex = |m: &LoadedModule| m.tapes.iter().find(|t| t.stage == "vertex").map_or(0, |t| t.operations.values().sum());
    [
        ("lines of WGSL", |m| m.ir.lines as usize),
        ("functions", |m| m.ir.functions as usize),
        ("branches", |m| m.ir.branches as usize),
        ("operations in the IR", |m| m.ir.operations.values().sum::<u32>() as usize),
        ("texture reads", |m| m.ir.texture_reads as usize),
        ("uniform bytes", |m| m.ir.uniform_bytes as usize),
        ("operations per pixel", fragment),
        ("operations per vertex", vertex),
        ("operations per draw", |m| m.tapes.iter().map(|t| t.uniform_operations).sum()),
        ("slots and registers", registers),
    ]
}

/// Two columns and their difference, or one.
pub(crate) fn grid(ui: &mut egui::Ui, id: &str, of: &[(&str, &Arc<LoadedModule>)]) {
    Grid::new(id).num_columns(of.len() + 2).striped(true).spacing([16.0, 3.0]).show(ui, |ui| {
        ui.label("");
        of.iter().for_each(|(name, _)| drop(ui.strong(*name)));
        ui.end_row();
        for (what, count) in cost_rows() {
            ui.label(what);
            let counts: Vec<usize> = of.iter().map(|(_, m)| count(m)).collect();
            counts.iter().for_each(|n| drop(ui.monospace(n.to_string())));
            if let [from, to] = counts[..] {
                ui.monospace(if from == to { String::new() } else { format!("{:+}", to as i64 - from as i64) });
            }
            ui.end_row();
        }
    });
}
