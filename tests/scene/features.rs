//! Names of surface features, scale bar, caption and compass: at the right places, without overlaps, and steady while the view moves.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::catalog::{NaifId, nomenclature};
use orrery::scene::Scene;
use orrery::scene::labels::{LabelLayer, LabelMetrics, Rect};
use orrery::scene::request::{Axes, Layers, Look, Position, Up, ViewRequest};
use orrery::time::Instant;
use std::collections::BTreeSet;

const MOON: NaifId = NaifId::MOON;

fn view(target: i32, layers: &str, distance_radii: Option<f64>) -> ViewRequest {
    ViewRequest {
        layers: Layers::parse(layers).expect("layers"),
        position: Position::AboveTarget { towards: None, distance_radii },
        fov_deg: Some(20.0),
        ..ViewRequest::of(NaifId(target), Instant::parse("2024-04-16T01:00:00Z").expect("a time"))
    }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

fn layer(scene: &Scene) -> &LabelLayer {
    scene.labels.as_ref().expect("labels")
}

fn rects(layer: &LabelLayer) -> Vec<Rect> {
    layer.margin.occupied(&LabelMetrics::of_size(layer.glyph_px)).collect()
}

/// The centre of a name's rectangle.
fn middle(layer: &LabelLayer, name: &str) -> Option<DVec2> {
    let metrics = LabelMetrics::of_size(layer.glyph_px);
    let text = layer.margin.texts.iter().find(|t| t.text == name)?;
    Some(text.left_end_px + DVec2::new(0.5 * metrics.width_px(name), 0.0))
}

/// The unit-sphere point of a planetographic position, computed from the ellipsoid's normal: a method independent of the program's.
fn unit_point(radii_km: DVec3, lat_deg: f64, lon_deg: f64) -> DVec3 {
    let (lat, lon) = (lat_deg.to_radians(), lon_deg.to_radians());
    let normal = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    (normal * radii_km).normalize()
}

/// Known positions (gazetteer; planetocentric latitudes of Mars are converted to planetographic by the flattening) against the camera's
/// projection of the ground.
#[test]
fn names_are_placed_on_their_features() {
    let cases = [
        (301, "Mare Crisium", 16.18, 59.10),
        (301, "Mare Imbrium", 34.72, -14.91),
        (301, "Clavius", -58.62, -14.73),
        (499, "Olympus Mons", 18.65, 226.2),
    ];
    for (body, name, lat, lon) in cases {
        let mut request = view(body, "+features", Some(7.0));
        if body == 499 {
            let radius_km = SESSION.catalog().body(NaifId(499)).expect("Mars").radii_km.x;
            // Above 223 degrees east, near Olympus Mons.
            let offset_km = DVec3::new(f64::cos(3.9), f64::sin(3.9), 0.2).normalize() * 7.0 * radius_km;
            request.position = Position::Offset { body: NaifId(499), offset_km, axes: Axes::BodyFixed };
        }
        let scene = scene(&request);
        let placement = scene.body(NaifId(body)).expect("the body").placement;
        let axis_ratio = placement.radii_km.z / placement.radii_km.x;
        let planetographic_deg =
            if body == 499 { (f64::to_radians(lat).tan() / (axis_ratio * axis_ratio)).atan().to_degrees() } else { lat };
        let expected =
            scene.camera.pixel_of_surface(&placement, unit_point(placement.radii_km, planetographic_deg, lon)).expect("on this side");
        let found = middle(layer(&scene), name).unwrap_or_else(|| panic!("{name} is not named: {:?}", layer(&scene).margin.texts));
        assert!(found.distance(expected) < 3.0, "{name}: {found}, {expected}");
        let mirrored = scene.camera.pixel_of_surface(&placement, unit_point(placement.radii_km, planetographic_deg, -lon));
        assert!(mirrored.is_none_or(|m| m.distance(found) > 30.0), "{name}: a map mirrored in longitude would pass too");
    }
}

/// From several distances, on bodies with many names: no two texts overlap, all are inside the image, and named features are on the near
/// side.
#[test]
fn names_do_not_overlap_and_are_on_the_near_side() {
    let mut max_names = 0;
    for (body, distance) in [(301, 40.0), (301, 6.0), (301, 3.0), (301, 1.3), (499, 6.0), (299, 8.0), (606, 8.0), (199, 3.0), (401, 4.0)] {
        let scene = scene(&view(body, "+features,+labels,+caption,+scale-bar,+compass", Some(distance)));
        let layer = layer(&scene);
        let rects = rects(layer);
        max_names = max_names.max(rects.len());
        let texts = &layer.margin.texts;
        let placement = scene.body(NaifId(body)).expect("a body").placement;
        let name = &SESSION.catalog().body(NaifId(body)).expect("the body").name;
        for (k, a) in rects[..texts.len()].iter().enumerate() {
            assert!(a.min.min_element() >= 0.0 && a.max.cmple(DVec2::splat(1024.0)).all(), "{body} {distance}: {:?}", texts[k]);
            for (b, other) in rects[..texts.len()].iter().zip(texts).skip(k + 1) {
                assert!(!a.overlaps(b), "{body} {distance}: {} over {}", texts[k].text, other.text);
            }
        }
        for text in texts {
            let Some(f) = nomenclature::surface_features(name).iter().find(|f| f.name == text.text) else { continue };
            let unit = (f.direction / placement.radii_km).normalize();
            assert!(placement.camera_in_unit_sphere().dot(unit) > 1.0, "{} is on the far side", f.name);
        }
    }
    assert!(max_names > 30, "{max_names}");
}

/// A disc whose radius is 48 percent of the image's height has no name, so that no name of a feature avoids its place; one of 32 percent has a name.
#[test]
fn a_body_that_fills_the_image_is_not_named() {
    for (distance_radii, is_named) in [(6.0, false), (9.0, true)] {
        let scene = scene(&view(301, "+labels", Some(distance_radii)));
        let moon = layer(&scene).labels.iter().find(|l| l.body == MOON).expect("a label");
        assert_eq!(moon.name_side.is_some(), is_named, "{distance_radii}: {moon:?}");
    }
}

/// From the Earth, the six landing sites (Apollo 11, 12, 14 to 17) are named if the Moon is large in the image, and none if it is small.
#[test]
fn apollo_sites_are_named_only_on_a_large_moon() {
    let named = |fov_deg: f64| {
        let request = ViewRequest { position: Position::Centre(NaifId::EARTH), fov_deg: Some(fov_deg), ..view(301, "+features", None) };
        let scene = scene(&request);
        let margin = &layer(&scene).margin;
        assert!(margin.rings.is_empty());
        [margin.texts.iter().filter(|t| t.text.starts_with("Apollo 1")).count(), margin.sites.len()]
    };
    let [names, sites] = named(0.7);
    assert!(names == 6 && sites >= 6, "{names} names, {sites} sites");
    assert_eq!(named(5.0), [0, 0]);
}

/// During a slow approach: from step to step few names appear or disappear, and the others move by less than 1.5 pixels.
#[test]
fn names_are_steady_while_the_view_moves() {
    let mut previous: Option<Scene> = None;
    let (mut changes, mut names) = (0, 0);
    for k in 0..30 {
        let scene = scene(&view(301, "+features", Some(5.0 * 0.999_f64.powi(k))));
        if let Some(before) = &previous {
            let names_of = |s: &Scene| layer(s).margin.texts.iter().map(|t| t.text.clone()).collect::<BTreeSet<_>>();
            let (earlier, later) = (names_of(before), names_of(&scene));
            changes += earlier.symmetric_difference(&later).count();
            names += later.len();
            for name in earlier.intersection(&later) {
                let [from, to] = [before, &scene].map(|s| middle(layer(s), name).expect("there"));
                assert!(from.distance(to) < 1.5, "{name}: {from} to {to}");
            }
        }
        previous = Some(scene);
    }
    println!("{changes} of {names} names appeared or disappeared");
    assert!(changes * 25 < names, "{changes} of {names}");
}

/// The length in km (`Ok`) or the angle in radians (`Err`) that the scale bar states, and its length in pixels.
fn scale_bar(scene: &Scene) -> (Result<f64, f64>, f64) {
    let margin = &layer(scene).margin;
    let text = &margin.texts[0].text;
    let (number, unit) = text.rsplit_once(' ').unwrap_or_else(|| text.split_at(text.find(['°', '\'', '"']).expect("a unit")));
    let number: f64 = number.replace(' ', "").parse().expect("a number");
    let stated = match unit {
        "au" => Ok(number * 149_597_870.7),
        "km" => Ok(number),
        "m" => Ok(number * 1e-3),
        "mm" => Ok(number * 1e-6),
        "°" => Err(number.to_radians()),
        "'" => Err((number / 60.0).to_radians()),
        "\"" => Err((number / 3600.0).to_radians()),
        _ => panic!("unit {unit} in {text}"),
    };
    (stated, margin.bars[0].rect.max.x - margin.bars[0].rect.min.x)
}

/// From 1 m above the ground to 100 au, on the Earth, on flattened Saturn and on Phobos: the bar's length in pixels is the length written above it, at the
/// distance of the ground in the image's middle. It was that at the distance of the centre: from 1 m above the Earth, 6.4 million times as long.
#[test]
fn a_scale_bar_is_as_long_as_it_says_on_the_ground_in_the_middle() {
    for (target, latitude_deg) in [(399, 10.0), (699, 50.0), (401, -30.0)] {
        let radii_km = SESSION.catalog().body(NaifId(target)).expect("the body").radii_km;
        let unit = unit_point(radii_km, latitude_deg, 20.0);
        let normal = (unit / radii_km).normalize();
        // From 1 m on, two steps per decade.
        for k in 0..=27 {
            let height_km = (1e-3 * 10_f64.powf(f64::from(k) / 2.0)).min(100.0 * 149_597_870.7);
            let offset_km = unit * radii_km + normal * height_km;
            // Of a distant body, the disc fills most of the image.
            let fov_deg = (2.2 * radii_km.x / offset_km.length()).to_degrees().clamp(1e-7, 20.0);
            let request = ViewRequest {
                position: Position::Offset { body: NaifId(target), offset_km, axes: Axes::BodyFixed },
                fov_deg: Some(fov_deg),
                ..view(target, "+scale-bar", None)
            };
            let scene = scene(&request);
            // The image's middle shows the centre's direction, so that the ground is on the line to the centre.
            let placement = scene.body(NaifId(target)).expect("the body").placement;
            let camera_km = placement.camera_in_unit_sphere() * radii_km;
            let ground_km = camera_km.length() - 1.0 / (camera_km.normalize() / radii_km).length();
            assert!((0.95..1.3).contains(&(ground_km / height_km)) || height_km > radii_km.x, "{target}: {ground_km} for {height_km}");
            let (stated, length_px) = scale_bar(&scene);
            let length_km = length_px * scene.camera.pixel_tangent() * ground_km;
            let stated_km = stated.unwrap_or_else(|angle| panic!("{target} from {height_km} km: an angle of {angle}"));
            assert!((length_km / stated_km - 1.0).abs() < 0.02, "{target} from {height_km} km: {length_km} for {stated_km}");
            assert!((60.0..230.0).contains(&length_px), "{target} from {height_km} km: {length_px}");
        }
    }
}

/// Standing on Mars, looking east, 1.7 m above the ground: below the horizon the bar is for the ground in the image's middle, at height / sin(depression).
/// Above the horizon it is for the lowest row, which is 10 degrees below the middle.
#[test]
fn a_scale_bar_on_the_ground_is_for_ground_in_the_image() {
    let (latitude_deg, longitude_deg, height_km) = (10.0_f64, 40.0_f64, 0.0017);
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
    let (up, east) = (DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat), DVec3::new(-sin_lon, cos_lon, 0.0));
    // Altitude of the middle, and of the row that the bar is for relative to the middle, degrees.
    for (altitude_deg, row_deg) in [(2.0_f64, -10.0_f64), (-1.0, 0.0), (-5.0, 0.0), (-60.0, 0.0)] {
        let altitude = altitude_deg.to_radians();
        let scene = scene(&ViewRequest {
            position: Position::Ground { body: NaifId(499), latitude_deg, longitude_deg, height_km },
            look: Look::Along { direction: east * altitude.cos() + up * altitude.sin(), axes: Axes::BodyFixed },
            up: Up::Zenith,
            ..view(499, "+scale-bar", None)
        });
        let (stated, length_px) = scale_bar(&scene);
        let view_depth_km = stated.expect("a length") / (length_px * scene.camera.pixel_tangent());
        let expected_km = height_km / (-(altitude_deg + row_deg)).to_radians().sin() * row_deg.to_radians().cos();
        assert!((view_depth_km / expected_km - 1.0).abs() < 0.05, "{altitude_deg}: {view_depth_km}, not {expected_km}");
    }
}

