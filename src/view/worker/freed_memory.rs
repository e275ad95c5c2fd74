//! Returns freed memory to the operating system.
//!
//! In: nothing. Out: memory pages that the allocator would otherwise keep. Always: this concerns only the allocator of the GNU C library;
//! elsewhere the functions do nothing. Not here: what is kept on purpose, such as decoded maps (`image::maps`).

/// Size in bytes from which a block is allocated by mmap, so that it is returned when it is freed: maps and the buffers for decoding them.
/// RGBA images of up to a million pixels, with 8 bits per channel, are smaller: each frame allocates several, and mapping fresh pages for
/// them took four milliseconds a frame.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MMAP_THRESHOLD_BYTES: libc::c_int = 4 << 20;

/// Makes the allocator return large blocks as soon as they are freed. Called before maps are read.
///
/// By default, the library raises the threshold to the size of the largest freed block, up to 32 MiB. After five minutes of visiting
/// bodies, 150 of 300 MB were then free but not returned, because they lay between blocks in use.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt may be called at any time, and the parameter accepts this value.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MMAP_THRESHOLD_BYTES);
    }
}

/// Returns the free pages between smaller blocks.
pub(crate) fn return_pages() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim may be called at any time from any thread; it does not touch memory in use.
    unsafe {
        libc::malloc_trim(0);
    }
}
