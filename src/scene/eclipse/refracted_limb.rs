//! The refracted limb: the Sun's image in the air at the limb of a body that stands before it.
//!
//! In: the bodies where the viewer sees them. Out: a [`RefractedLimb`] for each whose air bends light, seen from outside of that air, with the reason. Its
//! layers are those of the `refracted` eclipse (eclipse/air.rs): what the ring around the body shines with, summed over the sky of a point, is what that
//! eclipse gives the point. So that no light counts twice, all of the Sun below the top of that air belongs to the ring: what its disc drew there along
//! straight rays is taken away before the air is drawn. Lengths are the body's equatorial radii. Not here: how a pixel is summed
//! (shaders/entry/refracted_limb.wesl). Left out: bodies that stand before the Sun as the limb sees it, and the Sun's map.

use crate::catalog::{Body, NaifId};
use crate::scene::atmosphere;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{AnchorForm, Camera, NEAR_DEPTH_KM, Placement, ViewRays, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::eclipse::air::{self, RefractingLayers};
use crate::scene::eclipse::occluders::limb_law;
use crate::scene::in_view::Appearance;
use crate::scene::in_view::BodyInView;
use crate::scene::light::photometry;
use crate::scene::placed::PlacedBody;
use crate::scene::point::BLEND_TO_PX;
use crate::scene::purpose::Bound;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use glam::{DVec3, DVec4, Vec3, Vec4};

/// Uniforms of shaders/entry/refracted_limb.wesl, and where it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct RefractedLimb {
    pub body: NaifId,
    /// Over the air.
    pub rays: ViewRays,
    /// Over what of the Sun's disc was drawn unbent behind it.
    pub unbent: Option<ViewRays>,
    pub axis_ratios: Vec3,
    pub depth: f32,
    /// Unit vector, body axes; cotangent of the Sun's angular radius.
    pub sun_direction: Vec4,
    pub sun_across: [Vec4; 2],
    /// Radiance: factors of 1, mu, mu².
    pub sun_limb: [Vec4; 3],
    /// Height over the limb; solar radii by which the place on the Sun moves.
    pub air_edges: Vec<Vec4>,
    /// What a layer lets through: its mean, then its change from the lower edge to the upper.
    pub air_transmittance: Vec<Vec4>,
}

/// Changes of the transmission across each layer: the slope between its neighbours, so small that it goes over from one to the next without
/// reaching beyond either.
fn slopes(passes: &[DVec3]) -> Vec<DVec3> {
    let at = |k: usize| passes[k.min(passes.len() - 1)];
    let slope = |k: usize| {
        let (before, here, after) = (at(k.saturating_sub(1)), at(k), at(k + 1));
        let (up, down) = (after - here, here - before);
        let least = (2.0 * up.abs()).min(2.0 * down.abs()).min(0.5 * (up + down).abs());
        let rises = up.cmpgt(DVec3::ZERO) & down.cmpgt(DVec3::ZERO);
        let falls = up.cmplt(DVec3::ZERO) & down.cmplt(DVec3::ZERO);
        DVec3::select(rises, least, DVec3::select(falls, -least, DVec3::ZERO))
    };
    (0..passes.len()).map(slope).collect()
}

/// Radiance of the Sun's disc as factors of 1, mu, mu², per channel.
fn sun_radiance(sun: &Body) -> [DVec3; 3] {
    let (u1, u2) = limb_law(sun);
    let centre = sun.colour.as_dvec3() * photometry::normalisation(sun) * photometry::sun_disc_radiance();
    [1.0 - u1 - u2, u1 + 2.0 * u2, -u2].map(|factor| factor * centre)
}

/// The Sun and a body before it, as angles at the camera.
struct Sky {
    sun_radius: f64,
    /// Between the two centres.
    apart: f64,
    /// From the body's centre to its limb, and what that is wrong by for a body that is no sphere.
    limb: f64,
    uneven: f64,
    /// To the limb.
    distance: f64,
}

