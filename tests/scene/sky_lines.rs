//! Lines of the sky and of the ground: they run through the correct positions, are smooth at every field of view, lie behind bodies, and
//! disappear when switched off.

use crate::support::folds::{larger, smaller};
use crate::support::session::SESSION;
use glam::{DVec2, DVec3, Vec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::ephemeris::apparent::aberrated;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::annotation::strokes::LineSegment;
use orrery::scene::camera::Camera;
use orrery::scene::request::{Axes, Layers, Look, Position, Up, ViewRequest};
use orrery::scene::sky::frames::{SkyFrame, unit_vector};
use orrery::scene::sky::stars::StarPlacer;
use orrery::scene::viewpoint::viewer;
use orrery::time::Instant;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 1 };
const FIELDS_DEG: [f64; 7] = [1.0 / 60.0, 0.2, 2.0, 20.0, 60.0, 120.0, 170.0];

fn only(layer: &str) -> Layers {
    let mut layers = Layers::NONE;
    *layers.switch_by_name(layer).expect("a layer") = true;
    layers
}

fn towards(look: DVec3, fov_deg: f64, layers: Layers) -> ViewRequest {
    ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: look, axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(fov_deg),
        width: 500,
        height: 400,
        layers,
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-12-07T20:00:00Z").expect("a time"))
    }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

fn pixel(camera: &Camera, end: Vec3) -> DVec2 {
    camera.pixel_from_clip(end.truncate().as_dvec2())
}

/// Distance in pixels from a position to the nearest line segment.
fn distance_px(camera: &Camera, segments: &[LineSegment], at: DVec2) -> f64 {
    let distance_to = |p: &LineSegment| {
        let [a, b] = p.ends.map(|e| pixel(camera, e));
        let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
        at.distance(a.lerp(b, t))
    };
    segments.iter().map(distance_to).fold(f64::INFINITY, smaller)
}

