//! One body of a frame as it is reported: where it is seen, how large, and what was decided about it.

use crate::catalog::NaifId;
use crate::scene::camera::Placement;
use crate::scene::decision::Decision;
use crate::scene::draw::DrawFeatures;
use glam::DVec3;

/// How a body is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    /// As a shape of its own.
    Disc,
    /// 2 to 4 pixels across: a disc that grows out of its point, the light shared between them.
    DiscAndPoint,
    /// As a sprite with its light.
    Point,
    /// Outside the frame, behind the camera, around it, or not placed by the ephemeris: the first decision says which.
    NotShown,
}

/// Planetocentric place under a direction, degrees; east longitude in -180..=180.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SubPoint {
    /// Planetographic, north.
    pub latitude_deg: f64,
    /// East.
    pub longitude_deg: f64,
}

impl SubPoint {
    /// Of a direction of any length in body-fixed axes.
    pub fn of(direction_in_body: DVec3) -> Self {
        Self {
            latitude_deg: direction_in_body.z.atan2(direction_in_body.truncate().length()).to_degrees(),
            longitude_deg: direction_in_body.y.atan2(direction_in_body.x).to_degrees(),
        }
    }
}

/// One body of the frame: what the viewer has of it and what was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyInView {
    /// Its NAIF code.
    pub id: NaifId,
    /// As in the catalog.
    pub name: String,
    /// How it is drawn.
    pub appearance: Appearance,
    /// To the apparent centre.
    pub distance_km: f64,
    /// Of its equatorial diameter.
    pub angular_diameter_deg: f64,
    /// Diameter of the disc of the same area, pixels.
    pub diameter_px: f64,
    /// Sun - body - viewer; 0 for the Sun.
    pub phase_angle_deg: f64,
    /// Visual magnitude of the whole disc with its rings, in the sunlight that eclipses leave; `None` where none is left.
    pub magnitude: Option<f64>,
    /// Where the line to the camera meets the surface.
    pub sub_viewer: SubPoint,
    /// Where the line to the Sun does; `None` for the Sun itself.
    pub sub_solar: Option<SubPoint>,
    /// Where it is seen, and how it is turned.
    pub placement: Placement,
    /// Each feature, whether it is drawn, and why.
    pub decisions: Vec<Decision>,
    /// Structure of its draws, the globe first.
    pub features: Vec<DrawFeatures>,
    /// What is shown of it that nobody has measured: a map's or a shape's file, and how it was made.
    pub invented: Vec<(String, String)>,
}
