//! Camera controls below the list of bodies: position and direction of view.

use super::icons::{self, Icon};
use super::{Interface, accessible};
use crate::catalog::NaifId;
use crate::scene::request::Projection;
use crate::view::app::view_state::{CameraPose, MAX_FOV_DEG, MIN_FOV_DEG};
use crate::view::app::viewer::Action;
use egui::{Checkbox, ComboBox, DragValue, Grid, Slider};

/// A place being chosen, degrees.
#[derive(Default)]
pub(crate) struct Standpoint {
    latitude_deg: f64,
    longitude_deg: f64,
}

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let selected = interface.viewer.selected;
    let name = interface.viewer.name(selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        let [fly, look, level] =
            [(Icon::Fly, "Fly"), (Icon::LookAt, "Look at"), (Icon::Level, "Reset roll")].map(|(icon, word)| icons::button(ui, icon, word));
        if ui.add(fly).on_hover_text(format!("Fly to {name} (g)")).clicked() {
            actions.push(Action::FlyTo(selected));
        }
        if ui.add(look).on_hover_text(format!("Look at {name} from here")).clicked() {
            actions.push(Action::LookAt(selected));
        }
        if ui.add(level).on_hover_text("Look at the body again, north up (Home)").clicked() {
            actions.push(Action::FaceSelected);
        }
    });
    from_another(interface, ui, selected, actions);
    let standpoint = &mut interface.standpoint;
    Grid::new("place").num_columns(2).spacing([6.0, 3.0]).show(ui, |ui| {
        for (label, value, most) in
            [("Latitude", &mut standpoint.latitude_deg, 90.0), ("Longitude (E)", &mut standpoint.longitude_deg, 180.0)]
        {
            ui.label(label);
            let field = DragValue::new(value).range(-most..=most).speed(0.2).suffix("°");
            accessible::number(ui, field, &format!("{label}, degrees"));
            ui.end_row();
        }
    });
    let stand = icons::button(ui, Icon::Stand, "Stand on surface");
    if ui.add(stand).on_hover_text(format!("Stand on the surface of {name} at this place")).clicked() {
        actions.push(Action::StandOn(standpoint.latitude_deg, standpoint.longitude_deg));
    }
    let (orbits, mut fixed) = match interface.viewer.view.eye {
        CameraPose::Orbit { fixed, .. } => (true, fixed),
        _ => (false, false),
    };
    let turn = ui.add_enabled(orbits, Checkbox::new(&mut fixed, "Rotate with body"));
    if turn.on_hover_text("Body-fixed frame in place of an inertial one (f)").clicked() {
        actions.push(Action::RotateWithBody(fixed));
    }
    let mut tracks = interface.viewer.view.tracks;
    if ui.checkbox(&mut tracks, "Follow target").on_hover_text("Keep the camera pointed at the target").clicked() {
        actions.push(Action::Track(tracks));
    }
    let view = &mut interface.viewer.view;
    // A fisheye's angle stands with its other controls; a whole sphere has none.
    let perspective = view.composition.projection == Projection::Perspective;
    let fov = Slider::new(&mut view.fov_deg, MIN_FOV_DEG..=MAX_FOV_DEG).logarithmic(true).suffix("°");
    ui.add_enabled(perspective, fov)
        .on_hover_text("Vertical field of view, degrees")
        .on_disabled_hover_text("Of a perspective picture only");
}

/// Views the selected body from the centre of another.
fn from_another(interface: &Interface, ui: &mut egui::Ui, selected: NaifId, actions: &mut Vec<Action>) {
    let now = match interface.viewer.view.eye {
        CameraPose::Centre { body } => interface.viewer.name(body),
        _ => "choose a body",
    };
    ui.horizontal(|ui| {
        ui.label("View from");
        let list = ComboBox::from_id_salt("view from").selected_text(now).width(70.0).truncate().show_ui(ui, |ui| {
            for body in interface.viewer.subjects().iter().filter(|b| b.id != selected) {
                if ui.selectable_label(false, format!("Centre of {}", body.name)).clicked() {
                    actions.push(Action::LookFrom(body.id));
                }
            }
        });
        list.response.on_hover_text("See the selected body from the centre of another").accessible_name("View from");
    });
}
