#pragma once
// Light paths' first step: a light by its power (and a few of the paths for each, however dim), a point and a direction
// on it, and the flux the photon carries,
//   dPhi = L_e cos / (p_l p_y p_w)            (methods.md, "Departures")
// All kinds of lights behind one call. Directional lights and the environment send photons from a disc of the bounding
// sphere's radius that faces their direction.

#include <memory>
#include <optional>
#include <span>

#include "renderer/core/geometry.h"
#include "renderer/core/rgb.h"
#include "renderer/transport/punctual.h"  // range_window()

namespace photond {

struct Scene;

class DiscreteDistribution;
class EnvironmentSampler;
struct LightTriangle;

/// The start of a light path.
struct EmissionSample {
    Ray ray;                    // moved off an emitting surface; unit direction
    Rgb power_w{0};             // flux [W] one path stands for if it were the only one: divide by the number of paths
    uint32_t light = 0;         // index as in EmissionSampler::probability()
    uint32_t source = 0;        // light_source_of_* in light_sampling.h
    float range_m = kInfinity;  // point and spot lights: what their `range` leaves at distance d is range_window()
};

/// What many samples are drawn by: arrays of uniform numbers in [0, 1), at least as long as the samples.
struct EmissionNumbers {
    std::span<const float> light, position_x, position_y, direction_x, direction_y;
};

/// Immutable and thread-safe; borrows the scene.
class EmissionSampler {
public:
    explicit EmissionSampler(const Scene& scene);
    ~EmissionSampler();
    EmissionSampler(EmissionSampler&&) noexcept;
    EmissionSampler& operator=(EmissionSampler&&) noexcept;

    /// Draws a light by its power, but for one of 16 paths that all sources share, whatever their power; then a point
    /// and a direction. All numbers uniform in [0, 1). False when the sample carries nothing (a black texel, a masked
    /// one): a light path without light, which counts as emitted.
    ///
    /// Triangles send cosine-distributed light from points uniform by area; a two-sided one by its front for the lower
    /// half of u_direction.x, by its back for the upper. Points use u_direction alone, evenly over the sphere, spots in
    /// proportion to their falloff, directional lights u_position alone, evenly over the disc.
    bool sample(float u_light, const vec2& u_position, const vec2& u_direction, EmissionSample& out) const;

    /// The same for many paths, vectorised where the lights' kinds allow: samples[i] is by the i-th numbers what
    /// sample() draws, but for rounding. Where that is false, power_w is 0 and nothing else is said.
    void sample(const EmissionNumbers& numbers, std::span<EmissionSample> samples) const;

    /// The same for one light whose choice has that probability (already divided by in power_w), > 0. False for a light
    /// that sample() never chooses.
    bool sample_light(uint32_t light, float probability, const vec2& u_position, const vec2& u_direction,
                      EmissionSample& out) const;

    /// The numbers by which sample_light() sends a path of that light through `point`: one that starts at the same
    /// place of a lamp as that of the numbers given, or comes from the same direction of the sky. False where there is
    /// none: behind the lamp, outside of a spot's cone, or where the light has no power. Exact but for rounding.
    bool aim(uint32_t light, const vec3& point, vec2& u_position, vec2& u_direction) const;

    uint32_t lights() const;                  // triangles, punctual lights, and the environment last
    float probability(uint32_t light) const;  // with which sample() chooses it: exact, a multiple of 2^-24
    /// Which of a light's two pairs of numbers decides what it sees most: directional lights are guided by the place on
    /// their disc, all others by the direction.
    bool guided_by_position(uint32_t light) const;

    // What it is made of, for the device's copy (light_tables.h).
    std::span<const LightTriangle> triangles() const;  // beside Scene::triangle_lights
    const DiscreteDistribution& choice() const;        // of the lights
    float disc_m2() const;                             // that light from outside starts on
    const EnvironmentSampler* environment() const;     // null without one

    /// Flux of all lights [W], mean over the channels; 0: the scene is dark, or empty. That of points and spots is
    /// without the window of their range; that of textured triangles and of the environment is good to a few percent.
    double total_power_w() const;

    uint64_t bytes() const;
    static uint64_t estimate_bytes(uint64_t lights, Size2 environment_size);

private:
    struct Lights;
    std::unique_ptr<const Lights> lights_;
};

/// Of a scene's lights; none where the scene has no light.
std::optional<EmissionSampler> emission_of(const Scene& scene);

}  // namespace photond
