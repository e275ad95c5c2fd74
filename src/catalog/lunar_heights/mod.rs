//! The user's height map of the entire Moon: kilometres above a reference sphere.
//!
//! In: bytes of a PNG, a TIFF, or a label of NASA's Planetary Data System (PDS) and its image ([`HeightMap::of_image`], [`HeightMap::of_pds`]). Out:
//! [`HeightMap`], which gives the height in any direction. Always: every height is finite and within [`MAX_HEIGHT_KM`] of the sphere. A value of the map is the
//! height at the centre of its cell; between centres heights are interpolated linearly in longitude and latitude; between the first or last row and the pole
//! they are constant along each meridian. No height map is embedded. Not supported: maps of a part of the Moon, other projections, other bodies.

mod image_file;
mod label;

use crate::units::RAD_PER_ARCSEC;
use crate::wording::{echo, one_line};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Radius of the reference sphere of maps without a label: that of the maps of LOLA (Lunar Orbiter Laser Altimeter).
pub const DEFAULT_SPHERE_KM: f64 = 1737.4;
/// Largest accepted height above or below the sphere. Those of the Moon lie between -9.2 and 10.8 km (LOLA).
pub const MAX_HEIGHT_KM: f64 = 20.0;
/// Maximum number of heights in a map: enough for 21 per degree.
pub const MAX_HEIGHTS: usize = 30_000_000;
/// Maximum size of a file: [`MAX_HEIGHTS`] heights of eight bytes, and a header.
pub const MAX_FILE_BYTES: u64 = 8 * MAX_HEIGHTS as u64 + (1 << 20);
/// Mean distance of the Moon from the Earth.
const MOON_DISTANCE_KM: f64 = 384_400.0;
/// Maximum size of a label.
pub const MAX_LABEL_BYTES: u64 = 1 << 20;

/// An error in a height file, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {}", echo(.file), one_line(.why))]
pub struct HeightMapError {
    /// The file's name.
    pub file: String,
    /// What is wrong, and what to do.
    pub why: String,
}

/// The heights that black and white pixels stand for, in an image that does not state them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightRange {
    pub black_km: f64,
    pub white_km: f64,
}

/// Heights of the entire Moon above a sphere, on a grid of equal steps in longitude and latitude.
#[derive(Clone, PartialEq)]
pub struct HeightMap {
    name: String,
    columns: usize,
    rows: usize,
    /// Heights above the sphere: rows from north to south, each row eastward.
    heights_km: Vec<f32>,
    /// East longitude of the western edge of the first column, radians.
    west_rad: f64,
    /// Radius of the reference sphere.
    sphere_km: f64,
    /// Lowest height of the map.
    min_km: f64,
    /// Highest height of the map.
    max_km: f64,
}

impl std::fmt::Debug for HeightMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "HeightMap({}, {})", self.name, self.summary())
    }
}

impl HeightMap {
    /// A map of the entire Moon. `heights_km`: heights above the sphere of radius `sphere_km`, rows from north to south, each eastward from the longitude
    /// `west_deg`. `name`: the file's name in messages.
    ///
    /// # Errors
    /// If the map is not twice as wide as high, or has too many or too few heights; if the sphere does not have the size of the Moon; or if the Moon cannot
    /// have one of the heights (the error names the first).
    pub fn new(name: &str, columns: usize, heights_km: Vec<f32>, west_deg: f64, sphere_km: f64) -> Result<Self, HeightMapError> {
        let failed = |why: String| HeightMapError { file: name.to_owned(), why };
        let rows = columns / 2;
        check_size(columns, rows).map_err(failed)?;
        if columns * rows != heights_km.len() {
            return Err(failed(format!("{} heights, not {columns} x {rows}", heights_km.len())));
        }
        if !(1700.0..1800.0).contains(&sphere_km) {
            return Err(failed(format!("heights over a sphere of {sphere_km} km: the Moon's has about {DEFAULT_SPHERE_KM} km")));
        }
        if let Some(index) = heights_km.iter().position(|h| h.is_nan() || f64::from(*h).abs() > MAX_HEIGHT_KM) {
            let (row, column) = (index / columns + 1, index % columns + 1);
            let why = format!(
                "row {row}, column {column}: a height of {} km; the Moon's lie between -{MAX_HEIGHT_KM} and {MAX_HEIGHT_KM} km",
                heights_km[index]
            );
            return Err(failed(why));
        }
        let (min, max) = heights_km.iter().fold((f32::MAX, f32::MIN), |(min, max), h| (min.min(*h), max.max(*h)));
        let (min_km, max_km) = (f64::from(min), f64::from(max));
        Ok(Self { name: name.to_owned(), columns, rows, heights_km, west_rad: west_deg.to_radians(), sphere_km, min_km, max_km })
    }

