//! Measures the error of each ephemeris source against JPL's DE440:
//!
//!     cargo run --release --features bake --example measure_ephemeris -- de440.bsp
//!
//! Prints for each body and centre (NAIF ids) the worst and the root-mean-square error in km over 4000 dates, evenly spaced over the span, and
//! the worst error of the direction from the centre in arcseconds. The `error_km` that the library states for positions from series and mean
//! elements is the worst error from 1552 to 2646, rounded up.

use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, Source, spk::Spk};
use orrery::time::Instant;
use orrery::units::{DAYS_PER_JULIAN_YEAR, JD_J2000, RAD_PER_ARCSEC};

/// Number of dates at which each source is compared.
const DATE_COUNT: usize = 4000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: measure_ephemeris DE440.bsp")?;
    let de440 = Spk::parse(&path, &std::fs::read(&path)?)?;
    let ephemeris = Ephemeris::embedded(&Catalog::embedded())?;
    let bodies_and_centres =
        [(1, 10), (2, 10), (3, 10), (4, 10), (5, 10), (6, 10), (7, 10), (8, 10), (9, 10), (9, 0), (10, 0), (301, 399), (399, 3), (301, 10)];
    for (source, first_year, last_year) in [
        (Source::Kernel, 1900.0, 2100.0),
        (Source::Series, 1552.0, 2646.0),
        (Source::Series, 1600.0, 2500.0),
        (Source::Mean, 1552.0, 2646.0),
    ] {
        println!("{source:?} {first_year} to {last_year}\n place  from    worst km      rms km  worst arcsec");
        for (body, centre) in bodies_and_centres {
            let (mut worst_km, mut sum_of_squares_km2, mut worst_arcsec) = (0.0_f64, 0.0, 0.0_f64);
            for i in 0..DATE_COUNT {
                let year = first_year + (last_year - first_year) * (i as f64 + 0.5) / DATE_COUNT as f64;
                let t = Instant::from_jd_tdb(JD_J2000 + (year - 2000.0) * DAYS_PER_JULIAN_YEAR);
                let ours_km = ephemeris.state(NaifId(body), NaifId(centre), t, Some(source))?.state.pos_km;
                let de440_km = de440.state(body, centre, t.tdb_seconds_past_j2000()).ok_or("DE440 does not cover the date")?.pos_km;
                let error_km = (ours_km - de440_km).length();
                worst_km = worst_km.max(error_km);
                sum_of_squares_km2 += error_km * error_km;
                worst_arcsec = worst_arcsec.max((ours_km.normalize() - de440_km.normalize()).length() / RAD_PER_ARCSEC);
            }
            println!("{body:6} {centre:5} {worst_km:11.3} {:11.3} {worst_arcsec:13.4}", (sum_of_squares_km2 / DATE_COUNT as f64).sqrt());
        }
    }
    Ok(())
}
