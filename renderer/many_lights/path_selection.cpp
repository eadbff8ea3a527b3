#include "renderer/many_lights/path_selection.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "renderer/core/rng.h"
#include "renderer/many_lights/flux_map.h"

namespace photond {

namespace {

using gpu::VplPath;

RandomStream numbers_of(uint64_t seed, uint32_t pass, uint32_t stage, uint32_t stream) {
    return {seed, RandomDomain::Splats, pass, uint64_t{stage} << 32 | stream};
}

RatePhotons worth_by(const CameraImportance& seen, const Intersector& intersector) {
    return [&](std::span<const ReflectedPhoton> photons, std::span<const uint32_t> elements,
               std::span<PhotonWorth> worth) { return seen.brought(intersector, photons, elements, worth); };
}

/// The share of a path's light that is seen where it would arrive, as far as its rating tells.
float choice_of(const PhotonWorth& worth) {
    const float seen = worth.seen / worth.unshadowed;
    return seen > PATH_LEAST_CHOICE ? std::min(seen, 1.0f) : PATH_LEAST_CHOICE;
}

std::vector<VplPath> halton_paths(uint32_t count, const uvec2& rotation) {
    std::vector<VplPath> paths(count);
    for (uint32_t i = 0; i < count; ++i) {
        const uvec2 point = rotated_halton_point(i, rotation);
        paths[i] = {point.x, point.y, i, 1, 0};
    }
    return paths;
}

SelectedPaths accept(const PathPilot& pilot, uint32_t vpls, uint64_t seed, uint32_t pass, const uvec2& rotation,
                     const RatePaths& rate) {
    const std::vector<VplPath> candidates = halton_paths(pilot.candidates, rotation);
    const std::vector<PhotonWorth> worth = rate(candidates);
    const float share = static_cast<float>(vpls) / static_cast<float>(pilot.candidates);
    std::vector<VplPath> kept;
    for (uint32_t i = 0; i < pilot.candidates; ++i) {
        const float chance = std::min(pilot.target(worth[i].seen), 1.0f);
        if (!(numbers_of(seed, pass, PATH_STAGE_ACCEPTANCE, i).next() < chance)) continue;
        kept.push_back(candidates[i]);
        kept.back().weight = share / chance;
        kept.back().choice = choice_of(worth[i]);
    }
    const uint64_t count = kept.size();
    if (count > vpls) {
        // One in count / vpls of them, at equal steps: each is among them with the same chance.
        const uint32_t offset =
            static_cast<uint32_t>(uint64_t{numbers_of(seed, pass, PATH_STAGE_THINNING, 0).next_bits()} * count >> 32);
        for (uint64_t k = 0; k < vpls; ++k) {
            kept[k] = kept[(k * count + offset) / vpls];
            kept[k].weight *= static_cast<float>(count) / static_cast<float>(vpls);
        }
        kept.resize(vpls);
    }
    return {std::move(kept), pilot.candidates, count};
}

/// A step from `path`; a new tail has that element's numbers.
VplPath mutated(VplPath path, RandomStream& random, uint32_t element) {
    const uint32_t x = random.next_bits(), y = random.next_bits(), bits = random.next_bits();
    if (random.next() < CHAIN_LARGE_STEPS) return {x, y, element, 1, 0};
    // Whole numbers, the same on both devices; up as likely as down.
    const uint32_t shift = 32 - CHAIN_STEP_BITS + (bits >> 8) % CHAIN_STEP_SCALES;
    path.point_x += (bits & 2u) != 0 ? x >> shift : 0u - (x >> shift);
    path.point_y += (bits & 4u) != 0 ? y >> shift : 0u - (y >> shift);
    if ((bits & CHAIN_REDRAWN_TAILS) != 0) path.element = element;
    return path;
}

SelectedPaths walk_chains(const PathPilot& pilot, uint32_t vpls, uint64_t seed, uint32_t pass, const uvec2& rotation,
                          const RatePaths& rate) {
    struct State {
        VplPath path;
        float target;
        float mean_target;  // of the candidates, by the chance that this chain's start had among them
        uint32_t times, left;
    };
    const ChainShape shape(vpls);
    const std::vector<VplPath> candidates = halton_paths(pilot.candidates, rotation);
    const std::vector<PhotonWorth> worth = rate(candidates);
    FluxMap starts((static_cast<uint32_t>(std::bit_width(pilot.candidates - 1)) + 1) / 2);
    for (uint32_t i = 0; i < pilot.candidates; ++i) starts.worth()[i] = pilot.target(worth[i].seen);
    starts.sum();

    RandomStream random = numbers_of(seed, pass, PATH_STAGE_STARTS, 0);
    const uint32_t rotation_x = random.next_bits(), rotation_y = random.next_bits();
    std::vector<State> chains(shape.chains);
    for (uint32_t c = 0; c < shape.chains; ++c) {
        const Texel start = starts.choose(rotated_halton_point(c, {rotation_x, rotation_y}));
        const float target = starts.worth()[start.index];
        const float mean = target / (static_cast<float>(pilot.candidates) * start.probability);
        chains[c] = {candidates[start.index], target, mean, 1, 0};
        chains[c].path.choice = choice_of(worth[start.index]);
    }
    SelectedPaths selected;
    selected.paths.resize(size_t{shape.chains} * shape.states, VplPath{});  // what weighs nothing is nothing
    const float share = static_cast<float>(vpls) / static_cast<float>(shape.chains * shape.states);
    const auto leave = [&](State& state) {
        const auto chain = static_cast<uint32_t>(&state - chains.data());
        VplPath& left = selected.paths[chain * shape.states + state.left++];
        left = state.path;
        left.weight = share * state.mean_target * static_cast<float>(state.times) / state.target;
    };
    std::vector<VplPath> proposed(shape.chains);
    std::vector<float> chances(shape.chains);
    for (uint32_t step = 1; step < shape.states; ++step) {
        for (uint32_t c = 0; c < shape.chains; ++c) {
            RandomStream mine = numbers_of(seed, pass, PATH_STAGE_STEPS + step, c);
            proposed[c] = mutated(chains[c].path, mine, pilot.candidates + step * shape.chains + c);
            chances[c] = mine.next();
        }
        const std::vector<PhotonWorth> brought = rate(proposed);
        for (uint32_t c = 0; c < shape.chains; ++c) {
            State& state = chains[c];
            const float target = pilot.target(brought[c].seen);
            if (!(chances[c] * state.target < target)) {
                ++state.times;
                continue;
            }
            leave(state);
            state.path = proposed[c], state.target = target, state.times = 1;
            state.path.choice = choice_of(brought[c]);
            ++selected.accepted;
        }
    }
    for (State& state : chains) leave(state);
    selected.offered = uint64_t{shape.chains} * (shape.states - 1);
    return selected;
}

}  // namespace

PathPilot::PathPilot(VplPlacement placement, std::span<const float> worth, uint32_t vpls) : candidates(vpls) {
    double sum = 0;
    for (const float value : worth)
        if (std::isfinite(value)) sum += double{value};
    if (!worth.empty()) mean_worth = static_cast<float>(sum / static_cast<double>(worth.size()));
    if (placement != VplPlacement::Acceptance || !(mean_worth > 0)) return;
    double kept = 0;
    for (const float value : worth) kept += double{std::min(target(value), 1.0f)};
    candidates = static_cast<uint32_t>(std::ceil(vpls * static_cast<double>(worth.size()) / kept));
}

PathPilot find_path_pilot(VplPlacement placement, const VplTracer& tracer, const CameraImportance& seen,
                          const Intersector& intersector, uint32_t vpls, uint64_t seed, Stats& stats) {
    constexpr uint32_t kPaths = 1024;
    std::vector<float> worth;
    const SelectPaths none = [&](const uvec2& rotation, const RatePaths& rate) {
        for (const PhotonWorth& of_path : rate(halton_paths(kPaths, rotation))) worth.push_back(of_path.seen);
        return SelectedPaths{};
    };
    tracer.trace_selected(reference_seed(seed), 0, worth_by(seen, intersector), none, stats, CancelToken{});
    return {placement, worth, vpls};
}

float PathPilot::target(float worth) const {
    if (!(mean_worth > 0)) return 1;
    const float relative = worth / mean_worth;
    return relative > 0 ? std::min(relative, PATH_MOST_TARGET) + PATH_LEAST_TARGET : PATH_LEAST_TARGET;
}

TracedReflections trace_by_worth(VplPlacement placement, const PathPilot& pilot, const VplTracer& tracer,
                                 const CameraImportance& seen, const Intersector& intersector, uint32_t vpls,
                                 uint64_t seed, uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const SelectPaths select = [&](const uvec2& rotation, const RatePaths& rate) {
        return placement == VplPlacement::Acceptance ? accept(pilot, vpls, seed, pass, rotation, rate)
                                                     : walk_chains(pilot, vpls, seed, pass, rotation, rate);
    };
    return tracer.trace_selected(seed, pass, worth_by(seen, intersector), select, stats, cancel);
}

}  // namespace photond
