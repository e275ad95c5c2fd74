//! Skylight: in totality, where light from beyond the umbra keeps it above zero, against simulated photons; and from day to night, against
//! published illuminances.

use super::totality::{DALLAS, TOTALITY, UNIT_CD_M2, drawn, on_ground, parse_time, request};
use crate::support::random::Random;
use crate::support::session::SESSION;
use glam::{DVec3, Vec3, Vec4};
use orrery::catalog::{Catalog, NaifId, Species};
use orrery::scene::draw::EclipseUniforms;
use orrery::scene::multi_scatter_in_shadow;
use orrery::scene::request::{Axes, Look, Up, ViewRequest};
use orrery::time::Instant;
use orrery::units::luminance;
use std::f64::consts::{PI, TAU};

/// Mean radiance in a direction seen from a location (latitude and east longitude in degrees); below the horizon that of the ground.
fn radiance(
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
    let (altitude, azimuth) = (altitude_deg.to_radians(), azimuth_deg.to_radians());
    let direction = up * altitude.sin() + (north * azimuth.cos() + east * azimuth.sin()) * altitude.cos();
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

/// Between first and last contact at Dallas (17:23 and 20:02 UTC) the sky overhead falls and rises steadily, and is never black. In
/// northern Kenya on 1973-06-30 Shaw (1975, Appl. Opt. 14, 388) measured 10^-4 of the daylight value; the drawn value is within a factor of
/// 4.
#[test]
fn the_sky_overhead_darkens_by_three_to_five_powers_of_ten_but_not_to_zero() {
    // Green stands for the luminance: only ratios count.
    let overhead = |time: Instant, effects: &str| {
        // 10 degrees from the zenith, on the side away from the Sun.
        radiance(NaifId::EARTH, DALLAS, time, 80.0, 0.0, &format!("{CLEAR_SKY}{effects}")).y
    };
    let shaw_1975 = |effects: &str| {
        radiance(NaifId::EARTH, (3.0, 36.6), parse_time("1973-06-30T13:00:00Z"), 80.0, 0.0, &format!("{CLEAR_SKY}{effects}")).y
    };
    let daylight_ratio = shaw_1975("") / shaw_1975(",-eclipse");
    assert!((0.25e-4..4e-4).contains(&daylight_ratio), "{daylight_ratio:e}");
    let middle = parse_time(TOTALITY);
    let daylight_ratio = overhead(middle, "") / overhead(middle, ",-eclipse");
    assert!((1e-4..1e-3).contains(&daylight_ratio), "{daylight_ratio:e}");
    let after_middle = |s: f64| overhead(middle.plus_seconds(s), "");
    for side in [-1.0, 1.0] {
        let times = [0.0, 60.0, 110.0, 114.0, 118.0, 130.0, 150.0, 200.0, 400.0, 1000.0, 2400.0, 4300.0];
        let radiances: Vec<f64> = times.iter().map(|t| after_middle(side * t)).collect();
        assert!(radiances.iter().all(|v| *v > 0.0), "{radiances:?}");
        assert!(radiances.windows(2).all(|w| w[1] > 0.97 * w[0]), "it must fall towards the middle: {radiances:?}");
    }
    // Around the end of totality the light increases by less than a factor of 1.6 from second to second.
    let radiances: Vec<f64> = (0..24).map(|k| after_middle(104.0 + f64::from(k))).collect();
    assert!(radiances.windows(2).all(|w| w[1] / w[0] < 1.6 && w[1] / w[0] > 0.9), "{radiances:?}");
}

/// In totality the sky near the horizon is brighter and redder than overhead, in all directions, and the ground is as bright as in a
/// twilight.
#[test]
fn twilight_surrounds_the_horizon_in_totality() {
    let time = parse_time(TOTALITY);
    let overhead = radiance(NaifId::EARTH, DALLAS, time, 85.0, 0.0, CLEAR_SKY);
    assert!(overhead.z > overhead.x, "the sky overhead must be blue: {overhead}");
    for azimuth in 0..12 {
        let low = radiance(NaifId::EARTH, DALLAS, time, 3.0, f64::from(azimuth) * 30.0, CLEAR_SKY);
        assert!(low.y > 2.0 * overhead.y, "{azimuth}: {low} against {overhead}");
        assert!(low.x / low.z > 1.5 * overhead.x / overhead.z, "{azimuth}: {low} against {overhead}");
    }
    // An illuminance of a few lux, estimated as that of a twilight with the Sun about 5 degrees down, on an albedo of 0.05 to 0.3.
    let ground = radiance(NaifId::EARTH, DALLAS, time, -60.0, 0.0, CLEAR_SKY).y * UNIT_CD_M2 * PI;
    assert!((0.05..5.0).contains(&ground), "{ground} lm/m2");
}

/// The factors on multiply scattered light in the shadow against photons followed backwards through the same air with the same shadow: within
/// the 40 % that src/scene/atmosphere/multi_scatter_in_shadow.rs states. In an umbra of 130 km light is a quarter or less of that in one of
/// 40 km, so a factor for the wrong size fails.
#[test]
fn light_in_the_umbra_agrees_with_photons() {
    let catalog = Catalog::embedded();
    let mut earth = catalog.body(NaifId::EARTH).expect("the Earth").clone();
    let air = earth.atmosphere.as_mut().expect("air");
    air.species.retain(Species::is_gas);
    let (per_km, scale_height_km, top_km) = (air.species[0].scattering_per_km, air.species[0].scale_height_km, air.top_km);
    let radius_km = earth.radii_km.x;
    let ground_albedo = earth.mean_reflectance();
    // The cotangent of the Sun's angular radius at 1 au, and in Earth radii 1 au and the Moon's distance from the ground.
    let (cot_sun_radius, sun_distance, moon_distance) = (215.0_f64, 23_455.0_f64, 59.0_f64);
    let mut by_umbra = Vec::new();
    for umbra_radius_km in [40.0, 90.0, 130.0] {
        // A Moon in front of the Sun at the zenith, so much larger than the Sun that its umbra has this radius. The Sun's disc is uniform;
        // projected to the Moon's distance, its radius is `solar_radius_km`.
        let solar_radius_km = radius_km * moon_distance / cot_sun_radius;
        let occluder_radius = ((1.0 + umbra_radius_km / solar_radius_km) * moon_distance / cot_sun_radius) as f32;
        let eclipse = EclipseUniforms {
            axis: Vec4::new(0.0, 0.0, 1.0, (1.0 / sun_distance) as f32),
            perpendicular_axes: [
                Vec4::new(1.0, 0.0, 0.0, cot_sun_radius as f32),
                Vec4::new(0.0, 1.0, 0.0, (cot_sun_radius / sun_distance) as f32),
            ],
            limb_darkening: [Vec3::splat(1.0 / std::f32::consts::PI).extend(0.0), Vec4::ZERO, Vec4::ZERO],
            occluder_positions: vec![Vec4::new(0.0, 0.0, moon_distance as f32 + 1.0, 0.0)],
            occluder_outlines: vec![Vec4::new(1.0, 0.0, occluder_radius, occluder_radius)],
            ..EclipseUniforms::default()
        };
        let roots = multi_scatter_in_shadow::tables(&earth, &eclipse);
        assert_eq!(roots.len(), multi_scatter_in_shadow::VECTORS);
        assert!(roots[..multi_scatter_in_shadow::FACTORS_PER_OCCLUDER].iter().all(|r| r.min_element() >= 0.0 && r.max_element() <= 1.0));
        // The middle of the shadow, 2 km above the ground: the first column of the second row. The table stores square roots.
        for channel in [1, 2] {
            let tabulated = f64::from(roots[multi_scatter_in_shadow::COLUMNS][channel]).powi(2);
            let visible_fraction = |x: f64, y: f64| {
                visible_fraction_of_uniform_disc(f64::from(occluder_radius) * cot_sun_radius / moon_distance, x.hypot(y) / solar_radius_km)
            };
            let expected = shadow_ratio_by_photons(
                per_km[channel],
                scale_height_km,
                top_km,
                radius_km,
                ground_albedo[channel],
                60_000,
                visible_fraction,
            );
            assert!(
                (tabulated / expected - 1.0).abs() < 0.4,
                "{umbra_radius_km} km, channel {channel}: {tabulated:.2e} for {expected:.2e}"
            );
            by_umbra.push((tabulated, expected));
        }
    }
    // Two channels of each umbra.
    for ((smallest, _), (_, largest)) in by_umbra[..2].iter().zip(&by_umbra[4..]) {
        assert!(smallest / largest - 1.0 > 0.4, "the factor for the smallest umbra passes in the largest: {smallest:.2e}, {largest:.2e}");
    }
}

/// The occluder's radius and the separation of the centres are in solar radii.
fn visible_fraction_of_uniform_disc(occluder: f64, separation: f64) -> f64 {
    if separation >= occluder + 1.0 {
        return 1.0;
    }
    if separation <= occluder - 1.0 {
        return 0.0;
    }
    let angle = |a: f64, b: f64| ((separation * separation + a * a - b * b) / (2.0 * separation * a)).clamp(-1.0, 1.0).acos();
    // Half the central angles of the two circular segments that make up the overlap.
    let (of_sun, of_occluder) = (angle(1.0, occluder), angle(occluder, 1.0));
    1.0 - (of_sun - 0.5 * (2.0 * of_sun).sin() + occluder * occluder * (of_occluder - 0.5 * (2.0 * of_occluder).sin())) / PI
}

/// Light that arrives 2 km above the ground after at least one scattering or reflection, averaged over directions: its ratio in the shadow
/// to that without the shadow. The Sun is at the zenith. Scattering is isotropic, as for the factors. `visible_fraction`: of the Sun's disc,
/// at a distance from the shadow's axis (x and y in km).
fn shadow_ratio_by_photons(
    per_km: f64,
    scale_height_km: f64,
    top_km: f64,
    radius_km: f64,
    ground_albedo: f64,
    paths: u32,
    visible_fraction: impl Fn(f64, f64) -> f64,
) -> f64 {
    let mut generator = Random(0x2545_f491_4f6c_dd1d);
    let mut random = move || generator.positive();
    let sunlight = |height: f64| (-per_km * scale_height_km * (-height / scale_height_km).exp()).exp();
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
        // Delta tracking: free paths are sampled for the density at the ground, and a scattering is accepted with the relative density as
        // its probability.
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
                // Directions of a Lambert surface.
                let on_sphere = isotropic(&mut random);
                along = (up + on_sphere).normalize();
                position += up * 1e-6;
            } else if height > top_km {
                break;
            } else if random() < (-height / scale_height_km).exp() {
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

/// Outside every penumbra the tables change nothing, to the last bit; in the umbra the sky is darker.
#[test]
fn outside_the_penumbra_the_sky_is_unchanged() {
    let time = parse_time("2024-04-08T18:42:38Z");
    for (location, is_outside) in [((-30.0, -60.0), true), ((45.0, 10.0), true), (DALLAS, false)] {
        for altitude_deg in [3.0, 40.0] {
            let [eclipsed, plain] = [",+eclipse", ",-eclipse"]
                .map(|effects| radiance(NaifId::EARTH, location, time, altitude_deg, 120.0, &format!("{CLEAR_SKY}{effects}")));
            assert_eq!(eclipsed == plain, is_outside, "{location:?} {altitude_deg}: {eclipsed}, without the eclipse {plain}");
            assert!(is_outside || eclipsed.y < 0.1 * plain.y, "{location:?} {altitude_deg}: {eclipsed}, without the eclipse {plain}");
        }
    }
}

/// Illuminance of level ground by the sky alone, in lux, from 6 altitudes by 8 azimuths.
fn skylight_lux(body: NaifId, location: (f64, f64), time: Instant) -> f64 {
    let altitudes_deg = [4.0, 14.0, 26.0, 40.0, 57.0, 78.0];
    let band_edges_deg = [0.0, 9.0, 20.0, 33.0, 48.0, 67.0, 90.0_f64];
    let band = |k: usize| {
        let weight = PI * (band_edges_deg[k + 1].to_radians().sin().powi(2) - band_edges_deg[k].to_radians().sin().powi(2));
        let luminances = (0..8).map(|a| {
            let c = radiance(body, location, time, altitudes_deg[k], f64::from(a) * 45.0 + 10.0, &format!("{CLEAR_SKY},-eclipse"));
            luminance(c.to_array())
        });
        weight * luminances.sum::<f64>() / 8.0
    };
    (0..6).map(band).sum::<f64>() * UNIT_CD_M2
}

/// The time within `afternoon_s` after noon when the Sun is at an altitude.
fn afternoon_time(body: NaifId, location: (f64, f64), noon: Instant, altitude_deg: f64, afternoon_s: f64) -> Instant {
    let sun_altitude_deg = |seconds: f64| {
        let view =
            ViewRequest { position: on_ground(body, location), ..request(NaifId::SUN, noon.plus_seconds(seconds), 1.0, 8, 0.0, CLEAR_SKY) };
        let scene = SESSION.scene(&view).expect("a scene");
        let up = -scene.body(body).expect("the ground").placement.centre_km.normalize();
        up.dot(scene.body(NaifId::SUN).expect("the Sun").placement.centre_km.normalize()).asin().to_degrees()
    };
    let (mut early, mut late) = (0.0, afternoon_s);
    assert!(
        sun_altitude_deg(early) > altitude_deg && sun_altitude_deg(late) < altitude_deg,
        "{} to {} degrees",
        sun_altitude_deg(early),
        sun_altitude_deg(late)
    );
    // Bisects ten hours to two seconds, in which the Sun moves by 0.01 degrees.
    for _ in 0..14 {
        let middle = 0.5 * (early + late);
        if sun_altitude_deg(middle) > altitude_deg { early = middle } else { late = middle }
    }
    noon.plus_seconds(early)
}

/// At sunset the Sun's upper limb, raised by refraction, is on the horizon.
const SUNSET_DEG: f64 = -0.833;

/// Largest quotient of the drawn and a published illuminance, in either direction.
const MAX_FACTOR: f64 = 2.1;

/// From day to night on the Earth, skylight on level ground falls without a jump, and is within [`MAX_FACTOR`] of published values: 410 to
/// 585 lux at sunset, 2 to 3.5 at the end of civil twilight, 0.008 at that of nautical twilight, 6e-4 at that of astronomical twilight and
/// later (AMS Glossary of Meteorology). Simulated photons in the same air give the same light (docs/measurements.md; for gas alone also
/// tests/atmosphere/skylight.rs), so the excess is
/// that of the catalog's air. Part of it comes from little aerosol; the rest is not explained.
#[test]
fn twilight_illuminances_agree_with_published_values() {
    let location = (0.0, 0.0);
    let noon = parse_time("2024-03-20T12:00:00Z");
    let lux_at = |deg: f64| skylight_lux(NaifId::EARTH, location, afternoon_time(NaifId::EARTH, location, noon, deg, 36_000.0));
    let altitudes_deg = [60.0, 30.0, 10.0, 3.0, 0.0, SUNSET_DEG, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0, -14.0, -16.0, -18.0, -22.0, -30.0];
    let illuminances: Vec<f64> = altitudes_deg.iter().map(|deg| lux_at(*deg)).collect();
    println!("{altitudes_deg:?} degrees: {illuminances:?} lux");
    for (lux, deg) in illuminances.windows(2).zip(altitudes_deg.windows(2)) {
        assert!(lux[1] < lux[0] * 1.001, "at {deg:?} degrees {lux:?} lux");
        let decades_per_deg = (lux[0] / lux[1]).log10() / (deg[0] - deg[1]);
        assert!(decades_per_deg < 0.8, "at {deg:?} degrees {lux:?} lux: {decades_per_deg:.2}");
    }
    let lux_of = |deg: f64| illuminances[altitudes_deg.iter().position(|altitude| *altitude == deg).expect("one of them")];
    // The published range, and the factor above it that is allowed: less at sunset and at night, where the light is nearer to it.
    for (deg, published_min, published_max, factor_above) in [
        (SUNSET_DEG, 410.0, 585.0, 1.7),
        (-6.0, 2.0, 3.5, MAX_FACTOR),
        (-12.0, 0.008, 0.008, MAX_FACTOR),
        (-18.0, 6e-4, 6e-4, MAX_FACTOR),
        (-30.0, 6e-4, 6e-4, 2.0),
    ] {
        let allowed = published_min / MAX_FACTOR..published_max * factor_above;
        assert!(allowed.contains(&lux_of(deg)), "{deg} degrees: {} lux, not {allowed:?}", lux_of(deg));
    }
    assert!(lux_of(60.0) > 5e3 && lux_of(60.0) < 2.5e4, "{} lux by day", lux_of(60.0));
}

/// From dusk to night the ratio of the ground's luminous exitance to the sky's illuminance, its albedo, stays within a factor of 1.7 of its
/// geometric mean.
#[test]
fn the_ground_is_lit_by_the_sky_that_is_drawn() {
    let location = (0.0, 0.0);
    let noon = parse_time("2024-03-20T12:00:00Z");
    let ratios: Vec<f64> = [-1.0, -3.0, -5.0, -7.0, -9.0, -11.0, -13.0, -16.0, -20.0, -28.0]
        .into_iter()
        .map(|altitude_deg| {
            let time = afternoon_time(NaifId::EARTH, location, noon, altitude_deg, 36_000.0);
            let c = radiance(NaifId::EARTH, location, time, -70.0, 0.0, &format!("{CLEAR_SKY},-eclipse,-albedo,-specular"));
            luminance(c.to_array()) * UNIT_CD_M2 * PI / skylight_lux(NaifId::EARTH, location, time)
        })
        .collect();
    let geometric_mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
    assert!(ratios.iter().all(|r| (r / geometric_mean).ln().abs() < 1.7_f64.ln()), "{ratios:?}");
    assert!(
        (0.4..1.0).contains(&geometric_mean),
        "the albedo of a Lambert sphere is 3/2 of its geometric albedo, here 0.43: {geometric_mean}"
    );
}

/// On Mars and the Earth, with four models, at any time of day.
#[test]
fn sky_and_ground_are_never_black() {
    let cases = [(NaifId(499), (0.0, 0.0), "2024-03-20T12:00:00Z"), (NaifId::EARTH, (0.0, 0.0), "2024-03-20T23:59:00Z")];
    for (body, location, time) in cases {
        for model in ["table", "pixel-8", "pixel-32", "vertex"] {
            let mut darkest = f64::MAX;
            for hour in 0..6 {
                let time = parse_time(time).plus_seconds(f64::from(hour) * 4.0 * 3600.0);
                for altitude_deg in [60.0, 5.0, -40.0] {
                    let c = radiance(body, location, time, altitude_deg, 0.0, &format!("{CLEAR_SKY},-eclipse,+atmosphere={model}"));
                    assert!(c.min_element() > 0.0 && c.is_finite(), "{body:?} {model} {hour} {altitude_deg}: {c}");
                    darkest = darkest.min(c.y);
                }
            }
            assert!(darkest * UNIT_CD_M2 < 1e-3, "{body:?} {model}: one of the instants must be at night: {darkest:e}");
        }
    }
}
