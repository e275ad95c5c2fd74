//! Whether omitted effects are invisible: compares two frames of a view. One has the effects that the scene chooses ("chosen"), the other every effect ("all").
//!
//! In: random views. Out: the percentage of views in which some pixel differs by more than the stated bound, and the distributions of two quantities over the
//! views: the greatest difference, and the number of shader operations of the chosen frame divided by that of the frame with every effect. For each of the
//! worst views above the bound, at most [`MAX_EXPLAINED`], the result contains the omitted effect, the pixel, and the pixel's values in both frames and in the
//! true frame. These values show which of the two frames is wrong. The true frame has every effect, in f64, at [`TRUTH_SCALE`] times the width and height.
//! Always: both frames have the same exposure; "every effect" means that each effect but [`UNCHANGED_EFFECTS`] is switched on by hand.

use super::difference::worst_of;
use super::{SINGLE_SAMPLE, SweepResult, SweepSetup, if_possible};
use crate::image::levels::display_level;
use crate::measure::{LinearImage, PlannedView, quantile};
use crate::random::Random;
use crate::render::plan;
use crate::render::software::Precision;
use crate::scene::draw::{BodyShadow, RingShadow};
use crate::scene::effects::Effect;
use crate::scene::request::{Layers, Position, Purpose, ViewRequest};
use crate::session::{SessionError, tape_costs};
use crate::shader::ModuleId;
use crate::time::Instant;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Bound of the sweep for displays: one level of 255.
const DISPLAY_BOUND: f64 = 1.0;
/// Bound of the sweep for linear light, relative to the pixel's radiance: a thousandth for each omitted effect, with two effects at a pixel.
const LINEAR_BOUND: f64 = 2e-3;

/// Effects that are not switched on by hand, so that the scene chooses them in both frames. Points and meshes set how a body is represented and not its
/// radiance. No body of the shipped catalogs has overlays. The scene omits the corona beside the disc of a Sun of less than a pixel, however bright the corona
/// is.
const UNCHANGED_EFFECTS: [Effect; 4] = [Effect::Points, Effect::Mesh, Effect::Overlays, Effect::Corona];

/// A view, and what identifies it.
struct RandomView {
    case: Value,
    request: ViewRequest,
}

/// Random views: a body, a distance and a field of view (log-uniform), a direction, and an instant from 1900 to 2099.
fn views(setup: &SweepSetup<'_>, count: usize) -> Vec<RandomView> {
    let mut random = Random::new(setup.seed);
    let bodies = setup.session().catalog().bodies();
    // Half of the views look at these bodies, most of which have an atmosphere, rings or an eclipsing neighbour, and so the most effects.
    let effect_rich = ["earth", "saturn", "jupiter", "mars", "moon", "titan", "uranus", "io"];
    let effect_rich: Vec<_> = effect_rich.iter().filter_map(|n| setup.session().catalog().body_named(n).ok()).collect();
    let view = |k: usize| {
        let body = if k.is_multiple_of(2) { *random.choose(&effect_rich) } else { random.choose(bodies) };
        let time = Instant::from_jd_tdb(random.between(2_415_100.0, 2_488_000.0));
        // From 1.1 to 10,000 radii.
        let distance_radii = 10.0_f64.powf(random.between(0.05, 4.0));
        let direction = random.direction();
        // The disc's diameter is between a tenth of the frame's side and twice that side, where the limits of the field of view do not apply.
        let half_fov_tan = (1.0 / distance_radii).asin().tan() * 10.0_f64.powf(random.between(-0.3, 1.0));
        let request = ViewRequest {
            position: Position::Offset {
                body: body.id,
                offset_km: direction * distance_radii * body.radii_km.max_element(),
                axes: crate::scene::request::Axes::Icrf,
            },
            fov_deg: Some((2.0 * half_fov_tan.atan().to_degrees()).clamp(1e-6, 150.0)),
            width: 32,
            height: 32,
            layers: Layers { stars: false, ..Layers::default() },
            ..ViewRequest::of(body.id, time)
        };
        let case = json!({
            "seed": setup.seed, "view": k, "body": body.name, "time": time.to_utc_iso(), "distance_radii": distance_radii,
            "direction": direction.to_array(), "fov_deg": request.fov_deg,
        });
        RandomView { case, request }
    };
    (0..count).map(view).collect()
}

