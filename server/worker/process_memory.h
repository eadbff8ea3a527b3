#pragma once
#include <cstdint>

namespace photond {

/// Bytes of this process in physical memory now.
uint64_t resident_bytes();
/// The most there were since reset_peak_resident() (or the process' start, where the kernel does not let it be reset).
uint64_t peak_resident_bytes();
void reset_peak_resident();
/// Address space in use now.
uint64_t virtual_bytes();
/// Physical memory of the machine.
uint64_t machine_memory_bytes();
/// Gives memory that was freed back to the system, so that it is not counted as this job's.
void release_free_memory();
/// Keeps up to so many bytes that were freed, for who asks next: the kernel clears what it gives page by page, which
/// takes longer than most that is done with it.
void keep_free_memory(int bytes);

}  // namespace photond
