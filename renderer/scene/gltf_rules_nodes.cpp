// Rules of cameras, lights, nodes, scenes and animations.

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "renderer/scene/gltf_judge.h"
#include "renderer/scene/gltf_layout.h"

namespace photond::gltf_rules {

namespace {

/// An optional array of an object.
const Json& list(const Json& object, const char* key) {
    static const Json kNone = Json::array();
    const Json* found = find_member(object, key);
    return found == nullptr ? kNone : *found;
}

void check_transform(const Json& node) {
    for (const char* key : {"translation", "rotation", "scale"})
        if (node.contains("matrix") && node.contains(key)) fail(node, "has both matrix and " + std::string(key));
    const Json& m = list(node, "matrix");
    if (!m.empty() && (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0))
        fail(m, "the last row must be (0, 0, 0, 1)");
    double square = list(node, "rotation").empty() ? 1 : 0;
    for (const Json& component : list(node, "rotation")) square += component.get<double>() * component.get<double>();
    if (!(std::fabs(std::sqrt(square) - 1) < 0.01))
        fail(node["rotation"], "must be a unit quaternion; its length is " + std::to_string(std::sqrt(square)));
}

/// Of each node, none where it is the size of the array. Fails where there are two.
std::vector<size_t> find_parents(const Json& nodes) {
    std::vector<size_t> parents(nodes.size(), nodes.size());
    for (size_t i = 0; i < nodes.size(); ++i)
        for (const Json& child : list(nodes[i], "children")) {
            size_t& parent = parents[child.get<size_t>()];
            if (parent != nodes.size())
                fail(child, "node " + child.dump() + " is already a child of node " + std::to_string(parent));
            parent = i;
        }
    return parents;
}

/// Times are floats, and values floats or normalized whole numbers.
void check_sampler(const Json& root, const Json& sampler) {
    const auto layout_of = [&](const Json& index) {
        const Json& accessor = root["accessors"][index.get<size_t>()];
        return std::pair(element_layout(accessor["componentType"], accessor["type"].get<std::string>()),
                         accessor.value("normalized", false));
    };
    const auto [input, input_normalized] = layout_of(sampler["input"]);
    if (input.type != ComponentType::F32 || input.components() != 1)
        fail(sampler["input"], "accessor " + sampler["input"].dump() + " does not hold times, which are float scalars");
    const auto [output, normalized] = layout_of(sampler["output"]);
    if (output.columns != 1 || (output.type != ComponentType::F32 && !normalized))
        fail(sampler["output"], "accessor " + sampler["output"].dump() +
                                    " does not hold values, which are float or normalized scalars or vectors");
}

}  // namespace

void camera(const Json&, const Json& camera) {
    const Json* lens = find_member(camera, "orthographic");
    if (lens != nullptr && (*lens)["ymag"].get<float>() == 0) fail((*lens)["ymag"], "must not be 0");
}

void light(const Json&, const Json& light) {
    for (const Json& color : list(light, "color"))
        if (!std::isfinite(static_cast<float>(color.get<double>() * light.value("intensity", 1.0))))
            fail(light, "color x intensity is not finite");
    if (!light.contains("spot")) return;
    const double inner = light["spot"].value("innerConeAngle", 0.0), outer = light["spot"]["outerConeAngle"];
    if (!(inner < outer))
        fail(light["spot"],
             "innerConeAngle " + std::to_string(inner) + " must be less than outerConeAngle " + std::to_string(outer));
}

void node(const Json& root, const Json& node) {
    check_transform(node);
    if (!node.contains("weights")) return;
    const Json& weights = node["weights"];
    if (!node.contains("mesh")) fail(weights, "the node has no mesh");
    const size_t targets = target_count(root["meshes"][node["mesh"].get<size_t>()]["primitives"][0]);
    if (weights.size() != targets)
        fail(weights, "has " + std::to_string(weights.size()) + " elements, not " + std::to_string(targets));
}

void nodes(const Json&, const Json& nodes) {
    // With at most one parent each, a node that no root reaches is part of a cycle.
    const std::vector<size_t> parents = find_parents(nodes);
    std::vector<bool> reached(nodes.size(), false);
    std::vector<size_t> open;
    for (size_t i = 0; i < nodes.size(); ++i)
        if (parents[i] == nodes.size()) open.push_back(i);
    while (!open.empty()) {
        const size_t i = open.back();
        open.pop_back();
        reached[i] = true;
        for (const Json& child : list(nodes[i], "children")) open.push_back(child.get<size_t>());
    }
    for (size_t i = 0; i < nodes.size(); ++i)
        if (!reached[i]) fail(nodes[i]["children"], "the node is its own descendant");
}

void scenes(const Json& root, const Json& scenes) {
    const std::vector<size_t> parents = find_parents(list(root, "nodes"));
    for (const Json& scene : scenes) {
        std::set<size_t> seen;
        for (const Json& node : list(scene, "nodes")) {
            if (const size_t parent = parents[node.get<size_t>()]; parent != parents.size())
                fail(node, "node " + node.dump() + " is a child of node " + std::to_string(parent) +
                               ", so it cannot be a root");
            if (!seen.insert(node.get<size_t>()).second) fail(node, "node " + node.dump() + " is listed twice");
        }
    }
}

void animation(const Json& root, const Json& animation) {
    const size_t samplers = animation["samplers"].size();
    for (const Json& sampler : animation["samplers"]) check_sampler(root, sampler);
    for (const Json& channel : animation["channels"]) {
        const Json& target = channel["target"];
        if (target["path"] == "pointer" && find_extension(target, "KHR_animation_pointer") == nullptr)
            fail(target, "the path is \"pointer\", but there is no KHR_animation_pointer");
        if (const Json& sampler = channel["sampler"]; sampler.get<size_t>() >= samplers)
            fail(sampler, sampler.dump() + " is not an index into the " + std::to_string(samplers) +
                              " samplers of the animation");
    }
}

}  // namespace photond::gltf_rules
