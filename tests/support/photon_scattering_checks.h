#pragma once
// That photons carry what the eye finds, checked of whoever scatters them: the C++ and its GLSL twin by the same code.

#include <gtest/gtest.h>

#include <functional>
#include <span>

#include "renderer/core/rng.h"
#include "renderer/transport/photon_scattering.h"
#include "tests/support/bsdf_quadrature.h"
#include "tests/support/leaning_triangle.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// Cells over the sphere of directions: equal solid angles but for the last of each side of the surface, where a
/// leaning normal makes the eye use the geometric one.
struct DirectionCells {
    static constexpr int kRings = 8, kAzimuths = 8;
    static constexpr size_t kCells = kRings * kAzimuths;
    static constexpr double kEdges[kRings + 1] = {-1, -0.6, -0.3, -0.12, 0, 0.12, 0.3, 0.6, 1};

    static size_t cell(const vec3& w) {
        int ring = 0;
        while (ring + 1 < kRings && static_cast<double>(w.z) > kEdges[ring + 1]) ++ring;
        const double turn = 0.5 + std::atan2(static_cast<double>(w.y), static_cast<double>(w.x)) / (2 * M_PI);
        return static_cast<size_t>(ring * kAzimuths + std::clamp(static_cast<int>(turn * kAzimuths), 0, kAzimuths - 1));
    }
    /// A direction in the cell, from two numbers in [0, 1).
    static vec3 direction(size_t cell, double x, double y) {
        const int ring = static_cast<int>(cell) / kAzimuths, azimuth = static_cast<int>(cell) % kAzimuths;
        const double z = kEdges[ring] + (kEdges[ring + 1] - kEdges[ring]) * x;
        return vec3(direction_at(z, (azimuth + y) / kAzimuths + 0.5));
    }
    static double solid_angle(size_t cell) {
        const size_t ring = cell / kAzimuths;
        return (kEdges[ring + 1] - kEdges[ring]) * 2 * M_PI / kAzimuths;
    }
};

/// A mean and its variance.
struct Estimate {
    double mean = 0, variance = 0;
};

/// Power per solid angle that leaves towards `out` over power that arrives from wi, as the eye sees it:
/// f |cos_s(wi)| |cos_g(out)| / |cos_g(wi)|.
inline double seen_towards(const Scene& scene, const Case& c, float outside_ior, const vec3& wi, const vec3& out) {
    const ShadingPoint point = make_shading_point(scene, kHit, -out);
    const Bsdf bsdf = part_of(make_bsdf(scene, point, outside_ior), c.part);
    const Rgb f_cos = bsdf.f_cos(point.shading.to_local(out), point.shading.to_local(wi));
    return static_cast<double>(f_cos.x * std::fabs(glm::dot(point.geometric_normal, out)) /
                               std::fabs(glm::dot(point.geometric_normal, wi)));
}

/// Integral of density(out) over each cell: two random points in each of kSteps^2 strata, whose differences say how
/// much the mean varies.
template <class Density>
std::vector<Estimate> integrate_over_cells(const Density& density) {
    constexpr int kSteps = 16;
    std::vector<Estimate> cells(DirectionCells::kCells);
    RandomStream random(11, RandomDomain::Test, 0, 0);
    for (size_t i = 0; i < cells.size(); ++i) {
        const auto sample = [&](int row, int column) {
            const double x = (row + static_cast<double>(random.next())) / kSteps;
            const double y = (column + static_cast<double>(random.next())) / kSteps;
            return density(DirectionCells::direction(i, x, y)) * DirectionCells::solid_angle(i) / (kSteps * kSteps);
        };
        for (int row = 0; row < kSteps; ++row)
            for (int column = 0; column < kSteps; ++column) {
                const double a = sample(row, column), b = sample(row, column);
                cells[i].mean += (a + b) / 2;
                cells[i].variance += (a - b) * (a - b) / 4;
            }
    }
    return cells;
}

/// What the eye sees of light from wi: power that leaves into each cell over power that arrives.
inline std::vector<Estimate> seen_by_eye(const Scene& scene, const Case& c, float outside_ior, const vec3& wi) {
    return integrate_over_cells([&](const vec3& out) { return seen_towards(scene, c, outside_ior, wi, out); });
}

