#include "renderer/gbuffer/light_depth_maps.h"

#include <algorithm>
#include <cassert>
#include <string>

#include "protocol/error.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/transport/light_sampling.h"

namespace photond {

namespace {

using gpu::LightDepthMap;

constexpr float kLeastConeCosine = 0.5f;  // spots wider than that have cubes
constexpr size_t kRowGrain = 16;

bool has_cube(const PunctualLight& light) {
    return light.kind == PunctualLight::Kind::Point ||
           (light.kind == PunctualLight::Kind::Spot && light.cos_outer < kLeastConeCosine);
}
uint64_t texels_of(const PunctualLight& light, uint32_t resolution) {
    return (has_cube(light) ? 6 : 1) * uint64_t{resolution} * resolution;
}

/// Over all of the scene as the light sees it: from a plane before it.
void cover(LightDepthMap& map, const Bounds3& bounds) {
    const Frame axes(map.axis);
    Bounds3 seen;
    for (int corner = 0; corner < 8; ++corner)
        seen.extend(axes.to_local({(corner & 1 ? bounds.max : bounds.min).x, (corner & 2 ? bounds.max : bounds.min).y,
                                   (corner & 4 ? bounds.max : bounds.min).z}));
    if (bounds.empty()) seen.extend(vec3(0));
    // Past the border and before the first surface by more than rounding.
    const vec3 centre = seen.centre(), greatest = glm::max(glm::abs(seen.min), glm::abs(seen.max));
    const float margin = 1e-3f * seen.radius() + 1e-5f * std::max({greatest.x, greatest.y, greatest.z}) + 1e-30f;
    const vec3 size = seen.diagonal();
    map.half_side = 0.5f * std::max(size.x, size.y) + margin;
    map.origin = axes.to_world({centre.x, centre.y, seen.min.z - margin});
}

LightDepthMap place(const PunctualLight& light, const Bounds3& bounds, uint32_t first_texel) {
    LightDepthMap map{light.position, LIGHT_DEPTH_CUBE, light.direction, 1, first_texel};
    if (light.kind == PunctualLight::Kind::Directional) {
        map.kind = LIGHT_DEPTH_PARALLEL;
        cover(map, bounds);
    } else if (!has_cube(light)) {
        map.kind = LIGHT_DEPTH_CONE;
        const float cosine = std::min(light.cos_outer, 1.0f);
        map.half_side = std::max(std::sqrt((1 - cosine) * (1 + cosine)) / cosine, 1e-4f);
    }
    return map;
}

/// Where in a map: texels from its corner, and the face of a cube.
struct Place {
    vec2 texel;
    uint32_t face;
};

/// A vector as face `face` has it: along its axis first. Faces 2 a and 2 a + 1 look along +a and -a.
vec3 to_face(const vec3& v, uint32_t face) {
    return face < 2 ? v : face < 4 ? vec3(v.y, v.z, v.x) : vec3(v.z, v.x, v.y);
}
vec3 from_face(const vec3& v, uint32_t face) {
    return face < 2 ? v : face < 4 ? vec3(v.z, v.x, v.y) : vec3(v.y, v.z, v.x);
}
uint32_t face_of(const vec3& v) {
    const vec3 size = glm::abs(v);
    const uint32_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return 2 * axis + (v[static_cast<int>(axis)] < 0 ? 1 : 0);
}

Place place_on_cube(const vec3& to_point, float texels_per_unit) {
    const uint32_t face = face_of(to_point);
    const vec3 v = to_face(to_point, face);
    return {(vec2(v.y, v.z) / std::fabs(v.x) + 1.0f) * texels_per_unit, face};
}

/// The whole texel within the map; what is no number is at its corner.
uint32_t texel_number(float texel, uint32_t resolution) {
    return texel > 0 ? static_cast<uint32_t>(std::min(texel, static_cast<float>(resolution - 1))) : 0;
}

/// The ray through the centre of a map's texel.
Ray texel_ray(const LightDepthMap& map, uint32_t resolution, uint32_t texel) {
    const uint32_t of_face = texel % (resolution * resolution);
    const vec2 across = (vec2(of_face % resolution, of_face / resolution) + 0.5f) *
                            (2 * map.half_side / static_cast<float>(resolution)) -
                        map.half_side;
    if (map.kind == LIGHT_DEPTH_CUBE) {
        const uint32_t face = texel / (resolution * resolution);
        const vec3 direction = from_face({face % 2 == 1 ? -1.0f : 1.0f, across.x, across.y}, face);
        return {map.origin, glm::normalize(direction)};
    }
    const Frame axes(map.axis);
    if (map.kind == LIGHT_DEPTH_PARALLEL)
        return {map.origin + across.x * axes.tangent + across.y * axes.bitangent, map.axis};
    return {map.origin, glm::normalize(map.axis + across.x * axes.tangent + across.y * axes.bitangent)};
}

/// A texel of the square about the point's place, and a texel's width at the point.
struct Tap {
    uint32_t texel;
    float width_m;
};

Tap choose_texel(const LightDepthMap& map, const gpu::LightDepthConstants& constants, const vec3& position,
                 const vec2& u) {
    const uint32_t resolution = constants.resolution;
    const float texels_per_unit = 0.5f * static_cast<float>(resolution) / map.half_side;
    const vec2 aside = (u - 0.5f) * constants.pcf;
    const vec3 from_origin = position - map.origin;
    Place place{};
    float distance = 1;  // of the plane of the map's texels through the point
    if (map.kind == LIGHT_DEPTH_CUBE) {
        const float size = static_cast<float>(resolution);
        place = place_on_cube(from_origin, texels_per_unit);
        place.texel += aside;
        if (!(place.texel.x >= 0 && place.texel.x < size && place.texel.y >= 0 && place.texel.y < size)) {
            const vec2 across = place.texel / texels_per_unit - 1.0f;
            place = place_on_cube(from_face({place.face % 2 == 1 ? -1.0f : 1.0f, across.x, across.y}, place.face),
                                  texels_per_unit);
        }
        distance = std::max({std::fabs(from_origin.x), std::fabs(from_origin.y), std::fabs(from_origin.z)});
    } else {
        const vec3 local = Frame(map.axis).to_local(from_origin);
        if (map.kind == LIGHT_DEPTH_CONE) distance = local.z;
        place.texel = (vec2(local) / distance + map.half_side) * texels_per_unit + aside;
    }
    return {(place.face * resolution + texel_number(place.texel.y, resolution)) * resolution +
                texel_number(place.texel.x, resolution),
            distance / texels_per_unit};
}

}  // namespace

LightDepthLayout::LightDepthLayout(const Scene& scene, uint32_t resolution, uint32_t pcf)
    : constants{.resolution = resolution,
                .pcf = static_cast<float>(pcf),
                .first_source = light_source_of_punctual(scene, 0),
                .maps = static_cast<uint32_t>(scene.punctual_lights.size())} {
    uint64_t first = 0;
    for (const PunctualLight& light : scene.punctual_lights) {
        maps.push_back(place(light, scene.bounds, static_cast<uint32_t>(first)));
        first += texels_of(light, resolution);
        if (first > UINT32_MAX)
            throw Error(ErrorCode::Unsupported, "direct_resolution",
                        "shadow maps of " + std::to_string(scene.punctual_lights.size()) + " lights with " +
                            std::to_string(resolution) + " texels a side have more than 2^32 texels");
    }
    texels = static_cast<uint32_t>(first);
}

LightDepthMaps::LightDepthMaps(const Scene& scene, const Intersector& intersector, uint32_t resolution, uint32_t pcf,
                               Stats& stats)
    : layout_(scene, resolution, pcf), depths_m_(layout_.texels) {
    assert(resolution >= kLeastResolution && resolution <= kMostResolution && pcf <= kMostPcf);
    const StageTimer timer(stats, "shadow_maps");
    std::vector<uint32_t> map_of_row;  // maps have whole rows
    for (uint32_t i = 0; i < layout_.maps.size(); ++i)
        map_of_row.resize(map_of_row.size() + texels_of(scene.punctual_lights[i], resolution) / resolution, i);
    parallel_for(map_of_row.size(), kRowGrain, [&](size_t row) {
        const LightDepthMap& map = layout_.maps[map_of_row[row]];
        const auto first = static_cast<uint32_t>(row * resolution);
        std::vector<Ray> rays;
        std::vector<Hit> hits(resolution);
        rays.reserve(resolution);
        for (uint32_t i = 0; i < resolution; ++i)
            rays.push_back(texel_ray(map, resolution, first + i - map.first_texel));
        intersector.closest_hits(rays, hits, Coherence::Coherent);
        for (uint32_t i = 0; i < resolution; ++i) depths_m_[first + i] = hits[i].t;
    });
    stats.counts.shadow_rays += depths_m_.size();
}

LightSeen LightDepthMaps::seen(uint32_t source, const vec3& position, const vec3& normal, const vec2& u) const {
    const uint32_t light = source - layout_.constants.first_source;  // wraps past all maps for sources before
    if (light >= layout_.maps.size()) return LightSeen::Unknown;
    const LightDepthMap& map = layout_.maps[light];
    const Tap tap = choose_texel(map, layout_.constants, position, u);
    const Ray ray = texel_ray(map, layout_.constants.resolution, tap.texel);
    const vec3 to_point = position - ray.origin;
    const float along = glm::dot(to_point, ray.direction);
    const float across = glm::length(to_point - along * ray.direction),
                farthest = along + LIGHT_DEPTH_MOST_SLOPE * across;
    const float plane = glm::dot(to_point, normal) / glm::dot(ray.direction, normal);
    const float limit =
        (plane > 0 && plane < farthest ? plane : farthest) - tap.width_m - LIGHT_DEPTH_CONCAVE_SLOPE * across;
    return depths_m_[map.first_texel + tap.texel] >= limit ? LightSeen::Whole : LightSeen::Nothing;
}

vec2 LightDepthMaps::tap_number(const vec3& position, uint32_t source, uint32_t pass_key) {
    uint32_t bits[3];
    __builtin_memcpy(bits, &position.x, sizeof bits);
    const uint32_t x = hash32(hash32(hash32(hash32(bits[0]) ^ bits[1]) ^ bits[2]) ^ hash32(source ^ pass_key));
    return {to_unit_float(x), to_unit_float(hash32(x ^ 0x9e3779b9u))};
}

uint64_t LightDepthMaps::bytes() const {
    return depths_m_.size() * sizeof(float) + layout_.maps.size() * sizeof(LightDepthMap);
}

uint64_t LightDepthMaps::bytes_for(const Scene& scene, uint32_t resolution) {
    uint64_t bytes = 0;
    for (const PunctualLight& light : scene.punctual_lights)
        bytes += texels_of(light, resolution) * sizeof(float) + sizeof(LightDepthMap);
    return bytes;
}

}  // namespace photond
