// The scene on the device: its bytes are accounted, and the GLSL twins of what a surface is (textures, shading points,
// emission, materials) answer as the C++ does.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/surface_color.h"
#include "renderer/scene/texture_decode.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/emission.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_scene_test {
namespace {

using namespace test;

vec3 random_vector(RandomStream& random) { return vec3(random.next_2d(), random.next()) * 2.0f - 1.0f; }
vec3 random_direction(RandomStream& random) {
    for (;;)
        if (const vec3 v = random_vector(random); glm::dot(v, v) > 0.01f) return glm::normalize(v);
}
uint32_t random_below(RandomStream& random, size_t count) { return random.next_bits() % static_cast<uint32_t>(count); }
bool chance(RandomStream& random, float probability) { return random.next() < probability; }

Texture random_texture(RandomStream& random, Size2 size) {
    Texture texture;
    texture.size = size;
    for (size_t i = 0; i < size.pixels(); ++i) {
        const uint32_t bits = random.next_bits();
        texture.texels.emplace_back(bits, bits >> 8, bits >> 16, bits >> 24);
    }
    texture.wrap_s = Wrap(random_below(random, 3));
    texture.wrap_t = Wrap(random_below(random, 3));
    return texture;
}

// --- Textures

struct Lookup {
    int32_t texture;
    uint32_t srgb;
    vec2 uv;
};

TEST(GpuScene, TexturesAreLookedUpAlike) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    Scene scene;
    for (const Size2 size : {Size2{1, 1}, Size2{5, 3}, Size2{16, 16}})
        for (uint32_t wraps = 0; wraps < 9; ++wraps)
            for (const bool nearest : {false, true}) {
                Texture texture = random_texture(random, size);
                texture.wrap_s = Wrap(wraps % 3), texture.wrap_t = Wrap(wraps / 3), texture.nearest = nearest;
                scene.textures.push_back(texture);
            }
    finish_scene(scene);
    const float special[] = {0, 1, -1, 0.5f, 2, 1e-9f, -1e-9f, 1e9f, -1e9f, 3e38f, kInfinity, -kInfinity, NAN};
    std::vector<Lookup> lookups;
    for (size_t texture = 0; texture < scene.textures.size(); ++texture)
        for (const uint32_t srgb : {0u, 1u}) {
            for (const float u : special)
                for (const float v : special) lookups.push_back({static_cast<int32_t>(texture), srgb, {u, v}});
            for (int i = 0; i < 200; ++i)
                lookups.push_back({static_cast<int32_t>(texture), srgb, 3.0f * vec2(random_vector(random))});
        }
    const gpu::DeviceScene device_scene(gpu_device(), scene);
    const Twin twin("tests/gpu/texture_lookup.comp", &device_scene.set(), device_scene.specialization());
    const std::vector<vec4> answers = twin.run<vec4>(lookups.size(), {{"lookups", lookups}});
    for (size_t i = 0; i < lookups.size(); ++i) {
        const Texture& texture = scene.textures[static_cast<size_t>(lookups[i].texture)];
        const vec4 expected = sample_texture(texture, lookups[i].uv, lookups[i].srgb);
        // The place between two texels, known to half a spacing of a number up to the texture's width, weighs texels
        // that differ by 1 at most; and the roundings of three blends.
        const float side = static_cast<float>(std::max(texture.size.width, texture.size.height));
        const float tolerance = texture.nearest ? 6e-8f : 1.2e-7f * (4 + side);
        for (int c = 0; c < 4; ++c)
            ASSERT_NEAR(answers[i][c], expected[c], tolerance)
                << "texture " << lookups[i].texture << " at " << lookups[i].uv.x << ", " << lookups[i].uv.y;
    }
}

// --- Normals of triangles whose area leaves float's range

struct Edges {
    vec3 a, b;
};

