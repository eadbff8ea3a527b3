#pragma once
// The environment as surfaces of all roughnesses reflect it, looked at straight on: the split sum's first factor.
//
// [Karis 2013] Real Shading in Unreal Engine 4.

#include <span>
#include <vector>

#include "renderer/core/rgb.h"
#include "renderer/methods/image_based_lighting/prefiltered_environment_shared.h"

namespace photond {

struct Environment;
class EnvironmentSampler;

struct PrefilterSettings {
    uint32_t resolution = 256;  // cells along a side of the sharpest map; a power of two
    uint32_t levels = 12;
};

/// Octahedral maps of EnvironmentPyramid::blurred(), by roughness. The last one, of roughness 1, is the irradiance map
/// over pi; before the first there is the environment itself.
class PrefilteredEnvironment {
public:
    /// In parallel. Borrows the sampler, which is the environment's.
    PrefilteredEnvironment(const Environment& environment, const EnvironmentSampler& sampler,
                           const PrefilterSettings& settings);
    static uint64_t bytes_for(const PrefilterSettings& settings);
    /// Of what is needed while it is made, and no longer.
    static uint64_t scratch_bytes(const PrefilterSettings& settings, Size2 map);

    /// About a unit direction, by a lobe of that roughness in [0, 1]. Linear between the nodes of a map and, by the
    /// roughness's logarithm, between maps.
    Rgb radiance(const vec3& direction, float roughness) const;
    /// What a white Lambert reflector makes of it: irradiance over pi.
    Rgb reflected_by_white(const vec3& normal) const { return at(constants_.levels - 1, normal); }

    // For the twin in prefiltered_environment.glsl.
    const gpu::PrefilterConstants& constants() const { return constants_; }
    std::span<const Rgb> nodes() const { return nodes_; }

private:
    Rgb at(uint32_t level, const vec3& direction) const;

    const EnvironmentSampler& sampler_;
    gpu::PrefilterConstants constants_{};
    std::vector<Rgb> nodes_;  // of all maps
};

}  // namespace photond
