//! Bodies in the usual order: the Sun, the planets, then dwarf planets and asteroids, each followed by its moons.
//!
//! In: the catalog and the ephemeris. Out: every body's NAIF code once. Siblings are sorted by mean distance from their parent: the semi-major axis of
//! the catalog's elements, else that of the osculating orbit at J2000. Nothing here depends on the displayed instant.

use super::Ephemeris;
use crate::catalog::{Body, BodyKind, Catalog, Motion, NaifId};
use crate::time::Instant;

/// Semi-major axis of the orbit about the parent: the catalog's, else by the vis-viva equation from the state at J2000, else (no GM, or an unbound orbit)
/// the distance at J2000. `None` for a body without a parent in the catalog or one that the ephemeris cannot place.
pub fn semi_major_axis_km(catalog: &Catalog, ephemeris: &Ephemeris, body: &Body) -> Option<f64> {
    if let Motion::MeanElements(elements) = &body.motion {
        return Some(elements.semi_major_axis_km);
    }
    let parent = catalog.body(body.parent?)?;
    let state = ephemeris.state(body.id, parent.id, Instant::from_tdb_seconds_past_j2000(0.0), None).ok()?.state;
    let distance_km = state.pos_km.length();
    let total_gm = parent.gm_km3_s2.map(|gm| gm + body.gm_km3_s2.unwrap_or(0.0));
    let axis_km = total_gm.map(|gm| 1.0 / (2.0 / distance_km - state.vel_km_s.length_squared() / gm)).filter(|a| a.is_finite() && *a > 0.0);
    Some(axis_km.unwrap_or(distance_km))
}

/// Every body of the catalog once, in the order of the module's comment.
pub fn bodies_in_usual_order(catalog: &Catalog, ephemeris: &Ephemeris) -> Vec<NaifId> {
    let rank = |b: &Body| match b.kind {
        BodyKind::Star => 0,
        BodyKind::Planet => 1,
        BodyKind::DwarfPlanet | BodyKind::Asteroid => 2,
        BodyKind::Moon => 3,
    };
    // Rank, semi-major axis in km, body.
    let mut sorted: Vec<(i32, f64, &Body)> =
        catalog.bodies().iter().map(|b| (rank(b), semi_major_axis_km(catalog, ephemeris, b).unwrap_or(0.0), b)).collect();
    sorted.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.id.cmp(&b.2.id)));
    let mut order = Vec::with_capacity(sorted.len());
    for (_, _, body) in sorted.iter().filter(|(_, _, b)| b.kind != BodyKind::Moon) {
        order.push(body.id);
        order.extend(sorted.iter().filter(|(_, _, m)| m.kind == BodyKind::Moon && m.parent == Some(body.id)).map(|(_, _, m)| m.id));
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

    /// The semi-major axis from one state differs from the mean axis by the size of the perturbations. Standish 1992: Mars 1.523 71 au, Jupiter
    /// 5.202 89 au.
    #[test]
    fn an_orbit_known_by_its_state_has_its_published_axis() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        for (id, published_km) in [(499, 1.523_71 * crate::units::KM_PER_AU), (599, 5.202_89 * crate::units::KM_PER_AU), (301, 384_400.0)] {
            let ours = semi_major_axis_km(&catalog, &ephemeris, catalog.body(NaifId(id)).expect("a body")).expect("an orbit");
            assert!((ours / published_km - 1.0).abs() < 0.02, "{id}: {ours} against {published_km}");
        }
        assert_eq!(semi_major_axis_km(&catalog, &ephemeris, catalog.body(NaifId::SUN).expect("the Sun")), None);
    }
}
