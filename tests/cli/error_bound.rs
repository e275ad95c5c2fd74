//! `render --error` and `compare --error`: in nearly every pixel the difference from reference quality is within the pixel's error bound. With the bounds of
//! another view it is not.

use crate::support::sweep;
use std::path::Path;
use std::process::{Command, Output};

fn orrery(folder: &Path, args: &[&str]) -> Output {
    Command::new(crate::support::program::path())
        .current_dir(folder)
        .env_remove("XDG_RUNTIME_DIR")
        .args(args)
        .args(["--renderer", "software", "--cache", "cache"])
        .output()
        .expect("the program starts")
}

fn run_successfully(folder: &Path, args: &[&str]) -> Output {
    let out = orrery(folder, args);
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    out
}

/// Views with atmospheres, clouds, rings, an eclipse, craters.
const VIEWS: [(&str, &[&str]); 5] = [
    ("earth", &["--target", "earth", "--time", "2024-04-08T18:17:16Z", "--distance-radii", "3"]),
    ("saturn", &["--target", "saturn", "--time", "2017-05-17T00:00:00Z"]),
    ("moon", &["--target", "moon", "--time", "2022-11-08T09:45:00Z"]),
    ("jupiter", &["--target", "jupiter", "--time", "2015-01-24T06:45:00Z", "--distance-radii", "40", "--fov", "4"]),
    ("mars", &["--target", "mars", "--time", "2024-04-08T18:17:16Z", "--distance-radii", "1.2"]),
];

/// Limits of the mean of an image's bounds at two qualities, in levels of 255: larger bounds would hold, but say nothing.
const MAX_MEAN_BOUND_OF_STANDARD: f64 = 16.0;
const MAX_MEAN_BOUND_OF_DRAFT: f64 = 40.0;

#[test]
fn the_bound_holds_in_nearly_every_pixel_at_every_quality() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let mut pixel_count = 0.0;
    let mut pixels_beyond_bound = 0.0;
    // The negative control at the end needs the first two views.
    for (name, view) in VIEWS.into_iter().take(if sweep::in_full() { VIEWS.len() } else { 2 }) {
        let exposure_stops = {
            let out = run_successfully(path, &[&["explain", "--size", "160x160", "--json"][..], view].concat());
            let explained: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
            explained["exposure"]["stops"].as_f64().expect("stops").to_string()
        };
        let render_args = [&["render", "--size", "160x160"][..], view, &["--exposure", &exposure_stops]].concat();
        let reference = format!("{name}-reference.png");
        run_successfully(path, &[&render_args[..], &["--quality", "reference", "-o", &reference]].concat());
        for quality in ["draft", "standard"] {
            let (image, bound) = (format!("{name}-{quality}.png"), format!("{name}-{quality}-bound.png"));
            run_successfully(path, &[&render_args[..], &["--quality", quality, "-o", &image, "--error", &bound]].concat());
            let out = run_successfully(path, &["compare", &image, &reference, "--error", &bound, "--json"]);
            let compared: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
            let held_fraction = compared["bound_held"].as_f64().expect("a fraction");
            let mean_bound = {
                let image = image::open(path.join(&bound)).expect("a bound").to_rgb8();
                image.pixels().map(|p| f64::from(*p.0.iter().max().expect("three"))).sum::<f64>()
                    / f64::from(image.width() * image.height())
            };
            println!("{name} {quality}: held in {:.4} % of pixels, mean bound {mean_bound:.2} levels, {compared}", 100.0 * held_fraction);
            pixel_count += 160.0 * 160.0;
            pixels_beyond_bound += (1.0 - held_fraction) * 160.0 * 160.0;
            let max_mean = if quality == "standard" { MAX_MEAN_BOUND_OF_STANDARD } else { MAX_MEAN_BOUND_OF_DRAFT };
            assert!(mean_bound < max_mean, "{name} {quality}: a mean bound of {mean_bound} levels is too loose");
        }
    }
    assert!(pixels_beyond_bound <= 1e-4 * pixel_count, "the bound fails in {pixels_beyond_bound} of {pixel_count} pixels");
    // Negative control: the draft of the Earth with the bound of Saturn.
    let out =
        run_successfully(path, &["compare", "earth-draft.png", "earth-reference.png", "--error", "saturn-standard-bound.png", "--json"]);
    let compared: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert!(compared["bound_held"].as_f64().expect("a fraction") < 0.99, "{compared}");
}

