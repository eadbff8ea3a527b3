// Depth maps of splats: planes at any incidence, shadows, corners, resolution, and single rays as the oracle.

#include "renderer/methods/photon_splatting/splat_depth_maps.h"

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/scene_parts.h"

namespace photond::splat_depth_maps_test {
namespace {

/// Surfaces put together, and the maps of splats among them.
class SplatScene {
public:
    void quad(const vec3& a, const vec3& b, const vec3& c, const vec3& d) { shapes_.quad(a, b, c, d); }
    void box(const vec3& min, const vec3& max) { shapes_.box(min, max); }
    /// A square plate of that half side about `centre`, across `normal`.
    void plate(const vec3& centre, const vec3& normal, float half_side_m) {
        const Frame frame(normal);
        const vec3 s = half_side_m * frame.tangent, t = half_side_m * frame.bitangent;
        quad(centre - s - t, centre + s - t, centre + s + t, centre - s + t);
    }
    void finish() {
        test::add(scene_, shapes_.build(0), test::lambert(0.5f));
        finish_scene(scene_);
        MemoryBudget budget;
        Stats stats;
        intersector_ = make_embree_intersector(scene_, budget, stats);
    }
    SplatDepthMaps trace(std::span<const SplatFrustum> frusta, uint32_t resolution) const {
        SplatDepthMaps maps(resolution);
        Counts counts;
        maps.trace(frusta, *intersector_, counts);
        EXPECT_EQ(counts.shadow_rays, frusta.size() * resolution * resolution);
        return maps;
    }
    const Intersector& intersector() const { return *intersector_; }

private:
    Scene scene_;
    MeshBuilder shapes_;
    std::unique_ptr<Intersector> intersector_;
};

/// Whether the point is lit; nothing where it lies outside the frustum.
std::optional<bool> lit(const SplatDepthMaps& maps, const SplatFrustum& frustum, const vec3& p) {
    const vec3 local = SplatDepthMaps::frame(frustum).to_local(p - frustum.near_centre);
    if (std::max(std::fabs(local.x), std::fabs(local.y)) > frustum.half_side_m) return std::nullopt;
    if (local.z < 0 || local.z > frustum.depth_m) return std::nullopt;
    return maps.reaches(0, vec2(local), local.z);
}

vec3 unit_vector(RandomStream& random) {
    const float z = 2 * random.next() - 1, phi = 2 * kPi * random.next(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

TEST(SplatDepthMaps, APlaneIsLitAllOverHoweverRaysGrazeIt) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const uint32_t resolution : {4u, 5u, 16u, 64u}) {
        for (const float degrees : {0.0f, 30.0f, 60.0f, 75.0f, 80.0f}) {
            for (int azimuth = 0; azimuth < 8; ++azimuth) {
                const vec3 axis = unit_vector(random), centre = unit_vector(random);
                const Frame frame(axis);
                const float angle = degrees * kPi / 180, phi = 2 * kPi * random.next(), half_side_m = 0.1f;
                const vec3 across = std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent;
                const vec3 normal = std::sin(angle) * across - std::cos(angle) * axis;
                SplatScene scene;
                scene.plate(centre, normal, 4);
                scene.finish();
                const SplatFrustum frustum{centre - 1.0f * axis, axis, half_side_m, 2};
                const SplatDepthMaps maps = scene.trace({&frustum, 1}, resolution);
                size_t dark = 0;
                for (int i = 0; i <= 50; ++i) {
                    for (int j = 0; j <= 50; ++j) {
                        const vec2 p = 0.0399999f * half_side_m * vec2(i - 25, j - 25);
                        const float along =
                            1 - glm::dot(p.x * frame.tangent + p.y * frame.bitangent, normal) / glm::dot(axis, normal);
                        dark += !maps.reaches(0, p, along);
                    }
                }
                EXPECT_EQ(dark, 0u) << degrees << " degrees, resolution " << resolution;
            }
        }
    }
}

TEST(SplatDepthMaps, NothingIsLitMoreThanATexelBehindAPlane) {
    SplatScene scene;
    scene.plate({0, 0, 0}, {0, 0, 1}, 1);
    scene.finish();
    const SplatFrustum frustum{{0, 0, 1}, {0, 0, -1}, 0.2f, 3};
    const SplatDepthMaps maps = scene.trace({&frustum, 1}, 8);
    for (int i = -20; i <= 20; ++i) {
        for (int j = -20; j <= 20; ++j) {
            const vec2 p = 0.01f * vec2(i, j);
            EXPECT_TRUE(maps.reaches(0, p, 1.0f));
            EXPECT_TRUE(maps.reaches(0, p, 1.049f));  // a texel is 0.05 wide
            EXPECT_FALSE(maps.reaches(0, p, 1.051f));
        }
    }
}

TEST(SplatDepthMaps, APlateShadowsTheWallBehindItAndNotBesideItFromEitherFace) {
    constexpr uint32_t kResolution = 16;
    constexpr float kHalfSide = 0.4f, kTexel = 2 * kHalfSide / kResolution;
    for (const float facing : {1.0f, -1.0f}) {
        SplatScene scene;
        scene.plate({0, 0, 0}, {0, 0, 1}, 2);
        scene.plate({-1.013f, 0, 0.3f}, {0, 0, facing}, 1);  // its edge at x = -0.013
        scene.finish();
        const SplatFrustum frustum{{0, 0, 1}, {0, 0, -1}, kHalfSide, 2};
        const SplatDepthMaps maps = scene.trace({&frustum, 1}, kResolution);
        size_t shadowed = 0;
        for (int i = -39; i <= 39; ++i) {
            for (int j = -39; j <= 39; ++j) {
                const vec2 p = 0.01f * vec2(i, j);
                const std::optional<bool> wall = lit(maps, frustum, vec3(p, 0));
                ASSERT_TRUE(wall.has_value());
                if (p.x > -0.013f) {
                    EXPECT_TRUE(*wall) << p.x;
                } else {
                    EXPECT_TRUE(*lit(maps, frustum, vec3(p, 0.3f))) << "the plate itself";
                }
                if (p.x < -0.013f - 1.5f * kTexel) {
                    EXPECT_FALSE(*wall) << p.x;
                    ++shadowed;
                }
            }
        }
        EXPECT_GT(shadowed, 1000u);
    }
}

/// Counts of points of a surface within the frustum, by whether they are lit.
struct Lit {
    size_t lit = 0, dark = 0;
    void add(const std::optional<bool>& answer) {
        if (answer) ++(*answer ? lit : dark);
    }
};

TEST(SplatDepthMaps, InACornerWhatLiesBeforeTheWallStaysLit) {
    // A floor at z = 0 and a wall at x = 0 that meet; the room is x, z > 0. Also with a solid wall, 0.2 thick.
    for (const bool solid : {false, true}) {
        SplatScene scene;
        scene.quad({0, -3, 0}, {3, -3, 0}, {3, 3, 0}, {0, 3, 0});
        if (solid) {
            scene.box({-0.2f, -3, 0}, {0, 3, 3});
        } else {
            scene.quad({0, -3, 0}, {0, 3, 0}, {0, 3, 3}, {0, -3, 3});
        }
        scene.finish();
        for (const uint32_t resolution : {4u, 16u, 64u}) {
            for (const float slope : {0.0f, 0.3f, 1.0f}) {  // of the rays towards the wall
                for (const float beside_m : {0.003f, 0.03f, 0.1f}) {
                    // The frustum's side reaches behind the wall, at least where the rays meet the floor.
                    const vec3 axis = glm::normalize(vec3(-slope, 0, -1)), hit(beside_m, 0, 0);
                    const SplatFrustum frustum{hit - 0.5f * axis, axis, 0.15f, 1};
                    const SplatDepthMaps maps = scene.trace({&frustum, 1}, resolution);
                    Lit floor, wall;
                    for (int i = 1; i <= 60; ++i) {
                        for (int j = -30; j <= 30; ++j) {
                            const float along = 0.005f * static_cast<float>(i), y = 0.005f * static_cast<float>(j);
                            floor.add(lit(maps, frustum, {along, y, 0}));
                            if (slope > 0) wall.add(lit(maps, frustum, {0, y, along}));
                        }
                    }
                    EXPECT_GT(floor.lit, 500u);
                    EXPECT_EQ(floor.dark, 0u) << "slope " << slope << ", " << beside_m << " m, " << resolution;
                    EXPECT_EQ(wall.dark, 0u) << "slope " << slope << ", " << beside_m << " m, " << resolution;
                }
            }
        }
    }
}

TEST(SplatDepthMaps, RaysThatComeThroughTheWallLoseWhatTheyWouldHaveLitAndNoMore) {
    // Rays away from the wall: displaced ones start behind it and meet its back. They carry nothing
    // (derivations.md, "Splats with a kernel").
    SplatScene scene;
    scene.quad({0, -3, 0}, {3, -3, 0}, {3, 3, 0}, {0, 3, 0});
    scene.quad({0, -3, 0}, {0, 3, 0}, {0, 3, 3}, {0, -3, 3});
    scene.finish();
    constexpr uint32_t kResolution = 16;
    const vec3 axis = glm::normalize(vec3(0.5f, 0, -1)), hit(0.3f, 0, 0);
    const SplatFrustum frustum{hit - axis * 0.6f, axis, 0.2f, 1};
    const SplatDepthMaps maps = scene.trace({&frustum, 1}, kResolution);
    const float border_m = 1.5f * 2 * frustum.half_side_m / kResolution * std::sqrt(2.0f);  // whatever its direction
    Lit before, behind;
    for (int i = 1; i <= 150; ++i) {
        for (int j = -30; j <= 30; ++j) {
            const vec3 p(0.005f * static_cast<float>(i), 0.005f * static_cast<float>(j), 0);
            const vec3 start = p - glm::dot(p - frustum.near_centre, axis) * axis;
            // Across the rays, the wall's edge lies as far from the start as the wall's plane over its cosine.
            const float before_wall_m = start.x / std::sqrt(1 - axis.x * axis.x);
            if (before_wall_m >= 0) before.add(lit(maps, frustum, p));
            if (before_wall_m < -border_m) behind.add(lit(maps, frustum, p));
        }
    }
    EXPECT_GT(before.lit, 500u);
    EXPECT_EQ(before.dark, 0u);
    EXPECT_GT(behind.dark, 500u);
    EXPECT_EQ(behind.lit, 0u);
}

TEST(SplatDepthMaps, DetailNeedsResolution) {
    // The legs of the thesis' chairs (its Figure 19): a rod a twelfth of the frustum wide, between the coarse map's
    // texels' centres.
    SplatScene scene;
    scene.plate({0, 0, 0}, {0, 0, 1}, 2);
    scene.quad({0.12f, -2, 0.3f}, {0.2f, -2, 0.3f}, {0.2f, 2, 0.3f}, {0.12f, 2, 0.3f});
    scene.finish();
    const SplatFrustum frustum{{0, 0, 1}, {0, 0, -1}, 0.48f, 2};  // a texel of 4 is 0.24 wide: centres at 0.12, 0.36
    const SplatFrustum shifted{{-0.02f, 0, 1}, {0, 0, -1}, 0.48f, 2};
    const auto dark = [&](const SplatFrustum& f, uint32_t resolution) {
        const SplatDepthMaps maps = scene.trace({&f, 1}, resolution);
        Lit wall;
        for (int i = -45; i <= 45; ++i) wall.add(lit(maps, f, {0.01f * static_cast<float>(i), 0.013f, 0}));
        return wall.dark;
    };
    EXPECT_EQ(dark(shifted, 4), 0u);
    EXPECT_EQ(dark(frustum, 4), 0u);
    EXPECT_GE(dark(frustum, 64), 4u);  // 8 points lie behind the rod, a texel and a half off its edges 4
    EXPECT_LE(dark(frustum, 64), 8u);
}

TEST(SplatDepthMaps, WhereNothingIsMetAllIsLit) {
    SplatScene scene;
    scene.plate({0, 0, -5}, {0, 0, 1}, 1);  // beyond the frusta
    scene.finish();
    const std::vector<SplatFrustum> frusta(3, {{0, 0, 1}, {0, 0, -1}, 0.1f, 2});
    const SplatDepthMaps maps = scene.trace(frusta, 4);
    for (size_t i = 0; i < frusta.size(); ++i) {
        EXPECT_TRUE(maps.reaches(i, {0.1f, 0.1f}, 2));  // on the border, which belongs to the last texels
        EXPECT_TRUE(maps.reaches(i, {-0.1f, -0.1f}, 0));
    }
    EXPECT_EQ(SplatDepthMaps::bytes_for(3, 4), 3 * (16 * 4 + 8) + 16 * (sizeof(Ray) + sizeof(Hit)));
    SplatDepthMaps none(4);
    Counts counts;
    none.trace({}, scene.intersector(), counts);
    EXPECT_EQ(counts.shadow_rays, 0u);
}

TEST(SplatDepthMaps, TexelsHoldWhatSingleRaysMeet) {
    // Triangles everywhere; the depth of a texel inside the map against the greatest of nine rays and a texel's width.
    SplatScene scene;
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 300; ++i)
        scene.plate(vec3(random.next(), random.next(), random.next()), unit_vector(random), 0.05f);
    scene.finish();
    constexpr uint32_t kResolution = 8;
    std::vector<SplatFrustum> frusta;
    for (int i = 0; i < 40; ++i)
        frusta.push_back({vec3(random.next(), random.next(), random.next()), unit_vector(random), 0.2f, 0.5f});
    const SplatDepthMaps maps = scene.trace(frusta, kResolution);
    size_t met = 0;
    for (size_t f = 0; f < frusta.size(); ++f) {
        const Frame frame = SplatDepthMaps::frame(frusta[f]);
        const float texel = 2 * frusta[f].half_side_m / kResolution;
        const auto centre = [&](int i) { return (static_cast<float>(i) + 0.5f) * texel - frusta[f].half_side_m; };
        for (int row = 1; row < int(kResolution) - 1; ++row) {
            for (int column = 1; column < int(kResolution) - 1; ++column) {
                float farthest = 0;
                for (int i = -1; i <= 1; ++i) {
                    for (int j = -1; j <= 1; ++j) {
                        const vec3 start = frusta[f].near_centre + centre(column + i) * frame.tangent +
                                           centre(row + j) * frame.bitangent;
                        const Hit hit = scene.intersector().closest_hit({start, frame.normal, frusta[f].depth_m});
                        farthest = std::max(farthest, std::min(hit.t, frusta[f].depth_m));
                        met += hit.valid();
                    }
                }
                // Away from the map's border nothing goes on beyond it: the answer turns within rounding.
                const vec2 p(centre(column), centre(row));
                if (row == 1 || column == 1 || row == int(kResolution) - 2 || column == int(kResolution) - 2) {
                    EXPECT_TRUE(maps.reaches(f, p, farthest + 0.999f * texel));
                    continue;
                }
                EXPECT_TRUE(maps.reaches(f, p, farthest + texel - 1e-5f));
                EXPECT_FALSE(maps.reaches(f, p, farthest + texel + 1e-5f));
            }
        }
    }
    EXPECT_GT(met, 1000u);
}

}  // namespace
}  // namespace photond::splat_depth_maps_test
