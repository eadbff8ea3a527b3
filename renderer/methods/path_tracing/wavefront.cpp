#include "renderer/methods/path_tracing/wavefront.h"

#include <ctime>

#include "renderer/transport/bsdf.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/mis.h"

namespace photond {

namespace {

double thread_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// No path outlives roulette for ever, however white the scene.
constexpr float kMaxSurvival = 0.98f;

/// Adds radiance that reached the eye along a path with that many scatterings.
void add_radiance(PassImage& image, const Path& path, const Rgb& radiance) {
    if (path.scatterings == 0) {
        image.emitted[path.pixel] += radiance;
    } else if (path.scatterings == 1) {
        image.direct[path.pixel] += radiance;
    } else {
        image.indirect[path.pixel] += radiance;
        if (path.caustic && !image.caustic.empty()) image.caustic[path.pixel] += radiance;
    }
}

void clear_pixel(PassImage& image, uint32_t pixel) {
    for (std::vector<Rgb>* layer : {&image.emitted, &image.direct, &image.indirect, &image.caustic, &image.albedo,
                                    &image.normal, &image.position})
        if (!layer->empty()) (*layer)[pixel] = Rgb(0);
    if (!image.depth.empty()) image.depth[pixel] = 0;
    if (!image.hit.empty()) image.hit[pixel] = 0;
}

/// Normal, position and depth are those of the first surface met, mirrors included.
void store_first_hit(PassImage& image, const PathTracingScene& shared, uint32_t pixel, const ShadingPoint& point) {
    if (image.hit.empty()) return;
    image.hit[pixel] = 1;
    if (!image.normal.empty()) image.normal[pixel] = point.shading.normal;
    if (!image.position.empty()) image.position[pixel] = vec3(dvec3(point.position) + shared.scene.origin);
    if (!image.depth.empty())
        image.depth[pixel] = glm::dot(point.position - shared.view.camera.position, shared.view.camera.forward);
}

/// What is left after `distance` [m] in the solid; infinite distance: nothing where it absorbs at all.
Rgb transmittance(const Rgb& absorption_per_m, float distance) {
    Rgb left;
    for (int c = 0; c < 3; ++c) left[c] = absorption_per_m[c] > 0 ? std::exp(-absorption_per_m[c] * distance) : 1.0f;
    return left;
}

}  // namespace

Wavefront::Wavefront() : rays_(kPaths), hits_(kPaths), paths_(kPaths), keys_(kPaths), occluded_(kPaths) {
    shadow_rays_.reserve(kPaths);
    pending_.reserve(kPaths);
    for (Numbers* numbers : {&light_point_, &choice_, &direction_, &lobe_})
        numbers->x.resize(kPaths), numbers->y.resize(kPaths);
}

uint64_t Wavefront::bytes_per_thread() {
    return kPaths * (2 * sizeof(Ray) + sizeof(Hit) + sizeof(Path) + sizeof(uint32_t) + sizeof(Pending) +
                     sizeof(uint8_t) + 8 * sizeof(float));
}

void Wavefront::trace_tile(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile,
                           PassImage& image, Counts& counts, PathSeconds& seconds) {
    const bool plain = shared.scene.needs.only_lambert();
    double then = thread_seconds();
    const auto lap = [&then](double& part) {
        const double now = thread_seconds();
        part += now - then;
        then = now;
    };
    start_paths(shared, sampler, tile);
    for (size_t i = 0; i < count_; ++i) clear_pixel(image, paths_[i].pixel);

    for (uint32_t vertex = 0; count_ > 0; ++vertex) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_},
                                        vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
        (vertex == 0 ? counts.camera_rays : counts.bounce_rays) += count_;
        if (vertex == 0) lap(seconds.camera);

        draw_numbers(sampler, vertex, !plain);
        plain ? shade<true>(shared, vertex, image) : shade<false>(shared, vertex, image);
        trace_shadow_rays(shared, vertex, image, counts);
        lap(vertex == 0 ? seconds.direct : seconds.indirect);
    }
}

