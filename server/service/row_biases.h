#pragma once
// Bias and noise of comparisons' rows, told apart once all their seeds have succeeded: measured beside the jobs, by the
// helper in the lowest scheduling class, and kept in the store.

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

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
    /// Of a comparison that is over: waits until its rows are measured, for kPatience at most, and not at all while a
    /// job renders on the host's processors. Nothing happens for what is no comparison's id.
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
    void run();
    /// Under the lock, which it lets go of meanwhile.
    void pause(std::unique_lock<std::mutex>& lock);
    /// Of those rows that can be and are not; waits for jobs that render to leave time for it.
    void measure_rows(int64_t comparison);
    /// False where it is to be tried again.
    bool measured_now(int64_t comparison, const RowFilms& films, const std::vector<std::string>& layers);
    /// Throws TryLater, and what loading films throws.
    void measure(int64_t comparison, const RowFilms& films, const std::vector<std::string>& layers);

    ServiceCore& core_;
    ArtefactFiles& artefact_files_;
    Pictures& pictures_;
    JobFilms& films_;
    const Read read_;
    std::set<int64_t> settled_;   // under the lock: over, and nothing is left to be measured
    std::set<std::string> lost_;  // names of films that cannot be measured; of the thread alone
    std::thread thread_;
};

}  // namespace photond
