#include "server/worker/process_memory.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace photond {

namespace {

struct PageCounts {
    uint64_t virtual_pages = 0;
    uint64_t resident_pages = 0;
};

PageCounts page_counts() {
    PageCounts counts;
    std::ifstream("/proc/self/statm") >> counts.virtual_pages >> counts.resident_pages;
    return counts;
}

uint64_t page_bytes() { return static_cast<uint64_t>(sysconf(_SC_PAGESIZE)); }

}  // namespace

uint64_t resident_bytes() { return page_counts().resident_pages * page_bytes(); }
uint64_t virtual_bytes() { return page_counts().virtual_pages * page_bytes(); }

uint64_t peak_resident_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string key; status >> key;) {
        if (key == "VmHWM:") {
            uint64_t kib = 0;
            status >> kib;
            return kib << 10;
        }
        status.ignore(1 << 16, '\n');
    }
    return resident_bytes();
}

void reset_peak_resident() {
    // "5" resets the peak resident set (proc(5)). Opened once: in the sandbox it cannot be.
    static const int file = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (file < 0) return;
    if (write(file, "5", 1) != 1) { /* the peak then stays that of the process' life, as the header says */
    }
}

uint64_t machine_memory_bytes() { return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * page_bytes(); }

void release_free_memory() { malloc_trim(0); }

void keep_free_memory(int bytes) {
    mallopt(M_TRIM_THRESHOLD, bytes);
    constexpr int kMostOfHeap = 32 << 20;  // larger ones are mapped, and given back at once
    mallopt(M_MMAP_THRESHOLD, std::min(bytes, kMostOfHeap));
}

}  // namespace photond
