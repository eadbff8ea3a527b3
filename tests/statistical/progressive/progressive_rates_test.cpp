// Progressive radii against closed forms: a floor that a lamp lights by way of a mirror above it, as from its image
// behind the mirror. Even light is exact with every kernel and by every rule; under a near lamp noise and bias fall as
// the theory has it.

#include <gtest/gtest.h>

#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "tests/support/render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::progressive_rates_test {
namespace {

constexpr float kAlbedo = 0.5f;
constexpr double kFalseAlarm = 1e-6;
constexpr float kSeenHalf = 0.25f;  // of the floor, about its middle [m]

Material mirror() {
    Material material;
    material.base_color = Rgb(1);
    material.metallic = 1;
    material.roughness = 0;
    return material;
}

Mesh square(float y, float half, bool faces_up) {
    const vec3 a(-half, y, half), b(half, y, half), c(half, y, -half), d(-half, y, -half);
    return faces_up ? MeshBuilder().quad(a, b, c, d).build(0) : MeshBuilder().quad(d, c, b, a).build(0);
}

/// The middle of the floor, seen from straight above.
Camera from_above(float height_m) {
    Camera camera =
        look_at_camera({0, double{height_m}, 0}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(kSeenHalf / height_m));
    return camera;
}

constexpr float kMirrorY = 0.35f, kLampY = 0.1f, kImageY = 2 * kMirrorY - kLampY;

/// A point of 1 W/sr over the floor, under a mirror.
Scene near_lamp() {
    Scene scene;
    test::add(scene, square(0, 3, true), test::lambert(kAlbedo));
    test::add(scene, square(kMirrorY, 3, false), mirror());
    PunctualLight lamp;
    lamp.position = {0, kLampY, 0};
    scene.punctual_lights = {lamp};
    scene.cameras = {from_above(0.3f)};
    finish_scene(scene);
    return scene;
}
/// Radiance of the floor at that distance from the middle, by the lamp's image.
double near_radiance(double distance_sq_m2) {
    const double h = double{kImageY}, d_sq = h * h + distance_sq_m2;
    return double{kAlbedo} / std::numbers::pi * h / (d_sq * std::sqrt(d_sq));
}

/// Of a pixel's place on the floor from the middle. [m^2]
double distance_sq_of(Size2 size, uint32_t pixel) {
    const double pixel_m = 2 * double{kSeenHalf} / size.width;
    const double x = (pixel % size.width + 0.5) * pixel_m - double{kSeenHalf},
                 y = (pixel / size.width + 0.5) * pixel_m - double{kSeenHalf};
    return x * x + y * y;
}

/// Light from the side, which a mirror at 45 degrees turns straight down: even on all the floor that is seen.
Scene even_light() {
    Scene scene;
    test::add(scene, square(0, 0.6f, true), test::lambert(kAlbedo));
    // Light along +x meets it at x + y = 1.
    test::add(scene, MeshBuilder().quad({-1, 2, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 2, -1}).build(0), mirror());
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::Directional;
    sun.direction = {1, 0, 0};
    scene.punctual_lights = {sun};
    scene.cameras = {from_above(0.3f)};
    finish_scene(scene);
    return scene;
}

template <class M>
test::RenderSettingsOf<M> settings_of(RadiusRule rule, uint32_t photons, uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 32};
    settings.passes = passes;
    settings.params.radius_rule = rule;
    settings.params.photons = 1;  // of the global map, in which there is no light
    settings.params.caustic_photons = photons;
    settings.params.indirect_bounces = 1;
    return settings;
}

/// The mean of the picture is exact: within the spread of films of their own seeds.
template <class M>
void expect_even(const Scene& scene, const test::RenderSettingsOf<M>& asked, const std::string& what) {
    constexpr size_t kMostFilms = 20, kChecks = 11;
    constexpr double kMustNotice = 0.02;  // as a share of the mean
    const double expected = double{kAlbedo} / std::numbers::pi;
    const test::Interval mean =
        test::interval_when_narrow(kMustNotice * expected, kMostFilms, kFalseAlarm, kChecks, [&](uint64_t seed) {
            test::RenderSettingsOf<M> settings = asked;
            settings.seed = seed;
            return test::mean_of(test::render(scene, settings).resolve(Layer::Indirect));
        });
    std::printf("%-24s %+.3f %%, within %.3f %%\n", what.c_str(), 100 * (mean.mean / expected - 1),
                100 * mean.half_width / expected);
    EXPECT_LE(std::abs(mean.mean - expected), mean.half_width) << what;
    EXPECT_LE(mean.half_width, kMustNotice * expected) << what << ": too noisy to notice a defect";
}

