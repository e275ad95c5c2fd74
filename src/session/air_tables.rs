//! Tables of multiple scattering, each computed once and stored beside the shader library.
//!
//! In: a body with an atmosphere. Out: its table ([`crate::scene::air_table`]), from memory, from `<cache>/orrery/air/<digest>.table`, or computed on all
//! cores. The digest covers everything that the table depends on. A truncated or damaged file is computed again and replaced; a folder that
//! cannot be written is ignored.

use crate::catalog::Body;
use crate::files::{read_bytes, write_cached};
use crate::memo::Memo;
use crate::scene::air_table;
use glam::Vec4;
use sha2::{Digest, Sha256};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Tables in memory.
const MAX_TABLES: usize = 64;
const MAGIC: &[u8; 8] = b"ORRAIR01";
/// Magic, checksum, and four floats per node.
const FILE_BYTES: u64 = 8 + 32 + 16 * air_table::NODES as u64;

pub struct AirTables {
    /// None: in memory only.
    folder: Option<PathBuf>,
    tables: Memo<String, Arc<Vec<Vec4>>>,
}

/// Digest of the sources that compute a table.
fn code_digest(sources: &[&str]) -> [u8; 32] {
    let mut hash = Sha256::new();
    for text in sources {
        // Lengths in front, so that no two lists run together to the same bytes.
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    hash.finalize().into()
}

/// The file name of a table: a digest of the code that computes it and of all its inputs.
fn digest(body: &Body) -> String {
    static CODE: OnceLock<[u8; 32]> = OnceLock::new();
    digest_with(CODE.get_or_init(|| code_digest(&air_table::SOURCES)), body)
}

fn digest_with(code: &[u8; 32], body: &Body) -> String {
    let mut hash = Sha256::new();
    hash.update(code);
    let mut put = |values: &[f64]| values.iter().for_each(|v| hash.update(v.to_le_bytes()));
    put(&[body.radii_km.x]);
    put(&body.target_mean_colour());
    if let Some(air) = &body.atmosphere {
        put(&[air.top_km]);
        for s in &air.species {
            put(&s.scattering_per_km);
            put(&s.absorption_per_km);
            // Values that no species can have stand for absent ones.
            put(&[s.scale_height_km, s.asymmetry.unwrap_or(9.0), s.tent_centre_km.unwrap_or(-1.0)]);
        }
    }
    hash.finalize().iter().take(16).map(|b| format!("{b:02x}")).collect()
}

fn encode(table: &[Vec4]) -> Vec<u8> {
    let body: Vec<u8> = table.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
    [MAGIC.as_slice(), Sha256::digest(&body).as_slice(), &body].concat()
}

fn decode(bytes: &[u8]) -> Option<Vec<Vec4>> {
    let (sum, body) = bytes.strip_prefix(MAGIC.as_slice())?.split_at_checked(32)?;
    if Sha256::digest(body).as_slice() != sum || body.len() != air_table::NODES * 16 {
        return None;
    }
    let number = |b: &[u8]| b.try_into().map_or(f32::NAN, f32::from_le_bytes);
    Some(body.chunks_exact(16).map(|v| Vec4::new(number(&v[..4]), number(&v[4..8]), number(&v[8..12]), number(&v[12..]))).collect())
}

impl AirTables {
    /// `cache`: the folder that contains `orrery/`.
    pub fn open(cache: Option<PathBuf>) -> Self {
        Self { folder: cache.map(|c| c.join("orrery").join("air")), tables: Memo::with_capacity(MAX_TABLES) }
    }

    /// The table of a body's atmosphere; empty without one.
    pub fn get(&self, body: &Body) -> Arc<Vec<Vec4>> {
        let name = digest(body);
        self.tables.get(name.clone(), || Arc::new(self.read_or_compute(body, &name)))
    }

    fn read_or_compute(&self, body: &Body, name: &str) -> Vec<Vec4> {
        let path = self.folder.as_ref().map(|f| f.join(format!("{name}.table")));
        let kept = path.as_ref().and_then(|p| decode(&read_bytes(p, FILE_BYTES).ok()?));
        kept.unwrap_or_else(|| {
            let made = air_table::table(body).unwrap_or_default();
            // If writing fails, the next run computes it again.
            path.iter().for_each(|path| drop(write_cached(path, &encode(&made))));
            made
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    #[test]
    fn a_table_is_read_back_and_a_damaged_one_is_recomputed() {
        let catalog = Catalog::embedded();
        let pluto = catalog.body(NaifId(999)).expect("Pluto");
        let folder = tempfile::tempdir().expect("a folder");
        let fresh = || AirTables::open(Some(folder.path().to_owned())).get(pluto);
        let made = fresh();
        assert_eq!(made.len(), air_table::NODES);
        let path = folder.path().join("orrery/air").join(format!("{}.table", digest(pluto)));
        let bytes = std::fs::read(&path).expect("kept");
        assert_eq!(decode(&bytes).expect("whole"), *made);
        let other = [bytes.as_slice(), b"x"].concat();
        let mut wrong = bytes.clone();
        wrong[100] ^= 1;
        for damaged in [&bytes[..20], &bytes[..bytes.len() - 4], &other, &wrong] {
            assert_eq!(decode(damaged), None);
            std::fs::write(&path, damaged).expect("written");
            assert_eq!(*fresh(), *made);
            assert_eq!(std::fs::read(&path).expect("kept"), bytes, "healed");
        }
        let mut denser = pluto.clone();
        denser.atmosphere.as_mut().expect("air").top_km += 1.0;
        assert_ne!(digest(&denser), digest(pluto));
    }

    #[test]
    fn an_edit_of_the_code_that_computes_a_table_renames_it() {
        let catalog = Catalog::embedded();
        let pluto = catalog.body(NaifId(999)).expect("Pluto");
        for k in 0..air_table::SOURCES.len() {
            let mut edited = air_table::SOURCES;
            edited[k] = "// edited";
            assert_ne!(digest_with(&code_digest(&edited), pluto), digest(pluto));
        }
    }

    /// If a source used other parts of scene than those in the digest, or another part of the narrowing to f32, a table could change without a new name.
    #[test]
    fn the_code_that_computes_a_table_is_all_in_the_digest() {
        let covered = ["atmosphere::extinction", "camera", "constants"];
        let used = |text: &str| -> Vec<String> {
            let code = text.split("#[cfg(test)]").next().unwrap_or("").lines().map(|l| l.split("//").next().unwrap_or(""));
            let code = code.collect::<Vec<_>>().join("\n");
            let path = |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect() };
            // In a `use` list the module's path ends before the braces.
            let module = |path: String| path.trim_end_matches("::").to_owned();
            code.match_indices("crate::scene::").map(|(at, found)| module(path(&code[at + found.len()..]))).collect()
        };
        for source in air_table::SOURCES {
            assert!(used(source).iter().all(|name| covered.contains(&name.as_str())), "{:?}", used(source));
            // Absolute paths only, except in unit tests.
            assert_eq!(source.matches("super::").count(), source.matches("use super::*;").count());
            // From the camera module, only the narrowing.
            assert_eq!(source.matches("camera::").count(), source.matches("camera::narrow(").count());
        }
        assert_eq!(used("use crate::scene::eclipse::{Shade};"), ["eclipse"]);
    }
}