/// The vertices of Orion's figure are its stars, including proper motion and the aberration by the Earth's velocity, at fields of view from
/// the entire constellation to one minute of arc.
#[test]
fn figures_join_their_stars() {
    for (hip, fov_deg) in [(27_989, 40.0), (24_436, 40.0), (26_311, 3.0), (25_336, 0.2), (27_989, 1.0 / 60.0)] {
        let star = *SESSION.catalog().stars().star_of_hip(hip).expect("in the catalog");
        let request = towards(star.direction, fov_deg, only("constellations"));
        let built = scene(&request);
        let viewer = viewer(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a viewer");
        let apparent = StarPlacer::of(SESSION.catalog(), &viewer, &request).place(&star).direction;
        let at = built.camera.pixel_from_clip(built.camera.clip(apparent).expect("in front"));
        let nearest_px =
            built.sky_lines.iter().flat_map(|p| p.ends).map(|e| pixel(&built.camera, e).distance(at)).fold(f64::INFINITY, smaller);
        assert!(nearest_px < 0.05, "HIP {hip}, {fov_deg} degrees: {nearest_px}");
        // Without aberration the position would be off by up to 20 arc seconds.
        let without_aberration = built.camera.pixel_from_clip(built.camera.clip(star.direction).expect("in front"));
        assert!(
            fov_deg > 0.1 || without_aberration.distance(at) > 10.0,
            "the comparison must be able to fail: {}",
            without_aberration.distance(at)
        );
        assert!(
            built.sky_decisions.iter().any(|d| d.effect == "constellations" && d.on && d.reason.to_string().contains("Ori")),
            "{:?}",
            built.sky_decisions
        );
    }
    let named = scene(&towards(unit_vector(83.0, 0.0), 50.0, only("constellations")));
    assert!(named.line_texts.expect("names").texts.iter().any(|t| t.text == "Orion"));
}

/// In -2800 the sky turned about a point near Thuban, 26 degrees from the pole of the ICRF: there the meridians of the grid of date meet.
#[test]
fn the_equatorial_grid_of_date_has_the_pole_of_the_sky() {
    let time = Instant::parse("-2800-01-01T00:00:00Z").expect("a time");
    let pole = SESSION.ephemeris().body_from_icrf(NaifId::EARTH, time).expect("the Earth").row(2);
    let icrf_from_date = orrery::ephemeris::orientation::true_of_date_from_gcrs(time).transpose();
    assert!(orrery::ephemeris::angle_rad(icrf_from_date * DVec3::Z, pole).to_degrees() < 1e-3);
    assert!((orrery::ephemeris::angle_rad(pole, DVec3::Z).to_degrees() - 26.0).abs() < 1.0, "{pole}");
    // The largest distance from the lines of four points beside the pole, on the meridians of 0, 6, 12 and 18 hours.
    let largest_distance_px = |layer: &str| {
        let request = ViewRequest { time, ..towards(pole, 2.0, only(layer)) };
        let built = scene(&request);
        let velocity = viewer(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a viewer").sky_aberration_velocity_km_s;
        let distances = [0.0, 90.0, 180.0, 270.0].map(|ra_deg| {
            let clip = built.camera.clip(aberrated(icrf_from_date * unit_vector(ra_deg, 89.7), velocity)).expect("in front");
            distance_px(&built.camera, &built.sky_lines, built.camera.pixel_from_clip(clip))
        });
        distances.into_iter().fold(0.0, larger)
    };
    assert!(largest_distance_px("grid-equatorial-date") < 0.25, "{} px", largest_distance_px("grid-equatorial-date"));
    // Negative control.
    assert!(largest_distance_px("grid-equatorial") > 3.0, "{} px", largest_distance_px("grid-equatorial"));
}

/// The lines of each grid lie at their coordinates, in every frame and field of view, and no chord deviates from its circle.
#[test]
fn grids_run_through_their_coordinates() {
    for (layer, frame) in
        [("grid-equatorial", SkyFrame::Equatorial), ("grid-ecliptic", SkyFrame::Ecliptic), ("grid-galactic", SkyFrame::Galactic)]
    {
        for (longitude, latitude) in [(90.0, 30.0), (0.0, 0.0), (210.0, -60.0), (270.0, 90.0)] {
            let request_at = |fov_deg: f64| towards(frame.icrf_from_frame() * unit_vector(longitude, latitude), fov_deg, only(layer));
            for fov_deg in FIELDS_DEG {
                let request = request_at(fov_deg);
                let built = scene(&request);
                let velocity = viewer(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a viewer").sky_aberration_velocity_km_s;
                assert!(!built.sky_lines.is_empty() && built.sky_lines.len() < 40_000, "{layer} {fov_deg}: {}", built.sky_lines.len());
                let apparent_px = |lon: f64, lat: f64| {
                    let clip = built.camera.clip(aberrated(frame.icrf_from_frame() * unit_vector(lon, lat), velocity));
                    clip.filter(|c| c.abs().max_element() < 0.999).map(|c| built.camera.pixel_from_clip(c))
                };
                // Multiples of 90 degrees are lines in every view; test points along them, also between the segments' ends.
                let extent_deg = (fov_deg / 2.0).min(60.0);
                for k in -50..=50 {
                    let offset_deg = extent_deg * f64::from(k) / 50.0;
                    let lat = (latitude + offset_deg).clamp(-90.0, 90.0);
                    let meridian = (longitude / 90.0_f64).round() * 90.0;
                    for at in [apparent_px(meridian, lat), (latitude == 0.0).then(|| apparent_px(longitude + offset_deg, 0.0)).flatten()]
                        .into_iter()
                        .flatten()
                    {
                        let distance = distance_px(&built.camera, &built.sky_lines, at);
                        assert!(distance < 0.25, "{layer} about {longitude} {latitude}, {fov_deg} degrees, {offset_deg}: {distance}");
                    }
                }
                for segment in &built.sky_lines {
                    // Reversed depth 0 is infinitely far.
                    let is_valid =
                        segment.ends.iter().all(|e| e.is_finite() && e.z == 0.0) && segment.opacity.iter().all(|s| (0.0..=1.0).contains(s));
                    assert!(is_valid && segment.normals.iter().all(|a| (a.length() - 1.0).abs() < 1e-4), "{layer} {fov_deg}: {segment:?}");
                }
            }
        }
    }
    // The comparison must be able to fail.
    let built = scene(&towards(unit_vector(90.0, 33.0), 20.0, only("grid-ecliptic")));
    let beside = built.camera.pixel_from_clip(built.camera.clip(unit_vector(91.7, 31.7)).expect("in front"));
    assert!(distance_px(&built.camera, &built.sky_lines, beside) > 5.0);
}

/// After panning by up to 2 pixels, every line is about as near to a line of the first frame: no line appears or jumps within the frame. After
/// 20 pixels some line is far from those of the first frame, so the comparison can fail.
#[test]
fn lines_do_not_jump_when_panning() {
    let middle = unit_vector(100.0, 75.0);
    let sideways = middle.any_orthonormal_vector();
    let first = scene(&towards(middle, 30.0, only("grid-equatorial")));
    let pixel_rad = first.camera.pixel_tangent();
    // The greatest distance of a line of the panned frame from those of the first.
    let greatest_distance_px = |pan_px: f64| {
        let next = scene(&towards(middle + sideways * (pan_px * pixel_rad), 30.0, only("grid-equatorial")));
        let ends = next.sky_lines.iter().filter(|p| p.opacity[0] > 0.05).map(|p| pixel(&next.camera, p.ends[0]));
        let inside = ends.filter(|at| at.cmpgt(DVec2::splat(15.0)).all() && at.cmplt(DVec2::new(485.0, 385.0)).all());
        let distances: Vec<f64> = inside.map(|at| distance_px(&first.camera, &first.sky_lines, at)).collect();
        assert!(distances.len() > 20, "{} ends of line segments", distances.len());
        distances.into_iter().fold(0.0, larger)
    };
    for pan_px in [0.5, 1.0, 2.0] {
        let distance = greatest_distance_px(pan_px);
        assert!(distance < 2.0 * pan_px + 0.3, "{pan_px}: a line is {distance} pixels away from all lines of the first frame");
    }
    // The bound for a pan of 2 pixels.
    assert!(greatest_distance_px(20.0) > 4.3, "{}", greatest_distance_px(20.0));
}

/// On the ground, the celestial pole is in the north at an altitude equal to the latitude. A viewer that is not on the ground has no
/// horizon, and the decision's reason says so.
#[test]
fn the_horizon_is_that_of_the_viewers_location() {
    let (latitude_deg, longitude_deg) = (52.0, 13.4);
    let from_ground = |look: DVec3, fov_deg: f64| ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km: 0.002 },
        look: Look::Along { direction: look, axes: Axes::BodyFixed },
        up: Up::Zenith,
        ..towards(look, fov_deg, only("grid-horizon"))
    };
    let earth = orrery::catalog::Catalog::embedded().body(NaifId::EARTH).expect("the Earth").radii_km;
    let (_, zenith) = ground_point_km(earth, latitude_deg, longitude_deg, 0.0);
    let built = scene(&from_ground(DVec3::Z, 40.0));
    // The pole of rotation, body-fixed z, is on the meridian (the half circle of azimuth 0), which is the vertical line through the middle
    // of the image.
    let middle = DVec2::new(250.0, 200.0);
    assert!(distance_px(&built.camera, &built.sky_lines, middle) < 0.1, "{}", distance_px(&built.camera, &built.sky_lines, middle));
    // The middle is at altitude 52; lines are drawn every 10 degrees, at 50 and 60: 2 degrees below the middle and 8 above.
    let px_of = |deg: f64| f64::to_radians(deg).tan() / built.camera.pixel_tangent();
    for (up_deg, is_line) in [(-2.0, true), (8.0, true), (3.0, false)] {
        let at = middle - DVec2::new(40.0, px_of(up_deg));
        let distance = distance_px(&built.camera, &built.sky_lines, at);
        assert!((distance < 4.0) == is_line, "{up_deg}: {distance}");
    }
    let names =
        |built: &Scene| built.line_texts.as_ref().map_or(Vec::new(), |t| t.texts.iter().map(|t| t.text.clone()).collect::<Vec<_>>());
    let north = scene(&from_ground((DVec3::Z - zenith * zenith.z).normalize(), 30.0));
    assert!(names(&north).contains(&"N".to_owned()), "{:?}", names(&north));
    let in_space = scene(&towards(DVec3::X, 30.0, only("grid-horizon")));
    assert!(
        in_space.sky_lines.is_empty() && in_space.sky_decisions.iter().any(|d| !d.on && d.reason.to_string().contains("not on the ground")),
        "{:?}",
        in_space.sky_decisions
    );
}

/// Every body that is large enough has its own lines, in the order in which bodies are drawn: the Earth beyond the Moon's limb as well as
/// the Moon.
#[test]
fn each_body_in_sight_has_its_own_lines() {
    let from_earth_side = ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::EARTH), distance_radii: Some(6.0) },
        width: 400,
        height: 400,
        layers: only("grid-body"),
        ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-15T20:00:00Z").expect("a time"))
    };
    let facing = scene(&from_earth_side);
    assert_eq!(facing.ground_lines.iter().map(|(id, _)| *id).collect::<Vec<_>>(), [NaifId::MOON], "the Earth is behind the camera");
    let [earth, centre] = [NaifId::EARTH, NaifId::MOON].map(|id| facing.body(id).expect("in the catalog").placement.centre_km);
    let to_earth = (earth - centre).normalize();
    let offset_km = 1737.4 * (1.6 * to_earth.any_orthonormal_vector() - 6.0 * to_earth);
    let beyond = ViewRequest {
        position: Position::Offset { body: NaifId::MOON, offset_km, axes: Axes::Icrf },
        fov_deg: Some(34.0),
        // The Earth's disc is 110 pixels wide: on one of less than 76 pixels, no line would be visible.
        width: 2000,
        height: 2000,
        ..from_earth_side
    };
    let built = scene(&beyond);
    assert_eq!(built.ground_lines.iter().map(|(id, _)| *id).collect::<Vec<_>>(), [NaifId::MOON, NaifId::EARTH]);
    for (id, segments) in &built.ground_lines {
        let placement = built.body(*id).expect("in the catalog").placement;
        let at: Vec<DVec2> = segments.iter().map(|p| pixel(&built.camera, p.ends[0].lerp(p.ends[1], 0.5))).collect();
        let on_body = at.iter().filter(|at| built.camera.surface_under_pixel(&placement, **at).is_some()).count();
        assert!(on_body > 10 && on_body * 10 > at.len() * 8, "{id:?}: {on_body} of {}", at.len());
    }
    // From far away the Moon is too small for lines, which would fill its disc.
    let far = ViewRequest { fov_deg: Some(170.0), width: 64, height: 64, ..beyond };
    assert_eq!(scene(&far).ground_lines.iter().map(|(id, _)| *id).collect::<Vec<_>>(), []);
}

