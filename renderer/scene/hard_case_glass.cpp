// Caustics, refraction at its limits, and lobes that are nearly deltas.

#include "renderer/scene/hard_case_answers.h"
#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr const char* kCaustics = "caustic of a glass sphere; mirror-reflected caustic (SDS); light behind glass";
constexpr const char* kSnell =
    "index of refraction 1 and 1 + 1e-6, total internal reflection, nested and touching dielectrics";
const dvec3 kLight(4, 2, 1);

Material glass_of(float ior) {
    Material material = glass("glass");
    material.ior = ior;
    return material;
}

void add_uniform_light(Scene& scene) {
    add_mesh(scene, inward_box(vec3(-2), vec3(2), add_material(scene, emitter("sky", Rgb(1)))));
}

// ---- caustics

void add_floor_ball_and_lamp(Scene& scene) {
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, lambert("floor", Rgb(0.6f)))));
    add_mesh(scene, MeshBuilder().sphere({0, 0.6f, 0}, 0.5f, 64).build(add_material(scene, glass("glass"))));
    add_mesh(scene, level_rectangle(-0.6f, 0, -0.3f, 0.3f, 3, false,
                                    add_material(scene, emitter("lamp", 10.0f * Rgb(kLight)))));
}

Scene caustic() {
    Scene scene;
    add_floor_ball_and_lamp(scene);
    add_camera(scene, {0.8, 2.4, 2.6}, {0.1, 0.2, 0}, 0.7f);
    return scene;
}

/// The same caustic, seen by way of a mirror behind it only.
Scene caustic_in_mirror() {
    Scene scene;
    add_floor_ball_and_lamp(scene);
    const uint32_t mirror = add_material(scene, metal("mirror", Rgb(0.9f), 0));
    add_mesh(scene, MeshBuilder().quad({-2, 0, -1.5f}, {2, 0, -1.5f}, {2, 3, -1.5f}, {-2, 3, -1.5f}).build(mirror));
    add_camera(scene, {0.5, 2.2, 1.8}, {0.1, 1.3, -1.5}, 0.6f);
    return scene;
}

/// A grey ball within a shell of glass within uniform light. The ball emits what it does not reflect, so that all is in
/// equilibrium [Kirchhoff 1860]: radiance 1 everywhere, whatever the shell reflects to and fro.
Scene light_behind_glass() {
    Scene scene;
    add_uniform_light(scene);
    const uint32_t shell = add_material(scene, glass("shell"));
    add_mesh(scene, MeshBuilder().sphere({0, 0, 0}, 0.9f, 48).build(shell));
    Mesh cavity = MeshBuilder().sphere({0, 0, 0}, 0.8f, 48).build(shell);
    for (uvec3& t : cavity.triangles) std::swap(t.y, t.z);  // the glass lies outside of it
    for (vec3& n : cavity.normals) n = -n;
    add_mesh(scene, std::move(cavity));
    Material grey = lambert("grey", Rgb(0.5f));
    grey.emission = Rgb(0.5f);
    add_mesh(scene, MeshBuilder().sphere({0, 0, 0}, 0.4f, 32).build(add_material(scene, grey)));
    add_camera(scene, {0, 0.3, 1.9}, dvec3(0), 0.9f);
    return scene;
}

// ---- Snell at the limit

/// A ball between a rectangle light and the plane below it.
Scene ball_below_light(float ior) {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, lambert("grey", Rgb(0.5f)))));
    add_mesh(scene,
             level_rectangle(-0.5f, 0.5f, -0.5f, 0.5f, 1, false, add_material(scene, emitter("light", Rgb(kLight)))));
    add_mesh(scene, MeshBuilder().sphere({0.1f, 0.5f, 0}, 0.25f, 48).build(add_material(scene, glass_of(ior))));
    add_camera_down(scene, 0, 0.9f, 0, 0.5f);
    return scene;
}

