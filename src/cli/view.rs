//! `orrery view`, the default command: opens the window.
//!
//! In: the first view (a link, a file or options), a tour or data to open in it, settings and language. Out: the window, until the user closes it. Not here:
//! the window itself (`crate::view`).

use super::composition_args::CompositionArgs;
use super::view_args::parse_time_option;
use super::{CliError, Common};

const AFTER_HELP: &str = "`view` is the default command: `orrery --target saturn` is `orrery view --target saturn`.
With --shaders DIR, shader sources are reloaded when a file changes. Press `?` in the window for keyboard and mouse help.

Fields that a link or a file omits have the defaults of a new window: the Earth, now, the lit side from 3.5 radii.
`target` and `eye.body` are names or NAIF codes, `time` is ISO 8601 UTC, `paused` is true or false. If a link cannot
be read, the window opens with the default view and lists all errors. A file of points, lines or images (CSV, VOTable,
GeoJSON, KML, FITS) becomes a layer: on the target if its places are a body's, else in the sky.

Examples:
  orrery
  orrery view --target saturn --time 2017-05-17T00:00:00Z
  orrery view eclipse.json
  orrery view --target mars craters.csv
  orrery view 'orrery://view?target=jupiter&time=2015-01-24T06:45:00Z'
  orrery view --projection fisheye --dome-tilt 20 --warp projector.txt";

#[derive(clap::Args, Debug)]
#[command(after_help = AFTER_HELP, next_help_heading = "First view")]
pub(crate) struct ViewArgs {
    /// First body to look at
    #[arg(long, value_name = "BODY", default_value = "earth")]
    target: String,
    /// What to open: an orrery:// link, or a file with a view, a tour or data, as if it were dropped on the window
    #[arg(value_name = "LINK|FILE")]
    link: Option<String>,
    /// Settings file [default: settings.json in the user's configuration folder]
    #[arg(long, value_name = "FILE")]
    settings: Option<std::path::PathBuf>,
    /// Language of the window: en or de [default: of the settings, else of the environment (LC_ALL, LC_MESSAGES, LANG)]
    #[arg(long, value_name = "CODE")]
    language: Option<String>,
    /// Time: ISO 8601 UTC, jd_tdb:DAY, or now
    #[arg(long, value_name = "T", default_value = "now", allow_hyphen_values = true)]
    time: String,
    #[command(flatten)]
    composition: CompositionArgs,
}

impl Default for ViewArgs {
    fn default() -> Self {
        Self {
            target: "earth".into(),
            link: None,
            settings: None,
            language: None,
            time: "now".into(),
            composition: CompositionArgs::default(),
        }
    }
}

#[cfg(not(feature = "view"))]
pub(crate) fn run(_common: &Common, args: &ViewArgs) -> Result<(), CliError> {
    let time_text = parse_time_option(&args.time)?.to_utc_iso();
    let name = crate::wording::echo(&args.target);
    let (target, file) = (shell_word(&name), shell_word(&format!("{name}.png")));
    Err(CliError::Failed(format!(
        "this build has no window; to draw to a file: orrery render --target {target} --time {time_text} -o {file}"
    )))
}

/// A word of a command that a user may copy into a shell. It is quoted if a shell could interpret any of its characters.
#[cfg(any(test, not(feature = "view")))]
fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '/');
    if !word.is_empty() && word.chars().all(is_plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(feature = "view")]
pub(crate) fn run(common: &Common, args: &ViewArgs) -> Result<(), CliError> {
    windowed::run(common, args)
}

