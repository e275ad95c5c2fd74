//! Bodies in the usual order: the Sun, the planets, then dwarf planets and asteroids, each followed by its moons.
//!
//! In: the catalog and the ephemeris. Out: every body's NAIF code once. Siblings are sorted by mean distance from their parent: the semi-major axis of
//! the catalog's elements, else that of the osculating orbit at J2000. Nothing here depends on the displayed instant.

use super::Ephemeris;
use super::orbit_size::semi_major_axis_km;
use crate::catalog::{Body, BodyKind, Catalog, NaifId};

/// Every body of the catalog once, in the order of the module's comment.
pub fn bodies_in_usual_order(catalog: &Catalog, ephemeris: &Ephemeris) -> Vec<NaifId> {
    let rank = |b: &Body| match b.kind {
        BodyKind::Star => 0,
        BodyKind::Planet => 1,
        BodyKind::DwarfPlanet | BodyKind::Asteroid => 2,
        BodyKind::Moon => 3,
    };
    // Rank, semi-major axis in km (0 without an orbit), body.
    let mut sorted: Vec<(i32, f64, &Body)> =
        catalog.bodies().iter().map(|b| (rank(b), semi_major_axis_km(catalog, ephemeris, b).unwrap_or(0.0), b)).collect();
    sorted.sort_by(|(rank_a, axis_a, a), (rank_b, axis_b, b)| rank_a.cmp(rank_b).then(axis_a.total_cmp(axis_b)).then(a.id.cmp(&b.id)));
    let mut order = Vec::with_capacity(sorted.len());
    for (_, _, body) in sorted.iter().filter(|(_, _, b)| b.kind != BodyKind::Moon) {
        order.push(body.id);
        order.extend(sorted.iter().filter(|(_, _, m)| m.is_moon_of(body.id)).map(|(_, _, m)| m.id));
    }
    // A moon of a moon, which only a user's catalog can have, comes last.
    order.extend(sorted.iter().map(|(_, _, b)| b.id).filter(|id| !order.contains(id)).collect::<Vec<_>>());
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planets_are_sorted_by_distance_each_with_its_moons() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let order = bodies_in_usual_order(&catalog, &ephemeris);
        let names: Vec<&str> = order.iter().filter_map(|id| catalog.body(*id)).map(|b| b.name.as_str()).collect();
        assert_eq!(names[..8], ["Sun", "Mercury", "Venus", "Earth", "Moon", "Mars", "Phobos", "Deimos"]);
        let position = |name: &str| names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("{name} is missing"));
        // The order of the moons' distances in JPL's table of mean elements.
        for following in [
            &["Jupiter", "Metis", "Adrastea", "Amalthea", "Thebe", "Io", "Europa", "Ganymede", "Callisto", "Saturn"][..],
            &["Mimas", "Enceladus", "Tethys", "Dione", "Rhea", "Titan", "Hyperion", "Iapetus", "Uranus", "Miranda", "Ariel", "Umbriel"],
            &["Titania", "Oberon", "Neptune", "Proteus", "Triton", "Vesta", "Ceres", "Pluto"],
        ] {
            assert!(following.windows(2).all(|w| position(w[0]) < position(w[1])), "{names:?}");
        }
        assert_eq!(order.len(), catalog.bodies().len(), "every body");
        assert_eq!(order.iter().collect::<std::collections::BTreeSet<_>>().len(), order.len(), "once");
    }
}
