//! Contacts and magnitude of eclipses, measured from the Sun's light in images drawn from the ground, against the geometry of discs.
//!
//! The overlap of a disc with the limb-darkened Sun, integrated here, converts the light of an image into the distance of the centres;
//! distances near a contact give its instant. Air, glare, corona and map are off, because the overlap does not include their light.

use super::{EPHEMERIS, IAU, parse_time, seconds_after};
use crate::support::session::SESSION;
use glam::{DMat4, DVec4};
use orrery::catalog::{NaifId, Photometry};
use orrery::events::{GeodeticPosition, LocalCircumstances, solar_eclipses};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use orrery::{FrameImages, Instant};
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// Limb darkening of the Sun in green, 1 - u1 (1 - mu) - u2 (1 - mu)^2, from the catalog.
fn limb_darkening() -> [f64; 2] {
    let sun = IAU.body(NaifId::SUN).expect("the Sun");
    let Photometry::Emissive { u1, u2 } = &sun.photometry else { panic!("the Sun must be emissive") };
    [u1[1], u2[1]]
}

/// Fraction of the Sun's light hidden by a disc of radius `k` with its centre at this distance from the Sun's, both in solar radii.
fn hidden_fraction(k: f64, distance: f64, [u1, u2]: [f64; 2]) -> f64 {
    const RINGS: u32 = 4000;
    let (mut total, mut hidden) = (0.0, 0.0);
    for ring in 0..RINGS {
        // Rings of equal steps in mu: narrow at the limb, where contacts occur.
        let mu = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let r = (1.0 - mu * mu).sqrt();
        let light = mu * (1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2));
        let cosine = (r * r + distance * distance - k * k) / (2.0 * r * distance).max(1e-300);
        total += light;
        hidden += light * cosine.clamp(-1.0, 1.0).acos() / PI;
    }
    hidden / total
}

/// The distance of the centres, between `near` and `far`, at which this fraction is hidden.
fn distance_for(fraction: f64, k: f64, (mut near, mut far): (f64, f64), darkening: [f64; 2]) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        if hidden_fraction(k, middle, darkening) > fraction { near = middle } else { far = middle }
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
    let angular_radius = |body: NaifId| {
        let b = drawn.scene.body(body).expect("a body");
        (b.placement.radii_km.x / b.distance_km).asin()
    };
    let light: f64 = drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum();
    (light / angular_radius(NaifId::SUN).powi(2), angular_radius(NaifId::MOON) / angular_radius(NaifId::SUN))
}

