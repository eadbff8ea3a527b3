#include "renderer/photons/edge_tree.h"

#include <algorithm>
#include <bit>

#include "renderer/core/copy_elements.h"
#include "renderer/core/parallel.h"

namespace photond {

namespace {

float squared_distance(const vec3& p, const Bounds3& box) {
    const vec3 d = glm::max(glm::max(box.min - p, p - box.max), vec3(0));
    return glm::dot(d, d);
}

float squared_distance(const vec3& p, const SurfaceEdge& edge) {
    const vec3 along = edge.b - edge.a, to = p - edge.a;
    const float length_sq = glm::dot(along, along);
    const float t = length_sq > 0 ? std::clamp(glm::dot(to, along) / length_sq, 0.0f, 1.0f) : 0;
    const vec3 d = to - t * along;
    return glm::dot(d, d);
}

}  // namespace

EdgeTree::EdgeTree(std::vector<SurfaceEdge> edges) : edges_(std::move(edges)) {
    if (edges_.empty()) return;
    leaves_ = std::bit_ceil((edges_.size() + kLeafEdges - 1) / kLeafEdges);
    const auto at = [&](size_t edge) { return edges_.begin() + static_cast<std::ptrdiff_t>(edge); };
    for (size_t parts = 1; parts < leaves_; parts *= 2) {
        parallel_for(parts, 1, [&](size_t part) {
            const size_t first = first_edge(part, parts), end = first_edge(part + 1, parts);
            Bounds3 middles;
            for (size_t i = first; i < end; ++i) middles.extend(0.5f * (edges_[i].a + edges_[i].b));
            if (middles.empty()) return;
            const vec3 d = middles.diagonal();
            const int axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
            std::nth_element(at(first), at(first_edge(2 * part + 1, 2 * parts)), at(end),
                             [axis](const SurfaceEdge& e, const SurfaceEdge& f) {
                                 return e.a[axis] + e.b[axis] < f.a[axis] + f.b[axis];
                             });
        });
    }
    nodes_.resize(2 * leaves_);
    for (size_t node = nodes_.size() - 1; node > 0; --node) {
        Node& made = nodes_[node];
        made.harmless_m = kInfinity;
        if (node < leaves_) {
            for (const size_t child : {2 * node, 2 * node + 1}) {
                made.box.extend(nodes_[child].box);
                made.harmless_m = std::min(made.harmless_m, nodes_[child].harmless_m);
            }
            continue;
        }
        const size_t leaf = node - leaves_;
        for (size_t i = first_edge(leaf, leaves_); i < first_edge(leaf + 1, leaves_); ++i) {
            made.box.extend(edges_[i].a), made.box.extend(edges_[i].b);
            made.harmless_m = std::min(made.harmless_m, edges_[i].harmless_m);
        }
    }
}

bool EdgeTree::leaf_has_edges(size_t leaf, const vec3& p, float radius_m) const {
    for (size_t i = first_edge(leaf, leaves_); i < first_edge(leaf + 1, leaves_); ++i)
        if (edges_[i].harmless_m < radius_m && squared_distance(p, edges_[i]) <= sqr(radius_m)) return true;
    return false;
}

bool EdgeTree::has_edges(const vec3& p, float radius_m) const {
    if (leaves_ == 0) return false;
    for (size_t node = 1;;) {
        if (nodes_[node].harmless_m < radius_m && squared_distance(p, nodes_[node].box) <= sqr(radius_m)) {
            if (node < leaves_) {
                node *= 2;
                continue;
            }
            if (leaf_has_edges(node - leaves_, p, radius_m)) return true;
        }
        // To the next sibling, of this node or of the first ancestor that is a left child.
        ++node;
        node >>= std::countr_zero(node);
        if (node == 1) return false;
    }
}

uint64_t EdgeTree::estimate_bytes(uint64_t triangles) {
    // A furnished room has about one for each triangle; smooth surfaces have none, and closed ones at most three
    // halves.
    const uint64_t edges = std::max<uint64_t>(triangles, 16);
    return edges * sizeof(SurfaceEdge) + 2 * std::bit_ceil(edges / kLeafEdges) * sizeof(Node);
}

gpu::DiscCoverageConstants EdgeTree::device_constants(uint32_t first_word) const {
    return {.first_node_word = first_word,
            .first_edge_word = first_word + static_cast<uint32_t>(EDGE_NODE_WORDS * nodes_.size()),
            .leaves = static_cast<uint32_t>(leaves_),
            .edges = static_cast<uint32_t>(edges_.size())};
}

std::vector<uint32_t> EdgeTree::device_words() const {
    static_assert(sizeof(Node) == EDGE_NODE_WORDS * sizeof(uint32_t) &&
                  sizeof(SurfaceEdge) == EDGE_WORDS * sizeof(uint32_t));
    std::vector<uint32_t> words(EDGE_NODE_WORDS * nodes_.size() + EDGE_WORDS * edges_.size());
    if (leaves_ == 0) return words;
    const size_t of_nodes = EDGE_NODE_WORDS * nodes_.size();
    copy_elements(nodes_.data(), std::span(words).first(of_nodes));
    copy_elements(edges_.data(), std::span(words).subspan(of_nodes));
    return words;
}

}  // namespace photond
