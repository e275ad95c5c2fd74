//! `orrery shader`: lists, emits, compares, measures, verifies and exports generated shaders.
//!
//! In: shader keys or names of simple shaders, and the fragments (built in, or replaced by `--shaders`). Out: text or JSON on standard output, and files.
//! Not here: the commands `atlas` and `corpus` (`shader_export`), and `verify --report` (`shader_report`).

use super::inputs::{fragments, lowering, reachable_keys};
use super::output::{print_bytes, print_message, print_result, print_to_stderr, progress};
use super::output_file::write_output_file;
use super::shader_export::{ExportOptions, keys_of_default_view};
use super::{CliError, Common};
use crate::files::{FileAccess, check_output_path, read_bytes, read_text, write_atomic};
use crate::session::{Session, TapeCost, ms_per_megapixel, tape_costs};
use crate::shader::compare::{EmittedLine, FeatureDiff, difference, ir_cost};
use crate::shader::emit::emit_module_with;
use crate::shader::fragments::FRAGMENTS;
use crate::shader::id::SIMPLE_MODULES;
use crate::shader::key::{self, ShaderKey, covering_keys};
use crate::shader::record::{BuiltRecord, DigestRecord, changes_text, recorded_modules};
use crate::shader::translate::{Language, spirv_file, translate};
use crate::shader::{ModuleId, ShaderModule};
use crate::wording::{counted, echo};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant as WallInstant;

/// The record of digests, relative to the root of the source tree. Without `--record`, `verify` must run there.
const DEFAULT_RECORD: &str = "tests/shader_digests.txt";

#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:
  orrery shader keys --for saturn --time 2017-05-17T00:00:00Z
  orrery shader emit lambert.albedo.sun1.ellipsoid --annotate
  orrery shader export my-shaders && orrery --shaders my-shaders

The parts of a key may be in any order and case.")]
pub(crate) struct ShaderArgs {
    #[command(subcommand)]
    verb: ShaderVerb,
}