/// For a target that is a point the bar states an angle.
#[test]
fn a_scale_bar_beside_a_small_target_is_an_angle() {
    let scene = scene(&view(699, "+scale-bar", Some(4000.0)));
    let (stated, length_px) = scale_bar(&scene);
    let angle = stated.expect_err("an angle");
    assert!((length_px * scene.camera.pixel_tangent() / angle - 1.0).abs() < 0.02, "{angle}: {length_px}");
    assert!((60.0..230.0).contains(&length_px), "{length_px}");
}

/// Below a radius the caption gives the height above the ground, else the distance of the centre.
#[test]
fn a_caption_near_a_body_gives_the_height() {
    let caption = |height_km: f64| {
        let offset_km = DVec3::X * (1737.4 + height_km);
        let position = Position::Offset { body: MOON, offset_km, axes: Axes::BodyFixed };
        let scene = scene(&ViewRequest { position, ..view(MOON.0, "+caption", None) });
        layer(&scene).margin.texts.iter().map(|t| format!("{}|", t.text)).collect::<String>()
    };
    for (height_km, expected) in [(0.15, "from 150 m above the surface"), (120.0, "from 120 km above the surface"), (3475.0, "km away")] {
        let text = caption(height_km);
        assert!(text.contains(expected), "{height_km}: {text}");
        assert_eq!(text.contains("km away"), height_km > 1737.4, "{height_km}: {text}");
    }
}

