//! Renders images and answers queries on two other threads than the window's, so that input never waits for either.
//!
//! In: render jobs (a view at a size) and tasks (closures that use the session, such as queries). Out: images and answers, when they are
//! finished. Always: of several waiting jobs only the newest is rendered; no image waits for a task; the window is woken after each image and each
//! task. This module does not decide what is drawn.

use super::freed_memory;
use crate::render::plan::{GpuImage, SamplingQuality, SimpleDraw};
use crate::scene::Scene;
use crate::scene::request::ViewRequest;
use crate::session::{DrawnBy, RequestedOutput, Session, SessionError, Stages};
use crate::shader::library::Statistics;
use crate::view::app::exposure_adaptation::ExposureTicket;
use crate::view::language;
use parking_lot::{Condvar, Mutex};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant as WallInstant};

/// One image to render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderJob {
    pub request: ViewRequest,
    pub sampling: SamplingQuality,
    /// Whether the image may stay on the GPU, because the same GPU presents the window.
    pub output: RequestedOutput,
    /// Tells the adaptation of the exposure to which request the image belongs. The ticket returns with the image, or with the reason why there is none.
    pub exposure_ticket: ExposureTicket,
}

/// The result of a job.
pub struct RenderedView {
    pub job: RenderJob,
    pub scene: Scene,
    /// The draws with simple shaders, for the Shader panel.
    pub simple_draws: Vec<SimpleDraw>,
    /// Width and height of the image, pixels.
    pub width: u32,
    pub height: u32,
    /// The pixels, all opaque, top row first; empty if the image stayed on the GPU.
    pub rgba: Vec<[u8; 4]>,
    /// The image, if it stayed on the GPU.
    pub gpu_image: Option<GpuImage>,
    /// The renderer that drew the image, with its timings.
    pub drawn_by: DrawnBy,
    /// Time from the start of the job to the finished image, milliseconds.
    pub render_ms: f64,
    /// Time for which the render worker had no job before this one, milliseconds.
    pub idle_ms: f64,
    /// Time of each stage for this image.
    pub stages: Stages,
    /// Statistics of the shader library since the session was opened.
    pub library: Statistics,
}

/// Why a job has no image.
pub struct FailedJob {
    pub why: SessionError,
    /// The ticket of the job.
    pub exposure_ticket: ExposureTicket,
}

/// Work for the query worker: a query with the delivery of its answer, or other work that needs the session.
pub type Task = Box<dyn FnOnce(&Session) + Send>;

/// The session, and the work that the window leaves to other threads: the render worker draws images, the query worker runs tasks.
pub trait RenderWorker {
    fn session(&self) -> &Session;
    /// Requests an image. An older job that has not been started is dropped.
    fn submit(&self, job: RenderJob);
    /// Takes the newest finished image, or the reason why there is none; `None` if no job has finished since the last call.
    fn take(&self) -> Option<Result<RenderedView, FailedJob>>;
    /// Queues a task for the query worker, which runs one task after the other.
    fn run(&self, task: Task);
}

/// The answer to a query, which arrives later.
pub struct Pending<T>(Arc<Mutex<Option<T>>>);

/// A pending answer without a query: it never arrives.
impl<T> Default for Pending<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T> Pending<T> {
    /// A pending answer, and the function that delivers it.
    pub fn with_sender() -> (Self, impl FnOnce(T)) {
        let slot = Arc::new(Mutex::new(None));
        let answer = Arc::clone(&slot);
        (Self(slot), move |value| *answer.lock() = Some(value))
    }

    /// Takes the answer, if it has arrived.
    pub(crate) fn take(&self) -> Option<T> {
        self.0.lock().take()
    }
}

/// Runs a query on the worker; the returned [`Pending`] receives the answer.
pub(crate) fn ask<T: Send + 'static>(worker: &dyn RenderWorker, query: impl FnOnce(&Session) -> T + Send + 'static) -> Pending<T> {
    let (pending, deliver) = Pending::with_sender();
    // Each thread has its own language. The query runs on another thread, but texts in the answer must be in the language of this one.
    let language = language::current();
    worker.run(Box::new(move |session| {
        language::set(language);
        deliver(query(session));
    }));
    pending
}

/// Renders the image of a job on the calling thread.
///
/// # Errors
/// The reason why there is no image.
pub(crate) fn draw(session: &Session, job: RenderJob) -> Result<RenderedView, SessionError> {
    let (stages_before, _) = session.report_of_this_thread();
    let start = WallInstant::now();
    let drawn = session.draw_without_waiting(&job.request, job.sampling, job.output)?;
    let render_ms = start.elapsed().as_secs_f64() * 1e3;
    let (stages, library) = session.report_of_this_thread();
    Ok(RenderedView {
        job,
        scene: drawn.scene,
        simple_draws: drawn.simple_draws,
        width: drawn.frame.width,
        height: drawn.frame.height,
        rgba: drawn.frame.display,
        gpu_image: drawn.gpu_image,
        drawn_by: drawn.drawn_by,
        render_ms,
        // The render worker replaces this value.
        idle_ms: 0.0,
        stages: stages.since(&stages_before),
        library,
    })
}

