//! The Shader panel: the shader module that draws the selected body, with its key (which names it), source, uniforms, cost, the values of one pixel,
//! and sample images (of a fixed body, see `session::sample_body`) drawn with other keys.
//!
//! In: the last image, the selected body. Out: egui shapes. Always: a key changed by hand affects only this panel, not the image on screen;
//! slow queries run on the query worker (a background thread); everything shown belongs to the module named at the top; the text fields of a page stay while
//! a module is loading, and if there is none: otherwise what is typed next would act as shortcuts.

mod cost;
mod descriptions;
mod gallery;
mod key;
mod key_comparison;
mod module_text;
mod probe;
mod queries;
mod source;
mod values;

use super::Interface;
use crate::catalog::NaifId;
use crate::scene::draw::{Draw, DrawFeatures};
use crate::scene::request::Projection;
use crate::shader::ModuleId;
use crate::shader::id::SIMPLE_MODULES;
use crate::shader::key::ShaderKey;
use crate::view::language::{text, text_by_id, translated_name};
use crate::view::panels::theme::MIN_LIST_HEIGHT;
use crate::view::worker::render_worker::{RenderWorker, RenderedView};
use egui::{ComboBox, RichText, ScrollArea};
use queries::ShaderQueries;

/// A page of the panel; each is a file of this folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Page {
    /// The value of each dimension of the key, and what a change of the key makes different.
    Key,
    #[default]
    Source,
    /// The uniforms and textures of the draw.
    Values,
    Cost,
    /// The named values that the draws compute at one pixel.
    Probe,
    /// Sample images drawn with other keys.
    Gallery,
}

impl Page {
    /// Each page, with the message ids of its name and its tooltip.
    const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Key, "page-key", "page-key-hint"),
        (Self::Source, "page-source", "page-source-hint"),
        (Self::Values, "page-values", "page-values-hint"),
        (Self::Cost, "page-cost", "page-cost-hint"),
        (Self::Probe, "page-probe", "page-probe-hint"),
        (Self::Gallery, "page-gallery", "page-gallery-hint"),
    ];
}

/// What a user can choose for inspection; it determines the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ModuleChoice {
    /// A part of the selected body, given by the part's name: the module that draws it.
    Part(&'static str),
    /// A simple shader, given by its name in [`SIMPLE_MODULES`]: a module without a key, which all bodies share.
    Simple(&'static str),
}

/// The names of the pins.
const PIN_NAMES: [&str; 2] = ["A", "B"];

/// State of the Shader panel.
#[derive(Default)]
pub(crate) struct ShaderPanel {
    page: Page,
    /// The module that the user chose. `None`: the module of the body's globe; without a globe, of the body's first draw; without draws, of points.
    chosen: Option<ModuleChoice>,
    /// The body and the module that the last frame showed. When one of them changes, features changed by hand are dropped.
    last_inspected: Option<(NaifId, ModuleChoice)>,
    /// Features changed by hand, including values without effect, which the key omits; `None`: the features are those of the draw.
    edited: Option<DrawFeatures>,
    /// The features of a key from the search field, which replace `edited` in the next frame.
    requested: Option<DrawFeatures>,
    /// The keys pinned as A and B, for comparison.
    pins: [Option<ShaderKey>; 2],
    queries: ShaderQueries,
    key: key::KeyPage,
    key_comparison: key_comparison::KeyComparison,
    source: source::SourcePage,
    values: values::ValuesPage,
    probe: probe::ProbePage,
    gallery: gallery::GalleryPage,
}

/// What the panel shows in this frame.
struct Inspected<'a> {
    /// Runs the queries.
    worker: &'a dyn RenderWorker,
    /// The displayed image, with its scene.
    rendered: &'a RenderedView,
    /// The selected body's draw whose module is inspected; `None` for a simple shader.
    draw: Option<&'a Draw>,
    /// The key of `draw`.
    drawn_key: Option<ShaderKey>,
    /// The displayed module: the module of the draw, the module of the key changed by hand, or a simple shader.
    id: ModuleId,
    /// Number of images that the window has shown, which identifies the current one.
    image_number: u64,
}

impl Inspected<'_> {
    /// The displayed key; `None` for a simple shader.
    fn key(&self) -> Option<ShaderKey> {
        match &self.id {
            ModuleId::Keyed(key) => Some(*key),
            _ => None,
        }
    }

    /// Whether the displayed key was changed by hand.
    fn is_changed(&self) -> bool {
        self.drawn_key.is_some_and(|drawn_key| self.key() != Some(drawn_key))
    }
}

/// Shows the panel, and takes over a pixel that the user picked on the Probe page.
pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
    let mut panel = std::mem::take(&mut interface.shader);
    panel.show(interface, ui, worker);
    interface.viewport.picked_px = panel.probe.newly_picked_px.take().or(interface.viewport.picked_px);
    interface.shader = panel;
}

