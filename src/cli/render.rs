//! `orrery render`: draws an image, or a sequence of frames.
//!
//! In: a view (`view_args`), or a tour file. Out: image files, an animation or a video stream; optionally images of the error bound and a report of the time
//! taken. In a sequence, files that an earlier run completed for the same request are kept.

use super::composition_args::CompositionArgs;
use super::frame_rate::FrameRate;
use super::frames::{FrameOutput, existing_frames, may_replace_animation, parse_shard, parse_step};
use super::output::{print_message, print_result, print_to_stderr, progress};
use super::render_views::Views;
use super::video_output::VideoOutput;
use super::view_args::{ViewArgs, below_horizon_message, is_now, parse_size};
use super::{CliError, Common};
use crate::files::is_same_file;
use crate::measure::{check_has_bounds, error_bounds};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::legend::legend_of;
use crate::scene::request::{CAMERA_FILE_HELP, Projection, Purpose, StereoLayout, ViewRequest};
use crate::session::{DrawnBy, PROVENANCE_CHUNK, Provenance, Session, Stage, Stages, is_exr, milliseconds, process_cpu, write_image};
use crate::wording::{counted, echo};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant as WallInstant};

const EXAMPLES: &str = "Examples:
  orrery render --target earth --time 2024-04-08T18:17:16Z -o earth.png
  orrery render --target moon --from earth --at 51.5,-0.1 --time 2024-04-23T22:00:00Z --fov 1 -o moon.png
  orrery render --target jupiter --distance-radii 60 --layers +orbits -o orbits.png
  orrery render --target jupiter --distance-radii 40 --time 2026-11-28 --frames 240 --step 10m -o out-%05d.png
  orrery render --target io --frames 240 --step 60s -o - | ffmpeg -i - io.mp4
  orrery render --target saturn --stereo anaglyph -o saturn-red-cyan.png
  orrery render --target moon --from earth --at 51.5,-0.1 --time 2024-04-23T22:00:00Z --projection fisheye --dome-zenith \
    --size 4096x4096 -o dome.png
  orrery render --target mars --from earth --projection equirectangular --up celestial \
    --size 4096x2048 -o sky.png
  orrery render --target earth --time 2024-04-08T18:17:16Z -o earth.png --error bound.png
  orrery render --target jupiter --time 2015-01-24T05:00:00Z --frames 60 --step 3m --size 400x400 -o moons.gif
  orrery render --tour eclipse.json --size 1280x720 -o - | ffmpeg -i - eclipse.mp4

A sequence resumes where it stopped: each file records its request. Files of the same
request are kept; a file of another request stops the command before it draws
(--overwrite replaces it). Give --time to resume: `now` is a new request each time.
--quality draft uses 1 sample per pixel and 1 texture tap, standard 4 samples and up
to 8 taps, reference 4 samples and up to 16 taps.
";

/// The fields of a tour file.
const TOUR_FILE_HELP: &str = "Tour file: \"title\", and \"stops\" in order, each with
  \"view\": a link (orrery://view?target=699&time=2017-05-17) or the fields of a saved view
  \"text\": the text that the window shows there
  \"hold_s\": seconds for which the camera stays [6]
  \"time_rate\": simulated seconds per second during the stay [0]
  \"travel_s\": seconds of the flight from the previous stop; 0 is a cut [4]
";

/// Heading of the options that do not describe the view.
const OUTPUT_HEADING: &str = "Output";

/// Text below the options: examples, and descriptions of camera and tour files.
fn after_help() -> String {
    format!("{EXAMPLES}\n{CAMERA_FILE_HELP}\n{TOUR_FILE_HELP}")
}

