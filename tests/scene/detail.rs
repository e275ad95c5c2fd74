//! Procedural craters, hills and billows near the ground: gone from afar, fixed to the ground in any view, without a jump as the camera comes nearer, and
//! told as invented.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, ViewRequest};
use orrery::session::DrawnFrame;
use orrery::time::Instant;

const SIDE: u32 = 200;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };
const MOON_KM: f64 = 1737.4;

/// Straight down on the Moon at first quarter, the Sun 35 degrees up, from a height.
fn down(height_km: f64, aside: DVec2, effects: &str) -> ViewRequest {
    let below = DVec3::new(35_f64.to_radians().cos(), 35_f64.to_radians().sin(), 0.1).normalize();
    down_on(NaifId::MOON, MOON_KM, below, height_km, aside, effects)
}

/// Straight down on a body from a height over a direction from its centre (body axes); `aside`: km to the east and to the north of it.
fn down_on(body: NaifId, radius_km: f64, below: DVec3, height_km: f64, aside: DVec2, effects: &str) -> ViewRequest {
    let (east, north) = (DVec3::Z.cross(below).normalize(), below.cross(DVec3::Z.cross(below).normalize()));
    let over = (below + (east * aside.x + north * aside.y) / radius_km).normalize();
    ViewRequest {
        position: Position::Offset { body, offset_km: over * (radius_km + height_km), axes: Axes::BodyFixed },
        look: Look::Along { direction: -below, axes: Axes::BodyFixed },
        exposure: ExposureRequest::Stops(2.0),
        fov_deg: Some(40.0),
        width: SIDE,
        height: SIDE,
        layers: Layers::NONE,
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(body, Instant::parse("2024-04-15T20:00:00Z").expect("a time"))
    }
}

/// A place where the Sun stands 40 degrees up.
fn slantingly_lit(body: NaifId) -> DVec3 {
    let scene = SESSION.scene(&ViewRequest::of(body, Instant::parse("2024-04-15T20:00:00Z").expect("a time"))).expect("a scene");
    let noon = scene.body(body).expect("in the catalog").sub_solar.expect("lit");
    let (latitude, longitude) = (noon.latitude_deg.to_radians(), (noon.longitude_deg + 50.0).to_radians());
    DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin())
}

fn draw(request: &ViewRequest) -> DrawnFrame {
    SESSION.draw(request, SAMPLING, true).expect("drawn")
}

fn light(drawn: &DrawnFrame) -> Vec<f64> {
    drawn.frame.hdr.iter().map(|p| f64::from(p[1])).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn mean_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

/// Pearson's correlation.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (ma, mb) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(a, b)| f(a - ma, b - mb)).sum::<f64>();
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

/// From afar nothing is added, not even where it is asked for; near the ground it shows and keeps the mean light.
#[test]
fn detail_shows_where_texels_are_large_and_keeps_the_light() {
    let far = |effects| light(&draw(&down(20_000.0, DVec2::ZERO, effects)));
    let (with, without) = (far("+detail"), far("-detail"));
    let apart = with.iter().zip(&without).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6 && without.iter().any(|v| *v > 0.1), "from afar: {apart}");
    for height_km in [0.1, 1.0, 10.0] {
        let [with, without] = ["", "-detail"].map(|effects| draw(&down(height_km, DVec2::ZERO, effects)));
        let told = |drawn: &DrawnFrame| drawn.scene.body(NaifId::MOON).expect("drawn").invented.iter().any(|(what, _)| what == "detail");
        assert!(told(&with) && !told(&without), "{height_km} km");
        let [with, without] = [with, without].map(|drawn| light(&drawn));
        let level = mean(&without);
        let (shift, change) = (mean(&with) / level - 1.0, mean_difference(&with, &without) / level);
        println!("{height_km} km: mean {:+.3}, change {change:.3}", shift);
        assert!(change > 0.02, "{height_km} km: {change}");
        // Slopes away from the Sun lose more than those towards it gain: 16 % at 0.1 km (measured), where a frame holds few of the largest craters.
        assert!(shift.abs() < 0.2, "{height_km} km: {shift}");
        assert!(with.iter().all(|v| v.is_finite() && *v >= 0.0));
    }
}

