//! An occluder's atmosphere as layers, each with bending angles and a transmittance.
//!
//! In: a body with an atmosphere. Out: [`RefractingLayers`]. The bending angle of a ray that grazes an exponential atmosphere is the refractivity at the
//! grazing point times sqrt(2 pi r / H), with r the distance of this point from the body's centre and H the scale height (Baum and Code 1953, Astron. J. 58,
//! 108); the atmosphere is isothermal with the scale height of its gas. The transmittance of a layer includes extinction by the catalog's species along the
//! straight grazing ray, and for bodies with clouds also by haze and clouds, with mean values of the Earth. Not modelled: weather, and the curvature of the ray
//! in the extinction (it changes the ray's length in the Earth's air by less than 2 %).

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::extinction::optical_depth;
use crate::scene::atmosphere::species::rayleigh;
use glam::{DVec3, DVec4};

pub use crate::scene::constants::REFRACTION_LAYERS as LAYERS;
/// Number of heights per layer over which transmittance is averaged.
const HEIGHTS_PER_LAYER: usize = 4;

/// For the Earth's low, middle and high clouds: height of their tops, km, and the fraction of the sky that they cover (Rossow and Schiffer 1999, Bull. Amer.
/// Meteor. Soc. 80, 2261).
const CLOUD_TOPS_KM_AND_COVER: [(f64, f64); 3] = [(2.5, 0.27), (6.5, 0.19), (12.0, 0.22)];
/// Extinction of the haze in the free troposphere and the lower stratosphere, per km and channel, extrapolated down to the ground. The catalog's
/// aerosol covers only the mixed layer. The haze's extinction is about 1e-3 per km at 6 km and 1e-4 at 18 km in green (quiet years of
/// SAGE II: Thomason et al. 1997, J. Geophys. Res. 102, 8967); it varies as the wavelength to the power -1.3.
const HAZE_PER_KM: [f64; 3] = [3.5e-3, 4.0e-3, 5.0e-3];
const HAZE_SCALE_HEIGHT_KM: f64 = 5.0;
/// Length along a ray beyond which clouds are statistically independent; about the length of a weather front.
const CLOUD_CORRELATION_KM: f64 = 300.0;

/// Layers of an atmosphere from the ground up; the unit of length is the `unit_km` of [`layers`].
pub(crate) struct RefractingLayers {
    /// Height of the top of the highest layer: the apparent radius of this top minus the radius of the body's outline.
    pub top: f64,
    /// For each layer: apparent radius and reduced bending angle at the lower edge (x, y), then at the upper edge (z, w). The apparent radius is the impact
    /// parameter of the ray, the *reduced* bending angle the bending angle times [`shift_per_bending`], radians.
    pub edges: Vec<DVec4>,
    /// For each layer: its mean transmittance, per channel.
    pub transmittances: Vec<DVec3>,
}

impl RefractingLayers {
    /// Approximate fraction of sunlight that the layers refract to a point, per channel. `separation`: of the centres of Sun and occluder as seen from the
    /// point, in solar radii; `depth`: distance of the point behind the occluder, in the layers' unit of length; `to_solar_radii`: solar radii per that
    /// unit, for lengths at the occluder's distance as they appear from the point.
    pub(crate) fn refracted_fraction(&self, separation: f64, depth: f64, to_solar_radii: f64) -> DVec3 {
        let layer_fraction = |(edge, transmittance): (&DVec4, &DVec3)| {
            // The point sees the layer as a ring of mean radius r about the occluder's centre. Its light is bent inwards by a mean reduced angle b, so that it
            // left the Sun on the circle of radius |r - b depth| about this centre, here in solar radii.
            let radius = 0.5 * (edge.x + edge.z - (edge.y + edge.w) * depth).abs() * to_solar_radii;
            // The fraction of the circle's circumference that lies on the Sun's disc.
            let cosine = (radius * radius + separation * separation - 1.0) / (2.0 * radius * separation).max(1e-9);
            let visible_fraction = cosine.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
            // The layer's area relative to that of the Sun's disc, times the fraction of the layer that shows the Sun, times its transmittance.
            *transmittance * ((edge.z * edge.z - edge.x * edge.x) * to_solar_radii * to_solar_radii * visible_fraction)
        };
        self.edges.iter().zip(&self.transmittances).map(layer_fraction).sum()
    }
}

/// Whether the catalog has the refractivity of the body's air.
pub(crate) fn refracts(body: &Body) -> bool {
    body.atmosphere.as_ref().is_some_and(|air| air.refractivity.is_some() && rayleigh(air).is_some())
}

/// Angle by which the Sun's image shifts, as seen from a point, per angle by which the light bends: 1 for a Sun at infinity. `body_distance`: from the point to
/// the body whose air bends the light; `sun_distance`: from the point to the Sun, in the same unit. By the triangle of point, body and Sun, the shift times
/// `sun_distance` is the bending times the distance from body to Sun.
pub(crate) fn shift_per_bending(body_distance: f64, sun_distance: f64) -> f64 {
    (1.0 - body_distance / sun_distance).clamp(0.0, 1.0)
}

