//! Panoramas of the entire sky: one equirectangular image, or the six faces of a cube, as one texture.
//!
//! In: a PNG, JPEG or EXR; or a folder of six faces, or a file pattern in which `*` stands for a face's name. Out: an equirectangular texture, longitude 0
//! in the middle and increasing to the left, north up, and the *unit*: the luminance that the texel value 1 represents. The values of an EXR are taken to
//! be in cd/m². Always: a texture is 8-bit sRGB, which every device can filter. One texture spans 3.5 decades of linear light (its first step is
//! 1 / 255 / 12.92), too few for an EXR with stars. So what exceeds the value 1 is in a second texture, to be added to the first. Together they span seven
//! decades below the brightest value.
//!
//! Cube faces are named `px`, `nx`, `py`, `ny`, `pz`, `nz` as for a cube map seen from inside: `pz` has longitude 0 at its centre, `px` is to its right, `py`
//! contains the north pole. Upright are `px`, `nx`, `pz`, `nz`; `py` and `ny` adjoin `pz` with their lower and upper edge.

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
/// Smallest number of samples per texel of a face, along each axis. With 2, the light of a single texel of a face is right to 7 %, at the face's edge to 14 %.
const SAMPLES_PER_FACE_TEXEL: f64 = 2.0;
/// Fraction of an EXR's pixels, the brightest ones, that exceed the unit unless one of the two limits below applies.
const BRIGHT_FRACTION: f64 = 1e-4;
/// Largest unit as a multiple of the median: the steps of 8-bit sRGB are 6 % at a hundredth of the unit.
const MAX_UNIT_PER_MEDIAN: f32 = 100.0;
/// Smallest unit as a fraction of the maximum: about the first step of the second texture, 1 / 255 / 12.92. With a smaller unit, values between the first
/// texture's maximum and this step would be lost.
const MIN_UNIT_PER_MAXIMUM: f32 = 3e-4;

/// A panorama.
#[derive(Clone, Debug)]
pub struct Panorama {
    /// The equirectangular image.
    pub texture: Texture,
    /// Luminance that the texel value 1 represents, cd/m²; `None` unless the file holds linear floats: 8-bit values have no unit.
    pub unit_cd_m2: Option<f64>,
    /// The excess over the texel value 1, to be added to `texture`; `None` if no value exceeds 1.
    pub bright: Option<PanoramaExcess>,
}

/// What exceeds the value 1 of a panorama's texture.
#[derive(Clone, Debug)]
pub struct PanoramaExcess {
    pub texture: Texture,
    /// Luminance that the texel value 1 represents, cd/m².
    pub unit_cd_m2: f64,
}

/// The error of a file that cannot be used.
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
    linear_panorama(path, LinearImage::from_cube(&faces, SAMPLES_PER_FACE_TEXEL))
}

