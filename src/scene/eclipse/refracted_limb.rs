//! The refracted limb: the Sun's refracted image in the atmosphere of a body in front of the Sun, at the body's limb.
//!
//! In: the placed bodies. Out: the decision for each body with a refracting atmosphere, and a [`RefractedLimb`] for each that is drawn. The camera must be
//! outside the atmosphere. The air is divided into the layers of eclipse/refraction.rs, which the eclipse model `refracted` also uses. Therefore that model
//! gives a point in the shadow the light of the refracted limb that a camera at this point sees. Below the top of the atmosphere only the refracted limb shows
//! the Sun: the part of the Sun's disc that was drawn there along straight rays is removed first, so that no light is drawn twice. Lengths are in the body's
//! equatorial radii; the shader takes heights for those of the unit-sphere frame, as that of all air does. So the layers of a flattened body are lower at its
//! poles by the flattening: 10 % on Saturn, where layers that follow gravity would be a quarter lower. On small discs the light fades, because a body drawn as
//! a point shows no refracted limb. shaders/entry/refracted_limb.wesl sums the layers' light over a pixel. Not modelled: other bodies that hide the Sun from
//! the limb, the Sun's albedo map, and that air bends light more at the poles (on Saturn by a fifth), where it is thinner and the limb less curved along the
//! ray. A *reduced* bending angle is the shift of the Sun's image that a bending angle causes (`refraction::shift_per_bending`).

use crate::catalog::{Body, NaifId};
use crate::message::{Reason, reason};
use crate::scene::atmosphere;
use crate::scene::body_report::{Appearance, BodyReport};
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{AnchorForm, Camera, NEAR_DEPTH_KM, Placement, ViewRays, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::eclipse::refraction::{self, RefractingLayers};
use crate::scene::light::photometry;
use crate::scene::placed::PlacedBody;
use crate::scene::point::{DISC_ONLY_FROM_PX, beyond_small_disc};
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use glam::{DVec3, DVec4, Vec3, Vec4};

/// Uniforms of shaders/entry/refracted_limb.wesl, and the rectangles in which the limb is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct RefractedLimb {
    pub body: NaifId,
    /// View rays over the atmosphere.
    pub rays: ViewRays,
    /// View rays over the part of the Sun's disc that was drawn unrefracted behind the atmosphere; `None` if no such part is in the image.
    pub unrefracted_sun: Option<ViewRays>,
    /// Fraction of the Sun's refracted image that is drawn, and of its unrefracted image that is removed: less than 1 on small discs.
    pub drawn_fraction: f32,
    /// The body's semi-axes divided by its equatorial radius.
    pub axis_ratios: Vec3,
    /// Reversed depth just in front of the body's near side.
    pub depth: f32,
    /// x, y, z: unit vector to the Sun in body axes; w: cotangent of the Sun's angular radius.
    pub sun_direction: Vec4,
    /// Two unit vectors perpendicular to the Sun's direction, body axes; w: 0.
    pub sun_basis: [Vec4; 2],
    /// Radiance of the Sun's disc, as far as it is drawn (`drawn_fraction`) and tinted by the air around the camera: coefficients of 1, mu, mu².
    pub sun_limb_darkening: [Vec4; 3],
    /// For each edge of a layer, from the ground up. x: height over the limb; y: shift of the Sun's image away from the body's centre, in solar radii.
    pub air_edges: Vec<Vec4>,
    /// For each layer two values: the mean transmittance, then its change from the lower edge to the upper.
    pub air_transmittance: Vec<Vec4>,
}

