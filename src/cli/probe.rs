//! `orrery probe`: answers queries about single quantities with the emitted shaders, which the software renderer runs.
//!
//! In: a query as a JSON argument, or queries as JSON lines on standard input. Out: the answers as JSON, one per line.

use super::output::{print_message, print_result};
use super::stdin_lines::answer_lines;
use super::{CliError, Common};
use crate::probe::{Prober, queries_json, queries_text};
use crate::render::software::{Options, Precision, SoftwareRenderer};
use crate::session::Session;

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  orrery probe '{\"q\":\"disc-overlap\",\"k\":0.9,\"d\":0.5,\"model\":\"linear\"}'\n  \
    orrery probe --stdin --precision f64 < queries.jsonl\n  \
    orrery probe --questions",
    next_help_heading = "Query"
)]
pub(crate) struct ProbeArgs {
    /// One query, a JSON object
    #[arg(value_name = "QUERY", required_unless_present_any = ["stdin", "questions"])]
    query: Option<String>,
    /// Read queries as JSON lines and print one line for each; the query - does the same
    #[arg(long, conflicts_with = "query")]
    stdin: bool,
    /// List all queries with their fields and an example (with --json as one JSON value)
    #[arg(long, conflicts_with_all = ["query", "stdin"])]
    questions: bool,
    /// Floating-point precision of the shader
    #[arg(long, value_enum, default_value = "f32")]
    precision: Precision,
    /// Accepted for consistency; the output is always JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(common: &Common, args: &ProbeArgs) -> Result<(), CliError> {
    if args.questions {
        return print_result(&if args.json { format!("{:#}\n", queries_json()) } else { queries_text() });
    }
    let session = Session::open(&common.sources(), print_message)?;
    // 0 threads: one per core.
    let options = Options { threads: common.threads.unwrap_or(0), precision: args.precision, ..Options::default() };
    let renderer = SoftwareRenderer::new(options).map_err(|e| CliError::Failed(e.to_string()))?;
    let prober = Prober { session: &session, renderer: &renderer };
    match args.query.as_deref() {
        Some(query) if query != "-" => {
            let answer = prober.answer(query).map_err(|e| CliError::Failed(e.to_string()))?;
            print_result(&format!("{answer}\n"))
        }
        _ => answer_lines(|query| prober.answer(query).map_err(|e| e.to_string())),
    }
}
