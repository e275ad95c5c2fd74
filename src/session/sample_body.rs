//! Plans the drawing of a sample body with any module that has a key, to measure the cost of a key and to compare its results in f32 and f64.
//!
//! In: a module and the side of a square image. Out: a plan that draws a slightly flattened body, lit from the side, as seen from far away in its
//! equatorial plane (rings: from 25 degrees above that plane). Maps are small and the same for every key, so that differences between the images of two
//! keys are due to the keys alone.

use super::SessionError;
use crate::catalog::Ring;
use crate::image::{Level, SharedTexture, TexelFormat, Texture};
use crate::render::plan::{
    AddressMode, Attribute, Blend, COARSE_AIR_TEXTURE, ColourFormat, Cull, DepthState, FrameImages, FrontFace, Instances, LIMB_TABLE, Pass,
    Plan, PlanDraw, PlanError, RING_PROFILE, RING_SHADOW_GRID, RING_SHINE, SamplerBinding, SamplerState, ShadingRate, TextureBinding,
    TextureSource, Vertices, coarse_air_subimage_size, limb_table, map_format, ring_profile, ring_shadow_grid, ring_shine, role_of,
    uniform_bytes,
};
use crate::render::software::SoftwareRenderer;
use crate::scene::constants::{LIMB_COLUMNS, LIMB_ROWS};
use crate::scene::draw::{
    AirPass, AtmosphereUniforms, CloudUniforms, DrawUniforms, EclipseUniforms, Light, LimbTable, LimbUniforms, MapRole, OverlayUniforms,
    RingShadowGrid, RingTable, RingUniforms, Shape, Surface,
};
use crate::scene::eclipse::REFRACTING_LAYERS;
use crate::scene::multi_scatter_in_shadow::{COLUMN_RANGES_START, COLUMNS as IN_SHADOW_COLUMNS, VECTORS as IN_SHADOW_VECTORS};
use crate::scene::multi_scatter_table::{COLUMNS as MULTI_SCATTER_COLUMNS, NODES};
use crate::scene::optical_depth_above_ground;
use crate::scene::ring_shine::{COLUMNS, ROWS, RingShine, sun_disc_parts};
use crate::scene::rings::RingConditions;
use crate::shader::key::ShaderKey;
use crate::shader::{ModuleId, ShaderLibrary, ShaderModule};
use glam::{Mat4, Vec2, Vec3, Vec4};
use std::sync::Arc;
use std::time::Instant;

/// Side of a timed image, pixels.
const TIMED_SIDE_PX: u32 = 1000;
/// Largest number of taps on a map: that of standard quality.
const MAP_TAPS: u8 = 8;
/// Number of timed runs, of which the fastest counts.
const ROUNDS: usize = 5;
/// Half the image's side in body radii, small enough that even the corners are on the body.
pub const SAMPLE_HALF_SIDE_ON_DISC: f32 = 0.7;
/// Half the image's side in body radii, large enough that the whole limb is visible.
pub const SAMPLE_HALF_SIDE_WITH_LIMB: f32 = 1.25;
/// Number of columns and rows of quadrilaterals of the sphere mesh.
const MESH_SIZE: (u32, u32) = (48, 24);

/// Axis ratios of the sample body: flattened unless the key's shape is a sphere.
fn axis_ratios(key: &ShaderKey) -> Vec3 {
    if key.features().shape == Shape::Sphere { Vec3::ONE } else { Vec3::new(1.0, 1.0, 0.95) }
}

/// Direction of the Sun from the sample body, body axes; a unit vector except for rounding.
const SUNWARD: Vec3 = Vec3::new(0.6, 0.5, 0.624_5);
/// Occluders above the lit side, two of which overlap: the centre (two coordinates across the light's direction, one along it) and the radius, in radii of the
/// sample body.
const OCCLUDERS: [[f32; 4]; 4] = [[0.1, 0.1, 40.0, 0.25], [-0.15, 0.3, 55.0, 0.2], [0.4, -0.3, 20.0, 0.1], [-0.5, -0.4, 60.0, 0.3]];

