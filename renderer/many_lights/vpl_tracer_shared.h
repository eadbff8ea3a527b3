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

/// Of vpl_choose.comp.
struct VplChoosePush {
    uint paths;
    uint levels;  // of the map
    uint rotation_x;
    uint rotation_y;
};

/// The first step of a path, with its share of the power; black: it carries nothing.
struct VplStart {
    vec3 origin;
    vec3 direction;
    vec3 power_w;
    float range_m;
    float reflected_w;  // what its hit reflects: roulette keeps the path's power near that
    uint point;         // by which it was chosen: its numbers are of that element
};

/// Of vpl_starts.comp.
struct VplStartsPush {
    SequenceKey sequence;  // of the texels
    uint paths;
    uint levels;  // of the map
    uint rotation_x;
    uint rotation_y;
    uint runs;
    uint unused;  // the compilers differ in whether they would leave room here
};

/// Of vpl_paths.glsl.
struct VplPathsPush {
    SequenceKey sequence;  // of what comes after the first ray
    uint paths;
    uint bounces;
    uint photon_capacity;
    uint surface_capacity;
    float connect_threshold;
    uint unused;
};

#ifdef __cplusplus
static_assert(sizeof(VplTexelsPush) == 40 && sizeof(VplStartsPush) == 40 && sizeof(VplPathsPush) == 40 &&
                  sizeof(VplStart) == 48,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
