fn main() -> std::process::ExitCode {
    name_a_runtime_folder();
    orrery::cli::run()
}

/// Libraries of graphics drivers print a line of their own, several times at each probe, where no variable names the folder of running programs. What they look for in it
/// is a Wayland compositor's socket. The folder that systemd makes for the user is named where it is there; else a place in which nothing can lie: it says without
/// a word that there is no socket, and nobody else can put one there.
#[cfg(all(unix, not(target_os = "macos")))]
fn name_a_runtime_folder() {
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};
    if std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute()) {
        return;
    }
    let own = std::fs::metadata("/proc/self").ok().and_then(|me| {
        let folder = PathBuf::from(format!("/run/user/{}", me.uid()));
        let about = folder.metadata().ok()?;
        (about.is_dir() && about.uid() == me.uid() && about.mode() & 0o077 == 0).then_some(folder)
    });
    // SAFETY: the first thing that the process does: no other thread reads the environment meanwhile.
    unsafe { std::env::set_var("XDG_RUNTIME_DIR", own.as_deref().unwrap_or(Path::new("/dev/null"))) };
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn name_a_runtime_folder() {}
