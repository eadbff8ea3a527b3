// Everything of loaded glTF that is not geometry: containers and URIs, materials and textures, cameras, lights, scenes,
// extensions; and the reference scene.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "protocol/error.h"
#include "renderer/scene/scene.h"
#include "tests/support/test_gltf.h"

namespace photond::gltf_scene_test {
namespace {

std::string base64(const std::vector<uint8_t>& bytes) {
    constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kAlphabet[bits >> (18 - 6 * k) & 63];
    }
    return text;
}

/// One triangle with coordinates, material 0, and an image of four texels with textures 0 (image as it is) and 1
/// (nearest, clamped).
class TexturedTriangle : public TestGltf {
public:
    TexturedTriangle() {
        const int position = positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
        const int uv0 = floats("VEC2", 2, {0, 0, 1, 0, 0, 1});
        const int uv1 = floats("VEC2", 2, {0.5f, 0.5f, 1, 0, 0, 1});
        const int image =
            view(make_png({2, 2}, {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {9, 9, 9, 128}}));
        attributes = R"("POSITION":)" + std::to_string(position) + R"(,"TEXCOORD_0":)" + std::to_string(uv0) +
                     R"(,"TEXCOORD_1":)" + std::to_string(uv1) + R"(,"TEXCOORD_2":)" + std::to_string(uv0);
        set_mesh(attributes, R"(,"material":0)");
        set("images", R"([{"name":"four","bufferView":)" + std::to_string(image) + R"(,"mimeType":"image/png"}])");
        set("samplers", R"([{"magFilter":9728,"wrapS":33071,"wrapT":33648}])");
        set("textures", R"([{"source":0},{"name":"sharp","source":0,"sampler":0}])");
    }
    Scene load_with(const std::string& material) {
        set("materials", "[" + material + "]");
        return load();
    }
    std::string attributes;
};

TEST(GltfScene, MaterialFactorsAndDefaults) {
    TexturedTriangle file;
    const Material plain = file.load_with("{}").materials.at(0);
    EXPECT_EQ(plain.base_color, Rgb(1));
    EXPECT_EQ(plain.metallic, 1);
    EXPECT_EQ(plain.roughness, 1);
    EXPECT_EQ(plain.ior, 1.5f);
    EXPECT_EQ(plain.specular, 1);
    EXPECT_EQ(plain.alpha_mode, AlphaMode::Opaque);
    EXPECT_FALSE(plain.solid || plain.double_sided || plain.unlit || plain.emissive());

    const Material full =
        file.load_with(R"({"name":"everything","doubleSided":true,"alphaMode":"MASK","alphaCutoff":0.25,
        "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,"roughnessFactor":0.6},
        "emissiveFactor":[1,0.5,0.25],"extensions":{
        "KHR_materials_emissive_strength":{"emissiveStrength":8},"KHR_materials_ior":{"ior":1.33},
        "KHR_materials_specular":{"specularFactor":0,"specularColorFactor":[1,2,3]},
        "KHR_materials_transmission":{"transmissionFactor":0.9},
        "KHR_materials_volume":{"thicknessFactor":0.1,"attenuationDistance":2,"attenuationColor":[0.9,0.8,0.7]}}})")
            .materials.at(0);
    EXPECT_EQ(full.name, "everything");
    EXPECT_EQ(full.base_color, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(full.alpha, 0.4f);
    EXPECT_EQ(full.metallic, 0.5f);
    EXPECT_EQ(full.roughness, 0.6f);
    EXPECT_EQ(full.emission, Rgb(8, 4, 2));
    EXPECT_EQ(full.ior, 1.33f);
    EXPECT_EQ(full.specular, 0);
    EXPECT_EQ(full.specular_color, Rgb(1, 2, 3));
    EXPECT_EQ(full.transmission, 0.9f);
    EXPECT_TRUE(full.solid);
    EXPECT_EQ(full.attenuation_distance, 2);
    EXPECT_EQ(full.attenuation_color, Rgb(0.9f, 0.8f, 0.7f));
    EXPECT_EQ(full.alpha_mode, AlphaMode::Mask);
    EXPECT_EQ(full.alpha_cutoff, 0.25f);
    EXPECT_TRUE(full.double_sided);

    EXPECT_FALSE(file.load_with(R"({"extensions":{"KHR_materials_volume":{"thicknessFactor":0}}})").materials[0].solid)
        << "without thickness it is a thin sheet";
    EXPECT_TRUE(file.load_with(R"({"extensions":{"KHR_materials_unlit":{}}})").materials[0].unlit);
}

TEST(GltfScene, TexturesAreSharedBySamplerAndLoadedOnlyWhenTheyMatter) {
    TexturedTriangle file;
    const Scene scene = file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},
        "metallicRoughnessTexture":{"index":1}},"emissiveTexture":{"index":0},"emissiveFactor":[1,1,1]})");
    ASSERT_EQ(scene.textures.size(), 2u);
    const Material& m = scene.materials[0];
    EXPECT_EQ(m.base_color_texture.texture, m.emission_texture.texture);
    const Texture& soft = scene.textures[static_cast<size_t>(m.base_color_texture.texture)];
    const Texture& sharp = scene.textures[static_cast<size_t>(m.metallic_roughness_texture.texture)];
    EXPECT_EQ(soft.name, "four");
    EXPECT_EQ(soft.wrap_s, Wrap::Repeat);
    EXPECT_FALSE(soft.nearest);
    EXPECT_EQ(sharp.name, "sharp");
    EXPECT_EQ(sharp.wrap_s, Wrap::ClampToEdge);
    EXPECT_EQ(sharp.wrap_t, Wrap::MirroredRepeat);
    EXPECT_TRUE(sharp.nearest);
    EXPECT_EQ(soft.texels, sharp.texels);
    EXPECT_EQ(soft.texels[3], u8vec4(9, 9, 9, 128));

    EXPECT_TRUE(file.load_with(R"({"emissiveTexture":{"index":0},"occlusionTexture":{"index":0},
        "normalTexture":{"index":0,"scale":0},
        "extensions":{"KHR_materials_specular":{"specularFactor":0,"specularTexture":{"index":0}},
        "KHR_materials_transmission":{"transmissionTexture":{"index":0}}}})")
                    .textures.empty())
        << "textures multiplied by 0 are not loaded";
}

