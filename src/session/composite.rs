//! Builds the scenes and the plan of a composed image, which consists of several frames.
//!
//! In: a request for anything but one perspective frame: a dome, an equirectangular map, a stereo pair or a warped image. Out: the scene of the entire image,
//! and its plan. Always: the light is metered once, by a camera that sees the middle of the image, and every frame has that exposure.

use super::{Session, SessionError, Stage};
use crate::render::plan::{self, Plan, PlanError, SamplingQuality};
use crate::scene::camera::geometry::{ImageGeometry, WarpedGeometry};
use crate::scene::composite::{Arrangement, Composite, CompositeFrames, FrameRequest};
use crate::scene::request::{Projection, ViewRequest};
use crate::scene::{Scene, SceneBuilder};
use std::sync::Arc;

/// Smallest height of the image before it is warped.
const MIN_UNWARPED_HEIGHT_PX: f64 = 256.0;
/// Largest width and height of the image before it is warped.
const MAX_UNWARPED_SIDE_PX: f64 = 8192.0;

impl Session {
    /// The scene of the entire image, and the plan that draws its frames and combines them. A map that cannot be read is reported once, and its body is
    /// drawn without the map.
    ///
    /// # Errors
    /// A scene cannot be built, or a module cannot be compiled.
    pub(super) fn composite_plan(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<(Scene, Plan), SessionError> {
        loop {
            let (composite, screen_px) = self.composite_of(request)?;
            let warp_mesh_and_screen = request.composition.warp.as_deref().zip(screen_px);
            let modules = plan::composite_modules(&composite, warp_mesh_and_screen.is_some());
            let report_no_progress = || {};
            self.timed(Stage::Shaders, || self.library.warm(&modules, report_no_progress));
            match self.timed(Stage::Plan, || plan::composite(&composite, self, sampling, warp_mesh_and_screen)) {
                Ok(plan) => return Ok((with_warped_geometry(composite.whole_image, request), plan)),
                // The scenes are built again without the map.
                Err(PlanError::Map { file, why }) if self.record_unreadable_map(&file, &why) => {}
                // Modules on disk were tampered with, and are now replaced.
                Err(_) if self.replace_tampered(&modules) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }

    /// The composed image with the scenes of its frames; if the image is warped, also the size of the projector's screen, pixels.
    fn composite_of(&self, request: &ViewRequest) -> Result<(Composite, Option<[u32; 2]>), SessionError> {
        let screen_px = request.composition.warp.as_ref().map(|_| [request.width, request.height]);
        let mut unwarped = request.clone();
        if let Some(warp_mesh) = &request.composition.warp {
            // The aspect ratio of a dome's circle, of an equirectangular map, or of the screen.
            let aspect = match request.composition.projection {
                Projection::Fisheye => 1.0,
                Projection::Equirectangular => 2.0,
                Projection::Perspective => f64::from(request.width) / f64::from(request.height),
            };
            // At nine tenths of the mesh's nodes, a pixel of the image covers at most about one pixel of the screen. The mesh's unit of length is half the
            // screen's height.
            let height = 0.5 * f64::from(request.height) / warp_mesh.tenth_percentile_derivative(aspect);
            // The upper limit applies to the width, too. On a very wide screen it makes the height smaller than MIN_UNWARPED_HEIGHT_PX.
            let height = height.max(MIN_UNWARPED_HEIGHT_PX).min(MAX_UNWARPED_SIDE_PX / aspect.max(1.0));
            // For a screen that is one pixel wide, the width could round to 0.
            let side_px = |side: f64| side.round().max(1.0) as u32;
            (unwarped.width, unwarped.height) = (side_px(height * aspect), side_px(height));
        }
        let mut frames = CompositeFrames::of(&self.catalog, &self.ephemeris, &unwarped)?;
        let (exposure, body_values) = {
            let FrameRequest { request, viewer } = &frames.meter;
            let new_builder = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let (builder, resources) = self.metered_builder(new_builder)?;
            // An eye sees other values than the viewer midway between the eyes. Faces are drawn from the viewer's own position.
            let is_stereo = matches!(frames.arrangement, Arrangement::Eyes(_));
            (builder.exposure().clone(), if is_stereo { builder.values_of_bodies(&resources) } else { Vec::new() })
        };
        frames.set_exposure(&exposure);
        let mut scenes = Vec::new();
        for FrameRequest { request, viewer } in &frames.frames {
            let new_builder = || SceneBuilder::with_viewer(&self.catalog, &self.ephemeris, request, viewer.clone(), &self.scene_caches);
            let mut scene = self.scene_from(new_builder, |required| self.timed(Stage::Maps, || self.read_maps(required)))?;
            scene.exposure = exposure.clone();
            scenes.push(scene);
        }
        let composite =
            Composite::new((&self.catalog, &self.ephemeris), &unwarped, frames.arrangement, &frames.meter.viewer, body_values, scenes);
        composite.map(|c| (c, screen_px)).ok_or_else(|| SessionError::from(PlanError::Module("an image without a frame".into())))
    }
}

/// A scene with the geometry of the screen onto which its image is warped. Applied after planning, because the plan draws the unwarped image.
fn with_warped_geometry(mut whole: Scene, request: &ViewRequest) -> Scene {
    if let Some(warp_mesh) = &request.composition.warp {
        let image = Box::new(std::mem::take(&mut whole.geometry));
        let image_px = image.projection(&whole.camera).size_px().to_array().map(|px| px.round() as u32);
        let screen_px = [request.width, request.height];
        whole.geometry = ImageGeometry::Warped(WarpedGeometry { image, image_px, mesh: Arc::clone(warp_mesh), screen_px });
    }
    whole
}
