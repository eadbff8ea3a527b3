#include "renderer/error/welch_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "renderer/core/parallel.h"
#include "renderer/core/rgb.h"
#include "renderer/error/student_t.h"

namespace photond {

namespace {

/// Renderers compute in floats: so much of a mean is no difference.
constexpr double kRounding = 1e-6;

// A block is heavy-tailed where kFewPixels of those that have noise carry more than kMostShare of it.
constexpr double kFewPixels = 0.01, kMostShare = 0.5;
constexpr size_t kLeastPixels = 100;      // fewer say nothing of tails
constexpr double kMostHeavyBlocks = 0.1;  // of those judged, in an image that is not heavy-tailed

constexpr double kPower = 0.9;  // with which a bias that is called detectable is found

double luminance_of(std::span<const float> values, size_t pixel) {
    return double{luminance({values[3 * pixel], values[3 * pixel + 1], values[3 * pixel + 2]})};
}

/// Pixels of which something is known, and the share of `squares` that the largest kFewPixels of them carry.
std::optional<double> share_of_few(std::vector<double>& squares) {
    std::erase(squares, 0.0);
    if (squares.size() < kLeastPixels) return std::nullopt;
    const auto few = static_cast<std::ptrdiff_t>(std::ceil(kFewPixels * static_cast<double>(squares.size())));
    std::nth_element(squares.begin(), squares.begin() + few, squares.end(), std::greater<>());
    const double largest = std::accumulate(squares.begin(), squares.begin() + few, 0.0);
    return largest / std::accumulate(squares.begin() + few, squares.end(), largest);
}

/// A mean's variance, and the degrees of freedom that this is known with.
struct KnownVariance {
    double variance = 0, degrees = 1;
};

/// Of the two means of a block.
struct BlockNoise {
    KnownVariance films, reference;

    /// Of both in one [Satterthwaite 1946]; 0 degrees where there is no variance.
    KnownVariance sum() const {
        const double sum = films.variance + reference.variance;
        if (!(sum > 0)) return {0, 0};
        const double u = films.variance / sum, v = reference.variance / sum;
        return {sum, 1 / (u * u / films.degrees + v * v / reference.degrees)};
    }
};

/// P of a difference at least as large, of two means of normal numbers. The films' variance is what is least known: it
/// is replaced by all it may have come from, degrees / chi^2 times it, each by its chance [Fisher 1935; Tsui and
/// Weerahandi 1989, Generalized p-Values]. With that one given, the other's degrees are left to Satterthwaite.
double chance_of(double difference, const BlockNoise& noise) {
    const auto& [films, reference] = noise;
    if (!(difference > 0)) return 1;
    if (!(films.variance + reference.variance > 0)) return 0;
    // Steps of the logarithm of chi^2, where its density is smooth. Below is less than 1e-17 of it, which is what a
    // chance may lack; above 1e-7, where differences are least likely.
    const double half = films.degrees / 2, step = std::min(0.5, 0.7 / std::sqrt(half));
    const double least = -40 / half, greatest = std::log(films.degrees + 12 * std::sqrt(films.degrees) + 24);
    const auto steps = static_cast<size_t>((greatest - least) / step);
    const double log_norm = std::lgamma(half) + half * std::numbers::ln2;
    constexpr double kNegligible = 1e-9, kNormalDegrees = 2000;
    double chance = 0, mass = 0;
    for (size_t i = 0; i <= steps; ++i) {
        const double log_square = least + static_cast<double>(i) * step;
        const double square = std::exp(log_square), density = std::exp(half * log_square - square / 2 - log_norm);
        mass += density;
        if (density < kNegligible && square > films.degrees) continue;
        const double variance = films.variance * films.degrees / square + reference.variance;
        const double share = reference.variance / variance, degrees = reference.degrees / (share * share);
        const bool normal = !(degrees < kNormalDegrees);
        chance += density * student_t_tails(difference / std::sqrt(variance),
                                            normal ? std::numeric_limits<double>::infinity() : degrees);
    }
    return chance / mass;
}

struct TestedBlock {
    WelchBlock block;  // all but `found`
    BlockNoise noise;
    std::optional<bool> heavy_tailed = {};
};

/// What the pixels of a block say.
class BlockOfPixels {
public:
    explicit BlockOfPixels(size_t films) : sums_(films), values_(films) {}