TEST(ProgressiveRates, EvenLightIsExact) {
    const Scene scene = even_light();
    for (const auto& [shape, name] : {std::pair(KernelShape::Constant, "constant"),
                                      {KernelShape::Cone, "cone"},
                                      {KernelShape::Gaussian, "gaussian"},
                                      {KernelShape::Epanechnikov, "epanechnikov"}}) {
        auto settings = settings_of<ProbabilisticProgressivePhotonMapping>(RadiusRule::Global, 3000, 4);
        settings.params.kernel = shape;
        settings.params.radius_m = 0.05f;
        expect_even(scene, settings, name);
    }
    expect_even(scene, settings_of<ProbabilisticProgressivePhotonMapping>(RadiusRule::Trained, 3000, 4), "trained");
    for (const auto& [rule, name] :
         {std::pair(RadiusRule::Global, "global"), {RadiusRule::Local, "local"}, {RadiusRule::Tested, "tested"}}) {
        expect_even(scene, settings_of<StochasticProgressivePhotonMapping>(rule, 3000, 8), name);
        auto given = settings_of<StochasticProgressivePhotonMapping>(rule, 10'000, 8);
        given.params.radius_m = 0.015f;  // holds one photon in three passes
        expect_even(scene, given, std::string(name) + ", radius given");
    }
}

// Wide discs under the near lamp: what the layer says is how far the image's mean is off, but for the fourth power of
// the radius, which is a seventh of the second at the middle of the first pass's discs.
TEST(ProgressiveRates, TheBiasEstimateIsTheBias) {
    const Scene scene = near_lamp();
    for (const KernelShape shape : {KernelShape::Constant, KernelShape::Epanechnikov}) {
        auto settings = settings_of<ProbabilisticProgressivePhotonMapping>(RadiusRule::Global, 20'000, 8);
        settings.size = {16, 16};
        settings.params.radius_m = 0.2f;
        settings.params.kernel = shape;
        settings.layers.add(Layer::BiasEstimate);
        test::RunningMean bias, unexplained;
        for (settings.seed = 1; settings.seed <= 8; ++settings.seed) {
            const Film film = test::render(scene, settings);
            const std::vector<float> radiance = film.resolve(Layer::Indirect), told = film.resolve(Layer::BiasEstimate);
            double off = 0, said = 0, light = 0;
            for (uint32_t pixel = 0; pixel < told.size(); ++pixel) {
                const double truth = near_radiance(distance_sq_of(settings.size, pixel));
                off += double{radiance[3 * size_t{pixel}]} - truth, said += double{told[pixel]}, light += truth;
            }
            bias.add(off / light), unexplained.add((off - said) / light);
        }
        const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, 4), 7);
        std::printf("bias %+.3f %% +- %.3f, not explained %+.3f %% +- %.3f\n", 100 * bias.mean(),
                    100 * bias.standard_error(), 100 * unexplained.mean(), 100 * unexplained.standard_error());
        EXPECT_LT(bias.mean(), -t * bias.standard_error()) << "discs are wide enough to see it";
        EXPECT_LT(std::abs(unexplained.mean()), std::abs(bias.mean()) / 7 + t * unexplained.standard_error());
    }
}

