#include "renderer/progressive/point_radii_gpu.h"

#include <algorithm>
#include <cmath>

namespace photond {

namespace {

/// The record of a point that was never asked for, as words.
std::vector<float> unknown_point(const ProgressiveParams& params) {
    return with_point_of(params, [](const auto& point) {
        static_assert(sizeof point % sizeof(float) == 0);
        std::vector<float> words(sizeof point / sizeof(float));
        std::ranges::copy(std::as_bytes(std::span(&point, 1)), std::as_writable_bytes(std::span(words)).begin());
        return words;
    });
}

}  // namespace

PointRadiiGpu::PointRadiiGpu(gpu::Device& device, const ProgressiveParams& params, uint64_t pixels,
                             const ProgressivePhotons& photons, const std::string& state)
    : kind_{unknown_point(params).size() * sizeof(float), 1, pixels} {
    const std::vector<float> unknown = unknown_point(params);
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        first_[index_of(kind)] = last_.size();
        if (!photons.wanted(kind)) continue;
        words_[index_of(kind)] = pixels * unknown.size();
        for (uint64_t pixel = 0; pixel < pixels; ++pixel) last_.insert(last_.end(), unknown.begin(), unknown.end());
    }
    if (!state.empty()) {
        PerMap<std::span<std::byte>> points;
        for (size_t map = 0; map < points.size(); ++map)
            points[map] = std::as_writable_bytes(std::span(last_).subspan(first_[map], words_[map]));
        restore_points(state, kind_, points);
    }
    resolved_ = last_;
    const uint64_t bytes = last_.size() * sizeof(float);
    for (gpu::Buffer& points : points_) points = gpu::Buffer(device, "radii", bytes);
    host_points_ = gpu::Buffer(device, "readback", bytes, gpu::MemoryKind::Readback);
    gpu::upload(device, before(), std::as_bytes(std::span(last_)));
}

std::span<const float> PointRadiiGpu::of(const std::vector<float>& words, PhotonMapKind kind) const {
    return std::span(words).subspan(first_[index_of(kind)], words_[index_of(kind)]);
}

std::optional<float> PointRadiiGpu::mean_radius_m(PhotonMapKind kind) const {
    const std::span<const float> words = of(last_, kind);
    double sum = 0;
    uint64_t known = 0;
    for (size_t at = 0; at < words.size(); at += kind_.point_bytes / sizeof(float)) {
        if (!(words[at] > 0)) continue;
        sum += std::log(double{words[at]});
        ++known;
    }
    if (known == 0) return std::nullopt;
    return static_cast<float>(std::exp(sum / static_cast<double>(known)));
}

void PointRadiiGpu::begin_pass(uint32_t pass) {
    if (ended_ && *ended_ != pass) {
        before_ = 1 - before_;
        ended_.reset();
    }
    begun_ = pass;
}

void PointRadiiGpu::record_readback(gpu::CommandList& commands) {
    commands.copy(after(), 0, host_points_, 0, after().bytes());
    commands.host_reads(host_points_);
}

void PointRadiiGpu::end_pass() {
    const std::span<const float> words = host_points_.as<const float>();
    last_.assign(words.begin(), words.end());
    ended_ = begun_;
}

void PointRadiiGpu::resolve() { resolved_ = last_; }

std::string PointRadiiGpu::state() const {
    PerMap<std::span<const std::byte>> points;
    for (const PhotonMapKind kind : kPhotonMapKinds) points[index_of(kind)] = std::as_bytes(of(resolved_, kind));
    return save_points(kind_, points);
}

}  // namespace photond
