//! The shipped catalog is valid and agrees with its sources; invalid user files give exactly the expected error lines.

use orrery::catalog::{BodyKind, Catalog, MapLatitude, Motion, NaifId, Photometry, Ring};

/// The problems of a user's file `mine.toml` with this text.
pub(super) fn problems(text: &str) -> Vec<String> {
    match Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]) {
        Ok(_) => Vec::new(),
        Err(e) => e.problems.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn the_shipped_catalog_is_valid() {
    let catalog = Catalog::embedded();
    let count = |k| catalog.bodies().iter().filter(|b| b.kind == k).count();
    assert_eq!((count(BodyKind::Star), count(BodyKind::Planet), count(BodyKind::DwarfPlanet), count(BodyKind::Asteroid)), (1, 8, 2, 1));
    assert!(count(BodyKind::Moon) >= 40);
    for b in catalog.bodies() {
        assert!(b.radii_km.x >= b.radii_km.z, "{}: the pole is the short axis", b.name);
        let y = 0.2126 * b.colour.x + 0.7152 * b.colour.y + 0.0722 * b.colour.z;
        assert!((y - 1.0).abs() < 1e-5, "{}: colour has luminance {y}", b.name);
        assert!(!b.sources.is_empty(), "{} names no source", b.name);
        if let Motion::MeanElements(e) = &b.motion {
            assert!(e.semi_major_axis_km > b.radii_km.x, "{}", b.name);
            let gm_km3_s2 = b.parent.and_then(|p| catalog.body(p)).and_then(|p| p.gm_km3_s2).unwrap() + b.gm_km3_s2.unwrap_or(0.0);
            // Kepler's third law; the primary's oblateness changes the mean motion of the small inner moons by up to 2 percent.
            let deg_per_day = (gm_km3_s2 / e.semi_major_axis_km.powi(3)).sqrt().to_degrees() * 86_400.0;
            assert!(
                (deg_per_day / e.mean_motion_deg_day - 1.0).abs() < 0.02,
                "{}: {deg_per_day} against {}",
                b.name,
                e.mean_motion_deg_day
            );
        }
    }
    let mars = catalog.body(NaifId(499)).unwrap();
    assert!(mars.colour.x > mars.colour.y && mars.colour.y > mars.colour.z);
    assert!(matches!(mars.photometry, Photometry::OrenNayar { .. }));
    assert_eq!(mars.maps.albedo.as_ref().unwrap().latitude, MapLatitude::Planetographic);
    assert_eq!(catalog.body(NaifId(801)).unwrap().parent, Some(NaifId(899)));
    assert!(!catalog.body(NaifId(699)).unwrap().rings.is_empty());
    assert!(catalog.body(NaifId::EARTH).unwrap().atmosphere.as_ref().unwrap().species.len() == 3);
}

/// Irwin et al. 2024: Uranus and Neptune have nearly the same pale greenish blue; Neptune is slightly bluer.
#[test]
fn neptune_is_pale_and_close_to_uranus() {
    let catalog = Catalog::embedded();
    let (uranus, neptune) = (catalog.body(NaifId(799)).unwrap().colour, catalog.body(NaifId(899)).unwrap().colour);
    assert!((uranus - neptune).length() < 0.15 && neptune.z > uranus.z && neptune.z / neptune.x < 2.0, "{uranus} {neptune}");
}

#[test]
fn planets_have_their_moons_and_moons_their_planet() {
    let catalog = Catalog::embedded();
    let moons = |planet: i32| catalog.moons_of(NaifId(planet)).map(|moon| moon.name.as_str()).collect::<Vec<_>>();
    assert_eq!(moons(499), ["Phobos", "Deimos"]);
    assert_eq!(moons(999), ["Charon"]);
    // The Sun's planets are not moons.
    for without_moons in [10, 199, 301, 12345] {
        assert!(moons(without_moons).is_empty(), "{without_moons}");
    }
    for (body, planet) in [(301, 399), (606, 699), (901, 999), (699, 699), (999, 999), (10, 10), (12345, 12345)] {
        assert_eq!(catalog.planet_of(NaifId(body)), NaifId(planet), "{body}");
    }
}

#[test]
fn bodies_and_barycenters_are_found_by_name() {
    let catalog = Catalog::embedded();
    for (name, id) in [
        ("moon", 301),
        ("SATURN", 699),
        ("Luna", 301),
        ("mars barycenter", 4),
        ("Mars Barycentre", 4),
        ("earth-moon barycenter", 3),
        ("solar system barycenter", 0),
        ("ssb", 0),
        ("pluto barycenter", 9),
        ("ceres", 2_000_001),
    ] {
        assert_eq!(catalog.find_body_or_barycenter(name), Some(NaifId(id)), "{name}");
    }
    for name in ["", "vulcan", "io barycenter", "sun barycenter"] {
        assert_eq!(catalog.find_body_or_barycenter(name), None, "{name}");
    }
    for b in catalog.bodies() {
        assert_eq!(catalog.find_body_or_barycenter(&b.name), Some(b.id));
    }
}

#[test]
fn every_wrong_field_is_named() {
    let text = "[[body]]\nid = 499\ngeometric_albedo = -0.2\nradii_kn = [1.0, 2.0, 3.0]\nkind = \"plant\"\nphotometry = { model = \"oren-nayar\", roughness_deg = 90 }\n";
    assert_eq!(
        problems(text),
        [
            "mine.toml:3: Mars.geometric_albedo = -0.2: expected a number from 0 to 2",
            "mine.toml:4: Mars.radii_kn is not a field here: did you mean `radii_km`?",
            "mine.toml:5: Mars.kind = \"plant\": expected one of \"star\", \"planet\", \"dwarf-planet\", \"moon\", \"asteroid\"",
            "mine.toml:6: Mars.photometry.roughness_deg = 90: expected degrees from 0 to 60",
        ]
    );
}

#[test]
fn a_new_body_needs_all_fields() {
    let found = problems("# mine\n[[body]]\nid = 2000433\nname = \"Eros\"\nparent = \"Sunn\"\n");
    assert_eq!(
        found,
        [
            "mine.toml:2: Eros.colour_linear_srgb is missing",
            "mine.toml:2: Eros.geometric_albedo is missing",
            "mine.toml:2: Eros.kind is missing",
            "mine.toml:2: Eros.motion is missing",
            "mine.toml:2: Eros.photometry is missing",
            "mine.toml:2: Eros.radii_km is missing",
            "mine.toml:2: Eros.rotation is missing",
            "mine.toml:5: Eros.parent \"Sunn\" is not the name of a body; did you mean \"Sun\"?",
        ]
    );
}

/// Names are printed in lists, a line each, and in messages of one line.
#[test]
fn names_with_line_breaks_or_control_characters_are_refused() {
    let overlay = |name: &str| {
        format!(
            "[[overlay]]\nbody = \"Moon\"\nname = {name}\nfile = \"a.png\"\nprojection = \"orthographic\"\n\
             latitude_deg = 0.0\nlongitude_deg = 0.0\nwidth_km = 10.0\nheight_km = 10.0\n"
        )
    };
    for name in [r#""two\nlines""#, r#""two\rlines""#, r#""two\tcolumns""#] {
        let expected = format!("mine.toml:3: overlay.name = {name}: expected a name in one line, without control characters");
        assert_eq!(problems(&overlay(name)), [expected]);
    }
    // The characters that the file itself has are not shown: they would break the line of the message.
    let in_two_lines = problems(&overlay("\"\"\"two\nlines\"\"\""));
    assert_eq!(
        in_two_lines,
        ["mine.toml:3: overlay.name = \"\"\"two lines\"\"\": expected a name in one line, without control characters"]
    );
    let escaped = problems(&overlay(r#""bell\u0007""#));
    assert!(
        escaped.iter().any(|line| line.contains("overlay.name = ")) && escaped.iter().all(|line| !line.contains('\u{7}')),
        "{escaped:?}"
    );
    assert!(Catalog::with_files(&[("mine.toml".to_owned(), overlay("\"Größe 1\""))]).is_ok());
    let moment = problems("[[moment]]\nname = \"two\\nlines\"\n");
    assert!(moment[0].starts_with("mine.toml:") && moment.iter().any(|line| line.contains("expected a name in one line")), "{moment:?}");
}

/// A file's rings replace those of the embedded files, and a body's name may be written in several ways.
#[test]
fn rings_of_one_file_belong_together_however_the_body_is_named() {
    let ring = |body: &str, name: &str| {
        format!("[[ring]]\nbody = \"{body}\"\nname = \"{name}\"\ninner_km = 9e4\nouter_km = 1e5\ntau_normal = 0.1\n")
    };
    let rings_of = |files: &[(String, String)]| {
        let catalog = Catalog::with_files(files).unwrap_or_else(|e| panic!("{e}"));
        catalog.body(NaifId(699)).expect("Saturn").rings.iter().map(|r| r.name.clone()).collect::<Vec<_>>()
    };
    let first = ("a.toml".to_owned(), format!("{}{}", ring("Saturn", "X"), ring("saturn", "Y")));
    assert_eq!(rings_of(std::slice::from_ref(&first)), ["X", "Y"]);
    assert_eq!(rings_of(&[first, ("b.toml".to_owned(), ring("SATURN", "Z"))]), ["Z"]);
}

/// Where two rings overlap the later one counts, so only a gap may cover a denser ring. Negative control: Jupiter's rings in the opposite order, in which the
/// gossamer ring of Thebe hides that of Amalthea.
#[test]
fn no_ring_hides_a_denser_one() {
    let hidden = |rings: &[Ring]| {
        let pairs = rings.iter().enumerate().flat_map(|(k, earlier)| rings[k + 1..].iter().map(move |later| (earlier, later)));
        let hides = |(earlier, later): &(&Ring, &Ring)| {
            let overlap = later.inner_km < earlier.outer_km && earlier.inner_km < later.outer_km;
            overlap && 0.0 < later.tau_normal && later.tau_normal < earlier.tau_normal
        };
        pairs.filter(hides).map(|(earlier, later)| format!("{} by {}", earlier.name, later.name)).collect::<Vec<_>>()
    };
    let catalog = Catalog::embedded();
    for body in catalog.bodies() {
        assert_eq!(hidden(&body.rings), Vec::<String>::new(), "{}", body.name);
    }
    let mut reversed = catalog.body(NaifId(599)).expect("Jupiter").rings.clone();
    reversed.reverse();
    assert_eq!(hidden(&reversed), ["Amalthea gossamer by Thebe gossamer"]);
}

#[test]
fn invalid_rings_names_ids_and_toml_are_reported() {
    let found = problems(
        "[[ring]]\nbody = \"Saturn\"\nname = \"X\"\ninner_km = 9.0\nouter_km = 8.0\ntau_normal = nan\n\n[[atmosphere]]\nbody = \"Marz\"\ntop_km = 1.0\n",
    );
    assert_eq!(
        found,
        [
            "mine.toml:5: ring.outer_km = 8.0: expected kilometres above inner_km",
            "mine.toml:6: ring.tau_normal = nan: expected an optical depth from 0 to 100",
            "mine.toml:9: body \"Marz\" is not the name of a body; did you mean \"Mars\"?",
        ]
    );
    let no_id = problems("[[body]]\nname = \"Nobody\"\n");
    assert_eq!(no_id, ["mine.toml:1: Nobody.id is missing: expected a NAIF code above 9"]);
    // The rest of such an entry is read, too.
    let with_maps = problems("[[body]]\nname = \"Nobody\"\n[body.maps]\nnight = { fil = \"a.png\" }\n[body.sources]\nradii = \"a book\"\n");
    assert_eq!(
        with_maps,
        [
            "mine.toml:1: Nobody.id is missing: expected a NAIF code above 9",
            "mine.toml:4: Nobody.maps.night.fil is not a field here: did you mean `file`?",
            "mine.toml:4: Nobody.maps.night.file is missing: expected a file name without folders",
        ]
    );
    let duplicate_alias = problems("[[body]]\nid = 499\naliases = [\"Venus\"]\n");
    assert_eq!(duplicate_alias.len(), 1, "{duplicate_alias:?}");
}

/// What follows from a syntax error is not reported: neither fields that the parser guessed, nor names that the file defines and others use.
#[test]
fn a_file_that_is_not_toml_gives_one_line() {
    let body = "id = 2000433\nname = \"Eros\"\n";
    for (line, text) in [
        (1, "[[body]\n".to_owned()),
        (1, "[[body]\nid = 5\n".to_owned()),
        (3, format!("[[body]]\nid = 499\n= = =\nx = [1\n[[body]]\n{body}")),
        (4, format!("[[body]]\n{body}radius = = 3\n[[ring]\n")),
        (2, format!("[[body]]\nname = \"Eros\n{body}")),
        (5, format!("[[body]]\n{body}\nname = \"Twice\"\n")),
        (1, "= = =\n".repeat(100)),
    ] {
        let found = problems(&text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert!(found[0].starts_with(&format!("mine.toml:{line}: not TOML: ")), "{text}: {found:?}");
        // The fields of another file are still checked, but not its names.
        let other = "[[ring]]\nbody = \"Eros\"\nname = \"X\"\ninner_km = 9.0\nouter_km = 10.0\ntau_normal = nan\n";
        let files = [("mine.toml", text.as_str()), ("other.toml", other)].map(|(name, text)| (name.to_owned(), text.to_owned()));
        let error = Catalog::with_files(&files).expect_err("not TOML");
        let found: Vec<String> = error.problems.iter().map(ToString::to_string).collect();
        assert!(found.len() == 2 && found[1].starts_with("other.toml:6: ring.tau_normal = nan"), "{found:?}");
    }
    // A file that is TOML gives as many lines as it has problems.
    let wrong = problems("[[body]]\nid = 499\nx = 1\ny = 2\n");
    assert_eq!(wrong.len(), 2, "{wrong:?}");
}

#[test]
fn the_users_file_overrides_only_the_fields_that_it_contains() {
    let text = "[[body]]\nid = 499\ngeometric_albedo = 0.9\n[body.maps.albedo]\nfile = \"red.png\"\n";
    let mine = Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]).unwrap();
    let embedded = Catalog::embedded();
    let (old, new) = (embedded.body(NaifId(499)).unwrap(), mine.body(NaifId(499)).unwrap());
    assert_eq!(new.geometric_albedo, 0.9);
    assert_eq!(new.maps.albedo.as_ref().unwrap().file, "red.png");
    assert_eq!((new.radii_km, &new.motion, &new.maps.normal), (old.radii_km, &old.motion, &old.maps.normal));
    assert_eq!(embedded.bodies().len(), mine.bodies().len());
}

/// Each albedo and colour either was read in a source, or is marked as an estimate with its error. Only the Earth's albedo is both.
#[test]
fn values_without_a_source_are_marked_as_estimates() {
    let catalog = Catalog::embedded();
    let (mut sourced, mut estimated) = (0, 0);
    for b in catalog.bodies().iter().filter(|b| b.kind != BodyKind::Star) {
        for (topic, percent) in [("albedo", b.estimates.albedo_percent), ("colour", b.estimates.colour_percent)] {
            let source = b.sources.get(topic).unwrap_or_else(|| panic!("{} names no source of its {topic}", b.name));
            // The Earth's albedo was read in a source, but is also marked with an error because it is disputed.
            let was_read = source.contains("read in a public copy") && percent.is_none_or(|_| (b.id, topic) == (NaifId::EARTH, "albedo"));
            assert!(was_read || percent.is_some(), "{}, {topic}: {source}", b.name);
            sourced += usize::from(percent.is_none());
            estimated += usize::from(percent.is_some());
        }
        let notes = b.estimate_notes();
        let of_species = b.atmosphere.iter().flat_map(|a| &a.species).filter(|s| s.estimate_percent.is_some()).count();
        let of_body = [b.estimates.albedo_percent, b.estimates.colour_percent].into_iter().flatten().count();
        assert_eq!(notes.len(), of_species + of_body, "{}: {notes:?}", b.name);
    }
    assert!(sourced > 30 && estimated > 30, "{sourced} {estimated}");
}

/// Half of the light is 0.75 magnitudes (Pogson). A value in a user's file does not inherit the error of the value that it replaces.
#[test]
fn an_estimate_states_its_error_and_applies_only_to_the_catalogs_value() {
    let triton_with = |text: &str| {
        let catalog = Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]).expect("a catalog");
        catalog.body(NaifId(801)).expect("Triton").clone()
    };
    let triton = triton_with("[[body]]\nid = 801\ngeometric_albedo = 0.5\n[body.estimates]\nalbedo_percent = 50\n");
    assert_eq!(triton.estimate_notes()[0].to_string(), "estimated albedo 0.5 ±50 %, up to 0.75 mag in brightness");
    let users_value = triton_with("[[body]]\nid = 801\ngeometric_albedo = 0.5\n");
    assert_eq!(users_value.estimates.albedo_percent, None);
    assert!(users_value.estimates.colour_percent.is_some(), "its colour is still the catalog's");
    assert!(triton_with("[[body]]\nid = 801\n").estimates.albedo_percent.is_some());
    let found = problems("[[body]]\nid = 801\n[body.estimates]\nalbedo_percent = 120\nalbedo = 3\n");
    assert_eq!(
        found,
        [
            "mine.toml:4: Triton.estimates.albedo_percent = 120: expected percent above 0, at most 90",
            "mine.toml:5: Triton.estimates.albedo is not a field here: did you mean `albedo_percent`?",
        ]
    );
}

