// Nodes, scenes, cameras, lights and animations of a document.

#include <glm/gtc/quaternion.hpp>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

constexpr double kAny = JsonRef::kAnyNumber;

dmat4 read_transform(const JsonRef& place) {
    double m[16];
    if (place.numbers("matrix", m, -kAny, kAny)) {
        for (const char* key : {"translation", "rotation", "scale"})
            if (place.find(key)) place.fail("has both matrix and " + std::string(key));
        dmat4 matrix;
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row) matrix[column][row] = m[4 * column + row];
        if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1)
            place.require("matrix").fail("the last row must be (0, 0, 0, 1)");
        return matrix;
    }
    double t[3] = {0, 0, 0}, r[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    place.numbers("translation", t, -kAny, kAny);
    place.numbers("rotation", r, -1.01, 1.01);
    place.numbers("scale", s, -kAny, kAny);
    const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
    if (!(std::fabs(length - 1) < 0.01))
        place.require("rotation").fail("must be a unit quaternion; its length is " + std::to_string(length));
    const glm::dquat rotation(r[3] / length, r[0] / length, r[1] / length, r[2] / length);
    dmat4 matrix = glm::mat4_cast(rotation);
    for (int column = 0; column < 3; ++column) matrix[column] *= s[column];
    matrix[3] = glm::dvec4(t[0], t[1], t[2], 1);
    return matrix;
}

GltfNode read_node(const JsonRef& place, const GltfDocument& document, size_t node_count) {
    GltfNode node;
    node.name = place.text_or("name", "");
    node.mesh = place.index_or_none("mesh", document.meshes.size(), "meshes");
    node.skin = place.index_or_none("skin", document.skins.size(), "skins");
    node.camera = place.index_or_none("camera", document.cameras.size(), "cameras");
    if (const auto light = place.extension("KHR_lights_punctual"))
        node.light = light->require("light").index(document.lights.size(), "lights");
    node.local = read_transform(place);
    if (const auto children = place.find("children")) {
        node.children.resize(children->array_size());
        for (uint32_t i = 0; i < node.children.size(); ++i)
            node.children[i] = children->at(i).index(node_count, "nodes");
    }
    if (const auto weights = place.find("weights")) {
        if (!node.mesh) weights->fail("the node has no mesh");
        const auto& primitives = document.meshes[*node.mesh].primitives;
        const size_t targets = primitives.empty() ? 0 : primitives.front().targets.size();
        const auto size = static_cast<uint32_t>(targets);
        weights->array_size(size, size);
        for (uint32_t i = 0; i < size; ++i) node.weights.push_back(static_cast<float>(weights->at(i).number()));
    }
    return node;
}

Camera read_camera(const JsonRef& place) {
    Camera camera;
    camera.name = place.text_or("name", "");
    const JsonRef type = place.require("type");
    if (type.text() == "perspective") {
        const JsonRef lens = place.require("perspective");
        const JsonRef yfov = lens.require("yfov");
        camera.yfov = static_cast<float>(yfov.number(0, 3.141592));
        if (!(camera.yfov > 1e-6f)) yfov.fail("must be greater than 0");
        lens.number_or("znear", 1, 0, kAny);
        lens.number_or("zfar", 1, 0, kAny);
        lens.number_or("aspectRatio", 1, 0, kAny);
    } else if (type.text() == "orthographic") {
        camera.orthographic = true;
        const JsonRef lens = place.require("orthographic");
        const JsonRef ymag = lens.require("ymag");
        camera.ymag = std::fabs(static_cast<float>(ymag.number()));
        if (!(camera.ymag > 0)) ymag.fail("must not be 0");
        lens.require("xmag").number();
    } else {
        type.fail("must be \"perspective\" or \"orthographic\"");
    }
    return camera;
}

PunctualLight read_light(const JsonRef& place) {
    using Kind = PunctualLight::Kind;
    PunctualLight light;
    light.name = place.text_or("name", "");
    const JsonRef type = place.require("type");
    if (type.text() == "directional")
        light.kind = Kind::Directional;
    else if (type.text() == "spot")
        light.kind = Kind::Spot;
    else if (type.text() != "point")
        type.fail("must be \"point\", \"spot\" or \"directional\"");
    double color[3] = {1, 1, 1};
    place.numbers("color", color, 0, kAny);
    const double intensity = place.number_or("intensity", 1, 0, kAny);
    light.intensity = Rgb(dvec3(color[0], color[1], color[2]) * intensity);
    if (!is_finite(light.intensity)) place.fail("color x intensity is not finite");
    if (const auto range = place.find("range")) {
        light.range_m = static_cast<float>(range->number(0, kAny));
        if (!(light.range_m > 0)) range->fail("must be greater than 0");
    }
    if (light.kind == Kind::Spot) {
        const JsonRef spot = place.require("spot");
        constexpr double kHalfPi = 1.5707963267948966;
        const double outer = spot.number_or("outerConeAngle", kHalfPi / 2, 0, kHalfPi + 1e-6);
        const double inner = spot.number_or("innerConeAngle", 0, 0, kHalfPi + 1e-6);
        if (!(inner < outer))
            spot.fail("innerConeAngle " + std::to_string(inner) + " must be less than outerConeAngle " +
                      std::to_string(outer));
        light.cos_inner = static_cast<float>(std::cos(inner));
        light.cos_outer = static_cast<float>(std::max(0.0, std::cos(outer)));
    }
    return light;
}

