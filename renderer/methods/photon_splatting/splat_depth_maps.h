#pragma once
// Visibility within a splat (thesis 3.3): an orthographic depth map across the photon's ray, looking along it.

#include <span>
#include <vector>

#include "renderer/core/stats.h"
#include "renderer/scene/intersector.h"

namespace photond {

/// The volume one splat may light: a square prism about the photon's ray.
struct SplatFrustum {
    vec3 near_centre;  // world [m]: on the ray, stepped back from its hit
    vec3 axis;         // unit, along the ray
    float half_side_m;
    float depth_m;
};

/// Depth maps of a batch of splats. Rays are traced through the texels' centres; surfaces count from both sides. As the
/// near plane may lie behind or within what stands beside the ray (corners), and as a texel's centre stands for all of
/// it, a depth counts as reached when it is so for any texel of the 3x3 about it, to within a texel's width: borderline
/// cases are lit (thesis 3.3).
class SplatDepthMaps {
public:
    /// `resolution` texels along each side, 4 to 64.
    explicit SplatDepthMaps(uint32_t resolution) : resolution_(resolution) {}

    /// Replaces the maps. Adds to counts.shadow_rays. One thread; each thread has maps of its own.
    void trace(std::span<const SplatFrustum> frusta, const Intersector& intersector, Counts& counts);

    /// Whether light along the axis reaches the point at `across` (metres from the axis along the frame's tangent and
    /// bitangent, within the half side) at depth `along` [m] from the near plane.
    bool reaches(size_t frustum, vec2 across, float along) const;
    /// The frame that `across` is measured in.
    static Frame frame(const SplatFrustum& frustum) { return Frame(frustum.axis); }

    static uint64_t bytes_for(size_t frusta, uint32_t resolution);

private:
    uint32_t resolution_;
    std::vector<float> half_sides_m_;
    std::vector<float>
        farthest_m_;  // by frustum, row and column: the greatest depth of the 3x3 texels about it, and tolerance
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

}  // namespace photond
