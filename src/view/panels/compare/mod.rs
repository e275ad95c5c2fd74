//! The Compare panel: the current view drawn in two variants, which may differ in quality, effects, pixel view and renderer.
//!
//! In: the view, two variants. Out: their images, the difference and statistics, or bounds of the left image's difference from reference quality
//! (`bound`). Always: the two images differ only in what the variants set; they are drawn on the query worker (a background thread) once the view is at
//! rest; until a new pair has been drawn, the last one stays visible, with the names of its own variants.

mod bound;
pub mod pair;

use self::bound::ErrorBoundView;
use self::pair::{ComparedImage, Pair, PairView};
use super::{Interface, accessible};
use crate::image::DisplayImage;
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::draw::PixelView;
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{Quality, ViewRequest};
use crate::session::Session;
use crate::view::app::view_state::ViewState;
use crate::view::error_texts::error_text;
use crate::view::language::{text, text_by_id, translated_name};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use crate::view::worker::session_inputs::SessionInputs;
use egui::{ComboBox, TextEdit};
use std::sync::Arc;
use std::time::Instant as WallInstant;

/// The renderer of a variant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Renderer {
    /// The renderer of the window.
    #[default]
    Window,
    Software,
    /// The software renderer, in f64.
    SoftwareF64,
}

impl Renderer {
    /// Each renderer, with the message id of its name.
    const ALL: [(Self, &'static str); 3] =
        [(Self::Window, "variant-window"), (Self::Software, "variant-f32"), (Self::SoftwareF64, "variant-f64")];

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(r, _)| *r == self).map_or("", |(_, name)| text_by_id(name))
    }
}

/// One variant of the view.
#[derive(Clone, Debug, Default, PartialEq)]
struct Variant {
    quality: Quality,
    /// Effect overrides as typed, in the syntax of `--effects`; they apply after the view's own overrides.
    effects: String,
    pixel_view: PixelView,
    renderer: Renderer,
}

/// Everything on which a pair of images depends.
#[derive(Clone, PartialEq)]
struct ComparisonInput {
    /// The request for the view, before the variants change it.
    request: ViewRequest,
    /// The left and the right variant.
    variants: [Variant; 2],
    /// The view's own effect overrides. Those of `request`, which is that of the last image, may be older and are not used.
    view_effects: EffectOverrides,
    /// The state of the session on which the images depend besides the requests, such as the shader fragments.
    session_inputs: SessionInputs,
}

impl ComparisonInput {
    /// The request of the variant with this index: 0 is left, 1 is right.
    fn request_of(&self, index: usize) -> Result<ViewRequest, String> {
        let variant = &self.variants[index];
        let text = format!("{},{}", self.view_effects.to_text(), variant.effects);
        let effects = EffectOverrides::parse(&text).map_err(|e| error_text(&e))?;
        Ok(ViewRequest { effects, quality: variant.quality, pixel_view: variant.pixel_view, ..self.request.clone() })
    }

    /// Whether two inputs are equal, except that the image sizes may differ slightly: a new line of text in the panel leaves less space for the images.
    fn is_close_to(&self, other: &Self) -> bool {
        const TOLERANCE_PX: u32 = 32;
        let (a, b) = (&self.request, &other.request);
        let has_similar_size = a.width.abs_diff(b.width) < TOLERANCE_PX && a.height.abs_diff(b.height) < TOLERANCE_PX;
        let request = ViewRequest { width: a.width, height: a.height, ..b.clone() };
        has_similar_size && *self == Self { request, ..other.clone() }
    }
}

/// A drawn pair, and what it was drawn from.
struct DrawnPair {
    pair: Arc<Pair>,
    input: ComparisonInput,
}

/// Minimum width for the controls of the two variants beside each other, points; in a narrower panel they are below each other.
const MIN_WIDTH_FOR_COLUMNS: f32 = 520.0;

/// State of the Compare panel.
#[derive(Default)]
pub(crate) struct ComparePanel {
    /// The variants as set by the user; `None` until the panel is first shown.
    variants: Option<[Variant; 2]>,
    /// The input of the newest pair, displayed or pending.
    input: Option<ComparisonInput>,
    pending: Option<Pending<Result<DrawnPair, String>>>,
    /// The displayed pair, or why it could not be drawn.
    drawn_pair: Option<Result<DrawnPair, String>>,
    pair_view: PairView,
    /// Bounds of the left image's difference from reference quality.
    error_bound_view: ErrorBoundView,
}

/// The initial variants. Left: the view itself. Right: the view in draft quality, or in reference quality if the view itself is a draft.
fn initial_variants(view: &ViewState) -> [Variant; 2] {
    let as_seen = Variant { quality: view.quality, pixel_view: view.pixel_view, ..Variant::default() };
    let quality = if view.quality == Quality::Draft { Quality::Reference } else { Quality::Draft };
    [as_seen.clone(), Variant { quality, ..as_seen }]
}

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
    let mut panel = std::mem::take(&mut interface.compare);
    panel.show(interface, ui, worker);
    interface.compare = panel;
}