    /// Reads a greyscale PNG of 8 or 16 bits, or a TIFF of 8 or 16 bits or floating point, with longitude 0 in the middle. `range`: the heights of black and
    /// white. Without a range, unsigned 16-bit values count half metres upward from -10 km, and floating-point values are kilometres, as in the CGI Moon Kit of
    /// NASA's Scientific Visualization Studio.
    ///
    /// # Errors
    /// States what is wrong with the file, and what to do.
    pub fn of_image(name: &str, bytes: &[u8], range: Option<HeightRange>) -> Result<Self, HeightMapError> {
        let failed = |why: String| HeightMapError { file: name.to_owned(), why };
        let (columns, heights_km) = image_file::heights_km(bytes, range).map_err(failed)?;
        let west_deg = -180.0;
        Self::new(name, columns, heights_km, west_deg, DEFAULT_SPHERE_KM)
    }

    /// The name, without a folder, of the image file that a PDS label refers to.
    ///
    /// # Errors
    /// States what is wrong with the label.
    pub fn image_of_label(name: &str, text: &str) -> Result<String, HeightMapError> {
        label::image_file(text).map_err(|why| HeightMapError { file: name.to_owned(), why })
    }

    /// Reads an image with a detached PDS3 label, such as LOLA's LDEM.
    ///
    /// # Errors
    /// Names the keyword that is missing or has an unsupported value.
    pub fn of_pds(name: &str, text: &str, image: &[u8]) -> Result<Self, HeightMapError> {
        let read = label::heights(text, image).map_err(|why| HeightMapError { file: name.to_owned(), why })?;
        Self::new(name, read.columns, read.heights_km, read.west_deg, read.sphere_km)
    }

    /// Radius of the reference sphere.
    pub fn sphere_km(&self) -> f64 {
        self.sphere_km
    }

    /// The minimum and maximum height.
    pub fn range_km(&self) -> [f64; 2] {
        [self.min_km, self.max_km]
    }

    /// Angle between adjacent rows of heights, radians.
    pub fn step_rad(&self) -> f64 {
        PI / self.rows as f64
    }

    /// All heights: rows from north to south, each eastward.
    pub fn heights_km(&self) -> &[f32] {
        &self.heights_km
    }

    /// Resolution, range of heights and reference sphere as text.
    pub fn summary(&self) -> String {
        let spacing_km = self.step_rad() * self.sphere_km;
        format!(
            "{:.4} heights a degree ({spacing_km:.2} km on the ground, {:.1}\" at the limb), from {:.2} to {:.2} km over a sphere of {} km",
            self.columns as f64 / 360.0,
            spacing_km / MOON_DISTANCE_KM / RAD_PER_ARCSEC,
            self.min_km,
            self.max_km,
            self.sphere_km,
        )
    }

