//! User data on a body or in the sky: the table `[[layer]]` of a catalog file, and the file that it names.
//!
//! In: the TOML table, then the bytes of the file. Out: a [`DataLayer`] with its points, lines or image, or a message that names the first wrong line of the
//! text and its field. Always: one wrong line rejects the entire file. The ending of the file's name determines the format:
//! - CSV and VOTable: points. On a body by `lat_deg` (planetographic) and `lon_deg` (east), in the sky by `ra_deg` and `dec_deg` (ICRF); `time`, `size_px` and
//!   `colour` are optional. A point with a `time` appears then, and fades over the layer's `fade_days`. Other names of these columns: columns.rs.
//! - GeoJSON and KML: points and outlines on a body.
//! - FITS: an image on a body or in the sky.

mod columns;
mod csv;
mod fits;
mod geojson;
mod image_style;
mod kml;
mod layer;
mod votable;
mod xml;

use super::fields::{ALLOWED_NAME, is_file_name, is_name, optional_word};
use super::table::{TableReader, WithLine};
use super::{Overlay, OverlayProjection, Problem};
use crate::wording::{echo_within, without_byte_order_mark};
pub use fits::{ImageWcs, PlacedImage};
pub use image_style::{ColourMap, ImageStyle, Stretch};
pub(super) use layer::TotalSize;
use layer::{Content, hex_colour};
pub use layer::{DataLayer, DataLine, DataPoint};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Csv,
    VoTable,
    GeoJson,
    Kml,
    Fits,
}

/// Endings of file names, and their formats.
const FORMATS: [(&str, Format); 10] = [
    (".csv", Format::Csv),
    (".txt", Format::Csv),
    (".vot", Format::VoTable),
    (".votable", Format::VoTable),
    (".xml", Format::VoTable),
    (".geojson", Format::GeoJson),
    (".json", Format::GeoJson),
    (".kml", Format::Kml),
    (".fits", Format::Fits),
    (".fit", Format::Fits),
];

/// The format of a file, by the ending of its name.
fn format(file: &str) -> Option<Format> {
    let file = file.to_lowercase();
    FORMATS.iter().find(|(ending, _)| file.ends_with(ending)).map(|(_, format)| *format)
}

/// Whether a file of this name can be a layer, by its ending.
pub fn is_layer_file(file: &str) -> bool {
    format(file).is_some()
}

/// The endings of all formats, for messages.
pub fn layer_extensions() -> String {
    FORMATS.map(|(ending, _)| ending).join(", ")
}

/// Reads a `[[layer]]`: the name of its body, which the caller looks up (`None`: the sky), and the layer without its body and content. `None` if its name or
/// file is missing or wrong. Every mistake is also added to the problems of the catalog file.
pub(super) fn layer(mut table: TableReader) -> Option<(Option<WithLine<String>>, DataLayer)> {
    let name = table.required("name", ALLOWED_NAME, is_name);
    let allowed = format!("a file name without folders that ends in one of {}", layer_extensions());
    let file = table.required::<String>("file", &allowed, |f| is_layer_file(f) && is_file_name(f));
    let body = table.optional("body", "the name of a body", |_: &String| true);
    let size_px = table.optional("size_px", "pixels above 0, at most 100", |x: &f64| *x > 0.0 && *x <= 100.0);
    let colour = table.optional("colour", "a colour as \"#ff8040\"", |c: &String| hex_colour(c).is_some());
    let fade_days = table.optional("fade_days", "days above 0", |x: &f64| *x > 0.0 && x.is_finite());
    let stretch = optional_word(
        &mut table,
        "stretch",
        &[("linear", Stretch::Linear), ("sqrt", Stretch::Sqrt), ("asinh", Stretch::Asinh), ("log", Stretch::Log)],
    );
    let percentiles = table.optional("percentiles", "two percentages from 0 to 100, the first below the second", |p: &[f64; 2]| {
        0.0 <= p[0] && p[0] < p[1] && p[1] <= 100.0
    });
    let colour_map =
        optional_word(&mut table, "colour_map", &[("grey", ColourMap::Grey), ("viridis", ColourMap::Viridis), ("heat", ColourMap::Heat)]);
    let opacity = table.optional("opacity", "a number from 0 to 1", |x: &f64| (0.0..=1.0).contains(x));
    // `source` is for people who read the catalog file; only its type is checked.
    let _ = table.optional::<String>("source", "a string", |_| true);
    table.finish();
    let mut layer = DataLayer::new(name?.value, file?.value);
    let default_style = layer.style;
    layer.size_px = size_px.map_or(layer.size_px, |l| l.value);
    layer.colour = colour.and_then(|c| hex_colour(&c.value)).unwrap_or(layer.colour);
    layer.fade_days = fade_days.map(|l| l.value);
    layer.style = ImageStyle {
        stretch: stretch.unwrap_or(default_style.stretch),
        percentiles: percentiles.map_or(default_style.percentiles, |p| p.value),
        colour_map: colour_map.unwrap_or(default_style.colour_map),
        opacity: opacity.map_or(default_style.opacity, |o| o.value),
    };
    Some((body, layer))
}

