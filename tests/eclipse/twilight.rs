//! The sky without the Sun's disc: in totality, where light from beyond the umbra keeps it above zero, and from day to night, against published illuminances and traced
//! photons.

use super::totality::{DALLAS, TOTALITY, UNIT_CD_M2, drawn, on_ground, parse_time, request};
use crate::support::session::SESSION;
use glam::{DVec3, Vec3, Vec4};
use orrery::catalog::{Catalog, NaifId};
use orrery::scene::draw::EclipseUniforms;
use orrery::scene::multi_scatter_in_shadow;
use orrery::scene::request::{Axes, Look, Up, ViewRequest};
use orrery::time::Instant;
use std::f64::consts::{PI, TAU};

/// The sky's radiance at a given altitude and azimuth above a location.
fn sky(
    body: NaifId,
    (latitude_deg, longitude_deg): (f64, f64),
    time: Instant,
    altitude_deg: f64,
    azimuth_deg: f64,
    effects: &str,
) -> DVec3 {
    let (lat, lon) = (latitude_deg.to_radians(), longitude_deg.to_radians());
    let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
    let north = up.cross(east);
    let (h, a) = (altitude_deg.to_radians(), azimuth_deg.to_radians());
    let direction = up * h.sin() + (north * a.cos() + east * a.sin()) * h.cos();
    let view = ViewRequest {
        target: None,
        position: on_ground(body, (latitude_deg, longitude_deg)),
        look: Look::Along { direction, axes: Axes::BodyFixed },
        up: Up::Celestial,
        ..request(body, time, 0.5, 2, 12.0, effects)
    };
    let hdr = drawn(&view).frame.hdr;
    hdr.iter().map(|p| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))).sum::<DVec3>() / hdr.len() as f64
}

const CLEAR_SKY: &str = "-glow,-corona,-points,-planet-shine,-clouds,-night";

/// Between first and last contact at Dallas (17:23 and 20:02 UTC) the sky overhead is never zero and falls and rises steadily. In northern Kenya on 1973-06-30 Shaw
/// (1975, Appl. Opt. 14, 388) measured 10^-4 of the daylight value: agreement within a factor of 4.
#[test]
fn the_sky_overhead_darkens_by_four_powers_of_ten_but_not_to_zero() {
    let overhead = |time: Instant, eclipse: bool| {
        let effects = format!("{CLEAR_SKY}{}", if eclipse { "" } else { ",-eclipse" });
        // Off the zenith, on the side away from the Sun.
        sky(NaifId::EARTH, DALLAS, time, 80.0, 0.0, &effects).y
    };
    let shaw_1975 =
        |effects: &str| sky(NaifId::EARTH, (3.0, 36.6), parse_time("1973-06-30T13:00:00Z"), 80.0, 0.0, &format!("{CLEAR_SKY}{effects}")).y;
    let daylight_ratio = shaw_1975("") / shaw_1975(",-eclipse");
    assert!((0.25e-4..4e-4).contains(&daylight_ratio), "{daylight_ratio:e}");
    let middle = parse_time(TOTALITY);
    let daylight_ratio = overhead(middle, true) / overhead(middle, false);
    assert!((1e-4..1e-3).contains(&daylight_ratio), "{daylight_ratio:e}");
    let from_middle = |s: f64| overhead(middle.plus_seconds(s), true);
    for side in [-1.0, 1.0] {
        let times = [0.0, 60.0, 110.0, 114.0, 118.0, 130.0, 150.0, 200.0, 400.0, 1000.0, 2400.0, 4300.0];
        let all: Vec<f64> = times.iter().map(|t| from_middle(side * t)).collect();
        assert!(all.iter().all(|v| *v > 0.0), "{all:?}");
        assert!(all.windows(2).all(|w| w[1] > 0.97 * w[0]), "it falls towards the middle: {all:?}");
    }
    // Around the last and first sunlight, in steps of one second, the light changes by at most a factor of 1.6.
    let all: Vec<f64> = (0..24).map(|k| from_middle(104.0 + f64::from(k))).collect();
    assert!(all.windows(2).all(|w| w[1] / w[0] < 1.6 && w[1] / w[0] > 0.9), "{all:?}");
}

