//! `orrery render`: one image, or a run of frames, to files or a video stream.
use super::view_words::ViewWords;
use super::{CliError, Common};
use crate::image;
use crate::scene::legend::legend;
use crate::scene::request::{CAMERA_FILE_HELP, Purpose, ViewRequest};
use crate::session::{DrawnBy, Session, Stage, Stages, is_exr, milliseconds, process_cpu, write_picture};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant as Moment};

const EXAMPLES: &str = "Examples:
  orrery render --target earth --time 2024-04-08T18:17:16Z -o earth.png
  orrery render --target moon --from earth --at 51.5,-0.1 --fov 1 --up zenith -o moon.png
  orrery render --target jupiter --distance-radii 60 --layers +orbits -o orbits.png
  orrery render --target jupiter --distance-radii 40 --frames 240 --step 10m -o out-%05d.png
  orrery render --target io --frames 240 --step 60s -o - | ffmpeg -i - io.mp4

A run of frames goes on where it stopped: files that exist are left alone. With
--quality draft each pixel has 1 sample and maps 1 tap; standard 4 samples and
up to 8 taps; reference 4 samples and up to 16 taps.
";

/// Text under the options: examples and the camera file.
fn after_help() -> String {
    format!("{EXAMPLES}\n{CAMERA_FILE_HELP}")
}

#[derive(clap::Args, Debug, Default)]
#[command(after_help = after_help())]
pub struct RenderArgs {
    #[command(flatten)]
    view: ViewWords,
    /// File to write: .png, .exr (linear), a pattern as out-%05d.png, or - for a y4m stream
    #[arg(short, long, value_name = "FILE")]
    output: Option<String>,
    /// How many frames
    #[arg(long, value_name = "N", default_value_t = 1)]
    frames: u32,
    /// Time between frames: 60s, 10m, 6h, 1d; may be negative
    #[arg(long, value_name = "TIME", default_value = "60s", allow_hyphen_values = true)]
    step: String,
    /// Render every n-th frame from i (0 to n-1), so that several machines share a run
    #[arg(long, value_name = "I/N")]
    shard: Option<String>,
    /// Frames a second of a y4m stream
    #[arg(long, value_name = "N", default_value_t = 25)]
    rate: u32,
    /// Print JSON timings per stage, and when the first frame was there (to standard error when the picture goes to standard output)
    #[arg(long)]
    time_report: bool,
}

/// Where frames go.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Output {
    One(PathBuf),
    /// Text before and after the frame number, and its width.
    Run(String, usize, String),
    Stream,
}

fn output(text: Option<&str>, frames: u32) -> Result<Output, CliError> {
    let Some(text) = text else { return Err(CliError("name the file to write: -o out.png (or .exr, out-%05d.png, -)".into())) };
    if text == "-" {
        return Ok(Output::Stream);
    }
    if !text.to_ascii_lowercase().ends_with(".png") && !text.to_ascii_lowercase().ends_with(".exr") {
        return Err(CliError(format!("-o {text}: the name must end in .png or .exr")));
    }
    match text.split_once('%') {
        None if frames > 1 => Err(CliError(format!("-o {text}: for {frames} frames the name needs a number, as out-%05d.png"))),
        None => Ok(Output::One(text.into())),
        Some((before, rest)) => {
            let digits = rest.split_once('d').and_then(|(width, after)| {
                let width = if width.is_empty() { 0 } else { width.strip_prefix('0')?.parse().ok().filter(|w| *w <= 12)? };
                (!after.contains('%')).then(|| Output::Run(before.to_owned(), width, after.to_owned()))
            });
            digits.ok_or_else(|| CliError(format!("-o {text}: write the frame number as %d or %05d, once")))
        }
    }
}

impl Output {
    fn path(&self, frame: u32) -> Option<PathBuf> {
        match self {
            Self::One(path) => Some(path.clone()),
            Self::Run(before, width, after) => Some(format!("{before}{frame:0width$}{after}").into()),
            Self::Stream => None,
        }
    }
}

