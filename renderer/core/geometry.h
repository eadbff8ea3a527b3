#pragma once
// Vectors, rays, frames and boxes. The vector types are GLM's, whose names and meaning are GLSL's.

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

namespace photond {

using glm::dmat4;
using glm::dvec3;
using glm::mat3;
using glm::mat4;
using glm::mat4x3;
using glm::u8vec4;
using glm::uvec2;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 0.31830988618379067154f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Size2 {
    uint32_t width = 0;
    uint32_t height = 0;
    size_t pixels() const { return size_t{width} * height; }
    bool operator==(const Size2&) const = default;
};

struct Ray {
    vec3 origin;
    vec3 direction;  // unit length unless the user says so
    float t_max = kInfinity;
};

struct Bounds3 {
    vec3 min{kInfinity};
    vec3 max{-kInfinity};

    bool empty() const { return !(min.x <= max.x); }
    void extend(const vec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
    void extend(const Bounds3& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
    vec3 centre() const { return 0.5f * (min + max); }
    vec3 diagonal() const { return max - min; }
    /// Radius of the sphere about the centre that holds the box; 0 when empty.
    float radius() const { return empty() ? 0.0f : 0.5f * glm::length(diagonal()); }
};

inline float sqr(float x) { return x * x; }

/// An orthonormal frame about a unit normal, without branches on its direction.
/// [Duff et al. 2017] Building an Orthonormal Basis, Revisited. JCGT 6(1).
struct Frame {
    vec3 tangent;
    vec3 bitangent;
    vec3 normal;

    explicit Frame(const vec3& n) : normal(n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1.0f / (sign + n.z);
        const float b = n.x * n.y * a;
        tangent = vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
        bitangent = vec3(b, sign + n.y * n.y * a, -n.y);
    }
    vec3 to_local(const vec3& w) const { return {glm::dot(w, tangent), glm::dot(w, bitangent), glm::dot(w, normal)}; }
    vec3 to_world(const vec3& w) const { return w.x * tangent + w.y * bitangent + w.z * normal; }
};

/// The point to start a ray from so that it does not meet the surface it leaves: `p` moved along `n` (unit, towards the
/// side the ray leaves to) by an amount scaled with the coordinates' own floating-point spacing.
/// [Waechter and Binder 2019] A Fast and Robust Method for Avoiding Self-Intersection. Ray Tracing Gems, ch. 6.
inline vec3 offset_ray_origin(const vec3& p, const vec3& n) {
    constexpr float kOrigin = 1.0f / 32.0f, kFloatScale = 1.0f / 65536.0f, kIntScale = 256.0f;
    vec3 moved;
    for (int i = 0; i < 3; ++i) {
        const int offset = static_cast<int>(kIntScale * n[i]);
        int bits;
        static_assert(sizeof(bits) == sizeof(float));
        __builtin_memcpy(&bits, &p[i], sizeof bits);
        bits += p[i] < 0 ? -offset : offset;
        float shifted;
        __builtin_memcpy(&shifted, &bits, sizeof shifted);
        moved[i] = std::fabs(p[i]) < kOrigin ? p[i] + kFloatScale * n[i] : shifted;
    }
    return moved;
}

}  // namespace photond
