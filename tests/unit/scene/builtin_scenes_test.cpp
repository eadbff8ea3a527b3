// The scenes made in code: what is promised of each, and that their meshes are what they seem.

#include "renderer/scene/builtin_scenes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "protocol/error.h"
#include "renderer/scene/mesh_builder.h"

namespace photond::builtin_scenes_test {
namespace {

using Triangle = std::array<std::array<float, 3>, 3>;

/// World-space triangles turned so that the least corner comes first: equal for equal surfaces with equal winding.
std::multiset<Triangle> canonical(const std::vector<Triangle>& triangles) {
    std::multiset<Triangle> set;
    for (Triangle t : triangles) {
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        set.insert(t);
    }
    return set;
}

std::vector<Triangle> triangles_of(const Scene& scene) {
    std::vector<Triangle> all;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t) {
            const TriangleCorners corners = world_triangle(scene, i, t);
            Triangle triangle;
            for (size_t c = 0; c < 3; ++c) triangle[c] = {corners.p[c].x, corners.p[c].y, corners.p[c].z};
            all.push_back(triangle);
        }
    return all;
}

/// The triangles of a .glb whose nodes do not move its meshes, read without the loader.
std::vector<Triangle> read_plain_glb(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const auto word = [&](size_t at) {
        uint32_t value;
        std::memcpy(&value, bytes.data() + at, 4);
        return value;
    };
    const auto json = nlohmann::json::parse(bytes.substr(20, word(12)));
    const size_t binary = 20 + word(12) + 8;
    std::vector<Triangle> all;
    for (const auto& mesh : json["meshes"])
        for (const auto& primitive : mesh["primitives"]) {
            const auto start = [&](const nlohmann::json& accessor) {
                return binary +
                       json["bufferViews"][accessor["bufferView"].get<size_t>()].value("byteOffset", size_t{0}) +
                       accessor.value("byteOffset", size_t{0});
            };
            const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
            const auto& indices = json["accessors"][primitive["indices"].get<size_t>()];
            const bool wide = indices["componentType"] == 5125;
            for (size_t i = 0; i < indices["count"].get<size_t>(); i += 3) {
                Triangle triangle;
                for (size_t c = 0; c < 3; ++c) {
                    uint32_t index = 0;
                    std::memcpy(&index, bytes.data() + start(indices) + (i + c) * (wide ? 4 : 2), wide ? 4 : 2);
                    std::memcpy(triangle[c].data(), bytes.data() + start(positions) + index * 12, 12);
                }
                all.push_back(triangle);
            }
        }
    return all;
}

TEST(BuiltinScenes, AllAreThereWithACameraAndSoundMeshes) {
    std::set<std::string_view> names(builtin_scene_names().begin(), builtin_scene_names().end());
    EXPECT_EQ(names,
              (std::set<std::string_view>{"cornell-box", "cornell-box-spot", "cornell-box-glass", "cornell-box-glossy",
                                          "furnace", "caustic-ring", "keyhole", "interior"}));
    for (const std::string_view figure : builtin_scene_names("photon-splatting")) {
        EXPECT_TRUE(figure.starts_with("photon-splatting/") && is_builtin_scene(figure)) << figure;
        names.insert(figure);
    }
    for (const std::string_view family :
         {"progressive", "small-vcm", "doors", "visibility-filtering", "real-time", "moving"})
        for (const std::string_view name : builtin_scene_names(family)) {
            EXPECT_TRUE(name.starts_with(std::string(family) + "/") && is_builtin_scene(name)) << name;
            names.insert(name);
        }
    EXPECT_EQ(names.size(), 32u);
    for (const std::string_view name : names) {
        const Scene scene = make_builtin_scene(name);
        EXPECT_EQ(scene.name, name);
        EXPECT_EQ(find_camera(scene, "camera").name, "camera");
        EXPECT_TRUE(scene.needs.area_lights || scene.needs.punctual_lights || scene.environment) << name;
        size_t degenerate = 0, against_normal = 0;
        std::string culprit;
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
            ASSERT_LT(mesh.material, scene.materials.size());
            for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                const uvec3 corner = mesh.triangles[t];
                ASSERT_LT(std::max({corner.x, corner.y, corner.z}), mesh.positions.size());
                const TriangleCorners world = world_triangle(scene, i, t);
                const dvec3 cross = glm::cross(dvec3(world.p[1] - world.p[0]), dvec3(world.p[2] - world.p[0]));
                if (!(glm::length(cross) > 0)) ++degenerate;
                if (mesh.normals.empty()) continue;
                ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
                const vec3 mean_normal = scene.instances[i].normal_to_world *
                                         (mesh.normals[corner.x] + mesh.normals[corner.y] + mesh.normals[corner.z]);
                if (glm::dot(cross, dvec3(mean_normal)) < 0) {
                    ++against_normal;
                    culprit = scene.materials[mesh.material].name;
                }
            }
        }
        EXPECT_EQ(degenerate, 0u) << name;
        EXPECT_EQ(against_normal, 0u) << name << ": triangles wound against their normals, last of " << culprit;
    }
    EXPECT_THROW(make_builtin_scene("cornell"), Error);
}

