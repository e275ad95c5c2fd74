//! The finished scene: everything that one frame shows, ready to be planned.
//!
//! Plain values. `build` makes them; nothing changes them afterwards.

use crate::catalog::NaifId;
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::{labels, line_texts, orbits};
use crate::scene::camera::Camera;
use crate::scene::camera::geometry::ImageGeometry;
use crate::scene::decision::Decision;
use crate::scene::draw::{Draw, PixelView, Point, StarSprite};
use crate::scene::eclipse::refracted_limb;
use crate::scene::in_view::BodyInView;
use crate::scene::light::exposure::Exposure;
use crate::scene::light::{corona, glow};
use crate::scene::purpose::Purpose;
use crate::scene::request::view_request::ToneMap;
use crate::scene::sky::background::SkyBackground;
use crate::scene::sky::comets::Comets;
use crate::scene::sky::images::SkyImageDraw;
use crate::scene::sky::minor_planets::MinorPlanets;
use crate::time::Instant;

/// One frame, ready to be planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// At which the camera stands there.
    pub time: Instant,
    /// Where it stands, and its projection.
    pub camera: Camera,
    /// Where the finished picture shows directions.
    pub geometry: ImageGeometry,
    /// Factor from radiance to display.
    pub exposure: Exposure,
    /// What the pixels show.
    pub pixel_view: PixelView,
    /// How light beyond white is shown.
    pub tone_map: ToneMap,
    /// Every body of the catalog, in its order.
    pub bodies: Vec<BodyInView>,
    /// Diffuse light behind everything.
    pub background: Option<SkyBackground>,
    /// Over it: images of the user's.
    pub sky_images: Vec<SkyImageDraw>,
    /// Behind all bodies.
    pub stars: Vec<StarSprite>,
    /// Too small to be bodies of the catalog; hidden by what is nearer.
    pub minor_planets: Option<MinorPlanets>,
    /// Among them.
    pub comets: Comets,
    /// What was decided about the sky beyond all bodies.
    pub sky: Vec<Decision>,
    /// Of grids and constellations: between the sky's diffuse light and its stars.
    pub sky_lines: Vec<LineSegment>,
    /// Far to near: `order`.
    pub draws: Vec<Draw>,
    /// Bodies too small for a disc.
    pub points: Vec<Point>,
    /// Over the bodies, hidden by what is nearer.
    pub orbits: Vec<orbits::OrbitArc>,
    /// Like them: where bodies have been.
    pub lines: Vec<LineSegment>,
    /// Over the ground of one body, the side that faces the camera.
    pub ground_lines: Option<(NaifId, Vec<LineSegment>)>,
    /// Among the draws.
    pub corona: Option<corona::Corona>,
    /// Around bodies that stand before the Sun.
    pub limbs: Vec<refracted_limb::RefractedLimb>,
    /// Over everything.
    pub glow: Option<glow::Glow>,
    /// The selected body as a black shape, where its outline is wanted.
    pub outlined: Option<Draw>,
    /// Light beyond white spreads.
    pub bloom: bool,
    /// Over the finished picture, where they are wanted.
    pub labels: Option<labels::LabelLayer>,
    /// The same, of lines.
    pub texts: Option<line_texts::TextLayer>,
    /// What the picture is for.
    pub purpose: Purpose,
}

impl Scene {
    /// A body of the catalog by its code.
    pub fn body(&self, id: NaifId) -> Option<&BodyInView> {
        self.bodies.iter().find(|b| b.id == id)
    }
}
