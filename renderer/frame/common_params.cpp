#include "renderer/frame/common_params.h"

#include <string>

#include "protocol/error.h"
#include "protocol/param_info.h"
#include "renderer/transport/sobol.h"

namespace photond {

void visit_sampler(ParamVisitor& visitor, SamplerKind& sampler) {
    static constexpr std::string_view kSamplers[] = {"sobol", "random"};
    visitor.enumeration("sampler", sampler,
                        {ParamGroup::NoiseAndBias, kSamplers,
                         "numbers of the passes: low-discrepancy (Owen-scrambled Sobol') or independent"});
}

void TemporalParams::visit(ParamVisitor& visitor) {
    static constexpr std::string_view kReuses[] = {"none", "reproject"};
    visitor.enumeration(
        "temporal", reuse,
        {ParamGroup::Frames, kReuses,
         "each frame's indirect light stands alone, or is averaged with the last frames' at the same points, where "
         "neither surface nor light changed (reproject): less noise and flicker, and light that lags"});
    visitor.field("history_cap", history_cap,
                  {ParamGroup::Frames, "frames", 1, 1024,
                   "that a pixel's indirect light is the mean of, at most: more are smoother and lag more"});
}

void require_power_of_two(const char* pointer, uint32_t value) {
    if ((value & (value - 1)) != 0)
        throw Error(ErrorCode::OutOfRange, pointer,
                    std::string(pointer + 1) + " = " + std::to_string(value) + " is no power of two");
}

}  // namespace photond