TEST(BuiltinScenes, CornellBoxIsTheReferenceScene) {
    const Scene scene = make_builtin_scene("cornell-box");
    EXPECT_EQ(scene.triangle_count, 32u);
    EXPECT_TRUE(scene.needs.only_lambert());
    ASSERT_EQ(scene.triangle_lights.size(), 2u);
    EXPECT_EQ(scene.triangle_lights[0].radiance, Rgb(17, 12, 4));
    EXPECT_FALSE(scene.triangle_lights[0].two_sided);
    EXPECT_NEAR(scene.triangle_lights[0].area_m2 + scene.triangle_lights[1].area_m2, 1.3f * 1.05f, 1e-5);
    const Camera camera = find_camera(scene, "camera");
    EXPECT_EQ(camera.position, vec3(0, 2.73f, 8));
    EXPECT_EQ(camera.forward, vec3(0, 0, -1));
    EXPECT_EQ(camera.yfov, 0.6860478808414068f);

    const std::filesystem::path reference = std::filesystem::path(PHOTOND_TEST_DATA) / "reference/scene.glb";
    ASSERT_TRUE(std::filesystem::exists(reference)) << reference;
    EXPECT_EQ(canonical(triangles_of(scene)), canonical(read_plain_glb(reference)));
}

/// Directed edges of a closed, consistently wound surface come in opposite pairs, each once.
void expect_closed(const std::vector<Triangle>& triangles) {
    std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> edges;
    for (const Triangle& t : triangles)
        for (size_t c = 0; c < 3; ++c) ++edges[{t[c], t[(c + 1) % 3]}];
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1);
        ASSERT_TRUE(edges.contains({edge.second, edge.first})) << "an open edge";
    }
}

double enclosed_volume(const std::vector<Triangle>& triangles) {
    double volume = 0;
    for (const Triangle& t : triangles) {
        const auto corner = [&](size_t c) { return dvec3(t[c][0], t[c][1], t[c][2]); };
        volume += glm::dot(corner(0), glm::cross(corner(1), corner(2))) / 6;
    }
    return volume;
}

TEST(BuiltinScenes, FurnaceIsClosedAndEmitsInwards) {
    const Scene scene = make_builtin_scene("furnace");
    const std::vector<Triangle> triangles = triangles_of(scene);
    expect_closed(triangles);
    EXPECT_LT(enclosed_volume(triangles), 0) << "fronts look inwards";
    EXPECT_NEAR(enclosed_volume(triangles), -4.0 / 3 * M_PI, 0.1);
    EXPECT_EQ(scene.triangle_lights.size(), triangles.size());
    EXPECT_EQ(scene.materials[0].emission, Rgb(1));
    EXPECT_EQ(scene.materials[0].base_color, Rgb(0.5f));
    EXPECT_EQ(find_camera(scene, "camera").position, vec3(0));
    EXPECT_TRUE(scene.needs.only_lambert());
}

