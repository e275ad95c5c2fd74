//! The Effects panel: each effect with the scene's decision, the reason for it, the time that the effect takes, and how much it changes the
//! light. Also controls for quality, renderer, exposure, tone map, bloom, pixel view, layers and composition.
//!
//! In: the decisions of the last scene, measured costs, clicks. Out: the view with other effects and settings; queries that measure costs.

use super::number_field::{self, NumberKind};
use super::{Interface, accessible};
use crate::scene::effects::{Decision, Effect, EffectOverrides};
use crate::scene::request::{Quality, ToneMap, ViewRequest};
use crate::session::{DisplayPreference, EffectCost, RendererPreference, Session};
use crate::view::error_texts::error_text;
use crate::view::language::{body_name, decimal, reason_text, signed, text, translated_name};
use crate::view::worker::query_cache::QueryCache;
use crate::view::worker::render_worker::RenderWorker;
use crate::view::worker::session_inputs::SessionInputs;
use egui::{ComboBox, SliderClamping};

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker) {
    let view = &mut interface.viewer.view;
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("effects-quality"));
        for quality in Quality::ALL {
            ui.selectable_value(&mut view.quality, quality, translated_name("quality", quality.name()))
                .on_hover_text(text!("effects-quality-hint"));
        }
    });
    renderers(ui, worker, &mut interface.settings.presenter_preference);
    let view = &mut interface.viewer.view;
    let mut is_automatic = view.exposure_stops.is_none();
    // The exposure of the displayed image.
    let drawn_stops = interface.viewport.shown.as_ref().map_or(0.0, |rendered| rendered.scene.exposure.stops);
    ui.horizontal_wrapped(|ui| {
        let checkbox = ui.checkbox(&mut is_automatic, text!("effects-exposure-automatic"));
        if checkbox.on_hover_text(text!("effects-exposure-automatic-hint")).changed() {
            view.exposure_stops = if is_automatic { None } else { Some(drawn_stops) };
        }
        if let Some(stops) = &mut view.exposure_stops {
            // A view from a link or a file may have a value outside the slider's range, which must not be clamped merely because the panel is open.
            let slider = number_field::slider(stops, NumberKind::Plain, -20.0..=30.0, |slider| {
                slider.clamping(SliderClamping::Edits).text(text!("effects-stops"))
            });
            ui.add(slider).on_hover_text(text!("effects-exposure-hint"));
        } else {
            ui.label(text!("effects-drawn-stops", drawn_stops = signed(drawn_stops, 2)));
        }
    });
    if let Some(rendered) = interface.viewport.shown.as_ref().filter(|_| interface.viewer.view.exposure_stops.is_none()) {
        ui.label(egui::RichText::new(reason_text(&rendered.scene.exposure.reason)).weak().small());
    }
    let view = &mut interface.viewer.view;
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("effects-highlights"));
        for (tone_map, hover) in [(ToneMap::Filmic, text!("effects-filmic-hint")), (ToneMap::Clipped, text!("effects-clipped-hint"))] {
            ui.selectable_value(&mut view.tone_map, tone_map, translated_name("tone", tone_map.name())).on_hover_text(hover);
        }
        ui.checkbox(&mut view.bloom, text!("effects-bloom")).on_hover_text(text!("effects-bloom-hint"));
    });
    ui.horizontal(|ui| {
        ui.label(text!("effects-show"));
        accessible::pixel_view_list(ui, &mut view.pixel_view, text!("effects-show"));
    });
    super::layers::switches(interface, ui);
    super::composition::controls(interface, ui);
    super::telescope::controls(interface, ui);
    let view = &mut interface.viewer.view;
    ui.separator();
    let mut overrides = view.effects.clone();
    let selected_name = interface.viewer.catalog_name(interface.viewer.selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("effects-apply-to"));
        ui.selectable_value(&mut interface.edits_selected_body_only, false, text!("effects-all-bodies"))
            .on_hover_text(text!("effects-all-bodies-hint"));
        ui.selectable_value(&mut interface.edits_selected_body_only, true, text!("effects-one-body", name = body_name(&selected_name)))
            .on_hover_text(text!("effects-one-body-hint"));
        if ui.button(text!("effects-reset")).on_hover_text(text!("effects-reset-hint")).clicked() {
            overrides = EffectOverrides::default();
        }
    });
    let decisions = interface
        .viewport
        .shown
        .as_ref()
        .and_then(|rendered| rendered.scene.body(interface.viewer.selected))
        .map(|b| b.decisions.clone())
        .unwrap_or_default();
    let only_body = interface.edits_selected_body_only.then(|| selected_name.clone());
    // Costs are measured for effects that are drawn or were switched by hand. Each such effect is paired with whether it is drawn.
    let edited = if interface.edits_selected_body_only { overrides.own_overrides_mut(&selected_name) } else { &mut overrides };
    let set_by_hand: Vec<Effect> = Effect::ALL.into_iter().filter(|e| edited.override_of(*e).is_some()).collect();
    let has_cost = |effect: Effect, decision: &Decision| decision.on || set_by_hand.contains(&effect);
    let effect_with_cost = |e: Effect| decisions.iter().find(|d| d.effect == e.name() && has_cost(e, d)).map(|d| (e, d.on));
    let effects_with_cost: Vec<(Effect, bool)> = Effect::ALL.into_iter().filter_map(effect_with_cost).collect();
    measure_costs(interface, ui.ctx(), worker, only_body, &effects_with_cost);
    // Effects that are drawn or were switched by hand come first; the others follow, one line each. While a button is held the rows stay in place: an image
    // that arrives before the release may have other decisions, and the click is for the row that was pressed.
    let is_first = |e: &Effect| set_by_hand.contains(e) || decisions.iter().any(|d| d.on && d.effect == e.name());
    let keeps_rows = ui.input(|input| input.pointer.any_down() || input.pointer.any_released());
    let last_first = interface.first_effects.take().filter(|_| keeps_rows);
    let first_effects = last_first.unwrap_or_else(|| Effect::ALL.into_iter().filter(is_first).collect());
    let (first, rest): (Vec<Effect>, Vec<Effect>) = Effect::ALL.into_iter().partition(|e| first_effects.contains(e));
    interface.first_effects = Some(first_effects);
    for (effects, is_one_line) in [(first, false), (rest, true)] {
        for effect in effects {
            let decision = decisions.iter().find(|d| d.effect == effect.name());
            row(
                ui,
                effect,
                decision.map(|d| (d.on, reason_text(&d.description()))),
                interface.effect_costs.cache.known(&effect),
                is_one_line,
                edited,
            );
        }
        ui.separator();
    }
    // Decisions that are not about an effect have no switch.
    for d in decisions.iter().filter(|d| Effect::ALL.iter().all(|e| e.name() != d.effect)) {
        let sign = if d.on { "+" } else { "−" };
        ui.label(format!("{sign} {}: {}", translated_name("effect", d.effect), reason_text(&d.description())));
    }
    overrides.prune();
    interface.viewer.view.effects = overrides;
}

