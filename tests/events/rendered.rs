//! An eclipse in pixels: from the Sun's light in images taken on the ground follow the contacts and the magnitude, which agree with the geometry of discs.
//!
//! The overlap of a limb-darkened disc, integrated here, converts the light of an image into a distance between the discs' centres; distances before and after a
//! contact give its instant. Air, glare, corona and map are off, because the overlap does not include their light.

use super::{EPHEMERIS, IAU, parse_time, seconds_after};
use crate::support::session::SESSION;
use glam::{DMat4, DVec4};
use orrery::Instant;
use orrery::catalog::{NaifId, Photometry};
use orrery::events::{GeodeticPosition, LocalCircumstances, solar_eclipses};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// Limb darkening of the Sun in green, 1 - u1 (1 - mu) - u2 (1 - mu)^2, from the catalog.
fn limb_darkening() -> [f64; 2] {
    let sun = IAU.body(NaifId::SUN).expect("the Sun");
    let Photometry::Emissive { u1, u2 } = &sun.photometry else { panic!("the Sun must be emissive") };
    [u1[1], u2[1]]
}

/// The fraction of the Sun's light that a disc of radius `k` hides when its centre is at distance `s`, in solar radii.
fn hidden_fraction(k: f64, s: f64, [u1, u2]: [f64; 2]) -> f64 {
    const RINGS: u32 = 4000;
    let (mut total, mut hidden) = (0.0, 0.0);
    for ring in 0..RINGS {
        // Rings of equal steps in mu: narrow at the limb, where contacts occur.
        let mu = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let r = (1.0 - mu * mu).sqrt();
        let light = mu * (1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2));
        let cosine = (r * r + s * s - k * k) / (2.0 * r * s).max(1e-300);
        total += light;
        hidden += light * cosine.clamp(-1.0, 1.0).acos() / PI;
    }
    hidden / total
}

/// The distance, between `near` and `far`, at which the given fraction is hidden.
fn distance_of(fraction: f64, k: f64, (mut near, mut far): (f64, f64), darkening: [f64; 2]) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (near + far);
        if hidden_fraction(k, middle, darkening) > fraction { near = middle } else { far = middle }
    }
    0.5 * (near + far)
}

/// Effects that leave the Sun and the Moon as plain discs.
const DISCS_ONLY: &str = "-atmosphere,-glow,-corona,-albedo,-points";

/// The Sun's green light in an image from a location, divided by the square of the Sun's angular radius (which changes by 1e-4 from first to last contact), and
/// the ratio of the Moon's angular radius to the Sun's.
fn seen_from(place: GeodeticPosition, time: Instant, effects: &str) -> (f64, f64) {
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
    let light: f64 = drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum();
    (light / radius(NaifId::SUN).powi(2), radius(NaifId::MOON) / radius(NaifId::SUN))
}

