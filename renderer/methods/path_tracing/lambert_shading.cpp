// Shading of hits on plain Lambert reflectors: what general_shading.cpp does, for as many paths at once as the machine
// has lanes. Textures and the choice of a point on a light are left to one at a time.

#include "renderer/core/lanes.h"
#include "renderer/methods/eye_contributions.h"
#include "renderer/methods/hit_prefetch.h"
#include "renderer/methods/path_tracing/wavefront.h"
#include "renderer/scene/surface_color.h"

namespace photond {

namespace stdx = std::experimental;

namespace {

using LaneFloats = float[kLanes];
constexpr stdx::vector_aligned_tag kAligned;

struct Vec3Array {
    alignas(64) LaneFloats x, y, z;

    void set(size_t lane, const vec3& v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
    vec3 get(size_t lane) const { return {x[lane], y[lane], z[lane]}; }
    Vec3Lanes load() const { return {FloatLanes(x, kAligned), FloatLanes(y, kAligned), FloatLanes(z, kAligned)}; }
    void store(const Vec3Lanes& v) { v.x.copy_to(x, kAligned), v.y.copy_to(y, kAligned), v.z.copy_to(z, kAligned); }
};

Vec3Lanes unit(const Vec3Lanes& v) { return (1.0f / stdx::sqrt(dot(v, v))) * v; }

Vec3Lanes select(const FloatMask& mask, const Vec3Lanes& a, const Vec3Lanes& b) {
    return {photond::select(mask, a.x, b.x), photond::select(mask, a.y, b.y), photond::select(mask, a.z, b.z)};
}

/// offset_ray_origin(), lane by lane.
FloatLanes offset_coordinate(const FloatLanes& p, const FloatLanes& n) {
    constexpr float kOrigin = 1.0f / 32.0f, kFloatScale = 1.0f / 65536.0f, kIntScale = 256.0f;
    // Where p is negative, counting its bits up moves it down: the sign goes to the offset.
    const IntLanes offset =
        stdx::static_simd_cast<IntLanes>(photond::select(p < 0, FloatLanes(-kIntScale), kIntScale) * n);
    const FloatLanes moved = float_from_bits(bits_of(p) + offset);
    return photond::select(stdx::fabs(p) < kOrigin, p + kFloatScale * n, moved);
}

/// sample_cosine_hemisphere(), lane by lane; the concentric map's angles stay within +-pi/4, where the Taylor series
/// are exact to float precision.
Vec3Lanes cosine_hemisphere(const FloatLanes& u, const FloatLanes& v) {
    const FloatLanes a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    const FloatMask wide = stdx::fabs(a) > stdx::fabs(b);
    const FloatLanes radius = photond::select(wide, a, b), other = photond::select(wide, b, a);
    const FloatLanes phi = (kPi / 4) * other / photond::select(radius == 0, FloatLanes(1), radius);
    const FloatLanes q = phi * phi;
    const FloatLanes sine =
        phi * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 + q * (-1.0f / 5040 + q * (1.0f / 362880)))));
    const FloatLanes cosine = 1.0f + q * (-1.0f / 2 + q * (1.0f / 24 + q * (-1.0f / 720 + q * (1.0f / 40320))));
    const FloatLanes x = radius * photond::select(wide, cosine, sine), y = radius * photond::select(wide, sine, cosine);
    return {x, y, stdx::sqrt(stdx::max(1.0f - x * x - y * y, FloatLanes(1e-8f)))};
}

/// What a group of paths meets and where it goes on.
struct Group {
    // Gathered from the scene.
    Vec3Array corners[3], normals[3];  // world space; normals 0 where the mesh is flat
    Vec3Array direction, throughput, reflectance;
    alignas(64) LaneFloats u, v, flip;  // flip: -1 where the instance mirrors
    alignas(64) LaneFloats eta_scale, roulette, sample_x, sample_y;

