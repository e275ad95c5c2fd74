//! The window: the user browses the solar system, runs time, sets effects and inspects the shaders of the drawn bodies.
//!
//! In: a session and input events. Out: a window, presented by the GPU that renders the images, or by the CPU. This module computes neither
//! positions nor light; both come from the session.
//!
//! `app` contains the state and the actions that change it; `link` writes and reads views as text; `language` has the texts in the window's language,
//! and `error_texts` those of errors; `worker` renders images and answers queries on threads of its own; `panels` is the interface, which tests run
//! without a window; `window` has the event loop and the presentation.

pub mod app;
pub(crate) mod error_texts;
pub mod language;
pub mod link;
pub mod panels;
pub mod window;
pub mod worker;
