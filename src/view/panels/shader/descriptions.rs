//! Names and descriptions of the values of each dimension of a shader key. A dimension is one independent choice in the key, such as the surface.
//!
//! In: a dimension and the index of a value. Out: texts in the interface's language. Always: each value of each dimension has its own description.

use crate::shader::key::Dimension;
use crate::view::language::text;

/// The name of a value: its text in the key, or a word such as *none* for a value that the key omits; `?` if there is no such value.
pub(crate) fn value_text(dimension: &Dimension, value: usize) -> &'static str {
    match dimension.texts.get(value) {
        Some(&"") if dimension.name == "view" => text!("pixels-final"),
        Some(&"") => text!("key-value-none"),
        Some(text) => text,
        None => "?",
    }
}

/// Whether a dimension has only two values, off (omitted in the key) and on.
pub(crate) fn is_switch(dimension: &Dimension) -> bool {
    dimension.texts.len() == 2 && dimension.texts[0].is_empty()
}

/// What the value at an index means for the image; empty if there is no such value.
pub(crate) fn meaning(dimension: &Dimension, value: usize) -> &'static str {
    let meanings: &[&str] = match dimension.name {
        "surface" => &[
            text!("meaning-emits-light-with-limb-darkening"),
            text!("meaning-lambert-proportional-to-the-cosine-of-the-in"),
            text!("meaning-lommel-seeliger-no-limb-darkening-at-full-ph"),
            text!("meaning-lunar-lambert-a-weighted-mean-of-lommel-seel"),
            text!("meaning-oren-nayar-a-rough-surface-of-facets"),
            text!("meaning-atmosphere-only-where-a-view-ray-misses-the"),
            text!("meaning-a-cloud-shell-above-the-surface"),
            text!("meaning-a-flat-ring-of-particles"),
        ],
        "albedo" => &[text!("meaning-one-colour-for-the-whole-surface"), text!("meaning-surface-colour-from-a-map")],
        "normal" => &[text!("meaning-smooth-surface"), text!("meaning-surface-normals-from-a-map")],
        "specular" => &[text!("meaning-no-specular-reflection"), text!("meaning-specular-reflection-of-the-sun-on-water-from")],
        "night" => &[text!("meaning-no-night-lights"), text!("meaning-city-lights-on-the-night-side-from-a-map")],
        "cloudshadow" => &[text!("meaning-no-cloud-shadows"), text!("meaning-clouds-cast-shadows-on-the-surface")],
        "detail" => &[
            text!("meaning-no-relief-finer-than-the-map"),
            text!("meaning-procedural-craters-finer-than-the-map"),
            text!("meaning-procedural-hills-finer-than-the-map"),
            text!("meaning-procedural-billows-finer-than-the-cloud-map"),
        ],
        "custom-surface" => &[
            text!("meaning-no-custom-surface"),
            text!("meaning-the-first-custom-surface"),
            text!("meaning-the-second-custom-surface"),
            text!("meaning-the-third-custom-surface"),
            text!("meaning-the-fourth-custom-surface"),
        ],
        "overlays" => &[
            text!("meaning-no-overlay"),
            text!("meaning-one-overlay-image-on-the-surface"),
            text!("meaning-two-overlay-images-on-the-surface"),
        ],
        "lights" => &[
            text!("meaning-no-light"),
            text!("meaning-the-sun"),
            text!("meaning-the-sun-and-one-body-s-reflected-light"),
            text!("meaning-the-sun-and-two-bodies-reflected-light"),
        ],
        "occluders" => &[
            text!("meaning-no-occluder"),
            text!("meaning-up-to-one-occluder"),
            text!("meaning-up-to-two-occluders"),
            text!("meaning-up-to-three-occluders"),
            text!("meaning-up-to-four-occluders"),
        ],
        "eclipse-model" => &[
            text!("meaning-no-eclipse"),
            text!("meaning-linear-falloff-across-the-penumbra"),
            text!("meaning-overlap-of-discs-uniform-sun"),
            text!("meaning-overlap-of-discs-limb-darkened-sun"),
            text!("meaning-limb-darkened-sun-with-light-refracted-into"),
        ],
        "ring-shadow" => &[
            text!("meaning-no-ring-shadow"),
            text!("meaning-ring-shadow-of-a-point-sun"),
            text!("meaning-ring-shadow-with-a-penumbra"),
            text!("meaning-shadow-of-the-rings-of-another-body"),
        ],
        "limbheights" => &[text!("meaning-even-limb"), text!("meaning-the-moon-s-limb-by-its-own-heights")],
        "thinlimb" => &[text!("meaning-limb-of-one-point-a-pixel"), text!("meaning-light-averaged-over-pixels-at-the-limb")],
        "ringshine" => &[text!("meaning-no-ring-shine"), text!("meaning-light-from-the-rings-on-the-globe")],
        "body-shadow" => &[
            text!("meaning-no-shadow-of-the-globe-on-the-ring"),
            text!("meaning-shadow-of-a-sphere-point-sun"),
            text!("meaning-shadow-of-the-oblate-globe-with-a-penumbra"),
        ],
        "air" => &[
            text!("meaning-no-atmosphere"),
            text!("meaning-in-scattering-per-vertex-interpolated"),
            text!("meaning-in-scattering-per-pixel-8-quadrature-nodes"),
            text!("meaning-in-scattering-per-pixel-16-quadrature-nodes"),
            text!("meaning-in-scattering-per-pixel-32-quadrature-nodes"),
            text!("meaning-precomputed-tables-with-multiple-scattering"),
        ],
        "mie" => &[text!("meaning-no-mie-scattering"), text!("meaning-mie-scattering-by-haze-or-dust")],
        "absorption" => &[text!("meaning-no-absorbing-layer"), text!("meaning-an-absorbing-layer-such-as-ozone")],
        "air-pass" => &[
            text!("meaning-air-evaluated-for-each-pixel"),
            text!("meaning-air-interpolated-from-a-coarse-image"),
            text!("meaning-the-coarse-image-of-the-air-itself"),
            text!("meaning-air-interpolated-and-clouds-drawn-with-the-ground"),
            text!("meaning-the-sunlight-of-the-coarse-image"),
        ],
        "shape" => &[text!("meaning-ray-traced-sphere"), text!("meaning-ray-traced-ellipsoid"), text!("meaning-triangle-mesh")],
        "twosided" => &[text!("meaning-front-faces-only"), text!("meaning-both-faces-of-the-mesh-are-lit")],
        "alphatexture" => &[text!("meaning-opaque"), text!("meaning-opacity-from-the-albedo-map")],
        "vertexcolour" => &[text!("meaning-no-vertex-colours"), text!("meaning-vertex-colours-of-the-mesh")],
        "view" => &[
            text!("meaning-radiance-at-the-camera"),
            text!("meaning-distance-along-the-view-ray"),
            text!("meaning-surface-normal"),
            text!("meaning-albedo-unlit"),
            text!("meaning-texture-coordinates"),
            text!("meaning-sunlight-received"),
            text!("meaning-visible-fraction-of-the-sun-past-occluders"),
            text!("meaning-transmittance-of-the-ring-towards-the-sun"),
            text!("meaning-optical-depth-along-the-view-ray"),
            text!("meaning-cost-of-the-pixel"),
        ],
        _ => &[],
    };
    meanings.get(value).copied().unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::key::DIMENSIONS;

    #[test]
    fn every_value_of_every_dimension_has_a_unique_description() {
        for dimension in DIMENSIONS {
            let value_count = dimension.texts.len();
            let meanings: Vec<_> = (0..value_count).map(|value| meaning(dimension, value)).collect();
            let distinct: std::collections::BTreeSet<_> = meanings.iter().collect();
            assert!(meanings.iter().all(|m| !m.is_empty()) && distinct.len() == value_count, "{}: {meanings:?}", dimension.name);
            assert_eq!(meaning(dimension, value_count), "", "{}: a description without a value", dimension.name);
        }
    }
}