/// In totality the horizon is brighter and redder than the sky overhead in all directions, and the ground is lit by the same light.
#[test]
fn twilight_surrounds_the_horizon_in_totality() {
    let time = parse_time(TOTALITY);
    let overhead = sky(NaifId::EARTH, DALLAS, time, 85.0, 0.0, CLEAR_SKY);
    assert!(overhead.z > overhead.x, "deep blue: {overhead}");
    for azimuth in 0..12 {
        let low = sky(NaifId::EARTH, DALLAS, time, 3.0, f64::from(azimuth) * 30.0, CLEAR_SKY);
        assert!(low.y > 2.0 * overhead.y, "{azimuth}: {low} against {overhead}");
        assert!(low.x / low.z > 1.5 * overhead.x / overhead.z, "{azimuth}: {low} against {overhead}");
    }
    // The ground: a few lux, an estimate (that of a twilight with the Sun about 5 degrees down), on an albedo of 0.05 to 0.3.
    let ground = sky(NaifId::EARTH, DALLAS, time, -60.0, 0.0, CLEAR_SKY).y * UNIT_CD_M2 * PI;
    assert!((0.05..5.0).contains(&ground), "{ground} lm/m2");
}

/// The table's factors against photons traced backwards through the same air with the same shadow: the second and all higher orders.
#[test]
fn light_in_the_umbra_agrees_with_photons() {
    let catalog = Catalog::embedded();
    let mut earth = catalog.body(NaifId::EARTH).expect("the Earth").clone();
    let air = earth.atmosphere.as_mut().expect("air");
    air.species.retain(|s| s.asymmetry.is_none() && s.tent_centre_km.is_none());
    let (per_km, scale_km, top_km) = (air.species[0].scattering_per_km, air.species[0].scale_height_km, air.top_km);
    let radius_km = earth.radii_km.x;
    let ground_albedo = earth.target_mean_colour();
    // Cotangent of the Sun's angular radius, and the Moon's distance in Earth radii.
    let (cot, depth) = (215.0, 59.0);
    for umbra_km in [40.0, 90.0, 130.0] {
        // A Moon in front of the Sun at the zenith, larger than the Sun by the given margin; the Sun's disc is uniform.
        let solar_radius_km = radius_km * depth / cot;
        let occluder_radius = ((1.0 + umbra_km / solar_radius_km) * depth / cot) as f32;
        let eclipse = EclipseUniforms {
            axis: Vec4::new(0.0, 0.0, 1.0, 1.0 / 23_455.0),
            across: [Vec4::new(1.0, 0.0, 0.0, cot as f32), Vec4::new(0.0, 1.0, 0.0, (cot / 23_455.0) as f32)],
            limb: [Vec3::splat(1.0 / std::f32::consts::PI).extend(0.0), Vec4::ZERO, Vec4::ZERO],
            occluder_positions: vec![Vec4::new(0.0, 0.0, depth as f32 + 1.0, 0.0)],
            occluder_outlines: vec![Vec4::new(1.0, 0.0, occluder_radius, occluder_radius)],
            ..EclipseUniforms::default()
        };
        let roots = multi_scatter_in_shadow::tables(&earth, &eclipse);
        assert_eq!(roots.len(), multi_scatter_in_shadow::TABLES);
        assert!(roots[..multi_scatter_in_shadow::NODES].iter().all(|r| r.min_element() >= 0.0 && r.max_element() <= 1.0));
        // The middle of the shadow, 2 km above the ground: first column of the second row.
        for channel in [1, 2] {
            let tabulated = f64::from(roots[multi_scatter_in_shadow::COLUMNS][channel]).powi(2);
            let visible_fraction =
                |x: f64, y: f64| visible_fraction_of_uniform_disc(f64::from(occluder_radius) * cot / depth, x.hypot(y) / solar_radius_km);
            let expected =
                shadow_ratio_by_photons(per_km[channel], scale_km, top_km, radius_km, ground_albedo[channel], 60_000, visible_fraction);
            assert!((tabulated / expected - 1.0).abs() < 0.4, "{umbra_km} km, channel {channel}: {tabulated:.2e} for {expected:.2e}");
        }
    }
}

fn visible_fraction_of_uniform_disc(occluder: f64, separation: f64) -> f64 {
    if separation >= occluder + 1.0 {
        return 1.0;
    }
    if separation <= occluder - 1.0 {
        return 0.0;
    }
    let angle = |a: f64, b: f64| ((separation * separation + a * a - b * b) / (2.0 * separation * a)).clamp(-1.0, 1.0).acos();
    let (s, c) = (angle(1.0, occluder), angle(occluder, 1.0));
    1.0 - (s - 0.5 * (2.0 * s).sin() + occluder * occluder * (c - 0.5 * (2.0 * c).sin())) / PI
}

