// Reflected photons on the device, for both compilers: the records are ReflectedPhoton's and ReflectingSurface's.
#ifndef PHOTOND_REFLECTED_PHOTON_SHARED_H
#define PHOTOND_REFLECTED_PHOTON_SHARED_H

#ifndef __cplusplus
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#include "renderer/transport/sobol_shared.h"

#define REFLECTION_GROUP 64  // threads

// ReflectedPhoton::Spread
#define SPREAD_LAMBERT 0u
#define SPREAD_ROUGH 1u
#define SPREAD_BEAM 2u
#define SPREAD_SHIFT 8          // above the scatterings, which have the byte below
#define CASTER_SHIFT 10         // of SPREAD_BEAM: the instance that scattered it
#define MOST_CASTER 0x3fffffu   // ReflectedPhoton::kMostCaster
#define NO_SURFACE 0xffffffffu  // ReflectedPhoton::kNoSurface

#define JITTER_SET 0x80000000u  // kJitterSet

// Words of the state.
#define REFLECTION_PHOTONS 0   // of the pass; those for which there is no room are counted alone
#define REFLECTION_SURFACES 1  // the same
#define REFLECTION_ORDERED 2   // the sum of what the paths left
#define REFLECTION_NAN_SAMPLES 3
#define REFLECTION_INFINITE_SAMPLES 4
#define REFLECTION_PATHS 5  // of the pass
#define REFLECTION_STATE_WORDS 6

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

struct ReflectedPhotonRecord {
    vec3 position;
    vec3 power_w;
    vec3 normal;
    vec3 direction;
    uint smooth_normal;
    float correction;
    uint surface;
    uint scatterings_and_spread;
};

struct ReflectingSurfaceRecord {
    float t;  // the hit
    uint instance;
    uint triangle;
    float u;
    float v;
    vec3 wi_world;
    vec3 arriving_power_w;
    float outside_ior;
};

/// Whose photon this is: the pass's path, and its how-manieth.
struct PhotonOwner {
    uint path;
    uint ordinal;
};

/// ReflectiveShadowMaps::Grid.
struct TexelGrid {
    uint light;
    uint columns;
    uint rows;
    uint first_texel;
    float expected;
};

struct ReflectionPush {
    SequenceKey sequence;
    uint64_t first_element;  // of the pass's path 0
    uint first_path;         // of the paths traced now, half open
    uint end_path;
    uint most_scatterings;
    uint photon_capacity;
    uint surface_capacity;
    uint grids;        // 0: paths start by the lights' power
    uint rough_apart;  // 0 or 1
    float share;       // of its sample's power that a path has
    float glossy_threshold;
    uint unused;  // the compilers differ in whether they would leave room here
};

#ifdef __cplusplus
static_assert(sizeof(ReflectedPhotonRecord) == 64 && sizeof(ReflectingSurfaceRecord) == 48 &&
                  sizeof(ReflectionPush) == 64,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
