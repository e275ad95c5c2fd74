//! Positions, rotations and apparent places against outside references.

mod apparent;
mod horizon;
mod orientation;
mod positions;
mod satellites;
