// Shafts against shadow rays: what a shaft calls clear no ray may find blocked.

#include "renderer/transport/shaft_visibility.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <optional>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/discrete_distribution.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/surface.h"
#include "tests/support/scene_parts.h"

namespace photond::shaft_visibility_test {
namespace {

struct SurfacePoint {
    vec3 position, normal;
};

/// What lies off its surface towards `to`, as shadow rays begin.
vec3 off_surface(const SurfacePoint& point, const vec3& to) {
    const bool front = glm::dot(point.normal, to - point.position) > 0;
    return offset_ray_origin(point.position, front ? point.normal : -point.normal);
}

/// Where random rays of a scene begin and what they meet.
class Sampled {
public:
    explicit Sampled(Scene made)
        : scene(std::move(made)),
          shafts(scene),
          rounding_m(1e-5f * max_component(glm::max(glm::abs(scene.bounds.min), glm::abs(scene.bounds.max)))),
          random_(1, RandomDomain::Test, 0, 0) {
        MemoryBudget budget;
        Stats stats;
        intersector = make_embree_intersector(scene, budget, stats);
        std::vector<double> areas;
        for (uint32_t i = 0; i < scene.instances.size(); ++i)
            for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t) {
                triangles_.push_back(world_triangle(scene, i, t));
                const auto& p = triangles_.back().p;
                area_ += 0.5 * double{glm::length(glm::cross(p[1] - p[0], p[2] - p[0]))};
                areas_up_to_.push_back(area_);
            }
    }

    std::span<const TriangleCorners> triangles() const { return triangles_; }
    float next() { return random_.next(); }
    vec2 next_2d() { return random_.next_2d(); }

    /// On a surface, by area, on a random side.
    SurfacePoint surface_point() {
        const double at = double{next()} * area_;
        const auto found = std::upper_bound(areas_up_to_.begin(), areas_up_to_.end(), at);
        const size_t index = std::min(size_t(found - areas_up_to_.begin()), triangles_.size() - 1);
        const auto& p = triangles_[index].p;
        vec2 u = next_2d();
        if (u.x + u.y > 1) u = 1.0f - u;
        const vec3 normal = unit_cross(p[1] - p[0], p[2] - p[0]);
        return {(1 - u.x - u.y) * p[0] + u.x * p[1] + u.y * p[2], next() < 0.5f ? normal : -normal};
    }

    /// What a narrow bundle of rays from a random place meets, as pixels do: normals on the rays' side.
    std::vector<SurfacePoint> visible_points(float width) {
        const SurfacePoint eye = surface_point();
        const vec3 from = offset_ray_origin(eye.position, eye.normal);
        const Frame about(Frame(eye.normal).to_world(sample_cosine_hemisphere(next_2d())));
        std::vector<SurfacePoint> points;
        for (int i = 0; i < 24; ++i) {
            const vec2 across = width * (next_2d() - 0.5f);
            const vec3 w = glm::normalize(about.normal + across.x * about.tangent + across.y * about.bitangent);
            const Hit hit = intersector->closest_hit({from, w, kInfinity});
            if (!hit.valid()) continue;
            const ShadingPoint at = make_shading_point(scene, hit, w);
            points.push_back({at.position, at.geometric_normal});
        }
        return points;
    }

    /// Whether anything lies between, away from the ends. Rays of single precision may meet the surfaces they begin
    /// and end on where those lie far from the origin, which shadow_ray_blocked() tells as an obstacle.
    bool blocked_between(const SurfacePoint& apex, const SurfacePoint& point) const {
        const vec3 d = apex.position - point.position;
        const auto share = [&](const vec3& normal) {
            return std::min(8 * rounding_m / std::fabs(glm::dot(normal, d)), 0.5f);
        };
        const float begin = share(point.normal), end = 1 - share(apex.normal);
        return end > begin && intersector->occluded({point.position + begin * d, (end - begin) * d, 1});
    }

    /// Whether a shadow ray of photon splatting is blocked.
    bool shadow_ray_blocked(const SurfacePoint& apex, const SurfacePoint& point) const {
        const vec3 from = off_surface(point, apex.position);
        return intersector->occluded({from, offset_ray_origin(apex.position, apex.normal) - from, 1});
    }

