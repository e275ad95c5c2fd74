//! Coverage, clipping, interpolation, depth, anti-aliasing and blending of the software rasteriser, with vertex and fragment stages written in Rust.

use crate::support::folds::larger;
use crate::support::hand_shader::{HandShader, LaneFunction, colour_outputs, draw, fragment, location, mesh, pass, pass_through, render};
use orrery::render::plan::{Blend, Cull, DepthState, Pass};
use orrery::render::software::math::Real;
use orrery::render::software::program::{LaneInput, LaneOutput};

const DEPTH: DepthState = DepthState { test: true, write: true };

/// Pseudo-random numbers from 0 to 1, the same on every run (a linear congruential generator with the constants of Knuth's MMIX).
fn random(seed: &mut u64) -> f32 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 40) as f32 / (1u64 << 24) as f32
}

/// The clip coordinates of a point of a square image, given in pixels (y down), with depth 0.5 and w = 1.
fn clip_at(x: f32, y: f32, side_px: f32) -> [f32; 4] {
    [2.0 * x / side_px - 1.0, 1.0 - 2.0 * y / side_px, 0.5, 1.0]
}

fn one_colour(colour: [f32; 4]) -> impl Fn(&[f32]) -> Option<Vec<f32>> + Sync {
    move |_| Some(colour.to_vec())
}

/// Draws triangles that each add one, and returns the red channel: the number of triangles that cover each pixel, as a mean over its samples.
fn count_covered(vertices: &[[f32; 4]], width: u32, height: u32, samples: u8) -> Vec<f32> {
    let pass = pass(width, height, samples, vec![draw(mesh(vertices, &[]), Blend::Add)]);
    let add_one = one_colour([1.0; 4]);
    render(&pass, &[(&pass_through::<f32>(0), &fragment(vec![], &add_one))]).iter().map(|p| p[0]).collect()
}

#[test]
fn a_fan_covers_every_sample_exactly_once() {
    // Fans of 7 triangles around random centres, with corners on multiples of a pixel, on multiples of half a pixel, and anywhere.
    let mut seed = 7;
    for samples in [1, 4] {
        for round in 0..30 {
            let grid_px = [Some(1.0_f32), Some(0.5), None][round % 3];
            let mut coordinate = |lo: f32, hi: f32| {
                let v = lo + (hi - lo) * random(&mut seed);
                grid_px.map_or(v, |spacing| (v / spacing).round() * spacing)
            };
            let (w, h) = (101.0, 101.0);
            let centre = clip_at(coordinate(1.0, w - 1.0), coordinate(1.0, h - 1.0), w);
            let (x, y) = (coordinate(0.0, w), coordinate(0.0, h));
            // Points along the border of the image, in order; each triangle joins two neighbours to the centre.
            let rim: Vec<_> =
                [(0.0, 0.0), (x, 0.0), (w, 0.0), (w, y), (w, h), (x / 2.0, h), (0.0, h)].map(|(x, y)| clip_at(x, y, w)).to_vec();
            let fan: Vec<_> = (0..7).flat_map(|k| [centre, rim[k], rim[(k + 1) % 7]]).collect();
            let counts = count_covered(&fan, 101, 101, samples);
            let wrong_pixels = counts.iter().filter(|c| **c != 1.0).count();
            assert_eq!(wrong_pixels, 0, "round {round}, {samples} samples: {wrong_pixels} pixels are not covered exactly once");
        }
    }
}

#[test]
fn a_gap_between_triangles_changes_the_count() {
    // The two triangles would cover the image if the last corner were at x = 0.
    let counts = count_covered(
        &[
            clip_at(0.0, 0.0, 64.0),
            clip_at(64.0, 0.0, 64.0),
            clip_at(0.0, 64.0, 64.0),
            clip_at(64.0, 0.0, 64.0),
            clip_at(64.0, 64.0, 64.0),
            clip_at(2.0, 64.0, 64.0),
        ],
        64,
        64,
        1,
    );
    assert!(counts.contains(&0.0));
}

