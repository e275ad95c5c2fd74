//! Frame plans, and recorded images that the software renderer must reproduce.

mod composite;
mod golden;
mod permutations;
mod plan;
mod sphere_sprites;
