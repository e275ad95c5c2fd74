//! `orrery ephemeris`: prints positions and velocities, apparent places, orientations and what an observer sees (magnitude, size, phase and more) of bodies,
//! minor planets and comets and, for a place on the Earth, azimuth and altitude, or rise, transit and set.
//!
//! In: one query or a range of times as options, or queries as JSON lines on standard input. Out: text, JSON or CSV on standard output. Not here: the rows of
//! tables (`ephemeris_table`).

use super::eclipse::parse_place;
use super::ephemeris_table::{self, Columns, ObserverColumn, OutputFormat};
use super::frames::parse_step;
use super::output::{print_message, print_result};
use super::stdin_lines::answer_lines;
use super::view_args::parse_time_or_now;
use super::{CliError, Common, inputs};
use crate::catalog::small_bodies::NamedTarget;
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::apparent::{apparent_place, sub_points};
use crate::ephemeris::topocentric::Observer;
use crate::ephemeris::{Ephemeris, Source, SourcedState};
use crate::scene::SkyOfEarth;
use crate::session::read_small_bodies;
use crate::time::{Instant, TimeStep};
use crate::wording::{echo, suggestion_or_list};
use clap::Args;
use serde_json::{Value, json};

#[derive(Args, Debug, Default)]
#[command(
    after_help = "Examples:\n  orrery ephemeris --body moon --center earth --time 2024-04-08T18:17:16Z\n  \
    echo '{\"body\":\"jupiter\",\"center\":\"sun\",\"time\":\"jd_tdb:2460409.262\"}' | orrery ephemeris --stdin\n  \
    orrery ephemeris --body saturn --orientation --time 2017-05-17T00:00:00Z\n  \
    orrery ephemeris --body mars --apparent --from 2027-01-01 --to 2027-03-01 --step 1d --csv\n  \
    orrery ephemeris --rise-set --at 48.14,11.58 --time 2026-06-21\n  \
    orrery ephemeris --body venus --observer --from 2026-08-01 --to 2026-11-01 --step 7d\n  \
    orrery ephemeris --body 2P/Encke --quantities position,magnitude,horizon --at 48.14,11.58 --time now\n\n\
    Positions are geometric: km and km/s, ICRF axes. error_km bounds the error of the source; it is null if it is unknown, as for files of --kernel. \
    The source is the coarsest part of the position: of Pluto it is mean, because Pluto's place about its barycentre follows from Charon's mean orbit. With one \
    --time, --apparent and --orientation print JSON. \
    Minor planets and comets of the tables and of --minor-planets have names (pallas, \"2 Pallas\", \"1P/Halley\"), numbers (433) and \
    designations, packed or not (\"C/1995 O1\", K07Tf8A). They follow their osculating orbits without perturbations: their source is mean, \
    and their error unknown. A number that is a NAIF code (2 is Venus' barycentre) is the minor planet's in brackets: (2).\n\n\
    --observer and --quantities print what is seen from the Earth's centre, or from --at: the apparent place of date; the visual magnitude \
    (of planets with their rings, of comets in total, by M1 and K1, which may be magnitudes off; without the air's extinction); the mean \
    magnitude of a square arcsecond of the globe's lit part; the lit part of the disc; the largest diameter; the phase angle; the elongation \
    from the Sun, east (evening, trailing the Sun) or west (morning, leading it); the constellation. Without --quantities, JSON and CSV have \
    all of them, text those that fit into 100 columns.\n\n\
    Azimuth is measured from north through east; altitudes are without refraction. Rise and set are those of the upper limb of the Sun and the Moon, with 34 arcminutes of \
    refraction on the Earth; twilight ends with the Sun's centre at -6, -12 and -18 degrees. The \
    horizon is level at any height: it has no dip.\n\n\
    Dates are Gregorian in all years, also before 1582; year 0000 is 1 BC, -0584 is 585 BC. Before 1972 times are UT1.",
    next_help_heading = "Query"
)]
pub(crate) struct EphemerisArgs {
    /// Body, barycentre, minor planet or comet: its name, such as io, "mars barycenter" or 1P/Halley, its NAIF code, or its designation
    #[arg(long, required_unless_present_any = ["stdin", "rise_set"])]
    body: Option<String>,
    /// Origin: the body or barycentre that positions are relative to
    #[arg(long, required_unless_present_any = ["stdin", "apparent", "orientation", "observer", "quantities", "at", "rise_set"])]
    center: Option<String>,
    /// Time: ISO 8601 UTC, jd_tdb:2460409.262 or now
    #[arg(long, required_unless_present_any = ["stdin", "from"], allow_hyphen_values = true)]
    time: Option<String>,
    /// Start of a table
    #[arg(long, value_name = "T", allow_hyphen_values = true, requires_all = ["to", "step"], conflicts_with_all = ["time", "stdin", "rise_set"])]
    from: Option<String>,
    // clap does not enforce `requires` if the required option conflicts with an option that is given. Each option that requires `from` therefore repeats the
    // conflicts of `from`.
    /// End of a table, included if a step falls on it
    #[arg(long, value_name = "T", allow_hyphen_values = true, requires = "from", conflicts_with_all = ["time", "stdin", "rise_set"])]
    to: Option<String>,
    /// Time between rows: 60s, 10m, 6h, 1d. Leap seconds count, but days keep the time of day
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "from", conflicts_with_all = ["time", "stdin", "rise_set"])]
    step: Option<String>,
    /// Source of positions [default: the best one that covers the time]
    #[arg(long, value_enum)]
    source: Option<Source>,
    /// Read queries as JSON lines {"body","center","time","source"} and print one line for each
    #[arg(long, conflicts_with_all = ["body", "center", "time"])]
    stdin: bool,
    /// Apparent place from the Earth's centre: RA and Dec with light time, deflection and aberration
    #[arg(long, conflicts_with_all = ["orientation", "source"])]
    apparent: bool,
    /// Pole, prime meridian, sub-observer and sub-solar points, with light time to --center (default: the Earth)
    #[arg(long, conflicts_with = "source")]
    orientation: bool,
    /// What an observer sees: magnitude, size, phase, elongation and more, from the Earth's centre or from --at
    #[arg(long, conflicts_with_all = ["center", "apparent", "orientation", "source", "rise_set"])]
    observer: bool,
    /// Columns of --observer, which this option includes, in this order
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',', conflicts_with_all = ["center", "apparent", "orientation", "source", "rise_set"])]
    quantities: Vec<ObserverColumn>,
    /// Azimuth and altitude from a place on the Earth: latitude, east longitude (degrees), height (metres)
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", allow_hyphen_values = true, conflicts_with_all = ["center", "apparent", "orientation", "source", "stdin"])]
    at: Option<String>,
    /// Each rise, transit and set at a place in the 24 hours after --time; twilights too for the Sun, the default body
    #[arg(long, requires = "at", conflicts_with_all = ["center", "apparent", "orientation", "source", "stdin"])]
    rise_set: bool,
    /// Print a table as CSV, angles in degrees
    #[arg(long, requires = "from", conflicts_with_all = ["json", "time", "stdin", "rise_set"])]
    csv: bool,
    /// Print one JSON value
    #[arg(long)]
    json: bool,
}