HardCase invisible_ball(const char* name, const char* text, float ior, double tolerance) {
    const Rectangle view{-0.5, 0.5, -0.5, 0.5};
    return {std::string(kPrefix) + name,
            {.row = kSnell,
             .strains = "refraction that is none",
             .text = text,
             .checks = {equals("beauty", 0.5 * parallel_form_factor(view, view, 1) * kLight, {}, tolerance)}},
            [ior] { return ball_below_light(ior); }};
}

/// A right-angled prism: in through one leg, turned at the hypotenuse at 45 degrees (the critical angle is 41.8), out
/// through the other leg, below which there is a light.
Scene prism() {
    Scene scene;
    const vec3 top[] = {{-1, 1, 0}, {1, 1, 0}}, front[] = {{-1, 0, 0}, {1, 0, 0}}, back[] = {{-1, 0, -1}, {1, 0, -1}};
    add_mesh(scene, MeshBuilder()
                        .quad(front[0], front[1], top[1], top[0])
                        .quad(back[0], back[1], front[1], front[0])
                        .quad(top[0], top[1], back[1], back[0])
                        .triangle(back[0], front[0], top[0])
                        .triangle(front[1], back[1], top[1])
                        .build(add_material(scene, glass("glass"))));
    add_mesh(scene, level_rectangle(-2, 2, -3, 2, -1, true, add_material(scene, emitter("light", Rgb(kLight)))));
    add_orthographic_camera(scene, {0, 0.5, 3}, {0, 0.5, 0}, {0, 1, 0}, 0.2f);
    return scene;
}

/// Two faces met head-on with a lossless turn between: a slab, (1 - R) / (1 + R) with all reflections to and fro.
dvec3 prism_radiance() {
    constexpr double kR = 0.04;  // ((1.5 - 1) / (1.5 + 1))^2
    return (1 - kR) / (1 + kR) * kLight;
}

Scene nested() {
    Scene scene;
    add_uniform_light(scene);
    add_mesh(scene, MeshBuilder().sphere({0, 0, 0}, 0.6f, 48).build(add_material(scene, glass_of(1.5f))));
    add_mesh(scene, MeshBuilder().sphere({0.1f, 0, 0}, 0.4f, 48).build(add_material(scene, glass_of(1.33f))));
    add_mesh(scene, MeshBuilder().sphere({0.15f, 0, 0}, 0.2f, 48).build(add_material(scene, glass_of(2.4f))));
    add_camera(scene, {0, 0.3, 1.8}, dvec3(0), 0.6f);
    return scene;
}

/// Two blocks that share a face.
Scene touching() {
    Scene scene;
    add_uniform_light(scene);
    add_mesh(scene,
             MeshBuilder().box({-0.5f, -0.5f, -0.5f}, {0.5f, 0, 0.5f}).build(add_material(scene, glass_of(1.5f))));
    add_mesh(scene,
             MeshBuilder().box({-0.5f, 0, -0.5f}, {0.5f, 0.5f, 0.5f}).build(add_material(scene, glass_of(1.33f))));
    add_camera(scene, {0.4, 0.7, 1.8}, dvec3(0), 0.6f);
    return scene;
}

HardCase invisible_glass(const char* name, const char* text, Scene (*make)()) {
    return {std::string(kPrefix) + name,
            {.row = kSnell,
             .strains = "which index lies on which side",
             .text = text,
             .checks = {equals("beauty", dvec3(1))}},
            make};
}

// ---- nearly mirrors

constexpr double kLampSide = 0.2, kMirrorView = 1;  // [m]
constexpr double kLampRadiance = 100;

