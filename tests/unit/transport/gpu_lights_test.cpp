// The device's lights are the host's: the same samples, densities and radiance for the same numbers, but for rounding.
//
// A sample is a choice and then a map from numbers to places. Where a number falls within rounding of a choice's
// border the two may choose differently; the share of such samples is bounded, and all others agree.

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/light_tables.h"
#include "tests/support/device_light_samples.h"
#include "tests/support/scene_parts.h"

namespace photond::test::gpu_lights_test {
namespace {

// --- scenes ------------------------------------------------------------------------------------------------------

Scene cornell_box() { return make_builtin_scene("cornell-box"); }  // one parallelogram
Scene cornell_box_spot() { return make_builtin_scene("cornell-box-spot"); }

/// Triangles and points of all sizes, powers and directions, one-sided and two-sided, and a mirrored instance.
Scene many_lights() {
    Scene scene;
    RandomStream random(3, RandomDomain::Test, 0, 0);
    const auto anywhere = [&] { return vec3(random.next(), random.next(), random.next()) - 0.5f; };
    for (int i = 0; i < 300; ++i) {
        const vec3 at = 6.0f * anywhere();
        add(scene, MeshBuilder().triangle(at, at + 0.6f * anywhere(), at + 0.6f * anywhere()).build(0),
            emitting(Rgb(std::exp(4 * random.next()), 1, 2), i % 3 == 0));
    }
    Instance& mirrored = scene.instances[7];
    mirrored.identity = false;
    mirrored.to_world = mat4x3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.5f, 0, 0));
    mirrored.normal_to_world = mat3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
    mirrored.flips_orientation = true;
    for (int i = 0; i < 60; ++i) {
        PunctualLight light;
        light.kind = i % 2 ? PunctualLight::Kind::Spot : PunctualLight::Kind::Point;
        light.intensity = Rgb(random.next(), 2, 1);
        light.position = 6.0f * anywhere();
        light.direction = glm::normalize(anywhere());
        light.cos_inner = std::cos(0.2f + 0.01f * static_cast<float>(i));
        light.cos_outer = std::cos(0.2f + 0.03f * static_cast<float>(i));
        if (i % 3 == 0) light.range_m = 4;
        scene.punctual_lights.push_back(light);
    }
    finish_scene(scene);
    return scene;
}

Scene sky_and_sun() {
    Scene scene;
    add(scene, MeshBuilder().quad(vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1)).build(0),
        lambert(0.5f));
    Environment sky;
    sky.map.size = {37, 19};
    RandomStream random(5, RandomDomain::Test, 0, 0);
    for (size_t i = 0; i < sky.map.size.pixels(); ++i)
        sky.map.radiance.push_back(Rgb(random.next(), random.next(), 1) * (i == 150 ? 300.0f : random.next()));
    sky.scale = 0.7f;
    sky.rotation = 2.6f;
    scene.environment = sky;
    for (const vec3 direction : {vec3(0.3f, -1, 0.2f), vec3(-2, -1, 0)}) {
        PunctualLight sun;
        sun.kind = PunctualLight::Kind::Directional;
        sun.intensity = Rgb(3, 2, 1);
        sun.direction = glm::normalize(direction);
        scene.punctual_lights.push_back(sun);
    }
    finish_scene(scene);
    return scene;
}

Scene everything() {
    Scene scene = sky_and_sun();
    add(scene, MeshBuilder().quad({-0.5f, 1, -0.5f}, {0.5f, 1, -0.5f}, {0.5f, 1, 0.5f}, {-0.5f, 1, 0.5f}).build(0),
        emitting(Rgb(4, 3, 2)));
    PunctualLight point;
    point.position = vec3(0.4f, 0.6f, 0.1f);
    scene.punctual_lights.insert(scene.punctual_lights.begin() + 1, point);
    finish_scene(scene);
    return scene;
}

/// A texture with black texels on a masked surface, seen from both sides.
Scene textured() {
    Scene scene;
    add(scene, MeshBuilder().quad(vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1)).build(0),
        lambert(0.5f));
    Texture texture;
    texture.size = {4, 4};
    for (uint32_t i = 0; i < 16; ++i)
        texture.texels.push_back(i % 3 == 0 ? u8vec4(0, 0, 0, 255) : u8vec4(255 - 10 * i, 40 + 10 * i, 128, 255));
    Texture cut;
    cut.size = {3, 1};
    cut.nearest = true;
    cut.texels = {u8vec4(255, 255, 255, 255), u8vec4(255, 255, 255, 0), u8vec4(255, 255, 255, 255)};
    scene.textures = {texture, cut};
    Material material = emitting(Rgb(5, 4, 3), true);
    material.base_color = Rgb(1);
    material.emission_texture.texture = 0;
    material.base_color_texture.texture = 1;
    material.alpha_mode = AlphaMode::Mask;
    add(scene, MeshBuilder().quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}).build(0, true), material);
    finish_scene(scene);
    return scene;
}

