#include "renderer/film/film.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <mutex>
#include <type_traits>

#include "protocol/error.h"
#include "renderer/core/huge_pages.h"
#include "renderer/core/parallel.h"
#include "renderer/core/sha256.h"

namespace photond {

namespace {

constexpr size_t kGrainPixels = 2048;
constexpr uint32_t kMagnitudeBits = 0x7fffffffu;
constexpr uint32_t kLimitBits = std::bit_cast<uint32_t>(kFilmValueLimit);
constexpr uint32_t kInfinityBits = 0x7f800000u;
constexpr FixedSquares kSaturated = ~FixedSquares{0};

/// x / 2^-64, cut to a whole number; 0 <= x < 2^63. By the processor's own conversions, without branches: what lies
/// before the point, then what it leaves, which is exact.
inline FixedSquares to_fixed_squares(double x) {
    const int64_t whole = static_cast<int64_t>(x);
    const double rest = x - static_cast<double>(whole);
    return FixedSquares{static_cast<uint64_t>(whole)} << 64 | static_cast<uint64_t>(0x1p64 * rest);
}

/// x / 2^-64, cut to a whole number; |x| < kFilmValueLimit.
inline FixedSum to_fixed(float x) {
    const FixedSum magnitude = static_cast<FixedSum>(to_fixed_squares(std::fabs(double{x})));
    return std::signbit(x) ? -magnitude : magnitude;
}

inline void add_saturating(FixedSquares& sum, FixedSquares more) {
    const FixedSquares total = sum + more;
    sum = total < sum ? kSaturated : total;
}

inline void add_square(FixedSquares& sum, double value) { add_saturating(sum, to_fixed_squares(value * value)); }

inline uint32_t magnitude_bits(const Rgb& c) {
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x) & kMagnitudeBits; };
    return std::max({bits(c.x), bits(c.y), bits(c.z)});
}

inline void add_rgb(FixedSum* sums, const Rgb& c) {
    for (int k = 0; k < 3; ++k) sums[k] += to_fixed(c[k]);
}

/// To a pixel's sums, and to those over the image.
inline void add_rgb(FixedSum* sums, PassMeans::Sum& image, const Rgb& c) {
    for (size_t k = 0; k < 3; ++k) {
        const FixedSum value = to_fixed(c[static_cast<int>(k)]);
        sums[k] += value, image[k] += value;
    }
}

inline void add_squares(FixedSquares* sums, const Rgb& c) {
    for (int k = 0; k < 3; ++k) add_square(sums[k], double{c[k]});
}

double to_double(FixedSum sum) { return 0x1p-64 * nearest_double(sum); }

/// Of n values: their sum, their squares' sum, cut to 2^-64 each.
double variance_of_squares(FixedSum sum, FixedSquares squares, uint32_t n) {
    if (squares == kSaturated) return std::numeric_limits<double>::infinity();
    WideSquares n_squares = times(squares, n);  // in units of 2^-64
    n_squares = {n_squares.high << 64 | n_squares.low >> 64, n_squares.low << 64};
    return variance_of(sum, n_squares, n);
}

/// Layers of one kind that a film keeps: where a pass's values are, and where they are summed.
template <class Value>
class LayerPixels {
public:
    void add(FixedSum* sums, const Value* values) { layers_[count_++] = {sums, values}; }
    template <class Function>
    void each(const Function& function) const {
        for (size_t i = 0; i < count_; ++i) function(layers_[i].sums, layers_[i].values);
    }

private:
    struct {
        FixedSum* sums;
        const Value* values;
    } layers_[kLayerCount];
    size_t count_ = 0;
};

template <class Function>
std::vector<float> per_channel(size_t count, const Function& value) {
    std::vector<float> pixels(count);
    parallel_for(count, kGrainPixels, [&](size_t i) { pixels[i] = static_cast<float>(value(i)); });
    return pixels;
}

