#include "renderer/core/stats.h"

#include <ctime>

namespace photond {

namespace {
double clock_seconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
}  // namespace

Counts& Counts::operator+=(const Counts& other) {
    camera_rays += other.camera_rays;
    bounce_rays += other.bounce_rays;
    shadow_rays += other.shadow_rays;
    photon_rays += other.photon_rays;
    photons_emitted += other.photons_emitted;
    photons_stored += other.photons_stored;
    splats += other.splats;
    splat_contributions += other.splat_contributions;
    vpls += other.vpls;
    vpls_kept += other.vpls_kept;
    vpls_new += other.vpls_new;
    voxels += other.voxels;
    nan_samples += other.nan_samples;
    infinite_samples += other.infinite_samples;
    photon_rays_saved += other.photon_rays_saved;
    cache_hits += other.cache_hits;
    cache_misses += other.cache_misses;
    cache_refused += other.cache_refused;
    vpls_offered += other.vpls_offered;
    vpls_accepted += other.vpls_accepted;
    for (size_t i = 0; i < kBounces; ++i) photons_by_bounce[i] += other.photons_by_bounce[i];
    return *this;
}

Stage& Stats::stage(std::string_view name) {
    for (Stage& stage : stages)
        if (stage.name == name) return stage;
    return stages.emplace_back(Stage{std::string(name), 0, 0, 0});
}

double wall_now_seconds() { return clock_seconds(CLOCK_MONOTONIC); }
double cpu_now_seconds() { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID); }

StageTimer::StageTimer(Stats& stats, std::string_view name)
    : stats_(stats), name_(name), wall_start_(wall_now_seconds()), cpu_start_(cpu_now_seconds()) {}

StageTimer::~StageTimer() {
    Stage& stage = stats_.stage(name_);
    stage.wall_seconds += wall_now_seconds() - wall_start_;
    stage.cpu_seconds += cpu_now_seconds() - cpu_start_;
}

}  // namespace photond