/// A white metal plate and, at the end of the mirrored view at 45 degrees, a small lamp that faces it.
Scene plate_and_small_lamp(float roughness) {
    Scene scene;
    add_mesh(scene, level_rectangle(-2, 2, -2, 2, 0, true, add_material(scene, metal("metal", Rgb(1), roughness))));
    const float half = static_cast<float>(0.5 * kLampSide);
    const vec3 centre(0, 1.5f, -1.5f), right(half, 0, 0), up = half * glm::normalize(vec3(0, 1, 1));
    add_mesh(scene, MeshBuilder()
                        .quad(centre - right - up, centre + right - up, centre + right + up, centre - right + up)
                        .build(add_material(scene, emitter("lamp", Rgb(static_cast<float>(kLampRadiance))))));
    add_orthographic_camera(scene, {0, 2, 2}, {0, 0, 0}, {0, 1, 0}, static_cast<float>(0.5 * kMirrorView));
    return scene;
}

/// A mirror shows the lamp in its own size. A lobe of width alpha only spreads that image, and 4 alpha^2 over the
/// squared angle to the view's rim leaves it: GGX's tail, the answer's tolerance.
HardCase near_mirror(const char* name, float roughness) {
    const double alpha = static_cast<double>(roughness) * static_cast<double>(roughness);
    constexpr double kAngleToRim = 0.15;
    const double share = kLampSide * kLampSide / (kMirrorView * kMirrorView);
    return {std::string(kPrefix) + name,
            {.row = "roughness 0.01 ... 0.03 metal under a small light",
             .strains = "near-delta pdfs, fireflies",
             .text = "a white metal plate shows a small lamp as bright, in all, as a mirror does",
             .checks = {equals("beauty", dvec3(kLampRadiance * share), 1,
                               1e-4 + 4 * alpha * alpha / (kAngleToRim * kAngleToRim))}},
            [roughness] { return plate_and_small_lamp(roughness); }};
}

}  // namespace

void add_glass_cases(std::vector<HardCase>& cases) {
    const auto of_caustic = [](const char* name, const char* strains, const char* text, Scene (*make)()) {
        return HardCase{
            std::string(kPrefix) + name,
            {.row = kCaustics, .strains = strains, .text = text, .checks = {reference("indirect", 6)}, .passes = 1024},
            make};
    };
    cases.push_back(of_caustic("caustic-glass-sphere", "paths that are found from the light alone",
                               "the caustic of a glass ball as path tracing has it", caustic));
    cases.push_back(of_caustic("caustic-in-mirror", "paths that neither camera nor light tracer finds",
                               "the caustic of a glass ball seen in a mirror as path tracing has it",
                               caustic_in_mirror));
    cases.push_back({"hard-case/light-behind-glass",
                     {.row = kCaustics,
                      .strains = "light that comes through glass alone",
                      .text = "a grey ball in a shell of glass in uniform light, in equilibrium: 1 everywhere",
                      .checks = {equals("beauty", dvec3(1))}},
                     light_behind_glass});

    cases.push_back(invisible_ball("ior-1", "a ball of index 1 between light and floor: as without it", 1, 0));
    cases.push_back(
        invisible_ball("ior-1e-6", "a ball of index 1 + 1e-6 between light and floor: as without it", 1 + 1e-6f, 1e-5));
    cases.push_back({"hard-case/total-internal-reflection",
                     {.row = kSnell,
                      .strains = "reflection beyond the critical angle",
                      .text = "a light seen round the corner of a prism: (1 - R) / (1 + R) of its radiance",
                      .checks = {equals("emitted", prism_radiance()), zero("direct"), zero("indirect")}},
                     prism});
    cases.push_back(
        invisible_glass("nested-dielectrics", "three balls of glass, one in the other, in uniform light: 1", nested));
    cases.push_back(invisible_glass("touching-dielectrics",
                                    "two blocks of glass that share a face, in uniform light: 1", touching));

    constexpr std::pair<const char*, float> kMetals[] = {
        {"near-mirror-1", 0.01f}, {"near-mirror-2", 0.02f}, {"near-mirror-3", 0.03f}};
    for (const auto& [name, roughness] : kMetals) cases.push_back(near_mirror(name, roughness));
}

}  // namespace photond
