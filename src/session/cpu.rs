//! Measures the CPU time of this process.
//!
//! In: nothing. Out: the CPU time of the process's live threads on Linux, to the nanosecond; `None` elsewhere. The time of an ended thread is not
//! included, so a difference is correct only if no thread ends in between; a session's thread pools live as long as the session.

use std::time::Duration;

/// CPU time of all live threads so far. The calling thread yields first, because only then does the scheduler update that thread's time.
pub fn process_cpu() -> Option<Duration> {
    std::thread::yield_now();
    let mut nanoseconds = 0_u64;
    for task in std::fs::read_dir("/proc/self/task").ok()?.flatten() {
        // A thread may end between listing and reading.
        let Ok(text) = std::fs::read_to_string(task.path().join("schedstat")) else { continue };
        nanoseconds += running_ns(&text)?;
    }
    (nanoseconds > 0).then(|| Duration::from_nanos(nanoseconds))
}

/// The first value of a line `<ns running> <ns waiting> <time slices>`.
fn running_ns(schedstat: &str) -> Option<u64> {
    schedstat.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_scheduler_is_read_or_refused() {
        assert_eq!(running_ns("1234567 89 10\n"), Some(1_234_567));
        assert_eq!(running_ns(""), None);
        assert_eq!(running_ns("run 1 2"), None);
    }
}