/// Photons that arrive from wi at kHit, each scattered by its three numbers (u_lobe, u).
using ScatterMany = std::function<std::vector<PhotonScattering>(const Scene& scene, const Case& c, float outside_ior,
                                                                const vec3& wi, std::span<const vec3> numbers)>;

struct Carried {
    std::vector<Estimate> cells;
    double greatest_weight = 0;
    double photons = 0;
};

inline Carried carried_by_photons(const Scene& scene, const Case& c, float outside_ior, const vec3& wi,
                                  const ScatterMany& scatter, size_t photons, uint64_t stream) {
    std::vector<double> sums(DirectionCells::kCells), squares(DirectionCells::kCells);
    RandomStream random(12, RandomDomain::Test, 0, stream);
    std::vector<vec3> numbers(photons);
    for (vec3& n : numbers) {
        const float u_lobe = random.next();
        n = vec3(u_lobe, random.next_2d());
    }
    Carried carried;
    carried.photons = static_cast<double>(photons);
    for (const PhotonScattering& s : scatter(scene, c, outside_ior, wi, numbers)) {
        if (!s.valid()) continue;
        const double weight = static_cast<double>(s.weight.x);
        const size_t cell = DirectionCells::cell(s.direction);
        sums[cell] += weight, squares[cell] += weight * weight;
        carried.greatest_weight = std::max(carried.greatest_weight, weight);
    }
    for (size_t i = 0; i < sums.size(); ++i) {
        const double mean = sums[i] / carried.photons;
        carried.cells.push_back({mean, (squares[i] / carried.photons - mean * mean) / carried.photons});
    }
    return carried;
}

/// Greatest deviation in standard errors. The photons' variance is at least what the greatest weight makes likely, as a
/// few photons do not say how much their number varies; cells where fewer than 25 of these are expected are pooled.
inline double greatest_deviation(const std::vector<Estimate>& seen, const Carried& carried) {
    double greatest = 0, pooled = 0;
    Estimate pooled_seen, pooled_carried;
    const auto check = [&](const Estimate& eye, const Estimate& photons) {
        const double variance = std::max(photons.variance, carried.greatest_weight * eye.mean / carried.photons);
        greatest = std::max(greatest, std::fabs(eye.mean - photons.mean) / std::sqrt(variance + eye.variance + 1e-14));
    };
    for (size_t i = 0; i < seen.size(); ++i) {
        if (seen[i].mean * carried.photons >= 25 * carried.greatest_weight) {
            check(seen[i], carried.cells[i]);
            continue;
        }
        pooled_seen.mean += seen[i].mean, pooled_seen.variance += seen[i].variance;
        pooled_carried.mean += carried.cells[i].mean, pooled_carried.variance += carried.cells[i].variance;
        ++pooled;
    }
    if (pooled > 0) check(pooled_seen, pooled_carried);
    return greatest;
}

/// Power by photons is what the eye sees of light from each of kLights, cell by cell. Returns how often some of it left
/// towards the lowest directions above the surface, where the eye's frame may be another than the photon's.
inline size_t expect_photons_carry_what_the_eye_finds(const ScatterMany& scatter, const std::vector<Case>& list,
                                                      std::span<const Normals> all_normals, size_t photons,
                                                      double false_alarm) {
    const double z = two_sided_z(share_of_false_alarm(
        false_alarm, list.size() * all_normals.size() * std::size(kLights) * DirectionCells::kCells));
    uint64_t stream = 0;
    size_t below = 0;
    for (const Case& c : list)
        for (const Normals normals : all_normals) {
            Scene scene = triangle_scene(c.material, normals);
            finish_scene(scene);
            for (const vec3& wi : kLights) {
                const std::vector<Estimate> seen = seen_by_eye(scene, c, c.outside_ior, wi);
                const Carried carried = carried_by_photons(scene, c, c.outside_ior, wi, scatter, photons, ++stream);
                EXPECT_LT(greatest_deviation(seen, carried), z) << c.name << ", normals " << static_cast<int>(normals)
                                                                << ", light " << wi.x << " " << wi.y << " " << wi.z;
                below += seen[5 * DirectionCells::kAzimuths].mean > 1e-3;
                // No photon is worth much more than what arrived, whatever the frames: grazing light on leaning
                // surfaces may be scattered six times over (cos_s / cos_g), and draws that are needed are not rare.
                EXPECT_LT(carried.greatest_weight, 60) << c.name << ", normals " << static_cast<int>(normals);
            }
        }
    return below;
}

}  // namespace photond::test
