// The photon map as a glTF file: it is one by the letter of the specification (chunks, alignment, bounds, lists), it
// says of every photon what the map says, and our own loader takes it with a warning.

#include "renderer/photons/photon_cloud.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/scene.h"
#include "tests/support/temporary_folder.h"

namespace photond::photon_cloud_test {
namespace {

using nlohmann::json;

std::vector<Photon> random_photons(size_t count, uint64_t stream) {
    std::vector<Photon> photons;
    for (size_t i = 0; i < count; ++i) {
        RandomStream random(11, RandomDomain::Test, static_cast<uint32_t>(stream), i);
        const auto number = [&] { return 2 * random.next() - 1; };
        const auto unit = [&] { return glm::normalize(vec3(number(), number(), number()) + vec3(1e-3f)); };
        const vec3 position(number(), 3 * number(), number());
        const Rgb power = std::exp(4 * number()) * Rgb(random.next(), random.next(), random.next());
        const vec3 wi = unit(), normal = unit();
        photons.push_back({position, PhotonPayload::make(power, wi, normal, static_cast<uint32_t>(i % 300), i % 2)});
    }
    return photons;
}

PhotonMap map_of(const std::vector<Photon>& photons) { return PhotonMap(photons, PhotonSearch{}); }

/// A binary glTF taken apart.
struct Glb {
    json document;
    std::string data;

    explicit Glb(const std::filesystem::path& path) {
        std::ifstream file(path, std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(file), {});
        const auto word = [&](size_t at) {
            uint32_t value = 0;
            if (at + 4 <= bytes.size()) std::memcpy(&value, bytes.data() + at, 4);
            return value;
        };
        EXPECT_EQ(bytes.substr(0, 4), "glTF");
        EXPECT_EQ(word(4), 2u);
        EXPECT_EQ(word(8), bytes.size());
        EXPECT_EQ(bytes.substr(16, 4), "JSON");
        EXPECT_EQ(word(12) % 4, 0u);
        document = json::parse(bytes.substr(20, word(12)));
        const size_t next = 20 + word(12);
        if (next == bytes.size()) return;
        EXPECT_EQ(bytes.substr(next + 4, 4), std::string("BIN\0", 4));
        EXPECT_EQ(word(next) % 4, 0u);
        data = bytes.substr(next + 8);
        EXPECT_EQ(data.size(), word(next));
    }

    /// Component `k` of element `i` of an accessor of floats, which has to lie within its view and that in the buffer.
    float number(size_t accessor_index, size_t i, size_t k) const {
        const json& accessor = document.at("accessors").at(accessor_index);
        const json& view = document.at("bufferViews").at(accessor.at("bufferView").get<size_t>());
        const size_t offset = accessor.at("byteOffset").get<size_t>(), stride = view.at("byteStride").get<size_t>();
        const size_t within = offset + i * stride + 4 * k;
        EXPECT_LE(within + 4, view.at("byteLength").get<size_t>());
        const size_t at = view.at("byteOffset").get<size_t>() + within;
        EXPECT_LE(at + 4, data.size());
        float value = 0;
        std::memcpy(&value, data.data() + at, 4);
        return value;
    }
    vec3 vector(size_t accessor, size_t i) const {
        return {number(accessor, i, 0), number(accessor, i, 1), number(accessor, i, 2)};
    }
};

class PhotonCloud : public testing::Test {
protected:
    Glb write(const PhotonMap& global, const PhotonMap& caustic, const dvec3& origin = dvec3(0)) {
        write_photon_cloud(global, caustic, origin, path());
        return Glb(path());
    }
    std::filesystem::path path() const { return folder_.path() / "map.glb"; }

