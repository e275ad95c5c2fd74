//! The table of dimensions: the one place that names a dimension's values, in texts and in fragment conditions.

use crate::scene::draw::{Needs, PixelView, Shape, Surface};

/// A part of the text form. Dimensions of one part are joined by `-`, parts by `.`, both in the table's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    Surface,
    Maps,
    Lights,
    Shape,
    Flags,
    View,
}

impl Part {
    pub fn name(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Maps => "maps",
            Self::Lights => "lights",
            Self::Shape => "shape",
            Self::Flags => "flags",
            Self::View => "view",
        }
    }
}

/// One dimension. A value is an index into `texts` and `features`.
pub struct Dimension {
    pub name: &'static str,
    pub part: Part,
    /// How the text form writes each value; empty: not written, the value a text without this part has.
    pub texts: &'static [&'static str],
    /// The feature that each value switches on in the fragments; empty: none.
    pub features: &'static [&'static str],
    /// Whether a value switches on the features of all lesser values too (counts do).
    pub cumulative: bool,
    pub get: fn(&Needs) -> usize,
    pub set: fn(&mut Needs, usize),
}

const SURFACES: [Surface; 5] = [Surface::Emissive, Surface::Lambert, Surface::LommelSeeliger, Surface::LunarLambert, Surface::OrenNayar];
const SHAPES: [Shape; 3] = [Shape::Sphere, Shape::Ellipsoid, Shape::Mesh];
const VIEWS: [PixelView; 6] = PixelView::ALL;

fn index_of<T: PartialEq>(all: &[T], value: &T) -> usize {
    all.iter().position(|v| v == value).unwrap_or(0)
}

macro_rules! switch {
    ($name:literal, $part:expr, $feature:literal, $($field:ident).+) => {
        Dimension {
            name: $name,
            part: $part,
            texts: &["", $name],
            features: &["", $feature],
            cumulative: false,
            get: |n| usize::from(n.$($field).+),
            set: |n, v| n.$($field).+ = v == 1,
        }
    };
}

/// Every dimension, in the order of the text form.
pub static DIMENSIONS: &[Dimension] = &[
    Dimension {
        name: "surface",
        part: Part::Surface,
        texts: &["emissive", "lambert", "lommel-seeliger", "lunar-lambert", "oren-nayar"],
        features: &["surface.emissive", "surface.lambert", "surface.lommel-seeliger", "surface.lunar-lambert", "surface.oren-nayar"],
        cumulative: false,
        get: |n| index_of(&SURFACES, &n.surface),
        set: |n, v| n.surface = SURFACES[v],
    },
    switch!("albedo", Part::Maps, "maps.albedo", maps.albedo),
    switch!("normal", Part::Maps, "maps.normal", maps.normal),
    switch!("specular", Part::Maps, "maps.specular", maps.specular),
    switch!("night", Part::Maps, "maps.night", maps.night),
    Dimension {
        name: "lights",
        part: Part::Lights,
        texts: &["sun0", "sun1", "sun2", "sun3"],
        features: &["", "lights.1", "lights.2", "lights.3"],
        cumulative: true,
        get: |n| usize::from(n.lights).min(3),
        set: |n, v| n.lights = v as u8,
    },
    Dimension {
        name: "shape",
        part: Part::Shape,
        texts: &["sphere", "ellipsoid", "mesh"],
        features: &["shape.sphere", "shape.ellipsoid", "shape.mesh"],
        cumulative: false,
        get: |n| index_of(&SHAPES, &n.shape),
        set: |n, v| n.shape = SHAPES[v],
    },
    switch!("twosided", Part::Flags, "flags.twosided", flags.two_sided),
    switch!("alphatexture", Part::Flags, "flags.alphatexture", flags.alpha_texture),
    switch!("vertexcolour", Part::Flags, "flags.vertexcolour", flags.vertex_colour),
    Dimension {
        name: "view",
        part: Part::View,
        texts: &["", "depth", "normalview", "albedoview", "uv", "sunlight"],
        features: &["view.shaded", "view.depth", "view.normal", "view.albedo", "view.uv", "view.sunlight"],
        cumulative: false,
        get: |n| index_of(&VIEWS, &n.view),
        set: |n, v| n.view = VIEWS[v],
    },
];

/// The features that these needs switch on in the fragments.
pub fn features(needs: &Needs) -> Vec<&'static str> {
    let mut on = Vec::new();
    for d in DIMENSIONS {
        let value = (d.get)(needs);
        let first = if d.cumulative { 0 } else { value };
        on.extend(d.features[first..=value].iter().filter(|f| !f.is_empty()));
    }
    on
}
