#include "renderer/photons/photon_map.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr size_t kGrain = 1 << 14;

}  // namespace

PhotonMap::PhotonMap(std::vector<Photon> photons, const PhotonSearch& search) : search_(search) {
    assert(search.radius_m > 0 && "photons are looked for within a radius");
    assert((search.kind == PhotonSearch::Kind::Radius || search.nearest >= 2) && "the k-th sets the radius only");
    if (photons.empty()) return;
    std::vector<uint32_t> order(photons.size());
    {
        std::vector<vec3> points(photons.size());
        parallel_for(photons.size(), kGrain, [&](size_t i) { points[i] = photons[i].position; });
        if (search.kind == PhotonSearch::Kind::Nearest) {
            structure_.emplace<KdTree>(points, order);
        } else {
            structure_.emplace<HashGrid>(points, search.radius_m, order);
        }
    }
    payloads_.resize(photons.size());
    parallel_for(photons.size(), kGrain, [&](size_t i) { payloads_[i] = photons[order[i]].payload; });
}

vec3 PhotonMap::position(uint32_t index) const {
    if (const KdTree* tree = kd_tree()) return tree->position(index);
    assert(hash_grid() && "an empty map has no photon to ask for");
    return hash_grid()->position(index);
}

void PhotonMap::find(const vec3& p, Neighbours& out) const {
    if (const KdTree* tree = kd_tree()) {
        tree->find_nearest(p, search_.nearest, search_.radius_m, out);
    } else if (const HashGrid* grid = hash_grid()) {
        grid->find_within(p, search_.radius_m, out);
    } else {
        out.found.clear();
        out.radius_m = search_.radius_m;
    }
}

void PhotonMap::find_within(const vec3& p, float radius_m, Neighbours& out) const {
    if (const KdTree* tree = kd_tree()) {
        tree->find_within(p, radius_m, out);
    } else if (const HashGrid* grid = hash_grid()) {
        grid->find_within(p, radius_m, out);
    } else {
        out.found.clear();
        out.radius_m = radius_m;
    }
}

uint64_t PhotonMap::bytes() const {
    uint64_t bytes = payloads_.capacity() * sizeof(PhotonPayload);
    if (const KdTree* tree = kd_tree()) bytes += tree->bytes();
    if (const HashGrid* grid = hash_grid()) bytes += grid->bytes();
    return bytes;
}

uint64_t PhotonMap::bytes_for(uint64_t photons) {
    const uint64_t order = photons * sizeof(uint32_t), points = photons * sizeof(vec3);
    const auto most = [&](uint64_t structure, uint64_t build) {
        // While the structure is built, and while the payloads are moved.
        return structure + order + std::max(points + build, photons * sizeof(PhotonPayload));
    };
    return photons * sizeof(Photon) + std::max(most(KdTree::bytes_for(photons), KdTree::build_bytes_for(photons)),
                                               most(HashGrid::bytes_for(photons), HashGrid::build_bytes_for(photons)));
}

}  // namespace photond
