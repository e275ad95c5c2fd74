//! Proper names of stars beside their sprites.
//!
//! In: the stars of a frame. Out: texts, brightest stars first, each at the right of its star; `line_texts` decides which of them fit. Only stars that the
//! exposure shows and that no body hides have a name.

use crate::catalog::stars::{Star, star_name};
use crate::message::reason;
use crate::scene::annotation::labels::LabelMetrics;
use crate::scene::annotation::line_texts::UnplacedText;
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::draw::StarSprite;
use glam::{DVec2, DVec3};

/// Linear RGB of a star's name.
const COLOUR: DVec3 = DVec3::new(0.7, 0.75, 0.85);

/// Names of the stars of a frame, and a decision that reports their number. `glyph_px`: size of glyphs. `is_hidden`: whether a body covers a pixel.
pub(crate) fn star_names(
    camera: &Camera,
    sprites: &[StarSprite],
    stars: &[Star],
    glyph_px: f64,
    is_hidden: impl Fn(DVec2) -> bool,
) -> (Vec<UnplacedText>, Decision) {
    let metrics = LabelMetrics::of_size(glyph_px);
    let named = sprites.iter().filter_map(|sprite| {
        let star = stars.get(sprite.star?)?;
        let name = star_name(star.hip)?;
        let star_px = camera.pixel_from_clip(sprite.centre.truncate().as_dvec2());
        (!is_hidden(star_px)).then_some((star.v_magnitude, name, star_px))
    });
    let mut named: Vec<_> = named.collect();
    named.sort_by(|(magnitude, ..), (other, ..)| magnitude.total_cmp(other));
    let reason = reason!("star-names-have", count = named.len());
    let decision = Decision { effect: "star-names", on: !named.is_empty(), reason, stated_error: None };
    let star_radius_px = 0.0;
    let text = |(_, name, star_px): (f32, &str, DVec2)| {
        let centre_px = star_px + DVec2::new(0.5 * metrics.width_px(name) + metrics.gap_px(star_radius_px), 0.0);
        UnplacedText { text: name.to_owned(), centre_px, colour: COLOUR, is_grid_coordinate: false }
    };
    (named.into_iter().map(text).collect(), decision)
}
