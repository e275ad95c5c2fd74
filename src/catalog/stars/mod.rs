//! Stars: position, proper motion, distance, brightness and colour index, and a spatial index of the sky.
//!
//! In: the text of a catalog. Out: [`StarCatalog`]. Its stars are grouped by cells of the sky and sorted from bright to faint in each cell. A view
//! reads only the cells in its field, and of each cell only the stars down to its limiting magnitude. Always: directions are unit vectors, all numbers
//! are finite. Not here: the place of a star at a date (`ephemeris::star_place`), and its brightness in an image (`scene`).

mod names;
mod read;
mod synthetic;

pub use names::{STAR_NAMES, star_name};

use crate::units::{DAYS_PER_JULIAN_YEAR, JD_J2000};
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, LazyLock};

/// One star at the catalog's epoch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Star {
    /// Number in the Hipparcos catalog; 0: none.
    pub hip: u32,
    /// Unit vector from the solar system's barycentre, ICRF.
    pub direction: DVec3,
    /// Velocity divided by distance, per Julian year. Across the line of sight it is the proper motion in radians; along it, it is 0 if the radial velocity or
    /// the distance is unknown.
    pub motion_per_year: DVec3,
    /// Parallax, 1 au divided by the distance; 0 if it was not measured.
    pub parallax_rad: f64,
    /// Johnson V magnitude.
    pub v_magnitude: f32,
    /// Colour index B-V; `None`: not measured.
    pub b_v: Option<f32>,
}

/// The stars of one sky cell.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyCell {
    /// The cell's stars, the brightest first: indices in [`StarCatalog::stars`].
    pub stars: Range<usize>,
    /// Unit vector to the middle of the stars. At the epoch of the catalog every star lies within `radius_rad` of it.
    pub axis: DVec3,
    /// Angle from `axis` to the farthest star.
    pub radius_rad: f64,
    pub brightest_magnitude: f32,
    /// Length of the largest [`Star::motion_per_year`].
    pub max_motion_per_year: f64,
    /// Largest [`Star::parallax_rad`].
    pub max_parallax_rad: f64,
}

/// Stars, grouped by cells of the sky.
#[derive(Clone, Debug, PartialEq)]
pub struct StarCatalog {
    /// Julian date (TT) of the directions.
    epoch_jd: f64,
    /// Ordered by cell; within a cell, the brightest first.
    stars: Vec<Star>,
    /// The cells that contain stars.
    cells: Vec<SkyCell>,
}

/// An error in the file of a star catalog. Its text is one line: file, line, field, what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {message}")]
pub struct StarFileError {
    pub file: String,
    /// Line number, starting at 1.
    pub line: usize,
    pub message: String,
}

static EMBEDDED: LazyLock<Arc<StarCatalog>> = LazyLock::new(|| match StarCatalog::parse("stars_v7.csv", orrery_catalogs::STARS) {
    Ok(stars) => Arc::new(stars),
    Err(e) => panic!("the embedded stars are broken: {e}"),
});

/// Magnitude of the brightest embedded star, Sirius.
pub(super) const EMBEDDED_BRIGHTEST_MAGNITUDE: f32 = -1.44;

/// Cells along each side of the six faces of a cube around the observer. A cell is 3 to 7 degrees wide.
const CELLS_PER_SIDE: usize = 16;

/// The number of the cell that contains a direction: by the face of the cube that the direction meets, then by the row and the column on that face.
fn cell_of(direction: DVec3) -> usize {
    let magnitudes = direction.abs();
    let (axis, largest) = (0..3).map(|k| (k, magnitudes[k])).fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    let coordinate =
        |k: usize| (((direction[(axis + k) % 3] / largest + 1.0) / 2.0 * CELLS_PER_SIDE as f64) as usize).min(CELLS_PER_SIDE - 1);
    (face * CELLS_PER_SIDE + coordinate(1)) * CELLS_PER_SIDE + coordinate(2)
}

/// The cell of a range of stars, with its bounds.
fn bounded_cell(stars: &[Star], range: Range<usize>) -> SkyCell {
    let cell_stars = &stars[range.clone()];
    let axis = cell_stars.iter().map(|s| s.direction).sum::<DVec3>().normalize();
    let max = |value: fn(&Star) -> f64| cell_stars.iter().map(value).fold(0.0, f64::max);
    // A chord c spans the angle 2 asin(c / 2).
    let chord = cell_stars.iter().map(|s| s.direction.distance(axis)).fold(0.0, f64::max);
    SkyCell {
        stars: range,
        axis,
        radius_rad: 2.0 * (chord / 2.0).min(1.0).asin(),
        brightest_magnitude: cell_stars.iter().map(|s| s.v_magnitude).fold(f32::INFINITY, f32::min),
        max_motion_per_year: max(|s| s.motion_per_year.length()),
        max_parallax_rad: max(|s| s.parallax_rad),
    }
}

impl StarCatalog {
    /// The stars that are embedded in the program: 15 537 to magnitude 7. A test verifies that they can be read, so this never panics in a released program.
    pub fn embedded() -> Arc<Self> {
        Arc::clone(&EMBEDDED)
    }

    /// Reads a catalog: comma-separated values with named columns, or Hipparcos' hip2.dat.
    ///
    /// # Errors
    /// Names the first line that cannot be read.
    pub fn parse(file: &str, text: &str) -> Result<Self, StarFileError> {
        let (epoch_jd, stars) = read::read(file, text)?;
        Ok(Self::new(epoch_jd, stars))
    }

