//! The Effects panel: each effect with the scene's decision, its reason, and its cost in time and light; renderer, exposure, quality.

use super::{Interface, accessible};
use crate::scene::effects::{Decision, Effect, EffectOverrides};
use crate::scene::request::{Quality, ToneMap, ViewRequest};
use crate::session::{DisplayPreference, EffectCost, RendererPreference, Session};
use crate::view::worker::query_cache::QueryCache;
use crate::view::worker::render_worker::RenderWorker;
use egui::{ComboBox, ScrollArea};

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
    let view = &mut interface.viewer.view;
    ui.horizontal_wrapped(|ui| {
        ui.label("Quality");
        for quality in Quality::ALL {
            ui.selectable_value(&mut view.quality, quality, quality.name()).on_hover_text("How finely a picture at rest is drawn");
        }
    });
    renderers(ui, worker, &mut interface.settings.shown_by);
    let view = &mut interface.viewer.view;
    let mut automatic = view.exposure_stops.is_none();
    let drawn_stops = interface.viewport.drawing.as_ref().map_or(0.0, |d| d.scene.exposure.stops);
    ui.horizontal_wrapped(|ui| {
        let metered = ui.checkbox(&mut automatic, "Automatic exposure");
        if metered.on_hover_text("Meter what fills the picture").changed() {
            view.exposure_stops = if automatic { None } else { Some(drawn_stops) };
        }
        if let Some(stops) = &mut view.exposure_stops {
            ui.add(egui::Slider::new(stops, -20.0..=30.0).text("stops")).on_hover_text("Exposure, stops");
        } else {
            ui.label(format!("{drawn_stops:+.2} stops"));
        }
    });
    if let Some(drawing) = interface.viewport.drawing.as_ref().filter(|_| interface.viewer.view.exposure_stops.is_none()) {
        ui.label(egui::RichText::new(&drawing.scene.exposure.reason).weak().small());
    }
    let view = &mut interface.viewer.view;
    ui.horizontal_wrapped(|ui| {
        ui.label("Highlights");
        for (tone_map, hover) in [
            (ToneMap::Filmic, "Tone mapping: linear up to 0.8 of white, then a shoulder"),
            (ToneMap::Clipped, "Tone mapping: linear up to white, then clipped"),
        ] {
            ui.selectable_value(&mut view.tone_map, tone_map, tone_map.name()).on_hover_text(hover);
        }
        ui.checkbox(&mut view.bloom, "Bloom").on_hover_text("Light above white spreads, as in a lens");
    });
    ui.horizontal(|ui| {
        ui.label("Show");
        accessible::pixel_views(ui, &mut view.pixels, "Show");
    });
    super::layers::switches(interface, ui);
    super::composition::controls(interface, ui);
    let view = &mut interface.viewer.view;
    ui.separator();
    let mut overrides = view.effects.clone();
    let name = interface.viewer.name(interface.viewer.selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        ui.label("Apply to");
        ui.selectable_value(&mut interface.effects_of_one, false, "all bodies").on_hover_text("Switch effects of every body");
        ui.selectable_value(&mut interface.effects_of_one, true, format!("{name} only"))
            .on_hover_text("Switch effects of the selected body alone");
        if ui.button("Reset to automatic").on_hover_text("Remove everything that you set by hand").clicked() {
            overrides = EffectOverrides::default();
        }
    });
    let decisions = interface
        .viewport
        .drawing
        .as_ref()
        .and_then(|d| d.scene.body(interface.viewer.selected))
        .map(|b| b.decisions.clone())
        .unwrap_or_default();
    let of_body = interface.effects_of_one.then(|| name.clone());
    // Costs are measured for effects that are drawn or were switched off by hand.
    let has_cost = |e: Effect, d: &Decision| d.on || overrides.override_of(e).is_some();
    let on = |e: Effect| decisions.iter().find(|d| d.feature == e.name() && has_cost(e, d)).map(|d| (e, d.on));
    let decided: Vec<(Effect, bool)> = Effect::ALL.into_iter().filter_map(on).collect();
    measure_costs(interface, ui.ctx(), worker, of_body, &decided);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let asked = if interface.effects_of_one { overrides.of_body(&name) } else { &mut overrides };
        // Effects that are drawn or were switched by hand come first; the rest follows in short form.
        let (first, rest): (Vec<Effect>, Vec<Effect>) = Effect::ALL
            .into_iter()
            .partition(|e| asked.override_of(*e).is_some() || decisions.iter().any(|d| d.on && d.feature == e.name()));
        for (effects, short) in [(first, false), (rest, true)] {
            for effect in effects {
                let decision = decisions.iter().find(|d| d.feature == effect.name());
                row(ui, effect, decision.map(|d| (d.on, d.description())), interface.effect_costs.known.known(&effect), short, asked);
            }
            ui.separator();
        }
        for d in decisions.iter().filter(|d| Effect::ALL.iter().all(|e| e.name() != d.feature)) {
            ui.label(format!("{} {}: {}", if d.on { "+" } else { "−" }, d.feature, d.description()));
        }
    });
    overrides.prune();
    interface.viewer.view.effects = overrides;
}

/// Measured costs of the effects in a view at rest.
#[derive(Default)]
pub(crate) struct EffectCosts {
    /// The view, and the body if the switches apply to one body.
    of: Option<(ViewRequest, Option<String>)>,
    known: QueryCache<Effect, Result<EffectCost, String>>,
}

/// Delay after which a view at rest is measured, seconds.
const MEASURE_DELAY_S: f64 = 1.0;

