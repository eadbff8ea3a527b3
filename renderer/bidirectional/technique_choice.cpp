#include "renderer/bidirectional/technique_choice.h"

#include <algorithm>
#include <cmath>

namespace photond {

void CandidateMoments::add(TechniqueKind kind, const Rgb& value, std::span<const float> weights,
                           std::span<const WeighedCandidate> candidates) {
    const double mean = (double{value.x} + double{value.y} + double{value.z}) / 3;
    const double square =
        (double{value.x} * double{value.x} + double{value.y} * double{value.y} + double{value.z} * double{value.z}) / 3;
    for (size_t c = 0; c < candidates.size(); ++c) {
        const double weight = double{weights[c]};
        squares_[c] += weight * weight * square * double{candidates[c].more(kind)};
        means_[c * kTechniqueKinds + static_cast<size_t>(kind)] += weight * mean;
    }
}

CandidateMoments& CandidateMoments::operator+=(const CandidateMoments& other) {
    for (size_t i = 0; i < squares_.size(); ++i) squares_[i] += other.squares_[i];
    for (size_t i = 0; i < means_.size(); ++i) means_[i] += other.means_[i];
    return *this;
}

double CandidateMoments::mean(size_t candidate, double pixel_passes) const {
    double sum = 0;
    for (size_t kind = 0; kind < kTechniqueKinds; ++kind) sum += means_[candidate * kTechniqueKinds + kind];
    return sum / pixel_passes;
}

double CandidateMoments::variance(size_t candidate, double pixel_passes) const {
    double squared_means = 0;
    for (size_t kind = 0; kind < kTechniqueKinds; ++kind) {
        // Samples that many light paths share of a pixel's light have no mean worth the name each.
        if (kind == static_cast<size_t>(TechniqueKind::Seen) || kind == static_cast<size_t>(TechniqueKind::Merge))
            continue;
        const double mean = means_[candidate * kTechniqueKinds + kind] / pixel_passes;
        squared_means += mean * mean;
    }
    return std::max(squares_[candidate] / pixel_passes - squared_means, 0.0);
}

std::vector<TechniqueCandidate> technique_candidates(const TechniqueChoices& choices) {
    std::vector<float> light_paths;
    if (choices.light_paths) {
        light_paths = {std::min(*choices.light_paths, choices.most_light_paths)};
    } else {
        if (!choices.needs_light_paths) light_paths = {0};
        for (const float share : {0.25f, 0.5f, 0.75f, 1.0f, 2.0f}) {
            light_paths.push_back(std::min(share, choices.most_light_paths));
            if (share >= choices.most_light_paths) break;
        }
    }
    std::vector<uint32_t> connections{1, 2, 4, 8};
    if (!choices.needs_connections) connections.insert(connections.begin(), 0);
    if (choices.connections) connections = {*choices.connections};
    std::vector<TechniqueCandidate> all;
    for (const float paths : light_paths) {
        if (!(paths > 0)) {
            all.push_back({});  // from the eye alone
            continue;
        }
        for (const uint32_t of_vertex : connections) {
            if (!choices.needs_merges) all.push_back({paths, of_vertex, false});
            if (choices.merges) all.push_back({paths, of_vertex, true});
        }
    }
    return all;
}

double counted_cost(const TechniqueCandidate& candidate, const PilotCounts& counts, const CostlyScene& scene) {
    // Microseconds of one core of the machine that they were measured on: only what they are to each other counts. Few
    // triangles are gone through without a structure; plain Lambert reflectors are shaded in lanes by the eye alone.
    const bool small = scene.triangles <= 64;
    const double ray = small ? 0.03 : 0.25 + 0.012 * std::log2(static_cast<double>(scene.triangles) / 64);
    const double shading = scene.only_lambert ? 0.07 : 0.25, evaluation = scene.only_lambert ? 0.06 : 0.2;
    constexpr double kWeights = 0.3, kLight = 0.3, kSeen = 0.1, kConnection = 0.25;
    const double query = small ? 0.05 : 0.2;
    double cost = (counts.eye_vertices + counts.open_vertices) * ray + counts.eye_vertices * shading;
    if (!(candidate.light_paths > 0)) return cost;
    cost += counts.eye_vertices * kWeights;
    cost += candidate.light_paths * (counts.light_vertices * (ray + kLight) + counts.seen * (ray + kSeen));
    cost += candidate.connections * counts.open_vertices * (0.6 * ray + kConnection);
    if (candidate.merges) cost += counts.open_vertices * query + candidate.light_paths * counts.found * evaluation;
    return cost;
}

}  // namespace photond
