// One small room in many guises that must all show the same image, and walls that must let nothing through.

#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr const char* kRoom = "near-origin";
constexpr uint32_t kBounces = 2;
const Rgb kLampRadiance(4, 3.5f, 3);  // times 1e8 still what a film can hold

/// A floor, three walls, a box and a lamp over it; open above and in front.
Scene room() {
    Scene scene;
    const uint32_t grey = add_material(scene, lambert("grey", Rgb(0.7f)));
    const uint32_t red = add_material(scene, lambert("red", {0.6f, 0.1f, 0.1f}));
    const uint32_t green = add_material(scene, lambert("green", {0.1f, 0.5f, 0.15f}));
    const uint32_t lamp = add_material(scene, emitter("lamp", kLampRadiance));
    add_mesh(scene, level_rectangle(-1, 1, -1, 1, 0, true, grey));
    add_mesh(scene, MeshBuilder().quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}).build(grey));
    add_mesh(scene, MeshBuilder().quad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}).build(red));
    add_mesh(scene, MeshBuilder().quad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1}).build(green));
    add_mesh(scene, MeshBuilder().box({-0.4f, 0, -0.5f}, {0.2f, 0.7f, 0.1f}).build(grey));
    add_mesh(scene, level_rectangle(-0.3f, 0.3f, -0.3f, 0.3f, 1.75f, false, lamp));
    add_camera(scene, {0.2, 1.1, 3.2}, {0, 0.85, 0}, 0.6f);
    return scene;
}

/// Moves every point of the room, the camera's place too.
template <class Move>
Scene moved_room(const Move& move) {
    Scene scene = room();
    for (Mesh& mesh : scene.meshes)
        for (vec3& p : mesh.positions) p = move(p);
    for (Camera& camera : scene.cameras) camera.position = move(camera.position);
    return scene;
}

Scene scaled_room(float scale) {
    Scene scene = moved_room([scale](const vec3& p) { return scale * p; });
    for (Camera& camera : scene.cameras) camera.focus_distance_m *= scale;
    return scene;
}

/// 1e5 m away and between the numbers that a float can say there (1/128 m apart). As the loader has it: placed in
/// double, less an origin of whole metres, and only then rounded.
Scene far_room() {
    const dvec3 place(100'000.3, -70'000.1, 50'000.7), origin = glm::round(place);
    Scene scene = moved_room([&](const vec3& p) { return vec3(dvec3(p) + place - origin); });
    scene.origin = origin;
    return scene;
}

/// Every triangle cut along one side into strips and, between them, slivers whose width is 1e-6 of the triangle's.
Scene sliver_room() {
    constexpr int kStrips = 8;
    constexpr float kSliver = 1e-6f;
    Scene scene = room();
    for (Mesh& mesh : scene.meshes) {
        const Mesh whole = mesh;
        MeshBuilder cut;
        for (const uvec3& t : whole.triangles) {
            const vec3 a = whole.positions[t.x], b = whole.positions[t.y], c = whole.positions[t.z];
            const auto strip = [&](float from, float to) {  // shares of the way to c
                const vec3 a0 = a + from * (c - a), b0 = b + from * (c - b);
                const vec3 a1 = a + to * (c - a), b1 = b + to * (c - b);
                cut.triangle(a0, b0, b1);
                if (to < 1) cut.triangle(a0, b1, a1);
            };
            for (int i = 0; i < kStrips; ++i) {
                const float from = static_cast<float>(i) / kStrips, to = static_cast<float>(i + 1) / kStrips;
                strip(from, from + kSliver), strip(from + kSliver, to);
            }
        }
        mesh = cut.build(whole.material);
    }
    return scene;
}

/// Everything but the lamp twice in the same place.
Scene doubled_room() {
    Scene scene = room();
    const std::vector<Mesh> meshes = scene.meshes;
    for (const Mesh& mesh : meshes)
        if (!scene.materials[mesh.material].emissive()) add_mesh(scene, mesh);
    return scene;
}

Scene relit_room(float scale) {
    Scene scene = room();
    for (Material& material : scene.materials) material.emission *= scale;
    return scene;
}

HardCase same_room(const char* name, const char* row, const char* strains, const char* text, double scale,
                   std::function<Scene()> make) {
    return {std::string(kPrefix) + name,
            {.row = row, .strains = strains, .text = text, .checks = {same_as("beauty", kRoom, scale, kBounces)}},
            std::move(make)};
}

/// Two closed rooms side by side, one lit and one dark; the wall between them is `thickness` of the scene's length.
Scene thin_wall(float thickness) {
    Scene scene;
    constexpr float kLength = 3, kWall = 0.5f;
    const uint32_t grey = add_material(scene, lambert("grey", Rgb(0.7f)));
    const uint32_t lamp = add_material(scene, emitter("lamp", kLampRadiance));
    add_mesh(scene, inward_box({-1, 0, -0.5f}, {kWall, 1, 0.5f}, grey));
    add_mesh(scene, inward_box({kWall + thickness * kLength, 0, -0.5f}, {2, 1, 0.5f}, grey));
    add_mesh(scene, level_rectangle(-0.2f, 0.3f, -0.25f, 0.25f, 0.99f, false, lamp));
    add_camera(scene, {1.8, 0.6, 0.1}, {kWall, 0.4, 0}, 0.8f);
    return scene;
}

}  // namespace

