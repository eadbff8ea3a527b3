// Light propagation volumes: light neither grows nor dwindles on its way, walls stop it, and finer grids get what comes
// from outside of them.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/counters.h"
#include "renderer/methods/light_propagation_volumes/light_propagation_volumes_gpu.h"
#include "renderer/methods/light_propagation_volumes/propagation_volumes_gpu.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_light_propagation_volumes_test {
namespace {

using Lpv = LightPropagationVolumesGpu;
using Settings = test::RenderSettingsOf<Lpv>;

Settings small_settings(uint32_t passes) {
    Settings settings;
    settings.size = {32, 24};
    settings.passes = passes;
    settings.seed = 5;
    settings.params.vpls = 4096;
    settings.params.map_resolution = 64;
    return settings;
}

double indirect(const test::SceneOnDevice& where, const Settings& settings) {
    return test::mean_of_layer(test::render(where, settings), Layer::Indirect);
}

TEST(PropagationCascades, HoldTheSceneAndLieOnTheirParentsCells) {
    Bounds3 bounds;
    bounds.extend(vec3(-3, 0, 2)), bounds.extend(vec3(9, 4, 7.3f));
    const Camera camera = look_at_camera({8, 1, 3}, {2, 1, 5}, {0, 1, 0}, 0.8f);
    const gpu::PropagationCascades all = make_propagation_cascades(bounds, camera, 24, 3);
    ASSERT_EQ(all.count, 3u);
    const gpu::PropagationGrid& coarse = all.grids[0];
    EXPECT_EQ(coarse.cells.x, 24u);
    EXPECT_LE(coarse.cells.y, 11u) << "no more than the scene takes";
    EXPECT_EQ(all.cells, coarse.cells.x * coarse.cells.y * coarse.cells.z);
    for (int axis = 0; axis < 3; ++axis) {
        const float half = 0.5f * coarse.cell_m, end = coarse.low[axis] + coarse.cell_m * float(coarse.cells[axis]);
        EXPECT_LE(coarse.low[axis] + half, bounds.min[axis]);
        EXPECT_GE(end - half, bounds.max[axis]);
    }
    for (uint32_t i = 1; i < 3; ++i) {
        const gpu::PropagationGrid &parent = all.grids[i - 1], &grid = all.grids[i];
        EXPECT_FLOAT_EQ(2 * grid.cell_m, parent.cell_m);
        EXPECT_EQ(grid.cells, parent.cells);
        const vec3 cells_in = (grid.low - parent.low) / parent.cell_m;
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(cells_in[axis], std::round(cells_in[axis]), 1e-3f);
            EXPECT_GE(cells_in[axis], -1e-3f);
            EXPECT_LE(cells_in[axis] + 0.5f * float(grid.cells[axis]), float(parent.cells[axis]) + 0.501f);
        }
        const vec3 eye = (camera.position - grid.low) / grid.cell_m;
        EXPECT_TRUE(glm::all(glm::greaterThan(eye, vec3(0))) && glm::all(glm::lessThan(eye, vec3(grid.cells))));
    }
    Bounds3 point, far;
    point.extend(vec3(1e6f)), far.extend(vec3(1e6f)), far.extend(vec3(1e6f + 0.1f));
    for (const Bounds3& odd : {Bounds3{}, point, far}) {
        const gpu::PropagationCascades grids = make_propagation_cascades(odd, camera, 8, 4);
        EXPECT_GT(grids.grids[3].cell_m, 0);
        EXPECT_GE(grids.cells, 8u);
        EXPECT_GT(grids.grids[0].low.x + grids.grids[0].cell_m, grids.grids[0].low.x) << "cells lie at one place";
    }
}

/// What leaves all cells [W], by the means of their intensities.
double flux_of(const std::vector<gpu::CellLight>& cells) {
    double sum = 0;
    for (const gpu::CellLight& cell : cells) sum += double{cell.red.x} + double{cell.green.x} + double{cell.blue.x};
    return 4 * std::numbers::pi * sum;
}

