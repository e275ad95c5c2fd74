//! Celestial coordinate frames: equatorial, ecliptic and galactic, and that of the built-in panorama.
//!
//! In: a frame's name. Out: [`SkyFrame`], with its rotation to ICRF. Always: the frames are those of J2000, without precession.

use crate::units::RAD_PER_ARCSEC;
use crate::wording::suggestion_or_list;
use glam::{DMat3, DVec3};

/// Mean obliquity of the ecliptic at J2000 (IAU 2006: 84381.406 arcsec), radians.
const OBLIQUITY_J2000_RAD: f64 = 84_381.406 * RAD_PER_ARCSEC;

/// A celestial coordinate frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SkyFrame {
    /// The pole is that of the Galaxy; longitude 0 is at its centre.
    #[default]
    Galactic,
    /// ICRF, which is the mean equator of J2000 within 0.02 arcsec.
    Equatorial,
    /// Mean ecliptic and equinox of J2000.
    Ecliptic,
    /// The axes of NASA's panorama "Deep Star Maps" (SVS 3895), which cannot be chosen: the galactic pole and node of 1958, which are of B1950 (Blaauw et al.
    /// 1960, MNRAS 121, 123), taken for coordinates of J2000. They are turned against the galactic axes by 50 years of precession, 0.7
    /// degrees.
    DeepStarMaps,
}

/// A frame's name is not known. Contains the nearest known name as a suggestion, or a list of all, but not the unknown name itself: clap quotes it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct UnknownSkyFrame(String);

/// Unit vector of a longitude and a latitude, such as right ascension and declination, degrees.
pub fn unit_vector(longitude_deg: f64, latitude_deg: f64) -> DVec3 {
    let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (longitude_deg.to_radians().sin_cos(), latitude_deg.to_radians().sin_cos());
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// The ecliptic's north pole of J2000, ICRF.
pub fn ecliptic_pole() -> DVec3 {
    DVec3::new(0.0, -OBLIQUITY_J2000_RAD.sin(), OBLIQUITY_J2000_RAD.cos())
}

impl SkyFrame {
    /// The frames that can be chosen.
    pub(crate) const ALL: [Self; 3] = [Self::Galactic, Self::Equatorial, Self::Ecliptic];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Galactic => "galactic",
            Self::Equatorial => "equatorial",
            Self::Ecliptic => "ecliptic",
            Self::DeepStarMaps => "deep-star-maps",
        }
    }

    /// The frame of a name, ignoring case.
    ///
    /// # Errors
    /// An unknown name: the error contains the nearest known name, or a list of all.
    pub(crate) fn by_name(name: &str) -> Result<Self, UnknownSkyFrame> {
        let known = Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(name));
        known.ok_or_else(|| UnknownSkyFrame(suggestion_or_list(name, &Self::ALL.map(Self::name))))
    }

    /// The rotation from the frame to ICRF. Its columns are the frame's axes: x towards longitude 0, z towards its north pole.
    pub fn icrf_from_frame(self) -> DMat3 {
        match self {
            // Right ascension and declination of the pole, and galactic longitude of the ascending node, degrees: ESA 1997, The Hipparcos and Tycho
            // Catalogues, vol. 1, eq. 1.5.11.
            Self::Galactic => icrf_from_galactic(unit_vector(192.859_48, 27.128_25), 32.931_92),
            Self::DeepStarMaps => icrf_from_galactic(unit_vector(192.25, 27.4), 33.0),
            Self::Equatorial => DMat3::IDENTITY,
            Self::Ecliptic => {
                let pole = ecliptic_pole();
                DMat3::from_cols(DVec3::X, pole.cross(DVec3::X), pole)
            }
        }
    }
}

/// The rotation of a galactic frame, from its pole and the longitude of the ascending node of its equator on the celestial equator.
fn icrf_from_galactic(pole: DVec3, node_longitude_deg: f64) -> DMat3 {
    let node = DVec3::Z.cross(pole).normalize();
    let (sin, cos) = node_longitude_deg.to_radians().sin_cos();
    let centre = node * cos - pole.cross(node) * sin;
    DMat3::from_cols(centre, pole.cross(centre), pole)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known directions: the Galactic centre and pole (computed from the Hipparcos catalog's constants by spherical trigonometry), the celestial pole in
    /// Galactic axes, the summer solstice, the ecliptic pole.
    #[test]
    fn frames_have_their_published_axes() {
        let off_arcsec = |frame: SkyFrame, (lon, lat): (f64, f64), (ra, dec): (f64, f64)| {
            crate::ephemeris::angle_rad(frame.icrf_from_frame() * unit_vector(lon, lat), unit_vector(ra, dec)).to_degrees() * 3600.0
        };
        for (frame, place, icrf) in [
            (SkyFrame::Galactic, (0.0, 0.0), (266.404_994_8, -28.936_174_0)),
            (SkyFrame::Galactic, (0.0, 90.0), (192.859_48, 27.128_25)),
            // The celestial pole: its longitude is that of the ascending node plus 90 degrees, its latitude the declination of the Galactic pole.
            (SkyFrame::Galactic, (122.931_92, 27.128_25), (0.0, 90.0)),
            // The obliquity of the IAU 2006, 84381.406 arcsec, and 90 degrees minus it.
            (SkyFrame::Ecliptic, (90.0, 0.0), (90.0, 23.439_279)),
            (SkyFrame::Ecliptic, (0.0, 90.0), (270.0, 66.560_721)),
            // Any direction: the axes are those of ICRF.
            (SkyFrame::Equatorial, (101.0, -16.0), (101.0, -16.0)),
        ] {
            assert!(off_arcsec(frame, place, icrf) < 0.1, "{frame:?} {place:?}: {}", off_arcsec(frame, place, icrf));
            let m = frame.icrf_from_frame();
            assert!((m.determinant() - 1.0).abs() < 1e-12 && (m * m.transpose() - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-12));
            assert_eq!(SkyFrame::by_name(&frame.name().to_uppercase()), Ok(frame));
        }
        // The centre of Blaauw et al. (1960), defined in B1950 and converted to J2000, differs by 0.33 arcseconds from that of the Hipparcos
        // constants.
        let published = off_arcsec(SkyFrame::Galactic, (0.0, 0.0), (266.405_10, -28.936_18));
        assert!((0.2..0.5).contains(&published), "{published}");
        // General precession turns the sky by 5028.796 arcsec in a century (IAU 2006).
        let panorama_from_galactic = SkyFrame::DeepStarMaps.icrf_from_frame().transpose() * SkyFrame::Galactic.icrf_from_frame();
        let trace = panorama_from_galactic.x_axis.x + panorama_from_galactic.y_axis.y + panorama_from_galactic.z_axis.z;
        let turned_arcsec = ((trace - 1.0) / 2.0).acos().to_degrees() * 3600.0;
        assert!((turned_arcsec / (0.5 * 5028.796) - 1.0).abs() < 2e-3, "{turned_arcsec}");
        assert!(SkyFrame::by_name("galactc").is_err_and(|e| e.to_string().contains("galactic")));
    }
}
