//! The margin of an image: caption, scale bar and compass, which are drawn over the image near its edges.
//!
//! In: the request and the bodies in view. Out: texts, bars and rings. Always: lengths are round numbers; a length is valid across the line of sight at one
//! point of the target's ground, the one in the image's middle (`shown_ground` says which one if there is none). At other places it is wrong by the ratio of
//! the distances. If the image shows no such point, or if the target's disc is small, the scale bar states an angle: the angle that this bar would span in the
//! middle of the image. The caption gives the height of a camera near its target, else the distance of the target's centre. The compass points to the target's
//! north pole. In a narrow image the caption has more lines and the scale bar stands above the caption; what does not fit is left out.

use super::shown_ground::shown_ground_km;
use super::text::{Bar, LabelMetrics, NAME_COLOUR, Rect, TextLine};
use crate::catalog::Catalog;
use crate::message::{Argument, TextLanguage, message};
use crate::scene::body_report::BodyReport;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::numeric::with_significant_digits;
use crate::scene::request::view_request::{Position, ViewRequest};
use crate::units::KM_PER_AU;
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

/// Texts, bars and rings. A ring, given by its centre in pixels, is a circle: here the middle of the compass. [`LabelLayer`](super::labels::LabelLayer) adds
/// the names of surface features to the same texts, and the landing sites.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Margin {
    pub texts: Vec<TextLine>,
    pub bars: Vec<Bar>,
    pub rings: Vec<DVec2>,
    /// The positions of the named landing sites, each of which has a ring with a halo.
    pub sites: Vec<DVec2>,
}

/// Largest length of a scale bar relative to the image's width.
const MAX_BAR_FRACTION: f64 = 0.22;
/// Largest height of a caption relative to the image's height.
const MAX_CAPTION_FRACTION: f64 = 0.5;
/// Line spacing of a caption, in glyph sizes.
const CAPTION_LINE_SPACING: f64 = 1.3;
/// Distance of a caption from the image's left edge, in glyph sizes.
const CAPTION_EDGE: f64 = 0.8;
/// Distance from the image's lower edge to the middle of the caption's last line and to the top of the scale bar, and from the right edge to the bar; in glyph
/// sizes.
const EDGE_DISTANCE: f64 = 0.9;
/// Opacity of the scale bar and of the compass needle.
const BAR_OPACITY: f64 = 0.9;
/// Height of the ticks at the ends of a scale bar, in glyph sizes.
const TICK_HEIGHT: f64 = 0.45;
/// Height of the middle of a scale bar's text above the bar, in glyph sizes.
const BAR_TEXT_HEIGHT: f64 = 1.1;
/// Smallest distance of a scale bar's text from the image's right edge, in glyph sizes.
const BAR_TEXT_EDGE: f64 = 0.6;
/// Size of glyphs divided by the thickness of the scale bar and of the compass needle, before the thickness is rounded to whole pixels.
const GLYPH_PER_THICKNESS: f64 = 9.0;
/// Free space between a caption and the scale bar above it, in glyph sizes.
const CAPTION_GAP: f64 = 0.3;
/// Distance of the compass's middle from the right and the upper edge, in glyph sizes.
const COMPASS_EDGE: f64 = 3.0;
/// Half of the side of the square that the compass occupies, in glyph sizes.
const COMPASS_HALF_SIDE: f64 = 2.5;
/// Distances from the compass's middle to both ends of its needle, in glyph sizes.
const NEEDLE: (f64, f64) = (0.5, 1.2);
/// Distance from the compass's middle to the middle of its letter, in glyph sizes.
const NORTH_LETTER: f64 = 1.9;
/// Number of steps between the squares of which the needle consists.
const NEEDLE_STEPS: u32 = 10;
/// Smallest sine of the angle between a body's pole and the line of sight for which the compass is drawn.
const MIN_POLE_SINE: f64 = 0.02;
/// Diameter in pixels below which a target counts as a point, and the scale bar shows an angle.
const MIN_DISC_PX: f64 = 20.0;
/// Significant digits of lengths and angles.
const SIGNIFICANT_DIGITS: i32 = 3;

impl Margin {
    /// The margin of an image.
    pub(crate) fn of(
        image: &impl ImageProjection,
        request: &ViewRequest,
        catalog: &Catalog,
        bodies: &[BodyReport],
        metrics: &LabelMetrics,
    ) -> Self {
        let mut margin = Self::default();
        let target = request.target.and_then(|id| bodies.iter().find(|b| b.id == id)).filter(|b| b.distance_km > 0.0);
        if request.layers.caption {
            margin.caption(image, request, catalog, target, metrics);
        }
        if request.layers.scale_bar {
            margin.scale_bar(image, target, request.language, metrics);
        }
        if let Some(target) = target.filter(|_| request.layers.compass) {
            margin.compass(image, target, metrics);
        }
        margin
    }

