#include "renderer/photons/reflected_photons_gpu.h"

#include <algorithm>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

static_assert(sizeof(gpu::ReflectedPhotonRecord) == sizeof(ReflectedPhoton) &&
              sizeof(gpu::ReflectingSurfaceRecord) == sizeof(ReflectingSurface));
static_assert(SPREAD_LAMBERT == static_cast<uint32_t>(ReflectedPhoton::Spread::Lambert) &&
              SPREAD_ROUGH == static_cast<uint32_t>(ReflectedPhoton::Spread::Rough) &&
              SPREAD_BEAM == static_cast<uint32_t>(ReflectedPhoton::Spread::Beam) &&
              MOST_CASTER == ReflectedPhoton::kMostCaster);

uint32_t most_scatterings(const PhotonTracing& tracing) {
    return tracing.injection == PhotonInjection::ReflectiveShadowMap ? std::min(tracing.most_scatterings, 1u)
                                                                     : tracing.most_scatterings;
}

}  // namespace

uint32_t ReflectedPhotonsGpu::expected_photons(const PhotonTracing& tracing) {
    constexpr double kExpectedYield = 0.7;  // of a path at each of its scatterings, in a furnished closed room
    const double photons = kExpectedYield * tracing.photons * std::clamp(tracing.most_scatterings, 1u, 8u);
    return static_cast<uint32_t>(std::clamp(photons, 1024.0, 2e9));
}

uint64_t ReflectedPhotonsGpu::device_bytes(const PhotonTracing& tracing, bool lambert) {
    const uint64_t photons = expected_photons(tracing);
    return photons * (sizeof(gpu::ReflectedPhotonRecord) + sizeof(gpu::PhotonOwner) + sizeof(uint32_t)) +
           (lambert ? 1 : photons) * sizeof(gpu::ReflectingSurfaceRecord) + tracing.photons * sizeof(uint32_t);
}

ReflectedPhotonsGpu::ReflectedPhotonsGpu(const gpu::DeviceScene& scene, const EmissionSampler& emission,
                                         const PhotonTracing& tracing, gpu::Buffer& counters)
    : device_(scene.device()),
      tracing_(tracing),
      counters_(counters),
      state_(device_, "photons", REFLECTION_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device_, "readback", state_.bytes(), gpu::MemoryKind::Readback),
      path_counts_(device_, "photon_paths", (uint64_t{tracing.photons} + 1) * sizeof(uint32_t)),
      grids_(device_, "photon_paths", sizeof(gpu::TexelGrid)),
      trace_(device_, "renderer/photons/reflected_photons.comp", sizeof(gpu::ReflectionPush), &scene.set(),
             scene.specialization()),
      sort_(device_, "renderer/photons/reflected_photon_order.comp", sizeof(uint32_t)),
      sum_(device_, tracing.photons + 1) {
    if (tracing.injection == PhotonInjection::ReflectiveShadowMap) maps_.emplace(emission, tracing.photons);
    make_room(expected_photons(tracing), scene.scene().needs.only_lambert() ? 1 : expected_photons(tracing));
}

void ReflectedPhotonsGpu::make_room(uint32_t photons, uint32_t surfaces) {
    if (photons > photon_capacity_) {
        photons_ = {}, owners_ = {}, order_ = {};  // not both at once
        photons_ = gpu::Buffer(device_, "photons", uint64_t{photons} * sizeof(gpu::ReflectedPhotonRecord));
        owners_ = gpu::Buffer(device_, "photons", uint64_t{photons} * sizeof(gpu::PhotonOwner));
        order_ = gpu::Buffer(device_, "photons", uint64_t{photons} * sizeof(uint32_t));
        photon_capacity_ = photons;
    }
    if (surfaces > surface_capacity_) {
        surfaces_ = {};
        surfaces_ = gpu::Buffer(device_, "photons", uint64_t{surfaces} * sizeof(gpu::ReflectingSurfaceRecord));
        surface_capacity_ = surfaces;
    }
}

