// Geometry of loaded glTF: topologies, component types, transforms, skins and morph targets at rest, tangents.

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "protocol/error.h"
#include "renderer/scene/gltf_mesh.h"
#include "renderer/scene/scene.h"
#include "tests/support/test_gltf.h"

namespace photond::gltf_geometry_test {
namespace {

const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::vector<uint16_t> kSquareIndices = {0, 1, 2, 0, 2, 3};

std::string attribute(const std::string& name, int accessor) { return "\"" + name + "\":" + std::to_string(accessor); }

std::string member(const std::string& name, int value) { return ",\"" + name + "\":" + std::to_string(value); }

/// The corners of every triangle in world space, in order.
std::vector<vec3> corners(const Scene& scene) {
    std::vector<vec3> result;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t) {
            const TriangleCorners triangle = world_triangle(scene, i, t);
            result.insert(result.end(), triangle.p, triangle.p + 3);
        }
    return result;
}

/// Six times the signed volume under the triangles (divergence theorem): positive when a closed surface faces outwards.
double signed_volume(const Scene& scene) {
    double sum = 0;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t) {
            const TriangleCorners triangle = world_triangle(scene, i, t);
            const double six = glm::dot(dvec3(triangle.p[0]), glm::cross(dvec3(triangle.p[1]), dvec3(triangle.p[2])));
            sum += scene.instances[i].flips_orientation ? -six : six;
        }
    return sum;
}

Error load_error(const TestGltf& file, const LoadLimits& limits = {}) {
    try {
        file.load(limits);
    } catch (const Error& error) {
        return error;
    }
    return Error(ErrorCode::Internal, "loaded");
}

TEST(GltfGeometry, IndexedAndUnindexedTrianglesStripsAndFansAgree) {
    struct Topology {
        int mode;
        std::vector<uint16_t> indices;
    };
    // The same square, facing +z.
    for (const Topology& topology :
         {Topology{4, kSquareIndices}, Topology{5, {0, 1, 3, 2}}, Topology{6, {0, 1, 2, 3}}}) {
        for (const bool indexed : {true, false}) {
            std::vector<float> positions = kSquare;
            if (!indexed) {
                positions.clear();
                for (const uint16_t i : topology.indices)
                    positions.insert(positions.end(), &kSquare[size_t{i} * 3], &kSquare[size_t{i} * 3] + 3);
            }
            TestGltf file;
            const int position = file.positions(positions);
            std::string extra = member("mode", topology.mode);
            if (indexed) extra += member("indices", file.indices(topology.indices));
            file.set_mesh(attribute("POSITION", position), extra);
            const Scene scene = file.load();
            ASSERT_EQ(scene.triangle_count, 2u) << topology.mode;
            const std::vector<vec3> p = corners(scene);
            double area = 0;
            for (size_t t = 0; t < 2; ++t) {
                const vec3 n = glm::cross(p[3 * t + 1] - p[3 * t], p[3 * t + 2] - p[3 * t]);
                EXPECT_GT(n.z, 0) << "mode " << topology.mode << " turns triangle " << t;
                area += 0.5 * double{n.z};
            }
            EXPECT_EQ(area, 1);
            EXPECT_TRUE(scene.meshes[0].normals.empty()) << "no normals in the file: flat";
        }
    }
}

TEST(GltfGeometry, PointsAndLinesAreSkippedAndFlatTrianglesDropped) {
    TestGltf file;
    const int position = file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0, 0, 1, 0});
    const int indices = file.indices({0, 1, 2, 0, 0, 1, 0, 1, 3, 0, 2, 4});  // good, equal corners, in line, good
    const std::string a = R"({"attributes":{"POSITION":)" + std::to_string(position) + "}";
    file.set("meshes", R"([{"primitives":[)" + a + R"(,"mode":0},)" + a + R"(,"mode":3},)" + a +
                           member("indices", indices) + "}]}]");
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangle_count, 2u);
    EXPECT_EQ(scene.vertex_count, 5u);
    EXPECT_TRUE(has_warning(scene, "2 triangles without area"));
    EXPECT_TRUE(has_warning(scene, "2 primitives of points or lines"));
}

