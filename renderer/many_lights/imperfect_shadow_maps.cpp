#include "renderer/many_lights/imperfect_shadow_maps.h"

#include <algorithm>

#include "renderer/core/rng.h"
#include "renderer/many_lights/occluder_points.h"
#include "renderer/scene/surface_area.h"

namespace photond {

namespace {

/// Of the surface that the discs of a light have together: what one leaves free another covers. Measured from 1 to 3,
/// by the light wrongly let through or kept: in the Cornell box less is worse, among thin things more.
constexpr float kCoverage = 2;
constexpr uint64_t kKeyStream = 1;  // of the pass's random numbers
constexpr uint32_t kInfinityBits = 0x7f800000u;

uint32_t side_of(uint32_t resolution, uint32_t level) {
    for (; level > 0; --level) resolution = (resolution + 1) / 2;
    return resolution;
}

}  // namespace

uint64_t ImperfectShadowMaps::host_bytes(uint32_t points) {
    return uint64_t{points} * IMPERFECT_CHOICE * sizeof(gpu::OccluderPoint);
}

uint64_t ImperfectShadowMaps::device_bytes(uint32_t resolution, uint32_t most_lights, uint32_t points) {
    uint64_t bytes = host_bytes(points);
    for (uint32_t level = 1; level <= kLevels; ++level)
        bytes += VplShadowMapsGpu::device_bytes(side_of(resolution, level), most_lights);
    return bytes;
}

ImperfectShadowMaps::ImperfectShadowMaps(const gpu::DeviceScene& scene, VplShadowMapsGpu& maps, uint32_t points)
    : maps_(maps),
      points_(points),
      lights_at_once_(std::max(kDiscsAPath * scene.device().paths_per_submit() / points, 1u)),
      pieces_((maps.most_lights() + lights_at_once_ - 1) / lights_at_once_),
      splat_(scene.device(), "renderer/many_lights/imperfect_splat.comp", sizeof(gpu::ImperfectSplatPush)),
      pull_(scene.device(), "renderer/many_lights/imperfect_pull.comp", sizeof(gpu::ImperfectLevelPush)),
      push_(scene.device(), "renderer/many_lights/imperfect_push.comp", sizeof(gpu::ImperfectLevelPush)) {
    const std::vector<gpu::OccluderPoint> occluders = make_occluder_points(scene.scene(), points * IMPERFECT_CHOICE);
    if (!occluders.empty()) occluders_ = gpu::make_buffer(scene.device(), "occluder_points", std::span(occluders));
    radius_m_ = static_cast<float>(std::sqrt(kCoverage * surface_area_m2(scene.scene()) / (double{kPi} * points)));
    for (uint32_t level = 1; level <= kLevels; ++level)
        levels_[level - 1] =
            gpu::Buffer(scene.device(), "shadow_maps",
                        VplShadowMapsGpu::device_bytes(side_of(maps.resolution(), level), maps.most_lights()));
}

void ImperfectShadowMaps::record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count, uint64_t seed,
                                 uint32_t pass, uint32_t piece) {
    const gpu::Scope scope(commands, "shadow_maps");
    if (piece == 0) commands.fill(maps_.reach(), kInfinityBits);
    if (!occluders_) return;
    const uint32_t first = piece * lights_at_once_, end = std::min(first + lights_at_once_, maps_.most_lights());
    commands.bind(splat_, {gpu::read("vpls", vpls), gpu::read("counts", *count.buffer), gpu::read("points", occluders_),
                           gpu::read_write("reach_m", maps_.reach())});
    commands.push(gpu::ImperfectSplatPush{.resolution = maps_.resolution(),
                                          .count_word = count.index,
                                          .first_light = first,
                                          .end_light = end,
                                          .points = points_,
                                          .key = RandomStream(seed, RandomDomain::Splats, pass, kKeyStream).next_bits(),
                                          .radius_m = radius_m_});
    commands.dispatch_threads(uint64_t{end - first} * points_, IMPERFECT_GROUP);
    if (piece + 1 == pieces_) record_levels(commands, count);
}

void ImperfectShadowMaps::record_levels(gpu::CommandList& commands, gpu::DeviceWord count) {
    const auto level = [&](const gpu::ComputePipeline& pipeline, uint32_t coarse, uint32_t threads_side,
                           std::initializer_list<gpu::Binding> bindings) {
        commands.bind(pipeline, bindings);
        commands.push(gpu::ImperfectLevelPush{.count_word = count.index,
                                              .most_lights = maps_.most_lights(),
                                              .fine_side = side_of(maps_.resolution(), coarse - 1),
                                              .coarse_side = side_of(maps_.resolution(), coarse)});
        commands.dispatch_threads(uint64_t{maps_.most_lights()} * threads_side * threads_side, IMPERFECT_GROUP);
    };
    const auto buffer = [&](uint32_t at) -> gpu::Buffer& { return at == 0 ? maps_.reach() : levels_[at - 1]; };
    for (uint32_t coarse = 1; coarse <= kLevels; ++coarse)
        level(pull_, coarse, side_of(maps_.resolution(), coarse),
              {gpu::read("counts", *count.buffer), gpu::read("fine_m", buffer(coarse - 1)),
               gpu::write("coarse_m", buffer(coarse))});
    for (uint32_t coarse = kLevels; coarse > 0; --coarse)
        level(push_, coarse, side_of(maps_.resolution(), coarse - 1),
              {gpu::read("counts", *count.buffer), gpu::read("coarse_m", buffer(coarse)),
               gpu::read_write("fine_m", buffer(coarse - 1))});
}

}  // namespace photond