/// Every radius whose source is the text kernel (pck00011) equals the kernel's value, to the digit.
#[test]
fn radii_equal_those_of_the_text_kernel() {
    let kernel = orrery_catalogs::PLANETARY_CONSTANTS;
    let data: String = kernel.split("\\begindata").skip(1).filter_map(|part| part.split("\\begintext").next()).collect();
    let radii_of = |id: i32| -> Option<Vec<f64>> {
        let (_, rest) = data.split_once(&format!("BODY{id}_RADII"))?;
        let list = rest.split_once('(')?.1.split_once(')')?.0;
        Some(list.split_whitespace().filter_map(|w| w.parse().ok()).collect())
    };
    let catalog = Catalog::embedded();
    let mut checked = 0;
    for b in catalog.bodies().iter().filter(|b| b.sources.get("radii").is_some_and(|s| s.contains("pck00011"))) {
        let radii = radii_of(b.id.0).unwrap_or_else(|| panic!("the kernel has no radii of {}", b.name));
        assert_eq!(radii, b.radii_km.to_array(), "{}", b.name);
        checked += 1;
    }
    assert!(checked > 30, "{checked} bodies have radii of the kernel");
    assert_ne!(radii_of(399), radii_of(499), "the parser of this test must distinguish bodies");
}

/// CIE 1931 colour-matching functions as sums of asymmetric Gaussians: C. Wyman, P.-P. Sloan & P. Shirley, JCGT 2 (2), 2013.
fn colour_matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, peak: f64, width_below: f64, width_above: f64| {
        let x = (nm - peak) / if nm < peak { width_below } else { width_above };
        height * (-0.5 * x * x).exp()
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// The colour (linear sRGB of luminance 1) of a body with these reflectances at 440, 550 and 640 nm in sunlight, if sunlight itself is
/// white.
fn seen_colour(reflectance: [f64; 3]) -> [f64; 3] {
    let reflectance_at = |nm: f64| {
        if nm < 550.0 {
            let t = ((nm - 440.0) / 110.0).max(0.0);
            reflectance[0] + t * (reflectance[1] - reflectance[0])
        } else {
            let t = ((nm - 550.0) / 90.0).min(1.0);
            reflectance[1] + t * (reflectance[2] - reflectance[1])
        }
    };
    let (mut body, mut white) = ([0.0; 3], [0.0; 3]);
    for k in 380..=780 {
        let nm = f64::from(k);
        // The Sun as a blackbody of 5778 K.
        let sun = nm.powi(-5) / ((1.4388e7 / (nm * 5778.0)).exp() - 1.0);
        for (c, m) in colour_matching(nm).into_iter().enumerate() {
            body[c] += sun * m * reflectance_at(nm);
            white[c] += sun * m;
        }
    }
    let d65_white = [0.9505, 1.0, 1.089];
    let [x, y, z]: [f64; 3] = std::array::from_fn(|c| body[c] / white[c] * d65_white[c]);
    // XYZ to linear sRGB: IEC 61966-2-1.
    let rgb = [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z];
    rgb.map(|v| v / (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]))
}