TEST(GltfGeometry, IndicesOfEveryWidth) {
    for (const int component : {TestGltf::kU8, TestGltf::kU16, TestGltf::kU32}) {
        TestGltf file;
        std::vector<uint8_t> bytes = component == TestGltf::kU8    ? bytes_of(std::vector<uint8_t>{0, 1, 2, 0, 2, 3})
                                     : component == TestGltf::kU16 ? bytes_of(kSquareIndices)
                                                                   : bytes_of(std::vector<uint32_t>{0, 1, 2, 0, 2, 3});
        const int position = file.positions(kSquare);
        file.set_mesh(attribute("POSITION", position),
                      member("indices", file.accessor(file.view(bytes), component, "SCALAR", 6)));
        EXPECT_EQ(corners(file.load()),
                  (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    }
}

TEST(GltfGeometry, QuantizedComponentsConvertAsTheSpecificationSays) {
    struct Quantized {
        int component;
        bool normalized;
        double scale;  // divisor
    };
    for (const Quantized& q : {Quantized{TestGltf::kI8, true, 127}, Quantized{TestGltf::kI8, false, 1},
                               Quantized{TestGltf::kU8, true, 255}, Quantized{TestGltf::kU8, false, 1},
                               Quantized{TestGltf::kI16, true, 32767}, Quantized{TestGltf::kI16, false, 1},
                               Quantized{TestGltf::kU16, true, 65535}, Quantized{TestGltf::kU16, false, 1}}) {
        TestGltf file;
        const bool is_signed = q.component == TestGltf::kI8 || q.component == TestGltf::kI16;
        const int low = is_signed ? (q.component == TestGltf::kI8 ? -128 : -32768) : 0;  // below -1 when normalized
        const std::vector<int> values = {low, 0, 0, 100, 0, 0, 0, 50, 0};
        const bool narrow = q.component == TestGltf::kI8 || q.component == TestGltf::kU8;
        std::vector<uint8_t> bytes;  // a stride of 4 components: the 4th is padding
        for (size_t i = 0; i < values.size(); ++i) {
            bytes.push_back(static_cast<uint8_t>(values[i] & 0xff));
            if (!narrow) bytes.push_back(static_cast<uint8_t>(values[i] >> 8 & 0xff));
            if (i % 3 == 2) bytes.insert(bytes.end(), narrow ? 1 : 2, 0xee);
        }
        file.set("extensionsUsed", R"(["KHR_mesh_quantization"])");
        const int view = file.view(bytes, member("byteStride", narrow ? 4 : 8));
        file.set_mesh(attribute(
            "POSITION", file.accessor(view, q.component, "VEC3", 3, q.normalized ? R"(,"normalized":true)" : "")));
        const Scene scene = file.load();
        ASSERT_EQ(scene.triangle_count, 1u);
        const std::vector<vec3> p = corners(scene);
        const double expected_low = q.normalized ? std::max(low / q.scale, -1.0) : low;
        EXPECT_FLOAT_EQ(p[0].x, static_cast<float>(expected_low));
        EXPECT_FLOAT_EQ(p[1].x, static_cast<float>(100 / q.scale));
        EXPECT_FLOAT_EQ(p[2].y, static_cast<float>(50 / q.scale));

        file.set("extensionsUsed", "[]");
        EXPECT_EQ(load_error(file).code, ErrorCode::BadScene) << "quantized positions without the extension";
    }
}

TEST(GltfGeometry, InterleavedStridesAndOffsets) {
    TestGltf file;
    std::vector<float> interleaved;
    for (size_t v = 0; v < 4; ++v) {
        interleaved.push_back(-99);
        interleaved.insert(interleaved.end(), &kSquare[3 * v], &kSquare[3 * v] + 3);
        interleaved.insert(interleaved.end(), {0, 0, 2});  // a normal that is not unit
    }
    const int view = file.view(bytes_of(interleaved), member("byteStride", 28));
    const int position = file.accessor(view, TestGltf::kF32, "VEC3", 4, member("byteOffset", 4));
    const int normal = file.accessor(view, TestGltf::kF32, "VEC3", 4, member("byteOffset", 16));
    file.set_mesh(attribute("POSITION", position) + "," + attribute("NORMAL", normal),
                  member("indices", file.indices(kSquareIndices)));
    const Scene scene = file.load();
    EXPECT_EQ(corners(scene)[2], vec3(1, 1, 0));
    EXPECT_EQ(scene.meshes[0].normals, std::vector<vec3>(4, vec3(0, 0, 1)));
}

TEST(GltfGeometry, SparseValuesReplaceTheirBaseOrZeros) {
    for (const bool with_base : {true, false}) {
        TestGltf file;
        const int base = with_base ? file.view(bytes_of(kSquare)) : -1;
        const int indices = file.view(bytes_of(std::vector<uint16_t>{1, 2}));
        const int values = file.view(bytes_of(std::vector<float>{5, 0, 0, 5, 5, 0}));
        const int position =
            file.accessor(base, TestGltf::kF32, "VEC3", 4,
                          R"(,"sparse":{"count":2,"indices":{"bufferView":)" + std::to_string(indices) +
                              R"(,"componentType":5123},"values":{"bufferView":)" + std::to_string(values) + "}}");
        file.set_mesh(attribute("POSITION", position), member("indices", file.indices(kSquareIndices)));
        const Scene scene = file.load();
        const std::vector<vec3> p = corners(scene);
        ASSERT_GE(p.size(), 3u);
        EXPECT_EQ(p[1], vec3(5, 0, 0));
        EXPECT_EQ(p[2], vec3(5, 5, 0));
        EXPECT_EQ(scene.triangle_count, with_base ? 2u : 1u) << "without a base, vertices 0 and 3 fall together";
    }
}

TEST(GltfGeometry, MeshoptCompressedViewsDecode) {
    std::vector<uint8_t> vertices(meshopt_encodeVertexBufferBound(4, 12));
    vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), kSquare.data(), 4, 12));
    const std::vector<uint32_t> wide(kSquareIndices.begin(), kSquareIndices.end());
    std::vector<uint8_t> triangles(meshopt_encodeIndexBufferBound(6, 4)),
        sequence(meshopt_encodeIndexSequenceBound(6, 4));
    triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), wide.data(), 6));
    sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), wide.data(), 6));
    const std::vector<float> up(16, 0.0f);
    std::vector<float> normals = up;
    for (size_t v = 0; v < 4; ++v) normals[4 * v + 1] = 1;  // +y
    std::vector<uint8_t> octahedral(4 * 4);
    meshopt_encodeFilterOct(octahedral.data(), 4, 4, 8, normals.data());
    std::vector<uint8_t> filtered(meshopt_encodeVertexBufferBound(4, 4));
    filtered.resize(meshopt_encodeVertexBuffer(filtered.data(), filtered.size(), octahedral.data(), 4, 4));

    for (const bool as_sequence : {false, true}) {
        TestGltf file;
        file.set("extensionsRequired", R"(["EXT_meshopt_compression","KHR_mesh_quantization"])");
        file.set("extensionsUsed", R"(["EXT_meshopt_compression","KHR_mesh_quantization"])");
        file.extra_buffers = R"(,{"byteLength":88,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})";
        size_t fallback_offset = 0;
        // A view that lies in the fallback buffer, with its data in buffer 0.
        const auto compressed = [&](const std::vector<uint8_t>& data, size_t stride, size_t count,
                                    const std::string& mode) {
            // The raw bytes are a view of their own, which tells where they lie.
            const size_t offset = (file.binary().size() + 3) / 4 * 4;
            file.view(data);
            const std::string source = R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" +
                                       std::to_string(offset) + R"(,"byteLength":)" + std::to_string(data.size()) +
                                       R"(,"byteStride":)" + std::to_string(stride) + R"(,"count":)" +
                                       std::to_string(count) + R"(,"mode":)" + mode + "}}";
            const int view = file.raw_view(
                R"({"buffer":1,"byteOffset":)" + std::to_string(fallback_offset) + R"(,"byteLength":)" +
                std::to_string(stride * count) +
                (mode.find("ATTR") != mode.npos ? member("byteStride", static_cast<int>(stride)) : "") + source + "}");
            fallback_offset += stride * count;
            return view;
        };
        const int position = file.accessor(compressed(vertices, 12, 4, R"("ATTRIBUTES")"), TestGltf::kF32, "VEC3", 4);
        const int normal = file.accessor(compressed(filtered, 4, 4, R"("ATTRIBUTES","filter":"OCTAHEDRAL")"),
                                         TestGltf::kI8, "VEC3", 4, R"(,"normalized":true)");
        const int indices = file.accessor(
            as_sequence ? compressed(sequence, 4, 6, R"("INDICES")") : compressed(triangles, 4, 6, R"("TRIANGLES")"),
            TestGltf::kU32, "SCALAR", 6);
        file.set_mesh(attribute("POSITION", position) + "," + attribute("NORMAL", normal), member("indices", indices));
        const Scene scene = file.load();
        ASSERT_EQ(scene.triangle_count, 2u);
        double area = 0;
        const std::vector<vec3> p = corners(scene);
        for (size_t t = 0; t < 6; t += 3) area += 0.5 * double{glm::cross(p[t + 1] - p[t], p[t + 2] - p[t]).z};
        EXPECT_EQ(area, 1);
        for (const vec3& n : scene.meshes[0].normals) EXPECT_NEAR(n.y, 1, 0.01);
    }
}

