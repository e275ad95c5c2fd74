//! The Performance panel: a plot of recent frame times, its description for screen readers, and a table of the last frame's timings.
//!
//! In: finished images with their timings, the session's messages about drivers. Out: the panel. Here a frame is one image of the view; only in
//! `interface_ms` and `frame_start_s` is it a frame of the window.

use super::Interface;
use crate::session::Stage;
use crate::view::language::{decimal, text, translated_name};
use crate::view::worker::render_worker::RenderedView;
use egui_plot::{Legend, Line, Plot, PlotPoints};
use std::collections::VecDeque;

/// Largest number of frames in the plot.
const MAX_FRAMES: usize = 240;
/// Interval over which images are counted for the frame rate, and between updates of the plot's description, seconds.
const RATE_INTERVAL_S: f64 = 2.0;
/// The stages of drawing a frame; the other stages (reading catalogs and the ephemeris, writing files) are not part of drawing.
const FRAME_STAGES: [Stage; 5] = [Stage::Scene, Stage::Shaders, Stage::Maps, Stage::Plan, Stage::Draw];

/// Timings of one image.
struct Frame {
    /// The time of each stage, in the order of [`Stage::ALL`].
    stage_ms: [f64; Stage::ALL.len()],
    /// Name of each pass, and its milliseconds.
    passes_ms: Vec<(String, f64)>,
    /// Time from the start of the job to the finished image.
    render_ms: f64,
}

/// State of the Performance panel.
#[derive(Default)]
pub(crate) struct PerformancePanel {
    frames: VecDeque<Frame>,
    /// Arrival times of the newest image and of those in the [`RATE_INTERVAL_S`] before it, in egui's time (`InputState::time`).
    arrivals_s: VecDeque<f64>,
    /// Time that the interface itself took in the last frame, milliseconds.
    pub interface_ms: f64,
    /// The session's messages about drivers and devices.
    pub messages: Vec<String>,
    /// Description of the plot, and when it was formatted, in egui's time (`InputState::time`).
    plot_description: Option<(String, f64)>,
}

/// Whether a session message is only about drivers and devices. These messages are always in English.
pub(crate) fn is_about_drivers(line: &str) -> bool {
    line.contains("drawing in software") || line.contains("displaying via the CPU")
}

impl PerformancePanel {
    /// Adds the timings of a finished image.
    pub(crate) fn record(&mut self, rendered: &RenderedView, now_s: f64) {
        self.arrivals_s.push_back(now_s);
        while self.arrivals_s.front().is_some_and(|first| now_s - first > RATE_INTERVAL_S) {
            self.arrivals_s.pop_front();
        }
        let stage_ms = Stage::ALL.map(|s| rendered.stages.elapsed(s).as_secs_f64() * 1e3);
        self.frames.push_back(Frame { stage_ms, passes_ms: passes_ms(rendered), render_ms: rendered.render_ms });
        if self.frames.len() > MAX_FRAMES {
            self.frames.pop_front();
        }
    }

    /// Description of the plot, updated at most every [`RATE_INTERVAL_S`], because a screen reader announces each change.
    fn description(&mut self, now_s: f64) -> String {
        let is_old = |(_, created_s): &(String, f64)| now_s - created_s > RATE_INTERVAL_S;
        if self.plot_description.as_ref().is_none_or(is_old) {
            self.plot_description = Some((describe(&self.frames), now_s));
        }
        self.plot_description.as_ref().map_or(String::new(), |(description, _)| description.clone())
    }
}

/// A text with the number of frames, the mean and maximum of their times from job to image, and the mean time of each stage.
fn describe(frames: &VecDeque<Frame>) -> String {
    if frames.is_empty() {
        return text!("frames-none").into();
    }
    let mean = |value: &dyn Fn(&Frame) -> f64| frames.iter().map(value).sum::<f64>() / frames.len() as f64;
    let max_render_ms = frames.iter().map(|f| f.render_ms).fold(0.0, f64::max);
    let stages: Vec<String> = FRAME_STAGES
        .iter()
        .map(|stage| format!("{} {} ms", translated_name("stage", stage.name()), decimal(mean(&|f| f.stage_ms[*stage as usize]), 1)))
        .collect();
    let mean_render_ms = mean(&|f| f.render_ms);
    text!(
        "frames-description",
        frames = frames.len(),
        whole = decimal(mean_render_ms, 1),
        max = decimal(max_render_ms, 1),
        stages = stages.join(", ")
    )
}

