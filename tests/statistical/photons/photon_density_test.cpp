// Density estimation where the answer is known to rounding: on the inside of a sphere.
//
// A unit sphere emits radiance 1 and reflects the share rho of what arrives. A cosine-distributed ray from anywhere on
// it meets it anywhere with the same probability, so photons are uniform, and the irradiance by photons of at least n
// scatterings is pi rho^n / (1 - rho). The part of the sphere within distance r of one of its points has the area
// pi r^2 for every r (derivations.md, "Furnace sphere"): no curvature bias, whatever the kernel and the radius. The
// sphere is the analytic one: a tessellated one would be another surface.

#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <string>

#include "renderer/core/rng.h"
#include "renderer/photons/radiance_estimate.h"
#include "tests/support/statistics.h"

namespace photond::photon_density_test {
namespace {

using test::Interval;

constexpr double kFalseAlarm = 1e-6;   // chance that some set of seeds fails a test below without a defect
constexpr double kMustDetect = 0.005;  // a relative error this large may not go unnoticed
constexpr size_t kReplicates = 64;
constexpr uint32_t kAny = UINT32_MAX;
constexpr double kAlbedo = 0.5;

vec3 on_sphere(const vec2& u) {
    const float z = 1 - 2 * u.x, s = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
    return {s * std::cos(phi), s * std::sin(phi), z};
}

/// The photons of `paths` light paths that scattered at least `fewest` times. Path lengths are those of Russian
/// roulette, whose numbers are stratified over the paths: each path's law is what it would be, and the number of
/// photons has next to no noise of its own.
std::vector<Photon> trace(uint32_t paths, uint32_t fewest, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    const Rgb power_w(static_cast<float>(4 * std::numbers::pi * std::numbers::pi / paths));  // area x pi x radiance
    std::vector<Photon> photons;
    photons.reserve(static_cast<size_t>(paths / (1 - kAlbedo)) + 64);
    for (uint32_t path = 0; path < paths; ++path) {
        const double u = 1 - (path + double{random.next()}) / paths;
        const uint32_t scatterings = static_cast<uint32_t>(std::log(u) / std::log(kAlbedo));
        vec3 y = on_sphere(random.next_2d());
        for (uint32_t n = 0; n <= scatterings; ++n) {
            // From y inwards, to where the ray meets the sphere again.
            const vec3 w = Frame(-y).to_world(sample_cosine_hemisphere(random.next_2d()));
            const vec3 hit = glm::normalize(y - 2 * glm::dot(y, w) * w);
            if (n >= fewest) photons.push_back({hit, PhotonPayload::make(power_w, -w, -hit, n, false)});
            y = hit;
        }
    }
    return photons;
}

double expected_irradiance(uint32_t fewest) { return std::numbers::pi * std::pow(kAlbedo, fewest) / (1 - kAlbedo); }

/// Mean of estimate(point on the sphere) over about `count` points, one in each of as many parts of equal area.
template <class Estimate>
double mean_over_sphere(uint32_t count, RandomStream& random, const Estimate& estimate) {
    const uint32_t rows = static_cast<uint32_t>(std::sqrt(count / 2.0)), columns = 2 * rows;
    double sum = 0;
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const vec2 u = random.next_2d();
            sum += estimate(on_sphere({(static_cast<float>(row) + u.x) / static_cast<float>(rows),
                                       (static_cast<float>(column) + u.y) / static_cast<float>(columns)}));
        }
    }
    return sum / (rows * columns);
}

constexpr std::array kShapes = {KernelShape::Constant, KernelShape::Cone, KernelShape::Gaussian,
                                KernelShape::Epanechnikov};
constexpr std::array<uint32_t, 3> kCounts = {10, 50, 200};
constexpr uint32_t kPointsPerDisc = 4;  // their mean is then as good as that of the photons, nearly

/// Searches that find about k photons of so many on the sphere.
std::array<PhotonSearch, 2> searches(uint32_t k, size_t photons) {
    const float radius_m = 2 * std::sqrt(static_cast<float>(k) / static_cast<float>(photons));
    return {{{.kind = PhotonSearch::Kind::Nearest, .nearest = k, .radius_m = 0.49f},
             {.kind = PhotonSearch::Kind::Radius, .radius_m = radius_m}}};
}

