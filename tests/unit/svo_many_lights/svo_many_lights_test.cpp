// What many lights promise beside the right light: bits that do not depend on threads or on how passes are cut, layers,
// counts, parameters, memory; and that they stay finite in scenes that leave them nothing to work with.

#include "renderer/methods/svo_many_lights/svo_many_lights.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/render.h"
#include "tests/support/threads.h"

namespace photond::svo_many_lights_test {
namespace {

using Params = SvoManyLightsParams;
using Settings = test::RenderSettingsOf<SvoManyLights>;

Settings small(uint32_t passes = 1) {
    Settings settings;
    settings.size = {40, 35};  // tiles cut at both edges
    settings.passes = passes;
    settings.params.vpls = 100;
    settings.params.bounces = 1;
    settings.params.caustic_photons = 0;
    settings.params.map_resolution = 32;
    settings.params.voxel_resolution = 64;
    return settings;
}

struct Mode {
    const char* name;
    void (*set)(Params& params);
};
/// Every way through the code.
constexpr Mode kModes[] = {
    {"all bounces, caustics by photons", [](Params& p) { p.bounces = Params{}.bounces, p.caustic_photons = 2000; }},
    {"voxels, interleaved",
     [](Params& p) { p.visibility = VplVisibility::Svo, p.vpl_choice = VplChoice::Interleaved; }},
    {"three bounces through voxels, by the camera",
     [](Params& p) {
         p.bounces = 3, p.bounce_tracing = VplBounces::Voxels, p.placement = VplPlacement::Camera;
         p.visibility = VplVisibility::Svo;
     }},
    {"one bounce, caustics path traced", [](Params&) {}},
    {"lightcut, two bounces by rays", [](Params& p) { p.vpl_choice = VplChoice::Lightcut, p.bounces = 2; }},
    {"depth maps", [](Params& p) { p.visibility = VplVisibility::ShadowMaps, p.shadow_resolution = 8; }},
    {"nobody asks V", [](Params& p) { p.visibility = VplVisibility::None, p.repay = p.narrow_lobes = false; }},
    {"the thesis",
     [](Params& p) {
         p.visibility = VplVisibility::Svo, p.vpl_choice = VplChoice::Interleaved, p.repay = p.narrow_lobes = false;
         p.direct = DirectShadows::ShadowMaps, p.direct_resolution = 64, p.filter = 8;
     }},
    {"no clamp", [](Params& p) { p.clamp_m2 = 0.0f, p.vpl_choice = VplChoice::Interleaved, p.roulette = 0; }},
    {"blocks of 8", [](Params& p) { p.vpl_choice = VplChoice::Interleaved, p.interleave = 8; }},
    {"voxels near the point",
     [](Params& p) { p.visibility = VplVisibility::NearField, p.repay = p.narrow_lobes = false; }},
    {"by whole paths, accepted", [](Params& p) { p.placement = VplPlacement::Acceptance, p.bounces = 2; }},
    {"by whole paths, in chains",
     [](Params& p) { p.placement = VplPlacement::Metropolis, p.bounces = 3, p.visibility = VplVisibility::Svo; }},
    {"independent numbers", [](Params& p) { p.sampler = SamplerKind::Random, p.filter = 3; }},
};
Settings in_mode(const Mode& mode, uint32_t passes = 1) {
    Settings settings = small(passes);
    mode.set(settings.params);
    return settings;
}

constexpr Layer kOwnLayers[] = {Layer::Clamped, Layer::Voxels, Layer::Vpls, Layer::SplitNormal, Layer::SplitIndirect};
void ask_for_all(Settings& settings) {
    for (const Layer layer : kOwnLayers) settings.layers.add(layer);
}

double sum_of(const std::vector<float>& values) { return test::mean_of(values) * double(values.size()); }

void expect_sane(const Film& film) {
    EXPECT_EQ(film.nan_count(), 0u);
    EXPECT_EQ(film.infinity_count(), 0u);
    for (const LayerInfo& info : kLayers) {
        if (!film.layers().has(info.layer)) continue;
        for (const float value : film.resolve(info.layer)) {
            EXPECT_TRUE(std::isfinite(value)) << info.name;
            if (info.layer != Layer::SplitNormal) {
                EXPECT_GE(value, 0) << info.name;
            }
        }
    }
}

TEST(SvoManyLights, PixelHashIsTheSameForAnyNumberOfThreads) {
    for (const char* name : {"cornell-box-glossy", "cornell-box-spot", "cornell-box-glass", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const Mode& mode : kModes) {
            if (std::string_view(name) == "interior" && &mode != &kModes[2]) continue;
            if (std::string_view(name) == "cornell-box-glass" && &mode != &kModes[0]) continue;
            Settings settings = in_mode(mode, 2);
            ask_for_all(settings);
            std::vector<std::string> hashes;
            for (const int threads : {1, 2, 4})
                hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
            EXPECT_EQ(hashes[0], hashes[1]) << name << ", " << mode.name;
            EXPECT_EQ(hashes[0], hashes[2]) << name << ", " << mode.name;
        }
    }
}

TEST(SvoManyLights, RangesOfPassesMergeToTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    for (const Mode& mode : {kModes[0], kModes[1], kModes[2], kModes[7], kModes[11], kModes[12]}) {
        Settings settings = in_mode(mode, 4);
        ask_for_all(settings);
        const Film whole = test::render(scene, settings);
        settings.passes = 2;
        Film first = test::render(scene, settings);
        settings.first_pass = 2;
        const Film second = test::render(scene, settings);
        EXPECT_NE(first.pixel_hash(), second.pixel_hash()) << mode.name;
        first.merge(second);
        EXPECT_EQ(first, whole) << mode.name;
        settings.seed = 2;
        EXPECT_NE(test::render(scene, settings).pixel_hash(), second.pixel_hash()) << mode.name;
    }
}

TEST(SvoManyLights, NearFieldLiesBetweenTheVoxelsAndNobody) {
    const Scene scene = make_builtin_scene("interior");
    Settings settings = small(2);
    settings.params.roulette = 0;  // which nobody plays where none is asked for V
    settings.params.repay = settings.params.narrow_lobes = false;
    const auto rendered = [&](VplVisibility visibility, std::optional<float> radius_m) {
        settings.params.visibility = visibility;
        settings.params.near_field_radius_m = radius_m;
        return test::render(scene, settings);
    };
    const float beyond_m = 4 * scene.bounds.radius();
    const Film by_voxels = rendered(VplVisibility::Svo, {}), by_nobody = rendered(VplVisibility::None, {});
    EXPECT_EQ(rendered(VplVisibility::NearField, beyond_m).pixel_hash(), by_voxels.pixel_hash());
    EXPECT_EQ(rendered(VplVisibility::NearField, 0.0f).pixel_hash(), by_nobody.pixel_hash());
    // Each light that the nearer voxels let through comes as well where those farther away do not count.
    const std::vector<float> most = by_nobody.resolve(Layer::Indirect), least = by_voxels.resolve(Layer::Indirect);
    const std::vector<float> between = rendered(VplVisibility::NearField, {}).resolve(Layer::Indirect);
    for (size_t i = 0; i < between.size(); ++i) {
        EXPECT_LE(between[i], most[i] * 1.0001f) << i;
        EXPECT_GE(between[i], least[i] * 0.9999f) << i;
    }
    EXPECT_GT(sum_of(between), 1.001 * sum_of(least));
    EXPECT_LT(sum_of(between), 0.999 * sum_of(most));
}

TEST(SvoManyLights, NoBouncesLeaveTheLayerBlackAndMakeNoLights) {
    for (const Mode& mode : kModes) {
        Settings settings = in_mode(mode);
        settings.params.bounces = 0;
        Stats stats;
        const Film film = test::render(make_builtin_scene("cornell-box-glass"), settings, &stats);
        EXPECT_EQ(sum_of(film.resolve(Layer::Indirect)), 0) << mode.name;
        EXPECT_GT(sum_of(film.resolve(Layer::Direct)), 0) << mode.name;
        EXPECT_EQ(stats.counts.vpls + stats.counts.voxels + stats.counts.photons_emitted, 0u);
    }
}

TEST(SvoManyLights, StaysFiniteInEveryBuiltinScene) {
    for (const std::string_view name : builtin_scene_names()) {
        const Scene scene = make_builtin_scene(name);
        for (const Mode& mode : kModes) {
            if (name == "interior" && &mode != &kModes[2] && &mode != &kModes[7]) continue;
            Settings settings = in_mode(mode);
            settings.size = {24, 16};
            ask_for_all(settings);
            SCOPED_TRACE(testing::Message() << name << ", " << mode.name);
            expect_sane(test::render(scene, settings));
        }
    }
}

TEST(SvoManyLights, StaysFiniteWhereThereIsNothingToWorkWith) {
    for (const test::HardScene& hard : test::hard_scenes())
        for (const Mode& mode : kModes)
            for (const uint32_t vpls : {1u, 64u}) {
                Settings settings = in_mode(mode, 2);
                settings.params.vpls = vpls;
                settings.size = {16, 16};
                SCOPED_TRACE(testing::Message() << hard.name << ", " << vpls << " lights, " << mode.name);
                const Film film = test::render(hard.scene, settings);
                expect_sane(film);
                EXPECT_EQ(sum_of(film.resolve_beauty()) == 0, hard.dark);
            }
}

TEST(SvoManyLights, CountsStagesAndMemoryAreReported) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = in_mode(kModes[1], 2);
    Stats stats;
    MemoryBudget budget;
    test::render(scene, settings, &stats, &budget);
    const uint64_t pixels = settings.size.pixels();
    EXPECT_EQ(stats.counts.camera_rays, 2 * pixels);
    EXPECT_GT(stats.counts.vpls, 190u);
    EXPECT_LE(stats.counts.vpls, 200u);
    EXPECT_GT(stats.counts.voxels, 4u * 64 * 64) << "the walls alone";
    EXPECT_LT(stats.counts.voxels, 20u * 64 * 64);
    EXPECT_LE(stats.counts.bounce_rays, 2 * pixels);
    for (const char* stage :
         {"g_buffer", "g_buffer_split", "direct", "rsm", "vpl_generation", "svo_build", "indirect", "repay", "merge"})
        EXPECT_GT(stats.stage(stage).cpu_seconds, 0) << stage;
    for (const char* structure : {"pass_image", "wavefronts", "light_sampler", "emission_sampler", "vpl_tracer",
                                  "g_buffer", "vpls", "sparse_voxel_octree"})
        EXPECT_GT(budget.structures().at(structure), 0u) << structure;
    settings.params.visibility = VplVisibility::Rays;
    Stats by_rays;
    test::render(scene, settings, &by_rays);
    EXPECT_EQ(by_rays.counts.voxels, 0u) << "nothing asks for them";
    settings.params.bounces = 2;
    Stats two;
    test::render(scene, settings, &two);
    EXPECT_GT(two.counts.vpls, by_rays.counts.vpls * 5 / 4);
    // Without end of bounces roulette ends the paths: about as many lights as memory is set aside for.
    settings.params.bounces = Params{}.bounces;
    Stats all;
    test::render(scene, settings, &all);
    EXPECT_GT(all.counts.vpls, two.counts.vpls);
    EXPECT_LT(double(all.counts.vpls), 1.2 * 2 * double(expected_vpls(settings.params.vpls, settings.params.bounces)));
    EXPECT_LT(all.counts.vpls, 2 * most_vpls(settings.params.vpls, settings.params.bounces));
}

const Skipped* skipped(const Stats& stats, std::string_view what) {
    for (const Skipped& part : stats.skipped)
        if (part.what == what) return &part;
    return nullptr;
}

/// A map of caustic photons is made where a surface is specular, and the result says why where there is none.
TEST(SvoManyLights, CausticPhotonsAreSentWhereSomethingIsSpecular) {
    const auto render = [](const char* scene, void (*set)(Params&)) {
        Settings settings = small();
        settings.params.caustic_photons = 2000;
        set(settings.params);
        Stats stats;
        MemoryBudget budget;
        test::render(make_builtin_scene(scene), settings, &stats, &budget);
        EXPECT_EQ(skipped(stats, "caustic map") == nullptr, budget.structures().contains("caustic_map"));
        EXPECT_EQ(budget.structures().contains("caustic_map"), stats.stage("photon_tracing").cpu_seconds > 0);
        const Skipped* map = skipped(stats, "caustic map");
        return map ? map->why : std::string("there is one");
    };
    EXPECT_EQ(render("cornell-box-glass", [](Params&) {}), "there is one");
    EXPECT_EQ(render("cornell-box", [](Params&) {}), "no specular surface");
    EXPECT_EQ(render("cornell-box-glass", [](Params& p) { p.narrow_lobes = false; }), "narrow_lobes is off");
    EXPECT_EQ(render("cornell-box-glass", [](Params& p) { p.caustic_photons = 0; }),
              "caustic_photons is 0: they are path traced");
}

/// As far as the estimate is one: to a factor of two either way.
TEST(SvoManyLights, TakesTheMemoryItSays) {
    for (const char* name : {"cornell-box", "cornell-box-glass", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const Mode& mode : {kModes[0], kModes[1], kModes[2], kModes[5]}) {
            if (std::string_view(name) == "cornell-box-glass" && &mode != &kModes[0]) continue;
            Settings settings = in_mode(mode);
            settings.size = {160, 120};
            settings.params.vpls = 1000;
            if (&mode == &kModes[0]) settings.params.caustic_photons = Params{}.caustic_photons;
            MemoryBudget budget;
            Stats stats;
            test::render(scene, settings, &stats, &budget);
            uint64_t recorded = 0;
            for (const auto& [structure, bytes] : budget.structures()) recorded += bytes;
            const uint64_t estimate =
                SvoManyLights::estimate_bytes(settings.params, test::workload_of(scene, settings));
            EXPECT_LT(recorded, 2 * estimate) << name << ", " << mode.name;
            EXPECT_GT(recorded, estimate / 2) << name << ", " << mode.name;
        }
    }
}

TEST(SvoManyLights, MoreThanTheBudgetIsRefusedBeforeItIsTaken) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = small();
    settings.params.visibility = VplVisibility::Svo;
    settings.params.voxel_resolution = 1024;
    MemoryBudget budget(20 << 20);
    Stats stats;
    try {
        test::render(scene, settings, &stats, &budget);
        FAIL() << "a tree of 1024^3 voxels in 20 MiB";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::OutOfMemory);
    }
}

