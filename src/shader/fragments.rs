//! The WGSL fragments of shaders/, built into the program.

macro_rules! fragments {
    ($($name:literal),* $(,)?) => {
        /// Path inside shaders/ and text of every fragment, in order of path.
        pub static FRAGMENTS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../shaders/", $name)))),*];
    };
}

fragments![
    "entry/planet.wgsl",
    "entry/point.wgsl",
    "entry/tone_map.wgsl",
    "lib/draw.wgsl",
    "lib/glint.wgsl",
    "lib/intersection.wgsl",
    "lib/limb_darkening.wgsl",
    "lib/map_place.wgsl",
    "lib/mesh.wgsl",
    "lib/night_lights.wgsl",
    "lib/photometry/lambert.wgsl",
    "lib/photometry/lommel_seeliger.wgsl",
    "lib/photometry/lunar_lambert.wgsl",
    "lib/photometry/oren_nayar.wgsl",
    "lib/rectangle.wgsl",
    "lib/reflected.wgsl",
    "lib/relief.wgsl",
    "lib/sunlight.wgsl",
];

/// Simple modules: everything that is not a planet. The name is the key; the fragment is `entry/<name>.wgsl`.
pub const SIMPLE_MODULES: [&str; 2] = ["point", "tone_map"];
