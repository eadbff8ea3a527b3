#pragma once
#include <string>

#include "renderer/core/geometry.h"

namespace photond {

/// glTF perspective or orthographic camera, looking along its own -z with +y up. Pixels are square: yfov (or ymag) is
/// kept and the image's width/height sets the horizontal extent.
struct Camera {
    std::string name;
    bool orthographic = false;
    float yfov = 0.7f;  // full vertical angle [rad]
    float ymag = 1;     // orthographic: half the height of the view [m]
    vec3 position{0};
    vec3 right{1, 0, 0};  // orthonormal, world space
    vec3 up{0, 1, 0};
    vec3 forward{0, 0, -1};
    float aperture_radius_m = 0;  // thin lens; 0 is a pinhole
    float focus_distance_m = 1;   // along `forward`
};

/// A camera at `eye` that looks at `target`. Throws ErrorCode::OutOfRange when the directions do not define one.
Camera look_at_camera(const dvec3& eye, const dvec3& target, const dvec3& up, float yfov);

/// The rays of one camera for one film size, with what does not change from ray to ray computed once.
class CameraRays {
public:
    CameraRays(const Camera& camera, Size2 film_size);

    /// Starts the ray through image position `film` (pixels; (0,0) is the top left corner) from lens position `lens`, a
    /// uniform pair in [0,1)^2. The direction is unit.
    Ray operator()(vec2 film, vec2 lens) const;
    /// That position on the lens, from its centre [m].
    vec3 lens_offset(vec2 lens) const;

    const Camera& camera() const { return camera_; }
    vec3 corner() const { return corner_; }
    vec3 pixel_x() const { return pixel_x_; }
    vec3 pixel_y() const { return pixel_y_; }

private:
    Camera camera_;
    vec3 corner_;             // top left corner of the image on the plane at unit distance, less the eye
    vec3 pixel_x_, pixel_y_;  // steps of one pixel on that plane
};

/// One such ray.
Ray camera_ray(const Camera& camera, Size2 film_size, vec2 film, vec2 lens);

}  // namespace photond
