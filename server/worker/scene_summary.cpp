#include "server/worker/scene_summary.h"

#include <charconv>

#include "renderer/backends/cpu/embree_intersector.h"
#include "server/worker/photon_yield.h"

namespace photond {

using nlohmann::json;

namespace {

/// A float as the shortest decimal that gives it back, instead of its exact double: 0.7, not 0.699999988079071.
double shortest(float value) {
    char text[32];
    const std::to_chars_result end = std::to_chars(text, text + sizeof text, value);
    double result = static_cast<double>(value);
    std::from_chars(text, end.ptr, result);
    return result;
}

json in_file_coordinates(const Scene& scene, const vec3& p) {
    json point = json::array();
    for (int k = 0; k < 3; ++k)
        point.push_back(scene.origin[k] == 0 ? shortest(p[k]) : scene.origin[k] + static_cast<double>(p[k]));
    return point;
}

}  // namespace

json scene_summary(const Scene& scene, const std::string& name, bool builtin) {
    json cameras = json::array();
    for (const Camera& camera : scene.cameras)
        cameras.push_back(
            {{"name", camera.name}, {"yfov", camera.orthographic ? json(nullptr) : json(shortest(camera.yfov))}});
    json bounds = nullptr;
    if (!scene.bounds.empty())
        bounds = {{"min", in_file_coordinates(scene, scene.bounds.min)},
                  {"max", in_file_coordinates(scene, scene.bounds.max)}};
    json needs = json::object();
    scene.needs.visit([&](const char* need, bool needed) { needs[need] = needed; });
    MemoryBudget held;
    scene.account(held);
    const uint64_t acceleration_bytes = estimate_acceleration_bytes(scene);
    json yield = nullptr;
    if (const auto measured = measure_photon_yield(scene))
        yield = {{"global", measured->global},
                 {"caustic", measured->caustic},
                 {"caustic_unguided", measured->caustic_unguided}};
    return {{"name", name.empty() ? scene.name : name},
            {"bytes", scene.file_bytes},
            {"memory_bytes", held.accounted_bytes() + acceleration_bytes},
            {"acceleration_bytes", acceleration_bytes},
            {"triangles", scene.triangle_count},
            {"vertices", scene.vertex_count},
            {"materials", scene.materials.size()},
            {"textures", scene.textures.size()},
            {"lights",
             {{"area", scene.triangle_lights.size()},
              {"punctual", scene.punctual_lights.size()},
              {"environment", scene.environment.has_value()}}},
            {"cameras", cameras},
            {"animations", scene.animation_count},
            {"bounds", bounds},
            {"needs", needs},
            {"photon_yield", yield},
            {"warnings", scene.warnings},
            {"builtin", builtin}};
}

}  // namespace photond