TEST(SvoManyLights, FaultsOfParametersAreNamed) {
    const auto fault = [](void (*set)(Params&)) {
        Params params;
        set(params);
        try {
            params.check();
        } catch (const Error& error) {
            return error.faults.at(0).pointer;
        }
        return std::string("none");
    };
    EXPECT_EQ(fault([](Params&) {}), "none");
    EXPECT_EQ(fault([](Params& p) { p.map_resolution = 100; }), "/map_resolution");
    EXPECT_EQ(fault([](Params& p) { p.voxel_resolution = 96; }), "/voxel_resolution");
    EXPECT_EQ(fault([](Params& p) { p.interleave = 3; }), "/interleave");
}

/// The looks inside: all lights of an image that shows everything are counted, voxels lie where surfaces are seen, and
/// the split buffers hold the image's points in another order.
TEST(SvoManyLights, LayersShowWhatThereIs) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = in_mode(kModes[1]);
    settings.size = {64, 64};
    settings.layers.add(Layer::Normal);
    ask_for_all(settings);
    Stats stats;
    const Film film = test::render(scene, settings, &stats);
    const double shown = sum_of(film.resolve(Layer::Vpls));
    EXPECT_GT(shown, 0.2 * double(stats.counts.vpls));
    EXPECT_LE(shown, double(stats.counts.vpls));
    const std::vector<float> voxels = film.resolve(Layer::Voxels), normal = film.resolve(Layer::Normal),
                             split = film.resolve(Layer::SplitNormal);
    size_t lit = 0;
    for (size_t i = 0; i < settings.size.pixels(); ++i) lit += voxels[3 * i] > 0;
    EXPECT_GT(lit, settings.size.pixels() * 8 / 10);
    // Lamps have no point in the G-buffer.
    const std::vector<float> emitted = film.resolve(Layer::Emitted);
    const SplitLayout layout(settings.size, 4);
    for (uint32_t y = 0; y < 64; ++y)
        for (uint32_t x = 0; x < 64; ++x) {
            const uint32_t pixel = layout.pixel_of(layout.point_shown_at(x, y));
            ASSERT_LT(pixel, settings.size.pixels());
            if (emitted[3 * size_t{pixel}] > 0) continue;
            for (size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(split[3 * (size_t{y} * 64 + x) + c], normal[3 * size_t{pixel} + c], 1e-6f);
        }
}

TEST(SplitLayout, EachPixelHasOnePlace) {
    for (const uint32_t side : {1u, 2u, 4u, 8u})
        for (const Size2 size : {Size2{1, 1}, Size2{7, 5}, Size2{40, 35}, Size2{64, 64}}) {
            const SplitLayout layout(size, side);
            EXPECT_EQ(layout.tile_points % SplitLayout::kGroup, 0u);
            std::vector<int> met(size.pixels());
            for (uint32_t point = 0; point < layout.points(); ++point)
                if (const uint32_t pixel = layout.pixel_of(point); pixel != SplitLayout::kNoPixel) {
                    ++met.at(pixel);
                    EXPECT_EQ(layout.point_of(pixel % size.width, pixel / size.width), point);
                }
            for (const int times : met) EXPECT_EQ(times, 1);
        }
}

}  // namespace
}  // namespace photond::svo_many_lights_test
