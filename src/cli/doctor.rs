//! `orrery doctor`: what is there, what is missing, what to do. It never fails: each finding is a line.

use super::{CliError, Common, RendererChoice};
use crate::catalog::{Catalog, Kind};
use crate::image::{MapOrigin, MapStore};
use crate::render::software::Options;
use crate::render::software::kernels::KernelClass;
use crate::session::{SessionError, read_catalog};

#[derive(clap::Args, Debug, Default)]
#[command(after_help = "Example: orrery doctor --textures maps/")]
pub struct DoctorArgs {}

fn catalogs(common: &Common) -> Catalog {
    let folder = common.catalogs.as_ref().map(|f| f.display().to_string());
    let embedded = Catalog::embedded();
    match read_catalog(common.catalogs.as_deref()) {
        Ok(catalog) => {
            let over = folder.map_or(String::new(), |f| format!(" under the files of {f}"));
            println!("catalogs  embedded{over}, {} bodies", catalog.bodies().len());
            catalog
        }
        Err(SessionError::Catalog(e)) => {
            println!("catalogs  {} wrong fields; mend these:", e.problems.len());
            e.problems.iter().for_each(|problem| println!("          {problem}"));
            embedded
        }
        Err(e) => {
            println!("catalogs  {e}; name a readable folder with --catalogs");
            embedded
        }
    }
}

fn kernel(common: &Common, catalog: &Catalog) {
    match super::inputs::ephemeris(common, catalog) {
        Ok(_) => match &common.kernel {
            Some(path) => println!("kernel    {} over the embedded one, 1900 to 2100", path.display()),
            None => println!("kernel    embedded, 1900 to 2100; outside it series and mean elements answer"),
        },
        Err(e) => println!("kernel    {e}"),
    }
}

fn textures(common: &Common, catalog: &Catalog) {
    let store = MapStore::new(common.textures.clone());
    let (mut embedded, mut own, mut bare) = (0, 0, Vec::new());
    for body in catalog.bodies() {
        for map in [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten() {
            match store.origin(&map.file) {
                MapOrigin::Embedded => embedded += 1,
                MapOrigin::Folder(_) => own += 1,
                MapOrigin::Missing => {
                    println!("textures  {} of {} is missing; put it into a folder named by --textures", map.file, body.name)
                }
            }
        }
        if body.maps.albedo.is_none() && body.kind != Kind::Star {
            bare.push(body.name.as_str());
        }
    }
    println!("textures  {embedded} embedded, {own} from --textures");
    if !bare.is_empty() {
        println!("          without a map, drawn in their mean colour: {}", bare.join(", "));
    }
}

/// The adapters, and what `--renderer` makes of them.
#[cfg(feature = "gpu")]
fn adapters(common: &Common) {
    use crate::render::gpu::{AdapterKind, GpuRenderer, adapters};
    let all = adapters();
    let choice = match common.renderer {
        RendererChoice::Software => "software, as --renderer says".to_owned(),
        choice => match GpuRenderer::open(choice == RendererChoice::Gpu) {
            Ok(gpu) => format!("GPU: {}", gpu.facts()),
            Err(e) if choice == RendererChoice::Gpu => format!("none: {e}; leave --renderer out to draw in software"),
            Err(e) => format!("software, because {e}"),
        },
    };
    println!("renderer  {choice}");
    for facts in &all {
        let kind = match facts.kind {
            AdapterKind::Hardware => "hardware",
            AdapterKind::Unknown => "the driver does not say what",
            AdapterKind::Software => "computes on the processor; --renderer gpu takes it nonetheless",
        };
        println!("adapter   {facts}: {kind}");
    }
    if all.is_empty() {
        println!("adapter   none; a graphics driver for Vulkan, Metal, DX12 or GL would be found here");
    }
}

#[cfg(not(feature = "gpu"))]
fn adapters(common: &Common) {
    match common.renderer {
        RendererChoice::Gpu => println!("renderer  none: this build has no GPU renderer; leave --renderer out to draw in software"),
        _ => println!("renderer  software: this build has no GPU renderer"),
    }
}

pub fn run(common: &Common, _args: &DoctorArgs) -> Result<(), CliError> {
    let options = Options::default();
    let threads = common.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    adapters(common);
    println!("software  {} kernels on {threads} threads", options.kernels.name());
    let others: Vec<_> = KernelClass::available().iter().filter(|k| **k != options.kernels).map(|k| k.name()).collect();
    println!("          this machine could run {} too; ORRERY_KERNELS names one to try", others.join(", "));
    let catalog = catalogs(common);
    kernel(common, &catalog);
    textures(common, &catalog);
    match super::library::cache_directory(common).map(|cache| cache.join("orrery")) {
        Some(folder) if folder.is_dir() => println!("cache     {}", folder.display()),
        Some(folder) => println!("cache     {} is not there yet; the first picture makes it", folder.display()),
        None => println!("cache     no home folder is known; name one with --cache, else shaders are kept in memory only"),
    }
    Ok(())
}
