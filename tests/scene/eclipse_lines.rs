//! Shadows of eclipses as lines: their outlines lie where the shader's light changes, the path runs through places of printed tables, and cones reach from body to body.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::annotation::strokes::LineSegment;
use orrery::scene::draw::PixelView;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Look, Position, ViewRequest};
use orrery::time::Instant;

const GREATEST: &str = "2024-04-08T18:17:16Z";

fn view(target: i32, time: &str, layers: Layers) -> ViewRequest {
    ViewRequest {
        position: Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(20.0) },
        // A disc of 800 pixels: the Moon's umbra is a dozen wide.
        fov_deg: Some(6.5),
        width: 900,
        height: 900,
        layers,
        ..ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time"))
    }
}

fn path() -> Layers {
    Layers { eclipse_path: true, ..Layers::NONE }
}

fn pieces(made: &Scene) -> &[LineSegment] {
    made.ground_lines.first().map_or(&[][..], |(_, pieces)| pieces)
}

fn ends_px(made: &Scene, piece: &LineSegment) -> [DVec2; 2] {
    piece.ends.map(|e| made.camera.pixel_from_clip(e.truncate().as_dvec2()))
}

/// Pieces of umbra, penumbra or path, by their colour.
fn of_colour(made: &Scene, is: fn(DVec3) -> bool) -> Vec<LineSegment> {
    pieces(made).iter().filter(|p| is(p.colour.as_dvec3())).copied().collect()
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

/// On both sides of each outline the shader's light is what it must be: none within the umbra and some outside, all outside of the penumbra and less within. For the Moon's shadow
/// on the Earth and the shadow of a moon on Jupiter.
#[test]
fn outlines_lie_where_the_shaders_light_changes() {
    for (target, time) in [(399, GREATEST), (399, "2024-04-08T16:50:00Z"), (599, "2004-03-28T07:40:00Z")] {
        let shaded = ViewRequest {
            pixel_view: PixelView::Eclipse,
            effects: EffectOverrides::parse("+eclipse=limb-darkened,-clouds,-atmosphere").expect("effects"),
            ..view(target, time, Layers::NONE)
        };
        let drawn = SESSION.draw(&shaded, SamplingQuality { samples: 1, anisotropy: 1 }, true).expect("drawn");
        let light = |at: DVec2| f64::from(drawn.frame.hdr[at.y as usize * 900 + at.x as usize][1]);
        let made = SESSION.scene(&view(target, time, path())).expect("a scene");
        let placement = made.body(NaifId(target)).expect("in the catalog").placement;
        for (edge, what) in [(is_umbra as fn(DVec3) -> bool, "umbra"), (is_penumbra, "penumbra")] {
            let outline = of_colour(&made, edge);
            assert!(outline.len() > 10, "{target} {time}: {} pieces of the {what}", outline.len());
            let (mut seen, mut wrong) = (0, 0);
            for piece in &outline {
                let [a, b] = ends_px(&made, piece);
                let (middle, across) = (0.5 * (a + b), (b - a).perp().normalize_or_zero());
                // Steep ground near the limb turns a pixel into a long way.
                let steep = |at: DVec2| {
                    made.camera
                        .surface_under_pixel(&placement, at)
                        .is_none_or(|unit| unit.dot(placement.camera_in_unit_sphere().normalize()) < 0.3)
                };
                let sides = [middle + 2.0 * across, middle - 2.0 * across];
                if across == DVec2::ZERO || sides.iter().any(|at| steep(*at)) {
                    continue;
                }
                let [low, high] = {
                    let [one, other] = sides.map(light);
                    [one.min(other), one.max(other)]
                };
                seen += 1;
                wrong += usize::from(if what == "umbra" { low > 1e-6 || high < 1e-5 } else { high < 1.0 - 1e-4 || low > 1.0 - 1e-6 });
            }
            println!("{target} {time}: {what}: {seen} pieces, {wrong} wrong");
            // The umbra is a few pixels wide where it is small: some points two pixels aside lie beyond its other edge.
            assert!(seen > 5 && wrong * 20 <= seen, "{target} {time}, {what}: {wrong} of {seen}");
        }
        // The comparison must be able to fail, where there is one umbra: a pixel in its middle is not on its edge.
        let outline = of_colour(&made, is_umbra);
        let middle = outline.iter().map(|p| ends_px(&made, p)[0]).sum::<DVec2>() / outline.len() as f64;
        assert!(
            target == 599 || light(middle) < 2e-3 && light(middle + DVec2::new(300.0, 0.0)) > 2e-3,
            "{target} {time}: {}",
            light(middle)
        );
    }
}

/// NASA's path table of 2024-04-08 (Espenak, F. and Anderson, J., Total Solar Eclipse of 2024 April 08): places of the centre line by hour; each is within 4 km of the
/// drawn line (the table's lunar radius differs by 0.1 km, its Delta T by a second).
#[test]
fn the_path_of_2024_runs_through_the_places_of_the_table() {
    let made = SESSION.scene(&ViewRequest { width: 4000, height: 4000, ..view(399, GREATEST, path()) }).expect("a scene");
    let placement = made.body(NaifId::EARTH).expect("in the catalog").placement;
    let line = of_colour(&made, is_path);
    let off_km = |latitude_deg: f64, longitude_deg: f64| {
        let (ground, _) = ground_point_km(placement.radii_km, latitude_deg, longitude_deg, 0.0);
        let at = made.camera.pixel_of_surface(&placement, ground / placement.radii_km).expect("on the near side");
        let to = |p: &LineSegment| {
            let [a, b] = ends_px(&made, p);
            let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            at.distance(a.lerp(b, t))
        };
        let pixel_km = made.camera.pixel_tangent() * (placement.centre_km.length() - placement.radii_km.x);
        line.iter().map(to).fold(f64::INFINITY, f64::min) * pixel_km
    };
    // Greatest eclipse 18:17:16: 25 deg 17.4' N, 104 deg 08.3' W.
    assert!(off_km(25.29, -104.138) < 4.0, "{}", off_km(25.29, -104.138));
    // Half the path's 198 km beside it are the limits, and between them nothing.
    assert!(off_km(25.29 + 0.45, -104.138) > 20.0);
    assert!(made.sky.iter().any(|d| d.feature == "eclipse-path" && d.on && d.reason.contains("Moon")), "{:?}", made.sky);
    // A day before there is none, and the reason says so.
    let before = SESSION.scene(&view(399, "2024-04-07T12:00:00Z", path())).expect("a scene");
    assert!(pieces(&before).is_empty() && before.sky.iter().any(|d| d.feature == "eclipse-path" && !d.on), "{:?}", before.sky);
}

/// A cone's lines begin at the Moon and end at the Earth; the Moon alone has its own cone, which holds the Earth at an eclipse.
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
        ..ViewRequest::of(target, Instant::parse(GREATEST).expect("a time"))
    };
    for target in [NaifId::EARTH, NaifId::MOON] {
        let made = SESSION.scene(&request(target)).expect("a scene");
        assert!(!made.lines.is_empty() && made.lines.len() < 20_000, "{}", made.lines.len());
        let px = |id: NaifId| {
            made.camera.pixel_from_clip(made.camera.clip(made.body(id).expect("placed").placement.centre_km).expect("in front"))
        };
        let pixel_km = made.camera.pixel_tangent() * 9.5e5;
        for (body, radius_km) in [(NaifId::MOON, 1737.0), (NaifId::EARTH, 6378.0)] {
            let ends =
                made.lines.iter().flat_map(|p| ends_px(&made, p)).map(|at| at.distance(px(body)) * pixel_km).fold(f64::INFINITY, f64::min);
            assert!(ends < 1.2 * radius_km, "{target:?}: nearest line {ends} km from {body:?}");
        }
        assert!(made.lines.iter().all(|p| p.ends.iter().all(|e| e.is_finite() && e.z > 0.0)), "{target:?}");
        assert!(made.sky.iter().any(|d| d.feature == "eclipse-cones" && d.on), "{:?}", made.sky);
    }
    let off = SESSION.scene(&ViewRequest { layers: Layers::NONE, ..request(NaifId::EARTH) }).expect("a scene");
    assert!(off.lines.is_empty());
}
