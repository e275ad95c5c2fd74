//! Settings that the window keeps between runs: appearance, units, home, bookmarks, recent views, window placement.
//!
//! In: a file, if it exists. Out: [`Settings`], written back atomically. Always: a file with invalid content is reported, and its valid fields and bookmarks
//! are used. Such a file is renamed: `.broken` is appended to its name, or `.broken-2` and so on if that exists; the newest few are kept. Missing fields
//! have their defaults. Unknown fields, and bookmarks of another version of the program, are written back unchanged (`other_version`), and what another
//! running program has changed in the file stays (`merge`).

mod merge;
mod other_version;

use self::other_version::UnreadParts;
use crate::files::{FileAccess, WriteError, read_text, write_atomic, write_error};
use crate::session::DisplayPreference;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::telescope_setup::TelescopeSetup;
use crate::view::app::timeline::DEFAULT_SPAN_S;
use crate::view::app::view_state::{ViewState, wrapped_longitude_deg};
use crate::view::language::Language;
use crate::view::language::choice::deserialize_language;
use crate::view::window::placement::{MIN_SIZE_POINTS, WindowPlacement};
use serde::{Deserialize, Serialize};
use std::io::Error;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Range of the scale factor of text and controls.
pub(crate) const UI_SCALE_RANGE: RangeInclusive<f32> = 0.6..=3.0;
/// Largest settings file, bytes; enough for thousands of bookmarks.
const MAX_BYTES: u64 = 1 << 24;
/// Number of unusable settings files that are kept under other names (`.broken`).
const MAX_SET_ASIDE: usize = 5;
/// A file with this or a higher number in its name does not count as set aside, so that the next numbers are always far below the limit of u32.
const END_OF_SET_ASIDE_NUMBERS: u32 = 1 << 30;
/// Maximum number of recent views.
const MAX_RECENT: usize = 20;

/// The unit of lengths in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LengthUnit {
    #[default]
    Kilometres,
    AstronomicalUnits,
    Miles,
    BodyRadii,
}

/// The observer's place on the Earth: geodetic latitude, east longitude.
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

impl Home {
    /// The place with its longitude within ±180 degrees; the default place if the latitude is not within ±90 degrees.
    fn normalised_or_default(self) -> Self {
        let longitude_deg = wrapped_longitude_deg(self.longitude_deg);
        if (-90.0..=90.0).contains(&self.latitude_deg) { Self { longitude_deg, ..self } } else { Self::default() }
    }
}

/// The hints that the user has followed, which are no longer shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct HintsFollowed {
    pub drag: bool,
    pub scroll: bool,
    pub search: bool,
}

/// Layout of the panels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PanelLayout {
    /// Whether the list of bodies is shown.
    pub bodies_shown: bool,
    /// Name of the open panel; `None` if none is open.
    #[serde(rename = "open")]
    pub open_panel: Option<String>,
    /// Name of the kept panel, if any: a second panel, which the user keeps open on the other side of the viewport.
    #[serde(rename = "kept")]
    pub kept_panel: Option<String>,
    /// Whether the open panel is on the left, next to the list of bodies. The kept panel is on the other side.
    pub on_left: bool,
    /// Width of the list of bodies, points. This width and those below are `None` until such a panel is first shown, which stores its default width; after
    /// that only the user changes them.
    pub bodies_width: Option<f32>,
    /// Width of the open panel.
    pub panel_width: Option<f32>,
    /// Width of the open panel, if it is of the wide kind, which shows source text, images or tables and has a width of its own.
    pub wide_width: Option<f32>,
    /// Width of the kept panel.
    pub kept_width: Option<f32>,
    /// Width of the kept panel, if it is of the wide kind.
    pub kept_wide_width: Option<f32>,
    /// Whether the timeline is shown.
    pub timeline_shown: bool,
    /// Span of time that the timeline shows.
    pub timeline_span_s: f64,
    /// Whether *What to see now* is shown over the image. False once the user has closed it, opened or closed a
    /// panel, or triggered any `Action` except `TogglePause`.
    pub now_shown: bool,
    /// Size of the viewport in the last run, pixels: the first image is requested before the window has a size.
    pub viewport_px: [u32; 2],
}

/// Size of the viewport in a window of 1280x800 with the default panels.
const DEFAULT_VIEWPORT_PX: [u32; 2] = [1090, 712];

