//! The data files of Orrery, as bytes and text. README.md states source, licence, units, frame, epoch and error bound of each file.
//!
//! Nothing is parsed here. The crate exists because a package in a registry holds 10 MB at most.

/// Name and text of the catalog's files, in the order in which they are read.
pub static CATALOG_FILES: &[(&str, &str)] = &[
    ("planets.toml", include_str!("planets.toml")),
    ("dwarfs_and_asteroids.toml", include_str!("dwarfs_and_asteroids.toml")),
    ("moons_inner.toml", include_str!("moons_inner.toml")),
    ("moons_jupiter.toml", include_str!("moons_jupiter.toml")),
    ("moons_saturn.toml", include_str!("moons_saturn.toml")),
    ("moons_outer.toml", include_str!("moons_outer.toml")),
    ("rings.toml", include_str!("rings.toml")),
    ("atmospheres.toml", include_str!("atmospheres.toml")),
    ("moments.toml", include_str!("moments.toml")),
    ("instruments.toml", include_str!("instruments.toml")),
];

/// Title, summary and JSON of the tours.
pub static TOURS: &[(&str, &str, &str)] = &[
    (
        "A total eclipse and its shader",
        "8 April 2024 from space, from Dallas, and as the shader sees it",
        include_str!("tours/eclipse.json"),
    ),
    (
        "Saturn's shadows",
        "The rings on the planet, the planet on the rings, and the ring-plane crossing",
        include_str!("tours/saturn.json"),
    ),
    ("A day on Mars", "Morning and sunset in Gale crater, and Phobos", include_str!("tours/mars.json")),
];

/// SPK kernel of planets and barycentres, 1900 to 2100, baked by `examples/bake_kernel.rs`.
pub static KERNEL: &[u8] = include_bytes!("orrery_1900_2100.bsp");

/// SPK kernel of Pluto's barycentre, 1551 to 2646.
pub static PLUTO_KERNEL: &[u8] = include_bytes!("pluto_1551_2646.bsp");

/// Text PCK: radii, poles and prime meridians.
pub static PLANETARY_CONSTANTS: &str = include_str!("pck00011.tpc");

/// CSV of the truncated ELP 2000 series of the Moon.
pub static LUNAR_SERIES: &str = include_str!("elp2000_truncated.csv");

/// JSON of the L1.2 theory of the Galilean moons.
pub static GALILEAN_THEORY: &str = include_str!("galilean_l12.json");

/// JSON of the TASS 1.7 theory of Saturn's moons.
pub static SATURN_THEORY: &str = include_str!("saturn_tass17.json");

/// CSV of named surface features.
pub static NOMENCLATURE: &str = include_str!("nomenclature_usgs.csv");

/// CSV of cities.
pub static CITIES: &str = include_str!("cities.csv");

/// CSV of landing sites.
pub static LANDING_SITES: &str = include_str!("landing_sites.csv");

/// CSV of the stars to magnitude 7, epoch J1991.25.
pub static STARS: &str = include_str!("stars_v7.csv");

/// CSV of 605 minor planets: osculating elements and brightness.
pub static SMALL_BODIES: &str = include_str!("small_bodies.csv");

/// CSV of bright and well-known comets: osculating elements and total magnitudes.
pub static COMETS: &str = include_str!("comets.csv");

/// CSV of osculating elements of comets at other perihelion passages.
pub static COMET_APPARITIONS: &str = include_str!("comet_apparitions.csv");

/// CSV of total magnitudes of comets as observers saw them, before and after perihelion.
pub static COMET_LIGHT_CURVES: &str = include_str!("comet_light_curves.csv");

/// GeoJSON of the constellations' figures, J2000.
pub static CONSTELLATION_LINES: &str = include_str!("constellation_lines.json");

/// GeoJSON of the borders between constellations: the corners, in J2000, of Delporte's borders, which run along coordinates of B1875.
pub static CONSTELLATION_BORDERS: &str = include_str!("constellation_borders.json");

/// JSON list of the constellations: abbreviation, name, genitive, rank, and where a chart writes the name, J2000.
pub static CONSTELLATION_NAMES: &str = include_str!("constellation_names.json");
