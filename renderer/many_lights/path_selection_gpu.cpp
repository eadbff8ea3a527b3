#include "renderer/many_lights/path_selection_gpu.h"

#include <algorithm>
#include <bit>

namespace photond {

namespace {

/// The pyramid's, that holds so many targets.
uint32_t levels_for(uint32_t candidates) { return (static_cast<uint32_t>(std::bit_width(candidates - 1)) + 1) / 2; }

const std::string kFolder = "renderer/many_lights/";

}  // namespace

PathSelectionGpu::PathSelectionGpu(const gpu::DeviceScene& scene, VplTracerGpu& tracer, GBufferGpu& buffer,
                                   gpu::Buffer& counters, VplPlacement placement, const PathPilot& pilot, uint32_t vpls,
                                   uint64_t seed, float clamp_sq_m2)
    : tracer_(tracer),
      buffer_(buffer),
      counters_(counters),
      placement_(placement),
      pilot_(pilot),
      vpls_(vpls),
      rounds_((pilot.candidates + vpls - 1) / vpls),
      seed_(seed),
      clamp_sq_m2_(clamp_sq_m2),
      shape_(vpls),
      targets_(scene.device(), levels_for(pilot.candidates)),
      candidates_(scene.device(), "path_selection", pilot.candidates * sizeof(gpu::VplPath)),
      selected_(scene.device(), "path_selection", vpls * sizeof(gpu::VplPath)),
      kept_(scene.device(), "path_selection", chains() ? 0 : pilot.candidates * sizeof(uint32_t)),
      proposed_(scene.device(), "path_selection", chains() ? shape_.chains * sizeof(gpu::VplPath) : 0),
      proposed_targets_(scene.device(), "path_selection", chains() ? shape_.chains * sizeof(float) : 0),
      chain_states_(scene.device(), "path_selection", chains() ? shape_.chains * sizeof(gpu::PathChain) : 0),
      counts_(scene.device(), "path_selection", PATH_COUNT_WORDS * sizeof(uint32_t)),
      host_counts_(scene.device(), "readback", counts_.bytes(), gpu::MemoryKind::Readback),
      find_candidates_(scene.device(), kFolder + "vpl_points.comp", sizeof(gpu::VplPointsPush)),
      rate_(scene.device(), kFolder + "path_worth.comp", sizeof(gpu::PathWorthPush), &scene.set(),
            scene.specialization()),
      set_choices_(scene.device(), kFolder + "path_choices.comp", 0) {
    const auto make = [&](std::optional<gpu::ComputePipeline>& pipeline, const char* name) {
        pipeline.emplace(scene.device(), kFolder + name, sizeof(gpu::PathSelectionPush));
    };
    if (chains()) {
        make(start_, "path_chain_start.comp");
        make(propose_, "path_propose.comp");
        make(step_, "path_chain_step.comp");
    } else {
        sum_.emplace(scene.device(), pilot.candidates);
        make(accept_, "path_accept.comp");
        make(thin_, "path_thin.comp");
    }
}

uint64_t PathSelectionGpu::device_bytes(VplPlacement placement, uint32_t vpls) {
    constexpr uint32_t kCandidatesAPath = 4;  // of acceptance, about
    const uint64_t candidates = uint64_t{vpls} * (placement == VplPlacement::Acceptance ? kCandidatesAPath : 1);
    return candidates * (sizeof(gpu::VplPath) + 2 * sizeof(float)) + vpls * sizeof(gpu::VplPath);
}

uint64_t PathSelectionGpu::paths_of_piece() const {
    constexpr uint64_t kOfRating = 4;  // a path, and shadow rays of its lights
    return kOfRating * vpls_;
}

gpu::PathSelectionPush PathSelectionGpu::push(uint32_t pass, uint32_t step) const {
    return {.seed = seed_,
            .pass = pass,
            .vpls = vpls_,
            .candidates = pilot_.candidates,
            .levels = targets_.levels(),
            .chains = shape_.chains,
            .states = shape_.states,
            .step = step};
}

void PathSelectionGpu::record(gpu::CommandList& commands, uint32_t pass, uint32_t piece) {
    const gpu::Scope scope(commands, "vpl_generation");
    if (piece < rounds_) return record_candidates(commands, pass, piece);
    const uint32_t step = piece - rounds_;
    if (!chains())
        record_acceptance(commands, pass);
    else if (step == 0)
        record_starts(commands, pass);
    else
        record_step(commands, pass, step);
    if (piece + 1 < pieces()) return;
    tracer_.record_selected(commands, selected_);
    commands.copy(counts_, 0, host_counts_, 0, counts_.bytes());
    commands.host_reads(host_counts_);
}

void PathSelectionGpu::rate(gpu::CommandList& commands, uint32_t pass, gpu::Buffer& paths, uint32_t first,
                            uint32_t count, gpu::Buffer& targets) {
    tracer_.record_rated(commands, paths, first, count);
    commands.bind(rate_, {gpu::read_write("device_counters", counters_), gpu::read("state", tracer_.state()),
                          gpu::read("photons", tracer_.photons()), gpu::read("order", tracer_.order()),
                          gpu::read("first_of_path", tracer_.first_of_path()), gpu::read_write("paths", paths),
                          gpu::read("points", buffer_.points()), gpu::write("targets", targets)});
    commands.push(gpu::PathWorthPush{.seed = seed_,
                                     .pass = pass,
                                     .points = buffer_.layout().points(),
                                     .first = first,
                                     .count = count,
                                     .clamp_sq_m2 = clamp_sq_m2_,
                                     .mean_worth = pilot_.mean_worth});
    commands.dispatch_threads(count, PATH_SELECTION_GROUP);
}

/// Candidates of one round, as many as a pass has paths.
void PathSelectionGpu::record_candidates(gpu::CommandList& commands, uint32_t pass, uint32_t round) {
    if (round == 0) {
        tracer_.record_sums(commands);
        commands.fill(counts_, 0);
        commands.fill(targets_.sums(), 0);
        const uvec2 rotation = tracer_.texel_pass().rotation();
        commands.bind(find_candidates_, {gpu::write("paths", candidates_)});
        commands.push(gpu::VplPointsPush{pilot_.candidates, rotation.x, rotation.y});
        commands.dispatch_threads(pilot_.candidates, PATH_SELECTION_GROUP);
    }
    const uint32_t first = round * vpls_;
    rate(commands, pass, candidates_, first, std::min(vpls_, pilot_.candidates - first), targets_.sums());
}

void PathSelectionGpu::record_acceptance(gpu::CommandList& commands, uint32_t pass) {
    commands.bind(*accept_, {gpu::read("targets", targets_.sums()), gpu::read_write("candidates", candidates_),
                             gpu::write("kept", kept_)});
    commands.push(push(pass, 0));
    commands.dispatch_threads(pilot_.candidates, PATH_SELECTION_GROUP);
    const gpu::DeviceWord count = tracer_.path_count();
    commands.fill(*count.buffer, pilot_.candidates, count.index * sizeof(uint32_t), sizeof(uint32_t));
    sum_->record(commands, kept_, kept_, count, {counts_, PATHS_KEPT});
    commands.bind(*thin_,
                  {gpu::read("candidates", candidates_), gpu::read("ranks", kept_), gpu::read("path_counts", counts_),
                   gpu::write("selected", selected_), gpu::read_write("state", tracer_.state())});
    commands.push(push(pass, 0));
    commands.dispatch_threads(pilot_.candidates, PATH_SELECTION_GROUP);
}

void PathSelectionGpu::record_starts(gpu::CommandList& commands, uint32_t pass) {
    targets_.record_sum(commands);
    commands.fill(selected_, 0);  // what weighs nothing is nothing
    commands.bind(*start_, {gpu::read("flux_sums", targets_.sums()), gpu::read("candidates", candidates_),
                            gpu::write("chains", chain_states_)});
    commands.push(push(pass, 0));
    commands.dispatch_threads(shape_.chains, PATH_SELECTION_GROUP);
}

/// A step of all chains; the last leaves what states they have come to.
void PathSelectionGpu::record_step(gpu::CommandList& commands, uint32_t pass, uint32_t step) {
    if (step < shape_.states) {
        commands.bind(*propose_, {gpu::read_write("chains", chain_states_), gpu::write("proposed", proposed_)});
        commands.push(push(pass, step));
        commands.dispatch_threads(shape_.chains, PATH_SELECTION_GROUP);
        rate(commands, pass, proposed_, 0, shape_.chains, proposed_targets_);
    }
    commands.bind(*step_, {gpu::read_write("chains", chain_states_), gpu::read("proposed", proposed_),
                           gpu::read("targets", proposed_targets_), gpu::write("selected", selected_),
                           gpu::read_write("path_counts", counts_)});
    commands.push(push(pass, step));
    commands.dispatch_threads(shape_.chains, PATH_SELECTION_GROUP);
    const gpu::DeviceWord count = tracer_.path_count();
    commands.fill(*count.buffer, shape_.chains * shape_.states, count.index * sizeof(uint32_t), sizeof(uint32_t));
}

void PathSelectionGpu::record_choices(gpu::CommandList& commands, VplSetGpu& lights) {
    const gpu::Scope scope(commands, "vpl_generation");
    commands.bind(set_choices_, {gpu::read("counts", lights.counts()), gpu::read("order", tracer_.order()),
                                 gpu::read("owners", tracer_.owners()), gpu::read("places", tracer_.places()),
                                 gpu::read("selected", selected_), gpu::read_write("vpls", lights.vpls())});
    commands.dispatch_threads(lights.most(), PATH_SELECTION_GROUP);
}

void PathSelectionGpu::add_to(Counts& counts) const {
    const uint32_t* words = host_counts_.as<uint32_t>().data();
    counts.vpls_offered += chains() ? uint64_t{shape_.chains} * (shape_.states - 1) : pilot_.candidates;
    counts.vpls_accepted += words[chains() ? PATHS_ACCEPTED : PATHS_KEPT];
}

}  // namespace photond
