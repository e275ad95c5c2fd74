//! The sweeps of `stability` detect faults: each fault of the past, injected again, exceeds the bound of a sweep that passes without it.

use crate::support::session::{SESSION, session_with_edits};
use crate::support::sweep;
use orrery::catalog::NaifId;
use orrery::measure::Effort;
use orrery::render::plan::{DepthState, Plan};
use orrery::scene::request::Purpose;
use orrery::session::{Session, SessionError};
use orrery::stability::{InjectedFaults, SWEEPS, SweepReport, SweepResult, SweepSetup, run};
use orrery::time::Instant;

fn swept(session: &Session, name: &str, faults: InjectedFaults) -> SweepReport {
    let sweep = SWEEPS.iter().find(|s| s.name == name).unwrap_or_else(|| panic!("no sweep {name}"));
    let setup = SweepSetup::new(session, Effort::Short, 1, faults).expect("a setup");
    let report = run(sweep, &setup).unwrap_or_else(|e| panic!("{name}: {e}"));
    println!(
        "{name}: {} cases, {:e} of {:e} {}, {}",
        report.result.cases, report.result.worst, report.bound, report.result.worst_case, report.result.cause
    );
    report
}

/// Where the entire Sun is covered, rounding leaves a remainder in the closed form of the overlap. Without the early return and the clamps, the light in
/// an umbra would not be 0.
#[test]
fn shadows_are_stable_and_a_missing_clamp_in_an_umbra_is_detected() {
    assert!(!swept(&SESSION, "shadows", InjectedFaults::default()).has_failed());
    let obscuration = "lib/eclipse/obscuration.wesl";
    let unclamped = session_with_edits(&[
        ("lib/eclipse/disc_overlap.wesl", "    if overhang <= 0.0 {\n        return WHOLE_SUN;\n    }\n", ""),
        (obscuration, "let covers_centre = is_circular && circle.x >= 1.0 && circle.y < circle.x;", "let covers_centre = false;"),
        (obscuration, "parts.visible = max(WHOLE_SUN - parts.hidden, vec3f(0.0));", "parts.visible = WHOLE_SUN - parts.hidden;"),
        (
            obscuration,
            "return clamp(select(1.0 - hidden / whole, visible / whole, parts.visible.x < parts.hidden.x), vec3f(0.0), vec3f(1.0));",
            "return select(1.0 - hidden / whole, visible / whole, parts.visible.x < parts.hidden.x);",
        ),
    ]);
    assert!(swept(&unclamped, "shadows", InjectedFaults::default()).has_failed());
}

#[test]
fn an_angle_from_the_arc_cosine_of_a_dot_product_is_detected() {
    let by_cosine = session_with_edits(&[(
        "lib/eclipse/occluders.wesl",
        "    outline.semi_axes = select(shape.zw * scale",
        "    let towards = normalize(vec3f(outline.centre / draw.eclipse_perpendicular_axes[0].w, 1.0));
    let angle = acos(min(dot(towards, vec3f(0.0, 0.0, 1.0)), 1.0));
    outline.centre = normalize(outline.centre + vec2f(1.0e-12)) * tan(angle) * draw.eclipse_perpendicular_axes[0].w;
    outline.semi_axes = select(shape.zw * scale",
    )]);
    let report = swept(&by_cosine, "shadows", InjectedFaults::default());
    assert!(report.has_failed());
}

/// If no view can be planned, the sweep has shown nothing.
#[test]
fn a_sweep_without_a_case_fails() {
    let kept = swept(&SESSION, "umbra-exposure", InjectedFaults::default());
    assert!(!kept.has_failed());
    let without_case = SweepReport { result: SweepResult { cases: 0, ..kept.result.clone() }, ..kept };
    assert!(without_case.has_failed());
}

/// The sweep `sizes` also draws bodies without rings. If it skipped the views of Saturn, it would keep its bound.
#[test]
fn a_module_that_cannot_be_compiled_ends_a_sweep() {
    let broken = session_with_edits(&[("lib/ring/photometry.wesl", "fn ring_reflectance(", "fn 0ring_reflectance(")]);
    let setup = SweepSetup::new(&broken, Effort::Short, 1, InjectedFaults::default()).expect("a setup");
    let sizes = SWEEPS.iter().find(|s| s.name == "sizes").expect("the sweep");
    let error = run(sizes, &setup).expect_err("a module does not compile").to_string();
    assert!(error.contains("ring"), "{error}");
}

#[test]
fn an_umbra_is_black_at_every_exposure() {
    let report = swept(&SESSION, "umbra-exposure", InjectedFaults::default());
    assert!(!report.has_failed() && report.result.cases >= 30);
}

#[test]
fn missing_light_time_is_detected() {
    fn geometric(session: &Session, body: NaifId, time: Instant) -> Result<glam::DVec3, SessionError> {
        Ok(session.ephemeris().state(body, NaifId::EARTH, time, None)?.state.pos_km)
    }
    assert!(!swept(&SESSION, "light-time", InjectedFaults::default()).has_failed());
    let report = swept(&SESSION, "light-time", InjectedFaults { apparent_direction: Some(geometric), ..InjectedFaults::default() });
    assert!(report.has_failed() && report.result.worst > 20.0, "aberration alone is 20 arcseconds");
}

#[test]
fn a_body_without_a_direction_is_detected() {
    fn nowhere(_: &Session, _: NaifId, _: Instant) -> Result<glam::DVec3, SessionError> {
        Ok(glam::DVec3::ZERO)
    }
    assert!(swept(&SESSION, "light-time", InjectedFaults { apparent_direction: Some(nowhere), ..InjectedFaults::default() }).has_failed());
}

#[test]
fn clouds_with_depth_conflicts_are_detected() {
    fn write_depth(plan: &mut Plan) {
        for draw in plan.passes.iter_mut().flat_map(|p| &mut p.draws).filter(|d| d.label.ends_with("clouds")) {
            draw.depth = DepthState { test: true, write: true };
        }
    }
    assert!(!swept(&SESSION, "depth", InjectedFaults::default()).has_failed());
    assert!(swept(&SESSION, "depth", InjectedFaults { change_plan: Some(write_depth), ..InjectedFaults::default() }).has_failed());
}

#[test]
fn an_effect_that_is_left_out_too_long_is_detected() {
    assert!(!sweep::in_full() || !swept(&SESSION, "needs-linear", InjectedFaults::default()).has_failed());
    // An effect is drawn only if it changes half of the light, instead of a thousandth.
    let coarse = Purpose::Linear { floor: 0.5 };
    assert!(swept(&SESSION, "needs-linear", InjectedFaults { purpose: Some(coarse), ..InjectedFaults::default() }).has_failed());
}

/// The sweeps that no test above runs, with the cases of `orrery stability --short`.
#[test]
fn every_other_sweep_keeps_its_bound() {
    let tested_above = ["shadows", "umbra-exposure", "light-time", "depth", "needs-linear"];
    let failed: Vec<String> = SWEEPS
        .iter()
        .filter(|s| !tested_above.contains(&s.name) || !sweep::in_full() && s.name == "needs-linear")
        .enumerate()
        .filter(|(k, _)| sweep::runs(*k, 4))
        .map(|(_, s)| s)
        .map(|s| swept(&SESSION, s.name, InjectedFaults::default()))
        .filter(SweepReport::has_failed)
        .map(|r| format!("{}: {:e} of {:e} at {}: {}", r.name, r.result.worst, r.bound, r.result.worst_case, r.result.cause))
        .collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
