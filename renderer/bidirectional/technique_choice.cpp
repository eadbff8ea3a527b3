#include "renderer/bidirectional/technique_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace photond {

namespace {

double mean_of(const Rgb& value) { return (double{value.x} + double{value.y} + double{value.z}) / 3; }
double mean_square_of(const Rgb& value) {
    return (double{value.x} * double{value.x} + double{value.y} * double{value.y} + double{value.z} * double{value.z}) /
           3;
}

}  // namespace

CandidateWeight weigh_candidate(const MisShare& of_pilot, const MisShare& of_candidate) {
    constexpr float kMost = 1e12f;  // where the candidate could hardly make that path
    const float ratio = of_pilot.all() / of_candidate.all();
    return {.weight = of_candidate.weight(), .by_density = sqr(of_pilot.weight()) * (ratio < kMost ? ratio : kMost)};
}

void EyePathSum::add(TechniqueKind kind, const Rgb& value, const CandidateWeight& weight) {
    const Rgb weighed = weight.weight * value;
    by_density += static_cast<float>(double{weight.by_density} * mean_square_of(value));
    all += weighed;
    if (kind == TechniqueKind::Connection) {
        connected += weighed;
        connected_squared += static_cast<float>(mean_square_of(weighed));
    }
    if (kind == TechniqueKind::Merge) merged_squared += static_cast<float>(mean_square_of(weighed));
}

void PixelMoments::add(const EyePathSum& path) {
    squares_ += static_cast<float>(mean_square_of(path.all));
    eye_.all += path.all, eye_.connected += path.connected;
    eye_.connected_squared += path.connected_squared, eye_.merged_squared += path.merged_squared;
    eye_.by_density += path.by_density;
}

void PixelMoments::add_seen(const Rgb& value, const CandidateWeight& weight) {
    const Rgb weighed = weight.weight * value;
    seen_by_density_ += static_cast<float>(double{weight.by_density} * mean_square_of(value));
    seen_ += static_cast<float>(mean_of(weighed));
    seen_squares_ += static_cast<float>(mean_square_of(weighed));
}

double PixelMoments::mean(uint32_t passes) const { return (mean_of(eye_.all) + double{seen_}) / passes; }

double PixelMoments::variance(uint32_t passes, const WeighedCandidate& candidate) const {
    const double connected = std::max(double{eye_.connected_squared} - mean_square_of(eye_.connected) / passes, 0.0);
    // How many vertices merge, and how many the camera sees, is chance: as counts do, they vary by their squares.
    const double merged = double{eye_.merged_squared}, seen = double{seen_squares_};
    return (double{squares_} - mean_square_of(eye_.all) / passes) / (passes - 1) +
           ((double{candidate.more_connections} - 1) * connected + (double{candidate.more_light_paths} - 1) * merged +
            double{candidate.more_light_paths} * seen) /
               passes;
}

double PixelMoments::second_moment(uint32_t passes) const {
    return (double{eye_.by_density} + double{seen_by_density_}) / passes;
}

void VarianceSums::add(const VarianceSums& more, double weight) {
    for (size_t c = 0; c < of_paths.size(); ++c) {
        of_paths[c] += weight * more.of_paths[c];
        second_moments[c] += weight * more.second_moments[c];
    }
}

std::vector<double> VarianceSums::variances(size_t known) const {
    std::vector<double> result(of_paths.size());
    for (size_t c = 0; c < result.size(); ++c)
        result[c] = std::max({of_paths[c], of_paths[known] + second_moments[c] - second_moments[known], 0.0});
    return result;
}

