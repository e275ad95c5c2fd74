//! The viewport: shows the image, its labels and messages, and turns mouse input over it into actions.
//!
//! In: the last image with its scene, messages, the mouse. Out: what is painted, actions, the picked pixel and object of the sky, measured angles. Always: the
//! image is never stretched; the names of bodies avoid what the interface shows over the image; a click means what was under the pointer at the press, although
//! another image may arrive before the release: of a running clock, or of a typed number that counts from the press on. A picked pixel is a place in the
//! viewport, the pressed one: the probe shows what every image has there, the new one and all later ones, as its cross does.

use super::angle::SeenBody;
use super::icons::{self, Icon};
use super::render_loop::SeenPlace;
use super::sky_object::{self, MARKER_RADIUS_POINTS, NAME_COLOUR, NAME_POINTS};
use super::{Interface, tour, what_to_see_now};
use crate::catalog::NaifId;
use crate::scene::Scene;
use crate::scene::labels::{self, LabelMetrics, MARKER_OPACITY, SkyObject, body_at, snapped_px};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::session::Session;
use crate::view::app::orbit_camera::LOG_HEIGHT_PER_NOTCH;
use crate::view::app::viewer::Action;
use crate::view::language::text;
use crate::view::panels::theme::{HEADING_TEXT_POINTS, HIGHLIGHT_COLOUR, menu_style};
use crate::view::window::primitives::SCENE_IMAGE;
use crate::view::worker::render_worker::RenderWorker;
use egui::{Align2, Color32, FontId, PointerButton, Popup, Pos2, Rect, Sense, Stroke, Vec2};
use glam::{DVec2, DVec3};

/// Texts of the image whose upper edge is farther from the image's upper edge than this fraction of its height belong to the caption or the scale bar.
const CAPTION_TOP_FRACTION: f64 = 0.85;
/// Minimum width of the viewport for hints, points.
const MIN_WIDTH_FOR_HINTS: f32 = 440.0;
/// Distance of the message from the viewport's left edge and from what is below the message, points.
const MESSAGE_GAP: f32 = 8.0;
/// Width of the viewport that the message leaves free, points.
const MESSAGE_FREE_WIDTH: f32 = 40.0;
/// Smallest width at which the message wraps, points.
const MIN_MESSAGE_WIDTH: f32 = 60.0;
/// Distances of the two ends of an arm of the probe's cross from the pixel, points.
const PROBE_ARM_ENDS: [f32; 2] = [3.0, 9.0];
/// Scroll distance that egui reports for one notch of most wheels, points.
pub(super) const POINTS_PER_NOTCH: f64 = 50.0;
/// Roll of the camera per pixel of a drag with the middle button, degrees.
const ROLL_DEG_PER_PX: f64 = 0.25;

