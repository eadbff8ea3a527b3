// Photons that light pixels: the same image as from pixels that look for photons, and what a device must keep.

#include <gtest/gtest.h>

#include "renderer/methods/image_space_photon_mapping/image_space_photon_mapping_gpu.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/gpu_render.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_image_space_photon_mapping_test {
namespace {

using Ispm = ImageSpacePhotonMappingGpu;

template <class M>
test::RenderSettingsOf<M> settings_for(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 30};
    settings.passes = passes;
    settings.seed = 7;
    settings.params.photons = 4000;
    settings.params.radius_relative = 0.05f;
    settings.params.kernel = KernelShape::Constant;
    return settings;
}

test::RenderSettingsOf<Ispm> fixed_radius(uint32_t passes) {
    test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(passes);
    settings.params.shrink = false;
    settings.params.boundary = DiscBoundary::None;
    return settings;
}

/// A Lambert sphere of flat triangles, so that its scene needs no smooth normals and has the pipelines of the others.
void add_sphere(Scene& scene, const vec3& centre, float radius_m, uint32_t segments, float albedo) {
    Mesh sphere = MeshBuilder().sphere(centre, radius_m, segments).build(0);
    sphere.normals.clear();
    test::add(scene, std::move(sphere), test::lambert(albedo));
    finish_scene(scene);
}

// Where all is flat and Lambert, a photon is on a pixel's disc just when the pixel is on the photon's: the same pairs.
// The paths of eye and light have the same numbers, but for where rounding sends one elsewhere.
TEST(GpuImageSpacePhotonMapping, IsPhotonMappingWithTheLoopsTurnedRound) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box"));
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<PhotonMapping> gathered = settings_for<PhotonMapping>(4);
    gathered.params.gather = Gather::Direct;
    gathered.params.search = PhotonSearch::Kind::Radius;
    gathered.params.boundary = DiscBoundary::None;
    const Film scattered = test::render(where, fixed_radius(4));
    const Film wanted = test::render(scene, gathered);
    const double light = test::mean_of_layer(wanted, Layer::Indirect);
    EXPECT_GT(light, 0);
    EXPECT_NEAR(test::mean_of_layer(scattered, Layer::Indirect), light, 0.002 * light);
    EXPECT_LT(test::mean_relative_difference(wanted.resolve(Layer::Indirect), scattered.resolve(Layer::Indirect)),
              0.01);
}

TEST(GpuImageSpacePhotonMapping, SameBitsTwice) {
    // With the footprints that these scenes have in other tests: the pipelines are the same.
    for (const auto& [name, footprint] : {std::pair("cornell-box-glass", PhotonFootprint::Volume),
                                          std::pair("cornell-box-glossy", PhotonFootprint::Auto)}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(2);
        settings.params.footprint = footprint;
        const Film film = test::render(where, settings);
        EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << name;
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
    }
}

// The image is smooth, so that most of what sub-sampling takes away is found again: the better the weights, the more.
TEST(GpuImageSpacePhotonMapping, FewerLitPixelsMakeNearlyTheSameImage) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = fixed_radius(2);
    settings.size = {60, 45};
    settings.params.radius_relative = 0.1f;
    settings.params.photons = 20'000;
    settings.params.kernel = KernelShape::Epanechnikov;
    const std::vector<float> whole = test::render(where, settings).resolve(Layer::Indirect);
    settings.params.subsampling = 4;
    double before = 1;
    for (const Upsampling upsampling :
         {Upsampling::Nearest, Upsampling::Bilinear, Upsampling::Normal, Upsampling::Geometry}) {
        settings.params.upsampling = upsampling;
        const double apart =
            test::mean_relative_difference(whole, test::render(where, settings).resolve(Layer::Indirect));
        std::printf("upsampling %d: %.3f of the light is elsewhere\n", int(upsampling), apart);
        EXPECT_LT(apart, before);
        before = apart;
    }
}

