//! The fraction of sunlight that passes the occluders at single points, by the model that the shader draws.
//!
//! In: the uniforms of an eclipse and its model. Out: the fraction per channel, and its range within a ball. Error against shaders/lib/eclipse: 2e-3 of full
//! sunlight, and where air refracts light some hundredths of that light. Not here: the model with linear penumbrae, and the faster `approximate_shadow`, which
//! ignores limb darkening.

use crate::scene::draw::features::EclipseModel;
use crate::scene::draw::uniforms::EclipseUniforms;
use crate::scene::eclipse::refraction::RefractingLayers;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Number of parallel chords into which the Sun's disc is divided.
const CHORDS: u32 = 128;

/// An occluder's outline in front of the Sun, in solar radii from the middle of the Sun's disc.
struct Outline {
    centre: DVec2,
    /// Unit vector along the long axis.
    axis: DVec2,
    semi_axes: DVec2,
    /// Distance of the point behind the occluder, and solar radii per length at that distance; lengths in the receiver's equatorial radii.
    depth: f64,
    scale: f64,
}

impl Outline {
    fn may_hide_sun(&self) -> bool {
        self.centre.length() < 1.0 + self.semi_axes.x
    }

    /// Distance from the centre to the outline in the direction of the Sun's centre.
    fn radius_towards_sun(&self) -> f64 {
        let along_axes = DVec2::new(self.centre.dot(self.axis), self.centre.dot(self.axis.perp()));
        let length = along_axes.length();
        if length > 0.0 { length / (along_axes / self.semi_axes).length() } else { self.semi_axes.x }
    }

    /// The ends of the outline's chord at the height y; `None` if it has none.
    fn chord(&self, y: f64) -> Option<[f64; 2]> {
        // With (x, h) from the centre, the components along the axes are u = x axis.x + h axis.y and v = h axis.x - x axis.y. On the outline
        // (u / semi_axes.x)² + (v / semi_axes.y)² = 1, which is a x² + 2 b x + c = 0.
        let h = y - self.centre.y;
        let per_axis = 1.0 / (self.semi_axes * self.semi_axes);
        let axis_sq = self.axis * self.axis;
        let a = axis_sq.dot(per_axis);
        let b = h * self.axis.x * self.axis.y * (per_axis.x - per_axis.y);
        let c = h * h * (axis_sq.y * per_axis.x + axis_sq.x * per_axis.y) - 1.0;
        let discriminant = b * b - a * c;
        (discriminant > 0.0).then(|| [-1.0, 1.0].map(|sign| self.centre.x + (sign * discriminant.sqrt() - b) / a))
    }
}

/// The sunlight past the occluders of an eclipse.
pub(crate) struct SunlightPast<'u> {
    uniforms: &'u EclipseUniforms,
    /// The air of the first occluder; `None` if the model leaves it out.
    layers: Option<RefractingLayers>,
    /// Coefficients of 1, mu and mu² of the radiance of the Sun's disc, per channel.
    limb_darkening: [DVec3; 3],
}

impl<'u> SunlightPast<'u> {
    /// `None` without occluders, and for the model with linear penumbrae.
    pub(crate) fn of(uniforms: &'u EclipseUniforms, model: EclipseModel) -> Option<Self> {
        if uniforms.occluder_positions.is_empty() || matches!(model, EclipseModel::None | EclipseModel::Linear) {
            return None;
        }
        let layers = (model == EclipseModel::Refracted && !uniforms.air_edges.is_empty()).then(|| RefractingLayers {
            // Only the outline needs the top, and it already includes it.
            top: 0.0,
            edges: uniforms.air_edges.iter().map(|e| e.as_dvec4()).collect(),
            transmittances: uniforms.air_transmittance.iter().map(|t| t.truncate().as_dvec3()).collect(),
        });
        Some(Self { uniforms, layers, limb_darkening: uniforms.limb_darkening.map(|c| c.truncate().as_dvec3()) })
    }

