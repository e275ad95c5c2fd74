//! The HDR pass and its tone map, fused tile by tile, against two separate passes: every byte of the display image is the same.

use super::frame::{pass, scene, sphere, tone_map, with_threads};
use super::lower::compile;
use glam::Vec3;
use orrery::FrameImages;
use orrery::render::plan::{Blend, ColourFormat, Plan};
use orrery::render::software::{Options, Precision, SoftwareRenderer, lowering};
use orrery::scene::draw::MapSet;
use orrery::shader::ShaderLibrary;
use orrery::shader::fragments::Fragments;

/// The shipped tone map.
const TONE_MAP: &str = include_str!("../../shaders/entry/tone_map.wesl");

/// A library whose tone map has `to` in place of `from`.
fn with_tone_map(from: &str, to: &str) -> ShaderLibrary {
    assert!(TONE_MAP.contains(from));
    let library = ShaderLibrary::in_memory(lowering());
    library.set_fragments(Fragments::with_files([("entry/tone_map.wesl".to_owned(), TONE_MAP.replace(from, to))]));
    library
}

/// The display bytes of a plan drawn in two passes, because the HDR image is kept, and in fused passes.
fn separate_and_fused(plan: &Plan, library: &ShaderLibrary, options: Options) -> [Vec<[u8; 4]>; 2] {
    let renderer = SoftwareRenderer::new(options).expect("a renderer");
    [FrameImages::DisplayAndHdr, FrameImages::Display].map(|images| {
        let (frame, timings) = renderer.render(plan, library, images).expect("a frame");
        assert_eq!(frame.hdr.is_empty(), images == FrameImages::Display);
        assert_eq!(timings.passes.len(), plan.passes.len());
        frame.display
    })
}

/// A sphere whose limb crosses tiles, on a background that is not black.
fn lit_sphere(size: [u32; 2]) -> Plan {
    let mut plan = scene(size, vec![sphere(Vec3::new(1.0, 0.3, 0.2), MapSet::default())]);
    plan.passes[0].clear = [0.02, 0.5, 0.0, 1.0];
    plan
}

#[test]
fn fused_passes_give_the_bytes_of_separate_ones() {
    let library = ShaderLibrary::in_memory(lowering());
    for size in [[150, 130], [64, 64], [1, 1], [333, 70], [17, 200]] {
        for samples in [1, 4] {
            let mut plan = lit_sphere(size);
            plan.passes[0].samples = samples;
            for threads in [1, 2, 5] {
                let [separate, fused] = separate_and_fused(&plan, &library, with_threads(threads));
                assert!(separate == fused, "{size:?}, {samples} samples, {threads} threads");
            }
        }
    }
    let [separate, fused] =
        separate_and_fused(&lit_sphere([150, 130]), &library, Options { precision: Precision::F64, ..Options::default() });
    assert!(separate == fused, "in f64");
    let [_, empty] = separate_and_fused(&scene([150, 130], Vec::new()), &library, with_threads(1));
    assert!(empty.iter().all(|p| *p == [0, 0, 0, 255]), "an empty sky must be black");
}

#[test]
fn tiles_without_draws_equal_shaded_ones() {
    let library = ShaderLibrary::in_memory(lowering());
    for clear in [[0.0, 0.0, 0.0, 1.0], [0.02, 0.5, 1e-4, 1.0], [3.0, 0.1, 40.0, 1.0]] {
        let mut plan = scene([150, 130], Vec::new());
        plan.passes[0].clear = clear;
        // As a separate pass, the tone map shades every pixel.
        let [shaded, filled] = separate_and_fused(&plan, &library, with_threads(2));
        assert!(shaded == filled && filled.iter().all(|p| *p == filled[0]), "{clear:?}");
    }
}

/// The largest difference between two images in levels of 255, and the fraction of pixels that differ.
fn difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> (u8, f64) {
    let of_pixel = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
    let all: Vec<u8> = a.iter().zip(b).map(of_pixel).collect();
    (all.iter().copied().max().unwrap_or(0), all.iter().filter(|d| **d > 0).count() as f64 / all.len() as f64)
}

