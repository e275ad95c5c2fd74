//! The rim of air beyond the limb: its height in pixels, its light relative to that of the body, and whether it is left out or averaged over pixels.
//!
//! In: a body, its air, its diameter in pixels and its phase angle. Out: [`Rim`]. A rim less than half a pixel high is left out only if
//! it adds less than [`MIN_LIGHT_RATIO`] of the disc's light at this phase. A crescent has little light, so its rim is kept.

use crate::catalog::{Atmosphere, Body, Species};
use crate::scene::atmosphere::extinction::{density, extinction, scattering};
use crate::scene::atmosphere::phase;
use crate::scene::atmosphere::species::{colours_exclude_air, is_visible_over_disc};
use crate::scene::light::photometry;
use crate::scene::numeric::smooth_rise;
use glam::DVec3;
use std::f64::consts::PI;

/// Height in pixels from which the rim is drawn whatever its light.
pub(crate) const ALWAYS_DRAWN_RIM_PX: f64 = 0.5;
/// Height in pixels from which the rings' shadow on the rim is evaluated at samples along each ray; on a lower rim, one mean serves each ray.
pub(crate) const MIN_SAMPLED_SHADOW_PX: f64 = 1.0;
/// Ratio of the rim's light to the disc's below which a rim lower than [`ALWAYS_DRAWN_RIM_PX`] is left out.
pub(crate) const MIN_LIGHT_RATIO: f64 = 0.005;
/// Height in pixels below which a rim with more than [`MIN_AVERAGED_LIGHT_RATIO`] of the disc's light is averaged over each pixel. One ray per pixel shows a
/// rim of half a pixel with 1.5 times its light, one of a pixel with 1.2 times, one of two pixels with 1.07 times.
const MAX_AVERAGED_RIM_PX: f64 = 2.0;
/// See [`MAX_AVERAGED_RIM_PX`].
const MIN_AVERAGED_LIGHT_RATIO: f64 = 0.1;
/// Height of the bright part of a rim, in scale heights.
const BRIGHT_SCALE_HEIGHTS: f64 = 4.0;
const GROUND_HEIGHT_KM: f64 = 0.0;
/// Number of equal steps of height in which the light of the rim is summed.
const HEIGHT_STEPS: usize = 64;
/// Ratio of all light that the rim scatters to the light scattered once, for a rim that is opaque along the limb where it is bright: an estimate. The Earth's
/// is 1.8.
pub(crate) const ALL_ORDERS_TO_SINGLE_RATIO: f64 = 2.0;

/// The rim of a body's air as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rim {
    /// Height of the rim's bright part, pixels: [`BRIGHT_SCALE_HEIGHTS`] times the largest scale height, or all of the air.
    pub height_px: f64,
    /// The rim's light divided by that of the disc, both summed over the channels: an estimate that is mostly too large, up to five times.
    pub light_ratio: f64,
}

impl Rim {
    /// The rim of a body's air, for a disc of this diameter. `continues_disc`: whether the rim, where it is opaque, is drawn as a continuation of the disc's
    /// colour.
    pub(crate) fn of(body: &Body, air: &Atmosphere, diameter_px: f64, phase_angle_rad: f64, continues_disc: bool) -> Self {
        Self { height_px: height_px(body, air, diameter_px), light_ratio: light_ratio(body, air, phase_angle_rad, continues_disc) }
    }

    /// Whether the rim is lower than half a pixel, so that its light decides whether it is drawn.
    pub(crate) fn is_low(&self) -> bool {
        self.height_px < ALWAYS_DRAWN_RIM_PX
    }

    /// Whether the rim is too low and too faint to be drawn.
    pub(crate) fn is_negligible(&self) -> bool {
        self.is_low() && self.light_ratio < MIN_LIGHT_RATIO
    }

    /// Whether the rim's light must be averaged over each pixel, because one ray per pixel would show it much too bright.
    pub(crate) fn is_averaged(&self) -> bool {
        self.is_low() || (self.height_px < MAX_AVERAGED_RIM_PX && self.light_ratio > MIN_AVERAGED_LIGHT_RATIO)
    }
}

/// The species with an exponential profile: those that scatter light.
pub(crate) fn exponential(air: &Atmosphere) -> impl Iterator<Item = &Species> {
    air.species.iter().filter(|s| s.tent_centre_km.is_none())
}

