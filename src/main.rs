//! The program: prepares the environment and runs the command line.

fn main() -> std::process::ExitCode {
    set_xdg_runtime_dir();
    orrery::cli::run()
}

/// Sets `XDG_RUNTIME_DIR` unless it already is an absolute path. (The XDG Base Directory Specification declares relative ones invalid.) Graphics
/// drivers look in this folder for a Wayland socket, and print a warning to standard error if the variable is missing or invalid. The value is the
/// folder that systemd creates for the user, if it exists and only the user may access it; otherwise, or without `/proc`, it is `/dev/null`, in which
/// nobody can create a socket.
#[cfg(all(unix, not(target_os = "macos")))]
fn set_xdg_runtime_dir() {
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};
    if std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute()) {
        return;
    }
    let private_folder = std::fs::metadata("/proc/self").ok().and_then(|own_process| {
        let folder = PathBuf::from(format!("/run/user/{}", own_process.uid()));
        let metadata = folder.metadata().ok()?;
        (metadata.is_dir() && metadata.uid() == own_process.uid() && metadata.mode() & 0o077 == 0).then_some(folder)
    });
    // SAFETY: `main` calls this function first, when the process has no other thread that could read or write the environment.
    unsafe { std::env::set_var("XDG_RUNTIME_DIR", private_folder.as_deref().unwrap_or(Path::new("/dev/null"))) };
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn set_xdg_runtime_dir() {}
