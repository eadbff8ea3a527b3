// What a photon brings to a point, against integrals in double precision: the form factor of the clipped sphere by
// quadrature, and the mean over a photon's directions by stratified sampling.

#include "renderer/methods/photon_splatting/connect_weight.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "renderer/core/rng.h"
#include "renderer/methods/photon_splatting/splat_lanes.h"
#include "renderer/transport/sampling.h"
#include "tests/support/statistics.h"

namespace photond::connect_weight_test {
namespace {

constexpr double kPiD = 3.14159265358979323846;

float factor(double h, double c) {
    return horizon_factor(FloatLanes(static_cast<float>(h * h)), FloatLanes(static_cast<float>(c)))[0];
}

/// P of [connect_weight.h]: the chance that a cosine-distributed ray passes within 1 of a point at distance h whose
/// direction has cosine c. Rays pass within u = h sin(g), g their angle from the axis towards the point; the cosine's
/// integral over the azimuth, max(0, A + B cos(phi)) with A = c cos(g) and B = sqrt(1 - c^2) sin(g), is closed.
double chance_of_passing(double h, double c) {
    if (h <= 1) return 1;  // the ray begins within the sphere
    const double s = std::sqrt(1 - c * c);
    const auto ring = [&](double g) {
        const double a = c * std::cos(g), b = s * std::sin(g);
        if (a >= b) return 2 * kPiD * a;
        const double phi = std::acos(-a / b);
        return 2 * (a * phi + b * std::sin(phi));
    };
    const double most = std::asin(1 / h), horizon = std::min(most, std::asin(c));  // rings above it are whole
    constexpr int kSteps = 4000;
    double sum = 0;
    // Simpson's rule; from the horizon on in the root of the distance from there, where the ring has a root of its own.
    for (int i = 0; i <= kSteps; ++i) {
        const double share = static_cast<double>(i) / kSteps, weight = i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2;
        const double below = horizon * share, above = horizon + (most - horizon) * share * share;
        sum += weight *
               (ring(below) * std::sin(below) * horizon + ring(above) * std::sin(above) * 2 * share * (most - horizon));
    }
    return sum / (3 * kSteps) / kPiD;
}

TEST(ConnectWeight, TheQuadratureKnowsItsClosedForms) {
    // Whole spheres: c / H^2 (their form factor). A hemisphere of directions about the axis: (1 + c) / 2.
    for (const double c : {0.5, 0.8, 1.0}) {
        EXPECT_NEAR(chance_of_passing(2.5, c), c / 6.25, 1e-9);
        EXPECT_NEAR(chance_of_passing(1 + 1e-12, c), (1 + c) / 2, 2e-6);
    }
    // A sphere that the horizon halves: half of the cosine lobe's wedge, (alpha - sin(alpha) cos(alpha)) / pi.
    const double alpha = std::asin(1 / 3.0);
    EXPECT_NEAR(chance_of_passing(3, 1e-9), (alpha - std::sin(alpha) * std::cos(alpha)) / kPiD, 1e-8);
}

TEST(ConnectWeight, HorizonFactorIsTheInverseOfTheChanceOfPassing) {
    double worst = 0;
    for (int i = 0; i <= 90; ++i) {
        const double h = 0.2 * std::pow(5000.0, i / 90.0);  // 0.2 ... 1000
        for (int j = 0; j <= 60; ++j) {
            const double c = std::min(1.0, std::pow(10.0, -5 + 5.0 * j / 60));
            // What the float code was given, exactly.
            const double h_given = std::sqrt(double{static_cast<float>(h * h)}), c_given{static_cast<float>(c)};
            const double expected = c_given / (h_given * h_given * chance_of_passing(h_given, c_given));
            const double error = std::abs(double{factor(h, c)} / expected - 1);
            worst = std::max(worst, error);
            EXPECT_LE(error, 1e-4) << "H " << h << ", cosine " << c;
        }
    }
    std::printf("greatest relative error %.2g\n", worst);
}

TEST(ConnectWeight, IsOneFromWhereTheHorizonFreesTheSphere) {
    for (const double h : {1.01, 1.5, 4.0, 50.0, 999.0}) {
        EXPECT_EQ(factor(h, std::min(1.0, 1.001 / h)), 1.0f) << h;
        // No step there: what is clipped comes up to 1 from above as the sphere rises.
        EXPECT_NEAR(factor(h, 0.9999 / h), 1.0f, 2e-5f) << h;
        EXPECT_NEAR(factor(h, 0.99 / h), factor(h, 0.9901 / h), 2e-4f) << h;
    }
    EXPECT_EQ(factor(5, 1), 1.0f);
}

// A photon's half-line looks forward from outside of the sphere, and counts always from within: the chance jumps from
// (1 + c)/2 to 1 at H = 1, and the factor by its inverse. Nothing else may happen there.
TEST(ConnectWeight, JumpsByTheRaysThatLookAwayWhereTheSphereIsEntered) {
    for (const double c : {0.01, 0.1, 0.5, 0.9, 1.0}) {
        EXPECT_NEAR(double{factor(1 - 1e-6, c)}, c, 1e-5 * c);
        EXPECT_NEAR(double{factor(1 + 1e-6, c)}, 2 * c / (1 + c), 5e-3 * c) << c;
        EXPECT_GE(factor(1 + 1e-6, c), 0.9999f * factor(1 - 1e-6, c));
    }
}

TEST(ConnectWeight, StaysFiniteAtTheExtremes) {
    for (const double h : {0.0, 1e-30, 1e-15, 1e-6, 0.5, 1.0, 1 + 1e-7, 1e3, 1e6, 1e12, 1e18})
        for (const double c : {1e-38, 1e-20, 1e-7, 1e-3, 0.5, 1 - 6e-8, 1.0}) {
            const float f = factor(h, c);
            EXPECT_TRUE(std::isfinite(f)) << "H " << h << ", cosine " << c;
            EXPECT_GE(f, 0) << "H " << h << ", cosine " << c;
            // The clamp takes what the inverse square of a short way adds.
            const FloatLanes d_sq = static_cast<float>(std::max(h * h, 1e-37));
            const float clamped = connect_factor(d_sq, FloatLanes(static_cast<float>(c)), 1, 1)[0];
            EXPECT_TRUE(std::isfinite(clamped)) << "H " << h << ", cosine " << c;
            if (h <= 1) {
                EXPECT_LE(clamped, 1.001f * static_cast<float>(c)) << "H " << h;
            }
        }
}

TEST(ConnectWeight, ArcSineIsAccurate) {
    for (int i = 0; i <= 1000; ++i) {
        const float x = static_cast<float>(i) / 1000;
        EXPECT_NEAR(asin_lanes(FloatLanes(x))[0], std::asin(x), 6e-7f) << x;
    }
}

// --- whole splats

const Kernel kFilters[] = {Kernel(KernelShape::Constant), Kernel(KernelShape::Cone, 1.0f),
                           Kernel(KernelShape::Gaussian)};

struct Receiving {
    dvec3 position, normal;
};

/// Points about a photon at the origin that leaves the plane z = 0, for splats of radius 1: far, near the horizon,
/// within the splat's radius, and where both meet.
std::vector<Receiving> points_about() {
    std::vector<Receiving> points;
    for (const double d : {0.15, 0.5, 0.9, 1.1, 2.1, 4.0})
        for (const double c : {1.0, 0.6, 0.2, 0.05}) {
            const double s = std::sqrt(1 - c * c), turn = 2.4 * static_cast<double>(points.size());
            const dvec3 w(s * std::cos(turn), s * std::sin(turn), c);
            const dvec3 normal = glm::normalize(-w + 0.6 * dvec3(std::cos(5 * turn), std::sin(3 * turn), 0.3));
            points.push_back({d * w, normal});
        }
    return points;
}

std::vector<PointBlock> blocks_of(const std::vector<Receiving>& points) {
    std::vector<PointBlock> blocks((points.size() + kLanes - 1) / kLanes);
    for (size_t i = 0; i < blocks.size() * kLanes; ++i) {
        const Receiving& point = points[std::min(i, points.size() - 1)];
        PointBlock& block = blocks[i / kLanes];
        block.position.set(i % kLanes, vec3(point.position));
        block.normal.set(i % kLanes, vec3(point.normal));
        block.geometric_normal.set(i % kLanes, vec3(point.normal));
    }
    return blocks;
}

/// Irradiance at each point by photons of one watt from y: mean over a grid of directions, jittered, with splats of
/// that radius.
std::vector<double> mean_irradiance(const std::vector<Receiving>& points, const Kernel& filter, float radius,
                                    float clamp_sq, uint64_t seed) {
    constexpr uint32_t kSide = 128;
    const std::vector<PointBlock> blocks = blocks_of(points);
    std::vector<double> sums(points.size(), 0);
    RandomStream random(seed, RandomDomain::Splats, 0, 0);
    // Each disc alone has the exact mean: a table does not change it.
    std::array<float, 1024> discs;
    for (size_t i = 0; i < discs.size(); ++i)
        discs[i] = filter.sample_disc((static_cast<float>(i) + 0.5f) / static_cast<float>(discs.size()));
    for (uint32_t i = 0; i < kSide * kSide; ++i) {
        const vec2 u = (vec2(i % kSide, i / kSide) + random.next_2d()) / static_cast<float>(kSide);
        Splat splat;
        splat.axis = sample_cosine_hemisphere(glm::min(u, vec2(0x1.fffffep-1f)));
        splat.normal = vec3(0, 0, 1);
        splat.intensity = Rgb(1);
        // Another number than the directions' grid has.
        splat.disc = discs[static_cast<size_t>(random.next() * 1024)];
        const SplatBroadcast wide(splat, radius);
        for (size_t b = 0; b < blocks.size(); ++b) {
            const SplatGain gain = connect_gain<Receiver::FlatLambert>(splat, wide, blocks[b], filter, clamp_sq);
            for (size_t lane = 0; lane < kLanes && b * kLanes + lane < points.size(); ++lane)
                sums[b * kLanes + lane] += double{gain.gain[lane]};
        }
    }
    for (double& sum : sums) sum /= double{kSide} * kSide;
    return sums;
}

// The mean over the directions of a photon is the transport from y to x, for any radius, filter and place.
TEST(ConnectWeight, MeanOverDirectionsIsTheExactTransport) {
    constexpr double kFalseAlarm = 1e-6;
    constexpr size_t kReplicates = 24;
    const std::vector<Receiving> points = points_about();
    // A splat of a cell of several photons is wider than the clamp.
    const std::pair<float, float> kRadiusAndClamp[] = {{1.0f, 1.0f}, {2.0f, 1.0f}, {1.0f, 1.0f / 16}};
    const size_t checks = points.size() * std::size(kFilters) * std::size(kRadiusAndClamp);
    double worst = 0, widest = 0;
    for (const Kernel& filter : kFilters)
        for (const auto& [radius, clamp_sq] : kRadiusAndClamp) {
            std::vector<std::vector<double>> of_point(points.size());
            for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
                const std::vector<double> mean = mean_irradiance(points, filter, radius, clamp_sq, seed);
                for (size_t i = 0; i < points.size(); ++i) of_point[i].push_back(mean[i]);
            }
            for (size_t i = 0; i < points.size(); ++i) {
                const dvec3& x = points[i].position;
                const double d = glm::length(x), cos_y = x.z / d;
                const double cos_x = std::max(0.0, glm::dot(points[i].normal, -x / d));
                const double exact = cos_y * cos_x / (kPiD * std::max(d * d, double{clamp_sq}));
                const test::Interval interval = test::mean_interval(of_point[i], kFalseAlarm, checks);
                const double rounding = 2e-5 * exact;  // of horizon_factor()
                EXPECT_LE(std::abs(interval.mean - exact), interval.half_width + rounding)
                    << "d " << d << ", cosine " << cos_y << ", filter " << int(filter.shape()) << ", radius " << radius;
                // Few of the cosine's directions go near the horizon.
                const double must_detect = cos_y > 0.5 ? 0.04 : 0.25;
                EXPECT_LE(interval.half_width, must_detect * exact) << "too noisy: d " << d << ", cosine " << cos_y;
                worst = std::max(worst, std::abs(interval.mean / exact - 1));
                widest = std::max(widest, interval.half_width / exact);
            }
        }
    std::printf("greatest relative difference %.4f, greatest half-width %.4f\n", worst, widest);
}

TEST(ConnectWeight, ReceiversBelowTheHorizonOrTurnedAwayGetNothing) {
    std::vector<Receiving> points(kLanes, {dvec3(0, 0, 0.5), dvec3(0, 0, -1)});
    points[0] = {dvec3(0.1, 0, 0.5), dvec3(0, 0, 1)};        // turned away
    points[1] = {dvec3(0.1, 0, -0.5), dvec3(0, 0, 1)};       // below y's surface
    points[2] = {dvec3(0.1, 0, 0), dvec3(0, 0, 1)};          // in its plane
    points[3] = {dvec3(1.2, 0, 0.5), dvec3(0, 0, -1)};       // beyond the radius
    points[4] = {dvec3(0, 0, 0), dvec3(0, 0, -1)};           // y itself
    points[5] = {dvec3(1e18, 1e18, 1e18), dvec3(-1, 0, 0)};  // past a cluster's end
    PointBlock block = blocks_of(points)[0];
    block.geometric_normal.set(6, vec3(0, 0, 1));  // a smooth normal that leans over
    Splat splat;
    splat.axis = splat.normal = vec3(0, 0, 1);
    splat.radius = splat.disc = 1;
    for (const Kernel& filter : kFilters) {
        const SplatBroadcast wide(splat, 1);
        const auto flat = connect_gain<Receiver::FlatLambert>(splat, wide, block, filter, 1);
        const auto smooth = connect_gain<Receiver::SmoothLambert>(splat, wide, block, filter, 1);
        const auto general = connect_gain<Receiver::General>(splat, wide, block, filter, 1);
        for (const size_t lane : {0u, 1u, 2u, 3u, 4u, 5u}) {
            EXPECT_EQ(flat.gain[lane], 0) << lane;
            EXPECT_FALSE(flat.lit[lane]) << lane;
        }
        EXPECT_TRUE(general.lit[0]);  // its BSDF decides
        for (const size_t lane : {1u, 2u, 3u, 4u, 5u}) EXPECT_FALSE(general.lit[lane]) << lane;
        EXPECT_GT(flat.gain[6], 0);
        EXPECT_EQ(smooth.gain[6], 0);
        EXPECT_EQ(flat.gain[7], smooth.gain[7]);
        EXPECT_EQ(flat.gain[7], general.gain[7]);  // straight below: the cosine is 1
    }
}

// --- beams

/// Irradiance times area over a plane across the beam's axis, or one that leans by that cosine.
double light_on_plane(const Kernel& filter, const vec3& normal) {
    constexpr int kSide = 400;
    Splat splat;
    splat.kind = Splat::Kind::Beam;
    splat.origin = vec3(0.3f, -0.2f, 5);
    splat.axis = vec3(0, 0, -1);
    splat.radius = 0.7f;
    splat.near_m = 1, splat.far_m = 20;
    const SplatBroadcast wide(splat, splat.radius);
    // The part of the plane below the beam's square, in x and y: area dx dy / cos.
    const double area = (1.4 / kSide) * (1.4 / kSide) / double{normal.z};
    double sum = 0;
    PointBlock block{};
    for (size_t lane = 0; lane < kLanes; ++lane)
        block.normal.set(lane, normal), block.geometric_normal.set(lane, normal);
    for (int i = 0; i < kSide * kSide; i += int(kLanes)) {
        for (int lane = 0; lane < int(kLanes); ++lane) {
            const int k = i + lane;
            const vec2 xy =
                vec2(0.3f, -0.2f) + 1.4f * ((vec2(k % kSide, k / kSide) + 0.5f) / static_cast<float>(kSide) - 0.5f);
            block.position.set(size_t(lane), vec3(xy, -(normal.x * xy.x + normal.y * xy.y) / normal.z));
        }
        const SplatGain gain = beam_gain<Receiver::FlatLambert>(splat, wide, block, filter);
        sum += double{std::experimental::reduce(gain.gain)};
    }
    return sum * area / (0.7 * 0.7);
}

TEST(ConnectWeight, BeamsBringTheirPowerToAnyPlane) {
    for (const Kernel& filter : kFilters)
        for (const vec3& normal : {vec3(0, 0, 1), glm::normalize(vec3(1, 0.5f, 1)), glm::normalize(vec3(0, -2, 1))})
            EXPECT_NEAR(light_on_plane(filter, normal), 1, 1e-3) << int(filter.shape()) << ", cosine " << normal.z;
}

TEST(ConnectWeight, BeamsLightTheirPartOfTheRayAlone) {
    std::vector<Receiving> points;
    for (size_t i = 0; i < kLanes; ++i) points.push_back({dvec3(0, 0, -double(i)), dvec3(0, 0, 1)});
    points[3].normal = dvec3(0, 0, -1);
    const PointBlock block = blocks_of(points)[0];
    Splat splat;
    splat.kind = Splat::Kind::Beam;
    splat.axis = vec3(0, 0, -1);
    splat.radius = 1;
    splat.near_m = 2, splat.far_m = 5;
    const SplatGain gain = beam_gain<Receiver::FlatLambert>(splat, SplatBroadcast(splat, 1), block, kFilters[0]);
    for (size_t i = 0; i < kLanes; ++i) {
        const bool lit = i >= 2 && i <= 5 && i != 3;
        EXPECT_EQ(bool(gain.lit[i]), lit) << i;
        EXPECT_FLOAT_EQ(gain.gain[i], lit ? kInvPi : 0.0f) << i;
    }
}

}  // namespace
}  // namespace photond::connect_weight_test
