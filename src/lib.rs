//! Orrery: a solar-system viewer whose planets are drawn by generated shaders.
//!
//! The main modules are the stages of a pipeline. ARCHITECTURE.md contains a diagram, and `tests/project/layering.rs` checks which module may use which:
//!
//! [`catalog`] + [`time`] → [`ephemeris`] → [`scene`] → [`shader`] → [`render`] → [`image`] → [`view`] or [`cli`].
//!
//! # Use as a library
//!
//! The public interface is what this documentation shows: the names re-exported here, the starting points of most programs, and the modules
//! [`catalog`], [`time`], [`ephemeris`], [`scene`] (the request and the finished scene), [`shader`], [`session`], [`message`] and [`units`]. Each of their
//! items has a doc comment (the lint `missing_docs` checks this). Every other module is private, or public only for the tests and benches
//! of this package; it is hidden from the documentation and may change with any commit. All errors are returned as values. No module uses the
//! network, and only the command line takes the time of a view from the system clock, for `now`.
//!
//! Render an image (`&[]`: no texts in the file):
//!
//! ```no_run
//! use orrery::{FrameImages, SamplingQuality, Instant, NaifId, Session, Sources, ViewRequest, write_image};
//!
//! let session = Session::open(&Sources::default(), |message| eprintln!("{message}"))?;
//! let request = ViewRequest::of(NaifId::EARTH, Instant::parse("2024-04-08T18:17:16Z")?);
//! let drawn = session.draw(&request, SamplingQuality::of(request.quality), FrameImages::Display)?;
//! write_image("earth.png".as_ref(), &drawn.frame, &[])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Compute the geometric position of the Moon relative to the Earth (kilometres, ICRF) with its error bound; `None` selects the best source:
//!
//! ```no_run
//! use orrery::{Catalog, Ephemeris, Instant, NaifId};
//!
//! let ephemeris = Ephemeris::embedded(&Catalog::embedded())?;
//! let time = Instant::parse("2024-04-08T18:17:16Z")?;
//! let moon = ephemeris.state(NaifId::MOON, NaifId::EARTH, time, None)?;
//! println!("{} km, within {} km", moon.state.pos_km, moon.error_km);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Emit a shader:
//!
//! ```no_run
//! use orrery::shader::translate::{Language, translate};
//! use orrery::{Fragments, ShaderModule, lowering};
//!
//! let module = ShaderModule::build_with(&Fragments::default(), &"lambert.albedo.sun1.ellipsoid".parse()?, &lowering())?;
//! println!("{}", translate(&module, Language::Hlsl)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

pub mod catalog;
#[doc(hidden)]
pub mod cli;
pub mod ephemeris;
#[doc(hidden)]
pub mod events;
#[doc(hidden)]
pub mod export;
mod files;
#[doc(hidden)]
pub mod image;
mod json;
#[doc(hidden)]
pub mod measure;
mod memo;
#[doc(hidden)]
pub mod mesh;
pub mod message;
#[doc(hidden)]
pub mod probe;
mod random;
#[doc(hidden)]
pub mod render;
pub mod scene;
pub mod session;
pub mod shader;
#[doc(hidden)]
pub mod stability;
pub mod time;
pub mod units;
mod unwinding;
#[cfg(feature = "view")]
#[doc(hidden)]
pub mod view;
#[doc(hidden)]
pub mod wording;

pub use catalog::{Catalog, NaifId};
pub use ephemeris::Ephemeris;
pub use files::WriteError;
pub use render::frame::Frame;
pub use render::plan::{FrameImages, SamplingQuality};
pub use render::software::lowering;
pub use scene::request::ViewRequest;
pub use session::{Session, Sources, write_image};
pub use shader::ShaderModule;
pub use shader::fragments::Fragments;
pub use time::Instant;
