#version 460
// What photons were drawn over the pixels, to their sums, a thread a pixel that is drawn over.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 5
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/backends/gpu/scene.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/photons/kernel.glsl"

layout(constant_id = DISC_COVERAGE_ID) const bool DISC_COVERAGE = false;

layout(local_size_x = SCATTER_GROUP) in;
layout(push_constant, scalar) uniform Push { PhotonRasterPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 3, scalar) readonly buffer LightAndPhotons { vec4 light_and_photons[]; };
layout(set = 0, binding = 4, scalar) buffer Sums { vec3 sums[]; };
#define FOOTPRINTS constants
#define COVERAGE constants.coverage
#define EDGE_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/disc_coverage.glsl"
#define SUB_POINTS points
#include "renderer/gbuffer/upsampling.glsl"
#include "renderer/methods/image_space_photon_mapping/drawn_pixels.glsl"

void main() {
    const SplitRecord split = constants.split;
    const uint thread = flat_index();
    if (thread >= split.tile_width * split.tile_height) return;
    const uint x = thread % split.tile_width * split.side + sub_sample_offset(split);
    const uint y = thread / split.tile_width * split.side + sub_sample_offset(split);
    if (x >= split.width || y >= split.height) return;
    const uint index = split_point_of(split, x, y);
    if (!is_drawn(x, y, points[index], constants.radius_of_map_m[push.map])) return;
    const vec4 drawn = light_and_photons[thread];
    sums[index] += drawn.rgb;
    if (layer_kept(LAYER_OVERLAP)) {
        const uint pixel = y * split.width + x;
        store_value(LAYER_OVERLAP, pixel, load_value(LAYER_OVERLAP, pixel) + drawn.a);
    }
}
