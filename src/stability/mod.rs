//! Stability at the extremes: sweeps where arithmetic and decisions are most likely to fail.
//!
//! In: a session and an effort. Out: for each sweep its number of cases, the worst result, its case and cause, and the bound that it must keep.
//! Always: every bound is in [`SWEEPS`] with its unit and reason; a sweep fails above it; the same seed gives the same cases. Most sweeps compare the
//! emitted modules in f32 with the same modules in f64; others compare whole pictures, or positions with another computation. Where the user demands the GPU it draws the
//! pictures in f32; the bounds are the software renderer's, and so are named values and figures of single quantities.

mod difference;
mod keys;
mod light;
mod moving;
mod needs;
mod pictures;
mod places;
mod views;

use crate::catalog::NaifId;
use crate::measure::{DualRenderer, Effort, LightPicture, PlannedView};
use crate::render::plan::{Plan, SamplingQuality};
use crate::render::software::Precision;
use crate::scene::request::{Purpose, ViewRequest};
use crate::session::{RendererPreference, Session, SessionError};
use crate::time::Instant;
use glam::DVec3;
use serde_json::Value;

/// The result of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepResult {
    /// Number of compared views, keys, points or steps.
    pub cases: usize,
    /// The worst result, in the sweep's unit.
    pub worst: f64,
    /// The case that gave it.
    pub location: Value,
    /// The first difference in that case: a named value of a module, a decision, a pixel.
    pub cause: String,
}

impl SweepResult {
    /// Before the first case.
    fn none() -> Self {
        Self { cases: 0, worst: 0.0, location: Value::Null, cause: String::new() }
    }

    /// Counts a case, and keeps it if it is the worst so far. NaN is worst of all.
    fn add(&mut self, figure: f64, describe: impl FnOnce() -> (Value, String)) {
        self.cases += 1;
        let figure = if figure.is_nan() { f64::INFINITY } else { figure };
        if figure > self.worst || self.cases == 1 {
            self.worst = figure;
            (self.location, self.cause) = describe();
        }
    }
}

/// A sweep: its name, its bound, and the function that runs it.
pub struct Sweep {
    /// The value of `--sweep`.
    pub name: &'static str,
    /// Unit of its result.
    pub unit: &'static str,
    /// Upper bound of the result in a short run.
    pub bound: f64,
    /// Upper bound in a full run, whose more extreme cases may be worse.
    pub full_bound: f64,
    /// Reason for the bounds.
    pub reason: &'static str,
    run: fn(&SweepBench<'_>) -> Result<SweepResult, SessionError>,
}

/// A sweep's name and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepReport {
    /// Name of the sweep.
    pub name: &'static str,
    /// Unit of `worst` and `bound`.
    pub unit: &'static str,
    /// Upper bound of the result.
    pub bound: f64,
    /// Reason for the bound.
    pub reason: &'static str,
    /// The result.
    pub found: SweepResult,
}

impl SweepReport {
    /// Whether the result exceeds the bound.
    pub fn has_failed(&self) -> bool {
        self.found.worst > self.bound
    }
}

/// Apparent direction of a body from the Earth's centre: of any length, ICRF.
pub(crate) type ApparentDirection = fn(&Session, NaifId, Instant) -> Result<DVec3, SessionError>;

/// Fault injection: tests use it to show that a sweep finds an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Changes each plan before it is drawn.
    pub plan: Option<fn(&mut Plan)>,
    /// Replaces the scene's directions of bodies.
    pub place: Option<ApparentDirection>,
    /// Purpose of the frames with chosen features, instead of linear light.
    pub purpose: Option<Purpose>,
}

/// The environment of a sweep.
pub struct SweepBench<'a> {
    dual: DualRenderer<'a>,
    effort: Effort,
    seed: u64,
    /// Number of random views, if given.
    views: Option<usize>,
    faults: Faults,
}

impl<'a> SweepBench<'a> {
    /// # Errors
    /// The threads of the renderers cannot be started.
    pub fn new(session: &'a Session, effort: Effort, seed: u64, faults: Faults) -> Result<Self, SessionError> {
        Ok(Self { dual: DualRenderer::new(session)?, effort, seed, views: None, faults })
    }

    /// The same with another number of random views; `None`: the effort's.
    #[must_use]
    pub(crate) fn with_views(self, views: Option<usize>) -> Self {
        Self { views, ..self }
    }

