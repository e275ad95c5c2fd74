//! `orrery doctor`: what is there, what is missing, what to do. It never fails: each finding is a line.

use super::{CliError, Common};
use crate::catalog::{Catalog, Kind};
use crate::image::{MapOrigin, MapStore};
use std::path::Path;

#[derive(clap::Args, Debug, Default)]
pub struct DoctorArgs {}

/// The user's catalog files: (name, text), by name.
fn catalog_files(folder: &Path) -> std::io::Result<Vec<(String, String)>> {
    let mut paths: Vec<_> = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?.into_iter().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    paths.into_iter().map(|p| Ok((p.display().to_string(), std::fs::read_to_string(&p)?))).collect()
}

fn catalogs(common: &Common) -> Catalog {
    let embedded = Catalog::embedded();
    let Some(folder) = &common.catalogs else {
        println!("catalogs  embedded, {} bodies", embedded.bodies().len());
        return embedded;
    };
    let files = match catalog_files(folder) {
        Ok(files) => files,
        Err(e) => {
            println!("catalogs  {}: {e}; name a readable folder with --catalogs", folder.display());
            return embedded;
        }
    };
    match Catalog::with_files(&files) {
        Ok(catalog) => {
            println!("catalogs  embedded and {} files of {}, {} bodies", files.len(), folder.display(), catalog.bodies().len());
            catalog
        }
        Err(e) => {
            println!("catalogs  {} wrong fields in {}; mend these:", e.problems.len(), folder.display());
            for problem in e.problems {
                println!("          {problem}");
            }
            embedded
        }
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

pub fn run(common: &Common, _args: &DoctorArgs) -> Result<(), CliError> {
    println!("renderer  software: it draws every frame");
    let catalog = catalogs(common);
    textures(common, &catalog);
    match super::library::cache_directory(common).map(|cache| cache.join("orrery")) {
        Some(folder) if folder.is_dir() => println!("cache     {}", folder.display()),
        Some(folder) => println!("cache     {} is not there yet; the first picture makes it", folder.display()),
        None => println!("cache     no home folder is known; name one with --cache, else shaders are kept in memory only"),
    }
    Ok(())
}
