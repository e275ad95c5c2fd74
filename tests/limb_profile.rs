//! Radiance across the limbs of bodies with air: no dip inside of the limb and no line along it, at any size and phase, by any way of summing the air.

use crate::shared::SESSION;
use orrery::catalog::{Body, NaifId};
use orrery::render::plan::{Fineness, plan};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, Quality, Up, ViewRequest};
use orrery::time::Instant;

const FINENESS: Fineness = Fineness { samples: 1, anisotropy: 4 };
const TIERS: [&str; 5] = ["vertex", "pixel-8", "pixel-16", "pixel-32", "table"];
/// Venus, the Earth, Mars, Jupiter, Saturn, Uranus, Neptune, Titan, Pluto, Triton.
const BODIES: [i32; 10] = [299, 399, 499, 599, 699, 799, 899, 606, 999, 801];

/// Radiance along the line from the middle of the disc to its limb under the Sun and on into space, one value a pixel; and the limb's place there.
struct Profile {
    light: Vec<[f64; 3]>,
    limb_px: f64,
}

fn profile(id: i32, phase_deg: f64, diameter_px: u32, effects: &str) -> Profile {
    let time = Instant::parse("2021-06-01T00:00:00Z").expect("a time");
    let body: &Body = SESSION.catalog().body(NaifId(id)).expect("a body");
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, body.id, time, None).expect("placed").state.pos_km.normalize();
    // About the pole, so that the limb under the Sun is near the equator.
    let pole = SESSION.ephemeris().body_from_icrf(body.id, time).expect("turned").row(2);
    let sideways = pole.cross(to_sun).normalize();
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let radii: f64 = 40.0;
    let offset_km = (to_sun * cos + sideways * sin) * (radii * body.radii_km.x);
    // The limb under the Sun is to the right.
    let right = to_sun - offset_km.normalize() * to_sun.dot(offset_km.normalize());
    let right = if right.length() < 1e-6 { -sideways } else { right.normalize() };
    let up = right.cross(-offset_km.normalize());
    let width = (f64::from(diameter_px) * 0.62) as u32;
    let pixel = 2.0 / (radii * radii - 1.0).sqrt() / f64::from(diameter_px);
    // The middle of the disc stands at the frame's left: the view's axis is half a frame to the right of it.
    let look = -offset_km.normalize() + right * (pixel * 0.5 * f64::from(width));
    let height = 9;
    let request = ViewRequest {
        position: Position::Offset { body: body.id, offset_km, axes: Axes::Icrf },
        look: Look::Along { direction: look, axes: Axes::Icrf },
        up: Up::Along { direction: up, axes: Axes::Icrf },
        fov_deg: Some(2.0 * (0.5 * pixel * f64::from(height)).atan().to_degrees()),
        width,
        height,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        quality: Quality::Standard,
        ..ViewRequest::of(body.id, time)
    };
    let scene = SESSION.scene(&request).expect("a scene");
    let plan = plan(&scene, &*SESSION, FINENESS).expect("a plan");
    let hdr = SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn").0.hdr;
    let row = &hdr[(height / 2 * width) as usize..((height / 2 + 1) * width) as usize];
    let light: Vec<_> = row.iter().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect();
    Profile { light, limb_px: 0.5 * f64::from(diameter_px) }
}

/// How far the profile dips between two brighter places, and how far its brightest place from just inside the limb on stands over what is inside of that;
/// each in parts of the brightest of the row, the worst channel. From `from` parts of the radius outward.
fn faults(p: &Profile, from: f64) -> (f64, f64) {
    let start = (from * p.limb_px) as usize;
    let edge = (p.limb_px - 2.5).max(0.0) as usize;
    let mut worst = (0.0_f64, 0.0_f64);
    for c in 0..3 {
        let row: Vec<f64> = p.light.iter().map(|v| v[c]).collect();
        let most = row.iter().copied().fold(1e-9, f64::max);
        let part = &row[start..];
        for k in 1..part.len().saturating_sub(1) {
            let left = part[..k].iter().copied().fold(0.0, f64::max);
            let right = part[k + 1..].iter().copied().fold(0.0, f64::max);
            worst.0 = worst.0.max((left.min(right) - part[k]) / most);
        }
        let inside = row[edge.saturating_sub(3)..=edge].iter().copied().fold(0.0, f64::max);
        let beyond = row[edge..].iter().copied().fold(0.0, f64::max);
        worst.1 = worst.1.max((beyond - inside) / most);
    }
    worst
}

#[test]
fn measure() {
    for id in BODIES {
        for effects in ["-albedo,-normal,-clouds,-specular,-night,-rings", "-rings"] {
            for phase in [0.0, 30.0, 60.0, 90.0, 120.0, 150.0] {
                let mut text = String::new();
                for size in [100, 400, 1600] {
                    let p = profile(id, phase, size, effects);
                    let f = faults(&p, 0.9);
                    text += &format!(" {size}: dip {:.4} line {:.4};", f.0, f.1);
                }
                println!("{id} {phase} {}{text}", effects.len());
            }
        }
    }
    for (id, phase, size) in [(799, 0.0, 400), (799, 60.0, 400), (699, 0.0, 1600), (606, 0.0, 400), (299, 0.0, 400), (499, 0.0, 400)] {
        let p = profile(id, phase, size, "-albedo,-rings,-normal");
        let edge = p.limb_px as usize;
        println!(
            "{id} {phase} {size}: {:?}",
            p.light[edge - 8..(edge + 8).min(p.light.len())].iter().map(|v| v.map(|x| (x * 1e4).round() / 1e4)).collect::<Vec<_>>()
        );
    }
    let _ = TIERS;
}
