// The lights of a scene on the device, as make_light_tables() (light_tables.h) lays them out. For both compilers;
// scalar layout.
#ifndef PHOTOND_LIGHT_TABLES_SHARED_H
#define PHOTOND_LIGHT_TABLES_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"
namespace photond::gpu {
using uint = uint32_t;
#endif

// EmitterRecord::kind: a shape and flags.
#define EMITTER_TRIANGLE 0u
#define EMITTER_PARALLELOGRAM 1u
#define EMITTER_POINT 2u
#define EMITTER_SPOT 3u
#define EMITTER_SHAPE 3u      // mask
#define EMITTER_TWO_SIDED 4u  // flag
#define EMITTER_VARIES 8u     // flag

#define NO_EMITTER 0xffffffffu

#define LIGHT_SAMPLES_COMPENSATED_ID 59  // specialisation constant: by EnvironmentDensity::Compensated

/// As photond::Emitter.
struct EmitterRecord {
    vec3 corner;
    uint kind;
    vec3 edge1;
    uint instance;
    vec3 edge2;
    uint triangle;
    vec3 normal;
    float area_m2;
    vec3 radiance;
    float emission_per_m2;  // with which light paths start there: LightEnds::emission_per_m2()
};

// LightNodeRecord::link: what a node is and where it leads.
#define LIGHT_NODE_LEAF 0x80000000u
#define LIGHT_NODE_TWO_SIDED 0x40000000u
#define LIGHT_NODE_INDEX 0x3fffffffu  // mask: the right child, or the emitter of a leaf; the left child comes next

/// As LightTree::Node.
struct LightNodeRecord {
    vec3 centre;
    float radius;
    vec3 axis;
    float cos_cone;
    float sin_cone;
    float cos_emission;
    float intensity;
    uint link;
};

// Two words an emitter: the low 32 bits of LightTree::Leaf::path; its other 24, and above them the depth.
#define LEAF_DEPTH_SHIFT 24
#define LEAF_NO_DEPTH 0xffu

#define PUNCTUAL_POINT 0u
#define PUNCTUAL_SPOT 1u
#define PUNCTUAL_DIRECTIONAL 2u

/// As photond::PunctualLight, with what SpotCone makes of it.
struct PunctualLightRecord {
    vec3 intensity;
    uint kind;
    vec3 position;
    float range_m;  // infinite: none
    vec3 direction;
    float cos_outer;
    float inverse_width;  // of a spot's ramp, in the cosine
    float plateau;        // SpotCone::Shares; 0 for all but spots
    float ramp;
    float reach;  // width of the ramp that is left before the axis, in the cosine
};

/// Where everything is in the arrays of words (uint) and floats, and what there is one of.
struct LightConstants {
    // LIGHT_WORDS
    uint leaves;             // of emitters, two words each
    uint first_of_instance;  // LightSampler's
    uint emitter_of_triangle;
    uint directional;          // indices of punctual lights
    uint emitter_of_punctual;  // NO_EMITTER for the directional ones
    uint choice_guide;
    // LIGHT_FLOATS
    uint choice_cdf;
    uint row_cdf;              // EnvironmentSampler's
    uint column_cdf;           // height rows of width + 1
    uint row_edges;            // EnvironmentSampler::row_edge(), height + 1
    uint compensated_row_cdf;  // the same two by EnvironmentDensity::Compensated
    uint compensated_column_cdf;

    uint nodes;  // 0: no emitter
    uint directional_lights;
    uint choice_guides;  // intervals of the guide; 0: nothing can be chosen
    uint triangle_lights;
    uint first_triangle_light;  // Scene::triangle_lights one by one, without parallelograms: where in EMITTERS
    uint punctual_lights;
    uint instances;
    uint environment_width;
    uint environment_height;
    float environment_scale;
    float environment_rotation;
    float environment_mean_radiance;
    vec3 centre;  // of the scene's bounding sphere
    float radius_m;
};

#ifdef __cplusplus
static_assert(sizeof(EmitterRecord) == 80 && sizeof(LightNodeRecord) == 48 && sizeof(PunctualLightRecord) == 64 &&
                  sizeof(LightConstants) == 112,
              "scalar layout has no padding");
}  // namespace photond::gpu
#endif

#endif
