//! The panels at the sides of the viewport: the list of bodies, the open panel, and a second panel that the user keeps open.
//!
//! In: which panels are open, and their widths from the settings. Out: the panels' content, and the widths to which the user dragged them. Always: the open
//! panel and the kept panel are on opposite sides of the viewport. They leave [`MIN_VIEWPORT_WIDTH`] of it, unless the window has no room for a panel of
//! [`MIN_PANEL_WIDTH`] beside that; a window that is too narrow for the stored widths does not change these. The kept panel is hidden while the window is too
//! narrow for two panels; the list of bodies is hidden while it has no room beside the panels, but neither comes nor goes while the edge of a panel is
//! dragged. Controls do not widen a panel: they wrap or scroll, all of them together if the panel is too low. A panel whose title is dragged to the other half
//! of the window moves there, and the other panel takes its side. A panel for which the window has become too narrow reads a typed number before it is hidden.

use super::icons::{self, Icon};
use super::{Interface, Tab, body_browser, camera_controls, number_field};
use crate::view::app::settings::{PanelLayout, valid_width};
use crate::view::app::viewer::Action as ViewerAction;
use crate::view::language::text;
use crate::view::worker::render_worker::RenderWorker;
use egui::accesskit::Action;
use egui::containers::panel::PanelState;
use egui::{Align, CursorIcon, Id, Label, Layout, Panel, Rangef, Rect, RichText, ScrollArea, Sense, Ui, UiBuilder, Vec2};

/// Minimum width of the list of bodies, points.
const MIN_BODIES_WIDTH: f32 = 190.0;
/// Minimum width of a panel, points.
const MIN_PANEL_WIDTH: f32 = 280.0;
/// Width of a panel that is not wide, until the user changes it, points.
const PANEL_WIDTH: f32 = 330.0;
/// Width of a wide panel, until the user changes it, points.
const WIDE_PANEL_WIDTH: f32 = 560.0;
/// Minimum width of the viewport beside panels, points.
const MIN_VIEWPORT_WIDTH: f32 = 320.0;
/// Minimum width of a window for two panels, points.
const MIN_WIDTH_FOR_TWO_PANELS: f32 = 1000.0;
/// Minimum width of a window for the list of bodies beside a panel, points.
const MIN_WIDTH_FOR_BODIES: f32 = 800.0;
/// Minimum width of a window for the list of bodies beside a wide panel, points.
const MIN_WIDTH_FOR_BODIES_AND_WIDE_PANEL: f32 = MIN_BODIES_WIDTH + WIDE_PANEL_WIDTH + MIN_VIEWPORT_WIDTH;

impl Tab {
    /// The panel's width until the user changes it, points.
    fn default_width(self) -> f32 {
        if self.is_wide() { WIDE_PANEL_WIDTH } else { PANEL_WIDTH }
    }
}

/// Minimum width of a window for the list of bodies beside the open panel and the visible kept panel, points. Each of them is given with its width, to which
/// the user may have dragged it.
fn min_width_for_bodies(open: Option<(Tab, f32)>, kept: Option<(Tab, f32)>) -> f32 {
    let beside_default = match (open, kept) {
        (Some((open, _)), Some((kept, _))) => MIN_BODIES_WIDTH + open.default_width() + kept.default_width() + MIN_VIEWPORT_WIDTH,
        (Some((tab, _)), None) | (None, Some((tab, _))) if tab.is_wide() => MIN_WIDTH_FOR_BODIES_AND_WIDE_PANEL,
        (Some(_), None) | (None, Some(_)) => MIN_WIDTH_FOR_BODIES,
        (None, None) => 0.0,
    };
    // A point is left out, because widths are rounded to pixels.
    let excess = |(tab, width): (Tab, f32)| (width - tab.default_width() - 1.0).max(0.0);
    beside_default + open.map_or(0.0, excess) + kept.map_or(0.0, excess)
}

impl Interface {
    /// The kept panel, if the window is wide enough for it.
    pub(super) fn visible_kept(&self, ctx: &egui::Context) -> Option<Tab> {
        self.kept_tab.filter(|_| ctx.content_rect().width() >= MIN_WIDTH_FOR_TWO_PANELS)
    }

    /// Whether the panel is visible on either side of the viewport.
    pub(crate) fn is_open(&self, ctx: &egui::Context, tab: Tab) -> bool {
        self.tab == Some(tab) || self.visible_kept(ctx) == Some(tab)
    }

