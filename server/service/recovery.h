#pragma once
// What a start does before any process runs: an earlier daemon may have ended at any point, and the disk may be full.

#include <atomic>
#include <cstdint>

#include "server/service/attempts.h"
#include "server/service/purges.h"
#include "server/service/service_core.h"
#include "server/service/stray_files.h"
#include "server/store/quarantine.h"

namespace photond {

/// All take the lock.
class Recovery {
public:
    Recovery(ServiceCore& core, Attempts& attempts, Purges& purges)
        : core_(core), attempts_(attempts), purges_(purges), quarantine_(core.files.directory) {}

    /// Opens the events, does what finish() does, clears away what no row names, and fills the queue.
    void begin();
    /// Adopts films that no row knew, records what was running as lost and finishes removals. False where the disk had
    /// no room for it: reads are served, and it is to be called again.
    bool finish();
    bool is_finished() const { return finished_; }

    const Quarantine& quarantine() const { return quarantine_; }  // under the lock

private:
    void recover_rows();
    void clear_away_strays();
    void fill_queue();
    bool is_rendered(int64_t seq) const { return attempts_.running_attempt(seq) != nullptr; }

    ServiceCore& core_;
    Attempts& attempts_;
    Purges& purges_;
    Quarantine quarantine_;
    std::atomic<bool> finished_ = false;
    bool told_ = false;  // that there is no room
};

}  // namespace photond
