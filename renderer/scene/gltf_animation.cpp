// Animations of a document: channels to a node's own properties, and to others by KHR_animation_pointer.

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>

#include "renderer/scene/gltf_rig.h"

namespace photond {

namespace {

/// A property that an animation can drive, by what stands behind its object in a pointer.
struct PropertyName {
    std::string_view list;  // the document's array that it is of
    std::string_view path;
    Property property;
    uint32_t width;  // 0: as many as the mesh has morph targets
    uint32_t slot = 0;
};

constexpr std::string_view kLightList = "extensions/KHR_lights_punctual/lights";

constexpr PropertyName kProperties[] = {
    {"nodes", "translation", Property::Translation, 3},
    {"nodes", "rotation", Property::Rotation, 4},
    {"nodes", "scale", Property::Scale, 3},
    {"nodes", "weights", Property::Weights, 0},
    {"meshes", "weights", Property::Weights, 0},
    {"cameras", "perspective/yfov", Property::YFov, 1},
    {"cameras", "orthographic/ymag", Property::YMag, 1},
    {kLightList, "color", Property::LightColor, 3},
    {kLightList, "intensity", Property::LightIntensity, 1},
    {kLightList, "range", Property::LightRange, 1},
    {kLightList, "spot/innerConeAngle", Property::InnerCone, 1},
    {kLightList, "spot/outerConeAngle", Property::OuterCone, 1},
    {"materials", "pbrMetallicRoughness/baseColorFactor", Property::BaseColor, 4},
    {"materials", "pbrMetallicRoughness/metallicFactor", Property::Metallic, 1},
    {"materials", "pbrMetallicRoughness/roughnessFactor", Property::Roughness, 1},
    {"materials", "normalTexture/scale", Property::NormalScale, 1},
    {"materials", "emissiveFactor", Property::EmissiveFactor, 3},
    {"materials", "extensions/KHR_materials_emissive_strength/emissiveStrength", Property::EmissiveStrength, 1},
    {"materials", "alphaCutoff", Property::AlphaCutoff, 1},
    {"materials", "extensions/KHR_materials_ior/ior", Property::Ior, 1},
    {"materials", "extensions/KHR_materials_specular/specularFactor", Property::Specular, 1},
    {"materials", "extensions/KHR_materials_specular/specularColorFactor", Property::SpecularColor, 3},
    {"materials", "extensions/KHR_materials_transmission/transmissionFactor", Property::Transmission, 1},
    {"materials", "extensions/KHR_materials_volume/attenuationColor", Property::AttenuationColor, 3},
    {"materials", "extensions/KHR_materials_volume/attenuationDistance", Property::AttenuationDistance, 1},
};

/// Textures in visit_texture_refs()'s order, and what KHR_texture_transform has of each.
constexpr std::string_view kTexturePaths[kTextureSlots] = {
    "pbrMetallicRoughness/baseColorTexture",
    "pbrMetallicRoughness/metallicRoughnessTexture",
    "normalTexture",
    "emissiveTexture",
    "extensions/KHR_materials_specular/specularTexture",
    "extensions/KHR_materials_specular/specularColorTexture",
    "extensions/KHR_materials_transmission/transmissionTexture",
};
constexpr PropertyName kTransformProperties[] = {
    {"materials", "/extensions/KHR_texture_transform/offset", Property::TextureOffset, 2},
    {"materials", "/extensions/KHR_texture_transform/scale", Property::TextureScale, 2},
    {"materials", "/extensions/KHR_texture_transform/rotation", Property::TextureRotation, 1},
};

/// What a pointer names.
struct Pointed {
    PropertyName name;
    uint32_t index;
};

std::optional<PropertyName> find_property(std::string_view list, std::string_view path) {
    for (const PropertyName& name : kProperties)
        if (name.list == list && name.path == path) return name;
    if (list != "materials") return std::nullopt;
    for (uint32_t slot = 0; slot < kTextureSlots; ++slot)
        for (PropertyName name : kTransformProperties)
            if (path.starts_with(kTexturePaths[slot]) && path.substr(kTexturePaths[slot].size()) == name.path) {
                name.slot = slot;
                return name;
            }
    return std::nullopt;
}

/// "/LIST/INDEX/PATH", where this project renders that; nothing for other properties.
std::optional<Pointed> resolve_pointer(std::string_view pointer) {
    for (const std::string_view list : {std::string_view("nodes"), std::string_view("meshes"),
                                        std::string_view("cameras"), kLightList, std::string_view("materials")}) {
        if (!pointer.starts_with('/') || !pointer.substr(1).starts_with(list)) continue;
        const std::string_view rest = pointer.substr(1 + list.size());
        const size_t slash = rest.find('/', 1);
        if (!rest.starts_with('/') || slash == rest.npos) continue;
        const std::string digits(rest.substr(1, slash - 1));
        if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != digits.npos) continue;
        if (const auto name = find_property(list, rest.substr(slash + 1)))
            return Pointed{*name, static_cast<uint32_t>(std::stoul(digits))};
    }
    return std::nullopt;
}

/// What makes keys the same.
struct KeyList {
    int input, output;  // accessors
    Interpolation interpolation;
    uint32_t width;
    bool rotation;

