//! The stars of a frame: which stars are visible at the exposure, with their positions and brightness.
//!
//! In: the star catalog, the viewer, the threshold, the radiance displayed as white, the air around the camera. Out: [`StarSprite`]s for
//! shaders/entry/point.wesl, and the decision about them. Stars are drawn first, behind all bodies: later draws cover, dim or outshine them. Always: a star
//! too faint for the display has no sprite. A cell of the star catalog (a patch of the sky) that is outside the frame, or whose brightest star is too faint, is
//! skipped as a whole. A star is as bright as a body of the same magnitude. Left out: refraction and scintillation. A double star that the catalog does not
//! resolve is drawn as one star.

use super::star_colour::star_colour;
use crate::catalog::Catalog;
use crate::catalog::stars::{SkyCell, Star, StarCatalog};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::star_place::star_from_viewer;
use crate::message::{Reason, reason};
use crate::scene::atmosphere::tint_table::{FrameTints, TintTable};
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::{PixelView, StarSprite};
use crate::scene::light::photometry::{irradiance_of_magnitude, magnitude};
use crate::scene::point::{pixel_sr, point_peak, point_radius_px};
use crate::scene::purpose::Threshold;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The apparent direction of a star, and its brightness relative to that in the star catalog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ApparentStar {
    /// Unit vector, ICRF, with proper motion, parallax and aberration.
    pub direction: DVec3,
    /// Factor on the irradiance that follows from the magnitude in the star catalog.
    pub brightness_ratio: f64,
}

impl ApparentStar {
    fn boosted(self, factor: f64) -> Self {
        Self { brightness_ratio: self.brightness_ratio * factor, ..self }
    }
}

/// Computes the apparent places of the stars of one frame.
pub struct StarPlacer {
    /// Julian years since the epoch of the star catalog, for proper motion.
    years_since_epoch: f64,
    /// Barycentric position of the viewer, ICRF.
    viewer_au: DVec3,
    /// For aberration: [`Viewer::sky_aberration_velocity_km_s`].
    velocity_km_s: DVec3,
}

impl StarPlacer {
    /// For the stars of the catalog, a viewer, and the time of a request.
    pub fn of(catalog: &Catalog, viewer: &Viewer, request: &ViewRequest) -> Self {
        Self::of_stars(&catalog.stars(), viewer, request)
    }

    /// Like [`Self::of`], for the stars of a given star catalog.
    pub(crate) fn of_stars(stars: &StarCatalog, viewer: &Viewer, request: &ViewRequest) -> Self {
        Self {
            years_since_epoch: stars.years_since_epoch(request.time.jd_tt()),
            viewer_au: viewer.camera.position_km / KM_PER_AU,
            velocity_km_s: viewer.sky_aberration_velocity_km_s,
        }
    }

    /// The apparent place of a star.
    pub fn place(&self, star: &Star) -> ApparentStar {
        let vector = star_from_viewer(star, self.years_since_epoch, self.viewer_au);
        // In units of the star's distance at the epoch. The lower limit avoids a division by zero for a viewer at the star.
        let distance_ratio = vector.length().max(1e-9);
        ApparentStar { direction: aberrated(vector / distance_ratio, self.velocity_km_s), brightness_ratio: distance_ratio.powi(-2) }
    }

    /// Upper limit of the displacement of a cell's stars, by their motion since the epoch and by parallax, as a fraction of their distance.
    fn shift(&self, cell: &SkyCell) -> f64 {
        cell.max_motion_per_year * self.years_since_epoch.abs() + cell.max_parallax_rad * self.viewer_au.length()
    }
}

/// The faintest magnitude that is visible anywhere in the frame: the limit in the corners, where a pixel has the smallest solid angle. Infinite for linear
/// light.
fn limiting_magnitude(camera: &Camera, threshold: Threshold) -> f64 {
    limiting_magnitude_of_pixel(camera.pixel_tangent().powi(2) * camera.corner_rad().cos().powi(3), threshold)
}