/// Shows the viewport in the room that the panels leave.
pub(crate) fn show(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let viewport = ui.available_rect_before_wrap();
    let pixels_per_point = ui.ctx().pixels_per_point();
    let to_px = |points: f32| ((points * pixels_per_point).round() as u32).clamp(1, MAX_IMAGE_PX);
    interface.viewport.size_px = [to_px(viewport.width()), to_px(viewport.height())];
    interface.settings.panels.viewport_px = interface.viewport.size_px;
    let response = ui.interact(viewport, ui.scope_id().with("sky"), Sense::click_and_drag());
    let accessible_name = text!("sky-of", body = interface.viewer.name(interface.viewer.view.target));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &accessible_name));
    ui.painter().rect_filled(viewport, 0.0, Color32::BLACK);
    // The overlays of the last frame; those of this frame are collected anew.
    let overlays = std::mem::take(&mut interface.viewport.overlays);
    if !interface.image_only {
        tour::show(interface, ui, viewport);
    }
    let Some(size_px) = interface.shown().map(|rendered| [rendered.width, rendered.height]) else {
        if interface.message_line().is_empty() {
            ui.painter().text(
                viewport.center(),
                Align2::CENTER_CENTER,
                text!("drawing"),
                FontId::proportional(HEADING_TEXT_POINTS),
                NAME_COLOUR,
            );
        } else {
            show_message(interface, ui, viewport);
        }
        return;
    };
    let placement = ImagePlacement::of(size_px, viewport, interface.viewport.size_px);
    let texture_id = interface.gpu_image().map(|_| SCENE_IMAGE).or(interface.viewport.texture.as_ref().map(egui::TextureHandle::id));
    if let Some(texture_id) = texture_id {
        let visible = placement.image.intersect(viewport);
        ui.painter().image(texture_id, visible, placement.uv_within(visible), Color32::WHITE);
    }
    let metrics = LabelMetrics::of_size(f64::from(NAME_POINTS) / placement.points_per_px);
    let to_image_px = |overlay: &Rect| {
        let [min, max] = [overlay.min, overlay.max]
            .map(|corner| corner - placement.image.min)
            .map(|offset| DVec2::new(offset.x.into(), offset.y.into()));
        labels::Rect { min: min / placement.points_per_px, max: max / placement.points_per_px }
    };
    interface.refresh_labels(&metrics, overlays.iter().map(to_image_px));
    interface.viewport.caption_height = caption_height(interface, &placement);
    paint_labels(interface, ui, viewport, &placement);
    let to_point = |px: DVec2| placement.image.min + egui_vec(px * placement.points_per_px);
    sky_object::paint(interface, &ui.painter().with_clip_rect(viewport), worker.session(), placement.points_per_px, to_point);
    if let Some(rendered) = interface.shown() {
        let scene = &rendered.scene;
        let point_of = |px: DVec2| placement.image.min + egui_vec(px * placement.points_per_px);
        interface.angle.paint(
            &ui.painter().with_clip_rect(viewport),
            |direction| scene.geometry.pixel_of(&scene.camera, direction).map(point_of),
            |from, to| scene.geometry.is_cut_between(from, to),
        );
    }
    let place = pressed_place(interface, worker.session(), &response, &placement, viewport);
    if let Some(click) = handle_mouse(ui, &response, place, actions) {
        handle_click(interface, worker, click);
    }
    context_menu(interface, &response, place, actions);
    if !interface.image_only {
        what_to_see_now::show_over_viewport(interface, ui, worker, viewport, actions);
    }
    show_message(interface, ui, viewport);
    if !interface.image_only && !interface.tour.is_open() && interface.warning.is_none() {
        hints(interface, ui, viewport);
    }
    if interface.viewport.overlays != overlays {
        // In the next frame the names of bodies avoid the new overlays.
        ui.ctx().request_repaint();
    }
    if !interface.image_only && interface.is_open(ui.ctx(), super::Tab::Shader) && interface.shader.shows_probe() {
        paint_probe(interface, ui, viewport);
    }
}

/// Position of the image in the window. An image whose aspect ratio differs from the viewport's is scaled to the viewport's height. Since
/// the field of view spans the height, the image then shows bodies where the next image will show them. Such an image is cropped at its sides or
/// leaves black margins; it is never stretched.
struct ImagePlacement {
    /// The rectangle of the entire image, points.
    image: Rect,
    /// Points per pixel of the image, which may be coarse.
    points_per_px: f64,
}

impl ImagePlacement {
    /// The placement of an image of the given size in pixels. `viewport`, `viewport_px`: the viewport in points, and its size in pixels.
    fn of([width, height]: [u32; 2], viewport: Rect, viewport_px: [u32; 2]) -> Self {
        let [viewport_width, viewport_height] = viewport_px.map(u64::from);
        // The sides of a coarse image are those of the viewport, divided by a factor and rounded up, each by less than a pixel. So each product below exceeds
        // the product of the exact sides by less than one side of the viewport.
        let has_viewport_aspect =
            (u64::from(width) * viewport_height).abs_diff(u64::from(height) * viewport_width) <= viewport_width.max(viewport_height);
        if has_viewport_aspect {
            return Self { image: viewport, points_per_px: f64::from(viewport.width()) / f64::from(width) };
        }
        let points_per_px = viewport.height() / height as f32;
        let image = Rect::from_center_size(viewport.center(), Vec2::new(width as f32 * points_per_px, viewport.height()));
        Self { image, points_per_px: f64::from(points_per_px) }
    }

    /// The pixel of the image under a point of the interface; in the right half of a side-by-side pair, the corresponding pixel of the left
    /// half.
    fn image_px_of(&self, point: Pos2, scene: &Scene) -> DVec2 {
        let offset = point - self.image.min;
        scene.geometry.left_eye_px(DVec2::new(f64::from(offset.x), f64::from(offset.y)) / self.points_per_px)
    }