/// Measured costs of the effects, while the view does not change.
#[derive(Default)]
pub(crate) struct EffectCosts {
    /// What was measured: the view, the body's name if the switches apply to one body, and the session's inputs.
    measured: Option<(ViewRequest, Option<String>, SessionInputs)>,
    cache: QueryCache<Effect, Result<EffectCost, String>>,
}

/// Time without motion of the view after which measuring starts, seconds.
const MEASURE_DELAY_S: f64 = 1.0;

/// Measures one effect at a time while the view does not change, so that any other query waits for one measurement at most. `only_body`: the name of the
/// body to which the switches apply; `None` if they apply to all bodies. `effects`: the effects to measure, and whether each is drawn.
fn measure_costs(
    interface: &mut Interface,
    ctx: &egui::Context,
    worker: &dyn RenderWorker,
    only_body: Option<String>,
    effects: &[(Effect, bool)],
) {
    let Some(rendered) = &interface.viewport.shown else { return };
    let request = &rendered.job.request;
    let stops = rendered.scene.exposure.stops;
    let effect_costs = &mut interface.effect_costs;
    let session_inputs = SessionInputs::of(worker.session());
    let ignores_time = true;
    if effect_costs.measured.as_ref().is_none_or(|(measured, body, measured_inputs)| {
        super::render_loop::differs(measured, request, ignores_time) || *body != only_body || *measured_inputs != session_inputs
    }) {
        *effect_costs = EffectCosts { measured: Some((request.clone(), only_body.clone(), session_inputs)), cache: QueryCache::default() };
    }
    let at_rest_s = interface.viewport.frame_start_s - interface.viewport.last_motion_s;
    if interface.viewer.is_animating() {
        return;
    }
    if at_rest_s < MEASURE_DELAY_S {
        ctx.request_repaint_after(std::time::Duration::from_secs_f64(MEASURE_DELAY_S - at_rest_s));
        return;
    }
    let is_unknown = |effect_costs: &mut EffectCosts, effect: Effect| effect_costs.cache.known(&effect).is_none();
    if let Some((effect, on)) = effects.iter().copied().find(|(effect, _)| is_unknown(effect_costs, *effect)) {
        let (request, only_body) = (request.clone(), only_body.clone());
        let query =
            move |session: &Session| session.effect_cost(&request, stops, (effect, on), only_body.as_deref()).map_err(|e| error_text(&e));
        // Starts the measurement; `known` returns the result in a later frame.
        let _ = effect_costs.cache.get(worker, &effect, query);
    }
}

/// Shows the choice of the renderer, and whether the GPU or the processor presents the image.
fn renderers(ui: &mut egui::Ui, worker: &dyn RenderWorker, presenter_preference: &mut DisplayPreference) {
    let (choices, current) = worker.session().renderers();
    if choices.len() < 2 {
        // egui numbers controls from the top. A field below would lose the focus once a GPU is ready and the choice appears.
        return ui.skip_ahead_auto_ids(1);
    }
    ui.scope(|ui| renderer_choice(ui, worker, choices, current, presenter_preference));
}

