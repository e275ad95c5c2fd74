//! `orrery doctor`: checks adapters, data files and caches.
//!
//! In: the common options, whose files are read. Out: a report as text. Always: a problem is a line of the report and does not change the exit status.

use super::{CliError, Common};
use crate::catalog::{BodyKind, Catalog};
use crate::image::{MapOrigin, MapStore, TexelFormat};
use crate::render::software::Options;
use crate::render::software::kernels::KernelClass;
use crate::session::{Meshes, RendererPreference, Session, SessionError, Sources, cache_folder, read_catalog};
use crate::wording::counted;
use std::collections::BTreeSet;

/// Appends a line to the report. `run` prints the report once, at its end.
macro_rules! push_line {
    ($out:expr, $($args:tt)*) => { $out.push_str(&format!("{}\n", format_args!($($args)*))) };
}

#[derive(clap::Args, Debug, Default)]
#[command(after_help = "Examples:\n  orrery doctor\n  orrery doctor --textures maps/ --catalogs bodies/")]
pub(crate) struct DoctorArgs {}

/// Checks the catalog files. Returns the catalog for the other checks: the embedded one if a file is invalid.
fn report_catalogs(common: &Common, out: &mut String) -> Catalog {
    let folder = common.catalogs.as_ref().map(|f| f.display().to_string());
    match read_catalog(common.catalogs.as_deref()) {
        Ok(catalog) => {
            let overridden_by = folder.map_or(String::new(), |f| format!(", overridden by the files of {f}"));
            push_line!(out, "catalogs  embedded{overridden_by}, {} bodies", catalog.bodies().len());
            catalog
        }
        Err(SessionError::Catalog(e)) => {
            push_line!(out, "catalogs  {}:", counted(e.problems.len(), "invalid field"));
            e.to_string().lines().for_each(|problem| push_line!(out, "          {problem}"));
            Catalog::embedded()
        }
        Err(e) => {
            push_line!(out, "catalogs  {e}; give a readable folder with --catalogs");
            Catalog::embedded()
        }
    }
}

/// Lists the number and the names of the bodies of each kind, and the bodies without a stated source.
fn report_bodies(catalog: &Catalog, out: &mut String) {
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
            push_line!(out, "bodies    {}: {}", counted(names.len(), kind_name), names.join(", "));
        }
    }
    let without_source: Vec<&str> = catalog.bodies().iter().filter(|b| b.sources.is_empty()).map(|b| b.name.as_str()).collect();
    if !without_source.is_empty() {
        push_line!(out, "          no source stated ([body.sources]): {}", without_source.join(", "));
    }
}

/// Lists the number of built-in shader sources, and of those that the user's files replace or add.
fn report_shaders(common: &Common, out: &mut String) {
    match super::inputs::fragments(common) {
        Ok(fragments) => {
            let folder = common.shaders.as_ref().map(|folder| folder.display().to_string());
            let surface = (!common.surface.is_empty()).then(|| "--surface".to_owned());
            let origins: Vec<String> = folder.into_iter().chain(surface).collect();
            push_line!(out, "shaders   {} built-in sources", crate::shader::fragments::FRAGMENTS.len());
            if !origins.is_empty() {
                push_line!(out, "          {} replaced or added by {}", fragments.replaced_or_added().count(), origins.join(" and "));
            }
        }
        Err(e) => push_line!(out, "shaders   {e}"),
    }
}

/// Checks the ephemeris kernel.
fn report_ephemeris_kernel(common: &Common, catalog: &Catalog, out: &mut String) {
    match super::inputs::ephemeris(common, catalog) {
        Ok(_) => match &common.kernel {
            Some(path) => push_line!(out, "kernel    {} takes precedence over the embedded one (1900 to 2100)", path.display()),
            None => push_line!(out, "kernel    embedded, 1900 to 2100; series and mean elements outside"),
        },
        // One line per error. If a body has no source of positions, the line names its catalog file first.
        Err(e) => e.to_string().lines().for_each(|line| push_line!(out, "kernel    {line}")),
    }
}

/// Checks maps and shape models, and lists the bodies without a map.
fn report_textures(common: &Common, catalog: &Catalog, out: &mut String) {
    if let Some(folder) = common.textures.as_ref().filter(|folder| !folder.is_dir()) {
        push_line!(out, "textures  {}: there is no such folder; --textures takes a folder of maps", folder.display());
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
                        push_line!(out, "textures  {why}");
                    }
                }
                MapOrigin::Missing => {
                    push_line!(out, "textures  {file} of {} is missing; put it into the folder of --textures", body.name)
                }
            }
        }
        if body.mesh.is_some()
            && let Err(why) = meshes.model(body)
        {
            push_line!(out, "textures  {}: {why}", body.name);
        }
        if body.maps.albedo.is_none() && body.kind != BodyKind::Star {
            without_map.push(body.name.as_str());
        }
    }
    push_line!(out, "textures  {} embedded, {} from --textures", embedded_files.len(), folder_files.len());
    if !without_map.is_empty() {
        push_line!(out, "          no map, drawn in their mean colour: {}", without_map.join(", "));
    }
}

