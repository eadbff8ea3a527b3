#include "renderer/scene/rig_builder.h"

namespace photond {

uint32_t add_node(Rig& rig, RigNode node) {
    const auto index = static_cast<uint32_t>(rig.nodes.size());
    rig.nodes.push_back(std::move(node));
    rig.order.push_back(index);
    rig.walk.push_back(index);
    return index;
}

void add_rigged_mesh(Scene& scene, Rig& rig, std::shared_ptr<const ObjectMesh> object, uint32_t node,
                     std::optional<uint32_t> skin) {
    Mesh mesh;
    for (int slot = 0; slot < 2; ++slot) mesh.uv[slot] = object->mesh.uv[slot];
    mesh.colors = object->mesh.colors;
    mesh.material = object->mesh.material;
    RiggedMesh rigged;
    rigged.node = node;
    rigged.skin = skin;
    rigged.mesh = static_cast<uint32_t>(scene.meshes.size());
    rigged.transmits = scene.materials[mesh.material].transmission > 0;
    rigged.object = std::move(object);
    rig.meshes.push_back(std::move(rigged));
    scene.instances.push_back({.mesh = static_cast<uint32_t>(scene.meshes.size())});
    scene.meshes.push_back(std::move(mesh));
}

std::vector<float> turn_about(const dvec3& axis, double angle) {
    const dvec3 part = std::sin(0.5 * angle) * axis;
    return {static_cast<float>(part.x), static_cast<float>(part.y), static_cast<float>(part.z),
            static_cast<float>(std::cos(0.5 * angle))};
}

Channel drive(Property property, uint32_t target, std::vector<float> times, std::vector<float> values,
              Interpolation interpolation) {
    Channel channel;
    channel.property = property;
    channel.targets = {target};
    Keyframes keys;
    const size_t a_key = interpolation == Interpolation::CubicSpline ? 3 : 1;
    keys.width = static_cast<uint32_t>(values.size() / times.size() / a_key);
    keys.interpolation = interpolation;
    keys.rotation = property == Property::Rotation;
    keys.times = std::move(times);
    keys.values = std::move(values);
    channel.keyframes = std::make_shared<const Keyframes>(std::move(keys));
    return channel;
}

std::vector<float> keys_of(std::initializer_list<std::vector<float>> values) {
    std::vector<float> all;
    for (const std::vector<float>& value : values) all.insert(all.end(), value.begin(), value.end());
    return all;
}

}  // namespace photond
