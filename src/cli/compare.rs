//! `orrery compare`: measures the difference between two images.
//!
//! In: two image files of the same size, and optionally the error bounds that `render --error` wrote. Out: mean, 99.9th percentile and maximum of the
//! difference, PSNR, the fraction of pixels whose difference is within the bound, and a difference image.

use super::output::print_result;
use super::output_file::write_output_file;
use super::{CliError, Common};
use crate::files::read_bytes;
use crate::image::{self, DisplayImage, MAX_FILE_BYTES};
use crate::wording::{echo, echo_within};
use std::path::{Path, PathBuf};

/// Longest quotation of a file name in a message that names both images, characters.
const MAX_NAME_CHARS: usize = 100;

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Differences are in levels of 0 to 255, over red, green and blue (and alpha, if present).\n\n\
Examples:\n  orrery compare before.png after.png --tolerance 3 -o difference.png\n  \
  orrery compare earth.png reference.png --error bound.png",
    next_help_heading = "Comparison"
)]
pub(crate) struct CompareArgs {
    /// First image, PNG or JPEG
    a: PathBuf,
    /// Second image, of the same size
    b: PathBuf,
    /// Write the absolute difference as a PNG, scaled so that the largest is white
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "output")]
    overwrite: bool,
    // `-1` is read as a value, so that the message says what is allowed, instead of as an unknown option.
    /// Largest allowed difference; the exit status is 1 above it
    #[arg(long, value_name = "LEVELS", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// PNG of the error bounds that `render --error` writes (1 level = 1/255): print the percentage of pixels within their bound
    #[arg(long, value_name = "FILE")]
    error: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn read_image(path: &Path, max_megapixels: u32) -> Result<DisplayImage, CliError> {
    let name = echo(&path.display().to_string());
    let bytes = read_bytes(path, MAX_FILE_BYTES).map_err(|e| CliError::Failed(format!("{name}: {e}")))?;
    DisplayImage::decode(&name, &bytes, max_megapixels).map_err(|e| CliError::Failed(e.to_string()))
}

pub(crate) fn run(common: &Common, args: &CompareArgs) -> Result<(), CliError> {
    if let Some(t) = args.tolerance.filter(|t| !(0.0..=255.0).contains(t)) {
        return Err(CliError::Usage(format!("--tolerance {t:?}: must be 0 to 255")));
    }
    if let Some(path) = args.output.as_ref().filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))) {
        return Err(CliError::Usage(format!("-o {}: the name must end in .png", echo(&path.display().to_string()))));
    }
    let (a, b) = (read_image(&args.a, common.max_megapixels)?, read_image(&args.b, common.max_megapixels)?);
    let error_with_names = |e: image::ImageError| {
        CliError::Failed(format!(
            "{} and {}: {e}",
            echo_within(&args.a.display().to_string(), MAX_NAME_CHARS),
            echo_within(&args.b.display().to_string(), MAX_NAME_CHARS)
        ))
    };
    let difference = a.difference(&b).map_err(error_with_names)?;
    if let Some(path) = &args.output {
        let scaled = a.difference_image(&b).map_err(error_with_names)?;
        let mut bytes = Vec::new();
        image::write_png(&mut bytes, scaled.width, scaled.height, &scaled.rgba, &[]).map_err(|e| CliError::Failed(e.to_string()))?;
        write_output_file("-o", path, &bytes, args.overwrite)?;
    }
    let fraction_within_bound = match &args.error {
        Some(path) => Some(a.fraction_within(&b, &read_image(path, common.max_megapixels)?).map_err(error_with_names)?),
        None => None,
    };
    let psnr_text = difference.psnr_db.map_or("infinite".to_owned(), |db| format!("{db:.2} dB"));
    if args.json {
        let mut report = serde_json::json!(difference);
        if let Some(fraction) = fraction_within_bound {
            // A fraction, 0 to 1; the text output below gives percent.
            report["bound_held"] = fraction.into();
        }
        print_result(&format!("{report}\n"))?;
    } else {
        // `99.9 %` is the label of the 99.9th percentile.
        print_result(&format!(
            "mean {:.4}\n99.9 % {}\nmaximum {}\nPSNR {psnr_text}\npixels {}\n",
            difference.mean, difference.p999, difference.max, difference.pixels
        ))?;
        if let Some(fraction) = fraction_within_bound {
            print_result(&format!("the bound holds in {:.4} % of the pixels\n", 100.0 * fraction))?;
        }
    }
    match args.tolerance {
        Some(t) if f64::from(difference.max) > t => {
            Err(CliError::Failed(format!("the images differ by {} levels, more than the tolerance of {t}", difference.max)))
        }
        _ => Ok(()),
    }
}
