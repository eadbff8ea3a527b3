// Guiding by projection maps changes how often photons start where, and nothing else: the flux of every bundle of
// directions and places stays. And it does what it is for.

#include "renderer/photons/projection_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/bsdf.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::projection_map_test {
namespace {

using test::add;
using test::RunningMean;
using test::share_of_false_alarm;
using test::two_sided_z;

constexpr double kFalseAlarm = 1e-6;  // of each test as a whole
constexpr float kGlossyThreshold = 0.05f;

Material grey() {
    Material material;
    material.base_color = Rgb(0.5f);
    material.metallic = 0;
    material.specular = 0;
    return material;
}

Material mirror() {
    Material material;
    material.base_color = Rgb(0.9f);
    material.metallic = 1;
    material.roughness = 0;
    return material;
}

/// A mirroring ball over a grey floor of 4 m by 4 m; lights are added by the tests.
Scene ball_on_floor() {
    Scene scene;
    add(scene, MeshBuilder().quad(vec3(-2, 0, 2), vec3(2, 0, 2), vec3(2, 0, -2), vec3(-2, 0, -2)).build(0), grey());
    add(scene, MeshBuilder().sphere(vec3(0.4f, 0.3f, 0.2f), 0.3f, 32).build(0), mirror());
    return scene;
}

PunctualLight punctual(PunctualLight::Kind kind) {
    PunctualLight light;
    light.kind = kind;
    light.intensity = Rgb(3, 2, 1);
    light.position = vec3(-0.5f, 2, 0);
    light.direction = glm::normalize(vec3(0.3f, -1, 0.1f));
    light.cos_inner = std::cos(0.3f);
    light.cos_outer = std::cos(0.9f);
    return light;
}

Scene with_punctual(PunctualLight::Kind kind) {
    Scene scene = ball_on_floor();
    scene.punctual_lights.push_back(punctual(kind));
    finish_scene(scene);
    return scene;
}

/// Whose rays pass over the floor for the most part.
Scene low_sun() {
    Scene scene = ball_on_floor();
    scene.punctual_lights.push_back(punctual(PunctualLight::Kind::Directional));
    scene.punctual_lights[0].direction = glm::normalize(vec3(1, -0.2f, 0.1f));
    finish_scene(scene);
    return scene;
}

Scene with_panel(bool two_sided) {
    Scene scene = ball_on_floor();
    Material panel = grey();
    panel.emission = Rgb(3, 2, 1);
    panel.double_sided = two_sided;
    add(scene, MeshBuilder().quad(vec3(-1, 2, -1), vec3(0, 2, -1), vec3(0, 2, 0), vec3(-1, 2, 0)).build(0), panel);
    finish_scene(scene);
    return scene;
}

Scene with_environment() {
    Scene scene = ball_on_floor();
    Environment environment;
    environment.map.size = {8, 4};
    for (uint32_t i = 0; i < 32; ++i) environment.map.radiance.push_back(Rgb(i == 5 ? 10.0f : 1.0f, 1, 2));
    scene.environment = environment;
    finish_scene(scene);
    return scene;
}

/// Two posts far apart below a bright sky: between them light finds nothing.
Scene posts_in_the_open() {
    Scene scene;
    for (const float x : {-2.0f, 2.0f})
        add(scene, MeshBuilder().box(vec3(x - 0.2f, 0, -0.2f), vec3(x + 0.2f, 1, 0.2f)).build(0), grey());
    Environment environment;
    environment.map.size = {8, 4};
    for (uint32_t i = 0; i < 32; ++i) environment.map.radiance.push_back(Rgb(i < 16 ? 3.0f : 0.2f));
    scene.environment = environment;
    finish_scene(scene);
    return scene;
}

/// 300 small panels: more than get bins.
Scene with_many_panels() {
    Scene scene = ball_on_floor();
    Material panel = grey();
    panel.emission = Rgb(3, 2, 1);
    MeshBuilder panels;
    for (uint32_t i = 0; i < 150; ++i) {
        const float x = -1.5f + 0.2f * static_cast<float>(i % 15), z = -1 + 0.2f * static_cast<float>(i / 15);
        const float side = 0.02f + 0.0005f * static_cast<float>(i);
        panels.quad(vec3(x, 2, z), vec3(x + side, 2, z), vec3(x + side, 2, z + side), vec3(x, 2, z + side));
    }
    add(scene, panels.build(0), panel);
    finish_scene(scene);
    return scene;
}

struct Guided {
    explicit Guided(Scene made, ProjectionTarget target_of_map = ProjectionTarget::SpecularSurfaces)
        : scene(std::move(made)),
          intersector(make_embree_intersector(scene, budget, stats)),
          emission(scene),
          target(target_of_map),
          map(scene, *intersector, emission, target, kGlossyThreshold, 1) {}

