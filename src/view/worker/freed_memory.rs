//! Returns freed memory to the operating system.
//!
//! In: nothing. Out: memory pages that the allocator would otherwise keep. Always: the functions change only the allocator of the GNU C library (glibc);
//! with another allocator they do nothing. Not here: memory that the program keeps on purpose, such as decoded maps (`image::maps`).

/// Size in bytes from which the allocator takes a block from mmap, so that the block is returned when it is freed. Maps and the buffers for decoding
/// them are larger. RGBA images of up to a million pixels, with 8 bits per channel, are smaller, because each frame allocates several of them: mapping
/// fresh pages took four milliseconds per frame.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const MMAP_THRESHOLD_BYTES: libc::c_int = 4 << 20;

/// Makes the allocator return large blocks as soon as they are freed. Called before maps are read.
///
/// By default, glibc raises the threshold to the size of the largest freed block, up to 32 MiB. After five minutes of visits to bodies, the program
/// then held 300 MB, of which 150 MB were free but not returned, because they lay between blocks in use.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt may be called at any time, and the parameter accepts this value.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MMAP_THRESHOLD_BYTES);
    }
}

/// Returns the free pages that lie between smaller blocks in use.
pub(crate) fn return_pages() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim may be called at any time from any thread; it does not touch memory in use.
    unsafe {
        libc::malloc_trim(0);
    }
}
