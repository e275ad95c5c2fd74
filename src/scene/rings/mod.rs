//! Rings: when they are drawn, how rings and planet shadow and light each other, and the tables that their shaders read.
//!
//! `rings_before_sun`, `shadow_grid`, `shadow_on_body`: the shadow of rings on other bodies. `ring_light`: the light that rings send to a distant viewer.
//! [`ring_shine`]: the light that they send to their planet. [`RingConditions`]: the sunlight on the rings and the slants of the view rays, for which a table is
//! computed. [`MIN_COSINE`]: lower limit of the cosine of the angle between any path and the rings' normal.

pub(crate) mod decision;
pub(crate) mod phase;
pub(crate) mod radial_sums;
pub(crate) mod ring_light;
pub mod ring_shine;
pub mod ring_table;
pub(crate) mod rings_before_sun;
mod shadow_grid;
pub(crate) mod shadow_on_body;
mod single_scatter;
pub(crate) mod view;

pub use phase::{MIN_COSINE, dust_phase, large_particle_phase};
pub use ring_table::{RingConditions, slants_of_sunlight};