/// Runs each job and task immediately on the caller's thread, for tests.
pub struct InlineWorker<'a> {
    session: &'a Session,
    /// The result of the last job, if it has not been taken.
    newest_result: Mutex<Option<Result<RenderedView, FailedJob>>>,
}

impl<'a> InlineWorker<'a> {
    pub fn new(session: &'a Session) -> Self {
        Self { session, newest_result: Mutex::default() }
    }
}

impl RenderWorker for InlineWorker<'_> {
    fn session(&self) -> &Session {
        self.session
    }
    fn submit(&self, job: RenderJob) {
        let exposure_ticket = job.exposure_ticket;
        *self.newest_result.lock() = Some(draw(self.session, job).map_err(|why| FailedJob { why, exposure_ticket }));
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        self.newest_result.lock().take()
    }
    fn run(&self, task: Task) {
        task(self.session);
    }
}

/// Smallest interval between returns of freed pages to the system. Each of them delays the next image.
const PAGE_RETURN_INTERVAL: Duration = Duration::from_secs(20);

/// The waiting work of the two threads, and the newest result.
#[derive(Default)]
struct Work {
    /// The newest job, if it has not been started.
    job: Option<RenderJob>,
    tasks: VecDeque<Task>,
    /// The newest finished image, or the reason why there is none, if it has not been taken.
    newest_result: Option<Result<RenderedView, FailedJob>>,
    /// Whether an image is being rendered.
    is_drawing: bool,
    /// Whether the threads are to stop.
    is_closed: bool,
}

impl Work {
    /// Takes the waiting job, and records that it is being drawn.
    fn start_image(&mut self) -> Option<RenderJob> {
        let job = self.job.take();
        self.is_drawing |= job.is_some();
        job
    }
}

/// The state that the window shares with its two worker threads: the render worker draws images, the query worker runs tasks, and neither waits for
/// the other.
pub struct ThreadedWorker<'a> {
    session: &'a Session,
    work: Mutex<Work>,
    /// Notified when `work` has a new job or task, or is closed.
    changed: Condvar,
    /// Wakes the window.
    wake: Box<dyn Fn() + Send + Sync + 'a>,
}

impl<'a> ThreadedWorker<'a> {
    /// `wake` is called after each finished image and task.
    pub fn new(session: &'a Session, wake: impl Fn() + Send + Sync + 'a) -> Self {
        Self { session, work: Mutex::default(), changed: Condvar::new(), wake: Box::new(wake) }
    }

    /// The render worker: renders jobs until [`Self::close`] is called. Blocks, so it needs its own thread.
    pub fn render_until_closed(&self) {
        let mut last_page_return = WallInstant::now();
        let mut idle_since = WallInstant::now();
        while let Some(job) = self.wait_for_work(Work::start_image) {
            let idle_ms = idle_since.elapsed().as_secs_f64() * 1e3;
            let exposure_ticket = job.exposure_ticket;
            let rendered = draw(self.session, job)
                .map(|rendered| RenderedView { idle_ms, ..rendered })
                .map_err(|why| FailedJob { why, exposure_ticket });
            idle_since = WallInstant::now();
            {
                let mut work = self.work.lock();
                (work.newest_result, work.is_drawing) = (Some(rendered), false);
            }
            (self.wake)();
            if last_page_return.elapsed() > PAGE_RETURN_INTERVAL {
                freed_memory::return_pages();
                last_page_return = WallInstant::now();
            }
        }
    }

    /// The query worker: runs tasks until [`Self::close`] is called. Blocks, so it needs its own thread.
    pub fn run_tasks_until_closed(&self) {
        while let Some(task) = self.wait_for_work(|work| work.tasks.pop_front()) {
            task(self.session);
            (self.wake)();
        }
    }

    /// Waits until `take_work` finds work, and returns that work; `None` once the worker is closed.
    fn wait_for_work<T>(&self, take_work: impl Fn(&mut Work) -> Option<T>) -> Option<T> {
        let mut work = self.work.lock();
        loop {
            if work.is_closed {
                return None;
            }
            match take_work(&mut work) {
                Some(found) => return Some(found),
                None => self.changed.wait(&mut work),
            }
        }
    }

    /// Whether a requested image is not finished yet, so that the window will be woken.
    pub fn is_drawing(&self) -> bool {
        let work = self.work.lock();
        work.is_drawing || work.job.is_some()
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.work.lock().is_closed
    }

    /// Makes both threads stop once they have finished the current image and the current task.
    pub fn close(&self) {
        self.work.lock().is_closed = true;
        self.changed.notify_all();
    }
}

impl RenderWorker for ThreadedWorker<'_> {
    fn session(&self) -> &Session {
        self.session
    }
    fn submit(&self, job: RenderJob) {
        self.work.lock().job = Some(job);
        self.changed.notify_all();
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        self.work.lock().newest_result.take()
    }
    fn run(&self, task: Task) {
        self.work.lock().tasks.push_back(task);
        self.changed.notify_all();
    }
}