#[test]
fn coverage_is_close_to_the_area_beside_an_edge() {
    // A half plane at many slopes; the covered fraction of each pixel against its area, counted with 64 x 64 points.
    let mut worst_mean: f64 = 0.0;
    for k in 0..24 {
        let angle = (k as f32 + 0.3) * std::f32::consts::TAU / 24.0;
        let (cos, sin) = (angle.cos(), angle.sin());
        let vertex = |u: f32, v: f32| clip_at(32.0 + u * cos - v * sin, 32.0 + u * sin + v * cos, 64.0);
        let counts = count_covered(&[vertex(0.2, -200.0), vertex(400.0, 0.0), vertex(0.2, 200.0)], 64, 64, 4);
        let (mut sum, mut edge_pixels) = (0.0, 0.0);
        for (i, covered) in counts.iter().enumerate() {
            let edge_distance = |x: f32, y: f32| (x - 32.0) * cos + (y - 32.0) * sin - 0.2;
            let (left, top) = ((i % 64) as f32, (i / 64) as f32);
            // No point of a pixel is farther from its centre than 0.71 pixels.
            let centre_distance = edge_distance(left + 0.5, top + 0.5);
            let inside = if centre_distance.abs() > 0.75 {
                if centre_distance > 0.0 { 4096 } else { 0 }
            } else {
                (0..4096)
                    .filter(|p| edge_distance(left + ((p % 64) as f32 + 0.5) / 64.0, top + ((p / 64) as f32 + 0.5) / 64.0) > 0.0)
                    .count()
            };
            let area = inside as f64 / 4096.0;
            // No pixel deviates by more than one and a half of its four samples.
            assert!((f64::from(*covered) - area).abs() <= 0.375, "pixel {i}: {covered} against {area}");
            if inside > 0 && inside < 4096 {
                sum += (f64::from(*covered) - area).abs();
                edge_pixels += 1.0;
            }
        }
        worst_mean = larger(worst_mean, sum / edge_pixels);
    }
    assert!(worst_mean < 0.125, "a mean deviation of {worst_mean}, more than half a sample");
}

#[test]
fn a_triangle_through_the_camera_plane_draws_only_what_is_in_front() {
    // A ground plane from behind the camera to far ahead: w = distance. Its horizon is the middle row of the image.
    let (near, far) = (-10.0_f32, 1.0e6_f32);
    let corner = |x: f32, distance: f32| [x, -1.0, 0.01, distance];
    let ground = [corner(-4.0e6, near), corner(4.0e6, near), corner(0.0, far)];
    let counts = count_covered(&ground, 64, 64, 1);
    for y in 0..64 {
        let row: f32 = counts[y * 64..(y + 1) * 64].iter().sum();
        assert_eq!(row, if y < 32 { 0.0 } else { 64.0 }, "row {y}");
    }
}

#[test]
fn huge_and_invalid_triangles_are_safe() {
    let big = 1.0e30;
    let counts = count_covered(&[[-big, -big, 0.5, 1.0], [big, -big, 0.5, 1.0], [0.0, big, 0.5, 1.0]], 64, 64, 1);
    assert!(counts.iter().all(|c| *c == 1.0));
    for bad in [f32::NAN, f32::INFINITY] {
        let counts = count_covered(&[[bad, -1.0, 0.5, 1.0], [1.0, -1.0, 0.5, 1.0], [0.0, 1.0, 0.5, 1.0]], 64, 64, 1);
        assert!(counts.iter().all(|c| *c == 0.0));
    }
    // Zero area.
    assert!(count_covered(&[clip_at(1.0, 1.0, 64.0); 3], 64, 64, 4).iter().all(|c| *c == 0.0));
}

/// Greatest error, in pixels, of interpolated ground coordinates against the analytic ray-plane intersection.
fn worst_ground_error<R: Real>() -> f64 {
    // Camera one unit above the plane y = -1, looking along +z, focal length 1: clip = (x, y, near, z).
    let corners = [[-50.0, 1.0], [50.0, 1.0], [50.0, 100.0], [-50.0, 100.0]];
    let order = [0, 1, 2, 0, 2, 3];
    let vertices: Vec<_> = order.map(|k: usize| [corners[k][0], -1.0, 0.5, corners[k][1]]).to_vec();
    let varyings: Vec<_> = order.map(|k: usize| corners[k].to_vec()).to_vec();
    let pass = pass(128, 128, 1, vec![draw(mesh(&vertices, &varyings), Blend::Replace)]);
    let show = |v: &[R]| Some(vec![v[0], v[1], R::from_f64(0.0), R::from_f64(1.0)]);
    let image = render(&pass, &[(&pass_through::<R>(2), &fragment(vec![location(0, 0), location(0, 1)], &show))]);
    let mut worst = 0.0_f64;
    let mut covered = 0;
    for (i, p) in image.iter().enumerate() {
        let (x, y) = (((i % 128) as f64 + 0.5) / 64.0 - 1.0, 1.0 - ((i / 128) as f64 + 0.5) / 64.0);
        let z = -1.0 / y;
        if p[3] == 1.0 {
            covered += 1;
            // Error in pixels on the screen, where a wrong interpolation is visible.
            let (u, v) = (f64::from(p[0]), f64::from(p[1]));
            worst = larger(worst, larger((u / v - x).abs(), (1.0 / v - 1.0 / z).abs()) * 64.0);
        }
    }
    assert!(covered > 7000, "{covered}");
    worst
}

