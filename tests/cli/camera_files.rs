//! Camera files: each error names the file, and the line or the field.

use super::{orrery, path_text, stderr_text};

/// These errors had neither file nor field.
#[test]
fn errors_in_the_values_of_a_camera_file_name_file_and_field() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("camera.json");
    for (camera, message_part) in [
        (r#"{"position": {"body": "mrs", "radii": [3,0,0]}, "look": {"at": "mars"}}"#, "camera.json: position.body: no body"),
        (r#"{"position": {"body": "mars", "radii": [3,0,0]}, "look": {"at": "mrs"}}"#, "camera.json: look.at: no body"),
        (r#"{"position": {"body": "mars"}, "look": {"at": "mars"}}"#, "camera.json: position: give one of"),
        (
            r#"{"position": {"body": "mars", "radii": [3,0,0]}, "look": {"direction": [0,0,0]}}"#,
            "camera.json: look: the direction must not be zero",
        ),
        (
            r#"{"position": {"body": "mars", "radii": [3,0,0]}, "look": {"at": "mars"}, "fov_deg": 400}"#,
            "camera.json: fov_deg: field of view 400.0: must be 0.0000001 to 170 degrees",
        ),
        (
            r#"{"position": {"body": "mars", "latitude_deg": 91, "longitude_deg": 0}, "look": {"at": "sun"}}"#,
            "camera.json: position.latitude_deg: latitude 91.0: must be -90 to 90 degrees",
        ),
        (
            r#"{"position": {"body": "mars", "latitude_deg": 0, "longitude_deg": 400}, "look": {"at": "sun"}}"#,
            "camera.json: position.longitude_deg: longitude 400.0: ",
        ),
        (
            r#"{"position": {"body": "mars", "latitude_deg": 0, "longitude_deg": 0, "height_km": -1}, "look": {"at": "sun"}}"#,
            "camera.json: position.height_km: height -1.0 km: ",
        ),
        (r#"{"position": {"body": "mars", "radii": [1e308,0,0]}, "look": {"at": "mars"}}"#, "camera.json: position.radii: camera offset "),
    ] {
        std::fs::write(&file, camera).expect("written");
        let out = orrery(&["explain", "--camera-json", path_text(&file)]);
        assert!(out.status.code() == Some(1) && stderr_text(&out).contains(message_part), "{camera}: {}", stderr_text(&out));
    }
    // An option is named in place of the file that it overrides.
    let camera = r#"{"position": {"body": "mars", "radii": [3,0,0]}, "look": {"at": "mars"}, "fov_deg": 40}"#;
    std::fs::write(&file, camera).expect("written");
    for (options, message_part) in
        [(["--fov", "400"], "orrery: --fov: field of view 400.0"), (["--exposure", "99"], "--exposure: exposure 99.0")]
    {
        let out = orrery(&[&["explain", "--camera-json", path_text(&file)][..], &options].concat());
        assert!(out.status.code() == Some(2) && stderr_text(&out).contains(message_part), "{options:?}: {}", stderr_text(&out));
    }
    let stdin = orrery(&["explain", "--camera-json", "-"]);
    assert!(stdin.status.code() == Some(2) && stderr_text(&stdin).contains("--camera-json -: "), "{}", stderr_text(&stdin));
}

#[test]
fn errors_in_camera_files_name_the_line_in_plain_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("camera.json");
    for (camera, line_number, message_part) in [
        ("[]", 1, "expected an object {\"position\""),
        ("3", 1, "expected an object {\"position\""),
        ("\n\n\"a\"", 3, "expected an object {\"position\""),
        ("{}", 1, "position"),
        ("{\"position\": [],\n \"look\": {\"at\": \"mars\"}}", 1, "expected an object {\"body\""),
        ("{\"position\": {\"body\": \"mars\", \"radii\": [3,0,0]},\n\"look\": []}", 2, "expected an object {\"at\""),
        ("{\"position\": {\"body\": \"mars\", \"radii\": [3,0]},\n\"look\": {\"at\": \"mars\"}}", 1, "a list of 3 values"),
        ("{\"position\": {\"body\": \"mars\",\n\"radii\": [3,0,\"a\"]},\"look\": {\"at\": \"mars\"}}", 2, "expected a number"),
        ("{\"position\": {\"body\": \"mars\",\n\n\"radius\": 3},\"look\": {\"at\": \"mars\"}}", 3, "radius"),
        ("{\"position\":", 1, "EOF"),
        ("", 1, "EOF"),
    ] {
        std::fs::write(&file, camera).expect("written");
        let out = orrery(&["explain", "--camera-json", path_text(&file)]);
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(1) && line.trim().lines().count() == 1, "{camera:?}: {line}");
        assert!(line.contains(&format!("camera.json:{line_number}:")) && line.contains(message_part), "{camera:?}: {line}");
        assert!(!line.contains("struct ") && !line.contains("sequence") && !line.contains("f64"), "{camera:?}: {line}");
    }
}

/// A zero offset was refused, with the advice to move exactly to the centre.
#[test]
fn a_camera_at_an_offset_of_zero_is_at_the_centre() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("camera.json");
    let moon = |args: &[&str]| {
        let out = orrery(&[&["explain", "--json", "--time", "2024-04-08T18:00:00Z"][..], args].concat());
        assert!(out.status.success(), "{args:?}: {}", stderr_text(&out));
        let found: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
        let bodies = found["bodies"].as_array().expect("bodies").clone();
        let moon = bodies.into_iter().find(|b| b["name"] == "Moon").expect("in the image");
        ["distance_km", "diameter_px", "phase_angle_deg"].map(|field| moon[field].as_f64().expect("a number"))
    };
    let expected = moon(&["--target", "moon", "--from", "earth", "--fov", "30"]);
    for position in [r#""km": [0,0,0]"#, r#""radii": [0,0,0]"#, r#""km": [0,-0.0,0], "axes": "body-fixed""#] {
        let camera = format!(r#"{{"position": {{"body": "earth", {position}}}, "look": {{"at": "moon"}}, "fov_deg": 30}}"#);
        std::fs::write(&file, &camera).expect("written");
        assert_eq!(moon(&["--camera-json", path_text(&file)]), expected, "{camera}");
    }
    // Negative control: beside the centre the camera is inside the Earth.
    std::fs::write(&file, r#"{"position": {"body": "earth", "km": [1,0,0]}, "look": {"at": "moon"}}"#).expect("written");
    let out = orrery(&["explain", "--camera-json", path_text(&file)]);
    assert!(out.status.code() == Some(1) && stderr_text(&out).contains("inside Earth"), "{}", stderr_text(&out));
}

/// In a query the camera file is the field `view`. A value outside its range had no field.
#[test]
fn errors_in_the_view_of_a_query_name_its_field() {
    let look = r#""look":{"at":"mars"}"#;
    let position = r#""position":{"body":"mars","radii":[3,0,0]}"#;
    for (view, size, message_part) in [
        (format!(r#"{{{position},{look},"fov_deg":400}}"#), "[8,8]", "field `view.fov_deg`: field of view 400.0: must be "),
        (format!(r#"{{"position":{{"body":"mrs","radii":[3,0,0]}},{look}}}"#), "[8,8]", "field `view.position.body`: no body"),
        (
            format!(r#"{{"position":{{"body":"mars","latitude_deg":91,"longitude_deg":0}},{look}}}"#),
            "[8,8]",
            "field `view.position.latitude_deg`: latitude 91.0: ",
        ),
        (format!(r#"{{{position},{look},"up":"sideways"}}"#), "[8,8]", "field `view`: up `sideways`: "),
        (format!("{{{position},{look}}}"), "[0,8]", "field `size`: "),
    ] {
        let query = format!(r#"{{"q":"pixel","view":{view},"time":"2024-01-01","size":{size},"x":0,"y":0}}"#);
        let out = orrery(&["probe", &query]);
        assert!(!out.status.success() && stderr_text(&out).contains(message_part), "{query}: {}", stderr_text(&out));
    }
}