TEST(GltfScene, TextureTransformRotatesTheImageClockwise) {
    TexturedTriangle file;
    const Scene scene =
        file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":0,"extensions":{
        "KHR_texture_transform":{"offset":[0.5,0.25],"rotation":1.5707963267948966,"scale":[2,3],"texCoord":1}}}}})");
    const TextureRef& reference = scene.materials[0].base_color_texture;
    EXPECT_EQ(reference.uv_set, 1u);
    EXPECT_TRUE(scene.meshes[0].uv[0].empty()) << "set 0 is not read";
    ASSERT_EQ(scene.meshes[0].uv[1].size(), 3u);
    // Counter-clockwise with v down: u turns to -v. uv' = offset + R (2u, 3v): u' = 0.5 + 3v, v' = 0.25 - 2u.
    const vec3 uv1(0.1f, 0.2f, 1);
    EXPECT_NEAR(glm::dot(reference.row_u, uv1), 0.5 + 0.6, 1e-6);
    EXPECT_NEAR(glm::dot(reference.row_v, uv1), 0.25 - 0.2, 1e-6);
}

TEST(GltfScene, AnyTwoCoordinateSetsFitAndThreeDoNot) {
    TexturedTriangle file;
    const Scene scene = file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":2},
        "metallicRoughnessTexture":{"index":0,"texCoord":1}}})");
    const Material& m = scene.materials[0];
    EXPECT_EQ(m.metallic_roughness_texture.uv_set, 1u);
    EXPECT_EQ(m.base_color_texture.uv_set, 0u);
    EXPECT_EQ(scene.meshes[0].uv[0][1], vec2(1, 0));
    EXPECT_EQ(scene.meshes[0].uv[1][0], vec2(0.5f, 0.5f));
    try {
        file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":2},
            "metallicRoughnessTexture":{"index":0,"texCoord":1}},"normalTexture":{"index":0,"texCoord":0}})");
        ADD_FAILURE() << "three sets were accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Unsupported);
        EXPECT_EQ(error.faults.at(0).pointer, "/materials/0");
    }
}

