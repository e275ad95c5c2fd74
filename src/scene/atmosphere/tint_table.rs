//! Tint and transmittance of light from beyond the air around the camera, by the altitude of the line of sight.
//!
//! In: the air around the camera. Out: [`TintTable`], for light that comes from many directions; all that a frame draws shares one table ([`FrameTints`]). A
//! tint is the transmittance per channel, divided by its mean over the channels. It is for light that is drawn before the air, stars and corona: the draw of
//! the air dims what is behind it by that mean. Comets and minor planets are drawn after the air and take the transmittance itself. The table begins
//! at the horizon, below which the ground hides everything. Altitudes are those in the unit-sphere frame, in which the
//! horizon is level on flattened bodies, too. Error there: the table is of one vertical plane, and lengths in other planes differ by the flattening.

use crate::scene::atmosphere::air::{SurroundingAir, tint_of};
pub(crate) use crate::scene::constants::TINT_STEPS;
use glam::{DMat3, DVec3};
use std::cell::OnceCell;

/// Tints from the horizon to the zenith.
pub(crate) struct TintTable {
    /// To axes whose z axis is the zenith of the unit-sphere frame; a vector's length changes by as much as the body is flattened.
    from_icrf: DMat3,
    /// Sine of the horizon's altitude: 0 on the ground, below 0 above it.
    pub horizon_sine: f64,
    /// The tint of number k is at the altitude with the sine `horizon_sine` + (1 - `horizon_sine`) (k / [`TINT_STEPS`])^4.
    pub tints: [DVec3; TINT_STEPS + 1],
    /// Transmittances at the same altitudes.
    pub transmittances: [DVec3; TINT_STEPS + 1],
}

impl TintTable {
    /// `air`: `None` for a camera outside all air; the tint is then 1.
    pub(crate) fn of(air: Option<&SurroundingAir<'_>>) -> Self {
        let Some(air) = air else {
            let ones = [DVec3::ONE; TINT_STEPS + 1];
            return Self { from_icrf: DMat3::IDENTITY, horizon_sine: 0.0, tints: ones, transmittances: ones };
        };
        let placement = &air.placement;
        let camera = placement.camera_in_unit_sphere();
        let up = camera.normalize();
        let (x, y) = up.any_orthonormal_pair();
        let from_icrf = DMat3::from_cols(x, y, up).transpose()
            * DMat3::from_diagonal(placement.radii_km.x / placement.radii_km)
            * placement.body_from_icrf;
        let to_icrf = from_icrf.inverse();
        let horizon_sine = -(1.0 - 1.0 / camera.length_squared().max(1.0)).sqrt();
        let direction = |k: usize| {
            let sine = horizon_sine + (1.0 - horizon_sine) * (k as f64 / TINT_STEPS as f64).powi(4);
            to_icrf * DVec3::new((1.0 - sine * sine).max(0.0).sqrt(), 0.0, sine)
        };
        let transmittances: [DVec3; TINT_STEPS + 1] = std::array::from_fn(|k| air.transmittance(direction(k)));
        Self { from_icrf, horizon_sine, tints: transmittances.map(tint_of), transmittances }
    }

    /// The axes of [`Self::in_axes`], ICRF: the components of a vector there are its dot products with these.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        [0, 1, 2].map(|k| self.from_icrf.row(k))
    }

    /// A vector (ICRF) in axes in which the altitude of the table's tints is that above the xy plane.
    pub(crate) fn in_axes(&self, v: DVec3) -> DVec3 {
        self.from_icrf * v
    }

    /// The tint in a direction (ICRF, any length), as shaders/entry/corona.wesl has it.
    pub(crate) fn at(&self, direction: DVec3) -> DVec3 {
        self.interpolated(&self.tints, direction)
    }

    /// The transmittance in a direction (ICRF, any length), as shaders/entry/minor_planets.wesl has it; below the horizon that at the horizon.
    pub(crate) fn transmittance(&self, direction: DVec3) -> DVec3 {
        self.interpolated(&self.transmittances, direction)
    }

    /// The position in the table is that of shaders/lib/tint_position.wesl.
    fn interpolated(&self, values: &[DVec3; TINT_STEPS + 1], direction: DVec3) -> DVec3 {
        let sine = self.in_axes(direction).normalize().z;
        let fraction = ((sine - self.horizon_sine) / (1.0 - self.horizon_sine)).clamp(0.0, 1.0);
        let position = fraction.sqrt().sqrt() * TINT_STEPS as f64;
        let lower = (position as usize).min(TINT_STEPS - 1);
        values[lower].lerp(values[lower + 1], position - lower as f64)
    }
}

/// The tints of a frame, computed once, when something is drawn that they tint.
pub(crate) struct FrameTints<'a> {
    /// The air around the camera; `None` for a camera outside all air.
    pub air: Option<&'a SurroundingAir<'a>>,
    table: OnceCell<TintTable>,
}

