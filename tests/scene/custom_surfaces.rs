//! Custom surfaces: which bodies they colour, that they can be switched off, that they may use every name, and how errors are reported.

use crate::support::folds::larger;
use orrery::catalog::NaifId;
use orrery::scene::effects::Effect;
use orrery::scene::request::{Position, ViewRequest};
use orrery::session::{Session, Sources, SurfaceError};
use orrery::shader::fragments::FRAGMENTS;
use orrery::shader::source::Fragment;
use orrery::{FrameImages, Instant, SamplingQuality};
use std::collections::BTreeSet;
use std::path::Path;

const CHECKERS: &str = "import package::lib::custom::surface_point::{CustomSurface, SurfacePoint};

fn custom_surface(point: SurfacePoint) -> CustomSurface {
    let cell = floor(point.position * 4.0);
    let is_dark = abs((cell.x + cell.y + cell.z) % 2.0) > 0.5;
    return CustomSurface(select(vec3f(0.8), vec3f(0.05), is_dark), vec3f(0.0));
}
";

/// A session with custom surfaces: body, file name and text of each.
fn open(folder: &Path, surfaces: &[(&str, &str, &str)]) -> Result<Session, String> {
    let surfaces = surfaces.iter().map(|(body, file, text)| {
        let path = folder.join(file);
        std::fs::write(&path, text).expect("written");
        format!("{body}={}", path.display()).parse().expect("a body and a file")
    });
    let cache = folder.join("cache");
    std::fs::create_dir_all(&cache).expect("a folder");
    let sources = Sources { surfaces: surfaces.collect(), cache: Some(cache), ..Sources::default() };
    Session::open(&sources, |_| ()).map_err(|e| e.to_string())
}

fn view(body: NaifId) -> ViewRequest {
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(4.0) };
    let time = Instant::parse("2024-04-16T01:00:00Z").expect("a time");
    ViewRequest { position, width: 96, height: 96, ..ViewRequest::of(body, time) }
}

/// Linear pixels.
fn light(session: &Session, request: &ViewRequest) -> Vec<[f32; 4]> {
    session.draw(request, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
}

/// Greatest difference in any channel.
fn greatest_difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, larger)
}

#[test]
fn a_surface_colours_only_its_body_and_can_be_switched_off() {
    let folder = tempfile::tempdir().expect("temp");
    let standard = open(folder.path(), &[]).expect("a session");
    let custom = open(folder.path(), &[("moon", "checkers.wesl", CHECKERS)]).expect("a session");
    let (moon, mars) = (view(NaifId::MOON), view(NaifId(499)));
    let before = light(&standard, &moon);
    assert!(
        greatest_difference(&before, &light(&custom, &moon)) > 0.1 * before.iter().map(|p| p[1]).fold(0.0, larger),
        "the Moon is chequered"
    );
    assert_eq!(greatest_difference(&light(&standard, &mars), &light(&custom, &mars)), 0.0, "Mars has no surface of its own");
    let mut without = moon.clone();
    without.effects.set(Effect::CustomSurface, false);
    assert_eq!(greatest_difference(&before, &light(&custom, &without)), 0.0, "switched off it changes nothing");
    let decisions = custom.scene(&moon).expect("a scene").bodies.into_iter().flat_map(|b| b.decisions);
    assert!(decisions.into_iter().any(|d| d.effect == "custom-surface" && d.on));
}

/// A surface that emits light needs no Sun: it is visible on the night side.
#[test]
fn a_surface_may_emit_light() {
    let folder = tempfile::tempdir().expect("temp");
    let glowing = CHECKERS.replace("vec3f(0.0));", "vec3f(0.25, 0.0, 0.0));");
    let custom = open(folder.path(), &[("moon", "glowing.wesl", &glowing)]).expect("a session");
    let standard = open(folder.path(), &[]).expect("a session");
    // At new moon the Moon's night side faces the Earth.
    let request = ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::EARTH), distance_radii: Some(4.0) },
        time: Instant::parse("2024-06-06T12:38:00Z").expect("a time"),
        ..view(NaifId::MOON)
    };
    let (dark, lit) = (light(&standard, &request), light(&custom, &request));
    let middle = 48 * 96 + 48;
    let added_red = lit[middle][0] - dark[middle][0];
    assert!((added_red - 0.25).abs() < 0.002, "red light of 0.25 of a white plane: {added_red}");
    assert!((lit[middle][2] - dark[middle][2]).abs() < 0.002, "no blue is added");
}