#[derive(clap::Args, Debug, Default)]
#[command(after_help = after_help())]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    view: ViewArgs,
    /// How the image is put together: projection, stereo pair, warp mesh.
    #[command(flatten)]
    composition: CompositionArgs,
    /// Output file: .png, .exr (linear), a pattern such as out-%05d.png, an animation (.apng is lossless, .gif has 256 colours), or - for a y4m stream
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT_HEADING)]
    output: Option<OsString>,
    /// Number of frames
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = OUTPUT_HEADING)]
    frames: u32,
    /// Tour file (JSON) in place of a view: draw --rate frames per second along its stops; its fields are described below
    #[cfg(feature = "view")]
    #[arg(long, value_name = "FILE", help_heading = OUTPUT_HEADING, conflicts_with_all = ["frames", "step", "error", "target", "from", "distance_radii", "at",
        "height_km", "camera_json", "time", "fov", "up", "mirror", "exposure", "tone_map", "effects", "layers", "telescope", "stars_boost", "pixels"])]
    tour: Option<PathBuf>,
    /// Time between frames: 60s, 10m, 6h, 1d; may be negative. Leap seconds count, but days keep the time of day
    #[arg(long, value_name = "TIME", default_value = "60s", allow_hyphen_values = true, help_heading = OUTPUT_HEADING)]
    step: String,
    /// Render every n-th frame starting at i (0 to n-1), to share a sequence between machines
    #[arg(long, value_name = "I/N", help_heading = OUTPUT_HEADING)]
    shard: Option<String>,
    /// Replace files of other requests; of a sequence, files of the same request are kept
    #[arg(long, help_heading = OUTPUT_HEADING)]
    overwrite: bool,
    /// Write a per-pixel error bound relative to reference quality: .png (1 level = 1/255), .exr linear; repeat for both
    #[arg(long, value_name = "FILE", help_heading = OUTPUT_HEADING)]
    error: Vec<PathBuf>,
    /// Frames per second of a y4m stream, an animation or a tour; 29.97, 23.976 and ratios such as 30000/1001 are for y4m streams and tours
    #[arg(long, value_name = "N", default_value_t, help_heading = OUTPUT_HEADING)]
    rate: FrameRate,
    /// Print timings per stage and the time to the first frame as JSON (on standard error if the image goes to standard output)
    #[arg(long, help_heading = OUTPUT_HEADING)]
    time_report: bool,
}

