//! Stability at the extremes: sweeps that draw, probe and place where arithmetic and decisions are most likely to break.
//!
//! In: a session and an effort. Out: for each sweep its number of cases, the worst figure, where it is and what caused it, beside the bound that it must keep.
//! Always: every bound stands in [`SWEEPS`] with its unit and reason; a sweep fails above it; the same seed gives the same cases. Most sweeps compare the
//! emitted modules in f32 with the same modules in f64; others compare whole pictures, or positions with another computation. Not done: sweeps on a GPU, whose pictures
//! tests/gpu/ holds against the software renderer's.

mod difference;
mod keys;
mod light;
mod moving;
mod needs;
mod pictures;
mod places;
mod views;

use crate::catalog::NaifId;
use crate::measure::{Effort, Studio};
use crate::render::plan::{Plan, SamplingQuality};
use crate::render::software::Precision;
use crate::scene::request::{Purpose, ViewRequest};
use crate::session::{Session, SessionError};
use crate::time::Instant;
use glam::DVec3;
use serde_json::Value;

/// What a sweep found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// How many views, keys, points or steps were compared.
    pub cases: usize,
    /// The worst figure, in the sweep's unit.
    pub worst: f64,
    /// The case that gave it.
    pub location: Value,
    /// What in that case is off first: a named value of a module, a decision, a pixel.
    pub cause: String,
}

impl Found {
    /// Of no case yet.
    fn none() -> Self {
        Self { cases: 0, worst: 0.0, location: Value::Null, cause: String::new() }
    }

    /// Counts a case; keeps it where it is the worst so far. What is not a number is the worst of all.
    fn add(&mut self, figure: f64, describe: impl FnOnce() -> (Value, String)) {
        self.cases += 1;
        let figure = if figure.is_nan() { f64::INFINITY } else { figure };
        if figure > self.worst || self.cases == 1 {
            self.worst = figure;
            (self.location, self.cause) = describe();
        }
    }
}

/// A sweep: what it is called, what its figure must not exceed, and how it runs.
pub struct Sweep {
    /// As `--sweep` has it.
    pub name: &'static str,
    /// Of its figure.
    pub unit: &'static str,
    /// What the figure must not exceed.
    pub bound: f64,
    /// Why the bound is what it is.
    pub reason: &'static str,
    run: fn(&SweepBench<'_>) -> Result<Found, SessionError>,
}

/// A sweep's name and what it found.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepReport {
    /// The sweep's.
    pub name: &'static str,
    /// Of `worst` and `bound`.
    pub unit: &'static str,
    /// What the figure must not exceed.
    pub bound: f64,
    /// Why the bound is what it is.
    pub reason: &'static str,
    /// The figure and its case.
    pub found: Found,
}

impl SweepReport {
    /// Whether the bound is broken.
    pub fn has_failed(&self) -> bool {
        self.found.worst > self.bound
    }
}

/// Where a body is seen from the Earth's centre: a direction of any length, ICRF.
pub type PlaceBody = fn(&Session, NaifId, Instant) -> Result<DVec3, SessionError>;

/// Faults that tests put in, to show that a sweep finds them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Changes each plan before it is drawn.
    pub plan: Option<fn(&mut Plan)>,
    /// Places bodies in place of the scene.
    pub place: Option<PlaceBody>,
    /// What the frames of chosen features are for, in place of linear light.
    pub purpose: Option<Purpose>,
}

/// What a sweep runs with.
pub struct SweepBench<'a> {
    studio: Studio<'a>,
    effort: Effort,
    seed: u64,
    /// Random views, where their number is set by hand.
    views: Option<usize>,
    faults: Faults,
}

impl<'a> SweepBench<'a> {
    /// # Errors
    /// No threads for the renderers.
    pub fn new(session: &'a Session, effort: Effort, seed: u64, faults: Faults) -> Result<Self, SessionError> {
        Ok(Self { studio: Studio::new(session)?, effort, seed, views: None, faults })
    }

    /// The same with another number of random views; `None`: as many as the effort has.
    #[must_use]
    pub fn with_views(self, views: Option<usize>) -> Self {
        Self { views, ..self }
    }

    fn session(&self) -> &'a Session {
        self.studio.session
    }

    /// One of two by the effort.
    fn pick<T>(&self, short: T, full: T) -> T {
        if self.effort == Effort::Short { short } else { full }
    }

    /// A planned view, with the fault that a test put in.
    fn planned(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<crate::measure::PlannedView, SessionError> {
        let mut view = self.studio.planned(request, sampling)?;
        if let Some(change) = self.faults.plan {
            change(&mut view.plan);
        }
        Ok(view)
    }

    fn light(&self, view: &crate::measure::PlannedView, precision: Precision) -> Result<crate::measure::LightPicture, SessionError> {
        self.studio.light(view, precision)
    }
}

