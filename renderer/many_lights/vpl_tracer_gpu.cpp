#include "renderer/many_lights/vpl_tracer_gpu.h"

#include <bit>
#include <numeric>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint64_t kMostUpdate = 64 << 10;  // of CommandList::update()

/// Weak lights that a pass may choose.
uint64_t most_chosen(const TexelMap& map) {
    double expected = 0;
    for (const gpu::TexelRun& weak : map.weak()) expected += double{weak.expected};
    return static_cast<uint64_t>(std::ceil(expected)) + 1;
}

uint32_t levels_of(const VplTracing& tracing) { return static_cast<uint32_t>(std::countr_zero(tracing.map_side)); }

uint64_t most_photons(const VplTracing& tracing) { return most_vpls(tracing.vpls, tracing.bounces); }

}  // namespace

uint64_t VplTracerGpu::device_bytes(const VplTracing& tracing, bool weighted, bool lambert, uint64_t lights) {
    const uint64_t texels = uint64_t{tracing.map_side} * tracing.map_side, photons = most_photons(tracing);
    return (weighted ? 2 : 1) * FluxMapGpu::device_bytes(levels_of(tracing)) +
           (std::min(lights, texels) + 1) * sizeof(gpu::TexelRun) + texels * sizeof(gpu::ReflectedPhotonRecord) +
           photons * (sizeof(gpu::ReflectedPhotonRecord) + sizeof(gpu::PhotonOwner) + sizeof(uint32_t)) +
           (lambert ? 1 : photons) * sizeof(gpu::ReflectingSurfaceRecord) +
           (uint64_t{tracing.vpls} * 5 + 1) * sizeof(uint32_t) +
           tracing.vpls * (sizeof(gpu::VplStart) + sizeof(gpu::VplPath));
}

VplTracerGpu::VplTracerGpu(const gpu::DeviceScene& scene, const EmissionSampler& emission, const VplTracing& tracing,
                           gpu::Buffer& counters, bool weighted, VplBounceShader bounces)
    : device_(scene.device()),
      tracing_(tracing),
      counters_(counters),
      map_(emission, tracing.map_side),
      plain_(device_, map_.levels()),
      runs_(device_, "vpl_texels", (map_.runs().size() + most_chosen(map_)) * sizeof(gpu::TexelRun)),
      texels_(device_, "vpl_texels", uint64_t{map_.texels()} * sizeof(gpu::ReflectedPhotonRecord)),
      state_(device_, "vpls", REFLECTION_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device_, "readback", state_.bytes(), gpu::MemoryKind::Readback),
      photons_(device_, "vpls", most_photons(tracing) * sizeof(gpu::ReflectedPhotonRecord)),
      owners_(device_, "vpls", most_photons(tracing) * sizeof(gpu::PhotonOwner)),
      path_counts_(device_, "vpls", (uint64_t{tracing.vpls} + 1) * sizeof(uint32_t)),
      order_(device_, "vpls", most_photons(tracing) * sizeof(uint32_t)),
      surfaces_(
          device_, "vpls",
          (scene.scene().needs.only_lambert() ? 1 : most_photons(tracing)) * sizeof(gpu::ReflectingSurfaceRecord)),
      chosen_texels_(device_, "vpls", uint64_t{tracing.vpls} * sizeof(uint32_t)),
      places_(device_, "vpls", uint64_t{tracing.vpls} * sizeof(uint32_t)),
      halton_paths_(device_, "vpls", tracing.vpls * sizeof(gpu::VplPath)),
      starts_(device_, "vpls", tracing.vpls * sizeof(gpu::VplStart)),
      bounces_(std::move(bounces)),
      trace_texels_(device_, "renderer/many_lights/vpl_texels.comp", sizeof(gpu::VplTexelsPush), &scene.set(),
                    scene.specialization()),
      mix_(device_, "renderer/many_lights/vpl_mix.comp", sizeof(gpu::VplMixPush)),
      find_points_(device_, "renderer/many_lights/vpl_points.comp", sizeof(gpu::VplPointsPush)),
      choose_(device_, "renderer/many_lights/vpl_choose.comp", sizeof(gpu::VplChoosePush)),
      start_paths_(device_, "renderer/many_lights/vpl_starts.comp", sizeof(gpu::VplStartsPush), &scene.set(),
                   scene.specialization()),
      trace_paths_(device_, bounces_.name, sizeof(gpu::VplPathsPush), &scene.set(), scene.specialization()),
      sort_(device_, "renderer/photons/reflected_photon_order.comp", sizeof(uint32_t)),
      sort_paths_(device_, tracing.vpls),
      sum_(device_, tracing.vpls + 1) {
    if (weighted) weighted_.emplace(device_, map_.levels());
    if (!map_.runs().empty()) gpu::upload(device_, runs_, std::as_bytes(std::span(map_.runs())));
}