    /// The margin shifted to the right, as in the right half of a stereo pair.
    pub(crate) fn shifted(mut self, right_px: f64) -> Self {
        let shift = DVec2::new(right_px, 0.0);
        self.texts.iter_mut().for_each(|t| t.left_end_px += shift);
        self.rings.iter_mut().chain(&mut self.sites).for_each(|middle| *middle += shift);
        self.bars.iter_mut().for_each(|b| (b.rect.min, b.rect.max) = (b.rect.min + shift, b.rect.max + shift));
        self
    }

    /// Rectangles of the texts and bars.
    pub fn occupied<'a>(&'a self, metrics: &'a LabelMetrics) -> impl Iterator<Item = Rect> + 'a {
        let of_text = |t: &TextLine| metrics.rect(&t.text, t.left_end_px);
        self.texts.iter().map(of_text).chain(self.bars.iter().map(|b| b.rect))
    }

    fn text(&mut self, text: String, left_end_px: DVec2) {
        self.texts.push(TextLine { text, left_end_px, colour: NAME_COLOUR, opacity: 1.0 });
    }

    fn bar(&mut self, min: DVec2, size: DVec2) {
        self.bars.push(Bar { rect: Rect { min, max: min + size }, colour: NAME_COLOUR, opacity: BAR_OPACITY });
    }

    fn caption(
        &mut self,
        image: &impl ImageProjection,
        request: &ViewRequest,
        catalog: &Catalog,
        target: Option<&BodyReport>,
        metrics: &LabelMetrics,
    ) {
        let (glyph_px, language) = (metrics.glyph_px(), request.language);
        let length = |km| Argument::Number(length_text(km));
        // An id that is none of the catalog's bodies is that of a barycentre.
        let name_of = |id| catalog.body(id).map_or(message!("image-barycentre").into(), |b| Argument::from(&b.name));
        let time = language.time(&request.time.to_utc_iso());
        let first_line = target.map_or_else(|| time.clone(), |t| format!("{}   {time}", language.name("body", &t.name)));
        let viewpoint = match request.position {
            Position::Centre(body) => message!("image-from-centre", body = name_of(body)),
            Position::Ground { body, latitude_deg, longitude_deg, .. } => {
                let signed_longitude_deg = (longitude_deg + 180.0).rem_euclid(360.0) - 180.0;
                message!(
                    "image-from-ground",
                    body = name_of(body),
                    latitude = format_args!("{:.2}", latitude_deg.abs()),
                    north = language.name("compass", if latitude_deg < 0.0 { "S" } else { "N" }),
                    longitude = format_args!("{:.2}", signed_longitude_deg.abs()),
                    east = language.name("compass", if signed_longitude_deg < 0.0 { "W" } else { "E" }),
                )
            }
            Position::AboveTarget { .. } | Position::Offset { .. } => match target {
                Some(target) => match target.placement.height_near_ground_km() {
                    Some(height_km) => message!("image-from-height", height = length(height_km)),
                    None => message!("image-from-away", distance = length(target.distance_km)),
                },
                None => message!("image-from-space"),
            },
        };
        let second_line = message!("image-caption", from = viewpoint, view = image.field_of_view_text()).text_in(language);
        let size = image.size_px();
        let fits = |text: &str| metrics.width_px(text) <= size.x - 2.0 * CAPTION_EDGE * glyph_px;
        let Some((mut lines, rest)) = wrapped(&first_line, &CAPTION_BREAKS, &fits).zip(wrapped(&second_line, &CAPTION_BREAKS, &fits))
        else {
            return;
        };
        lines.extend(rest);
        if CAPTION_LINE_SPACING * glyph_px * lines.len() as f64 > MAX_CAPTION_FRACTION * size.y {
            return;
        }
        let bottom = size.y - EDGE_DISTANCE * glyph_px;
        let count = lines.len();
        for (k, line) in lines.into_iter().enumerate() {
            self.text(line, DVec2::new(CAPTION_EDGE * glyph_px, bottom - CAPTION_LINE_SPACING * glyph_px * (count - 1 - k) as f64));
        }
    }

