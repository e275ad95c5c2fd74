//! User data in catalog layers: points, outlines and images at the right position on the ground or in the sky, at the right times.

use crate::support::session::session_over;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::ephemeris::apparent::aberrated;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::labels::Dot;
use orrery::scene::request::{Axes, Layers, Look, Position, Up, ViewRequest};
use orrery::scene::viewpoint::viewer;
use orrery::session::Session;
use orrery::time::Instant;
use std::path::Path;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };
/// Width and height of a request by default.
const SIDE: usize = 1024;
const LAYER: &str =
    "[[layer]]\nname = \"quakes\"\nfile = \"quakes.csv\"\nbody = \"Earth\"\nfade_days = 2.0\ncolour = \"#ff0000\"\nsize_px = 12.0\n";

fn view(time: &str) -> ViewRequest {
    // Over the sub-solar point. At 03:00 UTC it is noon in Tohoku, where the points of the layers are.
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(4.0) };
    ViewRequest { position, ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time")) }
}

fn write_layer(folder: &Path, layer: &str, table: &str) {
    std::fs::write(folder.join("layers.toml"), layer).expect("written");
    std::fs::write(folder.join("quakes.csv"), table).expect("written");
}

fn dots(session: &Session, request: &ViewRequest) -> (Scene, Vec<Dot>) {
    let scene = session.scene(request).expect("a scene");
    let dots = scene.labels.as_ref().map_or(Vec::new(), |l| l.dots.clone());
    (scene, dots)
}

/// Two points at opposite places appear at their time where the camera sees their ground, fade over the given days, and are never visible on
/// the far side.
#[test]
fn points_appear_at_their_time_and_place_and_fade() {
    let folder = tempfile::tempdir().expect("a folder");
    let places = [(38.3, 142.4), (-38.3, -37.6)];
    let rows = places.map(|(lat, lon)| format!("2024-03-11T03:00:00Z,{lat},{lon}\n"));
    write_layer(folder.path(), LAYER, &format!("time,lat_deg,lon_deg\n{}", rows.concat()));
    let (session, messages) = session_over(folder.path());
    assert!(dots(&session, &view("2024-03-11T02:59:00Z")).1.is_empty(), "the point is visible before its time");
    let mut visible_at = [0; 2];
    for hours in [0, 6, 12, 24, 36] {
        let request = ViewRequest {
            time: Instant::parse("2024-03-11T03:00:00Z").expect("a time").plus_seconds(3600.0 * f64::from(hours)),
            ..view("2024-03-11T03:00:00Z")
        };
        let (scene, dots) = dots(&session, &request);
        let earth = scene.body(NaifId::EARTH).expect("the Earth").placement;
        let pixels = places.map(|(lat, lon)| {
            let ground = ground_point_km(earth.radii_km, lat, lon, 0.0).0 / earth.radii_km;
            scene.camera.pixel_of_surface(&earth, ground)
        });
        assert_eq!(dots.len(), pixels.iter().flatten().count(), "{hours} h: {dots:?} for {pixels:?}");
        for (dot, expected) in dots.iter().zip(pixels.iter().flatten()) {
            assert!(dot.centre_px.distance(*expected) < 0.01, "{hours} h: {dot:?} for {expected}");
            // A new point has the opacity 0.9.
            let expected_opacity = 0.9 * (1.0 - f64::from(hours) / 48.0);
            assert!((dot.opacity - expected_opacity).abs() < 1e-6, "{hours} h: {}", dot.opacity);
        }
        for (count, pixel) in visible_at.iter_mut().zip(&pixels) {
            *count += usize::from(pixel.is_some());
        }
    }
    assert!(visible_at.iter().all(|count| *count > 0), "both points must be seen: {visible_at:?}");
    let much_later = dots(&session, &view("2024-03-13T03:00:01Z")).1;
    assert!(much_later.is_empty(), "{much_later:?}");
    let without_layer = ViewRequest { layers: Layers::parse("-data").expect("layers"), ..view("2024-03-11T03:00:00Z") };
    assert!(dots(&session, &without_layer).1.is_empty());
    // In the image, the pixel at the point is red.
    let request = view("2024-03-11T03:00:00Z");
    let drawn = session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn");
    let at = dots(&session, &request).1[0].centre_px;
    let pixel = drawn.frame.display[(at.y as usize) * SIDE + at.x as usize];
    assert!(pixel[0] > 200 && pixel[1] < 60 && pixel[2] < 60, "{pixel:?}");
    assert!(messages.lock().expect("a list").is_empty());
}

