//! The lines that show eclipses: the outlines of umbra and penumbra lie where the shader's light changes, the path of the eclipse of 2024 runs
//! through the published point of greatest eclipse, and shadow cones reach from body to body.

use crate::support::folds::smaller;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::annotation::strokes::LineSegment;
use orrery::scene::draw::PixelView;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Look, Position, ViewRequest};
use orrery::time::Instant;

const JUPITER: NaifId = NaifId(599);
const SIDE: u32 = 900;
/// The instant of greatest eclipse in the total solar eclipse of 2024.
const GREATEST_ECLIPSE: &str = "2024-04-08T18:17:16Z";

fn view(target: NaifId, time: &str, layers: Layers) -> ViewRequest {
    ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(20.0) },
        // A disc of 800 pixels, on which the Moon's umbra is a dozen pixels wide.
        fov_deg: Some(6.5),
        width: SIDE,
        height: SIDE,
        layers,
        ..ViewRequest::of(target, Instant::parse(time).expect("a time"))
    }
}

fn path_layer() -> Layers {
    Layers { eclipse_path: true, ..Layers::NONE }
}

/// The lines on the ground.
fn segments(scene: &Scene) -> &[LineSegment] {
    scene.ground_lines.first().map_or(&[][..], |(_, segments)| segments)
}

fn ends_px(scene: &Scene, segment: &LineSegment) -> [DVec2; 2] {
    segment.ends.map(|end| scene.camera.pixel_from_clip(end.truncate().as_dvec2()))
}

/// The line segments that have a colour: those of the umbra, the penumbra or the path.
fn lines_of_colour(scene: &Scene, has_colour: fn(DVec3) -> bool) -> Vec<LineSegment> {
    segments(scene).iter().filter(|segment| has_colour(segment.colour.as_dvec3())).copied().collect()
}

fn is_umbra(colour: DVec3) -> bool {
    colour.x > 0.9 && colour.y < 0.5
}

fn is_penumbra(colour: DVec3) -> bool {
    colour.x > 0.9 && colour.y > 0.5
}

fn is_path(colour: DVec3) -> bool {
    colour.x < 0.5
}

