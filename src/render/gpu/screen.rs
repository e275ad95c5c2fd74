//! A window that the device draws on itself: no pixel goes through the processor.
//!
//! In: a window's handle, and plans of its size. Out: what the window shows next. Always: the surface has the size of the last plan; bytes of a plan are
//! shown as they are, since they are encoded for the display already. Not here: what is shown, and when.

use super::renderer::RenderTarget;
use super::{GpuError, GpuRenderer, caught};
use crate::render::plan::{ModuleProvider, Plan};
use wgpu::{
    CompositeAlphaMode, CurrentSurfaceTexture, Extent3d, PollType, PresentMode, Surface, SurfaceColorSpace, SurfaceConfiguration,
    SurfaceTexture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
};

/// A window's handle.
pub trait WindowHandle: wgpu::DisplayAndWindowHandle + 'static {}
impl<T: wgpu::DisplayAndWindowHandle + 'static> WindowHandle for T {}

/// A window's surface on one renderer's device.
pub struct GpuSurface {
    surface: Surface<'static>,
    format: TextureFormat,
    alpha_mode: CompositeAlphaMode,
    configured: Option<[u32; 2]>,
    /// How often in a row it could not be given the window's size.
    failed_resizes: u32,
}

/// A surface that fits its window no sooner does not fit it at all.
const MAX_FAILED_RESIZES: u32 = 40;

/// What pictures of a window may be made of, the one that is liked best first.
const WINDOW_FORMATS: [TextureFormat; 2] = [TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm];

impl GpuRenderer {
    /// A surface for the window.
    ///
    /// # Errors
    /// The adapter that draws cannot show anything there.
    pub fn screen(&self, window: impl WindowHandle) -> Result<GpuSurface, GpuError> {
        let refused = |why: String| GpuError::Adapter { adapter: self.facts().to_string(), why };
        let surface = self.instance.create_surface(window).map_err(|e| refused(super::one_line(&e.to_string())))?;
        let able = surface.get_capabilities(&self.adapter);
        let plain = |f: &&TextureFormat| WINDOW_FORMATS.contains(f);
        let format = *able.formats.iter().find(plain).ok_or_else(|| refused("it cannot show 8-bit pixels in this window".into()))?;
        let alpha_mode =
            if able.alpha_modes.contains(&CompositeAlphaMode::Opaque) { CompositeAlphaMode::Opaque } else { CompositeAlphaMode::Auto };
        Ok(GpuSurface { surface, format, alpha_mode, configured: None, failed_resizes: 0 })
    }

    /// Draws the plan to no end, so that no window waits for what its own frames need: some drivers compile with the first draw only.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub fn prepare_windows(&self, plan: &Plan, modules: &impl ModuleProvider) -> Result<(), GpuError> {
        if self.is_ready_for_windows(plan) == Some(true) {
            return Ok(());
        }
        let last = plan.passes.last().ok_or(GpuError::NotDrawn("a plan without passes"))?;
        let size = Extent3d { width: last.width, height: last.height, depth_or_array_layers: 1 };
        self.guarded(plan, || {
            let mut state = self.windows.lock();
            for format in WINDOW_FORMATS {
                let onto = self.device.create_texture(&TextureDescriptor {
                    label: Some("no window"),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: TextureDimension::D2,
                    format,
                    usage: TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                });
                self.submit(&mut state, plan, modules, RenderTarget::Given(&onto))?;
            }
            self.device.poll(PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
            Ok(())
        })
    }

    /// Whether a window's frame can be drawn without waiting for a compiler, whatever format the window has; `None`: one is being drawn just now.
    pub fn is_ready_for_windows(&self, plan: &Plan) -> Option<bool> {
        let state = self.windows.try_lock()?;
        Some(WINDOW_FORMATS.into_iter().all(|format| state.is_ready(plan, |_| format)))
    }

    /// Draws the plan onto the window. False where the system has no room for a picture just now (a window that is hidden), or windows are
    /// being made ready: nothing happened. `about_to_show` is called only if something will: some systems then wait for it.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`]: after one the screen is to be dropped.
    pub fn show(
        &self,
        screen: &mut GpuSurface,
        plan: &Plan,
        modules: &impl ModuleProvider,
        about_to_show: impl FnOnce(),
    ) -> Result<bool, GpuError> {
        let last = plan.passes.last().ok_or(GpuError::NotDrawn("a plan without passes"))?;
        let size = [last.width, last.height];
        let Some(mut state) = self.windows.try_lock() else { return Ok(false) };
        self.guarded(plan, || {
            let Some(next) = self.next(screen, size)? else { return Ok(false) };
            self.submit(&mut state, plan, modules, RenderTarget::Given(&next.texture))?;
            about_to_show();
            self.queue.present(next);
            Ok(true)
        })
    }

    /// Whether the surface has the window's size. False where it could not be given that just now: wgpu refuses while another thread draws, which passes.
    fn fitted(&self, screen: &mut GpuSurface, size: [u32; 2]) -> Result<bool, GpuError> {
        if screen.configured == Some(size) {
            return Ok(true);
        }
        screen.configured = None;
        let tried =
            caught(&self.device, || screen.configure(self, size)).or_else(|_| caught(&self.device, || screen.configure(self, size)));
        self.still_there()?;
        match tried {
            Ok(()) => {
                (screen.configured, screen.failed_resizes) = (Some(size), 0);
                Ok(true)
            }
            Err(e) if screen.failed_resizes >= MAX_FAILED_RESIZES => Err(e),
            Err(_) => {
                screen.failed_resizes += 1;
                Ok(false)
            }
        }
    }

    /// The picture to draw on next; `None`: not now.
    fn next(&self, screen: &mut GpuSurface, size: [u32; 2]) -> Result<Option<SurfaceTexture>, GpuError> {
        // A surface that no longer fits its window is fitted once.
        for _ in 0..2 {
            if !self.fitted(screen, size)? {
                return Ok(None);
            }
            match screen.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(next) => return Ok(Some(next)),
                CurrentSurfaceTexture::Suboptimal(next) => {
                    screen.configured = None;
                    return Ok(Some(next));
                }
                CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(None),
                CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => screen.configured = None,
                CurrentSurfaceTexture::Validation => return Err(GpuError::Refused("a picture for the window".into())),
            }
        }
        self.still_there()?;
        // A window that is being resized.
        Ok(None)
    }
}

impl GpuSurface {
    fn configure(&self, renderer: &GpuRenderer, [width, height]: [u32; 2]) {
        let config = SurfaceConfiguration {
            usage: TextureUsages::RENDER_ATTACHMENT,
            format: self.format,
            color_space: SurfaceColorSpace::default(),
            width,
            height,
            present_mode: PresentMode::AutoVsync,
            desired_maximum_frame_latency: 1,
            alpha_mode: self.alpha_mode,
            view_formats: Vec::new(),
        };
        self.surface.configure(&renderer.device, &config);
    }
}
