//! The canonical form of a draw's features: without those that do not change the image.
//!
//! In: any features. Out: the canonical features that give the same image, and the rules that led there, each with its reason.

use super::dimension::{DIMENSIONS, Dimension, MAX_LIGHTS};
use crate::scene::draw::{
    AirPass, AtmosphereModel, Detail, DrawFeatures, EclipseModel, MAX_AIR_LIGHTS, PixelView, RingShadow, Shape, Surface,
};
use std::sync::OnceLock;

/// A rule: for features for which `applies` holds, setting `dimension` to `value` does not change the image.
pub struct CanonicalRule {
    /// Name of the dimension.
    pub dimension: &'static str,
    /// The value's text in the key; empty for the value that the key omits.
    pub value: &'static str,
    pub applies: fn(&DrawFeatures) -> bool,
    /// The reason, for messages such as "`normal` changes nothing: REASON".
    pub because: &'static str,
}

fn is_emissive(f: &DrawFeatures) -> bool {
    f.surface == Surface::Emissive
}
/// Whether the image shows radiance, or what that costs to compute.
fn shows_radiance(f: &DrawFeatures) -> bool {
    f.view.shows_radiance()
}
/// Whether the surface is a sky, cloud or ring, which has none of the maps and effects of solid ground.
fn has_no_ground(f: &DrawFeatures) -> bool {
    matches!(f.surface, Surface::Sky | Surface::Cloud | Surface::Ring)
}
/// Whether the image shows light that comes from the Sun or another light: reflected by a surface, or scattered by air.
fn is_lit(f: &DrawFeatures) -> bool {
    shows_radiance(f) && !is_emissive(f) && f.lights > 0
}
/// Whether the image depends on how much sunlight arrives: a lit image, or the pixel view of sunlight.
fn shows_sunlight(f: &DrawFeatures) -> bool {
    is_lit(f) || (f.view == PixelView::Sunlight && f.lights > 0 && !is_emissive(f))
}
/// Whether the pixel's value depends on the surface normal. An emissive surface darkens towards its limb.
fn shows_normal(f: &DrawFeatures) -> bool {
    (is_lit(f) || (shows_radiance(f) && is_emissive(f)) || f.view == PixelView::Normal || (f.view == PixelView::Sunlight && f.lights > 0))
        && f.surface != Surface::Sky
}
/// Whether the draw fills the coarse image (of the air, and of the sunlight past occluders), which the draws of ground and clouds interpolate.
fn fills_coarse_image(f: &DrawFeatures) -> bool {
    f.air_pass.fills_image()
}
/// The rule by which a draw that fills the coarse image omits this dimension.
const fn omitted_in_coarse_image(dimension: &'static str) -> CanonicalRule {
    CanonicalRule { dimension, value: "", applies: fills_coarse_image, because: DRAWN_ALONE }
}
/// The reason of rules for a draw that fills the coarse image.
const DRAWN_ALONE: &str = "the air, or the sunlight past occluders, is drawn alone";
/// Whether the draw fills the coarse image with the sunlight that passes the occluders.
fn draws_sunlight_alone(f: &DrawFeatures) -> bool {
    f.air_pass == AirPass::SunlightDrawn
}
/// Whether the pixel's value depends on the albedo of the ground: not that of clouds and rings, which have a map and a table of their own.
fn shows_albedo(f: &DrawFeatures) -> bool {
    match f.surface {
        Surface::Sky | Surface::Cloud | Surface::Ring => false,
        _ => is_lit(f) || (shows_radiance(f) && is_emissive(f)) || f.view == PixelView::Albedo,
    }
}

