//! How much a part of a subject counts, by its radiance and its contrast.
//!
//! In: the radiance of a part, and that of the light in front of it. Out: factors on its share of the frame, 0 to 1.

/// Each part of the frame is weighted by this power of its radiance, because brighter ground attracts the eye. With 2/3 the lit part of a crescent outweighs
/// the night side, and the part of the Moon in the umbra outweighs a part still lit that is two thousandths of the disc.
pub(super) const RADIANCE_WEIGHT_EXPONENT: f64 = 2.0 / 3.0;
/// Radiance above which the weight no longer increases: a white plane in full sunlight. Without this limit a Sun of a few pixels would outweigh a planet.
const WEIGHT_RADIANCE_CAP: f64 = 1.0;

/// The factor by the radiance.
pub(super) fn radiance_weight(radiance: f64) -> f64 {
    radiance.min(WEIGHT_RADIANCE_CAP).powf(RADIANCE_WEIGHT_EXPONENT)
}

/// The factor by the contrast. `foreground_radiance`: radiance of the light added in front of the part.
pub(super) fn contrast_weight(radiance: f64, foreground_radiance: f64) -> f64 {
    (radiance / (radiance + foreground_radiance)).powi(2)
}
