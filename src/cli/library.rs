//! `orrery library`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct LibraryArgs {}

pub fn run(_common: &Common, _args: &LibraryArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
