//! Which bodies stand before the Sun as a body's ground sees it, and by which model their shadows are computed.
//!
//! In: the receiver as the viewer sees it, and the catalog's other bodies. Out: at most [`MAX_OCCLUDERS`] occluders that a bound lets
//! through. Light takes time: an occluder stands where it was when the light that meets the receiver passed it,
//! and the Sun where that light left it. Both directions carry the aberration of the receiver's motion: it leaves their separation at the
//! centre, but tilts the axis along which the shadow meets the rest of the body (20 arcsec at the Earth: 0.6 km, 0.6 s). Not here: how much light
//! is left (shaders/lib/eclipse).

use crate::catalog::{Body, BodyKind, NaifId, Photometry};
use crate::ephemeris::Ephemeris;
use crate::ephemeris::apparent::aberrated;
use crate::scene::draw::features::{Eclipse, EclipseModel, MAX_OCCLUDERS};
use crate::scene::eclipse::air as refraction;
use crate::scene::thresholds::VISIBLE_CHANGE;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat2, DMat3, DVec2, DVec3};

/// The body that is lit, at the moment when light met it.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    pub body: &'a Body,
    /// Barycentric ICRF.
    pub position_km: DVec3,
    pub time: Instant,
    pub body_from_icrf: DMat3,
    pub velocity_km_s: DVec3,
    /// To the Sun where the light left it.
    pub sun_from_body_km: DVec3,
}

impl<'a> Receiver<'a> {
    /// A body by its own clock: light meets it at `time`.
    pub fn at(ephemeris: &Ephemeris, body: &'a Body, time: Instant) -> Result<Self, crate::ephemeris::EphemerisError> {
        let state = ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, time, None)?.state;
        let position_km = state.pos_km;
        let sun_from_body_km = ephemeris.light_time_position(NaifId::SUN, position_km, time)?.0 - position_km;
        let velocity_km_s = state.vel_km_s;
        Ok(Self { body, position_km, time, velocity_km_s, body_from_icrf: ephemeris.body_from_icrf(body.id, time)?, sun_from_body_km })
    }

    pub(crate) fn radius_km(&self) -> f64 {
        self.body.radii_km.x
    }

    /// An offset from its centre as the moving body sees it: body axes, equatorial radii.
    fn seen(&self, offset_km: DVec3) -> DVec3 {
        let distance_km = offset_km.length();
        if distance_km > 0.0 {
            self.body_from_icrf * aberrated(offset_km / distance_km, self.velocity_km_s) * (distance_km / self.radius_km())
        } else {
            DVec3::ZERO
        }
    }
}

/// The axis from the receiver's centre to the Sun's, body axes; lengths in the receiver's equatorial radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) along: DVec3,
    pub(crate) across: [DVec3; 2],
    pub(crate) sun_distance: f64,
    /// Cotangent of the Sun's angular radius.
    pub(crate) cot: f64,
}

impl Axis {
    pub(crate) fn of(receiver: &Receiver<'_>, sun: &Body) -> Option<Self> {
        let to_sun = receiver.seen(receiver.sun_from_body_km);
        let sun_radius = sun.radii_km.max_element() / receiver.radius_km();
        let sun_distance = to_sun.length();
        if sun_distance.partial_cmp(&sun_radius) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let along = to_sun / sun_distance;
        let (x, y) = along.any_orthonormal_pair();
        let cot = ((sun_distance - sun_radius) * (sun_distance + sun_radius)).sqrt() / sun_radius;
        Some(Self { along, across: [x, y], sun_distance, cot })
    }

    pub(crate) fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.across[0]), v.dot(self.across[1]))
    }
}

/// Light between most bodies of one system takes less: so long a moon's path is straight to 0.4 km (Metis, which turns most), Io's to 40 m (tests/ephemeris/positions.rs).
const STRAIGHT_S: f64 = 10.0;

/// A body that may stand before the Sun: its outline in parallel light along the axis, receiver's equatorial radii.
#[derive(Clone, Debug)]
pub struct Occluder<'a> {
    pub body: &'a Body,
    pub(crate) across: DVec2,
    pub(crate) along: f64,
    /// Unit vector of the long axis, then the semi-axes, long and short.
    pub(crate) long_axis: DVec2,
    pub(crate) semi: DVec2,
    /// Most of the Sun's light that it blocks at any point of the receiver, 1 for all.
    pub(crate) max_obscuration: f64,
    /// Whether some point of the receiver sees nothing of the Sun past it.
    pub(crate) umbra: bool,
}

