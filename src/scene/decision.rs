//! Decisions: whether an effect is drawn, with the value and the threshold that decided it.
//!
//! In: whether an effect exceeds its threshold, and the reason, both computed by the effect's module. Out: [`Decision`]s in a [`DecisionLog`]. Always: the
//! user's choice overrides the threshold, but cannot draw a map that is missing or unreadable.

use crate::catalog::Map;
use crate::message::{Argument, Reason, reason};
use crate::scene::request::effects::{Effect, EffectOverrides};
use crate::scene::resources::Resources;
use crate::scene::stated_errors::StatedError;

/// The decision on one effect of one body in one frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Decision {
    /// The name of an [`Effect`], of a layer (`request::layers`), or of another decision, such as `visible` (the globe or rings are in the frame). In JSON
    /// it is called `feature`.
    #[serde(rename = "feature")]
    pub effect: &'static str,
    /// Whether it is drawn.
    pub on: bool,
    /// The value, its threshold and the comparison, in one line.
    pub reason: Reason,
    /// The model that computes the effect and its error, if there are several models. JSON keeps the name `tier` of earlier versions.
    #[serde(rename = "tier", skip_serializing_if = "Option::is_none")]
    pub stated_error: Option<StatedError>,
}

impl Decision {
    /// The reason, then the model and its error if the effect has several models.
    pub fn description(&self) -> Reason {
        match self.stated_error {
            Some(stated_error) => self.reason.clone().and(stated_error.reason()),
            None => self.reason.clone(),
        }
    }
}

/// The decisions about one body, in the order in which they were made.
pub(crate) struct DecisionLog<'a> {
    overrides: &'a EffectOverrides,
    resources: &'a Resources,
    pub decisions: Vec<Decision>,
}

impl<'a> DecisionLog<'a> {
    pub(crate) fn new(overrides: &'a EffectOverrides, resources: &'a Resources) -> Self {
        Self { overrides, resources, decisions: Vec::new() }
    }

    /// Records the decision with this name ([`Decision::effect`]) and returns `on`.
    pub(crate) fn record(&mut self, name: &'static str, on: bool, reason: Reason) -> bool {
        self.decisions.push(Decision { effect: name, on, reason, stated_error: None });
        on
    }

    /// Adds the model's stated error to the latest decision with this name that is on. `stated_error`: `None` if the effect has only one model.
    pub(crate) fn set_stated_error(&mut self, name: &'static str, stated_error: Option<StatedError>) {
        if let Some(last) = self.decisions.iter_mut().rfind(|d| d.effect == name && d.on) {
            last.stated_error = stated_error;
        }
    }

    /// Records the decision on an effect and returns whether it is drawn: if it exceeds its threshold, unless the user has switched it on or off.
    pub(crate) fn record_effect(&mut self, effect: Effect, exceeds_threshold: bool, reason: Reason) -> bool {
        match self.overrides.override_of(effect) {
            Some(on) => self.record(effect.name(), on, reason!("set-by-you")),
            None => self.record(effect.name(), exceeds_threshold, reason),
        }
    }

    /// Whether the user switched an effect off.
    pub(crate) fn is_switched_off(&self, effect: Effect) -> bool {
        self.overrides.override_of(effect) == Some(false)
    }

    /// Like [`Self::record_effect`] for an effect that needs a map: off if the body has no such map, or if the map's file cannot be read. `by_threshold`:
    /// whether the threshold is exceeded, and the reason; called only if the map is usable.
    pub(crate) fn record_effect_with_map(
        &mut self,
        effect: Effect,
        map: Option<&Map>,
        by_threshold: impl FnOnce() -> (bool, Reason),
    ) -> bool {
        match map {
            None => self.record(effect.name(), false, reason!("not-available")),
            Some(m) if self.resources.is_unreadable(&m.file) => self.record(effect.name(), false, reason!("unreadable", file = &m.file)),
            Some(m) => {
                let (on, reason) = by_threshold();
                self.record_effect(effect, on, with_invented_note(reason, m.invented.as_deref(), |how| reason!("map-invented", how = how)))
            }
        }
    }
}

/// Appends a note to the reason if a map or shape was invented, not measured. `invented`: the catalog's text that says how it was invented, `None` if it was
/// measured; `note`: makes the note from this text.
pub(crate) fn with_invented_note(reason: Reason, invented: Option<&str>, note: impl FnOnce(Argument) -> Reason) -> Reason {
    match invented {
        Some(how) => reason.and(note(invented_text(how))),
        None => reason,
    }
}

/// The catalog's description of how a map or shape was invented, as an argument of a message.
pub(crate) fn invented_text(how: &str) -> Argument {
    // The ids of its translations begin with `invented`.
    Argument::CatalogText("invented", how.to_owned())
}
