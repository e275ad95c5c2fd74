//! Approximate sunlight under occluders: for the exposure, for magnitudes and for bodies drawn as points.
//!
//! In: the occluders of a receiver, the eclipse model and the Sun. Out: the fraction of sunlight at a point, or its mean over the visible lit
//! ground, 0 to 1, per channel, because light that an occluder's air refracts is red. Drawn surfaces are shaded by shaders/lib/eclipse instead. Limb darkening
//! is ignored.
//!
//! As seen from the point, an occluder's outline is an ellipse. It is replaced by a circle of the ellipse's radius in the direction of the Sun's centre. With
//! the equatorial radius, a planet, which is hundreds of solar radii wide as seen from its moons, would hide the Sun even where the Sun is visible beyond a
//! pole of the oblate planet. The hidden fraction increases linearly as the separation decreases, from 0 at outer contact to the largest fraction that the
//! ellipse can hide, at inner contact. Of several occluders only the one that hides most counts.
//!
//! Largest error of the fraction, measured by this module's test against rays to a limb-darkened disc, in green. Radii are as seen from the receiver:
//! - 0.08 behind a planet as seen from its moons, behind Phobos and behind a round body of 0.3 solar radii;
//! - 0.13 behind round bodies of 1 and 2 solar radii;
//! - 0.16 behind elongated ones (semi-axes 0.75 to 2 solar radii).
//!
//! The comparison leaves out light refracted by the occluder's air. The finite number of points in the mean over the visible lit ground adds an error of at
//! most 0.005. For Pluto and Charon, whose shadows on each other have sharp edges, the bound is 0.02.

use crate::catalog::Body;
use crate::scene::draw::features::EclipseModel;
use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver};
use crate::scene::eclipse::refraction;
use crate::units::{GOLDEN_ANGLE_RAD, luminance};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Number of points in the mean over the visible lit ground.
const MEAN_POINTS: u32 = 300;
/// Number of points if a shadow is smaller than the receiver or has a sharp edge: then a single point changes the mean more.
const FINE_MEAN_POINTS: u32 = 600;
/// The edge of a shadow counts as sharp if the penumbra around its umbra is narrower than this, in receiver radii.
const SHARP_EDGE_WIDTH: f64 = 0.2;

/// Distance from the centre of an occluder's outline to its limb, measured along `direction`, equatorial radii of the receiver. `direction`: across the axis
/// ([`Axis::perpendicular_axes`]), of any length.
fn radius_towards(occluder: &Occluder<'_>, direction: DVec2) -> f64 {
    let along_axes = DVec2::new(direction.dot(occluder.long_axis), direction.dot(occluder.long_axis.perp()));
    let length = along_axes.length();
    if length > 0.0 { length / (along_axes / occluder.semi_axes).length() } else { occluder.semi_axes.x }
}

/// Approximate fraction of sunlight that occluders leave at points of a receiver, for discs without limb darkening.
pub(crate) struct ApproximateShadow<'a> {
    occluders: &'a [Occluder<'a>],
    /// From the receiver's centre to the Sun's.
    axis: Axis,
    /// The refracting layers of the first occluder's air: `model::choose_eclipse_model` has moved the occluder whose air refracts light to the first place.
    /// `None` if the model leaves out refraction, or if that air does not refract light.
    layers: Option<refraction::RefractingLayers>,
}

