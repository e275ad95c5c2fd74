//! Names of output files, words that shells complete, and modules written to files.

use super::{orrery, path_text, stderr_text};
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
    let section = |verb: &str| script.split(&format!("\n        orrery__subcmd__{verb})\n")).nth(1).expect("a section");
    let line_of =
        |option: &str| section("render").split(&format!("{option})\n")).nth(1).and_then(|rest| rest.lines().next()).expect(option);
    for option in ["--target", "--size", "--time", "--exposure", "--pixels", "--effects", "--layers", "--tone-map", "--up"] {
        assert!(!line_of(option).contains("compgen -f"), "{option}: {}", line_of(option));
    }
    for (option, word) in [("--pixels", "depth"), ("--effects", "-clouds"), ("--layers", "+orbits"), ("--up", "zenith")] {
        assert!(line_of(option).contains(word), "{option}: {}", line_of(option));
    }
    for option in ["--output", "--camera-json", "--kernel", "--surface", "--lunar-heights"] {
        let lines = section("render").split(&format!("{option})\n")).nth(1).and_then(|rest| rest.split(";;").next()).expect(option);
        assert!(lines.contains("compgen -f"), "{option}: {lines}");
    }
    let of_man = section("man").lines().find(|line| line.trim_start().starts_with("opts=")).expect("options");
    assert!(["render", "eclipse", "find"].iter().all(|verb| of_man.split([' ', '"']).any(|word| word == *verb)), "{of_man}");
}

/// On standard output SPIR-V is text, which is no SPIR-V file.
#[test]
fn a_module_is_written_to_a_file_and_as_spirv_in_binary_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let printed = |lang: &str| orrery(&["shader", "emit", "blur", "--lang", lang]).stdout;
    let written = |name: &str, lang: &str, more: &[&str]| {
        let out = orrery(&[&["shader", "emit", "blur", "--lang", lang, "-o", path_text(&path(name))][..], more].concat());
        (out.status.code(), std::fs::read(path(name)).expect("written"), stderr_text(&out))
    };
    let (code, binary, _) = written("blur.spv", "spirv", &[]);
    let words: Vec<u32> = binary.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    assert_eq!((code, words[0], binary.len() % 4), (Some(0), 0x0723_0203, 0));
    let text: String = words.iter().map(|word| format!("{word:08x}\n")).collect();
    assert_eq!(String::from_utf8(printed("spirv")).expect("UTF-8"), text);
    assert_eq!(written("blur.wgsl", "wgsl", &[]).1, printed("wgsl"));
    // Another module's file is kept, unless the user says otherwise.
    let (code, kept, message) = written("blur.wgsl", "msl", &[]);
    assert!(code == Some(1) && kept == printed("wgsl") && message.contains("--overwrite"), "{message}");
    assert_eq!(written("blur.wgsl", "msl", &["--overwrite"]).1, printed("msl"));
}
