//! Which renderer draws, and the way back to software when the GPU cannot.
//!
//! In: what the user asked for, and plans. Out: frames. The software renderer is always there. A GPU is opened with the first frame; when it
//! is missing or fails, that is said in one line, and the same plan is drawn in software, this frame and every later one.

use crate::render::frame::Frame;
use crate::render::plan::{PictureOnDevice, Plan};
use crate::render::software::{Precision, SoftwareRenderer, Timings};
use crate::shader::Library;
use std::sync::{Arc, OnceLock};

/// What the user asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RendererWish {
    /// A hardware GPU where there is one, else software.
    Auto,
    /// Any adapter, a driver on the processor too; none is an error.
    Gpu,
    #[default]
    Software,
}

impl RendererWish {
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Software => "software",
        }
    }
}

/// Who drew a frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnBy {
    pub renderer: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Milliseconds on the device by pass, where the adapter tells.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes_ms: Vec<(String, f64)>,
    /// What the software renderer did, where it drew.
    #[serde(skip)]
    pub software: Option<Timings>,
}

/// What became of a plan.
pub struct Done {
    pub frame: Frame,
    /// The picture, where it stays on the device: the frame has no pixels then.
    pub on_device: Option<PictureOnDevice>,
    pub by: DrawnBy,
}

/// What a frame is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    Pixels,
    /// The linear picture too.
    Linear,
    /// The picture may stay on the device that draws it.
    OnDevice,
}

/// Whether a picture that was drawn promptly in software could now come from the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// Nothing is under way.
    Settled,
    /// A thread makes what the last picture would need.
    Preparing,
    /// It has made it.
    JustReady,
}

pub struct Devices {
    pub software: SoftwareRenderer,
    /// Another one like it, with threads of its own; `None` inside where no threads were to be had.
    aside: OnceLock<Option<SoftwareRenderer>>,
    say: Arc<dyn Fn(&str) + Send + Sync>,
    #[cfg(feature = "gpu")]
    gpu: gpu::Gpu,
    #[cfg(not(feature = "gpu"))]
    wish: RendererWish,
}

impl Devices {
    /// `double_precision`: frames are computed in f64, which the software renderer alone does.
    pub fn new(software: SoftwareRenderer, wish: RendererWish, double_precision: bool, say: Arc<dyn Fn(&str) + Send + Sync>) -> Self {
        let wish = if double_precision && wish != RendererWish::Software {
            if wish == RendererWish::Gpu {
                say("the GPU does not compute in f64, which --quality reference asks for; drawing in software");
            }
            RendererWish::Software
        } else {
            wish
        };
        #[cfg(feature = "gpu")]
        return Self { software, aside: OnceLock::new(), say, gpu: gpu::Gpu::new(wish) };
        #[cfg(not(feature = "gpu"))]
        Self { software, aside: OnceLock::new(), say, wish }
    }

    /// The software renderer for what is drawn while a window's picture is: in one pool the picture would wait for the other to end.
    pub fn aside(&self) -> &SoftwareRenderer {
        let made = self.aside.get_or_init(|| SoftwareRenderer::new(*self.software.options()).ok());
        made.as_ref().unwrap_or(&self.software)
    }