    // Computed.
    Vec3Array position, geometric_normal, normal, start, next_direction;
    alignas(64) LaneFloats front, scattered, cos_next, survival_inverse;  // front, scattered: 1 or 0

    void gather(size_t lane, const PathTracingScene& shared, const Hit& hit, const Ray& ray, const EyePath& path) {
        const Scene& scene = shared.scene;
        const Instance& instance = scene.instances[hit.instance];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const uvec3 corner = mesh.triangles[hit.triangle];
        const bool smooth = !mesh.normals.empty();
        for (int c = 0; c < 3; ++c) {
            const vec3& p = mesh.positions[corner[c]];
            corners[c].set(lane, instance.identity ? p : instance.to_world * vec4(p, 1.0f));
            const vec3 n = smooth ? mesh.normals[corner[c]] : vec3(0);
            normals[c].set(lane, instance.identity ? n : instance.normal_to_world * n);
        }
        u[lane] = hit.u, v[lane] = hit.v;
        flip[lane] = instance.flips_orientation ? -1.0f : 1.0f;
        direction.set(lane, ray.direction);
        throughput.set(lane, path.throughput);
        eta_scale[lane] = path.eta_scale;
        // Vertex colours may exceed 1, reflectance may not.
        reflectance.set(
            lane, shared.shading[hit.instance].varies
                      ? glm::clamp(Rgb(surface_base_color(scene, mesh, hit.triangle, hit.u, hit.v)), Rgb(0), Rgb(1))
                      : scene.materials[mesh.material].base_color);
    }

    /// make_plain_shading_point(): position and normals on the side the ray came from.
    void find_surface() {
        const FloatLanes weight_u(u, kAligned), weight_v(v, kAligned), weight_w = 1.0f - weight_u - weight_v;
        const Vec3Lanes a = corners[0].load(), b = corners[1].load(), c = corners[2].load(), d = direction.load();
        const Vec3Lanes point = weight_w * a + weight_u * b + weight_v * c;
        Vec3Lanes geometric = FloatLanes(flip, kAligned) * unit(cross(b - a, c - a));
        const FloatMask from_front = dot(geometric, d) < 0;
        geometric = photond::select(from_front, FloatLanes(1), FloatLanes(-1)) * geometric;
        photond::select(from_front, FloatLanes(1), FloatLanes(0)).copy_to(front, kAligned);

        const Vec3Lanes sum =
            weight_w * normals[0].load() + weight_u * normals[1].load() + weight_v * normals[2].load();
        const FloatLanes length_sq = dot(sum, sum);
        const FloatMask smooth = length_sq > 1e-30f;
        const FloatLanes scale = photond::select(dot(sum, geometric) < 0, FloatLanes(-1), FloatLanes(1)) /
                                 stdx::sqrt(photond::select(smooth, length_sq, FloatLanes(1)));
        const Vec3Lanes turned = scale * sum;
        position.store(point);
        geometric_normal.store(geometric);
        normal.store(select(smooth && dot(turned, d) < 0, turned, geometric));
        start.store({offset_coordinate(point.x, geometric.x), offset_coordinate(point.y, geometric.y),
                     offset_coordinate(point.z, geometric.z)});
    }

