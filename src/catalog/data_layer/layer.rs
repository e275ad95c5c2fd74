//! Data layers, with points, lines or an image, and the points and lines that a file contains.
//!
//! In: points and lines, as the readers of the formats find them. Out: [`Content`] and [`DataLayer`]. Always: the number of positions (points and vertices of
//! lines) and the total length of the lines are limited, per layer and for all layers together.

use super::fits::PlacedImage;
use super::image_style::ImageStyle;
use crate::catalog::NaifId;
use crate::time::Instant;
use crate::wording::counted;
use std::sync::Arc;

/// Maximum number of points and line vertices of a layer together.
pub(super) const MAX_POSITIONS: usize = 1_000_000;

/// Maximum number of points and line vertices of all layers of a catalog together.
const MAX_POSITIONS_OF_ALL_LAYERS: usize = 2 * MAX_POSITIONS;

/// Maximum total length of the lines of a layer, and of all layers together, degrees of longitude and latitude: 4,000 times around a globe. Lines are drawn
/// in short steps: without this limit, a file of one megabyte whose lines go tens of thousands of times around would take 6 GB of memory.
const MAX_LENGTH_DEG: f64 = 4000.0 * 360.0;

/// A layer of data.
#[derive(Clone, Debug, PartialEq)]
pub struct DataLayer {
    /// The layer's name.
    pub name: String,
    /// Name of the file, which is in the folder of the catalog file.
    pub file: String,
    /// The body on which the layer lies; `None`: the sky.
    pub body: Option<NaifId>,
    /// Default diameter of a point: pixels in an image 1024 pixels high.
    pub size_px: f64,
    /// Default colour, sRGB.
    pub colour: [u8; 3],
    /// Days over which a point or line fades after its time; `None`: it does not fade.
    pub fade_days: Option<f64>,
    /// How the values of an image are converted to colours.
    pub style: ImageStyle,
    /// Points from the file.
    pub points: Arc<Vec<DataPoint>>,
    /// Lines from the file.
    pub lines: Arc<Vec<DataLine>>,
    /// The image from the file, if it has one.
    pub image: Option<Arc<PlacedImage>>,
    /// SHA-256 of the file, hexadecimal; empty until the file is read.
    pub digest: String,
}

/// A point of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataPoint {
    /// Planetographic latitude on a body, declination (ICRF) in the sky; degrees.
    pub lat_deg: f64,
    /// East longitude on a body, right ascension (ICRF) in the sky; degrees.
    pub lon_deg: f64,
    /// Time from which on the point is shown; `None`: always.
    pub time: Option<Instant>,
    /// Diameter like [`DataLayer::size_px`], if the file gives it.
    pub size_px: Option<f64>,
    /// sRGB, if the file gives it.
    pub colour: Option<[u8; 3]>,
}

/// A line on the ground, straight in longitude and latitude from vertex to vertex. Only layers on a body have lines.
#[derive(Clone, Debug, PartialEq)]
pub struct DataLine {
    /// At least two vertices: [planetographic latitude, east longitude], degrees.
    pub vertices: Vec<[f64; 2]>,
    /// Time from which on the line is shown; `None`: always.
    pub time: Option<Instant>,
}

/// The points and lines of a file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Content {
    pub points: Vec<DataPoint>,
    pub lines: Vec<DataLine>,
    position_count: usize,
    /// Total length of the lines.
    length_deg: f64,
}

impl Content {
    /// Counts positions before they are added; an error if there are too many.
    pub fn count_positions(&mut self, added: usize) -> Result<(), String> {
        self.position_count += added;
        if self.position_count > MAX_POSITIONS { Err(format!("more than {MAX_POSITIONS} positions")) } else { Ok(()) }
    }

    /// Adds a line. Vertices are as in [`DataLine::vertices`]; fewer than two are an error.
    pub fn add_line(&mut self, vertices: Vec<[f64; 2]>, time: Option<Instant>) -> Result<(), String> {
        self.count_positions(vertices.len())?;
        check_is_line(&vertices)?;
        self.add_length(length_deg(&vertices))?;
        self.lines.push(DataLine { vertices, time });
        Ok(())
    }

    /// Adds the points and lines of `other`.
    pub fn append(&mut self, other: Self) -> Result<(), String> {
        self.count_positions(other.position_count)?;
        self.add_length(other.length_deg)?;
        self.points.extend(other.points);
        self.lines.extend(other.lines);
        Ok(())
    }

    /// Adds to the total length of the lines; an error if the total is more than [`MAX_LENGTH_DEG`].
    fn add_length(&mut self, length_deg: f64) -> Result<(), String> {
        self.length_deg += length_deg;
        match self.length_deg > MAX_LENGTH_DEG {
            true => Err(format!("the lines are longer than {} times around the globe", MAX_LENGTH_DEG / 360.0)),
            false => Ok(()),
        }
    }

    /// Adds a point without its own size and colour.
    pub fn add_point(&mut self, [lat_deg, lon_deg]: [f64; 2], time: Option<Instant>) -> Result<(), String> {
        self.count_positions(1)?;
        self.points.push(DataPoint { lat_deg, lon_deg, time, size_px: None, colour: None });
        Ok(())
    }
}

/// Checks that a line has at least two vertices.
pub(super) fn check_is_line(vertices: &[[f64; 2]]) -> Result<(), String> {
    match vertices.len() {
        count @ 0..2 => Err(format!("a line with {}; two are needed", counted(count, "position"))),
        _ => Ok(()),
    }
}

