//! Results on standard output.

use super::CliError;
use std::io::{ErrorKind, Write};

/// Writes a result. A reader that has seen enough (`… | head`) is no error.
pub fn put(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(CliError(format!("standard output: {e}"))),
        _ => Ok(()),
    }
}