void VplTracerGpu::start(uint64_t seed, const ChosenPaths& paths) {
    pass_.emplace(map_, seed, 0);
    given_ = true;
    std::vector<gpu::VplStart> starts(paths.starts.size());
    std::vector<uint32_t> in_order(starts.size());
    std::iota(in_order.begin(), in_order.end(), 0u);
    std::ranges::stable_sort(in_order, {}, [&](uint32_t path) { return paths.order[path]; });
    for (size_t i = 0; i < starts.size(); ++i) {
        const ChosenStart& start = paths.starts[in_order[i]];
        const EmissionSample& first = start.first;
        starts[i] = {first.ray.origin, first.ray.direction, first.power_w,
                     first.range_m,    start.reflected_w,   in_order[i]};
    }
    gpu::upload(device_, starts_, std::as_bytes(std::span(starts)));
}

void VplTracerGpu::start(uint64_t seed, uint32_t pass) {
    if (given_) return;
    pass_.emplace(map_, seed, pass);
    run_count_ = static_cast<uint32_t>(map_.runs().size() + pass_->chosen().size());
}

void VplTracerGpu::record_map(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "rsm");
    std::array<uint32_t, REFLECTION_STATE_WORDS> words{};
    words[REFLECTION_PATHS] = tracing_.vpls;
    commands.update(state_, words);
    if (given_) return;
    const std::span<const std::byte> chosen = std::as_bytes(std::span(pass_->chosen()));
    const uint64_t first = map_.runs().size() * sizeof(gpu::TexelRun);
    for (uint64_t at = 0; at < chosen.size(); at += kMostUpdate)
        commands.update(runs_, chosen.subspan(at, std::min(kMostUpdate, chosen.size() - at)), first + at);

    commands.bind(trace_texels_,
                  {gpu::read_write("device_counters", counters_), gpu::read_write("state", state_),
                   gpu::write("texels", texels_), gpu::write("flux_w", plain_.sums()), gpu::read("texel_runs", runs_)});
    commands.push(gpu::VplTexelsPush{
        .sequence = VplTracer::texel_numbers(tracing_, *pass_).device_key(),
        .texels = map_.texels(),
        .used_texels = pass_->texels(),
        .runs = run_count_,
        .bounces = tracing_.bounces,
        .connect_threshold = tracing_.connect_threshold,
    });
    commands.dispatch_threads(map_.texels(), VPL_GROUP);
    if (weighted_) commands.copy(plain_.sums(), 0, weighted_->sums(), 0, uint64_t{map_.texels()} * sizeof(float));
}

void VplTracerGpu::record_sums(gpu::CommandList& commands) {
    plain_.record_sum(commands);
    if (!weighted_) return;
    weighted_->record_sum(commands);
    commands.bind(mix_, {gpu::read("flux", plain_.sums()), gpu::read_write("weighted", weighted_->sums())});
    commands.push(gpu::VplMixPush{map_.levels(), kPlainFluxShare});
    commands.dispatch_threads(map_.texels(), VPL_GROUP);
    weighted_->record_sum(commands);
}

void VplTracerGpu::record_vpls(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "vpl_generation");
    if (given_) {
        record_traced(commands, tracing_.vpls, false);
        record_state_readback(commands);
        return;
    }
    record_sums(commands);
    const uvec2 rotation = pass_->rotation();
    commands.bind(find_points_, {gpu::write("paths", halton_paths_)});
    commands.push(gpu::VplPointsPush{tracing_.vpls, rotation.x, rotation.y});
    commands.dispatch_threads(tracing_.vpls, VPL_GROUP);
    record_selected(commands, halton_paths_);
}