/// Limb darkening of a body that glows, per channel; even where it does not glow.
pub fn limb_law(body: &Body) -> (DVec3, DVec3) {
    match body.photometry {
        Photometry::Emissive { u1, u2 } => (DVec3::from_array(u1), DVec3::from_array(u2)),
        _ => (DVec3::ZERO, DVec3::ZERO),
    }
}

/// The brightest channel's centre of the Sun's disc over the disc's mean; see catalogs/README.md for the coefficients.
fn centre_over_mean(sun: &Body) -> f64 {
    let (u1, u2) = limb_law(sun);
    (0..3).map(|c| 1.0 / (1.0 - u1[c] / 3.0 - u2[c] / 6.0)).fold(1.0, f64::max)
}

/// What a receiver's ground may look like to the viewer and how far light for it is taken from the centre.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverExtent {
    /// Farthest lit point from the centre, equatorial radii: 1 for the ground, more with air, clouds or rings.
    pub reach: f64,
    /// Camera from the centre, body axes, equatorial radii; `None`: every side is seen.
    pub camera: Option<DVec3>,
    /// Equatorial radii that a pixel spans; 0: points are asked for.
    pub pixel: f64,
}

/// The occluders that count on a receiver, those that block most light first; and the strongest of all with what it blocks.
pub struct OccluderSearch<'a> {
    pub occluders: Vec<Occluder<'a>>,
    pub reason: String,
}

/// Looks for the occluders of `receiver` among `bodies`. `everything`: those below the bound count too, if their penumbra touches.
pub fn find<'a>(
    ephemeris: &Ephemeris,
    bodies: impl Iterator<Item = &'a Body>,
    sun: &Body,
    receiver: &Receiver<'_>,
    extent: ReceiverExtent,
    everything: bool,
) -> OccluderSearch<'a> {
    select_occluders(&candidates(ephemeris, bodies, sun, receiver), sun, receiver, extent, everything)
}

/// The bodies between the receiver and the Sun that are not far too small, wherever they pass: what takes the ephemeris' time.
pub fn candidates<'a>(
    ephemeris: &Ephemeris,
    bodies: impl Iterator<Item = &'a Body>,
    sun: &Body,
    receiver: &Receiver<'_>,
) -> Vec<Occluder<'a>> {
    let Some(axis) = Axis::of(receiver, sun) else { return Vec::new() };
    let others = bodies.filter(|b| b.id != receiver.body.id && b.id != sun.id && can_occlude(b, receiver.body));
    others.filter_map(|body| Occluder::of(ephemeris, body, receiver, &axis, sun)).collect()
}

/// The occluders among the candidates of the same receiver.
pub fn select_occluders<'a>(
    candidates: &[Occluder<'a>],
    sun: &Body,
    receiver: &Receiver<'_>,
    extent: ReceiverExtent,
    everything: bool,
) -> OccluderSearch<'a> {
    let Some(axis) = Axis::of(receiver, sun) else {
        return OccluderSearch { occluders: Vec::new(), reason: "it is inside the Sun".into() };
    };
    let mut occluders = Vec::new();
    let mut nearest: Option<(f64, &'a str)> = None;
    for occluder in candidates {
        let occluder = occluder.within(&axis, sun, extent.reach, receiver.radius_km());
        let body = occluder.body;
        let miss = occluder.miss(&axis, extent.reach);
        if miss > 0.0 {
            let share = miss / occluder.penumbra(&axis, extent.reach);
            if occluder.max_obscuration > VISIBLE_CHANGE && nearest.is_none_or(|(least, _)| share < least) {
                nearest = Some((share, &body.name));
            }
            continue;
        }
        // A shadow smaller than a pixel darkens it by its area.
        let of_pixel = if extent.pixel > 0.0 { occluder.shadow_area() / (extent.pixel * extent.pixel) } else { 1.0 };
        let counts = occluder.max_obscuration * of_pixel.min(1.0) > VISIBLE_CHANGE && occluder.shadow_is_visible(&axis, extent);
        if counts || everything {
            occluders.push(occluder);
        }
    }
    occluders.sort_by(|a, b| (b.max_obscuration * b.shadow_area()).total_cmp(&(a.max_obscuration * a.shadow_area())));
    let left_out = occluders.len().saturating_sub(usize::from(MAX_OCCLUDERS));
    occluders.truncate(usize::from(MAX_OCCLUDERS));
    let reason = match (occluders.first(), nearest) {
        (Some(first), _) => {
            let names: Vec<_> = occluders.iter().map(|c| c.body.name.as_str()).collect();
            let more = if left_out > 0 { format!("; {left_out} weaker ones omitted") } else { String::new() };
            format!(
                "penumbra of {} on its lit side; {} takes up to {:.3} of the light{more}",
                names.join(", "),
                first.body.name,
                first.max_obscuration
            )
        }
        (None, Some((share, name))) => format!("nearest penumbra: {name}'s, {share:.2} of its radius outside"),
        (None, None) => format!("no occluder blocks more than {VISIBLE_CHANGE:.2e} of the sunlight in view"),
    };
    OccluderSearch { occluders, reason }
}

