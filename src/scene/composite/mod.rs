//! Composed images: the frames of a composition, and the parts of their scenes that belong to the entire image.
//!
//! In: a request whose [`Composition`](crate::scene::request::Composition) is not the default. Out: [`CompositeFrames`], a request and a viewer for each frame
//! and for the light meter. In, later: the scenes built for the frames. Out: a [`Composite`] for `render::plan`. Always: one exposure for all frames; stars and
//! points of a dome or sphere are placed in the finished image, so that no resampling blurs or moves them, except near the poles of an equirectangular image.

mod arrangement;
mod eyes;
mod faces;
mod names;
pub mod sprites;

pub use arrangement::{Arrangement, CompositeFrames, Eyes, Faces, FrameRequest};
pub(crate) use faces::BORDER_PX;

use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::annotation::labels::{LabelLayer, LabelMetrics};
use crate::scene::annotation::line_texts::{PlacedText, TextLayer};
use crate::scene::annotation::margin::Margin;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::geometry::{ImageGeometry, StereoGeometry};
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::draw::PixelView;
use crate::scene::error::SceneError;
use crate::scene::finished::Scene;
use crate::scene::light::exposure::Exposure;
use crate::scene::request::view_request::{ExposureRequest, ViewRequest};
use crate::scene::request::{Composition, Projection, StereoLayout};
use crate::scene::sky::comets::Comets;
use glam::DVec2;

impl CompositeFrames {
    /// The frames of a request.
    ///
    /// # Errors
    /// Invalid camera parameters; a field of view that is too small or too large for a fisheye; a stereo pair without a target, with an image that is too
    /// narrow, or whose parallax at infinity would be too large.
    pub fn of(catalog: &Catalog, ephemeris: &Ephemeris, request: &ViewRequest) -> Result<Self, SceneError> {
        request.check()?;
        let without_composition = ViewRequest { composition: Composition::default(), ..request.clone() };
        match (request.composition.projection, request.composition.stereo) {
            (Projection::Perspective, Some(stereo)) => eyes::frames(catalog, ephemeris, &without_composition, stereo),
            (Projection::Perspective, None) => {
                let viewer = viewpoint::viewer(catalog, ephemeris, &without_composition)?;
                let frame = FrameRequest { request: without_composition, viewer };
                Ok(Self { meter: frame.clone(), frames: vec![frame], arrangement: Arrangement::Single })
            }
            (Projection::Fisheye | Projection::Equirectangular, _) => faces::frames(catalog, ephemeris, request, without_composition),
        }
    }

    /// Gives all frames the same exposure: that of the light meter's frame.
    pub(crate) fn set_exposure(&mut self, exposure: &Exposure) {
        self.frames.iter_mut().for_each(|f| f.request.exposure = ExposureRequest::Stops(exposure.stops));
    }
}

/// A composed image and the scenes of its frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Composite {
    pub scenes: Vec<Scene>,
    pub arrangement: Arrangement,
    /// The scene of the entire image. For faces it holds what is drawn after they have been combined: stars, points, labels and names. Otherwise it is the
    /// scene of the first frame; for a stereo pair, with the geometry of the pair, the texts of both eyes, and the values of bodies midway between the eyes.
    pub whole_image: Scene,
}

