#include "renderer/methods/image_based_lighting/prefiltered_environment.h"

#include <algorithm>
#include <bit>

#include "renderer/core/parallel.h"
#include "renderer/methods/image_based_lighting/environment_pyramid.h"
#include "renderer/transport/environment_sampling.h"

namespace photond {

namespace {

constexpr uint32_t kColumnsACell = 4;  // cells of the pyramid, around the horizon
constexpr float kCellOfAlpha = 0.5f;   // nodes of a map are so far apart, over alpha, where the resolution allows it

/// Across the map's fold at the horizon.
vec2 folded(const vec2& p) { return {std::copysign(1 - std::fabs(p.y), p.x), std::copysign(1 - std::fabs(p.x), p.y)}; }

/// A place in the unit square.
vec2 octahedral_place(const vec3& direction) {
    const vec3 size = glm::abs(direction);
    const vec2 p = vec2(direction) / (size.x + size.y + size.z);
    return 0.5f * (direction.z < 0 ? folded(p) : p) + 0.5f;
}

vec3 octahedral_direction(const vec2& place) {
    const vec2 p = 2.0f * place - 1.0f;
    const float z = 1 - std::fabs(p.x) - std::fabs(p.y);
    return glm::normalize(vec3(z < 0 ? folded(p) : p, z));
}

float alpha_of_level(const gpu::PrefilterConstants& constants, uint32_t level) {
    const float from_last = 1 - static_cast<float>(level) / static_cast<float>(constants.levels - 1);
    return sqr(std::pow(constants.least_roughness, from_last));
}

/// Nodes of half a turn are `side` cells apart. The lobe of the first level is as wide as one.
gpu::PrefilterConstants constants_of(const PrefilterSettings& settings) {
    gpu::PrefilterConstants constants{
        .levels = settings.levels,
        .least_roughness = std::sqrt(0.5f * kPi / static_cast<float>(settings.resolution)),
        .level = {}};
    uint32_t first = 0;
    for (uint32_t l = 0; l < settings.levels; ++l) {
        const float alpha = alpha_of_level(constants, l);
        const auto wanted = static_cast<uint32_t>(std::ceil(kPi / (kCellOfAlpha * alpha)));
        const uint32_t side = std::clamp<uint32_t>(std::bit_ceil(wanted), PREFILTER_LEAST_SIDE, settings.resolution);
        constants.level[l] = {first, side};
        first += (side + 1) * (side + 1);
    }
    return constants;
}

uint32_t nodes_of(const gpu::PrefilterConstants& constants) {
    const gpu::PrefilterLevel& last = constants.level[constants.levels - 1];
    return last.first + (last.side + 1) * (last.side + 1);
}

}  // namespace

uint64_t PrefilteredEnvironment::bytes_for(const PrefilterSettings& settings) {
    return nodes_of(constants_of(settings)) * sizeof(Rgb);
}

uint64_t PrefilteredEnvironment::scratch_bytes(const PrefilterSettings& settings, Size2 map) {
    return map.pixels() == 0 ? 0 : EnvironmentPyramid::bytes_for(map, kColumnsACell * settings.resolution);
}

PrefilteredEnvironment::PrefilteredEnvironment(const Environment& environment, const EnvironmentSampler& sampler,
                                               const PrefilterSettings& settings)
    : sampler_(sampler), constants_(constants_of(settings)), nodes_(nodes_of(constants_)) {
    const EnvironmentPyramid pyramid(environment, sampler, kColumnsACell * settings.resolution);
    for (uint32_t l = 0; l < constants_.levels; ++l) {
        const gpu::PrefilterLevel map = constants_.level[l];
        const float alpha = alpha_of_level(constants_, l);
        parallel_for(map.side + 1, 1, [&](size_t y) {
            for (uint32_t x = 0; x <= map.side; ++x) {
                const vec2 place = vec2(x, y) / static_cast<float>(map.side);
                nodes_[map.first + y * (map.side + 1) + x] = pyramid.blurred(octahedral_direction(place), alpha);
            }
        });
    }
}

Rgb PrefilteredEnvironment::radiance(const vec3& direction, float roughness) const {
    if (roughness <= constants_.least_roughness)
        return glm::mix(sampler_.radiance(direction), at(0, direction), roughness / constants_.least_roughness);
    const auto last = static_cast<float>(constants_.levels - 1);
    const float level = std::clamp(last * (1 - std::log(roughness) / std::log(constants_.least_roughness)), 0.0f, last);
    const uint32_t sharper = std::min(static_cast<uint32_t>(level), constants_.levels - 2);
    return glm::mix(at(sharper, direction), at(sharper + 1, direction), level - static_cast<float>(sharper));
}

Rgb PrefilteredEnvironment::at(uint32_t level, const vec3& direction) const {
    const auto [first, side] = constants_.level[level];
    const vec2 place = octahedral_place(direction) * static_cast<float>(side);
    const uint32_t x = std::min(static_cast<uint32_t>(place.x), side - 1),
                   y = std::min(static_cast<uint32_t>(place.y), side - 1);
    const float along = place.x - static_cast<float>(x), down = place.y - static_cast<float>(y);
    const Rgb* above = &nodes_[first + y * (side + 1) + x];
    const Rgb* below = above + side + 1;
    return glm::mix(glm::mix(above[0], above[1], along), glm::mix(below[0], below[1], along), down);
}

}  // namespace photond
