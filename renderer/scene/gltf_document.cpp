#include "renderer/scene/gltf_document.h"

#include <nlohmann/json.hpp>

#include "renderer/scene/gltf_judge.h"

namespace photond {

namespace {

/// tinygltf 2.7 reads every buffer and image whole, copies the binary chunk, refuses the buffers without data of
/// EXT_meshopt_compression, and reads whole numbers of extensions as 32 bits. So it gets one byte for each buffer, a
/// name of no file for each image, and floating-point numbers; what the file says comes back here.
struct Placeholders {
    std::vector<GltfBuffer> buffers;
    std::vector<tinygltf::Image> images;
    int no_view;  // stands for the view of accessors without one, which it does not let be indices
    int no_node;  // ... and for the node of channels without one, which it drops
};

void put_buffer(Json& buffer, std::vector<GltfBuffer>& buffers) {
    const auto uri = buffer.find("uri");
    GltfBuffer& kept = buffers.emplace_back();
    if (uri != buffer.end()) kept.uri = std::move(uri->get_ref<std::string&>());
    kept.byte_length = buffer["byteLength"].get<uint64_t>();
    const Json* meshopt = find_extension(buffer, "EXT_meshopt_compression");
    kept.meshopt_fallback = meshopt != nullptr && meshopt->value("fallback", false);
    buffer = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
}

void put_image(Json& image, std::vector<tinygltf::Image>& images) {
    tinygltf::Image& kept = images.emplace_back();
    kept.name = image.value("name", "");
    kept.bufferView = image.value("bufferView", -1);
    if (kept.bufferView < 0) kept.uri = std::move(image["uri"].get_ref<std::string&>());
    image = {{"uri", "placeholder"}};
}

Placeholders put_placeholders(Json& document) {
    Placeholders put;
    for (Json& buffer : document["buffers"]) put_buffer(buffer, put.buffers);
    for (Json& image : document["images"]) put_image(image, put.images);
    Json& views = document["bufferViews"];
    for (Json& view : views)
        if (view.contains("extensions"))
            for (Json& extension : view["extensions"])
                for (Json& value : extension)
                    if (value.is_number()) value = value.get<double>();
    put.no_view = static_cast<int>(views.size());
    views.push_back({{"buffer", 0}, {"byteLength", 1}});
    for (Json& accessor : document["accessors"]) accessor.emplace("bufferView", put.no_view);
    put.no_node = static_cast<int>(document["nodes"].size());
    for (Json& animation : document["animations"])
        for (Json& channel : animation["channels"]) channel["target"].emplace("node", put.no_node);
    return put;
}

}  // namespace

GltfDocument read_gltf_document(std::string_view text, const JsonBounds& bounds) {
    Json json = parse_json(text, bounds);
    GltfDocument document;
    judge_gltf(json, document.warnings);
    Placeholders put = put_placeholders(json);
    const std::string plain = json.dump();
    json = nullptr;
    document.model = parse_plain_gltf(plain);
    document.model.images = std::move(put.images);
    document.buffers = std::move(put.buffers);
    for (tinygltf::Accessor& accessor : document.model.accessors)
        if (accessor.bufferView == put.no_view) accessor.bufferView = -1;
    for (tinygltf::Animation& animation : document.model.animations)
        for (tinygltf::AnimationChannel& channel : animation.channels)
            if (channel.target_node == put.no_node) channel.target_node = -1;
    return document;
}

const tinygltf::Scene* GltfDocument::scene() const {
    return model.scenes.empty() ? nullptr : &model.scenes[std::max(model.defaultScene, 0)];
}

std::optional<int> gltf_attribute(const tinygltf::Primitive& primitive, const std::string& semantic) {
    const auto found = primitive.attributes.find(semantic);
    return found == primitive.attributes.end() ? std::nullopt : std::optional(found->second);
}

ElementLayout element_layout(const tinygltf::Accessor& accessor) {
    // tinygltf's types: the rows, and a bit for matrices.
    const auto type = static_cast<uint32_t>(accessor.type), rows = type & 15;
    return {static_cast<ComponentType>(accessor.componentType), (type & 32) != 0 ? rows : 1, rows};
}

const tinygltf::Value* gltf_extension(const tinygltf::ExtensionMap& extensions, const std::string& name) {
    const auto found = extensions.find(name);
    return found == extensions.end() ? nullptr : &found->second;
}

std::optional<int> gltf_light(const tinygltf::Node& node) {
    const tinygltf::Value* extension = gltf_extension(node.extensions, "KHR_lights_punctual");
    return extension == nullptr ? std::nullopt : std::optional(extension->Get("light").GetNumberAsInt());
}

}  // namespace photond
