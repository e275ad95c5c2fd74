//! `orrery stability`: runs sweeps, each a series of extreme views, and checks that the largest error of each is within its bound.
//!
//! In: names of sweeps, number and seed of the random views. Out: a report per sweep, as text or JSON; the command fails if an error exceeds its bound.

use super::output::{print_message, print_result, progress};
use super::{CliError, Common};
use crate::measure::Effort;
use crate::session::Session;
use crate::stability::{InjectedFaults, SWEEPS, Sweep, SweepReport, SweepSetup, run as run_sweep};
use crate::wording::{echo, suggestion_or_list};
use serde_json::{Value, json};

const AFTER_HELP: &str = "Examples:
  orrery stability --short
  orrery stability --sweep distance --sweep shadows
  orrery stability --sweep needs-display --views 500 --seed 7 --json

Each sweep draws, probes or places bodies where arithmetic and decisions are most likely
to break, and compares f32 with f64, pairs of images that should be equal, or positions
with an independent computation. The output of a sweep: the number of cases, the largest
error with its bound, the case with that error, and the first difference in it (a named
value of the module, a decision or a pixel). The exit status is 1 if an error exceeds its
bound. --short runs fewer cases, within two minutes on two cores. With --renderer gpu the
GPU draws the f32 images; sweeps for which its arithmetic is less precise have separate
bounds.";

#[derive(clap::Args, Debug, Default)]
#[command(after_help = AFTER_HELP, next_help_heading = "Sweeps")]
pub(crate) struct StabilityArgs {
    /// Sweep to run; repeat or separate by commas [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    sweep: Vec<String>,
    /// Fewer cases: within two minutes on two cores
    #[arg(long)]
    short: bool,
    /// Random views of `needs-display` and `needs-linear` [default: 3000, or 160 with --short]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    views: Option<u32>,
    /// Seed of the random cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(common: &Common, args: &StabilityArgs) -> Result<(), CliError> {
    let names: Vec<&str> = SWEEPS.iter().map(|s| s.name).collect();
    if let Some(unknown) = args.sweep.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(CliError::Usage(format!("--sweep {}: {}", echo(unknown), suggestion_or_list(unknown, &names))));
    }
    let chosen: Vec<&Sweep> = SWEEPS.iter().filter(|s| args.sweep.is_empty() || args.sweep.iter().any(|n| n == s.name)).collect();
    let session = Session::open(&common.sources(), print_message)?;
    let effort = if args.short { Effort::Short } else { Effort::Full };
    let setup = SweepSetup::new(&session, effort, args.seed, InjectedFaults::default())?.with_views(args.views.map(|n| n as usize));
    let bar = progress(chosen.len() as u64);
    let mut reports = Vec::new();
    for sweep in chosen {
        let report = run_sweep(sweep, &setup)?;
        if !args.json {
            bar.suspend(|| print_result(&report_text(&report)))?;
        }
        bar.inc(1);
        reports.push(report);
    }
    bar.finish_and_clear();
    let failed = reports.iter().filter(|r| r.has_failed()).count();
    if args.json {
        print_result(&format!("{}\n", json!({ "sweeps": reports.iter().map(report_json).collect::<Vec<_>>(), "failed": failed })))?;
    } else {
        print_result(&format!("{} of {} sweeps kept their bounds; seed {}\n", reports.len() - failed, reports.len(), args.seed))?;
    }
    match failed {
        0 => Ok(()),
        n => Err(CliError::Failed(format!("{n} of {} sweeps broke their bound", reports.len()))),
    }
}

/// A sweep's report as JSON. JSON has no infinity or NaN, so these become null.
fn report_json(report: &SweepReport) -> Value {
    json!({
        "name": report.name, "cases": report.result.cases, "worst": report.result.worst, "bound": report.bound, "unit": report.unit,
        "where": report.result.worst_case, "cause": report.result.cause,
    })
}

/// A sweep's report as lines of text.
fn report_text(report: &SweepReport) -> String {
    let verdict = if report.has_failed() { "BROKEN" } else { "kept" };
    let result = &report.result;
    format!(
        "{:<15} {verdict:<6} {:>6} cases, worst {:.3e} of {:.3e} {} ({})\n    at {}\n    {}\n",
        report.name, result.cases, result.worst, report.bound, report.unit, report.reason, result.worst_case, result.cause,
    )
}