/// The Sun as large as seen from the Earth, and as many occluders as the key has, the first with an atmosphere.
fn eclipse_uniforms(key: &ShaderKey) -> EclipseUniforms {
    // As for the Earth: the distance of the Sun in the Earth's radii, and the cotangent of the Sun's angular radius.
    let (sun_distance, sun_cotangent) = (23_455.0, 215.0);
    let along = SUNWARD.normalize_or_zero();
    let (x, y) = along.any_orthonormal_pair();
    let occluders = &OCCLUDERS[..usize::from(key.features().eclipse.occluders).min(OCCLUDERS.len())];
    let [_, _, _, radius] = OCCLUDERS[0];
    // Relative density of layer `k`, 1 for the lowest: bending and extinction decrease with height. Extinction is weakest in red.
    let density = |k: usize| 1.0 - k as f32 / REFRACTING_LAYERS as f32;
    // Apparent radius, in radii of the sample body, and reduced bending angle, radians, at the lower edge of a layer.
    let edge = |k: usize| (radius * (1.1 - 0.1 * density(k)), 0.02 * density(k).powi(2));
    let edges = (0..REFRACTING_LAYERS).map(|k| {
        let ((lower_radius, lower_bending), (upper_radius, upper_bending)) = (edge(k), edge(k + 1));
        Vec4::new(lower_radius, lower_bending, upper_radius, upper_bending)
    });
    let in_shadow_factor =
        |k: usize| (Vec3::new(0.1, 0.15, 0.2) + 0.8 * (k % IN_SHADOW_COLUMNS) as f32 / (IN_SHADOW_COLUMNS - 1) as f32).extend(0.0);
    // Integral of the limb-darkened disc's radiance, with u1 = 0.4 and u2 = 0.2.
    let disc_light = std::f32::consts::PI * (1.0 - 0.4 / 3.0 - 0.2 / 6.0);
    EclipseUniforms {
        axis: along.extend(1.0 / sun_distance),
        perpendicular_axes: [x.extend(sun_cotangent), y.extend(sun_cotangent / sun_distance)],
        // No error of interpolation is accepted.
        max_coarse_error: Vec2::ZERO,
        coarse_first_row: 0.0,
        // The same law as a polynomial in mu: constant, linear and quadratic coefficient.
        limb_darkening: [0.4, 0.8, -0.2].map(|f| Vec3::splat(f / disc_light).extend(0.0)),
        occluder_positions: occluders.iter().map(|[x, y, distance, _]| Vec4::new(*x, *y, *distance, 0.0)).collect(),
        // Direction of the long axis, then the two semi-axes.
        occluder_outlines: occluders.iter().map(|[.., radius]| Vec4::new(0.8, 0.6, *radius, 0.9 * radius)).collect(),
        air_edges: edges.collect(),
        air_transmittance: (0..REFRACTING_LAYERS).map(|k| Vec3::new(0.9, 0.6, 0.3).powf(4.0 * density(k)).extend(0.0)).collect(),
        // Factors that increase from the centre of the shadow outwards, and from red to blue. Then for each occluder the range of their columns: its start,
        // and 1 / its length, in solar radii from the occluder's limb.
        multi_scatter: (0..COLUMN_RANGES_START)
            .map(in_shadow_factor)
            .chain([Vec4::new(-1.5, 1.0 / 3.0, 0.0, 0.0); IN_SHADOW_VECTORS - COLUMN_RANGES_START])
            .collect(),
    }
}