    const Scene scene;
    const ShaftVisibility shafts;
    const float rounding_m;  // what lies less above a plane may as well lie below it, and gets next to no light
    std::unique_ptr<Intersector> intersector;

private:
    RandomStream random_;
    std::vector<TriangleCorners> triangles_;
    std::vector<double> areas_up_to_;
    double area_ = 0;
};

ShaftTarget target_of(std::span<const SurfacePoint> points) {
    Bounds3 box;
    dvec3 mean(0);
    bool flat = true;
    for (const SurfacePoint& point : points) {
        box.extend(point.position);
        mean += dvec3(point.position) / double(points.size());
        flat &= glm::distance(point.normal, points[0].normal) < 1e-6f;
    }
    for (const SurfacePoint& point : points)
        flat &= std::fabs(glm::dot(point.normal, point.position - vec3(mean))) <=
                1e-6f * max_component(glm::abs(point.position) + box.diagonal());
    const vec3 centre = flat ? vec3(mean) : box.centre();
    ShaftTarget target{centre, glm::max(box.max - centre, centre - box.min), 0, flat ? points[0].normal : vec3(0)};
    for (const SurfacePoint& point : points)
        target.radius_m = std::max(target.radius_m, 1.0001f * glm::distance(point.position, centre));
    return target;
}

struct Tally {
    uint64_t shafts = 0, known = 0, clear = 0, free = 0, flat = 0;  // clear: no blockers; free: no ray was blocked
    uint64_t rays = 0, blocked = 0;                                 // by Embree
    uint64_t by_blockers = 0, differing = 0;                        // of known shafts; in what they say
};

/// The rays from the points to the apex, against what is said of their shaft.
void compare_shaft(const Sampled& sampled, const SurfacePoint& apex, std::span<const SurfacePoint> points,
                   const ShaftBlockers& blockers, bool far_away, Tally& tally, const std::string& name) {
    const vec3 to = offset_ray_origin(apex.position, apex.normal);
    uint64_t rays = 0, blocked = 0;
    for (const SurfacePoint& point : points) {
        // Light that leaves above the apex's surface, and comes to the side that is seen.
        const vec3 d = point.position - apex.position;
        if (glm::dot(apex.normal, d) <= sampled.rounding_m || -glm::dot(point.normal, d) <= sampled.rounding_m)
            continue;
        ++rays;
        const bool ray_blocked =
            far_away ? sampled.blocked_between(apex, point) : sampled.shadow_ray_blocked(apex, point);
        blocked += ray_blocked;
        if (!blockers.known() || far_away) continue;  // there offset points do not lie off their surfaces
        const vec3 from = off_surface(point, apex.position);
        const bool cut =
            sampled.shafts.blocked(std::span(blockers.triangles).first(blockers.count), broadcast(from), to)[0];
        tally.by_blockers += cut;
        tally.differing += cut != ray_blocked;
    }
    if (rays == 0) return;
    if (blockers.count == 0) {
        EXPECT_EQ(blocked, 0u) << name << ", of " << rays << " rays";
    }
    ++tally.shafts;
    tally.known += blockers.known();
    tally.clear += blockers.count == 0;
    tally.free += blocked == 0;
    tally.rays += rays;
    tally.blocked += blocked;
}

/// Random apexes and targets; what the eye sees is found by rays as everywhere. Fails where a clear shaft has a blocked
/// ray, or known blockers say otherwise than rays but for a rare edge. Half of the points make a target within the
/// whole one.
Tally compare(Sampled& sampled, int count, const std::string& name, bool far_away = false) {
    Tally tally;
    for (int i = 0; i < count; ++i) {
        const SurfacePoint apex = sampled.surface_point();
        const float width = 0.4f * sampled.next() * sampled.next();
        const std::vector<SurfacePoint> points = sampled.visible_points(width);
        if (points.size() < 8) continue;
        const std::span<const SurfacePoint> part = std::span(points).first(points.size() / 2);
        const ShaftTarget target = target_of(points), within = target_of(part);
        const ShaftBlockers blockers = sampled.shafts.blockers(apex.position, apex.normal, target);
        tally.flat += target.flat();
        compare_shaft(sampled, apex, points, blockers, far_away, tally, name);
        compare_shaft(sampled, apex, part, sampled.shafts.blockers(apex.position, apex.normal, within, blockers),
                      far_away, tally, name + ", part of a target");
    }
    std::printf(
        "%s: %d shafts, %.3f known, of %d free ones %.3f clear; %d rays, %d blocked, %d by blockers; %d of "
        "them differ; %d flat\n",
        name.c_str(), int(tally.shafts), double(tally.known) / double(tally.shafts), int(tally.free),
        double(tally.clear) / double(tally.free), int(tally.rays), int(tally.blocked), int(tally.by_blockers),
        int(tally.differing), int(tally.flat));
    // Rays that pass an edge by the rounding of either test, or begin where two surfaces meet.
    EXPECT_LE(double(tally.differing), 2e-3 * double(tally.rays)) << name;
    return tally;
}

/// A room of 4 m with a partition of two sheets, `gap_m` apart and with a doorway, and a shelf as far above the floor.
Scene partitioned_room(float gap_m, const vec3& corner = vec3(0)) {
    Scene scene;
    const auto sheet = [&](MeshBuilder& builder, float x) {
        builder.quad({x, 0, 0}, {x, 3, 0}, {x, 3, 2.5f}, {x, 0, 2.5f});
    };
    MeshBuilder room, wall, shelf;
    const mat4 there = glm::translate(mat4(1), corner);
    room.place(there).box({0, 0, 0}, {4, 3, 4});
    wall.place(there);
    sheet(wall, 2), sheet(wall, 2 + gap_m);
    shelf.place(there).quad({0.5f, gap_m, 0.5f}, {0.5f, gap_m, 1.5f}, {1.5f, gap_m, 1.5f}, {1.5f, gap_m, 0.5f});
    test::add(scene, room.build(0), test::lambert(0.7f, 1));
    test::add(scene, wall.build(0), test::lambert(0.7f));
    test::add(scene, shelf.build(0), test::lambert(0.7f));
    finish_scene(scene);
    return scene;
}

TEST(ShaftVisibility, ClearShaftsHaveNoBlockedRay) {
    for (const char* name : {"cornell-box", "interior", "keyhole", "cornell-box-glass", "caustic-ring"}) {
        Sampled sampled(make_builtin_scene(name));
        const Tally tally = compare(sampled, 2000, name);
        EXPECT_GT(tally.clear, 30u) << name;
        EXPECT_GT(tally.blocked, 300u) << name << ": nothing that could have been wrong";
    }
}

TEST(ShaftVisibility, ThinWallsAndSurfacesThatNearlyTouchAreSeen) {
    for (const float gap_m : {0.1f, 1e-2f, 1e-3f, 1e-4f}) {
        Sampled sampled(partitioned_room(gap_m));
        const Tally tally = compare(sampled, 1500, "gap " + std::to_string(gap_m));
        EXPECT_GT(tally.clear, 50u);
        EXPECT_GT(tally.blocked, 1000u);
    }
}

TEST(ShaftVisibility, ScenesFarFromTheOriginHaveTheSameAnswer) {
    for (const float distance_m : {100.0f, 3000.0f}) {
        Sampled sampled(partitioned_room(0.05f, vec3(distance_m, 0, -distance_m)));
        const Tally tally = compare(sampled, 1500, "at " + std::to_string(distance_m), true);
        EXPECT_GT(tally.clear, 50u);
        EXPECT_GT(tally.blocked, 1000u);
    }
}

// What is free is mostly said to be: in the Cornell box two thirds of the connections need no shadow ray.
TEST(ShaftVisibility, MostFreeShaftsOfTheCornellBoxAreClear) {
    Sampled sampled(make_builtin_scene("cornell-box"));
    const Tally tally = compare(sampled, 3000, "cornell-box");
    EXPECT_GT(double(tally.clear), 0.6 * double(tally.free));
}

TEST(ShaftVisibility, AnApexWithinItsTargetKnowsNothing) {
    const Sampled sampled(make_builtin_scene("cornell-box"));
    const ShaftTarget target{sampled.scene.bounds.centre(), vec3(0.1f), 0.17f, vec3(0)};
    EXPECT_FALSE(sampled.shafts.blockers(target.centre, vec3(0, 1, 0), target).known());
    EXPECT_FALSE(sampled.shafts.blockers(target.centre + vec3(0.1f, 0, 0), vec3(0, 1, 0), target).known());
}

TEST(ShaftVisibility, MaskedSurfacesAreLeftToRays) {
    Scene scene = partitioned_room(0.1f);
    const ShaftTarget target{vec3(1, 0, 1), vec3(0.1f, 0, 0.1f), 0.15f, vec3(0, 1, 0)};
    const vec3 apex(3, 1, 1), normal(-1, 0, 0);  // beyond the partition
    EXPECT_TRUE(ShaftVisibility(scene).blockers(apex, normal, target).known());
    EXPECT_GT(ShaftVisibility(scene).blockers(apex, normal, target).count, 0u);
    scene.materials[1].alpha = 0.5f;
    scene.materials[1].alpha_mode = AlphaMode::Blend;
    finish_scene(scene);
    EXPECT_FALSE(ShaftVisibility(scene).blockers(apex, normal, target).known());
}

TEST(ShaftVisibility, AnEmptySceneIsClear) {
    Scene scene;
    finish_scene(scene);
    const ShaftVisibility shafts(scene);
    const ShaftTarget target{vec3(1, 2, 3), vec3(0.1f), 0.17f, vec3(0)};
    EXPECT_EQ(shafts.blockers(vec3(0), vec3(0, 1, 0), target).count, 0u);
    EXPECT_FALSE(shafts.near_above(target, 1, target.centre, vec3(0, 1, 0)));
}

// The size of the scene does not change what may be said of its memory beforehand.
TEST(ShaftVisibility, MemoryIsEstimated) {
    for (const char* name : {"cornell-box", "interior", "caustic-ring"}) {
        const Scene scene = make_builtin_scene(name);
        const ShaftVisibility shafts(scene);
        const auto estimate = double(ShaftVisibility::estimate_bytes(scene.triangle_count));
        EXPECT_GE(estimate * 1.05, double(shafts.bytes())) << name;
        EXPECT_LE(estimate, 1.5 * double(shafts.bytes()) + 4096) << name;
    }
    EXPECT_EQ(ShaftVisibility::estimate_bytes(ShaftVisibility::kMostTriangles + 1), 0u);
}

// Short rays upwards from the target's points meet nothing, and no corner of a triangle lies there, where nothing is
// said to be near.
TEST(ShaftVisibility, WhateverIsNearAboveIsFound) {
    for (const char* name : {"cornell-box", "interior", "keyhole"}) {
        Sampled sampled(make_builtin_scene(name));
        const float scene_radius_m = sampled.scene.bounds.radius();
        uint64_t asked = 0, nothing_near = 0, met = 0;
        for (int i = 0; i < 1500; ++i) {
            const std::vector<SurfacePoint> points = sampled.visible_points(0.2f * sampled.next());
            if (points.size() < 8) continue;
            const ShaftTarget target = target_of(points);
            if (!target.flat()) continue;
            const float reach_m = scene_radius_m * 0.2f * sampled.next() * sampled.next();
            const bool near = sampled.shafts.near_above(target, reach_m, target.centre, target.normal);
            ++asked;
            nothing_near += !near;
            const Frame frame(target.normal);
            bool hit = false;
            for (const SurfacePoint& point : points)
                for (int ray = 0; ray < 4; ++ray)
                    hit |= sampled.intersector->occluded({offset_ray_origin(point.position, target.normal),
                                                          frame.to_world(sample_cosine_hemisphere(sampled.next_2d())),
                                                          reach_m});
            const float above_m = 1e-4f * scene_radius_m;
            for (const TriangleCorners& triangle : sampled.triangles())
                for (const vec3& p : triangle.p)
                    hit |= glm::dot(target.normal, p - target.centre) > above_m &&
                           glm::distance(p, points[0].position) < reach_m;
            met += hit;
            if (!near) {
                EXPECT_FALSE(hit) << name << ", target " << i;
            }
        }
        std::printf("%s: of %d targets %d have nothing near, %d have something\n", name, int(asked), int(nothing_near),
                    int(met));
        EXPECT_GT(nothing_near, 50u) << name;
        EXPECT_GT(met, 50u) << name;
    }
}

}  // namespace
}  // namespace photond::shaft_visibility_test
