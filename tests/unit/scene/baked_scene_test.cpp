// Scenes as baked files: every bit of every field comes back, and what is no such file is refused, whatever it claims,
// for little memory.

#include "renderer/scene/baked_scene.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <new>
#include <tuple>

#include "protocol/error.h"
#include "protocol/scene_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/test_gltf.h"

namespace {
std::atomic<size_t> g_largest_allocation = 0;

void* counted_allocation(size_t bytes) {
    size_t largest = g_largest_allocation;
    while (bytes > largest && !g_largest_allocation.compare_exchange_weak(largest, bytes)) {
    }
    return std::malloc(bytes);
}
}  // namespace

// Every vector and string allocates through these; inlined, GCC takes free() for no match of new.
[[gnu::noinline]] void* operator new(size_t bytes) {
    if (void* memory = counted_allocation(bytes)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace photond::baked_scene_test {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMagicBytes = 31;

template <class T, class S>
inline constexpr bool kIs = std::is_same_v<std::remove_const_t<T>, S>;

/// The fields of a struct whose bytes alone do not say whether two are the same. A field that is added to one of them
/// does not compile here until it is listed, and is then asked for below.
template <class T>
auto fields(T& object) {
    if constexpr (kIs<T, TextureRef>) {
        auto& [texture, uv_set, row_u, row_v] = object;
        return std::tie(texture, uv_set, row_u, row_v);
    } else if constexpr (kIs<T, Texture>) {
        auto& [name, size, texels, wrap_s, wrap_t, nearest] = object;
        return std::tie(name, size, texels, wrap_s, wrap_t, nearest);
    } else if constexpr (kIs<T, Material>) {
        auto& [name, base_color, alpha, base_color_texture, metallic, roughness, metallic_roughness_texture,
               normal_texture, normal_scale, emission, emission_texture, ior, specular, specular_color,
               specular_texture, specular_color_texture, transmission, transmission_texture, solid, attenuation_color,
               attenuation_distance, alpha_mode, alpha_cutoff, double_sided, unlit] = object;
        return std::tie(name, base_color, alpha, base_color_texture, metallic, roughness, metallic_roughness_texture,
                        normal_texture, normal_scale, emission, emission_texture, ior, specular, specular_color,
                        specular_texture, specular_color_texture, transmission, transmission_texture, solid,
                        attenuation_color, attenuation_distance, alpha_mode, alpha_cutoff, double_sided, unlit);
    } else if constexpr (kIs<T, Mesh>) {
        auto& [positions, normals, tangents, uv, colors, triangles, material] = object;
        return std::tie(positions, normals, tangents, uv[0], uv[1], colors, triangles, material);
    } else if constexpr (kIs<T, Instance>) {
        auto& [mesh, identity, to_world, normal_to_world, flips_orientation] = object;
        return std::tie(mesh, identity, to_world, normal_to_world, flips_orientation);
    } else if constexpr (kIs<T, PunctualLight>) {
        auto& [name, kind, intensity, position, direction, cos_inner, cos_outer, range_m] = object;
        return std::tie(name, kind, intensity, position, direction, cos_inner, cos_outer, range_m);
    } else if constexpr (kIs<T, Camera>) {
        auto& [name, orthographic, yfov, ymag, position, right, up, forward, aperture_radius_m, focus_distance_m] =
            object;
        return std::tie(name, orthographic, yfov, ymag, position, right, up, forward, aperture_radius_m,
                        focus_distance_m);
    } else if constexpr (kIs<T, EnvironmentMap>) {
        auto& [size, radiance] = object;
        return std::tie(size, radiance);
    } else if constexpr (kIs<T, Environment>) {
        auto& [map, scale, rotation] = object;
        return std::tie(map, scale, rotation);
    } else if constexpr (kIs<T, TriangleLight>) {
        auto& [instance, triangle, area_m2, radiance, two_sided] = object;
        return std::tie(instance, triangle, area_m2, radiance, two_sided);
    } else if constexpr (kIs<T, Scene>) {
        // Of the file that a scene comes from, and not of the scene: what moves, file_bytes and warnings.
        auto& [name, meshes, instances, materials, textures, punctual_lights, cameras, environment, rig, posed, moment,
               triangle_lights, bounds, needs, inside_view, origin, triangle_count, vertex_count, file_bytes,
               warnings] = object;
        return std::tie(name, meshes, instances, materials, textures, punctual_lights, cameras, environment,
                        triangle_lights, bounds, needs, inside_view, origin, triangle_count, vertex_count);
    } else {
        return std::tuple<>();
    }
}

template <class T>
inline constexpr bool kHasFields = std::tuple_size_v<decltype(fields(std::declval<T&>()))> > 0;

/// Calls ask(left, right, place) for all that two objects are made of.
template <class T, class Ask>
void pair_up(const T& left, const T& right, const std::string& place, const Ask& ask) {
    if constexpr (kHasFields<const T>) {
        [&]<size_t... i>(std::index_sequence<i...>) {
            const auto l = fields(left), r = fields(right);
            (pair_up(std::get<i>(l), std::get<i>(r), place + "." + std::to_string(i), ask), ...);
        }
        (std::make_index_sequence<std::tuple_size_v<decltype(fields(left))>>());
    } else {
        ask(left, right, place);
    }
}

template <class T>
bool same_bytes(const T* left, const T* right, size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    return count == 0 || std::memcmp(left, right, count * sizeof(T)) == 0;
}

struct ExpectSame {
    template <class T>
    void operator()(const T& left, const T& right, const std::string& place) const {
        EXPECT_TRUE(same_bytes(&left, &right, 1)) << place;
    }
    void operator()(const std::string& left, const std::string& right, const std::string& place) const {
        EXPECT_EQ(left, right) << place;
    }
    template <class T>
    void operator()(const std::vector<T>& left, const std::vector<T>& right, const std::string& place) const {
        ASSERT_EQ(left.size(), right.size()) << place;
        if constexpr (kHasFields<const T>) {
            for (size_t i = 0; i < left.size(); ++i)
                pair_up(left[i], right[i], place + "[" + std::to_string(i) + "]", *this);
        } else {
            EXPECT_TRUE(same_bytes(left.data(), right.data(), left.size())) << place;
        }
    }
    template <class T>
    void operator()(const std::optional<T>& left, const std::optional<T>& right, const std::string& place) const {
        ASSERT_EQ(left.has_value(), right.has_value()) << place;
        if (left) pair_up(*left, *right, place, *this);
    }
};

/// Makes every field unlike its default and unlike its neighbours; vectors get three elements.
struct Fill {
    int next = 2;

    template <class T>
    void operator()(T& field) {
        if constexpr (kHasFields<T>)
            std::apply([&](auto&... inner) { ((*this)(inner), ...); }, fields(field));
        else if constexpr (std::is_same_v<T, bool>)
            field = !field;
        else if constexpr (std::is_enum_v<T>)
            field = static_cast<T>(1);
        else if constexpr (std::is_same_v<T, Size2>)
            field = {3, 1};
        else if constexpr (std::is_arithmetic_v<T>)
            field = static_cast<T>(next++);
        else
            components(field);
    }
    template <class T>
    void components(T& vector) {
        typename T::value_type values[sizeof(T) / sizeof(typename T::value_type)];
        for (auto& value : values) (*this)(value);
        std::memcpy(&vector, values, sizeof vector);
    }
    void operator()(std::string& text) { text = "text " + std::to_string(next++); }
    template <class T>
    void operator()(std::vector<T>& vector) {
        vector.resize(3);
        for (T& element : vector) (*this)(element);
    }
    template <class T>
    void operator()(std::optional<T>& optional) {
        (*this)(optional.emplace());
    }
};

/// A small scene with everything in it.
Scene full_scene() {
    Scene scene;
    Fill fill;
    auto given = std::tie(scene.name, scene.meshes, scene.instances, scene.materials, scene.textures,
                          scene.punctual_lights, scene.cameras, scene.environment, scene.origin);
    std::apply([&](auto&... field) { (fill(field), ...); }, given);
    uint32_t index = 0;
    for (Mesh& mesh : scene.meshes) {
        mesh.material = 2 - index++;
        for (uvec3& corner : mesh.triangles) corner = {0, 1, 2};
    }
    scene.materials[1].unlit = scene.materials[2].unlit = false;  // what is unlit needs nothing else
    scene.instances[0].mesh = 2, scene.instances[1].mesh = 0, scene.instances[2].mesh = 2;
    for (Material& m : scene.materials)
        for (TextureRef* reference :
             {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
              &m.specular_texture, &m.specular_color_texture, &m.transmission_texture})
            reference->texture = static_cast<int32_t>(index++ % 3), reference->uv_set = index % 2;
    finish_scene(scene);
    return scene;
}

class BakedScene : public testing::Test {
protected:
    fs::path file() const { return folder_.path() / "scene.baked"; }

    Scene round_trip(const Scene& scene) const {
        write_baked_scene(scene, file());
        EXPECT_EQ(fs::file_size(file()), baked_scene_bytes(scene));
        return read_baked_scene(file());
    }
    void expect_the_same(const Scene& scene) const {
        const Scene back = round_trip(scene);
        pair_up(scene, back, "scene", ExpectSame());
        const std::vector<uint8_t> first = bytes();
        round_trip(back);
        EXPECT_EQ(first, bytes()) << "the same scene makes the same bytes";
    }
    std::vector<uint8_t> bytes() const {
        std::ifstream in(file(), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    /// What reading these bytes throws; empty when they are a scene. Anything else than BadScene gets out.
    std::string refusal(std::span<const uint8_t> data) const {
        TestGltf::write(file(), data);
        return refusal();
    }
    std::string refusal() const {
        try {
            read_baked_scene(file());
            return "";
        } catch (const Error& error) {
            if (error.code != ErrorCode::BadScene) throw;
            EXPECT_NE(std::string(error.what()).find(file().string()), std::string::npos) << error.what();
            return error.what();
        }
    }
    /// Of a scene that has been spoilt: written as it is, for the writer trusts what it gets.
    std::string refusal_of(const std::function<void(Scene&)>& spoil) const {
        Scene scene = full_scene();
        spoil(scene);
        write_baked_scene(scene, file());
        return refusal();
    }

    const TemporaryFolder folder_;
};

TEST_F(BakedScene, EveryFieldComesBack) {
    const Scene scene = full_scene();
    EXPECT_TRUE(scene.needs.instances && scene.needs.environment && scene.needs.punctual_lights &&
                scene.needs.material_textures && scene.needs.vertex_colors);
    expect_the_same(scene);
}

TEST_F(BakedScene, NothingComesBackAsNothing) {
    Scene scene;
    finish_scene(scene);
    expect_the_same(scene);
}

TEST_F(BakedScene, BuiltInScenesComeBack) {
    std::vector<std::string_view> names(builtin_scene_names().begin(), builtin_scene_names().end());
    for (const std::string_view family : kSceneFamilies)
        names.insert(names.end(), builtin_scene_names(family).begin(), builtin_scene_names(family).end());
    EXPECT_GT(names.size(), 20u);
    for (const std::string_view name : names) {
        SCOPED_TRACE(name);
        expect_the_same(make_builtin_scene(name));
    }
}

TEST_F(BakedScene, LoadedScenesComeBack) {
    const fs::path reference = fs::path(PHOTOND_TEST_DATA) / "reference";
    const Scene loaded = load_gltf(reference / "scene.glb", reference, decode_texture);
    EXPECT_GT(loaded.triangle_count, 0u);
    expect_the_same(loaded);

    TestGltf gltf;
    const std::string position = std::to_string(gltf.positions({0, 0, 0, 1, 0, 0, 0, 1, 0}));
    const std::string uv = std::to_string(gltf.floats("VEC2", 2, {0, 0, 1, 0, 0, 1}));
    const int image = gltf.view(make_png({2, 2}, {{255, 0, 0, 255}, {0, 255, 0, 9}, {0, 0, 255, 255}, {9, 9, 9, 128}}));
    gltf.set_mesh(R"("POSITION":)" + position + R"(,"TEXCOORD_0":)" + uv, R"(,"material":0)");
    gltf.set("images", R"([{"bufferView":)" + std::to_string(image) + R"(,"mimeType":"image/png"}])");
    gltf.set("samplers", R"([{"magFilter":9728,"wrapS":33071,"wrapT":33648}])");
    gltf.set("textures", R"([{"source":0},{"source":0,"sampler":0}])");
    gltf.set("materials", R"([{"alphaMode":"MASK","normalTexture":{"index":1},"emissiveTexture":{"index":0},
        "emissiveFactor":[1,1,1],"pbrMetallicRoughness":{"baseColorTexture":{"index":0},
        "metallicRoughnessTexture":{"index":1}}}])");
    gltf.set("nodes", R"([{"mesh":0,"children":[1]},{"mesh":0,"translation":[0,0,1],"scale":[1,-1,1]}])");
    const Scene textured = gltf.load();
    EXPECT_EQ(textured.textures.size(), 2u);
    EXPECT_TRUE(textured.needs.normal_maps && textured.needs.alpha && textured.needs.emission_textures);
    EXPECT_FALSE(textured.triangle_lights.empty());
    EXPECT_FALSE(textured.meshes.front().tangents.empty());
    expect_the_same(textured);
}

TEST_F(BakedScene, EveryPartOfAFileIsRefused) {
    write_baked_scene(full_scene(), file());
    const std::vector<uint8_t> whole = bytes();
    ASSERT_EQ(refusal(whole), "");
    for (size_t length = whole.size(); length-- > 0;) {
        fs::resize_file(file(), length);
        ASSERT_NE(refusal(), "") << "the first " << length << " of " << whole.size();
    }
    std::vector<uint8_t> longer = whole;
    longer.push_back(0);
    EXPECT_NE(refusal(longer).find("goes on after its end"), std::string::npos);
}

TEST_F(BakedScene, OtherFilesAreRefused) {
    write_baked_scene(full_scene(), file());
    std::vector<uint8_t> other = bytes();
    const char* const kOther = "is not a baked scene of this version";
    for (size_t i = 0; i < kMagicBytes; ++i) {
        other[i] ^= 1;
        EXPECT_NE(refusal(other).find(kOther), std::string::npos) << "byte " << i;
        other[i] ^= 1;
    }
    EXPECT_NE(refusal(TestGltf().glb()).find(kOther), std::string::npos);
    fs::remove(file());
    EXPECT_NE(refusal(), "") << "no file";
    fs::create_directory(file());
    EXPECT_NE(refusal(), "") << "a folder";
}

TEST_F(BakedScene, NothingIsAllocatedForWildCounts) {
    write_baked_scene(full_scene(), file());
    const std::vector<uint8_t> whole = bytes();
    // What the test itself and the stream's buffer take, and what a file may: a few times its size.
    const size_t allowed = std::max<size_t>(4 * whole.size(), 1 << 16);
    std::fstream spoilt(file(), std::ios::in | std::ios::out | std::ios::binary);
    const auto put = [&](size_t at, const void* data, size_t size) {
        spoilt.seekp(static_cast<std::streamoff>(at));
        spoilt.write(static_cast<const char*>(data), static_cast<std::streamsize>(size)).flush();
    };
    size_t refused = 0;
    for (const uint64_t wild : {UINT64_MAX / 2, uint64_t{whole.size()}})
        for (size_t at = kMagicBytes; at + sizeof wild <= whole.size(); ++at) {
            put(at, &wild, sizeof wild);
            g_largest_allocation = 0;
            refused += refusal() != "";
            ASSERT_LE(g_largest_allocation, allowed) << wild << " at byte " << at;
            put(at, &whole[at], sizeof wild);
        }
    ASSERT_TRUE(spoilt);
    EXPECT_EQ(bytes(), whole);
    EXPECT_GT(refused, 1000u) << "counts, references and numbers were hit";
}

TEST_F(BakedScene, WhatRefersToNothingIsRefused) {
    const auto expect = [&](const std::string& reason, const std::function<void(Scene&)>& spoil) {
        EXPECT_NE(refusal_of(spoil).find(reason), std::string::npos) << reason << ", not: " << refusal();
    };
    ASSERT_EQ(refusal_of([](Scene&) {}), "");
    for (const uint32_t beyond : {3u, UINT32_MAX}) {
        expect("material that is not there", [&](Scene& s) { s.meshes[1].material = beyond; });
        expect("mesh that is not there", [&](Scene& s) { s.instances[2].mesh = beyond; });
        for (int corner = 0; corner < 3; ++corner)
            expect("vertex that is not there", [&](Scene& s) { s.meshes[0].triangles[2][corner] = beyond; });
    }
    expect("vertex that is not there", [](Scene& s) {
        Mesh& mesh = s.meshes[0];
        mesh = Mesh();
        mesh.triangles = {{0, 0, 0}};
    });
    for (const int32_t beyond : {3, INT32_MAX, -2, INT32_MIN})
        expect("texture that is not there", [&](Scene& s) { s.materials[1].transmission_texture.texture = beyond; });
    expect("texture that is not there", [](Scene& s) { s.materials[1].emission_texture.uv_set = 2; });
    expect("do not fit its vertices", [](Scene& s) { s.meshes[2].normals.pop_back(); });
    expect("do not fit its vertices", [](Scene& s) { s.meshes[2].tangents.resize(4); });
    expect("do not fit its vertices", [](Scene& s) { s.meshes[2].uv[0].pop_back(); });
    expect("do not fit its vertices", [](Scene& s) { s.meshes[2].uv[1].pop_back(); });
    expect("do not fit its vertices", [](Scene& s) { s.meshes[2].colors.pop_back(); });
    expect("texture that is not whole", [](Scene& s) { s.textures[0].texels.pop_back(); });
    expect("texture that is not whole", [](Scene& s) { s.textures[0].size = {UINT32_MAX, UINT32_MAX}; });
    expect("texture that is not whole", [](Scene& s) { s.textures[0].size = {}, s.textures[0].texels.clear(); });
    expect("texture that is not whole", [](Scene& s) { s.textures[1].wrap_t = static_cast<Wrap>(3); });
    expect("texture that is not whole", [](Scene& s) { s.textures[1].wrap_s = static_cast<Wrap>(255); });
    expect("no alpha mode", [](Scene& s) { s.materials[0].alpha_mode = static_cast<AlphaMode>(3); });
    expect("light of no kind", [](Scene& s) { s.punctual_lights[0].kind = static_cast<PunctualLight::Kind>(3); });
    expect("environment that is not whole", [](Scene& s) { s.environment->map.size.height = 2; });
    expect("environment that is not whole", [](Scene& s) { s.environment->map = {}; });
}

TEST_F(BakedScene, NumbersAreNumbers) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float wrong : {nan, kInfinity, -kInfinity}) {
        EXPECT_NE(refusal_of([&](Scene& s) { s.meshes[1].positions[2].z = wrong; }), "");
        EXPECT_NE(refusal_of([&](Scene& s) { s.meshes[1].uv[1][0].y = wrong; }), "");
        EXPECT_NE(refusal_of([&](Scene& s) { s.environment->map.radiance[2].b = wrong; }), "");
    }
    EXPECT_NE(refusal_of([&](Scene& s) { s.materials[1].roughness = nan; }), "");
    EXPECT_NE(refusal_of([&](Scene& s) { s.instances[1].to_world[3].z = nan; }), "");
    EXPECT_NE(refusal_of([&](Scene& s) { s.origin.z = double{nan}; }), "");
    EXPECT_EQ(refusal_of([&](Scene& s) { s.punctual_lights[1].range_m = kInfinity; }), "");
    EXPECT_EQ(refusal_of([&](Scene& s) { s.materials[1].attenuation_distance = kInfinity; }), "");
}

TEST_F(BakedScene, WhatCannotBeWrittenLeavesNothing) {
    const Scene scene = full_scene();
    EXPECT_THROW(write_baked_scene(scene, folder_.path() / "none" / "scene.baked"), Error);
    fs::create_directories(file() / "in the way");
    EXPECT_THROW(write_baked_scene(scene, file()), Error);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace photond::baked_scene_test