/// The largest reduced bending angle in [`RefractingLayers::edges`], radians: it belongs to the ray that grazes the ground. `None` if the refractivity is
/// unknown.
pub(crate) fn max_reduced_bending(body: &Body, shift_per_bending: f64) -> Option<f64> {
    let air = body.atmosphere.as_ref()?;
    Some(bending(air.refractivity?, body.radii_km.x, rayleigh(air)?.scale_height_km) * shift_per_bending)
}

/// Bending angle in radians of a ray that grazes the height where the air has this refractivity; see the module's documentation. `radius_km`: distance of that
/// height from the body's centre.
fn bending(refractivity: f64, radius_km: f64, scale_height_km: f64) -> f64 {
    refractivity * (std::f64::consts::TAU * radius_km / scale_height_km).sqrt()
}

/// Layers of a body's air in units of `unit_km`; `None` if the body has no air, or the catalog lacks its refractivity or its gas. `radius`: radius of the
/// body's outline, in the same unit; `shift_per_bending`: see [`shift_per_bending`].
pub(crate) fn layers(body: &Body, unit_km: f64, radius: f64, shift_per_bending: f64) -> Option<RefractingLayers> {
    let air = body.atmosphere.as_ref()?;
    let (refractivity, rayleigh) = (air.refractivity?, rayleigh(air)?);
    let radius_km = radius * unit_km;
    // The heights of the edges follow a sinh: layers are thin near the ground, where bending and extinction vary fast, and become thicker with height. With
    // the other spacings tried (powers, exponentials, other factors) the sum over the layers was farther from the integral over the air;
    // tests/atmosphere/refracted_limb.rs bounds the error. `edge`: from 0 at the ground to `LAYERS` at the top; fractions lie inside a layer.
    let sinh_scale_km = 0.75 * rayleigh.scale_height_km;
    let height_km = |edge: f64| sinh_scale_km * (edge / LAYERS as f64 * (air.top_km / sinh_scale_km).asinh()).sinh();
    // Apparent radius and reduced bending angle at an edge.
    let radius_and_bending_at = |edge: usize| {
        let h = height_km(edge as f64);
        let local_refractivity = refractivity * (-h / rayleigh.scale_height_km).exp();
        // Refraction makes a ray's impact parameter larger than its grazing radius.
        (
            (radius_km + h) * (1.0 + local_refractivity) / unit_km,
            bending(local_refractivity, radius_km + h, rayleigh.scale_height_km) * shift_per_bending,
        )
    };
    let edges = (0..LAYERS).map(|k| {
        let ((r0, b0), (r1, b1)) = (radius_and_bending_at(k), radius_and_bending_at(k + 1));
        DVec4::new(r0, b0, r1, b1)
    });
    let transmittances = (0..LAYERS).map(|k| {
        let sample = |j: usize| {
            let h_km = height_km(k as f64 + (j as f64 + 0.5) / HEIGHTS_PER_LAYER as f64);
            let haze_and_clouds =
                if body.clouds.is_some() { haze_transmittance(radius_km, h_km) * cloud_transmittance(radius_km, h_km) } else { DVec3::ONE };
            clear_transmittance(air, radius_km, h_km) * haze_and_clouds
        };
        (0..HEIGHTS_PER_LAYER).map(sample).sum::<DVec3>() / HEIGHTS_PER_LAYER as f64
    });
    let top = radius_and_bending_at(LAYERS).0 - radius;
    Some(RefractingLayers { top, edges: edges.collect(), transmittances: transmittances.collect() })
}

/// Integration steps of the optical depth from the grazing point to the top of the air.
const OPTICAL_DEPTH_STEPS: usize = 48;

/// Transmittance of clear air along a straight ray that grazes at a height, per channel.
fn clear_transmittance(air: &Atmosphere, radius_km: f64, height_km: f64) -> DVec3 {
    let grazing_km = radius_km + height_km;
    let half_path_km = ((radius_km + air.top_km).powi(2) - grazing_km * grazing_km).max(0.0).sqrt();
    let half_depth = optical_depth(air, half_path_km, OPTICAL_DEPTH_STEPS, |s_km| grazing_km.hypot(s_km) - radius_km);
    (-2.0 * half_depth).exp()
}

/// Transmittance of the thin haze above the Earth's mixed layer along a grazing ray.
fn haze_transmittance(radius_km: f64, height_km: f64) -> DVec3 {
    // The length that, at the density of the grazing point, has the column density of the entire ray through an exponential atmosphere.
    let path_km = (std::f64::consts::TAU * (radius_km + height_km) * HAZE_SCALE_HEIGHT_KM).sqrt();
    (DVec3::from_array(HAZE_PER_KM) * (-path_km * (-height_km / HAZE_SCALE_HEIGHT_KM).exp())).exp()
}

/// Fraction of rays grazing at a height that meet no cloud. For each kind of cloud, the path below its tops is divided into correlation lengths; on each of
/// them, the probability of meeting that kind is its cover.
fn cloud_transmittance(radius_km: f64, height_km: f64) -> f64 {
    let clear = |(top_km, cover): (f64, f64)| {
        let path_km = 2.0 * ((radius_km + top_km).powi(2) - (radius_km + height_km).powi(2)).max(0.0).sqrt();
        (1.0 - cover).powf(path_km / CLOUD_CORRELATION_KM)
    };
    CLOUD_TOPS_KM_AND_COVER.into_iter().map(clear).product()
}
