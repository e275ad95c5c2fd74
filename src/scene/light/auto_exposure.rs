//! The exposure of an image: set by the user, or chosen for the subjects in the frame.
//!
//! In: the request, the camera and the placed bodies. Out: [`Exposure`] with its reason. The light meter (`meter`) gives each subject in the frame a weight;
//! the subject with the greatest weight dominates, so that no image is a compromise between two subjects that differ by twenty stops. Always: the Sun's glare
//! saturates at most about a tenth of the frame (`MAX_MEDIAN_GLARE`), a daylight sky in the frame stays below white (`least_white_for_sky`), the highlights of
//! the bodies stay below white where a shorter exposure can protect them (`MAX_HIGHLIGHT_LEVEL`), the exposure is no longer than that of a photograph of the
//! night sky, and it changes as continuously as the meter's reading. Pixel views that show another quantity than light
//! ([`PixelView`]) are not metered: unless the user sets an exposure, each has one that does not depend on the image's content and that its legend states.

use crate::catalog::NaifId;
use crate::message::{Argument, Reason, reason};
use crate::scene::atmosphere::air;
use crate::scene::camera::Camera;
use crate::scene::draw::PixelView;
use crate::scene::light::city_lights;
use crate::scene::light::exposure::{AUTO_EXPOSED_MEAN, CD_M2_PER_RADIANCE, COST_STOPS, DARKEST_EV, Exposure, darkest_white};
use crate::scene::light::lights::{self, Reflector};
use crate::scene::light::meter::{FrameGlare, Meter, MeterReading, MeteredSubject, bright_ground_weight};
use crate::scene::numeric::{smooth_rise, with_significant_digits};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::{ExposureRequest, ViewRequest};
use crate::scene::resources::Context;
use crate::scene::sky::comet_tails::LightPatch;
use glam::FloatExt;
use std::ops::Range;

/// Power to which the weights of subjects are raised: subjects with weights in the ratio 1:3 contribute in the ratio 1:9.
const WEIGHT_EXPONENT: i32 = 2;
/// Exponent of the smooth maximum (p-norm) of several white levels. The smooth maximum of two equal levels is a quarter of a stop above them.
const SMOOTH_MAX_EXPONENT: i32 = 4;
/// Upper limits of the median glare in the frame, as a fraction of white: for subjects brighter than the glare, for fainter ones, and for those that are lost
/// in the glare. In the last case the sky looks black (0.003 of white is level 10 of 255), at the cost of the faintest stars.
const MAX_MEDIAN_GLARE: [f64; 3] = [0.2, 0.02, 0.003];
/// Ratio of a subject's radiance to the glare below which the subject is lost in the glare.
const LOST_SUBJECT_RATIO: f64 = 0.1;
/// Highest level, as a fraction of white, of the metered highlights of bodies. They are those of ground without the contrast of its map; with it a twentieth of
/// the drawn disc, or less, is shown at 0.9 of white or more (tests/scene/highlights.rs). A full disc, whose ground is evenly bright, stays at its level.
const MAX_HIGHLIGHT_LEVEL: f64 = 0.8;
/// The most by which highlights darken an image, stops. Much brighter ones are burnt out all the same: a sunlit planet beside a moon in its shadow, or the last
/// sunlit part of a moon in an eclipse.
const MAX_PROTECTIVE_STOPS: f64 = 1.5;
/// Radiances of the brightest city lights, in stops relative to what is white without them, between which the weight of city lights rises from 0 to 1. Below the
/// first they are hardly drawn.
const COUNTED_CITY_LIGHTS_STOPS: (f64, f64) = (-6.0, -4.0);
/// Beside the main subject, the reason of an exposure names every subject that contributes more than `NAMED_SHARE`, or moves the exposure by more than
/// `NAMED_STOPS`. It also names a limit (by the glare, the highlights, the sky, or for a night sky) that moves the exposure by more than `NAMED_STOPS`, and the
/// main subject's target level if the image misses this level by more than `NAMED_STOPS`.
const NAMED_SHARE: f64 = 0.1;
const NAMED_STOPS: f64 = 0.1;

/// An exposure, and the reading of the light meter from which it follows.
pub(crate) struct Metered {
    pub exposure: Exposure,
    /// The reading without city lights. `None` if the light is not metered, or if the exposure includes city lights.
    reading: Option<MeterReading>,
}

impl Metered {
    fn without_reading(exposure: Exposure) -> Self {
        Self { exposure, reading: None }
    }
}