/// One sample a pixel, as draft pictures have; eight taps.
const PLAIN: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };

/// Half a level of 255, which nobody sees: f32 against f64.
const HALF_LEVEL: f64 = 0.5;

const fn sweep(
    name: &'static str,
    (bound, unit): (f64, &'static str),
    reason: &'static str,
    run: fn(&SweepBench<'_>) -> Result<Found, SessionError>,
) -> Sweep {
    Sweep { name, unit, bound, reason, run }
}

/// Every sweep, with its bound.
pub const SWEEPS: [Sweep; 21] = [
    sweep("keys", (1.0 / 512.0, "of white"), "half a level of 256 before the sRGB curve; every covering key", keys::run),
    sweep(
        "simple",
        (2.0, "255ths"),
        "bytes of finished pictures may round apart by one; two in the refracted limb, whose faintest light is drawn since half a level counts",
        views::simple,
    ),
    sweep(
        "distance",
        (4.0, "255ths"),
        "from a metre above the ground to 100 au, from 1 arcsec to 170 degrees; half a level but for craters in a field of an arcsecond, probably because f32 knows a place on the ground to half a pixel there",
        views::distance,
    ),
    sweep(
        "pairs",
        (1.0, "255ths"),
        "a level: from afar and through narrow fields the rings behind a small moon are off by 0.64",
        views::pairs,
    ),
    sweep(
        "grazing",
        (2.0, "255ths"),
        "two levels where rings are seen edge on, rays along the horizon, fields of view from 0.3 degrees",
        views::grazing,
    ),
    sweep(
        "grazing-telescope",
        (8.0, "255ths"),
        "the same at 10 arcsec: differences of rays between pixels keep two digits in f32, 6.6 levels on the Moon's dark limb",
        views::grazing_telescope,
    ),
    sweep(
        "places",
        (3.0, "255ths"),
        "poles, date line, sub-solar and antisolar points, Sun on the horizon; half a level but for craters under a camera at a pole, whose cause is not found",
        views::places,
    ),
    sweep("ring-plane", (HALF_LEVEL, "255ths"), "half a level, camera or Sun in the plane of the rings", views::ring_plane),
    sweep("contacts", (HALF_LEVEL, "255ths"), "half a level, pictures at each contact of eclipses", views::contacts),
    sweep("radii", (HALF_LEVEL, "255ths"), "half a level, every body of the catalog", views::radii),
    sweep("years", (HALF_LEVEL, "255ths"), "half a level, years -3000 to 3000", views::years),
    sweep("sizes", (HALF_LEVEL, "255ths"), "half a level, bodies from a third of a pixel to more than the frame", views::sizes),
    sweep(
        "shadows",
        (5e-5, "of sunlight"),
        "f32 keeps five digits of the Sun's disc; 1 where an umbra is not 0 or full light not 1",
        light::shadows,
    ),
    sweep("umbra-exposure", (0.0, "255ths"), "an umbra is black at any exposure from -20 to +25 stops", light::umbra_exposure),
    sweep("light-time", (0.01, "arcsec"), "directions from the Earth's centre against bisection for the light's way", places::light_time),
    sweep("depth", (3.0, "255ths"), "f32 against f64, and 1 sample against 4, of bodies with layers at every distance", pictures::depth),
    sweep("motion", (2.0, "255ths"), "a step of less than a pixel moves light by less than a pixel", moving::motion),
    sweep("exposure", (1.0, "stops a step"), "automatic exposure through eclipses; 99 where a picture is black", moving::exposure),
    sweep(
        "scale",
        (4.0, "255ths, mean"),
        "eight times the pixels on a side, reduced; at 64 pixels the Earth's rim of air and its clouds' shadows are left out by size",
        pictures::scale,
    ),
    sweep(
        "needs-display",
        (8.0, "% of views"),
        "some pixel differs by more than a level from the frame with every feature; goal 0, left are rings: docs/trade.md",
        needs::display,
    ),
    sweep("needs-linear", (2.0, "% of views"), "some pixel differs by more than 2e-3 of itself; goal 0, see docs/trade.md", needs::linear),
];

/// Runs one sweep.
///
/// # Errors
/// Why a case cannot be drawn.
pub fn run(sweep: &Sweep, bench: &SweepBench<'_>) -> Result<SweepReport, SessionError> {
    let found = (sweep.run)(bench)?;
    Ok(SweepReport { name: sweep.name, unit: sweep.unit, bound: sweep.bound, reason: sweep.reason, found })
}