#[derive(clap::Subcommand, Debug)]
enum ShaderVerb {
    /// List all keys reachable with this catalog, one per line
    #[command(
        after_help = "Examples:\n  orrery shader keys --for saturn --time 2017-05-17T00:00:00Z\n  orrery shader keys --covering 2 --count"
    )]
    Keys {
        /// List a set of keys in which every combination of the values of any N dimensions occurs (N is 2 or 3) instead
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=3))]
        covering: Option<u8>,
        /// List the keys of the default view of this body instead
        #[arg(long = "for", value_name = "BODY", conflicts_with = "covering")]
        body: Option<String>,
        /// Time: ISO 8601 UTC, jd_tdb:DAY, or now
        #[arg(long, value_name = "T", requires = "body", conflicts_with_all = ["covering", "simple"], allow_hyphen_values = true)]
        time: Option<String>,
        /// List the names of the simple shaders instead, which draw everything but bodies
        #[arg(long, conflicts_with_all = ["covering", "body"])]
        simple: bool,
        /// Print one JSON list
        #[arg(long)]
        json: bool,
        /// Print the number of keys; the size of the full key space goes to standard error
        #[arg(long)]
        count: bool,
    },
    /// Print the module of a key, or a simple shader by name
    #[command(
        after_help = "Examples:\n  orrery shader emit lambert.albedo.sun1.ellipsoid --annotate\n  orrery shader emit tone_map --lang msl\n  orrery shader emit tone_map --lang spirv -o tone_map.spv"
    )]
    Emit {
        /// Shader key, or the name of a simple shader
        #[arg(value_parser = module_id)]
        key: ModuleId,
        /// Language. `spirv` prints one hexadecimal word a line, and writes a binary SPIR-V file with -o; `spirv-text` is its disassembly
        #[arg(long, value_enum, default_value = "wgsl")]
        lang: Language,
        /// Write to a file instead of printing
        #[arg(short, long = "output", value_name = "FILE")]
        output: Option<PathBuf>,
        /// Replace an existing file
        #[arg(long, requires = "output")]
        overwrite: bool,
        /// Begin each line with the feature that needs it
        #[arg(long)]
        annotate: bool,
        /// Print uniforms and bindings instead
        #[arg(long)]
        layout: bool,
    },
    /// Compare two modules, by feature
    #[command(after_help = "Example:\n  orrery shader diff lambert.albedo.sun1.sphere lambert.albedo.sun1.ellipsoid")]
    Diff {
        /// Shader key, or the name of a simple shader
        #[arg(value_parser = module_id)]
        first: ModuleId,
        /// The module to compare with it
        #[arg(value_parser = module_id)]
        second: ModuleId,
        /// Print one JSON value
        #[arg(long)]
        json: bool,
    },
    /// Count operations, texture reads and registers, and time the software renderer per megapixel
    #[command(after_help = "Example:\n  orrery shader cost lambert.albedo.sun1.ellipsoid")]
    Cost {
        /// Shader key, or the name of a simple shader
        #[arg(value_parser = module_id)]
        key: ModuleId,
        /// Print one JSON value
        #[arg(long)]
        json: bool,
    },
    /// Compile the modules of all reachable keys and covering sets, translate those of the covering sets to all languages, and compare all with the recorded digests
    #[command(after_help = REPORT_HELP)]
    Verify {
        /// Compare two revisions of the library instead: source, image and cost, by cause. A revision is a cache folder or a folder of the shader library, if it holds the entries of one generator; a folder of shader sources; or `built-in`
        #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["update", "record"])]
        report: Vec<PathBuf>,
        /// With --report: print one JSON value
        #[arg(long, requires = "report", conflicts_with_all = ["update", "record"])]
        json: bool,
        /// Record the digests
        #[arg(long)]
        update: bool,
        /// File of recorded digests
        #[arg(long, value_name = "FILE", default_value = DEFAULT_RECORD)]
        record: PathBuf,
    },
    /// Write a static site with a page for each module: image, source by feature, cost, and the modules one step away
    #[command(after_help = "Example:\n  orrery shader atlas --for saturn --time 2017-05-17T00:00:00Z -o atlas")]
    Atlas {
        /// Folder for the site; new, empty, or with an atlas in it
        #[arg(short, long = "output", value_name = "DIR")]
        output: PathBuf,
        #[command(flatten)]
        options: ExportOptions,
    },
    /// Write conformance test cases, to test other executors of WGSL: modules with inputs, expected pixels and tolerances
    #[command(after_help = "Example:\n  orrery shader corpus --for saturn --time 2017-05-17T00:00:00Z -o corpus")]
    Corpus {
        /// Folder for the cases; new, empty, or with earlier cases in it
        #[arg(short, long = "output", value_name = "DIR")]
        output: PathBuf,
        #[command(flatten)]
        options: ExportOptions,
    },
    /// Write the shader sources as files to edit, for --shaders
    #[command(after_help = "Example:\n  orrery shader export my-shaders && orrery --shaders my-shaders")]
    Export {
        /// Folder for the sources
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Overwrite files that differ from the built-in sources
        #[arg(long)]
        overwrite: bool,
    },
}

const REPORT_HELP: &str = "Two revisions side by side:
  orrery --cache old library warm          with the old program
  orrery --cache new library warm          with the new one
  orrery shader verify --report old new
  orrery shader verify --report built-in my-shaders

For each cause (a changed shader source, the generator, the lowering) the report names the modules that it changed,
the greatest change of their images of the sample body, and their cost before and after.";

/// Parses a shader key or the name of a simple shader, for clap.
fn module_id(text: &str) -> Result<ModuleId, String> {
    // clap quotes the text itself.
    text.parse().map_err(|e: key::KeyTextError| e.without_key())
}

fn failed(e: impl std::fmt::Display) -> CliError {
    CliError::Failed(e.to_string())
}

