//! Tests of views as text: what is written is read back exactly, and invalid text is rejected in one line.

use super::*;
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{Quality, ToneMap};
use crate::view::app::view_state::CameraPose;
use glam::DVec3;

fn view() -> ViewState {
    let time = Instant::from_tdb_seconds_past_j2000(765_894_000.123_456_7);
    let mut view = ViewState::around(NaifId(699), DVec3::new(1.0, -2.0, 0.7) * 2e5, 60_268.0, DVec3::new(0.08, 0.07, 0.99), time);
    view.effects = EffectOverrides::parse("+eclipse=linear,-rings").expect("effects");
    view.exposure_stops = Some(-1.25);
    view
}

/// A default view that differs from `view()`.
fn defaults() -> ViewState {
    let time = Instant::from_tdb_seconds_past_j2000(5.0);
    ViewState::around(NaifId::MOON, DVec3::new(0.0, 6e3, 1e3), 1737.4, DVec3::Z, time)
}

fn catalog() -> &'static Catalog {
    static CATALOG: std::sync::OnceLock<Catalog> = std::sync::OnceLock::new();
    CATALOG.get_or_init(Catalog::embedded)
}

fn with_test_defaults(mut partial_view: PartialView) -> Result<ViewState, String> {
    partial_view.resolve_body_names(catalog());
    partial_view.with_defaults(&defaults(), catalog()).map_err(|e| e.to_string())
}

fn of_link(link: &str) -> Result<ViewState, String> {
    with_test_defaults(PartialView::of_link(link))
}

#[test]
fn links_and_files_restore_the_view_exactly() {
    let camera_poses = [
        view().camera_pose,
        CameraPose::Ground {
            body: NaifId::EARTH,
            latitude_deg: -33.3,
            longitude_deg: 0.1 + 0.2,
            height_km: 0.0017,
            azimuth_deg: 270.0,
            altitude_deg: 5.0,
        },
        CameraPose::Centre { body: NaifId::EARTH },
        CameraPose::Free { body: NaifId::MOON, offset_km: DVec3::new(1e9, 1.0 / 3.0, 0.0), forward: DVec3::X, up: DVec3::Z },
    ];
    for (camera_pose, paused) in camera_poses.into_iter().zip([None, Some(true), Some(false), Some(true)]) {
        let view = ViewState { camera_pose, paused, ..view() };
        assert_eq!(of_link(&view.to_link()).as_ref(), Ok(&view), "{}", view.to_link());
        assert_eq!(with_test_defaults(PartialView::of_json(&view.to_json())), Ok(view));
    }
    let mirrored = ViewState { is_mirrored: true, ..view() };
    assert!(mirrored.to_link().contains("&mirrored=true") && of_link(&mirrored.to_link()).as_ref() == Ok(&mirrored), "{mirrored:?}");
    let telescope = Some(crate::scene::request::Telescope::parse("1000/22.3x14.9").expect("a telescope"));
    let outlined = ViewState { telescope, ..view() };
    assert_eq!(of_link(&outlined.to_link()).as_ref(), Ok(&outlined), "{}", outlined.to_link());
    assert!(of_link("orrery://view?telescope.kind=eyepiece&telescope.focal_length_mm=1").is_err_and(|why| why.starts_with("telescope")));
    let link = view().to_link();
    assert!(link.contains("target=699&") && !link.contains("mirrored"), "{link}");
    for form in [link.replacen("orrery://view?", "Orrery://VIEW/?", 1), format!(" {link}\n")] {
        assert!(is_link(&form) && of_link(&form) == Ok(view()), "{form}");
    }
    assert!(!is_link("orrery.json") && !is_link("or"));
    for text in [link, view().to_json()] {
        assert_eq!(with_test_defaults(PartialView::of(&format!("\u{feff}{text}"))), Ok(view()), "a byte order mark does not count");
    }
}

