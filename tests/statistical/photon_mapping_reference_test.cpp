// Photon mapping against images of the diffuse Cornell box made by an independent renderer (tests/data/reference).
//
// What is judged is the relative bias of a mean over many pixels. Photons are shared by all pixels of a pass, so its
// noise is that of the passes' means (Student's t over them), not of the pixels, with the reference's beside it. The
// long runs are held to the bias asked for as it stands; the short ones allow their own noise beside it. Both check
// that their noise is small enough to notice a defect.

#include <gtest/gtest.h>

#include <map>

#include "renderer/film/exr_file.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

constexpr Size2 kSize{256, 256};
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 3 * 3 * 2;       // three channels of three comparisons, short and long
constexpr double kReferenceNoise = 2.7e-4;  // RMSE a pixel, tests/data/reference/README.md

using Settings = test::RenderSettingsOf<PhotonMapping>;

std::vector<float> reference(const char* file) {
    return read_exr(std::filesystem::path(PHOTOND_TEST_DATA) / "reference" / file).layers.at("beauty");
}

/// Which pixels are judged; all when empty.
using Mask = std::vector<uint8_t>;

double masked_mean(const std::vector<float>& image, size_t channel, const Mask& mask) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = channel; i < image.size(); i += 3)
        if (mask.empty() || mask[i / 3]) sum += image[i], ++count;
    return sum / double(count);
}

/// The mean that is expected of the indirect layer, and what its bias is relative to.
struct Expected {
    std::vector<float> indirect;
    std::vector<float> relative_to;
};

struct Run {
    uint32_t groups, passes;  // films, and passes of each: the spread of the films' means is the noise
    double must_notice;       // relative
    bool allow_noise;         // beside the bias allowed
};

/// Checks the indirect layer's bias by channel; direct light is light sampling's, tested with path tracing.
void expect_bias_within(double allowed, const Run& run, const Scene& scene, Settings settings, const Expected& expected,
                        const Mask& mask = {}) {
    test::RunningMean means[3];
    settings.passes = run.passes;
    for (uint32_t g = 0; g < run.groups; ++g) {
        settings.first_pass = g * run.passes;
        const Film film = test::render(scene, settings);
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        const std::vector<float> image = film.resolve(Layer::Indirect);
        ASSERT_EQ(image.size(), expected.indirect.size());
        for (size_t c = 0; c < 3; ++c) means[c].add(masked_mean(image, c, mask));
    }
    const double pixels = mask.empty() ? double(kSize.pixels()) : double(std::count(mask.begin(), mask.end(), 1));
    const double share = test::share_of_false_alarm(kFalseAlarm, kChecks);
    for (size_t c = 0; c < 3; ++c) {
        const double scale = masked_mean(expected.relative_to, c, mask);
        const double bias = (means[c].mean() - masked_mean(expected.indirect, c, mask)) / scale;
        const double noise = (test::two_sided_t(share, double(run.groups) - 1) * means[c].standard_error() +
                              test::two_sided_z(share) * kReferenceNoise / std::sqrt(pixels)) /
                             scale;
        std::printf("channel %zu: relative bias %+.4f %%, standard error %.4f %%\n", c, 100 * bias,
                    100 * means[c].standard_error() / scale);
        EXPECT_LE(std::abs(bias), allowed + (run.allow_noise ? noise : 0)) << "channel " << c;
        EXPECT_LE(noise, run.must_notice) << "too noisy to notice a defect";
    }
}