/// Change of the transmittance across each layer, for linear interpolation within the layer. `transmittances`: the layers' means, from the ground up. The slope
/// is limited (monotonized central differences), so that the interpolation stays between the means of the neighbouring layers.
fn slopes(transmittances: &[DVec3]) -> Vec<DVec3> {
    let at = |k: usize| transmittances[k.min(transmittances.len() - 1)];
    let slope = |k: usize| {
        // Change from this layer to the one above, and from the one below to this layer.
        let (to_above, from_below) = (at(k + 1) - at(k), at(k) - at(k.saturating_sub(1)));
        let steepest = (2.0 * to_above.abs()).min(2.0 * from_below.abs()).min(0.5 * (to_above + from_below).abs());
        let rises = to_above.cmpgt(DVec3::ZERO) & from_below.cmpgt(DVec3::ZERO);
        let falls = to_above.cmplt(DVec3::ZERO) & from_below.cmplt(DVec3::ZERO);
        DVec3::select(rises, steepest, DVec3::select(falls, -steepest, DVec3::ZERO))
    };
    (0..transmittances.len()).map(slope).collect()
}

/// Radiance of the Sun's disc as coefficients of 1, mu, mu², per channel.
fn sun_radiance(sun: &Body) -> [DVec3; 3] {
    let (u1, u2) = limb_darkening(sun);
    let centre = sun.colour.as_dvec3() * photometry::albedo_normalisation(sun) * photometry::sun_disc_radiance();
    [1.0 - u1 - u2, u1 + 2.0 * u2, -u2].map(|factor| factor * centre)
}

/// The Sun and a body in front of the Sun, as seen from the camera.
struct LimbGeometry {
    /// Angular radius of the Sun.
    sun_radius_rad: f64,
    /// Angle between the centres of the Sun and the body.
    separation_rad: f64,
    /// Angular radius of the body.
    limb_radius_rad: f64,
    /// Largest error of `limb_radius_rad`, which is that of a sphere, for an ellipsoid.
    limb_radius_error_rad: f64,
    /// Distance from the camera to the body's centre, radii of the body.
    camera_distance: f64,
    /// Distance from the camera to the limb, radii of the body.
    limb_distance: f64,
}

impl LimbGeometry {
    fn of(placed: &PlacedBody<'_>, sun: &PlacedBody<'_>) -> Self {
        let camera_distance = placed.placement.camera_in_unit_sphere().length();
        let limb_radius_rad = (1.0 / camera_distance).min(1.0).asin();
        Self {
            sun_radius_rad: (sun.body.radii_km.x / sun.distance_km).min(1.0).asin(),
            separation_rad: crate::ephemeris::angle_rad(placed.placement.centre_km, sun.placement.centre_km),
            limb_radius_rad,
            limb_radius_error_rad: limb_radius_rad * crate::scene::features::choice::ellipsoid_flattening(placed.body),
            camera_distance,
            limb_distance: (camera_distance * camera_distance - 1.0).max(1e-12).sqrt(),
        }
    }

    /// Angle between the body's centre and a straight ray with this impact parameter, radii of the body; a right angle if the camera is nearer to the centre.
    fn angle_of_straight_ray(&self, impact_parameter: f64) -> f64 {
        (impact_parameter / self.camera_distance).min(1.0).asin()
    }

    /// Whether any layer can show the Sun: whether the angles that the layers show, of which negative ones lie beyond the body's centre, can reach the Sun's
    /// disc. This test does not need the layers, which take milliseconds to compute. `max_reduced_bending`: see [`refraction::max_reduced_bending`].
    fn may_show_sun(&self, placed: &PlacedBody<'_>, max_reduced_bending: f64) -> bool {
        let top_km = placed.body.atmosphere.as_ref().map_or(0.0, |air| air.top_km);
        // The largest and the smallest angle that `unrefracted_angles` can return.
        let max_angle = self.angle_of_straight_ray(1.0 + top_km / placed.body.radii_km.x);
        let min_angle = self.limb_radius_rad - max_reduced_bending;
        let margin = self.sun_radius_rad + self.limb_radius_error_rad;
        self.separation_rad - margin <= max_angle.max(-min_angle) && self.separation_rad + margin >= min_angle
    }

    /// Where on the sky the light at the lower and the upper edge of a layer comes from: the angle in radians between the body's centre and that source, as it
    /// would be seen without refraction. Negative if the source is on the other side of the centre. `layer`: one of [`RefractingLayers::edges`], apparent
    /// radius and reduced bending angle at the lower edge (x, y), then at the upper (z, w).
    fn unrefracted_angles(&self, layer: &DVec4) -> (f64, f64) {
        let at = |radius: f64, reduced_bending: f64| self.angle_of_straight_ray(radius) - reduced_bending;
        (at(layer.x, layer.y), at(layer.z, layer.w))
    }