impl DataLayer {
    /// A layer in the sky with default settings, without its content.
    pub fn new(name: String, file: String) -> Self {
        Self {
            name,
            file,
            body: None,
            size_px: 5.0,
            colour: [255, 140, 60],
            fade_days: None,
            style: ImageStyle::default(),
            points: Arc::default(),
            lines: Arc::default(),
            image: None,
            digest: String::new(),
        }
    }

    /// The layer with the content of its file. `file`: the file's name in messages; [`DataLayer::file`] determines the format.
    ///
    /// # Errors
    /// The first wrong line. For a FITS file the line is the number of the wrong header card.
    pub fn with_content(mut self, file: &str, bytes: &[u8]) -> Result<Self, Problem> {
        // From the line or header card, and the message.
        let problem = |(line, message): (usize, String)| Problem { file: file.to_owned(), line, message };
        self.digest = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
        let format = format(&self.file);
        if format == Some(Format::Fits) {
            let image = fits::read(bytes, self.body.is_some(), &self.style);
            self.image = Some(Arc::new(image.map_err(|(card, why)| problem((card, format!("header card {card}: {why}"))))?));
            return Ok(self);
        }
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
            problem((line, "not UTF-8 text".to_owned()))
        })?;
        let text = without_byte_order_mark(text);
        let on_body = self.body.is_some();
        let on_body_only = |read: fn(&str) -> Result<Content, (usize, String)>| match on_body {
            true => read(text),
            false => Err((1, "its coordinates are on a body: the layer needs `body`".to_owned())),
        };
        let content = match format {
            Some(Format::Csv) => csv::read(text, on_body),
            Some(Format::VoTable) => votable::read(text, on_body),
            Some(Format::GeoJson) => on_body_only(geojson::read),
            Some(Format::Kml) => on_body_only(kml::read),
            Some(Format::Fits) | None => Err((1, format!("`{}` ends in none of {}", echo_within(&self.file, 60), layer_extensions()))),
        };
        let content = content.map_err(problem)?;
        (self.points, self.lines) = (Arc::new(content.points), Arc::new(content.lines));
        Ok(self)
    }

    /// The name under which the session stores the image as a texture. It contains the digest of the file, so it differs from the name of every map file and
    /// changes with the layer's content.
    pub fn image_name(&self) -> String {
        format!("layer {} {}", self.name, self.digest)
    }

    /// The image of a layer on a body, as an overlay on the ground; `None` for a layer without an image or in the sky. FITS calls the equirectangular
    /// projection plate carrée.
    pub(super) fn overlay(&self) -> Option<Overlay> {
        let image = self.image.as_ref().filter(|_| self.body.is_some())?;
        let ImageWcs::PlateCarree { west_deg, east_deg, south_deg, north_deg, .. } = image.wcs else { return None };
        Some(Overlay {
            name: self.name.clone(),
            file: self.image_name(),
            gain: [1.0; 3],
            opacity: self.style.opacity,
            projection: OverlayProjection::Equirectangular { west_deg, east_deg, south_deg, north_deg },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;

    /// [`DataLayer::body`] of a layer in the sky.
    const IN_SKY: Option<NaifId> = None;

    fn layer_on(body: Option<NaifId>) -> DataLayer {
        DataLayer { body, ..DataLayer::new("quakes".into(), "quakes.csv".into()) }
    }

    #[test]
    fn a_table_is_read_by_its_columns() {
        let text = "time,Latitude,longitude,place,size,colour\n\
            2011-03-11T05:46:24Z,38.297,142.373,\"Tohoku, \"\"Japan\"\"\",9.1,#ff0000\n\n,-90,-180,,,\n";
        let layer = layer_on(Some(NaifId::EARTH)).with_content("quakes.csv", text.as_bytes()).expect("read");
        assert_eq!(layer.points.len(), 2);
        let first = layer.points[0];
        assert_eq!((first.lat_deg, first.lon_deg, first.size_px, first.colour), (38.297, 142.373, Some(9.1), Some([255, 0, 0])));
        assert_eq!(first.time.map(|t| t.to_utc_iso()[..19].to_owned()), Some("2011-03-11T05:46:24".into()));
        assert_eq!((layer.points[1].time, layer.points[1].size_px), (None, None));
        // In the sky `lon_deg` is the right ascension.
        assert_eq!(layer_on(IN_SKY).with_content("sky.csv", b"ra,dec\n10,20\n").expect("read").points[0].lon_deg, 10.0);
        // A byte order mark, before a comment or before the names of the columns.
        for text in ["\u{feff}# stars\r\nra,dec\r\n10,20\r\n", "\u{feff}ra,dec\n10,20\n"] {
            assert_eq!(layer_on(IN_SKY).with_content("sky.csv", text.as_bytes()).expect("read").points.len(), 1);
        }
    }

    #[test]
    fn each_mistake_names_file_line_and_field() {
        let why = |text: &str| layer_on(Some(NaifId::EARTH)).with_content("q.csv", text.as_bytes()).expect_err("a mistake").to_string();
        assert!(why("").starts_with("q.csv:1: empty"));
        assert!(why("ra,dec\n1,2\n").starts_with("q.csv:1: the line of column names has no columns lat_deg"));
        assert!(why("lat,dec\n1,2\n").starts_with("q.csv:1: the line of column names has no column lon_deg"));
        assert!(why("lat,lon\n1,2\n95,2\n").starts_with("q.csv:3: field lat_deg: `95` is not degrees"));
        assert!(why("lat,lon\n1,x\n").starts_with("q.csv:2: field lon_deg: `x`"));
        assert!(why("lat,lon\n1\n").starts_with("q.csv:2: 1 values; the table names 2 columns"));
        assert!(why("lat,lon,time\n1,2,2024-13-45\n").starts_with("q.csv:2: field time: `2024-13-45`"));
        assert!(why("lat,lon,colour\n1,2,red\n").starts_with("q.csv:2: field colour: `red`"));
        assert!(why("lat,lon,size_px\n1,2,-4\n").starts_with("q.csv:2: field size_px: `-4`"));
    }

    fn read(file: &str, body: Option<NaifId>, text: &str) -> Result<DataLayer, String> {
        let layer = DataLayer { body, ..DataLayer::new("own".into(), file.into()) };
        layer.with_content(file, text.as_bytes()).map_err(|e| e.to_string())
    }

    const VOTABLE: &str = "<?xml version=\"1.0\"?>\n<VOTABLE version=\"1.4\" xmlns=\"http://www.ivoa.net/xml/VOTable/v1.3\">\n<RESOURCE>\n\
        <TABLE>\n<FIELD name=\"id\" datatype=\"char\" arraysize=\"*\"/>\n<FIELD name=\"alpha\" ucd=\"pos.eq.ra;meta.main\" unit=\"deg\" datatype=\"double\"/>\n\
        <FIELD name=\"delta\" ucd=\"pos.eq.dec;meta.main\" datatype=\"double\"/>\n<FIELD name=\"time\" datatype=\"char\" arraysize=\"*\"/>\n\
        <DATA><TABLEDATA>\n<TR><TD>A &amp; &#66;</TD><TD> 10.5 </TD><TD>-20</TD><TD>2024-04-08T18:00:00Z</TD></TR>\n\
        <TR><TD/><TD>11</TD><TD>-21</TD><TD></TD></TR>\n</TABLEDATA></DATA>\n</TABLE>\n</RESOURCE>\n</VOTABLE>\n";

    /// A mark changes neither the content nor the line of a mistake.
    #[test]
    fn a_byte_order_mark_is_no_part_of_the_text() {
        let geojson = "{\"type\": \"Point\",\n\"coordinates\": [10, 20]}";
        for (file, body, text) in [
            ("a.csv", IN_SKY, "ra,dec\n10,20\n"),
            ("a.vot", IN_SKY, VOTABLE),
            ("a.geojson", Some(NaifId::EARTH), geojson),
            ("a.kml", Some(NaifId::EARTH), KML),
        ] {
            let content = |text: &str| read(file, body, text).map(|layer| (layer.points, layer.lines));
            let plain = content(text).unwrap_or_else(|e| panic!("{e}"));
            assert!(!plain.0.is_empty());
            assert_eq!(content(&format!("\u{feff}{text}")), Ok(plain), "{file}");
            let wrong = text.replace("20", "x");
            let expected = content(&wrong).expect_err(file);
            assert_eq!(content(&format!("\u{feff}{wrong}")), Err(expected), "{file}");
        }
    }

    #[test]
    fn votables_are_read_by_name_and_ucd() {
        let layer = read("a.vot", IN_SKY, VOTABLE).expect("read");
        assert_eq!(layer.points.iter().map(|p| (p.lon_deg, p.lat_deg)).collect::<Vec<_>>(), [(10.5, -20.0), (11.0, -21.0)]);
        assert!(layer.points[0].time.is_some() && layer.points[1].time.is_none());
        // Column names have precedence over UCDs: with these names the columns `id` and `time` are read as coordinates.
        let named = VOTABLE.replace("name=\"id\"", "name=\"RA\"").replace("name=\"time\"", "name=\"Dec\"");
        let error = read("a.vot", IN_SKY, &named).expect_err("text in place of a number");
        assert!(error.contains("field dec_deg: `2024-04-08T18:00:00Z`"), "{error}");
        let why = |from: &str, to: &str| read("a.vot", IN_SKY, &VOTABLE.replace(from, to)).expect_err("a mistake");
        assert!(
            why("<TD>-20</TD>", "<TD>-200</TD>").starts_with("a.vot:10: field dec_deg: `-200` is not degrees"),
            "{}",
            why("<TD>-20</TD>", "<TD>-200</TD>")
        );
        assert!(why("2024-04-08", "2024-13-08").starts_with("a.vot:10: field time: `2024-13-08T18"));
        assert!(why("<TD>-21</TD>", "").starts_with("a.vot:11: 3 values; the table names 4 columns"));
        assert!(why("pos.eq.ra;", "phys.mass;").starts_with("a.vot:9: the TABLE has no column ra_deg, nor by UCD"));
        assert!(why("unit=\"deg\"", "unit=\"h\"").starts_with("a.vot:9: field alpha (line 6): the unit `h` is not deg"));
        assert!(why("TABLEDATA", "FITS").starts_with("a.vot:9: rows as FITS; ask"));
        assert!(why("</TR>\n</TABLEDATA>", "</TABLEDATA>").starts_with("a.vot:11: not XML"));
        assert!(why("&amp;", "&bomb;").starts_with("a.vot:10: the entity &bomb; is not predefined"));
        assert!(read("a.vot", IN_SKY, "").expect_err("empty").starts_with("a.vot:1: not XML"));
        let cut = VOTABLE.find("</RESOURCE>").expect("there");
        assert!(read("a.vot", IN_SKY, &VOTABLE[..cut]).expect_err("cut").contains("the file ends within <RESOURCE>"));
        assert!(read("a.vot", IN_SKY, "<VOTABLE><RESOURCE/></VOTABLE>").expect_err("none").starts_with("a.vot:1: no TABLE in it"));
        assert!(read("a.vot", IN_SKY, &"<a>".repeat(100)).expect_err("deep").contains("more than 64 elements"));
    }

    /// Positions of B1950 are 0.6 degrees from those of J2000. A field without a reference may have any system of the document.
    #[test]
    fn positions_of_votables_are_icrs_or_refused() {
        let with = |systems: &str, reference: &str| {
            let text = VOTABLE
                .replace("<RESOURCE>", &format!("<RESOURCE>{systems}"))
                .replace("unit=\"deg\"", &format!("unit=\"deg\" {reference}"));
            read("a.vot", IN_SKY, &text).map(|layer| layer.points[0].lon_deg)
        };
        let [icrs, fk5, fk4, galactic] = [
            r#"<COOSYS ID="i" system="ICRS" epoch="J2016.0"/>"#,
            r#"<COOSYS ID="f5" system="eq_FK5" equinox="J2000.0"/>"#,
            r#"<COOSYS ID="f4" system="eq_FK4" equinox="B1950"/>"#,
            r#"<COOSYS ID="g" system="galactic"/>"#,
        ];
        let [fk4_and_fk5, fk4_and_icrs] = [fk5, icrs].map(|other| format!("{fk4}{other}"));
        let supported: [(&str, &str); 5] = [(icrs, ""), (fk5, "ref=\"f5\""), (fk5, ""), (&fk4_and_fk5, "ref=\"f5\""), (&fk4_and_icrs, "")];
        for (systems, reference) in supported {
            assert_eq!(with(systems, reference), Ok(10.5), "{systems} {reference}");
        }
        let fk5_of_1975 = fk5.replace("2000.0", "1975");
        let refused: [(&str, &str); 4] = [(fk4, ""), (galactic, ""), (&fk5_of_1975, ""), (&fk4_and_fk5, "ref=\"f4\"")];
        for (systems, reference) in refused {
            let why = with(systems, reference).expect_err(systems);
            assert!(why.starts_with("a.vot:9: field ") && why.contains("): the coordinate system (COOSYS) is "), "{why}");
        }
        assert!(with(fk4, "").expect_err("B1950").contains("is eq_FK4 B1950; only ICRS and FK5 J2000"));
    }

    #[test]
    fn nulls_of_votables_are_no_values() {
        // The first column becomes the size. `field`: the rest of its FIELD; `null`: a text that means that there is no value.
        for (field, null) in
            [("datatype=\"int\"><VALUES null=\"-99\"/></FIELD>", "-99"), ("datatype=\"double\"/>", "NaN"), ("datatype=\"double\"/>", " ")]
        {
            let with_size = VOTABLE.replace("name=\"id\" datatype=\"char\" arraysize=\"*\"/>", &format!("name=\"size\" {field}"));
            let layer = read("a.vot", IN_SKY, &with_size.replace("A &amp; &#66;", null)).expect("read");
            assert_eq!(layer.points.iter().map(|p| p.size_px).collect::<Vec<_>>(), [None, None], "{null}");
            assert_eq!(read("a.vot", IN_SKY, &with_size.replace("A &amp; &#66;", "7")).expect("read").points[0].size_px, Some(7.0));
        }
    }

    /// The rows of [`VOTABLE`] give the same points in both binary formats.
    #[test]
    fn binary_votables_give_the_same_points() {
        use base64::Engine;
        use base64::prelude::BASE64_STANDARD;
        // A text of variable length: its number of bytes, big-endian, and its bytes.
        let text = |t: &str| [&i32::try_from(t.len()).expect("short").to_be_bytes()[..], t.as_bytes()].concat();
        let row = |flags: &[u8], [id, time]: [&str; 2], [ra, dec]: [f64; 2]| {
            [flags.to_vec(), text(id), ra.to_be_bytes().to_vec(), dec.to_be_bytes().to_vec(), text(time)].concat()
        };
        let from = VOTABLE.find("<TABLEDATA>").expect("there");
        let to = VOTABLE.find("</DATA>").expect("there");
        // `form`: BINARY or BINARY2.
        let as_form = |form: &str, bytes: &[u8]| {
            let stream = format!("<{form}><STREAM encoding=\"base64\">\n{}\n</STREAM></{form}>", BASE64_STANDARD.encode(bytes));
            format!("{}{stream}{}", &VOTABLE[..from], &VOTABLE[to..])
        };
        let rows = |flags: [&[u8]; 2]| {
            [row(flags[0], ["A & B", "2024-04-08T18:00:00Z"], [10.5, -20.0]), row(flags[1], ["", "never"], [11.0, -21.0])].concat()
        };
        let text_layer = read("a.vot", IN_SKY, VOTABLE).expect("read");
        // Each row of BINARY2 begins with null flags, the highest bit for the first column. In the second row the flag of the fourth column, `time`, is set.
        let flagged = read("a.vot", IN_SKY, &as_form("BINARY2", &rows([&[0], &[0b0001_0000]]))).expect("read");
        assert_eq!(flagged.points, text_layer.points);
        // BINARY has no null flags, so the text `never` is read as a time.
        let unflagged = rows([&[], &[]]);
        let refused = read("a.vot", IN_SKY, &as_form("BINARY", &unflagged)).expect_err("a time");
        assert!(refused.starts_with("a.vot:") && refused.contains("row 2: field time: `never`"), "{refused}");
        // Without the last cell: a length of four bytes, and the five bytes of `never`. An empty cell, of length 0, takes its place.
        let end = unflagged.len() - 9;
        let cleared = [&unflagged[..end], &[0; 4]].concat();
        assert_eq!(read("a.vot", IN_SKY, &as_form("BINARY", &cleared)).expect("read").points, text_layer.points);
        let why = |from: &str, to: &str| {
            read("a.vot", IN_SKY, &as_form("BINARY2", &rows([&[0], &[0b0001_0000]])).replace(from, to)).expect_err("a mistake")
        };
        assert!(why("encoding=\"base64\"", "encoding=\"gzip\"").contains("the encoding of STREAM is `gzip`"));
        assert!(why("encoding", "href=\"a.bin\" encoding").contains("rows in another file"));
        assert!(
            why("datatype=\"double\"/>\n<FIELD name=\"time\"", "datatype=\"quad\"/>\n<FIELD name=\"time\"")
                .contains("field delta (line 7): the datatype `quad`")
        );
    }

    const GEOJSON: &str = r#"{"type": "FeatureCollection", "name": "own", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}},
"features": [
{"type": "Feature", "properties": {"time": "2024-04-08T18:00:00Z", "n": 3}, "geometry": {"type": "Point", "coordinates": [10, 20, 300]}},
{"type": "Feature", "properties": {"time": 1712599200000}, "geometry": {"coordinates": [[[0, 0], [10, 0], [10, 10], [0, 0]], [[1, 1], [2, 1], [2, 2], [1, 1]]], "type": "Polygon"}},
{"type": "Feature", "properties": null, "geometry": {"type": "GeometryCollection", "geometries": [{"type": "LineString", "coordinates": [[170, 1], [190, 1]]}]}},
{"type": "Feature", "geometry": null}
]}"#;

    #[test]
    fn all_geojson_geometries_are_read() {
        let layer = read("a.geojson", Some(NaifId::EARTH), GEOJSON).expect("read");
        let point = layer.points[0];
        assert_eq!((layer.points.len(), point.lat_deg, point.lon_deg), (1, 20.0, 10.0));
        // The outline and the hole of the polygon, and the line.
        assert_eq!(layer.lines.iter().map(|l| l.vertices.len()).collect::<Vec<_>>(), [4, 4, 2]);
        // The same instant as text and as milliseconds.
        let [text, ms] = [point.time, layer.lines[0].time].map(|t| t.expect("a time").tdb_seconds_past_j2000());
        assert!((text - ms).abs() < 1e-3, "{text} {ms}");
        for kind in ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon"] {
            let empty = format!("{{\"type\": \"Feature\", \"geometry\": {{\"type\": \"{kind}\", \"coordinates\": []}}}}");
            let with_empty = GEOJSON.replace("{\"type\": \"Feature\", \"geometry\": null}", &empty);
            assert_eq!(read("a.geojson", Some(NaifId::EARTH), &with_empty).map(|l| (l.points.len(), l.lines.len())), Ok((1, 3)), "{kind}");
        }
        let alone = r#"{"type": "MultiPolygon", "coordinates": [[[[1, 2], [3, 4], [1, 2]]], [[[5, 6], [7, 8], [5, 6]]]]}"#;
        assert_eq!(read("a.json", Some(NaifId::MOON), alone).expect("read").lines.len(), 2);
        let why = |from: &str, to: &str| read("a.geojson", Some(NaifId::EARTH), &GEOJSON.replace(from, to)).expect_err("a mistake");
        for (from, to, expected) in [
            ("[2, 2]", "[2, 92]", "a.geojson:4: field coordinates: latitude 92 is not degrees"),
            ("[170, 1]", "[1700, 1]", "a.geojson:5: field coordinates: longitude 1700 is not"),
            ("2024-04-08", "2024-14-08", "a.geojson:3: field time: `2024-14-08T18:00:00Z` is not"),
            ("1712599200000", "true", "a.geojson:4: field time: `true` is not"),
            ("[10, 20, 300]", "[10]", "a.geojson:3: field coordinates: a position is [longitude, latitude]"),
            ("[10, 20, 300]", "[[10, 20]]", "a.geojson:3: field coordinates: not those of a Point"),
            ("\"Polygon\"", "\"Circle\"", "a.geojson:4: field coordinates: not those of a Circle"),
            ("[[170, 1], [190, 1]]", "[[170, 1]]", "a.geojson:5: a line with 1 position;"),
            ("CRS84", "EPSG::3857", "a.geojson:1: field crs: `urn:ogc:def:crs:OGC:1.3:EPSG::3857` is not longitude"),
            // The end of the file is missing.
            ("null}\n]}", "null}\n", "a.geojson:"),
        ] {
            let error_text = why(from, to);
            assert!(error_text.starts_with(expected), "{error_text}");
        }
        assert!(read("a.geojson", Some(NaifId::EARTH), "[1]").expect_err("no object").starts_with("a.geojson:1: "));
        assert!(
            read("a.geojson", Some(NaifId::EARTH), r#"{"type":"FeatureCollection","features":[]}"#)
                .expect_err("none")
                .contains("no geometry")
        );
        assert!(read("a.geojson", IN_SKY, GEOJSON).expect_err("in the sky").contains("needs `body`"));
        assert!(read("a.geojson", Some(NaifId::EARTH), &"[".repeat(1_000_000)).is_err());
        assert!(
            read("a.geojson", Some(NaifId::EARTH), &format!("{{\"type\":\"Point\",\"coordinates\":{}", "[".repeat(1_000_000))).is_err()
        );
    }

    const KML: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Folder>\n\
        <Placemark><name>a</name><Point><coordinates>10,20,0</coordinates></Point>\n<TimeStamp><when>2024-04</when></TimeStamp></Placemark>\n\
        <Placemark><MultiGeometry><LineString><coordinates>\n0,0 1,1\n2,2</coordinates></LineString><Polygon><outerBoundaryIs><LinearRing>\n\
        <coordinates>0,0 5,0 5,5 0,0</coordinates></LinearRing></outerBoundaryIs></Polygon></MultiGeometry></Placemark>\n\
        </Folder></Document></kml>\n";

    #[test]
    fn kml_is_read_by_placemarks() {
        let layer = read("a.kml", Some(NaifId::EARTH), KML).expect("read");
        assert_eq!((layer.points.len(), layer.points[0].lat_deg, layer.points[0].lon_deg), (1, 20.0, 10.0));
        assert_eq!(layer.points[0].time.map(|t| t.to_utc_iso()[..10].to_owned()).as_deref(), Some("2024-04-01"));
        assert_eq!(layer.lines.iter().map(|l| (l.vertices.len(), l.time)).collect::<Vec<_>>(), [(3, None), (4, None)]);
        let why = |from: &str, to: &str| read("a.kml", Some(NaifId::EARTH), &KML.replace(from, to)).expect_err("a mistake");
        for (from, to, expected) in [
            ("10,20,0", "10", "a.kml:3: field coordinates: `10` is not longitude,latitude"),
            ("10,20,0", "x,20", "a.kml:3: field coordinates: `x,20` is not longitude"),
            ("5,5", "5,95", "a.kml:8: field coordinates: latitude 95 is not"),
            ("2024-04<", "2024-44<", "a.kml:4: field when: `2024-44` is not an ISO 8601 date"),
            ("0,0 1,1\n2,2", "0,0", "a.kml:5: a line with 1 position;"),
            ("<kml ", "<gpx ", "a.kml:"),
        ] {
            let error_text = why(from, to);
            assert!(error_text.starts_with(expected), "{error_text}");
            // A byte order mark changes no line number.
            let with_mark = read("a.kml", Some(NaifId::EARTH), &format!("\u{feff}{}", KML.replace(from, to))).expect_err("a mistake");
            assert_eq!(with_mark, error_text);
        }
        assert!(read("a.kml", Some(NaifId::EARTH), "<kml><Document/></kml>").expect_err("none").contains("no Placemark"));
        // A photograph has a place, too, but is not a Placemark.
        let photograph = "<PhotoOverlay><Point><coordinates>50,60</coordinates></Point></PhotoOverlay>";
        let layer = read("a.kml", Some(NaifId::EARTH), &KML.replace("<Folder>", &format!("<Folder>{photograph}"))).expect("read");
        assert_eq!((layer.points.len(), layer.points[0].lat_deg), (1, 20.0));
        // The times of a folder, and of a view that Google Earth saved, are not those of the Placemark after them.
        for other in ["<TimeSpan><begin>2050</begin></TimeSpan>", "<LookAt><gx:TimeStamp><when>2050</when></gx:TimeStamp></LookAt>"] {
            let document = KML.replace("<Folder>", &format!("<Folder>{other}")).replace("<TimeStamp><when>2024-04</when></TimeStamp>", "");
            let layer = read("a.kml", Some(NaifId::EARTH), &document).expect("read");
            assert!(layer.points.iter().all(|p| p.time.is_none()) && layer.lines.iter().all(|l| l.time.is_none()), "{other}");
        }
    }
}
