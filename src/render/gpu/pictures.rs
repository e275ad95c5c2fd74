//! Finished pictures that stay on the device, for as long as someone holds them.

use crate::render::plan::GpuImage;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};
use wgpu::TextureView;

/// The next picture's number: one sequence for all devices, so that no picture is taken for another device's.
static NEXT: AtomicU64 = AtomicU64::new(0);

#[derive(Default)]
pub struct Pictures {
    by_id: HashMap<u64, (Weak<u64>, TextureView)>,
}

impl Pictures {
    pub fn keep(&mut self, view: TextureView, [width, height]: [u32; 2]) -> GpuImage {
        self.by_id.retain(|_, (held, _)| held.strong_count() > 0);
        let id = Arc::new(NEXT.fetch_add(1, Ordering::Relaxed));
        self.by_id.insert(*id, (Arc::downgrade(&id), view));
        GpuImage { id, width, height }
    }

    /// `None`: it is another device's.
    pub fn get(&self, picture: &GpuImage) -> Option<TextureView> {
        self.by_id.get(&*picture.id).map(|(_, view)| view.clone())
    }
}
