// What path tracing promises beside the right light: bits that do not depend on threads or cuts, layers, counts,
// filters, cancellation, memory; and that its two shading paths agree.

#include "renderer/methods/path_tracing/path_tracing.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

#include "protocol/error.h"
#include "renderer/eye/pixel_filter.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/threads.h"

namespace photond::path_tracing_test {
namespace {

LayerSet all_layers() {
    LayerSet layers;
    for (const Layer layer :
         {Layer::Caustic, Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth, Layer::GeometricNormal})
        layers.add(layer);
    return layers;
}

test::RenderSettings settings_for(uint32_t passes) {
    test::RenderSettings settings;
    settings.size = {70, 50};  // tiles cut at both edges
    settings.passes = passes;
    settings.layers = all_layers();
    return settings;
}

TEST(PathTracing, PixelHashIsTheSameForAnyNumberOfThreads) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        const Scene scene = make_builtin_scene(name);
        std::vector<std::string> hashes;
        for (const int threads : {1, 2, 8})
            hashes.push_back(
                test::on_threads(threads, [&] { return test::render(scene, settings_for(3)).pixel_hash(); }));
        EXPECT_EQ(hashes[0], hashes[1]) << name;
        EXPECT_EQ(hashes[0], hashes[2]) << name;
    }
}

TEST(PathTracing, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    test::RenderSettings settings = settings_for(1);
    settings.first_pass = 5;
    const Film alone = test::render(scene, settings), again = test::render(scene, settings);
    EXPECT_EQ(alone, again);
    settings.first_pass = 6;
    EXPECT_NE(alone.pixel_hash(), test::render(scene, settings).pixel_hash());
    settings.first_pass = 5;
    settings.seed = 2;
    EXPECT_NE(alone.pixel_hash(), test::render(scene, settings).pixel_hash());
}

// The same numbers drive both; only rounding differs, which now and then sends a path elsewhere.
TEST(PathTracing, LanesAndSinglePathsShadeAlike) {
    const Scene lanes = test::turned(make_builtin_scene("cornell-box"));
    Scene single = test::turned(make_builtin_scene("cornell-box"));
    Texture flat;  // a normal map that changes nothing asks for the general shading
    flat.size = {1, 1};
    flat.texels = {{128, 128, 255, 255}};
    single.textures.push_back(flat);
    for (Material& m : single.materials) {
        m.normal_texture.texture = int32_t(single.textures.size() - 1);
        m.normal_scale = 0;
    }
    finish_scene(single);
    const Film a = test::render(lanes, settings_for(4)), b = test::render(single, settings_for(4));
    for (const Layer layer :
         {Layer::Emitted, Layer::Direct, Layer::Indirect, Layer::Albedo, Layer::Normal, Layer::GeometricNormal}) {
        const std::vector<float> x = a.resolve(layer), y = b.resolve(layer);
        size_t different = 0;
        for (size_t i = 0; i < x.size(); ++i) different += std::abs(x[i] - y[i]) > 1e-3f * (1e-3f + std::abs(x[i]));
        EXPECT_LT(different, x.size() / 100) << layer_info(layer).name;
    }
}

TEST(PathTracing, AuxiliaryLayersDescribeTheFirstSurface) {
    Scene scene = make_builtin_scene("cornell-box");
    scene.origin = dvec3(1000, 0, 0);
    const test::RenderSettings settings = settings_for(4);
    const Film film = test::render(scene, settings);
    const auto albedo = film.resolve(Layer::Albedo), normal = film.resolve(Layer::Normal),
               position = film.resolve(Layer::Position), depth = film.resolve(Layer::Depth);
    const size_t floor = 46 * 70 + 35;  // a pixel of the floor in front, next to the bottom edge
    EXPECT_NEAR(albedo[3 * floor], 0.725f, 1e-5f);
    EXPECT_NEAR(albedo[3 * floor + 2], 0.68f, 1e-5f);
    EXPECT_NEAR(normal[3 * floor + 1], 1, 1e-5f);
    EXPECT_NEAR(position[3 * floor + 1], 0, 1e-4f);
    EXPECT_NEAR(position[3 * floor], 1000, 0.2f);
    // The camera of the box looks along -z from z = 8.
    EXPECT_NEAR(depth[floor], 8 - position[3 * floor + 2], 1e-3f);
}