void expect_covers(const std::vector<double>& means, double exact, size_t checks, const std::string& what) {
    const Interval measured = test::mean_interval(means, kFalseAlarm, checks);
    EXPECT_LE(std::fabs(measured.mean - exact), measured.half_width)
        << what << ": " << measured.mean << " instead of " << exact;
    EXPECT_LE(2 * measured.half_width, kMustDetect * exact) << what << ": too noisy to notice a defect";
}

TEST(FurnaceSphere, PhotonDensityIsTheClosedForm) {
    constexpr uint32_t kPaths = 25'000, kFewest = 1;
    constexpr size_t kChecks = kCounts.size() * kShapes.size() * 2;
    std::vector<double> means[kCounts.size()][2][kShapes.size()];
    Neighbours scratch;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const std::vector<Photon> photons = trace(kPaths, kFewest, seed);
        for (size_t count = 0; count < kCounts.size(); ++count) {
            const auto kinds = searches(kCounts[count], photons.size());
            for (size_t kind = 0; kind < kinds.size(); ++kind) {
                const PhotonMap map(photons, kinds[kind]);
                for (size_t shape = 0; shape < kShapes.size(); ++shape) {
                    const EstimateSettings settings{.kernel = Kernel(kShapes[shape])};
                    RandomStream random(seed, RandomDomain::Test, 1, count * 64 + kind * 8 + shape);
                    const uint32_t points = static_cast<uint32_t>(kPointsPerDisc * photons.size() / kCounts[count]);
                    means[count][kind][shape].push_back(mean_over_sphere(points, random, [&](const vec3& p) {
                        return double{estimate_irradiance(map, settings, p, -p, kAny, scratch).x};
                    }));
                }
            }
        }
    }
    for (size_t count = 0; count < kCounts.size(); ++count)
        for (size_t kind = 0; kind < 2; ++kind)
            for (size_t shape = 0; shape < kShapes.size(); ++shape)
                expect_covers(means[count][kind][shape], expected_irradiance(kFewest), kChecks,
                              std::to_string(kCounts[count]) + (kind == 0 ? " nearest" : " by radius") + ", kernel " +
                                  std::to_string(shape));

    // The classical mistake is to count the k-th too. The test for k = 50 would see it.
    const Interval fifty = test::mean_interval(means[1][0][0], kFalseAlarm, kChecks);
    EXPECT_GT(std::fabs(fifty.mean * 50 / 49 - expected_irradiance(kFewest)), 50.0 / 49 * fifty.half_width);
}

TEST(FurnaceSphere, RadianceAndCountsOfScatterings) {
    // All photons, direct light included, so that estimates may leave out those of many scatterings.
    constexpr uint32_t kPaths = 10'000, kCount = 50;
    constexpr size_t kChecks = 2 * 3;
    const Rgb reflectance(0.8f);
    std::vector<double> all[2], radiance[2], at_most_one[2];
    Neighbours scratch;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const std::vector<Photon> photons = trace(kPaths, 0, seed);
        const auto kinds = searches(kCount, photons.size());
        for (size_t kind = 0; kind < kinds.size(); ++kind) {
            const PhotonMap map(photons, kinds[kind]);
            RandomStream random(seed, RandomDomain::Test, 2, kind);
            const uint32_t points = static_cast<uint32_t>(kPointsPerDisc * photons.size() / kCount);
            all[kind].push_back(mean_over_sphere(points, random, [&](const vec3& p) {
                return double{estimate_irradiance(map, {}, p, -p, kAny, scratch).x};
            }));
            at_most_one[kind].push_back(mean_over_sphere(points, random, [&](const vec3& p) {
                return double{estimate_irradiance(map, {}, p, -p, 1, scratch).x};
            }));
            radiance[kind].push_back(mean_over_sphere(points, random, [&](const vec3& p) {
                ShadingPoint point;
                point.position = p;
                point.geometric_normal = -p;
                point.shading = Frame(-p);
                const vec3 wo = sample_cosine_hemisphere(random.next_2d());
                return double{
                    estimate_radiance(map, {}, point, Bsdf::lambert(vec3(0, 0, 1), reflectance), wo, kAny, scratch)
                        .radiance.x};
            }));
        }
    }
    const double exact = expected_irradiance(0);
    for (size_t kind = 0; kind < 2; ++kind) {
        const std::string how = kind == 0 ? "nearest" : "by radius";
        expect_covers(all[kind], exact, kChecks, "irradiance, " + how);
        expect_covers(at_most_one[kind], exact * (1 - kAlbedo * kAlbedo), kChecks, "one scattering at most, " + how);
        expect_covers(radiance[kind], double{reflectance.x} / std::numbers::pi * exact, kChecks, "radiance, " + how);
    }
}

