//! *What to see now*: a row of small images over the viewport's lower edge and in the Moments panel.
//!
//! In: clicks. Out: views, a selected event, an opened panel. Always: the images are drawn in the background, one after the other, after
//! the first image of the viewport. The place of a view that does not exist (see [`NowItem::view`]) stays empty, so that no button moves under the pointer. A
//! click on an image that has not been drawn yet opens the view. The row over the viewport disappears permanently with the user's first action other than
//! pausing time, or when a panel is opened or closed. The Moments panel always shows the images.

use super::icons::{self, Icon};
use super::render_loop::colour_image;
use super::{Interface, Tab, events};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::draw::PixelView;
use crate::scene::request::{Layers, Quality};
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::composition_state::CompositionState;
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::Action;
use crate::view::app::what_to_see_now::{NowItem, NowView};
use crate::view::language::text;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, Color32, Context, Rect, Sense, Stroke, TextStyle, TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2};

/// Width and height of a thumbnail, points.
const THUMBNAIL_SIZE: [f32; 2] = [136.0, 84.0];
/// Pixels per point of a thumbnail, above 1 for screens with a high pixel density.
const PX_PER_POINT: f32 = 1.5;
/// Largest number of lines of the description below a thumbnail's title.
const MAX_DESCRIPTION_LINES: usize = 2;
/// Smallest width and height of the viewport at which the row is shown, points.
const MIN_VIEWPORT_SIZE: [f32; 2] = [760.0, 300.0];

/// A view and its image, as the query worker returns them.
struct DrawnThumbnail {
    now_view: NowView,
    /// Width and height, and the pixels, top row first; `None` if the image could not be drawn.
    image: Option<([u32; 2], Vec<[u8; 4]>)>,
}

/// A view and its image, as the row shows them.
struct Thumbnail {
    now_view: NowView,
    /// `None` if the image could not be drawn.
    texture: Option<TextureHandle>,
}

/// What is known about the thumbnail of an item.
#[derive(Default)]
enum ThumbnailState {
    #[default]
    NotRequested,
    Loading(Pending<Option<DrawnThumbnail>>),
    Ready(Box<Thumbnail>),
    /// The view does not exist: see [`NowItem::view`].
    Missing,
}

/// The thumbnails, and the end of the row.
#[derive(Default)]
pub(crate) struct NowThumbnails {
    /// The thumbnail of each item.
    states: [ThumbnailState; NowItem::ALL.len()],
    /// Whether an action hides the row as soon as the press that may have caused it is no longer part of a click.
    must_hide: bool,
    /// An item that was clicked before its view was known. The view opens once it is, unless the user does something else first.
    awaited: Option<NowItem>,
}

/// Takes a finished image and requests the next one, one at a time. Called only while the row is shown.
fn update(interface: &mut Interface, ctx: &Context, worker: &dyn RenderWorker) {
    if interface.shown().is_none() {
        return;
    }
    let base_view = ViewState { quality: Quality::Standard, ..interface.viewer.base_view() };
    let now = interface.viewer.now();
    let mut is_busy = false;
    for (item, state) in NowItem::ALL.into_iter().zip(&mut interface.now_thumbnails.states) {
        if let ThumbnailState::Loading(pending) = state {
            match pending.take() {
                None => is_busy = true,
                Some(drawn) => {
                    *state = drawn.map_or(ThumbnailState::Missing, |drawn| ThumbnailState::Ready(Box::new(with_texture(ctx, drawn))))
                }
            }
        }
        if !is_busy && matches!(state, ThumbnailState::NotRequested) {
            let base_view = base_view.clone();
            *state = ThumbnailState::Loading(ask(worker, move |session| draw(session, item, now, &base_view)));
            is_busy = true;
        }
    }
}

/// Draws the image of an item; `None` if its view does not exist.
fn draw(session: &crate::session::Session, item: NowItem, now: crate::time::Instant, base_view: &ViewState) -> Option<DrawnThumbnail> {
    let now_view = item.view(session, now, base_view)?;
    let [width, height] = THUMBNAIL_SIZE.map(|points| (points * PX_PER_POINT) as u32);
    let view = view_of_thumbnail(item, &now_view.view);
    let image = view.request(session.catalog(), session.ephemeris(), width, height).ok().and_then(|request| {
        let frame = session.draw_in_background(&request, SamplingQuality::of(request.quality), FrameImages::Display).ok()?.frame;
        Some(([frame.width, frame.height], frame.display))
    });
    Some(DrawnThumbnail { now_view, image })
}

/// The view that the thumbnail of an item shows. `view`: the item's.
fn view_of_thumbnail(item: NowItem, view: &ViewState) -> ViewState {
    // The thumbnail of the Shader item shows the visible fraction of the Sun, as the shader computes it.
    let pixel_view = if item == NowItem::Shader { PixelView::Eclipse } else { PixelView::Final };
    // A dome, a stereo pair, or lines and texts of layers would be illegible at this size.
    let (composition, layers, orbits) = (CompositionState::default(), Layers::default(), false);
    ViewState { pixel_view, composition, layers, orbits, ..view.clone() }
}

