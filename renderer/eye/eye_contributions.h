#pragma once
// What a path from the eye finds at the end of its ray, and where in the image it goes.

#include "renderer/eye/eye_path.h"
#include "renderer/eye/eye_scene.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/mis.h"

namespace photond {

/// Adds radiance that reached the eye along a path with that many scatterings.
inline void add_radiance(PassImage& image, const EyePath& path, const Rgb& radiance) {
    if (path.scatterings == 0) {
        image.of<Layer::Emitted>()[path.pixel] += radiance;
    } else if (path.scatterings == 1) {
        image.of<Layer::Direct>()[path.pixel] += radiance;
    } else {
        image.of<Layer::Indirect>()[path.pixel] += radiance;
        if (path.caustic && image.layers.has(Layer::Caustic)) image.of<Layer::Caustic>()[path.pixel] += radiance;
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

/// Normals, position and depth are those of the first surface met, mirrors included.
inline void store_first_hit(PassImage& image, const EyeScene& shared, uint32_t pixel, const vec3& position,
                            const vec3& shading_normal, const vec3& geometric_normal) {
    if (image.hit.empty()) return;
    image.hit[pixel] = 1;
    if (image.layers.has(Layer::Normal)) image.of<Layer::Normal>()[pixel] = shading_normal;
    if (image.layers.has(Layer::GeometricNormal)) image.of<Layer::GeometricNormal>()[pixel] = geometric_normal;
    if (image.layers.has(Layer::Position))
        image.of<Layer::Position>()[pixel] = vec3(dvec3(position) + shared.scene.origin);
    if (image.layers.has(Layer::Depth))
        image.of<Layer::Depth>()[pixel] = glm::dot(position - shared.view.camera.position, shared.view.camera.forward);
}

}  // namespace photond
