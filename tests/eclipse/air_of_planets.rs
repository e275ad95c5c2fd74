//! Sunlight through the air of planets on their moons: the round layers of the air fit the elliptical outline, the moons of Jupiter are lit just inside the
//! shadow and dark in its middle, where the shader has no refraction; the air of a planet in transit is left out.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3, Vec4};
use orrery::catalog::NaifId;
use orrery::probe::Prober;
use orrery::probe::sunlight::{OccludedSun, sunlight_from_uniforms};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::draw::{Eclipse, EclipseModel, EclipseUniforms};
use orrery::scene::eclipse::{EclipseModelChoice, REFRACTING_LAYERS, Receiver, choose_eclipse_model};
use orrery::time::Instant;

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

/// Uniforms of an occluder at a distance of 100, where the Sun's disc has a projected radius of 1, without limb darkening.
fn uniforms(semi_axes: DVec2) -> EclipseUniforms {
    let disc = Vec4::splat(std::f32::consts::FRAC_1_PI);
    EclipseUniforms {
        axis: Vec4::new(0.0, 0.0, 1.0, 1e-7),
        perpendicular_axes: [Vec4::new(1.0, 0.0, 0.0, 100.0), Vec4::new(0.0, 1.0, 0.0, 1e-5)],
        limb_darkening: [disc, Vec4::ZERO, Vec4::ZERO],
        occluder_positions: vec![Vec4::new(0.0, 0.0, 100.0, 0.0)],
        occluder_outlines: vec![Vec4::new(1.0, 0.0, semi_axes.x as f32, semi_axes.y as f32)],
        ..EclipseUniforms::default()
    }
}

/// Air that neither bends nor dims light leaves the light that passes the solid body. The outlines are Jupiter's from Io, Saturn's and a circle. Layers around
/// the centre, at the mean radius of the ellipse, were wrong by half of the Sun's light.
#[test]
fn clear_air_that_bends_nothing_changes_no_light_past_an_ellipse() {
    for (semi_axes, air) in [(DVec2::new(190.0, 177.7), 0.8), (DVec2::new(100.0, 90.2), 0.6), (DVec2::new(50.0, 50.0), 0.8)] {
        let mean_radius = (semi_axes.x * semi_axes.y).sqrt();
        let edge = |k: usize| (mean_radius + air * k as f64 / REFRACTING_LAYERS as f64) as f32;
        let with_air = EclipseUniforms {
            air_edges: (0..REFRACTING_LAYERS).map(|k| Vec4::new(edge(k), 0.0, edge(k + 1), 0.0)).collect(),
            air_transmittance: vec![Vec4::ONE; REFRACTING_LAYERS],
            ..uniforms(semi_axes + DVec2::splat(air))
        };
        let points: Vec<DVec3> = (0..=16)
            .flat_map(|k| (-8..=12).map(move |j| (f64::from(k) * std::f64::consts::PI / 16.0, 0.15 * f64::from(j))))
            .map(|(angle, beyond)| {
                let direction = DVec2::from_angle(angle);
                (direction * (1.0 / (direction / semi_axes).length() + beyond)).extend(0.0)
            })
            .collect();
        for precision in [Precision::F32, Precision::F64] {
            let renderer = renderer(precision);
            let prober = Prober { session: &SESSION, renderer: &renderer };
            let light = |model, uniforms: &EclipseUniforms| {
                sunlight_from_uniforms(&prober, Eclipse { occluders: 1, model }, uniforms.clone(), &points).expect("answers")
            };
            let (found, expected) = (light(EclipseModel::Refracted, &with_air), light(EclipseModel::LimbDarkened, &uniforms(semi_axes)));
            let partial = expected.iter().filter(|rgb| (0.05..0.95).contains(&rgb[1])).count();
            assert!(partial > 100, "{partial} points in the penumbra");
            for (point, (found, expected)) in points.iter().zip(found.iter().zip(&expected)) {
                assert!((found[1] - expected[1]).abs() < 0.01, "{semi_axes} {precision:?} {point}: {} for {}", found[1], expected[1]);
            }
        }
    }
}

/// Io enters Jupiter's shadow on 2024-12-08. In the first minutes after the last direct light, Jupiter's air sends it red light that fades; when all of it is
/// deep in the shadow, none, and the shader has no refraction.
#[test]
fn light_through_the_air_of_jupiter_fades_on_io() {
    let renderer = renderer(Precision::F64);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let io = SESSION.catalog().body(NaifId(501)).expect("Io");
    // The model, and the light at the point that faces Jupiter, with the model of standard quality or the one requested.
    let at = |time: &str, choice: EclipseModelChoice| {
        let receiver = Receiver::at(SESSION.ephemeris(), io, Instant::parse(time).expect("a time")).expect("placed");
        let sun = OccludedSun::seen_from(&prober, &receiver, choice).expect("a Sun");
        let model = choose_eclipse_model(&mut sun.occluders.clone(), choice).model;
        (model, sun.sunlight(&sun.occluders, &[DVec3::X], None).expect("answers")[0])
    };
    let best = EclipseModelChoice::Best;
    let mut before = [1.0; 3];
    for second in (0..=240).step_by(20) {
        let time = format!("2024-12-08T06:{:02}:{:02}Z", 14 + second / 60, second % 60);
        let (model, light) = at(&time, best);
        println!("{time}: {light:?}");
        assert_eq!(model, EclipseModel::Refracted, "{time}");
        assert!((0..3).all(|c| light[c] <= before[c] && light[c] >= 0.0), "{time}: {light:?} after {before:?}");
        before = light;
    }
    // At 06:16 the last direct light has ended. Without air none would be left. A few thousandths are the light of rays that are bent by 600 to 1000 km at
    // Io's distance: scale height over displacement, 19 km / 800 km, times the transmittance of gas and haze, a fifth.
    let (_, inside) = at("2024-12-08T06:16:10Z", best);
    assert!(inside[0] > 1.3 * inside[2] && (5e-4..5e-3).contains(&inside[1]), "{inside:?}");
    assert_eq!(at("2024-12-08T06:16:10Z", EclipseModelChoice::Requested(EclipseModel::LimbDarkened)).1, [0.0; 3]);
    let deep = "2024-12-08T06:50:00Z";
    assert_eq!(at(deep, best), (EclipseModel::LimbDarkened, [0.0; 3]));
    assert_eq!(at(deep, EclipseModelChoice::Draft).0, EclipseModel::UniformDisc);
    // The test by which the refraction was left out loses no light.
    assert_eq!(at(deep, EclipseModelChoice::Requested(EclipseModel::Refracted)), (EclipseModel::Refracted, [0.0; 3]));
}

/// Venus in transit is in front of the Sun as seen from the Earth. Its air sends no light into a shadow on the Earth, and there are no shaders for it.
#[test]
fn the_air_of_a_planet_in_transit_is_left_out() {
    let earth = SESSION.catalog().body(NaifId::EARTH).expect("the Earth");
    let receiver = Receiver::at(SESSION.ephemeris(), earth, Instant::parse("2012-06-06T01:30:00Z").expect("a time")).expect("placed");
    let renderer = renderer(Precision::F32);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let choice = EclipseModelChoice::Requested(EclipseModel::Refracted);
    let mut occluders = OccludedSun::seen_from(&prober, &receiver, choice).expect("a Sun").occluders;
    assert_eq!(occluders.iter().map(|o| o.body.id).collect::<Vec<_>>(), [NaifId(299)]);
    assert_eq!(choose_eclipse_model(&mut occluders, choice).model, EclipseModel::LimbDarkened);
}