/// A point smaller than a pixel is fainter than one as large as a pixel, but visible wherever it lies relative to the pixels.
#[test]
fn small_points_are_faint_and_never_lost() {
    let places: Vec<String> = (0..40).map(|k| format!("{},{}\n", 20.0 + 0.83 * f64::from(k), 120.0 + 0.77 * f64::from(k))).collect();
    let table = format!("lat_deg,lon_deg\n{}", places.concat());
    let drawn = |layer: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        write_layer(folder.path(), layer, &table);
        let (session, _) = session_over(folder.path());
        let request = view("2024-03-11T03:00:00Z");
        let image = session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn").frame.display.clone();
        (image, dots(&session, &request).1)
    };
    let of_size = |px: &str| drawn(&LAYER.replace("12.0", px).replace("fade_days = 2.0\n", ""));
    let (small, points) = of_size("0.4");
    let (large, _) = of_size("1.0");
    let hidden = ViewRequest { layers: Layers::parse("-data").expect("layers"), ..view("2024-03-11T03:00:00Z") };
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("no-layer.toml"), "").expect("written");
    let without = session_over(folder.path()).0.draw(&hidden, SAMPLING, FrameImages::Display).expect("drawn").frame.display.clone();
    assert!(points.len() > 30, "{} points", points.len());
    for point in &points {
        let [x, y] = [point.centre_px.x as usize, point.centre_px.y as usize];
        let change = |image: &[[u8; 4]]| -> u32 {
            let pixels = (y - 1..y + 2).flat_map(|y| (x - 1..x + 2).map(move |x| y * SIDE + x));
            pixels
                .flat_map(|pixel| (0..3).map(move |channel| (pixel, channel)))
                .map(|(p, c)| u32::from(image[p][c].abs_diff(without[p][c])))
                .sum()
        };
        let (of_small, of_large) = (change(&small), change(&large));
        assert!(of_small >= 6, "the point at {:?} changes the image by {of_small} levels", point.centre_px);
        // The ratio of the areas is 6.25. Eight-bit levels are rounded in each pixel.
        let ratio = f64::from(of_large) / f64::from(of_small);
        assert!((4.5..9.0).contains(&ratio), "{of_large} for {of_small} levels at {:?}", point.centre_px);
    }
}

/// Errors name file, line and field, and no session opens.
#[test]
fn wrong_layers_are_refused() {
    let refused = |layer: &str, table: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        write_layer(folder.path(), layer, table);
        let e = orrery::session::read_catalog(Some(folder.path())).map(|_| ()).expect_err("refused").to_string();
        e.replace(&folder.path().display().to_string(), "")
    };
    assert!(refused(LAYER, "lat,lon\n1,2\n91,3\n").contains("quakes.csv:3: field lat_deg: `91`"));
    assert!(
        refused(&LAYER.replace("Earth", "Earht"), "lat,lon\n1,2\n").contains("layers.toml:4: body \"Earht\" is not the name of a body")
    );
    assert!(refused(&LAYER.replace("fade_days = 2.0", "fade_days = -2.0"), "lat,lon\n1,2\n").contains("layers.toml:5"));
    assert!(refused(&LAYER.replace("quakes.csv", "none.csv"), "lat,lon\n1,2\n").contains("none.csv"));
}

/// A FITS image with the given header cards and bytes.
fn fits(cards: &[(&str, &str)], [width, height]: [usize; 2], data: &[u8]) -> Vec<u8> {
    let mut text = format!("{:<80}", "SIMPLE  =                    T");
    let size = [("BITPIX", "8".to_owned()), ("NAXIS", "2".to_owned()), ("NAXIS1", width.to_string()), ("NAXIS2", height.to_string())];
    let given = cards.iter().map(|(k, v)| (*k, (*v).to_owned()));
    size.into_iter().chain(given).for_each(|(k, v)| text += &format!("{:<80}", format!("{k:<8}= {v:>20}")));
    text += &format!("{:<80}", "END");
    let mut bytes = format!("{text:<length$}", length = text.len().next_multiple_of(2880)).into_bytes();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

/// A session over a folder with these layers and files, and the folder, which must outlive it.
fn session_with(layer: &str, files: &[(&str, &[u8])]) -> (Session, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("layers.toml"), layer).expect("written");
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).expect("written"));
    (session_over(folder.path()).0, folder)
}