#[cfg(feature = "view")]
mod windowed {
    use super::{CliError, Common, ViewArgs, parse_time_option};
    use crate::catalog::NaifId;
    use crate::cli::output::print_message;
    use crate::ephemeris::body_order::bodies_in_usual_order;
    use crate::session::{RendererPreference, Session, SessionError, Sources};
    use crate::time::Instant;
    use crate::view::app::body_positions::SessionPositions;
    use crate::view::app::initial_view::initial_view;
    use crate::view::app::settings::Settings;
    use crate::view::app::view_state::ViewState;
    use crate::view::app::viewer::{SelectableBody, Viewer};
    use crate::view::error_texts::UnreadFile;
    use crate::view::language::{Language, set as set_language};
    use crate::view::link::{is_link, view_from_text};
    use crate::view::opened_file::{OpenedFile, path_of, read};
    use crate::view::panels::Interface;
    use crate::view::window;
    use crate::view::window::shader_watcher::ShaderWatcher;
    use crate::view::worker::freed_memory::return_large_blocks;
    use crate::wording::echo;
    use parking_lot::Mutex;
    use std::sync::Arc;
    use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
    use std::time::Duration;

    pub(crate) fn run(common: &Common, args: &ViewArgs) -> Result<(), CliError> {
        let language =
            args.language.as_deref().map(Language::by_code).transpose().map_err(|e| CliError::Usage(format!("--language {e}")))?;
        let mut composition = args.composition.composition()?;
        // A view state stores no warp mesh: the window warps every view.
        let warp = composition.warp.take();
        // This changes a setting of the allocator, which must be done before the session reads maps.
        return_large_blocks();
        let messages: Arc<Mutex<Vec<String>>> = Arc::default();
        let session = open_session(common.sources_for_drawing(), &messages)?;
        let watcher = common
            .shaders
            .as_ref()
            .map(|folder| ShaderWatcher::open(folder, &session))
            .transpose()
            .map_err(|e| CliError::Failed(e.to_string()))?;
        let view_of_options = ViewState { quality: common.quality, ..view_of_options(&session, args)? };
        let settings_path = args.settings.clone().or_else(Settings::default_path);
        let (settings, load_message) = settings_path.as_deref().map_or((Settings::default(), None), Settings::load);
        load_message.iter().for_each(|line: &String| print_message(line));
        messages.lock().extend(load_message);
        let language = language.or(settings.language).unwrap_or_else(|| Language::of_environment(|name| std::env::var(name).ok()));
        // The warning below is a text of the window.
        set_language(language);
        let opened = args.link.as_ref().map(|link| opened(link, &session, view_of_options.target)).transpose();
        // The window shows the warning, too, because a user who clicked on a link does not see standard error.
        let warning = opened.as_ref().err().map(|UnreadFile { in_english, in_window }| {
            print_message(in_english);
            in_window.clone()
        });
        let (mut view, tour_or_layer) = match opened.ok().flatten() {
            Some(OpenedFile::View(view)) => (*view, None),
            tour_or_layer => (view_of_options, tour_or_layer),
        };
        // The projection and stereo options of the command line take precedence over those of a link.
        view.composition = view.composition.with_options(&composition);
        let viewer = Viewer::new(selectable_bodies(&session), view, now);
        // The settings that this window read or wrote last. Another window may have changed the file since then.
        let last_saved = Mutex::new(settings.clone());
        let mut interface = Interface::new(viewer, settings);
        interface.language = language;
        interface.session_messages = messages;
        interface.warning = warning;
        if let Some(file) = tour_or_layer {
            interface.open_file(file);
        }
        interface.warp = warp;
        interface.file_dialog = Some(window::file_dialog::open);
        let save_settings = |settings: &Settings| {
            let Some(path) = &settings_path else { return Ok(()) };
            let mut base = last_saved.lock();
            let saved = settings.save(path, Some(&base));
            if saved.is_ok() {
                base.clone_from(settings);
            }
            saved
        };
        // When the window has closed, dropping the sender ends the thread that simulates device losses.
        let (keep_running, window_closed) = channel();
        std::thread::scope(|scope| {
            if let Some(period) = device_loss_period() {
                let session = &session;
                scope.spawn(move || simulate_device_losses(session, period, &window_closed));
            }
            let result =
                window::run(&mut interface, &session, watcher.as_ref(), save_settings).map_err(|e| CliError::Failed(e.to_string()));
            drop(keep_running);
            result
        })
    }

