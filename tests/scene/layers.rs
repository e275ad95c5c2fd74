//! Layers of an image: orbits, names, an outline, bloom. Each appears only when requested and changes only its own pixels. Tests of where
//! orbit lines run are in src/scene/annotation/orbits.rs, of letters in src/image/glyph_atlas.rs.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::labels::{Label, LabelLayer, LabelMetrics, LabelSide, label_rect};
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Stereo, StereoLayout, ToneMap, Up, ViewRequest};
use orrery::time::Instant;

const JUPITER: NaifId = NaifId(599);

/// Jupiter and its surroundings.
fn jupiter() -> ViewRequest {
    let time = Instant::parse("2024-12-07T20:00:00Z").expect("a time");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(12.0) };
    ViewRequest { position, width: 256, height: 256, ..ViewRequest::of(JUPITER, time) }
}

#[test]
fn orbits_pass_in_front_of_and_behind_the_planet() {
    let [plain, with_orbits] = [false, true].map(|orbits| draw_with(Layers { orbits, ..Layers::default() }, &jupiter()));
    assert!(plain.scene.orbits.is_empty() && with_orbits.scene.orbits.len() > 12, "{} arcs", with_orbits.scene.orbits.len());
    assert!(plain.scene.bodies.iter().flat_map(|b| &b.decisions).all(|d| d.effect != "orbit"), "no orbit was requested");
    let camera = &with_orbits.scene.camera;
    let planet = with_orbits.scene.body(JUPITER).expect("in the catalog");
    let centre = camera.pixel_from_clip(camera.clip(planet.placement.centre_km).expect("in front"));
    // Depth is reversed: a nearer point has a larger value.
    let planet_depth = orrery::scene::camera::NEAR_DEPTH_KM / planet.placement.centre_km.dot(camera.forward);
    let is_changed = |at: DVec2| {
        let k = at.y as usize * camera.width as usize + at.x as usize;
        (0..3).any(|c| (plain.frame.hdr[k][c] - with_orbits.frame.hdr[k][c]).abs() > 1e-3)
    };
    // Numbers of changed points and of all points.
    let (mut in_front, mut behind, mut beside) = ((0, 0), (0, 0), (0, 0));
    let arc_fractions = (0..16).map(|k| (f64::from(k) + 0.5) / 16.0);
    for place in with_orbits.scene.orbits.iter().flat_map(|arc| arc_fractions.clone().map(move |fraction| arc.clip(fraction))) {
        let at = camera.pixel_from_clip(place.truncate());
        if at.min_element() < 0.0 || at.max_element() >= 256.0 {
            continue;
        }
        let from_centre = (at - centre).length() / (0.5 * planet.diameter_px);
        let count = match (from_centre, place.z > planet_depth) {
            (..0.8, true) => &mut in_front,
            (..0.8, false) => &mut behind,
            (1.2.., _) => &mut beside,
            _ => continue,
        };
        *count = (count.0 + u32::from(is_changed(at)), count.1 + 1);
    }
    let nearly_all = |(changed, all): (u32, u32)| all > 3 && 10 * changed > 9 * all;
    assert!(nearly_all(in_front) && nearly_all(beside), "(changed, all): in front {in_front:?}, beside {beside:?}");
    // The line of another moon may pass in front of the hidden point.
    assert!(behind.1 > 3 && 4 * behind.0 < behind.1, "(changed, all): behind {behind:?}");
    let decision_of = |name: &str| {
        with_orbits.scene.bodies.iter().find(|b| b.name == name).and_then(|b| b.decisions.iter().find(|d| d.effect == "orbit"))
    };
    assert!(decision_of("Io").is_some_and(|d| d.on && d.reason.to_string().contains("Jupiter")), "{:?}", decision_of("Io"));
    assert!(decision_of("Moon").is_some_and(|d| !d.on), "{:?}", decision_of("Moon"));
    assert!(decision_of("Sun").is_none(), "{:?}", decision_of("Sun"));
}

