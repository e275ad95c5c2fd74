//! The shadow of rings on moons: the eclipse of Iapetus that Barnard observed in 1889, the agreement of image, `explain` and `probe`, the dark line of Saturn's
//! rings on Rhea near the equinox of 2009, pixel by pixel, and rings of a user's catalog.

use crate::support::session::{SESSION, sources};
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::{Body, Catalog, NaifId, Photometry};
use orrery::ephemeris::Ephemeris;
use orrery::probe::Prober;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::draw::{BodyPart, Draw, PixelView, RingShadow};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, ViewRequest};
use orrery::scene::{Scene, bodies_seen_from};
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use orrery::units::GOLDEN_ANGLE_RAD;
use serde_json::json;

const RHEA: NaifId = NaifId(605);
const IAPETUS: NaifId = NaifId(608);
const SATURN: NaifId = NaifId(699);

fn time(text: &str) -> Instant {
    Instant::parse(text).expect("a time")
}

fn minutes_between(from: Instant, to: Instant) -> f64 {
    (to.tdb_seconds_past_j2000() - from.tdb_seconds_past_j2000()) / 60.0
}

/// A catalog and its ephemeris.
fn sky_of(catalog: Catalog) -> (Catalog, Ephemeris) {
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    (catalog, ephemeris)
}

/// The built-in catalog with a file added.
fn sky_with(file: &str) -> (Catalog, Ephemeris) {
    sky_of(Catalog::with_files(&[("mine.toml".to_owned(), file.to_owned())]).unwrap_or_else(|e| panic!("{e}")))
}

/// Magnitude of a body from the Earth's centre; 99 without light.
fn magnitude((catalog, ephemeris): &(Catalog, Ephemeris), id: NaifId, time: Instant) -> f64 {
    let bodies = bodies_seen_from(catalog, ephemeris, Position::Centre(NaifId::EARTH), time).expect("placed");
    bodies.iter().find(|b| b.id == id).expect("in the catalog").magnitude.unwrap_or(99.0)
}

/// When a condition that holds at `from` and not at `to` ceases to hold, to a few seconds.
fn end_of(holds: impl Fn(Instant) -> bool, from: Instant, to: Instant) -> Instant {
    assert!(holds(from) && !holds(to));
    let (mut before, mut after) = (from, to);
    for _ in 0..10 {
        let middle = before.plus_seconds(30.0 * minutes_between(before, after));
        if holds(middle) { before = middle } else { after = middle }
    }
    after
}

/// Barnard at Lick Observatory, on the morning of 2 November 1889 (Monthly Notices 50, 107): Iapetus came out of the shadow of the globe, first seen at 5h25m
/// sidereal time (10:44 UT at a longitude of 121.64 degrees west), faintly; then it went through the shadow of the C ring, and vanished in that of the B ring.
/// He estimated its brightness for 2.6 hours (Bryan 2007, J. Astron. Hist. Heritage 10, 31), until 13:20 UT. Iapetus counts as seen here while it is less than
/// 2 magnitudes fainter than usual. At both ends it changes by a magnitude in 4 to 10 minutes, so the choice matters little. The tolerances are those of his
/// eye (he judged the first light to be that of Enceladus, which it has 9 minutes later), and of the positions (970 km, 5 minutes).
#[test]
fn iapetus_fades_in_the_shadow_of_the_rings_when_barnard_saw_it() {
    let sky = sky_of(Catalog::embedded());
    let iapetus = |time: Instant| magnitude(&sky, IAPETUS, time);
    // Between the globe's shadow and the rings'.
    let undimmed = iapetus(time("1889-11-02T11:20:00Z"));
    let is_seen = |time: Instant| iapetus(time) < undimmed + 2.0;
    let reappeared = end_of(|time| !is_seen(time), time("1889-11-02T10:30:00Z"), time("1889-11-02T11:15:00Z"));
    let late_min = minutes_between(time("1889-11-02T10:44:00Z"), reappeared);
    let vanished = end_of(is_seen, time("1889-11-02T12:30:00Z"), time("1889-11-02T14:00:00Z"));
    let vanished_late_min = minutes_between(time("1889-11-02T13:20:00Z"), vanished);
    println!("reappears {late_min:.1} min after Barnard saw it, vanishes {vanished_late_min:.1} min after his last estimate");
    assert!(late_min.abs() < 8.0, "{late_min}");
    assert!(vanished_late_min.abs() < 10.0, "{vanished_late_min}");
    // The C ring is translucent.
    let [before_rings, behind_c_ring] = ["1889-11-02T11:30:00Z", "1889-11-02T12:20:00Z"].map(|text| iapetus(time(text)) - undimmed);
    assert!(before_rings.abs() < 0.03 && (0.25..0.7).contains(&behind_c_ring), "{before_rings}, {behind_c_ring}");
    // Negative control: without rings Iapetus keeps its light.
    let bare = sky_with("[[ring]]\nbody = \"Saturn\"\nname = \"none\"\ninner_km = 7e4\nouter_km = 8e4\ntau_normal = 0.0\n");
    let without_rings = ["1889-11-02T12:20:00Z", "1889-11-02T13:30:00Z"].map(|text| magnitude(&bare, IAPETUS, time(text)) - undimmed);
    assert!(without_rings.iter().all(|fading| fading.abs() < 0.03), "{without_rings:?}");
}

