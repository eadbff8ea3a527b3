#include "renderer/many_lights/vpl_choice_gpu.h"

#include <algorithm>

#include "protocol/error.h"

namespace photond {

namespace {

constexpr uint64_t kMostChosenBytes = 64u << 20;  // more points are chosen for piece by piece

/// Lights or nodes that a point looks at while it chooses, about.
uint64_t looked_at(uint32_t lights, const VplChoiceSettings& settings) {
    constexpr uint64_t kNodesALight = 4;
    return settings.lightcut ? kNodesALight * settings.lights : uint64_t{lights} + settings.lights;
}

/// Of these, what costs a device about what a path does: each is a load and a few products, a path a dozen rays.
constexpr uint64_t kLookedAtAPath = 32;

/// Points that there is room for.
uint64_t roomy_points(uint64_t points, const VplChoiceSettings& settings) {
    const uint64_t most = std::min(kMostChosenBytes / (settings.lights * sizeof(gpu::ChosenVplRecord)), points);
    return std::max<uint64_t>(most / SPLIT_GROUP, 1) * SPLIT_GROUP;
}

uint32_t points_of_piece(const gpu::Device& device, uint64_t points, uint32_t lights,
                         const VplChoiceSettings& settings) {
    const uint64_t by_time = kLookedAtAPath * device.paths_per_submit() / looked_at(lights, settings);
    const uint64_t most = std::min(by_time, roomy_points(points, settings));
    return static_cast<uint32_t>(std::max<uint64_t>(most / SPLIT_GROUP, 1) * SPLIT_GROUP);
}

constexpr uint64_t kChoiceLightBytes = 2 * sizeof(glm::vec4);  // vpl_choice_resampled.comp

/// Nodes of a cut that a thread keeps, where subgroups have at least so many threads.
constexpr uint32_t kLeastSubgroup = 4;
uint32_t nodes_a_thread(const VplChoiceSettings& settings) {
    return settings.lightcut ? (settings.lights + kLeastSubgroup - 1) / kLeastSubgroup : 0;
}

}  // namespace

VplChoiceGpu::VplChoiceGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, VplSetGpu& lights,
                           VplLightingGpu& lighting, gpu::Buffer& counters, VplVisibility visibility,
                           const VplChoiceSettings& settings)
    : settings_(settings),
      buffer_(buffer),
      lights_(lights),
      lighting_(lighting),
      counters_(counters),
      points_at_once_(points_of_piece(scene.device(), buffer.layout().points(), lights.likely(), settings)),
      pieces_((buffer.layout().points() + points_at_once_ - 1) / points_at_once_),
      chosen_(scene.device(), "vpl_choice",
              roomy_points(buffer.layout().points(), settings) * settings.lights * sizeof(gpu::ChosenVplRecord)),
      chosen_counts_(scene.device(), "vpl_choice", roomy_points(buffer.layout().points(), settings) * sizeof(uint32_t)),
      choice_lights_(scene.device(), "vpl_choice", settings.lightcut ? 0 : kChoiceLightBytes * lights.most()),
      cuts_(scene.device(), "vpl_choice",
            roomy_points(buffer.layout().points(), settings) * nodes_a_thread(settings) * sizeof(gpu::CutNode)),
      choose_(scene.device(),
              settings.lightcut ? "renderer/many_lights/vpl_choice_cut.comp"
                                : "renderer/many_lights/vpl_choice_resampled.comp",
              sizeof(gpu::VplChoicePush), &scene.set(), scene.specialization()),
      light_(scene.device(), VplVisibilityGpu::shader("renderer/many_lights/vpl_choice_light", visibility),
             sizeof(gpu::VplChoicePush), &scene.set(), scene.specialization()) {
    if (settings.lightcut && scene.device().limits().subgroup_size < kLeastSubgroup)
        throw Error(ErrorCode::Unsupported, "/vpl_choice",
                    "lightcut needs subgroups of 4 threads, of which this device has " +
                        std::to_string(scene.device().limits().subgroup_size));
    if (settings.lightcut)
        tree_.emplace(scene.device(), lights.most());
    else
        copy_lights_.emplace(scene.device(), "renderer/many_lights/vpl_choice_lights.comp", 0, &scene.set(),
                             scene.specialization());
}

uint64_t VplChoiceGpu::device_bytes(Size2 film_size, uint32_t most_lights, const VplChoiceSettings& settings) {
    const uint64_t a_point = settings.lights * sizeof(gpu::ChosenVplRecord) + sizeof(uint32_t) +
                             nodes_a_thread(settings) * sizeof(gpu::CutNode);
    return roomy_points(SplitLayout(film_size, 1).points(), settings) * a_point +
           (settings.lightcut ? VplTreeGpu::device_bytes(most_lights) : kChoiceLightBytes * most_lights);
}

uint64_t VplChoiceGpu::paths_of_piece() const {
    return points_at_once_ * looked_at(lights_.likely(), settings_) / kLookedAtAPath;
}

void VplChoiceGpu::record_lights(gpu::CommandList& commands) {
    if (tree_) return tree_->record(commands, lights_.vpls(), {lights_.counts(), VPL_COUNT});
    const gpu::Scope scope(commands, "vpl_generation");
    commands.bind(*copy_lights_, {gpu::read("counts", lights_.counts()), gpu::read("vpls", lights_.vpls()),
                                  gpu::write("choice_lights", choice_lights_)});
    commands.dispatch_threads(lights_.most(), VPL_SET_GROUP);
}

void VplChoiceGpu::record(gpu::CommandList& commands, const VplVisibilityGpu& visibility, uint32_t piece) {
    const uint32_t first = piece * points_at_once_;
    const uint32_t end = std::min(first + points_at_once_, buffer_.layout().points());
    const gpu::VplChoicePush push{first, end, points_at_once_, settings_.lights};
    const gpu::Scope scope(commands, "indirect");
    if (tree_)
        commands.bind(choose_, {gpu::read("constants", lighting_.constants()), gpu::read("points", buffer_.points()),
                                gpu::read("counts", lights_.counts()), gpu::write("chosen", chosen_),
                                gpu::write("chosen_counts", chosen_counts_), gpu::read("tree", tree_->nodes()),
                                gpu::read_write("cuts", cuts_)});
    else
        commands.bind(choose_, {gpu::read("constants", lighting_.constants()), gpu::read("points", buffer_.points()),
                                gpu::read("counts", lights_.counts()), gpu::read("choice_lights", choice_lights_),
                                gpu::write("chosen", chosen_), gpu::write("chosen_counts", chosen_counts_)});
    commands.push(push);
    commands.dispatch_threads(end - first, SPLIT_GROUP);

    std::vector<gpu::Binding> bindings = {gpu::read_write("device_counters", counters_),
                                          gpu::read("constants", lighting_.constants()),
                                          gpu::read("points", buffer_.points()),
                                          gpu::read("general_points", buffer_.general()),
                                          gpu::read("vpls", lights_.vpls()),
                                          gpu::read("vpl_lobes", lights_.lobes()),
                                          gpu::read_write("sums", buffer_.sums()),
                                          gpu::read("chosen", chosen_),
                                          gpu::read("chosen_counts", chosen_counts_)};
    visibility.append_to(bindings);
    commands.bind(light_, bindings);
    commands.push(push);
    commands.dispatch_threads(end - first, SPLIT_GROUP);
}

}  // namespace photond
