//! Approximate sunlight under occluders: for the exposure, for magnitudes and for bodies drawn as points.
//!
//! In: the occluders of a receiver, the eclipse model and the Sun. Out: the fraction of sunlight at a point, or its mean over the visible lit
//! ground, 0 to 1. Does not shade drawn surfaces (shaders/lib/eclipse does) and ignores limb darkening.

use crate::catalog::Body;
use crate::scene::draw::features::EclipseModel;
use crate::scene::eclipse::air;
use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver};
use glam::DVec3;

/// Approximate fraction of sunlight that occluders leave at points of a receiver, for discs without limb darkening.
pub(crate) struct ApproximateShadow<'a> {
    occluders: &'a [Occluder<'a>],
    axis: Axis,
    /// The first occluder's air, if it refracts light.
    layers: Option<air::RefractingLayers>,
}

impl<'a> ApproximateShadow<'a> {
    /// `None` without occluders.
    pub(crate) fn of(occluders: &'a [Occluder<'a>], model: EclipseModel, receiver: &Receiver<'_>, sun: &Body) -> Option<Self> {
        let axis = Axis::of(receiver, sun).filter(|_| !occluders.is_empty())?;
        let first = occluders.first().filter(|_| model == EclipseModel::Refracted);
        let fraction = |o: &Occluder<'_>| air::bending_fraction(o.along, axis.sun_distance);
        Some(Self { occluders, axis, layers: first.and_then(|o| air::layers(o.body, receiver.radius_km(), o.semi.x, fraction(o))) })
    }

    /// Fraction of sunlight at a point, given in the receiver's axes and equatorial radii.
    pub(crate) fn sunlight_fraction(&self, point: DVec3) -> f64 {
        let (across, along) = (self.axis.across(point), point.dot(self.axis.along));
        let mut fraction = 1.0_f64;
        for (index, occluder) in self.occluders.iter().enumerate() {
            let depth = occluder.along - along;
            if depth <= 0.0 {
                continue;
            }
            // Solar radii per unit of length at the occluder's distance.
            let scale = self.axis.cot_sun_radius / depth;
            let (separation, radius) = ((occluder.across - across).length() * scale, occluder.semi.x * scale);
            // Rises linearly from outer contact to full overlap, where the discs' areas decide.
            let obscuration =
                ((1.0 + radius - separation) / (1.0 + radius - (1.0 - radius).abs())).clamp(0.0, 1.0) * (radius * radius).min(1.0);
            fraction = fraction.min(1.0 - obscuration);
            if let Some(layers) = self.layers.as_ref().filter(|_| index == 0) {
                fraction += layers.light(separation, depth, scale);
            }
        }
        fraction.min(1.0)
    }

    /// Mean fraction over the lit ground that a viewer sees. `camera`: direction from the centre to the camera, body axes, of any length.
    pub(crate) fn mean(&self, camera: DVec3) -> f64 {
        let towards = camera.normalize_or(self.axis.along);
        const POINTS: usize = 200;
        let (mut sum, mut weights) = (0.0, 0.0);
        for k in 0..POINTS {
            // A Fibonacci lattice on the sphere.
            let z = 1.0 - (2.0 * k as f64 + 1.0) / POINTS as f64;
            let (sin, cos) = (k as f64 * 2.399_963).sin_cos();
            let point = DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
            let weight = point.dot(self.axis.along).max(0.0) * point.dot(towards).max(0.0);
            if weight >= 0.01 {
                sum += self.sunlight_fraction(point) * weight;
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { 1.0 }
    }
}
