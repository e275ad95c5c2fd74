//! Lines and texts over the image: grids, constellation figures, lines on the ground, shadow cones, instruments, names.
//!
//! In: the placed bodies, their reports, and the stars of the frame. Out: [`Annotations`]. Always: pixel views other than the final image have labels but no
//! other annotations; no text covers another; a body hides the texts behind it, both on the sky and on other bodies.

use super::SceneBuilder;
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::annotation::line_texts::{self, TextLayer, UnplacedText};
use crate::scene::annotation::sky_lines::{self, AnnotationLines, horizon_axes};
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::{eclipse_lines, ground_lines, instrument_frames, labels, small_body_names, star_names};
use crate::scene::body_report::BodyReport;
use crate::scene::camera::viewpoint::CarryingBody;
use crate::scene::decision::Decision;
use crate::scene::draw::StarSprite;
use crate::scene::draw::features::PixelView;
use crate::scene::features::inputs::FrameContext;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::Threshold;
use crate::scene::request::view_request::Position;
use crate::scene::sky::small_body_sight::SmallBodySight;
use crate::scene::sky::stars;
use glam::{DMat3, DVec2, DVec3};

/// The lines and texts drawn over an image, with the decisions about them. [`Scene`](crate::scene::Scene) documents the fields of the same names.
pub(super) struct Annotations {
    pub sky_lines: Vec<LineSegment>,
    pub ground_lines: Vec<(NaifId, Vec<LineSegment>)>,
    pub lines_in_space: Vec<LineSegment>,
    /// `None` if the request switches on none of its layers.
    pub labels: Option<labels::LabelLayer>,
    /// `None` if there are no texts.
    pub line_texts: Option<TextLayer>,
    pub decisions: Vec<Decision>,
}

impl Annotations {
    pub(super) fn build(builder: &SceneBuilder<'_>, frame: &FrameContext<'_>, reports: &[BodyReport], stars: &[StarSprite]) -> Self {
        let (request, camera) = (builder.request, frame.camera);
        let labels = labels::LabelLayer::of(camera, request, builder.catalog, reports, builder.viewer.sky_aberration_velocity_km_s);
        if request.pixel_view != PixelView::Final {
            let (sky_lines, ground_lines, lines_in_space) = Default::default();
            return Self { sky_lines, ground_lines, lines_in_space, labels, line_texts: None, decisions: Vec::new() };
        }
        let glyph_px = labels::glyph_size_px(camera.height);
        let main_body = builder.main_body();
        let cones = main_body.filter(|_| request.layers.eclipse_cones).map(|p| eclipse_lines::in_space(frame.context, camera, p));
        let (cone_lines, cone_decision) = cones.unzip();
        let sky = sky_lines::sky_lines(request, &builder.viewer, builder.local_horizon());
        let data = builder.catalog.data_layers();
        let main_lines = ground_lines::ground_lines(frame.context, camera, main_body, &data);
        let other_bodies =
            builder.placed.iter().filter(|p| main_body.is_none_or(|b| b.body.id != p.body.id) && !builder.camera_is_at_centre_of(p.body));
        let lines_of_others: Vec<(&PlacedBody<'_>, AnnotationLines)> =
            other_bodies.map(|p| (p, ground_lines::ground_lines(frame.context, camera, Some(p), &data))).collect();
        let instruments = builder.instrument_frames(glyph_px);
        let is_hidden = |at_px: DVec2| builder.is_covered(at_px);
        let names =
            request.layers.star_names.then(|| star_names::star_names(camera, stars, builder.catalog.stars().stars(), glyph_px, is_hidden));
        let (star_texts, star_decision) = names.unzip();
        let comet_texts = if request.layers.comets && request.layers.labels {
            builder.comet_names(reports, frame.threshold, glyph_px)
        } else {
            Vec::new()
        };
        let sky_texts = comet_texts
            .into_iter()
            .chain(star_texts.into_iter().flatten())
            .chain(sky.texts)
            .filter(|t| !builder.is_behind_body(t, glyph_px));
        let other_texts = lines_of_others.iter().flat_map(|(p, lines)| lines.texts.iter().filter(|t| builder.is_seen_on(p, t)).cloned());
        let main_texts = main_lines.texts.into_iter().filter(|t| main_body.is_some_and(|p| builder.is_seen_on(p, t)));
        let candidates: Vec<_> = sky_texts.chain(main_texts).chain(other_texts).chain(instruments.texts).collect();
        let line_texts =
            (!candidates.is_empty()).then(|| line_texts::place_texts(candidates, labels.as_ref(), glyph_px, camera.half_size_px() * 2.0));
        let decisions = cone_decision.into_iter().chain(sky.decisions).chain(main_lines.decisions).chain(instruments.decisions);
        Self {
            sky_lines: sky.segments,
            ground_lines: main_body
                .map(|p| (p.body.id, main_lines.segments))
                .into_iter()
                .chain(lines_of_others.into_iter().map(|(p, lines)| (p.body.id, lines.segments)))
                .filter(|(_, segments)| !segments.is_empty())
                .collect(),
            lines_in_space: cone_lines.into_iter().flatten().chain(instruments.segments).collect(),
            labels,
            line_texts,
            decisions: decisions.chain(star_decision).collect(),
        }
    }
}

impl<'a> SceneBuilder<'a> {
    /// The main body of the annotations: the target, else the body that the viewer stands on; `None` without either, or if the camera is at its centre, from
    /// where it is not drawn. Shadow cones are drawn for it and its occluders only. All bodies have ground lines, but only decisions about those of this body
    /// are recorded.
    fn main_body(&self) -> Option<&PlacedBody<'a>> {
        let id = self.request.target.or(self.viewer.stands_on.map(|body| body.id))?;
        self.placed.iter().find(|p| p.body.id == id && !self.camera_is_at_centre_of(p.body))
    }

