// What the bidirectional methods' shaders are told, and what they keep of paths: for both compilers.
#ifndef PHOTOND_BIDIRECTIONAL_SHARED_H
#define PHOTOND_BIDIRECTIONAL_SHARED_H

#include "renderer/bidirectional/mis_weights_shared.h"
#include "renderer/eye/path_wavefront_shared.h"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/hash_grid_shared.h"
#include "renderer/transport/sobol_shared.h"

#define LIGHT_PATHS_GROUP 64  // threads

/// Places on the lens have independent numbers, a set a vertex.
#define FIRST_LENS_SET 0x40000000u

/// Of the radius: how far from the disc vertices lie that are merged.
#define MERGE_MOST_HEIGHT 0.25f

/// How much merging counts for near an edge, beside what it would elsewhere. Discs are clipped there, which lets all
/// their light through but has noise, and bias, of its own: where the path can be made otherwise, it rather is.
#define MERGE_EDGE_SHARE 0.1f

// Elements of a SequenceSampler's run, whose paths the CPU traces together: SequenceSampler::kRun.
#define LIGHT_RUN_BITS 10

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// LightVertex of light_paths.h.
struct LightVertexRecord {
    vec3 position;
    uint instance;
    vec3 normal;
    uint triangle;
    vec3 from;
    float outside_ior;
    vec3 power_w;
    float acceptance;
    SubpathWeights weights;
    float u;
    float v;
    uint surfaces;  // and LIGHT_VERTEX_ALL_DELTA
};
#define LIGHT_VERTEX_ALL_DELTA 0x80000000u

/// LightSplat, but for where in the film it is.
struct LightSplatRecord {
    vec3 radiance;
    uint scatterings;  // and LIGHT_SPLAT_CAUSTIC
};
#define LIGHT_SPLAT_CAUSTIC 0x80000000u

/// PassTechniques, and where what it needs lies.
struct BidirectionalConstants {
    uint64_t join_salt;  // of the pass
    TechniqueNumbers numbers;
    uint light_paths;
    uint connections_per_vertex;
    uint own_path;  // 0 or 1
    float merge_radius_m;
    float edge_radius_m;
    // In the tables over the light's vertices, whose first word is the number of those: the edges of surfaces, the
    // grid's starts where they merge, and with own_path where each path's vertices begin in their order.
    DiscCoverageConstants edges;
    HashGridConstants vertex_grid;
    uint first_of_paths;
    uint capacity;  // vertices there is room for
};

struct LightPathsPush {
    SequenceKey sequence;
    uint64_t first_element;  // of the sequence: that of the pass's path 0
    uint first_path;         // of the paths traced here, half open
    uint end_path;
    uint surface_bits;  // of a vertex's key; 0: keys are the paths' numbers
    uint threads;
};

struct LightImagePush {
    uint columns;  // of the grid that splats are sorted into, which begins that many pixels before the image
    uint margin;
    vec3 techniques;  // shown_techniques(), the same for all pixels
};

/// Words of the light paths' state.
#define LIGHT_VERTICES_WORD 0   // of the pass, those without room included
#define LIGHT_NEXT_PATH_WORD 1  // of a dispatch: paths that a thread took after its first
#define LIGHT_RAYS_WORD 2       // of the pass: 64 bits, low first
#define LIGHT_SHADOW_RAYS_WORD 4
#define LIGHT_STATE_WORDS 6

/// A surface vertex of a path from the eye that waits to be joined with light paths.
struct JoinState {
    PathState path;  // as it arrived; the direction is that of the ray that met the surface
    SubpathWeights weights;
    uint instance;
    uint triangle;
    float u;
    float v;
    float outside_ior;
    float acceptance;
};

#ifdef __cplusplus
static_assert(sizeof(LightVertexRecord) == 96 && sizeof(LightSplatRecord) == 16 &&
              sizeof(BidirectionalConstants) == 44 + 16 + 60 + 8 && sizeof(LightPathsPush) == 40 &&
              sizeof(JoinState) == 140);
}  // namespace photond::gpu
#endif

#endif
