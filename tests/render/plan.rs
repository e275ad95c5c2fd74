//! The plan fills every uniform that the modules read: for each set of features that a scene can choose, every field of the uniform block
//! gets a value.

use crate::support::session::SESSION;
use glam::{Vec2, Vec3, Vec4};
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId};
use orrery::render::plan::{ColourFormat, Plan, SamplingQuality, uniform_bytes};
use orrery::scene::constants::OPTICAL_DEPTH_TERMS;
use orrery::scene::draw::{AtmosphereUniforms, CloudUniforms, DrawFeatures, DrawUniforms, EclipseUniforms, Light, RingUniforms};
use orrery::scene::effects::{EffectOverrides, possible_features};
use orrery::scene::multi_scatter_in_shadow;
use orrery::scene::multi_scatter_table::NODES;
use orrery::scene::request::{Composition, ExposureRequest, Position, Projection, Quality, ViewRequest};
use orrery::shader::emit::emit_fragment;
use orrery::shader::fragments::Fragments;
use orrery::shader::key::{ShaderKey, feature_names, keys_of};
use orrery::shader::reflect::LayoutError;
use orrery::shader::{Layout, Lowering, ModuleId, ShaderModule};
use orrery::time::Instant;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Uniforms with the given number of lights. Most fields have a distinct value, by which a test recognises them.
fn uniforms(lights: u8) -> DrawUniforms {
    let light = |k: f32| Light { direction_in_body: Vec3::new(k, k + 0.1, k + 0.2), irradiance: Vec3::splat(k + 0.5) };
    DrawUniforms {
        rect_in_clip: Vec4::new(1.0, 2.0, 3.0, 4.0),
        anchor_origin: Vec3::splat(5.0),
        anchor_du: Vec3::splat(6.0),
        anchor_dv: Vec3::splat(7.0),
        ray_origin: Vec3::splat(8.0),
        ray_du: Vec3::splat(9.0),
        ray_dv: Vec3::splat(10.0),
        anchor_radius_sq_minus_1: 11.0,
        anchor_is_camera: 1.0,
        silhouette_form: [Vec4::splat(32.0), Vec4::splat(33.0)],
        depth_row: Vec4::splat(12.0),
        nearest_point: Vec3::splat(54.0),
        axis_ratios: Vec3::splat(13.0),
        albedo: Vec3::new(14.0, 15.0, 16.0),
        lights: (0..lights).map(|k| light(100.0 + f32::from(k))).collect(),
        photometric_parameter: 17.0,
        averaged_part: 64.0,
        limb_darkening_u1: Vec3::splat(18.0),
        limb_darkening_u2: Vec3::splat(19.0),
        map_stretch: Vec2::splat(20.0),
        map_pixel: 34.0,
        camera_height: 35.0,
        detail: Default::default(),
        night_radiance: Vec3::splat(21.0),
        specular_strength: 22.0,
        wave_slope_sq: 23.0,
        normal_strength: 24.0,
        camera_in_unit_sphere: Vec3::splat(25.0),
        pixel_size: Vec2::splat(26.0),
        clip_from_unit_sphere: glam::Mat4::from_cols_array(&[31.0; 16]),
        mesh_anchor: Vec3::splat(46.0),
        mesh: None,
        foreground_limbs: Default::default(),
        limb: Default::default(),
        overlays: Vec::new(),
        clouds: CloudUniforms {
            clear_texel: 27.0,
            closed_texel: 28.0,
            radius: 29.0,
            albedo: 30.0,
            reflectance: 50.0,
            optical_depth_above: [Vec4::splat(51.0); OPTICAL_DEPTH_TERMS],
            coarse_first_row: 4.0,
        },
        eclipse: Default::default(),
        ring: RingUniforms::default(),
        air: AtmosphereUniforms {
            max_coarse_error: Vec2::ZERO,
            coarse_first_row: 3.0,
            end_heights: Vec2::new(0.1, 0.0),
            top_radius_sq_minus_1: 32.0,
            rayleigh_scale_height: 33.0,
            rayleigh_scattering: Vec3::splat(34.0),
            rayleigh_extinction: Vec3::splat(35.0),
            skylight_fraction: Vec3::splat(36.0),
            mie_scale_height: 37.0,
            mie_phase_parameters: Vec4::splat(38.0),
            mie_scattering: Vec3::splat(39.0),
            mie_extinction: Vec3::splat(40.0),
            absorption_layer: Vec3::splat(41.0),
            absorption_extinction: Vec3::splat(42.0),
            optical_depth_above_ground: [Vec4::splat(52.0); OPTICAL_DEPTH_TERMS],
            blend_mode: 45.0,
            map_weight: 53.0,
            night_radiance: 47.0,
            light_from_beyond: 65.0,
            second_light_irradiance: Vec3::splat(55.0),
            rim_is_thin: 49.0,
            multi_scatter_heights: Vec2::splat(43.0),
            multi_scatter: std::sync::Arc::new(vec![Vec4::splat(44.0); NODES]),
        },
    }
}

