// Energy balance: what stands inside a closed surface of radiance 1 [W m^-2 sr^-1], and closed surfaces that emit and
// reflect.

#include "renderer/scene/hard_case_answers.h"
#include "renderer/scene/hard_case_parts.h"

namespace photond {

namespace {

using namespace hard_case;

constexpr const char* kRow = "furnace sphere / box";

Material glowing_lambert(float albedo) {
    Material wall = lambert("wall", Rgb(albedo));
    wall.emission = Rgb(1);
    return wall;
}

Scene lambert_sphere(float albedo) {
    Scene scene;
    Mesh sphere = make_icosphere(3, add_material(scene, glowing_lambert(albedo)));
    for (uvec3& t : sphere.triangles) std::swap(t.y, t.z);  // fronts, which emit, look inwards
    add_mesh(scene, std::move(sphere));
    add_camera(scene, dvec3(0), dvec3(0, 0, -1), 1.2f);
    return scene;
}

Scene lambert_box(float albedo) {
    Scene scene;
    add_mesh(scene, inward_box(vec3(-1), vec3(1), add_material(scene, glowing_lambert(albedo))));
    add_camera(scene, dvec3(0.1, 0.2, 0.3), dvec3(-0.2, 0, -1), 1.2f);
    return scene;
}

/// A box of mirrors met head-on, where the reflectance is F0 = 0.5 whatever Fresnel's equations make of the rest.
Scene mirror_box() {
    Scene scene;
    Material mirror = metal("mirror", Rgb(0.5f), 0);
    mirror.emission = Rgb(1);
    add_mesh(scene, inward_box(vec3(-1), vec3(1), add_material(scene, mirror)));
    add_orthographic_camera(scene, {0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.75f);
    return scene;
}

/// Uniform light from all sides: a black box that emits 1.
void add_uniform_light(Scene& scene) {
    add_mesh(scene, inward_box(vec3(-2), vec3(2), add_material(scene, emitter("sky", Rgb(1)))));
}

/// A level plate seen at 45 degrees: it meets no light of its own, so what is seen is its directional albedo.
Scene plate_in_uniform_light(const Material& material) {
    Scene scene;
    add_uniform_light(scene);
    add_mesh(scene, level_rectangle(-0.5f, 0.5f, -0.5f, 0.5f, 0, true, add_material(scene, material)));
    add_orthographic_camera(scene, {0, 1, 1}, {0, 0, 0}, {0, 1, 0}, 0.2f);
    return scene;
}

Scene ball_in_uniform_light(const Material& material) {
    Scene scene;
    add_uniform_light(scene);
    add_mesh(scene, MeshBuilder().sphere({0, 0, 0}, 0.5f, 48).build(add_material(scene, material)));
    add_camera(scene, {0, 0.3, 1.8}, dvec3(0), 0.6f);
    return scene;
}

Material rough_glass(float roughness) {
    Material material = glass("glass");
    material.roughness = roughness;
    return material;
}

HardCase lambert_case(const char* name, const char* shape, float albedo, std::function<Scene()> make) {
    // A share `albedo` of the same radiance comes back at each scattering: the series of n bounces is exact too.
    const double a = albedo;
    return {std::string(kPrefix) + name,
            {.row = kRow,
             .strains = "energy balance of many bounces",
             .text = std::string("a closed Lambert ") + shape + " that emits 1: radiance 1 / (1 - albedo) everywhere",
             .checks = {equals("beauty", dvec3(1 / (1 - a))), equals("emitted", dvec3(1)), equals("direct", dvec3(a)),
                        equals("indirect", dvec3(a * a), 1)},
             .passes = a > 0.9 ? 256u : 64u},
            std::move(make)};
}

HardCase metal_case(const char* name, float roughness) {
    const double albedo = roughness == 0 ? 1.0 : ggx_directional_albedo(static_cast<double>(roughness), std::sqrt(0.5));
    return {std::string(kPrefix) + name,
            {.row = kRow,
             .strains = "energy balance of one scattering by GGX",
             .text = "a white metal plate in uniform light, seen at 45 degrees: its directional albedo, by quadrature",
             .checks = {equals("beauty", dvec3(albedo), 1, 1e-4), at_most("beauty", dvec3(1), 1)}},
            [roughness] { return plate_in_uniform_light(metal("metal", Rgb(1), roughness)); }};
}

HardCase plastic_case(const char* name, float roughness) {
    return {std::string(kPrefix) + name,
            {.row = kRow,
             .strains = "energy balance of a coat over a base",
             .text = "a white plastic plate in uniform light: no brighter than what surrounds it",
             .checks = {at_most("beauty", dvec3(1), 1)}},
            [roughness] { return plate_in_uniform_light(plastic("plastic", Rgb(1), roughness)); }};
}

}  // namespace

void add_furnace_cases(std::vector<HardCase>& cases) {
    constexpr std::pair<const char*, float> kAlbedos[] = {
        {"furnace-albedo-0", 0.0f}, {"furnace-albedo-50", 0.5f}, {"furnace-albedo-99", 0.99f}};
    for (const auto& [name, albedo] : kAlbedos)
        cases.push_back(lambert_case(name, "sphere", albedo, [albedo = albedo] { return lambert_sphere(albedo); }));
    cases.push_back(lambert_case("furnace-box-albedo-50", "box", 0.5f, [] { return lambert_box(0.5f); }));
    cases.push_back({"hard-case/furnace-mirror-50",
                     {.row = kRow,
                      .strains = "energy balance of many delta scatterings",
                      .text = "a closed box of mirrors of reflectance 0.5 that emit 1, met head-on: 2",
                      .checks = {equals("emitted", dvec3(2)), zero("direct"), zero("indirect")}},
                     mirror_box});

    constexpr std::pair<const char*, float> kMetals[] = {{"furnace-metal-roughness-0", 0.0f},
                                                         {"furnace-metal-roughness-1", 0.01f},
                                                         {"furnace-metal-roughness-3", 0.03f},
                                                         {"furnace-metal-roughness-30", 0.3f},
                                                         {"furnace-metal-roughness-100", 1.0f}};
    for (const auto& [name, roughness] : kMetals) cases.push_back(metal_case(name, roughness));
    constexpr std::pair<const char*, float> kPlastics[] = {{"furnace-plastic-roughness-0", 0.0f},
                                                           {"furnace-plastic-roughness-1", 0.01f},
                                                           {"furnace-plastic-roughness-30", 0.3f},
                                                           {"furnace-plastic-roughness-100", 1.0f}};
    for (const auto& [name, roughness] : kPlastics) cases.push_back(plastic_case(name, roughness));

    // Smooth clear glass takes nothing away, and what it changes of a ray's radiance within is undone when the ray
    // leaves.
    cases.push_back({"hard-case/furnace-glass-smooth",
                     {.row = kRow,
                      .strains = "energy balance of refraction",
                      .text = "a ball of smooth clear glass in uniform light: invisible",
                      .checks = {equals("beauty", dvec3(1))}},
                     [] { return ball_in_uniform_light(rough_glass(0)); }});
    cases.push_back({"hard-case/furnace-glass-rough",
                     {.row = kRow,
                      .strains = "energy balance of rough refraction",
                      .text = "a ball of rough clear glass in uniform light: no brighter than what surrounds it",
                      .checks = {at_most("beauty", dvec3(1))}},
                     [] { return ball_in_uniform_light(rough_glass(0.3f)); }});
    cases.push_back({"hard-case/furnace-glass-sheet",
                     {.row = kRow,
                      .strains = "energy balance of a thin sheet",
                      .text = "a sheet of smooth clear glass in uniform light: invisible",
                      .checks = {equals("beauty", dvec3(1))}},
                     [] {
                         Material sheet = glass("sheet");
                         sheet.solid = false;
                         return plate_in_uniform_light(sheet);
                     }});
}

}  // namespace photond
