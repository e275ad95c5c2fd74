//! Data of one's own on a body or in the sky: `[[layer]]` of a catalog file, and the table that it names.
//!
//! In: the table's section, then the text of its CSV file. Out: a [`DataLayer`] with its points, or the wrong line and field. The table's first line names its columns:
//! `lat_deg` and `lon_deg` (planetographic, east) for a layer of a body, `ra_deg` and `dec_deg` (ICRF) for one of the sky; `time` (ISO 8601 UTC or jd_tdb:DAY),
//! `size_px` and `colour` (#rrggbb) may be there; other columns are passed over. Values may stand in quotes. Always: nothing of a table with a wrong
//! line is kept.

use super::fields::is_name;
use super::table::{TableReader, WithLine};
use super::{NaifId, Problem};
use crate::time::Instant;
use crate::wording::echo_within;

/// Points of a table at most.
const MAX_POINTS: usize = 1_000_000;

/// A layer of data.
#[derive(Clone, Debug, PartialEq)]
pub struct DataLayer {
    /// As the catalog has it.
    pub name: String,
    /// The CSV file, in the folder of the catalog.
    pub file: String,
    /// Whose ground the points are on; `None`: the sky.
    pub body: Option<NaifId>,
    /// Diameter of a point where the table gives none: pixels of a picture 1024 pixels high.
    pub size_px: f64,
    /// sRGB of a point where the table gives none.
    pub colour: [u8; 3],
    /// Days in which a point fades after its time; `None`: it stays.
    pub fade_days: Option<f64>,
    /// From the table.
    pub points: Vec<DataPoint>,
}

/// A point of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataPoint {
    /// Latitude or declination, degrees.
    pub lat_deg: f64,
    /// East longitude or right ascension, degrees.
    pub lon_deg: f64,
    /// From which on it shows; `None`: always.
    pub time: Option<Instant>,
    /// Where the table gives it.
    pub size_px: Option<f64>,
    /// sRGB, where the table gives it.
    pub colour: Option<[u8; 3]>,
}

/// A layer and the name of its body, to be looked up.
pub(super) fn layer(mut s: TableReader) -> Option<(Option<WithLine<String>>, DataLayer)> {
    let name = s.need("name", "a name", is_name);
    let file = s.need::<String>("file", "a file name without folders", |f| !f.is_empty() && !f.contains(['/', '\\']) && f != "..");
    let body = s.take("body", "the name of a body", |_: &String| true);
    let size_px = s.take("size_px", "pixels above 0, at most 100", |x: &f64| *x > 0.0 && *x <= 100.0);
    let colour = s.take("colour", "a colour as \"#ff8040\"", |c: &String| hex_colour(c).is_some());
    let fade_days = s.take("fade_days", "days above 0", |x: &f64| *x > 0.0 && x.is_finite());
    let _ = s.take::<String>("source", "a string", |_| true);
    s.finish();
    let layer = DataLayer {
        name: name?.value,
        file: file?.value,
        body: None,
        size_px: size_px.map_or(5.0, |l| l.value),
        colour: colour.and_then(|c| hex_colour(&c.value)).unwrap_or([255, 140, 60]),
        fade_days: fade_days.map(|l| l.value),
        points: Vec::new(),
    };
    Some((body, layer))
}

/// `#rrggbb`.
fn hex_colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.trim().strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
    let channel = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).ok();
    Some([channel(0)?, channel(1)?, channel(2)?])
}

/// The values of a line, without their quotes; a quote in quotes is doubled (RFC 4180).
fn values(line: &str) -> Vec<String> {
    let (mut all, mut value, mut quoted) = (Vec::new(), String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                value.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(std::mem::take(&mut value).trim().to_owned()),
            _ => value.push(c),
        }
    }
    all.push(value.trim().to_owned());
    all
}