fn layout(features: &DrawFeatures) -> Layout {
    let id = ModuleId::Keyed(ShaderKey::for_draw(features));
    ShaderModule::build(&id, &Lowering::without_tape()).expect("the module builds").layout
}

fn number(bytes: &[u8], offset: u32) -> f32 {
    let start = offset as usize;
    f32::from_le_bytes(bytes[start..start + 4].try_into().expect("four bytes"))
}

#[test]
fn the_uniforms_of_every_key_are_filled_by_name() {
    let all = possible_features(&Catalog::embedded());
    // One set of features per key: the canonical form must not hide a missing uniform.
    let keys = keys_of(all.iter().copied());
    let fill_error = |layout: &Layout, key: &ShaderKey| {
        let features = *key.features();
        let occluders = vec![Vec4::ZERO; usize::from(features.eclipse.occluders)];
        let layers = vec![Vec4::ZERO; 32];
        let multi_scatter = vec![Vec4::splat(48.0); multi_scatter_in_shadow::VECTORS];
        let eclipse = EclipseUniforms {
            occluder_positions: occluders.clone(),
            occluder_outlines: occluders,
            air_edges: layers.clone(),
            air_transmittance: layers,
            multi_scatter,
            ..EclipseUniforms::default()
        };
        match uniform_bytes(layout, &DrawUniforms { eclipse, ..uniforms(features.lights) }, 1) {
            Ok(bytes) if bytes.is_empty() => Some(format!("{key}: nothing to fill")),
            Ok(_) => None,
            Err(e) => Some(format!("{key}: {e}")),
        }
    };
    // A single self-contained fragment declares the block. Keys for which it emits the same text have the same layout, so one key
    // represents them all.
    let block = |key: &ShaderKey| emit_fragment("lib/draw.wesl", "planet", &feature_names(key.features())).expect("emits").wgsl;
    let blocks: BTreeMap<String, ShaderKey> = keys.par_iter().map(|key| (block(key), *key)).collect();
    let layout_of_block = |text: &String| Layout::of(&naga::front::wgsl::parse_str(text).expect("a block")).expect("a layout");
    let failures: Vec<String> = blocks.par_iter().filter_map(|(text, key)| fill_error(&layout_of_block(text), key)).collect();
    // In complete modules the blocks have the same layouts.
    let sampled_blocks: Vec<_> = blocks.iter().step_by(blocks.len().div_ceil(40)).collect();
    sampled_blocks.par_iter().for_each(|(text, key)| assert_eq!(layout(key.features()).fields, layout_of_block(text).fields, "{key}"));
    println!("{} sets of features, {} keys, {} blocks", all.len(), keys.len(), blocks.len());
    assert!(keys.len() > 50 && blocks.len() > 20, "{} keys, {} blocks", keys.len(), blocks.len());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Whether any fragment declares a field of this name.
fn is_declared(name: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let fields =
        |line: &str| line.trim_end().ends_with(',') && line.split(|c| !is_name(c)).any(|word| word.strip_suffix(':') == Some(name));
    Fragments::default().all().any(|(_, text)| text.lines().any(fields))
}

/// The reverse: every value that is written has a field in some fragment.
#[test]
fn every_value_has_a_field() {
    let without: Vec<&str> = DrawUniforms::names().filter(|name| !is_declared(name)).collect();
    assert!(without.is_empty(), "no fragment declares {without:?}");
    assert!(DrawUniforms::names().count() > 50 && !is_declared("albedo_of_nothing") && !is_declared("rect_in"));
}

#[test]
fn values_are_written_to_their_fields() {
    let all = possible_features(&Catalog::embedded());
    let features = all
        .iter()
        .find(|f| f.lights == 2 && f.eclipse.occluders == 0 && f.maps.night && f.maps.specular)
        .expect("the Earth, lit by the Sun and the Moon");
    let layout = layout(features);
    let bytes = uniform_bytes(&layout, &uniforms(2), 1).expect("filled");
    let offset = |name: &str| layout.field(name).expect("a field").offset;
    assert_eq!(number(&bytes, offset("rect_in_clip") + 8), 3.0);
    assert_eq!(number(&bytes, offset("albedo") + 4), 15.0);
    assert_eq!(number(&bytes, offset("wave_slope_sq")), 23.0);
    assert_eq!(number(&bytes, offset("light_direction") + 16), 101.0);
    assert_eq!(number(&bytes, offset("light_irradiance") + 16), 101.5);
}

#[test]
fn a_wrong_number_of_lights_is_refused() {
    let all = possible_features(&Catalog::embedded());
    let features = all.iter().find(|f| f.lights == 2).expect("two lights");
    assert!(
        matches!(uniform_bytes(&layout(features), &uniforms(1), 1), Err(LayoutError::Mistyped { name, .. }) if name == "light_direction")
    );
}

/// The passes of the coarse image of the air come before the HDR pass, which reads it, so that the HDR pass is not always the first.
#[test]
fn the_hdr_pass_is_found_by_its_name() {
    let with_coarse_air = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(3.0) },
        quality: Quality::Draft,
        width: 512,
        height: 512,
        fov_deg: Some(45.0),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-06-08T18:17:16Z").expect("a time"))
    };
    let by_pixel = ViewRequest { may_use_coarse_air: false, ..with_coarse_air.clone() };
    for (request, is_first) in [(with_coarse_air, false), (by_pixel, true)] {
        let (_, plan) = SESSION.plan(&request, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
        let hdr = plan.hdr_pass().expect("an HDR pass");
        assert!(hdr.name == "light" && hdr.draws.iter().any(|d| d.label == "Earth"));
        assert_eq!(plan.passes[0].name == hdr.name, is_first);
    }
}

