//! Which values mean nothing beside which others.

use super::dimension::{DIMENSIONS, Dimension};
use crate::scene::draw::{AtmosphereModel, DrawFeatures, EclipseModel, PixelView, RingShadow, Shape, Surface};
use std::sync::OnceLock;

/// Where `applies` holds, the dimension `of` may take the value `least` and the image stays the same.
pub struct CanonicalRule {
    pub of: &'static str,
    /// The value's text (empty: the one that is not written).
    pub least: &'static str,
    pub applies: fn(&DrawFeatures) -> bool,
    /// Completes "… changes nothing: …".
    pub because: &'static str,
}

fn emissive(n: &DrawFeatures) -> bool {
    n.surface == Surface::Emissive
}
/// Whether the pixel shows the light itself, or the work of finding it.
fn full(n: &DrawFeatures) -> bool {
    matches!(n.view, PixelView::Final | PixelView::Cost)
}
/// Air, cloud and ring: nothing that a ground has.
fn no_ground(n: &DrawFeatures) -> bool {
    matches!(n.surface, Surface::Sky | Surface::Cloud | Surface::Ring)
}
/// Whether the picture shows light that falls on something.
fn lit(n: &DrawFeatures) -> bool {
    full(n) && !emissive(n) && n.lights > 0
}
/// Whether the picture shows how much sunlight arrives.
fn shows_sunlight(n: &DrawFeatures) -> bool {
    lit(n) || (n.view == PixelView::Sunlight && n.lights > 0 && !emissive(n))
}
/// Whether the pixel's value depends on the direction of the surface.
fn shows_normal(n: &DrawFeatures) -> bool {
    (lit(n) || (full(n) && emissive(n)) || n.view == PixelView::Normal || (n.view == PixelView::Sunlight && n.lights > 0))
        && n.surface != Surface::Sky
}
/// Whether the pixel's value depends on the surface's own colour. Clouds have a map, rings a table of their own.
fn shows_albedo(n: &DrawFeatures) -> bool {
    match n.surface {
        Surface::Sky | Surface::Cloud | Surface::Ring => false,
        _ => lit(n) || (full(n) && emissive(n)) || n.view == PixelView::Albedo,
    }
}