    fn scale_bar(&mut self, image: &impl ImageProjection, target: Option<&BodyReport>, language: TextLanguage, metrics: &LabelMetrics) {
        let (size, glyph_px) = (image.size_px(), metrics.glyph_px());
        let px_per_radian = image.px_per_radian_in_middle();
        let max_px = MAX_BAR_FRACTION * size.x;
        let max_rad = max_px / px_per_radian;
        let disc_px = |t: &&BodyReport| 2.0 * t.placement.radii_km.max_element() / t.distance_km * px_per_radian;
        // Length of a bar in the image's middle that spans an angle. In a perspective image this length grows faster than the angle.
        let spanning_px = |angle_rad: f64| 2.0 * image.disc_radius_px(0.5 * angle_rad);
        let ground_km = target.filter(|t| disc_px(t) >= MIN_DISC_PX).and_then(|t| shown_ground_km(image, &t.placement));
        let (text, length_px) = match ground_km.map(|ground_km| image.scale_distance_km(ground_km)) {
            Some(distance_km) => {
                let km = round_number_below(max_rad * distance_km);
                (length_text(km), km / distance_km * px_per_radian)
            }
            None => {
                let widest_rad = max_rad.min(FRAC_PI_2);
                // Length grows at least as fast as the angle, so an angle reduced in the ratio of the lengths spans at most `max_px`.
                let (text, angle_rad) = round_angle_below(widest_rad * (max_px / spanning_px(widest_rad)).min(1.0));
                (text, spanning_px(angle_rad))
            }
        };
        let text = language.number(&text);
        let length_px = length_px.round();
        let thickness = (glyph_px / GLYPH_PER_THICKNESS).round().max(1.0);
        let tick = (TICK_HEIGHT * glyph_px).round();
        let left = (size.x - EDGE_DISTANCE * glyph_px - length_px).round();
        // Centred over the bar, as far as the image's edge allows.
        let text_left = left + 0.5 * (length_px - metrics.width_px(&text));
        let text_left = text_left.min(size.x - BAR_TEXT_EDGE * glyph_px - metrics.width_px(&text));
        let text_at = |bar_top: f64| DVec2::new(text_left, bar_top - BAR_TEXT_HEIGHT * glyph_px);
        let rect_at = |bar_top: f64| {
            let of_text = metrics.rect(&text, text_at(bar_top));
            Rect {
                min: of_text.min.min(DVec2::new(left, bar_top - tick)),
                max: of_text.max.max(DVec2::new(left + length_px, bar_top + thickness)),
            }
        };
        let mut bar_top = (size.y - EDGE_DISTANCE * glyph_px).round();
        let gap = DVec2::new(metrics.glyph_width_px, 0.0);
        if self.occupied(metrics).any(|o| o.overlaps(&rect_at(bar_top).padded(gap))) {
            // Above the caption.
            let caption_top = self.occupied(metrics).map(|o| o.min.y).fold(size.y, f64::min);
            bar_top = (caption_top - thickness - CAPTION_GAP * glyph_px).floor();
        }
        if !rect_at(bar_top).is_in_image(size) {
            return;
        }
        self.bar(DVec2::new(left, bar_top), DVec2::new(length_px, thickness));
        self.bar(DVec2::new(left, bar_top - tick), DVec2::new(thickness, tick));
        self.bar(DVec2::new(left + length_px - thickness, bar_top - tick), DVec2::new(thickness, tick));
        let text_position = text_at(bar_top);
        self.text(text, text_position);
    }

    fn compass(&mut self, image: &impl ImageProjection, target: &BodyReport, metrics: &LabelMetrics) {
        let (size, glyph_px) = (image.size_px(), metrics.glyph_px());
        let centre_km = target.placement.centre_km;
        let pole = target.placement.body_from_icrf.row(2);
        // A pole within about a degree of the line of sight has no reliable direction in the image.
        let sine_to_line_of_sight = pole.cross(centre_km.normalize()).length();
        // The direction of the pole in the image, from a short step along the pole.
        let ends_px = image.pixel_of(centre_km).zip(image.pixel_of(centre_km + pole * (1e-3 * target.distance_km)));
        let Some(north) = ends_px.filter(|_| sine_to_line_of_sight > MIN_POLE_SINE).and_then(|(from, to)| (to - from).try_normalize())
        else {
            return;
        };
        let middle = DVec2::new(size.x - COMPASS_EDGE * glyph_px, COMPASS_EDGE * glyph_px).round();
        let bounds = Rect { min: middle, max: middle }.padded(DVec2::splat(COMPASS_HALF_SIDE * glyph_px));
        if !bounds.is_in_image(size) || self.occupied(metrics).any(|o| o.overlaps(&bounds)) {
            return;
        }
        self.rings.push(middle);
        let thickness = (glyph_px / GLYPH_PER_THICKNESS).round().max(1.0);
        // The needle is a row of overlapping squares, because a bar cannot be rotated.
        for k in 0..=NEEDLE_STEPS {
            let from_middle = NEEDLE.0 + (NEEDLE.1 - NEEDLE.0) * f64::from(k) / f64::from(NEEDLE_STEPS);
            let position = middle + north * glyph_px * from_middle;
            self.bar((position - 0.5 * thickness).round(), DVec2::splat(thickness));
        }
        let position = middle + north * NORTH_LETTER * glyph_px;
        self.text("N".into(), position - DVec2::new(0.5 * metrics.width_px("N"), 0.0));
    }
}

