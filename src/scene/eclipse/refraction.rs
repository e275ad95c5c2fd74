//! An occluder's atmosphere as layers, each with bending angles and a transmittance.
//!
//! In: a body with an atmosphere. Out: [`RefractingLayers`]. The bending angle of a ray that grazes an exponential atmosphere is the refractivity at the
//! grazing point times sqrt(2 pi r / H), with r the distance of this point from the body's centre and H the scale height (Baum and Code 1953, Astron. J. 58,
//! 108); the atmosphere is isothermal with the scale height of its gas. The transmittance of a layer includes extinction by the catalog's species along the
//! straight grazing ray and by the catalog's `limb_haze_km`, and for bodies with clouds also by haze and clouds, with mean values of the Earth. Not modelled:
//! weather, and the curvature of the ray in the extinction (it changes the ray's length in the Earth's air by less than 2 %).
//!
//! Where the refractivity exceeds H / r (critical refraction: on Venus below 30 km), rays follow the ground or turn towards it and do not leave the air. The
//! layers begin above that height, and the air below it is opaque. Error of the bending angle against an integral along the curved ray: 5 % where the air
//! transmits at least a hundredth of green light (this module's test), 11 % at the Earth's ground.

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

/// Layers of an atmosphere from the ground up, or from the height of critical refraction; the unit of length is the `unit_km` of [`layers`].
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
        // The point sees the edge of a layer as a circle of radius r about the occluder's centre. Its light is bent inwards by the reduced angle b, so that it
        // left the Sun on the circle of radius r - b depth about this centre, here in solar radii. If this is negative, the circle shows the opposite side of
        // the Sun, and its area counts as negative. A distant Sun is much smaller than the ring between two such circles.
        let source_radius = |radius: f64, bending: f64| (radius - bending * depth) * to_solar_radii;
        let area_on_sun = |radius: f64| area_in_common(radius.abs(), separation).copysign(radius);
        let layer_fraction = |(edge, transmittance): (&DVec4, &DVec3)| {
            let (below, above) = (source_radius(edge.x, edge.y), source_radius(edge.z, edge.w));
            let ring = std::f64::consts::PI * (above * above.abs() - below * below.abs());
            // The fraction of the ring that lies on the Sun's disc.
            let visible_fraction = ((area_on_sun(above) - area_on_sun(below)) / ring.max(1e-12)).clamp(0.0, 1.0);
            // The layer's area relative to that of the Sun's disc, times the fraction of the layer that shows the Sun, times its transmittance.
            *transmittance * ((edge.z * edge.z - edge.x * edge.x) * to_solar_radii * to_solar_radii * visible_fraction)
        };
        self.edges.iter().zip(&self.transmittances).map(layer_fraction).sum()
    }
}

/// The area that the Sun's disc and a circle have in common, as `common_area` of shaders/lib/eclipse/refraction.wesl. `radius`: of the circle; `separation`:
/// of the two centres; both in solar radii.
fn area_in_common(radius: f64, separation: f64) -> f64 {
    if separation >= 1.0 + radius {
        return 0.0;
    }
    if separation <= (1.0 - radius).abs() {
        return std::f64::consts::PI * radius.min(1.0).powi(2);
    }
    // Distances of the line through both crossings of the circles from the two centres.
    let from_sun = ((1.0 + (separation - radius) * (separation + radius)) / (2.0 * separation)).clamp(-1.0, 1.0);
    let from_circle = (separation - from_sun).clamp(-radius, radius);
    let segment = |radius: f64, distance: f64| {
        let half_chord = ((radius - distance) * (radius + distance)).max(0.0).sqrt();
        radius * radius * half_chord.atan2(distance) - distance * half_chord
    };
    segment(1.0, from_sun) + segment(radius, from_circle)
}

/// Whether light that an occluder's air bends may reach a receiver that its penumbra touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BentLight {
    /// The air bends no light, or the occluder is in another system: a planet in transit, whose bent light is too faint to matter. There are shaders with
    /// refraction only for occluders in the receiver's system (`model::max_occluders`).
    None,
    /// The entire receiver is so deep in the umbra that no ray is bent enough.
    Misses,
    /// Some of it gets such light. In the penumbra the air takes sunlight, too: in that of Jupiter on Io up to a sixth of it.
    Reaches,
}

/// The gas by which a body's air bends light.
struct RefractingGas {
    /// Refractivity at height 0.
    refractivity: f64,
    scale_height_km: f64,
    /// The height above which rays leave the air: 0, or the height of critical refraction.
    lowest_km: f64,
}

