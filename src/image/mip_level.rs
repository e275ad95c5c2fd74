//! One mip level of a texture, in memory or read from a store when its texels are first needed.
//!
//! In: texels, or a [`LevelSource`] and the level's index. Out: size and bytes. Always: a level has the same bytes whichever thread reads it
//! first; other threads that need it wait for that thread. While a source reads, its thread runs no other
//! rayon task, so that a level can be read inside a parallel computation.

use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

/// Supplies the texels of a mip chain, level by level.
pub(super) trait LevelSource: Debug + Send + Sync {
    /// The texels of a level. An implementation must not wait for rayon: a thread that waits for rayon may run another task meanwhile. If that task needs
    /// the same level, the thread waits for itself.
    fn read(&self, level: usize) -> Vec<u8>;
}

/// A level that is read from its source when it is first needed.
#[derive(Clone, Debug)]
struct OnDemand {
    source: Arc<dyn LevelSource>,
    /// Index in the mip chain; 0 is the finest.
    level: usize,
    /// Length of `bytes` once they are read.
    byte_count: usize,
    /// Empty until the level is first needed.
    bytes: OnceLock<Vec<u8>>,
}

#[derive(Clone, Debug)]
enum Texels {
    InMemory(Vec<u8>),
    OnDemand(OnDemand),
}

/// One mip level: tightly packed rows, top row first.
#[derive(Clone, Debug)]
pub struct Level {
    pub width: u32,
    pub height: u32,
    texels: Texels,
}

impl Level {
    /// A level in memory.
    pub fn new(width: u32, height: u32, bytes: Vec<u8>) -> Self {
        Self { width, height, texels: Texels::InMemory(bytes) }
    }

    /// The level with index `level` of a mip chain, four bytes per texel, which `source` supplies when it is needed.
    pub(super) fn on_demand((width, height): (u32, u32), source: Arc<dyn LevelSource>, level: usize) -> Self {
        let byte_count = 4 * width as usize * height as usize;
        Self { width, height, texels: Texels::OnDemand(OnDemand { source, level, byte_count, bytes: OnceLock::new() }) }
    }

    /// The bytes of all texels. They are read now, unless they have been read before.
    pub fn bytes(&self) -> &[u8] {
        match &self.texels {
            Texels::InMemory(bytes) => bytes,
            Texels::OnDemand(on_demand) => on_demand.bytes.get_or_init(|| {
                let mut bytes = on_demand.source.read(on_demand.level);
                // A source may return too few or too many bytes, and samplers do not check the length again.
                bytes.resize(on_demand.byte_count, 0);
                bytes
            }),
        }
    }

    /// The bytes of all texels, moved out of the level.
    pub(super) fn into_bytes(mut self) -> Vec<u8> {
        // Reads them if they have not been read yet.
        self.bytes();
        match &mut self.texels {
            Texels::InMemory(bytes) => std::mem::take(bytes),
            Texels::OnDemand(on_demand) => on_demand.bytes.take().unwrap_or_default(),
        }
    }

    /// The number of bytes of all texels, read or not.
    pub fn byte_count(&self) -> usize {
        match &self.texels {
            Texels::InMemory(bytes) => bytes.len(),
            Texels::OnDemand(on_demand) => on_demand.byte_count,
        }
    }

    /// The number of bytes that take memory now.
    pub fn bytes_in_memory(&self) -> usize {
        match &self.texels {
            Texels::InMemory(bytes) => bytes.len(),
            Texels::OnDemand(on_demand) => on_demand.bytes.get().map_or(0, Vec::len),
        }
    }
}

impl PartialEq for Level {
    fn eq(&self, other: &Self) -> bool {
        (self.width, self.height, self.bytes()) == (other.width, other.height, other.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Returns `length` bytes, each the level's index, and counts the reads.
    #[derive(Debug)]
    struct CountingSource {
        length: usize,
        reads: AtomicUsize,
    }

    impl LevelSource for CountingSource {
        fn read(&self, level: usize) -> Vec<u8> {
            self.reads.fetch_add(1, Ordering::SeqCst);
            vec![level as u8; self.length]
        }
    }

    #[test]
    fn a_level_is_read_once_and_has_the_length_of_its_size() {
        for length in [0, 31, 32, 100] {
            let source = Arc::new(CountingSource { length, reads: AtomicUsize::new(0) });
            // 4 x 2 texels of four bytes: 32 bytes.
            let level = Level::on_demand((4, 2), source.clone(), 3);
            assert_eq!((level.byte_count(), level.bytes_in_memory()), (32, 0));
            assert_eq!(source.reads.load(Ordering::SeqCst), 0, "the size is known without reading");
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| assert_eq!(level.bytes().len(), 32));
                }
            });
            assert_eq!((level.byte_count(), level.bytes_in_memory(), source.reads.load(Ordering::SeqCst)), (32, 32, 1));
            let mut expected = vec![3; length.min(32)];
            expected.resize(32, 0);
            assert!(level == Level::new(4, 2, expected.clone()) && level != Level::new(2, 4, expected.clone()));
            assert_eq!(level.into_bytes(), expected);
        }
    }
}
