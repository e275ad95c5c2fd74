//! Who hides whom: the order of draws, and what nearer bodies leave of a disc.

pub(crate) mod hidden;
pub(crate) mod limb_profiles;
pub(crate) mod lunar_limb;
pub(crate) mod order;
