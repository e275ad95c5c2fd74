//! The file format of a decoded map that is kept between runs: a header with a checksum, then the mip levels, each with its own checksum, so that
//! a level can be read without the others. Such a file is an entry of the store of maps ([`super::stored_maps`]).
//!
//! In: a mip chain, or the bytes of an entry. Out: the entry, or levels. Always: a damaged header gives no levels, and a damaged level is not
//! returned, except with a probability of 2^-128; the levels have the sizes of a complete chain. Texels are packed: without alpha if the level is opaque,
//! as one channel if it is also grey. Only chains with four bytes per texel have entries: maps of floats are not stored.
//!
//! Layout, integers little-endian:
//! - header: [`MAGIC`]; the key of the map; width and height of level 0, u32; for each level its number of channels, u8, and the XXH3 checksum (128 bits) of
//!   its packed texels; last the XXH3 of the header up to here;
//! - the packed texels of all levels, the finest first.
//!
//! The checksums are XXH3 because each start of the program reads megabytes of levels: SHA-256 took three quarters of the startup time on processors
//! without SHA instructions.

use super::mip_level::Level;
use twox_hash::XxHash3_128;

/// Digest of everything that determines the levels of a map.
pub(super) type Key = [u8; 16];

/// The first bytes of an entry: its kind and the version of this format.
const MAGIC: &[u8; 8] = b"ORRMAP02";
const CHECKSUM_BYTES: usize = 16;
/// Bytes of the header for each level: number of channels, checksum.
const LEVEL_RECORD_BYTES: usize = 1 + CHECKSUM_BYTES;
/// Magic, key and size.
const PREFIX_BYTES: usize = MAGIC.len() + size_of::<Key>() + 2 * size_of::<u32>();
/// Levels of the longest chain: a side of up to 2^32 - 1 texels can be halved 31 times.
const MAX_LEVELS: usize = 32;
/// Length of the longest header.
pub(super) const MAX_HEADER_BYTES: usize = header_bytes(MAX_LEVELS);

/// Length of the header of a chain of this many levels.
const fn header_bytes(level_count: usize) -> usize {
    PREFIX_BYTES + level_count * LEVEL_RECORD_BYTES + CHECKSUM_BYTES
}

/// Sizes of all levels of a complete chain, finest first.
fn chain_sizes((width, height): (u32, u32)) -> Vec<(u32, u32)> {
    let halved = |&(w, h): &(u32, u32)| (w > 1 || h > 1).then_some(((w / 2).max(1), (h / 2).max(1)));
    std::iter::successors(Some((width, height)), halved).collect()
}

fn checksum(bytes: &[u8]) -> [u8; CHECKSUM_BYTES] {
    XxHash3_128::oneshot(bytes).to_le_bytes()
}

fn texel_count((width, height): (u32, u32)) -> u64 {
    u64::from(width) * u64::from(height)
}

/// The header of an entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct EntryHeader {
    pub key: Key,
    /// Width and height of level 0.
    pub size: (u32, u32),
    /// Number of channels and checksum of each level.
    levels: Vec<(u8, [u8; CHECKSUM_BYTES])>,
}

impl EntryHeader {
    /// Reads the header from the first bytes of a file, of which [`MAX_HEADER_BYTES`] are enough; `None` if it is damaged or does not agree with `file_length`,
    /// in bytes.
    pub(super) fn parse(bytes: &[u8], file_length: u64) -> Option<Self> {
        let (key, rest) = bytes.strip_prefix(MAGIC)?.split_first_chunk()?;
        let (width, rest) = rest.split_first_chunk()?;
        let (height, rest) = rest.split_first_chunk()?;
        let size = (u32::from_le_bytes(*width), u32::from_le_bytes(*height));
        let sizes = chain_sizes(size);
        let (levels, rest) = rest.as_chunks::<LEVEL_RECORD_BYTES>().0.split_at_checked(sizes.len()).map(|(levels, _)| (levels, rest))?;
        let checksummed_bytes = header_bytes(sizes.len()) - CHECKSUM_BYTES;
        let header_checksum = rest.get(levels.as_flattened().len()..)?.first_chunk::<CHECKSUM_BYTES>()?;
        if texel_count(size) == 0 || checksum(&bytes[..checksummed_bytes]) != *header_checksum {
            return None;
        }
        let level = |[channels, checksum @ ..]: &[u8; LEVEL_RECORD_BYTES]| matches!(channels, 1 | 3 | 4).then_some((*channels, *checksum));
        let header = Self { key: *key, size, levels: levels.iter().map(level).collect::<Option<_>>()? };
        let (last_level_start, byte_count) = header.start_and_length(sizes.len() - 1);
        (last_level_start.checked_add(byte_count as u64) == Some(file_length)).then_some(header)
    }