/// The exposure of an image: metered, or as requested. `reflectors`: the bodies whose light may light others. `comet_patches`: comas and tails in the frame;
/// not read unless [`is_metered`]. `air`: the air around the camera, if any.
/// `earlier`: the exposure of the same frame with the same bright ground, but without city lights: only these are metered in addition.
pub(crate) fn exposure(
    context: Context<'_>,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    reflectors: &[Reflector<'_>],
    comet_patches: &[LightPatch],
    air: Option<&air::SurroundingAir<'_>>,
    earlier: Option<Metered>,
) -> Metered {
    if let ExposureRequest::Stops(stops) = context.request.exposure {
        return Metered::without_reading(Exposure::of(stops, reason!("set-by-you")));
    }
    let reading = earlier.and_then(|metered| metered.reading);
    let Metered { exposure, reading } = metered_exposure(context, camera, placed, reflectors, comet_patches, air, reading);
    // In a transition `stops` approaches `metered_stops`, which stays.
    let stops = context.request.exposure.stops_of(exposure.stops);
    Metered { exposure: Exposure { stops, ..exposure }, reading }
}

/// The exposure that the light meter chooses for the final image; for other pixel views the one that does not depend on the image's content. `reading`: of this
/// frame, without city lights; `None` if there is none yet.
fn metered_exposure(
    context: Context<'_>,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    reflectors: &[Reflector<'_>],
    comet_patches: &[LightPatch],
    air: Option<&air::SurroundingAir<'_>>,
    reading: Option<MeterReading>,
) -> Metered {
    let (request, resources) = (context.request, context.resources);
    match request.pixel_view {
        PixelView::Final => {}
        // A white plane that faces the Sun at the target is shown as white.
        PixelView::Sunlight => {
            let target = placed.iter().find(|p| Some(p.body.id) == request.target && p.body.id != NaifId::SUN);
            // Sunlight is the same in all channels.
            let irradiance = target.map_or(1.0, |p| lights::sunlight(p.body_to_sun_km).irradiance.x);
            return Metered::without_reading(Exposure::of(-irradiance.log2(), reason!("exposure-plane")));
        }
        PixelView::Cost => {
            let stops = COST_STOPS;
            let reason = reason!("exposure-instructions", count = format_args!("{:.0}", (-stops).exp2()));
            return Metered::without_reading(Exposure::of(stops, reason));
        }
        _ => {
            let stops_of_factor_1 = 0.0;
            return Metered::without_reading(Exposure::of(stops_of_factor_1, reason!("exposure-number")));
        }
    }
    // Only air that is dense enough for a daylight sky is metered.
    let air = air.filter(|a| a.is_bright());
    let meter = |city_light_weight: f64| Meter { context, camera, placed, reflectors, comet_patches, air, city_light_weight };
    let reading = reading.unwrap_or_else(|| meter(0.0).read(darkest_white()));
    let without_city_lights = from_reading(&reading);
    // Whether city lights count depends on the exposure without them: by day they are not drawn.
    let brightest_city_light = placed
        .iter()
        .filter(|p| resources.night_lights.contains_key(&p.body.id))
        .map(city_lights::drawn_white_radiance)
        .fold(0.0, f64::max);
    let city_light_weight = city_light_weight(brightest_city_light, without_city_lights.white());
    if city_light_weight > 0.0 {
        return Metered::without_reading(from_reading(&meter(city_light_weight).add_city_lights(reading)));
    }
    Metered { exposure: without_city_lights, reading: Some(reading) }
}

/// Weight of city lights relative to other ground. `brightest`: radiance of a white texel of the night map as it is drawn; `white`: the radiance that is white
/// in an image exposed without city lights.
fn city_light_weight(brightest: f64, white: f64) -> f64 {
    // 1e-30 only keeps the logarithm finite where there are no city lights.
    smooth_rise(COUNTED_CITY_LIGHTS_STOPS, (brightest / white).max(1e-30).log2())
}

/// The smooth maximum of two white levels.
fn smooth_max([a, b]: [f64; 2]) -> f64 {
    let (greater, less) = (a.max(b), a.min(b));
    // Powers of the quotient: those of the levels themselves would be 0 for a sky far below that of any night.
    if greater > 0.0 {
        greater * (1.0 + (less / greater).powi(SMOOTH_MAX_EXPONENT)).powf(1.0 / f64::from(SMOOTH_MAX_EXPONENT))
    } else {
        0.0
    }
}

