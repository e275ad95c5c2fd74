//! The source tree itself: which module may use which.

mod layering;
