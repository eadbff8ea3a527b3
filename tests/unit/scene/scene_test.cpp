// Finishing a scene: bounds, lights, needs, counts, accounting; choosing its camera; names that are nearly right.

#include "renderer/scene/scene.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "protocol/nearest_name.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/emission.h"

namespace photond::scene_test {
namespace {

uint32_t add_material(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

void add_mesh(Scene& scene, Mesh mesh, uint32_t material) {
    mesh.material = material;
    Instance instance;
    instance.mesh = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    scene.instances.push_back(instance);
}

Material lambert() {
    Material material;
    material.metallic = 0;
    material.specular = 0;
    return material;
}

Mesh unit_square() { return MeshBuilder().quad({0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {0, 0, -1}).build(0, true); }

Scene one_square(const Material& material) {
    Scene scene;
    add_mesh(scene, unit_square(), add_material(scene, material));
    return scene;
}

Texture texture_of(Size2 size, std::vector<u8vec4> texels) {
    Texture texture;
    texture.size = size;
    texture.texels = std::move(texels);
    texture.nearest = true;
    texture.wrap_s = texture.wrap_t = Wrap::ClampToEdge;
    return texture;
}

TEST(FinishScene, CountsInstancesAndBoundsThemInWorldSpace) {
    Scene scene = one_square(lambert());
    Instance moved;
    moved.identity = false;
    moved.to_world = mat4x3(vec3(2, 0, 0), vec3(0, 2, 0), vec3(0, 0, 2), vec3(10, 5, 0));
    scene.instances.push_back(moved);
    finish_scene(scene);
    EXPECT_EQ(scene.triangle_count, 4u);
    EXPECT_EQ(scene.vertex_count, 4u);
    EXPECT_EQ(scene.bounds.min, vec3(0, 0, -2));
    EXPECT_EQ(scene.bounds.max, vec3(12, 5, 0));
    EXPECT_TRUE(scene.needs.instances);
    EXPECT_EQ(world_triangle(scene, 1, 0).p[1], vec3(12, 5, 0));

    Scene empty;
    finish_scene(empty);
    EXPECT_TRUE(empty.bounds.empty());
    EXPECT_EQ(empty.bounds.radius(), 0.0f);
}

TEST(FinishScene, LightsAreTheEmissiveTrianglesOfEveryInstance) {
    Material material = lambert();
    material.emission = Rgb(2, 1, 0.5f);
    Scene scene = one_square(material);
    Instance scaled;
    scaled.identity = false;
    scaled.to_world = mat4x3(vec3(3, 0, 0), vec3(0, 3, 0), vec3(0, 0, 3), vec3(0));
    scene.instances.push_back(scaled);
    add_mesh(scene, unit_square(), add_material(scene, lambert()));
    finish_scene(scene);
    ASSERT_EQ(scene.triangle_lights.size(), 4u);
    EXPECT_FLOAT_EQ(scene.triangle_lights[0].area_m2, 0.5f);
    EXPECT_FLOAT_EQ(scene.triangle_lights[2].area_m2, 4.5f);
    EXPECT_EQ(scene.triangle_lights[3].instance, 1u);
    EXPECT_EQ(scene.triangle_lights[3].triangle, 1u);
    EXPECT_EQ(scene.triangle_lights[0].radiance, Rgb(2, 1, 0.5f));
    EXPECT_TRUE(scene.needs.area_lights);

    material.unlit = true;
    Scene unlit = one_square(material);
    finish_scene(unlit);
    EXPECT_TRUE(unlit.triangle_lights.empty()) << "unlit surfaces light nothing";
}

TEST(FinishScene, TexturedLightsHoldTheirMeanAndBlackOnesAreNone) {
    Material material = lambert();
    material.emission = Rgb(8);
    material.emission_texture.texture = 0;
    Scene scene = one_square(material);
    // Four columns: white, black, black, white. Each triangle of the square covers half of every column's area.
    const u8vec4 white(255), black(0, 0, 0, 255);
    scene.textures.push_back(texture_of({4, 1}, {white, black, black, white}));
    finish_scene(scene);
    ASSERT_EQ(scene.triangle_lights.size(), 2u);
    EXPECT_NEAR(scene.triangle_lights[0].radiance.x + scene.triangle_lights[1].radiance.x, 8, 0.15);
    EXPECT_TRUE(scene.needs.emission_textures);
    // What paths see is the texel, on the front only.
    EXPECT_EQ(emitted_radiance(scene, {0, 0, 0.05f, 0.05f}, true), Rgb(8));
    EXPECT_EQ(emitted_radiance(scene, {0, 0, 0.05f, 0.05f}, false), Rgb(0));
    EXPECT_EQ(emitted_radiance(scene, {0, 0, 0.4f, 0.05f}, true), Rgb(0));

    scene.textures[0].texels.assign(4, black);
    finish_scene(scene);
    EXPECT_TRUE(scene.triangle_lights.empty());
}

TEST(Emission, UnlitSurfacesShowTheirColourToTheEyeOnly) {
    Material material = lambert();
    material.unlit = true;
    material.base_color = Rgb(0.5f, 0.25f, 1);
    material.emission = Rgb(9);
    Scene scene = one_square(material);
    scene.meshes[0].colors.assign(4, vec4(0.5f, 1, 1, 1));
    finish_scene(scene);
    EXPECT_EQ(unlit_radiance(scene, {0, 0, 0.2f, 0.2f}), Rgb(0.25f, 0.25f, 1));
    EXPECT_EQ(emitted_radiance(scene, {0, 0, 0.2f, 0.2f}, true), Rgb(0));
    EXPECT_TRUE(scene.needs.unlit);
    scene.materials[0].unlit = false;
    EXPECT_EQ(unlit_radiance(scene, {0, 0, 0.2f, 0.2f}), Rgb(0));
}

TEST(Emission, CoverageFollowsTheAlphaMode) {
    Material material = lambert();
    material.alpha = 0.4f;
    for (const auto& [mode, expected] :
         {std::pair{AlphaMode::Opaque, 1.0f}, {AlphaMode::Mask, 0.0f}, {AlphaMode::Blend, 0.4f}}) {
        material.alpha_mode = mode;
        const Scene scene = one_square(material);
        EXPECT_FLOAT_EQ(surface_coverage(scene, {0, 0, 0.2f, 0.2f}), expected);
    }
}

/// The needs of a scene of one square.
Needs needs_of(const Material& material, std::vector<Texture> textures = {}) {
    Scene scene = one_square(material);
    scene.textures = std::move(textures);
    finish_scene(scene);
    return scene.needs;
}

TEST(Needs, OfPlainMaterials) {
    EXPECT_TRUE(needs_of(lambert()).only_lambert());
    EXPECT_TRUE(needs_of(lambert()).diffuse);

    Material mirror;
    mirror.roughness = 0.009f;
    EXPECT_TRUE(needs_of(mirror).delta);
    EXPECT_FALSE(needs_of(mirror).glossy);
    EXPECT_FALSE(needs_of(mirror).diffuse);
    mirror.roughness = 0.011f;
    EXPECT_FALSE(needs_of(mirror).delta);
    EXPECT_TRUE(needs_of(mirror).glossy);

    Material plastic = lambert();
    plastic.specular = 0.5f;
    EXPECT_TRUE(needs_of(plastic).glossy);
    EXPECT_TRUE(needs_of(plastic).diffuse);

    Material glass = lambert();
    glass.transmission = 1;
    glass.roughness = 0;
    glass.solid = true;
    EXPECT_TRUE(needs_of(glass).transmission);
    EXPECT_TRUE(needs_of(glass).solid_glass);
    EXPECT_TRUE(needs_of(glass).delta);
    EXPECT_FALSE(needs_of(glass).diffuse);

    glass.roughness = 0.5f;
    EXPECT_FALSE(needs_of(glass).delta);
    glass.ior = 1;
    EXPECT_TRUE(needs_of(glass).delta) << "of the index around it: nothing bends";

    Material black_metal;
    black_metal.base_color = Rgb(0);
    EXPECT_TRUE(needs_of(black_metal).glossy) << "shines at grazing angles";
    EXPECT_FALSE(needs_of(black_metal).only_lambert());

    Material black = lambert();
    black.base_color = Rgb(0);
    EXPECT_FALSE(needs_of(black).diffuse) << "a black emitter scatters nothing";
}

TEST(Needs, LookThroughTextures) {
    Material metal;
    metal.metallic_roughness_texture.texture = 0;
    const auto roughness_map = [](uint8_t g) {
        return std::vector{texture_of({2, 1}, {u8vec4(0, 200, 255, 255), u8vec4(0, g, 255, 255)})};
    };
    EXPECT_FALSE(needs_of(metal, roughness_map(3)).delta);  // 3/255 > 0.01
    EXPECT_TRUE(needs_of(metal, roughness_map(2)).delta);
    EXPECT_TRUE(needs_of(metal, roughness_map(2)).material_textures);

    Material leaf = lambert();
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.base_color_texture.texture = 0;
    EXPECT_FALSE(needs_of(leaf, {texture_of({1, 1}, {u8vec4(255)})}).alpha) << "opaque everywhere";
    EXPECT_TRUE(needs_of(leaf, {texture_of({2, 1}, {u8vec4(255), u8vec4(255, 255, 255, 0)})}).alpha);
    leaf.alpha_mode = AlphaMode::Opaque;
    EXPECT_FALSE(needs_of(leaf, {texture_of({1, 1}, {u8vec4(0)})}).alpha) << "alpha is ignored where opaque";
}

TEST(Needs, UnusedMaterialsAskForNothing) {
    Scene scene = one_square(lambert());
    Material glass = lambert();
    glass.transmission = 1;
    add_material(scene, glass);
    scene.meshes.push_back(unit_square());  // a mesh that nobody places
    scene.meshes.back().material = 1;
    finish_scene(scene);
    EXPECT_TRUE(scene.needs.only_lambert());
}

TEST(FindCamera, ByNameFirstOrFramed) {
    Scene scene = one_square(lambert());
    finish_scene(scene);
    const Camera framed = find_camera(scene, "");
    // The whole bounding sphere is inside the picture's height.
    const vec3 to_centre = scene.bounds.centre() - framed.position;
    EXPECT_NEAR(glm::dot(glm::normalize(to_centre), framed.forward), 1, 1e-5);
    EXPECT_NEAR(std::asin(scene.bounds.radius() / glm::length(to_centre)), framed.yfov / 2, 1e-4);

    for (const char* name : {"front", "overview"}) {
        Camera camera;
        camera.name = name;
        scene.cameras.push_back(camera);
    }
    EXPECT_EQ(find_camera(scene, "").name, "front");
    EXPECT_EQ(find_camera(scene, "overview").name, "overview");
    try {
        find_camera(scene, "overveiw");
        FAIL() << "an unknown name must be refused";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::UnknownName);
        EXPECT_NE(std::string(error.what()).find("\"overview\""), std::string::npos) << error.what();
        EXPECT_EQ(error.faults.at(0).pointer, "/camera/name");
    }
}

TEST(Scene, AccountsForWhatItHolds) {
    Scene scene = one_square(lambert());
    scene.textures.push_back(texture_of({64, 64}, std::vector<u8vec4>(4096, u8vec4(255))));
    finish_scene(scene);
    MemoryBudget budget;
    scene.account(budget);
    EXPECT_GE(budget.structures().at("textures"), 4096 * 4u);
    EXPECT_GE(budget.structures().at("meshes"), 4 * sizeof(vec3) + 2 * sizeof(uvec3) + sizeof(Mesh));
    EXPECT_LT(budget.accounted_bytes(), 4096 * 4u + 4096);
}

TEST(NearestName, FindsTypingMistakes) {
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(edit_distance("ab", "ba"), 1u);
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    const std::vector<std::string> known = {"photons", "gather", "gather_rays", "radius"};
    EXPECT_EQ(nearest_name("photon", known), "photons");
    EXPECT_EQ(nearest_name("gahter", known), "gather");
    EXPECT_EQ(nearest_name("Radius", known), "radius");
    EXPECT_EQ(nearest_name("gather_ray", known), "gather_rays");
    EXPECT_EQ(nearest_name("bounces", known), "");
    EXPECT_EQ(nearest_name("", known), "");
    EXPECT_EQ(nearest_name(std::string(100000, 'a'), {std::string(99999, 'a')}), "");
}

}  // namespace
}  // namespace photond::scene_test
