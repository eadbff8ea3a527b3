#pragma once
// Parts of the reference picture of the diffuse Cornell box (tests/data/reference) that methods are judged on apart.

#include <gtest/gtest.h>

#include "tests/support/reference_bias.h"

namespace photond::test {

inline constexpr size_t kReferenceRegions = 6;

struct Region {
    const char* name;
    Mask mask;
};

/// Regions of the picture: surfaces as wholes, and strips by their distance from the edges of walls and boxes. Chosen
/// in the reference's pixels; a smaller picture's pixel belongs where all of those it stands for do.
inline std::vector<Region> regions_of(const Scene& scene, uint32_t side) {
    const std::vector<float> positions = positions_seen(scene, kReferenceSize);
    const std::vector<float> distances = distances_to_edges(scene, positions);
    const auto where = [&](const auto& belongs) {
        Mask mask(distances.size());
        for (size_t i = 0; i < mask.size(); ++i)
            mask[i] = distances[i] > 0 && belongs(positions[3 * i + 1], distances[i]);
        return reduced_mask(mask, side);
    };
    const float floor = scene.bounds.min.y, ceiling = scene.bounds.max.y;
    constexpr float kNear = 1e-3f;             // [m], of a surface
    constexpr float kStrips[] = {0.2f, 0.5f};  // [m]
    return {{"whole picture", {}},
            {"ceiling", where([&](float y, float) { return y > ceiling - kNear; })},
            {"floor", where([&](float y, float) { return y < floor + kNear; })},
            {"within 0.2 m of edges", where([&](float, float d) { return d < kStrips[0]; })},
            {"0.2 m to 0.5 m from edges", where([&](float, float d) { return d >= kStrips[0] && d < kStrips[1]; })},
            {"farther from edges", where([&](float, float d) { return d >= kStrips[1]; })}};
}

inline std::vector<Mask> masks_of(const std::vector<Region>& regions) {
    std::vector<Mask> masks;
    for (const Region& region : regions) masks.push_back(region.mask);
    return masks;
}

/// One bounce of the reference at the picture's size.
inline Expected one_bounce(uint32_t side) {
    const std::vector<float> image = reduced(reference_image("indirect_one_bounce_256.exr"), side);
    return {image, image};
}

}  // namespace photond::test