impl ShaderPanel {
    /// Shows a key from the search field on the Key page.
    pub(crate) fn show_key(&mut self, key: &ShaderKey) {
        self.page = Page::Key;
        // A simple shader has no key, so it would hide the requested one.
        self.chosen.take_if(|module| matches!(module, ModuleChoice::Simple(_)));
        self.requested = Some(*key.features());
    }

    /// Opens the source at the lines of a feature of the selected body's draw.
    pub(crate) fn show_feature(&mut self, feature: &str) {
        (self.page, self.chosen, self.edited) = (Page::Source, None, None);
        self.source.request_feature(feature);
    }

    /// Drops stored errors: their texts are in the language in which the queries were made.
    pub(crate) fn forget_failures(&mut self) {
        self.queries.forget_failures();
        self.key_comparison.forget_failure();
        self.key.forget_failure();
    }

    /// Whether the Probe page is shown, so that the viewport marks its pixel.
    pub(crate) fn shows_probe(&self) -> bool {
        self.page == Page::Probe
    }

    /// Whether this control is the list of lines of the Source page, which uses Page Up, Page Down and Home.
    pub(crate) fn is_list_of_lines(&self, control: egui::Id) -> bool {
        self.source.lines_id == Some(control)
    }

    /// Determines the module to show, and shows the chosen page about it.
    fn show(&mut self, interface: &Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
        self.queries.reset_on_new_fragments(worker);
        let Some(rendered) = interface.shown() else {
            // The first image is still being drawn.
            ui.label(text!("shader-first"));
            return;
        };
        let body = interface.viewer.selected;
        let draws: Vec<&Draw> = rendered.scene.draws.iter().filter(|d| d.body == body).collect();
        let name = interface.viewer.name(body).to_owned();
        // The faces of a dome or whole-sphere image have scenes of their own, which are not kept.
        let is_perspective = rendered.job.request.composition.projection == Projection::Perspective;
        let no_draws_text = if is_perspective { text!("shader-point") } else { text!("shader-faces") };
        self.module_choices(ui, &name, &draws, no_draws_text);
        let chosen = self.chosen.filter(|module| match module {
            ModuleChoice::Part(part) => draws.iter().any(|d| d.part.name() == *part),
            ModuleChoice::Simple(_) => true,
        });
        let default_draw = draws.iter().find(|d| d.part.name() == "globe").or(draws.first());
        let module = chosen.unwrap_or(default_draw.map_or(ModuleChoice::Simple("point"), |d| ModuleChoice::Part(d.part.name())));
        if self.last_inspected.replace((body, module)) != Some((body, module)) {
            self.edited = None;
        }
        self.edited = self.requested.take().or(self.edited);
        let draw = match module {
            ModuleChoice::Part(part) => draws.into_iter().find(|d| d.part.name() == part),
            ModuleChoice::Simple(_) => None,
        };
        let drawn_key = draw.map(|d| ShaderKey::for_draw(&d.features));
        let id = match (module, drawn_key, self.edited) {
            (_, Some(_), Some(edited)) => ModuleId::Keyed(ShaderKey::for_draw(&edited)),
            (_, Some(drawn_key), None) => ModuleId::Keyed(drawn_key),
            (ModuleChoice::Simple(name), _, _) => ModuleId::Simple(name),
            (ModuleChoice::Part(_), None, _) => ModuleId::Simple("point"),
        };
        let inspected = Inspected { worker, rendered, draw, drawn_key, id, image_number: interface.viewport.images_shown };
        self.heading(ui, &inspected);
        ui.horizontal_wrapped(|ui| {
            for (page, name, tooltip) in Page::ALL {
                ui.selectable_value(&mut self.page, page, text_by_id(name)).on_hover_text(text_by_id(tooltip));
            }
        });
        ui.separator();
        let failure = self.queries.module(worker, &inspected.id).and_then(Result::err);
        match (self.page, failure.as_deref()) {
            (Page::Key, failure) => key::show(self, ui, &inspected, failure),
            (Page::Source, failure) => source::show(self, ui, &inspected, failure),
            (Page::Values, failure) => values::show(self, ui, &inspected, failure),
            (Page::Probe, failure) => probe::show(self, ui, &inspected, failure, interface),
            (Page::Cost | Page::Gallery, Some(failure)) => show_failure(ui, failure),
            (Page::Cost, None) => cost::show(self, ui, &inspected),
            (Page::Gallery, None) => gallery::show(self, ui, &inspected),
        }
    }

