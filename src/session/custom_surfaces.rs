//! Custom surfaces: a WESL function that colours the ground of one body, `--surface BODY=FILE`.
//!
//! In: bodies and files. Out: the catalog in which each of these bodies has a surface number, and the fragments that replace the built-in placeholders
//! shaders/lib/custom/surface_1.wesl to surface_4.wesl. Always: each file is checked before anything is drawn, by compiling a module with it and
//! lowering it for the software renderer; errors name the user's file; all names that a file declares, except `custom_surface`, get a prefix, so that no
//! module has one of them twice. Not here: the inputs of a surface function (shaders/lib/custom/surface_point.wesl).

use super::software_renderers::lowering;
use crate::catalog::Catalog;
use crate::files::read_text;
use crate::scene::draw::{DrawFeatures, MAX_CUSTOM_SURFACES};
use crate::shader::fragments::Fragments;
use crate::shader::key::ShaderKey;
use crate::shader::module::check_names;
use crate::shader::source::with_prefixed_names;
use crate::shader::{ModuleId, ShaderError, ShaderModule};
use crate::wording::{MAX_ECHO_CHARS, echo, echo_within};
use std::path::PathBuf;
use std::str::FromStr;

/// Largest file, bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// A body and the file that colours its surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurfaceFile {
    /// Name of the body, as the user wrote it.
    pub body: String,
    /// The file with the surface function.
    pub file: PathBuf,
}

/// A text that is not `BODY=FILE`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write BODY=FILE, such as mars=my_mars.wesl")]
pub struct SurfaceArgumentError;

impl FromStr for SurfaceFile {
    type Err = SurfaceArgumentError;
    fn from_str(text: &str) -> Result<Self, SurfaceArgumentError> {
        match text.split_once('=') {
            Some((body, file)) if !body.trim().is_empty() && !file.is_empty() => {
                Ok(Self { body: body.trim().to_owned(), file: PathBuf::from(file) })
            }
            _ => Err(SurfaceArgumentError),
        }
    }
}

/// Why a custom surface cannot be used, in one line.
#[derive(Debug, thiserror::Error)]
pub enum SurfaceError {
    /// More surfaces than placeholders.
    #[error("--surface: {0} surfaces; at most {MAX_CUSTOM_SURFACES} in one run")]
    TooMany(usize),
    /// No body of the catalog has this name, or it is that of a barycentre.
    #[error("--surface {body}: {why}")]
    Body {
        /// The body as the user wrote it.
        body: String,
        /// The catalog's error.
        why: String,
    },
    /// A body with two surfaces.
    #[error("--surface {0}: this body has a surface already; name each body once")]
    Twice(String),
    /// A file that cannot be read.
    #[error("--surface {body}={path}: {source}")]
    File {
        /// The body as the user wrote it.
        body: String,
        /// The path as the user named it.
        path: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// No module can be compiled with the file.
    #[error(
        "--surface {body}={path}: {why}; a surface has `fn custom_surface(point: SurfacePoint) -> CustomSurface`, with both types imported from package::lib::custom::surface_point"
    )]
    Module {
        /// The body as the user wrote it.
        body: String,
        /// The path as the user named it.
        path: String,
        /// The error of the generator, naga or the renderer.
        why: String,
    },
}

/// Path below shaders/ of the placeholder for the surface with this number, from 1.
fn fragment_path(number: u8) -> String {
    format!("lib/custom/surface_{number}.wesl")
}

/// What the names that the surface with this number declares begin with in modules. No built-in fragment declares such names.
fn name_prefix(number: u8) -> String {
    format!("surface{number}_")
}

/// The error of a surface with which no module can be compiled. It names the user's file and its declarations as the user wrote them.
fn module_error(number: u8, surface: &SurfaceFile, error: &ShaderError) -> SurfaceError {
    let path = echo(&surface.file.display().to_string());
    // The end of a long error is cut off. The path is inserted afterwards, so that a long path does not displace the error.
    let why = echo_within(&error.to_string(), 2 * MAX_ECHO_CHARS).replace(&name_prefix(number), "");
    let why = why.replace(&format!("shaders/{}", fragment_path(number)), &path);
    SurfaceError::Module { body: echo(&surface.body), path, why }
}

