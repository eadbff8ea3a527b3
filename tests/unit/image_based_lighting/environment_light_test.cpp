// The split sum against quadrature of the whole: where the environment is the same from everywhere it is exact for
// every material, and elsewhere its error is a table.

#include <gtest/gtest.h>

#include <cstdio>
#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/methods/image_based_lighting/environment_light.h"
#include "tests/support/bsdf_case.h"
#include "tests/support/environments.h"

namespace photond::environment_light_test {
namespace {

using test::direction_at;
using test::ScatteringMap;
using test::Side;

struct Family {
    const char* name;
    Bsdf::Parameters parameters;
};

std::vector<Family> families() {
    return {{"coat over diffuse", {.base_color = Rgb(0.8f, 0.5f, 0.2f)}},
            {"coat over black", {.base_color = Rgb(0)}},
            {"strong coloured coat", {.base_color = Rgb(0.7f), .ior = 2.2f, .specular_color = Rgb(1.3f, 1, 0.4f)}},
            {"no coat", {.base_color = Rgb(0.8f, 0.5f, 0.2f), .specular = 0}},
            {"metal", {.base_color = Rgb(1, 0.8f, 0.3f), .metallic = 1}},
            {"half metal", {.base_color = Rgb(1, 0.8f, 0.3f), .metallic = 0.5f}},
            {"thin sheet", {.base_color = Rgb(0.9f, 0.7f, 0.5f), .transmission = 1}},
            {"half thin sheet", {.base_color = Rgb(0.9f, 0.7f, 0.5f), .transmission = 0.5f}},
            {"glass, reflected", {.transmission = 1, .solid = true}},
            {"dense glass, reflected", {.transmission = 1, .solid = true, .eta = 2.2f}},
            {"glass from within, reflected", {.transmission = 1, .solid = true, .eta = 1 / 1.5f}}};
}

/// Of the light L(wi), local: the sum of f cos L over all directions, in double, by half-vectors of the lobe and, for
/// what is diffuse, of a wide one. Nothing of it knows the tables that the split sum asks.
template <class Radiance>
dvec3 scattered(const Bsdf& bsdf, const Bsdf::Parameters& p, const dvec3& wo, int steps, const Radiance& radiance) {
    const ScatteringMap map{test::HalfVectorMap(sqr(p.roughness)), wo, static_cast<double>(p.eta)};
    dvec3 sum(0);
    for (const Side side : {Side::Reflected, Side::Mirrored}) {
        if (side == Side::Mirrored && (p.solid || p.transmission == 0)) continue;
        for (int i = 0; i < steps; ++i)
            for (int j = 0; j < steps; ++j) {
                dvec3 wi(0);
                const double solid_angle =
                    map.scatter(side, (i + 0.5) / steps, (j + 0.5) / steps, wi) / (double(steps) * steps);
                if (solid_angle <= 0) continue;
                sum += solid_angle * dvec3(bsdf.f_cos(vec3(wo), vec3(wi))) * radiance(wi);
            }
    }
    return sum;
}

const std::vector<float> kRoughnesses = {0.02f, 0.05f, 0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f};
const std::vector<double> kCosines = {0.9999, 0.9, 0.6, 0.3, 0.1, 0.03};

TEST(EnvironmentLight, OfAnEvenEnvironmentIsTheDirectionalAlbedo) {
    const Rgb radiance(2, 1, 0.5f);
    const Environment environment = test::even_environment(radiance);
    const EnvironmentSampler sampler(environment);
    const PrefilteredEnvironment maps(environment, sampler, {.resolution = PREFILTER_LEAST_SIDE, .levels = 3});
    const Frame frame(glm::normalize(vec3(1, 2, 3)));
    constexpr double kMost = 0.01;
    for (const Family& family : families()) {
        double worst = 0;
        for (const float roughness : kRoughnesses)
            for (const double cosine : kCosines) {
                Bsdf::Parameters p = family.parameters;
                p.roughness = roughness;
                const Bsdf bsdf = Bsdf::layered(p).rough_part(0);
                const dvec3 wo = direction_at(cosine, 0.1);
                const dvec3 truth =
                    scattered(bsdf, p, wo, p.eta < 1 ? 700 : 300, [](const dvec3&) { return 1.0; }) * dvec3(radiance);
                const dvec3 split(EnvironmentLight::reflected(maps, frame, bsdf, vec3(wo)));
                for (int c = 0; c < 3; ++c) {
                    if (truth[c] == 0) {
                        EXPECT_EQ(split[c], 0) << family.name;
                        continue;
                    }
                    worst = std::max(worst, std::fabs(split[c] / truth[c] - 1));
                    EXPECT_NEAR(split[c] / truth[c], 1, kMost)
                        << family.name << ", roughness " << roughness << ", cos " << cosine << ", channel " << c;
                }
            }
        std::printf("%-30s off by %.2f %% at most\n", family.name, 100 * worst);
    }
    const Bsdf lambert = Bsdf::lambert({0, 0, 1}, Rgb(0.5f));
    EXPECT_NEAR(EnvironmentLight::reflected(maps, frame, lambert, {0, 0, 1}).x, 1, 1e-5);
    EXPECT_EQ(EnvironmentLight::reflected(maps, frame, lambert, {0, 0.6f, -0.8f}), Rgb(0));
    EXPECT_EQ(EnvironmentLight::reflected(maps, frame, Bsdf(), {0, 0, 1}), Rgb(0));
}

/// Mean over normals all around of |split sum - truth|, over the mean of the truth.
double split_sum_error(const PrefilteredEnvironment& maps, const EnvironmentSampler& sampler, const Bsdf::Parameters& p,
                       double cosine, int steps) {
    constexpr size_t kNormals = 192;
    constexpr double kGolden = 0.618033988749895, kPlastic = 0.754877666246693;
    const Bsdf bsdf = Bsdf::layered(p).rough_part(0);
    std::vector<double> errors(kNormals), truths(kNormals);
    parallel_for(kNormals, 1, [&](size_t i) {
        const double n = static_cast<double>(i) + 0.5;
        const Frame frame(vec3(direction_at(1 - 2 * n / kNormals, n * kGolden)));
        const dvec3 wo = direction_at(cosine, n * kPlastic);
        truths[i] = scattered(bsdf, p, wo, steps, [&](const dvec3& wi) {
                        return static_cast<double>(mean(sampler.radiance(frame.to_world(vec3(wi)))));
                    }).x;
        const Rgb split = EnvironmentLight::reflected(maps, frame, bsdf, vec3(wo));
        errors[i] = std::fabs(static_cast<double>(mean(split)) - truths[i]);
    });
    return std::reduce(errors.begin(), errors.end()) / std::reduce(truths.begin(), truths.end());
}

/// The tables of docs/image-based-lighting/README.md.
TEST(EnvironmentLight, LongErrorOfTheSplitSumByRoughnessAndAngle) {
    constexpr Size2 kSize{512, 256};
    const std::vector<std::pair<const char*, Environment>> environments = {
        {"Sky", test::sky(kSize)}, {"Sky with a sun", test::sky_with_sun(kSize)}, {"Windows", test::windows(kSize)}};
    const std::vector<float> roughnesses = {0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f};
    const std::vector<double> cosines = {1, 0.9, 0.7, 0.5, 0.3, 0.1};
    for (const bool metal : {true, false})
        for (const auto& [name, environment] : environments) {
            const EnvironmentSampler sampler(environment);
            const PrefilteredEnvironment maps(environment, sampler, {});
            std::printf("\n%s, %s\n\n| roughness |", metal ? "Metal" : "Coat over white", name);
            for (const double cosine : cosines) std::printf(" %.0f deg |", std::acos(cosine) * 180 / M_PI);
            std::printf("\n|---|---|---|---|---|---|---|\n");
            for (const float roughness : roughnesses) {
                std::printf("| %.2f |", static_cast<double>(roughness));
                for (const double cosine : cosines) {
                    const Bsdf::Parameters p{.metallic = metal ? 1.0f : 0.0f, .roughness = roughness};
                    const double error = split_sum_error(maps, sampler, p, std::min(cosine, 0.9999), metal ? 300 : 400);
                    std::printf(" %.1f %% |", 100 * error);
                    // Straight on the lobe is as it was blurred, but that G is the cosine there.
                    EXPECT_LT(error, cosine == 1 ? 0.15 : 1.0) << name << ", roughness " << roughness;
                }
                std::printf("\n");
            }
        }
}

}  // namespace
}  // namespace photond::environment_light_test