/// Where a line of the caption may be broken, best first: between name and time, between parts, between words.
const CAPTION_BREAKS: [&str; 3] = ["   ", ", ", " "];

/// A text wrapped into lines that fit. It is broken where `separators[0]` occurs, as seldom as possible; a part that is still too long is broken at
/// `separators[1]`, and so on. `None`: a word does not fit.
fn wrapped(text: &str, separators: &[&str], fits: &impl Fn(&str) -> bool) -> Option<Vec<String>> {
    if fits(text) {
        return Some(vec![text.to_owned()]);
    }
    let (separator, finer) = separators.split_first()?;
    let mut lines: Vec<String> = Vec::new();
    for part in text.split_inclusive(separator) {
        let joined = lines.last().map(|last| format!("{last}{}{part}", if last.ends_with(' ') { "" } else { " " }));
        match joined.filter(|joined| fits(joined.trim_end())) {
            Some(joined) => {
                lines.pop();
                lines.push(joined);
            }
            None if fits(part.trim_end()) => lines.push(part.to_owned()),
            None => lines.extend(wrapped(part.trim_end(), finer, fits)?),
        }
    }
    Some(lines.into_iter().map(|line| line.trim_end().to_owned()).collect())
}

/// The largest number of the form 1, 2 or 5 times a power of ten that is not above `max`.
fn round_number_below(max: f64) -> f64 {
    let power = 10_f64.powf(max.max(1e-300).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|v| *v <= max * (1.0 + 1e-12)).unwrap_or(power)
}

/// An integer with its digits in groups of three.
fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or("")).collect();
    groups.join(" ")
}

/// A length as text, in millimetres, metres, kilometres or astronomical units. A length that rounds to 1000 mm or 1000 m is given in the next unit.
fn length_text(km: f64) -> String {
    match km {
        _ if km < 999.5e-6 => format!("{} mm", with_significant_digits(km * 1e6, SIGNIFICANT_DIGITS)),
        _ if km < 999.5e-3 => format!("{} m", with_significant_digits(km * 1e3, SIGNIFICANT_DIGITS)),
        _ if km < 999.5 => format!("{} km", with_significant_digits(km, SIGNIFICANT_DIGITS)),
        _ if km < 0.1 * KM_PER_AU => format!("{} km", grouped(km.round())),
        _ => format!("{} au", with_significant_digits(km / KM_PER_AU, SIGNIFICANT_DIGITS)),
    }
}

