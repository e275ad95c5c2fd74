//! Keyboard shortcuts, and the window that lists them.
//!
//! In: pressed keys and typed text. Out: actions, changed settings, opened and closed panels. Always: keys typed into a text field, except those with Ctrl and
//! the function keys, are not shortcuts. While another control has the focus, every key that this control does not use itself is a shortcut; a button uses
//! Space, Enter and the arrow keys. Not here: the mouse (`viewport`) and the keys of the timeline (`timeline`).

use super::{Interface, Tab};
use crate::view::app::settings::UI_SCALE_RANGE;
use crate::view::app::view_state::CameraPose;
use crate::view::app::viewer::Action;
use crate::view::language::{text, text_by_id};
use egui::text_selection::LabelSelectionState;
use egui::{Grid, Key, Label, Modifiers, Popup, ScrollArea, TextStyle, Vec2, vec2};

/// Message ids of the keys and of what they do, for the help window. Only the messages of `key-panels` have arguments.
const SHORTCUTS: &[(&str, &str)] = &[
    ("key-drag", "key-drag-does"),
    ("key-look", "key-look-does"),
    ("key-roll", "key-roll-does"),
    ("key-zoom", "key-zoom-does"),
    ("key-fov", "key-fov-does"),
    ("key-click", "key-click-does"),
    ("key-measure", "key-measure-does"),
    ("key-fly", "key-fly-does"),
    ("key-bodies", "key-bodies-does"),
    ("key-arrows", "key-arrows-does"),
    ("key-home", "key-home-does"),
    ("key-history", "key-history-does"),
    ("key-rotate", "key-rotate-does"),
    ("key-mirror", "key-mirror-does"),
    ("key-search", "key-search-does"),
    ("key-pause", "key-pause-does"),
    ("key-speed", "key-speed-does"),
    ("key-direction", "key-direction-does"),
    ("key-now", "key-now-does"),
    ("key-events", "key-events-does"),
    ("key-timeline", "key-timeline-does"),
    ("key-layers", "key-layers-does"),
    ("key-panels", "key-panels-does"),
    ("key-save", "key-save-does"),
    ("key-tab", "key-tab-does"),
    ("key-escape", "key-escape-does"),
    ("key-text-size", "key-text-size-does"),
    ("key-full-screen", "key-full-screen-does"),
    ("key-image-only", "key-image-only-does"),
    ("key-help", "key-help-does"),
    ("key-quit", "key-quit-does"),
];

/// Length of the drag to which a press of an arrow key is equivalent, pixels.
const ARROW_DRAG_PX: f64 = 24.0;
/// Change of the interface's scale by one key press.
const UI_SCALE_STEP: f32 = 0.1;
/// Roll of the camera by one key press, degrees.
const ROLL_STEP_DEG: f64 = 5.0;
/// Zoom by one key press, wheel notches.
const ZOOM_STEP_NOTCHES: f64 = 1.0;

/// The largest digit on a key: panels after the ninth have no shortcut.
const MAX_PANEL_DIGIT: usize = 9;

/// Width and height that the help window needs in addition to its rows, for its frame and title, points.
const HELP_FRAME: Vec2 = vec2(32.0, 56.0);
/// Largest width of the rows of the help window, as a multiple of the height of a line of text; longer texts wrap.
const HELP_WIDTH_IN_LINE_HEIGHTS: f32 = 72.0;