// Both lack light, where surfaces end or bend away; what either has, both together have.
TEST(GpuImageSpacePhotonMapping, BothFootprintsTogetherLackLessThanEither) {
    Scene scene = make_builtin_scene("cornell-box");
    add_sphere(scene, {0, 1, -2.2f}, 0.3f, 32, 0.7f);  // bends away
    const test::SceneOnDevice where(scene);
    const auto with = [&](PhotonFootprint footprint) {
        test::RenderSettingsOf<Ispm> settings = fixed_radius(2);
        settings.params.kernel = KernelShape::Epanechnikov;
        settings.params.footprint = footprint;
        return test::render(where, settings).resolve(Layer::Indirect);
    };
    const std::vector<float> quads = with(PhotonFootprint::Quad), volumes = with(PhotonFootprint::Volume);
    const std::vector<float> both = with(PhotonFootprint::Auto);
    size_t more = 0;
    for (size_t i = 0; i < both.size(); ++i) {
        const float either = std::max(quads[i], volumes[i]);
        ASSERT_GE(both[i], either - 1e-5f * either) << "sums of photons in the same order";
        more += both[i] > 1.001f * quads[i];
    }
    EXPECT_GT(more, 5u);
}

// The same pairs of photon and pixel, found in another way; the sums are added up in another order.
TEST(GpuImageSpacePhotonMapping, DrawnPhotonsMakeTheSameImage) {
    struct Case {
        const char* scene;
        PhotonFootprint footprint;
        DiscBoundary boundary;
        uint32_t subsampling;
    };
    for (const auto& [name, footprint, boundary, subsampling] :
         {Case{"cornell-box", PhotonFootprint::Quad, DiscBoundary::None, 1},
          Case{"cornell-box", PhotonFootprint::Volume, DiscBoundary::None, 4},
          Case{"cornell-box-glossy", PhotonFootprint::Auto, DiscBoundary::Clip, 1}}) {
        const Scene scene = test::turned(make_builtin_scene(name));
        const test::SceneOnDevice where(scene);
        test::RenderSettingsOf<Ispm> settings = fixed_radius(2);
        settings.size = {40, 30};
        settings.params.kernel = KernelShape::Epanechnikov;
        settings.params.footprint = footprint;
        settings.params.boundary = boundary;
        settings.params.subsampling = subsampling;
        settings.layers.add(Layer::Overlap);
        const Film tiles = test::render(where, settings);
        settings.params.scatter = PhotonScatter::Raster;
        const Film drawn = test::render(where, settings);
        const double apart =
            test::mean_relative_difference(tiles.resolve(Layer::Indirect), drawn.resolve(Layer::Indirect));
        std::printf("footprint %d: %.1e apart\n", int(footprint), apart);
        EXPECT_LT(apart, 1e-6);
        EXPECT_LT(test::mean_relative_difference(tiles.resolve(Layer::Overlap), drawn.resolve(Layer::Overlap)), 1e-3)
            << "of photons that bring next to nothing";
        EXPECT_EQ(drawn.pixel_hash(), test::render(where, settings).pixel_hash()) << "the same bits each time";
    }
}

// Photons that share where light first arrives bring the same light, and are traced with fewer rays.
TEST(GpuImageSpacePhotonMapping, PhotonsThatShareTheirFirstHitsBringTheSameLight) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = fixed_radius(1);
    settings.params.sampler = SamplerKind::Random;
    settings.passes = 30;
    Stats apart_stats, shared_stats;
    const test::RunningMean apart = test::indirect_of_passes(where, settings, &apart_stats);
    settings.params.bounce_map_texels = 1500;  // 4,000 photons: a number that they do not divide by
    settings.layers.add(Layer::BounceMap);
    const test::RunningMean shared = test::indirect_of_passes(where, settings, &shared_stats);
    EXPECT_LT(std::fabs(shared.mean() - apart.mean()),
              5.2 * std::hypot(shared.standard_error(), apart.standard_error()));
    EXPECT_LT(shared.standard_error(), 0.02 * shared.mean()) << "too noisy to notice a defect";
    EXPECT_EQ(apart_stats.counts.photon_rays_saved, 0u);
    EXPECT_EQ(shared_stats.counts.photon_rays_saved, 30u * (4000u - 1500u));
    const auto rays = double(apart_stats.counts.photon_rays);
    EXPECT_NEAR(double(shared_stats.counts.photon_rays + shared_stats.counts.photon_rays_saved), rays, 0.01 * rays);
    uint64_t photons = 0;
    for (size_t i = 0; i + 1 < Counts::kBounces; ++i) {
        photons += shared_stats.counts.photons_by_bounce[i];
        if (i > 0) {
            EXPECT_LT(shared_stats.counts.photons_by_bounce[i], shared_stats.counts.photons_by_bounce[i - 1]);
        }
    }
    photons += shared_stats.counts.photons_by_bounce.back();
    EXPECT_EQ(photons, shared_stats.counts.photons_stored);
}