    /// Components of a vector along the two axes perpendicular to the line to the Sun.
    fn across(&self, v: DVec3) -> DVec2 {
        let [x, y] = self.uniforms.perpendicular_axes.map(|axis| axis.truncate().as_dvec3());
        DVec2::new(v.dot(x), v.dot(y))
    }

    /// The outlines of the occluders that are between a point and the Sun, with their indices, as `occluder_before_sun` of the shader computes them.
    fn outlines(&self, point: DVec3) -> impl Iterator<Item = (usize, Outline)> {
        let [cot_sun_radius, cot_per_distance] = self.uniforms.perpendicular_axes.map(|axis| f64::from(axis.w));
        let sunward = self.uniforms.axis.as_dvec4();
        let (across, along) = (self.across(point), point.dot(sunward.truncate()));
        let occluders = self.uniforms.occluder_positions.iter().zip(&self.uniforms.occluder_outlines).enumerate();
        occluders.filter_map(move |(index, (position, shape))| {
            let (position, shape) = (position.as_dvec4(), shape.as_dvec4());
            let depth = position.z - along;
            let scale = cot_sun_radius * (1.0 - along * sunward.w) / depth;
            let centre = (DVec2::new(position.x, position.y) - across) * scale + across * cot_per_distance;
            let semi_axes = DVec2::new(shape.z, shape.w) * scale;
            (depth > 0.0).then(|| (index, Outline { centre, axis: DVec2::new(shape.x, shape.y), semi_axes, depth, scale }))
        })
    }

    /// Integral of the Sun's radiance along a chord of half length h, from its middle to x.
    fn light_along_chord(&self, x: f64, h: f64) -> DVec3 {
        let mu = (h * h - x * x).max(0.0).sqrt();
        let of_mu = 0.5 * (x * mu + h * h * x.atan2(mu));
        let of_mu_sq = x * (h * h - x * x / 3.0);
        self.limb_darkening[0] * x + self.limb_darkening[1] * of_mu + self.limb_darkening[2] * of_mu_sq
    }

    /// The fraction of sunlight at a point, per channel. `point`: body axes, in the receiver's equatorial radii.
    pub(crate) fn fraction(&self, point: DVec3) -> DVec3 {
        let all: Vec<(usize, Outline)> = self.outlines(point).collect();
        let hiding: Vec<&Outline> = all.iter().map(|(_, outline)| outline).filter(|o| o.may_hide_sun()).collect();
        let mut light = if hiding.is_empty() { DVec3::ONE } else { self.direct_fraction(&hiding) };
        if let (Some(layers), Some((_, first))) = (&self.layers, all.iter().find(|(index, _)| *index == 0)) {
            // The layers are those of a round limb. It is moved along the line to the Sun's centre until its top is where the outline is.
            let top = layers.edges.last().map_or(0.0, |edge| edge.z) * first.scale;
            let separation = (first.centre.length() + top - first.radius_towards_sun()).max(0.0);
            light += layers.refracted_fraction(separation, first.depth, first.scale);
        }
        light
    }

    /// The fraction of the light of the Sun's disc that is outside all outlines.
    fn direct_fraction(&self, outlines: &[&Outline]) -> DVec3 {
        let (mut total, mut visible) = (DVec3::ZERO, DVec3::ZERO);
        let mut hidden: Vec<[f64; 2]> = Vec::with_capacity(outlines.len() + 1);
        for k in 0..CHORDS {
            // The ends of the chords are evenly spaced along the limb, so the distance between chords is proportional to h.
            let (y, h) = (PI * ((f64::from(k) + 0.5) / f64::from(CHORDS) - 0.5)).sin_cos();
            hidden.extend(outlines.iter().filter_map(|o| o.chord(y)).map(|ends| ends.map(|x| x.clamp(-h, h))));
            hidden.sort_by(|a, b| a[0].total_cmp(&b[0]));
            hidden.push([h, h]);
            let mut covered_to = -h;
            for [from, to] in hidden.drain(..) {
                if from > covered_to {
                    visible += h * (self.light_along_chord(from, h) - self.light_along_chord(covered_to, h));
                }
                covered_to = covered_to.max(to);
            }
            total += h * (self.light_along_chord(h, h) - self.light_along_chord(-h, h));
        }
        visible / total
    }

