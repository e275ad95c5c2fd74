//! `orrery ephemeris`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct EphemerisArgs {}

pub fn run(_common: &Common, _args: &EphemerisArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
