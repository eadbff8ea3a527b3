#pragma once
// Jobs on their way into the store.

#include <cstdint>
#include <optional>
#include <vector>

#include "server/service/service_core.h"

namespace photond {

/// A job that has been judged and waits to be written.
struct PreparedJob {
    JobRow row;               // seq 0
    uint64_t disk_bytes = 0;  // that it will leave
    /// The jobs that make what it is measured against, where nobody has asked for that before, with their disk_bytes.
    std::vector<JobRow> references;
    std::vector<uint64_t> reference_disk_bytes;
};

/// Jobs written in a transaction that is not committed yet.
struct Insertion {
    std::vector<JobRow> rows;  // references before the jobs that need them; raised ones among them
    Outbox outbox;
};

}  // namespace photond