/// The shader's light on both sides of each outline: none inside the umbra and some outside; full light outside the penumbra and less
/// inside. For the Moon's shadow on the Earth, and for shadows of moons on Jupiter.
#[test]
fn outlines_lie_where_the_shaders_light_changes() {
    for (target, time) in [(NaifId::EARTH, GREATEST_ECLIPSE), (NaifId::EARTH, "2024-04-08T16:50:00Z"), (JUPITER, "2004-03-28T07:40:00Z")] {
        let shaded = ViewRequest {
            pixel_view: PixelView::Eclipse,
            effects: EffectOverrides::parse("+eclipse=limb-darkened,-clouds,-atmosphere").expect("effects"),
            ..view(target, time, Layers::NONE)
        };
        let drawn = SESSION.draw(&shaded, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
        let light = |at: DVec2| f64::from(drawn.frame.hdr[at.y as usize * SIDE as usize + at.x as usize][1]);
        let scene = SESSION.scene(&view(target, time, path_layer())).expect("a scene");
        let placement = scene.body(target).expect("in the catalog").placement;
        // Near the limb the ground is seen at a grazing angle, and a pixel covers a long distance.
        let is_grazing = |at: DVec2| {
            let unit = scene.camera.surface_under_pixel(&placement, at);
            unit.is_none_or(|unit| unit.dot(placement.camera_in_unit_sphere().normalize()) < 0.3)
        };
        for (is_outline, outline_name) in [(is_umbra as fn(DVec3) -> bool, "umbra"), (is_penumbra, "penumbra")] {
            let outline = lines_of_colour(&scene, is_outline);
            assert!(outline.len() > 10, "{target:?} {time}: {} segments of the {outline_name}", outline.len());
            // The number of segments that can be checked, and of those where the light is wrong, of the outline moved by a number of pixels.
            let checked_and_wrong = |shift_px: DVec2| {
                let (mut checked, mut wrong) = (0, 0);
                for segment in &outline {
                    let [a, b] = ends_px(&scene, segment);
                    let (middle, across) = (0.5 * (a + b) + shift_px, (b - a).perp().normalize_or_zero());
                    let sides = [middle + 2.0 * across, middle - 2.0 * across];
                    if across == DVec2::ZERO || sides.iter().any(|at| is_grazing(*at)) {
                        continue;
                    }
                    let [low, high] = {
                        let [left, right] = sides.map(light);
                        [left.min(right), left.max(right)]
                    };
                    let is_wrong = if outline_name == "umbra" { low > 1e-6 || high < 1e-5 } else { high < 1.0 - 1e-4 || low > 1.0 - 1e-6 };
                    checked += 1;
                    wrong += usize::from(is_wrong);
                }
                (checked, wrong)
            };
            let (checked, wrong) = checked_and_wrong(DVec2::ZERO);
            println!("{target:?} {time}: {outline_name}: {checked} segments, {wrong} wrong");
            // A small umbra is only a few pixels wide, so some points two pixels inside its outline lie beyond the opposite edge.
            assert!(checked > 5 && wrong * 20 <= checked, "{target:?} {time}, {outline_name}: {wrong} of {checked}");
            // Negative control: an outline that is moved by 39 pixels is wrong, except where the shift is nearly parallel to it.
            let (checked, wrong) = checked_and_wrong(DVec2::new(37.0, 11.0));
            assert!(checked > 5 && wrong * 4 >= 3 * checked, "{target:?} {time}, {outline_name}, moved: {wrong} of {checked}");
        }
    }
}

/// The point of greatest eclipse in NASA's table of the path of 2024-04-08 (Espenak, F. and Anderson, J., Total Solar Eclipse of 2024 April
/// 08) is within 4 km of the drawn centre line. The table assumes another lunar radius, by 0.1 km, and another Delta T, by a second.
#[test]
fn the_path_of_2024_runs_through_the_tables_greatest_eclipse() {
    let scene =
        SESSION.scene(&ViewRequest { width: 4000, height: 4000, ..view(NaifId::EARTH, GREATEST_ECLIPSE, path_layer()) }).expect("a scene");
    let placement = scene.body(NaifId::EARTH).expect("in the catalog").placement;
    let line = lines_of_colour(&scene, is_path);
    let distance_km = |latitude_deg: f64, longitude_deg: f64| {
        let (ground, _) = ground_point_km(placement.radii_km, latitude_deg, longitude_deg, 0.0);
        let at = scene.camera.pixel_of_surface(&placement, ground / placement.radii_km).expect("on the near side");
        let distance_px = |segment: &LineSegment| {
            let [a, b] = ends_px(&scene, segment);
            let fraction = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            at.distance(a.lerp(b, fraction))
        };
        let pixel_km = scene.camera.pixel_tangent() * (placement.centre_km.length() - placement.radii_km.x);
        line.iter().map(distance_px).fold(f64::INFINITY, smaller) * pixel_km
    };
    // At 18:17:16: 25 deg 17.4' N, 104 deg 08.3' W.
    assert!(distance_km(25.29, -104.138) < 4.0, "{}", distance_km(25.29, -104.138));
    // The path is 198 km wide. Its limits and its centre line are drawn, and no line between them.
    assert!(distance_km(25.29 + 0.45, -104.138) > 20.0);
    assert!(
        scene.sky_decisions.iter().any(|d| d.effect == "eclipse-path" && d.on && d.reason.to_string().contains("Moon")),
        "{:?}",
        scene.sky_decisions
    );
    // One day earlier there is no path, and the reason says so.
    let before = SESSION.scene(&view(NaifId::EARTH, "2024-04-07T12:00:00Z", path_layer())).expect("a scene");
    assert!(
        segments(&before).is_empty() && before.sky_decisions.iter().any(|d| d.effect == "eclipse-path" && !d.on),
        "{:?}",
        before.sky_decisions
    );
}

/// The lines of the Moon's shadow cone reach from the Moon to the Earth, whether the target is the Earth, on which the shadow falls, or the
/// Moon, which casts it.
#[test]
fn cones_reach_from_the_moon_to_the_earth() {
    let request = |target: NaifId| ViewRequest {
        target: Some(target),
        position: Position::Offset { body: NaifId::EARTH, offset_km: DVec3::new(2e5, -9e5, 2e5), axes: orrery::scene::request::Axes::Icrf },
        look: Look::Target,
        fov_deg: Some(60.0),
        width: 1000,
        height: 1000,
        layers: Layers { eclipse_cones: true, ..Layers::NONE },
        ..ViewRequest::of(target, Instant::parse(GREATEST_ECLIPSE).expect("a time"))
    };
    for target in [NaifId::EARTH, NaifId::MOON] {
        let scene = SESSION.scene(&request(target)).expect("a scene");
        assert!(!scene.lines_in_space.is_empty() && scene.lines_in_space.len() < 20_000, "{}", scene.lines_in_space.len());
        let centre_px = |id: NaifId| {
            scene.camera.pixel_from_clip(scene.camera.clip(scene.body(id).expect("placed").placement.centre_km).expect("in front"))
        };
        // The camera is about 950 000 km from the Earth.
        let pixel_km = scene.camera.pixel_tangent() * 9.5e5;
        for (body, radius_km) in [(NaifId::MOON, 1737.0), (NaifId::EARTH, 6378.0)] {
            let nearest_km = scene
                .lines_in_space
                .iter()
                .flat_map(|segment| ends_px(&scene, segment))
                .map(|at| at.distance(centre_px(body)) * pixel_km)
                .fold(f64::INFINITY, smaller);
            assert!(nearest_km < 1.2 * radius_km, "{target:?}: the nearest line is {nearest_km} km from {body:?}");
        }
        assert!(scene.lines_in_space.iter().all(|segment| segment.ends.iter().all(|end| end.is_finite() && end.z > 0.0)), "{target:?}");
        assert!(scene.sky_decisions.iter().any(|d| d.effect == "eclipse-cones" && d.on), "{:?}", scene.sky_decisions);
    }
    let without_layer = SESSION.scene(&ViewRequest { layers: Layers::NONE, ..request(NaifId::EARTH) }).expect("a scene");
    assert!(without_layer.lines_in_space.is_empty());
}
