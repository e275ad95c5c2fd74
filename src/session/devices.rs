//! Which renderer draws, and the way back to software when the GPU cannot.
//!
//! In: what the user asked for, and plans. Out: frames. The software renderer is always there. A GPU is opened with the first frame; when it
//! is missing or fails, that is said in one line, and the same plan is drawn in software, this frame and every later one.

use crate::render::frame::Frame;
use crate::render::plan::Plan;
use crate::render::software::SoftwareRenderer;
use crate::shader::Library;
use std::sync::Arc;

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

/// Who drew a frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnBy {
    pub renderer: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Milliseconds on the device by pass, where the adapter tells.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes_ms: Vec<(String, f64)>,
}

pub struct Devices {
    pub software: SoftwareRenderer,
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
        return Self { software, say, gpu: gpu::Gpu::new(wish) };
        #[cfg(not(feature = "gpu"))]
        Self { software, say, wish }
    }

    fn in_software(&self, plan: &Plan, library: &Library, keep_hdr: bool) -> Result<(Frame, DrawnBy), String> {
        let (frame, _) = self.software.render(plan, library, keep_hdr).map_err(|e| e.to_string())?;
        Ok((frame, DrawnBy { renderer: "software", adapter: None, passes_ms: Vec::new() }))
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw(&self, plan: &Plan, library: &Library, keep_hdr: bool) -> Result<(Frame, DrawnBy), String> {
        if self.wish == RendererWish::Gpu {
            return Err("this build has no GPU renderer: leave --renderer out, or say --renderer software".into());
        }
        let _ = &self.say;
        self.in_software(plan, library, keep_hdr)
    }

    /// Draws the plan with the GPU where there is one that does, else in software.
    ///
    /// # Errors
    /// Why neither draws; that no adapter is there when one was demanded.
    #[cfg(feature = "gpu")]
    pub fn draw(&self, plan: &Plan, library: &Library, keep_hdr: bool) -> Result<(Frame, DrawnBy), String> {
        match self.gpu.draw(plan, library, keep_hdr, &*self.say)? {
            Some(drawn) => Ok(drawn),
            None => self.in_software(plan, library, keep_hdr),
        }
    }

    /// The same for a window: what the GPU has no pipeline for yet is drawn in software, while a thread makes it.
    #[cfg(feature = "gpu")]
    pub fn draw_promptly(&self, plan: &Plan, library: &Library) -> Result<(Frame, DrawnBy), String> {
        match self.gpu.draw_if_ready(plan, library, &self.say) {
            Some(drawn) => Ok(drawn),
            None => self.in_software(plan, library, false),
        }
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw_promptly(&self, plan: &Plan, library: &Library) -> Result<(Frame, DrawnBy), String> {
        self.draw(plan, library, false)
    }

    /// Begins to open the GPU that was wished for, so that the first frame waits less.
    pub fn begin(&self) {
        #[cfg(feature = "gpu")]
        self.gpu.begin();
    }

    /// Forgets what is kept of modules: those of the same names are no longer the same.
    pub fn forget_modules(&self) {
        self.software.forget_modules();
        #[cfg(feature = "gpu")]
        self.gpu.forget_modules();
    }

    /// Gives the device back, as a driver that resets does: for tests of the way back.
    #[cfg(feature = "gpu")]
    pub fn destroy_gpu(&self) {
        self.gpu.destroy();
    }
}

#[cfg(feature = "gpu")]
mod gpu {
    use super::{DrawnBy, Frame, Library, Plan, RendererWish};
    use crate::render::gpu::{GpuError, GpuRenderer};
    use crate::render::plan::{ModuleName, Modules};
    use crate::shader::ShaderModule;
    use std::collections::HashMap;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
    use std::thread::JoinHandle;

    type Say = dyn Fn(&str) + Send + Sync;

    enum State {
        /// Not tried yet.
        Unopened,
        /// A thread opens the device while the session is made.
        Opening(JoinHandle<Result<GpuRenderer, GpuError>>),
        Open(Arc<GpuRenderer>),
        /// A thread opens the device, or makes what a plan needs.
        Busy,
        /// Software draws from here on.
        Closed,
    }

    pub struct Gpu {
        wish: RendererWish,
        state: Arc<Mutex<State>>,
        /// Grows when kept pipelines are no longer those of the modules.
        epoch: Arc<AtomicU64>,
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

    fn joined(thread: JoinHandle<Result<GpuRenderer, GpuError>>) -> Result<GpuRenderer, GpuError> {
        thread.join().unwrap_or_else(|_| Err(GpuError::NoAdapter("a driver broke off".into())))
    }

    impl Drop for Gpu {
        /// No driver is still loading when the process ends.
        fn drop(&mut self) {
            if let State::Opening(thread) = std::mem::replace(&mut *locked(&self.state), State::Closed) {
                let _ = thread.join();
            }
        }
    }

    impl Gpu {
        pub fn new(wish: RendererWish) -> Self {
            let state = if wish == RendererWish::Software { State::Closed } else { State::Unopened };
            Self { wish, state: Arc::new(Mutex::new(state)), epoch: Arc::default(), said: Mutex::default() }
        }

        pub fn forget_modules(&self) {
            self.epoch.fetch_add(1, Ordering::SeqCst);
            let mut state = locked(&self.state);
            if matches!(*state, State::Open(_)) {
                *state = State::Unopened;
            }
        }

        /// Opens the device beside whatever else is done before the first frame.
        pub fn begin(&self) {
            let mut state = locked(&self.state);
            if matches!(*state, State::Unopened) {
                let software = self.wish == RendererWish::Gpu;
                *state = State::Opening(std::thread::spawn(move || GpuRenderer::open(software)));
            }
        }

        pub fn destroy(&self) {
            if let State::Open(renderer) = &*locked(&self.state) {
                renderer.destroy();
            }
        }

        /// `None`: software shall draw it.
        pub fn draw(&self, plan: &Plan, library: &Library, keep_hdr: bool, say: &Say) -> Result<Option<(Frame, DrawnBy)>, String> {
            let mut state = locked(&self.state);
            let opened = match std::mem::replace(&mut *state, State::Unopened) {
                State::Unopened => Some(GpuRenderer::open(self.wish == RendererWish::Gpu)),
                State::Opening(thread) => Some(joined(thread)),
                other => {
                    *state = other;
                    None
                }
            };
            match opened {
                Some(Ok(renderer)) => *state = State::Open(Arc::new(renderer)),
                Some(Err(e)) if self.wish == RendererWish::Gpu => {
                    return Err(format!("{e}; leave --renderer out, or say --renderer software"));
                }
                Some(Err(e)) => *state = closed(&e, say),
                None => {}
            }
            let State::Open(renderer) = &*state else { return Ok(None) };
            match renderer.render(plan, library, keep_hdr) {
                Ok((frame, timings)) => {
                    let adapter = Some(renderer.facts().to_string());
                    Ok(Some((frame, DrawnBy { renderer: "gpu", adapter, passes_ms: timings.passes })))
                }
                Err(e) => {
                    let said = self.said.lock().unwrap_or_else(PoisonError::into_inner).replace(e.clone());
                    if said.as_ref() != Some(&e) {
                        say(&format!("{e}: drawing in software"));
                    }
                    if e.is_final() {
                        *state = State::Closed;
                    }
                    Ok(None)
                }
            }
        }

        /// `None`: software shall draw it, now or for good. Never waits for a driver.
        pub fn draw_if_ready(&self, plan: &Plan, library: &Library, say: &Arc<Say>) -> Option<(Frame, DrawnBy)> {
            let mut state = locked(&self.state);
            if let State::Opening(thread) = &*state {
                if !thread.is_finished() {
                    return None;
                }
                if let State::Opening(thread) = std::mem::replace(&mut *state, State::Closed) {
                    *state = joined(thread).map_or_else(|e| closed(&e, &**say), |renderer| State::Open(Arc::new(renderer)));
                }
            }
            let renderer = match &*state {
                State::Open(renderer) if renderer.ready(plan) => {
                    drop(state);
                    return self.draw(plan, library, false, &**say).ok().flatten();
                }
                State::Open(renderer) => Some(Arc::clone(renderer)),
                State::Unopened => None,
                State::Opening(_) | State::Busy | State::Closed => return None,
            };
            let names: Vec<&ModuleName> = plan.passes.iter().flat_map(|p| &p.draws).map(|d| &d.module).collect();
            let gathered = names.into_iter().map(|n| Some((n.clone(), library.module(n).ok()?))).collect::<Option<_>>().map(Gathered)?;
            *state = State::Busy;
            let (shared, plan, say, wish) = (Arc::clone(&self.state), plan.clone(), Arc::clone(say), self.wish);
            let (epoch, began) = (Arc::clone(&self.epoch), self.epoch.load(Ordering::SeqCst));
            std::thread::spawn(move || {
                let opened = renderer.map_or_else(|| GpuRenderer::open(wish == RendererWish::Gpu).map(Arc::new), Ok);
                // Drawn once to no end: some drivers compile with the first draw only.
                let drawn = opened.and_then(|renderer| match renderer.render(&plan, &gathered, false) {
                    Err(e) if e.is_final() => Err(e),
                    _ => Ok(renderer),
                });
                let next = match drawn {
                    Ok(_) if epoch.load(Ordering::SeqCst) != began => State::Unopened,
                    Ok(renderer) => State::Open(renderer),
                    Err(e) => closed(&e, &*say),
                };
                *locked(&shared) = next;
            });
            None
        }
    }
}
