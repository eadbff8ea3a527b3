#include "renderer/photons/photon_tracer_gpu.h"

#include <algorithm>

#include "renderer/photons/photon_tracing_scene.h"
#include "renderer/photons/projection_map.h"
#include "renderer/photons/projection_map_shared.h"

namespace photond {

namespace {

static_assert(PHOTON_MAP_GLOBAL == static_cast<int>(PhotonMapKind::Global) &&
              PHOTON_MAP_CAUSTIC == static_cast<int>(PhotonMapKind::Caustic) &&
              PHOTON_MOST_SCATTERINGS == PhotonPayload::kMostScatterings);
static_assert(PHOTON_SET_DIRECTION == sample_set(EmissionSet::Direction) &&
              PHOTON_SET_POSITION == sample_set(EmissionSet::Position) &&
              PHOTON_SET_LIGHT == sample_set(EmissionSet::Light));

constexpr uint64_t kPhotonBytes = sizeof(gpu::PhotonPlace) + sizeof(gpu::PhotonPower) + 2 * sizeof(uint32_t);

gpu::Buffer make_stores(const gpu::DeviceScene& scene) {
    std::vector<uint32_t> stores(scene.scene().instances.size());
    for (uint32_t instance = 0; instance < stores.size(); ++instance)
        stores[instance] = stores_photons(scene.scene(), instance);
    return gpu::make_buffer(scene.device(), "photon_tracer", std::span<const uint32_t>(stores));
}

}  // namespace

UnsortedPhotons::UnsortedPhotons(gpu::Device& device, uint32_t capacity)
    : places(device, "photons", uint64_t{capacity} * sizeof(gpu::PhotonPlace)),
      powers(device, "photons", uint64_t{capacity} * sizeof(gpu::PhotonPower)),
      paths(device, "photons", uint64_t{capacity} * sizeof(uint32_t)),
      order(device, "photons", uint64_t{capacity} * sizeof(uint32_t)),
      sort(device, capacity) {
    // A map with room for fewer, of a pass that stores more, is made of whatever stands here, and made again.
    gpu::CommandList commands(device);
    commands.fill(order, 0);
    commands.submit();
    commands.wait();
}

uint64_t UnsortedPhotons::bytes_for(uint64_t capacity) {
    return capacity * (kPhotonBytes + 2 * sizeof(uint32_t)) + capacity / 4;  // and the sort's counts, at most
}

PhotonTracerGpu::PhotonTracerGpu(const gpu::DeviceScene& scene, const PhotonTracing& tracing,
                                 uint32_t bounce_map_texels)
    : tracing_(tracing),
      texels_(std::min(bounce_map_texels, tracing.photons)),
      state_(scene.device(), "photon_tracer", kStateBytes),
      stores_(make_stores(scene)),
      first_hits_(scene.device(), "bounce_map", bounce_map_bytes(std::max(texels_, 1u))),
      pipeline_(scene.device(), "renderer/photons/photon_tracing.comp", sizeof(gpu::PhotonTracingPush), &scene.set(),
                scene.specialization(std::vector{gpu::specialize(GUIDED_ID, tracing.guide != nullptr),
                                                 gpu::specialize(BOUNCE_MAP_ID, texels_ > 0)})) {
    if (texels_ > 0)
        bounces_.emplace(scene.device(), "renderer/photons/bounce_map.comp", sizeof(gpu::BounceMapPush), &scene.set(),
                         scene.specialization(std::vector{gpu::specialize(GUIDED_ID, tracing.guide != nullptr)}));
    const ProjectionMap::DeviceTables tables =
        tracing.guide ? tracing.guide->device_tables() : ProjectionMap::DeviceTables{};
    guide_words_ = gpu::make_buffer(scene.device(), "projection_map", std::span<const uint32_t>(tables.words));
    guide_cdf_ = gpu::make_buffer(scene.device(), "projection_map", std::span<const float>(tables.cdf));
}

uint64_t PhotonTracerGpu::device_bytes(uint64_t instances, uint64_t guide_bytes) {
    return kStateBytes + instances * sizeof(uint32_t) + guide_bytes;
}

void PhotonTracerGpu::record_start(gpu::CommandList& commands) { commands.fill(state_, 0); }

void PhotonTracerGpu::record_bounce_map(gpu::CommandList& commands, uint64_t seed, uint32_t pass, uint32_t first,
                                        uint32_t end) {
    commands.bind(*bounces_, {gpu::read_write("state", state_), gpu::write("first_hits", first_hits_),
                              gpu::read("guide_words", guide_words_), gpu::read("guide_cdf", guide_cdf_)});
    commands.push(gpu::BounceMapPush{sequence_of(seed).device_key(), uint64_t{pass} * texels_, first, end});
    commands.dispatch_threads(end - first, PHOTON_TRACING_GROUP);
}

SequenceSampler PhotonTracerGpu::sequence_of(uint64_t seed) const {
    return {tracing_.sampler, seed, RandomDomain::Photons, static_cast<uint32_t>(tracing_.kind)};
}

void PhotonTracerGpu::record_paths(gpu::CommandList& commands, uint64_t seed, uint32_t pass, uint32_t first,
                                   uint32_t end, UnsortedPhotons& photons, uint32_t capacity) {
    const uint32_t threads = std::min(end - first, kMostPathThreads);
    commands.fill(state_, 0, NEXT_PATH_WORD * sizeof(uint32_t), sizeof(uint32_t));
    commands.bind(pipeline_, {gpu::read_write("state", state_), gpu::write("places", photons.places),
                              gpu::write("powers", photons.powers), gpu::write("paths", photons.paths),
                              gpu::write("order", photons.order), gpu::read("instance_stores", stores_),
                              gpu::read("guide_words", guide_words_), gpu::read("guide_cdf", guide_cdf_),
                              gpu::read("first_hits", first_hits_)});
    commands.push(gpu::PhotonTracingPush{.sequence = sequence_of(seed).device_key(),
                                         .first_element = uint64_t{pass} * tracing_.photons,
                                         .first_path = first,
                                         .end_path = end,
                                         .photons = tracing_.photons,
                                         .most_scatterings = tracing_.most_scatterings,
                                         .kind = static_cast<uint32_t>(tracing_.kind),
                                         .capacity = capacity,
                                         .glossy_threshold = tracing_.glossy_threshold,
                                         .threads = threads,
                                         .texels = texels_});
    commands.dispatch_threads(threads, PHOTON_TRACING_GROUP);
}

void PhotonTracerGpu::add_to(Counts& counts, std::span<const uint32_t> state) const {
    counts.photons_emitted += tracing_.photons;
    counts.photons_stored += state[PHOTONS_STORED_WORD];
    if (texels_ > 0) counts.photon_rays_saved += tracing_.photons - texels_;
    counts.photon_rays += uint64_t{state[PHOTON_RAYS_WORD + 1]} << 32 | state[PHOTON_RAYS_WORD];
    counts.nan_samples += state[NAN_SAMPLES_WORD];
    counts.infinite_samples += state[INFINITE_SAMPLES_WORD];
}

}  // namespace photond
