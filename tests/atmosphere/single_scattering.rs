//! Air: single scattering against integrals computed outside this program (tests/data/rayleigh_reference_public.json, rayleigh_integrals.json), multiply
//! scattered light, the shadows of the planet and of the Moon, and air of zero density.

use crate::support::folds::{larger, largest_component};
use crate::support::reference_rays::{ReferenceRay, TABLE, rays};
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId};
use orrery::probe::Prober;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::draw::AtmosphereModel;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::multi_scatter_table;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, Up, ViewRequest};
use orrery::scene::stated_errors::{self, StatedError};
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use serde_json::{Value, json};
use std::f64::consts::PI;

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().expect("a list").iter().map(|n| n.as_f64().expect("a number")).collect()
}

/// Errors of a model on the rays of the reference that meet air. First, sorted: the largest relative error of each ray's radiance over the channels, without
/// channels fainter than 1e-4 of the atmosphere's brightest. Second: the largest error of a transmittance.
fn errors(model: &str) -> (Vec<f64>, f64) {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let expected: Vec<(&Value, [f64; 3])> = rays().iter().map(|ray| (ray.row, ray.radiance().to_array())).collect();
    let brightest =
        |air: &Value| expected.iter().filter(|(ray, _)| ray["atm"] == *air).flat_map(|(_, radiance)| *radiance).fold(0.0, f64::max);
    let (mut radiance, mut transmittance) = (Vec::new(), 0.0f64);
    // The segment is the part of a ray inside the air.
    for (ray, expected) in expected.iter().filter(|(ray, _)| !ray["segment"].is_null()) {
        let air = ray["atm"].as_str().expect("a name");
        let question = json!({ "q": "scatter", "atmosphere": TABLE["atmospheres"][air], "cam": ray["cam"], "dir": ray["dir"],
            "sun": ray["sun"], "tier": model });
        let answer = prober.answer(&question.to_string()).expect("an answer");
        assert_eq!(answer["hits_ground"], ray["hits_ground"], "{ray}");
        let floor = 1e-4 * brightest(&ray["atm"]);
        let got = numbers(&answer["radiance"]);
        assert!(got.iter().all(|v| v.is_finite() && *v >= 0.0), "{ray}: {got:?}");
        let worst = got.iter().zip(expected).filter(|(_, e)| **e > floor).map(|(g, e)| (g / e - 1.0).abs()).fold(0.0, larger);
        radiance.push(worst);
        for (g, e) in numbers(&answer["transmittance"]).iter().zip(numbers(&ray["transmittance"])) {
            transmittance = larger(transmittance, (g - e).abs());
        }
    }
    radiance.sort_by(f64::total_cmp);
    (radiance, transmittance)
}

/// The integrals without phase function, with the table's own phase functions (its field `method`), are the table's radiances, to 1e-8. Negative controls: an
/// asymmetry 1 % smaller, and integrals 1e-7 larger.
#[test]
fn the_integrals_give_the_radiances_of_the_table() {
    let greatest_error = |asymmetry_factor: f64, integral_factor: f64| {
        let of_table = |species: &Value, cosine: f64| {
            DVec3::splat(match species["phase"].as_str().expect("a word") {
                "rayleigh" => 3.0 / (16.0 * PI) * (1.0 + cosine * cosine),
                "hg" => {
                    let g = asymmetry_factor * species["g"].as_f64().expect("a number");
                    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
                }
                _ => 0.0,
            })
        };
        let error = |ray: &ReferenceRay| {
            let given = DVec3::from_slice(&numbers(&ray.row["radiance"]));
            largest_component((integral_factor * ray.radiance_with(of_table) - given).abs() / given.max(DVec3::splat(1e-12)))
        };
        rays().iter().map(error).fold(0.0, larger)
    };
    let found = greatest_error(1.0, 1.0);
    assert!(found < 1e-8, "{found}");
    assert!(greatest_error(0.99, 1.0) > 1e-3 && greatest_error(1.0, 1.0 + 1e-7) > 1e-8);
}

/// The error that `orrery explain` states for a model.
fn stated(model: AtmosphereModel) -> StatedError {
    stated_errors::of_atmosphere(model).expect("a stated error")
}

fn assert_within_stated_bounds(model: AtmosphereModel) {
    let StatedError { name, error_95_percent, max_error, .. } = stated(model);
    let (bound_of_95_percent, transmittance_bound) = (error_95_percent.expect("a bound for 95 %"), stated_errors::AIR_TRANSMITTANCE);
    let (radiance, transmittance) = errors(name);
    assert!(radiance.len() > 100, "{} rays", radiance.len());
    let percentile_95 = radiance[radiance.len() * 95 / 100];
    let worst = radiance[radiance.len() - 1];
    assert!(
        percentile_95 < bound_of_95_percent && worst < max_error && transmittance < transmittance_bound,
        "{name}: {percentile_95:.4} {worst:.4} {transmittance:.4}"
    );
}

