//! A cache of the Moon's limb profiles, kept from frame to frame.
//!
//! In: the height map and the viewer's place in the Moon's axes. Out: the profile, computed once for places that see the same limb.

use crate::catalog::lunar_heights::HeightMap;
use crate::ephemeris::angle_rad;
use crate::ephemeris::limb_profile::LimbProfile;
use crate::memo::Memo;
use glam::DVec3;
use std::sync::Arc;

/// Directions from the Moon that differ by less than this see the same limb, radians: 50 m on its ground.
const SAME_PLACE: f64 = 3e-5;

/// The most recent profiles, by map and place in the Moon's axes.
#[derive(Debug)]
pub(crate) struct LimbProfiles(Memo<(usize, DVec3), Arc<LimbProfile>>);

impl Default for LimbProfiles {
    fn default() -> Self {
        Self(Memo::with_capacity(4))
    }
}

impl LimbProfiles {
    /// `place_km`: in the Moon's axes, outside of all ground.
    pub(crate) fn seen_from(&self, map: &Arc<HeightMap>, place_km: DVec3) -> Arc<LimbProfile> {
        let is_same_limb = |kept: &(usize, DVec3), wanted: &(usize, DVec3)| {
            let lengths = kept.1.length() / wanted.1.length();
            kept.0 == wanted.0 && angle_rad(kept.1, wanted.1) < SAME_PLACE && (lengths - 1.0).abs() < 1e-3
        };
        let key = (Arc::as_ptr(map) as usize, place_km);
        self.0.get_compatible(is_same_limb, key, || Arc::new(LimbProfile::seen_from(map, place_km)))
    }
}