pub(crate) fn run(common: &Common, args: &RenderArgs) -> Result<(), CliError> {
    let run_start = WallInstant::now();
    let mut time_to_first_frame = None;
    let tour_file = args.tour_file();
    // The number of frames of a tour is not known before its file has been read.
    let output = FrameOutput::of_option(args.output.as_deref(), tour_file.is_none().then_some(args.frames))?;
    let step = parse_step(&args.step)?;
    let (first_number, stride) = parse_shard(args.shard.as_deref())?;
    if matches!(output, FrameOutput::Stream | FrameOutput::Animation(..)) && stride > 1 {
        return Err(CliError::Usage(
            "--shard needs files of one frame: a stream or an animation is written in order by one process".into(),
        ));
    }
    let starts_now = tour_file.is_none() && is_now(&args.view.time);
    if starts_now && stride > 1 && args.frames > 1 {
        print_message("--shard: give --time, because `now` is another instant for each shard");
    }
    let session = Session::open(&common.sources_for_drawing(), print_message)?;
    let session = if args.time_report { session.counting_cpu() } else { session };
    let composition = args.composition.composition()?;
    let views = match tour_file {
        Some(file) => Views::along_tour(file, parse_size(&args.view.size)?, args.rate, &session, &composition)?,
        None => Views::steps(args.view.request_with(session.catalog(), composition)?, step, args.frames),
    };
    let numbers = || (first_number..views.count()).step_by(stride as usize);
    // A time outside the accepted range is reported before the first frame is drawn.
    if let Some(last) = numbers().next_back() {
        views.check_last_frame(&session, last)?;
    } else {
        let count = counted(views.count() as usize, "frame");
        print_message(&format!("--shard {first_number}/{stride}: this shard has no frames; the sequence has only {count}"));
    }
    if views.has_stereo_or_warp() && output.path(first_number).is_some_and(|p| is_exr(&p)) {
        return Err(CliError::Usage("stereo pairs and warped images have display values: write .png, or - for a stream".into()));
    }
    let is_odd_pair = |request: &ViewRequest| {
        request.width % 2 == 1 && request.composition.stereo.is_some_and(|stereo| stereo.layout == StereoLayout::SideBySide)
    };
    if numbers().any(|number| is_odd_pair(&views.request(number))) {
        let size = &args.view.size;
        return Err(CliError::Usage(format!("--size {size}: a side-by-side pair has an even width, half of it for each eye")));
    }
    let lacks_its_outline = |request: &ViewRequest| request.layers.outline && request.composition.projection != Projection::Perspective;
    if numbers().next().is_some_and(|number| lacks_its_outline(&views.request(number))) {
        print_message("--layers +outline: fisheye and equirectangular images have no outline");
    }
    let request_of = |number: u32| {
        let purpose = Purpose::of_file(output.path(number).is_some_and(|p| is_exr(&p)));
        ViewRequest { purpose, quality: common.quality, ..views.request(number) }
    };
    let requested_files = numbers().filter_map(|n| Some((n, output.path(n)?, session.provenance(&request_of(n)))));
    let mut kept_frames = existing_frames(requested_files, parse_size(&args.view.size)?, args.overwrite, starts_now)?;
    if views.count() == 1 {
        // Only sequences resume; a single image is always drawn.
        kept_frames.clear();
    }
    if !kept_frames.is_empty() {
        print_message(&format!("kept {} of {} frames of an earlier run", kept_frames.len(), numbers().count()));
    }
    let error_bound_request = request_of(0);
    check_error_files(args, &output, &session, &error_bound_request, starts_now)?;
    let sampling = SamplingQuality::of(common.quality);
    // The time of `Stage::Write` alone, which the session does not measure.
    let mut write_time = Stages::default();
    let mut may_replace = args.overwrite;
    let mut animation_provenance = None;
    if let FrameOutput::Animation(path, _) = &output {
        let frames = numbers().map(|number| session.provenance(&request_of(number)));
        let provenance = animation_provenance.insert(Provenance::of_animation(frames, args.rate));
        may_replace = may_replace_animation(path, provenance, args.overwrite, starts_now)?;
    }
    let mut video = VideoOutput::begin(&output, parse_size(&args.view.size)?, views.count(), args.rate, may_replace)?;
    let bar = frame_progress(numbers().count() as u64);
    let mut drawn_frames = 0_u32;
    let mut drawn_by = None;
    // Said only if the target is hidden in every frame: in a sequence it may rise or set.
    let (mut hidden_frames, mut hidden_message) = (0, None);
    for number in numbers() {
        let path = output.path(number);
        if kept_frames.contains(&number) {
            bar.inc(1);
            continue;
        }
        let request = request_of(number);
        let is_linear = path.as_ref().is_some_and(|p| is_exr(p));
        let images = if is_linear { FrameImages::DisplayAndHdr } else { FrameImages::Display };
        let drawn = session.draw(&request, sampling, images)?;
        time_to_first_frame.get_or_insert_with(|| run_start.elapsed());
        drawn_frames += 1;
        if let Some(message) = below_horizon_message(&request, &drawn.scene) {
            hidden_frames += 1;
            hidden_message.get_or_insert(message);
        }
        drawn_by = Some(drawn.drawn_by.clone());
        let cpu_before = if args.time_report { process_cpu() } else { None };
        let start = WallInstant::now();
        let metadata = || {
            let provenance = animation_provenance.as_ref().map_or_else(|| session.provenance(&request).to_text(), Provenance::to_text);
            let mut metadata = text_chunks(args, views.title(), &request, &drawn.scene);
            metadata.push((PROVENANCE_CHUNK, provenance));
            metadata
        };
        match &path {
            Some(path) => write_image(path, &drawn.frame, &metadata())?,
            None => video.add(&drawn.frame, metadata)?,
        }
        write_time.add(Stage::Write, start.elapsed());
        if let Some(cpu_time) = cpu_before.and_then(|before| process_cpu()?.checked_sub(before)) {
            write_time.add_cpu(Stage::Write, cpu_time);
        }
        bar.inc(1);
    }
    video.finish()?;
    bar.finish_and_clear();
    if let Some(message) = hidden_message.filter(|_| hidden_frames == drawn_frames) {
        print_message(&message);
    }
    if !args.error.is_empty() {
        let bounds = error_bounds(&session, &error_bound_request)?;
        for path in &args.error {
            let provenance = session.provenance(&error_bound_request).of_error_bound();
            let metadata = [("Title", "Error bound".to_owned()), (PROVENANCE_CHUNK, provenance.to_text())];
            write_image(path, &bounds, &metadata)?;
        }
    }
    if common.verbose > 0 {
        print_message(&verbose_line(&session, &write_time, drawn_frames, drawn_by.as_ref()));
    }
    if args.time_report {
        let mut report = time_report(&session, &write_time, drawn_frames, time_to_first_frame, drawn_by);
        report["kept_frames"] = kept_frames.len().into();
        let report = format!("{report}\n");
        if output == FrameOutput::Stream {
            print_to_stderr(&report);
        } else {
            print_result(&report)?;
        }
    }
    Ok(())
}

impl RenderArgs {
    #[cfg(feature = "view")]
    fn tour_file(&self) -> Option<&Path> {
        self.tour.as_deref()
    }

    #[cfg(not(feature = "view"))]
    fn tour_file(&self) -> Option<&Path> {
        None
    }
}

/// Checks `--error`. It is refused for several frames, and for stereo pairs and warped images, which have no linear light. Its files must be PNG or EXR, must
/// not be the image itself, and must not hold the result of another request unless `--overwrite` is given.
fn check_error_files(
    args: &RenderArgs,
    output: &FrameOutput,
    session: &Session,
    request: &ViewRequest,
    starts_now: bool,
) -> Result<(), CliError> {
    if !args.error.is_empty() && args.frames > 1 {
        return Err(CliError::Usage("--error is for one frame: leave out --frames".into()));
    }
    if !args.error.is_empty() {
        check_has_bounds(request).map_err(|e| CliError::Usage(format!("--error: {e}")))?;
    }
    for path in &args.error {
        if output.path(0).is_some_and(|image| is_same_file(&image, path)) {
            return Err(CliError::Usage(format!("--error {}: -o writes the image into this file", echo(&path.display().to_string()))));
        }
        if !is_exr(path) && !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            return Err(CliError::Usage(format!("--error {}: the name must end in .png or .exr", echo(&path.display().to_string()))));
        }
    }
    let requested_files = args.error.iter().map(|path| (0, path.clone(), session.provenance(request).of_error_bound()));
    // Called for its errors: the bounds are written anew even if the files have them already.
    existing_frames(requested_files, (request.width, request.height), args.overwrite, starts_now).map(drop)
}

