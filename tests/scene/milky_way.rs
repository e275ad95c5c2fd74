//! The Milky Way and zodiacal light: positions, brightness, visibility; and panoramas supplied by the user.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::photometry::{irradiance_of_magnitude, magnitude};
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::scene::sky::frames::{SkyFrame, ecliptic_pole, unit_vector};
use orrery::scene::sky::zodiacal;
use orrery::session::{DrawnFrame, Session, Sources};
use orrery::time::Instant;
use orrery::units::KM_PER_AU;
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 1 };
const TIME: &str = "2024-06-07T00:00:00Z";

/// A view of the given layers alone in linear light, from the Earth's centre.
fn towards(look: DVec3, fov_deg: f64, layers: Layers) -> ViewRequest {
    ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: look, axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(fov_deg),
        width: 64,
        height: 64,
        purpose: Purpose::LINEAR,
        exposure: ExposureRequest::Stops(0.0),
        layers,
        effects: EffectOverrides::parse("-glow,-corona,-points").expect("effects"),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(TIME).expect("a time"))
    }
}

const MILKY_WAY: Layers = Layers { milky_way: true, ..Layers::NONE };
const ZODIACAL_LIGHT: Layers = Layers { zodiacal_light: true, ..Layers::NONE };

fn draw(session: &Session, request: &ViewRequest) -> DrawnFrame {
    session.draw(request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn")
}

/// Mean luminance of an image.
fn mean(drawn: &DrawnFrame) -> f64 {
    let sum: f64 = drawn.frame.hdr.iter().map(|p| orrery::units::luminance([p[0], p[1], p[2]].map(f64::from))).sum();
    sum / drawn.frame.hdr.len() as f64
}

/// V magnitude per square arc second of a radiance.
fn surface_magnitude(radiance: f64) -> f64 {
    let square_arc_second_sr = (PI / 180.0 / 3600.0).powi(2);
    magnitude(radiance / PI * square_arc_second_sr)
}

/// Mean luminance of a field around a position in Galactic coordinates.
fn mean_around(longitude_deg: f64, latitude_deg: f64, fov_deg: f64) -> f64 {
    mean(&draw(&SESSION, &towards(SkyFrame::Galactic.icrf_from_frame() * unit_vector(longitude_deg, latitude_deg), fov_deg, MILKY_WAY)))
}

/// Neighbouring galaxies and dark clouds of our own are where charts show them; a mirrored or rotated map would fail.
#[test]
fn the_milky_way_is_at_its_charted_position() {
    // NASA/IPAC Extragalactic Database: LMC 280.47 -32.89, SMC 302.80 -44.30; Coalsack 303 -1, between bright parts of Crux and Centaurus.
    for (name, l, b) in [("LMC", 280.47, -32.89), ("SMC", 302.80, -44.30)] {
        let (at_galaxy, mirrored, north) = (mean_around(l, b, 3.0), mean_around(-l, b, 3.0), mean_around(l, -b, 3.0));
        assert!(at_galaxy > 1.5 * mirrored && at_galaxy > 1.5 * north, "{name}: {at_galaxy:e}, mirrored {mirrored:e}, north {north:e}");
    }
    let (coalsack, beside) = (mean_around(302.5, -0.5, 3.0), mean_around(310.0, 0.0, 3.0).min(mean_around(295.0, -0.5, 3.0)));
    assert!(coalsack < 0.8 * beside, "Coalsack {coalsack:e}, beside {beside:e}");
    // Brighter towards the Galactic centre than away from it.
    assert!(mean_around(2.0, -4.0, 3.0) > 3.0 * mean_around(180.0, 0.0, 8.0));
}

/// The glow that star clusters leave in the map is at their places within 0.15 degrees. Negative control: read along the galactic axes, as the panorama's
/// documents name them, it is more than 0.3 degrees off.
#[test]
fn the_milky_way_is_aligned_with_the_stars() {
    let map_from_galactic = SkyFrame::DeepStarMaps.icrf_from_frame() * SkyFrame::Galactic.icrf_from_frame().transpose();
    // Right ascension and declination of J2000: SIMBAD.
    for (name, ra_deg, dec_deg) in [("omega Centauri", 201.697, -47.480), ("Praesepe", 130.1, 19.67), ("Pleiades", 56.601, 24.114)] {
        let place = unit_vector(ra_deg, dec_deg);
        // Along axes off by the difference, the image would be that of this place.
        let [offset_deg, offset_unaligned_deg] = [place, map_from_galactic * place].map(|look| {
            let drawn = draw(&SESSION, &towards(look, 2.5, MILKY_WAY));
            let light: Vec<f64> = drawn.frame.hdr.iter().map(|p| orrery::units::luminance([p[0], p[1], p[2]].map(f64::from))).collect();
            let mut sorted = light.clone();
            sorted.sort_by(f64::total_cmp);
            let glow_from = sorted[sorted.len() * 9 / 10];
            let (mut sum, mut weight) = (DVec2::ZERO, 0.0);
            for (k, value) in light.iter().enumerate() {
                let excess = (value - glow_from).max(0.0);
                sum += excess * (DVec2::new((k % 64) as f64, (k / 64) as f64) - 31.5);
                weight += excess;
            }
            (sum / weight).length() * 2.5 / 64.0
        });
        println!("{name}: {offset_deg:.3} degrees, along galactic axes {offset_unaligned_deg:.3}");
        assert!(offset_deg < 0.15 && offset_unaligned_deg > 0.3, "{name}: {offset_deg}, {offset_unaligned_deg}");
    }
}

/// Published values: 20 to 21 magnitudes per square arc second in the brightest clouds. At the Galactic poles all starlight and diffuse light
/// counts as 20 to 60 stars of tenth magnitude per square degree, 23.3 to 24.5 (Leinert et al. 1998, A&AS 127, 1, section 10). The map, from
/// which stars are taken out, must be fainter than that, by a magnitude at most. Measured: 24.9 and 25.0.
#[test]
fn the_milky_way_is_as_bright_as_published() {
    let cloud = surface_magnitude(mean_around(2.0, -4.0, 3.0));
    assert!((20.0..21.0).contains(&cloud), "{cloud}");
    for pole in [90.0, -90.0] {
        let at_pole = surface_magnitude(mean_around(0.0, pole, 20.0));
        println!("pole {pole}: {at_pole:.2}");
        assert!((24.5..25.5).contains(&at_pole), "{pole}: {at_pole}");
    }
    // Check of the scale: one square arc second with the flux of a star of that magnitude.
    let radiance = irradiance_of_magnitude(21.0) * PI / (PI / 180.0 / 3600.0_f64).powi(2);
    assert!((surface_magnitude(radiance) - 21.0).abs() < 1e-9);
}

/// At a field of view of one arc second all pixels agree to a thousandth, also after panning by up to an arc second.
#[test]
fn the_milky_way_is_steady_at_one_arc_second() {
    let direction = SkyFrame::Galactic.icrf_from_frame() * unit_vector(1.0, -3.0);
    let sideways = direction.any_orthonormal_vector();
    let draw_at = |arcsec: f64| draw(&SESSION, &towards(direction + sideways * (arcsec / 206_264.8), 1.0 / 3600.0, MILKY_WAY));
    let first = draw_at(0.0);
    let level = mean(&first);
    for arcsec in [0.0, 0.1, 0.2, 0.3, 0.5, 1.0] {
        let drawn = draw_at(arcsec);
        let deviation = drawn.frame.hdr.iter().map(|p| (f64::from(p[1]) / f64::from(first.frame.hdr[0][1]) - 1.0).abs()).fold(0.0, larger);
        assert!(deviation < 1e-3 && level > 0.0, "{arcsec}: {deviation:e}");
    }
}

/// The zodiacal light in the image is that of `zodiacal::brightness`, computed in f64 for the ray through a pixel, from the ecliptic to its pole
/// and round to the gegenschein.
#[test]
fn zodiacal_light_follows_its_law() {
    let probe = draw(&SESSION, &towards(DVec3::X, 60.0, ZODIACAL_LIGHT));
    let sun = probe.scene.body(NaifId::SUN).expect("in the catalog").placement.centre_km;
    let (to_sun, sun_distance_au) = (sun.normalize(), sun.length() / KM_PER_AU);
    for look in [to_sun, -to_sun, ecliptic_pole(), to_sun.cross(ecliptic_pole()), DVec3::new(0.2, 0.9, -0.5)] {
        let drawn = draw(&SESSION, &towards(look, 100.0, ZODIACAL_LIGHT));
        let camera = &drawn.scene.camera;
        let has_corona = drawn.scene.corona.is_some();
        let mut compared = 0;
        for y in (2..64).step_by(6) {
            for x in (2..64).step_by(6) {
                let ray = camera.ray(camera.clip_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))).normalize();
                let elongation_deg = ray.dot(to_sun).acos().to_degrees();
                // Near the Sun the light blends into the corona.
                if elongation_deg < 27.0 {
                    continue;
                }
                let expected = zodiacal::brightness(ray.dot(to_sun), ray.dot(ecliptic_pole())) * zodiacal::unit_radiance(sun_distance_au);
                let drawn_radiance = f64::from(drawn.frame.hdr[(y * 64 + x) as usize][1]);
                compared += 1;
                assert!(
                    (drawn_radiance / expected - 1.0).abs() < 1e-3,
                    "{look}, {x} {y}: {drawn_radiance:e} for {expected:e}, corona {has_corona}"
                );
            }
        }
        assert!(compared > 80, "{compared}");
    }
    // Farther from the Sun it is fainter, by a power of the distance.
    assert!((zodiacal::unit_radiance(5.2) / zodiacal::unit_radiance(1.0) - 5.2_f64.powf(-2.3)).abs() < 1e-12);
}

