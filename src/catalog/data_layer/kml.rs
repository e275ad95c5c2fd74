//! Points and outlines of a KML file (OGC 2.3): each Point, LineString and LinearRing of its Placemarks, with the Placemark's TimeStamp or the start
//! of its TimeSpan.
//!
//! In: the document; in its positions, longitude comes first, east-positive. Out: points and lines, with the latitude first, or what is wrong in which line of
//! text. Heights are ignored. Not read: styles, tracks, ground overlays, links to other files, and KMZ archives.

use super::layer::{Content, checked_position};
use super::xml::{Element, ElementHandler, walk};
use crate::time::Instant;
use crate::wording::echo_within;

/// What has been read of a document so far.
#[derive(Default)]
struct Document {
    is_kml: bool,
    /// Time of the current Placemark; `None` if it has none or none has been read yet. It may follow the coordinates, so points and lines are added to
    /// `content` at the Placemark's end.
    time: Option<Instant>,
    /// Points and lines of the current Placemark; positions are [latitude, longitude], degrees.
    points: Vec<[f64; 2]>,
    lines: Vec<Vec<[f64; 2]>>,
    /// The Placemarks that have ended.
    content: Content,
}

/// Positions of a `coordinates` element as [latitude, longitude], degrees. In the text, whitespace separates the positions, and commas their numbers.
fn positions(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let position = |tuple: &str| {
        let mut numbers = tuple
            .split(',')
            .map(|n| n.parse::<f64>().map_err(|_| format!("field coordinates: `{}` is not longitude,latitude", echo_within(tuple, 40))));
        let (lon, lat) = (numbers.next(), numbers.next());
        match (lon, lat) {
            // Longitude comes first in the text, latitude in the result.
            (Some(lon), Some(lat)) => checked_position(lon?, lat?).map_err(|why| format!("field coordinates: {why}")),
            _ => Err(format!("field coordinates: `{}` is not longitude,latitude", echo_within(tuple, 40))),
        }
    };
    text.split_whitespace().map(position).collect()
}

impl ElementHandler for Document {
    fn start_element(&mut self, path: &[Element]) -> Result<(), String> {
        if let [root] = path {
            self.is_kml = root.name == "kml";
        }
        Ok(())
    }

    fn end_element(&mut self, path: &[Element]) -> Result<(), String> {
        let Some(element) = path.last() else { return Ok(()) };
        // The name of the element that is `levels` levels above `element`; empty if there is none.
        let ancestor = |levels: usize| path.iter().rev().nth(levels).map_or("", |e| e.name.as_str());
        // A Point in another element, such as a PhotoOverlay, is not a place to draw.
        let is_in_placemark = || path.iter().any(|e| e.name == "Placemark");
        match (element.name.as_str(), ancestor(1)) {
            // The times of documents, folders and views are not those of a Placemark.
            ("when", "TimeStamp") | ("begin", "TimeSpan") if ancestor(2) == "Placemark" => {
                let text = element.text.trim();
                // A year or a month alone means its first day.
                let full_date = match text.len() {
                    4 => format!("{text}-01-01"),
                    7 => format!("{text}-01"),
                    _ => text.to_owned(),
                };
                let invalid_date = || format!("field {}: `{}` is not an ISO 8601 date in UTC", element.name, echo_within(text, 40));
                self.time = Some(Instant::parse(&full_date).map_err(|_| invalid_date())?);
            }
            ("coordinates", "Point") if is_in_placemark() => self.points.extend(positions(&element.text)?),
            ("coordinates", "LineString" | "LinearRing") if is_in_placemark() => self.lines.push(positions(&element.text)?),
            ("Placemark", _) => {
                let time = self.time.take();
                for point in std::mem::take(&mut self.points) {
                    self.content.add_point(point, time)?;
                }
                for line in std::mem::take(&mut self.lines) {
                    self.content.add_line(line, time)?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// The points and lines of a document. The error is the number of a line of the text, from 1, and what is wrong there.
pub(super) fn read(text: &str) -> Result<Content, (usize, String)> {
    let mut document = Document::default();
    walk(text, &mut document)?;
    if !document.is_kml {
        Err((1, "its first element is not kml".to_owned()))
    } else if document.content == Content::default() {
        Err((1, "no Placemark with a Point, LineString or LinearRing in it".to_owned()))
    } else {
        Ok(document.content)
    }
}
