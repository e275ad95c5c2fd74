//! Motion on an ellipse that may itself change. In: mean elements and an instant, or elements with their rates. Out: a state relative to the parent, ICRF, or
//! in the frame of the elements.
//!
//! Always: 0 <= e < 1; the velocity is the derivative of the position. Omitted: all periodic perturbations; the tests of each caller measure the resulting
//! error per body.

use super::State;
use crate::catalog::MeanElements;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_CENTURY, DAYS_PER_JULIAN_YEAR, JD_J2000, SECONDS_PER_DAY};
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Eccentric anomaly (radians, within half a turn of `mean_anomaly_rad`) that solves E - e sin E = M for 0 <= e < 1, accurate to rounding.
///
/// Newton's method inside a bracket that every step narrows: E is in [M, M + e] for M in [0, π]; negative M by symmetry.
pub fn eccentric_anomaly(mean_anomaly_rad: f64, e: f64) -> f64 {
    let turns = (mean_anomaly_rad / TAU).round();
    let m = mean_anomaly_rad - turns * TAU;
    let (m_abs, sign) = (m.abs(), m.signum());
    let (mut low, mut high) = (m_abs, (m_abs + e).min(PI));
    // `x`: |E| for `m`; at first Danby's starting value. Bisection alone reaches rounding in 60 steps.
    let mut x = (m_abs + 0.85 * e).min(high);
    for _ in 0..60 {
        let f = x - e * x.sin() - m_abs;
        if f > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - f / (1.0 - e * x.cos());
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-16 * (1.0 + x) {
            x = next;
            break;
        }
        x = next;
    }
    sign * x + turns * TAU
}

/// An ellipse and the place on it, in some frame; also the rates of these elements, per second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ellipse {
    pub semi_major_axis_km: f64,
    pub eccentricity: f64,
    pub inclination_rad: f64,
    /// Longitude of the ascending node.
    pub node_rad: f64,
    pub argument_of_periapsis_rad: f64,
    pub mean_anomaly_rad: f64,
}

/// State on an ellipse that does not change, in the frame of its elements. `node_rad`: longitude of the ascending node. `mean_anomaly_rate_per_s`: radians per
/// second.
pub fn state_in_frame(
    semi_major_axis_km: f64,
    e: f64,
    inclination_rad: f64,
    node_rad: f64,
    argument_of_periapsis_rad: f64,
    mean_anomaly_rad: f64,
    mean_anomaly_rate_per_s: f64,
) -> State {
    let ellipse = Ellipse { semi_major_axis_km, eccentricity: e, inclination_rad, node_rad, argument_of_periapsis_rad, mean_anomaly_rad };
    state_on_changing_ellipse(&ellipse, &Ellipse { mean_anomaly_rad: mean_anomaly_rate_per_s, ..Ellipse::default() })
}

/// State on an ellipse in the frame of its elements, which change at the given rates.
pub fn state_on_changing_ellipse(ellipse: &Ellipse, rates: &Ellipse) -> State {
    let (a_km, e) = (ellipse.semi_major_axis_km, ellipse.eccentricity);
    let (sin_anomaly, cos_anomaly) = eccentric_anomaly(ellipse.mean_anomaly_rad, e).sin_cos();
    let axis_ratio = (1.0 - e * e).sqrt();
    let axis_ratio_rate = -e * rates.eccentricity / axis_ratio;
    // The derivative of Kepler's equation, E - e sin E = M.
    let eccentric_anomaly_rate = (rates.mean_anomaly_rad + rates.eccentricity * sin_anomaly) / (1.0 - e * cos_anomaly);
    let in_plane = DVec3::new(cos_anomaly - e, axis_ratio * sin_anomaly, 0.0) * a_km;
    // The motion along the ellipse, the change of its shape, and the change of its size.
    let in_plane_velocity = DVec3::new(-sin_anomaly, axis_ratio * cos_anomaly, 0.0) * (a_km * eccentric_anomaly_rate)
        + DVec3::new(-rates.eccentricity, axis_ratio_rate * sin_anomaly, 0.0) * a_km
        + in_plane * (rates.semi_major_axis_km / a_km);
    let to_node = DMat3::from_rotation_z(ellipse.node_rad);
    let frame_from_orbit = to_node * DMat3::from_rotation_x(ellipse.inclination_rad);
    let frame_from_plane = frame_from_orbit * DMat3::from_rotation_z(ellipse.argument_of_periapsis_rad);
    let pos_km = frame_from_plane * in_plane;
    // The ellipse rotates: about the orbit's normal with the periapsis, about the line of nodes with the inclination, about the frame's pole with the node.
    let angular_velocity = frame_from_orbit * DVec3::Z * rates.argument_of_periapsis_rad
        + to_node * DVec3::X * rates.inclination_rad
        + DVec3::Z * rates.node_rad;
    State { pos_km, vel_km_s: frame_from_plane * in_plane_velocity + angular_velocity.cross(pos_km) }
}

