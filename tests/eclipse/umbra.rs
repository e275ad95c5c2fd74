//! Edges of shadows: sunlight is exactly 0 in every channel inside an umbra, exactly 1 outside every penumbra, and falls monotonically in
//! between, in f32 and f64. Tested for the models without refraction, for round and elongated occluders, for one to four occluders, and for
//! the shadows of a globe on its ring and of the ring on the globe.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use crate::support::sweep;
use glam::{DVec2, DVec3, Vec4};
use orrery::probe::Prober;
use orrery::probe::sunlight::sunlight_from_uniforms;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::draw::{Eclipse, EclipseModel, EclipseUniforms};
use serde_json::{Value, json};
use std::sync::LazyLock;

static RENDERERS: LazyLock<[SoftwareRenderer; 2]> = LazyLock::new(|| {
    [Precision::F32, Precision::F64]
        .map(|precision| SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer"))
});

fn probers() -> [(Prober<'static>, &'static str); 2] {
    [(Prober { session: &SESSION, renderer: &RENDERERS[0] }, "f32"), (Prober { session: &SESSION, renderer: &RENDERERS[1] }, "f64")]
}

const MODELS: [EclipseModel; 3] = [EclipseModel::Linear, EclipseModel::UniformDisc, EclipseModel::LimbDarkened];

/// An occluder's outline as seen from the receiver, relative to the Sun's centre, in solar radii.
#[derive(Clone, Copy, Debug)]
struct Outline {
    centre: DVec2,
    /// Direction of the long axis.
    axis: DVec2,
    semi_axes: DVec2,
}

impl Outline {
    fn shifted(self, by: DVec2) -> Self {
        Self { centre: self.centre + by, ..self }
    }

    /// Least and greatest value of the outline's quadratic form on the Sun's limb; it is 1 on the outline, and less inside.
    fn range_on_limb(&self) -> (f64, f64) {
        let quadratic_form = |angle: f64| {
            let p = DVec2::from_angle(angle) - self.centre;
            let (x, y) = (p.dot(self.axis), p.dot(self.axis.perp()));
            (x / self.semi_axes.x).powi(2) + (y / self.semi_axes.y).powi(2)
        };
        (0..2000)
            .map(|k| quadratic_form(f64::from(k) * std::f64::consts::TAU / 2000.0))
            .fold((f64::MAX, 0.0), |(a, b), v| (a.min(v), b.max(v)))
    }
}

/// Fraction of the light that an outline leaves visible of a Sun with these coefficients of limb darkening: a sum over chords along the outline's long axis.
fn visible_fraction_by_chords(outline: &Outline, [u1, u2]: [f64; 2]) -> f64 {
    let centre = DVec2::new(outline.centre.dot(outline.axis), outline.centre.dot(outline.axis.perp()));
    // The light along a chord, of which half is `sun_half`, from its midpoint to x.
    let light_to = |x: f64, sun_half: f64| {
        let mu = (sun_half * sun_half - x * x).max(0.0).sqrt();
        let of_mu = 0.5 * (x * mu + sun_half * sun_half * x.atan2(mu));
        (1.0 - u1 - u2) * x + (u1 + 2.0 * u2) * of_mu - u2 * x * (sun_half * sun_half - x * x / 3.0)
    };
    let [low, high] = [-1.0, 1.0].map(|side: f64| (centre.y + side * outline.semi_axes.y).clamp(-1.0, 1.0));
    let chords = 400;
    let hidden: f64 = (0..chords)
        .map(|k| {
            // Equal steps of an angle, whose sine is the height: the chords are densest where the outline or the Sun ends.
            let angle = std::f64::consts::PI * ((f64::from(k) + 0.5) / f64::from(chords) - 0.5);
            let y = 0.5 * (low + high) + 0.5 * (high - low) * angle.sin();
            let width = 0.5 * (high - low) * angle.cos() * std::f64::consts::PI / f64::from(chords);
            let sun_half = (1.0 - y * y).max(0.0).sqrt();
            let half = outline.semi_axes.x * (1.0 - ((y - centre.y) / outline.semi_axes.y).powi(2)).max(0.0).sqrt();
            let [left, right] = [centre.x - half, centre.x + half].map(|x| x.clamp(-sun_half, sun_half));
            width * (light_to(right, sun_half) - light_to(left, sun_half))
        })
        .sum();
    1.0 - hidden / (std::f64::consts::PI * (1.0 - u1 / 3.0 - u2 / 6.0))
}

/// u1 and u2 per channel, different as for the Sun: red darkens least.
const LIMB_DARKENING: [[f64; 2]; 3] = [[0.34, 0.25], [0.40, 0.26], [0.625, 0.18]];

/// Uniforms of occluders at a distance of 100, where the Sun's disc has a projected radius of 1: lengths across are in solar radii. The Sun
/// is nearly at infinity.
fn uniforms(occluders: &[Outline], model: EclipseModel) -> (Eclipse, EclipseUniforms) {
    let v = |x: f64, y: f64, z: f64, w: f64| Vec4::new(x as f32, y as f32, z as f32, w as f32);
    let limb_darkening = |k: usize| if model == EclipseModel::LimbDarkened { LIMB_DARKENING[k] } else { [0.0; 2] };
    let factors = [0, 1, 2].map(|k| {
        let [u1, u2] = limb_darkening(k);
        let flux = std::f64::consts::PI * (1.0 - u1 / 3.0 - u2 / 6.0);
        [(1.0 - u1 - u2) / flux, (u1 + 2.0 * u2) / flux, -u2 / flux]
    });
    let uniforms = EclipseUniforms {
        axis: v(0.0, 0.0, 1.0, 1e-7),
        perpendicular_axes: [v(1.0, 0.0, 0.0, 100.0), v(0.0, 1.0, 0.0, 1e-5)],
        limb_darkening: [0, 1, 2].map(|term| v(factors[0][term], factors[1][term], factors[2][term], 0.0)),
        occluder_positions: occluders.iter().map(|c| v(c.centre.x, c.centre.y, 100.0, 0.0)).collect(),
        occluder_outlines: occluders.iter().map(|c| v(c.axis.x, c.axis.y, c.semi_axes.x, c.semi_axes.y)).collect(),
        ..EclipseUniforms::default()
    };
    (Eclipse { occluders: occluders.len() as u8, model }, uniforms)
}

/// Pseudorandom numbers in 0..1, different for each seed.
fn random_numbers(seed: f64) -> impl FnMut() -> f64 {
    let mut k = seed;
    move || {
        k += 1.0;
        ((k * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
    }
}

/// The receiver moves in a straight line from outside the penumbra to the middle of the shadow, so that the occluder hides more and more of
/// the Sun.
#[test]
fn sunlight_is_exact_at_the_contacts_and_falls_monotonically() {
    let mut random = random_numbers(3.0);
    // Numbers of points without light, with full light and in between.
    let mut point_counts = [0; 3];
    let (mut worst_round, mut worst_elongated) = (0.0_f64, 0.0_f64);
    for case in 0..36 {
        let is_round = case % 3 != 0;
        let long = [0.05, 0.3, 0.99, 1.0, 1.02, 1.05, 1.3, 2.0, 3.5, 6.0, 25.0, 400.0][case % 12] * (0.97 + 0.06 * random());
        let short = if is_round { long } else { long * (0.6 + 0.39 * random()) };
        let shape = Outline { centre: DVec2::ZERO, axis: DVec2::from_angle(6.0 * random()), semi_axes: DVec2::new(long, short) };
        let direction = DVec2::from_angle(6.0 * random());
        let aside = direction.perp() * (0.3 * random() * (long - 1.0).clamp(0.0, 1.0));
        if !sweep::runs(case, 4) {
            continue;
        }
        // Distances of the occluder's centre along the way, from 1.3 solar radii before first contact to the middle.
        let steps = 240;
        let distances: Vec<f64> = (0..=steps).map(|k| (long + 2.3) * (1.0 - f64::from(k) / f64::from(steps))).collect();
        // The receiver moves and the occluders rest, so seen from the receiver the occluders move the other way.
        let points: Vec<_> = distances.iter().map(|d| (-(direction * *d + aside)).extend(0.0)).collect();
        // The contacts of `linear` with an elongated outline are approximate.
        for model in MODELS.into_iter().filter(|m| is_round || *m != EclipseModel::Linear) {
            // Each of the twelve sizes is tested with one occluder, and also with two or with four, alternately.
            for count in [1, if (case / 12 + case) % 2 == 0 { 2 } else { 4 }] {
                // The other occluders are far to the side and hide nothing.
                let others = (1..count).map(|k| shape.shifted(DVec2::new(3e4 * f64::from(k), 1e4)));
                let occluders: Vec<_> = std::iter::once(shape).chain(others).collect();
                let (eclipse, eclipse_uniforms) = uniforms(&occluders, model);
                for (prober, precision) in probers() {
                    let light = sunlight_from_uniforms(&prober, eclipse, eclipse_uniforms.clone(), &points).expect("answers");
                    let describe =
                        |k: usize| format!("{model:?} {precision} {count} occluders {shape:?} at {}: {:?}", distances[k], light[k]);
                    for (k, rgb) in light.iter().enumerate() {
                        let outline = shape.shifted(direction * distances[k] + aside);
                        let (min, max) = outline.range_on_limb();
                        let margin = 2e-3;
                        if max < 1.0 - margin && outline.semi_axes.y > 1.0 {
                            assert_eq!(*rgb, [0.0; 3], "{}", describe(k));
                            point_counts[0] += 1;
                        } else if min > 1.0 + margin && outline.centre.length() > 1.0 {
                            assert_eq!(*rgb, [1.0; 3], "{}", describe(k));
                            point_counts[1] += 1;
                        } else {
                            point_counts[2] += 1;
                        }
                    }
                    for k in 1..light.len() {
                        // After the closest approach a small occluder would uncover the Sun again, so the way ends there.
                        let rise = (0..3).map(|c| light[k][c] - light[k - 1][c]).fold(0.0, larger);
                        let worst = if is_round { &mut worst_round } else { &mut worst_elongated };
                        *worst = worst.max(rise);
                        // Round occluders: rounding, and a step of 2e-7 where the hidden part is summed instead of the visible part.
                        // Elongated occluders: the chords between 32 nodes have an error of 2.5e-4 of the light
                        // (tests/eclipse/reference_tables.rs).
                        let tolerance = if is_round { 4e-7 } else { 3e-4 };
                        assert!(rise <= tolerance, "rises by {rise:e} from {:?}: {}", light[k - 1], describe(k));
                    }
                }
            }
        }
    }
    println!("{point_counts:?}; light rises by {worst_round:e} and {worst_elongated:e} at most");
    assert!(point_counts.iter().all(|n| *n > 1000), "{point_counts:?}");
}

/// Within a flat outline, the Sun may be far from the end of the long axis in whose direction its centre lies, and near the sides: the nearest point of the
/// limb is not the one in that direction.
#[test]
fn flat_outlines_hide_exactly_the_sun_that_lies_inside_them() {
    // Ratio of the semi-axes, and bound on the error of the light. Measured at other positions: 4.6e-4 from 0.7 on, 9e-4 at 0.6, 1.3e-3 at 0.5, 2.6e-3 at
    // 0.41, 4.3e-3 at 0.3: in the penumbra the chords between 32 nodes, and the circle in place of a long limb, are worst for flat outlines.
    let ratios = [(0.3, 5e-3), (0.41, 3e-3), (0.5, 1.5e-3), (0.6, 1e-3), (0.7, 5e-4), (0.8, 5e-4), (0.9, 5e-4)];
    // Numbers of points without light, and of other points.
    let mut point_counts = [0; 2];
    let mut outside_end_circle = 0;
    for (index, (ratio, max_error)) in ratios.into_iter().enumerate().filter(|(index, _)| sweep::runs(*index, 3)) {
        let mut worst = 0.0;
        for short in [1.2, 2.0, 3.2, 5.0, 10.0, 30.0] {
            let axis = DVec2::from_angle(0.7 + index as f64);
            let shape = Outline { centre: DVec2::ZERO, axis, semi_axes: DVec2::new(short / ratio, short) };
            let offsets: Vec<DVec2> = [0.0_f64, 1.0, 3.0, 7.0, 15.0, 30.0, 50.0, 70.0, 90.0]
                .into_iter()
                .flat_map(|degrees| {
                    let direction = DVec2::from_angle(degrees.to_radians());
                    // From the middle to 1.6 solar radii beyond the outline.
                    let reach = 1.6 + 1.0 / (direction / shape.semi_axes).length();
                    (0..40).map(move |k| axis.rotate(direction * (reach * f64::from(k) / 39.0)))
                })
                .collect();
            let points: Vec<_> = offsets.iter().map(|offset| (-*offset).extend(0.0)).collect();
            let (eclipse, eclipse_uniforms) = uniforms(&[shape], EclipseModel::LimbDarkened);
            for (prober, precision) in probers() {
                let light = sunlight_from_uniforms(&prober, eclipse, eclipse_uniforms.clone(), &points).expect("answers");
                for (offset, rgb) in offsets.iter().zip(&light) {
                    let outline = shape.shifted(*offset);
                    if outline.range_on_limb().1 < 1.0 - 2e-3 {
                        assert_eq!(*rgb, [0.0; 3], "{precision} {outline:?}");
                        point_counts[0] += 1;
                        let radius = short * ratio;
                        outside_end_circle += usize::from(offset.distance(axis * (short / ratio - radius)) > radius - 1.0);
                    } else {
                        let error = (rgb[1] - visible_fraction_by_chords(&outline, LIMB_DARKENING[1])).abs();
                        assert!(error < max_error, "{precision} {outline:?}: {rgb:?}, off by {error:e}");
                        worst = larger(worst, error);
                        point_counts[1] += 1;
                    }
                }
            }
        }
        println!("ratio {ratio}: light off by {worst:e}");
    }
    assert!(point_counts.iter().all(|n| *n > 500), "{point_counts:?}");
    // Negative control: the circle of curvature at the end of the long axis, in place of the nearest point, would light many of the dark points.
    assert!(outside_end_circle > 100, "{outside_end_circle} of {point_counts:?}");
}

/// Some occluders cover the Sun only together, some cover it alone, and some leave a part uncovered.
#[test]
fn exactly_the_sets_of_occluders_that_cover_the_sun_leave_no_light() {
    let disc = |x: f64, y: f64, radius: f64| Outline { centre: DVec2::new(x, y), axis: DVec2::X, semi_axes: DVec2::splat(radius) };
    let cases: [(&[Outline], bool); 6] = [
        (&[disc(5.0, 0.0, 5.1), disc(-5.0, 0.0, 5.1)], true),
        (&[disc(5.0, 0.0, 5.1), disc(-5.0, 0.0, 4.8)], false),
        (&[disc(0.1, 0.0, 1.3), disc(0.5, 0.4, 0.3)], true),
        (&[disc(0.0, 9.0, 9.2), disc(7.0, -6.0, 9.4), disc(-7.0, -6.0, 9.4)], true),
        (&[disc(0.0, 9.0, 9.2), disc(9.0, -6.0, 8.9), disc(-9.0, -6.0, 8.9)], false),
        (&[disc(3.0, 0.0, 4.2), disc(0.2, 0.1, 0.2), disc(0.5, 0.3, 0.3), disc(-0.4, 0.3, 0.25)], true),
    ];
    for (occluders, is_covered) in cases {
        for model in [EclipseModel::UniformDisc, EclipseModel::LimbDarkened] {
            let (eclipse, eclipse_uniforms) = uniforms(occluders, model);
            for (prober, precision) in probers() {
                let rgb = sunlight_from_uniforms(&prober, eclipse, eclipse_uniforms.clone(), &[DVec3::ZERO]).expect("answers")[0];
                assert_eq!(rgb == [0.0; 3], is_covered, "{model:?} {precision} {occluders:?}: {rgb:?}");
                assert!(is_covered || rgb.iter().all(|v| *v > 0.01), "{model:?} {precision} {occluders:?}: {rgb:?}");
            }
        }
    }
}

fn answer(prober: &Prober<'_>, question: &Value) -> Value {
    prober.answer(&question.to_string()).unwrap_or_else(|e| panic!("{question}: {e}"))
}

/// Places on moons that move through their planets' shadows: all channels become dark at the same instant, and `probe` returns exact zeros.
#[test]
fn moons_become_dark_in_every_channel_at_once() {
    let crossings = [("ganymede", "2017-05-17T03:00:00Z", 20), ("io", "2024-12-07T12:00:00Z", 45), ("moon", "2022-11-08T08:00:00Z", 15)];
    for (body, from, step_minutes) in crossings {
        let start = orrery::time::Instant::parse(from).expect("a time");
        let (mut dark_count, mut lit_count) = (0, 0);
        for (prober, precision) in probers() {
            for k in 0..60 {
                let time = start.plus_seconds(f64::from(60 * step_minutes * k)).to_utc_iso();
                for (lat, lon) in [(0.0, 0.0), (-35.0, 80.0), (10.0, 200.0)] {
                    let question = json!({"q": "sunlight", "body": body, "time": time, "lat": lat, "lon": lon, "model": "limb-darkened"});
                    let found = answer(&prober, &question);
                    let rgb: Vec<f64> = (0..3).map(|c| found["rgb"][c].as_f64().expect("a number")).collect();
                    let fraction = found["fraction"].as_f64().expect("a number");
                    let zero_count = rgb.iter().filter(|v| **v == 0.0).count();
                    assert!(zero_count == 0 || zero_count == 3 && fraction == 0.0, "{precision} {question}: {found}");
                    // Even a thin crescent is brighter than a rounding error.
                    assert!(rgb.iter().all(|v| *v == 0.0 || *v > 1e-9), "{precision} {question}: {found}");
                    dark_count += usize::from(zero_count == 3);
                    lit_count += usize::from(rgb == [1.0; 3] && fraction == 1.0);
                }
            }
        }
        assert!(dark_count > 5 && lit_count > 50, "{body}: {dark_count} dark, {lit_count} fully lit");
    }
}

/// Along a ring through its planet's shadow, and on the globe outside the ring's shadow.
#[test]
fn shadows_of_globes_and_rings_have_exact_edges() {
    // Points without shadow and in full shadow.
    let mut point_counts = [0; 2];
    for (prober, precision) in probers() {
        for (sun_elevation_deg, ring_radius) in [(0.5_f64, 1.3), (4.0, 1.9), (20.0, 1.5), (26.0, 2.2)] {
            for (model, sun_deg) in [("sphere", 0.03), ("uniform-disc", 0.03), ("limb-darkened", 0.03), ("limb-darkened", 0.3)] {
                let (sine, cosine) = sun_elevation_deg.to_radians().sin_cos();
                let blocked: Vec<f64> = (0..=300)
                    .map(|k| {
                        // From noon to midnight in equal steps.
                        let angle = std::f64::consts::PI * (f64::from(k) / 300.0);
                        let question = json!({"q": "ring-shadow", "flattening": 0.098,
                            "point": [ring_radius * angle.cos(), ring_radius * angle.sin(), 0.0], "sun": [cosine, 0.0, sine],
                            "sun_angular_radius_deg": sun_deg, "model": model});
                        answer(&prober, &question)["blocked"].as_f64().expect("a number")
                    })
                    .collect();
                assert_eq!(blocked[0], 0.0, "{precision} {model}: noon");
                // With a high Sun, the shadow is short: a wide ring leaves it again before midnight. Up to its darkest point the blocked
                // fraction must not fall.
                let darkest = blocked.iter().copied().fold(0.0, f64::max);
                let deepest = blocked.iter().position(|b| *b == darkest).expect("one");
                for pair in blocked[..=deepest].windows(2) {
                    assert!(pair[1] >= pair[0] - 3e-7, "{precision} {model} {sun_elevation_deg} degrees: {pair:?}");
                }
                point_counts[0] += blocked.iter().filter(|b| **b == 0.0).count();
                point_counts[1] += blocked.iter().filter(|b| **b == 1.0).count();
                // At most one of these points may lie so close to the edge that only a trace of light is blocked or left.
                let nearly_exact = blocked.iter().filter(|b| **b != 0.0 && **b < 1e-6 || **b != 1.0 && **b > 1.0 - 1e-6).count();
                assert!(nearly_exact <= 1, "{precision} {model} {sun_elevation_deg} degrees: {nearly_exact}");
            }
        }
        // Outside the ring's shadow the globe receives all of the light.
        let profile = json!([{"r_in": 1.5, "r_out": 2.0, "tau_normal": 1.0}]);
        for k in 0..40 {
            let point = [1.0 + 0.004 * f64::from(k), 0.0, -0.1];
            let question = json!({"q": "ring-transmission", "profile": profile, "point": point, "sun": [1.0, 0.0, 0.4],
                "sun_angular_radius_deg": 0.05, "model": "penumbra"});
            assert_eq!(answer(&prober, &question)["transmission"].as_f64(), Some(1.0), "{precision} {question}");
        }
    }
    assert!(point_counts.iter().all(|n| *n > 500), "{point_counts:?}");
}