/// The same craters from another place: what detail does to the light at points of the ground agrees between two views, and not with points beside them.
#[test]
fn craters_stay_on_the_ground() {
    for height_km in [0.1, 3.0, 30.0] {
        let aside = DVec2::new(0.11, 0.07) * height_km;
        let ratio_of = |aside: DVec2| {
            let [with, without] = ["+detail", "-detail"].map(|effects| draw(&down(height_km, aside, effects)));
            let ratio: Vec<f64> = light(&with).iter().zip(light(&without)).map(|(a, b)| a / b.max(1e-9)).collect();
            (with, ratio)
        };
        let ((first, here), (second, there)) = (ratio_of(DVec2::ZERO), ratio_of(aside));
        let places = [&first, &second].map(|drawn| drawn.scene.body(NaifId::MOON).expect("drawn").placement);
        let at = |ratio: &[f64], px: DVec2| {
            // Bilinear: the ground's points lie between pixels.
            let corner = (px - 0.5).floor();
            let part = px - 0.5 - corner;
            let of = |x: f64, y: f64| ratio[y as usize * SIDE as usize + x as usize];
            let row = |y: f64| of(corner.x, y) * (1.0 - part.x) + of(corner.x + 1.0, y) * part.x;
            row(corner.y) * (1.0 - part.y) + row(corner.y + 1.0) * part.y
        };
        let (mut same, mut beside) = (Vec::new(), Vec::new());
        for y in 40..160 {
            for x in 40..160 {
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(unit) = first.scene.camera.surface_under_pixel(&places[0], px) else { continue };
                let Some(other) = second.scene.camera.pixel_of_surface(&places[1], unit) else { continue };
                if other.cmplt(DVec2::splat(12.0)).any() || other.cmpgt(DVec2::splat(f64::from(SIDE) - 12.0)).any() {
                    continue;
                }
                let value = here[y as usize * SIDE as usize + x as usize];
                same.push((value, at(&there, other)));
                beside.push((value, at(&there, other + DVec2::new(7.0, 5.0))));
            }
        }
        let (same, beside) = (correlation(&same), correlation(&beside));
        println!("{height_km} km: {same:.3}, beside {beside:.3}");
        assert!(same > 0.8 && beside < 0.4, "{height_km} km: {same} {beside}");
    }
}

/// Coming nearer by a thousandth changes the picture by little at every height: no size of craters appears at once.
#[test]
fn no_crater_pops_up() {
    let mut worst = (0.0, 0.0);
    let mut jump_of_a_size = 0.0_f64;
    let mut height_km = 30.0;
    while height_km > 3.0 {
        let [a, b] = [height_km, height_km * 0.999].map(|h| light(&draw(&down(h, DVec2::ZERO, "+detail"))));
        let change = mean_difference(&a, &b) / mean(&a);
        if change > worst.0 {
            worst = (change, height_km);
        }
        jump_of_a_size = jump_of_a_size.max(mean_difference(&a, &light(&draw(&down(height_km, DVec2::ZERO, "-detail")))) / mean(&a));
        height_km *= 0.93;
    }
    println!("worst change {:.4} at {:.2} km; detail in all {jump_of_a_size:.3}", worst.0, worst.1);
    assert!(worst.0 < 0.1 * jump_of_a_size, "{worst:?}");
}

