//! Tables of `orrery ephemeris`, one row per instant; also rise, transit, set and twilight of a day at a place.
//!
//! In: a body, instants and the requested columns. Out: a table as text, CSV or JSON. Always: every format has the same columns; a column's name ends in its
//! unit (in text, sexagesimal angles have no such suffix); a row's time is UTC. Not here: parsing of the command line.

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::apparent::{apparent_place, sub_points};
use crate::ephemeris::topocentric::{Observer, ObserverSky};
use crate::ephemeris::{Ephemeris, EphemerisError, Source};
use crate::time::{Instant, TimeStep};
use crate::units::SECONDS_PER_DAY;
use crate::wording::fixed_decimals;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Largest number of rows: enough for a year in steps of 160 s.
pub(crate) const MAX_ROWS: usize = 200_000;

/// The columns of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Columns {
    /// Geometric position and velocity relative to a centre, ICRF; distance, error and source. `source`: `None` selects the best one for each instant.
    State { center: NaifId, source: Option<Source> },
    /// Apparent right ascension and declination from the Earth's centre, of date and in GCRS; distance, light time and error.
    Apparent,
    /// Sub-observer and sub-solar point, phase angle, distance and light time.
    Orientation { observer: NaifId },
    /// Azimuth, altitude and hour angle at a place, without refraction; distance and semidiameter.
    Horizontal { place: Observer },
}

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
enum Cell {
    /// A number, and its number of decimals in text and CSV.
    Number(f64, usize),
    /// An angle in degrees below 360, and its number of decimals in text and CSV. What rounds to 360 is printed as 0.
    Angle(f64, usize),
    /// An angle that text shows in sexagesimal notation, and CSV in degrees with a number of decimals.
    Sexagesimal {
        text: String,
        degrees: f64,
        decimals: usize,
    },
    Text(String),
    /// A value that is unknown or does not exist: `-` in text, nothing in CSV, null in JSON.
    Empty,
}

/// The name of each column with its cell.
type Row = Vec<(&'static str, Cell)>;

/// How a table is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OutputFormat {
    Text,
    Csv,
    Json,
}

/// The instants from `from` to `to` (included if a step falls on it) in equal steps.
///
/// # Errors
/// A step that is not positive, a negative span, or more than [`MAX_ROWS`] instants.
pub(crate) fn instants(from: Instant, to: Instant, step: TimeStep) -> Result<Vec<Instant>, String> {
    let span_s = to.tdb_seconds_past_j2000() - from.tdb_seconds_past_j2000();
    if span_s < 0.0 {
        return Err("--from is after --to: swap them".into());
    }
    if !step.is_forward() {
        return Err("--step: must be more than 0".into());
    }
    let all = (0..=MAX_ROWS).map(|k| step.after(from, k as f64));
    // The tolerance of a tenth of a millisecond covers the rounding of `to` in its conversion to TDB.
    let rows: Vec<Instant> = all.take_while(|t| t.tdb_seconds_past_j2000() <= to.tdb_seconds_past_j2000() + 1e-4).collect();
    if rows.len() > MAX_ROWS {
        return Err(format!("--step: more than {MAX_ROWS} rows; take a longer step or a shorter span"));
    }
    Ok(rows)
}

/// A table of a body at given instants.
///
/// # Errors
/// The error of the ephemeris, with the instant at which it occurred.
pub(crate) fn table(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    body: NaifId,
    columns: Columns,
    times: &[Instant],
    format: OutputFormat,
) -> Result<String, String> {
    let rows: Vec<Row> = times
        .iter()
        .map(|t| row(catalog, ephemeris, body, columns, *t).map_err(|e| format!("{}: {e}", t.to_utc_iso())))
        .collect::<Result<_, _>>()?;
    Ok(format_rows(&rows, format))
}

