// From hits to shading points: sides, normals, mirrored instances, normal maps, ray origins.

#include "renderer/transport/surface.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/transport/bsdf.h"

namespace photond::surface_test {
namespace {

/// One triangle in the xy plane, counter-clockwise seen from +z, its texture coordinates as a picture lying in it: u to
/// the right, v downwards.
Scene triangle_scene() {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.uv[0] = {{0, 1}, {1, 1}, {0, 0}};
    mesh.triangles = {{0, 1, 2}};
    Scene scene;
    scene.meshes = {mesh};
    scene.instances = {Instance{}};
    scene.materials = {Material{}};
    return scene;
}

void place(Scene& scene, const mat3& linear, const vec3& translation) {
    Instance& instance = scene.instances[0];
    instance.identity = false;
    instance.to_world = mat4x3(linear[0], linear[1], linear[2], translation);
    instance.normal_to_world = glm::transpose(glm::inverse(linear));
    instance.flips_orientation = glm::determinant(linear) < 0;
}

/// A 1x1 normal map that leans by 45 degrees along the picture's x (and up its y, when asked).
void add_normal_map(Scene& scene, bool up) {
    const float lean = std::sqrt(0.5f);
    const auto byte = [](float x) { return static_cast<uint8_t>(std::lround(127.5f * (x + 1))); };
    Texture texture;
    texture.size = {1, 1};
    texture.texels = {u8vec4(byte(up ? 0 : lean), byte(up ? lean : 0), byte(lean), 255)};
    scene.textures = {texture};
    scene.materials[0].normal_texture.texture = 0;
}

const Hit kHit{.t = 1, .instance = 0, .triangle = 0, .u = 0.25f, .v = 0.5f};

void expect_near(const vec3& a, const vec3& b, float tolerance = 1e-6f) {
    EXPECT_NEAR(glm::distance(a, b), 0, tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(Surface, FacesTheRayFromEitherSide) {
    const Scene scene = triangle_scene();
    const ShadingPoint front = make_shading_point(scene, kHit, {0, 0, -1}),
                       back = make_shading_point(scene, kHit, {0, 0, 1});
    EXPECT_TRUE(front.front_side);
    EXPECT_FALSE(back.front_side);
    expect_near(front.position, {0.25f, 0.5f, 0});
    expect_near(front.geometric_normal, {0, 0, 1});
    expect_near(back.geometric_normal, {0, 0, -1});
    expect_near(back.shading.normal, {0, 0, -1});
    EXPECT_GT(ray_origin(front, {0, 0.6f, 0.8f}).z, 0);
    EXPECT_LT(ray_origin(front, {0, 0.6f, -0.8f}).z, 0);
    EXPECT_LT(ray_origin(back, {0, 0.6f, -0.8f}).z, 0);
}

// A mirroring node keeps the file's winding as the front (glTF 3.7.4): the side follows the transformed normal.
TEST(Surface, TransformsMoveAndMirror) {
    Scene scene = triangle_scene();
    scene.meshes[0].normals.assign(3, vec3(0, 0, 1));
    place(scene, mat3(2, 0, 0, 0, 1, 0, 0, 0, 1), {5, 0, 0});
    const ShadingPoint moved = make_shading_point(scene, kHit, {0, 0, -1});
    expect_near(moved.position - moved.clearance_m * moved.geometric_normal, {5.5f, 0.5f, 0});
    place(scene, mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), {0, 0, 0});
    const ShadingPoint point = make_shading_point(scene, kHit, {0, 0, -1});
    EXPECT_TRUE(point.front_side);
    expect_near(point.geometric_normal, {0, 0, 1});
    expect_near(point.shading.normal, {0, 0, 1});
    expect_near(point.position, {-0.25f, 0.5f, 0});
}

TEST(Surface, NormalsOfScaledInstancesStayPerpendicular) {
    Scene scene = triangle_scene();
    const vec3 slope = glm::normalize(vec3(1, 0, 1));
    scene.meshes[0].normals.assign(3, slope);
    place(scene, mat3(1, 0, 0, 0, 1, 0, 0, 0, 4), {0, 0, 0});
    // The normal of the plane x + z = 0 becomes that of x + z/4 = 0.
    expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, glm::normalize(vec3(1, 0, 0.25f)));
}

TEST(Surface, InterpolatedNormalsLeanButNeverAwayFromTheEye) {
    Scene scene = triangle_scene();
    const vec3 leaning = glm::normalize(vec3(1, 0, 0.2f));
    scene.meshes[0].normals.assign(3, leaning);
    expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, leaning);
    expect_near(make_shading_point(scene, kHit, {0, 0, 1}).shading.normal, -leaning);
    // Seen along +x the leaning normal faces away: the geometric one takes over.
    const vec3 along = glm::normalize(vec3(1, 0, -0.1f));
    expect_near(make_shading_point(scene, kHit, along).shading.normal, {0, 0, 1});
    // Normals that disagree with the winding are turned to its side; normals that cancel out are no normals.
    scene.meshes[0].normals.assign(3, -leaning);
    expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, leaning);
    scene.meshes[0].normals.assign(3, vec3(0));
    expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, {0, 0, 1});
}

