//! `orrery explain`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct ExplainArgs {}

pub fn run(_common: &Common, _args: &ExplainArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