    bool operator<(const KeyList& other) const {
        const auto members = [](const KeyList& of) {
            return std::tuple(of.input, of.output, of.interpolation, of.width, of.rotation);
        };
        return members(*this) < members(other);
    }
};

/// What the animations of a document have in common.
struct Shared {
    /// Each list of keys once: a file may name the same accessors in any number of samplers, and the same sampler in
    /// any number of channels.
    std::map<KeyList, std::shared_ptr<const Keyframes>> keys;
    /// By mesh the nodes that take its weights: those that show it and have none of their own.
    std::vector<std::vector<uint32_t>> nodes_of_mesh;
};

/// One animation at work.
class AnimationReader {
public:
    AnimationReader(const GltfDocument& document, GltfData& data, uint32_t index, Shared& shared,
                    std::vector<std::string>& warnings)
        : model_(document.model),
          stored_(model_.animations[index]),
          data_(data),
          index_(index),
          shared_(shared),
          warnings_(warnings) {}

    Animation read() {
        Animation animation;
        animation.name = stored_.name;
        std::map<std::pair<std::string, uint32_t>, uint32_t> driven;  // what, by which channel
        std::vector<Channel> of_nodes_and_others;
        for (uint32_t c = 0; c < stored_.channels.size(); ++c) {
            const std::optional<Pointed> pointed = pointed_by(c);
            if (!pointed) continue;
            check_index(c, *pointed);
            check_glass(c, *pointed);
            const std::string what = std::string(pointed->name.list) + "/" + std::string(pointed->name.path) +
                                     std::to_string(pointed->name.slot);
            const auto [found, is_new] = driven.try_emplace({what, pointed->index}, c);
            if (!is_new) fail(c, "target", "channel " + std::to_string(found->second) + " drives the same property");
            Channel channel = read_channel(c, *pointed);
            if (channel.targets.empty()) continue;
            // A mesh's weights come first: a node's own channel wins over them.
            (pointed->name.list == "meshes" ? animation.channels : of_nodes_and_others).push_back(std::move(channel));
        }
        std::ranges::move(of_nodes_and_others, std::back_inserter(animation.channels));
        return animation;
    }

private:
    template <class... Tokens>
    [[noreturn]] void fail(uint32_t channel, const char* member, const std::string& detail) const {
        throw Error(ErrorCode::BadScene,
                    gltf_pointer("animations", index_, "channels", std::to_string(channel), member), detail);
    }