impl RefractingGas {
    /// `None` if the body has no air, the catalog lacks its refractivity or its gas, or no ray below the top leaves it.
    fn of(body: &Body) -> Option<Self> {
        let air = body.atmosphere.as_ref()?;
        let (refractivity, scale_height_km) = (air.refractivity?, rayleigh(air)?.scale_height_km);
        // There the product of refractive index and radius, the impact parameter of a grazing ray, no longer grows with height.
        let critical_km = scale_height_km * (refractivity * body.radii_km.x / scale_height_km).ln();
        let lowest_km = critical_km.max(0.0);
        (lowest_km < air.top_km).then_some(Self { refractivity, scale_height_km, lowest_km })
    }

    fn refractivity_at(&self, height_km: f64) -> f64 {
        self.refractivity * (-height_km / self.scale_height_km).exp()
    }

    /// Bending angle in radians of a ray that grazes a height; see the module's documentation. `radius_km`: distance of height 0 from the body's centre.
    fn bending(&self, radius_km: f64, height_km: f64) -> f64 {
        self.refractivity_at(height_km) * (std::f64::consts::TAU * (radius_km + height_km) / self.scale_height_km).sqrt()
    }
}

/// Whether a body's air bends light that leaves it again (see `RefractingGas::of`).
pub(crate) fn refracts(body: &Body) -> bool {
    RefractingGas::of(body).is_some()
}

/// Angle by which the Sun's image shifts, as seen from a point, per angle by which the light bends: 1 for a Sun at infinity. `body_distance`: from the point to
/// the body whose air bends the light; `sun_distance`: from the point to the Sun, in the same unit. By the triangle of point, body and Sun, the shift times
/// `sun_distance` is the bending times the distance from body to Sun.
pub(crate) fn shift_per_bending(body_distance: f64, sun_distance: f64) -> f64 {
    (1.0 - body_distance / sun_distance).clamp(0.0, 1.0)
}

/// The largest reduced bending angle in [`RefractingLayers::edges`], radians: that of the lowest ray that leaves the air. `None` if the air does not
/// refract ([`refracts`]).
pub(crate) fn max_reduced_bending(body: &Body, shift_per_bending: f64) -> Option<f64> {
    let gas = RefractingGas::of(body)?;
    Some(gas.bending(body.radii_km.x, gas.lowest_km) * shift_per_bending)
}

