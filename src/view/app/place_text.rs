//! Latitude and longitude as text, with translated compass directions; typed latitudes and longitudes.
//!
//! In: latitudes, longitudes, or typed text. Out: text, or latitude and longitude. Always: the text of a place is read back as that place. Not here:
//! positions of bodies as vectors (`body_positions`).

use crate::events::GeodeticPosition;
use crate::view::language::numbers::typed_degrees;
use crate::view::language::{decimal, translated_name};

/// A place with one decimal, such as `25.5° N, 33.2° E`.
pub(crate) fn place_text(place: GeodeticPosition) -> String {
    latitude_longitude_text(place.latitude_deg, place.longitude_deg, 1)
}

/// Latitude and longitude with compass directions instead of signs.
pub(crate) fn latitude_longitude_text(latitude_deg: f64, longitude_deg: f64, decimals: usize) -> String {
    let with_direction = |deg: f64, positive, negative| {
        let direction = translated_name("direction", if deg < 0.0 { negative } else { positive });
        format!("{}° {direction}", decimal(deg.abs(), decimals))
    };
    format!("{}, {}", with_direction(latitude_deg, "north", "south"), with_direction(longitude_deg, "east", "west"))
}

/// Reads latitude and east longitude in degrees, such as `51.5, -0.1`, `31.3° S, 48.5° W`, or in German `51,5; -0,1`. `None` if the text is something
/// else, or if a value is outside its range.
pub(crate) fn parse_place(text: &str) -> Option<(f64, f64)> {
    parse_place_without_limits(text).filter(|(latitude_deg, longitude_deg)| latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0)
}

/// Reads latitude and east longitude as [`parse_place`] does, but without limits.
pub(crate) fn parse_place_without_limits(text: &str) -> Option<(f64, f64)> {
    // The separators are tried in this order, because a comma without a space may be a decimal mark.
    let (latitude, longitude) = text.split_once(';').or_else(|| text.split_once(", ")).or_else(|| text.split_once(','))?;
    Some((typed_latitude_deg(latitude)?, typed_longitude_deg(longitude)?))
}

/// Reads a latitude in degrees, without limits, such as `31.3° S` or `-31.3`.
pub(crate) fn typed_latitude_deg(text: &str) -> Option<f64> {
    typed_with_direction(text, "north", "south")
}

/// Reads an east longitude in degrees, without limits, such as `48.5° W` or `-48.5`.
pub(crate) fn typed_longitude_deg(text: &str) -> Option<f64> {
    typed_with_direction(text, "east", "west")
}

/// Reads an angle in degrees: with a sign, or with the first letter of a direction in English or in the language of the window. `positive`, `negative`:
/// the English names of the directions of positive and of negative angles.
fn typed_with_direction(text: &str, positive: &str, negative: &str) -> Option<f64> {
    let text = text.trim().to_lowercase();
    let without_direction = |direction: &str| {
        let translated = translated_name("direction", direction).to_lowercase();
        text.strip_suffix(translated.as_str()).or_else(|| text.strip_suffix(direction.get(..1)?))
    };
    // With a direction, a number has no sign.
    let unsigned = |text: &str| typed_degrees(text).filter(|degrees| degrees.is_sign_positive());
    match (without_direction(positive), without_direction(negative)) {
        (Some(text), _) => unsigned(text),
        // Not `-degrees`, so that an angle of 0 gets no sign.
        (None, Some(text)) => unsigned(text).map(|degrees| 0.0 - degrees),
        (None, None) => typed_degrees(&text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::language::{Language, set};

    #[test]
    fn places_have_compass_directions() {
        let place = |latitude_deg, longitude_deg| place_text(GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 });
        assert_eq!(place(25.49, -104.13), "25.5° N, 104.1° W");
        assert_eq!(place(-33.0, 18.0), "33.0° S, 18.0° E");
    }

    /// A place is read with signs or directions, and with the decimal mark of the language.
    #[test]
    fn places_are_read_in_the_language_of_the_window() {
        set(Language::English);
        for (text, place) in [
            ("51.5, -0.1", Some((51.5, -0.1))),
            ("51.5,-0.1", Some((51.5, -0.1))),
            ("51.5°, -0.1°", Some((51.5, -0.1))),
            ("31.3° S, 48.5° W", Some((-31.3, -48.5))),
            ("31.3s; 48.5 e", Some((-31.3, 48.5))),
            ("90, 360", Some((90.0, 360.0))),
            ("91, 0", None),
            ("0, 361", None),
            ("-31.3 S, 48.5 W", None),
            ("48.5 W, 31.3 S", None),
            ("nan, 0", None),
            ("inf, 0", None),
            ("N, E", None),
            ("51,5; -0,1", None),
            ("Apr 8, 2024", None),
            ("é, °", None),
        ] {
            assert_eq!(parse_place(text), place, "{text}");
        }
        assert_eq!(parse_place_without_limits("98.3, 500"), Some((98.3, 500.0)));
        for language in [Language::English, Language::German] {
            set(language);
            for (latitude_deg, longitude_deg) in [(25.5, 104.1), (-25.5, 104.1), (25.5, -104.1), (-0.1, -0.1), (0.0, 0.0)] {
                let text = latitude_longitude_text(latitude_deg, longitude_deg, 1);
                assert_eq!(parse_place(&text), Some((latitude_deg, longitude_deg)), "{text}");
            }
        }
        for text in ["51,5; -0,1", "51,5, -0,1", "51.5, -0.1", "51,5° N, 0,1° W", "51,5 n; 359,9 o"] {
            let (latitude_deg, longitude_deg) = parse_place(text).expect(text);
            assert!((latitude_deg - 51.5).abs() < 1e-9 && (longitude_deg.rem_euclid(360.0) - 359.9).abs() < 1e-9, "{text}");
        }
        set(Language::English);
    }
}