    MemoryBudget budget;
    Stats stats;
    Scene scene;
    std::unique_ptr<Intersector> intersector;
    EmissionSampler emission;
    ProjectionTarget target;
    ProjectionMap map;

    bool first_hit_counts(const Ray& ray) const {
        const Hit hit = intersector->closest_hit(ray);
        if (!hit.valid()) return false;
        const ShadingPoint point = make_shading_point(scene, hit, ray.direction);
        const Bsdf bsdf = make_bsdf(scene, point);
        return (target == ProjectionTarget::Surfaces ? bsdf : bsdf.specular_part(kGlossyThreshold)).scatters();
    }
    bool draw(RandomStream& random, bool guided, EmissionSample& sample) const {
        const float u_select = random.next();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        return guided ? map.sample(u_select, u_position, u_direction, sample)
                      : emission.sample(u_select, u_position, u_direction, sample);
    }
};

struct MapCase {
    const char* name;
    std::function<Scene()> make;
    ProjectionTarget target = ProjectionTarget::SpecularSurfaces;
};
void PrintTo(const MapCase& map_case, std::ostream* out) { *out << map_case.name; }

const MapCase kCases[] = {
    {"Point", [] { return with_punctual(PunctualLight::Kind::Point); }},
    {"Spot", [] { return with_punctual(PunctualLight::Kind::Spot); }},
    {"Directional", [] { return with_punctual(PunctualLight::Kind::Directional); }},
    {"Panel", [] { return with_panel(false); }},
    {"TwoSidedPanel", [] { return with_panel(true); }},
    {"Environment", with_environment},
    {"ManyPanels", with_many_panels},
    {"CornellBoxGlass", [] { return make_builtin_scene("cornell-box-glass"); }},
    {"AnySurfaceOfAPoint", [] { return with_punctual(PunctualLight::Kind::Point); }, ProjectionTarget::Surfaces},
    {"AnySurfaceOfTheSun", low_sun, ProjectionTarget::Surfaces},
    {"AnySurfaceOfAnEnvironment", posts_in_the_open, ProjectionTarget::Surfaces},
};

class ProjectionMapOf : public testing::TestWithParam<MapCase> {};

/// Cell of a ray's start and direction: both count, as the bins are of both.
constexpr uint32_t kDirectionCells = 8 * 8, kPlaceCells = 8, kCells = kDirectionCells * kPlaceCells;
uint32_t cell_of(const Scene& scene, const Ray& ray) {
    const vec3& w = ray.direction;
    const float turn = std::atan2(w.z, w.x) / (2 * kPi) + 0.5f;
    const auto index = [](float t) { return std::min(static_cast<uint32_t>(std::max(0.0f, t) * 8), 7u); };
    const vec3 from_centre = ray.origin - scene.bounds.centre();
    const uint32_t place =
        (from_centre.x > 0.0f ? 1u : 0u) | (from_centre.y > 0.0f ? 2u : 0u) | (from_centre.z > 0.0f ? 4u : 0u);
    return (place * 8 + index(0.5f + 0.5f * w.y)) * 8 + index(turn);
}

/// Flux of many photons by cell of start and direction; last, of all together.
struct Flux {
    struct Sum {
        uint32_t photons = 0;
        double power_w = 0, squares = 0;
        Sum& operator+=(const Sum& more) {
            photons += more.photons, power_w += more.power_w, squares += more.squares;
            return *this;
        }
    };
    std::vector<Sum> cells{kCells + 1};
    uint32_t samples = 0;
    float most_power_w = 0;

