//! A tour: views with texts (stops), and the camera path from each stop to the next.
//!
//! In: JSON, a session. Out: the view and the text at a given time. Always: the camera starts and ends each path at rest, exactly at the views
//! of the stops, or outside the body if a stop is seen from a body's centre; along a path, scene time runs without a jump from the time of the
//! first view to the time of the second; fields that a stop's view omits have the defaults of a link; a file with an error is rejected with a message
//! that names the stop and the field. Not here: playback.

use super::body_positions::{BodyPositions, SessionPositions};
use super::composition_state::CompositionState;
use super::flight::{CENTRE_VIEW_DISTANCE_RADII, FLIGHT_S, Flight, Pose, ease_in_out};
use super::view_state::{CameraPose, ViewState};
use crate::catalog::NaifId;
use crate::ephemeris::angle_rad;
use crate::scene::request::Projection;
use crate::scene::viewpoint::{Viewer, viewer};
use crate::session::Session;
use crate::time::Instant;
use crate::view::link::view_from_text;
use crate::wording::without_byte_order_mark;
use serde::Deserialize;
use serde_json::Value;

/// Largest tour file, bytes; a stop takes about 600 bytes.
pub(crate) const MAX_BYTES: u64 = 1 << 20;
/// Maximum number of stops. A file of a megabyte could have 87,000 of the shortest form, `{"view":{}}`, and a camera path takes 3 ms to plan in a
/// development build.
const MAX_STOPS: usize = 1000;
/// Length of the longest tour, an hour; also the greatest `hold_s` and `travel_s`.
const MAX_LENGTH_S: f64 = 3600.0;
/// Greatest magnitude of `time_rate`: 32 years per second, which crosses the span of the built-in ephemeris in about three minutes.
const MAX_TIME_RATE: f64 = 1e9;