/// Mean over all directions at 2 km of light that was scattered before it arrives: the ratio of shadowed to unshadowed, with the Sun at the zenith. Scattering is
/// isotropic, as in the table.
fn shadow_ratio_by_photons(
    per_km: f64,
    scale_km: f64,
    top_km: f64,
    radius_km: f64,
    ground_albedo: f64,
    paths: u32,
    visible_fraction: impl Fn(f64, f64) -> f64,
) -> f64 {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    };
    let sunlight = |height: f64| (-per_km * scale_km * (-height / scale_km).exp()).exp();
    let (mut shadowed, mut unshadowed) = (0.0, 0.0);
    for _ in 0..paths {
        let mut position = DVec3::new(0.0, 0.0, radius_km + 2.0);
        let isotropic = |random: &mut dyn FnMut() -> f64| {
            let z = 2.0 * random() - 1.0;
            let (sin, cos) = (TAU * random()).sin_cos();
            DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
        };
        let mut along = isotropic(&mut random);
        let mut weight = 1.0;
        // Delta tracking to the next scattering: the air is sampled at the ground's density, and a scattering is accepted with the probability of the local density.
        loop {
            let before = position;
            position += along * (-random().ln() / per_km);
            let height = position.length() - radius_km;
            let b = before.dot(along);
            let discriminant = b * b - before.length_squared() + radius_km * radius_km;
            if b < 0.0 && discriminant > 0.0 && (-b - discriminant.sqrt()) < (position - before).length() {
                position = before + along * (-b - discriminant.sqrt());
                let up = position.normalize();
                weight *= ground_albedo;
                let light = weight * up.z.max(0.0) * sunlight(0.0) / PI;
                shadowed += light * visible_fraction(position.x, position.y);
                unshadowed += light;
                let side = isotropic(&mut random);
                along = (up + side).normalize();
                position += up * 1e-6;
            } else if height > top_km {
                break;
            } else if random() < (-height / scale_km).exp() {
                let light = weight * sunlight(height) / (4.0 * PI);
                shadowed += light * visible_fraction(position.x, position.y);
                unshadowed += light;
                along = isotropic(&mut random);
            }
            if weight < 1e-4 {
                break;
            }
        }
    }
    shadowed / unshadowed
}

/// Outside every penumbra the tables change nothing, to the last bit.
#[test]
fn outside_the_penumbra_the_sky_is_unchanged() {
    let time = parse_time("2024-04-08T18:42:38Z");
    for location in [(-30.0, -60.0), (45.0, 10.0)] {
        for height in [3.0, 40.0] {
            let radiance_with = |effects: &str| sky(NaifId::EARTH, location, time, height, 120.0, &format!("{CLEAR_SKY}{effects}"));
            assert_eq!(radiance_with(",+eclipse"), radiance_with(",-eclipse"), "{location:?} {height}");
        }
    }
}

/// Illuminance of level ground by the entire sky without the Sun's disc, in lux, sampled at 6 altitudes by 8 azimuths.
fn lux(body: NaifId, location: (f64, f64), time: Instant) -> f64 {
    let altitudes_deg = [4.0, 14.0, 26.0, 40.0, 57.0, 78.0];
    let band_edges_deg = [0.0, 9.0, 20.0, 33.0, 48.0, 67.0, 90.0_f64];
    let band = |k: usize| {
        let weight = PI * (band_edges_deg[k + 1].to_radians().sin().powi(2) - band_edges_deg[k].to_radians().sin().powi(2));
        let luminances = (0..8).map(|a| {
            let c = sky(body, location, time, altitudes_deg[k], f64::from(a) * 45.0 + 10.0, &format!("{CLEAR_SKY},-eclipse"));
            0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
        });
        weight * luminances.sum::<f64>() / 8.0
    };
    (0..6).map(band).sum::<f64>() * UNIT_CD_M2
}

/// The time in an afternoon when the Sun is at the given altitude above a location; degrees.
fn afternoon_time(body: NaifId, location: (f64, f64), from: Instant, altitude_deg: f64, afternoon_s: f64) -> Instant {
    let height = |t: f64| {
        let view =
            ViewRequest { position: on_ground(body, location), ..request(NaifId::SUN, from.plus_seconds(t), 1.0, 8, 0.0, CLEAR_SKY) };
        let scene = SESSION.scene(&view).expect("a scene");
        let up = -scene.body(body).expect("the ground").placement.centre_km.normalize();
        up.dot(scene.body(NaifId::SUN).expect("the Sun").placement.centre_km.normalize()).asin().to_degrees()
    };
    let (mut early, mut late) = (0.0, afternoon_s);
    assert!(height(early) > altitude_deg && height(late) < altitude_deg, "{} to {} degrees", height(early), height(late));
    // Bisect to two seconds, in which the Sun moves by 0.01 degrees.
    for _ in 0..14 {
        let middle = 0.5 * (early + late);
        if height(middle) > altitude_deg { early = middle } else { late = middle }
    }
    from.plus_seconds(early)
}

/// At sunset the Sun's upper limb, raised by refraction, is on the horizon.
const SUNSET_DEG: f64 = -0.833;