TEST(GpuScene, TinyHugeAndNeedleTrianglesHaveNormals) {
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<Edges> edges;
    for (int i = 0; i < 1000; ++i) {
        const vec3 a = random_vector(random), b = random_vector(random);
        for (const float scale : {1e-15f, 1e-10f, 1e-5f, 1.0f, 1e9f, 1e12f, 1e17f})
            edges.push_back({a * scale, b * scale});
        // Needles: two edges that are nearly one, short enough that double is asked.
        edges.push_back({a * 1e-9f, a * 1e-9f + b * 1e-13f});
    }
    const Scene empty = [] {
        Scene scene;
        finish_scene(scene);
        return scene;
    }();
    const gpu::DeviceScene device_scene(gpu_device(), empty);
    const Twin twin("tests/gpu/unit_cross.comp", &device_scene.set(), device_scene.specialization());
    const std::vector<vec3> normals = twin.run<vec3>(edges.size(), {{"edges", edges}});
    for (size_t i = 0; i < edges.size(); ++i) {
        const dvec3 a(edges[i].a), b(edges[i].b), cross = glm::cross(a, b);
        // Float's cross product, which is used within its range, is known to a rounding of the edges' product; that of
        // the others to a rounding of itself.
        const double product = glm::length(a) * glm::length(b), area = glm::length(cross);
        const bool in_range = area * area > 1e-30 && area * area < 3e38;
        const double tolerance = 1e-6 * (in_range ? product / area : 1.0);
        EXPECT_LE(glm::length(dvec3(normals[i]) - cross / area), tolerance) << i << ", area " << area;
    }
}

// --- Surfaces

struct Place {
    Hit hit;
    vec3 ray_direction;
    vec3 leaving;
    float outside_ior;
};
struct Answer {
    vec3 position, geometric_normal, smooth_normal, tangent, bitangent, normal, ray_origin;
    uint32_t material, front_side;
    vec3 emitted_front, emitted_back, unlit;
    vec4 base_color;
    float coverage;
    vec3 albedo;
    float refraction_eta;
    uint32_t lobes;
};
static_assert(sizeof(Place) == 48 && sizeof(Answer) == 168, "must match surface_point.comp");

Answer expected_answer(const Scene& scene, const Place& place) {
    const Hit& hit = place.hit;
    const SurfacePoint at{hit.instance, hit.triangle, hit.u, hit.v};
    const ShadingPoint point = make_shading_point(scene, hit, place.ray_direction);
    const Bsdf bsdf = make_bsdf(scene, point, place.outside_ior);
    return {.position = point.position,
            .geometric_normal = point.geometric_normal,
            .smooth_normal = point.smooth_normal,
            .tangent = point.shading.tangent,
            .bitangent = point.shading.bitangent,
            .normal = point.shading.normal,
            .ray_origin = ray_origin(point, place.leaving),
            .material = point.material,
            .front_side = point.front_side,
            .emitted_front = emitted_radiance(scene, at, true),
            .emitted_back = emitted_radiance(scene, at, false),
            .unlit = unlit_radiance(scene, at),
            .base_color =
                surface_base_color(scene, scene.meshes[scene.instances[hit.instance].mesh], hit.triangle, hit.u, hit.v),
            .coverage = surface_coverage(scene, at),
            .albedo = bsdf.albedo(),
            .refraction_eta = bsdf.refraction_eta(),
            .lobes = (bsdf.scatters() ? 1u : 0u) | (bsdf.is_lambert() ? 2u : 0u) | (bsdf.has_delta() ? 4u : 0u) |
                     (bsdf.has_non_delta() ? 8u : 0u) | (bsdf.has_non_delta_transmission() ? 16u : 0u)};
}

template <class Vector>
float difference(const Vector& a, const Vector& b) {
    return glm::length(a - b);
}

/// How far the roundings of corners and of the cross product may turn a triangle's normal.
float normal_error(const Scene& scene, const Hit& hit) {
    const TriangleCorners corners = world_triangle(scene, hit.instance, hit.triangle);
    const vec3 e1 = corners.p[1] - corners.p[0], e2 = corners.p[2] - corners.p[0];
    float corner_error = 0;  // of the transform, in spacings
    if (!scene.instances[hit.instance].identity)
        for (const vec3& p : corners.p) corner_error = std::max(corner_error, 4 * (1 + glm::length(p)));
    const float edges = glm::length(e1) + glm::length(e2);
    constexpr float kSpacing = 1.2e-7f;
    return 4 * kSpacing * (1 + (corner_error * edges + edges * edges) / glm::length(glm::cross(e1, e2)));
}