/// Height in pixels of the bright rim beyond the limb.
pub(crate) fn height_px(body: &Body, air: &Atmosphere, diameter_px: f64) -> f64 {
    let rim_km = (BRIGHT_SCALE_HEIGHTS * exponential(air).map(|s| s.scale_height_km).fold(0.0, f64::max)).min(air.top_km);
    rim_km / (2.0 * body.radii_km.max_element()) * diameter_px
}

/// Of the ray that grazes at a height, per channel: its optical depth t, and t w p, where w is its single-scattering albedo and p the phase function times pi
/// (see [`light_ratio`]). `cos_scattering`: cosine of the angle by which the light is deflected, -1 for light that returns to where it came from.
pub(crate) fn tangent_ray(air: &Atmosphere, radius_km: f64, height_km: f64, cos_scattering: f64) -> (DVec3, DVec3) {
    let (mut depth, mut scattered) = (DVec3::ZERO, DVec3::ZERO);
    for s in exponential(air) {
        // The height is left out of the ray's distance from the centre.
        let column_km = (2.0 * PI * radius_km * s.scale_height_km).sqrt() * density(s, height_km);
        let per_steradian = phase::per_steradian(s.phase, cos_scattering);
        depth += extinction(s) * column_km;
        scattered += scattering(s) * per_steradian * (column_km * PI);
    }
    (depth, scattered)
}

/// Opacity along the ray that grazes at a height: the mean of the channels.
pub(crate) fn opacity_along_limb(air: &Atmosphere, radius_km: f64, height_km: f64) -> f64 {
    // The depth does not depend on the scattering angle.
    let cos_scattering = 0.0;
    let (depth, _scattered) = tangent_ray(air, radius_km, height_km, cos_scattering);
    (DVec3::ONE - (-depth).exp()).element_sum() / 3.0
}

/// Area that the air hides beyond the limb, divided by the disc's area: the air's opacity along grazing rays (mean of the channels), summed over height.
pub(crate) fn hidden_area_ratio(body: &Body, air: &Atmosphere) -> f64 {
    let radius_km = body.radii_km.max_element();
    let step_km = air.top_km / HEIGHT_STEPS as f64;
    let opacity = |height_km: f64| opacity_along_limb(air, radius_km, height_km);
    // A ring one step high has the area 2 pi times its radius times the step; the disc has pi times its radius squared.
    let opaque_radii_km =
        (0..HEIGHT_STEPS).map(|k| (k as f64 + 0.5) * step_km).map(|height_km| opacity(height_km) * (radius_km + height_km));
    2.0 * step_km * opaque_radii_km.sum::<f64>() / radius_km.powi(2)
}

/// How much of the rim continues the disc's colour, 0 to 1, if the body's colours include its air. The part rises from 0 at an opacity along the limb of 0.2
/// to 1 at 0.5, as in `disc_beyond_limb` of shaders/lib/air/in_front.wesl. `limb_opacity`: the opacity along the limb, the mean of the channels.
pub(crate) fn continued_part(limb_opacity: f64) -> f64 {
    smooth_rise((0.2, 0.5), limb_opacity)
}

/// Whether the air that is opaque along the limb continues the disc's colour, for a camera above the air: the colour includes the air, and the air is not drawn
/// over the disc.
pub(crate) fn continues_disc(body: &Body, air: &Atmosphere) -> bool {
    !colours_exclude_air(body) && !is_visible_over_disc(air)
}

/// Light, at a phase angle of 90 degrees, of a rim that continues the disc's colour, divided by the light of a uniform disc as bright as ground under a Sun in
/// the zenith. At other phase angles it is proportional to their sine: see [`light_ratio`].
fn light_if_continued(air: &Atmosphere, radius_km: f64) -> f64 {
    let step_km = air.top_km / HEIGHT_STEPS as f64;
    let opaque_km = (0..HEIGHT_STEPS).map(|k| opacity_along_limb(air, radius_km, (k as f64 + 0.5) * step_km)).sum::<f64>() * step_km;
    2.0 * opaque_km / (opacity_along_limb(air, radius_km, GROUND_HEIGHT_KM).max(1e-12) * PI * radius_km)
}

/// As [`light_if_continued`], times the part of the rim that continues the disc's colour; 0 without such a rim. For a distant camera.
pub(crate) fn continued_light(body: &Body) -> f64 {
    let Some(air) = body.atmosphere.as_ref().filter(|air| continues_disc(body, air)) else { return 0.0 };
    let radius_km = body.radii_km.max_element();
    let part = continued_part(opacity_along_limb(air, radius_km, GROUND_HEIGHT_KM));
    if part > 0.0 { part * light_if_continued(air, radius_km) } else { 0.0 }
}

