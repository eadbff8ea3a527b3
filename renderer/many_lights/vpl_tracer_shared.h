// What the shaders of VplTracerGpu are told, for both compilers.
#ifndef PHOTOND_VPL_TRACER_SHARED_H
#define PHOTOND_VPL_TRACER_SHARED_H

#ifndef __cplusplus
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#include "renderer/transport/sobol_shared.h"
#ifdef __cplusplus
#include "renderer/core/geometry.h"
#endif

#define VPL_GROUP 64  // threads

// Bindings of set 0 that a shader with a function of its own for hits after the first may use: from here on.
#define VPL_BOUNCE_BINDING 16

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// Of vpl_texels.comp.
struct VplTexelsPush {
    SequenceKey sequence;
    uint texels;       // of the map
    uint used_texels;  // those that belong to a light
    uint runs;
    uint bounces;
    float connect_threshold;
    uint unused;  // the compilers differ in whether they would leave room here
};

/// Of vpl_mix.comp.
struct VplMixPush {
    uint levels;        // of the map
    float plain_share;  // kPlainFluxShare
};

/// Of vpl_points.comp.
struct VplPointsPush {
    uint paths;
    uint rotation_x;
    uint rotation_y;
};

/// Of vpl_choose.comp.
struct VplChoosePush {
    uint paths;   // at most
    uint levels;  // of the map
};

/// A light path by its numbers.
struct VplPath {
    uint point_x;  // of the unit square, in fractions of 2^32: what chooses its texel
    uint point_y;
    uint element;  // of the sequence that its numbers after the first ray are of
    float weight;  // on the power that it has as one of the pass's
    float choice;  // its lights' (vpl_shared.h)
};

/// The first step of a path, with its share of the power; black: it carries nothing.
struct VplStart {
    vec3 origin;
    vec3 direction;
    vec3 power_w;
    float range_m;
    float reflected_w;  // what its hit reflects: roulette keeps the path's power near that
    uint element;       // that its later numbers are of
};

/// Of vpl_starts.comp.
struct VplStartsPush {
    SequenceKey sequence;  // of the texels
    uint vpls;             // paths whose power a whole pass shares
    uint levels;           // of the map
    uint first_path;       // of the list
    uint paths;            // at most
    uint runs;
    uint sorted;  // 1: by their texels
};

/// Of vpl_paths.glsl.
struct VplPathsPush {
    SequenceKey sequence;  // of what comes after the first ray
    uint paths;
    uint bounces;
    uint photon_capacity;
    uint surface_capacity;
    float connect_threshold;
    uint rated;  // 1: to be looked at, and none of the pass's
};

#ifdef __cplusplus
static_assert(sizeof(VplTexelsPush) == 40 && sizeof(VplStartsPush) == 40 && sizeof(VplPathsPush) == 40 &&
                  sizeof(VplStart) == 48,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
