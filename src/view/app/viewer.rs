//! The state of the window and how actions change it: the view, the rate of time, flights, history. All of these are plain values.
//!
//! In: actions of mouse, keys and panels; elapsed real seconds. Out: the current [`ViewState`]. Always: an orbiting camera cannot zoom into its body;
//! *Back* restores the previous view; the current time comes from the given clock. Not here: the window and the panels, turns and zooms
//! (`camera_motion`).

mod camera_motion;

use crate::catalog::{Body, BodyKind, NaifId};
use crate::ephemeris::topocentric::ground_point_km;
use crate::time::Instant;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::flight::{CENTRE_VIEW_DISTANCE_RADII, Flight, Pose};
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::preset_changes::PresetChanges;
use crate::view::app::time_rate::TimeRate;
use crate::view::app::view_state::{
    CameraPose, DEFAULT_FOV_DEG, MAX_FOV_DEG, ViewState, inertial_orbit_pose, pose_on_ground, rotated_view, view_at_azimuth_altitude,
};
use crate::view::language::body_name;
use glam::{DMat3, DQuat, DVec3};

/// A body that the user can select: what the window needs of a [`Body`].
#[derive(Clone, Debug, PartialEq)]
pub struct SelectableBody {
    pub id: NaifId,
    pub name: String,
    pub aliases: Vec<String>,
    pub kind: BodyKind,
    /// The body that it orbits; `None` for the Sun.
    pub parent: Option<NaifId>,
    /// Semi-axes: x through the prime meridian, y at 90 degrees east, z through the pole.
    pub radii_km: DVec3,
}

impl SelectableBody {
    pub fn of(body: &Body) -> Self {
        Self {
            id: body.id,
            name: body.name.clone(),
            aliases: body.aliases.clone(),
            kind: body.kind,
            parent: body.parent,
            radii_km: body.radii_km,
        }
    }
}

/// What a user's input does. Pixels are pixels of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Select a body, and leave the view as it is.
    Select(NaifId),
    /// Fly to the body this many entries after the selected one in the list: 1 for the next, -1 for the previous body.
    FlyAlongList(i32),
    /// Fly to a body, which becomes the target and the selected body at once.
    FlyTo(NaifId),
    /// Turn the camera about its body by a drag in pixels, right and down; a camera that does not orbit looks around instead.
    Turn(f64, f64),
    /// Turn the camera on the spot by pixels, right and down.
    LookAround(f64, f64),
    /// Roll by degrees; positive turns the shown image, mirrored or not, clockwise.
    Roll(f64),
    /// Zoom by wheel notches, positive inwards: change the height of an orbit, or the field of view of any other camera.
    Zoom(f64),
    /// Change the field of view by wheel notches; positive narrows it.
    ChangeFov(f64),
    /// Stand at a planetographic latitude and an east longitude of the selected body, degrees.
    StandOn(f64, f64),
    /// Look at another body from the current position: it becomes the target, and the selected body stays.
    LookAt(NaifId),
    /// Look at the selected body, which becomes the target, from the centre of another body.
    LookFrom(NaifId),
    /// Let an orbiting camera rotate with the body (true), or stay in ICRF (false).
    RotateWithBody(bool),
    /// Make the camera keep facing the target (true), or no longer (false).
    Track(bool),
    /// Face the orbited body again, or, without an orbit, the target; reset the roll.
    FaceBody,
    SetTime(Instant),
    /// Change the time by scene seconds.
    Step(f64),
    /// Run time at a rate, scene seconds per real second.
    RunAt(f64),
    /// Set the speed in scene seconds per real second, and keep the direction.
    SetSpeed(f64),
    /// Set the next faster speed, and resume paused time.
    Faster,
    Slower,
    /// Run time forward.
    TimeForward,
    TimeBackward,
    TogglePause,
    /// Show the present, and let time run forward in real time.
    Now,
    PreviousView,
    NextView,
    /// Show a complete view: a bookmark, a link, a moment. Its target becomes the selected body.
    Show(Box<ViewState>),
    /// Show the view of a preset. The [`PresetChanges`] say what the preset has changed in the settings of the view before; this view already contains them.
    ShowPreset(Box<ViewState>, PresetChanges),
}

