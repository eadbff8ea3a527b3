#pragma once
// A vocabulary of two methods, for tests of who reads requests.

#include "protocol/job.h"

namespace photond::test {

struct TinyParams final : MethodParams {
    uint32_t bounces = 8;
    float radius = 0.05f;
    void visit(ParamVisitor& visitor) override {
        using enum ParamGroup;
        visitor.field("bounces", bounces, {Light, "", 0, 1024, "bounces"});
        visitor.field("radius", radius, {Light, "m", 1e-3, 10, "radius"});
    }
};

inline JobVocabulary job_vocabulary() {
    JobVocabulary known;
    known.method_names = {"path_tracing", "photon_mapping"};
    known.always_layers = {"emitted", "direct", "indirect"};
    known.layer_names = {"caustic", "albedo", "normal", "position", "depth", "standard_error", "photon_count"};
    known.metric_names = {"relative_mse", "rmse", "estimated_relative_mse"};
    known.estimated_metrics = {"estimated_relative_mse"};
    known.radiance_layers = {"emitted", "direct", "indirect", "caustic"};
    known.make_params = [](const std::string&) { return std::make_unique<TinyParams>(); };
    known.devices_of = [](const std::string& method) {
        return method == "path_tracing" ? std::vector<std::string>{"cpu"} : std::vector<std::string>{"cpu", "gpu"};
    };
    known.layers_of = [all = known.layer_names](const std::string& method) {
        return method == "path_tracing" ? std::vector<std::string>(all.begin(), all.end() - 1) : all;
    };
    return known;
}

}  // namespace photond::test
