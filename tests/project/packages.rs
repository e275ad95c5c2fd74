//! Packages for crates.io: the data are complete, and each package is below the size limit of crates.io.

use super::files_below;
use std::path::Path;
use std::process::Command;

/// Size limit of crates.io, in bytes of the compressed package.
const MAX_BYTES: u64 = 10 * 1024 * 1024;

/// Names of the files below a folder with one of these extensions, without `Cargo.toml`.
fn file_names(folder: &str, extensions: &[&str]) -> Vec<String> {
    let mut files = Vec::new();
    files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), extensions, &mut files);
    let names = files.iter().map(|f| f.file_name().expect("a name").to_string_lossy().into_owned());
    names.filter(|n| n != "Cargo.toml").collect()
}

#[test]
fn every_map_and_every_catalog_is_embedded() {
    let embedded_maps: Vec<_> = orrery_textures::MAPS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(embedded_maps, file_names("textures", &["jpg", "png"]));
    let mut embedded_catalogs: Vec<_> = orrery_catalogs::CATALOG_FILES.iter().map(|(name, _)| (*name).to_owned()).collect();
    embedded_catalogs.sort();
    assert_eq!(embedded_catalogs, file_names("catalogs", &["toml"]));
}

/// Uncompressed sizes are counted: maps and kernels hardly compress, and text is negligible.
#[test]
fn each_package_is_under_the_size_limit_of_the_registry() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (package, folder) in [("orrery", "."), ("orrery-catalogs", "catalogs"), ("orrery-textures", "textures")] {
        let args = ["package", "--list", "--allow-dirty", "--offline", "--package", package];
        let listed = Command::new(env!("CARGO")).args(args).current_dir(root).output().expect("cargo starts");
        assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
        let listed = String::from_utf8(listed.stdout).expect("UTF-8");
        let size = |name: &str| std::fs::metadata(root.join(folder).join(name)).map_or(0, |m| m.len());
        let bytes: u64 = listed.lines().map(size).sum();
        println!("{package}: {} files, {bytes} bytes", listed.lines().count());
        assert!((100_000..MAX_BYTES).contains(&bytes), "{package}: {bytes} bytes");
        assert!(listed.lines().any(|l| l.starts_with("LICENSE")), "{package} has no licence");
        assert!(!listed.contains("tests/") && !listed.contains("target/"), "{package}: {listed}");
    }
}
