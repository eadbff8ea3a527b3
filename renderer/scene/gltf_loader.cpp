#include "renderer/scene/gltf_loader.h"

#include <cmath>
#include <cstring>

#include "renderer/scene/gltf_accessor.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/gltf_placement.h"
#include "renderer/scene/pose.h"

namespace photond {

namespace {

[[noreturn]] void bad(const std::string& detail) { throw Error(ErrorCode::BadScene, "", detail); }

/// The two parts of a file: its JSON and, in a .glb, its binary chunk.
struct Container {
    std::string_view json;
    std::span<const uint8_t> binary;
};

constexpr uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

uint32_t little32(std::span<const uint8_t> bytes, size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= uint32_t{bytes[at + i]} << (8 * i);
    return value;
}

/// glTF 2.0, 4.4: a header of 12 bytes, then chunks of (length, type, data); the first is JSON, the second, if there is
/// one, the buffer; unknown chunks after that are passed over.
Container split_glb(std::span<const uint8_t> file) {
    if (file.size() < 20) bad("the .glb of " + std::to_string(file.size()) + " bytes is shorter than its headers");
    if (little32(file, 4) != 2) bad("the .glb has container version " + std::to_string(little32(file, 4)) + ", not 2");
    const uint64_t length = little32(file, 8);
    if (length > file.size() || length < 20)
        bad("the .glb says it is " + std::to_string(length) + " bytes long, but it is " + std::to_string(file.size()));
    Container parts;
    uint64_t at = 12;
    for (int chunk = 0; at < length; ++chunk) {
        if (length - at < 8) bad("the .glb ends inside a chunk header at byte " + std::to_string(at));
        const uint64_t size = little32(file, at);
        const uint32_t type = little32(file, at + 4);
        at += 8;
        if (size > length - at)
            bad("chunk " + std::to_string(chunk) + " of the .glb, of " + std::to_string(size) +
                " bytes, passes the end of the file");
        const std::span<const uint8_t> data = file.subspan(at, size);
        if (chunk == 0 && type != kJsonChunk) bad("the first chunk of the .glb is not JSON");
        if (chunk == 0) parts.json = {reinterpret_cast<const char*>(data.data()), data.size()};
        if (chunk == 1 && type == kBinaryChunk) parts.binary = data;
        at += (size + 3) / 4 * 4;
    }
    return parts;
}

Container split(std::span<const uint8_t> file) {
    if (file.size() >= 4 && little32(file, 0) == kGlbMagic) return split_glb(file);
    return {{reinterpret_cast<const char*>(file.data()), file.size()}, {}};
}

/// `file` relative to the bundle's root.
std::string path_in_bundle(const std::filesystem::path& file, const std::filesystem::path& root) {
    if (file.is_relative()) return file.lexically_normal().string();
    const std::filesystem::path inside =
        file.lexically_normal().lexically_relative(std::filesystem::absolute(root).lexically_normal());
    if (inside.empty() || *inside.begin() == "..") bad("the scene's file lies outside its folder");
    return inside.string();
}

}  // namespace

Scene load_gltf(const std::filesystem::path& file, const std::filesystem::path& bundle_root, const ImageDecoder& decode,
                const LoadLimits& limits) {
    BundleFiles files(bundle_root, limits.max_file_bytes);
    const std::string path = path_in_bundle(file, bundle_root);
    const std::vector<uint8_t> bytes = files.read(path, "");
    const Container container = split(bytes);
    const GltfDocument document = read_gltf_document(container.json, {limits.max_json_depth, limits.max_json_values});

    const size_t slash = path.rfind('/');
    GltfData data(document, container.binary, files, slash == std::string::npos ? "" : path.substr(0, slash + 1),
                  limits.max_made_bytes);
    Scene scene;
    if (const tinygltf::Scene* shown = document.scene()) scene.name = shown->name;
    if (scene.name.empty()) scene.name = file.stem().string();
    scene.warnings = document.warnings;
    const std::shared_ptr<Rig> rig = place_gltf_scene(document, data, limits, scene);
    load_gltf_textures(document, data, decode, limits, scene);
    if (rig) {
        for (RiggedMaterial& rigged : rig->materials) rigged.rest = scene.materials[rigged.material];
        adopt_rig(scene, rig);
    }
    scene.file_bytes = files.bytes_read();
    finish_scene(scene);
    if (scene.triangle_count == 0) scene.warnings.push_back("the scene has no triangles");
    return scene;
}

std::map<std::string, double> gltf_camera_aspects(const std::filesystem::path& file,
                                                  const std::filesystem::path& bundle_root, const LoadLimits& limits) {
    BundleFiles files(bundle_root, limits.max_file_bytes);
    const std::vector<uint8_t> bytes = files.read(path_in_bundle(file, bundle_root), "");
    const GltfDocument document =
        read_gltf_document(split(bytes).json, {limits.max_json_depth, limits.max_json_values});
    std::map<std::string, double> aspects;
    for (const tinygltf::Node& node : document.model.nodes) {
        if (node.camera < 0) continue;
        const tinygltf::Camera& camera = document.model.cameras[static_cast<size_t>(node.camera)];
        const std::string& name = node.name.empty() ? camera.name : node.name;
        const bool orthographic = camera.type == "orthographic";
        const double aspect = orthographic ? std::fabs(camera.orthographic.xmag / camera.orthographic.ymag)
                                           : camera.perspective.aspectRatio;
        if (!name.empty() && std::isfinite(aspect) && aspect > 0) aspects.emplace(name, aspect);
    }
    return aspects;
}

}  // namespace photond
