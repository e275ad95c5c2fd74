//! The table of dimensions: for each, its values, their names in key texts and in the `@if` conditions of WESL files, and functions that get and set the value
//! in [`DrawFeatures`].

use crate::scene::draw::{
    AirPass, AtmosphereModel, BodyShadow, Detail, DrawFeatures, EclipseModel, MAX_CUSTOM_SURFACES, MAX_OCCLUDERS, PixelView, RingShadow,
    Shape, Surface,
};

/// A part of a shader key's text. In the text, the words of one part are joined by `-`, parts by `.`, both in the order of the table. A word may
/// itself contain `-`, such as `lommel-seeliger`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum KeyPart {
    Surface,
    Maps,
    Overlays,
    Lights,
    Eclipse,
    RingShadow,
    RingShine,
    BodyShadow,
    Air,
    Shape,
    /// Properties of a mesh.
    Flags,
    View,
}

impl KeyPart {
    /// For messages and the window.
    pub fn name(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Maps => "maps",
            Self::Overlays => "overlays",
            Self::Lights => "lights",
            Self::Eclipse => "eclipse",
            Self::RingShadow => "ring shadow",
            Self::RingShine => "ring shine",
            Self::BodyShadow => "body shadow",
            Self::Air => "atmosphere",
            Self::Shape => "shape",
            Self::Flags => "flags",
            Self::View => "view",
        }
    }
}

/// One dimension. A value is an index into `texts` and `feature_names`.
pub struct Dimension {
    /// Its name, for messages and for the rules of `key::canonical`.
    pub name: &'static str,
    /// The part of the key's text that contains its value.
    pub part: KeyPart,
    /// Text of each value in the key; empty for the value that the key omits.
    pub texts: &'static [&'static str],
    /// Name of the feature that each value enables. `@if` conditions test it with `_` for `.` and `-`. Empty: no feature.
    pub feature_names: &'static [&'static str],
    /// Whether a value also enables the features of all lesser values: `lights.2` comes with `lights.1`.
    pub cumulative: bool,
    /// The value that a draw's features have: an index into `texts`.
    pub get: fn(&DrawFeatures) -> usize,
    /// Changes a draw's features so that they have this value.
    pub set: fn(&mut DrawFeatures, usize),
}

/// Greatest number of lights in a key (the Sun and two other bodies): `scene::effects::MAX_LIGHTS`, as a test verifies.
pub(super) const MAX_LIGHTS: u8 = 3;
/// Greatest number of overlays in a key: `catalog::MAX_OVERLAYS`, as a test verifies.
pub(super) const MAX_OVERLAYS: u8 = 2;
const SURFACES: [Surface; 8] = Surface::ALL;
const SHAPES: [Shape; 3] = [Shape::Sphere, Shape::Ellipsoid, Shape::Mesh];
const VIEWS: [PixelView; 10] = PixelView::ALL;

/// Index of a value in the list of all values.
fn index_of<T: PartialEq>(all: &[T], value: &T) -> usize {
    all.iter().position(|v| v == value).unwrap_or(0)
}

/// A dimension with two values: off, which the key omits, and on, whose text in the key is the dimension's name.
macro_rules! switch {
    ($name:literal, $part:expr, $feature:literal, $($field:ident).+) => {
        Dimension {
            name: $name,
            part: $part,
            texts: &["", $name],
            feature_names: &["", $feature],
            cumulative: false,
            get: |f| usize::from(f.$($field).+),
            set: |f, v| f.$($field).+ = v == 1,
        }
    };
}