/// Checks that the files of `--stars`, `--minor-planets`, `--lunar-heights` and `--sky` can be read.
fn report_data_files(common: &Common, out: &mut String) {
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
            Ok(_) => push_line!(out, "data      the file of {option} can be read"),
            // Some errors are `FILE: --lunar-heights: REASON`. The option is removed from the error, because the line already names it.
            Err(e) => push_line!(out, "data      {option}: {}", e.to_string().replacen(&format!(": {option}: "), ": ", 1)),
        }
    }
}

/// Names the renderer that `--renderer` selects, and lists the graphics adapters.
#[cfg(feature = "gpu")]
fn report_adapters(common: &Common, out: &mut String) {
    use crate::render::gpu::{AdapterKind, GpuRenderer, adapters};
    let found = adapters();
    let selected = match common.renderer {
        RendererPreference::Software => "software (--renderer software)".to_owned(),
        preference => {
            let accept_software = preference == RendererPreference::Gpu;
            match GpuRenderer::open(accept_software) {
                Ok(gpu) => format!("GPU: {}", gpu.facts()),
                Err(e) if preference == RendererPreference::Gpu => format!("none: {e}; omit --renderer to draw in software"),
                Err(e) => format!("software: {e}"),
            }
        }
    };
    push_line!(out, "renderer  {selected}");
    for facts in &found {
        let kind = match facts.kind {
            AdapterKind::Hardware => "hardware",
            AdapterKind::Unknown => "kind unknown to the driver",
            AdapterKind::Software => "software driver; used only with --renderer gpu",
        };
        push_line!(out, "adapter   {facts}: {kind}");
    }
    if found.is_empty() {
        push_line!(out, "adapter   none found (Vulkan, Metal, DX12, GL)");
    }
}

#[cfg(not(feature = "gpu"))]
fn report_adapters(common: &Common, out: &mut String) {
    match common.renderer {
        RendererPreference::Gpu => push_line!(out, "renderer  none: this build has no GPU renderer; omit --renderer to draw in software"),
        _ => push_line!(out, "renderer  software: this build has no GPU renderer"),
    }
}

/// Names the kernel class of the software renderer (the instruction set of its compiled functions), and the other classes that this machine can run.
fn report_kernel_classes(used: KernelClass, available: &[KernelClass], threads: usize, out: &mut String) {
    push_line!(out, "software  {} kernels on {threads} threads", used.name());
    let others: Vec<_> = available.iter().filter(|k| **k != used).map(|k| k.name()).collect();
    if !others.is_empty() {
        push_line!(out, "          also available: {}; select one with ORRERY_KERNELS", others.join(", "));
    }
}

pub(crate) fn run(common: &Common, _args: &DoctorArgs) -> Result<(), CliError> {
    // The renderer interprets `--threads` in the same way: 0, or no option, means one thread per core.
    let threads =
        common.threads.filter(|threads| *threads > 0).unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let out = &mut String::new();
    report_adapters(common, out);
    report_kernel_classes(Options::default().kernel_class, &KernelClass::available(), threads, out);
    let catalog = report_catalogs(common, out);
    report_bodies(&catalog, out);
    report_ephemeris_kernel(common, &catalog, out);
    report_textures(common, &catalog, out);
    report_data_files(common, out);
    report_shaders(common, out);
    match cache_folder(common.cache.as_deref()).map(|cache| cache.join("orrery")) {
        Ok(folder) if folder.is_dir() => push_line!(out, "cache     {}", folder.display()),
        Ok(folder) => push_line!(out, "cache     {} does not exist yet; it is created with the first image", folder.display()),
        Err(why) => push_line!(out, "cache     {why}"),
    }
    super::output::print_result(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_kernel_classes_are_listed_only_if_there_are_any() {
        let report = |available: &[KernelClass]| {
            let mut out = String::new();
            report_kernel_classes(KernelClass::Portable, available, 2, &mut out);
            out
        };
        assert_eq!(report(&[KernelClass::Portable]), "software  portable kernels on 2 threads\n");
        let both = report(&[KernelClass::Neon, KernelClass::Portable]);
        assert!(both.ends_with("also available: neon; select one with ORRERY_KERNELS\n"), "{both}");
    }
}
