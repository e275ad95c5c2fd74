//! All bodies as seen from one place: distance, magnitude, phase, sub-points, without an image.
//!
//! In: the catalog, the ephemeris, the viewer's position and a time. Out: one [`BodyReport`] per body of the catalog, or that of one body. They are the reports
//! of the scene of a tiny image, so that light time, aberration, light of rings, light curves and eclipses are those of images.

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::Ephemeris;
use crate::scene::body_report::BodyReport;
use crate::scene::build::SceneBuilder;
use crate::scene::error::SceneError;
use crate::scene::finished::Scene;
use crate::scene::request::effects::{Effect, EffectOverrides};
use crate::scene::request::layers::Layers;
use crate::scene::request::view_request::{Axes, ExposureRequest, Look, Position, Up, ViewRequest};
use crate::scene::resources::{Caches, Resources};
use crate::time::Instant;
use glam::DVec3;

/// Width and height of the image: so small that bodies in it need few decisions.
const IMAGE_PX: u32 = 16;

/// Every body of the catalog, in catalog order, as a viewer at `position` sees it at `time`. `position` must not be [`Position::AboveTarget`], which needs a
/// target. Distances and directions have light time, magnitudes include rings, light curves and eclipses.
///
/// If the viewer is at a body's centre, this body has the distance 0 and no magnitude, and its phase angle, sub-observer point and angular diameter mean
/// nothing. A body that the ephemeris cannot place has the distance NaN and no magnitude ([`BodyReport::has_direction`]).
/// Any other body without a magnitude is one that no sunlight reaches, or the Sun entirely behind another body. The fields about an image are of no use:
/// `appearance`, `diameter_px`, `decisions`, `features` and `invented`.
///
/// # Errors
/// A position that is invalid, inside a body, or not covered by the ephemeris at this time.
pub fn bodies_seen_from(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    position: Position,
    time: Instant,
) -> Result<Vec<BodyReport>, SceneError> {
    let request = request(position, time);
    Ok(Scene::build(catalog, ephemeris, &request)?.bodies)
}

/// One body of the catalog as in [`bodies_seen_from`], and the part of its light that comes from its globe, without rings and ring-shine; `None` for a body
/// that the ephemeris cannot place. It decides on no effect, and `caches` keeps tables from call to call, so that it is faster.
///
/// # Errors
/// As [`bodies_seen_from`].
pub(crate) fn body_seen_from(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    caches: &Caches,
    position: Position,
    time: Instant,
    id: NaifId,
) -> Result<Option<(BodyReport, f64)>, SceneError> {
    let request = request(position, time);
    Ok(SceneBuilder::new(catalog, ephemeris, &request, caches)?.values_of_body(id, &Resources::default()))
}

/// The view whose reports are used.
fn request(position: Position, time: Instant) -> ViewRequest {
    let mut effects = EffectOverrides::default();
    // Magnitudes have ring-shine at large phase angles whatever this effect; for images it would need a new table for each date.
    effects.set(Effect::RingShine, false);
    ViewRequest {
        target: None,
        position,
        // Any direction, because bodies outside the image are reported, too.
        look: Look::Along { direction: DVec3::X, axes: Axes::Icrf },
        up: Up::Celestial,
        width: IMAGE_PX,
        height: IMAGE_PX,
        exposure: ExposureRequest::Stops(0.0),
        effects,
        layers: Layers::NONE,
        ..ViewRequest::of(NaifId::SUN, time)
    }
}
