//! The draws of annotations over the display image: names and markers of bodies, labels of lines, caption, scale bar and compass in the margins, and data
//! points.
//!
//! In: a scene's labels and texts, and the provider's glyph atlas. Out: draws for the display target. Always: glyphs are placed on whole pixels; what crosses
//! the left or right edge of an equirectangular image is repeated at the other edge. Not here: label placement (`scene::annotation`).

use super::error::PlanError;
use super::passes::{Blend, PlanDraw, TextureBinding, TextureSource};
use super::provider::ResourceProvider;
use super::simple_draws::{FIRST_READ_BINDING, colour, instanced_rectangles, simple_draw};
use crate::image::{Glyph, GlyphAtlas};
use crate::scene::Scene;
use crate::scene::annotation::line_texts::{PlacedText, TextLayer};
use crate::scene::labels::{
    Bar, Dot, LabelLayer, LabelMetrics, MARKER_OPACITY, MARKER_RADIUS, NAME_COLOUR, Rect, SELECTED_COLOUR, TextLine,
};
use std::sync::Arc;

/// Opacity of the names of bodies, and of the ring around the selected one.
const OPAQUE: f32 = 1.0;
/// Opacity of the label of a line, such as a grid line or a constellation's.
const LINE_LABEL_OPACITY: f32 = 0.85;
/// Opacity of the shadows that keep texts and bars readable on a bright background.
const SHADOW_OPACITY: f32 = 0.7;

/// Opacity of the halos around the names of bodies and of surface features, the texts of the margin, and the rings of landing sites.
const HALO_OPACITY: f32 = 0.85;
/// Opacity of a name from which its halo is no longer fainter: a halo as faint as its name would not keep the name readable.
const FULL_HALO_OPACITY: f32 = 0.5;

/// Opacity of the halo of a name or ring of this opacity.
fn halo_opacity(opacity: f32) -> f32 {
    HALO_OPACITY * (opacity / FULL_HALO_OPACITY).min(1.0)
}

/// Offset of a shadow from its text, to the right and down: one pixel per 13 pixels of text size, in whole pixels, at least one.
fn shadow_offset_px(glyph_px: f64) -> f64 {
    (glyph_px / 13.0).round().max(1.0)
}

/// A rectangle of the glyph atlas drawn into the image: a character, the ring of a marker, or a part of a bar.
struct GlyphQuad {
    /// Top-left corner in the image.
    corner_px: [f32; 2],
    /// A glyph's cell in the atlas, or a part of it: x, y, width, height in texels.
    cell: [f32; 4],
    /// sRGB-encoded, 0 to 1, and opacity.
    colour: [f32; 4],
}

/// A glyph at a pen position in the image. The position is rounded to whole pixels, so that each texel of the atlas covers exactly one pixel.
fn glyph_quad(glyph: &Glyph, pen: [f64; 2], [r, g, b]: [f32; 3], opacity: f32) -> GlyphQuad {
    let corner_px = std::array::from_fn(|k| (pen[k].round() + f64::from(glyph.bearing[k])) as f32);
    let [x, y, w, h] = [glyph.top_left[0], glyph.top_left[1], glyph.size[0], glyph.size[1]].map(|v| v as f32);
    GlyphQuad { corner_px, cell: [x, y, w, h], colour: [r, g, b, opacity] }
}

/// The ring around a point of the image. The ring glyph surrounds the middle of the pixel whose top-left corner is the pen position, hence `- 0.5`.
fn ring_quad(glyphs: &GlyphAtlas, [x, y]: [f64; 2], colour: [f32; 3], opacity: f32) -> GlyphQuad {
    glyph_quad(&glyphs.ring, [x - 0.5, y - 0.5], colour, opacity)
}

/// Markers and names of bodies, each name over its own halo, because it may be in front of a disc. `layer.labels` begins with the most important body; its
/// label is drawn last, over the others.
fn body_labels(layer: &LabelLayer, glyphs: &GlyphAtlas) -> Vec<GlyphQuad> {
    let metrics = LabelMetrics::of_size(layer.glyph_px);
    let mut quads = Vec::new();
    for label in layer.labels.iter().rev() {
        let is_selected = label.body == layer.selected;
        let text_colour = colour(if is_selected { SELECTED_COLOUR } else { NAME_COLOUR }).to_array();
        let centre = label.centre_px.to_array();
        // A disc larger than the marker needs none.
        if label.radius_px < MARKER_RADIUS * layer.glyph_px {
            quads.push(ring_quad(glyphs, centre, text_colour, if is_selected { OPAQUE } else { MARKER_OPACITY }));
        }
        // `None`: the name does not fit, or the body fills the image.
        if let Some(side) = label.name_side {
            let [dx, dy] = side.offset_px(&metrics, label.radius_px).to_array();
            let width = glyphs.layout(&label.name).last().map_or(0.0, |(x, glyph)| f64::from(x + glyph.advance));
            let left_end_px = [centre[0] + dx - if side.is_left { width } else { 0.0 }, centre[1] + dy];
            quads.extend(haloed_text_quads(&label.name, left_end_px, text_colour, OPAQUE, glyphs));
        }
    }
    quads
}