#[test]
fn omitted_fields_have_the_defaults_of_a_new_window() {
    assert_eq!(of_link("orrery://view"), Ok(defaults()));
    // A link may switch these two layers on by `layers` or by their own fields; both set the fields.
    let with_both = ViewState { orbits: true, bloom: true, ..defaults() };
    assert_eq!(of_link("orrery://view?layers=%2Borbits,%2Bbloom"), Ok(with_both.clone()));
    assert_eq!(of_link("orrery://view?orbits=true&bloom=true"), Ok(with_both));
    assert_eq!(of_link("orrery://view?fov_deg=3"), Ok(ViewState { fov_deg: 3.0, ..defaults() }));
    let Ok(ViewState { camera_pose: CameraPose::Orbit { distance_radii: 9.0, azimuth_deg, .. }, .. }) =
        of_link("orrery://view?eye.distance_radii=9")
    else {
        panic!("an orbit at 9 radii")
    };
    assert!(matches!(defaults().camera_pose, CameraPose::Orbit { azimuth_deg: default_deg, .. } if default_deg == azimuth_deg));
    let ground = of_link("orrery://view?eye.kind=ground&eye.latitude_deg=51.5").map(|view| view.camera_pose);
    assert_eq!(ground, Ok(pose_on_ground(NaifId::MOON, 51.5, 0.0)));
    let centre = of_link("orrery://view?eye.kind=centre&eye.body=399").map(|view| view.camera_pose);
    assert_eq!(centre, Ok(CameraPose::Centre { body: NaifId::EARTH }));
}

#[test]
fn target_and_time_of_a_link_are_known_before_the_other_fields_are_read() {
    let partial_view = |query: &str| {
        let mut partial_view = PartialView::of_link(&format!("orrery://view?{query}"));
        partial_view.resolve_body_names(catalog());
        partial_view
    };
    assert_eq!(partial_view("").target(), NaifId::EARTH);
    assert_eq!(partial_view("eye.body=301").target(), NaifId::MOON);
    assert_eq!(partial_view("target=599&eye.body=301").target(), NaifId(599));
    assert_eq!(partial_view("").take_time(), None);
    assert_eq!(partial_view("tdb_s=7.5").take_time(), Some(Instant::from_tdb_seconds_past_j2000(7.5)));
    let eclipse = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    assert_eq!(partial_view("time=2024-04-08T18:17:16Z").take_time(), Some(eclipse));
    for (bad, expected) in [("time=noon", "time"), ("time=noon&tdb_s=1", "leave one out"), ("time=3", "time")] {
        let mut partial_view = partial_view(bad);
        let is_rejected = partial_view.take_time().is_none() && partial_view.errors.iter().any(|why| why.contains(expected));
        assert!(is_rejected, "{bad}: {:?}", partial_view.errors);
    }
}

/// Every body is found by its name, its name in capitals, its aliases and its code, as target and as the camera's body.
#[test]
fn bodies_are_given_by_name_alias_or_code() {
    for body in catalog().bodies() {
        let names = [body.name.clone(), body.name.to_uppercase(), body.id.0.to_string()];
        for name in names.iter().chain(&body.aliases) {
            let link = format!("orrery://view?target={}&eye.body={}", escaped(name), escaped(name));
            let view = of_link(&link).expect(&link);
            assert_eq!((view.target, view.camera_pose.body()), (body.id, body.id), "{link}");
            let json = format!("{{\"target\": {}}}", Value::from(name.as_str()));
            assert!(
                name.parse::<i32>().is_ok() || with_test_defaults(PartialView::of_json(&json)).is_ok_and(|view| view.target == body.id),
                "{json}"
            );
        }
    }
    for bad in ["target=jupitre", "target=", "eye.body=planet%20nine", "target=earth-moon%20barycenter", "target=1.5", "target=true"] {
        let why = of_link(&format!("orrery://view?{bad}")).expect_err(bad);
        let field = bad.split('=').next().unwrap_or_default();
        assert!(why.starts_with(field) && !why.contains('\n'), "{bad}: {why}");
    }
}