#[test]
fn linear_bounds_are_written_and_foreign_or_unsupported_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let args = ["render", "--target", "moon", "--time", "2024-04-23T23:49:00Z", "--size", "24x24", "-o", "moon.png"];
    run_successfully(path, &[&args[..], &["--error", "bound.exr", "--error", "bound.png"]].concat());
    let linear = image::open(path.join("bound.exr")).expect("a bound").to_rgb32f();
    assert!(linear.pixels().all(|p| p.0.iter().all(|v| v.is_finite() && *v >= 0.0)) && linear.pixels().any(|p| p.0[1] > 0.0));
    // The same command again is accepted; the bound of another view is not overwritten.
    run_successfully(path, &[&args[..], &["--error", "bound.png"]].concat());
    let other =
        ["render", "--target", "mars", "--time", "2024-04-23T23:49:00Z", "--size", "24x24", "-o", "mars.png", "--error", "bound.png"];
    let out = orrery(path, &other);
    assert!(out.status.code() == Some(1) && !path.join("mars.png").exists(), "{}", String::from_utf8_lossy(&out.stderr));
    for (extra_options, message_part) in
        [(&["--error", "bound.gif"][..], ".png or .exr"), (&["--error", "b.png", "--frames", "2"], "one frame")]
    {
        let args = ["render", "--target", "moon", "--time", "2024-04-23T23:49:00Z", "-o", "run-%d.png"];
        let out = orrery(path, &[&args[..], extra_options].concat());
        let stderr_text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && stderr_text.contains(message_part), "{stderr_text}");
    }
}

/// An image never replaces a bound, nor a bound an image, unless `--overwrite` is given. Images without linear light have no bound, which is reported before
/// anything is drawn.
#[test]
fn a_bound_never_takes_the_place_of_an_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let args = ["render", "--target", "moon", "--time", "2024-04-23T23:49:00Z", "--size", "24x24", "--quality", "draft"];
    run_successfully(path, &[&args[..], &["-o", "moon.png", "--error", "bound.png"]].concat());
    let before = ["moon.png", "bound.png"].map(|name| std::fs::read(path.join(name)).expect("written"));
    for (extra_options, message_part) in [
        (&["-o", "moon.png", "--error", "./moon.png"][..], "-o writes the image"),
        (&["-o", "new.png", "--error", "new.png", "--overwrite"], "-o writes the image"),
        (&["-o", "new.png", "--error", "moon.png"], "content none, not bound of the error"),
        (&["-o", "bound.png"], "content bound of the error, not none"),
        (&["-o", "new.png", "--error", "new-bound.png", "--stereo", "anaglyph"], "no bound of the error"),
    ] {
        let out = orrery(path, &[&args[..], extra_options].concat());
        let stderr_text = String::from_utf8_lossy(&out.stderr).into_owned();
        let code = if message_part.starts_with("content ") { 1 } else { 2 };
        assert!(out.status.code() == Some(code) && stderr_text.contains(message_part), "{extra_options:?}: {stderr_text}");
        assert!(!path.join("new.png").exists() && !path.join("new-bound.png").exists(), "{extra_options:?}");
    }
    let contents = || ["moon.png", "bound.png"].map(|name| std::fs::read(path.join(name)).expect("there"));
    assert_eq!(before, contents());
    // With `--overwrite` a file of the other kind is replaced, here each by the other's content.
    let [image, bound] = &before;
    assert_ne!(image, bound);
    run_successfully(path, &[&args[..], &["-o", "new.png", "--error", "moon.png", "--overwrite"]].concat());
    assert_eq!([bound, bound], contents().each_ref(), "a bound in place of the image");
    run_successfully(path, &[&args[..], &["-o", "bound.png", "--overwrite"]].concat());
    assert_eq!([bound, image], contents().each_ref(), "an image in place of the bound");
}

/// In reference quality most of the bound comes from the stated errors of the models of atmosphere and eclipse. In the middle of a fisheye image, which is
/// drawn in frames of its own, the same view has the same models, so about the same bound. Bounds are whole levels.
#[test]
fn the_bound_of_a_fisheye_image_includes_atmosphere_and_eclipse() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let args = ["render", "--target", "earth", "--time", "2024-04-08T18:17:16Z", "--size", "65x65", "--fov", "30", "--exposure", "0"];
    let args = [&args[..], &["--quality", "reference"]].concat();
    run_successfully(path, &[&args[..], &["-o", "plain.png", "--error", "plain-bound.png"]].concat());
    run_successfully(path, &[&args[..], &["--projection", "fisheye", "-o", "fisheye.png", "--error", "fisheye-bound.png"]].concat());
    // Mean bound of the 7 x 7 pixels in the middle of the image.
    let middle_bound = |name: &str| {
        let image = image::open(path.join(name)).expect("a bound").to_rgb8();
        (29..36).flat_map(|y| (29..36).map(move |x| (x, y))).map(|(x, y)| f64::from(image.get_pixel(x, y).0[1])).sum::<f64>() / 49.0
    };
    let (plain, fisheye) = (middle_bound("plain-bound.png"), middle_bound("fisheye-bound.png"));
    assert!(plain > 3.5 && (fisheye - plain).abs() < 1.5, "{plain} and {fisheye} levels");
}
