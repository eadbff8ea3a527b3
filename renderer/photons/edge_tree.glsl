// GLSL twin of photons/edge_tree.h: whether a place is near an edge of a surface. Define COVERAGE (a
// DiscCoverageConstants) and EDGE_WORD(index), the tree's words, before.
#ifndef PHOTOND_EDGE_TREE_GLSL
#define PHOTOND_EDGE_TREE_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/core/geometry.glsl"
#include "renderer/photons/disc_coverage_shared.h"

float edge_float(uint word) { return uintBitsToFloat(EDGE_WORD(word)); }
vec3 edge_vec3(uint word) { return vec3(edge_float(word), edge_float(word + 1), edge_float(word + 2)); }

bool edge_node_is_near(uint node, vec3 p, float radius_m) {
    const uint word = COVERAGE.first_node_word + EDGE_NODE_WORDS * node;
    if (edge_float(word + 6) >= radius_m) return false;
    const vec3 d = max(max(edge_vec3(word) - p, p - edge_vec3(word + 3)), vec3(0.0));
    return dot(d, d) <= sqr(radius_m);
}

bool edge_is_near(uint edge, vec3 p, float radius_m) {
    const uint word = COVERAGE.first_edge_word + EDGE_WORDS * edge;
    if (edge_float(word + 6) >= radius_m) return false;
    const vec3 a = edge_vec3(word), along = edge_vec3(word + 3) - a, to = p - a;
    const float length_sq = dot(along, along);
    const vec3 d = to - (length_sq > 0.0 ? clamp(dot(to, along) / length_sq, 0.0, 1.0) : 0.0) * along;
    return dot(d, d) <= sqr(radius_m);
}

uint first_edge_of_leaf(uint leaf) {
    return uint(uint64_t(leaf) * uint64_t(COVERAGE.edges) / uint64_t(COVERAGE.leaves));
}

/// EdgeTree::has_edges().
bool has_edges(vec3 p, float radius_m) {
    if (COVERAGE.leaves == 0) return false;
    for (uint node = 1;;) {
        if (edge_node_is_near(node, p, radius_m)) {
            if (node < COVERAGE.leaves) {
                node *= 2;
                continue;
            }
            const uint end = first_edge_of_leaf(node - COVERAGE.leaves + 1);
            for (uint edge = first_edge_of_leaf(node - COVERAGE.leaves); edge < end; ++edge)
                if (edge_is_near(edge, p, radius_m)) return true;
        }
        ++node;
        node >>= findLSB(node);
        if (node == 1) return false;
    }
}

#endif
