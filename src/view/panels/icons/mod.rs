//! Icons in front of the text of buttons.
//!
//! In: a control's text or accessible name. Out: the control with a glyph of the Phosphor font in front of the text, or without text. Always: a screen
//! reader reads only the text or name, because the glyph is painted and not part of the text; the glyph has the text's colour. The font contains
//! only the glyphs listed here. It is Phosphor 2.1.2, regular (MIT, LICENSE-phosphor), reduced by fonttools; docs/text.md has the command.

use egui::{Align2, Atom, Button, FontData, FontDefinitions, FontFamily, FontId, Response, TextStyle, Ui, Vec2};
use std::sync::Arc;

/// Name of the icon font and of its family.
const FAMILY: &str = "icons";
/// Side of a glyph's square, relative to the font size of a button's text.
const RELATIVE_SIZE: f32 = 1.2;

/// An icon, named after its use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Icon {
    Bodies,
    Search,
    Back,
    Forward,
    Moments,
    Events,
    Effects,
    Layers,
    Information,
    Shader,
    Compare,
    Performance,
    Share,
    Help,
    Calendar,
    Now,
    Reverse,
    Pause,
    Play,
    Previous,
    Next,
    Plus,
    Minus,
    Close,
    Fly,
    LookAt,
    Level,
    Stand,
    Bookmark,
    Link,
    Save,
    Open,
    Image,
    Film,
    Record,
    Stop,
    Measure,
    Watch,
}

impl Icon {
    fn glyph(self) -> char {
        match self {
            Self::Bodies => '\u{e652}',
            Self::Search => '\u{e30c}',
            Self::Back => '\u{e058}',
            Self::Forward => '\u{e06c}',
            Self::Moments => '\u{e6a2}',
            Self::Events => '\u{e8b2}',
            Self::Effects => '\u{e434}',
            Self::Layers => '\u{e466}',
            Self::Information => '\u{e2ce}',
            Self::Shader => '\u{e1bc}',
            Self::Compare => '\u{e546}',
            Self::Performance => '\u{e628}',
            Self::Share => '\u{e408}',
            Self::Help => '\u{e3e8}',
            Self::Calendar => '\u{e7b4}',
            Self::Now => '\u{e19a}',
            Self::Reverse => '\u{e6a8}',
            Self::Pause => '\u{e39e}',
            Self::Play => '\u{e3d0}',
            Self::Previous => '\u{e138}',
            Self::Next => '\u{e13a}',
            Self::Plus => '\u{e3d4}',
            Self::Minus => '\u{e32a}',
            Self::Close => '\u{e4f6}',
            Self::Fly => '\u{e3fe}',
            Self::LookAt => '\u{e220}',
            Self::Level => '\u{e1c8}',
            Self::Stand => '\u{e316}',
            Self::Bookmark => '\u{e0ea}',
            Self::Link => '\u{e2e2}',
            Self::Save => '\u{e248}',
            Self::Open => '\u{e256}',
            Self::Image => '\u{e10e}',
            Self::Film => '\u{e792}',
            Self::Record => '\u{e3ee}',
            Self::Stop => '\u{e46c}',
            Self::Measure => '\u{e6b8}',
            Self::Watch => '\u{ea64}',
        }
    }
}

fn family() -> FontFamily {
    FontFamily::Name(FAMILY.into())
}

/// egui's default fonts and the icon font. The monospaced font supplies the characters that the proportional one lacks, such as the signs of
/// arcminutes and arcseconds.
pub(crate) fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let monospaced = fonts.families.get(&FontFamily::Monospace).cloned().unwrap_or_default();
    let proportional = fonts.families.entry(FontFamily::Proportional).or_default();
    let added: Vec<_> = monospaced.into_iter().filter(|name| !proportional.contains(name)).collect();
    proportional.extend(added);
    fonts.font_data.insert(FAMILY.into(), Arc::new(FontData::from_static(include_bytes!("phosphor.ttf"))));
    fonts.families.insert(family(), vec![FAMILY.into()]);
    fonts
}

/// The glyph as a part of a button, in the colour of the text. In the first frame, before the font is loaded, it is an empty space of the same size.
fn glyph_atom(ui: &Ui, icon: Icon) -> Atom<'static> {
    let side = (TextStyle::Button.resolve(ui.style()).size * RELATIVE_SIZE).round();
    Atom::paint(Vec2::splat(side), move |ui, place| {
        if ui.fonts(|fonts| fonts.definitions().families.contains_key(&family())) {
            let font = FontId::new(side, family());
            ui.painter().text(place.rect.center(), Align2::CENTER_CENTER, icon.glyph(), font, place.fallback_text_color);
        }
    })
}

