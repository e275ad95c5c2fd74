//! The planets on slowly changing ellipses for 3000 BC to AD 3000: the elements and rates of E. M. Standish, "Keplerian elements for approximate
//! positions of the major planets" (JPL), tables 2a and 2b.
//!
//! In: a planet's barycentre and an instant. Out: a heliocentric state, ICRF. [`error_km`] bounds the position's error.

use super::two_body::{Ellipse, state_on_changing_ellipse};
use super::{State, frames};
use crate::units::{DAYS_PER_JULIAN_CENTURY, DAYS_PER_JULIAN_YEAR, KM_PER_AU, SECONDS_PER_DAY};

const CENTURY_S: f64 = DAYS_PER_JULIAN_CENTURY * SECONDS_PER_DAY;

/// The ellipse of one planet, relative to the ecliptic and equinox of J2000.
struct MeanElements {
    /// a (au), e, then degrees: inclination, mean longitude, longitude of perihelion, longitude of the ascending node.
    at_j2000: [f64; 6],
    /// Their rates per Julian century.
    rates: [f64; 6],
    /// b, c, s and f of b T² + c cos(f T) + s sin(f T), in degrees with T in Julian centuries from J2000, which is added to the mean anomaly.
    anomaly_terms: [f64; 4],
}

/// By the NAIF codes of the barycentres, 1 to 9.
#[rustfmt::skip]
const PLANETS: [MeanElements; 9] = [
    // Mercury.
    MeanElements { at_j2000: [0.38709843, 0.20563661, 7.00559432, 252.25166724, 77.45771895, 48.33961819],
                   rates: [0.0, 0.00002123, -0.00590158, 149472.67486623, 0.15940013, -0.12214182],
                   anomaly_terms: [0.0; 4] },
    // Venus.
    MeanElements { at_j2000: [0.72332102, 0.00676399, 3.39777545, 181.97970850, 131.76755713, 76.67261496],
                   rates: [-0.00000026, -0.00005107, 0.00043494, 58517.81560260, 0.05679648, -0.27274174],
                   anomaly_terms: [0.0; 4] },
    // Earth-Moon barycentre.
    MeanElements { at_j2000: [1.00000018, 0.01673163, -0.00054346, 100.46691572, 102.93005885, -5.11260389],
                   rates: [-0.00000003, -0.00003661, -0.01337178, 35999.37306329, 0.31795260, -0.24123856],
                   anomaly_terms: [0.0; 4] },
    // Mars.
    MeanElements { at_j2000: [1.52371243, 0.09336511, 1.85181869, -4.56813164, -23.91744784, 49.71320984],
                   rates: [0.00000097, 0.00009149, -0.00724757, 19140.29934243, 0.45223625, -0.26852431],
                   anomaly_terms: [0.0; 4] },
    // Jupiter.
    MeanElements { at_j2000: [5.20248019, 0.04853590, 1.29861416, 34.33479152, 14.27495244, 100.29282654],
                   rates: [-0.00002864, 0.00018026, -0.00322699, 3034.90371757, 0.18199196, 0.13024619],
                   anomaly_terms: [-0.00012452, 0.06064060, -0.35635438, 38.35125000] },
    // Saturn.
    MeanElements { at_j2000: [9.54149883, 0.05550825, 2.49424102, 50.07571329, 92.86136063, 113.63998702],
                   rates: [-0.00003065, -0.00032044, 0.00451969, 1222.11494724, 0.54179478, -0.25015002],
                   anomaly_terms: [0.00025899, -0.13434469, 0.87320147, 38.35125000] },
    // Uranus.
    MeanElements { at_j2000: [19.18797948, 0.04685740, 0.77298127, 314.20276625, 172.43404441, 73.96250215],
                   rates: [-0.00020455, -0.00001550, -0.00180155, 428.49512595, 0.09266985, 0.05739699],
                   anomaly_terms: [0.00058331, -0.97731848, 0.17689245, 7.67025000] },
    // Neptune.
    MeanElements { at_j2000: [30.06952752, 0.00895439, 1.77005520, 304.22289287, 46.68158724, 131.78635853],
                   rates: [0.00006447, 0.00000818, 0.00022400, 218.46515314, 0.01009938, -0.00606302],
                   anomaly_terms: [-0.00041348, 0.68346318, -0.10162547, 7.67025000] },
    // Pluto.
    MeanElements { at_j2000: [39.48686035, 0.24885238, 17.14104260, 238.96535011, 224.09702598, 110.30167986],
                   rates: [0.00449751, 0.00006016, 0.00000501, 145.18042903, -0.00968827, -0.00809981],
                   anomaly_terms: [-0.01262724, 0.0, 0.0, 0.0] },
];

/// NAIF codes of the systems of Jupiter, Saturn, Uranus and Neptune, with the ratio of the Sun's mass to theirs (DE440).
const SUN_MASS_OVER_GIANTS: [(i32, f64); 4] = [(5, 1_047.348_6), (6, 3497.898), (7, 22_902.98), (8, 19_412.24)];

/// NAIF code of the body or barycentre relative to which mean elements, and the series of `series` except Pluto's, give the position of `target`; `None` for
/// another target.
pub fn origin_of(target: i32) -> Option<i32> {
    match target {
        // The planets' barycentres: relative to the Sun. The Sun: to the barycentre of the solar system.
        1..=9 => Some(10),
        10 => Some(0),
        // The Moon: relative to the Earth. The Earth: to the Earth-Moon barycentre.
        301 => Some(399),
        399 => Some(3),
        // Mercury and Venus: to their own barycentres.
        199 | 299 => Some(target / 100),
        _ => None,
    }
}

