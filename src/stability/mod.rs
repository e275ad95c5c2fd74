//! Numerical stability in extreme cases: sweeps over views and inputs for which rounding, or the choice of effects, is most likely to cause visible errors.
//!
//! In: a session and an effort. Out: for each sweep the number of cases, the worst result, its case and cause, and the bound that it must
//! keep. Always: every bound is in [`SWEEPS`] with its unit and reason; a sweep fails above its bound, or without a case; the same seed gives the same cases.
//! Most sweeps compare the emitted modules in f32 with the same modules in f64; others compare complete images, or positions with another
//! computation. If the user requests the GPU, it draws the f32 images, and the bounds for a GPU apply; named values of modules, the answers of
//! probes and the images of `umbra-exposure` are always those of the software renderer.

mod difference;
mod images;
mod keys;
mod light;
mod light_time;
mod moving;
mod omitted_effects;
mod views;

use crate::catalog::NaifId;
use crate::measure::{Effort, LinearImage, PlannedView, PrecisionRenderers, SINGLE_SAMPLE};
use crate::render::frame::Frame;
use crate::render::plan::{FrameImages, Plan, SamplingQuality};
use crate::render::software::{Precision, SoftwareRenderer};
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
    /// What identifies the case with the worst result. The sweeps `needs-display` and `needs-linear` list the worst views above their bound.
    pub worst_case: Value,
    /// The first difference in the worst case: a named value of a module, a decision, a pixel. The sweeps `needs-display` and `needs-linear` give statistics
    /// over all views instead.
    pub cause: String,
}

impl SweepResult {
    /// An empty result, before the first case.
    fn empty() -> Self {
        Self { cases: 0, worst: 0.0, worst_case: Value::Null, cause: "every case was skipped, so nothing was compared".into() }
    }

    /// Counts a case, and keeps it if it is the worst so far. `result`: in the sweep's unit; the greatest is the worst, and NaN counts as infinite. `describe`:
    /// what identifies the case, and the cause.
    fn add(&mut self, result: f64, describe: impl FnOnce() -> (Value, String)) {
        self.cases += 1;
        let result = if result.is_nan() { f64::INFINITY } else { result };
        // The first case is kept even if its result is 0.
        if result > self.worst || self.cases == 1 {
            self.worst = result;
            (self.worst_case, self.cause) = describe();
        }
    }
}

/// A sweep: its name, its bound, and the function that runs it.
pub struct Sweep {
    /// The value of `--sweep`.
    pub name: &'static str,
    /// Unit of the result.
    pub unit: &'static str,
    /// Upper bound of the result in a short run.
    pub bound: f64,
    /// Upper bound in a full run, whose more extreme cases may be worse.
    pub full_bound: f64,
    /// Upper bound in a short run where the GPU draws the images: drivers interpolate and divide less exactly. Measured with llvmpipe and an NVIDIA H100.
    /// [`run`] never applies less than `bound`.
    pub gpu_bound: f64,
    /// Upper bound in a full run where the GPU draws the images. [`run`] never applies less than `full_bound`.
    pub full_gpu_bound: f64,
    /// Reason for the bounds. Measured results in this text may be smaller than the bounds.
    pub reason: &'static str,
    run: fn(&SweepSetup<'_>) -> Result<SweepResult, SessionError>,
}

/// A sweep's name and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepReport {
    /// Name of the sweep.
    pub name: &'static str,
    /// Unit of `worst` and `bound`.
    pub unit: &'static str,
    /// Upper bound of the result for the effort and the renderer of the run.
    pub bound: f64,
    /// Reason for the bound.
    pub reason: &'static str,
    /// The result.
    pub result: SweepResult,
}

impl SweepReport {
    /// Whether the result exceeds the bound, or nothing was compared.
    pub fn has_failed(&self) -> bool {
        self.result.cases == 0 || self.result.worst > self.bound
    }
}

/// Computes the apparent direction of a body from the Earth's centre: a vector of any length, ICRF.
pub(crate) type ApparentDirection = fn(&Session, NaifId, Instant) -> Result<DVec3, SessionError>;