fn circumstances(day: &str, place: GeodeticPosition) -> LocalCircumstances {
    let from = parse_time(day);
    let eclipses = solar_eclipses(&IAU, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses");
    eclipses[0].seen_from(place).expect("an eclipse")
}

/// Seconds from a contact to each image, on the side where part of the Sun is hidden. A pixel is 4.5 arcseconds, and the Moon moves by one pixel in ten seconds.
const IMAGES_S: [f64; 4] = [40.0, 60.0, 80.0, 100.0];

/// Measures an eclipse at a location from images.
struct Images {
    place: GeodeticPosition,
    darkening: [f64; 2],
    /// The Sun's light before the first contact.
    unobscured: f64,
}

impl Images {
    /// Distance of the centres and the Moon's radius at an instant, both in solar radii.
    fn distance(&self, time: Instant) -> (f64, f64) {
        let (light, k) = seen_from(self.place, time, DISCS_ONLY);
        (distance_of(1.0 - light / self.unobscured, k, ((k - 1.0).abs(), 1.0 + k), self.darkening), k)
    }

    /// Measured delay of an outer contact after `time`, in seconds, for a Moon whose radius is larger by `enlargement`: a straight line fitted to the distances.
    fn outer_contact_s(&self, time: Instant, side: f64, enlargement: f64) -> f64 {
        let points = IMAGES_S.map(|s| {
            let (distance, k) = self.distance(time.plus_seconds(side * s));
            (side * s, distance - (1.0 + k + enlargement))
        });
        let n = points.len() as f64;
        let (mean_t, mean_distance) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let slope = points.iter().map(|p| (p.0 - mean_t) * (p.1 - mean_distance)).sum::<f64>()
            / points.iter().map(|p| (p.0 - mean_t).powi(2)).sum::<f64>();
        mean_t - mean_distance / slope
    }

    /// The same for second and third contact. Between them the distance has a minimum, but its square is smooth: nearly a parabola, which the turning Earth skews. A cubic is
    /// fitted by least squares to images before and after.
    fn inner_contacts_s(&self, [second, third]: [Instant; 2], enlargement: f64) -> [f64; 2] {
        let half = 0.5 * seconds_after(third, second);
        let middle = second.plus_seconds(half);
        let (mut normal, mut right_side, mut radius) = (DMat4::ZERO, DVec4::ZERO, 0.0);
        for t in IMAGES_S.into_iter().flat_map(|s| [-half - s, half + s]) {
            let (distance, k) = self.distance(middle.plus_seconds(t));
            let x = t / half;
            let powers = DVec4::new(1.0, x, x * x, x * x * x);
            normal += DMat4::from_cols(powers, powers * x, powers * x * x, powers * x * x * x);
            right_side += powers * distance * distance;
            radius = k;
        }
        let coefficients = normal.inverse() * right_side;
        let squared_at_contact = ((radius - 1.0).abs() + enlargement).powi(2);
        [-1.0_f64, 1.0].map(|contact| {
            // Newton's method from the geometry's contact.
            let mut x = contact;
            for _ in 0..20 {
                let value = coefficients.dot(DVec4::new(1.0, x, x * x, x * x * x)) - squared_at_contact;
                x -= value / coefficients.dot(DVec4::new(0.0, 1.0, 2.0 * x, 3.0 * x * x));
            }
            half * (x - contact)
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
        let images = Images { place, darkening, unobscured: seen_from(place, first.plus_seconds(-120.0), DISCS_ONLY).0 };
        // The comparison must be able to fail: a Moon that is 0.4 % larger meets the Sun seconds earlier.
        for (enlargement, agrees) in [(0.0, true), (0.004, false)] {
            let mut errors_s = vec![images.outer_contact_s(first, 1.0, enlargement), images.outer_contact_s(last, -1.0, enlargement)];
            if let (Some(second), Some(third)) = (contact("C2"), contact("C3")) {
                errors_s.extend(images.inner_contacts_s([second, third], enlargement));
            }
            println!("{day} {place:?} {enlargement}: {errors_s:.2?} s");
            assert!(errors_s.iter().all(|s| (s.abs() < 1.0) == agrees), "{day} {enlargement}: {errors_s:?} s");
        }
        let (light, k) = seen_from(place, expected.maximum.time, DISCS_ONLY);
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
            // In totality there is no light; in annularity the remaining light depends only a little on the Moon's position inside the Sun's disc.
            let (middle, limb) = (1.0 - hidden_fraction(k, 1e-9, darkening), 1.0 - hidden_fraction(k, (k - 1.0).abs(), darkening));
            let light_left = light / images.unobscured;
            assert!(if k > 1.0 { light == 0.0 } else { (middle - 1e-3..limb + 1e-3).contains(&light_left) }, "{day}: {light_left}");
        }
    }
}

/// Without air the Sun's disc is equally bright at any altitude, from two hours before the eclipse to its first contact. With air its light increases as it rises.
#[test]
fn the_sun_keeps_its_light_where_the_air_is_switched_off() {
    let place = GeodeticPosition { latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.0017 };
    let first = circumstances("2024-04-08", place).contacts[0].time;
    let relative_change = |effects: &str| {
        let [early, late] = [-7200.0, -60.0].map(|s| seen_from(place, first.plus_seconds(s), effects).0);
        late / early - 1.0
    };
    let (without_air, with_air) = (relative_change(DISCS_ONLY), relative_change("+atmosphere,-glow,-corona,-albedo,-points"));
    assert!(without_air.abs() < 2e-5 && with_air > 0.01, "{without_air:e} without air, {with_air} with it");
}