impl Default for PanelLayout {
    fn default() -> Self {
        Self {
            bodies_shown: true,
            open_panel: None,
            kept_panel: None,
            on_left: false,
            bodies_width: None,
            panel_width: None,
            wide_width: None,
            kept_width: None,
            kept_wide_width: None,
            timeline_shown: true,
            timeline_span_s: DEFAULT_SPAN_S,
            now_shown: true,
            viewport_px: DEFAULT_VIEWPORT_PX,
        }
    }
}

/// A width from a settings file, points, or the default if the width is missing or outside 100 to 4000 points.
pub fn valid_width(saved: Option<f32>, default: f32) -> f32 {
    saved.filter(|width| (100.0..=4000.0).contains(width)).unwrap_or(default)
}

/// A view with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    pub name: String,
    // Earlier versions wrote the view as `sight`.
    #[serde(alias = "sight")]
    pub view: ViewState,
}

/// The scale factor to use in a window of this width and height (points at scale 1). It is `ui_scale` of the settings, except that a scale above 1 that would
/// leave no room for the panels is reduced, because the control that changes the scale is in a panel. It is not reduced below 1.
pub(crate) fn scale_within(ui_scale: f32, [width, height]: [f32; 2]) -> f32 {
    let [min_width, min_height] = MIN_SIZE_POINTS.map(|side| side as f32);
    ui_scale.min((width / min_width).min(height / min_height).max(1.0))
}

/// The settings of the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Whether the interface is dark; `None` follows the system.
    pub dark: Option<bool>,
    /// Whether everything in the window is red on black, for eyes that are adapted to the dark.
    #[serde(rename = "red")]
    pub is_red: bool,
    /// Scale of text and controls.
    #[serde(rename = "zoom")]
    pub ui_scale: f32,
    /// `None`: the language of the system.
    #[serde(deserialize_with = "deserialize_language")]
    pub language: Option<Language>,
    /// Whether bodies are labelled with their names.
    #[serde(rename = "names")]
    pub labels_bodies: bool,
    /// Whether bodies that are too small to see are marked.
    #[serde(rename = "markers")]
    pub marks_small_bodies: bool,
    /// Whether the selected body is outlined, unless it is the target.
    #[serde(rename = "outline")]
    pub outlines_selected: bool,
    /// Whether the GPU or the CPU presents the window, if a GPU draws the image.
    #[serde(rename = "shown_by")]
    pub presenter_preference: DisplayPreference,
    pub unit: LengthUnit,
    pub home: Home,
    /// The time zone of displayed times.
    #[serde(rename = "clock")]
    pub time_zone: ShownTimeZone,
    pub telescope: TelescopeSetup,
    #[serde(rename = "hints")]
    pub hints_followed: HintsFollowed,
    pub panels: PanelLayout,
    /// `None`: the window was never closed.
    #[serde(rename = "place")]
    pub window_placement: Option<WindowPlacement>,
    /// The user's bookmarks. `other_version::Saved` writes them, with those of other versions of the program.
    #[serde(skip_serializing)]
    pub bookmarks: Vec<Bookmark>,
    /// The last views that the user left, newest first. `other_version::Saved` writes them, too.
    #[serde(skip_serializing)]
    pub recent: Vec<Bookmark>,
    /// The parts of the file that this version of the program cannot read.
    #[serde(skip)]
    pub unread: UnreadParts,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dark: Some(true),
            is_red: false,
            ui_scale: 1.0,
            language: None,
            labels_bodies: true,
            marks_small_bodies: true,
            outlines_selected: true,
            presenter_preference: DisplayPreference::default(),
            unit: LengthUnit::default(),
            home: Home::default(),
            time_zone: ShownTimeZone::default(),
            telescope: TelescopeSetup::default(),
            hints_followed: HintsFollowed::default(),
            panels: PanelLayout::default(),
            window_placement: None,
            bookmarks: Vec::new(),
            recent: Vec::new(),
            unread: UnreadParts::default(),
        }
    }
}

impl Settings {
    /// Adds a view to the recent views as the newest; an entry with the same view is replaced.
    pub(crate) fn add_recent(&mut self, name: String, view: ViewState) {
        self.recent.retain(|r| r.view != view);
        self.recent.insert(0, Bookmark { name, view });
        self.recent.truncate(MAX_RECENT);
    }

