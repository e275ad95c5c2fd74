//! The controls for images, sequences and animations.

use super::dialog::{self, FileField};
use super::export::Format;
use super::{Interface, Wanted};
use crate::view::app::file_names::absolute_path;
use crate::view::panels::accessible;
use crate::view::panels::icons::{self, Icon};
use egui::{DragValue, Label, ProgressBar, RichText, TextEdit, Ui};
use std::path::Path;

fn side(value: &mut u32) -> DragValue<'_> {
    DragValue::new(value).range(1..=16_384)
}

/// Width, height and labels; `labels` are their accessible names.
fn format_fields(ui: &mut Ui, format: &mut Format, [width, height, labels]: [&str; 3]) {
    accessible::number(ui, side(&mut format.size[0]), width);
    ui.label("x");
    accessible::number(ui, side(&mut format.size[1]), height);
    let labels = ui.checkbox(&mut format.names, "Labels").accessible_name(labels);
    labels.on_hover_text("Draw names and markers of bodies into what is saved");
}

fn folder(ui: &mut Ui, file: &str) {
    let folder =
        absolute_path(Path::new(file)).rsplit_once(std::path::MAIN_SEPARATOR).map_or(String::new(), |(folder, _)| folder.to_owned());
    ui.add(Label::new(RichText::new(format!("Folder: {folder}/")).small().weak()).truncate());
}

pub(crate) fn images(interface: &mut Interface, ui: &mut Ui) {
    ui.strong("Images");
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.picture).desired_width(150.0))
            .on_hover_text("Image file: .png or .exr. No file is replaced: the next free number is added to the name. %05d stands for the frame number of a sequence");
        dialog::button(interface, ui, FileField::Picture);
    });
    let panel = &mut interface.share;
    ui.horizontal(|ui| format_fields(ui, &mut panel.picture_format, ["Width, pixels", "Height, pixels", "Labels"]));
    folder(ui, &panel.picture);
    let save = icons::button(ui, Icon::Picture, "Save image");
    if ui.add_enabled(!panel.is_busy(), save).on_hover_text("Save an image (Ctrl+S)").clicked() {
        panel.wants_picture = true;
    }
}

/// Number of frames and their interval: for sequences and animations.
pub(crate) fn frames(interface: &mut Interface, ui: &mut Ui) {
    ui.strong("Frames over time");
    let panel = &mut interface.share;
    ui.horizontal_wrapped(|ui| {
        accessible::number(ui, DragValue::new(&mut panel.frames).range(1..=100_000), "Number of frames");
        ui.label("frames,");
        // At most a century.
        let step = DragValue::new(&mut panel.step_s).range(-3.2e9..=3.2e9).suffix(" s");
        accessible::number(ui, step, "Simulated seconds between frames");
        ui.label("apart");
    });
    if let Some(watch) = interface.events.playback_of_chosen() {
        let absolute_path =
            ui.button("Whole event").on_hover_text("As many seconds apart as the chosen event takes from its first frame to its last");
        if absolute_path.clicked() {
            panel.step_s = ((watch.to_tdb_s - watch.from_tdb_s) / f64::from(panel.frames.max(2) - 1)).round().max(1.0);
        }
    }
    let sequence = icons::button(ui, Icon::Save, "Export sequence");
    let hover = "Save each frame as an image of its own, from the shown time on, under the name above";
    if ui.add_enabled(!panel.is_busy(), sequence).on_hover_text(hover).clicked() {
        panel.wants = Some(Wanted::Sequence);
    }
}

pub(crate) fn animation(interface: &mut Interface, ui: &mut Ui) {
    ui.add_space(6.0);
    ui.strong("Animation");
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.animation.file).desired_width(150.0))
            .on_hover_text("Animation file: .gif (256 colours a frame) or .apng (every level). No file is replaced");
        dialog::button(interface, ui, FileField::Animation);
    });
    let panel = &mut interface.share;
    let animation = &mut panel.animation;
    ui.horizontal(|ui| {
        format_fields(
            ui,
            &mut animation.format,
            ["Width of the animation, pixels", "Height of the animation, pixels", "Labels in the animation"],
        );
    });
    ui.horizontal_wrapped(|ui| {
        accessible::number(ui, DragValue::new(&mut animation.rate).range(1..=100), "Frames a second");
        ui.label("a second");
        ui.checkbox(&mut animation.is_centred, "Around the shown time")
            .on_hover_text("Half of the frames come before the shown time; else all after it");
    });
    folder(ui, &animation.file);
    let record = icons::button(ui, Icon::Film, "Record animation");
    if ui.add_enabled(!panel.is_busy(), record).on_hover_text("Save the frames as one moving picture").clicked() {
        panel.wants = Some(Wanted::Animation);
    }
}

/// Progress of an export: bar, remaining time, button to stop it.
pub(crate) fn progress(interface: &mut Interface, ui: &mut Ui) {
    let now_s = interface.viewport.last_s;
    let Some(export) = &interface.share.export else { return };
    let cancelled = ui.horizontal_wrapped(|ui| {
        ui.add(ProgressBar::new(export.fraction()).desired_width(120.0).show_percentage()).accessible_name("Progress of the export");
        let cancel = icons::button(ui, Icon::Stop, "Cancel");
        let cancelled = ui.add(cancel).on_hover_text("Stop the export; frames of a sequence that are written stay").clicked();
        ui.label(export.progress_text(now_s));
        cancelled
    });
    if cancelled.inner {
        interface.share.export = None;
        interface.message = "The export was stopped".into();
    }
}