/// Both frames of a view.
struct FramePair {
    /// With the effects that the scene chooses.
    chosen: PlannedView,
    /// With the effects passed to [`frame_pair`] in addition.
    with_effects: PlannedView,
}

/// The frame with the effects that the scene chooses, and the frame with `effects` switched on in addition. Both use the models of ring and body shadows that
/// the scene chooses, because a difference between two models is not due to an omitted effect.
fn frame_pair(setup: &SweepSetup<'_>, request: &ViewRequest, purpose: Purpose, effects: &[Effect]) -> Result<FramePair, SessionError> {
    let exposed = setup.renderers.with_metered_exposure(ViewRequest { purpose, ..request.clone() })?;
    let mut request_with_effects = exposed.clone();
    for effect in effects.iter().filter(|e| !UNCHANGED_EFFECTS.contains(e)) {
        request_with_effects.effects.set(*effect, true);
    }
    let chosen = setup.plan_view(&ViewRequest { purpose: setup.injected_faults.purpose.unwrap_or(purpose), ..exposed }, SINGLE_SAMPLE)?;
    let mut scene = setup.plan_view(&request_with_effects, SINGLE_SAMPLE)?.scene;
    for draw in &mut scene.draws {
        let Some(chosen_draw) = chosen.scene.draws.iter().find(|c| c.body == draw.body && c.part == draw.part) else { continue };
        let chosen_features = chosen_draw.features;
        let features = &mut draw.features;
        if chosen_features.ring_shadow != RingShadow::None && features.ring_shadow != RingShadow::None {
            features.ring_shadow = chosen_features.ring_shadow;
        }
        if chosen_features.body_shadow != BodyShadow::None && features.body_shadow != BodyShadow::None {
            features.body_shadow = chosen_features.body_shadow;
        }
        // The thin limb is a filter and not an effect. The scene leaves it out of draws with eclipses or detail. The draw of the sky has only the uniform, by
        // which it covers what the ground's draw leaves uncovered.
        features.thin_limb = chosen_features.thin_limb;
        draw.uniforms.averaged_part = chosen_draw.uniforms.averaged_part;
    }
    let plan = plan::plan(&scene, setup.session(), SINGLE_SAMPLE)?;
    Ok(FramePair { chosen, with_effects: PlannedView { scene, plan } })
}

/// Factor from the width and the height of the two frames to those of the true frame.
const TRUTH_SCALE: u32 = 8;

/// The worst pixel of two frames: the difference, and the pixel's index.
#[derive(Clone, Copy)]
struct WorstPixel {
    difference: f64,
    index: usize,
}

impl WorstPixel {
    fn of(differences: impl Iterator<Item = f64>) -> Self {
        let (index, difference) = worst_of(&differences.collect::<Vec<_>>());
        Self { difference, index }
    }
}

/// A measure of the difference of two frames.
type DifferenceMeasure<'a> = &'a dyn Fn(&FramePair) -> Result<WorstPixel, SessionError>;

/// A pixel as JSON: its coordinates, and its radiance and display level per channel in both frames and in the true frame.
fn values_at(setup: &SweepSetup<'_>, request: &ViewRequest, purpose: Purpose, pixel_index: usize) -> Result<Value, SessionError> {
    let frames = frame_pair(setup, request, purpose, &Effect::ALL)?;
    let radiance_at = |image: &LinearImage| image.light.get(pixel_index).map(|p| [p[0], p[1], p[2]]);
    let levels_at = |image: &LinearImage| radiance_at(image).map(|p| p.map(|v| display_level(v, image.exposure_factor)));
    let exposed = setup.renderers.with_metered_exposure(ViewRequest { purpose, ..request.clone() })?;
    let finer = ViewRequest { width: request.width * TRUTH_SCALE, height: request.height * TRUTH_SCALE, ..exposed };
    let true_view = frame_pair(setup, &finer, purpose, &Effect::ALL)?.with_effects;
    let truth = setup.draw_linear(&true_view, Precision::F64)?.downsampled(TRUTH_SCALE);
    let [chosen, all] = [setup.draw_linear(&frames.chosen, Precision::F32)?, setup.draw_linear(&frames.with_effects, Precision::F32)?];
    Ok(json!({
        "pixel": [pixel_index as u32 % request.width, pixel_index as u32 / request.width],
        "levels": { "chosen": levels_at(&chosen), "all": levels_at(&all), "true": levels_at(&truth) },
        "radiance": { "chosen": radiance_at(&chosen), "all": radiance_at(&all), "true": radiance_at(&truth) },
    }))
}

