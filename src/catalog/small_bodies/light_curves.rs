//! Light curves of well-known comets, in place of the magnitudes of the orbital catalog.
//!
//! In: the embedded comets and the embedded table of light curves. Out: the comets with its brightness laws. The orbital catalog's M1 and K1 stand for what
//! astrometric images show, up to seven magnitudes fainter than observers saw.

use super::{BrightnessLaw, ORDINARY_DUST_TO_GAS, SmallBody};

/// Sets the brightness laws of the comets that the table names.
///
/// # Panics
/// The embedded table is broken. A test verifies that it is not.
pub(super) fn add_to(comets: &mut [SmallBody]) {
    for line in orrery_catalogs::COMET_LIGHT_CURVES.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let broken = |what: &str| -> ! { panic!("comet_light_curves.csv: {what} in `{line}`") };
        let cells: Vec<&str> = line.split(',').collect();
        let [name, m1, k1, m1_after, k1_after, dust_to_gas, ..] = cells[..] else { broken("too few values") };
        let Some(comet) = comets.iter_mut().find(|comet| comet.name == name) else { broken("no such comet") };
        let number = |cell: &str| cell.parse::<f64>().unwrap_or_else(|_| broken("no number"));
        let dust_to_gas = if dust_to_gas.is_empty() { ORDINARY_DUST_TO_GAS } else { number(dust_to_gas) };
        let law = |m1: &str, k1: &str| BrightnessLaw::Comet { m1: number(m1), k1: number(k1), dust_to_gas };
        comet.brightness = law(m1, k1);
        if !m1_after.is_empty() {
            comet.known.get_or_insert_default().brightness_after_perihelion = Some(law(m1_after, k1_after));
        }
    }
}