/// A thin and a thick ring with a gap between them. The table describes their light if the rings themselves are drawn (`Surface::Ring`), otherwise their
/// shadow.
fn ring_uniforms(surface: Surface) -> RingUniforms {
    let sample_ring = |inner_km: f64, outer_km: f64, tau_normal: f64| Ring {
        name: String::new(),
        inner_km,
        outer_km,
        tau_normal,
        albedo: [0.8, 0.7, 0.5],
        dust_fraction: 0.0,
    };
    // The radii are in radii of the sample body.
    let unit_km = 1.0;
    let rings = [sample_ring(1.1, 1.5, 0.1), sample_ring(1.6, 2.2, 1.5)];
    let sine = f64::from(SUNWARD.normalize_or_zero().z);
    // The Sun about as large as seen from Saturn.
    let (sun_tangent, steepest_slant, flattest_slant) = (5e-4, 1.0, 4.0);
    let table = match surface {
        Surface::Ring => {
            let conditions = RingConditions::new(Some(sun_disc_parts(sine, sun_tangent)), steepest_slant, flattest_slant);
            RingTable::of(rings.iter(), unit_km, &conditions)
        }
        _ => RingTable::of_shadow(rings.iter(), unit_km, &[1.0 / sine]),
    };
    RingUniforms {
        radius_range: Vec2::new(1.1, 2.2),
        outermost_radius: 2.2,
        max_segments: 16.0,
        table: table.map(Arc::new),
        half_pixel: 0.002,
        // Factor and exponent of the phase function.
        phase: Vec2::new(0.15, 3.0),
        // Asymmetry of each lobe of the dust's phase function, then the fraction of the light in each lobe.
        dust_asymmetry: Vec3::new(0.99, 0.6, 0.1),
        dust_weight: Vec3::new(0.05, 0.03, 0.02),
        // Height and width of the opposition surge.
        opposition: Vec2::new(0.3, 0.005),
        // Both the near and the far half.
        side: 0.0,
        sun_tangent: 0.0005,
        shadow_axes: Vec3::new(1.0, 1.0, 0.95),
        sun_limb_darkening_u1: Vec3::splat(0.4),
        sun_limb_darkening_u2: Vec3::splat(0.2),
        shine: None,
        // Direction to the Sun within the plane, 1 / height above which no ring is visible, factor on the light.
        shine_parameters: SUNWARD.truncate().normalize_or_zero().extend(1.1).extend(1.0),
        shadow_grid: None,
        shadow_grid_axes: shadow_grid_axes(),
    }
}

/// Number of places along a side of the grid with the shadow of another body's rings.
const SHADOW_GRID_SIDE: u32 = 32;

/// The grid's columns and rows, across the direction to the Sun. The grid is a little wider than the body with its air.
fn shadow_grid_axes() -> [Vec4; 2] {
    let (x, y) = SUNWARD.normalize_or_zero().any_orthonormal_pair();
    let half_side = 0.5 * (SHADOW_GRID_SIDE - 1) as f32;
    [x, y].map(|axis| (axis * (half_side / 1.25)).extend(half_side))
}

/// Two dark bands, redder at their edges.
fn sample_shadow_grid() -> RingShadowGrid {
    let texel = |n: u32| {
        let from_middle = (n / SHADOW_GRID_SIDE).abs_diff(SHADOW_GRID_SIDE / 2);
        match from_middle {
            3 | 7 => [0.7, 0.68, 0.65, 0.0],
            4..=6 => [0.1, 0.1, 0.1, 0.0],
            _ => [1.0, 1.0, 1.0, 0.0],
        }
    };
    RingShadowGrid { side: SHADOW_GRID_SIDE, texels: (0..SHADOW_GRID_SIDE * SHADOW_GRID_SIDE).flat_map(texel).collect() }
}

/// Ring-shine that is strongest at night, and brighter on the Sun's side of the ring plane.
fn sample_ring_shine() -> RingShine {
    let texel = |n: usize| {
        let (row, column) = (n / COLUMNS, n % COLUMNS);
        let level = column as f32 / COLUMNS as f32 * if row < ROWS { 0.5 } else { 0.2 };
        [level, 0.9 * level, 0.7 * level, 0.0]
    };
    RingShine { texels: (0..2 * ROWS * COLUMNS).flat_map(texel).collect(), max_height: 0.9, brightest: 0.5 }
}

/// A limb profile of twenty hills and valleys, exaggerated to 0.03 of the radius so that they are visible.
fn sample_limb() -> LimbTable {
    let points = LIMB_COLUMNS * LIMB_ROWS;
    let height = |k: usize| 0.03 * (std::f32::consts::TAU * 20.0 * k as f32 / points as f32).sin();
    // Each texel contains a height, and its difference from the next height.
    LimbTable { texels: (0..points).flat_map(|k| [height(k), height(k + 1) - height(k), 0.0, 0.0]).collect() }
}

