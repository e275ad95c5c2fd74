//! The light of a body's air around and beyond the terminator, seen from above the air, for the light meter.
//!
//! In: a body with air that is drawn over its ground. Out: the radiance of the air above a point of the ground, per unit of the Sun's irradiance. Beyond the
//! terminator the ground gets no sunlight, but the air above still does. By day this light is part of the body's mean albedo. Always: continuous in position
//! and time. Left out: eclipses of that air, and the air beyond the limb. For a camera 8 or more of the body's radii away (`FAR_RADII`), the meter ignores
//! twilight if the entire disc is in the frame: twilight is only on a small part of the disc.

use super::MeteredFrame;
use crate::catalog::{Atmosphere, Body, PhaseFunction, Species};
use crate::scene::atmosphere::extinction::scattering;
use crate::scene::atmosphere::species::{colours_exclude_air, is_visible_over_disc};
use crate::scene::atmosphere::{air, phase};
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// The Sun's altitude in degrees, and the radiance per irradiance of the Earth's air seen from straight above (brightest channel), measured in images that
/// this program drew.
const RADIANCE_BY_ALTITUDE: [(f64, f64); 8] =
    [(-18.0, 2.9e-10), (-14.0, 5.8e-8), (-10.0, 1.4e-6), (-8.0, 6.7e-6), (-6.0, 5.2e-5), (-4.0, 5.05e-4), (-2.0, 2.6e-3), (0.0, 7.5e-3)];
/// Altitude of the Sun at and above which the body's mean albedo includes all light of the air.
const DAY_ALTITUDE_DEG: f64 = 5.0;
/// Lower limit of the cosine of emission: for flatter views the radiance no longer grows with the path's length through the air.
const MIN_COS_EMISSION: f64 = 0.2;
/// The two results of [`reflectance_and_radius`] for the Earth, whose air [`RADIANCE_BY_ALTITUDE`] describes.
const EARTH_REFLECTANCE: f64 = 0.105;
const EARTH_RADIUS_SCALE_HEIGHTS: f64 = 873.7;

/// Reflectance of an atmosphere by light scattered once, half of which leaves upwards (brightest channel); and the body's radius divided by the largest scale
/// height of the species that scatter.
fn reflectance_and_radius(body: &Body, air: &Atmosphere) -> [f64; 2] {
    // Light scattered forwards counts as not scattered: hence the factor 1 - mean cosine of the scattering angle.
    let mean_cosine = |s: &Species| s.aerosol_phase().map_or(DVec3::ZERO, |aerosol| phase::mean_cosine(PhaseFunction::Aerosol(aerosol)));
    let vertical_depth = |s: &Species| scattering(s) * s.scale_height_km * (1.0 - mean_cosine(s));
    let depths: DVec3 = air.species.iter().map(vertical_depth).sum();
    let scattering_species = air.species.iter().filter(|s| scattering(s).max_element() > 0.0);
    let scale_height_km = scattering_species.map(|s| s.scale_height_km).fold(0.0, f64::max);
    [-0.5 * (-depths.max_element()).exp_m1(), body.radii_km.x / scale_height_km.max(1e-9)]
}

/// The air of a body under a low Sun.
pub(super) struct TwilightAir {
    /// Radiance relative to the Earth's air.
    strength: f64,
    /// Factor that converts the Sun's altitude here to the altitude at which the Earth's air is equally bright. The higher the air relative to the body's
    /// radius, the longer the air is lit after sunset, and the smaller the factor.
    altitude_factor: f64,
}

impl TwilightAir {
    /// `None` for a body without air, or with clear air that the body's colours include: such air is not drawn over the disc.
    fn of(body: &Body) -> Option<Self> {
        let air = body.atmosphere.as_ref().filter(|air| colours_exclude_air(body) || is_visible_over_disc(air))?;
        let [reflectance, radius_scale_heights] = reflectance_and_radius(body, air);
        Some(Self {
            strength: reflectance / EARTH_REFLECTANCE,
            // Where the Sun is at the small angle d below the horizon, the body's shadow reaches up to the height R d^2 / 2 in the air (R: the body's radius).
            // The air is equally bright where this is the same number of scale heights.
            altitude_factor: (radius_scale_heights / EARTH_RADIUS_SCALE_HEIGHTS).sqrt(),
        })
    }