// The host's paths have the numbers of the device's, but for where rounding sends one elsewhere.
TEST(GpuImageSpacePhotonMapping, PhotonsTracedOnTheHostAreTheSame) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box-glass"));
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(3);
    settings.params.shrink = false;
    Stats device_stats, host_stats;
    const Film on_device = test::render(where, settings, &device_stats);
    settings.params.trace = PhotonTrace::Cpu;
    const Film on_host = test::render(where, settings, &host_stats);
    const auto stored = double(device_stats.counts.photons_stored);
    EXPECT_NEAR(double(host_stats.counts.photons_stored), stored, 0.002 * stored);
    EXPECT_EQ(host_stats.counts.photons_emitted, device_stats.counts.photons_emitted);
    EXPECT_LT(test::mean_relative_difference(on_device.resolve(Layer::Indirect), on_host.resolve(Layer::Indirect)),
              0.01);
    EXPECT_EQ(on_host.pixel_hash(), test::render(where, settings).pixel_hash()) << "the same bits each time";
}

// A pass is itself whether the one before was traced too or not, and where there is too little room at first.
TEST(GpuImageSpacePhotonMapping, PassesTracedOnTheHostStandAlone) {
    Scene scene = test::floor_and_wall("point");
    add_sphere(scene, {0, 0, 0}, 30, 16, 0.9f);  // whence no light escapes
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(2);
    settings.params.trace = PhotonTrace::Cpu;
    Film apart({40, 30}, settings.layers);
    for (uint32_t pass = 0; pass < 2; ++pass) {
        test::RenderSettingsOf<Ispm> one = settings;
        one.passes = 1, one.first_pass = pass;
        test::run_passes(where, one, [&](Ispm& method, uint32_t) { method.resolve(apart); });
    }
    Stats stats;
    EXPECT_EQ(test::render(where, settings, &stats).pixel_hash(), apart.pixel_hash());
    EXPECT_GT(stats.counts.photons_stored, 2 * stats.counts.photons_emitted) << "more than there is room for at first";
}

// Caustic photons have footprints of their own, whose kernels have the same integral.
TEST(GpuImageSpacePhotonMapping, SmallerCausticFootprintsBringTheSameLight) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(24);
    settings.params.photons = 1500;
    settings.params.sampler = SamplerKind::Random;
    settings.params.shrink = false;
    settings.params.caustic_radius_share = 1;
    const test::RunningMean wide = test::indirect_of_passes(where, settings);
    settings.params.caustic_radius_share = 0.35f;
    const test::RunningMean narrow = test::indirect_of_passes(where, settings);
    EXPECT_LT(std::fabs(test::standard_errors_between(wide, narrow)), 5.2);
    EXPECT_LT(narrow.standard_error(), 0.02 * narrow.mean()) << "too noisy to notice a defect";
}

constexpr double kStandardErrors = 5.2;  // false alarms 2e-7

/// How much of path tracing's indirect light is lacking, and how much of that is in doubt.
struct Lack {
    double share, doubt;
};

class GpuImageSpacePhotonMappingLight : public testing::Test {
protected:
    /// Path tracing's light, rendered once for all tests.
    static const test::RunningMean& light_of_paths(const Scene& scene) {
        static const test::RunningMean light = [&] {
            test::RenderSettings settings;
            settings.size = {24, 18};
            settings.passes = 4000;  // they cost less than photons, whose noise is to be most of the doubt
            settings.params.sampler = SamplerKind::Random;
            return test::indirect_of_passes(scene, settings);
        }();
        return light;
    }
    Lack lack(test::RenderSettingsOf<Ispm> settings, float radius_relative) const {
        settings.params.sampler = SamplerKind::Random;
        settings.params.radius_relative = radius_relative;
        const test::RunningMean light = test::indirect_of_passes(where_, settings);
        const test::RunningMean& paths = light_of_paths(scene_);
        const Lack lack{1 - light.mean() / paths.mean(),
                        kStandardErrors * std::hypot(light.standard_error(), paths.standard_error()) / paths.mean()};
        std::printf("radius %.3f: lacks %.2f %%, %.2f %% in doubt\n", double{radius_relative}, 100 * lack.share,
                    100 * lack.doubt);
        return lack;
    }
    static constexpr float kWide = 0.1f;  // a radius, of the scene's
    static test::RenderSettingsOf<Ispm> of_wide() {
        test::RenderSettingsOf<Ispm> settings = fixed_radius(60);
        settings.size = {32, 24};
        settings.params.photons = 2200;
        return settings;
    }
    /// Of whole footprints of that radius, rendered once for all tests.
    Lack lack_of_wide() const {
        static const Lack wide = lack(of_wide(), kWide);
        return wide;
    }

private:
    const Scene scene_ = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where_{scene_};
};

