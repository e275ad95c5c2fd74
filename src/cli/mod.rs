//! The command line: words in, results on standard output, messages on standard error.
//!
//! Exit status 0 done, 1 it could not be done (one clear line says why and what to do), 2 the words are wrong. A verb is one file
//! with its arguments and a `run`; nothing here computes anything.

use crate::catalog::EclipseRadii;
use crate::render::plan::Fineness;
use crate::session::{RendererWish, SessionError, Sources};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

mod bench;
mod compare;
mod doctor;
mod ephemeris;
mod explain;
mod inputs;
mod library;
mod output;
mod probe;
mod render;
mod shader;
mod view;
mod view_words;

#[derive(Parser)]
#[command(name = "orrery", version, about = "A solar-system viewer whose planets are drawn by generated shaders")]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Subcommand)]
enum Verb {
    /// Open the window (default)
    View(view::ViewArgs),
    /// Render one image, or a run of frames, to files
    Render(render::RenderArgs),
    /// Print for a view every body, what its draw got and did not get, and why
    Explain(explain::ExplainArgs),
    /// List, emit, compare, cost and verify generated shaders
    Shader(shader::ShaderArgs),
    /// The shader library on disk
    Library(library::LibraryArgs),
    /// Positions and orientations of bodies
    Ephemeris(ephemeris::EphemerisArgs),
    /// Questions that the emitted shaders answer themselves
    Probe(probe::ProbeArgs),
    /// How far two pictures are from each other
    Compare(compare::CompareArgs),
    /// Milliseconds per frame of the standard scenes, by stage
    Bench(bench::BenchArgs),
    /// What is there, what is missing, what to do
    Doctor(doctor::DoctorArgs),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum RendererChoice {
    Auto,
    Gpu,
    Software,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Quality {
    Draft,
    Standard,
    Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Radii {
    Iau,
    Almanac,
}

/// Options that every verb takes.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Which renderer draws
    #[arg(long, global = true, value_enum, default_value = "auto")]
    pub renderer: RendererChoice,
    /// Trade of speed for accuracy: draft has one sample a pixel, standard four, reference four in f64
    #[arg(long, global = true, value_enum, default_value = "standard")]
    pub quality: Quality,
    /// Where the shader library lives
    #[arg(long, global = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Catalog files that override or add bodies
    #[arg(long, global = true, value_name = "DIR")]
    pub catalogs: Option<PathBuf>,
    /// Maps that come before the embedded ones
    #[arg(long, global = true, value_name = "DIR")]
    pub textures: Option<PathBuf>,
    /// A SPICE SPK file such as DE440
    #[arg(long, global = true, value_name = "FILE")]
    pub kernel: Option<PathBuf>,
    /// Radii of the Sun and the Moon in eclipses: the IAU's of 2015, or those of printed almanacs
    #[arg(long, global = true, value_enum, default_value = "iau")]
    pub radii: Radii,
    /// Worker threads (default: one per core)
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
    /// More messages
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// It could not be done: one line that says why and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct CliError(pub String);

impl Quality {
    /// What scene knows it as.
    pub fn of_request(self) -> crate::scene::request::Quality {
        match self {
            Self::Draft => crate::scene::request::Quality::Draft,
            Self::Standard => crate::scene::request::Quality::Standard,
            Self::Reference => crate::scene::request::Quality::Reference,
        }
    }
    /// Samples a pixel and taps of anisotropic filtering. `reference` computes in f64 too.
    pub fn fineness(self) -> Fineness {
        Fineness::of(self.of_request())
    }
}

impl Common {
    /// The same for a verb that draws frames.
    pub fn sources_to_draw(&self) -> Sources {
        Sources { draws: true, ..self.sources() }
    }

    /// What the catalog knows `--radii` as.
    pub fn eclipse_radii(&self) -> EclipseRadii {
        match self.radii {
            Radii::Iau => EclipseRadii::Iau,
            Radii::Almanac => EclipseRadii::Almanac,
        }
    }

    /// The files and folders that the user named.
    pub fn sources(&self) -> Sources {
        Sources {
            catalogs: self.catalogs.clone(),
            eclipse_radii: self.eclipse_radii(),
            textures: self.textures.clone(),
            kernel: self.kernel.clone(),
            cache: self.cache.clone(),
            threads: self.threads,
            double_precision: self.quality == Quality::Reference,
            renderer: match self.renderer {
                RendererChoice::Auto => RendererWish::Auto,
                RendererChoice::Gpu => RendererWish::Gpu,
                RendererChoice::Software => RendererWish::Software,
            },
            draws: false,
        }
    }
}

impl From<SessionError> for CliError {
    fn from(e: SessionError) -> Self {
        Self(e.to_string())
    }
}

/// Runs the program for the process's arguments.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() { 2 } else { 0 });
        }
    };
    let common = &cli.common;
    let done = match &cli.verb {
        None => view::run(common, &view::ViewArgs::default()),
        Some(Verb::View(a)) => view::run(common, a),
        Some(Verb::Render(a)) => render::run(common, a),
        Some(Verb::Explain(a)) => explain::run(common, a),
        Some(Verb::Shader(a)) => shader::run(common, a),
        Some(Verb::Library(a)) => library::run(common, a),
        Some(Verb::Ephemeris(a)) => ephemeris::run(common, a),
        Some(Verb::Probe(a)) => probe::run(common, a),
        Some(Verb::Compare(a)) => compare::run(common, a),
        Some(Verb::Bench(a)) => bench::run(common, a),
        Some(Verb::Doctor(a)) => doctor::run(common, a),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("orrery: {e}");
            ExitCode::FAILURE
        }
    }
}
