//! `orrery eclipse find`: a span of time comes in, a table or JSON of what happens in it goes out.

use super::output::put;
use super::{CliError, Common, inputs};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::events::{self, LocalCircumstances, LunarEclipse, LunarType, Place, SolarEclipse};
use crate::time::Instant;
use crate::wording::echo;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Map, Value, json};

#[derive(Args, Debug)]
pub struct EclipseArgs {
    #[command(subcommand)]
    verb: EclipseVerb,
}

#[derive(Subcommand, Debug)]
enum EclipseVerb {
    /// Find the eclipses of a span of time
    Find(FindArgs),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    Solar,
    Lunar,
}

#[derive(Args, Debug)]
#[command(
    after_help = "Examples:
  orrery eclipse find --from 2024-01-01 --to 2030-01-01
  orrery eclipse find --from 2015-03-01 --to 2015-04-01 --kind solar --at 78.22,15.65
  orrery eclipse find --from 1901-01-01 --to 2001-01-01 --kind lunar --radii almanac --json

Instants are UTC (UT1 before 1972) as the Earth's centre receives the light. Contacts: P penumbra, U umbra or antumbra; with --at also C1 to C4 of the
discs. magnitude: covered part of the diameter; in a central solar eclipse the ratio of the diameters; of the Moon in the umbra. --radii iau: the Earth's
shadow on the Moon is not enlarged; almanac: enlarged by Danjon's rule. The mountains of the Moon are left out.",
    next_help_heading = "Search"
)]
struct FindArgs {
    /// Start of the span: ISO 8601 UTC or jd_tdb:2460409.262
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    from: String,
    /// End of the span
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    to: String,
    /// What to find; several with commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "solar,lunar")]
    kind: Vec<Kind>,
    /// Local circumstances of a place: latitude, east longitude (degrees), height (metres)
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", allow_hyphen_values = true)]
    at: Option<String>,
    /// Print a JSON list
    #[arg(long)]
    json: bool,
}

pub fn run(common: &Common, args: &EclipseArgs) -> Result<(), CliError> {
    let EclipseVerb::Find(args) = &args.verb;
    let catalog = inputs::catalog(common)?;
    let ephemeris = inputs::ephemeris(common, &catalog)?;
    let rows = find(&catalog, &ephemeris, args).map_err(CliError::Failed)?;
    if args.json {
        let list: Vec<String> = rows.iter().map(|row| format!("  {row}")).collect();
        return put(&if list.is_empty() { "[]\n".to_owned() } else { format!("[\n{}\n]\n", list.join(",\n")) });
    }
    put(&as_text(&catalog, &rows, args.at.is_some()))
}