    /// Upper limit, per channel, of the radiance that the layers give to a pixel. Each layer that shows any part of the Sun counts with the radiance of the
    /// centre of the Sun's disc. `pixel_width_radii`: width of a pixel at the limb in radii of the body.
    fn max_radiance(&self, layers: &RefractingLayers, centre_radiance: DVec3, pixel_width_radii: f64) -> DVec3 {
        let shows = |layer: &DVec4| {
            let (low, high) = self.unrefracted_angles(layer);
            let nearest = if low * high <= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
            let margin = self.sun_radius_rad + self.limb_radius_error_rad;
            nearest <= self.separation_rad + margin && low.abs().max(high.abs()) >= self.separation_rad - margin
        };
        let showing = layers.edges.iter().zip(&layers.transmittances).filter(|(layer, _)| shows(layer));
        let (sum, greatest) = showing.fold((DVec3::ZERO, DVec3::ZERO), |(sum, greatest), (layer, transmittances)| {
            (sum + *transmittances * ((layer.z - layer.x) / pixel_width_radii), greatest.max(*transmittances))
        });
        // The mean transmittance over a pixel is at most the greatest of a layer.
        centre_radiance * sum.min(greatest)
    }
}

/// A short arc of a refracted limb, for the light meter.
pub(crate) struct LimbSegment {
    /// Unit vector from the camera to the middle of the arc, ICRF.
    pub direction: DVec3,
    /// Solid angle, sr: of the layers that show the Sun, or of a strip of the limb one pixel wide, whichever is larger.
    pub solid_angle: f64,
    /// Mean radiance over that solid angle, brightest channel, as far as it is drawn.
    pub radiance: f64,
    /// Fraction of this light whose rays would miss the Sun without refraction.
    pub bent_fraction: f64,
}

/// A refracted limb, for the light meter.
pub(crate) struct LimbLight {
    pub segments: Vec<LimbSegment>,
    /// Solid angle, sr, of a disc whose diameter is the chord of the arc that shows the Sun. In a sunset seen from orbit this is about the Sun's disc; if the
    /// entire limb shows the Sun, it is the body's disc.
    pub arc_disc_sr: f64,
    /// Mean transmittance of the layers that show the Sun, over the channels.
    pub transmittance: f64,
    /// Fraction of the light that is drawn: less than 1 for a small disc.
    pub drawn_fraction: f64,
}

/// Radius of the body's outline in the module's unit of length, the body's equatorial radius.
const OUTLINE_RADIUS: f64 = 1.0;
/// Number of segments on the side of the limb nearest to the Sun, and as many on the opposite side.
const SEGMENTS: u32 = 24;

