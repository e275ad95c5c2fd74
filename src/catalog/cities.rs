//! Cities of the Earth by name, with their coordinates.
//!
//! In: the embedded table cities.csv, and a prefix. Out: the cities whose name starts with the prefix, then those with the prefix at the start of
//! a later word.
//! Always: coordinates are those of the table, to a minute of arc or 0.02 degrees: about two kilometres. The table lists the cities after
//! which time zones are named, other large cities, and cities on the paths of eclipses.

use std::sync::LazyLock;

/// A city.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct City {
    /// English name.
    pub name: &'static str,
    /// English name of the country.
    pub country: &'static str,
    /// Latitude, positive north.
    pub latitude_deg: f64,
    /// Longitude, positive east.
    pub longitude_deg: f64,
}

impl City {
    /// Parses a line of the table: name, latitude, longitude, country. `None` if a field is missing or a coordinate is not a number.
    fn from_line(line: &'static str) -> Option<Self> {
        let mut fields = line.splitn(4, ',');
        let (name, latitude, longitude, country) = (fields.next()?, fields.next()?, fields.next()?, fields.next()?);
        Some(Self { name, country, latitude_deg: latitude.parse().ok()?, longitude_deg: longitude.parse().ok()? })
    }
}

static CITIES: LazyLock<Vec<City>> = LazyLock::new(|| {
    // The first line below the comments names the columns.
    let lines = orrery_catalogs::CITIES.lines().filter(|l| !l.starts_with('#')).skip(1);
    lines.filter_map(City::from_line).collect()
});

/// All cities, sorted by name.
pub fn all() -> &'static [City] {
    &CITIES
}

/// At most `limit` cities: first those whose name starts with `text`, then those of which a later word does. Case is ignored. Empty if `text` has fewer than
/// two characters.
pub fn with_prefix(text: &str, limit: usize) -> Vec<&'static City> {
    let prefix = text.trim().to_lowercase();
    if prefix.chars().count() < 2 {
        return Vec::new();
    }
    let starts_name = |c: &&City| c.name.to_lowercase().starts_with(&prefix);
    let starts_word = |c: &&City| !starts_name(c) && c.name.to_lowercase().split([' ', '-']).any(|word| word.starts_with(&prefix));
    CITIES.iter().filter(starts_name).chain(CITIES.iter().filter(starts_word)).take(limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Landmarks, with coordinates from other sources, lie within 0.2 degrees of their city.
    #[test]
    fn coordinates_agree_with_landmarks() {
        for (name, country, latitude_deg, longitude_deg) in [
            // Royal Observatory Greenwich; Paris and Sydney Observatory; Griffith Observatory.
            ("London", "Britain (UK)", 51.477, 0.0),
            ("Paris", "France", 48.836, 2.337),
            ("Sydney", "Australia", -33.860, 151.204),
            ("Los Angeles", "United States", 34.118, -118.300),
            // Monument Circle; Hallgrimskirkja.
            ("Indianapolis", "United States", 39.768, -86.158),
            ("Reykjavik", "Iceland", 64.142, -21.927),
            // Reunion Tower; the tower of the Deutsches Museum; the Temple of Karnak.
            ("Dallas", "United States", 32.775, -96.809),
            ("Munich", "Germany", 48.130, 11.583),
            ("Luxor", "Egypt", 25.719, 32.657),
        ] {
            let found = with_prefix(&name.to_lowercase(), 1);
            let [city] = found[..] else { panic!("{name}: {found:?}") };
            assert_eq!((city.name, city.country), (name, country));
            let difference_deg = (city.latitude_deg - latitude_deg).abs().max((city.longitude_deg - longitude_deg).abs());
            assert!(difference_deg < 0.2, "{name} is off by {difference_deg} degrees");
        }
    }

    #[test]
    fn every_line_is_a_city_and_prefixes_find_cities() {
        // Without the line that names the columns.
        let lines = orrery_catalogs::CITIES.lines().filter(|l| !l.starts_with('#')).count() - 1;
        assert!(lines > 400 && all().len() == lines, "{} of {lines}", all().len());
        assert!(all().iter().all(|c| c.latitude_deg.abs() <= 90.0 && c.longitude_deg.abs() <= 180.0 && !c.country.is_empty()));
        assert!(with_prefix("a", 9).is_empty() && with_prefix("york", 9)[0].name == "New York" && with_prefix("xyzzy", 9).is_empty());
    }
}