Scene dark() {
    Scene scene;
    add(scene, MeshBuilder().quad(vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1)).build(0),
        lambert(0.5f));
    finish_scene(scene);
    return scene;
}

struct LitScene {
    const char* name;
    Scene (*make)();
};
void PrintTo(const LitScene& lit, std::ostream* out) { *out << lit.name; }

const LitScene kScenes[] = {
    {"CornellBox", cornell_box},
    {"CornellBoxSpot", cornell_box_spot},
    {"ManyLights", many_lights},
    {"SkyAndSun", sky_and_sun},
    {"Everything", everything},
    {"Textured", textured},
    {"Dark", dark},
};

/// Points about the scene, with normals or without.
std::vector<LightQuery> random_queries(const Scene& scene, size_t count) {
    RandomStream random(17, RandomDomain::Test, 0, 0);
    const vec3 centre = scene.bounds.centre(), size = scene.bounds.diagonal() + 0.3f * scene.bounds.radius();
    std::vector<LightQuery> queries(count);
    for (size_t i = 0; i < count; ++i) {
        LightQuery& q = queries[i];
        q.p = centre + size * (vec3(random.next(), random.next(), random.next()) - 0.5f);
        const vec3 n = vec3(random.next(), random.next(), random.next()) - 0.5f;
        q.n = i % 4 == 0 ? vec3(0) : glm::normalize(n);
        q.u_select = random.next();
        q.u = random.next_2d();
    }
    return queries;
}

// --- comparing ---------------------------------------------------------------------------------------------------

/// Relative difference of two numbers or vectors.
double difference(float a, float b) {
    if (a == b) return 0;  // infinite ones too
    return std::fabs(double{a} - double{b}) / std::max(std::fabs(double{a}), std::fabs(double{b}));
}
double difference(const vec3& a, const vec3& b) {
    const double largest = std::max(glm::length(a), glm::length(b));
    return largest > 0 ? double{glm::length(a - b)} / largest : 0;
}

/// How far apart samples are: nearly all within rounding, and none further than where a map loses half its digits (near
/// a corner of a spherical triangle, at the rim of a spot's cone, where an environment rises steeply).
class Differences {
public:
    Differences(const char* what, double rounding, double most) : what_(what), rounding_(rounding), most_(most) {}
    ~Differences() {
        EXPECT_LE(static_cast<double>(beyond_), kShareBeyond * static_cast<double>(compared_)) << what_;
        EXPECT_LE(largest_, most_) << what_;
    }
    void add(double relative) {
        ++compared_;
        if (!(relative <= rounding_)) ++beyond_;
        if (!(relative <= largest_)) largest_ = relative;
    }

private:
    static constexpr double kShareBeyond = 0.02;  // measured: 1 % at most, of places on the textured panel
    const char* what_;
    double rounding_, most_, largest_ = 0;
    size_t compared_ = 0, beyond_ = 0;
};

constexpr size_t kQueries = 20'000;
// Choices at whose border a number lies within rounding: a few units of 2^-24 for each of the tree's levels.
constexpr size_t kChosenOtherwise = 4;

class GpuLights : public testing::TestWithParam<LitScene> {};

/// The second one where there is an environment.
std::vector<EnvironmentDensity> densities_of(const Scene& scene) {
    if (!scene.environment) return {EnvironmentDensity::Radiance};
    return {EnvironmentDensity::Radiance, EnvironmentDensity::Compensated};
}

void expect_samples_alike(const Scene& scene, EnvironmentDensity density) {
    const std::vector<LightQuery> queries = random_queries(scene, kQueries);
    const auto host = HostLights(scene, density).sample(queries), device = DeviceLights(scene, density).sample(queries);
    Differences wi("direction", 1e-5, 5e-3), target("target", 1e-5, 5e-3);
    Differences pdf("density", 1e-5, 1e-3), radiance("radiance", 1e-4, 0.1);
    size_t chosen_otherwise = 0;
    for (size_t i = 0; i < kQueries; ++i) {
        if (host[i].has_value() != device[i].has_value() || (host[i] && host[i]->source != device[i]->source)) {
            ++chosen_otherwise;
            continue;
        }
        if (!host[i]) continue;
        const LightSample &a = *host[i], &b = *device[i];
        ASSERT_EQ(a.delta, b.delta);
        wi.add(difference(a.wi, b.wi));
        pdf.add(difference(a.pdf_sa, b.pdf_sa));
        radiance.add(difference(a.radiance_over_pdf, b.radiance_over_pdf));
        ASSERT_EQ(a.distance < kInfinity, b.distance < kInfinity);
        if (a.distance < kInfinity) target.add(glm::length(a.target - b.target) / double{a.distance});
    }
    EXPECT_LE(chosen_otherwise, kChosenOtherwise);
}

TEST_P(GpuLights, DirectLightIsSampledAlike) {
    const Scene scene = GetParam().make();
    for (const EnvironmentDensity density : densities_of(scene)) expect_samples_alike(scene, density);
}

