//! Bodies with air in front of the Sun, seen from afar: automatic exposure shows the ring of air around them, and the light meter's estimate of its radiance is
//! that of the drawn ring.

use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, Purpose, ViewRequest};
use orrery::time::Instant;

const TIME: &str = "2024-04-08T18:17:16Z";
const SIDE: u32 = 96;

/// A view of a body at a phase angle, from a distance in its radii, whose disc fills about half of the image.
fn view(body: NaifId, phase_deg: f64, distance_radii: f64) -> ViewRequest {
    let time = Instant::parse(TIME).expect("a time");
    let towards_sun = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("a position").state.pos_km.normalize();
    let across = towards_sun.cross(DVec3::Z).normalize();
    let radius_km = SESSION.catalog().body(body).expect("in the catalog").radii_km.x;
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let offset_km = (towards_sun * cos + across * sin) * (radius_km * distance_radii);
    ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some(2.0 * (2.0 / distance_radii).atan().to_degrees()),
        effects: EffectOverrides::parse("-glow").unwrap_or_default(),
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(body, time)
    }
}

/// Fractions of the image's pixels that are white, and that are at least a third of the way to white.
fn white_and_lit(request: &ViewRequest) -> (f64, f64) {
    let frame = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::Display).expect("drawn").frame;
    let fraction = |level: u8| {
        frame.display.iter().filter(|p| p[..3].iter().any(|v| *v >= level)).count() as f64 / frame.display.len() as f64
    };
    (fraction(254), fraction(85))
}

/// Titan, Pluto and Mars from 20 radii, from a crescent to the Sun straight behind: the ring is neither white all over nor black, and the exposure changes
/// gradually while the Sun is hidden.
#[test]
fn the_ring_of_air_around_a_backlit_body_is_exposed() {
    for (body, phases_deg) in [(606, 177..=180), (999, 160..=180), (499, 178..=180)] {
        let body = NaifId(body);
        let mut stops = Vec::new();
        for phase_deg in phases_deg {
            let request = view(body, f64::from(phase_deg), 20.0);
            let metered = SESSION.scene(&request).expect("a scene").exposure.stops;
            let (white, lit) = white_and_lit(&request);
            println!("{body:?} {phase_deg}: {metered:.2} stops, {white:.3} white, {lit:.3} lit");
            assert!(white < 0.02 && lit > 0.002, "{body:?} at {phase_deg} degrees: {white} white, {lit} lit");
            stops.push(metered);
        }
        assert!(stops.windows(2).all(|w| (w[1] - w[0]).abs() < 1.0), "{body:?}: {stops:?}");
    }
}
