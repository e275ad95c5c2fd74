//! `orrery doctor`.
use super::{CliError, Common};

#[derive(clap::Args, Debug, Default)]
pub struct DoctorArgs {}

pub fn run(_common: &Common, _args: &DoctorArgs) -> Result<(), CliError> {
    Err(CliError("not built yet".into()))
}