/// The greatest difference that one effect makes when it alone is switched on in the chosen frame, and that effect's name; 0 and "several
/// together" if none makes any difference alone.
fn worst_omission(
    setup: &SweepSetup<'_>,
    request: &ViewRequest,
    purpose: Purpose,
    difference: DifferenceMeasure<'_>,
) -> Result<(f64, &'static str), SessionError> {
    let (mut greatest, mut name) = (0.0, "several together");
    for effect in Effect::ALL.into_iter().filter(|e| !UNCHANGED_EFFECTS.contains(e)) {
        let difference_alone = difference(&frame_pair(setup, request, purpose, &[effect])?)?.difference;
        if difference_alone > greatest {
            (greatest, name) = (difference_alone, effect.name());
        }
    }
    Ok((greatest, name))
}

/// Largest number of views, worst first, for which the omitted effect is determined.
const MAX_EXPLAINED: usize = 16;

/// Compares the frames of random views. The result is the percentage of views with a difference above `bound`, which has the unit of `difference`.
fn sweep_views(
    setup: &SweepSetup<'_>,
    purpose: Purpose,
    bound: f64,
    difference: DifferenceMeasure<'_>,
) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let (mut results, mut cost_ratios) = (Vec::new(), Vec::new());
    for RandomView { case, request } in views(setup, setup.view_count.unwrap_or(setup.short_or_full(160, 3000))) {
        let Some(pair) = if_possible(frame_pair(setup, &request, purpose, &Effect::ALL))? else { continue };
        let worst = difference(&pair)?;
        found.add(worst.difference, || (case.clone(), String::new()));
        results.push((worst, request, case));
        let [chosen, all] = [operations(setup, &pair.chosen), operations(setup, &pair.with_effects)];
        cost_ratios.extend((all > 0.0).then_some(chosen / all));
    }
    if results.is_empty() {
        return Ok(found);
    }
    results.sort_by(|(a, ..), (b, ..)| b.difference.total_cmp(&a.difference));
    // For each effect, the number of explained views in which it makes the greatest difference alone, and the greatest of these differences.
    let mut omitted: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
    let mut explained = Vec::new();
    for (worst, request, case) in results.iter().take_while(|(worst, ..)| worst.difference > bound).take(MAX_EXPLAINED) {
        let (difference_alone, effect) = worst_omission(setup, request, purpose, difference)?;
        let mut case = case.clone();
        case["apart"] = json!(worst.difference);
        case["lacks"] = json!(effect);
        case["values"] = values_at(setup, request, purpose, worst.index)?;
        explained.push(case);
        let (view_count, max_difference) = omitted.entry(effect).or_default();
        *view_count += 1;
        *max_difference = max_difference.max(difference_alone);
    }
    if !explained.is_empty() {
        found.worst_case = Value::Array(explained);
    }
    let named = omitted.iter().map(|(effect, (views, max))| format!("{effect} in {views} (up to {max:.2e})")).collect::<Vec<_>>();
    let explained_count = omitted.values().map(|(views, _)| views).sum::<usize>();
    let over_bound = results.iter().filter(|(worst, ..)| worst.difference > bound).count();
    let mut differences: Vec<f64> = results.iter().map(|(worst, ..)| worst.difference).collect();
    differences.sort_by(f64::total_cmp);
    cost_ratios.sort_by(f64::total_cmp);
    let quantile_of = |sorted: &[f64], fraction: f64| quantile(sorted, fraction).unwrap_or(0.0);
    found.cause = format!(
        "{over_bound} views over {bound:e}; the worst {explained_count} by the effect that makes the greatest difference: {}; differences over all views: median {:.2e}, 90 % {:.2e}, 99 % {:.2e}, worst {:.2e}; operations relative to those \
         with every effect: least {:.2}, 10 % {:.2}, median {:.2}, 90 % {:.2}",
        if named.is_empty() { "none".to_owned() } else { named.join(", ") },
        quantile_of(&differences, 0.5),
        quantile_of(&differences, 0.9),
        quantile_of(&differences, 0.99),
        quantile_of(&differences, 1.0),
        quantile_of(&cost_ratios, 0.0),
        quantile_of(&cost_ratios, 0.1),
        quantile_of(&cost_ratios, 0.5),
        quantile_of(&cost_ratios, 0.9),
    );
    // The result of the sweep is this percentage, not the greatest difference, which `add` has stored.
    found.worst = 100.0 * over_bound as f64 / differences.len().max(1) as f64;
    Ok(found)
}