/// Why a text is not a valid tour, in one line.
#[derive(Debug, thiserror::Error)]
pub enum TourError {
    /// Not JSON, or not the fields of a tour.
    #[error("not a tour: {0}")]
    Json(#[from] serde_json::Error),
    #[error("a tour has at least one stop: add one to \"stops\"")]
    Empty,
    /// More stops than a tour may have.
    #[error("{0} stops; a tour has at most {MAX_STOPS}")]
    TooManyStops(usize),
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

/// A stop in a tour file; [`Stop`] describes the fields.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StopFile {
    /// A link, or the fields of a view file.
    #[serde(deserialize_with = "crate::json::deserialize")]
    view: Value,
    #[serde(default)]
    text: String,
    #[serde(default = "default_hold_s")]
    hold_s: f64,
    #[serde(default = "default_travel_s")]
    travel_s: f64,
    #[serde(default)]
    time_rate: f64,
}

fn default_hold_s() -> f64 {
    6.0
}

fn default_travel_s() -> f64 {
    4.0
}

/// A stop of a tour, with the camera path to it.
#[derive(Clone, Debug, PartialEq)]
struct Stop {
    view: ViewState,
    text: String,
    /// Real seconds for which the camera stays at the stop.
    hold_s: f64,
    /// Scene seconds per real second while the camera stays.
    time_rate: f64,
    /// Real seconds that the camera path to this stop takes; 0 without a camera path.
    travel_s: f64,
    /// The camera path to this stop; `None` for the first stop, and for a cut (`travel_s` is 0).
    camera_path: Option<CameraPath>,
}

/// The camera path from the end of one stop to the start of the next.
#[derive(Clone, Debug, PartialEq)]
struct CameraPath {
    flight: Flight,
    /// Time of the view at the start of the path, TDB seconds past J2000.
    start_tdb_s: f64,
    /// Vertical field of view at the start of the path.
    start_fov_deg: f64,
    /// Full angle of the fisheye at the start of the path; `None` unless both stops are fisheyes.
    start_fisheye_deg: Option<f64>,
    /// Fraction by which the distance from the body's centre is increased in the middle of the path, to keep the path above the ground.
    lift: f64,
}

/// A path is raised if it starts or ends within this many radii of the body's centre.
const NEAR_RADII: f64 = 1.2;
/// Fraction by which a path is raised in its middle, per radian of the angle between its ends as seen from the body's centre.
const LIFT_PER_RAD: f64 = 0.3;

/// What a tour shows at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct TourFrame {
    pub view: ViewState,
    /// Index of the stop, from 0; on a camera path, of the stop at its end.
    pub stop_index: usize,
    /// Whether the view is changing: the camera moves between stops, or scene time runs.
    pub is_changing: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tour {
    pub title: String,
    stops: Vec<Stop>,
}

impl Tour {
    /// Parses a tour file. `now`: the time of stops that specify no time.
    ///
    /// # Errors
    /// If the text is not a tour; the error names the stop and the invalid field.
    pub fn parse(text: &str, session: &Session, now: Instant) -> Result<Self, TourError> {
        let file: TourFile = serde_json::from_str(without_byte_order_mark(text))?;
        if file.stops.len() > MAX_STOPS {
            return Err(TourError::TooManyStops(file.stops.len()));
        }
        let mut stops: Vec<Stop> = Vec::new();
        // Real seconds of all stays and of all camera paths so far.
        let (mut total_hold_s, mut total_travel_s) = (0.0, 0.0);
        for (index, stop_file) in file.stops.into_iter().enumerate() {
            let error = |field: &'static str, why: String| TourError::Stop { stop: index + 1, field, why };
            let view_text = match stop_file.view {
                Value::String(link) => link,
                fields => fields.to_string(),
            };
            let view = view_from_text(&view_text, session, now).map_err(|e| error("view", e.to_string()))?;
            for (field, value) in [("hold_s", stop_file.hold_s), ("travel_s", stop_file.travel_s)] {
                if !(0.0..=MAX_LENGTH_S).contains(&value) {
                    return Err(error(field, format!("{value:?} is not 0 to {MAX_LENGTH_S} seconds")));
                }
            }
            if !(-MAX_TIME_RATE..=MAX_TIME_RATE).contains(&stop_file.time_rate) {
                let range = format!("{:e} to {MAX_TIME_RATE:e}", -MAX_TIME_RATE);
                return Err(error("time_rate", format!("{} is not {range} scene seconds per real second", stop_file.time_rate)));
            }
            let mut stop = Stop {
                view,
                text: stop_file.text,
                hold_s: stop_file.hold_s,
                time_rate: stop_file.time_rate,
                travel_s: stop_file.travel_s,
                camera_path: None,
            };
            match stops.last() {
                Some(previous) if stop.travel_s > 0.0 => {
                    let start_view = previous.final_view();
                    // A failure here is an error of the previous stop, whose number is `index`, because messages count stops from 1. If that stop has a camera
                    // at its start, but none at its end, its `time_rate` is wrong.
                    let start_viewer = viewer_of(&start_view, session).map_err(|why| TourError::Stop {
                        stop: index,
                        field: if viewer_of(&previous.view, session).is_ok() { "time_rate" } else { "view" },
                        why,
                    })?;
                    let end_viewer = viewer_of(&stop.view, session).map_err(|why| error("view", why))?;
                    let camera_path = CameraPath::between((&start_view, &start_viewer), (&stop.view, &end_viewer), session);
                    stop.camera_path = Some(camera_path.map_err(|why| error("view", why))?);
                }
                _ => stop.travel_s = 0.0,
            }
            // Time runs during the stay, perhaps beyond the ephemeris.
            if stop.time_rate != 0.0 && viewer_of(&stop.view, session).is_ok() {
                viewer_of(&stop.final_view(), session).map_err(|why| error("time_rate", why))?;
            }
            total_hold_s += stop.hold_s;
            total_travel_s += stop.travel_s;
            if total_hold_s + total_travel_s > MAX_LENGTH_S {
                // The field to which most of the length is due. The message gives both sums and the number of stops, because the user may change any of them.
                let field = if total_travel_s > total_hold_s { "travel_s" } else { "hold_s" };
                let sums = format!("{total_hold_s:.1} s of hold_s and {total_travel_s:.1} s of travel_s in {} stops", index + 1);
                return Err(error(field, format!("up to here the tour is longer than {MAX_LENGTH_S} s: {sums}")));
            }
            stops.push(stop);
        }
        if stops.is_empty() { Err(TourError::Empty) } else { Ok(Self { title: file.title, stops }) }
    }

