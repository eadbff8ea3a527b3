#include "renderer/scene/inside_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr uint64_t kMostTriangles = 500'000;
constexpr size_t kMostLamps = 8, kRaysOfLamp = 32;
constexpr size_t kClosedOneIn = 50;                   // rays, of which one may leave
constexpr size_t kAcross = 4, kUp = 3, kAround = 16;  // places to stand, and ways to look
constexpr size_t kRaysOfPlace = 12;
constexpr float kSkinShare = 1e-4f;  // of the scene's radius: nearer than that a ray meets nothing
constexpr float kBack = 0.85f;       // of the way back to the wall
constexpr float kYfov = 0.9f;

struct FlatTriangle {
    vec3 corner, edge_1, edge_2;
};

bool stops_light(const Material& material) {
    return material.alpha_mode == AlphaMode::Opaque && !(material.transmission > 0);
}

/// All triangles that stop light, to be asked one after the other: the few rays there are do not pay for a structure.
class Walls {
public:
    explicit Walls(const Scene& scene) : skin_m_(kSkinShare * scene.bounds.radius()) {
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
            if (!stops_light(scene.materials[mesh.material])) continue;
            for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                const auto& p = world_triangle(scene, i, t).p;
                triangles_.push_back({p[0], p[1] - p[0], p[2] - p[0]});
            }
        }
    }

    /// Distance to the nearest in units of `direction`; infinite: none [Möller and Trumbore 1997].
    float distance(const vec3& origin, const vec3& direction) const {
        constexpr float kEdge = 1e-5f;  // beyond a triangle's edge that still counts: no ray slips through between two
        const float least = skin_m_ / glm::length(direction);
        float nearest = kInfinity;
        for (const FlatTriangle& triangle : triangles_) {
            const vec3 across = glm::cross(direction, triangle.edge_2);
            const float determinant = glm::dot(triangle.edge_1, across);
            if (determinant == 0) continue;
            const float inverse = 1 / determinant;
            const vec3 from = origin - triangle.corner;
            const float u = inverse * glm::dot(from, across);
            if (!(u >= -kEdge && u <= 1 + kEdge)) continue;
            const vec3 along = glm::cross(from, triangle.edge_1);
            const float v = inverse * glm::dot(direction, along);
            if (!(v >= -kEdge && u + v <= 1 + kEdge)) continue;
            const float t = inverse * glm::dot(triangle.edge_2, along);
            if (t > least && t < nearest) nearest = t;
        }
        return nearest;
    }
    bool sees(const vec3& a, const vec3& b) const { return !(distance(a, b - a) < 1 - 1e-3f); }

private:
    const float skin_m_;
    std::vector<FlatTriangle> triangles_;
};

/// Directions spread evenly over the sphere: Fibonacci's spiral.
vec3 spread_direction(size_t i, size_t count) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(count);
    const float angle = static_cast<float>(i) * std::numbers::pi_v<float> * (3 - std::sqrt(5.0f));
    const float radius = std::sqrt(std::max(0.0f, 1 - z * z));
    return {radius * std::cos(angle), z, radius * std::sin(angle)};
}

struct Lamp {
    vec3 position;
    vec3 front{0};  // 0: it shines all around
};

/// Some of the scene's lamps, spread over all there are.
std::vector<Lamp> some_lamps(const Scene& scene) {
    std::vector<Lamp> lamps;
    for (const PunctualLight& light : scene.punctual_lights) lamps.push_back({light.position});
    for (const TriangleLight& light : scene.triangle_lights) {
        const auto& p = world_triangle(scene, light.instance, light.triangle).p;
        const float side = scene.instances[light.instance].flips_orientation ? -1.0f : 1.0f;
        lamps.push_back({(p[0] + p[1] + p[2]) / 3.0f,
                         light.two_sided ? vec3(0) : side * glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]))});
    }
    const size_t all = lamps.size(), some = std::min(all, kMostLamps);
    for (size_t i = 0; i < some; ++i) lamps[i] = lamps[i * all / some];
    lamps.resize(some);
    return lamps;
}

bool is_closed_about(const Walls& walls, const std::vector<Lamp>& lamps) {
    const size_t rays = lamps.size() * kRaysOfLamp;
    std::vector<uint8_t> leaves(rays);
    parallel_for(rays, 1, [&](size_t i) {
        const Lamp& lamp = lamps[i / kRaysOfLamp];
        vec3 direction = spread_direction(i % kRaysOfLamp, kRaysOfLamp);
        if (glm::dot(direction, lamp.front) < 0) direction = -direction;
        leaves[i] = std::isfinite(walls.distance(lamp.position, direction)) ? 0 : 1;
    });
    return static_cast<size_t>(std::count(leaves.begin(), leaves.end(), 1)) * kClosedOneIn < rays;
}

/// The place within from which it is farthest to what is about it, in the median; of those that see a lamp, if any
/// does.
std::optional<vec3> most_open_place(const Scene& scene, const Walls& walls, const std::vector<Lamp>& lamps) {
    constexpr size_t kPlaces = kAcross * kUp * kAcross;
    std::array<vec3, kPlaces> places;
    std::array<std::pair<bool, float>, kPlaces> open;  // sees a lamp, median distance
    parallel_for(kPlaces, 1, [&](size_t i) {
        const vec3 share =
            (vec3(i % kAcross, i / kAcross % kUp, i / (kAcross * kUp)) + 0.5f) / vec3(kAcross, kUp, kAcross);
        places[i] = glm::mix(scene.bounds.min, scene.bounds.max, share);
        std::array<float, kRaysOfPlace> far;
        for (size_t ray = 0; ray < far.size(); ++ray)
            far[ray] = walls.distance(places[i], spread_direction(ray, far.size()));
        std::ranges::sort(far);
        if (!std::isfinite(far.back())) {
            open[i] = {false, 0.0f};
            return;
        }
        const bool lit =
            std::ranges::any_of(lamps, [&](const Lamp& lamp) { return walls.sees(places[i], lamp.position); });
        open[i] = {lit, far[far.size() / 2]};
    });
    const auto best = std::ranges::max_element(open);
    if (!(best->second > 0)) return std::nullopt;
    return places[static_cast<size_t>(best - open.begin())];
}

}  // namespace

std::optional<Camera> find_inside_view(const Scene& scene) {
    const bool from_without = std::ranges::any_of(scene.punctual_lights, [](const PunctualLight& light) {
        return light.kind == PunctualLight::Kind::Directional;
    });
    if (scene.environment || from_without || scene.triangle_count > kMostTriangles || !(scene.bounds.radius() > 0))
        return std::nullopt;
    const std::vector<Lamp> lamps = some_lamps(scene);
    if (lamps.empty()) return std::nullopt;
    const Walls walls(scene);
    if (!is_closed_about(walls, lamps)) return std::nullopt;
    const std::optional<vec3> place = most_open_place(scene, walls, lamps);
    if (!place) return std::nullopt;
    const auto way = [](size_t i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kAround;
        return vec3(std::cos(angle), 0, std::sin(angle));
    };
    std::array<float, kAround> far;
    parallel_for(kAround, 1, [&](size_t i) { far[i] = walls.distance(*place, way(i)); });
    const auto longest = std::ranges::max_element(far);
    if (!std::isfinite(*longest)) return std::nullopt;
    const vec3 back = *longest * way(static_cast<size_t>(longest - far.begin()));
    return look_at_camera(dvec3(*place + kBack * back), dvec3(*place - back), dvec3(0, 1, 0), kYfov);
}

}  // namespace photond
