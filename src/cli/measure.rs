//! `orrery measure`: measures speed against accuracy.
//!
//! A *choice* is a setting, such as the number of samples per pixel; its values are its *options* (`crate::measure`). Options of the command line are always
//! called *command-line options* here. In: the choices to measure, or a view in which the qualities are compared. Out: a table, CSV or JSON on standard output;
//! plots as files.

use super::output::{print_message, print_result, progress};
use super::output_file::{check_may_be_written, write_output_file};
use super::view_args::{parse_size, parse_time_option};
use super::{CliError, Common};
use crate::files::check_output_path;
use crate::image::write_png;
use crate::measure::{CHOICES, ChoiceMeasure, Effort, OptionMeasure, SUFFICIENT_LEVELS, measure_view, plot, renderer as measure_renderers};
use crate::scene::request::{Position, Quality, ViewRequest};
use crate::session::Session;
use crate::wording::echo;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const AFTER_HELP: &str = "Examples:
  orrery measure
  orrery measure --short -o trade.png -o trade.svg
  orrery measure --csv > trade.csv
  orrery measure --body saturn --time 2017-05-17T00:00:00Z

A choice is a setting, such as the number of samples per pixel; its values are its options.
Each line is an option: its error against the best that the program can do, its CPU time
as a ratio to that of the choice's most accurate option (median and quartiles of rounds in
which all options take turns), and the qualities that use it.
An option is dominated if another one is clearly better in time or error, and not worse
in the other. A quality uses the cheapest option within its bound: for draft 1 arcsec,
15.9 % of light (a quarter of a stop), 32 levels of 255 in 99.9 % of the pixels; for
standard 0.1 arcsec, 0.5 %, 3 levels. Reference uses the most accurate option.
With --body, the qualities are measured in one view, and the lowest quality is named that
keeps 99.9 % of the pixels within 1 level of the reference.";

/// The command-line options of a view, with which `--choice`, `-o` and `--overwrite` conflict. To list only `body` is not enough, although the others require
/// `body`: clap does not enforce `requires = "body"` if `body` conflicts with an option that is given.
const VIEW_OPTIONS: [&str; 4] = ["body", "time", "distance_radii", "size"];