    /// Texture coordinates of a rectangle of the interface inside the image.
    fn uv_within(&self, part: Rect) -> Rect {
        let uv = |p: Pos2| ((p - self.image.min) / self.image.size()).to_pos2();
        Rect::from_min_max(uv(part.min), uv(part.max))
    }
}

/// Height of the image's caption and scale bar above the viewport's lower edge, points; messages are shown above caption and scale bar.
fn caption_height(interface: &Interface, placement: &ImagePlacement) -> f32 {
    let Some(rendered) = interface.shown() else { return 0.0 };
    let (height, layers) = (f64::from(rendered.height), rendered.job.request.layers);
    if !(layers.caption || layers.scale_bar) {
        return 0.0;
    }
    let caption_rects = rendered.scene.text_and_bar_rects().into_iter().filter(|rect| rect.min.y > CAPTION_TOP_FRACTION * height);
    (caption_rects.map(|rect| height - rect.min.y).fold(0.0, f64::max) * placement.points_per_px) as f32
}

/// Shows the message line over the lower edge of the image, so that the image keeps its size. The line is above the overlays that would cover it: the
/// bar of a tour, the row *What to see now*. While there is no image of the view, the message is the reason why there is none. The reply to the last action is
/// then added below: otherwise an action would seem to have no effect.
fn show_message(interface: &mut Interface, ui: &egui::Ui, viewport: Rect) {
    let mut message = interface.message_line().to_owned();
    if message.is_empty() {
        return;
    }
    if interface.failure_reason.is_some() && !interface.reply_text().is_empty() {
        message = format!("{message}\n{}", interface.reply_text());
    }
    let area = egui::Area::new(ui.scope_id().with("message")).order(egui::Order::Middle).pivot(Align2::LEFT_BOTTOM);
    let lower_overlays = interface.viewport.overlays.iter().filter(|overlay| overlay.center().y > viewport.center().y);
    let bottom = lower_overlays.map(|overlay| overlay.top()).fold(viewport.bottom() - interface.viewport.caption_height, f32::min);
    let corner = Pos2::new(viewport.left() + MESSAGE_GAP, bottom - MESSAGE_GAP);
    let shown_area = area.fixed_pos(corner).interactable(false).show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((viewport.width() - MESSAGE_FREE_WIDTH).max(MIN_MESSAGE_WIDTH));
            let line = ui.colored_label(ui.visuals().warn_fg_color, message);
            // Screen readers announce the message although it has no focus.
            ui.ctx().accesskit_node_builder(line.id, |node| node.set_live(egui::accesskit::Live::Polite));
        });
    });
    interface.viewport.overlays.push(shown_area.response.rect);
}

/// Shows hints for three gestures to a new user, each until the user has made the gesture.
fn hints(interface: &mut Interface, ui: &egui::Ui, viewport: Rect) {
    let followed = interface.settings.hints_followed;
    let drag = (followed.drag || !interface.viewer.can_turn(), text!("hint-drag"));
    let hints = [drag, (followed.scroll, text!("hint-scroll")), (followed.search, text!("hint-search"))];
    if hints.iter().all(|(is_followed, _)| *is_followed) || !interface.message_line().is_empty() || viewport.width() < MIN_WIDTH_FOR_HINTS {
        return;
    }
    let area = egui::Area::new(ui.scope_id().with("hints")).order(egui::Order::Middle).pivot(Align2::CENTER_TOP);
    let shown_area = area.fixed_pos(viewport.center_top() + Vec2::new(0.0, 16.0)).interactable(false).show(ui.ctx(), |ui| {
        egui::Frame::new().fill(Color32::from_black_alpha(190)).corner_radius(12.0).inner_margin(egui::Margin::symmetric(14, 6)).show(
            ui,
            |ui| {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 18.0;
                    for (_, hint) in hints.into_iter().filter(|(is_followed, _)| !is_followed) {
                        ui.add(egui::Label::new(egui::RichText::new(hint).color(NAME_COLOUR)).selectable(false));
                    }
                });
            },
        );
    });
    interface.viewport.overlays.push(shown_area.response.rect);
}