/// Automatic exposure of nothing but stars shows the star clouds in Sagittarius, as photographs do: half of the pixels at 35 to 110 of 255. Negative control:
/// at the exposure of EV -4, 2.5 stops shorter, they are nearly black.
#[test]
fn automatic_exposure_shows_the_milky_way() {
    let linear = towards(SkyFrame::Galactic.icrf_from_frame() * unit_vector(2.0, -3.5), 12.0, MILKY_WAY);
    let automatic = ViewRequest { purpose: Purpose::Display, exposure: ExposureRequest::Auto, ..linear };
    let median = |request: &ViewRequest| {
        let drawn = draw(&SESSION, request);
        let mut levels: Vec<u8> = drawn.frame.display.iter().map(|p| p[0].max(p[1]).max(p[2])).collect();
        levels.sort_unstable();
        (levels[levels.len() / 2], drawn.scene.exposure)
    };
    let (level, exposure) = median(&automatic);
    assert!((35..110).contains(&level), "{level}; {}", exposure.reason);
    let (before, _) = median(&ViewRequest { exposure: ExposureRequest::Stops(exposure.stops - 2.5), ..automatic });
    assert!(before < 28, "{before}");
}

/// Next to a lit planet, neither layer is visible, drawn or loaded. A boost lifts both and the stars; the layer switch removes them; each
/// decision states its reason.
#[test]
fn the_exposure_decides_what_is_visible() {
    let saturn = |stars_boost_stops: f64, layers: Layers| {
        let base = ViewRequest::of(NaifId(699), Instant::parse(TIME).expect("a time"));
        let position = Position::AboveTarget { towards: None, distance_radii: Some(6.0) };
        SESSION
            .draw(&ViewRequest { position, width: 64, height: 64, stars_boost_stops, layers, ..base }, SAMPLING, FrameImages::DisplayAndHdr)
            .expect("drawn")
    };
    let decision_of = |drawn: &DrawnFrame, effect: &str| {
        drawn.scene.sky_decisions.iter().find(|d| d.effect == effect).map(|d| (d.on, d.reason.to_string()))
    };
    let background_draws = |drawn: &DrawnFrame| drawn.simple_draws.iter().filter(|d| d.module == "sky_background").count();
    let unboosted = saturn(0.0, Layers::default());
    assert!(unboosted.scene.background.is_none() && background_draws(&unboosted) == 0);
    for effect in ["milky-way", "zodiacal-light"] {
        assert!(
            decision_of(&unboosted, effect).is_some_and(|(on, why)| !on && why.contains("× white (threshold")),
            "{:?}",
            unboosted.scene.sky_decisions
        );
    }
    let boosted = saturn(16.0, Layers::default());
    assert!(
        background_draws(&boosted) == 1 && boosted.scene.stars.len() > 20 && decision_of(&boosted, "milky-way").is_some_and(|(on, _)| on),
        "{:?}",
        boosted.scene.sky_decisions
    );
    // The planet keeps its light and hides the sky behind it.
    let without_stars = saturn(16.0, Layers { stars: false, ..Layers::default() });
    let centre = 32 * 64 + 32;
    assert_eq!(without_stars.frame.hdr[centre], saturn(0.0, Layers::NONE).frame.hdr[centre]);
    assert!(without_stars.frame.hdr[0][1] > 0.0);
    let without_layers = saturn(16.0, Layers::NONE);
    assert!(
        background_draws(&without_layers) == 0
            && decision_of(&without_layers, "milky-way") == Some((false, "set by you".into()))
            && without_layers.frame.hdr[0][1] == 0.0
    );
    // The light increases by the factor that the stops imply.
    let base = towards(unit_vector(266.0, -29.0), 20.0, Layers { milky_way: true, zodiacal_light: true, ..Layers::NONE });
    let ratio = mean(&draw(&SESSION, &ViewRequest { stars_boost_stops: 3.0, ..base.clone() })) / mean(&draw(&SESSION, &base));
    assert!((ratio - 8.0).abs() < 1e-3, "{ratio}");
}

