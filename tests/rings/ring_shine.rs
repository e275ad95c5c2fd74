//! Ring-shine on the planet: the light that the shader reads from its table, against a plain sum over the rings' area; where it vanishes,
//! and its upper bound.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId, Ring};
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::draw::{BodyPart, PixelView};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::scene::ring_shine::RingShineGeometry;
use orrery::time::Instant;
use std::f64::consts::{PI, TAU};

const MARS: NaifId = NaifId(499);
const JUPITER: NaifId = NaifId(599);
const SATURN: NaifId = NaifId(699);
const URANUS: NaifId = NaifId(799);
const NEPTUNE: NaifId = NaifId(899);
const SIDE: u32 = 96;
/// When the Sun is 26 degrees north of Saturn's ring plane.
const OPEN: &str = "2017-05-17T00:00:00Z";
/// When the Sun is 3 degrees north of Saturn's ring plane.
const NEARLY_CLOSED: &str = "2024-09-08T00:00:00Z";

/// Saturn's night side with ring-shine, seen from 3 radii on the side away from the Sun.
fn night_view(time: &str, effects: &str, pixel_view: PixelView) -> (Scene, Vec<[f32; 4]>) {
    let towards_sun = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
    let mut request = ViewRequest {
        position: towards_sun,
        width: SIDE,
        height: SIDE,
        pixel_view,
        effects: EffectOverrides::parse(&format!("+ring-shine,-planet-shine,-rings,-atmosphere,-eclipse,{effects}")).expect("effects"),
        exposure: ExposureRequest::Stops(0.0),
        ..ViewRequest::of(SATURN, Instant::parse(time).expect("a time"))
    };
    // From the Sun's side to the opposite side, at 3 equatorial radii of 60 268 km.
    let from_sun = SESSION.scene(&request).expect("a scene");
    let away_from_sun = from_sun.body(SATURN).expect("Saturn").placement.centre_km.normalize();
    let offset_km = away_from_sun * 3.0 * 60_268.0;
    request.position = Position::Offset { body: SATURN, offset_km, axes: orrery::scene::request::Axes::Icrf };
    let drawn = SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
    (drawn.scene, drawn.frame.hdr)
}

/// Whether a pixel is on the disc and more than a pixel from the limb.
fn is_well_inside(scene: &Scene, middle: DVec2) -> bool {
    let placement = &scene.body(SATURN).expect("Saturn").placement;
    let neighbours = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
    neighbours.iter().all(|step| scene.camera.surface_under_pixel(placement, middle + 1.5 * step).is_some())
}

/// A deliberate error in the sum, which the comparison must detect.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    NoGlobeShadow,
    SidesExchanged,
}

/// A narrow annulus of the rings. `radius`: of its middle, in the planet's equatorial radii.
struct Annulus {
    radius: f64,
    tau_normal: f64,
    albedo: DVec3,
}

/// `count` annuli of equal width from radius `from` to radius `to`, in units of `unit_km`, without those in gaps. Where rings overlap, the
/// last one counts.
fn annuli(rings: &[Ring], unit_km: f64, from: f64, to: f64, count: usize) -> Vec<Annulus> {
    let annulus = |k: usize| {
        let radius = from + (to - from) * (k as f64 + 0.5) / count as f64;
        let ring = rings.iter().rfind(|ring| (ring.inner_km..ring.outer_km).contains(&(radius * unit_km)))?;
        (ring.tau_normal > 0.0).then(|| Annulus { radius, tau_normal: ring.tau_normal, albedo: DVec3::from_array(ring.albedo) })
    };
    (0..count).filter_map(annulus).collect()
}