/// The light of a small patch in a large empty scene, on its way.
struct Underway {
    explicit Underway(uint32_t steps) {
        Scene scene;
        scene.cameras.push_back(look_at_camera({0, 1, 3}, {0, 0, 0}, {0, 1, 0}, 0.8f));
        const auto patch = [&](const vec3& at) {
            MeshBuilder quad;
            quad.quad(at + vec3(-0.1f, 0, -0.1f), at + vec3(-0.1f, 0, 0.1f), at + vec3(0.1f, 0.05f, 0.1f),
                      at + vec3(0.1f, 0.05f, -0.1f));
            test::add(scene, quad.build(0), test::lambert(0.8f));
        };
        patch(vec3(0)), patch(vec3(-10)), patch(vec3(10));
        PunctualLight light;
        light.kind = PunctualLight::Kind::Spot;
        light.position = {0, 2, 0};
        light.direction = {0, -1, 0};
        light.cos_outer = 0.9999f, light.cos_inner = 1;
        light.intensity = Rgb(100, 50, 20);
        scene.punctual_lights.push_back(light);
        finish_scene(scene);
        const test::SceneOnDevice where(scene);
        const EmissionSampler emission(scene);
        gpu::Device& device = test::gpu_device();
        gpu::Counters counters(device);
        VplTracerGpu tracer(where.device_scene, emission, {.vpls = 500, .map_side = 32}, counters.buffer(), false);
        const gpu::PropagationCascades cascades = make_propagation_cascades(scene.bounds, scene.cameras[0], 24, 1);
        PropagationVolumesGpu volumes(where.device_scene, cascades, tracer.most_lights());
        Stats stats;
        volumes.find_faces(true, stats);
        gpu::CommandList commands(device);
        counters.record_clear(commands);
        tracer.start(1, 0);
        tracer.record_map(commands);
        tracer.record_vpls(commands);
        volumes.record_injection(commands, tracer, 0);
        volumes.record_steps(commands, 0, 0, steps);
        commands.submit();
        commands.wait();
        started = gpu::read_back<gpu::CellLight>(device, volumes.injected(), cascades.cells);
        travelled = gpu::read_back<gpu::CellLight>(device, volumes.volume(), cascades.cells);
        const auto photons = gpu::read_back<ReflectedPhoton>(device, tracer.photons(), tracer.most_lights());
        const uint32_t count =
            gpu::read_back<uint32_t>(device, tracer.state(), REFLECTION_STATE_WORDS)[REFLECTION_PHOTONS];
        for (const uint32_t i : gpu::read_back<uint32_t>(device, tracer.order(), count)) {
            const Rgb power = photons[i].power_w;
            flux_w += double{power.x} + double{power.y} + double{power.z};
        }
    }

    std::vector<gpu::CellLight> started, travelled;
    double flux_w = 0;  // of the lights
};

/// Five cells from the middle of 24 nothing has left the volume, and nothing stands in the way. Where negative parts
/// are cut off, thirty directions stand for all of them: what they miss is under 2 % a step, of one lobe alone (the
/// integral of max(0, 1/4 + cos/2) by them), and less of what comes from several sides.
TEST(GpuLightPropagation, FluxStaysTheSameFromStepToStep) {
    double before = 0;
    for (uint32_t steps = 1; steps <= 5; ++steps) {
        const Underway light(steps);
        ASSERT_GT(light.flux_w, 0);
        EXPECT_NEAR(flux_of(light.started) / light.flux_w, 1, 1e-5);
        const double all = flux_of(light.travelled), of_step = all - before;
        std::printf("step %u: %.4f\n", steps, of_step / light.flux_w);
        EXPECT_NEAR(of_step / light.flux_w, 1, 0.02);
        before = all;
    }
}

