//! The uniforms of one draw, all f32.
//!
//! Plain values: `scene::features` and the modules of each effect fill them, `render::plan` writes them to uniform blocks by name. A field followed
//! by a quoted name fills the uniform of that name in shaders/lib/draw.wesl. To add a uniform, add one line in that file and one here.

use crate::mesh::Mesh;
use crate::scene::camera::{self, ViewRays};
use crate::scene::constants::{MAX_DETAIL_LATTICES, OPTICAL_DEPTH_TERMS};
use crate::scene::draw::tables::{LimbTable, RingShadowGrid, RingShine, RingTable};
use glam::{Mat4, Vec2, Vec3, Vec4};
use std::borrow::Cow;
use std::sync::Arc;

/// The value of one uniform field.
#[derive(Clone, Debug, PartialEq)]
pub enum UniformValue<'a> {
    F32(f32),
    Vec2(Vec2),
    Vec3(Vec3),
    Vec4(Vec4),
    Mat4(Mat4),
    /// `array<vec4f, n>`.
    Rows(Cow<'a, [Vec4]>),
}

macro_rules! from_plain {
    ($($plain:ty => $variant:ident),*) => {
        $(impl From<&$plain> for UniformValue<'_> {
            fn from(value: &$plain) -> Self {
                Self::$variant(*value)
            }
        })*
    };
}
from_plain!(f32 => F32, Vec2 => Vec2, Vec3 => Vec3, Vec4 => Vec4, Mat4 => Mat4);

impl<'a, const N: usize> From<&'a [Vec4; N]> for UniformValue<'a> {
    fn from(rows: &'a [Vec4; N]) -> Self {
        Self::Rows(Cow::Borrowed(rows))
    }
}

impl<'a> From<&'a Vec<Vec4>> for UniformValue<'a> {
    fn from(rows: &'a Vec<Vec4>) -> Self {
        Self::Rows(Cow::Borrowed(rows))
    }
}

impl<'a> From<&'a Arc<Vec<Vec4>>> for UniformValue<'a> {
    fn from(rows: &'a Arc<Vec<Vec4>>) -> Self {
        Self::Rows(Cow::Borrowed(rows))
    }
}

/// Declares a struct. A field with a quoted name fills the uniform of that name: `pub top_radius_sq_minus_1: f32 = "air_top_radius_sq_minus_1"`.
macro_rules! uniforms {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($(#[$field_meta:meta])* pub $field:ident : $ty:ty $(= $uniform:literal)?,)*
        }
    ) => {
        $(#[$meta])*
        pub struct $name {
            $($(#[$field_meta])* pub $field: $ty,)*
        }

        impl $name {
            /// Names of the uniforms that fields of this struct fill.
            const UNIFORMS: &'static [&'static str] = &[$($($uniform,)?)*];

            /// The value of the field that fills the uniform `name`; `None` if no field of this struct does.
            fn own_uniform(&self, name: &str) -> Option<UniformValue<'_>> {
                match name {
                    $($($uniform => Some(UniformValue::from(&self.$field)),)?)*
                    _ => None,
                }
            }
        }
    };
}

/// One light on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the light, body-fixed axes.
    pub direction_in_body: Vec3,
    /// Irradiance on a plane facing the light, linear RGB, in units of the Sun's at 1 au.
    pub irradiance: Vec3,
}

