//! How the picture is put together: projection, dome, stereo pair.
//!
//! In: the view. Out: the view with another composition. Always: projection and stereo, which do not go together, switch each other off.

use super::Interface;
use crate::scene::request::composition::{DOME_TILT_RANGE_DEG, FISHEYE_RANGE_DEG};
use crate::scene::request::{Projection, StereoLayout};
use crate::view::app::composition_state::CompositionState;
use egui::{ComboBox, Slider, Ui};

/// What each projection is called in the window, and what it is for.
const PROJECTIONS: [(Projection, &str, &str); 3] = [
    (Projection::Perspective, "perspective", "As in a camera: straight lines stay straight"),
    (Projection::Fisheye, "fisheye (dome)", "A circle: the distance from its middle is proportional to the angle. For planetarium domes"),
    (Projection::Equirectangular, "whole sphere", "Equirectangular: longitude along the rows, latitude along the columns"),
];

/// The same of the ways in which two eyes share a picture.
const STEREO: [(Option<StereoLayout>, &str, &str); 4] = [
    (None, "off", "One eye"),
    (Some(StereoLayout::Anaglyph), "anaglyph", "For red and cyan glasses, red on the left"),
    (Some(StereoLayout::SideBySide), "side by side", "The left eye's picture on the left half"),
    (Some(StereoLayout::Interlaced), "interlaced", "Even rows for the left eye: polarised screens"),
];

/// The controls, folded.
pub(super) fn controls(interface: &mut Interface, ui: &mut Ui) {
    let composition = &mut interface.viewer.view.composition;
    egui::CollapsingHeader::new("Projection and stereo").show(ui, |ui| {
        let projection = choice(ui, "Projection", composition.projection, &PROJECTIONS);
        if projection != composition.projection {
            composition.projection = projection;
            composition.stereo = composition.stereo.filter(|_| projection == Projection::Perspective);
        }
        let is_fisheye = composition.projection == Projection::Fisheye;
        if is_fisheye {
            ui.add(Slider::new(&mut composition.fisheye_deg, FISHEYE_RANGE_DEG).suffix("°").text("Dome angle"))
                .on_hover_text("Full angle that the circle shows; of a hemisphere 180°");
            ui.checkbox(&mut composition.dome_zenith, "Zenith in the middle")
                .on_hover_text("The target then stands towards the bottom, where a dome has its front");
        }
        if composition.projection != Projection::Perspective {
            ui.add(Slider::new(&mut composition.dome_tilt_deg, DOME_TILT_RANGE_DEG).suffix("°").text("Tilt"))
                .on_hover_text("How far the middle of the picture is lowered towards its bottom");
        }
        let stereo = choice(ui, "Stereo", composition.stereo, &STEREO);
        if stereo != composition.stereo {
            composition.stereo = stereo;
            if stereo.is_some() {
                composition.projection = Projection::Perspective;
            }
        }
        if !composition.is_plain() && ui.button("Reset").on_hover_text("One perspective picture again").clicked() {
            *composition = CompositionState::default();
        }
    });
}

/// A list with a label; what is chosen now.
fn choice<T: Copy + PartialEq>(ui: &mut Ui, label: &str, mut chosen: T, all: &[(T, &str, &str)]) -> T {
    ui.horizontal(|ui| {
        ui.label(label);
        let shown = all.iter().find(|(value, ..)| *value == chosen).map_or("", |(_, name, _)| name);
        let list = ComboBox::from_id_salt(label).selected_text(shown).width(130.0).show_ui(ui, |ui| {
            for (value, name, hover) in all {
                ui.selectable_value(&mut chosen, *value, *name).on_hover_text(*hover);
            }
        });
        list.response.on_hover_text(label).accessible_name(label);
    });
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_projection_and_every_layout_can_be_chosen() {
        assert!(Projection::ALL.iter().all(|p| PROJECTIONS.iter().filter(|(q, ..)| p == q).count() == 1));
        assert!(StereoLayout::ALL.iter().all(|s| STEREO.iter().filter(|(t, ..)| Some(*s) == *t).count() == 1));
    }
}
