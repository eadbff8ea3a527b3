#include "renderer/many_lights/vpl_lighting_gpu.h"

#include <algorithm>

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl_lighting.h"

namespace photond {

namespace {

static_assert(VPL_VISIBILITY_SVO == static_cast<uint32_t>(VplVisibility::Svo) &&
              VPL_VISIBILITY_RAYS == static_cast<uint32_t>(VplVisibility::Rays) &&
              VPL_VISIBILITY_MAPS == static_cast<uint32_t>(VplVisibility::ShadowMaps) &&
              VPL_VISIBILITY_NONE == static_cast<uint32_t>(VplVisibility::None) &&
              VPL_VISIBILITY_NEAR_FIELD == static_cast<uint32_t>(VplVisibility::NearField));

/// Lights that a point goes through at a time: the mean that roulette goes by is theirs.
constexpr uint32_t kLightsAtOnce = 4096;

/// Lights that cost a point about what a path does, which is a dozen rays.
uint64_t lights_a_path(VplVisibility visibility) {
    return asks_voxels(visibility) || visibility == VplVisibility::Rays ? 8 : 32;
}

uint32_t points_at_once(const gpu::Device& device, VplVisibility visibility, uint32_t lights, uint32_t points) {
    const uint64_t in_time = lights_a_path(visibility) * device.paths_per_submit() / lights;
    const uint64_t groups = (std::min<uint64_t>(in_time, points) + SPLIT_GROUP - 1) / SPLIT_GROUP;
    return static_cast<uint32_t>(std::max<uint64_t>(groups, 1)) * SPLIT_GROUP;
}

uint32_t lights_of_tile(uint32_t lights, const GBufferGpu& buffer) {
    return (lights + buffer.layout().tiles() - 1) / buffer.layout().tiles();
}

}  // namespace

std::string VplVisibilityGpu::shader(const std::string& stem, VplVisibility kind) {
    switch (kind) {
        case VplVisibility::Svo:
        case VplVisibility::NearField: return stem + "_svo.comp";
        case VplVisibility::Rays: return stem + "_rays.comp";
        case VplVisibility::ShadowMaps: return stem + "_maps.comp";
        case VplVisibility::None: break;
    }
    return stem + "_none.comp";
}

void VplVisibilityGpu::append_to(std::vector<gpu::Binding>& bindings) const {
    if (asks_voxels(kind))
        bindings.insert(bindings.end(),
                        {gpu::read("svo_constants", tree->constants()), gpu::read("svo_nodes", tree->nodes()),
                         gpu::read("svo_bricks", tree->bricks())});
    if (kind == VplVisibility::ShadowMaps) bindings.push_back(gpu::read("vpl_map_reach_m", maps->reach()));
}

VplLightingGpu::VplLightingGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, VplSetGpu& lights,
                               gpu::Buffer& counters, uint64_t seed, const VplLightingSettings& settings)
    : buffer_(buffer),
      lights_(lights),
      counters_(counters),
      seed_(seed),
      settings_(settings),
      lights_at_once_(std::min(lights_of_tile(lights.likely(), buffer), kLightsAtOnce)),
      points_at_once_(points_at_once(scene.device(), settings.visibility, lights_at_once_, buffer.layout().points())),
      point_pieces_((buffer.layout().points() + points_at_once_ - 1) / points_at_once_),
      light_pieces_((lights_of_tile(lights.most(), buffer) + lights_at_once_ - 1) / lights_at_once_),
      constants_(scene.device(), "vpl_constants", sizeof(gpu::VplLightingConstants)) {
    if (settings.lights_all)
        light_.emplace(scene.device(),
                       VplVisibilityGpu::shader("renderer/many_lights/vpl_lighting", settings.visibility),
                       static_cast<uint32_t>(sizeof(gpu::VplLightingPush)), &scene.set(), scene.specialization());
}

uint64_t VplLightingGpu::paths_of_piece() const {
    return uint64_t{points_at_once_} * lights_at_once_ / lights_a_path(settings_.visibility);
}

uint32_t VplLightingGpu::rotation(uint64_t seed, uint32_t pass, uint32_t tiles) {
    return RandomStream(seed, RandomDomain::Splats, pass, 0).next_bits() % tiles;
}

void VplLightingGpu::record_constants(gpu::CommandList& commands, uint32_t pass) {
    commands.update(constants_, gpu::VplLightingConstants{.seed = seed_,
                                                          .pass = pass,
                                                          .rotation = rotation(seed_, pass, buffer_.layout().tiles()),
                                                          .split = buffer_.split(),
                                                          .clamp_sq_m2 = settings_.clamp_sq_m2,
                                                          .roulette = settings_.roulette,
                                                          .glossy_threshold = buffer_.glossy_threshold(),
                                                          .connect_threshold = settings_.connect_threshold,
                                                          .map_resolution = settings_.map_resolution,
                                                          .voxel_reach_m = settings_.voxel_reach_m});
}

void VplLightingGpu::record(gpu::CommandList& commands, const VplVisibilityGpu& visibility, uint32_t piece) {
    const uint32_t first = piece % point_pieces_ * points_at_once_;
    const uint32_t first_light = piece / point_pieces_ * lights_at_once_;
    const uint32_t end = std::min(first + points_at_once_, buffer_.layout().points());
    const gpu::Scope scope(commands, "indirect");
    std::vector<gpu::Binding> bindings = {
        gpu::read_write("device_counters", counters_), gpu::read("constants", constants_),
        gpu::read("points", buffer_.points()),         gpu::read("general_points", buffer_.general()),
        gpu::read("counts", lights_.counts()),         gpu::read("vpls", lights_.vpls()),
        gpu::read("vpl_lobes", lights_.lobes()),       gpu::read_write("sums", buffer_.sums())};
    visibility.append_to(bindings);
    commands.bind(*light_, bindings);
    commands.push(gpu::VplLightingPush{first, end, first_light, first_light + lights_at_once_});
    commands.dispatch_threads(end - first, SPLIT_GROUP);
}

}  // namespace photond
