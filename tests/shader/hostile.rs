//! Hostile fragments: each is refused or stopped with one line, and the session continues to draw with valid ones.

use orrery::scene::request::Quality;
use orrery::session::{RendererPreference, Session, Sources};
use orrery::shader::fragments::FRAGMENTS;
use orrery::{Fragments, FrameImages, Instant, NaifId, SamplingQuality, ViewRequest};
use std::time::{Duration, Instant as Clock};

/// The longest time that drawing or refusing may take. The renderer's own limit for one batch is about a second.
const TIMEOUT: Duration = Duration::from_secs(30);

const TONE_MAP: &str = "entry/tone_map.wesl";

/// The shipped tone map with added declarations, and added statements before its fragment stage returns.
fn tone_map(declarations: &str, statements: &str) -> Fragments {
    let (_, text) = FRAGMENTS.iter().find(|(name, _)| *name == TONE_MAP).expect("a fragment");
    let text = text
        .replace("@fragment", &format!("{declarations}\n@fragment"))
        .replace("    return displayed", &format!("{statements}\n    return displayed"));
    Fragments::with_files([(TONE_MAP.to_owned(), text)])
}

fn session(renderer: RendererPreference) -> Session {
    Session::open(&Sources { renderer, ..Sources::default() }, |_| {}).expect("a session")
}

/// The image's bytes, or the error.
fn drawn(session: &Session, fragments: Fragments) -> Result<Vec<[u8; 4]>, String> {
    session.set_fragments(fragments);
    let time = Instant::parse("2024-01-01T00:00:00Z").expect("a time");
    let request = ViewRequest { width: 48, height: 48, quality: Quality::Draft, ..ViewRequest::of(NaifId::MOON, time) };
    let start = Clock::now();
    let image = session
        .draw(&request, SamplingQuality::of(Quality::Draft), FrameImages::Display)
        .map(|d| d.frame.display)
        .map_err(|e| e.to_string());
    assert!(start.elapsed() < TIMEOUT, "{:?}: {image:?}", start.elapsed());
    image
}

/// Functions g0 to gN, each defined in terms of the previous one.
fn functions(count: usize, expression: impl Fn(usize) -> String) -> String {
    let function = |k: usize| format!("fn g{}(x: f32) -> f32 {{ return {}; }}\n", k + 1, expression(k));
    format!("fn g0(x: f32) -> f32 {{ return x * 1.5; }}\n{}", (0..count).map(function).collect::<String>())
}