/// Layers of a body's air in units of `unit_km`; `None` if its air does not refract ([`refracts`]). `radius`: radius of the
/// body's outline, in the same unit; `shift_per_bending`: see [`shift_per_bending`].
pub(crate) fn layers(body: &Body, unit_km: f64, radius: f64, shift_per_bending: f64) -> Option<RefractingLayers> {
    let air = body.atmosphere.as_ref()?;
    let gas = RefractingGas::of(body)?;
    let radius_km = radius * unit_km;
    // The heights of the edges follow a sinh: layers are thin near the ground, where bending and extinction vary fast, and become thicker with height. With
    // the other spacings tried (powers, exponentials, other factors) the sum over the layers was farther from the integral over the air;
    // tests/atmosphere/refracted_limb.rs bounds the error. `edge`: from 0 at the lowest edge to `LAYERS` at the top; fractions lie inside a layer.
    let sinh_scale_km = 0.75 * gas.scale_height_km;
    let thickness_km = air.top_km - gas.lowest_km;
    let height_km = |edge: f64| gas.lowest_km + sinh_scale_km * (edge / LAYERS as f64 * (thickness_km / sinh_scale_km).asinh()).sinh();
    // Apparent radius and reduced bending angle at an edge.
    let radius_and_bending_at = |edge: usize| {
        let h = height_km(edge as f64);
        // Refraction makes a ray's impact parameter larger than its grazing radius.
        ((radius_km + h) * (1.0 + gas.refractivity_at(h)) / unit_km, gas.bending(radius_km, h) * shift_per_bending)
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
            clear_transmittance(air, radius_km, h_km) * limb_haze_transmittance(air, h_km) * haze_and_clouds
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

/// Transmittance of a ray that grazes a height in the haze that the catalog gives only for refracted light.
fn limb_haze_transmittance(air: &Atmosphere, height_km: f64) -> f64 {
    let depth = air.limb_haze_km.map_or(0.0, |[unit_depth_km, scale_height_km]| ((unit_depth_km - height_km) / scale_height_km).exp());
    (-depth).exp()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// Bending angle of a ray that grazes a height of an exponential atmosphere: the integral along the curved ray of 2 b / sqrt((n r)² - b²) times the change
    /// of ln n, where b = n r at the grazing point.
    fn bending_by_integral(gas: &RefractingGas, radius_km: f64, grazing_km: f64) -> f64 {
        const STEPS: u32 = 4000;
        let (grazing_radius, refractivity) = (radius_km + grazing_km, gas.refractivity_at(grazing_km));
        let impact = grazing_radius * (1.0 + refractivity);
        // The height above the grazing point is the square of the variable of integration, so that the integrand is finite there.
        let end = (12.0 * gas.scale_height_km).sqrt();
        let integrand = |u: f64| {
            let (height, local) = (u * u, gas.refractivity_at(grazing_km + u * u));
            // n r - b without the difference of two nearly equal numbers.
            let above = (1.0 + local) * height + grazing_radius * refractivity * (-height / gas.scale_height_km).exp_m1();
            let sum = (1.0 + local) * (grazing_radius + height) + impact;
            2.0 * u * local / gas.scale_height_km / (1.0 + local) / (above * sum).sqrt()
        };
        let middles = (0..STEPS).map(|k| end * (f64::from(k) + 0.5) / f64::from(STEPS));
        2.0 * impact * middles.map(integrand).sum::<f64>() * end / f64::from(STEPS)
    }

    /// Bodies of the catalog whose air refracts, with their layers in kilometres for a Sun at infinity.
    fn refracting(catalog: &Catalog) -> Vec<(&Body, RefractingGas, RefractingLayers)> {
        let bodies = catalog.bodies().iter();
        bodies.filter_map(|body| Some((body, RefractingGas::of(body)?, layers(body, 1.0, body.radii_km.x, 1.0)?))).collect()
    }

    #[test]
    fn the_bending_angle_is_that_of_an_integral_along_the_ray() {
        let catalog = Catalog::embedded();
        let bodies = refracting(&catalog);
        assert_eq!(bodies.len(), 8);
        for (body, gas, layers) in bodies {
            let mut compared = 0;
            for (edge, transmittance) in layers.edges.iter().zip(&layers.transmittances).filter(|(_, t)| t.y > 0.01) {
                // The height whose grazing ray has this impact parameter, by iteration.
                let mut height_km = edge.x - body.radii_km.x;
                for _ in 0..50 {
                    height_km = edge.x / (1.0 + gas.refractivity_at(height_km)) - body.radii_km.x;
                }
                let integral = bending_by_integral(&gas, body.radii_km.x, height_km);
                assert!(
                    (edge.y / integral - 1.0).abs() < 0.07,
                    "{} at {height_km} km ({transmittance}): {} and {integral}",
                    body.name,
                    edge.y
                );
                compared += usize::from(edge.y > 1e-9);
            }
            assert!(compared > 5, "{}: {compared}", body.name);
        }
        // Negative control: near the height of critical refraction the formula fails.
        let neptune = catalog.body(NaifId(899)).and_then(RefractingGas::of).expect("its air refracts");
        assert!(bending_by_integral(&neptune, 24_764.0, 0.0) > 1.3 * neptune.bending(24_764.0, 0.0));
    }

    /// With the refractivity of Venus near its ground, rays that graze low heights do not leave the air. The layers begin above them.
    #[test]
    fn no_layer_is_below_the_height_of_critical_refraction() {
        let catalog = Catalog::embedded();
        let mut venus = catalog.body(NaifId(299)).expect("in the catalog").clone();
        let air = venus.atmosphere.as_mut().expect("air");
        (air.refractivity, air.top_km, air.limb_haze_km) = (Some(9e-3), 150.0, None);
        air.species[0].scale_height_km = 15.9;
        let radius_km = venus.radii_km.x;
        let gas = RefractingGas::of(&venus).expect("it refracts");
        // The impact parameter of a ray that grazes the ground is greater than that of one that grazes 10 km.
        assert!(radius_km * (1.0 + gas.refractivity_at(0.0)) > (radius_km + 10.0) * (1.0 + gas.refractivity_at(10.0)));
        assert!((15.0..25.0).contains(&gas.lowest_km), "{}", gas.lowest_km);
        let dense = layers(&venus, 1.0, radius_km, 1.0).expect("layers");
        let of_catalog = refracting(&catalog).into_iter().map(|(_, _, layers)| layers);
        for layers in of_catalog.chain([dense]) {
            for (edge, transmittance) in layers.edges.iter().zip(&layers.transmittances) {
                assert!(edge.z > edge.x && edge.w < edge.y && edge.w > 0.0 && edge.is_finite(), "{edge}");
                assert!(transmittance.min_element() >= 0.0 && transmittance.max_element() <= 1.0, "{transmittance}");
            }
            for depth in [1e3, 1e5, 1e7] {
                let light = layers.refracted_fraction(0.5, depth, 1e-3);
                assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
            }
        }
        // If no ray below the top leaves the air, nothing refracts.
        venus.atmosphere.as_mut().expect("air").top_km = 15.0;
        assert!(!refracts(&venus) && layers(&venus, 1.0, radius_km, 1.0).is_none());
    }

    /// The light of the layers in the shadows of planets on their moons, against an integral over heights without layers. Distances in kilometres. With the
    /// circle in the middle of each layer in place of its area, Triton would get no light 500 km within the shadow.
    #[test]
    fn layers_have_the_light_of_an_integral_over_heights() {
        const HEIGHTS: u32 = 3000;
        let catalog = Catalog::embedded();
        let mut lit = 0;
        // Planet, distance of the moon and of the Sun, depths of the Sun's centre behind the limb as seen from the moon.
        for (id, depth, sun_au, depths, tolerance) in [
            (599, 421_800.0, 5.2, [400.0, 900.0, 1500.0], 0.08),
            (599, 1_070_400.0, 5.2, [1000.0, 1500.0, 4000.0], 0.08),
            (699, 1_221_900.0, 9.5, [650.0, 1000.0, 2000.0], 0.08),
            (899, 354_800.0, 30.0, [100.0, 500.0, 1000.0], 0.2),
        ] {
            let body = catalog.body(NaifId(id)).expect("in the catalog");
            let (air, gas) = (body.atmosphere.as_ref().expect("air"), RefractingGas::of(body).expect("it refracts"));
            let radius_km = body.radii_km.x;
            let layers = layers(body, 1.0, radius_km, 1.0).expect("layers");
            let to_solar_radii = sun_au * crate::units::KM_PER_AU / 695_700.0 / depth;
            for behind_limb in depths {
                let separation = (radius_km - behind_limb) * to_solar_radii;
                let impact = |height: f64| (radius_km + height) * (1.0 + gas.refractivity_at(height));
                let at = |k: f64| gas.lowest_km + (air.top_km - gas.lowest_km) * (k / f64::from(HEIGHTS)).powi(2);
                let mut expected = DVec3::ZERO;
                for k in (0..HEIGHTS).map(f64::from) {
                    let (low, height, high) = (at(k), at(k + 0.5), at(k + 1.0));
                    let source = (impact(height) - gas.bending(radius_km, height) * depth).abs() * to_solar_radii;
                    let cosine = (source * source + separation * separation - 1.0) / (2.0 * source * separation);
                    let on_sun = cosine.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
                    if on_sun > 0.0 {
                        let transmittance = clear_transmittance(air, radius_km, height) * limb_haze_transmittance(air, height);
                        let area = (impact(high).powi(2) - impact(low).powi(2)) * to_solar_radii * to_solar_radii;
                        expected += transmittance * (area * on_sun);
                    }
                }
                let light = layers.refracted_fraction(separation, depth, to_solar_radii);
                println!("{}, {depth} km behind it, {behind_limb} km within the shadow: {light}, expected {expected}", body.name);
                assert!((light.y / expected.y - 1.0).abs() < tolerance, "{} {behind_limb}: {light}, not {expected}", body.name);
                assert!(light.x > light.z && light.x < 0.2, "{} {behind_limb}: {light}", body.name);
                lit += 1;
            }
        }
        assert_eq!(lit, 12);
    }

    #[test]
    fn haze_at_the_limb_has_its_depth_at_its_height() {
        let catalog = Catalog::embedded();
        let venus = catalog.body(NaifId(299)).expect("in the catalog");
        let air = venus.atmosphere.as_ref().expect("air");
        let [height_km, scale_height_km] = air.limb_haze_km.expect("haze");
        assert!((limb_haze_transmittance(air, height_km).ln() + 1.0).abs() < 1e-12);
        assert!((limb_haze_transmittance(air, height_km - 2.0_f64.ln() * scale_height_km).ln() + 2.0).abs() < 1e-12);
        let without = Atmosphere { limb_haze_km: None, ..air.clone() };
        assert!(limb_haze_transmittance(&without, 0.0) == 1.0);
        let clear = Body { atmosphere: Some(without), ..venus.clone() };
        let light = |body: &Body| layers(body, 1.0, body.radii_km.x, 1.0).expect("layers").transmittances[0].x;
        assert!(light(venus) < 1e-3 && light(&clear) > 0.5, "{} and {}", light(venus), light(&clear));
    }
}
