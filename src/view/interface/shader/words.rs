//! What each dimension of a key and each of its values means, for a reader.

use crate::shader::key::Dimension;

/// A value as the key's text writes it; the unwritten one by what it is.
pub fn value_text(d: &Dimension, value: usize) -> &'static str {
    match d.texts.get(value) {
        Some(&"") if d.name == "view" => "shaded",
        Some(&"") => "none",
        Some(text) => text,
        None => "?",
    }
}

/// Whether a dimension is on or off and nothing else.
pub fn is_switch(d: &Dimension) -> bool {
    d.texts.len() == 2 && d.texts[0].is_empty()
}

/// What a value does to the picture.
pub fn meaning(d: &Dimension, value: usize) -> &'static str {
    let words: &[&str] = match d.name {
        "surface" => &[
            "shines by itself, darker to its limb",
            "scatters evenly: as bright as the cosine of the Sun's height",
            "dark dust: an even disc when full",
            "a mean of Lommel-Seeliger and Lambert, weighted by body",
            "rough ground whose facets shade each other",
            "the air alone, where a view ray misses the ground",
            "a shell of cloud over the ground",
            "a flat ring of particles",
        ],
        "albedo" => &["one colour for all of the ground", "the ground's colour from a map"],
        "normal" => &["smooth ground", "slopes of the ground from a map"],
        "specular" => &["no glint", "the Sun's glint on water, where a map has water"],
        "night" => &["no lamps", "lamps of the night side from a map"],
        "cloudshadow" => &["no shadow of clouds", "clouds throw their shadow on the ground"],
        "overlays" => &["no image over the ground", "one image over the ground", "two images over the ground"],
        "lights" => &["no light", "the Sun", "the Sun and one body's reflected light", "the Sun and two bodies' reflected light"],
        "casters" => &[
            "no body stands before the Sun",
            "one body may stand before the Sun",
            "two bodies may stand before the Sun",
            "three bodies may stand before the Sun",
            "four bodies may stand before the Sun",
        ],
        "eclipse-model" => &[
            "no eclipse",
            "light falls off evenly between first and last contact",
            "overlap of discs, the Sun evenly bright",
            "overlap of discs, the Sun darker to its limb",
            "and the caster's air bends red light into its shadow",
        ],
        "ring-shadow" => {
            &["no shadow of the ring", "one ray to the Sun's centre through the ring", "the ring's shadow softened by the Sun's disc"]
        }
        "ringshine" => &["the rings throw no light on the globe", "light of the rings on the globe's night and shadowed ground"],
        "body-shadow" => &[
            "no shadow of the globe",
            "a sphere's shadow on the ring, the Sun a point",
            "the oblate globe's shadow, softened by the Sun's disc",
        ],
        "air" => &[
            "no air",
            "air summed at the corners, blended between them",
            "air summed at 8 places along each ray",
            "air summed at 16 places along each ray",
            "air summed at 32 places along each ray",
            "air from tables, light scattered many times too",
        ],
        "mie" => &["no haze", "haze or dust that scatters forward"],
        "absorption" => &["no absorbing layer", "a layer that only absorbs, such as ozone"],
        "shape" => &["a sphere met by the view ray", "an ellipsoid met by the view ray", "triangles of a mesh"],
        "twosided" => &["outside only", "both sides of the mesh are lit"],
        "alphatexture" => &["opaque", "opacity from the albedo map"],
        "vertexcolour" => &["no colour by vertex", "colour from the mesh's vertices"],
        "view" => &[
            "the light that reaches the eye",
            "distance along the view ray",
            "direction of the surface",
            "colour of the ground without light",
            "place in the map",
            "how much sunlight arrives",
            "what casters leave of the Sun",
            "what the ring leaves of the Sun",
            "optical depth along the view ray",
            "work that the pixel takes",
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