/// Length of a polyline, degrees: the sum over its segments of the changes of latitude and longitude, where longitude takes the shorter way around. Exception:
/// a line of two vertices at the same latitude, a whole turn or more apart, is drawn along the parallel all the way.
fn length_deg(vertices: &[[f64; 2]]) -> f64 {
    let segment_length = |[a, b]: &[[f64; 2]; 2]| {
        let longitude_change = (b[1] - a[1]).abs();
        // Slightly less than 360, for the rounding of coordinates.
        if vertices.len() == 2 && a[0] == b[0] && longitude_change > 359.999_999 {
            return longitude_change;
        }
        // Longitudes from -360 to 360 degrees may differ by almost two turns.
        let within_turn = longitude_change.rem_euclid(360.0);
        (b[0] - a[0]).abs() + within_turn.min(360.0 - within_turn)
    };
    vertices.array_windows().map(segment_length).sum()
}

/// Number of positions and total length of the lines in all layers of a catalog. They are limited because a small catalog may name the same file thousands of
/// times.
#[derive(Debug, Default)]
pub(in crate::catalog) struct TotalSize {
    position_count: usize,
    length_deg: f64,
}

impl TotalSize {
    /// Adds a layer.
    ///
    /// # Errors
    /// With this layer, the layers exceed [`MAX_POSITIONS_OF_ALL_LAYERS`] or [`MAX_LENGTH_DEG`].
    pub fn add(&mut self, layer: &DataLayer) -> Result<(), String> {
        self.position_count += layer.points.len() + layer.lines.iter().map(|line| line.vertices.len()).sum::<usize>();
        self.length_deg += layer.lines.iter().map(|line| length_deg(&line.vertices)).sum::<f64>();
        if self.position_count > MAX_POSITIONS_OF_ALL_LAYERS {
            return Err(format!("with this file all layers have more than {MAX_POSITIONS_OF_ALL_LAYERS} positions"));
        }
        if self.length_deg > MAX_LENGTH_DEG {
            return Err(format!(
                "with this file the lines of all layers are longer than {} times around the globe",
                MAX_LENGTH_DEG / 360.0
            ));
        }
        Ok(())
    }
}

/// Checks a position given in the order of GeoJSON and KML, longitude first; returns latitude and longitude, the order of this module.
pub(super) fn checked_position(lon_deg: f64, lat_deg: f64) -> Result<[f64; 2], String> {
    if !(-360.0..=360.0).contains(&lon_deg) {
        return Err(format!("longitude {lon_deg} is not degrees from -360 to 360"));
    }
    if !(-90.0..=90.0).contains(&lat_deg) {
        return Err(format!("latitude {lat_deg} is not degrees from -90 to 90 (longitude comes first)"));
    }
    Ok([lat_deg, lon_deg])
}

/// Parses `#rrggbb`; `None` for any other text.
pub(super) fn hex_colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.trim().strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let channel = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).ok();
    Some([channel(0)?, channel(1)?, channel(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::data_layer::geojson;

    /// A GeoJSON line that runs back and forth between the poles, 180 degrees per segment.
    fn line(segments: usize) -> String {
        let vertices: Vec<String> = (0..=segments).map(|k| format!("[0,{}]", if k % 2 == 0 { -90 } else { 90 })).collect();
        format!("{{\"type\":\"LineString\",\"coordinates\":[{}]}}", vertices.join(","))
    }

    #[test]
    fn a_colour_is_six_hexadecimal_digits() {
        assert_eq!(hex_colour(" #fF8040"), Some([255, 128, 64]));
        // `from_str_radix` alone would read +f as 15.
        assert!(["#+f+f+f", "#ff804", "ff8040", "#ff80\u{e9}", "#ff804g"].iter().all(|text| hex_colour(text).is_none()));
    }

    /// Lengths are those of the drawn lines: a whole parallel counts in full, a step across the antimeridian not at all.
    #[test]
    fn a_whole_parallel_is_a_turn_long() {
        assert_eq!(length_deg(&[[66.5, -180.0], [66.5, 180.0]]), 360.0);
        assert_eq!(length_deg(&[[10.0, 179.0], [10.0, 180.0], [10.0, -180.0], [10.0, -179.0]]), 2.0);
        assert_eq!(length_deg(&[[0.0, -350.0], [10.0, 350.0]]), 30.0);
    }

    /// The limits apply to the sum over the features of a file, and to the sum over layers.
    #[test]
    fn lengths_of_features_and_of_layers_add_up() {
        let max_segments = (MAX_LENGTH_DEG / 180.0) as usize;
        let collection = |segments: [usize; 2]| {
            let features = segments.map(|n| format!("{{\"type\":\"Feature\",\"geometry\":{}}}", line(n)));
            geojson::read(&format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", features.join(",")))
        };
        assert!(geojson::read(&line(max_segments)).is_ok() && geojson::read(&line(max_segments + 1)).is_err());
        let content = collection([max_segments / 2; 2]).expect("within the limit");
        // Each of the two lines has one vertex more than segments.
        assert_eq!((content.lines.len(), content.position_count), (2, max_segments + 2));
        let (_, why) = collection([max_segments / 2, max_segments / 2 + 1]).expect_err("together too long");
        assert!(why.contains("4000 times around the globe"), "{why}");
        let layer = DataLayer { lines: Arc::new(content.lines), ..DataLayer::new("a".into(), "a.json".into()) };
        let mut total = TotalSize::default();
        assert_eq!(total.add(&layer), Ok(()));
        assert!(total.add(&layer).is_err_and(|why| why.contains("all layers")));
    }
}
