//! An eclipse in pixels: the Sun's light in pictures from the ground gives the contacts and the magnitude that the geometry of discs gives.
//!
//! Light in a picture becomes a distance of the two discs' centres by the overlap of a limb-darkened disc, integrated here; distances before and after a contact
//! give its instant. Air, glare, corona and map are off: they add or take light that the overlap does not know.

use super::{EPHEMERIS, IAU, at};
use crate::support::session::SESSION;
use orrery::Instant;
use orrery::catalog::{NaifId, Photometry};
use orrery::events::{LocalCircumstances, Place, solar_eclipses};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// Green of the Sun's limb darkening, 1 - u1 (1 - mu) - u2 (1 - mu)^2, by the catalog.
fn limb_darkening() -> [f64; 2] {
    let sun = IAU.body(NaifId::SUN).expect("the Sun");
    let Photometry::Emissive { u1, u2 } = &sun.photometry else { panic!("it shines") };
    [u1[1], u2[1]]
}

/// The part of the Sun's light that a disc of radius `k` hides at a distance `s` of the centres, in solar radii.
fn hidden(k: f64, s: f64, [u1, u2]: [f64; 2]) -> f64 {
    const RINGS: u32 = 4000;
    let (mut all, mut behind) = (0.0, 0.0);
    for ring in 0..RINGS {
        // Rings of equal steps in mu: fine at the limb, where contacts are.
        let mu = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let r = (1.0 - mu * mu).sqrt();
        let light = mu * (1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2));
        let cosine = (r * r + s * s - k * k) / (2.0 * r * s).max(1e-300);
        all += light;
        behind += light * cosine.clamp(-1.0, 1.0).acos() / PI;
    }
    behind / all
}

/// The distance at which so much is hidden, between two distances.
fn distance_of(part: f64, k: f64, (mut near, mut far): (f64, f64), law: [f64; 2]) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        if hidden(k, middle, law) > part { near = middle } else { far = middle }
    }
    0.5 * (near + far)
}

/// The Sun and the Moon as discs alone.
const DISCS: &str = "-atmosphere,-glow,-corona,-albedo,-points";

/// The Sun's green light in a picture from a place, and the Moon's angular radius in the Sun's.
fn seen_from(place: Place, time: Instant, effects: &str) -> (f64, f64) {
    let request = ViewRequest {
        width: 480,
        height: 480,
        fov_deg: Some(0.6),
        exposure: ExposureRequest::Stops(-15.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        layers: Layers::parse("-stars").expect("a layer"),
        position: Position::Ground {
            body: NaifId::EARTH,
            latitude_deg: place.latitude_deg,
            longitude_deg: place.longitude_deg,
            height_km: place.height_km,
        },
        ..ViewRequest::of(NaifId::SUN, time)
    };
    let drawn = SESSION.draw(&request, SAMPLING, true).expect("draws");
    let radius = |body: NaifId| {
        let b = drawn.scene.body(body).expect("a body");
        (b.placement.radii_km.x / b.distance_km).asin()
    };
    let light = drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum();
    (light, radius(NaifId::MOON) / radius(NaifId::SUN))
}

fn circumstances(day: &str, place: Place) -> LocalCircumstances {
    let from = at(day);
    let eclipses = solar_eclipses(&IAU, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses");
    eclipses[0].seen_from(place).expect("an eclipse")
}

/// Instant at which a line through the points is 0: least squares.
fn zero_of(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>();
    mx - my / slope
}

#[test]
fn contacts_and_magnitude_from_pixels_are_those_of_the_geometry() {
    let law = limb_darkening();
    let place = |latitude_deg: f64, longitude_deg: f64| Place { latitude_deg, longitude_deg, height_km: 0.0017 };
    // Total at Dallas, annular at Albuquerque, partial at New York.
    for (day, place) in [("2024-04-08", place(32.78, -96.80)), ("2023-10-14", place(35.08, -106.65)), ("2024-04-08", place(40.71, -74.01))]
    {
        let expected = circumstances(day, place);
        let first = expected.contacts[0].time;
        let whole = seen_from(place, first.plus_seconds(-120.0), DISCS).0;
        for contact in &expected.contacts {
            let outer = matches!(contact.name, "C1" | "C4");
            // While the Sun is partly hidden: after C1 and C3, before C2 and C4.
            let side = if matches!(contact.name, "C1" | "C3") { 1.0 } else { -1.0 };
            let points: Vec<(f64, f64)> = [40.0, 60.0, 80.0, 100.0]
                .iter()
                .map(|s| {
                    let (light, k) = seen_from(place, contact.time.plus_seconds(side * s), DISCS);
                    let distance = distance_of(1.0 - light / whole, k, ((k - 1.0).abs(), 1.0 + k), law);
                    (side * s, distance - if outer { 1.0 + k } else { (k - 1.0).abs() })
                })
                .collect();
            let off_s = zero_of(&points);
            assert!(off_s.abs() < 1.0, "{day} {} from pixels: {off_s} s", contact.name);
            // The comparison must be able to fail: a Moon that is 0.2 % larger meets the Sun seconds earlier.
            let larger: Vec<_> = points.iter().map(|p| (p.0, p.1 - 0.004)).collect();
            assert!(zero_of(&larger).abs() > 1.0);
        }
        if expected.contacts.len() == 2 {
            let (light, k) = seen_from(place, expected.maximum.time, DISCS);
            let distance = distance_of(1.0 - light / whole, k, ((k - 1.0).abs(), 1.0 + k), law);
            let magnitude = 0.5 * (1.0 + k - distance);
            assert!((magnitude - expected.magnitude).abs() < 1e-3);
        } else {
            let (light, k) = seen_from(place, expected.maximum.time, DISCS);
            assert!(
                (k - expected.magnitude).abs() < 1e-3,
                "{day}: the Moon is {k} times as wide as the Sun, by the geometry {}",
                expected.magnitude
            );
            // In totality no light is left; in an annulus what the Moon leaves, wherever in the disc it stands.
            let (middle, limb) = (1.0 - hidden(k, 1e-9, law), 1.0 - hidden(k, (k - 1.0).abs(), law));
            assert!(
                if k > 1.0 { light == 0.0 } else { (middle - 1e-3..limb + 1e-3).contains(&(light / whole)) },
                "{day}: {}",
                light / whole
            );
        }
    }
}

/// Without air the Sun is as bright at any height: to f32's rounding, from two hours before the eclipse to its first contact. With it the light grows.
#[test]
fn the_sun_keeps_its_light_where_the_air_is_switched_off() {
    let place = Place { latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.0017 };
    let first = circumstances("2024-04-08", place).contacts[0].time;
    let over_two_hours = |effects: &str| {
        let [early, late] = [-7200.0, -60.0].map(|s| seen_from(place, first.plus_seconds(s), effects).0);
        late / early - 1.0
    };
    let (bare, aired) = (over_two_hours(DISCS), over_two_hours("+atmosphere,-glow,-corona,-albedo,-points"));
    assert!(bare.abs() < 1e-5 && aired > 0.01, "{bare:e} without air, {aired} with it");
}