/// The faintest magnitude of a point that is visible in the middle of an image. Infinite for linear light.
pub(crate) fn limiting_magnitude_in_middle(image: &dyn ImageProjection, threshold: Threshold) -> f64 {
    limiting_magnitude_of_pixel(image.px_per_radian_in_middle().powi(-2), threshold)
}

/// The same for a pixel of this solid angle.
fn limiting_magnitude_of_pixel(pixel_sr: f64, threshold: Threshold) -> f64 {
    let min_peak = threshold.cutoff_radiance(VISIBLE_LIGHT);
    // The flux of a point is its irradiance * PI / `pixel_sr`, and its central pixel has `point_peak()` of the flux.
    if min_peak > 0.0 { magnitude(min_peak / point_peak() * pixel_sr / PI) } else { f64::INFINITY }
}

/// The faintest magnitude that the layer of bright stars makes visible: a star of this magnitude, brightened by the same factor as all stars, adds
/// [`VISIBLE_LIGHT`], half a level of 255. With this factor a star of magnitude 0 is white, one of magnitude 2 has 0.15 of white in linear light, and one of
/// magnitude 6 is at level 12.
const BRIGHT_STARS_LIMIT: f64 = 9.5;

/// The stars of a frame and the decision about them; no decision in pixel views other than the final image. `white`: the radiance displayed as white.
/// `tints`: of the air around the camera.
pub(crate) fn stars(
    request: &ViewRequest,
    catalog: &Catalog,
    viewer: &Viewer,
    threshold: Threshold,
    white: f64,
    tints: &FrameTints<'_>,
) -> (Vec<StarSprite>, Option<Decision>) {
    let decided = |on: bool, reason: Reason| Some(Decision { effect: "stars", on, reason, stated_error: None });
    if request.pixel_view != PixelView::Final {
        return (Vec::new(), None);
    }
    if !request.layers.stars {
        return (Vec::new(), decided(false, reason!("set-by-you")));
    }
    let camera = &viewer.camera;
    // A boost of one stop shows stars that are 2.5 log10(2) magnitudes fainter.
    let boost = request.stars_boost_stops.exp2();
    // With the boost, but without the layer of bright stars.
    let limit_without_layer = limiting_magnitude(camera, threshold) + 2.5 * boost.log10();
    // In air the layer of bright stars has no effect: by day, brightened stars would be visible against the bright sky.
    let layer_brightening_mag =
        if request.layers.bright_stars && tints.air.is_none() { (BRIGHT_STARS_LIMIT - limit_without_layer).max(0.0) } else { 0.0 };
    let limit = limit_without_layer + layer_brightening_mag;
    // Factor on the brightness of all stars.
    let total_boost = boost * 10f64.powf(0.4 * layer_brightening_mag);
    let limit_note = match limit.is_finite() {
        false => reason!("stars-linear"),
        true if layer_brightening_mag > 0.0 => {
            reason!(
                "stars-brightened",
                stops = format_args!("{:+.1}", total_boost.log2()),
                alone = format_args!("{limit_without_layer:.1}")
            )
        }
        // Without brightening or boost.
        true if total_boost == 1.0 => reason!("stars-to-magnitude", limit = format_args!("{limit:.1}")),
        true => {
            reason!("stars-lifted", limit = format_args!("{limit:.1}"), stops = format_args!("{:+.1}", request.stars_boost_stops))
        }
    };
    // Near the Sun no star is noticeably brighter than in the star catalog, so if the catalog's brightest star is too faint, all are. Farther away each cell is
    // tested, with the parallaxes of its stars.
    let is_near_sun = viewer.camera.position_km.length() < CATALOG_BRIGHTNESS_KM;
    if is_near_sun && f64::from(catalog.brightest_magnitude()) > limit {
        return (Vec::new(), decided(false, limit_note));
    }
    let placer = StarPlacer::of(catalog, viewer, request);
    let tints = tints.table();
    let all_stars = catalog.stars();
    let culling = CullingFrame {
        camera,
        limit,
        max_off_axis_rad: camera.corner_rad() + viewer.sky_aberration_velocity_km_s.length() / SPEED_OF_LIGHT_KM_S,
    };
    let mut sprites = Vec::new();
    for cell in all_stars.cells().iter().filter(|cell| culling.may_show_star_of(cell, placer.shift(cell))) {
        let faintest = culling.faintest(placer.shift(cell));
        // A cell's stars are in order of brightness, the brightest first.
        let bright = cell.stars.clone().map(|k| (k, &all_stars.stars()[k])).take_while(|(_, star)| f64::from(star.v_magnitude) <= faintest);
        let to_sprite = |(k, star): (usize, &Star)| {
            let sprite = sprite(camera, star, &placer.place(star).boosted(total_boost), tints, white)?;
            Some(StarSprite { star: Some(k), ..sprite })
        };
        sprites.extend(bright.filter_map(to_sprite));
    }
    let mut reason = reason!("stars-in-frame", count = sprites.len()).and(limit_note);
    let faintest = f64::from(all_stars.faintest_magnitude());
    if limit.is_finite() && limit > faintest {
        reason = reason.and(reason!("stars-catalog-ends", faintest = format_args!("{faintest:.1}")));
    }
    let on = !sprites.is_empty();
    (sprites, decided(on, reason))
}

