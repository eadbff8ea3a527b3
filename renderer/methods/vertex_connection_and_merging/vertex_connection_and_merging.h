#pragma once
#include "renderer/bidirectional/bidirectional_method.h"

namespace photond {

struct VertexConnectionAndMergingParams final : BidirectionalParams {
    MergingParams merging_params;

    void visit(ParamVisitor& visitor) override {
        BidirectionalParams::visit(visitor);
        merging_params.visit(visitor);
    }
    void check() const override { merging_params.check(); }
    const MergingParams* merging() const override { return &merging_params; }
};

/// Vertex connection and merging: bidirectional path tracing, and photon mapping as one more way to make a path.
/// Vertices of eye and light paths that lie within a radius are merged; its ways and all others are weighed against
/// each other by multiple importance sampling, so that each path is made by what makes it best. Where few light paths
/// arrive, many pixels merge with the same vertices: `weights` correlation_aware counts merging for less there, which
/// takes blotches away and most of the bias; `interior` has 1.5 times less error by it, and a quarter of the bias.
/// Within which radius is one question for all places, or for each by the light's curvature there (`radius_rule`).
///
/// The most general of the methods: hidden lamps, caustics, and caustics seen in mirrors and through glass. Biased by
/// what it merges: the radius shrinks from pass to pass, and bias with it.
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Georgiev et al. 2012] Light Transport Simulation with Vertex Connection and Merging. ACM TOG 31(6).
/// [Grittmann, Georgiev, Slusallek 2021] Correlation-Aware Multiple Importance Sampling for Bidirectional Rendering
/// Algorithms. Computer Graphics Forum 40(2).
/// [Hachisuka, Pantaleoni, Jensen 2012] A Path Space Extension for Robust Light Transport Simulation. ACM TOG 31(6).
class VertexConnectionAndMerging final : public BidirectionalMethod {
public:
    static constexpr const char* kName = "vertex_connection_and_merging";
    using Params = VertexConnectionAndMergingParams;

    explicit VertexConnectionAndMerging(const Params& params) : BidirectionalMethod(std::make_unique<Params>(params)) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return BidirectionalMethod::estimate_bytes(params, workload);
    }
};

}  // namespace photond