#[test]
fn layers_are_parsed_or_refused_by_name() {
    assert_eq!(Layers::parse("+orbits,-labels").expect("layers"), Layers { orbits: true, ..Layers::default() });
    assert_eq!(Layers::parse("+Orbits,-LABELS").expect("layers"), Layers { orbits: true, ..Layers::default() });
    // The last sign counts.
    assert_eq!(Layers::parse("+orbits, -orbits").expect("layers"), Layers::default());
    // The text contains only the settings that differ from the default, and parses back to them.
    assert_eq!(Layers::default().to_text(), "");
    let switched = Layers::parse("-stars,+bloom").expect("layers");
    assert_eq!((switched.to_text().as_str(), switched.stars), ("+bloom,-stars", false));
    assert_eq!(Layers::parse(&switched.to_text()).expect("layers"), switched);
    for (text, why) in [("orbits", "write + or -"), ("+weather", "one of orbits, traces, labels, data"), ("labels", "write + or -")] {
        let error = Layers::parse(text).expect_err("refused").to_string();
        assert!(error.contains(why) && error.contains(text), "{error}");
    }
}

/// Positions of the pixels at which the displayed images differ.
fn changed_pixels(a: &orrery::session::DrawnFrame, b: &orrery::session::DrawnFrame) -> Vec<DVec2> {
    let width = a.frame.width as usize;
    let pairs = a.frame.display.iter().zip(&b.frame.display).enumerate();
    pairs.filter(|(_, (a, b))| a != b).map(|(k, _)| DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5)).collect()
}

fn draw_with(layers: Layers, request: &ViewRequest) -> orrery::session::DrawnFrame {
    let sampling = SamplingQuality { samples: 4, anisotropy: 1 };
    SESSION.draw(&ViewRequest { layers, ..request.clone() }, sampling, FrameImages::DisplayAndHdr).expect("drawn")
}

#[test]
fn names_appear_next_to_their_bodies_and_do_not_change_the_light() {
    let request = jupiter();
    let without_labels = draw_with(Layers::default(), &request);
    let named = draw_with(Layers { labels: true, ..Layers::default() }, &request);
    assert_eq!(without_labels.frame.hdr, named.frame.hdr, "names are not light");
    let labels = named.scene.labels.as_ref().expect("labels were requested");
    let metrics = LabelMetrics::of_size(labels.glyph_px);
    assert!(labels.labels.iter().filter(|label| label.name_side.is_some()).count() > 1, "{:?}", labels.labels);
    let changed_places = changed_pixels(&without_labels, &named);
    // Twice the mean width of a letter is wider than any name needs.
    let wide = LabelMetrics { glyph_width_px: 2.0 * metrics.glyph_width_px, ..metrics };
    let covers = |label: &Label, at: DVec2| {
        let name = label_rect(label.centre_px, label.radius_px, &label.name, &wide, label.name_side.unwrap_or(LabelSide::DEFAULT));
        let margin = DVec2::splat(0.5 * metrics.line_height_px);
        let in_name = label.name_side.is_some() && at.cmpge(name.min - margin).all() && at.cmple(name.max + margin).all();
        in_name || label.centre_px.distance(at) < 8.0
    };
    let stray: Vec<_> = changed_places.iter().filter(|at| !labels.labels.iter().any(|label| covers(label, **at))).collect();
    assert!(stray.is_empty(), "changed away from every name and marker: {stray:?}");
    for (label, side) in labels.labels.iter().filter_map(|label| Some((label, label.name_side?))) {
        let name = label_rect(label.centre_px, label.radius_px, &label.name, &wide, side);
        let inked = changed_places.iter().filter(|at| at.cmpge(name.min).all() && at.cmple(name.max).all()).count();
        let glyphs = label.name.chars().count();
        assert!(inked > 8 * glyphs, "{}: {inked} pixels for {glyphs} letters", label.name);
    }
}

