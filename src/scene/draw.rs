//! How much a draw needs: amounts, maps, points. The structure beside them is [`Needs`]; uniforms come from [`Amounts`].

use super::camera::ViewRays;
pub use super::constants;
pub use super::eclipse::EclipseAmounts;
pub use super::hidden::HiderAmounts;
pub use super::needs::*;
pub use super::overlays::OverlayAmounts;
pub use super::ring_table::RingTable;
pub use super::rings::RingAmounts;
use crate::catalog::NaifId;
use crate::mesh::Model;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// One light: where it comes from in the body's unit-sphere axes' parent frame (body-fixed axes), and how strong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the light, body-fixed axes.
    pub direction_in_body: Vec3,
    /// Irradiance on a plane facing the light, linear RGB, in units of the Sun's at 1 au.
    pub irradiance: Vec3,
}

/// The amounts of one draw, all f32, all in the body's unit-sphere frame: body-fixed axes, each divided by its semi-axis
/// (so the ellipsoid is the unit sphere).
///
/// The screen rectangle that bounds the silhouette is drawn; at rectangle coordinate (u, v) in 0 to 1 each (v down the screen), the view ray is
/// `anchor(u,v) + s * ray(u,v)`, both affine in u and v: value = origin + u * du + v * dv.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Amounts {
    /// Bounding rectangle in clip space: x of the left edge, y of the top edge, x of the right, y of the bottom (y up, -1..1).
    pub rect_in_clip: Vec4,
    /// A point on each view ray. Far camera: the crossing with the plane through the body's centre facing it, so magnitudes
    /// stay near one; near camera: the camera itself.
    pub anchor_origin: Vec3,
    pub anchor_du: Vec3,
    pub anchor_dv: Vec3,
    /// Direction of each view ray away from the camera, not normalised.
    pub ray_origin: Vec3,
    pub ray_du: Vec3,
    pub ray_dv: Vec3,
    /// Near camera: |camera|² - 1, computed in f64. Ignored when `anchor_is_camera` is 0.
    pub anchor_excess: f32,
    /// 1: the anchor is the camera (near form); 0: the anchor plane (far form).
    pub anchor_is_camera: f32,
    /// Clip-space depth of a point p of the unit-sphere frame: reversed depth = 1 / (dot(row.xyz, p) + row.w).
    pub depth_row: Vec4,
    /// Semi-axes over the equatorial radius: (1, b/a, c/a).
    pub axis_ratios: Vec3,
    /// Linear RGB reflectance scale (or radiance, for emissive): multiplies the map, or stands alone without one.
    pub albedo: Vec3,
    pub lights: Vec<Light>,
    /// Lunar weight L of lunar-lambert, or Oren-Nayar's sigma² (rad²).
    pub photometric_parameter: f32,
    /// Limb darkening per channel (emissive).
    pub limb_u1: Vec3,
    pub limb_u2: Vec3,
    /// z stretch that turns a unit-sphere point into the direction whose latitude the map counts.
    pub map_latitude_stretch: f32,
    /// Night lights radiance scale, ocean glint strength and mean square slope of the waves.
    pub night_radiance: Vec3,
    pub specular_strength: f32,
    pub wave_slope_sq: f32,
    /// Normal map strength.
    pub normal_strength: f32,
    /// Images over the ground, the lowest first.
    pub overlays: Vec<OverlayAmounts>,
    pub clouds: CloudAmounts,
    pub eclipse: EclipseAmounts,
    pub ring: RingAmounts,
    pub air: AirAmounts,
    /// Unit camera position for distant views or camera in unit-sphere frame, f32.
    pub camera_in_unit_sphere: Vec3,
    pub pixel_size: Vec2,
    /// Clip place of a mesh's points less the anchor, reversed depth.
    pub clip_from_unit_sphere: glam::Mat4,
    /// Near the ground the camera, farther out 0; unit-sphere frame.
    pub mesh_anchor: Vec3,
    pub mesh: Option<MeshAmounts>,
    /// Of a body that glows.
    pub hiders: HiderAmounts,
}

/// The triangles of a draw whose shape is a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAmounts {
    pub model: Arc<Model>,
    /// Unit vector towards the Sun in body axes and its angular radius in radians, where the mesh shades itself.
    pub sun: Option<(DVec3, f64)>,
    /// Height of the Sun over the shape's own horizon at each vertex, in its radii; brought in where `sun` asks for it.
    pub sun_heights: Option<Arc<Vec<f32>>>,
}

/// The cloud shell, for its own draw and for its shadow on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CloudAmounts {
    /// Texels at which the sky is clear, and closed.
    pub clear: f32,
    pub full: f32,
    /// Radius of the shell in the body's unit-sphere frame.
    pub radius: f32,
    /// Lambert albedo of a closed deck.
    pub albedo: f32,
}

