//! Labels of bodies: names and markers, fewer of them where bodies are crowded. Also the layer that contains them together with an image's other texts.
//!
//! In: the bodies that a camera sees, and the selected one. Out: labels in pixels of the image, important ones first. Always: names do not overlap (estimated
//! from the mean width of a glyph) or cover other texts. A body whose name does not fit keeps its marker; a body that fills the image has no name. A name is a
//! line away if there is no room beside the body, that of the selected body up to some lines. No name is nearer to another body's marker than to its own body,
//! except that of the selected body, and except to the marker of a less important body, if there is no other room. A body has no label if its centre is
//! outside the image, if it is behind the disc of a nearer body, if it is close to a more important label, or in a close view of a body of another system, if
//! it is too faint. Does not draw glyphs.

use super::data::{self, Dot};
use super::features;
use super::margin::Margin;
pub use super::text::LabelMetrics;
use super::text::Rect;
pub(crate) use super::text::{MARKER_RADIUS, NAME_COLOUR};
use crate::catalog::{Catalog, NaifId};
use crate::scene::annotation::orbits;
use crate::scene::body_report::{Appearance, BodyReport};
use crate::scene::camera::Placement;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::draw::PixelView;
use crate::scene::request::view_request::ViewRequest;
use glam::{DVec2, DVec3};

/// The label of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    pub body: NaifId,
    /// The body's name as it is written in the image.
    pub name: String,
    /// Centre of the body, pixels from the image's top left corner.
    pub centre_px: DVec2,
    /// Radius of the body's disc.
    pub radius_px: f64,
    /// The side on which its name is placed; `None` if the name does not fit, or if the body fills the image.
    pub name_side: Option<LabelSide>,
}

/// The side of its body on which a name is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelSide {
    pub is_left: bool,
    pub is_below: bool,
    /// Number of lines by which the name is farther above or below the body than in its usual place on this side.
    pub lines: u8,
}

impl LabelSide {
    /// The place that is tried first: right of the body and above its centre.
    pub const DEFAULT: Self = Self { is_left: false, is_below: false, lines: 0 };

    /// The places of a name, in the order in which they are tried: for each number of lines the four sides. `max_lines`: the largest value of [`Self::lines`].
    fn places(max_lines: u8) -> impl Iterator<Item = Self> {
        const SIDES: [(bool, bool); 4] = [(false, false), (true, false), (false, true), (true, true)];
        let at = |lines| SIDES.map(|(is_left, is_below)| Self { is_left, is_below, lines });
        (0..=max_lines).flat_map(at)
    }

    /// Vector in pixels from the centre of a body of this radius to the end of the name's centre line that is closer to the body.
    pub(crate) fn offset_px(self, metrics: &LabelMetrics, radius_px: f64) -> DVec2 {
        let horizontal_px = metrics.name_offset_px(radius_px);
        let vertical_px = horizontal_px + f64::from(self.lines) * metrics.line_height_px;
        DVec2::new(if self.is_left { -horizontal_px } else { horizontal_px }, if self.is_below { vertical_px } else { -vertical_px })
    }
}

/// Diameter in pixels above which a disc is more important than any smaller body except the Sun and the selected body.
const LARGE_DISC_PX: f64 = 24.0;

/// Sort key of a body's label, the most important first: its class, then its magnitude. A body of unknown magnitude counts as fainter than any other.
fn rank(body: &BodyReport, selected: NaifId, parent_of: &impl Fn(NaifId) -> Option<NaifId>) -> (u8, f64) {
    let orbits_sun = parent_of(body.id).is_none_or(|p| p == NaifId::SUN);
    let class = match () {
        () if body.id == selected => 0,
        () if body.id == NaifId::SUN => 1,
        () if body.appearance == Appearance::Disc && body.diameter_px > LARGE_DISC_PX => 2,
        () if orbits_sun => 3,
        () => 4,
    };
    (class, body.magnitude.unwrap_or(f64::INFINITY))
}

/// Magnitude of the faintest stars that the unaided eye sees.
const UNAIDED_EYE_MAGNITUDE: f64 = 6.5;