#[test]
fn an_outline_runs_around_the_selected_body_and_nowhere_on_it() {
    let time = Instant::parse("2024-12-07T20:00:00Z").expect("a time");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(4.0) };
    let request = ViewRequest { position, width: 200, height: 160, ..ViewRequest::of(JUPITER, time) };
    let without_outline = draw_with(Layers::default(), &request);
    let outlined = draw_with(Layers { outline: true, ..Layers::default() }, &request);
    assert_eq!(without_outline.frame.hdr, outlined.frame.hdr, "an outline is not light");
    let camera = &without_outline.scene.camera;
    let planet = without_outline.scene.body(JUPITER).expect("in the catalog").placement;
    let outline_pixels = changed_pixels(&without_outline, &outlined);
    assert!(outline_pixels.len() > 200, "{}", outline_pixels.len());
    // A pixel is well inside the disc if the points 2 pixels away are on the disc.
    let on_disc = |at: DVec2| camera.surface_under_pixel(&planet, at).is_some();
    let neighbours = [DVec2::ZERO, DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y];
    let inside = outline_pixels.iter().filter(|at| neighbours.iter().all(|d| on_disc(**at + 2.0 * *d))).count();
    assert_eq!(inside, 0, "of {}", outline_pixels.len());
    let near = |at: DVec2| (-8..=8).any(|x| (-8..=8).any(|y| on_disc(at + DVec2::new(f64::from(x), f64::from(y)))));
    assert!(outline_pixels.iter().all(|at| near(*at)), "outline pixels far from the limb");
    // A selected body outside the frame has no outline.
    let with_selected = |body: i32| ViewRequest { selected: Some(NaifId(body)), ..request.clone() };
    let neptune = draw_with(Layers { outline: true, ..Layers::default() }, &with_selected(899));
    assert!(neptune.scene.outlined_shape.is_none() && changed_pixels(&without_outline, &neptune).is_empty());
}

/// The Sun from so close that its disc exceeds white in the middle of the image.
fn overexposed_sun() -> ViewRequest {
    let time = Instant::parse("2024-12-07T20:00:00Z").expect("a time");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(60.0) };
    let effects = EffectOverrides::parse("-glow,-points").expect("effects");
    ViewRequest {
        position,
        width: 256,
        height: 256,
        effects,
        exposure: ExposureRequest::Stops(-14.0),
        ..ViewRequest::of(NaifId::SUN, time)
    }
}