/// Rotation from the frame whose pole is given (x axis at the pole's right ascension + 90 degrees) to ICRF.
pub fn icrf_from_pole_frame(pole_ra_deg: f64, pole_dec_deg: f64) -> DMat3 {
    DMat3::from_rotation_z((pole_ra_deg + 90.0).to_radians()) * DMat3::from_rotation_x((90.0 - pole_dec_deg).to_radians())
}

/// State relative to the parent, ICRF, from a catalog's mean elements.
///
/// The node regresses for inclinations under 90 degrees and advances above; the argument of the periapsis advances. The catalog's mean motion n is
/// the rate of the mean longitude at the epoch. So the rate of the anomaly at the epoch is n - argument' - node' in a prograde orbit and n - argument' + node'
/// in a retrograde one (a prime means a rate). A tidal term in T² is added to the anomaly, and so to the longitude.
pub fn state(elements: &MeanElements, t: Instant) -> State {
    // The few milliseconds between TDB and TT are neglected.
    let days = t.tdb_seconds_past_j2000() / SECONDS_PER_DAY - (elements.epoch_jd_tt - JD_J2000);
    // A period of 0 stands for no precession.
    let rate_deg_day = |period_yr: f64| if period_yr == 0.0 { 0.0 } else { 360.0 / (period_yr * DAYS_PER_JULIAN_YEAR) };
    let is_retrograde = elements.inclination_deg > 90.0;
    let node_rate_deg_day = if is_retrograde { rate_deg_day(elements.node_period_yr) } else { -rate_deg_day(elements.node_period_yr) };
    let argument_rate_deg_day = rate_deg_day(elements.argument_period_yr);
    // The mean longitude is node + argument + anomaly; in a retrograde orbit the node is subtracted.
    let anomaly_rate_at_epoch_deg_day =
        elements.mean_motion_deg_day - argument_rate_deg_day + if is_retrograde { node_rate_deg_day } else { -node_rate_deg_day };
    let (quadratic_deg_cy2, centuries) = (elements.longitude_quadratic_deg_cy2, days / DAYS_PER_JULIAN_CENTURY);
    let anomaly_rate_deg_day = anomaly_rate_at_epoch_deg_day + 2.0 * quadratic_deg_cy2 * centuries / DAYS_PER_JULIAN_CENTURY;
    let anomaly_change_deg = anomaly_rate_at_epoch_deg_day * days + quadratic_deg_cy2 * centuries * centuries;
    let ellipse = Ellipse {
        semi_major_axis_km: elements.semi_major_axis_km,
        eccentricity: elements.eccentricity,
        inclination_rad: elements.inclination_deg.to_radians(),
        node_rad: (elements.node_deg + node_rate_deg_day * days).to_radians(),
        argument_of_periapsis_rad: (elements.argument_of_periapsis_deg + argument_rate_deg_day * days).to_radians(),
        mean_anomaly_rad: ((elements.mean_anomaly_deg + anomaly_change_deg) % 360.0).to_radians(),
    };
    let rad_s = |deg_day: f64| (deg_day / SECONDS_PER_DAY).to_radians();
    let rates = Ellipse {
        node_rad: rad_s(node_rate_deg_day),
        argument_of_periapsis_rad: rad_s(argument_rate_deg_day),
        mean_anomaly_rad: rad_s(anomaly_rate_deg_day),
        ..Ellipse::default()
    };
    let state = state_on_changing_ellipse(&ellipse, &rates);
    let icrf_from_frame = icrf_from_pole_frame(elements.pole_ra_deg, elements.pole_dec_deg);
    State { pos_km: icrf_from_frame * state.pos_km, vel_km_s: icrf_from_frame * state.vel_km_s }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kepler_equation_holds_for_every_eccentricity() {
        for e in [0.0, 1e-9, 0.01, 0.3, 0.7, 0.97, 0.999, 0.999_999, 1.0 - 1e-12] {
            for i in -200..=200 {
                let m = f64::from(i) * 0.05 + 1e-7;
                let x = eccentric_anomaly(m, e);
                assert!((x - e * x.sin() - m).abs() < 4e-15 * (1.0 + m.abs()), "e {e} M {m}: {x}");
            }
            assert!(eccentric_anomaly(0.0, e).abs() < 1e-15);
        }
    }

    fn elements(inclination_deg: f64) -> MeanElements {
        MeanElements {
            pole_ra_deg: 268.1,
            pole_dec_deg: 64.5,
            epoch_jd_tt: 2_451_545.0,
            semi_major_axis_km: 421_800.0,
            eccentricity: 0.2,
            inclination_deg,
            node_deg: 40.0,
            argument_of_periapsis_deg: 80.0,
            mean_anomaly_deg: 340.0,
            mean_motion_deg_day: 203.5,
            node_period_yr: 0.7,
            argument_period_yr: 0.4,
            longitude_quadratic_deg_cy2: 12.7,
        }
    }

    /// Each element in turn changes, and then all of them.
    #[test]
    fn velocity_includes_the_rate_of_every_element() {
        let ellipse = [4e5, 0.2, 0.3, 0.7, 1.4, 5.9];
        let rates = [2.0, 1e-5, 2e-5, -3e-5, 4e-5, 5e-5];
        let of = |e: [f64; 6]| Ellipse {
            semi_major_axis_km: e[0],
            eccentricity: e[1],
            inclination_rad: e[2],
            node_rad: e[3],
            argument_of_periapsis_rad: e[4],
            mean_anomaly_rad: e[5],
        };
        for changing in (0..6).map(|k| k..k + 1).chain(std::iter::once(0..6)) {
            let rates: [f64; 6] = std::array::from_fn(|k| if changing.contains(&k) { rates[k] } else { 0.0 });
            let at = |s: f64| state_on_changing_ellipse(&of(std::array::from_fn(|k| ellipse[k] + rates[k] * s)), &of(rates));
            let slope = (at(1.0).pos_km - at(-1.0).pos_km) / 2.0;
            assert!(slope.length() > 1.0, "{changing:?}");
            assert!((slope - at(0.0).vel_km_s).length() < 1e-7, "{changing:?}: {slope} {}", at(0.0).vel_km_s);
        }
    }

    #[test]
    fn velocity_is_the_slope_of_position() {
        for inclination in [3.0, 157.0] {
            let e = elements(inclination);
            for days in [0.0, 0.3, 777.7, -40_000.0] {
                let at = |s: f64| state(&e, Instant::from_tdb_seconds_past_j2000(days * SECONDS_PER_DAY + s));
                let slope = (at(1.0).pos_km - at(-1.0).pos_km) / 2.0;
                // At 110 years an instant is rounded to 0.5 microseconds.
                assert!((slope - at(0.0).vel_km_s).length() < 1e-5, "{inclination} {days}: {slope} {}", at(0.0).vel_km_s);
                assert!((slope - at(900.0).vel_km_s).length() > 1e-3, "the velocity of 15 minutes later must not pass");
            }
        }
    }
}
