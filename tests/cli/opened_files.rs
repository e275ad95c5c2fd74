//! Files that `orrery view` opens, without a display: which message is about the file.

use super::stderr_text;
use std::process::Command;

/// The argument of `view` may be a file of data. It was read as the text of a view: "2 errors: features: no such field; ...".
#[test]
fn a_data_file_of_view_gets_an_error_about_its_data() {
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let invalid: [(&str, &[u8], &str); 3] = [
        ("wrong.csv", b"lat,lon\n95,140\n", "wrong.csv:2: field lat_deg: `95`"),
        ("map.png", b"\x89PNG", "map.png: not a data layer: its name does not end in any of .csv"),
        ("tour.json", br#"{"title":"T","stops":[]}"#, "tour.json: a tour has at least one stop"),
    ];
    let lines_of = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("written");
        let mut command = Command::new(crate::support::program::path());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.args(["--renderer", "software", "--cache"]).arg(folder.path()).arg("view").arg(&path);
        stderr_text(&command.output().expect("starts"))
    };
    for (name, content, message_part) in invalid {
        // A second line reports that there is no display.
        let lines = lines_of(name, content);
        assert!(lines.contains(message_part) && lines.lines().count() == 2 && !lines.contains("orrery://"), "{lines}");
    }
    let lines = lines_of("own.geojson", br#"{"type":"Point","coordinates":[10,20]}"#);
    assert!(lines.lines().count() == 1 && !lines.contains("own.geojson"), "{lines}");
}
