//! Shows how far each pixel of the left image can be from the same image at reference quality: an error bound per pixel, as a colour. The largest bound
//! of each colour is twice that of the previous colour; the last colour stands for more than 32 of 255 levels.
//!
//! In: a request. Out: an image of the bounds and the fraction of pixels of each colour. Always: the bounds are those of `render --error`,
//! computed on the query worker (a background thread) and only while they are shown; while the view moves, the last computed bounds stay visible.

use super::pair;
use crate::measure::error_bounds;
use crate::scene::request::ViewRequest;
use crate::session::Session;
use crate::view::error_texts::error_text;
use crate::view::language::{decimal, text};
use crate::view::panels::accessible;
use crate::view::panels::render_loop::colour_image;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use crate::view::worker::session_inputs::SessionInputs;
use egui::{Color32, Sense, TextureHandle, TextureOptions, Ui, Vec2};

/// The colour of a range of bounds.
struct ColourStep {
    /// Largest bound of the range, 8-bit levels. The range starts above the largest bound of the previous step.
    max: u8,
    colour: Color32,
}

/// The steps, with ascending bounds. The colours go from dark to bright, so that colour-blind users can tell them apart.
const COLOUR_STEPS: [ColourStep; 7] = [
    ColourStep { max: 1, colour: Color32::from_rgb(20, 20, 60) },
    ColourStep { max: 2, colour: Color32::from_rgb(48, 45, 125) },
    ColourStep { max: 4, colour: Color32::from_rgb(115, 50, 140) },
    ColourStep { max: 8, colour: Color32::from_rgb(185, 65, 110) },
    ColourStep { max: 16, colour: Color32::from_rgb(230, 105, 70) },
    ColourStep { max: 32, colour: Color32::from_rgb(250, 175, 60) },
    ColourStep { max: 255, colour: Color32::from_rgb(252, 250, 190) },
];

/// Index of the colour of a bound, given in 8-bit levels.
fn colour_index(bound: u8) -> usize {
    COLOUR_STEPS.iter().position(|step| bound <= step.max).unwrap_or(COLOUR_STEPS.len() - 1)
}

/// The range of bounds of a colour in 8-bit levels, such as `3 to 4`, or `2` if the range contains only this bound.
fn range_text(colour_index: usize) -> String {
    let max = COLOUR_STEPS[colour_index].max;
    let Some(max_below) = colour_index.checked_sub(1).map(|k| COLOUR_STEPS[k].max) else { return text!("bound-up-to", max = max) };
    match max {
        u8::MAX => text!("bound-over", min = max_below),
        _ if max == max_below + 1 => max.to_string(),
        _ => text!("bound-range", min = max_below + 1, max = max),
    }
}

/// Error bounds of an image, in 8-bit levels.
pub(crate) struct ErrorBounds {
    /// Width and height of the image, pixels.
    width: u32,
    height: u32,
    /// Each pixel's bound as a colour.
    rgba: Vec<[u8; 4]>,
    /// Fraction of the pixels that have each colour.
    fractions: [f64; COLOUR_STEPS.len()],
    /// Mean of the bounds of all pixels.
    mean: f64,
    /// Largest bound of all pixels.
    max: u8,
}

impl ErrorBounds {
    /// `bounds`: for each pixel the bounds of red, green and blue, and an unused alpha. The bound of a pixel is the largest of the three.
    fn of(width: u32, height: u32, bounds: &[[u8; 4]]) -> Self {
        let (mut counts, mut sum, mut max) = ([0_usize; COLOUR_STEPS.len()], 0.0, 0);
        let rgba = bounds.iter().map(|pixel| {
            let pixel_bound = pixel[..3].iter().copied().max().unwrap_or(0);
            counts[colour_index(pixel_bound)] += 1;
            sum += f64::from(pixel_bound);
            max = max.max(pixel_bound);
            COLOUR_STEPS[colour_index(pixel_bound)].colour.to_array()
        });
        let rgba = rgba.collect();
        let pixel_count = bounds.len().max(1) as f64;
        Self { width, height, rgba, fractions: counts.map(|n| n as f64 / pixel_count), mean: sum / pixel_count, max }
    }
}