/// Distance from a body's centre at which a flight to the body ends, in radii of the body.
const ARRIVAL_RADII: f64 = 3.5;
/// Distance from the Sun's centre at which a flight to the Sun ends, in radii of the Sun.
const ARRIVAL_RADII_SUN: f64 = 6.0;
/// Least field of view of a body seen from another one: the image then shows a small disc with its surroundings.
const MIN_LOOK_FROM_FOV_DEG: f64 = 1.0;
/// Field of view of a body seen from another one, in diameters of its disc. For a small disc `MIN_LOOK_FROM_FOV_DEG` is wider, and applies instead.
const LOOK_FROM_FOV_DIAMETERS: f64 = 1.8;
/// Field of view of a camera that is placed on the ground.
const GROUND_FOV_DEG: f64 = 60.0;
/// Interval between the images of a moving view, seconds.
const MOVING_INTERVAL_S: f64 = 1.0 / 60.0;
/// Interval between images while time runs no faster than real time and nothing else moves, seconds.
pub(crate) const REAL_TIME_INTERVAL_S: f64 = 1.0;
/// Maximum number of views in the history.
const MAX_HISTORY: usize = 64;

/// A direction in the history of views.
#[derive(Clone, Copy)]
enum HistoryStep {
    Back,
    Forward,
}

/// A view in the history, before or after the current one.
struct HistoryEntry {
    view: ViewState,
    /// See [`Viewer::preset_changes`].
    preset_changes: Option<PresetChanges>,
}

/// The state of the window. (`scene::camera::viewpoint::Viewer` is another type: the camera of a frame with its motion.)
pub struct Viewer {
    pub view: ViewState,
    pub time_rate: TimeRate,
    /// The body that is highlighted, and described by the panels about a body. The view's target may be another one.
    pub selected: NaifId,
    /// Whether a tour is changing the view, so that every frame needs a new image.
    pub is_tour_moving: bool,
    selectable_bodies: Vec<SelectableBody>,
    /// A flight and the camera pose at its end. During the flight, all fields of `view` except the camera pose are already those of the destination, so that
    /// the user's changes during the flight last.
    flight: Option<(Flight, CameraPose)>,
    /// What a preset has changed in the view, until the user leaves the preset. The history stores these changes with each view: after *Back* to a preset's
    /// view they are known again, and a view opened from there does not inherit them.
    preset_changes: Option<PresetChanges>,
    /// The views before the current one, oldest first.
    back_history: Vec<HistoryEntry>,
    /// The views to which *Forward* leads, the nearest one last.
    forward_history: Vec<HistoryEntry>,
    /// Gives the current time.
    clock: fn() -> Instant,
}

impl Viewer {
    /// Starts with `view`; `selectable_bodies` is in the order in which lists show the bodies.
    pub fn new(selectable_bodies: Vec<SelectableBody>, mut view: ViewState, clock: fn() -> Instant) -> Self {
        let selected = view.target;
        let mut time_rate = TimeRate::default();
        time_rate.set_paused(view.paused.take().unwrap_or(false));
        Self {
            view,
            time_rate,
            selected,
            is_tour_moving: false,
            selectable_bodies,
            flight: None,
            preset_changes: None,
            back_history: Vec::new(),
            forward_history: Vec::new(),
            clock,
        }
    }

    pub fn selectable_bodies(&self) -> &[SelectableBody] {
        &self.selectable_bodies
    }

    pub(crate) fn selectable_body(&self, id: NaifId) -> Option<&SelectableBody> {
        self.selectable_bodies.iter().find(|s| s.id == id)
    }