/// The rim's light divided by the disc's.
///
/// A ray that grazes at height z has the column sqrt(2 pi R H) n(z) of a species of scale height H and density n. Let t(z) be the ray's optical depth, w(z) its
/// single-scattering albedo, and p the phase function times pi. In full sunlight, light scattered once then gives the ray the radiance p w (1 - exp(-t))
/// per irradiance; light of all orders gives it [`ALL_ORDERS_TO_SINGLE_RATIO`] times as much. The ring of circumference 2 pi R, bright all around, emits 2 pi R
/// times the integral of this over z; the disc emits pi R^2 times geometric albedo and phase function. Neglected, because all make the rim darker: half of the
/// limb is beyond the terminator, sunlight is weakened on its way, and layers absorb.
///
/// With `continues_disc`, the disc's colour continues beside air that is opaque along the limb (`disc_beyond_limb` of shaders/lib/air/in_front.wesl). Relative
/// to ground under a Sun in the zenith, its radiance is sin(phase angle) cos(angle around the disc's centre from the direction of the Sun) times o, the ray's
/// opacity divided by that of a ray that grazes the ground. Over the lit half of the limb this sums to 2 R sin(phase angle) times the integral of o over z; the
/// disc emits pi R^2 times the geometric albedo and the phase function of its photometric model.
fn light_ratio(body: &Body, air: &Atmosphere, phase_angle_rad: f64, continues_disc: bool) -> f64 {
    let radius_km = body.radii_km.max_element();
    let cos_scattering = -phase_angle_rad.cos();
    let step_km = air.top_km / HEIGHT_STEPS as f64;
    let mut scattered_km = DVec3::ZERO;
    for k in 0..HEIGHT_STEPS {
        let (depth, scattered) = tangent_ray(air, radius_km, (k as f64 + 0.5) * step_km, cos_scattering);
        let opacity = DVec3::ONE - (-depth).exp();
        scattered_km += scattered * opacity / depth.max(DVec3::splat(1e-12)) * step_km;
    }
    let disc_light = body.colour.as_dvec3().element_sum() * body.geometric_albedo * photometry::phase(body, phase_angle_rad);
    let scattered_ratio = ALL_ORDERS_TO_SINGLE_RATIO * 2.0 * scattered_km.element_sum() / (radius_km * disc_light.max(1e-12));
    if !continues_disc {
        return scattered_ratio;
    }
    // All channels of the model's albedo are equal, since the body reflects.
    let [model_albedo, ..] = photometry::model_geometric_albedo(&body.photometry);
    let model_light = model_albedo * photometry::model_phase(&body.photometry, phase_angle_rad);
    let continued_ratio = phase_angle_rad.sin() * light_if_continued(air, radius_km) / model_light.max(1e-12);
    let part = continued_part(opacity_along_limb(air, radius_km, GROUND_HEIGHT_KM));
    scattered_ratio + (continued_ratio - scattered_ratio) * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    fn rim(catalog: &Catalog, name: &str, continues_disc: bool, diameter_px: f64, phase_deg: f64) -> Rim {
        let body = catalog.bodies().iter().find(|b| b.name == name).expect(name);
        Rim::of(body, body.atmosphere.as_ref().expect("air"), diameter_px, phase_deg.to_radians(), continues_disc)
    }

    #[test]
    fn crescents_keep_their_rim_at_every_size() {
        let catalog = Catalog::embedded();
        for (name, continues_disc) in
            [("Earth", false), ("Mars", false), ("Titan", false), ("Venus", true), ("Uranus", true), ("Jupiter", true)]
        {
            for diameter_px in [3.0, 24.0, 100.0] {
                assert!(!rim(&catalog, name, continues_disc, diameter_px, 170.0).is_negligible(), "{name} {diameter_px}");
            }
        }
        // Drawn in 2048 pixels, the rim of Venus has 0.72 of the light of its disc at 173.4 degrees, whose thin crescent the rim continues.
        let continues_disc = true;
        let (diameter_px, phase_deg) = (48.0, 173.4);
        let venus = rim(&catalog, "Venus", continues_disc, diameter_px, phase_deg).light_ratio;
        assert!((0.5..1.0).contains(&venus), "{venus}");
        // The limb of a full disc is dark, and so is the rim that continues it, though not black.
        for name in ["Jupiter", "Saturn", "Uranus", "Neptune"] {
            let (diameter_px, phase_deg) = (40.0, 5.0);
            let full = rim(&catalog, name, continues_disc, diameter_px, phase_deg);
            assert!(full.is_negligible() && full.light_ratio > 1e-5, "{name}: {full:?}");
        }
        // Height decides from half a pixel on, and light below it. The numbers are just below and just above the limits.
        let low = Rim { height_px: 0.499, light_ratio: 0.004 };
        assert!(
            low.is_negligible() && !Rim { light_ratio: 0.006, ..low }.is_negligible() && !Rim { height_px: 0.501, ..low }.is_negligible()
        );
        assert!(low.is_averaged() && !Rim { height_px: 0.501, ..low }.is_averaged());
        assert!(Rim { height_px: 1.9, light_ratio: 0.11 }.is_averaged() && !Rim { height_px: 2.1, light_ratio: 0.11 }.is_averaged());
    }

    /// The haze of Titan is opaque up to about 300 km, the dust of Mars up to 30 km. Opaque rings of these heights hide (1 + 300 / 2575)² - 1 = 0.25 and
    /// (1 + 30 / 3396)² - 1 = 0.018 of the discs' areas.
    #[test]
    fn haze_hides_more_than_the_disc() {
        let catalog = Catalog::embedded();
        let ratio = |name: &str| {
            let body = catalog.bodies().iter().find(|b| b.name == name).expect(name);
            hidden_area_ratio(body, body.atmosphere.as_ref().expect("air"))
        };
        assert!((0.2..0.35).contains(&ratio("Titan")), "{}", ratio("Titan"));
        assert!((0.005..0.03).contains(&ratio("Mars")), "{}", ratio("Mars"));
    }

    /// The sums against closed forms: the light that the air of Venus scatters, which is only gas, and the light with which it continues a Lambert disc.
    #[test]
    fn the_light_of_the_rim_is_that_of_its_columns() {
        let catalog = Catalog::embedded();
        let venus = catalog.bodies().iter().find(|b| b.name == "Venus").expect("Venus");
        let air = venus.atmosphere.as_ref().expect("air");
        let gas = exponential(air).next().expect("gas");
        let [scale_height_km, radius_km] = [gas.scale_height_km, venus.radii_km.max_element()];
        // Ein(t) = sum of (-1)^(n + 1) t^n / (n n!) is the integral of 1 - exp(-t exp(-z)) over z from 0 to infinity.
        let ein = |t: f64| {
            let mut term = 1.0;
            (1..60).fold(0.0, |sum, n| {
                let n = f64::from(n);
                term *= -t / n;
                sum - term / n
            })
        };
        let phase_angle_rad = 1.2_f64;
        // Optical depth along the limb.
        let limb_depth = DVec3::from_array(gas.scattering_per_km) * (2.0 * PI * radius_km * scale_height_km).sqrt();
        // The opacity along grazing rays integrated over height, summed over the channels.
        let equivalent_km: f64 = limb_depth.to_array().iter().map(|t| ein(*t) * scale_height_km).sum();
        let disc_light = venus.colour.as_dvec3().element_sum() * venus.geometric_albedo * photometry::phase(venus, phase_angle_rad);
        // The same in all channels.
        let rayleigh = phase::per_steradian(gas.phase, -phase_angle_rad.cos()).x;
        let scattered_ratio = 2.0 * ALL_ORDERS_TO_SINGLE_RATIO * PI * rayleigh * equivalent_km / (disc_light * radius_km);
        let continues_disc = false;
        let ratio = light_ratio(venus, air, phase_angle_rad, continues_disc) / scattered_ratio;
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
        // The limb of a Lambert disc, as bright at the position angle f as sin(phase angle) cos(f), and the light of the whole disc: 2 / 3 of its area times
        // the phase function. With the catalog's coefficients, the gas hides 57 % of what is behind it along the limb.
        let limb_opacity = limb_depth.to_array().iter().map(|t| 1.0 - (-t).exp()).sum::<f64>() / 3.0;
        assert!((limb_opacity - 0.57).abs() < 0.02, "{limb_opacity}");
        let continued_ratio = 2.0 * phase_angle_rad.sin() * (equivalent_km / 3.0 / limb_opacity)
            / (PI * radius_km * photometry::lambert_phase(phase_angle_rad) * 2.0 / 3.0);
        let continues_disc = true;
        let ratio = light_ratio(venus, air, phase_angle_rad, continues_disc) / continued_ratio;
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    }
}