#[test]
fn bloom_spreads_its_share_of_the_light_above_white() {
    let bloom = Layers { bloom: true, ..Layers::default() };
    let request = ViewRequest { tone_map: ToneMap::Clipped, ..overexposed_sun() };
    let sampling = SamplingQuality { samples: 4, anisotropy: 1 };
    let without_bloom = draw_with(Layers::default(), &request);
    let bloomed = draw_with(bloom, &request);
    assert_eq!(without_bloom.frame.hdr, bloomed.frame.hdr, "bloom must not change the linear light");
    let exposure = without_bloom.scene.exposure.factor();
    let light_above_white = |c: usize| -> f64 {
        let of_pixel = |p: &[f32; 4]| {
            let exposed: [f64; 3] = std::array::from_fn(|k| f64::from(p[k]) * exposure);
            let peak = exposed.into_iter().fold(1e-12, f64::max);
            exposed[c] * (peak - 1.0).clamp(0.0, 16.0) / peak
        };
        without_bloom.frame.hdr.iter().map(of_pixel).sum()
    };
    assert!(light_above_white(1) > 50.0, "the disc must be beyond white: {}", light_above_white(1));
    let linear = |byte: u8| {
        let s = f64::from(byte) / 255.0;
        if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    };
    // Outside the disc nothing is clipped, so the added light can be measured there; the clipped disc hides its own share.
    let placement = without_bloom.scene.body(NaifId::SUN).expect("in the catalog").placement;
    let centre = DVec2::splat(128.0);
    let radius_px =
        (0..128).find(|r| without_bloom.scene.camera.surface_under_pixel(&placement, centre + DVec2::new(f64::from(*r), 0.0)).is_none());
    let radius_px = f64::from(radius_px.expect("a limb"));
    let added: f64 = (bloomed.frame.display.iter().zip(&without_bloom.frame.display).enumerate())
        .filter(|(k, _)| DVec2::new((k % 256) as f64 + 0.5, (k / 256) as f64 + 0.5).distance(centre) > radius_px + 2.0)
        .map(|(_, (b, p))| linear(b[1]) - linear(p[1]))
        .sum();
    // A Gaussian around a small disc has the fraction exp(-r^2 / 2 variance) of its light beyond r. Averaging over n pixels adds n^2 / 12
    // to the variance; interpolating between such averages adds n^2 / 6.
    let outside = |amplitude: f64, variance: f64| amplitude * (-0.5 * (radius_px + 2.0).powi(2) / variance).exp();
    // Variances of the two blurs, px²: their widths are fractions of the image's height.
    let (near, far) = ((0.006_f64 * 256.0).powi(2), (0.03_f64 * 256.0).powi(2));
    let resampling_variance = |n: f64| n * n / 12.0 + n * n / 6.0;
    let expected =
        light_above_white(1) * (outside(0.10, near + resampling_variance(4.0)) + outside(0.05, near + far + resampling_variance(16.0)));
    assert!((0.8..1.25).contains(&(added / expected)), "{added} added outside a disc of {radius_px} px, {expected} expected");
    let draw_count = |drawn: &orrery::session::DrawnFrame, module: &str| drawn.simple_draws.iter().filter(|d| d.module == module).count();
    assert_eq!(["shrink", "blur", "tone_map_bloom", "tone_map"].map(|m| draw_count(&bloomed, m)), [2, 4, 1, 0]);
    assert_eq!(["shrink", "blur", "tone_map_bloom", "tone_map"].map(|m| draw_count(&without_bloom, m)), [0, 0, 0, 1]);
    // Where nothing exceeds white, bloom changes no byte.
    let dim = ViewRequest { exposure: ExposureRequest::Stops(-24.0), ..request.clone() };
    let (without_bloom, bloomed) = (draw_with(Layers::default(), &dim), draw_with(bloom, &dim));
    assert_eq!(without_bloom.frame.display, bloomed.frame.display);
    // An image of one pixel is valid too.
    let smallest = ViewRequest { width: 1, height: 1, ..request };
    let drawn = SESSION.draw(&ViewRequest { layers: bloom, ..smallest }, sampling, FrameImages::DisplayAndHdr).expect("drawn");
    assert_eq!((drawn.frame.display.len(), drawn.frame.hdr.len()), (1, 1));
}

/// Jupiter at many places of the image: its name keeps clear of the caption. Without the caption it would not.
#[test]
fn a_name_keeps_clear_of_the_caption() {
    let time = Instant::parse("2024-12-07T20:00:00Z").expect("a time");
    let layer_of = |caption: bool, [right, up]: [f64; 2]| {
        // The camera looks up, so that Jupiter is low in the image.
        let direction = DVec3::new(-1.0, -right, up);
        let request = ViewRequest {
            position: Position::Offset { body: JUPITER, offset_km: DVec3::X * 2e7, axes: Axes::Icrf },
            look: Look::Along { direction, axes: Axes::Icrf },
            fov_deg: Some(30.0),
            width: 400,
            height: 300,
            layers: Layers { labels: true, caption, ..Layers::default() },
            ..ViewRequest::of(JUPITER, time)
        };
        SESSION.scene(&request).expect("a scene").labels.expect("labels")
    };
    let (mut named, mut usually_covered) = (0, 0);
    for place in (0..15).flat_map(|i| (0..7).map(move |k| [0.045 * f64::from(i - 7), 0.18 + 0.01 * f64::from(k)])) {
        let with_caption = layer_of(true, place);
        let metrics = LabelMetrics::of_size(with_caption.glyph_px);
        let caption: Vec<_> = with_caption.margin.occupied(&metrics).collect();
        assert!(!caption.is_empty(), "a caption");
        // Whether the caption covers Jupiter's name, if there is a name.
        let covers = |layer: &LabelLayer| {
            let jupiter = layer.labels.iter().find(|label| label.body == JUPITER)?;
            let name = label_rect(jupiter.centre_px, jupiter.radius_px, &jupiter.name, &metrics, jupiter.name_side?);
            Some(caption.iter().any(|text| text.min.cmplt(name.max).all() && name.min.cmplt(text.max).all()))
        };
        if let Some(is_covered) = covers(&with_caption) {
            assert!(!is_covered, "{place:?}");
            named += 1;
        }
        usually_covered += u32::from(covers(&layer_of(false, place)) == Some(true));
    }
    assert!(named > 20 && usually_covered > 5, "{named} names; without the caption, {usually_covered} would lie under it");
}

