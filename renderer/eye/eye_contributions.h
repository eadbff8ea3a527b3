#pragma once
// What a path from the eye finds at the end of its ray, and where in the image it goes.

#include "renderer/eye/eye_path.h"
#include "renderer/eye/eye_scene.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/mis.h"

namespace photond {

/// A pass starts from black, pixel by pixel: by the thread that renders the pixel.
inline void clear_pixel(PassImage& image, uint32_t pixel) {
    for (std::vector<Rgb>* layer : {&image.emitted, &image.direct, &image.indirect, &image.caustic, &image.albedo,
                                    &image.normal, &image.position})
        if (!layer->empty()) (*layer)[pixel] = Rgb(0);
    if (!image.depth.empty()) image.depth[pixel] = 0;
    if (!image.photon_count.empty()) image.photon_count[pixel] = 0;
    if (!image.overlap.empty()) image.overlap[pixel] = 0;
    if (!image.hit.empty()) image.hit[pixel] = 0;
}

/// Adds radiance that reached the eye along a path with that many scatterings.
inline void add_radiance(PassImage& image, const EyePath& path, const Rgb& radiance) {
    if (path.scatterings == 0) {
        image.emitted[path.pixel] += radiance;
    } else if (path.scatterings == 1) {
        image.direct[path.pixel] += radiance;
    } else {
        image.indirect[path.pixel] += radiance;
        if (path.caustic && !image.caustic.empty()) image.caustic[path.pixel] += radiance;
    }
}

/// Adds what comes from outside the scene along a ray that met nothing.
inline void add_environment(PassImage& image, const EyeScene& shared, const EyePath& path, const vec3& direction) {
    if (!shared.scene.environment) return;
    const Rgb radiance = path.throughput * shared.lights.environment_radiance(direction);
    const float light_pdf =
        path.delta ? 0.0f : shared.lights.pdf_environment(path.position, path.lit_normal, direction);
    add_radiance(image, path, path.delta ? radiance : power_heuristic(path.pdf_sa, light_pdf) * radiance);
}

/// Adds what an emissive triangle sends along the ray that met it; `front`: met from its front side.
inline void add_emission(PassImage& image, const EyeScene& shared, const EyePath& path, const Hit& hit, bool front,
                         const vec3& direction) {
    const Rgb emitted = emitted_radiance(shared.scene, {hit.instance, hit.triangle, hit.u, hit.v}, front);
    if (is_black(emitted)) return;
    const Rgb radiance = path.throughput * emitted;
    const float light_pdf = path.delta ? 0.0f
                                       : shared.lights.pdf_triangle(path.position, path.lit_normal, hit.instance,
                                                                    hit.triangle, direction, hit.t);
    add_radiance(image, path, path.delta ? radiance : power_heuristic(path.pdf_sa, light_pdf) * radiance);
}

/// Normal, position and depth are those of the first surface met, mirrors included.
inline void store_first_hit(PassImage& image, const EyeScene& shared, uint32_t pixel, const vec3& position,
                            const vec3& shading_normal) {
    if (image.hit.empty()) return;
    image.hit[pixel] = 1;
    if (!image.normal.empty()) image.normal[pixel] = shading_normal;
    if (!image.position.empty()) image.position[pixel] = vec3(dvec3(position) + shared.scene.origin);
    if (!image.depth.empty())
        image.depth[pixel] = glm::dot(position - shared.view.camera.position, shared.view.camera.forward);
}

}  // namespace photond
