//! The WGSL fragments of shaders/, built into the program, and a folder's files over them while someone writes shaders.

use super::ModuleId;
use std::collections::{BTreeMap, BTreeSet};

macro_rules! fragments {
    ($($name:literal),* $(,)?) => {
        /// Path inside shaders/ and text of every fragment, in order of path.
        pub static FRAGMENTS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../shaders/", $name)))),*];
    };
}

fragments![
    "entry/blur.wgsl",
    "entry/corona.wgsl",
    "entry/glow.wgsl",
    "entry/interface.wgsl",
    "entry/label.wgsl",
    "entry/line.wgsl",
    "entry/outline.wgsl",
    "entry/planet.wgsl",
    "entry/point.wgsl",
    "entry/probe_disc_overlap.wgsl",
    "entry/probe_ring_shadow.wgsl",
    "entry/probe_ring_transmission.wgsl",
    "entry/probe_scatter.wgsl",
    "entry/probe_sunlight.wgsl",
    "entry/refracted_limb.wgsl",
    "entry/shrink.wgsl",
    "entry/tone_map.wgsl",
    "entry/tone_map_bloom.wgsl",
    "lib/air/along.wgsl",
    "lib/air/columns.wgsl",
    "lib/air/counts.wgsl",
    "lib/air/many.wgsl",
    "lib/air/of_draw.wgsl",
    "lib/air/path.wgsl",
    "lib/air/rising.wgsl",
    "lib/air/scatter.wgsl",
    "lib/air/seen_air.wgsl",
    "lib/air/shaded.wgsl",
    "lib/air/spread.wgsl",
    "lib/air/sums.wgsl",
    "lib/clouds.wgsl",
    "lib/display.wgsl",
    "lib/draw.wgsl",
    "lib/eclipse/casters.wgsl",
    "lib/eclipse/chords.wgsl",
    "lib/eclipse/circle.wgsl",
    "lib/eclipse/linear.wgsl",
    "lib/eclipse/nodes.wgsl",
    "lib/eclipse/overlap.wgsl",
    "lib/eclipse/refraction.wgsl",
    "lib/eclipse/silhouette.wgsl",
    "lib/filtered.wgsl",
    "lib/glint.wgsl",
    "lib/intersection.wgsl",
    "lib/lane.wgsl",
    "lib/limb_darkening.wgsl",
    "lib/map_place.wgsl",
    "lib/maps.wgsl",
    "lib/mesh.wgsl",
    "lib/night_lights.wgsl",
    "lib/overlay.wgsl",
    "lib/own_depth.wgsl",
    "lib/photometry/lambert.wgsl",
    "lib/photometry/lommel_seeliger.wgsl",
    "lib/photometry/lunar_lambert.wgsl",
    "lib/photometry/oren_nayar.wgsl",
    "lib/rectangle.wgsl",
    "lib/reflected.wgsl",
    "lib/relief.wgsl",
    "lib/ring/body_shadow.wgsl",
    "lib/ring/photometry.wgsl",
    "lib/ring/profile.wgsl",
    "lib/ring/shadow.wgsl",
    "lib/ring/shine.wgsl",
    "lib/ring/surface.wgsl",
    "lib/screen.wgsl",
    "lib/sunlight.wgsl",
    "lib/uncovered.wgsl",
    "lib/view_ray.wgsl",
];

/// The fragments that a generator works with: those built in, some of them perhaps replaced.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fragments {
    replaced: BTreeMap<String, String>,
}

impl Fragments {
    /// Files over the built-in ones, by path inside shaders/. A file that says what is built in replaces nothing.
    pub fn with_files(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let built_in = |path: &str, text: &str| FRAGMENTS.contains(&(path, text));
        Self { replaced: files.into_iter().filter(|(path, text)| !built_in(path, text)).collect() }
    }

