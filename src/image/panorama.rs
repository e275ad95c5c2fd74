//! Panoramas of the entire sky: one equirectangular image, or the six faces of a cube, as one texture.
//!
//! In: a PNG, JPEG or EXR; or a folder of six faces, or a file pattern in which `*` stands for a face's name. Out: an equirectangular texture, longitude 0
//! in the middle and increasing to the left, north up, and the luminance that the texel value 1 represents. The values of an EXR are taken to
//! be in cd/m². Always: the texture is 8-bit sRGB, which every device can filter; the brightest ten-thousandth of an EXR's pixels is clipped.
//!
//! Cube faces are named `px`, `nx`, `py`, `ny`, `pz`, `nz` as for a cube map seen from inside: `pz` has longitude 0 at its centre, `px` is to its right, `py`
//! contains the north pole.

use super::mips::RowThreads;
use super::{DEFAULT_MAX_MEGAPIXELS, ImageError, MAX_FILE_BYTES, MAX_MAP_SIDE, MapDecoding, PoleFilter, TexelFormat, Texture, decode_any};
use crate::files::read_bytes;
use crate::units::linear_to_srgb;
use glam::{DVec2, DVec3, Vec3};
use image::{DynamicImage, ImageFormat};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// Formats of a panorama or a face.
const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::OpenExr];
/// Usual file extensions of these formats.
const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "exr"];
/// Names of the faces, in the order of the indices that [`cube_face`] returns.
const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];
/// Largest width of a panorama that is made from a cube, texels.
const MAX_WIDTH_FROM_CUBE: usize = 8192;
/// Fraction of an EXR's pixels that are brighter than the texel value 1, and are therefore clipped.
const CLIPPED_FRACTION: f64 = 1e-4;

/// A panorama.
#[derive(Clone, Debug)]
pub struct Panorama {
    /// The equirectangular image.
    pub texture: Texture,
    /// Luminance that the texel value 1 represents, cd/m²; `None` unless the file holds linear floats: 8-bit values have no unit.
    pub unit_cd_m2: Option<f64>,
}

fn unreadable(path: &Path, reason: impl Into<String>) -> ImageError {
    ImageError::Unreadable { name: path.display().to_string(), reason: reason.into() }
}

/// Reads a panorama. `max_megapixels`: limit on the size of the image, or of the six faces together; `None` for [`DEFAULT_MAX_MEGAPIXELS`].
///
/// # Errors
/// One line with the file's name and the reason why it cannot be read.
pub fn read_panorama(path: &Path, max_megapixels: Option<u32>) -> Result<Panorama, ImageError> {
    let read = |path: &Path| {
        let bytes = read_bytes(path, MAX_FILE_BYTES).map_err(|e| unreadable(path, e.to_string()))?;
        decode_any(&path.display().to_string(), &bytes, &FORMATS, max_megapixels.unwrap_or(DEFAULT_MAX_MEGAPIXELS), MAX_MAP_SIDE)
    };
    let is_pattern = path.file_name().is_some_and(|name| name.to_string_lossy().contains('*'));
    if !is_pattern && !path.is_dir() {
        let image = read(path)?;
        let (width, height) = (image.width(), image.height());
        if width.abs_diff(2 * height) > 1 {
            return Err(unreadable(
                path,
                format!("{width}x{height} pixels are not a whole sky: an equirectangular panorama is twice as wide as high"),
            ));
        }
        return if is_linear(&image) { linear_panorama(path, LinearImage::of(image)) } else { srgb_panorama(path, image) };
    }
    let faces = FACES.map(|face| face_path(path, face));
    let mut decoded = Vec::new();
    for face in faces {
        let face = face?;
        let image = read(&face)?;
        let common_side = decoded.first().map_or(image.width(), |f: &DynamicImage| f.width());
        if image.width() != image.height() || image.width() != common_side {
            let reason = format!("{}x{} pixels: the six faces must be squares of one size", image.width(), image.height());
            return Err(unreadable(&face, reason));
        }
        let (side, max_total) = (u64::from(image.width()), u64::from(max_megapixels.unwrap_or(DEFAULT_MAX_MEGAPIXELS)));
        let total_megapixels = (6 * side * side).div_ceil(1_000_000);
        if total_megapixels > max_total {
            let reason = format!(
                "six faces of {side}x{side} pixels are {total_megapixels} megapixels, more than {max_total}; --max-megapixels {total_megapixels} allows them"
            );
            return Err(unreadable(&face, reason));
        }
        if decoded.first().is_some_and(|first| is_linear(first) != is_linear(&image)) {
            return Err(unreadable(
                &face,
                "the values of an EXR are luminances, those of a PNG or JPEG are not: all six faces must be of one kind",
            ));
        }
        decoded.push(image);
    }
    let faces: Vec<LinearImage> = decoded.into_iter().map(LinearImage::of).collect();
    linear_panorama(path, LinearImage::from_cube(&faces))
}

