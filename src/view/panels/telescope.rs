//! Controls for a view as in a telescope: the mirrored image, and the field of view of an eyepiece or a camera.
//!
//! In: the settings' telescope, the view. Out: the view with its outline, mirrored, or with its field of view. Always: a telescope of a view, such as one
//! from a link, is also that of the fields; a setup whose field is too wide is not shown.

use super::Interface;
use super::number_field::{self, NumberKind};
use crate::scene::request::Projection;
use crate::scene::request::telescope::{APPARENT_FIELD_RANGE_DEG, TELESCOPE_LENGTH_RANGE_MM};
use crate::view::app::view_state::{MAX_FOV_DEG, MIN_FOV_DEG};
use crate::view::language::{decimal, text};
use egui::{Button, Checkbox, Grid, Ui};

/// Decimals of a field of view, degrees.
const FIELD_DECIMALS: usize = 2;

/// Shows the controls under a collapsible heading.
pub(super) fn controls(interface: &mut Interface, ui: &mut Ui) {
    let (view, setup) = (&mut interface.viewer.view, &mut interface.settings.telescope);
    egui::CollapsingHeader::new(text!("telescope-heading")).show(ui, |ui| {
        if let Some(telescope) = view.telescope {
            setup.set(telescope);
        }
        ui.checkbox(&mut view.is_mirrored, text!("telescope-mirror")).on_hover_text(text!("menu-mirror-hint"));
        ui.horizontal_wrapped(|ui| {
            for (has_camera, name) in [(false, text!("telescope-eyepiece")), (true, text!("telescope-camera"))] {
                ui.selectable_value(&mut setup.has_camera, has_camera, name).on_hover_text(text!("telescope-with-hint"));
            }
        });
        Grid::new("telescope").num_columns(2).spacing([6.0, 3.0]).show(ui, |ui| {
            let length_field = |ui: &mut Ui, label: &str, value_mm: &mut f64| {
                ui.label(label);
                number_field::show(ui, value_mm, NumberKind::Plain, TELESCOPE_LENGTH_RANGE_MM, label, |field| {
                    field.speed(0.5).max_decimals(2)
                });
                ui.end_row();
            };
            length_field(ui, text!("telescope-focal-length"), &mut setup.focal_length_mm);
            if setup.has_camera {
                length_field(ui, text!("telescope-sensor-width"), &mut setup.sensor_width_mm);
                length_field(ui, text!("telescope-sensor-height"), &mut setup.sensor_height_mm);
            } else {
                length_field(ui, text!("telescope-eyepiece-length"), &mut setup.eyepiece_mm);
                ui.label(text!("telescope-apparent-field"));
                number_field::show(
                    ui,
                    &mut setup.apparent_field_deg,
                    NumberKind::Degrees,
                    APPARENT_FIELD_RANGE_DEG,
                    text!("telescope-apparent-field"),
                    |field| field.speed(0.2).max_decimals(1),
                );
                ui.end_row();
            }
        });
        let telescope = setup.telescope();
        let is_possible = telescope.check().is_ok();
        let [width_deg, height_deg] = telescope.size_deg();
        let [width, height] = [width_deg, height_deg].map(|deg| decimal(deg, FIELD_DECIMALS));
        ui.label(match telescope.magnification() {
            _ if !is_possible => text!("telescope-too-wide").to_owned(),
            Some(times) => text!("telescope-eyepiece-field", times = decimal(times, 0), field = width),
            None => text!("telescope-camera-field", width = width, height = height),
        });
        let is_perspective = view.composition.projection == Projection::Perspective;
        let mut is_shown = view.telescope.is_some();
        ui.add_enabled(is_perspective, Checkbox::new(&mut is_shown, text!("telescope-outline")))
            .on_hover_text(text!("telescope-outline-hint"))
            .on_disabled_hover_text(text!("camera-fov-disabled"));
        view.telescope = Some(telescope).filter(|_| is_shown && is_possible);
        let fill = ui.add_enabled(is_perspective && is_possible, Button::new(text!("telescope-fill")));
        if fill.on_hover_text(text!("telescope-fill-hint")).on_disabled_hover_text(text!("camera-fov-disabled")).clicked() {
            view.fov_deg = height_deg.clamp(MIN_FOV_DEG, MAX_FOV_DEG);
        }
    });
}
