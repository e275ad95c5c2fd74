//! Files of `--catalogs` beside the shipped ones: rings that do not fit their body, renamed bodies, values that were refused.

use super::entries::problems;
use orrery::catalog::{Catalog, NaifId};

fn ring(body: &str, inner_km: &str, outer_km: &str) -> String {
    format!("[[ring]]\nbody = \"{body}\"\nname = \"x\"\ninner_km = {inner_km}\nouter_km = {outer_km}\ntau_normal = 1.0\n")
}

/// Mars has an equatorial radius of 3396.19 km, Phobos semi-axes of 13.0, 11.4 and 9.1 km.
#[test]
fn a_ring_lies_outside_its_body_and_not_too_far_away() {
    for (body, inner_km, outer_km) in [("Mars", "3396.2", "5e3"), ("Mars", "4e3", "3.39e9"), ("Phobos", "13.1", "14.0")] {
        assert_eq!(problems(&ring(body, inner_km, outer_km)), Vec::<String>::new(), "{body} {inner_km} {outer_km}");
    }
    for (body, inner_km, outer_km, expected) in [
        ("Mars", "1e3", "2e3", "mine.toml:4: ring.inner_km = 1000.0: expected kilometres above 3396.19, the equatorial radius of Mars"),
        ("Mars", "3e3", "5e3", "mine.toml:4: ring.inner_km = 3000.0: expected kilometres above 3396.19, the equatorial radius of Mars"),
        ("Phobos", "12.0", "14.0", "mine.toml:4: ring.inner_km = 12.0: expected kilometres above 13.0, the equatorial radius of Phobos"),
        (
            "Mars",
            "4e3",
            "1e300",
            "mine.toml:5: ring.outer_km = 1e300: expected kilometres below 3396190000.0, a million times 3396.19, the equatorial radius of Mars",
        ),
    ] {
        assert_eq!(problems(&ring(body, inner_km, outer_km)), [expected]);
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_file() {
    assert_eq!(problems(&format!("\u{feff}{}", ring("Mars", "4e3", "5e3"))), Vec::<String>::new());
    let wrong = ring("Mars", "1e3", "2e3");
    assert_eq!(problems(&format!("\u{feff}{wrong}")), problems(&wrong));
}

/// A folder without catalog files is probably not the one that was meant.
#[test]
fn a_folder_of_catalogs_has_a_catalog() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = || orrery::session::read_catalog(Some(folder.path())).map_err(|e| e.to_string());
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("Cargo.toml", "[package]\n");
    write("notes.txt", "none\n");
    // Attributes that macOS keeps beside a file; the text is not TOML.
    write("._mine.toml", "none\n");
    let error = read().expect_err("no catalog");
    assert!(error.contains(&folder.path().display().to_string()) && error.contains("no catalog file (*.toml) in it"), "{error}");
    // On some systems names of files are in capital letters.
    write("MINE.TOML", "[[body]]\nid = 401\nname = \"Fear\"\n");
    assert!(read().expect("a catalog").body_named("Fear").is_ok());
}

/// Saturn's shipped rings reach from 66 900 km to 480 000 km.
#[test]
fn radii_that_do_not_fit_the_shipped_rings_are_reported_in_the_users_file() {
    let saturn = |radii_km: &str| format!("[[body]]\nid = 699\nradii_km = [{radii_km}]\n");
    assert_eq!(problems(&saturn("66e3, 66e3, 6e4")), Vec::<String>::new());
    assert_eq!(
        problems(&saturn("6e4, 67e3, 6e4")),
        ["mine.toml:3: Saturn.radii_km: expected an equatorial radius below 66900.0 km, where its rings begin"]
    );
    assert_eq!(
        problems(&saturn("0.1, 0.1, 0.1")),
        ["mine.toml:3: Saturn.radii_km: expected an equatorial radius above 0.48 km, a millionth of that of its rings"]
    );
    // Rings of the user's own replace the shipped ones, whatever the order in the file.
    let with_rings = saturn("67e3, 67e3, 6e4") + &ring("Saturn", "7e4", "8e4");
    assert_eq!(problems(&with_rings), Vec::<String>::new());
}

/// The shipped atmospheres and moments name the Earth, and the moons of Mars their planet.
#[test]
fn a_renamed_body_is_still_found_by_its_former_name() {
    let text = "[[body]]\nid = 399\nname = \"Terra\"\n\n[[body]]\nid = 499\nname = \"Ares\"\naliases = [\"fourth\"]\n";
    let files = [("mine.toml".to_owned(), text.to_owned()), ("more.toml".to_owned(), "[[body]]\nid = 399\nname = \"Gaia\"\n".to_owned())];
    let catalog = Catalog::with_files(&files).unwrap_or_else(|e| panic!("{e}"));
    let earth = catalog.body(NaifId::EARTH).expect("the Earth");
    assert!(earth.name == "Gaia" && earth.atmosphere.is_some(), "{}", earth.name);
    for (name, id) in [("Earth", 399), ("terra", 399), ("Gaia", 399), ("mars", 499), ("Ares", 499), ("fourth", 499)] {
        assert_eq!(catalog.find_body_or_barycenter(name), Some(NaifId(id)), "{name}");
    }
    assert_eq!(catalog.body(NaifId(401)).expect("Phobos").parent, Some(NaifId(499)));
    // A former name that is now the name of another body is that body's alone.
    let swapped = "[[body]]\nid = 401\nname = \"Deimos\"\n[[body]]\nid = 402\nname = \"Phobos\"\n";
    let catalog = Catalog::with_files(&[("mine.toml".to_owned(), swapped.to_owned())]).unwrap_or_else(|e| panic!("{e}"));
    for (name, id) in [("Deimos", 401), ("Phobos", 402)] {
        assert_eq!(catalog.find_body_or_barycenter(name), Some(NaifId(id)), "{name}");
    }
    // A name that no body has or had is still unknown.
    assert_eq!(problems("[[body]]\nid = 401\nparent = \"Ares\"\n"), ["mine.toml:3: Phobos.parent \"Ares\" is not the name of a body"]);
}

#[test]
fn a_refused_value_is_not_reported_as_missing() {
    let text = "[[body]]\nid = 2000433\nname = \"Eros\"\nkind = \"asteroid\"\nparent = 5\nradii_km = [1e7, 1e7, 1e7]\ngeometric_albedo = nan\n\
                motion = \"text\"\nphotometry = { model = \"lambert\" }\nrotation = { model = \"synchronous\" }\n";
    assert_eq!(
        problems(text),
        [
            "mine.toml:1: Eros.colour_linear_srgb is missing",
            "mine.toml:5: Eros.parent = 5: expected the name of a body",
            "mine.toml:6: Eros.radii_km = [1e7, 1e7, 1e7]: expected three lengths in km, above 0 and below 1e7",
            "mine.toml:7: Eros.geometric_albedo = nan: expected a number from 0 to 2",
            "mine.toml:8: Eros.motion = string: expected a table",
        ]
    );
    // The field that is missing follows from a line of the user's, not from the shipped file.
    assert_eq!(problems("[[body]]\nid = 10\nkind = \"planet\"\n"), ["mine.toml:3: Sun.parent is missing: all bodies but stars have one"]);
}

/// Of two tables of one body in one file the later would have replaced fields of the earlier without a word. In two files that is how values are overridden.
#[test]
fn a_file_has_one_table_for_each_body() {
    let body = |id: i32, albedo: f64| format!("[[body]]\nid = {id}\ngeometric_albedo = {albedo}\n");
    assert_eq!(problems(&format!("{}{}", body(401, 0.1), body(402, 0.2))), Vec::<String>::new());
    let twice = problems(&format!("{}{}", body(401, 0.1), body(401, 0.2)));
    let [line] = &twice[..] else { panic!("{twice:?}") };
    assert!(line.contains("[[body]] with the id 401: this file has one already in line 2"), "{line}");
    let files = [("a.toml", body(401, 0.1)), ("b.toml", body(401, 0.2))].map(|(name, text)| (name.to_owned(), text));
    let overridden = Catalog::with_files(&files).expect("two files");
    assert_eq!(overridden.body(NaifId(401)).expect("Phobos").geometric_albedo, 0.2);
}
