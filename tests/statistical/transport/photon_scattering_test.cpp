// Light scatters as the eye would have found it: at one surface, direction by direction, against the eye's BSDF in the
// eye's own shading frame; and between two patches by way of a bumpy one.

#include "renderer/transport/photon_scattering.h"

#include <gtest/gtest.h>

#include <span>

#include "renderer/core/rng.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/sampling.h"
#include "tests/support/bsdf_quadrature.h"
#include "tests/support/photon_scattering_checks.h"
#include "tests/support/statistics.h"

namespace photond::photon_scattering_test {
namespace {

using namespace test;

constexpr double kFalseAlarm = 1e-6;  // of each test
constexpr size_t kPhotons = 60'000;

using Scatter = PhotonScattering (*)(const ShadingPoint&, const Bsdf&, const vec3&, float, const vec2&);

/// The BSDF's own weight, as if shading normals were the surface's.
PhotonScattering scatter_naively(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi, float u_lobe,
                                 const vec2& u) {
    const BsdfSample s = bsdf.sample(point.shading.to_local(wi), u_lobe, u, TransportMode::Importance);
    if (!s.valid()) return {};
    return {point.shading.to_world(s.wi), s.weight, s.pdf_sa, s.delta, s.refraction};
}

/// As ScatterMany: photon by photon.
ScatterMany one_by_one(Scatter scatter) {
    return
        [scatter](const Scene& scene, const Case& c, float outside_ior, const vec3& wi, std::span<const vec3> numbers) {
            const ShadingPoint point = make_shading_point(scene, kHit, -wi);
            const Bsdf bsdf = part_of(make_bsdf(scene, point, outside_ior), c.part);
            std::vector<PhotonScattering> scattered;
            scattered.reserve(numbers.size());
            for (const vec3& n : numbers) scattered.push_back(scatter(point, bsdf, wi, n.x, vec2(n.y, n.z)));
            return scattered;
        };
}

TEST(PhotonScattering, CarriesWhatTheEyeFinds) {
    const size_t below = expect_photons_carry_what_the_eye_finds(one_by_one(scatter_photon), cases(), kAllNormals,
                                                                 kPhotons, kFalseAlarm);
    EXPECT_GT(below, 20u);
}

// The density is what the eye sees, direction by direction, on both sides of the surface; so that what connections
// evaluate is what scatter_photon() draws from.
TEST(PhotonScattering, DensityIsWhatTheEyeSees) {
    size_t compared = 0;
    RandomStream random(14, RandomDomain::Test, 0, 0);
    for (const Case& c : cases())
        for (const Normals normals : kAllNormals) {
            const Scene scene = triangle_scene(c.material, normals);
            for (const vec3& wi : kLights) {
                const ShadingPoint point = make_shading_point(scene, kHit, -wi);
                const Bsdf bsdf = part_of(make_bsdf(scene, point), c.part);
                for (int i = 0; i < 300; ++i) {
                    const vec3 out(
                        direction_at(2 * static_cast<double>(random.next()) - 1, static_cast<double>(random.next())));
                    const double seen = seen_towards(scene, c, 1, wi, out);
                    const auto density = static_cast<double>(scatter_density(point, bsdf, wi, out).x);
                    EXPECT_NEAR(density, seen, 1e-3 * seen + 1e-6)  // rounding near the horizon
                        << c.name << ", normals " << static_cast<int>(normals) << ", light " << wi.x << " " << wi.y
                        << " " << wi.z << ", out " << out.x << " " << out.y << " " << out.z;
                    compared += seen > 1e-3;
                }
            }
        }
    EXPECT_GT(compared, 10'000u);
}

// Its integral is the mean weight of what scatter_photon() draws.
TEST(PhotonScattering, DensityIntegratesToTheMeanWeight) {
    const std::vector<Case> list = cases();
    constexpr size_t kChosen[] = {0, 1, 2, 6};  // reflectors
    const double z = two_sided_z(share_of_false_alarm(
        kFalseAlarm, std::size(kChosen) * std::size(kAllNormals) * std::size(kLights) * DirectionCells::kCells));
    uint64_t stream = 1000;
    for (const size_t which : kChosen)
        for (const Normals normals : kAllNormals) {
            const Case& c = list[which];
            const Scene scene = triangle_scene(c.material, normals);
            for (const vec3& wi : kLights) {
                const ShadingPoint point = make_shading_point(scene, kHit, -wi);
                const Bsdf bsdf = part_of(make_bsdf(scene, point), c.part);
                const std::vector<Estimate> integral = integrate_over_cells(
                    [&](const vec3& out) { return static_cast<double>(scatter_density(point, bsdf, wi, out).x); });
                EXPECT_LT(greatest_deviation(integral, carried_by_photons(scene, c, 1, wi, one_by_one(scatter_photon),
                                                                          kPhotons, ++stream)),
                          z)
                    << c.name << ", normals " << static_cast<int>(normals) << ", light " << wi.x << " " << wi.y << " "
                    << wi.z;
            }
        }
}

TEST(PhotonScattering, TheBsdfsOwnWeightWouldBeNoticed) {
    for (const Normals normals : {Normals::Leaning, Normals::Mapped})
        for (const size_t which : {0u, 1u, 2u, 4u}) {
            const Case c = cases()[which];
            const Scene scene = triangle_scene(c.material, normals);
            const std::vector<Estimate> seen = seen_by_eye(scene, c, 1, kLights[3]);
            EXPECT_GT(greatest_deviation(
                          seen, carried_by_photons(scene, c, 1, kLights[3], one_by_one(scatter_naively), kPhotons, 1)),
                      10)
                << c.name;
        }
}

/// Where a delta lobe about `normal` (unit, on wi's side) sends light, in double.
dvec3 leaves_by(const dvec3& wi, const dvec3& normal, double eta, bool refracted) {
    const double cos_i = glm::dot(wi, normal);
    if (!refracted) return 2 * cos_i * normal - wi;
    const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
    return -wi / eta + (cos_i / eta - cos_t) * normal;
}

/// How much the solid angle of a pencil of light grows by, by finite differences.
double widening(const dvec3& wi, const dvec3& normal, double eta, bool refracted) {
    constexpr double kStep = 1e-5;
    const dvec3 a = glm::normalize(glm::cross(wi, dvec3(0.3, 0.5, 0.8))), b = glm::cross(wi, a);
    const auto slope = [&](const dvec3& step) {
        return (leaves_by(glm::normalize(wi + kStep * step), normal, eta, refracted) -
                leaves_by(glm::normalize(wi - kStep * step), normal, eta, refracted)) /
               (2 * kStep);
    };
    return glm::length(glm::cross(slope(a), slope(b)));
}

/// What the eye's own delta samples of direction `out` say of light from wi: weight times probability.
double reflectance_for_eye(const Bsdf& bsdf, const ShadingPoint& eye, const vec3& out, const vec3& wi) {
    constexpr int kStrata = 2048;
    double sum = 0;
    for (int i = 0; i < kStrata; ++i) {
        const BsdfSample s =
            bsdf.sample(eye.shading.to_local(out), (static_cast<float>(i) + 0.5f) / kStrata, vec2(0.5f));
        if (s.valid() && s.delta && glm::distance(eye.shading.to_world(s.wi), wi) < 1e-3f)
            sum += static_cast<double>(s.weight.x) / kStrata;
    }
    return sum;
}

// Mirrors and smooth glass: of light from wi, what leaves by each way the eye may see it is
//   R_eye dsigma(out) / dsigma(wi) |cos_g(out)| / |cos_g(wi)|,
// where the eye's R, of radiance, holds the squared index.
TEST(PhotonScattering, DeltaLobesCarryWhatTheEyeFinds) {
    constexpr int kStrata = 4096;
    Material mirror, glass;
    mirror.base_color = Rgb(0.8f), mirror.roughness = 0;
    glass.metallic = 0, glass.roughness = 0, glass.transmission = 1, glass.solid = true;
    int reflected = 0, refracted = 0, by_geometric_normal = 0;
    RandomStream random(13, RandomDomain::Test, 0, 0);
    for (const Material& material : {mirror, glass})
        for (const Normals normals : kAllNormals) {
            const Scene scene = triangle_scene(material, normals);
            for (int light = 0; light < 200; ++light) {
                const double z = (random.next() < 0.5f ? 1 : -1) * std::pow(static_cast<double>(random.next()), 2);
                const vec3 wi(direction_at(z, static_cast<double>(random.next())));
                if (std::fabs(wi.z) < 0.02f) continue;
                const ShadingPoint point = make_shading_point(scene, kHit, -wi);
                const Bsdf bsdf = make_bsdf(scene, point);
                const vec3 leaning = make_shading_point(scene, kHit, -point.geometric_normal).shading.normal;
                std::vector<std::pair<vec3, double>> ways;
                for (const vec3& normal : {point.geometric_normal, leaning})
                    for (const bool refracts : {false, true}) {
                        const double eta = point.front_side ? 1.5 : 1 / 1.5;
                        const dvec3 n(glm::normalize(dvec3(normal)));
                        if (glm::dot(dvec3(wi), n) < 1e-6) continue;
                        const dvec3 exact = leaves_by(dvec3(wi), n, eta, refracts);
                        if (!(std::fabs(exact.z) > 1e-6)) continue;  // NaN: total reflection
                        const vec3 out(exact);
                        const ShadingPoint eye = make_shading_point(scene, kHit, -out);
                        const double found = reflectance_for_eye(make_bsdf(scene, eye), eye, out, wi) *
                                             widening(dvec3(wi), n, eta, refracts) *
                                             std::fabs(exact.z / static_cast<double>(wi.z));
                        const bool known = std::any_of(ways.begin(), ways.end(), [&](const auto& way) {
                            return glm::distance(way.first, out) < 1e-3f;
                        });
                        if (found <= 0 || known) continue;
                        ways.emplace_back(out, found);
                        ++(refracts ? refracted : reflected);
                        by_geometric_normal += normals != Normals::Flat && normal == point.geometric_normal;
                    }
                std::vector<double> carried(ways.size());
                double elsewhere = 0;
                for (int i = 0; i < kStrata; ++i) {
                    const PhotonScattering s =
                        scatter_photon(point, bsdf, wi, (static_cast<float>(i) + 0.5f) / kStrata, vec2(0.5f));
                    if (!s.valid()) continue;
                    ASSERT_TRUE(s.delta);
                    ASSERT_EQ(s.refraction, (s.direction.z < 0) != (wi.z < 0));
                    size_t way = 0;
                    while (way < ways.size() && glm::distance(ways[way].first, s.direction) > 1e-3f) ++way;
                    (way < ways.size() ? carried[way] : elsewhere) += static_cast<double>(s.weight.x) / kStrata;
                }
                EXPECT_LT(elsewhere, 1e-6) << wi.x << " " << wi.y << " " << wi.z;
                for (size_t way = 0; way < ways.size(); ++way)
                    EXPECT_NEAR(carried[way], ways[way].second, 2e-3 * std::max(1.0, ways[way].second))
                        << "normals " << static_cast<int>(normals) << ", wi " << wi.x << " " << wi.y << " " << wi.z
                        << ", out " << ways[way].first.x << " " << ways[way].first.y << " " << ways[way].first.z;
            }
        }
    EXPECT_GT(reflected, 400);
    EXPECT_GT(refracted, 200);
    EXPECT_GT(by_geometric_normal, 10);
}

// ------------------------------------------------------------------------------------------------ from patch to patch

constexpr float kPatchSide = 1.6f;

/// A square about `centre`, facing along its frame's normal.
struct Patch {
    vec3 centre;
    Frame frame;

    vec3 point(const vec2& u) const {
        return centre + kPatchSide * ((u.x - 0.5f) * frame.tangent + (u.y - 0.5f) * frame.bitangent);
    }
    /// Whether a ray meets its front.
    bool met_by(const vec3& origin, const vec3& direction) const {
        const float cos_theta = -glm::dot(direction, frame.normal);
        if (cos_theta <= 0) return false;
        const float t = glm::dot(origin - centre, frame.normal) / cos_theta;
        if (t <= 0) return false;
        const vec3 p = origin + t * direction - centre;
        return std::fabs(glm::dot(p, frame.tangent)) < 0.5f * kPatchSide &&
               std::fabs(glm::dot(p, frame.bitangent)) < 0.5f * kPatchSide;
    }
};

Patch patch_towards_origin(const vec3& centre) { return {centre, Frame(glm::normalize(-centre))}; }

/// A bumpy square in the xy plane about the origin: interpolated normals or a map of sixteen texels.
Scene bumpy_square(const Material& material, bool mapped) {
    Mesh mesh;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh.uv[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    Scene scene;
    scene.materials = {material};
    if (mapped) {
        Texture texture;
        texture.size = {4, 4};
        RandomStream random(14, RandomDomain::Test, 0, 0);
        for (int i = 0; i < 16; ++i) {
            const auto lean = [&] { return static_cast<uint8_t>(127.5f + 75 * (2 * random.next() - 1)); };
            const uint8_t x = lean();
            texture.texels.emplace_back(x, lean(), 230, 255);
        }
        scene.textures = {texture};
        scene.materials[0].normal_texture.texture = 0;
    } else {
        for (const vec3& p : mesh.positions) mesh.normals.push_back(glm::normalize(vec3(0.5f * p.x, 0.4f * p.y, 1)));
    }
    scene.meshes = {mesh};
    scene.instances = {Instance{}};
    return scene;
}

/// Where a ray meets the square.
Hit hit_square(const vec3& origin, const vec3& direction) {
    const float t = -origin.z / direction.z;
    const vec3 p = origin + t * direction;
    if (!(t > 0) || std::fabs(p.x) > 1 || std::fabs(p.y) > 1) return {};
    const float x = 0.5f * (p.x + 1), y = 0.5f * (p.y + 1);  // barycentrics of the corners: see bumpy_square()
    return x >= y ? Hit{.t = t, .instance = 0, .triangle = 0, .u = x - y, .v = y}
                  : Hit{.t = t, .instance = 0, .triangle = 1, .u = x, .v = y - x};
}

/// A path from a patch by way of the square: where it leaves the square for, and what it carries.
struct Path {
    vec3 position{0}, direction{0};
    double flux = 0;  // of a patch of radiance 1

    double flux_to(const Patch& end) const { return flux > 0 && end.met_by(position, direction) ? flux : 0; }
};

/// A path of light, or one of the eye's when there is no `scatter`.
Path path_from(const Patch& start, const Scene& scene, Scatter scatter, RandomStream& random) {
    const vec3 origin = start.point(random.next_2d());
    const vec3 direction = start.frame.to_world(sample_cosine_hemisphere(random.next_2d()));
    const Hit hit = hit_square(origin, direction);
    const float u_lobe = random.next();
    const vec2 u = random.next_2d();
    if (!hit.valid()) return {};
    const ShadingPoint point = make_shading_point(scene, hit, direction);
    const Bsdf bsdf = make_bsdf(scene, point);
    Path path{.position = point.position};
    Rgb weight(0);
    if (scatter != nullptr) {
        const PhotonScattering s = scatter(point, bsdf, -direction, u_lobe, u);
        weight = s.weight, path.direction = s.direction;
    } else if (const BsdfSample s = bsdf.sample(point.shading.to_local(-direction), u_lobe, u); s.valid()) {
        weight = s.weight, path.direction = point.shading.to_world(s.wi);
    }
    path.flux = M_PI * static_cast<double>(sqr(kPatchSide) * weight.x);
    return path;
}

constexpr int kPaths = 500'000;

/// Flux that `lamp` (radiance 1) sends to each target by way of the square; the same photons for all targets.
std::vector<RunningMean> flux_by_photons(const Scene& scene, const Patch& lamp, std::span<const Patch> targets,
                                         Scatter scatter) {
    RandomStream random(15, RandomDomain::Test, 0, 0);
    std::vector<RunningMean> flux(targets.size());
    for (int i = 0; i < kPaths; ++i) {
        const Path path = path_from(lamp, scene, scatter, random);
        for (size_t k = 0; k < targets.size(); ++k) flux[k].add(path.flux_to(targets[k]));
    }
    return flux;
}

/// The same, as the target finds it.
RunningMean flux_by_eye(const Scene& scene, const Patch& lamp, const Patch& target) {
    RandomStream random(16, RandomDomain::Test, 0, 0);
    RunningMean flux;
    for (int i = 0; i < kPaths; ++i) flux.add(path_from(target, scene, nullptr, random).flux_to(lamp));
    return flux;
}

/// How far the flux by photons is from that by eye paths.
struct Disagreement {
    Disagreement(const RunningMean& by_photons, const RunningMean& by_eye) {
        const double error = std::hypot(by_photons.standard_error(), by_eye.standard_error());
        standard_errors = std::fabs(by_photons.mean() - by_eye.mean()) / error;
        relative_error = error / by_eye.mean();
    }

    double standard_errors;
    double relative_error;  // standard error over the flux
};

TEST(PhotonScattering, BetweenTwoPatchesLightAndEyeAgree) {
    std::vector<Case> list = cases();
    list.resize(5);  // Lambert, coated, metal, sheet, glass
    list.push_back({"smooth glass", list[4].material});
    list.back().material.roughness = 0;
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, list.size() * 2 * 3));
    const Patch lamp = patch_towards_origin({-0.9f, 0.1f, 0.7f});
    // Across the square, past it (grazing), and below.
    const Patch targets[] = {patch_towards_origin({0.8f, 0.3f, 0.8f}), patch_towards_origin({1.4f, 0.4f, 0.3f}),
                             patch_towards_origin({0.4f, 0.2f, -0.8f})};
    double naive = 0;
    for (const Case& c : list)
        for (const bool mapped : {false, true}) {
            const Scene scene = bumpy_square(c.material, mapped);
            const auto lit = std::span(targets).first(c.material.transmission > 0 ? 3 : 2);
            const std::vector<RunningMean> by_photons = flux_by_photons(scene, lamp, lit, scatter_photon);
            for (size_t k = 0; k < lit.size(); ++k) {
                const RunningMean by_eye = flux_by_eye(scene, lamp, lit[k]);
                const Disagreement found(by_photons[k], by_eye);
                EXPECT_LT(found.standard_errors, z)
                    << c.name << (mapped ? ", mapped" : ", smooth") << ", target at " << lit[k].centre.x;
                EXPECT_LT(found.relative_error, 0.04) << c.name;
                if (!mapped && c.material.metallic == 1 && k == 1) {
                    const RunningMean by_weight = flux_by_photons(scene, lamp, lit, scatter_naively)[k];
                    naive = Disagreement(by_weight, by_eye).standard_errors;
                }
            }
        }
    EXPECT_GT(naive, 10);  // the BSDF's own weight would be noticed
}

}  // namespace
}  // namespace photond::photon_scattering_test