    /// Total length, real seconds.
    pub fn length_s(&self) -> f64 {
        self.stops.iter().map(|s| s.travel_s + s.hold_s).sum()
    }

    /// Number of stops.
    pub fn stop_count(&self) -> usize {
        self.stops.len()
    }

    /// The text of a stop. `stop_index`: from 0.
    pub fn text(&self, stop_index: usize) -> &str {
        self.stops.get(stop_index).map_or("", |s| s.text.as_str())
    }

    /// Time at which the camera arrives at a stop, real seconds from the start of the tour. `stop_index`: from 0.
    pub fn arrival_s(&self, stop_index: usize) -> f64 {
        let departure_s: f64 = self.stops.iter().take(stop_index).map(|s| s.travel_s + s.hold_s).sum();
        departure_s + self.stops.get(stop_index).map_or(0.0, |s| s.travel_s)
    }

    /// What the tour shows `elapsed_s` real seconds after its start, clamped to the tour.
    pub fn at(&self, elapsed_s: f64) -> TourFrame {
        // Real seconds since the start of the camera path to the stop `index`; once `travel_s` is subtracted, since the arrival at this stop.
        let mut remaining_s = elapsed_s.max(0.0);
        // A tour has at least one stop.
        let last = self.stops.len() - 1;
        let mut index = 0;
        loop {
            let stop = &self.stops[index];
            if let Some(camera_path) = stop.camera_path.as_ref().filter(|_| remaining_s < stop.travel_s) {
                return TourFrame { view: camera_path.at(remaining_s / stop.travel_s, &stop.view), stop_index: index, is_changing: true };
            }
            remaining_s -= stop.travel_s;
            if remaining_s < stop.hold_s || index == last {
                let held_s = remaining_s.clamp(0.0, stop.hold_s);
                return TourFrame {
                    view: stop.view_after(held_s),
                    stop_index: index,
                    is_changing: stop.time_rate != 0.0 && remaining_s < stop.hold_s,
                };
            }
            remaining_s -= stop.hold_s;
            index += 1;
        }
    }
}

impl Stop {
    /// The view after the camera has stayed for `held_s` real seconds.
    fn view_after(&self, held_s: f64) -> ViewState {
        ViewState { tdb_s: self.view.tdb_s + held_s * self.time_rate, paused: Some(true), ..self.view.clone() }
    }

