// Needs: what a scene or a job does not need is not built, and the result says what, why and how many bytes that saved.
// One table for all methods; whatever any of them says it has skipped must be in it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <set>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/methods/image_based_lighting/image_based_lighting.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/methods/radiance_cache/params.h"
#include "renderer/methods/registry.h"
#include "renderer/methods/reverse_photon_mapping/reverse_photon_mapping.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/progressive/progressive_params.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/environments.h"
#include "tests/support/hard_scenes.h"

namespace photond::needs_of_methods_test {
namespace {

using SetParams = void (*)(MethodParams&);
using MakeScene = Scene (*)();

template <class P, void (*kSet)(P&)>
void set_as(MethodParams& params) {
    kSet(dynamic_cast<P&>(params));
}
void set_nothing(MethodParams&) {}

struct Outcome {
    Stats stats;
    std::map<std::string, uint64_t> structures;

    const Skipped* skipped(std::string_view what) const {
        const auto found =
            std::find_if(stats.skipped.begin(), stats.skipped.end(), [&](const Skipped& s) { return s.what == what; });
        return found == stats.skipped.end() ? nullptr : &*found;
    }
    uint64_t bytes(const std::vector<std::string_view>& names) const {
        uint64_t sum = 0;
        for (const auto& [name, bytes] : structures)
            if (std::count(names.begin(), names.end(), name)) sum += bytes;
        return sum;
    }
    double seconds(const std::vector<std::string_view>& names) const {
        double sum = 0;
        for (const Stage& stage : stats.stages)
            if (std::count(names.begin(), names.end(), stage.name)) sum += stage.cpu_seconds;
        return sum;
    }
};

Outcome run(std::string_view method_name, const Scene& scene, SetParams set) {
    const MethodInfo& info = *find_method(method_name);
    const std::unique_ptr<MethodParams> params = info.make_params();
    set(*params);
    params->check();
    MemoryBudget budget, ray_structures;
    Outcome result;
    const auto intersector = make_embree_intersector(scene, ray_structures, result.stats);
    const std::unique_ptr<Method> method = info.make(*params);
    constexpr Size2 kSize{32, 32};
    method->begin({scene, intersector.get(), View{find_camera(scene, ""), kSize, PixelFilter::Box, {}}, 1, budget},
                  result.stats);
    Film film(kSize, {});
    method->run_pass(0, result.stats, CancelToken{});
    method->resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    result.structures = budget.structures();
    return result;
}

template <const auto& kName>
Scene builtin() {
    return make_builtin_scene(kName);
}
constexpr char kBox[] = "cornell-box", kGlass[] = "cornell-box-glass", kGlossy[] = "cornell-box-glossy";

Scene leaves() {
    Material leaf = test::lambert(0.5f);
    leaf.alpha = 0.5f;
    leaf.alpha_mode = AlphaMode::Blend;
    Scene scene = test::corner(leaf);
    scene.punctual_lights = {test::lamp()};
    finish_scene(scene);
    return scene;
}
Scene under_a_sky() {
    Scene scene = make_builtin_scene("cornell-box");
    scene.environment = test::sky({64, 32});
    finish_scene(scene);
    return scene;
}
Scene dark() {
    Scene scene = make_builtin_scene("cornell-box");
    for (Material& material : scene.materials) material.emission = Rgb(0);
    finish_scene(scene);
    return scene;
}

void one_gathered_bounce(PhotonMappingParams& p) { p.indirect_bounces = 1, p.gather_rays = 2; }
void gathered(PhotonMappingParams& p) { p.gather_rays = 2; }
void one_reversed_bounce(ReversePhotonMappingParams& p) { p.indirect_bounces = 1, p.gather_rays = 2; }
void reversed(ReversePhotonMappingParams& p) { p.gather_rays = 2; }
void direct(PhotonMappingParams& p) { p.photons = 5000, p.gather = Gather::Direct; }
void precomputed(PhotonMappingParams& p) { p.photons = 5000, p.gather_rays = 16; }
void progressive(ProgressiveParams& p) { p.photons = 5000; }
void progressive_without_bounces(ProgressiveParams& p) { p.photons = 5000, p.indirect_bounces = 0; }
void all_techniques(BidirectionalParams& p) { p.adapt = false; }
void kernel(PhotonSplattingParams& p) { p.estimator = SplatEstimator::Kernel; }
void blind(PhotonSplattingParams& p) { p.visibility = false; }
void no_bounces(PhotonSplattingParams& p) { p.bounces = 0; }
void no_lights(SvoManyLightsParams& p) { p.bounces = 0; }
void small_maps(ImageBasedLightingParams& p) { p.prefilter_resolution = 64, p.prefilter_levels = 4; }
void without_cached_bounces(RadianceCacheParams& p) { p.indirect_bounces = 0; }
void by_voxels(SvoManyLightsParams& p) { p.visibility = VplVisibility::Svo, p.voxel_resolution = 64; }

/// A part of a method, where it is skipped and where it is not.
struct Part {
    std::string_view method, what;
    MakeScene without;
    SetParams without_params;
    MakeScene with;
    SetParams with_params;
    std::vector<std::string_view> structures;  // of the budget, that are its own; none: it takes no memory
    std::vector<std::string_view> stages;      // that are its own, or that it makes longer
    double within = 0;                         // bytes saved against those it takes where it is needed: factor
};

std::vector<Part> parts() {
    constexpr SetParams kGathered = set_as<PhotonMappingParams, gathered>;
    constexpr SetParams kReversed = set_as<ReversePhotonMappingParams, reversed>;
    constexpr SetParams kSmallMaps = set_as<ImageBasedLightingParams, small_maps>;
    constexpr SetParams kKernel = set_as<PhotonSplattingParams, kernel>;
    const std::string_view kTracing = "path_tracing", kMapping = "photon_mapping", kSplatting = "photon_splatting",
                           kLights = "svo_many_lights", kReverse = "reverse_photon_mapping";
    const MakeScene box = builtin<kBox>, glass = builtin<kGlass>, glossy = builtin<kGlossy>;
    std::vector<Part> all{
        {kTracing, "layered shading", box, set_nothing, glossy, set_nothing, {}, {"direct", "indirect"}},
        {kTracing, "absorption", box, set_nothing, glass, set_nothing, {}, {}},
        {kTracing, "alpha test of rays", box, set_nothing, leaves, set_nothing, {}, {}},
        {kMapping, "caustic map", box, kGathered, glass, kGathered, {"caustic_map"}, {"photon_tracing"}, 4},
        {kMapping,
         "global map",
         box,
         set_as<PhotonMappingParams, one_gathered_bounce>,
         box,
         kGathered,
         {"global_map"},
         {"photon_tracing", "photon_map_build"},
         3},
        {kMapping,
         "precomputed irradiance",
         box,
         set_as<PhotonMappingParams, direct>,
         box,
         set_as<PhotonMappingParams, precomputed>,
         {"precomputed_irradiance"},
         {"photon_map_build"},
         1.5},
        {kMapping, "absorption", box, kGathered, glass, kGathered, {}, {}},
        {kReverse, "caustic map", box, kReversed, glass, kReversed, {"caustic_map"}, {"photon_tracing"}, 4},
        {kReverse,
         "global map",
         box,
         set_as<ReversePhotonMappingParams, one_reversed_bounce>,
         box,
         kReversed,
         {"global_map"},
         {"photon_tracing", "photon_map_build"},
         3},
        {kReverse, "absorption", box, kReversed, glass, kReversed, {}, {}},
        {kSplatting,
         "splats",
         dark,
         set_nothing,
         box,
         set_nothing,
         {"photons", "splat_batch"},
         {"photon_tracing", "splat_find", "splat"},
         2},
        {kSplatting,
         "splats",
         box,
         set_as<PhotonSplattingParams, no_bounces>,
         box,
         set_nothing,
         {"photons", "splat_batch"},
         {"photon_tracing", "splat_find", "splat"},
         0},
        {kSplatting, "shaft visibility", box, kKernel, box, set_nothing, {"shaft_visibility"}, {"shaft_build"}, 2},
        {kSplatting,
         "shaft visibility",
         box,
         set_as<PhotonSplattingParams, blind>,
         box,
         set_nothing,
         {"shaft_visibility"},
         {"shaft_build"},
         2},
        {kSplatting, "depth maps of beams", box, set_nothing, glass, set_nothing, {}, {"splat_depth"}},
        {kSplatting, "absorption", box, set_nothing, glass, set_nothing, {}, {}},
        {kLights, "virtual point lights", dark, set_nothing, box, set_nothing, {"vpls"}, {"vpl_generation"}, 3},
        {kLights,
         "virtual point lights",
         box,
         set_as<SvoManyLightsParams, no_lights>,
         box,
         set_nothing,
         {"vpls"},
         {"vpl_generation"},
         0},
        {kLights,
         "sparse voxel octree",
         box,
         set_nothing,
         box,
         set_as<SvoManyLightsParams, by_voxels>,
         {"sparse_voxel_octree"},
         {"svo_build"},
         0},
        {kLights, "absorption", box, set_nothing, glass, set_nothing, {}, {}},
        {kLights, "caustic map", box, set_nothing, glass, set_nothing, {"caustic_map"}, {"photon_tracing"}, 3},
        {"image_based_lighting",
         "prefiltered environment",
         box,
         kSmallMaps,
         under_a_sky,
         kSmallMaps,
         {"prefiltered_environment"},
         {"prefilter"},
         1.01},
        {"radiance_cache", "directions of cells", box, set_nothing, glossy, set_nothing, {}, {}},
        {"radiance_cache",
         "radiance cache",
         box,
         set_as<RadianceCacheParams, without_cached_bounces>,
         box,
         set_nothing,
         {"radiance_cache"},
         {"cache_fill"},
         1.01},
    };
    constexpr SetParams kProgressive = set_as<ProgressiveParams, progressive>,
                        kWithoutBounces = set_as<ProgressiveParams, progressive_without_bounces>;
    for (const std::string_view method : {"progressive_photon_mapping", "stochastic_progressive_photon_mapping",
                                          "probabilistic_progressive_photon_mapping"}) {
        all.push_back(
            {method, "caustic map", box, kProgressive, glass, kProgressive, {"caustic_map"}, {"photon_tracing"}});
        all.push_back({method,
                       "global map",
                       box,
                       kWithoutBounces,
                       box,
                       kProgressive,
                       {"global_map"},
                       {"photon_tracing", "photon_map_build"},
                       4});
        all.push_back({method, "absorption", box, kProgressive, glass, kProgressive, {}, {}});
    }
    constexpr SetParams kAll = set_as<BidirectionalParams, all_techniques>;
    for (const std::string_view method : {"bidirectional_path_tracing", "vertex_connection_and_merging"}) {
        all.push_back({method, "light paths", dark, kAll, box, kAll, {"light_vertices"}, {"light_paths"}, 3});
        all.push_back({method, "absorption", box, set_nothing, glass, set_nothing, {}, {}});
    }
    return all;
}

TEST(NeedsOfMethods, WhatIsNotNeededIsNotBuilt) {
    for (const Part& part : parts()) {
        SCOPED_TRACE(testing::Message() << part.method << ": " << part.what);
        const Outcome without = run(part.method, part.without(), part.without_params);
        const Outcome with = run(part.method, part.with(), part.with_params);
        const Skipped* skipped = without.skipped(part.what);
        ASSERT_NE(skipped, nullptr);
        EXPECT_FALSE(skipped->why.empty());
        EXPECT_EQ(with.skipped(part.what), nullptr);
        EXPECT_EQ(without.bytes(part.structures), 0u);

        // Bytes are said where the part has some, and are about what it takes.
        const uint64_t taken = with.bytes(part.structures);
        EXPECT_EQ(skipped->bytes_saved > 0, !part.structures.empty());
        EXPECT_EQ(taken > 0, !part.structures.empty());
        const double saved = double(skipped->bytes_saved);
        std::printf("%-17s %-22s %9.1f kB saved (%9.1f kB where needed), %7.2f ms of its stages (%7.2f ms)\n",
                    std::string(part.method).c_str(), std::string(part.what).c_str(), saved / 1e3, double(taken) / 1e3,
                    1e3 * without.seconds(part.stages), 1e3 * with.seconds(part.stages));
        if (part.within > 0) {
            EXPECT_LE(saved, part.within * double(taken));
            EXPECT_GE(saved, double(taken) / part.within);
        }
    }
}

TEST(NeedsOfMethods, AllThatIsSkippedAnywhereIsInTheTable) {
    // "connections" and "merging" are a pilot's choice: technique_choice_test. Indirect light image_based_lighting has
    // none of, in any scene.
    std::set<std::pair<std::string, std::string>> known{{"bidirectional_path_tracing", "connections"},
                                                        {"vertex_connection_and_merging", "connections"},
                                                        {"vertex_connection_and_merging", "merging"},
                                                        {"svo_many_lights", "projection map"},
                                                        {"image_based_lighting", "indirect light"}};
    // Both are judged by photons: projection_map_test.
    for (const char* method : {"photon_mapping", "reverse_photon_mapping", "progressive_photon_mapping",
                               "stochastic_progressive_photon_mapping", "probabilistic_progressive_photon_mapping"})
        for (const char* map : {"projection map", "global projection map"}) known.emplace(method, map);
    for (const Part& part : parts()) known.emplace(part.method, part.what);
    for (const MethodInfo& method : all_methods()) {
        if (!method.make) continue;  // runs on GPUs alone: in its own test
        size_t skipped = 0;
        for (const MakeScene make : {MakeScene(builtin<kBox>), MakeScene(builtin<kGlass>), MakeScene(dark)}) {
            const Outcome all = run(method.name, make(), [](MethodParams& params) {
                if (auto* p = dynamic_cast<GatheringParams*>(&params)) p->photons = 2000, p->gather_rays = 2;
                if (auto* p = dynamic_cast<ProgressiveParams*>(&params)) p->photons = 2000;
                if (auto* p = dynamic_cast<PhotonSplattingParams*>(&params)) p->photons = 500;
            });
            std::set<std::string> names;
            for (const Skipped& part : all.stats.skipped) {
                EXPECT_TRUE(known.contains({std::string(method.name), part.what})) << method.name << ": " << part.what;
                EXPECT_TRUE(names.insert(part.what).second) << method.name << " names it twice: " << part.what;
                EXPECT_FALSE(part.why.empty());
                ++skipped;
            }
        }
        EXPECT_GT(skipped, 0u) << method.name << " needs all of every scene?";
    }
}

}  // namespace
}  // namespace photond::needs_of_methods_test
