//! The WGSL fragments of shaders/, built into the program.

use super::ModuleId;

macro_rules! fragments {
    ($($name:literal),* $(,)?) => {
        /// Path inside shaders/ and text of every fragment, in order of path.
        pub static FRAGMENTS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../shaders/", $name)))),*];
    };
}

fragments![
    "entry/glow.wgsl",
    "entry/line.wgsl",
    "entry/planet.wgsl",
    "entry/point.wgsl",
    "entry/probe_disc_overlap.wgsl",
    "entry/probe_scatter.wgsl",
    "entry/probe_sunlight.wgsl",
    "entry/probe_ring_shadow.wgsl",
    "entry/probe_ring_transmission.wgsl",
    "entry/tone_map.wgsl",
    "lib/air/along.wgsl",
    "lib/air/columns.wgsl",
    "lib/air/many.wgsl",
    "lib/air/of_draw.wgsl",
    "lib/air/path.wgsl",
    "lib/air/rising.wgsl",
    "lib/air/scatter.wgsl",
    "lib/air/seen_air.wgsl",
    "lib/air/shaded.wgsl",
    "lib/air/sums.wgsl",
    "lib/clouds.wgsl",
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
    "lib/sunlight.wgsl",
    "lib/view_ray.wgsl",
];

/// Simple modules: everything that is not a planet. The name is the key; the fragment is `entry/<name>.wgsl`.
pub const SIMPLE_MODULES: [&str; 4] = ["glow", "line", "point", "tone_map"];

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
