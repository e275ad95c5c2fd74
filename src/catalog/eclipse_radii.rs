//! The radii of the Sun and the Moon for the computation of eclipses.
//!
//! In: a convention ([`EclipseRadii`]). Out: the catalog with the convention's two radii, so that images, shadows, contact times and queries use the same
//! values. The convention changes the length of totality by seconds: on 2024-04-08 the IAU's radii, with a Moon 0.75 km larger than the almanacs', give 4 s
//! more totality and an umbra 3 km wider.
//! Not here: the Moon's limb profile, which shifts contacts by further seconds.

use super::{Catalog, NaifId};
use crate::message::{Message, message};
use crate::units::KM_PER_AU;
use glam::DVec3;

/// The Earth's equatorial radius (WGS 84), the unit of k.
const ALMANAC_EARTH_RADIUS_KM: f64 = 6378.137;
/// k, the ratio of the Moon's radius to the Earth's, for the umbra. It is smaller than k of the mean limb, because sunlight still passes through the
/// valleys of the limb when the mean limb covers the Sun.
const K_UMBRA: f64 = 0.272_281;
/// k of the mean limb, for the penumbra.
const K_PENUMBRA: f64 = 0.272_488;
/// The Sun's semidiameter at 1 au, arcseconds (Auwers 1891), the value that almanacs adopted.
const ALMANAC_SUN_SEMIDIAMETER_ARCSEC: f64 = 959.63;

/// A convention on the radii of the Sun and the Moon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EclipseRadii {
    /// The catalog's own radii: the Sun by IAU 2015 Resolution B3, the Moon's mean radius by IAU WGCCRE 2015.
    #[default]
    Iau,
    /// NASA's canons of eclipses (Espenak and Meeus 2006, NASA/TP-2006-214141): k = 0.272281 for the umbra, 0.272488 for the penumbra.
    Almanac,
}

impl EclipseRadii {
    /// Both conventions.
    pub const ALL: [Self; 2] = [Self::Iau, Self::Almanac];

    /// The name in options and links.
    pub fn name(self) -> &'static str {
        match self {
            Self::Iau => "iau",
            Self::Almanac => "almanac",
        }
    }

    /// The convention with a name, in upper or lower case.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|r| r.name().eq_ignore_ascii_case(name))
    }

    /// Radii of the Sun and the Moon, in this order, that replace the catalog's; `None`: the catalog's radii stay.
    pub(crate) fn replacement_km(self) -> Option<(f64, f64)> {
        match self {
            Self::Iau => None,
            Self::Almanac => {
                Some((KM_PER_AU * (ALMANAC_SUN_SEMIDIAMETER_ARCSEC / 3600.0).to_radians().sin(), K_UMBRA * ALMANAC_EARTH_RADIUS_KM))
            }
        }
    }

    /// The Moon's radius for the penumbra (first and last contact) divided by its radius for the umbra, which images use, too.
    pub fn penumbral_moon_ratio(self) -> f64 {
        match self {
            Self::Iau => 1.0,
            Self::Almanac => K_PENUMBRA / K_UMBRA,
        }
    }
}

impl Catalog {
    /// This catalog with a convention's radii of the Sun and the Moon.
    pub fn with_eclipse_radii(mut self, radii: EclipseRadii) -> Self {
        self.eclipse_radii = radii;
        if let Some((sun_km, moon_km)) = radii.replacement_km() {
            for body in &mut self.bodies {
                match body.id {
                    NaifId::SUN => body.radii_km = DVec3::splat(sun_km),
                    NaifId::MOON => body.radii_km = DVec3::splat(moon_km),
                    _ => {}
                }
            }
        }
        self
    }

    /// The convention whose radii the catalog has.
    pub fn eclipse_radii(&self) -> EclipseRadii {
        self.eclipse_radii
    }

    /// The convention and its radii in words (NaN for a body that the catalog lacks): `iau: Sun 695700.0 km, Moon 1737.4 km`.
    pub fn eclipse_radii_text(&self) -> Message {
        let radius_km = |id| self.body(id).map_or(f64::NAN, |b| b.radii_km.x);
        message!(
            "radii-used",
            source = self.eclipse_radii.name(),
            sun = format_args!("{:.1}", radius_km(NaifId::SUN)),
            moon = format_args!("{:.1}", radius_km(NaifId::MOON))
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::SUN_RADIUS_KM;

    #[test]
    fn the_default_is_the_iau_and_changes_nothing() {
        let catalog = Catalog::embedded().with_eclipse_radii(EclipseRadii::default());
        assert_eq!(catalog.body(NaifId::SUN).expect("the Sun").radii_km, DVec3::splat(SUN_RADIUS_KM));
        assert_eq!(catalog.eclipse_radii_text().to_string(), "iau: Sun 695700.0 km, Moon 1737.4 km");
    }

    #[test]
    fn almanacs_have_a_larger_sun_and_a_smaller_moon() {
        let catalog = Catalog::embedded().with_eclipse_radii(EclipseRadii::Almanac);
        let radius_km = |id| catalog.body(id).expect("a body").radii_km.x;
        // 959.63 arcsec at 1 au are 696 000 km to within 20 km; k = 0.272281 is 1736.65 km.
        assert!((radius_km(NaifId::SUN) - 696_000.0).abs() < 20.0);
        assert!((radius_km(NaifId::MOON) - 1736.65).abs() < 0.01);
        for radii in EclipseRadii::ALL {
            assert_eq!(EclipseRadii::from_name(&radii.name().to_uppercase()), Some(radii));
        }
        assert_eq!(EclipseRadii::from_name("other"), None);
    }
}