/// When light from Iapetus in the shadow of the C ring left it, as Barnard saw it at 12:30.
const BEHIND_C_RING: &str = "1889-11-02T11:10:00Z";

/// A view of Iapetus in the shadow of the C ring, as a disc or as a point.
fn scene(distance_radii: f64, stops: f64, effects: &str) -> Scene {
    let request = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
        fov_deg: Some(20.0),
        width: 64,
        height: 64,
        exposure: ExposureRequest::Stops(stops),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(IAPETUS, time(BEHIND_C_RING))
    };
    SESSION.scene(&request).expect("a scene")
}

/// The fraction of green sunlight that the grid of a draw has for a point (body axes, equatorial radii), between its four places.
fn fraction_in_grid(draw: &Draw, point: DVec3) -> f64 {
    let Some(grid) = &draw.uniforms.ring.shadow_grid else { return 1.0 };
    let place = draw.uniforms.ring.shadow_grid_axes.map(|axis| axis.truncate().as_dvec3().dot(point) + f64::from(axis.w));
    let last = f64::from(grid.side - 1);
    let low = place.map(|k| k.clamp(0.0, last - 1.0).floor());
    let [u, v] = [place[0] - low[0], place[1] - low[1]];
    let at =
        |column: f64, row: f64| f64::from(grid.texels[4 * ((low[1] + row) as usize * grid.side as usize + (low[0] + column) as usize) + 1]);
    (at(0.0, 0.0) * (1.0 - u) + at(1.0, 0.0) * u) * (1.0 - v) + (at(0.0, 1.0) * (1.0 - u) + at(1.0, 1.0) * u) * v
}

/// Mean of the grid over the disc that the Sun sees, by the cosine of incidence.
fn mean_fraction_in_grid(draw: &Draw) -> f64 {
    const COUNT: u32 = 4000;
    let axes = draw.uniforms.ring.shadow_grid_axes.map(|axis| axis.truncate().as_dvec3().normalize_or_zero());
    let (mut light, mut left) = (0.0, 0.0);
    for k in 0..COUNT {
        let radius_sq = (f64::from(k) + 0.5) / f64::from(COUNT);
        let place = DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * radius_sq.sqrt();
        let cosine = (1.0 - radius_sq).sqrt();
        light += cosine;
        left += cosine * fraction_in_grid(draw, axes[0] * place.x + axes[1] * place.y);
    }
    left / light
}

fn globe_of(scene: &Scene, id: NaifId) -> Option<&Draw> {
    scene.draws.iter().find(|d| d.body == id && d.part == BodyPart::Globe)
}

