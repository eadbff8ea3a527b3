#include "renderer/progressive/radius_map.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/core/rng.h"

namespace photond {

namespace {

constexpr uint32_t kIsLeaf = RADIUS_MAP_LEAF;

}  // namespace

RadiusMap::RadiusMap(std::vector<PlacedRadius> places, float otherwise_m) : most_m_(otherwise_m) {
    if (places.empty()) {
        leaves_.push_back({otherwise_m, vec3(0)});
        nodes_.push_back({0, kIsLeaf, 0, 0});
        return;
    }
    build(places);
    most_m_ = std::ranges::max_element(leaves_, {}, &Leaf::radius_m)->radius_m;
}

uint32_t RadiusMap::build(std::span<PlacedRadius> places) {
    const auto node = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Bounds3 box;
    for (const PlacedRadius& place : places) box.extend(place.position);
    const vec3 width_m = box.max - box.min;
    const int axis = width_m.x >= width_m.y && width_m.x >= width_m.z ? 0 : width_m.y >= width_m.z ? 1 : 2;
    if (places.size() <= kLeafPlaces || !(width_m[axis] > 0)) {
        double sum = 0;
        for (const PlacedRadius& place : places) sum += std::log(double{place.radius_m});
        nodes_[node] = {0, kIsLeaf, static_cast<uint32_t>(leaves_.size()), 0};
        leaves_.push_back({static_cast<float>(std::exp(sum / static_cast<double>(places.size()))), width_m});
        return node;
    }
    const size_t half = places.size() / 2;
    const auto coordinate = [axis](const PlacedRadius& place) { return place.position[axis]; };
    std::ranges::nth_element(places, places.begin() + static_cast<std::ptrdiff_t>(half), {}, coordinate);
    const float plane = coordinate(places[half]);
    const uint32_t left = build(places.first(half)), right = build(places.subspan(half));
    nodes_[node] = {plane, static_cast<uint32_t>(axis), left, right};
    return node;
}

const RadiusMap::Leaf& RadiusMap::leaf_at(const vec3& p) const {
    const Node* node = &nodes_[0];
    while (node->axis != kIsLeaf)
        node = &nodes_[p[static_cast<int>(node->axis)] < node->plane ? node->left : node->right];
    return leaves_[node->left];
}

float RadiusMap::radius_m(const vec3& p, uint32_t turn) const {
    const vec3 width_m = leaf_at(p).width_m;
    vec3 moved = p;
    uint32_t bits = turn;
    for (int axis = 0; axis < 3; ++axis) {
        bits = hash32(bits + 0x9e3779b9u);
        moved[axis] += width_m[axis] * (to_unit_float(bits) - 0.5f);
    }
    return leaf_at(moved).radius_m;
}

float RadiusMap::median_m() const {
    if (leaves_.empty()) return most_m_;
    std::vector<float> radii;
    for (const Leaf& leaf : leaves_) radii.push_back(leaf.radius_m);
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::ranges::nth_element(radii, middle);
    return *middle;
}

std::vector<gpu::RadiusMapRecord> RadiusMap::device_records() const {
    std::vector<gpu::RadiusMapRecord> records;
    records.reserve(nodes_.size() + leaves_.size());
    for (const Node& node : nodes_) records.push_back({node.plane, node.axis, node.left, node.right});
    for (const Leaf& leaf : leaves_) {
        const auto width = [&](int axis) { return std::bit_cast<uint32_t>(leaf.width_m[axis]); };
        records.push_back({leaf.radius_m, width(0), width(1), width(2)});
    }
    return records;
}

uint64_t RadiusMap::bytes_for(uint64_t places) {
    // Halves until a leaf is full: leaves hold more than half of what they may.
    const uint64_t leaves = 2 * places / kLeafPlaces + 1;
    return places * sizeof(PlacedRadius) + 2 * (leaves * sizeof(Leaf) + 2 * leaves * sizeof(Node));
}

}  // namespace photond