/// Fault injection: tests use it to show that a sweep finds an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct InjectedFaults {
    /// Changes each plan before it is drawn. Exceptions: the sweep `scale`, and in `needs-display` and `needs-linear` the frames with every effect.
    pub change_plan: Option<fn(&mut Plan)>,
    /// Replaces the scene's directions of bodies in the sweep `light-time`.
    pub apparent_direction: Option<ApparentDirection>,
    /// Replaces the purpose for which the scene chooses effects in the sweeps `needs-display` and `needs-linear`; the frames with every effect
    /// keep the sweep's purpose.
    pub purpose: Option<Purpose>,
}

/// What a sweep runs with: renderers, effort, seed and injected faults.
pub struct SweepSetup<'a> {
    renderers: PrecisionRenderers<'a>,
    /// A renderer in f64 that snaps vertices to the subpixel grid of GPUs; `None` unless the GPU draws the images.
    gpu_grid_renderer: Option<SoftwareRenderer>,
    effort: Effort,
    seed: u64,
    /// Number of random views in the sweeps `needs-display` and `needs-linear`; `None`: the effort decides.
    view_count: Option<usize>,
    injected_faults: InjectedFaults,
}

impl<'a> SweepSetup<'a> {
    /// A setup with the renderers that the session's settings ask for.
    ///
    /// # Errors
    /// The threads of the renderers cannot be started.
    pub fn new(session: &'a Session, effort: Effort, seed: u64, injected_faults: InjectedFaults) -> Result<Self, SessionError> {
        let gpu_grid_renderer = requests_gpu(session).then(|| session.renderer_for_gpu_comparison()).transpose()?;
        Ok(Self { renderers: PrecisionRenderers::new(session)?, gpu_grid_renderer, effort, seed, view_count: None, injected_faults })
    }

    /// Sets the number of random views; `None`: the effort decides.
    #[must_use]
    pub(crate) fn with_views(self, view_count: Option<usize>) -> Self {
        Self { view_count, ..self }
    }

    fn session(&self) -> &'a Session {
        self.renderers.session
    }

    /// `short` for a short effort, otherwise `full`.
    fn short_or_full<T>(&self, short: T, full: T) -> T {
        if self.effort == Effort::Short { short } else { full }
    }

    /// Plans a view and applies the injected fault.
    fn plan_view(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<PlannedView, SessionError> {
        // Without the coarse image of the air, each draw can be drawn by itself, which is needed to find the one at fault.
        let (scene, plan) = self.session().plan(&ViewRequest { may_use_coarse_air: false, ..request.clone() }, sampling)?;
        let mut view = PlannedView { scene, plan };
        if let Some(change) = self.injected_faults.change_plan {
            change(&mut view.plan);
        }
        Ok(view)
    }

    /// The linear image of a view. In f32 the GPU draws it if the user requests the GPU.
    fn draw_linear(&self, view: &PlannedView, precision: Precision) -> Result<LinearImage, SessionError> {
        if precision == Precision::F64 || !self.uses_gpu() {
            return self.renderers.draw_linear(view, precision);
        }
        let frame = self.session().draw_plan(&view.plan, FrameImages::DisplayAndHdr)?;
        Ok(LinearImage { width: frame.width, height: frame.height, light: frame.hdr, exposure_factor: view.scene.exposure.factor() })
    }

    /// The finished image of a view, drawn as in [`Self::draw_linear`].
    fn draw_display(&self, view: &PlannedView, precision: Precision) -> Result<Vec<[u8; 4]>, SessionError> {
        if precision == Precision::F64 || !self.uses_gpu() {
            let (frame, _) = self.renderers.renderer(precision).render(&view.plan, self.session().library(), FrameImages::Display)?;
            return Ok(frame.display);
        }
        Ok(self.session().draw_plan(&view.plan, FrameImages::Display)?.display)
    }

    /// Frames of a view with meshes or lines, drawn in f64: each pixel of the f32 image must match one of these frames. There are two if the GPU draws the
    /// images, because an edge through a pixel's centre covers the pixel or not, depending on the grid to which the GPU snaps vertices.
    fn f64_frames(&self, view: &PlannedView) -> Result<Vec<Frame>, SessionError> {
        let renderers = [Some(self.renderers.renderer(Precision::F64)), self.gpu_grid_renderer.as_ref()];
        let frame_of =
            |renderer: &SoftwareRenderer| Ok(renderer.render(&view.plan, self.session().library(), FrameImages::DisplayAndHdr)?.0);
        renderers.into_iter().flatten().map(frame_of).collect()
    }

    /// Whether the GPU draws the images in f32.
    fn uses_gpu(&self) -> bool {
        requests_gpu(self.session())
    }
}

