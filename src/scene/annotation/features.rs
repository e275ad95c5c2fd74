//! Names of surface features: which of them fit into an image, and where.
//!
//! In: the bodies in an image and the rectangles of other labels. Out: [`TextLine`]s, and the positions of named landing sites. Always: names overlap neither
//! each other nor other labels. Nearer bodies have priority; on each body, landing sites, then larger features. The name of a landing site is beside it; any
//! other name is centred on its feature, so that it stays in place while the view moves. A name fades out towards the limb, and as its feature becomes
//! smaller in the image; the name of a landing site fades with the size of its body instead. Features on the far side of their body or behind a nearer body
//! have no name.

use super::text::{LabelMetrics, Rect, TextLine};
use crate::catalog::nomenclature;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::numeric::smooth_rise;
use glam::DVec2;

/// Maximum number of names in an image.
const MAX_NAMES: usize = 70;
/// Smallest diameter, in glyph sizes, of a body whose features are named.
const MIN_BODY_SIZE: f64 = 4.0;
/// Size of a feature in the image, in glyph sizes, at which its name starts to appear, and at which it is opaque: the feature's diameter, or for elongated
/// features their width ([`nomenclature::SurfaceFeature::effective_size_km`]).
const FEATURE_FADE: (f64, f64) = (0.9, 1.4);
/// Diameter of the body in the image, in glyph sizes, at which the name of a landing site starts to appear, and at which it is opaque.
const SITE_FADE: (f64, f64) = (16.0, 22.0);
/// Cosine of the emission angle at which a name starts to appear, and at which it is opaque.
const LIMB_FADE: (f64, f64) = (0.15, 0.35);
/// Opacity below which a name is left out.
const MIN_OPACITY: f64 = 0.02;
/// Largest size (as in [`FEATURE_FADE`]) of a named feature, in units of the image's shorter side: larger ones fill the view.
const MAX_FEATURE_SIZE: f64 = 1.5;
/// Distance from a landing site to the near end of its name, in glyph sizes.
const SITE_NAME_DISTANCE: f64 = 0.7;
/// Vertical distance of a name above or below its landing site, in line heights.
const SITE_NAME_SHIFT: f64 = 1.4;
/// Free space around a name, in glyph sizes: horizontal and vertical.
const NAME_MARGIN: DVec2 = DVec2::new(0.6, 0.3);
/// Lower limit of the assumed distance from the camera to a body's nearest ground, km; without it the distance could be 0 or negative.
const MIN_DISTANCE_KM: f64 = 1e-3;
/// sRGB of a feature's name.
pub(crate) const FEATURE_COLOUR: [u8; 3] = [238, 226, 196];

/// The names, and the positions of the named landing sites, pixels from the top left corner. `occupied`: rectangles that names must not overlap; this function
/// adds the rectangles of the names.
pub(crate) fn surface_feature_names(
    image: &impl ImageProjection,
    bodies: &[BodyReport],
    metrics: &LabelMetrics,
    occupied: &mut Vec<Rect>,
) -> (Vec<TextLine>, Vec<DVec2>) {
    let image_px = image.size_px();
    let glyph_px = metrics.glyph_px();
    let px_per_radian = image.px_per_radian_in_middle();
    let (mut names, mut sites) = (Vec::new(), Vec::new());
    // A camera at a body's centre sees none of its features.
    let mut nearest_first: Vec<&BodyReport> = bodies.iter().filter(|b| b.distance_km.is_finite() && b.distance_km > 0.0).collect();
    nearest_first.sort_by(|a, b| a.distance_km.total_cmp(&b.distance_km));
    for (k, body) in nearest_first.iter().enumerate() {
        let placement = &body.placement;
        let body_diameter_px = 2.0 * placement.radii_km.max_element() / body.distance_km * px_per_radian;
        if body_diameter_px < MIN_BODY_SIZE * glyph_px || placement.camera_is_inside() {
            continue;
        }
        // Positions are from the body's centre, in body axes.
        let camera_km = placement.camera_in_unit_sphere() * placement.radii_km;
        // Landing sites first, then the other features from large to small.
        for feature in nomenclature::surface_features(&body.name) {
            if names.len() >= MAX_NAMES {
                return (names, sites);
            }
            // The point where the ray from the centre meets the ellipsoid.
            let ground_km = feature.direction / (feature.direction / placement.radii_km).length();
            let normal = (ground_km / (placement.radii_km * placement.radii_km)).normalize();
            let to_camera = camera_km - ground_km;
            let distance_km = to_camera.length();
            let mut opacity = smooth_rise(LIMB_FADE, to_camera.dot(normal) / distance_km);
            let feature_px = feature.effective_size_km / distance_km * px_per_radian;
            opacity *= if feature.is_landing_site {
                smooth_rise(SITE_FADE, body_diameter_px / glyph_px)
            } else {
                smooth_rise(FEATURE_FADE, feature_px / glyph_px)
            };
            if opacity < MIN_OPACITY {
                if !feature.is_landing_site && feature_px < FEATURE_FADE.0 * glyph_px {
                    // The remaining features are no larger. If even on the nearest ground they would be too small, none of them has a name.
                    let nearest_km = (body.distance_km - placement.radii_km.max_element()).max(MIN_DISTANCE_KM);
                    if feature.effective_size_km / nearest_km * px_per_radian < FEATURE_FADE.0 * glyph_px {
                        break;
                    }
                }
                continue;
            }
            let line_of_sight = placement.body_from_icrf.transpose() * -to_camera;
            let Some(feature_at_px) = image.pixel_of(line_of_sight) else { continue };
            let is_hidden = nearest_first[..k]
                .iter()
                .any(|nearer| !nearer.placement.camera_is_inside() && nearer.placement.surface_along(line_of_sight).is_some());
            if is_hidden || feature_px > MAX_FEATURE_SIZE * image_px.min_element() {
                continue;
            }
            let width_px = metrics.width_px(feature.name);
            // Left end of the name's centre line if the name is centred on the feature.
            let centred = feature_at_px - DVec2::new(0.5 * width_px, 0.0);
            let to_side = DVec2::new(0.5 * width_px + SITE_NAME_DISTANCE * glyph_px, 0.0);
            // A landing site's name is placed on its right, or if that does not fit, on its left, below right or above right.
            let down = DVec2::new(0.0, SITE_NAME_SHIFT * metrics.line_height_px);
            let places = match feature.is_landing_site {
                true => vec![centred + to_side, centred - to_side, centred + to_side + down, centred + to_side - down],
                false => vec![centred],
            };
            // The margin may extend beyond the image.
            let fits = |(_, rect): &(DVec2, Rect)| {
                let with_margin = rect.padded(NAME_MARGIN * glyph_px);
                rect.is_in_image(image_px) && !occupied.iter().any(|t| t.overlaps(&with_margin))
            };
            let with_rect = |left_end_px| (left_end_px, metrics.rect(feature.name, left_end_px));
            let Some((left_end_px, rect)) = places.into_iter().map(with_rect).find(fits) else { continue };
            occupied.push(rect);
            sites.extend(feature.is_landing_site.then_some(feature_at_px));
            names.push(TextLine { text: feature.name.to_owned(), left_end_px, colour: FEATURE_COLOUR, opacity });
        }
    }
    (names, sites)
}
