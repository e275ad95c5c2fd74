//! The fragments (WESL files of shaders/) that modules are emitted from.
//!
//! In: the built-in fragments, and a user's files that replace some of them or are new; below, *file* means only a file of the user. Out: text and parsed
//! form of each fragment, by path. Not here: the grammar (`shader::source`).

use super::ShaderError;
use super::constants::CONSTANTS;
use super::source::Fragment;
use crate::wording::without_byte_order_mark;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{LazyLock, OnceLock};

macro_rules! fragments {
    ($($path:literal),* $(,)?) => {
        const HAND_WRITTEN_FRAGMENTS: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../shaders/", $path)))),*];
    };
}

fragments![
    "entry/anaglyph.wesl",
    "entry/blur.wesl",
    "entry/coarse_air.wesl",
    "entry/comet_tail.wesl",
    "entry/corona.wesl",
    "entry/dot.wesl",
    "entry/equirectangular.wesl",
    "entry/fisheye.wesl",
    "entry/glow.wesl",
    "entry/interface.wesl",
    "entry/interlace.wesl",
    "entry/label.wesl",
    "entry/line.wesl",
    "entry/minor_planets.wesl",
    "entry/orbit.wesl",
    "entry/outline.wesl",
    "entry/planet.wesl",
    "entry/point.wesl",
    "entry/probe_body_shadow.wesl",
    "entry/probe_disc_overlap.wesl",
    "entry/probe_ring_transmission.wesl",
    "entry/probe_scatter.wesl",
    "entry/probe_sunlight.wesl",
    "entry/refracted_limb.wesl",
    "entry/shrink.wesl",
    "entry/side_by_side.wesl",
    "entry/sky_background.wesl",
    "entry/sky_image.wesl",
    "entry/tone_map.wesl",
    "entry/tone_map_bloom.wesl",
    "entry/warp.wesl",
    "lib/air/at_limb.wesl",
    "lib/air/coarse.wesl",
    "lib/air/coarse_samples.wesl",
    "lib/air/column_density.wesl",
    "lib/air/in_front.wesl",
    "lib/air/multi_scatter.wesl",
    "lib/air/multi_scatter_in_shadow.wesl",
    "lib/air/optical_depth_above.wesl",
    "lib/air/path.wesl",
    "lib/air/phase.wesl",
    "lib/air/sample_counts.wesl",
    "lib/air/scatter_along.wesl",
    "lib/air/scatter_marched.wesl",
    "lib/air/scatter_monotonic.wesl",
    "lib/air/skylight.wesl",
    "lib/air/sums.wesl",
    "lib/air/sunlight_fraction.wesl",
    "lib/air/uniforms.wesl",
    "lib/clouds.wesl",
    "lib/clouds_over_ground.wesl",
    "lib/conic.wesl",
    "lib/cube_faces.wesl",
    "lib/custom/surface_1.wesl",
    "lib/custom/surface_2.wesl",
    "lib/custom/surface_3.wesl",
    "lib/custom/surface_4.wesl",
    "lib/custom/surface_point.wesl",
    "lib/detail.wesl",
    "lib/display.wesl",
    "lib/draw.wesl",
    "lib/eclipse/chords.wesl",
    "lib/eclipse/coarse_sunlight.wesl",
    "lib/eclipse/coarse_sunlight_samples.wesl",
    "lib/eclipse/disc_overlap.wesl",
    "lib/eclipse/linear_penumbra.wesl",
    "lib/eclipse/obscuration.wesl",
    "lib/eclipse/occluders.wesl",
    "lib/eclipse/refraction.wesl",
    "lib/eclipse/silhouette.wesl",
    "lib/eclipse/sun_disc_nodes.wesl",
    "lib/eye_images.wesl",
    "lib/filtered_map.wesl",
    "lib/foreground_limb.wesl",
    "lib/fragment_depth.wesl",
    "lib/glint.wesl",
    "lib/globe.wesl",
    "lib/intersection.wesl",
    "lib/limb_darkening.wesl",
    "lib/limb_distance.wesl",
    "lib/limb_heights.wesl",
    "lib/map_coordinates.wesl",
    "lib/maps.wesl",
    "lib/mesh.wesl",
    "lib/night_lights.wesl",
    "lib/overlay.wesl",
    "lib/photometry/lambert.wesl",
    "lib/photometry/lommel_seeliger.wesl",
    "lib/photometry/lunar_lambert.wesl",
    "lib/photometry/oren_nayar.wesl",
    "lib/point_light.wesl",
    "lib/point_shape.wesl",
    "lib/probe_query.wesl",
    "lib/read_map.wesl",
    "lib/rectangle.wesl",
    "lib/reflected.wesl",
    "lib/relief.wesl",
    "lib/ring/body_shadow.wesl",
    "lib/ring/footprint.wesl",
    "lib/ring/intervals.wesl",
    "lib/ring/photometry.wesl",
    "lib/ring/profile.wesl",
    "lib/ring/ring_patch.wesl",
    "lib/ring/segments.wesl",
    "lib/ring/shadow.wesl",
    "lib/ring/shadow_on_moon.wesl",
    "lib/ring/shine.wesl",
    "lib/ring/surface.wesl",
    "lib/screen.wesl",
    "lib/srgb_decoded.wesl",
    "lib/sunlight.wesl",
    "lib/texels_between.wesl",
    "lib/tint_position.wesl",
    "lib/view_ray.wesl",
];