    fn in_software(by: &SoftwareRenderer, plan: &Plan, library: &Library, keep: Keep) -> Result<Done, String> {
        let (frame, timings) = by.render(plan, library, keep == Keep::Linear).map_err(|e| e.to_string())?;
        let by = DrawnBy { renderer: "software", adapter: None, passes_ms: Vec::new(), software: Some(timings) };
        Ok(Done { frame, on_device: None, by })
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw(&self, by: &SoftwareRenderer, plan: &Plan, library: &Library, keep: Keep) -> Result<Done, String> {
        if self.wish == RendererWish::Gpu {
            return Err("this build has no GPU renderer: leave --renderer out, or say --renderer software".into());
        }
        let _ = &self.say;
        Self::in_software(by, plan, library, keep)
    }

    /// Draws the plan with the GPU where there is one that does, else with the given software renderer.
    ///
    /// # Errors
    /// Why neither draws; that no adapter is there when one was demanded.
    #[cfg(feature = "gpu")]
    pub fn draw(&self, by: &SoftwareRenderer, plan: &Plan, library: &Library, keep: Keep) -> Result<Done, String> {
        match self.gpu.draw(plan, library, keep, &*self.say)? {
            Some(drawn) => Ok(drawn),
            None => Self::in_software(by, plan, library, keep),
        }
    }

    /// The same for a window: what the GPU has no pipeline for yet is drawn in software, while a thread makes it, and what `window`, the plan of
    /// a window's own frame, needs.
    #[cfg(feature = "gpu")]
    pub fn draw_promptly(&self, plan: &Plan, window: impl FnOnce() -> Option<Plan>, library: &Library, keep: Keep) -> Result<Done, String> {
        match self.gpu.draw_if_ready(plan, window, library, keep, &self.say) {
            Some(drawn) => Ok(drawn),
            None => Self::in_software(&self.software, plan, library, keep),
        }
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw_promptly(&self, plan: &Plan, _: impl FnOnce() -> Option<Plan>, library: &Library, keep: Keep) -> Result<Done, String> {
        self.draw(&self.software, plan, library, keep)
    }

    /// What can be wished for here: software alone where frames are in f64, or the build has no GPU renderer.
    pub fn choices(&self) -> &'static [RendererWish] {
        if self.software.options().precision == Precision::F64 || !cfg!(feature = "gpu") {
            return &[RendererWish::Software];
        }
        &[RendererWish::Auto, RendererWish::Gpu, RendererWish::Software]
    }

    /// What is wished for now.
    pub fn wish(&self) -> RendererWish {
        #[cfg(feature = "gpu")]
        return self.gpu.wish();
        #[cfg(not(feature = "gpu"))]
        self.wish
    }

    /// Never waits.
    pub fn readiness(&self) -> Readiness {
        #[cfg(feature = "gpu")]
        return self.gpu.readiness();
        #[cfg(not(feature = "gpu"))]
        Readiness::Settled
    }

    /// Wishes for another renderer from the next frame on; what is not among the [`Self::choices`] changes nothing.
    pub fn choose(&self, wish: RendererWish) {
        let _ = wish;
        #[cfg(feature = "gpu")]
        if self.choices().contains(&wish) {
            self.gpu.choose(wish);
        }
    }

    /// Begins to open the GPU that was wished for, so that the first frame waits less.
    pub fn begin(&self) {
        #[cfg(feature = "gpu")]
        self.gpu.begin();
    }

    /// Forgets what is kept of modules: those of the same names are no longer the same.
    pub fn forget_modules(&self) {
        self.software.forget_modules();
        if let Some(Some(aside)) = self.aside.get() {
            aside.forget_modules();
        }
        #[cfg(feature = "gpu")]
        self.gpu.forget_modules();
    }

    /// The device that draws, if one does. Never waits: while it draws, or is made ready for more, the answer is [`gpu::Standing::Unchanged`].
    #[cfg(feature = "gpu")]
    pub fn standing(&self) -> gpu::Standing {
        self.gpu.standing(&*self.say)
    }

    /// Gives the device back, as a driver that resets does: for tests of the way back.
    #[cfg(feature = "gpu")]
    pub fn destroy_gpu(&self) {
        self.gpu.destroy();
    }
}

#[cfg(feature = "gpu")]
pub mod gpu {
    use super::{Done, DrawnBy, Frame, Keep, Library, Plan, Readiness, RendererWish};
    use crate::render::gpu::{GpuError, GpuRenderer, Turn};
    use crate::render::plan::{ModuleName, Modules};
    use crate::shader::ShaderModule;
    use std::collections::HashMap;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
    use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
    use std::thread::JoinHandle;

