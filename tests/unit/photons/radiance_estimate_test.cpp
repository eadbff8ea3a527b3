// The estimate against its definition, summed in double over all photons; and what the disc refuses.

#include "renderer/photons/radiance_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "renderer/core/rng.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/rays.h"
#include "tests/support/statistics.h"

namespace photond::radiance_estimate_test {
namespace {

const vec3 kUp(0, 0, 1);
constexpr uint32_t kAny = UINT32_MAX;
constexpr PhotonSearch kRadius{.kind = PhotonSearch::Kind::Radius, .nearest = 50, .radius_m = 0.2f};
constexpr PhotonSearch kNearest{.kind = PhotonSearch::Kind::Nearest, .nearest = 40, .radius_m = 1.0f};

ShadingPoint point_at(const vec3& position, const vec3& geometric_normal, const vec3& shading_normal) {
    ShadingPoint point;
    point.position = position;
    point.geometric_normal = geometric_normal;
    point.shading = Frame(shading_normal);
    return point;
}
ShadingPoint flat_point(const vec3& position = vec3(0)) { return point_at(position, kUp, kUp); }

Photon photon_at(const vec3& position, const Rgb& power_w = Rgb(1), const vec3& wi = kUp, const vec3& normal = kUp,
                 uint32_t scatterings = 1, bool all_delta = false) {
    return {position, PhotonPayload::make(power_w, wi, normal, scatterings, all_delta)};
}

/// Photons about the plane z = 0, some off it, with other normals and from either side.
std::vector<Photon> mixed_photons(size_t count, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<Photon> photons;
    for (size_t i = 0; i < count; ++i) {
        const float x = random.next() - 0.5f, y = random.next() - 0.5f;
        const float z = random.next() < 0.5f ? 0.0f : 0.3f * (random.next() - 0.5f);
        vec3 normal = kUp;
        if (random.next() < 0.5f)
            normal = glm::normalize(vec3(random.next(), random.next(), random.next()) * 2.0f - 1.0f);
        const vec3 wi = Frame(normal).to_world(sample_cosine_hemisphere(random.next_2d()));
        photons.push_back(photon_at({x, y, z}, Rgb(random.next(), random.next(), random.next()), wi, normal,
                                    random.next_bits() % 6, random.next() < 0.3f));
    }
    return photons;
}

/// All that an estimate says, from the definition: which photons the search finds, which of them pass, what they add.
struct Expected {
    dvec3 radiance{0}, delta_radiance{0}, irradiance{0};
    uint32_t photons = 0;
};
Expected by_definition(const PhotonMap& map, const EstimateSettings& settings, const ShadingPoint& point,
                       const Bsdf& bsdf, const vec3& wo, uint32_t most_scatterings) {
    std::vector<std::pair<double, uint32_t>> by_distance;
    for (uint32_t i = 0; i < map.size(); ++i)
        by_distance.emplace_back(glm::distance(dvec3(point.position), dvec3(map.position(i))), i);
    std::sort(by_distance.begin(), by_distance.end());
    double radius = double{map.search().radius_m};
    size_t count = 0;
    while (count < by_distance.size() && by_distance[count].first < radius) ++count;
    if (map.search().kind == PhotonSearch::Kind::Nearest && count >= map.search().nearest) {
        count = map.search().nearest - 1;
        radius = by_distance[count].first;
    }
    const double thickness = settings.disc_thickness_m ? double{*settings.disc_thickness_m} : radius / 4;
    const dvec3 normal(point.geometric_normal);
    Expected expected;
    for (size_t i = 0; i < count; ++i) {
        const auto [distance, index] = by_distance[i];
        const PhotonPayload& photon = map.payload(index);
        const double height = std::fabs(glm::dot(normal, dvec3(map.position(index)) - dvec3(point.position)));
        const double side = glm::dot(dvec3(photon.normal()), normal);
        if (height > thickness || photon.scatterings() > most_scatterings) continue;
        if (side < 0 && !bsdf.has_non_delta_transmission()) continue;
        if (!settings.soft_disc && std::fabs(side) < 0.5) continue;
        const double q_sq = distance * distance / (radius * radius);
        double kernel = double{settings.kernel(static_cast<float>(q_sq))} / (radius * radius);
        if (settings.soft_disc) kernel *= std::fabs(side) * (1 - height / thickness);
        ++expected.photons;
        if (side > 0) expected.irradiance += kernel * dvec3(photon.power_w);
        const double cos_g = glm::dot(dvec3(photon.wi_world()), normal);
        dvec3 f(0);
        if (bsdf.is_lambert() && point.shading.normal == point.geometric_normal) {
            f = dvec3(bsdf.albedo()) / std::numbers::pi;
        } else if ((cos_g > 0) == (side > 0)) {
            const double cos_p = glm::dot(dvec3(photon.wi_world()), dvec3(photon.normal()));
            f = dvec3(bsdf.f_cos(wo, point.shading.to_local(photon.wi_world()))) / std::max(1e-3, std::fabs(cos_p));
        }
        expected.radiance += kernel * f * dvec3(photon.power_w);
        if (photon.all_delta()) expected.delta_radiance += kernel * f * dvec3(photon.power_w);
    }
    return expected;
}

void expect_near(const Rgb& estimate, const dvec3& expected) {
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(double{estimate[channel]}, expected[channel], 2e-4 * std::fabs(expected[channel]) + 1e-12);
}

Bsdf rough_plastic() {
    return Bsdf::layered({.base_color = Rgb(0.3f, 0.6f, 0.9f), .metallic = 0.3f, .roughness = 0.5f});
}
Bsdf rough_sheet(const vec3& geometric_normal_local = kUp) {
    return Bsdf::layered({.geometric_normal = geometric_normal_local, .roughness = 0.6f, .transmission = 0.7f});
}

TEST(RadianceEstimate, IsItsDefinition) {
    const vec3 tilted = glm::normalize(vec3(0.3f, -0.2f, 1));
    const vec3 up_of_tilted = Frame(tilted).to_local(kUp);
    Bsdf::Parameters metal{.geometric_normal = up_of_tilted, .metallic = 1, .roughness = 0.7f};
    struct Surface {
        vec3 shading_normal;
        Bsdf bsdf;
    };
    const Surface surfaces[] = {{kUp, Bsdf::lambert(kUp, Rgb(0.2f, 0.5f, 0.8f))},
                                {tilted, Bsdf::lambert(up_of_tilted, Rgb(0.2f, 0.5f, 0.8f))},
                                {kUp, rough_plastic()},
                                {kUp, rough_sheet()},
                                {tilted, Bsdf::layered(metal)},
                                {tilted, rough_sheet(up_of_tilted)}};
    EstimateSettings plain, soft, thick;
    soft.soft_disc = true;
    thick.disc_thickness_m = 0.15f;
    const vec3 wo = glm::normalize(vec3(0.3f, 0.4f, 0.8f));
    Neighbours scratch;
    for (const PhotonSearch& search : {kRadius, kNearest}) {
        const PhotonMap map(mixed_photons(800, 1), search);
        for (const KernelShape shape :
             {KernelShape::Constant, KernelShape::Cone, KernelShape::Gaussian, KernelShape::Epanechnikov}) {
            for (EstimateSettings settings : {plain, soft, thick}) {
                settings.kernel = Kernel(shape);
                for (const Surface& surface : surfaces) {
                    for (const uint32_t most : {kAny, 2u}) {
                        const ShadingPoint point = point_at(vec3(0.03f, 0.05f, 0), kUp, surface.shading_normal);
                        const Expected expected = by_definition(map, settings, point, surface.bsdf, wo, most);
                        const RadianceEstimate estimate =
                            estimate_radiance(map, settings, point, surface.bsdf, wo, most, scratch);
                        EXPECT_EQ(estimate.photons, expected.photons);
                        EXPECT_GT(estimate.photons, 3u);
                        expect_near(estimate.radiance, expected.radiance);
                        expect_near(estimate.delta_radiance, expected.delta_radiance);
                        if (surface.bsdf.has_non_delta_transmission()) continue;
                        expect_near(estimate_irradiance(map, settings, point.position, kUp, most, scratch),
                                    expected.irradiance);
                    }
                }
            }
        }
    }
}

/// Irradiance at the origin by a single photon there or thereabouts.
float one_photon(const Photon& photon, const EstimateSettings& settings = {}, const vec3& normal = kUp) {
    Neighbours scratch;
    return estimate_irradiance(PhotonMap({photon}, kRadius), settings, vec3(0), normal, kAny, scratch).x;
}

TEST(RadianceEstimate, TheDiscEndsAtItsThicknessAndAtSixtyDegrees) {
    const float full = 1 / (kPi * sqr(kRadius.radius_m)), quarter = kRadius.radius_m / 4;
    EXPECT_FLOAT_EQ(one_photon(photon_at(vec3(0))), full);
    EXPECT_FLOAT_EQ(one_photon(photon_at({0.19f, 0, 0})), full);
    EXPECT_EQ(one_photon(photon_at({0.2f, 0, 0})), 0.0f) << "strictly nearer";
    for (const float side : {-1.0f, 1.0f}) {
        EXPECT_FLOAT_EQ(one_photon(photon_at({0, 0, side * quarter})), full);
        EXPECT_EQ(one_photon(photon_at({0, 0, side * 1.001f * quarter})), 0.0f);
        const EstimateSettings thin{.disc_thickness_m = 0.01f}, in_plane{.disc_thickness_m = 0.0f};
        EXPECT_FLOAT_EQ(one_photon(photon_at({0, 0, side * 0.0099f}), thin), full);
        EXPECT_EQ(one_photon(photon_at({0, 0, side * 0.0101f}), thin), 0.0f);
        EXPECT_FLOAT_EQ(one_photon(photon_at({0.1f, 0, 0}), in_plane), full);
        EXPECT_EQ(one_photon(photon_at({0, 0, side * 1e-6f}), in_plane), 0.0f);
    }
    const auto turned = [](float degrees) {
        return vec3(std::sin(degrees * kPi / 180), 0, std::cos(degrees * kPi / 180));
    };
    EXPECT_FLOAT_EQ(one_photon(photon_at(vec3(0), Rgb(1), kUp, turned(59.8f))), full);
    EXPECT_EQ(one_photon(photon_at(vec3(0), Rgb(1), kUp, turned(60.2f))), 0.0f);
    EXPECT_EQ(one_photon(photon_at(vec3(0), Rgb(1), -kUp, -kUp)), 0.0f) << "arrived behind";
    EXPECT_FLOAT_EQ(one_photon(photon_at(vec3(0), Rgb(1), -kUp, -kUp), {}, -kUp), full);
}

TEST(RadianceEstimate, TheFarSideCountsOnlyThroughRoughTransmission) {
    const PhotonMap behind({photon_at(vec3(0), Rgb(1), -kUp, -kUp)}, kRadius);
    Neighbours scratch;
    EXPECT_EQ(estimate_radiance(behind, {}, flat_point(), rough_plastic(), kUp, kAny, scratch).photons, 0u);
    const RadianceEstimate through = estimate_radiance(behind, {}, flat_point(), rough_sheet(), kUp, kAny, scratch);
    EXPECT_EQ(through.photons, 1u);
    EXPECT_GT(through.radiance.x, 0.0f);
    const PhotonMap slanting({photon_at(vec3(0), Rgb(1), -kUp, glm::normalize(vec3(2, 0, -1)))}, kRadius);
    EXPECT_EQ(estimate_radiance(slanting, {}, flat_point(), rough_sheet(), kUp, kAny, scratch).photons, 0u);
}

TEST(RadianceEstimate, TheKthNearestSetsTheRadiusAndDoesNotCount) {
    std::vector<Photon> photons;
    for (int i = 1; i <= 10; ++i) photons.push_back(photon_at({0.01f * static_cast<float>(i), 0, 0}));
    const auto irradiance = [&](uint32_t k) {
        Neighbours scratch;
        const PhotonMap map(photons, {.kind = PhotonSearch::Kind::Nearest, .nearest = k, .radius_m = 0.5f});
        return estimate_irradiance(map, {}, vec3(0), kUp, kAny, scratch).x;
    };
    EXPECT_FLOAT_EQ(irradiance(4), 3 / (kPi * sqr(0.04f)));
    EXPECT_FLOAT_EQ(irradiance(10), 9 / (kPi * sqr(0.1f)));
    EXPECT_FLOAT_EQ(irradiance(11), 10 / (kPi * sqr(0.5f))) << "fewer than k: all, over the search radius";
}

TEST(RadianceEstimate, ATiltedShadingNormalSeesPhotonsByBothCosines) {
    const vec3 shading = glm::normalize(vec3(1, 0, 1)), wi = glm::normalize(vec3(0.5f, 0.2f, 1));
    const Bsdf lambert = Bsdf::lambert(Frame(shading).to_local(kUp), Rgb(0.6f));
    const ShadingPoint point = point_at(vec3(0), kUp, shading);
    const vec3 wo = point.shading.to_local(kUp);
    Neighbours scratch;
    const auto radiance = [&](const vec3& from) {
        return estimate_radiance(PhotonMap({photon_at(vec3(0), Rgb(1), from)}, kRadius), {}, point, lambert, wo, kAny,
                                 scratch)
            .radiance.x;
    };
    const float density = 1 / (kPi * sqr(kRadius.radius_m));
    EXPECT_NEAR(radiance(wi), 0.6f / kPi * density * glm::dot(wi, shading) / wi.z, 1e-3f);
    EXPECT_EQ(radiance(glm::normalize(vec3(-2, 0, 1))), 0.0f) << "below the shading normal's horizon";
    // Grazing the surface, straight above the shading normal's horizon: finite, by the least cosine.
    const float grazing = radiance(glm::normalize(vec3(1, 0, 1e-6f)));
    EXPECT_LE(grazing, 0.6f / kPi * density * std::sqrt(0.5f) * 1.001e3f);
}

TEST(RadianceEstimate, IsDividedByTheShareOfTheDiscOnTheSurface) {
    // A square from x = 0 on: at 5 cm from its edge a disc of 20 cm hangs over.
    Scene scene;
    scene.meshes.push_back(MeshBuilder().quad({0, -2, 0}, {4, -2, 0}, {4, 2, 0}, {0, 2, 0}).build(0));
    scene.instances.emplace_back();
    scene.materials.emplace_back();
    finish_scene(scene);
    const auto intersector = test::intersector_of(scene);
    const DiscCoverage coverage(scene, *intersector, kRadius.radius_m);
    const PhotonMap map({photon_at({0.1f, 0, 0})}, kRadius);
    const ShadingPoint point = flat_point({0.05f, 0, 0});
    const Bsdf lambert = Bsdf::lambert(kUp, Rgb(0.5f));
    Neighbours scratch;
    for (const KernelShape shape : {KernelShape::Constant, KernelShape::Epanechnikov}) {
        const EstimateSettings none{.kernel = Kernel(shape)}, clip{.kernel = Kernel(shape), .coverage = &coverage};
        const CoverageDisc disc{point.position, kUp, kRadius.radius_m, kRadius.radius_m / 4};
        const float inverse = DiscProbe(coverage, clip.kernel, disc, 0, DiscCare::Fine).mass().inverse;
        EXPECT_GT(inverse, 1.1f);
        EXPECT_LT(inverse, 2.5f);
        EXPECT_FLOAT_EQ(estimate_irradiance(map, clip, point.position, kUp, kAny, scratch).x,
                        estimate_irradiance(map, none, point.position, kUp, kAny, scratch).x * inverse);
        EXPECT_FLOAT_EQ(estimate_radiance(map, clip, point, lambert, kUp, kAny, scratch).radiance.x,
                        estimate_radiance(map, none, point, lambert, kUp, kAny, scratch).radiance.x * inverse);
    }
}

TEST(RadianceEstimate, ClippedDiscsTakeNoPhotonFromBehindAPartition) {
    Scene scene;
    MeshBuilder builder;
    builder.quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0});
    builder.quad({0, -2, 0}, {0, 2, 0}, {0, 2, 1}, {0, -2, 1});
    scene.meshes.push_back(builder.build(0));
    scene.instances.emplace_back();
    scene.materials.emplace_back();
    finish_scene(scene);
    const auto intersector = test::intersector_of(scene);
    const DiscCoverage coverage(scene, *intersector, kRadius.radius_m);
    const EstimateSettings clip{.coverage = &coverage};
    Neighbours scratch;
    const auto irradiance = [&](float x) {
        return estimate_irradiance(PhotonMap({photon_at({x, 0.01f, 0})}, kRadius), clip, {-0.05f, 0, 0}, kUp, kAny,
                                   scratch)
            .x;
    };
    EXPECT_EQ(irradiance(0.05f), 0.0f);
    EXPECT_GT(irradiance(-0.06f), 0.0f);
}

