#pragma once
// A scene in which nothing stands between surfaces: one bounce of light is the same with visibility and without.

#include <string>

#include "renderer/scene/mesh_builder.h"
#include "tests/support/gpu_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// A floor and a wall apart from it, seen by the camera, before a light: "point", "spot", "directional", "area" (two
/// triangles), "two-sided" (of which half the light is lost), or "environment". Or before "none", with the pipelines of
/// "point".
inline Scene floor_and_wall(const std::string& light) {
    Scene scene;
    MeshBuilder floor, wall;
    floor.quad({-2, 0, 0.5f}, {-2, 0, 4}, {2, 0, 4}, {2, 0, 0.5f});
    wall.quad({-2, 0.5f, 0}, {2, 0.5f, 0}, {2, 3, 0}, {-2, 3, 0});
    add(scene, floor.build(0), lambert(0.6f));
    add(scene, wall.build(0), lambert(0.8f));
    scene.cameras.push_back(look_at_camera({0, 3, 7}, {0, 1, 1}, {0, 1, 0}, 0.8f));
    scene.cameras.back().name = "camera";
    PunctualLight punctual;
    punctual.intensity = Rgb(3, 2, 1);
    punctual.position = {0.4f, 2.5f, 3};
    punctual.direction = glm::normalize(vec3(-0.2f, -0.9f, -0.8f));
    punctual.cos_inner = 0.9f, punctual.cos_outer = 0.6f;
    if (light == "point") punctual.kind = PunctualLight::Kind::Point;
    if (light == "spot") punctual.kind = PunctualLight::Kind::Spot;
    if (light == "directional") punctual.kind = PunctualLight::Kind::Directional;
    if (light == "point" || light == "spot" || light == "directional") scene.punctual_lights.push_back(punctual);
    if (light == "area" || light == "two-sided") {
        MeshBuilder lamp;  // above them: it stands between no two points
        lamp.quad({-0.3f, 4.3f, 3}, {0.3f, 4.3f, 3}, {0.3f, 4, 3.3f}, {-0.3f, 4, 3.3f});
        add(scene, lamp.build(0), emitting(Rgb(9, 8, 7), true));
        scene.materials.back().double_sided = light == "two-sided";
    }
    if (light == "environment") {
        Environment environment;
        environment.map.size = {8, 4};
        environment.map.radiance.assign(32, Rgb(1, 0.8f, 0.6f));
        environment.map.radiance[9] = Rgb(6);
        scene.environment = environment;
    }
    finish_scene(scene);
    if (light == "none") scene.needs.punctual_lights = true;
    return scene;
}

inline double mean_of_layer(const Film& film, Layer layer) { return mean_of(film.resolve(layer)); }

/// Of the passes: the mean of the indirect layer of each, rendered by itself. Independent where its sampler is.
template <class M>
RunningMean indirect_of_passes(const SceneOnDevice& where, RenderSettingsOf<M> settings, Stats* stats = nullptr) {
    RunningMean mean;
    MemoryBudget budget;
    Stats own_stats;
    const RenderContext context{where.scene, &where.intersector, view_of(where.scene, settings), settings.seed,
                                budget,      &where.device_scene};
    run_passes_in(
        context, settings,
        [&](M& method, uint32_t pass) {
            Film film(settings.size, settings.layers, pass);
            method.resolve(film);
            mean.add(mean_of_layer(film, Layer::Indirect));
        },
        stats ? *stats : own_stats);
    return mean;
}
template <class M>
RunningMean indirect_of_passes(const Scene& scene, const RenderSettingsOf<M>& settings) {
    RunningMean mean;
    run_passes(scene, settings, [&](M& method, uint32_t pass) {
        Film film(settings.size, settings.layers, pass);
        method.resolve(film);
        mean.add(mean_of_layer(film, Layer::Indirect));
    });
    return mean;
}

/// Their difference in standard errors.
inline double standard_errors_between(const RunningMean& a, const RunningMean& b) {
    return (a.mean() - b.mean()) / std::hypot(a.standard_error(), b.standard_error());
}

}  // namespace photond::test
