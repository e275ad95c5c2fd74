//! The constellations: names, figures and borders.
//!
//! In: the embedded files of catalogs/ (figures and borders as GeoJSON, and a list of names), with right ascension and declination of J2000 in degrees. Out:
//! [`Constellations`]: figures, whose vertices refer to stars of the catalog where possible, so that they follow proper motion; and the borders of the IAU
//! (Delporte 1930), which run along circles of right ascension and declination of the equinox B1875; the constellation that a direction lies in. Not here:
//! apparent places.

use super::stars::StarCatalog;
use glam::DVec3;
use serde::Deserialize;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// A vertex of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FigureVertex {
    /// Unit vector at the epoch J2000, ICRF.
    pub direction: DVec3,
    /// The star at this vertex: its index in [`StarCatalog::embedded`]. `None` if the catalog has no star within `SAME_STAR_RAD`.
    pub star: Option<usize>,
}

/// A constellation, or one of the two parts of Serpens.
#[derive(Clone, Debug, PartialEq)]
pub struct Constellation {
    /// The IAU abbreviation.
    pub abbreviation: String,
    /// Its Latin name.
    pub name: String,
    /// Where its name is written: a unit vector, ICRF.
    pub label_direction: DVec3,
    /// Polylines from star to star. Empty for the second part of Serpens: the first has the figure of the entire constellation.
    pub figure: Vec<Vec<FigureVertex>>,
}

/// A segment of a border between two corners, along a circle of right ascension or declination of B1875.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderSegment {
    /// Right ascension and declination of B1875, radians. The right ascensions differ by at most half a turn, so the second may lie beyond ±pi.
    pub ends: [[f64; 2]; 2],
    /// The constellations on its two sides, in no particular order: indices in [`Constellations::all`].
    pub sides: [usize; 2],
}

/// All constellations, and the borders between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Constellations {
    /// One per constellation, but two for Serpens.
    pub all: Vec<Constellation>,
    /// The segments of all borders, in no particular order.
    pub borders: Vec<BorderSegment>,
}

/// Largest angle between a vertex and the star that it stands for. It is far above the rounding of the files, four decimals of a degree, because the epoch of
/// their positions is unknown, and stars of large proper motion may have moved since.
const SAME_STAR_RAD: f64 = 0.01 * PI / 180.0;

/// A GeoJSON FeatureCollection of lines; its coordinates are right ascension and declination, degrees.
#[derive(Deserialize)]
struct Collection {
    features: Vec<Feature>,
}

#[derive(Deserialize)]
struct Feature {
    /// Of a figure: the IAU abbreviation of its constellation.
    id: Option<String>,
    /// Of a border: the abbreviations of the constellations on its two sides, separated by a comma.
    ids: Option<String>,
    geometry: Geometry,
}

#[derive(Deserialize)]
struct Geometry {
    coordinates: Vec<Vec<[f64; 2]>>,
}

/// The unit vector of a right ascension and a declination.
fn direction([ra_deg, dec_deg]: [f64; 2]) -> DVec3 {
    let ((sin_ra, cos_ra), (sin_dec, cos_dec)) = (ra_deg.to_radians().sin_cos(), dec_deg.to_radians().sin_cos());
    DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec)
}

/// Right ascension, -pi to pi, and declination of a unit vector, radians.
fn ra_dec_rad(v: DVec3) -> [f64; 2] {
    [v.y.atan2(v.x), v.z.clamp(-1.0, 1.0).asin()]
}