/// A progress bar for several frames, a hidden one for a single frame.
fn frame_progress(frame_count: u64) -> indicatif::ProgressBar {
    if frame_count > 1 { progress(frame_count) } else { indicatif::ProgressBar::hidden() }
}

/// The metadata of an image, or of an animation by its first frame. `Creation Time` is the time of the view. The time of writing is left out, so that the same command writes the same bytes.
fn text_chunks(args: &RenderArgs, title: Option<&str>, request: &ViewRequest, scene: &crate::scene::Scene) -> Vec<(&'static str, String)> {
    let v = &args.view;
    let options = [("target", &v.target), ("from", &v.from), ("at", &v.at), ("up", &v.up), ("effects", &v.effects), ("layers", &v.layers)];
    let given = options.into_iter().filter_map(|(name, value)| Some(format!("{name} {}", value.as_ref()?)));
    let mut description: Vec<String> = given.collect();
    if request.is_mirrored {
        description.push("mirrored".into());
    }
    if !request.composition.is_plain() {
        description.push(request.composition.to_text());
    }
    description.push(format!("exposure {:+.3}", scene.exposure.stops));
    vec![
        ("Title", title.map(str::to_owned).or(v.target.clone()).unwrap_or_else(|| "Orrery".into())),
        ("Creation Time", request.time.to_utc_iso()),
        ("Description", description.join(", ")),
        ("Legend", legend_of(scene)),
        ("Software", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
    ]
}

/// The line of `-v`: how many frames were drawn, by which renderer, and the time of each stage.
fn verbose_line(session: &Session, write_time: &Stages, drawn_frames: u32, drawn_by: Option<&DrawnBy>) -> String {
    let (session_stages, _) = session.report();
    let stages = session_stages.and(write_time);
    let times = Stage::ALL.map(|stage| format!("{} {:.1} ms", stage.name(), milliseconds(stages.elapsed(stage))));
    let renderer = drawn_by.map_or(String::new(), |by| format!(" by {}", by.adapter.as_deref().unwrap_or(by.renderer)));
    format!("drew {}{renderer}: {}", counted(drawn_frames as usize, "frame"), times.join(", "))
}

/// The JSON object of `--time-report`. `time_to_first_frame`: the time from the start of the command to the first frame. `drawn_by`: what drew the last frame,
/// with the times of this frame's passes; the stages are summed over all frames.
fn time_report(
    session: &Session,
    write_time: &Stages,
    drawn_frames: u32,
    time_to_first_frame: Option<Duration>,
    drawn_by: Option<DrawnBy>,
) -> serde_json::Value {
    let (mut stages, library_statistics) = session.report();
    stages.add(Stage::Write, write_time.elapsed(Stage::Write));
    if let Some(cpu_time) = write_time.cpu(Stage::Write) {
        stages.add_cpu(Stage::Write, cpu_time);
    }
    // Only stages whose CPU time is known. It is unknown for stages that run before counting starts (`Stage::Catalog`, `Stage::Kernel`), and for all stages if
    // the operating system does not report it.
    let cpu_times =
        Stage::ALL.into_iter().filter_map(|s| Some((format!("{}_ms", s.name()), serde_json::json!(milliseconds(stages.cpu(s)?)))));
    let cpu: serde_json::Map<String, serde_json::Value> = cpu_times.collect();
    let process_cpu_ms = process_cpu().map(milliseconds);
    let mut report = serde_json::json!({
        "renderer": drawn_by.as_ref().map_or("none", |by| by.renderer), "frames": drawn_frames, "stages": stages.to_json(), "cpu": cpu,
        "process_cpu_ms": process_cpu_ms, "library": library_statistics, "first_frame_ms": time_to_first_frame.map(milliseconds),
    });
    if let Some(timings) = drawn_by.as_ref().and_then(|by| by.software_timings.as_ref()) {
        report["software_passes"] = serde_json::json!(timings.passes);
    }
    if let Some(by) = drawn_by.filter(|by| by.adapter.is_some()) {
        report["adapter"] = serde_json::json!(by.adapter);
        report["gpu_passes_ms"] =
            by.gpu_passes_ms.into_iter().map(|(name, ms)| (name, serde_json::json!(ms))).collect::<serde_json::Map<_, _>>().into();
    }
    report
}
