//! Stereo pairs, domes and warps by command line: image sizes, f64 against f32, pixels of directions (`probe project`), and error messages.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

static CACHE: LazyLock<PathBuf> = LazyLock::new(crate::support::scratch::program_cache);

fn orrery(args: &[&str]) -> Output {
    let base = ["--renderer", "software", "--cache", CACHE.to_str().expect("a UTF-8 path")];
    Command::new(crate::support::program::path()).args(args).args(base).output().expect("the program starts")
}

const VIEW_ARGUMENTS: [&str; 7] = ["render", "--target", "saturn", "--time", "2017-05-17T00:00:00Z", "--size", "96x64"];

fn render(args: &[&str], to: &Path) -> Result<image::RgbaImage, String> {
    let out = orrery(&[&VIEW_ARGUMENTS[..], args, &["-o", to.to_str().expect("a UTF-8 path")]].concat());
    if out.status.success() {
        Ok(image::open(to).expect("an image").to_rgba8())
    } else {
        assert!(matches!(out.status.code(), Some(1 | 2)), "{args:?}: {:?}", out.status);
        Err(String::from_utf8_lossy(&out.stderr).trim().to_owned())
    }
}

/// Each composition has the requested size, and is the same in f64 (`--quality reference`) as in f32: the mean difference is below 0.03
/// levels of 255 (measured: at most 0.006).
#[test]
fn every_composition_is_drawn_in_both_precisions() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("mesh.data");
    // Bourke's format: mesh type 2, columns and rows, then x y u v and the brightness of each node.
    std::fs::write(&mesh, "2\n2 2\n-1.5 -1 0 0 1\n1.5 -1 1 0 1\n-1.2 1 0 1 0.5\n1.2 1 1 1 1\n").expect("written");
    let mesh = mesh.to_str().expect("a UTF-8 path");
    for (k, args) in [
        &["--stereo", "anaglyph"][..],
        &["--stereo", "side-by-side"],
        &["--stereo", "interlaced", "--eye-separation-km", "2000"],
        &["--projection", "fisheye", "--distance-radii", "2", "--dome-tilt", "30"],
        &["--projection", "equirectangular", "--distance-radii", "2"],
        &["--warp", mesh],
    ]
    .into_iter()
    .enumerate()
    {
        let path = |name: &str| folder.path().join(format!("{name}{k}.png"));
        let in_f32 = render(args, &path("f32")).expect("drawn");
        let in_f64 = render(&[args, &["--quality", "reference"]].concat(), &path("f64")).expect("drawn");
        assert_eq!((in_f32.dimensions(), in_f64.dimensions()), ((96, 64), (96, 64)), "{args:?}");
        assert!(in_f32.pixels().filter(|p| p[1] > 30).count() > 200, "{args:?} is dark");
        let difference_in_levels = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
        let mean_after =
            |bytes: usize| in_f32.iter().skip(bytes).zip(in_f64.iter()).map(difference_in_levels).sum::<f64>() / (96.0 * 64.0 * 4.0);
        let mean = mean_after(0);
        println!("{args:?}: f64 differs by {mean:.4} levels in the mean");
        assert!(mean < 0.03, "{args:?}: {mean}");
        // Negative control: the image moved by a pixel of four bytes.
        assert!(mean_after(4) > 1.0, "{args:?}: {}", mean_after(4));
    }
}

/// The image that such a screen samples would be less than half a pixel wide.
#[test]
fn a_warp_for_a_screen_one_pixel_wide_is_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, image) = (folder.path().join("quarter.data"), folder.path().join("x.png"));
    // The image is on a quarter of the screen's width and height.
    std::fs::write(&mesh, "2\n2 2\n-0.0004 -0.25 0 0 1\n0.0004 -0.25 1 0 1\n-0.0004 0.25 0 1 1\n0.0004 0.25 1 1 1\n").expect("written");
    let [mesh, image_path] = [&mesh, &image].map(|path| path.to_str().expect("a UTF-8 path"));
    let view = &VIEW_ARGUMENTS[..5];
    let out = orrery(&[view, &["--size", "1x600", "--warp", mesh, "-o", image_path]].concat());
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(image::open(&image).expect("an image").to_rgba8().dimensions(), (1, 600));
}

#[test]
fn wrong_composition_arguments_are_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("fold.data");
    // The third column (x = 0) is left of the second (x = 0.5).
    std::fs::write(&mesh, "2\n3 2\n-1 -1 0 0 1\n0.5 -1 0.5 0 1\n0 -1 1 0 1\n-1 1 0 1 1\n0.5 1 0.5 1 1\n0 1 1 1 1\n").expect("written");
    let (fold, missing) = (mesh.to_str().expect("a UTF-8 path"), folder.path().join("none.data"));
    for (args, expected_words) in [
        (&["--warp", fold][..], &["fold.data:4: the mesh folds", "row 1, column 2"][..]),
        (&["--warp", missing.to_str().expect("a UTF-8 path")], &["none.data", "--warp takes a text file"]),
        (&["--stereo", "anaglyph", "--projection", "fisheye"], &["stereo requires the perspective projection"]),
        (&["--stereo", "anaglyph", "--eye-separation-km", "-3"], &["more than 0 km"]),
        (&["--stereo", "anaglyph", "--eye-separation-km", "1e9"], &["at most"]),
        (&["--dome-tilt", "20"], &["--projection fisheye"]),
        (&["--projection", "fisheye", "--fov", "400"], &["--fov: field of view 400.0: must be 1 to 360 degrees"]),
    ] {
        let message = render(args, &folder.path().join("x.png")).expect_err("refused");
        assert!(expected_words.iter().all(|w| message.contains(w)) && message.lines().count() == 1, "{args:?}: {message}");
    }
    let exr = render(&["--stereo", "anaglyph"], &folder.path().join("x.exr")).expect_err("refused");
    assert!(exr.contains("display values"), "{exr}");
    let odd = folder.path().join("odd.png");
    let size = ["--size", "7x4", "--stereo", "side-by-side", "-o", odd.to_str().expect("a UTF-8 path")];
    let odd = orrery(&[&VIEW_ARGUMENTS[..5], &size].concat());
    let message = String::from_utf8_lossy(&odd.stderr).trim().to_owned();
    assert!(!odd.status.success() && message.contains("--size 7x4") && message.contains("even width"), "{message}");
    // The folder contains only the mesh.
    assert!(std::fs::read_dir(folder.path()).expect("a folder").count() == 1, "an image was written");
}

