//! The effects that a user can switch on or off, and the user's choices.
//!
//! In: texts such as `+night,-normal,+eclipse=linear`. Out: [`EffectOverrides`]. Always: an unknown effect or model is an error here, so that later stages only
//! match on enums. An unknown body is an error in [`super::ViewRequest::check_bodies`].

use crate::catalog::{Body, normalized_name};
use crate::scene::draw::features::{AtmosphereModel, EclipseModel};
use crate::scene::error::SceneError;
use crate::wording::{echo, echo_within, suggestion_or_list};
use std::collections::{BTreeMap, BTreeSet};

/// An effect that can be switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// The body's oblate or triaxial figure; without this effect it is drawn as a sphere.
    Ellipsoid,
    /// Triangles in place of the ellipsoid.
    Mesh,
    /// The shadow that a mesh casts on itself.
    SelfShadow,
    /// The albedo map.
    Albedo,
    /// Images over the albedo map: a body's overlays, data layers included.
    Overlays,
    /// Relief from the normal map.
    Normal,
    /// Procedural relief and albedo finer than the maps.
    Detail,
    /// The user's WESL function that colours the ground.
    CustomSurface,
    /// Light that water mirrors: of the Sun, of other bodies and of the sky.
    Specular,
    /// City lights of the night side.
    Night,
    /// The cloud shell.
    Clouds,
    /// The clouds' shadow on the ground.
    CloudShadow,
    /// Shadows of other bodies.
    Eclipse,
    /// The rings themselves.
    Rings,
    /// The rings' shadow on their body.
    RingShadow,
    /// The rings' light on their body.
    RingShine,
    /// The body's shadow on its rings.
    BodyShadow,
    /// Scattering and absorption by air.
    Atmosphere,
    /// The Sun's image refracted by the atmosphere at the limb.
    RefractedLimb,
    /// Light reflected by other bodies.
    PlanetShine,
    /// Points for bodies too small for a disc, and the glare of small discs.
    Points,
    /// The glare around the Sun.
    Glare,
    /// The solar corona.
    Corona,
}

impl Effect {
    /// Every effect, in the order in which texts and panels list them.
    pub const ALL: [Self; 23] = [
        Self::Ellipsoid,
        Self::Mesh,
        Self::SelfShadow,
        Self::Albedo,
        Self::Overlays,
        Self::Normal,
        Self::Detail,
        Self::CustomSurface,
        Self::Specular,
        Self::Night,
        Self::Clouds,
        Self::CloudShadow,
        Self::Eclipse,
        Self::Rings,
        Self::RingShadow,
        Self::RingShine,
        Self::BodyShadow,
        Self::Atmosphere,
        Self::RefractedLimb,
        Self::PlanetShine,
        Self::Points,
        Self::Glare,
        Self::Corona,
    ];

    /// The name in options and links.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::Mesh => "mesh",
            Self::SelfShadow => "self-shadow",
            Self::Albedo => "albedo",
            Self::Overlays => "overlays",
            Self::Normal => "normal",
            Self::Detail => "detail",
            Self::CustomSurface => "custom-surface",
            Self::Specular => "specular",
            Self::Night => "night",
            Self::Clouds => "clouds",
            Self::CloudShadow => "cloud-shadow",
            Self::Eclipse => "eclipse",
            Self::Rings => "rings",
            Self::RingShadow => "ring-shadow",
            Self::RingShine => "ring-shine",
            Self::BodyShadow => "body-shadow",
            Self::Atmosphere => "atmosphere",
            Self::RefractedLimb => "refracted-limb",
            Self::PlanetShine => "planet-shine",
            Self::Points => "points",
            // As the name of its shader.
            Self::Glare => "glow",
            Self::Corona => "corona",
        }
    }

    /// Names of the models among which the user may choose, as in `+eclipse=linear`; empty if there is no choice.
    pub fn models(self) -> &'static [&'static str] {
        const ECLIPSE_MODELS: [&str; EclipseModel::CHOICES.len()] = [
            EclipseModel::Linear.name(),
            EclipseModel::UniformDisc.name(),
            EclipseModel::LimbDarkened.name(),
            EclipseModel::Refracted.name(),
        ];
        const ATMOSPHERE_MODELS: [&str; AtmosphereModel::CHOICES.len()] = [
            AtmosphereModel::Vertex.name(),
            AtmosphereModel::Pixel8.name(),
            AtmosphereModel::Pixel16.name(),
            AtmosphereModel::Pixel32.name(),
            AtmosphereModel::Table.name(),
        ];
        match self {
            Self::Eclipse => &ECLIPSE_MODELS,
            Self::Atmosphere => &ATMOSPHERE_MODELS,
            _ => &[],
        }
    }
}