/// Compares at random places of all instances, seen from anywhere. `smooth_error`: of normals interpolated and mapped.
void compare_surfaces(const Scene& scene, size_t count, float smooth_error) {
    RandomStream random(4, RandomDomain::Test, 0, 0);
    std::vector<Place> places;
    while (places.size() < count) {
        const uint32_t instance = random_below(random, scene.instances.size());
        const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
        if (mesh.triangles.empty()) continue;
        vec2 uv = random.next_2d();
        if (uv.x + uv.y > 1) uv = 1.0f - uv;
        const Hit hit{1, instance, random_below(random, mesh.triangles.size()), uv.x, uv.y};
        places.push_back(
            {hit, random_direction(random), random_direction(random), chance(random, 0.5f) ? 1.0f : 1.33f});
    }
    const gpu::DeviceScene device_scene(gpu_device(), scene);
    const Twin twin("tests/gpu/surface_point.comp", &device_scene.set(), device_scene.specialization());
    const std::vector<Answer> answers = twin.run<Answer>(places.size(), {{"places", places}});
    const float size = 1e-6f * (glm::length(scene.bounds.min) + glm::length(scene.bounds.max));
    for (size_t i = 0; i < places.size(); ++i) {
        const Answer& got = answers[i];
        const Answer want = expected_answer(scene, places[i]);
        SCOPED_TRACE(scene.name + ", instance " + std::to_string(places[i].hit.instance) + ", triangle " +
                     std::to_string(places[i].hit.triangle));
        ASSERT_LE(difference(got.position, want.position), size);
        const float flat_error = normal_error(scene, places[i].hit), normal_tolerance = flat_error + smooth_error;
        ASSERT_LE(difference(got.geometric_normal, want.geometric_normal), flat_error);
        ASSERT_LE(difference(got.smooth_normal, want.smooth_normal), normal_tolerance);
        ASSERT_LE(difference(got.normal, want.normal), normal_tolerance);
        if (std::fabs(want.normal.z) > normal_tolerance) {  // frames jump where z changes its sign
            ASSERT_LE(difference(got.tangent, want.tangent), 4 * normal_tolerance);
            ASSERT_LE(difference(got.bitangent, want.bitangent), 4 * normal_tolerance);
        }
        ASSERT_LE(difference(got.ray_origin, want.ray_origin), 2 * size);
        ASSERT_EQ(got.material, want.material);
        ASSERT_EQ(got.front_side, want.front_side);
        const auto same = [](const auto& a, const auto& b, float tolerance) {
            return difference(a, b) <= tolerance * (1 + glm::length(b));
        };
        // Texture coordinates are known to a few roundings; a texture's slope is its width.
        ASSERT_TRUE(same(got.emitted_front, want.emitted_front, 1e-5f));
        ASSERT_TRUE(same(got.emitted_back, want.emitted_back, 1e-5f));
        ASSERT_TRUE(same(got.unlit, want.unlit, 1e-5f));
        ASSERT_TRUE(same(got.base_color, want.base_color, 1e-5f));
        ASSERT_NEAR(got.coverage, want.coverage, 1e-5f);
        // Through the interpolated table of albedos, whose slope in the roughness is some ten.
        ASSERT_TRUE(same(got.albedo, want.albedo, 1e-4f))
            << got.albedo.x << " for " << want.albedo.x << ", material " << want.material;
        ASSERT_NEAR(got.refraction_eta, want.refraction_eta, 1e-6f);
        ASSERT_EQ(got.lobes, want.lobes);
    }
}

TextureRef random_reference(RandomStream& random, const Scene& scene, float probability) {
    TextureRef reference;
    if (!chance(random, probability)) return reference;
    reference.texture = static_cast<int32_t>(random_below(random, scene.textures.size()));
    reference.uv_set = random_below(random, 2);
    reference.row_u += 0.5f * random_vector(random);
    reference.row_v += 0.5f * random_vector(random);
    return reference;
}

