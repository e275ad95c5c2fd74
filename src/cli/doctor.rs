//! `orrery doctor`: checks adapters, data files and caches.
//!
//! In: the common options, whose files are read. Out: a report as text or JSON. Always: a problem is a line of the report; in JSON it is marked. It is a
//! *failure*, and the exit status 1, if other commands that draw or compute end with the same options: a file that cannot be used, or a missing renderer. Other
//! problems leave something out or cost time: a missing map, a cache that cannot be written.

use super::{CliError, Common};
use crate::catalog::{BodyKind, Catalog};
use crate::files::try_folder;
use crate::image::{MapOrigin, MapStore, TexelFormat};
use crate::render::software::Options;
use crate::render::software::kernels::KernelClass;
use crate::session::{
    Meshes, RendererPreference, Session, SessionError, Sources, TextureFolder, cache_folder, read_catalog, with_surfaces,
};
use crate::wording::counted;
use std::collections::BTreeSet;

#[derive(clap::Args, Debug, Default)]
#[command(after_help = "Examples:
  orrery doctor
  orrery doctor --textures maps/ --catalogs bodies/
  orrery doctor --json

The exit status is 1 if a problem is a failure: other commands end with it. That is a file
or folder of an option that cannot be used (--catalogs, --kernel, --shaders, --surface,
--stars, --minor-planets, --lunar-heights, --sky, --textures), or --renderer gpu without
one. With any other problem they work, such as a map that is missing (the body has its
mean colour) or a cache that cannot be written (starts are slower).

JSON: {\"problems\": their number, \"failures\": how many of them are failures,
\"lines\": [{\"topic\", \"text\", \"problem\", \"failure\": true or false}]}.")]
pub(crate) struct DoctorArgs {
    /// Print one JSON value
    #[arg(long)]
    json: bool,
}

/// A line of the report.
#[derive(serde::Serialize)]
struct Line {
    topic: &'static str,
    text: String,
    /// Whether something is missing, invalid or not used as the user wants.
    problem: bool,
    /// Whether other commands end with this problem.
    failure: bool,
    /// Whether the text belongs to the line before it; the topic is then not printed again.
    #[serde(skip)]
    continues: bool,
}

/// The report, which `run` prints once, at its end.
#[derive(Default)]
struct Report {
    lines: Vec<Line>,
}

impl Report {
    fn fact(&mut self, topic: &'static str, text: impl Into<String>) {
        self.lines.push(Line { topic, text: text.into(), problem: false, failure: false, continues: false });
    }

    /// A fact about the line before it.
    fn detail(&mut self, topic: &'static str, text: impl Into<String>) {
        self.lines.push(Line { topic, text: text.into(), problem: false, failure: false, continues: true });
    }

    fn problem(&mut self, topic: &'static str, text: impl Into<String>) {
        self.lines.push(Line { topic, text: text.into(), problem: true, failure: false, continues: false });
    }

    fn failure(&mut self, topic: &'static str, text: impl Into<String>) {
        self.lines.push(Line { topic, text: text.into(), problem: true, failure: true, continues: false });
    }

    fn to_text(&self) -> String {
        let line = |line: &Line| format!("{:<9} {}\n", if line.continues { "" } else { line.topic }, line.text);
        self.lines.iter().map(line).collect()
    }

    fn to_json(&self) -> serde_json::Value {
        let problems = self.lines.iter().filter(|line| line.problem).count();
        let failures = self.lines.iter().filter(|line| line.failure).count();
        serde_json::json!({ "problems": problems, "failures": failures, "lines": self.lines })
    }

    /// # Errors
    /// The topics of the failures.
    fn check_failures(&self) -> Result<(), CliError> {
        let mut topics: Vec<&str> = self.lines.iter().filter(|line| line.failure).map(|line| line.topic).collect();
        topics.dedup();
        if topics.is_empty() {
            return Ok(());
        }
        Err(CliError::Failed(format!("other commands fail with these options; the report says why at: {}", topics.join(", "))))
    }
}

