//! Exports for use outside the program: a report on two revisions of the shader library, an atlas of its modules, a corpus for other
//! implementations of WGSL.
//!
//! In: the modules of one [`Revision`], or of two. Out: files, or a [`report::Report`]. Always: the software renderer draws the sample body of
//! [`crate::session::sample_body_plan_of`] with its portable kernels, so that the same modules give the same bytes on every machine. Not here: images of views
//! (`session`), and the wording of results (`cli`).

pub mod atlas;
pub mod corpus;
pub mod report;
pub mod revision;
pub mod sample_image;

pub use revision::{Revision, RevisionError};