TEST(GltfScene, PrimitivesWithoutMaterialGetTheDefaultAndUnusedMaterialsGo) {
    TexturedTriangle file;
    file.set_mesh(file.attributes);
    const Scene scene =
        file.load_with(R"({"name":"unused","extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}})");
    ASSERT_EQ(scene.materials.size(), 1u);
    EXPECT_EQ(scene.materials[0].name, "default");
    EXPECT_EQ(scene.materials[0].metallic, 1);
    EXPECT_FALSE(scene.needs.transmission);
}

TEST(GltfScene, VertexColoursAreClampedAndCounted) {
    TestGltf file;
    const int position = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int color = file.floats("VEC3", 3, {0.5f, 0.25f, 1, 2, 0, 0, 1, 1, 1});
    const int bytes = file.accessor(file.view({51, 102, 153, 204, 0, 0, 0, 0, 255, 255, 255, 255}), TestGltf::kU8,
                                    "VEC4", 3, R"(,"normalized":true)");
    file.set_mesh(R"("POSITION":)" + std::to_string(position) + R"(,"COLOR_0":)" + std::to_string(color));
    const Scene scene = file.load();
    EXPECT_EQ(scene.meshes[0].colors, (std::vector<vec4>{{0.5f, 0.25f, 1, 1}, {1, 0, 0, 1}, {1, 1, 1, 1}}));
    EXPECT_TRUE(has_warning(scene, "1 vertex colours"));
    file.set_mesh(R"("POSITION":)" + std::to_string(position) + R"(,"COLOR_0":)" + std::to_string(bytes));
    EXPECT_EQ(file.load().meshes[0].colors[0], vec4(51, 102, 153, 204) / 255.0f);
}

TEST(GltfScene, CamerasComeDepthFirstWithTheirNodesNames) {
    TexturedTriangle file;
    file.set("cameras", R"([{"name":"own","type":"perspective","perspective":{"yfov":0.5,"aspectRatio":2,"znear":0.1}},
        {"type":"orthographic","orthographic":{"xmag":3,"ymag":4,"znear":0,"zfar":1}}])");
    file.set("materials", "[{}]");
    file.set("nodes", R"([{"mesh":0},{"children":[2,3]},{"name":"deep","children":[4]},{"camera":1,"name":"second"},
        {"camera":0,"scale":[3,3,3],"translation":[1,2,3],"rotation":[0,0.70710678,0,0.70710678]},{"camera":0,"name":"other scene"},{"camera":1}])");
    file.set("scenes", R"([{"nodes":[5]},{"nodes":[0,1,6]}])");
    file.set("scene", "1");
    const Scene scene = file.load();
    ASSERT_EQ(scene.cameras.size(), 3u);
    EXPECT_EQ(scene.cameras[0].name, "own") << "node 4 has no name, so the camera's own; depth first before node 3";
    EXPECT_EQ(scene.cameras[1].name, "second");
    EXPECT_EQ(scene.cameras[2].name, "camera_2");
    const Camera& camera = scene.cameras[0];
    EXPECT_EQ(camera.yfov, 0.5f);
    EXPECT_EQ(camera.position, vec3(1, 2, 3));
    EXPECT_LT(glm::length(camera.forward - vec3(-1, 0, 0)), 1e-6f) << "a quarter turn about y";
    EXPECT_LT(glm::length(camera.right - vec3(0, 0, -1)), 1e-6f);
    EXPECT_LT(glm::length(camera.up - vec3(0, 1, 0)), 1e-6f);
    EXPECT_TRUE(scene.cameras[1].orthographic);
    EXPECT_EQ(scene.cameras[1].ymag, 4);

    file.set("scene", "0");
    EXPECT_EQ(file.load().cameras.at(0).name, "other scene");
    EXPECT_TRUE(has_warning(file.load(), "no triangles"));
}