/// Shows the choice among these renderers, and that of what presents the image if one of them may be a GPU.
fn renderer_choice(
    ui: &mut egui::Ui,
    worker: &dyn RenderWorker,
    choices: &[RendererPreference],
    current: RendererPreference,
    presenter_preference: &mut DisplayPreference,
) {
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("effects-renderer"));
        for preference in choices.iter().copied() {
            let hover = match preference {
                RendererPreference::Auto => text!("effects-renderer-auto"),
                RendererPreference::Gpu => text!("effects-renderer-gpu"),
                RendererPreference::Software => text!("effects-renderer-software"),
            };
            if ui.selectable_label(current == preference, translated_name("renderer", preference.name())).on_hover_text(hover).clicked() {
                // On the query worker, since the GPU may be busy.
                worker.run(Box::new(move |session| session.set_renderer_preference(preference)));
            }
        }
    });
    if current == RendererPreference::Software {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(text!("effects-display"));
        let displays = [
            (DisplayPreference::Auto, text!("effects-display-auto"), text!("effects-display-auto-hint")),
            (DisplayPreference::Gpu, text!("effects-display-gpu"), text!("effects-display-gpu-hint")),
            (DisplayPreference::Cpu, text!("effects-display-cpu"), text!("effects-display-cpu-hint")),
        ];
        for (preference, name, hover) in displays {
            ui.selectable_value(presenter_preference, preference, name).on_hover_text(hover);
        }
    });
}

/// The translated name of an effect.
fn effect_name(effect: Effect) -> &'static str {
    translated_name("effect", effect.name())
}

/// Shows the row of one effect: its switch, model, cost and reason; in one line if `is_one_line`. `decision`: whether the scene draws the effect, and
/// why; `None` if the scene did not consider it for this body.
fn row(
    ui: &mut egui::Ui,
    effect: Effect,
    decision: Option<(bool, String)>,
    cost: Option<&Result<EffectCost, String>>,
    is_one_line: bool,
    overrides: &mut EffectOverrides,
) {
    let reason = decision.as_ref().map_or(text!("effects-not-available"), |(_, reason)| reason.as_str());
    let reason_label = || egui::Label::new(egui::RichText::new(reason).weak().small()).truncate();
    let chosen_by_hand = overrides.override_of(effect);
    let mut is_on = chosen_by_hand.unwrap_or(decision.as_ref().is_some_and(|(is_drawn, _)| *is_drawn));
    ui.horizontal(|ui| {
        let hover = text!("effects-switch-hint", effect = effect_name(effect));
        if ui.checkbox(&mut is_on, effect_name(effect)).on_hover_text(hover).clicked() {
            overrides.set(effect, is_on);
        }
        if !effect.models().is_empty() {
            let chosen_model = overrides.model_name(effect).map_or(text!("effects-automatic"), |model| translated_name("model", model));
            let list = ComboBox::from_id_salt(effect.name()).selected_text(chosen_model).width(90.0).show_ui(ui, |ui| {
                for model in effect.models() {
                    let is_chosen = overrides.model_name(effect) == Some(*model);
                    if ui.selectable_label(is_chosen, translated_name("model", model)).clicked() {
                        // This cannot fail, because the list contains only models of this effect.
                        let _ = overrides.choose_model(effect, model);
                    }
                }
            });
            let info = || egui::WidgetInfo {
                current_text_value: Some(chosen_model.to_owned()),
                ..egui::WidgetInfo::labeled(egui::Role::ComboBox, true, text!("effects-method", effect = effect_name(effect)))
            };
            list.response.widget_info(info);
            list.response.on_hover_text(text!("effects-method-hint", effect = effect_name(effect)));
        }
        if chosen_by_hand.is_some() {
            let name = text!("effects-reset-one", effect = effect_name(effect));
            if ui.small_button("×").accessible_name(&name).on_hover_text(name).clicked() {
                overrides.clear_override(effect);
            }
        }
        if let Some(Ok(cost)) = cost {
            let cost_label = egui::RichText::new(cost_text(cost)).weak();
            ui.add(egui::Label::new(cost_label).truncate()).on_hover_text(text!("effects-cost-hint"));
        }
        if is_one_line {
            ui.add(reason_label());
        }
    });
    if !is_one_line {
        ui.indent(effect.name(), |ui| ui.add(reason_label()));
    }
}

/// A cost such as `+1.2 ms, -3.9 % light (4.1 %)`: time, net change of the total light, and in parentheses the sum of the pixels' absolute changes.
fn cost_text(cost: &EffectCost) -> String {
    let [net_percent, absolute_percent] = [cost.light.net, cost.light.absolute].map(|fraction| 100.0 * fraction);
    let decimals = if absolute_percent.abs() < 0.1 { 3 } else { 1 };
    text!("effects-cost", time = signed(cost.ms, 1), light = signed(net_percent, decimals), absolute = decimal(absolute_percent, decimals))
}