    /// The view at which the camera leaves the stop.
    fn final_view(&self) -> ViewState {
        self.view_after(self.hold_s)
    }
}

/// The camera of a view's scene, and the body on whose ground it stands, if any.
fn viewer_of(view: &ViewState, session: &Session) -> Result<Viewer, String> {
    let (catalog, ephemeris) = (session.catalog(), session.ephemeris());
    // The image size does not affect the position of the camera.
    let request = view.request(catalog, ephemeris, 64, 64).map_err(|e| e.to_string())?;
    viewer(catalog, ephemeris, &request).map_err(|e| e.to_string())
}

/// The pose of a view's camera relative to the centre of `body`; for a view from a body's centre, a pose outside that body on the side that the camera
/// faces.
fn pose_about(body: NaifId, view: &ViewState, viewer: &Viewer, session: &Session) -> Result<Pose, String> {
    let name = |id| session.catalog().body(id).map_or("?", |b| b.name.as_str());
    let camera = &viewer.camera;
    let camera_body = view.camera_pose.body();
    let offset_from_camera_body_km = match (view.camera_pose, viewer.stands_on) {
        (CameraPose::Centre { .. }, _) => camera.forward * CENTRE_VIEW_DISTANCE_RADII * radius_km(camera_body, session),
        (_, Some(ground)) => camera.position_km - ground.centre_km,
        (_, None) => {
            let body_position = session.ephemeris().light_time_position(camera_body, camera.position_km, view.time());
            let (body_km, _) = body_position.map_err(|e| e.to_string())?;
            camera.position_km - body_km
        }
    };
    let offset_km = SessionPositions(session)
        .free_camera_offset_km(body, camera_body, offset_from_camera_body_km, view.time())
        .ok_or_else(|| format!("no source gives the positions of {} and {}", name(camera_body), name(body)))?;
    Ok(Pose { offset_km, forward: camera.forward, up: camera.up })
}

/// The greatest radius of a body; 0 for one that the catalog lacks.
fn radius_km(body: NaifId, session: &Session) -> f64 {
    session.catalog().body(body).map_or(0.0, |b| b.radii_km.max_element())
}

impl CameraPath {
    /// The path from one view to another, relative to the body of the view at the end. Each view is given with its [`viewer_of`].
    fn between(
        (start_view, start_viewer): (&ViewState, &Viewer),
        (end_view, end_viewer): (&ViewState, &Viewer),
        session: &Session,
    ) -> Result<Self, String> {
        let body = end_view.camera_pose.body();
        let (start, end) = (pose_about(body, start_view, start_viewer, session)?, pose_about(body, end_view, end_viewer, session)?);
        let is_near = start.offset_km.length().min(end.offset_km.length()) < NEAR_RADII * radius_km(body, session);
        let lift = if is_near { LIFT_PER_RAD * angle_rad(start.offset_km, end.offset_km) } else { 0.0 };
        let are_fisheyes = [start_view, end_view].iter().all(|view| view.composition.projection == Projection::Fisheye);
        let start_fisheye_deg = are_fisheyes.then_some(start_view.composition.fisheye_deg);
        Ok(Self {
            flight: Flight::new(start, end),
            start_tdb_s: start_view.tdb_s,
            start_fov_deg: start_view.fov_deg,
            start_fisheye_deg,
            lift,
        })
    }

    /// The view at a fraction of the path's duration, 0 to 1. `end_view`: the view at the end of the path.
    fn at(&self, fraction: f64, end_view: &ViewState) -> ViewState {
        let Pose { offset_km, forward, up } = Flight { elapsed_s: fraction * FLIGHT_S, ..self.flight }.pose();
        let eased = ease_in_out(fraction);
        // 4 x (1 - x) is 1 in the middle of the path and 0 at its ends.
        let offset_km = offset_km * (1.0 + self.lift * 4.0 * eased * (1.0 - eased));
        // Interpolates the logarithm, so that the zoom is even. The result is clamped, because rounding could exceed the greatest field of view.
        let interpolated_deg = |start_deg: f64, end_deg: f64| {
            (start_deg.ln() + (end_deg / start_deg).ln() * eased).exp().clamp(start_deg.min(end_deg), start_deg.max(end_deg))
        };
        let end_fisheye_deg = end_view.composition.fisheye_deg;
        let fisheye_deg = self.start_fisheye_deg.map_or(end_fisheye_deg, |start_deg| interpolated_deg(start_deg, end_fisheye_deg));
        ViewState {
            composition: CompositionState { fisheye_deg, ..end_view.composition.clone() },
            tdb_s: self.start_tdb_s + (end_view.tdb_s - self.start_tdb_s) * eased,
            camera_pose: CameraPose::Free { body: end_view.camera_pose.body(), offset_km, forward, up },
            tracks: false,
            fov_deg: interpolated_deg(self.start_fov_deg, end_view.fov_deg),
            paused: Some(true),
            ..end_view.clone()
        }
    }
}