/// A film is touched for the first time here, page after page: with small ones that takes longer than its zeros do.
template <class Fixed>
void fill_with_zeros(std::vector<Fixed>& values, size_t count) {
    values.reserve(count);
    prefer_huge_pages(values.data(), count * sizeof(Fixed));
    values.assign(count, 0);
}

}  // namespace

PassImage::PassImage(Size2 image_size, LayerSet layer_set) : size(image_size), layers(layer_set) {
    for (const LayerInfo& info : kLayers) {
        if (!layers.has_in_passes(info.layer)) continue;
        const auto i = static_cast<size_t>(info.layer);
        if (info.channel_count() == 1)
            values_[i].assign(size.pixels(), 0.0f);
        else
            colors_[i].assign(size.pixels(), Rgb(0));
    }
    if (layers.needs_hits()) hit.assign(size.pixels(), 0);
}

void PassImage::clear(size_t first_pixel, size_t pixels) {
    const auto clear = [&]<class Value>(std::vector<Value>& values) {
        std::fill_n(values.begin() + static_cast<ptrdiff_t>(first_pixel), pixels, Value(0));
    };
    each_layer([&](const LayerInfo&, auto& layer) { clear(layer); });
    if (!hit.empty()) clear(hit);
}

uint64_t PassImage::bytes_for(Size2 size, LayerSet layers) {
    uint64_t bytes_a_pixel = layers.needs_hits() ? 1 : 0;
    for (const LayerInfo& info : kLayers)
        if (layers.has_in_passes(info.layer)) bytes_a_pixel += info.channel_count() * sizeof(float);
    return bytes_a_pixel * size.pixels();
}

Film::Film(Size2 size, LayerSet layers, uint32_t first_pass) : size_(size), layers_(layers), next_pass_(first_pass) {
    const size_t n = size.pixels();
    for (const LayerInfo& info : kLayers)
        if (layers.has_in_passes(info.layer))
            fill_with_zeros(sums_[static_cast<size_t>(info.layer)], n * info.channel_count());
    for (auto* squares : {&squares_beauty_, &squares_direct_, &squares_indirect_}) fill_with_zeros(*squares, 3 * n);
    if (layers.needs_hits()) hits_.assign(n, 0);
}

uint64_t Film::bytes_for(Size2 size, LayerSet layers) {
    uint64_t bytes_a_pixel = 9 * sizeof(FixedSquares) + (layers.needs_hits() ? sizeof(uint32_t) : 0);
    for (const LayerInfo& info : kLayers)
        if (layers.has_in_passes(info.layer)) bytes_a_pixel += info.channel_count() * sizeof(FixedSum);
    return bytes_a_pixel * size.pixels();
}

