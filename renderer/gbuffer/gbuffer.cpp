#include "renderer/gbuffer/gbuffer.h"

namespace photond {

GBuffer::GBuffer(Size2 size, uint32_t split_side, uint32_t max_scatterings)
    : layout_(size, split_side),
      max_scatterings_(max_scatterings),
      columns_((size.width + kTileSide - 1) / kTileSide),
      points_(layout_.points()),
      slots_(layout_.points()),
      general_(size_t{columns_} * ((size.height + kTileSide - 1) / kTileSide)) {}

uint64_t GBuffer::bytes() const {
    uint64_t bytes = points_.size() * (sizeof(gpu::GBufferPoint) + sizeof(uint32_t));
    for (const std::vector<VisiblePoint>& tile : general_) bytes += tile.capacity() * sizeof(VisiblePoint);
    return bytes;
}

uint64_t GBuffer::estimate_bytes(Size2 size, const Needs& needs) {
    constexpr double kSlack = 1.3;  // of lists that grow by doubling
    const double general = needs.only_lambert() ? 0 : kSlack * sizeof(VisiblePoint);
    return static_cast<uint64_t>(static_cast<double>(size.pixels()) *
                                 (sizeof(gpu::GBufferPoint) + sizeof(uint32_t) + general));
}

void GBufferSink::start(const Tile& tile, const SpecularWalk& walk, const PassSampler& sampler, GBuffer& buffer,
                        const Camera& camera) {
    tile_ = tile;
    walk_ = &walk;
    sampler_ = &sampler;
    buffer_ = &buffer;
    eye_ = camera.position, forward_ = camera.forward;
    general_ = &buffer.general_[buffer.tile_of(tile.x0, tile.y0)];
    general_->clear();
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x) {
            gpu::GBufferPoint& point = buffer.points_[buffer.layout_.point_of(x, y)];
            point = {};
            point.pixel = y * buffer.layout_.size.width + x;
        }
    }
}

void GBufferSink::take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) {
    for (const LambertVisiblePoint& point : lambert) {
        offer({.position = point.position,
               .normal = point.normal,
               .geometric_normal = point.geometric_normal,
               .weight = point.weight * kInvPi,
               .share = max_component(point.weight),
               .pixel = point.pixel,
               .scatterings = point.scatterings,
               .key = walk_->path_key(point),
               .vertex = walk_->vertex()},
              0);
    }
    for (const VisiblePoint& point : others) {
        const bool both_sides = point.rough.has_non_delta_transmission();
        const uint32_t slot = static_cast<uint32_t>(general_->size());
        const bool kept = offer({.position = point.surface.position,
                                 .normal = both_sides ? vec3(0) : point.surface.shading.normal,
                                 .geometric_normal = point.surface.geometric_normal,
                                 .weight = point.throughput,
                                 .share = max_component(point.throughput * point.rough.albedo()),
                                 .pixel = point.pixel,
                                 .scatterings = point.scatterings,
                                 .key = point.path_key,
                                 .vertex = point.vertex},
                                GBUFFER_GENERAL);
        if (!kept) continue;
        const uint32_t width = buffer_->layout_.size.width;
        buffer_->slots_[buffer_->layout_.point_of(point.pixel % width, point.pixel / width)] = slot;
        general_->push_back(point);
    }
}

bool GBufferSink::offer(const Offer& offered, uint32_t general) {
    if (!(offered.share > 0)) return false;
    const uint32_t width = buffer_->layout_.size.width;
    gpu::GBufferPoint& point =
        buffer_->points_[buffer_->layout_.point_of(offered.pixel % width, offered.pixel / width)];
    point.total += offered.share;
    if (point.kind != 0) {  // by a number that the walk leaves over
        const float u = sampler_->sample_2d(offered.key, sample_set(offered.vertex, VertexSet::Lobe)).y;
        if (!(u * point.total < offered.share)) return false;
    }
    const uint32_t most = buffer_->max_scatterings_ - std::min(buffer_->max_scatterings_, offered.scatterings + 1);
    point.position = offered.position;
    point.kind = GBUFFER_POINT | general | std::min(most, GBUFFER_SCATTERINGS);
    point.normal = offered.normal;
    point.depth_m = glm::dot(offered.position - eye_, forward_);
    point.geometric_normal = offered.geometric_normal;
    point.weight = offered.weight * (1 / offered.share);
    return true;
}

void GBufferSink::finish() {
    for (uint32_t y = tile_.y0; y < tile_.y1; ++y) {
        for (uint32_t x = tile_.x0; x < tile_.x1; ++x) {
            gpu::GBufferPoint& point = buffer_->points_[buffer_->layout_.point_of(x, y)];
            if (point.kind != 0) point.weight *= point.total;
        }
    }
}

}  // namespace photond