/// The refracted limb as segments, for the light meter: the arcs where the layers of a body's atmosphere show the Sun, treated as a uniform disc. The limb
/// is that of a sphere: for an oblate body the arcs are slightly displaced. `pixel_rad`: angle that a pixel spans. `None` if the refractivity is unknown, the
/// camera is inside the atmosphere, the Sun is nearer than the body, the disc is too small to draw, or no layer shows the Sun.
pub(crate) fn limb_light(placed: &PlacedBody<'_>, sun: &PlacedBody<'_>, pixel_rad: f64) -> Option<LimbLight> {
    if placed.distance_km <= 0.0 || sun.distance_km <= placed.distance_km || camera_is_inside(placed) {
        return None;
    }
    let (geometry, shift_per_bending) = (LimbGeometry::of(placed, sun), refraction::shift_per_bending(placed.distance_km, sun.distance_km));
    let drawn_fraction = beyond_small_disc(2.0 * geometry.limb_radius_rad / pixel_rad);
    let is_possible = drawn_fraction > 0.0
        && refraction::max_reduced_bending(placed.body, shift_per_bending).is_some_and(|b| geometry.may_show_sun(placed, b));
    let layers_of_air = || refraction::layers(placed.body, placed.body.radii_km.x, OUTLINE_RADIUS, shift_per_bending);
    let layers = is_possible.then(layers_of_air).flatten()?;
    let to_body = placed.placement.centre_km / placed.distance_km;
    let to_sun = sun.placement.centre_km / sun.distance_km;
    let x = (to_sun - to_body * to_body.dot(to_sun)).try_normalize().unwrap_or_else(|| to_body.any_orthonormal_vector());
    let y = to_body.cross(x);
    // Half the range of position angles, from the direction of the Sun, in which a line through the body's centre crosses the Sun's disc.
    let half_arc = (geometry.sun_radius_rad / geometry.separation_rad.max(1e-300)).min(1.0).asin();
    // The middles of the segments: on the Sun's side of the limb, then on the opposite side.
    let position_angles = (0..2 * SEGMENTS).map(|k| {
        let side = if k < SEGMENTS { 0.0 } else { std::f64::consts::PI };
        side + half_arc * (2.0 * (f64::from(k % SEGMENTS) + 0.5) / f64::from(SEGMENTS) - 1.0)
    });
    let step_rad = 2.0 * half_arc / f64::from(SEGMENTS);
    let pixel_width_radii = pixel_rad * geometry.limb_distance;
    let (sin_limb, cos_limb) = geometry.limb_radius_rad.sin_cos();
    // Thickness of the layers that show the Sun, and the product of this thickness and their mean transmittance; both summed over all segments.
    let (mut all_shown, mut all_light) = (0.0, 0.0);
    let mut segments = Vec::new();
    for angle in position_angles {
        let (sin, cos) = angle.sin_cos();
        // Angles from the body's centre at which the line at this position angle enters and leaves the Sun's disc; negative on the opposite side.
        let half_chord = (geometry.sun_radius_rad.powi(2) - (geometry.separation_rad * sin).powi(2)).max(0.0).sqrt();
        let (from, to) = (geometry.separation_rad * cos - half_chord, geometry.separation_rad * cos + half_chord);
        // The fraction of a range of angles that is on the Sun's disc.
        let fraction_on_sun = |low: f64, high: f64| (high.min(to) - low.max(from)).max(0.0) / (high - low).max(1e-300);
        // Thickness of the layers that show the Sun, in radii; the integral of their transmittance over it, and the part of this integral whose rays would miss
        // the Sun without refraction.
        let (mut shown_thickness, mut light, mut bent_light) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (layer, transmittances) in layers.edges.iter().zip(&layers.transmittances) {
            let (low, high) = geometry.unrefracted_angles(layer);
            let shown = fraction_on_sun(low, high) * (layer.z - layer.x);
            let straight_fraction = fraction_on_sun(geometry.angle_of_straight_ray(layer.x), geometry.angle_of_straight_ray(layer.z));
            shown_thickness += shown;
            light += shown * transmittances.max_element();
            bent_light += shown * transmittances.max_element() * (1.0 - straight_fraction);
            all_light += shown * transmittances.element_sum() / 3.0;
        }
        all_shown += shown_thickness;
        if light > 0.0 {
            let width = shown_thickness.max(pixel_width_radii);
            segments.push(LimbSegment {
                direction: to_body * cos_limb + (x * cos + y * sin) * sin_limb,
                // Length of the segment times its width, as angles.
                solid_angle: step_rad * sin_limb * width / geometry.limb_distance,
                radiance: photometry::sun_disc_radiance() * drawn_fraction * light / width,
                bent_fraction: bent_light / light,
            });
        }
    }
    let arc_disc_sr = std::f64::consts::PI * (sin_limb * half_arc.sin()).powi(2);
    (!segments.is_empty()).then(|| LimbLight { segments, arc_disc_sr, transmittance: all_light / all_shown, drawn_fraction })
}