/// Irradiance at a point of the ellipsoid, `place`, per unit of sunlight, summed over every visible piece of ring. `width`: radial width of an
/// annulus. Lengths are in equatorial radii. `sun`: the Sun's direction.
fn summed_ring_shine(annuli: &[Annulus], width: f64, polar_radius: f64, place: DVec3, sun: DVec3, fault: Fault) -> DVec3 {
    const PIECES_PER_ANNULUS: usize = 300;
    // The mean over all directions of (pi - phase angle)^3.09, by which the phase function below is divided.
    let mean_power =
        (0..2000).map(|k| (f64::from(k) + 0.5) * PI / 2000.0).map(|angle| 0.5 * angle.powf(3.09) * angle.sin() * PI / 2000.0).sum::<f64>();
    let normal = DVec3::new(place.x, place.y, place.z / (polar_radius * polar_radius)).normalize();
    let mut sum = DVec3::ZERO;
    for &Annulus { radius, tau_normal: tau, albedo } in annuli {
        for k in 0..PIECES_PER_ANNULUS {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / PIECES_PER_ANNULUS as f64).sin_cos();
            let piece = DVec3::new(radius * cos, radius * sin, 0.0);
            let to_ring = piece - place;
            let cos_incidence = normal.dot(to_ring.normalize());
            if cos_incidence <= 0.0 {
                continue;
            }
            // Skip the piece if its path to the Sun meets the ellipsoid.
            let to_unit_sphere = DVec3::new(1.0, 1.0, 1.0 / polar_radius);
            let (from, along) = (piece * to_unit_sphere, (sun * to_unit_sphere).normalize());
            let closest = from - along * from.dot(along);
            if fault != Fault::NoGlobeShadow && from.dot(along) < 0.0 && closest.length() < 1.0 {
                continue;
            }
            let to_planet = -to_ring.normalize();
            // Cosines of the angles from the ring's normal to the planet and to the Sun.
            let (mu, mu0) = (to_planet.z.abs(), sun.z.abs());
            let phase_angle = to_planet.dot(sun).clamp(-1.0, 1.0).acos();
            let phase = (PI - phase_angle).powf(3.09) / mean_power * (1.0 + 0.32 / (1.0 + (phase_angle / 2.0).tan() / 0.0045));
            let same_side = (to_planet.z * sun.z > 0.0) != (fault == Fault::SidesExchanged);
            let scattered = if same_side {
                mu0 / (mu + mu0) * (1.0 - (-tau / mu - tau / mu0).exp())
            } else if (mu - mu0).abs() < 1e-6 {
                tau / mu * (-tau / mu).exp()
            } else {
                mu0 / (mu - mu0) * ((-tau / mu).exp() - (-tau / mu0).exp())
            };
            let solid_angle = radius * width * TAU / PIECES_PER_ANNULUS as f64 * mu / to_ring.length_squared();
            sum += albedo * (0.25 * phase * scattered * solid_angle * cos_incidence / PI);
        }
    }
    sum
}

/// The greatest difference between image and sum over a grid of pixels on the night side, relative to the brightest pixel; and the brightest
/// pixel's light per unit of sunlight.
fn greatest_error(time: &str, fault: Fault) -> (f64, f64) {
    const ANNULI: usize = 600;
    let (scene, hdr) = night_view(time, "", PixelView::Sunlight);
    let catalog = Catalog::embedded();
    let saturn = catalog.body(SATURN).expect("Saturn");
    let unit_km = saturn.radii_km.x;
    // From the D ring to the F ring, in equatorial radii.
    let (from, to) = (1.1, 2.34);
    let annuli = annuli(&saturn.rings, unit_km, from, to, ANNULI);
    let draw = scene.draws.iter().find(|d| d.part == BodyPart::Globe).expect("a globe");
    assert!(draw.features.ring_shine);
    let light = draw.uniforms.lights[0];
    let sun = light.direction_in_body.as_dvec3().normalize();
    let placement = &scene.body(SATURN).expect("Saturn").placement;
    let brightest = hdr.iter().map(|p| f64::from(p[0] / light.irradiance.x)).fold(0.0, larger);
    let (mut greatest, mut compared): (f64, usize) = (0.0, 0);
    for (k, pixel) in hdr.iter().enumerate() {
        let (x, y) = (k as u32 % SIDE, k as u32 / SIDE);
        if x % 9 != 4 || y % 5 != 2 {
            continue;
        }
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let Some(hit) = scene.camera.surface_under_pixel(placement, middle) else { continue };
        let normal = (hit / placement.radii_km).normalize();
        // Skip the day side, which has direct sunlight.
        if normal.dot(sun) > 0.0 || !is_well_inside(&scene, middle) {
            continue;
        }
        let polar_radius = placement.radii_km.z / unit_km;
        let place = hit * placement.radii_km / unit_km;
        let expected = summed_ring_shine(&annuli, (to - from) / ANNULI as f64, polar_radius, place, sun, fault);
        for c in 0..3 {
            let found = f64::from(pixel[c] / light.irradiance.x);
            greatest = larger(greatest, (found - expected[c]).abs() / brightest);
        }
        compared += 1;
    }
    assert!(compared > 50, "{compared} places");
    (greatest, brightest)
}

#[test]
fn night_light_agrees_with_the_sum_over_the_rings() {
    for time in [OPEN, NEARLY_CLOSED] {
        let (error, brightest) = greatest_error(time, Fault::None);
        println!("{time}: {error:.2e} of the brightest place, {brightest:.3e} of sunlight");
        assert!(error < 0.01, "{time}: {error:e} of the brightest place");
        // At most a fifth of sunlight: the rings are as bright as the globe and fill up to half of the sky.
        assert!((2e-4..0.2).contains(&brightest), "{time}: {brightest:e}");
    }
    // Negative controls.
    assert!(greatest_error(OPEN, Fault::NoGlobeShadow).0 > 0.03);
    assert!(greatest_error(OPEN, Fault::SidesExchanged).0 > 0.03);
}

