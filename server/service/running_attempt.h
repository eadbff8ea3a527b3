#pragma once
// The attempt that a worker has at hand, as it is known in memory; and the sum of all attempts since the daemon
// started.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/worker_messages.h"
#include "server/core_loss.h"

namespace photond {

using SteadyClock = std::chrono::steady_clock;

/// A film saved while its job went on; the file goes with its last reader.
struct Snapshot {
    std::filesystem::path path;
    int64_t passes_done = 0;
    SteadyClock::time_point saved;

    Snapshot() = default;
    Snapshot(const Snapshot&) = delete;
    Snapshot& operator=(const Snapshot&) = delete;
    ~Snapshot();
};

struct RunningAttempt {
    int64_t seq = 0;
    int64_t attempt = 0;
    int64_t pixels = 0;  // of a pass
    int64_t passes_before = 0;
    double seconds_before = 0;  // those of the film it goes on from
    std::string film;           // file name it will write
    int64_t passes_done = 0;
    double progress = 0;
    double seconds = 0;
    nlohmann::json error_now;                        // {"metric", "value"} or null
    nlohmann::json curve = nlohmann::json::array();  // its points so far, those of the film it goes on from first
    bool progress_untold = false;
    bool curve_begun = false;  // this attempt has sent points: they take the place of earlier ones
    nlohmann::json unpublished = nlohmann::json::array();  // points that no event has told yet
    SteadyClock::time_point last_curve_event;
    SteadyClock::time_point begun, last_event;
    SteadyClock::time_point deadline = SteadyClock::time_point::max();  // of the attempt's own time
    SteadyClock::time_point kill_at = SteadyClock::time_point::max();   // when it has not answered a cancel
    bool deadline_passed = false;
    uint64_t snapshots = 0;          // asked for
    int64_t snapshot_asked_at = -1;  // passes_done then
    bool device_shared = false;      // another job ran meanwhile on the same cores ...
    bool host_shared = false;        // ... or at all
    ProcessorSeconds taken;          // by other processes of ours meanwhile
    std::string device_lost;         // the worker's reason; empty: it has said none
    std::shared_ptr<const Snapshot> snapshot;
    /// How it ended, when the store could not be written (disk full): tried again until it can.
    std::function<void()> unsettled;
};

/// What has been rendered since the daemon started, as far as it is known.
struct Totals {
    std::map<std::string, uint64_t> jobs{{"succeeded", 0}, {"failed", 0}, {"cancelled", 0}};
    std::map<std::string, uint64_t> rays{{"camera", 0}, {"bounce", 0}, {"shadow", 0}, {"photon", 0}};
    uint64_t photons = 0;
    int64_t passes = 0;
    int64_t pixels = 0;  // of all passes
    double render_seconds = 0;

    void add(const RunningAttempt& attempt);
    /// An attempt that has ended; `rendered` as its worker said.
    void add(const RunningAttempt& attempt, const std::optional<RenderedWork>& rendered);
};

}  // namespace photond
