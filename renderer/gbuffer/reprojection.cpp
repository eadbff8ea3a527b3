#include "renderer/gbuffer/reprojection.h"

#include <array>
#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/scene/camera_projection.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr float kLeastNormalCosine = 0.9f;  // 25 degrees
constexpr float kMostOffPlane = 0.01f;      // over the distance to the eye
constexpr float kOnPixel = 1e-3f;           // as near a pixel's middle it is the middle: nothing is blurred
constexpr float kLeastWeight = 0.05f;       // of the four pixels together, for them to tell anything
constexpr float kMirrorMetallic = 0.5f, kMirrorRoughness = 0.2f;

struct SurfacePoint {
    vec3 position, normal;
};

SurfacePoint point_of(const TriangleCorners& corners, const Hit& hit) {
    const auto& p = corners.p;
    return {(1 - hit.u - hit.v) * p[0] + hit.u * p[1] + hit.v * p[2], glm::cross(p[1] - p[0], p[2] - p[0])};
}

/// Its normal made unit and turned to the eye; false where the triangle has none.
bool face(SurfacePoint& point, const vec3& towards_eye) {
    const float length = glm::length(point.normal);
    if (!(length > 0)) return false;
    point.normal *= (glm::dot(point.normal, towards_eye) < 0 ? -1.0f : 1.0f) / length;
    return true;
}

Ray centre_ray(const CameraRays& camera, size_t x, size_t y) {
    return camera(vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), vec2(0.5f));
}

bool shows_elsewhere(const Material& material) {
    return material.transmission > 0 || (material.metallic > kMirrorMetallic && material.roughness < kMirrorRoughness);
}

/// Adds the values of a pixel of `from`, weighed, to those of `at` of `to`.
void add_weighed(const History& from, size_t pixel, float weight, History& to, size_t at) {
    to.indirect[at] += weight * from.indirect[pixel];
    to.frames[at] += weight * from.frames[pixel];
    to.near_light[at] += weight * from.near_light[pixel];
    to.near_step[at] += weight * from.near_step[pixel];
    to.step_product[at] += weight * from.step_product[pixel];
    to.age[at] += weight * from.age[pixel];
}

/// A pixel's history, by where its point was.
class Lookup {
public:
    explicit Lookup(const History& before) : before_(before), rays_(before.camera, before.size) {}

    Rejection take(SurfacePoint was, uint32_t instance, History& past, size_t at) const {
        const std::optional<vec2> film = project(rays_, was.position);
        const auto [width, height] = before_.size;
        if (!film || !(film->x >= 0 && film->y >= 0 && film->x < static_cast<float>(width) &&
                       film->y < static_cast<float>(height)))
            return Rejection::Outside;
        const Camera& camera = before_.camera;
        const vec3 from_eye = was.position - camera.position;
        if (!face(was, camera.orthographic ? -camera.forward : -from_eye)) return Rejection::Surface;
        const float most_off = kMostOffPlane * (camera.orthographic ? camera.ymag : glm::length(from_eye));
        const std::array<Tap, 2> across = taps(film->x), down = taps(film->y);
        float sum = 0;
        for (const Tap& y : down)
            for (const Tap& x : across) {
                const float weight = x.weight * y.weight;
                if (!(weight > 0) || x.pixel < 0 || y.pixel < 0 || x.pixel >= int64_t{width} ||
                    y.pixel >= int64_t{height})
                    continue;
                const auto pixel = static_cast<size_t>(y.pixel) * width + static_cast<size_t>(x.pixel);
                if (before_.instance[pixel] != instance || !(before_.frames[pixel] > 0) ||
                    glm::dot(before_.normal[pixel], was.normal) < kLeastNormalCosine ||
                    std::fabs(glm::dot(before_.position[pixel] - was.position, was.normal)) > most_off)
                    continue;
                add_weighed(before_, pixel, weight, past, at);
                sum += weight;
            }
        const float scale = sum > kLeastWeight ? 1 / sum : 0;
        past.indirect[at] *= scale, past.frames[at] *= scale;
        past.near_light[at] *= scale, past.near_step[at] *= scale;
        past.step_product[at] *= scale, past.age[at] *= scale;
        return scale > 0 ? Rejection::None : Rejection::Surface;
    }

private:
    struct Tap {
        int64_t pixel;
        float weight;
    };
    static std::array<Tap, 2> taps(float film) {
        const float middle = film - 0.5f, first = std::floor(middle);
        float share = middle - first;
        if (share < kOnPixel) share = 0;
        if (share > 1 - kOnPixel) share = 1;
        const auto pixel = static_cast<int64_t>(first);
        return {{{pixel, 1 - share}, {pixel + 1, share}}};
    }

    const History& before_;
    const CameraRays rays_;
};

}  // namespace

std::unique_ptr<HitsToCome> begin_centre_hits(const RenderContext& context) {
    const Size2 size = context.view.film_size;
    const CameraRays camera(context.view.camera, size);
    std::vector<Ray> rays(size.pixels());
    parallel_for(size.height, 4, [&](size_t y) {
        for (uint32_t x = 0; x < size.width; ++x) rays[y * size.width + x] = centre_ray(camera, x, y);
    });
    return context.intersector->begin_closest_hits(std::move(rays), Coherence::Coherent);
}

Reprojected reproject(const Scene& scene, const View& view, std::span<const Hit> hits, const History* before,
                      const PastPose* pose) {
    const Size2 size = view.film_size;
    Reprojected found{History(size), History(size), std::vector<Rejection>(size.pixels(), Rejection::Surface)};
    found.now.camera = view.camera;
    const CameraRays camera(view.camera, size);
    std::optional<Lookup> lookup;
    if (before) lookup.emplace(*before);
    parallel_for(size.pixels(), 1024, [&](size_t at) {
        const Hit& hit = hits[at];
        found.now.instance[at] = kNoHit;
        if (!hit.valid()) return;
        const Instance& instance = scene.instances[hit.instance];
        if (shows_elsewhere(scene.materials[scene.meshes[instance.mesh].material])) return;
        SurfacePoint point = point_of(world_triangle(scene, hit.instance, hit.triangle), hit);
        if (!face(point, -centre_ray(camera, at % size.width, at / size.width).direction)) return;
        found.now.instance[at] = hit.instance;
        found.now.position[at] = point.position, found.now.normal[at] = point.normal;
        if (!lookup || !pose) return;
        const std::optional<TriangleCorners> was = pose->triangle(scene, hit.instance, hit.triangle);
        if (was) found.rejection[at] = lookup->take(point_of(*was, hit), hit.instance, found.past, at);
    });
    return found;
}

}  // namespace photond