#[test]
fn equator_and_poles_get_no_ring_shine() {
    let (scene, lit) = night_view(OPEN, "", PixelView::Final);
    let (_, dark) = night_view(OPEN, "-ring-shine", PixelView::Final);
    let placement = &scene.body(SATURN).expect("Saturn").placement;
    let sun = scene.draws[0].uniforms.lights[0].direction_in_body.as_dvec3();
    let (mut lit_by_rings, mut near_poles) = (0, 0);
    for k in 0..lit.len() {
        let middle = DVec2::new(f64::from(k as u32 % SIDE) + 0.5, f64::from(k as u32 / SIDE) + 0.5);
        let Some(unit) = scene.camera.surface_under_pixel(placement, middle) else { continue };
        if (unit / placement.radii_km).normalize().dot(sun) > -0.02 || !is_well_inside(&scene, middle) {
            continue;
        }
        assert_eq!(&dark[k][..3], &[0.0; 3], "light on a night without moons, air and rings");
        lit_by_rings += usize::from(lit[k][0] > 0.0);
        // The F ring, at 2.33 radii the outermost in the table, sets at a parametric latitude of 64.6 degrees, whose sine is 0.903.
        if unit.z.abs() > 0.91 {
            assert_eq!(&lit[k][..3], &[0.0; 3], "lit by rings below the horizon");
            near_poles += 1;
        }
    }
    assert!(lit_by_rings > 1000 && near_poles > 5, "{lit_by_rings} pixels lit by rings, {near_poles} near the poles");
    // The table contains light divided by height above the equator. This quotient is finite, so the light vanishes at the equator: a
    // hundredth of a degree from it the light is less than a fiftieth of the maximum.
    let shine = scene.draws[0].uniforms.ring.shine.clone().expect("a table");
    let at_equator = shine.texels[..4 * orrery::scene::ring_shine::COLUMNS].iter().copied().fold(0.0, larger);
    assert!(f64::from(at_equator) * 0.01f64.to_radians() < 0.02 * shine.brightest, "{at_equator}");
}

/// Compares the total ring-shine on the globe with the total sunlight on the rings.
#[test]
fn ring_shine_never_exceeds_the_sunlight_on_the_rings() {
    use orrery::scene::ring_shine::{COLUMNS, ROWS, RingShineCache};
    let rings = [Ring { name: "x".into(), inner_km: 1.05, outer_km: 2.5, tau_normal: 3.0, albedo: [1.0; 3], dust_fraction: 0.0 }];
    let rings: Vec<&Ring> = rings.iter().collect();
    for sin_elevation in [0.02, 0.4, 0.95] {
        let geometry = RingShineGeometry { rings: &rings, radius_km: 1.0, polar_ratio: 1.0, sin_elevation, sun_tangent: 5e-4 };
        let shine = geometry.shine(&RingShineCache::default()).expect("a table");
        let mut power = 0.0;
        for row in 0..2 * ROWS {
            // Heights increase with the square of the row number; each row covers half the interval to either neighbour.
            let row_height = |k: f64| shine.max_height * (k.clamp(0.0, (ROWS - 1) as f64) / (ROWS - 1) as f64).powi(2);
            let k = (row % ROWS) as f64;
            let (height, band) = (row_height(k), row_height(k + 0.5) - row_height(k - 0.5));
            for column in 0..COLUMNS {
                let end_weight = if column == 0 || column == COLUMNS - 1 { 0.5 } else { 1.0 };
                let light = f64::from(shine.texels[4 * (row * COLUMNS + column)]) * height;
                power += 2.0 * end_weight * PI / (COLUMNS - 1) as f64 * band * light;
            }
        }
        let sunlight_on_rings = sin_elevation * PI * (2.5f64.powi(2) - 1.05f64.powi(2));
        assert!(
            power > 0.01 * sunlight_on_rings && power < 0.5 * sunlight_on_rings,
            "sine {sin_elevation}: {power} of {sunlight_on_rings}"
        );
    }
}

#[test]
fn ring_shine_is_drawn_where_visible_and_its_reason_is_given() {
    let decision = |body: NaifId, effects: &str| {
        let request = ViewRequest {
            effects: EffectOverrides::parse(effects).expect("effects"),
            ..ViewRequest::of(body, Instant::parse(OPEN).expect("a time"))
        };
        let scene = Scene::build(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a scene");
        let features = scene.draws.iter().find(|d| d.body == body && d.part == BodyPart::Globe).expect("a globe").features;
        let ring_shine_decision = scene.body(body).expect("a body").decisions.iter().find(|d| d.effect == "ring-shine").cloned();
        (features.ring_shine, ring_shine_decision)
    };
    let (on, ring_shine_decision) = decision(SATURN, "");
    assert!(on && ring_shine_decision.is_some_and(|d| d.on && d.reason.to_string().contains("× white (threshold")));
    for body in [JUPITER, URANUS, NEPTUNE] {
        let (on, ring_shine_decision) = decision(body, "");
        assert!(!on && ring_shine_decision.is_some_and(|d| !d.on && d.reason.to_string().contains("× white (threshold")), "{body:?}");
    }
    assert!(!decision(SATURN, "-ring-shine").0);
    assert!(decision(URANUS, "+ring-shine").0, "Uranus has ring-shine, although invisible");
    assert_eq!(decision(MARS, "+ring-shine"), (false, None), "Mars has no rings");
}
