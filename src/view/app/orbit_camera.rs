//! The orbiting camera of the window: angles about the pole of the orbited body and a distance, changed by mouse and keys.
//!
//! In: drags in pixels, wheel notches, the pole. Out: the camera's offset from the body's centre in kilometres. Pole and offset are both in ICRF, or both
//! in body-fixed axes, in which the pole is z. This module uses no window and no ephemeris.

use glam::{DMat3, DVec3};

/// Smallest distance from the centre, in radii: for the Earth, a metre above the sphere of its equatorial radius.
const MIN_DISTANCE_RADII: f64 = 1.0 + 1.6e-7;
/// Largest distance from the centre, in radii: about 2000 au for the Earth's radius.
const MAX_DISTANCE_RADII: f64 = 5.0e7;
/// Change of the natural logarithm of the height above the ground per wheel notch: six notches change the height by a factor of e.
pub(crate) const LOG_HEIGHT_PER_NOTCH: f64 = 1.0 / 6.0;
/// Largest elevation, 89.9 degrees: at the pole the azimuth would be undefined, and a drag divides by the cosine of the elevation.
const MAX_ELEVATION_RAD: f64 = 89.9 * std::f64::consts::PI / 180.0;
/// Height above the ground, in radii, up to which the angle per pixel of a drag increases.
const MAX_DRAG_HEIGHT_RADII: f64 = 4.0;

/// Difference between the azimuths of the camera and of the Sun in [`OrbitCamera::on_lit_side`], so that the terminator is visible.
const LIT_SIDE_SUN_AZIMUTH_DEG: f64 = 35.0;
/// Angle by which the camera of [`OrbitCamera::on_lit_side`] is farther from the equator than the Sun.
const LIT_SIDE_ELEVATION_DEG: f64 = 12.0;
/// Largest elevation of the camera of [`OrbitCamera::on_lit_side`], 69 degrees, so that it is not above a pole.
const LIT_SIDE_MAX_ELEVATION_RAD: f64 = 1.2;

/// Position of the camera around a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OrbitCamera {
    /// Angle about the pole, radians: in ICRF from the ascending node of the body's equator, in body-fixed axes from the prime meridian.
    pub azimuth_rad: f64,
    /// Angle above the body's equator, radians, within ±89.9 degrees.
    pub elevation_rad: f64,
    /// Distance from the centre in equatorial radii.
    pub distance_radii: f64,
}

/// Rotation from the axes of a body's equator to the reference axes, in which `pole` is given: ICRF or body-fixed ones. Its columns are the axes of the
/// equator: z is the pole, x the ascending node on the plane z = 0 of the reference axes. In body-fixed axes the pole is z, and the rotation is the identity.
pub(crate) fn reference_from_equator(pole: DVec3) -> DMat3 {
    let z = pole.try_normalize().unwrap_or(DVec3::Z);
    let x = DVec3::Z.cross(z).try_normalize().unwrap_or(DVec3::X);
    DMat3::from_cols(x, z.cross(x), z)
}

impl OrbitCamera {
    /// The orbit with these angles in degrees.
    pub(crate) fn from_degrees(azimuth_deg: f64, elevation_deg: f64, distance_radii: f64) -> Self {
        Self { azimuth_rad: azimuth_deg.to_radians(), elevation_rad: elevation_deg.to_radians(), distance_radii }
    }

    /// The orbit of a camera at `offset_km` from the centre of a body of `radius_km`. `pole`: in the axes of `offset_km`.
    pub(crate) fn from_offset(offset_km: DVec3, radius_km: f64, pole: DVec3) -> Self {
        // The offset along the axes of the body's equator.
        let equatorial_km = reference_from_equator(pole).transpose() * offset_km;
        let distance_from_axis_km = equatorial_km.truncate().length();
        let mut orbit = Self {
            azimuth_rad: equatorial_km.y.atan2(equatorial_km.x),
            elevation_rad: equatorial_km.z.atan2(distance_from_axis_km),
            distance_radii: equatorial_km.length() / radius_km,
        };
        orbit.keep_in_bounds();
        orbit
    }

    /// As [`Self::from_offset`], for an offset in radii of the body.
    pub(crate) fn from_offset_radii(offset_radii: DVec3, pole: DVec3) -> Self {
        Self::from_offset(offset_radii, 1.0, pole)
    }

    /// The orbit of a camera that sees the lit side of a body and of its rings. `sunward`: the unit vector from the body to the Sun. Both it
    /// and `pole` are in ICRF.
    pub(crate) fn on_lit_side(sunward: DVec3, distance_radii: f64, pole: DVec3) -> Self {
        let mut orbit = Self::from_offset_radii(sunward * distance_radii, pole);
        orbit.azimuth_rad += LIT_SIDE_SUN_AZIMUTH_DEG.to_radians();
        // Farther from the equator than the Sun, on the same side.
        let elevation_rad = orbit.elevation_rad + LIT_SIDE_ELEVATION_DEG.to_radians().copysign(orbit.elevation_rad);
        orbit.elevation_rad = elevation_rad.clamp(-LIT_SIDE_MAX_ELEVATION_RAD, LIT_SIDE_MAX_ELEVATION_RAD);
        orbit
    }

