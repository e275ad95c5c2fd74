//! The values of options that select a variant of an enum: the name of each variant on the command line.
//!
//! In: enums of the modules below the command line. Out: for each, an implementation of clap's `ValueEnum`, so that the command line needs no copies of the
//! enums.

use crate::catalog::EclipseRadii;
use crate::ephemeris::Source;
use crate::render::software::Precision;
use crate::scene::request::{Projection, Quality, StereoLayout};
use crate::session::RendererPreference;
use crate::shader::translate::Language;
use clap::ValueEnum;
use clap::builder::PossibleValue;

/// Implements `ValueEnum` for an enum, with a name for each variant.
macro_rules! option_values {
    ($enum_type:ty: $($variant:ident $name:literal),*) => {
        impl ValueEnum for $enum_type {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),*]
            }
            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(PossibleValue::new(match self { $(Self::$variant => $name),* }))
            }
        }
    };
}

option_values!(RendererPreference: Auto "auto", Gpu "gpu", Software "software");
option_values!(Quality: Draft "draft", Standard "standard", Reference "reference");
option_values!(EclipseRadii: Iau "iau", Almanac "almanac");
option_values!(Source: Mean "mean", Series "series", Kernel "kernel");
option_values!(Precision: F32 "f32", F64 "f64");
option_values!(Language: Wgsl "wgsl", Hlsl "hlsl", Glsl "glsl", Msl "msl", Spirv "spirv", Assembly "spirv-text", Ir "ir");
option_values!(Projection: Perspective "perspective", Fisheye "fisheye", Equirectangular "equirectangular");
option_values!(StereoLayout: Anaglyph "anaglyph", SideBySide "side-by-side", Interlaced "interlaced");
