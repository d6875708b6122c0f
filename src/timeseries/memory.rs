//! Returns freed memory to the system.

/// Returns memory that the allocator keeps. glibc keeps freed blocks of up to 32 MB that lie below blocks in use, for
/// example the dropped channels of a long recording, or a signal after it was converted to rows; it keeps them for each
/// thread.
pub fn give_back_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        unsafe extern "C" {
            /// May be called at any time, from any thread; `pad` [bytes] are kept at the end of the heap.
            safe fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        malloc_trim(0);
    }
}