/// An atmosphere with Rayleigh and Mie scattering and an absorption layer. Its height is a fifth of the body's radius, so that each part is visible.
fn air_uniforms() -> AtmosphereUniforms {
    let radius_sq_minus_1 = |height: f32| height * (2.0 + height);
    let air = AtmosphereUniforms {
        // No error of interpolation is accepted.
        max_coarse_error: Vec2::ZERO,
        coarse_first_row: 0.0,
        top_radius_sq_minus_1: radius_sq_minus_1(0.2),
        // As of a ray from the top of the air to the ground.
        end_heights: Vec2::new(0.2, 0.0),
        rayleigh_scale_height: 0.025,
        rayleigh_scattering: Vec3::new(2.0, 4.0, 9.0),
        rayleigh_extinction: Vec3::new(2.0, 4.0, 9.0),
        skylight_fraction: Vec3::splat(0.4),
        mie_scale_height: 0.01,
        // Henyey-Greenstein's function (w = 0), even if that of catalogs changes: the images of this invented body must not change with it.
        mie_phase_parameters: Vec4::new(0.7, 0.7, 0.7, 0.0),
        mie_scattering: Vec3::splat(8.0),
        mie_extinction: Vec3::new(9.0, 9.5, 10.0),
        absorption_layer: Vec3::new(radius_sq_minus_1(0.03), radius_sq_minus_1(0.06), radius_sq_minus_1(0.09)),
        absorption_extinction: Vec3::new(0.8, 2.0, 0.2),
        optical_depth_above_ground: Default::default(),
        blend_mode: 0.0,
        map_weight: 0.0,
        night_radiance: 1e-3,
        light_from_beyond: 1e-3,
        second_light_irradiance: Vec3::splat(0.1),
        rim_is_thin: 0.0,
        // Height of the floor above the ground (0: the floor is the ground), and 1 / height of the air's top.
        multi_scatter_heights: Vec2::new(0.0, 5.0),
        multi_scatter: Arc::new((0..NODES).map(|k| Vec4::splat(0.02 * (k % MULTI_SCATTER_COLUMNS) as f32)).collect()),
    };
    AtmosphereUniforms { optical_depth_above_ground: optical_depth_above_ground::terms(&air), ..air }
}

/// Distance of the camera from the body's centre.
const DISTANCE_RADII: f32 = 1.0e3;

