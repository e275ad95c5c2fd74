//! The path of a central eclipse on the ground: centre line and limits.
//!
//! In: a solar eclipse. Out: places on the centre line at equal steps of time, and on both limits. A limit is the farthest
//! place, on a great circle perpendicular to the path, at which the eclipse is still total or annular. Not here: the limits beyond the ends of the centre line,
//! where only one side of the shadow meets the ground. [`cut_at_antimeridian`] cuts any line of places for GeoJSON.

use super::local::GeodeticPosition;
use super::solar::SolarEclipse;
use crate::time::Instant;
use std::f64::consts::FRAC_PI_2;

/// Number of steps, equal in time, along the centre line.
const STEPS: i32 = 120;
/// The first distance from the centre line at which a limit is searched, degrees of arc; it is doubled until the eclipse is neither total nor annular.
const FIRST_OFFSET_DEG: f64 = 0.02;
/// The search for a limit gives up above this distance. Because the distance is doubled, the last one tried is 20.48 degrees. Where the antumbra grazes the
/// ground, a sunlit limit can be more than 11 degrees (1200 km) from the centre line.
const MAX_OFFSET_DEG: f64 = 25.0;

/// Tolerance of the distance of a limit from the centre line, degrees of arc: 11 m.
const LIMIT_TOLERANCE_DEG: f64 = 1e-4;

/// A path on the ground, in the direction in which the shadow moves.
#[derive(Clone, Debug, Default)]
pub struct EclipsePath {
    /// Where the axis of the shadow meets the ground, by time.
    pub centre_line: Vec<(Instant, GeodeticPosition)>,
    /// North of the centre line; a point is missing where the umbra or antumbra extends beyond the sunlit ground.
    pub northern_limit: Vec<GeodeticPosition>,
    /// South of the centre line; points are missing for the same reason.
    pub southern_limit: Vec<GeodeticPosition>,
}

impl SolarEclipse {
    /// The path of the eclipse; `None` if the axis of the shadow misses the ground.
    pub fn path(&self) -> Option<EclipsePath> {
        let geometry = &self.geometry;
        let (start_s, end_s) = geometry.central_span()?;
        let mut path = EclipsePath::default();
        // Degrees of latitude by which the left limit is north of the right one, summed over the steps; a missing point counts as one on the centre
        // line.
        let mut left_is_north_by_deg = 0.0;
        for i in 0..=STEPS {
            // Slightly inside the span, where the axis certainly meets the ground.
            let fraction = (f64::from(i) / f64::from(STEPS)).clamp(1e-5, 1.0 - 1e-5);
            // Seconds from the mean new moon, as all times of the eclipse's geometry.
            let s = start_s + (end_s - start_s) * fraction;
            let Some(centre) = geometry.centre(s) else { continue };
            path.centre_line.push((geometry.sky.instant(s), centre));
            let step_s = 1e-3 * (end_s - start_s);
            // Ahead in the first half and behind in the second, so that the other place is inside the span, too.
            let heading_rad = match (fraction < 0.5, geometry.centre(s + step_s), geometry.centre(s - step_s)) {
                (true, Some(ahead), _) => bearing_rad(centre, ahead),
                (false, _, Some(behind)) => bearing_rad(behind, centre),
                _ => continue,
            };
            // Left and right of the shadow's motion: north and south, unless the path goes westward over a pole.
            let (left, right) = (self.limit(s, centre, heading_rad - FRAC_PI_2), self.limit(s, centre, heading_rad + FRAC_PI_2));
            let northward_deg = |limit: Option<GeodeticPosition>| limit.map_or(0.0, |p| p.latitude_deg - centre.latitude_deg);
            left_is_north_by_deg += northward_deg(left) - northward_deg(right);
            path.northern_limit.extend(left);
            path.southern_limit.extend(right);
        }
        if left_is_north_by_deg < 0.0 {
            std::mem::swap(&mut path.northern_limit, &mut path.southern_limit);
        }
        Some(path)
    }

    /// The place farthest from `centre`, on the great circle that leaves `centre` at `bearing_rad`, where the eclipse is still total or annular. `None` if it
    /// is beyond [`MAX_OFFSET_DEG`], or if the Sun is more than a degree below the place's horizon when the phase there is greatest. `s`: when the shadow's
    /// axis is at `centre`, in seconds from the mean new moon.
    fn limit(&self, s: f64, centre: GeodeticPosition, bearing_rad: f64) -> Option<GeodeticPosition> {
        let geometry = &self.geometry;
        let is_total_or_annular =
            |distance_deg: f64| geometry.station(place_along(centre, bearing_rad, distance_deg)).total_or_annular_instant_near(s).is_some();
        let (mut inside_deg, mut outside_deg) = (0.0, FIRST_OFFSET_DEG);
        while is_total_or_annular(outside_deg) {
            inside_deg = outside_deg;
            outside_deg *= 2.0;
            if outside_deg > MAX_OFFSET_DEG {
                return None;
            }
        }
        while outside_deg - inside_deg > LIMIT_TOLERANCE_DEG {
            let middle_deg = 0.5 * (inside_deg + outside_deg);
            if is_total_or_annular(middle_deg) { inside_deg = middle_deg } else { outside_deg = middle_deg }
        }
        let place = place_along(centre, bearing_rad, inside_deg);
        let station = geometry.station(place);
        // Far from the centre line the phase is greatest up to an hour before or after `s`, at another altitude of the Sun.
        // The altitude is without refraction; with it, the Sun's upper limb is above the horizon down to an altitude of -0.8 degrees.
        let greatest_s = station.total_or_annular_instant_near(s).unwrap_or(s);
        (station.sun_altitude_deg(greatest_s) > -1.0).then_some(place)
    }
}