#[test]
fn varyings_are_perspective_correct() {
    let (single, double) = (worst_ground_error::<f32>(), worst_ground_error::<f64>());
    assert!(single < 1e-3, "f32: {single} pixels");
    assert!(double < 1e-3, "f64: {double} pixels");
}

#[test]
fn varyings_are_exact_where_w_is_one() {
    // The varying is x in pixels; it must be exact at every pixel centre.
    let vertex_at = |x: f32, y: f32| (clip_at(x, y, 256.0), vec![x]);
    let (vertices, varyings): (Vec<_>, Vec<_>) = [vertex_at(0.0, 0.0), vertex_at(0.0, 512.0), vertex_at(512.0, 0.0)].into_iter().unzip();
    let pass = pass(256, 256, 1, vec![draw(mesh(&vertices, &varyings), Blend::Replace)]);
    let show = |v: &[f32]| Some(vec![v[0], v[1], v[2], 1.0]);
    let inputs = vec![location(0, 0), LaneInput::FragCoord { component: 0 }, LaneInput::FragCoord { component: 3 }];
    let image = render(&pass, &[(&pass_through::<f32>(1), &fragment(inputs, &show))]);
    for (i, p) in image.iter().enumerate() {
        assert_eq!(p, &[(i % 256) as f32 + 0.5, (i % 256) as f32 + 0.5, 1.0, 1.0]);
    }
}

#[test]
fn flat_varyings_use_the_first_vertex_and_facing_follows_the_winding() {
    let vertices = [
        clip_at(0.0, 0.0, 64.0),
        clip_at(0.0, 64.0, 64.0),
        clip_at(64.0, 0.0, 64.0),
        clip_at(64.0, 64.0, 64.0),
        clip_at(0.0, 64.0, 64.0),
        clip_at(64.0, 0.0, 64.0),
    ];
    let varyings: Vec<_> = [5.0, 6.0, 7.0, 8.0, 9.0, 10.0].map(|v| vec![v]).to_vec();
    let show = |v: &[f32]| Some(vec![v[0], f32::from(u8::from(v[1].is_mask_set())), 0.0, 1.0]);
    let inputs = vec![LaneInput::Location { index: 0, component: 0, flat: true }, LaneInput::FrontFacing];
    let mut two_sided = pass(64, 64, 1, vec![draw(mesh(&vertices, &varyings), Blend::Replace)]);
    let stages = (&pass_through::<f32>(1), &fragment(inputs, &show));
    let image = render(&two_sided, &[stages]);
    assert_eq!(image[64 * 10 + 10], [5.0, 1.0, 0.0, 1.0]);
    assert_eq!(image[64 * 50 + 50], [8.0, 0.0, 0.0, 1.0]);
    two_sided.draws[0].cull = Cull::Back;
    let image = render(&two_sided, &[stages]);
    assert_eq!(image[64 * 10 + 10], [5.0, 1.0, 0.0, 1.0]);
    assert_eq!(image[64 * 50 + 50], [0.0; 4]);
}