/// Checks the catalog files. Returns the catalog for the other checks: the embedded one if a file is invalid.
fn report_catalogs(common: &Common, out: &mut Report) -> Catalog {
    let folder = common.catalogs.as_ref().map(|f| f.display().to_string());
    match read_catalog(common.catalogs.as_deref()) {
        Ok(catalog) => {
            let overridden_by = folder.map_or(String::new(), |f| format!(", overridden by the files of {f}"));
            out.fact("catalogs", format!("embedded{overridden_by}, {} bodies", catalog.bodies().len()));
            catalog
        }
        Err(SessionError::Catalog(e)) => {
            // The number of fields is a heading; each field is a problem of its own.
            out.fact("catalogs", format!("{}:", counted(e.problems.len(), "invalid field")));
            let of_field = |line: &str| Line { topic: "catalogs", text: line.to_owned(), problem: true, failure: true, continues: true };
            out.lines.extend(e.to_string().lines().map(of_field));
            Catalog::embedded()
        }
        Err(e) => {
            out.failure("catalogs", format!("{e}; give a readable folder with --catalogs"));
            Catalog::embedded()
        }
    }
}

/// Lists the number and the names of the bodies of each kind, and the bodies without a stated source.
fn report_bodies(catalog: &Catalog, out: &mut Report) {
    let kinds = [
        (BodyKind::Star, "star"),
        (BodyKind::Planet, "planet"),
        (BodyKind::DwarfPlanet, "dwarf planet"),
        (BodyKind::Moon, "moon"),
        (BodyKind::Asteroid, "asteroid"),
    ];
    for (kind, kind_name) in kinds {
        let names: Vec<&str> = catalog.bodies().iter().filter(|b| b.kind == kind).map(|b| b.name.as_str()).collect();
        if !names.is_empty() {
            out.fact("bodies", format!("{}: {}", counted(names.len(), kind_name), names.join(", ")));
        }
    }
    let without_source: Vec<&str> = catalog.bodies().iter().filter(|b| b.sources.is_empty()).map(|b| b.name.as_str()).collect();
    if !without_source.is_empty() {
        out.detail("bodies", format!("no source stated ([body.sources]): {}", without_source.join(", ")));
    }
}

/// Lists the number of built-in shader sources, and of those that the user's files replace or add.
fn report_shaders(common: &Common, catalog: &Catalog, out: &mut Report) {
    match super::inputs::fragments(common) {
        Ok(fragments) => {
            let folder = common.shaders.as_ref().map(|folder| folder.display().to_string());
            let surface = (!common.surface.is_empty()).then(|| "--surface".to_owned());
            let origins: Vec<String> = folder.into_iter().chain(surface).collect();
            out.fact("shaders", format!("{} built-in sources", crate::shader::fragments::FRAGMENTS.len()));
            if !origins.is_empty() {
                out.detail("shaders", format!("{} replaced or added by {}", fragments.replaced_or_added().count(), origins.join(" and ")));
            }
        }
        Err(e) => out.failure("shaders", e.to_string()),
    }
    // The bodies of --surface.
    if let Err(e) = with_surfaces(catalog.clone(), &common.surface) {
        out.failure("shaders", e.to_string());
    }
}

/// Checks the ephemeris kernel.
fn report_ephemeris_kernel(common: &Common, catalog: &Catalog, out: &mut Report) {
    match super::inputs::ephemeris(common, catalog) {
        Ok(_) => match &common.kernel {
            Some(path) => out.fact("kernel", format!("{} takes precedence over the embedded one (1900 to 2100)", path.display())),
            None => out.fact("kernel", "embedded, 1900 to 2100; series and mean elements outside"),
        },
        // One line per error. If a body has no source of positions, the line names its catalog file first.
        Err(e) => e.to_string().lines().for_each(|line| out.failure("kernel", line)),
    }
}

