//! Lines and texts over the image: grids, constellation figures, lines on the ground, shadow cones, instruments, names.
//!
//! In: the placed bodies, their reports, and the stars of the frame. Out: [`Annotations`]. Always: pixel views other than the final image have labels but no
//! other annotations; no text covers another; a body hides the texts on the sky and on other bodies behind it.

use super::SceneBuilder;
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::annotation::line_texts::{self, TextLayer, UnplacedText};
use crate::scene::annotation::sky_lines::{self, AnnotationLines, horizon_axes};
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::{eclipse_lines, ground_lines, instrument_frames, labels, star_names};
use crate::scene::body_report::BodyReport;
use crate::scene::camera::viewpoint::CarryingBody;
use crate::scene::decision::Decision;
use crate::scene::draw::StarSprite;
use crate::scene::draw::features::PixelView;
use crate::scene::features::inputs::FrameContext;
use crate::scene::placed::PlacedBody;
use crate::scene::request::view_request::Position;
use glam::{DMat3, DVec2, DVec3};

/// The lines and texts drawn over an image, with the decisions about them. [`Scene`](crate::scene::Scene) documents the fields of the same names.
pub(super) struct Annotations {
    pub sky_lines: Vec<LineSegment>,
    pub ground_lines: Vec<(NaifId, Vec<LineSegment>)>,
    pub lines_in_space: Vec<LineSegment>,
    pub labels: Option<labels::LabelLayer>,
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
        let main_body = builder.target_or_ground_body();
        let cones = main_body.filter(|_| request.layers.eclipse_cones).map(|p| eclipse_lines::in_space(frame.context, camera, p));
        let (cone_lines, cone_decision) = cones.unzip();
        let sky = sky_lines::sky_lines(request, &builder.viewer, builder.local_horizon());
        let data = builder.catalog.data_layers();
        let ground = ground_lines::ground_lines(frame.context, camera, main_body, &data);
        let others =
            builder.placed.iter().filter(|p| main_body.is_none_or(|b| b.body.id != p.body.id) && !builder.camera_is_at_centre_of(p.body));
        let others: Vec<(&PlacedBody<'_>, AnnotationLines)> =
            others.map(|p| (p, ground_lines::ground_lines(frame.context, camera, Some(p), &data))).collect();
        let instruments = builder.instrument_frames(glyph_px);
        let is_hidden = |at_px: DVec2| builder.is_covered(at_px);
        let names =
            request.layers.star_names.then(|| star_names::star_names(camera, stars, builder.catalog.stars().stars(), glyph_px, is_hidden));
        let (star_texts, star_decision) = names.unzip();
        let sky_texts = star_texts.into_iter().flatten().chain(sky.texts).filter(|t| !builder.is_behind_body(t, glyph_px));
        let other_texts = others.iter().flat_map(|(p, lines)| lines.texts.iter().filter(|t| builder.is_seen_on(p, t)).cloned());
        let main_texts = ground.texts.into_iter().filter(|t| main_body.is_some_and(|p| builder.is_seen_on(p, t)));
        let candidates: Vec<_> = sky_texts.chain(main_texts).chain(other_texts).chain(instruments.texts).collect();
        let line_texts =
            (!candidates.is_empty()).then(|| line_texts::place_texts(candidates, labels.as_ref(), glyph_px, camera.half_size_px() * 2.0));
        let decisions = cone_decision.into_iter().chain(sky.decisions).chain(ground.decisions).chain(instruments.decisions);
        Self {
            sky_lines: sky.segments,
            ground_lines: main_body
                .map(|p| (p.body.id, ground.segments))
                .into_iter()
                .chain(others.into_iter().map(|(p, lines)| (p.body.id, lines.segments)))
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
    /// The main body of the annotations: the target, else the body that the viewer stands on; `None` without either, or if the camera is at its centre. Its
    /// shadow cones and those of its occluders are drawn. All bodies have ground lines, but only the decisions about this body's ground lines are recorded.
    fn target_or_ground_body(&self) -> Option<&PlacedBody<'a>> {
        let id = self.request.target.or(self.viewer.stands_on.map(|ground| ground.id))?;
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
    /// above the text's centre, so that texts on the horizon are kept. Grid coordinates are never hidden: they stay at the image's edge, and so do azimuths
    /// below the horizon.
    fn is_behind_body(&self, text: &UnplacedText, glyph_px: f64) -> bool {
        let hides = |p: &PlacedBody<'_>| {
            let is_ground = self.viewer.stands_on.is_some_and(|ground| ground.id == p.body.id);
            let lift_px = if is_ground { DVec2::new(0.0, glyph_px) } else { DVec2::ZERO };
            !self.camera_is_at_centre_of(p.body) && self.viewer.camera.surface_under_pixel(&p.placement, text.centre_px - lift_px).is_some()
        };
        !text.is_grid_coordinate && self.placed.iter().any(hides)
    }

    /// Outlines of instruments' fields of view, centred on the target. `glyph_px`: size of glyphs.
    fn instrument_frames(&self, glyph_px: f64) -> AnnotationLines {
        if !self.request.layers.instruments {
            return AnnotationLines::default();
        }
        let target = self.placed.iter().find(|p| Some(p.body.id) == self.request.target && !self.camera_is_at_centre_of(p.body));
        instrument_frames::frames(self.catalog.instruments(), &self.viewer.camera, target.map(|p| p.placement.centre_km), glyph_px)
    }

    /// The [`horizon_axes`] of a viewer who stands on a body; `None` for any other viewer.
    fn local_horizon(&self) -> Option<DMat3> {
        let (Position::Ground { latitude_deg, longitude_deg, .. }, Some(CarryingBody { id, .. })) =
            (self.request.position, self.viewer.stands_on)
        else {
            return None;
        };
        let body_from_icrf = self.ephemeris.body_from_icrf(id, self.request.time).ok()?;
        let radii_km = self.catalog.body(id).map_or(DVec3::ONE, |b| b.radii_km);
        let height_km = 0.0;
        let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
        Some(horizon_axes(body_from_icrf.transpose() * normal, body_from_icrf.row(2)))
    }
}
