//! Facts about the star that was clicked or found: catalog values, and quantities derived from them.
//!
//! In: a star of the catalog, and the time since the catalog's epoch. Out: its name, a title, a table. Always: a quantity that the catalog does not
//! determine has no row, or a note in place of its value.

use super::fact;
use crate::catalog::stars::{Star, star_name};
use crate::ephemeris::apparent::RaDec;
use crate::ephemeris::star_place::star_from_viewer;
use crate::scene::sky::temperature_k;
use crate::units::RAD_PER_ARCSEC;
use crate::view::language::numbers::localised;
use crate::view::language::{decimal, signed, text};
use egui::Grid;
use glam::DVec3;

/// Light years in a parsec: the parsec of IAU 2015 Resolution B2, and the light year of 365.25 days.
const LIGHT_YEARS_PER_PARSEC: f64 = 3.261_564;
/// Smallest parallax from which a distance is computed, milliarcseconds: about the standard error of Hipparcos parallaxes.
const MIN_PARALLAX_MAS: f64 = 1.0;

/// The star's proper name and Hipparcos number, as far as the star has them. The catalog gives stars without a number the number 0.
pub(super) fn name(star: &Star) -> String {
    match (star_name(star.hip), star.hip) {
        (Some(name), hip) => format!("{name} (HIP {hip})"),
        (None, 0) => text!("star-unnumbered").into(),
        (None, hip) => format!("HIP {hip}"),
    }
}

/// The star's name and magnitude in one line.
pub(super) fn title(star: &Star) -> String {
    text!("star-title", star = name(star), magnitude = decimal(star.v_magnitude, 2))
}

/// The facts as pairs of label and value.
fn label_value_pairs(star: &Star, years_since_epoch: f64) -> Vec<(&'static str, String)> {
    let mut facts = vec![(text!("star-magnitude-v"), signed(star.v_magnitude, 2))];
    if let Some(b_v) = star.b_v {
        facts.push((text!("star-colour-index"), signed(b_v, 3)));
        let kelvin = temperature_k(f64::from(b_v));
        // The temperature that follows from a colour index is accurate to a few per cent at best, and to ten per cent for hot stars, so it is rounded.
        let rounding_k = if kelvin < 10_000.0 { 50.0 } else { 500.0 };
        facts.push((
            text!("star-temperature"),
            text!("star-temperature-value", kelvin = decimal((kelvin / rounding_k).round() * rounding_k, 0)),
        ));
    }
    let parallax_mas = star.parallax_rad / RAD_PER_ARCSEC * 1e3;
    if parallax_mas >= MIN_PARALLAX_MAS {
        let parsecs = 1e3 / parallax_mas;
        facts.push((text!("star-parallax"), format!("{} mas", decimal(parallax_mas, 2))));
        facts.push((
            text!("fact-distance"),
            text!("star-distance", years = decimal(parsecs * LIGHT_YEARS_PER_PARSEC, 1), parsecs = decimal(parsecs, 1)),
        ));
        facts.push((text!("star-absolute-magnitude"), signed(f64::from(star.v_magnitude) + 5.0 - 5.0 * parsecs.log10(), 2)));
    } else {
        facts.push((text!("fact-distance"), text!("star-too-far").into()));
    }
    // Unit vectors to the east and to the north at the star.
    let east = DVec3::Z.cross(star.direction).normalize_or_zero();
    let north = star.direction.cross(east);
    let motion_mas_per_year = |axis: DVec3| star.motion_per_year.dot(axis) / RAD_PER_ARCSEC * 1e3;
    let (east_mas_per_year, north_mas_per_year) = (motion_mas_per_year(east), motion_mas_per_year(north));
    let position_angle_deg = east_mas_per_year.atan2(north_mas_per_year).to_degrees().rem_euclid(360.0);
    facts.push((
        text!("star-proper-motion"),
        text!(
            "star-proper-motion-value",
            mas = decimal(east_mas_per_year.hypot(north_mas_per_year), 1),
            angle_deg = decimal(position_angle_deg, 0)
        ),
    ));
    // The place at the displayed time, as seen from the solar system's barycentre, that is, without annual parallax.
    let place = RaDec::of(star_from_viewer(star, years_since_epoch, DVec3::ZERO));
    facts.push((text!("fact-right-ascension"), text!("star-right-ascension-value", angle = localised(place.ra_text()))));
    facts.push((text!("fact-declination"), localised(place.dec_text())));
    facts
}

/// Shows the star's name, and its facts as a table. `years_since_epoch`: from the star catalog's epoch to the displayed time; `more_rows`: adds rows to the
/// table.
pub(super) fn facts(ui: &mut egui::Ui, star: &Star, years_since_epoch: f64, more_rows: impl FnOnce(&mut egui::Ui)) {
    ui.strong(name(star));
    Grid::new("star").num_columns(2).striped(true).show(ui, |ui| {
        for (label, value) in label_value_pairs(star, years_since_epoch) {
            fact::row(ui, label, value);
        }
        more_rows(ui);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::stars::StarCatalog;

    /// Sirius: 8.6 light years, absolute magnitude 1.45, 1339 mas a year towards 204 degrees, 9940 K (Gray & Corbally 2009 and SIMBAD; the
    /// temperature computed from the colour index is correct within 6 %).
    #[test]
    fn sirius_has_the_published_facts() {
        let stars = StarCatalog::embedded();
        let sirius = stars.star_of_hip(32_349).expect("Sirius");
        assert_eq!(title(sirius), "Sirius (HIP 32349), magnitude -1.44");
        // From the epoch of the catalog, 1991.25, to J2000.
        let facts = label_value_pairs(sirius, 8.75);
        let fact = |label: &str| facts.iter().find(|(l, _)| *l == label).map(|(_, value)| value.clone()).expect(label);
        assert!(fact("distance").starts_with("8.6 light years (2.6 pc)"), "{}", fact("distance"));
        assert_eq!(fact("absolute magnitude"), "+1.45");
        assert!(fact("proper motion").starts_with("1339.4 mas a year towards 204°"), "{}", fact("proper motion"));
        let kelvin: f64 = fact("temperature").split_whitespace().nth(1).and_then(|k| k.parse().ok()).expect("a number");
        assert!((kelvin / 9_940.0 - 1.0).abs() < 0.06, "{kelvin}");
        // J2000: 6h 45m 08.9s, -16 deg 42' 58.0".
        assert!(fact("right ascension").starts_with("6h 45m 08.9s") && fact("declination").starts_with("-16° 42′ 58.0″"), "{facts:?}");
    }

    #[test]
    fn unmeasured_facts_are_omitted() {
        let far = StarCatalog::parse("one", "ra_deg,dec_deg,v_mag\n10,90,5\n").expect("a star");
        let star = &far.stars()[0];
        assert_eq!(title(star), "Star without a Hipparcos number, magnitude 5.00");
        let facts = label_value_pairs(star, 0.0);
        assert!(facts.iter().all(|(label, _)| !["temperature", "parallax", "absolute magnitude"].contains(label)), "{facts:?}");
        assert!(facts.iter().all(|(_, value)| !value.contains("NaN")), "{facts:?}");
    }
}
