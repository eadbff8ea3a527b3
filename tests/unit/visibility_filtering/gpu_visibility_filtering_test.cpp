// Visibility filtering: proxies bring the light of every kind of lamp, far voxels what their harmonics say, and lists
// what the filter says.

#include <gtest/gtest.h>

#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_visibility_filtering_test {
namespace {

using VisibilityFiltering = VisibilityFilteringGpu;
using Settings = test::RenderSettingsOf<VisibilityFiltering>;

constexpr double kStandardErrors = 5.2;  // false alarms 2e-7

/// Unbiased but for softening that is next to nothing: every voxel is asked by a ray, and all are near.
Settings asked_by_rays(uint32_t passes) {
    Settings settings;
    settings.size = {24, 18};
    settings.passes = passes;
    settings.seed = 3;
    settings.params.proxies = 8000;
    settings.params.visibility = ProxyVisibility::Rays;
    settings.params.near_voxels = 1e5f;
    settings.params.subsampling = 1;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

class GpuVisibilityFilteringLights : public testing::TestWithParam<const char*> {};

// Independent answer: path tracing of one bounce.
TEST_P(GpuVisibilityFilteringLights, ReachOtherSurfaces) {
    const Scene scene = test::floor_and_wall(GetParam());
    test::RenderSettings traced;
    traced.size = {24, 18};
    traced.passes = 2400;
    traced.params.indirect_bounces = 1;
    traced.params.sampler = SamplerKind::Random;
    const test::RunningMean wanted = test::indirect_of_passes(scene, traced);
    Settings asked = asked_by_rays(34);
    if (!scene.needs.environment) asked.params.proxies = 2000;  // a small lamp's light needs no more
    const test::RunningMean found = test::indirect_of_passes(test::SceneOnDevice(scene), asked);
    const double doubt = kStandardErrors * std::hypot(found.standard_error(), wanted.standard_error());
    std::printf("%s: %+.3f %%, %.3f in doubt\n", GetParam(), 100 * (found.mean() / wanted.mean() - 1),
                100 * doubt / wanted.mean());
    constexpr double kSoftening = 2e-3;  // r^2 / d^2, 0.7 m apart
    EXPECT_LT(std::fabs(found.mean() - wanted.mean()), doubt + kSoftening * wanted.mean());
    EXPECT_LT(doubt, 0.03 * wanted.mean()) << "too noisy to notice a defect";
}

INSTANTIATE_TEST_SUITE_P(All, GpuVisibilityFilteringLights, testing::Values("point", "area", "environment"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

// Nothing stands between: maps of what lights see say what rays say.
TEST(GpuVisibilityFiltering, DepthMapsLightProxiesAsRaysDo) {
    const Scene scene = test::floor_and_wall("spot");
    const test::SceneOnDevice where(scene);
    Settings settings = asked_by_rays(2);
    const double by_rays = test::mean_of_layer(test::render(where, settings), Layer::Indirect);
    settings.params.proxy_shadows = ProxyShadows::DepthMaps;
    Stats stats;
    const double by_maps = test::mean_of_layer(test::render(where, settings, &stats), Layer::Indirect);
    EXPECT_GT(by_rays, 0);
    EXPECT_NEAR(by_maps, by_rays, 0.005 * by_rays);
    EXPECT_GT(stats.counts.shadow_rays, settings.params.depth_map_resolution) << "no map was made";
}

/// A small patch of a ceiling that a point light lights, and another small one that sees it at an angle [radians] from
/// its normal and faces it.
Scene patch_seen_at(float angle) {
    Scene scene;
    constexpr float kHalf = 0.05f, kDistance = 4;
    const vec3 way(std::sin(angle), -std::cos(angle), 0), side = glm::cross(way, vec3(0, 0, 1));
    const auto patch = [&](const vec3& middle, const vec3& s) {
        const vec3 t(0, 0, kHalf);
        return MeshBuilder().quad(middle - s - t, middle + s - t, middle + s + t, middle - s + t).build(0);
    };
    test::add(scene, patch(vec3(0), vec3(kHalf, 0, 0)), test::lambert(0.8f));
    test::add(scene, patch(kDistance * way, kHalf * side), test::lambert(0.8f));
    PunctualLight light;  // beside the way between them: it lights the far one's back alone, if at all
    light.kind = PunctualLight::Kind::Point;
    light.position = vec3(0, -1, 0.7f);
    light.intensity = Rgb(5);
    scene.punctual_lights.push_back(light);
    const vec3 eye = (kDistance - 0.6f) * way + 0.2f * side;
    scene.cameras.push_back(look_at_camera(dvec3(eye), dvec3(kDistance * way), {0, 0, 1}, 0.08f));
    finish_scene(scene);
    return scene;
}

// Harmonics of order 1 make 1 / 4 + cos / 2 of a cosine [Ramamoorthi and Hanrahan 2001]: 3/4 of it straight ahead, as
// much as it at 60 degrees.
TEST(GpuVisibilityFiltering, FarVoxelsSendWhatHarmonicsOfOrderOneSay) {
    for (const float degrees : {0.0f, 40.0f, 60.0f}) {
        const float angle = degrees * std::numbers::pi_v<float> / 180;
        const Scene scene = patch_seen_at(angle);
        const test::SceneOnDevice where(scene);
        Settings settings = asked_by_rays(20);
        settings.size = {8, 8};
        settings.params.proxies = 2000;
        const test::RunningMean near = test::indirect_of_passes(where, settings);
        settings.params.near_voxels = 1;
        const test::RunningMean far = test::indirect_of_passes(where, settings);
        const double wanted = (0.25 + 0.5 * std::cos(angle)) / std::cos(angle), found = far.mean() / near.mean();
        const double doubt = kStandardErrors * std::hypot(near.standard_error(), far.standard_error()) / near.mean();
        std::printf("%g degrees: %.4f, wanted %.4f, %.4f in doubt\n", double{degrees}, found, wanted, doubt);
        EXPECT_NEAR(found, wanted, 0.005 * wanted + doubt);
        EXPECT_LT(doubt, 0.05 * wanted);
    }
}

TEST(GpuVisibilityFiltering, SameBitsTwiceAndNothingThatIsNoNumber) {
    for (const char* name : {"cornell-box", "cornell-box-glossy"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        for (const ProxyVisibility visibility : {ProxyVisibility::Discs, ProxyVisibility::Svo, ProxyVisibility::Rays}) {
            Settings settings;
            settings.size = {40, 30};
            settings.passes = 2;
            settings.params.proxies = 4000;
            settings.params.voxel_resolution = 64;
            settings.params.visibility = visibility;
            if (visibility == ProxyVisibility::Svo && !scene.needs.only_lambert())
                settings.params.specular = ProxySpecular::Paper;
            Stats stats;
            const Film film = test::render(where, settings, &stats);
            EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << name;
            EXPECT_EQ(film.nan_count() + film.infinity_count() + stats.counts.nan_samples, 0u);
            EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
            EXPECT_NEAR(double(stats.counts.vpls), 2 * 4000, 60) << "proxies";
        }
    }
}

// The filter gives a list what those about it have, so a wider one gives more; without one a list has its own.
TEST(GpuVisibilityFiltering, WiderFiltersSeeMoreVoxels) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings;
    settings.size = {96, 72};
    settings.params.rays = 16;
    settings.params.lists = ListKind::Bits;
    settings.params.voxels = 6;
    for (const Layer layer : {Layer::VisibilityCount, Layer::ListsBeforeFilter, Layer::Proxies, Layer::ProxyVoxels})
        settings.layers.add(layer);
    std::vector<float> before;
    double light = 0;
    for (const uint32_t side : {1u, 3u, 7u}) {
        settings.params.filter_side = side;
        const Film film = test::render(where, settings);
        const std::vector<float> seen = film.resolve(Layer::VisibilityCount);
        const std::vector<float> own = film.resolve(Layer::ListsBeforeFilter);
        if (side == 1) {
            EXPECT_EQ(seen, own);
        }
        for (size_t i = 0; i < seen.size(); ++i) {
            ASSERT_GE(seen[i], own[i]);
            ASSERT_GE(seen[i], before.empty() ? 0 : before[i]);
        }
        EXPECT_GT(test::mean_of(seen), before.empty() ? 1 : 1.1 * test::mean_of(before));
        EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), light) << "more voxels, more light";
        light = test::mean_of_layer(film, Layer::Indirect);
        before = seen;
        const std::vector<float> discs = film.resolve(Layer::Proxies);
        EXPECT_GT(std::count_if(discs.begin(), discs.end(), [](float value) { return value > 0; }),
                  std::ptrdiff_t(discs.size() / 3));
    }
}

// Of the light that shadow rays find, lists that count rays have about as much in fine voxels as in coarse ones; lists
// of bits lose half of it.
TEST(GpuVisibilityFiltering, CountsFindTheLightInVoxelsOfAnySize) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    const auto light_of = [&](Settings settings) {
        settings.size = {48, 36};
        settings.passes = 1;
        return test::mean_of_layer(test::render(where, settings), Layer::Indirect);
    };
    const double wanted = light_of(asked_by_rays(1));
    const auto share = [&](ProxyVisibility visibility, ListKind lists, uint32_t voxels) {
        Settings settings;
        settings.params.visibility = visibility;
        settings.params.lists = lists;
        settings.params.voxels = voxels;
        const double found = light_of(settings) / wanted;
        std::printf("visibility %d, lists %d, %u voxels: %.3f of the light\n", int(visibility), int(lists), voxels,
                    found);
        return found;
    };
    for (const ProxyVisibility visibility : {ProxyVisibility::Discs, ProxyVisibility::Svo}) {
        const double in_coarse = share(visibility, ListKind::Counts, 6),
                     in_fine = share(visibility, ListKind::Counts, 20);
        const double coarse_bits = share(visibility, ListKind::Bits, 6),
                     fine_bits = share(visibility, ListKind::Bits, 20);
        EXPECT_LT(std::fabs(in_fine - 1), 0.5 * std::fabs(fine_bits - 1));
        EXPECT_LT(std::fabs(in_fine - in_coarse), 0.2 * std::fabs(fine_bits - coarse_bits));
    }
}

// Whether lists are bits of which the four about a point are joined, or numbers that light list by list: the same sums.
TEST(GpuVisibilityFiltering, IndicesLightAsBitsDo) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings;
    settings.size = {64, 48};
    settings.params.lists = ListKind::Bits;
    const std::vector<float> bits = test::render(where, settings).resolve(Layer::Indirect);
    settings.params.lists = ListKind::Indices;
    EXPECT_GT(test::mean_of(bits), 0);
    EXPECT_LT(test::mean_relative_difference(bits, test::render(where, settings).resolve(Layer::Indirect)), 1e-4);
}

