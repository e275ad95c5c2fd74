//! A cache of the Moon's limb profiles, kept from frame to frame.
//!
//! In: the height map and the viewer's position in the Moon's axes. Out: the profile, computed only if no recent profile was seen from nearly the
//! same position.

use crate::catalog::lunar_heights::HeightMap;
use crate::ephemeris::angle_rad;
use crate::ephemeris::limb_profile::LimbProfile;
use crate::memo::Memo;
use glam::DVec3;
use std::sync::Arc;

/// Largest angle between the directions from the Moon to two viewers who share a profile, radians: such an angle moves the limb by 50 m on the Moon's ground.
const MAX_ANGLE_RAD: f64 = 3e-5;
/// Largest relative difference between the distances of two viewers who share a profile.
const MAX_DISTANCE_DIFFERENCE: f64 = 1e-3;
/// Number of profiles that are kept.
const MAX_PROFILES: usize = 4;

/// Map, and viewer's position in the Moon's axes, km. Maps are compared by address; the key keeps its map alive, so that no other map can have the same
/// address.
type Key = (Arc<HeightMap>, DVec3);

/// The most recent profiles.
#[derive(Debug)]
pub(crate) struct LimbProfileCache(Memo<Key, Arc<LimbProfile>>);

impl Default for LimbProfileCache {
    fn default() -> Self {
        Self(Memo::with_capacity(MAX_PROFILES))
    }
}

impl LimbProfileCache {
    /// The profile seen from a position in the Moon's axes, which must be outside all ground.
    pub(crate) fn seen_from(&self, map: &Arc<HeightMap>, viewer_km: DVec3) -> Arc<LimbProfile> {
        let is_same_limb = |(cached_map, cached_km): &Key, (map, viewer_km): &Key| {
            let distance_ratio = cached_km.length() / viewer_km.length();
            Arc::ptr_eq(cached_map, map)
                && angle_rad(*cached_km, *viewer_km) < MAX_ANGLE_RAD
                && (distance_ratio - 1.0).abs() < MAX_DISTANCE_DIFFERENCE
        };
        let key = (Arc::clone(map), viewer_km);
        self.0.get_compatible(is_same_limb, key, || Arc::new(LimbProfile::seen_from(map, viewer_km)))
    }
}
