//! `orrery library`: shows, fills, checks and clears the shader library, the decoded maps and the tables on disk.
//!
//! In: the common options, which select the cache folder and the shader sources. Out: numbers and sizes of entries, or damaged entries, as text or JSON.
//! Filling covers only the shader library: maps and tables are stored when they are first used.

use super::inputs::{lowering, reachable_keys};
use super::output::{print_message, print_result, progress};
use super::{CliError, Common};
use crate::files::try_folder;
use crate::image::{StoredMaps, StoredMapsStatus};
use crate::session::{StoredTables, StoredTablesStatus, cache_folder, open_library};
use crate::shader::id::SIMPLE_MODULES;
use crate::shader::library::{DiskCheck, DiskStatus};
use crate::shader::{ModuleId, ShaderLibrary};
use crate::wording::{counted, echo};

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  orrery library warm\n  orrery library status --json\n\n`status`, `verify` and `clear` also cover the decoded maps and the tables (scattering in air, ring-shine) that are kept beside the library. Modules of edited shader sources (--shaders) stay in memory; `warm` then only checks that they compile."
)]
pub(crate) struct LibraryArgs {
    #[command(subcommand)]
    verb: LibraryVerb,
    /// Print one JSON value
    #[arg(long, global = true)]
    json: bool,
}

#[derive(clap::Subcommand, Debug, Clone, Copy)]
enum LibraryVerb {
    /// Show the folder, and the numbers and sizes of its entries
    #[command(after_help = "Example:\n  orrery library status")]
    Status,
    /// Compile every module that a view can need
    #[command(after_help = "Example:\n  orrery library warm")]
    Warm,
    /// Check every entry
    #[command(after_help = "Example:\n  orrery library verify")]
    Verify,
    /// Remove all entries
    #[command(after_help = "Example:\n  orrery library clear")]
    Clear,
}

/// What `library status` reports.
#[derive(serde::Serialize)]
struct StatusReport {
    #[serde(flatten)]
    modules: DiskStatus,
    /// Decoded maps; `None` without a cache folder.
    maps: Option<StoredMapsStatus>,
    /// Tables; `None` without a cache folder.
    tables: Option<StoredTablesStatus>,
}

/// What `library verify` reports.
#[derive(serde::Serialize)]
struct VerifyReport {
    #[serde(flatten)]
    modules: DiskCheck,
    /// Number of intact decoded maps. Damaged ones are listed with the damaged modules.
    valid_maps: u64,
    /// The same for tables.
    valid_tables: u64,
}

/// The shader library that the common options select, and the decoded maps and tables (`None` without a cache folder). Disk errors are printed to standard
/// error.
fn open(common: &Common) -> Result<(ShaderLibrary, Option<(StoredMaps, StoredTables)>), CliError> {
    let cache = cache_folder(common.cache.as_deref()).map_err(|e| print_message(&e.to_string())).ok();
    let library = open_library(cache.as_deref(), lowering(), std::sync::Arc::new(print_message));
    // A file of `--surface` is a shader source, too.
    if common.shaders.is_some() || !common.surface.is_empty() {
        library.set_fragments(super::inputs::fragments(common)?);
    }
    Ok((library, cache.as_deref().map(|cache| (StoredMaps::new(cache), StoredTables::new(cache)))))
}

/// Checks, before the minutes that filling takes, that modules can be stored. Modules of edited sources never are; then `warm` checks that they compile.
fn check_can_be_filled(common: &Common, library: &ShaderLibrary) -> Result<(), CliError> {
    if common.shaders.is_some() || !common.surface.is_empty() {
        return Ok(());
    }
    let folder =
        library.status().folder.ok_or_else(|| CliError::Failed("no folder to store modules in; name one with --cache DIR".into()))?;
    try_folder(&folder)
        .map_err(|e| CliError::Failed(format!("the shader library cannot be stored: {e}; name another folder with --cache DIR")))
}

fn print_json(value: &impl serde::Serialize) -> Result<(), CliError> {
    print_result(&format!("{}\n", serde_json::to_string(value).map_err(|e| CliError::Failed(e.to_string()))?))
}