/// The outline of a square region lies on its parallels and meridians, is not drawn on the far side, and disappears with its layer.
#[test]
fn outlines_follow_their_coordinates() {
    let layer = "[[layer]]\nname = \"field\"\nfile = \"field.geojson\"\nbody = \"Earth\"\ncolour = \"#00ff00\"\n";
    let json = r#"{"type":"Polygon","coordinates":[[[130,20],[150,20],[150,40],[130,40],[130,20]]]}"#;
    let (session, _folder) = session_with(layer, &[("field.geojson", json.as_bytes())]);
    let request = view("2024-03-11T03:00:00Z");
    let scene = session.scene(&request).expect("a scene");
    let earth = scene.body(NaifId::EARTH).expect("the Earth").placement;
    let (body, segments) = scene.ground_lines.first().expect("lines");
    assert!(*body == NaifId::EARTH && segments.len() >= 4, "{}", segments.len());
    let half = scene.camera.half_size_px();
    let ends: Vec<DVec2> =
        segments.iter().flat_map(|p| p.ends).map(|e| (e.truncate().as_dvec2() * DVec2::new(1.0, -1.0) + 1.0) * half).collect();
    // Each end lies on one of the two parallels or meridians.
    for end in &ends {
        let ground = scene.camera.surface_under_pixel(&earth, *end).expect("on the disc");
        let normal = (ground / earth.radii_km).normalize();
        let (lat, lon) = (normal.z.asin().to_degrees(), normal.y.atan2(normal.x).to_degrees());
        let error_deg = [lat - 20.0, lat - 40.0, lon - 130.0, lon - 150.0].into_iter().map(f64::abs).fold(f64::INFINITY, f64::min);
        assert!(error_deg < 0.05 && (19.9..40.1).contains(&lat) && (129.9..150.1).contains(&lon), "{end}: {lat} {lon}");
    }
    // The outline passes each vertex and the middle of each side.
    for (lat, lon) in
        [(20.0, 130.0), (20.0, 150.0), (40.0, 150.0), (40.0, 130.0), (20.0, 140.0), (30.0, 150.0), (40.0, 140.0), (30.0, 130.0)]
    {
        let ground = ground_point_km(earth.radii_km, lat, lon, 0.0).0 / earth.radii_km;
        let at = scene.camera.pixel_of_surface(&earth, ground).expect("on the near side");
        let distance_px = ends.chunks(2).map(|p| distance_to_segment(p[0], p[1], at)).fold(f64::INFINITY, f64::min);
        assert!(distance_px < 0.15, "{lat} {lon}: {distance_px} pixels");
    }
    let drawn = session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn");
    let middle = scene.camera.pixel_of_surface(&earth, ground_point_km(earth.radii_km, 30.0, 150.0, 0.0).0 / earth.radii_km).expect("seen");
    let outline_is_drawn = |drawn: &orrery::session::DrawnFrame| {
        let at = |dx: i64| drawn.frame.display[(middle.y as usize) * SIDE + (middle.x as i64 + dx) as usize];
        (-2..=2).map(at).any(|p| p[1] > 100 && p[1] > p[0] + 50 && p[1] > p[2] + 50)
    };
    assert!(outline_is_drawn(&drawn));
    let without_layer = ViewRequest { layers: Layers::parse("-data").expect("layers"), ..request.clone() };
    assert!(session.scene(&without_layer).expect("a scene").ground_lines.is_empty());
    assert!(!outline_is_drawn(&session.draw(&without_layer, SAMPLING, FrameImages::Display).expect("drawn")));
    // From the other side none of the outline is visible.
    let night = view("2024-03-11T15:00:00Z");
    assert!(session.scene(&night).expect("a scene").ground_lines.is_empty());
}

