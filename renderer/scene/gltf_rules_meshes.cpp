// Rules of meshes, skins and materials. Each accessor must have the shape and component type its use allows, so that
// later code can read it without asking again.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/scene/gltf_judge.h"
#include "renderer/scene/gltf_layout.h"

namespace photond::gltf_rules {

namespace {

struct Use {
    uint32_t min_rows, max_rows;
    bool float_allowed;
    bool normalized_unsigned_allowed;  // 8 and 16 bits
    bool plain_unsigned_allowed;       // 8 and 16 bits, not normalized
    bool quantized_allowed;            // any 8 or 16 bits, with KHR_mesh_quantization
};

/// The rule of a semantic; none for one that is not read (application-specific, or a higher set than is used).
const Use* use_of(std::string_view semantic, bool target) {
    static constexpr Use kVector{3, 3, true, false, false, true};
    static constexpr Use kTangent{4, 4, true, false, false, true};
    static constexpr Use kTexCoord{2, 2, true, true, false, true};
    static constexpr Use kColor{3, 4, true, true, false, false};
    static constexpr Use kJoints{4, 4, false, false, true, false};
    static constexpr Use kWeights{4, 4, true, true, false, false};
    if (semantic == "POSITION" || semantic == "NORMAL") return &kVector;
    if (semantic == "TANGENT") return target ? &kVector : &kTangent;
    if (target) return nullptr;
    if (semantic.starts_with("TEXCOORD_")) return &kTexCoord;
    if (semantic == "COLOR_0") return &kColor;
    if (semantic.starts_with("JOINTS_")) return &kJoints;
    if (semantic.starts_with("WEIGHTS_")) return &kWeights;
    return nullptr;
}

const Json& accessor_of(const Json& root, const Json& index) { return root["accessors"][index.get<size_t>()]; }

ElementLayout layout_of(const Json& accessor) {
    return element_layout(accessor["componentType"], accessor["type"].get<std::string>());
}

bool is_unsigned(ComponentType type) {
    return type == ComponentType::U8 || type == ComponentType::U16 || type == ComponentType::U32;
}

bool fits(const Json& accessor, const Use& use, bool quantized) {
    const ElementLayout layout = layout_of(accessor);
    if (layout.columns != 1 || layout.rows < use.min_rows || layout.rows > use.max_rows) return false;
    if (layout.type == ComponentType::F32) return use.float_allowed;
    if (layout.type == ComponentType::U32) return false;
    if (use.quantized_allowed && quantized) return true;
    const bool normalized = accessor.value("normalized", false);
    return is_unsigned(layout.type) && (normalized ? use.normalized_unsigned_allowed : use.plain_unsigned_allowed);
}

void check_types(const Json& root, const Json& attributes, bool target) {
    const bool quantized = lists_extension(root, "KHR_mesh_quantization");
    for (const auto& [semantic, index] : attributes.items())
        if (const Use* use = use_of(semantic, target); use && !fits(accessor_of(root, index), *use, quantized))
            fail(index, "accessor " + index.dump() + " has a type that " + semantic + " cannot have" +
                            (use->quantized_allowed && !quantized ? " without KHR_mesh_quantization" : ""));
}

void check_counts(const Json& root, const Json& attributes, const Json& count) {
    for (const auto& [semantic, index] : attributes.items())
        if (const Json& elements = accessor_of(root, index)["count"]; elements != count)
            fail(attributes, semantic + " has " + elements.dump() + " elements, but POSITION has " + count.dump());
}

/// TEXCOORD_n, COLOR_n, JOINTS_n, WEIGHTS_n must count up from 0 without gaps. Gives the number of sets.
size_t check_sets(const Json& attributes, const std::string& prefix) {
    std::vector<unsigned long> sets;
    for (const auto& [semantic, index] : attributes.items()) {
        if (!semantic.starts_with(prefix)) continue;
        const std::string digits = semantic.substr(prefix.size());
        if (digits.empty() || digits.size() > 3 || digits.find_first_not_of("0123456789") != std::string::npos)
            fail(attributes, '"' + semantic.substr(0, 60) + "\" is no attribute name");
        sets.push_back(std::stoul(digits));
    }
    std::ranges::sort(sets);
    for (size_t i = 0; i < sets.size(); ++i)
        if (sets[i] != i) fail(attributes, prefix + std::to_string(i) + " is missing below a higher set");
    return sets.size();
}

}  // namespace

size_t target_count(const Json& primitive) {
    const Json* attributes = find_member(primitive, "attributes");
    if (attributes == nullptr || !attributes->contains("POSITION") || !primitive.contains("targets")) return 0;
    return primitive["targets"].size();
}

void primitive(const Json& root, const Json& primitive) {
    const Json& attributes = primitive["attributes"];
    check_types(root, attributes, false);
    if (primitive.contains("indices")) {
        const Json& accessor = accessor_of(root, primitive["indices"]);
        const ElementLayout layout = layout_of(accessor);
        if (layout.components() != 1 || !is_unsigned(layout.type) || accessor.value("normalized", false))
            fail(primitive["indices"], "indices must be unsigned scalars, not normalized");
    }
    if (attributes.empty()) fail(attributes, "POSITION is missing");
    if (!attributes.contains("POSITION")) return;  // allowed, and nothing to draw
    check_sets(attributes, "TEXCOORD_");
    check_sets(attributes, "COLOR_");
    const size_t joints = check_sets(attributes, "JOINTS_"), weights = check_sets(attributes, "WEIGHTS_");
    if (joints != weights)
        fail(attributes, std::to_string(joints) + " JOINTS sets but " + std::to_string(weights) + " WEIGHTS sets");
    const Json& positions = accessor_of(root, attributes["POSITION"]);
    check_counts(root, attributes, positions["count"]);
    if (find_extension(primitive, "KHR_draco_mesh_compression") != nullptr && !positions.contains("bufferView"))
        fail(primitive, "KHR_draco_mesh_compression is not supported, and there is no uncompressed copy",
             ErrorCode::Unsupported);
    for (size_t i = 0; i < target_count(primitive); ++i) {
        check_types(root, primitive["targets"][i], true);
        check_counts(root, primitive["targets"][i], positions["count"]);
    }
}

void mesh(const Json&, const Json& mesh) {
    const Json& primitives = mesh["primitives"];
    const size_t targets = target_count(primitives[0]);
    const size_t weights = mesh.contains("weights") ? mesh["weights"].size() : 0;
    for (const Json& primitive : primitives) {
        if (target_count(primitive) != targets)
            fail(primitives, "the primitives of a mesh must have the same number of morph targets");
        if (weights != 0 && weights != targets)
            fail(mesh["weights"],
                 "has " + std::to_string(weights) + " elements for " + std::to_string(targets) + " morph targets");
    }
}

void skin(const Json& root, const Json& skin) {
    if (!skin.contains("inverseBindMatrices")) return;
    const Json& matrices = skin["inverseBindMatrices"];
    const Json& accessor = accessor_of(root, matrices);
    const ElementLayout layout = layout_of(accessor);
    if (layout.type != ComponentType::F32 || layout.columns != 4) fail(matrices, "must be 4x4 float matrices");
    if (accessor["count"].get<size_t>() < skin["joints"].size())
        fail(matrices,
             "has " + accessor["count"].dump() + " matrices for " + std::to_string(skin["joints"].size()) + " joints");
}

void material(const Json&, const Json& material) {
    const auto number = [&](const char* extension, const char* key, double absent) {
        const Json* found = find_extension(material, std::string("KHR_materials_") + extension);
        return found == nullptr ? absent : found->value(key, absent);
    };
    const double strength = number("emissive_strength", "emissiveStrength", 1), ior = number("ior", "ior", 1.5);
    for (const Json& factor : material.value("emissiveFactor", Json::array()))
        if (!std::isfinite(factor.get<float>() * static_cast<float>(strength)))
            fail(material, "emissiveFactor x emissiveStrength is not finite");
    if (ior != 0 && ior < 1)
        fail((*find_extension(material, "KHR_materials_ior"))["ior"], "must be 0 or at least 1, not " + shown(ior));
    if (number("transmission", "transmissionFactor", 0) > 0 && ior == 0)
        fail(*find_extension(material, "KHR_materials_transmission"),
             "a transmissive material cannot have an index of refraction of 0", ErrorCode::Unsupported);
}

}  // namespace photond::gltf_rules