    type Say = dyn Fn(&str) + Send + Sync;

    /// What a thread works at: the device, open and with what the plan in hand needs.
    struct Preparing {
        thread: JoinHandle<Result<Arc<GpuRenderer>, GpuError>>,
        /// The epoch and the wish with which it began.
        epoch: u64,
        wish: RendererWish,
    }

    /// What a window may know of the device.
    pub enum Standing {
        /// It draws.
        Open(Arc<GpuRenderer>),
        /// As it was when last asked, as far as can be told without waiting.
        Unchanged,
        /// Software draws.
        Software,
    }

    enum State {
        /// Not tried yet.
        Unopened,
        /// A thread opens the device, or makes what a plan needs.
        Preparing(Preparing),
        Open(Arc<GpuRenderer>),
        /// Software draws from here on.
        Closed,
    }

    pub struct Gpu {
        wish: Mutex<RendererWish>,
        state: Mutex<State>,
        /// Grows when kept pipelines are no longer those of the modules.
        epoch: AtomicU64,
        /// A thread's work was taken over, and no picture was drawn promptly since.
        just_ready: AtomicBool,
        /// Said last: a run of frames says it once.
        said: Mutex<Option<GpuError>>,
    }

    /// The modules of one plan, for a thread that outlives the borrow of the library.
    struct Gathered(HashMap<ModuleName, Arc<ShaderModule>>);

    impl Modules for Gathered {
        fn module(&self, name: &ModuleName) -> Result<Arc<ShaderModule>, String> {
            self.0.get(name).cloned().ok_or_else(|| format!("{name} was not gathered"))
        }
    }

    fn locked(state: &Mutex<State>) -> MutexGuard<'_, State> {
        state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What `auto` makes of a failure to open: software, and one line that says so.
    fn closed(e: &GpuError, say: &Say) -> State {
        match e {
            GpuError::SoftwareDriver(_) => say(&format!("{e}: drawing in software; --renderer gpu takes it nonetheless")),
            e => say(&format!("{e}: drawing in software")),
        }
        State::Closed
    }

    impl Drop for Gpu {
        /// No driver is still loading or compiling when the process ends: at its exit a driver takes down what such a thread stands on.
        fn drop(&mut self) {
            if let State::Preparing(preparing) = std::mem::replace(&mut *locked(&self.state), State::Closed) {
                let _ = preparing.thread.join();
            }
        }
    }

    impl Gpu {
        pub fn new(wish: RendererWish) -> Self {
            let state = if wish == RendererWish::Software { State::Closed } else { State::Unopened };
            Self {
                wish: Mutex::new(wish),
                state: Mutex::new(state),
                epoch: AtomicU64::new(0),
                just_ready: AtomicBool::new(false),
                said: Mutex::default(),
            }
        }

        pub fn wish(&self) -> RendererWish {
            *self.wish.lock().unwrap_or_else(PoisonError::into_inner)
        }

        /// Another wish may mean another device: what is open is given back.
        pub fn choose(&self, wish: RendererWish) {
            let before = std::mem::replace(&mut *self.wish.lock().unwrap_or_else(PoisonError::into_inner), wish);
            if wish == before {
                return;
            }
            self.said.lock().unwrap_or_else(PoisonError::into_inner).take();
            let mut state = locked(&self.state);
            if !matches!(*state, State::Preparing(_)) {
                *state = if wish == RendererWish::Software { State::Closed } else { State::Unopened };
            }
        }

        pub fn readiness(&self) -> Readiness {
            let Ok(state) = self.state.try_lock() else { return Readiness::Settled };
            match &*state {
                _ if self.wish() == RendererWish::Software => Readiness::Settled,
                State::Preparing(preparing) if preparing.thread.is_finished() => Readiness::JustReady,
                State::Preparing(_) => Readiness::Preparing,
                State::Open(_) if self.just_ready.load(Ordering::SeqCst) => Readiness::JustReady,
                State::Unopened | State::Open(_) | State::Closed => Readiness::Settled,
            }
        }