    void add(const CrossMeter& references, std::span<const std::vector<float>> films, size_t pixel) {
        const double r = luminance_of(references.mean_reference(), pixel);
        const double d = luminance_of(references.half_difference(), pixel);
        double mean = 0;
        for (size_t i = 0; i < films.size(); ++i) {
            values_[i] = luminance_of(films[i], pixel);
            mean += values_[i] / static_cast<double>(films.size());
        }
        if (!std::isfinite(r) || !std::isfinite(d) || !std::isfinite(mean)) return;
        ++count_, reference_ += r;
        double spread = 0;
        for (size_t i = 0; i < films.size(); ++i)
            sums_[i] += values_[i], spread += (values_[i] - mean) * (values_[i] - mean);
        reference_squares_.push_back(d * d);
        // Over the light there: noise that is even in it is not of few pixels.
        const auto weight = double{references.weights()[3 * pixel + 1]};
        weighted_reference_.push_back(d * d * weight), weighted_films_.push_back(spread * weight);
    }

    size_t count() const { return count_; }

    /// `image_mean`: of R. Differences and noise are over the block's scale.
    TestedBlock test(double image_mean) const {
        const auto n = static_cast<double>(count_);
        const double r = reference_ / n;
        double mean = 0;
        for (const double sum : sums_) mean += sum / n / static_cast<double>(sums_.size());
        const double norm = std::sqrt(r * r + 0.01 * image_mean * image_mean), scale = norm > 0 ? norm : 1;
        const BlockNoise noise{variance_of_films(mean, scale), variance_of_reference(scale)};
        const double distance = std::fabs(mean - r) - kRounding * std::max(std::fabs(mean), std::fabs(r));
        const KnownVariance sum = noise.sum();
        return {.block = {.difference = (mean - r) / scale,
                          .standard_error = std::sqrt(sum.variance),
                          .degrees = sum.degrees,
                          .p = chance_of(distance / scale, noise)},
                .noise = noise};
    }

    /// Whether few pixels carry most of the noise of either; empty where too few have any. Call it last.
    std::optional<bool> heavy_tailed() {
        const std::optional<double> reference = share_of_few(weighted_reference_),
                                    films = share_of_few(weighted_films_);
        if (!reference && !films) return std::nullopt;
        return std::max(reference.value_or(0), films.value_or(0)) > kMostShare;
    }

private:
    KnownVariance variance_of_films(double mean, double scale) const {
        const auto k = static_cast<double>(sums_.size());
        double squares = 0;
        for (const double sum : sums_) squares += std::pow((sum / static_cast<double>(count_) - mean) / scale, 2);
        return {squares / (k - 1) / k, k - 1};
    }

    /// Of sums of squares of normal numbers the fourth powers are three times the squares' own variance over two.
    KnownVariance variance_of_reference(double scale) const {
        const auto n = static_cast<double>(count_);
        double squares = 0, fourths = 0;
        for (const double square : reference_squares_) squares += square, fourths += square * square;
        return {squares / (n * n * scale * scale), fourths > 0 ? 3 * squares * squares / fourths : n};
    }

    size_t count_ = 0;
    double reference_ = 0;
    std::vector<double> sums_, values_;                                            // by film
    std::vector<double> reference_squares_, weighted_reference_, weighted_films_;  // by pixel
};

double mean_luminance(std::span<const float> image) {
    double sum = 0;
    size_t count = 0;
    for (size_t pixel = 0; pixel < image.size() / 3; ++pixel)
        if (const double value = luminance_of(image, pixel); std::isfinite(value)) sum += value, ++count;
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// Marks those found [Holm 1979].
void find_blocks(std::vector<TestedBlock*> blocks) {
    std::sort(blocks.begin(), blocks.end(),
              [](const TestedBlock* a, const TestedBlock* b) { return a->block.p < b->block.p; });
    for (size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i]->block.p > WelchMap::kLevel / static_cast<double>(blocks.size() - i)) break;
        blocks[i]->block.found = true;
    }
}

/// By the noise of the block of the median standard error.
double detectable_bias(std::vector<TestedBlock*> blocks) {
    std::erase_if(blocks, [](const TestedBlock* tested) { return tested->block.degrees == 0; });
    if (blocks.empty()) return 0;
    const auto middle = blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() / 2);
    std::nth_element(blocks.begin(), middle, blocks.end(), [](const TestedBlock* a, const TestedBlock* b) {
        return a->block.standard_error < b->block.standard_error;
    });
    const TestedBlock& typical = **middle;
    double low = 0, high = 1e8 * typical.block.standard_error;  // two seeds, 1.57 million blocks
    for (int i = 0; i < 60; ++i) {
        const double difference = (low + high) / 2;
        (chance_of(difference, typical.noise) > WelchMap::kLevel / static_cast<double>(blocks.size()) ? low : high) =
            difference;
    }
    return low + typical.block.standard_error * two_sided_student_t(2 * kPower - 1, typical.block.degrees);
}

