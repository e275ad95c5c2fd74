//! Smooth light is shaded at every fourth pixel and interpolated between.

use super::frame::with_threads;
use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{Plan, SamplingQuality, ShadingRate};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::request::{Axes, Layers, Look, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;
use orrery::{Frame, FrameImages};

/// The Sun from a distance in solar radii, with its glare and, in front of it, the orbits of the planets. From 12,000 radii the glare covers every pixel.
fn request(size: [u32; 2], distance_radii: f64) -> ViewRequest {
    ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
        fov_deg: Some(60.0),
        width: size[0],
        height: size[1],
        layers: Layers { orbits: true, ..Layers::default() },
        ..ViewRequest::of(NaifId::SUN, Instant::parse("2024-06-08T00:00:00Z").expect("a time"))
    }
}

/// The Sun's limb through the middle of the image, where the glare is smooth even in a small image: the disc is 6000 pixels wide.
fn limb_request(size: [u32; 2]) -> ViewRequest {
    let distance_radii = 30.0;
    let view = request(size, distance_radii);
    let to_sun = SESSION.scene(&view).expect("a scene").body(NaifId::SUN).expect("the Sun").placement.centre_km.normalize();
    let sin_radius = 1.0 / distance_radii;
    let direction = to_sun * (1.0 - sin_radius * sin_radius).sqrt() + to_sun.any_orthonormal_vector() * sin_radius;
    let pixel_deg = sin_radius.asin().to_degrees() / 3000.0;
    ViewRequest { look: Look::Along { direction, axes: Axes::Icrf }, fov_deg: Some(pixel_deg * f64::from(size[1])), ..view }
}

fn plan(request: &ViewRequest, samples: u8) -> Plan {
    SESSION.plan(request, SamplingQuality { samples, anisotropy: 1 }).expect("a plan").1
}

fn draw(plan: &Plan, options: Options) -> Frame {
    let renderer = SoftwareRenderer::new(options).expect("a renderer");
    renderer.render(plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("a frame").0
}

fn shaded_per_pixel(mut plan: Plan) -> Plan {
    let draws = plan.passes.iter_mut().flat_map(|pass| &mut pass.draws);
    draws.for_each(|draw| draw.shading_rate = ShadingRate::PerPixel);
    plan
}

fn has_interpolated_draws(plan: &Plan) -> bool {
    plan.passes.iter().flat_map(|pass| &pass.draws).any(|draw| draw.shading_rate == ShadingRate::Interpolated)
}

/// The share of pixels whose light differs at all, the greatest relative difference of light, and the greatest difference of display levels.
fn difference(a: &Frame, b: &Frame) -> (f64, f64, u8) {
    // `max` would ignore NaN.
    assert!(a.hdr.iter().chain(&b.hdr).flatten().all(|v| v.is_finite()));
    let (mut differing, mut relative, mut levels) = (0, 0.0_f64, 0);
    for (pixel_a, pixel_b) in a.hdr.iter().zip(&b.hdr) {
        differing += usize::from(pixel_a != pixel_b);
        for (light_a, light_b) in pixel_a.iter().zip(pixel_b) {
            relative = relative.max(f64::from((light_a - light_b).abs()) / f64::from(light_b.abs()).max(1e-30));
        }
    }
    for (level_a, level_b) in a.display.iter().flatten().zip(b.display.iter().flatten()) {
        levels = levels.max(level_a.abs_diff(*level_b));
    }
    (differing as f64 / a.hdr.len() as f64, relative, levels)
}

/// Interpolated glare differs by at most a 500th from glare that is shaded per pixel, and by at most one display level, for images of any shape, one and
/// four samples. It is used for most of a large image, and nowhere in images so small that the glare in them is not smooth.
#[test]
fn interpolated_light_is_within_a_500th() {
    for (size, samples, min_differing_share) in
        [([1024, 1024], 1, 0.8), ([700, 500], 4, 0.5), ([64, 32], 1, 0.0), ([200, 33], 1, 0.0), ([63, 500], 4, 0.0), ([1, 1], 1, 0.0)]
    {
        let plan = plan(&request(size, 12_000.0), samples);
        assert!(has_interpolated_draws(&plan));
        let [interpolated, per_pixel] = [plan.clone(), shaded_per_pixel(plan)].map(|plan| draw(&plan, with_threads(2)));
        let (differing_share, relative, levels) = difference(&interpolated, &per_pixel);
        assert!(relative <= 1.0 / 500.0 && levels <= 1, "{size:?}: {relative}, {levels} levels");
        assert!(differing_share >= min_differing_share, "{size:?}: {differing_share} of the pixels are interpolated");
        assert!(min_differing_share > 0.0 || differing_share == 0.0, "{size:?}: {differing_share} of the pixels are interpolated");
        // The comparison must be able to fail: a tenth more than the bound.
        let mut brighter = per_pixel.clone();
        brighter.hdr.iter_mut().flatten().for_each(|v| *v *= 1.0 + 1.1 / 500.0);
        let (_, brighter_relative, _) = difference(&brighter, &per_pixel);
        assert!(brighter_relative > 1.0 / 500.0);
    }
}

/// At any distance from the Sun: in a frame that the disc fills, around a disc, with a glare that ends within the frame, and far away.
#[test]
fn the_bound_holds_from_the_disc_to_a_distant_sun() {
    for distance_radii in [1.5, 4.0, 30.0, 300.0, 3e3, 1e5, 2e6] {
        let plan = plan(&request([640, 512], distance_radii), 1);
        let [interpolated, per_pixel] = [plan.clone(), shaded_per_pixel(plan)].map(|plan| draw(&plan, with_threads(2)));
        let (differing_share, relative, levels) = difference(&interpolated, &per_pixel);
        assert!(relative <= 1.0 / 500.0 && levels <= 1, "{distance_radii} radii: {relative}, {levels} levels");
        // Here the glare covers the frame. It is smooth from 160 pixels around the Sun on, in about half of the tiles.
        let is_interpolated = [4.0, 1e5].contains(&distance_radii);
        assert!(!is_interpolated || differing_share > 0.3, "{distance_radii} radii: {differing_share} of the pixels are interpolated");
    }
}

#[test]
fn the_image_has_the_same_bits_for_any_number_of_threads() {
    let plan = plan(&request([500, 300], 12_000.0), 4);
    let frames = [1, 3].map(|threads| draw(&plan, with_threads(threads)));
    assert!(frames[0].hdr == frames[1].hdr && frames[0].display == frames[1].display);
}

/// What is measured is shaded at every pixel: linear light, reference quality, and double precision.
#[test]
fn measured_light_is_not_interpolated() {
    let view = request([128, 64], 12_000.0);
    assert!(!has_interpolated_draws(&plan(&ViewRequest { purpose: Purpose::LINEAR, ..view.clone() }, 1)));
    assert!(!has_interpolated_draws(&plan(&ViewRequest { quality: Quality::Reference, ..view.clone() }, 1)));
    // Light that is smooth, so that it is interpolated in single precision.
    let plan = plan(&limb_request([128, 64]), 1);
    for (precision, is_interpolated) in [(Precision::F64, false), (Precision::F32, true)] {
        let options = Options { precision, ..with_threads(2) };
        let frames = [plan.clone(), shaded_per_pixel(plan.clone())].map(|plan| draw(&plan, options));
        assert_eq!(frames[0].hdr != frames[1].hdr, is_interpolated, "{precision:?}");
    }
}