/// Handles the keys pressed in this frame.
pub(crate) fn handle_keys(interface: &mut Interface, ctx: &egui::Context, actions: &mut Vec<Action>) {
    return_focus(interface, ctx);
    if ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::F11)) {
        interface.fullscreen = !interface.fullscreen;
    }
    let take_ctrl_key = |key: Key| ctx.input_mut(|i| i.consume_key(Modifiers::COMMAND, key));
    let ui_scale = &mut interface.settings.ui_scale;
    if take_ctrl_key(Key::Plus) || take_ctrl_key(Key::Equals) {
        *ui_scale = (*ui_scale + UI_SCALE_STEP).min(*UI_SCALE_RANGE.end());
    } else if take_ctrl_key(Key::Minus) {
        *ui_scale = (*ui_scale - UI_SCALE_STEP).max(*UI_SCALE_RANGE.start());
    } else if take_ctrl_key(Key::Num0) {
        *ui_scale = 1.0;
    }
    if take_ctrl_key(Key::Q) {
        interface.quit_requested = true;
    }
    if take_ctrl_key(Key::S) {
        // `share::update` saves the image to a file.
        interface.share.wants_image = true;
    }
    // Letters typed into a text field are not shortcuts. A control that got the focus after the last frame may be a text field that egui has not shown yet.
    let focused = ctx.memory(|m| m.focused());
    if ctx.text_edit_focused() || (focused.is_some() && focused != interface.last_focus) {
        return;
    }
    let typed_texts: Vec<String> = ctx.input(|i| {
        let has_ctrl = i.modifiers.command || i.modifiers.ctrl;
        let texts = i.events.iter().filter_map(|e| if let egui::Event::Text(text) = e { Some(text.clone()) } else { None });
        if has_ctrl { Vec::new() } else { texts.collect() }
    });
    for text in typed_texts {
        // Caps Lock makes no difference: no shortcut needs a capital letter.
        match text.to_lowercase().as_str() {
            "u" => interface.toggle_image_only(ctx),
            // Keys that show a control show all of them if they are hidden.
            "/" => {
                interface.show_controls();
                interface.search.wants_focus = true;
            }
            "?" => interface.help_shown = interface.show_controls() || !interface.help_shown,
            "b" => interface.body_browser_shown = interface.show_controls() || !interface.body_browser_shown,
            "n" => interface.settings.labels_bodies = !interface.settings.labels_bodies,
            "m" => interface.settings.marks_small_bodies = !interface.settings.marks_small_bodies,
            "e" => interface.time_bar.wants_next_event = true,
            "p" => interface.time_bar.wants_previous_event = true,
            "i" => {
                let is_shown = interface.show_controls() || !interface.settings.panels.timeline_shown;
                interface.settings.panels.timeline_shown = is_shown;
            }
            "x" => interface.settings.outlines_selected = !interface.settings.outlines_selected,
            "o" => interface.viewer.view.orbits = !interface.viewer.view.orbits,
            "h" => interface.viewer.view.is_mirrored = !interface.viewer.view.is_mirrored,
            "g" => actions.push(Action::FlyTo(interface.viewer.selected)),
            "f" => {
                let rotates_with_body = matches!(interface.viewer.view.camera_pose, CameraPose::Orbit { is_body_fixed: true, .. });
                actions.push(Action::RotateWithBody(!rotates_with_body));
            }
            "[" => actions.push(Action::Roll(-ROLL_STEP_DEG)),
            "]" => actions.push(Action::Roll(ROLL_STEP_DEG)),
            "+" | "=" => actions.push(Action::Zoom(ZOOM_STEP_NOTCHES)),
            "-" => actions.push(Action::Zoom(-ZOOM_STEP_NOTCHES)),
            "." => actions.push(Action::Faster),
            "," => actions.push(Action::Slower),
            "l" => actions.push(Action::TimeForward),
            "j" => actions.push(Action::TimeBackward),
            "t" => actions.push(Action::Now),
            " " if focused.is_some() => {}
            " " => {
                // If Space pauses or continues a tour, it does not also pause or continue the clock: a playing tour sets the time itself.
                if !interface.tour.toggle() {
                    actions.push(Action::TogglePause);
                }
            }
            typed => {
                if let Some(tab) = Tab::of_digit(typed) {
                    interface.toggle(ctx, tab);
                }
            }
        }
    }
    if ctx.input(|i| i.events.contains(&egui::Event::Copy)) {
        ctx.copy_text(interface.viewer.shareable_view().to_link());
        // At the end of the frame, egui copies the selected text of a label instead. A mere click on a label counts as a selection, too, but without text; the
        // link is then what was copied. The two cases cannot be told apart here, so the reply to a selection does not say what was copied.
        let may_have_selected_text = ctx.plugin::<LabelSelectionState>().lock().has_selection();
        interface.show_reply(if may_have_selected_text { text!("copied") } else { text!("link-copied") });
    }
    let take_key = |key: Key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
    // On Escape egui itself closes an open menu. egui has also removed the keyboard focus already, so `close_topmost` asks whether a control had the
    // focus in the last frame.
    if !Popup::is_any_open(ctx) && take_key(Key::Escape) {
        close_topmost(interface, ctx);
    }
    if ctx.input_mut(|i| i.consume_key(Modifiers::SHIFT, Key::Backspace)) {
        actions.push(Action::NextView);
    }
    let is_taken = |key: Key| match key {
        Key::ArrowRight | Key::ArrowLeft | Key::ArrowUp | Key::ArrowDown => focused.is_some(),
        Key::PageDown | Key::PageUp | Key::Home => focused.is_some_and(|control| interface.shader.is_list_of_lines(control)),
        _ => false,
    };
    for (key, action) in [
        (Key::PageDown, Action::FlyAlongList(1)),
        (Key::PageUp, Action::FlyAlongList(-1)),
        (Key::Home, Action::FaceBody),
        (Key::Backspace, Action::PreviousView),
        (Key::ArrowRight, Action::Turn(ARROW_DRAG_PX, 0.0)),
        (Key::ArrowLeft, Action::Turn(-ARROW_DRAG_PX, 0.0)),
        (Key::ArrowUp, Action::Turn(0.0, ARROW_DRAG_PX)),
        (Key::ArrowDown, Action::Turn(0.0, -ARROW_DRAG_PX)),
    ] {
        if !is_taken(key) && take_key(key) {
            actions.push(action);
        }
    }
}

