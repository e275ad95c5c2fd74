//! Builds the scenes and the plan of a composed image, which consists of several frames.
//!
//! In: a request for anything but one perspective frame: a dome, an equirectangular map, a stereo pair or a warped image. Out: the scene of the entire image,
//! and its plan. Always: the light is metered once, by a camera that sees the middle of the image, and every frame has that exposure.

use super::{Session, SessionError, Stage};
use crate::render::plan::{self, Plan, PlanError, SamplingQuality};
use crate::scene::camera::geometry::{ImageGeometry, WarpedGeometry};
use crate::scene::composite::{Composite, CompositeFrames, FrameRequest};
use crate::scene::request::{Projection, ViewRequest};
use crate::scene::{Scene, SceneBuilder};
use std::sync::Arc;

/// Limits of the unwarped image: least height, largest side.
const MIN_UNWARPED_HEIGHT_PX: f64 = 256.0;
const MAX_UNWARPED_SIDE_PX: f64 = 8192.0;

impl Session {
    pub(super) fn composite_plan(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<(Scene, Plan), SessionError> {
        loop {
            let (composite, screen_px) = self.composite_of(request)?;
            let mesh = request.composition.warp.as_deref().zip(screen_px);
            let modules = plan::composite_modules(&composite, mesh.is_some());
            self.timed(Stage::Shaders, || self.library.warm(&modules, || {}));
            match self.timed(Stage::Plan, || plan::composite(&composite, self, sampling, mesh)) {
                Ok(plan) => return Ok((with_warped_geometry(composite.whole, request), plan)),
                Err(PlanError::Map { file, why }) if self.record_unreadable_map(&file, &why) => {}
                Err(_) if self.replace_tampered(&modules) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }

    /// The composed image with the scenes of its frames; if it is warped, also the size of the screen.
    fn composite_of(&self, request: &ViewRequest) -> Result<(Composite, Option<[u32; 2]>), SessionError> {
        let screen_px = request.composition.warp.as_ref().map(|_| [request.width, request.height]);
        let mut unwarped = request.clone();
        if let Some(mesh) = &request.composition.warp {
            // The aspect ratio of a dome's circle, of an equirectangular map, or of the screen.
            let aspect = match request.composition.projection {
                Projection::Fisheye => 1.0,
                Projection::Equirectangular => 2.0,
                Projection::Perspective => f64::from(request.width) / f64::from(request.height),
            };
            // Except at the tenth of the nodes that magnify most, a pixel of the image covers at most about one of the screen. The mesh's unit of length is
            // half the screen's height.
            let height = 0.5 * f64::from(request.height) / mesh.tenth_percentile_derivative(aspect);
            // The width is limited, too; on a very wide screen this upper limit of the height is below the lower one, and has precedence.
            let height = height.max(MIN_UNWARPED_HEIGHT_PX).min(MAX_UNWARPED_SIDE_PX / aspect.max(1.0));
            // A screen a pixel wide would round to an image without a column.
            let side_px = |side: f64| side.round().max(1.0) as u32;
            (unwarped.width, unwarped.height) = (side_px(height * aspect), side_px(height));
        }
        let mut frames = CompositeFrames::of(&self.catalog, &self.ephemeris, &unwarped)?;
        let exposure = {
            let FrameRequest { request, viewer } = &frames.meter;
            let begin = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let (builder, _) = self.metered(begin)?;
            builder.exposure().clone()
        };
        frames.set_exposure(&exposure);
        let mut scenes = Vec::new();
        for FrameRequest { request, viewer } in &frames.frames {
            let begin = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let mut scene = self.scene_from(begin, |required| self.timed(Stage::Maps, || self.read_maps(required)))?;
            scene.exposure = exposure.clone();
            scenes.push(scene);
        }
        let composite = Composite::new(&self.catalog, &unwarped, frames.arrangement, &frames.meter.viewer.camera, scenes);
        composite.map(|c| (c, screen_px)).ok_or_else(|| SessionError::from(PlanError::Module("an image without a frame".into())))
    }
}

/// A scene with the geometry of the screen onto which its image is warped. Applied after planning, because the plan draws the unwarped image.
fn with_warped_geometry(mut whole: Scene, request: &ViewRequest) -> Scene {
    if let Some(mesh) = &request.composition.warp {
        let image = Box::new(std::mem::take(&mut whole.geometry));
        let image_px = image.projection(&whole.camera).size_px().to_array().map(|px| px.round() as u32);
        let screen_px = [request.width, request.height];
        whole.geometry = ImageGeometry::Warped(WarpedGeometry { image, image_px, mesh: Arc::clone(mesh), screen_px });
    }
    whole
}
