//! Draws of what is written over a finished picture: names and markers of bodies, texts of lines, margins, points of data.
//!
//! In: a scene's labels and texts, the provider's letters. Out: draws for the display target. Always: letters stand on whole pixels. Not here: where a text has
//! room (`scene::annotation`).

use super::error::PlanError;
use super::passes::{Blend, PlanDraw, TextureBinding, TextureSource};
use super::provider::ResourceProvider;
use super::shared::{READS_BINDING, colour, of_module, rectangles};
use crate::image::{Glyph, GlyphAtlas};
use crate::scene::Scene;
use crate::scene::annotation::line_texts::{PlacedText, TextLayer};
use crate::scene::marks::{
    Bar, Dot, FILLS_PICTURE, LabelLayer, LabelMetrics, LabelSide, MARKER_OPACITY, MARKER_RADIUS, NAME_COLOUR, Rect, SELECTED_COLOUR,
    TextMark,
};
use std::sync::Arc;

/// Opacity of a line's text.
const TEXT_OPACITY: f32 = 0.85;
/// Opacity of the shadow that keeps a name readable before something bright.
const NAME_SHADOW: f32 = 0.7;

/// One letter or marker in the picture.
struct Stamp {
    corner_px: [f32; 2],
    cell: [f32; 4],
    colour: [f32; 4],
}

/// A cell whose pen stands at a place: whole pixels, so that each texel falls on one.
fn stamp(cell: &Glyph, pen: [f64; 2], [r, g, b]: [f32; 3], opacity: f32) -> Stamp {
    let corner_px = std::array::from_fn(|k| (pen[k].round() + f64::from(cell.bearing[k])) as f32);
    let [x, y, w, h] = [cell.at[0], cell.at[1], cell.size[0], cell.size[1]].map(|v| v as f32);
    Stamp { corner_px, cell: [x, y, w, h], colour: [r, g, b, opacity] }
}

/// Markers and names, the least important first, each name over its own shadow.
fn stamps(labels: &LabelLayer, glyphs: &GlyphAtlas, height: u32) -> Vec<Stamp> {
    let lettering = LabelMetrics::of_size(labels.size_px);
    let shade_px = (labels.size_px / 13.0).round().max(1.0);
    let mut all = Vec::new();
    for mark in labels.marks.iter().rev() {
        let selected = mark.body == labels.selected;
        let ink = colour(if selected { SELECTED_COLOUR } else { NAME_COLOUR }).to_array();
        let at = mark.centre_px.to_array();
        if mark.radius_px < MARKER_RADIUS * labels.size_px {
            let at = [at[0] - 0.5, at[1] - 0.5];
            all.push(stamp(&glyphs.marker, at, ink, if selected { 1.0 } else { MARKER_OPACITY }));
        }
        let side = mark.named.or_else(|| selected.then_some(LabelSide::DEFAULT));
        if let Some(side) = side
            && mark.radius_px < FILLS_PICTURE * f64::from(height)
        {
            let [x, y] = side.offset_px(lettering.gap_px(mark.radius_px)).to_array();
            let width = glyphs.layout(&mark.name).last().map_or(0.0, |(along, cell)| f64::from(along + cell.advance));
            let left = [at[0] + x - if side.left { width } else { 0.0 }, at[1] + y];
            all.extend(written(&mark.name, left, ink, 1.0, glyphs, shade_px));
        }
    }
    all
}

/// A text over its own shadow. `left_px`: the left end of its middle line.
fn written(text: &str, left_px: [f64; 2], ink: [f32; 3], opacity: f32, glyphs: &GlyphAtlas, shade_px: f64) -> Vec<Stamp> {
    let pen = [left_px[0], left_px[1] + f64::from(glyphs.baseline_offset)];
    let mut all = Vec::new();
    for (away_px, ink, opacity) in [(shade_px, [0.0; 3], NAME_SHADOW * opacity), (0.0, ink, opacity)] {
        let written = glyphs.layout(text).filter(|(_, cell)| cell.size[0] > 0);
        all.extend(written.map(|(along, cell)| stamp(&cell, [pen[0] + f64::from(along) + away_px, pen[1] + away_px], ink, opacity)));
    }
    all
}

/// Texts of lines.
fn text_stamps(layer: &TextLayer, glyphs: &GlyphAtlas) -> Vec<Stamp> {
    let shade_px = (layer.size_px / 13.0).round().max(1.0);
    let stamps = |t: &PlacedText| written(&t.text, t.left_px.to_array(), t.colour, TEXT_OPACITY, glyphs, shade_px);
    layer.texts.iter().flat_map(stamps).collect()
}