/// The uniforms of the sample body. `half_side`: half the image's side in body radii.
fn draw_uniforms(key: &ShaderKey, half_side: f32) -> DrawUniforms {
    // Rings are seen from 25 degrees above their plane; from within the plane they would be a line.
    let is_ring = key.features().surface == Surface::Ring;
    let forward = if is_ring { Vec3::new(-0.906_307_8, 0.0, -0.422_618_26) } else { Vec3::NEG_X };
    let up = Vec3::new(forward.z, 0.0, -forward.x);
    // Rays to a body are parallel. The footprints of rings need a camera in which rays meet: a ray of depth 1 is 1 / distance of the anchor's offset.
    let ray_per_anchor = if is_ring { 1.0 / DISTANCE_RADII } else { 0.0 };
    let anchor_origin = up * half_side - Vec3::Y * half_side;
    let (anchor_du, anchor_dv) = (Vec3::new(0.0, 2.0 * half_side, 0.0), up * (-2.0 * half_side));
    // The Sun's light and two fainter ones.
    let light_directions = [SUNWARD, Vec3::new(0.2, -0.9, 0.387_3), Vec3::new(-0.3, 0.1, -0.948_7)];
    let lights = light_directions.iter().zip([1.0, 0.1, 0.05]).take(usize::from(key.features().lights));
    DrawUniforms {
        rect_in_clip: Vec4::new(-1.0, 1.0, 1.0, -1.0),
        anchor_origin,
        anchor_du,
        anchor_dv,
        ray_origin: forward + anchor_origin * ray_per_anchor,
        ray_du: anchor_du * ray_per_anchor,
        ray_dv: anchor_dv * ray_per_anchor,
        // 1 - q², where q is the distance of a ray from the body's centre, for parallel rays of length 1: q² = half_side² ((2u - 1)² + (2v - 1)²).
        silhouette_form: [
            Vec4::new(1.0 - 2.0 * half_side * half_side, 4.0 * half_side * half_side, 4.0 * half_side * half_side, 0.0),
            Vec4::new(-4.0 * half_side * half_side, 0.0, -4.0 * half_side * half_side, 0.0),
        ],
        depth_row: forward.extend(DISTANCE_RADII),
        nearest_point: -forward,
        axis_ratios: axis_ratios(key),
        // The same view for a mesh: x (towards the viewer) becomes depth, y points right and z up.
        clip_from_unit_sphere: Mat4::from_cols(
            Vec4::new(0.0, 0.0, 0.25, 0.0),
            Vec4::new(1.0 / half_side, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / half_side, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 0.5, 1.0),
        ),
        albedo: Vec3::new(0.6, 0.5, 0.4),
        air: air_uniforms(),
        eclipse: eclipse_uniforms(key),
        lights: lights
            .map(|(v, irradiance)| Light { direction_in_body: v.normalize_or_zero(), irradiance: Vec3::splat(irradiance) })
            .collect(),
        photometric_parameter: 0.1,
        limb_darkening_u1: Vec3::splat(0.4),
        limb_darkening_u2: Vec3::splat(0.2),
        averaged_part: 1.0,
        map_stretch: Vec2::ONE,
        // So wide that no map counts as magnified: a magnified map would be smoothed, and in most views none is magnified.
        map_pixel: 1.0,
        camera_height: 1.0,
        night_radiance: Vec3::splat(0.2),
        specular_strength: 1.0,
        wave_slope_sq: 0.03,
        normal_strength: 1.0,
        clouds: CloudUniforms {
            clear_texel: 0.1,
            closed_texel: 0.9,
            radius: 1.01,
            albedo: 0.7,
            reflectance: 0.7,
            // Half of the air is above the clouds.
            optical_depth_above: air_uniforms().optical_depth_above_ground.map(|row| (0.5 * row.truncate()).extend(row.w)),
            coarse_first_row: 0.0,
        },
        camera_in_unit_sphere: forward * -DISTANCE_RADII,
        overlays: overlay_uniforms(key),
        ring: ring_uniforms(key.features().surface),
        // As seen along the negative x axis: north is up, celestial east to the left. -1: no body in front of the Sun has a limb profile.
        limb: LimbUniforms { position_angle_axes: [up.extend(1.0 / half_side), Vec3::NEG_Y.extend(-1.0)], table: None },
        ..DrawUniforms::default()
    }
}

/// Overlays on the visible side: an equirectangular image, and an orthographic one within it. Their rows are those of shaders/lib/overlay.wesl.
fn overlay_uniforms(key: &ShaderKey) -> Vec<OverlayUniforms> {
    let row = |x: f32, y: f32, z: f32, w: f32| Vec4::new(x, y, z, w);
    let tint_and_opacity = row(0.5, 0.6, 0.7, 0.8);
    // First and last u, first and last v.
    let bounds = row(0.0, 1.0, 0.0, 1.0);
    // Three axes, each with a ratio of the body's semi-axes; image widths and heights per radian, central latitude in radians, 0 for the projection.
    let equirectangular =
        [row(1.0, 0.0, 0.0, 1.0), row(0.0, 1.0, 0.0, 1.0), row(0.0, 0.0, 1.0, 1.0), row(0.6, 1.1, 0.2, 0.0), bounds, tint_and_opacity];
    // Three axes, each with a ratio of the body's semi-axes; image widths and heights per radius, the centre's northing in radii, 1 for the projection.
    let orthographic =
        [row(0.0, 1.0, 0.0, 1.0), row(0.0, 0.0, 1.0, 1.0), row(1.0, 0.0, 0.0, 1.0), row(1.2, 1.3, 0.1, 1.0), bounds, tint_and_opacity];
    [equirectangular, orthographic]
        .into_iter()
        .map(|rows| OverlayUniforms { rows, wraps_around: false })
        .take(usize::from(key.features().overlays))
        .collect()
}

