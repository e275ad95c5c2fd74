//! Only what the scene needs: frames with chosen features against frames with every feature.
//!
//! In: random views. Out: the worst pixel, and the distribution over views. Always: both frames have one exposure; "every feature" is each effect switched on
//! by hand, in the model that the scene would take.

use super::random::Random;
use super::{Found, PLAIN, SweepBench};
use crate::measure::{PlannedView, quantile};
use crate::render::software::Precision;
use crate::scene::effects::Effect;
use crate::scene::request::{Layers, Position, Purpose, ViewRequest};
use crate::session::SessionError;
use crate::time::Instant;
use serde_json::{Value, json};

/// Effects that say how a body is shown and not what light reaches the pixel: they are left to the scene in both frames.
const LEFT_ALONE: [Effect; 3] = [Effect::Points, Effect::Mesh, Effect::Overlays];

struct RandomView {
    location: Value,
    request: ViewRequest,
}

/// A body, a distance in even parts of its logarithm, a direction, an instant of two centuries.
fn views(bench: &SweepBench<'_>, count: usize) -> Vec<RandomView> {
    let mut random = Random::new(bench.seed);
    let bodies = bench.session().catalog().bodies();
    // Every other view looks at a body with air, rings or moons: that is where features are.
    let rich = ["earth", "saturn", "jupiter", "mars", "moon", "titan", "uranus", "io"];
    let rich: Vec<_> = rich.iter().filter_map(|n| bench.session().catalog().named(n).ok()).collect();
    let view = |k: usize| {
        let body = if k % 2 == 0 { *random.of(&rich) } else { random.of(bodies) };
        let time = Instant::from_jd_tdb(random.between(2_415_100.0, 2_488_000.0));
        let distance_radii = 10.0_f64.powf(random.between(0.05, 4.0));
        let direction = random.direction();
        let half = (1.0 / distance_radii).asin().tan() * 10.0_f64.powf(random.between(-0.3, 1.0));
        let request = ViewRequest {
            position: Position::Offset {
                body: body.id,
                offset_km: direction * distance_radii * body.radii_km.max_element(),
                axes: crate::scene::request::Axes::Icrf,
            },
            fov_deg: Some((2.0 * half.atan().to_degrees()).clamp(1e-6, 150.0)),
            width: 32,
            height: 32,
            layers: Layers { stars: false, ..Layers::default() },
            ..ViewRequest::of(body.id, time)
        };
        let location = json!({
            "seed": bench.seed, "view": k, "body": body.name, "time": time.to_utc_iso(), "distance_radii": distance_radii,
            "direction": direction.to_array(), "fov_deg": request.fov_deg,
        });
        RandomView { location, request }
    };
    (0..count).map(view).collect()
}

/// Both frames of a view.
struct Frames {
    chosen: PlannedView,
    all: PlannedView,
}

fn frames(bench: &SweepBench<'_>, request: &ViewRequest, purpose: Purpose) -> Result<Frames, SessionError> {
    let exposed = bench.studio.exposed(ViewRequest { purpose, ..request.clone() })?;
    let mut everything = exposed.clone();
    for effect in Effect::ALL.into_iter().filter(|e| !LEFT_ALONE.contains(e)) {
        everything.effects.set(effect, true);
    }
    let chosen = ViewRequest { purpose: bench.faults.purpose.unwrap_or(purpose), ..exposed };
    Ok(Frames { chosen: bench.planned(&chosen, PLAIN)?, all: bench.planned(&everything, PLAIN)? })
}

/// What the frame with everything has on and the chosen one has not, for the view's target.
fn left_out(frames: &Frames, request: &ViewRequest) -> String {
    let on = |view: &PlannedView| -> Vec<&'static str> {
        let target = request.target.and_then(|id| view.scene.body(id));
        target.map_or(Vec::new(), |b| b.decisions.iter().filter(|d| d.on).map(|d| d.feature).collect())
    };
    let chosen = on(&frames.chosen);
    let missing: Vec<_> = on(&frames.all).into_iter().filter(|f| !chosen.contains(f)).collect();
    if missing.is_empty() { "the target lacks no feature: another body's".to_owned() } else { format!("left out: {}", missing.join(", ")) }
}

fn swept(bench: &SweepBench<'_>, purpose: Purpose, figure: impl Fn(&Frames) -> Result<f64, SessionError>) -> Result<Found, SessionError> {
    let mut found = Found::none();
    let mut figures = Vec::new();
    for RandomView { location, request } in views(bench, bench.pick(160, 3000)) {
        let Ok(frames) = frames(bench, &request, purpose) else { continue };
        let worst = figure(&frames)?;
        figures.push(worst);
        found.add(worst, || (location, left_out(&frames, &request)));
    }
    figures.sort_by(f64::total_cmp);
    let at = |part: f64| quantile(&figures, part).unwrap_or(0.0);
    let distribution = format!("over views: median {:.2e}, 90 % {:.2e}, 99 % {:.2e}, all {:.2e}", at(0.5), at(0.9), at(0.99), at(1.0));
    found.cause = format!("{}; {distribution}", found.cause);
    Ok(found)
}

/// Bytes of the display.
pub(super) fn display(bench: &SweepBench<'_>) -> Result<Found, SessionError> {
    swept(bench, Purpose::Display, |frames| {
        let bytes = |view: &PlannedView| {
            bench.studio.renderer(Precision::F32).render(&view.plan, bench.session().library(), false).map(|(frame, _)| frame.display)
        };
        let (chosen, all) = (bytes(&frames.chosen)?, bytes(&frames.all)?);
        Ok(chosen.iter().zip(&all).flat_map(|(a, b)| (0..3).map(move |c| f64::from(a[c].abs_diff(b[c])))).fold(0.0, f64::max))
    })
}

/// A pixel's light over that of the frame with everything; pixels below a millionth of the brightest are left to rounding.
pub(super) fn linear(bench: &SweepBench<'_>) -> Result<Found, SessionError> {
    swept(bench, Purpose::LINEAR, |frames| {
        let (chosen, all) = (bench.light(&frames.chosen, Precision::F32)?, bench.light(&frames.all, Precision::F32)?);
        let brightest = all.light.iter().flat_map(|p| p[..3].iter()).fold(0.0_f32, |a, b| a.max(*b));
        let part = |a: &[f32; 4], b: &[f32; 4]| {
            let whole = b[..3].iter().fold(0.0_f32, |a, b| a.max(*b));
            let apart = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
            if whole > 1e-6 * brightest { f64::from(apart / whole) } else { 0.0 }
        };
        Ok(chosen.light.iter().zip(&all.light).map(|(a, b)| part(a, b)).fold(0.0, f64::max))
    })
}