void link_parents(const JsonRef& nodes, GltfDocument& document) {
    for (uint32_t i = 0; i < document.nodes.size(); ++i) {
        const std::vector<uint32_t>& children = document.nodes[i].children;
        for (uint32_t k = 0; k < children.size(); ++k) {
            std::optional<uint32_t>& parent = document.nodes[children[k]].parent;
            if (parent)
                nodes.at(i)
                    .require("children")
                    .at(k)
                    .fail("node " + std::to_string(children[k]) + " is already a child of node " +
                          std::to_string(*parent));
            parent = i;
        }
    }
    // With at most one parent each, a node that no root reaches is part of a cycle.
    std::vector<uint32_t> open;
    std::vector<bool> reached(document.nodes.size(), false);
    for (uint32_t i = 0; i < document.nodes.size(); ++i)
        if (!document.nodes[i].parent) open.push_back(i);
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        reached[i] = true;
        open.insert(open.end(), document.nodes[i].children.begin(), document.nodes[i].children.end());
    }
    for (uint32_t i = 0; i < reached.size(); ++i)
        if (!reached[i]) nodes.at(i).require("children").fail("the node is its own descendant");
}

GltfScene read_scene(const JsonRef& place, const GltfDocument& document) {
    GltfScene scene;
    scene.name = place.text_or("name", "");
    const auto roots = place.find("nodes");
    if (!roots) return scene;
    scene.roots.resize(roots->array_size());
    std::vector<bool> seen(document.nodes.size(), false);
    for (uint32_t i = 0; i < scene.roots.size(); ++i) {
        const uint32_t root = scene.roots[i] = roots->at(i).index(document.nodes.size(), "nodes");
        if (document.nodes[root].parent)
            roots->at(i).fail("node " + std::to_string(root) + " is a child of node " +
                              std::to_string(*document.nodes[root].parent) + ", so it cannot be a root");
        if (seen[root]) roots->at(i).fail("node " + std::to_string(root) + " is listed twice");
        seen[root] = true;
    }
    return scene;
}

void check_animation(const JsonRef& place, const GltfDocument& document) {
    const JsonRef samplers = place.require("samplers");
    const uint32_t sampler_count = samplers.array_size(1);
    for (uint32_t i = 0; i < sampler_count; ++i)
        for (const char* key : {"input", "output"})
            samplers.at(i).require(key).index(document.accessors.size(), "accessors");
    const JsonRef channels = place.require("channels");
    const uint32_t channel_count = channels.array_size(1);
    for (uint32_t i = 0; i < channel_count; ++i) {
        channels.at(i).require("sampler").index(sampler_count, "samplers of the animation");
        const JsonRef target = channels.at(i).require("target");
        target.index_or_none("node", document.nodes.size(), "nodes");
        target.require("path").text();
    }
}

template <class T, class Read>
void read_all(const std::optional<JsonRef>& array, std::vector<T>& out, FaultList& faults, const Read& read) {
    if (!array) return;
    faults.collect([&] {
        out.resize(array->array_size());
        for (uint32_t i = 0; i < out.size(); ++i) faults.collect([&] { out[i] = read(array->at(i)); });
    });
}

}  // namespace

void read_gltf_nodes(const JsonRef& root, GltfDocument& document, FaultList& faults) {
    faults.collect([&] {
        read_all(root.find("cameras"), document.cameras, faults, read_camera);
        if (const auto lights = root.extension("KHR_lights_punctual"))
            read_all(lights->find("lights"), document.lights, faults, read_light);
    });
    faults.throw_if_any();
    const auto nodes = root.find("nodes");
    faults.collect([&] {
        if (!nodes) return;
        const size_t node_count = nodes->array_size();
        read_all(nodes, document.nodes, faults,
                 [&](const JsonRef& place) { return read_node(place, document, node_count); });
    });
    faults.throw_if_any();
    faults.collect([&] {
        if (nodes) link_parents(*nodes, document);
    });
    faults.throw_if_any();
    faults.collect([&] {
        read_all(root.find("scenes"), document.scenes, faults,
                 [&](const JsonRef& place) { return read_scene(place, document); });
        document.scene = root.index_or_none("scene", document.scenes.size(), "scenes");
        if (!document.scene && !document.scenes.empty()) document.scene = 0;
        if (const auto animations = root.find("animations")) {
            document.animation_count = animations->array_size();
            for (uint32_t i = 0; i < document.animation_count; ++i)
                faults.collect([&] { check_animation(animations->at(i), document); });
        }
    });
}

}  // namespace photond