/// Values as earlier versions wrote them.
#[test]
fn names_of_earlier_versions_are_read() {
    let old = of_link("orrery://view?tone_map=plain&pixels=shaded&quality=reference&effects=-rings").expect("a view");
    let effects = EffectOverrides::parse("-rings").expect("effects");
    assert_eq!(old, ViewState { tone_map: ToneMap::Clipped, quality: Quality::Reference, effects, ..defaults() });
    assert!(old.to_link().contains("tone_map=clipped&") && old.to_link().contains("pixels=final&"), "{}", old.to_link());
    assert_eq!(of_link("orrery://view?tone_map=film"), Ok(defaults()));
}

#[test]
fn misspelt_words_in_a_link_get_a_suggestion() {
    for (misspelt, meant) in [
        ("target=satrun", "`Saturn`"),
        ("eye.body=jupitr", "`Jupiter`"),
        ("targte=599", "`target`"),
        ("tiem=now", "`time`"),
        ("pasued=true", "`paused`"),
        ("eye.latitud_deg=3&eye.kind=ground", "`latitude_deg`"),
        ("effects=%2Beclips", "`eclipse`"),
    ] {
        let why = of_link(&format!("orrery://view?{misspelt}")).expect_err(misspelt);
        assert!(why.contains("did you mean") && why.contains(meant), "{misspelt}: {why}");
    }
    assert!(of_link("orrery://view?qqqq=1").is_err_and(|why| !why.contains("did you mean")), "nothing is similar");
}

/// Otherwise one of the two values would be lost without a message. The same body as target and as the camera's body is no repetition.
#[test]
fn a_field_given_twice_is_an_error() {
    for (query, field) in [
        ("target=599&target=699", "target"),
        ("fov_deg=3&orbits=true&fov_deg=3", "fov_deg"),
        ("eye.body=301&eye.distance_radii=9&eye.body=399", "eye.body"),
    ] {
        let why = of_link(&format!("orrery://view?{query}")).expect_err(query);
        assert!(why.contains(&format!("`{field}` is given twice")), "{query}: {why}");
    }
    // A value may be a group of fields.
    let why = of_link("orrery://view?eye={\"body\":301,\"body\":399}").expect_err("two bodies");
    assert!(why.contains("`eye`: field `body` is given twice"), "{why}");
    let of_json = |text: &str| with_test_defaults(PartialView::of_json(text));
    let why = of_json("{\"target\": 599, \"eye\": {\"body\": 301, \"body\": 399}}").expect_err("two bodies");
    assert!(why.contains("field `body` is given twice"), "{why}");
    assert!(of_link("orrery://view?target=599&eye.body=599").is_ok() && of_json("{\"target\": 599, \"eye\": {\"body\": 599}}").is_ok());
}

/// A value of the wrong kind is reported in plain words, without the names of Rust's types.
#[test]
fn wrong_kinds_of_values_are_reported_in_plain_words() {
    for (link, part) in [
        ("time=2024", "time: time `2024`: the month is missing; give ISO 8601 UTC such as 2024-"),
        ("time=true", "time: time `true`: the year "),
        ("fov_deg=wide", "fov_deg: expected a number, found the text \"wide\""),
        ("eye.distance_radii=far", "eye.distance_radii: expected a number, found the text \"far\""),
        ("tracks=1", "tracks: expected a boolean, found the number 1"),
        ("quality=3", "quality: expected a string, found the number 3"),
    ] {
        let mut partial_view = PartialView::of_link(&format!("orrery://view?{link}"));
        let _ = partial_view.take_time();
        let why = with_test_defaults(partial_view).expect_err(link);
        assert!(why.starts_with(part), "{link}: {why}");
    }
}

