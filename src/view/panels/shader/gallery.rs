//! The Gallery page: keys that differ from the displayed key in one dimension (one independent choice, such as the surface), each with an image of the
//! sample body (a fixed body, see `session::sample_body`).
//!
//! In: the displayed features. Out: egui shapes; the features of a clicked image, as if changed by hand. Always: each key is shown once; only visible
//! images are drawn.

use super::descriptions::{is_switch, value_text};
use super::queries::{SAMPLE_PX, ShaderQueries};
use super::{Inspected, ShaderPanel};
use crate::scene::draw::DrawFeatures;
use crate::shader::key::{DIMENSIONS, ShaderKey};
use crate::view::language::text;
use crate::view::panels::theme::{HIGHLIGHT_COLOUR, MIN_LIST_HEIGHT, SMALL_TEXT_POINTS};
use crate::view::worker::render_worker::RenderWorker;
use egui::{Color32, ComboBox, Rect, RichText, ScrollArea, Sense, Stroke, Vec2, pos2};

/// State of the Gallery page.
#[derive(Default)]
pub(crate) struct GalleryPage {
    /// Name of the dimension that varies; `None`: each dimension in turn.
    dimension: Option<&'static str>,
}

/// One key of the gallery.
struct Entry {
    /// How the key differs from the displayed one, such as `with mie`.
    caption: String,
    /// Features with this key, not reduced to the key's canonical form: they may include values without effect.
    features: DrawFeatures,
    key: ShaderKey,
}

/// Space of an entry beside its image, and below it for the caption, points.
const ENTRY_MARGIN: Vec2 = Vec2::new(24.0, 34.0);
/// Gap between two rows or columns, points.
const GAP: f32 = 8.0;
/// Addition to the width of a column (image, margin and gap) when the number of columns that fit is computed, points.
const COLUMN_RESERVE: f32 = 4.0;

pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let (Some(drawn_key), Some(key)) = (inspected.drawn_key, inspected.key()) else {
        ui.label(text!("gallery-none"));
        return;
    };
    ui.horizontal(|ui| {
        let label = ui.label(text!("gallery-vary"));
        let chosen_name = panel.gallery.dimension.unwrap_or(text!("gallery-every"));
        let list = ComboBox::from_id_salt("gallery dimension").selected_text(chosen_name).width(160.0).show_ui(ui, |ui| {
            ui.selectable_value(&mut panel.gallery.dimension, None, text!("gallery-every"));
            for dimension in DIMENSIONS {
                ui.selectable_value(&mut panel.gallery.dimension, Some(dimension.name), dimension.name);
            }
        });
        list.response.labelled_by(label.id).on_hover_text(text!("gallery-hint"));
    });
    let displayed_features = panel.edited.unwrap_or(inspected.draw.map_or(*drawn_key.features(), |d| d.features));
    let entries = neighbours(&displayed_features, panel.gallery.dimension);
    ui.weak(text!("gallery-count", count = entries.len().saturating_sub(1)));
    let mut clicked = None;
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        let side = SAMPLE_PX as f32;
        let columns = ((ui.available_width() / (side + ENTRY_MARGIN.x + GAP + COLUMN_RESERVE)) as usize).max(1);
        egui::Grid::new("gallery").num_columns(columns).spacing([GAP, GAP]).show(ui, |ui| {
            for (index, entry) in entries.iter().enumerate() {
                ui.allocate_ui(Vec2::splat(side) + ENTRY_MARGIN, |ui| {
                    ui.vertical(|ui| {
                        ui.set_width(side + ENTRY_MARGIN.x);
                        let name = text!("gallery-inspect", key = entry.caption);
                        let response = sample_button(&mut panel.queries, ui, inspected.worker, &entry.key, &name);
                        if entry.key == key {
                            let outline = Stroke::new(2.0, HIGHLIGHT_COLOUR);
                            ui.painter().rect_stroke(response.rect, 0.0, outline, egui::StrokeKind::Inside);
                        }
                        if response.on_hover_text(entry.key.to_string()).clicked() {
                            clicked = Some(entry.features);
                        }
                        let caption = match panel.pin_names(&entry.key)[..] {
                            [] => entry.caption.clone(),
                            ref names => text!("gallery-pinned", caption = entry.caption, names = names.join(", ")),
                        };
                        ui.add(egui::Label::new(RichText::new(caption).size(SMALL_TEXT_POINTS)).wrap());
                    });
                });
                if (index + 1) % columns == 0 {
                    ui.end_row();
                }
            }
        });
    });
    if let Some(features) = clicked {
        panel.edited = Some(features);
    }
}

/// The key of `base`, then the keys that result if one dimension of `base` is changed, each key once. With `dimension_name`, only that dimension is
/// changed.
fn neighbours(base: &DrawFeatures, dimension_name: Option<&str>) -> Vec<Entry> {
    let mut all = vec![Entry { caption: text!("change-this-key").into(), features: *base, key: ShaderKey::for_draw(base) }];
    for dimension in DIMENSIONS.iter().filter(|d| dimension_name.is_none_or(|name| name == d.name)) {
        for value in 0..dimension.texts.len() {
            let mut features = *base;
            (dimension.set)(&mut features, value);
            let key = ShaderKey::for_draw(&features);
            if all.iter().all(|entry| entry.key != key) {
                let caption = match (is_switch(dimension), value) {
                    (true, 0) => text!("gallery-without", dimension = dimension.name),
                    (true, _) => text!("gallery-with", dimension = dimension.name),
                    (false, _) => format!("{}: {}", dimension.name, value_text(dimension, value)),
                };
                all.push(Entry { caption, features, key });
            }
        }
    }
    all
}

/// Shows the image of the sample body drawn with a key, as a button. `name`: its accessible name.
pub(crate) fn sample_button(
    queries: &mut ShaderQueries,
    ui: &mut egui::Ui,
    worker: &dyn RenderWorker,
    key: &ShaderKey,
    name: &str,
) -> egui::Response {
    let side = Vec2::splat(SAMPLE_PX as f32);
    let (rect, response) = ui.allocate_exact_size(side, Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    // An image is not requested before it is visible.
    if !ui.is_rect_visible(rect) {
        return response;
    }
    ui.painter().rect_filled(rect, 2.0, Color32::BLACK);
    match queries.sample_texture(ui.ctx(), worker, key) {
        Some(Ok(texture)) => {
            let full_uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), rect, full_uv, Color32::WHITE);
            response
        }
        Some(Err(why)) => response.on_hover_text(why),
        None => {
            egui::Spinner::new().paint_at(ui, Rect::from_center_size(rect.center(), Vec2::splat(16.0)));
            response
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::draw::RingShadow;

    #[test]
    fn neighbours_differ_in_one_dimension_and_occur_once() {
        let base = DrawFeatures { lights: 1, ring_shadow: RingShadow::Penumbra, ..DrawFeatures::MINIMAL };
        let rings = neighbours(&base, Some("ring-shadow"));
        assert_eq!(
            rings.iter().map(|entry| entry.features.ring_shadow).collect::<Vec<_>>(),
            [RingShadow::Penumbra, RingShadow::None, RingShadow::PointSun, RingShadow::OfPlanet]
        );
        let in_every_dimension = None;
        let all = neighbours(&base, in_every_dimension);
        let keys: std::collections::BTreeSet<_> = all.iter().map(|entry| entry.key).collect();
        assert!(keys.len() == all.len() && all.len() > rings.len(), "{} entries", all.len());
        // Mie scattering without an atmosphere does not change the key, so it has no entry.
        assert!(all.iter().all(|entry| entry.caption != "with mie"));
    }
}
