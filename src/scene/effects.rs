//! The features a draw can have, what the viewer asked of them, and the one place that turns a choice into [`Needs`].
//!
//! [`possible_needs`] lists what [`Chosen::needs`] can return for any choice that [`Available`] allows, so the keys that are
//! validated ahead of time and the keys that frames use come from the same two functions.

use super::SceneError;
use super::draw::{AirTier, BodyShadow, Eclipse, EclipseModel, Flags, MapSet, Needs, PixelView, RingShadow, Shape, Surface};
use crate::catalog::{Body, Catalog, OVERLAYS_AT_MOST, Photometry, ShapeModel};
use crate::wording::{echo, echo_of, or_one_of};
use std::collections::{BTreeMap, BTreeSet};

/// A feature that can be switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    Ellipsoid,
    /// Triangles in place of the ellipsoid.
    Mesh,
    /// The shadow that a mesh throws on itself.
    SelfShadow,
    Albedo,
    Overlays,
    Normal,
    Specular,
    Night,
    Clouds,
    CloudShadow,
    Eclipse,
    Rings,
    RingShadow,
    RingShine,
    BodyShadow,
    Atmosphere,
    /// The Sun's image that the air at the limb bends to the camera.
    RefractedLimb,
    PlanetShine,
    Points,
    /// The veil of light around the Sun.
    Glow,
    /// The Sun's outermost air.
    Corona,
}

impl Effect {
    pub const ALL: [Self; 21] = [
        Self::Ellipsoid,
        Self::Mesh,
        Self::SelfShadow,
        Self::Albedo,
        Self::Overlays,
        Self::Normal,
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
        Self::Glow,
        Self::Corona,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::Mesh => "mesh",
            Self::SelfShadow => "self-shadow",
            Self::Albedo => "albedo",
            Self::Overlays => "overlays",
            Self::Normal => "normal",
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
            Self::Glow => "glow",
            Self::Corona => "corona",
        }
    }
}

impl Effect {
    /// The ways in which it can be computed, where the viewer may choose one: `+eclipse=linear`.
    pub fn ways(self) -> &'static [&'static str] {
        match self {
            Self::Eclipse => &["linear", "uniform-disc", "limb-darkened", "refracted"],
            Self::Atmosphere => &super::air::WAYS,
            _ => &[],
        }
    }
}

/// What the viewer switched on or off by hand.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EffectOverrides {
    on: BTreeSet<Effect>,
    off: BTreeSet<Effect>,
    ways: BTreeMap<Effect, &'static str>,
    /// For single bodies, by their names in lower case; what is asked here comes before what is asked of all.
    of: BTreeMap<String, EffectOverrides>,
}