/// The displayed bounds, and those that are being computed for a newer request.
#[derive(Default)]
pub(crate) struct ErrorBoundView {
    /// The inputs of the newest bounds, displayed or pending.
    requested: Option<(ViewRequest, SessionInputs)>,
    pending: Option<Pending<Result<ErrorBounds, String>>>,
    displayed: Option<Result<(ErrorBounds, TextureHandle), String>>,
}

impl ErrorBoundView {
    /// For a change of language: drops an error and pending bounds, so that the bounds are computed again; see `ComparePanel::forget_failures`.
    pub(crate) fn forget_failures(&mut self) {
        let was_pending = self.pending.take().is_some();
        if self.displayed.take_if(|displayed| displayed.is_err()).is_some() || was_pending {
            self.requested = None;
        }
    }

    /// Shows an error, for tests.
    #[cfg(test)]
    pub(super) fn fail(&mut self, why: &str) {
        self.displayed = Some(Err(why.to_owned()));
    }

    /// Whether nothing is shown or pending, for tests.
    #[cfg(test)]
    pub(super) fn is_empty(&self) -> bool {
        self.displayed.is_none() && self.pending.is_none()
    }

    /// Starts to compute the bounds, unless a computation is running or the inputs are the same as for the last computation.
    pub(crate) fn compute_if_needed(&mut self, worker: &dyn RenderWorker, request: &ViewRequest) {
        let requested = Some((request.clone(), SessionInputs::of(worker.session())));
        if self.pending.is_some() || self.requested == requested {
            return;
        }
        self.requested = requested;
        let request = request.clone();
        self.pending = Some(ask(worker, move |session: &Session| {
            // This frame holds bounds instead of colours.
            let frame = error_bounds(session, &request).map_err(|e| error_text(&e))?;
            Ok(ErrorBounds::of(frame.width, frame.height, &frame.display))
        }));
    }

    /// Shows the last computed bounds. `image_name`: the name of the image to which they belong.
    pub(crate) fn show(&mut self, ui: &mut Ui, image_name: &str) {
        if let Some(computed) = self.pending.as_ref().and_then(Pending::take) {
            self.pending = None;
            self.displayed = Some(computed.map(|bounds| {
                let image = colour_image(bounds.width, bounds.height, bounds.rgba.clone());
                let texture = ui.ctx().load_texture("bounds", image, TextureOptions::NEAREST);
                (bounds, texture)
            }));
        }
        if self.pending.is_some() {
            ui.horizontal(|ui| {
                accessible::spinner(ui, text!("bound-coming"));
                ui.weak(text!("bound-coming-label"));
            });
        }
        match &self.displayed {
            Some(Ok((bounds, texture))) => {
                legend(ui, bounds);
                let size = Vec2::new(bounds.width as f32, bounds.height as f32);
                pair::image(ui, texture.id(), size, &text!("bound-image", name = image_name));
                ui.label(text!("bound-statistics", mean = decimal(bounds.mean, 1), max = bounds.max));
            }
            Some(Err(why)) => drop(ui.colored_label(ui.visuals().error_fg_color, why)),
            None => {}
        }
    }
}

/// Shows each colour with its range of bounds and its fraction of the pixels.
fn legend(ui: &mut Ui, bounds: &ErrorBounds) {
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("bound-legend"));
        for (k, step) in COLOUR_STEPS.iter().enumerate() {
            let (rect, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, step.colour);
            ui.label(text!("bound-fraction", range = range_text(k), percent = decimal(100.0 * bounds.fractions[k], 1)));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_colour_covers_twice_the_bound_of_the_last_and_fractions_sum_to_one() {
        assert_eq!([0, 1, 2, 3, 4, 5, 32, 33, 255].map(colour_index), [0, 0, 1, 2, 2, 3, 5, 6, 6]);
        assert_eq!([0, 1, 2, 6].map(range_text), ["up to 1", "2", "3 to 4", "over 32"]);
        let bounds = ErrorBounds::of(2, 2, &[[1, 0, 0, 255], [0, 9, 3, 255], [0, 0, 40, 255], [1, 1, 1, 255]]);
        assert!((bounds.fractions.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!((bounds.fractions[0], bounds.max, bounds.mean), (0.5, 40, 12.75));
        let brightness = |c: &Color32| u32::from(c.r()) * 3 + u32::from(c.g()) * 6 + u32::from(c.b());
        assert!(COLOUR_STEPS.windows(2).all(|pair| brightness(&pair[0].colour) < brightness(&pair[1].colour)));
    }
}
