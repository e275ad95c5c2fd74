//! `orrery bench`: measures wall time and CPU time per frame of the standard scenes, by stage, and prints JSON.
//!
//! Each scene is drawn once to fill the caches and then measured. Except for `first_ms`, `least_ms` and the costs of effects, the times in a scene's row
//! are those of a single frame, the one with the median wall time, so that they belong together. No files are written.

use super::output::{print_message, progress};
use super::view_args::parse_size;
use super::{CliError, Common};
use crate::measure::timing::{Quartiles, interleaved};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::draw::{INSTRUCTIONS_PER_READ, PixelView};
use crate::scene::effects::Effect;
use crate::scene::request::{ExposureRequest, ViewRequest};
use crate::session::{DrawnBy, LightChange, Session, Stage, Stages, milliseconds, process_cpu, standard_scenes};
use crate::wording::{echo, suggestion_or_list};
use indicatif::ProgressBar;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::time::{Duration, Instant as WallInstant};

const AFTER_HELP: &str = "Examples:
  orrery bench
  orrery bench --scene saturn --scene moon-limb --size 512x512 --frames 9

With --effects, each scene also lists its active effects. cpu_ms and wall_ms are the
cost of an effect: the median difference between --frames pairs of frames with and
without it, at least 0. cpu_noise_ms and wall_noise_ms are the median absolute deviation
of these differences (null for one pair); a cost below its noise is not significant.
light is the sum over the pixels of the absolute change of luminance that the effect
causes, as a fraction of the total luminance of the brighter image.

Scenes: earth-3-radii, saturn, moon-limb, jupiter-four-moons, whole-system, night-sky, belt
(100000 invented minor planets, distributed as the known ones), million-stars (the
embedded stars and invented fainter ones, down to magnitude 10.8).

With --counts, each scene also lists what the fragment shaders of its bodies execute in
one frame: operations (a fused multiply-add is one; a branch counts for all pixels of a
batch if one of them takes it) and texture reads (a filtered read is one, whatever its
number of taps), both summed over the pixels.

With --meshes, shape models are measured in place of the scenes: an invented shape for
Phobos with 5000 to 326000 triangles. For each number: the time to read the shape, the
time to trace its shadow on itself, and the times to draw it with and without that
shadow, each divided by the time to draw the ellipsoid, measured alternately.

Each scene is drawn once to fill the caches (first_ms), then --frames times. median_ms,
median_cpu_ms, stages and stages_cpu are those of the frame with the median wall time
(of an even number, the faster of the middle two). CPU times add up all threads of the
process; null if the system does not report them. Compare results of one machine only;
on a busy machine compare least_ms.";

#[derive(clap::Args, Debug, Default)]
#[command(after_help = AFTER_HELP, next_help_heading = "Measurement")]
pub(crate) struct BenchArgs {
    /// Scene to measure; repeat or separate by commas [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    scene: Vec<String>,
    /// Measured frames of each scene
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024")]
    size: String,
    /// Measure shape models by number of triangles instead
    #[arg(long, conflicts_with_all = ["scene", "effects", "counts"])]
    meshes: bool,
    /// Also measure the cost of each active effect
    #[arg(long)]
    effects: bool,
    /// Also count the operations that the shaders of the bodies execute, in the software renderer
    #[arg(long)]
    counts: bool,
    /// Accepted for consistency; the output is always JSON
    #[arg(long)]
    json: bool,
}

/// The stages of every measured frame. The others run at program start (catalog, kernel) or write files, which `bench` does not.
const FRAME_STAGES: [Stage; 5] = [Stage::Scene, Stage::Shaders, Stage::Maps, Stage::Plan, Stage::Draw];

/// The measurements of one frame.
struct MeasuredFrame {
    /// Elapsed time.
    wall: Duration,
    /// CPU time of all threads; `None` if the system does not report it.
    cpu: Option<Duration>,
    /// Time of each stage.
    stages: Stages,
    /// Renderer and adapter; `None` only in tests.
    drawn_by: Option<DrawnBy>,
}