impl Composite {
    /// Combines the scenes of the frames, one per frame in the same order; `None` without scenes. `meter_viewer`: the viewer of the light meter's frame; for a
    /// stereo pair, midway between the eyes. `body_values`: for a stereo pair, the bodies as that viewer sees them; otherwise empty.
    pub(crate) fn new(
        (catalog, ephemeris): (&Catalog, &Ephemeris),
        request: &ViewRequest,
        arrangement: Arrangement,
        meter_viewer: &Viewer,
        body_values: Vec<BodyReport>,
        mut scenes: Vec<Scene>,
    ) -> Option<Self> {
        let mut whole = scenes.first()?.clone();
        // `frame_of_face`: index of each face's frame; `None` for a face that the image does not show.
        if let Arrangement::Faces(Faces { image, frame_of_face, .. }) = &arrangement {
            whole.geometry = ImageGeometry::Sphere(image.clone());
            // The camera keeps its position. Its field of view remains that of a face's frame.
            let camera = &mut whole.camera;
            (camera.right, camera.up, camera.forward) = (image.right, image.up, image.forward);
            (camera.width, camera.height) = (image.width, image.height);
            // The faces draw the following themselves, except what images made of faces lack: an outline, and texts other than names of comets, stars
            // and constellations, which `line_texts` gets below.
            (whole.draws, whole.ground_lines, whole.lines_in_space, whole.refracted_limbs) = Default::default();
            (whole.corona, whole.glare, whole.outlined_shape) = (None, None, None);
            (whole.sky_images, whole.sky_lines, whole.orbits) = Default::default();
            (whole.minor_planets, whole.comets, whole.line_texts) = (None, Comets::default(), None);
            whole.background = None;
            // Stars and points are moved from the faces to the entire image. Near the poles of an equirectangular image they stay in the faces.
            (whole.stars, whole.points) = Default::default();
            for (face, frame) in frame_of_face.iter().enumerate() {
                let Some(scene) = frame.and_then(|k| scenes.get_mut(k)) else { continue };
                let white = scene.exposure.white();
                // The stars of earlier faces are given, because a star on the edge of two faces may be in both scenes.
                let stars = sprites::stars(image, face, &scene.camera, &scene.stars, &whole.stars, white);
                let points = sprites::points(image, face, &scene.camera, &scene.points, &scene.bodies, white);
                (scene.stars, scene.points) = (stars.in_face, points.in_face);
                whole.stars.extend(stars.in_image);
                whole.points.extend(points.in_image);
            }
            // Each body's entry comes from the face that contains the body's centre. All scenes list the catalog's bodies in the same order.
            for (k, body) in whole.bodies.iter_mut().enumerate() {
                let face = faces::face_of(image.in_axes(body.placement.centre_km));
                if let Some(seen) = frame_of_face[face].and_then(|f| scenes.get(f)?.bodies.get(k)) {
                    *body = seen.clone();
                }
            }
            // The faces have no bloom: it spreads light over the entire image.
            whole.has_bloom = request.layers.bloom && request.pixel_view == PixelView::Final;
            whole.labels = LabelLayer::of(image, request, catalog, &whole.bodies, meter_viewer.sky_aberration_velocity_km_s);
            whole.line_texts = names::texts(request, catalog, ephemeris, &whole);
        }
        // `first_columns`: the first column of each eye's frame that the image shows.
        if let Arrangement::Eyes(Eyes { first_columns, layout, .. }) = &arrangement {
            let is_side_by_side = *layout == StereoLayout::SideBySide;
            let width = meter_viewer.camera.width;
            whole.geometry = ImageGeometry::Stereo(StereoGeometry { left_column: first_columns[0], width, is_side_by_side });
            // The margin is that of the viewer between the eyes, the same in both images: zero parallax. The ground in the middle differs between the eyes, and
            // with it would the scale bar.
            let metrics = LabelMetrics::of_size(LabelLayer::empty(request).glyph_px);
            let margin = Margin::of(&meter_viewer.camera, request, catalog, &body_values, &metrics);
            if margin != Margin::default() {
                for (scene, first_column) in scenes.iter_mut().zip(first_columns) {
                    let labels = scene.labels.get_or_insert_with(|| LabelLayer::empty(request));
                    labels.add(margin.clone().shifted(f64::from(*first_column)));
                }
            }
            // Left edge of the right eye's image in the pair.
            let right_image_px = if is_side_by_side { f64::from(width) } else { 0.0 };
            let shifts_px = [-f64::from(first_columns[0]), right_image_px - f64::from(first_columns[1])];
            whole.set_texts_of_eyes(request, &scenes, shifts_px);
            // What is drawn, where, and why, stays that of the left eye.
            whole.bodies.iter_mut().zip(body_values).for_each(|(body, seen)| body.take_values(seen));
        }
        Some(Self { scenes, arrangement, whole_image: whole })
    }
}

impl Scene {
    /// Replaces the texts by those of the eyes of a stereo pair. The eyes' scenes draw the texts; the pair's scene only tells its users where they are. It
    /// has no names of bodies and no data points. `shifts_px`: for each eye, position in the pair minus position in the eye's frame, to the right.
    fn set_texts_of_eyes(&mut self, request: &ViewRequest, eyes: &[Self], shifts_px: [f64; 2]) {
        (self.labels, self.line_texts) = (None, None);
        for (eye, shift_px) in eyes.iter().zip(shifts_px) {
            if let Some(layer) = &eye.labels {
                self.labels.get_or_insert_with(|| LabelLayer::empty(request)).add(layer.margin.clone().shifted(shift_px));
            }
            if let Some(layer) = &eye.line_texts {
                let texts = layer.texts.iter().map(|t| PlacedText { left_end_px: t.left_end_px + DVec2::new(shift_px, 0.0), ..t.clone() });
                let of_pair = self.line_texts.get_or_insert_with(|| TextLayer { glyph_px: layer.glyph_px, texts: Vec::new() });
                of_pair.texts.extend(texts);
            }
        }
    }
}
