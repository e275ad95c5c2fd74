//! Where to stand and which way to face, below the list of bodies.

use super::{Interface, named};
use crate::catalog::NaifId;
use crate::view::sight::{Eye, FOV_LEAST_DEG, FOV_MOST_DEG};
use crate::view::viewer::Action;
use egui::{Checkbox, ComboBox, DragValue, Slider};

/// A place that is being chosen, degrees.
#[derive(Default)]
pub struct Stance {
    latitude_deg: f64,
    longitude_deg: f64,
}

pub fn panel(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let selected = interface.viewer.selected;
    let name = interface.viewer.name(selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        if ui.button("Fly").on_hover_text(format!("Fly to {name} (g)")).clicked() {
            actions.push(Action::FlyTo(selected));
        }
        if ui.button("Face").on_hover_text(format!("Face {name} from here")).clicked() {
            actions.push(Action::LookAt(selected));
        }
        if ui.button("Level").on_hover_text("Face the body again, level (Home)").clicked() {
            actions.push(Action::Level);
        }
    });
    from_another(interface, ui, selected, actions);
    ui.horizontal_wrapped(|ui| {
        let stance = &mut interface.stance;
        let latitude = DragValue::new(&mut stance.latitude_deg).range(-90.0..=90.0).speed(0.2).suffix(" lat");
        named::number(ui, latitude, "Latitude to stand on, degrees");
        let longitude = DragValue::new(&mut stance.longitude_deg).range(-180.0..=180.0).speed(0.2).suffix(" east");
        named::number(ui, longitude, "East longitude to stand on, degrees");
        if ui.button("Stand there").on_hover_text(format!("Stand on the ground of {name}")).clicked() {
            actions.push(Action::StandOn(stance.latitude_deg, stance.longitude_deg));
        }
    });
    let (orbits, mut fixed) = match interface.viewer.sight.eye {
        Eye::Orbit { fixed, .. } => (true, fixed),
        _ => (false, false),
    };
    let turn = ui.add_enabled(orbits, Checkbox::new(&mut fixed, "turn with the body"));
    if turn.on_hover_text("The frame turns with the body, or rests among the stars (f)").clicked() {
        actions.push(Action::TurnWithBody(fixed));
    }
    let mut tracks = interface.viewer.sight.tracks;
    if ui.checkbox(&mut tracks, "track").on_hover_text("Keep facing what is looked at").clicked() {
        actions.push(Action::Track(tracks));
    }
    let lens = Slider::new(&mut interface.viewer.sight.fov_deg, FOV_LEAST_DEG..=FOV_MOST_DEG).logarithmic(true).suffix(" deg");
    ui.add(lens).on_hover_text("Field of view, degrees from top to bottom");
}

/// The selected body through a lens, from the centre of another.
fn from_another(interface: &Interface, ui: &mut egui::Ui, selected: NaifId, actions: &mut Vec<Action>) {
    let now = match interface.viewer.sight.eye {
        Eye::Centre { body } => interface.viewer.name(body).to_owned(),
        _ => "another body".into(),
    };
    ComboBox::from_label("from").selected_text(now).width(110.0).show_ui(ui, |ui| {
        for body in interface.viewer.subjects().iter().filter(|b| b.id != selected) {
            if ui.selectable_label(false, format!("from {}", body.name)).clicked() {
                actions.push(Action::LookFrom(body.id));
            }
        }
    });
}