    /// Opens a panel, unless it is visible as the kept panel. Hidden bars and panels come back.
    pub(crate) fn open(&mut self, ctx: &egui::Context, tab: Tab) {
        self.show_controls();
        if self.visible_kept(ctx) == Some(tab) {
            return;
        }
        self.kept_tab.take_if(|kept| *kept == tab);
        self.tab = Some(tab);
    }

    /// Opens a panel, or closes it if it is visible.
    pub(crate) fn toggle(&mut self, ctx: &egui::Context, tab: Tab) {
        if self.image_only {
            // An open panel that is hidden with all others is shown, not closed.
            self.open(ctx, tab);
        } else if self.visible_kept(ctx) == Some(tab) {
            self.kept_tab = None;
        } else if self.tab == Some(tab) {
            self.tab = None;
        } else {
            self.open(ctx, tab);
        }
    }
}

/// The name under which egui stores the width of a panel. Wide panels have names of their own, so that they do not take the width of the others.
fn egui_name(tab: Tab, is_kept: bool) -> &'static str {
    match (tab.is_wide(), is_kept) {
        (false, false) => "open panel",
        (true, false) => "wide open panel",
        (false, true) => "kept panel",
        (true, true) => "wide kept panel",
    }
}

/// The width of a panel in the settings.
fn stored_width(panels: &mut PanelLayout, tab: Tab, is_kept: bool) -> &mut Option<f32> {
    match (tab.is_wide(), is_kept) {
        (false, false) => &mut panels.panel_width,
        (true, false) => &mut panels.wide_width,
        (false, true) => &mut panels.kept_width,
        (true, true) => &mut panels.kept_wide_width,
    }
}

/// The width of a panel where it has room, points: the one to which the user dragged it, or the default.
fn wanted_width(panels: &mut PanelLayout, tab: Tab, is_kept: bool) -> f32 {
    valid_width(*stored_width(panels, tab, is_kept), tab.default_width()).max(MIN_PANEL_WIDTH)
}

/// The largest width of a panel in a room of this width, of which another panel takes `other_width`, points: some of the viewport stays visible.
fn max_panel_width(room_width: f32, other_width: f32) -> f32 {
    (room_width - other_width - MIN_VIEWPORT_WIDTH).max(MIN_PANEL_WIDTH)
}

/// The name under which egui stores the width of the list of bodies.
const BODIES_NAME: &str = "bodies";

/// The id that egui gives to the edge of the panel of this name.
fn edge_id(ui: &Ui, name: &str) -> Id {
    ui.scope_id().with(name).with("__resize")
}

/// Whether the user drags the edge of this panel, or has dropped it in this frame.
fn is_edge_dragged(ui: &Ui, name: &str) -> bool {
    ui.ctx().read_response(edge_id(ui, name)).is_some_and(|edge| edge.dragged() || edge.drag_stopped())
}

/// Name under which egui stores which panel shows the control with the focus.
const FOCUSED_PANEL: &str = "panel with the focus";

/// A panel that showed the control with the focus when it was last shown.
#[derive(Clone, Copy)]
struct FocusedPanel {
    panel: Id,
    control: Id,
}

/// The control with the focus, if it has been shown in this pass.
fn shown_focus(ui: &Ui) -> Option<Id> {
    let focused = ui.memory(|memory| memory.focused())?;
    ui.ctx().viewport(|viewport| viewport.this_pass.widgets.contains(focused)).then_some(focused)
}

/// Whether this panel is shown for one more pass although the window no longer has room for it: a text in it is being edited, which egui would drop. In this
/// pass the field loses the focus and reads its text; while it is being typed, in a later one.
fn must_read_text(ui: &Ui, name: &str) -> bool {
    let ctx = ui.ctx();
    let Some(focused) = ctx.memory(|memory| memory.focused()).filter(|_| ctx.text_edit_focused()) else { return false };
    let last = ctx.data(|data| data.get_temp::<FocusedPanel>(Id::unique(FOCUSED_PANEL)));
    let is_in_panel = last.is_some_and(|last| last.panel == ui.scope_id().with(name) && last.control == focused);
    if !is_in_panel {
        return false;
    }
    if !number_field::may_change_text(ui) {
        ctx.memory_mut(|memory| memory.surrender_focus(focused));
    }
    ctx.request_repaint();
    true
}