void expect_densities_alike(const Scene& scene, EnvironmentDensity density) {
    const HostLights host_lights(scene, density);
    std::vector<LightPdfQuery> queries;
    RandomStream random(19, RandomDomain::Test, 0, 0);
    for (const LightQuery& q : random_queries(scene, kQueries)) {
        const float z = 1 - 2 * random.next(), azimuth = 2 * kPi * random.next(), r = std::sqrt(1 - z * z);
        LightPdfQuery query{q.p, q.n, vec3(r * std::cos(azimuth), r * std::sin(azimuth), z)};
        query.instance = std::min(static_cast<uint32_t>(random.next() * static_cast<float>(scene.instances.size())),
                                  static_cast<uint32_t>(scene.instances.size() - 1));
        const size_t triangles = scene.meshes[scene.instances[query.instance].mesh].triangles.size();
        query.triangle = static_cast<uint32_t>(random.next() * static_cast<float>(triangles));
        query.distance = 0.1f + 5 * random.next();
        queries.push_back(query);
    }
    const auto host = host_lights.pdfs(queries), device = DeviceLights(scene, density).pdfs(queries);
    Differences triangle("triangles", 1e-5, 1e-3), environment("environment's density", 1e-5, 1e-3);
    Differences radiance("environment", 1e-4, 0.1);
    for (size_t i = 0; i < kQueries; ++i) {
        triangle.add(difference(host[i].triangle, device[i].triangle));
        environment.add(difference(host[i].environment, device[i].environment));
        radiance.add(difference(host[i].environment_radiance, device[i].environment_radiance));
    }
}

TEST_P(GpuLights, DensitiesAndTheEnvironmentAreAlike) {
    const Scene scene = GetParam().make();
    for (const EnvironmentDensity density : densities_of(scene)) expect_densities_alike(scene, density);
}

TEST_P(GpuLights, LightPathsStartAlike) {
    const Scene scene = GetParam().make();
    const HostEmission host_emission(scene);
    const DeviceEmission device_emission(scene);
    ASSERT_EQ(host_emission.lights(), device_emission.lights());
    for (uint32_t light = 0; light < host_emission.lights(); ++light) {
        EXPECT_EQ(host_emission.probability(light), device_emission.probability(light));
        EXPECT_EQ(host_emission.guided_by_position(light), device_emission.guided_by_position(light));
    }
    RandomStream random(23, RandomDomain::Test, 0, 0);
    std::vector<EmissionQuery> queries = emission_queries(kQueries, random);
    for (size_t i = 0; i < kQueries && host_emission.lights() > 0; i += 2) {  // every second is of a light given
        queries[i].light = static_cast<uint32_t>(i / 2) % host_emission.lights();
        queries[i].probability = 0.1f + random.next();
    }
    const auto host = host_emission.sample(queries), device = device_emission.sample(queries);
    Differences origin("origin", 1e-5, 1e-3), direction("direction", 1e-5, 5e-3), power("power", 1e-4, 0.1);
    for (size_t i = 0; i < kQueries; ++i) {
        // The light is chosen by exact numbers: both choose the same.
        ASSERT_EQ(host[i].has_value(), device[i].has_value());
        if (!host[i]) continue;
        const EmissionSample &a = *host[i], &b = *device[i];
        ASSERT_EQ(a.light, b.light);
        ASSERT_EQ(a.source, b.source);
        ASSERT_EQ(a.range_m, b.range_m);
        origin.add(double{glm::length(a.ray.origin - b.ray.origin)} / double{scene.bounds.radius()});
        direction.add(difference(a.ray.direction, b.ray.direction));
        power.add(difference(a.power_w, b.power_w));
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GpuLights, testing::ValuesIn(kScenes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(GpuLightTables, AnglesAreGoodToAFewUnits) {
    struct Answer {
        float angle;
        vec2 sin_cos;
    };
    RandomStream random(29, RandomDomain::Test, 0, 0);
    std::vector<vec2> points = {vec2(0), {0, 1}, {0, -1}, {1, 0}, {-1, 0}, {1, 1}, {-1, -1}, {1, -0.0f}, {-1, -0.0f}};
    for (int i = 0; i < 50'000; ++i) {
        const float x = 2 * random.next() - 1, y = 2 * random.next() - 1;
        points.push_back(vec2(x * (i % 2 ? 8.0f : std::exp2(-20 * random.next())), y));
    }
    const auto answers = run_twin<Answer>("tests/gpu/angles.comp", points.size(), {{"points", points}});
    double angle = 0, sines = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        const double x = points[i].x, y = points[i].y;
        angle = std::max(angle, difference(answers[i].angle, static_cast<float>(std::atan2(y, x))));
        sines = std::max({sines, std::fabs(double{answers[i].sin_cos.x} - std::sin(x)),
                          std::fabs(double{answers[i].sin_cos.y} - std::cos(x))});
    }
    EXPECT_LT(angle, 4 * 0x1p-23);  // of the angle: four units in the last place at most
    EXPECT_LT(sines, 3 * 0x1p-24);  // of 1: three
}

}  // namespace
}  // namespace photond::test::gpu_lights_test
