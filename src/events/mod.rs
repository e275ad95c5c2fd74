//! Events: eclipses of the Sun and the Moon, transits of Mercury and Venus, and phenomena of the Galilean moons and Titan.
//!
//! In: catalog, ephemeris, a span of time. Out: eclipses in order of time; transits planet by planet; phenomena of moons, not sorted. Instants are those at
//! which the Earth's centre receives the light; eclipses and transits also have local circumstances. Positions include light time and aberration, as in the
//! shaders, and radii follow the catalog's convention ([`EclipseRadii`](crate::catalog::EclipseRadii)), except for [`lunar_eclipses_by_almanacs`]. Not here:
//! drawing, files.

mod cone;
mod contacts;
mod fitted;
mod limb;
mod local;
mod lunar;
mod lunation;
mod moons;
mod mutual;
mod numeric;
mod path;
mod saros;
mod sky;
mod solar;
mod transit;

pub use limb::LimbContact;
pub use local::{GeodeticPosition, LocalCircumstances, LocalContact};
pub use lunar::{LunarEclipse, LunarType, shadow_enlargement};
pub use moons::{MoonEvent, MoonEventType, moon_events};
pub use mutual::mutual_events;
pub use path::{CutVertex, EclipsePath, cut_at_antimeridian};
pub use solar::{SolarEclipse, SolarType};
pub use transit::{Transit, transits};

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use lunation::{Phase, Syzygy};
use saros::SeriesStarts;
use sky::BodyRadii;
use std::ops::Range;

/// Eclipses of the Sun whose instant of greatest eclipse is in `from..to`.
///
/// # Errors
/// The catalog lacks a body, or the ephemeris does not cover the span. If an eclipse is possible near an end of the span, the ephemeris must also cover the two
/// days beyond this end.
pub fn solar_eclipses(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let with_saros_member = true;
    find_solar(catalog, ephemeris, from..to, with_saros_member)
}

/// As [`solar_eclipses`], but with [`SolarEclipse::saros_member`] left `None`: finding it takes most of the time.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn solar_eclipses_without_saros(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    from: Instant,
    to: Instant,
) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let with_saros_member = false;
    find_solar(catalog, ephemeris, from..to, with_saros_member)
}

/// Eclipses of the Moon whose instant of greatest eclipse is in `from..to`.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn lunar_eclipses(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let with_saros_member = true;
    find_lunar(ephemeris, BodyRadii::of(catalog)?, from..to, with_saros_member)
}

/// As [`lunar_eclipses`], but always by the radii of almanacs, whatever convention the catalog follows: with a shadow that the Earth's air enlarges, as an
/// observer sees it. [`LunarEclipse::saros_member`] is left `None`: finding it takes most of the time.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn lunar_eclipses_by_almanacs(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    from: Instant,
    to: Instant,
) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let with_saros_member = false;
    find_lunar(ephemeris, BodyRadii::of_almanacs(catalog)?, from..to, with_saros_member)
}

/// Eclipses of the Sun whose instant of greatest eclipse is in `span`. `with_saros_member`: whether to find each eclipse's number within its Saros series.
fn find_solar(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    span: Range<Instant>,
    with_saros_member: bool,
) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let radii = BodyRadii::of(catalog)?;
    let eclipse_at = |new_moon| solar::eclipse_at(ephemeris, radii, new_moon);
    let set_member = |e: &mut SolarEclipse, member| e.saros_member = member;
    eclipses_at_phase(
        Phase::New,
        span,
        |t| check_covered(ephemeris, t),
        |e| e.greatest,
        eclipse_at,
        with_saros_member.then_some(set_member),
    )
}

/// As [`find_solar`], for eclipses of the Moon.
fn find_lunar(
    ephemeris: &Ephemeris,
    radii: BodyRadii,
    span: Range<Instant>,
    with_saros_member: bool,
) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let eclipse_at = |full_moon| lunar::eclipse_at(ephemeris, radii, full_moon);
    let set_member = |e: &mut LunarEclipse, member| e.saros_member = member;
    eclipses_at_phase(
        Phase::Full,
        span,
        |t| check_covered(ephemeris, t),
        |e| e.greatest,
        eclipse_at,
        with_saros_member.then_some(set_member),
    )
}

/// Checks that the ephemeris has the Sun, the Earth and the Moon at `t`.
///
/// # Errors
/// The ephemeris does not cover `t`.
fn check_covered(ephemeris: &Ephemeris, t: Instant) -> Result<(), EphemerisError> {
    ephemeris.state(NaifId::EARTH, NaifId::SUN, t, BEST_SOURCE)?;
    ephemeris.state(NaifId::MOON, NaifId::EARTH, t, BEST_SOURCE)?;
    Ok(())
}

