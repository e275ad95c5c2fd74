//! The provenance of an image: a record of its request and inputs that is written into the file, so that an interrupted sequence resumes only with its
//! own files.
//!
//! In: a view request, and the sources from which the session draws it. Out: a [`Provenance`], named values as one line of JSON; for an existing file,
//! whether it is complete and to which request it belongs. Always: the provenance depends on every field of a request, on every catalog, map, kernel and
//! fragment that can change the image, and on the precision of the software renderer. It does not depend on the clock, on paths, on the number of threads
//! or on the cache folder. Two builds of the same version have different provenances only if their catalogs or shaders differ. If either the GPU or the
//! software renderer may draw, the provenance does not say which one drew.

use super::images::{PROVENANCE_CHUNK, is_exr};
use super::{Session, Sources};
use crate::catalog::{Body, Catalog, DataLayer, NaifId};
use crate::files::is_there;
use crate::image::{
    AnimationFormat, TEXT_SEARCH_BYTES, animation_format, exr_text_in_head, gif_text_in_head, png_text_in_head, verify_exr, verify_png,
};
use crate::render::plan::SKY_DECODING;
use crate::scene::request::{Axes, ExposureRequest, Look, Position, Telescope, Up, ViewRequest};
use crate::scene::sky::map::{MILKY_WAY_FILE, SkyMap};
use crate::shader::generator;
use crate::wording::echo_within;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// All values that determine the pixels of an image, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance(BTreeMap<String, String>);

/// The file, if any, that already exists at the path of an image that is to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExistingImage {
    /// There is no file.
    None,
    /// A complete file with the same provenance.
    Same,
    /// A file of another request. The text lists the first three differing fields: for each its name, the file's value and this request's value, as in
    /// `size 64x64, not 32x32`; then the number of the others.
    Other(String),
    /// The provenance matches, but the file is not a complete image of this size. The text gives the reason.
    Damaged(String),
    /// No provenance can be read: the path is not that of a readable file, or the file has none. The text gives the reason.
    Unknown(String),
}

/// The first 8 bytes of the SHA-256 of the parts, each preceded by its length, as hexadecimal digits.
fn hex_digest(parts: impl IntoIterator<Item = Vec<u8>>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    generator::hex(&hash.finalize()[..8])
}

/// The first 8 bytes of a file's SHA-256 as hexadecimal digits, or `none` if the file cannot be read.
fn file_digest(path: &Path) -> String {
    // A pipe or a device would never end.
    if !path.is_file() {
        return "none".into();
    }
    let read = || -> std::io::Result<String> {
        let (mut file, mut hash, mut block) = (BufReader::new(File::open(path)?), Sha256::new(), vec![0; 1 << 20]);
        loop {
            match file.read(&mut block)? {
                0 => return Ok(generator::hex(&hash.finalize()[..8])),
                n => hash.update(&block[..n]),
            }
        }
    };
    read().unwrap_or_else(|_| "none".into())
}

/// The first bytes of a file, at most `max_bytes`.
fn read_head(path: &Path, max_bytes: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    File::open(path).and_then(|f| f.take(max_bytes).read_to_end(&mut bytes)).map(|_| bytes).map_err(|e| e.to_string())
}

