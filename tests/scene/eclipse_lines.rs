//! Shadows of eclipses as lines: outlines lie where the shader's light changes, the path of 2024 runs through the published point of
//! greatest eclipse, and cones reach from body to body.

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

const GREATEST_ECLIPSE: &str = "2024-04-08T18:17:16Z";

fn view(target: i32, time: &str, layers: Layers) -> ViewRequest {
    ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(20.0) },
        // A disc of 800 pixels, on which the Moon's umbra is a dozen pixels wide.
        fov_deg: Some(6.5),
        width: 900,
        height: 900,
        layers,
        ..ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time"))
    }
}

fn path_layer() -> Layers {
    Layers { eclipse_path: true, ..Layers::NONE }
}

fn segments(built: &Scene) -> &[LineSegment] {
    built.ground_lines.first().map_or(&[][..], |(_, segments)| segments)
}

fn ends_px(built: &Scene, segment: &LineSegment) -> [DVec2; 2] {
    segment.ends.map(|e| built.camera.pixel_from_clip(e.truncate().as_dvec2()))
}

/// The line segments of the umbra, penumbra or path, selected by colour.
fn lines_of_colour(built: &Scene, has_colour: fn(DVec3) -> bool) -> Vec<LineSegment> {
    segments(built).iter().filter(|p| has_colour(p.colour.as_dvec3())).copied().collect()
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
/// inside. Tested for the Moon's shadow on the Earth and for the shadow of a moon on Jupiter.
#[test]
fn outlines_lie_where_the_shaders_light_changes() {
    for (target, time) in [(399, GREATEST_ECLIPSE), (399, "2024-04-08T16:50:00Z"), (599, "2004-03-28T07:40:00Z")] {
        let shaded = ViewRequest {
            pixel_view: PixelView::Eclipse,
            effects: EffectOverrides::parse("+eclipse=limb-darkened,-clouds,-atmosphere").expect("effects"),
            ..view(target, time, Layers::NONE)
        };
        let drawn = SESSION.draw(&shaded, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
        let light = |at: DVec2| f64::from(drawn.frame.hdr[at.y as usize * 900 + at.x as usize][1]);
        let built = SESSION.scene(&view(target, time, path_layer())).expect("a scene");
        let placement = built.body(NaifId(target)).expect("in the catalog").placement;
        for (is_outline, outline_name) in [(is_umbra as fn(DVec3) -> bool, "umbra"), (is_penumbra, "penumbra")] {
            let outline = lines_of_colour(&built, is_outline);
            assert!(outline.len() > 10, "{target} {time}: {} segments of the {outline_name}", outline.len());
            let (mut checked, mut contradicting) = (0, 0);
            for segment in &outline {
                let [a, b] = ends_px(&built, segment);
                let (middle, across) = (0.5 * (a + b), (b - a).perp().normalize_or_zero());
                // Near the limb the ground is seen at a grazing angle, and a pixel covers a long distance.
                let is_grazing = |at: DVec2| {
                    built
                        .camera
                        .surface_under_pixel(&placement, at)
                        .is_none_or(|unit| unit.dot(placement.camera_in_unit_sphere().normalize()) < 0.3)
                };
                let sides = [middle + 2.0 * across, middle - 2.0 * across];
                if across == DVec2::ZERO || sides.iter().any(|at| is_grazing(*at)) {
                    continue;
                }
                let [low, high] = {
                    let [one, other] = sides.map(light);
                    [one.min(other), one.max(other)]
                };
                checked += 1;
                contradicting +=
                    usize::from(if outline_name == "umbra" { low > 1e-6 || high < 1e-5 } else { high < 1.0 - 1e-4 || low > 1.0 - 1e-6 });
            }
            println!("{target} {time}: {outline_name}: {checked} segments, {contradicting} contradicting");
            // A small umbra is only a few pixels wide: some points two pixels to the side lie beyond its other edge.
            assert!(checked > 5 && contradicting * 20 <= checked, "{target} {time}, {outline_name}: {contradicting} of {checked}");
        }
        // The comparison must be able to fail: on the Earth, where there is a single umbra, its middle is dark, and 300 pixels away it is
        // light.
        let outline = lines_of_colour(&built, is_umbra);
        let middle = outline.iter().map(|p| ends_px(&built, p)[0]).sum::<DVec2>() / outline.len() as f64;
        assert!(
            target == 599 || light(middle) < 2e-3 && light(middle + DVec2::new(300.0, 0.0)) > 2e-3,
            "{target} {time}: {}",
            light(middle)
        );
    }
}

/// NASA's path table of 2024-04-08 (Espenak, F. and Anderson, J., Total Solar Eclipse of 2024 April 08): the point of greatest eclipse is
/// within 4 km of the drawn line (the table's lunar radius differs by 0.1 km, its Delta T by a second).
#[test]
fn the_path_of_2024_runs_through_the_tables_greatest_eclipse() {
    let built = SESSION.scene(&ViewRequest { width: 4000, height: 4000, ..view(399, GREATEST_ECLIPSE, path_layer()) }).expect("a scene");
    let placement = built.body(NaifId::EARTH).expect("in the catalog").placement;
    let line = lines_of_colour(&built, is_path);
    let distance_km = |latitude_deg: f64, longitude_deg: f64| {
        let (ground, _) = ground_point_km(placement.radii_km, latitude_deg, longitude_deg, 0.0);
        let at = built.camera.pixel_of_surface(&placement, ground / placement.radii_km).expect("on the near side");
        let distance_to = |p: &LineSegment| {
            let [a, b] = ends_px(&built, p);
            let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            at.distance(a.lerp(b, t))
        };
        let pixel_km = built.camera.pixel_tangent() * (placement.centre_km.length() - placement.radii_km.x);
        line.iter().map(distance_to).fold(f64::INFINITY, smaller) * pixel_km
    };
    // Greatest eclipse 18:17:16: 25 deg 17.4' N, 104 deg 08.3' W.
    assert!(distance_km(25.29, -104.138) < 4.0, "{}", distance_km(25.29, -104.138));
    // The limits lie half the path's width of 198 km to either side of the centre line; between them there is no line.
    assert!(distance_km(25.29 + 0.45, -104.138) > 20.0);
    assert!(
        built.sky_decisions.iter().any(|d| d.effect == "eclipse-path" && d.on && d.reason.to_string().contains("Moon")),
        "{:?}",
        built.sky_decisions
    );
    // One day earlier there is no path, and the reason says so.
    let before = SESSION.scene(&view(399, "2024-04-07T12:00:00Z", path_layer())).expect("a scene");
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
        let built = SESSION.scene(&request(target)).expect("a scene");
        assert!(!built.lines_in_space.is_empty() && built.lines_in_space.len() < 20_000, "{}", built.lines_in_space.len());
        let centre_px = |id: NaifId| {
            built.camera.pixel_from_clip(built.camera.clip(built.body(id).expect("placed").placement.centre_km).expect("in front"))
        };
        // The camera is about 950 000 km from the Earth.
        let pixel_km = built.camera.pixel_tangent() * 9.5e5;
        for (body, radius_km) in [(NaifId::MOON, 1737.0), (NaifId::EARTH, 6378.0)] {
            let nearest_km = built
                .lines_in_space
                .iter()
                .flat_map(|p| ends_px(&built, p))
                .map(|at| at.distance(centre_px(body)) * pixel_km)
                .fold(f64::INFINITY, smaller);
            assert!(nearest_km < 1.2 * radius_km, "{target:?}: nearest line {nearest_km} km from {body:?}");
        }
        assert!(built.lines_in_space.iter().all(|p| p.ends.iter().all(|e| e.is_finite() && e.z > 0.0)), "{target:?}");
        assert!(built.sky_decisions.iter().any(|d| d.effect == "eclipse-cones" && d.on), "{:?}", built.sky_decisions);
    }
    let without_layer = SESSION.scene(&ViewRequest { layers: Layers::NONE, ..request(NaifId::EARTH) }).expect("a scene");
    assert!(without_layer.lines_in_space.is_empty());
}