/// The uniforms of one limb; `None` if the atmosphere is outside the image. `tint`: see [`refracted_limbs`]. `drawn_fraction`: see [`RefractedLimb`].
fn refracted_limb(
    camera: &Camera,
    placed: &PlacedBody<'_>,
    sun: &PlacedBody<'_>,
    layers: &RefractingLayers,
    tint: DVec3,
    drawn_fraction: f64,
) -> Option<RefractedLimb> {
    let placement = &placed.placement;
    let top = layers.edges.last()?.z;
    let shell = Placement { radii_km: placement.radii_km * top, ..*placement };
    let rect = Outline::of(camera, &shell).rect(camera)?;
    let rays_over = |rect| camera.view_rays(placement, rect, AnchorForm::Auto);
    let sun_direction = (placement.body_from_icrf * sun.placement.centre_km).normalize();
    let (x, y) = sun_direction.any_orthonormal_pair();
    let sun_radius_km = sun.body.radii_km.x;
    let cot_sun_angular_radius = ((sun.distance_km - sun_radius_km) * (sun.distance_km + sun_radius_km)).sqrt() / sun_radius_km;
    let edge = |radius: f64, reduced_bending: f64| {
        Vec4::new(narrow_scalar(radius - 1.0), narrow_scalar(reduced_bending * cot_sun_angular_radius), 0.0, 0.0)
    };
    let first = layers.edges.first()?;
    let air_edges = std::iter::once(edge(first.x, first.y)).chain(layers.edges.iter().map(|e| edge(e.z, e.w))).collect();
    let transmittances = layers.transmittances.iter().zip(slopes(&layers.transmittances)).flat_map(|(mean, slope)| [*mean, slope]);
    let nearest_depth_km = placement.centre_km.dot(camera.forward) - placement.radii_km.max_element();
    // Nearer than the near side by a few rounding errors of f32. If the near side is closer than the near plane: the depth of
    // that plane, because nothing can be in front of the body.
    let depth =
        if nearest_depth_km > NEAR_DEPTH_KM { NEAR_DEPTH_KM / nearest_depth_km * (1.0 + 4.0 * f64::from(f32::EPSILON)) } else { 1.0 };
    Some(RefractedLimb {
        body: placed.body.id,
        rays: rays_over(rect),
        unrefracted_sun: sun.outline.rect(camera).and_then(|of_sun| of_sun.intersection(&rect)).map(rays_over),
        drawn_fraction: narrow_scalar(drawn_fraction),
        axis_ratios: narrow(placement.radii_km / placement.radii_km.x),
        depth: narrow_scalar(depth.min(1.0)),
        sun_direction: narrow(sun_direction).extend(narrow_scalar(cot_sun_angular_radius)),
        sun_basis: [x, y].map(|v| narrow(v).extend(0.0)),
        sun_limb_darkening: sun_radiance(sun.body).map(|f| narrow(f * tint * drawn_fraction).extend(0.0)),
        air_edges,
        air_transmittance: transmittances.map(|v| narrow(v).extend(0.0)).collect(),
    })
}

/// Whether the camera is inside the body's atmosphere.
fn camera_is_inside(placed: &PlacedBody<'_>) -> bool {
    atmosphere::air::shell(placed.body, &placed.placement).is_some_and(|shell| shell.camera_is_inside())
}