pub(crate) fn run(common: &Common, args: &BenchArgs) -> Result<(), CliError> {
    let (width, height) = parse_size(&args.size)?;
    if args.meshes {
        return super::bench_meshes::run(common, (width, height), args.frames as usize);
    }
    let mut scenes = standard_scenes(width, height);
    let names: Vec<&str> = scenes.iter().map(|s| s.name).collect();
    if let Some(unknown) = args.scene.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(CliError::Usage(format!("--scene {}: {}", echo(unknown), suggestion_or_list(unknown, &names))));
    }
    scenes.iter_mut().for_each(|s| s.request.quality = common.quality);
    scenes.retain(|s| args.scene.is_empty() || args.scene.iter().any(|name| name == s.name));
    let open_session = || Session::open(&common.sources_for_drawing(), print_message).map(Session::counting_cpu);
    let session = open_session()?;
    let bar = progress(scenes.len() as u64 * (u64::from(args.frames) + 1));
    let mut rows = Vec::new();
    for scene in &scenes {
        // A scene with invented minor planets or stars needs a session that uses these in place of the embedded ones.
        let own_session = match (scene.minor_planets(), scene.stars()) {
            (Some(bodies), _) => Some(open_session()?.with_small_bodies(bodies)),
            (None, Some(stars)) => Some(open_session()?.with_stars(stars)),
            (None, None) => None,
        };
        let session = own_session.as_ref().unwrap_or(&session);
        let measure = |request: &ViewRequest| -> Result<MeasuredFrame, CliError> {
            let (stages_before, _) = session.report();
            let cpu_before = process_cpu();
            let start = WallInstant::now();
            let drawn_by = Some(session.draw(request, SamplingQuality::of(common.quality), FrameImages::Display)?.drawn_by);
            let wall = start.elapsed();
            let cpu = cpu_before.and_then(|before| process_cpu()?.checked_sub(before));
            bar.inc(1);
            let (stages_after, _) = session.report();
            Ok(MeasuredFrame { wall, cpu, stages: stages_after.since(&stages_before), drawn_by })
        };
        let first = measure(&scene.request)?;
        let mut frames = (0..args.frames).map(|_| measure(&scene.request)).collect::<Result<Vec<_>, _>>()?;
        let mut row = scene_row(scene.name, &first, &mut frames);
        if args.effects {
            let effects = effect_rows(session, SamplingQuality::of(common.quality), &scene.request, args.frames, &measure, &bar)?;
            row["effects"] = effects.into();
        }
        if args.counts {
            row["counts"] = shader_counts(session, SamplingQuality::of(common.quality), &scene.request)?;
        }
        rows.push(row);
    }
    bar.finish_and_clear();
    let options = session.renderer().options();
    let report = json!({
        "kernels": options.kernel_class.name(),
        "threads": session.renderer().threads(),
        "width": width,
        "height": height,
        "samples": SamplingQuality::of(common.quality).samples,
        "frames": args.frames,
        "scenes": rows,
    });
    super::output::print_result(&format!("{report:#}\n"))
}

/// The number of pixels that the bodies' fragment shaders shade in one frame, and the operations and texture reads of these shaders, summed over the pixels.
fn shader_counts(session: &Session, sampling: SamplingQuality, request: &ViewRequest) -> Result<Value, CliError> {
    // The pixel view `cost` shows only bodies, so the shaders of stars and lines are not counted.
    let costs = session.draw(&ViewRequest { pixel_view: PixelView::Cost, ..request.clone() }, sampling, FrameImages::DisplayAndHdr)?;
    // Each pixel of this view stores the operations in red, and the texture reads times INSTRUCTIONS_PER_READ in green.
    let (red, green) = (0, 1);
    let sum = |channel: usize| costs.frame.hdr.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>();
    Ok(json!({ "shaded_pixels": costs.frame.hdr.iter().filter(|pixel| pixel[red] > 0.0).count(),
        "operations": sum(red).round(), "texture_reads": (sum(green) / INSTRUCTIONS_PER_READ).round() }))
}