    /// The name of a body in the window's language.
    pub(crate) fn name(&self, id: NaifId) -> &str {
        body_name(self.catalog_name(id))
    }

    /// The name of a body in the catalog, in effects and in links.
    pub(crate) fn catalog_name(&self, id: NaifId) -> &str {
        self.selectable_body(id).map_or("?", |s| s.name.as_str())
    }

    /// The current time.
    pub(crate) fn now(&self) -> Instant {
        (self.clock)()
    }

    pub fn is_flying(&self) -> bool {
        self.flight.is_some()
    }

    pub(crate) fn has_previous_view(&self) -> bool {
        !self.back_history.is_empty()
    }

    pub(crate) fn has_next_view(&self) -> bool {
        !self.forward_history.is_empty()
    }

    /// At most `max_count` bodies: first the bodies with a name or alias that begins with the text, then those with a name or alias that only contains it.
    pub(crate) fn matching_bodies(&self, text: &str, max_count: usize) -> Vec<&SelectableBody> {
        let query = text.trim().to_lowercase();
        if query.is_empty() {
            return Vec::new();
        }
        let names = |s: &SelectableBody| {
            [body_name(&s.name), &s.name].into_iter().chain(s.aliases.iter().map(String::as_str)).map(str::to_lowercase).collect::<Vec<_>>()
        };
        let with_prefix = self.selectable_bodies.iter().filter(|s| names(s).iter().any(|n| n.starts_with(&query)));
        let containing = self
            .selectable_bodies
            .iter()
            .filter(|s| names(s).iter().all(|n| !n.starts_with(&query)) && names(s).iter().any(|n| n.contains(&query)));
        with_prefix.chain(containing).take(max_count).collect()
    }

    /// Applies an action. `image_height_px`: height of the image in which the mouse moves; `positions`: of the bodies.
    pub fn apply(&mut self, action: Action, image_height_px: f64, positions: &dyn BodyPositions) {
        match action {
            Action::Select(id) => self.selected = id,
            Action::FlyAlongList(entries) => self.fly_along_list(entries, positions),
            Action::FlyTo(id) => self.fly_to(id, positions),
            Action::Turn(dx_px, dy_px) => self.turn(dx_px, dy_px, image_height_px, positions),
            Action::LookAround(dx_px, dy_px) => self.look_around(dx_px, dy_px, image_height_px, positions),
            Action::Roll(deg) => self.roll(deg, positions),
            Action::Zoom(notches) => self.zoom(notches, positions),
            Action::ChangeFov(notches) => self.change_fov(notches),
            Action::StandOn(latitude_deg, longitude_deg) => self.stand_on(latitude_deg, longitude_deg),
            Action::LookAt(id) => self.look_at(id, positions),
            Action::LookFrom(id) => self.look_from(id, positions),
            Action::RotateWithBody(make_body_fixed) => self.rotate_with_body(make_body_fixed, positions),
            Action::Track(tracks) => self.track(tracks, positions),
            Action::FaceBody => self.face_body(positions),
            Action::SetTime(t) => self.view.tdb_s = t.tdb_seconds_past_j2000(),
            Action::Step(seconds) => self.view.tdb_s += seconds,
            Action::RunAt(rate) => self.time_rate.run_at(rate),
            Action::SetSpeed(speed) => self.time_rate.set_speed(speed),
            Action::Faster => self.time_rate.faster(),
            Action::Slower => self.time_rate.slower(),
            Action::TimeForward => self.time_rate.forward(),
            Action::TimeBackward => self.time_rate.backward(),
            Action::TogglePause => self.time_rate.toggle_pause(),
            Action::Now => {
                self.view.tdb_s = self.now().tdb_seconds_past_j2000();
                self.time_rate.reset();
            }
            Action::PreviousView => self.step_history(HistoryStep::Back),
            Action::NextView => self.step_history(HistoryStep::Forward),
            Action::Show(view) => self.show(*view, None),
            Action::ShowPreset(view, changes) => self.show(*view, Some(changes)),
        }
    }