/// Direction from one place to another along a great circle, from north through east, on a sphere with the places' geodetic coordinates.
fn bearing_rad(from: GeodeticPosition, to: GeodeticPosition) -> f64 {
    let (from_lat, to_lat) = (from.latitude_deg.to_radians(), to.latitude_deg.to_radians());
    let delta_lon = (to.longitude_deg - from.longitude_deg).to_radians();
    (delta_lon.sin() * to_lat.cos()).atan2(from_lat.cos() * to_lat.sin() - from_lat.sin() * to_lat.cos() * delta_lon.cos())
}

/// The place that is reached from another, on the sphere of [`bearing_rad`], by a distance (degrees of arc) along the great circle that leaves it at a
/// bearing.
fn place_along(from: GeodeticPosition, bearing_rad: f64, distance_deg: f64) -> GeodeticPosition {
    let (lat, distance) = (from.latitude_deg.to_radians(), distance_deg.to_radians());
    let sin_lat = (lat.sin() * distance.cos() + lat.cos() * distance.sin() * bearing_rad.cos()).clamp(-1.0, 1.0);
    let delta_lon = (bearing_rad.sin() * distance.sin() * lat.cos()).atan2(distance.cos() - lat.sin() * sin_lat);
    let longitude_deg = (from.longitude_deg + delta_lon.to_degrees() + 540.0).rem_euclid(360.0) - 180.0;
    GeodeticPosition { latitude_deg: sin_lat.asin().to_degrees(), longitude_deg, height_km: 0.0 }
}

/// A vertex of a line that was cut at the antimeridian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutVertex {
    /// East longitude, degrees.
    pub longitude_deg: f64,
    /// Geodetic latitude, degrees.
    pub latitude_deg: f64,
    /// Fractional index into the places of the uncut line: 2.25 is a quarter of the way from its place 2, counted from 0, to its place 3.
    pub fractional_index: f64,
}

/// A line of places, cut where it crosses the antimeridian, as GeoJSON requires (RFC 7946, section 3.1.9). Each cut adds two vertices, which belong to none of
/// the places; with their `fractional_index`, a caller interpolates other properties of the places, such as times.
pub fn cut_at_antimeridian(places: &[GeodeticPosition]) -> Vec<Vec<CutVertex>> {
    let mut lines: Vec<Vec<CutVertex>> = vec![Vec::new()];
    let mut previous: Option<CutVertex> = None;
    for (k, place) in places.iter().enumerate() {
        let vertex = CutVertex { longitude_deg: place.longitude_deg, latitude_deg: place.latitude_deg, fractional_index: k as f64 };
        if let Some(previous) = previous.replace(vertex).filter(|p| (p.longitude_deg - vertex.longitude_deg).abs() > 180.0) {
            let edge_deg = 180.0_f64.copysign(previous.longitude_deg);
            // Degrees of longitude from the earlier place to the antimeridian, and to the later place.
            let to_antimeridian_deg = (edge_deg - previous.longitude_deg).abs();
            let to_later_place_deg = 360.0 - (previous.longitude_deg - vertex.longitude_deg).abs();
            let fraction = if to_later_place_deg > 0.0 { to_antimeridian_deg / to_later_place_deg } else { 0.0 };
            let interpolated = |from: f64, to: f64| from + (to - from) * fraction;
            let at_edge = CutVertex {
                longitude_deg: edge_deg,
                latitude_deg: interpolated(previous.latitude_deg, vertex.latitude_deg),
                fractional_index: interpolated(previous.fractional_index, vertex.fractional_index),
            };
            lines.last_mut().into_iter().for_each(|line| line.push(at_edge));
            lines.push(vec![CutVertex { longitude_deg: -edge_deg, ..at_edge }]);
        }
        lines.last_mut().into_iter().for_each(|line| line.push(vertex));
    }
    lines.retain(|line| line.len() > 1);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(latitude_deg: f64, longitude_deg: f64) -> GeodeticPosition {
        GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 }
    }

    #[test]
    fn the_bearing_to_a_destination_is_the_bearing_it_was_computed_from() {
        for (lat, lon) in [(0.0, 0.0), (60.0, 179.0), (-45.0, -100.0)] {
            for bearing_deg in [10.0_f64, 100.0, 200.0, 300.0] {
                let distance_deg = 3.0;
                let reached = place_along(place(lat, lon), bearing_deg.to_radians(), distance_deg);
                let found_deg = bearing_rad(place(lat, lon), reached).to_degrees().rem_euclid(360.0);
                assert!((found_deg - bearing_deg).abs() < 1e-9, "{lat} {lon} {bearing_deg}: {found_deg}");
            }
        }
    }

    #[test]
    fn a_line_over_the_antimeridian_is_cut_there() {
        let cut = cut_at_antimeridian(&[place(10.0, 170.0), place(12.0, 178.0), place(14.0, -178.0), place(16.0, -170.0)]);
        let numbers =
            |line: &Vec<CutVertex>| line.iter().map(|v| [v.longitude_deg, v.latitude_deg, v.fractional_index]).collect::<Vec<_>>();
        assert_eq!(
            cut.iter().map(numbers).collect::<Vec<_>>(),
            [[[170.0, 10.0, 0.0], [178.0, 12.0, 1.0], [180.0, 13.0, 1.5]], [[-180.0, 13.0, 1.5], [-178.0, 14.0, 2.0], [-170.0, 16.0, 3.0]]]
        );
        assert_eq!(cut_at_antimeridian(&[place(0.0, -10.0), place(0.0, 10.0)]).len(), 1);
    }
}