/// The sunlight of the drawn disc that passes the rings, and the light of the point.
fn light(scene: &Scene) -> [Option<f64>; 2] {
    let point = scene.points.iter().find(|p| p.body == IAPETUS);
    let sunlight = |d: &Draw| f64::from(d.uniforms.lights[0].irradiance.y) * mean_fraction_in_grid(d);
    [globe_of(scene, IAPETUS).map(sunlight), point.map(|p| f64::from(p.flux.y))]
}

fn by_rings(scene: &Scene) -> (bool, String) {
    let decisions = &scene.body(IAPETUS).expect("Iapetus").decisions;
    let found: Vec<_> = decisions.iter().filter(|d| d.effect == "eclipse-by-rings").collect();
    assert_eq!(found.len(), 1, "decided once");
    (found[0].on, found[0].reason.to_string())
}

/// The mean over the disc, point, magnitude and `explain` have the same factor; disc and `probe` have the same fraction at a place. Without the effect
/// `eclipse`, images lack the shadow; the magnitude keeps it.
#[test]
fn disc_point_magnitude_explain_and_probe_agree() {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let query = json!({ "q": "sunlight", "body": "iapetus", "time": BEHIND_C_RING, "lat": 0.0, "lon": 0.0 });
    let answer = Prober { session: &SESSION, renderer: &renderer }.answer(&query.to_string()).expect("answers");
    let fraction = answer["fraction"].as_f64().expect("a number");
    assert!((0.4..0.9).contains(&fraction), "{answer}");
    assert!((answer["by"]["saturn rings"].as_f64().expect("by rings") - (1.0 - fraction)).abs() < 1e-6, "{answer}");
    // A disc of about 60 pixels, too dark to have glare, and a point of a fifth of a pixel, which is exposed longer to be visible.
    for (kind, distance_radii, stops, tolerance) in [(0, 6.0, 0.0, 0.012), (1, 2000.0, 8.0, 2e-3)] {
        let [with, without] = ["-planet-shine", "-planet-shine,-eclipse"].map(|effects| scene(distance_radii, stops, effects));
        let [dimmed, full] = [&with, &without].map(|scene| light(scene)[kind].expect("drawn"));
        let (is_on, reason) = by_rings(&with);
        assert!(is_on && reason.contains("Saturn"), "{reason}");
        let stated: f64 = reason.split(' ').find_map(|word| word.parse().ok()).expect("a number");
        assert!((0.5..0.8).contains(&stated), "{reason}");
        assert!((dimmed / full - stated).abs() < tolerance, "{dimmed} of {full}, not {stated}");
        if let Some(globe) = globe_of(&with, IAPETUS).filter(|_| kind == 0) {
            assert_eq!(globe.features.ring_shadow, RingShadow::OfPlanet);
            let drawn = fraction_in_grid(globe, DVec3::X);
            assert!((drawn - fraction).abs() < 0.03, "{drawn} is drawn, {fraction} by `probe`");
        }
        assert!(!by_rings(&without).0);
        assert!(globe_of(&without, IAPETUS).is_none_or(|globe| globe.features.ring_shadow == RingShadow::None));
        let [of_dimmed, of_full] = [&with, &without].map(|scene| scene.body(IAPETUS).and_then(|b| b.magnitude).expect("lit"));
        assert!((of_dimmed - of_full).abs() < 1e-9, "{of_dimmed}, {of_full}");
    }
}

/// The sunlight of Rhea at an instant, in f64 and km: positions by the ephemeris, the light that passes the rings by rays to points of the Sun's disc.
struct SunBehindRings<'a> {
    rhea_km: DVec3,
    /// Of the light that now reaches Rhea: where Saturn was as it passed, and where the Sun was as it left.
    saturn_km: DVec3,
    sun_km: DVec3,
    /// Saturn's equatorial axes.
    axes: [DVec3; 3],
    saturn: &'a Body,
    sun: &'a Body,
}

