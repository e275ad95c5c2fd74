//! Domes, whole spheres and stereo pairs in the window: they are chosen in the panel and kept in links, and a click selects what is drawn there.

use crate::support::folds::smaller;
use crate::view::input::{SATURN, TIME, Window, click, pausable_window};
use crate::view::interface::{interface, session, settle};
use egui_kittest::kittest::Queryable;
use glam::DVec2;
use orrery::catalog::NaifId;
use orrery::scene::labels::CLICK_RADIUS_PX;
use orrery::scene::request::{Projection, StereoLayout, Telescope, WarpMesh};
use orrery::time::Instant;
use orrery::view::app::composition_state::CompositionState;
use orrery::view::link::view_from_text;
use orrery::view::panels::{Interface, Tab};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn compositions() -> Vec<CompositionState> {
    let stereo = |layout| CompositionState { stereo: Some(layout), ..CompositionState::default() };
    let tilted = |projection| CompositionState { projection, dome_tilt_deg: 20.0, ..CompositionState::default() };
    vec![
        CompositionState::default(),
        tilted(Projection::Fisheye),
        CompositionState { fisheye_deg: 60.0, ..tilted(Projection::Fisheye) },
        tilted(Projection::Equirectangular),
        stereo(StereoLayout::Anaglyph),
        stereo(StereoLayout::SideBySide),
        stereo(StereoLayout::Interlaced),
    ]
}

fn saturn_with(composition: &CompositionState) -> Interface {
    let mut interface = interface(SATURN, TIME);
    interface.viewer.view.composition = composition.clone();
    interface.viewer.view.fov_deg = 60.0;
    interface.settings.labels_bodies = true;
    interface
}

/// A window of this height, after the image of its view has been drawn.
fn settled_window(interface: Interface, height_points: f32) -> Window {
    let is_drawing = Arc::new(AtomicBool::new(true));
    let mut window = pausable_window(interface, &is_drawing, height_points);
    settle(&mut window);
    window
}

/// Saturn and five moons. A wide fisheye shows them all close together.
const AIMED_AT: [NaifId; 6] = [SATURN, NaifId(601), NaifId(602), NaifId(604), NaifId(608), NaifId(611)];

