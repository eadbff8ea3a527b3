#include "renderer/scene/rig.h"

#include <algorithm>
#include <set>

namespace photond {

dmat4 RigNode::local() const {
    if (matrix) return *matrix;
    dmat4 local = glm::mat4_cast(rotation);
    for (int column = 0; column < 3; ++column) local[column] *= scale[column];
    local[3] = glm::dvec4(translation, 1);
    return local;
}

void TextureTransform::apply(TextureRef& reference) const {
    // uv' = translation * rotation * scale * uv, as the extension's text gives the matrices: counter-clockwise in uv
    // with v down.
    const double c = std::cos(rotation), s = std::sin(rotation);
    reference.row_u = vec3(dvec3(c * scale.x, s * scale.y, offset.x));
    reference.row_v = vec3(dvec3(-s * scale.x, c * scale.y, offset.y));
}

double Animation::duration_s() const {
    double end = 0;
    for (const Channel& channel : channels) end = std::max(end, channel.keyframes->end_s());
    return end;
}

std::vector<bool> moving_nodes(const Rig& rig, std::span<const Animation> animations) {
    std::vector<bool> moving(rig.nodes.size(), false);
    for (const Animation& animation : animations)
        for (const Channel& channel : animation.channels)
            if (channel.property <= Property::Scale)
                for (const uint32_t node : channel.targets) moving[node] = true;
    for (const uint32_t i : rig.order)
        if (rig.nodes[i].parent >= 0 && moving[static_cast<size_t>(rig.nodes[i].parent)]) moving[i] = true;
    return moving;
}

bool changes_weights(std::span<const Animation> animations, uint32_t node) {
    return std::ranges::any_of(animations, [&](const Animation& animation) {
        return std::ranges::any_of(animation.channels, [&](const Channel& channel) {
            return channel.property == Property::Weights && std::ranges::count(channel.targets, node) > 0;
        });
    });
}

bool moves_mesh(const Rig& rig, std::span<const Animation> animations, const std::vector<bool>& moving, uint32_t node,
                std::optional<uint32_t> skin) {
    if (changes_weights(animations, node)) return true;
    if (!skin) return moving[node];
    return std::ranges::any_of(rig.skins[*skin].joints, [&](uint32_t joint) { return moving[joint]; });
}

std::vector<uint32_t> parents_first(const std::vector<RigNode>& nodes) {
    std::vector<std::vector<uint32_t>> children(nodes.size());
    std::vector<uint32_t> order;
    order.reserve(nodes.size());
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].parent < 0)
            order.push_back(i);
        else
            children[static_cast<size_t>(nodes[i].parent)].push_back(i);
    }
    for (size_t next = 0; next < order.size(); ++next) {
        const std::vector<uint32_t>& below = children[order[next]];
        order.insert(order.end(), below.begin(), below.end());
    }
    return order;
}

uint64_t Rig::bytes() const {
    uint64_t bytes = nodes.capacity() * sizeof(RigNode);
    std::set<const ObjectMesh*> counted;
    for (const RiggedMesh& mesh : meshes)
        if (counted.insert(mesh.object.get()).second) bytes += mesh.object->bytes();
    std::set<const Keyframes*> counted_keys;
    for (const Animation& animation : animations)
        for (const Channel& channel : animation.channels)
            if (counted_keys.insert(channel.keyframes.get()).second) bytes += channel.keyframes->bytes();
    return bytes;
}

}  // namespace photond