/// The radiance that is white in an image of a subject alone, with the Sun's glare in front of it. Glare has little effect in front of brighter subjects; in
/// front of a dark sky it would make the image grey. So the upper limit of the median glare depends on the subject's radiance relative to it: the inverse of
/// the limit is blended between the inverses of the three values. The median depends on white, because a Sun that is drawn as a point has a sprite whose size
/// does.
fn white_behind_glare(glare: &FrameGlare, subject_white: f64) -> f64 {
    let glare = glare.median(subject_white);
    // About the subject's mean radiance, relative to the glare.
    let subject_per_glare = subject_white * AUTO_EXPOSED_MEAN / glare;
    // Rises from 0 to 1 as the subject becomes fainter relative to the glare; 1/2 where its radiance divided by the glare's is `ratio`.
    let weight_below = |ratio: f64| 1.0 / (1.0 + (subject_per_glare / ratio).powi(2));
    let [bright, faint, lost] = MAX_MEDIAN_GLARE;
    let white_per_glare =
        bright.recip().lerp(faint.recip(), weight_below(1.0)) * 1.0_f64.lerp(faint / lost, weight_below(LOST_SUBJECT_RATIO));
    smooth_max([subject_white, glare * white_per_glare])
}

/// The exposure for a reading of the light meter. The glare limits each subject, not their mean: while the Moon covers the last of the Sun, the weight passes
/// from the Sun to the sky and the corona, which are at first lost in the glare. A mean of Sun and sky is brighter than the glare; limited as such a subject,
/// the exposure rose by some stops before the limit took effect.
fn from_reading(reading: &MeterReading) -> Exposure {
    let mut subjects = reading.subjects.clone();
    let contribution = |m: &MeteredSubject| m.weight.powi(WEIGHT_EXPONENT);
    let total_contribution: f64 = subjects.iter().map(contribution).sum();
    let share = |m: &MeteredSubject| contribution(m) / total_contribution;
    let mean_of = |white_of: &dyn Fn(&MeteredSubject) -> f64| subjects.iter().map(|m| share(m) * white_of(m).ln()).sum::<f64>().exp();
    let behind_glare = mean_of(&|m: &MeteredSubject| white_behind_glare(&reading.glare, m.white()));
    let night = darkest_white();
    let share_of_bodies: f64 = subjects.iter().filter(|m| m.is_of_bodies).map(share).sum();
    let unprotected = smooth_max([behind_glare, night]);
    let whites = Whites {
        subjects: mean_of(&MeteredSubject::white),
        behind_glare,
        night,
        highlights: unprotected * protective_stops(reading, unprotected, share_of_bodies).exp2(),
        sky: reading.least_white_for_sky,
    };
    // Not the smooth maximum: a sky that is not too bright changes nothing.
    let white = whites.highlights.max(whites.sky);
    subjects.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    Exposure::of(-white.log2(), reason_of(&subjects, share, &whites, white))
}

/// By how many stops the exposure is reduced to protect highlights. `white`: the radiance that would be white without this. `share_of_bodies`: of bodies in the
/// exposure, 0 to 1; in an image that is exposed for something else, such as the sky, their highlights count less.
fn protective_stops(reading: &MeterReading, white: f64, share_of_bodies: f64) -> f64 {
    let Some(radiance) = reading.highlights.radiance(white * AUTO_EXPOSED_MEAN) else { return 0.0 };
    let excess_stops = (radiance / (white * MAX_HIGHLIGHT_LEVEL)).log2().max(0.0);
    // Rises with the excess, so that an image never becomes brighter as a highlight grows.
    share_of_bodies * excess_stops / 1.0_f64.hypot(excess_stops / MAX_PROTECTIVE_STOPS)
}

/// The radiances that the parts of a frame require as white.
struct Whites {
    subjects: f64,
    /// What the subjects require behind the glare.
    behind_glare: f64,
    night: f64,
    /// What all of these and the highlights require.
    highlights: f64,
    /// The least that the sky around the camera allows.
    sky: f64,
}

/// Whether the light in the frame determines the exposure: not if the user has set it, nor in pixel views other than the final image.
pub(crate) fn is_metered(request: &ViewRequest) -> bool {
    !matches!(request.exposure, ExposureRequest::Stops(_)) && request.pixel_view == PixelView::Final
}

/// Bodies so near the camera that the frame may show nothing but their bright ground: the caller loads their maps and meters again. Empty if the light is not
/// metered. Only bodies with an albedo of the bare ground, as the Earth, whose deserts reflect eight times the mean of land and sea; elsewhere ground up to
/// twice as bright as the mean is not beyond white. Bodies with a shape model, whose maps are decoded in another way, are left out.
pub(crate) fn bright_grounds_to_meter(context: Context<'_>, camera: &Camera, placed: &[PlacedBody<'_>]) -> Vec<NaifId> {
    let request = context.request;
    let is_near = |p: &&PlacedBody<'_>| {
        let is_drawn = request.effects.override_of_body(p.body, Effect::Albedo) != Some(false);
        let has_map = p.body.mesh.is_none() && p.body.maps.albedo.as_ref().is_some_and(|m| !context.resources.is_unreadable(&m.file));
        p.body.clear_sky_albedo.is_some()
            && is_drawn
            && has_map
            && bright_ground_weight(p, &request.effects) > 0.0
            && p.outline.rect(camera).is_some()
    };
    placed.iter().filter(|_| is_metered(request)).filter(is_near).map(|p| p.body.id).collect()
}