#[test]
fn helper_lanes_extrapolate_the_plane_outside_the_triangle() {
    // A narrow triangle covers many quads only in part: differences between their lanes still give the slopes of the plane.
    let vertex_at = |x: f32, y: f32| (clip_at(x, y, 64.0), vec![3.0 * x - 2.0 * y]);
    let (vertices, varyings): (Vec<_>, Vec<_>) = [vertex_at(9.2, 9.3), vertex_at(10.1, 20.7), vertex_at(13.9, 9.4)].into_iter().unzip();
    let differences = |quad: &[Vec<f32>; 4]| {
        std::array::from_fn(|k: usize| vec![quad[k | 1][0] - quad[k & !1][0], quad[k | 2][0] - quad[k & !2][0], 0.0, 1.0])
    };
    let shader =
        HandShader { inputs: vec![location(0, 0)], outputs: colour_outputs(), discards: false, function: LaneFunction::Quad(&differences) };
    let image = render(&pass(64, 64, 1, vec![draw(mesh(&vertices, &varyings), Blend::Replace)]), &[(&pass_through::<f32>(1), &shader)]);
    let covered: Vec<_> = image.iter().filter(|p| p[3] == 1.0).collect();
    assert!(covered.len() > 15);
    for p in covered {
        // Snapping the corners to 1/4096 pixel tilts the plane of so small a triangle by up to a thousandth.
        assert!((p[0] - 3.0).abs() < 5e-3 && (p[1] + 2.0).abs() < 5e-3, "{p:?}");
    }
}

/// Two triangles that cover the image.
fn whole_image(depth: f32) -> Vec<[f32; 4]> {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]: [f32; 2]| [x, y, depth, 1.0]).to_vec()
}

#[test]
fn depth_orders_distances_from_a_metre_to_a_hundred_au() {
    // Reversed depth, 1 m / distance: a metre, a kilometre, the Moon's distance, 1 au, 100 au and slightly more.
    let depths = [1.0e3_f32, 1.0, 1.0 / 384_400.0, 1.0 / 1.496e8, 1.0 / 1.496e10, 1.0 / 1.4961e10].map(|inverse_km| inverse_km / 1.0e3);
    let colours = [0, 1, 2, 3, 4, 5].map(|k| one_colour([k as f32 + 1.0, 0.0, 0.0, 1.0]));
    let vertex = pass_through::<f32>(0);
    for order in [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [3, 5, 0, 4, 1, 2]] {
        let fragments: Vec<_> = order.iter().map(|k| fragment(vec![], &colours[*k])).collect();
        for count in 1..=6 {
            let draws = order[..count]
                .iter()
                .map(|k| {
                    let mut tested = draw(mesh(&whole_image(depths[*k]), &[]), Blend::Replace);
                    tested.depth = DEPTH;
                    tested
                })
                .collect();
            let stages: Vec<_> = fragments[..count].iter().map(|f| (&vertex, f)).collect();
            let image = render(&pass(8, 8, 4, draws), &stages);
            let nearest = order[..count].iter().min().expect("one at least");
            assert!(image.iter().all(|p| p[0] == *nearest as f32 + 1.0), "{order:?} {count}");
        }
    }
}

#[test]
fn written_depth_and_discard_are_honoured() {
    let vertex = pass_through::<f32>(0);
    // Left half at depth 0.75, right half at 0.25; column 8 is discarded.
    let stepped = |v: &[f32]| (v[0] as u32 != 8).then(|| vec![1.0, 0.0, 0.0, 1.0, if v[0] < 16.0 { 0.75 } else { 0.25 }]);
    let mut outputs = colour_outputs();
    outputs.push(LaneOutput::FragDepth);
    let near_far =
        HandShader { inputs: vec![LaneInput::FragCoord { component: 0 }], outputs, discards: true, function: LaneFunction::Lane(&stepped) };
    let green = one_colour([0.0, 1.0, 0.0, 1.0]);
    let flat = fragment(vec![], &green);
    for samples in [1, 4] {
        let mut draws = vec![draw(mesh(&whole_image(0.5), &[]), Blend::Replace); 2];
        draws.iter_mut().for_each(|d| d.depth = DEPTH);
        let forward = render(&pass(32, 32, samples, draws.clone()), &[(&vertex, &near_far), (&vertex, &flat)]);
        let backward = render(&pass(32, 32, samples, draws), &[(&vertex, &flat), (&vertex, &near_far)]);
        assert!(forward == backward, "the order of the draws must not matter");
        for (i, p) in forward.iter().enumerate() {
            let x = i % 32;
            let red = x < 16 && x != 8;
            assert_eq!(p, &if red { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0, 1.0] }, "x = {x}");
        }
    }
}