/// The row of an instant. The last printed decimal is a metre, a micrometre per second or a millisecond. Of apparent places it is 0.4 milliarcseconds, of their
/// error 0.1 milliarcseconds, of semidiameters 0.004 arcseconds, and of other angles 0.04 arcseconds.
fn row(catalog: &Catalog, ephemeris: &Ephemeris, body: NaifId, columns: Columns, t: Instant) -> Result<Row, EphemerisError> {
    let mut row: Row = vec![("time_utc", Cell::Text(t.to_utc_iso()))];
    match columns {
        Columns::State { center, source } => {
            let found = ephemeris.state(body, center, t, source)?;
            for (name, km) in ["x_km", "y_km", "z_km"].into_iter().zip(found.state.pos_km.to_array()) {
                row.push((name, Cell::Number(km, 3)));
            }
            for (name, km_s) in ["vx_km_s", "vy_km_s", "vz_km_s"].into_iter().zip(found.state.vel_km_s.to_array()) {
                row.push((name, Cell::Number(km_s, 9)));
            }
            row.push(("distance_km", Cell::Number(found.state.pos_km.length(), 3)));
            let error = if found.error_km.is_finite() { Cell::Number(found.error_km, 3) } else { Cell::Empty };
            row.extend([("error_km", error), ("source", Cell::Text(source_name(found.source)))]);
        }
        Columns::Apparent => {
            let apparent = apparent_place(ephemeris, body, t)?;
            let (of_date, gcrs) = (apparent.true_of_date, apparent.gcrs);
            let sexagesimal = |text: String, degrees: f64| Cell::Sexagesimal { text, degrees, decimals: 7 };
            row.extend([
                ("ra_deg", sexagesimal(of_date.ra_text(), of_date.ra_deg)),
                ("dec_deg", sexagesimal(of_date.dec_text(), of_date.dec_deg)),
                ("ra_gcrs_deg", sexagesimal(gcrs.ra_text(), gcrs.ra_deg)),
                ("dec_gcrs_deg", sexagesimal(gcrs.dec_text(), gcrs.dec_deg)),
                ("distance_km", Cell::Number(apparent.distance_km, 3)),
                ("light_time_s", Cell::Number(apparent.light_time_s, 3)),
                ("error_arcsec", if apparent.error_arcsec.is_finite() { Cell::Number(apparent.error_arcsec, 4) } else { Cell::Empty }),
            ]);
        }
        Columns::Orientation { observer } => {
            let body = catalog.body(body).ok_or_else(|| EphemerisError::other("a barycentre has no orientation"))?;
            let points = sub_points(ephemeris, body, observer, t)?;
            let degrees = |value: Option<f64>| value.map_or(Cell::Empty, |v| Cell::Angle(v, 5));
            row.extend([
                ("sub_observer_lat_deg", degrees(Some(points.sub_observer.lat_graphic_deg))),
                ("sub_observer_lon_east_deg", degrees(Some(points.sub_observer.lon_east_deg))),
                ("sub_solar_lat_deg", degrees(points.sub_solar.map(|p| p.lat_graphic_deg))),
                ("sub_solar_lon_east_deg", degrees(points.sub_solar.map(|p| p.lon_east_deg))),
                ("phase_angle_deg", degrees(points.phase_angle_deg)),
                ("distance_km", Cell::Number(points.distance_km, 3)),
                ("light_time_s", Cell::Number(points.light_time_s, 3)),
            ]);
        }
        Columns::Horizontal { place } => {
            let topocentric = ObserverSky { catalog, ephemeris, place }.topocentric(body, t)?;
            row.extend([
                ("azimuth_deg", Cell::Angle(topocentric.azimuth_deg, 5)),
                ("altitude_deg", Cell::Number(topocentric.altitude_deg, 5)),
                ("hour_angle_deg", Cell::Number(topocentric.hour_angle_deg, 5)),
                ("distance_km", Cell::Number(topocentric.distance_km, 3)),
                ("semidiameter_deg", Cell::Number(topocentric.semidiameter_deg, 6)),
            ]);
        }
    }
    Ok(row)
}

fn source_name(source: Source) -> String {
    json!(source).as_str().unwrap_or_default().to_owned()
}