/// Path of a face of the cube.
fn face_path(path: &Path, face: &str) -> Result<PathBuf, ImageError> {
    if let Some(name) = path.file_name().map(|n| n.to_string_lossy()).filter(|n| n.contains('*')) {
        return Ok(path.with_file_name(name.replacen('*', face, 1)));
    }
    let existing = EXTENSIONS.iter().map(|extension| path.join(format!("{face}.{extension}"))).find(|p| p.is_file());
    existing.ok_or_else(|| unreadable(path, format!("no {face}.png, .jpg or .exr in it; a cube map has the faces {}", FACES.join(", "))))
}

/// Whether the file held linear floats, as an EXR does.
fn is_linear(image: &DynamicImage) -> bool {
    matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_))
}

/// An image in linear light.
struct LinearImage {
    width: usize,
    height: usize,
    /// Red, green and blue of each texel: flat, as the decoder returns them, so that a large file is not copied.
    values: Vec<f32>,
    /// Whether the file held linear floats.
    was_linear: bool,
}

impl LinearImage {
    /// Converts to linear light; floats that are negative or not finite become 0.
    fn of(image: DynamicImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let was_linear = is_linear(&image);
        let values = if was_linear {
            let mut values = image.into_rgb32f().into_raw();
            values.iter_mut().for_each(|v| *v = if v.is_finite() { v.max(0.0) } else { 0.0 });
            values
        } else {
            let table: Vec<f32> = (0..=255).map(|i| crate::units::srgb_to_linear(f64::from(i) / 255.0) as f32).collect();
            image.into_rgb8().into_raw().into_iter().map(|b| table[usize::from(b)]).collect()
        };
        Self { width, height, values, was_linear }
    }

    fn texel(&self, x: usize, y: usize) -> Vec3 {
        Vec3::from_slice(&self.values[3 * (y * self.width + x)..])
    }

    /// Bilinear interpolation between texel centres, clamped at the edges. `position`: texels right of and below the top left corner.
    fn sample(&self, position: DVec2) -> Vec3 {
        let p = (position - 0.5).clamp(DVec2::ZERO, DVec2::new((self.width - 1) as f64, (self.height - 1) as f64));
        let (x, y) = (p.x as usize, p.y as usize);
        let (x1, y1) = ((x + 1).min(self.width - 1), (y + 1).min(self.height - 1));
        let row = |y: usize| self.texel(x, y).lerp(self.texel(x1, y), p.x.fract() as f32);
        row(y).lerp(row(y1), p.y.fract() as f32)
    }