#[derive(clap::Args, Debug, Default)]
#[command(after_help = AFTER_HELP, next_help_heading = "Measurement")]
pub(crate) struct MeasureArgs {
    /// Small images and few rounds: within half a minute on two cores
    #[arg(long)]
    short: bool,
    /// Only this choice; repeat for several [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',', conflicts_with_all = VIEW_OPTIONS)]
    choice: Vec<String>,
    /// Measure the qualities in a view of this body
    #[arg(long, value_name = "BODY", requires = "time")]
    body: Option<String>,
    /// Time of that view: ISO 8601 UTC, jd_tdb:2460409.262 or now
    #[arg(long, value_name = "TIME", requires = "body", allow_hyphen_values = true)]
    time: Option<String>,
    /// Distance of that view in equatorial radii [default: the disc fills 3/4 of the image height]
    #[arg(long, value_name = "X", requires = "body", allow_negative_numbers = true)]
    distance_radii: Option<f64>,
    /// Size of that view in pixels
    #[arg(long, value_name = "WxH", default_value = "256x256", requires = "body")]
    size: String,
    /// Plot of speed against accuracy, .png or .svg; repeat for both
    #[arg(short, long, value_name = "FILE", conflicts_with_all = VIEW_OPTIONS)]
    output: Vec<PathBuf>,
    /// Replace existing files
    #[arg(long, requires = "output", conflicts_with_all = VIEW_OPTIONS)]
    overwrite: bool,
    /// Print comma-separated values
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(common: &Common, args: &MeasureArgs) -> Result<(), CliError> {
    for path in &args.output {
        plot_format(path)?;
        check_output_path(path)?;
        check_may_be_written("-o", path, args.overwrite)?;
    }
    let known: Vec<&str> = CHOICES.iter().map(|(name, _)| *name).chain(["renderer"]).collect();
    if let Some(unknown) = args.choice.iter().find(|given| !known.iter().any(|name| given.eq_ignore_ascii_case(name))) {
        return Err(CliError::Usage(format!("--choice {}: {}", echo(unknown), crate::wording::suggestion_or_list(unknown, &known))));
    }
    let effort = if args.short { Effort::Short } else { Effort::Full };
    let session = Session::open(&common.sources_for_drawing(), print_message)?;
    if let Some(body) = &args.body {
        return measure_one_view(&session, args, body, effort);
    }
    let is_named = |name: &str| args.choice.iter().any(|given| given.eq_ignore_ascii_case(name));
    let is_chosen = |name: &str| args.choice.is_empty() || is_named(name);
    // One step for each choice, and one for the comparison of renderers.
    let bar = progress(CHOICES.len() as u64 + 1);
    // The renderers are compared first: if the comparison fails, no minutes of other measurements are lost.
    let renderers = if is_chosen("renderer") { measure_renderers(&session, effort)? } else { None };
    bar.inc(1);
    if renderers.is_none() && is_named("renderer") {
        let why = "--choice renderer: no GPU draws here, so that nothing can be compared; `orrery doctor` lists the adapters";
        return Err(CliError::Failed(why.into()));
    }
    let mut choices = Vec::new();
    for (name, measure) in CHOICES {
        if is_chosen(name) {
            choices.push(measure(&session, effort)?);
        }
        bar.inc(1);
    }
    choices.extend(renderers);
    bar.finish_and_clear();
    let plots_written = args.output.iter().try_for_each(|path| write_plot(path, &choices, args.overwrite));
    let text = if args.json {
        format!("{}\n", json!({ "choices": options_of(&choices).map(|(c, o)| option_json(c, o)).collect::<Vec<_>>() }))
    } else if args.csv {
        csv(&choices)
    } else {
        table(&choices)
    };
    // Printed even if a plot could not be written, because the measurement has taken minutes.
    print_result(&text)?;
    plots_written
}

/// Measures the qualities in the view of `--body`, and names the lowest sufficient quality.
fn measure_one_view(session: &Session, args: &MeasureArgs, body: &str, effort: Effort) -> Result<(), CliError> {
    let body = session.catalog().body_named(body).map_err(|e| CliError::Usage(format!("--body: {e}")))?;
    // clap demands the time if the body is given.
    let time = parse_time_option(args.time.as_deref().unwrap_or("now"))?;
    let (width, height) = parse_size(&args.size)?;
    // `towards: None`: seen from the direction of the Earth, or of the Sun if the body is the Earth.
    let position = Position::AboveTarget { towards: None, distance_radii: args.distance_radii };
    let request = ViewRequest { width, height, position, ..ViewRequest::of(body.id, time) };
    request.check().map_err(|e| CliError::Usage(format!("--distance-radii: {e}")))?;
    let measured = measure_view(session, &request, effort)?;
    let choices = std::slice::from_ref(&measured.qualities);
    let sufficient = measured.sufficient.name();
    let text = if args.json {
        format!("{}\n", json!({ "choices": options_of(choices).map(|(c, o)| option_json(c, o)).collect::<Vec<_>>(), "enough": sufficient }))
    } else if args.csv {
        csv(choices)
    } else {
        let within = format!("within {SUFFICIENT_LEVELS} level of the reference in 99.9 % of the pixels");
        format!("{}\n{} at {}: {sufficient} is enough ({within})\n", table(choices), body.name, time.to_utc_iso())
    };
    print_result(&text)
}

/// Every option of the choices, with its choice.
fn options_of(choices: &[ChoiceMeasure]) -> impl Iterator<Item = (&ChoiceMeasure, &OptionMeasure)> {
    choices.iter().flat_map(|c| c.options.iter().map(move |o| (c, o)))
}

fn quality_names(qualities: &[Quality]) -> Vec<&'static str> {
    qualities.iter().map(|q| q.name()).collect()
}

/// The value with four significant digits; further digits are noise.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn option_json(choice: &ChoiceMeasure, option: &OptionMeasure) -> Value {
    let time = option.measurement.relative_time;
    json!({
        "choice": choice.name, "option": option.name, "error": rounded(option.measurement.error), "unit": choice.unit.name(),
        "time_ratio": rounded(time.median), "spread": [rounded(time.low), rounded(time.high)],
        "dominated": option.is_dominated, "default_of": quality_names(&option.default_of),
    })
}

