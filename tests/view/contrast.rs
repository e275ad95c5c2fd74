//! Contrast of all text that the panels paint, in both themes: WCAG 2.2, success criterion 1.4.3, level AA.

use crate::view::interface::{harness, interface, settle};
use egui::epaint::{ClippedShape, Shape};
use egui::{Color32, Pos2, Rect};
use egui_kittest::kittest::{By, Queryable};
use orrery::catalog::NaifId;
use orrery::view::panels::Tab;

/// Relative luminance by WCAG 2.2.
fn luminance(c: Color32) -> f64 {
    let linear = |v: u8| {
        let v = f64::from(v) / 255.0;
        if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b())
}

/// Contrast ratio by WCAG 2.2.
pub(super) fn contrast(a: Color32, b: Color32) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[derive(Debug)]
struct PaintedText {
    text: String,
    middle: Pos2,
    colour: Color32,
    background: Color32,
}

/// Texts in the order of painting, each with the last fill below it. Texts over the sky's image have shadows of their own and are left out.
fn painted_texts(shapes: &[ClippedShape]) -> Vec<PaintedText> {
    fn walk(shape: &Shape, clip: Rect, filled: &mut Vec<(Rect, Color32)>, found: &mut Vec<PaintedText>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|s| walk(s, clip, filled, found)),
            // An image counts as black; texts over black are left out below.
            Shape::Rect(r) if r.brush.is_some() => filled.push((r.rect.intersect(clip), Color32::BLACK)),
            Shape::Rect(r) if r.fill.a() > 0 => {
                let below = filled.iter().rev().find(|(rect, _)| rect.contains(r.rect.center())).map_or(Color32::BLACK, |f| f.1);
                filled.push((r.rect.intersect(clip), below.blend(r.fill)));
            }
            Shape::Text(t) if t.opacity_factor >= 0.99 => {
                let rect = t.visual_bounding_rect();
                let below = filled.iter().rev().find(|(place, _)| place.contains(rect.center()));
                let Some((_, background)) = below.filter(|(_, c)| *c != Color32::BLACK && clip.contains(rect.center())) else { return };
                for section in &t.galley.job.sections {
                    let section_colour = section.format.color;
                    let section_colour = if section_colour == Color32::PLACEHOLDER { t.fallback_color } else { section_colour };
                    let colour = t.override_text_color.unwrap_or(section_colour);
                    let text = t.galley.job.text.get(section.byte_range.start.0..section.byte_range.end.0).unwrap_or_default();
                    let background = if section.format.background.a() == 255 { section.format.background } else { *background };
                    if !text.trim().is_empty() {
                        found.push(PaintedText {
                            text: text.to_owned(),
                            middle: rect.center(),
                            colour: background.blend(colour),
                            background,
                        });
                    }
                }
            }
            _ => {}
        }
    }
    let (mut filled, mut found) = (Vec::new(), Vec::new());
    shapes.iter().for_each(|s| walk(&s.shape, s.clip_rect, &mut filled, &mut found));
    found
}

/// Disabled controls are left out, as in the criterion, and so are the axis labels of *Performance*, which egui_plot fades where they are dense.
#[test]
fn all_text_is_legible_in_both_themes() {
    let mut harness = harness(interface(NaifId(699), "2017-05-17T00:00:00Z"));
    let mut lowest = (f64::INFINITY, String::new());
    for dark in [true, false] {
        harness.state_mut().settings.dark = Some(dark);
        for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
            harness.state_mut().tab = tab;
            harness.state_mut().help_shown = tab.is_none();
            settle(&mut harness);
            let disabled: Vec<Rect> = harness.query_all(By::new().predicate(|node| node.is_disabled())).map(|n| n.rect()).collect();
            let is_axis_label = |painted: &PaintedText| tab == Some(Tab::Performance) && painted.text.parse::<f64>().is_ok();
            let all: Vec<PaintedText> = painted_texts(&harness.output().shapes)
                .into_iter()
                .filter(|painted| !disabled.iter().any(|d| d.contains(painted.middle)) && !is_axis_label(painted))
                .collect();
            assert!(all.len() > 30, "{tab:?}: {} texts", all.len());
            for painted in all {
                let ratio = contrast(painted.colour, painted.background);
                if ratio < lowest.0 {
                    lowest = (ratio, format!("{tab:?}, dark {dark}: {painted:?}"));
                }
            }
        }
    }
    assert!(lowest.0 >= 4.5, "{:.2}: {}", lowest.0, lowest.1);
}

#[test]
fn the_contrast_ratio_is_that_of_wcag() {
    // WCAG's own extremes, and grey 118 on white, the lightest grey that passes (1.4.3, understanding).
    assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9 && contrast(Color32::WHITE, Color32::WHITE) == 1.0);
    assert!(contrast(Color32::from_gray(118), Color32::WHITE) >= 4.5 && contrast(Color32::from_gray(119), Color32::WHITE) < 4.5);
    // egui's own weak text fails in the light theme.
    let light = egui::Visuals::light();
    assert!(contrast(light.panel_fill.blend(light.weak_text_color()), light.panel_fill) < 4.5);
}
