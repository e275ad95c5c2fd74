//! What the window shows and how input changes it: body, orbit, time, pace. Plain values, no window.

use super::orbit::Orbit;
use super::pace::Pace;
use crate::catalog::NaifId;
use crate::time::Instant;
use glam::DVec3;

/// A body that can be looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    pub id: NaifId,
    pub name: String,
    /// Equatorial.
    pub radius_km: f64,
    /// North pole, ICRF unit vector.
    pub pole: DVec3,
}

/// What one frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    pub target: NaifId,
    pub name: String,
    /// Camera from the target's centre, ICRF kilometres.
    pub offset_km: DVec3,
    pub distance_radii: f64,
    pub time: Instant,
    /// Vertical field of view.
    pub fov_deg: f64,
    /// Pace of time, for the title.
    pub pace: String,
}

/// What a key, a button or the wheel asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    NextBody,
    PreviousBody,
    /// Drag by pixels, right and down.
    Turn(f64, f64),
    /// Wheel notches; positive nears.
    Zoom(f64),
    Faster,
    Slower,
    Forward,
    Backward,
    TogglePause,
    /// The clock's time, at its own pace.
    Now,
    Quit,
}

const FOV_DEG: f64 = 45.0;
/// A new body is shown from this many radii.
const ARRIVAL_RADII: f64 = 3.5;

/// The state behind the window.
pub struct Controls {
    subjects: Vec<Subject>,
    current: usize,
    orbit: Orbit,
    time: Instant,
    pace: Pace,
    clock: fn() -> Instant,
}

impl Controls {
    /// Starts at `target` (the first subject when it is not among them), the camera at `offset_km`. `subjects` must not be empty.
    pub fn new(subjects: Vec<Subject>, target: NaifId, offset_km: DVec3, time: Instant, clock: fn() -> Instant) -> Option<Self> {
        let current = subjects.iter().position(|s| s.id == target).unwrap_or(0);
        let subject = subjects.get(current)?;
        let orbit = Orbit::from_offset(offset_km, subject.radius_km, subject.pole);
        Some(Self { current, orbit, time, pace: Pace::default(), clock, subjects })
    }

    fn subject(&self) -> &Subject {
        &self.subjects[self.current]
    }

    /// Changes the state. `height_px` is the window's height.
    pub fn apply(&mut self, action: Action, height_px: f64) {
        let count = self.subjects.len();
        match action {
            Action::NextBody => self.go_to((self.current + 1) % count),
            Action::PreviousBody => self.go_to((self.current + count - 1) % count),
            Action::Turn(dx, dy) => self.orbit.drag(dx, dy, height_px, FOV_DEG.to_radians()),
            Action::Zoom(notches) => self.orbit.zoom(notches),
            Action::Faster => self.pace.faster(),
            Action::Slower => self.pace.slower(),
            Action::Forward => self.pace.forward(),
            Action::Backward => self.pace.backward(),
            Action::TogglePause => self.pace.toggle_pause(),
            Action::Now => {
                self.time = (self.clock)();
                self.pace.reset();
            }
            Action::Quit => {}
        }
    }

    /// The same side in inertial space is kept: the light falls on the new body about as it fell on the last.
    fn go_to(&mut self, index: usize) {
        let direction = self.orbit.offset_km(1.0, self.subject().pole);
        self.current = index;
        let subject = self.subject();
        let offset_km = direction.try_normalize().unwrap_or(DVec3::X) * (ARRIVAL_RADII * subject.radius_km);
        self.orbit = Orbit::from_offset(offset_km, subject.radius_km, subject.pole);
    }

    /// Lets `real_s` seconds pass.
    pub fn pass(&mut self, real_s: f64) {
        self.time = self.time.plus_seconds(self.pace.scene_seconds(real_s));
    }

    /// Seconds between frames that time alone asks for: none when paused, one in real time, else as fast as they come.
    pub fn frame_interval_s(&self) -> Option<f64> {
        match self.pace.rate().abs() {
            0.0 => None,
            r if r <= 1.0 => Some(1.0),
            _ => Some(1.0 / 60.0),
        }
    }

    /// Time runs so fast that every frame differs.
    pub fn time_races(&self) -> bool {
        self.pace.rate().abs() > 1.0
    }

    pub fn look(&self) -> Look {
        let subject = self.subject();
        Look {
            target: subject.id,
            name: subject.name.clone(),
            offset_km: self.orbit.offset_km(subject.radius_km, subject.pole),
            distance_radii: self.orbit.distance_radii,
            time: self.time,
            fov_deg: FOV_DEG,
            pace: self.pace.label(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controls() -> Controls {
        let subject = |id, name: &str, radius_km| Subject { id: NaifId(id), name: name.into(), radius_km, pole: DVec3::Z };
        let subjects = vec![subject(10, "Sun", 695_700.0), subject(399, "Earth", 6378.1), subject(301, "Moon", 1737.4)];
        let start = Instant::from_jd_tdb(2_451_545.0);
        Controls::new(subjects, NaifId::EARTH, DVec3::new(0.0, 20_000.0, 0.0), start, || Instant::from_jd_tdb(2_460_000.5))
            .expect("subjects")
    }

    #[test]
    fn bodies_go_round_both_ways_and_keep_the_side() {
        let mut c = controls();
        assert_eq!(c.look().name, "Earth");
        c.apply(Action::NextBody, 800.0);
        c.apply(Action::NextBody, 800.0);
        assert_eq!(c.look().name, "Sun");
        c.apply(Action::PreviousBody, 800.0);
        let look = c.look();
        assert_eq!(look.name, "Moon");
        assert!((look.offset_km - DVec3::new(0.0, ARRIVAL_RADII * 1737.4, 0.0)).length() < 1e-6);
    }

    #[test]
    fn time_passes_at_its_pace_and_now_is_the_clock() {
        let mut c = controls();
        c.apply(Action::Faster, 800.0);
        c.pass(0.1);
        assert!((c.look().time.tdb_seconds_past_j2000() - 1.0).abs() < 1e-9);
        assert!(c.time_races());
        c.apply(Action::Now, 800.0);
        assert_eq!(c.look().time.jd_tdb(), 2_460_000.5);
        assert_eq!(c.frame_interval_s(), Some(1.0));
        c.apply(Action::TogglePause, 800.0);
        assert_eq!(c.frame_interval_s(), None);
    }

    #[test]
    fn nothing_to_look_at_is_no_controls() {
        assert!(Controls::new(Vec::new(), NaifId::EARTH, DVec3::X, Instant::from_jd_tdb(0.0), || Instant::from_jd_tdb(0.0)).is_none());
    }
}