TEST(Surface, NormalMapsLeanAlongThePicture) {
    for (const bool vertex_tangents : {false, true})
        for (const bool up : {false, true}) {
            Scene scene = triangle_scene();
            add_normal_map(scene, up);
            // Green is up in the picture, and the picture's top is at v = 0, here y = 1.
            if (vertex_tangents) scene.meshes[0].tangents.assign(3, vec4(1, 0, 0, 1));
            const vec3 lean = glm::normalize(up ? vec3(0, 1, 1) : vec3(1, 0, 1));
            expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, lean, 0.01f);
            expect_near(make_shading_point(scene, kHit, {0, 0, 1}).shading.normal, -lean, 0.01f);
            // Mirrored, the picture leans the mirrored way; turned, the turned way.
            place(scene, mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), {0, 0, 0});
            expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, {-lean.x, lean.y, lean.z}, 0.01f);
            place(scene, mat3(0, 1, 0, -1, 0, 0, 0, 0, 1), {0, 0, 0});
            expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, {-lean.y, lean.x, lean.z}, 0.01f);
        }
}

// Over interpolated normals, too, the map makes one normal for all eyes; those it faces away from see the geometric
// one.
TEST(Surface, EyesSeeTheMappedNormalOrTheGeometricOne) {
    Scene scene = triangle_scene();
    add_normal_map(scene, true);
    const vec3 leaning = glm::normalize(vec3(1, 0, 0.3f));
    scene.meshes[0].normals.assign(3, leaning);
    const vec3 mapped = glm::normalize(leaning + vec3(0, 1, 0));
    expect_near(make_shading_point(scene, kHit, -leaning).shading.normal, mapped, 0.01f);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    int turned_from_interpolated = 0, seen[2] = {};
    for (int i = 0; i < 1000; ++i) {
        const vec3 direction = glm::normalize(2.0f * vec3(random.next(), random.next(), random.next()) - 1.0f);
        const ShadingPoint point = make_shading_point(scene, kHit, direction);
        const float side = point.front_side ? 1.0f : -1.0f;
        expect_near(point.smooth_normal, side * mapped, 0.01f);
        const bool by_map = glm::dot(point.smooth_normal, direction) < 0;
        EXPECT_EQ(point.shading.normal, by_map ? point.smooth_normal : point.geometric_normal);
        ++seen[by_map];
        turned_from_interpolated += by_map && side * glm::dot(leaning, direction) >= 0;
    }
    EXPECT_GT(seen[0], 100);
    EXPECT_GT(seen[1], 100);
    EXPECT_GT(turned_from_interpolated, 50);
}

TEST(Surface, NormalScaleFlattens) {
    Scene scene = triangle_scene();
    add_normal_map(scene, false);
    scene.materials[0].normal_scale = 0;
    expect_near(make_shading_point(scene, kHit, {0, 0, -1}).shading.normal, {0, 0, 1}, 1e-5f);
}