    /// The height above the sphere in a direction, a vector of any length in the Moon's mean-Earth axes.
    pub fn height_km(&self, direction: DVec3) -> f64 {
        let longitude = direction.y.atan2(direction.x);
        let latitude = direction.z.atan2(direction.truncate().length());
        // Column and row, in cells from the centre of the first cell.
        let x = (longitude - self.west_rad).rem_euclid(TAU) / TAU * self.columns as f64 - 0.5;
        let y = ((FRAC_PI_2 - latitude) / PI * self.rows as f64 - 0.5).clamp(0.0, (self.rows - 1) as f64);
        let (x0, y0) = (x.floor(), y.floor());
        let left = if x0 < 0.0 { self.columns - 1 } else { (x0 as usize).min(self.columns - 1) };
        let right = if left + 1 == self.columns { 0 } else { left + 1 };
        let upper = y0 as usize;
        let lower = (upper + 1).min(self.rows - 1);
        let at = |row: usize, column: usize| f64::from(self.heights_km[row * self.columns + column]);
        let in_row = |row: usize| at(row, left) + (at(row, right) - at(row, left)) * (x - x0);
        in_row(upper) + (in_row(lower) - in_row(upper)) * (y - y0)
    }
}

/// Checks the size of a map; the error states why it is rejected.
fn check_size(columns: usize, rows: usize) -> Result<(), String> {
    if rows < 2 || columns != 2 * rows {
        return Err(format!("{columns} x {rows} heights: a map of the whole Moon is twice as wide as high"));
    }
    if columns.saturating_mul(rows) > MAX_HEIGHTS {
        return Err(format!("{columns} x {rows} heights, more than {MAX_HEIGHTS}: use a coarser map, such as one with 16 per degree"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn towards(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
    }

    /// A map that is linear in latitude and has a step in longitude is reproduced at and between the cell centres, and across its western edge.
    #[test]
    fn heights_are_interpolated_between_cell_centres() {
        const COLUMNS: usize = 72;
        let height = |row: usize, column: usize| 0.1 * (row as f32) + if column < 36 { 0.0 } else { 2.0 };
        for west_deg in [-180.0, 0.0] {
            let km = (0..36).flat_map(|row| (0..COLUMNS).map(move |column| height(row, column))).collect();
            let map = HeightMap::new("made", COLUMNS, km, west_deg, DEFAULT_SPHERE_KM).expect("a map");
            for latitude in [-80.0, -12.5, 0.0, 33.0, 80.0] {
                let expected_km = 0.1 * ((90.0 - latitude) / 5.0 - 0.5);
                assert!((map.height_km(towards(latitude, west_deg + 90.0) * 7.0) - expected_km).abs() < 1e-5);
                assert!((map.height_km(towards(latitude, west_deg + 270.0)) - expected_km - 2.0).abs() < 1e-5);
                // Half way between the last column and the first.
                assert!((map.height_km(towards(latitude, west_deg)) - expected_km - 1.0).abs() < 1e-4, "{latitude}");
            }
            // The pole has the height of the first row at longitude 0: half way between 0 and 2 km.
            assert!((map.height_km(DVec3::Z) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn impossible_heights_are_rejected_with_row_and_column() {
        const WEST_DEG: f64 = 0.0;
        let flat =
            |columns: usize, km: f32| HeightMap::new("made", columns, vec![km; columns * (columns / 2)], WEST_DEG, DEFAULT_SPHERE_KM);
        assert!(flat(8, 0.0).is_ok());
        assert!(flat(7, 0.0).is_err());
        for wrong in [f32::NAN, 25.0, -32768.0, f32::INFINITY] {
            let mut km = vec![0.0; 32];
            km[11] = wrong;
            let why = HeightMap::new("made", 8, km, WEST_DEG, DEFAULT_SPHERE_KM).expect_err("no height of the Moon").to_string();
            assert!(why.starts_with("made: row 2, column 4:"), "{why}");
        }
        assert!(HeightMap::new("made", 8, vec![0.0; 32], WEST_DEG, 3396.0).is_err(), "a sphere of Mars's radius must be rejected");
    }
}