TEST(RadianceEstimate, ClippedDiscsTakeNoPhotonFromAStripThatNoPlaceFinds) {
    // Behind the partition lies a strip of floor half a millimetre wide: one of a thousand places falls on it.
    Scene scene;
    MeshBuilder builder;
    builder.quad({-2, -2, 0}, {0.0005f, -2, 0}, {0.0005f, 2, 0}, {-2, 2, 0});
    builder.quad({0, -2, 0}, {0, 2, 0}, {0, 2, 1}, {0, -2, 1});
    scene.meshes.push_back(builder.build(0));
    scene.instances.emplace_back();
    scene.materials.emplace_back();
    finish_scene(scene);
    const auto intersector = test::intersector_of(scene);
    const DiscCoverage coverage(scene, *intersector, kRadius.radius_m);
    const EstimateSettings clip{.coverage = &coverage}, whole;
    Neighbours scratch;
    // Seen photons are left where the first four that are asked find the hidden ones.
    std::vector<Photon> hidden(20, photon_at({0.00025f, 0.01f, 0})), both = hidden;
    both.push_back(photon_at({-0.06f, 0.01f, 0}));
    const PhotonMap strip(hidden, kRadius), all(both, kRadius);
    const vec3 centre(-0.05f, 0, 0);
    EXPECT_GT(estimate_irradiance(strip, whole, centre, kUp, kAny, scratch).x, 0.0f);
    int places_that_found_it = 0;
    for (uint32_t i = 0; i < 100; ++i) {
        const DiscQuery query{.turn = i * 0x9e3779b9u, .care = i % 2 == 0 ? DiscCare::Fine : DiscCare::Coarse};
        const CoverageDisc disc{centre, kUp, kRadius.radius_m, kRadius.radius_m / 4};
        places_that_found_it += DiscProbe(coverage, clip.kernel, disc, query.turn, query.care).mass().hides;
        EXPECT_EQ(estimate_irradiance(strip, clip, centre, kUp, kAny, scratch, query).x, 0.0f);
        const RadianceEstimate seen =
            estimate_radiance(all, clip, flat_point(centre), Bsdf::lambert(kUp, Rgb(0.5f)), kUp, kAny, scratch, query);
        EXPECT_EQ(seen.photons, 1u);
    }
    EXPECT_LT(places_that_found_it, 50) << "the strip is not narrow";
}

