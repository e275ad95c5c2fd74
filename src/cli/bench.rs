//! `orrery bench`: milliseconds per frame of the standard scenes, by stage, as JSON.

use super::view_words::size;
use super::{CliError, Common};
use crate::session::{Session, Stage, standard_scenes};
use std::time::Instant as Moment;

const EXAMPLE: &str = "Example:
  orrery bench --scene saturn --frames 9

Each scene is drawn once to fill caches, then --frames times; the median frame and
the mean of each stage are printed. These are wall times: compare figures of one
run on one machine only.";

#[derive(clap::Args, Debug, Default)]
#[command(after_help = EXAMPLE)]
pub struct BenchArgs {
    /// Only this scene [default: all]
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Counted frames of each scene
    #[arg(long, value_name = "N", default_value_t = 5)]
    frames: u32,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024")]
    size: String,
}

/// Stages of a frame, without those of the start.
const FRAME_STAGES: [Stage; 5] = [Stage::Scene, Stage::Shaders, Stage::Maps, Stage::Plan, Stage::Draw];

pub fn run(common: &Common, args: &BenchArgs) -> Result<(), CliError> {
    common.drawing_renderer()?;
    let (width, height) = size(&args.size)?;
    let frames = args.frames.max(1);
    let session = Session::open(&common.sources(), |line| eprintln!("orrery: {line}"))?;
    let scenes = standard_scenes(width, height);
    let names: Vec<&str> = scenes.iter().map(|s| s.name).collect();
    if let Some(wanted) = &args.scene
        && !names.contains(&wanted.as_str())
    {
        return Err(CliError(format!("--scene {wanted}: one of {}", names.join(", "))));
    }
    let mut rows = Vec::new();
    for scene in scenes.iter().filter(|s| args.scene.as_deref().is_none_or(|w| w == s.name)) {
        session.draw(&scene.request, common.quality.fineness(), false)?;
        let (before, _) = session.report();
        let mut frame_ms = Vec::new();
        for _ in 0..frames {
            let start = Moment::now();
            session.draw(&scene.request, common.quality.fineness(), false)?;
            frame_ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
        frame_ms.sort_by(f64::total_cmp);
        let (after, _) = session.report();
        let mean_ms = |s: Stage| (after.spent(s) - before.spent(s)).as_secs_f64() * 1e3 / f64::from(frames);
        let stages: serde_json::Map<String, serde_json::Value> =
            FRAME_STAGES.into_iter().map(|s| (format!("{}_ms", s.name()), rounded(mean_ms(s)))).collect();
        rows.push(serde_json::json!({
            "scene": scene.name,
            "median_ms": rounded(frame_ms[frame_ms.len() / 2]),
            "least_ms": rounded(frame_ms[0]),
            "stages": stages,
        }));
    }
    let report = serde_json::json!({ "renderer": "software", "width": width, "height": height, "frames": frames, "scenes": rows });
    super::output::put(&format!("{report:#}\n"))
}

fn rounded(ms: f64) -> serde_json::Value {
    serde_json::json!((ms * 1e3).round() / 1e3)
}