uniforms! {
    /// The uniforms of one draw, all f32. Unless stated otherwise, vectors are in the body's unit-sphere frame: body-fixed axes, each divided by its semi-axis
    /// (so the ellipsoid is the unit sphere).
    ///
    /// The draw covers the screen rectangle that bounds the silhouette. At rectangle coordinates (u, v), each from 0 to 1 (v down the screen), the view ray is
    /// `anchor(u,v) + s * ray(u,v)`. Anchor and ray are affine in u and v: value = origin + u * du + v * dv.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct DrawUniforms {
        /// Bounding rectangle in clip space: x of the left edge, y of the top edge, x of the right, y of the bottom (y up, -1..1).
        pub rect_in_clip: Vec4 = "rect_in_clip",
        /// A point on each view ray: the camera itself, or for a camera far from the body the intersection with the plane through the body's centre parallel
        /// to the image, so that values are of order one. `anchor_is_camera` says which.
        pub anchor_origin: Vec3 = "anchor_origin",
        pub anchor_du: Vec3 = "anchor_du",
        pub anchor_dv: Vec3 = "anchor_dv",
        /// Direction of each view ray away from the camera, not normalised.
        pub ray_origin: Vec3 = "ray_origin",
        pub ray_du: Vec3 = "ray_du",
        pub ray_dv: Vec3 = "ray_dv",
        /// |camera|² - 1, computed in f64 and then narrowed. Ignored when `anchor_is_camera` is 0.
        pub anchor_radius_sq_minus_1: f32 = "anchor_radius_sq_minus_1",
        /// 1: the anchor is the camera. 0: it is in the plane through the body's centre.
        pub anchor_is_camera: f32 = "anchor_is_camera",
        /// |ray|² (1 - q²), where q is the view ray's distance from the centre, as a polynomial in u and v: coefficients of 1, u, v, then of u², uv, v²
        /// (xyz of each row).
        pub silhouette_form: [Vec4; 2] = "silhouette_form",
        /// Clip-space depth of a point p of the unit-sphere frame: reversed depth = 1 / (dot(depth_row.xyz, p) + depth_row.w).
        pub depth_row: Vec4 = "depth_row",
        /// The point of the body that reaches farthest along the line from the body's centre to the camera. The pixel view `depth` shows places along this
        /// line, from 0 to 1 at this point, and not along the view axis, which differs between the faces of a dome image.
        pub nearest_point: Vec3 = "nearest_point",
        /// Semi-axes divided by the equatorial radius: (1, b/a, c/a).
        pub axis_ratios: Vec3 = "axis_ratios",
        /// Linear RGB reflectance, or radiance for emissive surfaces: a factor on the albedo map if there is one, else the value itself.
        pub albedo: Vec3 = "albedo",
        pub lights: Vec<Light>,
        /// Lunar weight L of lunar-lambert, or Oren-Nayar's sigma² (rad²).
        pub photometric_parameter: f32 = "photometric_parameter",
        /// Limb darkening per channel (emissive surfaces only).
        pub limb_darkening_u1: Vec3 = "limb_darkening_u1",
        pub limb_darkening_u2: Vec3 = "limb_darkening_u2",
        /// Part of each pixel over which the light of a thin crescent is averaged: 1 for all of it, less where averages fade out, 0 for a single point
        /// (`surface::crescent`). In the draw of the sky: that of the ground's draw.
        pub averaged_part: f32 = "averaged_part",
        /// Factors on y and z of a unit-sphere point. Longitude and latitude of the resulting direction give the column and the row of the map. The factors
        /// depend on whether the map's rows are spaced by planetocentric or by planetographic latitude.
        pub map_stretch: Vec2 = "map_stretch",
        /// Lower limit of the width on the ground of any pixel of the draw, as a fraction of the body's circumference.
        pub map_pixel: f32 = "map_pixel",
        /// Distance of the camera from the centre, minus 1.
        pub camera_height: f32 = "camera_height",
        /// Radiance of a white texel of the night map.
        pub night_radiance: Vec3 = "night_radiance",
        /// Factor on the light that water mirrors.
        pub specular_strength: f32 = "specular_strength",
        /// Mean square slope of the waves: the sum for both horizontal directions.
        pub wave_slope_sq: f32 = "wave_slope_sq",
        /// Factor on the slopes of the normal map.
        pub normal_strength: f32 = "normal_strength",
        /// Images over the ground, the lowest first.
        pub overlays: Vec<OverlayUniforms>,
        pub clouds: CloudUniforms,
        pub eclipse: EclipseUniforms,
        pub ring: RingUniforms,
        pub air: AtmosphereUniforms,
        /// The camera in the unit-sphere frame, f32.
        pub camera_in_unit_sphere: Vec3 = "camera_in_unit_sphere",
        /// Clip units per pixel.
        pub pixel_size: Vec2 = "pixel_size",
        /// Matrix from a mesh's points relative to `mesh_anchor` to clip positions with reversed depth.
        pub clip_from_unit_sphere: Mat4 = "clip_from_unit_sphere",
        /// Subtracted from vertices, unit-sphere frame: the camera if it is near the body, else 0.
        pub mesh_anchor: Vec3 = "mesh_anchor",
        /// `None`: the shape is the ellipsoid or a ring.
        pub mesh: Option<MeshInstance>,
        pub detail: DetailUniforms,
        /// Limbs of bodies in front of an emissive body.
        pub foreground_limbs: ForegroundLimbUniforms,
        pub limb: LimbUniforms,
    }
}