/// Path of a face of the cube: of the pattern `path`, or in the folder `path`.
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

    /// Resamples six faces to an equirectangular image. `samples_per_face_texel`: see [`SAMPLES_PER_FACE_TEXEL`].
    fn from_cube(faces: &[Self], samples_per_face_texel: f64) -> Self {
        let side = faces[0].width;
        let width = (4 * side).min(MAX_WIDTH_FROM_CUBE);
        let height = width / 2;
        // Latitude, radians, at a position in the panorama, texels.
        let latitude_at = |y: f64| PI * (0.5 - y / height as f64);
        // As `cube_face`; sine and cosine of the latitude and of the longitude.
        let on_face = |[sin_latitude, cos_latitude]: [f64; 2], [sin_longitude, cos_longitude]: [f64; 2]| {
            let (forward, left, up) = (cos_latitude * cos_longitude, cos_latitude * sin_longitude, sin_latitude);
            cube_face(DVec3::new(-left, up, forward))
        };
        let sin_cos = |angle: f64| <[f64; 2]>::from(angle.sin_cos());
        // Longitudes are sums of that of a column's left edge and an offset in it. Their sines and cosines follow from tables by the addition theorem.
        let edges: Vec<[f64; 2]> = (0..width).map(|column| sin_cos(TAU * (0.5 - column as f64 / width as f64))).collect();
        let offset_at = |x: f64| sin_cos(TAU * x / width as f64);
        let sample_count =
            |length_rad: f64, face_texel_rad: f64| (samples_per_face_texel * length_rad / face_texel_rad).ceil().max(1.0) as usize;
        // At a face's corner, where 1 + r² (below) is 3.
        let max_count = sample_count(TAU / width as f64, 2.0 / side as f64 / 3.0);
        let offsets_of_all: Vec<Vec<[f64; 2]>> =
            (0..=max_count).map(|count| (0..count).map(|k| offset_at((k as f64 + 0.5) / count as f64)).collect()).collect();
        // The longitude decreases to the right.
        let before = |[sin, cos]: [f64; 2], [sin_offset, cos_offset]: [f64; 2]| {
            [sin * cos_offset - cos * sin_offset, cos * cos_offset + sin * sin_offset]
        };
        let middle_of_column = offset_at(0.5);
        // The mean of the faces over the area of the panorama's texel `k`. As angles, a face's texels are up to three times narrower at its corners than in its
        // middle, so the number of samples depends on the place.
        let texel = |k: usize| {
            let (column, row) = (k % width, (k / width) as f64);
            let [sin_latitude, cos_latitude] = sin_cos(latitude_at(row + 0.5));
            let (_, middle) = on_face([sin_latitude, cos_latitude], before(edges[column], middle_of_column));
            // Angular width of the face's texel there in the direction in which it is narrowest: a length dr at distance r from the middle of a face at
            // distance 1 spans dr / (1 + r²).
            let face_texel_rad = 2.0 / side as f64 / (1.0 + middle.length_squared());
            let samples = |length_rad: f64| sample_count(length_rad, face_texel_rad).min(max_count);
            let (columns, rows) = (samples(TAU / width as f64 * cos_latitude), samples(PI / height as f64));
            let offsets = &offsets_of_all[columns];
            let mut sum = Vec3::ZERO;
            for sample_row in 0..rows {
                let latitude = sin_cos(latitude_at(row + (sample_row as f64 + 0.5) / rows as f64));
                for offset in offsets {
                    let (face, position) = on_face(latitude, before(edges[column], *offset));
                    sum += faces[face].sample((position * 0.5 + 0.5) * side as f64);
                }
            }
            (sum / (columns * rows) as f32).to_array()
        };
        let values = (0..width * height).into_par_iter().flat_map_iter(texel).collect();
        Self { width, height, values, was_linear: faces.iter().all(|f| f.was_linear) }
    }

    /// The value that becomes the texel value 1, and the largest value; both 1 for an 8-bit or a black image.
    fn unit_and_maximum(&self) -> (f32, f32) {
        if !self.was_linear {
            return (1.0, 1.0);
        }
        // The brightest channel of each pixel.
        let mut maxima: Vec<f32> = self.values.as_chunks::<3>().0.iter().map(|t| Vec3::from_array(*t).max_element()).collect();
        let mut quantile = |fraction: f64| {
            let index = ((maxima.len() as f64 * fraction) as usize).min(maxima.len() - 1);
            *maxima.select_nth_unstable_by(index, f32::total_cmp).1
        };
        let (median, bright, maximum) = (quantile(0.5), quantile(1.0 - BRIGHT_FRACTION), quantile(1.0));
        let unit = bright.min(MAX_UNIT_PER_MEDIAN * median).max(MIN_UNIT_PER_MAXIMUM * maximum);
        if unit > 0.0 { (unit, maximum) } else { (1.0, 1.0) }
    }

    /// The image, its linear values converted by `value_of` and clamped to [0, 1], as opaque 8-bit sRGB.
    fn encoded(&self, value_of: impl Fn(f32) -> f32 + Sync) -> Vec<u8> {
        let encode = |v: f32| (linear_to_srgb(f64::from(value_of(v).clamp(0.0, 1.0))) * 255.0).round() as u8;
        self.values.as_chunks::<3>().0.par_iter().flat_map_iter(|[r, g, b]| [encode(*r), encode(*g), encode(*b), 255]).collect()
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

/// The panorama of an image in linear light.
fn linear_panorama(path: &Path, image: LinearImage) -> Result<Panorama, ImageError> {
    let (unit, maximum) = image.unit_and_maximum();
    let texels = image.encoded(|v| v / unit);
    let excess = maximum - unit;
    let bright_texels = (excess > 0.0).then(|| image.encoded(|v| (v - unit) / excess));
    let (size, was_linear) = ((image.width as u32, image.height as u32), image.was_linear);
    // The floats may take gigabytes; the mip chains below need memory of their own.
    drop(image);
    let bright = match bright_texels {
        Some(texels) => Some(PanoramaExcess { texture: with_mips(path, size, texels)?, unit_cd_m2: f64::from(excess) }),
        None => None,
    };
    Ok(Panorama { texture: with_mips(path, size, texels)?, unit_cd_m2: was_linear.then_some(f64::from(unit)), bright })
}

/// The panorama of an image in sRGB, whose bytes are kept: decoding to linear light and back would take twice the memory and time.
fn srgb_panorama(path: &Path, image: DynamicImage) -> Result<Panorama, ImageError> {
    let mut rgba = image.into_rgba8();
    // A sky is opaque.
    rgba.pixels_mut().for_each(|p| p.0[3] = 255);
    Ok(Panorama { texture: with_mips(path, rgba.dimensions(), rgba.into_raw())?, unit_cd_m2: None, bright: None })
}

/// The texture of sRGB texels, with its mip chain. `PoleFilter::Values`: rows near the poles are filtered, as in maps.
fn with_mips(path: &Path, (width, height): (u32, u32), rgba: Vec<u8>) -> Result<Texture, ImageError> {
    let decoding = MapDecoding { poles: PoleFilter::Values, ..MapDecoding::plain(TexelFormat::Rgba8Srgb) };
    Texture::with_decoding(width, height, rgba, decoding, RowThreads::All).map_err(|e| unreadable(path, e.to_string()))
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
        // In the order of `FACES`: the direction of the position (s, t) of a face, from -1 to 1 to the right and down.
        let directions = [
            |s: f64, t: f64| DVec3::new(1.0, -t, -s),
            |s: f64, t: f64| DVec3::new(-1.0, -t, s),
            |s: f64, t: f64| DVec3::new(s, 1.0, t),
            |s: f64, t: f64| DVec3::new(s, -1.0, -t),
            |s: f64, t: f64| DVec3::new(s, -t, 1.0),
            |s: f64, t: f64| DVec3::new(-s, -t, -1.0),
        ];
        let middle = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
        let face = |direction: fn(f64, f64) -> DVec3| {
            let values = (0..side * side).flat_map(|k| paint(direction(middle(k % side), middle(k / side))).to_array()).collect();
            LinearImage { width: side, height: side, values, was_linear: false }
        };
        let faces: Vec<LinearImage> = directions.map(face).into();
        let sky = LinearImage::from_cube(&faces, SAMPLES_PER_FACE_TEXEL);
        assert_eq!((sky.width, sky.height), (256, 128));
        for (x, y, d) in [
            (128, 64, DVec3::Z),
            (64, 64, DVec3::NEG_X),
            (192, 64, DVec3::X),
            (0, 64, DVec3::NEG_Z),
            (9, 0, DVec3::Y),
            (77, 127, DVec3::NEG_Y),
        ] {
            // Over one texel the colour changes by up to pi / 256 = 0.012.
            let difference = (sky.texel(x, y) - paint(d)).abs().max_element();
            assert!(difference < 0.02, "{x}, {y}: {difference}");
        }
    }

    /// Single texels of a cube's face keep their light, in its middle and at its edges and corners.
    #[test]
    fn a_cube_keeps_the_light_of_stars() {
        let side = 48_usize;
        // Light (radiance times solid angle) in the panorama over that in the cube, for a star that fills the texel (x, y) of the face pz.
        let kept = |x: usize, y: usize, samples_per_face_texel: f64| {
            let mut faces: Vec<LinearImage> =
                (0..6).map(|_| LinearImage { width: side, height: side, values: vec![0.0; 3 * side * side], was_linear: true }).collect();
            faces[4].values[3 * (y * side + x)] = 1.0;
            let sky = LinearImage::from_cube(&faces, samples_per_face_texel);
            let texel_rad = PI / sky.height as f64;
            let texel_sr = |k: usize| (((k / sky.width) as f64 + 0.5) * texel_rad).sin() * texel_rad.powi(2);
            let light: f64 = (0..sky.width * sky.height).map(|k| f64::from(sky.values[3 * k]) * texel_sr(k)).sum();
            let middle = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
            let star_sr = (2.0 / side as f64).powi(2) / (1.0 + middle(x).powi(2) + middle(y).powi(2)).powf(1.5);
            light / star_sr
        };
        let stars: Vec<(usize, usize)> = (1..side - 1).step_by(5).flat_map(|y| [(1, y), (2, y), (24, y), (45, y + 1)]).collect();
        let worst = |samples: f64| stars.iter().map(|(x, y)| (kept(*x, *y, samples) - 1.0).abs()).fold(0.0, f64::max);
        // 10 %: the 7 % of `SAMPLES_PER_FACE_TEXEL`, and a margin.
        let (averaged, single) = (worst(SAMPLES_PER_FACE_TEXEL), worst(0.0));
        assert!(averaged < 0.1, "{averaged}");
        assert!(single > 0.2, "negative control, one sample per texel: {single}");
    }

    /// Both a faint sky and a few pixels 10,000 times as bright are in the textures of an EXR, however many pixels are bright.
    #[test]
    fn an_exr_keeps_its_faint_and_its_bright_values() {
        let linear = |level: u8| crate::units::srgb_to_linear(f64::from(level) / 255.0);
        // `BRIGHT_FRACTION` of the pixels are 52.
        for bright_pixels in [0, 1, 48, 60, 3000] {
            let (width, height) = (1024, 512);
            let mut values = vec![1e-3_f32; 3 * width * height];
            values[..3 * bright_pixels].fill(10.0);
            let image = LinearImage { width, height, values, was_linear: true };
            let sky = linear_panorama(Path::new("sky.exr"), image).expect("a panorama");
            let (faint, unit) = (sky.texture.levels[0].bytes(), sky.unit_cd_m2.expect("a unit"));
            assert_eq!(sky.bright.is_some(), bright_pixels > 0, "{bright_pixels}");
            // Luminance of a texel's red. The rows at the poles are filtered, so the faint sky is read at the equator.
            let at = |k: usize| linear(faint[4 * k]) * unit;
            let equator = at(width * height / 2);
            // 4 %: the steps of 8 bits are 6 % at a hundredth of the unit; half a step, and a margin.
            assert!((equator / 1e-3 - 1.0).abs() < 0.04, "{bright_pixels}: {equator}");
            if let Some(bright) = &sky.bright {
                let largest = |bytes: &[u8]| linear(bytes.iter().step_by(4).copied().max().unwrap_or(0));
                // Negative control: in the first texture alone the bright pixels have a hundredth of their 10 cd/m².
                assert!(largest(faint) * unit < 0.2, "{bright_pixels}");
                let bytes = bright.texture.levels[0].bytes();
                // Both units add up to the maximum; the faint sky adds nothing to the second texture.
                assert!(bright.unit_cd_m2 + unit > 9.99 && bytes[4 * (width * height / 2)] == 0, "{bright_pixels}");
                // 3000 bright pixels fill two rows, whose values the filter at the pole leaves unchanged.
                assert!(bright_pixels < 3000 || largest(bytes) > 0.99, "{bright_pixels}");
            }
        }
    }
}
