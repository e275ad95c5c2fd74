//! Contacts and magnitude of eclipses, measured from the Sun's light in images drawn from the ground, against the geometry of discs.
//!
//! This file integrates the light that a disc in front of the limb-darkened Sun hides. By this integral the light of an image gives the distance
//! between the centres of Sun and Moon, and distances near a contact give the contact's instant. Air, glare, corona and map are off, because the
//! integral does not include their light.

use super::{EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use crate::support::session::SESSION;
use glam::{DMat4, DVec4};
use orrery::catalog::{NaifId, Photometry};
use orrery::events::{GeodeticPosition, LocalCircumstances, solar_eclipses};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use orrery::{FrameImages, Instant};
use std::f64::consts::PI;

/// The height of a standing observer's eyes.
const EYE_HEIGHT_KM: f64 = 0.0017;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// Limb darkening of the Sun in green, 1 - u1 (1 - mu) - u2 (1 - mu)^2, from the catalog.
fn limb_darkening() -> [f64; 2] {
    let sun = IAU_RADII.body(NaifId::SUN).expect("the Sun");
    let Photometry::Emissive { u1, u2 } = &sun.photometry else { panic!("the Sun must be emissive") };
    [u1[1], u2[1]]
}

/// Fraction of the Sun's light that a disc hides. `radius`: the disc's. `distance`: between the centres. Both are in solar radii.
fn hidden_fraction(radius: f64, distance: f64, [u1, u2]: [f64; 2]) -> f64 {
    const RINGS: u32 = 4000;
    let (mut total, mut hidden) = (0.0, 0.0);
    for ring in 0..RINGS {
        // Equal steps of mu, the cosine at the Sun's surface, make rings that are narrow at the limb, where contacts occur.
        let mu = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let r = (1.0 - mu * mu).sqrt();
        let light = mu * (1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2));
        let cosine = (r * r + distance * distance - radius * radius) / (2.0 * r * distance).max(1e-300);
        total += light;
        hidden += light * cosine.clamp(-1.0, 1.0).acos() / PI;
    }
    hidden / total
}

/// The distance between the centres, from `near` to `far`, at which a disc of this radius hides this fraction of the light.
fn distance_for(fraction: f64, radius: f64, (mut near, mut far): (f64, f64), darkening: [f64; 2]) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        if hidden_fraction(radius, middle, darkening) > fraction { near = middle } else { far = middle }
    }
    0.5 * (near + far)
}

/// Effects that leave the Sun and the Moon as plain discs.
const DISCS_ONLY: &str = "-atmosphere,-glow,-corona,-albedo,-points";

/// The Sun's green light in an image drawn from a place, divided by the square of the Sun's angular radius (which changes by 1e-4 from
/// first to last contact); and the ratio of the Moon's angular radius to the Sun's.
fn light_and_radius_ratio(place: GeodeticPosition, time: Instant, effects: &str) -> (f64, f64) {
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
    let drawn = SESSION.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("draws");
    let angular_radius_rad = |body: NaifId| {
        let placed = drawn.scene.body(body).expect("a body");
        (placed.placement.radii_km.x / placed.distance_km).asin()
    };
    let light: f64 = drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum();
    (light / angular_radius_rad(NaifId::SUN).powi(2), angular_radius_rad(NaifId::MOON) / angular_radius_rad(NaifId::SUN))
}

