#pragma once
#include "renderer/bidirectional/bidirectional_method.h"

namespace photond {

/// Bidirectional path tracing: each pass follows a path from the eye through every pixel and light paths from the
/// lights, and joins them by all connections, light samples, lights that are met and light paths that the camera sees.
/// All ways to make one path are weighed against each other by multiple importance sampling.
///
/// Unbiased. Strong where light reaches the scene by detours: lamps that are hidden, covered or shine through gaps, and
/// caustics seen directly, which light paths find and the camera sees. Caustics seen in mirrors and through glass
/// converge slowly, and those of point, spot and directional lights seen so are missing altogether.
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Veach and Guibas 1995] Bidirectional Estimators for Light Transport. Photorealistic Rendering Techniques.
/// [Lafortune and Willems 1993] Bi-Directional Path Tracing. Compugraphics.
/// [Davidovic et al. 2014] Progressive Light Transport Simulation on the GPU: the light vertex cache. ACM TOG 33(3).
class BidirectionalPathTracing final : public BidirectionalMethod {
public:
    static constexpr const char* kName = "bidirectional_path_tracing";
    using Params = BidirectionalParams;

    explicit BidirectionalPathTracing(const Params& params) : BidirectionalMethod(std::make_unique<Params>(params)) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return BidirectionalMethod::estimate_bytes(params, workload);
    }
};

}  // namespace photond
