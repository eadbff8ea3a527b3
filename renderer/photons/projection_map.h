#pragma once
// Projection maps: which directions from the lights lead to specular surfaces, so that caustic photons are sent there;
// and, where most of what the lights send meets nothing, which lead to any surface, for all other photons.
// [Jensen 1996], [Gumhold, "Importance sampling of emitted photons via projection maps"] (docs/design/sources.md).
//
// The slides project the objects into bins of directions for sampled points of each light. Here rays are traced instead
// (a ray is what a photon will do; it knows occluders, textures with holes, and every kind of light), a few for each
// bin of the numbers the EmissionSampler draws from. Bins that saw such surfaces, and their neighbours, are preferred;
// every other bin keeps a share, so that nothing is missed.

#include <memory>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/scene/intersector.h"
#include "renderer/transport/emission_sampling.h"

namespace photond {

/// What photons are led to.
enum class ProjectionTarget : uint8_t {
    SpecularSurfaces,  // for caustic photons
    Surfaces,          // any that scatter: a photon that meets none is lost
};

class ProjectionMap {
public:
    /// Traces the pilot rays; a pure function of scene and seed. `glossy_threshold`: lobes with alpha below it are
    /// specular (bsdf.h, Bsdf::specular_part()).
    ProjectionMap(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                  ProjectionTarget target, float glossy_threshold, uint64_t seed);
    ~ProjectionMap();
    ProjectionMap(ProjectionMap&&) noexcept;

    /// Power-weighted share of unguided photons whose first hit is such a surface, measured by the pilot rays.
    double unguided_share() const;
    /// The share of guided ones, counted by further rays. unguided_share() where nothing is guided.
    double guided_share() const;
    /// Whether guiding pays: the guided share is at least twice the unguided one, and something was seen at all. Where
    /// it cannot (no such surface, or hardly any other first hit), sample() is unguided.
    bool helps() const;

    /// Whether the lights were divided into bins at all: not where there is nothing to look for, nor where a few rays
    /// showed that no share can be doubled.
    bool has_bins() const;

    /// Both shares in words, for what is skipped where it does not help.
    std::string text() const;

    /// As EmissionSampler::sample(), preferring the bins that saw such surfaces; the power makes up for it. No
    /// number is used twice: u_select chooses light and bin.
    bool sample(float u_select, const vec2& u_position, const vec2& u_direction, EmissionSample& out) const;

    /// For the twin in projection_map.glsl: its words, and the choice's cumulative table.
    struct DeviceTables {
        std::vector<uint32_t> words;
        std::vector<float> cdf;
    };
    DeviceTables device_tables() const;

    uint64_t pilot_rays() const;
    uint64_t bytes() const;
    /// At most, what its building takes for a while included.
    static uint64_t estimate_bytes(uint64_t lights);

private:
    struct Bins;
    std::unique_ptr<const Bins> bins_;
};

}  // namespace photond
