//! Draws: their features ([`features::DrawFeatures`]), uniforms ([`uniforms::DrawUniforms`]), maps and tables; also points and stars.
//!
//! Only types. In: `scene::features` creates draws and points, `scene::sky` stars. Out: `shader` derives keys from the features, and `render::plan` fills
//! uniform blocks from the uniforms.

pub mod features;
pub mod tables;
pub mod uniforms;

use crate::catalog::NaifId;
pub use crate::scene::constants;
pub use features::{
    Air, AirPass, AtmosphereModel, BodyShadow, Detail, DrawFeatures, Eclipse, EclipseModel, INSTRUCTIONS_PER_READ, MAX_AIR_LIGHTS,
    MAX_CUSTOM_SURFACES, MAX_OCCLUDERS, MapSet, MeshFlags, PixelView, RingShadow, Shape, Surface,
};
use glam::Vec3;
pub use tables::{LimbTable, RingShadowGrid, RingShine, RingTable};
pub use uniforms::{
    AtmosphereUniforms, CloudUniforms, DetailUniforms, DrawUniforms, EclipseUniforms, ForegroundLimbUniforms, Light, LimbUniforms,
    MeshInstance, OverlayUniforms, RingUniforms,
};

/// The part of a body that a draw shows. The variants are in the order in which parts of one body are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BodyPart {
    /// The half of the ring behind the globe's centre.
    RingBehind,
    /// The atmosphere beyond the limb. It is drawn before the ground, so that the ground's antialiased edge blends over it.
    Sky,
    Globe,
    Clouds,
    /// The half of the ring in front of the globe's centre.
    RingInFront,
}

impl BodyPart {
    pub fn name(self) -> &'static str {
        match self {
            Self::RingBehind => "ring-behind",
            Self::Sky => "sky",
            Self::Globe => "globe",
            Self::Clouds => "clouds",
            Self::RingInFront => "ring",
        }
    }
}

/// One draw of a body that is large enough to be a disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    pub body: NaifId,
    pub part: BodyPart,
    /// The name of the body and, except for its globe, of the part: `Earth clouds`. For labels and error messages.
    pub name: String,
    pub features: DrawFeatures,
    pub uniforms: DrawUniforms,
    /// The map and overlay files that the draw reads.
    pub map_files: MapFiles,
}

impl Draw {
    /// A black draw of the same shape, without maps and effects: it covers the same pixels as this draw.
    pub fn shape_alone(&self) -> Self {
        // Back faces of a two-sided mesh cover pixels, too.
        let two_sided = self.features.flags.two_sided;
        // In the Sun's draw (emissive) the limb profile shapes the part that the Moon hides, not the Sun's own outline.
        let limb_heights = self.features.limb_heights && self.features.surface != Surface::Emissive;
        let features = DrawFeatures {
            shape: self.features.shape,
            limb_heights,
            flags: MeshFlags { two_sided, ..MeshFlags::default() },
            ..DrawFeatures::MINIMAL
        };
        Self { features, map_files: MapFiles::default(), ..self.clone() }
    }
}

/// The role of a map in a draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapRole {
    Albedo,
    Normal,
    /// Water mask, for the light that water mirrors.
    Specular,
    /// Lights of cities at night.
    Night,
    /// Opacity of the clouds.
    Clouds,
    /// An image over the ground; the number is its position in the stack of overlays, 0 for the lowest.
    Overlay(u8),
}

/// File names of a draw's maps inside the textures folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MapFiles {
    pub albedo: Option<String>,
    pub normal: Option<String>,
    pub specular: Option<String>,
    pub night: Option<String>,
    pub clouds: Option<String>,
    /// If the body has clouds: the cloud map's values for a clear sky and for a closed deck, in this order, as bits of f32, which can be compared and hashed.
    pub cloud_texel_bits: Option<[u32; 2]>,
    /// Overlay images, the lowest first, as [`DrawUniforms::overlays`].
    pub overlays: Vec<String>,
}

impl MapFiles {
    /// Each file with its role in the draw.
    pub fn by_role(&self) -> impl Iterator<Item = (MapRole, &str)> {
        let maps = [
            (MapRole::Albedo, &self.albedo),
            (MapRole::Normal, &self.normal),
            (MapRole::Specular, &self.specular),
            (MapRole::Night, &self.night),
            (MapRole::Clouds, &self.clouds),
        ];
        let overlays = (0..).zip(&self.overlays).map(|(n, file)| (MapRole::Overlay(n), file.as_str()));
        maps.into_iter().filter_map(|(role, file)| Some((role, file.as_deref()?))).chain(overlays)
    }
}

/// The sprite of a star, or of the head of a comet, which is drawn like a star.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarSprite {
    /// Clip x and y after division by w (-1 to 1 over the viewport), and reversed depth, which is 0 (infinitely far) for a star.
    pub centre: Vec3,
    /// Half the height of the sprite in pixels; 0 if another frame of a composed image draws the sprite.
    pub radius_px: f32,
    /// Width over height: above 1 away from the equator of an equirectangular image, otherwise 1.
    pub stretch: f32,
    /// Linear RGB: the sum of the sprite's radiance over its pixels.
    pub flux: Vec3,
    /// The star's index in the star catalog; `None` for the head of a comet.
    pub star: Option<usize>,
}

/// The sprite of a body too small for a disc, or of the glare of a small disc ([`Self::is_disc_glare`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub body: NaifId,
    /// Clip x and y after division by w (-1 to 1 over the viewport), and reversed depth.
    pub centre: Vec3,
    /// Half the height of the sprite in pixels.
    pub radius_px: f32,
    /// Width over height: above 1 away from the equator of an equirectangular image, otherwise 1.
    pub stretch: f32,
    /// Linear RGB: the sum of the sprite's radiance over its pixels.
    pub flux: Vec3,
    /// Area in pixels that the body hides of the discs and rings behind it: the area of its disc and of the air beyond its limb, times the fraction of its
    /// light that bodies and rings in front of it transmit. It is 0
    /// - for the Sun, and if there is no disc or ring behind the body,
    /// - if the body's own disc is drawn, too, because the disc hides as much,
    /// - in pixel views other than the final image,
    /// - by day for a camera in air, except in front of the Sun, because the sky outshines the bodies behind.
    pub covered_px: f32,
    /// For the glare of a disc, the disc's radius in pixels: such a sprite is wider than that of a point and has no core. 0 for a body drawn as a point.
    pub disc_radius_px: f32,
}

impl Point {
    /// Whether this is the glare of a disc.
    pub fn is_disc_glare(&self) -> bool {
        self.disc_radius_px > 0.0
    }
}
