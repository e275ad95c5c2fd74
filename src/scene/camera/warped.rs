//! Where a picture on a warp mesh shows what the picture itself shows elsewhere.
//!
//! In: pixels of the picture, pixels of the screen. Out: one for the other. Always: both directions use the triangles that the renderer draws, so that a mark stands on what it marks.

use super::geometry::ImageGeometry;
use crate::scene::request::warp_mesh::WarpMesh;
use glam::DVec2;
use std::sync::Arc;

/// A finished picture on a mesh. Pixels from the top left corner, as everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpedGeometry {
    /// How the picture on the mesh shows directions.
    pub picture: Box<ImageGeometry>,
    /// Its size.
    pub picture_px: [u32; 2],
    pub mesh: Arc<WarpMesh>,
    /// Size of the screen.
    pub screen_px: [u32; 2],
}

impl WarpedGeometry {
    /// The pixel of the screen that shows a pixel of the picture; `None` if none does. Of several the first in the mesh.
    pub(crate) fn screen_of_picture(&self, pixel: DVec2) -> Option<DVec2> {
        let part = pixel / size(self.picture_px);
        let place = self.mesh.screen_of_picture(DVec2::new(part.x, 1.0 - part.y))?;
        let screen = size(self.screen_px);
        Some(DVec2::new(0.5 * screen.x + 0.5 * screen.y * place.x, 0.5 * screen.y * (1.0 - place.y)))
    }

    /// The pixel of the picture that a pixel of the screen shows; `None` beside the mesh.
    pub(crate) fn picture_of_screen(&self, pixel: DVec2) -> Option<DVec2> {
        let screen = size(self.screen_px);
        let place = (pixel - 0.5 * screen) / (0.5 * screen.y);
        let part = self.mesh.picture_of_screen(DVec2::new(place.x, -place.y))?;
        Some(DVec2::new(part.x, 1.0 - part.y) * size(self.picture_px))
    }

    /// Pixels of the screen per pixel of the picture, where both have one height.
    pub(crate) fn scale(&self) -> f64 {
        f64::from(self.screen_px[1]) / f64::from(self.picture_px[1])
    }
}

fn size([width, height]: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(width), f64::from(height))
}