/// The scene of a stereo pair has caption and scale bar where the image shows them, once per eye.
#[test]
fn the_scene_of_a_stereo_pair_has_its_texts_where_they_are_drawn() {
    for layout in [StereoLayout::SideBySide, StereoLayout::Anaglyph, StereoLayout::Interlaced] {
        let stereo = Some(Stereo { layout, eye_separation_km: None });
        let composition = Composition { stereo, ..Composition::default() };
        let request = ViewRequest { composition, width: 1200, height: 300, ..jupiter() };
        let [without_texts, drawn] = [false, true].map(|is_on| {
            let layers = Layers { caption: is_on, scale_bar: is_on, ..Layers::default() };
            let sampling = SamplingQuality { samples: 1, anisotropy: 1 };
            SESSION.draw(&ViewRequest { layers, ..request.clone() }, sampling, FrameImages::Display).expect("drawn")
        });
        let changed_places = changed_pixels(&without_texts, &drawn);
        let is_changed = |at: DVec2| changed_places.contains(&(at.floor() + 0.5));
        let layer = drawn.scene.labels.as_ref().expect("texts");
        let occupied: Vec<_> = layer.margin.occupied(&LabelMetrics::of_size(layer.glyph_px)).collect();
        for (k, rect) in occupied.iter().enumerate() {
            let inked = changed_places.iter().filter(|at| at.cmpge(rect.min).all() && at.cmple(rect.max).all()).count();
            assert!(inked > 3, "{layout:?} {k}: {inked} pixels in {rect:?}");
        }
        // The horizontal bars of both eyes, which are followed by their two ticks.
        assert_eq!(layer.margin.bars.len(), 6, "{layout:?}");
        let places: Vec<DVec2> = [0, 3].map(|k| layer.margin.bars[k].rect.min).into();
        let apart_px = if layout == StereoLayout::SideBySide { 600.0 } else { 0.0 };
        assert_eq!(places[1] - places[0], DVec2::new(apart_px, 0.0), "{layout:?}");
        for corner in places {
            let at = |right: f64| is_changed(corner + DVec2::new(right, 0.5));
            assert!(!at(-1.5) && at(0.5) && at(1.5), "{layout:?}: {corner}");
        }
    }
}

/// 50 km above the Moon, looking at its ground obliquely with eyes 20 km apart, of which one is higher: the ground in the middle is at other distances from
/// each eye, but both images have the scale bar of the view, in the same place.
#[test]
fn both_eyes_have_the_same_scale_bar() {
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    let pair = ViewRequest {
        layers: Layers { scale_bar: true, ..Layers::default() },
        position: Position::Offset { body: NaifId::MOON, offset_km: DVec3::X * 1787.4, axes: Axes::BodyFixed },
        look: Look::Along { direction: DVec3::new(-cos, sin, 0.0), axes: Axes::BodyFixed },
        up: Up::Along { direction: DVec3::Z, axes: Axes::BodyFixed },
        composition: Composition {
            stereo: Some(Stereo { layout: StereoLayout::SideBySide, eye_separation_km: Some(20.0) }),
            ..Composition::default()
        },
        width: 600,
        height: 200,
        ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-12-07T20:00:00Z").expect("a time"))
    };
    let scene = SESSION.draw(&pair, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::Display).expect("drawn").scene;
    let margin = &scene.labels.as_ref().expect("texts").margin;
    let [left, right] = [0, 3].map(|k| margin.bars[k].rect);
    let shift = DVec2::new(300.0, 0.0);
    assert_eq!((right.min, right.max), (left.min + shift, left.max + shift));
    assert_eq!(margin.texts[0].text, margin.texts[1].text);
    assert!(margin.texts[0].text.ends_with(" km"), "{}", margin.texts[0].text);
}

