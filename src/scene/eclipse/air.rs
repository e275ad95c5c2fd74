//! An occluder's air as layers that bend light and let a part of it through.
//!
//! Bending of a ray that grazes an exponential atmosphere: refractivity there times sqrt(2 pi r / H) (Baum and Code 1953, Astron. J.
//! 58, 108); the air keeps one temperature, its scale height is that of its gas. What a layer lets through: extinction by the catalog's species
//! along the straight grazing ray, and haze and gaps between clouds where the catalog's body has clouds. Left out: weather, and the path's own curvature in the extinction (under 2 % of its length for
//! the Earth).

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::extinction::optical_depth;
use crate::scene::atmosphere::species::gas;
use glam::{DVec3, DVec4};

pub use crate::scene::constants::REFRACTION_LAYERS as LAYERS;
/// Heights in a layer whose transmissions are averaged.
const HEIGHTS: usize = 4;

/// Clouds of the Earth by their tops, km, and the part of the sky that they cover: low, middle and high (Rossow and Schiffer 1999, Bull.
/// Amer. Meteor. Soc. 80, 2261).
const CLOUD_TOPS: [(f64, f64); 3] = [(2.5, 0.27), (6.5, 0.19), (12.0, 0.22)];
/// Haze of the free troposphere and the lower stratosphere, which the catalog's aerosol of the mixed layer lacks: about 1e-3 per km at 6 km
/// and 1e-4 at 18 km in green (quiet years of SAGE II: Thomason et al. 1997, J. Geophys. Res. 102, 8967), by the wavelength to -1.3.
const HAZE_PER_KM: [f64; 3] = [3.5e-3, 4.0e-3, 5.0e-3];
const HAZE_HEIGHT_KM: f64 = 5.0;
/// Length over which cloud is of one piece: that of a weather front.
const CLOUD_FIELD_KM: f64 = 300.0;

pub(crate) struct RefractingLayers {
    /// Thickness of the air.
    pub top: f64,
    /// Radius and bending (radians) at the lower edge, then at the upper.
    pub edges: Vec<DVec4>,
    pub passes: Vec<DVec3>,
}

impl RefractingLayers {
    /// About the green light that they bend to a point: `distance` from the axis in solar radii of `scale` a unit, `depth` units behind.
    pub fn light(&self, distance: f64, depth: f64, scale: f64) -> f64 {
        let layer = |(edge, passes): (&DVec4, &DVec3)| {
            let ring = 0.5 * (edge.x + edge.z - (edge.y + edge.w) * depth).abs() * scale;
            // The part of the ring's circle that lies on the Sun's disc.
            let cosine = (ring * ring + distance * distance - 1.0) / (2.0 * ring * distance).max(1e-9);
            let shows = cosine.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
            (edge.z * edge.z - edge.x * edge.x) * scale * scale * shows * crate::units::luminance(passes.to_array())
        };
        self.edges.iter().zip(&self.passes).map(layer).sum()
    }
}

/// Whether the catalog knows how strongly the body's air bends light.
pub(crate) fn bends(body: &Body) -> bool {
    body.atmosphere.as_ref().is_some_and(|air| air.refractivity.is_some() && gas(air).is_some())
}

/// Part of a bending by which the place that it shows of the Sun moves on the sky of a point: all of it for a Sun at infinity. `depth`: of the
/// body from the point, `sun`: of the Sun.
pub(crate) fn shown(depth: f64, sun: f64) -> f64 {
    (1.0 - depth / sun).clamp(0.0, 1.0)
}

/// The greatest bending of [`layers`], radians: of the ray that grazes the ground. `None` where it is not known.
pub(crate) fn greatest_bending(body: &Body, shown: f64) -> Option<f64> {
    let air = body.atmosphere.as_ref()?;
    Some(bending(air.refractivity?, body.radii_km.x, gas(air)?.scale_height_km) * shown)
}

/// Of a ray that grazes where the refractivity is `there`, radians.
fn bending(there: f64, radius_km: f64, scale_height_km: f64) -> f64 {
    there * (std::f64::consts::TAU * radius_km / scale_height_km).sqrt()
}

/// Layers of a body's air in units of `unit_km`; `radius` is that of its outline, `shown` [`shown`] from where it is looked at.
pub(crate) fn layers(body: &Body, unit_km: f64, radius: f64, shown: f64) -> Option<RefractingLayers> {
    let air = body.atmosphere.as_ref()?;
    let (refractivity, gas) = (air.refractivity?, gas(air)?);
    let radius_km = radius * unit_km;
    // Thin layers below, where bending and dimming change fast; from there in steps that grow with height. Of the ways tried (powers, exponentials,
    // other factors) this one is nearest to the integral: tests/atmosphere/refracted_limb.rs.
    let thin_km = 0.75 * gas.scale_height_km;
    let height_km = |edge: f64| thin_km * (edge / LAYERS as f64 * (air.top_km / thin_km).asinh()).sinh();
    let at = |edge: usize| {
        let h = height_km(edge as f64);
        let there = refractivity * (-h / gas.scale_height_km).exp();
        // A ray that grazes at a height comes from a little above it.
        ((radius_km + h) * (1.0 + there) / unit_km, bending(there, radius_km + h, gas.scale_height_km) * shown)
    };
    let edges = (0..LAYERS).map(|k| {
        let ((r0, b0), (r1, b1)) = (at(k), at(k + 1));
        DVec4::new(r0, b0, r1, b1)
    });
    let passes = (0..LAYERS).map(|k| {
        let part = |j: usize| {
            let h_km = height_km(k as f64 + (j as f64 + 0.5) / HEIGHTS as f64);
            let weather = if body.clouds.is_some() { through_haze(radius_km, h_km) * between_clouds(radius_km, h_km) } else { DVec3::ONE };
            transmission(air, radius_km, h_km) * weather
        };
        (0..HEIGHTS).map(part).sum::<DVec3>() / HEIGHTS as f64
    });
    Some(RefractingLayers { top: at(LAYERS).0 - radius, edges: edges.collect(), passes: passes.collect() })
}

/// Steps from the grazing point outwards.
const STEPS: usize = 48;

/// What is left of a straight ray that grazes at a height, per channel.
fn transmission(air: &Atmosphere, radius_km: f64, height_km: f64) -> DVec3 {
    let grazing_km = radius_km + height_km;
    let half_km = ((radius_km + air.top_km).powi(2) - grazing_km * grazing_km).max(0.0).sqrt();
    let half = optical_depth(air, half_km, STEPS, |s_km| grazing_km.hypot(s_km) - radius_km);
    (-2.0 * half).exp()
}

/// What the thin haze above the Earth's mixed layer lets through of a grazing ray.
fn through_haze(radius_km: f64, height_km: f64) -> DVec3 {
    let way_km = (std::f64::consts::TAU * (radius_km + height_km) * HAZE_HEIGHT_KM).sqrt();
    (DVec3::from_array(HAZE_PER_KM) * (-way_km * (-height_km / HAZE_HEIGHT_KM).exp())).exp()
}

/// The part of rays grazing at a height that meets no cloud: each kind leaves its clear part once for every field along the way below its
/// tops.
fn between_clouds(radius_km: f64, height_km: f64) -> f64 {
    let clear = |(top_km, cover): (f64, f64)| {
        let way_km = 2.0 * ((radius_km + top_km).powi(2) - (radius_km + height_km).powi(2)).max(0.0).sqrt();
        (1.0 - cover).powf(way_km / CLOUD_FIELD_KM)
    };
    CLOUD_TOPS.into_iter().map(clear).product()
}