#[test]
fn invalid_links_are_rejected_in_one_line() {
    let good = view().to_link();
    for (bad, expected_part) in [
        (good.replace("view?", "look?"), "orrery://"),
        (good.replace("target", "aim"), "aim"),
        (good.replace("fov_deg=45.0", "fov_deg=0"), "fov_deg"),
        (good.replace("eye.kind=orbit", "eye.kind=perch"), "perch"),
        (good.replace("%3D", "%3"), "escape"),
        (good.replace("-rings", "-wings"), "wings"),
        (format!("{good}&target.x=1"), "target"),
        ("orrery://view?eye=3".into(), "3"),
        ("orrery://view?eye.kind=free".into(), "offset_km"),
        ("orrery://view?tdb_s=1e999".into(), "1e999"),
        ("orrery://view?tdb_s=now".into(), "tdb_s"),
        ("orrery://view?eye.latitude_deg=3".into(), "latitude_deg"),
        (format!("orrery://view?{}=1", "a.".repeat(30_000)), "deep"),
        (format!("orrery://view?{}", "a=1&".repeat(30_000)), "bytes"),
        ("orrery://view?quality=be%0Ast".into(), "quality"),
    ] {
        let why = with_test_defaults(PartialView::of(&bad)).expect_err(expected_part);
        assert!(why.contains(expected_part) && !why.contains('\n') && why.len() < 1000, "{}: {why}", shortened(&bad));
    }
    assert!(of_link("https://x").is_err_and(|why| why.contains("orrery://")));
    // Characters that control a terminal or the direction of text are escaped.
    for control in ['\u{1b}', '\u{202e}'] {
        let why = of_link(&format!("orrery://view?a{control}b")).expect_err("no field=value");
        assert!(!why.contains(control) && why.contains(&control.escape_default().to_string()), "{why}");
    }
    for bad in ["", "[1]", "{\"target\":", "7"] {
        assert!(with_test_defaults(PartialView::of_json(bad)).is_err_and(|why| !why.contains('\n')), "{bad}");
    }
}

/// All pairs of these errors, and all sets of at least 14 of the 15: each error of the link is reported, and no other.
#[test]
fn all_errors_of_a_link_are_listed() {
    let errors = [
        ("target=jupitre", "jupitre"),
        ("aim=3", "aim"),
        ("fov_deg=500", "fov_deg"),
        ("roll_deg=left", "roll_deg"),
        ("effects=%2Bwings", "wings"),
        ("tone_map=sepia", "sepia"),
        ("pixels=colour", "colour"),
        ("quality=best", "best"),
        ("exposure_stops=900", "exposure_stops"),
        ("paused=maybe", "paused"),
        ("eye.distance_radii=far", "eye.distance_radii"),
        ("eye.azimuth=3", "azimuth"),
        ("eye.body=nowhere", "nowhere"),
        ("bloom", "bloom"),
        ("orbits=%zz", "orbits"),
    ];
    for chosen_bits in (1_u32..1 << errors.len()).filter(|bits| bits.count_ones() == 2 || bits.count_ones() > 13) {
        let is_chosen = |k: &usize| chosen_bits & (1 << k) != 0;
        let pairs: Vec<&str> = (0..errors.len()).filter(is_chosen).map(|k| errors[k].0).collect();
        let link = format!("orrery://view?{}", pairs.join("&"));
        let why = of_link(&link).expect_err(&link);
        assert!(why.starts_with(&format!("{} errors: ", pairs.len())), "{link}: {why}");
        for (k, (_, name)) in errors.iter().enumerate() {
            assert_eq!(why.contains(name), is_chosen(&k), "{link}: `{name}` in {why}");
        }
    }
    let many: String = (0..500).map(|k| format!("f{k}=1&")).collect();
    let why = of_link(&format!("orrery://view?{many}")).expect_err("500 fields");
    assert!(why.starts_with("500 errors: ") && why.ends_with('…') && why.len() < 6000, "{why}");
}
