//! One test binary: one link. Each module below is one area; unit tests live beside the code.

mod air;
mod air_bounds;
mod air_shadows;
mod apparent;
mod bench;
mod catalog;
mod cli;
mod cli_frames;
mod cli_messages;
mod clouds;
mod depth;
mod eclipse;
mod ephemeris;
mod exposure;
mod formulas;
mod glint;
mod golden;
#[cfg(feature = "gpu")]
mod gpu;
mod horizon;
mod layering;
mod layers;
mod library;
mod limb_profile;
mod limbs;
mod linear;
mod mesh;
mod metering;
mod moments;
mod orientation;
mod overlays;
mod permutations;
mod plan;
mod poles;
mod probe;
mod refracted_limb;
mod relief;
mod ring_shine;
mod rings;
mod satellites;
mod scene;
mod scene_magnitude;
mod scene_silhouette;
mod shader_keys;
mod shared;
mod shrinking;
mod six_cases;
mod software_filtered;
mod software_frame;
mod software_lower;
mod software_math;
mod software_raster;
mod software_sampling;
mod software_speed;
mod software_tone_map;
mod textures;
mod toggles;
mod totality;
mod umbra;
#[cfg(feature = "view")]
mod viewer;
#[cfg(feature = "view")]
mod viewer_access;
#[cfg(feature = "view")]
mod viewer_hands;
#[cfg(feature = "view")]
mod viewer_inspect;
#[cfg(feature = "view")]
mod viewer_panels;
mod views;
#[cfg(all(feature = "gpu", feature = "view"))]
mod window_frame;
