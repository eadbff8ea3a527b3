// Scenes in which there is nothing to divide by, and cameras where none should be.

#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr const char* kNothing = "one photon; zero photons; no light; black scene; all-mirror scene; closed dark box";
constexpr const char* kCameras = "camera inside glass, on a surface, inside a light";
const Rgb kLampRadiance(4, 2, 1);

void add_lamp(Scene& scene) {
    add_mesh(scene, level_rectangle(-0.5f, 0.5f, -0.5f, 0.5f, 0.9f, false,
                                    add_material(scene, emitter("lamp", kLampRadiance))));
}

/// The inside of a box of 2 m, seen from a place near its front.
Scene box_interior(const Material& walls) {
    Scene scene;
    add_mesh(scene, inward_box(vec3(-1), vec3(1), add_material(scene, walls)));
    add_camera(scene, {0.1, 0.2, 0.9}, {0, -0.1, -1}, 1.0f);
    return scene;
}

Scene no_light() { return box_interior(lambert("grey", Rgb(0.5f))); }

Scene black() {
    Scene scene = box_interior(lambert("black", Rgb(0)));
    add_lamp(scene);
    return scene;
}

Scene all_mirror() {
    Scene scene = box_interior(metal("mirror", Rgb(0.9f), 0));
    add_lamp(scene);
    return scene;
}

/// All light is outside.
Scene dark_box() {
    Scene scene = box_interior(lambert("grey", Rgb(0.5f)));
    add_mesh(scene, level_rectangle(-1, 1, -1, 1, 2, false, add_material(scene, emitter("lamp", kLampRadiance))));
    add_directional_light(scene, {-0.3f, -1, -0.5f}, kLampRadiance);
    return scene;
}

Scene camera_in_glass() {
    Scene scene;
    add_mesh(scene, inward_box(vec3(-2), vec3(2), add_material(scene, emitter("sky", Rgb(1)))));
    add_mesh(scene, MeshBuilder().sphere({0, 0, 0}, 0.5f, 48).build(add_material(scene, glass("glass"))));
    add_camera(scene, {0.1, 0.05, 0}, {0, 0, -1}, 1.0f);
    return scene;
}

Scene camera_on_surface() {
    Scene scene = box_interior(lambert("grey", Rgb(0.5f)));
    add_lamp(scene);
    scene.cameras.clear();
    add_camera(scene, {0.3, -1, 0.4}, {0, 0, -1}, 1.0f);
    return scene;
}

Scene camera_in_light(bool two_sided) {
    Scene scene;
    Material lamp = emitter("lamp", kLampRadiance);
    lamp.double_sided = two_sided;
    add_mesh(scene, MeshBuilder().box(vec3(-1), vec3(1)).build(add_material(scene, lamp)));
    add_camera(scene, {0.1, 0.2, 0.3}, {0, -0.1, -1}, 1.0f);
    return scene;
}

HardCase scene_case(const char* name, const char* row, const char* strains, const char* text,
                    std::vector<KnownCheck> checks, std::function<Scene()> make) {
    return {std::string(kPrefix) + name,
            {.row = row, .strains = strains, .text = text, .checks = std::move(checks), .passes = 16},
            std::move(make)};
}

HardCase tested_elsewhere(const char* name, const char* row, const char* strains, const char* text) {
    return {.name = std::string(kPrefix) + name,
            .answer = {.row = row, .strains = strains, .text = text},
            .test = "unit_worker HardLimits"};
}

}  // namespace

void add_degenerate_cases(std::vector<HardCase>& cases) {
    const char* const kDivision = "division by nothing";
    cases.push_back(scene_case("no-light", kNothing, kDivision, "a closed grey box without light: black",
                               {zero("beauty", 2)}, no_light));
    cases.push_back(scene_case("black", kNothing, kDivision, "a lamp in a black box: only the lamp is seen",
                               {zero("direct", 2), zero("indirect", 2), finite()}, black));
    cases.push_back(scene_case("all-mirror", kNothing, "no surface to leave a photon on",
                               "a lamp in a box of mirrors: nothing but the lamp and its images",
                               {zero("direct", 2), zero("indirect", 2), finite()}, all_mirror));
    cases.push_back(scene_case("dark-box", kNothing, "light that reaches nothing",
                               "a closed grey box, all light outside of it: black", {zero("beauty", 2)}, dark_box));
    cases.push_back(tested_elsewhere("few-photons", kNothing, kDivision,
                                     "a pass of one photon is defined and finite; zero photons are refused"));

    cases.push_back(tested_elsewhere("million-passes", "a million passes of a constant", "accumulation drift",
                                     "the film's mean and variance after 2^20 passes are exact to 1e-6"));
    cases.push_back(tested_elsewhere(
        "crowded-cell", "1e8 photons in one voxel / one pixel", "counters, capacity, overflow of 32 bits",
        "1e8 photons in a pixel of every pass: the mean is preserved; a million photons at "
        "one point: all found"));
    // The loader poses nothing yet: a job's time must be 0 for an animated file. What can go stale is tested with a
    // scene for each frame.
    cases.push_back(tested_elsewhere("animated-thin-object", "animated thin object passing",
                                     "stale structures between frames",
                                     "a frame rendered after others equals the frame rendered alone; a time other than "
                                     "0 is refused while animation is not built"));

    cases.push_back(scene_case("camera-in-glass", kCameras, "origin handling",
                               "from within a ball of glass, in uniform light: finite", {finite()}, camera_in_glass));
    cases.push_back(scene_case("camera-on-surface", kCameras, "self-hits", "from a point of the floor: finite",
                               {finite()}, camera_on_surface));
    cases.push_back(scene_case("camera-in-light", kCameras, "origin handling",
                               "from within a lamp that emits outwards: black", {zero("beauty", 2)},
                               [] { return camera_in_light(false); }));
    cases.push_back(scene_case("camera-in-two-sided-light", kCameras, "origin handling",
                               "from within a lamp that emits to both sides: its radiance",
                               {equals("emitted", dvec3(kLampRadiance), 2), zero("direct", 2), zero("indirect", 2)},
                               [] { return camera_in_light(true); }));
}

}  // namespace photond