/// Shows the context menu of the view, with the commands for the body under the pointer if there is one.
fn context_menu(interface: &mut Interface, response: &egui::Response, place: Option<SeenPlace>, actions: &mut Vec<Action>) {
    if response.secondary_clicked() {
        let body = place.and_then(|place| place.body);
        interface.viewport.menu_direction = place.and_then(|place| place.direction);
        interface.viewport.menu_body = body;
        actions.extend(body.map(Action::Select));
    }
    Popup::context_menu(response).style(menu_style).show(|ui| {
        if let Some(body) = interface.viewport.menu_body {
            ui.strong(interface.viewer.name(body));
            for (name, hover, action) in [
                (text!("menu-fly"), text!("menu-fly-hint"), Action::FlyTo(body)),
                (text!("menu-look-at"), text!("menu-look-at-hint"), Action::LookAt(body)),
            ] {
                if ui.button(name).on_hover_text(hover).clicked() {
                    actions.push(action);
                }
            }
            for (name, tab) in [
                (text!("menu-information"), super::Tab::Information),
                (text!("menu-effects"), super::Tab::Effects),
                (text!("menu-shader"), super::Tab::Shader),
            ] {
                if ui.button(name).on_hover_text(tab.about()).clicked() {
                    interface.open(ui.ctx(), tab);
                }
            }
            ui.separator();
        }
        let measure_button = icons::button(ui, Icon::Measure, text!("menu-measure"));
        let hover = text!("menu-measure-hint");
        if ui.add(measure_button).on_hover_text(hover).clicked()
            && let Some(direction) = interface.viewport.menu_direction
        {
            measure(interface, direction, interface.viewport.menu_body);
        }
        if ui.button(text!("menu-upside-down")).on_hover_text(text!("menu-upside-down-hint")).clicked() {
            actions.push(Action::Roll(180.0));
        }
        ui.checkbox(&mut interface.viewer.view.is_mirrored, text!("menu-mirror")).on_hover_text(text!("menu-mirror-hint"));
        if ui.button(text!("menu-copy-link")).on_hover_text(text!("menu-copy-link-hint")).clicked() {
            ui.ctx().copy_text(interface.viewer.shareable_view().to_link());
            interface.show_reply(text!("link-copied"));
        }
        if ui.button(text!("menu-save-image")).on_hover_text(text!("menu-save-image-hint")).clicked() {
            interface.share.wants_image = true;
        }
    });
}

/// Paints the names and markers of bodies, as the settings demand.
fn paint_labels(interface: &Interface, ui: &egui::Ui, viewport: Rect, placement: &ImagePlacement) {
    let painter = ui.painter().with_clip_rect(viewport);
    for label in &interface.viewport.labels {
        let centre = placement.image.min + egui_vec(label.centre_px * placement.points_per_px);
        let radius = (label.radius_px * placement.points_per_px) as f32;
        let is_selected = label.body == interface.viewer.selected;
        let colour = if is_selected { HIGHLIGHT_COLOUR } else { NAME_COLOUR };
        if interface.settings.marks_small_bodies && radius < MARKER_RADIUS_POINTS {
            painter.circle_stroke(
                centre,
                MARKER_RADIUS_POINTS,
                Stroke::new(1.0, colour.gamma_multiply(if is_selected { 1.0 } else { MARKER_OPACITY })),
            );
        }
        // A body that fills the image has no name side: the window's title names it.
        if let Some(side) = label.name_side
            && interface.settings.labels_bodies
        {
            let text_anchor = centre + egui_vec(side.offset_px(&LabelMetrics::of_size(f64::from(NAME_POINTS)), f64::from(radius)));
            let align = if side.is_left { Align2::RIGHT_CENTER } else { Align2::LEFT_CENTER };
            let font = FontId::proportional(NAME_POINTS);
            painter.text(text_anchor + Vec2::splat(1.0), align, &label.name, font.clone(), Color32::from_black_alpha(180));
            painter.text(text_anchor, align, &label.name, font, colour);
        }
    }
}

/// A vector in points, in f32 as egui has it.
fn egui_vec(v: DVec2) -> Vec2 {
    Vec2::new(v.x as f32, v.y as f32)
}

/// Handles a click that is not an action of the viewer: measures an angle, or picks a pixel and an object of the sky.
fn handle_click(interface: &mut Interface, worker: &dyn RenderWorker, click: Click) {
    match click {
        Click::Measure { direction, body } => measure(interface, direction, body),
        Click::Pick { viewport_px, sky_object } => {
            interface.viewport.picked_px = Some(viewport_px);
            interface.viewport.sky_object = sky_object;
            let scene = interface.shown().map(|rendered| &rendered.scene);
            if let Some(title) = sky_object.zip(scene).and_then(|(object, scene)| sky_object::title(object, worker.session(), scene)) {
                interface.show_reply(title);
            }
        }
    }
}

