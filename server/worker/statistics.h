#pragma once
// The numbers that come with every image (protocol.md, "Shapes", `statistics`).

#include <algorithm>
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

/// What a job's clock was taken by, of the attempt at hand (pass_loop.h).
struct ClockUse {
    std::optional<double> asked_seconds;
    double render_seconds = 0;  // of all attempts
    double begin_seconds = 0;
    double passes_seconds = 0;
    uint32_t passes_rendered = 0;
    double cut_off_seconds = 0;  // of a pass that was not done in time; 0: none

    double overshoot_seconds() const { return asked_seconds ? std::max(0.0, render_seconds - *asked_seconds) : 0; }
    /// Whether the seconds asked for were kept, as nearly as loops see a stop.
    bool kept() const { return overshoot_seconds() <= 0.5 + 0.05 * asked_seconds.value_or(0); }
};

struct StatisticsInput {
    const Stats& stats;
    const Film& film;
    std::string pixel_hash;  // Film::pixel_hash(); empty of a film without passes
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
    std::optional<ClockUse> clock = {};                 // none: of several jobs
    std::vector<std::string> warnings = {};             // of the picture
};

nlohmann::json statistics_json(const StatisticsInput& input);

/// SHA-256 of what determines a job's pixels and when it stops: the request as understood, less priority, labels and
/// what it waits for,
/// with the scene's id for its name.
std::string job_hash(const JobRequest& request, const std::string& scene_id);

/// The same numbers for an EXR's header: "photond:memory.peak_resident_bytes". Members of lists go by their "name",
/// whole numbers past 2^53 become text, what is null is left out.
std::vector<ImageAttribute> statistics_attributes(const nlohmann::json& statistics);

}  // namespace photond