pub(crate) fn run(common: &Common, args: &LibraryArgs) -> Result<(), CliError> {
    let (library, beside) = open(common)?;
    match args.verb {
        LibraryVerb::Status => {
            let (maps, tables) = beside.map(|(maps, tables)| (maps.status(), tables.status())).unzip();
            if args.json {
                let status = StatusReport { modules: library.status(), maps, tables };
                print_json(&status)?;
                return status.modules.unreadable.map_or(Ok(()), |why| Err(CliError::Failed(format!("shader library: {why}"))));
            }
            let (status, maps, tables) = (library.status(), maps.unwrap_or_default(), tables.unwrap_or_default());
            let folder = status.folder.map_or("in memory".to_owned(), |f| f.display().to_string());
            print_result(&format!(
                "folder     {folder}\nentries    {} ({} kB)\nother versions  {} ({} kB)\nmaps       {} ({} kB)\nmaps of other versions  {} ({} kB)\n\
                 tables     {} ({} kB)\n",
                status.entries,
                status.bytes / 1000,
                status.other_entries,
                status.other_bytes / 1000,
                maps.entries,
                maps.bytes / 1000,
                maps.other_entries,
                maps.other_bytes / 1000,
                tables.entries,
                tables.bytes / 1000
            ))?;
            status.unreadable.map_or(Ok(()), |why| Err(CliError::Failed(format!("shader library: {why}"))))
        }
        LibraryVerb::Warm => {
            check_can_be_filled(common, &library)?;
            let mut ids: Vec<ModuleId> = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n)).collect();
            ids.extend(reachable_keys(common)?.into_iter().map(ModuleId::Keyed));
            let bar = progress(ids.len() as u64);
            let failures = library.warm_on_disk(&ids, || bar.inc(1));
            bar.finish_and_clear();
            if library.cannot_be_written() {
                // The line above this one says why.
                let stored = library.status().entries;
                return Err(CliError::Failed(format!("library warm has stopped: {stored} of {} modules are stored", ids.len())));
            }
            if let Some(first) = failures.first() {
                return Err(CliError::Failed(format!(
                    "{} of {} modules could not be compiled; the first: {first}",
                    failures.len(),
                    ids.len()
                )));
            }
            let statistics = library.statistics();
            if args.json {
                return print_json(&statistics);
            }
            let ms_each = |seconds: f64, n: u64| if n == 0 { 0.0 } else { 1000.0 * seconds / n as f64 };
            print_result(&format!(
                "compiled   {} ({:.2} ms each)\nfrom disk  {} ({:.2} ms each)\nwritten    {} ({:.2} ms each)\nrepaired   {}\n",
                statistics.emitted,
                ms_each(statistics.emitting_s, statistics.emitted),
                statistics.from_disk,
                ms_each(statistics.reading_s, statistics.from_disk),
                statistics.written,
                ms_each(statistics.writing_s, statistics.written),
                statistics.repaired
            ))
        }
        LibraryVerb::Verify => {
            let ((valid_maps, damaged_maps), (valid_tables, damaged_tables)) =
                beside.map(|(maps, tables)| (maps.verify(), tables.verify())).unwrap_or_default();
            let mut report = VerifyReport { modules: library.verify(), valid_maps, valid_tables };
            report.modules.damaged.extend(damaged_maps.into_iter().chain(damaged_tables));
            let modules = &report.modules;
            if args.json {
                print_json(&report)?;
            } else {
                let damaged =
                    modules.damaged.iter().map(|(file, why)| format!("damaged    {}: {why}\n", echo(&file.display().to_string())));
                print_result(&format!(
                    "valid      {}\nvalid maps {valid_maps}\nvalid tables  {valid_tables}\n{}",
                    modules.valid,
                    damaged.collect::<String>()
                ))?;
            }
            if let Some(why) = &modules.unreadable {
                return Err(CliError::Failed(format!("shader library: {why}")));
            }
            if !modules.damaged.is_empty() {
                return Err(CliError::Failed(format!(
                    "damaged entries: {}; a file is replaced when it is next used, and `orrery library clear` removes all entries",
                    modules.damaged.len()
                )));
            }
            Ok(())
        }
        LibraryVerb::Clear => {
            // All are cleared, even if one of them fails.
            let of_library = library.clear();
            let (of_maps, of_tables) = beside.map_or((Ok(0), Ok(0)), |(maps, tables)| (maps.clear(), tables.clear()));
            let removed = of_library.map_err(|e| CliError::Failed(format!("the shader library cannot be cleared: {e}")))?
                + of_maps.map_err(|e| CliError::Failed(format!("the decoded maps cannot be cleared: {e}")))?
                + of_tables.map_err(|e| CliError::Failed(format!("the tables cannot be cleared: {e}")))?;
            if args.json {
                return print_json(&serde_json::json!({ "removed": removed }));
            }
            print_result(&format!("removed    {}\n", counted(removed as usize, "file")))
        }
    }
}
