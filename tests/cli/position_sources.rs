//! The program refuses catalogs with bodies for which it has no source of position or rotation. Every shipped body has both.

use super::{orrery, path_text, stderr_text};

/// The error names file, line and field.
#[test]
fn a_body_without_a_source_of_its_position_or_rotation_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mine.toml");
    let body = |id: i32, name: &str, parent_line: &str, motion: &str, rotation: &str| {
        format!(
            "[[body]]\nid = {id}\nname = \"{name}\"\nkind = \"asteroid\"\n{parent_line}radii_km = [10, 9, 8]\ngeometric_albedo = 0.1\n\
             colour_linear_srgb = [1, 1, 1]\nphotometry = {{ model = \"lambert\" }}\nmotion = {motion}\nrotation = {rotation}\n"
        )
    };
    let orbit = "{ theory = \"mean-elements\", pole_ra_deg = 270, pole_dec_deg = 66.5, epoch_jd_tt = 2451545, semi_major_axis_km = 4e8, \
                 eccentricity = 0.1, inclination_deg = 5, node_deg = 1, argument_of_periapsis_deg = 2, mean_anomaly_deg = 3, \
                 mean_motion_deg_day = 0.2, node_period_yr = 0, argument_period_yr = 0 }";
    let (planetary, pck, synchronous) = ("{ theory = \"planetary\" }", "{ model = \"pck\" }", "{ model = \"synchronous\" }");
    let fixed = "{ model = \"fixed\", pole_ra_deg = 0, pole_dec_deg = 90, w0_deg = 0, w_deg_day = 400 }";
    let sun = "parent = \"Sun\"\n";
    let valid = body(2_009_999, "Testa", sun, orbit, fixed);
    // Catalogs, each with line and field of the expected error, if any.
    let cases = [
        (valid.clone(), None),
        (body(2_009_999, "Testa", sun, orbit, synchronous), None),
        (body(2_009_999, "Testa", sun, orbit, pck), Some((11, "Testa.rotation"))),
        (body(2_009_999, "Testa", sun, planetary, fixed), Some((10, "Testa.motion"))),
        (format!("{}{}", valid, body(2_009_998, "Moonlet", "parent = \"Testa\"\n", orbit, pck)), Some((22, "Moonlet.rotation"))),
        (
            format!(
                "{}{}",
                body(2_009_999, "Testa", "parent = \"Testb\"\n", orbit, fixed),
                body(2_009_998, "Testb", "parent = \"Testa\"\n", orbit, fixed)
            ),
            Some((5, "Testa.parent")),
        ),
        // Six orbits below Jupiter, whose centre is three links from the solar system's barycentre: the sixth is one too many. A body has 11 lines.
        (
            ["Jupiter", "Testa", "Testb", "Testc", "Testd", "Teste", "Testf"]
                .windows(2)
                .zip(2_009_990..)
                .map(|(pair, id)| body(id, pair[1], &format!("parent = \"{}\"\n", pair[0]), orbit, fixed))
                .collect(),
            Some((5 * 11 + 5, "Testf.parent")),
        ),
        // Shipped bodies whose rotation is replaced: the text kernel has those of the Earth and Proteus, but not that of Nereid.
        ("[[body]]\nid = 399\nrotation = { model = \"pck\" }\n".into(), None),
        (
            "\n[[body]]\nid = 808\nrotation = { model = \"pck\" }\n[[body]]\nid = 802\nrotation = { model = \"pck\" }\n".into(),
            Some((7, "Nereid.rotation")),
        ),
    ];
    for (catalog, expected_error) in cases {
        std::fs::write(&file, &catalog).expect("written");
        let commands: [&[&str]; 4] = [
            &["explain", "--target", "earth", "--time", "2024-04-08"],
            &["ephemeris", "--body", "moon", "--center", "earth", "--time", "2024-04-08"],
            &["shader", "keys", "--for", "earth", "--time", "2024-04-08"],
            &["probe", r#"{"q":"disc-overlap","k":1,"d":1}"#],
        ];
        for command in commands {
            let out = orrery(&[command, &["--catalogs", path_text(folder.path())]].concat());
            let line = stderr_text(&out);
            match expected_error {
                None => assert!(out.status.success(), "{catalog}: {line}"),
                Some((error_line, field)) => {
                    assert!(
                        out.status.code() == Some(1) && line.contains(&format!("mine.toml:{error_line}: {field}")),
                        "{catalog}: {line}"
                    );
                    // The error says what to write instead, or that the parents are a cycle.
                    assert!(line.contains("write") || line.contains("is a cycle"), "{line}");
                }
            }
        }
        if expected_error.is_none() && catalog.contains("Testa") {
            let out = orrery(&["explain", "--target", "testa", "--time", "2024-04-08", "--catalogs", path_text(folder.path())]);
            assert!(out.status.success(), "a body that loads must be drawn: {}", stderr_text(&out));
        }
    }
}

#[test]
fn every_shipped_body_has_a_position_source() {
    let catalog = orrery::catalog::Catalog::embedded();
    let ephemeris = orrery::ephemeris::Ephemeris::embedded(&catalog).expect("the shipped kernel");
    assert_eq!(ephemeris.unsupported_fields(&catalog), Vec::new());
}

/// Io has no kernel and Ceres no series: another source answers, which is not silent. Negative control: the Moon has all three.
#[test]
fn a_source_that_a_body_lacks_is_reported() {
    let stderr_for = |body: &str, source: &str| {
        let out = orrery(&["ephemeris", "--body", body, "--center", "sun", "--time", "2024-04-08", "--source", source]);
        assert!(out.status.success(), "{}", stderr_text(&out));
        stderr_text(&out)
    };
    for (body, source, used) in [("io", "kernel", "series"), ("ceres", "series", "mean")] {
        let line = stderr_for(body, source);
        assert!(line.starts_with(&format!("orrery: --source {source}: ")) && line.ends_with(&format!("{used}\n")), "{line}");
    }
    for source in ["mean", "series", "kernel"] {
        assert_eq!(stderr_for("moon", source), "", "{source}");
    }
}
