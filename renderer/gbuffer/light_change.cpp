#include "renderer/gbuffer/light_change.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr size_t kWindowRadius = 3;    // pixels
constexpr double kNoiseOfMeans = 2;    // times their variance that is held to be noise
constexpr double kGuessedNoise = 0.1;  // of the window's mean, over that, before steps tell
constexpr double kGuessedFrames = 2;   // that the guess counts as
constexpr double kLongestMemory = 8;   // frames, of the product of steps

/// Sums over the pixels about one that have a history.
struct WindowSums {
    dvec3 pass{0}, past{0};
    double squares = 0, past_frames = 0, pixels = 0;  // `squares`: of their differences

    WindowSums& operator+=(const WindowSums& other) {
        pass += other.pass, past += other.past;
        squares += other.squares, past_frames += other.past_frames, pixels += other.pixels;
        return *this;
    }
};

/// What each pixel gives to the windows that it is in.
std::vector<WindowSums> pixel_sums(const Reprojected& found, std::span<const Rgb> indirect) {
    std::vector<WindowSums> sums(indirect.size());
    parallel_for(indirect.size(), 4096, [&](size_t at) {
        if (found.rejection[at] != Rejection::None || !is_finite(indirect[at])) return;
        const dvec3 pass(indirect[at]), past(found.past.indirect[at]);
        sums[at] = {pass, past, glm::dot(pass - past, pass - past), double{found.past.frames[at]}, 1};
    });
    return sums;
}

/// Of the windows about the pixels of a row. Each is summed anew: a running sum would keep something of what has left
/// it.
std::vector<WindowSums> window_sums(const std::vector<WindowSums>& pixels, Size2 size, size_t y) {
    const auto range = [](size_t middle, size_t end) {
        return std::pair{middle - std::min(middle, kWindowRadius), std::min(middle + kWindowRadius + 1, end)};
    };
    std::vector<WindowSums> columns(size.width), windows(size.width);
    const auto [top, bottom] = range(y, size.height);
    for (size_t row = top; row < bottom; ++row)
        for (size_t x = 0; x < size.width; ++x) columns[x] += pixels[row * size.width + x];
    for (size_t x = 0; x < size.width; ++x) {
        const auto [left, right] = range(x, size.width);
        for (size_t column = left; column < right; ++column) windows[x] += columns[column];
    }
    return windows;
}

}  // namespace

LightChange find_light_change(const Reprojected& found, std::span<const Rgb> indirect) {
    const Size2 size = found.past.size;
    const size_t pixels = size.pixels();
    LightChange result{std::vector<float>(pixels, 1), std::vector<Rgb>(pixels), std::vector<Rgb>(pixels),
                       std::vector<float>(pixels), std::vector<float>(pixels, 1)};
    const std::vector<WindowSums> sums = pixel_sums(found, indirect);
    parallel_for(size.height, 8, [&](size_t y) {
        const std::vector<WindowSums> windows = window_sums(sums, size, y);
        for (size_t at = y * size.width; at < (y + 1) * size.width; ++at) {
            if (!is_finite(indirect[at])) continue;
            if (found.rejection[at] != Rejection::None) {
                result.near_light[at] = indirect[at];
                continue;
            }
            const WindowSums& window = windows[at - y * size.width];
            const dvec3 now = window.pass / window.pixels, past = window.past / window.pixels;
            const double frames = std::max(1.0, window.past_frames / window.pixels);
            const dvec3 step = now - dvec3(found.past.near_light[at]);
            const double age = found.past.age[at], product_now = glm::dot(step, dvec3(found.past.near_step[at]));
            const double products = std::max(age - 2, 0.0);  // taken in before
            const double memory = std::min(products + 1, kLongestMemory);
            const double product = age < 2 ? 0 : glm::mix(double{found.past.step_product[at]}, product_now, 1 / memory);
            result.near_light[at] = Rgb(now), result.near_step[at] = Rgb(step);
            result.step_product[at] = static_cast<float>(product);
            result.age[at] = static_cast<float>(std::min(age + 1, 2 * kLongestMemory));

            const double difference = glm::dot(now - past, now - past);
            // Of one pass: the differences vary by the history's noise too.
            const double apart = std::max(0.0, window.squares / window.pixels - difference) / (1 + 1 / frames);
            const double told = std::min(products, kLongestMemory);
            const double guessed = kGuessedNoise * kGuessedNoise * glm::dot(past, past);
            const double in_common =
                std::max(0.0, (told * -double{found.past.step_product[at]} + kGuessedFrames * guessed) /
                                  (told + kGuessedFrames));
            const double of_means = std::max(apart / window.pixels, in_common) * (1 + 1 / frames);
            const double changed = std::max(0.0, difference - kNoiseOfMeans * of_means);
            const double noise = apart + in_common;
            const double off = changed + noise / double{std::max(found.past.frames[at], 1.0f)};
            if (off + noise > 0) result.own_share[at] = static_cast<float>(off / (off + noise));
        }
    });
    return result;
}

}  // namespace photond
