//! Display of two images of the same size: side by side, split by a line, or as their difference, with statistics.
//!
//! In: drawn images. Out: egui shapes. Always: images, difference and statistics belong to the same pair; differences are between 8-bit display values,
//! as in `orrery compare`.

use crate::image::{self, DisplayImage};
use crate::view::error_texts::error_text;
use crate::view::language::{decimal, text, text_by_id, translated_name};
use crate::view::panels::render_loop::colour_image;
use crate::view::panels::theme::{BODY_TEXT_POINTS, HIGHLIGHT_COLOUR};
use egui::{Color32, Pos2, Rect, Sense, Slider, Stroke, TextureHandle, TextureOptions, Vec2, pos2};
use std::sync::Arc;

/// One drawn image.
pub(crate) struct ComparedImage {
    pub image: DisplayImage,
    /// Name of the renderer that drew the image, as in the messages `renderer-…`.
    pub renderer: String,
    /// Time that drawing the image took.
    pub took_ms: f64,
}

/// Two images and their difference.
pub(crate) struct Pair {
    /// The left and the right image.
    pub images: [ComparedImage; 2],
    pub statistics: image::Difference,
    /// The difference as an image.
    pub difference: DisplayImage,
}

impl Pair {
    /// Compares two drawn images.
    ///
    /// # Errors
    /// If an image could not be drawn, or the sizes differ.
    pub(crate) fn of(left: Result<ComparedImage, String>, right: Result<ComparedImage, String>) -> Result<Self, String> {
        let left = left.map_err(|e| text!("pair-left-failed", e = e))?;
        let right = right.map_err(|e| text!("pair-right-failed", e = e))?;
        let statistics = left.image.difference(&right.image).map_err(|e| error_text(&e))?;
        let difference = left.image.difference_image(&right.image).map_err(|e| error_text(&e))?;
        Ok(Self { images: [left, right], statistics, difference })
    }
}

/// How a pair is displayed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum DisplayMode {
    #[default]
    Split,
    SideBySide,
    Difference,
    /// The error bounds of the left image.
    ErrorBounds,
}

impl DisplayMode {
    /// Each mode, with the message ids of its name and its tooltip.
    const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Split, "pair-split", "pair-split-hint"),
        (Self::SideBySide, "pair-beside", "pair-beside-hint"),
        (Self::Difference, "pair-difference", "pair-difference-hint"),
        (Self::ErrorBounds, "pair-bound", "pair-bound-hint"),
    ];
}

/// A function that shows the error bounds of an image; its argument is the image's name.
pub(crate) type ShowErrorBounds<'a> = &'a mut dyn FnMut(&mut egui::Ui, &str);

/// State of the display of a pair.
#[derive(Default)]
pub(crate) struct PairView {
    /// The pair whose images the textures hold.
    loaded: Option<Arc<Pair>>,
    /// The left image, the right image and their difference; empty before the first pair.
    textures: Vec<TextureHandle>,
    mode: DisplayMode,
    /// Position of the divider: the fraction of the width that shows the left image. `None`: a half.
    split: Option<f32>,
}

/// Height of the buttons above and the statistics below an image, points.
const CONTROLS_HEIGHT: f32 = 70.0;
/// Height up to which an image is not reduced to fit the panel, points: in a lower panel the user scrolls.
const ALWAYS_ALLOWED_HEIGHT: f32 = 330.0;
/// Distance of a name from the divider and from the image's edge, points.
const NAME_DISTANCE: f32 = 6.0;
/// Least width of a part of the image in which its name is shown, without the distances, points.
const MIN_NAME_WIDTH: f32 = 40.0;
/// Texture coordinates of the entire image.
const FULL_UV: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

impl PairView {
    /// Whether error bounds are shown instead of the images.
    pub(crate) fn shows_error_bounds(&self) -> bool {
        self.mode == DisplayMode::ErrorBounds
    }

