//! The command line: arguments in, results on standard output, messages on standard error. In code a command, such as `render`, is a `Verb`.
//!
//! Exit status:
//! - 0: success, even if the reader of standard output closes it early;
//! - 1: failure. A line on standard error states the reason and what to do; invalid catalog files get a line per invalid field;
//! - 2: the arguments are wrong, whether clap rejects them or a command: a word that is not known, a number out of range, options that exclude each other;
//! - none: a signal ended the process, which a shell reports as 128 + its number (`interrupt`).
//!
//! Each command's arguments and function are in a file of its name (`documents` for `completions` and `man`). The commands parse, call other modules and
//! format: the results themselves are computed by the modules below the command line.

use crate::catalog::{CatalogError, EclipseRadii};
use crate::files::WriteError;
use crate::image::DEFAULT_MAX_MEGAPIXELS;
use crate::scene::request::Quality;
use crate::scene::sky::frames::SkyFrame;
use crate::session::{RendererPreference, SessionError, Sources, SurfaceError, SurfaceFile};
use crate::wording::{echo_within, escape_controls};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

mod bench;
mod bench_meshes;
mod compare;
mod composition_args;
mod doctor;
mod documents;
mod eclipse;
mod eclipse_table;
mod ephemeris;
mod ephemeris_table;
mod explain;
mod frame_rate;
mod frames;
mod inputs;
mod interrupt;
mod library;
mod measure;
mod option_values;
mod output;
mod output_file;
mod probe;
mod render;
mod render_views;
mod shader;
mod shader_export;
mod shader_report;
mod stability;
mod stdin_lines;
mod video_output;
mod view;
mod view_args;

/// The end of `orrery --help`, below the options.
const AFTER_HELP: &str = "Without a command, the arguments are those of `view`:
  orrery --target saturn --time 2017-05-17T00:00:00Z
  orrery 'orrery://view?target=599&time=2015-01-24T06:45:00Z'

Examples:
  orrery
  orrery render --target earth --time 2024-04-08T18:17:16Z -o earth.png
  orrery explain --target jupiter --from earth
  orrery <COMMAND> --help";

#[derive(Parser)]
#[command(name = "orrery", version, about = "A solar-system viewer whose planets are drawn by generated shaders", after_help = AFTER_HELP)]
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
    /// Render an image or a sequence of frames to files
    Render(render::RenderArgs),
    /// Explain which effects each body of a view has, and why
    Explain(explain::ExplainArgs),
    /// List, emit, compare, measure and verify the generated shaders
    Shader(shader::ShaderArgs),
    /// Manage the disk cache: shader library and decoded maps
    Library(library::LibraryArgs),
    /// Compute positions and orientations of bodies
    Ephemeris(ephemeris::EphemerisArgs),
    /// Find eclipses, transits and phenomena of the Galilean moons and Titan
    Eclipse(eclipse::EclipseArgs),
    /// Evaluate single quantities with the generated shaders
    Probe(probe::ProbeArgs),
    /// Measure the difference between two images
    Compare(compare::CompareArgs),
    /// Measure speed against accuracy: time and error of alternative models and settings
    Measure(measure::MeasureArgs),
    /// Test extreme views: f32 against f64, pairs of images that should be equal, and positions against an independent computation
    Stability(stability::StabilityArgs),
    /// Measure frame times of the standard scenes, by stage
    Bench(bench::BenchArgs),
    /// Check graphics adapters, data files and caches
    Doctor(doctor::DoctorArgs),
    /// Generate shell completions
    Completions(documents::CompletionsArgs),
    /// Generate the manual page
    Man(documents::ManArgs),
}