/// The eclipses that `eclipse_at` finds at new or full moons, and whose instant of greatest eclipse (`greatest`) is in the span. `set_member` stores an
/// eclipse's number within its Saros series, `None` if that is unknown; without `set_member` the numbers are not computed.
///
/// `check_covered` is an error where the ephemeris lacks positions. It is called at the ends of the span and at each new or full moon in it, because
/// `eclipse_at` rules out most eclipses without the ephemeris: the result for a span that is not covered would be "no eclipse".
fn eclipses_at_phase<E>(
    phase: Phase,
    span: Range<Instant>,
    check_covered: impl Fn(Instant) -> Result<(), EphemerisError>,
    greatest: impl Fn(&E) -> Instant,
    eclipse_at: impl Fn(Syzygy) -> Result<Option<E>, EphemerisError>,
    set_member: Option<impl Fn(&mut E, Option<i64>)>,
) -> Result<Vec<E>, EphemerisError> {
    check_covered(span.start)?;
    check_covered(span.end)?;
    let mut found = Vec::new();
    let mut series_starts = SeriesStarts::default();
    // The mean new or full moon and the greatest eclipse differ by less than a day.
    const MARGIN_S: f64 = SECONDS_PER_DAY;
    let (first, last) = (span.start.plus_seconds(-MARGIN_S), span.end.plus_seconds(MARGIN_S));
    let mut syzygy = Syzygy::at_or_before(phase, first);
    // `at_or_before` may return a syzygy before the margin, which the ephemeris need not cover.
    while syzygy.mean_instant() < first {
        syzygy = syzygy.next();
    }
    while syzygy.mean_instant() < last {
        if span.contains(&syzygy.mean_instant()) {
            check_covered(syzygy.mean_instant())?;
        }
        if let Some(mut eclipse) = eclipse_at(syzygy)?.filter(|e| span.contains(&greatest(e))) {
            if let Some(set_member) = &set_member {
                // `None` if the series may have begun before the span of the ephemeris.
                let member = series_starts.member(syzygy, |earlier| eclipse_at(earlier).map(|e| e.is_some()));
                set_member(&mut eclipse, member.ok());
            }
            found.push(eclipse);
        }
        syzygy = syzygy.next();
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn instant(text: &str) -> Instant {
        Instant::parse(text).expect("a time")
    }

    /// Number of eclipses found from `from` to `to`, if each new moon has one or none has one, and the ephemeris covers all times but those of `gap`.
    fn eclipse_count(from: &str, to: &str, gap: Range<Instant>, each_has_eclipse: bool) -> Result<usize, EphemerisError> {
        let check_covered = |t: Instant| if gap.contains(&t) { Err(EphemerisError::other("not covered")) } else { Ok(()) };
        // As the real functions: the ephemeris is asked only if an eclipse is possible.
        let eclipse_at = |syzygy: Syzygy| match each_has_eclipse {
            true => check_covered(syzygy.mean_instant()).map(|()| Some(syzygy)),
            false => Ok(None),
        };
        let no_member: Option<fn(&mut Syzygy, Option<i64>)> = None;
        let span = instant(from)..instant(to);
        eclipses_at_phase(Phase::New, span, check_covered, |syzygy| syzygy.mean_instant(), eclipse_at, no_member).map(|found| found.len())
    }

    /// A span may begin a day after the ephemeris does.
    #[test]
    fn no_phase_before_the_margin_is_computed() {
        let before = instant("-1000-01-01")..instant("2024-01-01").plus_seconds(-SECONDS_PER_DAY);
        assert_eq!(eclipse_count("2024-01-01", "2025-01-01", before, true), Ok(13), "the new moons from 11 January to 30 December");
    }

    /// `eclipse_at` rules out eclipses in any year, without the ephemeris. Where the ephemeris has no positions, the result must be an error, not "no eclipse".
    #[test]
    fn no_eclipse_is_an_answer_only_for_spans_that_are_covered() {
        let count = |from, to, (gap_start, gap_end)| eclipse_count(from, to, instant(gap_start)..instant(gap_end), false);
        // Mean new moons of 2024: 11 January, 9 February, 10 March.
        let february = ("2024-02-01", "2024-02-28");
        assert_eq!(count("2024-03-01", "2024-04-01", february), Ok(0), "the gap is before the span");
        assert_eq!(count("2024-01-15", "2024-01-31", february), Ok(0), "the gap is after the span");
        for (from, to, gap, what) in [
            ("2024-02-03", "2024-02-25", february, "the entire span"),
            ("2024-02-12", "2024-02-20", february, "a span without a new moon"),
            ("2024-01-15", "2024-02-05", february, "the end"),
            ("2024-02-20", "2024-03-05", february, "the beginning"),
            ("2024-01-01", "2024-04-01", ("2024-02-07", "2024-02-12"), "a new moon between the ends"),
        ] {
            assert!(count(from, to, gap).is_err(), "{what}");
        }
    }
}
