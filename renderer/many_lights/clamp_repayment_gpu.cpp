#include "renderer/many_lights/clamp_repayment_gpu.h"

#include <algorithm>

#include "renderer/many_lights/vpl_lighting_shared.h"

namespace photond {

namespace {

std::vector<gpu::Specialization> constants_of(const gpu::DeviceScene& scene, const RepaymentAsks& asks, bool caustics) {
    return scene.specialization(std::vector{gpu::specialize(CLAMP_IS_ASKED_ID, asks.clamped),
                                            gpu::specialize(CLAMP_IS_REPAID_ID, asks.clamped && asks.repaid),
                                            gpu::specialize(NARROW_IS_ASKED_ID, asks.narrow),
                                            gpu::specialize(CAUSTICS_ARE_PHOTONS_ID, caustics),
                                            gpu::specialize(SEARCH_NEAREST_ID, false)});
}

}  // namespace

ClampRepaymentGpu::ClampRepaymentGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, DeviceImage& image,
                                     uint64_t seed, SamplerKind sampler, const RepaymentAsks& asks,
                                     CausticPhotonsGpu* caustics)
    : buffer_(buffer),
      image_(image),
      caustics_(caustics),
      no_caustics_(scene.device()),
      seed_(seed),
      sampler_kind_(sampler),
      points_at_once_(std::max(scene.device().paths_per_submit() / SPLIT_GROUP, 1u) * SPLIT_GROUP),
      pieces_((buffer.layout().points() + points_at_once_ - 1) / points_at_once_),
      sampler_(scene.device(), "sampler", sizeof(gpu::PassSamplerData)),
      pipeline_(scene.device(), "renderer/many_lights/clamp_repayment.comp", sizeof(gpu::PointPush), &scene.set(),
                constants_of(scene, asks, caustics != nullptr)) {}

void ClampRepaymentGpu::record(gpu::CommandList& commands, gpu::Buffer& constants, uint32_t pass, uint32_t piece) {
    if (piece == 0)
        commands.update(sampler_, PassSampler(sampler_kind_, seed_, RandomDomain::Splats, pass).device_data());
    const uint32_t first = piece * points_at_once_, end = std::min(first + points_at_once_, buffer_.layout().points());
    const gpu::Scope scope(commands, "repay");
    std::vector<gpu::Binding> bindings = {gpu::read_write("device_layers", image_.layers()),
                                          gpu::read_write("device_counters", image_.counters()),
                                          gpu::read("eye", buffer_.eye()),
                                          gpu::read("pass_sampler", sampler_),
                                          gpu::read("constants", constants),
                                          gpu::read("points", buffer_.points()),
                                          gpu::read("general_points", buffer_.general()),
                                          gpu::read_write("sums", buffer_.sums())};
    if (caustics_)
        caustics_->append_to(bindings);
    else
        no_caustics_.append_to(bindings);
    commands.bind(pipeline_, bindings);
    commands.push(gpu::PointPush{first, end});
    commands.dispatch_threads(end - first, SPLIT_GROUP);
}

}  // namespace photond
