// Light paths of virtual point lights, chosen by what they bring to the picture (path_selection.h), for both compilers.
#ifndef PHOTOND_PATH_SELECTION_SHARED_H
#define PHOTOND_PATH_SELECTION_SHARED_H

#define PATH_SELECTION_GROUP 64  // threads

/// Of the mean that a path's target is of at least: what lights is never left out.
#define PATH_LEAST_TARGET 0.1f
#define PATH_MOST_TARGET 1e6f
#define PATH_LEAST_CHOICE 0.1f  // of their size, that choices take lights for

// States of a chain, at most; and its mutations.
#define CHAIN_STATES 16
#define CHAIN_LARGE_STEPS 0.3f    // share of those that forget the state
#define CHAIN_STEP_BITS 29        // a small step moves the point by less than 2^(that - 32) along each axis ...
#define CHAIN_STEP_SCALES 4u      // ... or by half, a quarter ... of that
#define CHAIN_REDRAWN_TAILS 0x1u  // this bit of a number: whether a small step draws what follows the first hit anew

// Stages of a pass that random numbers are drawn for: the upper half of a stream of RandomDomain::Splats.
#define PATH_STAGE_ACCEPTANCE 1u  // a stream a candidate
#define PATH_STAGE_THINNING 2u    // one
#define PATH_STAGE_STARTS 3u      // one
#define PATH_STAGE_STEPS 4u       // and those behind: a stream a chain

// Words of a device's counts.
#define PATHS_KEPT 0      // by acceptance, before they are thinned
#define PATHS_ACCEPTED 1  // by chains
#define PATH_COUNT_WORDS 2

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#else
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

/// Of the shaders that select.
struct PathSelectionPush {
    uint64_t seed;
    uint pass;
    uint vpls;
    uint candidates;
    uint levels;  // of the pyramid over the candidates' targets
    uint chains;
    uint states;  // of each chain
    uint step;
    uint unused;  // the compilers differ in whether they would leave room here
};

/// Of path_worth.comp.
struct PathWorthPush {
    uint64_t seed;
    uint pass;
    uint points;  // of the G-buffer
    uint first;   // of the paths, whose targets go there
    uint count;
    float clamp_sq_m2;
    float mean_worth;
};

/// A chain between two of its steps.
struct PathChain {
    uint point_x;  // its state, a VplPath
    uint point_y;
    uint element;
    float target;
    float mean_target;  // of the candidates, by the chance that this chain's start had among them
    uint times;
    uint left;     // states that it has left
    float chance;  // by which the step that is proposed is decided
    float choice;  // the state's
};

#ifdef __cplusplus
static_assert(sizeof(PathSelectionPush) == 40 && sizeof(PathWorthPush) == 32 && sizeof(PathChain) == 36,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
