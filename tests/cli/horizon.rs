//! A target below the horizon of the place: `render` and `explain` say so in one line.

use super::{orrery, path_text, stderr_text};

/// At noon of this day the Moon was 50.7 degrees below London's horizon (`ephemeris --at`), ten hours later 19 degrees above it. Of the frames of a sequence
/// only some are below.
#[test]
fn a_target_below_the_horizon_is_said_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let view = ["--target", "moon", "--from", "earth", "--at", "51.5,-0.1", "--fov", "1", "--size", "32x32"];
    let draw = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let out = orrery(&[&["render"], &view[..], more, &["-o", path_text(&path)]].concat());
        assert!(out.status.success(), "{}", stderr_text(&out));
        stderr_text(&out)
    };
    let message = "orrery: Moon: 50.7 degrees below the horizon, hidden by the ground of Earth; choose another --time or --at\n";
    assert_eq!(draw("a.png", &["--time", "2024-04-23T12:00:00Z"]), message);
    assert_eq!(draw("b.png", &["--time", "2024-04-23T22:00:00Z"]), "");
    assert_eq!(draw("c%d.png", &["--time", "2024-04-23T12:00:00Z", "--frames", "2", "--step", "10h"]), "");
    let explained = |time: &str| stderr_text(&orrery(&[&["explain"], &view[..], &["--time", time]].concat()));
    assert_eq!((explained("2024-04-23T12:00:00Z").as_str(), explained("2024-04-23T22:00:00Z").as_str()), (message, ""));
}

/// The examples that stand on the ground give a time at which their target is up.
#[test]
fn the_examples_of_the_help_show_their_target() {
    let help = String::from_utf8(orrery(&["render", "--help"]).stdout).expect("UTF-8");
    // Long examples are wrapped.
    let text = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let examples: Vec<&str> = text.split("orrery render ").filter(|example| example.contains("--at ")).collect();
    let of_ground = examples.iter().filter(|example| example.starts_with("--target"));
    let mut tested = 0;
    for example in of_ground {
        let args: Vec<&str> = example.split(" -o ").next().unwrap_or_default().split_whitespace().collect();
        assert!(args.contains(&"--time"), "{example}");
        let options = ["--target", "--from", "--at", "--time"];
        let kept: Vec<&str> = args.windows(2).filter(|pair| options.contains(&pair[0])).flatten().copied().collect();
        let out = orrery(&[&["explain"], &kept[..]].concat());
        assert!(out.status.success() && out.stderr.is_empty(), "{example}: {}", stderr_text(&out));
        tested += 1;
    }
    assert_eq!(tested, 2);
}