/// The Moon hides the coordinates of the Earth's grid that lie behind it. They are shown where the Moon is behind the camera.
#[test]
fn a_body_hides_the_coordinates_on_the_body_behind_it() {
    let texts = |distance_radii: f64, fov_deg: f64| {
        let request = ViewRequest {
            position: Position::AboveTarget { towards: Some(NaifId::MOON), distance_radii: Some(distance_radii) },
            fov_deg: Some(fov_deg),
            width: 500,
            height: 500,
            layers: only("grid-body"),
            ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-04-08T12:00:00Z").expect("a time"))
        };
        let layer = scene(&request).line_texts.expect("coordinates");
        layer.texts.into_iter().map(|t| t.text).collect::<Vec<_>>()
    };
    // The Moon is 56 radii from the Earth, in front of the middle of its disc, where the label of the meridian 0 is. The Moon's own meridian 0 is on its
    // side that faces the Earth, which the camera does not see.
    let [beyond_moon, before_moon] = [texts(120.0, 1.2), texts(50.0, 2.9)];
    let has = |texts: &[String], text: &str| texts.iter().any(|t| t == text);
    assert!(has(&beyond_moon, "300°E") && !has(&beyond_moon, "0°E"), "{beyond_moon:?}");
    assert!(has(&before_moon, "300°E") && has(&before_moon, "0°E"), "{before_moon:?}");
}