/// Options that every command takes.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Common options")]
pub(crate) struct Common {
    /// Renderer: auto uses a hardware GPU if there is one, otherwise the software renderer
    #[arg(long, global = true, value_enum, default_value = "auto")]
    pub renderer: RendererPreference,
    /// Quality: draft uses 1 sample per pixel, standard 4, reference 4 in f64
    #[arg(long, global = true, value_enum, default_value = "standard")]
    pub quality: Quality,
    /// Folder of shader sources that replace built-in ones (`orrery shader export` writes them)
    #[arg(long, global = true, value_name = "DIR")]
    pub shaders: Option<PathBuf>,
    /// Shader source that colours the ground of a body, BODY=FILE, with `fn custom_surface(point: SurfacePoint) -> CustomSurface`; repeat for up to four bodies
    #[arg(long, global = true, value_name = "BODY=FILE")]
    pub surface: Vec<SurfaceFile>,
    /// Folder of the disk cache: shader library, decoded maps, tables
    #[arg(long, global = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Folder of catalog files that override or add bodies
    #[arg(long, global = true, value_name = "DIR")]
    pub catalogs: Option<PathBuf>,
    /// Folder of maps, which replace embedded ones of the same name, and of shape models
    #[arg(long, global = true, value_name = "DIR")]
    pub textures: Option<PathBuf>,
    /// Largest image that is read, in millions of pixels
    #[arg(long, global = true, value_name = "N", default_value_t = DEFAULT_MAX_MEGAPIXELS, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub max_megapixels: u32,
    /// SPICE SPK file, such as DE440, that takes precedence over the embedded kernel
    #[arg(long, global = true, value_name = "FILE")]
    pub kernel: Option<PathBuf>,
    /// Stars in place of the embedded ones: CSV with named columns (ra_deg, ra_hours or rarad; dec_deg or decrad; v_mag; ...) such as
    /// the HYG database, or Hipparcos' hip2.dat
    #[arg(long, global = true, value_name = "FILE")]
    pub stars: Option<PathBuf>,
    /// Minor planets and comets in place of the embedded ones: CSV with named columns (e, a_au or q_au, i_deg, node_deg, argp_deg, M_deg and epoch_mjd or tp_jd, H or M1),
    /// JSON from JPL's Small-Body Database, or MPCORB.DAT
    #[arg(long, global = true, value_name = "FILE")]
    pub minor_planets: Option<PathBuf>,
    /// Panorama in place of the Milky Way: PNG, JPEG or EXR (cd/m2), equirectangular with longitude 0 in the middle, increasing to the left; or a folder with the faces
    /// px, nx, py, ny, pz, nz of a cube, or a file name pattern with * for the face
    #[arg(long, global = true, value_name = "FILE")]
    pub sky: Option<PathBuf>,
    /// Height map of the entire Moon, for its limb in solar eclipses: grey PNG or TIFF with longitude 0 in the middle, or a PDS label or image such as LDEM_16.LBL;
    /// FILE,LOW,HIGH gives the heights of black and white in km, which 8-bit files need
    #[arg(long, global = true, value_name = "FILE[,LOW,HIGH]")]
    pub lunar_heights: Option<OsString>,
    /// Axes of --sky: galactic, equatorial (ICRF) or ecliptic (J2000)
    #[arg(long, global = true, value_name = "FRAME", default_value = "galactic", value_parser = SkyFrame::by_name)]
    pub sky_frame: SkyFrame,
    /// Radii of the Sun and the Moon in eclipses: IAU 2015, or those of printed almanacs
    #[arg(long, global = true, value_enum, default_value = "iau")]
    pub radii: EclipseRadii,
    /// Number of worker threads [default: one per core]
    #[arg(long, global = true, value_name = "N", value_parser = thread_count)]
    pub threads: Option<usize>,
    /// Print the time taken to standard error; `render` also prints the renderer and the time of each stage
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// A failure without a variant of its own: one line that states the reason and what to do.
    #[error("{0}")]
    Failed(String),
    /// Wrong arguments: one line that names the option.
    #[error("{0}")]
    Usage(String),
    /// Invalid fields of catalog files, one per line.
    #[error(transparent)]
    Catalog(#[from] CatalogError),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The process that reads standard output has closed it, as in `orrery shader keys | head`.
    #[error("standard output was closed")]
    OutputClosed,
}

impl Common {
    /// The user's sources for commands that draw frames: the GPU is opened while the catalogs are read.
    pub(crate) fn sources_for_drawing(&self) -> Sources {
        Sources { will_draw: true, ..self.sources() }
    }

