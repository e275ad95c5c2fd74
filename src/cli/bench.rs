//! `orrery bench`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct BenchArgs {}

pub fn run(_common: &Common, _args: &BenchArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