// A coarse sphere: its facets are seen in one layer, its smooth normals in the other. Both of Lambert's kernel, eight
// lanes at once, and of the one for all materials.
TEST(PathTracing, TheGeometricNormalIsThatOfTheTriangle) {
    for (const float metallic : {0.0f, 1.0f}) {
        Scene scene;
        Material ball;
        ball.metallic = metallic, ball.specular = 0;
        scene.materials = {ball};
        scene.meshes = {MeshBuilder().sphere({0, 0, -4}, 1, 8).build(0)};
        scene.instances.resize(1);
        scene.cameras = {Camera{}};
        finish_scene(scene);
        const Film film = test::render(scene, settings_for(1));
        const std::vector<float> smooth = film.resolve(Layer::Normal), flat = film.resolve(Layer::GeometricNormal),
                                 position = film.resolve(Layer::Position), depth = film.resolve(Layer::Depth);
        std::set<std::array<float, 3>> facets;
        double least_cosine = 1;
        for (size_t i = 0; i < depth.size(); ++i) {
            if (depth[i] == 0) continue;
            const vec3 n(smooth[3 * i], smooth[3 * i + 1], smooth[3 * i + 2]);
            const vec3 g(flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]);
            const vec3 at(position[3 * i], position[3 * i + 1], position[3 * i + 2]);
            EXPECT_NEAR(glm::length(g), 1, 1e-5f);
            EXPECT_LT(glm::dot(g, at), 0) << "it faces the eye, which is at the origin";
            least_cosine = std::min(least_cosine, double(glm::dot(n, g)));
            facets.insert({std::round(g.x * 1e4f), std::round(g.y * 1e4f), std::round(g.z * 1e4f)});
        }
        EXPECT_LT(facets.size(), 64u) << "a facet has one normal";
        EXPECT_GT(facets.size(), 8u);
        EXPECT_LT(least_cosine, 0.99) << "the smooth ones turn within it";
        EXPECT_GT(least_cosine, 0.7);
    }
}

TEST(PathTracing, CausticsArePartOfTheIndirectLight) {
    const Film film = test::render(make_builtin_scene("caustic-ring"), settings_for(32));
    const std::vector<float> caustic = film.resolve(Layer::Caustic), indirect = film.resolve(Layer::Indirect);
    for (size_t i = 0; i < caustic.size(); ++i) EXPECT_LE(caustic[i], indirect[i] * 1.00001f);
    EXPECT_GT(test::mean_of(caustic), 0.01 * test::mean_of(indirect));
    const Film plain = test::render(make_builtin_scene("cornell-box"), settings_for(2));
    EXPECT_EQ(test::mean_of(plain.resolve(Layer::Caustic)), 0);
}

TEST(PathTracing, UnlitSurfacesShowToTheEyeAndLightNothing) {
    Scene scene;
    Material sign, wall;
    sign.unlit = true;
    sign.base_color = Rgb(0.25f, 0.5f, 1);
    wall.specular = wall.metallic = 0;
    scene.materials = {sign, wall};
    scene.meshes = {MeshBuilder().quad({-9, 0, -2}, {9, 0, -2}, {9, 9, -2}, {-9, 9, -2}).build(0),
                    MeshBuilder().quad({-9, -9, -2}, {9, -9, -2}, {9, 0, -2}, {-9, 0, -2}).build(1)};
    scene.instances.resize(2);
    scene.instances[1].mesh = 1;
    scene.cameras = {Camera{}};
    finish_scene(scene);
    test::RenderSettings settings = settings_for(2);
    settings.size = {16, 16};
    const Film film = test::render(scene, settings);
    const std::vector<float> emitted = film.resolve(Layer::Emitted);
    EXPECT_FLOAT_EQ(emitted[3 * (2 * 16 + 8) + 1], 0.5f);
    EXPECT_FLOAT_EQ(emitted[3 * (2 * 16 + 8) + 2], 1.0f);
    EXPECT_EQ(emitted[3 * (13 * 16 + 8)], 0);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Direct)), 0);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Indirect)), 0);
}