/// Whether a body is drawn, has a drawn orbit, or would be visible to the unaided eye.
fn is_noticeable(body: &BodyReport) -> bool {
    let has_orbit = || body.decisions.iter().any(|decision| decision.effect == orbits::EFFECT && decision.on);
    body.appearance != Appearance::NotShown || body.magnitude.is_some_and(|m| m < UNAIDED_EYE_MAGNITUDE) || has_orbit()
}

/// sRGB of the selected body's name, marker and outline.
pub(crate) const SELECTED_COLOUR: [u8; 3] = [255, 206, 110];
/// Opacity of a marker relative to that of a name, for a body that is not selected.
pub(crate) const MARKER_OPACITY: f32 = 0.55;
/// Radius of a disc, relative to the image's height, from which the body is not named, because it fills the image.
const IMAGE_FILLING_RADIUS: f64 = 0.45;

/// The labels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelLayer {
    /// Size of the glyphs.
    pub glyph_px: f64,
    /// The selected body, else the target, else the Sun; its label has a colour of its own.
    pub selected: NaifId,
    pub labels: Vec<Label>,
    /// Caption, scale bar and compass; also the names of surface features and the rings of landing sites.
    pub margin: Margin,
    /// Points of data, below all names.
    pub dots: Vec<Dot>,
}

impl LabelLayer {
    /// The texts, marks and data points of the layers that the request switches on; `None` if it switches on none of these layers. `velocity_km_s`: the
    /// viewer's velocity, for the aberration of data points in the sky.
    pub(crate) fn of(
        image: &impl ImageProjection,
        request: &ViewRequest,
        catalog: &Catalog,
        bodies: &[BodyReport],
        velocity_km_s: DVec3,
    ) -> Option<Self> {
        let layers = &request.layers;
        let shows_margin = layers.caption || layers.scale_bar || layers.compass;
        let shows_data = layers.data && request.pixel_view == PixelView::Final && !catalog.data_layers().is_empty();
        if !(layers.labels || layers.features || shows_margin || shows_data) {
            return None;
        }
        let mut layer = Self::empty(request);
        if shows_data {
            layer.dots = data::dots(image, catalog, bodies, velocity_km_s, request.time);
        }
        let metrics = LabelMetrics::of_size(layer.glyph_px);
        if shows_margin {
            layer.add(Margin::of(image, request, catalog, bodies, &metrics));
        }
        let mut occupied: Vec<Rect> = layer.occupied(&metrics).collect();
        if layers.labels {
            let parent_of = |id: NaifId| catalog.body(id).and_then(|b| b.parent);
            let name_of = |name: &str| request.language.name("body", name).to_owned();
            layer.labels = body_labels(image, bodies, layer.selected, parent_of, &metrics, name_of, &occupied);
            let of_label = |label: &Label| Some(label_rect(label.centre_px, label.radius_px, &label.name, &metrics, label.name_side?));
            occupied.extend(layer.labels.iter().filter_map(of_label));
        }
        if layers.features {
            let (names, sites) = features::surface_feature_names(image, bodies, &metrics, &mut occupied);
            layer.margin.texts.extend(names);
            layer.margin.sites.extend(sites);
        }
        Some(layer)
    }

    /// A layer without labels.
    pub(crate) fn empty(request: &ViewRequest) -> Self {
        let selected = request.selected.or(request.target).unwrap_or(NaifId::SUN);
        Self { glyph_px: glyph_size_px(request.height), selected, labels: Vec::new(), margin: Margin::default(), dots: Vec::new() }
    }

    /// Adds texts, bars, rings and landing sites.
    pub(crate) fn add(&mut self, margin: Margin) {
        self.margin.texts.extend(margin.texts);
        self.margin.bars.extend(margin.bars);
        self.margin.rings.extend(margin.rings);
        self.margin.sites.extend(margin.sites);
    }

    /// Rectangles of the texts and bars of [`Self::margin`]; those of [`Self::labels`] are not included.
    pub(crate) fn occupied<'a>(&'a self, metrics: &'a LabelMetrics) -> impl Iterator<Item = Rect> + 'a {
        self.margin.occupied(metrics)
    }
}

/// Size of glyphs in an image of this height in pixels: a seventieth of the height, but large enough to read in a small image.
pub(crate) fn glyph_size_px(height: u32) -> f64 {
    (f64::from(height) / 70.0).clamp(13.0, 240.0).round()
}