impl<'a> FrameTints<'a> {
    pub(crate) fn of(air: Option<&'a SurroundingAir<'a>>) -> Self {
        Self { air, table: OnceCell::new() }
    }

    /// `None` without air.
    pub(crate) fn table(&self) -> Option<&TintTable> {
        let air = self.air?;
        Some(self.table.get_or_init(|| TintTable::of(Some(air))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::scene::atmosphere::sky_brightness::SkyBrightnessCache;
    use crate::scene::camera::Placement;

    /// Over each body with air, at heights up to just below the top: along lines of sight above the horizon in all azimuths, the interpolated tint is that of
    /// the line of sight. Errors: 0.011 of the light without air from the lower tenth of the air (on Saturn, by its flattening); above it up to 0.08, in the
    /// lowest kilometres at the Earth's limb.
    #[test]
    fn the_table_has_the_tint_of_each_line_of_sight() {
        let catalog = Catalog::embedded();
        let skies = SkyBrightnessCache::default();
        for body in catalog.bodies() {
            let Some(air) = body.atmosphere.as_ref() else { continue };
            for part in [1e-5, 0.1, 0.5, 0.999] {
                // At a latitude of 45 degrees, where the vertical of a flattened body differs most from the direction away from its centre.
                let ground = DVec3::new(0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt());
                let centre_km = -ground * (1.0 + part * air.top_km / body.radii_km.x) * body.radii_km;
                let placement = Placement { centre_km, body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km };
                let around = SurroundingAir::of(body, &placement, &skies).expect("in the air");
                let table = TintTable::of(Some(&around));
                let (mut worst, mut worst_transmittance) = (0.0_f64, 0.0_f64);
                for k in 0..400 {
                    let (sin_azimuth, cos_azimuth) = (2.4 * f64::from(k)).sin_cos();
                    let sine = table.horizon_sine + (1.0 - table.horizon_sine) * ((f64::from(k) + 0.5) / 400.0).powi(2);
                    let across = (1.0 - sine * sine).max(0.0).sqrt();
                    let direction = table.from_icrf.inverse() * DVec3::new(across * cos_azimuth, across * sin_azimuth, sine);
                    // Of light that the air dims to nothing, the tint has no effect.
                    let error = (table.at(direction) - around.tint(direction)).abs() * around.mean_transmittance(direction);
                    worst = worst.max(error.max_element());
                    let error = (table.transmittance(direction) - around.transmittance(direction)).abs();
                    worst_transmittance = worst_transmittance.max(error.max_element());
                }
                println!("{} at {part}: {worst:.4}, transmittance {worst_transmittance:.4}", body.name);
                // A camera high in the air sees the transmittance rise from 0 to 1 within two or three steps.
                let (bound, transmittance_bound) = if part <= 0.1 { (0.02, 0.04) } else { (0.1, 0.15) };
                assert!(
                    worst_transmittance < transmittance_bound,
                    "{} at {part} of the height of its air: {worst_transmittance}",
                    body.name
                );
                assert!(worst < bound, "{} at {part} of the height of its air: an error of {worst}", body.name);
            }
        }
    }

    #[test]
    fn near_the_top_of_the_air_only_the_horizon_is_red() {
        let catalog = Catalog::embedded();
        let skies = SkyBrightnessCache::default();
        let earth = catalog.body(crate::catalog::NaifId(399)).expect("the Earth");
        let placement =
            Placement { centre_km: -DVec3::X * (earth.radii_km.x + 95.0), body_from_icrf: DMat3::IDENTITY, radii_km: earth.radii_km };
        let around = SurroundingAir::of(earth, &placement, &skies).expect("95 km up is in the air");
        let table = TintTable::of(Some(&around));
        // The horizon is 9.8 degrees below the horizontal plane.
        let at = |altitude_deg: f64| {
            let (sin, cos) = altitude_deg.to_radians().sin_cos();
            table.at(DVec3::new(sin, cos, 0.0))
        };
        assert!(at(-9.75).x > 2.0 && at(-9.75).z < 0.1, "{}", at(-9.75));
        for altitude_deg in [-5.0, 0.0, 10.0, 90.0] {
            assert!((at(altitude_deg) - 1.0).abs().max_element() < 5e-3, "{altitude_deg}: {}", at(altitude_deg));
        }
        assert!(TintTable::of(None).at(DVec3::Y) == DVec3::ONE);
        // All that a frame draws shares one table.
        let of_frame = FrameTints::of(Some(&around));
        assert!(of_frame.table.get().is_none(), "computed before anything needs it");
        let [first, second] = [(); 2].map(|()| of_frame.table().expect("air"));
        assert!(std::ptr::eq(first, second) && first.tints == table.tints);
        assert!(FrameTints::of(None).table().is_none());
    }
}
