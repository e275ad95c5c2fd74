//! The stars of a frame: which of them the exposure shows, where, and how bright.
//!
//! In: the catalogue's stars, the viewer, the threshold and the white level, the air around the camera. Out: [`StarSprite`]s for shaders/entry/point.wesl,
//! and the reason. Stars are behind all bodies: what is drawn later covers, dims or outshines them. Always: a star too faint for a level of the display has
//! no sprite; a sky cell outside the frame, or whose brightest star is too faint, costs one comparison. A star's flux is that of a body of the same
//! magnitude. Left out: refraction, and scintillation. Double stars that the catalogue does not resolve are one.

use super::star_colour::star_colour;
use crate::catalog::Catalog;
use crate::catalog::stars::{Cell, Star, StarCatalog};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::star_place::star_from_viewer;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::{PixelView, StarSprite};
use crate::scene::light::photometry::{irradiance_of_magnitude, magnitude};
use crate::scene::point::{point_peak, point_radius_px};
use crate::scene::purpose::Threshold;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The apparent direction of a star, and its brightness relative to the catalogue's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarPlace {
    /// Unit vector, ICRF, with proper motion, parallax and aberration.
    pub direction: DVec3,
    pub brightening: f64,
}

impl StarPlace {
    fn boosted(self, factor: f64) -> Self {
        Self { brightening: self.brightening * factor, ..self }
    }
}

/// Computes the apparent places of the stars of one frame.
pub struct StarPlacer {
    years: f64,
    viewer_au: DVec3,
    velocity_km_s: DVec3,
}

impl StarPlacer {
    pub fn of(catalog: &Catalog, viewer: &Viewer, request: &ViewRequest) -> Self {
        Self::of_stars(&catalog.stars(), viewer, request)
    }

    /// For the stars of a given catalogue.
    pub(crate) fn of_stars(stars: &StarCatalog, viewer: &Viewer, request: &ViewRequest) -> Self {
        Self {
            years: stars.years_since_epoch(request.time.jd_tt()),
            viewer_au: viewer.camera.position_km / KM_PER_AU,
            velocity_km_s: viewer.body_velocity_km_s,
        }
    }

    pub fn place(&self, star: &Star) -> StarPlace {
        let vector = star_from_viewer(star, self.years, self.viewer_au);
        // Avoids a division by zero for a viewer at the star.
        let distance = vector.length().max(1e-9);
        StarPlace { direction: aberrated(vector / distance, self.velocity_km_s), brightening: distance.powi(-2) }
    }

    /// Upper limit of the shift of a cell's stars since the epoch, relative to their distance, as seen by the viewer.
    fn shift(&self, cell: &Cell) -> f64 {
        cell.motion_per_year * self.years.abs() + cell.parallax_rad * self.viewer_au.length()
    }
}

/// Tint of light from beyond by the camera's air, by altitude: transmittance per channel over its mean. The draw of the air applies the mean.
struct AirTint {
    up: DVec3,
    tints: Vec<DVec3>,
}

/// Rows of the table, from [`AirTint::LOWEST_DEG`] upwards, denser near the horizon.
const TINTS: usize = 48;

impl AirTint {
    const LOWEST_DEG: f64 = -3.0;

    fn of(air: &SurroundingAir<'_>) -> Self {
        let up = air.up();
        let level = up.any_orthonormal_vector();
        let tint = |k: usize| {
            let altitude = (Self::LOWEST_DEG + (90.0 - Self::LOWEST_DEG) * (k as f64 / TINTS as f64).powi(2)).to_radians();
            air.tint(up * altitude.sin() + level * altitude.cos())
        };
        Self { up, tints: (0..=TINTS).map(tint).collect() }
    }

    fn at(&self, direction: DVec3) -> DVec3 {
        let altitude_deg = direction.dot(self.up).clamp(-1.0, 1.0).asin().to_degrees();
        let place = ((altitude_deg - Self::LOWEST_DEG) / (90.0 - Self::LOWEST_DEG)).clamp(0.0, 1.0).sqrt() * TINTS as f64;
        let below = (place as usize).min(TINTS - 1);
        self.tints[below].lerp(self.tints[below + 1], place - below as f64)
    }
}

/// Angle from the middle of the frame to its corner.
fn corner_rad(camera: &Camera) -> f64 {
    camera.tan_half_fov.length().atan()
}

/// The faintest magnitude that is visible somewhere in the frame: in the corners, where a pixel has the smallest solid angle.
fn limiting_magnitude(camera: &Camera, threshold: Threshold) -> f64 {
    let pixel_sr = camera.pixel_tangent().powi(2) * corner_rad(camera).cos().powi(3);
    let least_peak = threshold.cutoff_radiance(VISIBLE_LIGHT);
    if least_peak > 0.0 { magnitude(least_peak / point_peak() * pixel_sr / PI) } else { f64::INFINITY }
}