    fn session(&self) -> &'a Session {
        self.dual.session
    }

    /// The first value for a short effort, else the second.
    fn pick<T>(&self, short: T, full: T) -> T {
        if self.effort == Effort::Short { short } else { full }
    }

    /// A planned view, with the injected fault.
    fn plan_view(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<PlannedView, SessionError> {
        let mut view = self.dual.plan_view(request, sampling)?;
        if let Some(change) = self.faults.plan {
            change(&mut view.plan);
        }
        Ok(view)
    }

    /// The light of a view. In f32 it is the GPU's, if the session draws by one.
    fn light(&self, view: &PlannedView, precision: Precision) -> Result<LightPicture, SessionError> {
        if precision == Precision::F64 || !self.is_on_gpu() {
            return self.dual.light(view, precision);
        }
        let frame = self.session().draw_plan(&view.plan, true)?;
        Ok(LightPicture { width: frame.width, height: frame.height, light: frame.hdr, exposure_factor: view.scene.exposure.factor() })
    }

    /// The finished picture of a view, as [`Self::light`].
    fn display(&self, view: &PlannedView, precision: Precision) -> Result<Vec<[u8; 4]>, SessionError> {
        if precision == Precision::F64 || !self.is_on_gpu() {
            let (frame, _) = self.dual.renderer(precision).render(&view.plan, self.session().library(), false)?;
            return Ok(frame.display);
        }
        Ok(self.session().draw_plan(&view.plan, false)?.display)
    }

    /// Whether the user demands the GPU.
    fn is_on_gpu(&self) -> bool {
        self.session().renderers().1 == RendererPreference::Gpu
    }
}

/// One sample per pixel, as in draft pictures; eight taps.
const PLAIN: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };

/// An invisible half level of 255: the bound of f32 against f64.
const HALF_LEVEL: f64 = 0.5;

const fn sweep(
    name: &'static str,
    (bound, unit): (f64, &'static str),
    reason: &'static str,
    run: fn(&SweepBench<'_>) -> Result<SweepResult, SessionError>,
) -> Sweep {
    Sweep { name, unit, bound, full_bound: bound, reason, run }
}

impl Sweep {
    const fn in_full(self, full_bound: f64) -> Self {
        Self { full_bound, ..self }
    }
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
        (HALF_LEVEL, "255ths"),
        "half a level, from a metre above the ground to 100 au, from 1 arcsec to 170 degrees; in full 0.81 on Saturn's rings beside Pan",
        views::distance,
    )
    .in_full(1.0),
    sweep(
        "pairs",
        (1.0, "255ths"),
        "a level, in full 1.13, on rings behind a small moon that fills the frame from afar: f32 holds a place in them to 14 m",
        views::pairs,
    )
    .in_full(1.2),
    sweep(
        "grazing",
        (1.0, "255ths"),
        "a level, rays along the horizon, fields of view from 0.3 degrees: 0.6 on Saturn's rings, whose plane such a ray meets at a place of few digits",
        views::grazing,
    ),
    sweep("grazing-telescope", (HALF_LEVEL, "255ths"), "half a level, the same at 10 arcsec", views::grazing_telescope),
    sweep(
        "places",
        (HALF_LEVEL, "255ths"),
        "half a level at poles, date line, sub-solar and antisolar points, Sun on the horizon; in full 1.26 two metres over Mercury's pole",
        views::places,
    )
    .in_full(1.5),
    sweep("ring-plane", (HALF_LEVEL, "255ths"), "half a level, camera or Sun in the plane of the rings", views::ring_plane),
    sweep(
        "contacts",
        (HALF_LEVEL, "255ths"),
        "half a level, pictures at each contact of eclipses; in full 2.13 half a second from totality, of a thin crescent at a long exposure",
        views::contacts,
    )
    .in_full(2.5),
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
        (0.25, "% of views"),
        "some pixel differs by more than a level from the frame with every feature; goal 0, seven of 3000 views are left: docs/trade.md",
        needs::display,
    ),
    sweep("needs-linear", (0.0, "% of views"), "some pixel differs by more than 2e-3 of itself in none of 3000 views", needs::linear),
];

/// Runs one sweep.
///
/// # Errors
/// Why a case cannot be drawn.
pub fn run(sweep: &Sweep, bench: &SweepBench<'_>) -> Result<SweepReport, SessionError> {
    let found = (sweep.run)(bench)?;
    let bound = bench.pick(sweep.bound, sweep.full_bound);
    Ok(SweepReport { name: sweep.name, unit: sweep.unit, bound, reason: sweep.reason, found })
}