    /// Reads settings from a file; a missing file gives the default settings. If the file or a part of it cannot be used, returns the remaining
    /// settings and an error for the user, and appends `.broken` to the file's name, so that saving does not overwrite the file. The newest [`MAX_SET_ASIDE`]
    /// such files are kept: they may hold the user's bookmarks. Without an error, the returned text is the notice of [`Settings::unread`], if there is one.
    pub(crate) fn load(path: &Path) -> (Self, Option<String>) {
        let text = match read_text(path, MAX_BYTES) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return (Self::default(), None),
            Err(e) if path.is_file() => return (Self::default(), Some(format!("{}: {e}; {}", path.display(), set_aside_message(path)))),
            Err(e) => return (Self::default(), Some(format!("{}: {e}; starting with the default settings", path.display()))),
        };
        let (read, invalid_fields) = match other_version::read(&text) {
            Ok(read) => read,
            Err(e) => return (Self::default(), Some(format!("{}: {e}; {}", path.display(), set_aside_message(path)))),
        };
        // egui would panic at a scale of 0.
        let ui_scale = read.ui_scale.clamp(*UI_SCALE_RANGE.start(), *UI_SCALE_RANGE.end());
        let settings = Self { ui_scale, home: read.home.normalised_or_default(), ..read };
        if let Some(invalid_fields) = invalid_fields {
            let no_base = None;
            let outcome = match set_aside(path) {
                // The valid part is written now: until the user changes a setting, the settings writer writes nothing, and there would be no file.
                Ok(kept_as) => match settings.save_merged_with(path, no_base, Some(&text)) {
                    Ok(()) => kept_as,
                    Err(e) => format!("{kept_as}; {e}"),
                },
                Err(reason) => reason,
            };
            return (settings, Some(format!("{}: {invalid_fields}; {outcome}", path.display())));
        }
        let notice = settings.unread.notice().map(|notice| format!("{}: {notice}", path.display()));
        (settings, notice)
    }

    /// Writes the file atomically. `base`: the settings that this program read or wrote last; settings that are the same as in `base` are taken from the
    /// file. Without `base`, only unknown fields are taken from the file.
    ///
    /// # Errors
    /// If the folder or the file cannot be written; the error names the path and the reason.
    pub(crate) fn save(&self, path: &Path, base: Option<&Self>) -> Result<(), WriteError> {
        self.save_merged_with(path, base, read_text(path, MAX_BYTES).ok().as_deref())
    }

    /// As [`Settings::save`], but merges with the text `stored` instead of the text of the file.
    fn save_merged_with(&self, path: &Path, base: Option<&Self>, stored: Option<&str>) -> Result<(), WriteError> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|e| write_error(path, &e))?;
        write_atomic(path, FileAccess::Owner, |out| {
            let content = self.merged_with(base, stored).map_err(Error::other)?;
            serde_json::to_writer_pretty(out, &content).map_err(Error::other)
        })
    }

    /// The path of the settings file in the user's configuration folder.
    pub(crate) fn default_path() -> Option<PathBuf> {
        directories::BaseDirs::new().map(|dirs| dirs.config_dir().join("orrery").join("settings.json"))
    }
}

/// Sets a file aside. Returns a text for the user: where the file is now, or why it could not be renamed.
fn set_aside_message(path: &Path) -> String {
    set_aside(path).unwrap_or_else(|reason| reason)
}

/// Sets a file that cannot be used as settings aside: appends `.broken` to its name, or `.broken-2` and so on. Returns a text for the user: where the file is
/// now, or, as the error, why it could not be renamed.
fn set_aside(path: &Path) -> Result<String, String> {
    let earlier_numbers = set_aside_numbers(path);
    // The new number is above all earlier ones, even if a lower one is free, so that the newest file has the highest number.
    let mut number = earlier_numbers.last().map_or(1, |last| last + 1);
    // The name may be taken all the same, for example if the folder cannot be listed.
    while set_aside_path(path, number).symlink_metadata().is_ok() {
        number += 1;
    }
    let aside_path = set_aside_path(path, number);
    std::fs::rename(path, &aside_path).map_err(|e| format!("it could not be set aside: {e}"))?;
    // The oldest files are removed, so that with the new one at most `MAX_SET_ASIDE` are left.
    let removed_count = (earlier_numbers.len() + 1).saturating_sub(MAX_SET_ASIDE);
    for number in earlier_numbers.into_iter().take(removed_count) {
        // A file that cannot be removed is tried again when the next one is set aside.
        let _ = std::fs::remove_file(set_aside_path(path, number));
    }
    Ok(format!("kept as {}", aside_path.display()))
}