#[test]
fn the_native_tone_map_is_within_a_level_of_its_tape() {
    let exposed = "radiance * draw.exposure";
    let shipped = ShaderLibrary::in_memory(lowering());
    // Another text with the same values is not recognised as the shipped tone map, so it runs on the tape.
    let equivalent = with_tone_map(exposed, "radiance * (draw.exposure * 1.0)");
    let brighter = with_tone_map(exposed, "radiance * (draw.exposure * 1.02)");
    let mut plan = lit_sphere([333, 200]);
    plan.passes[0].samples = 4;
    let [_, image] = separate_and_fused(&plan, &shipped, with_threads(2));
    let [(equivalent_levels, equivalent_fraction), (brighter_levels, _)] = [equivalent, brighter].map(|library| {
        let [_, other] = separate_and_fused(&plan, &library, with_threads(2));
        difference(&image, &other)
    });
    // A value within a thousandth of a level of a rounding boundary may be rounded the other way: 0.002 of the values in each of three channels.
    assert!(equivalent_levels <= 1 && equivalent_fraction < 0.006, "{equivalent_levels} levels, {equivalent_fraction} of the pixels");
    assert!(brighter_levels > 1, "a brighter image must be detected, not one of {brighter_levels} levels");
}

#[test]
fn draws_after_the_tone_map_are_kept() {
    let library = ShaderLibrary::in_memory(lowering());
    let mut plan = lit_sphere([150, 130]);
    let mut top = sphere(Vec3::X, MapSet::default());
    (top.scissor, top.blend) = ([70, 3, 140, 90], Blend::PremultipliedOver);
    top.depth = tone_map(0).depth;
    plan.passes[1].draws.push(top);
    let [separate, fused] = separate_and_fused(&plan, &library, with_threads(2));
    assert!(separate == fused);
    let [_, without] = separate_and_fused(&lit_sphere([150, 130]), &library, with_threads(2));
    assert!(fused != without, "the draw on top must be visible");
}

#[test]
fn a_tone_map_that_reads_more_than_the_light_of_its_pixel_gives_the_same_bytes() {
    let own_pixel = "vec2i(floor(position.xy))";
    for (from, to) in [
        (own_pixel, "vec2i(floor(position.xy)) + vec2i(1, 0)"),
        (own_pixel, "vec2i(floor(position.yx))"),
        (own_pixel, "vec2i(70, 9)"),
        ("radiance * draw.exposure", "radiance * position.x * 0.01"),
        ("radiance * draw.exposure", "radiance * f32(textureDimensions(hdr).x) * 0.01"),
    ] {
        let library = with_tone_map(from, to);
        let [separate, fused] = separate_and_fused(&lit_sphere([150, 130]), &library, with_threads(2));
        assert!(separate == fused, "{to}");
        let [as_shipped, _] = separate_and_fused(&lit_sphere([150, 130]), &ShaderLibrary::in_memory(lowering()), with_threads(2));
        assert!(separate != as_shipped, "{to} changes nothing");
    }
}

#[test]
fn an_hdr_image_that_two_passes_read_is_stored() {
    let library = ShaderLibrary::in_memory(lowering());
    let mut plan = lit_sphere([150, 130]);
    // The second tone map needs the light of the first HDR pass.
    plan.passes.push(pass("again", [150, 130], ColourFormat::Rgba8Unorm, 1, [0.0; 4], vec![tone_map(0)]));
    let [separate, fused] = separate_and_fused(&plan, &library, with_threads(2));
    assert!(separate == fused && separate.iter().any(|p| p[0] > 100));
}

#[test]
fn programs_that_depend_on_the_pixel_position_are_detected() {
    let fragment = |body: &str| {
        compile(&format!(
            "@group(0) @binding(1) var light: texture_2d<f32>;
            @fragment fn main(@builtin(position) p: vec4f) -> @location(0) vec4f {{ {body} }}"
        ))
    };
    for independent in [
        "return textureLoad(light, vec2i(floor(p.xy)), 0);",
        "return vec4f(1.0);",
        "let c = textureLoad(light, vec2i(p.xy) + vec2i(1, 2), 0); if c.x > 0.5 { return sqrt(c); } return c * c;",
    ] {
        assert!(fragment(independent).is_position_independent(), "{independent}");
    }
    for dependent in [
        "return textureLoad(light, vec2i(floor(p.xy)), 0) + p.x;",
        "return p;",
        "if p.x > 5.0 { return vec4f(0.0); } return vec4f(1.0);",
        "let c = textureLoad(light, vec2i(p.xy), 0); if c.x > 0.5 { return sqrt(c) * p.y; } return c;",
        "return textureLoad(light, vec2i(p.xy), i32(p.x));",
        "var sum = vec4f(0.0); for (var i = 0; i < i32(p.x); i++) { sum += textureLoad(light, vec2i(i, 0), 0); } return sum;",
        "let c = textureLoad(light, vec2i(p.xy), 0); return dpdx(c);",
    ] {
        assert!(!fragment(dependent).is_position_independent(), "{dependent}");
    }
}
