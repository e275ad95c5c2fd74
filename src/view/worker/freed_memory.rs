//! Memory that the allocator keeps after it was freed.
//!
//! In: nothing. Out: pages given back to the operating system. Always: the rules of the GNU C library, and nothing with another one. Not here: what is kept on
//! purpose, such as decoded maps (`image::maps`).

/// Blocks of at least this size are mapped by themselves, bytes, so that they go back when they are freed: maps, their mip levels and pictures.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MAPPED_FROM_BYTES: libc::c_int = 1 << 20;
/// Number of heaps that the threads share.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const HEAPS: libc::c_int = 2;

/// Sets the rules by which freed memory goes back. Called before the first thread starts.
///
/// Left alone, the library raises the size from which it maps blocks to that of the largest one freed, up to 32 MB, and has a heap for each thread: after
/// five minutes of visiting bodies half of 300 MB was free between blocks in use.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt may be called at any time; both parameters accept these values.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MAPPED_FROM_BYTES);
        libc::mallopt(libc::M_ARENA_MAX, HEAPS);
    }
}

/// Gives the freed pages between smaller blocks back.
pub(crate) fn return_pages() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim may be called at any time from any thread; it does not touch memory in use.
    unsafe {
        libc::malloc_trim(0);
    }
}