/// With the five samples of `vertex` half of the rays are within 1 %, but 1 % of them, in twilight and at limbs, are off by more than 10 %.
#[test]
fn five_samples_keep_their_stated_error() {
    let (radiance, _) = errors("vertex");
    let percentile = |percent: usize| radiance[radiance.len() * percent / 100];
    assert!(percentile(50) < 0.01 && percentile(99) > 0.1, "{} {}", percentile(50), percentile(99));
    assert_within_stated_bounds(AtmosphereModel::Vertex);
}

#[test]
fn eight_samples_keep_their_stated_error() {
    assert_within_stated_bounds(AtmosphereModel::Pixel8);
}

#[test]
fn sixteen_samples_keep_their_stated_error() {
    assert_within_stated_bounds(AtmosphereModel::Pixel16);
}

#[test]
fn thirty_two_samples_keep_their_stated_error() {
    assert_within_stated_bounds(AtmosphereModel::Pixel32);
}

/// Radiance of the sky at an altitude, seen from 2 m above the Earth's ground, with the Sun `sun_below_deg` below the horizon. `is_antisolar`: at the
/// azimuth opposite the Sun's, otherwise at the Sun's.
fn dusk_radiance(sun_below_deg: f64, altitude_deg: f64, is_antisolar: bool) -> Vec<f64> {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let (sun_altitude, altitude) = ((-sun_below_deg).to_radians(), altitude_deg.to_radians());
    let side = if is_antisolar { -1.0 } else { 1.0 };
    let question = json!({ "q": "scatter", "atmosphere": TABLE["atmospheres"]["earth_full"], "cam": [1.0 + 2.0 / 6_360_000.0, 0.0, 0.0],
        "dir": [altitude.sin(), side * altitude.cos(), 0.0], "sun": [sun_altitude.sin(), sun_altitude.cos(), 0.0],
        "tier": "pixel-16" });
    numbers(&prober.answer(&question.to_string()).expect("an answer")["radiance"])
}

#[test]
fn the_planets_shadow_rises_opposite_the_setting_sun() {
    // A ray that leaves the air, at a height of 100 km, inside the planet's shadow receives no light.
    assert_eq!(dusk_radiance(4.0, 2.0, true), [0.0; 3]);
    assert!(dusk_radiance(4.0, 20.0, true)[0] > 1e-5, "above the shadow the air is lit");
    assert!(dusk_radiance(0.5, 2.0, true)[0] > 1e-5, "just after sunset the low sky is lit");
    let glow = dusk_radiance(4.0, 2.0, false);
    assert!(glow[0] > 10.0 * glow[2] && glow[0] > 1e-3, "the low sky above the Sun is red: {glow:?}");
    let night = dusk_radiance(30.0, 20.0, false);
    assert!(night.iter().all(|v| *v == 0.0), "{night:?}");
}

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

fn earth_at(time: &str, effects: &str) -> ViewRequest {
    ViewRequest {
        width: 160,
        height: 160,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
    }
}

fn sum(session: &Session, request: &ViewRequest) -> f64 {
    session
        .draw(request, SAMPLING, FrameImages::DisplayAndHdr)
        .expect("draws")
        .frame
        .hdr
        .iter()
        .map(|p| f64::from(p[0] + p[1] + p[2]))
        .sum()
}