impl DataLayer {
    /// What the columns may be called (letters and digits alone, lower case): latitude, longitude, time, size, colour.
    fn columns(&self) -> [&'static [&'static str]; 5] {
        let place: [&'static [&'static str]; 2] = match self.body {
            Some(_) => [&["latdeg", "lat", "latitude"], &["londeg", "lon", "longitude", "lng"]],
            None => [&["decdeg", "dec", "dedeg"], &["radeg", "ra"]],
        };
        [place[0], place[1], &["time", "date", "datetime"], &["sizepx", "size"], &["colour", "color"]]
    }

    /// The layer with the points of its table. `file`: what messages call it.
    ///
    /// # Errors
    /// The first wrong line.
    pub fn with_table(mut self, file: &str, text: &str) -> Result<Self, Problem> {
        let wrong = |line: usize, message: String| Problem { file: file.to_owned(), line, message };
        let mut lines = (1..).zip(text.lines()).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
        let (first, head) = lines.next().ok_or_else(|| wrong(1, "empty; the first line names the columns".into()))?;
        let plain = |name: &String| name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
        let head: Vec<String> = values(head.trim_start_matches('\u{feff}')).iter().map(plain).collect();
        let place = self.columns().map(|names| head.iter().position(|h| names.contains(&h.as_str())));
        let [Some(lat), Some(lon), time, size, colour] = place else {
            let wanted = if self.body.is_some() { "lat_deg and lon_deg" } else { "ra_deg and dec_deg" };
            return Err(wrong(first, format!("the first line names no columns {wanted}")));
        };
        for (number, line) in lines {
            if self.points.len() >= MAX_POINTS {
                return Err(wrong(number, format!("more than {MAX_POINTS} points")));
            }
            let values = values(line);
            if values.len() != head.len() {
                return Err(wrong(number, format!("{} values; the first line names {} columns", values.len(), head.len())));
            }
            let bad = |field: &str, at: usize, allowed: &str| {
                wrong(number, format!("field {field}: `{}` is not {allowed}", echo_within(&values[at], 40)))
            };
            let within = |field: &str, at: usize, least: f64, most: f64, allowed: &str| {
                values[at].parse().ok().filter(|v| (least..=most).contains(v)).ok_or_else(|| bad(field, at, allowed))
            };
            let given = |at: Option<usize>| at.filter(|at| !values[*at].is_empty());
            let [lat_name, lon_name] = if self.body.is_some() { ["lat_deg", "lon_deg"] } else { ["dec_deg", "ra_deg"] };
            let time = given(time).map(|at| Instant::parse(&values[at]).map_err(|_| bad("time", at, "ISO 8601 UTC or jd_tdb:DAY")));
            let size = given(size).map(|at| within("size_px", at, 1e-3, 1000.0, "pixels above 0, at most 1000"));
            let colour = given(colour).map(|at| hex_colour(&values[at]).ok_or_else(|| bad("colour", at, "a colour as #ff8040")));
            self.points.push(DataPoint {
                lat_deg: within(lat_name, lat, -90.0, 90.0, "degrees from -90 to 90")?,
                lon_deg: within(lon_name, lon, -360.0, 360.0, "degrees from -360 to 360")?,
                time: time.transpose()?,
                size_px: size.transpose()?,
                colour: colour.transpose()?,
            });
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(body: Option<NaifId>) -> DataLayer {
        let file = "quakes.csv".to_owned();
        DataLayer { name: "quakes".into(), file, body, size_px: 5.0, colour: [1, 2, 3], fade_days: None, points: Vec::new() }
    }

    #[test]
    fn a_table_is_read_by_its_columns() {
        let text = "time,Latitude,longitude,place,size,colour\n\
            2011-03-11T05:46:24Z,38.297,142.373,\"Tohoku, \"\"Japan\"\"\",9.1,#ff0000\n\n,-90,-180,,,\n";
        let layer = on(Some(NaifId::EARTH)).with_table("quakes.csv", text).expect("read");
        assert_eq!(layer.points.len(), 2);
        let first = layer.points[0];
        assert_eq!((first.lat_deg, first.lon_deg, first.size_px, first.colour), (38.297, 142.373, Some(9.1), Some([255, 0, 0])));
        assert_eq!(first.time.map(|t| t.to_utc_iso()[..19].to_owned()), Some("2011-03-11T05:46:24".into()));
        assert_eq!((layer.points[1].time, layer.points[1].size_px), (None, None));
        assert_eq!(on(None).with_table("sky.csv", "ra,dec\n10,20\n").expect("read").points[0].lon_deg, 10.0);
    }

    #[test]
    fn each_mistake_names_file_line_and_field() {
        let why = |text: &str| on(Some(NaifId::EARTH)).with_table("q.csv", text).expect_err("a mistake").to_string();
        assert!(why("").starts_with("q.csv:1: empty"));
        assert!(why("ra,dec\n1,2\n").starts_with("q.csv:1: the first line names no columns lat_deg"));
        assert!(why("lat,lon\n1,2\n95,2\n").starts_with("q.csv:3: field lat_deg: `95` is not degrees"));
        assert!(why("lat,lon\n1,x\n").starts_with("q.csv:2: field lon_deg: `x`"));
        assert!(why("lat,lon\n1\n").starts_with("q.csv:2: 1 values; the first line names 2"));
        assert!(why("lat,lon,time\n1,2,2024-13-45\n").starts_with("q.csv:2: field time: `2024-13-45`"));
        assert!(why("lat,lon,colour\n1,2,red\n").starts_with("q.csv:2: field colour: `red`"));
        assert!(why("lat,lon,size_px\n1,2,-4\n").starts_with("q.csv:2: field size_px: `-4`"));
    }
}