/// Distance, size, phase, magnitude and sub-points are those of the view, between the eyes. They were those of the left eye, which here is millions of
/// kilometres from the Earth's centre, and the Earth was beside itself.
#[test]
fn the_values_of_a_stereo_pair_are_those_of_the_view() {
    let time = Instant::parse("2024-01-20T16:30:00Z").expect("a time");
    let position = Position::Centre(NaifId::EARTH);
    let single = ViewRequest { position, width: 400, height: 300, fov_deg: Some(45.0), ..ViewRequest::of(JUPITER, time) };
    let scene = |request: &ViewRequest| {
        let sampling = SamplingQuality { samples: 1, anisotropy: 1 };
        SESSION.draw(request, sampling, FrameImages::Display).expect("drawn").scene
    };
    let values = |scene: &Scene, id: NaifId| {
        let body = scene.body(id).expect("in the catalog");
        let sub_points = [Some(body.sub_observer), body.sub_solar].map(|p| p.map(|p| [p.lat_centric_deg, p.lon_east_deg]));
        let numbers = [body.distance_km, body.angular_diameter_deg, body.diameter_px, body.phase_angle_deg];
        (numbers, body.magnitude, sub_points, body.sun_altitude_deg)
    };
    let view = scene(&single);
    for (layout, width) in [(StereoLayout::SideBySide, 800), (StereoLayout::Anaglyph, 400), (StereoLayout::Interlaced, 400)] {
        let stereo = Some(Stereo { layout, eye_separation_km: None });
        let pair = scene(&ViewRequest { composition: Composition { stereo, ..Composition::default() }, width, ..single.clone() });
        for id in [JUPITER, NaifId(501), NaifId::SUN, NaifId::MOON, NaifId::EARTH] {
            assert_eq!(values(&pair, id), values(&view, id), "{layout:?}: {id:?}");
        }
        // The comparison must be able to fail: what is drawn is where the left eye sees it, at another distance.
        let [from_eye_km, from_view_km] = [&pair, &view].map(|s| s.body(JUPITER).expect("in the catalog").placement.centre_km.length());
        assert!((from_eye_km - from_view_km).abs() > 1e3, "{layout:?}: {from_eye_km} and {from_view_km} km");
    }
    // The sub-solar latitude of the Earth is the declination of the Sun, -20.1 degrees on this day (Astronomical Almanac).
    let declination_deg = view.body(NaifId::EARTH).and_then(|earth| earth.sub_solar).expect("lit by the Sun").lat_centric_deg;
    assert!((declination_deg + 20.1).abs() < 0.1, "{declination_deg}");
}

/// A body from the Earth's centre, celestial north up.
fn from_earth(target: NaifId, utc: &str, fov_deg: f64, [width, height]: [u32; 2]) -> ViewRequest {
    let (position, fov_deg) = (Position::Centre(NaifId::EARTH), Some(fov_deg));
    ViewRequest { position, up: Up::Celestial, fov_deg, width, height, ..ViewRequest::of(target, Instant::parse(utc).expect(utc)) }
}