        pub fn forget_modules(&self) {
            self.epoch.fetch_add(1, Ordering::SeqCst);
            let open = match &*locked(&self.state) {
                State::Open(renderer) => Some(Arc::clone(renderer)),
                _ => None,
            };
            if let Some(renderer) = open {
                renderer.forget_modules();
            }
        }

        /// Never waits.
        pub fn standing(&self, say: &Say) -> Standing {
            if self.wish() == RendererWish::Software {
                return Standing::Software;
            }
            let Ok(mut state) = self.state.try_lock() else { return Standing::Unchanged };
            self.settle(&mut state, say);
            match &*state {
                State::Open(renderer) => Standing::Open(Arc::clone(renderer)),
                State::Unopened | State::Preparing(_) => Standing::Unchanged,
                State::Closed => Standing::Software,
            }
        }

        fn prepare(&self, work: impl FnOnce() -> Result<Arc<GpuRenderer>, GpuError> + Send + 'static) -> State {
            State::Preparing(Preparing { thread: std::thread::spawn(work), epoch: self.epoch.load(Ordering::SeqCst), wish: self.wish() })
        }

        /// Waits for the thread. What it made of modules that were forgotten meanwhile is forgotten too; a device that is no longer wished for is given back.
        fn prepared(&self, preparing: Preparing) -> Result<State, GpuError> {
            let renderer = preparing.thread.join().unwrap_or_else(|_| Err(GpuError::NoAdapter("a driver broke off".into())))?;
            if preparing.wish != self.wish() {
                return Ok(State::Unopened);
            }
            if preparing.epoch != self.epoch.load(Ordering::SeqCst) {
                renderer.forget_modules();
            }
            Ok(State::Open(renderer))
        }

        /// Takes over what a thread has made, if it is done.
        fn settle(&self, state: &mut State, say: &Say) {
            *state = match std::mem::replace(state, State::Unopened) {
                State::Preparing(preparing) if preparing.thread.is_finished() => {
                    self.just_ready.store(true, Ordering::SeqCst);
                    self.prepared(preparing).unwrap_or_else(|e| closed(&e, say))
                }
                other => other,
            };
        }

        /// Opens the device beside whatever else is done before the first frame.
        pub fn begin(&self) {
            let mut state = locked(&self.state);
            if matches!(*state, State::Unopened) {
                let software = self.wish() == RendererWish::Gpu;
                *state = self.prepare(move || GpuRenderer::open(software).map(Arc::new));
            }
        }

        pub fn destroy(&self) {
            if let State::Open(renderer) = &*locked(&self.state) {
                renderer.destroy();
            }
        }

        /// The device, opened and waited for; `None`: software shall draw.
        fn opened(&self, say: &Say) -> Result<Option<Arc<GpuRenderer>>, String> {
            let mut state = locked(&self.state);
            let mut now = Ok(std::mem::replace(&mut *state, State::Unopened));
            if let Ok(State::Preparing(preparing)) = now {
                now = self.prepared(preparing);
            }
            if let Ok(State::Unopened) = now {
                now = GpuRenderer::open(self.wish() == RendererWish::Gpu).map(|renderer| State::Open(Arc::new(renderer)));
            }
            *state = match now {
                Ok(now) => now,
                Err(e) if self.wish() == RendererWish::Gpu => return Err(format!("{e}; leave --renderer out, or say --renderer software")),
                Err(e) => closed(&e, say),
            };
            Ok(if let State::Open(renderer) = &*state { Some(Arc::clone(renderer)) } else { None })
        }

        /// `None`: software shall draw it.
        pub fn draw(&self, plan: &Plan, library: &Library, keep: Keep, say: &Say) -> Result<Option<Done>, String> {
            if self.wish() == RendererWish::Software {
                return Ok(None);
            }
            // Drawn without the lock: whoever wants a picture promptly, or asks how the device stands, sees at once that it is at work.
            Ok(self.opened(say)?.and_then(|renderer| self.draw_in(&renderer, renderer.turn(), plan, library, keep, say)))
        }

