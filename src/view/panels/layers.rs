//! Switches of the layers (stars, Milky Way, lines), each with the scene's decision about it.

use super::Interface;
use crate::scene::request::Layers;
use egui::Slider;

/// Name of a layer, its label, and what it shows.
const SWITCHES: [(&str, &str, &str); 16] = [
    ("stars", "Stars", "Stars, as far as the exposure shows them"),
    ("milky-way", "Milky Way", "The Milky Way's diffuse light, as far as the exposure shows it"),
    ("zodiacal-light", "Zodiacal light", "Sunlit dust between the planets, as far as the exposure shows it"),
    ("star-names", "Star names", "Proper names of the stars that show"),
    ("constellations", "Constellations", "Figures and names of the 88 constellations"),
    ("boundaries", "Boundaries", "Borders between the constellations"),
    ("grid-equatorial", "Equatorial grid", "Right ascension and declination, ICRF"),
    ("grid-ecliptic", "Ecliptic grid", "Ecliptic longitude and latitude, J2000"),
    ("grid-galactic", "Galactic grid", "Galactic longitude and latitude"),
    ("grid-horizon", "Horizon grid", "Azimuth and altitude, when you stand on a surface"),
    ("grid-body", "Body grid", "Longitude and planetographic latitude on the target"),
    ("terminator", "Terminator", "Where the Sun rises and sets on the target"),
    ("eclipse-path", "Eclipse path", "Umbra and penumbra on the target, and the path of the shadow over its ground"),
    ("eclipse-cones", "Shadow cones", "Umbra and penumbra in space, of the target and of what stands before its Sun"),
    ("instruments", "Instrument fields", "Fields of view of eyepieces, cameras and telescopes around the target"),
    ("data", "Data layers", "Your points, lines and images: [[layer]] of a catalog, or a file dropped on the window"),
];

/// The switches, and the brightening of stars and diffuse light.
pub(crate) fn switches(interface: &mut Interface, ui: &mut egui::Ui) {
    let decisions = interface.viewport.drawing.as_ref().map(|d| d.scene.sky.clone()).unwrap_or_default();
    let view = &mut interface.viewer.view;
    egui::CollapsingHeader::new("Sky and lines").show(ui, |ui| {
        for (name, title, hover) in SWITCHES {
            let Some(on) = view.layers.by_name(name) else { continue };
            let why = decisions.iter().find(|d| d.feature == name).map_or_else(String::new, |d| format!("\n{}", d.description()));
            ui.checkbox(on, title).on_hover_text(format!("{hover}{why}"));
        }
        ui.add(Slider::new(&mut view.stars_boost, 0.0..=20.0).text("Faint light, stops"))
            .on_hover_text("Brighten stars, Milky Way and zodiacal light, to show them beside a lit planet");
        if ui.button("Reset layers").on_hover_text("Stars, Milky Way and zodiacal light as the exposure shows them; no lines").clicked() {
            (view.layers, view.stars_boost) = (Layers::default(), 0.0);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_switch_is_a_layer_with_words_of_its_own() {
        let mut layers = Layers::default();
        for (k, (name, title, hover)) in SWITCHES.into_iter().enumerate() {
            assert!(layers.by_name(name).is_some() && !hover.is_empty(), "{name}");
            assert!(SWITCHES[k + 1..].iter().all(|(other, words, _)| *other != name && *words != title), "{name}");
        }
    }
}