/// A panorama with one red spot: the spot appears where the panorama's frame puts it, both from a flat image and from the faces of a cube.
#[test]
fn a_users_panorama_is_placed_in_its_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let red_spot = |width: u32, height: u32, at: [u32; 2]| {
        let inside = |x: u32, y: u32| x.abs_diff(at[0]) < 6 && y.abs_diff(at[1]) < 6;
        image::RgbImage::from_fn(width, height, |x, y| image::Rgb(if inside(x, y) { [255, 0, 0] } else { [20, 20, 20] }))
    };
    // Longitude 90, latitude 30: a quarter to the left of the middle, two thirds up.
    let flat = folder.path().join("flat.png");
    red_spot(360, 180, [90, 60]).save(&flat).expect("written");
    // The face to the left of the middle face is the face of longitude 90, nx. The other faces have no spot.
    let cube = folder.path().join("cube");
    std::fs::create_dir(&cube).expect("a folder");
    for face in ["px", "nx", "py", "ny", "pz", "nz"] {
        // 30 degrees above the middle of a face: 64 pixels times the tangent.
        let at = if face == "nx" { [64, 27] } else { [500, 500] };
        red_spot(128, 128, at).save(cube.join(format!("{face}.png"))).expect("written");
    }
    for (sky, frame) in [
        (flat.clone(), SkyFrame::Galactic),
        (flat, SkyFrame::Equatorial),
        (cube.clone(), SkyFrame::Ecliptic),
        (cube.join("*.png"), SkyFrame::Galactic),
    ] {
        let sources = Sources { sky: Some(sky.clone()), sky_frame: frame, cache: Some(folder.path().join("cache")), ..Sources::default() };
        let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
        let redness = |longitude: f64, latitude: f64| {
            let drawn = draw(&session, &towards(frame.icrf_from_frame() * unit_vector(longitude, latitude), 1.0, MILKY_WAY));
            let p = drawn.frame.hdr[32 * 64 + 32];
            f64::from(p[0]) / f64::from(p[1])
        };
        assert!(redness(90.0, 30.0) > 20.0, "{} {frame:?}: {}", sky.display(), redness(90.0, 30.0));
        for (longitude, latitude) in [(270.0, 30.0), (90.0, -30.0), (0.0, 30.0), (90.0, 60.0)] {
            assert!(redness(longitude, latitude) < 1.1, "{} {frame:?}: {longitude} {latitude}", sky.display());
        }
    }
}

