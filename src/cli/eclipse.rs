//! `orrery eclipse find`: finds eclipses, transits, and phenomena of the Galilean moons and Titan (*moon events*) in a span of time.
//!
//! In: the span, the kinds of events, and optionally a place on the Earth. Out: a table (`eclipse_table`) or JSON on standard output, and the paths of central
//! solar eclipses as a GeoJSON file. The events are computed by `events`.

use super::eclipse_table::as_text;
use super::output::print_result;
use super::output_file::write_output_file;
use super::view_args::parse_time_or_now;
use super::{CliError, Common, inputs};
use crate::catalog::lunar_heights::HeightMap;
use crate::catalog::{Catalog, EclipseRadii, NaifId};
use crate::ephemeris::Ephemeris;
use crate::events::{self, GeodeticPosition, LimbContact, LocalCircumstances, LunarEclipse, LunarType, MoonEvent, SolarEclipse, Transit};
use crate::files::check_output_path;
use crate::time::Instant;
use crate::wording::echo;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[command(after_help = "Examples:
  orrery eclipse find --from 2024-01-01 --to 2030-01-01
  orrery eclipse find --help")]
pub(crate) struct EclipseArgs {
    #[command(subcommand)]
    verb: EclipseVerb,
}

#[derive(Subcommand, Debug)]
enum EclipseVerb {
    /// Find the eclipses, transits and phenomena of moons in a span of time
    Find(FindArgs),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    Solar,
    Lunar,
    /// Mercury and Venus in front of the Sun
    Transit,
    /// Io, Europa, Ganymede, Callisto and Titan: transits, occultations, shadow transits, eclipses, and mutual events of the Galilean moons
    Moons,
}

#[derive(Args, Debug)]
#[command(
    after_help = "Examples:
  orrery eclipse find --from 2024-01-01 --to 2030-01-01
  orrery eclipse find --from 2015-03-01 --to 2015-04-01 --kind solar --at 78.22,15.65
  orrery eclipse find --from 2024-04-01 --to 2024-05-01 --kind solar --path path.geojson
  orrery eclipse find --from 2024-04-01 --to 2024-05-01 --kind solar --at 32.78,-96.80 --lunar-heights LDEM_16.LBL
  orrery eclipse find --from 2015-01-24 --to 2015-01-25 --kind moons
  orrery eclipse find --from 1901-01-01 --to 2001-01-01 --kind lunar --radii almanac --json

Instants are UTC (UT1 before 1972; in the far future without further leap seconds, so
70 minutes ahead of the time of day in 3000), when the light reaches the Earth's
centre. Dates are Gregorian in all years, also before 1582; year 0000 is 1 BC, -0584
is 585 BC.
Contacts of eclipses: P of the penumbra, U of the umbra or antumbra; with --at also
C1 to C4 of the discs. Contacts of transits and moons: I to IV, when the limbs touch
(of transits with --at also those at the place); begin and end, when the centre of the
moon or of its shadow passes the planet's edge; in transits and shadow transits the
edge of its lit part that the Earth sees.
Longitudes, circumstances at a place and instants before 1972 are as uncertain as
Delta T (TT - UT1). Its standard error is printed if it is half a second or more.
Magnitude: covered fraction of the Sun's diameter, in a central eclipse the ratio of
the diameters; in a lunar eclipse the fraction of the Moon's diameter in the umbra,
negative if the Moon misses it; in a transit the ratio of the planet's diameter to the
Sun's.
Gamma: least distance of the shadow's axis from the Earth's centre, in a lunar eclipse
of the Moon's centre from the axis, in Earth radii; in a transit of the planet from the
Sun's centre, in solar radii. Positive to the north.
Duration: of totality or annularity at the greatest eclipse of the Sun; of the total,
else of the partial, else of the penumbral phase of a lunar eclipse; from I to IV in a
transit (with --at also II to III at the place); from begin to end of a moon's event.
Place: of the greatest eclipse of the Sun; in a lunar eclipse where the Moon is in the
zenith. Saros 136/20: the 20th eclipse of series 136.
With --radii iau the Earth's shadow is the geometric one, with almanac it is enlarged
by Danjon's rule, for the air: this is the shadow that observers time. Where the type
differs, the table has that of almanacs, too (2021-05-26: total, not partial).
Contacts are those of the Moon's mean limb. With --at and --lunar-heights (a map of
your own; none is included) those of its real limb are added: its C2 is the last bead
and its C3 the first.",
    next_help_heading = "Search"
)]
struct FindArgs {
    /// Start of the span: ISO 8601 UTC, jd_tdb:2460409.262 or now
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    from: String,
    /// End of the span
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    to: String,
    /// What to find; separate several by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "solar,lunar")]
    kind: Vec<Kind>,
    /// Local circumstances of eclipses and transits at a place: latitude, east longitude (degrees), height (metres)
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", allow_hyphen_values = true)]
    at: Option<String>,
    /// Write centre lines and limits of the central solar eclipses found as GeoJSON
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "path")]
    overwrite: bool,
    /// Print a JSON list
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(common: &Common, args: &EclipseArgs) -> Result<(), CliError> {
    let EclipseVerb::Find(args) = &args.verb;
    // Checked before the search, which takes minutes for a span of centuries.
    if args.path.as_deref() == Some(Path::new("-")) {
        return Err(CliError::Usage("--path -: standard output has the table; name a file, such as path.geojson".into()));
    }
    args.path.as_deref().map(check_output_path).transpose()?;
    let question = Question::of(args).map_err(CliError::Usage)?;
    let catalog = inputs::catalog(common)?;
    let ephemeris = inputs::ephemeris(common, &catalog)?;
    let Found { rows, lunar_by_almanacs, path_file_result } = find(&catalog, &ephemeris, args, &question).map_err(CliError::Failed)?;
    if args.json {
        let list: Vec<String> = rows.iter().map(|row| format!("  {row}")).collect();
        print_result(&if list.is_empty() { "[]\n".to_owned() } else { format!("[\n{}\n]\n", list.join(",\n")) })?;
    } else {
        print_result(&as_text(&catalog, &rows, &lunar_by_almanacs))?;
    }
    path_file_result.map_err(CliError::Failed)
}