constexpr Size2 kFlickerSize{128, 96};

/// Positions and the numbers of voxels met there, as a camera that is moved a little sees them.
struct SeenLists {
    std::vector<float> positions, counts;
};
SeenLists lists_from(const char* name, float moved_m, bool world_rays) {
    Scene scene = make_builtin_scene(name);
    scene.cameras.front().position.x += moved_m;
    Settings settings;
    settings.size = kFlickerSize;
    settings.params.proxies = 6000;
    settings.params.filter_side = 1;
    settings.params.rays = 8;
    settings.params.voxels = 6;
    settings.params.lists = ListKind::Bits;
    settings.params.march_subsampling = settings.params.subsampling = 1;
    settings.params.world_rays = world_rays;
    for (const Layer layer : {Layer::ListsBeforeFilter, Layer::Position}) settings.layers.add(layer);
    const Film film = test::render(test::SceneOnDevice(scene), settings);
    return {film.resolve(Layer::Position), film.resolve(Layer::ListsBeforeFilter)};
}

/// Mean difference of the numbers at the same places: those within 14 mm, less than a pixel, which the camera that is
/// moved to the side sees in the same row or one beside it.
double flicker(const SeenLists& a, const SeenLists& b) {
    double sum = 0, places = 0;
    constexpr size_t kRow = kFlickerSize.width;
    for (size_t i = 0; i < a.counts.size(); ++i) {
        const size_t row = i / kRow, first = row > 0 ? row - 1 : 0;
        const vec3 at(a.positions[3 * i], a.positions[3 * i + 1], a.positions[3 * i + 2]);
        for (size_t j = first * kRow; j < std::min((row + 2) * kRow, b.counts.size()); ++j) {
            const vec3 d = vec3(b.positions[3 * j], b.positions[3 * j + 1], b.positions[3 * j + 2]) - at;
            if (glm::dot(at, at) == 0 || glm::dot(d, d) > 2e-4f) continue;  // nothing is seen there, or another place
            sum += std::fabs(a.counts[i] - b.counts[j]), ++places;
            break;
        }
    }
    EXPECT_GT(places, 300) << "too few places are seen twice";
    return sum / places;
}