/// Operations of the draws of a view's bodies: pixels of each draw's rectangle times the operations of its fragment stage, loops counted once.
fn operations(setup: &SweepSetup<'_>, view: &PlannedView) -> f64 {
    let fragment_operations = |id: &ModuleId| {
        let tapes = setup.session().library().get(id).ok().and_then(|module| tape_costs(&module).ok()).unwrap_or_default();
        tapes.iter().filter(|t| t.stage == "fragment").flat_map(|t| t.operations.values()).sum::<usize>() as f64
    };
    let bodies = view.plan.passes.iter().flat_map(|p| &p.draws).filter(|d| matches!(d.module, ModuleId::Keyed(_)));
    let pixels = |[left, top, right, bottom]: [u32; 4]| f64::from(right.saturating_sub(left)) * f64::from(bottom.saturating_sub(top));
    bodies.map(|draw| pixels(draw.scissor) * fragment_operations(&draw.module)).sum()
}

/// The sweep for displays, by the difference of display bytes.
pub(super) fn display(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    sweep_views(setup, Purpose::Display, DISPLAY_BOUND, &|pair| {
        let (chosen, with_effects) =
            (setup.draw_display(&pair.chosen, Precision::F32)?, setup.draw_display(&pair.with_effects, Precision::F32)?);
        let difference = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).fold(0.0, f64::max);
        Ok(WorstPixel::of(chosen.iter().zip(&with_effects).map(difference)))
    })
}

/// The sweep for linear light, by the difference relative to the pixel's radiance. Pixels below a millionth of the brightest in both frames are ignored,
/// because rounding dominates there.
pub(super) fn linear(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    sweep_views(setup, Purpose::LINEAR, LINEAR_BOUND, &|pair| {
        let (chosen, with_effects) =
            (setup.draw_linear(&pair.chosen, Precision::F32)?, setup.draw_linear(&pair.with_effects, Precision::F32)?);
        let brightest = with_effects.light.iter().flat_map(|p| p[..3].iter()).fold(0.0_f32, |a, b| a.max(*b));
        Ok(WorstPixel::of(chosen.light.iter().zip(&with_effects.light).map(|(a, b)| relative_difference(a, b, brightest))))
    })
}

/// Greatest difference of any channel, relative to the pixel's radiance in the frame in which it is brighter: an omitted shadow may leave light where the frame
/// with every effect has none. 0 if both radiances are at most a millionth of `brightest`. Infinite if a value of either frame is not finite: `f32::max` would
/// ignore NaN.
fn relative_difference(chosen: &[f32; 4], all: &[f32; 4], brightest: f32) -> f64 {
    if chosen[..3].iter().chain(&all[..3]).any(|v| !v.is_finite()) {
        return f64::INFINITY;
    }
    let radiance = chosen[..3].iter().chain(&all[..3]).fold(0.0_f32, |a, b| a.max(*b));
    let difference = (0..3).map(|c| (chosen[c] - all[c]).abs()).fold(0.0, f32::max);
    if radiance > 1e-6 * brightest { f64::from(difference / radiance) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_that_is_not_finite_differs() {
        let grey = [0.5, 0.5, 0.5, 1.0];
        assert_eq!(relative_difference(&grey, &grey, 1.0), 0.0);
        assert_eq!(relative_difference(&[0.5, 0.25, 0.5, 1.0], &grey, 1.0), 0.5);
        let black = [0.0, 0.0, 0.0, 1.0];
        assert_eq!(relative_difference(&black, &grey, 1e9), 0.0, "too faint beside the brightest pixel");
        assert_eq!(relative_difference(&grey, &black, 1.0), 1.0, "light in an umbra that the scene omits");
        for broken in [f32::NAN, f32::INFINITY] {
            let broken = [0.5, broken, 0.5, 1.0];
            assert_eq!(relative_difference(&broken, &grey, 1.0), f64::INFINITY);
            assert_eq!(relative_difference(&grey, &broken, 1.0), f64::INFINITY);
        }
    }
}