#[test]
fn blending_follows_its_equations_at_edges_too() {
    let vertex = pass_through::<f32>(0);
    let (under, over) = (one_colour([0.5, 0.25, 1.0, 1.0]), one_colour([0.25, 0.5, 0.0, 0.5]));
    let stages = [(&vertex, &fragment(vec![], &under)), (&vertex, &fragment(vec![], &over))];
    // The second draw's edge at x = 2.5 pixels covers two of four samples there.
    let half = [clip_at(2.5, -60.0, 8.0), clip_at(2.5, 60.0, 8.0), clip_at(100.0, 0.0, 8.0)];
    for (blend, full) in
        [(Blend::Replace, [0.25, 0.5, 0.0, 0.5]), (Blend::PremultipliedOver, [0.5, 0.625, 0.5, 1.0]), (Blend::Add, [0.75, 0.75, 1.0, 1.5])]
    {
        let draws = vec![draw(mesh(&whole_image(0.5), &[]), Blend::Replace), draw(mesh(&half, &[]), blend)];
        let image = render(&pass(8, 8, 4, draws), &stages);
        let row = &image[4 * 8..5 * 8];
        assert_eq!(row[0], [0.5, 0.25, 1.0, 1.0]);
        assert_eq!(row[5], full, "{blend:?}");
        let mean: [f32; 4] = std::array::from_fn(|k| 0.5 * (row[0][k] + full[k]));
        assert_eq!(row[2], mean, "{blend:?}");
    }
}

#[test]
fn draws_stay_inside_their_scissor() {
    let vertex = pass_through::<f32>(0);
    let white = one_colour([1.0; 4]);
    let mut scissored = draw(mesh(&whole_image(0.5), &[]), Blend::Add);
    scissored.scissor = [3, 5, 77, 70];
    for samples in [1, 4] {
        let image = render(&pass(100, 90, samples, vec![scissored.clone()]), &[(&vertex, &fragment(vec![], &white))]);
        for (i, p) in image.iter().enumerate() {
            let inside = (3..77).contains(&(i % 100)) && (5..70).contains(&(i / 100));
            assert_eq!(p[0], f32::from(u8::from(inside)), "{i}");
        }
    }
}

/// A pass with many small and large overlapping triangles, whose blended colours depend on the order of drawing.
fn overlapping_triangles() -> Pass {
    let mut seed = 3;
    let (mut vertices, mut varyings) = (Vec::new(), Vec::new());
    for k in 0..600 {
        let extent = if k % 40 == 0 { 150.0 } else { 9.0 };
        let (x, y) = (random(&mut seed) * 200.0, random(&mut seed) * 200.0);
        for _ in 0..3 {
            let p = clip_at(x + extent * (random(&mut seed) - 0.5), y + extent * (random(&mut seed) - 0.5), 200.0);
            let w = 0.5 + random(&mut seed);
            vertices.push([p[0] * w, p[1] * w, random(&mut seed) * w, w]);
            varyings.push(vec![random(&mut seed), random(&mut seed), random(&mut seed)]);
        }
    }
    let mut over = draw(mesh(&vertices, &varyings), Blend::PremultipliedOver);
    over.depth = DEPTH;
    let mut add = over.clone();
    add.depth.test = false;
    add.blend = Blend::Add;
    pass(200, 200, 4, vec![over, add])
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let pass = overlapping_triangles();
    let vertex = pass_through::<f32>(3);
    let show = |v: &[f32]| Some(vec![v[0] * 0.5, v[1] * 0.5, v[2] * 0.5, 0.5]);
    let shader = fragment((0..3).map(|c| location(0, c)).collect(), &show);
    let stages = [(&vertex, &shader), (&vertex, &shader)];
    let render_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| render(&pass, &stages))
    };
    let single_threaded = render_with(1);
    assert!(single_threaded.iter().filter(|p| p[3] > 0.0).count() > 10_000);
    for threads in [1, 2, 3] {
        let same = render_with(threads).iter().zip(&single_threaded).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits));
        assert!(same, "{threads} threads");
    }
}

#[test]
fn every_size_is_drawn() {
    for (w, h) in [(1, 1), (1, 77), (77, 1), (63, 65), (16384, 1), (1, 16384)] {
        for samples in [1, 4] {
            let vertex = pass_through::<f32>(0);
            let white = one_colour([1.0; 4]);
            let image =
                render(&pass(w, h, samples, vec![draw(mesh(&whole_image(0.5), &[]), Blend::Add)]), &[(&vertex, &fragment(vec![], &white))]);
            assert_eq!(image.len(), (w * h) as usize);
            assert!(image.iter().all(|p| *p == [1.0; 4]), "{w}x{h}, {samples} samples");
        }
    }
}