/// Bodies in the frame whose city lights this exposure shows: the caller loads their maps and meters again with their light. Empty if the user has set the
/// exposure or switched the effect off, and in pixel views other than the final image.
pub(crate) fn night_lights_to_meter(context: Context<'_>, camera: &Camera, placed: &[PlacedBody<'_>], exposure: &Exposure) -> Vec<NaifId> {
    let request = context.request;
    let is_shown = |p: &&PlacedBody<'_>| {
        let is_drawn = request.effects.override_of_body(p.body, Effect::Night) != Some(false);
        let has_map = p.body.maps.night.as_ref().is_some_and(|m| !context.resources.is_unreadable(&m.file));
        let weight = city_light_weight(city_lights::drawn_white_radiance(p), (-exposure.metered_stops).exp2());
        is_drawn && has_map && weight > 0.0 && p.outline.rect(camera).is_some()
    };
    placed.iter().filter(|_| is_metered(request)).filter(is_shown).map(|p| p.body.id).collect()
}

/// The reason for a metered exposure: the main subject with its luminance and the level at which the image shows it; its target level, if that differs; and
/// what moves the exposure, in stops: other subjects, and a limit. `subjects`: the one with the greatest weight first; `share`: a subject's contribution to the
/// exposure, 0 to 1. `white`: the radiance that the image shows as white.
fn reason_of(subjects: &[MeteredSubject], share: impl Fn(&MeteredSubject) -> f64, whites: &Whites, white: f64) -> Reason {
    let Some(first) = subjects.first() else { return reason!("exposure-nothing") };
    let luminance_argument = |radiance: f64| rounded(radiance * CD_M2_PER_RADIANCE, 3, 0.01..1e4);
    let level_argument = |level: f64| rounded(level, 2, 0.001..1e3);
    // Without the sign of a rounded 0.
    let stops_argument = |stops: f64| Argument::Number(format!("{:+.2}", (100.0 * stops).round() / 100.0 + 0.0));
    let (subject, luminance) = (first.name.clone(), luminance_argument(first.drawn_radiance()));
    // As a fraction of white.
    let level = first.radiance / white;
    let drawn_level = level_argument(level * first.drawn_part);
    let main = if (level / first.target_level).log2().abs() > NAMED_STOPS {
        let target_level = level_argument(first.target_level * first.drawn_part);
        reason!("exposure-moved", subject = subject, luminance = luminance, level = drawn_level, aim = target_level)
    } else {
        reason!("exposure-metered", subject = subject, luminance = luminance, level = drawn_level)
    };
    let others = subjects.iter().skip(1).filter_map(|other| {
        let part = share(other);
        // Positive: this subject makes the image brighter.
        let moved_stops = part * (first.white() / other.white()).log2();
        (part > NAMED_SHARE || moved_stops.abs() > NAMED_STOPS).then(|| {
            let (luminance, percent) = (luminance_argument(other.drawn_radiance()), rounded(100.0 * part, 2, 0.01..1e3));
            let stops = stops_argument(moved_stops);
            reason!("exposure-second", part = percent, subject = other.name.clone(), luminance = luminance, stops = stops)
        })
    });
    // Negative: limits make the image darker.
    let limit_stops = (whites.subjects / white).log2();
    // What the limits add in turn: the glare, the night, the highlights. The greatest is named, with the sum.
    let unprotected = smooth_max([whites.behind_glare, whites.night]);
    let [by_glare, by_night, by_highlights] =
        [whites.behind_glare / whites.subjects, unprotected / whites.behind_glare, whites.highlights / unprotected];
    let limit = (limit_stops < -NAMED_STOPS).then(|| {
        let stops = stops_argument(limit_stops);
        if whites.sky >= white {
            reason!("exposure-sky", stops = stops)
        } else if by_highlights > by_glare.max(by_night) {
            reason!("exposure-highlights", stops = stops)
        } else if by_glare > by_night {
            reason!("exposure-glare", stops = stops)
        } else {
            reason!("exposure-night", ev = DARKEST_EV, stops = stops)
        }
    });
    [main].into_iter().chain(others).chain(limit).collect()
}

/// A number with `digits` significant digits; outside the range `plain` with an exponent and two digits.
fn rounded(number: f64, digits: i32, plain: Range<f64>) -> Argument {
    Argument::Number(if plain.contains(&number) { with_significant_digits(number, digits) } else { format!("{number:.1e}") })
}
