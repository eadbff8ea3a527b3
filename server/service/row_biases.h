#pragma once
// Bias and noise of comparisons' rows, told apart once all their seeds have succeeded: measured beside the jobs, by the
// helper in the lowest scheduling class, and kept in the store.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "protocol/error.h"
#include "server/service/artefact_files.h"
#include "server/service/job_films.h"
#include "server/service/pictures.h"
#include "server/service/row_films.h"
#include "server/service/service_core.h"

namespace photond {

/// All without the lock.
class RowBiases {
public:
    /// Throws NotFound.
    using Read = std::function<Compared(const std::string& comparison)>;

    RowBiases(ServiceCore& core, ArtefactFiles& artefact_files, Pictures& pictures, JobFilms& films, Read read)
        : core_(core), artefact_files_(artefact_files), pictures_(pictures), films_(films), read_(std::move(read)) {}
    /// The daemon is stopping, and pictures with it.
    ~RowBiases();

    void start();
    /// Of a comparison that is over: waits until its rows are measured, for kPatience at most. Not at all while a job
    /// renders on the host's processors, other comparisons come before this one, nothing is left to be measured or
    /// Pictures::kMostCallers wait already. Nothing happens for what is no comparison's id.
    void settle(const std::string& id);

    /// The map of row `index` (as in the table) and a layer, as JSON and as a picture. Throw NotFound, with the reason,
    /// where there is none; faults of `layer`; TryLater while a job renders and it is not measured yet.
    Artefact map_json(const std::string& id, size_t index, const std::string& layer);
    Artefact map_picture(const std::string& id, size_t index, const std::string& layer);

    static constexpr std::chrono::seconds kPatience{5};

private:
    struct MeasuredRow {
        int64_t comparison = 0;
        std::string label;  // with what the sweep gave
        RowFilms films;
        nlohmann::json map;
    };
    MeasuredRow measured_row(const std::string& id, size_t index, const std::string& layer);
    /// A layer of a row, asked for by itself: however many there are, each has the helper's time limit.
    struct Unmeasured {
        RowFilms films;
        std::string layer;

        std::string name() const { return films.name + "/" + layer; }
    };
    struct Failed {
        int faults = 0;  // that may have been the films'
        std::chrono::seconds pause{0};
        SteadyClock::time_point again;
    };
    void run();
    /// Under the lock, which it lets go of meanwhile: the comparison to be looked at next; none when the daemon stops.
    std::optional<int64_t> next(std::unique_lock<std::mutex>& lock);
    void pause(std::unique_lock<std::mutex>& lock);  // likewise
    /// Of the rows that can be measured, what has not been and is not lost. Throws NotFound.
    std::vector<Unmeasured> unmeasured(int64_t comparison);
    /// Under the lock: it has not failed, or long enough ago.
    bool is_due(const Unmeasured& unmeasured, SteadyClock::time_point now) const;
    bool anything_due(int64_t comparison);
    /// All that is due; waits for jobs that render to leave time for it. When to look again, where anything failed.
    std::optional<SteadyClock::time_point> measure_rows(int64_t comparison);
    /// False where it is to be tried again at once.
    bool measured_now(int64_t comparison, const Unmeasured& unmeasured);
    /// Whether it is to be tried again.
    bool failed(const Unmeasured& unmeasured, ErrorCode code);
    /// Throws TryLater, and what loading films throws.
    void measure(int64_t comparison, const Unmeasured& unmeasured);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    Pictures& pictures_;
    JobFilms& films_;
    const Read read_;
    // Under the lock.
    std::set<int64_t> settled_;                         // over, and nothing is left to be measured now
    int64_t looks_at_ = 0;                              // the comparison that the thread is at; 0: none
    int callers_ = 0;                                   // that wait in settle()
    std::map<int64_t, SteadyClock::time_point> later_;  // comparisons to be looked at again
    std::map<std::string, Failed> failed_;              // by Unmeasured::name()
    std::set<std::string> lost_;                        // likewise: cannot be measured
    std::thread thread_;
};

}  // namespace photond