/// Pixels whose points, and whose neighbours', lie farther than `distance` from every edge at which a surface ends or
/// bends, and on one surface (silhouettes are left out).
Mask far_from_edges(const Scene& scene, const std::vector<float>& positions, float distance) {
    struct Edge {
        vec3 a, b;
    };
    struct Face {
        vec3 normal;
        size_t count;
        Edge edge;
        bool crease;
    };
    const auto key = [](const vec3& p) {
        return std::array<long, 3>{std::lround(1e3f * p.x), std::lround(1e3f * p.y), std::lround(1e3f * p.z)};
    };
    std::map<std::array<std::array<long, 3>, 2>, Face> faces;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners corners = world_triangle(scene, i, t);
            const vec3 n = glm::normalize(glm::cross(corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]));
            for (int e = 0; e < 3; ++e) {
                const Edge edge{corners.p[e], corners.p[(e + 1) % 3]};
                const auto ka = key(edge.a), kb = key(edge.b);
                const auto [at, added] =
                    faces.try_emplace({std::min(ka, kb), std::max(ka, kb)}, Face{n, 0, edge, false});
                ++at->second.count;
                at->second.crease |= glm::dot(at->second.normal, n) < 0.99f;
            }
        }
    }
    Mask mask(kSize.pixels(), 0);
    for (size_t i = 0; i < mask.size(); ++i) {
        const vec3 p(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
        if (p == vec3(0)) continue;  // nothing was hit
        bool far = true;
        for (const auto& [unused, face] : faces) {
            if (face.count == 2 && !face.crease) continue;
            const vec3 along = face.edge.b - face.edge.a;
            const float s = std::clamp(glm::dot(p - face.edge.a, along) / glm::dot(along, along), 0.0f, 1.0f);
            far = far && glm::length(p - face.edge.a - s * along) > distance;
        }
        mask[i] = far;
    }
    Mask inner(mask.size(), 0);
    const size_t width = kSize.width;
    for (size_t y = 1; y + 1 < kSize.height; ++y) {
        for (size_t x = 1; x + 1 < width; ++x) {
            bool far = true;
            for (size_t j = y - 1; j <= y + 1; ++j)
                for (size_t i = x - 1; i <= x + 1; ++i) {
                    const float* p = &positions[3 * (j * width + i)];
                    const float* q = &positions[3 * (y * width + x)];
                    far = far && mask[j * width + i] && std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < 0.3f;
                }
            inner[y * width + x] = far;
        }
    }
    return inner;
}

/// Emitted, direct and indirect light of the reference, and its indirect light alone.
Expected all_bounces() {
    Expected expected{reference("reference_256.exr"), reference("reference_256.exr")};
    const std::vector<float> direct = reference("direct_only_256.exr");
    for (size_t i = 0; i < direct.size(); ++i) expected.indirect[i] -= direct[i];
    return expected;
}

void final_gathering(std::optional<uint32_t> bounces, uint32_t gather_rays, const Run& run) {
    Settings settings;
    settings.size = kSize;
    settings.params.gather_rays = gather_rays;
    settings.params.indirect_bounces = bounces;
    // Lookups at the ends of gather rays lose 1.3 % of all indirect light at edges without it, 0.34 % of the image.
    settings.params.boundary = DiscBoundary::Clip;
    const std::vector<float> one_bounce = reference("indirect_one_bounce_256.exr");
    expect_bias_within(3e-3, run, make_builtin_scene("cornell-box"), settings,
                       bounces ? Expected{one_bounce, one_bounce} : all_bounces());
}

/// Fixed radius of 0.05 m, 200,000 photons a pass. The bias is relative to the indirect light itself.
void direct_visualisation(const Run& run) {
    constexpr float kRadius = 0.05f;
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings;
    settings.size = kSize;
    settings.params.gather = Gather::Direct;
    settings.params.search = PhotonSearch::Kind::Radius;
    settings.params.radius_m = kRadius;

    Settings positions = settings;
    positions.passes = 1;
    positions.params.photons = 1;
    positions.layers.add(Layer::Position);
    const Mask mask = far_from_edges(scene, test::render(scene, positions).resolve(Layer::Position), kRadius);
    EXPECT_GT(std::count(mask.begin(), mask.end(), 1), 30000);
    Expected expected = all_bounces();
    expected.relative_to = expected.indirect;
    expect_bias_within(1e-2, run, scene, settings, expected, mask);
}

constexpr Run kShort{12, 1, 0.03, true}, kLong{16, 2, 0.005, false}, kLongDirect{16, 4, 0.01, false};

TEST(PhotonMappingReference, FinalGatheringOfOneBounce) { final_gathering(1, 8, kShort); }
TEST(PhotonMappingReferenceLong, FinalGatheringOfOneBounce) { final_gathering(1, 64, kLong); }

TEST(PhotonMappingReference, FinalGatheringOfAllBounces) { final_gathering({}, 4, kShort); }
TEST(PhotonMappingReferenceLong, FinalGatheringOfAllBounces) { final_gathering({}, 64, kLong); }

TEST(PhotonMappingReference, DirectVisualisationFarFromEdges) { direct_visualisation(kShort); }
TEST(PhotonMappingReferenceLong, DirectVisualisationFarFromEdges) { direct_visualisation(kLongDirect); }

}  // namespace
}  // namespace photond