/// Switched off by name, left out in an eclipse and on gas, and said so.
#[test]
fn detail_is_for_airless_ground_and_can_be_switched_off() {
    let decision = |request: &ViewRequest, body: NaifId| {
        let scene = SESSION.scene(request).expect("a scene");
        let all = &scene.body(body).expect("in the catalog").decisions;
        all.iter().find(|d| d.feature == "detail").map(|d| (d.on, d.reason.clone()))
    };
    let on = decision(&down(10.0, DVec2::ZERO, ""), NaifId::MOON).expect("decided");
    assert!(on.0 && on.1.contains("nobody has measured"), "{on:?}");
    assert_eq!(decision(&down(10.0, DVec2::ZERO, "-detail"), NaifId::MOON).map(|d| d.0), Some(false));
    let whole =
        ViewRequest { width: SIDE, height: SIDE, ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-15T20:00:00Z").expect("a time")) };
    assert_eq!(decision(&whole, NaifId::MOON).map(|d| d.0), Some(false));
    for gas in [NaifId(599), NaifId::SUN] {
        assert_eq!(decision(&ViewRequest { target: Some(gas), ..whole.clone() }, gas), None, "{gas:?}");
    }
}

/// Mars' ground and the Earth's clouds: nothing from afar, something near, and the mean light stays. Open sea stays as it is.
#[test]
fn hills_and_billows_show_near_the_ground_and_keep_the_light() {
    let (mars, earth) = (NaifId(499), NaifId(399));
    for (body, radius_km, heights_km, least_change) in [(mars, 3390.0, [3.0, 20.0, 60.0], 0.02), (earth, 6371.0, [40.0, 80.0, 200.0], 0.02)]
    {
        let below = slantingly_lit(body);
        let pair =
            |height_km: f64| ["", "-detail"].map(|effects| light(&draw(&down_on(body, radius_km, below, height_km, DVec2::ZERO, effects))));
        let [with, without] = pair(20_000.0);
        assert_eq!(with, without, "{body:?} from afar");
        let (mut most_change, mut most_shift) = (0.0_f64, 0.0_f64);
        for height_km in heights_km {
            let [with, without] = pair(height_km);
            let level = mean(&without);
            let (change, shift) = (mean_difference(&with, &without) / level, mean(&with) / level - 1.0);
            println!("{body:?} from {height_km} km: mean {shift:+.3}, change {change:.3}");
            assert!(with.iter().all(|v| v.is_finite() && *v >= 0.0));
            (most_change, most_shift) = (most_change.max(change), most_shift.max(shift.abs()));
        }
        assert!(most_change > least_change && most_shift < 0.1, "{body:?}: change {most_change}, shift {most_shift}");
    }
    // The Pacific at 10 north, 140 west: its water is water in every texel around.
    let sea = DVec3::new(-0.7544, -0.6330, 0.1736);
    let [with, without] = ["-clouds,+detail", "-clouds,-detail"].map(|e| light(&draw(&down_on(earth, 6371.0, sea, 40.0, DVec2::ZERO, e))));
    assert!(mean_difference(&with, &without) <= 1e-3 * mean(&without), "hills on the sea");
}

/// The same hills from another place, and the same billows.
#[test]
fn hills_and_billows_stay_where_they_are() {
    for (body, radius_km, height_km) in [(NaifId(499), 3390.0, 20.0), (NaifId(399), 6371.0, 80.0)] {
        let below = slantingly_lit(body);
        // By a tenth of the frame's width to the east: so many pixels.
        let width_km = 2.0 * (height_km - if body == NaifId(399) { 6.0 } else { 0.0 }) * 20_f64.to_radians().tan();
        let moved = |part: f64| down_on(body, radius_km, below, height_km, DVec2::new(part * width_km, 0.0), "");
        let [first, second] = [0.0, 0.1].map(|part| light(&draw(&moved(part))));
        let shift = (0.1 * f64::from(SIDE)) as usize;
        // East is to the right or to the left, as the camera has its north; the other way must not agree.
        let agreement = |sign: i32| {
            let pairs: Vec<(f64, f64)> = (40..160)
                .flat_map(|y| (40..160).map(move |x: i32| (y, x, x + sign * shift as i32)))
                .map(|(y, x, there)| (first[y * SIDE as usize + x as usize], second[y * SIDE as usize + there as usize]))
                .collect();
            correlation(&pairs)
        };
        let (right, left) = (agreement(-1), agreement(1));
        println!("{body:?}: {right:.3} {left:.3}");
        assert!(right.max(left) > 0.8 && right.min(left) < 0.6, "{body:?}: {right} {left}");
    }
}
