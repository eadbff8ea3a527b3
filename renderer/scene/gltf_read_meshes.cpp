// Meshes and skins of a document. Each accessor must have the shape and component type its use allows, so that later
// code can read it without asking again.

#include <algorithm>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

struct Rule {
    uint32_t min_rows, max_rows;
    bool float_allowed;
    bool normalized_unsigned_allowed;  // 8 and 16 bits
    bool plain_unsigned_allowed;       // 8 and 16 bits, not normalized
    bool quantized_allowed;            // any 8 or 16 bits, with KHR_mesh_quantization
};

/// The rule of a semantic; none for one that is not read (application-specific, or a higher set than is used).
const Rule* rule_for(std::string_view semantic, bool target) {
    static constexpr Rule kVector{3, 3, true, false, false, true};
    static constexpr Rule kTangent{4, 4, true, false, false, true};
    static constexpr Rule kTexCoord{2, 2, true, true, false, true};
    static constexpr Rule kColor{3, 4, true, true, false, false};
    static constexpr Rule kJoints{4, 4, false, false, true, false};
    static constexpr Rule kWeights{4, 4, true, true, false, false};
    if (semantic == "POSITION" || semantic == "NORMAL") return &kVector;
    if (semantic == "TANGENT") return target ? &kVector : &kTangent;
    if (target) return nullptr;
    if (semantic.starts_with("TEXCOORD_")) return &kTexCoord;
    if (semantic == "COLOR_0") return &kColor;
    if (semantic.starts_with("JOINTS_")) return &kJoints;
    if (semantic.starts_with("WEIGHTS_")) return &kWeights;
    return nullptr;
}

bool fits(const GltfAccessor& accessor, const Rule& rule, bool quantized) {
    if (accessor.columns != 1 || accessor.rows < rule.min_rows || accessor.rows > rule.max_rows) return false;
    if (accessor.type == ComponentType::F32) return rule.float_allowed;
    if (accessor.type == ComponentType::U32) return false;
    if (rule.quantized_allowed && quantized) return true;
    const bool is_unsigned = accessor.type == ComponentType::U8 || accessor.type == ComponentType::U16;
    return is_unsigned && (accessor.normalized ? rule.normalized_unsigned_allowed : rule.plain_unsigned_allowed);
}

std::vector<GltfAttribute> read_attributes(const JsonRef& place, const GltfDocument& document, bool target,
                                           bool quantized) {
    std::vector<GltfAttribute> attributes;
    if (!place.is_object()) place.fail("must be an object");
    for (uint32_t i = 0; i < place.member_count(); ++i) {
        const JsonRef value = place.member_value(i);
        const uint32_t index = value.index(document.accessors.size(), "accessors");
        const std::string_view semantic = place.member_key(i);
        if (const Rule* rule = rule_for(semantic, target); rule && !fits(document.accessors[index], *rule, quantized))
            value.fail("accessor " + std::to_string(index) + " has a type that " + std::string(semantic) +
                       " cannot have" +
                       (rule->quantized_allowed && !quantized ? " without KHR_mesh_quantization" : ""));
        attributes.push_back({semantic, index});
    }
    return attributes;
}

void check_counts(const JsonRef& place, const std::vector<GltfAttribute>& attributes, uint64_t count,
                  const GltfDocument& document) {
    for (const GltfAttribute& attribute : attributes)
        if (document.accessors[attribute.accessor].count != count)
            place.fail(std::string(attribute.semantic) + " has " +
                       std::to_string(document.accessors[attribute.accessor].count) + " elements, but POSITION has " +
                       std::to_string(count));
}

uint32_t decimal(std::string_view digits) {
    uint32_t value = 0;
    for (const char c : digits) value = value * 10 + static_cast<uint32_t>(c - '0');
    return value;
}

/// TEXCOORD_n, COLOR_n, JOINTS_n, WEIGHTS_n must count up from 0 without gaps.
void check_sets(const JsonRef& place, const std::vector<GltfAttribute>& attributes) {
    for (const std::string_view prefix : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"}) {
        std::vector<uint32_t> sets;
        for (const GltfAttribute& attribute : attributes) {
            if (!attribute.semantic.starts_with(prefix)) continue;
            const std::string_view digits = attribute.semantic.substr(prefix.size());
            if (digits.empty() || digits.size() > 3 ||
                !std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; }))
                place.fail("\"" + std::string(attribute.semantic.substr(0, 60)) + "\" is no attribute name");
            sets.push_back(decimal(digits));
        }
        std::ranges::sort(sets);
        for (uint32_t i = 0; i < sets.size(); ++i)
            if (sets[i] != i) place.fail(std::string(prefix) + std::to_string(i) + " is missing below a higher set");
    }
}

void check_skinning(const JsonRef& place, const GltfPrimitive& primitive) {
    size_t joints = 0, weights = 0;
    for (const GltfAttribute& attribute : primitive.attributes) {
        joints += attribute.semantic.starts_with("JOINTS_");
        weights += attribute.semantic.starts_with("WEIGHTS_");
    }
    if (joints != weights)
        place.fail(std::to_string(joints) + " JOINTS sets but " + std::to_string(weights) + " WEIGHTS sets");
}

