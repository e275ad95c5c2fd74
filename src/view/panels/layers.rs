//! Switches of the layers: stars, Milky Way, lines.
//!
//! In: the last scene's decisions about layers, clicks. Out: the view with other layers. Always: a switch's tooltip also states whether the scene
//! draws the layer, and why.

use super::Interface;
use super::number_field::{self, NumberKind};
use crate::scene::request::Layers;
use crate::view::language::{reason_text, text, text_by_id};
use egui::SliderClamping;

/// Name of each layer, and the message ids of its label and its tooltip.
const SWITCHES: [(&str, &str, &str); 18] = [
    ("stars", "sky-stars", "sky-stars-hint"),
    ("bright-stars", "layer-bright-stars", "layer-bright-stars-hint"),
    ("milky-way", "sky-milky-way", "sky-milky-way-hint"),
    ("zodiacal-light", "sky-zodiacal-light", "sky-zodiacal-light-hint"),
    ("star-names", "sky-star-names", "sky-star-names-hint"),
    ("constellations", "sky-constellations", "sky-constellations-hint"),
    ("boundaries", "sky-boundaries", "sky-boundaries-hint"),
    ("grid-equatorial", "sky-grid-equatorial", "sky-grid-equatorial-hint"),
    ("grid-equatorial-date", "sky-grid-equatorial-date", "sky-grid-equatorial-date-hint"),
    ("grid-ecliptic", "sky-grid-ecliptic", "sky-grid-ecliptic-hint"),
    ("grid-galactic", "sky-grid-galactic", "sky-grid-galactic-hint"),
    ("grid-horizon", "sky-grid-horizon", "sky-grid-horizon-hint"),
    ("grid-body", "sky-grid-body", "sky-grid-body-hint"),
    ("terminator", "sky-terminator", "sky-terminator-hint"),
    ("eclipse-path", "sky-eclipse-path", "sky-eclipse-path-hint"),
    ("eclipse-cones", "sky-eclipse-cones", "sky-eclipse-cones-hint"),
    ("instruments", "sky-instruments", "sky-instruments-hint"),
    ("data", "sky-data", "sky-data-hint"),
];

/// Shows the switches, the slider that brightens stars and diffuse light, and the button that resets all of these.
pub(crate) fn switches(interface: &mut Interface, ui: &mut egui::Ui) {
    let decisions = interface.viewport.shown.as_ref().map(|rendered| rendered.scene.sky_decisions.clone()).unwrap_or_default();
    let view = &mut interface.viewer.view;
    egui::CollapsingHeader::new(text!("sky-heading")).show(ui, |ui| {
        for (name, label, tooltip) in SWITCHES {
            let Some(is_on) = view.layers.switch_by_name(name) else { continue };
            let why =
                decisions.iter().find(|d| d.effect == name).map_or_else(String::new, |d| format!("\n{}", reason_text(&d.description())));
            ui.checkbox(is_on, text_by_id(label)).on_hover_text(format!("{}{why}", text_by_id(tooltip)));
        }
        // A view from a link or a file may have a valid value outside the slider's range. Opening the panel must not change it.
        let slider = number_field::slider(&mut view.stars_boost, NumberKind::Plain, 0.0..=20.0, |slider| {
            slider.clamping(SliderClamping::Edits).text(text!("sky-faint-light"))
        });
        ui.add(slider).on_hover_text(text!("sky-faint-light-hint"));
        if ui.button(text!("sky-reset")).on_hover_text(text!("sky-reset-hint")).clicked() {
            (view.layers, view.stars_boost) = (Layers::default(), 0.0);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_switch_is_a_layer_with_a_unique_label() {
        let mut layers = Layers::default();
        for (index, (name, label, tooltip)) in SWITCHES.into_iter().enumerate() {
            assert!(layers.switch_by_name(name).is_some() && !tooltip.is_empty(), "{name}");
            assert!(
                SWITCHES[index + 1..].iter().all(|(later_name, later_label, _)| *later_name != name && *later_label != label),
                "{name}"
            );
        }
    }
}
