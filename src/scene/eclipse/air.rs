//! A caster's air as layers that bend light and let a part of it through.
//!
//! Bending of a ray that grazes an exponential atmosphere: refractivity there times sqrt(2 pi r / H) (Baum and Code 1953, Astron. J.
//! 58, 108); the air keeps one temperature, its scale height is that of its gas. What a layer lets through: extinction by the catalog's species
//! along the straight grazing ray. Left out: clouds, weather, and the path's own curvature in the extinction (under 2 % of its length for
//! the Earth).

use crate::catalog::{Atmosphere, Body, Species};
use glam::{DVec3, DVec4};

/// Layers; the array's size in shaders/lib/draw.wgsl.
const LAYERS: usize = 32;
/// Heights in a layer whose transmissions are averaged.
const HEIGHTS: usize = 4;

pub(super) struct Layers {
    /// Thickness of the air.
    pub top: f64,
    /// Radius and bending (radians) at the lower edge, then at the upper.
    pub edges: Vec<DVec4>,
    pub passes: Vec<DVec3>,
}

/// Whether the catalog knows how strongly the body's air bends light.
pub(super) fn bends(body: &Body) -> bool {
    body.atmosphere.as_ref().is_some_and(|air| air.refractivity.is_some() && gas(air).is_some())
}

/// The species whose molecules bend the light: the first that scatters by Rayleigh's law and thins out upward.
fn gas(air: &Atmosphere) -> Option<&Species> {
    air.species.iter().find(|s| s.asymmetry.is_none() && s.tent_centre_km.is_none() && s.scattering_per_km[1] > 0.0)
}

/// Layers of a body's air in units of `unit_km`; `radius` is that of its outline.
pub(super) fn layers(body: &Body, unit_km: f64, radius: f64) -> Option<Layers> {
    let air = body.atmosphere.as_ref()?;
    let (refractivity, gas) = (air.refractivity?, gas(air)?);
    let radius_km = radius * unit_km;
    // Thin layers below, where bending and dimming change fast.
    let height_km = |edge: f64| air.top_km * (edge / LAYERS as f64).powf(1.5);
    let at = |edge: usize| {
        let h = height_km(edge as f64);
        let there = refractivity * (-h / gas.scale_height_km).exp();
        let bending = there * (std::f64::consts::TAU * (radius_km + h) / gas.scale_height_km).sqrt();
        // A ray that grazes at a height comes from a little above it.
        ((radius_km + h) * (1.0 + there) / unit_km, bending)
    };
    let edges = (0..LAYERS).map(|k| {
        let ((r0, b0), (r1, b1)) = (at(k), at(k + 1));
        DVec4::new(r0, b0, r1, b1)
    });
    let passes = (0..LAYERS).map(|k| {
        let part = |j: usize| transmission(air, radius_km, height_km(k as f64 + (j as f64 + 0.5) / HEIGHTS as f64));
        (0..HEIGHTS).map(part).sum::<DVec3>() / HEIGHTS as f64
    });
    Some(Layers { top: at(LAYERS).0 - radius, edges: edges.collect(), passes: passes.collect() })
}

/// What is left of a straight ray that grazes at a height, per channel.
fn transmission(air: &Atmosphere, radius_km: f64, height_km: f64) -> DVec3 {
    let grazing_km = radius_km + height_km;
    let half_km = ((radius_km + air.top_km).powi(2) - grazing_km * grazing_km).max(0.0).sqrt();
    // Midpoints, denser near the grazing point: s = half u².
    const STEPS: usize = 48;
    let depth: DVec3 = (0..STEPS)
        .map(|k| {
            let u = (k as f64 + 0.5) / STEPS as f64;
            let s_km = half_km * u * u;
            let h_km = grazing_km.hypot(s_km) - radius_km;
            let weight_km = 2.0 * half_km * 2.0 * u / STEPS as f64;
            let extinction =
                |s: &Species| (DVec3::from_array(s.scattering_per_km) + DVec3::from_array(s.absorption_per_km)) * density(s, h_km);
            air.species.iter().map(extinction).sum::<DVec3>() * weight_km
        })
        .sum();
    (-depth).exp()
}

/// Over that at the reference level; a tent over that at its tip.
fn density(species: &Species, height_km: f64) -> f64 {
    match species.tent_centre_km {
        None => (-height_km / species.scale_height_km).exp(),
        Some(centre_km) => (1.0 - (height_km - centre_km).abs() / species.scale_height_km).max(0.0),
    }
}
