#include "renderer/scene/camera.h"

#include <algorithm>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

/// Maps the unit square to the unit disc with little distortion.
/// [Shirley and Chiu 1997] A Low Distortion Map Between Disk and Square. JGT 2(3).
vec2 concentric_disc(vec2 u) {
    const vec2 offset = 2.0f * u - vec2(1.0f);
    if (offset.x == 0 && offset.y == 0) return vec2(0);
    float radius, phi;
    if (std::fabs(offset.x) > std::fabs(offset.y)) {
        radius = offset.x;
        phi = kPi / 4 * (offset.y / offset.x);
    } else {
        radius = offset.y;
        phi = kPi / 2 - kPi / 4 * (offset.x / offset.y);
    }
    return radius * vec2(std::cos(phi), std::sin(phi));
}

bool finite(const dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

Camera look_at_camera(const dvec3& eye, const dvec3& target, const dvec3& up, float yfov) {
    const std::string place = "/camera/look_at";
    if (!finite(eye)) throw Error(ErrorCode::OutOfRange, place + "/eye", "eye is not finite");
    if (!finite(target)) throw Error(ErrorCode::OutOfRange, place + "/target", "target is not finite");
    if (!finite(up) || up == dvec3(0))
        throw Error(ErrorCode::OutOfRange, place + "/up", "up must be finite and not the zero vector");
    if (!(yfov > 0 && yfov < kPi))
        throw Error(ErrorCode::OutOfRange, place + "/yfov",
                    "yfov = " + std::to_string(yfov) + " is outside (0, 3.14159) radians");
    // Scaled before lengths are taken, so that neither 1e-200 nor 1e200 leaves the range of double.
    const auto unit = [](dvec3 v) {
        v /= std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        return v / glm::length(v);
    };
    if (eye == target) throw Error(ErrorCode::OutOfRange, place + "/target", "target is the same point as eye");
    const dvec3 forward = unit(target - eye);
    const dvec3 across = glm::cross(forward, unit(up));
    constexpr double kLeastSine = 1e-9;  // below it rounding decides which way is right
    if (!(glm::length(across) > kLeastSine))
        throw Error(ErrorCode::OutOfRange, place + "/up", "up is parallel to the viewing direction");
    const dvec3 right = glm::normalize(across);

    Camera camera;
    camera.yfov = yfov;
    camera.position = vec3(eye);
    camera.forward = vec3(forward);
    camera.right = vec3(right);
    camera.up = vec3(glm::cross(right, forward));
    camera.focus_distance_m = static_cast<float>(glm::length(target - eye));
    return camera;
}

CameraRays::CameraRays(const Camera& camera, Size2 film_size) : camera_(camera) {
    const float width = static_cast<float>(film_size.width), height = static_cast<float>(film_size.height);
    const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
    const float half_width = half_height * width / height;
    pixel_x_ = (2 * half_width / width) * camera.right;
    pixel_y_ = (-2 * half_height / height) * camera.up;
    corner_ = -half_width * camera.right + half_height * camera.up;
    if (!camera.orthographic) corner_ += camera.forward;
}

Ray CameraRays::operator()(vec2 film, vec2 lens) const {
    // Position on the plane at unit distance (perspective: along `forward`), relative to the eye.
    const vec3 plane = corner_ + film.x * pixel_x_ + film.y * pixel_y_;
    vec3 origin = camera_.position;
    vec3 direction = plane;
    if (camera_.orthographic) origin += plane, direction = camera_.forward;
    if (camera_.aperture_radius_m > 0) {
        // Every lens point sees the same point of the plane of focus, which is perpendicular to `forward`.
        const vec3 shift = lens_offset(lens);
        direction -= shift / camera_.focus_distance_m;
        origin += shift;
    }
    return {origin, glm::normalize(direction), kInfinity};
}

vec3 CameraRays::lens_offset(vec2 lens) const {
    const vec2 disc = camera_.aperture_radius_m * concentric_disc(lens);
    return disc.x * camera_.right + disc.y * camera_.up;
}

Ray camera_ray(const Camera& camera, Size2 film_size, vec2 film, vec2 lens) {
    return CameraRays(camera, film_size)(film, lens);
}

}  // namespace photond
