#include "renderer/error/flip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>

#include "renderer/core/huge_pages.h"
#include "renderer/core/lane_math.h"
#include "renderer/core/parallel.h"
#include "renderer/error/flip_exposures.h"
#include "renderer/error/flip_features.h"

namespace photond {

namespace {

/// Rows that one task goes down; before the first it filters as many more as the filters reach.
constexpr uint32_t kStripRows = 64;

/// The error of each pixel of a row from the features of two images [Andersson et al. 2020, Sec. 4].
[[gnu::flatten]] void compare_rows(const float* p, const float* q, size_t plane_floats, float* error) {
    namespace stdx = std::experimental;
    constexpr float kInvSqrt2 = 0.70710678118654752f;
    for (size_t x = 0; x < plane_floats; x += kLanes) {
        const auto load = [&](const float* features, size_t plane) {
            return FloatLanes(features + plane * plane_floats + x, stdx::element_aligned);
        };
        const FloatLanes color = color_error(hyab({load(p, 0), load(p, 1), load(p, 2)},  //
                                                  {load(q, 0), load(q, 1), load(q, 2)}));
        const FloatLanes edge = stdx::abs(load(p, 3) - load(q, 3)), point = stdx::abs(load(p, 4) - load(q, 4));
        // qf = 1/2; strengths are at most sqrt 2, up to rounding.
        const FloatLanes feature = stdx::sqrt(stdx::min(kInvSqrt2 * stdx::max(edge, point), FloatLanes(1.0f)));
        stdx::min(power(color, 1.0f - feature), FloatLanes(1.0f)).copy_to(error + x, stdx::element_aligned);
    }
}

double mean_of_rows(const std::vector<double>& row_sums, Size2 size) {
    return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / static_cast<double>(size.pixels());
}

}  // namespace

struct Flip::Impl {
    Size2 size;
    FlipFilters filters;
    std::vector<float> exposures;
    bool tone_mapped;
    size_t row_floats;        // of a row's features
    size_t cached_exposures;  // the first of them
    std::vector<float> cache;
    std::vector<float> reference;  // where not all exposures are in the cache

    Impl(Size2 image_size, std::span<const float> image, FlipRange range, float pixels_per_degree, uint64_t cache_bytes)
        : size(image_size),
          filters(make_flip_filters(double{pixels_per_degree})),
          exposures(range == FlipRange::Hdr ? flip_exposures(image) : std::vector<float>{0.0f}),
          tone_mapped(range == FlipRange::Hdr),
          row_floats(FeatureRow::floats(size.width)),
          cached_exposures(std::min<size_t>(exposures.size(), cache_bytes / exposure_bytes())) {
        cache.reserve(cached_exposures * exposure_floats());
        prefer_huge_pages(cache.data(), cache.capacity() * sizeof(float));
        cache.resize(cached_exposures * exposure_floats());
        if (cached_exposures < exposures.size()) reference.assign(image.begin(), image.end());
        fill_cache(image);
    }

    size_t exposure_floats() const { return row_floats * size.height; }
    size_t exposure_bytes() const { return exposure_floats() * sizeof(float); }
    float* cached_row(size_t exposure, uint32_t y) {
        return cache.data() + exposure * exposure_floats() + y * row_floats;
    }
    const float* cached_row(size_t exposure, uint32_t y) const {
        return const_cast<Impl*>(this)->cached_row(exposure, y);
    }

    std::optional<float> tone_mapped_exposure(size_t exposure) const {
        return tone_mapped ? std::optional(exposures[exposure]) : std::nullopt;
    }
    size_t strips() const { return (size.height + kStripRows - 1) / kStripRows; }

    void fill_cache(std::span<const float> image) {
        parallel_for(strips() * cached_exposures, 1, [&](size_t task) {
            const size_t exposure = task / strips();
            const auto first = static_cast<uint32_t>(task % strips() * kStripRows);
            FeatureScan scan(filters, size);
            scan.start(image, tone_mapped_exposure(exposure), first);
            const uint32_t end = std::min(first + kStripRows, size.height);
            for (uint32_t y = first; y < end; ++y) scan.next_row(cached_row(exposure, y));
        });
    }