/// A tetrahedron that faces outwards, with its vertex normals.
void set_tetrahedron(TestGltf& file) {
    const int position = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
    const float s = 0.57735027f;
    const int normal = file.positions({-s, -s, -s, 1, 0, 0, 0, 1, 0, 0, 0, 1});
    file.set_mesh(attribute("POSITION", position) + "," + attribute("NORMAL", normal),
                  member("indices", file.indices({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})));
}

TEST(GltfGeometry, NodeTransformsComposeAndMirrorsKeepTheOutsideOut) {
    TestGltf file;
    set_tetrahedron(file);
    EXPECT_NEAR(signed_volume(file.load()), 1, 1e-6);

    // A quarter turn about z, then a mirror in x of the parent, then a move.
    file.set("nodes", R"([{"children":[1],"scale":[-2,1,1],"translation":[10,0,0]},
        {"mesh":0,"rotation":[0,0,0.70710678118,0.70710678118],"translation":[0,0,3]}])");
    const Scene scene = file.load();
    EXPECT_NEAR(signed_volume(scene), 2, 1e-5)
        << "the mirror doubles the size, and must not turn the surface inside out";
    // (1,0,0) -> turned (0,1,0) -> moved (0,1,3) -> mirrored (0,1,3) -> moved (10,1,3); its normal (1,0,0) -> (0,1,0).
    const Mesh& mesh = scene.meshes[0];
    bool found = false;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (glm::length(mesh.positions[v] - vec3(10, 1, 3)) > 1e-5f) continue;
        found = true;
        EXPECT_LT(glm::length(mesh.normals[v] - vec3(0, 1, 0)), 1e-5f);
    }
    EXPECT_TRUE(found);
    EXPECT_TRUE(scene.instances[0].identity);

    file.set("nodes", R"([{"mesh":0,"matrix":[0,0,-1,0, 0,1,0,0, 1,0,0,0, 5,6,7,1]}])");
    const Scene by_matrix = file.load();
    EXPECT_NEAR(signed_volume(by_matrix), 1, 1e-5);
    EXPECT_EQ(by_matrix.meshes[0].positions[1], vec3(5, 6, 6)) << "the first column is where x goes";
}