/// In every composition, a click on the middle of Saturn selects Saturn, and one on a moon away from all other bodies selects this moon. A side-by-side pair
/// is clicked in both images. A click on empty sky selects nothing.
#[test]
fn a_click_selects_what_the_image_shows_there() {
    let mut clicked_moons = 0;
    // The plain image and the dome also mirrored.
    let mirrored = compositions().into_iter().take(2).map(|composition| (composition, true));
    for (composition, is_mirrored) in compositions().into_iter().map(|composition| (composition, false)).chain(mirrored) {
        let mut interface = saturn_with(&composition);
        interface.viewer.view.is_mirrored = is_mirrored;
        let mut window = settled_window(interface, 640.0);
        let sky = window.get_by_label_contains("The sky: ").rect();
        let rendered = window.state().shown().expect("an image");
        let (width, scene) = (f64::from(rendered.width), &rendered.scene);
        let points_per_px = f64::from(sky.width()) / width;
        let height = f64::from(sky.height()) / points_per_px;
        let shown: Vec<(NaifId, DVec2)> = scene
            .bodies
            .iter()
            .filter(|b| b.has_direction())
            .filter_map(|b| Some((b.id, scene.geometry.pixel_of(&scene.camera, b.placement.centre_km)?)))
            .collect();
        // Places on the rings, out to the F ring.
        let saturn = scene.body(SATURN).expect("of the catalog").placement;
        let on_rings = (7..15).flat_map(|r| (0..60).map(move |k| (f64::from(r) * 1e4, f64::from(k) * TAU / 60.0)));
        let ring_directions =
            on_rings.map(|(r, angle)| saturn.centre_km + saturn.body_from_icrf.transpose() * (DVec2::from_angle(angle) * r).extend(0.0));
        let rings_px: Vec<DVec2> = ring_directions.filter_map(|d| scene.geometry.pixel_of(&scene.camera, d)).collect();
        let px_of = |id: NaifId| shown.iter().find(|s| s.0 == id).map(|s| s.1);
        let saturn_px = px_of(SATURN).expect("the target is in the image");
        // The target is in the middle of its image; a dome's tilt moves it up or down only.
        let image_count = if composition.stereo == Some(StereoLayout::SideBySide) { 2.0 } else { 1.0 };
        assert!((saturn_px.x - 0.5 * width / image_count).abs() < 1.0, "{composition:?}: {saturn_px} of {width}");
        let image_offsets = if image_count == 2.0 { vec![0.0, 0.5 * width] } else { vec![0.0] };
        let inside = |px: DVec2| px.cmpgt(DVec2::splat(2.0)).all() && px.x < width / image_count - 2.0 && px.y < height - 2.0;
        // Distance to the nearest body other than `except`.
        let clearance_px = |px: DVec2, except: Option<NaifId>| {
            shown.iter().filter(|s| Some(s.0) != except).map(|s| s.1.distance(px)).fold(f64::INFINITY, smaller)
        };
        let selected_at = |window: &mut Window, px: DVec2| {
            window.state_mut().viewer.selected = NaifId::SUN;
            click(window, sky.min + egui::vec2((px.x * points_per_px) as f32, (px.y * points_per_px) as f32));
            let selected = window.state().viewer.selected;
            // Wait, so that the next click is not part of a double-click.
            crate::view::input::advance(window, 1.0);
            selected
        };
        let mut clicked = Vec::new();
        for id in AIMED_AT {
            let is_clear = |px: &DVec2| inside(*px) && clearance_px(*px, Some(id)) > 1.5 * CLICK_RADIUS_PX;
            let Some(px) = px_of(id).filter(is_clear) else { continue };
            for offset in &image_offsets {
                let at = px + DVec2::new(*offset, 0.0);
                assert_eq!(selected_at(&mut window, at), id, "{composition:?}: at {at}");
            }
            clicked.push(id);
        }
        assert_eq!(clicked.first(), Some(&SATURN), "{composition:?}: {clicked:?} could be clicked on");
        clicked_moons += clicked.len() - 1;
        // In the inner part of the image, which a fisheye's circle includes. Saturn's disc has a radius of less than a quarter of the height.
        let places = (5..16).flat_map(|i| (5..16).map(move |j| DVec2::new(f64::from(i), f64::from(j)) / 20.0));
        let mut places = places.map(|p| p * DVec2::new(width / image_count, height));
        let is_empty = |px: &DVec2| {
            let is_beside_rings = rings_px.iter().all(|ring_px| ring_px.distance(*px) > 2.0 * CLICK_RADIUS_PX);
            clearance_px(*px, None) > 2.0 * CLICK_RADIUS_PX && px.distance(saturn_px) > 0.3 * height && is_beside_rings
        };
        let empty = places.find(is_empty).expect("a place without bodies");
        assert_eq!(selected_at(&mut window, empty), NaifId::SUN, "{composition:?}: at {empty}, where nothing is");
    }
    assert!(clicked_moons >= 6, "only {clicked_moons} moons could be clicked on");
}