impl EffectOverrides {
    /// Reads `+night,-normal,+eclipse=linear`; `moon:-eclipse` is for one body alone. An effect named twice keeps the last sign; a way stays until another is named or the
    /// effect is switched off. A way does not switch an effect on where its bound says no.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let mut overrides = Self::default();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            if let Some((body, rest)) = part.split_once(':') {
                if rest.contains(':') {
                    return Err(SceneError::Request(format!("effect `{}`: one body before the colon, one effect after it", echo(part))));
                }
                let body = body.trim().to_lowercase();
                let so_far = overrides.of.get(&body).map(Self::to_text).unwrap_or_default();
                overrides.of.insert(body, Self::parse(&format!("{so_far},{rest}"))?);
                continue;
            }
            let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                _ => return Err(SceneError::Request(format!("effect `{}`: write + or - before its name", echo(part)))),
            };
            let (name, way) = name.split_once('=').map_or((name, None), |(n, w)| (n.trim(), Some(w.trim())));
            let Some(effect) = Effect::ALL.into_iter().find(|e| e.name().eq_ignore_ascii_case(name)) else {
                let known: Vec<_> = Effect::ALL.iter().map(|e| e.name()).collect();
                return Err(SceneError::Request(format!("effect `{}` is not known; {}", echo(name), or_one_of(name, &known))));
            };
            match way {
                None => overrides.set(effect, on),
                Some(_) if !on => {
                    return Err(SceneError::Request(format!(
                        "effect `{}`: only + takes a way; write -{}",
                        echo_of(part, 120),
                        effect.name()
                    )));
                }
                Some(way) => overrides.choose(effect, way)?,
            }
        }
        Ok(overrides)
    }

    pub fn set(&mut self, effect: Effect, on: bool) {
        let (to, from) = if on { (&mut self.on, &mut self.off) } else { (&mut self.off, &mut self.on) };
        to.insert(effect);
        from.remove(&effect);
        if !on {
            self.ways.remove(&effect);
        }
    }

    /// What holds for one body, where anything is asked of it alone.
    pub fn for_body(&self, name: &str) -> Option<Self> {
        let own = self.of.get(&name.to_lowercase())?;
        let mut both = Self { of: BTreeMap::new(), ..self.clone() };
        for effect in Effect::ALL {
            if let Some(on) = own.asked(effect) {
                both.set(effect, on);
            }
            if let Some(way) = own.way(effect) {
                both.off.remove(&effect);
                both.ways.insert(effect, way);
            }
        }
        Some(both)
    }

    /// What is asked of one body alone, to be changed.
    pub fn of_body(&mut self, name: &str) -> &mut Self {
        self.of.entry(name.to_lowercase()).or_default()
    }

    /// Drops the bodies of which nothing is asked alone.
    pub fn prune(&mut self) {
        self.of.retain(|_, own| *own != Self::default());
    }

    /// Bodies of which something is asked alone.
    pub fn bodies(&self) -> impl Iterator<Item = &str> {
        self.of.keys().map(String::as_str)
    }

    /// Leaves the effect to the scene again.
    pub fn forget(&mut self, effect: Effect) {
        self.on.remove(&effect);
        self.off.remove(&effect);
        self.ways.remove(&effect);
    }

    /// What [`Self::parse`] reads back.
    pub fn to_text(&self) -> String {
        let switched = |e: &Effect| {
            let way = self.ways.get(e).map(|w| format!("+{}={w}", e.name()));
            let on = self.asked(*e).map(|on| format!("{}{}", if on { '+' } else { '-' }, e.name()));
            on.into_iter().chain(way)
        };
        let of_bodies = self.of.iter().flat_map(|(body, own)| {
            let text = own.to_text();
            text.split(',').filter(|p| !p.is_empty()).map(|p| format!("{body}:{p}")).collect::<Vec<_>>()
        });
        Effect::ALL.iter().flat_map(switched).chain(of_bodies).collect::<Vec<_>>().join(",")
    }

    /// Chooses one of [`Effect::ways`].
    pub fn choose(&mut self, effect: Effect, way: &str) -> Result<(), SceneError> {
        let Some(known) = effect.ways().iter().find(|w| w.eq_ignore_ascii_case(way)) else {
            return Err(SceneError::Request(match effect.ways() {
                [] => format!("effect `{}` has one way only: write +{0}", effect.name()),
                ways => format!("effect `{}` has no way `{}`; {}", effect.name(), echo(way), or_one_of(way, ways)),
            }));
        };
        self.off.remove(&effect);
        self.ways.insert(effect, known);
        Ok(())
    }

    /// The way that the viewer chose.
    pub fn way(&self, effect: Effect) -> Option<&'static str> {
        self.ways.get(&effect).copied()
    }

    /// `Some(on)` where the viewer asked.
    pub fn asked(&self, effect: Effect) -> Option<bool> {
        if self.on.contains(&effect) {
            Some(true)
        } else if self.off.contains(&effect) {
            Some(false)
        } else {
            None
        }
    }
}

/// One feature of one body in one frame: whether it is drawn, and the number against the bound that said so.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Decision {
    pub feature: &'static str,
    pub on: bool,
    pub reason: String,
    /// How it is computed, where there is more than one way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tier: Option<super::tiers::Tier>,
}

impl Decision {
    /// Why, and where there are several ways how and how far off.
    pub fn said(&self) -> String {
        match self.tier {
            Some(tier) => format!("{}; {tier}", self.reason),
            None => self.reason.clone(),
        }
    }
}

