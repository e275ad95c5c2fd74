//! Orientation of bodies: `body_from_icrf` rotations.
//!
//! In: pole and meridian of a body, an orbit, or for the Earth an instant. Out: a rotation whose rows are the body's axes in ICRF (z the north pole, x the
//! prime meridian). Sources: the IAU WGCCRE 2015 models in catalogs/pck00011.tpc; for the Earth, IAU 2006 precession and IAU 2000A nutation (crate sofars) with
//! UT1. Omitted: polar motion (under 0.5 arcsec, 15 m on the ground) and the Moon's physical libration beyond the IAU series (0.01 degrees).

mod pck;

pub use pck::{Pck, PckError, PoleAndMeridian};

use super::time_grid::TimeGrid;
use crate::time::Instant;
use crate::units::JD_J2000;
use glam::{DMat3, DVec3};

/// The PCK (text file of SPICE with poles and meridians of bodies) that is embedded in the program.
pub use orrery_catalogs::PLANETARY_CONSTANTS as EMBEDDED_PCK;

/// Right-handed rotation of the axes by `angle_rad` about z: R3 of the literature.
fn r3(angle_rad: f64) -> DMat3 {
    DMat3::from_rotation_z(-angle_rad)
}

/// Right-handed rotation of the axes by `angle_rad` about x: R1 of the literature.
fn r1(angle_rad: f64) -> DMat3 {
    DMat3::from_rotation_x(-angle_rad)
}

impl PoleAndMeridian {
    /// R3(W) R1(90° - dec) R3(90° + ra), as WGCCRE defines it.
    pub fn body_from_icrf(&self) -> DMat3 {
        r3(self.w_deg.to_radians()) * r1((90.0 - self.pole_dec_deg).to_radians()) * r3((90.0 + self.pole_ra_deg).to_radians())
    }

    /// The three angles of a rotation, for display; right ascension and W from 0 to 360 degrees. For a pole along ICRF z, right ascension is 0.
    pub fn of(body_from_icrf: &DMat3) -> Self {
        let pole = body_from_icrf.row(2);
        // Ascending node of the body's equator on the ICRF equator.
        let node = DVec3::Z.cross(pole).try_normalize().unwrap_or(DVec3::Y);
        let node_in_body = *body_from_icrf * node;
        Self {
            pole_ra_deg: (-node.x).atan2(node.y).to_degrees().rem_euclid(360.0),
            pole_dec_deg: pole.z.atan2(pole.truncate().length()).to_degrees(),
            w_deg: (-node_in_body.y).atan2(node_in_body.x).to_degrees().rem_euclid(360.0),
        }
    }
}

/// The Earth's rotation from GCRS (axes of the ICRF) to ITRS (axes fixed to the Earth) by IAU 2006/2000A and UT1, without polar motion.
pub fn earth_itrs_from_gcrs(t: Instant) -> DMat3 {
    itrs_from_gcrs_via(&intermediate_from_gcrs(t), t)
}

/// The rotation from GCRS to the celestial intermediate reference system, by rows: z towards the celestial pole, x towards the origin of right ascension on
/// its equator (CIO). Unlike the Earth's rotation angle, it changes slowly, by precession and nutation only.
fn intermediate_from_gcrs(t: Instant) -> [[f64; 3]; 3] {
    sofars::pnp::c2i06a(JD_J2000, t.jd_tt() - JD_J2000)
}

/// The rotation from GCRS to ITRS, from the matrix of [`intermediate_from_gcrs`] and the Earth's rotation angle.
fn itrs_from_gcrs_via(intermediate_from_gcrs: &[[f64; 3]; 3], t: Instant) -> DMat3 {
    let days_tt = t.jd_tt() - JD_J2000;
    let angle_rad = sofars::erst::era00(JD_J2000, t.jd_ut1() - JD_J2000);
    // `sofars` keeps SOFA's names: `pom00` makes the matrix of polar motion, `sp00` the TIO locator s', `c2tcio` the product of all three rotations. Of polar
    // motion only s' is used: the pole's coordinates are taken as 0.
    let polar_motion = sofars::pnp::pom00(0.0, 0.0, sofars::pnp::sp00(JD_J2000, days_tt));
    DMat3::from_cols_array_2d(&sofars::pnp::c2tcio(intermediate_from_gcrs, angle_rad, &polar_motion)).transpose()
}

