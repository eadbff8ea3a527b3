#include "renderer/photons/photon_cloud.h"

#include <bit>
#include <cstdio>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"

namespace photond {

namespace {

/// A photon as it lies in the file's buffer, all attributes side by side.
struct CloudPoint {
    vec3 position;
    vec3 normal;
    Rgb color;
    Rgb power_w;
    vec3 direction;
    float scatterings;
};
static_assert(sizeof(CloudPoint) == 64 && std::endian::native == std::endian::little, "written as it lies in memory");

struct Attribute {
    const char* name;
    size_t offset;
    const char* type;
};
constexpr Attribute kAttributes[] = {
    {"POSITION", offsetof(CloudPoint, position), "VEC3"},
    {"NORMAL", offsetof(CloudPoint, normal), "VEC3"},
    {"COLOR_0", offsetof(CloudPoint, color), "VEC3"},
    {"_POWER", offsetof(CloudPoint, power_w), "VEC3"},
    {"_DIRECTION", offsetof(CloudPoint, direction), "VEC3"},
    {"_SCATTERINGS", offsetof(CloudPoint, scatterings), "SCALAR"},
};

constexpr size_t kPointsAtOnce = 4096;
constexpr uint64_t kJsonBytes = 4096;  // about what the document takes, whatever the number of photons

struct Cloud {
    const char* name;
    const PhotonMap* map;
    vec3 low{kInfinity}, high{-kInfinity};
    float color_per_watt = 0;
};

Cloud measured(const char* name, const PhotonMap& map) {
    Cloud cloud{name, &map};
    double luminance_w = 0;
    for (uint32_t i = 0; i < map.size(); ++i) {
        const vec3 position = map.position(i);
        cloud.low = glm::min(cloud.low, position), cloud.high = glm::max(cloud.high, position);
        luminance_w += double{luminance(map.payload(i).power_w)};
    }
    if (luminance_w > 0)
        cloud.color_per_watt =
            static_cast<float>(kPhotonCloudMeanLuminance * static_cast<double>(map.size()) / luminance_w);
    return cloud;
}

CloudPoint point_of(const Cloud& cloud, uint32_t i) {
    const PhotonPayload& payload = cloud.map->payload(i);
    return {cloud.map->position(i), payload.normal(),   glm::min(payload.power_w * cloud.color_per_watt, Rgb(1)),
            payload.power_w,        payload.wi_world(), static_cast<float>(payload.scatterings())};
}

/// Nine digits bring a float back bit by bit, seventeen a double.
std::string number(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", double{value});
    return text;
}
std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}
template <class Vector>
std::string array_of(const Vector& v) {
    return "[" + number(v.x) + "," + number(v.y) + "," + number(v.z) + "]";
}

std::string joined(const std::vector<std::string>& items) {
    std::string list;
    for (const std::string& item : items) list += (list.empty() ? "" : ",") + item;
    return "[" + list + "]";
}

std::string document(const std::vector<Cloud>& clouds, const dvec3& origin) {
    std::vector<std::string> primitives, materials, accessors, views;
    uint64_t offset = 0;
    for (const Cloud& cloud : clouds) {
        const std::string count = std::to_string(cloud.map->size());
        std::string attributes;
        for (const Attribute& attribute : kAttributes) {
            attributes += (attributes.empty() ? "\"" : ",\"") + std::string(attribute.name) +
                          "\":" + std::to_string(accessors.size());
            std::string accessor = "{\"bufferView\":" + std::to_string(views.size()) +
                                   ",\"byteOffset\":" + std::to_string(attribute.offset) +
                                   ",\"componentType\":5126,\"count\":" + count + ",\"type\":\"" + attribute.type +
                                   "\"";
            if (attribute.offset == offsetof(CloudPoint, position))
                accessor += ",\"min\":" + array_of(cloud.low) + ",\"max\":" + array_of(cloud.high);
            accessors.push_back(accessor + "}");
        }
        primitives.push_back("{\"mode\":0,\"material\":" + std::to_string(materials.size()) + ",\"attributes\":{" +
                             attributes + "}}");
        materials.push_back("{\"name\":\"" + std::string(cloud.name) +
                            "\",\"extensions\":{\"KHR_materials_unlit\":{}}}");
        const uint64_t bytes = cloud.map->size() * sizeof(CloudPoint);
        views.push_back("{\"buffer\":0,\"byteOffset\":" + std::to_string(offset) +
                        ",\"byteLength\":" + std::to_string(bytes) +
                        ",\"byteStride\":" + std::to_string(sizeof(CloudPoint)) + ",\"target\":34962}");
        offset += bytes;
    }
    std::string text =
        "{\"asset\":{\"version\":\"2.0\",\"generator\":\"photond " PHOTOND_VERSION
        "\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"name\":\"photon map\",\"translation\":" +
        array_of(origin);
    // Lists may not be empty in glTF: a map without photons is a node and nothing else.
    if (clouds.empty()) return text + "}]}";
    return text + ",\"mesh\":0}],\"meshes\":[{\"name\":\"photon map\",\"primitives\":" + joined(primitives) +
           "}],\"materials\":" + joined(materials) + ",\"accessors\":" + joined(accessors) +
           ",\"bufferViews\":" + joined(views) + ",\"buffers\":[{\"byteLength\":" + std::to_string(offset) +
           "}],\"extensionsUsed\":[\"KHR_materials_unlit\"]}";
}

void write_words(AtomicFile& file, std::initializer_list<uint32_t> words) {
    file.write(words.begin(), words.size() * sizeof(uint32_t));
}

}  // namespace

void write_photon_cloud(const PhotonMap& global, const PhotonMap& caustic, const dvec3& origin,
                        const std::filesystem::path& path) {
    const uint64_t photons = uint64_t{global.size()} + caustic.size();
    if (photon_cloud_bytes(photons) > UINT32_MAX)
        throw Error(ErrorCode::OutOfRange, "a photon map of " + std::to_string(photons) +
                                               " photons does not fit a binary glTF of 4 GiB; lower photons");
    std::vector<Cloud> clouds;
    if (!global.empty()) clouds.push_back(measured("global photons", global));
    if (!caustic.empty()) clouds.push_back(measured("caustic photons", caustic));
    std::string text = document(clouds, origin);
    text.resize((text.size() + 3) / 4 * 4, ' ');

    // [glTF 2.0, sec. 4.4] header, JSON chunk, BIN chunk, each a multiple of four bytes.
    constexpr uint32_t kMagic = 0x46546c67, kVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
    const uint32_t text_bytes = static_cast<uint32_t>(text.size());
    const uint32_t data_bytes = static_cast<uint32_t>(photons * sizeof(CloudPoint));
    const uint32_t data_chunk_bytes = data_bytes ? 8 + data_bytes : 0;
    AtomicFile file(path);
    write_words(file, {kMagic, kVersion, 12 + 8 + text_bytes + data_chunk_bytes, text_bytes, kJsonChunk});
    file.write(text.data(), text.size());
    if (data_bytes) write_words(file, {data_bytes, kBinaryChunk});
    std::vector<CloudPoint> points;
    points.reserve(kPointsAtOnce);
    for (const Cloud& cloud : clouds)
        for (uint32_t i = 0; i < cloud.map->size();) {
            points.clear();
            while (i < cloud.map->size() && points.size() < kPointsAtOnce) points.push_back(point_of(cloud, i++));
            file.write(points.data(), points.size() * sizeof(CloudPoint));
        }
    file.commit();
}

uint64_t photon_cloud_bytes(uint64_t photons) { return kJsonBytes + photons * sizeof(CloudPoint); }

}  // namespace photond