/// Reflected radiance over a plane that uniform radiance of 1 lights, seen along the shading normal, which is tilted by
/// `tilt`; half of the photons lie on facets turned by `bend` the same way. For a Lambert reflector of kReflectance.
constexpr double kReflectance = 0.75;
Interval radiance_by_tilted_normal(double tilt, double bend) {
    constexpr uint32_t kPhotons = 20'000;
    const auto turned = [](double angle) {
        return vec3(std::sin(static_cast<float>(angle)), 0, std::cos(static_cast<float>(angle)));
    };
    const vec3 up(0, 0, 1), facet = turned(bend);
    ShadingPoint point;
    point.geometric_normal = up;
    point.shading = Frame(turned(tilt));
    const Bsdf bsdf = Bsdf::lambert(point.shading.to_local(up), Rgb(static_cast<float>(kReflectance)));
    const PhotonSearch search{.kind = PhotonSearch::Kind::Radius, .radius_m = 2.0f};
    Neighbours scratch;
    const auto means = test::replicates(kReplicates, [&](uint64_t seed) {
        RandomStream random(seed, RandomDomain::Test, 3, 0);
        std::vector<Photon> photons;
        for (uint32_t i = 0; i < kPhotons; ++i) {
            const vec2 place = sample_unit_disk(random.next_2d()) * search.radius_m;
            const vec3& normal = i % 2 ? facet : up;
            const vec3 wi = Frame(normal).to_world(sample_cosine_hemisphere(random.next_2d()));
            const Rgb power_w(static_cast<float>(std::numbers::pi * std::numbers::pi * 4 / kPhotons));
            photons.push_back({vec3(place, 0), PhotonPayload::make(power_w, wi, normal, 1, false)});
        }
        const PhotonMap map(std::move(photons), search);
        return double{estimate_radiance(map, {}, point, bsdf, point.shading.to_local(up), kAny, scratch).radiance.x};
    });
    return test::mean_interval(means, kFalseAlarm, 1);
}

TEST(Plane, ATiltedShadingNormalSeesItsShareOfUniformLight) {
    // Of the hemisphere about the surface the shading normal, tilted by a, sees what reflects rho (1 + cos a) / 2 (less
    // 1e-3 sin a at most, by the least cosine photons are divided by).
    constexpr double kTilt = 0.6, kMustDetectHere = 0.02, kMostBias = 1e-3;
    const double exact = kReflectance * (1 + std::cos(kTilt)) / 2;
    const Interval measured = radiance_by_tilted_normal(kTilt, 0);
    EXPECT_LE(std::fabs(measured.mean - exact), measured.half_width + kMostBias * exact);
    EXPECT_LE(2 * measured.half_width, kMustDetectHere * exact) << "too noisy to notice a defect";
    // Without the quotient of cosines it would be rho.
    EXPECT_GT(std::fabs(kReflectance - exact), 2 * measured.half_width);
}

TEST(Plane, PhotonsOfANeighbouringFacetCountByTheirOwnCosine) {
    // A smooth normal half way between two facets, a from either. What it sees of the light that meets the other facet
    // comes from above both horizons, and reflects rho cos a. By the point's own cosine the sum is 42 % too large.
    constexpr double kTilt = 0.35, kMustDetectHere = 0.02, kMostBias = 3e-3;  // normals are stored to 2e-3
    const double exact = kReflectance * ((1 + std::cos(kTilt)) / 2 + std::cos(kTilt)) / 2;
    const Interval measured = radiance_by_tilted_normal(kTilt, 2 * kTilt);
    EXPECT_LE(std::fabs(measured.mean - exact), measured.half_width + kMostBias * exact);
    EXPECT_LE(2 * measured.half_width, kMustDetectHere * exact) << "too noisy to notice a defect";
}

}  // namespace
}  // namespace photond::photon_density_test