/// Path inside shaders/ and text of every built-in fragment, sorted by path: those written by hand, and those of `shader::constants`.
pub static FRAGMENTS: LazyLock<Vec<(&'static str, &'static str)>> = LazyLock::new(|| {
    let constants = CONSTANTS.iter().map(|(path, text)| (*path, text.as_str()));
    let mut all: Vec<_> = HAND_WRITTEN_FRAGMENTS.iter().copied().chain(constants).collect();
    all.sort_unstable();
    all
});

/// A fragment's parsed form or first error, computed at its first use.
type Parsed = OnceLock<Result<Fragment, ShaderError>>;

/// Text and parsed form of the built-in fragments, by path; each is parsed at its first use.
static BUILT_IN_BY_PATH: LazyLock<HashMap<&'static str, (&'static str, Parsed)>> =
    LazyLock::new(|| FRAGMENTS.iter().map(|(path, text)| (*path, (*text, Parsed::new()))).collect());

/// A set of fragments from which modules are emitted: the built-in ones, and the user's files, which replace some of them or are new.
#[derive(Clone, Debug, Default)]
pub struct Fragments {
    /// Text and parsed form of the user's files that replace built-in fragments or are new, by path inside shaders/.
    user_files: BTreeMap<String, (String, Parsed)>,
}

impl PartialEq for Fragments {
    fn eq(&self, other: &Self) -> bool {
        // The parsed forms are not compared, because they follow from the texts.
        let mut pairs = self.user_files.iter().zip(&other.user_files);
        self.user_files.len() == other.user_files.len()
            && pairs.all(|((path, (text, _)), (other_path, (other_text, _)))| path == other_path && text == other_text)
    }
}

impl Eq for Fragments {}

impl Fragments {
    /// The built-in fragments, replaced and extended by these files of the user (path inside shaders/, text). A file equal to the built-in fragment replaces
    /// nothing.
    pub fn with_files(files: impl IntoIterator<Item = (String, String)>) -> Self {
        Self::default().and_files(files)
    }

    /// These fragments, replaced and extended by further files. A file equal to a built-in fragment restores it.
    #[must_use]
    pub fn and_files(mut self, files: impl IntoIterator<Item = (String, String)>) -> Self {
        let is_built_in = |path: &str, text: &str| FRAGMENTS.contains(&(path, text));
        for (path, text) in files {
            let text = without_byte_order_mark(&text).to_owned();
            if is_built_in(&path, &text) {
                self.user_files.remove(&path);
            } else {
                self.user_files.insert(path, (text, Parsed::new()));
            }
        }
        self
    }

    /// Text and parsed form of a fragment, or its first error; `None` if there is no fragment of this path.
    pub fn parsed(&self, path: &str) -> Option<(&str, Result<&Fragment, ShaderError>)> {
        let (text, parsed): (&str, _) = match self.user_files.get(path) {
            // A user's file is untrusted: all of it is checked against limits and the grammar, also the parts whose `@if` holds for no key.
            Some((text, parsed)) => (text, parsed.get_or_init(|| Fragment::check(path, text))),
            None => {
                let (text, parsed) = BUILT_IN_BY_PATH.get(path)?;
                (text, parsed.get_or_init(|| Fragment::parse(path, text)))
            }
        };
        Some((text, parsed.as_ref().map_err(Clone::clone)))
    }

    /// A fragment's text by its path inside shaders/.
    pub fn text(&self, path: &str) -> Option<&str> {
        let built_in = || BUILT_IN_BY_PATH.get(path).map(|(text, _)| *text);
        self.user_files.get(path).map(|(text, _)| text.as_str()).or_else(built_in)
    }