/// The triangles of a draw whose shape is a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshInstance {
    /// The body's shape model.
    pub model: Arc<Mesh>,
    /// For each vertex: altitude of the Sun's centre above the horizon that the shape forms there, in radii of the Sun's disc; negative below it.
    pub sun_altitudes: Arc<Vec<f32>>,
}

uniforms! {
    /// The cloud shell, for its own draw and for its shadow on the ground.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct CloudUniforms {
        /// Values of the cloud map, 0 to 1, of a clear sky and of a closed cloud deck.
        pub clear_texel: f32 = "cloud_clear",
        pub closed_texel: f32 = "cloud_full",
        /// Radius of the shell in the body's unit-sphere frame.
        pub radius: f32 = "cloud_radius",
        /// Lambert albedo of a closed deck; it dims the light that a deck lets through to the ground.
        pub albedo: f32 = "cloud_albedo",
        /// Radiance of a closed deck divided by its irradiance. This field and the next two are for pixels in which the ground's draw also shows the clouds.
        pub reflectance: f32 = "cloud_reflectance",
        /// Optical depth of the air above the clouds, in the form of [`AtmosphereUniforms::optical_depth_above_ground`].
        pub optical_depth_above: [Vec4; OPTICAL_DEPTH_TERMS] = "cloud_optical_depth_above",
        /// First row of the clouds' part of the coarse image of the air. `render::plan`, which arranges the image, sets this field.
        pub coarse_first_row: f32 = "cloud_coarse_first_row",
    }
}

uniforms! {
    /// The air above a floor: the ground or, in the clouds' draw, the cloud shell. Lengths are in the floor's equatorial radii. `radius_sq_minus_1` is
    /// |p|² - 1 in the frame in which the floor is the unit sphere.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct AtmosphereUniforms {
        /// `radius_sq_minus_1` of the air's top.
        pub top_radius_sq_minus_1: f32 = "air_top_radius_sq_minus_1",
        /// For the view rays that only rise or only fall within the air: heights of the near end (x: the camera, or the air's top if the camera is above it)
        /// and of the far end (y: 0 or the air's top). `scene::atmosphere::uniform_rows` computes the uniform `air_quadrature_nodes` from them.
        pub end_heights: Vec2,
        pub rayleigh_scale_height: f32 = "air_rayleigh_scale_height",
        /// This and the other coefficients of Rayleigh and Mie: at the floor, per equatorial radius, linear RGB.
        pub rayleigh_scattering: Vec3 = "air_rayleigh_scattering",
        pub rayleigh_extinction: Vec3 = "air_rayleigh_extinction",
        /// Of the sunlight that extinction removes, the fraction that reaches the ground as skylight.
        pub skylight_fraction: Vec3 = "air_skylight_fraction",
        pub mie_scale_height: f32 = "air_mie_scale_height",
        /// Parameters of the aerosol's phase function: `catalog::AerosolPhase::parameters`.
        pub mie_phase_parameters: Vec4 = "air_mie_phase_parameters",
        pub mie_scattering: Vec3 = "air_mie_scattering",
        pub mie_extinction: Vec3 = "air_mie_extinction",
        /// `radius_sq_minus_1` at the bottom, the middle and the top of the absorption layer.
        pub absorption_layer: Vec3 = "air_absorption_layer",
        /// At the middle of the absorption layer, per equatorial radius, linear RGB.
        pub absorption_extinction: Vec3 = "air_absorption_extinction",
        /// Optical depth of the air above the floor, as `scene::atmosphere::optical_depth_above_ground` fits it: coefficients of t, t², ... (xyz: RGB), and k
        /// in w of the first row, for t = 1 / (1 + k cos z) at the zenith angle z.
        pub optical_depth_above_ground: [Vec4; OPTICAL_DEPTH_TERMS] = "air_optical_depth_above_ground",
        /// 0: the atmosphere is composited over the ground. 1: the ground's map includes the atmosphere, so the brighter of the two is shown. 2: the map
        /// includes an atmosphere that is transparent straight down, so the disc shows the map alone, and the atmosphere beyond the limb continues the disc's
        /// brightness.
        pub blend_mode: f32 = "air_blend_mode",
        /// Weight of mode 1 or 2 in a mixture with mode 0: 1 for a camera above the air, less for one in it; 0 if `blend_mode` is 0. In the draw of the sky the
        /// shader gives mode 2 less weight: none to rays that rise from a camera in the air.
        pub map_weight: f32 = "air_map_weight",
        /// Radiance of the night sky (airglow and light from beyond the air), as it lights the ground. In a draw of the sky: of the airglow alone, above the
        /// camera; 0 for a camera outside the air.
        pub night_radiance: f32 = "air_night_radiance",
        /// In a draw of the sky: mean radiance of zodiacal light and starlight, 0 for a camera outside the air. The air scatters a part of it, in proportion to
        /// the air's opacity.
        pub light_from_beyond: f32 = "air_starlight",
        /// Irradiance by the second light source, the body that reflects most sunlight here, divided by the Sun's here, for the light of the air; 0 if the air
        /// would not visibly scatter that light.
        pub second_light_irradiance: Vec3 = "air_second_light",
        /// 1 if the atmosphere's rim is less than a pixel high: the rings' shadow is then evaluated once per view ray through it.
        pub rim_is_thin: f32 = "air_rim_is_thin",
        /// Largest accepted error of interpolation in the coarse image of the air: x relative to the air's light, y as radiance divided by the irradiance of
        /// the first light source, the Sun. An error below either is accepted. Both are negative if no pixel may interpolate.
        pub max_coarse_error: Vec2,
        /// First row of the body's part of the coarse image of the air. `render::plan` sets this field.
        pub coarse_first_row: f32 = "air_coarse_first_row",
        /// Heights for the table of multiply scattered light, which measures them from the ground, whereas the draw measures them from the floor. x: height of
        /// the floor above the ground. y: 1 / height of the air's top above the ground.
        pub multi_scatter_heights: Vec2 = "air_multi_scatter_heights",
        /// The table of `scene::atmosphere::multi_scatter_table`; empty if the draw does not read it.
        pub multi_scatter: Arc<Vec<Vec4>> = "air_multi_scatter",
    }
}

