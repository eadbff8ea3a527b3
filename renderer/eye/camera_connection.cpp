#include "renderer/eye/camera_connection.h"

namespace photond {

CameraConnector::CameraConnector(const CameraRays& rays)
    : rays_(rays), pixels_per_m2_(1 / (glm::length(rays.pixel_x()) * glm::length(rays.pixel_y()))) {}

/// Of a ray under that cosine to the axis.
float CameraConnector::density(float cosine) const {
    return rays_.camera().orthographic ? pixels_per_m2_ / cosine : pixels_per_m2_ / (cosine * cosine * cosine);
}

CameraPdf CameraConnector::pdf(const vec3& direction) const {
    const Camera& camera = rays_.camera();
    return {density(glm::dot(direction, camera.forward)), camera.orthographic};
}

/// `on_plane`: on the plane at unit distance, orthographic on the eye's own, relative to the eye.
vec2 CameraConnector::film_at(const vec3& on_plane) const {
    const vec3 from_corner = on_plane - rays_.corner();
    const vec3 &x = rays_.pixel_x(), &y = rays_.pixel_y();
    return {glm::dot(from_corner, x) / glm::dot(x, x), glm::dot(from_corner, y) / glm::dot(y, y)};
}

std::optional<CameraConnection> CameraConnector::connect(const vec3& point, const vec2& lens) const {
    const Camera& camera = rays_.camera();
    const bool has_lens = camera.aperture_radius_m > 0;
    const vec3 shift = has_lens ? rays_.lens_offset(lens) : vec3(0);
    // Rays through one point of the lens meet the plane of focus where those through its centre do.
    const vec3 bend = has_lens ? shift / camera.focus_distance_m : vec3(0);
    CameraConnection seen;
    vec3 on_plane;
    if (camera.orthographic) {
        const vec3 along = camera.forward - bend;
        const float steps = glm::dot(point - camera.position, camera.forward);
        if (!(steps > 0)) return std::nullopt;
        seen.target = point - steps * along;
        on_plane = seen.target - camera.position - shift;
        seen.distance = steps * glm::length(along);
        seen.to_camera = -glm::normalize(along);
    } else {
        seen.target = camera.position + shift;
        const vec3 from_lens = point - seen.target;
        const float depth = glm::dot(from_lens, camera.forward);
        seen.distance = glm::length(from_lens);
        if (!(depth > 0)) return std::nullopt;
        on_plane = from_lens / depth + bend;
        seen.to_camera = -from_lens / seen.distance;
    }
    seen.film = film_at(on_plane);
    seen.pdf = density(-glm::dot(seen.to_camera, camera.forward));
    seen.responsivity_per_m2 = camera.orthographic ? seen.pdf : seen.pdf / sqr(seen.distance);
    return seen;
}

}  // namespace photond