/// The text of `emit --layout`: uniforms with offset, size, type and name, then the bindings of textures and samplers.
fn layout_text(module: &ShaderModule) -> String {
    let layout = &module.layout;
    let mut text = String::new();
    let _ = writeln!(text, "uniforms  group 0, binding 0, {} bytes", layout.uniform_size);
    for field in &layout.fields {
        let _ = writeln!(text, "  {:>4}  {:>3}  {:<18} {}", field.offset, field.size, field.ty.to_string(), field.name);
    }
    layout.textures.iter().for_each(|b| text.push_str(&format!("texture   group 0, binding {}  {}\n", b.binding, b.name)));
    layout.samplers.iter().for_each(|b| text.push_str(&format!("sampler   group 0, binding {}  {}\n", b.binding, b.name)));
    text
}

/// The text of `emit --annotate`: each line of the module, preceded by the feature that includes the line.
fn annotated_text(wgsl: &str, map: &crate::shader::SourceMap) -> String {
    let width = map.features.iter().map(String::len).max().unwrap_or(0);
    let lines = (1..).zip(wgsl.lines());
    lines.map(|(number, line)| format!("{:<width$} | {line}\n", map.feature_of(number).unwrap_or(""))).collect()
}

/// The text of `diff`: for each feature, the lines that only one module has.
fn difference_text(differences: &[FeatureDiff]) -> String {
    let mut text = String::new();
    for d in differences {
        let _ = writeln!(text, "{}", d.feature);
        for (sign, lines) in [('-', &d.only_first), ('+', &d.only_second)] {
            lines.iter().for_each(|l| text.push_str(&format!("  {sign} {}  ({}:{})\n", l.text, l.fragment, l.line)));
        }
    }
    text
}

/// The JSON value of `diff`: a list of features, each with its lines.
fn difference_json(differences: &[FeatureDiff]) -> serde_json::Value {
    let lines = |lines: &[EmittedLine]| -> Vec<serde_json::Value> {
        lines.iter().map(|l| serde_json::json!({ "text": l.text, "fragment": l.fragment, "line": l.line })).collect()
    };
    differences
        .iter()
        .map(|d| serde_json::json!({ "feature": d.feature, "only_first": lines(&d.only_first), "only_second": lines(&d.only_second) }))
        .collect()
}

/// The text of `cost`. `tapes`: the cost of the tapes of the vertex and of the fragment stage. `ms_per_megapixel`: `None` if the module was not timed.
fn cost_text(module: &ShaderModule, tapes: &[TapeCost], ms_per_megapixel: Option<f64>, compile_time: std::time::Duration) -> String {
    let cost = ir_cost(module);
    let mut operations: Vec<_> = cost.operations.iter().collect();
    operations.sort_by_key(|(name, n)| (std::cmp::Reverse(**n), *name));
    let mut text = format!(
        "lines {}, functions {}, branches {}, uniform bytes {}\ntexture reads  {}\noperations     {} in the IR\n",
        cost.lines,
        cost.functions,
        cost.branches,
        cost.uniform_bytes,
        cost.texture_reads,
        operations.iter().map(|(_, n)| **n).sum::<u32>()
    );
    operations.iter().for_each(|(name, n)| text.push_str(&format!("  {n:>4}  {name}\n")));
    for tape in tapes {
        let operations: usize = tape.operations.values().sum();
        let _ = writeln!(
            text,
            "{:<8} tape  {operations} operations per lane, {} per draw, {} texture reads, {} jumps, {} slots, {} registers",
            tape.stage, tape.uniform_operations, tape.texture_reads, tape.jumps, tape.slots, tape.registers
        );
        let mut kinds: Vec<_> = tape.operations.iter().collect();
        kinds.sort_by_key(|(name, n)| (std::cmp::Reverse(**n), *name));
        kinds.iter().for_each(|(name, n)| text.push_str(&format!("  {n:>4}  {name}\n")));
    }
    match ms_per_megapixel {
        Some(ms) => text.push_str(&format!("software       {ms:.1} ms per megapixel on this machine\n")),
        None => text.push_str("software       not timed (only ray-traced bodies are)\n"),
    }
    let _ = writeln!(text, "compile time   {:.2} ms", compile_time.as_secs_f64() * 1000.0);
    text
}