/// What a body could have drawn, by its catalog entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Available {
    pub ellipsoid: bool,
    pub maps: MapSet,
    pub emissive: bool,
    pub rings: bool,
}

/// Part of the light by which a feature must change a pixel to count: half a level of 256.
pub const VISIBLE_CHANGE: f64 = 1.0 / 512.0;
/// The Sun and at most two other bodies light a draw.
pub const LIGHTS_AT_MOST: u8 = 3;

impl Available {
    pub fn of(body: &Body) -> Self {
        let emissive = matches!(body.photometry, Photometry::Emissive { .. });
        let maps = MapSet {
            albedo: body.maps.albedo.is_some(),
            normal: body.maps.normal.is_some() && !emissive,
            specular: body.maps.specular.is_some() && !emissive,
            night: body.maps.night.is_some() && !emissive,
            cloud_shadow: body.clouds.is_some() && !emissive,
        };
        Self { ellipsoid: flattening(body) > 0.0, maps, emissive, rings: body.rings.iter().any(|r| r.tau_normal > 0.0) }
    }
}

/// Largest relative difference of two semi-axes: the most by which the ellipsoid's normal leans from the sphere's, radians.
pub fn flattening(body: &Body) -> f64 {
    1.0 - body.radii_km.min_element() / body.radii_km.max_element()
}

/// What one draw of a body is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chosen {
    pub ellipsoid: bool,
    /// Triangles in place of the ellipsoid, and how they are drawn.
    pub mesh: Option<Flags>,
    pub maps: MapSet,
    /// Images over the ground.
    pub overlays: u8,
    /// Lights besides the Sun, strongest first.
    pub shine: u8,
    pub eclipse: Eclipse,
    /// Of the sunlight on its rings.
    pub ring_eclipse: Eclipse,
    pub ring_shadow: RingShadow,
    /// The rings light the globe.
    pub ring_shine: bool,
    pub body_shadow: BodyShadow,
    /// How the air is summed; `None` without it.
    pub air: AirTier,
}

impl Chosen {
    /// Whether the rings light the globe. Moons give a thousandth of it (less beside rings that the Sun hardly lights): with both the keys of ringed bodies would be twice as many.
    fn lit_by_rings(self, body: &Body) -> bool {
        let available = Available::of(body);
        self.ring_shine && available.rings && !available.emissive
    }

    /// The structure of the draw. What the body does not have is left out, so no choice can ask for it.
    pub fn needs(self, body: &Body, view: PixelView) -> Needs {
        let available = Available::of(body);
        let air = super::air::structure(body, self.air);
        // Air lies on the true shape: half as many keys, and nobody misses a round one under it.
        let ellipsoid = self.ellipsoid || air.tier != AirTier::None;
        let mesh = self.mesh.zip(body.mesh.as_ref()).filter(|_| air.tier == AirTier::None).map(|(flags, model)| Flags {
            two_sided: flags.two_sided && model.two_sided,
            alpha_texture: flags.alpha_texture && model.alpha && self.maps.albedo && available.maps.albedo,
            vertex_colour: flags.vertex_colour && model.vertex_colours,
        });
        let surface = match body.photometry {
            Photometry::Emissive { .. } => Surface::Emissive,
            Photometry::Lambert => Surface::Lambert,
            Photometry::LommelSeeliger => Surface::LommelSeeliger,
            Photometry::LunarLambert { .. } => Surface::LunarLambert,
            Photometry::OrenNayar { .. } => Surface::OrenNayar,
        };
        Needs {
            surface,
            maps: MapSet {
                albedo: self.maps.albedo && available.maps.albedo,
                normal: self.maps.normal && available.maps.normal,
                specular: self.maps.specular && available.maps.specular,
                night: self.maps.night && available.maps.night,
                cloud_shadow: self.maps.cloud_shadow && available.maps.cloud_shadow,
            },
            overlays: self.overlays.min(body.overlays.len().min(usize::from(OVERLAYS_AT_MOST)) as u8),
            lights: match (available.emissive, self.lit_by_rings(body), self.shine) {
                (true, ..) => 0,
                (false, true, _) | (false, false, 0) => 1,
                // The last of them may be dark: half as many keys.
                (false, false, _) if air.tier != AirTier::None && self.eclipse.casters > 0 => LIGHTS_AT_MOST,
                (false, false, shine) => (1 + shine).min(LIGHTS_AT_MOST),
            },
            eclipse: if available.emissive { Eclipse::default() } else { self.eclipse },
            // Under air in an eclipse the ring's shadow is left out: features.rs says so.
            ring_shadow: if available.rings && !available.emissive && (air.tier == AirTier::None || self.eclipse.casters == 0) {
                self.ring_shadow
            } else {
                RingShadow::None
            },
            ring_shine: self.lit_by_rings(body),
            shape: match mesh {
                Some(_) => Shape::Mesh,
                None if ellipsoid && available.ellipsoid => Shape::Ellipsoid,
                None => Shape::Sphere,
            },
            flags: mesh.unwrap_or_default(),
            air,
            view,
            ..Needs::LEAST
        }
    }
}

