#pragma once
// Points of the scene as the camera sees them: where in the image, from which point of the lens, and with which density
// its own paths would have gone there. What CameraRays (scene/camera.h) does, the other way round.
//
// Densities are for an image whose pixel has the area one, whatever filter pixels have: eye paths start with density
// one over the area of their own pixel's filter, whose sum over all pixels that is.

#include <optional>

#include "renderer/scene/camera.h"

namespace photond {

/// Of a ray that starts at the lens.
struct CameraPdf {
    float pdf = 0;         // perspective: of its direction [1/sr]; orthographic: of its place, across it [1/m^2]
    bool by_area = false;  // orthographic
};

struct CameraConnection {
    vec2 film{0};       // in pixels, from the top left corner; may lie outside of the image
    vec3 to_camera{0};  // unit, from the point
    vec3 target{0};     // where the ray to the camera ends
    float distance = 0;
    float pdf = 0;                  // CameraPdf of the ray that comes from there
    float responsivity_per_m2 = 0;  // a pixel's radiance over the intensity [W/sr] that the point sends to the camera
};

class CameraConnector {
public:
    explicit CameraConnector(const CameraRays& rays);

    CameraPdf pdf(const vec3& direction) const;
    /// The point as seen from the place of the lens that `lens`, uniform in [0, 1)^2, draws. None where it lies behind
    /// the camera.
    std::optional<CameraConnection> connect(const vec3& point, const vec2& lens) const;

private:
    float density(float cosine) const;
    vec2 film_at(const vec3& on_plane) const;

    const CameraRays rays_;
    const float pixels_per_m2_;  // on the plane at unit distance; orthographic: on the eye's
};

}  // namespace photond
