//! The Values page: the uniforms of a draw with their byte offsets, and its textures with their files.
//!
//! In: the displayed module, and its draw in the last image. Out: egui shapes. Always: the values are those of the last image; if the user has
//! edited the draw's key, its values are shown in the layout of the edited key's module.

use super::queries::ModuleFailure;
use super::{Inspected, ShaderPanel, show_failure};
use crate::render::plan::{self, RING_PROFILE, role_of, uniform_bytes};
use crate::shader::reflect::UniformField;
use crate::shader::{Layout, ModuleId};
use crate::view::error_texts::error_text;
use crate::view::language::{decimal, text};
use crate::view::panels::accessible;
use crate::view::panels::table::{self, SortOrder, SortValue};
use crate::view::panels::theme::{MIN_LIST_HEIGHT, SMALL_TEXT_POINTS};
use egui::{ComboBox, Grid, RichText, ScrollArea, TextEdit};

/// State of the Values page.
#[derive(Default)]
pub(crate) struct ValuesPage {
    /// Only uniforms whose name contains this text are shown.
    filter: String,
    /// The order of the uniforms.
    order: SortOrder,
    /// Index of the chosen draw among those that use the displayed simple shader.
    draw_index: usize,
}

/// Shows the page. `failure`: why there is no module.
pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, failure: Option<&ModuleFailure>) {
    let module = panel.queries.loaded_module(inspected.worker, &inspected.id);
    // The field comes first, so that it stays where it is while a module loads.
    ui.horizontal_wrapped(|ui| {
        let label = ui.label(text!("probe-filter"));
        let field = TextEdit::singleline(&mut panel.values.filter).id_salt("filter of the values").desired_width(120.0);
        ui.add(field).labelled_by(label.id).on_hover_text(text!("values-filter-hint"));
        if let Some(layout) = module.as_ref().map(|loaded| &loaded.module.layout) {
            ui.strong(text!("values-count", count = layout.fields.len(), bytes = layout.uniform_size));
        }
    });
    let Some(module) = module else {
        match failure {
            Some(failure) => show_failure(ui, failure),
            None => drop(accessible::spinner(ui, text!("module-loading"))),
        }
        return;
    };
    let layout = &module.module.layout;
    let bytes = match (inspected.draw, &inspected.id) {
        (Some(draw), _) => Some(uniform_bytes(layout, &draw.uniforms, inspected.rendered.job.sampling.anisotropy)),
        (None, ModuleId::Simple(name)) => simple_module_bytes(panel, ui, inspected, name).map(Ok),
        (None, _) => None,
    };
    match &bytes {
        None => drop(ui.weak(text!("values-unused"))),
        Some(Err(error)) => drop(ui.colored_label(ui.visuals().warn_fg_color, text!("values-none", e = error_text(error)))),
        Some(Ok(_)) => {}
    }
    let bytes = bytes.and_then(Result::ok);
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        uniform_table(ui, layout, bytes.as_deref(), &mut panel.values);
        ui.separator();
        ui.strong(text!("values-textures", textures = layout.textures.len(), samplers = layout.samplers.len()));
        texture_table(panel, ui, inspected, layout);
    });
}

/// The uniform bytes of a draw that uses a simple shader; `None` if no draw uses it. If several do, shows a list to choose one.
fn simple_module_bytes(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, module: &str) -> Option<Vec<u8>> {
    let draws: Vec<_> = inspected.rendered.simple_draws.iter().filter(|d| d.module == module).collect();
    let chosen_index = &mut panel.values.draw_index;
    *chosen_index = (*chosen_index).min(draws.len().checked_sub(1)?);
    if draws.len() > 1 {
        let list = ComboBox::from_label(text!("values-draw")).selected_text(draws[*chosen_index].label.as_str()).show_ui(ui, |ui| {
            for (index, draw) in draws.iter().enumerate() {
                ui.selectable_value(chosen_index, index, draw.label.as_str());
            }
        });
        list.response.on_hover_text(text!("values-draw-hint"));
    } else {
        ui.weak(draws[*chosen_index].label.as_str());
    }
    Some(draws[*chosen_index].uniform_bytes.clone())
}