/// The span and the place of the options.
struct Question {
    from: Instant,
    to: Instant,
    observer: Option<GeodeticPosition>,
}

impl Question {
    fn of(args: &FindArgs) -> Result<Self, String> {
        let time = |name: &str, text: &str| parse_time_or_now(text).map_err(|e| format!("--{name}: {e}"));
        let (from, to) = (time("from", &args.from)?, time("to", &args.to)?);
        if from >= to {
            return Err(format!("--from {} is not before --to {}: swap them", echo(&args.from), echo(&args.to)));
        }
        if args.path.is_some() && !args.kind.contains(&Kind::Solar) {
            return Err("--path: only eclipses of the Sun have a path; add solar to --kind".into());
        }
        Ok(Self { from, to, observer: args.at.as_deref().map(parse_place).transpose()? })
    }
}

/// What [`find`] found.
struct Found {
    /// The events of the span as JSON objects, in order of time.
    rows: Vec<Value>,
    /// For the table: the eclipses of the Moon as almanacs have them, unless the rows already do.
    lunar_by_almanacs: Vec<LunarEclipse>,
    /// The result of writing the file of `--path`: `run` prints the events even if the file cannot be written.
    path_file_result: Result<(), String>,
}

/// Finds the events of the span, and writes the file of `--path`.
fn find(catalog: &Catalog, ephemeris: &Ephemeris, args: &FindArgs, question: &Question) -> Result<Found, String> {
    let Question { from, to, observer } = *question;
    let radii = catalog.eclipse_radii();
    let mut rows: Vec<(Instant, Value)> = Vec::new();
    let mut lunar_by_almanacs = Vec::new();
    let mut path_file_result = Ok(());
    let is_wanted = |kind| args.kind.contains(&kind);
    if is_wanted(Kind::Solar) {
        let found = events::solar_eclipses(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        for eclipse in &found {
            let mut row = solar_row(eclipse, observer);
            if let (Some(observer), Some(map)) = (observer, catalog.lunar_heights()) {
                let contacts = eclipse.limb_contacts(observer, ephemeris, map).map_err(|e| e.to_string())?;
                row["local"]["limb"] = limb_circumstances(&contacts, map);
            }
            rows.push((eclipse.greatest, row));
        }
        if let Some(file) = &args.path {
            path_file_result = write_eclipse_paths(file, &found, radii.name(), args.overwrite);
        }
    }
    if is_wanted(Kind::Lunar) {
        let found = events::lunar_eclipses(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        rows.extend(found.iter().map(|e| (e.greatest, lunar_row(e, observer, events::shadow_enlargement(radii)))));
        if !args.json && radii != EclipseRadii::Almanac {
            lunar_by_almanacs = events::lunar_eclipses_by_almanacs(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        }
    }
    if is_wanted(Kind::Transit) {
        let found = events::transits(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        rows.extend(found.iter().map(|e| (e.greatest, transit_row(catalog, e, observer))));
    }
    if is_wanted(Kind::Moons) {
        let found = events::moon_events(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        let mutual = events::mutual_events(catalog, ephemeris, from, to).map_err(|e| e.to_string())?;
        rows.extend(found.iter().chain(&mutual).map(|e| (e.greatest, moon_event_row(catalog, e))));
    }
    rows.sort_by(|a, b| a.0.tdb_seconds_past_j2000().total_cmp(&b.0.tdb_seconds_past_j2000()));
    for (greatest, row) in &mut rows {
        row["radii"] = json!(radii.name());
        let (delta_t_s, error_s) = greatest.delta_t_and_error_s();
        row["delta_t_s"] = json!(delta_t_s);
        row["delta_t_error_s"] = json!(error_s);
    }
    Ok(Found { rows: rows.into_iter().map(|(_, row)| row).collect(), lunar_by_almanacs, path_file_result })
}

/// Accepted heights of a place, metres: from below the deepest sea floor (Challenger Deep, 10.9 km) to the edge of space (Karman line).
const HEIGHT_RANGE_M: std::ops::RangeInclusive<f64> = -12_000.0..=100_000.0;

/// Parses `--at`: `LAT,LON` or `LAT,LON,HEIGHT` in degrees, degrees east and metres.
pub(super) fn parse_place(text: &str) -> Result<GeodeticPosition, String> {
    let invalid = |what: &str| format!("--at {}: {what}; give latitude and east longitude in degrees, such as 78.22,15.65", echo(text));
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let numbers = parsed.map_err(|_| invalid("not numbers separated by commas"))?;
    let (latitude_deg, longitude_deg, height_m) = match numbers[..] {
        [lat, lon] => (lat, lon, 0.0),
        [lat, lon, height] => (lat, lon, height),
        _ => return Err(invalid("not two or three numbers")),
    };
    if !(-90.0..=90.0).contains(&latitude_deg) || !(-360.0..=360.0).contains(&longitude_deg) {
        return Err(invalid("latitude goes from -90 to 90, longitude from -360 to 360"));
    }
    if !HEIGHT_RANGE_M.contains(&height_m) {
        let (lowest, highest) = (HEIGHT_RANGE_M.start(), HEIGHT_RANGE_M.end());
        return Err(invalid(&format!("the height goes from {lowest} to {highest} metres")));
    }
    Ok(GeodeticPosition { latitude_deg, longitude_deg, height_km: height_m / 1000.0 })
}

/// Contacts as a JSON object that maps names to UTC times.
fn utc_times(contacts: &[(&'static str, Instant)]) -> Value {
    Value::Object(contacts.iter().map(|(name, t)| ((*name).to_owned(), json!(t.to_utc_iso()))).collect())
}

/// A solar eclipse as a JSON object. Its `lat` and `lon` are those of the point of greatest eclipse. `observer`: the place of `--at`.
fn solar_row(eclipse: &SolarEclipse, observer: Option<GeodeticPosition>) -> Value {
    let mut row = json!({
        "kind": "solar",
        "type": eclipse.class.name(),
        "central": eclipse.is_central,
        "greatest": eclipse.greatest.to_utc_iso(),
        "greatest_tt": eclipse.greatest.to_tt_iso(),
        "gamma": eclipse.gamma,
        "magnitude": eclipse.magnitude,
        "contacts": utc_times(&eclipse.contacts),
        "lat": eclipse.place.latitude_deg,
        "lon": eclipse.place.longitude_deg,
        "sun_altitude_deg": eclipse.sun_altitude_deg,
        "duration_s": eclipse.duration_s,
        "saros": eclipse.saros,
        "saros_member": eclipse.saros_member,
    });
    if let Some(observer) = observer {
        add_local(&mut row, eclipse.seen_from(observer).as_ref());
    }
    row
}

/// The contacts computed with the Moon's limb profile, as the JSON object `limb`. Of each contact, `later_s` is its time minus the time of the same contact of
/// the mean limb, and `height_km` the height of the silhouette there above the reference sphere of `map`. In a total eclipse, the last bead goes out at C2 and
/// the first one shines at C3; in an annular eclipse, the last mountain leaves the Sun's limb at C2 and the first one reaches it at C3.
fn limb_circumstances(contacts: &[LimbContact], map: &HeightMap) -> Value {
    let contact = |c: &LimbContact| {
        let (time, angle_deg) = (c.time.to_utc_iso(), c.position_angle_deg);
        json!({ "time": time, "later_s": c.delay_s, "position_angle_deg": angle_deg, "height_km": c.height_km })
    };
    let time_of = |name: &str| contacts.iter().find(|c| c.name == name).map_or(Value::Null, |c| json!(c.time.to_utc_iso()));
    let by_name: Map<String, Value> = contacts.iter().map(|c| (c.name.to_owned(), contact(c))).collect();
    json!({ "heights": map.summary(), "contacts": by_name, "last_bead": time_of("C2"), "first_bead": time_of("C3") })
}

/// A lunar eclipse as a JSON object. Its `lat` and `lon` are those of the sub-lunar point at greatest eclipse. `observer`: the place of `--at`.
/// `shadow_enlargement`: name of the rule by which the Earth's shadow is enlarged.
fn lunar_row(eclipse: &LunarEclipse, observer: Option<GeodeticPosition>, shadow_enlargement: &str) -> Value {
    let (penumbral_s, partial_s, total_s) =
        (eclipse.duration_s("P1", "P4"), eclipse.duration_s("U1", "U4"), eclipse.duration_s("U2", "U3"));
    let mut row = json!({
        "kind": "lunar",
        "type": eclipse.class.name(),
        "greatest": eclipse.greatest.to_utc_iso(),
        "greatest_tt": eclipse.greatest.to_tt_iso(),
        "gamma": eclipse.gamma,
        "magnitude": eclipse.umbral_magnitude,
        "penumbral_magnitude": eclipse.penumbral_magnitude,
        "contacts": utc_times(&eclipse.contacts),
        "lat": eclipse.place.latitude_deg,
        "lon": eclipse.place.longitude_deg,
        "duration_s": match eclipse.class {
            LunarType::Total => total_s,
            LunarType::Partial => partial_s,
            LunarType::Penumbral => penumbral_s,
        },
        "durations_s": { "penumbral": penumbral_s, "partial": partial_s, "total": total_s },
        "saros": eclipse.saros,
        "saros_member": eclipse.saros_member,
        "shadow": shadow_enlargement,
    });
    if let Some(observer) = observer {
        add_local(&mut row, Some(&eclipse.seen_from(observer)));
    }
    row
}

/// The body's name; empty if the catalog lacks the body.
fn name_of(catalog: &Catalog, id: NaifId) -> &str {
    catalog.body(id).map_or("", |b| b.name.as_str())
}

/// A transit of Mercury or Venus as a JSON object. `observer`: the place of `--at`.
fn transit_row(catalog: &Catalog, transit: &Transit, observer: Option<GeodeticPosition>) -> Value {
    let mut row = json!({
        "kind": "transit",
        "type": "transit",
        "body": name_of(catalog, transit.planet),
        "greatest": transit.greatest.to_utc_iso(),
        "greatest_tt": transit.greatest.to_tt_iso(),
        "gamma": transit.gamma,
        "magnitude": transit.magnitude,
        "separation_arcsec": transit.separation_arcsec,
        "contacts": utc_times(&transit.contacts),
        "lat": null,
        "lon": null,
        "duration_s": transit.duration_s(),
        "saros": null,
    });
    if let Some(observer) = observer {
        add_local(&mut row, transit.seen_from(observer).as_ref());
    }
    row
}

/// An event of a moon as a JSON object. In a mutual event, its `by` is the moon that occults or eclipses `body`, and so is nearer to the Earth or the Sun.
fn moon_event_row(catalog: &Catalog, event: &MoonEvent) -> Value {
    json!({
        "kind": "moons",
        "type": event.class.name(),
        "body": name_of(catalog, event.moon),
        "planet": name_of(catalog, event.planet),
        "by": event.nearer_moon.map(|id| name_of(catalog, id)),
        "greatest": event.greatest.to_utc_iso(),
        "greatest_tt": event.greatest.to_tt_iso(),
        "gamma": null,
        "magnitude": null,
        "contacts": utc_times(&event.contacts),
        "lat": null,
        "lon": null,
        "duration_s": event.duration_s(),
        "saros": null,
    })
}

/// Writes the centre lines and limits of the central eclipses as a GeoJSON file (RFC 7946).
fn write_eclipse_paths(file: &Path, eclipses: &[SolarEclipse], radii_name: &str, overwrite: bool) -> Result<(), String> {
    let mut features = Vec::new();
    for eclipse in eclipses {
        let Some(path) = eclipse.path() else { continue };
        let centre: Vec<GeodeticPosition> = path.centre_line.iter().map(|(_, place)| *place).collect();
        let instants: Vec<Instant> = path.centre_line.iter().map(|(t, _)| *t).collect();
        // `instants`: one for each place, or empty if the line has no times.
        let mut add = |name: &str, places: &[GeodeticPosition], instants: &[Instant]| {
            let lines = events::cut_at_antimeridian(places);
            if !lines.is_empty() {
                // A time for each vertex, in the order of the coordinates.
                let times: Vec<String> =
                    lines.iter().flatten().filter_map(|v| Some(instant_at(instants, v.fractional_index)?.to_utc_iso())).collect();
                let times = if times.is_empty() { Value::Null } else { json!(times) };
                let coordinates: Vec<Vec<[f64; 2]>> =
                    lines.iter().map(|line| line.iter().map(|v| [v.longitude_deg, v.latitude_deg]).collect()).collect();
                features.push(json!({
                    "type": "Feature",
                    "properties": {
                        "name": name, "type": eclipse.class.name(), "greatest": eclipse.greatest.to_utc_iso(), "saros": eclipse.saros,
                        "radii": radii_name, "times": times,
                    },
                    "geometry": { "type": "MultiLineString", "coordinates": coordinates },
                }));
            }
        };
        add("centre line", &centre, &instants);
        add("northern limit", &path.northern_limit, &[]);
        add("southern limit", &path.southern_limit, &[]);
    }
    if features.is_empty() {
        return Err("--path: no central eclipse of the Sun in this span; widen it".into());
    }
    let collection = json!({ "type": "FeatureCollection", "features": features });
    write_output_file("--path", file, format!("{collection}\n").as_bytes(), overwrite).map_err(|e| e.to_string())
}

/// The instant at a fractional index into the places of a line ([`events::CutVertex::fractional_index`]): interpolated linearly between the `instants` of the
/// places; `None` if the line has no times.
fn instant_at(instants: &[Instant], fractional_index: f64) -> Option<Instant> {
    let earlier = *instants.get(fractional_index as usize)?;
    let later = instants.get(fractional_index as usize + 1).unwrap_or(&earlier);
    Some(earlier.plus_seconds(fractional_index.fract() * (later.tdb_seconds_past_j2000() - earlier.tdb_seconds_past_j2000())))
}

/// Adds the circumstances at a place as the row's field `local`, and the times of the local contacts to the row's `contacts`. `seen`: `None` if the discs do
/// not meet at the place.
fn add_local(row: &mut Value, seen: Option<&LocalCircumstances>) {
    let Some(seen) = seen else {
        row["local"] = json!({ "visible": false });
        return;
    };
    let contact = |c: &events::LocalContact| {
        let time = c.time.to_utc_iso();
        json!({ "time": time, "altitude_deg": c.altitude_deg, "azimuth_deg": c.azimuth_deg, "up": c.is_up() })
    };
    let contacts: Map<String, Value> = seen.contacts.iter().map(|c| (c.name.to_owned(), contact(c))).collect();
    // Only local contacts of a solar eclipse have names with C. The row of a transit keeps the times of the Earth's centre, and the contacts of a lunar eclipse
    // are the same everywhere.
    for c in seen.contacts.iter().filter(|c| c.name.starts_with('C')) {
        row["contacts"][c.name] = json!(c.time.to_utc_iso());
    }
    row["local"] = json!({
        "visible": seen.is_visible,
        "contacts": contacts,
        "maximum": contact(&seen.maximum),
        "magnitude": seen.magnitude,
        "penumbral_magnitude": seen.penumbral_magnitude,
        "obscuration": seen.obscuration,
        "rise": seen.rise.map(Instant::to_utc_iso),
        "set": seen.set.map(Instant::to_utc_iso),
        "duration_s": seen.central_duration_s,
    });
}