impl Sky {
    fn of(p: &PlacedBody<'_>, sun: &PlacedBody<'_>) -> Self {
        let camera = p.placement.camera_in_unit_sphere().length();
        let limb = (1.0 / camera).min(1.0).asin();
        Self {
            sun_radius: (sun.body.radii_km.x / sun.distance_km).min(1.0).asin(),
            apart: crate::ephemeris::angle_rad(p.placement.centre_km, sun.placement.centre_km),
            limb,
            uneven: limb * crate::scene::features::choice::flattening(p.body),
            distance: (camera * camera - 1.0).max(1e-12).sqrt(),
        }
    }

    /// Whether any layer can show the Sun: known without the layers, which take milliseconds to make.
    fn can_show(&self, p: &PlacedBody<'_>, greatest_bending: f64) -> bool {
        let top_km = p.body.atmosphere.as_ref().map_or(0.0, |air| air.top_km);
        let outermost = self.limb + top_km / p.body.radii_km.x / self.distance;
        let innermost = self.limb - greatest_bending;
        let room = self.sun_radius + self.uneven;
        self.apart - room <= outermost.max(-innermost) && self.apart + room >= innermost
    }

    /// Where the lower edge and the upper edge of a layer show what lies behind, as angles from the body's centre.
    fn shown_by(&self, edge: &DVec4) -> (f64, f64) {
        let at = |radius: f64, bending: f64| self.limb + (radius - 1.0) / self.distance - bending;
        (at(edge.x, edge.y), at(edge.z, edge.w))
    }

    /// The most that the layers can shine with, per channel, in pixels that span this many radii at the limb: all that show the Sun somewhere, at its
    /// centre's radiance.
    fn most(&self, layers: &RefractingLayers, centre: DVec3, pixel: f64) -> DVec3 {
        let shows = |edge: &DVec4| {
            let (low, high) = self.shown_by(edge);
            let nearest = if low * high <= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
            let room = self.sun_radius + self.uneven;
            nearest <= self.apart + room && low.abs().max(high.abs()) >= self.apart - room
        };
        let shown = layers.edges.iter().zip(&layers.passes).filter(|(edge, _)| shows(edge));
        let (sum, greatest) = shown.fold((DVec3::ZERO, DVec3::ZERO), |(sum, greatest), (edge, passes)| {
            (sum + *passes * ((edge.z - edge.x) / pixel), greatest.max(*passes))
        });
        centre * sum.min(greatest)
    }
}

/// A piece of a refracted limb as the camera sees it.
pub(crate) struct LimbPiece {
    /// From the camera to its middle, unit vector in ICRF.
    pub direction: DVec3,
    /// Solid angle, sr: of the layers that show the Sun, or of a pixel's width of the limb where that is more.
    pub solid_angle: f64,
    /// Mean radiance over that, of the brightest channel.
    pub radiance: f64,
}

/// Pieces on each side of the limb.
const PIECES: u32 = 24;

