#pragma once
// Sampling of direct light: which light, which point or direction on it, and with what density. All kinds of lights
// behind one call. Densities are in solid angle at the point that is lit and hold the choice of the light, so that they
// weigh against a BSDF's by multiple importance sampling as they stand.

#include <memory>
#include <span>

#include "renderer/scene/scene.h"

namespace photond {

class EnvironmentSampler;
enum class EnvironmentDensity : uint8_t;
class LightTree;
struct Emitter;

/// One direction towards a light, before it is known whether anything is in between.
struct LightSample {
    vec3 wi;                     // unit, from the lit point to the light
    float distance = kInfinity;  // [m]; infinite for directional lights and the environment
    vec3 target;                 // end of the shadow ray where the distance is finite, just before the light's surface
    Rgb radiance_over_pdf;   // [W m^-2]: estimate of L / pdf_sa; delta lights: perpendicular irradiance / probability
    float pdf_sa = 0;        // [1/sr], choice of light included; delta lights: probability of the choice alone
    bool delta = false;      // no other technique finds this light: its MIS weight is 1
    uint32_t source = 0;     // what casts one shadow: see light_source_of_* below
    uint32_t emitter = ~0u;  // of LightSampler::emitters(), where it is one of those

    /// The ray that must not be occluded. `origin`: the lit point, moved off its surface (offset_ray_origin).
    Ray shadow_ray(const vec3& origin) const {
        const bool finite = distance < kInfinity;
        return {origin, finite ? target - origin : wi, finite ? 1.0f : kInfinity};
    }
};

/// Numbers of what casts one shadow: the emitting triangles of an instance together, each punctual light, the
/// environment.
inline uint32_t light_source_of_instance(uint32_t instance) { return instance; }
inline uint32_t light_source_of_punctual(const Scene& scene, uint32_t light) {
    return static_cast<uint32_t>(scene.instances.size()) + light;
}
inline uint32_t light_source_of_environment(const Scene& scene) {
    return static_cast<uint32_t>(scene.instances.size() + scene.punctual_lights.size());
}

/// Samples the lights of a finished scene. Immutable and thread-safe; borrows the scene.
///
/// Arguments common to all calls: `p` the lit point (world), `n` a unit normal such that nothing arriving from
/// directions with dot(n, wi) <= 0 counts, or zero when light from everywhere counts (glass, thin sheets). The same p
/// and n must be given to sample() and to the pdf it is weighed against.
///
/// Triangles that emit, points and spots are chosen through a light tree, directional lights and the environment beside
/// it by the irradiance they could bring to p.
class LightSampler {
public:
    /// By radiance, unless every sample's contribution is weighed as EnvironmentDensity::Compensated asks.
    explicit LightSampler(const Scene& scene);
    LightSampler(const Scene& scene, EnvironmentDensity environment);
    ~LightSampler();
    LightSampler(LightSampler&&) noexcept;

    /// Draws one light and a direction to it. `u_select` and `u` uniform in [0,1). False when the sample carries
    /// nothing (no light reaches p, the point drawn faces away, its texel is black): the estimate is then zero.
    bool sample(const vec3& p, const vec3& n, float u_select, const vec2& u, LightSample& out) const;

    /// Density [1/sr] with which sample() draws the direction `wi` (unit) that meets this triangle at `distance`; 0
    /// when the triangle is no light.
    float pdf_triangle(const vec3& p, const vec3& n, uint32_t instance, uint32_t triangle, const vec3& wi,
                       float distance) const;
    /// Density [1/sr] with which sample() draws `wi` (unit) from the environment; 0 without one.
    float pdf_environment(const vec3& p, const vec3& n, const vec3& wi) const;
    /// Probability with which sample() chooses that punctual light.
    float probability_punctual(const vec3& p, const vec3& n, uint32_t light) const;

    /// What arrives from outside the scene along -wi [W m^-2 sr^-1]; black without an environment.
    Rgb environment_radiance(const vec3& wi) const;

    // What it is made of, for the device's copy (light_tables.h).
    std::span<const Emitter> emitters() const;
    const LightTree& tree() const;                  // over the emitters
    std::span<const uint32_t> directional() const;  // indices of punctual lights
    const EnvironmentSampler* environment() const;  // null without one
    /// Which emitter a triangle belongs to: emitter_of_triangle()[first_of_instance()[i] + t]; kNoEmitter in either: to
    /// none. Both empty where no triangle emits.
    std::span<const uint32_t> first_of_instance() const;
    std::span<const uint32_t> emitter_of_triangle() const;
    /// kNoEmitter where the triangle is no light.
    uint32_t emitter_of(uint32_t instance, uint32_t triangle) const;

    /// Whether the scene has no light that sample() could draw.
    bool empty() const;
    uint64_t bytes() const;
    /// bytes() of a sampler for that many lights and an environment of that size (0 x 0: none), to a few percent.
    static uint64_t estimate_bytes(uint64_t lights, Size2 environment_size);

private:
    struct Lights;
    std::unique_ptr<const Lights> lights_;
};

}  // namespace photond
