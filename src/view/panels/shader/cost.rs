//! The Cost page: operations of the module's IR (naga's intermediate representation) and of its tapes (the lists of operations that the software
//! renderer runs), the module's origin, and statistics of the shader library.
//!
//! In: the displayed module, and the library's statistics as of the last image. Out: egui shapes. Always: a module is timed only when the user asks.

use super::key_comparison::cost_table;
use super::{Inspected, ShaderPanel};
use crate::shader::library::{CacheOutcome, Statistics};
use crate::view::language::{decimal, text};
use crate::view::panels::accessible;
use crate::view::panels::theme::MIN_LIST_HEIGHT;
use egui::{CollapsingHeader, Grid, ScrollArea};
use std::cmp::Reverse;
use std::collections::BTreeMap;

pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let Some(module) = panel.queries.loaded_module(inspected.worker, &inspected.id) else {
        accessible::spinner(ui, text!("module-loading"));
        return;
    };
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        cost_table(ui, "cost", &[(text!("cost-count"), &module)]);
        if inspected.key().is_some() {
            ui.horizontal(|ui| {
                if ui.button(text!("cost-time")).on_hover_text(text!("cost-time-hint")).clicked() {
                    panel.queries.start_timing(inspected.worker, &inspected.id);
                }
                // Milliseconds per megapixel of the sample body; `Ok(None)`: the module cannot draw it.
                match panel.queries.timing(&inspected.id) {
                    Some(Ok(Some(ms))) => drop(ui.label(text!("cost-timed", ms = decimal(ms, 1)))),
                    Some(Ok(None)) => drop(ui.label(text!("cost-not-timed"))),
                    Some(Err(e)) => drop(ui.label(e)),
                    None => {}
                }
            });
        }
        ui.separator();
        ui.strong(text!("cost-library"));
        if let Some(origin) = module.origin {
            let how = match origin.outcome {
                CacheOutcome::Read => text!("cost-loaded"),
                CacheOutcome::Emitted => text!("cost-compiled"),
                CacheOutcome::Repaired => text!("cost-recompiled"),
            };
            ui.label(text!("cost-origin", how = how, ms = decimal(origin.took_ms, 2)));
        }
        match &module.library_entry {
            Some((path, bytes)) => drop(ui.label(text!("cost-entry", size = decimal(*bytes as f64 / 1e3, 1), path = path.display()))),
            None => drop(ui.label(text!("cost-memory-only"))),
        }
        library_statistics(ui, &inspected.rendered.library);
        ui.separator();
        let operations: BTreeMap<&str, usize> = module.ir.operations.iter().map(|(kind, count)| (kind.as_str(), *count as usize)).collect();
        counts_by_kind(ui, text!("cost-ir"), &operations);
        // One per stage. `operations` run for each lane, `uniform_operations` once per draw.
        for tape in &module.tapes {
            let operations: BTreeMap<&str, usize> = tape.operations.iter().map(|(kind, count)| (kind.as_str(), *count)).collect();
            counts_by_kind(ui, &text!("cost-tape", stage = tape.stage), &operations);
            let line = text!(
                "cost-tape-line",
                stage = tape.stage,
                operations = tape.uniform_operations,
                reads = tape.texture_reads,
                jumps = tape.jumps,
                slots = tape.slots,
                registers = tape.registers
            );
            ui.label(line);
        }
    });
}

/// Shows how often the library has read, compiled (`emitted`, including parsing and lowering) and written modules since the session was opened, with the
/// mean time of each.
fn library_statistics(ui: &mut egui::Ui, library: &Statistics) {
    let mean_time = |total_s: f64, count: u64| {
        if count == 0 { String::new() } else { text!("cost-each", ms = decimal(1e3 * total_s / count as f64, 2)) }
    };
    Grid::new("library").num_columns(3).striped(true).spacing([16.0, 3.0]).show(ui, |ui| {
        let rows = [
            (text!("library-memory"), library.from_memory, String::new()),
            (text!("library-disk"), library.from_disk, mean_time(library.reading_s, library.from_disk)),
            (text!("cost-compiled"), library.emitted, mean_time(library.emitting_s, library.emitted)),
            (text!("library-written"), library.written, mean_time(library.writing_s, library.written)),
            (text!("library-repaired"), library.repaired, String::new()),
        ];
        for (label, count, time_each) in rows {
            ui.label(label);
            ui.monospace(count.to_string());
            ui.label(time_each);
            ui.end_row();
        }
    });
}

/// Shows a foldable list of counts by kind of operation, largest first, three in a row. Its title includes their sum.
fn counts_by_kind(ui: &mut egui::Ui, title: &str, counts: &BTreeMap<&str, usize>) {
    let mut sorted: Vec<_> = counts.iter().collect();
    sorted.sort_by_key(|(kind, count)| (Reverse(**count), **kind));
    let total: usize = counts.values().sum();
    CollapsingHeader::new(format!("{title}: {total}")).id_salt(title).default_open(false).show(ui, |ui| {
        Grid::new(title).num_columns(6).striped(true).spacing([12.0, 2.0]).show(ui, |ui| {
            for row in sorted.chunks(3) {
                for (kind, count) in row {
                    ui.monospace(format!("{count:>5}"));
                    ui.label(**kind);
                }
                ui.end_row();
            }
        });
    });
}