Material random_material(RandomStream& random, const Scene& scene) {
    Material m;
    const auto some = [&](float otherwise) { return chance(random, 0.7f) ? random.next() : otherwise; };
    m.base_color = Rgb(random.next(), random.next(), random.next());
    m.alpha = random.next();
    m.base_color_texture = random_reference(random, scene, 0.6f);
    m.metallic = some(0);
    m.roughness = random.next();
    m.metallic_roughness_texture = random_reference(random, scene, 0.5f);
    m.normal_texture = random_reference(random, scene, 0.6f);
    m.normal_scale = 1.5f * random.next();
    if (chance(random, 0.5f)) m.emission = 10.0f * Rgb(random.next(), random.next(), random.next());
    m.emission_texture = random_reference(random, scene, 0.6f);
    m.ior = chance(random, 0.1f) ? 0.0f : 1 + random.next();
    m.specular = some(0);
    m.specular_color = Rgb(random.next(), random.next(), random.next()) * 1.5f;
    m.specular_texture = random_reference(random, scene, 0.5f);
    m.specular_color_texture = random_reference(random, scene, 0.5f);
    m.transmission = some(0);
    m.transmission_texture = random_reference(random, scene, 0.5f);
    m.solid = chance(random, 0.5f);
    m.attenuation_distance = 1;
    m.alpha_mode = AlphaMode(random_below(random, 3));
    m.double_sided = chance(random, 0.5f);
    m.unlit = chance(random, 0.2f);
    return m;
}

Mesh random_mesh(RandomStream& random, uint32_t material) {
    Mesh mesh;
    mesh.material = material;
    const bool normals = chance(random, 0.7f), tangents = normals && chance(random, 0.5f);
    const bool colors = chance(random, 0.4f);
    const bool uv[2] = {chance(random, 0.8f), chance(random, 0.6f)};
    const size_t triangles = 1 + random_below(random, 12);
    while (mesh.triangles.size() < triangles) {
        vec3 p[3];
        for (vec3& q : p) q = random_vector(random);
        // Not so thin that the normal is lost in roundings.
        if (glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) < 0.3f) continue;
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.triangles.emplace_back(first + 2, first, first + 1);
        const vec3 up = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
        for (const vec3& q : p) {
            mesh.positions.push_back(q);
            if (normals) mesh.normals.push_back(glm::normalize(up + 0.8f * random_vector(random)));
            if (tangents) mesh.tangents.emplace_back(random_direction(random), chance(random, 0.5f) ? 1 : -1);
            if (colors) mesh.colors.emplace_back(1.2f * random.next(), random.next(), random.next(), random.next());
            for (int i = 0; i < 2; ++i)
                if (uv[i]) mesh.uv[i].push_back(2.0f * vec2(random_vector(random)));
        }
    }
    return mesh;
}

/// Everything that a surface can have, at random; some meshes are placed several times, some mirrored.
Scene random_scene() {
    RandomStream random(5, RandomDomain::Test, 0, 0);
    Scene scene;
    scene.name = "random scene";
    for (const Size2 size : {Size2{4, 4}, Size2{7, 2}, Size2{1, 1}, Size2{8, 16}})
        scene.textures.push_back(random_texture(random, size));
    for (uint32_t i = 0; i < 60; ++i) {
        scene.materials.push_back(random_material(random, scene));
        scene.meshes.push_back(random_mesh(random, i));
    }
    for (uint32_t i = 0; i < 150; ++i) {
        Instance instance;
        instance.mesh = i % 60;
        if (i >= 20) {
            mat3 linear;
            do {
                for (int c = 0; c < 3; ++c) linear[c] = random_vector(random);
            } while (std::fabs(glm::determinant(linear)) < 0.3f);
            instance.identity = false;
            instance.to_world = mat4x3(linear[0], linear[1], linear[2], 2.0f * random_vector(random));
            instance.normal_to_world = glm::transpose(glm::inverse(linear));
            instance.flips_orientation = glm::determinant(linear) < 0;
        }
        scene.instances.push_back(instance);
    }
    finish_scene(scene);
    return scene;
}

