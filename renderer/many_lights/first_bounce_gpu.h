#pragma once
// What methods have in common that light a G-buffer by what the lights' maps see, on a device alone: the walk from the
// eye, the map of a pass, the merge.

#include <memory>
#include <optional>

#include "renderer/frame/device_frame.h"
#include "renderer/gbuffer/gbuffer_merge_gpu.h"
#include "renderer/many_lights/camera_importance_gpu.h"
#include "renderer/many_lights/incremental_vpls.h"
#include "renderer/many_lights/path_selection_gpu.h"

namespace photond {

struct FirstBounceSettings {
    uint32_t bounces = 1;  // 0: no indirect light
    VplTracing tracing;
    GBufferWalk walk;
    gpu::GeometryFilter filter{};
    std::optional<float> clamp_m2;  // B; none: default_clamp_sq_m2() of tracing.vpls lights
    VplPlacement placement = VplPlacement::Flux;
};

/// Of a method's parameters that have the names of vpl_params.h: `lights` lights a pass, and no split buffer, filter or
/// clamp of its own yet.
template <class Params>
FirstBounceSettings first_bounce_of(const Params& params, uint32_t lights) {
    return {.bounces = params.bounces,
            .tracing = {.vpls = lights,
                        .map_side = params.map_resolution,
                        .bounces = params.bounces,
                        .connect_threshold = params.connect_threshold,
                        .sampler = params.sampler},
            .walk = {.split_side = 1,
                     .max_scatterings = params.bounces + 1,
                     .glossy_threshold = params.glossy_threshold,
                     .sampler = params.sampler}};
}

class FirstBounceGpu {
public:
    /// Appends what comes between the lights' map and the merge: from tracer() to the sums of buffer().
    using AddSteps = DeviceFrame::AddSteps;

    /// A method's begin(). Takes `pass_image` of the host's budget; stages `pipelines`, `rsm`; says what is skipped.
    /// `frames`: where frames hand lights on; null: they do not.
    FirstBounceGpu(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats,
                   VplsBetweenFrames* frames = nullptr);
    ~FirstBounceGpu();
    /// Of the host's memory, and of the device's to a factor of two.
    static uint64_t estimate_bytes(const FirstBounceSettings& settings, const Workload& workload);
    static uint64_t estimate_device_bytes(const FirstBounceSettings& settings, const Workload& workload);
    /// Whether there is indirect light, as far as that is known beforehand.
    static bool may_be_lit(const FirstBounceSettings& settings, const Workload& workload);

    /// Whether there is indirect light to come: what follows is there only then.
    bool lit() const { return tracer_ != nullptr; }
    VplTracerGpu& tracer() { return *tracer_; }
    float clamp_sq_m2() const { return clamp_sq_m2_; }
    /// Appends what leaves the pass's lights in the tracer: the first that light_by() does, but for who takes its
    /// texels.
    void add_vpl_steps(uint32_t pass, DeviceFrame::Steps& steps);
    /// Said once, where lit().
    void light_by(AddSteps add_steps) { light_steps_ = std::move(add_steps); }

    const gpu::DeviceScene& scene() const { return scene_; }
    uint64_t seed() const { return seed_; }
    GBufferGpu& buffer() { return buffer_; }
    gpu::Buffer& counters() { return frame_.image().counters(); }
    DeviceFrame& frame() { return frame_; }

    /// A method's own of that name. `grows`: as DeviceFrame::run_with_room() asks.
    void run_pass(
        uint32_t pass, Stats& stats, const CancelToken& cancel,
        const std::function<bool()>& grows = [] { return false; });

private:
    void find_lights(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats,
                     VplsBetweenFrames* frames);
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);

    const gpu::DeviceScene& scene_;
    const uint64_t seed_;
    DeviceFrame frame_;
    GBufferGpu buffer_;
    GBufferMergeGpu merge_;
    std::optional<EmissionSampler> emission_;
    std::unique_ptr<VplTracerGpu> tracer_;
    std::optional<CameraImportanceGpu> importance_;  // of VplPlacement::Camera
    std::optional<PathSelectionGpu> selection_;      // of placements that select paths
    float clamp_sq_m2_ = 0;
    AddSteps light_steps_;
};

}  // namespace photond