/// The number that follows a word.
fn number_after(text: &str, word: &str) -> Option<f64> {
    text.split_once(word)?.1.split([' ', ',', ';', ')']).find(|w| !w.is_empty())?.parse().ok()
}

/// Colours follow, by the spectrum, from the albedos or colour indices in their sources. Taking three wavelengths as red, green and blue
/// instead would give too little saturation: a red of 1.27 for Mars. The Earth, Titan, Uranus and Neptune are exceptions
/// (catalogs/README.md).
#[test]
fn colours_follow_from_the_albedos_in_their_sources() {
    let catalog = Catalog::embedded();
    let mut checked = 0;
    for b in catalog.bodies().iter().filter(|b| ![399, 606, 799, 899].contains(&b.id.0)) {
        let Some(text) = b.sources.get("colour") else { continue };
        let reflectance = if let Some((_, list)) = text.split_once("B, V, Rc ") {
            let list: Vec<f64> = list.split(", ").filter_map(|w| w.parse().ok()).collect();
            [list[0], list[1], list[2]]
        } else if let Some(b_v) = number_after(text, "B-V ") {
            // 0.653: B-V of the Sun (Ramirez et al. 2012).
            [10_f64.powf(-0.4 * (b_v - 0.653)), 1.0, number_after(text, "p(640)/p(550) ").unwrap_or(1.0)]
        } else {
            continue;
        };
        let seen = seen_colour(reflectance);
        for (c, value) in b.colour.to_array().into_iter().enumerate() {
            assert!((f64::from(value) - seen[c]).abs() < 0.001, "{} channel {c}: {value} for {}", b.name, seen[c]);
        }
        checked += 1;
    }
    assert!(checked > 30, "{checked} colours could be recomputed");
    assert!(seen_colour([0.5; 3]).iter().all(|v| (v - 1.0).abs() < 0.002), "grey is grey");
    assert!((seen_colour([0.088, 0.17, 0.25])[0] - 1.27).abs() > 0.1, "three wavelengths would not suffice");
}

