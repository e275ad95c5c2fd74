//! `orrery render`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct RenderArgs {}

pub fn run(_common: &Common, _args: &RenderArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
