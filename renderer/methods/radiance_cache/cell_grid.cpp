#include "renderer/methods/radiance_cache/cell_grid.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/rng.h"

namespace photond {

std::optional<uint32_t> CellGrid::level(float distance_m, float spread_m) const {
    const auto level_of = [&](float side) {
        const float levels = std::ceil(std::log2(coarsest_m / side));
        return levels >= float{kMostLevel} ? kMostLevel : static_cast<uint32_t>(std::max(levels, 0.0f));
    };
    const uint32_t by_eye = level_of(of_distance * distance_m);
    if (spread_m >= side_m(by_eye)) return by_eye;
    const uint32_t by_ray = level_of(spread_m);
    if (by_ray > by_eye + kFinerLevels || spread_m < side_m(by_ray)) return std::nullopt;
    return by_ray;
}

CellKey CellGrid::key(const vec3& position, const vec3& normal, uint32_t direction, uint32_t level) const {
    const vec3 cell = glm::floor((position - origin) / side_m(level));
    // Halves of the normal's components: faces of a box, and those cut off its edges, lie in the middle of a share.
    const vec3 side = glm::round(2.0f * normal) + 2.0f;
    const auto whole = [](float x) { return static_cast<uint32_t>(static_cast<int32_t>(x)); };
    const uint32_t facing = whole(side.x) + 5 * (whole(side.y) + 5 * whole(side.z));
    uint32_t place = hash32(whole(cell.x) ^ 0x9e3779b9u), fingerprint = hash32(whole(cell.x) ^ 0x7f4a7c15u);
    for (const uint32_t part : {whole(cell.y), whole(cell.z), level | facing << 5 | direction << 12}) {
        place = hash32(place ^ part);
        fingerprint = hash32(fingerprint + part);
    }
    return {place, std::max(fingerprint, 1u)};
}

uint32_t direction_bin(const vec3& direction, uint32_t side) {
    const vec3 n = direction / (std::fabs(direction.x) + std::fabs(direction.y) + std::fabs(direction.z));
    vec2 on_square(n.x, n.y);
    if (n.z < 0) on_square = {std::copysign(1 - std::fabs(n.y), n.x), std::copysign(1 - std::fabs(n.x), n.y)};
    const auto row = [&](float x) {
        const auto most = static_cast<float>(side);
        return static_cast<uint32_t>(std::clamp(std::floor(0.5f * (x + 1) * most), 0.0f, most - 1));
    };
    return row(on_square.x) + side * row(on_square.y);
}

}  // namespace photond
