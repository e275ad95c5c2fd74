//! Effects on and off: each with what the scene decided, and why.

use super::Interface;
use crate::scene::draw::PixelView;
use crate::scene::effects::{Effect, EffectOverrides};
use crate::view::sight::{QUALITIES, quality_name};
use egui::{ComboBox, ScrollArea};

pub fn panel(interface: &mut Interface, ui: &mut egui::Ui) {
    let sight = &mut interface.viewer.sight;
    ui.horizontal_wrapped(|ui| {
        ui.label("Quality");
        for quality in QUALITIES {
            let name = quality_name(quality);
            if ui.selectable_label(sight.quality == name, name).clicked() {
                sight.quality = name.to_owned();
            }
        }
    });
    let mut automatic = sight.exposure_stops.is_none();
    let drawn_stops = interface.sky.drawing.as_ref().map_or(0.0, |d| d.scene.exposure.stops);
    ui.horizontal_wrapped(|ui| {
        if ui.checkbox(&mut automatic, "automatic exposure").changed() {
            sight.exposure_stops = if automatic { None } else { Some(drawn_stops) };
        }
        if let Some(stops) = &mut sight.exposure_stops {
            ui.add(egui::Slider::new(stops, -20.0..=30.0).text("stops")).on_hover_text("Exposure in stops");
        } else {
            ui.label(format!("{drawn_stops:+.2} stops"));
        }
    });
    ComboBox::from_label("what each pixel shows").selected_text(sight.pixels.clone()).show_ui(ui, |ui| {
        for view in PixelView::ALL {
            ui.selectable_value(&mut sight.pixels, view.name().to_owned(), view.name());
        }
    });
    ui.separator();
    let mut overrides = EffectOverrides::parse(&sight.effects).unwrap_or_default();
    let name = interface.viewer.name(interface.viewer.selected).to_owned();
    ui.horizontal_wrapped(|ui| {
        ui.label("Switch");
        ui.selectable_value(&mut interface.effects_of_one, false, "for all bodies");
        ui.selectable_value(&mut interface.effects_of_one, true, format!("for {name} alone"));
        if ui.button("Only what the scene needs").on_hover_text("Takes back everything that was switched by hand").clicked() {
            overrides = EffectOverrides::default();
        }
    });
    let decisions = interface
        .sky
        .drawing
        .as_ref()
        .and_then(|d| d.scene.body(interface.viewer.selected))
        .map(|b| b.decisions.clone())
        .unwrap_or_default();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for effect in Effect::ALL {
            let decision = decisions.iter().find(|d| d.feature == effect.name());
            let asked = if interface.effects_of_one { overrides.of_body(&name) } else { &mut overrides };
            row(ui, effect, decision.map(|d| (d.on, d.reason.as_str())), asked);
        }
        ui.separator();
        for d in decisions.iter().filter(|d| Effect::ALL.iter().all(|e| e.name() != d.feature)) {
            ui.label(format!("{} {}: {}", if d.on { "+" } else { "−" }, d.feature, d.reason));
        }
    });
    interface.viewer.sight.effects = overrides.to_text();
}

/// One effect: drawn or not, by whom, why, and in which way.
fn row(ui: &mut egui::Ui, effect: Effect, decided: Option<(bool, &str)>, overrides: &mut EffectOverrides) {
    let asked = overrides.asked(effect);
    let mut on = asked.unwrap_or(decided.is_some_and(|d| d.0));
    ui.horizontal(|ui| {
        let hover = format!("Switch {} on or off by hand", effect.name());
        if ui.checkbox(&mut on, effect.name()).on_hover_text(hover).clicked() {
            overrides.set(effect, on);
        }
        if !effect.ways().is_empty() {
            let now = overrides.way(effect).unwrap_or("by need");
            ComboBox::from_id_salt(effect.name()).selected_text(now).width(90.0).show_ui(ui, |ui| {
                for way in effect.ways() {
                    if ui.selectable_label(now == *way, *way).clicked() {
                        // A way of the list is one that the effect has.
                        let _ = overrides.choose(effect, way);
                    }
                }
            });
        }
        if asked.is_some() && ui.small_button("×").on_hover_text(format!("Let the scene decide on {}", effect.name())).clicked() {
            overrides.forget(effect);
        }
        let reason = decided.map_or("nothing here has it", |d| d.1);
        ui.add(egui::Label::new(egui::RichText::new(reason).weak().small()).truncate());
    });
}
