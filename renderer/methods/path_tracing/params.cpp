#include "renderer/frame/common_params.h"
#include "renderer/methods/path_tracing/path_tracing.h"

namespace photond {

void PathTracingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field("indirect_bounces", indirect_bounces,
                  {Light, "", 0, 1e6, "greatest number of bounces in the indirect layer; unlimited when not given"});
    visit_sampler(visitor, sampler);
    visitor.field("roulette_start", roulette_start,
                  {NoiseAndBias, "", 1, 1e6, "surface interactions after which Russian roulette may end a path"});
}

}  // namespace photond