    /// Shows a pair. `names`: the names of the left and the right image. `show_error_bounds`: shows the error bounds of the left image; with `None`, the user
    /// cannot choose the bounds.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, pair: &Arc<Pair>, names: [&str; 2], show_error_bounds: Option<ShowErrorBounds<'_>>) {
        self.load_textures(ui.ctx(), pair);
        let is_available = |mode: DisplayMode| show_error_bounds.is_some() || mode != DisplayMode::ErrorBounds;
        ui.horizontal(|ui| {
            for (mode, name, hint) in DisplayMode::ALL.into_iter().filter(|(mode, ..)| is_available(*mode)) {
                ui.selectable_value(&mut self.mode, mode, text_by_id(name)).on_hover_text(text_by_id(hint));
            }
            if self.mode == DisplayMode::Split {
                let split = self.split.get_or_insert(0.5);
                ui.add(Slider::new(split, 0.0..=1.0).show_value(false).text(text!("pair-divider")))
                    .on_hover_text(text!("pair-divider-hint"));
            }
        });
        let [left, right] = names;
        let size = Vec2::new(pair.difference.width as f32, pair.difference.height as f32);
        let [left_texture, right_texture, difference] = &self.textures[..] else { return };
        let (textures, difference) = ([left_texture.id(), right_texture.id()], difference.id());
        match self.mode {
            DisplayMode::Split => self.show_split(ui, size, textures, names),
            DisplayMode::SideBySide => {
                ui.columns(2, |columns| {
                    for ((ui, texture), name) in columns.iter_mut().zip(textures).zip([left, right]) {
                        image(ui, texture, size, name);
                        ui.weak(name);
                    }
                });
            }
            DisplayMode::ErrorBounds => return show_error_bounds.map_or((), |show| show(ui, left)),
            DisplayMode::Difference => image(ui, difference, size, &text!("pair-difference-of", left = left, right = right)),
        }
        statistics(ui, pair);
    }

    /// Loads the images of a pair as textures, unless the last call loaded the same pair.
    fn load_textures(&mut self, ctx: &egui::Context, pair: &Arc<Pair>) {
        if self.loaded.as_ref().is_some_and(|loaded| Arc::ptr_eq(loaded, pair)) {
            return;
        }
        let load = |image: &DisplayImage| {
            ctx.load_texture("pair", colour_image(image.width, image.height, image.rgba.clone()), TextureOptions::LINEAR)
        };
        let [left, right] = &pair.images;
        self.textures = vec![load(&left.image), load(&right.image), load(&pair.difference)];
        self.loaded = Some(Arc::clone(pair));
    }

    /// Shows the left image to the left of the divider, and the right image to its right. A click or drag moves the divider.
    fn show_split(&mut self, ui: &mut egui::Ui, size: Vec2, textures: [egui::TextureId; 2], [left, right]: [&str; 2]) {
        let (rect, response) = ui.allocate_exact_size(fitted(ui, size), Sense::click_and_drag());
        let label = text!("pair-split-of", left = left, right = right);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
        if let Some(pointer) = response.interact_pointer_pos() {
            self.split = Some(((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0));
        }
        let split = self.split.unwrap_or(0.5);
        let divider_x = rect.left() + split * rect.width();
        // The part of the image between two fractions of its width: its rectangle on the screen and its texture coordinates.
        let part = |start: f32, end: f32| {
            let place = Rect::from_min_max(
                pos2(rect.left() + start * rect.width(), rect.top()),
                pos2(rect.left() + end * rect.width(), rect.bottom()),
            );
            (place, Rect::from_min_max(pos2(start, 0.0), pos2(end, 1.0)))
        };
        for (texture, (place, uv)) in textures.into_iter().zip([part(0.0, split), part(split, 1.0)]) {
            ui.painter().image(texture, place, uv, Color32::WHITE);
        }
        ui.painter().line_segment([pos2(divider_x, rect.top()), pos2(divider_x, rect.bottom())], Stroke::new(1.5, HIGHLIGHT_COLOUR));
        let painter = ui.painter().with_clip_rect(rect);
        let font = egui::FontId::proportional(BODY_TEXT_POINTS);
        let sides = [
            (-NAME_DISTANCE, egui::Align2::RIGHT_TOP, left, divider_x - rect.left()),
            (NAME_DISTANCE, egui::Align2::LEFT_TOP, right, rect.right() - divider_x),
        ];
        for (offset_points, align, name, part_width) in sides {
            // A name that is longer than its part of the image wraps.
            let width = part_width - 2.0 * NAME_DISTANCE;
            if width < MIN_NAME_WIDTH {
                continue;
            }
            // The name has a dark background, since the image below may be white.
            let galley = painter.layout(name.to_owned(), font.clone(), Color32::from_gray(230), width);
            let place = align.anchor_size(pos2(divider_x + offset_points, rect.top() + 4.0), galley.size());
            painter.rect_filled(place.expand(2.0), 2.0, Color32::from_black_alpha(190));
            painter.galley(place.min, galley, Color32::PLACEHOLDER);
        }
    }
}

/// The size in points at which an image of `size` pixels is shown: scaled to the panel's width, or to the panel's height if the image would otherwise
/// be higher than the panel and than [`ALWAYS_ALLOWED_HEIGHT`]. The aspect ratio stays.
pub(crate) fn fitted(ui: &egui::Ui, size: Vec2) -> Vec2 {
    let width = ui.available_width();
    let max_height = (ui.available_height() - CONTROLS_HEIGHT).max(ALWAYS_ALLOWED_HEIGHT);
    let scale = (width / size.x.max(1.0)).min(max_height / size.y.max(1.0));
    size * scale
}

/// Shows an image of `size` pixels, scaled as by [`fitted`], with an accessible name.
pub(crate) fn image(ui: &mut egui::Ui, texture: egui::TextureId, size: Vec2, name: &str) {
    let size = fitted(ui, size);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    // In a column, egui widens the allocated rectangle to the column; the image keeps its size in the middle.
    ui.painter().image(texture, Rect::from_center_size(rect.center(), size), FULL_UV, Color32::WHITE);
}

/// The statistics of the difference in one line, and the size and drawing times of the images in another.
pub(crate) fn statistics_text(pair: &Pair) -> [String; 2] {
    let statistics = &pair.statistics;
    let psnr = statistics.psnr_db.map_or(text!("pair-infinite").to_owned(), |db| format!("{} dB", decimal(db, 2)));
    let [left, right] = &pair.images;
    [
        text!("pair-statistics", mean = decimal(statistics.mean, 4), p999 = statistics.p999, max = statistics.max, psnr = psnr),
        text!(
            "pair-times",
            width = pair.difference.width,
            height = pair.difference.height,
            left = decimal(left.took_ms, 1),
            left_by = translated_name("renderer", &left.renderer),
            right = decimal(right.took_ms, 1),
            right_by = translated_name("renderer", &right.renderer)
        ),
    ]
}

/// Shows the lines of [`statistics_text`].
fn statistics(ui: &mut egui::Ui, pair: &Pair) {
    for line in statistics_text(pair) {
        ui.label(line);
    }
}