    /// Sorts stars into cells.
    fn new(epoch_jd: f64, mut stars: Vec<Star>) -> Self {
        let mut by_cell: BTreeMap<usize, Vec<Star>> = BTreeMap::new();
        for star in stars.drain(..) {
            by_cell.entry(cell_of(star.direction)).or_default().push(star);
        }
        let mut ranges = Vec::with_capacity(by_cell.len());
        for mut cell_stars in by_cell.into_values() {
            cell_stars.sort_by(|a, b| a.v_magnitude.total_cmp(&b.v_magnitude));
            ranges.push(stars.len()..stars.len() + cell_stars.len());
            stars.append(&mut cell_stars);
        }
        let cells = ranges.into_iter().map(|range| bounded_cell(&stars, range)).collect();
        Self { epoch_jd, stars, cells }
    }

    /// All stars, ordered by cell.
    pub fn stars(&self) -> &[Star] {
        &self.stars
    }

    pub fn cells(&self) -> &[SkyCell] {
        &self.cells
    }

    pub fn brightest_magnitude(&self) -> f32 {
        self.cells.iter().map(|c| c.brightest_magnitude).fold(f32::INFINITY, f32::min)
    }

    /// Magnitude of the faintest star; negative infinity without stars.
    pub fn faintest_magnitude(&self) -> f32 {
        // The stars of a cell are in order of brightness.
        self.cells
            .iter()
            .filter_map(|cell| self.stars.get(cell.stars.clone())?.last())
            .map(|s| s.v_magnitude)
            .fold(f32::NEG_INFINITY, f32::max)
    }

    /// The star with a Hipparcos number.
    pub fn star_of_hip(&self, number: u32) -> Option<&Star> {
        self.index_of_hip(number).map(|k| &self.stars[k])
    }

    /// The index in [`Self::stars`] of the star with a Hipparcos number.
    pub fn index_of_hip(&self, number: u32) -> Option<usize> {
        self.stars.iter().position(|s| s.hip == number && number != 0)
    }

    /// Julian years from the epoch to a Julian date (TT).
    pub fn years_since_epoch(&self, jd_tt: f64) -> f64 {
        (jd_tt - self.epoch_jd) / DAYS_PER_JULIAN_YEAR
    }
}

/// The Julian date of a Julian epoch such as 1991.25.
fn julian_epoch(year: f64) -> f64 {
    JD_J2000 + (year - 2000.0) * DAYS_PER_JULIAN_YEAR
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::RAD_PER_ARCSEC;

    /// Every star lies in one cell and within its bounds, and a cell's stars are sorted from bright to faint.
    #[test]
    fn cells_bound_their_stars() {
        let catalog = StarCatalog::embedded();
        assert_eq!(catalog.stars().len(), 15_537);
        assert_eq!(catalog.brightest_magnitude(), EMBEDDED_BRIGHTEST_MAGNITUDE);
        assert_eq!(catalog.cells().iter().map(|c| c.stars.len()).sum::<usize>(), 15_537);
        for cell in catalog.cells() {
            let stars_in_cell = &catalog.stars()[cell.stars.clone()];
            assert!(cell.radius_rad < 0.1, "{}", cell.radius_rad);
            assert!(
                stars_in_cell.windows(2).all(|w| w[0].v_magnitude <= w[1].v_magnitude)
                    && stars_in_cell[0].v_magnitude == cell.brightest_magnitude
            );
            for star in stars_in_cell {
                assert!((star.direction.length() - 1.0).abs() < 1e-12);
                assert!(star.direction.dot(cell.axis) >= cell.radius_rad.cos() - 1e-12);
                assert!(star.motion_per_year.length() <= cell.max_motion_per_year && star.parallax_rad <= cell.max_parallax_rad);
            }
        }
    }

    /// Sirius agrees with the Hipparcos catalog, Barnard's star (V 9.5) is too faint to be embedded, and Vega has its place of J1991.25 (ESA 1997).
    #[test]
    fn the_embedded_stars_agree_with_hipparcos() {
        let catalog = StarCatalog::embedded();
        let sirius = catalog.star_of_hip(32_349).expect("Sirius");
        assert_eq!((sirius.v_magnitude, sirius.b_v), (-1.44, Some(0.009)));
        assert!((sirius.parallax_rad / RAD_PER_ARCSEC - 0.379_21).abs() < 1e-9);
        assert!((sirius.motion_per_year.length() / RAD_PER_ARCSEC - 1.339_42).abs() < 1e-4);
        assert!(catalog.star_of_hip(87_937).is_none() && catalog.star_of_hip(0).is_none());
        assert!((catalog.years_since_epoch(JD_J2000) - 8.75).abs() < 1e-12);
        let vega = catalog.star_of_hip(91_262).expect("Vega").direction;
        // 18h 36m 56.19s, +38 deg 46' 58.8" at J1991.25; the tolerance covers the rounding of these figures.
        let (ra, dec) = ((18.0 + 36.0 / 60.0 + 56.19 / 3600.0) * 15.0_f64, 38.0 + 46.0 / 60.0 + 58.8 / 3600.0_f64);
        let (ra, dec) = (ra.to_radians(), dec.to_radians());
        let expected = DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
        assert!(vega.distance(expected) < 0.2 * RAD_PER_ARCSEC, "{}", vega.distance(expected) / RAD_PER_ARCSEC);
    }
}