/// The quantity that a query requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    /// The state vector: geometric position and velocity.
    State,
    /// The apparent place.
    Apparent,
    /// Pole, prime meridian, sub-observer and sub-solar points.
    Orientation,
    /// What an observer on the Earth sees.
    Observed,
}

impl EphemerisArgs {
    fn quantity(&self) -> Quantity {
        match (self.apparent, self.orientation) {
            (true, _) => Quantity::Apparent,
            (_, true) => Quantity::Orientation,
            _ if self.observer || !self.quantities.is_empty() => Quantity::Observed,
            _ => Quantity::State,
        }
    }

    /// The columns of [`Quantity::Observed`].
    fn observer_columns(&self, is_text: bool) -> Vec<ObserverColumn> {
        match (self.quantities.is_empty(), is_text) {
            (false, _) => self.quantities.clone(),
            (true, true) => ObserverColumn::of_text(self.at.is_some()),
            (true, false) => ObserverColumn::all(self.at.is_some()),
        }
    }
}

/// The instants of which the options ask.
#[derive(Clone, Copy, Debug)]
enum Times {
    One(Instant),
    Steps { from: Instant, to: Instant, step: TimeStep },
}

/// The words of the options, parsed: bodies, times and place. Not of `--stdin`, whose lines have words of their own.
struct Words {
    /// Without `--body` the Sun.
    body: NamedTarget,
    center: Option<NaifId>,
    times: Times,
    place: Option<Observer>,
}