impl ComparePanel {
    /// For a change of language: drops errors, whose texts are in the previous language, and pending images, which may become such errors. All of these are
    /// drawn again.
    pub(crate) fn forget_failures(&mut self) {
        let was_pending = self.pending.take().is_some();
        if self.drawn_pair.take_if(|drawn| drawn.is_err()).is_some() || was_pending {
            self.input = None;
        }
        self.error_bound_view.forget_failures();
    }

    /// Takes a finished pair, shows the controls of the variants and the last pair, and starts to draw a new pair if needed.
    fn show(&mut self, interface: &Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
        if let Some(drawn) = self.pending.as_ref().and_then(Pending::take) {
            self.pending = None;
            self.drawn_pair = Some(drawn);
        }
        let view = &interface.viewer.view;
        let mut variants = self.variants.take().unwrap_or_else(|| initial_variants(view));
        let sides = [text!("compare-left"), text!("compare-right")];
        if ui.available_width() >= MIN_WIDTH_FOR_COLUMNS {
            ui.columns(2, |columns| {
                for ((ui, variant), side) in columns.iter_mut().zip(&mut variants).zip(sides) {
                    variant_controls(ui, variant, side);
                }
            });
        } else {
            variants.iter_mut().zip(sides).for_each(|(variant, side)| variant_controls(ui, variant, side));
        }
        let mut swapped = false;
        ui.horizontal(|ui| {
            swapped = ui.button(text!("compare-swap")).on_hover_text(text!("compare-swap-hint")).clicked();
            if ui.button(text!("compare-reset")).on_hover_text(text!("compare-reset-hint")).clicked() {
                variants = initial_variants(view);
            }
            if self.pending.is_some() {
                accessible::spinner(ui, text!("compare-coming"));
                ui.weak(text!("compare-coming-label"));
            }
        });
        if swapped {
            variants.swap(0, 1);
        }
        ui.separator();
        let syntax_error = variants.iter().zip(sides).find_map(|(variant, side)| {
            let e = EffectOverrides::parse(&variant.effects).err()?;
            Some(format!("{side}: {}", error_text(&e)))
        });
        if let Some(syntax_error) = syntax_error {
            ui.colored_label(ui.visuals().warn_fg_color, syntax_error);
        } else {
            self.draw_if_needed(interface, ui, worker, &variants);
        }
        match &self.drawn_pair {
            Some(Ok(DrawnPair { pair, input })) => {
                let names = [variant_text(&input.variants[0]), variant_text(&input.variants[1])];
                // While a new pair is being drawn, the spinner above says so.
                if input.variants != variants && self.pending.is_none() {
                    ui.colored_label(ui.visuals().warn_fg_color, text!("compare-of-last", left = names[0], right = names[1]));
                }
                if let Some(request) = input.request_of(0).ok().filter(|_| self.pair_view.shows_error_bounds()) {
                    self.error_bound_view.compute_if_needed(worker, &request);
                }
                self.pair_view.show(ui, pair, [&names[0], &names[1]], Some(&mut |ui, name| self.error_bound_view.show(ui, name)));
            }
            Some(Err(why)) => drop(ui.colored_label(ui.visuals().error_fg_color, why)),
            None => drop(ui.weak(text!("compare-waits"))),
        }
        self.variants = Some(variants);
    }

    /// Starts to draw both variants if the view is at rest, unless their images exist or are being drawn.
    fn draw_if_needed(&mut self, interface: &Interface, ui: &egui::Ui, worker: &dyn RenderWorker, variants: &[Variant; 2]) {
        let Some(rendered) = interface.shown() else { return };
        let quality = interface.viewer.view.quality;
        let is_at_rest = rendered.job.request.quality == quality && rendered.job.sampling == SamplingQuality::of(quality);
        if self.pending.is_some() || !is_at_rest || interface.viewer.is_animating() {
            return;
        }
        let input = ComparisonInput {
            request: fitted_request(&rendered.job.request, ui),
            variants: variants.clone(),
            view_effects: interface.viewer.view.effects.clone(),
            session_inputs: SessionInputs::of(worker.session()),
        };
        if self.input.as_ref().is_some_and(|last| last.is_close_to(&input)) {
            return;
        }
        self.input = Some(input.clone());
        self.pending = Some(ask(worker, move |session| {
            let [left, right] = [0, 1].map(|k| draw(session, &input.request_of(k)?, &input.variants[k]));
            Ok(DrawnPair { pair: Arc::new(Pair::of(left, right)?), input })
        }));
        // The worker of the tests runs a task at once, so the images may have arrived; the next frame takes them.
        ui.ctx().request_repaint();
    }
}

