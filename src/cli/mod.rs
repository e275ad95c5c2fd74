//! The command line: words in, results on standard output, messages on standard error.
//!
//! Exit status 0 done, 1 it could not be done (one clear line says why and what to do), 2 the words are wrong. A verb is one file
//! with its arguments and a `run`; nothing here computes anything.

use crate::catalog::EclipseRadii;
use crate::render::plan::Fineness;
use crate::session::{RendererWish, SessionError, Sources};
use crate::wording::{echo_of, harmless};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

mod bench;
mod compare;
mod doctor;
mod documents;
mod ephemeris;
mod explain;
mod frames;
mod inputs;
mod library;
mod output;
mod probe;
mod render;
mod shader;
mod view;
mod view_words;

/// Text under the verbs.
const DEFAULT_VERB: &str = "Without a verb the words are those of `view`:
  orrery --target saturn --time 2017-05-17T00:00:00Z
  orrery 'orrery://view?target=599&time=2015-01-24T06:45:00Z'

Examples:
  orrery
  orrery render --target earth --time 2024-04-08T18:17:16Z -o earth.png
  orrery explain --target jupiter --from earth
  orrery <VERB> --help";

#[derive(Parser)]
#[command(name = "orrery", version, about = "A solar-system viewer whose planets are drawn by generated shaders", after_help = DEFAULT_VERB)]
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
    /// Completions of verbs and options for a shell
    Completions(documents::CompletionsArgs),
    /// The manual page
    Man(documents::ManArgs),
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
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// Which renderer draws
    #[arg(long, global = true, value_enum, default_value = "auto")]
    pub renderer: RendererChoice,
    /// Trade of speed for accuracy: draft has one sample a pixel, standard four, reference four in f64
    #[arg(long, global = true, value_enum, default_value = "standard")]
    pub quality: Quality,
    /// Shader fragments laid over the built-in ones, by their paths inside shaders/ (`orrery shader export` writes them)
    #[arg(long, global = true, value_name = "DIR")]
    pub shaders: Option<PathBuf>,
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

/// Why a verb ended early.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// It could not be done: one line that says why and what to do.
    #[error("{0}")]
    Failed(String),
    /// The reader of standard output has seen enough, as in `orrery shader keys | head`.
    #[error("standard output was closed")]
    OutputClosed,
}

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
            shaders: self.shaders.clone(),
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
        Self::Failed(e.to_string())
    }
}

/// A word of the command line that messages show at most so much of.
const WORD_ECHO: usize = 60;

/// The words, by way of `view` where they name no verb.
fn parsed(words: &[OsString]) -> Result<Cli, clap::Error> {
    let e = match Cli::try_parse_from(words) {
        Err(e) if matches!(e.kind(), ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand) => e,
        done => return done,
    };
    let verbs = Cli::command();
    let is_verb = |word: &OsString| verbs.get_subcommands().any(|v| word == v.get_name());
    let kept_view = match e.get(ContextKind::InvalidSubcommand) {
        // A verb with a slip of the finger opens no window.
        Some(ContextValue::String(word)) => word.contains("://") || word.ends_with(".json") || std::path::Path::new(word).is_file(),
        _ => true,
    };
    if !kept_view || words.iter().skip(1).any(is_verb) {
        return Err(e);
    }
    let viewed = words.iter().take(1).cloned().chain([OsString::from("view")]).chain(words.iter().skip(1).cloned());
    Cli::try_parse_from(viewed)
}

/// Prints what clap has to say, with long words cut and nothing that steers a terminal.
fn print_parser(e: &clap::Error, words: &[OsString]) {
    let mut given: Vec<String> = Vec::new();
    for word in words.iter().skip(1) {
        let word = word.to_string_lossy().into_owned();
        given.extend(word.split_once('=').map_or(Vec::new(), |(name, value)| vec![name.to_owned(), value.to_owned()]));
        given.push(word);
    }
    given.retain(|word| echo_of(word, WORD_ECHO) != *word);
    if given.is_empty() || !e.use_stderr() {
        let _ = e.print();
        return;
    }
    given.sort_by_key(|word| std::cmp::Reverse(word.len()));
    let said = given.iter().fold(e.render().to_string(), |said, word| said.replace(word.as_str(), &echo_of(word, WORD_ECHO)));
    output::write_error(&harmless(&said));
}

/// Runs the program for the process's arguments.
pub fn run() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    let cli = match parsed(&words) {
        Ok(cli) => cli,
        Err(e) => {
            print_parser(&e, &words);
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
        Some(Verb::Completions(a)) => documents::completions(a),
        Some(Verb::Man(a)) => documents::manual(a),
    };
    match done {
        Ok(()) | Err(CliError::OutputClosed) => ExitCode::SUCCESS,
        Err(e) => {
            output::say(&e.to_string());
            ExitCode::FAILURE
        }
    }
}