/// The direction of a pixel of the image, or of the body or star near it; `None` outside the circle of a fisheye image.
fn snapped_direction(interface: &Interface, image_px: DVec2) -> Option<DVec3> {
    let scene = &interface.shown()?.scene;
    scene.geometry.direction(&scene.camera, snapped_px(&interface.viewport.labels, scene, image_px))
}

/// Adds a direction (ICRF unit vector) and the body in this direction, if any, to the measured angle.
fn measure(interface: &mut Interface, direction: DVec3, body: Option<NaifId>) {
    let Some(rendered) = &interface.viewport.shown else { return };
    let bodies = &rendered.scene.bodies;
    // A body that was clicked in an earlier image may have moved relative to the camera since.
    interface.angle.move_bodies(|name| bodies.iter().find(|b| b.name == name).map(|b| b.placement.centre_km));
    let body_in_view = body.and_then(|id| rendered.scene.body(id));
    let seen_body = body_in_view.map(|body| SeenBody { name: body.name.clone(), centre_km: body.placement.centre_km });
    let message = interface.angle.add(direction, seen_body);
    interface.show_reply(message);
}

/// What was under the pointer when its button was pressed on the image, until the release; `None` while no button is.
fn pressed_place(
    interface: &mut Interface,
    session: &Session,
    response: &egui::Response,
    placement: &ImagePlacement,
    viewport: Rect,
) -> Option<SeenPlace> {
    let place = interface.viewport.pressed_place.take().or_else(|| {
        let (pointer, rendered) = (response.interact_pointer_pos()?, interface.shown()?);
        let image_px = placement.image_px_of(pointer, &rendered.scene);
        let body = body_at(&interface.viewport.labels, &rendered.scene, session.catalog(), image_px);
        let sky_object = if body.is_none() { sky_object::object_at(interface, session, image_px) } else { None };
        let offset_px = (pointer - viewport.min) * response.ctx.pixels_per_point();
        let [width, height] = interface.viewport.size_px;
        // At a scale that is not whole, the last point of the viewport may be beyond its last pixel.
        let viewport_px = [(offset_px.x as u32).min(width - 1), (offset_px.y as u32).min(height - 1)];
        Some(SeenPlace { body, sky_object, direction: snapped_direction(interface, image_px), viewport_px })
    });
    interface.viewport.pressed_place = place.filter(|_| response.is_pointer_button_down_on());
    place
}

/// A click on the image.
enum Click {
    /// With Ctrl: adds a direction, and the body there, if any, to the measured angle.
    Measure { direction: DVec3, body: Option<NaifId> },
    /// Without Ctrl: picks a pixel for the probe, and an object of the sky.
    Pick {
        /// The pressed pixel of the viewport.
        viewport_px: [u32; 2],
        /// The star, comet or minor planet at the click, if there is no body.
        sky_object: Option<SkyObject>,
    },
}