// Where the camera moves, rays that are tied to the world go on to meet what they met.
TEST(GpuVisibilityFiltering, RaysTiedToTheWorldFlickerLess) {
    const auto flicker_with = [](bool world_rays) {
        return flicker(lists_from("cornell-box", 0, world_rays), lists_from("cornell-box", 0.05f, world_rays));
    };
    const double tied = flicker_with(true), by_pixel = flicker_with(false);
    std::printf("voxels that come or go: %.2f tied to the world, %.2f by pixel\n", tied, by_pixel);
    EXPECT_LT(tied, 0.5 * by_pixel);
}

TEST(GpuVisibilityFiltering, NoLightPassesThinWallsWhereRaysAsk) {
    const Scene scene = make_builtin_scene("hard-case/thin-wall-1e-3");
    Settings settings = asked_by_rays(2);
    settings.params.near_voxels = 1.5f;
    EXPECT_EQ(test::mean_of_layer(test::render(test::SceneOnDevice(scene), settings), Layer::Indirect), 0);
}

TEST(GpuVisibilityFiltering, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none"), lit = test::floor_and_wall("point");
    for (const Scene* scene : {&dark, &lit}) {
        Settings settings;
        settings.passes = 2;
        if (scene == &lit) settings.params.bounces = 0;
        const Film film = test::render(test::SceneOnDevice(*scene), settings);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Direct) > 0, scene == &lit);
    }
}

