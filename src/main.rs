//! The program: prepares the environment and runs the command line.

fn main() -> std::process::ExitCode {
    set_xdg_runtime_dir();
    orrery::cli::run()
}

/// Sets `XDG_RUNTIME_DIR` if it is not set to an absolute path. Graphics drivers look there for a Wayland socket, and print a line each time if the
/// variable is missing. The value is the folder that systemd creates for the user, if it exists and is private; else `/dev/null`, which contains
/// no socket and in which nobody can create one.
#[cfg(all(unix, not(target_os = "macos")))]
fn set_xdg_runtime_dir() {
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};
    if std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute()) {
        return;
    }
    let private_folder = std::fs::metadata("/proc/self").ok().and_then(|me| {
        let folder = PathBuf::from(format!("/run/user/{}", me.uid()));
        let metadata = folder.metadata().ok()?;
        (metadata.is_dir() && metadata.uid() == me.uid() && metadata.mode() & 0o077 == 0).then_some(folder)
    });
    // SAFETY: this is the first thing that the process does, so no other thread reads the environment.
    unsafe { std::env::set_var("XDG_RUNTIME_DIR", private_folder.as_deref().unwrap_or(Path::new("/dev/null"))) };
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn set_xdg_runtime_dir() {}