/// Hostile cases: declarations, statements, and a part of the expected message.
fn hostile_cases() -> Vec<(String, String, &'static str)> {
    let endless_loops =
        "for (var i = 0u; i < 4000000000u; i++) { for (var j = 0u; j < 4000000000u; j++) { k += i ^ j ^ u32(position.x); } }";
    let deep_loops = format!("{}k += 1u;{}", "for (var i = k; i < 4000000000u; i++) { ".repeat(40), " }".repeat(40));
    let all: [(&str, &str, &'static str); 15] = [
        ("", "loop { }", "this loop never ends"),
        ("", "while true { let a = 1; }", "this loop never ends"),
        // It cannot be decided in advance whether these loops end.
        ("", "var x = radiance.x; while x > -1.0 { x += 1e-9; }", "a loop of the fragment stage was stopped"),
        ("", "var k = 0u; loop { k += u32(position.x) * 0u; if k > 0u { break; } }", "a loop of the fragment stage was stopped"),
        ("", &format!("var k = 0u; {endless_loops} if k == 7u {{ discard; }}"), "a loop of the fragment stage was stopped"),
        ("", &format!("var k = 0u; {deep_loops} if k == 7u {{ discard; }}"), "a loop of the fragment stage was stopped"),
        ("fn again(x: f32) -> f32 { return again(x + 1.0); }", "let y = again(radiance.x);", "`again` is recursive"),
        ("fn ping(x: f32) -> f32 { return pong(x); }\nfn pong(x: f32) -> f32 { return ping(x); }", "let y = ping(1.0);", "is cyclic"),
        // 2^40 calls when inlined.
        (&functions(40, |k| format!("g{k}(x) + g{k}(x + 1.0)")), "if g40(radiance.x) > 1e30 { discard; }", "too many"),
        (&functions(300, |k| format!("g{k}(x)")), "if g300(radiance.x) > 1e30 { discard; }", "nested in each other"),
        ("", "var a: array<f32, 4294967295>; a[u32(position.x)] = 1.0;", "Size exceeds limit"),
        ("", "var a: array<array<f32, 65536>, 65536>; a[u32(position.x)][1] = 1.0;", "Size exceeds limit"),
        (
            "",
            "var a: array<f32, 30000000>; a[u32(position.x)] = radiance.x; if a[u32(position.y)] > 1e30 { discard; }",
            "an array of more than 16384 numbers",
        ),
        ("", "var a = array<f32, 2>(1.0, 2.0); a[7] = 1.0;", "index 7 is out of"),
        ("var<private> big: array<f32, 1000000000>;", "big[u32(position.x)] = 1.0; if big[3] > 1.0 { discard; }", "Size exceeds limit"),
    ];
    all.into_iter().map(|(declarations, statements, word)| (declarations.to_owned(), statements.to_owned(), word)).collect()
}

#[test]
fn hostile_fragments_are_refused_and_valid_ones_draw_again() {
    let session = session(RendererPreference::Software);
    let valid_image = drawn(&session, Fragments::default()).expect("an image");
    for (declarations, statements, message_part) in hostile_cases() {
        let error = drawn(&session, tone_map(&declarations, &statements)).expect_err(&statements);
        assert!(error.contains(message_part) && !error.trim().contains('\n') && error.len() < 600, "{statements}: {error}");
        assert_eq!(drawn(&session, Fragments::default()).as_ref(), Ok(&valid_image), "after {statements}");
    }
}

/// Reads outside an array or a texture return some value of it or zero, never other memory, and a long bounded loop is drawn.
#[test]
fn indices_out_of_range_stay_inside_and_long_loops_that_end_are_drawn() {
    let session = session(RendererPreference::Software);
    let valid_image = drawn(&session, Fragments::default()).expect("an image");
    for statements in [
        "var a = array<f32, 3>(1.0, 2.0, 3.0); let far = a[u32(position.x * 1e6)]; if far < 0.0 || far > 3.0 { discard; }",
        "let far = textureLoad(hdr, vec2i(2147483647, -2147483647), 9999); if far.x != far.x { discard; }",
        "var a: array<f32, 4>; a[i32(position.x) - 1000000] = 5.0; a[0xffffffffu - u32(position.y)] = 7.0;",
        "var s = 0u; for (var i = 0u; i < 20000u; i++) { s += i ^ u32(position.x); } if s == 1u { discard; }",
    ] {
        assert_eq!(drawn(&session, tone_map("", statements)).as_ref(), Ok(&valid_image), "{statements}");
    }
}

/// A session with a GPU refuses hostile fragments too, because the software renderer runs new modules first. Afterwards the device draws
/// valid ones.
#[cfg(feature = "gpu")]
#[test]
fn hostile_fragments_do_not_disturb_the_gpu() {
    if crate::support::gpu::gpu().is_none() {
        return;
    }
    let session = session(RendererPreference::Gpu);
    let valid_image = drawn(&session, Fragments::default()).expect("an image");
    for (declarations, statements, message_part) in hostile_cases() {
        let error = drawn(&session, tone_map(&declarations, &statements)).expect_err(&statements);
        assert!(error.contains(message_part) && !error.trim().contains('\n'), "{statements}: {error}");
    }
    assert_eq!(drawn(&session, Fragments::default()), Ok(valid_image));
}
