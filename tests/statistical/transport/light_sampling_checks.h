#pragma once
// The sampler of lights draws with the densities it states, and what it estimates is right: chi-square over the
// surfaces of the lights and over the sphere, and irradiance against closed forms. For whoever samples: the type is
// HostLights (light_samples.h) or one with its face.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "renderer/scene/mesh_builder.h"
#include "tests/support/light_samples.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::test {

template <class Lights>
class LightSamplingDensity : public testing::Test {};
TYPED_TEST_SUITE_P(LightSamplingDensity);
template <class Lights>
class LightSamplingEstimate : public testing::Test {};
TYPED_TEST_SUITE_P(LightSamplingEstimate);

inline constexpr double kLightSamplingFalseAlarm = 1e-6;  // of each test as a whole

/// Light downwards from a rectangle of the given size whose centre is at `centre`.
inline Mesh ceiling_panel(const vec3& centre, float width, float depth) {
    const float w = 0.5f * width, d = 0.5f * depth;
    return MeshBuilder()
        .quad(centre + vec3(-w, 0, -d), centre + vec3(w, 0, -d), centre + vec3(w, 0, d), centre + vec3(-w, 0, d))
        .build(0);
}

/// Irradiance [W m^-2] of a polygon of radiance 1 wholly above the plane at p: Lambert's formula.
/// [Lambert 1760], in the form of [Baum, Rushmeier, Winget 1989] Improving Radiosity Solutions, Eq. 7.
inline double polygon_irradiance(const std::vector<dvec3>& corners, const dvec3& p, const dvec3& n) {
    double sum = 0;
    for (size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = glm::normalize(corners[i] - p), b = glm::normalize(corners[(i + 1) % corners.size()] - p);
        const dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(across / sine, n);
    }
    return std::fabs(0.5 * sum);
}

/// The same for a one-sided triangle light; 0 seen from behind.
inline double triangle_irradiance(const Scene& scene, const TriangleLight& light, const dvec3& p, const dvec3& n) {
    const TriangleCorners t = world_triangle(scene, light.instance, light.triangle);
    const dvec3 a(t.p[0]), b(t.p[1]), c(t.p[2]);
    if (glm::dot(glm::cross(b - a, c - a), p - a) <= 0) return 0;
    return polygon_irradiance({a, b, c}, p, n);
}

// --- densities ---------------------------------------------------------------------------------------------------

/// Cells of a triangle: kCells^2 equal pieces in rows of barycentrics.
inline constexpr uint32_t kCells = 6;

inline uint32_t cell_of(float u, float v) {
    const uint32_t row = std::min(static_cast<uint32_t>(v * kCells), kCells - 1);
    const uint32_t column = std::min(static_cast<uint32_t>(u * kCells), kCells - 1 - row);
    const bool upper = column + row < kCells - 1 &&
                       (u * kCells - static_cast<float>(column)) + (v * kCells - static_cast<float>(row)) > 1;
    return (row * kCells + column) * 2 + (upper ? 1 : 0);  // half of the numbers stay unused
}
inline constexpr uint32_t kCellNumbers = 2 * kCells * kCells;

/// Probability that the sampler's direction meets each cell of each triangle light, by midpoint quadrature of
/// pdf_triangle() over kFine^2 pieces of each cell.
template <class Lights>
std::vector<double> expected_shares(const Scene& scene, const Lights& sampler, const vec3& p, const vec3& n) {
    constexpr uint32_t kFine = 6, kRows = kCells * kFine;
    std::vector<LightPdfQuery> queries;
    std::vector<std::pair<size_t, double>> pieces;  // of each query: the cell, and the solid angle
    for (size_t l = 0; l < scene.triangle_lights.size(); ++l) {
        const TriangleLight& light = scene.triangle_lights[l];
        const TriangleCorners t = world_triangle(scene, light.instance, light.triangle);
        const dvec3 normal = glm::normalize(glm::cross(dvec3(t.p[1]) - dvec3(t.p[0]), dvec3(t.p[2]) - dvec3(t.p[0]))) *
                             (scene.instances[light.instance].flips_orientation ? -1.0 : 1.0);
        for (uint32_t row = 0; row < kRows; ++row)
            for (uint32_t column = 0; column + row < kRows; ++column)
                for (int upper = 0; upper < (column + row + 1 < kRows ? 2 : 1); ++upper) {
                    const double shift = upper ? 2.0 / 3 : 1.0 / 3;
                    const double u = (column + shift) / kRows, v = (row + shift) / kRows;
                    const dvec3 point = (1 - u - v) * dvec3(t.p[0]) + u * dvec3(t.p[1]) + v * dvec3(t.p[2]);
                    const dvec3 to_light = point - dvec3(p);
                    const double distance = glm::length(to_light);
                    const dvec3 wi = to_light / distance;
                    const double cosine = -glm::dot(normal, wi);
                    if (light.two_sided ? cosine == 0 : cosine <= 0) continue;
                    queries.push_back({p, n, vec3(wi), static_cast<float>(distance), light.instance, light.triangle});
                    pieces.push_back(
                        {l * kCellNumbers + cell_of(static_cast<float>(u), static_cast<float>(v)),
                         std::fabs(cosine) / (distance * distance) * light.area_m2 / (double{kRows} * kRows)});
                }
    }
    std::vector<double> shares(scene.triangle_lights.size() * kCellNumbers, 0.0);
    const std::vector<LightPdfs> pdfs = sampler.pdfs(queries);
    for (size_t i = 0; i < pieces.size(); ++i) shares[pieces[i].first] += double{pdfs[i].triangle} * pieces[i].second;
    return shares;
}