impl Words {
    /// # Errors
    /// The option, and what is wrong with its word.
    fn parse(catalog: &Catalog, args: &EphemerisArgs) -> Result<Self, CliError> {
        let body = match &args.body {
            Some(name) => target(catalog, "--body", name).map_err(CliError::Usage)?,
            None => NamedTarget::Body(NaifId::SUN),
        };
        let center = args.center.as_deref().map(|name| body_id(catalog, "--center", name)).transpose().map_err(CliError::Usage)?;
        if args.apparent && center.is_some_and(|center| center != NaifId::EARTH) {
            let why = "--center: an apparent place is always seen from the Earth's centre; omit this option";
            return Err(CliError::Usage(why.into()));
        }
        let time_of = |option: &str, text: &Option<String>| -> Result<Instant, CliError> {
            let text = text.as_deref().ok_or_else(|| CliError::Usage(format!("{option} is missing")))?;
            parse_time(text).map_err(|e| CliError::Usage(format!("{option}: {e}")))
        };
        let times = match &args.step {
            Some(step) => Times::Steps { from: time_of("--from", &args.from)?, to: time_of("--to", &args.to)?, step: parse_step(step)? },
            None => Times::One(time_of("--time", &args.time)?),
        };
        let place = args.at.as_deref().map(parse_place).transpose().map_err(CliError::Usage)?.map(|geodetic| Observer {
            body: NaifId::EARTH,
            lat_graphic_deg: geodetic.latitude_deg,
            lon_east_deg: geodetic.longitude_deg,
            height_km: geodetic.height_km,
        });
        Ok(Self { body, center, times, place })
    }
}

pub(crate) fn run(common: &Common, args: &EphemerisArgs) -> Result<(), CliError> {
    let catalog = inputs::catalog(common)?.with_small_bodies(read_small_bodies(common.minor_planets.as_deref())?);
    if args.at.is_none() && args.quantities.contains(&ObserverColumn::Horizon) {
        return Err(CliError::Usage("--quantities: horizon needs a place; add --at LAT,LON".into()));
    }
    // Before the kernel is read, whose errors are failures.
    let words = if args.stdin { None } else { Some(Words::parse(&catalog, args)?) };
    let ephemeris = inputs::ephemeris(common, &catalog)?;
    let Some(words) = words else { return answer_stdin(&catalog, &ephemeris, args) };
    let (source, quantity) = (args.source, args.quantity());
    let time = match words.times {
        Times::One(time) if words.place.is_none() && quantity != Quantity::Observed => time,
        _ => return print_result(&table_or_rise_and_set(&catalog, &ephemeris, args, &words)?),
    };
    let query = Query { name: args.body.clone().unwrap_or_default(), body: words.body, center: words.center, time, source };
    if quantity != Quantity::State {
        let value = query.apparent_or_orientation(&catalog, &ephemeris, quantity).map_err(CliError::Failed)?;
        return print_result(&if args.json { format!("{value}\n") } else { format!("{value:#}\n") });
    }
    let answer = query.state(&ephemeris).map_err(CliError::Failed)?;
    if let Some(requested) = source.filter(|requested| *requested != answer.source) {
        let [requested, found] = [requested, answer.source].map(source_name);
        print_message(&format!(
            "--source {requested}: a part of this position has no such source; the least accurate source used is {found}"
        ));
    }
    let text = if args.json { format!("{}\n", as_json(&answer)) } else { as_text(&answer) };
    print_result(&text)
}

