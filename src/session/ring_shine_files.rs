//! Stores tables of ring-shine on disk, so that each is computed only once.
//!
//! In: the numbers that determine a table. Out: the table, read from or written to `<cache>/orrery/rings/<digest>.table`. Always: the digest in the name
//! covers the code and all inputs; a damaged file is treated as missing and is replaced; a folder that cannot be written is ignored.

use super::stored_tables::{self, Magic, code_digest};
use crate::scene::rings::ring_shine::{self, COLUMNS, ROWS, RingShine, RingShineStore};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The name of the folder of these tables.
pub(super) const FOLDER: &str = "rings";
/// The first bytes of a table's file.
pub(super) const MAGIC: &Magic = b"ORRSHN01";
/// Length of the texels, bytes: four floats per column and row, for both sides of the rings.
const TEXEL_BYTES: usize = 2 * ROWS * COLUMNS * 16;
/// Length of the header, bytes: two f64, which are the fields `max_height` (the |z| of ground in the unit-sphere frame from which no ring is above the horizon)
/// and `brightest` (the largest irradiance) of [`RingShine`].
const HEADER_BYTES: usize = 16;

/// The tables in a cache folder.
#[derive(Debug)]
pub(super) struct RingShineFiles {
    folder: PathBuf,
}

fn to_bytes(table: &RingShine) -> Vec<u8> {
    let texels = table.texels.iter().flat_map(|v| v.to_le_bytes());
    [table.max_height, table.brightest].into_iter().flat_map(f64::to_le_bytes).chain(texels).collect()
}

fn from_bytes(bytes: &[u8]) -> Option<RingShine> {
    let (header, texels) = bytes.split_at_checked(HEADER_BYTES)?;
    let [max_height, brightest] = header.as_chunks::<8>().0 else { return None };
    Some(RingShine {
        texels: stored_tables::floats(texels).collect(),
        max_height: f64::from_le_bytes(*max_height),
        brightest: f64::from_le_bytes(*brightest),
    })
}

impl RingShineFiles {
    /// `cache`: the folder that contains `orrery/`.
    pub(super) fn new(cache: &Path) -> Self {
        Self { folder: stored_tables::folder(cache, FOLDER) }
    }

    /// The file of a table. `key`: the numbers that determine the table.
    fn path(&self, key: &[f64]) -> PathBuf {
        static CODE_DIGEST: OnceLock<[u8; 32]> = OnceLock::new();
        let name = stored_tables::name(CODE_DIGEST.get_or_init(|| code_digest(&ring_shine::SOURCES)), key.iter().copied());
        stored_tables::file(&self.folder, &name)
    }
}

impl RingShineStore for RingShineFiles {
    fn read(&self, key: &[f64]) -> Option<RingShine> {
        from_bytes(&stored_tables::read(&self.path(key), MAGIC, HEADER_BYTES + TEXEL_BYTES)?)
    }

    fn write(&self, key: &[f64], table: &RingShine) {
        stored_tables::write(&self.path(key), MAGIC, &to_bytes(table));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Ring;
    use crate::scene::rings::ring_shine::{RingShineCache, RingShineGeometry};

    /// Where the tables of [`RingShineCache`] are stored.
    const IN_MEMORY: bool = false;
    const ON_DISK: bool = true;

    #[test]
    fn a_table_is_read_back_and_a_damaged_one_is_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let ring = Ring { name: "x".into(), inner_km: 1.3, outer_km: 2.2, tau_normal: 1.0, albedo: [0.8, 0.6, 0.4], dust_fraction: 0.0 };
        let shine = |sin_elevation: f64, is_on_disk: bool| {
            let geometry = RingShineGeometry { rings: &[&ring], radius_km: 1.0, polar_ratio: 0.9, sin_elevation, sun_tangent: 5e-4 };
            let store = is_on_disk.then(|| Box::new(RingShineFiles::new(folder.path())) as Box<dyn RingShineStore>);
            geometry.shine(&RingShineCache::stored(store)).expect("light")
        };
        let files = || -> Vec<PathBuf> {
            let read = std::fs::read_dir(folder.path().join("orrery/rings")).into_iter().flatten().flatten();
            read.map(|e| e.path()).collect()
        };
        let computed = shine(0.3, IN_MEMORY);
        assert!(files().is_empty());
        assert_eq!(shine(0.3, ON_DISK), computed);
        // Two tables: for the next tabulated elevations of the Sun above and below the actual one.
        let stored = files();
        assert_eq!(stored.len(), 2);
        let intact = std::fs::read(&stored[0]).expect("stored");
        assert_eq!((shine(0.3, ON_DISK), files().len()), (computed.clone(), 2));
        let mut flipped_bit = intact.clone();
        flipped_bit[100] ^= 1;
        for damaged in [&intact[..20], &intact[..intact.len() - 4], &flipped_bit, &[intact.as_slice(), b"x"].concat()] {
            std::fs::write(&stored[0], damaged).expect("written");
            assert_eq!(shine(0.3, ON_DISK), computed);
            assert_eq!(std::fs::read(&stored[0]).expect("stored"), intact, "replaced");
        }
        // The file's content is really used: another table under the same name changes the result.
        let mut table = stored_tables::decode(MAGIC, &intact).and_then(from_bytes).expect("intact");
        table.texels.iter_mut().for_each(|v| *v *= 2.0);
        stored_tables::write(&stored[0], MAGIC, &to_bytes(&table));
        assert_ne!(shine(0.3, ON_DISK), computed);
        assert_ne!(shine(0.5, ON_DISK), computed);
        assert!(files().len() > 2, "another elevation of the Sun has its own tables");
    }

    /// The digest must cover every module of `scene` that the table's code uses; otherwise a table could change without a new name.
    #[test]
    fn the_digest_covers_all_code_of_a_table() {
        // Modules of `SOURCES`, and two that it need not have: `camera::narrow_scalar` only rounds to f32, `draw::tables` computes no texel.
        let covered =
            ["camera::narrow_scalar", "constants", "numeric", "draw::tables", "rings::phase", "rings::ring_table", "rings::single_scatter"];
        for source in ring_shine::SOURCES {
            for used in stored_tables::scene_modules_used(source) {
                assert!(covered.iter().any(|c| used.starts_with(c)), "{used}");
            }
        }
    }
}