/// The window takes the same options: what `render` refuses, it refuses before it opens.
#[test]
fn the_window_refuses_wrong_composition_arguments_in_one_line() {
    if !crate::support::program::has_view() {
        return;
    }
    for (args, expected_words) in [
        (&["--dome-zenith"][..], "zenith requires --projection fisheye"),
        (&["--dome-tilt", "400"], "tilt requires --projection fisheye or equirectangular"),
        (&["--projection", "fisheye", "--dome-tilt", "400"], "--dome-tilt: dome tilt 400.0: must be -180 to 180 degrees"),
        (&["--projection", "fisheye", "--stereo", "anaglyph"], "stereo requires the perspective projection"),
        (&["--stereo", "anaglyph", "--eye-separation-km", "-3"], "--eye-separation-km: eye separation -3.0 km: must be more than 0 km"),
    ] {
        let out = orrery(&[&["view"][..], args].concat());
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && message.contains(expected_words), "{args:?}: {message}");
        assert!(message.trim().lines().count() == 1 && out.stdout.is_empty(), "{args:?}: {message}");
    }
}

#[test]
fn probe_project_gives_pixels_in_fisheye_and_equirectangular_images() {
    let project = |projection: &str, ra: f64, dec: f64| -> serde_json::Value {
        let question = format!(
            r#"{{"q":"project","view":{{"position":{{"body":"earth","km":[20000,0,0]}},"look":{{"direction":[0,1,0]}},"up":"celestial"}},"time":"2024-04-08T18:17:16Z","size":[400,200],"projection":"{projection}","ra_deg":{ra},"dec_deg":{dec}}}"#
        );
        let out = orrery(&["probe", &question]);
        serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{e}: {} {}", question, String::from_utf8_lossy(&out.stderr)))
    };
    let pixel = |v: &serde_json::Value| {
        let answer = v.get("ok").unwrap_or(v);
        [answer["x"].as_f64().expect("x"), answer["y"].as_f64().expect("y")]
    };
    // The centre of the view is at a right ascension of 90 degrees: 60 is 30 degrees right of it, 30 is 60 degrees right. In the fisheye
    // image 90 degrees are the circle's radius, 100 pixels. Aberration displaces a direction by at most 0.006 degrees, which are 0.007 pixels.
    let [x, y] = pixel(&project("equirectangular", 60.0, 45.0));
    assert!((x - (200.0 + 30.0 / 360.0 * 400.0)).abs() < 0.01 && (y - (100.0 - 45.0 / 180.0 * 200.0)).abs() < 0.01, "{x} {y}");
    let [x, y] = pixel(&project("fisheye", 30.0, 0.0));
    assert!((x - (200.0 + 60.0 / 90.0 * 100.0)).abs() < 0.01 && (y - 100.0).abs() < 0.01, "{x} {y}");
}

/// One line on standard error; none without the layer, and none for an image that has the outline.
#[test]
fn a_dome_image_says_that_it_has_no_outline() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("x.png");
    let view =
        ["render", "--target", "saturn", "--time", "2017-05-17T00:00:00Z", "--size", "32x32", "-o", image.to_str().expect("a UTF-8 path")];
    for (args, is_said) in [
        (&["--projection", "fisheye", "--layers", "+outline"][..], true),
        (&["--projection", "equirectangular", "--layers", "+outline"], true),
        (&["--projection", "fisheye"], false),
        (&["--layers", "+outline"], false),
    ] {
        let out = orrery(&[&view[..], args, &["--overwrite"]].concat());
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success() && message.contains("have no outline") == is_said, "{args:?}: {message}");
        assert!(message.trim().lines().count() == usize::from(is_said), "{args:?}: {message}");
    }
}

/// Every wrong size is a wrong argument; that of a stereo pair counted as a failure.
#[test]
fn a_stereo_pair_that_is_too_narrow_is_a_wrong_argument() {
    let folder = tempfile::tempdir().expect("a folder");
    for (layout, size, message_part) in
        [("anaglyph", "1x512", "at least 2 pixels wide for each eye"), ("side-by-side", "1x512", "--size: size 1x512: must be at least 2")]
    {
        let image = folder.path().join("x.png");
        let view = [
            "render",
            "--target",
            "saturn",
            "--time",
            "2024-12-07T20:00:00Z",
            "-o",
            super::path_text(&image),
            "--overwrite",
            "--stereo",
            layout,
            "--size",
        ];
        let out = orrery(&[&view[..], &[size]].concat());
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && message.contains(message_part), "{layout}: {message}");
        // Negative control.
        assert!(orrery(&[&view[..], &["4x4"]].concat()).status.success(), "{layout}");
    }
}
