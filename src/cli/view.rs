//! `orrery view`: the window, and the default verb.

use super::view_words::instant;
use super::{CliError, Common};

const KEYS: &str = "Mouse: drag turns, the wheel nears and recedes.
Keys: n, Tab next body; p previous; arrows turn; + - zoom; . faster, , slower,
j backward, l forward, Space pause, t now; q, Escape quit.

Examples:
  orrery
  orrery view --target saturn --time 2017-05-17T00:00:00Z";

#[derive(clap::Args, Debug)]
#[command(after_help = KEYS)]
pub struct ViewArgs {
    /// Body to start at
    #[arg(long, value_name = "BODY", default_value = "earth")]
    target: String,
    /// ISO 8601 UTC, jd_tdb:DAY, or now
    #[arg(long, value_name = "T", default_value = "now", allow_hyphen_values = true)]
    time: String,
}

impl Default for ViewArgs {
    fn default() -> Self {
        Self { target: "earth".into(), time: "now".into() }
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
    use crate::cli::Quality;
    use crate::ephemeris::order::by_distance;
    use crate::scene::request::{Axes, Position, ViewRequest};
    use crate::session::Session;
    use crate::time::Instant;
    use crate::view::controls::{Controls, Look, Subject};
    use crate::view::window::{self, Painter, Picture};
    use glam::DVec3;

    /// The first picture is taken from this far, in equatorial radii.
    const START_RADII: f64 = 3.5;

    pub fn run(common: &Common, args: &ViewArgs) -> Result<(), CliError> {
        let time = instant(&args.time)?;
        let session = Session::open(&common.sources_to_draw(), |line| eprintln!("orrery: {line}"))?;
        let catalog = session.catalog();
        let named = catalog.find_place(&args.target).and_then(|id| catalog.body(id));
        let target = named.ok_or_else(|| CliError(format!("--target {}: no body has this name", args.target)))?;
        let start_km = sunlit_side(&session, target.id, time) * (START_RADII * target.radii_km.x);
        let controls = Controls::new(subjects(&session, time), target.id, start_km, time, clock)
            .ok_or_else(|| CliError("the catalog has no bodies: leave --catalogs out".into()))?;
        let mut painter = SessionPainter { session: &session, quality: common.quality };
        window::run(controls, &mut painter).map_err(|e| CliError(e.to_string()))
    }

    fn clock() -> Instant {
        // J2000 when the clock shows what no calendar has.
        instant("now").unwrap_or(Instant::from_tdb_seconds_past_j2000(0.0))
    }

    /// Every body, planets from the Sun outwards each with its moons, with its pole at the start: poles move by arcseconds in a session.
    fn subjects(session: &Session, time: Instant) -> Vec<Subject> {
        let pole = |id: NaifId| session.ephemeris().body_from_icrf(id, time).map_or(DVec3::Z, |m| m.row(2));
        let subject = |b: &crate::catalog::Body| Subject { id: b.id, name: b.name.clone(), radius_km: b.radii_km.x, pole: pole(b.id) };
        by_distance(session.catalog(), session.ephemeris()).into_iter().filter_map(|id| session.catalog().body(id)).map(subject).collect()
    }

    /// A direction over the lit side, thirty degrees off the Sun's so that the terminator shows.
    fn sunlit_side(session: &Session, target: NaifId, time: Instant) -> DVec3 {
        let to_sun = session.ephemeris().state(NaifId::SUN, target, time, None).map_or(DVec3::X, |a| a.state.pos_km);
        let Some(sun) = to_sun.try_normalize() else { return DVec3::X };
        glam::DQuat::from_axis_angle(DVec3::Z, 30_f64.to_radians()) * sun
    }

    struct SessionPainter<'a> {
        session: &'a Session,
        quality: Quality,
    }

    impl Painter for SessionPainter<'_> {
        fn paint(&mut self, look: &Look, width: u32, height: u32) -> Result<Picture, String> {
            let request = ViewRequest {
                position: Position::Offset { body: look.target, offset_km: look.offset_km, axes: Axes::Icrf },
                fov_deg: Some(look.fov_deg),
                width: width.clamp(1, 16384),
                height: height.clamp(1, 16384),
                quality: self.quality.of_request(),
                ..ViewRequest::of(look.target, look.time)
            };
            let frame = self.session.draw_promptly(&request, self.quality.fineness()).map_err(|e| e.to_string())?.frame;
            Ok(Picture { width: frame.width, height: frame.height, rgba: frame.display })
        }

        fn title(&self, look: &Look) -> String {
            format!("{} · {} · {:.4} radii · {} · Orrery", look.name, look.time.to_utc_iso(), look.distance_radii, look.pace)
        }
    }
}