/// A row for each active effect: its cost, and how much it changes the image. Cost and change come from frames with and without the effect; the timed frames
/// are drawn alternately. The function adds the number of timed frames to the length of `bar`, and expects `measure` to advance `bar` by one per frame.
/// `pair_count`: timed pairs for each effect.
fn effect_rows(
    session: &Session,
    sampling: SamplingQuality,
    request: &ViewRequest,
    pair_count: u32,
    measure: &dyn Fn(&ViewRequest) -> Result<MeasuredFrame, CliError>,
    bar: &ProgressBar,
) -> Result<Vec<Value>, CliError> {
    let drawn_with_effects = session.draw(request, sampling, FrameImages::DisplayAndHdr)?;
    // The exposure is fixed, so that automatic exposure does not brighten the image without the effect.
    let request_with_effects = ViewRequest { exposure: ExposureRequest::Stops(drawn_with_effects.scene.exposure.stops), ..request.clone() };
    let mut rows = Vec::new();
    let is_active = |e: Effect| drawn_with_effects.scene.bodies.iter().flat_map(|b| &b.decisions).any(|d| d.on && d.effect == e.name());
    let active: Vec<Effect> = Effect::ALL.into_iter().filter(|e| is_active(*e)).collect();
    bar.inc_length(2 * u64::from(pair_count) * active.len() as u64);
    for effect in active {
        let mut request_without_effect = request_with_effects.clone();
        request_without_effect.effects.set(effect, false);
        // This frame also loads the modules and maps that the image without the effect needs, so that the timed frames do not.
        let drawn_without_effect = session.draw(&request_without_effect, sampling, FrameImages::DisplayAndHdr)?;
        let frames = interleaved(pair_count as usize, &[&|| measure(&request_with_effects), &|| measure(&request_without_effect)])?;
        let difference_ms = |a: Duration, b: Duration| milliseconds(a) - milliseconds(b);
        // Each pair: the frame with the effect and the frame without the effect of one round.
        let pairs = || frames[0].iter().zip(&frames[1]);
        let (wall_ms, wall_noise_ms) = cost_and_noise_ms(pairs().map(|(a, b)| difference_ms(a.wall, b.wall)).collect());
        let (cpu_ms, cpu_noise_ms) = cost_and_noise_ms(pairs().filter_map(|(a, b)| Some(difference_ms(a.cpu?, b.cpu?))).collect());
        rows.push(json!({
            "name": effect.name(),
            "cpu_ms": cpu_ms,
            "cpu_noise_ms": cpu_noise_ms,
            "wall_ms": wall_ms,
            "wall_noise_ms": wall_noise_ms,
            "light": LightChange::between(&drawn_without_effect.frame.hdr, &drawn_with_effects.frame.hdr).absolute,
        }));
    }
    Ok(rows)
}

/// The cost, which is the median of the time differences but at least 0 (`None` without any), and the noise, which is the median absolute deviation of the
/// differences (`None` for fewer than two).
fn cost_and_noise_ms(differences_ms: Vec<f64>) -> (Option<f64>, Option<f64>) {
    let count = differences_ms.len();
    let median_of = |values: Vec<f64>| Quartiles::of(values).map(|quartiles| quartiles.median);
    let Some(median) = median_of(differences_ms.clone()) else { return (None, None) };
    let noise = median_of(differences_ms.iter().map(|d| (d - median).abs()).collect()).filter(|_| count > 1);
    let round_to_microsecond = |ms: f64| (1e3 * ms).round() / 1e3;
    (Some(round_to_microsecond(median.max(0.0))), noise.map(round_to_microsecond))
}