/// Names that shader sources declare, too, mean the surface's own functions in it, and those of the sources elsewhere: from near, where a view has most of the
/// sources, and from far.
#[test]
fn a_surface_may_declare_any_name() {
    let names: BTreeSet<String> = FRAGMENTS
        .iter()
        .flat_map(|(path, text)| Fragment::parse(path, text).expect("a built-in fragment").declared)
        .filter(|name| !["custom_surface", "CustomSurface", "SurfacePoint"].contains(&name.as_str()))
        .collect();
    assert!(["reflected", "hill", "gradient_noise", "albedo_map", "fragment_main", "draw"].iter().all(|n| names.contains(*n)));
    assert!(names.iter().all(|n| !n.starts_with("surface1_")), "the prefix is the custom surface's own");
    // Red light: the sum of what a function of each name returns, which f32 represents exactly.
    let functions: String = names.iter().map(|name| format!("fn {name}() -> f32 {{ return 0.0009765625; }}\n")).collect();
    let calls: String = names.iter().map(|name| format!("    red += {name}();\n")).collect();
    let text = |statements: &str| {
        let body = CHECKERS.replace("    return", &format!("    var red = 0.0;\n{statements}    return"));
        body.replace("vec3f(0.0));", "vec3f(red, 0.0, 0.0));")
    };
    let sum = names.len() as f64 / 1024.0;
    let folder = tempfile::tempdir().expect("temp");
    let named = open(folder.path(), &[("mars", "named.wesl", &(text(&calls) + &functions))]).expect("a session");
    let plain = open(folder.path(), &[("mars", "plain.wesl", &text(&format!("    red = {sum:?};\n")))]).expect("a session");
    for distance_radii in [4.0, 1.02] {
        let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(distance_radii) };
        let request = ViewRequest { position, width: 48, height: 48, ..view(NaifId(499)) };
        assert_eq!(greatest_difference(&light(&named, &request), &light(&plain, &request)), 0.0, "{distance_radii} radii");
    }
}

#[test]
fn errors_name_the_users_file() {
    let folder = tempfile::tempdir().expect("temp");
    let error_of =
        |surfaces: &[(&str, &str, &str)]| open(folder.path(), surfaces).err().unwrap_or_else(|| panic!("{surfaces:?} was accepted"));
    let unbalanced = CHECKERS.replace("vec3f(0.8)", "vec3f(0.8");
    let without_function = CHECKERS.replace("fn custom_surface", "fn my_surface");
    let mistyped = CHECKERS.replace("-> CustomSurface", "-> vec3f");
    for (text, expected) in [(&unbalanced, "surface.wesl:"), (&without_function, "custom_surface"), (&mistyped, "surface.wesl:")] {
        let message = error_of(&[("moon", "surface.wesl", text)]);
        assert!(message.contains(expected) && !message.contains('\n') && !message.contains("lib/custom/surface_1"), "{message}");
    }
    // Mistakes that naga's parser, its validator and the lowering find, in a line after the function's first line, which is the third. Some messages are longer
    // than what is quoted of them. Of a number in place of a vector or a struct, naga also names the place that asks for another type: in another fragment, or
    // nowhere.
    for mistake in [
        "return point.albedo;",
        "let x = point.albedo * vec2f(1.0, 2.0);",
        "if point.albedo { }",
        "let x = foo(point.albedo);",
        "return CustomSurface(point.albedo, 1.0);",
        "let x = SurfacePoint(1.0);",
        "return 1.0;",
        "loop { }",
        "let x = frexp(point.position.x);",
        "var x: array<f32, 20000>;",
    ] {
        for lines_before in [0, 3] {
            let text = CHECKERS.replace("{\n", &format!("{{\n{}    {mistake}\n", "\n".repeat(lines_before)));
            let (message, expected) = (error_of(&[("moon", "surface.wesl", &text)]), format!("surface.wesl:{}: ", 4 + lines_before));
            assert!(message.contains(&expected) && !message.contains("shaders/"), "{mistake} {message}, {expected} expected");
        }
    }
    // Both types are in the module that is compiled, because other sources import them.
    let (_, without_import) = CHECKERS.split_once('\n').expect("lines");
    let message = error_of(&[("moon", "surface.wesl", without_import)]);
    assert!(message.contains("surface.wesl:2: ") && message.contains("`SurfacePoint`"), "{message}");
    // The functions of the file have a prefix in the module, but not in messages.
    let helpers = format!("{CHECKERS}fn hill() -> f32 {{ return 1.0; }}\nfn billow() -> f32 {{ return hill(1.0); }}\n");
    let message = error_of(&[("moon", "surface.wesl", &helpers)]);
    let lines_before = CHECKERS.lines().count();
    assert!(message.contains(&format!("surface.wesl:{}: ", lines_before + 2)) && !message.contains("surface1"), "{message}");
    let message = error_of(&[("moon", "surface.wesl", &format!("{CHECKERS}fn hill() -> f32 {{ }}\n"))]);
    assert!(message.contains(&format!("surface.wesl:{}: the function `hill` can end without a value", lines_before + 1)), "{message}");
    let message = error_of(&[("moon", "surface.wesl", &format!("{CHECKERS}@fragment fn main() {{ }}\n"))]);
    assert!(message.contains(&format!("surface.wesl:{}:1: ", lines_before + 1)) && message.contains("`@fragment`"), "{message}");
    assert!(error_of(&[("moom", "a.wesl", CHECKERS)]).contains("Moon"), "the nearest name is offered");
    assert!(error_of(&[("moon", "a.wesl", CHECKERS), ("MOON", "b.wesl", CHECKERS)]).contains("MOON"));
    let five: Vec<(&str, &str, &str)> = ["moon", "mars", "io", "europa", "titan"].iter().map(|b| (*b, "a.wesl", CHECKERS)).collect();
    assert_eq!(error_of(&five), SurfaceError::TooMany(5).to_string());
    let missing = Sources { surfaces: vec!["moon=no-such-file.wesl".parse().expect("a body and a file")], ..Sources::default() };
    assert!(Session::open(&missing, |_| ()).is_err_and(|e| e.to_string().contains("no-such-file.wesl")));
}