/// Makes a texture of a drawn image.
fn with_texture(ctx: &Context, drawn: DrawnThumbnail) -> Thumbnail {
    let texture = drawn.image.map(|([width, height], pixels)| {
        let name = format!("now: {}", drawn.now_view.title);
        ctx.load_texture(name, colour_image(width, height, pixels), TextureOptions::LINEAR)
    });
    Thumbnail { now_view: drawn.now_view, texture }
}

/// Which panels are open: those at the sides, and the list of bodies.
type OpenPanels = ([Option<Tab>; 2], bool);

pub(crate) fn open_panels(interface: &Interface) -> OpenPanels {
    ([interface.tab, interface.kept_tab], interface.body_browser_shown)
}

/// Hides the row permanently if this frame's input caused an action or opened or closed a panel. `panels_before`: [`open_panels`] before
/// the input.
pub(crate) fn hide_after_input(interface: &mut Interface, ctx: &Context, panels_before: OpenPanels, actions: &[Action]) {
    // Pausing time is no reason to hide the row: the user may still be looking at it.
    let has_acted = actions.iter().any(|action| !matches!(action, Action::TogglePause));
    if has_acted || open_panels(interface) != panels_before {
        interface.now_thumbnails.awaited = None;
    }
    let must_hide = &mut interface.now_thumbnails.must_hide;
    *must_hide |= has_acted;
    // A press that ends a typed date acts before the release, which may be a click on the row.
    let may_click = ctx.input(|input| input.pointer.any_down() && input.pointer.could_any_button_be_click());
    if (!may_click && std::mem::take(must_hide)) || open_panels(interface) != panels_before {
        interface.settings.panels.now_shown = false;
    }
}

/// Shows the row over the viewport, unless it has been hidden, a panel or tour is open, or the viewport is too small.
pub(crate) fn show_over_viewport(interface: &mut Interface, ui: &Ui, worker: &dyn RenderWorker, viewport: Rect, actions: &mut Vec<Action>) {
    let may_show = interface.settings.panels.now_shown && interface.tab.is_none() && !interface.tour.is_open();
    if !may_show || viewport.width() < MIN_VIEWPORT_SIZE[0] || viewport.height() < MIN_VIEWPORT_SIZE[1] {
        return;
    }
    let area = egui::Area::new(ui.scope_id().with("what to see now")).order(egui::Order::Middle).pivot(Align2::CENTER_BOTTOM);
    let mut must_hide = false;
    let bottom = viewport.center_bottom() - vec2(0.0, 10.0 + interface.viewport.caption_height);
    let shown_area = area.fixed_pos(bottom).show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.strong(text!("now"));
                ui.weak(text!("now-also"));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let hover = text!("now-close-hint");
                    must_hide = icons::icon_button(ui, Icon::Close, text!("now-close")).on_hover_text(hover).clicked();
                });
            });
            ui.horizontal(|ui| must_hide |= thumbnail_row(interface, ui, worker, actions));
        });
    });
    interface.viewport.overlays.push(shown_area.response.rect);
    if must_hide {
        interface.settings.panels.now_shown = false;
    }
}

/// Shows the thumbnails as buttons; returns whether a view was opened.
pub(crate) fn thumbnail_row(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) -> bool {
    update(interface, ui.ctx(), worker);
    let NowThumbnails { states, awaited, .. } = &interface.now_thumbnails;
    let zone = interface.settings.time_zone;
    let (mut clicked, mut arrived) = (None, None);
    for (item, state) in NowItem::ALL.into_iter().zip(states) {
        let thumbnail = match state {
            ThumbnailState::Missing => {
                ui.allocate_exact_size(button_size(ui), Sense::hover());
                continue;
            }
            ThumbnailState::Ready(thumbnail) => Some(&**thumbnail),
            ThumbnailState::NotRequested | ThumbnailState::Loading(_) => None,
        };
        let known_view = || thumbnail.map(|thumbnail| thumbnail.now_view.clone());
        let is_awaited = *awaited == Some(item);
        if thumbnail_button(ui, item, thumbnail, zone, is_awaited) {
            clicked = Some((item, known_view()));
        } else if is_awaited && thumbnail.is_some() {
            arrived = Some((item, known_view()));
        }
    }
    let Some((item, known_view)) = clicked.or(arrived) else { return false };
    // The window does not wait for the search for an eclipse.
    let view_without_search = || {
        let base_view = interface.viewer.base_view();
        (item != NowItem::Eclipse).then(|| item.view(worker.session(), interface.viewer.now(), &base_view)).flatten()
    };
    let Some(now_view) = known_view.or_else(view_without_search) else {
        interface.now_thumbnails.awaited = Some(item);
        return false;
    };
    interface.now_thumbnails.awaited = None;
    open(interface, ui.ctx(), worker, item, now_view, actions);
    true
}