/// A map that varies smoothly with u and v, so that filtering is visible rather than aliasing; as a normal map it tilts normals by some degrees.
fn sample_map(role: MapRole) -> Result<Texture, SessionError> {
    let (width, height) = (64u32, 32u32);
    let wave = |k: u32, count: u32, turns: f64| (f64::from(k) / f64::from(count) * std::f64::consts::TAU * turns).sin();
    let byte = |x: f64| (127.5 + 127.5 * x).round().clamp(0.0, 255.0) as u8;
    let mut rgba = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (a, b) = (wave(x, width, 2.0), wave(y, height, 1.5));
            rgba.extend(if role == MapRole::Normal {
                [byte(0.2 * a), byte(0.2 * b), 250, 255]
            } else {
                [byte(0.8 * a), byte(0.8 * b), byte(a * b), 200]
            });
        }
    }
    Texture::from_rgba8(width, height, rgba, map_format(role)).map_err(|e| PlanError::Module(e.to_string()).into())
}

/// The sphere as triangles with position, normal, map coordinates, altitude of the Sun and colour; vertices are duplicated along the seam.
fn sphere_mesh(vertex_colour: bool) -> Vertices {
    let (columns, rows) = MESH_SIZE;
    let (mut position, mut normal, mut map_coordinates, mut colour, mut indices) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut sun_altitude = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
            let (longitude, latitude) = ((u - 0.5) * std::f32::consts::TAU, (0.5 - v) * std::f32::consts::PI);
            let point = [latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin()];
            position.extend(point);
            normal.extend(point);
            map_coordinates.extend([u, v]);
            // Altitude of the Sun above the mesh's own horizon, in radii of the Sun, as if a ridge cast a shadow over the western side.
            sun_altitude.push(30.0 * point[1] + 10.0);
            colour.extend([u, v, 0.5, 1.0]);
            if column < columns && row < rows {
                let vertex = row * (columns + 1) + column;
                let vertex_below = vertex + columns + 1;
                indices.extend([vertex, vertex_below, vertex + 1, vertex + 1, vertex_below, vertex_below + 1]);
            }
        }
    }
    let attribute = |components: u32, values: Vec<f32>| Attribute { components, values: Arc::new(values) };
    let mut attributes = vec![attribute(3, position), attribute(3, normal), attribute(2, map_coordinates), attribute(1, sun_altitude)];
    if vertex_colour {
        attributes.push(attribute(4, colour));
    }
    Vertices::Mesh { attributes, indices: Arc::new(indices) }
}

/// A plan that draws the sample body with a key's module into a square HDR image. `half_side`: half its side in body radii.
///
/// # Errors
/// The module cannot be compiled, or has a uniform for which the sample has no value.
pub fn sample_body_plan(library: &ShaderLibrary, key: &ShaderKey, side_px: u32, half_side: f32) -> Result<Plan, SessionError> {
    let module = library.get(&ModuleId::Keyed(*key)).map_err(|e| SessionError::Plan(PlanError::Module(e.to_string())))?;
    sample_body_plan_of(&module, key, side_px, half_side)
}

/// A coarse image of the air without marked texels, so that each pixel evaluates its own air. If the ground's draw also shades clouds, the left half is
/// marked, so that the draws of ground and clouds each shade a part of the clouds.
fn coarse_air(side_px: u32, air_pass: AirPass) -> SharedTexture {
    let [width, height] = coarse_air_subimage_size([side_px, side_px]);
    let is_marked = |column: u32| air_pass == AirPass::ReadWithClouds && column < width / 2;
    let texel = |column| if is_marked(column) { [0.3_f32, 0.4, 0.5, 1.0] } else { [0.0; 4] };
    let bytes = (0..width * height).flat_map(|k| texel(k % width)).flat_map(f32::to_le_bytes).collect();
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![Level::new(width, height, bytes)] })
}