        /// `None`: it could not, and software shall draw.
        fn draw_in(
            &self,
            renderer: &Arc<GpuRenderer>,
            turn: Turn<'_>,
            plan: &Plan,
            library: &Library,
            keep: Keep,
            say: &Say,
        ) -> Option<Done> {
            let drawn = match keep {
                Keep::Pixels | Keep::Linear => {
                    renderer.render_in(turn, plan, library, keep == Keep::Linear).map(|(frame, timings)| (frame, None, timings))
                }
                Keep::OnDevice => renderer.render_on_device_in(turn, plan, library).map(|(picture, timings)| {
                    let frame = Frame { width: picture.width, height: picture.height, hdr: Vec::new(), display: Vec::new() };
                    (frame, Some(picture), timings)
                }),
            };
            match drawn {
                Ok((frame, on_device, timings)) => {
                    let adapter = Some(renderer.facts().to_string());
                    let by = DrawnBy { renderer: "gpu", adapter, passes_ms: timings.passes, software: None };
                    Some(Done { frame, on_device, by })
                }
                Err(e) => {
                    let said = self.said.lock().unwrap_or_else(PoisonError::into_inner).replace(e.clone());
                    if said.as_ref() != Some(&e) {
                        say(&format!("{e}: drawing in software"));
                    }
                    if e.is_final() {
                        let mut state = locked(&self.state);
                        if matches!(&*state, State::Open(open) if Arc::ptr_eq(open, renderer)) {
                            *state = State::Closed;
                        }
                    }
                    None
                }
            }
        }

        /// `None`: software shall draw it, now or for good. Never waits for a driver.
        pub fn draw_if_ready(
            &self,
            plan: &Plan,
            window: impl FnOnce() -> Option<Plan>,
            library: &Library,
            keep: Keep,
            say: &Arc<Say>,
        ) -> Option<Done> {
            if self.wish() == RendererWish::Software {
                return None;
            }
            // Another thread opens the device or waits for it.
            let Ok(mut state) = self.state.try_lock() else { return None };
            self.settle(&mut state, &**say);
            self.just_ready.store(false, Ordering::SeqCst);
            let renderer = match &*state {
                State::Open(renderer) => Some(Arc::clone(renderer)),
                State::Unopened => None,
                State::Preparing(_) | State::Closed => return None,
            };
            let window = window();
            if let Some(renderer) = &renderer {
                let for_windows = window.as_ref().and_then(|w| renderer.is_ready_for_windows(w)).unwrap_or(true);
                if let Some(turn) = renderer.turn_if_ready(plan).filter(|_| for_windows) {
                    drop(state);
                    return self.draw_in(renderer, turn, plan, library, keep, &**say);
                }
            }
            let passes = plan.passes.iter().chain(window.iter().flat_map(|w| &w.passes));
            let names: Vec<&ModuleName> = passes.flat_map(|p| &p.draws).map(|d| &d.module).collect();
            let gathered = names.into_iter().map(|n| Some((n.clone(), library.module(n).ok()?))).collect::<Option<_>>().map(Gathered)?;
            let (plan, wish) = (plan.clone(), self.wish());
            *state = self.prepare(move || {
                let renderer = renderer.map_or_else(|| GpuRenderer::open(wish == RendererWish::Gpu).map(Arc::new), Ok)?;
                // Drawn once to no end: some drivers compile with the first draw only.
                let drawn =
                    [Some(renderer.render(&plan, &gathered, false).err()), window.map(|w| renderer.prepare_windows(&w, &gathered).err())];
                match drawn.into_iter().flatten().flatten().find(GpuError::is_final) {
                    Some(e) => Err(e),
                    None => Ok(renderer),
                }
            });
            None
        }
    }
}