/// The caption states the target, time, viewpoint and field of view; the compass points up where north is up, and turns with the image.
#[test]
fn caption_and_compass_describe_the_view() {
    let shown = scene(&ViewRequest { width: 1400, ..view(699, "+caption,+compass", Some(20.0)) });
    let all: String = layer(&shown).margin.texts.iter().map(|t| format!("{}|", t.text)).collect();
    for part in ["Saturn", "2024-04-16 01:00", "UTC", "km away", "field of view 20.0°", "N|"] {
        assert!(all.contains(part), "{part}: {all}");
    }
    let compass_needle = |scene: &Scene| {
        let layer = layer(scene);
        middle(layer, "N").expect("a compass") - layer.margin.rings[0]
    };
    let to_north = compass_needle(&shown);
    assert!(to_north.y < -10.0 && to_north.x.abs() < 0.05 * to_north.y.abs(), "{to_north}");
    let pole = SESSION.ephemeris().body_from_icrf(NaifId(699), shown.time).expect("axes").row(2);
    let south_up = Up::Along { direction: -pole, axes: Axes::Icrf };
    let turned = scene(&ViewRequest { up: south_up, ..view(699, "+compass", Some(20.0)) });
    assert!(compass_needle(&turned).y > 10.0);
    assert!(scene(&view(MOON.0, "", Some(5.0))).labels.is_none());
}