/// Distance from a point to a line segment.
fn distance_to_segment(a: DVec2, b: DVec2, at: DVec2) -> f64 {
    let along = b - a;
    let t = if along.length_squared() > 0.0 { ((at - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    at.distance(a + along * t)
}

/// A white point in a sky image appears where a star with its coordinates would, at any exposure and with the viewer's aberration.
#[test]
fn a_sky_image_is_aligned_with_the_stars() {
    let (ra, dec) = (152.093_f64, 11.967_f64);
    let cards = [
        ("CTYPE1", "'RA---TAN'"),
        ("CTYPE2", "'DEC--TAN'"),
        ("CRVAL1", "151.9"),
        ("CRVAL2", "11.9"),
        ("CRPIX1", "50.5"),
        ("CRPIX2", "30.5"),
        ("CDELT1", "-0.005"),
        ("CDELT2", "0.005"),
    ];
    // The gnomonic projection, by the textbook's formula.
    let (ra_offset, dec_rad, centre_dec) = ((ra - 151.9).to_radians(), dec.to_radians(), 11.9_f64.to_radians());
    let cos_c = centre_dec.sin() * dec_rad.sin() + centre_dec.cos() * dec_rad.cos() * ra_offset.cos();
    let x = 50.5 - (dec_rad.cos() * ra_offset.sin() / cos_c).to_degrees() / 0.005;
    let y = 30.5 + ((centre_dec.cos() * dec_rad.sin() - centre_dec.sin() * dec_rad.cos() * ra_offset.cos()) / cos_c).to_degrees() / 0.005;
    let mut data = vec![0_u8; 100 * 60];
    // The four pixels around the position share the light of one white pixel, so that their centroid lies there.
    let (x0, y0) = (x.floor(), y.floor());
    for (k, weight) in
        [(1.0 - x.fract()) * (1.0 - y.fract()), x.fract() * (1.0 - y.fract()), (1.0 - x.fract()) * y.fract(), x.fract() * y.fract()]
            .into_iter()
            .enumerate()
    {
        let (px, py) = (x0 as usize + k % 2, y0 as usize + k / 2);
        data[(py - 1) * 100 + px - 1] = (255.0 * orrery::units::linear_to_srgb(weight)).round() as u8;
    }
    // A white pixel in a corner, so that percentile 100 is white.
    data[0] = 255;
    let layer = "[[layer]]\nname = \"field\"\nfile = \"field.fits\"\npercentiles = [0.0, 100.0]\n";
    let (session, _folder) = session_with(layer, &[("field.fits", &fits(&cards, [100, 60], &data))]);
    let direction = DVec3::new(dec_rad.cos() * ra.to_radians().cos(), dec_rad.cos() * ra.to_radians().sin(), dec_rad.sin());
    for (fov_deg, stops) in [(0.5, 0.0), (1.0, 8.0)] {
        let request = ViewRequest {
            target: None,
            position: Position::Centre(NaifId::EARTH),
            look: Look::Along { direction, axes: Axes::Icrf },
            up: Up::Celestial,
            fov_deg: Some(fov_deg),
            width: 400,
            height: 400,
            exposure: orrery::scene::request::ExposureRequest::Stops(stops),
            layers: Layers { data: true, ..Layers::NONE },
            ..view("2024-03-11T03:00:00Z")
        };
        let viewer = viewer(session.catalog(), session.ephemeris(), &request).expect("a viewer");
        let camera = &viewer.camera;
        let pixel_of = |v: DVec3| camera.pixel_from_clip(camera.clip(v).expect("ahead"));
        let at = pixel_of(aberrated(direction, viewer.sky_aberration_velocity_km_s));
        let drawn = session.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn");
        let texel_px = 0.005 / fov_deg * 400.0;
        let (mut sum, mut moment) = (0.0, DVec2::ZERO);
        for (k, p) in drawn.frame.hdr.iter().enumerate() {
            let place = DVec2::new((k % 400) as f64 + 0.5, (k / 400) as f64 + 0.5);
            if place.distance(at) < 3.0 * texel_px {
                sum += f64::from(p[1]);
                moment += place * f64::from(p[1]);
            }
        }
        let error_px = (moment / sum).distance(at);
        assert!(error_px < 0.1, "{fov_deg} degrees: {error_px} pixels");
        assert!((moment / sum).distance(pixel_of(direction)) > 2.0, "without aberration the position is some 20 arcseconds off");
        // White stays white at any exposure: the four pixels sum to one.
        let white = sum / texel_px.powi(2) / drawn.scene.exposure.white();
        assert!((white - 1.0).abs() < 0.05, "{fov_deg} degrees: {white}");
    }
}

/// A point in the sky is where a star with its coordinates would be drawn: with the viewer's aberration.
#[test]
fn a_point_in_the_sky_has_the_aberration_of_a_star() {
    let layer = "[[layer]]\nname = \"star\"\nfile = \"star.csv\"\n";
    let (session, _folder) = session_with(layer, &[("star.csv", &b"ra_deg,dec_deg\n152.093,11.967\n"[..])]);
    let direction = orrery::scene::sky::frames::unit_vector(152.093, 11.967);
    let request = ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction, axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(1.0),
        width: 400,
        height: 400,
        layers: Layers { data: true, ..Layers::NONE },
        ..view("2024-03-11T03:00:00Z")
    };
    let (scene, dots) = dots(&session, &request);
    let velocity_km_s = viewer(session.catalog(), session.ephemeris(), &request).expect("a viewer").sky_aberration_velocity_km_s;
    let pixel_of = |v: DVec3| scene.camera.pixel_from_clip(scene.camera.clip(v).expect("ahead"));
    assert_eq!(dots.len(), 1);
    let error_px = dots[0].centre_px.distance(pixel_of(aberrated(direction, velocity_km_s)));
    assert!(error_px < 0.01, "{error_px} pixels");
    // Negative control: without aberration the place is some 20 arcseconds, two pixels, off.
    assert!(dots[0].centre_px.distance(pixel_of(direction)) > 1.0, "{:?}", dots[0]);
}

/// An image of a body covers its ground at the position and orientation that the FITS header gives.
#[test]
fn an_image_of_a_body_covers_its_ground() {
    let cards = [
        ("CTYPE1", "'EALN-CAR'"),
        ("CTYPE2", "'EALT-CAR'"),
        ("CRVAL1", "130"),
        ("CRPIX1", "0.5"),
        ("CRPIX2", "-1.5"),
        ("CDELT1", "10"),
        ("CDELT2", "10"),
    ];
    // Longitude 130 to 150, latitude 20 to 40; only the north-east quarter is white.
    let layer = "[[layer]]\nname = \"map\"\nfile = \"map.fits\"\nbody = \"Earth\"\npercentiles = [0.0, 100.0]\n";
    let (session, _folder) = session_with(layer, &[("map.fits", &fits(&cards, [2, 2], &[0, 0, 0, 255]))]);
    let request = ViewRequest {
        effects: orrery::scene::effects::EffectOverrides::parse("-clouds,-atmosphere").expect("effects"),
        ..view("2024-03-11T03:00:00Z")
    };
    let drawn = session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn");
    let earth = drawn.scene.body(NaifId::EARTH).expect("the Earth").placement;
    let level = |lat: f64, lon: f64| {
        let at =
            drawn.scene.camera.pixel_of_surface(&earth, ground_point_km(earth.radii_km, lat, lon, 0.0).0 / earth.radii_km).expect("seen");
        drawn.frame.display[(at.y as usize) * SIDE + at.x as usize][1]
    };
    let (white, black) = (level(37.5, 147.5), [level(22.5, 132.5), level(37.5, 132.5), level(22.5, 147.5)]);
    assert!(black.iter().all(|b| *b < 20 && white > b + 100), "{white} {black:?}");
}

/// Errors of each format name file, line and field, and no session opens.
#[test]
fn wrong_files_of_each_format_are_refused() {
    let refused = |name: &str, body: &str, bytes: &[u8]| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("layers.toml"), format!("[[layer]]\nname = \"own\"\nfile = \"{name}\"\n{body}"))
            .expect("written");
        std::fs::write(folder.path().join(name), bytes).expect("written");
        let e = orrery::session::read_catalog(Some(folder.path())).map(|_| ()).expect_err("refused").to_string();
        e.replace(&folder.path().display().to_string(), "")
    };
    let earth = "body = \"Earth\"\n";
    let json = br#"{"type":"Point","coordinates":[10,99]}"#;
    assert!(refused("a.geojson", earth, json).contains("a.geojson:1: field coordinates: latitude 99"));
    assert!(refused("a.geojson", "", json).contains("a.geojson:1: its coordinates are on a body"));
    assert!(
        refused("a.kml", earth, b"<kml><Placemark><Point><coordinates>x</coordinates></Point></Placemark></kml>")
            .contains("a.kml:1: field coordinates: `x`")
    );
    assert!(refused("a.vot", "", b"<VOTABLE><RESOURCE/></VOTABLE>").contains("a.vot:1: no TABLE"));
    // A service that fails while it writes the rows says so after them.
    let cut_short = b"<VOTABLE><RESOURCE><TABLE><FIELD name=\"ra\"/><FIELD name=\"dec\"/><DATA><TABLEDATA><TR><TD>1</TD><TD>2</TD></TR></TABLEDATA></DATA></TABLE>\
        <INFO name=\"QUERY_STATUS\" value=\"ERROR\">disk full</INFO></RESOURCE></VOTABLE>";
    assert!(refused("a.vot", "", cut_short).contains("the service that wrote it says: disk full"));
    assert!(refused("a.fits", "", &fits(&[], [2, 2], &[1, 2, 3, 4])).contains("CTYPE1"));
    assert!(refused("a.fits", "", b"no image at all").contains("a.fits:1: header card 1: does not begin with SIMPLE"));
    assert!(refused("a.csv", "", b"\xff\xfe").contains("a.csv:1: not UTF-8 text"));
    assert!(refused("a.png", "", b"").contains("layers.toml:3"));
    let incomplete_overlay = format!("{earth}[[overlay]]\nbody = \"Earth\"\n");
    assert!(refused("a.csv", &incomplete_overlay, b"lat,lon\n1,2\n").contains("layers.toml"));
}