fn format_rows(rows: &[Row], format: OutputFormat) -> String {
    let mut out = String::new();
    match format {
        OutputFormat::Json => {
            let objects: Vec<String> = rows.iter().map(|row| format!("  {}", row_as_json(row))).collect();
            out = format!("[\n{}\n]\n", objects.join(",\n"));
        }
        OutputFormat::Csv => {
            let names: Vec<&str> = rows.first().map_or(Vec::new(), |row| row.iter().map(|(name, _)| *name).collect());
            let _ = writeln!(out, "{}", names.join(","));
            for row in rows {
                let cells: Vec<String> = row.iter().map(|(_, cell)| cell.in_csv()).collect();
                let _ = writeln!(out, "{}", cells.join(","));
            }
        }
        OutputFormat::Text => {
            let mut lines: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|(_, cell)| cell.in_text()).collect()).collect();
            let headings = rows.first().map_or(Vec::new(), |row| row.iter().map(|(name, cell)| cell.heading(name)).collect());
            lines.insert(0, headings);
            let widths: Vec<usize> =
                (0..lines[0].len()).map(|k| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0)).collect();
            for line in lines {
                let cells: Vec<String> = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
                let _ = writeln!(out, "{}", cells.join("  "));
            }
        }
    }
    out
}

fn row_as_json(row: &Row) -> Value {
    let value = |cell: &Cell| match cell {
        Cell::Number(v, _) | Cell::Angle(v, _) | Cell::Sexagesimal { degrees: v, .. } => json!(v),
        Cell::Text(text) => json!(text),
        Cell::Empty => Value::Null,
    };
    row.iter().map(|(name, cell)| ((*name).to_owned(), value(cell))).collect::<Map<_, _>>().into()
}

/// An angle with this many decimals; what rounds to 360 degrees is 0.
fn angle_text(degrees: f64, decimals: usize) -> String {
    let text = |v: f64| fixed_decimals(v, decimals);
    if text(degrees) == text(360.0) { text(0.0) } else { text(degrees) }
}

impl Cell {
    fn in_text(&self) -> String {
        match self {
            Self::Number(v, decimals) => fixed_decimals(*v, *decimals),
            Self::Angle(v, decimals) => angle_text(*v, *decimals),
            Self::Sexagesimal { text, .. } | Self::Text(text) => text.clone(),
            Self::Empty => "-".into(),
        }
    }

    fn in_csv(&self) -> String {
        match self {
            Self::Number(v, decimals) => fixed_decimals(*v, *decimals),
            Self::Angle(v, decimals) | Self::Sexagesimal { degrees: v, decimals, .. } => angle_text(*v, *decimals),
            Self::Text(text) => text.clone(),
            Self::Empty => String::new(),
        }
    }

    /// The heading of this cell's column in a text table. Sexagesimal angles are not decimal degrees, so their heading lacks the suffix `_deg`.
    fn heading(&self, name: &str) -> String {
        match self {
            Self::Sexagesimal { .. } => name.trim_end_matches("_deg").to_owned(),
            _ => name.to_owned(),
        }
    }
}

/// Altitudes of the Sun's centre, degrees, at the ends of the twilights (Explanatory Supplement, 3rd ed., section 12.1.3).
const TWILIGHTS: [(&str, f64); 3] = [("civil", -6.0), ("nautical", -12.0), ("astronomical", -18.0)];

/// Rise, transit and set of a body at a place in the 24 hours from `start`, as JSON; for the Sun also civil, nautical and
/// astronomical dawn and dusk.
///
/// # Errors
/// See [`ObserverSky::topocentric`].
pub(crate) fn rise_and_set(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    body: NaifId,
    place: Observer,
    start: Instant,
) -> Result<Value, EphemerisError> {
    let sky = ObserverSky { catalog, ephemeris, place };
    let found = sky.rise_set_times(body, start, SECONDS_PER_DAY)?;
    let time = |t: Option<Instant>| t.map_or(Value::Null, |t| json!(t.to_utc_iso()));
    let event = |t: Option<Instant>| -> Result<Value, EphemerisError> {
        let Some(t) = t else { return Ok(Value::Null) };
        let topocentric = sky.topocentric(body, t)?;
        Ok(json!({ "time": t.to_utc_iso(), "azimuth_deg": topocentric.azimuth_deg, "altitude_deg": topocentric.altitude_deg }))
    };
    let mut answer = json!({
        "body": catalog.body(body).map(|b| b.name.clone()),
        "place": { "lat_deg": place.lat_graphic_deg, "lon_deg": place.lon_east_deg, "height_km": place.height_km },
        "from": start.to_utc_iso(),
        "to": start.plus_seconds(SECONDS_PER_DAY).to_utc_iso(),
        "up_at_start": found.is_up_at_start,
        "rise": event(found.rise)?,
        "transit": event(found.transit.map(|(t, _altitude_deg)| t))?,
        "set": event(found.set)?,
    });
    if body == NaifId::SUN {
        let mut twilight = Map::new();
        for (name, altitude_deg) in TWILIGHTS {
            let [dawn, dusk] = sky.crossings(body, altitude_deg, start, SECONDS_PER_DAY)?;
            twilight.insert(name.into(), json!({ "dawn": time(dawn), "dusk": time(dusk) }));
        }
        answer["twilight"] = twilight.into();
    }
    Ok(answer)
}