size_t most_like_pilot(std::span<const TechniqueCandidate> candidates) {
    const auto distance = [](const TechniqueCandidate& c) {
        return std::fabs(std::log2(std::max(c.light_paths, 0.01f))) + std::fabs(static_cast<float>(c.connections) - 1) +
               (c.merges ? 0.0f : 10.0f);
    };
    return static_cast<size_t>(std::ranges::min_element(candidates, {}, distance) - candidates.begin());
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
    constexpr double kWeights = 0.3, kLight = 0.3, kSeen = 0.1, kConnection = 0.25, kClipRays = 12;
    const double query = small ? 0.05 : 0.2;
    double cost = (counts.eye_vertices + counts.open_vertices) * ray + counts.eye_vertices * shading;
    if (!(candidate.light_paths > 0)) return cost;
    cost += counts.eye_vertices * kWeights;
    cost += candidate.light_paths * (counts.light_vertices * (ray + kLight) + counts.seen * (ray + kSeen));
    cost += candidate.connections * counts.open_vertices * (0.6 * ray + kConnection);
    if (candidate.merges)
        cost += counts.open_vertices * query + candidate.light_paths * counts.found * evaluation +
                counts.clipped * kClipRays * ray;
    return cost;
}

namespace {

/// A block's own best has to be better by more than that, of what is weighed.
constexpr double kStay = 0.85;
constexpr int kRounds = 4;

/// The sums over all blocks.
JudgedBlock sum_of(std::span<const JudgedBlock> judged, size_t candidates, std::span<const size_t> of_blocks) {
    JudgedBlock sum;
    for (size_t block = 0; block < of_blocks.size(); ++block) {
        const JudgedBlock& here = judged[block * candidates + of_blocks[block]];
        sum.relative_variance += here.relative_variance, sum.cost += here.cost;
    }
    return sum;
}
double worth(const JudgedBlock& judged) { return judged.relative_variance * judged.cost; }
bool has_all_of(const TechniqueCandidate& more, const TechniqueCandidate& less) {
    return more.connections >= less.connections && (more.merges || !less.merges);
}

}  // namespace

ChosenTechniques choose_techniques(std::span<const TechniqueCandidate> candidates,
                                   std::span<const JudgedBlock> judged) {
    const size_t count = candidates.size(), blocks = judged.size() / count;
    std::vector<double> alone;  // what each would be everywhere
    for (size_t c = 0; c < count; ++c) alone.push_back(worth(sum_of(judged, count, std::vector<size_t>(blocks, c))));
    ChosenTechniques best;
    best.everywhere = static_cast<size_t>(std::ranges::min_element(alone) - alone.begin());
    // What is left where light is brighter than can be squared, and nothing is less than anything.
    best.of_blocks.assign(blocks, best.everywhere);
    double least = std::numeric_limits<double>::infinity();
    for (size_t first = 0; first < count;) {
        size_t end = first;
        while (end < count && candidates[end].light_paths == candidates[first].light_paths) ++end;
        const auto of_image = static_cast<size_t>(std::min_element(alone.begin() + static_cast<std::ptrdiff_t>(first),
                                                                   alone.begin() + static_cast<std::ptrdiff_t>(end)) -
                                                  alone.begin());
        // The product of two sums is least where each block has the least variance and cost together, cost being worth
        // what the sums' ratio says; which changes with what is chosen.
        std::vector<size_t> of_blocks(blocks, of_image);
        JudgedBlock sum = sum_of(judged, count, of_blocks);
        for (int round = 0; round < kRounds && sum.cost > 0; ++round) {
            const double per_cost = sum.relative_variance / sum.cost;
            for (size_t block = 0; block < blocks; ++block) {
                const auto weighed = [&](size_t c) {
                    const JudgedBlock& here = judged[block * count + c];
                    return here.relative_variance + per_cost * here.cost;
                };
                size_t own = of_image;
                for (size_t c = first; c < end; ++c)
                    if (has_all_of(candidates[c], candidates[of_image]) && weighed(c) < weighed(own)) own = c;
                of_blocks[block] = weighed(own) < kStay * weighed(of_image) ? own : of_image;
            }
            sum = sum_of(judged, count, of_blocks);
        }
        if (worth(sum) < least) {
            least = worth(sum);
            best.of_blocks = std::move(of_blocks);
        }
        first = end;
    }
    best.gain = least > 0 && std::isfinite(least) ? alone[best.everywhere] / least : 1;
    return best;
}

}  // namespace photond