    /// Shows buttons for the draws of the body and a list of the simple shaders, to choose the module. `body_name`: the body's name. `no_draws_text`: says
    /// why the body has no draws, if it has none.
    fn module_choices(&mut self, ui: &mut egui::Ui, body_name: &str, draws: &[&Draw], no_draws_text: &str) {
        let current = self.last_inspected.map(|(_, module)| module);
        ui.horizontal_wrapped(|ui| {
            ui.strong(body_name);
            if draws.is_empty() {
                ui.weak(no_draws_text);
            }
            for draw in draws {
                let part = ModuleChoice::Part(draw.part.name());
                let hover = text!("shader-part-hint", name = body_name, part = translated_name("part", draw.part.name()));
                if ui.selectable_label(current == Some(part), translated_name("part", draw.part.name())).on_hover_text(hover).clicked() {
                    self.chosen = Some(part);
                }
            }
            ui.separator();
            let title_of = |simple: &str| simple.replace('_', " ");
            let selected = match current {
                Some(ModuleChoice::Simple(simple)) => title_of(simple),
                _ => text!("shader-shared").to_owned(),
            };
            let list = ComboBox::from_id_salt("shared modules").selected_text(selected).show_ui(ui, |ui| {
                for simple in SIMPLE_MODULES {
                    let module = ModuleChoice::Simple(simple);
                    if ui.selectable_label(current == Some(module), title_of(simple)).clicked() {
                        self.chosen = Some(module);
                    }
                }
            });
            list.response.on_hover_text(text!("shader-shared-hint")).accessible_name(text!("shader-shared"));
        });
    }

    /// The names of the pins that hold a key: `A`, `B`, both or none.
    fn pin_names(&self, key: &ShaderKey) -> Vec<&'static str> {
        self.pins.iter().zip(PIN_NAMES).filter(|(pin, _)| **pin == Some(*key)).map(|(_, name)| name).collect()
    }

    /// Shows the module's name, the pins, a button that opens the comparison of pinned keys, and a button that resets a changed key.
    fn heading(&mut self, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
        ui.add(egui::Label::new(RichText::new(inspected.id.to_string()).monospace().strong()).wrap());
        ui.horizontal_wrapped(|ui| {
            if ui.small_button(text!("shader-copy")).on_hover_text(text!("shader-copy-hint")).clicked() {
                ui.ctx().copy_text(inspected.id.to_string());
            }
            if let Some(key) = inspected.key() {
                for (pin, name) in self.pins.iter_mut().zip(PIN_NAMES) {
                    let is_pinned = *pin == Some(key);
                    // A pin that holds another key says so.
                    let (label, hover) = match pin {
                        Some(other) if !is_pinned => {
                            (text!("shader-repin", name = name), text!("shader-repin-hint", name = name, key = other.to_string()))
                        }
                        _ => (text!("shader-pin", name = name), text!("shader-pin-hint", name = name)),
                    };
                    if ui.selectable_label(is_pinned, label).on_hover_text(hover).clicked() {
                        *pin = if is_pinned { None } else { Some(key) };
                    }
                }
                let may_compare = self.page != Page::Key && self.pins.iter().any(Option::is_some);
                if may_compare && ui.small_button(text!("shader-compare")).on_hover_text(text!("shader-compare-hint")).clicked() {
                    self.page = Page::Key;
                }
            }
            if inspected.is_changed() {
                ui.colored_label(ui.visuals().warn_fg_color, text!("shader-changed"));
                if ui.small_button(text!("shader-back")).on_hover_text(text!("shader-back-hint")).clicked() {
                    self.edited = None;
                }
            }
        });
    }
}

/// Shows why there is no module, with the place of the error in its source.
fn show_failure(ui: &mut egui::Ui, failure: &queries::ModuleFailure) {
    ui.colored_label(ui.visuals().error_fg_color, &failure.why);
    ui.weak(text!("shader-broken"));
    let area = ScrollArea::both().id_salt(("failure", &failure.why)).auto_shrink([false, true]).min_scrolled_height(MIN_LIST_HEIGHT);
    area.show(ui, |ui| {
        ui.add(egui::Label::new(RichText::new(&failure.diagnosis).monospace()).extend());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// While a simple shader is chosen, no key is shown.
    #[test]
    fn a_key_from_the_search_field_replaces_a_chosen_simple_shader() {
        // `sun1`: the Sun is the only light.
        let Ok(key) = "lambert.albedo.sun1.ellipsoid".parse::<ShaderKey>() else { panic!("not a key") };
        let rings = ModuleChoice::Part("rings");
        for (chosen, expected) in [(ModuleChoice::Simple("point"), None), (rings, Some(rings))] {
            let mut panel = ShaderPanel { chosen: Some(chosen), ..ShaderPanel::default() };
            panel.show_key(&key);
            assert_eq!((panel.chosen, panel.page), (expected, Page::Key));
        }
    }
}