/// Decides which refracted limbs a frame shows, records the decisions in the bodies' reports, and returns the uniforms. `tint`: for a vector to the source of
/// light, the colour that the air around the camera gives to this light ([`atmosphere::air::SurroundingAir::tint`]).
pub(crate) fn refracted_limbs(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    threshold: Threshold,
    tint: impl Fn(DVec3) -> DVec3,
    reports: &mut [BodyReport],
) -> Vec<RefractedLimb> {
    let Some(sun) = placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > 0.0) else { return Vec::new() };
    let mut all = Vec::new();
    for p in placed.iter().filter(|p| refraction::refracts(p.body) && p.distance_km > 0.0 && request.pixel_view == PixelView::Final) {
        let is_this_disc = |b: &&mut BodyReport| b.id == p.body.id && matches!(b.appearance, Appearance::Disc | Appearance::DiscAndPoint);
        let Some(report) = reports.iter_mut().find(is_this_disc) else { continue };
        let own_effects = request.effects.for_catalog_body(p.body);
        let effects = own_effects.as_ref().unwrap_or(&request.effects);
        let mut record = |on: bool, reason: Reason| {
            report.decisions.push(Decision { effect: Effect::RefractedLimb.name(), on, reason, stated_error: None });
            on
        };
        let shift_per_bending = refraction::shift_per_bending(p.distance_km, sun.distance_km);
        let reduced_bending = refraction::max_reduced_bending(p.body, shift_per_bending);
        let geometry = LimbGeometry::of(p, sun);
        let why_not = match (reduced_bending, effects.override_of(Effect::Atmosphere)) {
            (None, _) => Some(reason!("eclipse-no-bending")),
            (_, Some(false)) => Some(reason!("eclipse-air-off")),
            _ if camera_is_inside(p) => Some(reason!("eclipse-in-air")),
            _ if sun.distance_km <= p.distance_km => Some(reason!("eclipse-not-before-sun")),
            _ if report.diameter_px < DISC_ONLY_FROM_PX => {
                Some(reason!("eclipse-disc-small", size = format_args!("{:.1}", report.diameter_px), threshold = DISC_ONLY_FROM_PX))
            }
            _ => None,
        };
        if let Some(why_not) = why_not {
            record(false, why_not);
            continue;
        }
        // If no layer can show the Sun, nothing is drawn even on request: the step that removes the unrefracted Sun would remove it from every pixel that
        // the limb crosses.
        let layers = reduced_bending
            .filter(|reduced_bending| geometry.may_show_sun(p, *reduced_bending))
            .and_then(|_| refraction::layers(p.body, p.body.radii_km.x, OUTLINE_RADIUS, shift_per_bending));
        // A body drawn as a point shows no refracted limb, so that of a small disc fades.
        let drawn_fraction = beyond_small_disc(report.diameter_px);
        let tint = tint(p.placement.centre_km);
        // At the centre of the Sun's disc mu is 1.
        let centre_radiance: DVec3 = sun_radiance(sun.body).iter().sum::<DVec3>() * tint * drawn_fraction;
        let shown = layers.map(|layers| {
            let max_radiance =
                geometry.max_radiance(&layers, centre_radiance, camera.pixel_tangent() * geometry.limb_distance).max_element();
            (layers, max_radiance)
        });
        let Some((layers, max_radiance)) = shown.filter(|(_, max_radiance)| *max_radiance > 0.0) else {
            record(false, reason!("eclipse-no-layer"));
            continue;
        };
        let on = match effects.override_of(Effect::RefractedLimb) {
            Some(on) => record(on, reason!("set-by-you")),
            None => record(
                threshold.is_exceeded_by_radiance(max_radiance),
                reason!("eclipse-at-most", light = threshold.radiance_description(max_radiance)),
            ),
        };
        if on {
            all.extend(refracted_limb(camera, p, sun, &layers, tint, drawn_fraction));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmittance_is_monotone_between_layers_and_never_negative() {
        let rising: Vec<_> = [0.0, 1e-9, 1e-4, 0.02, 0.3, 0.8, 0.97, 1.0].map(DVec3::splat).to_vec();
        let slopes = slopes(&rising);
        for (k, (mean, slope)) in rising.iter().zip(&slopes).enumerate() {
            let (low, high) = (mean.x - 0.5 * slope.x, mean.x + 0.5 * slope.x);
            assert!(low >= -1e-15 && high <= 1.0 + 1e-15 && slope.x >= 0.0, "{k}: {low} to {high}");
            assert!(k == 0 || low >= rising[k - 1].x - 1e-15, "{k}");
            assert!(k + 1 == rising.len() || high <= rising[k + 1].x + 1e-15, "{k}");
        }
        // At k = 4 the slope is the central difference, (0.8 - 0.02) / 2 = 0.39.
        assert!(slopes[4].x > 0.2, "the slope in the middle of a smooth rise must not vanish: {}", slopes[4].x);
    }
}
