#pragma once
// What a render did: counters and stage times. Each thread counts for itself; sums are taken at the end of a pass.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace photond {

/// Additive counts of one task, pass or job (conventions.md, "Statistics").
struct Counts {
    uint64_t camera_rays = 0;
    uint64_t bounce_rays = 0;
    uint64_t shadow_rays = 0;
    uint64_t photon_rays = 0;
    uint64_t photons_emitted = 0;
    uint64_t photons_stored = 0;
    uint64_t splats = 0;
    uint64_t splat_contributions = 0;  // a splat and a visible point within it
    uint64_t vpls = 0;                 // virtual point lights
    uint64_t vpls_kept = 0;            // light paths that a frame took over from the one before
    uint64_t vpls_new = 0;             // light paths that a frame has beside those
    uint64_t voxels = 0;               // set, in all trees built
    uint64_t nan_samples = 0;          // dropped
    uint64_t infinite_samples = 0;     // dropped
    uint64_t photon_rays_saved = 0;    // that photons need not trace, as they share where light first arrives
    uint64_t cache_hits = 0;           // vertices at which a cache of radiance was asked and knew enough
    uint64_t cache_misses = 0;         // ... and did not
    uint64_t cache_refused = 0;        // samples for which it had no room
    uint64_t vpls_offered = 0;         // light paths that were decided on by what they bring to the picture
    uint64_t vpls_accepted = 0;        // ... and those that were taken

    static constexpr size_t kBounces = 8;
    std::array<uint64_t, kBounces> photons_by_bounce{};  // stored after 1, 2 ... scatterings, or as many and more;
                                                         // where a method tells

    uint64_t rays() const { return camera_rays + bounce_rays + shadow_rays + photon_rays; }
    Counts& operator+=(const Counts& other);
};

/// Wall, CPU (all threads of the process) and GPU seconds of one named stage (methods.md, "Stage names").
struct Stage {
    std::string name;
    double wall_seconds = 0;
    double cpu_seconds = 0;
    double gpu_seconds = 0;
};

/// A part that the scene did not need.
struct Skipped {
    std::string what;
    std::string why;
    uint64_t bytes_saved = 0;
};

struct Stats {
    Counts counts;
    std::vector<Stage> stages;  // in order of first use
    std::vector<Skipped> skipped;

    /// The stage of that name, added at the end when it is new.
    Stage& stage(std::string_view name);
};

double wall_now_seconds();  // monotonic
double cpu_now_seconds();   // of the whole process

/// Adds the time between construction and destruction to a stage.
class StageTimer {
public:
    StageTimer(Stats& stats, std::string_view name);
    ~StageTimer();
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;

private:
    Stats& stats_;
    std::string name_;
    double wall_start_;
    double cpu_start_;
};

}  // namespace photond