    /// Resamples six faces to an equirectangular image.
    fn from_cube(faces: &[Self]) -> Self {
        let side = faces[0].width;
        let width = (4 * side).min(MAX_WIDTH_FROM_CUBE);
        let height = width / 2;
        let texel = |k: usize| {
            let longitude = TAU * (0.5 - ((k % width) as f64 + 0.5) / width as f64);
            let latitude = PI * (0.5 - ((k / width) as f64 + 0.5) / height as f64);
            let (forward, left, up) = (latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
            let (face, position) = cube_face(DVec3::new(-left, up, forward));
            faces[face].sample((position * 0.5 + 0.5) * side as f64).to_array()
        };
        let values = (0..width * height).into_par_iter().flat_map_iter(texel).collect();
        Self { width, height, values, was_linear: faces.iter().all(|f| f.was_linear) }
    }
}

/// The face that a direction (right, up, forward) hits, as an index into [`FACES`], and the position on it: -1 to 1, to the right and down as
/// seen from inside.
fn cube_face(d: DVec3) -> (usize, DVec2) {
    let magnitude = d.abs();
    if magnitude.x >= magnitude.y && magnitude.x >= magnitude.z {
        let sign = d.x.signum();
        (usize::from(sign < 0.0), DVec2::new(-d.z * sign, -d.y) / magnitude.x)
    } else if magnitude.y >= magnitude.z {
        let sign = d.y.signum();
        (2 + usize::from(sign < 0.0), DVec2::new(d.x, d.z * sign) / magnitude.y)
    } else {
        let sign = d.z.signum();
        (4 + usize::from(sign < 0.0), DVec2::new(d.x * sign, -d.y) / magnitude.z)
    }
}

/// The panorama of an image in linear light. The texel value 1 is the image value 1 or, for an EXR, the value that [`CLIPPED_FRACTION`] of its pixels exceed.
fn linear_panorama(path: &Path, image: LinearImage) -> Result<Panorama, ImageError> {
    // The value of the image that becomes the texel value 1.
    let unit = if image.was_linear {
        // The brightest channel of each pixel.
        let mut maxima: Vec<f32> = image.values.as_chunks::<3>().0.iter().map(|t| Vec3::from_array(*t).max_element()).collect();
        let index = ((maxima.len() as f64 * (1.0 - CLIPPED_FRACTION)) as usize).min(maxima.len() - 1);
        let (_, unit, _) = maxima.select_nth_unstable_by(index, f32::total_cmp);
        if *unit > 0.0 { *unit } else { 1.0 }
    } else {
        1.0
    };
    let encode = |v: f32| (linear_to_srgb(f64::from((v / unit).clamp(0.0, 1.0))) * 255.0).round() as u8;
    let texels = image.values.as_chunks::<3>().0;
    let bytes: Vec<u8> = texels.par_iter().flat_map_iter(|[r, g, b]| [encode(*r), encode(*g), encode(*b), 255]).collect();
    let (size, unit_cd_m2) = ((image.width as u32, image.height as u32), image.was_linear.then_some(f64::from(unit)));
    drop(image);
    with_mips(path, size, bytes, unit_cd_m2)
}

/// The panorama of an image in sRGB, whose bytes are kept: decoding to linear light and back would take twice the memory and time.
fn srgb_panorama(path: &Path, image: DynamicImage) -> Result<Panorama, ImageError> {
    let mut rgba = image.into_rgba8();
    rgba.pixels_mut().for_each(|p| p.0[3] = 255);
    let unit_cd_m2 = None;
    with_mips(path, rgba.dimensions(), rgba.into_raw(), unit_cd_m2)
}

/// The panorama of encoded texels, with its mip chain.
fn with_mips(path: &Path, (width, height): (u32, u32), rgba: Vec<u8>, unit_cd_m2: Option<f64>) -> Result<Panorama, ImageError> {
    let decoding = MapDecoding { poles: PoleFilter::Values, ..MapDecoding::plain(TexelFormat::Rgba8Srgb) };
    let texture = Texture::with_decoding(width, height, rgba, decoding, RowThreads::All);
    Ok(Panorama { texture: texture.map_err(|e| unreadable(path, e.to_string()))?, unit_cd_m2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For each direction, the face that it hits and the position on this face, by the arrangement that the head of the module states.
    #[test]
    fn faces_are_arranged_as_in_a_cube_map() {
        for (d, face, position) in [
            ((0.0, 0.0, 1.0), 4, (0.0, 0.0)),
            ((1.0, 0.0, 0.0), 0, (0.0, 0.0)),
            // Right of the centre of pz is px, whose left edge adjoins pz.
            ((0.5, 0.0, 1.0), 4, (0.5, 0.0)),
            ((1.0, 0.0, 0.5), 0, (-0.5, 0.0)),
            ((-1.0, 0.0, 0.5), 1, (0.5, 0.0)),
            ((0.0, 1.0, 0.5), 2, (0.0, 0.5)),
            ((0.0, -1.0, 0.5), 3, (0.0, -0.5)),
            ((0.5, 0.0, -1.0), 5, (-0.5, 0.0)),
            ((0.0, 0.5, 1.0), 4, (0.0, -0.5)),
        ] {
            assert_eq!(cube_face(d.into()), (face, position.into()), "{d:?}");
        }
    }

    /// If faces of both kinds were mixed, luminances of an EXR would be clipped at the white of the 8-bit faces.
    #[test]
    fn faces_with_and_without_a_unit_are_not_mixed() {
        let folder = tempfile::tempdir().expect("a folder");
        let image = DynamicImage::ImageRgb32F(image::Rgb32FImage::from_pixel(4, 4, image::Rgb([3.0, 2.0, 1.0])));
        for face in FACES {
            let path = folder.path().join(format!("{face}.exr"));
            image.save(path).expect("written");
        }
        let default_limit = None;
        assert!(read_panorama(folder.path(), default_limit).is_ok_and(|p| p.unit_cd_m2.is_some()));
        image.to_rgb8().save(folder.path().join("ny.png")).expect("written");
        std::fs::remove_file(folder.path().join("ny.exr")).expect("removed");
        let error = read_panorama(folder.path(), default_limit).expect_err("mixed").to_string();
        assert!(error.contains("ny.png") && error.contains("of one kind"), "{error}");
    }

    /// A cube painted as a function of direction becomes the same panorama: north up, longitude increasing to the left.
    #[test]
    fn a_cube_becomes_its_panorama() {
        let side = 64_usize;
        let paint = |d: DVec3| (d.normalize() * 0.5 + 0.5).as_vec3();
        let axes = [
            |s: f64, t: f64| DVec3::new(1.0, -t, -s),
            |s: f64, t: f64| DVec3::new(-1.0, -t, s),
            |s: f64, t: f64| DVec3::new(s, 1.0, t),
            |s: f64, t: f64| DVec3::new(s, -1.0, -t),
            |s: f64, t: f64| DVec3::new(s, -t, 1.0),
            |s: f64, t: f64| DVec3::new(-s, -t, -1.0),
        ];
        let middle = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
        let face = |axis: fn(f64, f64) -> DVec3| {
            let values = (0..side * side).flat_map(|k| paint(axis(middle(k % side), middle(k / side))).to_array()).collect();
            LinearImage { width: side, height: side, values, was_linear: false }
        };
        let faces: Vec<LinearImage> = axes.map(face).into();
        let sky = LinearImage::from_cube(&faces);
        assert_eq!((sky.width, sky.height), (256, 128));
        for (x, y, d) in [
            (128, 64, DVec3::Z),
            (64, 64, DVec3::NEG_X),
            (192, 64, DVec3::X),
            (0, 64, DVec3::NEG_Z),
            (9, 0, DVec3::Y),
            (77, 127, DVec3::NEG_Y),
        ] {
            let difference = (sky.texel(x, y) - paint(d)).abs().max_element();
            assert!(difference < 0.02, "{x}, {y}: {difference}");
        }
    }
}
