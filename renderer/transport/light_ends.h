#pragma once
// Densities of a light's points and directions by both samplers: the one that lights a point from them
// (light_sampling.h) and the one that starts light paths there (emission_sampling.h). For methods that weigh the two.

#include <span>
#include <vector>

#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/light_sampling.h"

namespace photond {

/// Of one point or direction of a light. `direct`: by LightSampler at the point it lights, choice of the light
/// included: [1/m^2]; infinite: [1/sr]; delta: a probability. `emission`: as a light path's start, choice included:
/// [1/(m^2 sr)]; points and spots [1/sr]; directional [1/m^2].
template <class Real>
struct BasicLightEnd {
    Real direct = 0;
    Real emission = 0;
    Real cosine = 1;  // between the direction and the light's normal; 1 where it has none
    bool delta = false;
    bool infinite = false;  // environment, directional lights
};
using LightEnd = BasicLightEnd<float>;

/// Immutable and thread-safe; borrows scene and samplers. Points lit: `p` and `n` as LightSampler has them. 0 for both
/// densities where the light does not shine.
class LightEnds {
public:
    LightEnds(const Scene& scene, const LightSampler& lights, const EmissionSampler& emission);

    /// A triangle that was met from p along `wi` (unit) at that distance, or that is to be drawn there.
    LightEnd on_triangle(const vec3& p, const vec3& n, uint32_t instance, uint32_t triangle, const vec3& wi,
                         float distance) const;
    LightEnd of_environment(const vec3& p, const vec3& n, const vec3& wi) const;
    /// Of what LightSampler drew. Its own density, over solid angle at p as weights of next-event estimation want
    /// it (mis_weights.h), goes to `pdf_direct_sa`.
    LightEnd of_sample(const LightSample& sample, float& pdf_direct_sa) const;
    /// Of what EmissionSampler drew; `direct` is still to be asked for.
    LightEnd of_emission(const EmissionSample& sample) const;
    /// ... at the path's first hit, which is p.
    float direct_at_first_hit(const EmissionSample& sample, const vec3& p, const vec3& n, float distance) const;

    /// By emitter: with which light paths start there [1/m^2]; of two-sided ones either side's.
    std::span<const float> emission_per_m2() const { return emission_per_m2_; }

    uint64_t bytes() const { return emission_per_m2_.capacity() * sizeof(float); }

private:
    float emitted_by_cosine(uint32_t emitter, float cosine) const;
    float emission_punctual(uint32_t punctual, const vec3& direction) const;
    float emission_environment(const vec3& wi) const;

    const Scene& scene_;
    const LightSampler& lights_;
    const EmissionSampler& emission_;
    uint32_t triangles_;  // lights of the emission before the punctual ones
    std::vector<float> emission_per_m2_;
};

}  // namespace photond