/// A text over its own shadow. `left_end_px`: the left end of the text, at half the height of its lower-case letters; `shadow_px`: the shadow's offset in x
/// and y.
fn text_quads(
    text: &str,
    left_end_px: [f64; 2],
    text_colour: [f32; 3],
    opacity: f32,
    glyphs: &GlyphAtlas,
    shadow_px: f64,
) -> Vec<GlyphQuad> {
    let pen = [left_end_px[0], left_end_px[1] + f64::from(glyphs.baseline_offset_px)];
    let mut quads = Vec::new();
    for (offset_px, colour, opacity) in [(shadow_px, [0.0; 3], SHADOW_OPACITY * opacity), (0.0, text_colour, opacity)] {
        let visible = glyphs.layout(text).filter(|(_, glyph)| glyph.size[0] > 0);
        quads
            .extend(visible.map(|(x, glyph)| glyph_quad(&glyph, [pen[0] + f64::from(x) + offset_px, pen[1] + offset_px], colour, opacity)));
    }
    quads
}

/// A text over the halos of its letters. `left_end_px`: as for [`text_quads`].
fn haloed_text_quads(text: &str, left_end_px: [f64; 2], text_colour: [f32; 3], opacity: f32, glyphs: &GlyphAtlas) -> Vec<GlyphQuad> {
    let pen = [left_end_px[0], left_end_px[1] + f64::from(glyphs.baseline_offset_px)];
    let is_visible = |(_, glyph): &(f32, Glyph)| glyph.size[0] > 0;
    let quad = |(x, glyph): (f32, Glyph), colour, opacity| glyph_quad(&glyph, [pen[0] + f64::from(x), pen[1]], colour, opacity);
    // The halos come first: that of a letter must not cover the letter before it.
    let halos = glyphs.halos(text).filter(is_visible).map(|halo| quad(halo, [0.0; 3], halo_opacity(opacity)));
    halos.chain(glyphs.layout(text).filter(is_visible).map(|glyph| quad(glyph, text_colour, opacity))).collect()
}

/// Labels of lines.
fn line_labels(layer: &TextLayer, glyphs: &GlyphAtlas) -> Vec<GlyphQuad> {
    let shadow_px = shadow_offset_px(layer.glyph_px);
    let quads = |t: &PlacedText| text_quads(&t.text, t.left_end_px.to_array(), t.colour, LINE_LABEL_OPACITY, glyphs, shadow_px);
    layer.texts.iter().flat_map(quads).collect()
}

/// A filled rectangle of whole pixels, tiled with the solid square of the glyph atlas.
fn filled_bar(bar: &Bar, glyphs: &GlyphAtlas) -> Vec<GlyphQuad> {
    let [r, g, b] = colour(bar.colour).to_array();
    let square = glyphs.solid_square;
    let side = square.size[0].max(1);
    // `as` is exact: a side of an image fits into u32.
    let [width, height] = (bar.rect.max - bar.rect.min).round().to_array().map(|v| v.max(0.0) as u32);
    let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
    let tile = |k: u32| {
        let [x, y] = [k % columns * side, k / columns * side];
        let corner_px = [bar.rect.min.x.round() as f32 + x as f32, bar.rect.min.y.round() as f32 + y as f32];
        let cell = [square.top_left[0], square.top_left[1], (width - x).min(side), (height - y).min(side)].map(|v| v as f32);
        GlyphQuad { corner_px, cell, colour: [r, g, b, bar.opacity as f32] }
    };
    (0..columns * rows).map(tile).collect()
}