/// As many triangles as a furnished room has, and gloss, but no pipeline that other tests do not have.
Scene many_glossy_triangles() {
    Scene scene = make_builtin_scene("cornell-box-glossy");
    Mesh torus = MeshBuilder().torus({0, 1.5f, -1.5f}, 0.8f, 0.3f, 256, 128).build(0);
    torus.normals.clear();
    test::add(scene, std::move(torus), test::lambert(0.5f));
    finish_scene(scene);
    return scene;
}

TEST(GpuVisibilityFiltering, TakesTheMemoryItSays) {
    for (const Scene& scene : {make_builtin_scene("cornell-box"), many_glossy_triangles()}) {
        const test::SceneOnDevice where(scene);
        for (const ProxyVisibility visibility : {ProxyVisibility::Discs, ProxyVisibility::Svo, ProxyVisibility::Rays}) {
            Settings settings;
            settings.size = {256, 192};
            settings.params.visibility = visibility;
            // Lists take what the image and the parameters say, whatever the scene.
            settings.params.kept_lists = visibility == ProxyVisibility::Discs && scene.needs.only_lambert() ? 8 : 0;
            if (visibility == ProxyVisibility::Svo && !scene.needs.only_lambert())
                settings.params.specular = ProxySpecular::Paper;  // as above
            test::expect_device_bytes_as_estimated<VisibilityFiltering>(where, settings);
        }
    }
}

}  // namespace
}  // namespace photond::gpu_visibility_filtering_test
