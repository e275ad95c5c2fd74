//! Animations that `orrery render` writes: their frames, their metadata, and which existing files they replace.

use super::{orrery, path_text, stderr_text};
use image::AnimationDecoder;
use orrery::image::{gif_text_in_head, png_text_in_head};
use std::path::Path;
use std::process::Output;

/// Draws three frames into `out`.
fn draw(out: &Path, extra_options: &[&str]) -> Output {
    draw_frames(out, "3", extra_options)
}

fn draw_frames(out: &Path, count: &str, extra_options: &[&str]) -> Output {
    let args = ["render", "--target", "phobos", "--time", "2024-04-08T18:17:16Z", "--size", "12x10", "--frames", count, "--step", "20m"];
    orrery(&[&args[..], &["-o", path_text(out)], extra_options].concat())
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a file")
}

#[test]
fn an_animation_has_the_frames_of_a_sequence_and_the_metadata_of_its_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    for name in ["out-%d.png", "out.apng", "out.gif"] {
        let out = draw(&path_of(name), &["--rate", "10"]);
        assert!(out.status.success(), "{name}: {}", stderr_text(&out));
    }
    let frame_of_sequence = |k: usize| image::open(path_of(&format!("out-{k}.png"))).expect("an image").to_rgb8();
    let file = std::io::BufReader::new(std::fs::File::open(path_of("out.apng")).expect("a file"));
    let frames =
        image::codecs::png::PngDecoder::new(file).expect("a PNG").apng().expect("animated").into_frames().collect_frames().expect("frames");
    assert_eq!(frames.len(), 3);
    for (k, frame) in frames.iter().enumerate() {
        assert_eq!(image::DynamicImage::from(frame.buffer().clone()).to_rgb8(), frame_of_sequence(k), "frame {k}");
        assert_eq!(frame.delay().numer_denom_ms(), (100, 1));
    }
    assert_ne!(frame_of_sequence(0), frame_of_sequence(2), "the comparison must be able to fail");
    let [png, apng, gif] = ["out-0.png", "out.apng", "out.gif"].map(|name| read(&path_of(name)));
    for keyword in ["Title", "Creation Time", "Description", "Legend", "Software"] {
        let of_png = png_text_in_head(&png, keyword).expect(keyword);
        assert_eq!(png_text_in_head(&apng, keyword).as_ref(), Some(&of_png), "{keyword}");
        assert_eq!(gif_text_in_head(&gif, keyword).as_ref(), Some(&of_png), "{keyword}");
    }
    let request = png_text_in_head(&apng, "Request");
    assert!(request == gif_text_in_head(&gif, "Request") && request.is_some_and(|r| r.contains("\"frames\":\"3 at 10 per second (")));
}

/// One of the same request is drawn again, with the same bytes. Others are kept unless `--overwrite` is given.
#[test]
fn an_animation_replaces_one_of_its_own_request_only() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a.apng", "a.gif"] {
        let path = folder.path().join(name);
        assert!(draw(&path, &[]).status.success());
        let bytes = read(&path);
        for same_request in [&[][..], &["--overwrite"], &["--threads", "1"]] {
            let again = draw(&path, same_request);
            assert!(again.status.success(), "{name} {same_request:?}: {}", stderr_text(&again));
            assert_eq!(read(&path), bytes, "{name} {same_request:?}");
        }
        for (other, message_part) in [
            (draw(&path, &["--tone-map", "clipped"]), "tone-map filmic, not clipped"),
            (draw(&path, &["--rate", "20"]), "frames 3 at 25 per second"),
            (draw_frames(&path, "4", &[]), "not 4 at 25 per second"),
        ] {
            let line = stderr_text(&other);
            assert_eq!((other.status.code(), line.trim().lines().count()), (Some(1), 1), "{name}: {line}");
            assert!(line.contains("--overwrite") && line.contains(message_part), "{name}: {line}");
            assert_eq!(read(&path), bytes, "{name}");
        }
        std::fs::write(&path, "mine").expect("a file");
        let line = stderr_text(&draw(&path, &[]));
        assert!(line.contains("its request is unknown") && line.contains("--overwrite"), "{name}: {line}");
        assert_eq!(read(&path), b"mine");
        assert!(draw(&path, &["--overwrite"]).status.success());
        assert_eq!(read(&path), bytes, "{name}");
    }
}

#[test]
fn unsupported_settings_are_reported_before_anything_is_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gif");
    for (extra_options, message_part) in
        [(&["--shard", "0/2"][..], "--shard"), (&["--rate", "400"], "1 to 50"), (&["--rate", "29.97"], "whole number")]
    {
        let out = draw(&path, extra_options);
        let message = stderr_text(&out);
        assert!(out.status.code() == Some(2) && message.contains(message_part) && !path.exists(), "{message}");
    }
}

/// Film and television have rates that are no whole numbers.
#[test]
fn a_stream_may_have_any_rate() {
    for (rate, in_header) in [("25", " F25:1 "), ("29.97", " F30000:1001 "), ("24000/1001", " F24000:1001 "), ("12.5", " F12500:1000 ")] {
        let out = draw(Path::new("-"), &["--rate", rate]);
        let header = String::from_utf8_lossy(out.stdout.split(|byte| *byte == b'\n').next().expect("a line")).into_owned();
        assert!(out.status.success() && header.starts_with("YUV4MPEG2 ") && header.contains(in_header), "{rate}: {header}");
    }
}
