//! Writes to standard output and standard error, for all commands.
//!
//! In: results and messages. Out: text on the two streams. Always: a closed stream never causes a panic; a result then gives the error
//! [`CliError::OutputClosed`], and a message is dropped.

use super::CliError;
use crate::wording::{escape_controls, one_line};
use std::io::{Error, ErrorKind, IsTerminal, Write};

/// Writes a result to standard output.
///
/// # Errors
/// [`CliError::OutputClosed`] if the reader has closed the pipe (`… | head`), else the reason for the failure.
pub(crate) fn print_result(text: &str) -> Result<(), CliError> {
    print_bytes(text.as_bytes())
}

/// As [`print_result`], for bytes.
pub(crate) fn print_bytes(bytes: &[u8]) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|e| stdout_error(&e))
}

/// The error of a command that could not write to standard output.
pub(crate) fn stdout_error(e: &Error) -> CliError {
    match e.kind() {
        ErrorKind::BrokenPipe => CliError::OutputClosed,
        _ => CliError::Failed(format!("standard output: {e}")),
    }
}

/// Writes a message to standard error, `orrery: …`, on one line even if it quotes text with line breaks.
pub(crate) fn print_message(line: &str) {
    print_to_stderr(&format!("orrery: {}\n", one_line(line)));
}

/// Writes several messages, one per line; `orrery: ` precedes the first.
pub(crate) fn print_messages(lines: &str) {
    print_to_stderr(&format!("orrery: {}\n", escape_controls(lines)));
}

/// Writes text to standard error unchanged. A failure is ignored, because a closed stream has no reader.
pub(crate) fn print_to_stderr(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// A progress bar if standard error is a terminal, otherwise a hidden one.
pub(crate) fn progress(steps: u64) -> indicatif::ProgressBar {
    if std::io::stderr().is_terminal() { indicatif::ProgressBar::new(steps) } else { indicatif::ProgressBar::hidden() }
}