TEST(GpuLightPropagation, LightGoesThroughNoWallHoweverThin) {
    for (const char* name : {"hard-case/thin-wall-1e-3", "hard-case/thin-wall-1e-5"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        Settings settings = small_settings(2);
        settings.params.steps = 48;
        EXPECT_EQ(indirect(where, settings), 0) << name;
        settings.params.geometry_volume = false;
        EXPECT_GT(indirect(where, settings), 0) << name;
    }
}

/// The eye is near one end of a long hall whose other end is lit.
TEST(GpuLightPropagation, FinerVolumesGetWhatComesFromOutside) {
    const Scene scene = [] {
        Scene hall;
        const auto quad = [&](const vec3& a, const vec3& b, const vec3& c, const vec3& d) {
            MeshBuilder wall;
            wall.quad(a, b, c, d);
            test::add(hall, wall.build(0), test::lambert(0.7f));
        };
        quad({0, 0, 0}, {0, 0, 3}, {12, 0, 3}, {12, 0, 0});
        quad({0, 3, 0}, {12, 3, 0}, {12, 3, 3}, {0, 3, 3});
        quad({0, 0, 0}, {12, 0, 0}, {12, 3, 0}, {0, 3, 0});
        quad({0, 0, 3}, {0, 3, 3}, {12, 3, 3}, {12, 0, 3});
        quad({12, 0, 0}, {12, 0, 3}, {12, 3, 3}, {12, 3, 0});
        quad({0, 0, 0}, {0, 3, 0}, {0, 3, 3}, {0, 0, 3});
        PunctualLight light;
        light.kind = PunctualLight::Kind::Spot;
        light.position = {11, 1.5f, 1.5f};
        light.direction = {-1, 0, 0};
        light.cos_outer = 0.75f, light.cos_inner = 0.9f;
        light.intensity = Rgb(50);
        hall.punctual_lights.push_back(light);
        hall.cameras.push_back(look_at_camera({2.5, 1.5, 1.5}, {0, 1.2, 1.4}, {0, 1, 0}, 0.8f));
        finish_scene(hall);
        return hall;
    }();
    const test::SceneOnDevice where(scene);
    Settings settings = small_settings(4);
    settings.params.bounces = 1;
    settings.params.steps = 64;
    settings.params.resolution = 24;
    const double one = indirect(where, settings);
    settings.params.cascades = 2;
    const double two = indirect(where, settings);
    std::printf("one %.4g, two %.4g\n", one, two);
    EXPECT_GT(one, 0);
    EXPECT_NEAR(two, one, 0.3 * one) << "cells of half the size spread light otherwise, but no less of it";
}

TEST(GpuLightPropagation, SameBitsTwiceAndNothingThatIsNoNumber) {
    for (const char* name : {"cornell-box-glossy", "cornell-box-spot"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        Settings settings = small_settings(2);
        settings.params.cascades = 2;
        settings.layers.add(Layer::Volume);
        const Film film = test::render(where, settings);
        EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << name;
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_GT(test::mean_of_layer(film, Layer::Volume), 0);
    }
}

/// Path tracing is the answer; what is asked is no more than that nothing is off by a factor.
TEST(GpuLightPropagation, ABoxIsAboutAsBrightAsItIs) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    for (const uint32_t bounces : {1u, 254u}) {
        test::RenderSettings traced;
        traced.size = {32, 24};
        traced.passes = 100;
        traced.params.indirect_bounces = bounces;
        const double wanted = test::indirect_of_passes(scene, traced).mean();
        Settings settings = small_settings(4);
        settings.params.bounces = bounces;
        const double found = indirect(where, settings);
        std::printf("%u bounces: %.3f of path tracing\n", bounces, found / wanted);
        EXPECT_NEAR(found, wanted, 0.25 * wanted) << bounces;
    }
}

TEST(GpuLightPropagation, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none");
    const Scene lit = test::floor_and_wall("environment");
    for (const Scene* scene : {&dark, &lit}) {
        const test::SceneOnDevice where(*scene);
        Settings settings = small_settings(1);
        EXPECT_EQ(indirect(where, settings) > 0, scene == &lit);
        settings.params.bounces = 0;
        EXPECT_EQ(indirect(where, settings), 0);
    }
}

TEST(GpuLightPropagation, TakesTheDeviceMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = small_settings(1);
    settings.params.resolution = 32;
    settings.params.cascades = 3;
    settings.size = {160, 120};
    test::expect_device_bytes_as_estimated(where, settings);
}

}  // namespace
}  // namespace photond::gpu_light_propagation_volumes_test