/// Name and milliseconds of each pass: GPU time if the GPU drew the image and has timestamp queries, or wall time of the software renderer.
/// A pass has the name of its target in `render::plan`, which the messages `pass-…` translate.
fn passes_ms(rendered: &RenderedView) -> Vec<(String, f64)> {
    let software = rendered.drawn_by.software_timings.iter().flat_map(|t| &t.passes).map(|p| (p.name.clone(), p.wall_ms));
    rendered.drawn_by.gpu_passes_ms.iter().cloned().chain(software).collect()
}

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui) {
    let description = interface.performance.description(interface.viewport.frame_start_s);
    let performance = &interface.performance;
    let plot = Plot::new("frame times")
        .height(200.0)
        .legend(Legend::default().text_style(egui::TextStyle::Small).background_alpha(0.4))
        .include_y(0.0)
        .allow_scroll(false)
        .y_axis_label("ms")
        .show(ui, |plot| {
            let points = |value: &dyn Fn(&Frame) -> f64| -> PlotPoints<'_> {
                performance.frames.iter().enumerate().map(|(i, f)| [i as f64, value(f)]).collect()
            };
            for stage in FRAME_STAGES {
                plot.line(Line::new(translated_name("stage", stage.name()), points(&|f| f.stage_ms[stage as usize])));
            }
            // A frame without this pass is plotted as 0 ms.
            for (pass, _) in performance.frames.back().map_or(&[][..], |f| &f.passes_ms) {
                let pass_ms = |f: &Frame| f.passes_ms.iter().find(|(name, _)| name == pass).map_or(0.0, |(_, ms)| *ms);
                plot.line(Line::new(text!("frames-pass", pass = translated_name("pass", pass)), points(&pass_ms)));
            }
            plot.line(Line::new(text!("frames-total"), points(&|f| f.render_ms)));
        });
    plot.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, text!("frames-plot")));
    // Value and description are both set, because not every platform announces the value of an image.
    ui.ctx().accesskit_node_builder(plot.response.id, |node| {
        node.set_value(description.clone());
        node.set_description(description);
    });
    for message in &performance.messages {
        ui.add(egui::Label::new(message).wrap());
    }
    let Some(rendered) = interface.shown() else { return };
    let table_rows = |ui: &mut egui::Ui| {
        let mut row = |label: &str, value: String| {
            ui.label(label);
            ui.monospace(value);
            ui.end_row();
        };
        let drawn_by = &rendered.drawn_by;
        row(text!("perf-renderer"), drawn_by.adapter.clone().unwrap_or_else(|| translated_name("renderer", drawn_by.renderer).into()));
        row(text!("perf-display"), if interface.presents_on_gpu { "GPU" } else { "CPU" }.into());
        row(text!("perf-image"), format!("{}x{} px", rendered.width, rendered.height));
        row(text!("perf-frame"), format!("{} ms", decimal(rendered.render_ms, 1)));
        row(
            text!("perf-frame-rate"),
            text!("perf-frame-rate-value", rate = decimal(performance.arrivals_s.len() as f64 / RATE_INTERVAL_S, 1)),
        );
        for stage in FRAME_STAGES {
            row(translated_name("stage", stage.name()), format!("{} ms", decimal(rendered.stages.elapsed(stage).as_secs_f64() * 1e3, 2)));
        }
        for (pass, ms) in passes_ms(rendered) {
            row(&text!("frames-pass", pass = translated_name("pass", &pass)), format!("{} ms", decimal(ms, 2)));
        }
        if let Some(timings) = &drawn_by.software_timings {
            row(text!("perf-triangles-submitted"), timings.passes.iter().map(|p| p.submitted_triangles).sum::<usize>().to_string());
            row(text!("perf-triangles-culled"), timings.passes.iter().map(|p| p.culled_triangles).sum::<usize>().to_string());
            row(text!("perf-triangles-clipped"), timings.passes.iter().map(|p| p.clipped_triangles).sum::<usize>().to_string());
            row(text!("perf-triangles-shaded"), timings.passes.iter().map(|p| p.rasterised_triangles).sum::<usize>().to_string());
        }
        row(text!("perf-interface"), format!("{} ms", decimal(performance.interface_ms, 2)));
        row(text!("perf-draws"), rendered.scene.draws.len().to_string());
        row(text!("perf-points"), rendered.scene.points.len().to_string());
        let shown_count = rendered.scene.bodies.iter().filter(|b| b.appearance != crate::scene::Appearance::NotShown).count();
        row(text!("perf-bodies"), text!("perf-bodies-value", shown = shown_count, all = rendered.scene.bodies.len()));
        let library = &rendered.library;
        row(text!("perf-shaders-memory"), library.from_memory.to_string());
        row(text!("perf-shaders-disk"), text!("perf-in-seconds", count = library.from_disk, seconds = decimal(library.reading_s, 3)));
        row(text!("perf-shaders-compiled"), text!("perf-in-seconds", count = library.emitted, seconds = decimal(library.emitting_s, 3)));
        row(text!("perf-shaders-written"), text!("perf-in-seconds", count = library.written, seconds = decimal(library.writing_s, 3)));
        row(text!("perf-shaders-repaired"), library.repaired.to_string());
        row(text!("perf-memory"), resident_mib().map_or(text!("perf-not-available").into(), |m| format!("{m:.0} MiB")));
    };
    egui::Grid::new("performance").num_columns(2).striped(true).show(ui, table_rows);
}

/// Resident memory of the process, MiB; `None` if the system has no /proc, which Linux has.
fn resident_mib() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let kib: f64 = text.lines().find_map(|l| l.strip_prefix("VmRSS:"))?.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_description_of_the_plot_is_kept_for_an_interval() {
        let mut panel = PerformancePanel::default();
        assert_eq!(panel.description(0.0), "no frame yet");
        for render_ms in [10.0, 20.0, 60.0] {
            let mut stage_ms = [0.0; Stage::ALL.len()];
            stage_ms[Stage::Draw as usize] = render_ms / 2.0;
            panel.frames.push_back(Frame { stage_ms, passes_ms: Vec::new(), render_ms });
        }
        assert_eq!(panel.description(RATE_INTERVAL_S), "no frame yet");
        let description = panel.description(RATE_INTERVAL_S + 0.1);
        assert!(
            description.starts_with("3 frames: mean 30.0 ms, maximum 60.0 ms") && description.contains("draw 15.0 ms"),
            "{description}"
        );
    }
}