/// The effects that the user switched on or off.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EffectOverrides {
    switched_on: BTreeSet<Effect>,
    switched_off: BTreeSet<Effect>,
    eclipse_model: Option<EclipseModel>,
    air_model: Option<AtmosphereModel>,
    /// Overrides for single bodies, by their names as [`normalized_name`] writes them; they take precedence over overrides for all bodies.
    per_body: BTreeMap<String, EffectOverrides>,
}

impl EffectOverrides {
    /// Reads `+night,-normal,+eclipse=linear`; `moon:-eclipse` applies to one body only. If an effect is named twice, the last sign counts. A model stays
    /// set until another model is named or the effect is switched off. Choosing a model cancels an earlier `-` but is no `+`: the effect's threshold decides.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let mut overrides = Self::default();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            if let Some((body, rest)) = part.split_once(':') {
                if rest.contains(':') {
                    return Err(SceneError::Request(format!("effect `{}`: one body before the colon, one effect after it", echo(part))));
                }
                if rest.trim().is_empty() {
                    return Err(SceneError::Request(format!("effect `{}`: the effect is missing after the colon", echo(part))));
                }
                let body = normalized_name(body);
                // Parsed together with what was read for the body before, so that its last sign counts.
                let previous = overrides.per_body.get(&body).map(Self::to_text).unwrap_or_default();
                overrides.per_body.insert(body, Self::parse(&format!("{previous},{rest}"))?);
                continue;
            }
            let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                _ => return Err(SceneError::Request(format!("effect `{}`: write + or - before its name", echo(part)))),
            };
            let (name, model) = name.split_once('=').map_or((name, None), |(n, m)| (n.trim(), Some(m.trim())));
            let Some(effect) = Effect::ALL.into_iter().find(|e| e.name().eq_ignore_ascii_case(name)) else {
                let known: Vec<_> = Effect::ALL.iter().map(|e| e.name()).collect();
                return Err(SceneError::Request(format!("effect `{}` is not known; {}", echo(name), suggestion_or_list(name, &known))));
            };
            match model {
                None => overrides.set(effect, on),
                Some(_) if !on => {
                    return Err(SceneError::Request(format!(
                        "effect `{}`: only + takes a model; write -{}",
                        echo_within(part, 120),
                        effect.name()
                    )));
                }
                Some(model) => overrides.choose_model(effect, model)?,
            }
        }
        Ok(overrides)
    }

    /// Switches an effect on or off for all bodies.
    pub fn set(&mut self, effect: Effect, on: bool) {
        let (chosen, opposite) =
            if on { (&mut self.switched_on, &mut self.switched_off) } else { (&mut self.switched_off, &mut self.switched_on) };
        chosen.insert(effect);
        opposite.remove(&effect);
        if !on {
            self.clear_model(effect);
        }
    }

    /// All overrides that apply to one body, those for all bodies included. `None` if this body has no overrides of its own; then `self` applies.
    pub fn for_body(&self, name: &str) -> Option<Self> {
        self.for_names(std::iter::once(name))
    }

    /// Like [`Self::for_body`], for all names of a body of the catalog. Overrides under its main name take precedence, because the window uses that name.
    pub(crate) fn for_catalog_body(&self, body: &Body) -> Option<Self> {
        self.for_names(body.aliases.iter().chain(std::iter::once(&body.name)).map(String::as_str))
    }

    /// Whether the user switched an effect of a body on or off; `None` if neither.
    pub(crate) fn override_of_body(&self, body: &Body, effect: Effect) -> Option<bool> {
        self.for_catalog_body(body).as_ref().unwrap_or(self).override_of(effect)
    }

    /// As [`Self::for_body`], for a body with these names: overrides under later names take precedence. `None` if there are none under any of the names.
    fn for_names<'n>(&self, names: impl Iterator<Item = &'n str>) -> Option<Self> {
        if self.per_body.is_empty() {
            return None;
        }
        let mut under_each_name = names.filter_map(|name| self.per_body.get(&normalized_name(name))).peekable();
        under_each_name.peek()?;
        let mut all = Self { per_body: BTreeMap::new(), ..self.clone() };
        under_each_name.for_each(|own| all.replace_by(own));
        Some(all)
    }

    /// Replaces overrides for all bodies by those for one body (`own`), where it has any. A model chosen for the body cancels a `-` for all bodies, as in
    /// [`Self::choose_model`].
    fn replace_by(&mut self, own: &Self) {
        for effect in Effect::ALL {
            if let Some(on) = own.override_of(effect) {
                self.set(effect, on);
            }
            if own.model_name(effect).is_some() {
                self.switched_off.remove(&effect);
            }
        }
        self.eclipse_model = own.eclipse_model.or(self.eclipse_model);
        self.air_model = own.air_model.or(self.air_model);
    }

    /// The overrides of one body only, to be changed.
    pub fn own_overrides_mut(&mut self, name: &str) -> &mut Self {
        self.per_body.entry(normalized_name(name)).or_default()
    }

    /// Removes the entries of bodies that have no overrides left.
    pub fn prune(&mut self) {
        self.per_body.retain(|_, own| *own != Self::default());
    }

    /// Bodies with overrides of their own.
    pub fn bodies(&self) -> impl Iterator<Item = &str> {
        self.per_body.keys().map(String::as_str)
    }

    /// Removes an effect's override and its chosen model, so that the threshold decides.
    pub fn clear_override(&mut self, effect: Effect) {
        self.switched_on.remove(&effect);
        self.switched_off.remove(&effect);
        self.clear_model(effect);
    }

    /// Removes the model that the user chose for an effect.
    fn clear_model(&mut self, effect: Effect) {
        match effect {
            Effect::Eclipse => self.eclipse_model = None,
            Effect::Atmosphere => self.air_model = None,
            _ => {}
        }
    }

    /// The text that [`Self::parse`] reads back.
    pub fn to_text(&self) -> String {
        let effect_texts = |e: &Effect| {
            let model_text = self.model_name(*e).map(|model| format!("+{}={model}", e.name()));
            let switch_text = self.override_of(*e).map(|on| format!("{}{}", if on { '+' } else { '-' }, e.name()));
            switch_text.into_iter().chain(model_text)
        };
        let body_texts = self.per_body.iter().flat_map(|(body, own)| {
            let text = own.to_text();
            text.split(',').filter(|p| !p.is_empty()).map(|p| format!("{body}:{p}")).collect::<Vec<_>>()
        });
        Effect::ALL.iter().flat_map(effect_texts).chain(body_texts).collect::<Vec<_>>().join(",")
    }

    /// Chooses one of [`Effect::models`] by its name, and cancels a `-` of the effect.
    ///
    /// # Errors
    /// The effect has no such model.
    pub fn choose_model(&mut self, effect: Effect, name: &str) -> Result<(), SceneError> {
        let unknown = || {
            SceneError::Request(match effect.models() {
                [] => format!("effect `{}` has only one model: write +{0}", effect.name()),
                known => format!("effect `{}` has no model `{}`; {}", effect.name(), echo(name), suggestion_or_list(name, known)),
            })
        };
        match effect {
            Effect::Eclipse => {
                let model = EclipseModel::CHOICES.into_iter().find(|m| m.name().eq_ignore_ascii_case(name));
                self.eclipse_model = Some(model.ok_or_else(unknown)?);
            }
            Effect::Atmosphere => {
                let model = AtmosphereModel::CHOICES.into_iter().find(|m| m.name().eq_ignore_ascii_case(name));
                self.air_model = Some(model.ok_or_else(unknown)?);
            }
            _ => return Err(unknown()),
        }
        self.switched_off.remove(&effect);
        Ok(())
    }

    /// The eclipse model that the user chose, if any.
    pub fn eclipse_model(&self) -> Option<EclipseModel> {
        self.eclipse_model
    }

    /// The atmosphere model that the user chose, if any.
    pub fn air_model(&self) -> Option<AtmosphereModel> {
        self.air_model
    }

    /// Name of the model that the user chose, if any.
    pub fn model_name(&self, effect: Effect) -> Option<&'static str> {
        match effect {
            Effect::Eclipse => self.eclipse_model.map(EclipseModel::name),
            Effect::Atmosphere => self.air_model.map(AtmosphereModel::name),
            _ => None,
        }
    }

    /// Whether the user switched the effect on or off; `None` if neither.
    pub fn override_of(&self, effect: Effect) -> Option<bool> {
        if self.switched_on.contains(&effect) {
            Some(true)
        } else if self.switched_off.contains(&effect) {
            Some(false)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overrides_are_read_and_unknown_names_rejected() {
        let overrides = EffectOverrides::parse("+night, -normal,+NORMAL,-points").expect("known effects");
        assert_eq!(overrides.override_of(Effect::Night), Some(true));
        assert_eq!(overrides.override_of(Effect::Normal), Some(true));
        assert_eq!(overrides.override_of(Effect::Points), Some(false));
        assert_eq!(overrides.override_of(Effect::Albedo), None);
        let overrides = EffectOverrides::parse("+eclipse=Linear").expect("a model");
        assert_eq!((overrides.model_name(Effect::Eclipse), overrides.override_of(Effect::Eclipse)), (Some("linear"), None));
        assert_eq!(EffectOverrides::parse("+eclipse=linear,-eclipse").expect("both").model_name(Effect::Eclipse), None);
        assert!(EffectOverrides::parse("+eclipse=round").unwrap_err().to_string().contains("limb-darkened"));
        let overrides = EffectOverrides::parse("+night,-clouds,Moon:-eclipse,moon:+albedo,io:+eclipse=linear").expect("effects of bodies");
        let moon = overrides.for_body("Moon").expect("the Moon's own");
        assert_eq!(
            (moon.override_of(Effect::Eclipse), moon.override_of(Effect::Albedo), moon.override_of(Effect::Night)),
            (Some(false), Some(true), Some(true))
        );
        assert_eq!((overrides.override_of(Effect::Eclipse), overrides.for_body("Earth")), (None, None));
        assert_eq!(overrides.for_body("Io").expect("Io's own").model_name(Effect::Eclipse), Some("linear"));
        assert_eq!(EffectOverrides::parse(&overrides.to_text()).expect("what it wrote"), overrides);
        assert_eq!(overrides.bodies().collect::<Vec<_>>(), ["io", "moon"]);
        assert!(EffectOverrides::parse("+night=linear").unwrap_err().to_string().contains("only one model"));
        assert!(EffectOverrides::parse("-eclipse=linear").unwrap_err().to_string().contains("-eclipse"));
        assert!(EffectOverrides::parse("night").unwrap_err().to_string().contains("`night`: write + or -"));
        assert!(EffectOverrides::parse("moon: ").unwrap_err().to_string().contains("`moon:`: the effect is missing"));
        assert!(EffectOverrides::parse("+eclipses").unwrap_err().to_string().contains("did you mean `eclipse`"));
    }

    /// A body's effects can be set under each of its names, however it is written.
    #[test]
    fn other_names_of_a_body_mean_the_same_body() {
        let catalog = crate::catalog::Catalog::embedded();
        let body = |name: &str| catalog.body_named(name).expect("in the catalog");
        let eclipse_override =
            |text: &str, name: &str| EffectOverrides::parse(text).expect("effects").override_of_body(body(name), Effect::Eclipse);
        for text in ["moon:-eclipse", "Luna:-eclipse", " LUNA :-eclipse", "moon:-night,luna:-eclipse"] {
            assert_eq!((eclipse_override(text, "moon"), eclipse_override(text, "earth")), (Some(false), None), "{text}");
        }
        // The alias `1 Ceres`.
        assert_eq!(eclipse_override("1_Ceres:-eclipse", "ceres"), Some(false));
        assert_eq!(eclipse_override("-eclipse,luna:+eclipse", "moon"), Some(true));
        // The window sets effects under the body's main name, which therefore takes precedence.
        assert_eq!(eclipse_override("luna:-eclipse,moon:+eclipse", "moon"), Some(true));
        assert_eq!(eclipse_override("-eclipse,luna:+eclipse", "io"), Some(false));
    }
}