/// The path of the file that was set aside with a number.
fn set_aside_path(path: &Path, number: u32) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(if number == 1 { ".broken".to_owned() } else { format!(".broken-{number}") });
    PathBuf::from(name)
}

/// The numbers of the files that were set aside, ascending; empty if the folder cannot be listed. Symbolic links count, even if their target is missing.
fn set_aside_numbers(path: &Path) -> Vec<u32> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Some(settings_name) = path.file_name().and_then(|n| n.to_str()) else { return Vec::new() };
    let number = |name: &str| match name.strip_prefix(settings_name)?.strip_prefix(".broken")? {
        "" => Some(1),
        // Only names that the program writes: `settings.json.broken-02` is a file of the user.
        rest => {
            let number = rest.strip_prefix('-')?.parse::<u32>().ok()?;
            ((2..END_OF_SET_ASIDE_NUMBERS).contains(&number) && rest == format!("-{number}")).then_some(number)
        }
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut numbers: Vec<u32> = entries.filter_map(|entry| number(entry.file_name().to_str()?)).collect();
    numbers.sort_unstable();
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::time::Instant;
    use glam::DVec3;

    fn view(id: i32) -> ViewState {
        let (offset_km, radius_km) = (DVec3::new(1e5, 0.0, 0.3), 1e4);
        ViewState::around(NaifId(id), offset_km, radius_km, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.1))
    }

    #[test]
    fn the_scale_leaves_room_for_the_panels() {
        let (usual, large, tiny) = ([1264.0, 736.0], [3840.0, 2160.0], [400.0, 300.0]);
        // The panels need a width of 600 points: 2.1067 is 1264 / 600.
        for (ui_scale, size, expected) in [(3.0, usual, 2.1067), (2.0, usual, 2.0), (3.0, large, 3.0), (2.0, tiny, 1.0), (0.6, tiny, 0.6)] {
            let scale = scale_within(ui_scale, size);
            assert!((scale - expected).abs() < 1e-3, "{ui_scale} in {size:?}: {scale}");
        }
    }

    #[test]
    fn saved_settings_are_loaded_unchanged() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deep").join("settings.json");
        let mut settings = Settings { ui_scale: 1.25, dark: None, ..Settings::default() };
        settings.bookmarks.push(Bookmark { name: "Saturn's \"ears\"".into(), view: view(699) });
        for i in 0..40 {
            settings.add_recent(format!("view {i}"), view(i));
        }
        settings.add_recent("again".into(), view(39));
        assert_eq!((settings.recent.len(), settings.recent[0].name.as_str()), (MAX_RECENT, "again"));
        let no_base = None;
        settings.save(&path, no_base).expect("a file");
        assert_eq!(Settings::load(&path), (settings.clone(), None));
        // Earlier versions wrote views under another field name.
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.contains("\"view\":"));
        std::fs::write(&path, text.replace("\"view\":", "\"sight\":")).expect("a file");
        assert_eq!(Settings::load(&path), (settings, None));
    }

    #[test]
    fn an_unknown_language_does_not_affect_the_other_settings() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("a file");
            Settings::load(&path)
        };
        let others = Settings { labels_bodies: false, ui_scale: 1.5, ..Settings::default() };
        for unknown in ["\"tlh\"", "\"\"", "null", "7", "[\"de\"]", "{\"code\": \"de\"}"] {
            let text = format!("{{\"language\": {unknown}, \"names\": false, \"zoom\": 1.5}}");
            assert_eq!(read(&text), (others.clone(), None), "{unknown}");
        }
        let german = Settings { language: Some(Language::German), ..others };
        assert_eq!(read("{\"language\": \"de\", \"names\": false, \"zoom\": 1.5}"), (german.clone(), None));
        let no_base = None;
        german.save(&path, no_base).expect("a file");
        assert_eq!(Settings::load(&path), (german, None));
        // A file that is not JSON is set aside.
        assert!(read("{\"language\": de}").1.is_some());
    }

    #[test]
    fn a_scale_outside_its_range_is_limited() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        for (saved, ui_scale) in
            [("0", 0.6), ("-1", 0.6), ("1e-6", 0.6), ("0.6", 0.6), ("1.5", 1.5), ("3", 3.0), ("1000", 3.0), ("1e30", 3.0)]
        {
            std::fs::write(&path, format!("{{\"zoom\": {saved}}}")).expect("a file");
            assert_eq!(Settings::load(&path), (Settings { ui_scale, ..Settings::default() }, None), "{saved}");
        }
    }

    #[test]
    fn an_impossible_home_is_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let greenwich = Home::default();
        for (saved, home) in [
            ([52.5, 13.4], Home { latitude_deg: 52.5, longitude_deg: 13.4 }),
            ([-90.0, 180.0], Home { latitude_deg: -90.0, longitude_deg: 180.0 }),
            ([10.0, 200.0], Home { latitude_deg: 10.0, longitude_deg: -160.0 }),
            ([500.0, 13.4], greenwich),
            ([-90.5, 0.0], greenwich),
        ] {
            let [latitude_deg, longitude_deg] = saved;
            std::fs::write(&path, format!("{{\"home\": {{\"latitude_deg\": {latitude_deg}, \"longitude_deg\": {longitude_deg}}}}}"))
                .expect("a file");
            assert_eq!(Settings::load(&path), (Settings { home, ..Settings::default() }, None), "{saved:?}");
        }
    }

    #[test]
    fn a_broken_settings_file_is_kept_aside_and_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        std::fs::write(&path, "{\"zoom\": \"large\"}").expect("a file");
        let (settings, error) = Settings::load(&path);
        assert_eq!(settings, Settings::default());
        assert!(error.expect("a line").contains("settings.json.broken"));
        assert_eq!(std::fs::read_to_string(folder.path().join("settings.json.broken")).expect("kept"), "{\"zoom\": \"large\"}");
        // A file that cannot be read is set aside, too, under a name of its own, so that it does not replace the first.
        let too_large = vec![b' '; MAX_BYTES as usize + 1];
        std::fs::write(&path, &too_large).expect("a file");
        let (settings, error) = Settings::load(&path);
        assert!(settings == Settings::default() && error.expect("a line").ends_with("settings.json.broken-2"));
        assert_eq!(std::fs::read(folder.path().join("settings.json.broken-2")).expect("kept"), too_large);
        assert_eq!(std::fs::read_to_string(folder.path().join("settings.json.broken")).expect("kept"), "{\"zoom\": \"large\"}");
        std::fs::write(&path, "[").expect("a file");
        assert!(Settings::load(&path).1.expect("a line").ends_with("settings.json.broken-3"));
        // A file of an earlier version with fewer fields is valid.
        std::fs::write(&path, "{\"names\": false}").expect("a file");
        assert_eq!(Settings::load(&path), (Settings { labels_bodies: false, ..Settings::default() }, None));
    }

    #[test]
    fn only_the_newest_broken_settings_files_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        // A file of the user, whose name the program would not write.
        std::fs::write(folder.path().join("settings.json.broken-01"), "mine").expect("a file");
        for number in 1..=12 {
            std::fs::write(&path, format!("[{number}")).expect("a file");
            let line = Settings::load(&path).1.expect("a line");
            let suffix = if number == 1 { ".broken".to_owned() } else { format!(".broken-{number}") };
            assert!(line.ends_with(&format!("settings.json{suffix}")), "{line}");
        }
        assert_eq!(set_aside_numbers(&path), [8, 9, 10, 11, 12]);
        assert_eq!(std::fs::read_to_string(set_aside_path(&path, 12)).expect("kept"), "[12");
        assert!(folder.path().join("settings.json.broken-01").exists());
        // A number that the user removed is not given again, because the highest number must be the newest file.
        std::fs::remove_file(set_aside_path(&path, 9)).expect("removed");
        std::fs::write(&path, "[13").expect("a file");
        assert!(Settings::load(&path).1.expect("a line").ends_with(".broken-13"));
        assert_eq!(set_aside_numbers(&path), [8, 10, 11, 12, 13]);
    }
}