fn circumstances(day: &str, place: GeodeticPosition) -> LocalCircumstances {
    let from = parse_time(day);
    let eclipses = solar_eclipses(&IAU_RADII, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses");
    eclipses[0].seen_from(place).expect("an eclipse")
}

/// The instants of the images near a contact, as seconds away from it, into the partial phase. A pixel is 4.5 arcseconds; the Moon moves by a
/// pixel in ten seconds.
const IMAGE_OFFSETS_S: [f64; 4] = [40.0, 60.0, 80.0, 100.0];

/// Measures an eclipse in images that are drawn as seen from a place.
struct EclipseImages {
    place: GeodeticPosition,
    darkening: [f64; 2],
    /// The Sun's light before the first contact.
    unobscured_light: f64,
}

impl EclipseImages {
    /// Distance between the centres, and the Moon's radius, at an instant; both in solar radii.
    fn distance_and_moon_radius(&self, time: Instant) -> (f64, f64) {
        let (light, moon_radius) = light_and_radius_ratio(self.place, time, DISCS_ONLY);
        let near_and_far = ((moon_radius - 1.0).abs(), 1.0 + moon_radius);
        (distance_for(1.0 - light / self.unobscured_light, moon_radius, near_and_far, self.darkening), moon_radius)
    }

    /// Seconds from an outer contact's expected time to its measured time, by a straight line fitted to the distances. `side`: 1 if the
    /// partial phase follows, -1 if it precedes. `enlargement`: added to the Moon's radius, in solar radii.
    fn outer_contact_error_s(&self, time: Instant, side: f64, enlargement: f64) -> f64 {
        let points = IMAGE_OFFSETS_S.map(|s| {
            let (distance, moon_radius) = self.distance_and_moon_radius(time.plus_seconds(side * s));
            (side * s, distance - (1.0 + moon_radius + enlargement))
        });
        let n = points.len() as f64;
        let (mean_s, mean_distance) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let slope = points.iter().map(|p| (p.0 - mean_s) * (p.1 - mean_distance)).sum::<f64>()
            / points.iter().map(|p| (p.0 - mean_s).powi(2)).sum::<f64>();
        mean_s - mean_distance / slope
    }

    /// The same for second and third contact. Between them the distance has a sharp minimum, but its square is smooth: nearly a parabola,
    /// skewed by the Earth's rotation. The least-squares fit of a cubic to the square uses images before second and after third contact.
    fn inner_contact_errors_s(&self, [second, third]: [Instant; 2], enlargement: f64) -> [f64; 2] {
        let half_s = 0.5 * seconds_after(third, second);
        let middle = second.plus_seconds(half_s);
        // The normal equations of the fit. The unit of time is `half_s`, so the contacts are expected at -1 and 1.
        let (mut matrix, mut right_side, mut last_moon_radius) = (DMat4::ZERO, DVec4::ZERO, 0.0);
        for seconds in IMAGE_OFFSETS_S.into_iter().flat_map(|s| [-half_s - s, half_s + s]) {
            let (distance, moon_radius) = self.distance_and_moon_radius(middle.plus_seconds(seconds));
            let x = seconds / half_s;
            let powers = DVec4::new(1.0, x, x * x, x * x * x);
            matrix += DMat4::from_cols(powers, powers * x, powers * x * x, powers * x * x * x);
            right_side += powers * distance * distance;
            last_moon_radius = moon_radius;
        }
        let coefficients = matrix.inverse() * right_side;
        let squared_at_contact = ((last_moon_radius - 1.0).abs() + enlargement).powi(2);
        [-1.0_f64, 1.0].map(|expected| {
            // Newton's method from the expected contact.
            let mut x = expected;
            for _ in 0..20 {
                let value = coefficients.dot(DVec4::new(1.0, x, x * x, x * x * x)) - squared_at_contact;
                x -= value / coefficients.dot(DVec4::new(0.0, 1.0, 2.0 * x, 3.0 * x * x));
            }
            half_s * (x - expected)
        })
    }
}

#[test]
fn contacts_and_magnitude_from_pixels_agree_with_the_geometry() {
    let darkening = limb_darkening();
    let place = |latitude_deg: f64, longitude_deg: f64| GeodeticPosition { latitude_deg, longitude_deg, height_km: EYE_HEIGHT_KM };
    // Total at Dallas, annular at Albuquerque, partial at New York.
    for (day, place) in [("2024-04-08", place(32.78, -96.80)), ("2023-10-14", place(35.08, -106.65)), ("2024-04-08", place(40.71, -74.01))]
    {
        let expected = circumstances(day, place);
        let contact = |name: &str| expected.contacts.iter().find(|c| c.name == name).map(|c| c.time);
        let [first, last] = ["C1", "C4"].map(|name| contact(name).expect("an eclipse"));
        let images =
            EclipseImages { place, darkening, unobscured_light: light_and_radius_ratio(place, first.plus_seconds(-120.0), DISCS_ONLY).0 };
        // Negative control: a Moon whose radius is larger by 0.4 % of the Sun's meets the Sun seconds earlier.
        for (enlargement, must_agree) in [(0.0, true), (0.004, false)] {
            let mut errors_s =
                vec![images.outer_contact_error_s(first, 1.0, enlargement), images.outer_contact_error_s(last, -1.0, enlargement)];
            if let (Some(second), Some(third)) = (contact("C2"), contact("C3")) {
                errors_s.extend(images.inner_contact_errors_s([second, third], enlargement));
            }
            println!("{day} {place:?} {enlargement}: {errors_s:.2?} s");
            assert!(errors_s.iter().all(|s| (s.abs() < 1.0) == must_agree), "{day}, the Moon enlarged by {enlargement}: {errors_s:?} s");
        }
        let (light, moon_radius) = light_and_radius_ratio(place, expected.maximum.time, DISCS_ONLY);
        if expected.contacts.len() == 2 {
            let magnitude = 0.5 * (1.0 + moon_radius - images.distance_and_moon_radius(expected.maximum.time).0);
            assert!((magnitude - expected.magnitude).abs() < 1e-3, "{day}: {magnitude} for {}", expected.magnitude);
        } else {
            // If one disc lies inside the other, the magnitude is the ratio of their diameters.
            assert!(
                (moon_radius - expected.magnitude).abs() < 1e-3,
                "{day}: the Moon is {moon_radius} times as wide as the Sun, by the geometry {}",
                expected.magnitude
            );
            // In totality there is no light. In annularity there is least light if the discs are concentric, and a little more if their limbs touch.
            let light_at = |distance: f64| 1.0 - hidden_fraction(moon_radius, distance, darkening);
            let (concentric, touching) = (light_at(1e-9), light_at((moon_radius - 1.0).abs()));
            let visible = light / images.unobscured_light;
            assert!(
                if moon_radius > 1.0 { light == 0.0 } else { (concentric - 1e-3..touching + 1e-3).contains(&visible) },
                "{day}: {visible}"
            );
        }
    }
}

/// From two hours to a minute before first contact the Sun rises higher. Without air its light is constant, with air it increases.
#[test]
fn without_air_the_suns_light_does_not_depend_on_its_altitude() {
    let place = GeodeticPosition { latitude_deg: 32.78, longitude_deg: -96.80, height_km: EYE_HEIGHT_KM };
    let first = circumstances("2024-04-08", place).contacts[0].time;
    let relative_change = |effects: &str| {
        let [early, late] = [-7200.0, -60.0].map(|s| light_and_radius_ratio(place, first.plus_seconds(s), effects).0);
        late / early - 1.0
    };
    let (without_air, with_air) = (relative_change(DISCS_ONLY), relative_change("+atmosphere,-glow,-corona,-albedo,-points"));
    assert!(without_air.abs() < 2e-5 && with_air > 0.01, "{without_air:e} without air, {with_air} with it");
}
