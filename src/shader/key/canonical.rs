//! Which values mean nothing beside which others.

use super::dimension::{DIMENSIONS, Dimension};
use crate::scene::draw::{Needs, PixelView, Shape, Surface};

/// Where `applies` holds, the dimension `of` may take the value `least` and the image stays the same.
pub struct Rule {
    pub of: &'static str,
    /// The value's text (empty: the one that is not written).
    pub least: &'static str,
    pub applies: fn(&Needs) -> bool,
    /// Completes "… changes nothing: …".
    pub because: &'static str,
}

fn emissive(n: &Needs) -> bool {
    n.surface == Surface::Emissive
}
fn shaded(n: &Needs) -> bool {
    n.view == PixelView::Shaded
}
/// Whether the shaded view shows reflected light.
fn reflects(n: &Needs) -> bool {
    shaded(n) && !emissive(n) && n.lights > 0
}
/// Whether the pixel's value depends on the direction of the surface.
fn shows_normal(n: &Needs) -> bool {
    reflects(n) || (shaded(n) && emissive(n)) || n.view == PixelView::Normal || (n.view == PixelView::Sunlight && n.lights > 0)
}
/// Whether the pixel's value depends on the surface's own colour.
fn shows_albedo(n: &Needs) -> bool {
    reflects(n) || (shaded(n) && emissive(n)) || n.view == PixelView::Albedo
}

/// Applied in order until nothing changes; each rule only takes away, so that ends.
pub static RULES: &[Rule] = &[
    Rule { of: "lights", least: "sun0", applies: emissive, because: "an emissive surface reflects nothing" },
    Rule { of: "lights", least: "sun0", applies: |n| !shaded(n) && n.view != PixelView::Sunlight, because: "this view shows no light" },
    Rule { of: "surface", least: "lambert", applies: |n| !shaded(n), because: "this view does not show how the surface turns light" },
    Rule {
        of: "surface",
        least: "lambert",
        applies: |n| !emissive(n) && n.lights == 0,
        because: "without a light every reflecting surface is black",
    },
    Rule {
        of: "normal",
        least: "",
        applies: |n| !shows_normal(n) || (shaded(n) && emissive(n)),
        because: "relief shows only where light falls on it, or in the normal view",
    },
    Rule { of: "specular", least: "", applies: |n| !reflects(n), because: "a glint needs a light and a reflecting surface" },
    Rule { of: "night", least: "", applies: |n| !shaded(n) || emissive(n), because: "lamps show only on a shaded, reflecting surface" },
    Rule { of: "twosided", least: "", applies: |n| n.shape != Shape::Mesh, because: "a closed body shows its outside only" },
    Rule { of: "twosided", least: "", applies: |n| !shows_normal(n), because: "this image does not depend on the surface's direction" },
    Rule { of: "vertexcolour", least: "", applies: |n| n.shape != Shape::Mesh, because: "only a mesh has vertices with a colour" },
    Rule { of: "vertexcolour", least: "", applies: |n| !shows_albedo(n), because: "this image does not show the surface's colour" },
    Rule {
        of: "albedo",
        least: "",
        applies: |n| !shows_albedo(n) && !n.flags.alpha_texture,
        because: "this image does not show the surface's colour",
    },
    Rule { of: "alphatexture", least: "", applies: |n| !n.maps.albedo, because: "alpha comes from the albedo map" },
];

fn named(name: &str) -> Option<&'static Dimension> {
    DIMENSIONS.iter().find(|d| d.name == name)
}

/// The first rule that would change these needs, with the dimension and the value it asks for.
pub(super) fn first_breach(needs: &Needs) -> Option<(&'static Rule, &'static Dimension, usize)> {
    RULES.iter().find_map(|rule| {
        let dimension = named(rule.of)?;
        let least = dimension.texts.iter().position(|t| *t == rule.least)?;
        ((rule.applies)(needs) && (dimension.get)(needs) != least).then_some((rule, dimension, least))
    })
}

/// The needs that draw the same image with the least.
pub fn canonical(needs: &Needs) -> Needs {
    let mut least = *needs;
    least.lights = least.lights.min(3);
    while let Some((_, dimension, value)) = first_breach(&least) {
        (dimension.set)(&mut least, value);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::super::nominal_needs;
    use super::*;

    #[test]
    fn every_rule_names_a_dimension_and_a_value_and_is_used() {
        for rule in RULES {
            let d = named(rule.of).unwrap_or_else(|| panic!("no dimension {}", rule.of));
            assert!(d.texts.contains(&rule.least), "{}: no value {:?}", rule.of, rule.least);
            assert!(nominal_needs().any(|n| (rule.applies)(&n)), "{} never applies", rule.because);
        }
    }

    #[test]
    fn canonical_is_idempotent_and_only_takes_away() {
        for n in nominal_needs() {
            let c = canonical(&n);
            assert_eq!(canonical(&c), c, "{n:?}");
            assert_eq!((c.view, c.shape), (n.view, n.shape), "what is seen and its shape never change");
            for d in DIMENSIONS.iter().filter(|d| d.name != "surface") {
                assert!((d.get)(&c) <= (d.get)(&n), "{} grew: {n:?}", d.name);
            }
        }
    }

    #[test]
    fn a_lit_textured_planet_keeps_everything() {
        let n = Needs {
            surface: Surface::OrenNayar,
            maps: crate::scene::draw::MapSet { albedo: true, normal: true, specular: true, night: true },
            lights: 2,
            shape: Shape::Mesh,
            flags: crate::scene::draw::Flags { two_sided: true, alpha_texture: true, vertex_colour: true },
            view: PixelView::Shaded,
        };
        assert_eq!(canonical(&n), n);
    }
}