/// Distance from the Sun within which no star is noticeably brighter than from the Earth: at 1000 au the nearest star is brighter by 0.008 magnitudes.
const CATALOG_BRIGHTNESS_KM: f64 = 1000.0 * KM_PER_AU;

/// The frame against which cells are culled.
struct CullingFrame<'c> {
    camera: &'c Camera,
    /// Limiting magnitude.
    limit: f64,
    /// Angle from the middle of the frame to its corner, plus the largest angle of aberration.
    max_off_axis_rad: f64,
}

impl CullingFrame<'_> {
    /// The faintest magnitude in the star catalog that may be visible, for stars that may have come closer by the fraction `shift` of their distance and
    /// so be brighter by -5 log10(1 - `shift`) magnitudes.
    fn faintest(&self, shift: f64) -> f64 {
        if shift < 1.0 { self.limit - 5.0 * (1.0 - shift).log10() } else { f64::INFINITY }
    }

    /// Whether any star of the cell may be in the frame and bright enough.
    fn may_show_star_of(&self, cell: &SkyCell, shift: f64) -> bool {
        // A displacement by a fraction of the distance changes the direction by at most the arc sine of the fraction.
        let shift_rad = if shift < 1.0 { shift.asin() } else { PI };
        let reach_rad = self.max_off_axis_rad + cell.radius_rad + shift_rad + self.sprite_rad();
        let cos_off_axis = cell.axis.dot(self.camera.forward);
        (reach_rad >= PI || cos_off_axis >= reach_rad.cos()) && f64::from(cell.brightest_magnitude) <= self.faintest(shift)
    }

    /// Largest angular radius of a sprite: the glare of a star outside the frame can reach into it.
    fn sprite_rad(&self) -> f64 {
        (crate::scene::point::MAX_RADIUS_PX * self.camera.pixel_tangent()).min(FRAC_PI_2)
    }
}

/// The sprite of a star, if it is in the frame. `white`: the radiance displayed as white. The caller sets the star's index.
fn sprite(camera: &Camera, star: &Star, place: &ApparentStar, tints: Option<&TintTable>, white: f64) -> Option<StarSprite> {
    let clip = camera.clip(place.direction)?;
    // As `point::flux_of_irradiance`.
    let flux = irradiance_of_magnitude(f64::from(star.v_magnitude)) * place.brightness_ratio * PI / pixel_sr(camera, place.direction);
    let radius_px = point_radius_px(flux * point_peak() / white);
    let max_clip = DVec2::ONE + (radius_px + 1.0) / camera.half_size_px();
    (clip.abs().cmple(max_clip).all()).then(|| {
        let colour = star_colour(star.b_v) * tints.map_or(DVec3::ONE, |t| t.at(place.direction));
        StarSprite {
            centre: narrow(clip.extend(0.0)),
            radius_px: narrow_scalar(radius_px),
            stretch: 1.0,
            flux: narrow(colour * flux),
            star: None,
        }
    })
}