/// Heliocentric state of the barycentre with the NAIF code `1..=9`, ICRF; `None` for another code. `tdb_s`: TDB seconds past J2000, here and below.
pub fn planet(barycentre: i32, tdb_s: f64) -> Option<State> {
    let MeanElements { at_j2000, rates, anomaly_terms } = PLANETS.get(usize::try_from(barycentre).ok()?.checked_sub(1)?)?;
    let t = tdb_s / CENTURY_S;
    let [b, c, s, f] = *anomaly_terms;
    let angle_rad = (f * t).to_radians();
    let (sin, cos) = angle_rad.sin_cos();
    // The ellipse with these elements in the order of the tables, and these degrees added to its mean anomaly.
    let ellipse = |[a_au, e, inclination_deg, longitude_deg, perihelion_deg, node_deg]: [f64; 6], anomaly_deg: f64| Ellipse {
        semi_major_axis_km: a_au * KM_PER_AU,
        eccentricity: e,
        inclination_rad: inclination_deg.to_radians(),
        node_rad: node_deg.to_radians(),
        argument_of_periapsis_rad: (perihelion_deg - node_deg).to_radians(),
        mean_anomaly_rad: ((longitude_deg - perihelion_deg + anomaly_deg) % 360.0).to_radians(),
    };
    let state = state_on_changing_ellipse(
        &ellipse(std::array::from_fn(|i| at_j2000[i] + rates[i] * t), b * t * t + c * cos + s * sin),
        // The derivatives, per second; the mean anomaly moves by less than a turn in one.
        &ellipse(rates.map(|r| r / CENTURY_S), (2.0 * b * t + (s * cos - c * sin) * f.to_radians()) / CENTURY_S),
    );
    let icrf_from_ecliptic = frames::icrf_from_ecliptic();
    Some(State { pos_km: icrf_from_ecliptic * state.pos_km, vel_km_s: icrf_from_ecliptic * state.vel_km_s })
}

/// The Sun's barycentric state, from the four giant planets. Left out: the inner planets, which move the Sun by up to 800 km.
pub fn sun(tdb_s: f64) -> State {
    let mut barycentric = State::REST;
    // Masses in units of the Sun's.
    let total_mass: f64 = 1.0 + SUN_MASS_OVER_GIANTS.iter().map(|(_, ratio)| 1.0 / ratio).sum::<f64>();
    for (giant, ratio) in SUN_MASS_OVER_GIANTS {
        let Some(state) = planet(giant, tdb_s) else { continue };
        // The Sun is displaced away from the giant, by the giant's share of the total mass.
        let fraction = -1.0 / (ratio * total_mass);
        barycentric = barycentric.plus(State { pos_km: state.pos_km * fraction, vel_km_s: state.vel_km_s * fraction });
    }
    barycentric
}

/// Up to this many years before and after J2000 the error bounds of mean elements and of series (`series`) are constant. They were measured from 448 years
/// before J2000 to 646 years after.
pub const CONSTANT_ERROR_YEARS: f64 = 640.0;

/// Upper limit of the error, in km, of a position relative to [`origin_of`] the target: the largest difference from DE440 at 4000 dates over 1552-2646, as
/// `examples/measure_ephemeris.rs` prints it, rounded up. More than [`CONSTANT_ERROR_YEARS`] from J2000 the limit grows linearly with time;
/// tests/ephemeris/positions.rs verifies this growth for the planets against VSOP87 from 3000 BC to AD 3000.
pub fn error_km(target: i32, tdb_s: f64) -> f64 {
    // Keyed by NAIF code: barycentres 1 to 9, the Sun 10, the Moon 301, the Earth 399.
    let worst_km = match target {
        1 => 8_000.0,
        2 => 34_000.0,
        3 => 36_000.0,
        4 => 190_000.0,
        5 => 2.7e6,
        6 => 9.8e6,
        7 => 16.2e6,
        8 => 7.7e6,
        9 => 10.6e6,
        10 => 4_300.0,
        301 => 3_000.0,
        399 => 36.0,
        // Mercury (199) and Venus (299) coincide with their barycentres: a nominal bound.
        _ => 0.001,
    };
    worst_km * (tdb_s / (CONSTANT_ERROR_YEARS * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY)).abs().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 3000 BC to AD 3000, the years of the tables.
    #[test]
    fn velocities_are_slopes_of_positions() {
        for (barycentre, elements) in (1..).zip(&PLANETS) {
            // A step in which the planet moves by 3e-4 radians. The central difference is then accurate to some 4e-8.
            let step_s = 3e-4 * CENTURY_S / elements.rates[3].to_radians();
            for k in 0..=240 {
                let tdb_s = (-50.0 + 0.25 * f64::from(k)) * CENTURY_S;
                let at = |offset_s: f64| planet(barycentre, tdb_s + offset_s).expect("a planet");
                let (before, after) = (at(-step_s), at(step_s));
                let slope = (after.pos_km - before.pos_km) / (2.0 * step_s);
                let error = (slope - at(0.0).vel_km_s).length() / slope.length();
                assert!(error < 1e-6, "{barycentre}, {} centuries: {error:e}", tdb_s / CENTURY_S);
                // The velocity of a tenth of the step later would not pass.
                assert!(
                    (at(0.1 * step_s).vel_km_s - slope).length() / slope.length() > 1e-6,
                    "{barycentre}, {} centuries",
                    tdb_s / CENTURY_S
                );
            }
        }
        for centuries in [-50.0, -12.3, 0.0, 10.0] {
            let (tdb_s, step_s) = (centuries * CENTURY_S, 1e5);
            let slope = (sun(tdb_s + step_s).pos_km - sun(tdb_s - step_s).pos_km) / (2.0 * step_s);
            let error = (slope - sun(tdb_s).vel_km_s).length() / slope.length();
            assert!(error < 1e-5, "{centuries} centuries: {error:e}");
        }
    }
}