/// Digests of the files from which a session draws: its catalog, and the files of the sources with which it was opened.
fn source_digests(catalog: &Catalog, sources: &Sources) -> BTreeMap<String, String> {
    // The citations of values (`Body::sources`) are left out, because they change no image.
    let bodies = catalog.bodies().iter().map(|b| format!("{:?}", Body { sources: BTreeMap::new(), ..b.clone() }).into_bytes());
    let instruments = catalog.instruments().iter().map(|i| format!("{i:?}").into_bytes());
    let files = catalog.bodies().iter().flat_map(|b| {
        let maps = [&b.maps.albedo, &b.maps.normal, &b.maps.specular, &b.maps.night].into_iter().flatten().map(|m| m.file.as_str());
        let clouds = b.clouds.iter().map(|c| c.map.file.as_str());
        maps.chain(clouds).chain(b.overlays.iter().map(|o| o.file.as_str())).chain(b.mesh.iter().map(|m| m.file.as_str()))
    });
    let files = files.chain([MILKY_WAY_FILE]);
    // If several folders have a file of this name, the session reads the first one.
    let found = files.filter_map(|name| Some((name, sources.map_and_mesh_folders().map(|f| f.join(name)).find(|path| is_there(path))?)));
    let digests: BTreeMap<&str, String> = found.map(|(name, path)| (name, file_digest(&path))).collect();
    let maps_and_meshes =
        if digests.is_empty() { "embedded".into() } else { hex_digest(digests.iter().map(|(n, d)| format!("{n} {d}").into_bytes())) };
    let entry = |name: &str, value: String| (name.to_owned(), value);
    let file = |path: &Option<PathBuf>| path.as_deref().map_or("embedded".into(), file_digest);
    BTreeMap::from([
        entry("program", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
        entry("catalogs", hex_digest(bodies.chain(instruments))),
        entry("kernel", file(&sources.kernel)),
        entry("stars", file(&sources.stars)),
        entry("minor planets", file(&sources.minor_planets)),
        entry("images", maps_and_meshes),
    ])
}

/// The properties that determine how a data layer is drawn; its content is covered by its digest.
fn layer_text(layer: &DataLayer) -> String {
    let DataLayer { name, file, body, size_px, colour, fade_days, style, digest, points: _, lines: _, image: _ } = layer;
    format!("{name} {file} {body:?} {size_px} {colour:?} {fade_days:?} {style:?} {digest}")
}

/// The calendar date and time in a provenance, without the TDB seconds.
fn calendar_time(provenance: &Provenance) -> &str {
    provenance.0.get("time").map_or("", |t| t.split(" (").next().unwrap_or_default())
}

impl Provenance {
    /// The provenance of a request. `digests`: those of everything from which the session draws, by name, as in [`source_digests`].
    pub(super) fn new(catalog: &Catalog, request: &ViewRequest, digests: &BTreeMap<String, String>) -> Self {
        // An id that is no body of the catalog, such as that of a barycentre, is a place with a number.
        let name = |id: NaifId| catalog.body(id).map_or_else(|| format!("place {}", id.0), |b| b.name.clone());
        // Destructured without `..`: a new field of a request does not compile until the provenance covers it.
        let ViewRequest {
            time,
            target,
            position,
            look,
            up,
            is_mirrored,
            composition,
            fov_deg,
            width,
            height,
            exposure,
            tone_map,
            effects,
            layers,
            telescope,
            stars_boost_stops,
            selected,
            quality,
            pixel_view,
            purpose,
            language,
            may_use_coarse_air,
        } = request;
        // For a value that the request leaves to the program.
        let default_text = || "as usual".to_owned();
        let axes_name = |axes: &Axes| match axes {
            Axes::Icrf => "ICRF",
            Axes::BodyFixed => "body-fixed",
        };
        let from = match position {
            Position::AboveTarget { towards, distance_radii } => {
                let side = towards.map_or_else(default_text, name);
                distance_radii.map_or_else(|| format!("side {side}, fitted"), |d| format!("side {side}, {d} radii"))
            }
            Position::Centre(body) => format!("centre of {}", name(*body)),
            Position::Ground { body, latitude_deg, longitude_deg, height_km } => {
                format!("{} at {latitude_deg},{longitude_deg}, {height_km} km high", name(*body))
            }
            Position::Offset { body, offset_km, axes } => format!("{} + {:?} km {}", name(*body), offset_km.to_array(), axes_name(axes)),
        };
        let look = match look {
            Look::Target => "at the target".into(),
            Look::Along { direction, axes } => format!("{:?} {}", direction.to_array(), axes_name(axes)),
        };
        let up = match up {
            Up::Along { direction, axes } => format!("{:?} {}", direction.to_array(), axes_name(axes)),
            named => format!("{named:?}").to_lowercase(),
        };
        let exposure = match exposure {
            ExposureRequest::Auto => "auto".into(),
            ExposureRequest::Stops(stops) => format!("{stops} stops"),
            ExposureRequest::Transition { from_stops, progress } => format!("{progress} of the way from {from_stops} stops to auto"),
        };
        let entry = |name: &str, value: String| (name.to_owned(), value);
        let mut values = digests.clone();
        values.extend([
            entry("target", target.map_or("none".into(), name)),
            entry("time", format!("{} (TDB {} s past J2000)", time.to_utc_iso(), time.tdb_seconds_past_j2000())),
            entry("from", from),
            entry("look", look),
            entry("up", up),
            entry("mirrored", is_mirrored.to_string()),
            entry("composition", composition.to_text()),
            entry("fov", fov_deg.map_or_else(default_text, |f| format!("{f} deg"))),
            entry("size", format!("{width}x{height}")),
            entry("exposure", exposure),
            entry("tone-map", tone_map.name().into()),
            entry("effects", effects.to_text()),
            entry("layers", layers.to_text()),
            entry("telescope", telescope.map_or("none".into(), Telescope::to_text)),
            entry("stars-boost", format!("{stars_boost_stops} stops")),
            entry("selected", selected.map_or("the target".into(), name)),
            entry("quality", format!("{quality:?}").to_lowercase()),
            entry("pixels", pixel_view.name().into()),
            entry("purpose", format!("{purpose:?}").to_lowercase()),
            entry("language", language.code().into()),
            entry("coarse air", may_use_coarse_air.to_string()),
        ]);
        Self(values)
    }

    /// The provenance of the image that shows the error bounds of this request's image. It differs from `self`, so that neither image passes for the other.
    #[must_use]
    pub fn of_error_bound(mut self) -> Self {
        self.0.insert("content".to_owned(), "bound of the error".to_owned());
        self
    }

    /// The provenance of an animation of these frames: that of the first frame, the number and rate of all, and their digest.
    #[must_use]
    pub fn of_animation(frames: impl IntoIterator<Item = Self>, frames_per_s: impl std::fmt::Display) -> Self {
        let (mut first, mut count) = (None, 0_u32);
        let texts = frames.into_iter().map(|frame| {
            count += 1;
            let text = frame.to_text().into_bytes();
            first.get_or_insert(frame);
            text
        });
        let digest = hex_digest(texts);
        let mut values = first.map_or(BTreeMap::new(), |Self(values)| values);
        values.insert("frames".to_owned(), format!("{count} at {frames_per_s} per second ({digest})"));
        Self(values)
    }

    /// One line of JSON in ASCII, the same bytes for the same provenance.
    pub fn to_text(&self) -> String {
        let json = serde_json::json!(self.0).to_string();
        let utf16_units = |c: char| if c.is_ascii() { vec![c as u16] } else { c.encode_utf16(&mut [0; 2]).to_vec() };
        json.chars().flat_map(utf16_units).map(|u| if u < 0x80 { char::from(u as u8).to_string() } else { format!("\\u{u:04x}") }).collect()
    }

    /// Target, time and size, by which a user recognises the image.
    pub fn target_time_and_size(&self) -> String {
        let value = |name: &str| self.0.get(name).map_or("", String::as_str);
        format!("target {}, time {}, size {}", echo_within(value("target"), 60), calendar_time(self), value("size"))
    }

    fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok().map(Self)
    }

    /// The fields in which two provenances differ, as [`ExistingImage::Other`] lists them.
    fn differences(theirs: &Self, ours: &Self) -> String {
        // The fields that a user knows best come first.
        let best_known = ["target", "time", "from", "size", "effects", "layers", "quality"];
        let names =
            best_known.into_iter().chain(theirs.0.keys().chain(ours.0.keys()).map(String::as_str).filter(|k| !best_known.contains(k)));
        let mut differing: Vec<&str> = Vec::new();
        for name in names.filter(|n| theirs.0.get(*n) != ours.0.get(*n)) {
            if !differing.contains(&name) {
                differing.push(name);
            }
        }
        // Two times that differ only below a millisecond are shown with their TDB seconds.
        let same_calendar_time = calendar_time(theirs) == calendar_time(ours);
        let value = |provenance: &Self, name: &str| match provenance.0.get(name).map(String::as_str) {
            None | Some("") => "none".to_owned(),
            Some(_) if name == "time" && !same_calendar_time => echo_within(calendar_time(provenance), 60),
            Some(text) => echo_within(text, 60),
        };
        let listed = differing.iter().take(3).map(|n| format!("{} {}, not {}", echo_within(n, 20), value(theirs, n), value(ours, n)));
        let more = differing.len().saturating_sub(3);
        listed.chain((more > 0).then(|| format!("and {more} more"))).collect::<Vec<_>>().join("; ")
    }

    /// Compares this provenance with that of the file at the path to which the image or animation is to be written. `Same` says nothing about the rest of the
    /// file.
    pub fn compare_with_file(&self, path: &Path) -> ExistingImage {
        match path.metadata() {
            // A missing or invalid folder is reported when the image is written.
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return ExistingImage::None,
            Err(e) => return ExistingImage::Unknown(e.to_string()),
            Ok(metadata) if !metadata.is_file() => return ExistingImage::Unknown("not a regular file".into()),
            Ok(_) => {}
        }
        let head = match read_head(path, TEXT_SEARCH_BYTES as u64) {
            Ok(head) => head,
            Err(why) => return ExistingImage::Unknown(why),
        };
        let text = match animation_format(path) {
            Some(AnimationFormat::Gif) => gif_text_in_head(&head, PROVENANCE_CHUNK),
            Some(AnimationFormat::Apng) => png_text_in_head(&head, PROVENANCE_CHUNK),
            None if is_exr(path) => exr_text_in_head(&head),
            None => png_text_in_head(&head, PROVENANCE_CHUNK),
        };
        match text.as_deref().and_then(Self::parse) {
            None => ExistingImage::Unknown("the file has no readable provenance".into()),
            Some(theirs) if theirs != *self => ExistingImage::Other(Self::differences(&theirs, self)),
            Some(_) => ExistingImage::Same,
        }
    }

    /// Examines the file at the path to which this image is to be written. `size`: the image's width and height, pixels.
    pub fn examine_existing_image(&self, path: &Path, size: (u32, u32)) -> ExistingImage {
        let compared = self.compare_with_file(path);
        if compared != ExistingImage::Same {
            return compared;
        }
        // An upper bound for an image of this size: per pixel four floats of 4 bytes and 4 bytes of overhead, 64 bytes per row, 1 MiB of texts.
        let max_bytes = u64::from(size.0) * u64::from(size.1) * 20 + u64::from(size.1) * 64 + (1 << 20);
        // A file that was removed meanwhile is reported below.
        if path.metadata().is_ok_and(|metadata| metadata.len() > max_bytes) {
            return ExistingImage::Damaged("larger than any image of this size".into());
        }
        let checked = read_head(path, max_bytes)
            .and_then(|b| if is_exr(path) { verify_exr(&b) } else { verify_png(&b, size) }.map_err(|e| e.to_string()));
        checked.map_or_else(ExistingImage::Damaged, |()| ExistingImage::Same)
    }
}