TEST(GpuScene, SurfacesOfAllKindsAreTheSame) {
    const Scene scene = random_scene();
    uint32_t needs = 0;
    scene.needs.visit([&](const char*, bool value) { needs += value; });
    ASSERT_EQ(needs, 14) << "all but punctual lights and an environment";
    compare_surfaces(scene, 10000, 1e-4f);
}

TEST(GpuScene, SurfacesOfBuiltInScenesAreTheSame) {
    for (const char* name : {"cornell-box", "caustic-ring", "interior"})
        compare_surfaces(make_builtin_scene(name), 5000, 1e-6f);
}

TEST(GpuScene, SurfacesOfAFileAreTheSame) {
    const std::filesystem::path folder = PHOTOND_TEST_DATA "/reference";
    compare_surfaces(load_gltf(folder / "scene.glb", folder, decode_texture), 5000, 1e-6f);
}

// --- Uploading

TEST(GpuScene, BytesAreThoseThatMemoryAccounts) {
    const Scene scene = make_builtin_scene("interior");
    gpu::Device device(gpu::DeviceOptions{.id = gpu_device().report().id});
    Stats stats;
    const gpu::DeviceScene device_scene(device, scene, stats);
    EXPECT_EQ(device_scene.bytes(), device.memory().used_bytes());
    EXPECT_EQ(device_scene.structures(), device.memory().structures());
    EXPECT_GE(device_scene.structures().at("scene_positions"), scene.vertex_count * sizeof(vec3));
    EXPECT_GT(stats.stage("scene_upload").wall_seconds, 0);
    EXPECT_GT(stats.stage("acceleration_build").wall_seconds, 0);
}

/// What an Error says; empty where there is none.
std::string error_of(ErrorCode code, const std::function<void()>& run) {
    try {
        run();
    } catch (const Error& error) {
        EXPECT_EQ(error.code, code);
        return error.what();
    }
    return "";
}

TEST(GpuScene, TexelsPastTheLimitAreRefusedWithTheFigures) {
    RandomStream random(6, RandomDomain::Test, 0, 0);
    Scene scene;
    scene.textures.push_back(random_texture(random, {1024, 512}));
    finish_scene(scene);
    gpu::Device device(gpu::DeviceOptions{.id = gpu_device().report().id, .memory_limit_bytes = 1 << 20});
    const std::string text =
        error_of(ErrorCode::OutOfMemory, [&] { const gpu::DeviceScene device_scene(device, scene); });
    EXPECT_NE(text.find("scene_texels"), std::string::npos) << text;
    EXPECT_NE(text.find("2097152 bytes"), std::string::npos) << text;
    EXPECT_NE(text.find("1048576 bytes"), std::string::npos) << text;
    EXPECT_EQ(device.memory().used_bytes(), 0) << "what was uploaded before is given back";
}

/// A large texture goes up in many pieces.
TEST(GpuScene, LargeTexturesArriveWhole) {
    RandomStream random(7, RandomDomain::Test, 0, 0);
    Scene scene;
    for (const Size2 size : {Size2{3, 5}, Size2{1700, 1300}, Size2{900, 1100}, Size2{2, 2}}) {
        scene.textures.push_back(random_texture(random, size));
        scene.textures.back().nearest = true;
    }
    finish_scene(scene);
    std::vector<Lookup> lookups;
    for (int i = 0; i < 20000; ++i) {
        const uint32_t texture = random_below(random, scene.textures.size());
        lookups.push_back({static_cast<int32_t>(texture), 0, random.next_2d()});
    }
    const gpu::DeviceScene device_scene(gpu_device(), scene);
    const Twin twin("tests/gpu/texture_lookup.comp", &device_scene.set(), device_scene.specialization());
    const std::vector<vec4> answers = twin.run<vec4>(lookups.size(), {{"lookups", lookups}});
    for (size_t i = 0; i < lookups.size(); ++i)
        ASSERT_LE(difference(answers[i], sample_texture(scene.textures[static_cast<size_t>(lookups[i].texture)],
                                                        lookups[i].uv, false)),
                  1.2e-7f);
}

}  // namespace
}  // namespace photond::gpu_scene_test