void Wavefront::start_paths(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile) {
    count_ = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x) {
            Path& path = paths_[count_];
            path = Path{};
            path.pixel = y * shared.view.film_size.width + x;
            keys_[count_++] = sampler.pixel_key(path.pixel);
        }
    }
    const std::span<const uint32_t> keys(keys_.data(), count_);
    sampler.sample_2d(keys, sample_set(CameraSet::Film), {direction_.x.data(), count_}, {direction_.y.data(), count_});
    const bool lens = shared.view.camera.aperture_radius_m > 0;
    if (lens) sampler.sample_2d(keys, sample_set(CameraSet::Lens), {lobe_.x.data(), count_}, {lobe_.y.data(), count_});
    for (size_t i = 0; i < count_; ++i) {
        const uint32_t pixel = paths_[i].pixel, width = shared.view.film_size.width;
        const vec2 corner(float(pixel % width), float(pixel / width));
        rays_[i] = shared.camera_rays(corner + shared.filter({direction_.x[i], direction_.y[i]}),
                                      lens ? vec2(lobe_.x[i], lobe_.y[i]) : vec2(0));
    }
}

void Wavefront::draw_numbers(const PassSampler& sampler, uint32_t vertex, bool lobes) {
    const std::span<const uint32_t> keys(keys_.data(), count_);
    const auto draw = [&](VertexSet set, Numbers& numbers) {
        sampler.sample_2d(keys, sample_set(vertex, set), {numbers.x.data(), count_}, {numbers.y.data(), count_});
    };
    draw(VertexSet::LightPoint, light_point_);
    draw(VertexSet::LightChoiceAndRoulette, choice_);
    draw(VertexSet::Direction, direction_);
    if (lobes) draw(VertexSet::Lobe, lobe_);
}

template <bool kPlain>
void Wavefront::shade(const PathTracingScene& shared, uint32_t vertex, PassImage& image) {
    shadow_rays_.clear();
    pending_.clear();
    size_t kept = 0;  // paths that go on close the gaps left by those that end
    for (size_t i = 0; i < count_; ++i) {
        if (!shade_vertex<kPlain>(shared, vertex, i, image)) continue;
        if (kept != i) {
            paths_[kept] = paths_[i];
            rays_[kept] = rays_[i];
            keys_[kept] = keys_[i];
        }
        ++kept;
    }
    count_ = kept;
}