// What whole footprints lose past the ends of surfaces is in proportion to their radius, in the first order: as they
// shrink the image comes to path tracing's.
TEST_F(GpuImageSpacePhotonMappingLight, WholeFootprintsLackInProportionToTheirRadius) {
    test::RenderSettingsOf<Ispm> of_narrow = fixed_radius(60);
    of_narrow.size = {48, 36};  // pixels cost less than photons, few of which are on a narrow footprint
    const Lack wide = lack_of_wide(), narrow = lack(of_narrow, kWide / 5);
    EXPECT_GT(wide.share, wide.doubt);
    EXPECT_LT(std::fabs(narrow.share - wide.share / 5), narrow.doubt + wide.doubt / 5 + wide.share / 25)
        << "of the second order, a fifth of a fifth";
    EXPECT_LT(narrow.doubt + wide.doubt / 5, 0.5 * wide.share) << "too noisy to notice a defect";
}

// Clipped ones lack none in the first order.
TEST_F(GpuImageSpacePhotonMappingLight, ClippedFootprintsLackHardlyAny) {
    test::RenderSettingsOf<Ispm> clipped = of_wide();
    clipped.params.boundary = DiscBoundary::Clip;
    const Lack whole = lack_of_wide(), cut = lack(clipped, kWide);
    EXPECT_GT(whole.share, 2 * whole.doubt) << "too noisy to notice a defect";
    EXPECT_LT(std::fabs(cut.share), cut.doubt + 0.1 * whole.share);
}

// A floor goes on below a wall that stands on it, but not the light.
TEST(GpuImageSpacePhotonMapping, NoLightPassesThinWalls) {
    const Scene scene = make_builtin_scene("hard-case/thin-wall-1e-3");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = fixed_radius(4);
    EXPECT_GT(test::mean_of_layer(test::render(where, settings), Layer::Indirect), 0) << "that is seen with whole ones";
    settings.params.boundary = DiscBoundary::Clip;
    EXPECT_EQ(test::mean_of_layer(test::render(where, settings), Layer::Indirect), 0);
}

TEST(GpuImageSpacePhotonMapping, MoreBouncesAreMoreLight) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    double before = 0;
    for (const uint32_t bounces : {1u, 3u}) {
        test::RenderSettingsOf<Ispm> settings = fixed_radius(2);
        settings.params.bounces = bounces;
        const double light = test::mean_of_layer(test::render(where, settings), Layer::Indirect);
        EXPECT_GT(light, 1.1 * before);
        before = light;
    }
}

TEST(GpuImageSpacePhotonMapping, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none"), lit = test::floor_and_wall("point");
    for (const Scene* scene : {&dark, &lit}) {
        const test::SceneOnDevice where(*scene);
        test::RenderSettingsOf<Ispm> settings = settings_for<Ispm>(2);
        if (scene == &lit) settings.params.bounces = 0;
        const Film film = test::render(where, settings);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Direct) > 0, scene == &lit);
    }
}

TEST(GpuImageSpacePhotonMapping, TakesTheMemoryItSays) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        const Scene scene = make_builtin_scene(name);
        test::RenderSettingsOf<Ispm> settings;
        settings.size = {256, 192};
        const test::SceneOnDevice where(scene);
        for (const PhotonTrace trace : {PhotonTrace::Gpu, PhotonTrace::Cpu}) {
            settings.params.trace = trace;
            test::expect_device_bytes_as_estimated<Ispm>(where, settings);
        }
    }
}

}  // namespace
}  // namespace photond::gpu_image_space_photon_mapping_test