/// Rotation from the mean equator and equinox of B1875.0 to ICRF: precession between B1875.0 and J2000 by the angles of Lieske (1977, A&A 58, 1). The borders
/// were drawn in the system of older star catalogs (FK4). The differences of FK4 from today's catalogs, up to an arcsecond, and the ICRF's offset from J2000
/// (0.02 arcseconds) are ignored.
pub fn icrf_from_b1875() -> glam::DMat3 {
    /// B1875.0 is JD 2405889.258.
    const CENTURIES_FROM_J2000: f64 = (2_405_889.258 - crate::units::JD_J2000) / crate::units::DAYS_PER_JULIAN_CENTURY;
    let t = CENTURIES_FROM_J2000;
    let angle = |a: f64, b: f64, c: f64| (a * t + b * t * t + c * t * t * t) * crate::units::RAD_PER_ARCSEC;
    let zeta = angle(2306.2181, 0.301_88, 0.017_998);
    let z = angle(2306.2181, 1.094_68, 0.018_203);
    let theta = angle(2004.3109, -0.426_65, -0.041_833);
    (glam::DMat3::from_rotation_z(z) * glam::DMat3::from_rotation_y(-theta) * glam::DMat3::from_rotation_z(zeta)).transpose()
}

impl Constellations {
    /// The 88 constellations that are embedded in the program. A test verifies that their files can be read, so this never panics in a released program.
    pub fn embedded() -> &'static Self {
        static EMBEDDED: LazyLock<Constellations> = LazyLock::new(|| match Constellations::read() {
            Ok(all) => all,
            Err(e) => panic!("the embedded constellations are broken: {e}"),
        });
        &EMBEDDED
    }

    fn read() -> Result<Self, serde_json::Error> {
        // Abbreviation, name, genitive, rank, and the position of the label; genitive and rank are not used.
        type Name = (String, String, String, String, [f64; 2]);
        let names: Vec<Name> = serde_json::from_str(orrery_catalogs::CONSTELLATION_NAMES)?;
        let figures: Collection = serde_json::from_str(orrery_catalogs::CONSTELLATION_LINES)?;
        let borders: Collection = serde_json::from_str(orrery_catalogs::CONSTELLATION_BORDERS)?;
        let stars = StarCatalog::embedded();
        let years_to_j2000 = stars.years_since_epoch(crate::units::JD_J2000);
        let vertex = |ra_dec_deg: [f64; 2]| {
            let direction = direction(ra_dec_deg);
            // The chord, which for such small angles equals the angle in radians.
            let distance = |index: usize| {
                let star = &stars.stars()[index];
                (star.direction + star.motion_per_year * years_to_j2000).normalize().distance(direction)
            };
            // Twice the angle, as a margin for proper motion: the bounds of cells hold at the epoch of the star catalog.
            let near = |cell: &&super::stars::SkyCell| cell.axis.dot(direction) > (cell.radius_rad + 2.0 * SAME_STAR_RAD).cos();
            let indices = stars.cells().iter().filter(near).flat_map(|cell| cell.stars.clone());
            // The brightest star at the vertex: of a double star, the brighter component.
            let at_vertex = indices.filter(|index| distance(*index) < SAME_STAR_RAD);
            let star = at_vertex.min_by(|a, b| stars.stars()[*a].v_magnitude.total_cmp(&stars.stars()[*b].v_magnitude));
            FigureVertex { direction, star }
        };
        // Serpens has two parts, each with a name entry. The first entry gets the figure of both parts.
        let mut abbreviations_with_figure = std::collections::BTreeSet::new();
        let constellation = |(abbreviation, name, _, _, label_ra_dec_deg): Name| {
            let is_first_entry = abbreviations_with_figure.insert(abbreviation.clone());
            let figures_of_name = figures.features.iter().filter(|f| is_first_entry && f.id.as_ref() == Some(&abbreviation));
            let lines = figures_of_name.flat_map(|f| &f.geometry.coordinates);
            let figure = lines.map(|line| line.iter().map(|ra_dec_deg| vertex(*ra_dec_deg)).collect()).collect();
            Constellation { abbreviation, name, label_direction: direction(label_ra_dec_deg), figure }
        };
        let all: Vec<Constellation> = names.into_iter().map(constellation).collect();
        let b1875_from_icrf = icrf_from_b1875().transpose();
        let border = |ends: &[[f64; 2]], sides: [usize; 2]| {
            let [a, b] = [ends[0], ends[1]].map(|end| ra_dec_rad(b1875_from_icrf * direction(end)));
            let turns = ((b[0] - a[0]) / TAU).round();
            BorderSegment { ends: [a, [b[0] - turns * TAU, b[1]]], sides }
        };
        let index_of = |abbreviation: &str| all.iter().position(|c| c.abbreviation == abbreviation);
        let mut segments = Vec::new();
        for feature in &borders.features {
            let sides = feature.ids.as_deref().and_then(|ids| ids.split_once(',')).and_then(|(a, b)| Some([index_of(a)?, index_of(b)?]));
            let sides = sides.ok_or_else(|| <serde_json::Error as serde::de::Error>::custom("a border without its two constellations"))?;
            segments.extend(feature.geometry.coordinates.iter().flat_map(|line| line.windows(2).map(|ends| border(ends, sides))));
        }
        Ok(Self { all, borders: segments })
    }

    /// The constellation that a direction (of any length, ICRF) lies in. On a border it is one of the neighbours.
    ///
    /// The hour circle of B1875 is followed from its north pole to the direction: each border on the way leads from one constellation to the next.
    pub fn containing(&self, direction_icrf: DVec3) -> Option<&Constellation> {
        let [ra, dec] = ra_dec_rad(icrf_from_b1875().transpose() * direction_icrf.try_normalize()?);
        // Declination at which a segment crosses the hour circle. The half-open test counts a border through a corner on the hour circle once.
        let crossing = |segment: &BorderSegment| {
            let [from, to] = segment.ends.map(|[end_ra, _]| (end_ra - ra + PI).rem_euclid(TAU) - PI);
            // The other two crossings of zero are those opposite the hour circle, where the difference leaps by a turn.
            let crosses = (from > 0.0) != (to > 0.0) && (to - from).abs() < PI;
            let [[_, dec_from], [_, dec_to]] = segment.ends;
            crosses.then(|| dec_from + (dec_to - dec_from) * from / (from - to)).filter(|crossing_dec| *crossing_dec > dec)
        };
        let mut crossings: Vec<(f64, [usize; 2])> = self.borders.iter().filter_map(|s| Some((crossing(s)?, s.sides))).collect();
        crossings.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut current = self.all.iter().position(|c| c.abbreviation == "UMi")?;
        for (_, [a, b]) in crossings {
            if a == current {
                current = b;
            } else if b == current {
                current = a;
            }
        }
        self.all.get(current)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_88_with_figures_of_catalogued_stars() {
        let sky = Constellations::embedded();
        let abbreviations: std::collections::BTreeSet<&str> = sky.all.iter().map(|c| c.abbreviation.as_str()).collect();
        assert_eq!(abbreviations.len(), 88);
        let vertices: Vec<&FigureVertex> = sky.all.iter().flat_map(|c| &c.figure).flatten().collect();
        let stars = vertices.iter().filter(|v| v.star.is_some()).count();
        println!("{stars} of {} vertices are stars", vertices.len());
        assert!(vertices.len() > 700 && 100 * stars > 97 * vertices.len(), "{stars} of {}", vertices.len());
        let orion = sky.all.iter().find(|c| c.abbreviation == "Ori").expect("Orion");
        let hips: Vec<u32> = orion.figure.iter().flatten().filter_map(|v| Some(StarCatalog::embedded().stars()[v.star?].hip)).collect();
        // Betelgeuse, Rigel, Bellatrix, the belt.
        assert!([27_989, 24_436, 25_336, 26_311, 26_727, 25_930].iter().all(|hip| hips.contains(hip)), "{hips:?}");
    }

    /// Positions of J2000, degrees, among them the two poles, both parts of Serpens, and Rho Aquilae, whose proper motion took it across the border to
    /// Delphinus.
    #[test]
    fn directions_lie_in_their_constellations() {
        let sky = Constellations::embedded();
        let places = [
            (101.287, -16.716, "CMa"),
            (37.95, 89.26, "UMi"),
            (317.2, -88.95, "Oct"),
            (0.0, 90.0, "UMi"),
            (180.0, -90.0, "Oct"),
            (303.57, 15.2, "Del"),
            (236.07, 6.43, "Ser"),
            (275.3, -2.9, "Ser"),
            (2.097, 29.09, "And"),
            (354.8, 77.6, "Cep"),
            (344.41, -29.62, "PsA"),
            (201.3, -11.16, "Vir"),
            (247.35, -26.43, "Sco"),
            (260.21, -24.99, "Oph"),
        ];
        for (ra, dec, abbreviation) in places {
            let found = sky.containing(direction([ra, dec])).expect("the whole sky is covered");
            assert_eq!(found.abbreviation, abbreviation, "{ra} {dec}");
        }
        assert!(sky.containing(DVec3::ZERO).is_none());
    }

    /// Areas of constellations, square degrees (IAU), from 40 000 directions that cover the sphere evenly, within 5. All 88 occur.
    #[test]
    fn constellations_have_their_published_areas() {
        let sky = Constellations::embedded();
        let count = 40_000;
        let mut found = std::collections::BTreeMap::<&str, f64>::new();
        for k in 0..count {
            let dec_deg = (-1.0 + (2.0 * f64::from(k) + 1.0) / f64::from(count)).asin().to_degrees();
            // Turned by the golden angle from one direction to the next.
            let ra_deg = (f64::from(k) * 137.507_764_05).rem_euclid(360.0);
            let constellation = sky.containing(direction([ra_deg, dec_deg])).expect("the whole sky is covered");
            *found.entry(constellation.abbreviation.as_str()).or_default() += 41_252.96 / f64::from(count);
        }
        assert_eq!(found.len(), 88);
        for (abbreviation, area) in [("Hya", 1302.84), ("UMa", 1279.66), ("Ser", 636.93), ("Oct", 291.05), ("UMi", 255.86), ("Cru", 68.45)]
        {
            assert!((found[abbreviation] - area).abs() < 5.0, "{abbreviation}: {} square degrees, not {area}", found[abbreviation]);
        }
    }

    /// Delporte's borders run along circles of right ascension and declination of B1875: in the coordinates of another equinox they would be slanted.
    #[test]
    fn borders_run_along_circles_of_1875() {
        let sky = Constellations::embedded();
        // How far a segment is from both a parallel and a meridian, degrees.
        let deviation_deg = |b: &BorderSegment| {
            let [[ra, dec], [ra2, dec2]] = b.ends;
            ((ra2 - ra).abs() * dec.cos().min(dec2.cos())).min((dec2 - dec).abs()).to_degrees()
        };
        let straight = sky.borders.iter().filter(|b| deviation_deg(b) < 0.005).count();
        println!("{straight} of {}", sky.borders.len());
        assert!(sky.borders.len() > 500 && 100 * straight > 97 * sky.borders.len(), "{straight} of {}", sky.borders.len());
        assert!(sky.borders.iter().all(|b| (b.ends[1][0] - b.ends[0][0]).abs() <= PI));
        // In the coordinates of J2000 the same borders are slanted, so the test can tell the two equinoxes apart.
        let in_j2000 = |end: [f64; 2]| {
            let v = icrf_from_b1875() * direction(end.map(f64::to_degrees));
            [v.y.atan2(v.x), v.z.asin()]
        };
        let straight_in_j2000 =
            sky.borders.iter().filter(|b| deviation_deg(&BorderSegment { ends: b.ends.map(in_j2000), sides: b.sides }) < 0.005).count();
        assert!(2 * straight_in_j2000 < sky.borders.len(), "{straight_in_j2000}");
    }
}
