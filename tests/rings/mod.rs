//! Rings: light through them, shadows, and the light that they reflect onto their planet.

mod edge_on;
mod globe_outside;
mod moon_shadows;
mod picking;
mod pixels;
mod reference_tables;
mod ring_shine;
mod shadow_on_moons;