/// Caption, scale bar and compass; also the names of surface features and the landing sites, which the scene's `margin` contains, too.
fn margin_labels(layer: &LabelLayer, glyphs: &GlyphAtlas) -> Vec<GlyphQuad> {
    let shadow_px = shadow_offset_px(layer.glyph_px);
    let margin = &layer.margin;
    let ring = |centre: &glam::DVec2| ring_quad(glyphs, centre.to_array(), colour(NAME_COLOUR).to_array(), MARKER_OPACITY);
    let site = |centre: &glam::DVec2| {
        let [x, y] = centre.to_array();
        [glyph_quad(&glyphs.ring_halo, [x - 0.5, y - 0.5], [0.0; 3], halo_opacity(MARKER_OPACITY)), ring(centre)]
    };
    let text = |t: &TextLine| haloed_text_quads(&t.text, t.left_end_px.to_array(), colour(t.colour).to_array(), t.opacity as f32, glyphs);
    let shadow = |bar: &Bar| {
        let offset = glam::DVec2::splat(shadow_px);
        let rect = Rect { min: bar.rect.min + offset, max: bar.rect.max + offset };
        filled_bar(&Bar { rect, colour: [0; 3], opacity: f64::from(SHADOW_OPACITY) * bar.opacity }, glyphs)
    };
    let bars = margin.bars.iter().flat_map(shadow).chain(margin.bars.iter().flat_map(|bar| filled_bar(bar, glyphs)));
    margin.rings.iter().map(ring).chain(margin.sites.iter().flat_map(site)).chain(bars).chain(margin.texts.iter().flat_map(text)).collect()
}

/// In an image whose left edge continues the right one, repeats each item that crosses one of these edges at the other edge. `ends`: left and right end of an
/// item, pixels; `shifted`: an item moved to the right by this many pixels.
fn repeated_across_edges<T>(scene: &Scene, items: Vec<T>, ends: impl Fn(&T) -> [f64; 2], shifted: impl Fn(&T, f64) -> T) -> Vec<T> {
    if !scene.geometry.is_periodic() {
        return items;
    }
    let width_px = f64::from(scene.camera.width);
    let with_copies = |item: T| {
        let [left, right] = ends(&item);
        let copies = [(left < 0.0).then(|| shifted(&item, width_px)), (right > width_px).then(|| shifted(&item, -width_px))];
        copies.into_iter().flatten().chain([item])
    };
    items.into_iter().flat_map(with_copies).collect()
}

/// Data points, in one draw; none without data.
fn dots(scene: &Scene, all: &[Dot], provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let ends = |d: &Dot| [d.centre_px.x - d.radius_px, d.centre_px.x + d.radius_px];
    let shifted = |d: &Dot, right_px: f64| Dot { centre_px: d.centre_px + glam::DVec2::new(right_px, 0.0), ..*d };
    let all = repeated_across_edges(scene, all.to_vec(), ends, shifted);
    // Attributes, each with its number of components: centre and radius in pixels; colour and opacity.
    let (vertices, instances) = instanced_rectangles::<Dot>(
        &all,
        &[
            (3, |d| d.centre_px.extend(d.radius_px).as_vec3().to_array().to_vec()),
            (4, |d| colour(d.colour).extend(d.opacity as f32).to_array().to_vec()),
        ],
    );
    let draw = simple_draw("dot", scene, provider, |w| w.vec2("pixel_size", scene.camera.clip_per_pixel()))?;
    Ok(vec![PlanDraw { label: "data".into(), vertices, instances, blend: Blend::PremultipliedOver, ..draw }])
}