TEST(RadianceEstimate, OfALargerDiscThanIsWantedOnlyTheRadiusIsTold) {
    const PhotonMap map({photon_at({0.05f, 0, 0})}, kRadius);
    const Bsdf lambert = Bsdf::lambert(kUp, Rgb(0.5f));
    Neighbours scratch;
    for (const float most_m : {0.99f * kRadius.radius_m, kRadius.radius_m}) {
        const RadianceEstimate found =
            estimate_radiance(map, {}, flat_point(vec3(0)), lambert, kUp, kAny, scratch, {.most_radius_m = most_m});
        EXPECT_EQ(found.radius_m, kRadius.radius_m);
        EXPECT_EQ(found.photons, most_m < kRadius.radius_m ? 0u : 1u);
        EXPECT_EQ(found.radiance.x > 0, most_m >= kRadius.radius_m);
    }
}

/// Photons on the plane z = 0, within a square of side 2, as many in the mean where light is as bright.
std::vector<Photon> photons_by_light(size_t tried, uint64_t stream, const auto& light_at, float brightest) {
    RandomStream random(5, RandomDomain::Test, 0, stream);
    std::vector<Photon> photons;
    for (size_t i = 0; i < tried; ++i) {
        const vec3 p(2 * random.next() - 1, 2 * random.next() - 1, 0);
        if (brightest * random.next() < light_at(p)) photons.push_back(photon_at(p, Rgb(1, 0.5f, 0.25f)));
    }
    return photons;
}