impl SunBehindRings<'_> {
    fn sunward(&self) -> DVec3 {
        (self.sun_km - self.rhea_km).normalize()
    }

    /// Fraction of the green light of the Sun's disc that passes the rings to a place, an offset from Rhea's centre.
    fn fraction_at(&self, offset_km: DVec3) -> f64 {
        const RAYS: u32 = 1200;
        let Photometry::Emissive { u1: [_, u1, _], u2: [_, u2, _] } = self.sun.photometry else { panic!("the Sun shines") };
        let (across, up) = self.sunward().any_orthonormal_pair();
        let in_saturn_axes = |v: DVec3| DVec3::from_array(self.axes.map(|axis| axis.dot(v)));
        let point = in_saturn_axes(self.rhea_km + offset_km - self.saturn_km);
        let (mut light, mut left) = (0.0, 0.0);
        for k in 0..RAYS {
            let radius_sq = (f64::from(k) + 0.5) / f64::from(RAYS);
            let on_disc = DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * (radius_sq.sqrt() * self.sun.radii_km.x);
            let ray = in_saturn_axes(self.sun_km + across * on_disc.x + up * on_disc.y - self.rhea_km - offset_km);
            let one_minus_mu = 1.0 - (1.0 - radius_sq).sqrt();
            let radiance = 1.0 - u1 * one_minus_mu - u2 * one_minus_mu * one_minus_mu;
            let part = -point.z / ray.z;
            let radius_km = (point + ray * part).truncate().length();
            let is_in = |r: &&orrery::catalog::Ring| r.inner_km <= radius_km && radius_km < r.outer_km;
            // Of overlapping rings the last counts.
            let ring = self.saturn.rings.iter().rev().find(is_in).filter(|_| part > 0.0);
            let sine = ray.z.abs() / ray.length();
            light += radiance;
            left += radiance * ring.map_or(1.0, |r| (-r.tau_normal / sine).exp());
        }
        left / light
    }
}

