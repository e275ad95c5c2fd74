//! Measures two choices that affect positions: the source of the ephemeris, and the corrections for light time and aberration.
//!
//! In: the session's ephemeris. Out: for each option its time and its error, in arcseconds as seen from the Earth: the greatest over the Sun, the Moon and the
//! planets on dates that span 185 years.

use super::images::larger_or_nan;
use super::rule::ErrorUnit;
use super::{Candidate, ChoiceMeasure, Effort, measure_choice};
use crate::catalog::NaifId;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::{BEST_SOURCE, EphemerisError, Source, angle_rad};
use crate::scene::request::Quality;
use crate::session::{Session, SessionError};
use crate::time::Instant;
use crate::units::RAD_PER_ARCSEC;
use glam::DVec3;

/// Sun, Moon and planets.
const BODIES: [NaifId; 9] =
    [NaifId::SUN, NaifId::MOON, NaifId(199), NaifId(299), NaifId(499), NaifId(599), NaifId(699), NaifId(799), NaifId(899)];
/// The first of `DATE_COUNT` dates from 1905 to 2089, within the time span of the embedded kernel.
const FIRST_JD_TDB: f64 = 2_416_847.3;
/// Days between the dates, not a multiple of any body's period.
const STEP_DAYS: f64 = 1_983.7;
const DATE_COUNT: usize = 35;
/// Repetitions over all bodies and dates in one timed run, because a position takes only microseconds.
const REPETITIONS: usize = 3;

fn instants() -> impl Iterator<Item = Instant> {
    (0..DATE_COUNT).map(|k| Instant::from_jd_tdb(FIRST_JD_TDB + STEP_DAYS * k as f64))
}

/// A way of computing the direction of a body from the Earth. The vector may have any length.
type DirectionFn<'a> = Box<dyn Fn(NaifId, Instant) -> Result<DVec3, EphemerisError> + 'a>;

/// The greatest angular separation between two ways of computing directions, arcseconds; NaN if any is NaN.
fn worst_arcsec(a: &DirectionFn<'_>, b: &DirectionFn<'_>) -> Result<f64, EphemerisError> {
    let mut worst = 0.0_f64;
    for t in instants() {
        for body in BODIES {
            worst = larger_or_nan(worst, angle_rad(a(body, t)?, b(body, t)?) / RAD_PER_ARCSEC);
        }
    }
    Ok(worst)
}

/// The options, before they are timed, of a choice among methods of computing directions, with their errors against `reference`. `methods`: for each its name,
/// the method, and the qualities that use it by default.
fn candidates<'a>(
    methods: Vec<(&'static str, DirectionFn<'a>, Vec<Quality>)>,
    reference: &DirectionFn<'_>,
) -> Result<Vec<Candidate<'a>>, EphemerisError> {
    let mut all = Vec::new();
    for (name, method, default_of) in methods {
        let error = worst_arcsec(&method, reference)?;
        let workload = Box::new(move || {
            for _ in 0..REPETITIONS {
                for t in instants() {
                    for body in BODIES {
                        std::hint::black_box(method(body, t)?);
                    }
                }
            }
            Ok(())
        });
        all.push(Candidate { name: name.to_owned(), error, default_of, workload });
    }
    Ok(all)
}

/// Measures the choice of the ephemeris's source (`--source`): mean elements, series or kernel. In the years that the kernel covers, every quality uses it.
pub(super) fn ephemeris_source(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let ephemeris = session.ephemeris();
    // Geometric, from the Earth.
    let direction_by = |source: Source| -> DirectionFn<'_> {
        Box::new(move |body, t| Ok(ephemeris.state(body, NaifId::EARTH, t, Some(source))?.state.pos_km))
    };
    let methods = vec![
        ("mean", direction_by(Source::Mean), vec![]),
        ("series", direction_by(Source::Series), vec![]),
        ("kernel", direction_by(Source::Kernel), Quality::ALL.to_vec()),
    ];
    let about =
        "worst direction from the Earth, Sun to Neptune and Moon, 1905-2089, against the kernel (itself within 0.02 arcsec of DE440)";
    measure_choice("ephemeris", about, ErrorUnit::Arcseconds, effort.rounds(), candidates(methods, &direction_by(Source::Kernel))?)
}

/// Measures the choice among the geometric direction, the one corrected for light time, and the apparent one, corrected for light time and aberration.
pub(super) fn direction_corrections(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let ephemeris = session.ephemeris();
    // Relative to the solar system's barycentre.
    let state = move |body, t| Ok::<_, EphemerisError>(ephemeris.state(body, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state);
    let geometric: DirectionFn<'_> = Box::new(move |body, t| Ok(state(body, t)?.pos_km - state(NaifId::EARTH, t)?.pos_km));
    let corrected_for_light_time: DirectionFn<'_> = Box::new(move |body, t| {
        let observer_km = state(NaifId::EARTH, t)?.pos_km;
        let (emission_km, _time) = ephemeris.light_time_position(body, observer_km, t)?;
        Ok(emission_km - observer_km)
    });
    let apparent = move |body, t| -> Result<DVec3, EphemerisError> {
        let observer = state(NaifId::EARTH, t)?;
        let (emission_km, _time) = ephemeris.light_time_position(body, observer.pos_km, t)?;
        Ok(aberrated((emission_km - observer.pos_km).normalize(), observer.vel_km_s))
    };
    let methods = vec![
        ("geometric", geometric, vec![]),
        ("light-time", corrected_for_light_time, vec![]),
        ("apparent", Box::new(apparent) as DirectionFn<'_>, Quality::ALL.to_vec()),
    ];
    let reference: DirectionFn<'_> = Box::new(apparent);
    let about =
        "worst direction from the Earth, Sun to Neptune and Moon, 1905-2089, against the apparent direction (light time and aberration)";
    measure_choice("light-time", about, ErrorUnit::Arcseconds, effort.rounds(), candidates(methods, &reference)?)
}