impl<'a> ApproximateShadow<'a> {
    /// `None` without occluders, or if the receiver's centre is inside the Sun.
    pub(crate) fn of(occluders: &'a [Occluder<'a>], model: EclipseModel, receiver: &Receiver<'_>, sun: &Body) -> Option<Self> {
        let axis = Axis::of(receiver, sun).filter(|_| !occluders.is_empty())?;
        let first = occluders.first().filter(|_| model == EclipseModel::Refracted);
        // Shift of the Sun's image per angle by which the light bends.
        let shift_per_bending = |o: &Occluder<'_>| refraction::shift_per_bending(o.distance_along, axis.sun_distance);
        let layers = first.and_then(|o| refraction::layers(o.body, receiver.radius_km(), o.semi_axes.x, shift_per_bending(o)));
        Some(Self { occluders, axis, layers })
    }

    /// Fraction of the luminance of sunlight at a point, whose position is given in the receiver's axes and equatorial radii.
    pub(crate) fn sunlight_fraction(&self, point: DVec3) -> f64 {
        luminance(self.sunlight(point).to_array())
    }

    /// Fraction of sunlight at a point in the channel with the greatest fraction: in the red light of an umbra some twice that of the luminance.
    pub(crate) fn brightest_sunlight_fraction(&self, point: DVec3) -> f64 {
        self.sunlight(point).max_element()
    }

    /// As [`Self::sunlight_fraction`], but per channel.
    fn sunlight(&self, point: DVec3) -> DVec3 {
        let (point_across, point_along) = (self.axis.offset_across(point), point.dot(self.axis.sunward));
        let mut fraction = DVec3::ONE;
        for (index, occluder) in self.occluders.iter().enumerate() {
            // Distance of the point behind the occluder, away from the Sun.
            let distance_behind = occluder.distance_along - point_along;
            if distance_behind <= 0.0 {
                continue;
            }
            // Factor from lengths at the occluder, in the receiver's equatorial radii, to apparent solar radii.
            let to_solar_radii = self.axis.cot_sun_angular_radius / distance_behind;
            let offset = occluder.offset_across - point_across;
            let layers = self.layers.as_ref().filter(|_| index == 0);
            // Most points are outside the penumbra: they are skipped before the radius is computed. Refracted light may reach such points.
            if layers.is_none()
                && offset.length_squared() * to_solar_radii * to_solar_radii >= (1.0 + occluder.semi_axes.x * to_solar_radii).powi(2)
            {
                continue;
            }
            // What is behind the air shines through its layers, so the top of the air hides the direct light.
            let air = layers.map_or(0.0, |layers| layers.top);
            let limb = radius_towards(occluder, offset);
            let (separation, radius) = (offset.length() * to_solar_radii, (limb + air) * to_solar_radii);
            // Linear in the separation: 0 at outer contact; at inner contact the largest fraction of the disc's area that the ellipse can hide (semi-axes
            // beyond one solar radius hide no more).
            let max_obscuration = ((occluder.semi_axes + DVec2::splat(air)) * to_solar_radii).min(DVec2::ONE).element_product();
            let obscuration = ((1.0 + radius - separation) / (1.0 + radius - (1.0 - radius).abs())).clamp(0.0, 1.0) * max_obscuration;
            fraction = fraction.min(DVec3::splat(1.0 - obscuration));
            if let Some(layers) = layers {
                // The layers are computed for a round limb whose radius is the major semi-axis. The separation is increased by the difference between this
                // radius and the one towards the Sun, so that the Sun's centre is as far from the round limb as it is from the elliptical outline.
                let separation = separation + (occluder.semi_axes.x - limb) * to_solar_radii;
                fraction += layers.refracted_fraction(separation, distance_behind, to_solar_radii);
            }
        }
        fraction.min(DVec3::ONE)
    }

    /// Number of points that the mean needs.
    fn mean_points(&self) -> u32 {
        // At the receiver's centre.
        let penumbra_width = |o: &Occluder<'_>| 2.0 * o.distance_along / self.axis.cot_sun_angular_radius;
        // The receiver's radius is 1.
        let needs_fine_mean = |o: &Occluder<'_>| o.semi_axes.y < 1.0 || penumbra_width(o) < SHARP_EDGE_WIDTH;
        if self.occluders.iter().any(needs_fine_mean) { FINE_MEAN_POINTS } else { MEAN_POINTS }
    }

    /// Mean fraction per channel over the lit ground that a viewer sees, weighted by the cosines of incidence and emission (Lambert). The receiver counts as a
    /// sphere, seen from a distance. `camera`: direction from the centre to the camera, body axes, of any length.
    pub(crate) fn mean_sunlight(&self, camera: DVec3) -> DVec3 {
        let to_sun = self.axis.sunward;
        let towards_camera = camera.normalize_or(to_sun);
        // The visible lit ground is a lune. `middle` points to its middle, halfway between the directions to the Sun and to the camera. `side` lies in the
        // plane of these three directions, perpendicular to `middle`; `pole` is perpendicular to that plane. All points lie in the lune, so that a thin
        // crescent gets as many as a full disc.
        let (sum, difference) = (to_sun + towards_camera, towards_camera - to_sun);
        let middle = sum.normalize_or(self.axis.perpendicular_axes[0]);
        let side = if difference.length() > 1e-6 { difference.normalize() } else { middle.any_orthonormal_vector() };
        let pole = side.cross(middle);
        // (pi - phase angle) / 2: the two lengths are twice the cosine and twice the sine of half the phase angle.
        let half_width_rad = sum.length().atan2(difference.length());
        let (mut sunlight, mut weights) = (DVec3::ZERO, 0.0);
        let points = self.mean_points();
        for k in 0..points {
            // A Fibonacci lattice on the unit sphere: equal steps in height above the plane of `middle` and `side`, and steps of the golden angle in longitude,
            // scaled to the lune's width. The first point has the longitude of the middle.
            let height = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(points);
            let turns = f64::from(k) * GOLDEN_ANGLE_RAD / TAU + 0.5;
            let (sin, cos) = (half_width_rad * (2.0 * turns.fract() - 1.0)).sin_cos();
            let point = (middle * cos + side * sin) * (1.0 - height * height).sqrt() + pole * height;
            let weight = point.dot(to_sun).max(0.0) * point.dot(towards_camera).max(0.0);
            sunlight += self.sunlight(point) * weight;
            weights += weight;
        }
        // All weights are 0 if the camera is exactly opposite to the Sun and sees only the night side.
        if weights > 0.0 { sunlight / weights } else { self.sunlight(middle) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::ephemeris::{BEST_SOURCE, Ephemeris};
    use crate::scene::eclipse::occluders::{limb_darkening, outline};
    use crate::time::Instant;
    use glam::DMat3;

    /// An ellipsoid in front of the Sun, as seen from a receiver.
    struct EclipseGeometry<'a> {
        receiver: Receiver<'a>,
        axis: Axis,
        sun: &'a Body,
        occluder: &'a Body,
        /// Semi-axes of the occluder, in the receiver's equatorial radii.
        radii: DVec3,
        /// Distance of the occluder's centre along the line to the Sun, in the receiver's equatorial radii.
        distance_along: f64,
        receiver_from_occluder: DMat3,
    }

    /// For [`EclipseGeometry::of`]: the occluder keeps its own semi-axes.
    const TRUE_SEMI_AXES: Option<DVec3> = None;

    impl<'a> EclipseGeometry<'a> {
        /// The occluder at its true distance from the receiver, but moved onto the line to the Sun. `ids`: NAIF codes of receiver and occluder.
        /// `semi_axes_in_solar_radii`: replaces the occluder's semi-axes; in units of the Sun's apparent radius at the receiver.
        fn of(catalog: &'a Catalog, ephemeris: &Ephemeris, ids: [i32; 2], semi_axes_in_solar_radii: Option<DVec3>) -> Self {
            let time = Instant::parse("2025-10-30T02:52:00Z").expect("a time");
            let [body, occluder, sun] = [ids[0], ids[1], 10].map(|id| catalog.body(NaifId(id)).expect("in the catalog"));
            let receiver = Receiver::at(ephemeris, body, time).expect("placed");
            let axis = Axis::of(&receiver, sun).expect("lit");
            let offset_km = ephemeris.state(occluder.id, body.id, time, BEST_SOURCE).expect("placed").state.pos_km;
            let distance_along = offset_km.length() / receiver.radius_km();
            let receiver_from_occluder =
                receiver.body_from_icrf * ephemeris.body_from_icrf(occluder.id, time).expect("an orientation").transpose();
            // A length at the occluder that looks as large as the Sun's radius, in the receiver's equatorial radii.
            let apparent_sun_radius = distance_along / axis.cot_sun_angular_radius;
            let radii = semi_axes_in_solar_radii.map_or(occluder.radii_km / receiver.radius_km(), |s| s * apparent_sun_radius);
            Self { receiver, axis, sun, occluder, radii, distance_along, receiver_from_occluder }
        }

        /// The occluder with its centre at an offset across the axis.
        fn occluder_at(&self, offset_across: DVec2) -> Occluder<'a> {
            let (long_axis, semi_axes) = outline(&self.axis, self.receiver_from_occluder, self.radii);
            Occluder {
                body: self.occluder,
                offset_across,
                distance_along: self.distance_along,
                long_axis,
                semi_axes,
                // The approximation does not read these two.
                max_blocked_fraction: 0.0,
                bent_light: refraction::BentLight::None,
            }
        }

        /// Distance of the occluder's outline from the axis at which the whole receiver is just outside the penumbra, or, behind a large
        /// occluder, just inside the umbra: the receiver's radius plus half the penumbra's width, in receiver radii.
        fn receiver_and_penumbra(&self) -> f64 {
            1.0 + self.distance_along / self.axis.cot_sun_angular_radius
        }

        /// The fraction of sunlight by [`ApproximateShadow`].
        fn approximate(&self, occluder: Occluder<'_>, point: DVec3) -> f64 {
            let occluders = [occluder];
            let shadow = ApproximateShadow::of(&occluders, EclipseModel::LimbDarkened, &self.receiver, self.sun).expect("an occluder");
            shadow.sunlight_fraction(point)
        }

        /// Whether a ray in `direction` from a point misses the ellipsoid, whose centre is at an offset across the axis.
        fn misses(&self, offset_across: DVec2, point: DVec3, direction: DVec3) -> bool {
            let centre = self.axis.perpendicular_axes[0] * offset_across.x
                + self.axis.perpendicular_axes[1] * offset_across.y
                + self.axis.sunward * self.distance_along;
            let in_unit_sphere = |v: DVec3| (self.receiver_from_occluder.transpose() * v) / self.radii;
            let (origin, ray) = (in_unit_sphere(point - centre), in_unit_sphere(direction).normalize());
            origin.dot(ray) > 0.0 || origin.cross(ray).length() > 1.0
        }

        /// The fraction of sunlight at a point by rays to points of the Sun's disc, weighted by its limb darkening in green.
        fn by_rays(&self, offset_across: DVec2, point: DVec3) -> f64 {
            const RAYS: u32 = 1500;
            let to_sun = self.axis.sunward * self.axis.sun_distance - point;
            let sun_radius = self.axis.sun_distance / self.axis.cot_sun_angular_radius;
            let (u1, u2) = limb_darkening(self.sun);
            let (mut total, mut visible) = (0.0, 0.0);
            for k in 0..RAYS {
                // Steps of the golden angle spread the points evenly.
                let radius = ((f64::from(k) + 0.5) / f64::from(RAYS)).sqrt();
                let on_disc = DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * (radius * sun_radius);
                let one_minus_mu = 1.0 - (1.0 - radius * radius).sqrt();
                let light = 1.0 - u1.y * one_minus_mu - u2.y * one_minus_mu * one_minus_mu;
                total += light;
                let direction = to_sun + self.axis.perpendicular_axes[0] * on_disc.x + self.axis.perpendicular_axes[1] * on_disc.y;
                visible += if self.misses(offset_across, point, direction) { light } else { 0.0 };
            }
            visible / total
        }

        /// Mean fraction of sunlight over the receiver's lit side as the Sun sees it, by rays.
        fn mean_by_rays(&self, offset_across: DVec2) -> f64 {
            const POINTS: u32 = 100;
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in 0..POINTS {
                let radius_sq = (f64::from(k) + 0.5) / f64::from(POINTS);
                let (on_disc, cosine) = (DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * radius_sq.sqrt(), (1.0 - radius_sq).sqrt());
                let point =
                    self.axis.perpendicular_axes[0] * on_disc.x + self.axis.perpendicular_axes[1] * on_disc.y + self.axis.sunward * cosine;
                sum += cosine * self.by_rays(offset_across, point);
                weights += cosine;
            }
            sum / weights
        }

        /// ([largest error, largest error if round], [number of positions with the Sun hidden, partly hidden, entirely visible]) over positions of the occluder
        /// at all position angles and impact parameters, as seen from the receiver's centre and from a point of its ground. "If round": the outline is
        /// replaced by a circle whose radius is the major semi-axis.
        fn largest_errors(&self) -> ([f64; 2], [u32; 3]) {
            let (mut errors, mut counts) = ([0.0_f64; 2], [0; 3]);
            for point in [DVec3::ZERO, self.axis.sunward * 0.8 + self.axis.perpendicular_axes[0] * 0.6] {
                let apparent_sun_radius = (self.distance_along - point.dot(self.axis.sunward)) / self.axis.cot_sun_angular_radius;
                for direction in (0..12).map(|k| DVec2::from_angle(TAU * f64::from(k) / 12.0)) {
                    let offset_across = |distance: f64| self.axis.offset_across(point) + direction * distance;
                    // The distance at which the limb hides the Sun's centre, by bisection.
                    let (mut inside, mut outside) = (0.0, 2.0 * self.radii.max_element());
                    for _ in 0..50 {
                        let middle = 0.5 * (inside + outside);
                        let to_sun = self.axis.sunward * self.axis.sun_distance - point;
                        if self.misses(offset_across(middle), point, to_sun) { outside = middle } else { inside = middle }
                    }
                    let beside_limb = (-16..=16).map(|k| inside + 0.1 * f64::from(k) * apparent_sun_radius);
                    let farther_in = (0..8).map(|k| inside * f64::from(k) / 8.0);
                    for offset_across in beside_limb.chain(farther_in).filter(|d| *d >= 0.0).map(offset_across) {
                        let expected = self.by_rays(offset_across, point);
                        let occluder = self.occluder_at(offset_across);
                        let round = Occluder { semi_axes: DVec2::splat(occluder.semi_axes.x), ..occluder.clone() };
                        for (error, occluder) in errors.iter_mut().zip([occluder, round]) {
                            *error = error.max((self.approximate(occluder, point) - expected).abs());
                        }
                        // 0: hidden, 1: partly hidden, 2: entirely visible.
                        let visibility = if expected == 0.0 { 0 } else { 1 + usize::from(expected == 1.0) };
                        counts[visibility] += 1;
                    }
                }
            }
            (errors, counts)
        }
    }

    /// The bounds are those of the module's comment, with a margin of up to a hundredth for the spacing of the rays.
    #[test]
    fn the_fraction_of_sunlight_has_its_stated_error() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        // NAIF codes of moons and of their planets, which are in front of the Sun.
        let moons_and_planets = [[606, 699], [608, 699], [501, 599], [502, 599], [503, 599], [504, 599], [801, 899], [401, 499]];
        for ids in moons_and_planets {
            let ([error, error_if_round], counts) = EclipseGeometry::of(&catalog, &ephemeris, ids, TRUE_SEMI_AXES).largest_errors();
            println!("{ids:?}: {error:.3}, with the equatorial radius {error_if_round:.3}; {counts:?}");
            assert!(error < 0.085, "{ids:?}: {error}");
            assert!(counts.iter().all(|n| *n > 50), "{ids:?}: {counts:?}");
            // Negative control: with the equatorial radii of Saturn and Jupiter the Sun is entirely hidden where rays reach all of it.
            assert!(error_if_round > 0.99 || ![699, 599].contains(&ids[1]), "{ids:?}: {error_if_round}");
        }
        // Phobos in front of the Sun as seen from Mars; then, in its place, bodies that look about as large as the Sun.
        for (semi_axes, bound) in [
            (TRUE_SEMI_AXES, 0.085),
            (Some(DVec3::splat(0.3)), 0.085),
            (Some(DVec3::ONE), 0.13),
            (Some(DVec3::splat(2.0)), 0.13),
            (Some(DVec3::new(0.75, 0.75, 1.3)), 0.17),
            (Some(DVec3::new(0.9, 0.9, 2.0)), 0.17),
        ] {
            let ([error, error_if_round], counts) = EclipseGeometry::of(&catalog, &ephemeris, [499, 401], semi_axes).largest_errors();
            println!("Phobos, {semi_axes:?}: {error:.3}, with the longest radius {error_if_round:.3}; {counts:?}");
            assert!(error < bound, "{semi_axes:?}: {error}");
        }
    }

    /// Air that neither bends nor dims light: where the Sun is behind it, the light through its layers and the direct light are not both counted. On Io, whose
    /// Sun is hardly larger than Jupiter's air is high, half of the Sun's light would be counted twice.
    #[test]
    fn sunlight_behind_clear_air_is_counted_once() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let geometry = EclipseGeometry::of(&catalog, &ephemeris, [501, 599], TRUE_SEMI_AXES);
        let mut clear = geometry.occluder.clone();
        let air = clear.atmosphere.as_mut().expect("air");
        (air.refractivity, air.limb_haze_km) = (Some(1e-12), None);
        for species in &mut air.species {
            (species.scattering_per_km, species.absorption_per_km) = ([0.0; 3], [0.0; 3]);
        }
        let outline = geometry.occluder_at(DVec2::ZERO);
        let sun_radius = geometry.distance_along / geometry.axis.cot_sun_angular_radius;
        let mut partial = 0;
        for (direction, radius) in [(outline.long_axis, outline.semi_axes.x), (outline.long_axis.perp(), outline.semi_axes.y)] {
            for k in -15..=30 {
                let offset_across = direction * (radius + 0.1 * f64::from(k) * sun_radius);
                let occluders = [Occluder { body: &clear, ..geometry.occluder_at(offset_across) }];
                let [with_air, without] = [EclipseModel::Refracted, EclipseModel::LimbDarkened].map(|model| {
                    let shadow = ApproximateShadow::of(&occluders, model, &geometry.receiver, geometry.sun).expect("an occluder");
                    shadow.sunlight_fraction(DVec3::ZERO)
                });
                assert!((with_air - without).abs() < 0.12, "{k}: {with_air} with clear air, {without} without");
                partial += u32::from(without > 0.05 && without < 0.95);
            }
        }
        assert!(partial > 20, "{partial}");
    }

    /// The light of a whole moon that a planet's shadow leaves: the errors that scene::light::magnitude states, with a margin. They are 0.1 magnitudes if more
    /// than 0.4 of the light is left, and 0.7 magnitudes if less but at least a twentieth is left.
    #[test]
    fn the_magnitude_of_an_eclipsed_moon_has_its_stated_error() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        for ids in [[606, 699], [501, 599], [504, 599], [401, 499]] {
            let geometry = EclipseGeometry::of(&catalog, &ephemeris, ids, TRUE_SEMI_AXES);
            let outline = geometry.occluder_at(DVec2::ZERO);
            let receiver_and_penumbra = geometry.receiver_and_penumbra();
            let mut partial = 0;
            for (direction, radius) in [(outline.long_axis, outline.semi_axes.x), (outline.long_axis.perp(), outline.semi_axes.y)] {
                for k in -9..=9 {
                    let offset_across = direction * (radius + receiver_and_penumbra * f64::from(k) / 9.0);
                    let expected = geometry.mean_by_rays(offset_across);
                    let occluders = [geometry.occluder_at(offset_across)];
                    let shadow = ApproximateShadow::of(&occluders, EclipseModel::LimbDarkened, &geometry.receiver, geometry.sun);
                    let error = -2.5 * (shadow.expect("an occluder").mean_sunlight(geometry.axis.sunward).y / expected).log10();
                    println!("{ids:?}: {expected:.4} of the light, off by {error:.3} magnitudes");
                    let bound = if expected > 0.4 { 0.1 } else { 0.75 };
                    assert!(expected < 0.05 || error.abs() < bound, "{ids:?}: {expected} of the light, off by {error} magnitudes");
                    partial += u32::from(expected > 0.05 && expected < 0.95);
                }
            }
            assert!(partial > 10, "{ids:?}: {partial} partial eclipses");
        }
    }

    /// The direction to a camera that sees the receiver at a phase angle. `azimuth_rad`: angle of the camera around the line to the Sun.
    fn camera(axis: &Axis, phase_deg: f64, azimuth_rad: f64) -> DVec3 {
        let (sin, cos) = phase_deg.to_radians().sin_cos();
        let across = DVec2::from_angle(azimuth_rad);
        axis.sunward * cos + (axis.perpendicular_axes[0] * across.x + axis.perpendicular_axes[1] * across.y) * sin
    }

    #[test]
    fn the_mean_is_0_in_an_umbra_and_1_outside_a_penumbra_at_every_phase() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        for ids in [[501, 599], [606, 699]] {
            let geometry = EclipseGeometry::of(&catalog, &ephemeris, ids, TRUE_SEMI_AXES);
            let outline = geometry.occluder_at(DVec2::ZERO);
            let receiver_and_penumbra = geometry.receiver_and_penumbra();
            let outside = outline.long_axis * (outline.semi_axes.x + 2.0 * receiver_and_penumbra);
            for (offset_across, expected) in [(DVec2::ZERO, 0.0), (outside, 1.0)] {
                let occluders = [geometry.occluder_at(offset_across)];
                let shadow =
                    ApproximateShadow::of(&occluders, EclipseModel::LimbDarkened, &geometry.receiver, geometry.sun).expect("an occluder");
                for phase_deg in (0..=180).map(f64::from).chain([1e-9, 1e-5, 179.9, 180.0 - 1e-5, 180.0 - 1e-9]) {
                    for azimuth in (0..4).map(|k| TAU * f64::from(k) / 4.0) {
                        let mean = shadow.mean_sunlight(camera(&geometry.axis, phase_deg, azimuth));
                        assert!(mean == DVec3::splat(expected), "{ids:?}: {mean} in place of {expected} at {phase_deg} degrees");
                    }
                }
            }
        }
    }

    /// The error of the mean for a moon behind its planet, a planet behind its moon, and two bodies of which one casts a sharp shadow on the other. The
    /// occluder's offsets are not multiples of the spacing of any lattice of points.
    #[test]
    fn the_points_of_the_mean_are_enough() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let (mut error_of_sphere_lattice, mut partial) = (0.0_f64, 0);
        for (ids, bound) in [([501, 599], 0.005), ([606, 699], 0.005), ([599, 501], 0.005), ([999, 901], 0.02)] {
            let geometry = EclipseGeometry::of(&catalog, &ephemeris, ids, TRUE_SEMI_AXES);
            let outline = geometry.occluder_at(DVec2::ZERO);
            let receiver_and_penumbra = geometry.receiver_and_penumbra();
            let mut largest_error = 0.0_f64;
            for phase_deg in [0.0, 1.0, 60.0, 120.0, 165.0] {
                for (azimuth, k) in (0..3).flat_map(|k| (-20..=20).map(move |j| (TAU * f64::from(k) / 3.0, j))) {
                    let distance = outline.semi_axes.x.max(1.0) + receiver_and_penumbra * (f64::from(k) * 0.0471 - 0.05);
                    let occluders = [geometry.occluder_at(outline.long_axis * distance)];
                    let shadow = ApproximateShadow::of(&occluders, EclipseModel::LimbDarkened, &geometry.receiver, geometry.sun)
                        .expect("an occluder");
                    let camera = camera(&geometry.axis, phase_deg, azimuth);
                    // The mean over those points of a lattice on the entire sphere that lie in the lune. Without refraction all channels are equal, so that
                    // luminance and green are the same.
                    let over_sphere = |points: u32| {
                        let (mut sunlight, mut weights) = (0.0, 0.0);
                        for k in 0..points {
                            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(points);
                            let point = (DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * (1.0 - z * z).sqrt()).extend(z);
                            let weight = point.dot(geometry.axis.sunward).max(0.0) * point.dot(camera).max(0.0);
                            if weight > 0.0 {
                                sunlight += shadow.sunlight_fraction(point) * weight;
                                weights += weight;
                            }
                        }
                        sunlight / weights
                    };
                    let (expected, mean) = (over_sphere(40_000), shadow.mean_sunlight(camera).y);
                    largest_error = largest_error.max((mean - expected).abs());
                    error_of_sphere_lattice = error_of_sphere_lattice.max((over_sphere(2 * MEAN_POINTS) - expected).abs());
                    partial += u32::from(expected > 0.05 && expected < 0.95);
                }
            }
            println!("{} behind {}: {largest_error:.4}", ids[0], ids[1]);
            assert!(largest_error < bound, "{largest_error} for {ids:?}");
        }
        assert!(partial > 40, "{partial} partial eclipses");
        // Negative control: with twice as many points, but on the entire sphere, the mean of a thin crescent is wrong by more than 0.01.
        assert!(error_of_sphere_lattice > 0.01, "{error_of_sphere_lattice}");
    }
}
