//! Draws plans into a window's surface, without readback.
//!
//! In: a window's handle, and plans. Out: the window's next frame. Always: the surface gets the size of each plan; a plan's output bytes are shown unchanged,
//! because they are already encoded for the display. Not here: what is shown, and when.

use super::renderer::{FrameResources, RenderTarget};
use super::{GpuError, GpuRenderer, with_error_scopes};
use crate::render::plan::{ModuleProvider, Plan};
use wgpu::{
    CompositeAlphaMode, CurrentSurfaceTexture, Extent3d, PollType, PresentMode, Surface, SurfaceColorSpace, SurfaceConfiguration,
    SurfaceTexture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
};

/// The handles of a window from which wgpu creates a surface.
pub trait WindowHandle: wgpu::DisplayAndWindowHandle + 'static {}
impl<T: wgpu::DisplayAndWindowHandle + 'static> WindowHandle for T {}

/// A window's surface on one renderer's device.
pub(crate) struct GpuSurface {
    surface: Surface<'static>,
    format: TextureFormat,
    alpha_mode: CompositeAlphaMode,
    /// The size for which the surface is configured; `None` if it must be configured before the next frame.
    configured_size: Option<[u32; 2]>,
    /// Consecutive failures to configure the surface for the window's size.
    failed_resizes: u32,
}

/// Number of consecutive failures to configure a surface that are ignored; the next one is returned as an error. With one failure per frame and 60 frames per
/// second, they last two thirds of a second.
const MAX_FAILED_RESIZES: u32 = 40;

/// Formats that a window's surface may have. Of these, the one that the adapter lists first is used.
const WINDOW_FORMATS: [TextureFormat; 2] = [TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm];

impl GpuRenderer {
    /// Creates a surface for the window.
    ///
    /// # Errors
    /// The renderer's adapter cannot present to this window.
    pub(crate) fn create_surface(&self, window: impl WindowHandle) -> Result<GpuSurface, GpuError> {
        let unusable = |why: String| GpuError::Adapter { adapter: self.facts().to_string(), why };
        if super::x11::may_crash(self.facts(), &window) {
            return Err(unusable("this driver needs the GLX extension, which the X display lacks".into()));
        }
        let surface = self.instance.create_surface(window).map_err(|e| unusable(super::one_line(&e.to_string())))?;
        let capabilities = surface.get_capabilities(&self.adapter);
        let is_usable = |f: &&TextureFormat| WINDOW_FORMATS.contains(f);
        let format =
            *capabilities.formats.iter().find(is_usable).ok_or_else(|| unusable("it cannot show 8-bit pixels in this window".into()))?;
        let supports_opaque = capabilities.alpha_modes.contains(&CompositeAlphaMode::Opaque);
        let alpha_mode = if supports_opaque { CompositeAlphaMode::Opaque } else { CompositeAlphaMode::Auto };
        Ok(GpuSurface { surface, format, alpha_mode, configured_size: None, failed_resizes: 0 })
    }

