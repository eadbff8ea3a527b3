#version 460
// Photons scattered over the pixels of a block, a group a block, a thread a pixel. The group's threads test as many
// batches at once against the block's bounds, then the photons of those that may reach it; those that do wait in shared
// memory, in their order, and are gone through by all threads together. So nothing is written down of which photon
// reaches which pixel, and every sum is taken in the order of the photons: the same bits each time.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/photons/kernel.glsl"
#include "renderer/photons/photon.glsl"

layout(constant_id = FOOTPRINT_VOLUME_ID) const bool FOOTPRINT_VOLUME = false;
layout(constant_id = DISC_COVERAGE_ID) const bool DISC_COVERAGE = false;

layout(local_size_x = SCATTER_GROUP) in;
layout(push_constant, scalar) uniform Push { PhotonScatterPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 4, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 5, std430) readonly buffer MapPowers { uvec4 map_powers[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Batches { PhotonBatch batches[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { vec3 sums[]; };

#define BOX_GROUP SCATTER_GROUP
#include "renderer/methods/image_space_photon_mapping/box_of_group.glsl"
shared uint found[2];               // a bit a thread
shared uint near[SCATTER_GROUP];    // batches that may reach the block
shared uint queue[SCATTER_GROUP];   // photons of one that do

#define COVERAGE constants.coverage
#define EDGE_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/disc_coverage.glsl"
#define SUB_POINTS points
#include "renderer/methods/image_space_photon_mapping/upsampling.glsl"

/// Of the threads that `wanted` holds for, how many in all; `place`: this one's among them.
uint number_of_wanted(bool wanted, out uint place) {
    const uint thread = gl_LocalInvocationIndex;
    if (thread < 2) found[thread] = 0;
    barrier();
    if (wanted) atomicOr(found[thread / 32], 1u << thread % 32);
    barrier();
    const uvec2 mask = uvec2(found[0], found[1]);
    const uint below = (1u << thread % 32) - 1u;
    place = thread < 32 ? bitCount(mask.x & below) : bitCount(mask.x) + bitCount(mask.y & below);
    barrier();
    return bitCount(mask.x) + bitCount(mask.y);
}

/// What light a photon brings to a point, of its power: of Lambert points irradiance, of others radiance. `wi`: towards
/// where it came from; `cos_p`: between that and the normal of the surface it lies on; `side`: between the normals.
vec3 light_of(GBufferPoint point, Receiver receiver, vec3 wi, float cos_p, float side) {
    // A photon of a curved surface's next facet may have come from below this one's horizon.
    if ((dot(wi, point.geometric_normal) > 0.0) != (side > 0.0)) return vec3(0.0);
    const float share = 1.0 / max(abs(cos_p), DISC_LEAST_COSINE);
    if (is_general(point))
        return share * bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, wi));
    if (point.normal == vec3(0.0)) return vec3(1.0);
    return vec3(point.normal == point.geometric_normal ? 1.0 : share * max(dot(point.normal, wi), 0.0));
}

/// A pixel, and what light can reach of the disc about it.
struct LitPixel {
    GBufferPoint point;
    Receiver receiver;
    bool cut;  // the disc may hang over an edge, or reach behind a wall
    DiscProbe probe;
};

void add_photon(uint photon, HashGridConstants map, float radius_m, LitPixel pixel, inout vec3 sum) {
    const GBufferPoint point = pixel.point;
    const Receiver receiver = pixel.receiver;
    const uvec4 place = grid_places[map.first_point + photon];
    const vec3 offset = point.position - uintBitsToFloat(place.xyz);
    const float distance_sq = dot(offset, offset), radius_sq = radius_m * radius_m;
    if (!(distance_sq < radius_sq)) return;
    if (photon_scatterings(place.w) > (point.kind & GBUFFER_SCATTERINGS)) return;
    const vec3 normal = photon_normal(place.w);
    const float height_m = dot(normal, offset);
    float q_sq = distance_sq / radius_sq;
    if (FOOTPRINT_VOLUME) {
        q_sq += (1.0 / sqr(VOLUME_HEIGHT) - 1.0) * sqr(height_m) / radius_sq;
        if (!(q_sq < 1.0)) return;
    } else if (abs(height_m) > QUAD_HEIGHT * radius_m) {
        return;
    }
    // The weight of agreement: both normals are of facets, so that it tends to 1 as footprints shrink.
    const float side = dot(normal, point.geometric_normal);
    const bool both_sides = is_general(point) ? bsdf_has_non_delta_transmission(receiver.rough)
                                              : point.normal == vec3(0.0);
    if (side <= 0.0 && !both_sides) return;
    if (DISC_COVERAGE && pixel.cut &&
        (abs(side) < DISC_COSINE || !disc_sees(pixel.probe, uintBitsToFloat(place.xyz))))
        return;
    const uvec4 power = map_powers[map.first_point + photon];
    const vec3 wi = photon_direction(power.w);
    const float weight = abs(side) * kernel_evaluate(constants.kernel, q_sq) / radius_sq;
    sum += weight * uintBitsToFloat(power.xyz) * light_of(point, receiver, wi, dot(wi, normal), side);
}

void main() {
    const uint block = push.first_block + flat_index() / SCATTER_GROUP;
    if (block >= push.end_block) return;
    const uint thread = gl_LocalInvocationIndex;
    const SplitRecord split = constants.split;
    // Blocks of a tile of the split buffer, whose pixels lie a sub-sample apart.
    const uint columns = (split.tile_width + SCATTER_BLOCK_SIDE - 1) / SCATTER_BLOCK_SIDE;
    const uint rows = (split.tile_height + SCATTER_BLOCK_SIDE - 1) / SCATTER_BLOCK_SIDE;
    const uint tile = block / (columns * rows), in_tile = block % (columns * rows);
    const uint column = in_tile % columns * SCATTER_BLOCK_SIDE + thread % SCATTER_BLOCK_SIDE;
    const uint row = in_tile / columns * SCATTER_BLOCK_SIDE + thread / SCATTER_BLOCK_SIDE;
    const uint x = column * split.side + tile % split.side, y = row * split.side + tile / split.side;
    const bool in_image = x < split.width && y < split.height;
    const uint index = in_image ? split_point_of(split, x, y) : 0;
    LitPixel pixel;
    pixel.point = points[index];
    const GBufferPoint point = pixel.point;
    const bool lit = in_image && lights_itself(split, x, y, point, constants.radius_m);
    if (lit && is_general(point)) pixel.receiver = make_receiver(general_points[index], constants.glossy_threshold);

    const HashGridConstants map = constants.maps[push.map];
    const float radius_m = constants.radius_m;
    vec3 block_low = lit ? point.position - radius_m : vec3(INFINITY);
    vec3 block_high = lit ? point.position + radius_m : vec3(-INFINITY);
    box_of_group(block_low, block_high);
    if (!(block_low.x <= block_high.x)) return;  // none of its pixels is lit
    pixel.cut = DISC_COVERAGE && lit && has_edges(point.position, radius_m);
    DiscMass mass = DiscMass(1.0, false);
    if (pixel.cut) {
        pixel.probe = probe_disc(
            CoverageDisc(point.position, point.geometric_normal, radius_m, QUAD_HEIGHT * radius_m));
        mass = disc_mass(constants.kernel, pixel.probe, hash32(point.pixel ^ constants.turn), DISC_COARSE_BATCH);
    }

    const uint photons = min(grid_starts[map.first_start + map.slots], map.capacity);
    const uint batches_of_pass = min((photons + SCATTER_GROUP - 1) / SCATTER_GROUP, push.batches);
    vec3 sum = vec3(0.0);
    for (uint first = 0; first < batches_of_pass; first += SCATTER_GROUP) {
        bool may_reach = false;
        if (first + thread < batches_of_pass) {
            const PhotonBatch batch = batches[constants.first_batch[push.map] + first + thread];
            may_reach = all(lessThanEqual(batch.low, block_high)) && all(lessThanEqual(block_low, batch.high));
        }
        uint place;
        const uint batches_near = number_of_wanted(may_reach, place);
        if (may_reach) near[place] = first + thread;
        barrier();
        for (uint i = 0; i < batches_near; ++i) {
            const uint photon = near[i] * SCATTER_GROUP + thread;
            bool reaches = false;
            if (photon < photons) {
                const vec3 position = uintBitsToFloat(grid_places[map.first_point + photon].xyz);
                reaches = all(lessThanEqual(position, block_high)) && all(lessThanEqual(block_low, position));
            }
            const uint waiting = number_of_wanted(reaches, place);
            if (reaches) queue[place] = photon;
            barrier();
            if (lit)
                for (uint k = 0; k < waiting; ++k) add_photon(queue[k], map, radius_m, pixel, sum);
            barrier();
        }
        barrier();
    }
    if (lit) sums[index] += mass.inverse * sum;
}