    /// Bsdf::lambert() and, if asked for, Russian roulette.
    void scatter(bool with_roulette) {
        const Vec3Lanes n = normal.load();
        const Vec3Lanes w = cosine_hemisphere(FloatLanes(sample_x, kAligned), FloatLanes(sample_y, kAligned));
        // [Duff et al. 2017], as in Frame.
        const FloatLanes sign = stdx::copysign(FloatLanes(1), n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
        const Vec3Lanes tangent{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
        const Vec3Lanes bitangent{b, sign + n.y * n.y * a, -n.y};
        const Vec3Lanes wi = w.x * tangent + w.y * bitangent + w.z * n;

        const Vec3Lanes left = throughput.load() * reflectance.load();
        const FloatLanes hope = stdx::max(stdx::max(left.x, left.y), left.z) * FloatLanes(eta_scale, kAligned);
        const FloatLanes survival = with_roulette ? stdx::min(hope, FloatLanes(kMaxSurvival)) : FloatLanes(1);
        const FloatMask on = FloatLanes(roulette, kAligned) < survival && hope > 0 && dot(n, direction.load()) < 0 &&
                             dot(wi, geometric_normal.load()) > 0;
        next_direction.store(wi);
        w.z.copy_to(cos_next, kAligned);
        (1.0f / survival).copy_to(survival_inverse, kAligned);
        photond::select(on, FloatLanes(1), FloatLanes(0)).copy_to(scattered, kAligned);
    }
};

}  // namespace

void Wavefront::shade_lambert(const PathTracingScene& shared, uint32_t vertex, PassImage& image) {
    const Scene& scene = shared.scene;
    const bool roulette = vertex + 1 >= shared.roulette_start;
    Group group;
    for (size_t first = 0; first < lambert_.size(); first += kLanes) {
        const size_t lanes = std::min(kLanes, lambert_.size() - first);
        for (size_t lane = 0; lane < kLanes; ++lane) {  // lanes past the end repeat the last path and are not read
            const size_t place = std::min(first + lane, lambert_.size() - 1);
            prefetch_ahead(scene, hits_, lambert_, place);
            const uint32_t i = lambert_[place];
            group.gather(lane, shared, hits_[i], rays_[i], paths_[i]);
            group.sample_x[lane] = direction_.x[i];
            group.sample_y[lane] = direction_.y[i];
            group.roulette[lane] = roulette ? choice_.y[i] : 0.0f;
        }
        group.find_surface();
        group.scatter(roulette);

        for (size_t lane = 0; lane < lanes; ++lane) {
            const uint32_t i = lambert_[first + lane];
            const EyePath& path = paths_[i];
            const Hit& hit = hits_[i];
            const vec3 position = group.position.get(lane), normal = group.normal.get(lane);
            const Rgb reflectance = group.reflectance.get(lane);
            if (vertex == 0) store_first_hit(image, shared, path.pixel, position, normal);
            if (shared.shading[hit.instance].emits)
                add_emission(image, shared, path, hit, group.front[lane] != 0, rays_[i].direction);
            if (path.scatterings >= shared.max_scatterings || is_black(reflectance)) continue;
            const bool camera_walk = path.scatterings == 0;
            if (camera_walk && !image.albedo.empty() && is_black(image.albedo[path.pixel]))
                image.albedo[path.pixel] = reflectance;

            const vec3 start = group.start.get(lane);
            LightSample light;
            if (shared.lights.sample(position, normal, choice_.x[i], {light_point_.x[i], light_point_.y[i]}, light)) {
                const float cos_light = glm::dot(normal, light.wi);
                if (cos_light > 0 && glm::dot(group.geometric_normal.get(lane), light.wi) > 0) {
                    const float pdf_sa = cos_light * kInvPi;
                    const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, pdf_sa);
                    shadow_rays_[shadow_count_] = light.shadow_ray(start);
                    pending_[shadow_count_++] = {
                        (weight * pdf_sa) * path.throughput * reflectance * light.radiance_over_pdf, path.pixel,
                        !camera_walk};
                }
            }
            if (group.scattered[lane] == 0) continue;
            EyePath& next = next_paths_[next_count_];
            next = path;
            next.throughput *= reflectance * group.survival_inverse[lane];
            next.pdf_sa = group.cos_next[lane] * kInvPi;
            next.position = position;
            next.lit_normal = normal;
            next.delta = false;
            next.caustic = camera_walk;
            ++next.scatterings;
            next_rays_[next_count_] = {start, group.next_direction.get(lane), kInfinity};
            next_keys_[next_count_++] = keys_[i];
        }
    }
}

}  // namespace photond
