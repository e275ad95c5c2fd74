//! `orrery shader`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct ShaderArgs {}

pub fn run(_common: &Common, _args: &ShaderArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
