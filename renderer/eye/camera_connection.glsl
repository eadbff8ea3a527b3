// GLSL twin of eye/camera_connection.h and .cpp: points of the scene as the camera sees them.
#ifndef PHOTOND_CAMERA_CONNECTION_GLSL
#define PHOTOND_CAMERA_CONNECTION_GLSL

#include "renderer/scene/camera.glsl"

/// As CameraConnection of camera_connection.h has it.
struct CameraConnection {
    vec2 film;
    vec3 to_camera;
    vec3 target;
    float distance;
    float pdf;
    float responsivity_per_m2;
};

/// Of a ray that starts at the lens, under that cosine to the axis.
float camera_density(CameraConstants camera, float cosine) {
    const float pixels_per_m2 = 1.0 / (length(camera.pixel_x) * length(camera.pixel_y));
    return camera.orthographic != 0 ? pixels_per_m2 / cosine : pixels_per_m2 / (cosine * cosine * cosine);
}

/// CameraPdf: perspective: of its direction [1/sr]; orthographic: of its place, across it [1/m^2].
float camera_pdf(CameraConstants camera, vec3 direction) {
    return camera_density(camera, dot(direction, camera.forward));
}

/// `on_plane`: on the plane at unit distance, orthographic on the eye's own, relative to the eye.
vec2 camera_film_at(CameraConstants camera, vec3 on_plane) {
    const vec3 from_corner = on_plane - camera.corner;
    return vec2(dot(from_corner, camera.pixel_x) / dot(camera.pixel_x, camera.pixel_x),
                dot(from_corner, camera.pixel_y) / dot(camera.pixel_y, camera.pixel_y));
}

/// The point as seen from the place of the lens that `lens`, uniform in [0, 1)^2, draws. False where it lies behind the
/// camera.
bool camera_connect(CameraConstants camera, vec3 point, vec2 lens, out CameraConnection seen) {
    const bool has_lens = camera.aperture_radius_m > 0.0;
    vec3 shift = vec3(0.0);
    if (has_lens) {
        const vec2 disc = camera.aperture_radius_m * concentric_disc(lens);
        shift = disc.x * camera.right + disc.y * camera.up;
    }
    // Rays through one point of the lens meet the plane of focus where those through its centre do.
    const vec3 bend = has_lens ? shift / camera.focus_distance_m : vec3(0.0);
    vec3 on_plane;
    if (camera.orthographic != 0) {
        const vec3 along = camera.forward - bend;
        const float steps = dot(point - camera.position, camera.forward);
        if (!(steps > 0.0)) return false;
        seen.target = point - steps * along;
        on_plane = seen.target - camera.position - shift;
        seen.distance = steps * length(along);
        seen.to_camera = -normalize(along);
    } else {
        seen.target = camera.position + shift;
        const vec3 from_lens = point - seen.target;
        const float depth = dot(from_lens, camera.forward);
        seen.distance = length(from_lens);
        if (!(depth > 0.0)) return false;
        on_plane = from_lens / depth + bend;
        seen.to_camera = -from_lens / seen.distance;
    }
    seen.film = camera_film_at(camera, on_plane);
    seen.pdf = camera_density(camera, -dot(seen.to_camera, camera.forward));
    seen.responsivity_per_m2 = camera.orthographic != 0 ? seen.pdf : seen.pdf / sqr(seen.distance);
    return true;
}

#endif
