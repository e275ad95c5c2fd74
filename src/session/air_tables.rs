//! Provides tables of multiple scattering. Each is computed once and stored in the cache folder, next to the shader library.
//!
//! In: a body with an atmosphere. Out: its table ([`crate::scene::multi_scatter_table`]), from memory, from `<cache>/orrery/air/<digest>.table`, or
//! computed on all cores. The digest covers everything on which the table depends. If a file is truncated or damaged, its table is computed again and the
//! file replaced; a folder that cannot be written is ignored.

use super::stored_tables::{self, Magic, code_digest};
use crate::catalog::{Atmosphere, Body, Species};
use crate::memo::Memo;
use crate::scene::multi_scatter_table;
use glam::Vec4;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Largest number of tables in memory.
const MAX_TABLES: usize = 64;
/// The name of the folder of these tables.
pub(super) const FOLDER: &str = "air";
/// The first bytes of a table's file.
pub(super) const MAGIC: &Magic = b"ORRAIR01";
/// Length of a table, bytes: for each of its nodes (a height and a zenith angle of the Sun) a `Vec4`, in which the last component is unused.
const TABLE_BYTES: usize = 16 * multi_scatter_table::NODES;

/// The multiple-scattering tables of a session, by [`table_name`].
pub struct AirTables {
    /// `None`: tables are kept in memory only.
    folder: Option<PathBuf>,
    tables: Memo<String, Arc<Vec<Vec4>>>,
}

/// The name of a body's table, which is its file's name without the extension: a digest of the code that computes the table and of all inputs.
fn table_name(body: &Body) -> String {
    static CODE_DIGEST: OnceLock<[u8; 32]> = OnceLock::new();
    table_name_with(CODE_DIGEST.get_or_init(|| code_digest(&multi_scatter_table::SOURCES)), body)
}

/// As [`table_name`], for a given digest of the code.
fn table_name_with(code_digest: &[u8; 32], body: &Body) -> String {
    let mut inputs = vec![body.radii_km.x];
    inputs.extend(body.mean_reflectance());
    // A pattern without `..`, so that the compiler demands a decision about each new field.
    if let Some(Atmosphere { top_km, species, refractivity: _, limb_haze_km: _, airglow_cd_m2: _, forward_light: _ }) = &body.atmosphere {
        inputs.push(*top_km);
        inputs.extend(species.iter().flat_map(Species::optical_numbers));
    }
    stored_tables::name(code_digest, inputs)
}

fn to_bytes(table: &[Vec4]) -> Vec<u8> {
    table.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect()
}

fn from_bytes(bytes: &[u8]) -> Vec<Vec4> {
    let values: Vec<f32> = stored_tables::floats(bytes).collect();
    values.as_chunks::<4>().0.iter().map(|v| Vec4::from_array(*v)).collect()
}

impl AirTables {
    /// `cache`: the folder that contains `orrery/`; `None`: tables are kept in memory only.
    pub fn open(cache: Option<PathBuf>) -> Self {
        Self { folder: cache.map(|cache| stored_tables::folder(&cache, FOLDER)), tables: Memo::with_capacity(MAX_TABLES) }
    }

    /// The table of a body's atmosphere; empty for a body without atmosphere.
    pub fn get(&self, body: &Body) -> Arc<Vec<Vec4>> {
        let name = table_name(body);
        self.tables.get(name.clone(), || Arc::new(self.read_or_compute(body, &name)))
    }

