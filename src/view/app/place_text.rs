//! Latitude and longitude as text, with translated compass directions.
//!
//! In: latitudes, longitudes. Out: text. Not here: positions of bodies as vectors (`body_positions`).

use crate::events::GeodeticPosition;
use crate::view::language::{decimal, named};

/// `25.5° N, 33.2° E`.
pub(crate) fn place_text(place: GeodeticPosition) -> String {
    latitude_longitude_text(place.latitude_deg, place.longitude_deg, 1)
}

/// Latitude and longitude with compass directions instead of signs.
pub(crate) fn latitude_longitude_text(latitude_deg: f64, longitude_deg: f64, decimals: usize) -> String {
    let with_direction = |deg: f64, positive, negative| {
        let direction = named("direction", if deg < 0.0 { negative } else { positive });
        format!("{}° {direction}", decimal(deg.abs(), decimals))
    };
    format!("{}, {}", with_direction(latitude_deg, "north", "south"), with_direction(longitude_deg, "east", "west"))
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
