//! Controls for the composition of the image: projection, dome, stereo pair.
//!
//! In: the view. Out: the view with another composition. Always: a stereo pair and a projection other than perspective exclude each other; choosing
//! one switches the other off.

use super::Interface;
use super::number_field::{self, NumberKind};
use crate::scene::request::composition::{DOME_TILT_RANGE_DEG, FISHEYE_RANGE_DEG};
use crate::scene::request::{Projection, StereoLayout};
use crate::view::app::composition_state::CompositionState;
use crate::view::language::{text, text_by_id};
use egui::{ComboBox, Ui};

/// Each projection, with the message ids of its name and its tooltip.
const PROJECTIONS: [(Projection, &str, &str); 3] = [
    (Projection::Perspective, "projection-perspective", "projection-perspective-hint"),
    (Projection::Fisheye, "projection-fisheye", "projection-fisheye-hint"),
    (Projection::Equirectangular, "projection-sphere", "projection-sphere-hint"),
];

/// Each stereo layout (`None`: no stereo pair), with the message ids of its name and its tooltip.
const STEREO: [(Option<StereoLayout>, &str, &str); 4] = [
    (None, "stereo-off", "stereo-off-hint"),
    (Some(StereoLayout::Anaglyph), "stereo-anaglyph", "stereo-anaglyph-hint"),
    (Some(StereoLayout::SideBySide), "stereo-side-by-side", "stereo-side-by-side-hint"),
    (Some(StereoLayout::Interlaced), "stereo-interlaced", "stereo-interlaced-hint"),
];

/// Shows the controls under a collapsible heading.
pub(super) fn controls(interface: &mut Interface, ui: &mut Ui) {
    let composition = &mut interface.viewer.view.composition;
    egui::CollapsingHeader::new(text!("projection-heading")).show(ui, |ui| {
        let projection = choice(ui, text!("projection"), composition.projection, &PROJECTIONS);
        if projection != composition.projection {
            composition.projection = projection;
            composition.stereo = composition.stereo.filter(|_| projection == Projection::Perspective);
        }
        let is_fisheye = composition.projection == Projection::Fisheye;
        if is_fisheye {
            let angle = number_field::slider(&mut composition.fisheye_deg, NumberKind::Degrees, FISHEYE_RANGE_DEG, |slider| {
                slider.text(text!("projection-dome-angle"))
            });
            ui.add(angle).on_hover_text(text!("projection-dome-angle-hint"));
            ui.checkbox(&mut composition.is_zenith_centred, text!("projection-zenith")).on_hover_text(text!("projection-zenith-hint"));
        }
        if composition.projection != Projection::Perspective {
            let tilt = number_field::slider(&mut composition.dome_tilt_deg, NumberKind::Degrees, DOME_TILT_RANGE_DEG, |slider| {
                slider.text(text!("projection-tilt"))
            });
            ui.add(tilt).on_hover_text(text!("projection-tilt-hint"));
        }
        let stereo = choice(ui, text!("stereo"), composition.stereo, &STEREO);
        if stereo != composition.stereo {
            composition.stereo = stereo;
            if stereo.is_some() {
                composition.projection = Projection::Perspective;
            }
        }
        if !composition.is_plain() && ui.button(text!("projection-reset")).on_hover_text(text!("projection-reset-hint")).clicked() {
            *composition = CompositionState::default();
        }
    });
}

/// Shows a drop-down list with a label; returns the chosen value. `options`: the values, each with the message ids of its name and tooltip.
fn choice<T: Copy + PartialEq>(ui: &mut Ui, label: &str, mut chosen: T, options: &[(T, &'static str, &'static str)]) -> T {
    ui.horizontal(|ui| {
        ui.label(label);
        let chosen_name = options.iter().find(|(value, ..)| *value == chosen).map_or("", |(_, name, _)| text_by_id(name));
        let list = ComboBox::from_id_salt(label).selected_text(chosen_name).width(130.0).show_ui(ui, |ui| {
            for (value, name, tooltip) in options {
                ui.selectable_value(&mut chosen, *value, text_by_id(name)).on_hover_text(text_by_id(tooltip));
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
        let is_listed_once = |projection: &Projection| PROJECTIONS.iter().filter(|(listed, ..)| listed == projection).count() == 1;
        assert!(Projection::ALL.iter().all(is_listed_once));
        let is_listed_once = |layout: &StereoLayout| STEREO.iter().filter(|(listed, ..)| *listed == Some(*layout)).count() == 1;
        assert!(StereoLayout::ALL.iter().all(is_listed_once));
    }
}