uint32_t ReflectedPhotonsGpu::start(uint64_t seed, uint32_t pass) {
    push_ = {.first_element = uint64_t{pass} * tracing_.photons,
             .most_scatterings = most_scatterings(tracing_),
             .photon_capacity = photon_capacity_,
             .surface_capacity = surface_capacity_,
             .rough_apart = tracing_.rough_apart,
             .share = 1 / static_cast<float>(tracing_.photons),
             .glossy_threshold = tracing_.glossy_threshold};
    paths_ = tracing_.photons;
    if (maps_) {
        const ReflectiveShadowMapPass texels(*maps_, seed, pass);
        const std::vector<gpu::TexelGrid> grids = texels.device_grids();
        const std::span<const std::byte> bytes = std::as_bytes(std::span(grids));
        if (bytes.size() > grids_.bytes()) {
            grids_ = {};
            grids_ = gpu::Buffer(device_, "photon_paths", bytes.size());
        }
        gpu::upload(device_, grids_, bytes);
        push_.first_element = 0;
        push_.grids = static_cast<uint32_t>(grids.size());
        push_.share = 1;
        paths_ = static_cast<uint32_t>(texels.texels());
        seed = texels.seed();
    }
    push_.sequence =
        SequenceSampler(tracing_.sampler, seed, RandomDomain::Photons, static_cast<uint32_t>(tracing_.kind))
            .device_key();
    return paths_;
}

void ReflectedPhotonsGpu::record_start(gpu::CommandList& commands) {
    std::array<uint32_t, REFLECTION_STATE_WORDS> words{};
    words[REFLECTION_PATHS] = paths_;
    commands.update(state_, words);
}

void ReflectedPhotonsGpu::record_paths(gpu::CommandList& commands, uint32_t first, uint32_t end) {
    const gpu::Scope scope(commands, "photon_tracing");
    commands.bind(trace_, {gpu::read_write("device_counters", counters_), gpu::read_write("state", state_),
                           gpu::write("photons", photons_), gpu::write("owners", owners_),
                           gpu::write("photons_of_path", path_counts_), gpu::write("surfaces", surfaces_),
                           gpu::read("grids", grids_)});
    gpu::ReflectionPush push = push_;
    push.first_path = first;
    push.end_path = end;
    commands.push(push);
    commands.dispatch_threads(end - first, REFLECTION_GROUP);
}

void ReflectedPhotonsGpu::record_order(gpu::CommandList& commands) {
    {
        const gpu::Scope scope(commands, "photon_tracing");
        sum_.record(commands, path_counts_, path_counts_, {state_, REFLECTION_PATHS}, {state_, REFLECTION_ORDERED});
        commands.bind(sort_, {gpu::read("state", state_), gpu::read("owners", owners_),
                              gpu::read("first_of_path", path_counts_), gpu::write("order", order_)});
        commands.push(photon_capacity_);
        commands.dispatch_threads(photon_capacity_, REFLECTION_GROUP);
    }
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

bool ReflectedPhotonsGpu::grow_if_short() {
    const uint32_t photons = counted(REFLECTION_PHOTONS), surfaces = counted(REFLECTION_SURFACES);
    if (photons <= photon_capacity_ && surfaces <= surface_capacity_) return false;
    const auto roomy = [](uint32_t count, uint32_t capacity) {
        return count > capacity ? static_cast<uint32_t>(std::min(uint64_t{count} * 5 / 4, uint64_t{UINT32_MAX})) : 0u;
    };
    make_room(roomy(photons, photon_capacity_), roomy(surfaces, surface_capacity_));
    return true;
}

void ReflectedPhotonsGpu::add_to(Counts& counts) const {
    counts.nan_samples += counted(REFLECTION_NAN_SAMPLES);
    counts.infinite_samples += counted(REFLECTION_INFINITE_SAMPLES);
}

}  // namespace photond