/// The row of a scene; sorts `frames`, which must not be empty, by wall time.
fn scene_row(name: &str, first: &MeasuredFrame, frames: &mut [MeasuredFrame]) -> Value {
    frames.sort_by_key(|f| f.wall);
    let median_frame = &frames[(frames.len() - 1) / 2];
    let by_stage = |ms: &dyn Fn(Stage) -> Value| -> Map<String, Value> {
        FRAME_STAGES.into_iter().map(|s| (format!("{}_ms", s.name()), ms(s))).collect()
    };
    json!({
        "scene": name,
        "renderer": median_frame.drawn_by.as_ref().map(|by| by.renderer),
        "adapter": median_frame.drawn_by.as_ref().and_then(|by| by.adapter.clone()),
        "device_passes_ms": median_frame.drawn_by.as_ref().map(|by| by.gpu_passes_ms.iter().cloned().collect::<BTreeMap<_, _>>()),
        "first_ms": milliseconds(first.wall),
        "median_ms": milliseconds(median_frame.wall),
        "median_cpu_ms": median_frame.cpu.map(milliseconds),
        "least_ms": milliseconds(frames[0].wall),
        "stages": by_stage(&|s| json!(milliseconds(median_frame.stages.elapsed(s)))),
        "stages_cpu": by_stage(&|s| json!(median_frame.stages.cpu(s).map(milliseconds))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Sources;
    use indicatif::ProgressDrawTarget;

    #[test]
    fn the_progress_bar_expects_the_frames_that_measure_effects() {
        let cache = tempfile::tempdir().expect("a folder");
        let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
        let session = Session::open(&sources, |_| {}).expect("opens");
        let scene = standard_scenes(8, 8).into_iter().find(|s| s.name == "saturn").expect("a standard scene");
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::hidden());
        bar.inc(1);
        let measure = |_: &ViewRequest| -> Result<MeasuredFrame, CliError> {
            bar.inc(1);
            Ok(MeasuredFrame { wall: Duration::ZERO, cpu: None, stages: Stages::default(), drawn_by: None })
        };
        let effects =
            effect_rows(&session, SamplingQuality { samples: 1, anisotropy: 1 }, &scene.request, 2, &measure, &bar).expect("effects");
        assert!(!effects.is_empty());
        // One frame before the call, then for each effect two pairs of frames.
        assert_eq!((bar.length(), bar.position()), (Some(1 + 4 * effects.len() as u64), 1 + 4 * effects.len() as u64));
    }

    #[test]
    fn a_cost_is_a_median_of_at_least_zero_with_its_deviation() {
        assert_eq!(cost_and_noise_ms(vec![-3.0, -1.0, -2.0]), (Some(0.0), Some(1.0)));
        assert_eq!(cost_and_noise_ms(vec![4.0, 6.0]), (Some(5.0), Some(1.0)));
        assert_eq!((cost_and_noise_ms(vec![7.0]), cost_and_noise_ms(Vec::new())), ((Some(7.0), None), (None, None)));
    }

    #[test]
    fn a_row_describes_a_single_frame() {
        let ms = Duration::from_millis;
        let frame = |wall_ms: u64, cpu_ms: u64| {
            let mut stages = Stages::default();
            stages.add(Stage::Draw, ms(wall_ms - 1));
            MeasuredFrame { wall: ms(wall_ms), cpu: Some(ms(cpu_ms)), stages, drawn_by: None }
        };
        let mut frames = [frame(30, 1), frame(10, 3), frame(20, 7), frame(40, 2)];
        let row = scene_row("saturn", &frame(90, 9), &mut frames);
        assert_eq!((&row["median_ms"], &row["median_cpu_ms"], &row["least_ms"]), (&json!(20.0), &json!(7.0), &json!(10.0)));
        assert_eq!((&row["stages"]["draw_ms"], &row["stages_cpu"]["draw_ms"]), (&json!(19.0), &Value::Null));
    }
}
