//! The window: browse the system, run time, switch effects, read what draws it.
//!
//! In: a session, input. Out: a window, shown by the device that draws its pictures, or by the processor where none does. It computes no positions and no
//! light of its own.

pub mod adaptation;
mod answers;
pub mod first;
pub mod flight;
pub mod interface;
pub mod kept;
pub mod moments;
pub mod names;
mod option_text;
pub mod orbit;
pub mod pace;
pub mod paint;
pub mod pieces;
pub mod place;
pub mod places;
pub mod present;
pub mod settings;
pub mod sight;
pub mod studio;
pub mod tempo;
pub mod viewer;
pub mod watch;
pub mod window;
