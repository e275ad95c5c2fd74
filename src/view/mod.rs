//! The window: browse the system, run time, set effects, inspect the shaders of what is drawn.
//!
//! In: a session and input events. Out: a window, displayed by the GPU that draws the images, or by the CPU. It computes no positions and no
//! light of its own.
//!
//! `app` holds the state and how actions change it; `link` writes and reads views as text; `worker` draws and answers off the window's
//! thread; `panels` is the interface, which needs no window; `window` is the event loop and the ways to get pixels on screen.

pub mod app;
pub mod language;
pub mod link;
pub mod panels;
pub mod window;
pub mod worker;