/// The triangle light that a sample ended on and where, by brute force over all of them.
struct FoundLight {
    size_t light = 0;
    float u = 0, v = 0;
};
inline std::optional<FoundLight> find_light(const Scene& scene, const vec3& p, const LightSample& sample) {
    std::optional<FoundLight> best;
    double least_miss = 1e-4;  // relative to the distance
    for (size_t l = 0; l < scene.triangle_lights.size(); ++l) {
        const TriangleLight& light = scene.triangle_lights[l];
        const TriangleCorners t = world_triangle(scene, light.instance, light.triangle);
        const dvec3 e1 = dvec3(t.p[1]) - dvec3(t.p[0]), e2 = dvec3(t.p[2]) - dvec3(t.p[0]);
        const dvec3 s = dvec3(p) - dvec3(t.p[0]), w(sample.wi), across = glm::cross(w, e2);
        const double away = glm::dot(glm::cross(e1, e2), w);  // > 0: seen from behind
        if (!light.two_sided && (scene.instances[light.instance].flips_orientation ? -away : away) >= 0) continue;
        const double inverse = 1 / glm::dot(across, e1);
        const double u = glm::dot(s, across) * inverse, v = glm::dot(w, glm::cross(s, e1)) * inverse;
        const double distance = glm::dot(e2, glm::cross(s, e1)) * inverse;
        constexpr double kEdge = 1e-5;
        if (u < -kEdge || v < -kEdge || u + v > 1 + kEdge) continue;
        const double miss = std::fabs(distance - sample.distance) / sample.distance;
        if (miss < least_miss) {
            least_miss = miss;
            const double scale = std::max(1.0, u + v);
            best = FoundLight{l, static_cast<float>(std::clamp(u, 0.0, 1.0) / scale),
                              static_cast<float>(std::clamp(v, 0.0, 1.0) / scale)};
        }
    }
    return best;
}

