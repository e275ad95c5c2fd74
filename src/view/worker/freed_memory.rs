//! Memory that the allocator keeps after it was freed.
//!
//! In: nothing. Out: pages given back to the operating system. Always: only the GNU C library's allocator is changed; elsewhere the functions do
//! nothing. Not here: what is kept on purpose, such as decoded maps (`image::maps`).

/// Blocks of at least this size are mapped by themselves, bytes, so that they go back when they are freed: maps and what decoding them needs. Images of
/// up to a million pixels are smaller: each frame has several, and fresh pages for them took four milliseconds a frame.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MAPPED_FROM_BYTES: libc::c_int = 4 << 20;

/// Sets the size from which blocks are mapped by themselves. Called before maps are read.
///
/// By default, the library raises this size to that of the largest block freed, up to 32 MB: after five minutes of visiting bodies half of 300 MB was
/// free between blocks in use.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt may be called at any time, and the parameter accepts this value.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MAPPED_FROM_BYTES);
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
