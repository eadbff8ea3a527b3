// GLSL twin of transport/light_tree.cpp: a light drawn with a probability that follows what it can bring to a point.
#ifndef PHOTOND_LIGHT_TREE_GLSL
#define PHOTOND_LIGHT_TREE_GLSL

#include "renderer/core/angles.glsl"
#include "renderer/transport/light_tables.glsl"
#include "renderer/transport/light_tree_shared.h"

layout(set = SCENE_SET, binding = LIGHT_NODES_BINDING, scalar) readonly buffer LightNodes {
    LightNodeRecord light_nodes[];
};

struct LightTreeChoice {
    uint light;         // index in `emitters`
    float probability;  // > 0
    float u;            // what is left of the number that chose, uniform in [0, 1) again
};

/// cos(max(0, a - b)) from sines and cosines of two angles in [0, pi].
float cos_of_difference(float cos_a, float sin_a, float cos_b, float sin_b) {
    return cos_a > cos_b ? 1.0 : cos_a * cos_b + sin_a * sin_b;
}
float sin_of_difference(float cos_a, float sin_a, float cos_b, float sin_b) {
    return cos_a > cos_b ? 0.0 : sin_a * cos_b - cos_a * sin_b;
}

/// [Conty Estevez and Kulla 2018, Eq. 3] with the cosine at p bounded as well: intensity x cos' x cos_i' / d^2, where
/// each angle is made smaller by what the cluster's extent and cone leave open. Zero only where nothing can arrive.
float light_tree_importance(LightNodeRecord node, vec3 p, vec3 n) {
    const vec3 to_centre = node.centre - p;
    const float distance_sq = dot(to_centre, to_centre);
    const float radius_sq = sqr(node.radius);
    // Among lights directions tell nothing, and the cluster's extent stands for the distance.
    if (distance_sq <= max(radius_sq, 1e-24))
        return node.intensity / max(max(distance_sq, 0.1 * radius_sq), 1e-24);

    const float inverse_distance = inversesqrt(distance_sq);
    const vec3 w = inverse_distance * to_centre;
    const float sin_spread = node.radius * inverse_distance;  // of the sphere seen from p
    const float cos_spread = sin_from_cos(sin_spread);

    float cos_out = -dot(node.axis, w);
    if (has_flag(node.link, LIGHT_NODE_TWO_SIDED)) cos_out = abs(cos_out);
    const float sin_out = sin_from_cos(cos_out);
    const float cos_x = cos_of_difference(cos_out, sin_out, node.cos_cone, node.sin_cone);
    const float sin_x = sin_of_difference(cos_out, sin_out, node.cos_cone, node.sin_cone);
    const float cos_least = cos_of_difference(cos_x, sin_x, cos_spread, sin_spread);
    // The slack keeps rounding from declaring a light unseen; at worst a cluster is asked in vain.
    if (cos_least <= node.cos_emission - 1e-5) return 0.0;
    float importance = node.intensity * max(cos_least, 1e-3) * sqr(inverse_distance);

    if (n != vec3(0.0)) {
        const float cos_in = dot(n, w);
        const float cos_in_least = cos_of_difference(cos_in, sin_from_cos(cos_in), cos_spread, sin_spread);
        if (cos_in_least <= -1e-5) return 0.0;
        importance *= max(cos_in_least, 1e-3);
    }
    return importance;
}

bool light_tree_empty() { return light_constants.nodes == 0u; }

float light_tree_irradiance_estimate(vec3 p, vec3 n) {
    return light_tree_empty() ? 0.0 : light_tree_importance(light_nodes[0], p, n);
}

/// Probability of the left one of two clusters of these importances; negative where neither can be reached.
float light_tree_share_of_left(float left, float right) {
    if (left > 0.0 && right > 0.0)
        return clamp(left / (left + right), LIGHT_TREE_LEAST_SHARE, 1.0 - LIGHT_TREE_LEAST_SHARE);
    return left > 0.0 ? 1.0 : right > 0.0 ? 0.0 : -1.0;
}

bool light_tree_sample(vec3 p, vec3 n, float u, out LightTreeChoice choice) {
    if (light_tree_empty()) return false;
    uint node = 0u;
    uint link = light_nodes[0].link;
    float probability = 1.0;
    while (!has_flag(link, LIGHT_NODE_LEAF)) {
        const uint left = node + 1u, right = link & LIGHT_NODE_INDEX;
        const LightNodeRecord left_node = light_nodes[left], right_node = light_nodes[right];
        const float left_share =
            light_tree_share_of_left(light_tree_importance(left_node, p, n), light_tree_importance(right_node, p, n));
        if (!(left_share >= 0.0)) return false;
        if (u < left_share) {
            u /= left_share;
            probability *= left_share;
            node = left;
            link = left_node.link;
        } else {
            const float right_share = 1.0 - left_share;
            u = (u - left_share) / right_share;
            probability *= right_share;
            node = right;
            link = right_node.link;
        }
        u = min(u, BELOW_ONE);
    }
    choice = LightTreeChoice(link & LIGHT_NODE_INDEX, probability, u);
    return probability > 0.0;
}

float light_tree_probability(vec3 p, vec3 n, uint light) {
    const uint first = light_constants.leaves + 2u * light;
    const uvec2 path = uvec2(light_words[first], light_words[first + 1u]);
    const uint leaf_depth = path.y >> LEAF_DEPTH_SHIFT;
    if (leaf_depth == LEAF_NO_DEPTH) return 0.0;
    uint node = 0u;
    uint link = light_nodes[0].link;
    float probability = 1.0;
    for (uint depth = 0u; depth < leaf_depth; ++depth) {
        const uint left = node + 1u, right = link & LIGHT_NODE_INDEX;
        const LightNodeRecord left_node = light_nodes[left], right_node = light_nodes[right];
        const float left_share =
            light_tree_share_of_left(light_tree_importance(left_node, p, n), light_tree_importance(right_node, p, n));
        if (!(left_share >= 0.0)) return 0.0;
        const bool goes_right = (((depth < 32u ? path.x : path.y) >> (depth & 31u)) & 1u) != 0u;
        probability *= goes_right ? 1.0 - left_share : left_share;
        node = goes_right ? right : left;
        link = goes_right ? right_node.link : left_node.link;
    }
    return probability;
}

#endif
