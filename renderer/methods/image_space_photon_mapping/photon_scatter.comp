#version 460
// Photons scattered over the pixels of a block, a group a block, a thread a pixel. The group's threads test as many
// batches at once against the block's bounds, then the photons of those that may reach it; those that do wait in shared
// memory, in their order, and are gone through by all threads together. So nothing is written down of which photon
// reaches which pixel, and every sum is taken in the order of the photons: the same bits each time.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 8
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"

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
#include "renderer/splats/box_of_group.glsl"
shared uint found[2];               // a bit a thread
shared uint near[SCATTER_GROUP];    // batches that may reach the block
shared uint queue[SCATTER_GROUP];   // photons of one that do

#define FOOTPRINTS constants
#define FOOTPRINT_RADIUS_M constants.radius_of_map_m[push.map]
#include "renderer/methods/image_space_photon_mapping/photon_light.glsl"
#define COVERAGE constants.coverage
#define EDGE_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/disc_coverage.glsl"
#define SUB_POINTS points
#include "renderer/gbuffer/upsampling.glsl"
#include "renderer/methods/image_space_photon_mapping/drawn_pixels.glsl"

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

/// A pixel, and what light can reach of the disc about it.
struct LitPixel {
    GBufferPoint point;
    Receiver receiver;
    bool cut;  // the disc may hang over an edge, or reach behind a wall
    DiscProbe probe;
};

void add_photon(uint photon, HashGridConstants map, LitPixel pixel, inout vec3 sum, inout uint photons) {
    const uvec4 place = grid_places[map.first_point + photon];
    FootprintHit hit;
    if (!reaches_point(place, pixel.point, pixel.receiver, pixel.cut, hit)) return;
    if (DISC_COVERAGE && pixel.cut &&
        (abs(hit.side) < DISC_COSINE || !disc_sees(pixel.probe, uintBitsToFloat(place.xyz))))
        return;
    sum += photon_light(map_powers[map.first_point + photon], pixel.point, pixel.receiver, hit);
    ++photons;
}

/// Blocks of sub-samples come first, then those of the pixels as the image has them, but for the sub-samples: pixels of a
/// block are near one another. False: the thread's pixel is another block's.
bool pixel_of_block(uint block, uint thread, out uint x, out uint y) {
    const SplitRecord split = constants.split;
    const bool few = split.side > 1u;
    const uint side = SCATTER_BLOCK_SIDE, column = thread % side, row = thread / side;
    const uint columns = (split.tile_width + side - 1) / side, rows = (split.tile_height + side - 1) / side;
    if (few && block < columns * rows) {
        x = (block % columns * side + column) * split.side + sub_sample_offset(split);
        y = (block / columns * side + row) * split.side + sub_sample_offset(split);
        return true;
    }
    if (few) block -= columns * rows;
    const uint image_columns = (split.width + side - 1) / side;
    x = block % image_columns * side + column;
    y = block / image_columns * side + row;
    return !few || !is_sub_sample(split, x, y);
}

void main() {
    const uint block = push.first_block + flat_index() / SCATTER_GROUP;
    if (block >= push.end_block) return;
    const uint thread = gl_LocalInvocationIndex;
    const SplitRecord split = constants.split;
    uint x, y;
    const bool in_order = pixel_of_block(block, thread, x, y);
    const bool in_image = in_order && x < split.width && y < split.height;
    const uint index = in_image ? split_point_of(split, x, y) : 0;
    LitPixel pixel;
    pixel.point = points[index];
    const GBufferPoint point = pixel.point;
    const bool lit = in_image && lights_itself(split, x, y, point, QUAD_HEIGHT * constants.radius_m) &&
                     !is_drawn(x, y, point, FOOTPRINT_RADIUS_M);
    if (lit && is_general(point)) pixel.receiver = make_receiver(general_points[index], constants.glossy_threshold);

    const HashGridConstants map = constants.maps[push.map];
    const float radius_m = FOOTPRINT_RADIUS_M;
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
    uint lit_by = 0;
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
                for (uint k = 0; k < waiting; ++k) add_photon(queue[k], map, pixel, sum, lit_by);
            barrier();
        }
        barrier();
    }
    if (!lit) return;
    sums[index] += mass.inverse * sum;
    if (layer_kept(LAYER_OVERLAP)) {
        const uint pixel_number = y * split.width + x;
        store_value(LAYER_OVERLAP, pixel_number, load_value(LAYER_OVERLAP, pixel_number) + float(lit_by));
    }
}
