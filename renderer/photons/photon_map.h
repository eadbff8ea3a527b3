#pragma once
// A set of photons that can be searched: by kd-tree for the k nearest, by hash grid within a fixed radius.

#include <variant>

#include "renderer/core/memory_budget.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/photons/kd_tree.h"
#include "renderer/photons/photon.h"

namespace photond {

/// How photons about a point are found.
struct PhotonSearch {
    enum class Kind : uint8_t { Nearest, Radius };
    Kind kind = Kind::Nearest;
    uint32_t nearest = 50;   // k, >= 2
    float radius_m = 0.05f;  // the fixed radius; of the k nearest the farthest that is looked at; > 0
};

/// Immutable and thread-safe once built.
class PhotonMap {
public:
    PhotonMap() = default;
    /// Builds the structure in parallel; the map is the same for any number of threads.
    PhotonMap(std::vector<Photon> photons, const PhotonSearch& search);

    bool empty() const { return payloads_.empty(); }
    size_t size() const { return payloads_.size(); }
    const PhotonSearch& search() const { return search_; }
    const PhotonPayload& payload(uint32_t index) const { return payloads_[index]; }
    vec3 position(uint32_t index) const;

    /// Photons about p, as search() says. Empty when the map is.
    void find(const vec3& p, Neighbours& out) const;
    /// Photons nearer to p than radius_m, which must not be more than search() has where that is a fixed radius.
    void find_within(const vec3& p, float radius_m, Neighbours& out) const;
    /// The structure, where one is wanted by name; nullptr when the map has the other (or is empty).
    const KdTree* kd_tree() const { return std::get_if<KdTree>(&structure_); }
    const HashGrid* hash_grid() const { return std::get_if<HashGrid>(&structure_); }

    uint64_t bytes() const;
    /// The most that a map of so many photons takes while it is built, the photons it is given included; of either
    /// structure.
    static uint64_t bytes_for(uint64_t photons);

private:
    PhotonSearch search_;
    std::variant<std::monostate, KdTree, HashGrid> structure_;
    std::vector<PhotonPayload> payloads_;  // in the structure's order
};

}  // namespace photond