/// The output for `--from`, `--at` or `--observer`: a table of positions, apparent places, orientations, azimuth and altitude, or what an observer sees, with
/// one row per instant; with `--rise-set` rise, transit, set and twilights of one day.
fn table_or_rise_and_set(catalog: &Catalog, ephemeris: &Ephemeris, args: &EphemerisArgs, words: &Words) -> Result<String, CliError> {
    let Words { body, center, times, place } = words;
    if let (Some(place), Times::One(start), true) = (*place, *times, args.rise_set) {
        let events = ephemeris_table::rise_and_set(catalog, ephemeris, body, place, start).map_err(|e| CliError::Failed(e.to_string()))?;
        return Ok(if args.json { format!("{events}\n") } else { ephemeris_table::rise_and_set_text(&events) });
    }
    let format = match (args.csv, args.json) {
        (true, _) => OutputFormat::Csv,
        (_, true) => OutputFormat::Json,
        _ => OutputFormat::Text,
    };
    let (sky, observer_columns) = (SkyOfEarth::new(catalog, ephemeris, *place), args.observer_columns(format == OutputFormat::Text));
    let columns = match (*place, args.quantity()) {
        (_, Quantity::Observed) => Columns::Observer { sky: &sky, columns: &observer_columns },
        (Some(place), _) => Columns::Horizontal { place },
        (_, Quantity::State) => {
            let missing = || CliError::Usage("--center is missing: the body that positions are relative to".into());
            Columns::State { center: center.ok_or_else(missing)?, source: args.source }
        }
        (_, Quantity::Apparent) => Columns::Apparent,
        (_, Quantity::Orientation) => Columns::Orientation { observer: center.unwrap_or(NaifId::EARTH) },
    };
    let times = match *times {
        Times::Steps { from, to, step } => ephemeris_table::instants(from, to, step).map_err(CliError::Usage)?,
        Times::One(time) => vec![time],
    };
    ephemeris_table::table(catalog, ephemeris, body, columns, &times, format).map_err(CliError::Failed)
}

/// A query for one instant.
struct Query {
    /// The body as the user wrote it, for messages.
    name: String,
    body: NamedTarget,
    /// Of a position: its origin, always present. Of an apparent place or an orientation: the observer.
    center: Option<NaifId>,
    time: Instant,
    /// The source of a position; `None`: the best one that covers the time.
    source: Option<Source>,
}

impl Query {
    /// The geometric position and velocity.
    fn state(&self, ephemeris: &Ephemeris) -> Result<SourcedState, String> {
        let center = self.center.ok_or("center is missing: the body that positions are relative to")?;
        ephemeris.target_state((&self.body).into(), center, self.time, self.source).map_err(|e| e.to_string())
    }

    /// The apparent place or the orientation as JSON. An orientation is seen from the query's centre, or from the Earth if the query has none.
    fn apparent_or_orientation(&self, catalog: &Catalog, ephemeris: &Ephemeris, quantity: Quantity) -> Result<Value, String> {
        let observer = self.center.unwrap_or(NaifId::EARTH);
        let value = if quantity == Quantity::Apparent {
            if observer != NaifId::EARTH {
                return Err("center: an apparent place is always seen from the Earth's centre; omit this field".into());
            }
            serde_json::to_value(apparent_place(ephemeris, &self.body, self.time).map_err(|e| e.to_string())?)
        } else {
            let body =
                ephemeris_table::body_with_orientation(catalog, &self.body).map_err(|why| format!("body `{}`: {why}", echo(&self.name)))?;
            serde_json::to_value(sub_points(ephemeris, body, observer, self.time).map_err(|e| e.to_string())?)
        };
        value.map_err(|e| e.to_string())
    }

