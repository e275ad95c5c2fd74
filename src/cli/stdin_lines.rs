//! Queries as lines of standard input, for the commands with `--stdin`.
//!
//! In: lines. Out: for each of them a line on standard output, `{"ok": …}` or `{"error": …}`. Always: after an invalid line the other lines are answered.

use super::CliError;
use super::output::print_result;
use crate::wording::without_byte_order_mark;
use serde_json::{Value, json};
use std::io::BufRead;

/// Answers each line of standard input. `answer` gets the line without the white space around it.
pub(super) fn answer_lines(answer: impl Fn(&str) -> Result<Value, String>) -> Result<(), CliError> {
    for (index, line) in std::io::stdin().lock().split(b'\n').enumerate() {
        let line = line.map_err(|e| CliError::Failed(format!("standard input: {e}")))?;
        let answered = String::from_utf8(line).map_err(|_| "not UTF-8 text".to_owned()).and_then(|line| {
            let query = if index == 0 { without_byte_order_mark(&line) } else { &line };
            answer(query.trim())
        });
        let reply = match answered {
            Ok(answer) => json!({ "ok": answer }),
            Err(e) => json!({ "error": e }),
        };
        print_result(&format!("{reply}\n"))?;
    }
    Ok(())
}