/// Draws from the triangle lights of a scene and holds the counts against the stated densities; `covered` is the share
/// of numbers that must give a sample, where it is known.
template <class Lights>
void check_triangle_densities(const Scene& scene, const vec3& p, const vec3& n, size_t samples, size_t checks,
                              std::optional<double> covered, const char* what) {
    const Lights sampler(scene);
    std::vector<double> expected = expected_shares(scene, sampler, p, n), counts(expected.size() + 1, 0.0);
    double total = 0;
    for (double& share : expected) total += share, share *= static_cast<double>(samples);
    expected.push_back(std::max(0.0, 1 - total) * static_cast<double>(samples));  // nothing drawn
    EXPECT_LT(total, 1.002) << what << ": the densities integrate to more than 1";
    if (covered) {
        EXPECT_NEAR(total, *covered, 0.002) << what << ": integral of the densities";
    }
    if (total > 0.9999) expected.back() = 0;  // quadrature's error, no share of its own

    RandomStream random(7, RandomDomain::Test, 0, 0);
    size_t pdf_faults = 0, unfound = 0, misses = 0;
    std::vector<LightPdfQuery> queries;
    std::vector<float> stated;  // beside the queries
    for (const std::optional<LightSample>& sample : sampler.sample(light_queries(p, n, samples, random))) {
        if (!sample) {
            ++counts.back(), ++misses;
            continue;
        }
        const std::optional<FoundLight> found = find_light(scene, p, *sample);
        if (!found) {
            ++unfound;
            continue;
        }
        const TriangleLight& light = scene.triangle_lights[found->light];
        queries.push_back({p, n, sample->wi, sample->distance, light.instance, light.triangle});
        stated.push_back(sample->pdf_sa);
        ++counts[found->light * kCellNumbers + cell_of(found->u, found->v)];
    }
    // Both are computed in float, from the point and from the direction: they part at grazing angles by rounding.
    const std::vector<LightPdfs> pdfs = sampler.pdfs(queries);
    for (size_t i = 0; i < pdfs.size(); ++i)
        if (!(std::fabs(pdfs[i].triangle - stated[i]) <= 2e-3f * stated[i])) ++pdf_faults;
    // A triangle seen all but edge-on is missed by the brute force now and then.
    EXPECT_LE(unfound, samples / 100'000) << what << ": samples on no light";
    EXPECT_LE(pdf_faults, samples / 2000) << what << ": sample() and pdf_triangle() disagree";
    if (expected.back() == 0 && misses < samples / 10000) counts.back() = 0;  // numbers at the very rim
    const double probability = chi_square_probability(counts, expected);
    EXPECT_GT(probability, share_of_false_alarm(kLightSamplingFalseAlarm, checks)) << what << ": chi-square";
}

TYPED_TEST_P(LightSamplingDensity, OneTriangleNearAndFar) {
    // Near: drawn by solid angle; far: by area. Both must match their density, the switch included.
    constexpr size_t kChecks = 4;
    for (const auto& [height, what] :
         {std::pair{0.3f, "0.3 m away"}, {0.9f, "0.9 m away"}, {1.3f, "1.3 m away"}, {6.0f, "6 m away"}}) {
        Scene scene;
        add(scene,
            MeshBuilder().triangle({-0.7f, height, -0.4f}, {0.6f, height, -0.5f}, {0.1f, height + 0.2f, 0.8f}).build(0),
            emitting(Rgb(3, 2, 1)));
        finish_scene(scene);
        check_triangle_densities<TypeParam>(scene, vec3(0.1f, 0, 0), vec3(0, 1, 0), 400'000, kChecks, 1.0, what);
    }
}

TYPED_TEST_P(LightSamplingDensity, Parallelogram) {
    constexpr size_t kChecks = 3;
    for (const float height : {0.4f, 1.0f, 5.0f}) {
        Scene scene;
        add(scene, ceiling_panel({0.2f, height, 0}, 1.3f, 1.05f), emitting(Rgb(17, 12, 4)));
        finish_scene(scene);
        check_triangle_densities<TypeParam>(scene, vec3(0), vec3(0, 1, 0), 400'000, kChecks, 1.0, "parallelogram");
    }
}

TYPED_TEST_P(LightSamplingDensity, TwoSidedMirroredAndTexturedEmitters) {
    constexpr size_t kChecks = 3;
    Scene scene;
    add(scene, ceiling_panel({0, 1, 0}, 1, 1), emitting(Rgb(1), true));
    finish_scene(scene);
    check_triangle_densities<TypeParam>(scene, vec3(0.1f, 2.5f, 0.2f), vec3(0, -1, 0), 300'000, kChecks, 1.0,
                                        "seen from its back");

    // A mirrored instance: corners turn the other way round, the front stays the front.
    Scene mirrored;
    Mesh panel = ceiling_panel({0.5f, 1, 0}, 1, 1);
    add(mirrored, panel, emitting(Rgb(1)));
    mirrored.instances[0].identity = false;
    mirrored.instances[0].to_world = mat4x3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0));
    mirrored.instances[0].normal_to_world = mat3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
    mirrored.instances[0].flips_orientation = true;
    finish_scene(mirrored);
    check_triangle_densities<TypeParam>(mirrored, vec3(0), vec3(0, 1, 0), 300'000, kChecks, 1.0, "mirrored");

    Scene textured;
    Material material = emitting(Rgb(1));
    material.emission_texture.texture = 0;
    Texture texture;
    texture.size = {2, 2};
    texture.texels = {u8vec4(255), u8vec4(40, 80, 120, 255), u8vec4(10, 10, 10, 255), u8vec4(200, 20, 90, 255)};
    textured.textures.push_back(texture);
    add(textured, MeshBuilder().quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}).build(0, true), material);
    finish_scene(textured);
    check_triangle_densities<TypeParam>(textured, vec3(0.3f, 0, 0.1f), vec3(0, 1, 0), 300'000, kChecks, 1.0,
                                        "textured");
}

