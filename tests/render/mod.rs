//! Frame plans, and recorded images that both the software renderer and its pair tests draw.

mod composite;
mod golden;
mod permutations;
mod plan;