/// The air, lengths in equatorial radii. An excess is |p|² - 1 in the unit-sphere frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AirAmounts {
    /// Excess above which there is nothing.
    pub top: f32,
    /// Heights of the camera's end and the far end of a ray that only rises or only falls; outside the air, that of its top.
    pub ends: Vec2,
    pub gas_height: f32,
    /// Per radius at the ground, linear RGB.
    pub gas_scattering: Vec3,
    pub gas_extinction: Vec3,
    /// Part of the light taken out of the sunlight that reaches the ground from the sky.
    pub skylight: Vec3,
    pub haze_height: f32,
    pub haze_asymmetry: f32,
    pub haze_scattering: Vec3,
    pub haze_extinction: Vec3,
    /// Excess at the foot, the middle and the top of an absorbing layer.
    pub layer: Vec3,
    pub layer_extinction: Vec3,
    /// 0: the air lies over the ground. 1: the ground's colours hold the air already, so that of both the brighter is seen. 2: they hold air that hides
    /// nothing straight down, so that the disc is seen, and beside it the air goes on with the disc's light.
    pub veil: f32,
    /// Radiance of the night sky: none for a sky that is seen from outside.
    pub night: f32,
    /// Height of the floor over the ground and one over that of the top, both in the floor's radii.
    pub many_heights: Vec2,
    /// [`crate::scene::air_table`]; brought in where the draw asks for it.
    pub many: Arc<Vec<Vec4>>,
}

/// Which part of a body a draw shows, in the order in which parts of one body are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The half of the ring behind the globe's centre.
    RingBehind,
    /// The air beside the ground, before it: the ground's soft edge covers it.
    Sky,
    Globe,
    Clouds,
    /// The half of the ring before the globe's centre.
    Ring,
}

impl Part {
    pub fn name(self) -> &'static str {
        match self {
            Self::RingBehind => "ring-behind",
            Self::Sky => "sky",
            Self::Globe => "globe",
            Self::Clouds => "clouds",
            Self::Ring => "ring",
        }
    }
}

/// One draw of a body that is large enough to be a disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    pub body: NaifId,
    pub part: Part,
    /// The body's name, for labels.
    pub name: String,
    pub needs: Needs,
    pub amounts: Amounts,
    /// The map files that `needs.maps` asks for.
    pub map_files: MapFiles,
}

impl Draw {
    /// The same shape, black and without anything on it: what it covers.
    pub fn shape_alone(&self) -> Self {
        let two_sided = self.needs.flags.two_sided;
        let needs = Needs { shape: self.needs.shape, flags: Flags { two_sided, ..Flags::default() }, ..Needs::LEAST };
        Self { needs, map_files: MapFiles::default(), ..self.clone() }
    }
}

/// File names of a draw's maps inside the textures folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MapFiles {
    pub albedo: Option<String>,
    pub normal: Option<String>,
    pub specular: Option<String>,
    pub night: Option<String>,
    pub cloud: Option<String>,
    /// In the order of the overlays' amounts.
    pub overlays: Vec<String>,
}

impl Amounts {
    /// What every draw over a rectangle has: its view rays.
    pub(super) fn of_rays(rays: &ViewRays) -> Self {
        Self {
            rect_in_clip: rays.rect_in_clip,
            anchor_origin: rays.anchor_origin,
            anchor_du: rays.anchor_du,
            anchor_dv: rays.anchor_dv,
            ray_origin: rays.ray_origin,
            ray_du: rays.ray_du,
            ray_dv: rays.ray_dv,
            anchor_excess: rays.anchor_excess,
            anchor_is_camera: if rays.anchor_is_camera { 1.0 } else { 0.0 },
            depth_row: rays.depth_row,
            ..Self::default()
        }
    }
}

impl MapFiles {
    /// Each file with the texture binding it is read from (1 albedo, 2 normal, 3 specular, 4 night, 7 cloud, 9 and 10 overlays).
    pub fn bindings(&self) -> impl Iterator<Item = (u32, &str)> {
        let overlays = (9..).zip(self.overlays.iter().map(String::as_str));
        [(1, &self.albedo), (2, &self.normal), (3, &self.specular), (4, &self.night), (7, &self.cloud)]
            .into_iter()
            .filter_map(|(binding, file)| file.as_deref().map(|f| (binding, f)))
            .chain(overlays)
    }
}

/// A body too small for a disc: a sprite that carries its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub body: NaifId,
    /// Clip x and y, reversed depth.
    pub centre: Vec3,
    /// Reach of the sprite in pixels, three standard deviations.
    pub radius_px: f32,
    /// Linear RGB sum of its radiance over the pixels it falls on.
    pub flux: Vec3,
}