/// Errors that arise only with the shipped catalog are reported at the line of the user's file that causes them, whatever the order of
/// bodies.
#[test]
fn cycles_and_duplicate_names_are_found_in_the_users_file() {
    let moon = |id: i32, name: &str, parent: &str| {
        let orbit: String =
            ["pole_ra_deg", "pole_dec_deg", "epoch_jd_tt", "eccentricity", "inclination_deg", "node_deg", "argument_of_periapsis_deg"]
                .into_iter()
                .chain(["mean_anomaly_deg", "node_period_yr", "argument_period_yr"])
                .map(|field| format!("{field} = 0.0\n"))
                .collect();
        format!(
            "[[body]]\nid = {id}\nname = \"{name}\"\nparent = \"{parent}\"\nkind = \"moon\"\nradii_km = [10.0, 10.0, 10.0]\ngeometric_albedo = 0.1\n\
             colour_linear_srgb = [1.0, 1.0, 1.0]\nphotometry = {{ model = \"lambert\" }}\nrotation = {{ model = \"synchronous\" }}\n\
             [body.motion]\ntheory = \"mean-elements\"\nsemi_major_axis_km = 1e5\nmean_motion_deg_day = 1.0\n{orbit}"
        )
    };
    assert_eq!(problems(&moon(50_001, "A", "Mars")), Vec::<String>::new(), "a valid moon");
    let lines_per_moon = moon(50_001, "A", "Mars").lines().count();
    // Text of the file; line and part of each message.
    for (text, expected) in [
        ("[[body]]\nid = 401\nparent = \"Phobos\"\n".to_owned(), vec![(3, "Phobos.parent is the body itself")]),
        ("[[body]]\nid = 499\nparent = \"Phobos\"\n".to_owned(), vec![(3, "Mars.parent is a cycle: Phobos, Mars")]),
        ("[[body]]\nid = 402\nname = \"Phobos\"\n".to_owned(), vec![(3, "the name \"Phobos\" is already that of body 401")]),
        ("[[body]]\nid = 401\nname = \"Deimos\"\n".to_owned(), vec![(3, "the name \"Deimos\" is already that of body 402")]),
        ("[[body]]\nid = 401\naliases = [\"deimos\"]\n".to_owned(), vec![(3, "already that of body 402")]),
        (moon(50_001, "Earth", "Mars"), vec![(3, "the name \"Earth\" is already that of body 399")]),
        (moon(50_001, "A", "A"), vec![(4, "A.parent is the body itself")]),
        (
            moon(50_001, "A", "B") + &moon(50_002, "B", "A"),
            vec![(4, "A.parent is a cycle: B, A"), (lines_per_moon + 4, "B.parent is a cycle: A, B")],
        ),
        (
            moon(50_001, "A", "Mars") + &moon(50_002, "a", "Mars"),
            vec![(lines_per_moon + 3, "the name \"a\" is already that of body 50001")],
        ),
        // Names are looked up without regard to `-`, `_` and the number of spaces.
        (
            moon(50_001, "S 2004-7", "Mars") + &moon(50_002, "S_2004 7", "Mars"),
            vec![(lines_per_moon + 3, "the name \"S_2004 7\" is already that of body 50001")],
        ),
        (moon(50_001, "EMB", "Mars"), vec![(3, "the name \"EMB\" is that of a barycentre")]),
        (moon(50_001, "Pluto-Barycentre", "Mars"), vec![(3, "the name \"Pluto-Barycentre\" is that of a barycentre")]),
        // Names are looked up before codes. A number that is no other body's code is a name as any other.
        (moon(50_001, "599", "Mars"), vec![(3, "the name \"599\" is the NAIF code of body 599")]),
        (moon(50_001, "5", "Mars"), vec![(3, "the name \"5\" is the NAIF code of a barycentre")]),
        ("[[body]]\nid = 401\naliases = [\"402\"]\n".to_owned(), vec![(3, "the name \"402\" is the NAIF code of body 402")]),
        (moon(50_001, "50001", "Mars") + &moon(50_002, "433", "Mars"), vec![]),
    ] {
        let found = problems(&text);
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, (line, message)) in found.iter().zip(expected) {
            assert!(found.contains(&format!(":{line}: ")) && found.contains(message) && !found.contains("moons_inner"), "{found}");
        }
    }
}

