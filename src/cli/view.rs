//! `orrery view`: the window, and the default verb.

use super::view_words::instant;
use super::{CliError, Common};

const KEYS: &str = "The window explains its keys and mouse under `?`.

Examples:
  orrery
  orrery view --target saturn --time 2017-05-17T00:00:00Z
  orrery view eclipse.json";

#[derive(clap::Args, Debug)]
#[command(after_help = KEYS)]
pub struct ViewArgs {
    /// Body to start at
    #[arg(long, value_name = "BODY", default_value = "earth")]
    target: String,
    /// A view that was kept: orrery://… or a file
    #[arg(value_name = "LINK")]
    link: Option<String>,
    /// What the window remembers [default: settings.json in the user's configuration folder]
    #[arg(long, value_name = "FILE")]
    settings: Option<std::path::PathBuf>,
    /// Shader fragments laid over the built-in ones, by their paths inside shaders/; read again when a file changes
    #[arg(long, value_name = "DIR")]
    shaders: Option<std::path::PathBuf>,
    /// ISO 8601 UTC, jd_tdb:DAY, or now
    #[arg(long, value_name = "T", default_value = "now", allow_hyphen_values = true)]
    time: String,
}

impl Default for ViewArgs {
    fn default() -> Self {
        Self { target: "earth".into(), link: None, settings: None, shaders: None, time: "now".into() }
    }
}

#[cfg(not(feature = "view"))]
pub fn run(_common: &Common, args: &ViewArgs) -> Result<(), CliError> {
    let at = instant(&args.time)?.to_utc_iso();
    Err(CliError(format!("this build has no window; to draw to a file: orrery render --target {} --time {at} -o {0}.png", args.target)))
}

#[cfg(feature = "view")]
pub fn run(common: &Common, args: &ViewArgs) -> Result<(), CliError> {
    windowed::run(common, args)
}

#[cfg(feature = "view")]
mod windowed {
    use super::{CliError, Common, ViewArgs, instant};
    use crate::catalog::NaifId;
    use crate::ephemeris::order::by_distance;
    use crate::session::Session;
    use crate::time::Instant;
    use crate::view::interface::Interface;
    use crate::view::settings::Settings;
    use crate::view::sight::{Sight, quality_name};
    use crate::view::viewer::{Subject, Viewer};
    use crate::view::watch::Watch;
    use crate::view::window;
    use glam::DVec3;
    use std::sync::{Arc, Mutex, PoisonError};

    /// The first picture is taken from this far, in equatorial radii.
    const START_RADII: f64 = 3.5;

    pub fn run(common: &Common, args: &ViewArgs) -> Result<(), CliError> {
        let heard: Arc<Mutex<Vec<String>>> = Arc::default();
        let hearing = Arc::clone(&heard);
        let session = Session::open(&common.sources_to_draw(), move |line| {
            eprintln!("orrery: {line}");
            hearing.lock().unwrap_or_else(PoisonError::into_inner).push(line.to_owned());
        })?;
        let watch = args.shaders.as_ref().map(|folder| Watch::open(folder, &session)).transpose().map_err(CliError)?;
        let sight = match &args.link {
            Some(link) => kept(link)?,
            None => Sight { quality: quality_name(common.quality.of_request()).into(), ..first(&session, args)? },
        };
        let viewer = Viewer::new(subjects(&session), sight, clock);
        let path = args.settings.clone().or_else(Settings::usual_path);
        let (settings, said) = path.as_deref().map_or((Settings::default(), None), Settings::load);
        said.iter().for_each(|line| eprintln!("orrery: {line}"));
        let mut interface = Interface::new(viewer, settings);
        interface.heard = heard;
        let ended = window::run(&mut interface, &session, watch.as_ref()).map_err(|e| CliError(e.to_string()));
        if let (Ok(()), Some(path)) = (&ended, &path) {
            interface.settings.save(path).map_err(CliError)?;
        }
        ended
    }

    /// A link, or the file that keeps one.
    fn kept(link: &str) -> Result<Sight, CliError> {
        if crate::view::sight::is_link(link) {
            return Sight::from_link(link).map_err(|e| CliError(format!("{link}: {e}")));
        }
        let text = std::fs::read_to_string(link)
            .map_err(|e| CliError(format!("{link}: {e}; a link begins with {}", crate::view::sight::SCHEME)))?;
        Sight::from_json(&text).map_err(|e| CliError(format!("{link}: {e}")))
    }

    fn first(session: &Session, args: &ViewArgs) -> Result<Sight, CliError> {
        let time = instant(&args.time)?;
        let catalog = session.catalog();
        let named = catalog.find_place(&args.target).and_then(|id| catalog.body(id));
        let target = named.ok_or_else(|| CliError(format!("--target {}: no body has this name", args.target)))?;
        let start_km = sunlit_side(session, target.id, time) * (START_RADII * target.radii_km.x);
        let pole = session.ephemeris().body_from_icrf(target.id, time).map_or(DVec3::Z, |m| m.row(2));
        Ok(Sight::around(target.id, start_km, target.radii_km.x, pole, time))
    }

    fn clock() -> Instant {
        // J2000 when the clock shows what no calendar has.
        instant("now").unwrap_or(Instant::from_tdb_seconds_past_j2000(0.0))
    }

    /// Every body, planets from the Sun outwards each with its moons.
    fn subjects(session: &Session) -> Vec<Subject> {
        by_distance(session.catalog(), session.ephemeris())
            .into_iter()
            .filter_map(|id| session.catalog().body(id))
            .map(Subject::of)
            .collect()
    }

    /// A direction over the lit side, thirty degrees off the Sun's so that the terminator shows.
    fn sunlit_side(session: &Session, target: NaifId, time: Instant) -> DVec3 {
        let to_sun = session.ephemeris().state(NaifId::SUN, target, time, None).map_or(DVec3::X, |a| a.state.pos_km);
        let Some(sun) = to_sun.try_normalize() else { return DVec3::X };
        glam::DQuat::from_axis_angle(DVec3::Z, 30_f64.to_radians()) * sun
    }
}