    /// Whether no other body hides a text of the ground lines of `body`: at the text's position `body` is the nearest body.
    fn is_seen_on(&self, body: &PlacedBody<'_>, text: &UnplacedText) -> bool {
        let covers = |p: &&PlacedBody<'_>| self.viewer.camera.surface_under_pixel(&p.placement, text.centre_px).is_some();
        let nearest = self
            .placed
            .iter()
            .filter(|p| !self.camera_is_at_centre_of(p.body))
            .filter(covers)
            .min_by(|a, b| a.distance_km.total_cmp(&b.distance_km));
        nearest.is_some_and(|p| p.body.id == body.body.id)
    }

    /// Whether any body, including the one that the viewer stands on, covers a pixel.
    fn is_covered(&self, at_px: DVec2) -> bool {
        let covers = |p: &PlacedBody<'_>| self.viewer.camera.surface_under_pixel(&p.placement, at_px).is_some();
        self.placed.iter().any(|p| !self.camera_is_at_centre_of(p.body) && covers(p))
    }

    /// Whether any body, including the one that the viewer stands on, hides a text on the sky. The ground hides a text only if it reaches a glyph's height
    /// above the text's centre, so that texts on the horizon are kept. Coordinates of grid lines, also azimuths below the horizon, are never hidden: they stay
    /// at the image's edge.
    fn is_behind_body(&self, text: &UnplacedText, glyph_px: f64) -> bool {
        let hides = |p: &PlacedBody<'_>| {
            let is_ground = self.viewer.stands_on.is_some_and(|body| body.id == p.body.id);
            // Pixel rows are counted downwards, so a higher point has a smaller y.
            let lift_px = if is_ground { DVec2::new(0.0, glyph_px) } else { DVec2::ZERO };
            !self.camera_is_at_centre_of(p.body) && self.viewer.camera.surface_under_pixel(&p.placement, text.centre_px - lift_px).is_some()
        };
        !text.is_grid_coordinate && self.placed.iter().any(hides)
    }

    /// The names of the comets that the frame shows. No request has a comet as its target.
    fn comet_names(&self, reports: &[BodyReport], threshold: Threshold, glyph_px: f64) -> Vec<UnplacedText> {
        let sight = SmallBodySight {
            ephemeris: self.ephemeris,
            position_km: self.viewer.camera.position_km,
            velocity_km_s: self.viewer.velocity_km_s,
            time: self.request.time,
        };
        let camera = &self.viewer.camera;
        let (limiting_magnitude, chosen) = (stars::limiting_magnitude_in_middle(camera, threshold), None);
        let all = self.catalog.small_bodies();
        small_body_names::small_body_names(camera, &sight, reports, &all.comets, limiting_magnitude, chosen, glyph_px)
    }

    /// Outlines of instruments' fields of view, centred on the target; without a target in the image, on the image, except in a face of a cube. Also the
    /// outline of the request's telescope. `glyph_px`: size of glyphs.
    fn instrument_frames(&self, glyph_px: f64) -> AnnotationLines {
        let (request, camera) = (self.request, &self.viewer.camera);
        let mut lines = AnnotationLines::default();
        if request.layers.instruments {
            let target = self.placed.iter().find(|p| Some(p.body.id) == request.target && !self.camera_is_at_centre_of(p.body));
            lines = instrument_frames::frames(self.catalog.instruments(), camera, target.map(|p| p.placement.centre_km), glyph_px);
        }
        if let Some(telescope) = request.telescope {
            let own = instrument_frames::telescope_frame(telescope, camera, request.language, glyph_px);
            lines.segments.extend(own.segments);
            lines.texts.extend(own.texts);
        }
        lines
    }

    /// The [`horizon_axes`] of a viewer who stands on a body; `None` for any other viewer.
    fn local_horizon(&self) -> Option<DMat3> {
        let (Position::Ground { latitude_deg, longitude_deg, .. }, Some(CarryingBody { id, .. })) =
            (self.request.position, self.viewer.stands_on)
        else {
            return None;
        };
        let body_from_icrf = self.ephemeris.body_from_icrf(id, self.request.time).ok()?;
        // The viewer has been placed on a body of the catalog, so the default is not used.
        let radii_km = self.catalog.body(id).map_or(DVec3::ONE, |b| b.radii_km);
        let height_km = 0.0;
        let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
        let (zenith, north_pole) = (body_from_icrf.transpose() * normal, body_from_icrf.row(2));
        Some(horizon_axes(zenith, north_pole))
    }
}
