//! The species of an atmosphere.
//!
//! In: the catalog's atmosphere, with at most one gas, one aerosol and one absorption layer. Out: each of these species, the vertical optical depth of all
//! together, what of them the disc shows, and the features of draws.

use crate::catalog::{Atmosphere, Body, Species};
use crate::scene::atmosphere::extinction::{extinction, scattering};
use crate::scene::draw::features::{Air, AtmosphereModel};
use glam::DVec3;

/// The species with Rayleigh's phase function and an exponential profile, if the air has one.
pub(crate) fn rayleigh(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.is_gas())
}

/// The species with the phase function of aerosols (shaders call it Mie) and an exponential profile, if the air has one.
pub(crate) fn mie(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.aerosol_phase().is_some())
}

/// The species with a triangular profile, if the air has one.
pub(crate) fn absorption_layer(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.tent_centre_km.is_some())
}

/// Vertical optical depth, per channel.
pub(crate) fn vertical_optical_depth(air: &Atmosphere) -> DVec3 {
    vertical_integral(air, extinction)
}

/// The part of the vertical optical depth that is due to scattering, per channel.
pub(crate) fn vertical_scattering_depth(air: &Atmosphere) -> DVec3 {
    vertical_integral(air, scattering)
}

/// Whether the colours of the body's map and disc are those of the ground without the atmosphere; the colours of other bodies include the atmosphere.
pub(crate) fn colours_exclude_air(body: &Body) -> bool {
    body.clear_sky_albedo.is_some()
}

/// Vertical optical depth in the clearest channel above which an atmosphere is visible over the disc: Mars' dust (0.5) is, the clear gas of the giant
/// planets is not.
const MIN_DEPTH_OVER_DISC: f64 = 0.3;

/// Whether the atmosphere is visible over the disc: its scattered light extends past the terminator, so that it is drawn even over a map that includes it.
pub(crate) fn is_visible_over_disc(air: &Atmosphere) -> bool {
    vertical_optical_depth(air).min_element() > MIN_DEPTH_OVER_DISC
}

/// The vertical integral of a coefficient summed over all species. `of_species`: [`scattering`] or [`extinction`].
fn vertical_integral(air: &Atmosphere, of_species: fn(&Species) -> DVec3) -> DVec3 {
    // Both profiles integrate to `scale_height_km`, which for a triangular profile is half its width.
    air.species.iter().map(|s| of_species(s) * s.scale_height_km).sum()
}

/// The atmospheric features of a body's draws with this model; the default, without air, for a body without an atmosphere.
pub(crate) fn air_features(body: &Body, model: AtmosphereModel) -> Air {
    body.atmosphere.as_ref().map_or_else(Air::default, |air| features_of_air(air, model))
}

/// The atmospheric features of draws of this air with this model.
pub(crate) fn features_of_air(air: &Atmosphere, model: AtmosphereModel) -> Air {
    Air { model, mie: mie(air).is_some(), absorption: absorption_layer(air).is_some() }
}
