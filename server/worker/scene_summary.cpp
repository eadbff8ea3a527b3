#include "server/worker/scene_summary.h"

#include <charconv>
#include <cmath>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/scene/movers.h"
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

/// The camera as a job's "look_at". An orthographic one becomes the perspective that shows as much at the target.
json look_at_of(const Scene& scene, const Camera& camera) {
    const float radius = scene.bounds.empty() ? 0 : static_cast<float>(scene.bounds.radius());
    float distance = scene.bounds.empty() ? 0 : glm::dot(vec3(scene.bounds.centre()) - camera.position, camera.forward);
    // The middle is at the eye, or behind it: any distance will do that is of the scene's own size.
    if (!(distance > 1e-3f * radius)) distance = radius > 0 ? radius : 1;
    json up = json::array();
    for (int k = 0; k < 3; ++k) up.push_back(shortest(camera.up[k]));
    return {{"eye", in_file_coordinates(scene, camera.position)},
            {"target", in_file_coordinates(scene, camera.position + distance * camera.forward)},
            {"up", up},
            {"yfov", shortest(camera.orthographic ? 2 * std::atan(camera.ymag / distance) : camera.yfov)}};
}

/// Each animation, how long it takes, and what it moves.
json motion_of(const Scene& scene) {
    json motion = json::array();
    if (!scene.rig) return motion;
    const Rig& rig = *scene.rig;
    const std::vector<Movers> all_movers = count_movers(rig);
    for (uint32_t i = 0; i < rig.animations.size(); ++i) {
        const Movers& movers = all_movers[i];
        motion.push_back({{"index", i},
                          {"name", rig.animations[i].name},
                          {"duration_seconds", rig.animations[i].duration_s()},
                          {"moves",
                           {{"meshes", movers.meshes},
                            {"triangles", movers.triangles},
                            {"cameras", movers.cameras},
                            {"lights", movers.lights},
                            {"materials", movers.materials}}}});
    }
    return motion;
}

}  // namespace

json scene_summary(const Scene& scene, const std::string& name, bool builtin) {
    json cameras = json::array();
    for (const Camera& camera : scene.cameras)
        cameras.push_back({{"name", camera.name},
                           {"yfov", camera.orthographic ? json(nullptr) : json(shortest(camera.yfov))},
                           {"look_at", look_at_of(scene, camera)}});
    json bounds = nullptr;
    if (!scene.bounds.empty())
        bounds = {{"min", in_file_coordinates(scene, scene.bounds.min)},
                  {"max", in_file_coordinates(scene, scene.bounds.max)}};
    json needs = json::object();
    scene.needs.visit([&](const char* need, bool needed) { needs[need] = needed; });
    const float alpha = scene.needs.least_glossy_alpha;
    MemoryBudget held;
    scene.account(held);
    const uint64_t acceleration_bytes = estimate_acceleration_bytes(scene);
    json yield = nullptr;
    if (const auto measured = measure_photon_yield(scene))
        yield = {{"global", measured->global.guided},
                 {"global_unguided", measured->global.unguided},
                 {"caustic", measured->caustic.guided},
                 {"caustic_unguided", measured->caustic.unguided}};
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
            {"default_view", look_at_of(scene, find_camera(scene, ""))},
            {"animations", scene.rig ? scene.rig->animations.size() : 0},
            {"motion", motion_of(scene)},
            {"bounds", bounds},
            {"needs", needs},
            {"least_glossy_alpha", std::isfinite(alpha) ? json(shortest(alpha)) : json()},
            {"photon_yield", yield},
            {"warnings", scene.warnings},
            {"builtin", builtin}};
}

}  // namespace photond