/// A warp mesh mirrors and shifts the image: a click selects Saturn where the mesh puts it, and not above the middle of the image.
#[test]
fn a_click_follows_the_warp_mesh() {
    let aspect = 1.6;
    let mut mesh = "2\n9 7\n".to_owned();
    for (row, column) in (0..7).flat_map(|r| (0..9).map(move |c| (r, c))) {
        let (u, v) = (f64::from(column) / 8.0, f64::from(row) / 6.0);
        let (x, y) = (0.7 * aspect * (1.0 - 2.0 * u) + 0.45, 0.8 * (2.0 * v - 1.0) - 0.15 * u);
        mesh.push_str(&format!("{x} {y} {u} {v} 1\n"));
    }
    let mut interface = saturn_with(&CompositionState::default());
    interface.warp = Some(Arc::new(WarpMesh::parse("projector.data", &mesh).expect("a mesh")));
    let mut window = settled_window(interface, 640.0);
    let sky = window.get_by_label_contains("The sky: ").rect();
    let rendered = window.state().shown().expect("an image");
    let points_per_px = f64::from(sky.width()) / f64::from(rendered.width);
    let scene = &rendered.scene;
    let centre_km = scene.body(SATURN).expect("of the catalog").placement.centre_km;
    let saturn_px = scene.geometry.pixel_of(&scene.camera, centre_km).expect("on the mesh");
    let middle = 0.5 * DVec2::new(f64::from(rendered.width), f64::from(rendered.height));
    // At the middle, u = v = 0.5; there x = 0.45 and y = -0.075, in halves of the height.
    assert!(saturn_px.distance(middle + DVec2::new(0.45, 0.075) * middle.y) < 1.5, "Saturn at {saturn_px}, middle {middle}");
    for (px, is_saturn) in [(saturn_px, true), (middle - DVec2::new(0.0, 0.6 * middle.y), false)] {
        window.state_mut().viewer.selected = NaifId::SUN;
        click(&mut window, sky.min + egui::vec2((px.x * points_per_px) as f32, (px.y * points_per_px) as f32));
        assert_eq!(window.state().viewer.selected == SATURN, is_saturn, "at {px}");
        crate::view::input::advance(&mut window, 1.0);
    }
}

/// A dome's draws belong to its faces. The Shader panel says so, and does not call a large body a point.
#[test]
fn the_shader_panel_says_why_a_dome_has_no_list_of_draws() {
    for composition in compositions() {
        let mut interface = saturn_with(&composition);
        interface.tab = Some(Tab::Shader);
        let window = settled_window(interface, 640.0);
        let is_perspective = composition.projection == Projection::Perspective;
        let says = |text: &str| window.query_by_label_contains(text).is_some();
        assert_eq!(says("in the perspective projection only"), !is_perspective, "{composition:?}");
        assert!(!says("is drawn as a point"), "{composition:?}");
    }
}

/// The image has the composition that was chosen in the panel. A projection switches stereo off, and stereo the projection.
#[test]
fn the_panel_chooses_a_projection_and_a_stereo_pair() {
    let mut interface = saturn_with(&CompositionState::default());
    interface.tab = Some(Tab::Effects);
    let mut window = settled_window(interface, 1900.0);
    window.get_by_label("Projection and stereo").click();
    settle(&mut window);
    let choose = |window: &mut Window, list: &str, entry: &str| {
        window.get_by_role_and_label(egui::accesskit::Role::ComboBox, list).click();
        window.run_steps(4);
        window.get_by_label(entry).click();
        settle(window);
    };
    choose(&mut window, "Stereo", "anaglyph");
    let composition = |window: &Window| window.state().shown().expect("an image").job.request.composition.clone();
    assert_eq!(composition(&window).stereo.map(|s| s.layout), Some(StereoLayout::Anaglyph));
    choose(&mut window, "Projection", "fisheye (dome)");
    assert_eq!((composition(&window).projection, composition(&window).stereo), (Projection::Fisheye, None));
    let request = &window.state().shown().expect("an image").job.request;
    assert_eq!(request.fov_deg, Some(180.0));
    choose(&mut window, "Stereo", "side by side");
    assert_eq!(composition(&window).projection, Projection::Perspective);
    window.get_by_label("Reset").click();
    settle(&mut window);
    assert!(composition(&window).is_plain());
    assert_eq!(window.state().viewer.view.composition, CompositionState::default());
}

