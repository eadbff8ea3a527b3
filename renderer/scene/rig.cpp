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

Movement movement_of(const Rig& rig, std::span<const Animation> animations) {
    Movement moving{std::vector<bool>(rig.nodes.size()), std::vector<bool>(rig.nodes.size()), {}};
    for (const Animation& animation : animations)
        for (const Channel& channel : animation.channels)
            if (channel.property <= Property::Weights)
                for (const uint32_t node : channel.targets)
                    (channel.property == Property::Weights ? moving.weights : moving.nodes)[node] = true;
    for (const uint32_t i : rig.order)
        if (rig.nodes[i].parent >= 0 && moving.nodes[static_cast<size_t>(rig.nodes[i].parent)]) moving.nodes[i] = true;
    for (const RigSkin& skin : rig.skins)
        moving.skins.push_back(std::ranges::any_of(skin.joints, [&](uint32_t joint) { return moving.nodes[joint]; }));
    return moving;
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

uint64_t node_bytes(const std::vector<RigNode>& nodes) {
    uint64_t bytes = nodes.capacity() * sizeof(RigNode);
    std::set<const std::vector<double>*> counted;
    for (const RigNode& node : nodes) {
        bytes += node.name.capacity();
        if (node.weights && counted.insert(node.weights.get()).second)
            bytes += node.weights->capacity() * sizeof(double);
    }
    return bytes;
}

uint64_t Rig::bytes() const {
    uint64_t bytes = node_bytes(nodes) + (order.capacity() + walk.capacity()) * sizeof(uint32_t) +
                     skins.capacity() * sizeof(RigSkin) + meshes.capacity() * sizeof(RiggedMesh) +
                     materials.capacity() * sizeof(RiggedMaterial);
    for (const RigSkin& skin : skins)
        bytes += skin.joints.capacity() * sizeof(uint32_t) + skin.inverse_bind.capacity() * sizeof(dmat4);
    std::set<const ObjectMesh*> counted;
    for (const RiggedMesh& mesh : meshes)
        if (counted.insert(mesh.object.get()).second) bytes += mesh.object->bytes();
    std::set<const Keyframes*> counted_keys;
    for (const Animation& animation : animations)
        for (const Channel& channel : animation.channels) {
            bytes += sizeof(Channel) + channel.targets.capacity() * sizeof(uint32_t);
            if (counted_keys.insert(channel.keyframes.get()).second) bytes += channel.keyframes->bytes();
        }
    return bytes;
}

}  // namespace photond
