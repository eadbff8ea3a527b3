#pragma once
// The renderings a table of hard cases needs: asked for once each, run as jobs over several seeds, reduced to the
// figures that were wanted.

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/hard_cases_pixels.h"
#include "clients/cli/session.h"

namespace photond::cli {

/// One scene by one method; its seeds are jobs of their own.
struct RenderWish {
    std::string scene;
    nlohmann::json method;  // the wire's
    uint32_t passes = 1;
    ImageSize size;
    uint64_t first_seed = 1;

    nlohmann::json job(uint64_t seed, double seconds) const;
};

struct RenderLimits {
    uint64_t seeds = 8;
    double job_seconds = 120;     // stop.seconds of each job
    double timeout_seconds = 60;  // on top of it, from a job's start: then it hangs
};

/// What came of the jobs of one wish.
struct Rendering {
    RenderWish wish;
    std::map<std::string, MeanLayer> layers;         // over the seeds; those a region was wanted of
    PixelFaults faults;                              // of the pixels of every radiance layer
    uint64_t nan_samples = 0, infinite_samples = 0;  // dropped by the film
    std::vector<std::string> failures;               // of jobs: refused, failed, without pixels
    uint32_t hangs = 0;
    uint32_t cut_short = 0;  // jobs that ended by their seconds before their passes
    double seconds = 0;      // on the jobs' clocks
    std::vector<std::string> jobs;
};

class Renderings {
public:
    /// The place of this rendering among all, and of the region's means in it. What was wanted before is shared.
    struct Place {
        size_t rendering = 0, region = 0;
        bool operator==(const Place&) const = default;
    };
    Place want(const RenderWish& wish, const std::string& layer, const ImageRegion& region);

    /// Runs the jobs, many submitted ahead of the one that is collected. Jobs that fail or hang are written down;
    /// throws Failure where the daemon is lost or the command interrupted, after cancelling and removing its jobs.
    void run(Session& session, const RenderLimits& limits);

    size_t size() const { return all_.size(); }
    const Rendering& rendering(size_t index) const { return all_[index].rendering; }
    const MeanLayer& layer(const Place& place) const;
    /// Mean of the region by seed; none where the job gave no pixels.
    const std::vector<std::optional<Radiance>>& means(const Place& place) const;

private:
    struct Wanted {
        std::string layer;
        ImageRegion region;
        std::vector<std::optional<Radiance>> means;
    };
    struct Entry {
        std::string key;
        Rendering rendering;
        std::vector<Wanted> wanted;
    };
    class Runner;

    std::vector<Entry> all_;
};

/// Removes jobs that are over, with their files.
void remove_jobs(Session& session, const std::vector<std::string>& jobs);

}  // namespace photond::cli