TEST(GltfGeometry, NormalsStayPerpendicularUnderUnevenScale) {
    TestGltf file;
    const int position = file.positions({1, 0, 0, 0, 1, 0, 0, 0, 1});
    const float s = 0.57735027f;
    const int normal = file.positions({s, s, s, s, s, s, s, s, s});
    file.set_mesh(attribute("POSITION", position) + "," + attribute("NORMAL", normal));
    file.set("nodes", R"([{"mesh":0,"scale":[1,4,-0.25]}])");
    const Scene scene = file.load();
    const Mesh& mesh = scene.meshes[0];
    const uvec3 t = mesh.triangles[0];
    const vec3 e1 = mesh.positions[t.y] - mesh.positions[t.x], e2 = mesh.positions[t.z] - mesh.positions[t.x];
    EXPECT_NEAR(glm::dot(mesh.normals[0], e1), 0, 1e-5);
    EXPECT_NEAR(glm::dot(mesh.normals[0], e2), 0, 1e-5);
    EXPECT_GT(glm::dot(mesh.normals[0], glm::cross(e1, e2)), 0);
}

/// A grid of 2 n^2 triangles.
void set_grid(TestGltf& file, uint16_t n) {
    std::vector<float> positions;
    std::vector<uint16_t> indices;
    for (uint16_t y = 0; y <= n; ++y)
        for (uint16_t x = 0; x <= n; ++x) positions.insert(positions.end(), {float(x), float(y), float(x * y % 3)});
    for (uint16_t y = 0; y < n; ++y)
        for (uint16_t x = 0; x < n; ++x) {
            const auto i = static_cast<uint16_t>(y * (n + 1) + x);
            const auto up = static_cast<uint16_t>(i + n + 1);
            for (const int corner : {int{i}, i + 1, int{up}, i + 1, up + 1, int{up}})
                indices.push_back(static_cast<uint16_t>(corner));
        }
    const int position = file.positions(positions);
    file.set_mesh(attribute("POSITION", position), member("indices", file.indices(indices)));
}

