// GLSL twin of eye/eye_contributions.h: what a path from the eye finds at the end of its ray, and where it goes. Colours
// are kept by the thread until its path ends; the layers of the first hit go to the image (device_image.glsl) at once.
#ifndef PHOTOND_EYE_CONTRIBUTIONS_GLSL
#define PHOTOND_EYE_CONTRIBUTIONS_GLSL

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/eye/eye_scene.glsl"
#include "renderer/transport/emission.glsl"
#include "renderer/transport/light_sampling.glsl"
#include "renderer/transport/mis.glsl"

/// What one path brings to its pixel.
struct PathLight {
    vec3 emitted, direct, indirect, caustic;
    vec3 albedo;
};
PathLight no_light() { return PathLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0)); }

/// Adds radiance that reached the eye along a path with that many scatterings.
void add_radiance(inout PathLight light, EyePath path, vec3 radiance) {
    if (path.scatterings == 0) {
        light.emitted += radiance;
    } else if (path.scatterings == 1) {
        light.direct += radiance;
    } else {
        light.indirect += radiance;
        if (path.caustic && layer_kept(LAYER_CAUSTIC)) light.caustic += radiance;
    }
}

/// Adds what comes from outside the scene along a ray that met nothing.
void add_environment(inout PathLight light, EyePath path, vec3 direction) {
    if (!NEEDS_ENVIRONMENT) return;
    const vec3 radiance = path.throughput * environment_radiance(direction);
    const float light_pdf = path.delta ? 0.0 : light_pdf_environment(path.position, path.lit_normal, direction);
    add_radiance(light, path, path.delta ? radiance : power_heuristic(path.pdf_sa, light_pdf) * radiance);
}

/// Adds what an emissive triangle sends along the ray that met it; `front`: met from its front side.
void add_emission(inout PathLight light, EyePath path, Hit hit, bool front, vec3 direction) {
    const vec3 emitted = emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, front);
    if (is_black(emitted)) return;
    const vec3 radiance = path.throughput * emitted;
    const float light_pdf =
        path.delta ? 0.0
                   : light_pdf_triangle(path.position, path.lit_normal, hit.instance, hit.triangle, direction, hit.t);
    add_radiance(light, path, path.delta ? radiance : power_heuristic(path.pdf_sa, light_pdf) * radiance);
}

/// Normals, position and depth are those of the first surface met, mirrors included.
void store_first_hit(uint pixel, vec3 position, vec3 shading_normal, vec3 geometric_normal) {
    if (!layer_kept(LAYER_HITS)) return;
    store_value(LAYER_HITS, pixel, 1.0);
    if (layer_kept(LAYER_NORMAL)) store_rgb(LAYER_NORMAL, pixel, shading_normal);
    if (layer_kept(LAYER_GEOMETRIC_NORMAL)) store_rgb(LAYER_GEOMETRIC_NORMAL, pixel, geometric_normal);
    if (layer_kept(LAYER_POSITION)) store_rgb(LAYER_POSITION, pixel, position);
    if (layer_kept(LAYER_DEPTH)) store_value(LAYER_DEPTH, pixel, dot(position - eye.camera.position, eye.camera.forward));
}

/// Adds what the path brought to its pixel's layers.
void store_light(uint pixel, PathLight light) {
    add_rgb(LAYER_EMITTED, pixel, light.emitted);
    add_rgb(LAYER_DIRECT, pixel, light.direct);
    add_rgb(LAYER_INDIRECT, pixel, light.indirect);
    if (layer_kept(LAYER_CAUSTIC)) add_rgb(LAYER_CAUSTIC, pixel, light.caustic);
    if (layer_kept(LAYER_ALBEDO)) store_rgb(LAYER_ALBEDO, pixel, light.albedo);
}

#endif