void add_room_cases(std::vector<HardCase>& cases) {
    constexpr std::pair<const char*, float> kWalls[] = {
        {"thin-wall-1e-3", 1e-3f}, {"thin-wall-1e-4", 1e-4f}, {"thin-wall-1e-5", 1e-5f}};
    for (const auto& [name, thickness] : kWalls)
        cases.push_back({std::string(kPrefix) + name,
                         {.row = "thin wall, 1e-3 .. 1e-5 of the scene",
                          .strains = "light leaking through voxels, kernels, depth maps",
                          .text = "a closed room beside a lit one: no light",
                          .checks = {zero("beauty", kBounces)},
                          .passes = 16},
                         [thickness = thickness] { return thin_wall(thickness); }});

    constexpr const char* kFar = "far from the origin";
    cases.push_back({std::string(kPrefix) + kRoom,
                     {.row = kFar,
                      .strains = "what the same room elsewhere is held against",
                      .text = "a room as path tracing has it",
                      .checks = {reference("beauty", kBounces)}},
                     room});
    cases.push_back(same_room("far-origin", kFar, "float cancellation in rays, voxels, hashes",
                              "the room 1e5 m away, re-centred in double: the same image", 1, far_room));
    constexpr const char* kScale = "tiny (1e-4) and huge (1e6) scenes";
    cases.push_back(same_room("tiny", kScale, "absolute epsilons", "the room 1e-4 as large: the same image", 1,
                              [] { return scaled_room(1e-4f); }));
    cases.push_back(same_room("huge", kScale, "absolute epsilons", "the room 1e6 times as large: the same image", 1,
                              [] { return scaled_room(1e6f); }));
    cases.push_back(same_room("slivers", "needle and sliver triangles, aspect 1e6",
                              "normals, sampling by area, voxelisation", "the room cut into slivers: the same image", 1,
                              sliver_room));
    cases.push_back(same_room("coplanar-duplicates", "coplanar duplicate surfaces",
                              "ties in traversal, double counting", "the room's surfaces twice: the same image", 1,
                              doubled_room));
    constexpr const char* kRange = "light of 1e-6 and of 1e8, dynamic range 1e14 in one image";
    cases.push_back(same_room("dim-light", kRange, "termination by absolute thresholds",
                              "the room's lamp times 1e-6: the image times 1e-6", static_cast<double>(1e-6f),
                              [] { return relit_room(1e-6f); }));
    cases.push_back(same_room("bright-light", kRange, "overflow of halves and sums",
                              "the room's lamp times 1e8: the image times 1e8", 1e8, [] { return relit_room(1e8f); }));
    cases.push_back({std::string(kPrefix) + "keyhole",
                     {.row = "keyhole: light in the next room",
                      .strains = "sampling that rarely succeeds",
                      .text = "indirect light as path tracing has it",
                      .checks = {reference("indirect", 4)},
                      .passes = 256},
                     make_keyhole});
}

}  // namespace photond
