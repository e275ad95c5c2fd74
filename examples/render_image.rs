//! Renders Saturn with the library and writes a PNG, or an EXR if the file name ends in .exr:
//!
//!     cargo run --release --example render_image -- saturn.png

use orrery::scene::request::Purpose;
use orrery::session::is_exr;
use orrery::{FrameImages, Instant, NaifId, SamplingQuality, Session, Sources, ViewRequest, write_image};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::path::PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "saturn.png".into()));
    let session = Session::open(&Sources::default(), |line| eprintln!("{line}"))?;
    let mut request = ViewRequest { width: 640, height: 400, ..ViewRequest::of(NaifId(699), Instant::parse("2017-04-26T12:00:00Z")?) };
    // An EXR also keeps light that a display does not show.
    request.purpose = Purpose::of_file(is_exr(&path));
    let images = if is_exr(&path) { FrameImages::DisplayAndHdr } else { FrameImages::Display };
    let drawn = session.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, images)?;
    write_image(&path, &drawn.frame, &[])?;
    Ok(())
}
