#include "renderer/error/motion_errors.h"

#include <cassert>
#include <cmath>

#include "renderer/error/cross_sums.h"
#include "renderer/error/pixel_chunks.h"

namespace photond {

namespace {

/// One of the three: its terms divided by D.
struct MotionSums {
    CrossSums sums;
    double shared_noise = 0;

    MotionSums& operator+=(const MotionSums& other) {
        sums += other.sums, shared_noise += other.shared_noise;
        return *this;
    }
};

struct FrameSums {
    MotionSums flicker, lag, change;
    uint64_t count = 0;

    FrameSums& operator+=(const FrameSums& other) {
        flicker += other.flicker, lag += other.lag, change += other.change, count += other.count;
        return *this;
    }
};

/// What a pixel adds to one of them, channel by channel.
struct PixelTerms {
    double product = 0, term = 0, shared_noise = 0;

    void add_to(MotionSums& to) const { to += {{product, term * term, product * product}, shared_noise}; }
};

/// What each value of a frame and of the one before is made of.
class MotionSweep {
public:
    MotionSweep(const CrossMeter& now, const CrossMeter& before, std::span<const float> image,
                std::span<const float> image_before)
        : now_(now),
          before_(before),
          image_(image),
          image_before_(image_before),
          shares_noise_(now.denominators() == Denominators::Pixel),
          square_(now.unit() * now.unit()) {}

    FrameSums of(size_t first, size_t last) const {
        FrameSums sums;
        for (size_t pixel = first; pixel < last; ++pixel) {
            PixelTerms flicker, lag, change;
            for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) sums.count += add(i, flicker, lag, change);
            flicker.add_to(sums.flicker), lag.add_to(sums.lag), change.add_to(sums.change);
        }
        return sums;
    }

private:
    bool add(size_t i, PixelTerms& flicker, PixelTerms& lag, PixelTerms& change) const {
        const double r = double{now_.mean_reference()[i]}, h = double{now_.half_difference()[i]};
        const double h_before = double{before_.half_difference()[i]};
        const double change_of_r = r - double{before_.mean_reference()[i]}, change_of_h = h - h_before;
        const double e = double{image_[i]} - r;
        const double excess = double{image_[i]} - double{image_before_[i]} - change_of_r;
        if (!std::isfinite(e) || !std::isfinite(excess) || !std::isfinite(change_of_h)) return false;
        const double weight = double{now_.weights()[i]} / square_;
        const double nu = h * h * weight, noise_squared = 2.0 / 3 * nu * nu * (4 * r * r * weight - 1);
        const auto add_square = [&](PixelTerms& terms, double difference) {
            terms.product += (difference - change_of_h) * (difference + change_of_h) * weight;
            terms.term -= 2 * difference * change_of_h * weight;
            if (shares_noise_) terms.shared_noise += 4 * nu * difference * r * weight - noise_squared;
        };
        add_square(flicker, excess);
        add_square(change, -change_of_r);
        lag.product += (e * change_of_r + h * change_of_h) * weight;
        lag.term += ((e - change_of_r) * h - e * h_before) * weight;
        if (shares_noise_) lag.shared_noise += noise_squared - 2 * nu * (e - change_of_r) * r * weight;
        return true;
    }

    const CrossMeter& now_;
    const CrossMeter& before_;
    const std::span<const float> image_, image_before_;
    const bool shares_noise_;
    const double square_;
};

}  // namespace

std::optional<double> MotionErrors::frames_late(const CrossError& lag, const CrossError& change) {
    if (!(change.interval().least > 0)) return std::nullopt;
    return -lag.value / change.value;
}

MotionErrors motion_errors(const CrossMeter& references, const CrossMeter& references_before,
                           std::span<const float> image, std::span<const float> image_before) {
    const uint64_t pixels = references.size().pixels();
    assert(references_before.size().pixels() == pixels && image.size() == 3 * pixels &&
           image_before.size() == image.size());
    const MotionSweep sweep(references, references_before, image, image_before);
    const FrameSums sums =
        sum_of_chunks<FrameSums>(pixels, [&](size_t first, size_t last) { return sweep.of(first, last); });
    MotionErrors errors;
    errors.left_out = image.size() - sums.count;
    if (sums.count == 0 || references.mean() == 0) return errors;
    const auto error = [&](const MotionSums& of) {
        CrossError found = of.sums.error(sums.count, pixels);
        found.value -= of.shared_noise / static_cast<double>(sums.count);
        return found;
    };
    errors.flicker = error(sums.flicker), errors.lag = error(sums.lag), errors.change = error(sums.change);
    return errors;
}

}  // namespace photond