    fn read_or_compute(&self, body: &Body, name: &str) -> Vec<Vec4> {
        let path = self.folder.as_ref().map(|folder| stored_tables::file(folder, name));
        let stored = path.as_ref().and_then(|p| stored_tables::read(p, MAGIC, TABLE_BYTES));
        stored.map(|bytes| from_bytes(&bytes)).unwrap_or_else(|| {
            let computed = multi_scatter_table::table(body).unwrap_or_default();
            path.iter().for_each(|path| stored_tables::write(path, MAGIC, &to_bytes(&computed)));
            computed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{AerosolPhase, Catalog, NaifId, PhaseFunction};

    #[test]
    fn a_table_is_read_back_and_a_damaged_one_is_recomputed() {
        let catalog = Catalog::embedded();
        let pluto = catalog.body(NaifId(999)).expect("Pluto");
        let folder = tempfile::tempdir().expect("a folder");
        let table_of_new_session = || AirTables::open(Some(folder.path().to_owned())).get(pluto);
        let computed = table_of_new_session();
        assert_eq!(computed.len(), multi_scatter_table::NODES);
        let path = folder.path().join("orrery/air").join(format!("{}.table", table_name(pluto)));
        let bytes = std::fs::read(&path).expect("stored");
        let decode = |bytes: &[u8]| stored_tables::decode(MAGIC, bytes).filter(|b| b.len() == TABLE_BYTES).map(from_bytes);
        assert_eq!(decode(&bytes).expect("intact"), *computed);
        let with_extra_byte = [bytes.as_slice(), b"x"].concat();
        let mut flipped_bit = bytes.clone();
        flipped_bit[100] ^= 1;
        for damaged in [&bytes[..20], &bytes[..bytes.len() - 4], &with_extra_byte, &flipped_bit] {
            assert_eq!(decode(damaged), None);
            std::fs::write(&path, damaged).expect("written");
            assert_eq!(*table_of_new_session(), *computed);
            assert_eq!(std::fs::read(&path).expect("stored"), bytes, "replaced");
        }
        let mut with_higher_top = pluto.clone();
        with_higher_top.atmosphere.as_mut().expect("air").top_km += 1.0;
        assert_ne!(table_name(&with_higher_top), table_name(pluto));
    }

    #[test]
    fn each_number_of_an_aerosol_changes_the_name() {
        let catalog = Catalog::embedded();
        let mars = catalog.body(NaifId(499)).expect("Mars");
        let name_with = |aerosol: AerosolPhase| {
            let mut other = mars.clone();
            for s in &mut other.atmosphere.as_mut().expect("air").species {
                if s.aerosol_phase().is_some() {
                    s.phase = PhaseFunction::Aerosol(aerosol);
                }
            }
            table_name(&other)
        };
        let aerosol = AerosolPhase::with_asymmetry([0.5; 3]);
        let mut names = vec![name_with(aerosol)];
        for field in AerosolPhase::FIELDS {
            let mut scratch = aerosol;
            let count = (field.numbers)(&mut scratch).len();
            for k in 0..count {
                let mut other = aerosol;
                (field.numbers)(&mut other)[k] += 0.1;
                let name = name_with(other);
                assert!(!names.contains(&name), "{} {k}", field.catalog_key);
                names.push(name);
            }
        }
    }

    #[test]
    fn editing_the_code_of_a_table_changes_its_name() {
        let catalog = Catalog::embedded();
        let pluto = catalog.body(NaifId(999)).expect("Pluto");
        for k in 0..multi_scatter_table::SOURCES.len() {
            let mut edited = multi_scatter_table::SOURCES;
            edited[k] = "// edited";
            assert_ne!(table_name_with(&code_digest(&edited), pluto), table_name(pluto));
        }
    }

    /// The digest must cover every module of `scene` that the table's code uses; otherwise a table could change without a new name. `camera` is allowed
    /// although the digest does not cover it; the code may use only its function `narrow`, which converts to f32.
    #[test]
    fn the_digest_covers_all_code_of_a_table() {
        let allowed =
            ["atmosphere::air_sphere", "atmosphere::diffuse_light", "atmosphere::extinction", "atmosphere::phase", "camera", "constants"];
        let used = stored_tables::scene_modules_used;
        let is_allowed = |path: &str| {
            allowed.iter().any(|module| path.strip_prefix(module).is_some_and(|rest| rest.is_empty() || rest.starts_with("::")))
        };
        assert!(is_allowed("constants::X") && !is_allowed("constantsx"));
        for source in multi_scatter_table::SOURCES {
            assert!(used(source).iter().all(|path| is_allowed(path)), "{:?}", used(source));
            // The sources use absolute paths only, except in unit tests.
            assert_eq!(source.matches("super::").count(), source.matches("use super::*;").count());
            // From the camera module, the sources use only `narrow`.
            assert_eq!(source.matches("camera::").count(), source.matches("camera::narrow(").count());
        }
        assert_eq!(used("use crate::scene::eclipse::{Shade};"), ["eclipse"]);
    }
}