GltfPrimitive read_primitive(const JsonRef& place, const GltfDocument& document, bool quantized) {
    GltfPrimitive primitive;
    const JsonRef attributes = place.require("attributes");
    primitive.attributes = read_attributes(attributes, document, false, quantized);
    primitive.mode = static_cast<uint32_t>(place.whole_or("mode", 4, 0, 6));
    primitive.material = place.index_or_none("material", document.materials.size(), "materials");
    primitive.indices = place.index_or_none("indices", document.accessors.size(), "accessors");
    if (primitive.indices) {
        const GltfAccessor& accessor = document.accessors[*primitive.indices];
        const bool is_unsigned = accessor.type == ComponentType::U8 || accessor.type == ComponentType::U16 ||
                                 accessor.type == ComponentType::U32;
        if (accessor.components() != 1 || !is_unsigned || accessor.normalized)
            place.require("indices").fail("indices must be unsigned scalars, not normalized");
    }
    const auto positions = primitive.attribute("POSITION");
    if (!positions) {
        if (primitive.attributes.empty()) attributes.fail("POSITION is missing");
        return primitive;  // allowed, and nothing to draw
    }
    check_sets(attributes, primitive.attributes);
    check_skinning(attributes, primitive);
    const uint64_t count = document.accessors[*positions].count;
    check_counts(attributes, primitive.attributes, count, document);
    if (place.extension("KHR_draco_mesh_compression") && !document.accessors[*positions].view)
        place.fail("KHR_draco_mesh_compression is not supported, and there is no uncompressed copy",
                   ErrorCode::Unsupported);
    if (const auto targets = place.find("targets")) {
        const uint32_t target_count = targets->array_size();
        for (uint32_t i = 0; i < target_count; ++i) {
            primitive.targets.push_back(read_attributes(targets->at(i), document, true, quantized));
            check_counts(targets->at(i), primitive.targets.back(), count, document);
        }
    }
    return primitive;
}

std::vector<float> read_weights(const JsonRef& place, const char* key) {
    std::vector<float> weights;
    if (const auto array = place.find(key)) {
        const uint32_t size = array->array_size();
        for (uint32_t i = 0; i < size; ++i) weights.push_back(static_cast<float>(array->at(i).number()));
    }
    return weights;
}

GltfMesh read_mesh(const JsonRef& place, const GltfDocument& document, bool quantized, FaultList& faults) {
    GltfMesh mesh;
    mesh.name = place.text_or("name", "");
    const JsonRef primitives = place.require("primitives");
    mesh.primitives.resize(primitives.array_size(1));
    for (uint32_t i = 0; i < mesh.primitives.size(); ++i)
        faults.collect([&] { mesh.primitives[i] = read_primitive(primitives.at(i), document, quantized); });
    mesh.weights = read_weights(place, "weights");
    for (const GltfPrimitive& primitive : mesh.primitives) {
        if (primitive.targets.size() != mesh.primitives.front().targets.size())
            primitives.fail("the primitives of a mesh must have the same number of morph targets");
        if (!mesh.weights.empty() && mesh.weights.size() != primitive.targets.size())
            place.require("weights").fail("has " + std::to_string(mesh.weights.size()) + " elements for " +
                                          std::to_string(primitive.targets.size()) + " morph targets");
    }
    return mesh;
}

GltfSkin read_skin(const JsonRef& place, const GltfDocument& document, size_t node_count) {
    GltfSkin skin;
    const JsonRef joints = place.require("joints");
    skin.joints.resize(joints.array_size(1));
    for (uint32_t i = 0; i < skin.joints.size(); ++i) skin.joints[i] = joints.at(i).index(node_count, "nodes");
    place.index_or_none("skeleton", node_count, "nodes");
    skin.inverse_bind_matrices = place.index_or_none("inverseBindMatrices", document.accessors.size(), "accessors");
    if (skin.inverse_bind_matrices) {
        const GltfAccessor& accessor = document.accessors[*skin.inverse_bind_matrices];
        if (accessor.type != ComponentType::F32 || accessor.columns != 4 || accessor.rows != 4)
            place.require("inverseBindMatrices").fail("must be 4x4 float matrices");
        if (accessor.count < skin.joints.size())
            place.require("inverseBindMatrices")
                .fail("has " + std::to_string(accessor.count) + " matrices for " + std::to_string(skin.joints.size()) +
                      " joints");
    }
    return skin;
}

}  // namespace

std::optional<uint32_t> GltfPrimitive::attribute(std::string_view semantic) const {
    for (const GltfAttribute& attribute : attributes)
        if (attribute.semantic == semantic) return attribute.accessor;
    return std::nullopt;
}

void read_gltf_meshes(const JsonRef& root, GltfDocument& document, FaultList& faults) {
    const bool quantized = lists_extension(root, "KHR_mesh_quantization");
    faults.collect([&] {
        const auto meshes = root.find("meshes");
        if (!meshes) return;
        document.meshes.resize(meshes->array_size());
        for (uint32_t i = 0; i < document.meshes.size(); ++i)
            faults.collect([&] { document.meshes[i] = read_mesh(meshes->at(i), document, quantized, faults); });
    });
    faults.collect([&] {
        const auto skins = root.find("skins");
        if (!skins) return;
        const auto nodes = root.find("nodes");
        const size_t node_count = nodes ? nodes->array_size() : 0;
        document.skins.resize(skins->array_size());
        for (uint32_t i = 0; i < document.skins.size(); ++i)
            faults.collect([&] { document.skins[i] = read_skin(skins->at(i), document, node_count); });
    });
}

}  // namespace photond
