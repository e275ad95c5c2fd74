//! Tables of `orrery ephemeris`, one row per instant; also rise, transit, set and twilight of a day at a place.
//!
//! In: a body, instants and the requested columns. Out: a table as text, CSV or JSON. Always: for the same columns every format has the same values; a column's
//! name ends in its unit (in text, sexagesimal angles have no such suffix, and some headings are shorter); a row's time is UTC. Not here: parsing of the
//! command line.

use crate::catalog::small_bodies::NamedTarget;
use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::apparent::{apparent_place, sub_points};
use crate::ephemeris::topocentric::{Horizontal, Observer, ObserverSky};
use crate::ephemeris::{Ephemeris, EphemerisError, Source};
use crate::scene::{Observed, SceneError, SkyOfEarth};
use crate::time::{Instant, TimeStep};
use crate::units::{KM_PER_AU, SECONDS_PER_DAY};
use crate::wording::fixed_decimals;
use clap::ValueEnum;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Largest number of rows: enough for a year in steps of 160 s.
pub(crate) const MAX_ROWS: usize = 200_000;

/// A quantity that an observer sees; some have two columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ObserverColumn {
    /// Apparent right ascension and declination of date
    Position,
    /// Azimuth and altitude at the place of --at, without refraction
    Horizon,
    /// Visual magnitude
    Magnitude,
    /// Mean visual magnitude of a square arcsecond of the lit part
    SurfaceBrightness,
    /// Largest diameter, arcseconds
    Diameter,
    /// Lit part of the disc, 0 to 1
    Illuminated,
    /// Angle at the body between Sun and observer
    Phase,
    /// Angle from the Sun, east (evening) or west (morning)
    Elongation,
    /// Constellation by the IAU's borders
    Constellation,
    /// Distance from the observer, km and au
    Distance,
    /// Rate of change of the distance, positive if it grows
    RangeRate,
}

impl ObserverColumn {
    /// All columns in their order; those of the horizon only at a place.
    pub(crate) fn all(at_place: bool) -> Vec<Self> {
        Self::value_variants().iter().copied().filter(|column| at_place || *column != Self::Horizon).collect()
    }

    /// The columns that fit into 100 characters.
    pub(crate) fn of_text(at_place: bool) -> Vec<Self> {
        let place = if at_place { Self::Horizon } else { Self::Position };
        vec![place, Self::Magnitude, Self::Diameter, Self::Illuminated, Self::Elongation, Self::Constellation]
    }

    /// The cells of this quantity.
    fn cells(self, observed: &Observed, horizon: Option<Horizontal>) -> Row {
        let number = |value: Option<f64>, decimals: usize| value.map_or(Cell::Empty, |v| Cell::Number(v, decimals));
        let place = &observed.place;
        match self {
            Self::Position => {
                let of_date = place.true_of_date;
                let sexagesimal = |text: String, degrees: f64| Cell::Sexagesimal { text, degrees, decimals: 7 };
                vec![
                    ("ra_deg", sexagesimal(of_date.ra_text(), of_date.ra_deg)),
                    ("dec_deg", sexagesimal(of_date.dec_text(), of_date.dec_deg)),
                ]
            }
            Self::Horizon => vec![
                ("azimuth_deg", horizon.map_or(Cell::Empty, |h| Cell::Angle(h.azimuth_deg, 5))),
                ("altitude_deg", number(horizon.map(|h| h.altitude_deg), 5)),
            ],
            Self::Magnitude => vec![("magnitude", number(observed.magnitude, 2))],
            Self::SurfaceBrightness => vec![("surface_brightness_mag_arcsec2", number(observed.surface_brightness_mag_arcsec2, 2))],
            Self::Diameter => vec![("diameter_arcsec", number(observed.angular_diameter_deg.map(|deg| 3600.0 * deg), 2))],
            Self::Illuminated => vec![("illuminated_fraction", number(observed.illuminated_fraction, 3))],
            Self::Phase => vec![("phase_angle_deg", number(observed.phase_angle_deg, 3))],
            Self::Elongation => {
                let side = |is_east: bool| Cell::Text(if is_east { "east" } else { "west" }.into());
                vec![
                    ("elongation_deg", number(observed.elongation.map(|e| e.angle_deg), 2)),
                    ("elongation_side", observed.elongation.map_or(Cell::Empty, |e| side(e.is_east))),
                ]
            }
            Self::Constellation => {
                vec![("constellation", Cell::Text(observed.constellation.map_or("", |c| c.abbreviation.as_str()).into()))]
            }
            Self::Distance => {
                vec![("distance_km", Cell::Number(place.distance_km, 3)), ("distance_au", Cell::Number(place.distance_km / KM_PER_AU, 9))]
            }
            Self::RangeRate => vec![("range_rate_km_s", Cell::Number(observed.range_rate_km_s, 6))],
        }
    }
}