    /// What an observer at the Earth's centre sees, as JSON.
    fn observed(&self, sky: &SkyOfEarth<'_>, columns: &[ObserverColumn]) -> Result<Value, String> {
        if self.center.is_some_and(|center| center != NaifId::EARTH) {
            return Err("center: the observer is at the Earth's centre; omit this field".into());
        }
        ephemeris_table::observed_as_json(sky, &self.body, columns, self.time)
    }

    /// Parses a line of standard input; `source` is the default for lines without a source.
    fn from_json(catalog: &Catalog, line: &str, source: Option<Source>, quantity: Quantity) -> Result<Self, String> {
        let value = crate::json::value(line).map_err(|e| if e.is_data() { e.to_string() } else { format!("not a JSON object: {e}") })?;
        let object = value.as_object().ok_or("not a JSON object; give {\"body\",\"center\",\"time\",\"source\"}")?;
        let known = ["body", "center", "time", "source"];
        if let Some(unknown) = object.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(format!("field `{}` is not known; {}", echo(unknown), suggestion_or_list(unknown, &known)));
        }
        let text = |name: &str| match object.get(name) {
            Some(Value::String(s)) => Ok(s.clone()),
            Some(_) => Err(format!("field {name:?} is not a string")),
            None => Err(format!("field {name:?} is missing")),
        };
        let source = match object.get("source") {
            None | Some(Value::Null) => source,
            // Accepted with every quantity, so that the same lines can be sent for each. Only a position uses it: an apparent place and an orientation always
            // come from the best source.
            Some(s) => Some(
                serde_json::from_value(s.clone())
                    .map_err(|_| format!("source {} is not known; one of mean, series, kernel", echo(&s.to_string())))?,
            ),
        };
        // Only a position needs a centre.
        let center = if quantity == Quantity::State || object.contains_key("center") { Some(text("center")?) } else { None };
        let (name, time) = (text("body")?, text("time")?);
        let body = target(catalog, "body", &name)?;
        let center = center.map(|center| body_id(catalog, "center", &center)).transpose()?;
        Ok(Self { name, body, center, time: parse_time(&time)?, source })
    }
}

/// The body or barycentre with this name or NAIF code. `field`: the option or JSON field that an error names.
fn body_id(catalog: &Catalog, field: &str, name: &str) -> Result<NaifId, String> {
    catalog.body_or_barycenter(name).map_err(|e| format!("{field}: {e}"))
}

/// The body, barycentre, minor planet or comet that is called so. `field`: the option or JSON field that an error names.
fn target(catalog: &Catalog, field: &str, name: &str) -> Result<NamedTarget, String> {
    catalog.target_named(name).map_err(|e| format!("{field}: {e}"))
}

/// As [`parse_time_or_now`], with the error as text.
fn parse_time(text: &str) -> Result<Instant, String> {
    parse_time_or_now(text).map_err(|e| e.to_string())
}

/// Answers each line of standard input.
fn answer_stdin(catalog: &Catalog, ephemeris: &Ephemeris, args: &EphemerisArgs) -> Result<(), CliError> {
    let (quantity, is_text) = (args.quantity(), false);
    let (sky, columns) = (SkyOfEarth::new(catalog, ephemeris, None), args.observer_columns(is_text));
    answer_lines(|line| {
        let query = Query::from_json(catalog, line, args.source, quantity)?;
        match quantity {
            Quantity::State => query.state(ephemeris).map(|answer| as_json(&answer)),
            Quantity::Observed => query.observed(&sky, &columns),
            Quantity::Apparent | Quantity::Orientation => query.apparent_or_orientation(catalog, ephemeris, quantity),
        }
    })
}