/// Of a share, with two digits.
std::string percent(double share, bool with_sign = false) {
    char text[48];
    const double value = 100 * share;
    const char* format =
        std::fabs(value) >= 99.5 ? (with_sign ? "%+.0f %%" : "%.0f %%") : (with_sign ? "%+.2g %%" : "%.2g %%");
    std::snprintf(text, sizeof text, format, value);
    return text;
}

}  // namespace

WelchMap welch_map(const CrossMeter& references, std::span<const std::vector<float>> films, uint32_t block) {
    assert(films.size() >= 2 && block > 0);
    const Size2 pixels = references.size();
    for ([[maybe_unused]] const std::vector<float>& film : films) assert(film.size() == 3 * pixels.pixels());
    WelchMap map;
    map.block = block, map.seeds = films.size();
    map.size = {(pixels.width + block - 1) / block, (pixels.height + block - 1) / block};
    std::vector<std::optional<TestedBlock>> tested(map.size.pixels());
    const double image_mean = mean_luminance(references.mean_reference());
    parallel_for(tested.size(), 1, [&](size_t i) {
        const auto column = static_cast<uint32_t>(i % map.size.width), row = static_cast<uint32_t>(i / map.size.width);
        BlockOfPixels of_pixels(films.size());
        for (uint32_t y = row * block; y < std::min((row + 1) * block, pixels.height); ++y)
            for (uint32_t x = column * block; x < std::min((column + 1) * block, pixels.width); ++x)
                of_pixels.add(references, films, size_t{y} * pixels.width + x);
        if (of_pixels.count() == 0) return;
        tested[i] = of_pixels.test(image_mean);
        tested[i]->heavy_tailed = of_pixels.heavy_tailed();
    });
    std::vector<TestedBlock*> blocks;
    for (std::optional<TestedBlock>& block_of_pixels : tested)
        if (block_of_pixels) blocks.push_back(&*block_of_pixels);
    map.tested = blocks.size();
    find_blocks(blocks);
    map.detectable = detectable_bias(blocks);
    for (const TestedBlock* of : blocks) {
        map.found += of->block.found;
        map.judged_blocks += of->heavy_tailed.has_value(), map.heavy_blocks += of->heavy_tailed.value_or(false);
        map.share_below_level += (of->block.p < WelchMap::kLevel ? 1.0 : 0.0) / static_cast<double>(blocks.size());
    }
    map.heavy_tailed =
        static_cast<double>(map.heavy_blocks) > kMostHeavyBlocks * static_cast<double>(map.judged_blocks);
    for (const std::optional<TestedBlock>& of : tested) map.blocks.push_back(of ? of->block : WelchBlock{});
    return map;
}

std::string WelchMap::text() const {
    const std::string of_all = std::to_string(tested) + (tested == 1 ? " block" : " blocks");
    std::string text;
    if (tested == 0) return "no pixel is finite in all images";
    if (found > 0) {
        const WelchBlock* worst = nullptr;
        for (const WelchBlock& block : blocks)
            if (block.found && (!worst || std::fabs(block.difference) > std::fabs(worst->difference))) worst = &block;
        text = "biased: " + std::to_string(found) + " of " + of_all + (found == 1 ? " differs" : " differ") +
               " from the reference at a level of " + percent(kLevel) + ", the worst by " +
               percent(worst->difference, true) + " +- " + percent(worst->standard_error);
    } else {
        text = "no block of " + std::to_string(tested) + " differs from the reference at a level of " +
               percent(kLevel) + "; a bias of " + percent(detectable) + " in one block would have been found";
        if (seeds < kSeedsToTell && detectable > 1) text += ": " + std::to_string(seeds) + " seeds are few";
    }
    if (heavy_tailed)
        text += ". The noise is heavy-tailed: in " + std::to_string(heavy_blocks) + " of " +
                std::to_string(judged_blocks) + " blocks " + percent(kFewPixels) +
                " of the pixels carry more than half of it, and blocks may be found by chance";
    return text;
}

}  // namespace photond