/// Spacing of the instants at which [`intermediate_from_gcrs`] sums nutation's 1400 terms, seconds. Between them its matrix is interpolated linearly, with an
/// error of step²/8 times the second derivative. The fortnightly term (0.09 arcsec in X, a coordinate of the pole) contributes most of it: 1e-13 rad.
const POLE_STEP_S: f64 = 240.0;

/// Computes [`earth_itrs_from_gcrs`] with a cache of the matrices of `intermediate_from_gcrs`. The grid has one function only, hence the key `()`.
#[derive(Debug)]
pub struct EarthRotation(TimeGrid<(), [[f64; 3]; 3]>);

impl Default for EarthRotation {
    fn default() -> Self {
        Self(TimeGrid::new(POLE_STEP_S))
    }
}

impl EarthRotation {
    /// As [`earth_itrs_from_gcrs`], with an interpolated pole; `POLE_STEP_S` states the error.
    pub(crate) fn itrs_from_gcrs(&self, t: Instant) -> DMat3 {
        let at_node = |tdb_s| intermediate_from_gcrs(Instant::from_tdb_seconds_past_j2000(tdb_s));
        let ([a, b], weight) = self.0.values_around((), t.tdb_seconds_past_j2000(), at_node);
        let interpolated = std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + (b[i][j] - a[i][j]) * weight));
        itrs_from_gcrs_via(&interpolated, t)
    }
}

/// Rotation from GCRS to the true equator and equinox of date (bias, precession and nutation).
pub fn true_of_date_from_gcrs(t: Instant) -> DMat3 {
    let rows = sofars::pnp::pnm06a(JD_J2000, t.jd_tt() - JD_J2000);
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// Rotation (`body_from_icrf`) of a tidally locked body: x towards the parent, z along the orbit's normal. `pos_km`, `vel_km_s`: of the body relative to the
/// parent, ICRF. `None` for a radial orbit.
pub fn synchronous(pos_km: DVec3, vel_km_s: DVec3) -> Option<DMat3> {
    let x = (-pos_km).try_normalize()?;
    let z = pos_km.cross(vel_km_s).try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;

    #[test]
    fn the_embedded_pck_parses_and_has_the_main_bodies() {
        let pck = Pck::parse(EMBEDDED_PCK).expect("the shipped PCK parses");
        // NAIF ids: 10 the Sun, those with 99 planets and Pluto, the other three-digit ones moons; at the end Ceres and Vesta.
        for body in [10, 199, 299, 399, 301, 499, 401, 599, 501, 699, 606, 799, 899, 801, 999, 901, 2_000_001, 2_000_004] {
            assert!(pck.pole_and_meridian(NaifId(body), 0.0).is_some(), "{body}");
        }
    }

    #[test]
    fn angles_and_matrix_round_trip() {
        let jupiter = PoleAndMeridian { pole_ra_deg: 317.7, pole_dec_deg: 52.9, w_deg: 176.6 };
        let m = jupiter.body_from_icrf();
        assert!((m.determinant() - 1.0).abs() < 1e-12);
        let back = PoleAndMeridian::of(&m);
        assert!(
            (back.pole_ra_deg - 317.7).abs() < 1e-9 && (back.pole_dec_deg - 52.9).abs() < 1e-9 && (back.w_deg - 176.6).abs() < 1e-9,
            "{back:?}"
        );
    }

    #[test]
    fn the_interpolated_pole_agrees_with_the_exact_one() {
        let largest_rad = |step_s: f64| {
            let rotation = EarthRotation(TimeGrid::new(step_s));
            // Every 89 days over 98 years, at changing places between two nodes.
            let difference_rad = |k: i32| {
                let t = Instant::from_tdb_seconds_past_j2000(f64::from(k) * 7.7e6 + 0.4 * step_s);
                let (cached, exact) = (rotation.itrs_from_gcrs(t), earth_itrs_from_gcrs(t));
                (0..3).map(|row| (cached.row(row) - exact.row(row)).length()).fold(0.0, f64::max)
            };
            (-200..200).map(difference_rad).fold(0.0, f64::max)
        };
        assert!(largest_rad(POLE_STEP_S) < 1e-12, "{} rad", largest_rad(POLE_STEP_S));
        assert!(largest_rad(300.0 * POLE_STEP_S) > 1e-12, "a grid 300 times as coarse exceeds the bound");
    }

    #[test]
    fn a_locked_moon_shows_one_face() {
        let m = synchronous(DVec3::new(4e5, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.2)).expect("an orbit");
        assert!((m * DVec3::NEG_X - DVec3::X).length() < 1e-12);
        assert!(synchronous(DVec3::X, DVec3::X).is_none());
    }
}