fn as_json(answer: &SourcedState) -> Value {
    json!({
        "pos_km": answer.state.pos_km.to_array(),
        "vel_km_s": answer.state.vel_km_s.to_array(),
        "source": answer.source,
        "error_km": answer.error_km,
    })
}

/// The name of a source, as `--source` has it.
fn source_name(source: Source) -> String {
    json!(source).as_str().unwrap_or_default().to_owned()
}

fn as_text(answer: &SourcedState) -> String {
    let [x, y, z] = answer.state.pos_km.to_array();
    let [vx, vy, vz] = answer.state.vel_km_s.to_array();
    let error = if answer.error_km.is_finite() { format!("within {:.3} km", answer.error_km) } else { "error unknown".to_owned() };
    format!(
        "position  {x:.6} {y:.6} {z:.6} km\nvelocity  {vx:.9} {vy:.9} {vz:.9} km/s\ndistance  {:.6} km\nsource    {}, {error}\n",
        answer.state.pos_km.length(),
        source_name(answer.source)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer_to(line: &str) -> Result<SourcedState, String> {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped kernel");
        let default_source = None;
        Query::from_json(&catalog, line, default_source, Quantity::State)?.state(&ephemeris)
    }

    #[test]
    fn valid_lines_are_answered_and_invalid_ones_get_an_error() {
        let good = answer_to(r#"{"body":"Moon","center":"earth","time":"2024-04-08T18:17:16Z"}"#).expect("an answer");
        // The Moon was near its perigee, some 359 800 km away.
        assert!((good.state.pos_km.length() - 359_800.0).abs() < 500.0, "{}", good.state.pos_km.length());
        for (line, error_part) in [
            ("", "JSON"),
            ("[1]", "JSON object"),
            (r#"{"body":"moon","center":"earth"}"#, "\"time\" is missing"),
            (r#"{"body":7,"center":"earth","time":"now"}"#, "\"body\" is not a string"),
            (r#"{"body":"nibiru","center":"earth","time":"now"}"#, "nibiru"),
            (r#"{"body":"moon","center":"earth","time":"soon"}"#, "soon"),
            (r#"{"body":"moon","center":"earth","time":"now","source":"gut"}"#, "gut"),
            (r#"{"body":"moon","center":"earth","time":"now","sauce":"mean"}"#, "sauce"),
        ] {
            let error = answer_to(line).expect_err(line);
            assert!(error.contains(error_part) && !error.contains('\n'), "{line}: {error}");
        }
    }

    /// A centre that does not apply is refused, because ignoring it would answer another question. A source that does not apply is ignored.
    #[test]
    fn centres_that_a_quantity_cannot_use_are_refused() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped kernel");
        let answer = |fields: &str, quantity: Quantity| {
            let line = format!(r#"{{"body":"mars","time":"2024-04-08"{fields}}}"#);
            let default_source = None;
            Query::from_json(&catalog, &line, default_source, quantity)?.apparent_or_orientation(&catalog, &ephemeris, quantity)
        };
        for quantity in [Quantity::Apparent, Quantity::Orientation] {
            let plain = answer("", quantity).expect("an answer");
            for source in ["null", "\"mean\""] {
                assert_eq!(answer(&format!(r#","center":"earth","source":{source}"#), quantity).as_ref(), Ok(&plain));
            }
            assert!(answer(r#","source":"gut""#, quantity).expect_err("refused").starts_with("source"));
            assert!(answer(r#","center":"""#, quantity).expect_err("refused").starts_with("center"));
        }
        assert!(answer(r#","center":"jupiter""#, Quantity::Apparent).expect_err("refused").starts_with("center"));
        let from_jupiter = answer(r#","center":"jupiter""#, Quantity::Orientation).expect("an answer");
        assert_ne!(from_jupiter, answer("", Quantity::Orientation).expect("an answer"));
    }
}
