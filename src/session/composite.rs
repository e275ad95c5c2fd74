//! Builds the scenes and the plan of a composed image, which consists of several frames.
//!
//! In: a request whose composition is not plain. Out: the scene of the entire image, and its plan. Always: the light is metered once, for the middle
//! of the image, and every frame has that exposure.

use super::{Session, SessionError, Stage};
use crate::render::plan::{self, Plan, PlanError, SamplingQuality};
use crate::scene::camera::geometry::{ImageGeometry, WarpedGeometry};
use crate::scene::composite::{Composite, CompositeFrames, FrameRequest};
use crate::scene::request::{Projection, ViewRequest};
use crate::scene::{Scene, SceneBuilder};
use std::sync::Arc;

/// Smallest and largest side of the image that a warp mesh samples, pixels.
const WARPED_PX: (f64, f64) = (256.0, 8192.0);

impl Session {
    pub(super) fn composite_plan(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<(Scene, Plan), SessionError> {
        loop {
            let (composite, screen) = self.composite_of(request)?;
            let mesh = request.composition.warp.as_deref().zip(screen);
            let modules = plan::composite_modules(&composite, mesh.is_some());
            self.timed(Stage::Shaders, || self.library.warm(&modules, || {}));
            match self.timed(Stage::Plan, || plan::composite(&composite, self, sampling, mesh)) {
                Ok(plan) => return Ok((with_warped_geometry(composite.whole, request), plan)),
                Err(PlanError::Map { file, why }) if self.record_unreadable_map(&file, &why) => {}
                Err(_) if self.replace_forged(&modules) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }

    /// The composed image with the scenes of its frames, and the size of the screen onto which it is warped, if it is.
    fn composite_of(&self, request: &ViewRequest) -> Result<(Composite, Option<[u32; 2]>), SessionError> {
        let screen = request.composition.warp.as_ref().map(|_| [request.width, request.height]);
        let mut inner = request.clone();
        if let Some(mesh) = &request.composition.warp {
            // The aspect ratio of a dome's circle, of an equirectangular map, or of the screen.
            let aspect = match request.composition.projection {
                Projection::Fisheye => 1.0,
                Projection::Equirectangular => 2.0,
                Projection::Perspective => f64::from(request.width) / f64::from(request.height),
            };
            let height =
                (0.5 * f64::from(request.height) / mesh.smallest_derivative(aspect)).clamp(WARPED_PX.0, WARPED_PX.1 / aspect.max(1.0));
            // The clamp keeps both sides in range.
            (inner.width, inner.height) = ((height * aspect).round() as u32, height.round() as u32);
        }
        let mut frames = CompositeFrames::of(&self.catalog, &self.ephemeris, &inner)?;
        let exposure = {
            let FrameRequest { request, viewer } = &frames.meter;
            let begin = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let (builder, _) = self.metered(begin)?;
            builder.exposure().clone()
        };
        frames.exposed(&exposure);
        let mut scenes = Vec::new();
        for FrameRequest { request, viewer } in &frames.frames {
            let begin = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let mut scene = self.scene_from(begin, |required| self.timed(Stage::Maps, || self.read_maps(required)))?;
            scene.exposure = exposure.clone();
            scenes.push(scene);
        }
        let composite = Composite::new(&self.catalog, &inner, frames.arrangement, &frames.meter.viewer.camera, scenes);
        composite.map(|c| (c, screen)).ok_or_else(|| SessionError::from(PlanError::Module("an image without a frame".into())))
    }
}

/// A planned scene with the geometry of the screen. Applied only after planning, because the plan places everything in the image as it is before the
/// mesh warps it.
fn with_warped_geometry(mut whole: Scene, request: &ViewRequest) -> Scene {
    if let Some(mesh) = &request.composition.warp {
        let image = Box::new(std::mem::take(&mut whole.geometry));
        let image_px = image.projection(&whole.camera).size_px().to_array().map(|px| px.round() as u32);
        let screen_px = [request.width, request.height];
        whole.geometry = ImageGeometry::Warped(WarpedGeometry { image, image_px, mesh: Arc::clone(mesh), screen_px });
    }
    whole
}