void Film::add_pass(const PassImage& pass) {
    assert(pass.size == size_ && pass.layers == layers_ && "a pass has its film's size and layers");
    const auto sums = [&](Layer layer) { return sums_[static_cast<size_t>(layer)].data(); };
    const bool auxiliary = layers_.needs_hits();
    // Those beside the beauty's parts: of all pixels, and of pixels that were hit.
    LayerPixels<Rgb> rgb_layers[2];
    LayerPixels<float> single_layers[2];
    pass.each_layer([&]<class Value>(const LayerInfo& info, const std::vector<Value>& pixels) {
        if (info.layer == Layer::Emitted || info.layer == Layer::Direct || info.layer == Layer::Indirect) return;
        const size_t kind = info.mean == LayerMean::Hits ? 1 : 0;
        if constexpr (std::is_same_v<Value, Rgb>)
            rgb_layers[kind].add(sums(info.layer), pixels.data());
        else
            single_layers[kind].add(sums(info.layer), pixels.data());
    });
    const std::vector<Rgb>& pass_emitted = pass.of<Layer::Emitted>();
    const std::vector<Rgb>& pass_direct = pass.of<Layer::Direct>();
    const std::vector<Rgb>& pass_indirect = pass.of<Layer::Indirect>();
    FixedSum* const emitted_sums = sums(Layer::Emitted);
    FixedSum* const direct_sums = sums(Layer::Direct);
    FixedSum* const indirect_sums = sums(Layer::Indirect);

    std::atomic<uint64_t> nan_count{0}, infinity_count{0};
    std::mutex image_mutex;
    PassMeans::Sum image_emitted{}, image_direct{}, image_indirect{};  // over the pixels that are not dropped
    const auto add_range = [&](const tbb::blocked_range<size_t>& range) {
        uint64_t nans = 0, infinities = 0;
        PassMeans::Sum emitted_sum{}, direct_sum{}, indirect_sum{};
        for (size_t i = range.begin(); i != range.end(); ++i) {
            const Rgb emitted = pass_emitted[i], direct = pass_direct[i], indirect = pass_indirect[i];
            const uint32_t emitted_bits = magnitude_bits(emitted), direct_bits = magnitude_bits(direct);
            const uint32_t indirect_bits = magnitude_bits(indirect);
            uint32_t worst = std::max({emitted_bits, direct_bits, indirect_bits});
            const bool hit = auxiliary && pass.hit[i];
            for (int kind = 0; kind <= (hit ? 1 : 0); ++kind) {
                rgb_layers[kind].each([&](FixedSum*, const Rgb* v) { worst = std::max(worst, magnitude_bits(v[i])); });
                single_layers[kind].each([&](FixedSum*, const float* v) {
                    worst = std::max(worst, std::bit_cast<uint32_t>(v[i]) & kMagnitudeBits);
                });
            }
            if (worst >= kLimitBits) {
                ++(worst > kInfinityBits ? nans : infinities);
                continue;
            }
            if (emitted_bits) add_rgb(emitted_sums + 3 * i, emitted_sum, emitted);
            if (direct_bits) {
                add_rgb(direct_sums + 3 * i, direct_sum, direct);
                add_squares(&squares_direct_[3 * i], direct);
            }
            if (indirect_bits) {
                add_rgb(indirect_sums + 3 * i, indirect_sum, indirect);
                add_squares(&squares_indirect_[3 * i], indirect);
            }
            if (emitted_bits | direct_bits | indirect_bits)
                for (int k = 0; k < 3; ++k)
                    add_square(squares_beauty_[3 * i + static_cast<size_t>(k)],
                               double{emitted[k]} + double{direct[k]} + double{indirect[k]});
            if (hit) ++hits_[i];
            for (int kind = 0; kind <= (hit ? 1 : 0); ++kind) {
                rgb_layers[kind].each([&](FixedSum* to, const Rgb* v) {
                    if (!is_black(v[i])) add_rgb(to + 3 * i, v[i]);
                });
                single_layers[kind].each([&](FixedSum* to, const float* v) { to[i] += to_fixed(v[i]); });
            }
        }
        nan_count += nans, infinity_count += infinities;
        const std::lock_guard lock(image_mutex);
        for (size_t k = 0; k < 3; ++k)
            image_emitted[k] += emitted_sum[k], image_direct[k] += direct_sum[k], image_indirect[k] += indirect_sum[k];
    };
    tbb::parallel_for(tbb::blocked_range<size_t>(0, size_.pixels(), kGrainPixels), add_range);
    nan_count_ += nan_count, infinity_count_ += infinity_count;
    pass_means_.add(image_emitted, image_direct, image_indirect, size_.pixels());
    pass_ranges_.add(next_pass_++);
    ++passes_;
}

