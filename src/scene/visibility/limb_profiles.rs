//! A cache of the Moon's limb profiles, kept from frame to frame.
//!
//! In: the height map and the viewer's position in the Moon's axes. Out: the profile, computed only if none of the last few was seen from a position from
//! which the limb looks the same.

use crate::catalog::lunar_heights::HeightMap;
use crate::ephemeris::angle_rad;
use crate::ephemeris::limb_profile::LimbProfile;
use crate::memo::Memo;
use glam::DVec3;
use std::sync::Arc;

/// Viewers whose directions from the Moon differ by less than this angle, radians, and whose distances by less than [`SAME_DISTANCE_RATIO`] share a profile: 50 m
/// on the Moon's ground.
const SAME_DIRECTION_RAD: f64 = 3e-5;

/// The most recent profiles, by map and viewer's position in the Moon's axes.
#[derive(Debug)]
pub(crate) struct LimbProfiles(Memo<(usize, DVec3), Arc<LimbProfile>>);

impl Default for LimbProfiles {
    fn default() -> Self {
        Self(Memo::with_capacity(4))
    }
}

impl LimbProfiles {
    /// The profile seen from a position in the Moon's axes, which must be outside all ground.
    pub(crate) fn seen_from(&self, map: &Arc<HeightMap>, viewer_km: DVec3) -> Arc<LimbProfile> {
        let is_same_limb = |cached: &(usize, DVec3), requested: &(usize, DVec3)| {
            let distance_ratio = cached.1.length() / requested.1.length();
            cached.0 == requested.0 && angle_rad(cached.1, requested.1) < SAME_DIRECTION_RAD && (distance_ratio - 1.0).abs() < 1e-3
        };
        let key = (Arc::as_ptr(map) as usize, viewer_km);
        self.0.get_compatible(is_same_limb, key, || Arc::new(LimbProfile::seen_from(map, viewer_km)))
    }
}
