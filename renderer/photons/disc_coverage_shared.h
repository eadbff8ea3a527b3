// How places of a disc of density estimation are looked up: for both compilers. CPU twins: disc_coverage.h,
// edge_tree.h.
#ifndef PHOTOND_DISC_COVERAGE_SHARED_H
#define PHOTOND_DISC_COVERAGE_SHARED_H

#define EDGE_NODE_WORDS 7  // EdgeTree::Node, SurfaceEdge
#define EDGE_WORDS 7

#define DISC_COSINE 0.5f         // between normals: surface and photons that are turned more are another's
#define DISC_LEAST_COSINE 1e-3f  // between a photon and the normal of where it lies, that sums are divided by
#define DISC_LEAST_MASS 0.05f    // of a disc's, that sums are divided by
#define DISC_FINE_BATCH 8        // places that are looked up at once, and covered ones that are waited for
#define DISC_COARSE_BATCH 4      // the same where many discs are averaged
#define DISC_MOST_PLACES 128     // that are looked up
#define DISC_NOTHING_LOST 1e-3f  // of the series' last term: less is rounding
#define DISC_LEAST_LIFT 0.1f     // of the radius: how far above the disc places are looked for at least
#define DISC_SAME_PLANE 0.02f    // of the radius: how far from the disc's plane a slanted ray may end
#define DISC_ABOVE_POINT 0.01f   // of the radius: where a ray to a point of a surface ends above it

// Steps of the three-dimensional sequence whose places are spread most evenly: the second is taken for the angle, the
// third for the distance from the axis, the first for the disc that the kernel is a mixture of. [Roberts 2018] The
// Unreasonable Effectiveness of Quasirandom Sequences.
#define DISC_STEP_X 0.8191725134f
#define DISC_STEP_Y 0.6710436067f
#define DISC_STEP_Z 0.5497004779f

// Specialisation constants.
#define DISC_COVERAGE_ID 54  // whether discs are clipped

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// The tree of edges.
struct DiscCoverageConstants {
    uint first_node_word;  // of node 0, which is none: the root is node 1
    uint first_edge_word;
    uint leaves;  // 0: there is no edge
    uint edges;
};

#ifdef __cplusplus
static_assert(sizeof(DiscCoverageConstants) == 16);
}  // namespace photond::gpu
#endif

#endif