/// Applied in order until nothing changes; each rule only takes away, so that ends.
pub static RULES: &[CanonicalRule] = &[
    CanonicalRule {
        of: "surface",
        least: "lambert",
        applies: |n| {
            n.surface == Surface::Sky
                && (n.air.tier == AtmosphereModel::None || !(full(n) || n.view == PixelView::OpticalDepth) || (full(n) && n.lights == 0))
        },
        because: "a sky without lit air shows nothing",
    },
    CanonicalRule { of: "lights", least: "sun0", applies: emissive, because: "an emissive surface reflects nothing" },
    CanonicalRule {
        of: "lights",
        least: "sun0",
        applies: |n| matches!(n.view, PixelView::Depth | PixelView::Normal | PixelView::Albedo | PixelView::Uv | PixelView::OpticalDepth),
        because: "this view shows no light",
    },
    CanonicalRule {
        of: "lights",
        least: "sun0",
        applies: |n| n.view == PixelView::Eclipse && n.eclipse.occluders == 0,
        because: "no occluder stands before the Sun",
    },
    CanonicalRule {
        of: "lights",
        least: "sun0",
        applies: |n| n.view == PixelView::Ring && (n.ring_shadow == RingShadow::None || n.surface == Surface::Ring),
        because: "no ring stands before the Sun",
    },
    CanonicalRule {
        of: "lights",
        least: "sun1",
        applies: |n| matches!(n.view, PixelView::Eclipse | PixelView::Ring) && n.lights > 1,
        because: "this view shows the Sun's light alone",
    },
    CanonicalRule {
        of: "surface",
        least: "lambert",
        applies: |n| !full(n) && !no_ground(n),
        because: "this view does not show how the surface turns light",
    },
    CanonicalRule {
        of: "surface",
        least: "lambert",
        applies: |n| !emissive(n) && !no_ground(n) && n.lights == 0,
        because: "without a light every reflecting surface is black",
    },
    CanonicalRule { of: "shape", least: "sphere", applies: |n| n.surface == Surface::Ring, because: "a ring is flat" },
    CanonicalRule {
        of: "shape",
        least: "ellipsoid",
        applies: |n| n.shape == Shape::Mesh && matches!(n.surface, Surface::Sky | Surface::Cloud),
        because: "air and clouds follow the ellipsoid",
    },
    CanonicalRule {
        of: "normal",
        least: "",
        applies: |n| !shows_normal(n) || (full(n) && emissive(n)) || no_ground(n),
        because: "relief shows only where light falls on ground, or in the normal view",
    },
    CanonicalRule {
        of: "specular",
        least: "",
        applies: |n| !lit(n) || no_ground(n),
        because: "a glint needs a light and a reflecting ground",
    },
    CanonicalRule {
        of: "night",
        least: "",
        applies: |n| !full(n) || emissive(n) || no_ground(n),
        because: "city lights show only on a shaded, reflecting ground",
    },
    CanonicalRule {
        of: "cloudshadow",
        least: "",
        applies: |n| !shows_sunlight(n) || no_ground(n),
        because: "clouds throw a shadow only where the Sun falls on ground",
    },
    CanonicalRule {
        of: "detail",
        least: "",
        applies: |n| !lit(n) || no_ground(n) || n.shape == Shape::Mesh,
        because: "finer relief than the map shows only on lit ground of a smooth body",
    },
    CanonicalRule {
        of: "custom-surface",
        least: "",
        applies: |n| !shows_albedo(n) || no_ground(n),
        because: "this image does not show the ground's colour",
    },
    CanonicalRule {
        of: "overlays",
        least: "",
        applies: |n| !shows_albedo(n) || no_ground(n),
        because: "this image does not show the ground's colour",
    },
    CanonicalRule {
        of: "occluders",
        least: "",
        applies: |n| n.eclipse.model == EclipseModel::None,
        because: "without a model nothing is darkened",
    },
    CanonicalRule {
        of: "occluders",
        least: "",
        applies: |n| !(shows_sunlight(n) || n.view == PixelView::Eclipse && n.lights > 0 && !emissive(n)),
        because: "this image does not show the Sun's light",
    },
    CanonicalRule { of: "eclipse-model", least: "", applies: |n| n.eclipse.occluders == 0, because: "no occluder stands before the Sun" },
    CanonicalRule {
        of: "ring-shadow",
        least: "",
        applies: |n| n.surface == Surface::Ring || !(shows_sunlight(n) || n.view == PixelView::Ring && n.lights > 0 && !emissive(n)),
        because: "a ring's shadow needs sunlight and something else than the ring",
    },
    CanonicalRule {
        of: "ringshine",
        least: "",
        applies: |n| no_ground(n) || !shows_sunlight(n),
        because: "a ring lights ground only, and in views that show the light",
    },
    CanonicalRule {
        of: "body-shadow",
        least: "",
        applies: |n| n.surface != Surface::Ring || !shows_sunlight(n),
        because: "the body's shadow falls on its ring, in sunlight",
    },
    CanonicalRule {
        of: "air",
        least: "",
        applies: |n| {
            emissive(n) || n.surface == Surface::Ring || !(full(n) || n.view == PixelView::OpticalDepth) || full(n) && n.lights == 0
        },
        because: "this image shows no air",
    },
    CanonicalRule { of: "air", least: "", applies: |n| n.shape == Shape::Mesh, because: "air lies over an ellipsoid" },
    CanonicalRule { of: "mie", least: "", applies: |n| n.air.tier == AtmosphereModel::None, because: "there is no air" },
    CanonicalRule { of: "absorption", least: "", applies: |n| n.air.tier == AtmosphereModel::None, because: "there is no air" },
    CanonicalRule {
        of: "limbheights",
        least: "",
        applies: |n| no_ground(n) || n.shape == Shape::Mesh,
        because: "the Moon's own limb is that of its ground, or cuts the Sun behind it",
    },
    CanonicalRule { of: "twosided", least: "", applies: |n| n.shape != Shape::Mesh, because: "a closed body shows its outside only" },
    CanonicalRule {
        of: "twosided",
        least: "",
        applies: |n| !shows_normal(n),
        because: "this image does not depend on the surface's direction",
    },
    CanonicalRule { of: "vertexcolour", least: "", applies: |n| n.shape != Shape::Mesh, because: "only a mesh has vertices with a colour" },
    CanonicalRule {
        of: "vertexcolour",
        least: "",
        applies: |n| !shows_albedo(n),
        because: "this image does not show the surface's colour",
    },
    CanonicalRule { of: "alphatexture", least: "", applies: no_ground, because: "air, clouds and rings have an opacity of their own" },
    CanonicalRule {
        of: "albedo",
        least: "",
        applies: |n| !shows_albedo(n) && !n.flags.alpha_texture,
        because: "this image does not show the surface's colour",
    },
    CanonicalRule { of: "alphatexture", least: "", applies: |n| !n.maps.albedo, because: "alpha comes from the albedo map" },
];