TYPED_TEST_P(LightSamplingDensity, TreeOfTriangles) {
    // A closed bumpy room of 320 emitting triangles, all facing p; and the same seen from outside, where most face
    // away.
    Scene scene;
    Mesh room = make_icosphere(2, 0);
    for (uvec3& t : room.triangles) std::swap(t.y, t.z);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (vec3& p : room.positions) p *= 0.9f + 0.2f * random.next();
    add(scene, room, emitting(Rgb(1)));
    finish_scene(scene);
    constexpr size_t kChecks = 3;
    check_triangle_densities<TypeParam>(scene, vec3(0.2f, 0.1f, -0.3f), vec3(0), 150'000, kChecks, 1.0, "from within");
    check_triangle_densities<TypeParam>(scene, vec3(2.0f, 0.5f, 0), vec3(-1, 0, 0), 150'000, kChecks, std::nullopt,
                                        "from outside");

    // Lights of all powers and directions, some below the horizon of p: with n given those are left out.
    Scene scattered;
    for (int i = 0; i < 60; ++i) {
        const vec3 at = 6.0f * (vec3(random.next(), random.next(), random.next()) - 0.5f);
        const vec3 a = vec3(random.next(), random.next(), random.next()) - 0.5f;
        const vec3 b = vec3(random.next(), random.next(), random.next()) - 0.5f;
        add(scattered, MeshBuilder().triangle(at, at + 0.6f * a, at + 0.6f * b).build(0),
            emitting(Rgb(std::exp(4 * random.next())), i % 3 == 0));
    }
    finish_scene(scattered);
    check_triangle_densities<TypeParam>(scattered, vec3(0.1f, 0.2f, 0.3f), glm::normalize(vec3(1, 2, 0.5f)), 150'000,
                                        kChecks, std::nullopt, "scattered");
}

TYPED_TEST_P(LightSamplingDensity, PointLightsThroughTheTreeAndSuns) {
    // Delta lights: each must come up as often as the probability stated with it, and the probabilities sum to 1.
    Scene scene;
    RandomStream random(11, RandomDomain::Test, 0, 0);
    constexpr uint32_t kPoints = 40, kSuns = 3;
    for (uint32_t i = 0; i < kPoints + kSuns; ++i) {
        PunctualLight light;
        light.kind = i < kPoints ? PunctualLight::Kind::Point : PunctualLight::Kind::Directional;
        light.intensity = Rgb(0.1f + 3 * random.next());
        light.position = 4.0f * vec3(random.next() - 0.5f, random.next() + 0.1f, random.next() - 0.5f);
        light.direction = glm::normalize(vec3(random.next() - 0.5f, -1, random.next() - 0.5f));
        scene.punctual_lights.push_back(light);
    }
    finish_scene(scene);
    const TypeParam sampler(scene);
    constexpr size_t kSamples = 400'000;
    std::vector<double> counts(kPoints + kSuns, 0.0), expected(kPoints + kSuns, 0.0);
    for (const auto& drawn : sampler.sample(light_queries(vec3(0), vec3(0, 1, 0), kSamples, random))) {
        ASSERT_TRUE(drawn);
        const LightSample& sample = *drawn;
        ASSERT_TRUE(sample.delta);
        uint32_t which = 0;
        for (; which < kPoints + kSuns; ++which) {
            const PunctualLight& light = scene.punctual_lights[which];
            const bool same = sample.distance < kInfinity ? sample.target == light.position && which < kPoints
                                                          : sample.wi == -light.direction && which >= kPoints;
            if (same) break;
        }
        ASSERT_LT(which, kPoints + kSuns);
        ++counts[which];
        expected[which] = sample.pdf_sa;
    }
    double total = 0;
    for (double& probability : expected) total += probability, probability *= kSamples;
    EXPECT_NEAR(total, 1.0, 1e-4);
    EXPECT_GT(chi_square_probability(counts, expected), kLightSamplingFalseAlarm);
}

// --- environment -------------------------------------------------------------------------------------------------

inline Scene environment_scene(Size2 size, float rotation, const std::function<Rgb(uint32_t, uint32_t)>& texel) {
    Scene scene;
    Environment environment;
    environment.map.size = size;
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) environment.map.radiance.push_back(texel(x, y));
    environment.rotation = rotation;
    environment.scale = 2;
    scene.environment = environment;
    finish_scene(scene);
    return scene;
}