TEST(GltfScene, PunctualLightsArePlaced) {
    TexturedTriangle file;
    file.set("materials", "[{}]");
    file.set("extensionsUsed", R"(["KHR_lights_punctual"])");
    file.set("extensions", R"({"KHR_lights_punctual":{"lights":[
        {"type":"directional","name":"sun","color":[1,0.5,0.25],"intensity":4},{"type":"point","intensity":7,"range":9},
        {"type":"spot","spot":{"innerConeAngle":0.5,"outerConeAngle":1}},{"type":"spot","spot":{}}]}})");
    const std::string use = R"("extensions":{"KHR_lights_punctual":{"light":)";
    file.set("nodes", R"([{"mesh":0},{"rotation":[-0.70710678,0,0,0.70710678],)" + use +
                          R"(0}}},{"name":"bulb","translation":[1,2,3],)" + use + "1}}},{" + use + "2}}},{" + use +
                          "3}}}]");
    file.set("scenes", R"([{"nodes":[0,1,2,3,4]}])");
    const Scene scene = file.load();
    ASSERT_EQ(scene.punctual_lights.size(), 4u);
    const auto& lights = scene.punctual_lights;
    EXPECT_EQ(lights[0].kind, PunctualLight::Kind::Directional);
    EXPECT_EQ(lights[0].name, "sun");
    EXPECT_EQ(lights[0].intensity, Rgb(4, 2, 1));
    EXPECT_LT(glm::length(lights[0].direction - vec3(0, -1, 0)), 1e-6f) << "-z turned down";
    EXPECT_EQ(lights[1].name, "bulb");
    EXPECT_EQ(lights[1].position, vec3(1, 2, 3));
    EXPECT_EQ(lights[1].range_m, 9);
    EXPECT_EQ(lights[2].kind, PunctualLight::Kind::Spot);
    EXPECT_FLOAT_EQ(lights[2].cos_inner, std::cos(0.5f));
    EXPECT_FLOAT_EQ(lights[2].cos_outer, std::cos(1.0f));
    EXPECT_FLOAT_EQ(lights[3].cos_inner, 1) << "the extension's defaults: 0 and pi/4";
    EXPECT_FLOAT_EQ(lights[3].cos_outer, std::sqrt(0.5f));
}

TEST(GltfScene, ExtensionsRequiredAreRefusedByNameAndUsedOnesWarnedOf) {
    TexturedTriangle file;
    file.set("materials", "[{}]");
    file.set("extensionsUsed", R"(["KHR_materials_clearcoat","KHR_materials_ior"])");
    const Scene scene = file.load();
    EXPECT_TRUE(has_warning(scene, "KHR_materials_clearcoat"));
    EXPECT_FALSE(has_warning(scene, "KHR_materials_ior"));
    file.set("extensionsRequired", R"(["KHR_materials_ior","KHR_draco_mesh_compression","KHR_texture_basisu"])");
    try {
        file.load();
        ADD_FAILURE() << "was loaded";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Unsupported);
        ASSERT_EQ(error.faults.size(), 2u) << "both are named";
        EXPECT_EQ(error.faults[0].pointer, "/extensionsRequired/1");
        EXPECT_NE(error.faults[0].detail.find("KHR_draco_mesh_compression"), std::string::npos);
        EXPECT_EQ(error.faults[1].pointer, "/extensionsRequired/2");
    }
}