/// Adds what path i finds at the end of its ray, draws a light sample there and the next ray. False: the path ends.
template <bool kPlain>
bool Wavefront::shade_vertex(const PathTracingScene& shared, uint32_t vertex, size_t i, PassImage& image) {
    const Scene& scene = shared.scene;
    Path& path = paths_[i];
    Ray& ray = rays_[i];
    const Hit& hit = hits_[i];

    if constexpr (!kPlain) {
        if (const uint32_t medium = path.media.top(); medium != MediumStack::kVacuum)
            path.throughput *= transmittance(shared.absorption_per_m[medium], hit.t);
    }
    if (!hit.valid()) {
        if (!scene.environment) return false;
        const Rgb radiance = path.throughput * shared.lights.environment_radiance(ray.direction);
        const float weight =
            path.delta ? 1.0f
                       : power_heuristic(path.pdf_sa,
                                         shared.lights.pdf_environment(path.position, path.lit_normal, ray.direction));
        add_radiance(image, path, weight * radiance);
        return false;
    }

    const ShadingPoint point =
        kPlain ? make_plain_shading_point(scene, hit, ray.direction) : make_shading_point(scene, hit, ray.direction);
    const Material& material = scene.materials[point.material];
    if (vertex == 0) store_first_hit(image, shared, path.pixel, point);
    const SurfacePoint place{hit.instance, hit.triangle, hit.u, hit.v};
    if (!kPlain && material.unlit) {
        if (path.scatterings == 0) {
            const Rgb radiance = unlit_radiance(scene, place);
            add_radiance(image, path, path.throughput * radiance);
            if (!image.albedo.empty()) image.albedo[path.pixel] = radiance;
        }
        return false;
    }
    if (material.emissive()) {
        const Rgb radiance = path.throughput * emitted_radiance(scene, place, point.front_side);
        const float weight =
            path.delta
                ? 1.0f
                : power_heuristic(path.pdf_sa, shared.lights.pdf_triangle(path.position, path.lit_normal, hit.instance,
                                                                          hit.triangle, ray.direction, hit.t));
        add_radiance(image, path, weight * radiance);
    }
    if (path.scatterings >= shared.max_scatterings) return false;

    Bsdf bsdf;
    if constexpr (kPlain) {
        bsdf = make_plain_bsdf(scene, point);
    } else {
        const uint32_t outside = path.media.outside_of(point.material, !point.front_side);
        bsdf = make_bsdf(scene, point, outside == MediumStack::kVacuum ? 1.0f : scene.materials[outside].ior);
    }
    const vec3 wo = point.shading.to_local(-ray.direction);
    const bool camera_walk = path.scatterings == 0;
    if (camera_walk && !image.albedo.empty() && bsdf.has_non_delta() && is_black(image.albedo[path.pixel]))
        image.albedo[path.pixel] = bsdf.albedo();

    path.position = point.position;
    path.lit_normal = !kPlain && bsdf.has_non_delta_transmission() ? vec3(0) : point.shading.normal;
    LightSample light;
    if (bsdf.has_non_delta() && shared.lights.sample(path.position, path.lit_normal, choice_.x[i],
                                                     {light_point_.x[i], light_point_.y[i]}, light)) {
        const BsdfValue f = bsdf.evaluate(wo, point.shading.to_local(light.wi));
        if (!is_black(f.f_cos)) {
            const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, f.pdf_sa);
            shadow_rays_.push_back(light.shadow_ray(ray_origin(point, light.wi)));
            pending_.push_back(
                {weight * path.throughput * f.f_cos * light.radiance_over_pdf, path.pixel, path.scatterings > 0});
        }
    }

    const BsdfSample next = bsdf.sample(wo, kPlain ? 0.0f : lobe_.x[i], {direction_.x[i], direction_.y[i]});
    if (!next.valid()) return false;
    path.throughput *= next.weight;
    path.pdf_sa = next.pdf_sa;
    path.delta = next.delta;
    if (!(camera_walk && next.delta)) {
        path.caustic = camera_walk || (path.caustic && next.delta);
        ++path.scatterings;
    }
    if constexpr (!kPlain) {
        if (next.refraction) {
            path.eta_scale *= sqr(next.eta);
            point.front_side ? path.media.enter(point.material) : path.media.leave(point.material);
        }
    }

    if (!is_finite(path.throughput)) {  // shown, not hidden: the film drops and counts it
        add_radiance(image, path, path.throughput);
        return false;
    }
    const float hope = max_component(path.throughput) * path.eta_scale;
    if (vertex + 1 >= shared.roulette_start) {
        const float survival = std::min(hope, kMaxSurvival);
        if (choice_.y[i] >= survival) return false;
        path.throughput /= survival;
    }
    const vec3 wi = point.shading.to_world(next.wi);
    ray = {ray_origin(point, wi), wi, kInfinity};
    return true;
}

void Wavefront::trace_shadow_rays(const PathTracingScene& shared, uint32_t vertex, PassImage& image, Counts& counts) {
    shared.intersector.occluded(shadow_rays_, {occluded_.data(), shadow_rays_.size()},
                                vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
    counts.shadow_rays += shadow_rays_.size();
    for (size_t i = 0; i < pending_.size(); ++i) {
        if (occluded_[i]) continue;
        const Pending& light = pending_[i];
        (light.indirect ? image.indirect : image.direct)[light.pixel] += light.radiance;
    }
}

}  // namespace photond