/// The planet that a body belongs to, itself for a planet.
fn system(body: &Body) -> NaifId {
    body.parent.filter(|p| *p != NaifId::SUN).unwrap_or(body.id)
}

/// Bodies of other systems are far away: only planets can take as much as the bound (Jupiter a twentieth of Saturn's Sun; Ganymede 7e-5).
fn can_occlude(occluder: &Body, receiver: &Body) -> bool {
    system(occluder) == system(receiver) || occluder.kind == BodyKind::Planet
}

/// What a body of this radius blocks at most of the Sun's light when it passes this far before it.
fn max_obscuration(radius: f64, axis: &Axis, sun: &Body, depth: f64) -> f64 {
    let solar_radii = radius * axis.cot / depth.max(1e-9);
    if solar_radii >= 1.0 { 1.0 } else { (solar_radii * solar_radii * centre_over_mean(sun)).min(1.0) }
}

impl<'a> Occluder<'a> {
    fn of(ephemeris: &Ephemeris, body: &'a Body, receiver: &Receiver<'_>, axis: &Axis, sun: &Body) -> Option<Self> {
        let unit_km = receiver.radius_km();
        let radius = body.radii_km.max_element() / unit_km;
        // Where it is now serves to leave out what is far too small or on the wrong side, with twice the room.
        let now = ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, receiver.time, None).ok()?.state;
        let away_km = (now.pos_km - receiver.position_km).length();
        if max_obscuration(radius, axis, sun, 0.5 * away_km / unit_km) < 0.1 * VISIBLE_CHANGE {
            return None;
        }
        let light_s = away_km / SPEED_OF_LIGHT_KM_S;
        let (position_km, passed_at) = if light_s < STRAIGHT_S {
            // The speeds of a system are 1e-4 of light's: one more round leaves nothing to see.
            let light_s = (now.pos_km - now.vel_km_s * light_s - receiver.position_km).length() / SPEED_OF_LIGHT_KM_S;
            (now.pos_km - now.vel_km_s * light_s, receiver.time.plus_seconds(-light_s))
        } else {
            ephemeris.light_time_position(body.id, receiver.position_km, receiver.time).ok()?
        };
        let centre = receiver.seen(position_km - receiver.position_km);
        let (along, across) = (centre.dot(axis.along), axis.across(centre));
        if along <= 0.0 || along >= axis.sun_distance {
            return None;
        }
        let occluder_from_icrf = ephemeris.body_from_icrf(body.id, passed_at).ok()?;
        let (long_axis, semi) = outline(axis, receiver.body_from_icrf * occluder_from_icrf.transpose(), body.radii_km / unit_km);
        Some(Self { body, across, along, long_axis, semi, max_obscuration: 0.0, umbra: false })
    }

    /// What it can do to points of the receiver no farther than `reach` from its centre.
    fn within(&self, axis: &Axis, sun: &Body, reach: f64, unit_km: f64) -> Self {
        let radius = self.body.radii_km.max_element() / unit_km;
        let max_obscuration = max_obscuration(radius, axis, sun, (self.along - reach).max(radius));
        let umbra = self.across.length() < reach + self.semi.x - self.along / axis.cot;
        Self { max_obscuration, umbra, ..self.clone() }
    }

    /// Radius of the penumbra where it meets the receiver.
    fn penumbra(&self, axis: &Axis, reach: f64) -> f64 {
        self.semi.x + (self.along + reach) / axis.cot
    }

    /// Of its cross section: umbra and penumbra together take the light of that much ground, or less.
    fn shadow_area(&self) -> f64 {
        std::f64::consts::PI * self.semi.x * self.semi.y
    }

    /// By how much the penumbra misses the receiver; not above 0: it touches.
    fn miss(&self, axis: &Axis, reach: f64) -> f64 {
        self.across.length() - reach - self.penumbra(axis, reach)
    }

    /// Whether some point that it may darken can be seen. Points around the penumbra and inside are asked, and the point of the lit
    /// side that faces the camera most; a margin of 0.03 radii covers what lies between them.
    fn shadow_is_visible(&self, axis: &Axis, extent: ReceiverExtent) -> bool {
        let Some(camera) = extent.camera.filter(|_| extent.reach < 1.2) else { return true };
        let distance = camera.length();
        let radius = self.penumbra(axis, extent.reach) + 0.03;
        let towards = camera / distance;
        let horizon = 1.0 / distance - 0.03 - (extent.reach - 1.0).max(0.0).sqrt() * 1.5;
        let seen = |across: DVec2| {
            let across = across.clamp_length_max(1.0);
            let inside = (across - self.across).length() <= radius * 1.001;
            let along = (1.0 - across.length_squared()).max(0.0).sqrt();
            inside && axis.across(towards).dot(across) + towards.dot(axis.along) * along > horizon
        };
        let around = (0..96).any(|k| {
            let on_ring = DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 96.0);
            [1.0, 0.66, 0.33, 0.0].iter().any(|part| seen(self.across + on_ring * (radius * part)))
        });
        around || seen(axis.across(towards))
    }
}