/// The lines of the ground lie on the body: the terminator where the Sun's centre is on the horizon, the equator where the camera maps its
/// ground.
#[test]
fn ground_lines_lie_at_their_coordinates() {
    for (target, distance_radii) in [(599, 5.0), (399, 3.0), (301, 1.3), (699, 4.0)] {
        let towards = Some(NaifId(if target == 399 { 301 } else { 399 }));
        let base = ViewRequest {
            position: Position::AboveTarget { towards, distance_radii: Some(distance_radii) },
            width: 400,
            height: 400,
            layers: only("terminator"),
            ..ViewRequest::of(NaifId(target), Instant::parse("2024-04-15T20:00:00Z").expect("a time"))
        };
        let body_of = |built: &Scene| built.body(NaifId(target)).expect("in the catalog").placement;
        let built = scene(&base);
        let sun = built.body(NaifId::SUN).expect("in the catalog").placement.centre_km;
        let placement = body_of(&built);
        let to_sun = (placement.body_from_icrf * (sun - placement.centre_km)).normalize();
        let segments = built.ground_lines.first().map_or(&[][..], |(_, segments)| segments);
        let mut on_terminator = 0;
        let points_on = |p: &LineSegment| [0.0, 0.25, 0.5, 0.75].map(|t| pixel(&built.camera, p.ends[0].lerp(p.ends[1], t)));
        for at in segments.iter().flat_map(points_on) {
            let Some(unit) = built.camera.surface_under_pixel(&placement, at) else { continue };
            let normal = (unit / placement.radii_km).normalize();
            on_terminator += 1;
            // Near the limb a tenth of a pixel corresponds to a degree; the Sun's direction changes by less during the light time.
            let facing = normal.dot((placement.body_from_icrf * -placement.centre_km).normalize());
            assert!(normal.dot(to_sun).abs() < 0.02 / facing.max(0.05), "{target}: {}", normal.dot(to_sun));
        }
        // Seen from the Earth, the terminators of Jupiter and Saturn are close to the limb.
        assert!(on_terminator > 10 || target == 599 || target == 699, "{target}: {on_terminator}");
        let built = scene(&ViewRequest { layers: only("grid-body"), ..base.clone() });
        let placement = body_of(&built);
        let segments = built.ground_lines.first().map_or(&[][..], |(_, segments)| segments);
        assert!(segments.len() > 20, "{target}");
        // The half of the equator that faces the camera is drawn.
        let mut on_equator = 0;
        for longitude in 0..360 {
            let unit = unit_vector(f64::from(longitude), 0.0);
            let Some(at) = built.camera.pixel_of_surface(&placement, unit) else { continue };
            if (0.0..400.0).contains(&at.x) && (0.0..400.0).contains(&at.y) {
                on_equator += 1;
                assert!(
                    distance_px(&built.camera, segments, at) < 0.3,
                    "{target}, {longitude}: {}",
                    distance_px(&built.camera, segments, at)
                );
            }
        }
        assert!(on_equator > 10, "{target}: {on_equator}");
    }
}

