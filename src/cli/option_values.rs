//! The command line's names for the variants of enums that other modules define.
//!
//! In: nothing. Out: clap's lists of option values. Always: each choice has one enum, which the command line shares with the modules below it.

use crate::catalog::EclipseRadii;
use crate::ephemeris::Source;
use crate::render::software::Precision;
use crate::scene::request::{Projection, Quality, StereoLayout};
use crate::session::RendererPreference;
use crate::shader::translate::Language;
use clap::ValueEnum;
use clap::builder::PossibleValue;

macro_rules! values {
    ($choice:ty: $($variant:ident $name:literal),*) => {
        impl ValueEnum for $choice {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),*]
            }
            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(PossibleValue::new(match self { $(Self::$variant => $name),* }))
            }
        }
    };
}

values!(RendererPreference: Auto "auto", Gpu "gpu", Software "software");
values!(Quality: Draft "draft", Standard "standard", Reference "reference");
values!(EclipseRadii: Iau "iau", Almanac "almanac");
values!(Source: Mean "mean", Series "series", Kernel "kernel");
values!(Precision: F32 "f32", F64 "f64");
values!(Language: Wgsl "wgsl", Hlsl "hlsl", Glsl "glsl", Msl "msl", Spirv "spirv", Assembly "spirv-text", Ir "ir");
values!(Projection: Perspective "perspective", Fisheye "fisheye", Equirectangular "equirectangular");
values!(StereoLayout: Anaglyph "anaglyph", SideBySide "side-by-side", Interlaced "interlaced");
