//! A tour: views with texts, and the camera path from each to the next.
//!
//! In: JSON, a session. Out: the view and the text at a given time. Always: the camera starts and ends each path at rest and meets both ends; scene time runs from one view's to
//! the other's without a jump; fields that a stop omits have the defaults of a link. A file with an error is refused, with the stop and the field. Not here: playback.

use super::flight::{FLIGHT_S, Flight, Pose, ease_in_out};
use super::places::{BodyPositions, SessionPositions};
use super::view_state::{CameraPose, ViewState};
use crate::ephemeris::angle_rad;
use crate::scene::viewpoint::viewer;
use crate::session::Session;
use crate::time::Instant;
use crate::view::link::view_from_text;
use serde::Deserialize;
use serde_json::Value;

/// Largest tour, bytes; a stop has some 600.
pub(crate) const MAX_BYTES: u64 = 1 << 20;
/// Longest tour, seconds: an hour.
const MAX_LENGTH_S: f64 = 3600.0;

/// Why a text is no tour, in one line.
#[derive(Debug, thiserror::Error)]
pub enum TourError {
    /// Not JSON, or not the fields of a tour.
    #[error("not a tour: {0}")]
    Json(#[from] serde_json::Error),
    #[error("a tour has at least one stop: add to \"stops\"")]
    Empty,
    /// An invalid field of a stop, counted from 1.
    #[error("stop {stop}, {field}: {why}")]
    Stop { stop: usize, field: &'static str, why: String },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TourFile {
    title: String,
    stops: Vec<StopFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StopFile {
    /// A link, or the fields of a view file.
    view: Value,
    #[serde(default)]
    text: String,
    #[serde(default = "usual_hold_s")]
    hold_s: f64,
    #[serde(default = "usual_travel_s")]
    travel_s: f64,
    #[serde(default)]
    time_rate: f64,
}

fn usual_hold_s() -> f64 {
    6.0
}

fn usual_travel_s() -> f64 {
    4.0
}

#[derive(Clone, Debug, PartialEq)]
struct Stop {
    view: ViewState,
    text: String,
    /// Real seconds for which the camera stays, and scene seconds per real second meanwhile.
    hold_s: f64,
    time_rate: f64,
    /// Seconds of the path to this stop.
    travel_s: f64,
    /// `None`: the first stop, or a cut.
    camera_path: Option<CameraPath>,
}

/// The camera path from the end of one stop to the start of the next.
#[derive(Clone, Debug, PartialEq)]
struct CameraPath {
    flight: Flight,
    from_tdb_s: f64,
    from_fov_deg: f64,
    /// Fraction by which the path is raised above the body's centre in its middle, so that it leads over the horizon and not through the ground.
    lift: f64,
}

/// A path is raised if it starts or ends within this many radii of the body's centre.
const NEAR_RADII: f64 = 1.2;
/// How much it is raised in its middle, per radian around the body.
const LIFT_PER_RAD: f64 = 0.3;

/// The state of a tour at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct TourMoment {
    pub view: ViewState,
    /// Number of the stop, from 0; on a path the one that it leads to.
    pub stop: usize,
    /// The camera is moving between stops.
    pub moves: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tour {
    pub title: String,
    stops: Vec<Stop>,
}

impl Tour {
    /// `now`: the time of stops without one.
    ///
    /// # Errors
    /// The stop and the invalid field.
    pub fn parse(text: &str, session: &Session, now: Instant) -> Result<Self, TourError> {
        let file: TourFile = serde_json::from_str(text)?;
        let mut stops: Vec<Stop> = Vec::new();
        let mut length_s = 0.0;
        for (k, told) in file.stops.into_iter().enumerate() {
            let wrong = |field: &'static str, why: String| TourError::Stop { stop: k + 1, field, why };
            let words = match told.view {
                Value::String(link) => link,
                fields => fields.to_string(),
            };
            let view = view_from_text(&words, session, now).map_err(|e| wrong("view", e.to_string()))?;
            for (field, value) in [("hold_s", told.hold_s), ("travel_s", told.travel_s)] {
                if !(0.0..=3600.0).contains(&value) {
                    return Err(wrong(field, format!("{value} is not 0 to 3600 seconds")));
                }
            }
            if !(-1e9..=1e9).contains(&told.time_rate) {
                return Err(wrong("time_rate", format!("{} is not -1e9 to 1e9 seconds a second", told.time_rate)));
            }
            let mut stop =
                Stop { view, text: told.text, hold_s: told.hold_s, time_rate: told.time_rate, travel_s: told.travel_s, camera_path: None };
            match stops.last() {
                Some(before) if stop.travel_s > 0.0 => {
                    let camera_path = CameraPath::between(&before.left(), &stop.view, session).map_err(|why| wrong("view", why))?;
                    stop.camera_path = Some(camera_path);
                }
                _ => stop.travel_s = 0.0,
            }
            length_s += stop.travel_s + stop.hold_s;
            if length_s > MAX_LENGTH_S {
                return Err(wrong("hold_s", format!("the tour is longer than {MAX_LENGTH_S} s")));
            }
            stops.push(stop);
        }
        if stops.is_empty() { Err(TourError::Empty) } else { Ok(Self { title: file.title, stops }) }
    }

    /// Total length, seconds.
    pub fn length_s(&self) -> f64 {
        self.stops.iter().map(|s| s.travel_s + s.hold_s).sum()
    }

    /// Number of stops.
    pub fn stops(&self) -> usize {
        self.stops.len()
    }

    /// The text of a stop.
    pub fn text(&self, stop: usize) -> &str {
        self.stops.get(stop).map_or("", |s| s.text.as_str())
    }

    /// When the camera arrives at a stop, seconds from the start.
    pub fn arrival_s(&self, stop: usize) -> f64 {
        let before: f64 = self.stops.iter().take(stop).map(|s| s.travel_s + s.hold_s).sum();
        before + self.stops.get(stop).map_or(0.0, |s| s.travel_s)
    }

    /// The state at a time, clamped to the tour.
    pub fn at(&self, passed_s: f64) -> TourMoment {
        let mut left_s = passed_s.max(0.0);
        let last = self.stops.len() - 1;
        for (k, stop) in self.stops.iter().enumerate() {
            if let Some(camera_path) = stop.camera_path.as_ref().filter(|_| left_s < stop.travel_s) {
                return TourMoment { view: camera_path.at(left_s / stop.travel_s, &stop.view), stop: k, moves: true };
            }
            left_s -= stop.travel_s;
            if left_s < stop.hold_s || k == last {
                let held_s = left_s.clamp(0.0, stop.hold_s);
                return TourMoment { view: stop.after(held_s), stop: k, moves: stop.time_rate != 0.0 && left_s < stop.hold_s };
            }
            left_s -= stop.hold_s;
        }
        // A tour has at least one stop.
        TourMoment { view: self.stops[last].left(), stop: last, moves: false }
    }
}

impl Stop {
    fn after(&self, held_s: f64) -> ViewState {
        ViewState { tdb_s: self.view.tdb_s + held_s * self.time_rate, paused: Some(true), ..self.view.clone() }
    }

    fn left(&self) -> ViewState {
        self.after(self.hold_s)
    }
}

impl CameraPath {
    fn between(from: &ViewState, to: &ViewState, session: &Session) -> Result<Self, String> {
        let body = to.eye.body();
        let pose = |view: &ViewState| -> Result<Pose, String> {
            let (catalog, ephemeris) = (session.catalog(), session.ephemeris());
            // The image size does not affect the position of the camera.
            let request = view.request(catalog, ephemeris, 64, 64).map_err(|e| e.to_string())?;
            let viewer = viewer(catalog, ephemeris, &request).map_err(|e| e.to_string())?;
            let camera = viewer.camera;
            let own = view.eye.body();
            let own_km = match viewer.stands_on {
                Some((_, centre_km)) => centre_km,
                None => ephemeris.light_time_position(own, camera.position_km, view.time()).map_err(|e| e.to_string())?.0,
            };
            let offset_km = SessionPositions(session)
                .offset_from_km(body, own, camera.position_km - own_km, view.time())
                .ok_or_else(|| format!("no source knows where {} is", body.0))?;
            Ok(Pose { offset_km, forward: camera.forward, up: camera.up })
        };
        let (start, end) = (pose(from)?, pose(to)?);
        let radius_km = session.catalog().body(body).map_or(0.0, |b| b.radii_km.max_element());
        let is_near = start.offset_km.length().min(end.offset_km.length()) < NEAR_RADII * radius_km;
        let lift = if is_near { LIFT_PER_RAD * angle_rad(start.offset_km, end.offset_km) } else { 0.0 };
        Ok(Self { flight: Flight::new(start, end), from_tdb_s: from.tdb_s, from_fov_deg: from.fov_deg, lift })
    }

    fn at(&self, part: f64, to: &ViewState) -> ViewState {
        let Pose { offset_km, forward, up } = Flight { passed_s: part * FLIGHT_S, ..self.flight }.pose();
        let s = ease_in_out(part);
        let offset_km = offset_km * (1.0 + self.lift * 4.0 * s * (1.0 - s));
        ViewState {
            tdb_s: self.from_tdb_s + (to.tdb_s - self.from_tdb_s) * s,
            eye: CameraPose::Free { body: to.eye.body(), offset_km, forward, up },
            tracks: false,
            fov_deg: (self.from_fov_deg.ln() + (to.fov_deg / self.from_fov_deg).ln() * s).exp(),
            paused: Some(true),
            ..to.clone()
        }
    }
}
