//! The search field, its suggestions, and the actions that they trigger.
//!
//! In: typed text, clicks. Out: actions, opened panels. Always: an error appears below the field until the text changes; when the field
//! gets the focus, its text is selected; similar texts are offered, never chosen automatically.

use super::{Interface, MAX_ECHO_CHARS, Tab, events, moments, sky_object, what_to_see_now};
use crate::catalog::{Catalog, NaifId};
use crate::scene::effects::EffectOverrides;
use crate::scene::labels::SkyObject;
use crate::view::app::body_positions::SessionPositions;
use crate::view::app::date_text::resembles_date;
use crate::view::app::moment_view::view_of_moment;
use crate::view::app::place_text::parse_place_without_limits;
use crate::view::app::search::{SearchTarget, Suggestion, mentions_events, similar_texts, suggestions, surface_feature_view};
use crate::view::app::sky_target::{constellation_view, sight_from_earth, small_body_view, star_view};
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::{catalog_text, text};
use crate::view::link::{is_link, view_from_text};
use crate::view::worker::render_worker::RenderWorker;
use crate::wording::echo_within;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Id, Key, Label, RichText, TextEdit};

/// Largest number of suggestions.
const MAX_SUGGESTIONS: usize = 8;
/// Smallest and largest width of an error below the field, points.
const ERROR_WIDTH_RANGE: [f32; 2] = [120.0, 460.0];
/// Width of the margins of the list below the field, points.
const LIST_MARGINS: f32 = 24.0;

/// State of the search field.
#[derive(Default)]
pub(crate) struct SearchField {
    /// The text in the field.
    typed: String,
    /// Index of the highlighted suggestion.
    highlighted: usize,
    /// Whether the field takes the keyboard focus when it is shown next.
    pub wants_focus: bool,
    /// The error for the last text entered, until the text changes.
    failure: Option<String>,
}

impl SearchField {
    /// Clears the text and the error. Returns false if both were empty.
    pub(crate) fn clear(&mut self) -> bool {
        let was_in_use = !self.typed.is_empty() || self.failure.is_some();
        self.typed.clear();
        self.failure = None;
        was_in_use
    }

    /// Removes the error.
    pub(crate) fn forget_failure(&mut self) {
        self.failure = None;
    }
}

/// Selects the entire text of a field, so that typing replaces it.
fn select_all(ctx: &egui::Context, field: Id, text: &str) {
    let mut state = TextEditState::load(ctx, field).unwrap_or_default();
    state.cursor.set_char_range(Some(CCursorRange::two(CCursor::new(0), CCursor::new(text.chars().count()))));
    state.store(ctx, field);
}

/// Shows the search field, with its suggestions or error.
pub(crate) fn field(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let field = TextEdit::singleline(&mut interface.search.typed).hint_text(text!("search-field-hint-text")).desired_width(150.0);
    // Its own id, because a wider window has captions before it.
    let response = ui.add(field.id_salt("search")).on_hover_text(text!("search-hint"));
    let response = response.accessible_name(text!("search"));
    let focus_requested = std::mem::take(&mut interface.search.wants_focus);
    if focus_requested {
        response.request_focus();
    }
    if focus_requested || response.gained_focus() {
        select_all(ui.ctx(), response.id, &interface.search.typed);
    }
    if response.changed() {
        interface.search.highlighted = 0;
        interface.search.failure = None;
    }
    let catalog = worker.session().catalog();
    let zone = interface.settings.time_zone;
    let found = suggestions(&interface.search.typed, &interface.viewer, catalog, zone, MAX_SUGGESTIONS);
    let mut chosen = None;
    let enter_pressed = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    if response.has_focus() || enter_pressed {
        let (moves_down, moves_up) = ui.input(|i| (i.key_pressed(Key::ArrowDown), i.key_pressed(Key::ArrowUp)));
        let last_index = found.len().saturating_sub(1);
        interface.search.highlighted =
            (interface.search.highlighted + usize::from(moves_down)).saturating_sub(usize::from(moves_up)).min(last_index);
    }
    if enter_pressed && !interface.search.typed.trim().is_empty() {
        match (found.get(interface.search.highlighted), apply_typed_effects(interface)) {
            _ if is_link(&interface.search.typed) => open_link(interface, worker, actions),
            (Some(suggestion), _) => chosen = Some(suggestion.target.clone()),
            (None, Some(Ok(()))) => {
                interface.search.clear();
                // The reply confirms the switches, because a switched effect may be invisible in this view; the switches apply to all later views.
                interface.show_reply(text!("search-effects-switched", effects = interface.viewer.view.effects.to_text()));
            }
            (None, Some(Err(why))) => interface.search.failure = Some(why),
            (None, None) => interface.search.failure = Some(not_found(interface)),
        }
        if interface.search.failure.is_some() {
            // After an error the user can type again at once.
            response.request_focus();
            select_all(ui.ctx(), response.id, &interface.search.typed);
        }
    }
    suggestion_list(interface, ui, catalog, response.rect, &found, &mut chosen);
    if let Some(target) = chosen {
        interface.search.clear();
        open_target(interface, ui.ctx(), worker, target, actions);
    }
}