uniforms! {
    /// Uniforms of shaders/lib/eclipse, all f32. Positions are differences in f64 from the receiver's centre; lengths are in its equatorial radii.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct EclipseUniforms {
        /// Unit vector to the Sun in body axes (xyz), and 1 / distance (w).
        pub axis: Vec4 = "eclipse_axis",
        /// Two unit vectors perpendicular to the axis (xyz). Their w: the cotangent of the Sun's angular radius, and this cotangent divided by the distance.
        pub perpendicular_axes: [Vec4; 2] = "eclipse_perpendicular_axes",
        /// Largest accepted error of sunlight that is interpolated from the coarse image of the air, as [`AtmosphereUniforms::max_coarse_error`].
        pub max_coarse_error: Vec2,
        /// First row of the sunlight's part of the coarse image of the air. `render::plan` sets this field.
        pub coarse_first_row: f32 = "eclipse_coarse_first_row",
        /// Radiance of the Sun's disc, normalised so that its integral over the unit disc is 1: coefficients of 1, mu, mu² per channel.
        pub limb_darkening: [Vec4; 3] = "eclipse_limb_darkening",
        /// Per occluder: the coordinates of its centre across the axis (xy) and along it (z).
        pub occluder_positions: Vec<Vec4> = "occluder_position",
        /// Per occluder: the unit vector of its outline's long axis (xy), and the semi-axes (zw).
        pub occluder_outlines: Vec<Vec4> = "occluder_outline",
        /// Per refracting layer of the first occluder's atmosphere: apparent radius and reduced bending angle, radians, at its lower edge (xy) and at its upper
        /// edge (zw). Reduced: times `scene::eclipse::refraction::shift_per_bending`.
        pub air_edges: Vec<Vec4> = "occluder_air_edges",
        /// Per refracting layer: its transmittance.
        pub air_transmittance: Vec<Vec4> = "occluder_air_transmittance",
        /// The table of `scene::atmosphere::multi_scatter_in_shadow`; empty if the draw does not read it.
        pub multi_scatter: Vec<Vec4> = "occluder_multi_scatter",
    }
}