    /// Every attribute of a primitive against the map it is of.
    void expect_says(const Glb& glb, size_t primitive_index, const PhotonMap& map, const char* name) {
        const json& primitive = glb.document["meshes"][0]["primitives"][primitive_index];
        EXPECT_EQ(primitive["mode"], 0) << "POINTS";
        EXPECT_EQ(glb.document["materials"][primitive["material"].get<size_t>()]["name"], name);
        const json& attributes = primitive["attributes"];
        EXPECT_EQ(attributes.size(), 6u);
        for (const auto& [attribute, index] : attributes.items()) {
            const json& accessor = glb.document["accessors"][index.get<size_t>()];
            EXPECT_EQ(accessor["componentType"], 5126);
            EXPECT_EQ(accessor["count"], map.size());
            EXPECT_EQ(accessor["type"], attribute == "_SCATTERINGS" ? "SCALAR" : "VEC3");
            EXPECT_EQ(accessor["byteOffset"].get<size_t>() % 4, 0u);
            const json& view = glb.document["bufferViews"][accessor["bufferView"].get<size_t>()];
            EXPECT_EQ(view["byteStride"].get<size_t>() % 4, 0u);
            EXPECT_LE(view["byteStride"].get<size_t>(), 252u);
            EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
            EXPECT_EQ(view["target"], 34962);
        }
        vec3 low(kInfinity), high(-kInfinity);
        double luminance_sum = 0, power_sum = 0;
        for (uint32_t i = 0; i < map.size(); ++i) {
            const PhotonPayload& payload = map.payload(i);
            const vec3 position = glb.vector(attributes["POSITION"], i), color = glb.vector(attributes["COLOR_0"], i);
            EXPECT_EQ(position, map.position(i));
            EXPECT_EQ(glb.vector(attributes["NORMAL"], i), payload.normal());
            EXPECT_NEAR(glm::length(glb.vector(attributes["NORMAL"], i)), 1, 1e-5);
            EXPECT_EQ(glb.vector(attributes["_POWER"], i), payload.power_w);
            EXPECT_EQ(glb.vector(attributes["_DIRECTION"], i), payload.wi_world());
            EXPECT_EQ(glb.number(attributes["_SCATTERINGS"], i, 0), static_cast<float>(payload.scatterings()));
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(color, vec3(0))) &&
                        glm::all(glm::lessThanEqual(color, vec3(1))));
            low = glm::min(low, position), high = glm::max(high, position);
            if (max_component(color) < 1)  // not cut: a multiple of the power
                luminance_sum += double{luminance(color)}, power_sum += double{luminance(payload.power_w)};
        }
        const json& position = glb.document["accessors"][attributes["POSITION"].get<size_t>()];
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(position["min"][size_t(k)].get<float>(), low[k]);
            EXPECT_EQ(position["max"][size_t(k)].get<float>(), high[k]);
        }
        double all_power = 0;
        for (uint32_t i = 0; i < map.size(); ++i) all_power += double{luminance(map.payload(i).power_w)};
        const double scale = kPhotonCloudMeanLuminance * static_cast<double>(map.size()) / all_power;
        EXPECT_NEAR(luminance_sum, scale * power_sum, 1e-5 * scale * power_sum);
    }

private:
    TemporaryFolder folder_;
};

TEST_F(PhotonCloud, SaysOfEveryPhotonWhatTheMapSays) {
    // More than one write of the file's points, and not a whole number of them.
    const PhotonMap global = map_of(random_photons(5000, 0)), caustic = map_of(random_photons(321, 1));
    const Glb glb = write(global, caustic, {1e6 + 0.1, -2, 3});
    EXPECT_EQ(glb.document["asset"]["version"], "2.0");
    const json& node = glb.document["nodes"][glb.document["scenes"][0]["nodes"][0].get<size_t>()];
    EXPECT_EQ(node["translation"], json({1e6 + 0.1, -2.0, 3.0}));
    ASSERT_EQ(glb.document["meshes"][node["mesh"].get<size_t>()]["primitives"].size(), 2u);
    expect_says(glb, 0, global, "global photons");
    expect_says(glb, 1, caustic, "caustic photons");
    EXPECT_EQ(glb.document["buffers"], json::parse(R"([{"byteLength": )" + std::to_string(glb.data.size()) + "}]"));
    const auto bytes = std::filesystem::file_size(path());
    EXPECT_LE(bytes, photon_cloud_bytes(5321));
    EXPECT_GE(bytes + 4096, photon_cloud_bytes(5321));
}

TEST_F(PhotonCloud, LeavesOutWhatIsEmpty) {
    const PhotonMap one = map_of(random_photons(1, 2));
    const Glb caustic_only = write(PhotonMap(), one);
    ASSERT_EQ(caustic_only.document["meshes"][0]["primitives"].size(), 1u);
    expect_says(caustic_only, 0, one, "caustic photons");
    const Glb empty = write(PhotonMap(), PhotonMap());
    EXPECT_FALSE(empty.document.contains("meshes") || empty.document.contains("buffers"));
    EXPECT_FALSE(empty.document["nodes"][0].contains("mesh"));
    EXPECT_TRUE(empty.data.empty());
}

TEST_F(PhotonCloud, PowerThatIsNilGivesBlack) {
    std::vector<Photon> dark = random_photons(3, 3);
    for (Photon& photon : dark) photon.payload.power_w = Rgb(0);
    const Glb glb = write(map_of(dark), PhotonMap());
    const json& attributes = glb.document["meshes"][0]["primitives"][0]["attributes"];
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(glb.vector(attributes["COLOR_0"], i), vec3(0));
}

TEST_F(PhotonCloud, OurOwnLoaderPassesOverThePoints) {
    write(map_of(random_photons(100, 4)), PhotonMap());
    try {
        const Scene scene = load_gltf(path(), path().parent_path(), [](auto, const auto&) { return Texture(); });
        EXPECT_EQ(scene.triangle_count, 0u);
        EXPECT_FALSE(scene.warnings.empty());
    } catch (const Error& error) {  // a file of points alone has nothing to render; but it was read to its end
        EXPECT_EQ(error.code, ErrorCode::BadScene);
        EXPECT_NE(std::string(error.what()).find("triangle"), std::string::npos) << error.what();
    }
}

TEST_F(PhotonCloud, AFolderThatIsNotThereIsAnError) {
    EXPECT_THROW(write_photon_cloud(PhotonMap(), PhotonMap(), dvec3(0), "/nowhere/map.glb"), Error);
}

}  // namespace
}  // namespace photond::photon_cloud_test