/// Checks maps and shape models, and lists the bodies without a map.
fn report_textures(common: &Common, catalog: &Catalog, out: &mut Report) {
    if let Some(folder) = common.textures.as_ref().filter(|folder| !folder.is_dir()) {
        out.failure("textures", format!("{}: there is no such folder; --textures takes a folder of maps", folder.display()));
    }
    let store = MapStore::with_limit(common.textures.clone(), common.max_megapixels);
    let meshes = Meshes::new(common.textures.iter().chain(&common.catalogs).cloned());
    // Sets, because several bodies may share a file.
    let (mut embedded_files, mut folder_files, mut without_map) = (BTreeSet::new(), BTreeSet::new(), Vec::new());
    for body in catalog.bodies() {
        let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
        let maps = maps.chain(body.clouds.as_ref().map(|clouds| &clouds.map)).map(|map| &map.file);
        for file in maps.chain(body.overlays.iter().map(|overlay| &overlay.file)) {
            match store.origin(file) {
                MapOrigin::Embedded => {
                    embedded_files.insert(file);
                }
                MapOrigin::Folder(_) => {
                    // A store of its own, so that a decoded map does not stay in memory.
                    let decoded =
                        || MapStore::with_limit(common.textures.clone(), common.max_megapixels).get(file, TexelFormat::Rgba8Unorm);
                    if folder_files.insert(file)
                        && let Err(why) = decoded()
                    {
                        out.problem("textures", why.to_string());
                    }
                }
                MapOrigin::Missing => {
                    out.problem("textures", format!("{file} of {} is missing; put it into the folder of --textures", body.name))
                }
            }
        }
        if body.mesh.is_some()
            && let Err(why) = meshes.model(body)
        {
            out.problem("textures", format!("{}: {why}", body.name));
        }
        if body.maps.albedo.is_none() && body.kind != BodyKind::Star {
            without_map.push(body.name.as_str());
        }
    }
    out.fact("textures", format!("{} embedded, {} from --textures", embedded_files.len(), folder_files.len()));
    if !without_map.is_empty() {
        out.detail("textures", format!("no map, drawn in their mean colour: {}", without_map.join(", ")));
    }
    if let Some(unused) = common.textures.as_ref().and_then(|folder| TextureFolder::of(folder, catalog).unused_text(catalog)) {
        out.problem("textures", format!("not used: {unused}"));
    }
}

/// Checks that the files of `--stars`, `--minor-planets`, `--lunar-heights` and `--sky` can be read.
fn report_data_files(common: &Common, out: &mut Report) {
    let given = common.sources();
    let (stars, minor_planets) = (given.stars.is_some(), given.minor_planets.is_some());
    let (lunar_heights, sky) = (given.lunar_heights.is_some(), given.sky.is_some());
    // A session for each file, because a session stops at the first file that it cannot read.
    let without_files = Sources {
        max_megapixels: given.max_megapixels,
        cache: given.cache.clone(),
        threads: given.threads,
        renderer: RendererPreference::Software,
        ..Sources::default()
    };
    let options = [
        ("--stars", stars, Sources { stars: given.stars, ..without_files.clone() }),
        ("--minor-planets", minor_planets, Sources { minor_planets: given.minor_planets, ..without_files.clone() }),
        ("--lunar-heights", lunar_heights, Sources { lunar_heights: given.lunar_heights, ..without_files.clone() }),
        ("--sky", sky, Sources { sky: given.sky, sky_frame: given.sky_frame, ..without_files }),
    ];
    for (option, _, sources) in options.into_iter().filter(|(_, is_given, _)| *is_given) {
        match Session::open(&sources, |_| {}) {
            Ok(_) => out.fact("data", format!("the file of {option} can be read")),
            // Some errors are `FILE: --lunar-heights: REASON`. The option is removed from the error, because the line already names it.
            Err(e) => out.failure("data", format!("{option}: {}", e.to_string().replacen(&format!(": {option}: "), ": ", 1))),
        }
    }
}

