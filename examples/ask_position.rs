//! Prints the apparent position of a body seen from the Earth's centre, with its error bound:
//!
//!     cargo run --release --example ask_position -- jupiter 2040-09-08T12:00:00Z

use orrery::catalog::Catalog;
use orrery::ephemeris::{Ephemeris, apparent::apparent_place};
use orrery::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let word = |n: usize, otherwise: &str| std::env::args().nth(n).unwrap_or_else(|| otherwise.into());
    let catalog = Catalog::embedded();
    let body = catalog.body_named(&word(1, "jupiter"))?;
    let time = Instant::parse(&word(2, "2040-09-08T12:00:00Z"))?;
    let place = apparent_place(&Ephemeris::embedded(&catalog)?, body.id, time)?;
    let at = place.true_of_date;
    println!("{}: RA {:.4}, declination {:.4} degrees of date, within {:.2} arcsec", body.name, at.ra_deg, at.dec_deg, place.error_arcsec);
    Ok(())
}