/// Days before the equinox of 11 August 2009, Rhea passes behind Saturn's rings, the Sun 0.06 and 0.14 degrees above their plane: their shadow is a dark line
/// on its disc, or two. Seen from the direction of the Sun, each pixel of the column through the middle of the disc has the light that the geometry in f64
/// gives it, and the line has its place and width. Negative control: the mean factor in place of the line.
#[test]
fn the_line_of_the_rings_on_rhea_is_where_the_geometry_puts_it() {
    const SIDE: u32 = 161;
    // Nearer than the rings, so that they are not in the image.
    const DISTANCE_RADII: f64 = 400.0;
    // The half angle of the image, in radii of Rhea at its distance.
    const HALF_SIDE_RADII: f64 = 1.1;
    let (catalog, ephemeris) = sky_of(Catalog::embedded());
    let [rhea, saturn, sun] = [RHEA, SATURN, NaifId::SUN].map(|id| catalog.body(id).expect("in the catalog"));
    let radius_km = rhea.radii_km.x;
    for (text, darkest) in [("2009-08-07T03:00:00Z", 0.2..0.75), ("2009-08-02T14:30:00Z", 0.0..0.6)] {
        let time = time(text);
        let left = time.plus_seconds(-DISTANCE_RADII * radius_km / 299_792.458);
        let rhea_km = ephemeris.state(RHEA, NaifId::SOLAR_SYSTEM_BARYCENTER, left, None).expect("a place").state.pos_km;
        let seen = |id: NaifId| ephemeris.light_time_position(id, rhea_km, left).expect("a place");
        let ((saturn_km, passed), (sun_km, _)) = (seen(SATURN), seen(NaifId::SUN));
        let icrf_from_saturn = ephemeris.body_from_icrf(SATURN, passed).expect("an orientation").transpose();
        let axes = [icrf_from_saturn.x_axis, icrf_from_saturn.y_axis, icrf_from_saturn.z_axis];
        let sunlight = SunBehindRings { rhea_km, saturn_km, sun_km, axes, saturn, sun };
        let sunward = sunlight.sunward();
        let request = ViewRequest {
            position: Position::Offset { body: RHEA, offset_km: sunward * DISTANCE_RADII * radius_km, axes: Axes::Icrf },
            fov_deg: Some(2.0 * (HALF_SIDE_RADII / DISTANCE_RADII).atan().to_degrees()),
            width: SIDE,
            height: SIDE,
            pixel_view: PixelView::Ring,
            layers: Layers { stars: false, ..Layers::default() },
            ..ViewRequest::of(RHEA, time)
        };
        let single_sample = SamplingQuality { samples: 1, anisotropy: 8 };
        let drawn = SESSION.draw(&request, single_sample, FrameImages::DisplayAndHdr).expect("drawn");
        let globe = globe_of(&drawn.scene, RHEA).expect("a disc");
        assert_eq!(globe.features.ring_shadow, RingShadow::OfPlanet);
        // North in the image, as the view has it: towards Rhea's pole.
        let pole = ephemeris.body_from_icrf(RHEA, left).expect("an orientation").transpose().z_axis;
        let north = (pole - sunward * pole.dot(sunward)).normalize();
        let mean = mean_fraction_in_grid(globe);
        let (mut largest, mut error_of_mean) = (0.0_f64, 0.0_f64);
        // For the image and by the geometry: blocked light, its moments along the column, and the darkest place.
        let mut moments = [[0.0_f64, 0.0, 0.0, 1.0]; 2];
        for row in 0..SIDE {
            let up_radii = HALF_SIDE_RADII * (1.0 - (2.0 * f64::from(row) + 1.0) / f64::from(SIDE));
            if up_radii.abs() > 0.95 {
                continue;
            }
            let depth_radii = (1.0 - up_radii * up_radii).sqrt();
            let expected = sunlight.fraction_at((north * up_radii + sunward * depth_radii) * radius_km);
            let found = f64::from(drawn.frame.hdr[(row * SIDE + SIDE / 2) as usize][1]);
            largest = largest.max((found - expected).abs());
            error_of_mean = error_of_mean.max((mean - expected).abs());
            for (moments, fraction) in moments.iter_mut().zip([found, expected]) {
                let blocked = 1.0 - fraction;
                let [sum, first, second, least] = *moments;
                *moments = [sum + blocked, first + blocked * up_radii, second + blocked * up_radii * up_radii, least.min(fraction)];
            }
        }
        let [(place, width, least), (expected_place, expected_width, expected_least)] = moments.map(|[sum, first, second, least]| {
            let place = first / sum;
            (place, (second / sum - place * place).sqrt(), least)
        });
        println!(
            "{text}: {largest:.4}; place {place:.4}, {expected_place:.4}; width {width:.4}, {expected_width:.4}; {least:.3}, {expected_least:.3}"
        );
        assert!(darkest.contains(&expected_least), "{text}: {expected_least}");
        assert!(largest < 0.03, "{text}: {largest}");
        assert!((place - expected_place).abs() < 0.01 && (width - expected_width).abs() < 0.01, "{text}: {place}, {width}");
        assert!(error_of_mean > 0.2, "{text}: the mean is as good: {error_of_mean}");
    }
}

/// A ring around the Earth, out to three quarters of the Moon's distance: at the full Moon of June 2024 sunlight, 23.4 degrees above the equator, passes it on
/// the way to the Moon, and is dimmed by the optical depth over the sine of that angle. The new Moon is on the near side of the ring.
#[test]
fn rings_of_a_users_catalog_dim_the_moon() {
    const OPTICAL_DEPTH: f64 = 0.5;
    let ring = format!("[[ring]]\nbody = \"Earth\"\nname = \"x\"\ninner_km = 7e3\nouter_km = 3e5\ntau_normal = {OPTICAL_DEPTH}\n");
    let (ringed, bare) = (sky_with(&ring), sky_of(Catalog::embedded()));
    let fading = |text: &str| magnitude(&ringed, NaifId::MOON, time(text)) - magnitude(&bare, NaifId::MOON, time(text));
    let expected = 2.5 * std::f64::consts::LOG10_E * OPTICAL_DEPTH / 23.43_f64.to_radians().sin();
    let full = fading("2024-06-22T01:00:00Z");
    assert!((full - expected).abs() < 0.03, "{full}, not {expected}");
    assert!(fading("2024-06-06T18:00:00Z").abs() < 1e-9);
}