/// Half floats hold radiances from 6e-8 to 65,504: at exposures for which a radiance that matters may be beyond these, the linear image has 32-bit floats.
#[test]
fn exposures_beyond_half_floats_have_32_bit_targets() {
    let format = |stops: f64| {
        let view = ViewRequest::of(NaifId::SUN, Instant::parse("2024-10-10T00:00:00Z").expect("a time"));
        let request = ViewRequest { width: 16, height: 16, exposure: ExposureRequest::Stops(stops), ..view };
        let (_, plan) = SESSION.plan(&request, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
        plan.hdr_pass().expect("an HDR pass").format
    };
    // White has the radiance 2^-stops, which lines and names reach. Automatic exposure of the Sun is -15.7 stops.
    for (stops, expected) in [
        (-20.0, ColourFormat::HdrF32),
        (-16.0, ColourFormat::HdrF32),
        (-15.7, ColourFormat::Hdr),
        (11.0, ColourFormat::Hdr),
        (12.0, ColourFormat::HdrF32),
    ] {
        assert_eq!(format(stops), expected, "{stops} stops");
    }
}

/// A frame's linear image is that of the HDR pass, even if an earlier pass has the same size: the samples of the air of one or two draws, or a face.
#[test]
fn the_linear_image_of_a_frame_is_that_of_its_hdr_pass() {
    let near_earth = |effects: &str| ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(3.0) },
        quality: Quality::Draft,
        fov_deg: Some(0.5),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-06-08T18:17:16Z").expect("a time"))
    };
    let of_size = |request: &ViewRequest, [width, height]: [u32; 2]| ViewRequest { width, height, ..request.clone() };
    let [with_clouds, without_clouds] = ["+clouds", "-clouds"].map(near_earth);
    let composition = Composition { projection: Projection::Equirectangular, ..Composition::default() };
    let sphere = ViewRequest { fov_deg: None, composition, ..without_clouds.clone() };
    let small_sizes = (4..=5).flat_map(|width| (3..=13).map(move |height| [width, height]));
    let plane = small_sizes.flat_map(|size| [of_size(&with_clouds, size), of_size(&without_clouds, size)]);
    let requests: Vec<ViewRequest> = plane.chain((18..=22).map(|side| of_size(&sphere, [side, side]))).collect();
    let mut equal_sizes = [0, 0];
    for request in requests {
        let (_, plan) = SESSION.plan(&request, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
        let linear = |plan: &Plan| SESSION.renderer().render(plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
        let hdr_pass = plan.passes.iter().rposition(|pass| pass.name == "light").expect("an HDR pass");
        // Without the later passes the last image is the linear one.
        let hdr_only = Plan { passes: plan.passes[..=hdr_pass].to_vec() };
        let is_plane = request.composition == Composition::default();
        assert!(linear(&plan) == linear(&hdr_only), "{}x{}, plane: {is_plane}", request.width, request.height);
        let has_its_size = plan.passes[..hdr_pass].iter().any(|pass| [pass.width, pass.height] == [request.width, request.height]);
        equal_sizes[usize::from(is_plane)] += usize::from(has_its_size);
    }
    assert!(equal_sizes.iter().all(|count| *count > 0), "{equal_sizes:?}");
}