/// The draws of all annotations: data points first, then all others in one draw.
pub(super) fn labels(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let labels = scene.labels.as_ref();
    // Both layers have the same text size.
    let Some(glyph_px) = labels.map(|l| l.glyph_px).or(scene.line_texts.as_ref().map(|t| t.glyph_px)) else {
        return Ok(Vec::new());
    };
    let glyphs = provider.glyphs(glyph_px);
    let mut quads = scene.line_texts.as_ref().map_or(Vec::new(), |texts| line_labels(texts, &glyphs));
    let mut draws = Vec::new();
    if let Some(labels) = labels {
        quads.extend(body_labels(labels, &glyphs));
        quads.extend(margin_labels(labels, &glyphs));
        draws = dots(scene, &labels.dots, provider)?;
    }
    if quads.is_empty() {
        return Ok(draws);
    }
    let ends = |q: &GlyphQuad| [q.corner_px[0], q.corner_px[0] + q.cell[2]].map(f64::from);
    let shifted = |q: &GlyphQuad, right_px: f64| GlyphQuad { corner_px: [q.corner_px[0] + right_px as f32, q.corner_px[1]], ..*q };
    let quads = repeated_across_edges(scene, quads, ends, shifted);
    let (vertices, instances) =
        instanced_rectangles::<GlyphQuad>(&quads, &[(2, |q| q.corner_px.to_vec()), (4, |q| q.cell.to_vec()), (4, |q| q.colour.to_vec())]);
    let draw = simple_draw("label", scene, provider, |w| w.vec2("pixel_size", scene.camera.clip_per_pixel()))?;
    let textures = vec![TextureBinding { binding: FIRST_READ_BINDING, source: TextureSource::Image(Arc::clone(&glyphs.texture)) }];
    draws.push(PlanDraw { label: "names".into(), textures, vertices, instances, blend: Blend::PremultipliedOver, ..draw });
    Ok(draws)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::annotation::features::FEATURE_COLOUR;

    const SIZE_PX: [usize; 2] = [300, 60];

    /// Display values of an image of one grey level with these quads over it, as the label shader and its blend mode give them, 0 to 1.
    fn drawn(quads: &[GlyphQuad], glyphs: &GlyphAtlas, ground: f32) -> Vec<[f32; 3]> {
        let mut image = vec![[ground; 3]; SIZE_PX[0] * SIZE_PX[1]];
        let level = &glyphs.texture.levels[0];
        for quad in quads {
            let [left, top, width, height] = quad.cell.map(|v| v as usize);
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let coverage = f32::from(level.bytes()[4 * ((top + y) * level.width as usize + left + x)]) / 255.0;
                let [r, g, b, opacity] = quad.colour;
                let alpha = opacity * coverage;
                let pixel = &mut image[(quad.corner_px[1] as usize + y) * SIZE_PX[0] + quad.corner_px[0] as usize + x];
                *pixel = std::array::from_fn(|k| pixel[k] * (1.0 - alpha) + [r, g, b][k] * alpha);
            }
        }
        image
    }

    /// Contrast of two colours by WCAG 2.1, 1 to 21.
    fn contrast(a: [f32; 3], b: [f32; 3]) -> f32 {
        let linear = |v: f32| if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
        let luminance = |[r, g, b]: [f32; 3]| 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// The least contrast between a pixel of a letter and the next pixel beside the letter on its left, right, upper or lower side. `min_coverage`: of the
    /// letter's pixels that count, 0 to 1.
    fn least_contrast(quads: &[GlyphQuad], text_colour: [f32; 3], glyphs: &GlyphAtlas, ground: f32, min_coverage: f32) -> f32 {
        let image = drawn(quads, glyphs, ground);
        let letters = quads.iter().filter(|quad| quad.colour[..3] == text_colour);
        let opaque_letters: Vec<GlyphQuad> = letters.map(|q| GlyphQuad { colour: [1.0; 4], ..*q }).collect();
        let coverage: Vec<f32> = drawn(&opaque_letters, glyphs, 0.0).into_iter().map(|pixel| pixel[0]).collect();
        let (mut least, mut counted) = (f32::INFINITY, 0);
        for at in (0..image.len()).filter(|at| coverage[*at] >= min_coverage) {
            for step in [1, -1, SIZE_PX[0] as isize, -(SIZE_PX[0] as isize)] {
                let beside = (1..).map(|k| at.wrapping_add_signed(k * step)).find(|beside| coverage[*beside] < 0.1).expect("a pixel");
                least = least.min(contrast(image[at], image[beside]));
                counted += 1;
            }
        }
        assert!(counted > 20, "{counted} edges of letters");
        least
    }

    /// Pale names on the sunlit Moon once had only the shadow of all other texts, which leaves their left and upper sides on pale ground.
    #[test]
    fn names_of_features_are_readable_on_any_ground() {
        let (text, left_end_px, text_colour) = ("Rabbi Levi", [30.0, 30.0], colour(FEATURE_COLOUR).to_array());
        // Half-transparent names, too. Thin strokes of small text cover few pixels completely.
        for (glyph_px, opacity, min_coverage) in [(13.0, 1.0, 0.5), (26.0, 1.0, 0.8), (26.0, 0.6, 0.8)] {
            let glyphs = GlyphAtlas::draw(text.chars(), glyph_px as f32, 0.4);
            let with_halo = haloed_text_quads(text, left_end_px, text_colour, opacity, &glyphs);
            for ground in [0.0, 0.5, 1.0] {
                let ratio = least_contrast(&with_halo, text_colour, &glyphs, ground, min_coverage);
                assert!(ratio >= 3.0, "text of {glyph_px} px, opacity {opacity}, on ground of {ground}: {ratio}");
            }
            // Negative control: on white ground the shadow alone is not enough.
            let with_shadow = text_quads(text, left_end_px, text_colour, opacity, &glyphs, shadow_offset_px(glyph_px));
            assert!(least_contrast(&with_shadow, text_colour, &glyphs, 1.0, min_coverage) < 3.0);
        }
    }
}
