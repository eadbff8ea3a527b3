#include "renderer/scene/gltf_rig.h"

#include <algorithm>

namespace photond {

namespace {

dvec3 vector_or(const std::vector<double>& numbers, double fallback) {
    return numbers.empty() ? dvec3(fallback) : dvec3(numbers[0], numbers[1], numbers[2]);
}

MorphWeights weights_or_none(const std::vector<double>& stored) {
    return stored.empty() ? nullptr : std::make_shared<const std::vector<double>>(stored);
}

/// `of_meshes`: the weights of each mesh.
RigNode read_gltf_node(const tinygltf::Node& stored, const std::vector<MorphWeights>& of_meshes) {
    RigNode node;
    node.name = stored.name;
    node.camera = stored.camera;
    node.light = gltf_light(stored).value_or(-1);
    node.weights = weights_or_none(stored.weights);
    if (!node.weights && stored.mesh >= 0) node.weights = of_meshes[static_cast<size_t>(stored.mesh)];
    if (!stored.matrix.empty()) {
        node.matrix.emplace(1.0);
        for (int k = 0; k < 16; ++k) (*node.matrix)[k / 4][k % 4] = stored.matrix[static_cast<size_t>(k)];
        return node;
    }
    if (const std::vector<double>& r = stored.rotation; !r.empty()) {
        const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
        node.rotation = glm::dquat(r[3] / length, r[0] / length, r[1] / length, r[2] / length);
    }
    node.scale = vector_or(stored.scale, 1);
    node.translation = vector_or(stored.translation, 0);
    return node;
}

Camera read_gltf_camera(const tinygltf::Camera& stored) {
    Camera camera;
    camera.name = stored.name;
    camera.orthographic = stored.type == "orthographic";
    if (camera.orthographic)
        camera.ymag = std::fabs(static_cast<float>(stored.orthographic.ymag));
    else
        camera.yfov = static_cast<float>(stored.perspective.yfov);
    return camera;
}

RiggedLight read_gltf_light(const tinygltf::Light& stored) {
    using Kind = PunctualLight::Kind;
    RiggedLight light;
    light.name = stored.name;
    light.kind = stored.type == "spot" ? Kind::Spot : stored.type == "point" ? Kind::Point : Kind::Directional;
    light.color = vector_or(stored.color, 1);
    light.intensity = stored.intensity;
    if (stored.range > 0) light.range_m = stored.range;
    if (light.kind == Kind::Spot) {
        light.inner_cone = stored.spot.innerConeAngle;
        light.outer_cone = stored.spot.outerConeAngle;
    }
    return light;
}

RigSkin read_gltf_skin(const tinygltf::Skin& stored, GltfData& data, uint32_t index) {
    // A joint is a number in the file, and here a matrix that is stored, one that is posed, and one of the pose before.
    data.charge(stored.joints.size() * 3 * sizeof(dmat4), gltf_pointer("skins", index, "joints"));
    RigSkin skin;
    skin.joints.assign(stored.joints.begin(), stored.joints.end());
    skin.inverse_bind.assign(skin.joints.size(), dmat4(1));
    if (stored.inverseBindMatrices < 0) return skin;
    const AccessorView matrices = data.accessor(static_cast<uint32_t>(stored.inverseBindMatrices));
    for (size_t k = 0; k < skin.joints.size(); ++k) skin.inverse_bind[k] = matrices.matrix(k);
    return skin;
}

/// Nodes of the default scene, depth first.
std::vector<uint32_t> walk_of(const GltfDocument& document, const std::vector<RigNode>& nodes) {
    std::vector<uint32_t> walk, open;
    const auto push = [&open](const std::vector<int>& below) { open.insert(open.end(), below.rbegin(), below.rend()); };
    if (document.scene() != nullptr) {
        push(document.scene()->nodes);
    } else {
        for (size_t i = nodes.size(); i > 0; --i)
            if (nodes[i - 1].parent < 0) open.push_back(static_cast<uint32_t>(i - 1));
    }
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        walk.push_back(i);
        push(document.model.nodes[i].children);
    }
    return walk;
}

}  // namespace

Rig read_gltf_rig(const GltfDocument& document, GltfData& data, std::vector<std::string>& warnings) {
    const tinygltf::Model& model = document.model;
    Rig rig;
    std::vector<MorphWeights> of_meshes;
    for (const tinygltf::Mesh& mesh : model.meshes) of_meshes.push_back(weights_or_none(mesh.weights));
    for (const tinygltf::Node& node : model.nodes) rig.nodes.push_back(read_gltf_node(node, of_meshes));
    for (size_t i = 0; i < model.nodes.size(); ++i)
        for (const int child : model.nodes[i].children)
            rig.nodes[static_cast<size_t>(child)].parent = static_cast<int32_t>(i);
    rig.order = parents_first(rig.nodes);
    rig.walk = walk_of(document, rig.nodes);
    for (const tinygltf::Camera& camera : model.cameras) rig.cameras.push_back(read_gltf_camera(camera));
    for (const tinygltf::Light& light : model.lights) rig.lights.push_back(read_gltf_light(light));
    for (uint32_t i = 0; i < model.skins.size(); ++i) rig.skins.push_back(read_gltf_skin(model.skins[i], data, i));
    rig.animations = read_gltf_animations(document, data, warnings);
    return rig;
}

}  // namespace photond