pub(crate) fn run(common: &Common, args: &ShaderArgs) -> Result<(), CliError> {
    match &args.verb {
        // `strength`: the number of dimensions whose combinations a covering set contains.
        ShaderVerb::Keys { covering: strength, body, time, simple, json, count } => {
            if *simple {
                let names = || SIMPLE_MODULES.iter().map(|n| format!("{n}\n")).collect::<String>();
                return match (count, json) {
                    (true, _) => print_result(&format!("{}\n", SIMPLE_MODULES.len())),
                    (_, true) => print_result(&format!("{}\n", serde_json::json!(SIMPLE_MODULES))),
                    _ => print_result(&names()),
                };
            }
            let keys: Vec<ShaderKey> = match (strength, body) {
                (Some(strength), _) => covering_keys(usize::from(*strength)),
                (None, Some(body)) => keys_of_default_view(common, body, time.as_deref().unwrap_or("now"))?,
                (None, None) => reachable_keys(common)?.into_iter().collect(),
            };
            if *json && !*count {
                return print_result(&format!("{}\n", serde_json::json!(keys)));
            }
            if *count {
                print_to_stderr(&format!("of {} combinations of dimension values\n", key::count_combinations()));
                return print_result(&format!("{}\n", keys.len()));
            }
            print_result(&keys.iter().map(|k| format!("{k}\n")).collect::<String>())
        }
        ShaderVerb::Emit { key, lang, output, overwrite, annotate, layout } => {
            let module = ShaderModule::build_with(&fragments(common)?, key, &lowering()).map_err(failed)?;
            let content = match *lang {
                _ if *layout => layout_text(&module).into_bytes(),
                Language::Wgsl if *annotate => annotated_text(&module.wgsl, &module.source_map).into_bytes(),
                _ if *annotate => return Err(CliError::Usage("--annotate works for WGSL only; omit --lang".into())),
                Language::Spirv if output.is_some() => spirv_file(&module).map_err(failed)?,
                language => translate(&module, language).map_err(failed)?.into_bytes(),
            };
            match output {
                Some(path) => write_output_file("-o", path, &content, *overwrite),
                None => print_bytes(&content),
            }
        }
        ShaderVerb::Diff { first, second, json } => {
            let fragments = fragments(common)?;
            let emitted = |id| emit_module_with(&fragments, id).map_err(failed);
            let differences = difference(&emitted(first)?, &emitted(second)?);
            if *json {
                return print_result(&format!("{}\n", difference_json(&differences)));
            }
            print_result(&difference_text(&differences))
        }
        ShaderVerb::Cost { key, json } => {
            let start = WallInstant::now();
            let module = ShaderModule::build_with(&fragments(common)?, key, &lowering()).map_err(failed)?;
            let compile_time = start.elapsed();
            let session = Session::open(&common.sources(), print_message)?;
            let ms = ms_per_megapixel(session.renderer(), session.library(), key)?;
            let tapes = tape_costs(&module).map_err(failed)?;
            if *json {
                let value = serde_json::json!({
                    "key": key.to_string(), "ir": ir_cost(&module), "tapes": tapes, "ms_per_megapixel": ms,
                    "making_ms": compile_time.as_secs_f64() * 1e3,
                });
                return print_result(&format!("{value}\n"));
            }
            print_result(&cost_text(&module, &tapes, ms, compile_time))
        }
        ShaderVerb::Verify { report, json, .. } if !report.is_empty() => super::shader_report::run(report, *json),
        ShaderVerb::Verify { update, record, .. } => verify(common, *update, record),
        ShaderVerb::Atlas { output, options } => super::shader_export::atlas(common, output, options),
        ShaderVerb::Corpus { output, options } => super::shader_export::corpus(common, output, options),
        ShaderVerb::Export { folder, overwrite } => export(folder, *overwrite),
    }
}

/// Largest shader source or record of digests that is read, bytes; real ones are far smaller.
const MAX_TEXT_BYTES: u64 = 1 << 26;

