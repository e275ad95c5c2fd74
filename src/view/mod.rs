//! The window: the user browses the solar system, runs time, sets effects and inspects the shaders of the drawn bodies.
//!
//! In: a session and input events. Out: a window, which the GPU that renders the images presents, or else the CPU. This module computes
//! neither positions nor light; both come from the session.
//!
//! - `app`: the state, and the actions that change it.
//! - `link`: views as text, written and read back; `opened_file`: files with views, tours and data.
//! - `language`: all texts, in the window's language; `error_texts`: those of errors.
//! - `worker`: threads that render images and answer queries.
//! - `panels`: the interface, which tests run without a window.
//! - `window`: the event loop, and the presentation of images.

pub mod app;
pub(crate) mod error_texts;
pub mod language;
pub mod link;
pub mod opened_file;
pub mod panels;
pub mod window;
pub mod worker;
