//! Camera controls below the list of bodies: position, direction and field of view.
//!
//! In: the selected body, the view, clicks. Out: actions; the field of view and the typed place, which the controls set directly.

use super::Interface;
use super::icons::{self, Icon};
use super::number_field::{self, NumberKind};
use crate::catalog::NaifId;
use crate::scene::request::Projection;
use crate::view::app::view_state::{CameraPose, MAX_FOV_DEG, MAX_TYPED_LONGITUDE_DEG, MIN_FOV_DEG, wrapped_longitude_deg};
use crate::view::app::viewer::Action;
use crate::view::language::{body_name, text};
use egui::{Checkbox, Color32, ComboBox, Grid};

/// The widest text of a field of view, for which the rail of its slider leaves room in a narrow list of bodies.
const WIDEST_FOV: &str = "0.000100°";
/// Space for the frame of a field with a number, points.
const FIELD_MARGIN: f32 = 4.0;
/// Least width of the rail of the slider, points.
const MIN_RAIL_WIDTH: f32 = 40.0;

/// The place typed into the fields for *Stand on surface*: planetographic latitude, east longitude. If the Earth is selected, the fields edit the
/// observer's place instead (`InformationPanel::observer_place`), for which events and the times of rise and set are also computed.
#[derive(Default)]
pub(crate) struct TypedPlace {
    latitude_deg: f64,
    longitude_deg: f64,
}

/// Shows all controls; those for a body apply to the selected body.
pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let selected = interface.viewer.selected;
    let name = interface.viewer.name(selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        let [fly, look, level] =
            [(Icon::Fly, text!("camera-fly")), (Icon::LookAt, text!("camera-look-at")), (Icon::Level, text!("camera-level"))]
                .map(|(icon, word)| icons::button(ui, icon, word));
        if ui.add(fly).on_hover_text(text!("camera-fly-hint", name = name)).clicked() {
            actions.push(Action::FlyTo(selected));
        }
        if ui.add(look).on_hover_text(text!("camera-look-at-hint", name = name)).clicked() {
            actions.push(Action::LookAt(selected));
        }
        if ui.add(level).on_hover_text(text!("camera-level-hint")).clicked() {
            actions.push(Action::FaceBody);
        }
    });
    view_from_list(interface, ui, selected, actions);
    let is_earth = selected == NaifId::EARTH;
    let (typed_place, observer_place) = (&mut interface.typed_place, &mut interface.information.observer_place);
    let (latitude_deg, longitude_deg) = if is_earth {
        (&mut observer_place.latitude_deg, &mut observer_place.longitude_deg)
    } else {
        (&mut typed_place.latitude_deg, &mut typed_place.longitude_deg)
    };
    Grid::new("place").num_columns(2).spacing([6.0, 3.0]).show(ui, |ui| {
        for (label, value_deg, kind, limit_deg) in [
            (text!("camera-latitude"), &mut *latitude_deg, NumberKind::Latitude, 90.0),
            (text!("camera-longitude"), &mut *longitude_deg, NumberKind::Longitude, MAX_TYPED_LONGITUDE_DEG),
        ] {
            ui.label(label);
            let name = text!("camera-degrees", label = label);
            number_field::show(ui, value_deg, kind, -limit_deg..=limit_deg, &name, |field| field.speed(0.2).max_decimals(4));
            ui.end_row();
        }
    });
    *longitude_deg = wrapped_longitude_deg(*longitude_deg);
    let stand = icons::button(ui, Icon::Stand, text!("camera-stand"));
    if ui.add(stand).on_hover_text(text!("camera-stand-hint", name = name)).clicked() {
        actions.push(Action::StandOn(*latitude_deg, *longitude_deg));
    }
    let (is_orbit, mut rotates_with_body) = match interface.viewer.view.camera_pose {
        CameraPose::Orbit { is_body_fixed, .. } => (true, is_body_fixed),
        _ => (false, false),
    };
    let checkbox = ui.add_enabled(is_orbit, Checkbox::new(&mut rotates_with_body, text!("camera-rotate")));
    if checkbox.on_hover_text(text!("camera-rotate-hint")).clicked() {
        actions.push(Action::RotateWithBody(rotates_with_body));
    }
    let can_turn = interface.viewer.can_turn();
    let mut tracks_target = interface.viewer.view.tracks || !can_turn;
    let follow = ui.add_enabled(can_turn, Checkbox::new(&mut tracks_target, text!("camera-follow")));
    if follow.on_hover_text(text!("camera-follow-hint")).on_disabled_hover_text(text!("drag-at-centre")).clicked() {
        actions.push(Action::Track(tracks_target));
    }
    let view = &mut interface.viewer.view;
    let available_width = ui.available_width();
    // The angle of a fisheye is set in the Effects panel; an equirectangular image has no field of view.
    let is_perspective = view.composition.projection == Projection::Perspective;
    let fov = number_field::slider(&mut view.fov_deg, NumberKind::Degrees, MIN_FOV_DEG..=MAX_FOV_DEG, |slider| slider.logarithmic(true));
    ui.scope(|ui| {
        let style = ui.style();
        let font = style.drag_value_text_style.resolve(style);
        let number_width = ui.painter().layout_no_wrap(WIDEST_FOV.to_owned(), font, Color32::PLACEHOLDER).size().x;
        let spacing = ui.spacing_mut();
        let besides_rail = number_width + 2.0 * spacing.button_padding.x + spacing.item_spacing.x + FIELD_MARGIN;
        spacing.slider_width = spacing.slider_width.min(available_width - besides_rail).max(MIN_RAIL_WIDTH);
        ui.add_enabled(is_perspective, fov).on_hover_text(text!("camera-fov-hint")).on_disabled_hover_text(text!("camera-fov-disabled"));
    });
}

/// Shows the list of bodies from whose centres the selected body can be viewed.
fn view_from_list(interface: &Interface, ui: &mut egui::Ui, selected: NaifId, actions: &mut Vec<Action>) {
    let current = match interface.viewer.view.camera_pose {
        CameraPose::Centre { body } => interface.viewer.name(body),
        _ => text!("camera-choose-body"),
    };
    ui.horizontal(|ui| {
        ui.label(text!("camera-view-from"));
        let list = ComboBox::from_id_salt("view from").selected_text(current).width(70.0).truncate().show_ui(ui, |ui| {
            for body in interface.viewer.selectable_bodies().iter().filter(|b| b.id != selected) {
                if ui.selectable_label(false, text!("camera-centre-of", body = body_name(&body.name))).clicked() {
                    actions.push(Action::LookFrom(body.id));
                }
            }
        });
        list.response.on_hover_text(text!("camera-view-from-hint")).accessible_name(text!("camera-view-from"));
    });
}