    /// Advances scene time and a flight by `real_s` real seconds.
    pub(crate) fn advance(&mut self, real_s: f64) {
        self.view.tdb_s += self.time_rate.scene_seconds(real_s);
        let Some((flight, end_pose)) = &mut self.flight else { return };
        if !flight.advance(real_s) {
            self.end_flight();
        } else {
            let Pose { offset_km, forward, up } = flight.pose();
            self.view.camera_pose = CameraPose::Free { body: end_pose.body(), offset_km, forward, up };
        }
    }

    /// Interval between the images that passing time and motion require, seconds; `None` if nothing changes.
    pub(crate) fn frame_interval_s(&self) -> Option<f64> {
        if self.is_animating() {
            return Some(MOVING_INTERVAL_S);
        }
        (self.time_rate.rate() != 0.0).then_some(REAL_TIME_INTERVAL_S)
    }

    /// Whether every frame needs a new image: in a flight or a tour, and while time runs faster than real time.
    pub fn is_animating(&self) -> bool {
        self.time_rate.rate().abs() > 1.0 || self.flight.is_some() || self.is_tour_moving
    }

    /// Stores the current view in the history, and shows another. `preset_changes`: those that `view` contains, if it is the view of a preset.
    fn show(&mut self, mut view: ViewState, preset_changes: Option<PresetChanges>) {
        if let Some(paused) = view.paused.take() {
            self.time_rate.set_paused(paused);
        }
        self.push_history();
        self.selected = view.target;
        self.view = view;
        self.preset_changes = preset_changes;
    }

    /// Stores the view, or a flight's destination, in the history, unless the history ends with this view already. Ends the flight, and drops the views to
    /// which *Forward* led.
    fn push_history(&mut self) {
        let current = self.history_entry();
        self.end_flight();
        if self.back_history.last().is_none_or(|last| last.view != current.view) {
            self.back_history.push(current);
        }
        if self.back_history.len() > MAX_HISTORY {
            self.back_history.remove(0);
        }
        self.forward_history.clear();
    }

    /// The current view, or a flight's destination, as the history stores it.
    fn history_entry(&self) -> HistoryEntry {
        HistoryEntry { view: self.view_after_flight(), preset_changes: self.preset_changes }
    }

    /// Stores the view in the history before the camera goes elsewhere, then undoes the brightness of stars and the exposure that a preset has set, but not
    /// its orbits and constellations. The history keeps the view as it was.
    fn leave_view(&mut self) {
        self.push_history();
        if let Some(changes) = self.preset_changes.take() {
            changes.undo_brightness(&mut self.view);
        }
    }

    /// The view from which new views take quality, effects and layers: the current one, or a flight's destination, without the changes of a preset.
    pub(crate) fn base_view(&self) -> ViewState {
        let mut view = self.view_after_flight();
        if let Some(changes) = self.preset_changes {
            changes.undo(&mut view);
        }
        view
    }

    /// The view at the end of the flight in progress; without a flight, the current view.
    pub fn view_after_flight(&self) -> ViewState {
        let camera_pose = self.flight.as_ref().map_or(self.view.camera_pose, |(_, end_pose)| *end_pose);
        ViewState { camera_pose, ..self.view.clone() }
    }

    /// The view as it is saved and shared, including whether time is paused.
    pub fn shareable_view(&self) -> ViewState {
        ViewState { paused: Some(self.time_rate.is_paused()), ..self.view_after_flight() }
    }

    /// Restores the previous or the next view of the history, if there is one.
    fn step_history(&mut self, step: HistoryStep) {
        let current = self.history_entry();
        let (from_history, to_history) = match step {
            HistoryStep::Back => (&mut self.back_history, &mut self.forward_history),
            HistoryStep::Forward => (&mut self.forward_history, &mut self.back_history),
        };
        let Some(restored) = from_history.pop() else { return };
        to_history.push(current);
        self.flight = None;
        self.selected = restored.view.target;
        (self.view, self.preset_changes) = (restored.view, restored.preset_changes);
    }