TEST(RadianceEstimate, MomentsAreTheirDefinition) {
    constexpr float kRadius_m = 0.15f;
    const PhotonMap map(mixed_photons(3000, 7), kRadius);
    const ShadingPoint point = flat_point();
    for (const bool lambert : {true, false}) {
        const Bsdf bsdf = lambert ? Bsdf::lambert(kUp, Rgb(0.7f, 0.5f, 0.2f)) : rough_plastic();
        for (const KernelShape shape : {KernelShape::Constant, KernelShape::Epanechnikov}) {
            const EstimateSettings settings{.kernel = Kernel(shape), .disc_thickness_m = {}, .soft_disc = false};
            Neighbours scratch;
            DiscMoments moments{.channels = Rgb(0.3f, 0.5f, 0.2f)};
            const RadianceEstimate found = estimate_radiance(map, settings, point, bsdf, kUp, kAny, scratch,
                                                             {.radius_m = kRadius_m, .moments = &moments});
            // One photon after the other, by maps of one each.
            DiscMoments expected;
            std::array<double, DiscMoments::kSectors> by_half_quadrant{};
            for (uint32_t i = 0; i < map.size(); ++i) {
                const float distance = glm::length(map.position(i) - point.position);
                if (distance >= kRadius_m) continue;
                const PhotonMap alone({{map.position(i), map.payload(i)}}, kRadius);
                const Rgb light =
                    estimate_radiance(alone,
                                      {.kernel = Kernel(), .disc_thickness_m = 0.25f * kRadius_m, .soft_disc = false},
                                      point, bsdf, kUp, kAny, scratch)
                        .radiance *
                    kPi * sqr(kRadius.radius_m);
                const double w = double{glm::dot(light, moments.channels)};
                if (w == 0) continue;
                expected.photons += 1, expected.w += w, expected.w_sq += w * w;
                expected.w_t += w * (2 * double{sqr(distance / kRadius_m)} - 1);
                // The plane's axes are the frame's, but for signs and order: sectors are told apart by half quadrants.
                const vec3 offset = map.position(i) - point.position;
                const auto quadrant = static_cast<size_t>((offset.x < 0 ? 1 : 0) + (offset.y < 0 ? 2 : 0));
                by_half_quadrant[2 * quadrant + (std::fabs(offset.x) < std::fabs(offset.y) ? 1 : 0)] += w;
            }
            EXPECT_GT(expected.photons, 20);
            EXPECT_EQ(moments.photons, expected.photons);
            EXPECT_EQ(found.scattered, static_cast<uint32_t>(expected.photons));
            EXPECT_NEAR(moments.w, expected.w, 1e-4 * expected.w);
            EXPECT_NEAR(moments.w_sq, expected.w_sq, 1e-4 * expected.w_sq);
            EXPECT_NEAR(moments.w_t, expected.w_t, 1e-4 * expected.w);
            EXPECT_EQ(found.radius_m, kRadius_m);
            std::ranges::sort(by_half_quadrant);
            std::array<double, DiscMoments::kSectors> sectors = moments.sectors;
            std::ranges::sort(sectors);
            for (size_t i = 0; i < sectors.size(); ++i)
                EXPECT_NEAR(sectors[i], by_half_quadrant[i], 1e-4 * expected.w) << "sector " << i;
        }
    }
}