    /// The user's sources for commands that draw no frames.
    pub(crate) fn sources(&self) -> Sources {
        Sources {
            catalogs: self.catalogs.clone(),
            eclipse_radii: self.radii,
            textures: self.textures.clone(),
            max_megapixels: Some(self.max_megapixels),
            kernel: self.kernel.clone(),
            stars: self.stars.clone(),
            minor_planets: self.minor_planets.clone(),
            lunar_heights: self.lunar_heights.clone(),
            sky: self.sky.clone(),
            sky_frame: self.sky_frame,
            shaders: self.shaders.clone(),
            surfaces: self.surface.clone(),
            cache: self.cache.clone(),
            threads: self.threads,
            uses_f64: self.quality == Quality::Reference,
            renderer: self.renderer,
            will_draw: false,
        }
    }
}

impl From<SurfaceError> for CliError {
    fn from(e: SurfaceError) -> Self {
        Self::Failed(e.to_string())
    }
}

impl From<SessionError> for CliError {
    fn from(e: SessionError) -> Self {
        match e {
            SessionError::Catalog(problems) => Self::Catalog(problems),
            other => Self::Failed(other.to_string()),
        }
    }
}

/// Largest number of worker threads. More threads would only wait for each other, and starting 1000 takes seconds.
const MAX_THREADS: usize = 256;

/// Parses `--threads`; 0 means one thread per core.
fn thread_count(text: &str) -> Result<usize, String> {
    let allowed = || format!("write a whole number of threads from 1 to {MAX_THREADS}, or 0 for one per core");
    text.parse().ok().filter(|n| *n <= MAX_THREADS).ok_or_else(allowed)
}

/// Longest quotation of an argument in a message, characters.
const MAX_ARGUMENT_CHARS: usize = 60;

/// Parses the arguments; arguments without a command are those of `view`.
fn parse_args(args: &[OsString]) -> Result<Cli, clap::Error> {
    let e = match Cli::try_parse_from(args) {
        Err(e) if matches!(e.kind(), ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand) => e,
        parsed_or_other_error => return parsed_or_other_error,
    };
    let command = Cli::command();
    let is_verb = |word: &OsString| command.get_subcommands().any(|v| word == v.get_name());
    let may_be_view_argument = match e.get(ContextKind::InvalidSubcommand) {
        // In the place of a command, `view` takes a link or a file. Any other word is a misspelt command, which must not open the window.
        Some(ContextValue::String(word)) => word.contains("://") || word.ends_with(".json") || std::path::Path::new(word).is_file(),
        _ => true,
    };
    // If a command is given, the unknown argument belongs to that command, and `view` must not be inserted.
    if !may_be_view_argument || args.iter().skip(1).any(is_verb) {
        return Err(e);
    }
    let with_view_verb = args.iter().take(1).cloned().chain([OsString::from("view")]).chain(args.iter().skip(1).cloned());
    Cli::try_parse_from(with_view_verb)
}

/// Prints the requested help or version.
fn print_help(e: &clap::Error) -> Result<(), CliError> {
    e.print().and_then(|()| std::io::stdout().flush()).map_err(|e| output::stdout_error(&e))
}

/// Prints clap's message. In it, long arguments are cut and control characters are escaped.
fn print_usage_error(e: &clap::Error, args: &[OsString]) {
    // clap quotes whole arguments, or one side of NAME=VALUE.
    let mut quotable: Vec<String> = Vec::new();
    for arg in args.iter().skip(1) {
        let arg = arg.to_string_lossy().into_owned();
        quotable.extend(arg.split_once('=').map_or(Vec::new(), |(name, value)| vec![name.to_owned(), value.to_owned()]));
        quotable.push(arg);
    }
    // Only arguments that are too long or contain control characters have to be replaced.
    quotable.retain(|text| echo_within(text, MAX_ARGUMENT_CHARS) != *text);
    if quotable.is_empty() {
        let _ = e.print();
        return;
    }
    // Longest first, because an argument contains its value.
    quotable.sort_by_key(|text| std::cmp::Reverse(text.len()));
    let message = quotable
        .iter()
        .fold(e.render().to_string(), |message, text| message.replace(text.as_str(), &echo_within(text, MAX_ARGUMENT_CHARS)));
    output::print_to_stderr(&escape_controls(&message));
}

/// Runs the program with the arguments of the process.
pub fn run() -> ExitCode {
    let args: Vec<OsString> = std::env::args_os().collect();
    let cli = match parse_args(&args) {
        Ok(cli) => cli,
        Err(e) if e.use_stderr() => {
            print_usage_error(&e, &args);
            return ExitCode::from(2);
        }
        Err(e) => return exit_code(print_help(&e)),
    };
    interrupt::catch_signals();
    let common = &cli.common;
    let start = std::time::Instant::now();
    let result = match &cli.verb {
        None => view::run(common, &view::ViewArgs::default()),
        Some(Verb::View(a)) => view::run(common, a),
        Some(Verb::Render(a)) => render::run(common, a),
        Some(Verb::Explain(a)) => explain::run(common, a),
        Some(Verb::Shader(a)) => shader::run(common, a),
        Some(Verb::Library(a)) => library::run(common, a),
        Some(Verb::Ephemeris(a)) => ephemeris::run(common, a),
        Some(Verb::Eclipse(a)) => eclipse::run(common, a),
        Some(Verb::Probe(a)) => probe::run(common, a),
        Some(Verb::Compare(a)) => compare::run(common, a),
        Some(Verb::Measure(a)) => measure::run(common, a),
        Some(Verb::Stability(a)) => stability::run(common, a),
        Some(Verb::Bench(a)) => bench::run(common, a),
        Some(Verb::Doctor(a)) => doctor::run(common, a),
        Some(Verb::Completions(a)) => documents::completions(a),
        Some(Verb::Man(a)) => documents::manual(a),
    };
    if common.verbose > 0 && result.is_ok() {
        output::print_message(&format!("done in {:.3} s", start.elapsed().as_secs_f64()));
    }
    exit_code(result)
}

/// Reports the error of a command, if any, and returns the exit status.
fn exit_code(result: Result<(), CliError>) -> ExitCode {
    match result {
        Ok(()) | Err(CliError::OutputClosed) => ExitCode::SUCCESS,
        Err(CliError::Catalog(problems)) => {
            output::print_messages(&problems.to_string());
            ExitCode::FAILURE
        }
        Err(CliError::Usage(why)) => {
            output::print_message(&why);
            ExitCode::from(2)
        }
        Err(e) => {
            output::print_message(&e.to_string());
            ExitCode::FAILURE
        }
    }
}