impl Chosen {
    /// The structure of the cloud shell's draw; `None` where the body has no clouds or the view shows what lies under them.
    pub fn cloud_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let shown = body.clouds.is_some() && matches!(view, PixelView::Shaded | PixelView::Cost);
        let ground = Self { mesh: None, ..self }.needs(body, view);
        shown.then_some(Needs { surface: Surface::Cloud, maps: MapSet::default(), overlays: 0, ring_shine: false, ..ground })
    }

    /// The structure of the ring's draws; `None` where the body has none.
    pub fn ring_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let available = Available::of(body);
        let needs =
            Needs { surface: Surface::Ring, lights: 1, eclipse: self.ring_eclipse, body_shadow: self.body_shadow, view, ..Needs::LEAST };
        (available.rings && !available.emissive).then_some(needs)
    }

    /// The structure of the draw of the air beside the ground; `None` where there is none or the view does not show it.
    pub fn sky_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let shown = matches!(view, PixelView::Shaded | PixelView::Cost | PixelView::OpticalDepth);
        let ground = self.needs(body, view);
        let sky = Needs { surface: Surface::Sky, maps: MapSet::default(), overlays: 0, ring_shine: false, lights: 1, ..ground };
        (shown && ground.air.tier != AirTier::None).then_some(sky)
    }
}

/// No caster, and every number of casters under every model that the body's system allows.
fn possible_eclipses(catalog: &Catalog, body: &Body) -> Vec<Eclipse> {
    let (most, refracted) = super::eclipse::possible(catalog.bodies(), body);
    let mut all = vec![Eclipse::default()];
    for casters in 1..=most {
        let models = [EclipseModel::Linear, EclipseModel::UniformDisc, EclipseModel::LimbDarkened];
        all.extend(models.map(|model| Eclipse { casters, model }));
        all.extend(refracted.then_some(Eclipse { casters, model: EclipseModel::Refracted }));
    }
    all
}

/// Every set of the maps that a body has.
fn possible_maps(body: &Body) -> Vec<MapSet> {
    let of = Available::of(body).maps;
    let has = |bits: u8, bit: u8| bits & (1 << bit) != 0;
    let set = |bits| MapSet {
        albedo: of.albedo && has(bits, 0),
        normal: of.normal && has(bits, 1),
        specular: of.specular && has(bits, 2),
        night: of.night && has(bits, 3),
        cloud_shadow: of.cloud_shadow && has(bits, 4),
    };
    (0..32).map(set).collect::<BTreeSet<_>>().into_iter().collect()
}

/// No mesh, and the body's: with and without colours, which its file may have.
fn possible_meshes(body: &Body) -> Vec<Option<Flags>> {
    let of = |m: &ShapeModel, vertex_colour| Some(Flags { two_sided: m.two_sided, alpha_texture: m.alpha, vertex_colour });
    let meshes = body.mesh.iter().flat_map(|m| [false, m.vertex_colours].map(|coloured| of(m, coloured)));
    std::iter::once(None).chain(meshes).collect()
}