/// Names the renderer that `--renderer` selects, and lists the graphics adapters.
#[cfg(feature = "gpu")]
fn report_adapters(common: &Common, out: &mut Report) {
    use crate::render::gpu::{AdapterKind, GpuRenderer, adapters};
    let found = adapters();
    match common.renderer {
        RendererPreference::Software => out.fact("renderer", "software (--renderer software)"),
        preference => {
            let accept_software = preference == RendererPreference::Gpu;
            match GpuRenderer::open(accept_software) {
                Ok(gpu) => out.fact("renderer", format!("GPU: {}", gpu.facts())),
                Err(e) if preference == RendererPreference::Gpu => {
                    out.failure("renderer", format!("none: {e}; omit --renderer to draw in software"));
                }
                Err(e) => out.fact("renderer", format!("software: {e}")),
            }
        }
    }
    for facts in &found {
        let kind = match facts.kind {
            AdapterKind::Hardware => "hardware",
            AdapterKind::Unknown => "kind unknown to the driver",
            AdapterKind::Software => "software driver; used only with --renderer gpu",
        };
        out.fact("adapter", format!("{facts}: {kind}"));
    }
    if found.is_empty() {
        out.fact("adapter", "none found (Vulkan, Metal, DX12, GL)");
    }
}

#[cfg(not(feature = "gpu"))]
fn report_adapters(common: &Common, out: &mut Report) {
    match common.renderer {
        RendererPreference::Gpu => {
            out.failure("renderer", "none: this build has no GPU renderer; omit --renderer to draw in software");
        }
        _ => out.fact("renderer", "software: this build has no GPU renderer"),
    }
}

/// Names the kernel class of the software renderer (the instruction set of its compiled functions), and the other classes that this machine can run.
fn report_kernel_classes(used: KernelClass, available: &[KernelClass], threads: usize, out: &mut Report) {
    out.fact("software", format!("{} kernels on {threads} threads", used.name()));
    let others: Vec<_> = available.iter().filter(|k| **k != used).map(|k| k.name()).collect();
    if !others.is_empty() {
        out.detail("software", format!("also available: {}; select one with ORRERY_KERNELS", others.join(", ")));
    }
}

/// Checks the cache folder: whether it exists and can be written.
fn report_cache(common: &Common, out: &mut Report) {
    let folder = match cache_folder(common.cache.as_deref()) {
        Ok(cache) => cache.join("orrery"),
        Err(why) => return out.problem("cache", why.to_string()),
    };
    if let Err(why) = try_folder(&folder) {
        let unusable = format!("{} cannot be written: {why}; everything is kept in memory only", folder.display());
        return out.problem("cache", unusable);
    }
    let note = if folder.is_dir() { "" } else { " does not exist yet; it is created with the first image" };
    out.fact("cache", format!("{}{note}", folder.display()));
}

pub(crate) fn run(common: &Common, args: &DoctorArgs) -> Result<(), CliError> {
    // The renderer interprets `--threads` in the same way: 0, or no option, means one thread per core.
    let threads =
        common.threads.filter(|threads| *threads > 0).unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let mut report = Report::default();
    let out = &mut report;
    report_adapters(common, out);
    report_kernel_classes(Options::default().kernel_class, &KernelClass::available(), threads, out);
    if let Some(why) = KernelClass::unavailable_choice() {
        out.problem("software", why);
    }
    let catalog = report_catalogs(common, out);
    report_bodies(&catalog, out);
    report_ephemeris_kernel(common, &catalog, out);
    report_textures(common, &catalog, out);
    report_data_files(common, out);
    report_shaders(common, &catalog, out);
    report_cache(common, out);
    super::output::print_result(&if args.json { format!("{}\n", report.to_json()) } else { report.to_text() })?;
    report.check_failures()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_kernel_classes_are_listed_only_if_there_are_any() {
        let report = |available: &[KernelClass]| {
            let mut out = Report::default();
            report_kernel_classes(KernelClass::Portable, available, 2, &mut out);
            out.to_text()
        };
        assert_eq!(report(&[KernelClass::Portable]), "software  portable kernels on 2 threads\n");
        let both = report(&[KernelClass::Neon, KernelClass::Portable]);
        assert!(both.ends_with("also available: neon; select one with ORRERY_KERNELS\n"), "{both}");
    }
}
