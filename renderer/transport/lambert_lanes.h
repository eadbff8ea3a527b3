#pragma once
// Scattering at plain Lambert reflectors for as many paths at once as the machine has lanes: what make_shading_point()
// and Bsdf::lambert() do one by one. Textures are looked up one by one here too.
//
// A group is used in this order: gather() and the numbers for each lane, find_surface(), then scatter() for paths from
// the eye or scatter_photons() for paths from a light.

#include <utility>

#include "renderer/core/lanes.h"
#include "renderer/core/rgb.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"
#include "renderer/transport/ray_start.h"

namespace photond {

/// Surfaces that reflect like Bsdf::lambert() and shade without a normal map: those a LambertGroup knows.
inline bool is_plain_lambert(const Material& m) {
    return !m.unlit && m.metallic == 0 && m.specular == 0 && m.transmission == 0 && !m.normal_texture.used();
}
/// Whether the reflectance differs from place to place, by texture or vertex colour.
inline bool base_color_varies(const Scene& scene, const Mesh& mesh) {
    return scene.materials[mesh.material].base_color_texture.used() || !mesh.colors.empty();
}

using LaneFloats = float[kLanes];

struct Vec3Array {
    alignas(kLaneAlignment) LaneFloats x, y, z;

    void set(size_t lane, const vec3& v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
    vec3 get(size_t lane) const { return {x[lane], y[lane], z[lane]}; }
    Vec3Lanes load() const {
        constexpr std::experimental::vector_aligned_tag kAligned;
        return {FloatLanes(x, kAligned), FloatLanes(y, kAligned), FloatLanes(z, kAligned)};
    }
    void store(const Vec3Lanes& v) {
        constexpr std::experimental::vector_aligned_tag kAligned;
        v.x.copy_to(x, kAligned), v.y.copy_to(y, kAligned), v.z.copy_to(z, kAligned);
    }
};

namespace lambert_lanes {

namespace stdx = std::experimental;
inline constexpr stdx::vector_aligned_tag kAligned;

inline Vec3Lanes unit(const Vec3Lanes& v) { return (1.0f / stdx::sqrt(dot(v, v))) * v; }

inline Vec3Lanes select(const FloatMask& mask, const Vec3Lanes& a, const Vec3Lanes& b) {
    return {photond::select(mask, a.x, b.x), photond::select(mask, a.y, b.y), photond::select(mask, a.z, b.z)};
}

/// offset_ray_origin(), lane by lane.
inline FloatLanes offset_coordinate(const FloatLanes& p, const FloatLanes& n) {
    constexpr float kOrigin = 1.0f / 32.0f, kFloatScale = 1.0f / 65536.0f, kIntScale = 256.0f;
    // Where p is negative, counting its bits up moves it down: the sign goes to the offset.
    const IntLanes offset =
        stdx::static_simd_cast<IntLanes>(photond::select(p < 0, FloatLanes(-kIntScale), kIntScale) * n);
    const FloatLanes moved = float_from_bits(bits_of(p) + offset);
    return photond::select(stdx::fabs(p) < kOrigin, p + kFloatScale * n, moved);
}

/// surface_clearance(), lane by lane.
inline FloatLanes surface_clearance(const Vec3Lanes& a, const Vec3Lanes& b, const Vec3Lanes& c) {
    const auto farthest = [](const FloatLanes& p, const FloatLanes& q, const FloatLanes& r) {
        return stdx::max(stdx::max(stdx::fabs(p), stdx::fabs(q)), stdx::fabs(r));
    };
    return kClearance * farthest(farthest(a.x, b.x, c.x), farthest(a.y, b.y, c.y), farthest(a.z, b.z, c.z));
}

/// step_off(), lane by lane.
inline FloatLanes step_off_coordinate(const FloatLanes& p, const FloatLanes& n) {
    return p + kStepOff * n * stdx::fabs(p);
}

/// sample_unit_disk(), lane by lane.
inline std::pair<FloatLanes, FloatLanes> unit_disk(const FloatLanes& u, const FloatLanes& v) {
    const FloatLanes a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    const FloatMask wide = stdx::fabs(a) > stdx::fabs(b);
    const FloatLanes radius = photond::select(wide, a, b), other = photond::select(wide, b, a);
    const FloatLanes phi = (kPi / 4) * other / photond::select(radius == 0, FloatLanes(1), radius);
    const FloatLanes q = phi * phi;
    const FloatLanes sine =
        phi * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 + q * (-1.0f / 5040 + q * (1.0f / 362880)))));
    const FloatLanes cosine = 1.0f + q * (-1.0f / 2 + q * (1.0f / 24 + q * (-1.0f / 720 + q * (1.0f / 40320))));
    return {radius * photond::select(wide, cosine, sine), radius * photond::select(wide, sine, cosine)};
}