/// A button with an icon and text, which the caller adds to the interface.
pub(crate) fn button<'a>(ui: &Ui, icon: Icon, text: &'a str) -> Button<'a> {
    Button::new((glyph_atom(ui, icon), text))
}

/// Shows a button with only an icon; `name` is its accessible name.
pub(crate) fn icon_button(ui: &mut Ui, icon: Icon, name: &str) -> Response {
    let button = Button::new(glyph_atom(ui, icon));
    ui.add(button).accessible_name(name)
}

/// Shows a button that looks pressed if `is_on`.
pub(crate) fn selectable(ui: &mut Ui, icon: Icon, is_on: bool, text: &str) -> Response {
    let button = Button::selectable(is_on, (glyph_atom(ui, icon), text));
    ui.add(button)
}

/// Shows a button with only an icon that looks pressed if `is_on`; `name` is its accessible name.
pub(crate) fn selectable_without_text(ui: &mut Ui, icon: Icon, is_on: bool, name: &str) -> Response {
    let button = Button::selectable(is_on, glyph_atom(ui, icon));
    ui.add(button).accessible_name(name)
}

/// Shows a button that inverts `is_on` when it is clicked, and looks pressed while `is_on` is true.
pub(crate) fn toggle(ui: &mut Ui, icon: Icon, is_on: &mut bool, text: &str) -> Response {
    let response = selectable(ui, icon, *is_on, text);
    if response.clicked() {
        *is_on = !*is_on;
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Icon; 38] = {
        use Icon as I;
        [
            I::Bodies,
            I::Search,
            I::Back,
            I::Forward,
            I::Moments,
            I::Events,
            I::Effects,
            I::Layers,
            I::Information,
            I::Shader,
            I::Compare,
            I::Performance,
            I::Share,
            I::Help,
            I::Calendar,
            I::Now,
            I::Reverse,
            I::Pause,
            I::Play,
            I::Previous,
            I::Next,
            I::Plus,
            I::Minus,
            I::Close,
            I::Fly,
            I::LookAt,
            I::Level,
            I::Stand,
            I::Bookmark,
            I::Link,
            I::Save,
            I::Open,
            I::Image,
            I::Film,
            I::Record,
            I::Stop,
            I::Measure,
            I::Watch,
        ]
    };

    /// Adds the characters beyond ASCII in the texts and source files below a folder.
    fn add_characters_beyond_ascii(folder: &std::path::Path, all: &mut std::collections::BTreeSet<char>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                add_characters_beyond_ascii(&path, all);
            } else if path.extension().is_some_and(|e| e == "ftl" || e == "rs") {
                all.extend(std::fs::read_to_string(path).expect("text").chars().filter(|c| !c.is_ascii()));
            }
        }
    }

    #[test]
    fn every_character_of_the_window_has_a_glyph() {
        let mut all = std::collections::BTreeSet::from(['″', '′', 'α', 'ω']);
        add_characters_beyond_ascii(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/view"), &mut all);
        let missing_in = |definitions: FontDefinitions| {
            let ctx = egui::Context::default();
            ctx.set_fonts(definitions);
            let mut missing = Vec::new();
            let mut output = ctx.run_ui(Default::default(), |ui| {
                let font = FontId::proportional(16.0);
                missing = ui.fonts_mut(|fonts| all.iter().copied().filter(|c| !fonts.has_glyph(&font, *c)).collect());
            });
            output.textures_delta.clear();
            missing
        };
        assert_eq!(missing_in(fonts()), Vec::<char>::new());
        assert!(missing_in(FontDefinitions::default()).contains(&'″'), "the proportional font alone lacks it");
    }

    /// The font contains each glyph, no two icons share a glyph, and the font does not contain letters.
    #[test]
    fn every_icon_has_a_glyph_of_its_own_in_the_font() {
        let ctx = egui::Context::default();
        ctx.set_fonts(fonts());
        let mut output = ctx.run_ui(Default::default(), |ui| {
            ui.fonts_mut(|fonts| {
                let font = FontId::new(16.0, family());
                for (k, icon) in ALL.into_iter().enumerate() {
                    assert!(fonts.has_glyph(&font, icon.glyph()), "{icon:?}");
                    assert!(ALL[..k].iter().all(|other| other.glyph() != icon.glyph()), "{icon:?}");
                }
                assert!(!fonts.has_glyph(&font, 'a'));
            });
        });
        // This frame is not painted, so its textures are discarded.
        output.textures_delta.clear();
    }
}
