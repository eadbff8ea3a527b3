#pragma once
// Depth maps of virtual point lights from points instead of triangles: each light is shown a random share of the
// scene's points, discs as wide as the others are apart, and holes between them are closed from coarser levels.
//
// [Ritschel, Grosch, Kim, Seidel, Dachsbacher, Kautz 2008] Imperfect Shadow Maps for Efficient Computation of Indirect
// Illumination. ACM TOG 27(5). Pull-push: [Grossman and Dally 1998] Point Sample Rendering. EGWR; by distances that are
// alike: [Marroquim, Kraus, Cavalcanti 2007] Efficient Point-Based Rendering Using Image Reconstruction. PBG.
//
// Where this departs from the paper: maps are octahedral, not paraboloids, and discs are drawn as discs, at the
// distance of their plane in each texel, so that what they shadow follows vpl_shadow_maps.h; each pass shows each
// light another share.
//
// Wrong beside that: discs stand out beyond edges by up to their radius, nothing nearer to a light than that shadows
// it, and up to 2^kLevels - 1 texels beside a surface are closed too where nothing is behind it.

#include <optional>

#include "renderer/many_lights/imperfect_shadow_maps_shared.h"
#include "renderer/many_lights/vpl_shadow_maps_gpu.h"

namespace photond {

/// Fills the maps of a VplShadowMapsGpu, in place of tracing them. Borrows it.
class ImperfectShadowMaps {
public:
    static constexpr uint32_t kLevels = 2;       // above the maps
    static constexpr uint32_t kDiscsAPath = 16;  // that cost a device what a path does

    /// `points`: that each light is shown, out of IMPERFECT_CHOICE times as many.
    ImperfectShadowMaps(const gpu::DeviceScene& scene, VplShadowMapsGpu& maps, uint32_t points);

    /// A pass is recorded in that many pieces, 0 ..., each short enough for one submit. Scope `shadow_maps`. A pure
    /// function of the lights, the scene, seed and pass.
    uint32_t pieces() const { return pieces_; }
    /// Each takes about as long as that many paths.
    uint64_t paths_of_piece() const { return uint64_t{lights_at_once_} * points_ / kDiscsAPath; }
    void record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count, uint64_t seed, uint32_t pass,
                uint32_t piece);

    float disc_radius_m() const { return radius_m_; }
    /// Beside the maps; of the host while it is made.
    static uint64_t device_bytes(uint32_t resolution, uint32_t most_lights, uint32_t points);
    static uint64_t host_bytes(uint32_t points);

private:
    void record_levels(gpu::CommandList& commands, gpu::DeviceWord count);

    VplShadowMapsGpu& maps_;
    const uint32_t points_, lights_at_once_, pieces_;
    float radius_m_ = 0;
    gpu::Buffer occluders_;  // nothing where the scene has no area
    gpu::Buffer levels_[kLevels];
    gpu::ComputePipeline splat_, pull_, push_;
};

}  // namespace photond
