// Solids of glass that share a face are made to overlap; nothing else is.

#include "renderer/scene/touching_solids.h"

#include <gtest/gtest.h>

#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/scene.h"

namespace photond::touching_solids_test {
namespace {

Material glass() {
    Material material;
    material.metallic = 0, material.transmission = 1, material.solid = true;
    return material;
}

Scene scene_of(std::vector<Mesh> meshes, const Material& material = glass()) {
    Scene scene;
    scene.materials.push_back(material);
    scene.meshes = std::move(meshes);
    scene.instances.resize(scene.meshes.size());
    for (uint32_t i = 0; i < scene.instances.size(); ++i) scene.instances[i].mesh = i;
    return scene;
}

Mesh box(const vec3& min, const vec3& max) { return MeshBuilder().box(min, max).build(0); }

/// A box whose upper face is cut otherwise: into 3 x 3 cells, and by the other diagonal.
Mesh box_with_fine_top(const vec3& min, const vec3& max) {
    MeshBuilder builder;
    Mesh plain = box(min, max);
    for (const uvec3& t : plain.triangles) {
        const vec3 a = plain.positions[t.x], b = plain.positions[t.y], c = plain.positions[t.z];
        if (a.y < max.y || b.y < max.y || c.y < max.y) builder.triangle(a, b, c);
    }
    const auto corner = [&](int i, int k) {
        return vec3(min.x + static_cast<float>(i) / 3 * (max.x - min.x), max.y,
                    min.z + static_cast<float>(k) / 3 * (max.z - min.z));
    };
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            builder.quad(corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k), corner(i, k));
    return builder.build(0);
}

Bounds3 bounds_of(const Scene& scene, uint32_t instance) {
    const Instance& placed = scene.instances[instance];
    Bounds3 bounds;
    for (const vec3& p : scene.meshes[placed.mesh].positions)
        bounds.extend(placed.identity ? p : placed.to_world * vec4(p, 1));
    return bounds;
}

/// Rays start at most so far off at points within a metre of the origin.
constexpr float kOffset = 1.0f / 32768;

TEST(TouchingSolids, AFaceOfOneIsMovedIntoTheOtherAndStaysWithinItsSides) {
    const vec3 low(-0.5f, -0.5f, -0.5f), high(0.5f, 0.5f, 0.5f);
    for (const bool fine : {false, true}) {
        const Mesh below = fine ? box_with_fine_top(low, {0.5f, 0, 0.5f}) : box(low, {0.5f, 0, 0.5f});
        Scene scene = scene_of({below, box({-0.5f, 0, -0.5f}, high)});
        EXPECT_EQ(overlap_touching_solids(scene), 1u);
        const Bounds3 lower = bounds_of(scene, 0), upper = bounds_of(scene, 1);
        EXPECT_EQ(lower.max.y, 0);
        EXPECT_LT(upper.min.y, -2 * kOffset * 0.5f);
        EXPECT_GT(upper.min.y, -8 * kOffset);
        EXPECT_EQ(upper.max, high);
        for (const vec3& p : scene.meshes[1].positions)
            if (p.y < 0) {
                EXPECT_LT(std::fabs(p.x), 0.5f) << "it tapers";
                EXPECT_GT(std::fabs(p.x), 0.5f - 8 * kOffset);
            }
        EXPECT_EQ(overlap_touching_solids(scene), 0u) << "they overlap already";
    }
}

TEST(TouchingSolids, ATransformIsUndone) {
    Scene scene = scene_of({box({-1, -1, -1}, {1, 0, 1}), box({0, 0, 0}, {1, 1, 1})});
    Instance& placed = scene.instances[1];
    placed.identity = false;
    placed.to_world = mat4x3(vec3(0, 0, -0.5f), vec3(0, 0.25f, 0), vec3(-0.5f, 0, 0), vec3(0.2f, 0, 0.3f));
    placed.flips_orientation = true;
    EXPECT_EQ(overlap_touching_solids(scene), 1u);
    const Bounds3 moved = bounds_of(scene, 1);
    EXPECT_LT(moved.min.y, -2 * kOffset * 0.25f);
    EXPECT_GT(moved.min.y, -8 * kOffset);
    EXPECT_FLOAT_EQ(moved.max.y, 0.25f);
}

TEST(TouchingSolids, WhatDoesNotTouchStaysAsItIs) {
    const Mesh block = box({-0.5f, -0.5f, -0.5f}, {0.5f, 0, 0.5f});
    const Mesh others[] = {
        box({-0.5f, 0.001f, -0.5f}, {0.5f, 0.5f, 0.5f}),  // a gap of a millimetre
        box({0.5f, 0, -0.5f}, {1, 0.5f, 0.5f}),           // an edge in common
        box({-0.2f, -0.3f, -0.2f}, {0.2f, -0.1f, 0.2f}),  // within
        box({-0.5f, -0.5f, -0.5f}, {0.5f, 0, 0.5f}),      // the same once more: faces that look the same way
    };
    for (const Mesh& other : others) {
        Scene scene = scene_of({block, other});
        EXPECT_EQ(overlap_touching_solids(scene), 0u) << other.positions[0].x;
        EXPECT_EQ(scene.meshes[1].positions, other.positions);
    }
    Material sheet = glass();
    sheet.solid = false;
    Scene scene = scene_of({block, box({-0.5f, 0, -0.5f}, {0.5f, 0.5f, 0.5f})}, sheet);
    EXPECT_EQ(overlap_touching_solids(scene), 0u) << "thin sheets have no inside";
}

TEST(TouchingSolids, RoughOnesNeedTheWayStraightThrough) {
    // Where one lies within another, a back bends nothing, and what bends nothing is a delta.
    Material rough = glass();
    rough.roughness = 0.5f;
    for (const bool both : {false, true}) {
        Scene scene = scene_of({box({-0.5f, -0.5f, -0.5f}, {0.5f, 0, 0.5f})}, rough);
        if (both) scene = scene_of({scene.meshes[0], box({-0.5f, 0, -0.5f}, {0.5f, 0.5f, 0.5f})}, rough);
        finish_scene(scene);
        EXPECT_EQ(scene.needs.delta, both);
    }
}

TEST(TouchingSolids, OfAMeshPlacedOftenItsNeighbourMoves) {
    const Mesh small = box({0, 0, 0}, {0.5f, 0.5f, 0.5f});
    Scene scene = scene_of({box({-1, -1, -1}, {2, 0, 2}), small});
    scene.instances.push_back(scene.instances[1]);
    scene.instances.back().identity = false;
    scene.instances.back().to_world[3] = vec3(1, 0, 0);
    Scene alone = scene;
    EXPECT_EQ(overlap_touching_solids(scene), 1u);
    EXPECT_EQ(scene.meshes[1].positions, small.positions);
    EXPECT_GT(bounds_of(scene, 0).max.y, 0);
    EXPECT_TRUE(scene.warnings.empty());

    // Two placings that touch one another cannot be told apart.
    alone.instances.erase(alone.instances.begin());
    alone.instances.back().to_world[3] = vec3(0.5f, 0, 0);
    EXPECT_EQ(overlap_touching_solids(alone), 0u);
    ASSERT_EQ(alone.warnings.size(), 1u);
    EXPECT_NE(alone.warnings[0].find("1 pairs"), std::string::npos) << alone.warnings[0];
}

}  // namespace
}  // namespace photond::touching_solids_test
