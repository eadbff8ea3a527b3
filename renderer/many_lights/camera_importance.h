#pragma once
// Where lights would help the picture: what light from a place brings to some of the points that the eye sees. For VPL
// placement: `camera`, by the lights' texels; `acceptance` and `metropolis` (path_selection.h), by whole light paths.
// GPU twins: camera_importance.comp, path_worth.comp.
//
// [Segovia et al. 2006] Bidirectional Instant Radiosity. EGSR (the idea: lights are resampled by what they bring to the
// camera).

#include <functional>
#include <vector>

#include "renderer/gbuffer/gbuffer.h"
#include "renderer/many_lights/camera_importance_shared.h"
#include "renderer/many_lights/vpl_tracer.h"

namespace photond {

class SparseVoxelOctree;

class CameraImportance {
public:
    static constexpr uint32_t kPoints = CAMERA_IMPORTANCE_POINTS;  // of the G-buffer, drawn anew each pass

    /// `tree`, which is borrowed, answers for V; null: all is seen. `clamp_sq_m2`: B.
    CameraImportance(const GBuffer& buffer, const SparseVoxelOctree* tree, float clamp_sq_m2, uint64_t seed,
                     uint32_t pass);
    /// Before there is a G-buffer: by what camera rays through places of the film meet first, for pilots.
    CameraImportance(const Scene& scene, const Intersector& intersector, const View& view, float clamp_sq_m2,
                     uint64_t seed);

    /// What flux leaving there brings to the points, over that flux: sum of weight cos_o cos_x / max(B, d^2) V. Any
    /// scale.
    float operator()(const ReflectedPhoton& photon) const;
    /// The same times the flux, by some of the points, which the element of each photon's path chooses; the scene
    /// answers for V by rays, which are counted. As RatePhotons (vpl_tracer.h).
    uint64_t brought(const Intersector& intersector, std::span<const ReflectedPhoton> photons,
                     std::span<const uint32_t> elements, std::span<PhotonWorth> worth) const;

private:
    struct Point {
        vec3 position, normal, geometric_normal;
        float weight;  // 0: there is none
    };
    /// But for V.
    float unshadowed(const Point& point, const ReflectedPhoton& photon) const;
    static vec3 lit_side(const Point& point, const ReflectedPhoton& photon);

    std::vector<Point> points_;
    const SparseVoxelOctree* tree_ = nullptr;
    float clamp_sq_m2_;
};

}  // namespace photond
