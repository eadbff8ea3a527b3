#version 460
// Paths that fill the cache, a thread a path: their first vertices past the first surface leave records, which the end of
// the path turns into samples.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/radiance_cache/cached_paths.glsl"
#include "renderer/photons/photon.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { CacheTrainPush push; };
layout(set = 0, binding = 8, scalar) readonly buffer Tiles { uint tiles[]; };
layout(set = 0, binding = 9, scalar) buffer Records { CacheRecord records[]; };
layout(set = 0, binding = 10, scalar) writeonly buffer RecordCounts { uint record_counts[]; };

uint shadow_rays = 0, first_record, record_count = 0;

/// What has come along the path since the last record, and by how much it counts there.
vec3 arrived(PathLight light) { return light.emitted + light.direct + light.indirect; }

void end_stretch(inout EyePath path, inout PathLight light) {
    if (record_count > 0u) {
        records[first_record + record_count - 1u].arrives = arrived(light);
        records[first_record + record_count - 1u].link = path.throughput;
    }
    light = no_light();
    path.throughput = vec3(1.0);
}

void begin_record(ShadingPoint surface, Bsdf rough, uint direction, uint level, float spread_m, uint random) {
    const vec3 albedo = bsdf_albedo(rough);
    CacheRecord record;
    record.position = surface.position;
    record.normal = octahedral_encode(16u, surface.shading.normal);
    record.level_and_direction = level | direction << 5;
    record.spread_m = spread_m;
    record.random = hash32(random ^ 0x68bc21ebu);
    record.inverse_albedo = mix(vec3(0.0), 1.0 / max(albedo, vec3(1e-37)), greaterThan(albedo, vec3(0.0)));
    record.own_rough = record.own = record.through_rough = record.weight = vec3(0.0);
    record.arrives = record.link = vec3(0.0);
    records[first_record + record_count++] = record;
}

/// A vertex of the path. False: it ends.
bool step_path(uint vertex, uint key, inout float spread_m, inout EyePath path, inout Ray ray, inout PathLight light) {
    const Hit hit = closest_hit(ray);
    if (!arrive(path, hit, ray, light)) return false;
    EyeVertex met;
    met.surface = make_shading_point(hit, ray.direction);
    if (NEEDS_UNLIT && has_flag(scene_materials[met.surface.material].flags, MATERIAL_UNLIT)) return false;
    if (is_emissive(met.surface.material)) add_emission(light, path, hit, met.surface.front_side, ray.direction);
    if (!open_surface(path, ray, light, met)) return false;
    if (path.scatterings > 0u) spread_m += spread_of_ray(path, hit.t);
    Bsdf bsdf = met.bsdf;
    const Bsdf rough = bsdf_is_lambert(bsdf) ? bsdf : bsdf_rough_part(bsdf, cache.glossy_threshold);
    bool keeps_sample = false;
    uint level;
    if (bsdf_scatters(rough) && keeps_samples_at(path) &&
        cell_level(distance(met.surface.position, cache.eye), spread_m, level)) {
        const uint random = hash32(key ^ hash32(cache.key ^ vertex)), direction = cell_direction(rough, -ray.direction);
        vec3 known;
        if (push.ends_in_cells != 0u && ask_cells(met.surface, direction, level, spread_m, random, known)) {
            light.indirect += path.throughput * bsdf_albedo(rough) * known;
            if (bsdf_is_lambert(bsdf)) return false;
            bsdf = bsdf_specular_part(bsdf, cache.glossy_threshold);
            if (!bsdf_scatters(bsdf)) return false;
        } else if (record_count < CACHE_MOST_RECORDS) {
            end_stretch(path, light);
            begin_record(met.surface, rough, direction, level, spread_m, random);
            keeps_sample = true;
        }
    }
    const uint record = first_record + record_count - 1u;
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    if (record_count > 0u) {  // else nobody wants it
        const VertexLight lit = light_at_vertex(path, met, bsdf, key, vertex, choice.x, shadow_rays);
        const vec3 own = lit.wanted ? lit.arrives * bsdf_f_cos(bsdf, met.wo, lit.wi) : vec3(0.0);
        if (keeps_sample) {
            records[record].own = own;
            if (lit.wanted) records[record].own_rough = lit.arrives * bsdf_f_cos(rough, met.wo, lit.wi);
        } else {
            light.indirect += path.throughput * own;
        }
    }
    const BsdfSample next = next_of_vertex(met, bsdf, key, vertex);
    const bool on = leave_surface(path, met.surface, next, vertex + 1u >= eye.roulette_start, choice.y, light, ray);
    if (on && keeps_sample) {
        const float rarer = max_component(path.throughput) / max_component(next.weight);  // by roulette
        records[record].weight = path.throughput;
        if (!next.delta) records[record].through_rough = rarer / next.pdf_sa * bsdf_f_cos(rough, met.wo, next.wi);
        path.throughput = vec3(1.0);
    }
    return on;
}

/// From the last record to the first: what arrives at each.
void make_samples() {
    vec3 sent = vec3(0.0);  // by the record after
    float brightest = 0.0;
    uint kept = record_count;
    for (uint i = record_count; i-- > 0u;) {
        const CacheRecord record = records[first_record + i];
        const vec3 arrives = record.arrives + record.link * sent;
        sent = record.own + record.weight * arrives;
        const vec3 radiance = (record.own_rough + record.through_rough * arrives) * record.inverse_albedo;
        if (!is_finite(radiance)) kept = i;  // nor those before it, to which it was to add
        records[first_record + i].own_rough = radiance;
        if (is_finite(radiance)) brightest = max(brightest, max_component(radiance));
    }
    record_counts[first_record / CACHE_MOST_RECORDS] = kept;
    brightest = subgroupMax(brightest);
    if (subgroupElect() && brightest > 0.0) atomicMax(cache_state[CACHE_FOUND], floatBitsToUint(brightest));
}

void main() {
    const uint place = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    if (place >= push.end_tile) return;
    const uint path_index = (place - push.first_tile) * EYE_TILE * EYE_TILE + gl_LocalInvocationIndex;
    first_record = CACHE_MOST_RECORDS * path_index;
    EyePath path;
    Ray ray;
    uint key, vertex = 0;
    if (start_eye_path(tiles[place], tiles[place] + 1u, gl_LocalInvocationIndex, path, ray, key)) {
        PathLight light = no_light();
        float spread_m = 0.0;
        while (step_path(vertex, key, spread_m, path, ray, light)) ++vertex;
        end_stretch(path, light);
        if (record_count > 0u) records[first_record + record_count - 1u].link = vec3(0.0);
    }
    make_samples();
    count(COUNTER_CAMERA_RAYS, 1);
    count(COUNTER_BOUNCE_RAYS, vertex);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}