/// An atmosphere of zero density, evaluated in each pixel, gives the same image bit for bit as no atmosphere; with the coarse image of the
/// air the two differ only by rounding.
#[test]
fn an_empty_atmosphere_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let species = "[[atmosphere.species]]\nscattering_per_km = [0.0, 0.0, 0.0]\nabsorption_per_km = [0.0, 0.0, 0.0]\n";
    let text = format!(
        "[[atmosphere]]\nbody = \"Earth\"\ntop_km = 100.0\nsource = \"a test\"\n{species}name = \"gas\"\nscale_height_km = 8.0\n\
         {species}name = \"haze\"\nscale_height_km = 1.2\nasymmetry = 0.8\n{species}name = \"layer\"\nscale_height_km = 15.0\ntent_centre_km = 25.0\n"
    );
    std::fs::write(folder.path().join("empty.toml"), text).expect("written");
    let sources = Sources { catalogs: Some(folder.path().to_owned()), cache: Some(folder.path().join("cache")), ..Sources::default() };
    let empty_air = Session::open(&sources, |_| {}).expect("opens");
    // Large enough for the rim of the atmosphere to be drawn.
    let large = |effects: &str| ViewRequest { width: 400, height: 400, ..earth_at("2024-06-08T06:00:00Z", effects) };
    let (with, without) = (large("+atmosphere"), large("-atmosphere"));
    let draws_with_air =
        empty_air.scene(&with).expect("a scene").draws.iter().filter(|d| d.features.air.model != AtmosphereModel::None).count();
    assert!(draws_with_air >= 3, "ground, clouds and sky are drawn with the empty air: {draws_with_air}");
    let airless = empty_air.draw(&without, SAMPLING, FrameImages::DisplayAndHdr).expect("draws").frame.hdr;
    let by_pixel = ViewRequest { may_use_coarse_air: false, ..with.clone() };
    assert!(empty_air.draw(&by_pixel, SAMPLING, FrameImages::DisplayAndHdr).expect("draws").frame.hdr == airless, "the pixels differ");
    // With the coarse image the ground's draw shades the clouds, and rounds differently.
    let coarse = empty_air.draw(&with, SAMPLING, FrameImages::DisplayAndHdr).expect("draws").frame.hdr;
    let relative_difference = |a: &[f32; 4], b: &[f32; 4]| (0..3).map(|c| (a[c] - b[c]).abs() / b[c].max(1e-3)).fold(0.0, larger);
    let greatest = coarse.iter().zip(&airless).map(|(a, b)| relative_difference(a, b)).fold(0.0, larger);
    assert!(greatest < 2e-3, "{greatest:e}");
    // The real air must change the image.
    assert!((sum(&SESSION, &with) / sum(&SESSION, &without) - 1.0).abs() > 0.01);
}

/// In the umbra of the eclipse of 8 April 2024 the sky overhead is almost dark; near the horizon the sunlit air beyond the umbra is
/// visible.
#[test]
fn the_moons_shadow_darkens_the_air() {
    // Radiance in the eclipse, relative to that without it.
    let remaining_fraction = |altitude_deg: f64| {
        let sky = |effects: &str| {
            let altitude = altitude_deg.to_radians();
            let (lat, lon) = (25.29f64.to_radians(), (-104.14f64).to_radians());
            let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
            let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
            let request = ViewRequest {
                target: None,
                position: Position::Ground { body: NaifId::EARTH, latitude_deg: 25.29, longitude_deg: -104.14, height_km: 0.002 },
                look: Look::Along { direction: up * altitude.sin() + east * altitude.cos(), axes: Axes::BodyFixed },
                up: Up::Celestial,
                fov_deg: Some(1.0),
                width: 8,
                height: 8,
                ..earth_at("2024-04-08T18:17:16Z", effects)
            };
            sum(&SESSION, &request)
        };
        // Only sunlight is compared, so city lights are off.
        sky("+eclipse,-night") / sky("-eclipse,-night")
    };
    let (zenith, horizon) = (remaining_fraction(85.0), remaining_fraction(2.0));
    assert!(zenith < 2e-3, "{zenith}");
    assert!(horizon > 5.0 * zenith && horizon < 0.5, "{horizon} against {zenith}");
}

/// Multiply scattered light in the table is below 0.01 of sunlight for Pluto's thin air, and below 1 for thicker air. In an image of the
/// Earth it adds 10 to 100 % to the blue light.
#[test]
fn multiple_scattering_is_negligible_in_thin_air_and_brightens_the_earth() {
    let catalog = Catalog::embedded();
    for (name, upper_bound) in [("Earth", 1.0), ("Titan", 1.0), ("Pluto", 0.01)] {
        let mut body = catalog.bodies().iter().find(|b| b.name == name).expect(name).clone();
        // The ground is black, as the light that it reflects would illuminate thin air, too.
        (body.geometric_albedo, body.clear_sky_albedo) = (0.0, None);
        let table = multi_scatter_table::table(&body).expect("a table");
        assert_eq!(table.len(), multi_scatter_table::NODES);
        let brightest = table[..multi_scatter_table::HEIGHTS * multi_scatter_table::COLUMNS]
            .iter()
            .map(|root| root.truncate().max_element().powi(2))
            .fold(0.0, larger);
        assert!(table.iter().all(|v| v.is_finite() && v.min_element() >= 0.0), "{name}");
        assert!(brightest > 0.0 && brightest < upper_bound, "{name}: {brightest}");
    }
    let time = "2024-06-08T06:00:00Z";
    let total_blue = |effects: &str| {
        let drawn = SESSION.draw(&earth_at(time, effects), SAMPLING, FrameImages::DisplayAndHdr).expect("draws");
        drawn.frame.hdr.iter().map(|p| f64::from(p[2])).sum::<f64>()
    };
    let (single, multiple) = (total_blue("+atmosphere=pixel-16,-clouds,-eclipse"), total_blue("+atmosphere=table,-clouds,-eclipse"));
    let ratio = multiple / single;
    assert!(ratio > 1.1 && ratio < 2.0, "{ratio}");
}