uniforms! {
    /// Uniforms of shaders/lib/detail.wesl, where a lattice is a cubic grid of cells of one size. Positions are relative to an origin: in a narrow field of
    /// view a point of the ground in view; otherwise the camera if it is near the body, else the body's centre. Lengths are in the body's radii.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct DetailUniforms {
        /// Per lattice, from coarse to fine: the position of the origin within its cell, in cells (xyz), and the side of a cell (w).
        pub lattice: [Vec4; MAX_DETAIL_LATTICES] = "detail_lattice",
        /// Per lattice: the cell that contains the origin (xyz), modulo the lattices' period.
        pub cells: [Vec4; MAX_DETAIL_LATTICES] = "detail_cells",
        /// Side of a cell at which lattices have faded out; they begin to fade at half this side. The rows hold no coarser lattice.
        pub largest: f32 = "detail_largest",
        /// The camera relative to the origin (xyz), and the tangent of the angle that a pixel spans (w).
        pub camera: Vec4 = "detail_camera",
        /// The origin, if it is a point of the ground. Row 0: this point in the unit-sphere frame (xyz), and its view depth (w; 0: the origin is no point of
        /// the ground). Row 1: the view ray to the point, with a view depth of 1 (xyz), and the point's u in the draw's rectangle (w). Row 2: its v (x).
        pub reference: [Vec4; 3] = "detail_reference",
    }
}

uniforms! {
    /// Uniforms of shaders/lib/limb_heights.wesl.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct LimbUniforms {
        /// In the Moon's draw: unit vectors towards the position angles 0 and 90 degrees of its limb. In the draw of the Sun behind the Moon: coefficients of
        /// 1, x, y that give a pixel's offset from the Moon along these vectors (shaders/lib/draw.wesl).
        pub position_angle_axes: [Vec4; 2] = "limb_position_angle_axes",
        pub table: Option<Arc<LimbTable>>,
    }
}

uniforms! {
    /// Uniforms of shaders/lib/foreground_limb.wesl.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct ForegroundLimbUniforms {
        /// Three rows for each of two bodies, which shaders/lib/foreground_limb.wesl describes. All rows share one origin of screen positions, whose x (pixels)
        /// is w of the first body's third row, and whose y is w of the second's.
        pub rows: [Vec4; 6] = "foreground_limb",
    }
}

pub use crate::scene::constants::VECTORS_PER_OVERLAY;

/// The uniforms of one overlay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlayUniforms {
    /// As shaders/lib/overlay.wesl describes them.
    pub rows: [Vec4; VECTORS_PER_OVERLAY],
    /// Whether the image spans all longitudes, so that its left edge joins its right edge.
    pub wraps_around: bool,
}

uniforms! {
    /// Uniforms of shaders/lib/ring.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct RingUniforms {
        pub table: Option<Arc<RingTable>>,
        /// Innermost and outermost radius, equatorial radii.
        pub radius_range: Vec2 = "ring_radius_range",
        /// Outermost radius of all rings of the body, drawn or not, equatorial radii.
        pub outermost_radius: f32 = "ring_extent",
        /// Maximum number of segments into which a pixel's footprint on the ring's plane is divided, at least 1.
        pub max_segments: f32 = "ring_segments",
        /// Size of half a pixel at the body's distance, equatorial radii.
        pub half_pixel: f32 = "ring_half_pixel",
        /// Phase function of the large particles: x times the scattering angle (radians) to the power y.
        pub phase: Vec2 = "ring_phase",
        /// Asymmetry of each lobe of the dust's phase function, and the fraction of the light in each lobe.
        pub dust_asymmetry: Vec3 = "ring_dust_asymmetry",
        pub dust_weight: Vec3 = "ring_dust_weight",
        /// Height (x) of the opposition surge, and its width (y): the tangent of half the phase angle at which half of the height is left.
        pub opposition: Vec2 = "ring_opposition",
        /// The half of the rings that is drawn. 1: the one in front of the body's centre; -1: the one behind it; 0: both.
        pub side: f32 = "ring_side",
        /// Tangent of the Sun's angular radius.
        pub sun_tangent: f32 = "sun_tangent",
        /// For the globe's shadow on the rings: the globe's semi-axes divided by its equatorial radius.
        pub shadow_axes: Vec3 = "shadow_axes",
        /// For the same shadow: the Sun's limb darkening per channel.
        pub sun_limb_darkening_u1: Vec3 = "sun_limb_darkening_u1",
        pub sun_limb_darkening_u2: Vec3 = "sun_limb_darkening_u2",
        /// Ring-shine on the globe.
        pub shine: Option<Arc<RingShine>>,
        /// Ring-shine: unit vector in the ring's plane, in the direction of the Sun's projection on it (xy); 1 / the height above this plane from which no ring
        /// is visible (z); factor on the light (w).
        pub shine_parameters: Vec4 = "ring_shine",
        /// The shadow of another body's rings.
        pub shadow_grid: Option<Arc<RingShadowGrid>>,
        /// A point p (body axes, equatorial radii) is in the column dot(xyz, p) + w of the first vector, and in the row that the second vector gives.
        pub shadow_grid_axes: [Vec4; 2] = "ring_shadow_axes",
    }
}

