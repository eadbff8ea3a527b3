#pragma once
// The parameters of path tracing: each is a field here, and a line of visit().

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/transport/roulette_shared.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// How a GPU's work is laid out: a thread follows a path to its end, or kernels do a step of all paths each
/// (path_wavefront_gpu.h). The image is the same. The wavefront is 1.5 times as fast in `interior` on lavapipe, but its
/// six kernels take seconds longer to compile than the small images of such devices take to render; which is better on
/// a card is still to be measured (photond-gpu-bench runs both).
enum class PathKernels : uint8_t { Mega, Wavefront };

struct PathTracingParams final : MethodParams {
    TemporalParams temporal;
    std::optional<uint32_t> indirect_bounces;
    SamplerKind sampler = SamplerKind::Sobol;
    uint32_t roulette_start = ROULETTE_START;
    PathKernels gpu_kernels = PathKernels::Mega;

    void visit(ParamVisitor& visitor) override;
    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
};

inline void PathTracingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kGpuKernels[] = {"mega", "wavefront"};

    visitor.field("indirect_bounces", indirect_bounces,
                  {Light, "", 0, 1e6, "greatest number of bounces in the indirect layer; unlimited when not given"});
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    visitor.field("roulette_start", roulette_start,
                  {NoiseAndBias, "", 1, 1e6, "surface interactions after which Russian roulette may end a path"});
    visitor.enumeration(
        "gpu_kernels", gpu_kernels,
        {Device, kGpuKernels,
         "a thread follows a path to its end (mega), or kernels do a step of all paths each (wavefront); "
         "the same image, and nothing to the CPU"});
}

}  // namespace photond
