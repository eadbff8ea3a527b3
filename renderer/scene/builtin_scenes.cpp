#include "renderer/scene/builtin_scenes.h"

#include <algorithm>
#include <array>

#include "protocol/error.h"
#include "protocol/scene_families.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/hard_cases.h"

namespace photond {

namespace {

struct BuiltinScene {
    std::string_view name;
    Scene (*make)();
};

constexpr std::array kBuiltinScenes = {
    BuiltinScene{"cornell-box", make_cornell_box},
    BuiltinScene{"cornell-box-spot", make_cornell_box_spot},
    BuiltinScene{"cornell-box-glass", make_cornell_box_glass},
    BuiltinScene{"cornell-box-glossy", make_cornell_box_glossy},
    BuiltinScene{"furnace", make_furnace},
    BuiltinScene{"caustic-ring", make_caustic_ring},
    BuiltinScene{"keyhole", make_keyhole},
    BuiltinScene{"interior", make_interior},
};

constexpr std::array kSplattingFigures = {
    BuiltinScene{"photon-splatting/plate", make_splatting_plate},
    BuiltinScene{"photon-splatting/skimming-ray", make_splatting_skimming_ray},
    BuiltinScene{"photon-splatting/chairs", make_splatting_chairs},
};

constexpr std::array kDetails = {
    BuiltinScene{"details/bar", make_detail_bar},
    BuiltinScene{"details/bar-at-mid-height", make_detail_bar_at_mid_height},
    BuiltinScene{"details/stepped-bars", make_detail_stepped_bars},
    BuiltinScene{"details/moulding", make_detail_moulding},
    BuiltinScene{"details/bevel", make_detail_bevel},
    BuiltinScene{"details/shelf", make_detail_shelf},
    BuiltinScene{"details/books", make_detail_books},
};

constexpr std::array kCaustics = {
    BuiltinScene{"caustics/glass-on-floor", make_glass_on_floor},
};

constexpr std::array kProgressive = {
    BuiltinScene{"progressive/lamp", make_progressive_lamp},
    BuiltinScene{"progressive/box", make_progressive_box},
    BuiltinScene{"progressive/torus", make_progressive_torus},
    BuiltinScene{"progressive/torus-spot", make_progressive_torus_spot},
    BuiltinScene{"progressive/mirror-bathroom", make_progressive_mirror_bathroom},
    BuiltinScene{"progressive/flashlight", make_progressive_flashlight},
};

constexpr std::array kSmallVcm = {
    BuiltinScene{"small-vcm/sun", make_small_vcm_sun},
    BuiltinScene{"small-vcm/ceiling", make_small_vcm_ceiling},
    BuiltinScene{"small-vcm/point", make_small_vcm_point},
    BuiltinScene{"small-vcm/sky", make_small_vcm_sky},
};

constexpr std::array kDoors = {
    BuiltinScene{"doors/ajar", make_ajar_door},
};

constexpr std::array kVisibilityFiltering = {
    BuiltinScene{"visibility-filtering/glossiness-10", make_box_of_glossiness_10},
    BuiltinScene{"visibility-filtering/glossiness-30", make_box_of_glossiness_30},
    BuiltinScene{"visibility-filtering/glossiness-50", make_box_of_glossiness_50},
};

constexpr std::array kRealTime = {
    BuiltinScene{"real-time/conference", make_conference},
};

constexpr std::array kMoving = {
    BuiltinScene{"moving/cornell-box", make_moving_cornell_box},
    BuiltinScene{"moving/thin-object", make_moving_thin_object},
    BuiltinScene{"moving/teleport", make_moving_teleport},
    BuiltinScene{"moving/appearing", make_moving_appearing},
    BuiltinScene{"moving/light-switched-on", make_moving_light_switched_on},
    BuiltinScene{"moving/light-switched-off", make_moving_light_switched_off},
};

template <size_t N>
constexpr std::array<std::string_view, N> names_of(const std::array<BuiltinScene, N>& scenes) {
    std::array<std::string_view, N> names;
    for (size_t i = 0; i < N; ++i) names[i] = scenes[i].name;
    return names;
}
constexpr auto kNames = names_of(kBuiltinScenes);
constexpr auto kSplattingNames = names_of(kSplattingFigures);
constexpr auto kDetailNames = names_of(kDetails);
constexpr auto kCausticNames = names_of(kCaustics);
constexpr auto kProgressiveNames = names_of(kProgressive);
constexpr auto kSmallVcmNames = names_of(kSmallVcm);
constexpr auto kDoorNames = names_of(kDoors);
constexpr auto kVisibilityNames = names_of(kVisibilityFiltering);
constexpr auto kRealTimeNames = names_of(kRealTime);
constexpr auto kMovingNames = names_of(kMoving);

const BuiltinScene* find_builtin(std::string_view name) {
    for (const std::span<const BuiltinScene> scenes :
         {std::span<const BuiltinScene>(kBuiltinScenes), std::span<const BuiltinScene>(kSplattingFigures),
          std::span<const BuiltinScene>(kDetails), std::span<const BuiltinScene>(kCaustics),
          std::span<const BuiltinScene>(kProgressive), std::span<const BuiltinScene>(kSmallVcm),
          std::span<const BuiltinScene>(kDoors), std::span<const BuiltinScene>(kVisibilityFiltering),
          std::span<const BuiltinScene>(kRealTime), std::span<const BuiltinScene>(kMoving)})
        for (const BuiltinScene& builtin : scenes)
            if (builtin.name == name) return &builtin;
    return nullptr;
}

}  // namespace

std::span<const std::string_view> builtin_scene_names() { return kNames; }

std::span<const std::string_view> builtin_scene_names(std::string_view family) {
    static const std::vector<std::string_view> kHardCases = [] {
        std::vector<std::string_view> names;
        for (const HardCase& hard_case : hard_cases())
            if (hard_case.make) names.push_back(hard_case.name);
        return names;
    }();
    const std::span<const std::string_view> of_families[] = {
        kHardCases,     kSplattingNames, kDetailNames,     kCausticNames,  kProgressiveNames,
        kSmallVcmNames, kDoorNames,      kVisibilityNames, kRealTimeNames, kMovingNames};
    static_assert(std::size(of_families) == kSceneFamilies.size());
    std::string known;
    for (size_t i = 0; i < kSceneFamilies.size(); ++i) {
        if (family == kSceneFamilies[i]) return of_families[i];
        known += (known.empty() ? "" : ", ") + std::string(kSceneFamilies[i]);
    }
    throw Error(ErrorCode::UnknownName,
                "there is no family of scenes \"" + std::string(family) + "\"; there are " + known);
}

bool is_builtin_scene(std::string_view name) { return find_builtin(name) || find_hard_case(name); }

Scene make_builtin_scene(std::string_view name) {
    const auto finished = [name](Scene scene) {
        scene.name = name;
        finish_scene(scene);
        return scene;
    };
    if (const BuiltinScene* builtin = find_builtin(name)) return finished(builtin->make());
    if (const HardCase* hard_case = find_hard_case(name)) return finished(hard_case->make());
    throw Error(ErrorCode::NotFound, "there is no built-in scene named \"" + std::string(name) + "\"");
}

Material lambert(const char* name, const Rgb& albedo) {
    Material material;
    material.name = name;
    material.base_color = albedo;
    material.metallic = 0;
    material.specular = 0;
    return material;
}

Material metal(const char* name, const Rgb& reflectance, float roughness) {
    Material material;
    material.name = name;
    material.base_color = reflectance;
    material.roughness = roughness;
    return material;
}

Material plastic(const char* name, const Rgb& albedo, float roughness) {
    Material material = lambert(name, albedo);
    material.specular = 1;
    material.roughness = roughness;
    return material;
}

Material glass(const char* name) {
    Material material = plastic(name, Rgb(1), 0);
    material.transmission = 1;
    material.solid = true;
    return material;
}

Material emitter(const char* name, const Rgb& radiance) {
    Material material = lambert(name, Rgb(0));
    material.emission = radiance;
    return material;
}

uint32_t add_material(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

void add_mesh(Scene& scene, Mesh mesh) {
    Instance instance;
    instance.mesh = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    scene.instances.push_back(instance);
}

void add_camera(Scene& scene, const dvec3& eye, const dvec3& target, float yfov) {
    Camera camera = look_at_camera(eye, target, dvec3(0, 1, 0), yfov);
    camera.name = "camera";
    scene.cameras.push_back(std::move(camera));
}

}  // namespace photond
