//! `orrery eclipse find` with `--lunar-heights`: contacts by the Moon's limb profile, and errors for invalid files.

use crate::support::sweep;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Searches for the eclipse of 2024-04-08. `heights`: the value of `--lunar-heights`. `folder`: the cache.
fn find(folder: &Path, heights: &str, output_args: &[&str]) -> Output {
    let mut command = Command::new(crate::support::program::path());
    command.arg("--cache").arg(folder).args(["--lunar-heights", heights]);
    command.args(["eclipse", "find", "--from", "2024-04-08", "--to", "2024-04-09", "--kind", "solar", "--at", "32.78,-96.80"]);
    command.args(output_args).output().expect("starts")
}

/// Writes a file, and returns its path.
fn write_file(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("a file");
    path.to_str().expect("a plain name").to_owned()
}

fn grey_png(depth: png::BitDepth, width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    encoder.write_header().and_then(|mut w| w.write_image_data(data)).expect("a PNG");
    bytes
}

/// With heights of zero the contacts are those of the mean limb, and the map's resolution is stated. The heights are given as PNG of 16 and 8
/// bits, and as a PDS image by the name of its label or of the image.
#[test]
fn limb_profile_contacts_are_listed_beside_mean_limb_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    // A value of a 16-bit PNG is the height above -10 km in half metres. An 8-bit PNG needs the heights of black and white: 51 of 255 is zero
    // if black is -2 km and white is 8 km.
    let zero_heights: Vec<u8> = 20_000_u16.to_be_bytes().repeat(72 * 36);
    let sixteen_bit = write_file(folder.path(), "sixteen.png", &grey_png(png::BitDepth::Sixteen, 72, 36, &zero_heights));
    let eight_bit = write_file(folder.path(), "eight.png", &grey_png(png::BitDepth::Eight, 72, 36, &[51; 72 * 36]));
    write_file(folder.path(), "ldem.img", &[0; 72 * 36 * 2]);
    let label = "^IMAGE = \"LDEM.IMG\"\nLINES = 36\nLINE_SAMPLES = 72\nSAMPLE_TYPE = LSB_INTEGER\nSAMPLE_BITS = 16\n\
                 UNIT = METER\nSCALING_FACTOR = 0.5\nOFFSET = 1737400.\n";
    let label = write_file(folder.path(), "ldem.lbl", label.as_bytes());
    let image = folder.path().join("ldem.img");
    let formats = [sixteen_bit, format!("{eight_bit},-2,8"), label, image.to_str().expect("a plain name").to_owned()];
    for (_, heights) in formats.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 4)) {
        let out = find(folder.path(), &heights, &["--json"]);
        assert!(out.status.success(), "{heights}: {}", String::from_utf8_lossy(&out.stderr));
        let rows: Value = serde_json::from_slice(&out.stdout).expect("JSON");
        let limb = &rows[0]["local"]["limb"];
        for name in ["C1", "C2", "C3", "C4"] {
            let later_s = limb["contacts"][name]["later_s"].as_f64().unwrap_or_else(|| panic!("{heights}: {limb}"));
            assert!(later_s.abs() < 0.005, "{heights} {name}: {later_s}");
        }
        assert_eq!(limb["last_bead"], limb["contacts"]["C2"]["time"]);
        assert_eq!(limb["first_bead"], limb["contacts"]["C3"]["time"]);
        assert!(limb["heights"].as_str().is_some_and(|h| h.starts_with("0.2000 heights a degree (151.62 km")), "{limb}");
    }
    // At heights of 1 km, 0.5 arcsec, totality begins and ends more than a second from the contacts of the mean limb.
    let one_kilometre = format!("{eight_bit},-1,9");
    let rows: Value = serde_json::from_slice(&find(folder.path(), &one_kilometre, &["--json"]).stdout).expect("JSON");
    let later_s = |name: &str| rows[0]["local"]["limb"]["contacts"][name]["later_s"].as_f64().expect("seconds");
    assert!(later_s("C2") < -1.0 && later_s("C3") > 1.0, "{} {}", later_s("C2"), later_s("C3"));
    // The text lists contacts, beads and the range of heights.
    let out = find(folder.path(), &one_kilometre, &[]);
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(
        text.contains("by the Moon's own limb: C1 ") && text.contains("C2, last bead, ") && text.contains("from 1.00 to 1.00 km"),
        "{text}"
    );
}

#[test]
fn invalid_height_maps_are_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let eight_bit = write_file(folder.path(), "eight.png", &grey_png(png::BitDepth::Eight, 8, 4, &[0; 32]));
    let square = write_file(folder.path(), "square.png", &grey_png(png::BitDepth::Eight, 4, 4, &[0; 16]));
    let text = write_file(folder.path(), "heights.txt", b"1 2 3");
    let without_label = write_file(folder.path(), "lonely.img", &[0; 64]);
    let outside_folder = write_file(folder.path(), "climbing.lbl", b"^IMAGE = \"../x.img\"");
    let missing = folder.path().join("none.png");
    for (heights, message_part) in [
        (eight_bit.as_str(), "FILE,-9.15,10.76"),
        (&format!("{eight_bit},8,-2"), "below that of white"),
        (&format!("{eight_bit},-900,10"), "row 1, column 1: a height of -900 km"),
        (&format!("{square},0,1"), "twice as wide as high"),
        (&text, "neither PNG nor TIFF"),
        (&without_label, "the image's label"),
        (&outside_folder, "must be in the same folder as its label"),
        (missing.to_str().expect("a plain name"), "No such file"),
    ] {
        let out = find(folder.path(), heights, &[]);
        let stderr_text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(1), "{heights}: {stderr_text}");
        assert!(
            stderr_text.contains(message_part) && stderr_text.contains("--lunar-heights") && stderr_text.trim_end().lines().count() == 1,
            "{heights}: {stderr_text}"
        );
    }
}