void Film::merge(const Film& other) {
    if (other.size_ != size_)
        throw Error(ErrorCode::Conflict,
                    "films of " + std::to_string(size_.width) + " x " + std::to_string(size_.height) + " and " +
                        std::to_string(other.size_.width) + " x " + std::to_string(other.size_.height) + " pixels");
    if (other.layers_ != layers_) throw Error(ErrorCode::Conflict, "films with different layers");
    if (uint64_t{passes_} + other.passes_ > UINT32_MAX)
        throw Error(ErrorCode::OutOfRange, "more passes than a film can hold");
    pass_ranges_.add(other.pass_ranges_);
    const auto add_sums = [](std::vector<FixedSum>& sums, const std::vector<FixedSum>& more) {
        parallel_for(sums.size(), kGrainPixels, [&](size_t i) { sums[i] += more[i]; });
    };
    const auto add_squares = [](std::vector<FixedSquares>& sums, const std::vector<FixedSquares>& more) {
        parallel_for(sums.size(), kGrainPixels, [&](size_t i) { add_saturating(sums[i], more[i]); });
    };
    for (size_t i = 0; i < kLayerCount; ++i) add_sums(sums_[i], other.sums_[i]);
    add_squares(squares_beauty_, other.squares_beauty_);
    add_squares(squares_direct_, other.squares_direct_);
    add_squares(squares_indirect_, other.squares_indirect_);
    for (size_t i = 0; i < hits_.size(); ++i) hits_[i] += other.hits_[i];
    pass_means_.merge(other.pass_means_);
    passes_ += other.passes_;
    nan_count_ += other.nan_count_, infinity_count_ += other.infinity_count_;
    if (passes_ > 0) next_pass_ = pass_ranges_.end();
}

std::vector<float> Film::resolve(Layer layer) const {
    assert(layers_.has(layer));
    const LayerInfo& info = layer_info(layer);
    const size_t count = size_.pixels() * info.channel_count();
    if (layer == Layer::StandardError) {
        if (passes_ < 2) return std::vector<float>(count, std::numeric_limits<float>::infinity());
        return per_channel(count, [&](size_t i) {
            return std::sqrt(variance_of_squares(beauty_sum(i), squares_beauty_[i], passes_) / passes_);
        });
    }
    const std::vector<FixedSum>& sums = sums_[static_cast<size_t>(layer)];
    return per_channel(count, [&](size_t i) {
        const uint32_t samples = info.mean == LayerMean::Hits ? hits_[i / info.channel_count()] : passes_;
        return samples ? to_double(sums[i]) / samples : 0.0;
    });
}

FixedSum Film::beauty_sum(size_t i) const {
    return sums_[static_cast<size_t>(Layer::Emitted)][i] + sums_[static_cast<size_t>(Layer::Direct)][i] +
           sums_[static_cast<size_t>(Layer::Indirect)][i];
}

std::vector<float> Film::resolve_beauty() const {
    return per_channel(3 * size_.pixels(),
                       [&](size_t i) { return passes_ ? to_double(beauty_sum(i)) / passes_ : 0.0; });
}

std::vector<float> Film::pass_variance_beauty() const {
    if (passes_ < 2) return {};
    return per_channel(3 * size_.pixels(),
                       [&](size_t i) { return variance_of_squares(beauty_sum(i), squares_beauty_[i], passes_); });
}

std::vector<float> Film::pass_variance(Layer layer) const {
    assert(layer == Layer::Direct || layer == Layer::Indirect);
    if (passes_ < 2) return {};
    const std::vector<FixedSquares>& squares = layer == Layer::Direct ? squares_direct_ : squares_indirect_;
    const std::vector<FixedSum>& sums = sums_[static_cast<size_t>(layer)];
    return per_channel(sums.size(), [&](size_t i) { return variance_of_squares(sums[i], squares[i], passes_); });
}

std::string Film::pixel_hash() const {
    static_assert(std::endian::native == std::endian::little, "pixels are hashed as little-endian float32");
    Sha256 hash;
    const auto add = [&](const std::vector<float>& pixels) {
        hash.update(pixels.data(), pixels.size() * sizeof(float));
    };
    add(resolve_beauty());
    for (const LayerInfo& info : kLayers)
        if (layers_.has(info.layer)) add(resolve(info.layer));
    return hash.hex_digest();
}

}  // namespace photond
