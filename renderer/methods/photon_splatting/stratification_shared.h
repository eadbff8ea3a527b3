// Stratified photons on the device, for both compilers. CPU twin: stratification.h.
#ifndef PHOTOND_STRATIFICATION_SHARED_H
#define PHOTOND_STRATIFICATION_SHARED_H

#define STRATIFICATION_GROUP 64  // threads

// Specialisation constant: codes do not fit into a key of 32 bits.
#define STRATIFICATION_WIDE_ID 48

// Representative
#define REPRESENTATIVE_RANDOM 0u
#define REPRESENTATIVE_BY_POWER 1u
#define REPRESENTATIVE_CLOSEST_TO_MEAN 2u
#define REPRESENTATIVE_DOMINANT_DIRECTION 3u

// Words of the state.
#define STRATIFICATION_PHOTONS 0
#define STRATIFICATION_SOURCES 1
#define STRATIFICATION_COVERS 2  // the sum of all that joins begin and end: 0
#define STRATIFICATION_STATE_WORDS 3

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#else
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

/// StratificationSettings and the grid of the pass.
struct StratificationConstants {
    uint64_t seed;
    uint pass;
    uint photons;
    vec3 grid_min;  // StratificationGrid
    float cells_per_m;
    vec3 low;
    uint levels;
    vec3 high;
    uint minimum_photons;
    vec3 first;
    uint splats_per_cell;
    uint representative;
    uint mean_power;  // 0 or 1
    uint high_bits;   // keys: of codes the bits above the 32nd instead of those below
    uint unused;      // the compilers differ in whether they would leave room here
};

/// SplatSource.
struct SplatSourceRecord {
    uint photon;  // the pass's photon-th in the order of ReflectedPhotonsGpu
    vec3 power_w;
    float photons;
};

#ifdef __cplusplus
static_assert(sizeof(StratificationConstants) == 96 && sizeof(SplatSourceRecord) == 20,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