    pub(super) fn sizes(&self) -> Vec<(u32, u32)> {
        chain_sizes(self.size)
    }

    /// Offset of a level's packed texels in the file, and their number of bytes (0 if there is no such level). Saturates if the size in the header is absurd.
    pub(super) fn start_and_length(&self, level: usize) -> (u64, usize) {
        let mut byte_counts =
            self.sizes().into_iter().zip(&self.levels).map(|(size, (channels, _))| texel_count(size).saturating_mul(u64::from(*channels)));
        let start = byte_counts.by_ref().take(level).fold(header_bytes(self.levels.len()) as u64, u64::saturating_add);
        (start, byte_counts.next().map_or(0, |count| usize::try_from(count).unwrap_or(usize::MAX)))
    }

    /// The texels of a level, four bytes each; `None` if there is no such level or `packed` is damaged.
    pub(super) fn unpack(&self, level: usize, packed: &[u8]) -> Option<Vec<u8>> {
        let (channels, level_checksum) = self.levels.get(level)?;
        if packed.len() != self.start_and_length(level).1 || checksum(packed) != *level_checksum {
            return None;
        }
        if *channels == 4 {
            return Some(packed.to_vec());
        }
        // Alpha stays opaque.
        let mut rgba = vec![u8::MAX; packed.len() / usize::from(*channels) * 4];
        let texels = rgba.as_chunks_mut::<4>().0.iter_mut();
        match channels {
            1 => texels.zip(packed).for_each(|(texel, grey)| [texel[0], texel[1], texel[2]] = [*grey; 3]),
            _ => texels.zip(packed.as_chunks::<3>().0).for_each(|(texel, rgb)| [texel[0], texel[1], texel[2]] = *rgb),
        }
        Some(rgba)
    }
}

/// The number of channels to store: 1 for a grey and opaque level, 3 for an opaque one, else 4, also for grey with alpha.
fn stored_channels(rgba: &[u8]) -> u8 {
    let texels = rgba.as_chunks::<4>().0;
    if !texels.iter().all(|t| t[3] == u8::MAX) {
        return 4;
    }
    if texels.iter().all(|t| t[0] == t[1] && t[1] == t[2]) { 1 } else { 3 }
}

/// The number of stored channels, and the packed texels.
fn pack(rgba: &[u8]) -> (u8, Vec<u8>) {
    let (channels, texels) = (stored_channels(rgba), rgba.as_chunks::<4>().0);
    let packed = match channels {
        1 => texels.iter().map(|t| t[0]).collect(),
        3 => {
            let mut packed = vec![0; 3 * texels.len()];
            packed.as_chunks_mut::<3>().0.iter_mut().zip(texels).for_each(|(rgb, t)| *rgb = [t[0], t[1], t[2]]);
            packed
        }
        _ => rgba.to_vec(),
    };
    (channels, packed)
}

/// The entry of a chain of levels; `None` if the chain is incomplete or does not have four bytes per texel.
pub(super) fn encode(key: &Key, chain: &[Level]) -> Option<Vec<u8>> {
    let first = chain.first()?;
    let size = (first.width, first.height);
    let is_complete = chain.iter().map(|level| (level.width, level.height)).eq(chain_sizes(size));
    if !is_complete || chain.iter().any(|level| level.byte_count() as u64 != 4 * texel_count((level.width, level.height))) {
        return None;
    }
    let mut file = [MAGIC.as_slice(), key, &size.0.to_le_bytes(), &size.1.to_le_bytes()].concat();
    let packed: Vec<(u8, Vec<u8>)> = chain.iter().map(|level| pack(level.bytes())).collect();
    for (channels, texels) in &packed {
        file.push(*channels);
        file.extend_from_slice(&checksum(texels));
    }
    let header_checksum = checksum(&file);
    file.extend_from_slice(&header_checksum);
    packed.iter().for_each(|(_, texels)| file.extend_from_slice(texels));
    Some(file)
}

/// The key of an entry; `None` if any part of it is damaged.
pub(super) fn key_if_intact(file: &[u8]) -> Option<Key> {
    let header = EntryHeader::parse(file, file.len() as u64)?;
    let is_intact = |level: usize| {
        let (start, byte_count) = header.start_and_length(level);
        let packed = usize::try_from(start).ok().and_then(|start| file.get(start..)?.get(..byte_count));
        packed.is_some_and(|packed| header.unpack(level, packed).is_some())
    };
    (0..header.levels.len()).all(is_intact).then_some(header.key)
}