/// From the ground a body above the horizon has a label, one below it has none: the Sun before and an hour after sunset, 10 degrees below.
#[test]
fn a_body_below_the_horizon_is_not_named() {
    for (time, is_visible) in [("1997-04-01T17:30:00Z", true), ("1997-04-01T19:30:00Z", false)] {
        let request = ViewRequest {
            layers: Layers::parse("+labels").expect("layers"),
            position: Position::Ground { body: NaifId::EARTH, latitude_deg: 45.0, longitude_deg: 0.0, height_km: 0.0017 },
            fov_deg: Some(50.0),
            width: 400,
            height: 300,
            ..ViewRequest::of(NaifId::SUN, Instant::parse(time).expect("a time"))
        };
        assert_eq!(layer(&scene(&request)).labels.iter().any(|l| l.body == NaifId::SUN), is_visible, "{time}");
    }
}

/// A view of a moon along a line that passes Saturn's centre at this many equatorial radii towards the pole; the polar radius is 0.902.
fn view_past_saturns_pole(moon: NaifId, height_radii: f64, layers: &str, fov_deg: f64) -> ViewRequest {
    let (saturn, time) = (NaifId(699), Instant::parse("2024-04-16T01:00:00Z").expect("a time"));
    let pole = SESSION.ephemeris().body_from_icrf(saturn, time).expect("an orientation").row(2);
    let moon_km = SESSION.ephemeris().state(moon, saturn, time, None).expect("placed").state.pos_km;
    let radius_km = SESSION.catalog().body(saturn).expect("Saturn").radii_km.x;
    ViewRequest {
        layers: Layers::parse(layers).expect("layers"),
        position: Position::Offset {
            body: saturn,
            offset_km: moon_km + (pole * (height_radii * radius_km) - moon_km) * 5.0,
            axes: Axes::Icrf,
        },
        fov_deg: Some(fov_deg),
        width: 512,
        height: 512,
        ..ViewRequest::of(moon, time)
    }
}

/// Where a moon is visible over Saturn's pole, it has its label and its features have their names; behind the disc there are none.
#[test]
fn a_moon_over_the_pole_of_an_oblate_planet_is_named() {
    let tethys = NaifId(603);
    for (height_radii, is_visible) in [(0.935, true), (0.8, false)] {
        let with_labels = scene(&view_past_saturns_pole(tethys, height_radii, "+labels", 10.0));
        assert_eq!(layer(&with_labels).labels.iter().any(|l| l.body == tethys), is_visible, "{height_radii}: the label");
        let with_features = scene(&view_past_saturns_pole(tethys, height_radii, "+features", 0.08));
        assert_eq!(!layer(&with_features).margin.texts.is_empty(), is_visible, "{height_radii}: the names of features");
    }
}
