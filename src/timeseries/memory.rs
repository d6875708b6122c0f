//! Memory that was freed, given back to the system.

/// Gives back what the allocator keeps. glibc keeps freed blocks of up to 32 MB that lie below others in use, such as the channels of a long
/// recording that nobody wants, or a signal that rows were made of; what other threads allocate comes on top of them.
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
