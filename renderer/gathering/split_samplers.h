#pragma once
// The numbers of vertices at which a path splits: into gather rays, or into light samples.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "renderer/core/rgb.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// How many of `all` samples a vertex gets: all for light that reaches the eye unweakened; fewer, in proportion, behind
/// dim reflections. `throughput` and `eta_scale` as in EyePath.
inline uint32_t split_of(uint32_t all, const Rgb& throughput, float eta_scale) {
    const auto most = static_cast<float>(all);
    return static_cast<uint32_t>(std::clamp(std::ceil(most * max_component(throughput) * eta_scale), 1.0f, most));
}

/// The numbers of one pass for vertices with up to N samples each. Sample i is element pass * N + i of every vertex's
/// sequence: the samples of a pass are stratified, and so are those of all passes together.
class SplitSamplers {
public:
    SplitSamplers(SamplerKind kind, uint64_t seed, uint32_t pass, uint32_t samples) {
        samplers_.reserve(samples);
        for (uint32_t i = 0; i < samples; ++i)
            samplers_.emplace_back(kind, seed, RandomDomain::Camera, pass * samples + i);
    }

    const PassSampler& operator[](size_t sample) const { return samplers_[sample]; }
    std::span<const PassSampler> all() const { return samplers_; }
    size_t size() const { return samplers_.size(); }
    static uint64_t bytes_for(uint32_t samples) {
        return samples * (sizeof(PassSampler) + PassSampler::kPreparedSets * 16ull);
    }

private:
    std::vector<PassSampler> samplers_;
};

/// The samplers of one pass.
struct PassSamplers {
    PassSampler path;     // of eye paths: one element
    SplitSamplers light;  // of light samples at their vertices
    SplitSamplers gather;
};

}  // namespace photond