/// Writes the built-in fragments as files, except those whose file already has the same content.
fn export(folder: &Path, overwrite: bool) -> Result<(), CliError> {
    let quoted = |path: &Path| echo(&path.display().to_string());
    let (mut to_write, mut unchanged) = (Vec::new(), 0);
    for (name, text) in FRAGMENTS.iter() {
        let path = folder.join(name);
        match read_bytes(&path, MAX_TEXT_BYTES) {
            Ok(bytes) if bytes == text.as_bytes() => unchanged += 1,
            Ok(_) if !overwrite => {
                return Err(CliError::Failed(format!("{}: differs from the built-in source; --overwrite replaces it", quoted(&path))));
            }
            Err(e) if !overwrite && path.is_file() => {
                return Err(CliError::Failed(format!("{}: {e}; --overwrite replaces it", quoted(&path))));
            }
            _ => to_write.push((path, *text)),
        }
    }
    for (path, text) in &to_write {
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|e| CliError::Failed(format!("{}: {e}", quoted(parent))))?;
        write_atomic(path, FileAccess::All, |out| out.write_all(text.as_bytes()))?;
    }
    let unchanged_note = if unchanged == 0 { String::new() } else { format!(", {unchanged} unchanged") };
    print_result(&format!(
        "{} written to {}{unchanged_note}; use this folder with --shaders\n",
        counted(to_write.len(), "shader source"),
        quoted(folder)
    ))
}

/// Compiles and translates the modules, and compares their digests with the record at `path`, or with `update` writes them there.
fn verify(common: &Common, update: bool, path: &Path) -> Result<(), CliError> {
    let quoted_path = echo(&path.display().to_string());
    // The record is read first, because compiling the modules takes minutes.
    if update {
        check_output_path(path)?;
    }
    let recorded = match read_text(path, MAX_TEXT_BYTES) {
        // An update replaces an invalid record, and creates a missing one.
        Ok(text) if update => Ok(DigestRecord::parse(&text).unwrap_or_default()),
        Ok(text) => DigestRecord::parse(&text).map_err(|e| CliError::Failed(format!("{quoted_path}: {e}"))),
        Err(_) if update => Ok(DigestRecord::default()),
        Err(e) => {
            let advice = "run in the source tree, or give a file with --record and create it with --update";
            Err(CliError::Failed(format!("{quoted_path}: {e}; {advice}")))
        }
    };
    // Outside the source tree the default record is missing. The modules are compiled nevertheless, because invalid modules are found without a record.
    if path != Path::new(DEFAULT_RECORD) && recorded.is_err() {
        return recorded.map(drop);
    }
    let modules = recorded_modules(&reachable_keys(common)?);
    let bar = progress(modules.len() as u64);
    let built = BuiltRecord::of_fragments(&fragments(common)?, &modules, &lowering(), || bar.inc(1));
    bar.finish_and_clear();
    let current = built.map_err(|failures| match print_result(&failures.iter().map(|f| format!("{f}\n")).collect::<String>()) {
        Ok(()) => {
            let verb = if failures.len() == 1 { "is" } else { "are" };
            CliError::Failed(format!("{} of {} modules {verb} not valid", failures.len(), modules.len()))
        }
        Err(e) => e,
    })?;
    let translated = modules.iter().filter(|m| m.is_translated).count();
    print_result(&format!("{} modules emitted, validated and lowered; {translated} translated\n", modules.len()))?;
    let recorded = recorded?;
    let changes = recorded.changes(&current);
    print_result(&changes_text(&changes))?;
    if update {
        let text = current.record.to_text();
        write_atomic(path, FileAccess::All, |out| out.write_all(text.as_bytes()))?;
        return print_result(&format!("recorded in {quoted_path}\n"));
    }
    match changes.len() {
        0 => print_result("all as recorded\n"),
        1 => Err(CliError::Failed(format!("1 module differs from {quoted_path}; `--update` records it there"))),
        n => Err(CliError::Failed(format!("{n} modules differ from {quoted_path}; `--update` records them there"))),
    }
}