impl Session {
    /// Digest of a panorama's texels, axes and unit.
    fn sky_digest(&self, map: &SkyMap) -> String {
        let texels = |file: &str| self.maps.get_decoded(file, SKY_DECODING).map_or(Vec::new(), |t| t.levels[0].bytes().to_vec());
        let bright = map.bright.iter().flat_map(|bright| [texels(&bright.file), bright.unit_radiance.to_string().into_bytes()]);
        let parts = [texels(&map.file), format!("{} {}", map.frame.name(), map.unit_radiance).into_bytes()];
        hex_digest(parts.into_iter().chain(bright))
    }

    /// The provenance of a request that this session draws.
    pub fn provenance(&self, request: &ViewRequest) -> Provenance {
        let digests = self.source_digests.get_or_init(|| {
            let mut digests = source_digests(&self.catalog, &self.sources);
            if let Some(map) = self.catalog.lunar_heights() {
                digests.insert(
                    "lunar heights".into(),
                    hex_digest([map.summary().into_bytes(), bytemuck::cast_slice(map.heights_km()).to_vec()]),
                );
            }
            digests.insert("sky".into(), self.sky_map.as_ref().map_or("embedded".into(), |map| self.sky_digest(map)));
            digests
        });
        let mut digests = digests.clone();
        // The window may change data layers, shader sources and the renderer while it runs.
        let layers = self.catalog.data_layers();
        if !layers.is_empty() {
            digests.insert("data".into(), hex_digest(layers.iter().map(|l| layer_text(l).into_bytes())));
        }
        digests.insert("shaders".into(), self.library.generator_digest().to_string());
        let precision = if self.sources.uses_f64 { " in f64" } else { "" };
        digests.insert("renderer".into(), format!("{}{precision}", self.devices.preference().name()));
        Provenance::new(&self.catalog, request, &digests)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::RendererPreference;
    use crate::time::Instant;

    /// An image in f32 must not pass for the same view in f64, for example one that a window saved at quality `reference`.
    #[test]
    fn the_provenance_contains_the_precision() {
        let request = ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-08T18:17:16Z").expect("a time"));
        let [single, double] = [false, true].map(|uses_f64| {
            let cache = tempfile::tempdir().expect("a folder");
            let sources = Sources {
                renderer: RendererPreference::Software,
                uses_f64,
                cache: Some(cache.path().to_owned()),
                threads: Some(1),
                ..Sources::default()
            };
            Session::open(&sources, |line| panic!("{line}")).expect("a session").provenance(&request)
        });
        assert_eq!(Provenance::differences(&single, &double), "renderer software, not software in f64");
    }
}
