//! Names on the surfaces of bodies: the features of the IAU's gazetteer, and crewed landing sites.
//!
//! In: the embedded tables nomenclature_usgs.csv and landing_sites.csv. Out: the features of a body: landing sites first, then the others from large to small.
//! Always: the tables' latitudes are taken as planetocentric and their longitudes as east, which is right for Mars and for nearly spherical bodies. For oblate
//! moons the gazetteer gives planetographic latitudes, so their features are off by up to 5 degrees on Mimas and 2 on Enceladus. Not here: the choice of the
//! names that an image shows.

use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// A named place.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFeature {
    /// The name in the table.
    pub name: &'static str,
    /// Unit vector from the body's centre, in body-fixed axes: z to the north pole, x to longitude 0 on the equator.
    pub direction: DVec3,
    /// Diameter; 0 if the table gives none, and for landing sites.
    pub diameter_km: f64,
    /// Size by which an image decides whether to show the name: the diameter, or the width of elongated features such as valleys, ridges and rilles. Their
    /// diameter in the gazetteer is their length, and the width is assumed to be a quarter of that.
    pub effective_size_km: f64,
    /// Whether it is a landing site.
    pub is_landing_site: bool,
}

/// The gazetteer's codes of elongated feature types: catena, chasma, dorsum, fossa, linea, flumen, rima, rupes, scopulus, sulcus, vallis.
const ELONGATED_TYPES: [&str; 11] = ["CA", "CM", "DO", "FO", "LI", "FM", "RI", "RU", "SC", "SU", "VA"];
/// Assumed ratio of width to length of these types.
const ELONGATED_WIDTH_TO_LENGTH: f64 = 0.25;

impl SurfaceFeature {
    /// Parses the fields of a table's line; `None` if one is not a number where it should be. `latitude`, `longitude`: degrees. `feature_type`: the gazetteer's
    /// code, empty for a landing site. `diameter_km`: empty for a feature without a diameter; `None` for a landing site, whose table has no diameters.
    fn parse(name: &'static str, feature_type: &str, latitude: &str, longitude: &str, diameter_km: Option<&str>) -> Option<Self> {
        let (lat, lon): (f64, f64) = (latitude.parse().ok()?, longitude.parse().ok()?);
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (lat.to_radians().sin_cos(), lon.to_radians().sin_cos());
        let is_landing_site = diameter_km.is_none();
        let diameter_km: f64 = match diameter_km {
            None | Some("") => 0.0,
            Some(text) => text.parse().ok()?,
        };
        Some(Self {
            name,
            direction: DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
            diameter_km,
            effective_size_km: diameter_km * if ELONGATED_TYPES.contains(&feature_type) { ELONGATED_WIDTH_TO_LENGTH } else { 1.0 },
            is_landing_site,
        })
    }

    /// The body and the feature of a line: seven fields in the gazetteer, four in the table of landing sites. `None` if the line cannot be read.
    fn from_line(line: &'static str) -> Option<(&'static str, Self)> {
        match line.split(',').collect::<Vec<_>>()[..] {
            [body, _usgs_id, name, feature_type, lat, lon, diameter] => {
                Some((body, Self::parse(name, feature_type, lat, lon, Some(diameter))?))
            }
            [body, name, lat, lon] => Some((body, Self::parse(name, "", lat, lon, None)?)),
            _ => None,
        }
    }
}

/// The data lines of both tables, without comments and headings.
fn lines() -> impl Iterator<Item = &'static str> {
    let rows = |table: &'static str| table.lines().filter(|l| !l.starts_with('#') && !l.is_empty()).skip(1);
    rows(orrery_catalogs::LANDING_SITES).chain(rows(orrery_catalogs::NOMENCLATURE))
}

static BY_BODY: LazyLock<BTreeMap<String, Vec<SurfaceFeature>>> = LazyLock::new(|| {
    let mut all: BTreeMap<String, Vec<SurfaceFeature>> = BTreeMap::new();
    for (body, feature) in lines().filter_map(SurfaceFeature::from_line) {
        all.entry(body.to_lowercase()).or_default().push(feature);
    }
    let order = |a: &SurfaceFeature, b: &SurfaceFeature| {
        b.is_landing_site.cmp(&a.is_landing_site).then(b.effective_size_km.total_cmp(&a.effective_size_km)).then(a.name.cmp(b.name))
    };
    all.values_mut().for_each(|features| features.sort_by(order));
    all
});

/// The features of the body with this name, landing sites first, then the others from large to small; none for a body without named features.
pub fn surface_features(body: &str) -> &'static [SurfaceFeature] {
    BY_BODY.get(&body.to_lowercase()).map_or(&[], Vec::as_slice)
}

/// All characters of the names, for the glyph atlas.
pub fn characters() -> impl Iterator<Item = char> {
    BY_BODY.values().flatten().flat_map(|f| f.name.chars())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Latitude and east longitude, degrees, and the diameter, km, of a feature.
    fn place_and_diameter(body: &str, name: &str) -> (f64, f64, f64) {
        let feature = surface_features(body).iter().find(|f| f.name == name).unwrap_or_else(|| panic!("{name}"));
        let direction = feature.direction;
        (direction.z.asin().to_degrees(), direction.y.atan2(direction.x).to_degrees().rem_euclid(360.0), feature.diameter_km)
    }

    /// Each line is read, and well-known features are within 1.5 degrees and 5 % of the gazetteer's own pages (planetarynames.wr.usgs.gov). The place of Apollo
    /// 11 is that of the table.
    #[test]
    fn the_tables_are_read_and_coordinates_agree_with_the_gazetteer() {
        let unread: Vec<_> = lines().filter(|l| SurfaceFeature::from_line(l).is_none()).collect();
        assert!(unread.is_empty(), "{unread:?}");
        // Features of the gazetteer, and landing sites.
        assert_eq!(lines().count(), 6320 + 6);
        for (body, name, lat, lon, diameter) in [
            ("Moon", "Tycho", -43.3, 348.8, 85.0),
            ("moon", "Copernicus", 9.6, 339.9, 96.0),
            ("Mars", "Olympus Mons", 18.65, 226.2, 610.0),
            ("Mars", "Gale", -5.4, 137.8, 154.0),
            ("Mercury", "Caloris Planitia", 31.5, 162.7, 1550.0),
            ("Moon", "Apollo 11", 0.67, 23.47, 0.0),
        ] {
            let (found_lat, found_lon, found_diameter) = place_and_diameter(body, name);
            assert!((found_lat - lat).abs() < 1.5 && (found_lon - lon).abs() < 1.5, "{name}: {found_lat} {found_lon}");
            assert!((found_diameter - diameter).abs() <= 0.05 * diameter, "{name}: {found_diameter}");
        }
        let moon = surface_features("Moon");
        assert!(
            moon[..6].iter().all(|f| f.is_landing_site) && moon[6..].windows(2).all(|w| w[0].effective_size_km >= w[1].effective_size_km)
        );
        assert!(surface_features("Nibiru").is_empty());
    }
}
