#pragma once
// Where the image shows a point: the inverse of CameraRays for the middle of the lens. GLSL twin:
// camera_projection.glsl.

#include <optional>

#include "renderer/scene/camera.h"

namespace photond {

/// Image position [pixels]; none behind the eye. May lie outside of the image.
inline std::optional<vec2> project(const CameraRays& rays, const vec3& position) {
    const Camera& camera = rays.camera();
    vec3 plane = position - camera.position;
    const float depth_m = glm::dot(plane, camera.forward);
    if (!camera.orthographic) {
        if (!(depth_m > 0)) return std::nullopt;
        plane /= depth_m;
    }
    const vec3 across = plane - rays.corner();
    return vec2(glm::dot(across, rays.pixel_x()) / glm::dot(rays.pixel_x(), rays.pixel_x()),
                glm::dot(across, rays.pixel_y()) / glm::dot(rays.pixel_y(), rays.pixel_y()));
}

}  // namespace photond