    /// The smallest and the largest fraction of sunlight within a ball, per channel. For each occluder, the light grows with the distance from its shadow's
    /// axis: exact for round occluders of which one at a time is in front of the Sun, and if the light that their air refracts is small.
    pub(crate) fn range_within(&self, centre: DVec3, radius: f64) -> [DVec3; 2] {
        let [x, y] = self.uniforms.perpendicular_axes.map(|axis| axis.truncate().as_dvec3());
        let at_centre = self.fraction(centre);
        let (mut least, mut most) = (at_centre, at_centre);
        for (_, outline) in self.outlines(centre) {
            // By a step across the axis, the outline moves in front of the Sun by this many solar radii per length, the other way.
            let rate = outline.scale - f64::from(self.uniforms.perpendicular_axes[1].w);
            let to_axis = outline.centre / rate.max(f64::MIN_POSITIVE);
            let towards_axis = to_axis.try_normalize().unwrap_or(DVec2::X);
            for step in [radius.min(to_axis.length()), -radius] {
                let offset = towards_axis * step;
                let light = self.fraction(centre + x * offset.x + y * offset.y);
                (least, most) = (least.min(light), most.max(light));
            }
        }
        [least, most]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    /// A round occluder whose radius is `radius` solar radii, seen from the receiver's centre; solar radii are 1/100 equatorial radius at its distance. The
    /// Sun has the limb darkening 1 - 0.6 (1 - mu), normalised.
    fn uniforms(radius: f32) -> EclipseUniforms {
        let flux = std::f32::consts::PI * (1.0 - 0.6 / 3.0);
        EclipseUniforms {
            axis: Vec4::new(0.0, 0.0, 1.0, 1e-5),
            perpendicular_axes: [Vec4::new(1.0, 0.0, 0.0, 2000.0), Vec4::new(0.0, 1.0, 0.0, 2000.0 * 1e-5)],
            limb_darkening: [Vec4::splat(0.4 / flux), Vec4::splat(0.6 / flux), Vec4::ZERO],
            occluder_positions: vec![Vec4::new(0.0, 0.0, 20.0, 0.0)],
            occluder_outlines: vec![Vec4::new(1.0, 0.0, radius * 0.01, radius * 0.01)],
            ..EclipseUniforms::default()
        }
    }

    /// In the middle of a small disc's shadow, the hidden light is that of a circle about the Sun's middle, which has a closed form; without overlap all light
    /// is left, and behind a large disc none.
    #[test]
    fn the_fraction_is_that_of_closed_forms() {
        let k = 0.5_f64;
        // The integral of 1 - 0.6 (1 - mu) over the circle of radius k, divided by that over the disc.
        let hidden = (0.4 * k * k / 2.0 + 0.6 * (1.0 - (1.0 - k * k).powf(1.5)) / 3.0) / (0.4 / 2.0 + 0.6 / 3.0);
        let uniforms_of_half = uniforms(0.5);
        let half = SunlightPast::of(&uniforms_of_half, EclipseModel::LimbDarkened).expect("an occluder");
        assert!((half.fraction(DVec3::ZERO).y - (1.0 - hidden)).abs() < 1e-3, "{}, not {}", half.fraction(DVec3::ZERO).y, 1.0 - hidden);
        assert_eq!(half.fraction(DVec3::X * 0.02), DVec3::ONE);
        let uniforms_of_large = uniforms(3.0);
        let large = SunlightPast::of(&uniforms_of_large, EclipseModel::LimbDarkened).expect("an occluder");
        assert_eq!(large.fraction(DVec3::X * 0.019), DVec3::ZERO);
        // Half of the Sun behind a straight edge: the limb of a disc of 1000 solar radii.
        let uniforms_of_edge = uniforms(1000.0);
        let edge = SunlightPast::of(&uniforms_of_edge, EclipseModel::LimbDarkened).expect("an occluder");
        // There, a length of the receiver is 100 solar radii, less the 0.02 by which the Sun moves.
        let half_hidden = edge.fraction(DVec3::Y * (1000.0 / 99.98)).y;
        assert!((half_hidden - 0.5).abs() < 2e-3, "{half_hidden}");
        assert!(SunlightPast::of(&uniforms_of_edge, EclipseModel::Linear).is_none());
    }

    /// Air that neither bends nor dims light leaves the light that passes the solid body, whose outline is an ellipse like that of a giant planet seen from its
    /// moons. With layers around the centre, at the mean radius of the ellipse, up to a third of the Sun's light would be added or missing.
    #[test]
    fn clear_air_that_bends_nothing_changes_no_light_past_an_ellipse() {
        const LAYERS: u32 = 32;
        let (semi_axes, air) = (DVec2::new(1.0, 0.93), 0.005);
        let mean_radius = (semi_axes.x * semi_axes.y).sqrt();
        let with_outline = |semi_axes: DVec2| EclipseUniforms {
            occluder_outlines: vec![Vec4::new(1.0, 0.0, semi_axes.x as f32, semi_axes.y as f32)],
            ..uniforms(1.0)
        };
        let edge = |k: u32| (mean_radius + air * f64::from(k) / f64::from(LAYERS)) as f32;
        let of_air = EclipseUniforms {
            air_edges: (0..LAYERS).map(|k| Vec4::new(edge(k), 0.0, edge(k + 1), 0.0)).collect(),
            air_transmittance: vec![Vec4::ONE; LAYERS as usize],
            ..with_outline(semi_axes + DVec2::splat(air))
        };
        let of_solid = with_outline(semi_axes);
        let with_air = SunlightPast::of(&of_air, EclipseModel::Refracted).expect("an occluder");
        let without_air = SunlightPast::of(&of_solid, EclipseModel::LimbDarkened).expect("an occluder");
        let mut partial = 0;
        for (angle, offset) in (0..=8).flat_map(|k| (-12..=12).map(move |j| (PI * f64::from(k) / 16.0, f64::from(j)))) {
            let direction = DVec2::from_angle(angle);
            let outline = 1.0 / (direction / semi_axes).length();
            // A solar radius at the occluder's distance is 0.01.
            let point = (direction * (outline + 0.001 * offset)).extend(0.0);
            let (light, expected) = (with_air.fraction(point).y, without_air.fraction(point).y);
            // The layers' share is that of a Sun without limb darkening.
            assert!((light - expected).abs() < 0.06, "{light}, not {expected} at {angle} rad, {offset}");
            partial += u32::from(expected > 0.05 && expected < 0.95);
        }
        assert!(partial > 50, "{partial}");
    }

    /// Every point of a ball has a fraction within the range, which is that of the ball and not wider.
    #[test]
    fn the_range_contains_all_points_of_the_ball() {
        let uniforms = uniforms(2.0);
        let past = SunlightPast::of(&uniforms, EclipseModel::LimbDarkened).expect("an occluder");
        for (distance, radius) in [(0.02, 0.005), (0.012, 0.012), (0.005, 0.02), (0.04, 0.005)] {
            let centre = DVec3::new(0.6, 0.8, 0.0) * distance;
            let [least, most] = past.range_within(centre, radius);
            let (mut seen_least, mut seen_most) = (1.0_f64, 0.0_f64);
            for (ring, k) in (0..=10).flat_map(|ring| (0..48).map(move |k| (ring, k))) {
                let offset = DVec2::from_angle(2.0 * PI * f64::from(k) / 48.0) * (radius * f64::from(ring) / 10.0);
                let light = past.fraction(centre + offset.extend(0.0)).y;
                (seen_least, seen_most) = (seen_least.min(light), seen_most.max(light));
            }
            assert!(least.y <= seen_least + 1e-3 && most.y >= seen_most - 1e-3, "{distance} {radius}: {least} {most}");
            assert!(seen_least - least.y < 0.02 && most.y - seen_most < 0.02, "{distance} {radius}: {seen_least} {seen_most}");
        }
    }
}
