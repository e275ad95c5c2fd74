//! Memory that the allocator keeps after it was freed.
//!
//! In: nothing. Out: pages given back to the operating system. Not here: what is kept on purpose, such as decoded maps (`image::maps`).

/// Gives freed pages back to the operating system. The GNU C library keeps those between blocks that are still in use, in each thread's own heap:
/// after a quarter of an hour of visiting bodies that was a fifth of the window's memory (98 of 489 MB, one run). Does nothing where there is another C library.
pub(crate) fn return_pages() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: malloc_trim may be called at any time from any thread; it does not touch memory in use.
    unsafe {
        libc::malloc_trim(0);
    }
}
