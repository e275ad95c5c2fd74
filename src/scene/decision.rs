//! Decisions: which feature is drawn, and the number against the bound that said so.

use crate::catalog::Map;
use crate::scene::request::effects::{Effect, EffectOverrides};
use crate::scene::resources::Resources;
use crate::scene::tiers::Tier;

/// One feature of one body in one frame: whether it is drawn, and the number against the bound that said so.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Decision {
    /// The name of an effect, or of what depends on several.
    pub feature: &'static str,
    /// Whether it is drawn.
    pub on: bool,
    /// The number against its bound, in one line.
    pub reason: String,
    /// How it is computed, where there is more than one way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tier: Option<Tier>,
}

impl Decision {
    /// Why, and where there are several ways how and how far off.
    pub fn description(&self) -> String {
        match self.tier {
            Some(tier) => format!("{}; {tier}", self.reason),
            None => self.reason.clone(),
        }
    }
}

/// The decisions about one body, in the order in which they were made.
pub(crate) struct DecisionLog<'a> {
    effects: &'a EffectOverrides,
    resources: &'a Resources,
    pub decisions: Vec<Decision>,
}

impl<'a> DecisionLog<'a> {
    pub fn new(effects: &'a EffectOverrides, resources: &'a Resources) -> Self {
        Self { effects, resources, decisions: Vec::new() }
    }

    /// Notes a decision and hands it back.
    pub fn note(&mut self, feature: &'static str, on: bool, reason: String) -> bool {
        self.decisions.push(Decision { feature, on, reason, tier: None });
        on
    }
    /// Says how a feature that was decided on is computed.
    pub fn tier(&mut self, feature: &'static str, tier: Option<Tier>) {
        if let Some(last) = self.decisions.iter_mut().rfind(|d| d.feature == feature && d.on) {
            last.tier = tier;
        }
    }
    /// The bound decides, unless the viewer asked.
    pub fn effect(&mut self, effect: Effect, by_bound: bool, reason: String) -> bool {
        match self.effects.override_of(effect) {
            Some(on) => self.note(effect.name(), on, "set by you".into()),
            None => self.note(effect.name(), by_bound, reason),
        }
    }
    /// Whether the viewer switched an effect off.
    pub fn is_switched_off(&self, effect: Effect) -> bool {
        self.effects.override_of(effect) == Some(false)
    }
    /// A map: absent and unreadable files cannot be asked for.
    pub fn map(&mut self, effect: Effect, map: Option<&Map>, bound: impl FnOnce() -> (bool, String)) -> bool {
        match map {
            None => self.note(effect.name(), false, "not available for this body".into()),
            Some(m) if self.resources.is_unreadable(&m.file) => {
                self.note(effect.name(), false, format!("{} could not be read: drawn without it", m.file))
            }
            Some(m) => {
                let (on, reason) = bound();
                self.effect(effect, on, with_invented(reason, "the map", m.invented.as_deref()))
            }
        }
    }
}

/// A reason, and what of the thing it is about is invented.
pub(crate) fn with_invented(reason: String, what: &str, invented: Option<&str>) -> String {
    match invented {
        Some(how) => format!("{reason}; {what} is invented: {how}"),
        None => reason,
    }
}
