//! What a preset has changed in the view besides camera and time, and how the next view undoes it.
//!
//! In: the views before and after the preset. Out: a view without the preset's changes. Always: once the user has changed one of
//! these settings, none of them is changed back.

use super::view_state::ViewState;

/// The settings that a preset may change besides camera and time; the fields are those of [`ViewState`] and of its layers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PresetSettings {
    orbits: bool,
    constellations: bool,
    stars_boost: f64,
    exposure_stops: Option<f64>,
}

impl PresetSettings {
    fn of(view: &ViewState) -> Self {
        let ViewState { orbits, stars_boost, exposure_stops, .. } = *view;
        Self { orbits, constellations: view.layers.constellations, stars_boost, exposure_stops }
    }
}

/// The settings before and after the last preset, so that other views do not inherit its changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PresetChanges {
    settings_before: PresetSettings,
    settings_after: PresetSettings,
}

impl PresetChanges {
    /// The changes of a preset that has replaced `view_before` by `view_after`.
    pub(crate) fn between(view_before: &ViewState, view_after: &ViewState) -> Self {
        Self { settings_before: PresetSettings::of(view_before), settings_after: PresetSettings::of(view_after) }
    }

    /// Undoes the preset's changes, unless the user has changed one of these settings since.
    pub(crate) fn undo(&self, view: &mut ViewState) {
        if PresetSettings::of(view) == self.settings_after {
            self.undo_brightness(view);
            (view.orbits, view.layers.constellations) = (self.settings_before.orbits, self.settings_before.constellations);
        }
    }

    /// Undoes only the brightness of stars and the exposure: a flight from the preset's view to a body keeps the preset's orbits and constellations.
    pub(crate) fn undo_brightness(&self, view: &mut ViewState) {
        if PresetSettings::of(view) == self.settings_after {
            (view.stars_boost, view.exposure_stops) = (self.settings_before.stars_boost, self.settings_before.exposure_stops);
        }
    }
}