/// The rules. As long as any rule changes the features, the first such rule is applied. This ends: each rule lowers the index of its dimension's value or sets
/// the surface to Lambert, which no rule replaces. The value `sunN` stands for N lights, of which the first is the Sun.
pub static RULES: &[CanonicalRule] = &[
    CanonicalRule {
        dimension: "surface",
        value: "lambert",
        applies: |f| {
            f.surface == Surface::Sky
                && (f.air.model == AtmosphereModel::None
                    || !(shows_radiance(f) || f.view == PixelView::OpticalDepth)
                    || (shows_radiance(f) && f.lights == 0))
        },
        because: "a sky without lit air shows nothing",
    },
    CanonicalRule { dimension: "lights", value: "sun0", applies: is_emissive, because: "an emissive surface reflects nothing" },
    CanonicalRule {
        dimension: "lights",
        value: "sun0",
        applies: |f| matches!(f.view, PixelView::Depth | PixelView::Normal | PixelView::Albedo | PixelView::Uv | PixelView::OpticalDepth),
        because: "this view shows no light",
    },
    CanonicalRule {
        dimension: "lights",
        value: "sun0",
        applies: |f| f.view == PixelView::Eclipse && f.eclipse.occluders == 0,
        because: "no occluder is in front of the Sun",
    },
    CanonicalRule {
        dimension: "lights",
        value: "sun0",
        applies: |f| f.view == PixelView::Ring && (f.ring_shadow == RingShadow::None || f.surface == Surface::Ring),
        because: "no ring is in front of the Sun",
    },
    CanonicalRule {
        dimension: "lights",
        value: "sun1",
        applies: |f| matches!(f.view, PixelView::Eclipse | PixelView::Ring) && f.lights > 1,
        because: "this view shows the Sun's light alone",
    },
    CanonicalRule {
        dimension: "surface",
        value: "lambert",
        applies: |f| !shows_radiance(f) && !has_no_ground(f),
        because: "this view does not show how the surface reflects light",
    },
    CanonicalRule {
        dimension: "surface",
        value: "lambert",
        applies: |f| !is_emissive(f) && !has_no_ground(f) && f.lights == 0,
        because: "without a light every reflecting surface is black",
    },
    CanonicalRule { dimension: "shape", value: "sphere", applies: |f| f.surface == Surface::Ring, because: "a ring is flat" },
    CanonicalRule {
        dimension: "shape",
        value: "ellipsoid",
        applies: |f| f.shape == Shape::Mesh && matches!(f.surface, Surface::Sky | Surface::Cloud),
        because: "air and clouds follow the ellipsoid",
    },
    CanonicalRule {
        dimension: "normal",
        value: "",
        applies: |f| !shows_normal(f) || (shows_radiance(f) && is_emissive(f)) || has_no_ground(f),
        because: "relief shows only where light falls on ground, or in the normal view",
    },
    CanonicalRule {
        dimension: "specular",
        value: "",
        applies: |f| !is_lit(f) || has_no_ground(f),
        because: "a glint needs a light and a reflecting ground",
    },
    CanonicalRule {
        dimension: "night",
        value: "",
        applies: |f| !shows_radiance(f) || is_emissive(f) || has_no_ground(f),
        because: "city lights show only on a shaded, reflecting ground",
    },
    CanonicalRule {
        dimension: "cloudshadow",
        value: "",
        applies: |f| !shows_sunlight(f) || has_no_ground(f),
        because: "clouds throw a shadow only where the Sun falls on ground",
    },
    CanonicalRule {
        dimension: "detail",
        value: "",
        applies: |f| !is_lit(f) || f.shape == Shape::Mesh || matches!(f.surface, Surface::Sky | Surface::Ring),
        because: "finer relief than the map shows only on lit ground or clouds of a smooth body",
    },
    CanonicalRule {
        dimension: "detail",
        value: "",
        // Billows on a surface other than clouds, or other detail on clouds.
        applies: |f| (f.surface == Surface::Cloud) != (f.detail == Detail::Billows),
        because: "billows are of clouds, craters and hills of the ground",
    },
    CanonicalRule {
        dimension: "custom-surface",
        value: "",
        applies: |f| !shows_albedo(f) || has_no_ground(f),
        because: "this image does not show the ground's colour",
    },
    CanonicalRule {
        dimension: "overlays",
        value: "",
        applies: |f| !shows_albedo(f) || has_no_ground(f),
        because: "this image does not show the ground's colour",
    },
    CanonicalRule {
        dimension: "occluders",
        value: "",
        applies: |f| f.eclipse.model == EclipseModel::None,
        because: "without a model nothing is darkened",
    },
    CanonicalRule {
        dimension: "occluders",
        value: "",
        applies: |f| !(shows_sunlight(f) || f.view == PixelView::Eclipse && f.lights > 0 && !is_emissive(f)),
        because: "this image does not show the Sun's light",
    },
    CanonicalRule {
        dimension: "eclipse-model",
        value: "",
        applies: |f| f.eclipse.occluders == 0,
        because: "no occluder is in front of the Sun",
    },
    CanonicalRule {
        dimension: "ring-shadow",
        value: "",
        applies: |f| f.surface == Surface::Ring || !(shows_sunlight(f) || f.view == PixelView::Ring && f.lights > 0 && !is_emissive(f)),
        because: "a ring's shadow needs sunlight and something other than the ring",
    },
    CanonicalRule {
        dimension: "ringshine",
        value: "",
        applies: |f| has_no_ground(f) || !shows_sunlight(f),
        because: "a ring lights ground only, and in views that show the light",
    },
    CanonicalRule {
        dimension: "body-shadow",
        value: "",
        applies: |f| f.surface != Surface::Ring || !shows_sunlight(f),
        because: "the body's shadow falls on its ring, in sunlight",
    },
    CanonicalRule {
        dimension: "air",
        value: "",
        applies: |f| {
            is_emissive(f)
                || f.surface == Surface::Ring
                || !(shows_radiance(f) || f.view == PixelView::OpticalDepth)
                || shows_radiance(f) && f.lights == 0
        },
        because: "this image shows no air",
    },
    CanonicalRule { dimension: "air", value: "", applies: |f| f.shape == Shape::Mesh, because: "air lies over an ellipsoid" },
    CanonicalRule { dimension: "mie", value: "", applies: |f| f.air.model == AtmosphereModel::None, because: "there is no air" },
    CanonicalRule { dimension: "absorption", value: "", applies: |f| f.air.model == AtmosphereModel::None, because: "there is no air" },
    CanonicalRule {
        dimension: "air-pass",
        value: "",
        applies: |f| matches!(f.air.model, AtmosphereModel::None | AtmosphereModel::Vertex) && !draws_sunlight_alone(f),
        because: "there is no air whose evaluation it would save",
    },
    CanonicalRule {
        dimension: "air-pass",
        value: "",
        applies: |f| draws_sunlight_alone(f) && (f.eclipse.occluders == 0 || has_no_ground(f) || is_emissive(f) || f.shape == Shape::Mesh),
        because: "nothing takes sunlight from the ground",
    },
    CanonicalRule { dimension: "air", value: "", applies: draws_sunlight_alone, because: "the sunlight past occluders is drawn alone" },
    CanonicalRule {
        dimension: "air-pass",
        value: "",
        applies: |f| f.surface == Surface::Sky || !shows_radiance(f),
        because: "a coarse image holds the light before ground and clouds",
    },
    CanonicalRule {
        dimension: "air-pass",
        value: "",
        applies: |f| f.ring_shadow != RingShadow::None,
        because: "a ring's shadow is finer than the coarse image",
    },
    CanonicalRule {
        dimension: "air-pass",
        // The text of `AirPass::Read`.
        value: "coarse",
        applies: |f| f.air_pass == AirPass::ReadWithClouds && f.surface != Surface::Cloud && !f.maps.cloud_shadow,
        because: "the ground's draw shows the clouds by the map of their shadow",
    },
    CanonicalRule {
        dimension: "surface",
        value: "lambert",
        applies: |f| fills_coarse_image(f) && f.surface != Surface::Cloud,
        because: DRAWN_ALONE,
    },
    CanonicalRule { dimension: "lights", value: "sun1", applies: |f| draws_sunlight_alone(f) && f.lights > 1, because: DRAWN_ALONE },
    CanonicalRule {
        dimension: "lights",
        value: "sun2",
        applies: |f| (f.surface == Surface::Sky || fills_coarse_image(f)) && f.lights > MAX_AIR_LIGHTS,
        because: "the air scatters the light of the Sun and of one other body",
    },
    omitted_in_coarse_image("albedo"),
    omitted_in_coarse_image("normal"),
    omitted_in_coarse_image("specular"),
    omitted_in_coarse_image("night"),
    omitted_in_coarse_image("cloudshadow"),
    omitted_in_coarse_image("detail"),
    omitted_in_coarse_image("custom-surface"),
    omitted_in_coarse_image("overlays"),
    omitted_in_coarse_image("ringshine"),
    omitted_in_coarse_image("limbheights"),
    omitted_in_coarse_image("thinlimb"),
    omitted_in_coarse_image("alphatexture"),
    CanonicalRule {
        dimension: "limbheights",
        value: "",
        applies: |f| has_no_ground(f) || f.shape == Shape::Mesh,
        because: "the limb profile belongs to the Moon's ground, or to the Sun behind the Moon",
    },
    CanonicalRule {
        dimension: "thinlimb",
        value: "",
        applies: |f| !is_lit(f) || f.surface == Surface::Ring || f.shape == Shape::Mesh,
        because: "light ends within a pixel where the Sun lights a smooth globe or its air",
    },
    CanonicalRule {
        dimension: "twosided",
        value: "",
        applies: |f| f.shape != Shape::Mesh,
        because: "a closed body shows its outside only",
    },
    CanonicalRule {
        dimension: "twosided",
        value: "",
        applies: |f| !shows_normal(f),
        because: "this image does not depend on the surface's direction",
    },
    CanonicalRule {
        dimension: "vertexcolour",
        value: "",
        applies: |f| f.shape != Shape::Mesh,
        because: "only a mesh has vertices with a colour",
    },
    CanonicalRule {
        dimension: "vertexcolour",
        value: "",
        applies: |f| !shows_albedo(f),
        because: "this image does not show the surface's colour",
    },
    CanonicalRule {
        dimension: "alphatexture",
        value: "",
        applies: has_no_ground,
        because: "air, clouds and rings have an opacity of their own",
    },
    CanonicalRule {
        dimension: "albedo",
        value: "",
        applies: |f| !shows_albedo(f) && !f.flags.alpha_texture,
        because: "this image does not show the surface's colour",
    },
    CanonicalRule { dimension: "alphatexture", value: "", applies: |f| !f.maps.albedo, because: "alpha comes from the albedo map" },
];