    pub fn text(&self, path: &str) -> Option<&str> {
        let built_in = || FRAGMENTS.iter().find(|(name, _)| *name == path).map(|(_, text)| *text);
        self.replaced.get(path).map(String::as_str).or_else(built_in)
    }

    /// Paths of those that are not the built-in ones.
    pub fn replaced(&self) -> impl Iterator<Item = &str> {
        self.replaced.keys().map(String::as_str)
    }

    pub fn are_built_in(&self) -> bool {
        self.replaced.is_empty()
    }

    /// Files that replace no built-in fragment and that no fragment uses, in order of path.
    pub fn unused(&self) -> Vec<&str> {
        let used_by = |text: &str| {
            let lines = text.lines().filter_map(|l| l.trim_start().strip_prefix("//:")?.trim().strip_prefix("use "));
            lines.map(|path| path.trim().to_owned()).collect::<Vec<_>>()
        };
        let mut reached: BTreeSet<String> = FRAGMENTS.iter().map(|(path, _)| (*path).to_owned()).collect();
        let mut open: Vec<String> = reached.iter().cloned().collect();
        while let Some(path) = open.pop() {
            let used = self.replaced.get(&path).map(|text| used_by(text)).unwrap_or_default();
            open.extend(used.into_iter().filter(|p| reached.insert(p.clone())));
        }
        self.replaced.keys().filter(|path| !reached.contains(*path)).map(String::as_str).collect()
    }

    /// Path and text of every fragment: the built-in ones in order of path, then those that are new.
    pub fn all(&self) -> impl Iterator<Item = (&str, &str)> {
        let known = FRAGMENTS.iter().map(|(path, text)| (*path, self.replaced.get(*path).map_or(*text, String::as_str)));
        let is_new = |(path, _): &(&String, &String)| FRAGMENTS.iter().all(|(known, _)| known != path);
        known.chain(self.replaced.iter().filter(is_new).map(|(path, text)| (path.as_str(), text.as_str())))
    }
}

/// Simple modules: everything that is not a planet. The name is the key; the fragment is `entry/<name>.wgsl`.
pub const SIMPLE_MODULES: [&str; 12] =
    ["blur", "corona", "glow", "interface", "label", "line", "outline", "point", "refracted_limb", "shrink", "tone_map", "tone_map_bloom"];

/// Modules that answer questions: entry fragments `entry/<name>.wgsl` emitted with the features of a key.
pub const PROBES: [&str; 5] = ["probe_disc_overlap", "probe_ring_shadow", "probe_ring_transmission", "probe_scatter", "probe_sunlight"];

/// The keys with which a probe is recorded and tested: one for each model that it may be asked for.
pub fn probe_samples() -> Vec<ModuleId> {
    let keys = |name: &'static str, texts: &[&str]| {
        texts.iter().filter_map(|t| t.parse().ok()).map(|key| ModuleId::Probe(name, key)).collect::<Vec<_>>()
    };
    let models = ["linear", "uniform-disc", "limb-darkened"].map(|m| format!("lambert.sun1.eclipse1-{m}.sphere"));
    let mut all = keys("probe_disc_overlap", &models.each_ref().map(String::as_str));
    all.extend(keys("probe_sunlight", &["lambert.sun1.eclipse1-limb-darkened.sphere", "lambert.sun1.eclipse4-refracted.sphere"]));
    all.extend(keys("probe_ring_shadow", &["ring.sun1.bodyshadow-sphere.sphere", "ring.sun1.bodyshadow-ellipsoid-penumbra.sphere"]));
    all.extend(keys("probe_ring_transmission", &["lambert.sun1.ringshadow-point-sun.sphere", "lambert.sun1.ringshadow-penumbra.sphere"]));
    let scatter = ["air-pixel-8", "air-pixel-16-mie", "air-pixel-32-mie-absorption", "air-pixel-16-absorption"];
    let scatter = scatter.map(|air| format!("sky.sun1.{air}.sphere"));
    all.extend(keys("probe_scatter", &scatter.each_ref().map(String::as_str)));
    all
}