/// From day to night on the Earth: skylight on level ground falls without a jump to that of the night, and agrees with published values within a factor of 2.5: 410 to
/// 585 lux at sunset, 2 to 3.5 at the end of civil twilight, 0.008 of nautical, 6e-4 of astronomical and below (AMS Glossary of Meteorology). Measured: 1.4, 2.5 and 2.3
/// times the middle of the ranges. Photons followed through the same air give the same light (tests/atmosphere/twilight.rs), so the sum over orders is not too bright.
/// Part of the excess comes from the catalog's air, which is clearer than average; the rest is not explained (docs/measurements.md).
#[test]
fn twilight_is_as_bright_as_published() {
    let location = (0.0, 0.0);
    let noon = parse_time("2024-03-20T12:00:00Z");
    let lux_at = |deg: f64| lux(NaifId::EARTH, location, afternoon_time(NaifId::EARTH, location, noon, deg, 36_000.0));
    let heights = [60.0, 30.0, 10.0, 3.0, 0.0, SUNSET_DEG, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0, -14.0, -16.0, -18.0, -22.0, -30.0];
    let all: Vec<f64> = heights.iter().map(|h| lux_at(*h)).collect();
    println!("{heights:?} degrees: {all:?} lux");
    for (w, h) in all.windows(2).zip(heights.windows(2)) {
        assert!(w[1] < w[0] * 1.001, "at {h:?} degrees {w:?} lux");
        let decades_per_deg = (w[0] / w[1]).log10() / (h[0] - h[1]);
        assert!(decades_per_deg < 0.8, "at {h:?} degrees {w:?} lux: {decades_per_deg:.2}");
    }
    let lux_of = |deg: f64| all[heights.iter().position(|h| *h == deg).expect("one of them")];
    for (deg, lowest, highest) in
        [(SUNSET_DEG, 165.0, 1000.0), (-6.0, 0.8, 8.75), (-12.0, 0.0032, 0.02), (-18.0, 2.4e-4, 1.5e-3), (-30.0, 2e-4, 1.2e-3)]
    {
        assert!((lowest..highest).contains(&lux_of(deg)), "{deg} degrees: {} lux", lux_of(deg));
    }
    assert!(lux_of(60.0) > 5e3 && lux_of(60.0) < 2.5e4, "{} lux by day", lux_of(60.0));
}

/// The ground is lit by the sky that is drawn: from dusk to night their ratio, the ground's albedo, stays within a factor of 1.7 of its geometric mean.
#[test]
fn the_ground_is_lit_by_the_sky_that_is_drawn() {
    let location = (0.0, 0.0);
    let noon = parse_time("2024-03-20T12:00:00Z");
    let ratios: Vec<f64> = [-1.0, -3.0, -5.0, -7.0, -9.0, -11.0, -13.0, -16.0, -20.0, -28.0]
        .into_iter()
        .map(|height| {
            let time = afternoon_time(NaifId::EARTH, location, noon, height, 36_000.0);
            let c = sky(NaifId::EARTH, location, time, -70.0, 0.0, &format!("{CLEAR_SKY},-eclipse,-albedo,-specular"));
            (0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z) * UNIT_CD_M2 * PI / lux(NaifId::EARTH, location, time)
        })
        .collect();
    let geometric_mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
    assert!(ratios.iter().all(|r| (r / geometric_mean).ln().abs() < 1.7_f64.ln()), "{ratios:?}");
    assert!((0.4..1.0).contains(&geometric_mean), "one and a half times the disc's geometric albedo of 0.43: {geometric_mean}");
}

/// On Mars and the Earth, in all models: ground and sky are never entirely black, at any time of day.
#[test]
fn every_sky_has_a_night() {
    let cases = [(NaifId(499), (0.0, 0.0), "2024-03-20T12:00:00Z"), (NaifId::EARTH, (0.0, 0.0), "2024-03-20T23:59:00Z")];
    for (body, location, time) in cases {
        for model in ["table", "pixel-8", "pixel-32", "vertex"] {
            let mut min = f64::MAX;
            for hour in 0..6 {
                let time = parse_time(time).plus_seconds(f64::from(hour) * 4.0 * 3600.0);
                for height in [60.0, 5.0, -40.0] {
                    let c = sky(body, location, time, height, 0.0, &format!("{CLEAR_SKY},-eclipse,+atmosphere={model}"));
                    assert!(c.min_element() > 0.0 && c.is_finite(), "{body:?} {model} {hour} {height}: {c}");
                    min = min.min(c.y);
                }
            }
            assert!(min * UNIT_CD_M2 < 1e-3, "{body:?} {model}: one of the instants must be at night: {min:e}");
        }
    }
}
