#pragma once
// Where lights would help the picture: what light from a place brings to some of the points that the eye sees.
// For VPL placement `camera`; GPU twin: camera_importance.comp.
//
// [Segovia et al. 2006] Bidirectional Instant Radiosity. EGSR (the idea: lights are resampled by what they bring to the
// camera).

#include <functional>
#include <vector>

#include "renderer/gbuffer/gbuffer.h"
#include "renderer/photons/reflected_photon.h"

namespace photond {

class SparseVoxelOctree;

class CameraImportance {
public:
    static constexpr uint32_t kPoints = 64;  // of the G-buffer, drawn anew each pass

    /// `tree`, which is borrowed, answers for V; null: all is seen. `clamp_sq_m2`: B.
    CameraImportance(const GBuffer& buffer, const SparseVoxelOctree* tree, float clamp_sq_m2, uint64_t seed,
                     uint32_t pass);

    /// What flux leaving there brings to the points, over that flux: sum of weight cos_o cos_x / max(B, d^2) V. Any
    /// scale.
    float operator()(const ReflectedPhoton& photon) const;

private:
    struct Point {
        vec3 position, normal, geometric_normal;
        float weight;
    };
    std::vector<Point> points_;
    const SparseVoxelOctree* tree_;
    float clamp_sq_m2_;
};

}  // namespace photond
