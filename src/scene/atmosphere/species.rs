//! The species of an air, as the catalog gives them: which is gas, haze or layer, and how deep they are together.

use crate::catalog::{Atmosphere, Body, Species};
use crate::scene::atmosphere::extinction::extinction;
use crate::scene::draw::features::{Air, AtmosphereModel};
use glam::DVec3;

/// The species whose molecules scatter by Rayleigh's law and thin out upward.
pub(crate) fn gas(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.asymmetry.is_none() && s.tent_centre_km.is_none())
}
pub(crate) fn haze(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.asymmetry.is_some() && s.tent_centre_km.is_none())
}
pub(crate) fn layer(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.tent_centre_km.is_some())
}
/// Optical depth straight up, per channel.
pub(crate) fn vertical_depth(air: &Atmosphere) -> DVec3 {
    // A tent of half width w holds as much as a slab of height w.
    air.species.iter().map(|s| extinction(s) * s.scale_height_km).sum()
}

/// What of the air a body's draws have at this tier; none without an atmosphere.
pub(crate) fn structure(body: &Body, tier: AtmosphereModel) -> Air {
    body.atmosphere.as_ref().map_or_else(Air::default, |air| Air { tier, mie: haze(air).is_some(), absorption: layer(air).is_some() })
}
