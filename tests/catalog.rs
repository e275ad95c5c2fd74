//! The catalog as a whole: what ships is sound, and broken files give exactly the expected lines.

use orrery::catalog::{Catalog, Kind, MapLatitude, Motion, NaifId, Photometry};

fn complaints(text: &str) -> Vec<String> {
    match Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]) {
        Ok(_) => Vec::new(),
        Err(e) => e.problems.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn what_ships_is_whole() {
    let catalog = Catalog::embedded();
    let count = |k| catalog.bodies().iter().filter(|b| b.kind == k).count();
    assert_eq!((count(Kind::Star), count(Kind::Planet), count(Kind::DwarfPlanet), count(Kind::Asteroid)), (1, 8, 2, 1));
    assert!(count(Kind::Moon) >= 40);
    for b in catalog.bodies() {
        assert!(b.radii_km.x >= b.radii_km.z, "{}: the pole is the short axis", b.name);
        let y = 0.2126 * b.colour.x + 0.7152 * b.colour.y + 0.0722 * b.colour.z;
        assert!((y - 1.0).abs() < 1e-5, "{}: colour has luminance {y}", b.name);
        assert!(!b.sources.is_empty(), "{} names no source", b.name);
        if let Motion::MeanElements(e) = &b.motion {
            assert!(e.semi_major_axis_km > b.radii_km.x, "{}", b.name);
            let gm = b.parent.and_then(|p| catalog.body(p)).and_then(|p| p.gm_km3_s2).unwrap() + b.gm_km3_s2.unwrap_or(0.0);
            // Kepler's third law; the primary's oblateness moves the small inner moons by up to 2 percent.
            let n = (gm / e.semi_major_axis_km.powi(3)).sqrt().to_degrees() * 86_400.0;
            assert!((n / e.mean_motion_deg_day - 1.0).abs() < 0.02, "{}: {n} against {}", b.name, e.mean_motion_deg_day);
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

/// Irwin et al. 2024: Uranus and Neptune are nearly one pale greenish blue, Neptune slightly bluer.
#[test]
fn neptune_is_pale_and_close_to_uranus() {
    let catalog = Catalog::embedded();
    let (u, n) = (catalog.body(NaifId(799)).unwrap().colour, catalog.body(NaifId(899)).unwrap().colour);
    assert!((u - n).length() < 0.15 && n.z > u.z && n.z / n.x < 2.0, "{u} {n}");
}

#[test]
fn places_have_names() {
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
        assert_eq!(catalog.find_place(name), Some(NaifId(id)), "{name}");
    }
    for name in ["", "vulcan", "io barycenter", "sun barycenter"] {
        assert_eq!(catalog.find_place(name), None, "{name}");
    }
    for b in catalog.bodies() {
        assert_eq!(catalog.find_place(&b.name), Some(b.id));
    }
}

#[test]
fn every_wrong_field_is_named() {
    let text = "[[body]]\nid = 499\ngeometric_albedo = -0.2\nradii_kn = [1.0, 2.0, 3.0]\nkind = \"plant\"\nphotometry = { model = \"oren-nayar\", roughness_deg = 90 }\n";
    assert_eq!(
        complaints(text),
        [
            "mine.toml:3: Mars.geometric_albedo = -0.2: expected a number from 0 to 2",
            "mine.toml:4: Mars.radii_kn is not a field here: did you mean `radii_km`?",
            "mine.toml:5: Mars.kind = \"plant\": expected one of \"star\", \"planet\", \"dwarf-planet\", \"moon\", \"asteroid\"",
            "mine.toml:6: Mars.photometry.roughness_deg = 90: expected degrees from 0 to 60",
        ]
    );
}

#[test]
fn a_new_body_must_be_whole() {
    let found = complaints("# mine\n[[body]]\nid = 2000433\nname = \"Eros\"\nparent = \"Sunn\"\n");
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
            "mine.toml:5: \"Sunn\" is not the name of a body; did you mean \"sun\"?",
        ]
    );
}

#[test]
fn broken_rings_air_and_words_are_named() {
    let found = complaints(
        "[[ring]]\nbody = \"Saturn\"\nname = \"X\"\ninner_km = 9.0\nouter_km = 8.0\ntau_normal = nan\n\n[[atmosphere]]\nbody = \"Marz\"\ntop_km = 1.0\n",
    );
    assert_eq!(
        found,
        [
            "mine.toml:5: ring.outer_km = 8.0: expected kilometres above inner_km",
            "mine.toml:6: ring.tau_normal = nan: expected an optical depth from 0 to 100",
            "mine.toml:9: \"Marz\" is not the name of a body; did you mean \"mars\"?",
        ]
    );
    let words = complaints("[[body]\nid = 499\n");
    assert!(!words.is_empty() && words[0].starts_with("mine.toml:1: not TOML: "), "{words:?}");
    let no_id = complaints("[[body]]\nname = \"Nobody\"\n");
    assert_eq!(no_id, ["mine.toml:1: Nobody.id is missing: expected a NAIF code above 9"]);
    let doubled = complaints("[[body]]\nid = 499\naliases = [\"Venus\"]\n");
    assert_eq!(doubled.len(), 1, "{doubled:?}");
}

#[test]
fn the_users_file_overrides_fields_only() {
    let text = "[[body]]\nid = 499\ngeometric_albedo = 0.9\n[body.maps.albedo]\nfile = \"red.png\"\n";
    let mine = Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]).unwrap();
    let (a, b) = (Catalog::embedded(), mine);
    let (old, new) = (a.body(NaifId(499)).unwrap(), b.body(NaifId(499)).unwrap());
    assert_eq!(new.geometric_albedo, 0.9);
    assert_eq!(new.maps.albedo.as_ref().unwrap().file, "red.png");
    assert_eq!((new.radii_km, &new.motion, &new.maps.normal), (old.radii_km, &old.motion, &old.maps.normal));
    assert_eq!(a.bodies().len(), b.bodies().len());
}