    /// Radiance per unit of the Sun's irradiance. `cos_sun`, `cos_emission`: cosines of the angles between the vertical and the directions to the Sun and the
    /// viewer.
    pub(super) fn radiance(&self, cos_sun: f64, cos_emission: f64) -> f64 {
        let altitude_deg = cos_sun.clamp(-1.0, 1.0).asin().to_degrees();
        let altitude_on_earth_deg = altitude_deg * self.altitude_factor;
        let table = &RADIANCE_BY_ALTITUDE;
        // ln(radiance) is interpolated. Below the table the slope of its lowest segment continues; above the table its last value holds.
        let lower = table.iter().rposition(|(deg, _)| *deg <= altitude_on_earth_deg).unwrap_or(0).min(table.len() - 2);
        let ((deg0, radiance0), (deg1, radiance1)) = (table[lower], table[lower + 1]);
        let fraction = ((altitude_on_earth_deg - deg0) / (deg1 - deg0)).min(1.0);
        let seen_from_above = (radiance0.ln() + fraction * (radiance1 / radiance0).ln()).exp();
        self.strength * seen_from_above * (1.0 - smoothstep(altitude_deg / DAY_ALTITUDE_DEG)) / cos_emission.max(MIN_COS_EMISSION)
    }
}

/// The radiance per unit of the Sun's irradiance that the meter expects of a body's air seen from straight above; `None` if it does not meter this air. For
/// tests/scene/metered_subjects.rs, which compares it with drawn images.
#[doc(hidden)]
pub fn metered_twilight(body: &Body, sun_altitude_deg: f64) -> Option<f64> {
    let cos_emission = 1.0;
    TwilightAir::of(body).map(|air| air.radiance(sun_altitude_deg.to_radians().sin(), cos_emission))
}

/// The source text of the rows that [`RADIANCE_BY_ALTITUDE`] needs after a change of the Earth's air. `drawn_to_metered`: the radiance of drawn images
/// relative to [`metered_twilight`], by the Sun's altitude in degrees. For the message of tests/scene/metered_subjects.rs.
#[doc(hidden)]
pub fn corrected_twilight_rows(drawn_to_metered: impl Fn(f64) -> f64) -> String {
    corrected_rows(&RADIANCE_BY_ALTITUDE, drawn_to_metered)
}

/// The source text of the rows of a table by altitude, each radiance multiplied by the factor for its altitude.
fn corrected_rows(table: &[(f64, f64)], factor: impl Fn(f64) -> f64) -> String {
    let rows: Vec<String> = table.iter().map(|(deg, radiance)| format!("({deg:?}, {:.2e})", radiance * factor(*deg))).collect();
    rows.join(", ")
}

impl MeteredFrame<'_, '_> {
    /// The air of a body that the camera sees from above; `None` if it is not drawn. For a camera low in the air the strength falls to 0, because the
    /// meter counts the sky around such a camera (`sky_weight`) as a subject of its own.
    pub(super) fn twilight_air_of(&self, p: &PlacedBody<'_>) -> Option<TwilightAir> {
        if self.meter.context.request.effects.override_of_body(p.body, Effect::Atmosphere) == Some(false) {
            return None;
        }
        let air = TwilightAir::of(p.body)?;
        let surrounding = self.meter.air.filter(|a| a.body.id == p.body.id);
        Some(TwilightAir { strength: air.strength * (1.0 - surrounding.map_or(0.0, air::SurroundingAir::sky_weight)), ..air })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    #[test]
    fn twilight_fades_without_a_jump_and_adds_nothing_by_day() {
        let catalog = Catalog::embedded();
        // The Earth, Mars and Titan.
        for id in [399, 499, 606] {
            let air = TwilightAir::of(catalog.body(NaifId(id)).expect("a body")).expect("air over the ground");
            // Just above `DAY_ALTITUDE_DEG`.
            assert_eq!(air.radiance(f64::to_radians(5.1).sin(), 0.1), 0.0);
            // ln(radiance) by the altitude in hundredths of a degree. The greatest step is that of the fade at 4.5 degrees, 0.04.
            let at = |k: i32| air.radiance((0.01 * f64::from(k)).to_radians().sin(), 0.5).max(1e-12).ln();
            let steps = (-3000..450).map(|k| (at(k + 1) - at(k)).abs());
            assert!(steps.fold(0.0, f64::max) < 0.05, "{id}: a jump");
        }
    }

    /// The clear gas of Jupiter is not drawn over its disc.
    #[test]
    fn gas_that_the_map_contains_has_no_twilight_of_its_own() {
        let catalog = Catalog::embedded();
        assert!(TwilightAir::of(catalog.body(NaifId(599)).expect("Jupiter")).is_none());
    }

    /// With an invented table, so that new rows of [`RADIANCE_BY_ALTITUDE`] leave this test as it is.
    #[test]
    fn corrected_rows_are_those_of_the_table_times_the_factor() {
        let corrected = corrected_rows(&[(-18.0, 2.9e-10), (0.0, 7.5e-3)], |deg| if deg < 0.0 { 1.0 } else { 2.0 });
        assert_eq!(corrected, "(-18.0, 2.90e-10), (0.0, 1.50e-2)");
    }
}