fn dimension_named(name: &str) -> Option<&'static Dimension> {
    DIMENSIONS.iter().find(|d| d.name == name)
}

/// Each rule with its dimension and the index of its value in that dimension, resolved once from the names in [`RULES`]. A test finds unknown names.
fn resolved_rules() -> &'static [(&'static CanonicalRule, &'static Dimension, usize)] {
    static RESOLVED: OnceLock<Vec<(&'static CanonicalRule, &'static Dimension, usize)>> = OnceLock::new();
    RESOLVED.get_or_init(|| {
        let resolve = |rule: &'static CanonicalRule| {
            let dimension = dimension_named(rule.dimension)?;
            Some((rule, dimension, dimension.texts.iter().position(|t| *t == rule.value)?))
        };
        RULES.iter().filter_map(resolve).collect()
    })
}

/// The first rule that changes these features, with its dimension and the index of its value; `None` if the features are canonical.
pub(super) fn first_reduction(features: &DrawFeatures) -> Option<(&'static CanonicalRule, &'static Dimension, usize)> {
    resolved_rules().iter().copied().find(|(rule, dimension, value)| (dimension.get)(features) != *value && (rule.applies)(features))
}

/// The smallest set of features that draws the same image.
pub fn canonical(features: &DrawFeatures) -> DrawFeatures {
    reduce(features, |_| ())
}