/// Seconds in `60s`, `10m`, `6h`, `1d` or a bare number of seconds.
fn step_seconds(text: &str) -> Result<f64, CliError> {
    let (number, unit) = text.split_at(text.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len());
    let scale = match unit {
        "" | "s" => Some(1.0),
        "m" | "min" => Some(60.0),
        "h" => Some(3600.0),
        "d" => Some(86_400.0),
        _ => None,
    };
    let seconds = scale.zip(number.trim().parse::<f64>().ok()).map(|(s, n)| s * n).filter(|s| s.is_finite());
    seconds.ok_or_else(|| CliError(format!("--step {text}: write a number with s, m, h or d, as 60s")))
}

/// `i/n` with 0 <= i < n.
fn shard(text: Option<&str>) -> Result<(u32, u32), CliError> {
    let Some(text) = text else { return Ok((0, 1)) };
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    parts.filter(|(i, n)| i < n).ok_or_else(|| CliError(format!("--shard {text}: write i/n with i from 0 to n-1, as 0/4")))
}

pub fn run(common: &Common, args: &RenderArgs) -> Result<(), CliError> {
    let begun = Moment::now();
    let mut first_frame = None;
    let output = output(args.output.as_deref(), args.frames)?;
    let step_s = step_seconds(&args.step)?;
    let (first, stride) = shard(args.shard.as_deref())?;
    if output == Output::Stream && stride > 1 {
        return Err(CliError("--shard needs files: frames of one stream come in order from one run".into()));
    }
    let session = Session::open(&common.sources_to_draw(), |line| eprintln!("orrery: {line}"))?;
    let session = if args.time_report { session.counting_cpu() } else { session };
    let request = ViewRequest { quality: common.quality.of_request(), ..args.view.request(session.catalog())? };
    let fineness = common.quality.fineness();
    let mut written = Stages::default();
    let mut stream = std::io::BufWriter::new(std::io::stdout());
    let bar = progress(args.frames);
    let mut drawn_frames = 0_u32;
    let mut drawn_by = None;
    for number in (first..args.frames).step_by(stride as usize) {
        let path = output.path(number);
        if args.frames > 1 && path.as_ref().is_some_and(|p| p.exists()) {
            bar.inc(1);
            continue;
        }
        let request = ViewRequest { time: request.time.plus_seconds(f64::from(number) * step_s), ..request.clone() };
        let keep_hdr = path.as_ref().is_some_and(|p| is_exr(p));
        let request = ViewRequest { purpose: Purpose::of_file(keep_hdr), ..request };
        let drawn = session.draw(&request, fineness, keep_hdr)?;
        first_frame.get_or_insert_with(|| begun.elapsed());
        drawn_frames += 1;
        drawn_by = Some(drawn.by.clone());
        let before = if args.time_report { process_cpu() } else { None };
        let start = Moment::now();
        match &path {
            Some(path) => write_picture(path, &drawn.frame, &text_chunks(args, &request, &drawn.scene)).map_err(CliError)?,
            None => {
                if number == first {
                    image::write_y4m_header(&mut stream, request.width, request.height, args.rate).map_err(to_stream)?;
                }
                image::write_y4m_frame(&mut stream, &drawn.frame.display).map_err(to_stream)?;
            }
        }
        written.add(Stage::Write, start.elapsed());
        if let Some(ran) = before.and_then(|before| process_cpu()?.checked_sub(before)) {
            written.add_cpu(Stage::Write, ran);
        }
        bar.inc(1);
    }
    stream.flush().map_err(to_stream)?;
    bar.finish_and_clear();
    if args.time_report {
        let report = report(&session, &written, drawn_frames, first_frame, drawn_by);
        if output == Output::Stream { eprintln!("{report}") } else { println!("{report}") }
    }
    Ok(())
}

fn to_stream(e: impl std::fmt::Display) -> CliError {
    CliError(format!("standard output: {e}"))
}

/// A bar on a terminal, nothing in a pipe or for one frame.
fn progress(frames: u32) -> indicatif::ProgressBar {
    if frames > 1 && std::io::stderr().is_terminal() {
        indicatif::ProgressBar::new(u64::from(frames))
    } else {
        indicatif::ProgressBar::hidden()
    }
}