/// Long axis and semi-axes of an ellipsoid's outline in light along the axis. `receiver_from_occluder` turns its axes, `radii` are its
/// semi-axes.
pub(crate) fn outline(axis: &Axis, receiver_from_occluder: DMat3, radii: DVec3) -> (DVec2, DVec2) {
    // The outline's squared half width along a unit vector n is n M n, M the sum of the semi-axes' squares across the light.
    let m = [0, 1, 2].map(|k| {
        let a = axis.across(receiver_from_occluder.col(k)) * radii[k];
        DMat2::from_cols(a * a.x, a * a.y)
    });
    let m = m[0] + m[1] + m[2];
    let (p, q, r) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let (mean, spread) = (0.5 * (p + r), (0.5 * (p - r)).hypot(q));
    let long_axis = DVec2::from_angle(0.5 * (2.0 * q).atan2(p - r));
    (long_axis, DVec2::new((mean + spread).max(0.0).sqrt(), (mean - spread).max(0.0).sqrt()))
}

/// The model that was asked for, or the tier's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EclipseModelChoice {
    Asked(EclipseModel),
    /// Even discs where the picture is a draft; the darkened limb and refracted light otherwise.
    Draft,
    Best,
}

/// Picks the model and puts an occluder with air first where its air counts.
pub fn model(occluders: &mut [Occluder<'_>], wanted: EclipseModelChoice) -> Eclipse {
    let count = u8::try_from(occluders.len()).unwrap_or(MAX_OCCLUDERS);
    let asked_refracted = wanted == EclipseModelChoice::Asked(EclipseModel::Refracted);
    let model = match wanted {
        _ if count == 0 => EclipseModel::None,
        EclipseModelChoice::Asked(EclipseModel::Refracted) | EclipseModelChoice::Best => {
            match occluders.iter().position(|c| refraction::bends(c.body) && (c.umbra || asked_refracted)) {
                Some(k) => {
                    occluders[..=k].rotate_right(1);
                    EclipseModel::Refracted
                }
                None => EclipseModel::LimbDarkened,
            }
        }
        EclipseModelChoice::Asked(model) => model,
        EclipseModelChoice::Draft => EclipseModel::UniformDisc,
    };
    Eclipse { occluders: count, model }
}

/// The most occluders that a body of the catalog can meet, and whether one of them has air that bends light: the others of its system, and one
/// planet more for those outside of Jupiter's orbit (from inside every planet stays below the bound).
pub fn possible<'a>(bodies: &'a [Body], receiver: &'a Body) -> (u8, bool) {
    let mut others = bodies.iter().filter(|b| b.id != receiver.id && b.id != NaifId::SUN && system(b) == system(receiver));
    let one_more = usize::from(!(100..600).contains(&receiver.id.0));
    let count = (others.clone().count() + one_more).min(usize::from(MAX_OCCLUDERS)) as u8;
    (if receiver.id == NaifId::SUN { 0 } else { count }, others.any(refraction::bends))
}
