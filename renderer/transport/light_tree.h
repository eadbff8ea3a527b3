#pragma once
// A tree over lights of finite position, from which one is drawn with a probability that follows what it can bring to a
// point.
// [Conty Estevez and Kulla 2018] Importance Sampling of Many Lights with Adaptive Tree Splitting. Proc. ACM Comput.
// Graph. Interact. Tech. 1(2); the importance without trigonometry is that of [Pharr, Jakob, Humphreys 2023] Physically
// Based Rendering, 4th ed., sec. 12.6.3.

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// What the tree knows of one light, or of several together.
struct LightBounds {
    Bounds3 bounds;            // positions light leaves from
    vec3 axis{0, 0, 1};        // of the cone that holds all normals; unit
    float cone_angle = 0;      // half-angle of that cone [rad]
    float emission_angle = 0;  // light leaves within this angle of a normal [rad]
    float intensity = 0;       // mean over channels of the greatest radiant intensity [W sr^-1]
    bool two_sided = false;    // emits to both sides of its normals
};

class LightTree {
public:
    LightTree() = default;
    /// Lights without intensity are never drawn.
    explicit LightTree(std::span<const LightBounds> lights);

    bool empty() const { return nodes_.empty(); }

    struct Choice {
        uint32_t light;
        float probability;  // > 0
        float u;            // what is left of the number that chose, uniform in [0, 1) again
    };
    /// Draws a light for point p and normal n (see LightSampler); false when none can reach it.
    bool sample(const vec3& p, const vec3& n, float u, Choice& choice) const;
    /// Probability with which sample() draws that light.
    float probability(const vec3& p, const vec3& n, uint32_t light) const;

    /// Bound-like estimate of the irradiance all lights together bring to p [W m^-2], mean over channels; 0 only where
    /// none can.
    float irradiance_estimate(const vec3& p, const vec3& n) const;

    // The left child follows its parent, so that one line of the cache often holds both.
    struct alignas(64) Node {
        vec3 centre;
        float radius;  // of the sphere about the box
        vec3 axis;
        float cos_cone, sin_cone;
        float cos_emission;
        float intensity;
        uint32_t right_or_light;  // the right child, or the light of a leaf
        bool leaf;
        bool two_sided;
    };
    struct Leaf {
        uint64_t path = 0;  // bit d: at depth d the way to the light goes right
        uint8_t depth = kNoLeaf;
    };
    static constexpr uint8_t kNoLeaf = 0xff;
    static constexpr uint32_t kMostLevels = 56;  // no path is longer

    std::span<const Node> nodes() const { return nodes_; }     // [0] is the root
    std::span<const Leaf> leaves() const { return leaf_of_; }  // of every light

    uint64_t bytes() const { return nodes_.capacity() * sizeof(Node) + leaf_of_.capacity() * sizeof(Leaf); }

private:
    static float importance(const Node& node, const vec3& p, const vec3& n);
    static float share_of_left(float left, float right);
    struct Builder;

    std::vector<Node> nodes_;
    std::vector<Leaf> leaf_of_;
};

}  // namespace photond