// Light that varies linearly leaves the statistic standard normal; of light that varies quadratically the moments tell
// the kernel's bias: 2,000 discs of some 200 photons each; false-alarm rate 1e-6 for each of four checks.
TEST(RadianceEstimate, MomentsTellCurvedLightAndNoOther) {
    constexpr PhotonSearch kSearch{.kind = PhotonSearch::Kind::Radius, .nearest = 50, .radius_m = 0.5f};
    constexpr int kDiscs = 2000;
    const double z = test::two_sided_z(1e-6);
    const auto statistics = [&](const auto& light_at, test::RunningMean& curvature, test::RunningMean& bias) {
        for (uint64_t disc = 0; disc < kDiscs; ++disc) {
            const PhotonMap map(photons_by_light(1000, disc, light_at, 2), kSearch);
            Neighbours scratch;
            DiscMoments moments;
            estimate_radiance(map, {}, flat_point(), Bsdf::lambert(kUp, Rgb(1)), kUp, kAny, scratch,
                              {.moments = &moments});
            curvature.add(std::sqrt(3 / moments.w_sq) * moments.w_t);
            bias.add(3 * moments.w_t / moments.w);
        }
    };
    test::RunningMean even, even_bias, curved, curved_bias;
    statistics([](const vec3& p) { return 1 + 0.9f * p.x; }, even, even_bias);
    EXPECT_NEAR(even.mean(), 0, z / std::sqrt(double(kDiscs)));
    EXPECT_NEAR(even.variance(), 1, z * std::sqrt(2.0 / kDiscs));
    // 1 + a d^2: the constant kernel is a r^2 / 2 too bright at the centre, of 1 + a r^2 / 2 in all.
    constexpr double kBias = 0.5 * 0.8 * kSearch.radius_m * kSearch.radius_m;
    statistics([](const vec3& p) { return 1 + 0.8f * glm::dot(p, p); }, curved, curved_bias);
    EXPECT_GT(curved.mean(), z / std::sqrt(double(kDiscs)));
    EXPECT_NEAR(curved_bias.mean(), kBias / (1 + kBias), z * curved_bias.standard_error() + 2e-3) << "ratios of sums";
}