/// The stars of a frame and the decision about them; `None` in pixel views other than the final image.
pub(crate) fn stars(
    request: &ViewRequest,
    catalog: &Catalog,
    viewer: &Viewer,
    threshold: Threshold,
    white: f64,
    air: Option<&SurroundingAir<'_>>,
) -> (Vec<StarSprite>, Option<Decision>) {
    let decided = |on: bool, reason: String| Some(Decision { feature: "stars", on, reason, tier: None });
    if request.pixel_view != PixelView::Final {
        return (Vec::new(), None);
    }
    if !request.layers.stars {
        return (Vec::new(), decided(false, "set by you".into()));
    }
    let camera = &viewer.camera;
    // One stop is 2.5 log10(2) magnitudes.
    let boost = request.stars_boost.exp2();
    let limit = limiting_magnitude(camera, threshold) + 2.5 * boost.log10();
    let lifted = if boost == 1.0 { String::new() } else { format!(", {:+.1} stops brighter than they are", request.stars_boost) };
    let shows = if limit.is_finite() {
        format!("the exposure shows stars to magnitude {limit:.1}{lifted}")
    } else {
        "linear light shows any star".into()
    };
    // Within the solar system parallax makes no star brighter; farther out the cells account for it.
    let near = viewer.camera.position_km.length() < NEAR_KM;
    if near && f64::from(catalog.brightest_magnitude()) > limit {
        return (Vec::new(), decided(false, shows));
    }
    let placer = StarPlacer::of(catalog, viewer, request);
    let tint = air.map(AirTint::of);
    let all = catalog.stars();
    let in_view = InView { camera, limit, reach_rad: corner_rad(camera) + viewer.body_velocity_km_s.length() / SPEED_OF_LIGHT_KM_S };
    let mut sprites = Vec::new();
    for cell in all.cells().iter().filter(|cell| in_view.may_hold(cell, placer.shift(cell))) {
        let faintest = in_view.faintest(placer.shift(cell));
        let bright = cell.stars.clone().map(|k| (k, &all.stars()[k])).take_while(|(_, star)| f64::from(star.v_magnitude) <= faintest);
        let of = |(k, star): (usize, &Star)| {
            let sprite = sprite(camera, star, &placer.place(star).boosted(boost), tint.as_ref(), white)?;
            Some(StarSprite { star: Some(k), ..sprite })
        };
        sprites.extend(bright.filter_map(of));
    }
    let reason = format!("{} in the frame; {shows}", sprites.len());
    let on = !sprites.is_empty();
    (sprites, decided(on, reason))
}

/// Distance from the Sun (1000 au) within which no star is brighter than from the Earth by a thousandth of a magnitude.
const NEAR_KM: f64 = 1000.0 * KM_PER_AU;

/// The frame against which cells are culled.
struct InView<'c> {
    camera: &'c Camera,
    limit: f64,
    /// Angle from the middle of the frame to its corner, plus that of aberration.
    reach_rad: f64,
}

impl InView<'_> {
    /// The faintest catalogue magnitude that may be visible, for stars that may have come nearer by `shift` of their distance.
    fn faintest(&self, shift: f64) -> f64 {
        if shift < 1.0 { self.limit - 5.0 * (1.0 - shift).log10() } else { f64::INFINITY }
    }

    /// Whether a star of the cell may be in the frame and bright enough.
    fn may_hold(&self, cell: &Cell, shift: f64) -> bool {
        // A position that shifts by a fraction of its distance changes direction by the arc sine of it.
        let turn = if shift < 1.0 { shift.asin() } else { PI };
        let reach = self.reach_rad + cell.radius_rad + turn + self.sprite_rad();
        let ahead = cell.axis.dot(self.camera.forward);
        (reach >= PI || ahead >= reach.cos()) && f64::from(cell.brightest_magnitude) <= self.faintest(shift)
    }

    /// Angular reach of the glare of a star outside the frame.
    fn sprite_rad(&self) -> f64 {
        (crate::scene::point::MAX_RADIUS_PX * self.camera.pixel_tangent()).min(FRAC_PI_2)
    }
}

/// The sprite of a star, if it is in the frame; its index is set by the caller.
fn sprite(camera: &Camera, star: &Star, place: &StarPlace, tint: Option<&AirTint>, white: f64) -> Option<StarSprite> {
    let clip = camera.clip(place.direction)?;
    let cos_off_axis = place.direction.dot(camera.forward);
    let pixel_sr = camera.pixel_tangent().powi(2) * cos_off_axis.max(1e-3).powi(3);
    let flux = irradiance_of_magnitude(f64::from(star.v_magnitude)) * place.brightening * PI / pixel_sr;
    let colour = star_colour(star.b_v) * tint.map_or(DVec3::ONE, |t| t.at(place.direction));
    let radius_px = point_radius_px(flux * point_peak() / white);
    let reach = DVec2::ONE + (radius_px + 1.0) / camera.half_size();
    (clip.abs().cmple(reach).all()).then(|| StarSprite {
        centre: narrow(clip.extend(0.0)),
        radius_px: narrow_scalar(radius_px),
        flux: narrow(colour * flux),
        star: None,
    })
}
