// Transforms, cameras and lights of a document, into ours.

#include <glm/gtc/quaternion.hpp>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

dvec3 vector_or(const std::vector<double>& numbers, double fallback) {
    return numbers.empty() ? dvec3(fallback) : dvec3(numbers[0], numbers[1], numbers[2]);
}

}  // namespace

dmat4 gltf_local_matrix(const tinygltf::Node& node) {
    dmat4 matrix(1.0);
    if (!node.matrix.empty()) {
        for (int k = 0; k < 16; ++k) matrix[k / 4][k % 4] = node.matrix[k];
        return matrix;
    }
    if (const std::vector<double>& r = node.rotation; !r.empty()) {
        const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
        matrix = glm::mat4_cast(glm::dquat(r[3] / length, r[0] / length, r[1] / length, r[2] / length));
    }
    const dvec3 scale = vector_or(node.scale, 1);
    for (int column = 0; column < 3; ++column) matrix[column] *= scale[column];
    matrix[3] = glm::dvec4(vector_or(node.translation, 0), 1);
    return matrix;
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

PunctualLight read_gltf_light(const tinygltf::Light& stored) {
    using Kind = PunctualLight::Kind;
    PunctualLight light;
    light.name = stored.name;
    light.kind = stored.type == "spot" ? Kind::Spot : stored.type == "point" ? Kind::Point : Kind::Directional;
    light.intensity = Rgb(vector_or(stored.color, 1) * stored.intensity);
    if (stored.range > 0) light.range_m = static_cast<float>(stored.range);
    if (light.kind == Kind::Spot) {
        light.cos_inner = static_cast<float>(std::cos(stored.spot.innerConeAngle));
        light.cos_outer = static_cast<float>(std::max(0.0, std::cos(stored.spot.outerConeAngle)));
    }
    return light;
}

}  // namespace photond