    /// Draws the plan off screen in each window format, so that a window's first frame need not wait for pipelines: some drivers compile only at the first
    /// draw.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub fn warm_up_window_pipelines(&self, plan: &Plan, modules: &impl ModuleProvider) -> Result<(), GpuError> {
        if self.is_ready_for_windows(plan) == Some(true) {
            return Ok(());
        }
        let last = plan.passes.last().ok_or(GpuError::NoPass)?;
        let size = Extent3d { width: last.width, height: last.height, depth_or_array_layers: 1 };
        self.run_checked(plan, || {
            let mut resources = self.window_resources.lock();
            for format in WINDOW_FORMATS {
                let off_screen = self.device.create_texture(&TextureDescriptor {
                    label: Some("off-screen window frame"),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: TextureDimension::D2,
                    format,
                    usage: TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                });
                self.submit_to_window(&mut resources, plan, modules, &off_screen)?;
            }
            self.device.poll(PollType::wait_indefinitely()).map_err(|e| GpuError::DeviceLost(e.to_string()))?;
            Ok(())
        })
    }

    /// Submits a plan whose last pass draws to a window's texture, and removes that texture from `resources`, even after an error.
    fn submit_to_window(
        &self,
        resources: &mut FrameResources,
        plan: &Plan,
        modules: &impl ModuleProvider,
        texture: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let submitted = self.submit(resources, plan, modules, RenderTarget::External(texture));
        resources.targets.truncate(plan.passes.len().saturating_sub(1));
        submitted.map(|_| ())
    }

    /// Whether a frame can be drawn to a window of any supported format without waiting for the shader compiler; `None` while the windows'
    /// resources are in use, as in [`Self::warm_up_window_pipelines`].
    pub fn is_ready_for_windows(&self, plan: &Plan) -> Option<bool> {
        let resources = self.window_resources.try_lock()?;
        Some(WINDOW_FORMATS.into_iter().all(|format| resources.is_ready(plan, |_| format)))
    }

    /// Draws the plan to the window and presents it; returns whether it did so. It does not if the surface has no texture now, because the window is hidden or
    /// after a failure that may be temporary, or while the windows' resources are in use, as in [`GpuRenderer::warm_up_window_pipelines`].
    /// `before_present` is called right before presenting: some window systems need the notification.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`]; after an error the caller must drop the surface.
    pub(crate) fn present(
        &self,
        surface: &mut GpuSurface,
        plan: &Plan,
        modules: &impl ModuleProvider,
        before_present: impl FnOnce(),
    ) -> Result<bool, GpuError> {
        let last = plan.passes.last().ok_or(GpuError::NoPass)?;
        let size = [last.width, last.height];
        let Some(mut resources) = self.window_resources.try_lock() else { return Ok(false) };
        self.run_checked(plan, || {
            let Some(next) = self.next_texture(surface, size)? else { return Ok(false) };
            self.submit_to_window(&mut resources, plan, modules, &next.texture)?;
            before_present();
            self.queue.present(next);
            Ok(true)
        })
    }

    /// Configures the surface, unless it is configured for this size. Tries twice, because wgpu may fail to configure a surface while another thread draws.
    /// Returns false after two failures, which may be temporary.
    fn ensure_size(&self, surface: &mut GpuSurface, size: [u32; 2]) -> Result<bool, GpuError> {
        if surface.configured_size == Some(size) {
            return Ok(true);
        }
        surface.configured_size = None;
        let configure = || with_error_scopes(&self.device, || surface.configure(self, size));
        let result = configure().or_else(|_| configure());
        self.check_fatal_error()?;
        match result {
            Ok(()) => {
                (surface.configured_size, surface.failed_resizes) = (Some(size), 0);
                Ok(true)
            }
            Err(e) if surface.failed_resizes >= MAX_FAILED_RESIZES => Err(e),
            Err(_) => {
                surface.failed_resizes += 1;
                Ok(false)
            }
        }
    }

    /// The surface's next texture; `None` if no texture is available now.
    fn next_texture(&self, surface: &mut GpuSurface, size: [u32; 2]) -> Result<Option<SurfaceTexture>, GpuError> {
        // An outdated or lost surface is configured again once.
        for _ in 0..2 {
            if !self.ensure_size(surface, size)? {
                return Ok(None);
            }
            match surface.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(next) => return Ok(Some(next)),
                CurrentSurfaceTexture::Suboptimal(next) => {
                    surface.configured_size = None;
                    return Ok(Some(next));
                }
                CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(None),
                CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => surface.configured_size = None,
                CurrentSurfaceTexture::Validation => return Err(GpuError::DriverError("no texture for the window's next frame".into())),
            }
        }
        self.check_fatal_error()?;
        // Outdated or lost again, as may happen while the window is resized.
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