/// Every dimension, in the order of the text form.
pub static DIMENSIONS: &[Dimension] = &[
    Dimension {
        name: "surface",
        part: KeyPart::Surface,
        texts: &["emissive", "lambert", "lommel-seeliger", "lunar-lambert", "oren-nayar", "sky", "cloud", "ring"],
        feature_names: &[
            "surface.emissive",
            "surface.lambert",
            "surface.lommel-seeliger",
            "surface.lunar-lambert",
            "surface.oren-nayar",
            "surface.sky",
            "surface.cloud",
            "surface.ring",
        ],
        cumulative: false,
        get: |f| index_of(&SURFACES, &f.surface),
        set: |f, v| f.surface = SURFACES[v],
    },
    switch!("albedo", KeyPart::Maps, "maps.albedo", maps.albedo),
    switch!("normal", KeyPart::Maps, "maps.normal", maps.normal),
    switch!("specular", KeyPart::Maps, "maps.specular", maps.specular),
    switch!("night", KeyPart::Maps, "maps.night", maps.night),
    switch!("cloudshadow", KeyPart::Maps, "maps.cloud-shadow", maps.cloud_shadow),
    Dimension {
        name: "detail",
        part: KeyPart::Maps,
        // The key's word for craters is the name of the dimension.
        texts: &["", "detail", "hills", "billows"],
        feature_names: &["", "detail.craters", "detail.hills", "detail.billows"],
        cumulative: false,
        get: |f| index_of(&Detail::ALL, &f.detail),
        set: |f, v| f.detail = Detail::ALL[v],
    },
    Dimension {
        name: "custom-surface",
        part: KeyPart::Maps,
        // `customN`: the custom surface with the number N, not N of them.
        texts: &["", "custom1", "custom2", "custom3", "custom4"],
        feature_names: &["", "custom.1", "custom.2", "custom.3", "custom.4"],
        cumulative: false,
        get: |f| usize::from(f.custom_surface.min(MAX_CUSTOM_SURFACES)),
        set: |f, v| f.custom_surface = v as u8,
    },
    Dimension {
        name: "overlays",
        part: KeyPart::Overlays,
        // `overlayN`: N overlays.
        texts: &["", "overlay1", "overlay2"],
        feature_names: &["", "overlays.1", "overlays.2"],
        cumulative: true,
        get: |f| usize::from(f.overlays.min(MAX_OVERLAYS)),
        set: |f, v| f.overlays = v as u8,
    },
    Dimension {
        name: "lights",
        part: KeyPart::Lights,
        // `sunN`: N lights, of which the first is the Sun and the others are bodies that reflect its light.
        texts: &["sun0", "sun1", "sun2", "sun3"],
        feature_names: &["", "lights.1", "lights.2", "lights.3"],
        cumulative: true,
        get: |f| usize::from(f.lights.min(MAX_LIGHTS)),
        set: |f, v| f.lights = v as u8,
    },
    Dimension {
        name: "occluders",
        part: KeyPart::Eclipse,
        // `eclipseN`: N occluders.
        texts: &["", "eclipse1", "eclipse2", "eclipse3", "eclipse4"],
        feature_names: &["", "eclipse.1", "eclipse.2", "eclipse.3", "eclipse.4"],
        cumulative: true,
        get: |f| usize::from(f.eclipse.occluders.min(MAX_OCCLUDERS)),
        set: |f, v| f.eclipse.occluders = v as u8,
    },
    Dimension {
        name: "eclipse-model",
        part: KeyPart::Eclipse,
        texts: &["", "linear", "uniform-disc", "limb-darkened", "refracted"],
        feature_names: &["", "eclipse.linear", "eclipse.uniform-disc", "eclipse.limb-darkened", "eclipse.refracted"],
        cumulative: false,
        get: |f| index_of(&EclipseModel::ALL, &f.eclipse.model),
        set: |f, v| f.eclipse.model = EclipseModel::ALL[v],
    },
    Dimension {
        name: "ring-shadow",
        part: KeyPart::RingShadow,
        // `ringshadow-of-planet`: the shadow of another body's rings, such as that of Saturn's rings on a moon. The others: of the body's own rings.
        texts: &["", "ringshadow-point-sun", "ringshadow-penumbra", "ringshadow-of-planet"],
        feature_names: &["", "ring-shadow.point-sun", "ring-shadow.penumbra", "ring-shadow.of-planet"],
        cumulative: false,
        get: |f| index_of(&RingShadow::ALL, &f.ring_shadow),
        set: |f, v| f.ring_shadow = RingShadow::ALL[v],
    },
    switch!("ringshine", KeyPart::RingShine, "ring-shine", ring_shine),
    Dimension {
        // The planet's shadow on its rings. The shadow of one body on another is a matter of `eclipse`.
        name: "body-shadow",
        part: KeyPart::BodyShadow,
        texts: &["", "bodyshadow-sphere", "bodyshadow-ellipsoid-penumbra"],
        feature_names: &["", "body-shadow.sphere", "body-shadow.ellipsoid-penumbra"],
        cumulative: false,
        get: |f| index_of(&BodyShadow::ALL, &f.body_shadow),
        set: |f, v| f.body_shadow = BodyShadow::ALL[v],
    },
    Dimension {
        // `air-pixel-N`: at most N samples along each pixel's view ray. `air-vertex` takes at most 5; `air-table` takes at most 16, and reads the light of
        // higher orders of scattering from a table.
        name: "air",
        part: KeyPart::Air,
        texts: &["", "air-vertex", "air-pixel-8", "air-pixel-16", "air-pixel-32", "air-table"],
        feature_names: &["", "air.vertex", "air.pixel-8", "air.pixel-16", "air.pixel-32", "air.table"],
        cumulative: false,
        get: |f| index_of(&AtmosphereModel::ALL, &f.air.model),
        set: |f, v| f.air.model = AtmosphereModel::ALL[v],
    },
    switch!("mie", KeyPart::Air, "air.mie", air.mie),
    switch!("absorption", KeyPart::Air, "air.absorption", air.absorption),
    Dimension {
        // What the draw does with the coarse image of the air. No text: does not use it. `coarse`: reads it. `coarsedraw`: fills it with the light of the air.
        // `coarseclouds`: the ground's draw reads it and also shows the clouds. `coarsesunlight`: fills it with the sunlight that passes the occluders.
        name: "air-pass",
        part: KeyPart::Air,
        texts: &["", "coarse", "coarsedraw", "coarseclouds", "coarsesunlight"],
        feature_names: &["", "air-pass.read", "air-pass.drawn", "air-pass.read-with-clouds", "air-pass.sunlight-drawn"],
        cumulative: false,
        get: |f| index_of(&AirPass::ALL, &f.air_pass),
        set: |f, v| f.air_pass = AirPass::ALL[v],
    },
    Dimension {
        name: "shape",
        part: KeyPart::Shape,
        texts: &["sphere", "ellipsoid", "mesh"],
        feature_names: &["shape.sphere", "shape.ellipsoid", "shape.mesh"],
        cumulative: false,
        get: |f| index_of(&SHAPES, &f.shape),
        set: |f, v| f.shape = SHAPES[v],
    },
    switch!("limbheights", KeyPart::Shape, "limb-heights", limb_heights),
    switch!("thinlimb", KeyPart::Shape, "thin-limb", thin_limb),
    switch!("twosided", KeyPart::Flags, "flags.twosided", flags.two_sided),
    switch!("alphatexture", KeyPart::Flags, "flags.alphatexture", flags.alpha_texture),
    switch!("vertexcolour", KeyPart::Flags, "flags.vertexcolour", flags.vertex_colour),
    Dimension {
        name: "view",
        part: KeyPart::View,
        // No text: the final image, whose feature is `view.shaded`.
        texts: &["", "depth", "normalview", "albedoview", "uv", "sunlight", "eclipseview", "ringview", "opticaldepth", "cost"],
        feature_names: &[
            "view.shaded",
            "view.depth",
            "view.normal",
            "view.albedo",
            "view.uv",
            "view.sunlight",
            "view.eclipse",
            "view.ring",
            "view.optical-depth",
            // `cost`: runs the code of the final image; the renderer counts its instructions.
            "view.shaded",
        ],
        cumulative: false,
        get: |f| index_of(&VIEWS, &f.view),
        set: |f, v| f.view = VIEWS[v],
    },
];

/// The names of the features that are on for a draw, as the table spells them; `@if` conditions test these.
pub fn feature_names(draw: &DrawFeatures) -> Vec<&'static str> {
    let mut on = Vec::new();
    for d in DIMENSIONS {
        let value = (d.get)(draw);
        let first = if d.cumulative { 0 } else { value };
        on.extend(d.feature_names[first..=value].iter().filter(|f| !f.is_empty()));
    }
    on
}