TEST(BuiltinScenes, SolidGlassIsClosed) {
    // Beer's law and refraction follow a path in and out: a crack would let it out on the wrong side.
    size_t solids = 0;
    std::vector<std::string_view> names = {"cornell-box-glass", "interior"};
    const auto progressive = builtin_scene_names("progressive");
    names.insert(names.end(), progressive.begin(), progressive.end());
    for (const std::string_view name : names) {
        const Scene scene = make_builtin_scene(name);
        for (const Mesh& mesh : scene.meshes) {
            if (!scene.materials[mesh.material].solid) continue;
            Scene alone;
            alone.meshes.push_back(mesh);
            alone.instances.emplace_back();
            expect_closed(triangles_of(alone));
            EXPECT_GT(enclosed_volume(triangles_of(alone)), 0) << name;
            ++solids;
        }
    }
    EXPECT_EQ(solids, 10u);
}

TEST(BuiltinScenes, InteriorIsDetailedAndTheSameEveryTime) {
    const Scene scene = make_builtin_scene("interior"), again = make_builtin_scene("interior");
    EXPECT_GE(scene.triangle_count, 50'000u);
    EXPECT_TRUE(scene.needs.instances);
    EXPECT_TRUE(scene.needs.base_color_textures);
    EXPECT_EQ(triangles_of(scene), triangles_of(again));
    EXPECT_GT(scene.bounds.min.y, -0.01f) << "nothing below the floor";
}

TEST(MeshBuilder, ClosedShapesAreClosedAndHoldTheirVolume) {
    const auto triangles = [](const MeshBuilder& builder) {
        Scene scene;
        scene.materials.emplace_back();
        scene.meshes.push_back(builder.build(0));
        scene.instances.emplace_back();
        return triangles_of(scene);
    };
    const auto box = triangles(MeshBuilder().box({-1, 0, 2}, {1, 3, 4}));
    expect_closed(box);
    EXPECT_NEAR(enclosed_volume(box), 12, 1e-5);
    // Rounding takes from 12 edges and 8 corners: V = inner box + six slabs + 12 quarter rounds + one ball.
    const double r = 0.25, a = 2 - 2 * r, b = 3 - 2 * r, c = 2 - 2 * r;
    const double rounded_volume =
        a * b * c + 2 * r * (a * b + b * c + c * a) + M_PI * r * r * (a + b + c) + 4.0 / 3 * M_PI * r * r * r;
    const std::tuple<MeshBuilder, double, double> shapes[] = {
        {MeshBuilder().rounded_box({-1, 0, 2}, {1, 3, 4}, 0.25f, 16), rounded_volume, 0.005 * rounded_volume},
        {MeshBuilder().sphere({5, 1, 2}, 0.5f, 96), M_PI / 6, 0.002},
        {MeshBuilder().cylinder({0, 1, 0}, 0.5f, 2, 96), M_PI / 2, 0.002},
        {MeshBuilder().torus({1, 0, 0}, 2, 0.5f, 96, 48), 2 * M_PI * M_PI * 2 * 0.25, 0.05},
    };
    for (const auto& [shape, volume, tolerance] : shapes) {
        expect_closed(triangles(shape));
        EXPECT_NEAR(enclosed_volume(triangles(shape)), volume, tolerance);
    }
    Scene ball;
    ball.materials.emplace_back();
    ball.meshes.push_back(make_icosphere(2, 0));
    ball.instances.emplace_back();
    expect_closed(triangles_of(ball));
    EXPECT_EQ(ball.meshes[0].triangles.size(), 320u);
}

}  // namespace
}  // namespace photond::builtin_scenes_test
