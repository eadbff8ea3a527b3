#include "renderer/scene/gltf_document.h"

#include <algorithm>

namespace photond {

namespace {

constexpr std::string_view kSupportedExtensions[] = {
    "KHR_lights_punctual",     "KHR_materials_emissive_strength", "KHR_materials_ior",
    "KHR_materials_specular",  "KHR_materials_transmission",      "KHR_materials_volume",
    "KHR_materials_unlit",     "KHR_texture_transform",           "KHR_mesh_quantization",
    "EXT_meshopt_compression",
};

bool supported(std::string_view extension) {
    return std::ranges::find(kSupportedExtensions, extension) != std::end(kSupportedExtensions);
}

void check_version(const JsonRef& root) {
    const JsonRef asset = root.require("asset");
    const JsonRef version = asset.require("version");
    if (!version.text().starts_with("2."))
        version.fail("glTF version \"" + std::string(version.text().substr(0, 20)) + "\" is not 2.x",
                     ErrorCode::Unsupported);
    if (const auto least = asset.find("minVersion"); least && least->text() != "2.0")
        least->fail("the file asks for glTF \"" + std::string(least->text().substr(0, 20)) + "\", newer than 2.0",
                    ErrorCode::Unsupported);
}

void check_extensions(const JsonRef& root, GltfDocument& document, FaultList& faults) {
    if (const auto required = root.find("extensionsRequired")) {
        const uint32_t count = required->array_size();
        for (uint32_t i = 0; i < count; ++i)
            faults.collect([&] {
                const std::string_view name = required->at(i).text();
                if (!supported(name))
                    required->at(i).fail("the file requires the extension " + std::string(name.substr(0, 100)) +
                                             ", which is not supported",
                                         ErrorCode::Unsupported);
            });
    }
    faults.throw_if_any();
    if (const auto used = root.find("extensionsUsed")) {
        const uint32_t count = used->array_size();
        for (uint32_t i = 0; i < count; ++i) {
            const std::string_view name = used->at(i).text();
            if (!supported(name))
                document.warnings.push_back("the extension " + std::string(name.substr(0, 100)) +
                                            " is not supported and was ignored");
        }
    }
}

}  // namespace

bool lists_extension(const JsonRef& root, std::string_view name) {
    for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
        const auto list = root.find(key);
        if (!list) continue;
        const uint32_t count = list->array_size();
        for (uint32_t i = 0; i < count; ++i)
            if (list->at(i).text() == name) return true;
    }
    return false;
}

GltfDocument read_gltf_document(const JsonDocument& json) {
    GltfDocument document;
    FaultList faults;
    const JsonRef root = json.root();
    if (!root.is_object()) root.fail("a glTF document must be a JSON object");
    check_version(root);
    check_extensions(root, document, faults);
    read_gltf_data(root, document, faults);
    faults.throw_if_any();
    read_gltf_materials(root, document, faults);
    faults.throw_if_any();
    read_gltf_meshes(root, document, faults);
    faults.throw_if_any();
    read_gltf_nodes(root, document, faults);
    faults.throw_if_any();
    return document;
}

}  // namespace photond
