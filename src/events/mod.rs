//! Events: eclipses of the Sun and the Moon, transits of Mercury and Venus, and phenomena of the Galilean moons and Titan.
//!
//! In: catalog, ephemeris, a span of time. Out: eclipses by time, and transits and phenomena of moons in the order in which they are found, with their instants
//! as the Earth's centre receives the light; for eclipses and transits also local circumstances. The geometry is that of the shaders: bodies are where the light
//! passed them, and radii are the catalog's ([`EclipseRadii`](crate::catalog::EclipseRadii)). Nothing is drawn here and no file is read.

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
pub use path::{CutVertex, EclipsePath, cut_at_date_line};
pub use solar::{SolarEclipse, SolarType};
pub use transit::{Transit, transits};

use crate::catalog::Catalog;
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;
use lunation::{Phase, Syzygy};
use saros::SeriesStarts;
use sky::EclipseBodies;

/// Eclipses of the Sun whose greatest phase is in `from..to`.
///
/// # Errors
/// The catalog lacks a body, or the theories do not cover the span.
pub fn solar_eclipses(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let bodies = EclipseBodies::of(catalog)?;
    let eclipse_at = |new_moon| solar::eclipse_at(ephemeris, bodies, new_moon);
    let mut found = eclipses_at_phase(Phase::New, from, to, |e: &SolarEclipse| e.greatest, eclipse_at)?;
    count_members(&mut found, eclipse_at, |e: &mut SolarEclipse, member| e.saros_member = member);
    Ok(found.into_iter().map(|(eclipse, _)| eclipse).collect())
}

/// As [`solar_eclipses`], without their numbers in the Saros series, which take most of the time.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn uncounted_solar_eclipses(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    from: Instant,
    to: Instant,
) -> Result<Vec<SolarEclipse>, EphemerisError> {
    let bodies = EclipseBodies::of(catalog)?;
    let eclipse_at = |new_moon| solar::eclipse_at(ephemeris, bodies, new_moon);
    let found = eclipses_at_phase(Phase::New, from, to, |e: &SolarEclipse| e.greatest, eclipse_at)?;
    Ok(found.into_iter().map(|(eclipse, _)| eclipse).collect())
}

/// Eclipses of the Moon whose greatest phase is in `from..to`.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn lunar_eclipses(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let bodies = EclipseBodies::of(catalog)?;
    let eclipse_at = |full_moon| lunar::eclipse_at(ephemeris, bodies, full_moon);
    let mut found = eclipses_at_phase(Phase::Full, from, to, |e: &LunarEclipse| e.greatest, eclipse_at)?;
    count_members(&mut found, eclipse_at, |e: &mut LunarEclipse, member| e.saros_member = member);
    Ok(found.into_iter().map(|(eclipse, _)| eclipse).collect())
}

/// As [`lunar_eclipses`], without their numbers in the Saros series, which take most of the time.
///
/// # Errors
/// As [`solar_eclipses`].
pub fn uncounted_lunar_eclipses(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    from: Instant,
    to: Instant,
) -> Result<Vec<LunarEclipse>, EphemerisError> {
    let bodies = EclipseBodies::of(catalog)?;
    let eclipse_at = |full_moon| lunar::eclipse_at(ephemeris, bodies, full_moon);
    let found = eclipses_at_phase(Phase::Full, from, to, |e: &LunarEclipse| e.greatest, eclipse_at)?;
    Ok(found.into_iter().map(|(eclipse, _)| eclipse).collect())
}

/// The eclipses that `eclipse_at` finds at the syzygies of a phase, with these syzygies.
fn eclipses_at_phase<E>(
    phase: Phase,
    from: Instant,
    to: Instant,
    greatest: impl Fn(&E) -> Instant,
    eclipse_at: impl Fn(Syzygy) -> Result<Option<E>, EphemerisError>,
) -> Result<Vec<(E, Syzygy)>, EphemerisError> {
    let mut found = Vec::new();
    // Mean and true phase differ by less than a day.
    const MARGIN_S: f64 = 86_400.0;
    let mut syzygy = Syzygy::before(phase, from.plus_seconds(-MARGIN_S));
    while syzygy.mean_instant() < to.plus_seconds(MARGIN_S) {
        found.extend(eclipse_at(syzygy)?.filter(|e| (from..to).contains(&greatest(e))).map(|eclipse| (eclipse, syzygy)));
        syzygy = syzygy.next();
    }
    Ok(found)
}

/// Sets the numbers of eclipses in their Saros series.
fn count_members<E>(
    eclipses: &mut [(E, Syzygy)],
    eclipse_at: impl Fn(Syzygy) -> Result<Option<E>, EphemerisError>,
    set_member: impl Fn(&mut E, Option<i64>),
) {
    let mut starts = SeriesStarts::default();
    for (eclipse, syzygy) in eclipses {
        // The start is unknown if the series may have begun before the theories' span.
        set_member(eclipse, starts.member(*syzygy, |earlier| eclipse_at(earlier).map(|e| e.is_some())).ok());
    }
}
