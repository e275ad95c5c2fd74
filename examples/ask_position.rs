//! Prints the apparent right ascension and declination of a body seen from the Earth's centre, both in degrees, of the true equator and equinox of date, with
//! their error bound:
//!
//!     cargo run --release --example ask_position -- jupiter 2040-09-08T12:00:00Z

use orrery::catalog::Catalog;
use orrery::ephemeris::{Ephemeris, apparent::apparent_place};
use orrery::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let argument = |n: usize, default: &str| std::env::args().nth(n).unwrap_or_else(|| default.into());
    let catalog = Catalog::embedded();
    let body = catalog.body_named(&argument(1, "jupiter"))?;
    let time = Instant::parse(&argument(2, "2040-09-08T12:00:00Z"))?;
    let place = apparent_place(&Ephemeris::embedded(&catalog)?, body.id, time)?;
    let of_date = place.true_of_date;
    println!(
        "{}: RA {:.4}, declination {:.4} degrees of date, within {:.2} arcsec",
        body.name, of_date.ra_deg, of_date.dec_deg, place.error_arcsec
    );
    Ok(())
}
