//! The window: orbit, zoom, walk from body to body, run time. Software frames are presented without any GPU.
//!
//! In: input events and finished frames. Out: view requests. It computes no positions and no light.

pub mod controls;
pub mod orbit;
pub mod pace;
pub mod window;