/// A choice's globe with and without the ring's light, under each number of overlays, by each shape.
fn ground_needs(chosen: Chosen, body: &Body, view: PixelView) -> impl Iterator<Item = Needs> {
    let overlays = 0..=body.overlays.len().min(usize::from(OVERLAYS_AT_MOST)) as u8;
    possible_meshes(body).into_iter().flat_map(move |mesh| {
        let of = move |overlays| [false, true].map(|ring_shine| Chosen { overlays, ring_shine, mesh, ..chosen }.needs(body, view));
        overlays.clone().flat_map(of)
    })
}

/// Every structure that a frame can ask for any body of the catalog under any effects and pixel view, in order, each once.
pub fn possible_needs(catalog: &Catalog) -> Vec<Needs> {
    let both = [false, true];
    let mut all = BTreeSet::new();
    for body in catalog.bodies() {
        let eclipses = possible_eclipses(catalog, body);
        let has_rings = Available::of(body).rings;
        for view in PixelView::ALL {
            for ellipsoid in both {
                for maps in possible_maps(body) {
                    for shine in 0..LIGHTS_AT_MOST {
                        for &eclipse in &eclipses {
                            // The two shadows are parts of different draws, so that their values need not be crossed.
                            let shadows = RingShadow::ALL.into_iter().zip(BodyShadow::ALL);
                            for (ring_shadow, body_shadow) in shadows.take(if has_rings { RingShadow::ALL.len() } else { 1 }) {
                                let air = AirTier::None;
                                let chosen = Chosen {
                                    ellipsoid,
                                    maps,
                                    shine,
                                    eclipse,
                                    ring_eclipse: eclipse,
                                    ring_shadow,
                                    body_shadow,
                                    air,
                                    ..Chosen::default()
                                };
                                all.extend(ground_needs(chosen, body, view));
                                all.extend(chosen.cloud_needs(body, view));
                                all.extend(chosen.ring_needs(body, view));
                            }
                            for air in super::air::possible_tiers(body) {
                                for ring_shadow in RingShadow::ALL {
                                    let chosen = Chosen { ellipsoid, maps, shine, eclipse, air, ring_shadow, ..Chosen::default() };
                                    all.extend(ground_needs(chosen, body, view));
                                    all.extend(chosen.cloud_needs(body, view));
                                    all.extend(chosen.sky_needs(body, view));
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    all.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overrides_are_read_or_refused_by_name() {
        let o = EffectOverrides::parse("+night, -normal,+NORMAL,-points").expect("known effects");
        assert_eq!(o.asked(Effect::Night), Some(true));
        assert_eq!(o.asked(Effect::Normal), Some(true));
        assert_eq!(o.asked(Effect::Points), Some(false));
        assert_eq!(o.asked(Effect::Albedo), None);
        let o = EffectOverrides::parse("+eclipse=Linear").expect("a way");
        assert_eq!((o.way(Effect::Eclipse), o.asked(Effect::Eclipse)), (Some("linear"), None));
        assert_eq!(EffectOverrides::parse("+eclipse=linear,-eclipse").expect("both").way(Effect::Eclipse), None);
        assert!(EffectOverrides::parse("+eclipse=round").unwrap_err().to_string().contains("limb-darkened"));
        let o = EffectOverrides::parse("+night,-clouds,Moon:-eclipse,moon:+albedo,io:+eclipse=linear").expect("effects of bodies");
        let moon = o.for_body("Moon").expect("the Moon's own");
        assert_eq!(
            (moon.asked(Effect::Eclipse), moon.asked(Effect::Albedo), moon.asked(Effect::Night)),
            (Some(false), Some(true), Some(true))
        );
        assert_eq!((o.asked(Effect::Eclipse), o.for_body("Earth")), (None, None));
        assert_eq!(o.for_body("Io").expect("Io's own").way(Effect::Eclipse), Some("linear"));
        assert_eq!(EffectOverrides::parse(&o.to_text()).expect("what it wrote"), o);
        assert_eq!(o.bodies().collect::<Vec<_>>(), ["io", "moon"]);
        assert!(EffectOverrides::parse("+night=linear").unwrap_err().to_string().contains("one way"));
        assert!(EffectOverrides::parse("-eclipse=linear").unwrap_err().to_string().contains("-eclipse"));
        assert!(EffectOverrides::parse("night").unwrap_err().to_string().contains("`night`: write + or -"));
        assert!(EffectOverrides::parse("+eclipses").unwrap_err().to_string().contains("did you mean `eclipse`"));
    }

    /// What an eclipse changes in the structure of a draw: itself, and under air the ring's shadow and the number of lights, upward.
    #[test]
    fn an_eclipse_takes_no_light_but_the_suns() {
        let catalog = Catalog::embedded();
        let eclipse = Eclipse { casters: 1, model: EclipseModel::LimbDarkened };
        let (mut under_air, mut by_rings) = (0, 0);
        for body in catalog.bodies() {
            for air in super::super::air::possible_tiers(body) {
                for (shine, ring_shine) in [(0, false), (1, false), (2, false), (0, true)] {
                    let chosen = Chosen { shine, ring_shine, air, ..Chosen::default() };
                    let plain = chosen.needs(body, PixelView::Shaded);
                    let dim = Chosen { eclipse, ..chosen }.needs(body, PixelView::Shaded);
                    assert_eq!(Needs { eclipse: plain.eclipse, lights: plain.lights, ..dim }, plain, "{}", body.name);
                    assert!(dim.lights == plain.lights || air != AirTier::None && plain.lights > 1 && dim.lights > plain.lights);
                    under_air += usize::from(air != AirTier::None && shine > 0 && dim.lights > 1 && dim.eclipse == eclipse);
                    by_rings += usize::from(air != AirTier::None && dim.ring_shine && dim.eclipse == eclipse);
                }
            }
        }
        assert!(under_air > 20 && by_rings > 10, "{under_air} {by_rings}");
    }

    #[test]
    fn nothing_is_possible_that_the_body_does_not_have() {
        let catalog = Catalog::embedded();
        let all = possible_needs(&catalog);
        let sun = catalog.body(crate::catalog::NaifId::SUN).expect("the Sun");
        let everything = MapSet { albedo: true, normal: true, specular: true, night: true, cloud_shadow: true };
        let needs = Chosen { ellipsoid: true, maps: everything, shine: 200, ..Chosen::default() }.needs(sun, PixelView::Shaded);
        assert_eq!((needs.surface, needs.lights, needs.maps.night), (Surface::Emissive, 0, false));
        assert!(all.contains(&needs));
        assert!(all.iter().all(|n| n.lights <= LIGHTS_AT_MOST && (n.surface == Surface::Emissive) == (n.lights == 0)));
        assert!(!all.iter().any(|n| n.shape == Shape::Mesh));
        let foreign = Needs { flags: Flags { two_sided: true, ..Flags::default() }, ..needs };
        assert!(!all.contains(&foreign));
    }

    #[test]
    fn a_mesh_is_possible_where_the_catalog_names_one_with_what_it_allows() {
        let file = |rest: &str| {
            let text = format!("[[body]]\nid = 401\n[body.mesh]\nfile = \"phobos.obj\"\n{rest}");
            Catalog::with_files(&[("mine.toml".into(), text)]).expect("reads")
        };
        let flags = |catalog: &Catalog| -> BTreeSet<Flags> {
            possible_needs(catalog).into_iter().filter(|n| n.shape == Shape::Mesh).map(|n| n.flags).collect()
        };
        let plain = Flags::default();
        assert_eq!(flags(&file("")), [plain, Flags { vertex_colour: true, ..plain }].into());
        let cut = Flags { two_sided: true, alpha_texture: true, vertex_colour: false };
        // Without its map nothing is cut out.
        let both = [cut, Flags { alpha_texture: false, ..cut }].into();
        assert_eq!(flags(&file("two_sided = true\nalpha = true\nvertex_colours = false\n")), both);
    }
}
