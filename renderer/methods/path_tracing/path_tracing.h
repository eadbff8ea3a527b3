#pragma once
#include "renderer/frame/method.h"
#include "renderer/methods/path_tracing/params.h"

namespace photond {

/// Path tracing: the reference that every other method is judged by.
///
/// Each pass follows one path from the eye through every pixel. At each vertex direct light is estimated twice, by a
/// point drawn on a light and by the direction the BSDF draws, joined by multiple importance sampling with the power
/// heuristic; Russian roulette on the throughput ends paths without bias. All kinds of lights and materials, thin lens,
/// absorption inside solids (Beer's law), solids within solids.
/// Strong on everything but caustics of small lights, which only chance finds: those converge slowly, and the light of
/// point, spot and directional lights through glass or off mirrors is missing altogether (no path from the eye hits
/// such a light).
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// Paths go in batches: all rays of a tile are traced, then all vertices shaded, then all shadow rays, so that ray
/// packets are full and scenes of plain Lambert surfaces are shaded with vector instructions.
///
/// [Kajiya 1986] The Rendering Equation. SIGGRAPH.
/// [Veach 1997] Robust Monte Carlo Methods for Light Transport Simulation. PhD thesis, Stanford.
class PathTracing final : public Method {
public:
    static constexpr const char* kName = "path_tracing";
    using Params = PathTracingParams;

    explicit PathTracing(const PathTracingParams& params);
    /// What begin() will record, to a few percent.
    static uint64_t estimate_bytes(const PathTracingParams& params, const Workload& workload);
    ~PathTracing() override;

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;

private:
    struct Scratch;  // what a thread needs for the tile it traces

    const PathTracingParams params_;
    std::unique_ptr<const struct PathScene> scene_;
    std::unique_ptr<Scratch> scratch_;
    PassImage image_;
    bool pass_complete_ = false;  // image_ holds a whole pass
};

}  // namespace photond