TEST(GltfGeometry, SharedMeshesAreBakedWhenSmallAndInstancedWhenLarge) {
    for (const uint16_t n : {uint16_t{10}, uint16_t{20}}) {  // 200 and 800 triangles, each twice
        TestGltf file;
        set_grid(file, n);
        file.set("nodes", R"([{"mesh":0},{"mesh":0,"translation":[100,0,0],"scale":[1,1,-2]}])");
        file.set("scenes", R"([{"nodes":[0,1]}])");
        const Scene scene = file.load();
        const bool baked = n == 10;
        EXPECT_EQ(scene.meshes.size(), baked ? 2u : 1u);
        ASSERT_EQ(scene.instances.size(), 2u);
        EXPECT_EQ(scene.instances[1].identity, baked);
        EXPECT_EQ(scene.instances[1].flips_orientation, !baked);
        EXPECT_EQ(scene.triangle_count, 4u * n * n);
        // Wherever it is stored, triangle 0 of the second copy is the first's, moved and mirrored in z.
        const TriangleCorners first = world_triangle(scene, 0, 0), second = world_triangle(scene, 1, 0);
        for (int k = 0; k < 3; ++k) {
            const int other = baked && k > 0 ? 3 - k : k;  // a baked mirror image has its corners turned
            EXPECT_EQ(second.p[other], first.p[k] * vec3(1, 1, -2) + vec3(100, 0, 0));
        }
    }
}

TEST(GltfGeometry, ASceneFarAwayIsRecentredInDouble) {
    TestGltf file;
    set_tetrahedron(file);
    // At 5e6 a float's spacing is 0.5: the tetrahedron would collapse.
    file.set(
        "nodes",
        R"([{"children":[1,2],"translation":[5000000.25,1000000,-3]},{"mesh":0},{"camera":0,"translation":[0,0,2]}])");
    file.set("cameras", R"([{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}])");
    const Scene scene = file.load();
    EXPECT_GT(glm::length(scene.origin), 4e6);
    EXPECT_NEAR(signed_volume(scene), 1, 1e-5);
    const dvec3 corner = scene.origin + dvec3(scene.meshes[0].positions[0]);
    EXPECT_NEAR(corner.x, 5000000.25, 1e-6);
    EXPECT_NEAR(corner.y, 1000000, 1e-6);
    const dvec3 eye = scene.origin + dvec3(scene.cameras[0].position);
    EXPECT_NEAR(eye.x, 5000000.25, 1e-6);
    EXPECT_NEAR(eye.z, -1, 1e-6);

    file.set("nodes", R"([{"mesh":0,"translation":[3,0,0]}])");
    EXPECT_EQ(file.load().origin, dvec3(0)) << "near scenes keep their coordinates";
}