/// The refracted limb in pieces, for the light meter: where the layers of a body's air show the Sun, whose disc counts as evenly bright. A sphere's limb: seen from
/// a body's flattened side the arcs lie a little beside their places. None for air that does not bend light, from inside of it, where the Sun is nearer, and for discs so small that it is not drawn.
pub(crate) fn pieces(p: &PlacedBody<'_>, sun: &PlacedBody<'_>, pixel_rad: f64) -> Vec<LimbPiece> {
    if p.distance_km <= 0.0 || sun.distance_km <= p.distance_km || camera_is_inside(p) {
        return Vec::new();
    }
    let (sky, shown) = (Sky::of(p, sun), air::shown(p.distance_km, sun.distance_km));
    let is_possible = 2.0 * sky.limb >= BLEND_TO_PX * pixel_rad && air::greatest_bending(p.body, shown).is_some_and(|b| sky.can_show(p, b));
    let Some(layers) = is_possible.then(|| air::layers(p.body, p.body.radii_km.x, 1.0, shown)).flatten() else { return Vec::new() };
    let towards = p.placement.centre_km / p.distance_km;
    let aside = sun.placement.centre_km / sun.distance_km;
    let x = (aside - towards * towards.dot(aside)).try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
    let y = towards.cross(x);
    // Position angles whose radius crosses the Sun's disc, on its own side and on the opposite one.
    let reach = (sky.sun_radius / sky.apart.max(1e-300)).min(1.0).asin();
    let places = (0..2 * PIECES).map(|k| {
        let side = if k < PIECES { 0.0 } else { std::f64::consts::PI };
        side + reach * (2.0 * (f64::from(k % PIECES) + 0.5) / f64::from(PIECES) - 1.0)
    });
    let step = 2.0 * reach / f64::from(PIECES);
    let pixel = pixel_rad * sky.distance;
    let piece = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let half_chord = (sky.sun_radius.powi(2) - (sky.apart * sin).powi(2)).max(0.0).sqrt();
        let (from, to) = (sky.apart * cos - half_chord, sky.apart * cos + half_chord);
        // Thickness of what shows the Sun, radii, and the light of it.
        let (thickness, light) = layers.edges.iter().zip(&layers.passes).fold((0.0, 0.0), |(thickness, light), (edge, passes)| {
            let (low, high) = sky.shown_by(edge);
            let shown = (high.min(to) - low.max(from)).max(0.0) / (high - low).max(1e-300) * (edge.z - edge.x);
            (thickness + shown, light + shown * passes.max_element())
        });
        let width = thickness.max(pixel);
        let (out, along) = sky.limb.sin_cos();
        LimbPiece {
            direction: towards * along + (x * cos + y * sin) * out,
            solid_angle: step * out * width / sky.distance,
            radiance: photometry::sun_disc_radiance() * light / width,
        }
    };
    places.map(piece).filter(|piece| piece.radiance > 0.0).collect()
}

fn limb(camera: &Camera, p: &PlacedBody<'_>, sun: &PlacedBody<'_>, layers: &RefractingLayers, tint: DVec3) -> Option<RefractedLimb> {
    let place = &p.placement;
    let top = layers.edges.last()?.z;
    let shell = Placement { radii_km: place.radii_km * top, ..*place };
    let rect = Outline::of(camera, &shell).rect(camera)?;
    let over = |rect| camera.view_rays(place, rect, AnchorForm::Auto);
    let towards = (place.body_from_icrf * sun.placement.centre_km).normalize();
    let (x, y) = towards.any_orthonormal_pair();
    let cot = ((sun.distance_km - sun.body.radii_km.x) * (sun.distance_km + sun.body.radii_km.x)).sqrt() / sun.body.radii_km.x;
    let edge = |radius: f64, bending: f64| Vec4::new(narrow_scalar(radius - 1.0), narrow_scalar(bending * cot), 0.0, 0.0);
    let first = layers.edges.first()?;
    let air_edges = std::iter::once(edge(first.x, first.y)).chain(layers.edges.iter().map(|e| edge(e.z, e.w))).collect();
    let passes = layers.passes.iter().zip(slopes(&layers.passes)).flat_map(|(mean, slope)| [*mean, slope]);
    let near_km = place.centre_km.dot(camera.forward) - place.radii_km.max_element();
    // Nothing lies between the camera and a body whose near side is beside it.
    let depth = if near_km > NEAR_DEPTH_KM { NEAR_DEPTH_KM / near_km * (1.0 + 4.0 * f64::from(f32::EPSILON)) } else { 1.0 };
    Some(RefractedLimb {
        body: p.body.id,
        rays: over(rect),
        unbent: sun.outline.rect(camera).and_then(|of_sun| of_sun.common(&rect)).map(over),
        axis_ratios: narrow(place.radii_km / place.radii_km.x),
        depth: narrow_scalar(depth.min(1.0)),
        sun_direction: narrow(towards).extend(narrow_scalar(cot)),
        sun_across: [x, y].map(|v| narrow(v).extend(0.0)),
        sun_limb: sun_radiance(sun.body).map(|f| narrow(f * tint).extend(0.0)),
        air_edges,
        air_transmittance: passes.map(|v| narrow(v).extend(0.0)).collect(),
    })
}

