#include "renderer/methods/reverse_photon_mapping/photon_stream.h"

#include <algorithm>
#include <numbers>

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"

namespace photond {

namespace {

constexpr size_t kGrain = 1 << 12;
/// Octaves of radii, the largest first; the last has all that are smaller.
constexpr size_t kOctaves = 4;
/// A disc's radius is no smaller than this share of the largest: photons that coincide would have a disc without area,
/// and their light would be lost.
constexpr float kLeastShare = 1e-3f;

constexpr size_t kPhotonBytes = sizeof(StreamedPhoton) + sizeof(StreamedDirection);
/// Fewer photons say nothing of their leaf's density: the last leaf may have so few.
constexpr size_t kLeastInLeaf = 16;

size_t octave_of(float radius_m, float most_m) {
    const float octave = std::floor(std::log2(most_m / radius_m));
    return static_cast<size_t>(std::clamp(octave, 0.0f, static_cast<float>(kOctaves - 1)));
}

}  // namespace

void PhotonStream::Octave::set(size_t photon, const PhotonMap& map, uint32_t index, float photon_radius_m,
                               const EstimateSettings& settings) {
    const PhotonPayload& payload = map.payload(index);
    const float area = sqr(photon_radius_m);
    // Where a disc is without area or without end there is no density (radiance_estimate.cpp says the same).
    const bool spreads = area >= std::numeric_limits<float>::min() && area < kInfinity;
    const vec3 normal = payload.normal(), wi = payload.wi_world();
    photons[photon] = {map.position(index), area, spreads ? payload.power_w / area : Rgb(0), payload.normal_and_path};
    directions[photon] = {wi, glm::dot(wi, normal), normal, disc_thickness_m(settings, photon_radius_m)};
}

PhotonStream::PhotonStream(const PhotonMap& map, const EstimateSettings& settings, std::vector<float> radii_m)
    : map_(&map), radii_m_(std::move(radii_m)) {
    if (map.empty()) return;
    const float most_m = map.search().radius_m;
    if (has_one_radius()) {
        typical_radius_m_ = most_m;
        Octave& all = octaves_.emplace_back();
        all.radius_m = most_m;
        all.least_thickness_m = all.most_thickness_m = disc_thickness_m(settings, most_m);
        all.grid = map.hash_grid();
        all.photons.resize(map.size());
        all.directions.resize(map.size());
        parallel_for(map.size(), kGrain,
                     [&](size_t i) { all.set(i, map, static_cast<uint32_t>(i), most_m, settings); });
        return;
    }
    std::vector<float> sorted = radii_m_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    typical_radius_m_ = *middle;

    std::vector<std::vector<uint32_t>> members(kOctaves);
    for (uint32_t i = 0; i < map.size(); ++i) members[octave_of(radii_m_[i], most_m)].push_back(i);
    grids_.reserve(kOctaves);  // octaves point at them
    for (const std::vector<uint32_t>& indices : members) {
        if (indices.empty()) continue;
        std::vector<vec3> points(indices.size());
        float radius_m = 0, least_radius_m = kInfinity;
        for (size_t i = 0; i < indices.size(); ++i) {
            points[i] = map.position(indices[i]);
            radius_m = std::max(radius_m, radii_m_[indices[i]]);
            least_radius_m = std::min(least_radius_m, radii_m_[indices[i]]);
        }
        std::vector<uint32_t> order(indices.size());
        Octave& octave = octaves_.emplace_back();
        octave.radius_m = radius_m;
        octave.least_thickness_m = disc_thickness_m(settings, least_radius_m);
        octave.most_thickness_m = disc_thickness_m(settings, radius_m);
        octave.grid = &grids_.emplace_back(points, radius_m, order);
        octave.photons.resize(indices.size());
        octave.directions.resize(indices.size());
        parallel_for(indices.size(), kGrain, [&](size_t i) {
            const uint32_t index = indices[order[i]];
            octave.set(i, map, index, radii_m_[index], settings);
        });
    }
}

float PhotonStream::radius_at_m(const vec3& place, float most_m) const {
    if (has_one_radius()) return map_->search().radius_m;
    const uint32_t nearest = map_->kd_tree()->find_one(place, most_m, [](uint32_t) { return true; });
    return nearest < map_->size() ? radii_m_[nearest] : most_m;
}

uint64_t PhotonStream::bytes() const {
    uint64_t bytes = radii_m_.capacity() * sizeof(float);
    for (const HashGrid& grid : grids_) bytes += grid.bytes();
    for (const Octave& octave : octaves_) bytes += octave.photons.capacity() * kPhotonBytes;
    return bytes;
}

uint64_t PhotonStream::bytes_for(uint64_t photons, InfluenceRadius influence) {
    const uint64_t own =
        influence == InfluenceRadius::Fixed ? 0 : sizeof(float) + HashGrid::bytes_for(photons) / photons;
    return photons * (kPhotonBytes + own);
}

std::vector<float> influence_radii_m(const PhotonMap& map, InfluenceRadius influence, uint32_t nearest) {
    if (influence == InfluenceRadius::Fixed || map.empty()) return {};
    const KdTree& tree = *map.kd_tree();
    const float most_m = map.search().radius_m, least_m = kLeastShare * most_m;
    std::vector<float> radii_m(map.size());
    ThreadLocal<Neighbours> scratch;
    const auto nearest_radius_m = [&](size_t i) {
        Neighbours& found = scratch.local();
        // The photon itself is the nearest.
        tree.find_nearest(map.position(static_cast<uint32_t>(i)), nearest + 1, most_m, found);
        return std::max(found.radius_m, least_m);
    };
    if (influence == InfluenceRadius::Knn) {
        parallel_for(map.size(), 256, [&](size_t i) { radii_m[i] = nearest_radius_m(i); });
        return radii_m;
    }
    // [Havran et al. 2005]: the leaf's photons lie on a surface about as large as the square on its diagonal's half,
    // and k of them on a disc.
    constexpr uint32_t kLeaf = KdTree::kBucket;
    parallel_for((map.size() + kLeaf - 1) / kLeaf, 64, [&](size_t leaf) {
        const size_t first = leaf * kLeaf, last = std::min(map.size(), first + kLeaf);
        if (last - first < kLeastInLeaf) {
            for (size_t i = first; i < last; ++i) radii_m[i] = nearest_radius_m(i);
            return;
        }
        Bounds3 bounds;
        for (size_t i = first; i < last; ++i) bounds.extend(map.position(static_cast<uint32_t>(i)));
        const vec3 diagonal = bounds.diagonal();
        const float area = 0.5f * glm::dot(diagonal, diagonal);
        const float share = static_cast<float>(nearest) / static_cast<float>(last - first);
        const float radius_m = std::clamp(std::sqrt(share * area * kInvPi), least_m, most_m);
        std::fill(radii_m.begin() + static_cast<std::ptrdiff_t>(first),
                  radii_m.begin() + static_cast<std::ptrdiff_t>(last), radius_m);
    });
    return radii_m;
}

}  // namespace photond
