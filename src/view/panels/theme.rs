//! Colours, text sizes and spacing of the panels, for each theme.
//!
//! In: a theme (dark or light). Out: egui styles and fonts, and the pointer action that takes the focus from a text field; widths of texts. Always: the
//! contrast ratio of text to its background is at least 4.5 (WCAG 2.2, level AA); `tests/view/contrast` measures the ratio on the painted output. Not here:
//! the colours of names in images (`scene::labels`) and of source code (`shader::module_text`), and red light for the night (`window::night_colours`).

use super::icons;
use crate::scene::labels::SELECTED_COLOUR;
use crate::view::language::numbers::field_text;
use egui::style::NumberFormatter;
use egui::{Color32, Context, FontFamily, FontId, Style, SurrenderFocusOn, TextStyle, Theme, Ui, Visuals, vec2};

/// Text size of captions, points.
pub(crate) const SMALL_TEXT_POINTS: f32 = 11.0;
/// Text size of source code, points.
pub(crate) const CODE_TEXT_POINTS: f32 = 12.0;
/// Text size of labels, buttons and values, points.
pub(crate) const BODY_TEXT_POINTS: f32 = 13.0;
/// Text size of headings, points.
pub(crate) const HEADING_TEXT_POINTS: f32 = 18.0;

/// Minimum height of a list that scrolls below other controls of a panel, points. A panel with less room for it scrolls as a whole.
pub(crate) const MIN_LIST_HEIGHT: f32 = 120.0;

/// Colour of marks over images and drawings: that of the selected body's name and outline in images.
pub(crate) const HIGHLIGHT_COLOUR: Color32 = opaque(SELECTED_COLOUR);

/// An opaque colour of these sRGB bytes.
pub(crate) const fn opaque([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Sets the styles of both themes and the fonts of an egui context. A text field loses the focus when the pointer is pressed elsewhere, not at the release: the
/// release may be a click on a button that hides the field, and by then the field must have read its text.
pub(crate) fn apply(ctx: &Context) {
    ctx.set_fonts(icons::fonts());
    ctx.options_mut(|options| options.input_options.surrender_focus_on = SurrenderFocusOn::Presses);
    for theme in [Theme::Dark, Theme::Light] {
        ctx.set_style_of(theme, style(theme));
    }
}

/// The style of menus: egui's own, except that the entry with the keyboard focus keeps its ring. Without it a chosen entry would look the same with the
/// focus as without.
pub(crate) fn menu_style(style: &mut Style) {
    let ring = style.visuals.widgets.active.bg_stroke;
    egui::containers::menu::menu_style(style);
    style.visuals.widgets.active.bg_stroke = ring;
}

/// Width of a text in the font of labels and fields, points.
pub(crate) fn text_width(ui: &Ui, text: String) -> f32 {
    ui.painter().layout_no_wrap(text, TextStyle::Body.resolve(ui.style()), Color32::PLACEHOLDER).size().x
}

fn style(theme: Theme) -> Style {
    let mut style = Style { visuals: visuals(theme), ..Style::default() };
    let proportional = |size| FontId::new(size, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, proportional(SMALL_TEXT_POINTS)),
        (TextStyle::Body, proportional(BODY_TEXT_POINTS)),
        (TextStyle::Button, proportional(BODY_TEXT_POINTS)),
        (TextStyle::Heading, proportional(HEADING_TEXT_POINTS)),
        (TextStyle::Monospace, FontId::new(BODY_TEXT_POINTS, FontFamily::Monospace)),
    ]
    .into();
    style.number_formatter = NumberFormatter::new(field_text);
    style.spacing.item_spacing = vec2(8.0, 4.0);
    style.spacing.button_padding = vec2(6.0, 2.0);
    style
}

fn visuals(theme: Theme) -> Visuals {
    let grey = Color32::from_gray;
    let rgb = Color32::from_rgb;
    let mut visuals = theme.default_visuals();
    let (text, weak, warning, error, link) = match theme {
        Theme::Dark => (grey(200), grey(155), rgb(255, 170, 60), rgb(255, 125, 115), rgb(110, 180, 255)),
        Theme::Light => (grey(50), grey(95), rgb(150, 65, 0), rgb(180, 20, 20), rgb(0, 90, 165)),
    };
    visuals.widgets.noninteractive.fg_stroke.color = text;
    visuals.weak_text_color = Some(weak);
    visuals.warn_fg_color = warning;
    visuals.error_fg_color = error;
    visuals.hyperlink_color = link;
    visuals.striped = false;
    visuals
}
