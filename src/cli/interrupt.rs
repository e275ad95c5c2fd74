//! Ends the program early at Ctrl+C, when its terminal is closed, or when the system asks, without leaving temporary files behind.
//!
//! In: SIGINT, SIGTERM and SIGHUP; on Windows the console's Ctrl+C, Ctrl+Break and closing. Out: the temporary files are removed, and the process ends as if
//! it had not caught the signal. A shell reports 128 + the number of the signal, 130 after Ctrl+C, and stops its loop, which it would not do after an exit
//! with 130.
//! Always: a signal that is ignored at the start stays ignored, as with `nohup`. A second signal of the same kind ends the process at once.

#[cfg(unix)]
mod system {
    use crate::files::remove_unfinished;
    use std::io::Read;
    use std::os::fd::IntoRawFd;
    use std::sync::atomic::{AtomicI32, Ordering};

    const SIGNALS: [libc::c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];
    /// The pipe by which `on_signal` wakes the thread that ends the process.
    static PIPE: AtomicI32 = AtomicI32::new(-1);

    /// Interrupts any thread at any instruction, so that it must not wait for a lock or allocate memory.
    extern "C" fn on_signal(signal: libc::c_int) {
        let byte = signal as u8;
        // SAFETY: `write` may be called in a signal handler; it reads the one byte that `byte` has.
        unsafe { libc::write(PIPE.load(Ordering::Relaxed), (&raw const byte).cast(), 1) };
    }

    fn catch(signal: libc::c_int) {
        // SAFETY: all fields of `sigaction` are plain numbers and pointers, for which zero is valid.
        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        // SAFETY: a null pointer as the new action changes nothing; the old one is written to `action`.
        let is_known = unsafe { libc::sigaction(signal, std::ptr::null(), &raw mut action) } == 0;
        if !is_known || action.sa_sigaction != libc::SIG_DFL {
            return;
        }
        action.sa_sigaction = on_signal as *const () as libc::sighandler_t;
        // The default action returns with the first signal.
        action.sa_flags = libc::SA_RESTART | libc::SA_RESETHAND;
        // SAFETY: `action` is valid, and its handler calls only functions that a handler may call. A null pointer leaves out the old action.
        unsafe { libc::sigaction(signal, &raw const action, std::ptr::null_mut()) };
    }

    pub(super) fn catch_signals() {
        let Ok((mut reader, writer)) = std::io::pipe() else { return };
        let end_at_signal = move || {
            let mut signal = [0_u8];
            if reader.read_exact(&mut signal).is_ok() {
                remove_unfinished();
                let signal = libc::c_int::from(signal[0]);
                // SAFETY: both accept any number. The signal has its default action again, which ends the process; if it is blocked, `_exit` does.
                unsafe {
                    libc::raise(signal);
                    libc::_exit(128 + signal)
                }
            }
        };
        if std::thread::Builder::new().name("signals".into()).spawn(end_at_signal).is_ok() {
            // Never closed.
            PIPE.store(writer.into_raw_fd(), Ordering::Relaxed);
            SIGNALS.into_iter().for_each(catch);
        }
    }
}

#[cfg(windows)]
mod system {
    use crate::files::remove_unfinished;

    /// Ctrl+Break, a closed console and the end of the user's session; `libc` lacks the constant.
    const SIGBREAK: libc::c_int = 21;
    /// The exit status of a process that does not catch Ctrl+C (STATUS_CONTROL_C_EXIT).
    const CONTROL_C_EXIT: libc::c_int = 0xc000_013a_u32 as libc::c_int;

    /// The C runtime calls this on a thread of its own, so that it may wait for a lock.
    extern "C" fn on_signal(_signal: libc::c_int) {
        remove_unfinished();
        // SAFETY: `_exit` accepts any status and does not return.
        unsafe { libc::_exit(CONTROL_C_EXIT) }
    }

    pub(super) fn catch_signals() {
        for signal in [libc::SIGINT, SIGBREAK] {
            // SAFETY: the handler has the signature that `signal` requires.
            let previous = unsafe { libc::signal(signal, on_signal as *const () as libc::sighandler_t) };
            if previous == libc::SIG_IGN {
                // SAFETY: as above; the signal is ignored again.
                unsafe { libc::signal(signal, libc::SIG_IGN) };
            }
        }
    }
}

#[cfg(not(any(unix, windows)))]
mod system {
    pub(super) fn catch_signals() {}
}

/// Called once, before any work.
pub(super) fn catch_signals() {
    system::catch_signals();
}
