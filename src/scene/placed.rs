//! Apparent places of bodies: light time, aberration for a moving viewer, orientation, outline and phase.
//!
//! In: a body of the catalog, the ephemeris and the viewer. Out: [`PlacedBody`], the input of every decision about the body.

use crate::catalog::{Body, Catalog, NaifId, Photometry};
use crate::ephemeris::Ephemeris;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::limb_profile::LimbProfile;
use crate::scene::camera::Placement;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::viewpoint;
use crate::scene::eclipse::occluders::{Occluder, Receiver};
use crate::scene::error::SceneError;
use crate::scene::light::brightness::{self, Irradiance};
use crate::scene::light::{disc_light, photometry};
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::resources::Caches;
use crate::scene::rings::rings_before_sun::RingsBeforeSun;
use crate::time::Instant;
use glam::{DMat3, DQuat, DVec3};
use std::cell::OnceCell;
use std::sync::Arc;

/// A body at its apparent place, before the decisions about its effects.
pub(crate) struct PlacedBody<'a> {
    pub body: &'a Body,
    /// All bodies of the catalog.
    pub catalog: &'a Catalog,
    /// Position at `emitted_at` relative to the solar-system barycentre, ICRF.
    pub position_km: DVec3,
    /// Vector from the body to the Sun, ICRF, with light time: to where the Sun was when it emitted the light that arrives at `emitted_at`. Zero for the Sun.
    pub body_to_sun_km: DVec3,
    /// The time at which the light that the viewer sees left the body.
    pub emitted_at: Instant,
    /// Orientation at `emitted_at` without aberration, for directions towards sources of light; `placement` has the orientation with aberration.
    pub body_from_icrf: DMat3,
    /// Position and orientation as the viewer sees them: both are rotated by aberration.
    pub placement: Placement,
    /// Distance from the camera.
    pub distance_km: f64,
    /// Angle at the body between the Sun and the viewer; 0 for the Sun.
    pub phase_angle_rad: f64,
    /// Outline of the ellipsoid in the image.
    pub outline: Outline,
    /// Irradiance at the viewer from globe and rings without eclipses and planet-shine, in units of the Sun's at 1 au.
    pub irradiance: Irradiance,
    /// The irradiance that the body shows where it is drawn as a point, linear RGB: `irradiance` without what the user has switched off. That may be the rings
    /// with their shadow and light on the globe, only ring-shine, or the light of air and glint.
    pub shown_irradiance: DVec3,
    /// The body as a receiver of sunlight, with all bodies that may be in front of the Sun as seen from it. Computed once and used for the exposure,
    /// the globe, its rings and its point.
    pub receiver_and_candidates: OnceCell<(Receiver<'a>, Vec<Occluder<'a>>)>,
    /// The rings of other bodies that take sunlight from the body (`eclipse::sun_occluders` computes them, once).
    pub rings_before_sun: OnceCell<Vec<RingsBeforeSun<'a>>>,
    /// The fraction of the body's light that nearer bodies leave visible, per channel (`visibility::hidden`). Computed once and used for the exposure, the
    /// glare, the corona and the draws.
    pub visible_fraction: OnceCell<DVec3>,
    /// The limb profile of the Moon if it is in front of the Sun and the user supplied lunar heights, else `None`. `visibility::lunar_limb` sets it.
    pub limb_profile: Option<Arc<LimbProfile>>,
}

impl PlacedBody<'_> {
    /// Angular radius of the body's bounding sphere; a right angle for a camera within it.
    pub(crate) fn angular_radius_rad(&self) -> f64 {
        (self.body.radii_km.max_element() / self.distance_km).min(1.0).asin()
    }

    /// Whether the body fills more than a right angle: it is ground with a horizon, not a disc with a diameter. So it is from within the air of any body of
    /// the built-in catalog. Not for a camera in the body, which does not see it.
    pub(crate) fn is_ground_below_camera(&self) -> bool {
        !self.placement.camera_is_inside() && self.angular_radius_rad() > std::f64::consts::FRAC_PI_4
    }

    /// What the radiance by the photometric model is multiplied by: the factor that makes the disc as bright as the published phase law
    /// ([`disc_light::phase_correction`]) or, for an emissive body, whose model gives 1, the radiance of the Sun's disc.
    pub(crate) fn phase_brightness(&self) -> f64 {
        self.phase_brightness_of_light(self.phase_angle_rad)
    }

    /// [`Self::phase_brightness`] for a light at a phase angle, which for planet-shine is another than the Sun's.
    pub(crate) fn phase_brightness_of_light(&self, phase_angle_rad: f64) -> f64 {
        match self.body.photometry {
            Photometry::Emissive { .. } => photometry::sun_disc_radiance(),
            _ => disc_light::phase_correction(self.body, phase_angle_rad, self.distance_km / self.body.radii_km.x),
        }
    }

    /// The factor that scales the photometric model to the catalog's geometric albedo, times [`Self::phase_brightness`].
    pub(crate) fn radiance_scale(&self) -> DVec3 {
        photometry::albedo_normalisation(self.body) * self.phase_brightness()
    }
}