    /// The largest error over the exposures, of rows [first, end), and each row's sum.
    void measure_strip(std::span<const float> image, uint32_t first, uint32_t end, FlipMap& map,
                       std::vector<double>& row_sums) const;
};

void Flip::Impl::measure_strip(std::span<const float> image, uint32_t first, uint32_t end, FlipMap& map,
                               std::vector<double>& row_sums) const {
    FeatureScan scan(filters, size);
    std::optional<FeatureScan> reference_scan;
    if (cached_exposures < exposures.size()) reference_scan.emplace(filters, size);
    std::vector<float> features(row_floats), reference_features(row_floats);
    std::vector<float> errors(FeatureRow::plane_floats(size.width));
    for (size_t exposure = 0; exposure < exposures.size(); ++exposure) {
        const bool cached = exposure < cached_exposures;
        scan.start(image, tone_mapped_exposure(exposure), first);
        if (!cached) reference_scan->start(reference, tone_mapped_exposure(exposure), first);
        for (uint32_t y = first; y < end; ++y) {
            scan.next_row(features.data());
            if (!cached) reference_scan->next_row(reference_features.data());
            const float* other = cached ? cached_row(exposure, y) : reference_features.data();
            compare_rows(features.data(), other, errors.size(), errors.data());
            float* row = map.values.data() + size_t{y} * size.width;
            for (size_t x = 0; x < size.width; ++x) row[x] = std::max(row[x], errors[x]);
        }
    }
    for (uint32_t y = first; y < end; ++y) {
        const float* row = map.values.data() + size_t{y} * size.width;
        row_sums[y] = std::accumulate(row, row + size.width, 0.0);
    }
}

Flip::Flip(Size2 size, std::span<const float> reference, FlipRange range, float pixels_per_degree,
           uint64_t cache_bytes) {
    assert(size.pixels() > 0 && reference.size() == 3 * size.pixels());
    impl_ = std::make_unique<const Impl>(size, reference, range, pixels_per_degree, cache_bytes);
}

Flip::~Flip() = default;

FlipMap Flip::measure(std::span<const float> image) const {
    const Size2 size = impl_->size;
    assert(image.size() == 3 * size.pixels());
    FlipMap map{std::vector<float>(size.pixels()), 0};
    std::vector<double> row_sums(size.height);
    parallel_for(impl_->strips(), 1, [&](size_t strip) {
        const auto first = static_cast<uint32_t>(strip * kStripRows);
        impl_->measure_strip(image, first, std::min(first + kStripRows, size.height), map, row_sums);
    });
    map.mean = mean_of_rows(row_sums, size);
    return map;
}

const std::vector<float>& Flip::exposures() const { return impl_->exposures; }

uint64_t Flip::bytes() const { return (impl_->cache.size() + impl_->reference.size()) * sizeof(float); }

FlipPool pool_flip(std::span<const float> map) {
    if (map.empty()) return {};
    std::vector<float> sorted(map.begin(), map.end());
    std::sort(sorted.begin(), sorted.end());
    std::vector<double> below(sorted.size());  // weight of the values up to each
    std::inclusive_scan(sorted.begin(), sorted.end(), below.begin(), std::plus<>(), 0.0);
    const auto weighted = [&](double share) {
        const auto reached = std::lower_bound(below.begin(), below.end(), share * below.back());
        return double{sorted[static_cast<size_t>(reached - below.begin())]};
    };
    return {.mean = below.back() / static_cast<double>(map.size()),
            .weighted_first_quartile = weighted(0.25),
            .weighted_median = weighted(0.5),
            .weighted_third_quartile = weighted(0.75),
            .minimum = sorted.front(),
            .maximum = sorted.back()};
}

}  // namespace photond