/// Shows a panel of this width, or of the nearest width in a range. Returns its new width if the user drags its edge. `name`: of `panel`.
fn show_panel(ui: &mut Ui, panel: Panel, name: &str, width: f32, widths: Rangef, add_contents: impl FnOnce(&mut Ui)) -> Option<f32> {
    let id = ui.scope_id().with(name);
    // egui would keep the width that a small window has enforced in a wider window, too.
    ui.ctx().data_mut(|data| data.remove::<PanelState>(id));
    let focus_before = shown_focus(ui);
    let shown_width = panel.default_size(width).size_range(widths).show(ui, add_contents).response.rect.width();
    if let Some(control) = shown_focus(ui).filter(|_| focus_before.is_none()) {
        ui.ctx().data_mut(|data| data.insert_temp(Id::unique(FOCUSED_PANEL), FocusedPanel { panel: id, control }));
    }
    let (edge, is_dragged) = (edge_id(ui, name), is_edge_dragged(ui, name));
    let by_assistive_technology = [Action::Increment, Action::Decrement, Action::SetValue];
    let is_set = ui.input(|input| by_assistive_technology.into_iter().any(|action| input.has_accesskit_action_request(edge, action)));
    (is_dragged || is_set).then_some(shown_width)
}

/// Shows the list of bodies and the open panels, and stores the widths that the user set.
pub(crate) fn show(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<ViewerAction>) {
    let (window_width, room_width) = (ui.ctx().content_rect().width(), ui.available_width());
    // A click in this frame may close one of these panels or move it to the other side; the next frame shows that. No panel is shown twice in a frame.
    let visible_kept = interface.visible_kept(ui.ctx());
    let kept = visible_kept.or_else(|| interface.kept_tab.filter(|tab| must_read_text(ui, egui_name(*tab, true))));
    let open = interface.tab;
    let panels = &mut interface.settings.panels;
    let min_open_width = open.map_or(0.0, |_| MIN_PANEL_WIDTH);
    let kept_width = kept.map_or(0.0, |tab| wanted_width(panels, tab, true).min(max_panel_width(room_width, min_open_width)));
    let open_width = open.map_or(0.0, |tab| wanted_width(panels, tab, false).min(max_panel_width(room_width, kept_width)));
    // During a drag the list would push a panel at the left aside, and its edge away from the pointer.
    let shown_panels = [(open, false), (kept, true)];
    let names = shown_panels.into_iter().filter_map(|(tab, is_kept)| Some(egui_name(tab?, is_kept)));
    if !names.chain([BODIES_NAME]).any(|name| is_edge_dragged(ui, name)) {
        let min_width = min_width_for_bodies(open.map(|tab| (tab, open_width)), kept.map(|tab| (tab, kept_width)));
        interface.bodies_have_room = window_width >= min_width;
    }
    let has_bodies = interface.body_browser_shown && (interface.bodies_have_room || must_read_text(ui, BODIES_NAME));
    if has_bodies {
        let width = *interface.settings.panels.bodies_width.get_or_insert(MIN_BODIES_WIDTH);
        let width = valid_width(Some(width), MIN_BODIES_WIDTH);
        let widths = Rangef::new(MIN_BODIES_WIDTH, (room_width - open_width - kept_width - MIN_VIEWPORT_WIDTH).max(MIN_BODIES_WIDTH));
        let new_width = show_panel(ui, Panel::left(BODIES_NAME), BODIES_NAME, width, widths, |ui| {
            // The controls below the list scroll if they are taller than this.
            let max_height = 0.6 * ui.available_height();
            Panel::bottom("camera controls").show(ui, |ui| {
                ScrollArea::vertical()
                    .max_height(max_height)
                    .min_scrolled_height(max_height)
                    .show(ui, |ui| camera_controls::panel(interface, ui, actions));
            });
            body_browser::tree(interface, ui, actions);
        });
        interface.settings.panels.bodies_width = new_width.or(interface.settings.panels.bodies_width);
    }
    // The kept panel is on the other side.
    let open_is_on_left = interface.settings.panels.on_left;
    if let Some(tab) = kept {
        let is_kept = true;
        let name = egui_name(tab, is_kept);
        let panel = if open_is_on_left { Panel::right(name) } else { Panel::left(name) };
        // Beside the list of bodies it leaves the open panel its width: otherwise the list would disappear, and move the panel, at the end of a drag.
        let other_width = if has_bodies { open_width } else { min_open_width };
        let widths = Rangef::new(MIN_PANEL_WIDTH, max_panel_width(ui.available_width(), other_width));
        let new_width = show_panel(ui, panel, name, kept_width, widths, |ui| content(interface, ui, tab, worker, actions));
        remember_width(interface, tab, is_kept, new_width);
    }
    if let Some(tab) = open {
        let is_kept = false;
        let name = egui_name(tab, is_kept);
        let panel = if open_is_on_left { Panel::left(name) } else { Panel::right(name) };
        let widths = Rangef::new(MIN_PANEL_WIDTH, max_panel_width(ui.available_width(), 0.0));
        let new_width = show_panel(ui, panel, name, open_width, widths, |ui| content(interface, ui, tab, worker, actions));
        remember_width(interface, tab, is_kept, new_width);
    }
    interface.settings.panels.bodies_shown = interface.body_browser_shown;
    interface.settings.panels.open_panel = interface.tab.map(|tab| tab.name().to_owned());
    interface.settings.panels.kept_panel = interface.kept_tab.map(|tab| tab.name().to_owned());
}