    double mean(const Sum& sum) const { return sum.power_w / samples; }
    double variance_of_mean(const Sum& sum) const { return (sum.squares / samples - mean(sum) * mean(sum)) / samples; }
};
Flux measure_flux(const Guided& guided, bool by_map, uint32_t samples, uint64_t stream) {
    Flux flux;
    flux.samples = samples;
    RandomStream random(3, RandomDomain::Test, 0, stream);
    for (uint32_t i = 0; i < samples; ++i) {
        EmissionSample sample;
        if (!guided.draw(random, by_map, sample)) continue;
        const double power_w = mean(sample.power_w);
        const Flux::Sum photon{1, power_w, power_w * power_w};
        flux.cells[cell_of(guided.scene, sample.ray)] += photon;
        flux.cells[kCells] += photon;
        flux.most_power_w = std::max(flux.most_power_w, mean(sample.power_w));
    }
    return flux;
}

/// Guided and unguided photons carry the same flux into every cell.
TEST_P(ProjectionMapOf, IsUnbiased) {
    constexpr double kMustDetect = 0.02;
    constexpr uint32_t kSamples = 1000000, kLeastPhotons = 100;  // in a cell; cells with fewer are joined
    const Guided guided(GetParam().make(), GetParam().target);
    const Flux with = measure_flux(guided, true, kSamples, 1), without = measure_flux(guided, false, kSamples, 2);
    Flux::Sum few_with, few_without;
    std::vector<std::pair<Flux::Sum, Flux::Sum>> pairs;
    for (uint32_t cell = 0; cell <= kCells; ++cell) {
        if (with.cells[cell].photons >= kLeastPhotons && without.cells[cell].photons >= kLeastPhotons)
            pairs.emplace_back(with.cells[cell], without.cells[cell]);
        else
            few_with += with.cells[cell], few_without += without.cells[cell];
    }
    ASSERT_GT(pairs.size(), 3u);
    if (few_with.photons >= kLeastPhotons && few_without.photons >= kLeastPhotons)
        pairs.emplace_back(few_with, few_without);
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, pairs.size() * std::size(kCases)));
    for (const auto& [a, b] : pairs) {
        const double tolerance = z * std::sqrt(with.variance_of_mean(a) + without.variance_of_mean(b));
        EXPECT_NEAR(with.mean(a), without.mean(b), tolerance + 1e-5 * without.mean(b));
    }
    const Flux::Sum &all_with = with.cells[kCells], &all_without = without.cells[kCells];
    EXPECT_LT(z * std::sqrt(with.variance_of_mean(all_with) + without.variance_of_mean(all_without)),
              kMustDetect * without.mean(all_without))
        << "too noisy to notice a defect";
    // A tenth of the photons is unguided.
    EXPECT_LE(with.most_power_w, 10.0001f * without.most_power_w);
}

/// Both shares are what photons really do, guided or not.
TEST_P(ProjectionMapOf, StatesItsShares) {
    const Guided guided(GetParam().make(), GetParam().target);
    constexpr uint32_t kSamples = 40000;
    RandomStream random(4, RandomDomain::Test, 0, 0);
    double power_w = 0, target_power_w = 0, squares = 0;
    uint32_t on_target = 0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        EmissionSample sample;
        if (guided.draw(random, true, sample)) on_target += guided.first_hit_counts(sample.ray) ? 1 : 0;
        if (!guided.draw(random, false, sample)) continue;
        const double mean_w = mean(sample.power_w);
        power_w += mean_w, squares += mean_w * mean_w;
        if (guided.first_hit_counts(sample.ray)) target_power_w += mean_w;
    }
    // The map's own shares are estimates as well: the guided one of 4096 rays, the unguided one of far more than 8192.
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, 2 * std::size(kCases)));
    const double g = on_target / double{kSamples}, u = target_power_w / power_w;
    const double spread = squares * kSamples / (power_w * power_w);  // of the powers: 1 when all are the same
    EXPECT_NEAR(guided.map.guided_share(), g, z * std::sqrt(g * (1 - g) * (1.0 / kSamples + 1.0 / 4096)));
    EXPECT_NEAR(guided.map.unguided_share(), u, z * std::sqrt(spread * u * (1 - u) * (1.0 / kSamples + 1.0 / 8192)));
    EXPECT_TRUE(guided.map.helps());
    const bool any = guided.target == ProjectionTarget::Surfaces;  // of whose rays a third may meet one unguided
    EXPECT_GT(guided.map.guided_share(), (any ? 2 : 3) * guided.map.unguided_share());
    EXPECT_LE(guided.map.bytes(), ProjectionMap::estimate_bytes(guided.emission.lights()));
    RecordProperty("unguided_share", std::to_string(guided.map.unguided_share()));
    RecordProperty("guided_share", std::to_string(guided.map.guided_share()));
    std::printf("%s: share %.4f, guided %.4f, %llu pilot rays\n", GetParam().name, guided.map.unguided_share(),
                guided.map.guided_share(), static_cast<unsigned long long>(guided.map.pilot_rays()));
}