    std::optional<Pointed> pointed_by(uint32_t c) {
        const tinygltf::AnimationChannel& channel = stored_.channels[c];
        std::string pointer;
        if (channel.target_path != "pointer") {
            if (channel.target_node < 0) return std::nullopt;  // glTF 2.0, 5.9: such a channel is passed over
            pointer = "/nodes/" + std::to_string(channel.target_node) + "/" + channel.target_path;
        } else if (const tinygltf::Value* extension =
                       gltf_extension(channel.target_extensions, "KHR_animation_pointer")) {
            pointer = extension->Get("pointer").Get<std::string>();
        }
        std::optional<Pointed> pointed = resolve_pointer(pointer);
        if (!pointed)
            warnings_.push_back("animation " + std::to_string(index_) + " drives " + pointer.substr(0, 100) +
                                ", which is not rendered");
        return pointed;
    }

    size_t length_of(std::string_view list) const {
        if (list == "nodes") return model_.nodes.size();
        if (list == "meshes") return model_.meshes.size();
        if (list == "cameras") return model_.cameras.size();
        return list == "materials" ? model_.materials.size() : model_.lights.size();
    }
    void check_index(uint32_t c, const Pointed& pointed) const {
        if (const size_t length = length_of(pointed.name.list); pointed.index >= length)
            fail(c, "target",
                 std::to_string(pointed.index) + " is not an index into the " + std::to_string(length) + " " +
                     std::string(pointed.name.list));
        if (pointed.name.list == "nodes" && pointed.name.property <= Property::Scale &&
            !model_.nodes[pointed.index].matrix.empty())
            fail(c, "target",
                 "node " + std::to_string(pointed.index) + " has a matrix, and what has one cannot be animated");
    }

    /// What the judge refuses of a material at rest.
    void check_glass(uint32_t c, const Pointed& pointed) const {
        if (pointed.name.property != Property::Transmission) return;
        const tinygltf::Value* ior = gltf_extension(model_.materials[pointed.index].extensions, "KHR_materials_ior");
        if (ior != nullptr && ior->Has("ior") && ior->Get("ior").GetNumberAsDouble() == 0)
            throw Error(ErrorCode::Unsupported,
                        gltf_pointer("animations", index_, "channels", std::to_string(c), "target"),
                        "a transmissive material cannot have an index of refraction of 0");
    }

    size_t morph_targets(size_t mesh) const {
        const std::vector<tinygltf::Primitive>& primitives = model_.meshes[mesh].primitives;
        return primitives.empty() ? 0 : primitives.front().targets.size();
    }

    Channel read_channel(uint32_t c, const Pointed& pointed) {
        Channel channel{.property = pointed.name.property, .slot = pointed.name.slot, .targets = {}, .keyframes = {}};
        uint32_t width = pointed.name.width;
        if (pointed.name.property == Property::Weights) {
            const bool of_mesh = pointed.name.list == "meshes";
            const int mesh = of_mesh ? static_cast<int>(pointed.index) : model_.nodes[pointed.index].mesh;
            if (mesh >= 0) width = static_cast<uint32_t>(morph_targets(static_cast<size_t>(mesh)));
            if (width == 0) fail(c, "target", "there are no morph targets whose weights could be animated");
            if (of_mesh) {
                const std::vector<uint32_t>& nodes = shared_.nodes_of_mesh[pointed.index];
                data_.charge(nodes.size() * sizeof(uint32_t),
                             gltf_pointer("animations", index_, "channels", std::to_string(c), "target"));
                channel.targets = nodes;
            } else {
                channel.targets = {pointed.index};
            }
        } else {
            channel.targets = {pointed.index};
        }
        channel.keyframes = share_keyframes(c, width, pointed.name.property == Property::Rotation);
        return channel;
    }

    std::shared_ptr<const Keyframes> share_keyframes(uint32_t c, uint32_t width, bool rotation) {
        const auto index = static_cast<uint32_t>(stored_.channels[c].sampler);
        const tinygltf::AnimationSampler& sampler = stored_.samplers[index];
        const Interpolation interpolation = sampler.interpolation == "STEP"          ? Interpolation::Step
                                            : sampler.interpolation == "CUBICSPLINE" ? Interpolation::CubicSpline
                                                                                     : Interpolation::Linear;
        std::shared_ptr<const Keyframes>& held =
            shared_.keys[{sampler.input, sampler.output, interpolation, width, rotation}];
        if (!held) {
            Keyframes keys{.width = width, .interpolation = interpolation, .rotation = rotation};
            read_keyframes(index, keys);
            if (rotation) check_rotations(c, keys);
            held = std::make_shared<const Keyframes>(std::move(keys));
        }
        return held;
    }

