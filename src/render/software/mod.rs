//! The software renderer: executes a plan's passes on the CPU.
//!
//! In: a plan and its lowered modules. Out: a frame and its timings. The entry point is [`renderer`].
//!
//! [`lower`] turns each entry point of a module's naga IR into a [`program`]. A program's tape is a list of instructions, each of which computes a scalar for
//! many lanes at once. A lane is a pixel or a vertex. [`exec`] runs the tape with SIMD [`kernels`]; [`sample`] reads textures for it. [`raster`] turns
//! triangles into covered quads of 2x2 pixels.
//!
//! [`vertex`] turns a draw into triangles, [`pass`] sorts them into tiles and distributes the tiles over the cores, [`shade`] fills batches of 128 lanes
//! (`lane_inputs`) and runs them. `coarse_shading` shades smooth light at fewer points. [`tiles`] stores a tile's colour, `tile_depth` its depth, and
//! `tile_rows` writes the tile into the image. `pass_fusion` lets the tone map read the tiles of an HDR image that is never stored; [`tone_map`] computes the
//! tone map in native code instead of running its tape, unless the user has edited its shader.

pub mod blend;
mod coarse_shading;
pub mod error;
pub mod exec;
pub mod fragment_setup;
mod inspect_pixel;
pub mod kernels;
mod lane_inputs;
pub mod lower;
pub mod math;
mod nearest_triangle;
pub mod pass;
mod pass_fusion;
mod prepared_draw;
pub mod program;
pub mod raster;
pub mod renderer;
pub mod sample;
pub mod shade;
pub mod stage;
pub mod tape;
mod tape_stage;
mod texel_marks;
mod tile_depth;
mod tile_rows;
pub mod tiles;
pub mod timings;
pub mod tone_map;
mod tone_map_run;
pub mod vertex;

pub use error::RenderError;
use error::{try_grow, try_vec};
pub(crate) use inspect_pixel::{NamedValue, PixelValues};
// The functions with which the shader library lowers and stores modules.
pub use lower::lowering;
pub use raster::setup::VertexGrid;
pub use renderer::{Options, Precision, SoftwareRenderer};
pub(crate) use timings::Timings;

/// Maximum width and maximum height of a pass, in pixels.
pub(crate) const MAX_SIDE_PX: u32 = 16384;
