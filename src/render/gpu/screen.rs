//! A window that the device draws on itself: no pixel goes through the processor.
//!
//! In: a window's handle, and plans of its size. Out: what the window shows next. Always: the surface has the size of the last plan; bytes of a plan are
//! shown as they are, since they are encoded for the display already. Not here: what is shown, and when.

use super::renderer::{Onto, State};
use super::{GpuError, GpuRenderer};
use crate::render::plan::{Modules, Plan};
use wgpu::{
    CompositeAlphaMode, CurrentSurfaceTexture, PresentMode, Surface, SurfaceColorSpace, SurfaceConfiguration, SurfaceTexture,
    TextureFormat, TextureUsages,
};

/// A window's handle.
pub trait Showable: wgpu::DisplayAndWindowHandle + 'static {}
impl<T: wgpu::DisplayAndWindowHandle + 'static> Showable for T {}

/// A window's surface on one renderer's device.
pub struct GpuScreen {
    surface: Surface<'static>,
    format: TextureFormat,
    alpha_mode: CompositeAlphaMode,
    configured: Option<[u32; 2]>,
    /// Of the window's own frames: none of them waits for a picture that is being drawn.
    state: State,
}

impl GpuRenderer {
    /// A surface for the window.
    ///
    /// # Errors
    /// The adapter that draws cannot show anything there.
    pub fn screen(&self, window: impl Showable) -> Result<GpuScreen, GpuError> {
        let refused = |why: String| GpuError::Adapter { adapter: self.facts().to_string(), why };
        let surface = self.instance.create_surface(window).map_err(|e| refused(super::one_line(&e.to_string())))?;
        let able = surface.get_capabilities(&self.adapter);
        let plain = |f: &&TextureFormat| matches!(f, TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm);
        let format = *able.formats.iter().find(plain).ok_or_else(|| refused("it cannot show 8-bit pixels in this window".into()))?;
        let alpha_mode =
            if able.alpha_modes.contains(&CompositeAlphaMode::Opaque) { CompositeAlphaMode::Opaque } else { CompositeAlphaMode::Auto };
        Ok(GpuScreen { surface, format, alpha_mode, configured: None, state: State::default() })
    }

    /// Draws the plan onto the window. False where the system has no room for a picture just now (a window that is hidden): nothing happened.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`]: after one the screen is to be dropped.
    pub fn show(&self, screen: &mut GpuScreen, plan: &Plan, modules: &impl Modules) -> Result<bool, GpuError> {
        let last = plan.passes.last().ok_or(GpuError::NotDrawn("a plan without passes"))?;
        let size = [last.width, last.height];
        self.guarded(plan, || {
            let Some(next) = self.next(screen, size)? else { return Ok(false) };
            self.submit(&mut screen.state, plan, modules, Onto::Given(&next.texture))?;
            self.queue.present(next);
            Ok(true)
        })
    }

    /// The picture to draw on next; `None`: not now.
    fn next(&self, screen: &mut GpuScreen, size: [u32; 2]) -> Result<Option<SurfaceTexture>, GpuError> {
        // A surface that no longer fits its window is fitted once.
        for _ in 0..2 {
            if screen.configured != Some(size) {
                screen.configure(self, size);
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

impl GpuScreen {
    /// Forgets what was made of modules: those of the same names are no longer the same.
    pub fn forget_modules(&mut self) {
        self.state.forget_modules();
    }

    fn configure(&mut self, renderer: &GpuRenderer, [width, height]: [u32; 2]) {
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
        self.configured = Some([width, height]);
    }
}
