#pragma once
// The numbers that come with every image (protocol.md, "Shapes", `statistics`).

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/job.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/film.h"
#include "renderer/scene/needs.h"
#include "server/worker/device.h"
#include "server/worker/error_statistics.h"

namespace photond {

/// Of one job: bytes of a GPU's memory by structure, and the most there were.
struct DeviceMemoryUse {
    std::map<std::string, uint64_t> structures;
    uint64_t peak_bytes = 0;
};

struct StatisticsInput {
    const Stats& stats;
    const Film& film;
    const MemoryBudget& budget;
    const Needs& needs;
    const Device& device;
    const JobRequest& request;
    std::string scene_id;
    double render_seconds = 0;  // begin + passes + resolve
    unsigned threads = 1;
    uint64_t baseline_resident_bytes = 0;
    uint64_t peak_resident_bytes = 0;
    std::string settings_hash;                          // film_identity.h; empty: not known
    uint32_t resumed_passes = 0;                        // of these, from a film of an earlier attempt
    const ErrorStatistics* errors = nullptr;            // none: nothing was measured
    std::optional<DeviceMemoryUse> device_memory = {};  // none: on the CPU
};

nlohmann::json statistics_json(const StatisticsInput& input);

/// SHA-256 of what determines a job's pixels and when it stops: the request as understood, less priority and labels,
/// with the scene's id for its name.
std::string job_hash(const JobRequest& request, const std::string& scene_id);

/// The same numbers for an EXR's header: "photond:memory.peak_resident_bytes". Members of lists go by their "name",
/// whole numbers past 2^53 become text, what is null is left out.
std::vector<ImageAttribute> statistics_attributes(const nlohmann::json& statistics);

}  // namespace photond