TEST(RadianceEstimate, NothingIsLookedUpForNothing) {
    Neighbours scratch;
    const PhotonMap map(mixed_photons(100, 2), kRadius);
    EXPECT_EQ(estimate_radiance(map, {}, flat_point(), Bsdf(), kUp, kAny, scratch).photons, 0u);
    EXPECT_EQ(estimate_radiance(PhotonMap(), {}, flat_point(), rough_plastic(), kUp, kAny, scratch).radiance, Rgb(0));
    EXPECT_EQ(estimate_irradiance(PhotonMap(), {}, vec3(0), kUp, kAny, scratch), Rgb(0));
    EXPECT_EQ(estimate_irradiance(map, {}, vec3(100), kUp, kAny, scratch), Rgb(0));
    EXPECT_EQ(estimate_radiance(map, {}, flat_point(), Bsdf::lambert(kUp, Rgb(1)), -kUp, kAny, scratch).radiance,
              Rgb(0))
        << "seen from behind";
}

TEST(RadianceEstimate, CoincidentPhotonsAndExtremeRadiiStayFinite) {
    Neighbours scratch;
    const PhotonMap coincident(std::vector<Photon>(60, photon_at(vec3(0))), kNearest);
    EXPECT_EQ(estimate_irradiance(coincident, {}, vec3(0), kUp, kAny, scratch), Rgb(0)) << "a disc of radius 0";
    EXPECT_EQ(estimate_radiance(coincident, {}, flat_point(), rough_plastic(), kUp, kAny, scratch).radiance, Rgb(0));
    EXPECT_GT(estimate_irradiance(coincident, {}, vec3(0.1f, 0, 0), kUp, kAny, scratch).x, 0.0f);
    for (const float radius_m : {1e-25f, 1e-15f, 1e15f, 1e25f, kInfinity}) {
        const PhotonSearch search{.kind = PhotonSearch::Kind::Nearest, .nearest = 100, .radius_m = radius_m};
        for (const KernelShape shape :
             {KernelShape::Constant, KernelShape::Cone, KernelShape::Gaussian, KernelShape::Epanechnikov}) {
            const Rgb e = estimate_irradiance(PhotonMap(std::vector<Photon>(60, photon_at(vec3(0))), search),
                                              {.kernel = Kernel(shape)}, vec3(0), kUp, kAny, scratch);
            EXPECT_TRUE(is_finite(e) && e.x >= 0) << radius_m;
        }
    }
}

}  // namespace
}  // namespace photond::radiance_estimate_test
