//! Events: eclipses of the Sun and the Moon, transits of Mercury and Venus, and phenomena of the Galilean moons and Titan.
//!
//! In: catalog, ephemeris, a span of time. Out: eclipses in order of time; transits planet by planet; phenomena of moons, not sorted. Instants are those at
//! which the Earth's centre receives the light; eclipses and transits also have local circumstances. Positions include light time and aberration, as in the
//! shaders, and radii follow the catalog's convention ([`EclipseRadii`](crate::catalog::EclipseRadii)). Not here: drawing, files.

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

use crate::catalog::Catalog;
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use lunation::{Phase, Syzygy};
use saros::SeriesStarts;
use sky::BodyRadii;
use std::ops::Range;

/// Eclipses of the Sun whose greatest phase is in `from..to`.
///
/// # Errors
/// The catalog lacks a body, or the ephemeris does not cover the span.
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

/// Eclipses of the Moon whose greatest phase is in `from..to`.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn lunar_eclipses(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let with_saros_member = true;
    find_lunar(catalog, ephemeris, from..to, with_saros_member)
}

/// As [`lunar_eclipses`], but with [`LunarEclipse::saros_member`] left `None`: finding it takes most of the time.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn lunar_eclipses_without_saros(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    from: Instant,
    to: Instant,
) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let with_saros_member = false;
    find_lunar(catalog, ephemeris, from..to, with_saros_member)
}

/// `with_saros_member`: whether to find each eclipse's number within its Saros series.
fn find_solar(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    span: Range<Instant>,
    with_saros_member: bool,
) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let radii = BodyRadii::of(catalog)?;
    let eclipse_at = |new_moon| solar::eclipse_at(ephemeris, radii, new_moon);
    let set_member = |e: &mut SolarEclipse, member| e.saros_member = member;
    eclipses_at_phase(Phase::New, span, |e| e.greatest, eclipse_at, with_saros_member.then_some(set_member))
}

/// As [`find_solar`].
fn find_lunar(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    span: Range<Instant>,
    with_saros_member: bool,
) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let radii = BodyRadii::of(catalog)?;
    let eclipse_at = |full_moon| lunar::eclipse_at(ephemeris, radii, full_moon);
    let set_member = |e: &mut LunarEclipse, member| e.saros_member = member;
    eclipses_at_phase(Phase::Full, span, |e| e.greatest, eclipse_at, with_saros_member.then_some(set_member))
}

/// The eclipses that `eclipse_at` finds at the new or full moons of a span. `set_member` stores an eclipse's number within its Saros series; with
/// `None`, the numbers are not computed.
fn eclipses_at_phase<E>(
    phase: Phase,
    span: Range<Instant>,
    greatest: impl Fn(&E) -> Instant,
    eclipse_at: impl Fn(Syzygy) -> Result<Option<E>, EphemerisError>,
    set_member: Option<impl Fn(&mut E, Option<i64>)>,
) -> Result<Vec<E>, EphemerisError> {
    let mut found = Vec::new();
    let mut starts = SeriesStarts::default();
    // The mean new or full moon and the greatest eclipse differ by less than a day.
    const MARGIN_S: f64 = SECONDS_PER_DAY;
    let (first, last) = (span.start.plus_seconds(-MARGIN_S), span.end.plus_seconds(MARGIN_S));
    let mut syzygy = Syzygy::at_or_before(phase, first);
    // The ephemeris may not cover a syzygy before the margin.
    while syzygy.mean_instant() < first {
        syzygy = syzygy.next();
    }
    while syzygy.mean_instant() < last {
        if let Some(mut eclipse) = eclipse_at(syzygy)?.filter(|e| span.contains(&greatest(e))) {
            if let Some(set_member) = &set_member {
                // `None` if the series may have begun before the span of the ephemeris.
                set_member(&mut eclipse, starts.member(syzygy, |earlier| eclipse_at(earlier).map(|e| e.is_some())).ok());
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

    /// A span may begin a day after the ephemeris does.
    #[test]
    fn no_phase_before_the_margin_is_computed() {
        let span = Instant::parse("2024-01-01").expect("a time")..Instant::parse("2025-01-01").expect("a time");
        let covered_from = span.start.plus_seconds(-SECONDS_PER_DAY);
        let eclipse_at = |syzygy: Syzygy| match syzygy.mean_instant() < covered_from {
            true => Err(EphemerisError::other("not covered")),
            false => Ok(Some(syzygy)),
        };
        let no_member: Option<fn(&mut Syzygy, Option<i64>)> = None;
        let found = eclipses_at_phase(Phase::New, span, |syzygy| syzygy.mean_instant(), eclipse_at, no_member).expect("covered");
        assert_eq!(found.len(), 13, "the new moons of 2024, from 11 January to 30 December");
    }
}
