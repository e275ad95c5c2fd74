//! Names of output files, and words that shells complete.

use super::stderr_text;
use std::process::Command;

/// Other options take such names, too. Without room for a frame number a name is that of one file.
#[cfg(unix)]
#[test]
fn an_image_may_have_a_name_that_is_not_utf8() {
    use std::os::unix::ffi::OsStringExt;
    let folder = tempfile::tempdir().expect("a folder");
    let render = |name: &[u8], more: &[&str]| {
        let path = folder.path().join(std::ffi::OsString::from_vec(name.to_vec()));
        let mut command = Command::new(crate::support::program::path());
        command.args(["render", "--renderer", "software", "--cache"]).arg(crate::support::scratch::program_cache());
        command.args(["--target", "phobos", "--time", "2024-01-01", "--size", "8x8"]).args(more).arg("-o").arg(&path);
        (command.output().expect("starts"), path)
    };
    for (name, more) in [(&b"a\xff.png"[..], &[][..]), (b"b\xff.exr", &[]), (b"c\xff.gif", &["--frames", "2"])] {
        let (out, path) = render(name, more);
        assert!(out.status.success() && path.is_file(), "{path:?}: {}", stderr_text(&out));
    }
    for (name, more, message_part) in
        [(&b"d\xff.bmp"[..], &[][..], "must have the extension"), (b"e\xff.png", &["--frames", "2"], "needs a number")]
    {
        let (out, path) = render(name, more);
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(2) && line.contains(message_part) && !path.exists(), "{path:?}: {line}");
    }
}

/// Without a command the options are those of `view`; a body is no file.
#[test]
fn shells_complete_the_options_of_the_default_command() {
    if !crate::support::program::has_view() {
        return;
    }
    let out = Command::new(crate::support::program::path()).args(["completions", "bash"]).output().expect("starts");
    let script = String::from_utf8(out.stdout).expect("UTF-8");
    let of_program = script.split("\n        orrery)\n").nth(1).and_then(|rest| rest.split("\n        orrery").next()).expect("a section");
    let words = of_program.lines().find(|line| line.trim_start().starts_with("opts=")).expect("options");
    assert!([" --target ", " --time ", " --language ", " --stars "].iter().all(|option| words.contains(option)), "{words}");
    let render = script.split("\n        orrery__subcmd__render)\n").nth(1).or(script.split("\n        orrery__render)\n").nth(1));
    let target = render.expect("a section").split("--target)\n").nth(1).and_then(|rest| rest.lines().next()).expect("the option");
    assert!(!target.contains("compgen -f"), "{target}");
}