// As files look whose images are of an extension: materials of such a texture are loaded without it.
TEST(GltfScene, TexturesWithoutASourceAreWarnedOf) {
    TexturedTriangle file;
    file.set("extensionsUsed", R"(["EXT_texture_webp"])");
    file.set("textures", R"([{"extensions":{"EXT_texture_webp":{"source":0}}},{"source":0},{"name":"none"}])");
    const Scene scene = file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},
        "metallicRoughnessTexture":{"index":1}},"normalTexture":{"index":2,"texCoord":5},
        "emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}})");
    EXPECT_TRUE(has_warning(scene, "2 textures have no source image")) << scene.warnings.size();
    EXPECT_TRUE(has_warning(scene, "EXT_texture_webp"));
    EXPECT_FALSE(has_warning(scene, "texture coordinates"));
    const Material& material = scene.materials.at(0);
    EXPECT_FALSE(material.base_color_texture.used() || material.normal_texture.used());
    EXPECT_TRUE(material.metallic_roughness_texture.used() && material.emissive());
    EXPECT_EQ(scene.textures.size(), 1u);
    file.set("textures", R"([{"source":0},{"source":0}])");
    EXPECT_FALSE(has_warning(file.load_with(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})"), "source"));
}

// tinygltf wants a znear and a zfar, indices in a buffer view, whole numbers without a point, and every image there.
TEST(GltfScene, WhatTheParserWantsAndGltfDoesNotIsNoFault) {
    TexturedTriangle file;
    const int zeros = file.accessor(-1, TestGltf::kU32, "SCALAR", 3);
    file.set_mesh(file.attributes,
                  R"(,"material":0.0},{"attributes":{"POSITION":0e0},"indices":)" + std::to_string(zeros));
    file.set("materials", "[{}]");
    file.set("images", R"([{"uri":"nobody reads it.png"}])");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":0.5},"orthographic":7},
        {"type":"orthographic","orthographic":{"xmag":3,"ymag":4}}])");
    file.set("nodes", R"([{"mesh":0,"children":[1,2.0]},{"camera":0},{"camera":1}])");
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangle_count, 1u);
    EXPECT_TRUE(has_warning(scene, "1 triangles without area"));
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.cameras[0].yfov, 0.5f);
    EXPECT_EQ(scene.cameras[1].ymag, 4);
}

TEST(GltfScene, MembersThatGltfDoesNotNameAreNotRead) {
    TexturedTriangle file;
    const std::string strange =
        R"("extras":{"index":-7,"a":[null,{}]},"extensions":{"VENDOR_x":{"source":-4}},"mood":[])";
    file.set("materials", R"([{"pbrMetallicRoughness":{"metallicFactor":0,)" + strange + "}," + strange + "}]");
    file.set("nodes", R"([{"mesh":0,"parent":0,)" + strange + "}]");
    file.set("parents", "[0]");
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangle_count, 1u);
    EXPECT_EQ(scene.materials.at(0).metallic, 0);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfScene, AllFaultsOfAKindAreNamedAtOnce) {
    TexturedTriangle file;
    file.set("materials",
             R"([{"pbrMetallicRoughness":{"metallicFactor":2}},{"alphaMode":"NONE"},{"doubleSided":"no"}])");
    try {
        file.load();
        ADD_FAILURE() << "was loaded";
    } catch (const Error& error) {
        ASSERT_EQ(error.faults.size(), 3u);
        EXPECT_EQ(error.faults[0].pointer, "/materials/0/pbrMetallicRoughness/metallicFactor");
        EXPECT_NE(error.faults[0].detail.find("2 is outside [0, 1]"), std::string::npos) << error.faults[0].detail;
        EXPECT_EQ(error.faults[1].pointer, "/materials/1/alphaMode");
        EXPECT_EQ(error.faults[2].pointer, "/materials/2/doubleSided");
    }
}