INSTANTIATE_TEST_SUITE_P(Lights, ProjectionMapOf, testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ProjectionMap, IsTheSameForAnyNumberOfThreads) {
    const Scene scene = with_panel(true);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const EmissionSampler emission(scene);
    const auto make = [&](int threads, uint64_t seed) {
        return test::on_threads(threads, [&] {
            return std::make_unique<ProjectionMap>(scene, *intersector, emission, ProjectionTarget::SpecularSurfaces,
                                                   kGlossyThreshold, seed);
        });
    };
    const auto one = make(1, 5), four = make(4, 5), other = make(4, 6);
    EXPECT_EQ(one->unguided_share(), four->unguided_share());
    EXPECT_EQ(one->guided_share(), four->guided_share());
    EXPECT_EQ(one->pilot_rays(), four->pilot_rays());
    EXPECT_NE(one->guided_share(), other->guided_share());
    RandomStream random(6, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 10000; ++i) {
        const float u_select = random.next();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        EmissionSample a, b;
        ASSERT_EQ(one->sample(u_select, u_position, u_direction, a),
                  four->sample(u_select, u_position, u_direction, b));
        ASSERT_EQ(a.power_w, b.power_w);
        ASSERT_EQ(a.ray.direction, b.ray.direction);
    }
}

/// Nothing to gain: no specular surface, nothing but specular surfaces, no light. Photons start as without a map.
TEST(ProjectionMap, KnowsWhenItCannotHelp) {
    const auto closed_box = [](const Material& wall) {
        Scene scene;
        Mesh box = MeshBuilder().box(vec3(-1), vec3(1)).build(0);
        for (uvec3& t : box.triangles) std::swap(t.y, t.z);
        add(scene, std::move(box), wall);
        scene.punctual_lights.push_back(punctual(PunctualLight::Kind::Point));
        scene.punctual_lights[0].position = vec3(0.2f, 0.1f, 0);
        finish_scene(scene);
        return scene;
    };
    Material coated = grey();
    coated.specular = 1;
    coated.roughness = 0.5f;  // glossy, but above the threshold
    const Guided lambert(closed_box(grey())), mirrors(closed_box(mirror())), rough(closed_box(coated));
    EXPECT_EQ(lambert.map.unguided_share(), 0);
    EXPECT_EQ(lambert.map.pilot_rays(), 0u) << "nothing there to look for";
    EXPECT_EQ(rough.map.unguided_share(), 0);
    EXPECT_NEAR(mirrors.map.unguided_share(), 1, 1e-6);
    for (const Guided* guided : {&lambert, &mirrors, &rough}) {
        EXPECT_FALSE(guided->map.helps());
        EXPECT_EQ(guided->map.guided_share(), guided->map.unguided_share());
        EmissionSample sample;
        ASSERT_TRUE(guided->map.sample(0.3f, vec2(0.2f), vec2(0.6f), sample));
        EXPECT_NEAR(mean(sample.power_w), guided->emission.total_power_w(), 1e-3 * guided->emission.total_power_w());
    }

    Scene dark_scene = ball_on_floor();
    finish_scene(dark_scene);
    const Guided dark(std::move(dark_scene)), empty{Scene{}};
    for (const Guided* guided : {&dark, &empty}) {
        EmissionSample sample;
        EXPECT_FALSE(guided->map.helps());
        EXPECT_FALSE(guided->map.sample(0.5f, vec2(0.5f), vec2(0.5f), sample));
    }
}

/// In a closed room every photon meets a surface: a few rays show it, and no bins are made.
TEST(ProjectionMap, LooksAtOpenScenesAlone) {
    Scene scene = make_builtin_scene("cornell-box");
    const Guided box(std::move(scene), ProjectionTarget::Surfaces);
    EXPECT_GT(box.map.unguided_share(), 0.5);
    EXPECT_EQ(box.map.guided_share(), box.map.unguided_share());
    EXPECT_FALSE(box.map.helps());
    EXPECT_FALSE(box.map.has_bins());
    EXPECT_LE(box.map.pilot_rays(), 4096u);
    EmissionSample guided, unguided;
    ASSERT_TRUE(box.map.sample(0.3f, vec2(0.2f), vec2(0.6f), guided));
    ASSERT_TRUE(box.emission.sample(0.3f, vec2(0.2f), vec2(0.6f), unguided));
    EXPECT_NEAR(mean(guided.power_w), mean(unguided.power_w), 1e-5 * mean(unguided.power_w));
}

/// A surface beyond a light's range is not lit: it draws no photons.
TEST(ProjectionMap, KnowsTheRangeOfLights) {
    Scene scene = ball_on_floor();
    scene.punctual_lights.push_back(punctual(PunctualLight::Kind::Point));
    scene.punctual_lights[0].range_m = 0.5f;
    finish_scene(scene);
    const Guided guided(std::move(scene));
    EXPECT_EQ(guided.map.unguided_share(), 0);
    EXPECT_FALSE(guided.map.helps());
}

}  // namespace
}  // namespace photond::projection_map_test
