//! Visibility between bodies: the order of draws, and the part of a disc that nearer bodies leave visible.

pub(crate) mod hidden;
pub(crate) mod limb_profiles;
pub(crate) mod lunar_limb;
pub(crate) mod order;
pub(crate) mod points;
