//! Reads the user's panorama of the sky when the session is opened, and determines the radiance that its value 1 stands for.
//!
//! In: the file, the celestial frame of its coordinates, and the map store. Out: a [`SkyMap`], whose texels are in the map store, or an error in one line.

use super::SessionError;
use crate::image::{ImageError, MapStore, read_panorama};
use crate::render::plan::SKY_DECODING;
use crate::scene::CD_M2_PER_RADIANCE;
use crate::scene::sky::frames::SkyFrame;
use crate::scene::sky::map::{BrightSkyMap, SkyMap};
use crate::units::luminance;
use crate::wording::echo;
use std::path::Path;

/// Mean radiance over the sphere that a panorama without a unit is given: that of the embedded Milky Way.
fn default_mean_radiance() -> f64 {
    /// Mean over the sphere of the luminance of the embedded map's texels, as a linear texel value.
    const MILKY_WAY_MEAN_VALUE: f64 = 0.0293;
    SkyMap::milky_way().unit_radiance * MILKY_WAY_MEAN_VALUE
}

/// The error for `--sky`. It names one file, once: the one that `e` names, such as a face of a cube, otherwise the panorama.
fn sky_error(panorama: &str, e: &ImageError) -> SessionError {
    let (file, reason) = e.file_and_reason();
    SessionError::File { path: echo(file.unwrap_or(panorama)), why: format!("--sky: {reason}") }
}

/// Reads the panorama that the option `--sky` names, and adds its texels to the map store; `None` without a path.
///
/// # Errors
/// The file that cannot be read, and why.
pub(super) fn read_sky(
    path: Option<&Path>,
    frame: SkyFrame,
    maps: &MapStore,
    max_megapixels: Option<u32>,
) -> Result<Option<SkyMap>, SessionError> {
    let Some(path) = path else { return Ok(None) };
    let name = path.display().to_string();
    let panorama = read_panorama(path, max_megapixels).map_err(|e| sky_error(&name, &e))?;
    let mean = luminance(panorama.texture.mean_over_sphere());
    let unit_radiance = match panorama.unit_cd_m2 {
        Some(cd_m2) => cd_m2 / CD_M2_PER_RADIANCE,
        None => default_mean_radiance() / mean.max(1e-6),
    };
    // The map store's name of the panorama, which no map of a catalog can have.
    let file = format!("--sky {name}");
    let width = panorama.texture.levels[0].width;
    maps.insert(&file, SKY_DECODING, panorama.texture);
    let bright = panorama.bright.map(|bright| {
        let bright_file = format!("{file}, bright values");
        maps.insert(&bright_file, SKY_DECODING, bright.texture);
        BrightSkyMap { file: bright_file, unit_radiance: bright.unit_cd_m2 / CD_M2_PER_RADIANCE }
    });
    // An upper bound: what exceeds it is in `bright`.
    let brightest_value = 1.0;
    Ok(Some(SkyMap { file, frame, width, unit_radiance, brightest_value, bright, is_milky_way: false }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_its_file_once() {
        let reason = "cut short".to_owned();
        for (error, line) in [
            (ImageError::Unreadable { name: "px.png".into(), reason }, "px.png: --sky: not an image that can be read: cut short"),
            (
                ImageError::TooLarge { name: "sky.exr".into(), width: 20_000, height: 10_000, max_megapixels: 64 },
                "sky.exr: --sky: 20000 x 10000 pixels are 200 megapixels, more than 64; --max-megapixels 200 allows them",
            ),
            (ImageError::Damaged("no end".into()), "sky: --sky: not a whole image: no end"),
        ] {
            assert_eq!(sky_error("sky", &error).to_string(), line);
            // What `ImageError` shows by itself is the same with its file in front.
            assert!(error.to_string().ends_with(&error.file_and_reason().1), "{error}");
        }
    }
}