/// Whether the user requests the GPU.
fn requests_gpu(session: &Session) -> bool {
    let (_, preference) = session.renderers();
    preference == RendererPreference::Gpu
}

/// A view, or `None` if it is impossible: from inside a body, or at a time that the ephemeris does not cover. Other errors, such as a module that cannot be
/// compiled, are faults and end the sweep.
fn if_possible<T>(view: Result<T, SessionError>) -> Result<Option<T>, SessionError> {
    match view {
        Ok(view) => Ok(Some(view)),
        Err(SessionError::Scene(_) | SessionError::Ephemeris(_)) => Ok(None),
        Err(e) => Err(e),
    }
}

/// Keeps those draws of the linear image whose label satisfies `condition`.
fn retain_draws(plan: &mut Plan, condition: impl Fn(&str) -> bool) {
    if let Some(index) = plan.hdr_pass_index() {
        plan.passes[index].draws.retain(|draw| condition(&draw.label));
    }
}

/// Half a level, in 255ths: an invisible difference, and the usual bound between f32 and f64.
const HALF_LEVEL: f64 = 0.5;

/// A sweep with the same bound for both efforts and all renderers.
const fn sweep(
    name: &'static str,
    (bound, unit): (f64, &'static str),
    reason: &'static str,
    run: fn(&SweepSetup<'_>) -> Result<SweepResult, SessionError>,
) -> Sweep {
    Sweep { name, unit, bound, full_bound: bound, gpu_bound: bound, full_gpu_bound: bound, reason, run }
}

impl Sweep {
    /// The sweep with another bound for a full run.
    const fn with_full_bound(self, full_bound: f64) -> Self {
        Self { full_bound, ..self }
    }

    /// The sweep with another bound on a GPU, for both efforts.
    const fn with_gpu_bounds(self, gpu_bound: f64) -> Self {
        Self { gpu_bound, full_gpu_bound: gpu_bound, ..self }
    }

    /// The sweep with another bound for a full run on a GPU.
    const fn with_full_gpu_bound(self, full_gpu_bound: f64) -> Self {
        Self { full_gpu_bound, ..self }
    }
}

/// Every sweep, with its bound.
pub const SWEEPS: [Sweep; 21] = [
    sweep("keys", (1.0 / 512.0, "of white"), "half a level of 256 before the sRGB curve; every covering key", keys::run),
    sweep(
        "simple",
        (2.0, "255ths"),
        "display bytes may differ by one through rounding; by two in the refracted limb, where light of half a level is drawn; by three there on a GPU",
        views::simple,
    )
    .with_gpu_bounds(4.0),
    sweep(
        "distance",
        (HALF_LEVEL, "255ths"),
        "half a level, from a metre above the ground to 100 au, from 1 arcsec to 170 degrees; in full 0.81 on Saturn's rings beside Pan",
        views::distance,
    )
    .with_full_bound(1.0)
    .with_gpu_bounds(1.0),
    sweep(
        "pairs",
        (1.0, "255ths"),
        "a level, in full 1.13, on rings behind a small moon that fills the frame from afar: f32 resolves positions in them to 14 m; on a GPU 3.34 there (NVIDIA H100; llvmpipe 1.64, since it interpolates rays)",
        views::pairs,
    )
    .with_full_bound(1.2)
    .with_full_gpu_bound(4.0),
    sweep(
        "grazing",
        (1.0, "255ths"),
        "a level, rays along the horizon, fields of view from 0.3 degrees: 0.6 on Saturn's rings, since f32 gives few digits of the point where such a ray meets their plane",
        views::grazing,
    )
    .with_gpu_bounds(2.0),
    sweep(
        "grazing-telescope",
        (HALF_LEVEL, "255ths"),
        "half a level, the same at 10 arcsec; on a GPU 1.28 in full, since its atan2 is off by 1.3e-6 radians and the Sun grazes the Moon's relief",
        views::grazing_telescope,
    )
    .with_gpu_bounds(1.0)
    .with_full_gpu_bound(1.5),
    sweep(
        "places",
        (1.0, "255ths"),
        "a level at poles, on the antimeridian, with the Sun in the zenith, in the nadir and on the horizon: 0.56 on the Earth's horizon at sunset; in full 1.26 two metres over Mercury's pole",
        views::places,
    )
    .with_full_bound(1.5)
    .with_gpu_bounds(1.0),
    sweep(
        "ring-plane",
        (HALF_LEVEL, "255ths"),
        "half a level, camera or Sun in the plane of the rings; 0.41 in the B ring, 90 m from the plane: f32 resolves a ringlet's edge to 7 m; on a GPU 0.61 in full",
        views::ring_plane,
    )
    .with_gpu_bounds(1.0),
    sweep(
        "contacts",
        (HALF_LEVEL, "255ths"),
        "half a level, images at each contact of eclipses",
        views::contacts,
    )
    .with_gpu_bounds(1.0),
    sweep(
        "radii",
        (HALF_LEVEL, "255ths"),
        "half a level, every body of the catalog; on a GPU 1.79 in full on Saturn's rings beside Pan, since it interpolates rays",
        views::radii,
    )
    .with_gpu_bounds(1.0)
    .with_full_gpu_bound(2.0),
    sweep("years", (HALF_LEVEL, "255ths"), "half a level, years -3000 to 3000", views::years).with_gpu_bounds(1.0),
    sweep("sizes", (HALF_LEVEL, "255ths"), "half a level, bodies from a third of a pixel to more than the frame", views::sizes)
        .with_gpu_bounds(1.0),
    sweep(
        "shadows",
        (5e-5, "of sunlight"),
        "f32 keeps five digits of the Sun's disc; the result is 1 if an umbra is not exactly 0, or full light not exactly 1",
        light::shadows,
    ),
    sweep("umbra-exposure", (0.0, "255ths"), "an umbra is black at any exposure from -20 to +25 stops", light::umbra_exposure),
    sweep("light-time", (0.01, "arcsec"), "directions from the Earth's centre against light time by bisection", light_time::run),
    sweep("depth", (3.0, "255ths"), "f32 against f64, and 1 sample against 4, of bodies with layers at every distance", images::depth),
    sweep(
        "motion",
        (2.0, "255ths"),
        "camera and bodies move by less than a pixel a step, so that light moves by less than a pixel",
        moving::motion,
    ),
    sweep("exposure", (1.0, "stops a step"), "automatic exposure through eclipses; 99 where an image is black", moving::exposure),
    sweep(
        "scale",
        (4.0, "255ths, mean"),
        "against a downsampled image with eight times the pixels on a side; 3.0 on the Earth in 64 pixels",
        images::scale,
    ),
    sweep(
        "needs-display",
        (0.0, "% of views"),
        "in no view does a pixel differ by more than a level from the frame with every effect",
        omitted_effects::display,
    ),
    sweep(
        "needs-linear",
        (0.0, "% of views"),
        "in no view does a pixel differ by more than 2e-3 of its radiance from the frame with every effect",
        omitted_effects::linear,
    ),
];

/// Runs one sweep.
///
/// # Errors
/// The reason why a case cannot be drawn.
pub fn run(sweep: &Sweep, setup: &SweepSetup<'_>) -> Result<SweepReport, SessionError> {
    let result = (sweep.run)(setup)?;
    let bound = setup.short_or_full(sweep.bound, sweep.full_bound);
    let gpu_bound = setup.short_or_full(sweep.gpu_bound, sweep.full_gpu_bound);
    let bound = if setup.uses_gpu() { bound.max(gpu_bound) } else { bound };
    Ok(SweepReport { name: sweep.name, unit: sweep.unit, bound, reason: sweep.reason, result })
}
