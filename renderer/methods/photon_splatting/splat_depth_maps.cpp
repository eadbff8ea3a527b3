#include "renderer/methods/photon_splatting/splat_depth_maps.h"

#include <cassert>

#include "renderer/methods/photon_splatting/splat_shared.h"

namespace photond {

namespace {

/// Greatest of each of `count` numbers, `stride` apart, and its two neighbours, in place. Beyond either end they go on
/// by half the last step: as far as the last one's texel reaches. By at most `most_step`, as the step may be one from a
/// surface to another.
void greatest_of_three(float* values, size_t count, size_t stride, float most_step) {
    const auto beyond = [most_step](float last, float before) {
        return last + 0.5f * std::clamp(last - before, 0.0f, most_step);
    };
    const float past_end = beyond(values[(count - 1) * stride], values[(count - 2) * stride]);
    float before = beyond(values[0], values[stride]);
    for (size_t i = 0; i < count; ++i) {
        const float here = values[i * stride];
        const float after = i + 1 < count ? values[(i + 1) * stride] : past_end;
        values[i * stride] = std::max({before, here, after});
        before = here;
    }
}

}  // namespace

SplatDepthMaps::SplatDepthMaps(uint32_t resolution) : resolution_(resolution) {
    assert(resolution >= kLeastResolution && resolution <= kMostResolution);
    const size_t texels = size_t{resolution} * resolution;
    rays_.resize(texels);
    hits_.resize(texels);
}

void SplatDepthMaps::trace(std::span<const SplatFrustum> frusta, const Intersector& intersector, Counts& counts) {
    const size_t texels = rays_.size();
    texels_per_m_.clear();
    farthest_m_.resize(frusta.size() * texels);
    for (size_t i = 0; i < frusta.size(); ++i) {
        const SplatFrustum& frustum = frusta[i];
        assert(frustum.half_side_m > 0 && frustum.depth_m > 0);
        texels_per_m_.push_back(0.5f * static_cast<float>(resolution_) / frustum.half_side_m);
        trace_texels(frustum, intersector);
        spread(frustum, &farthest_m_[i * texels]);
    }
    counts.shadow_rays += frusta.size() * texels;
}

void SplatDepthMaps::trace_texels(const SplatFrustum& frustum, const Intersector& intersector) {
    // One frustum's rays make a batch: 16 to 4096 parallel ones, which fit a cache with their hits.
    const Frame axes = frame(frustum);
    const float texel_m = 2 * frustum.half_side_m / static_cast<float>(resolution_);
    const auto centre_m = [&](uint32_t texel) {
        return (static_cast<float>(texel) + 0.5f) * texel_m - frustum.half_side_m;
    };
    Ray* ray = rays_.data();
    for (uint32_t row = 0; row < resolution_; ++row) {
        const vec3 row_centre = frustum.near_centre + centre_m(row) * axes.bitangent;
        for (uint32_t column = 0; column < resolution_; ++column)
            *ray++ = {row_centre + centre_m(column) * axes.tangent, frustum.axis, frustum.depth_m};
    }
    intersector.closest_hits(rays_, hits_, Coherence::Coherent);
}

void SplatDepthMaps::spread(const SplatFrustum& frustum, float* farthest_m) const {
    // Row by row, then column by column: the greatest of 3x3, and of a plane the greatest within the texel's reach.
    const float texel_m = 2 * frustum.half_side_m / static_cast<float>(resolution_);
    for (size_t i = 0; i < hits_.size(); ++i) farthest_m[i] = std::min(hits_[i].t, frustum.depth_m);
    for (size_t k = 0; k < resolution_; ++k)
        greatest_of_three(farthest_m + k * resolution_, resolution_, 1, SPLAT_MOST_SLOPE * texel_m);
    for (size_t k = 0; k < resolution_; ++k)
        greatest_of_three(farthest_m + k, resolution_, resolution_, SPLAT_MOST_SLOPE * texel_m);
    for (size_t i = 0; i < hits_.size(); ++i) farthest_m[i] += texel_m;
}

uint64_t SplatDepthMaps::bytes_for(size_t frusta, uint32_t resolution) {
    const uint64_t texels = uint64_t{resolution} * resolution;
    // texels_per_m_ grows by doubling.
    return frusta * (texels * sizeof(float) + 2 * sizeof(float)) + texels * (sizeof(Ray) + sizeof(Hit));
}

}  // namespace photond