/// No Sun shines on the Sun: instead of a terminator there is a decision that says so. On a small disc, whose grid would be invisible, no coordinates are
/// written.
#[test]
fn lines_that_are_not_drawn_have_a_reason_and_no_text() {
    let of_body = |target: NaifId, distance_radii: f64, layer: &str| {
        scene(&ViewRequest {
            position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
            width: 400,
            height: 400,
            layers: only(layer),
            ..ViewRequest::of(target, Instant::parse("2024-04-15T20:00:00Z").expect("a time"))
        })
    };
    let sun = of_body(NaifId::SUN, 6.0, "terminator");
    assert!(sun.sky_decisions.iter().any(|d| d.effect == "terminator" && !d.on), "{:?}", sun.sky_decisions);
    // Discs of 250 and of 24 pixels.
    let [large, small] = [4.0, 40.0].map(|distance_radii| of_body(NaifId::EARTH, distance_radii, "grid-body"));
    assert!(large.line_texts.is_some() && small.line_texts.is_none() && small.ground_lines.is_empty(), "{:?}", small.line_texts);
}

/// A body hides the sky's lines completely; with the layer switched off nothing is drawn.
#[test]
fn bodies_hide_the_lines_behind_them() {
    let base = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(6.0) },
        width: 200,
        height: 200,
        layers: Layers::NONE,
        ..ViewRequest::of(NaifId(599), Instant::parse("2024-12-07T20:00:00Z").expect("a time"))
    };
    let drawn =
        |layers: Layers| SESSION.draw(&ViewRequest { layers, ..base.clone() }, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn");
    let (plain, with_grid) = (drawn(Layers::NONE), drawn(only("grid-ecliptic")));
    assert!(plain.scene.sky_lines.is_empty() && plain.scene.line_texts.is_none() && !with_grid.scene.sky_lines.is_empty());
    let placement = plain.scene.body(NaifId(599)).expect("in the catalog").placement;
    let (mut on_disc, mut beside) = (0, 0);
    for (k, (a, b)) in plain.frame.hdr.iter().zip(&with_grid.frame.hdr).enumerate() {
        let at = DVec2::new((k % 200) as f64 + 0.5, (k / 200) as f64 + 0.5);
        let neighbours = [DVec2::ZERO, DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y];
        let inside = neighbours.iter().all(|d| plain.scene.camera.surface_under_pixel(&placement, at + 2.0 * *d).is_some());
        match (a == b, inside) {
            (false, true) => on_disc += 1,
            (false, false) => beside += 1,
            _ => {}
        }
    }
    assert!(on_disc == 0 && beside > 200, "{on_disc} {beside}");
}

