//! A body where the viewer sees it: light time, the aberration of a moving viewer, orientation, outline and phase.
//!
//! In: a body of the catalog, the ephemeris and the viewer. Out: [`PlacedBody`], which every decision about the body reads.

use crate::catalog::{Body, Catalog, NaifId, Photometry};
use crate::ephemeris::Ephemeris;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::limb_profile::LimbProfile;
use crate::scene::camera::Placement;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::viewpoint;
use crate::scene::eclipse::occluders::{Occluder, Receiver};
use crate::scene::error::SceneError;
use crate::scene::light::{brightness, photometry};
use crate::scene::request::view_request::ViewRequest;
use crate::scene::resources::Caches;
use crate::time::Instant;
use glam::{DMat3, DVec3};
use std::cell::OnceCell;
use std::sync::Arc;

/// A body where the viewer sees it, before anything is decided.
pub(crate) struct PlacedBody<'a> {
    pub body: &'a Body,
    /// Who else there is.
    pub catalog: &'a Catalog,
    /// Barycentric, when the light left.
    pub position_km: DVec3,
    pub sun_from_body_km: DVec3,
    pub seen_at: Instant,
    /// When the light left; directions to lights are turned by this one, the view by the placement's.
    pub body_from_icrf: DMat3,
    pub placement: Placement,
    pub distance_km: f64,
    pub alpha: f64,
    pub outline: Outline,
    /// At the viewer, in units of the Sun's at 1 au: globe and rings, as if no eclipse were.
    pub irradiance: f64,
    /// Itself as a receiver of sunlight, and who may stand before its Sun: asked for by the exposure, the globe, its rings and its point.
    pub before_sun: OnceCell<(Receiver<'a>, Vec<Occluder<'a>>)>,
    /// Of the Moon before the Sun, where the user gave its heights.
    pub limb_profile: Option<Arc<LimbProfile>>,
}

impl PlacedBody<'_> {
    /// Brightness of the disc at this phase over that of its model; of the Sun its radiance.
    pub fn phase_brightness(&self) -> f64 {
        match self.body.photometry {
            Photometry::Emissive { .. } => photometry::sun_disc_radiance(),
            _ => photometry::phase_correction(self.body, self.alpha, self.distance_km / self.body.radii_km.x),
        }
    }

    /// The factor that makes the photometric model's albedo the catalog's, times [`Self::phase_brightness`].
    pub fn tone(&self) -> DVec3 {
        photometry::normalisation(self.body) * self.phase_brightness()
    }
}

/// Puts a body where the viewer sees it: light time, and aberration for a viewer who moves.
pub(crate) fn place<'a>(
    catalog: &'a Catalog,
    body: &'a Body,
    ephemeris: &Ephemeris,
    viewer: &viewpoint::Viewer,
    request: &ViewRequest,
    caches: &Caches,
) -> Result<PlacedBody<'a>, SceneError> {
    let camera = &viewer.camera;
    let stood_on = viewer.stands_on.filter(|(id, _)| *id == body.id);
    let (position_km, seen_at) = match stood_on {
        _ if viewer.inside == Some(body.id) => (camera.position_km, request.time),
        Some((_, position_km)) => (position_km, request.time),
        None => ephemeris.light_time_position(body.id, camera.position_km, request.time)?,
    };
    let resting_km = position_km - camera.position_km;
    let distance_km = resting_km.length();
    let body_from_icrf = ephemeris.body_from_icrf(body.id, seen_at)?;
    let mut placement = Placement { centre_km: resting_km, body_from_icrf, radii_km: body.radii_km };
    if viewer.velocity_km_s != DVec3::ZERO && distance_km > 0.0 && stood_on.is_none() {
        let direction = resting_km / distance_km;
        let apparent = aberrated(direction, viewer.velocity_km_s);
        // The whole body turns with its apparent place: the viewer sees the face that the light left, moved on the sky.
        let apparent_from_resting = viewpoint::rotation_between(direction, apparent);
        placement.centre_km = apparent * distance_km;
        placement.body_from_icrf = body_from_icrf * apparent_from_resting.transpose();
    }
    let sun_from_body_km = if body.id == NaifId::SUN {
        DVec3::ZERO
    } else {
        ephemeris.light_time_position(NaifId::SUN, position_km, seen_at)?.0 - position_km
    };
    let inside = viewer.inside == Some(body.id);
    if !inside && placement.camera_is_inside() {
        return Err(SceneError::Inside(body.name.clone()));
    }
    let alpha = if body.id == NaifId::SUN || inside { 0.0 } else { crate::ephemeris::angle_rad(-resting_km, sun_from_body_km) };
    let n = placement.camera_in_unit_sphere() * body.radii_km;
    let irradiance = if inside {
        0.0
    } else {
        brightness::irradiance(&caches.ring_tables, body, alpha, body_from_icrf * sun_from_body_km, n.normalize() * distance_km)
    };
    let outline = if inside { Outline::Behind } else { Outline::of(camera, &placement) };
    Ok(PlacedBody {
        body,
        catalog,
        position_km,
        sun_from_body_km,
        seen_at,
        body_from_icrf,
        placement,
        distance_km,
        alpha,
        outline,
        irradiance,
        before_sun: OnceCell::new(),
        limb_profile: None,
    })
}