/// Shows the view of the link in the field, or the link's errors.
fn open_link(interface: &mut Interface, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    match view_from_text(&interface.search.typed, worker.session(), interface.viewer.now()) {
        Ok(view) => {
            interface.search.clear();
            actions.push(Action::Show(Box::new(view)));
        }
        Err(e) => interface.search.failure = Some(error_text(&e)),
    }
}

/// The error for a text that matches nothing.
fn not_found(interface: &Interface) -> String {
    let text = interface.search.typed.trim();
    let quoted = echo_within(text, MAX_ECHO_CHARS);
    if parse_place_without_limits(text).is_some() {
        text!("search-no-place", typed = quoted)
    } else if resembles_date(text) {
        text!("time-no-date", typed = quoted)
    } else if mentions_events(text) {
        text!("search-no-event", typed = quoted)
    } else {
        text!("search-nothing", typed = quoted)
    }
}

/// Shows the list below the search field: suggestions, or the error and similar texts. `field_rect`: the field's rectangle. `chosen`: set to the target of
/// a clicked suggestion.
fn suggestion_list(
    interface: &Interface,
    ui: &egui::Ui,
    catalog: &Catalog,
    field_rect: egui::Rect,
    found: &[Suggestion],
    chosen: &mut Option<SearchTarget>,
) {
    let failure = interface.search.failure.as_ref();
    let zone = interface.settings.time_zone;
    let similar = if found.is_empty() { similar_texts(&interface.search.typed, &interface.viewer, catalog, zone) } else { Vec::new() };
    if found.is_empty() && failure.is_none() && similar.is_empty() {
        return;
    }
    let area = egui::Area::new(ui.scope_id().with("suggestions")).fixed_pos(field_rect.left_bottom()).order(egui::Order::Foreground);
    area.show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            if let Some(why) = failure {
                // The error wraps, because it may list names.
                let available_width = ui.ctx().content_rect().right() - field_rect.left() - LIST_MARGINS;
                ui.set_max_width(available_width.clamp(ERROR_WIDTH_RANGE[0], ERROR_WIDTH_RANGE[1]));
                let error_label = ui.add(Label::new(RichText::new(why).color(ui.visuals().warn_fg_color)).wrap());
                // Screen readers announce the error although the focus stays in the field.
                ui.ctx().accesskit_node_builder(error_label.id, |node| node.set_live(egui::accesskit::Live::Polite));
            }
            for (index, suggestion) in found.iter().enumerate() {
                if ui
                    .selectable_label(index == interface.search.highlighted, format!("{} · {}", suggestion.name, suggestion.about))
                    .clicked()
                {
                    *chosen = Some(suggestion.target.clone());
                }
            }
            for text in similar {
                let max_count = 1;
                let suggestion = suggestions(&text, &interface.viewer, catalog, zone, max_count).into_iter().next();
                if let Some(suggestion) = suggestion
                    && ui.selectable_label(false, text!("search-did-you-mean", name = text)).clicked()
                {
                    *chosen = Some(suggestion.target);
                }
            }
        });
    });
}

/// Applies the typed text if it has the syntax of `--effects`, such as `+eclipse` or `-rings`; otherwise returns `None`. An error is returned as a text.
fn apply_typed_effects(interface: &mut Interface) -> Option<Result<(), String>> {
    let typed = interface.search.typed.trim();
    if !typed.starts_with(['+', '-']) || !typed.contains(char::is_alphabetic) {
        return None;
    }
    let view = &mut interface.viewer.view;
    let combined = format!("{},{typed}", view.effects.to_text());
    Some(EffectOverrides::parse(&combined).map(|overrides| view.effects = overrides).map_err(|e| error_text(&e)))
}