fn circumstances(day: &str, place: GeodeticPosition) -> LocalCircumstances {
    let from = parse_time(day);
    let eclipses = solar_eclipses(&IAU, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses");
    eclipses[0].seen_from(place).expect("an eclipse")
}

/// Times of the images near a contact, as seconds from it on the side of the partial phase. A pixel is 4.5 arcseconds; the Moon moves by a
/// pixel in ten seconds.
const IMAGE_OFFSETS_S: [f64; 4] = [40.0, 60.0, 80.0, 100.0];

/// Measures an eclipse from images drawn from a place.
struct EclipseImages {
    place: GeodeticPosition,
    darkening: [f64; 2],
    /// The Sun's light before the first contact.
    unobscured: f64,
}

impl EclipseImages {
    /// Distance of the centres and the Moon's radius at an instant, both in solar radii.
    fn distance(&self, time: Instant) -> (f64, f64) {
        let (light, k) = light_and_radius_ratio(self.place, time, DISCS_ONLY);
        (distance_for(1.0 - light / self.unobscured, k, ((k - 1.0).abs(), 1.0 + k), self.darkening), k)
    }

    /// Seconds from an outer contact's expected time to its measured time, by a straight line fitted to the distances. `side`: 1 if the
    /// partial phase follows, -1 if it precedes. `enlargement`: added to the Moon's radius, in solar radii.
    fn outer_contact_error_s(&self, time: Instant, side: f64, enlargement: f64) -> f64 {
        let points = IMAGE_OFFSETS_S.map(|s| {
            let (distance, k) = self.distance(time.plus_seconds(side * s));
            (side * s, distance - (1.0 + k + enlargement))
        });
        let n = points.len() as f64;
        let (mean_t, mean_distance) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let slope = points.iter().map(|p| (p.0 - mean_t) * (p.1 - mean_distance)).sum::<f64>()
            / points.iter().map(|p| (p.0 - mean_t).powi(2)).sum::<f64>();
        mean_t - mean_distance / slope
    }

    /// The same for second and third contact. Between them the distance has a sharp minimum, but its square is smooth: nearly a parabola,
    /// skewed by the Earth's rotation. A cubic is fitted to it, by least squares, from images before second and after third contact.
    fn inner_contact_errors_s(&self, [second, third]: [Instant; 2], enlargement: f64) -> [f64; 2] {
        let half_s = 0.5 * seconds_after(third, second);
        let middle = second.plus_seconds(half_s);
        // The normal equations.
        let (mut matrix, mut right_side, mut moon_radius) = (DMat4::ZERO, DVec4::ZERO, 0.0);
        for t in IMAGE_OFFSETS_S.into_iter().flat_map(|s| [-half_s - s, half_s + s]) {
            let (distance, k) = self.distance(middle.plus_seconds(t));
            let x = t / half_s;
            let powers = DVec4::new(1.0, x, x * x, x * x * x);
            matrix += DMat4::from_cols(powers, powers * x, powers * x * x, powers * x * x * x);
            right_side += powers * distance * distance;
            moon_radius = k;
        }
        let coefficients = matrix.inverse() * right_side;
        let squared_at_contact = ((moon_radius - 1.0).abs() + enlargement).powi(2);
        [-1.0_f64, 1.0].map(|contact| {
            // Newton's method from the expected contact, at -1 or 1.
            let mut x = contact;
            for _ in 0..20 {
                let value = coefficients.dot(DVec4::new(1.0, x, x * x, x * x * x)) - squared_at_contact;
                x -= value / coefficients.dot(DVec4::new(0.0, 1.0, 2.0 * x, 3.0 * x * x));
            }
            half_s * (x - contact)
        })
    }
}

#[test]
fn contacts_and_magnitude_from_pixels_agree_with_the_geometry() {
    let darkening = limb_darkening();
    let place = |latitude_deg: f64, longitude_deg: f64| GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0017 };
    // Total at Dallas, annular at Albuquerque, partial at New York.
    for (day, place) in [("2024-04-08", place(32.78, -96.80)), ("2023-10-14", place(35.08, -106.65)), ("2024-04-08", place(40.71, -74.01))]
    {
        let expected = circumstances(day, place);
        let contact = |name: &str| expected.contacts.iter().find(|c| c.name == name).map(|c| c.time);
        let [first, last] = ["C1", "C4"].map(|name| contact(name).expect("an eclipse"));
        let images =
            EclipseImages { place, darkening, unobscured: light_and_radius_ratio(place, first.plus_seconds(-120.0), DISCS_ONLY).0 };
        // Negative control: a Moon whose radius is larger by 0.4 % of the Sun's meets the Sun seconds earlier.
        for (enlargement, agrees) in [(0.0, true), (0.004, false)] {
            let mut errors_s =
                vec![images.outer_contact_error_s(first, 1.0, enlargement), images.outer_contact_error_s(last, -1.0, enlargement)];
            if let (Some(second), Some(third)) = (contact("C2"), contact("C3")) {
                errors_s.extend(images.inner_contact_errors_s([second, third], enlargement));
            }
            println!("{day} {place:?} {enlargement}: {errors_s:.2?} s");
            assert!(errors_s.iter().all(|s| (s.abs() < 1.0) == agrees), "{day} {enlargement}: {errors_s:?} s");
        }
        let (light, k) = light_and_radius_ratio(place, expected.maximum.time, DISCS_ONLY);
        if expected.contacts.len() == 2 {
            let magnitude = 0.5 * (1.0 + k - images.distance(expected.maximum.time).0);
            assert!((magnitude - expected.magnitude).abs() < 1e-3, "{day}: {magnitude} for {}", expected.magnitude);
        } else {
            // If one disc lies inside the other, the magnitude is the ratio of their diameters.
            assert!(
                (k - expected.magnitude).abs() < 1e-3,
                "{day}: the Moon is {k} times as wide as the Sun, by the geometry {}",
                expected.magnitude
            );
            // In totality there is no light. In annularity it is least if the discs are concentric, and a little more if the limbs touch.
            let (concentric, at_limb) = (1.0 - hidden_fraction(k, 1e-9, darkening), 1.0 - hidden_fraction(k, (k - 1.0).abs(), darkening));
            let visible = light / images.unobscured;
            assert!(if k > 1.0 { light == 0.0 } else { (concentric - 1e-3..at_limb + 1e-3).contains(&visible) }, "{day}: {visible}");
        }
    }
}

/// From two hours before first contact to a minute before it, while the Sun rises higher: without air its light is constant, with air it
/// increases.
#[test]
fn without_air_the_suns_light_does_not_depend_on_its_altitude() {
    let place = GeodeticPosition { latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.0017 };
    let first = circumstances("2024-04-08", place).contacts[0].time;
    let relative_change = |effects: &str| {
        let [early, late] = [-7200.0, -60.0].map(|s| light_and_radius_ratio(place, first.plus_seconds(s), effects).0);
        late / early - 1.0
    };
    let (without_air, with_air) = (relative_change(DISCS_ONLY), relative_change("+atmosphere,-glow,-corona,-albedo,-points"));
    assert!(without_air.abs() < 2e-5 && with_air > 0.01, "{without_air:e} without air, {with_air} with it");
}
