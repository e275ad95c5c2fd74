//! The finished scene: everything that one frame shows, the input of `render::plan`.
//!
//! Plain values. `build` creates them, and `composite` derives the scene of a composed image from those of its frames; nothing changes them afterwards.

use crate::catalog::NaifId;
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::text::{LabelMetrics, Rect};
use crate::scene::annotation::{labels, line_texts, orbit_arcs};
use crate::scene::body_report::BodyReport;
use crate::scene::camera::Camera;
use crate::scene::camera::geometry::ImageGeometry;
use crate::scene::decision::Decision;
use crate::scene::draw::{Draw, PixelView, Point, StarSprite};
use crate::scene::eclipse::refracted_limb;
use crate::scene::light::exposure::Exposure;
use crate::scene::light::{corona, glare};
use crate::scene::purpose::{Purpose, Threshold};
use crate::scene::request::view_request::ToneMap;
use crate::scene::sky::background::SkyBackground;
use crate::scene::sky::comets::Comets;
use crate::scene::sky::images::SkyImageDraw;
use crate::scene::sky::minor_planets::MinorPlanets;
use crate::scene::sky::stars;
use crate::time::Instant;
use glam::DVec3;

/// The finished scene of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The time at the camera.
    pub time: Instant,
    /// The camera's position, axes and projection.
    pub camera: Camera,
    /// The viewer's velocity, barycentric, for the aberration of bodies: zero unless the camera moves with a body.
    pub viewer_velocity_km_s: DVec3,
    /// The mapping from directions to pixels of the finished image: the perspective of `camera`, or another one for a composed image.
    pub geometry: ImageGeometry,
    /// Factor from radiance to display.
    pub exposure: Exposure,
    /// The quantity that the pixels show.
    pub pixel_view: PixelView,
    /// How radiance above white is mapped to display values.
    pub tone_map: ToneMap,
    /// Every body of the catalog, also those that the image does not show, in catalog order.
    pub bodies: Vec<BodyReport>,
    /// Diffuse light of the sky, behind everything else; `None` if it is not drawn.
    pub background: Option<SkyBackground>,
    /// The user's sky images, drawn over the background.
    pub sky_images: Vec<SkyImageDraw>,
    /// Stars, drawn behind all bodies.
    pub stars: Vec<StarSprite>,
    /// Minor planets, from lists of orbital elements; nearer bodies hide them. `None` if they are not drawn.
    pub minor_planets: Option<MinorPlanets>,
    /// Comets, with their tails and orbits.
    pub comets: Comets,
    /// Decisions that belong to no single body: about stars, diffuse light, minor planets, comets, and lines.
    pub sky_decisions: Vec<Decision>,
    /// Lines of grids and constellations, drawn between the sky's diffuse light and its stars.
    pub sky_lines: Vec<LineSegment>,
    /// Draws of bodies, sorted from far to near.
    pub draws: Vec<Draw>,
    /// Bodies with a diameter of up to 4 pixels, drawn as points of light, and the glare of discs with a diameter of up to 16 pixels (`scene::point`).
    pub points: Vec<Point>,
    /// Orbits, drawn over the bodies; nearer bodies hide them.
    pub orbits: Vec<orbit_arcs::OrbitArc>,
    /// Other lines in space: traces of past motion and shadow cones, which nearer bodies hide; and outlines of instruments' fields of view, which no body
    /// hides.
    pub lines_in_space: Vec<LineSegment>,
    /// For each body with lines on its ground: the segments on the side that faces the camera.
    pub ground_lines: Vec<(NaifId, Vec<LineSegment>)>,
    /// The solar corona, drawn after the Sun and the draws behind it; `None` if it is not drawn.
    pub corona: Option<corona::Corona>,
    /// The refracted limbs of bodies in front of the Sun.
    pub refracted_limbs: Vec<refracted_limb::RefractedLimb>,
    /// The Sun's glare, drawn over everything; `None` if it is not drawn.
    pub glare: Option<glare::Glare>,
    /// The draw of the selected body's shape alone, in black, from which its outline is computed; `None` if no outline is drawn.
    pub outlined_shape: Option<Draw>,
    /// Whether bloom spreads light brighter than white.
    pub has_bloom: bool,
    /// Over the finished image: names and markers of bodies, caption, scale bar, compass, names of surface features, points of the user's data; `None` if all
    /// are off.
    pub labels: Option<labels::LabelLayer>,
    /// Over the finished image: texts about lines and the sky, which are coordinates of grids, and names of constellations, stars, comets and instruments;
    /// `None` if there are none.
    pub line_texts: Option<line_texts::TextLayer>,
    /// What the image is for.
    pub purpose: Purpose,
}

impl Scene {
    /// A body of the catalog by its code.
    pub fn body(&self, id: NaifId) -> Option<&BodyReport> {
        self.bodies.iter().find(|b| b.id == id)
    }

    /// The faintest magnitude of a point that is visible in the middle of the image. Infinite for linear light.
    pub(crate) fn limiting_magnitude(&self) -> f64 {
        let threshold = Threshold::of(self.purpose, self.exposure.white());
        stars::limiting_magnitude_in_middle(&*self.geometry.projection(&self.camera), threshold)
    }

    /// How far below the horizontal plane of the camera the centre of a body is, degrees, if the ground of `ground`, near which the camera is, hides the entire
    /// disc; `None` if some of the disc is above the horizon. Not tested: rings and air of the body.
    pub fn degrees_below_ground(&self, body: NaifId, ground: NaifId) -> Option<f64> {
        let (body, ground) = (self.body(body)?, self.body(ground)?);
        if body.id == ground.id || !body.has_direction() || ground.placement.camera_is_inside() {
            return None;
        }
        let direction = body.placement.centre_km.try_normalize()?;
        let is_farther = body.distance_km > ground.placement.ground_along(direction)?.length();
        let is_hidden = is_farther && ground.placement.covers_disc(direction, 0.5 * body.angular_diameter_deg.to_radians());
        // The gradient of the ellipsoid through the camera.
        let gradient = ground.placement.camera_in_unit_sphere() / ground.placement.radii_km;
        let zenith = ground.placement.body_from_icrf.transpose() * gradient.try_normalize()?;
        is_hidden.then(|| -direction.dot(zenith).clamp(-1.0, 1.0).asin().to_degrees())
    }

    /// Rectangles of all texts and bars in the image except the names of bodies.
    #[cfg_attr(not(feature = "view"), expect(dead_code, reason = "only the window asks for them"))]
    pub(crate) fn text_and_bar_rects(&self) -> Vec<Rect> {
        // `occupied` leaves out the names of bodies.
        let label_rects = |layer: &labels::LabelLayer| layer.occupied(&LabelMetrics::of_size(layer.glyph_px)).collect::<Vec<_>>();
        let line_text_rects = |layer: &line_texts::TextLayer| {
            let metrics = LabelMetrics::of_size(layer.glyph_px);
            // `left_end_px`: the left end of a text's centre line.
            layer.texts.iter().map(|text| metrics.rect(&text.text, text.left_end_px)).collect::<Vec<_>>()
        };
        self.labels.iter().flat_map(label_rects).chain(self.line_texts.iter().flat_map(line_text_rects)).collect()
    }
}
