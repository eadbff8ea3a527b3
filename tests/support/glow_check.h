#pragma once
// Whether glass lights its surroundings as path tracing says.

#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::test {

inline constexpr size_t kGlowFilms = 64;  // of their own seeds

/// Means of the indirect layer about the glass over films that `render(seed)` makes.
template <class Render>
RunningMean glow(const Render& render) {
    RunningMean mean;
    for (uint64_t seed = 1; seed <= kGlowFilms; ++seed) mean.add(mean_of(render(seed).resolve(Layer::Indirect)));
    return mean;
}

/// Of path tracing. In the picture, about a metre, this is what the glass casts, as the floor sees nothing else.
inline RunningMean traced_glow(const Scene& scene) {
    RenderSettings settings;
    settings.passes = 12;
    return glow([&](uint64_t seed) {
        settings.seed = 1000 + seed;
        return render(scene, settings);
    });
}

/// Splats may lose 5 % where their discs reach beyond the floor's lit part; as wide as the scene has them they add 150
/// %.
inline void expect_same_glow(const RunningMean& splatted, const RunningMean& traced) {
    constexpr double kAllowed = 0.05, kMustNotice = 0.7, kFalseAlarm = 1e-6;
    // Welch's interval, with the fewer degrees of freedom.
    const double t = two_sided_t(kFalseAlarm, double(kGlowFilms) - 1);
    const double sigma = std::hypot(splatted.standard_error(), traced.standard_error()) / traced.mean();
    const double difference = splatted.mean() / traced.mean() - 1;
    std::printf("light about the glass: %+.1f %%, standard error %.1f %%\n", 100 * difference, 100 * sigma);
    EXPECT_LE(std::abs(difference), kAllowed + t * sigma);
    EXPECT_LE(t * sigma, kMustNotice) << "too noisy to notice a defect";
}

}  // namespace photond::test
