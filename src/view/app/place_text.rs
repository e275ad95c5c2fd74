//! Short text for places on a body.
//!
//! In: latitudes, longitudes. Out: text. Not here: times (`language::dates`).

use crate::events::GeodeticPosition;
use crate::view::language::{decimal, named};

/// `25.5° N, 33.2° E`.
pub(crate) fn place_text(place: GeodeticPosition) -> String {
    place_degrees(place.latitude_deg, place.longitude_deg, 1)
}

/// Latitude and longitude with compass directions instead of signs.
pub(crate) fn place_degrees(latitude_deg: f64, longitude_deg: f64, digits: usize) -> String {
    let side = |deg: f64, positive, negative| {
        let direction = named("direction", if deg < 0.0 { negative } else { positive });
        format!("{}° {direction}", decimal(deg.abs(), digits))
    };
    format!("{}, {}", side(latitude_deg, "north", "south"), side(longitude_deg, "east", "west"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_compass_directions() {
        let place = |latitude_deg, longitude_deg| place_text(GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 });
        assert_eq!(place(25.49, -104.13), "25.5° N, 104.1° W");
        assert_eq!(place(-33.0, 18.0), "33.0° S, 18.0° E");
    }
}