/// An EXR with a bright patch of 0.2 % of the sky, 10,000 times as bright as the rest: both are drawn with their luminances.
#[test]
fn an_exr_panorama_keeps_faint_and_bright_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let sky = folder.path().join("sky.exr");
    // Around longitude 90, latitude 30.
    let luminance = |x: u32, y: u32| if x.abs_diff(90) < 6 && y.abs_diff(60) < 6 { 10.0_f32 } else { 1e-3 };
    let pixels = image::Rgb32FImage::from_fn(360, 180, |x, y| image::Rgb([luminance(x, y); 3]));
    image::DynamicImage::ImageRgb32F(pixels).save(&sky).expect("written");
    let sources = Sources { sky: Some(sky), cache: Some(folder.path().join("cache")), ..Sources::default() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
    let light = |longitude: f64, latitude: f64| {
        mean(&draw(&session, &towards(sources.sky_frame.icrf_from_frame() * unit_vector(longitude, latitude), 1.0, MILKY_WAY)))
    };
    let (bright, faint) = (light(90.0, 30.0), light(270.0, -30.0));
    // 5 %: half a step of the 8-bit texel is 3 % at a hundredth of the texel value 1, where the faint light is.
    assert!((bright / faint / 1e4 - 1.0).abs() < 0.05, "{bright:e} {faint:e}");
}

/// A file that is not a sky panorama gives one line that names the file and the cause.
#[test]
fn a_bad_panorama_gives_one_error_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("text.png"), "no image").expect("written");
    image::RgbImage::new(100, 80).save(path("square.png")).expect("written");
    std::fs::create_dir(path("cube")).expect("a folder");
    image::RgbImage::new(8, 8).save(path("cube/px.png")).expect("written");
    image::RgbImage::new(8, 9).save(path("f_px.png")).expect("written");
    for (name, why) in [
        ("text.png", "PNG, JPG, EXR"),
        ("square.png", "twice as wide as high"),
        ("missing.png", "missing.png"),
        ("cube", "no nx.png"),
        ("f_*.png", "squares of one size"),
    ] {
        let sources = Sources { sky: Some(path(name)), cache: Some(path("cache")), ..Sources::default() };
        let error = Session::open(&sources, |_| ()).err().expect(name).to_string();
        assert!(error.contains(why) && error.contains("--sky") && !error.contains('\n'), "{name}: {error}");
    }
}
