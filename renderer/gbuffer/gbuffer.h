#pragma once
// The G-buffer of a pass on the CPU: one visible point a pixel, where the split layout has it. GPU twin:
// gbuffer_gpu.h.

#include <span>
#include <vector>

#include "renderer/eye/specular_walk.h"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/split_buffer.h"

namespace photond {

/// Points of all pixels, kept from pass to pass for its memory.
class GBuffer {
public:
    GBuffer(Size2 size, uint32_t split_side, uint32_t max_scatterings);

    const SplitLayout& layout() const { return layout_; }
    std::span<const gpu::GBufferPoint> points() const { return points_; }
    /// Of a point with GBUFFER_GENERAL.
    const VisiblePoint& general(uint32_t point) const {
        const uint32_t pixel = points_[point].pixel, width = layout_.size.width;
        return general_[tile_of(pixel % width, pixel / width)][slots_[point]];
    }
    uint64_t bytes() const;
    static uint64_t estimate_bytes(Size2 size, const Needs& needs);

    /// Side of the tiles that sinks take.
    static constexpr uint32_t kTileSide = 32;

private:
    friend class GBufferSink;
    uint32_t tile_of(uint32_t x, uint32_t y) const { return y / kTileSide * columns_ + x / kTileSide; }

    const SplitLayout layout_;
    const uint32_t max_scatterings_, columns_;
    std::vector<gpu::GBufferPoint> points_;
    std::vector<uint32_t> slots_;                     // of general points: in their tile's list
    std::vector<std::vector<VisiblePoint>> general_;  // by tile; those that were not kept among them
};

/// Takes the points of one tile after the other, and keeps one a pixel: by weighted reservoir sampling [Chao 1982],
/// in proportion to throughput times the albedo of what waits. One thread's.
class GBufferSink final : public VisiblePointSink {
public:
    /// `tile` has the side kTileSide, but at the border. `walk` is the one that will call take(),
    /// by the numbers of `sampler`.
    void start(const Tile& tile, const SpecularWalk& walk, const PassSampler& sampler, GBuffer& buffer,
               const Camera& camera);
    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override;
    /// After the walk: weights make up for the points that were left out.
    void finish();

private:
    struct Offer {
        vec3 position, normal, geometric_normal;
        Rgb weight;   // as GBufferPoint::weight
        float share;  // what the choice goes by
        uint32_t pixel, scatterings, key, vertex;
    };
    /// Whether the pixel's point is this one now.
    bool offer(const Offer& offered, uint32_t general);

    Tile tile_{};
    const SpecularWalk* walk_ = nullptr;
    const PassSampler* sampler_ = nullptr;
    GBuffer* buffer_ = nullptr;
    std::vector<VisiblePoint>* general_ = nullptr;
    vec3 eye_{0}, forward_{0};
};

}  // namespace photond