/// The rules that make these features canonical, in the order in which they apply.
pub fn reductions(features: &DrawFeatures) -> Vec<&'static CanonicalRule> {
    let mut applied = Vec::new();
    reduce(features, |rule| applied.push(rule));
    applied
}

/// Applies the rules until the features are canonical. `applied` receives each rule that was applied.
fn reduce(features: &DrawFeatures, mut applied: impl FnMut(&'static CanonicalRule)) -> DrawFeatures {
    let mut reduced = *features;
    // No key has more lights.
    reduced.lights = reduced.lights.min(MAX_LIGHTS);
    while let Some((rule, dimension, value)) = first_reduction(&reduced) {
        (dimension.set)(&mut reduced, value);
        applied(rule);
    }
    reduced
}

#[cfg(test)]
mod tests {
    use super::super::random_features;
    use super::*;

    #[test]
    fn every_rule_names_a_dimension_and_a_value_and_is_used() {
        let samples = random_features(1, 20_000);
        for rule in RULES {
            let d = dimension_named(rule.dimension).unwrap_or_else(|| panic!("no dimension {}", rule.dimension));
            assert!(d.texts.contains(&rule.value), "{}: no value {:?}", rule.dimension, rule.value);
            assert!(samples.iter().any(|f| (rule.applies)(f)), "{} never applies", rule.because);
        }
    }

    /// The module `key` may not use these constants of `scene` and `catalog`, and repeats them.
    #[test]
    fn the_greatest_counts_are_those_of_scene_and_catalog() {
        use super::super::dimension::MAX_OVERLAYS;
        assert_eq!((MAX_LIGHTS, MAX_OVERLAYS), (crate::scene::effects::MAX_LIGHTS, crate::catalog::MAX_OVERLAYS));
    }

    #[test]
    fn canonical_is_idempotent_and_only_removes_features() {
        for f in random_features(2, 100_000) {
            let c = canonical(&f);
            assert_eq!(canonical(&c), c, "{f:?}");
            assert_eq!(c.view, f.view, "the pixel view never changes");
            // Rules set the surface to Lambert whatever its index.
            for d in DIMENSIONS.iter().filter(|d| d.name != "surface") {
                assert!((d.get)(&c) <= (d.get)(&f), "{} grew: {f:?}", d.name);
            }
        }
    }

    #[test]
    fn canonical_keeps_all_features_of_a_lit_planet_that_has_every_effect() {
        use crate::scene::draw::{Air, Eclipse, MapSet, MeshFlags};
        let f = DrawFeatures {
            surface: Surface::OrenNayar,
            maps: MapSet { albedo: true, normal: true, specular: true, night: true, cloud_shadow: true },
            overlays: 2,
            lights: 2,
            eclipse: Eclipse { occluders: 4, model: EclipseModel::Refracted },
            ring_shadow: RingShadow::Penumbra,
            ring_shine: true,
            air: Air { model: AtmosphereModel::Table, mie: true, absorption: true },
            shape: Shape::Ellipsoid,
            limb_heights: true,
            thin_limb: true,
            flags: MeshFlags { alpha_texture: true, ..MeshFlags::default() },
            ..DrawFeatures::MINIMAL
        };
        assert_eq!(canonical(&f), f);
        // A mesh has additional flags, but no atmosphere, limb profile or thin limb.
        let flags = MeshFlags { two_sided: true, alpha_texture: true, vertex_colour: true };
        let mesh = DrawFeatures { shape: Shape::Mesh, air: Air::default(), limb_heights: false, thin_limb: false, flags, ..f };
        assert_eq!(canonical(&mesh), mesh);
        assert_eq!(canonical(&DrawFeatures { air: f.air, ..mesh }), mesh);
    }
}