/// A filled rectangle of whole pixels, in pieces no larger than the block of the letters' texture.
fn filled(bar: &Bar, glyphs: &GlyphAtlas) -> Vec<Stamp> {
    let [r, g, b] = colour(bar.colour).to_array();
    let block = glyphs.block;
    let side = block.size[0].max(1);
    // Coordinates of a picture fit.
    let [width, height] = (bar.rect.most - bar.rect.least).round().to_array().map(|v| v.max(0.0) as u32);
    let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
    let piece = |k: u32| {
        let [x, y] = [k % columns * side, k / columns * side];
        let corner_px = [bar.rect.least.x.round() as f32 + x as f32, bar.rect.least.y.round() as f32 + y as f32];
        let cell = [block.at[0], block.at[1], (width - x).min(side), (height - y).min(side)].map(|v| v as f32);
        Stamp { corner_px, cell, colour: [r, g, b, bar.opacity as f32] }
    };
    (0..columns * rows).map(piece).collect()
}

/// Names of features, caption, scale bar and compass.
fn margin_stamps(labels: &LabelLayer, glyphs: &GlyphAtlas) -> Vec<Stamp> {
    let shade_px = (labels.size_px / 13.0).round().max(1.0);
    let margin = &labels.margin;
    let ring = |at: &glam::DVec2| stamp(&glyphs.marker, [at.x - 0.5, at.y - 0.5], colour(NAME_COLOUR).to_array(), MARKER_OPACITY);
    let text = |t: &TextMark| written(&t.text, t.left_px.to_array(), colour(t.colour).to_array(), t.opacity as f32, glyphs, shade_px);
    let shadow = |bar: &Bar| {
        let away = glam::DVec2::splat(shade_px);
        let rect = Rect { least: bar.rect.least + away, most: bar.rect.most + away };
        filled(&Bar { rect, colour: [0; 3], opacity: f64::from(NAME_SHADOW) * bar.opacity }, glyphs)
    };
    let bars = margin.bars.iter().flat_map(shadow).chain(margin.bars.iter().flat_map(|bar| filled(bar, glyphs)));
    margin.rings.iter().map(ring).chain(bars).chain(margin.texts.iter().flat_map(text)).collect()
}

/// Points of data, in one draw.
fn dots(scene: &Scene, all: &[Dot], provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let (vertices, instances) = rectangles::<Dot>(
        all,
        &[
            (3, |d| d.centre_px.extend(d.radius_px).as_vec3().to_array().to_vec()),
            (4, |d| colour(d.colour).extend(d.opacity as f32).to_array().to_vec()),
        ],
    );
    let draw = of_module("dot", scene, provider, |w| w.vec2("pixel_size", scene.camera.clip_per_pixel()))?;
    Ok(vec![PlanDraw { label: "data".into(), vertices, instances, blend: Blend::PremultipliedOver, ..draw }])
}

/// Names and markers of bodies, texts of lines, points of data.
pub(super) fn labels(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let labels = scene.labels.as_ref();
    let Some(size_px) = labels.map(|l| l.size_px).or(scene.texts.as_ref().map(|t| t.size_px)) else {
        return Ok(Vec::new());
    };
    let glyphs = provider.glyphs(size_px);
    let mut all = scene.texts.as_ref().map_or(Vec::new(), |texts| text_stamps(texts, &glyphs));
    let mut draws = Vec::new();
    if let Some(labels) = labels {
        all.extend(stamps(labels, &glyphs, scene.camera.height));
        all.extend(margin_stamps(labels, &glyphs));
        draws = dots(scene, &labels.dots, provider)?;
    }
    if all.is_empty() {
        return Ok(draws);
    }
    let (vertices, instances) =
        rectangles::<Stamp>(&all, &[(2, |s| s.corner_px.to_vec()), (4, |s| s.cell.to_vec()), (4, |s| s.colour.to_vec())]);
    let draw = of_module("label", scene, provider, |w| w.vec2("pixel_size", scene.camera.clip_per_pixel()))?;
    let textures = vec![TextureBinding { binding: READS_BINDING, source: TextureSource::Image(Arc::clone(&glyphs.texture)) }];
    draws.push(PlanDraw { label: "names".into(), textures, vertices, instances, blend: Blend::PremultipliedOver, ..draw });
    Ok(draws)
}