/// Samples of an environment by that density: one of a bright texel among dim ones.
template <class Lights>
void check_environment(EnvironmentDensity density) {
    constexpr uint32_t kWidth = 16, kHeight = 8;
    RandomStream random(5, RandomDomain::Test, 0, 0);
    const float rotation = 0.7f;
    const Scene scene = environment_scene({kWidth, kHeight}, rotation, [&](uint32_t x, uint32_t y) {
        return x == 5 && y == 2 ? Rgb(500, 400, 300) : Rgb(random.next() * random.next());
    });
    const Lights sampler(scene, density);
    // Cells: texels, found from the direction by the convention itself (centre column at -z, columns towards +x, turned
    // counter-clockwise); the density is constant in each.
    const auto direction_of = [&](double column, double row) {
        const double polar = M_PI * row / kHeight, azimuth = 2 * M_PI * (column / kWidth - 0.5) - rotation;
        return dvec3(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth));
    };
    constexpr size_t kSamples = 500'000;
    std::vector<double> expected, counts(kWidth * kHeight, 0.0);
    double total = 0;
    std::vector<LightPdfQuery> texels;
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x)
            texels.push_back({vec3(0), vec3(0), vec3(direction_of(x + 0.5, y + 0.5))});
    const std::vector<LightPdfs> densities = sampler.pdfs(texels);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            const double solid_angle =
                2 * M_PI / kWidth * (std::cos(M_PI * y / kHeight) - std::cos(M_PI * (y + 1) / kHeight));
            const double share = solid_angle * densities[y * kWidth + x].environment;
            total += share;
            expected.push_back(share * kSamples);
        }
    EXPECT_NEAR(total, 1.0, 1e-4);
    RunningMean flux;
    for (const auto& drawn : sampler.sample(light_queries(vec3(0), vec3(0), kSamples, random))) {
        ASSERT_TRUE(drawn);
        const LightSample& sample = *drawn;
        ASSERT_NEAR(glm::length(sample.wi), 1, 1e-5);
        ASSERT_EQ(sample.distance, kInfinity);
        double column = 0.5 + (std::atan2(sample.wi.x, -sample.wi.z) + rotation) / (2 * M_PI);
        column -= std::floor(column);
        const double row = std::acos(std::clamp(sample.wi.y, -1.0f, 1.0f)) / M_PI;
        const auto x = std::min(static_cast<uint32_t>(column * kWidth), kWidth - 1);
        const auto y = std::min(static_cast<uint32_t>(row * kHeight), kHeight - 1);
        ++counts[y * kWidth + x];
        flux.add(sample.radiance_over_pdf.x);
    }
    EXPECT_GT(chi_square_probability(counts, expected), kLightSamplingFalseAlarm);

    // The integral of radiance over all directions that are drawn, by midpoint quadrature of the lookup; and the
    // texels' means, which the density has to follow.
    double integral = 0;
    constexpr uint32_t kFine = 24;
    std::vector<LightPdfQuery> directions;
    std::vector<double> solid_angles;
    for (uint32_t y = 0; y < kHeight * kFine; ++y)
        for (uint32_t x = 0; x < kWidth * kFine; ++x) {
            const double row = (y + 0.5) / kFine, column = (x + 0.5) / kFine;
            directions.push_back({vec3(0), vec3(0), vec3(direction_of(column, row))});
            solid_angles.push_back(2 * M_PI / (kWidth * kFine) * M_PI / (kHeight * kFine) *
                                   std::sin(M_PI * row / kHeight));
        }
    const std::vector<LightPdfs> sky = sampler.pdfs(directions);
    std::vector<double> means(densities.size());
    for (size_t i = 0; i < sky.size(); ++i) {
        if (sky[i].environment > 0) integral += solid_angles[i] * double{sky[i].environment_radiance.x};
        const size_t x = i % (kWidth * kFine) / kFine, y = i / (kWidth * kFine) / kFine;
        means[y * kWidth + x] += double{mean(sky[i].environment_radiance)} / (kFine * kFine);
    }
    const double half_width = two_sided_z(kLightSamplingFalseAlarm) * flux.standard_error();
    EXPECT_NEAR(flux.mean(), integral, half_width + 1e-3 * integral);
    EXPECT_LT(2 * half_width, 0.02 * integral) << "too noisy to notice a defect of 2 %";

    std::vector<double> of_row(kHeight);
    double mean_of_map = 0, sum = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
        of_row[y] = 2 * M_PI / kWidth * (std::cos(M_PI * y / kHeight) - std::cos(M_PI * (y + 1) / kHeight));
    for (size_t i = 0; i < means.size(); ++i) mean_of_map += means[i] * of_row[i / kWidth] / (4 * M_PI);
    const bool compensated = density == EnvironmentDensity::Compensated;
    for (double& value : means) value = std::max(0.0, value - (compensated ? mean_of_map : 0));
    for (size_t i = 0; i < means.size(); ++i) sum += means[i] * of_row[i / kWidth];
    size_t dark = 0;
    for (size_t i = 0; i < means.size(); ++i) {
        EXPECT_NEAR(densities[i].environment, means[i] / sum, 2e-3 * means[i] / sum + 1e-6);
        dark += densities[i].environment == 0;
    }
    EXPECT_EQ(dark > means.size() / 2, compensated);
}