void VplTracerGpu::record_rated(gpu::CommandList& commands, gpu::Buffer& paths, uint32_t first, uint32_t count) {
    commands.fill(state_, count, REFLECTION_PATHS * sizeof(uint32_t), sizeof(uint32_t));
    record_paths(commands, paths, first, count, true);
}

void VplTracerGpu::record_selected(gpu::CommandList& commands, gpu::Buffer& paths) {
    commands.bind(choose_, {gpu::read("flux_sums", chosen_by().sums()), gpu::write("texel_of_path", chosen_texels_),
                            gpu::write("places", places_), gpu::read("paths", paths), gpu::read("state", state_)});
    commands.push(gpu::VplChoosePush{tracing_.vpls, map_.levels()});
    commands.dispatch_threads(tracing_.vpls, VPL_GROUP);
    sort_paths_.record(commands, chosen_texels_, places_, {state_, REFLECTION_PATHS}, std::max(2 * map_.levels(), 1u));
    record_paths(commands, paths, 0, tracing_.vpls, false);
    record_state_readback(commands);
}

void VplTracerGpu::record_state_readback(gpu::CommandList& commands) {
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

/// What those paths of a list leave; of the pass's in the order of their texels.
void VplTracerGpu::record_paths(gpu::CommandList& commands, gpu::Buffer& paths, uint32_t first, uint32_t count,
                                bool rated) {
    commands.bind(start_paths_, {gpu::read("texel_runs", runs_), gpu::read("flux_sums", chosen_by().sums()),
                                 gpu::read("flux_w", plain_.sums()), gpu::read("places", places_),
                                 gpu::write("starts", starts_), gpu::read("paths", paths), gpu::read("state", state_)});
    commands.push(gpu::VplStartsPush{.sequence = VplTracer::texel_numbers(tracing_, *pass_).device_key(),
                                     .vpls = tracing_.vpls,
                                     .levels = map_.levels(),
                                     .first_path = first,
                                     .paths = count,
                                     .runs = run_count_,
                                     .sorted = rated ? 0u : 1u});
    commands.dispatch_threads(count, VPL_GROUP);
    record_traced(commands, count, rated);
}

/// What so many paths leave, by their first steps.
void VplTracerGpu::record_traced(gpu::CommandList& commands, uint32_t count, bool rated) {
    static_assert(REFLECTION_PHOTONS == 0 && REFLECTION_SURFACES == 1 && REFLECTION_ORDERED == 2);
    commands.fill(state_, 0, 0, 3 * sizeof(uint32_t));
    std::vector<gpu::Binding> bindings = {gpu::read_write("device_counters", counters_),
                                          gpu::read_write("state", state_),
                                          gpu::write("photons", photons_),
                                          gpu::write("owners", owners_),
                                          gpu::write("photons_of_path", path_counts_),
                                          gpu::write("surfaces", surfaces_),
                                          gpu::read("starts", starts_)};
    bindings.insert(bindings.end(), bounces_.bindings.begin(), bounces_.bindings.end());
    commands.bind(trace_paths_, bindings);
    commands.push(gpu::VplPathsPush{
        .sequence = VplTracer::path_numbers(tracing_, *pass_).device_key(),
        .paths = count,
        .bounces = tracing_.bounces,
        .photon_capacity = most_lights(),
        .surface_capacity = static_cast<uint32_t>(surfaces_.bytes() / sizeof(gpu::ReflectingSurfaceRecord)),
        .connect_threshold = tracing_.connect_threshold,
        .rated = rated ? 1u : 0u,
    });
    commands.dispatch_threads(count, VPL_GROUP);

    sum_.record(commands, path_counts_, path_counts_, {state_, REFLECTION_PATHS}, {state_, REFLECTION_ORDERED});
    commands.bind(sort_, {gpu::read("state", state_), gpu::read("owners", owners_),
                          gpu::read("first_of_path", path_counts_), gpu::write("order", order_)});
    commands.push(most_lights());
    commands.dispatch_threads(most_lights(), REFLECTION_GROUP);
}

void VplTracerGpu::add_to(Counts& counts) const {
    const uint32_t* words = host_state_.as<uint32_t>().data();
    counts.nan_samples += words[REFLECTION_NAN_SAMPLES];
    counts.infinite_samples += words[REFLECTION_INFINITE_SAMPLES];
}

}  // namespace photond