    /// The camera's offset from the body's centre, kilometres.
    pub(crate) fn offset_km(&self, radius_km: f64, pole: DVec3) -> DVec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth_rad.sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation_rad.sin_cos();
        let direction = DVec3::new(cos_elevation * cos_azimuth, cos_elevation * sin_azimuth, sin_elevation);
        reference_from_equator(pole) * direction * (self.distance_radii * radius_km)
    }

    /// Applies a drag by `dx_px` to the right and `dy_px` down. The angle per pixel is proportional to the height above the ground, up to
    /// [`MAX_DRAG_HEIGHT_RADII`]. Near the ground a drag of a pixel therefore moves the ground by about a pixel. `fov_rad`: vertical field of view.
    pub(crate) fn drag(&mut self, dx_px: f64, dy_px: f64, image_height_px: f64, fov_rad: f64) {
        let height_radii = self.distance_radii - 1.0;
        let rad_per_px = (fov_rad / image_height_px.max(1.0)) * height_radii.min(MAX_DRAG_HEIGHT_RADII);
        self.azimuth_rad -= dx_px * rad_per_px / self.elevation_rad.cos();
        self.elevation_rad += dy_px * rad_per_px;
        self.keep_in_bounds();
    }

    /// Zooms by notches: positive moves closer. The height above the ground is scaled, so the camera never reaches the ground.
    pub(crate) fn zoom(&mut self, notches: f64) {
        // In a view from a link the distance may be less than a radius.
        let height_radii = self.distance_radii.max(MIN_DISTANCE_RADII) - 1.0;
        let height_radii = height_radii * (-notches * LOG_HEIGHT_PER_NOTCH).exp();
        self.distance_radii = 1.0 + height_radii;
        self.keep_in_bounds();
    }

    fn keep_in_bounds(&mut self) {
        self.azimuth_rad = self.azimuth_rad.rem_euclid(std::f64::consts::TAU);
        self.elevation_rad = self.elevation_rad.clamp(-MAX_ELEVATION_RAD, MAX_ELEVATION_RAD);
        self.distance_radii = self.distance_radii.clamp(MIN_DISTANCE_RADII, MAX_DISTANCE_RADII);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLE: DVec3 = DVec3::new(0.08, -0.31, 0.947);

    #[test]
    fn offset_and_orbit_round_trip() {
        let orbit = OrbitCamera { azimuth_rad: 1.2, elevation_rad: -0.4, distance_radii: 3.5 };
        let restored = OrbitCamera::from_offset(orbit.offset_km(6378.0, POLE), 6378.0, POLE);
        assert!((restored.azimuth_rad - 1.2).abs() < 1e-12 && (restored.elevation_rad + 0.4).abs() < 1e-12);
        assert!((restored.distance_radii - 3.5).abs() < 1e-12);
    }

    #[test]
    fn elevation_is_latitude_about_the_pole() {
        let orbit = OrbitCamera { azimuth_rad: 0.3, elevation_rad: 0.5, distance_radii: 2.0 };
        let latitude_sine = orbit.offset_km(1.0, POLE).normalize_or_zero().dot(POLE.normalize_or_zero());
        assert!((latitude_sine - 0.5_f64.sin()).abs() < 1e-12, "{latitude_sine}");
    }

    #[test]
    fn a_pole_along_icrf_z_still_has_axes() {
        let axes = reference_from_equator(DVec3::Z);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_zoom_reaches_the_ground_or_infinity() {
        let mut orbit = OrbitCamera { azimuth_rad: 0.0, elevation_rad: 0.0, distance_radii: 3.0 };
        for _ in 0..2000 {
            orbit.zoom(1.0);
        }
        assert_eq!(orbit.distance_radii, MIN_DISTANCE_RADII);
        for _ in 0..2000 {
            orbit.zoom(-1.0);
        }
        assert_eq!(orbit.distance_radii, MAX_DISTANCE_RADII);
    }

    #[test]
    fn a_drag_over_the_pole_stops_below_it() {
        let mut orbit = OrbitCamera { azimuth_rad: 0.0, elevation_rad: 0.0, distance_radii: 3.0 };
        orbit.drag(0.0, 1e6, 800.0, 0.8);
        assert_eq!(orbit.elevation_rad, MAX_ELEVATION_RAD);
        orbit.drag(10.0, 0.0, 800.0, 0.8);
        assert!(orbit.azimuth_rad.is_finite());
    }
}
