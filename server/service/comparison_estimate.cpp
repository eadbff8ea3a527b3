// What a comparison will take, before it is queued: of each of its jobs, and of the reference that is still to be made.

#include <algorithm>
#include <map>
#include <mutex>
#include <set>

#include "server/comparisons/left_out_marks.h"
#include "server/left_out_json.h"
#include "server/service/comparisons.h"

namespace photond {

using nlohmann::json;

namespace {

/// A sum that is known while all its parts are.
class Sum {
public:
    void add(const std::optional<double>& part) {
        known_ = known_ && part;
        value_ += part.value_or(0);
    }
    std::optional<double> value() const { return known_ ? std::optional(value_) : std::nullopt; }
    json to_json() const { return known_ ? json(value_) : json(); }

private:
    double value_ = 0;
    bool known_ = true;
};

/// The seeds of an entry with one choice of the sweep's values: a row of the tables.
struct Row {
    const PlannedJob* first;
    uint64_t memory_bytes = 0;
    Sum seconds;
    std::string warning;  // empty: none
    std::optional<PathsLeftOut> left_out = {};
};

}  // namespace

json Comparisons::estimate_comparison(const ComparisonRequest& request) {
    const std::string& scene_name = request.jobs.front().request.scene;
    scenes_.know_scene(scene_name);
    const std::lock_guard lock(core_.mutex);
    const std::vector<PreparedJob> prepared = prepare_jobs(request);
    jobs_.intake.check_room(prepared);
    const auto scene = scenes_.find_scene(scene_name);
    if (!scene) throw Error(ErrorCode::Internal, "a scene that was found is not there");

    EarlierJobs earlier;
    std::vector<Row> rows;
    std::map<std::string, Sum> devices;  // one job after another on each, beside each other on all
    std::set<std::string> references;
    Sum reference_seconds;
    uint64_t memory_bytes = 0;
    for (size_t i = 0; i < prepared.size(); ++i) {
        const PlannedJob& planned = request.jobs[i];
        if (rows.empty() || rows.back().first->entry != planned.entry ||
            rows.back().first->parameters != planned.parameters)
            rows.push_back({&planned, 0, {}, {}, {}});
        const TimeEstimate time = jobs_.estimates.estimate_time(planned.request, *scene, earlier);
        const uint64_t bytes = jobs_.estimates.estimate_memory_bytes(planned.request, *scene);
        rows.back().seconds.add(time.seconds);
        rows.back().warning = time.warning;
        rows.back().memory_bytes = std::max(rows.back().memory_bytes, bytes);
        rows.back().left_out = jobs_.estimates.paths_left_out(planned.request, *scene);
        devices[prepared[i].row.device].add(time.seconds);
        memory_bytes = std::max(memory_bytes, bytes);
        for (uint32_t film = 0; film < prepared[i].references.size(); ++film) {
            if (!references.insert(prepared[i].references[film].content).second) continue;
            const JobRequest reference = References::reference_request(planned.request, film);
            reference_seconds.add(jobs_.estimates.estimate_time(reference, *scene, earlier).seconds);
            memory_bytes = std::max(memory_bytes, jobs_.estimates.estimate_memory_bytes(reference, *scene));
        }
    }

    std::optional<double> longest = 0;
    for (const auto& [device, seconds] : devices)
        longest = longest && seconds.value() ? std::optional(std::max(*longest, *seconds.value())) : std::nullopt;
    json entries = json::array();
    json warnings = json::array();
    ComparisonTable marks;  // with no more than decides who is marked
    if (const JobRequest& first = request.jobs.front().request; first.reference && first.reference->rendering)
        marks.reference_left_out = jobs_.estimates.paths_left_out(References::reference_request(first, 0), *scene);
    for (const Row& row : rows) {
        TableRow of_table;
        of_table.left_out = row.left_out;
        const std::string mark = mark_text(marks, of_table);
        for (const std::string& warning : {row.warning, mark})
            if (!warning.empty())
                warnings.push_back(row_name(row.first->label, row.first->parameters) + ": " + warning);
        entries.push_back({{"label", row.first->label},
                           {"parameters", row.first->parameters},
                           {"memory_bytes", row.memory_bytes},
                           {"seconds", row.seconds.to_json()},
                           {"left_out", row.left_out ? to_json(*row.left_out) : json()},
                           {"mark", mark.empty() ? json() : json(mark)}});
    }
    return {{"jobs", prepared.size()},
            {"memory_bytes", memory_bytes},
            {"seconds", longest ? json(*longest) : json()},
            {"reference_seconds", reference_seconds.to_json()},
            {"warnings", std::move(warnings)},
            {"entries", std::move(entries)}};
}

}  // namespace photond