/// Computes the apparent place of a body: light time, and aberration for a moving viewer.
pub(crate) fn place<'a>(
    catalog: &'a Catalog,
    body: &'a Body,
    ephemeris: &Ephemeris,
    viewer: &viewpoint::Viewer,
    request: &ViewRequest,
    caches: &Caches,
) -> Result<PlacedBody<'a>, SceneError> {
    let camera = &viewer.camera;
    // A body that carries the camera has the position given by `viewer`, without light time.
    let body_under_camera = viewer.stands_on.filter(|under| under.id == body.id);
    let body_around_camera = viewer.at_centre_of.filter(|around| around.id == body.id);
    let camera_is_at_centre = body_around_camera.is_some();
    let (position_km, emitted_at) = match body_under_camera.or(body_around_camera) {
        Some(body_with_camera) => (body_with_camera.centre_km, request.time),
        None => ephemeris.light_time_position(body.id, camera.position_km, request.time)?,
    };
    // Zero also for the eyes of a stereo pair, which are beside the centre: the body has no direction for them either.
    let astrometric_km = if camera_is_at_centre { DVec3::ZERO } else { position_km - camera.position_km };
    let distance_km = astrometric_km.length();
    let body_from_icrf = ephemeris.body_from_icrf(body.id, emitted_at)?;
    let mut placement = Placement { centre_km: astrometric_km, body_from_icrf, radii_km: body.radii_km };
    // A body on which the camera stands moves with it, so it has no aberration.
    if viewer.velocity_km_s != DVec3::ZERO && distance_km > 0.0 && body_under_camera.is_none() {
        let direction = astrometric_km / distance_km;
        let apparent = aberrated(direction, viewer.velocity_km_s);
        // Aberration moves the body's image on the sky but shows no other side of the body. So the orientation is rotated together with the direction.
        let apparent_from_astrometric = DMat3::from_quat(DQuat::from_rotation_arc(direction, apparent));
        placement.centre_km = apparent * distance_km;
        placement.body_from_icrf = body_from_icrf * apparent_from_astrometric.transpose();
    }
    let body_to_sun_km = if body.id == NaifId::SUN {
        DVec3::ZERO
    } else {
        ephemeris.light_time_position(NaifId::SUN, position_km, emitted_at)?.0 - position_km
    };
    if !camera_is_at_centre && placement.camera_is_inside() {
        return Err(SceneError::Inside(body.name.clone()));
    }
    let phase_angle_rad =
        if body.id == NaifId::SUN || camera_is_at_centre { 0.0 } else { crate::ephemeris::angle_rad(-astrometric_km, body_to_sun_km) };
    // Vectors from the body's centre to the camera, the Sun and the viewer, body axes.
    let to_camera_km = placement.camera_in_unit_sphere() * body.radii_km;
    let (sun_km, viewer_km) = (body_from_icrf * body_to_sun_km, to_camera_km.normalize() * distance_km);
    // Whether the user has not switched the effect off.
    let shows = |effect: Effect| request.effects.override_of_body(body, effect) != Some(false);
    let (irradiance, shown_irradiance) = if camera_is_at_centre {
        (Irradiance::default(), DVec3::ZERO)
    } else {
        let with_rings = brightness::irradiance(caches, body, phase_angle_rad, sun_km, viewer_km);
        let shown = if shows(Effect::Rings) { with_rings } else { brightness::globe_irradiance(body, phase_angle_rad, sun_km, viewer_km) };
        let shown = shown.with_shown_air(body, shows);
        let shown = if shows(Effect::RingShine) { shown } else { shown.without_ring_shine() };
        (with_rings, shown.rgb(body))
    };
    let outline = if camera_is_at_centre { Outline::Behind } else { Outline::of(camera, &placement) };
    Ok(PlacedBody {
        body,
        catalog,
        position_km,
        body_to_sun_km,
        emitted_at,
        body_from_icrf,
        placement,
        distance_km,
        phase_angle_rad,
        outline,
        irradiance,
        shown_irradiance,
        receiver_and_candidates: OnceCell::new(),
        rings_before_sun: OnceCell::new(),
        visible_fraction: OnceCell::new(),
        limb_profile: None,
    })
}
