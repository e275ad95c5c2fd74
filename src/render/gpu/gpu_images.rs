//! Finished images in GPU memory. An image is kept at least as long as a [`GpuImage`] handle to it exists: each registration drops the images without a handle.

use crate::render::plan::GpuImage;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};
use wgpu::TextureView;

/// The next image's id. Ids are unique in the process, so that no device mistakes another device's image for one of its own.
static NEXT_ID: AtomicU64 = AtomicU64::new(0);

#[derive(Default)]
pub(crate) struct GpuImages {
    /// By id: the view of the image's texture, and a weak reference to the `Arc` that all handles of the image share. Once no handle is left, it cannot
    /// be upgraded.
    by_id: HashMap<u64, (Weak<u64>, TextureView)>,
}

impl GpuImages {
    /// Keeps an image of this size in pixels, and returns its first handle.
    pub(crate) fn register(&mut self, view: TextureView, [width, height]: [u32; 2]) -> GpuImage {
        self.by_id.retain(|_, (handles, _)| handles.strong_count() > 0);
        let id = Arc::new(NEXT_ID.fetch_add(1, Ordering::Relaxed));
        self.by_id.insert(*id, (Arc::downgrade(&id), view));
        GpuImage { id, width, height }
    }

    /// The view of an image's texture; `None` for an image of another device.
    pub(crate) fn get(&self, image: &GpuImage) -> Option<TextureView> {
        self.by_id.get(&*image.id).map(|(_, view)| view.clone())
    }
}