/// What a picture says of itself: no clock, so that the same command writes the same bytes.
fn text_chunks(args: &RenderArgs, request: &ViewRequest, scene: &crate::scene::Scene) -> Vec<(&'static str, String)> {
    let v = &args.view;
    let mut view = v.target.clone().map_or(String::new(), |t| format!("target {t}"));
    for (word, value) in [("from", &v.from), ("at", &v.at), ("up", &v.up), ("effects", &v.effects), ("layers", &v.layers)] {
        if let Some(value) = value {
            view.push_str(&format!(", {word} {value}"));
        }
    }
    view.push_str(&format!(", exposure {:+.3}", scene.exposure.stops));
    vec![
        ("Title", v.target.clone().unwrap_or_else(|| "Orrery".into())),
        ("Creation Time", request.time.to_utc_iso()),
        ("Description", view),
        ("Legend", legend(scene.pixel_view, &scene.exposure)),
        ("Software", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
    ]
}

fn report(session: &Session, written: &Stages, frames: u32, first_frame: Option<Duration>, by: Option<DrawnBy>) -> serde_json::Value {
    let (mut stages, library) = session.report();
    stages.add(Stage::Write, written.spent(Stage::Write));
    if let Some(ran) = written.cpu(Stage::Write) {
        stages.add_cpu(Stage::Write, ran);
    }
    // Stages without processor time were not counted: catalog and kernel, which come before, and all where the system does not tell.
    let counted =
        Stage::ALL.into_iter().filter_map(|s| Some((format!("{}_ms", s.name()), serde_json::json!(milliseconds(stages.cpu(s)?)))));
    let cpu: serde_json::Map<String, serde_json::Value> = counted.collect();
    let whole = process_cpu().map(milliseconds);
    let mut report = serde_json::json!({
        "renderer": by.as_ref().map_or("none", |by| by.renderer), "frames": frames, "stages": stages.to_json(), "cpu": cpu,
        "process_cpu_ms": whole, "library": library, "first_frame_ms": first_frame.map(milliseconds),
    });
    if let Some(timings) = by.as_ref().and_then(|by| by.software.as_ref()) {
        report["software_passes"] = serde_json::json!(timings.passes);
    }
    if let Some(by) = by.filter(|by| by.adapter.is_some()) {
        report["adapter"] = serde_json::json!(by.adapter);
        report["gpu_passes_ms"] =
            by.passes_ms.into_iter().map(|(name, ms)| (name, serde_json::json!(ms))).collect::<serde_json::Map<_, _>>().into();
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_numbers_go_where_the_pattern_says() {
        let run = output(Some("a/out-%05d.png"), 10).expect("a pattern");
        assert_eq!(run.path(7), Some("a/out-00007.png".into()));
        assert_eq!(output(Some("out-%d.exr"), 10).expect("a pattern").path(12), Some("out-12.exr".into()));
        assert_eq!(output(Some("-"), 10).expect("a stream"), Output::Stream);
        for (bad, frames) in [("out.png", 2), ("out.gif", 1), ("out-%5x.png", 2), ("out-%d-%d.png", 2), ("out-%099999d.png", 2)] {
            assert!(output(Some(bad), frames).unwrap_err().to_string().contains(bad), "{bad}");
        }
        assert!(output(None, 1).unwrap_err().to_string().contains("-o out.png"));
    }

    #[test]
    fn steps_and_shards_are_read_or_refused() {
        assert_eq!(step_seconds("60s").expect("s"), 60.0);
        assert_eq!(step_seconds("-1.5h").expect("h"), -5400.0);
        assert_eq!(step_seconds("2d").expect("d"), 172_800.0);
        assert!(step_seconds("soon").is_err());
        assert_eq!(shard(Some("3/4")).expect("a shard"), (3, 4));
        assert_eq!(shard(None).expect("no shard"), (0, 1));
        for bad in ["4/4", "0/0", "1", "a/b"] {
            assert!(shard(Some(bad)).unwrap_err().to_string().contains(bad));
        }
    }
}