/// Measures one effect at a time while the view is at rest, so that a click waits for one at most.
fn measure_costs(
    interface: &mut Interface,
    ctx: &egui::Context,
    worker: &dyn RenderWorker,
    of_body: Option<String>,
    effects: &[(Effect, bool)],
) {
    let Some(drawing) = &interface.viewport.drawing else { return };
    let request = &drawing.job.request;
    let stops = drawing.scene.exposure.stops;
    let effect_costs = &mut interface.effect_costs;
    if effect_costs.of.as_ref().is_none_or(|(of, body)| super::render_loop::differs(of, request, true) || *body != of_body) {
        *effect_costs = EffectCosts { of: Some((request.clone(), of_body.clone())), known: QueryCache::default() };
    }
    let rested_s = interface.viewport.last_s - interface.viewport.moved_s;
    if interface.viewer.is_animating() {
        return;
    }
    if rested_s < MEASURE_DELAY_S {
        ctx.request_repaint_after(std::time::Duration::from_secs_f64(MEASURE_DELAY_S - rested_s));
        return;
    }
    let unknown = |effect_costs: &mut EffectCosts, effect: Effect| effect_costs.known.known(&effect).is_none();
    if let Some((effect, on)) = effects.iter().copied().find(|(effect, _)| unknown(effect_costs, *effect)) {
        let (request, of_body) = (request.clone(), of_body.clone());
        let question =
            move |session: &Session| session.effect_cost(&request, stops, (effect, on), of_body.as_deref()).map_err(|e| e.to_string());
        let _ = effect_costs.known.get(worker, &effect, question);
    }
}

/// Choice of the renderer and of the presentation.
fn renderers(ui: &mut egui::Ui, worker: &dyn RenderWorker, shown_by: &mut DisplayPreference) {
    let (choices, now) = worker.session().renderers();
    if choices.len() < 2 {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Renderer");
        for preference in choices.iter().copied() {
            let hover = match preference {
                RendererPreference::Auto => "A hardware GPU if there is one, otherwise the CPU",
                RendererPreference::Gpu => "Any graphics adapter, even a software driver",
                RendererPreference::Software => "CPU only",
            };
            if ui.selectable_label(now == preference, preference.name()).on_hover_text(hover).clicked() {
                // Off this thread, since the device may be busy.
                worker.run(Box::new(move |session| session.set_renderer_preference(preference)));
            }
        }
    });
    if now == RendererPreference::Software {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Display via");
        let variants = [
            (DisplayPreference::Auto, "auto", "The GPU if it is hardware and draws the images, otherwise the CPU"),
            (DisplayPreference::Device, "GPU", "The adapter that draws the images: they are not read back"),
            (DisplayPreference::Processor, "CPU", "Images are read back from the GPU, and the CPU paints the interface"),
        ];
        for (preference, name, hover) in variants {
            ui.selectable_value(shown_by, preference, name).on_hover_text(hover);
        }
    });
}

/// The row of one effect: its switch, model, cost and reason; in one line if `short`.
fn row(
    ui: &mut egui::Ui,
    effect: Effect,
    decided: Option<(bool, String)>,
    cost: Option<&Result<EffectCost, String>>,
    short: bool,
    overrides: &mut EffectOverrides,
) {
    let reason = decided.as_ref().map_or("not available for this body", |d| d.1.as_str());
    let why = || egui::Label::new(egui::RichText::new(reason).weak().small()).truncate();
    let asked = overrides.override_of(effect);
    let mut on = asked.unwrap_or(decided.as_ref().is_some_and(|d| d.0));
    ui.horizontal(|ui| {
        let hover = format!("Set {} on or off", effect.name());
        if ui.checkbox(&mut on, effect.name()).on_hover_text(hover).clicked() {
            overrides.set(effect, on);
        }
        if !effect.variants().is_empty() {
            let now = overrides.variant(effect).unwrap_or("automatic");
            let choice = ComboBox::from_id_salt(effect.name()).selected_text(now).width(90.0).show_ui(ui, |ui| {
                for way in effect.variants() {
                    if ui.selectable_label(now == *way, *way).clicked() {
                        // The list only has models of this effect.
                        let _ = overrides.choose(effect, way);
                    }
                }
            });
            let said = || egui::WidgetInfo {
                current_text_value: Some(now.to_owned()),
                ..egui::WidgetInfo::labeled(egui::Role::ComboBox, true, format!("Method of {}", effect.name()))
            };
            choice.response.widget_info(said);
            choice.response.on_hover_text(format!("How {} is computed; automatic: as the scene needs it", effect.name()));
        }
        if asked.is_some() && ui.small_button("×").on_hover_text(format!("Reset {} to automatic", effect.name())).clicked() {
            overrides.clear_override(effect);
        }
        if let Some(Ok(cost)) = cost {
            let words = egui::RichText::new(cost_text(cost)).weak();
            ui.add(egui::Label::new(words).truncate()).on_hover_text(
                "Measured on a small software rendering with and without it, scaled to this image: time added, net change of light, and in parentheses \
                 the light that moves",
            );
        }
        if short {
            ui.add(why());
        }
    });
    if !short {
        ui.indent(effect.name(), |ui| ui.add(why()));
    }
}

/// Formats as `+1.2 ms, -3.9 % light (4.1 %)`.
fn cost_text(cost: &EffectCost) -> String {
    let [light, moved] = [cost.light.net, cost.light.moved].map(|p| 100.0 * p);
    let digits = if moved.abs() < 0.1 { 3 } else { 1 };
    format!("{:+.1} ms, {light:+.digits$} % light ({moved:.digits$} %)", cost.ms)
}