/// The events of the span as JSON objects, by time.
fn find(catalog: &Catalog, ephemeris: &Ephemeris, args: &FindArgs) -> Result<Vec<Value>, String> {
    let time = |name: &str, text: &str| Instant::parse(text).map_err(|e| format!("--{name}: {e}"));
    let (from, to) = (time("from", &args.from)?, time("to", &args.to)?);
    if from >= to {
        return Err(format!("--from {} is not before --to {}: swap them", echo(&args.from), echo(&args.to)));
    }
    let place = args.at.as_deref().map(parse_place).transpose()?;
    let radii = catalog.eclipse_radii();
    let mut rows: Vec<(Instant, Value)> = Vec::new();
    let wants = |kind| args.kind.contains(&kind);
    if wants(Kind::Solar) {
        let found = events::solar_eclipses(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        rows.extend(found.iter().map(|e| (e.greatest, solar(e, place))));
    }
    if wants(Kind::Lunar) {
        let found = events::lunar_eclipses(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        rows.extend(found.iter().map(|e| (e.greatest, lunar(e, place, events::shadow_of(radii)))));
    }
    rows.sort_by(|a, b| a.0.tdb_seconds_past_j2000().total_cmp(&b.0.tdb_seconds_past_j2000()));
    for (_, row) in &mut rows {
        row["radii"] = json!(radii.name());
    }
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

/// `LAT,LON` or `LAT,LON,HEIGHT`: degrees, degrees east, metres.
fn parse_place(text: &str) -> Result<Place, String> {
    let wrong = |what: &str| format!("--at {}: {what}; give latitude and east longitude in degrees, such as 78.22,15.65", echo(text));
    let numbers: Vec<f64> =
        text.split(',').map(|part| part.trim().parse().map_err(|_| wrong("not numbers with commas"))).collect::<Result<_, _>>()?;
    let (latitude_deg, longitude_deg, height_m) = match numbers[..] {
        [lat, lon] => (lat, lon, 0.0),
        [lat, lon, height] => (lat, lon, height),
        _ => return Err(wrong("not two or three numbers")),
    };
    if !(-90.0..=90.0).contains(&latitude_deg) || !(-360.0..=360.0).contains(&longitude_deg) {
        return Err(wrong("latitude goes from -90 to 90, longitude from -360 to 360"));
    }
    if !(-12_000.0..=100_000.0).contains(&height_m) {
        return Err(wrong("the height goes from -12000 to 100000 metres"));
    }
    Ok(Place { latitude_deg, longitude_deg, height_km: height_m / 1000.0 })
}

/// Contacts as an object of UTC times.
fn times(contacts: &[(&'static str, Instant)]) -> Value {
    Value::Object(contacts.iter().map(|(name, t)| ((*name).to_owned(), json!(t.to_utc_iso()))).collect())
}

fn solar(e: &SolarEclipse, place: Option<Place>) -> Value {
    let mut row = json!({
        "kind": "solar",
        "type": e.class.name(),
        "central": e.central,
        "greatest": e.greatest.to_utc_iso(),
        "greatest_tt": e.greatest.to_tt_iso(),
        "gamma": e.gamma,
        "magnitude": e.magnitude,
        "contacts": times(&e.contacts),
        "lat": e.place.latitude_deg,
        "lon": e.place.longitude_deg,
        "sun_altitude_deg": e.sun_altitude_deg,
        "duration_s": e.duration_s,
        "saros": e.saros,
    });
    if let Some(place) = place {
        add_local(&mut row, e.seen_from(place).as_ref());
    }
    row
}

fn lunar(e: &LunarEclipse, place: Option<Place>, shadow: &str) -> Value {
    let (penumbral_s, partial_s, total_s) = (e.duration_s("P1", "P4"), e.duration_s("U1", "U4"), e.duration_s("U2", "U3"));
    let mut row = json!({
        "kind": "lunar",
        "type": e.class.name(),
        "greatest": e.greatest.to_utc_iso(),
        "greatest_tt": e.greatest.to_tt_iso(),
        "gamma": e.gamma,
        "magnitude": e.umbral_magnitude,
        "penumbral_magnitude": e.penumbral_magnitude,
        "contacts": times(&e.contacts),
        "lat": e.place.latitude_deg,
        "lon": e.place.longitude_deg,
        "duration_s": match e.class {
            LunarType::Total => total_s,
            LunarType::Partial => partial_s,
            LunarType::Penumbral => penumbral_s,
        },
        "durations_s": { "penumbral": penumbral_s, "partial": partial_s, "total": total_s },
        "saros": e.saros,
        "shadow": shadow,
    });
    if let Some(place) = place {
        add_local(&mut row, Some(&e.seen_from(place)));
    }
    row
}

/// What a place sees, under `local`; and the contacts of the discs beside the others.
fn add_local(row: &mut Value, seen: Option<&LocalCircumstances>) {
    let Some(seen) = seen else {
        row["local"] = json!({ "visible": false });
        return;
    };
    let contact = |c: &events::LocalContact| json!({ "time": c.time.to_utc_iso(), "altitude_deg": c.altitude_deg, "azimuth_deg": c.azimuth_deg, "up": c.is_up() });
    let contacts: Map<String, Value> = seen.contacts.iter().map(|c| (c.name.to_owned(), contact(c))).collect();
    for c in &seen.contacts {
        row["contacts"][c.name] = json!(c.time.to_utc_iso());
    }
    row["local"] = json!({
        "visible": seen.visible,
        "contacts": contacts,
        "maximum": contact(&seen.maximum),
        "magnitude": seen.magnitude,
        "obscuration": seen.obscuration,
        "rise": seen.rise.map(Instant::to_utc_iso),
        "set": seen.set.map(Instant::to_utc_iso),
        "duration_s": seen.central_s,
    });
}

/// `2024-04-08 18:17:20` of an ISO time, to the second.
fn short_time(iso: &Value) -> String {
    let text = iso.as_str().unwrap_or("");
    text.split('.').next().unwrap_or("").trim_end_matches('Z').replace('T', " ")
}

/// `18:17:20` of the same.
fn time_of_day(iso: &Value) -> String {
    short_time(iso).rsplit(' ').next().unwrap_or("").to_owned()
}

fn number(value: &Value, digits: usize) -> String {
    value.as_f64().map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

/// `4m28s`, `1h02m`.
fn length(seconds: &Value) -> String {
    match seconds.as_f64().map(|s| s.round() as i64) {
        None => "-".to_owned(),
        Some(s) if s < 3600 => format!("{}m{:02}s", s / 60, s % 60),
        Some(s) => format!("{}h{:02}m", s / 3600, s % 3600 / 60),
    }
}

fn as_text(catalog: &Catalog, rows: &[Value], at_place: bool) -> String {
    let mut table =
        vec![["greatest (UTC)", "kind", "type", "gamma", "magnitude", "lat", "lon", "duration", "Saros", "contacts"].map(str::to_owned)];
    let mut notes: Vec<Option<String>> = vec![None];
    for row in rows {
        let word = |name: &str| row[name].as_str().unwrap_or("-").to_owned();
        table.push([
            short_time(&row["greatest"]),
            word("kind"),
            word("type"),
            number(&row["gamma"], 4),
            number(&row["magnitude"], 4),
            number(&row["lat"], 2),
            number(&row["lon"], 2),
            length(&row["duration_s"]),
            row["saros"].as_i64().map_or_else(|| "-".to_owned(), |n| n.to_string()),
            contacts_text(row),
        ]);
        notes.push(at_place.then(|| local_text(&row["local"])));
    }
    let widths: [usize; 10] = std::array::from_fn(|column| table.iter().map(|r| r[column].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for (row, note) in table.iter().zip(notes) {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        text += &format!("{}\n", cells.join("  ").trim_end());
        text.extend(note.map(|n| format!("    {n}\n")));
    }
    let shadow = events::shadow_of(catalog.eclipse_radii());
    text + &format!("{} found; radii {}; the Earth's shadow: {shadow}\n", rows.len(), catalog.eclipse_radii_text())
}

/// By time; those of the discs at a place are in its own line.
fn contacts_text(row: &Value) -> String {
    let Some(contacts) = row["contacts"].as_object() else { return String::new() };
    let mut by_time: Vec<_> = contacts.iter().filter(|(name, _)| !name.starts_with('C')).collect();
    by_time.sort_by_key(|(_, time)| time.as_str().unwrap_or(""));
    by_time.iter().map(|(name, time)| format!("{name} {}", time_of_day(time))).collect::<Vec<_>>().join(" ")
}

/// `here: C1 09:11:33 (8°) … magnitude 1.018 at 10:12:02`, or `here: not visible`.
fn local_text(local: &Value) -> String {
    if local["visible"] != json!(true) {
        return "here: not visible".to_owned();
    }
    let one = |name: &str, c: &Value| {
        let below = if c["up"] == json!(true) { "" } else { ", below the horizon" };
        format!("{name} {} ({}°{below})", time_of_day(&c["time"]), number(&c["altitude_deg"], 1))
    };
    let mut by_time: Vec<(String, &Value)> =
        local["contacts"].as_object().into_iter().flatten().map(|(name, c)| (name.clone(), c)).collect();
    by_time.push(("maximum".to_owned(), &local["maximum"]));
    by_time.sort_by_key(|(_, c)| c["time"].as_str().unwrap_or("").to_owned());
    let mut parts: Vec<String> = by_time.iter().map(|(name, c)| one(name, c)).collect();
    parts.push(format!("magnitude {}", number(&local["magnitude"], 4)));
    if !local["obscuration"].is_null() {
        parts.push(format!("obscuration {}", number(&local["obscuration"], 4)));
    }
    for name in ["rise", "set"] {
        if !local[name].is_null() {
            parts.push(format!("{name} {}", time_of_day(&local[name])));
        }
    }
    if !local["duration_s"].is_null() {
        parts.push(format!("for {}", length(&local["duration_s"])));
    }
    format!("here: {}", parts.join(" · "))
}