/// Shows the view of an item, with the panel that belongs to it.
pub(crate) fn open(
    interface: &mut Interface,
    ctx: &Context,
    worker: &dyn RenderWorker,
    item: NowItem,
    now_view: NowView,
    actions: &mut Vec<Action>,
) {
    match now_view.event {
        Some(event) => {
            interface.open(ctx, Tab::Events);
            events::show(interface, worker, event, actions);
        }
        None => {
            // The view is computed again, because time, quality, effects and layers may have changed since the thumbnail was drawn. The
            // thumbnail also has a quality of its own.
            let now = interface.viewer.now();
            let view = item.view(worker.session(), now, &interface.viewer.base_view()).map_or(now_view.view, |current| current.view);
            let tdb_s = if now_view.opens_at_current_time { now.tdb_seconds_past_j2000() } else { view.tdb_s };
            actions.push(Action::Show(Box::new(ViewState { tdb_s, ..view })));
            if now_view.opens_at_current_time {
                // A view of the present runs in real time, whatever the rate was. `RunAt` ends a pause, so a pause is restored.
                actions.push(Action::RunAt(1.0));
                if interface.viewer.time_rate.is_paused() {
                    actions.push(Action::TogglePause);
                }
            }
        }
    }
    if item == NowItem::Shader {
        interface.open(ctx, Tab::Shader);
        interface.shader.show_feature("eclipse");
    }
}

fn button_size(ui: &Ui) -> Vec2 {
    let line_height = ui.text_style_height(&TextStyle::Small);
    Vec2::from(THUMBNAIL_SIZE) + vec2(0.0, (1.0 + MAX_DESCRIPTION_LINES as f32) * line_height + 6.0)
}

/// Shows the button of an item: its image, or a spinner until `thumbnail` has arrived, above its title and description. `is_awaited`: whether it was clicked
/// already. Returns whether the button was clicked.
fn thumbnail_button(ui: &mut Ui, item: NowItem, thumbnail: Option<&Thumbnail>, zone: ShownTimeZone, is_awaited: bool) -> bool {
    let line_height = ui.text_style_height(&TextStyle::Small);
    let (rect, response) = ui.allocate_exact_size(button_size(ui), Sense::click());
    let title = thumbnail.map_or(item.name(), |t| t.now_view.title.as_str());
    let about = thumbnail.map_or_else(String::new, |t| t.now_view.about(zone));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{title}: {about}")));
    let response = response.on_hover_text(if about.is_empty() { title } else { about.as_str() });
    let image = Rect::from_min_size(rect.min, THUMBNAIL_SIZE.into());
    let painter = ui.painter();
    painter.rect_filled(image, 4.0, Color32::BLACK);
    match thumbnail.and_then(|t| t.texture.as_ref()) {
        Some(texture) => {
            let full_uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), image, full_uv, Color32::WHITE);
        }
        None if thumbnail.is_none() => egui::Spinner::new().paint_at(ui, Rect::from_center_size(image.center(), Vec2::splat(16.0))),
        None => {}
    }
    let visuals = ui.visuals();
    if response.hovered() || response.has_focus() || is_awaited {
        painter.rect_stroke(image, 4.0, Stroke::new(2.0, visuals.selection.bg_fill), egui::StrokeKind::Outside);
    }
    let lines = |top: f32, text: &str, max_rows: usize, colour| {
        let wrap = TextWrapping { max_rows, ..TextWrapping::wrap_at_width(THUMBNAIL_SIZE[0]) };
        let job = LayoutJob { wrap, ..LayoutJob::simple_singleline(text.to_owned(), TextStyle::Small.resolve(ui.style()), colour) };
        painter.galley(pos2(rect.left(), top), painter.layout_job(job), colour);
    };
    let max_title_lines = 1;
    lines(image.bottom() + 3.0, title, max_title_lines, visuals.strong_text_color());
    lines(image.bottom() + 3.0 + line_height, about.as_str(), MAX_DESCRIPTION_LINES, visuals.text_color());
    response.clicked()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::time::Instant;
    use glam::DVec3;

    /// The names of constellations and instruments ran across the thumbnail of the Moon if these layers were on.
    #[test]
    fn a_thumbnail_has_no_layers() {
        let time = Instant::from_tdb_seconds_past_j2000(0.0);
        let plain = ViewState::around(NaifId::MOON, DVec3::X * 1e4, 1737.4, DVec3::Z, time);
        let layers = Layers { constellations: true, caption: true, ..Layers::default() };
        let with_layers = ViewState { layers, orbits: true, ..plain.clone() };
        assert_eq!(view_of_thumbnail(NowItem::Moon, &with_layers), plain);
        assert_eq!(view_of_thumbnail(NowItem::Shader, &with_layers).pixel_view, PixelView::Eclipse);
    }
}