fn camera_is_inside(p: &PlacedBody<'_>) -> bool {
    atmosphere::air::shell(p.body, &p.placement).is_some_and(|shell| shell.camera_is_inside())
}

/// Decides on the refracted limbs of a frame and notes them among the features of their bodies. `tint`: what the camera's own air leaves of light from a
/// direction.
pub(crate) fn limbs(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    bound: Bound,
    tint: impl Fn(DVec3) -> DVec3,
    bodies: &mut [BodyInView],
) -> Vec<RefractedLimb> {
    let Some(sun) = placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > 0.0) else { return Vec::new() };
    let mut all = Vec::new();
    for p in placed.iter().filter(|p| air::bends(p.body) && p.distance_km > 0.0 && request.pixel_view == PixelView::Final) {
        let drawn = |b: &&mut BodyInView| b.id == p.body.id && matches!(b.appearance, Appearance::Disc | Appearance::DiscAndPoint);
        let Some(body) = bodies.iter_mut().find(drawn) else { continue };
        let own = request.effects.for_body(&p.body.name);
        let effects = own.as_ref().unwrap_or(&request.effects);
        let mut note = |on: bool, reason: String| {
            body.decisions.push(Decision { feature: Effect::RefractedLimb.name(), on, reason, tier: None });
            on
        };
        let shown = air::shown(p.distance_km, sun.distance_km);
        let bending = air::greatest_bending(p.body, shown);
        let sky = Sky::of(p, sun);
        let why_not = match (bending, effects.override_of(Effect::Atmosphere)) {
            (None, _) => Some("nothing is known of how its air bends light".into()),
            (_, Some(false)) => Some("its air is switched off".into()),
            _ if camera_is_inside(p) => Some("the camera is in its air".into()),
            _ if sun.distance_km <= p.distance_km => Some("it does not stand before the Sun".into()),
            _ if body.diameter_px < BLEND_TO_PX => Some(format!("its disc is {:.1} px across against {BLEND_TO_PX}", body.diameter_px)),
            _ => None,
        };
        if let Some(why_not) = why_not {
            note(false, why_not);
            continue;
        }
        let wanted = effects.override_of(Effect::RefractedLimb);
        let is_possible = wanted == Some(true) || bending.is_some_and(|bending| sky.can_show(p, bending));
        let Some(layers) = is_possible.then(|| air::layers(p.body, p.body.radii_km.x, 1.0, shown)).flatten() else {
            note(false, "no layer of its air shows the Sun".into());
            continue;
        };
        let tint = tint(p.placement.centre_km);
        let centre: DVec3 = sun_radiance(sun.body).iter().sum::<DVec3>() * tint;
        let part = sky.most(&layers, centre, camera.pixel_tangent() * sky.distance).max_element();
        let reason = if part > 0.0 { format!("at most {}", bound.description(part)) } else { "no layer of its air shows the Sun".into() };
        let on = match wanted {
            Some(on) => note(on, "set by you".into()),
            None => note(bound.counts(part), reason),
        };
        if on {
            all.extend(limb(camera, p, sun, &layers, tint));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmissions_go_over_from_layer_to_layer_and_never_below_nothing() {
        let rising: Vec<_> = [0.0, 1e-9, 1e-4, 0.02, 0.3, 0.8, 0.97, 1.0].map(DVec3::splat).to_vec();
        let slopes = slopes(&rising);
        for (k, (mean, slope)) in rising.iter().zip(&slopes).enumerate() {
            let (low, high) = (mean.x - 0.5 * slope.x, mean.x + 0.5 * slope.x);
            assert!(low >= -1e-15 && high <= 1.0 + 1e-15 && slope.x >= 0.0, "{k}: {low} to {high}");
            assert!(k == 0 || low >= rising[k - 1].x - 1e-15, "{k}");
            assert!(k + 1 == rising.len() || high <= rising[k + 1].x + 1e-15, "{k}");
        }
        assert!(slopes[4].x > 0.2, "a smooth middle is not flat: {}", slopes[4].x);
    }
}