TEST(GltfGeometry, OnlyUsedVerticesAreKept) {
    TestGltf file;
    std::vector<float> positions(3 * 1000, 7.0f);
    const std::vector<float> corner = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::copy(corner.begin(), corner.end(), positions.begin() + 3 * 500);
    const int position = file.positions(positions);
    file.set_mesh(attribute("POSITION", position), member("indices", file.indices({500, 501, 502})));
    const Scene scene = file.load();
    EXPECT_EQ(scene.vertex_count, 3u);
    EXPECT_EQ(corners(scene), (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(GltfGeometry, SkinnedMeshesStandWhereTheirJointsDo) {
    TestGltf file;
    const int position = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int joints = file.accessor(file.view(bytes_of(std::vector<uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0})),
                                     TestGltf::kU8, "VEC4", 3);
    const int weights = file.floats("VEC4", 4, {1, 0, 0, 0, 0, 1, 0, 0, 0.5f, 0.5f, 0, 0});
    // Joint 0 stands at (0,0,5); joint 1 at (0,0,9) but was bound at z = 2.
    const int inverse_bind = file.floats(
        "MAT4", 16, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -2, 1});
    file.set_mesh(attribute("POSITION", position) + "," + attribute("JOINTS_0", joints) + "," +
                  attribute("WEIGHTS_0", weights));
    file.set(
        "nodes",
        R"([{"mesh":0,"skin":0,"translation":[1000,0,0]},{"translation":[0,0,5],"children":[2]},{"translation":[0,0,4]}])");
    file.set("skins", R"([{"joints":[1,2],"inverseBindMatrices":)" + std::to_string(inverse_bind) + "}]");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    const Scene scene = file.load();
    // The node's own transform does not count (glTF 2.0, 3.7.3.3).
    EXPECT_EQ(corners(scene), (std::vector<vec3>{{0, 0, 5}, {1, 0, 7}, {0, 1, 6}}));
}

TEST(GltfGeometry, MorphTargetsStandAtTheirStoredWeights) {
    TestGltf file;
    const int position = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int target = file.positions({0, 0, 2, 0, 0, 2, 0, 0, 2});
    file.set("meshes", R"([{"weights":[0.5],"primitives":[{"attributes":{"POSITION":)" + std::to_string(position) +
                           R"(},"targets":[{"POSITION":)" + std::to_string(target) + "}]}]}]");
    EXPECT_EQ(corners(file.load())[0], vec3(0, 0, 1));
    file.set("nodes", R"([{"mesh":0,"weights":[0.25]}])");
    const Scene scene = file.load();
    EXPECT_EQ(corners(scene)[0], vec3(0, 0, 0.5f)) << "the node's weights go before the mesh's";
}

TEST(GltfGeometry, TangentsFollowTheTextureAndSplitWhereItTurns) {
    Mesh mesh;
    // Two squares side by side; u runs right on the left one and left on the right one (a mirrored texture), v runs
    // down.
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    mesh.normals.assign(6, vec3(0, 0, 1));
    mesh.uv[0] = {{0, 1}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {0, 0}};
    mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
    const Mesh before = mesh;
    build_tangents(mesh, {.texture = 0});
    EXPECT_EQ(mesh.positions.size(), 8u) << "the seam's two vertices are split";
    ASSERT_EQ(mesh.tangents.size(), 8u);
    for (size_t t = 0; t < 4; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = mesh.triangles[t][k];
            const float side = t < 2 ? 1.0f : -1.0f;
            EXPECT_EQ(mesh.positions[v], before.positions[before.triangles[t][k]]);
            EXPECT_NEAR(mesh.tangents[v].x, side, 1e-6);
            // The bitangent cross(n, t) * w points up the image, which is +y on both squares.
            const vec3 bitangent = glm::cross(mesh.normals[v], vec3(mesh.tangents[v])) * mesh.tangents[v].w;
            EXPECT_NEAR(bitangent.y, 1, 1e-6);
        }
}

TEST(GltfGeometry, TangentsAreBuiltOnlyWhereANormalMapAsks) {
    TestGltf file;
    const int position = file.positions(kSquare);
    const int uv = file.floats("VEC2", 2, {0, 1, 1, 1, 1, 0, 0, 0});
    const int image = file.view(make_png({1, 1}, {{128, 128, 255, 255}}));
    file.set("images", R"([{"bufferView":)" + std::to_string(image) + R"(,"mimeType":"image/png"}])");
    file.set("textures", R"([{"source":0}])");
    file.set_mesh(attribute("POSITION", position) + "," + attribute("TEXCOORD_0", uv),
                  member("indices", file.indices(kSquareIndices)) + member("material", 0));
    file.set("materials", R"([{"normalTexture":{"index":0}}])");
    const Scene with = file.load();
    ASSERT_EQ(with.meshes[0].tangents.size(), 6u) << "flat: three vertices a triangle";
    for (const vec4& t : with.meshes[0].tangents) EXPECT_EQ(t, vec4(1, 0, 0, 1));
    file.set("materials", R"([{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])");
    EXPECT_TRUE(file.load().meshes[0].tangents.empty());
    file.set("materials", "[{}]");
    const Scene without = file.load();
    EXPECT_TRUE(without.meshes[0].uv[0].empty()) << "what no texture reads is not kept";
    EXPECT_TRUE(without.textures.empty());
}

TEST(GltfGeometry, TooManyTrianglesAreRefusedBeforeTheyAreRead) {
    TestGltf file;
    set_grid(file, 10);
    file.set("nodes", R"([{"mesh":0},{"mesh":0}])");
    file.set("scenes", R"([{"nodes":[0,1]}])");
    EXPECT_NO_THROW(file.load({.max_triangles = 400}));
    const Error error = load_error(file, {.max_triangles = 399});
    EXPECT_EQ(error.code, ErrorCode::BadScene);
    ASSERT_FALSE(error.faults.empty());
    EXPECT_EQ(error.faults[0].pointer, "/nodes/1/mesh");
}

}  // namespace
}  // namespace photond::gltf_geometry_test
