//! What the window remembers from one run to the next: looks, units, home, bookmarks, recent views, its place on the desktop.
//!
//! In: a file, if it is there. Out: [`Settings`], and back to the file whole. Always: a file that cannot be read is kept aside and said, never
//! overwritten; fields that a file lacks keep their defaults.

use crate::files::{FileAccess, WriteError, failure, read_text, write_whole};
use crate::session::DisplayPreference;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::civil_time::Clock;
use crate::view::app::view_state::ViewState;
use crate::view::window::placement::WindowPlacement;
use serde::{Deserialize, Serialize};
use std::io::Error;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Sizes of text and controls.
pub const ZOOMS: RangeInclusive<f32> = 0.6..=3.0;
/// Bytes of a settings file at the most: thousands of bookmarks.
const MAX_BYTES: u64 = 1 << 24;
/// Views that are remembered without being kept.
const RECENT: usize = 20;

/// The unit of lengths in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    #[default]
    Kilometres,
    AstronomicalUnits,
    Miles,
    BodyRadii,
}

/// The observer's place on the Earth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Home {
    pub latitude_deg: f64,
    pub longitude_deg: f64,
}

impl Default for Home {
    fn default() -> Self {
        // The Royal Observatory in Greenwich.
        Self { latitude_deg: 51.4769, longitude_deg: 0.0 }
    }
}

/// What a new user has found: hints for it are shown no more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct HintsUsed {
    pub drag: bool,
    pub scroll: bool,
    pub search: bool,
}

/// How the panels were left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PanelLayout {
    pub bodies_shown: bool,
    /// Title of the panel that is open.
    pub open: Option<String>,
    /// Panels are at the left of the sky, beside the bodies.
    pub on_left: bool,
    /// Points; `None`: never changed.
    pub bodies_width: Option<f32>,
    pub panel_width: Option<f32>,
    /// Of panels with source or two pictures.
    pub wide_width: Option<f32>,
    pub timeline_shown: bool,
    /// Seconds from end to end of the timeline.
    pub timeline_span_s: f64,
    /// *What to see now* is over the sky.
    pub now_shown: bool,
}

impl Default for PanelLayout {
    fn default() -> Self {
        Self {
            bodies_shown: true,
            open: None,
            on_left: false,
            bodies_width: None,
            panel_width: None,
            wide_width: None,
            timeline_shown: true,
            timeline_span_s: 2.0 * 365.25 * SECONDS_PER_DAY,
            now_shown: true,
        }
    }
}

/// A width that a file may tell, as far as a panel can have it.
pub fn usable_width(told: Option<f32>, usual: f32) -> f32 {
    told.filter(|width| (100.0..=4000.0).contains(width)).unwrap_or(usual)
}

/// A view with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    pub name: String,
    #[serde(alias = "sight")]
    pub view: ViewState,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Dark panels; `None` follows the system.
    pub dark: Option<bool>,
    /// Size of text and controls.
    pub zoom: f32,
    pub names: bool,
    pub markers: bool,
    /// A line of light around the selected body, where it is not what the view is of.
    pub outline: bool,
    /// What shows the window where a device draws.
    pub shown_by: DisplayPreference,
    pub unit: Unit,
    pub home: Home,
    pub clock: Clock,
    pub hints: HintsUsed,
    pub panels: PanelLayout,
    /// `None`: it was never closed.
    pub place: Option<WindowPlacement>,
    pub bookmarks: Vec<Bookmark>,
    /// Newest first.
    pub recent: Vec<Bookmark>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dark: Some(true),
            zoom: 1.0,
            names: true,
            markers: true,
            outline: true,
            shown_by: DisplayPreference::default(),
            unit: Unit::default(),
            home: Home::default(),
            clock: Clock::default(),
            hints: HintsUsed::default(),
            panels: PanelLayout::default(),
            place: None,
            bookmarks: Vec::new(),
            recent: Vec::new(),
        }
    }
}

impl Settings {
    /// Puts a view at the head of the recent ones.
    pub fn remember(&mut self, name: String, view: ViewState) {
        self.recent.retain(|r| r.view != view);
        self.recent.insert(0, Bookmark { name, view });
        self.recent.truncate(RECENT);
    }

    /// The settings of a file, and one line where it could not be read: it then stands beside its place with `.broken` after its name.
    pub fn load(path: &Path) -> (Self, Option<String>) {
        let text = match read_text(path, MAX_BYTES) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return (Self::default(), None),
            Err(e) => return (Self::default(), Some(format!("{}: {e}; starting with the default settings", path.display()))),
        };
        match serde_json::from_str(&text) {
            Ok(settings) => (settings, None),
            Err(e) => {
                let aside = PathBuf::from(format!("{}.broken", path.display()));
                let kept = match std::fs::rename(path, &aside) {
                    Ok(()) => format!("kept as {}", aside.display()),
                    Err(e) => format!("it could not be set aside: {e}"),
                };
                (Self::default(), Some(format!("{}: {e}; {kept}", path.display())))
            }
        }
    }

    /// Written beside its place and moved there whole.
    ///
    /// # Errors
    /// The path and why.
    pub fn save(&self, path: &Path) -> Result<(), WriteError> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|e| failure(path, &e))?;
        write_whole(path, FileAccess::Owner, |out| serde_json::to_writer_pretty(out, self).map_err(Error::other))
    }

    /// Where the system keeps a user's settings.
    pub fn usual_path() -> Option<PathBuf> {
        directories::BaseDirs::new().map(|dirs| dirs.config_dir().join("orrery").join("settings.json"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::time::Instant;
    use glam::DVec3;

    fn view(id: i32) -> ViewState {
        ViewState::around(NaifId(id), DVec3::new(1e5, 0.0, 0.3), 1e4, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.1))
    }

    #[test]
    fn settings_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deep").join("settings.json");
        let mut settings = Settings { zoom: 1.25, dark: None, ..Settings::default() };
        settings.bookmarks.push(Bookmark { name: "Saturn's \"ears\"".into(), view: view(699) });
        for i in 0..40 {
            settings.remember(format!("view {i}"), view(i));
        }
        settings.remember("again".into(), view(39));
        assert_eq!((settings.recent.len(), settings.recent[0].name.as_str()), (RECENT, "again"));
        settings.save(&path).expect("a file");
        assert_eq!(Settings::load(&path), (settings.clone(), None));
        // As programs of earlier versions wrote the views.
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.contains("\"view\":"));
        std::fs::write(&path, text.replace("\"view\":", "\"sight\":")).expect("a file");
        assert_eq!(Settings::load(&path), (settings, None));
    }

    #[test]
    fn a_broken_file_is_kept_aside_and_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        std::fs::write(&path, "{\"zoom\": \"large\"}").expect("a file");
        let (settings, said) = Settings::load(&path);
        assert_eq!(settings, Settings::default());
        assert!(said.expect("a line").contains("settings.json.broken"));
        assert_eq!(std::fs::read_to_string(folder.path().join("settings.json.broken")).expect("kept"), "{\"zoom\": \"large\"}");
        // An old file with fewer fields is fine.
        std::fs::write(&path, "{\"names\": false}").expect("a file");
        assert_eq!(Settings::load(&path), (Settings { names: false, ..Settings::default() }, None));
    }
}