/// Jupiter's moons on 2026-11-30: Io had no name, since its places collided with the name of Ganymede, and the name of the invisible Amalthea stood at Io's
/// marker.
#[test]
fn crowded_names_are_those_of_the_brighter_bodies_and_next_to_their_own() {
    let layers = Layers { labels: true, ..Layers::default() };
    let request = ViewRequest { layers, ..from_earth(JUPITER, "2026-11-30T20:40:00Z", 1.0, [760, 712]) };
    let layer = SESSION.scene(&request).expect("a scene").labels.expect("labels");
    let metrics = LabelMetrics::of_size(layer.glyph_px);
    let marker_px = 5.0 / 13.0 * layer.glyph_px;
    let is_named = |moon: i32| layer.labels.iter().any(|label| label.body == NaifId(moon) && label.name_side.is_some());
    // Io and Europa have one marker.
    assert!(is_named(501) && is_named(503) && is_named(504), "{:?}", layer.labels);
    for (index, label) in layer.labels.iter().enumerate().filter(|(_, label)| label.body != JUPITER) {
        let Some(side) = label.name_side else { continue };
        let name = label_rect(label.centre_px, label.radius_px, &label.name, &metrics, side);
        let distance_px = |at: DVec2| at.distance(at.clamp(name.min, name.max)) - marker_px;
        // The more important labels come first.
        for other in layer.labels[..index].iter().filter(|other| other.radius_px < marker_px) {
            let distances_px = [label, other].map(|label| distance_px(label.centre_px));
            assert!(distances_px[0] <= distances_px[1], "{} is nearer to {}: {distances_px:?}", label.name, other.name);
            let apart_px = label.centre_px.distance(other.centre_px);
            assert!(other.name_side.is_some() || apart_px > metrics.line_height_px, "{} is named, {} is not", label.name, other.name);
        }
    }
}

/// A caption over the sunlit Moon could not be read: its letters are about as bright as the ground, and had only a shadow to their right.
#[test]
fn a_caption_over_sunlit_ground_has_a_dark_halo() {
    let request = from_earth(NaifId::MOON, "2026-11-24T21:00:00Z", 0.2, [512, 256]);
    let [plain, captioned] = [false, true].map(|caption| draw_with(Layers { caption, ..Layers::default() }, &request));
    let levels = |pixel: &[u8; 4]| pixel[..3].iter().map(|level| i32::from(*level)).sum::<i32>();
    let changes = plain.frame.display.iter().zip(&captioned.frame.display).map(|(before, after)| levels(after) - levels(before));
    let changed: Vec<i32> = changes.filter(|change| *change != 0).collect();
    let darkened = changed.iter().filter(|change| **change < -60).count();
    assert!(changed.len() > 500 && 3 * darkened > 2 * changed.len(), "{darkened} of {} pixels are darker", changed.len());
}

/// Behind Saturn, Pluto of magnitude 14 was named as large as Dione. It has a label if it is selected, and in a view that shows no body from near by.
#[test]
fn in_a_close_view_faint_bodies_of_other_systems_have_no_label() {
    let (saturn, pluto, dione) = (NaifId(699), NaifId(999), NaifId(604));
    let layers = Layers { labels: true, ..Layers::default() };
    let view = ViewRequest { layers, ..ViewRequest::of(saturn, Instant::parse("2026-08-20T00:00:00Z").expect("a time")) };
    let seen = SESSION.scene(&view).expect("a scene");
    let to_pluto = seen.body(pluto).expect("in the catalog").placement.centre_km.normalize();
    // From 11 radii, Pluto is 11 degrees beside the middle of Saturn.
    let away = (to_pluto + 0.2 * to_pluto.any_orthonormal_vector()).normalize() * -6.6e5;
    let position = Position::Offset { body: saturn, offset_km: away, axes: Axes::Icrf };
    let close = ViewRequest { position, fov_deg: Some(45.0), ..view };
    let is_labelled = |request: &ViewRequest, id: NaifId| {
        SESSION.scene(request).expect("a scene").labels.expect("labels").labels.iter().any(|label| label.body == id)
    };
    assert!(!is_labelled(&close, pluto) && is_labelled(&close, saturn));
    assert!([dione, NaifId(605), NaifId(606)].iter().any(|moon| is_labelled(&close, *moon)), "Saturn's moons");
    assert!(is_labelled(&ViewRequest { selected: Some(pluto), ..close.clone() }, pluto));
    let beside_saturn = ViewRequest { look: Look::Along { direction: to_pluto, axes: Axes::Icrf }, fov_deg: Some(8.0), ..close };
    assert!(is_labelled(&beside_saturn, pluto));
}