/// sample_cosine_hemisphere(), lane by lane.
inline Vec3Lanes cosine_hemisphere(const FloatLanes& u, const FloatLanes& v) {
    const auto [x, y] = unit_disk(u, v);
    return {x, y, stdx::sqrt(stdx::max(1.0f - x * x - y * y, FloatLanes(1e-8f)))};
}

/// A local direction in the world. [Duff et al. 2017], as in Frame.
inline Vec3Lanes to_world(const Vec3Lanes& n, const Vec3Lanes& w) {
    const FloatLanes sign = stdx::copysign(FloatLanes(1), n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    const Vec3Lanes tangent{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    const Vec3Lanes bitangent{b, sign + n.y * n.y * a, -n.y};
    return w.x * tangent + w.y * bitangent + w.z * n;
}

}  // namespace lambert_lanes

/// An instance as its triangles are read at hits: what lies behind several references in the scene, side by side.
/// Borrows the scene.
struct LambertSurface {
    LambertSurface(const Scene& scene, uint32_t index) {
        const Instance& instance = scene.instances[index];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Material& material = scene.materials[mesh.material];
        const auto data = [](const auto& array) { return array.empty() ? nullptr : array.data(); };
        triangles = mesh.triangles.data();
        positions = mesh.positions.data();
        normals = data(mesh.normals);
        colors = data(mesh.colors);
        placed = instance.identity ? nullptr : &instance;
        flip = instance.flips_orientation ? -1.0f : 1.0f;
        base_color = material.base_color;
        const TextureRef& reference = material.base_color_texture;
        if (!reference.used()) return;
        texture = &scene.textures[static_cast<size_t>(reference.texture)];
        uv = data(mesh.uv[reference.uv_set]);
        row_u = reference.row_u, row_v = reference.row_v;
    }

    bool varies() const { return texture || colors; }  // base_color_varies()

    void prefetch_corners(const Hit& hit) const {
        const uvec3 corner = triangles[hit.triangle];
        for (int i = 0; i < 3; ++i) {
            __builtin_prefetch(&positions[corner[i]]);
            if (normals) __builtin_prefetch(&normals[corner[i]]);
        }
    }
    void prefetch_coordinates(const Hit& hit) const {
        if (!varies()) return;
        const uvec3 corner = triangles[hit.triangle];
        for (int i = 0; i < 3; ++i) {
            if (uv) __builtin_prefetch(&uv[corner[i]]);
            if (colors) __builtin_prefetch(&colors[corner[i]]);
        }
    }

    /// Where the texture is read. To be called only where there is a texture.
    TextureLookup lookup(const Hit& hit) const {
        const vec3 st(uv ? interpolate(uv, hit) : vec2(0), 1);
        return prepare_lookup(*texture, {glm::dot(row_u, st), glm::dot(row_v, st)});
    }

    /// Base colour; `texels` as lookup() says, not looked at without a texture.
    Rgb reflectance(const Hit& hit, const TextureLookup& texels) const {
        Rgb color = base_color;
        if (texture) color *= sample_srgb(texels);
        if (colors) color *= Rgb(interpolate(colors, hit));
        return glm::clamp(color, Rgb(0), Rgb(1));  // vertex colours may exceed 1, reflectance may not
    }

    template <class T>
    T interpolate(const T* attribute, const Hit& hit) const {
        const uvec3 corner = triangles[hit.triangle];
        return (1 - hit.u - hit.v) * attribute[corner.x] + hit.u * attribute[corner.y] + hit.v * attribute[corner.z];
    }

    const uvec3* triangles;
    const vec3* positions;
    const vec3* normals;     // null: flat
    const vec4* colors;      // null: none
    const Instance* placed;  // null: the mesh is in world space
    const Texture* texture = nullptr;
    const vec2* uv = nullptr;  // null: (0, 0) everywhere
    vec3 row_u{0}, row_v{0};
    Rgb base_color;
    float flip;  // -1 where the instance mirrors
};

/// What a group of paths meets and where it goes on.
struct LambertGroup {
    // Gathered, lane by lane.
    Vec3Array corners[3], normals[3];  // world space; normals 0 where the mesh is flat
    Vec3Array direction;               // of the ray that met the surface
    Vec3Array throughput;              // of paths from a light: the photon's power
    Vec3Array reflectance;
    alignas(kLaneAlignment) LaneFloats u, v, flip;  // flip: -1 where the instance mirrors
    alignas(kLaneAlignment)
        LaneFloats scale;  // what throughput's greatest component is multiplied by to judge the path
    alignas(kLaneAlignment) LaneFloats roulette, sample_x, sample_y;  // uniform numbers

    // Of find_surface().
    Vec3Array position, geometric_normal, normal, start;
    Vec3Array smooth_normal;  // interpolated, on the geometric normal's side; that one where the mesh is flat
    alignas(kLaneAlignment) LaneFloats front;  // 1: seen from the front, or 0

    // Of scatter() and scatter_photons().
    Vec3Array next_direction;
    alignas(kLaneAlignment) LaneFloats scattered;         // 1: goes on, or 0
    alignas(kLaneAlignment) LaneFloats cos_next;          // scatter() alone: against the normal
    alignas(kLaneAlignment) LaneFloats survival_inverse;  // scatter() alone; NaN where the path's numbers are
    alignas(kLaneAlignment) LaneFloats correction;        // scatter_photons(): of the shading normal

    /// `varies`: base_color_varies().
    void gather(size_t lane, const Scene& scene, bool varies, const Hit& hit, const Ray& ray,
                const Rgb& path_throughput, float path_scale) {
        const Instance& instance = scene.instances[hit.instance];
        const Mesh& mesh = scene.meshes[instance.mesh];
        gather_triangle(lane, mesh.triangles[hit.triangle], mesh.positions.data(),
                        mesh.normals.empty() ? nullptr : mesh.normals.data(), instance.identity ? nullptr : &instance);
        flip[lane] = instance.flips_orientation ? -1.0f : 1.0f;
        u[lane] = hit.u, v[lane] = hit.v;
        direction.set(lane, ray.direction);
        throughput.set(lane, path_throughput);
        scale[lane] = path_scale;
        // Vertex colours may exceed 1, reflectance may not.
        reflectance.set(
            lane, varies ? glm::clamp(Rgb(surface_base_color(scene, mesh, hit.triangle, hit.u, hit.v)), Rgb(0), Rgb(1))
                         : scene.materials[mesh.material].base_color);
    }

    /// What find_surface() and scatter_photons() need.
    void gather(size_t lane, const LambertSurface& surface, const Hit& hit, const Ray& ray) {
        gather_triangle(lane, surface.triangles[hit.triangle], surface.positions, surface.normals, surface.placed);
        flip[lane] = surface.flip;
        u[lane] = hit.u, v[lane] = hit.v;
        direction.set(lane, ray.direction);
    }

    /// make_plain_shading_point(): position and normals on the side the ray came from.
    void find_surface() {
        using namespace lambert_lanes;
        const FloatLanes weight_u(u, kAligned), weight_v(v, kAligned), weight_w = 1.0f - weight_u - weight_v;
        const Vec3Lanes a = corners[0].load(), b = corners[1].load(), c = corners[2].load(), d = direction.load();
        Vec3Lanes geometric = FloatLanes(flip, kAligned) * unit(cross(b - a, c - a));
        const FloatMask from_front = dot(geometric, d) < 0;
        geometric = photond::select(from_front, FloatLanes(1), FloatLanes(-1)) * geometric;
        photond::select(from_front, FloatLanes(1), FloatLanes(0)).copy_to(front, kAligned);
        const Vec3Lanes point = weight_w * a + weight_u * b + weight_v * c + surface_clearance(a, b, c) * geometric;

        const Vec3Lanes sum =
            weight_w * normals[0].load() + weight_u * normals[1].load() + weight_v * normals[2].load();
        const FloatLanes length_sq = dot(sum, sum);
        const FloatMask smooth = length_sq > 1e-30f;
        const FloatLanes turn = photond::select(dot(sum, geometric) < 0, FloatLanes(-1), FloatLanes(1)) /
                                stdx::sqrt(photond::select(smooth, length_sq, FloatLanes(1)));
        const Vec3Lanes turned = lambert_lanes::select(smooth, turn * sum, geometric);
        position.store(point);
        geometric_normal.store(geometric);
        smooth_normal.store(turned);
        normal.store(lambert_lanes::select(dot(turned, d) < 0, turned, geometric));
        start.store({step_off_coordinate(point.x, geometric.x), step_off_coordinate(point.y, geometric.y),
                     step_off_coordinate(point.z, geometric.z)});
    }

    /// Bsdf::lambert() and, if asked for, Russian roulette, which no path passes with more than `most_survival`.
    void scatter(bool with_roulette, float most_survival) {
        using namespace lambert_lanes;
        const Vec3Lanes n = normal.load();
        const Vec3Lanes w = cosine_hemisphere(FloatLanes(sample_x, kAligned), FloatLanes(sample_y, kAligned));
        const Vec3Lanes wi = to_world(n, w);

        const Vec3Lanes left = throughput.load() * reflectance.load();
        const FloatLanes hope = stdx::max(stdx::max(left.x, left.y), left.z) * FloatLanes(scale, kAligned);
        const FloatLanes survival = with_roulette ? stdx::min(hope, FloatLanes(most_survival)) : FloatLanes(1);
        const FloatMask on = FloatLanes(roulette, kAligned) < survival && hope > 0 && dot(n, direction.load()) < 0 &&
                             dot(wi, geometric_normal.load()) > 0;
        next_direction.store(wi);
        w.z.copy_to(cos_next, kAligned);
        (1.0f / survival).copy_to(survival_inverse, kAligned);
        photond::select(on, FloatLanes(1), FloatLanes(0)).copy_to(scattered, kAligned);
    }

    /// scatter_photon(): power changes by reflectance x correction.
    void scatter_photons() {
        using namespace lambert_lanes;
        const Vec3Lanes geometric = geometric_normal.load(), d = direction.load(), turned = smooth_normal.load();
        const Vec3Lanes wi =
            to_world(geometric, cosine_hemisphere(FloatLanes(sample_x, kAligned), FloatLanes(sample_y, kAligned)));

        // Drawn about the geometric normal, what photon_scattering.h asks for comes down to
        // |cos_s(arriving)| / |cos_g(arriving)|, with the shading normal an eye at the end of wi would have.
        const FloatMask flat = turned.x == geometric.x && turned.y == geometric.y && turned.z == geometric.z;
        const FloatLanes factor = photond::select(flat || dot(turned, wi) <= 0, FloatLanes(1),
                                                  stdx::max(-dot(turned, d), FloatLanes(0)) / -dot(geometric, d));

        // All paths that are not black go on; those that are no number too, so that they are counted.
        const FloatMask on = dot(geometric, wi) > 0 && !(factor == 0);
        next_direction.store(wi);
        factor.copy_to(correction, kAligned);
        photond::select(on, FloatLanes(1), FloatLanes(0)).copy_to(scattered, kAligned);
    }

private:
    /// `normals_at` is null where the mesh is flat, `placed` where it is in world space.
    void gather_triangle(size_t lane, const uvec3& corner, const vec3* positions, const vec3* normals_at,
                         const Instance* placed) {
        for (int c = 0; c < 3; ++c) {
            const vec3& p = positions[corner[c]];
            corners[c].set(lane, placed ? placed->to_world * vec4(p, 1.0f) : p);
            const vec3 n = normals_at ? normals_at[corner[c]] : vec3(0);
            normals[c].set(lane, placed ? placed->normal_to_world * n : n);
        }
    }
};

}  // namespace photond
