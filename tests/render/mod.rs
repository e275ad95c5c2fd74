//! Frame plans, and recorded images that the software renderer must reproduce.

mod composite;
mod fisheye_rim;
mod golden;
mod mirrored;
mod permutations;
mod plan;
mod sphere_names;
mod sphere_sprites;