/// The largest round angle not above `max_rad`: its text, and its value in radians.
fn round_angle_below(max_rad: f64) -> (String, f64) {
    let round = |value: f64, steps: &[f64]| steps.iter().rev().copied().find(|s| *s <= value).unwrap_or(steps[0]);
    let deg = max_rad.to_degrees();
    let (value, unit, per_deg) = match deg {
        _ if deg >= 1.0 => (round(deg, &[1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0]), "°", 1.0),
        _ if deg >= 1.0 / 60.0 => (round(60.0 * deg, &[1.0, 2.0, 5.0, 10.0, 20.0, 30.0]), "'", 60.0),
        _ if deg >= 1.0 / 3600.0 => (round(3600.0 * deg, &[1.0, 2.0, 5.0, 10.0, 20.0, 30.0]), "\"", 3600.0),
        _ => (round_number_below(3600.0 * deg), "\"", 3600.0),
    };
    (format!("{}{unit}", with_significant_digits(value, SIGNIFICANT_DIGITS)), (value / per_deg).to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::scene::camera::Camera;
    use crate::scene::request::Layers;
    use crate::time::Instant;
    use glam::DVec3;

    /// The margin of an image without bodies: caption and scale bar.
    fn margin_of(width: u32, height: u32) -> (Margin, LabelMetrics) {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 20.0, width, height);
        let time = Instant::parse("2017-05-17T00:00:00Z").expect("a time");
        let layers = Layers::parse("+caption,+scale-bar").expect("layers");
        let request = ViewRequest { width, height, layers, ..ViewRequest::of(NaifId(699), time) };
        let metrics = LabelMetrics::of_size((f64::from(height) / 70.0).max(13.0).round());
        (Margin::of(&camera, &request, &Catalog::embedded(), &[], &metrics), metrics)
    }

    /// The caption once extended beyond narrow images, such as the halves of a stereo pair, and overlapped the scale bar.
    #[test]
    fn caption_and_scale_bar_fit_into_every_image() {
        for (width, height) in [(1000, 700), (300, 300), (250, 300), (200, 100), (100, 1000), (48, 48), (16, 16), (1, 1)] {
            let (margin, metrics) = margin_of(width, height);
            let texts: Vec<Rect> = margin.texts.iter().map(|t| metrics.rect(&t.text, t.left_end_px)).collect();
            let size = DVec2::new(f64::from(width), f64::from(height));
            assert!(margin.occupied(&metrics).all(|r| r.is_in_image(size)), "{width}x{height}: {margin:?}");
            for (k, rect) in texts.iter().enumerate() {
                let mut others = texts[k + 1..].iter().chain(margin.bars.iter().map(|b| &b.rect));
                assert!(!others.any(|o| o.overlaps(rect)), "{width}x{height}: {margin:?}");
            }
            // Images less than 100 pixels wide or up to 100 high have no room for the caption. Those less than 48 wide have none for the scale bar, which
            // consists of three rectangles: the bar and its two ticks.
            let words: String = margin.texts.iter().map(|t| format!("{} ", t.text)).collect();
            assert_eq!(words.contains("2017-05-17") && words.contains("20.0°"), width >= 100 && height > 100, "{width}x{height}: {words}");
            assert_eq!(margin.bars.len(), if width >= 48 { 3 } else { 0 }, "{width}x{height}: {margin:?}");
        }
        assert_eq!(margin_of(1000, 700).0.texts.len(), 3, "two lines and the text of the bar");
    }

    /// In the middle of a perspective image a bar spans its angle to within its rounding to whole pixels, also in a wide field.
    #[test]
    fn a_bar_in_the_middle_spans_its_angle() {
        let metrics = LabelMetrics::of_size(13.0);
        for (fov_deg, text, deg) in [(20.0, "5°", 5.0), (100.0, "30°", 30.0), (120.0, "45°", 45.0), (160.0, "90°", 90.0)] {
            let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, fov_deg, 1500, 1000);
            let mut margin = Margin::default();
            let no_target = None;
            margin.scale_bar(&camera, no_target, TextLanguage::English, &metrics);
            let bar = margin.bars[0].rect;
            let length = bar.max.x - bar.min.x;
            let spanned_deg = 2.0 * (0.5 * length * camera.pixel_tangent()).atan().to_degrees();
            let half_pixel_deg = (0.5 * camera.pixel_tangent()).to_degrees();
            assert_eq!(margin.texts[0].text, text, "{fov_deg}");
            assert!((spanned_deg - deg).abs() <= half_pixel_deg, "{fov_deg}: {spanned_deg} for {deg}");
            assert!(length <= MAX_BAR_FRACTION * 1500.0 + 0.5, "{fov_deg}: {length}");
        }
    }

    #[test]
    fn lengths_are_round_and_fit() {
        // Neighbouring round numbers and angles differ by a factor of at most 2.5; the bounds, 2.6 and 3.1, leave a margin. Angles up to 3 mrad, ten
        // arcminutes, are tested here.
        for k in -60..60 {
            let max = 10_f64.powf(f64::from(k) / 7.0) * 1.01;
            let round = round_number_below(max);
            assert!(round <= max && round > max / 2.6, "{round} below {max}");
            let max_rad = max.min(3.0) * 1e-3;
            let (text, angle) = round_angle_below(max_rad);
            assert!(angle <= max_rad * (1.0 + 1e-12) && angle > max_rad / 3.1, "{text}");
        }
        let texts = [(20_000.0, "20 000 km"), (0.5, "500 m"), (5.0, "5 km"), (1_234_567.0, "1 234 567 km"), (149_597_870.7, "1 au")];
        let rounded_up = [(999.7e-6, "1 m"), (0.9997, "1 km"), (999.7, "1 000 km"), (0.9994, "999 m"), (999.4, "999 km")];
        for (km, text) in texts.into_iter().chain(rounded_up) {
            assert_eq!(length_text(km), text);
        }
        assert_eq!(round_angle_below(0.2).0, "10°");
        assert_eq!(round_angle_below(0.001).0, "2'");
        assert_eq!(round_angle_below(1e-5).0, "2\"");
    }
}