/// The shorter heading that a column has in text.
fn short_heading(name: &str) -> &str {
    match name {
        "magnitude" => "mag",
        "diameter_arcsec" => "arcsec",
        "illuminated_fraction" => "lit",
        "elongation_deg" => "elong",
        "elongation_side" => "side",
        "constellation" => "const",
        other => other,
    }
}

/// The columns of a table.
#[derive(Clone, Copy)]
pub(crate) enum Columns<'a> {
    /// Geometric position and velocity relative to a centre, ICRF; distance, error and source. `source`: `None` selects the best one for each instant.
    State { center: NaifId, source: Option<Source> },
    /// Apparent right ascension and declination from the Earth's centre, of date and in GCRS; distance, light time and error.
    Apparent,
    /// Sub-observer and sub-solar point, phase angle, distance and light time.
    Orientation { observer: NaifId },
    /// Azimuth, altitude and hour angle at a place, without refraction; distance and semidiameter.
    Horizontal { place: Observer },
    /// What an observer on the Earth sees.
    Observer { sky: &'a SkyOfEarth<'a>, columns: &'a [ObserverColumn] },
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
    body: &NamedTarget,
    columns: Columns<'_>,
    times: &[Instant],
    format: OutputFormat,
) -> Result<String, String> {
    let rows: Vec<Row> = times
        .iter()
        .map(|t| row(catalog, ephemeris, body, columns, *t).map_err(|e| format!("{}: {e}", t.to_utc_iso())))
        .collect::<Result<_, _>>()?;
    Ok(format_rows(&rows, format))
}

/// The row of what an observer sees at an instant.
fn observer_row(sky: &SkyOfEarth<'_>, body: &NamedTarget, columns: &[ObserverColumn], t: Instant) -> Result<Row, SceneError> {
    let observed = sky.observe(body, t)?;
    let horizon = if columns.contains(&ObserverColumn::Horizon) { sky.horizontal(body, t)? } else { None };
    let mut row: Row = vec![("time_utc", Cell::Text(t.to_utc_iso()))];
    row.extend(columns.iter().flat_map(|column| column.cells(&observed, horizon)));
    Ok(row)
}

/// What an observer sees at an instant, as a JSON object.
///
/// # Errors
/// See [`SkyOfEarth::observe`].
pub(crate) fn observed_as_json(sky: &SkyOfEarth<'_>, body: &NamedTarget, columns: &[ObserverColumn], t: Instant) -> Result<Value, String> {
    observer_row(sky, body, columns, t).map(|row| row_as_json(&row)).map_err(|e| e.to_string())
}

/// The body of the catalog whose orientation is requested.
///
/// # Errors
/// A barycentre has no orientation, and that of minor planets and comets outside the catalog is unknown.
pub(crate) fn body_with_orientation<'c>(catalog: &'c Catalog, named: &NamedTarget) -> Result<&'c Body, &'static str> {
    match named {
        NamedTarget::Body(id) => catalog.body(*id).ok_or("a barycentre has no orientation"),
        NamedTarget::SmallBody(_) => Err("the rotation of this small body is unknown, so that it has no orientation"),
    }
}