impl RingUniforms {
    /// (x, y, z) for the index of the bin that contains a radius in the table: x - y / radius, at most z.
    fn bins(&self) -> Vec3 {
        self.table.as_ref().map_or(Vec3::ZERO, |t| Vec3::from_array(t.bins.map(camera::narrow_scalar)))
    }

    /// The slants of a ring's own table, by their index in the series of all slants (`scene::rings::ring_table`): the first (x), and the last relative to it,
    /// minus a margin (y).
    fn slants(&self) -> Vec2 {
        let [first, last] = self.table.as_ref().map_or([0, 1], |t| t.slants).map(f64::from);
        // The upper limit stays just below the last row, so that interpolation reads the last row as the successor of the row before it.
        Vec2::new(camera::narrow_scalar(first), camera::narrow_scalar(last - first - 1e-3))
    }

    /// Number of slants of sunlight in the table of the rings' shadow, one per row after the bins; 0 without a table.
    fn sun_rows(&self) -> f32 {
        self.table.as_ref().map_or(0.0, |t| camera::narrow_scalar(f64::from(t.rows_after_bins())))
    }
}

impl DrawUniforms {
    /// Names of the uniforms that [`Self::uniform`] computes: no field holds their value.
    const DERIVED: [&'static str; 6] = ["light_direction", "light_irradiance", "overlay", "ring_bins", "ring_slants", "ring_sun_rows"];

    /// Names of all uniforms that a draw's values fill.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let own =
            [Self::UNIFORMS, CloudUniforms::UNIFORMS, EclipseUniforms::UNIFORMS, RingUniforms::UNIFORMS, AtmosphereUniforms::UNIFORMS];
        own.into_iter()
            .chain([ForegroundLimbUniforms::UNIFORMS, DetailUniforms::UNIFORMS, LimbUniforms::UNIFORMS])
            .flatten()
            .copied()
            .chain(Self::DERIVED)
    }

    /// The value of a uniform by its name in the WESL files; `None` if no field has that name.
    pub fn uniform(&self, name: &str) -> Option<UniformValue<'_>> {
        let of_lights = |field: fn(&Light) -> Vec3| UniformValue::Rows(self.lights.iter().map(|l| field(l).extend(0.0)).collect());
        match name {
            "light_direction" => Some(of_lights(|l| l.direction_in_body)),
            "light_irradiance" => Some(of_lights(|l| l.irradiance)),
            "overlay" => Some(UniformValue::Rows(self.overlays.iter().flat_map(|o| o.rows).collect())),
            "ring_bins" => Some(UniformValue::Vec3(self.ring.bins())),
            "ring_slants" => Some(UniformValue::Vec2(self.ring.slants())),
            "ring_sun_rows" => Some(UniformValue::F32(self.ring.sun_rows())),
            _ => self
                .own_uniform(name)
                .or_else(|| self.clouds.own_uniform(name))
                .or_else(|| self.eclipse.own_uniform(name))
                .or_else(|| self.ring.own_uniform(name))
                .or_else(|| self.air.own_uniform(name))
                .or_else(|| self.detail.own_uniform(name))
                .or_else(|| self.limb.own_uniform(name))
                .or_else(|| self.foreground_limbs.own_uniform(name)),
        }
    }

    /// The uniforms of the view rays over a rectangle; all other uniforms have their defaults.
    pub fn of_rays(rays: &ViewRays) -> Self {
        Self::default().with_rays(rays)
    }

    /// These uniforms with the view rays of another rectangle.
    pub(crate) fn with_rays(self, rays: &ViewRays) -> Self {
        Self {
            rect_in_clip: rays.rect_in_clip,
            anchor_origin: rays.anchor_origin,
            anchor_du: rays.anchor_du,
            anchor_dv: rays.anchor_dv,
            ray_origin: rays.ray_origin,
            ray_du: rays.ray_du,
            ray_dv: rays.ray_dv,
            anchor_radius_sq_minus_1: rays.anchor_radius_sq_minus_1,
            anchor_is_camera: if rays.anchor_is_camera { 1.0 } else { 0.0 },
            silhouette_form: rays.silhouette_form,
            depth_row: rays.depth_row,
            nearest_point: rays.nearest_point,
            ..self
        }
    }
}