/// Mean over pixels of the squared relative error after so many passes, for each of `lengths`.
std::vector<double> errors_after(const Scene& scene,
                                 test::RenderSettingsOf<ProbabilisticProgressivePhotonMapping> settings,
                                 const std::vector<uint32_t>& lengths) {
    std::vector<double> errors;
    Film film(settings.size, settings.layers);
    settings.passes = lengths.back();
    test::run_passes(scene, settings, [&](ProbabilisticProgressivePhotonMapping& method, uint32_t) {
        method.resolve(film);
        if (film.passes() != lengths[errors.size()]) return;
        const std::vector<float> radiance = film.resolve(Layer::Indirect);
        double sum = 0;
        for (uint32_t pixel = 0; pixel < settings.size.pixels(); ++pixel) {
            const double truth = near_radiance(distance_sq_of(settings.size, pixel));
            const double error = double{radiance[3 * size_t{pixel}]} / truth - 1;
            sum += error * error;
        }
        errors.push_back(sum / double(settings.size.pixels()));
    });
    return errors;
}

/// The slope of the error over passes, on logarithms, by least squares.
double slope_of(const std::vector<uint32_t>& lengths, const std::vector<double>& errors) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t i = 0; i < lengths.size(); ++i) {
        const double x = std::log(double(lengths[i])), y = std::log(errors[i]);
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// What the error is proportional to by the radii's closed form, r_i^2 the radius of pass i over the first one's: noise
/// is (1/N^2) sum 1/r_i^2, squared bias the square of (1/N) sum r_i^2.
double expected_error(bool noise, double alpha, uint32_t passes) {
    double sum = 0;
    for (uint32_t pass = 0; pass < passes; ++pass) {
        const double i = pass + 1.0;
        const double share_sq = std::exp(std::lgamma(i + alpha) - std::lgamma(1 + alpha) - std::lgamma(i + 1));
        sum += noise ? 1 / share_sq : share_sq;
    }
    const double mean = sum / passes;
    return noise ? mean / passes : mean * mean;
}

// [Kaplanyan and Dachsbacher 2013, sec. 4]: variance of the mean falls as N^-alpha, squared bias as N^(2 alpha - 2),
// once the sums of radii are near their asymptotes.
TEST(ProgressiveRates, ErrorsFallAsTheRadiiHaveIt) {
    const Scene scene = near_lamp();
    const std::vector<uint32_t> lengths{32, 64, 128, 256, 512};
    struct Case {
        bool noise;
        float alpha, slope;
    };
    for (const Case& c : {Case{true, 0.3f, -0.30f}, Case{true, 2.0f / 3, -0.667f}, Case{false, 2.0f / 3, -0.667f},
                          Case{false, 0.7f, -0.60f}}) {
        // Noise where discs are small and many, bias where they are wide and full.
        auto settings =
            settings_of<ProbabilisticProgressivePhotonMapping>(RadiusRule::Global, c.noise ? 4000 : 8000, 0);
        const uint32_t side = c.noise ? 64 : 16;
        settings.size = {side, side};
        settings.params.alpha = c.alpha;
        settings.params.radius_m = c.noise ? 0.01f : 0.25f;
        settings.params.kernel = KernelShape::Constant;
        settings.params.disc_thickness_m = 0.01f;
        if (c.noise) {  // independent photons, all of one power
            settings.params.projection_maps = false;
            settings.params.sampler = SamplerKind::Random;
        }
        test::RunningMean slope;
        for (settings.seed = 1; settings.seed <= 2; ++settings.seed)
            slope.add(slope_of(lengths, errors_after(scene, settings, lengths)));
        std::vector<double> expected, later;
        const std::vector<uint32_t> many{1u << 18, 1u << 20, 1u << 22};
        for (const uint32_t n : lengths) expected.push_back(expected_error(c.noise, double{c.alpha}, n));
        for (const uint32_t n : many) later.push_back(expected_error(c.noise, double{c.alpha}, n));
        const double here = slope_of(lengths, expected);
        std::printf("alpha %.3f, %s: slope %.3f +- %.3f, %.3f by the radii of these passes, %.3f of a million\n",
                    double{c.alpha}, c.noise ? "noise" : "bias", slope.mean(), slope.standard_error(), here,
                    slope_of(many, later));
        EXPECT_NEAR(slope.mean(), here, 0.05);
        EXPECT_NEAR(slope_of(many, later), double{c.slope}, 0.005);
    }
}

}  // namespace
}  // namespace photond::progressive_rates_test