    /// Fault injection for `.ci/soak`: the time from one simulated device loss to the next. The environment variable `ORRERY_LOSE_DEVICE_S` gives it in
    /// seconds; `None` without it.
    fn device_loss_period() -> Option<Duration> {
        let seconds: f64 = std::env::var("ORRERY_LOSE_DEVICE_S").ok()?.parse().ok()?;
        Duration::try_from_secs_f64(seconds).ok().filter(|period| !period.is_zero())
    }

    /// Destroys the GPU device once per period, as a driver reset would. Half a period later, switches to the software renderer and back, as a user would; this
    /// opens a new device. Returns when the sender of `window_closed` is dropped.
    fn simulate_device_losses(session: &Session, period: Duration, window_closed: &Receiver<()>) {
        let wait_half_period = || window_closed.recv_timeout(period / 2) == Err(RecvTimeoutError::Timeout);
        let (_, preference) = session.renderers();
        while wait_half_period() {
            #[cfg(feature = "gpu")]
            session.destroy_gpu();
            if !wait_half_period() {
                return;
            }
            session.set_renderer_preference(RendererPreference::Software);
            session.set_renderer_preference(preference);
        }
    }

    /// Opens the session. A catalog, star file or table of small bodies with an error is left out, with a message: the window opens nevertheless.
    fn open_session(mut sources: Sources, messages: &Arc<Mutex<Vec<String>>>) -> Result<Session, SessionError> {
        loop {
            let session_messages = Arc::clone(messages);
            let opened = Session::open(&sources, move |line| {
                print_message(line);
                session_messages.lock().push(line.to_owned());
            });
            let error = match opened {
                Ok(session) => return Ok(session),
                Err(error) => error,
            };
            let Some((option, usable)) = sources.without_invalid_data(&error) else { return Err(error) };
            sources = usable;
            // A catalog may have several invalid fields, with a line for each.
            for line in format!("{error}\nthe window opens without {option}").lines() {
                print_message(line);
                messages.lock().push(line.to_owned());
            }
        }
    }

    /// What a link or a file contains. `target`: the body that gets data with places on a body.
    fn opened(link: &str, session: &Session, target: NaifId) -> Result<OpenedFile, UnreadFile> {
        if is_link(link) {
            let view = view_from_text(link, session, now());
            return view.map(|view| OpenedFile::View(Box::new(view))).map_err(|e| UnreadFile::of_text(&echo(link), &e));
        }
        read(session, &path_of(link), Some(target), now())
    }

    /// The view of a new window at `--target` and `--time`.
    fn view_of_options(session: &Session, args: &ViewArgs) -> Result<ViewState, CliError> {
        let catalog = session.catalog();
        let target = catalog.body_named(&args.target).map_err(|e| CliError::Usage(format!("--target: {e}")))?.id;
        let view = initial_view(catalog, &SessionPositions(session), target, parse_time_option(&args.time)?);
        view.map_err(|e| CliError::Failed(format!("--target {}: {e}", echo(&args.target))))
    }

    /// The current time; J2000 if the system clock is outside the supported calendar.
    fn now() -> Instant {
        parse_time_option("now").unwrap_or(Instant::from_tdb_seconds_past_j2000(0.0))
    }

    /// The bodies that the window lists: all of the catalog, in the order of `ephemeris::body_order`.
    fn selectable_bodies(session: &Session) -> Vec<SelectableBody> {
        bodies_in_usual_order(session.catalog(), session.ephemeris())
            .into_iter()
            .filter_map(|id| session.catalog().body(id))
            .map(SelectableBody::of)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_with_blanks_or_quotes_are_quoted() {
        for (word, quoted) in [
            ("earth", "earth"),
            ("599", "599"),
            ("Barnard's star", r"'Barnard'\''s star'"),
            ("earth moon.png", "'earth moon.png'"),
            ("$(x)", "'$(x)'"),
            ("", "''"),
        ] {
            assert_eq!(shell_word(word), quoted, "{word}");
        }
    }
}