    /// What keys say of themselves stands already.
    void read_keyframes(uint32_t index, Keyframes& keys) {
        const tinygltf::AnimationSampler& sampler = stored_.samplers[index];
        const auto bad = [&](const char* member, const std::string& detail) {
            throw Error(ErrorCode::BadScene,
                        gltf_pointer("animations", index_, "samplers", std::to_string(index), member), detail);
        };
        const AccessorView input = data_.accessor(static_cast<uint32_t>(sampler.input));
        const AccessorView output = data_.accessor(static_cast<uint32_t>(sampler.output));
        constexpr uint64_t kMaxZeros = 65536;
        for (const auto& [view, member] : {std::pair(&input, "input"), std::pair(&output, "output")})
            if (view->is_zeros() && view->count() > kMaxZeros)
                bad(member, "has " + std::to_string(view->count()) + " elements without a buffer view, more than " +
                                std::to_string(kMaxZeros));
        const uint64_t numbers =
            input.count() * keys.width * (keys.interpolation == Interpolation::CubicSpline ? 3 : 1);
        if (output.count() * output.rows() != numbers)
            bad("output", "has " + std::to_string(output.count() * output.rows()) + " numbers, not the " +
                              std::to_string(numbers) + " of " + std::to_string(input.count()) + " keys");
        data_.charge((input.count() + numbers) * sizeof(float),
                     gltf_pointer("animations", index_, "samplers", std::to_string(index)));
        keys.times.reserve(input.count());
        for (uint64_t k = 0; k < input.count(); ++k) {
            const float time = input.value(k, 0);
            if (!std::isfinite(time) || time < (keys.times.empty() ? 0 : keys.times.back()))
                bad("input",
                    "the time of key " + std::to_string(k) +
                        (std::isfinite(time) ? " is before that of the key before it, or negative" : " is not finite"));
            keys.times.push_back(time);
        }
        keys.values.reserve(numbers);
        for (uint64_t k = 0; k < output.count(); ++k)
            for (uint32_t row = 0; row < output.rows(); ++row) {
                keys.values.push_back(output.value(k, row));
                if (!std::isfinite(keys.values.back()))
                    bad("output", "element " + std::to_string(k) + " is not finite");
            }
    }

    /// The values among the keys must have a direction; tangents need not.
    void check_rotations(uint32_t c, const Keyframes& keys) const {
        const bool spline = keys.interpolation == Interpolation::CubicSpline;
        for (size_t k = 0; k < keys.times.size(); ++k) {
            const float* q = &keys.values[k * (spline ? 12 : 4) + (spline ? 4 : 0)];
            if (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0)
                fail(c, "sampler", "the quaternion of key " + std::to_string(k) + " is 0");
        }
    }

    const tinygltf::Model& model_;
    const tinygltf::Animation& stored_;
    GltfData& data_;
    const uint32_t index_;
    Shared& shared_;
    std::vector<std::string>& warnings_;
};

}  // namespace

std::vector<Animation> read_gltf_animations(const GltfDocument& document, GltfData& data,
                                            std::vector<std::string>& warnings) {
    std::vector<Animation> animations;
    Shared shared;
    shared.nodes_of_mesh.resize(document.model.meshes.size());
    for (uint32_t i = 0; i < document.model.nodes.size(); ++i)
        if (const tinygltf::Node& node = document.model.nodes[i]; node.mesh >= 0 && node.weights.empty())
            shared.nodes_of_mesh[static_cast<size_t>(node.mesh)].push_back(i);
    for (uint32_t i = 0; i < document.model.animations.size(); ++i)
        animations.push_back(AnimationReader(document, data, i, shared, warnings).read());
    return animations;
}

}  // namespace photond