    /// Paths of the fragments that a file of the user replaces or adds.
    pub fn replaced_or_added(&self) -> impl Iterator<Item = &str> {
        self.user_files.keys().map(String::as_str)
    }

    /// Whether all fragments are the built-in ones.
    pub fn are_built_in(&self) -> bool {
        self.user_files.is_empty()
    }

    /// Paths of new files that no fragment with a built-in path imports, directly or through others, sorted. Empty if any file that is used has an error,
    /// because what that file imports is then unknown.
    pub fn unused(&self) -> Vec<&str> {
        let mut reached_paths: BTreeSet<String> = FRAGMENTS.iter().map(|(path, _)| (*path).to_owned()).collect();
        // No built-in fragment imports a new one, so the search starts at the user's files that replace built-in fragments.
        let mut unvisited: Vec<String> = self.user_files.keys().filter(|path| reached_paths.contains(*path)).cloned().collect();
        while let Some(path) = unvisited.pop() {
            match self.parsed(&path) {
                Some((_, Ok(fragment))) => {
                    unvisited.extend(fragment.imports.iter().map(|i| i.path.clone()).filter(|p| reached_paths.insert(p.clone())));
                }
                // An invalid file; its error is reported when a module that contains the file is emitted.
                Some((_, Err(_))) => return Vec::new(),
                // No file has this path; the error is reported when a module that contains the import is emitted.
                None => {}
            }
        }
        self.user_files.keys().filter(|path| !reached_paths.contains(*path)).map(String::as_str).collect()
    }

    /// Path and text of every fragment: first the built-in ones and those that replace them, sorted by path, then the new ones, sorted by path.
    pub fn all(&self) -> impl Iterator<Item = (&str, &str)> {
        let built_in = FRAGMENTS.iter().map(|(path, text)| (*path, self.user_files.get(*path).map_or(*text, |(text, _)| text.as_str())));
        let is_new = |(path, _): &(&String, &(String, Parsed))| !BUILT_IN_BY_PATH.contains_key(path.as_str());
        built_in.chain(self.user_files.iter().filter(is_new).map(|(path, (text, _))| (path.as_str(), text.as_str())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_equal_to_the_built_in_fragment_restores_it() {
        let (path, text) = FRAGMENTS[0];
        let file = |text: &str| [(path.to_owned(), text.to_owned())];
        let changed = Fragments::with_files(file("// nothing"));
        assert_eq!((changed.text(path), changed.replaced_or_added().count()), (Some("// nothing"), 1));
        let restored = changed.and_files(file(text));
        assert_eq!(restored.text(path), Some(text));
        assert!(restored.are_built_in() && restored == Fragments::default());
    }

    #[test]
    fn a_byte_order_mark_is_no_part_of_a_file() {
        let (path, text) = FRAGMENTS[0];
        let with_mark = |text: &str| Fragments::with_files([(path.to_owned(), format!("\u{feff}{text}"))]);
        assert!(with_mark(text).are_built_in());
        assert_eq!(with_mark("// nothing").text(path), Some("// nothing"));
    }

    #[test]
    fn a_file_that_nothing_imports_is_unused_also_beside_broken_files() {
        // The built-in fragment of the clouds, replaced by a file that imports another fragment.
        let clouds_importing = |import: &str| ("lib/clouds.wesl".to_owned(), format!("import package::lib::{import}::a;\n"));
        let new = |name: &str, text: &str| (format!("lib/{name}.wesl"), text.to_owned());
        let (sound, broken) = ("const a = 1.0;\n", "const a = = 1.0;\n");
        let unused = |files: Vec<(String, String)>| {
            let fragments = Fragments::with_files(files);
            fragments.unused().into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(unused(vec![clouds_importing("mine"), new("mine", sound), new("other", sound)]), ["lib/other.wesl"]);
        // An unused file may be broken, because its imports do not matter.
        assert_eq!(unused(vec![clouds_importing("mine"), new("mine", sound), new("other", broken)]), ["lib/other.wesl"]);
        // "other" and "third" are unused.
        assert_eq!(unused(vec![clouds_importing("mine"), new("mine", sound), new("other", broken), new("third", sound)]).len(), 2);
        // The broken file is used, and may import the other one.
        assert!(unused(vec![clouds_importing("mine"), new("mine", broken), new("other", sound)]).is_empty());
    }
}
