//! `orrery probe`: questions by words or JSON lines come in, the emitted shaders' own answers go out.

use super::output::{put, say};
use super::{CliError, Common};
use crate::probe::{Prober, questions_json, questions_text};
use crate::render::software::{Options, Precision, SoftwareRenderer};
use crate::session::Session;
use serde_json::json;
use std::io::BufRead;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum PrecisionChoice {
    #[default]
    F32,
    F64,
}

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  orrery probe '{\"q\":\"disc-overlap\",\"k\":0.9,\"d\":0.5,\"model\":\"linear\"}'\n  \
    orrery probe --stdin --precision f64 < questions.jsonl\n  \
    orrery probe --questions",
    next_help_heading = "Question"
)]
pub struct ProbeArgs {
    /// One question, a JSON object
    #[arg(required_unless_present_any = ["stdin", "questions"])]
    question: Option<String>,
    /// Read questions as JSON lines and answer one line each (also where the question is -)
    #[arg(long, conflicts_with = "question")]
    stdin: bool,
    /// Print every question with its fields and an example (with --json as one JSON value)
    #[arg(long, conflicts_with_all = ["question", "stdin"])]
    questions: bool,
    /// What the shader's lanes compute in
    #[arg(long, value_enum, default_value = "f32")]
    precision: PrecisionChoice,
    /// Print one JSON value (the answer always is one)
    #[arg(long)]
    json: bool,
}

pub fn run(common: &Common, args: &ProbeArgs) -> Result<(), CliError> {
    if args.questions {
        return put(&if args.json { format!("{:#}\n", questions_json()) } else { questions_text() });
    }
    let session = Session::open(&common.sources(), say)?;
    let precision = match args.precision {
        PrecisionChoice::F32 => Precision::F32,
        PrecisionChoice::F64 => Precision::F64,
    };
    let options = Options { threads: common.threads.unwrap_or(0), precision, ..Options::default() };
    let renderer = SoftwareRenderer::new(options).map_err(|e| CliError::Failed(e.to_string()))?;
    let prober = Prober { session: &session, renderer: &renderer };
    match args.question.as_deref() {
        Some(question) if question != "-" => {
            let answer = prober.answer(question).map_err(CliError::Failed)?;
            put(&format!("{answer}\n"))
        }
        _ => {
            for line in std::io::stdin().lock().split(b'\n') {
                let line = line.map_err(|e| CliError::Failed(format!("standard input: {e}")))?;
                let answer = String::from_utf8(line).map_err(|_| "not UTF-8 text".to_owned()).and_then(|l| prober.answer(l.trim()));
                let reply = match answer {
                    Ok(a) => json!({ "ok": a }),
                    Err(e) => json!({ "error": e }),
                };
                put(&format!("{reply}\n"))?;
            }
            Ok(())
        }
    }
}
