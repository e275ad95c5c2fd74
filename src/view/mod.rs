//! The window: browse the system, run time, switch effects, read what draws it.
//!
//! In: a session, input. Out: a window whose picture and interface are painted on the processor, GPU or not. It computes no positions and no
//! light of its own.

pub mod answers;
pub mod first;
pub mod flight;
pub mod interface;
pub mod kept;
pub mod moments;
pub mod orbit;
pub mod pace;
pub mod paint;
pub mod place;
pub mod settings;
pub mod sight;
pub mod studio;
pub mod tempo;
pub mod viewer;
pub mod watch;
pub mod window;
