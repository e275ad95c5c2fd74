//! The controls of the Share panel for images, sequences of images and animations.
//!
//! In: the panel's settings. Out: changed settings, and a request for an export, which the panel starts. Always: no export can be requested while another
//! is running.

use super::dialog::{self, FileField};
use super::export::ImageOptions;
use super::{ExportKind, Interface};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::event_view::EventPlayback;
use crate::view::app::file_names::absolute_path;
use crate::view::language::{decimal, text};
use crate::view::panels::icons::{self, Icon};
use crate::view::panels::number_field::{self, NumberKind};
use egui::{Checkbox, Label, ProgressBar, RichText, TextEdit, Ui};
use std::path::Path;

/// Greatest time between frames: about a century.
const MAX_STEP_S: f64 = 36_500.0 * SECONDS_PER_DAY;

/// Shows a field for a width or height, pixels.
fn side_field(ui: &mut Ui, side_px: &mut u32, name: &str) {
    number_field::show(ui, side_px, NumberKind::Whole, 1..=MAX_IMAGE_PX, name, |field| field);
}

/// Shows the fields for width, height and labels. The array contains their accessible names, in this order.
fn option_fields(ui: &mut Ui, options: &mut ImageOptions, [width, height, labels]: [&str; 3]) {
    side_field(ui, &mut options.size_px[0], width);
    ui.label("×");
    side_field(ui, &mut options.size_px[1], height);
    let checkbox = ui.checkbox(&mut options.has_labels, text!("image-labels")).accessible_name(labels);
    checkbox.on_hover_text(text!("image-labels-hint"));
}

/// Shows the folder to which a file will be written.
fn folder(ui: &mut Ui, file: &str) {
    // An empty name has no absolute path.
    let path = absolute_path(&Path::new(".").join(file));
    let folder = path.rsplit_once(std::path::MAIN_SEPARATOR).map_or("", |(folder, _)| folder);
    ui.add(Label::new(RichText::new(text!("image-folder", folder = folder)).small().weak()).truncate());
}

/// Shows the controls that save one image.
pub(crate) fn single_image(interface: &mut Interface, ui: &mut Ui) {
    ui.strong(text!("images"));
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.image_file_name).desired_width(150.0)).on_hover_text(text!("images-file-hint"));
        dialog::button(interface, ui, FileField::Image);
    });
    let panel = &mut interface.share;
    ui.horizontal(|ui| option_fields(ui, &mut panel.image_options, [text!("image-width"), text!("image-height"), text!("image-labels")]));
    folder(ui, &panel.image_file_name);
    let save = icons::button(ui, Icon::Image, text!("images-save"));
    if ui.add_enabled(!panel.is_busy(), save).on_hover_text(text!("images-save-hint")).clicked() {
        panel.wants_image = true;
    }
}

/// The playback of the chosen event, whose frames an export can have; `None` unless the displayed time is near the event.
fn playback_near_view(interface: &Interface) -> Option<EventPlayback> {
    let view = interface.viewer.view_after_flight();
    // At the observer's place an event may be shorter than for the entire Earth.
    let playback = interface.events.playback_of_chosen(&view.camera_pose, interface.information.observer_place)?;
    playback.is_near(view.tdb_s).then_some(playback)
}

/// As [`playback_near_view`], if the user wants the frames to span the event.
pub(super) fn chosen_playback(interface: &Interface) -> Option<EventPlayback> {
    playback_near_view(interface).filter(|_| interface.share.wants_event_span)
}

/// The time between the frames of a playback, such as `160.2 s`, or from the slow part to the rest: `5.1 to 160.2 s`.
fn interval_text(playback: &EventPlayback, frame_count: u32) -> String {
    let real_s = playback.length_s() / f64::from(frame_count.max(2) - 1);
    let longest = decimal(playback.rate * real_s, 1);
    match playback.slow_part {
        Some(slow) => text!("frames-event-steps", shortest = decimal(slow.rate * real_s, 1), longest = longest),
        None => format!("{longest} s"),
    }
}

/// Shows the button that exports a sequence, and the fields for the number of frames and their interval, which also apply to animations.
pub(crate) fn frames(interface: &mut Interface, ui: &mut Ui) {
    ui.strong(text!("frames"));
    let is_near_event = playback_near_view(interface).is_some();
    let event_playback = chosen_playback(interface);
    let panel = &mut interface.share;
    ui.horizontal_wrapped(|ui| {
        number_field::show(ui, &mut panel.frame_count, NumberKind::Whole, 1..=100_000, text!("frames-count"), |field| field);
        ui.label(text!("frames-unit"));
        if let Some(playback) = &event_playback {
            ui.label(interval_text(playback, panel.frame_count)).on_hover_text(text!("frames-step"));
        } else {
            let range = -MAX_STEP_S..=MAX_STEP_S;
            number_field::show(ui, &mut panel.step_s, NumberKind::Seconds, range, text!("frames-step"), |field| field);
        }
        ui.label(text!("frames-apart"));
    });
    if is_near_event {
        ui.checkbox(&mut panel.wants_event_span, text!("frames-whole-event")).on_hover_text(text!("frames-whole-event-hint"));
    }
    let sequence = icons::button(ui, Icon::Save, text!("frames-export"));
    let hover = text!("frames-export-hint");
    if ui.add_enabled(!panel.is_busy(), sequence).on_hover_text(hover).clicked() {
        panel.requested_export = Some(ExportKind::Sequence);
    }
}

/// Shows the controls that record an animation.
pub(crate) fn animation(interface: &mut Interface, ui: &mut Ui) {
    ui.add_space(6.0);
    ui.strong(text!("animation"));
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.animation.file_name).desired_width(150.0))
            .on_hover_text(text!("animation-file-hint"));
        dialog::button(interface, ui, FileField::Animation);
    });
    let frames_span_event = chosen_playback(interface).is_some();
    let panel = &mut interface.share;
    let animation = &mut panel.animation;
    ui.horizontal(|ui| {
        option_fields(ui, &mut animation.options, [text!("animation-width"), text!("animation-height"), text!("animation-labels")]);
    });
    ui.horizontal_wrapped(|ui| {
        number_field::show(ui, &mut animation.frames_per_s, NumberKind::Whole, 1..=100, text!("animation-rate"), |field| field);
        ui.label(text!("animation-rate-unit"));
        let centred = Checkbox::new(&mut animation.is_centred_on_displayed_time, text!("animation-centred"));
        ui.add_enabled(!frames_span_event, centred).on_hover_text(text!("animation-centred-hint"));
    });
    folder(ui, &animation.file_name);
    let record = icons::button(ui, Icon::Film, text!("animation-record"));
    if ui.add_enabled(!panel.is_busy(), record).on_hover_text(text!("animation-record-hint")).clicked() {
        panel.requested_export = Some(ExportKind::Animation);
    }
}

/// Shows the progress of an export: a bar, the remaining time, and a button that stops it.
pub(crate) fn progress(interface: &mut Interface, ui: &mut Ui) {
    let now_s = interface.viewport.frame_start_s;
    let Some(export) = &interface.share.export else { return };
    let is_cancelled = ui
        .horizontal(|ui| {
            ui.add(ProgressBar::new(export.fraction()).desired_width(120.0).show_percentage()).accessible_name(text!("export-bar"));
            let cancel = icons::button(ui, Icon::Stop, text!("export-cancel"));
            ui.add(cancel).on_hover_text(text!("export-cancel-hint")).clicked()
        })
        .inner;
    ui.label(export.progress_text(now_s));
    if is_cancelled {
        interface.share.export = None;
        interface.show_reply(text!("export-stopped"));
    }
}