/// The f32 components of a field; empty if the field extends past the end of the bytes.
fn components_of(field: &UniformField, bytes: &[u8]) -> Vec<f32> {
    let end = field.offset as usize + 4 * field.ty.components();
    let field_bytes = bytes.get(field.offset as usize..end).unwrap_or_default();
    let (components, _) = field_bytes.as_chunks::<4>();
    components.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

/// Formats a number by its magnitude: from 1e-4 to 1e6 with up to six decimals, without trailing zeros; zero as `0`; any other with six significant
/// digits and an exponent.
pub(crate) fn brief_number(v: f32) -> String {
    let magnitude = v.abs();
    if v == v.trunc() && magnitude < 1e6 {
        return format!("{v}");
    }
    if !(1e-4..1e6).contains(&magnitude) {
        return format!("{v:.5e}");
    }
    // The decimal point is removed, too, if rounding leaves no decimals, as for 1 + f32::EPSILON.
    format!("{v:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The value by which a column of the table of uniforms is sorted; the columns are in the order of their titles.
fn sort_value(field: &UniformField, column: usize) -> SortValue {
    match column {
        0 => SortValue::Number(field.offset.into()),
        1 => SortValue::Number(field.size.into()),
        2 => SortValue::Text(field.ty.to_string()),
        _ => SortValue::Text(field.name.clone()),
    }
}

/// Shows the table of uniforms whose name contains the page's filter, in its order; their values are empty without `bytes`.
fn uniform_table(ui: &mut egui::Ui, layout: &Layout, bytes: Option<&[u8]>, page: &mut ValuesPage) {
    /// Largest number of lines, of four components each, that the table shows of a value.
    const MAX_LINES: usize = 3;
    /// Largest number of these lines that the value's tooltip shows.
    const MAX_TOOLTIP_LINES: usize = 60;
    Grid::new("uniforms").num_columns(5).striped(true).spacing([10.0, 3.0]).show(ui, |ui| {
        let titles = [text!("values-offset"), text!("values-bytes"), text!("values-type"), text!("values-name")];
        table::headings(ui, &mut page.order, &titles);
        ui.weak(text!("values-value"));
        ui.end_row();
        let filter = page.filter.trim().to_ascii_lowercase();
        let fields = layout.fields.iter().filter(|f| f.name.contains(&filter));
        let fields = page.order.sorted(fields, |field, column| sort_value(field, column));
        let offsets = table::aligned(fields.iter().map(|field| field.offset.to_string()));
        let sizes = table::aligned(fields.iter().map(|field| field.size.to_string()));
        for ((field, offset), size) in fields.into_iter().zip(offsets).zip(sizes) {
            ui.monospace(offset);
            ui.monospace(size);
            ui.label(RichText::new(field.ty.to_string()).monospace().size(SMALL_TEXT_POINTS));
            ui.label(&field.name);
            let components = bytes.map(|b| components_of(field, b)).unwrap_or_default();
            let lines: Vec<String> =
                components.chunks(4).map(|line| line.iter().map(|v| brief_number(*v)).collect::<Vec<_>>().join(", ")).collect();
            let hidden_lines = lines.len().saturating_sub(MAX_LINES);
            let mut text = lines[..lines.len().min(MAX_LINES)].join("\n");
            if hidden_lines > 0 {
                text.push('\n');
                text.push_str(&text!("values-more", more = hidden_lines));
            }
            let response = ui.add(egui::Label::new(RichText::new(text).monospace().size(SMALL_TEXT_POINTS)).wrap());
            if hidden_lines > 0 {
                response.on_hover_text(RichText::new(lines[..lines.len().min(MAX_TOOLTIP_LINES)].join("\n")).monospace());
            }
            ui.end_row();
        }
    });
}

/// Shows the tables of textures and samplers.
fn texture_table(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, layout: &Layout) {
    Grid::new("textures").num_columns(4).striped(true).spacing([10.0, 3.0]).show(ui, |ui| {
        for heading in [text!("values-binding"), text!("values-name"), text!("values-file"), text!("values-size")] {
            ui.weak(heading);
        }
        ui.end_row();
        for texture in &layout.textures {
            ui.monospace(texture.binding.to_string());
            ui.label(&texture.name);
            let map = inspected.draw.zip(role_of(&texture.name)).and_then(|(draw, role)| {
                let (_, file) = draw.map_files.by_role().find(|(r, _)| *r == role)?;
                Some((file, plan::map_decoding(role, &draw.map_files, draw.features.shape)))
            });
            let ring_table = inspected.draw.and_then(|draw| draw.uniforms.ring.table.as_ref()).filter(|_| texture.name == RING_PROFILE);
            match (map, ring_table) {
                (Some((file, decoding)), _) => {
                    ui.label(file);
                    match panel.queries.map_facts(inspected.worker, file, decoding) {
                        Some(Ok(facts)) => {
                            ui.label(text!(
                                "values-map",
                                width = facts.width,
                                height = facts.height,
                                levels = facts.levels,
                                megabytes = decimal(facts.bytes as f64 / 1e6, 1)
                            ));
                        }
                        Some(Err(why)) => drop(ui.label(why)),
                        None => drop(accessible::spinner(ui, text!("values-map-loading"))),
                    }
                }
                (None, Some(ring_table)) => {
                    ui.label(text!("values-ring-profile"));
                    ui.label(format!("{}x{}, f32", ring_table.width, ring_table.height));
                }
                (None, None) => {
                    ui.weak(text!("values-not-used"));
                    ui.label("");
                }
            }
            ui.end_row();
        }
        for sampler in &layout.samplers {
            ui.monospace(sampler.binding.to_string());
            ui.label(&sampler.name);
            ui.weak(text!("values-sampler"));
            ui.label(text!("values-taps", taps = inspected.rendered.job.sampling.anisotropy));
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_at_their_offsets_and_formatted_briefly() {
        let field = |offset: u32, ty| UniformField { name: "x".into(), ty, offset, size: 12 };
        let bytes: Vec<u8> = [1.0f32, 2.5, -3.0, 4e-9].iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(components_of(&field(4, crate::shader::reflect::FieldType::Vec3), &bytes), [2.5, -3.0, 4e-9]);
        assert!(components_of(&field(8, crate::shader::reflect::FieldType::Vec3), &bytes).is_empty(), "past the end");
        assert_eq!([2.5, -3.0, 4e-9].map(brief_number), ["2.5", "-3", "4.00000e-9"]);
        assert_eq!([1e7, 0.25].map(brief_number), ["1.00000e7", "0.25"]);
        assert_eq!([1.0 + f32::EPSILON, f32::EPSILON - 1.0].map(brief_number), ["1", "-1"]);
    }
}