/// The row of an instant. The last printed decimal is a metre, a micrometre per second or a millisecond. Of apparent places it is 0.4 milliarcseconds, of their
/// error 0.1 milliarcseconds, of semidiameters 0.004 arcseconds, and of other angles 0.04 arcseconds.
fn row(catalog: &Catalog, ephemeris: &Ephemeris, body: &NamedTarget, columns: Columns<'_>, t: Instant) -> Result<Row, EphemerisError> {
    let mut row: Row = vec![("time_utc", Cell::Text(t.to_utc_iso()))];
    match columns {
        Columns::State { center, source } => {
            let found = ephemeris.target_state(body.into(), center, t, source)?;
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
            let body = body_with_orientation(catalog, body).map_err(EphemerisError::other)?;
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
            // The size of a minor planet or comet is not known.
            let is_small = matches!(body, NamedTarget::SmallBody(_));
            row.extend([
                ("azimuth_deg", Cell::Angle(topocentric.azimuth_deg, 5)),
                ("altitude_deg", Cell::Number(topocentric.altitude_deg, 5)),
                ("hour_angle_deg", Cell::Number(topocentric.hour_angle_deg, 5)),
                ("distance_km", Cell::Number(topocentric.distance_km, 3)),
                ("semidiameter_deg", if is_small { Cell::Empty } else { Cell::Number(topocentric.semidiameter_deg, 6) }),
            ]);
        }
        Columns::Observer { sky, columns } => {
            return observer_row(sky, body, columns, t).map_err(|e| EphemerisError::other(e.to_string()));
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
            _ => short_heading(name).to_owned(),
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
    body: &NamedTarget,
    place: Observer,
    start: Instant,
) -> Result<Value, EphemerisError> {
    let sky = ObserverSky { catalog, ephemeris, place };
    let name = match body {
        NamedTarget::Body(id) => catalog.body(*id).map(|b| b.name.clone()),
        NamedTarget::SmallBody(small) => Some(small.full_name()),
    };
    let found = sky.rise_set_times(body, start, SECONDS_PER_DAY)?;
    let time = |t: Option<Instant>| t.map_or(Value::Null, |t| json!(t.to_utc_iso()));
    let event = |t: Option<Instant>| -> Result<Value, EphemerisError> {
        let Some(t) = t else { return Ok(Value::Null) };
        let topocentric = sky.topocentric(body, t)?;
        Ok(json!({ "time": t.to_utc_iso(), "azimuth_deg": topocentric.azimuth_deg, "altitude_deg": topocentric.altitude_deg }))
    };
    let mut answer = json!({
        "body": name,
        "place": { "lat_deg": place.lat_graphic_deg, "lon_deg": place.lon_east_deg, "height_km": place.height_km },
        "from": start.to_utc_iso(),
        "to": start.plus_seconds(SECONDS_PER_DAY).to_utc_iso(),
        "up_at_start": found.is_up_at_start,
        "rise": event(found.rise)?,
        "transit": event(found.transit.map(|(t, _altitude_deg)| t))?,
        "set": event(found.set)?,
    });
    for (name, t) in [
        ("second_rise", found.second_rise),
        ("second_transit", found.second_transit.map(|(t, _altitude_deg)| t)),
        ("second_set", found.second_set),
    ] {
        if t.is_some() {
            answer[name] = event(t)?;
        }
    }
    if *body == NamedTarget::Body(NaifId::SUN) {
        let mut twilight = Map::new();
        for (name, altitude_deg) in TWILIGHTS {
            let [dawn, dusk] = sky.crossings(NaifId::SUN, altitude_deg, start, SECONDS_PER_DAY)?;
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
    // A second event only if there is one: a planet may rise twice in 24 hours, just after their start and just before their end.
    let names = ["rise", "second_rise", "transit", "second_transit", "set", "second_set"];
    for name in names.into_iter().filter(|name| !name.starts_with("second") || events[*name].is_object()) {
        let event = &events[name];
        let name = name.replace('_', " ");
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