TEST(GltfScene, SeparateFilesDataUrisAndTheGlbGiveTheSameScene) {
    TexturedTriangle file;
    file.set("materials", R"([{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])");
    const Scene from_glb = file.load();

    const TemporaryFolder folder;
    const std::filesystem::path inside = folder.path() / "models";
    std::filesystem::create_directories(inside / "image files");
    TestGltf::write(inside / "data 1.bin", file.binary());
    const std::vector<uint8_t> png =
        make_png({2, 2}, {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {9, 9, 9, 128}});
    TestGltf::write(inside / "image files" / "four.png", png);
    const auto load_as = [&](const std::string& buffer_uri, const std::string& image_uri) {
        file.extra_of_buffer = R"(,"uri":")" + buffer_uri + "\"";
        file.set("images", R"([{"name":"four","uri":")" + image_uri + R"("}])");
        const std::string json = file.json();
        TestGltf::write(inside / "scene.gltf", std::vector<uint8_t>(json.begin(), json.end()));
        return load_gltf(inside / "scene.gltf", folder.path(), decode_texture);
    };
    for (const Scene& scene :
         {load_as("data%201.bin", "image%20files/four.png"), load_as("./data 1.bin", "image files/four.png"),
          load_as("data:application/octet-stream;base64," + base64(file.binary()),
                  "data:image/png;base64," + base64(png))}) {
        EXPECT_EQ(scene.meshes.at(0).positions, from_glb.meshes.at(0).positions);
        EXPECT_EQ(scene.textures.at(0).texels, from_glb.textures.at(0).texels);
        EXPECT_GT(scene.file_bytes, 0u);
    }
    EXPECT_EQ(load_gltf("models/scene.gltf", folder.path(), decode_texture).triangle_count, 1u)
        << "relative to the root";
}

TEST(GltfScene, LimitsAreKept) {
    TexturedTriangle file;
    file.set("materials", R"([{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])");
    const auto refused = [&](const LoadLimits& limits) {
        try {
            file.load(limits);
        } catch (const Error& error) {
            return error.code;
        }
        return ErrorCode::Internal;
    };
    EXPECT_EQ(refused({.max_file_bytes = 100}), ErrorCode::BadScene);
    EXPECT_EQ(refused({.max_texture_pixels = 3}), ErrorCode::BadImage);
    EXPECT_EQ(refused({.max_total_texture_pixels = 3}), ErrorCode::BadImage);
    EXPECT_EQ(refused({.max_json_depth = 3}), ErrorCode::BadScene);
    EXPECT_EQ(refused({.max_json_values = 20}), ErrorCode::BadScene);
    EXPECT_EQ(refused({}), ErrorCode::Internal);
}

// What tests/data/reference/README.md says of the scene.
TEST(GltfScene, TheReferenceBoxIsWhatItsDescriptionSays) {
    const std::filesystem::path folder = std::filesystem::path(PHOTOND_TEST_DATA) / "reference";
    const Scene scene = load_gltf(folder / "scene.glb", folder, decode_texture);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.triangle_count, 32u);
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_LT(glm::length(scene.cameras[0].position - vec3(0, 2.73f, 8)), 1e-5f);
    EXPECT_LT(glm::length(scene.cameras[0].forward - vec3(0, 0, -1)), 1e-6f);
    EXPECT_FLOAT_EQ(scene.cameras[0].yfov, 0.6860478808414069f);
    for (const Material& m : scene.materials) {
        EXPECT_EQ(m.specular, 0);
        EXPECT_EQ(m.metallic, 0);
    }
    double area = 0;
    ASSERT_EQ(scene.triangle_lights.size(), 2u);
    for (const TriangleLight& light : scene.triangle_lights) {
        area += double{light.area_m2};
        EXPECT_LT(glm::length(light.radiance - Rgb(17, 12, 4)), 1e-5f);
        EXPECT_FALSE(light.two_sided);
        const TriangleCorners corners = world_triangle(scene, light.instance, light.triangle);
        EXPECT_NEAR(corners.p[0].y, 5.478, 1e-5);
        EXPECT_LT(glm::cross(corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]).y, 0) << "it faces down";
    }
    EXPECT_NEAR(area, 1.3 * 1.05, 1e-5);
    EXPECT_TRUE(scene.needs.only_lambert());
}

}  // namespace
}  // namespace photond::gltf_scene_test
