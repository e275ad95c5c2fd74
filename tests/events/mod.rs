//! Eclipses, transits and events of moons, as `eclipse find` reports them.

mod canons;
mod commands;
mod eclipse_table;
mod limb;
mod local;
mod moons;
mod rendered;
mod transits;

use orrery::catalog::EclipseRadii;
use orrery::{Catalog, Ephemeris, Instant};
use std::sync::LazyLock;

/// The catalog with the radii that the IAU publishes, and the same catalog with the radii that almanacs use for eclipses (a smaller Moon, an umbra enlarged by
/// the Earth's air). The ephemeris does not depend on radii.
static IAU_RADII: LazyLock<Catalog> = LazyLock::new(Catalog::embedded);
static ALMANAC_RADII: LazyLock<Catalog> = LazyLock::new(|| Catalog::embedded().with_eclipse_radii(EclipseRadii::Almanac));
static EPHEMERIS: LazyLock<Ephemeris> = LazyLock::new(|| Ephemeris::embedded(&IAU_RADII).expect("the shipped ephemeris"));

fn parse_time(text: &str) -> Instant {
    Instant::parse(text).expect(text)
}

/// Seconds from instant `b` to instant `a`.
fn seconds_after(a: Instant, b: Instant) -> f64 {
    a.tdb_seconds_past_j2000() - b.tdb_seconds_past_j2000()
}