/// Applies the chosen suggestion.
fn open_target(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker, target: SearchTarget, actions: &mut Vec<Action>) {
    interface.settings.hints_followed.search = true;
    let session = worker.session();
    let catalog = session.catalog();
    let positions = SessionPositions(session);
    match target {
        SearchTarget::Body(id) => actions.push(Action::FlyTo(id)),
        SearchTarget::Time(time) => actions.push(Action::SetTime(time)),
        SearchTarget::Place { latitude_deg, longitude_deg } => actions.push(Action::StandOn(latitude_deg, longitude_deg)),
        SearchTarget::City(city) => {
            // The city becomes the observer's place, which events and the times of rise and set use too.
            interface.information.choose_city(city);
            actions.extend([Action::Select(NaifId::EARTH), Action::StandOn(city.latitude_deg, city.longitude_deg)]);
            interface.show_reply(text!("search-city-chosen", city = city.name, country = catalog_text("country", city.country)));
        }
        SearchTarget::Feature { body, feature } => {
            if let Some(selectable_body) = interface.viewer.selectable_body(body) {
                actions.push(Action::Show(Box::new(surface_feature_view(feature, selectable_body, &interface.viewer.base_view()))));
            }
        }
        SearchTarget::Effect(_) => interface.open(ctx, Tab::Effects),
        SearchTarget::Key(key) => {
            interface.open(ctx, Tab::Shader);
            interface.shader.show_key(&key);
        }
        SearchTarget::Events { kinds, start } => {
            interface.open(ctx, Tab::Events);
            events::search_for(interface, worker, &kinds, start);
        }
        SearchTarget::Preset(preset) => moments::open_preset(interface, worker, preset, actions),
        SearchTarget::WhatToSeeNow(item) => {
            let view = item.view(session, interface.viewer.now(), &interface.viewer.base_view());
            match view {
                Some(view) => what_to_see_now::open(interface, ctx, worker, item, view, actions),
                None => interface.refuse_view(text!("outside-ephemeris", name = item.name())),
            }
        }
        SearchTarget::Moment(name) => {
            let moment = catalog.moments().iter().find(|m| m.name == name);
            match moment.and_then(|m| view_of_moment(m, catalog, &positions, &interface.viewer.base_view())) {
                Some(view) => actions.push(Action::Show(Box::new(view))),
                None => interface.refuse_view(text!("outside-ephemeris", name = catalog_text("moment", &name))),
            }
        }
        SearchTarget::Star(hip) => {
            let (stars, base_view) = (catalog.stars(), &interface.viewer.base_view());
            let years_since_epoch = stars.years_since_epoch(base_view.time().jd_tt());
            match stars.star_of_hip(hip).and_then(|star| star_view(star, years_since_epoch, &positions, base_view)) {
                Some(view) => {
                    actions.push(Action::Show(Box::new(view)));
                    interface.viewport.sky_object = stars.index_of_hip(hip).map(SkyObject::Star);
                }
                None => interface.refuse_view(text!("search-star-outside", hip = hip, body = interface.viewer.name(NaifId::EARTH))),
            }
        }
        SearchTarget::SmallBody(body) => {
            let (ephemeris, base_view) = (session.ephemeris(), interface.viewer.base_view());
            match small_body_view(&body, ephemeris, &positions, &base_view).zip(sight_from_earth(ephemeris, &base_view)) {
                Some((view, sight)) => {
                    actions.push(Action::Show(Box::new(view)));
                    interface.viewport.sky_object = SkyObject::of_small_body(&catalog.small_bodies(), &body);
                    interface.show_reply(sky_object::small_body_title(&body, &sight));
                }
                None => interface.refuse_view(text!("outside-ephemeris", name = body.full_name())),
            }
        }
        SearchTarget::Constellation(constellation) => match constellation_view(constellation, &positions, &interface.viewer.base_view()) {
            Some(view) => actions.push(Action::Show(Box::new(view))),
            None => interface.refuse_view(text!("outside-ephemeris", name = constellation.name)),
        },
    }
}
