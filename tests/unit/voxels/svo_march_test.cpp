// Rays through a voxel tree against a loop over all set voxels, in double precision.

#include "renderer/voxels/svo_march.h"

#include <gtest/gtest.h>

#include <optional>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/voxels/sparse_voxel_octree.h"
#include "tests/support/voxels.h"

namespace photond::svo_march_test {
namespace {

SparseVoxelOctree build(const Scene& scene, uint32_t resolution) {
    return {scene, make_voxel_grid(scene.bounds, resolution), true};
}

struct Interval {
    double enter, leave;
};
/// Where origin + t direction [voxels] is within a voxel made larger by `widen` to all sides.
std::optional<Interval> crossing(const dvec3& origin, const dvec3& direction, const uvec3& voxel, double widen) {
    Interval interval{0, 1e300};
    for (int i = 0; i < 3; ++i) {
        const double low = voxel[i] - widen - origin[i], high = voxel[i] + 1.0 + widen - origin[i];
        if (direction[i] == 0) {
            if (low > 0 || high < 0) return {};
            continue;
        }
        const double a = low / direction[i], b = high / direction[i];
        interval.enter = std::max(interval.enter, std::min(a, b)),
        interval.leave = std::min(interval.leave, std::max(a, b));
    }
    if (interval.enter > interval.leave) return {};
    return interval;
}

Ray random_ray(RandomStream& random, const Bounds3& bounds, int kind) {
    const vec3 size = bounds.diagonal();
    const vec3 from = bounds.min + (1.6f * test::random_vec3(random) - 0.3f) * size;
    vec3 to = bounds.min + (1.2f * test::random_vec3(random) - 0.1f) * size;
    if (kind == 1) to[random.next_bits() % 3] = from[0];
    vec3 d = glm::normalize(to - from);
    if (kind == 2) {
        d = vec3(0);
        d[random.next_bits() % 3] = random.next() < 0.5f ? -1 : 1;
    }
    return {from, d, random.next() < 0.3f ? random.next() * glm::length(size) : kInfinity};
}

class Marching : public testing::TestWithParam<const char*> {};

TEST_P(Marching, MeetsWhatALoopOverAllVoxelsMeets) {
    const std::string name = GetParam();
    const Scene scene = name == "medley" ? test::voxel_medley() : make_builtin_scene(name);
    const SparseVoxelOctree tree = build(scene, 32);
    const SvoView view = tree.view();
    const test::VoxelList list = test::list_voxels(view);
    RandomStream random(1, RandomDomain::Test, 0, 0);
    size_t hits = 0;
    constexpr double kRounding = 2e-4;  // of single precision, in voxels
    for (int i = 0; i < 3000; ++i) {
        const Ray ray = random_ray(random, scene.bounds, i % 3);
        const double t_max = double{ray.t_max} / double{tree.constants().grid.cell_m};
        const dvec3 origin =
            (dvec3(ray.origin) - dvec3(tree.constants().grid.low)) / double{tree.constants().grid.cell_m};
        const dvec3 direction(ray.direction);
        double surely = 1e300, perhaps = 1e300;
        for (const uint64_t v : list.voxels) {
            const uvec3 voxel(v % 32, v / 32 % 32, v / 1024);
            const auto inner = crossing(origin, direction, voxel, -kRounding);
            if (inner && inner->enter < t_max - kRounding) surely = std::min(surely, inner->enter);
            const auto outer = crossing(origin, direction, voxel, kRounding);
            if (outer && outer->enter < t_max + kRounding) perhaps = std::min(perhaps, outer->enter);
        }
        VoxelHit hit;
        const bool met = svo_first_voxel(view, ray, hit);
        hits += met;
        const double t = met ? double{hit.t} / double{tree.constants().grid.cell_m} : 1e300;
        ASSERT_LE(t, surely + 0.1) << i;  // an inner box is entered at grazing angles long after the voxel
        ASSERT_GE(t, perhaps - kRounding) << i;
        if (!met) continue;
        const auto own = crossing(origin, direction, hit.voxel, kRounding);
        ASSERT_TRUE(own) << i;
        ASSERT_NEAR(t, own->enter, 0.1) << i;
        const uint64_t code = hit.voxel.x + 32 * (hit.voxel.y + 32 * uint64_t{hit.voxel.z});
        const auto at = std::lower_bound(list.voxels.begin(), list.voxels.end(), code);
        ASSERT_TRUE(at != list.voxels.end() && *at == code) << i;
        ASSERT_EQ(hit.surface, list.triangles[static_cast<size_t>(at - list.voxels.begin())]);
    }
    EXPECT_GT(hits, 500u);
    EXPECT_LT(hits, 3000u);
}
INSTANTIATE_TEST_SUITE_P(Scenes, Marching, testing::Values("medley", "cornell-box", "photon-splatting/chairs"));

TEST(SvoMarch, EndsWhateverItIsGiven) {
    const Scene scene = make_builtin_scene("cornell-box");
    const SparseVoxelOctree tree = build(scene, 64);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float odd[] = {0, -0.0f, 1, -1, 0.27f, 1e-30f, -1e-30f, 1e30f, -1e30f, kInfinity, -kInfinity, nan};
    RandomStream random(2, RandomDomain::Test, 0, 0);
    const auto pick = [&] { return odd[random.next_bits() % std::size(odd)]; };
    const auto point = [&] {
        const float x = pick(), y = pick();
        return vec3(x, y, pick());
    };
    for (int i = 0; i < 20'000; ++i) {
        VoxelHit hit;
        const Ray ray{point(), point(), pick()};
        ASSERT_TRUE(!svo_first_voxel(tree.view(), ray, hit) || tree.view().is_set(hit.voxel));
        svo_occluded(tree.view(), ray.origin, ray.direction);
        svo_occluded(tree.view(), ray.origin, point(), ray.direction, point());
    }
    VoxelHit hit;
    EXPECT_FALSE(svo_first_voxel(tree.view(), {vec3(nan), vec3(0, 0, 1)}, hit));
    EXPECT_FALSE(svo_first_voxel(tree.view(), {vec3(0.2f), vec3(0, nan, 1)}, hit));
    EXPECT_FALSE(svo_first_voxel(tree.view(), {vec3(0.2f), vec3(0, 0, 1), nan}, hit));
    EXPECT_FALSE(svo_occluded(tree.view(), vec3(0.2f), vec3(0.2f)));
    EXPECT_FALSE(svo_occluded(tree.view(), vec3(0.2f), vec3(0, 1, 0), vec3(0.2f), vec3(0, -1, 0)));
}

/// Several at a time are answered as one by one, but for segments that pass an edge by less than rounding.
TEST(SvoMarch, AnswersManyAtATime) {
    for (const uint32_t resolution : {16u, 64u, 512u}) {
        const Scene scene = test::voxel_medley();
        const SparseVoxelOctree tree = build(scene, resolution);
        RandomStream random(5, RandomDomain::Test, 0, 0);
        const auto point = [&] { return scene.bounds.min + scene.bounds.diagonal() * test::random_vec3(random); };
        const auto unit = [&] { return glm::normalize(test::random_vec3(random) - 0.5f); };
        std::vector<SvoSegment> segments;
        for (int i = 0; i < 10'001; ++i) segments.push_back({point(), unit(), point(), unit()});
        segments[7].a.y = std::numeric_limits<float>::quiet_NaN();
        segments[70].b = segments[70].a;
        segments[700].b = vec3(1e30f);
        std::vector<uint8_t> occluded(segments.size(), 2);
        svo_occluded(tree.view(), segments, occluded);
        size_t met = 0, different = 0;
        for (size_t i = 0; i < segments.size(); ++i) {
            const SvoSegment& s = segments[i];
            ASSERT_LT(occluded[i], 2);
            met += occluded[i];
            different += svo_occluded(tree.view(), s.a, s.normal_a, s.b, s.normal_b) != (occluded[i] != 0);
        }
        EXPECT_LE(different, segments.size() / 1000);
        EXPECT_GT(met, segments.size() / 10);
        EXPECT_LT(met, segments.size() * 9 / 10);
        uint8_t one = 2;
        svo_occluded(tree.view(), std::span(segments).subspan(9, 1), std::span(&one, 1));
        EXPECT_EQ(one, occluded[9]);
        svo_occluded(tree.view(), std::span<const SvoSegment>(), std::span<uint8_t>());
    }
}

/// A box cut in two by a wall of that thickness, turned so that no face lies along voxels.
Scene divided_box(float thickness_m, bool turned) {
    Scene scene;
    MeshBuilder builder;
    builder.box(vec3(-1), vec3(1));
    if (thickness_m > 0)
        builder.box(vec3(-1, -1, -0.5f * thickness_m), vec3(1, 1, 0.5f * thickness_m));
    else
        builder.quad(vec3(-1, -1, 0), vec3(1, -1, 0), vec3(1, 1, 0), vec3(-1, 1, 0));
    test::add(scene, builder.build(0), test::lambert(0.5f));
    finish_scene(scene);
    return turned ? test::turned(scene) : scene;
}

TEST(SvoMarch, LetsNothingThroughThinWalls) {
    RandomStream random(3, RandomDomain::Test, 0, 0);
    const mat3 turn(glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3))));  // as test::turned()
    for (const float thickness_m : {0.0f, 2e-3f}) {
        for (const bool turned : {false, true}) {
            const Scene scene = divided_box(thickness_m, turned);
            for (const uint32_t resolution : {64u, 256u}) {
                const SparseVoxelOctree tree = build(scene, resolution);
                const float away = 8 * tree.constants().grid.cell_m;
                int leaks = 0;
                for (int i = 0; i < 50'000; ++i) {
                    vec3 a = 1.99f * (test::random_vec3(random) - 0.5f), b = 1.99f * (test::random_vec3(random) - 0.5f);
                    a.z = away + (0.99f - away) * random.next(), b.z = -away - (0.99f - away) * random.next();
                    if (turned) a = turn * a, b = turn * b;
                    leaks += !svo_occluded(tree.view(), a, b);
                }
                EXPECT_EQ(leaks, 0) << thickness_m << " " << turned << " " << resolution;
            }
        }
    }
}

