//! Measures the error of each ephemeris source against JPL's DE440: `cargo run --release --features bake --example measure_ephemeris --
//! de440.bsp`.
//!
//! Prints per body and centre the worst and the root-mean-square error over 4000 dates, evenly spaced over the span: in km, relative to the
//! origin of the source's theory, and in arcseconds as seen from that origin. `error_km` of the sources is these figures, rounded up.

use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, Source, spk::Spk};
use orrery::time::Instant;

const DATES: usize = 4000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: measure_ephemeris DE440.bsp")?;
    let truth = Spk::parse(&path, &std::fs::read(&path)?)?;
    let ephemeris = Ephemeris::embedded(&Catalog::embedded())?;
    let places =
        [(1, 10), (2, 10), (3, 10), (4, 10), (5, 10), (6, 10), (7, 10), (8, 10), (9, 10), (9, 0), (10, 0), (301, 399), (399, 3), (301, 10)];
    for (source, first_year, last_year) in [
        (Source::Kernel, 1900.0, 2100.0),
        (Source::Series, 1552.0, 2646.0),
        (Source::Series, 1600.0, 2500.0),
        (Source::Mean, 1552.0, 2646.0),
    ] {
        println!("{source:?} {first_year} to {last_year}\n place  from    worst km      rms km  worst arcsec");
        for (body, center) in places {
            let (mut worst_km, mut squares, mut worst_arcsec) = (0.0_f64, 0.0, 0.0_f64);
            for i in 0..DATES {
                let year = first_year + (last_year - first_year) * (i as f64 + 0.5) / DATES as f64;
                let t = Instant::from_jd_tdb(2_451_545.0 + (year - 2000.0) * 365.25);
                let ours_km = ephemeris.state(NaifId(body), NaifId(center), t, Some(source))?.state.pos_km;
                let de440_km = truth.state(body, center, t.tdb_seconds_past_j2000()).ok_or("DE440 does not cover the date")?.pos_km;
                let error_km = (ours_km - de440_km).length();
                worst_km = worst_km.max(error_km);
                squares += error_km * error_km;
                worst_arcsec = worst_arcsec.max((ours_km.normalize() - de440_km.normalize()).length() * 206_264.806);
            }
            println!("{body:6} {center:5} {worst_km:11.3} {:11.3} {worst_arcsec:13.4}", (squares / DATES as f64).sqrt());
        }
    }
    Ok(())
}