TYPED_TEST_P(LightSamplingDensity, Environment) { check_environment<TypeParam>(EnvironmentDensity::Radiance); }
TYPED_TEST_P(LightSamplingDensity, EnvironmentsExcessOverItsMean) {
    check_environment<TypeParam>(EnvironmentDensity::Compensated);
}
TYPED_TEST_P(LightSamplingDensity, AnEvenEnvironmentIsSampledEvenly) {
    const Scene scene = environment_scene({16, 8}, 0, [](uint32_t, uint32_t) { return Rgb(0.1f, 0.7f, 0.3f); });
    RandomStream random(6, RandomDomain::Test, 0, 0);
    std::vector<LightPdfQuery> anywhere;
    for (int i = 0; i < 500; ++i) {
        const float z = 1 - 2 * random.next(), azimuth = 2 * kPi * random.next(), r = std::sqrt(1 - z * z);
        anywhere.push_back({vec3(0), vec3(0), vec3(r * std::cos(azimuth), z, r * std::sin(azimuth))});
    }
    for (const EnvironmentDensity density : {EnvironmentDensity::Radiance, EnvironmentDensity::Compensated})
        for (const LightPdfs& pdfs : TypeParam(scene, density).pdfs(anywhere))
            EXPECT_NEAR(pdfs.environment, 1 / (4 * kPi), 1e-5f);
}
TYPED_TEST_P(LightSamplingDensity, EnvironmentLooksWhereTheConventionSays) {
    // One bright texel right of the centre column: seen towards -z and +x; turned by +90 degrees, seen towards -x, -z.
    const auto bright = [](uint32_t x, uint32_t y) { return x == 9 && y == 4 ? Rgb(100) : Rgb(0); };
    const auto toward = [](double azimuth) {
        return vec3(float(std::sin(azimuth)), -0.195f, float(-std::cos(azimuth)));
    };
    const double centre = 2 * M_PI * (9.5 / 16 - 0.5);
    const auto pdfs_towards = [](const Scene& scene, const vec3& wi) {
        return TypeParam(scene).pdfs({{vec3(0), vec3(0), wi}})[0];
    };
    const Scene straight = environment_scene({16, 8}, 0, bright);
    EXPECT_NEAR(pdfs_towards(straight, glm::normalize(toward(centre))).environment_radiance.x, 200, 2);
    EXPECT_NEAR(pdfs_towards(straight, glm::normalize(toward(-centre))).environment_radiance.x, 0, 1e-3);
    const Scene turned = environment_scene({16, 8}, kPi / 2, bright);
    // Counter-clockwise from above takes -z to -x.
    const vec3 expected = glm::normalize(toward(centre - M_PI / 2));
    EXPECT_LT(expected.x, 0);
    EXPECT_NEAR(pdfs_towards(turned, expected).environment_radiance.x, 200, 2);
    const Scene black = environment_scene({4, 2}, 0, [](uint32_t, uint32_t) { return Rgb(0); });
    EXPECT_EQ(pdfs_towards(black, vec3(0, 1, 0)).environment, 0.0f);
}

// --- estimates ---------------------------------------------------------------------------------------------------

/// Irradiance at p estimated from light samples alone, no shadows.
template <class Lights>
RunningMean estimate_irradiance(const Scene& scene, const vec3& p, const vec3& n, size_t samples, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    RunningMean estimate;
    for (const auto& sample : Lights(scene).sample(light_queries(p, n, samples, random)))
        estimate.add(sample ? double{sample->radiance_over_pdf.x} * std::max(0.0f, glm::dot(n, sample->wi)) : 0.0);
    return estimate;
}