/// Turns drags, the wheel and clicks into actions; returns a click that measures an angle or picks a pixel.
fn handle_mouse(ui: &egui::Ui, response: &egui::Response, place: Option<SeenPlace>, actions: &mut Vec<Action>) -> Option<Click> {
    let pixels_per_point = f64::from(ui.ctx().pixels_per_point());
    let drag = response.drag_delta();
    let (drag_x_px, drag_y_px) = (f64::from(drag.x) * pixels_per_point, f64::from(drag.y) * pixels_per_point);
    if response.dragged_by(PointerButton::Primary) && (drag_x_px, drag_y_px) != (0.0, 0.0) {
        let looks_around = ui.input(|i| i.modifiers.shift);
        actions.push(if looks_around { Action::LookAround(-drag_x_px, -drag_y_px) } else { Action::Turn(drag_x_px, drag_y_px) });
    }
    if response.dragged_by(PointerButton::Secondary) && (drag_x_px, drag_y_px) != (0.0, 0.0) {
        actions.push(Action::LookAround(-drag_x_px, -drag_y_px));
    }
    if response.dragged_by(PointerButton::Middle) && drag_x_px != 0.0 {
        actions.push(Action::Roll(drag_x_px * ROLL_DEG_PER_PX));
    }
    if response.hovered() {
        // `wheel` and `pinch` are in wheel notches. Spreading two fingers to twice their distance halves the camera's height above the ground.
        let (wheel, pinch, changes_fov) = ui.input(|i| {
            let (scroll, zoom) = (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta()));
            (scroll / POINTS_PER_NOTCH, zoom.ln() / LOG_HEIGHT_PER_NOTCH, i.modifiers.alt)
        });
        let notches = if pinch == 0.0 { wheel } else { pinch };
        if notches != 0.0 {
            actions.push(if changes_fov { Action::ChangeFov(notches) } else { Action::Zoom(notches) });
        }
    }
    let SeenPlace { body, sky_object, direction, viewport_px } = place?;
    // Clicks with Ctrl come before double-clicks, so that two quick clicks with Ctrl measure an angle, too.
    if response.clicked() && ui.input(|i| i.modifiers.command) {
        return direction.map(|direction| Click::Measure { direction, body });
    }
    if response.double_clicked() {
        actions.extend(body.map(Action::FlyTo));
    } else if response.clicked() {
        actions.extend(body.map(Action::Select));
        return Some(Click::Pick { viewport_px, sky_object });
    }
    None
}

/// Paints a cross at the pixel that the probe inspects.
fn paint_probe(interface: &Interface, ui: &egui::Ui, viewport: Rect) {
    let Some([x, y]) = interface.viewport.picked_px else { return };
    let centre = viewport.min + Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / ui.ctx().pixels_per_point();
    let painter = ui.painter().with_clip_rect(viewport);
    for direction in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y] {
        let arm = PROBE_ARM_ENDS.map(|distance| centre + direction * distance);
        painter.line_segment(arm, Stroke::new(3.0, Color32::from_black_alpha(160)));
        painter.line_segment(arm, Stroke::new(1.0, HIGHLIGHT_COLOUR));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    /// An image with the viewport's aspect ratio fills the viewport, however coarse it is; another image keeps its aspect ratio, is
    /// centred, and has the viewport's height.
    #[test]
    fn an_image_is_never_stretched() {
        let sides = [1_u32, 7, 200, 333, 640, 1279, 2560];
        for [view_width, view_height] in sides.iter().flat_map(|w| sides.map(|h| [*w, h])) {
            for scale in [1.0, 1.5, 2.0] {
                let viewport = Rect::from_min_size(pos2(190.0, 30.0), Vec2::new(view_width as f32, view_height as f32) / scale);
                for factor in [1.0, 1.125, 1.625, 2.0, 3.375, 5.0] {
                    let size = [view_width, view_height].map(|side| (f64::from(side) / factor).ceil() as u32);
                    assert_eq!(
                        ImagePlacement::of(size, viewport, [view_width, view_height]).image,
                        viewport,
                        "{size:?} in {view_width}x{view_height}"
                    );
                }
                for [width, height] in sides.iter().flat_map(|w| sides.map(|h| [*w, h])) {
                    let placement = ImagePlacement::of([width, height], viewport, [view_width, view_height]);
                    if placement.image == viewport {
                        // A difference of less than a pixel is rounding.
                        let [w, h, view_w, view_h] = [width, height, view_width, view_height].map(f64::from);
                        let stretch_px = (h - w * view_h / view_w).abs().min((w - h * view_w / view_h).abs());
                        assert!(stretch_px <= 1.0, "{width}x{height} in {view_width}x{view_height}: stretched by {stretch_px} pixels");
                    } else {
                        let expected_width = placement.image.height() * width as f32 / height as f32;
                        let error = (placement.image.width() - expected_width).abs();
                        assert!(
                            error < 1e-3 + 1e-5 * expected_width,
                            "{width}x{height} in {view_width}x{view_height}: width wrong by {error} points"
                        );
                    }
                    assert!((placement.image.height() - viewport.height()).abs() < 1e-3);
                    assert!((placement.image.center() - viewport.center()).length() < 1e-3 + 1e-6 * placement.image.width());
                    let uv = placement.uv_within(placement.image.intersect(viewport));
                    assert!(uv.min.x >= -1e-4 && uv.max.x <= 1.0001 && uv.min.y.abs() < 1e-4 && (uv.max.y - 1.0).abs() < 1e-4);
                }
            }
        }
    }
}
