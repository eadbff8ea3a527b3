#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace photond {

/// Asks the system to back memory that was just allocated, and not written yet, with large pages: what is read all over
/// a large array waits for the processor's table of pages otherwise. A hint; small blocks are left as they are.
inline void prefer_huge_pages(void* memory, size_t bytes) {
    constexpr size_t kHugePage = size_t{1} << 21;
    constexpr uintptr_t kPage = 4096;
    if (bytes < kHugePage) return;
    // From the start of the allocation's first page, which the system may have put on the boundary of a large one.
    const size_t into_page = reinterpret_cast<uintptr_t>(memory) % kPage;
    madvise(static_cast<char*>(memory) - into_page, (into_page + bytes) / kPage * kPage, MADV_HUGEPAGE);
}

}  // namespace photond