inline void expect_irradiance(const RunningMean& estimate, double exact, size_t checks, double must_detect,
                              const char* what) {
    const double half_width =
        two_sided_z(share_of_false_alarm(kLightSamplingFalseAlarm, checks)) * estimate.standard_error();
    EXPECT_NEAR(estimate.mean(), exact, half_width + 1e-5 * exact) << what;
    EXPECT_LE(2 * half_width, must_detect * exact) << what << ": too noisy to notice a defect";
}

TYPED_TEST_P(LightSamplingEstimate, RectangleAboveAPlane) {
    constexpr size_t kChecks = 5;
    for (const auto& [at, height] : {std::pair{vec3(0), 0.05f},
                                     {vec3(0.3f, 0, 0.1f), 0.5f},
                                     {vec3(2, 0, 1), 1.0f},
                                     {vec3(0.5f, 0, 0.5f), 4.0f},
                                     {vec3(30, 0, 0), 2.0f}}) {
        Scene scene;
        add(scene, ceiling_panel({0, height, 0}, 1.3f, 1.05f), emitting(Rgb(3)));
        finish_scene(scene);
        double exact = 0;
        for (const TriangleLight& light : scene.triangle_lights)
            exact += 3 * triangle_irradiance(scene, light, dvec3(at), dvec3(0, 1, 0));
        expect_irradiance(estimate_irradiance<TypeParam>(scene, at, vec3(0, 1, 0), 400'000, 1), exact, kChecks, 0.02,
                          "rectangle");
    }
}

TYPED_TEST_P(LightSamplingEstimate, RectangleInTinyHugeAndDistantScenes) {
    constexpr size_t kChecks = 3;
    for (const float scale : {1e-4f, 1.0f, 1e6f}) {
        Scene scene;
        add(scene, ceiling_panel(scale * vec3(0.2f, 0.8f, 0), scale * 1.3f, scale * 1.05f), emitting(Rgb(3)));
        finish_scene(scene);
        double exact = 0;
        for (const TriangleLight& light : scene.triangle_lights)
            exact += 3 * triangle_irradiance(scene, light, dvec3(0), dvec3(0, 1, 0));
        expect_irradiance(estimate_irradiance<TypeParam>(scene, vec3(0), vec3(0, 1, 0), 200'000, 1), exact, kChecks,
                          0.01, "scaled");
    }
}

TYPED_TEST_P(LightSamplingEstimate, NeedleTriangles) {
    // The panel cut into slivers of aspect 1e4 gives what the panel gives.
    constexpr int kSlivers = 10000;
    Scene scene;
    MeshBuilder builder;
    for (int i = 0; i < kSlivers; ++i) {
        const float x0 = static_cast<float>(i) / kSlivers - 0.5f, x1 = static_cast<float>(i + 1) / kSlivers - 0.5f;
        builder.quad({x0, 1, -0.5f}, {x1, 1, -0.5f}, {x1, 1, 0.5f}, {x0, 1, 0.5f});
    }
    add(scene, builder.build(0), emitting(Rgb(1)));
    finish_scene(scene);
    const double exact =
        polygon_irradiance({{-0.5, 1, -0.5}, {0.5, 1, -0.5}, {0.5, 1, 0.5}, {-0.5, 1, 0.5}}, dvec3(0), dvec3(0, 1, 0));
    expect_irradiance(estimate_irradiance<TypeParam>(scene, vec3(0), vec3(0, 1, 0), 100'000, 2), exact, 1, 0.02,
                      "slivers");
}

TYPED_TEST_P(LightSamplingEstimate, TenThousandLightsAreTheSumOfTheirParts) {
    Scene scene;
    RandomStream random(9, RandomDomain::Test, 0, 0);
    MeshBuilder dim, bright;
    for (int i = 0; i < 10'000; ++i) {
        const vec3 at = {100 * (random.next() - 0.5f), 1 + 2 * random.next(), 100 * (random.next() - 0.5f)};
        (i % 10 ? dim : bright).triangle(at, at + vec3(0.2f, 0, 0), at + vec3(0, 0.1f * random.next(), 0.2f));
    }
    add(scene, dim.build(0), emitting(Rgb(1)));
    add(scene, bright.build(0), emitting(Rgb(50)));
    finish_scene(scene);
    ASSERT_EQ(scene.triangle_lights.size(), 10'000u);
    constexpr size_t kChecks = 3;
    for (const vec3& p : {vec3(0), vec3(13, 0, -20), vec3(80, 0, 80)}) {
        double exact = 0;
        for (const TriangleLight& light : scene.triangle_lights)
            exact += double{light.radiance.x} * triangle_irradiance(scene, light, dvec3(p), dvec3(0, 1, 0));
        const RunningMean estimate = estimate_irradiance<TypeParam>(scene, p, vec3(0, 1, 0), 800'000, 3);
        expect_irradiance(estimate, exact, kChecks, 0.03, "10,000 lights");
        // A tree that stopped to help would still be right, so its noise is bounded too: choosing by power alone has a
        // relative variance of 50 and more here.
        EXPECT_LT(estimate.variance() / (exact * exact), 8) << "relative variance of one sample";
    }
}

TYPED_TEST_P(LightSamplingEstimate, LightsOfAllKindsTogether) {
    Scene scene;
    add(scene, ceiling_panel({0, 2, 0}, 1, 1), emitting(Rgb(4)));
    PunctualLight point, spot, sun;
    point.kind = PunctualLight::Kind::Point, point.intensity = Rgb(2), point.position = vec3(1, 1, 0),
    point.range_m = 3;
    spot.kind = PunctualLight::Kind::Spot, spot.intensity = Rgb(10), spot.position = vec3(-1, 2, 0.5f);
    spot.direction = vec3(0, -1, 0), spot.cos_inner = std::cos(0.3f), spot.cos_outer = std::cos(0.8f);
    sun.kind = PunctualLight::Kind::Directional, sun.intensity = Rgb(5), sun.direction = glm::normalize(vec3(1, -2, 0));
    scene.punctual_lights = {point, spot, sun};
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(0.5f));
    scene.environment = sky;
    finish_scene(scene);

    double exact = 0;
    for (const TriangleLight& light : scene.triangle_lights)
        exact += 4 * triangle_irradiance(scene, light, dvec3(0), dvec3(0, 1, 0));
    const double d = std::sqrt(2.0);
    exact += 2 / (d * d) * (1 - std::pow(d / 3, 4)) * (1 / d);  // point: I cos / d^2, windowed
    const double s = std::sqrt(1 + 4 + 0.25), cone = 2 / s;     // spot: the squared ramp of the extension
    exact += 10 * std::pow((cone - std::cos(0.8)) / (std::cos(0.3) - std::cos(0.8)), 2) / (s * s) * (2 / s);
    exact += 5 * 2 / std::sqrt(5.0);  // sun
    exact += 0.5 * M_PI;              // uniform sky over the hemisphere
    expect_irradiance(estimate_irradiance<TypeParam>(scene, vec3(0), vec3(0, 1, 0), 400'000, 4), exact, 1, 0.02,
                      "all kinds");
}

TYPED_TEST_P(LightSamplingEstimate, MaskedAndTexturedLight) {
    // Left half of the panel emits 1, the right half is cut away: as half a panel.
    Scene scene;
    Material material = emitting(Rgb(1));
    material.alpha_mode = AlphaMode::Mask;
    material.base_color_texture.texture = 0;
    Texture cut;
    cut.size = {2, 1};
    cut.nearest = true;
    cut.wrap_s = cut.wrap_t = Wrap::ClampToEdge;
    cut.texels = {u8vec4(0, 0, 0, 255), u8vec4(0, 0, 0, 0)};
    scene.textures.push_back(cut);
    add(scene, MeshBuilder().quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}).build(0, true), material);
    finish_scene(scene);
    const double exact =
        polygon_irradiance({{-1, 1, -1}, {0, 1, -1}, {0, 1, 1}, {-1, 1, 1}}, dvec3(0, 0, 0), dvec3(0, 1, 0));
    expect_irradiance(estimate_irradiance<TypeParam>(scene, vec3(0), vec3(0, 1, 0), 400'000, 5), exact, 1, 0.02,
                      "masked");
    EXPECT_NEAR(scene.triangle_lights[0].radiance.x + scene.triangle_lights[1].radiance.x, 1.0, 0.05);
}

REGISTER_TYPED_TEST_SUITE_P(LightSamplingDensity, OneTriangleNearAndFar, Parallelogram,
                            TwoSidedMirroredAndTexturedEmitters, TreeOfTriangles, PointLightsThroughTheTreeAndSuns,
                            Environment, EnvironmentsExcessOverItsMean, AnEvenEnvironmentIsSampledEvenly,
                            EnvironmentLooksWhereTheConventionSays);
REGISTER_TYPED_TEST_SUITE_P(LightSamplingEstimate, RectangleAboveAPlane, RectangleInTinyHugeAndDistantScenes,
                            NeedleTriangles, TenThousandLightsAreTheSumOfTheirParts, LightsOfAllKindsTogether,
                            MaskedAndTexturedLight);

}  // namespace photond::test
