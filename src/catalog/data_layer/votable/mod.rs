//! Points in a VOTable (IVOA, versions 1.1 to 1.5): the first TABLE of the document, its rows as TABLEDATA, BINARY or BINARY2.
//!
//! In: the document. Out: points, or a line number and what is wrong there. A column is identified by its name as in a CSV table, or, if no name fits, by its
//! UCD (Unified Content Descriptor), such as `pos.eq.ra`, `pos.bodyrc.lon` or their forms before 2005 (UCD1). Rejected: rows in a FITS file, angles in
//! units other than degrees, and positions in the sky whose coordinate system (COOSYS) is neither ICRS nor FK5 J2000.

mod binary;

use self::binary::{BinaryColumn, BinaryRows};
use super::columns::PointColumns;
use super::layer::Content;
use super::xml::{Element, ElementHandler, walk};
use crate::wording::echo_within;

/// A FIELD element: the description of a column.
struct Field {
    name: String,
    /// Unified Content Descriptor: what the column means.
    ucd: String,
    /// The attribute `unit`; `None` if the element has none.
    unit: Option<String>,
    data_type: String,
    /// The attribute `arraysize`: number of values in a cell, as text.
    arraysize: String,
    /// The number that means null, as text; `None` if no number does.
    null: Option<String>,
    /// The attribute `ref`: the ID of a coordinate system; empty if there is none.
    reference: String,
    /// The line of the element.
    line: usize,
}

/// A COOSYS element: a coordinate system.
struct CoordinateSystem {
    id: String,
    system: String,
    equinox: String,
}

impl CoordinateSystem {
    /// Whether its positions are those of ICRS, to the precision of this program. A system without name is FK5 (VOTable 1.1 to 1.3), and without equinox J2000.
    fn is_icrs_or_fk5_j2000(&self) -> bool {
        let is_j2000 = || self.equinox.is_empty() || self.equinox.trim_start_matches('J').parse::<f64>() == Ok(2000.0);
        match self.system.as_str() {
            "ICRS" => true,
            "" | "eq_FK5" | "FK5" => is_j2000(),
            _ => false,
        }
    }
}

impl Field {
    /// Whether the text of a cell of TABLEDATA is the null number of this field, or NaN. An empty cell needs no check: [`PointColumns`] reads it as null.
    fn is_null(&self, cell: &str) -> bool {
        let is_float = matches!(self.data_type.as_str(), "float" | "double");
        self.null.as_deref() == Some(cell) || is_float && cell.eq_ignore_ascii_case("nan")
    }
}

/// What has been read of the first TABLE.
#[derive(Default)]
struct Table {
    /// Whether points are given by latitude and longitude, not by declination and right ascension.
    on_body: bool,
    fields: Vec<Field>,
    /// The coordinate systems before the rows.
    systems: Vec<CoordinateSystem>,
    /// The columns of a point; `None` before the rows begin.
    columns: Option<PointColumns>,
    /// The cells of the current TR.
    row: Vec<String>,
    content: Content,
    /// Whether TABLEDATA, BINARY or BINARY2 has begun.
    has_data: bool,
    /// Whether the TABLE has ended; later elements other than the service's status are ignored.
    has_ended: bool,
}

/// The column name by which [`PointColumns`] knows the quantity of a UCD.
fn column_name_of_ucd(ucd: &str) -> Option<&'static str> {
    let ucd = ucd.to_lowercase();
    let primary_word = ucd.split(';').next().unwrap_or_default().trim();
    match primary_word {
        "pos.eq.ra" | "pos_eq_ra_main" => Some("ra_deg"),
        "pos.eq.dec" | "pos_eq_dec_main" => Some("dec_deg"),
        "pos.bodyrc.lon" | "pos.bodyrc.long" | "pos.earth.lon" => Some("lon_deg"),
        "pos.bodyrc.lat" | "pos.earth.lat" => Some("lat_deg"),
        _ => None,
    }
}

impl Table {
    /// Finds the columns of a point by name, or else by UCD, and checks the units of the coordinates.
    fn choose_columns(&mut self) -> Result<(), String> {
        let names: Vec<String> = self.fields.iter().map(|f| f.name.clone()).collect();
        let names_by_ucd = || -> Vec<String> {
            let name = |f: &Field| column_name_of_ucd(&f.ucd).map_or_else(|| f.name.clone(), str::to_owned);
            self.fields.iter().map(name).collect()
        };
        let columns = PointColumns::of(&names, self.on_body)
            .or_else(|_| PointColumns::of(&names_by_ucd(), self.on_body))
            .map_err(|why| format!("the TABLE {why}, nor by UCD"))?;
        for field in columns.coordinate_columns().filter_map(|index| self.fields.get(index)) {
            if let Some(unit) = field.unit.as_deref().filter(|unit| !matches!(*unit, "" | "deg" | "degree" | "degrees")) {
                return Err(format!(
                    "field {} (line {}): the unit `{}` is not deg",
                    echo_within(&field.name, 40),
                    field.line,
                    echo_within(unit, 20)
                ));
            }
            // A field without a valid reference may have any of the systems.
            let referenced = self.systems.iter().filter(|system| !system.id.is_empty() && system.id == field.reference).collect::<Vec<_>>();
            let possible: Vec<&CoordinateSystem> = if referenced.is_empty() { self.systems.iter().collect() } else { referenced };
            let is_supported = self.on_body || possible.iter().any(|system| system.is_icrs_or_fk5_j2000());
            if let Some(CoordinateSystem { system, equinox, .. }) = possible.first().filter(|_| !is_supported) {
                let name = echo_within(format!("{system} {equinox}").trim(), 40);
                return Err(format!(
                    "field {} (line {}): the coordinate system (COOSYS) is {name}; only ICRS and FK5 J2000 are supported",
                    echo_within(&field.name, 40),
                    field.line
                ));
            }
        }
        self.columns = Some(columns);
        Ok(())
    }