/// The options as CSV, with a header.
fn csv(choices: &[ChoiceMeasure]) -> String {
    let line = |(choice, option): (&ChoiceMeasure, &OptionMeasure)| {
        let time = option.measurement.relative_time;
        format!(
            "{},\"{}\",{},{},{},{},{},{},{}\n",
            choice.name,
            option.name.replace('"', "\"\""),
            rounded(option.measurement.error),
            choice.unit.name(),
            rounded(time.median),
            rounded(time.low),
            rounded(time.high),
            option.is_dominated,
            quality_names(&option.default_of).join(" "),
        )
    };
    let header = "choice,option,error,unit,time_ratio,time_ratio_low,time_ratio_high,dominated,default_of\n";
    header.to_owned() + &options_of(choices).map(line).collect::<String>()
}

/// The options as text, grouped by choice.
fn table(choices: &[ChoiceMeasure]) -> String {
    let mut text = String::new();
    for choice in choices {
        text += &format!("{} ({})\n", choice.name, choice.about);
        for option in &choice.options {
            let time = option.measurement.relative_time;
            let mut notes = quality_names(&option.default_of).join(", ");
            if option.is_dominated {
                notes += if notes.is_empty() { "dominated" } else { "; dominated" };
            }
            let line = format!(
                "  {:<26} {:>10} {:<11} time {:>7} ({} to {})  {notes}",
                option.name,
                rounded(option.measurement.error),
                choice.unit.name(),
                rounded(time.median),
                rounded(time.low),
                rounded(time.high),
            );
            text += &format!("{}\n", line.trim_end());
        }
        for (quality, admissible_option) in choice.defaults_to_change() {
            text += &format!("  by rule, {} should use {admissible_option}\n", quality.name());
        }
    }
    text
}

#[derive(Clone, Copy, PartialEq)]
enum PlotFormat {
    Png,
    Svg,
}

fn plot_format(path: &Path) -> Result<PlotFormat, CliError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(PlotFormat::Png),
        Some("svg") => Ok(PlotFormat::Svg),
        _ => Err(CliError::Usage(format!("-o {}: the name must end in .png or .svg", echo(&path.display().to_string())))),
    }
}

fn write_plot(path: &Path, choices: &[ChoiceMeasure], overwrite: bool) -> Result<(), CliError> {
    let failed = |e: plot::PlotError| CliError::Failed(e.to_string());
    let bytes = match plot_format(path)? {
        PlotFormat::Svg => plot::svg(choices).map_err(failed)?.into_bytes(),
        PlotFormat::Png => {
            let mut bytes = Vec::new();
            let (width, height) = plot::SIZE_PX;
            write_png(&mut bytes, width, height, &plot::pixels(choices).map_err(failed)?, &[])
                .map_err(|e| CliError::Failed(e.to_string()))?;
            bytes
        }
    };
    write_output_file("-o", path, &bytes, overwrite)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::rule::ErrorUnit;

    #[test]
    fn the_help_states_the_bounds_of_the_rule() {
        let help = AFTER_HELP.replace('\n', " ");
        let bounds = |quality: Quality| {
            [ErrorUnit::Arcseconds, ErrorUnit::PercentOfLight, ErrorUnit::Levels].map(|unit| unit.bound(quality).expect("a bound"))
        };
        let [arcsec, percent, levels] = bounds(Quality::Draft);
        let of_draft = format!("for draft {arcsec} arcsec, {percent} % of light (a quarter of a stop), {levels} levels of 255 in 99.9 %");
        let [arcsec, percent, levels] = bounds(Quality::Standard);
        let of_standard = format!("for standard {arcsec} arcsec, {percent} %, {levels} levels.");
        assert!(help.contains(&of_draft) && help.contains(&of_standard), "{of_draft}; {of_standard}: {help}");
        let of_view = format!("keeps 99.9 % of the pixels within {SUFFICIENT_LEVELS} level of the reference.");
        assert!(help.contains(&of_view), "{of_view}: {help}");
    }
}