/// Largest value of [`LabelSide::lines`], for the selected body and for any other.
const SELECTED_MAX_LINES: u8 = 8;
const MAX_LINES: u8 = 1;
/// Distance from a more important body without a name, in heights of a line, below which a body has none either: the name would be read as that of the more
/// important body.
const UNNAMED_NEIGHBOUR_LINES: f64 = 2.0;
/// Free space at each end of a name, in mean widths of a glyph: names with wide letters are up to a tenth wider than estimated.
const NAME_MARGIN: f64 = 1.0;
/// Distance in pixels from a more important body below which a body has no label. If half the radius of that body's disc is larger, this half counts, up to
/// [`MAX_CROWDED_PX`].
const CROWDED_PX: f64 = 7.0;
const MAX_CROWDED_PX: f64 = 20.0;
/// Radius of a disc in pixels above which a body hides others; smaller ones are drawn as points or nearly so.
const MIN_HIDING_RADIUS_PX: f64 = 3.0;
/// How far inside the outline of a nearer body a disc must be to be hidden, in radii of the nearer body. For a camera less than one radius above that body,
/// this distance is multiplied by the camera's height in radii.
const HIDDEN_DEPTH: f64 = 0.03;

/// The labels of the bodies that a camera sees, most important first. `name_of` translates names; `occupied`: rectangles that names avoid.
pub(crate) fn body_labels(
    image: &dyn ImageProjection,
    bodies: &[BodyReport],
    selected: NaifId,
    parent_of: impl Fn(NaifId) -> Option<NaifId>,
    metrics: &LabelMetrics,
    name_of: impl Fn(&str) -> String,
    occupied: &[Rect],
) -> Vec<Label> {
    let size = image.size_px();
    let angular_radius_rad = |b: &BodyReport| (b.placement.radii_km.max_element() / b.distance_km).min(1.0).asin();
    let is_placed = |b: &&BodyReport| b.distance_km.is_finite() && b.distance_km > 0.0;
    let mut visible: Vec<(&BodyReport, DVec2, f64)> = bodies
        .iter()
        .filter(is_placed)
        .filter_map(|b| {
            let centre_px = image.pixel_of(b.placement.centre_km)?;
            let radius_px = image.disc_radius_px(angular_radius_rad(b));
            // A body whose centre is outside the image has no label.
            let is_inside = (0.0..=size.x).contains(&centre_px.x) && (0.0..=size.y).contains(&centre_px.y);
            is_inside.then_some((b, centre_px, radius_px))
        })
        .collect();
    // Bodies hide others even if their centres are outside the image: for example the body on which the camera stands.
    let is_disc = |b: &&BodyReport| !b.placement.camera_is_inside() && image.disc_radius_px(angular_radius_rad(b)) > MIN_HIDING_RADIUS_PX;
    let possibly_hiding: Vec<&BodyReport> = bodies.iter().filter(is_placed).filter(is_disc).collect();
    // A body is hidden only if its disc is well inside the outline of the nearer body, so a moon over the pole of an oblate planet keeps its label.
    let is_hidden = |b: &BodyReport| {
        possibly_hiding.iter().filter(|other| other.id != b.id && other.distance_km < b.distance_km).any(|nearer| {
            // For a camera on the ground the outline is the horizon, and a body just below it is hidden.
            let height_radii = (nearer.placement.camera_in_unit_sphere().length() - 1.0).clamp(0.0, 1.0);
            let shrunk = Placement { radii_km: (1.0 - HIDDEN_DEPTH * height_radii) * nearer.placement.radii_km, ..nearer.placement };
            shrunk.covers_disc(b.placement.centre_km, angular_radius_rad(b))
        })
    };
    visible.retain(|(b, ..)| !is_hidden(b));
    // A close view of a planet or moon is about its system: a body far behind it that only a telescope would show has no label, unless it is selected.
    let system_of = |id: NaifId| parent_of(id).filter(|parent| *parent != NaifId::SUN).unwrap_or(id);
    let is_close = |b: &&BodyReport| b.id != NaifId::SUN && b.appearance == Appearance::Disc && b.diameter_px > LARGE_DISC_PX;
    let closest = visible.iter().map(|(b, ..)| *b).filter(is_close).max_by(|a, b| a.diameter_px.total_cmp(&b.diameter_px));
    if let Some(system) = closest.map(|b| system_of(b.id)) {
        visible.retain(|(b, ..)| b.id == selected || system_of(b.id) == system || is_noticeable(b));
    }
    visible.sort_by(|a, b| {
        let [(class_a, magnitude_a), (class_b, magnitude_b)] = [a.0, b.0].map(|body| rank(body, selected, &parent_of));
        class_a.cmp(&class_b).then(magnitude_a.total_cmp(&magnitude_b)).then(a.0.id.cmp(&b.0.id))
    });
    // The bodies with labels, which are the more important ones where bodies are crowded.
    let mut labelled: Vec<(&BodyReport, DVec2, f64)> = Vec::new();
    for (b, centre_px, radius_px) in visible {
        let crowded_px = |radius_px: f64| CROWDED_PX.max((0.5 * radius_px).min(MAX_CROWDED_PX));
        if labelled.iter().all(|(_, other_px, other_radius_px)| other_px.distance(centre_px) >= crowded_px(*other_radius_px)) {
            labelled.push((b, centre_px, radius_px));
        }
    }
    let marker_px = MARKER_RADIUS * metrics.glyph_px();
    let mut chosen: Vec<Label> = Vec::new();
    let mut occupied: Vec<Rect> = occupied.to_vec();
    for (index, (b, centre_px, radius_px)) in labelled.iter().copied().enumerate() {
        let name = name_of(&b.name);
        let with_rect = |side: LabelSide| (side, label_rect(centre_px, radius_px, &name, metrics, side));
        let margin = DVec2::new(NAME_MARGIN * metrics.glyph_width_px, 0.0);
        let fits = |(_, rect): &(LabelSide, Rect)| rect.is_in_image(size) && !occupied.iter().any(|o| o.overlaps(&rect.padded(margin)));
        // Whether the name is nearer to its body than to the markers of these others. A disc that is larger than a marker may lie behind the name.
        let is_nearest = |rect: &Rect, others: &[(&BodyReport, DVec2, f64)]| {
            let own_px = rect.distance_px(centre_px) - radius_px.max(marker_px);
            let mut markers = others.iter().filter(|(other, _, other_radius_px)| other.id != b.id && *other_radius_px < marker_px);
            markers.all(|(_, other_px, _)| rect.distance_px(*other_px) - marker_px >= own_px)
        };
        let is_selected = b.id == selected;
        let places: Vec<(LabelSide, Rect)> =
            LabelSide::places(if is_selected { SELECTED_MAX_LINES } else { MAX_LINES }).map(with_rect).filter(fits).collect();
        let more_important = &labelled[..index];
        let place = places
            .iter()
            .find(|(_, rect)| is_nearest(rect, &labelled))
            .or_else(|| places.iter().find(|(_, rect)| is_nearest(rect, more_important)))
            .or_else(|| places.first().filter(|_| is_selected))
            .copied();
        let neighbour_px = UNNAMED_NEIGHBOUR_LINES * metrics.line_height_px;
        let is_unnamed_neighbour =
            |label: &Label| label.name_side.is_none() && label.radius_px < marker_px && label.centre_px.distance(centre_px) < neighbour_px;
        let is_named = radius_px < IMAGE_FILLING_RADIUS * size.y && (is_selected || !chosen.iter().any(is_unnamed_neighbour));
        let place = place.filter(|_| is_named);
        occupied.extend(place.map(|(_, rect)| rect));
        chosen.push(Label { body: b.id, name, centre_px, radius_px, name_side: place.map(|(side, _)| side) });
    }
    chosen
}

/// The rectangle of a body's name at its disc or marker.
pub fn label_rect(centre_px: DVec2, radius_px: f64, name: &str, metrics: &LabelMetrics, side: LabelSide) -> Rect {
    let near_end = centre_px + side.offset_px(metrics, radius_px);
    let left_end_px = if side.is_left { near_end - DVec2::new(metrics.width_px(name), 0.0) } else { near_end };
    metrics.rect(name, left_end_px)
}