/// The surfaces with their numbers, or an error if there are more surfaces than placeholders.
fn numbered(surfaces: &[SurfaceFile]) -> Result<impl Iterator<Item = (u8, &SurfaceFile)>, SurfaceError> {
    if surfaces.len() > usize::from(MAX_CUSTOM_SURFACES) {
        return Err(SurfaceError::TooMany(surfaces.len()));
    }
    Ok((1..=MAX_CUSTOM_SURFACES).zip(surfaces))
}

/// The catalog in which each listed body has the number of its surface, counted from 1 in the order of the list.
///
/// # Errors
/// An unknown or repeated body, or more surfaces than placeholders.
pub fn with_surfaces(mut catalog: Catalog, surfaces: &[SurfaceFile]) -> Result<Catalog, SurfaceError> {
    for (number, surface) in numbered(surfaces)? {
        let body = || echo(&surface.body);
        let id = catalog.body_named(&surface.body).map_err(|e| SurfaceError::Body { body: body(), why: e.to_string() })?.id;
        if !catalog.set_custom_surface(id, number) {
            return Err(SurfaceError::Twice(body()));
        }
    }
    Ok(catalog)
}

/// The texts of the files, with prefixes before the names that they declare, each with the path below shaders/ of the placeholder that it replaces.
/// `base`: the other fragments with which they are compiled.
///
/// # Errors
/// A file that cannot be read, a file with which a module does not compile, or more surfaces than placeholders.
pub fn surface_fragments(surfaces: &[SurfaceFile], base: &Fragments) -> Result<Vec<(String, String)>, SurfaceError> {
    if surfaces.is_empty() {
        return Ok(Vec::new());
    }
    let mut texts = Vec::new();
    for (number, surface) in numbered(surfaces)? {
        let file_error = |source| SurfaceError::File { body: echo(&surface.body), path: echo(&surface.file.display().to_string()), source };
        let text = read_text(&surface.file, MAX_FILE_BYTES).map_err(file_error)?;
        let path = fragment_path(number);
        let named = with_prefixed_names(&path, &text, &name_prefix(number), "custom_surface");
        texts.push((path, named.map_err(|e| module_error(number, surface, &e))?));
    }
    let fragments = base.clone().and_files(texts.iter().cloned());
    let lowering = lowering();
    for (number, surface) in numbered(surfaces)? {
        let sample_features = DrawFeatures { custom_surface: number, lights: 1, ..DrawFeatures::MINIMAL };
        let key = ShaderKey::for_draw(&sample_features);
        check_names(&fragments, &fragment_path(number), &key)
            .and_then(|()| ShaderModule::build_with(&fragments, &ModuleId::Keyed(key), &lowering))
            .map_err(|e| module_error(number, surface, &e))?;
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn body_and_file_are_separated_at_the_first_equals_sign() {
        let surface: SurfaceFile = "mars=a=b.wesl".parse().expect("a surface");
        assert_eq!((surface.body.as_str(), surface.file.as_path()), ("mars", Path::new("a=b.wesl")));
        for invalid in ["mars", "=a.wesl", "mars=", " =a"] {
            assert_eq!(invalid.parse::<SurfaceFile>(), Err(SurfaceArgumentError), "{invalid}");
        }
    }

    /// `orrery doctor` reads the files without the catalog, so `with_surfaces` does not check their number.
    #[test]
    fn more_files_than_placeholders_are_refused_before_they_are_read() {
        let surface = SurfaceFile { body: "moon".into(), file: "no-such-file.wesl".into() };
        let surfaces = vec![surface; usize::from(MAX_CUSTOM_SURFACES) + 1];
        let error = surface_fragments(&surfaces, &Fragments::default()).expect_err("too many");
        assert_eq!(error.to_string(), SurfaceError::TooMany(surfaces.len()).to_string());
        let error = surface_fragments(&surfaces[1..], &Fragments::default()).expect_err("no file").to_string();
        assert!(error.starts_with("--surface moon=no-such-file.wesl: "), "{error}");
    }
}