/// The result of [`rise_and_set`] as text, one event per line.
pub(crate) fn rise_and_set_text(events: &Value) -> String {
    let mut out = String::new();
    let above_or_below = if events["up_at_start"].as_bool() == Some(true) { "above" } else { "below" };
    let _ = writeln!(
        out,
        "{} at {}, {}, from {}: {above_or_below} the horizon at first",
        events["body"].as_str().unwrap_or_default(),
        events["place"]["lat_deg"],
        events["place"]["lon_deg"],
        events["from"].as_str().unwrap_or_default()
    );
    for name in ["rise", "transit", "set"] {
        let event = &events[name];
        let _ = match (event["time"].as_str(), event["azimuth_deg"].as_f64(), event["altitude_deg"].as_f64()) {
            (Some(time), Some(azimuth), Some(altitude)) => {
                let (azimuth, altitude) = (angle_text(azimuth, 2), fixed_decimals(altitude, 2));
                writeln!(out, "{name:<22}{time}  azimuth {azimuth} deg, altitude {altitude} deg")
            }
            _ => writeln!(out, "{name:<22}none within the day"),
        };
    }
    for (name, _) in TWILIGHTS.iter().filter(|_| events["twilight"].is_object()) {
        for end in ["dawn", "dusk"] {
            let time = events["twilight"][name][end].as_str().unwrap_or("none within the day");
            let _ = writeln!(out, "{:<22}{time}", format!("{name} {end}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// South of the tropics the Sun culminates in the north, just east or just west of it.
    #[test]
    fn an_angle_that_rounds_to_a_full_circle_is_zero() {
        let event = |azimuth: f64| json!({ "time": "2026-06-21T10:48:00Z", "azimuth_deg": azimuth, "altitude_deg": 32.6 });
        for (azimuth, text) in [(359.997, "azimuth 0.00 deg"), (359.99, "azimuth 359.99 deg"), (0.001, "azimuth 0.00 deg")] {
            let printed = rise_and_set_text(&json!({ "transit": event(azimuth), "place": {} }));
            assert!(printed.contains(text), "{azimuth}: {printed}");
        }
        let texts = |cell: Cell| (cell.in_text(), cell.in_csv());
        assert_eq!(texts(Cell::Angle(359.999_999, 5)), ("0.00000".to_owned(), "0.00000".to_owned()));
        assert_eq!(texts(Cell::Angle(359.99, 5)).0, "359.99000");
        let ra = Cell::Sexagesimal { text: "0h".into(), degrees: 359.999_999_99, decimals: 7 };
        assert_eq!(ra.in_csv(), "0.0000000");
        assert_eq!(Cell::Number(359.999_9, 3).in_csv(), "360.000", "a distance is not an angle");
    }

    /// Values near zero are, for example, the latitude below the Sun at an equinox, the altitude of a body that rises, and the hour angle of one that
    /// culminates.
    #[test]
    fn a_value_that_rounds_to_zero_has_no_sign() {
        for degrees in [-0.000_004, -0.0] {
            let declination = Cell::Sexagesimal { text: String::new(), degrees, decimals: 5 };
            for cell in [Cell::Number(degrees, 5), Cell::Angle(degrees, 5), declination] {
                assert_eq!(cell.in_csv(), "0.00000", "{cell:?}");
            }
            assert_eq!([Cell::Number(degrees, 5).in_text(), Cell::Angle(degrees, 5).in_text()], ["0.00000", "0.00000"]);
        }
        assert_eq!(Cell::Number(-0.000_006, 5).in_text(), "-0.00001");
        let event = json!({ "time": "2026-06-21T10:48:00Z", "azimuth_deg": 0.0, "altitude_deg": -0.004 });
        let printed = rise_and_set_text(&json!({ "transit": event, "place": {} }));
        assert!(printed.contains("altitude 0.00 deg"), "{printed}");
    }
}