/// As [`sample_body_plan`], but with a given module of the key instead of the library's.
///
/// # Errors
/// The module has a uniform for which the sample has no value, or a texture that is not a map of a body.
pub fn sample_body_plan_of(module: &ShaderModule, key: &ShaderKey, side_px: u32, half_side: f32) -> Result<Plan, SessionError> {
    let plan_error = |e: String| SessionError::Plan(PlanError::Module(e));
    let id = ModuleId::Keyed(*key);
    let uniforms = draw_uniforms(key, half_side);
    let uniform_bytes = uniform_bytes(&module.layout, &uniforms, MAP_TAPS).map_err(|e| plan_error(format!("{id}: {e}")))?;
    let sampler_state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    let mut textures = Vec::new();
    for t in &module.layout.textures {
        let image = match (t.name.as_str(), &uniforms.ring.table) {
            (RING_PROFILE, Some(table)) => ring_profile(table),
            (RING_SHINE, _) => ring_shine(&sample_ring_shine()),
            (RING_SHADOW_GRID, _) => ring_shadow_grid(&sample_shadow_grid()),
            (LIMB_TABLE, _) => limb_table(&sample_limb()),
            (COARSE_AIR_TEXTURE, _) => coarse_air(side_px, key.features().air_pass),
            (name, _) => Arc::new(sample_map(role_of(name).ok_or_else(|| plan_error(format!("{id}: `{name}` is not a map of a body")))?)?),
        };
        textures.push(TextureBinding { binding: t.binding, source: TextureSource::Image(image) });
    }
    let features = key.features();
    let draw = PlanDraw {
        label: id.to_string(),
        module: id,
        uniform_bytes,
        textures,
        samplers: module.layout.samplers.iter().map(|s| SamplerBinding { binding: s.binding, state: sampler_state }).collect(),
        vertices: if features.shape == Shape::Mesh { sphere_mesh(features.flags.vertex_colour) } else { Vertices::Count(6) },
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        // The draws that fill the coarse image write no depth.
        depth: if features.air_pass.fills_image() {
            DepthState { test: false, write: false }
        } else {
            DepthState { test: true, write: true }
        },
        scissor: [0, 0, side_px, side_px],
        extent: None,
    };
    let pass = Pass {
        name: "sample",
        width: side_px,
        height: side_px,
        format: ColourFormat::Hdr,
        samples: 1,
        clear: [0.0; 4],
        has_depth: true,
        draws: vec![draw],
    };
    Ok(Plan { passes: vec![pass] })
}

/// Elapsed milliseconds for a million pixels that all lie on the sample body, from the fastest of several runs. `None` for a module that draws no body,
/// and for a mesh, whose time depends on its number of triangles.
///
/// # Errors
/// The module cannot be compiled or run.
pub fn ms_per_megapixel(renderer: &SoftwareRenderer, library: &ShaderLibrary, id: &ModuleId) -> Result<Option<f64>, SessionError> {
    ms_per_megapixel_at(renderer, library, id, TIMED_SIDE_PX)
}

/// As [`ms_per_megapixel`], but timed with an image of another size, for a quick estimate.
///
/// # Errors
/// The module cannot be compiled or run.
pub fn ms_per_megapixel_at(
    renderer: &SoftwareRenderer,
    library: &ShaderLibrary,
    id: &ModuleId,
    side_px: u32,
) -> Result<Option<f64>, SessionError> {
    let ModuleId::Keyed(key) = id else { return Ok(None) };
    if key.features().shape == Shape::Mesh {
        return Ok(None);
    }
    let plan = sample_body_plan(library, key, side_px, SAMPLE_HALF_SIDE_ON_DISC)?;
    let mut fastest_ms = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        renderer.render(&plan, library, FrameImages::Display)?;
        fastest_ms = fastest_ms.min(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(Some(fastest_ms * 1e6 / (f64::from(side_px) * f64::from(side_px))))
}
