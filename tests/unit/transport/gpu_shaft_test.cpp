// Shafts on the device against rays: what no triangle, or none of those told, cuts, no ray may find blocked.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/transport/surface.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_shaft_test {
namespace {

constexpr uint32_t kMostBlockers = 8;  // SHAFT_MOST_BLOCKERS of shaft.comp

/// As in shaft.comp.
struct Target {
    vec3 centre, half_extent;
    float radius_m;
    vec3 normal;
};
struct Question {
    vec3 apex, apex_normal;
    Target target;
    vec3 from, to;
};
struct Answer {
    uint32_t blockers, cut;
};
static_assert(sizeof(Question) == 88);

struct SeenPoint {
    vec3 position, normal;  // on the side it is seen from
};

/// Points that rays about a direction meet.
std::vector<SeenPoint> look(const test::SceneOnDevice& where, const Intersector& rays, RandomStream& random,
                            float width, int count) {
    const auto point = [&] {
        const float x = random.next(), y = random.next();
        return vec3(x, y, random.next());
    };
    const Bounds3& box = where.scene.bounds;
    const vec3 eye = box.min + box.diagonal() * (0.8f * point() + 0.1f), about = point() - 0.5f;
    std::vector<SeenPoint> points;
    for (int i = 0; i < count; ++i) {
        const vec3 w = glm::normalize(about + width * (point() - 0.5f));
        const Hit hit = rays.closest_hit({eye, w, kInfinity});
        if (!hit.valid()) continue;
        const ShadingPoint at = make_shading_point(where.scene, hit, w);
        points.push_back({at.position, at.geometric_normal});
    }
    return points;
}

Target target_of(const std::vector<SeenPoint>& points) {
    Bounds3 box;
    vec3 mean(0);
    bool flat = true;
    for (const SeenPoint& point : points) {
        box.extend(point.position);
        mean += point.position / float(points.size());
        flat &= glm::length(point.normal - points[0].normal) < 1e-6f;
    }
    const float coordinates = max_component(glm::max(glm::abs(box.min), glm::abs(box.max)));
    for (const SeenPoint& point : points)
        flat &= std::fabs(glm::dot(point.position - mean, points[0].normal)) <= 1e-6f * coordinates;
    Target target{flat ? mean : box.centre(), {}, 0, flat ? points[0].normal : vec3(0)};
    target.half_extent = glm::max(box.max - target.centre, target.centre - box.min);
    for (const SeenPoint& point : points)
        target.radius_m = std::max(target.radius_m, 1.0001f * glm::length(point.position - target.centre));
    return target;
}

class GpuShafts : public testing::TestWithParam<const char*> {};

TEST_P(GpuShafts, MissNothingThatRaysMeet) {
    const Scene scene = make_builtin_scene(GetParam());
    const test::SceneOnDevice where(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> rays = make_embree_intersector(scene, budget, stats);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<Question> questions;
    while (questions.size() < 20'000) {
        const std::vector<SeenPoint> points = look(where, *rays, random, 0.1f, 12);
        const std::vector<SeenPoint> apexes = look(where, *rays, random, 2.0f, 8);
        if (points.empty()) continue;
        const Target target = target_of(points);
        for (const SeenPoint& apex : apexes) {
            for (const SeenPoint& point : points) {
                const vec3 d = point.position - apex.position;
                // Along a surface, where hardly any light goes, what stands off it by rounding may be either side.
                const float grazing = 1e-3f * glm::length(d);
                if (!(glm::dot(apex.normal, d) > grazing) || !(glm::dot(point.normal, d) < -grazing)) continue;
                questions.push_back({apex.position, apex.normal, target,
                                     offset_ray_origin(point.position, point.normal),
                                     offset_ray_origin(apex.position, apex.normal)});
            }
        }
    }
    const auto constants = where.device_scene.specialization();
    const test::Twin twin("tests/gpu/shaft.comp", &where.device_scene.set(), constants);
    const std::vector<Answer> answers = twin.run<Answer>(questions.size(), {{"questions", questions}});
    size_t known = 0, clear = 0, wrong = 0;
    for (size_t i = 0; i < questions.size(); ++i) {
        if (answers[i].blockers > kMostBlockers) continue;
        ++known;
        clear += answers[i].blockers == 0;
        const bool blocked = rays->occluded({questions[i].from, questions[i].to - questions[i].from, 1});
        wrong += blocked != (answers[i].cut != 0);
    }
    EXPECT_GT(known, questions.size() / 5);
    EXPECT_GT(clear, questions.size() / 20);
    // Through edges and corners, which of two triangles a segment cuts, or none, is rounding's to decide.
    EXPECT_LE(wrong, known / 2000);
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuShafts,
                         testing::Values("cornell-box", "photon-splatting/chairs", "interior"));

}  // namespace
}  // namespace photond::gpu_shaft_test
