//! Descriptions of each dimension of a key and of each of its values.

use crate::shader::key::Dimension;

/// A value as in the key's text; one that the text omits by a word.
pub(crate) fn value_text(d: &Dimension, value: usize) -> &'static str {
    match d.texts.get(value) {
        Some(&"") if d.name == "view" => "final image",
        Some(&"") => "none",
        Some(text) => text,
        None => "?",
    }
}

/// Whether a dimension has only the values on and off.
pub(crate) fn is_switch(d: &Dimension) -> bool {
    d.texts.len() == 2 && d.texts[0].is_empty()
}

/// The effect of a value on the picture.
pub(crate) fn meaning(d: &Dimension, value: usize) -> &'static str {
    let words: &[&str] = match d.name {
        "surface" => &[
            "emits light, with limb darkening",
            "Lambert: proportional to the cosine of the incidence angle",
            "Lommel-Seeliger: no limb darkening at full phase",
            "lunar-Lambert: a weighted mean of Lommel-Seeliger and Lambert",
            "Oren-Nayar: a rough surface of facets",
            "atmosphere only, where a view ray misses the surface",
            "a cloud shell above the surface",
            "a flat ring of particles",
        ],
        "albedo" => &["one colour for the whole surface", "surface colour from a map"],
        "normal" => &["smooth surface", "surface normals from a map"],
        "specular" => &["no specular reflection", "specular reflection of the Sun on water, from a map"],
        "night" => &["no night lights", "city lights on the night side, from a map"],
        "cloudshadow" => &["no cloud shadows", "clouds cast shadows on the surface"],
        "detail" => &[
            "no relief finer than the map",
            "procedural craters finer than the map",
            "procedural hills finer than the map",
            "procedural billows finer than the cloud map",
        ],
        "custom-surface" => &[
            "no custom surface",
            "the first custom surface",
            "the second custom surface",
            "the third custom surface",
            "the fourth custom surface",
        ],
        "overlays" => &["no overlay", "one overlay image on the surface", "two overlay images on the surface"],
        "lights" => &["no light", "the Sun", "the Sun and one body's reflected light", "the Sun and two bodies' reflected light"],
        "occluders" => &["no occluder", "up to one occluder", "up to two occluders", "up to three occluders", "up to four occluders"],
        "eclipse-model" => &[
            "no eclipse",
            "linear falloff across the penumbra",
            "overlap of discs, uniform Sun",
            "overlap of discs, limb-darkened Sun",
            "limb-darkened Sun, with light refracted into the umbra by the occluder's atmosphere",
        ],
        "ring-shadow" => &["no ring shadow", "ring shadow of a point Sun", "ring shadow with a penumbra"],
        "limbheights" => &["even limb", "the Moon's limb by its own heights"],
        "ringshine" => &["no ring-shine", "light from the rings on the globe"],
        "body-shadow" => {
            &["no shadow of the globe on the ring", "shadow of a sphere, point Sun", "shadow of the oblate globe, with a penumbra"]
        }
        "air" => &[
            "no atmosphere",
            "in-scattering per vertex, interpolated",
            "in-scattering per pixel, 8 quadrature nodes",
            "in-scattering per pixel, 16 quadrature nodes",
            "in-scattering per pixel, 32 quadrature nodes",
            "precomputed tables with multiple scattering",
        ],
        "mie" => &["no Mie scattering", "Mie scattering by haze or dust"],
        "absorption" => &["no absorbing layer", "an absorbing layer such as ozone"],
        "shape" => &["ray-traced sphere", "ray-traced ellipsoid", "triangle mesh"],
        "twosided" => &["front faces only", "both faces of the mesh are lit"],
        "alphatexture" => &["opaque", "opacity from the albedo map"],
        "vertexcolour" => &["no vertex colours", "vertex colours of the mesh"],
        "view" => &[
            "radiance at the camera",
            "distance along the view ray",
            "surface normal",
            "albedo, unlit",
            "texture coordinates",
            "sunlight received",
            "visible fraction of the Sun past occluders",
            "transmittance of the ring towards the Sun",
            "optical depth along the view ray",
            "cost of the pixel",
        ],
        _ => &[],
    };
    words.get(value).copied().unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::key::DIMENSIONS;

    #[test]
    fn every_value_of_every_dimension_has_words_of_its_own() {
        for d in DIMENSIONS {
            let words: Vec<_> = (0..d.texts.len()).map(|v| meaning(d, v)).collect();
            let distinct: std::collections::BTreeSet<_> = words.iter().collect();
            assert!(words.iter().all(|w| !w.is_empty()) && distinct.len() == words.len(), "{}: {words:?}", d.name);
            assert_eq!(meaning(d, d.texts.len()), "", "{}: words without a value", d.name);
        }
    }
}