fn named(name: &str) -> Option<&'static Dimension> {
    DIMENSIONS.iter().find(|d| d.name == name)
}

/// Each rule with the dimension and the value that its words stand for, looked up once.
fn resolved() -> &'static [(&'static CanonicalRule, &'static Dimension, usize)] {
    static RESOLVED: OnceLock<Vec<(&'static CanonicalRule, &'static Dimension, usize)>> = OnceLock::new();
    RESOLVED.get_or_init(|| {
        let resolve = |rule: &'static CanonicalRule| {
            let dimension = named(rule.of)?;
            Some((rule, dimension, dimension.texts.iter().position(|t| *t == rule.least)?))
        };
        RULES.iter().filter_map(resolve).collect()
    })
}

/// The first rule that would change these needs, with the dimension and the value it asks for.
pub(super) fn first_breach(features: &DrawFeatures) -> Option<(&'static CanonicalRule, &'static Dimension, usize)> {
    resolved().iter().copied().find(|(rule, dimension, least)| (dimension.get)(features) != *least && (rule.applies)(features))
}

/// The needs that draw the same image with the least.
pub fn canonical(features: &DrawFeatures) -> DrawFeatures {
    reduced(features, |_| ())
}

/// The rules that make these needs canonical, in the order in which they apply.
pub fn reductions(features: &DrawFeatures) -> Vec<&'static CanonicalRule> {
    let mut applied = Vec::new();
    reduced(features, |rule| applied.push(rule));
    applied
}

fn reduced(features: &DrawFeatures, mut applied: impl FnMut(&'static CanonicalRule)) -> DrawFeatures {
    let mut least = *features;
    least.lights = least.lights.min(3);
    while let Some((rule, dimension, value)) = first_breach(&least) {
        (dimension.set)(&mut least, value);
        applied(rule);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::super::sample_features;
    use super::*;

    #[test]
    fn every_rule_names_a_dimension_and_a_value_and_is_used() {
        let some = sample_features(1, 20_000);
        for rule in RULES {
            let d = named(rule.of).unwrap_or_else(|| panic!("no dimension {}", rule.of));
            assert!(d.texts.contains(&rule.least), "{}: no value {:?}", rule.of, rule.least);
            assert!(some.iter().any(|n| (rule.applies)(n)), "{} never applies", rule.because);
        }
    }

    #[test]
    fn canonical_is_idempotent_and_only_takes_away() {
        for n in sample_features(2, 100_000) {
            let c = canonical(&n);
            assert_eq!(canonical(&c), c, "{n:?}");
            assert_eq!(c.view, n.view, "what is seen never changes");
            for d in DIMENSIONS.iter().filter(|d| d.name != "surface") {
                assert!((d.get)(&c) <= (d.get)(&n), "{} grew: {n:?}", d.name);
            }
        }
    }

    #[test]
    fn a_lit_planet_under_everything_keeps_everything() {
        use crate::scene::draw::{Air, Eclipse, Flags, MapSet};
        let n = DrawFeatures {
            surface: Surface::OrenNayar,
            maps: MapSet { albedo: true, normal: true, specular: true, night: true, cloud_shadow: true },
            overlays: 2,
            lights: 2,
            eclipse: Eclipse { occluders: 4, model: EclipseModel::Refracted },
            ring_shadow: RingShadow::Penumbra,
            ring_shine: true,
            air: Air { tier: AtmosphereModel::Table, mie: true, absorption: true },
            shape: Shape::Ellipsoid,
            limb_heights: true,
            flags: Flags { alpha_texture: true, ..Flags::default() },
            ..DrawFeatures::MINIMAL
        };
        assert_eq!(canonical(&n), n);
        // What a mesh has more, and the air that it has not.
        let flags = Flags { two_sided: true, alpha_texture: true, vertex_colour: true };
        let mesh = DrawFeatures { shape: Shape::Mesh, air: Air::default(), limb_heights: false, flags, ..n };
        assert_eq!(canonical(&mesh), mesh);
        assert_eq!(canonical(&DrawFeatures { air: n.air, ..mesh }), mesh);
    }
}