/// The Moon two days before the full Moon, in the shadow of a ring around the Earth that leaves 0.28 of the sunlight, in a catalog with more entries. Returns
/// the decisions about the Moon: effect, whether it is on, and the reason.
fn decisions_in_ring_shadow(entries: &str, position: Position, effects: &str) -> Vec<(&'static str, bool, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let ring = "[[ring]]\nbody = \"Earth\"\nname = \"x\"\ninner_km = 7e3\nouter_km = 3e5\ntau_normal = 0.5\n";
    std::fs::write(folder.path().join("mine.toml"), format!("{ring}{entries}")).expect("written");
    let sources = Sources { catalogs: Some(folder.path().to_owned()), ..sources() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
    let request = ViewRequest {
        position,
        fov_deg: Some(40.0),
        width: 64,
        height: 64,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId::MOON, time("2024-06-20T01:00:00Z"))
    };
    let scene = session.scene(&request).expect("a scene");
    let moon = scene.body(NaifId::MOON).expect("the Moon");
    moon.decisions.iter().map(|d| (d.effect, d.on, d.reason.to_string())).collect()
}

/// Of ring-shine and planet-shine, which no shader has together, the stronger is drawn. The Moon's own ring gives it 1.8 times as much light as the Earth, or
/// half as much, because its light is sunlight that the Earth's ring dims. Negative control: without the shadow ring-shine is drawn.
#[test]
fn the_stronger_light_is_that_of_dimmed_sunlight() {
    let own_ring = "[[ring]]\nbody = \"Moon\"\nname = \"y\"\ninner_km = 2e3\nouter_km = 5e3\ntau_normal = 1.8e-5\n";
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(6.0) };
    for (effects, left_out, other) in
        [("+planet-shine,+ring-shine", "ring-shine", "planet-shine"), ("+planet-shine,+ring-shine,-eclipse", "planet-shine", "ring-shine")]
    {
        let decisions = decisions_in_ring_shadow(own_ring, position, effects);
        let is_left_out = |effect: &str| decisions.iter().any(|(name, on, _)| *name == effect && !on);
        assert!(is_left_out(left_out) && !is_left_out(other), "{effects}: {decisions:?}");
    }
}

/// Light of the Earth in the air of the Moon, relative to sunlight: 3.5 times as much if the Earth's ring dims sunlight to 0.28.
#[test]
fn planet_shine_in_air_is_compared_with_dimmed_sunlight() {
    let air = "[[atmosphere]]\nbody = \"Moon\"\ntop_km = 50.0\nsource = \"a test\"\n[[atmosphere.species]]\nname = \"gas\"\n\
               scattering_per_km = [0.01, 0.01, 0.01]\nabsorption_per_km = [0.0, 0.0, 0.0]\nscale_height_km = 8.0\n";
    let position = Position::Ground { body: NaifId::MOON, latitude_deg: 0.0, longitude_deg: 0.0, height_km: 0.0017 };
    let part = |effects: &str| -> f64 {
        let decisions = decisions_in_ring_shadow(air, position, effects);
        let (.., reason) = decisions.iter().find(|(name, ..)| *name == "planet-shine-in-air").expect("decided");
        reason.split(' ').find_map(|word| word.parse().ok()).expect("a number")
    };
    let (dimmed, undimmed) = (part("+planet-shine"), part("+planet-shine,-eclipse"));
    // The numbers have two digits.
    assert!((dimmed / undimmed * 0.2846 - 1.0).abs() < 0.1, "{dimmed}, {undimmed} in undimmed sunlight");
}