// Beer's law through a slab of smooth glass of index 1: what is left is the attenuation colour after its distance.
TEST(PathTracing, SolidsAbsorbByBeersLaw) {
    Scene scene;
    Material glass;
    glass.metallic = glass.roughness = 0;
    glass.transmission = 1;
    glass.solid = true;
    glass.ior = 1;
    glass.specular = 0;
    glass.attenuation_color = Rgb(0.5f, 0.25f, 1);
    glass.attenuation_distance = 2;
    scene.materials = {glass};
    scene.meshes = {MeshBuilder().box({-9, -9, -6}, {9, 9, -5}).build(0)};
    scene.instances.resize(1);
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(1));
    scene.environment = sky;
    Camera camera;
    camera.yfov = 0.01f;  // straight on: one metre of glass
    scene.cameras = {camera};
    finish_scene(scene);
    test::RenderSettings settings = settings_for(1);
    settings.size = {8, 8};
    const std::vector<float> emitted = test::render(scene, settings).resolve(Layer::Emitted);
    EXPECT_NEAR(emitted[0], std::sqrt(0.5f), 1e-3f);
    EXPECT_NEAR(emitted[1], 0.5f, 1e-3f);
    EXPECT_NEAR(emitted[2], 1, 1e-3f);
}

TEST(PathTracing, ACancelledPassLeavesNothing) {
    const Scene scene = make_builtin_scene("cornell-box");
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    PathTracing method({});
    method.begin({scene, intersector.get(), View{find_camera(scene, ""), {64, 64}}, 1, budget}, stats);
    Film film({64, 64}, {});
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    EXPECT_EQ(stats.counts.camera_rays, 64u * 64u);
    EXPECT_GT(stats.counts.bounce_rays, 0u);
    EXPECT_GT(stats.counts.shadow_rays, 0u);
    for (const char* stage : {"g_buffer", "direct", "indirect"}) EXPECT_GT(stats.stage(stage).cpu_seconds, 0) << stage;
    EXPECT_GT(budget.structures().at("pass_image"), 64u * 64u * 36u - 1);
}

TEST(PathTracing, RefusesAFilmThatDoesNotFit) {
    const Scene scene = make_builtin_scene("cornell-box");
    MemoryBudget budget(1 << 20);
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    PathTracing method({});
    EXPECT_THROW(method.begin({scene, intersector.get(), View{find_camera(scene, ""), {4096, 4096}}, 1, budget}, stats),
                 Error);
}

TEST(PathTracing, IsInTheListOfMethods) {
    const MethodInfo* info = find_method("path_tracing");
    ASSERT_NE(info, nullptr);
    EXPECT_TRUE(info->mergeable);
    EXPECT_NE(info->make(*info->make_params()), nullptr);
    EXPECT_EQ(find_method("nosuch"), nullptr);
}

// Second moments of the offsets, of the filters as they are defined (pixels^2, one axis): box 1/12; the Gaussian's and
// Blackman-Harris' by quadrature of their formulas over +-1.5.
TEST(PixelFilter, OffsetsFollowTheFilter) {
    const auto second_moment = [](auto&& density) {
        double sum = 0, moment = 0;
        for (double x = -1.4995; x < 1.5; x += 0.001) sum += density(x), moment += x * x * density(x);
        return moment / sum;
    };
    const double gaussian = second_moment([](double x) { return std::exp(-2 * x * x); });
    const double blackman_harris = second_moment([](double x) {
        const double phase = 3.14159265358979 * (x / 1.5 + 1);
        return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) - 0.01168 * std::cos(3 * phase);
    });
    for (const auto& [filter, exact] : {std::pair{PixelFilter::Box, 1.0 / 12},
                                        {PixelFilter::Gaussian, gaussian},
                                        {PixelFilter::BlackmanHarris, blackman_harris}}) {
        const PixelFilterSampler sampler(filter);
        constexpr int kSteps = 20000;
        double mean = 0, moment = 0;
        for (int i = 0; i < kSteps; ++i) {
            const double x = sampler(vec2((float(i) + 0.5f) / kSteps, 0.5f)).x - 0.5;
            mean += x / kSteps, moment += x * x / kSteps;
        }
        EXPECT_NEAR(mean, 0, 1e-3);
        EXPECT_NEAR(moment, exact, 2e-3 * exact + 1e-4);
    }
}

}  // namespace
}  // namespace photond::path_tracing_test