/// 25 mm at 1000 mm with an apparent field of 52 degrees shows 1.3 degrees. The outline is part of the view, and the settings keep the numbers.
#[test]
fn the_field_of_a_telescope_is_outlined_and_fills_the_view() {
    let mut interface = saturn_with(&CompositionState::default());
    interface.tab = Some(Tab::Effects);
    let mut window = settled_window(interface, 1900.0);
    window.get_by_label("Telescope").click();
    settle(&mut window);
    assert!(window.query_by_label_contains("40×, field 1.30°").is_some());
    window.get_by_label("Fill the view").click();
    settle(&mut window);
    assert!((window.state().viewer.view.fov_deg - 1.3).abs() < 1e-9);
    window.state_mut().viewer.view.fov_deg = 2.0;
    let segment_count = |window: &Window| window.state().shown().expect("an image").scene.lines_in_space.len();
    settle(&mut window);
    let without_outline = segment_count(&window);
    window.get_by_label("Outline its field").click();
    settle(&mut window);
    let telescope = window.state().viewer.view.telescope.expect("a telescope");
    assert_eq!(telescope.to_text(), "1000/25/52");
    assert!(segment_count(&window) > without_outline + 8);
    window.get_by_label("Mirror image").click();
    settle(&mut window);
    assert!(window.state().shown().expect("an image").job.request.is_mirrored);
    // The telescope of a link is that of the panel.
    window.state_mut().viewer.view.telescope = Some(Telescope::parse("2000/36x24").expect("a telescope"));
    settle(&mut window);
    assert!(window.query_by_label_contains("Field 1.03° × 0.69°").is_some());
    assert_eq!((window.state().settings.telescope.has_camera, window.state().settings.telescope.focal_length_mm), (true, 2000.0));
}

/// A dome is combined from frames of other sizes, so a pixel of the image is no pixel of a frame.
#[test]
fn the_probe_refuses_a_pixel_of_a_dome() {
    let mut interface = saturn_with(&compositions()[1]);
    interface.tab = Some(Tab::Shader);
    let mut window = settled_window(interface, 900.0);
    window.get_by_label("Probe").click();
    settle(&mut window);
    window.get_by_label("Centre of the image").click();
    settle(&mut window);
    assert!(window.query_all_by_label_contains("choose the perspective projection").count() > 0);
    window.state_mut().viewer.view.composition = CompositionState::default();
    settle(&mut window);
    assert_eq!(window.query_all_by_label_contains("choose the perspective projection").count(), 0);
}

#[test]
fn a_link_keeps_the_composition_and_refuses_impossible_ones() {
    let view = saturn_with(&CompositionState::default()).viewer.view;
    assert!(!view.to_link().contains("composition"), "a plain image omits the composition");
    let now = Instant::parse(TIME).expect("a time");
    for composition in compositions() {
        let kept = orrery::view::app::view_state::ViewState { composition, ..view.clone() };
        assert_eq!(view_from_text(&kept.to_link(), session(), now).expect("a view"), kept);
        assert_eq!(view_from_text(&kept.to_json(), session(), now).expect("a view"), kept);
    }
    let from_short_link = view_from_text("orrery://view?target=saturn&composition.stereo=interlaced", session(), now).expect("a view");
    assert_eq!(from_short_link.composition, CompositionState { stereo: Some(StereoLayout::Interlaced), ..CompositionState::default() });
    for (fields, message_part) in [
        ("composition.projection=fishey", "fisheye"),
        ("composition.fisheye_deg=400", "1 to 360 degrees"),
        ("composition.stereo=red", "anaglyph"),
        ("composition.eye_separation_km=-1", "more than 0 km"),
        ("composition.dome_tilt_deg=1e9", "-180 to 180"),
        ("composition.tilt=3", "no such field"),
        ("composition=fisheye", "composition"),
    ] {
        let error = view_from_text(&format!("orrery://view?target=saturn&{fields}"), session(), now).expect_err(fields).to_string();
        assert!(error.contains(message_part) && error.contains("composition") && !error.contains('\n'), "{fields}: {error}");
    }
}