/// The names of Orion's bright stars are to the right of the stars, and a click near a star selects it; at low exposure or with the layer
/// off there are no names.
#[test]
fn visible_stars_have_names() {
    let at_stops = |stops: f64, layers: Layers| ViewRequest {
        exposure: orrery::scene::request::ExposureRequest::Stops(stops),
        ..towards(unit_vector(83.0, 0.0), 40.0, layers)
    };
    let named = Layers { stars: true, star_names: true, ..Layers::NONE };
    let built = scene(&at_stops(19.0, named));
    let texts = built.line_texts.as_ref().expect("names");
    for (name, hip) in [("Rigel", 24_436), ("Betelgeuse", 27_989), ("Bellatrix", 25_336)] {
        let text = texts.texts.iter().find(|t| t.text == name).unwrap_or_else(|| panic!("{name} has no label"));
        let star = SESSION.catalog().stars().index_of_hip(hip).expect("in the catalog");
        let at = orrery::scene::labels::star_px(&built, star).expect("drawn");
        let offset = text.left_end_px - at;
        assert!((0.0..2.0 * texts.glyph_px).contains(&offset.x) && offset.y.abs() < texts.glyph_px, "{name}: {offset}");
        // A click near the star selects it; a click far from it does not.
        assert_eq!(orrery::scene::labels::star_at(&built, at + DVec2::splat(2.0)), Some(star), "{name}");
        assert_ne!(orrery::scene::labels::star_at(&built, at + DVec2::splat(40.0)), Some(star), "{name}");
    }
    assert!(scene(&at_stops(0.0, named)).line_texts.is_none(), "no star is visible at a daylight exposure");
    assert!(scene(&at_stops(19.0, Layers { star_names: false, ..named })).line_texts.is_none());
}

/// Spica, eight pixels inside the right limb of the Moon, has no name, though there would be room for it beside the limb, no click selects it, and it has no
/// place for a ring around it; eight pixels outside it has these.
#[test]
fn a_body_hides_the_names_of_the_stars_behind_it() {
    const MOON_RADIUS_KM: f64 = 1737.4;
    let index = SESSION.catalog().stars().index_of_hip(65_474).expect("in the catalog");
    let spica = SESSION.catalog().stars().stars()[index].direction.normalize();
    let right = spica.cross(DVec3::Z).normalize();
    // Whether the star has a name, whether a click outside the limb selects it, and whether it has a place for a ring.
    let shown = |beyond_limb_px: f64| {
        let request = ViewRequest {
            exposure: orrery::scene::request::ExposureRequest::Stops(19.0),
            ..towards(spica, 10.0, Layers { stars: true, star_names: true, ..Layers::NONE })
        };
        let pixel_rad = 2.0 * f64::to_radians(5.0).tan() / f64::from(request.height);
        // The Moon is 20 of its radii away, to the left of the star.
        let (sin, cos) = (f64::asin(1.0 / 20.0) + beyond_limb_px * pixel_rad).sin_cos();
        let offset_km = -20.0 * MOON_RADIUS_KM * (spica * cos - right * sin);
        let built = scene(&ViewRequest { position: Position::Offset { body: NaifId::MOON, offset_km, axes: Axes::Icrf }, ..request });
        let selected = orrery::scene::labels::star_at(&built, DVec2::new(260.0, 200.0)) == Some(index);
        let has_place = orrery::scene::labels::star_px(&built, index).is_some();
        // The Moon is drawn over the star.
        assert!(built.stars.iter().any(|sprite| sprite.star == Some(index)), "the star is not in the frame");
        (built.line_texts.is_some_and(|layer| layer.texts.iter().any(|t| t.text == "Spica")), selected, has_place)
    };
    assert_eq!((shown(-8.0), shown(8.0)), ((false, false, false), (true, true, true)));
}