/// Maximum length of the longer side of a compared image, pixels.
const MAX_SIDE_PX: f32 = 1024.0;

/// The request for an image that fits the panel and has the aspect ratio of the viewport.
fn fitted_request(request: &ViewRequest, ui: &egui::Ui) -> ViewRequest {
    let [width, height] = [request.width, request.height].map(|length| length.max(1) as f32);
    let size_px = pair::fitted(ui, egui::Vec2::new(width, height)) * ui.ctx().pixels_per_point();
    // One factor for both sides keeps the aspect ratio.
    let size_px = size_px * (MAX_SIDE_PX / size_px.max_elem()).min(1.0);
    let [width, height] = [size_px.x, size_px.y].map(|length| length.round().max(1.0) as u32);
    ViewRequest { width, height, ..request.clone() }
}

/// Shows the controls of one variant. `side`: *Left* or *Right*, in the interface's language.
fn variant_controls(ui: &mut egui::Ui, variant: &mut Variant, side: &str) {
    ui.strong(side);
    ui.horizontal(|ui| {
        for quality in Quality::ALL {
            let hover = text!("compare-quality-hint", side = side, quality = translated_name("quality", quality.name()));
            ui.selectable_value(&mut variant.quality, quality, translated_name("quality", quality.name())).on_hover_text(hover);
        }
    });
    ui.horizontal(|ui| {
        ui.label(text!("effects-show"));
        accessible::pixel_view_list(ui, &mut variant.pixel_view, &text!("compare-show", side = side));
    });
    ui.horizontal(|ui| {
        let list = ComboBox::new((side, "renderer"), text!("compare-renderer"))
            .width(150.0)
            .selected_text(variant.renderer.name())
            .show_ui(ui, |ui| {
                for (renderer, name) in Renderer::ALL {
                    ui.selectable_value(&mut variant.renderer, renderer, text_by_id(name));
                }
            });
        list.response.on_hover_text(text!("compare-renderer-of", side = side));
    });
    let field = TextEdit::singleline(&mut variant.effects).hint_text("+eclipse=linear,-normal").desired_width(f32::INFINITY);
    let name = text!("compare-effects-hint", side = side);
    ui.add(field).accessible_name(&name).on_hover_text(name);
}

/// A short description of a variant, such as `draft depth`.
fn variant_text(variant: &Variant) -> String {
    let mut words = vec![translated_name("quality", variant.quality.name())];
    words.extend((variant.pixel_view != PixelView::Final).then(|| accessible::pixel_view_name(variant.pixel_view)));
    words.extend((!variant.effects.trim().is_empty()).then_some(variant.effects.trim()));
    words.extend((variant.renderer != Renderer::Window).then_some(variant.renderer.name()));
    words.join(" ")
}

/// Draws a variant and measures the time that drawing takes.
///
/// # Errors
/// The text of the session's or renderer's error, in the window's language.
fn draw(session: &Session, request: &ViewRequest, variant: &Variant) -> Result<ComparedImage, String> {
    let sampling = SamplingQuality::of(request.quality);
    let to_text = |e: crate::session::SessionError| error_text(&e);
    // This first plan loads modules and maps, so that the measured time does not include loading.
    session.plan(request, sampling).map_err(to_text)?;
    let in_f64 = true;
    let f64_renderer =
        if variant.renderer == Renderer::SoftwareF64 { Some(session.renderer_in(in_f64).map_err(|e| error_text(&e))?) } else { None };
    let start = WallInstant::now();
    let (frame, renderer_name) = if variant.renderer == Renderer::Window {
        // By the GPU, if the window uses it; otherwise by the software renderer for queries, as below.
        let drawn = session.draw_in_background(request, sampling, FrameImages::Display).map_err(to_text)?;
        (drawn.frame, drawn.drawn_by.renderer)
    } else {
        let (_, plan) = session.plan(request, sampling).map_err(to_text)?;
        let renderer = f64_renderer.as_ref().unwrap_or(session.background_renderer());
        let (frame, _) = renderer.render(&plan, session.library(), FrameImages::Display).map_err(|e| error_text(&e))?;
        (frame, "software")
    };
    let took_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok(ComparedImage {
        image: DisplayImage { width: frame.width, height: frame.height, rgba: frame.display },
        renderer: renderer_name.to_owned(),
        took_ms,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_in_the_previous_language_is_dropped() {
        let mut panel = ComparePanel { drawn_pair: Some(Err("why".into())), pending: Some(Pending::default()), ..ComparePanel::default() };
        panel.error_bound_view.fail("why");
        panel.forget_failures();
        assert!(panel.drawn_pair.is_none() && panel.pending.is_none() && panel.error_bound_view.is_empty());
    }
}