    /// Flies to the body this many entries after the selected one in the list, which wraps around at its ends.
    fn fly_along_list(&mut self, entries: i32, positions: &dyn BodyPositions) {
        let count = self.selectable_bodies.len() as i32;
        let Some(index) = self.selectable_bodies.iter().position(|s| s.id == self.selected) else { return };
        if let Some(next) = self.selectable_bodies.get((index as i32 + entries).rem_euclid(count.max(1)) as usize).map(|s| s.id) {
            self.fly_to(next, positions);
        }
    }

    /// The equatorial radius of a body; 1 km for an unknown one.
    fn radius_km(&self, id: NaifId) -> f64 {
        self.selectable_body(id).map_or(1.0, |s| s.radii_km.x)
    }

    /// Position of the camera relative to the centre of a body, and orientation of the camera; ICRF. `None` if the ephemeris does not cover the time.
    fn pose_relative_to(&self, body: NaifId, positions: &dyn BodyPositions) -> Option<Pose> {
        let time = self.view.time();
        let camera_body = self.view.camera_pose.body();
        let icrf_from_body = positions.body_from_icrf(camera_body, time)?.transpose();
        // `up_if_tracking`: the up direction if the camera tracks another body, as in `ViewState::request`: celestial north in an orbit, the zenith on the
        // ground. `None` in poses that do not use `tracks`.
        let (offset_km, forward, up, up_if_tracking) = match self.view.camera_pose {
            CameraPose::Free { offset_km, forward, up, .. } => (offset_km, forward, up, None),
            CameraPose::Orbit { is_body_fixed, azimuth_deg, elevation_deg, distance_radii, yaw_deg, pitch_deg, .. } => {
                let orbit = OrbitCamera::from_degrees(azimuth_deg, elevation_deg, distance_radii);
                let (icrf_from_axes, pole) =
                    if is_body_fixed { (icrf_from_body, DVec3::Z) } else { (DMat3::IDENTITY, icrf_from_body.z_axis) };
                let offset_in_axes_km = orbit.offset_km(self.radius_km(camera_body), pole);
                let (forward, up) = rotated_view(-offset_in_axes_km.normalize(), pole, yaw_deg, pitch_deg);
                (icrf_from_axes * offset_in_axes_km, icrf_from_axes * forward, icrf_from_axes * up, Some(DVec3::Z))
            }
            CameraPose::Ground { latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg, .. } => {
                let radii_km = self.selectable_body(camera_body).map_or(DVec3::ONE, |s| s.radii_km);
                let (body_fixed_km, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
                let (forward, up) = view_at_azimuth_altitude(normal, azimuth_deg, altitude_deg);
                (icrf_from_body * body_fixed_km, icrf_from_body * forward, icrf_from_body * up, Some(icrf_from_body * normal))
            }
            CameraPose::Centre { .. } => {
                // A flight from here draws the body, which the view from its centre omits. The pose is outside, on the side of the target.
                let towards_target = positions.geometric_vector_km(camera_body, self.view.target, time)?.try_normalize()?;
                (towards_target * self.radius_km(camera_body) * CENTRE_VIEW_DISTANCE_RADII, towards_target, DVec3::Z, None)
            }
        };
        let (forward, up) = up_if_tracking
            .filter(|_| self.view.tracks && self.view.target != camera_body)
            .and_then(|up| Some(((positions.geometric_vector_km(camera_body, self.view.target, time)? - offset_km).try_normalize()?, up)))
            .unwrap_or((forward, up));
        let level_up = (up - forward * up.dot(forward)).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let roll_rad = if matches!(self.view.camera_pose, CameraPose::Free { .. }) { 0.0 } else { self.view.roll_deg.to_radians() };
        // A positive roll turns the up vector about `forward` by a negative angle.
        let up = DQuat::from_axis_angle(forward, -roll_rad) * level_up;
        // The same position relative to `body`.
        Some(Pose { offset_km: positions.free_camera_offset_km(body, camera_body, offset_km, time)?, forward, up })
    }

    /// Starts a flight to a body, or shows the body at once if the current pose of the camera is unknown. Does nothing for an unknown body.
    fn fly_to(&mut self, id: NaifId, positions: &dyn BodyPositions) {
        let time = self.view.time();
        let Some(radius_km) = self.selectable_body(id).map(|s| s.radii_km.x) else { return };
        let Some(pole) = positions.body_from_icrf(id, time).map(|m| m.row(2)) else { return };
        let sunward = positions.geometric_vector_km(id, NaifId::SUN, time).and_then(DVec3::try_normalize);
        let start_pose = self.pose_relative_to(id, positions);
        // Unit vector from the body to the side of arrival: its lit side, or for the Sun the side where the camera is now.
        let side = sunward.or(start_pose.and_then(|p| p.offset_km.try_normalize())).unwrap_or(DVec3::X);
        let orbit = if id == NaifId::SUN {
            OrbitCamera::from_offset_radii(side * ARRIVAL_RADII_SUN, pole)
        } else {
            OrbitCamera::on_lit_side(side, ARRIVAL_RADII, pole)
        };
        self.leave_view();
        self.selected = id;
        (self.view.target, self.view.tracks, self.view.roll_deg, self.view.fov_deg) = (id, true, 0.0, DEFAULT_FOV_DEG);
        let end_pose = inertial_orbit_pose(id, orbit);
        let offset_km = orbit.offset_km(radius_km, pole);
        let forward = -offset_km.normalize();
        let (yaw_deg, pitch_deg) = (0.0, 0.0);
        let (_, up) = rotated_view(forward, pole, yaw_deg, pitch_deg);
        match start_pose {
            Some(start) => {
                self.view.camera_pose = CameraPose::Free { body: id, offset_km: start.offset_km, forward: start.forward, up: start.up };
                self.flight = Some((Flight::new(start, Pose { offset_km, forward, up }), end_pose));
            }
            None => self.view.camera_pose = end_pose,
        }
    }

    /// Ends a flight at once: the camera takes the pose of the destination, an orbit that drags can change.
    fn end_flight(&mut self) {
        if let Some((_, end_pose)) = self.flight.take() {
            self.view.camera_pose = end_pose;
        }
    }

    /// Places the camera on the ground of the selected body.
    fn stand_on(&mut self, latitude_deg: f64, longitude_deg: f64) {
        let body = self.selected;
        self.leave_view();
        self.view.camera_pose = pose_on_ground(body, latitude_deg, longitude_deg);
        (self.view.target, self.view.roll_deg, self.view.fov_deg) = (body, 0.0, GROUND_FOV_DEG);
    }

    /// Shows the selected body, with its surroundings, from the centre of `camera_body`.
    fn look_from(&mut self, camera_body: NaifId, positions: &dyn BodyPositions) {
        let target = self.selected;
        if camera_body == target {
            return;
        }
        // An unknown distance counts as infinite: the field of view is then the least.
        let distance_km = positions.geometric_vector_km(camera_body, target, self.view.time()).map_or(f64::INFINITY, DVec3::length);
        // Half the angle that the target's disc spans.
        let half_disc_deg = (self.radius_km(target) / distance_km).min(1.0).asin().to_degrees();
        let fov_deg = (2.0 * half_disc_deg * LOOK_FROM_FOV_DIAMETERS).clamp(MIN_LOOK_FROM_FOV_DEG, MAX_FOV_DEG);
        let camera_pose = CameraPose::Centre { body: camera_body };
        self.leave_view();
        self.view = ViewState { camera_pose, target, tracks: true, fov_deg, roll_deg: 0.0, ..self.view.clone() };
    }
}

#[cfg(test)]
mod tests;