/// Elements and rotations with which a position or an orientation would overflow and become NaN.
#[test]
fn elements_and_rates_beyond_all_bodies_are_refused() {
    let usual = [
        ("pole_ra_deg", "270.0"),
        ("pole_dec_deg", "66.5"),
        ("epoch_jd_tt", "2451545.0"),
        ("semi_major_axis_km", "9376.0"),
        ("eccentricity", "0.015"),
        ("inclination_deg", "1.1"),
        ("node_deg", "1e300"),
        ("argument_of_periapsis_deg", "216.3"),
        ("mean_anomaly_deg", "-1e300"),
        ("mean_motion_deg_day", "1128.8"),
        ("node_period_yr", "-2.26"),
        ("argument_period_yr", "0.0"),
        ("longitude_quadratic_deg_cy2", "12.7"),
    ];
    let phobos = |changed: &str, value: &str| {
        let line = |(field, usual): &(&str, &str)| format!("{field} = {}\n", if *field == changed { value } else { *usual });
        let elements: String = usual.iter().map(line).collect();
        problems(&format!("[[body]]\nid = 401\n[body.motion]\ntheory = \"mean-elements\"\n{elements}"))
    };
    assert_eq!(phobos("", ""), Vec::<String>::new(), "an angle may have any value");
    for (field, value) in [
        ("epoch_jd_tt", "-1e300"),
        ("semi_major_axis_km", "1e300"),
        ("mean_motion_deg_day", "1e300"),
        ("node_period_yr", "1e-320"),
        ("argument_period_yr", "-1e-320"),
        ("longitude_quadratic_deg_cy2", "-1e300"),
    ] {
        let found = phobos(field, value);
        assert!(found.len() == 1 && found[0].contains(&format!("Phobos.motion.{field} = {value}: expected ")), "{found:?}");
    }
    let spin = "rotation = { model = \"fixed\", pole_ra_deg = 1e300, pole_dec_deg = 66.5, w0_deg = 1e300, w_deg_day =";
    assert_eq!(problems(&format!("[[body]]\nid = 401\n{spin} -750.0 }}\n")), Vec::<String>::new());
    let found = problems(&format!("[[body]]\nid = 401\n{spin} -1e300 }}\n"));
    assert_eq!(found, ["mine.toml:3: Phobos.rotation.w_deg_day = -1e300: expected degrees a day from -1e6 to 1e6"]);
}
