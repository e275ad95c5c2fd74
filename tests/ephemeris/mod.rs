//! Positions, rotations and apparent places against external references.

mod apparent;
mod horizon;
mod kernel_gaps;
mod orientation;
mod positions;
mod satellites;
