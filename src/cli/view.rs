//! `orrery view`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct ViewArgs {}

pub fn run(_common: &Common, _args: &ViewArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
