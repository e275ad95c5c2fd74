//! Rings: light through them, shadows, and the light that they send to their planet.

mod pixels;
mod reference_tables;
mod ring_shine;