TEST(Surface, PlainAndFullPointsAreTheSameWithoutNormalMaps) {
    Scene scene = triangle_scene();
    scene.meshes[0].normals = {{0, 0, 1}, glm::normalize(vec3(1, 0, 1)), glm::normalize(vec3(0, 1, 1))};
    place(scene, mat3(1, 0.2f, 0, 0, -1, 0.5f, 0.3f, 0, 1), {0.1f, 0.2f, 0.3f});
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 100; ++i) {
        const Hit hit{.t = 1, .instance = 0, .triangle = 0, .u = 0.5f * random.next(), .v = 0.5f * random.next()};
        const vec3 direction = glm::normalize(2.0f * vec3(random.next(), random.next(), random.next()) - 1.0f);
        const ShadingPoint full = make_shading_point(scene, hit, direction);
        const ShadingPoint plain = make_plain_shading_point(scene, hit, direction);
        EXPECT_EQ(full.position, plain.position);
        EXPECT_EQ(full.smooth_normal, plain.smooth_normal);
        EXPECT_EQ(full.shading.normal, plain.shading.normal);
        EXPECT_EQ(full.shading.tangent, plain.shading.tangent);
        EXPECT_EQ(full.geometric_normal, plain.geometric_normal);
        EXPECT_EQ(full.front_side, plain.front_side);
    }
}

TEST(Surface, TinyAndHugeTrianglesHaveNormals) {
    for (const float size : {1e-15f, 1e-9f, 1e-4f, 1e6f, 1e15f}) {
        Scene scene = triangle_scene();
        for (vec3& p : scene.meshes[0].positions) p *= size;
        scene.meshes[0].positions[2].x = 1e-6f * size;  // and a sliver's edge
        expect_near(make_shading_point(scene, kHit, {0, 0, -1}).geometric_normal, {0, 0, 1}, 1e-5f);
    }
}

TEST(MakeBsdf, MaterialsBecomeTheirLobes) {
    Scene scene = triangle_scene();
    Material& material = scene.materials[0];
    const auto bsdf_of = [&](const vec3& direction, float outside_ior = 1) {
        return make_bsdf(scene, make_shading_point(scene, kHit, direction), outside_ior);
    };
    material.metallic = 0, material.specular = 0, material.base_color = Rgb(0.3f);
    EXPECT_TRUE(bsdf_of({0, 0, -1}).is_lambert());
    EXPECT_EQ(bsdf_of({0, 0, -1}).albedo(), Rgb(0.3f));

    material.specular = 1, material.roughness = 0.5f;
    EXPECT_FALSE(bsdf_of({0, 0, -1}).is_lambert());
    EXPECT_FALSE(bsdf_of({0, 0, -1}).has_delta());
    material.roughness = 0.005f;
    EXPECT_TRUE(bsdf_of({0, 0, -1}).has_delta() && bsdf_of({0, 0, -1}).has_non_delta());
    material.metallic = 1;
    EXPECT_FALSE(bsdf_of({0, 0, -1}).has_non_delta());

    material.metallic = 0, material.transmission = 1, material.solid = true, material.base_color = Rgb(1);
    const float n = 1.5f;
    // Straight on, T = 0.96 and radiance is compressed by the square of the index.
    for (const bool front : {true, false}) {
        const Bsdf glass = bsdf_of({0, 0, front ? -1.0f : 1.0f});
        const BsdfSample s = glass.sample({0, 0, 1}, 0.5f, vec2(0.5f));
        ASSERT_TRUE(s.valid() && s.refraction);
        EXPECT_FLOAT_EQ(s.eta, front ? n : 1 / n);
        EXPECT_NEAR(s.weight.x, 1 / sqr(s.eta), 1e-5);  // chosen by its reflectance, so weighed by compression alone
        EXPECT_NEAR(s.pdf_sa, 0.96, 1e-5);
    }
    // In a medium of the same index the surface is not seen.
    EXPECT_EQ(bsdf_of({0, 0, -1}, n).sample({0, 0, 1}, 0.0f, vec2(0.5f)).wi, vec3(0, 0, -1));

    material.unlit = true;
    EXPECT_FALSE(bsdf_of({0, 0, -1}).has_non_delta() || bsdf_of({0, 0, -1}).has_delta());
    EXPECT_FALSE(bsdf_of({0, 0, -1}).sample({0, 0, 1}, 0.5f, vec2(0.5f)).valid());
}

}  // namespace
}  // namespace photond::surface_test
