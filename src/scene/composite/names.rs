//! Names of comets, stars and constellations in dome images and whole-sphere images.
//!
//! In: the scene of the entire image, with its stars and the labels of bodies; the requested layers. Out: the names that fit. Not here: the coordinates of
//! grids and the names of instruments. Their places are computed for one perspective frame, at whose edges coordinates stand, and such images have none.

use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::annotation::labels::glyph_size_px;
use crate::scene::annotation::line_texts::{TextLayer, place_texts};
use crate::scene::annotation::{data, picking, sky_lines, small_body_names, star_names};
use crate::scene::draw::PixelView;
use crate::scene::finished::Scene;
use crate::scene::request::view_request::ViewRequest;
use glam::DVec2;

/// The names; `None` without any. `whole`: the scene of the entire image, with its stars, bodies and labels.
pub(super) fn texts(request: &ViewRequest, catalog: &Catalog, ephemeris: &Ephemeris, whole: &Scene) -> Option<TextLayer> {
    if request.pixel_view != PixelView::Final {
        return None;
    }
    let (camera, glyph_px) = (&whole.camera, glyph_size_px(whole.camera.height));
    let star_distance_km = f64::INFINITY;
    // Outside a fisheye's circle there is nothing to name.
    let is_hidden = |px: DVec2| {
        let direction = whole.geometry.direction(camera, px);
        direction.is_none_or(|direction| data::is_hidden(&whole.bodies, direction, star_distance_km))
    };
    let mut names = Vec::new();
    if request.layers.comets && request.layers.labels {
        let sight = picking::sight_of(whole, ephemeris);
        let image = whole.geometry.projection(camera);
        let all = catalog.small_bodies();
        let (limiting_magnitude, chosen) = (whole.limiting_magnitude(), None);
        names.extend(small_body_names::small_body_names(&*image, &sight, &whole.bodies, &all.comets, limiting_magnitude, chosen, glyph_px));
    }
    if request.layers.star_names {
        let (of_stars, _decision) = star_names::star_names(camera, &whole.stars, catalog.stars().stars(), glyph_px, is_hidden);
        names.extend(of_stars);
    }
    if request.layers.constellations {
        let all = sky_lines::constellation_names(&*whole.geometry.projection(camera));
        names.extend(all.into_iter().filter(|name| !is_hidden(name.centre_px)));
    }
    (!names.is_empty()).then(|| place_texts(names, whole.labels.as_ref(), glyph_px, 2.0 * camera.half_size_px()))
}