/// When Escape closes a menu or list that was opened with the keyboard, gives the focus back to its button. egui itself only takes the focus away.
fn return_focus(interface: &mut Interface, ctx: &egui::Context) {
    if !Popup::is_any_open(ctx) {
        interface.focused_before_menu = ctx.memory(|m| m.focused());
    } else if let Some(button) = interface.focused_before_menu
        && ctx.input(|i| i.key_pressed(Key::Escape))
    {
        ctx.memory_mut(|m| m.request_focus(button));
    }
}

/// Handles Escape: closes or ends the first of these that is present: warning, image without bars and panels, search, keyboard focus, measured angle,
/// tour, help, open panel, kept panel (the second panel, on the other side of the viewport) if it is visible, full screen. Escape never ends the program;
/// closing its window or Ctrl+Q does.
fn close_topmost(interface: &mut Interface, ctx: &egui::Context) {
    let had_focus = interface.last_focus.take().is_some();
    if interface.warning.take().is_some() || interface.show_controls() {
        return;
    }
    if interface.search.clear() || had_focus || interface.angle.clear() || interface.tour.end() {
        return;
    }
    if std::mem::take(&mut interface.help_shown) || interface.tab.take().is_some() {
        return;
    }
    // A kept panel for which the window is too narrow stays kept.
    if interface.visible_kept(ctx).is_some() {
        interface.kept_tab = None;
    } else {
        interface.fullscreen = false;
    }
}

/// Shows the window that lists the shortcuts. Its texts wrap and its rows scroll as the program's window requires.
pub(crate) fn help(interface: &mut Interface, ctx: &egui::Context) {
    let panels = Tab::ALL.map(|tab| interface.language.inside_sentence(tab.title())).join(", ");
    let available = (ctx.content_rect().size() - HELP_FRAME).max(Vec2::ZERO);
    egui::Window::new(text!("help-title")).open(&mut interface.help_shown).resizable(false).show(ctx, |ui| {
        let width = available.x.min(HELP_WIDTH_IN_LINE_HEIGHTS * ui.text_style_height(&TextStyle::Body));
        // egui limits the height to the height in the last frame; the minimum lets the rows grow again with the program's window.
        ScrollArea::vertical().max_height(available.y).min_scrolled_height(available.y).show(ui, |ui| {
            ui.set_max_width(width);
            Grid::new("sheet").num_columns(2).min_row_height(0.0).striped(true).show(ui, |ui| {
                for (keys_id, description_id) in SHORTCUTS {
                    let (keys, description) = match *keys_id {
                        "key-panels" => {
                            (text!("key-panels", last = Tab::ALL.len().min(MAX_PANEL_DIGIT)), text!("key-panels-does", panels = panels))
                        }
                        _ => (text_by_id(keys_id).to_owned(), text_by_id(description_id).to_owned()),
                    };
                    ui.strong(keys);
                    ui.add(Label::new(description).wrap());
                    ui.end_row();
                }
            });
        });
    });
}
