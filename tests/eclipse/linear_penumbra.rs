//! The eclipse model `linear` behind elongated outlines.

use crate::support::session::SESSION;
use orrery::probe::Prober;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use serde_json::json;

/// Elongated outlines against the exact overlap of uniform discs, up to a planet as large as Saturn seen from its inner moons.
#[test]
fn the_linear_model_follows_elongated_outlines() {
    let renderer = SoftwareRenderer::new(Options { precision: Precision::F64, ..Options::default() }).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    // The radius to the tangent line across the direction of the Sun's centre is longer than the outline there.
    let by_tangent = |major: f64, minor: f64, angle: f64, distance: f64| {
        let radius = (major * angle.cos()).hypot(minor * angle.sin());
        ((1.0 + radius - distance) / (1.0 + radius - (1.0 - radius).abs())).clamp(0.0, 1.0)
    };
    let mut worst_by_tangent = 0.0_f64;
    for (major, minor, bound) in
        [(300.0, 270.0, 0.07), (100.0, 90.0, 0.07), (5.0, 4.5, 0.08), (2.0, 0.75, 0.13), (1.2, 0.9, 0.13), (0.5, 0.3, 0.03)]
    {
        for angle_deg in (0..=90).step_by(15) {
            let angle = f64::from(angle_deg).to_radians();
            let outline = major * minor / (minor * angle.cos()).hypot(major * angle.sin());
            for distance in (-12..=12).map(|eighths| outline + f64::from(eighths) / 8.0).filter(|d| *d > 0.0) {
                let blocked = |model: &str| {
                    let q = json!({"q": "disc-overlap", "semi_major": major, "semi_minor": minor, "centre_distance": distance,
                        "offset_angle_from_major_axis_deg": angle_deg, "model": model});
                    let answer = prober.answer(&q.to_string()).expect("an answer");
                    answer["blocked"].as_f64().expect("a number")
                };
                let exact = blocked("uniform-disc");
                let error = blocked("linear") - exact;
                assert!(error.abs() < bound, "{major} {minor} at {angle_deg} degrees, {distance}: {error}");
                worst_by_tangent = worst_by_tangent.max((by_tangent(major, minor, angle, distance) - exact).abs());
            }
        }
    }
    assert!(worst_by_tangent > 0.5, "{worst_by_tangent}");
}