/// Floor and ceiling of an empty room see each other, however flat the segment lies: their own voxels are not in the
/// way.
TEST(SvoMarch, SparesTheSurfacesItsEndsLieOn) {
    for (const bool turned : {false, true}) {
        const Scene scene = turned ? test::turned(divided_box(0, false)) : divided_box(0, false);
        const mat3 turn = turned ? mat3(glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3)))) : mat3(1.0f);
        const SparseVoxelOctree tree = build(scene, 128);
        const float margin = 4 * tree.constants().grid.cell_m;  // to the walls
        RandomStream random(4, RandomDomain::Test, 0, 0);
        int blocked = 0;
        for (int i = 0; i < 20'000; ++i) {
            const auto inside = [&] { return (1 - margin) * (2 * random.next() - 1); };
            const float x = inside(), z = margin + (1 - 2 * margin) * random.next();
            vec3 a(x, -1, z), b(inside(), inside(), 1), normal_b(0, 0, -1);
            if (i % 2) b = vec3(b.x, 1, margin + (1 - 2 * margin) * random.next()), normal_b = vec3(0, -1, 0);
            if (b.y < -1 + margin || b.z < margin) continue;
            blocked += svo_occluded(tree.view(), turn * a, turn * vec3(0, 1, 0), turn * b, turn * normal_b);
        }
        EXPECT_EQ(blocked, 0);
    }
}

}  // namespace
}  // namespace photond::svo_march_test
