//! The refracted image of the Sun in a body's limb: together with the direct Sun it has the light that the eclipse model computes for the
//! same place; the light falls smoothly as the Sun sets, and does not depend on the image size.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::{NaifId, Photometry};
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::probe::Prober;
use orrery::probe::sunlight::OccludedSun;
use orrery::render::plan::{SamplingQuality, plan};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::draw::{BodyPart, EclipseModel};
use orrery::scene::eclipse::{EclipseModelChoice, Receiver};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use orrery::time::Instant;
use orrery::units::KM_PER_AU;
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

fn instant(text: &str) -> Instant {
    Instant::parse(text).expect(text)
}

fn view_of(body: NaifId, time: Instant, fov_deg: f64, side: u32, effects: &str) -> ViewRequest {
    ViewRequest {
        fov_deg: Some(fov_deg),
        width: side,
        height: side,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(body, time)
    }
}

fn light(scene: &Scene, renderer: &SoftwareRenderer) -> Vec<[f64; 3]> {
    let plan = plan(scene, &*SESSION, SAMPLING).expect("a plan");
    let hdr = renderer.render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
    hdr.iter().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

/// Irradiance from the whole image (radiance times solid angle, summed over the pixels), relative to the Sun's at 1 au.
fn irradiance(scene: &Scene, light: &[[f64; 3]]) -> [f64; 3] {
    let camera = &scene.camera;
    let mut sum = [0.0; 3];
    for (k, pixel) in light.iter().enumerate() {
        let (x, y) = (k as u32 % camera.width, k as u32 / camera.width);
        let clip = camera.clip_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        // The ray's component along the view axis is 1.
        let ray_length = camera.ray(clip).length();
        let solid_angle = camera.pixel_tangent().powi(2) / ray_length.powi(3);
        for c in 0..3 {
            sum[c] += pixel[c] * solid_angle / PI;
        }
    }
    sum
}

/// The irradiance from the refracted limb alone: the image with the effect minus the image without.
fn limb_irradiance(request: &ViewRequest, renderer: &SoftwareRenderer) -> [f64; 3] {
    let without = EffectOverrides::parse(&format!("{},-refracted-limb", request.effects.to_text())).expect("effects");
    let [with, without] = [request.effects.clone(), without].map(|effects| {
        let scene = SESSION.scene(&ViewRequest { effects, ..request.clone() }).expect("a scene");
        irradiance(&scene, &light(&scene, renderer))
    });
    std::array::from_fn(|c| with[c] - without[c])
}

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

/// Sunlight, direct and refracted past the Earth, at places on the Moon, from the eclipse model; relative to the Sun's irradiance at 1 au.
/// `places`: latitude and longitude in degrees.
fn light_on_the_moon(renderer: &SoftwareRenderer, time: Instant, places: &[(f64, f64)]) -> Vec<[f64; 3]> {
    let prober = Prober { session: &SESSION, renderer };
    let moon = SESSION.catalog().body(NaifId::MOON).expect("the Moon");
    let receiver = Receiver::at(SESSION.ephemeris(), moon, time).expect("placed");
    let occluded_sun = OccludedSun::seen_from(&prober, &receiver, EclipseModelChoice::Requested(EclipseModel::Refracted)).expect("a Sun");
    let point = |(latitude, longitude): &(f64, f64)| ground_point_km(moon.radii_km, *latitude, *longitude, 0.0).0 / moon.radii_km.x;
    let points: Vec<DVec3> = places.iter().map(point).collect();
    // `None`: the Sun's limb darkening is that of the catalog.
    let fractions = occluded_sun.sunlight(&occluded_sun.occluders, &points, None).expect("answers");
    let unocculted = |p: &DVec3| {
        let point_km = receiver.body_from_icrf.transpose() * (*p * moon.radii_km.x);
        (KM_PER_AU / (receiver.body_to_sun_km - point_km).length()).powi(2)
    };
    fractions.iter().zip(&points).map(|(fraction, p)| fraction.map(|channel| channel * unocculted(p))).collect()
}

/// Light refracted past a round Earth to a point `distance_km` behind it, relative to the unocculted Sun's there: an integral over heights
/// and position angles of the limb, from the catalog's numbers. `sun_km`: distance from the point to the Sun; `separation`: of the centres
/// of Sun and Earth, in solar radii. It shares no code with the program, and its 600 steps in height are far finer than the program's
/// refracting layers.
fn light_past_the_limb(distance_km: f64, sun_km: f64, separation: f64) -> [f64; 3] {
    let catalog = SESSION.catalog();
    let (earth, sun) = (catalog.body(NaifId::EARTH).expect("the Earth"), catalog.body(NaifId::SUN).expect("the Sun"));
    let air = earth.atmosphere.as_ref().expect("air");
    let Photometry::Emissive { u1, u2 } = sun.photometry else { panic!("the Sun must be emissive") };
    let radius_km = (earth.radii_km.x * earth.radii_km.z).sqrt();
    let (rayleigh_scale_height_km, ground_refractivity) = (air.species[0].scale_height_km, air.refractivity.expect("bends"));
    let transmittance_at = |height: f64| {
        let half_path_km = ((radius_km + air.top_km).powi(2) - (radius_km + height).powi(2)).sqrt();
        let mut optical_depth = [0.0; 3];
        const STEPS: usize = 40;
        for k in 0..STEPS {
            // The distance from the grazing point grows with u², so steps are short where the air is dense.
            let u = (k as f64 + 0.5) / STEPS as f64;
            let h = (radius_km + height).hypot(half_path_km * u * u) - radius_km;
            for s in &air.species {
                let density = match s.tent_centre_km {
                    Some(centre) => (1.0 - (h - centre).abs() / s.scale_height_km).max(0.0),
                    None => (-h / s.scale_height_km).exp(),
                };
                for (c, depth) in optical_depth.iter_mut().enumerate() {
                    *depth += (s.scattering_per_km[c] + s.absorption_per_km[c]) * density * 4.0 * half_path_km * u / STEPS as f64;
                }
            }
        }
        // Haze and clouds as in src/scene/eclipse/refraction.rs, which gives their sources.
        const CLOUD_CORRELATION_KM: f64 = 300.0;
        const HAZE_SCALE_HEIGHT_KM: f64 = 5.0;
        let path_km = |top: f64| 2.0 * ((radius_km + top).powi(2) - (radius_km + height).powi(2)).max(0.0).sqrt();
        let clear_of_clouds: f64 = [(2.5, 0.27), (6.5, 0.19), (12.0, 0.22)]
            .map(|(top, cover): (f64, f64)| (1.0 - cover).powf(path_km(top) / CLOUD_CORRELATION_KM))
            .iter()
            .product();
        let haze_km = (2.0 * PI * (radius_km + height) * HAZE_SCALE_HEIGHT_KM).sqrt() * (-height / HAZE_SCALE_HEIGHT_KM).exp();
        let haze_per_km = [3.5e-3, 4.0e-3, 5.0e-3];
        std::array::from_fn::<f64, 3, _>(|c| (-optical_depth[c] - haze_per_km[c] * haze_km).exp() * clear_of_clouds)
    };
    // Of a length at the Earth's limb, projected onto the Sun.
    let solar_radii_per_km = sun_km / sun.radii_km.x / distance_km;
    let mut light = [0.0; 3];
    const HEIGHTS: usize = 600;
    const ANGLES: usize = 180;
    for k in 0..HEIGHTS {
        let height_at = |step: f64| air.top_km * (step / HEIGHTS as f64).powi(2);
        let (height, thickness) = (height_at(k as f64 + 0.5), height_at(k as f64 + 1.0) - height_at(k as f64));
        let refractivity = ground_refractivity * (-height / rayleigh_scale_height_km).exp();
        let impact_km = (radius_km + height) * (1.0 + refractivity);
        let bending_rad = refractivity * (2.0 * PI * (radius_km + height) / rayleigh_scale_height_km).sqrt();
        // The Sun is at a finite distance: a ray bent at the Earth meets it shifted by less than at infinity, by this factor.
        let shift_rad = bending_rad * (1.0 - distance_km / sun_km);
        let image_radius = (impact_km - shift_rad * distance_km) * solar_radii_per_km;
        // Area of the ring in square solar radii. Its width is that of `impact_km`, whose derivative by height is not 1, as the
        // refractivity changes with height.
        let area = impact_km
            * thickness
            * (1.0 + refractivity - refractivity * (radius_km + height) / rayleigh_scale_height_km)
            * (2.0 * PI / ANGLES as f64)
            * solar_radii_per_km
            * solar_radii_per_km;
        let mut disc_radiance = [0.0; 3];
        for j in 0..ANGLES {
            let angle = 2.0 * PI * (j as f64 + 0.5) / ANGLES as f64;
            let mu_sq = 1.0 - (image_radius - separation * angle.cos()).powi(2) - (separation * angle.sin()).powi(2);
            if mu_sq > 0.0 {
                let one_minus_mu = 1.0 - mu_sq.sqrt();
                for c in 0..3 {
                    disc_radiance[c] +=
                        (1.0 - u1[c] * one_minus_mu - u2[c] * one_minus_mu * one_minus_mu) / (PI * (1.0 - u1[c] / 3.0 - u2[c] / 6.0));
                }
            }
        }
        if disc_radiance[0] > 0.0 {
            let transmittance = transmittance_at(height);
            for c in 0..3 {
                light[c] += disc_radiance[c] * area * transmittance[c];
            }
        }
    }
    light
}

/// From the edge of the penumbra to the middle of the umbra, at three places on the Moon, in small and large images: the direct Sun and the
/// refracted ring together have the light of the eclipse model, and in the umbra also that of the integral over the limb.
#[test]
fn the_sun_and_its_refracted_ring_have_the_light_of_the_eclipse() {
    let single = renderer(Precision::F32);
    let sizes = [64, 150, 320];
    for (k, minutes) in [-172.0, -140.0, -118.0, -109.0, -104.0, -60.0, -30.0, 0.0, 30.0, 70.0].into_iter().enumerate() {
        let time = instant("2022-11-08T10:59:00Z").plus_seconds(60.0 * minutes);
        let places = [(0.0, 0.0), (50.0, -40.0), (-35.0, 60.0)];
        let (latitude_deg, longitude_deg) = places[k % places.len()];
        let expected = light_on_the_moon(&single, time, &[(latitude_deg, longitude_deg)])[0];
        // In the penumbra a part of the Sun is visible directly: the field must contain all of that part, and its antialiased edge needs a
        // large image. The last crescent, a tenth of a pixel wide in 320 pixels, has 6.6 % more light there than in 2560, and 0.4 % more in 1280.
        let in_penumbra = expected[0] > 2e-3;
        let (side, fov_deg) = match in_penumbra {
            true if expected[0] < 0.1 => (1280, 4.4),
            true => (320, 4.4),
            false => (sizes[k % sizes.len()], 2.6),
        };
        let request = ViewRequest {
            position: Position::Ground { body: NaifId::MOON, latitude_deg, longitude_deg, height_km: 0.0017 },
            ..view_of(NaifId::EARTH, time, fov_deg, side, "sun:-albedo,-glow,-night,-planet-shine")
        };
        let mut scene = SESSION.scene(&request).expect("a scene");
        let measured = irradiance(&scene, &light(&scene, &single));
        // The integral does not include the sunlight that the Earth's air scatters: 0.1 % of the red light in mid-eclipse and 2.5 % of the blue light.
        scene.draws.retain(|d| d.part != BodyPart::Sky);
        let refracted = irradiance(&scene, &light(&scene, &single));
        let [earth, sun] = [NaifId::EARTH, NaifId::SUN].map(|id| scene.body(id).expect("placed").placement.centre_km);
        let separation = orrery::ephemeris::angle_rad(earth, sun) * sun.length() / 695_700.0;
        let unocculted = (KM_PER_AU / sun.length()).powi(2);
        let integral = light_past_the_limb(earth.length(), sun.length(), separation).map(|fraction| fraction * unocculted);
        // Almost no blue light is left in the deep umbra, and sums over layers are inaccurate there: below 5e-6 it is not compared.
        let eclipse_tolerance = if in_penumbra {
            [if expected[0] > 0.1 { 0.01 } else { 0.025 }; 3]
        } else {
            [0.02, 0.025, if measured[2] > 5e-6 { 0.035 } else { f64::INFINITY }]
        };
        let integral_tolerance =
            if in_penumbra { [f64::INFINITY; 3] } else { [0.01, 0.03, if measured[2] > 5e-6 { 0.045 } else { f64::INFINITY }] };
        for c in 0..3 {
            let (by_eclipse, by_integral) = (measured[c] / expected[c] - 1.0, refracted[c] / integral[c] - 1.0);
            println!(
                "{minutes} min, {side} px, channel {c}: {:.3e}, {by_eclipse:+.4} from the eclipse's, {by_integral:+.4} from the integral",
                measured[c]
            );
            assert!(
                by_eclipse.abs() < eclipse_tolerance[c]
                    // Where the integral is not compared, the ratio may be NaN.
                    && (integral_tolerance[c].is_infinite() || by_integral.abs() < integral_tolerance[c]),
                "{minutes} min, channel {c}: {by_eclipse} {by_integral}"
            );
        }
        // At 70 minutes the place is near the edge of the umbra, where the light comes through higher air and is less red.
        assert!(in_penumbra || measured[0] > 1.3 * measured[2] || minutes > 60.0, "the ring is red: {measured:?}");
    }
}

/// A camera behind the body as seen from the Sun: `behind` radii along the axis of the shadow, `aside` radii off it.
fn view_from_behind(body: NaifId, behind: f64, aside: f64, side: u32, fov_deg: f64, effects: &str) -> ViewRequest {
    let time = instant("2022-11-08T10:59:00Z");
    let catalog_body = SESSION.catalog().body(body).expect("a body");
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("placed").state.pos_km.normalize();
    let across = to_sun.any_orthonormal_vector();
    let offset_km = (across * aside - to_sun * behind) * catalog_body.radii_km.x;
    ViewRequest { position: Position::Offset { body, offset_km, axes: Axes::Icrf }, ..view_of(body, time, fov_deg, side, effects) }
}

/// The light does not depend on the image size: for the entire ring from the Moon's distance and from far away, and for an arc of it from
/// 20 radii. At smaller distances it does: from 8 radii, an arc around a disc of 25 pixels has 21 % less light than around one of 300.
#[test]
fn the_light_is_the_same_at_every_size() {
    let single = renderer(Precision::F32);
    for (radii, aside) in [(60.3_f64, 0.12), (157.0, 0.12), (20.0, 0.8)] {
        let fov_deg = 2.6 * (1.0 / radii).asin().to_degrees();
        let sums = [20, 33, 64, 129, 400]
            .map(|side| limb_irradiance(&view_from_behind(NaifId::EARTH, radii, aside, side, fov_deg, "-clouds,-night"), &single));
        let largest = sums[sums.len() - 1];
        assert!(largest[0] > 1e-9 && largest[0] > largest[2], "{radii}: {largest:?}");
        for (k, sum) in sums.iter().enumerate() {
            for c in 0..3 {
                println!("{radii} {k} {c}: {:.4}", sum[c] / largest[c]);
                // Measured: 1.1 % for entire rings, 4.7 % for an arc around a disc of 15 pixels.
                assert!(
                    (sum[c] / largest[c] - 1.0).abs() < if radii > 50.0 { 0.02 } else { [0.08, 0.05, 0.03, 0.03, 0.03][k] },
                    "{radii} radii, size {k}, channel {c}: {sum:?} for {largest:?}"
                );
            }
        }
    }
}

/// Seen from geostationary orbit, the Sun sets behind the Earth: its light falls without a step from that of the full Sun to that of the
/// last refracted image.
#[test]
fn refracted_sunlight_falls_smoothly_as_the_sun_sets() {
    let single = renderer(Precision::F32);
    let radii: f64 = 42_164.0 / 6378.137;
    let limb_angle = (1.0 / radii).asin();
    let mut before: Option<f64> = None;
    let mut reddest: f64 = 0.0;
    for step in 0..57 {
        // Height of the Sun's centre above the limb, in solar radii.
        let height = 2.0 - 0.125 * f64::from(step);
        // The Sun's angular radius is 0.00466 rad.
        let angle = limb_angle + height * 0.00466;
        let (sin, cos) = angle.sin_cos();
        let mut request = view_from_behind(NaifId::EARTH, radii * cos, radii * sin, 160, 2.2, "sun:-albedo,-glow,-night,-clouds");
        let to_sun = SESSION.ephemeris().state(NaifId::SUN, NaifId::EARTH, request.time, None).expect("placed").state.pos_km;
        let Position::Offset { offset_km, .. } = request.position else { panic!("an offset") };
        request.look = Look::Along { direction: to_sun - offset_km, axes: Axes::Icrf };
        let scene = SESSION.scene(&request).expect("a scene");
        let sum = irradiance(&scene, &light(&scene, &single));
        println!("{height:.2}: {sum:?}");
        if let Some(before) = before {
            assert!(sum[0] <= before * 1.003, "{height}: {} after {before}", sum[0]);
            assert!(sum[0] > before * 0.25 - 1e-7, "{height}: {} after {before}", sum[0]);
        }
        if step == 0 {
            assert!((sum[0] - 1.0).abs() < 0.05, "{sum:?}");
        }
        reddest = reddest.max(if sum[0] > 1e-6 { sum[0] / sum[2].max(1e-12) } else { 0.0 });
        before = Some(sum[0]);
    }
    assert!(reddest > 5.0, "the last light is red: {reddest}");
}

/// f32 gives the same image as f64 near the Earth, from the Moon's distance and from far away, for the entire disc and for a magnified
/// limb.
#[test]
fn single_precision_suffices_at_every_distance() {
    let [single, double] = [Precision::F32, Precision::F64].map(renderer);
    // The limb's point nearest to the Sun.
    let at_limb = |request: &ViewRequest| {
        let sun = SESSION.ephemeris().state(NaifId::SUN, NaifId::EARTH, request.time, None).expect("placed").state.pos_km;
        let Position::Offset { offset_km, .. } = request.position else { panic!("an offset") };
        let down = -offset_km.normalize();
        let aside = (sun - offset_km).reject_from_normalized(down).normalize();
        let limb_angle = (6378.0 / offset_km.length()).asin() * 1.002;
        Look::Along { direction: down * limb_angle.cos() + aside * limb_angle.sin(), axes: Axes::Icrf }
    };
    // Distances along the shadow's axis and off it, in radii, of a camera at this distance that sees the Sun at the limb.
    let sun_at_limb = |radii: f64| (radii * (1.0 / radii).asin().cos(), 1.0);
    // Magnified views of the limb, then views of the entire ring: from a height of 400 km to a distance of 1.2 million km.
    for (behind, aside, fov_deg, magnified) in [
        (sun_at_limb(1.06).0, sun_at_limb(1.06).1, 3.0, true),
        (sun_at_limb(1.06).0, sun_at_limb(1.06).1, 60.0, true),
        (sun_at_limb(6.6).0, sun_at_limb(6.6).1, 1.5, true),
        (60.3, 0.85, 0.1, true),
        (190.0, 0.8, 0.05, true),
        (60.3, 0.3, 2.5, false),
        (190.0, 0.3, 0.8, false),
    ] {
        let mut request = view_from_behind(NaifId::EARTH, behind, aside, 72, fov_deg, "-clouds,-night,-glow");
        if magnified {
            request.look = at_limb(&request);
        }
        let scene = SESSION.scene(&request).expect("a scene");
        assert_eq!(scene.refracted_limbs.len(), 1, "{behind}");
        let [in_single, in_double] = [&single, &double].map(|renderer| light(&scene, renderer));
        let brightest = in_double.iter().map(|p| p[0]).fold(0.0, larger);
        let worst = in_single.iter().zip(&in_double).map(|(s, d)| (s[0] - d[0]).abs()).fold(0.0, larger) / brightest;
        println!("{behind} {fov_deg}: {worst:e} of {brightest:e}");
        assert!(worst > 0.0, "{behind} radii, {fov_deg} degrees: both images have the same bits, so both were computed in f32");
        assert!(brightest > 1e-3 && worst < 0.5 / 256.0, "{behind} radii, {fov_deg} degrees: off by {worst} of the brightest, {brightest}");
    }
}

/// The decision states its reason, and the effect is off without air, when switched off, in tiny images, and from positions that no
/// refracted light reaches.
#[test]
fn the_decision_on_the_refracted_limb_states_its_reason() {
    let decision_of = |request: &ViewRequest| {
        let scene = SESSION.scene(request).expect("a scene");
        let body = scene.body(request.target.expect("a target")).expect("there").clone();
        let found = body.decisions.iter().find(|d| d.effect == "refracted-limb").cloned();
        assert_eq!(found.as_ref().is_some_and(|d| d.on), !scene.refracted_limbs.is_empty());
        found.map(|d| (d.on, d.reason.to_string()))
    };
    let assert_decision = |request: &ViewRequest, should_be_on: bool, part_of_reason: &str| {
        let (is_on, reason) = decision_of(request).expect("a decision");
        assert!(is_on == should_be_on && reason.contains(part_of_reason), "{is_on}: {reason}");
    };
    assert_decision(&view_from_behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, ""), true, "× white (threshold");
    assert_decision(&view_from_behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, "-refracted-limb"), false, "set by you");
    assert_decision(&view_from_behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, "-atmosphere"), false, "switched off");
    // No layer shows the Sun: from the Sun's side, from behind Mars, whose thin air bends light little, from behind Jupiter, and from 45 degrees off the axis.
    assert_decision(&view_from_behind(NaifId::EARTH, -60.0, 0.1, 64, 3.0, ""), false, "no layer");
    assert_decision(&view_from_behind(NaifId(499), 40.0, 0.1, 64, 3.0, ""), false, "no layer");
    assert_decision(&view_from_behind(NaifId(599), 60.0, 0.1, 64, 3.0, ""), false, "no layer");
    assert_decision(&view_from_behind(NaifId::EARTH, 6.0, 6.0, 64, 25.0, ""), false, "no layer");
    assert_decision(&view_from_behind(NaifId::EARTH, 60.0, 0.1, 4, 3.0, ""), false, "px across");
    assert_eq!(decision_of(&view_from_behind(NaifId(999), 60.0, 0.1, 64, 3.0, "")), None, "the catalog has no refractivity for Pluto");
}