/// Stores the width to which the user dragged a panel; if there is none yet, the default.
fn remember_width(interface: &mut Interface, tab: Tab, is_kept: bool, new_width: Option<f32>) {
    let stored = stored_width(&mut interface.settings.panels, tab, is_kept);
    *stored = new_width.or(*stored).or(Some(tab.default_width()));
}

/// Shows a panel's title, and below it its controls. They scroll in both directions if the panel has no room for them; otherwise egui would widen the panel,
/// or cut them off if the window has no room for a wider panel. A list within a panel fills the rest of it, but has a minimum height
/// ([`MIN_LIST_HEIGHT`](super::theme::MIN_LIST_HEIGHT)): while even this minimum does not fit, the wheel moves the list first and then the whole panel.
fn content(interface: &mut Interface, ui: &mut Ui, tab: Tab, worker: &dyn RenderWorker, actions: &mut Vec<ViewerAction>) {
    heading(interface, ui, tab);
    // Each panel has an id of its own, the same on both sides of the viewport, so that it keeps its scroll positions and open sections.
    let id = Id::unique(("panel", tab.name()));
    ui.scope_builder(UiBuilder::new().scope_id(id), |ui| {
        // Without the minimum of 0, the controls would lie over the time bar in a very low window.
        ScrollArea::both().auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
            // One point less, because positions are rounded to pixels: controls as large as the panel would scroll by a fraction of a point.
            // `Ui::set_max_height()` would not do: it keeps later controls within this height by placing them over one another.
            let available = ui.available_rect_before_wrap();
            let room = Rect::from_min_size(available.min, (available.size() - Vec2::splat(1.0)).max(Vec2::ZERO));
            ui.scope_builder(UiBuilder::new().max_rect(room), |ui| tab.show(interface, ui, worker, actions));
        });
    });
}

/// Shows the title of a panel, by which it can be dragged to the other side, and the buttons that close it and keep it open.
fn heading(interface: &mut Interface, ui: &mut Ui, tab: Tab) {
    ui.horizontal(|ui| {
        let title = ui.add(Label::new(RichText::new(tab.title()).heading()).selectable(false).sense(Sense::DRAG));
        let title = title.on_hover_cursor(CursorIcon::Grab).on_hover_text(text!("panel-move-hint"));
        if title.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        }
        if let Some(pointer) = title.interact_pointer_pos().filter(|_| title.drag_stopped()) {
            let is_dropped_on_left = pointer.x < ui.ctx().content_rect().center().x;
            // `on_left` is the side of the open panel; the kept panel is on the other side.
            interface.settings.panels.on_left = is_dropped_on_left == (interface.tab == Some(tab));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let is_kept = interface.kept_tab == Some(tab);
            let close = icons::icon_button(ui, Icon::Close, &text!("panel-close", panel = tab.title()));
            if close.on_hover_text(text!("panel-close-hint")).clicked() {
                interface.toggle(ui.ctx(), tab);
            }
            if ui.ctx().content_rect().width() >= MIN_WIDTH_FOR_TWO_PANELS {
                let keep = ui.selectable_label(is_kept, text!("panel-keep"));
                if keep.on_hover_text(text!("panel-keep-hint")).clicked() {
                    // Either way, this panel changes sides. The previously kept panel takes its place; a panel on the new side is closed.
                    (interface.tab, interface.kept_tab) = if is_kept { (Some(tab), None) } else { (interface.kept_tab, Some(tab)) };
                }
            }
        });
    });
}