    /// Adds the points of the rows in a STREAM. `text`: the rows in base64. `has_null_flags`: in each row a bit per column says whether the value is null
    /// (BINARY2).
    fn read_stream(&mut self, text: &str, has_null_flags: bool) -> Result<(), String> {
        let columns = self.columns.as_ref().ok_or("a STREAM outside of BINARY")?;
        let column = |f: &Field| {
            BinaryColumn::new(&f.data_type, &f.arraysize, f.null.as_deref())
                .map_err(|why| format!("field {} (line {}): {why}", echo_within(&f.name, 40), f.line))
        };
        let binary_columns = self.fields.iter().map(column).collect::<Result<Vec<_>, _>>()?;
        let mut rows = BinaryRows::new(&binary_columns, text, has_null_flags)?;
        let mut count = 0_usize;
        while let Some(row) = rows.next_row()? {
            count += 1;
            let point = columns.point(&row).map_err(|why| format!("row {count}: {why}"))?;
            self.content.count_positions(1)?;
            self.content.points.push(point);
        }
        Ok(())
    }
}

impl ElementHandler for Table {
    fn start_element(&mut self, path: &[Element]) -> Result<(), String> {
        let Some(element) = path.last().filter(|_| !self.has_ended) else { return Ok(()) };
        match element.name.as_str() {
            "COOSYS" => {
                let attribute = |name: &str| element.attribute(name).unwrap_or_default().trim().to_owned();
                let (id, system, equinox) = (attribute("ID"), attribute("system"), attribute("equinox"));
                self.systems.push(CoordinateSystem { id, system, equinox });
            }
            "FIELD" => {
                let attribute = |name: &str| element.attribute(name).unwrap_or_default().to_owned();
                let (name, ucd) = (if attribute("name").is_empty() { attribute("ID") } else { attribute("name") }, attribute("ucd"));
                let unit = element.attribute("unit").map(str::to_owned);
                let (data_type, arraysize) = (attribute("datatype"), attribute("arraysize"));
                let reference = attribute("ref");
                self.fields.push(Field { name, ucd, unit, data_type, arraysize, null: None, reference, line: element.line });
            }
            "VALUES" if path.iter().rev().nth(1).is_some_and(|parent| parent.name == "FIELD") => {
                if let Some(field) = self.fields.last_mut() {
                    field.null = element.attribute("null").map(str::to_owned);
                }
            }
            "TABLEDATA" | "BINARY" | "BINARY2" => {
                self.has_data = true;
                self.choose_columns()?;
            }
            "FITS" => {
                return Err(
                    "rows as FITS; ask the service for TABLEDATA, or convert the file (stilts tcopy ofmt=votable-tabledata)".to_owned()
                );
            }
            "STREAM" if element.attribute("href").is_some() => return Err("rows in another file: `href` of STREAM".to_owned()),
            "STREAM" if element.attribute("encoding") != Some("base64") => {
                let encoding = echo_within(element.attribute("encoding").unwrap_or("none"), 20);
                return Err(format!("the encoding of STREAM is `{encoding}`; only base64 is supported"));
            }
            "TR" => self.row.clear(),
            _ => {}
        }
        Ok(())
    }

    fn end_element(&mut self, path: &[Element]) -> Result<(), String> {
        let Some(element) = path.last() else { return Ok(()) };
        // A service that fails while it writes the rows says so after the TABLE (IVOA DALI 1.1, 4.4).
        if element.name == "INFO" && element.attribute("name") == Some("QUERY_STATUS") && element.attribute("value") == Some("ERROR") {
            return Err(format!("the service that wrote it says: {}", echo_within(element.text.trim(), 200)));
        }
        if self.has_ended {
            return Ok(());
        }
        match element.name.as_str() {
            "STREAM" => {
                let serialization = path.iter().rev().nth(1).map_or("", |parent| parent.name.as_str());
                if let "BINARY" | "BINARY2" = serialization {
                    self.read_stream(&element.text, serialization == "BINARY2")?;
                }
            }
            "TD" => self.row.push(element.text.trim().to_owned()),
            "TR" => {
                let columns = self.columns.as_ref().ok_or("a row outside of TABLEDATA")?;
                for (cell, field) in self.row.iter_mut().zip(&self.fields) {
                    if field.is_null(cell) {
                        cell.clear();
                    }
                }
                let point = columns.point(&self.row)?;
                self.content.count_positions(1)?;
                self.content.points.push(point);
            }
            "TABLE" => self.has_ended = true,
            _ => {}
        }
        Ok(())
    }
}

/// The points of a document. `on_body`: as in [`PointColumns::of`]. The error is a line number and what is wrong there.
pub(super) fn read(text: &str, on_body: bool) -> Result<Content, (usize, String)> {
    let mut table = Table { on_body, ..Table::default() };
    walk(text, &mut table)?;
    if !table.has_ended {
        Err((1, "no TABLE in it: not a VOTable".to_owned()))
    } else if !table.has_data {
        Err((1, "its TABLE has neither TABLEDATA nor BINARY".to_owned()))
    } else {
        Ok(table.content)
    }
}
