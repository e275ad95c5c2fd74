//! The report on one body of a frame: its apparent position and size, and the decisions about it.
//!
//! Plain values, which `SceneBuilder::build` fills in. `explain --json` prints them; the text of `explain` and the Information panel show most of them.

use crate::catalog::NaifId;
use crate::message::Reason;
use crate::scene::camera::Placement;
use crate::scene::decision::Decision;
use crate::scene::draw::DrawFeatures;
use glam::DVec3;

/// How a body is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    /// As an ellipsoid or a shape model.
    Disc,
    /// As a disc and a sprite, at 2 to 4 pixels across: they share the light, so that the transition between both is gradual.
    DiscAndPoint,
    /// As a sprite with the body's flux.
    Point,
    /// Not drawn, for a reason that the decisions give: it is outside the frame or behind the camera, has the camera at its centre, could not be placed by the
    /// ephemeris, or is a point too faint to see.
    NotShown,
}

/// A sub-observer or sub-solar point, in planetocentric coordinates.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SubPoint {
    /// Planetocentric latitude, north positive: the angle between the equator and the line from the centre. Latitudes of a
    /// `ViewRequest` are planetographic instead.
    #[serde(rename = "latitude_deg")]
    pub lat_centric_deg: f64,
    /// Longitude, east positive, from -180 to 180 degrees.
    #[serde(rename = "longitude_deg")]
    pub lon_east_deg: f64,
}

impl SubPoint {
    /// The point in a direction from the centre: a vector of any length, body-fixed axes.
    pub fn of(direction_in_body: DVec3) -> Self {
        Self {
            lat_centric_deg: direction_in_body.z.atan2(direction_in_body.truncate().length()).to_degrees(),
            lon_east_deg: direction_in_body.y.atan2(direction_in_body.x).to_degrees(),
        }
    }
}

/// One body of the frame: its appearance to the viewer, and the decisions about it. A field added here without `skip` appears in `explain --json`.
/// In it, `sub_observer` and `decisions` have the names that they had in earlier versions.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BodyReport {
    /// Its NAIF code.
    pub id: NaifId,
    /// As in the catalog.
    pub name: String,
    /// How it is drawn.
    pub appearance: Appearance,
    /// Distance from the camera to the apparent centre.
    pub distance_km: f64,
    /// Angle under which the camera sees its largest diameter.
    pub angular_diameter_deg: f64,
    /// Diameter of a circle with the area of the body's outline, pixels. The outline of a body that is partly behind the camera is no ellipse; then this is an
    /// estimate from its radius and distance. 0 with the camera at the centre, and for a body that could not be placed.
    pub diameter_px: f64,
    /// Angle at the body between the Sun and the viewer; 0 for the Sun.
    pub phase_angle_deg: f64,
    /// Visual magnitude of the complete disc with its rings, in the sunlight that eclipses leave; `None` if no sunlight is left, or if
    /// the body has no direction ([`Self::has_direction`]).
    pub magnitude: Option<f64>,
    /// Where the line to the camera meets the surface. Undefined without such a line ([`Self::has_direction`]).
    #[serde(rename = "sub_viewer")]
    pub sub_observer: SubPoint,
    /// Where the line to the Sun meets the surface; `None` for the Sun itself.
    pub sub_solar: Option<SubPoint>,
    /// Altitude of the Sun's centre at `sub_observer` when the light that the camera sees left the body: the angle above the plane that touches the ellipsoid
    /// there, without refraction. `None` for the Sun itself, for a body that could not be placed, and with the camera at the centre.
    pub sun_altitude_deg: Option<f64>,
    /// Its apparent position and orientation.
    #[serde(skip)]
    pub placement: Placement,
    /// For each effect: whether it is drawn, and why.
    #[serde(rename = "features")]
    pub decisions: Vec<Decision>,
    /// Features of its draws, the globe first.
    #[serde(skip)]
    pub features: Vec<DrawFeatures>,
    /// What the image shows of the body that is invented, not measured.
    #[serde(skip)]
    pub invented: Vec<InventedData>,
}

/// A part of a body's appearance that is invented, not measured.
#[derive(Clone, Debug, PartialEq)]
pub struct InventedData {
    /// File of a map or shape model, or the word `detail` for procedural detail.
    pub source: String,
    /// How it was made.
    pub how_made: Reason,
}

impl BodyReport {
    /// Whether the line from the camera to the body's centre has a direction, so that size, phase, magnitude and sub-observer point are defined. It has none if
    /// the camera is at the centre, or if the ephemeris could not place the body.
    pub fn has_direction(&self) -> bool {
        self.distance_km > 0.0
    }

    /// Replaces the values by those of another viewer, `seen`: for a stereo pair, the viewer between the eyes. What is drawn, where, and why, stays.
    pub(crate) fn take_values(&mut self, seen: Self) {
        let drawn = std::mem::replace(self, seen);
        (self.appearance, self.placement, self.decisions) = (drawn.appearance, drawn.placement, drawn.decisions);
        (self.features, self.invented) = (drawn.features, drawn.invented);
    }
}
