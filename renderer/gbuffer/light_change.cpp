#include "renderer/gbuffer/light_change.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr int64_t kWindowRadius = 8;
constexpr float kCertain = 4, kDoubtful = 2.5f;  // standard deviations
constexpr float kGuessedNoise = 0.25f;           // of the light, before frames tell
constexpr float kGuessedFrames = 2;              // that the guess counts as
constexpr float kMeanRate = 0.25f;               // of the running mean
constexpr float kLongestMemory = 8;              // frames, of the mean of squares

/// Sums over the pixels about one that have a history.
struct WindowSums {
    dvec3 pass{0}, past{0}, squares{0};  // `squares`: of their differences
    double pixels = 0;

    WindowSums& operator+=(const WindowSums& other) {
        pass += other.pass, past += other.past, squares += other.squares, pixels += other.pixels;
        return *this;
    }
    WindowSums& operator-=(const WindowSums& other) {
        pass -= other.pass, past -= other.past, squares -= other.squares, pixels -= other.pixels;
        return *this;
    }
};

/// In place: each of `count` sums, `stride` apart, becomes that of itself and its neighbours within the radius.
void sum_window(WindowSums* sums, int64_t count, int64_t stride) {
    std::vector<WindowSums> alone(static_cast<size_t>(count));
    for (int64_t i = 0; i < count; ++i) alone[static_cast<size_t>(i)] = sums[i * stride];
    for (int64_t i = 0; i < count; ++i) {
        WindowSums sum;  // anew for each: a running sum would keep what light has left the window
        for (int64_t k = std::max<int64_t>(0, i - kWindowRadius); k <= std::min(count - 1, i + kWindowRadius); ++k)
            sum += alone[static_cast<size_t>(k)];
        sums[i * stride] = sum;
    }
}

std::vector<WindowSums> window_sums(const Reprojected& found, std::span<const Rgb> indirect) {
    const Size2 size = found.past.size;
    std::vector<WindowSums> sums(size.pixels());
    parallel_for(size.height, 8, [&](size_t y) {
        for (size_t at = y * size.width; at < (y + 1) * size.width; ++at) {
            if (found.rejection[at] != Rejection::None) continue;
            const dvec3 pass(indirect[at]), past(found.past.indirect[at]);
            sums[at] = {pass, past, (pass - past) * (pass - past), 1};
        }
        sum_window(sums.data() + y * size.width, size.width, 1);
    });
    parallel_for(size.width, 8, [&](size_t x) { sum_window(sums.data() + x, size.height, size.width); });
    return sums;
}

}  // namespace

LightChange find_light_change(const Reprojected& found, std::span<const Rgb> indirect) {
    const Size2 size = found.past.size;
    LightChange result{std::vector<float>(size.pixels()), std::vector<Rgb>(size.pixels()),
                       std::vector<Rgb>(size.pixels())};
    const std::vector<WindowSums> sums = window_sums(found, indirect);
    parallel_for(size.height, 8, [&](size_t y) {
        for (size_t at = y * size.width; at < (y + 1) * size.width; ++at) {
            if (found.rejection[at] != Rejection::None) continue;
            const WindowSums& window = sums[at];
            const float frames = found.past.frames[at], told = std::max(frames - 1, 0.0f);
            const float memory = std::min(told + 1, kLongestMemory);
            float off = 0;
            for (int c = 0; c < 3; ++c) {
                const double difference = (window.pass[c] - window.past[c]) / window.pixels;
                const double past = window.past[c] / window.pixels;
                const double apart =
                    std::max(0.0, window.squares[c] / window.pixels - difference * difference) / window.pixels;
                const double guessed = std::pow(kGuessedNoise * past, 2);
                const double before =
                    (told * found.past.squared_change[at][c] + kGuessedFrames * guessed) / (told + kGuessedFrames);
                const double variance = std::max(apart, before);
                const auto mean =
                    static_cast<float>(glm::mix(double{found.past.change[at][c]}, difference, double{kMeanRate}));
                result.change[at][c] = mean;
                // What is far off is taken in as if it were at the edge of what may be noise.
                const double square = std::min(difference * difference, variance * kCertain * kCertain);
                result.squared_change[at][c] =
                    static_cast<float>(glm::mix(double{found.past.squared_change[at][c]}, square, 1.0 / memory));
                if (!(variance > 0)) {
                    if (difference != 0) off = kCertain;
                    continue;
                }
                // Of noise the running mean varies by what its own terms do and by the history's, common to them.
                const double of_mean = variance * (kMeanRate / (2 - kMeanRate) + 1 / std::max(frames, 1.0f));
                off = std::max({off, static_cast<float>(std::fabs(difference) / std::sqrt(variance)),
                                static_cast<float>(std::fabs(mean) / std::sqrt(of_mean))});
            }
            result.kept[at] = 1 - std::clamp((off - kDoubtful) / (kCertain - kDoubtful), 0.0f, 1.0f);
        }
    });
    return result;
}

}  // namespace photond
