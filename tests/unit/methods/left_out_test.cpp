// Kinds of path that methods leave out: what each says of a scene, and by rendering, that this light is missing and
// that no other is.

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <set>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/gathering/gathering_params.h"
#include "renderer/methods/path_tracing/params.h"
#include "renderer/methods/photon_splatting/params.h"
#include "renderer/methods/registry.h"
#include "renderer/methods/svo_many_lights/params.h"
#include "renderer/progressive/progressive_params.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::left_out_test {
namespace {

constexpr uint32_t kBounces = 3;
constexpr uint32_t kPasses = 24;

Material mirror(float roughness = 0) {
    Material material;
    material.metallic = 1;
    material.roughness = roughness;
    return material;
}

Material glass() {
    Material material;
    material.metallic = 0;
    material.roughness = 0;
    material.transmission = 1;
    material.solid = true;
    return material;
}

/// A spot above a floor and a wall, which it lights by a mirror, through glass or straight on.
Scene spot_scene(const std::string& caster) {
    Scene scene;
    MeshBuilder room, inside;
    room.quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}).quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2});
    test::add(scene, room.build(0), test::lambert(0.6f));
    float height = 2.8f, half_angle_degrees = 60;
    if (caster == "mirror") {
        inside.quad({-0.6f, 1, 0.5f}, {0.6f, 1, 0.5f}, {0.6f, 0.5f, -0.5f}, {-0.6f, 0.5f, -0.5f});
        test::add(scene, inside.build(0), mirror());
        half_angle_degrees = 13;
    } else if (caster == "glass ball") {  // nearer to it than its focus: what comes out is wide
        height = 2.6f, half_angle_degrees = 30;
        test::add(scene, inside.sphere({0, 2, 0}, 0.5f, 32).build(0), glass());
    }
    scene.punctual_lights = {test::spot_light({0, height, 0}, {0, -1, 0}, half_angle_degrees)};
    scene.cameras.push_back(look_at_camera({0, 1.6f, 6}, {0, 1.2f, 0}, {0, 1, 0}, 0.7f));
    finish_scene(scene);
    return scene;
}

std::unique_ptr<MethodParams> params_of(const MethodInfo& info, bool narrow_lobes) {
    std::unique_ptr<MethodParams> params = info.make_params();
    if (auto* p = dynamic_cast<PathTracingParams*>(params.get()))
        p->indirect_bounces = kBounces, p->sampler = SamplerKind::Random;
    if (auto* p = dynamic_cast<BidirectionalParams*>(params.get()))
        p->indirect_bounces = kBounces, p->sampler = SamplerKind::Random;
    if (auto* p = dynamic_cast<GatheringParams*>(params.get()))
        p->indirect_bounces = kBounces, p->photons = 2500, p->gather_rays = 4, p->sampler = SamplerKind::Random;
    if (auto* p = dynamic_cast<ProgressiveParams*>(params.get()))
        p->indirect_bounces = kBounces, p->photons = 2500, p->sampler = SamplerKind::Random;
    if (auto* p = dynamic_cast<PhotonSplattingParams*>(params.get()))
        p->bounces = kBounces, p->photons = 4000, p->sampler = SamplerKind::Random;
    if (auto* p = dynamic_cast<SvoManyLightsParams*>(params.get()))
        p->bounces = kBounces, p->vpls = 64, p->caustic_photons = 2000, p->narrow_lobes = narrow_lobes,
        p->sampler = SamplerKind::Random;
    return params;
}

/// Of the image's indirect light, over the passes.
test::RunningMean indirect_light(const MethodInfo& info, const MethodParams& params, const Scene& scene) {
    constexpr Size2 kSize{24, 24};
    MemoryBudget budget, ray_structures;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, ray_structures, stats);
    const std::unique_ptr<Method> method = info.make(params);
    method->begin({scene, intersector.get(), View{find_camera(scene, ""), kSize, PixelFilter::Box, {}}, 1, budget},
                  stats);
    test::RunningMean mean;
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        Film film(kSize, {}, pass);
        method->run_pass(pass, stats, CancelToken{});
        method->resolve(film);
        mean.add(test::mean_of(film.resolve(Layer::Indirect)));
    }
    return mean;
}

std::set<std::string> names(const PathsLeftOut& left_out) {
    std::set<std::string> found;
    for (const PathKind kind : left_out.kinds()) found.emplace(kPathKinds[static_cast<size_t>(kind)].name);
    return found;
}

/// Chance of a false alarm of a check: 1e-6 of all.
double most_standard_errors() { return test::two_sided_t(test::share_of_false_alarm(1e-6, 32), kPasses - 1); }

TEST(LeftOut, LightIsMissingWhereAMethodSaysSoAndThereAlone) {
    const MethodInfo& mapping = *find_method("photon_mapping");
    const auto mapping_params = params_of(mapping, true);
    size_t with_all = 0, with_less = 0;
    for (const char* caster : {"nothing", "mirror", "glass ball"}) {
        const Scene scene = spot_scene(caster);
        const PathsLeftOut of_mapping = mapping.left_out(*mapping_params, scene.needs);
        ASSERT_EQ(names(of_mapping), std::set<std::string>{"further_bounces"});
        const test::RunningMean whole = indirect_light(mapping, *mapping_params, scene);
        for (const MethodInfo& info : all_methods()) {
            if (!info.make || &info == &mapping) continue;  // the others run on GPUs alone
            for (const bool narrow_lobes : {true, false}) {
                if (!narrow_lobes && (info.name != "svo_many_lights" || !scene.needs.delta)) continue;
                const auto params = params_of(info, narrow_lobes);
                const PathsLeftOut said = info.left_out(*params, scene.needs).without(of_mapping);
                // Next to nothing of these rooms is seen in mirrors; that has a test of its own.
                const bool in_mirrors_alone = names(said) == std::set<std::string>{"delta_light_caustics_in_mirrors"};
                const PathsLeftOut lacks = in_mirrors_alone ? PathsLeftOut{} : said;
                const test::RunningMean found = indirect_light(info, *params, scene);
                const double missing = 1 - found.mean() / whole.mean();
                const double noise = std::hypot(found.standard_error(), whole.standard_error()) / whole.mean();
                SCOPED_TRACE(testing::Message() << caster << ", " << info.name << ": " << 100 * missing << " +- "
                                                << 100 * noise << " % missing; it says: " << lacks.text());
                std::printf("%-10s %-16s %5.1f +- %4.1f %% missing, says %zu kinds\n", caster,
                            std::string(info.name).c_str(), 100 * missing, 100 * noise, lacks.kinds().size());
                // What is said to be missing is more than nine tenths of the light in these scenes.
                ASSERT_LT(most_standard_errors() * noise, 0.8) << "too noisy to tell";
                if (lacks.empty())
                    EXPECT_NEAR(missing, 0, most_standard_errors() * noise);
                else
                    EXPECT_GT(missing, most_standard_errors() * noise);
                (lacks.empty() ? with_all : with_less) += 1;
            }
        }
    }
    EXPECT_GE(with_all, 7u);
    EXPECT_GE(with_less, 4u);
}

TEST(LeftOut, CausticsInMirrorsAreFoundByMergingAlone) {
    Scene scene = spot_scene("mirror");
    MeshBuilder wall;
    wall.quad({-4, -1, 5}, {-4, 4, 5}, {4, 4, 5}, {4, -1, 5});  // the eye looks into it
    test::add(scene, wall.build(0), mirror());
    scene.cameras = {look_at_camera({0, 1.2f, 4}, {0, 1.2f, 5}, {0, 1, 0}, 0.4f)};
    finish_scene(scene);
    const auto indirect = [&](const char* name) {
        const MethodInfo& info = *find_method(name);
        return indirect_light(info, *params_of(info, true), scene);
    };
    const test::RunningMean connected = indirect("bidirectional_path_tracing"),
                            merged = indirect("vertex_connection_and_merging"), mapped = indirect("photon_mapping");
    const double noise = std::hypot(merged.standard_error(), mapped.standard_error());
    EXPECT_GT(mapped.mean(), 10 * noise);
    EXPECT_NEAR(merged.mean(), mapped.mean(), most_standard_errors() * noise);
    EXPECT_LT(connected.mean(), 0.1 * mapped.mean());
}

/// A scene's needs: a mirror or glass, a spot, and gloss of that alpha.
Needs needs_of(bool delta, bool spot, float alpha) {
    Needs needs;
    needs.diffuse = true, needs.delta = delta, needs.punctual_lights = spot, needs.least_glossy_alpha = alpha;
    return needs;
}

TEST(LeftOut, FollowsFromParametersAndNeeds) {
    using Names = std::set<std::string>;
    const float none = std::numeric_limits<float>::infinity();
    const auto said = [](const char* name, const Needs& needs, uint32_t bounces = PathsLeftOut::kAllBounces) {
        const MethodInfo& info = *find_method(name);
        const std::unique_ptr<MethodParams> params = info.make_params();
        if (auto* p = dynamic_cast<PathTracingParams*>(params.get())) p->indirect_bounces = bounces;
        if (auto* p = dynamic_cast<GatheringParams*>(params.get())) p->indirect_bounces = bounces;
        if (auto* p = dynamic_cast<BidirectionalParams*>(params.get())) p->indirect_bounces = bounces;
        return names(info.left_out(*params, needs));
    };
    const Names caustics{"delta_light_caustics", "delta_light_after_caustics"};
    EXPECT_EQ(said("path_tracing", needs_of(true, true, none)), caustics);
    EXPECT_EQ(said("path_tracing", needs_of(true, false, none)), Names{}) << "lamps and skies are met";
    EXPECT_EQ(said("path_tracing", needs_of(false, true, none)), Names{});
    EXPECT_EQ(said("path_tracing", needs_of(true, true, none), 1), (Names{"further_bounces", "delta_light_caustics"}));
    EXPECT_EQ(said("path_tracing", needs_of(true, true, none), 0), Names{"further_bounces"});
    EXPECT_EQ(said("path_tracing", Needs{}, 0), Names{}) << "nothing scatters light";
    EXPECT_EQ(said("path_tracing", needs_of(true, true, 0.01f)).count("delta_light_in_gloss"), 1u);
    EXPECT_EQ(said("photon_mapping", needs_of(true, true, 0.01f)), Names{"delta_light_in_gloss"});
    EXPECT_EQ(said("photon_mapping", needs_of(true, true, 0.1f)), Names{}) << "that is looked up";
    EXPECT_EQ(said("reverse_photon_mapping", needs_of(true, true, 0.01f)), Names{"delta_light_in_gloss"});
    EXPECT_EQ(said("reverse_photon_mapping", needs_of(true, true, 0.1f)), Names{});
    EXPECT_EQ(said("photon_mapping", needs_of(true, true, none), 3), Names{"further_bounces"});
    EXPECT_EQ(said("bidirectional_path_tracing", needs_of(true, true, 0.01f)),
              Names{"delta_light_caustics_in_mirrors"});
    EXPECT_EQ(said("bidirectional_path_tracing", needs_of(true, false, none)), Names{});
    EXPECT_EQ(said("vertex_connection_and_merging", needs_of(true, true, 0.01f), 3), Names{"further_bounces"});
    EXPECT_EQ(said("image_based_lighting", needs_of(true, true, 0.01f)), Names{"further_bounces"});
    EXPECT_EQ(said("image_space_photon_mapping", needs_of(true, true, 0.01f)), Names{"delta_light_in_gloss"});
    EXPECT_EQ(said("visibility_filtering", needs_of(true, true, none)),
              (Names{"further_bounces", "caustics", "delta_light_caustics"}));
    for (const char* by_cells : {"light_propagation_volumes", "voxel_cone_tracing"})
        EXPECT_EQ(said(by_cells, needs_of(true, true, 0.1f)), (Names{"caustics", "delta_light_caustics"}))
            << "of all bounces";
    for (const char* baseline : {"reflective_shadow_maps", "imperfect_shadow_maps"}) {
        EXPECT_EQ(said(baseline, needs_of(false, true, 0.3f)), Names{"further_bounces"});
        EXPECT_EQ(said(baseline, needs_of(false, true, 0.1f)), (Names{"further_bounces", "caustics"}));
        EXPECT_EQ(said(baseline, needs_of(true, true, none)),
                  (Names{"further_bounces", "caustics", "delta_light_caustics"}));
    }
}

TEST(LeftOut, WhatOneLacksAndAnotherHasIsTheDifference) {
    const Needs needs = needs_of(true, true, std::numeric_limits<float>::infinity());
    const PathsLeftOut eye = left_out_by_eye_paths(PathsLeftOut::kAllBounces, needs);
    const PathsLeftOut all = left_out_by_photons(PathsLeftOut::kAllBounces, 0.05f, needs);
    const PathsLeftOut one = left_out_by_photons(1, 0.05f, needs), two = left_out_by_photons(2, 0.05f, needs);
    EXPECT_EQ(eye.without(eye).text(), "");
    EXPECT_EQ(all.without(eye).text(), "");
    EXPECT_EQ(eye.without(one).text(), "light of points, spots and suns that mirrors or smooth glass send to a surface")
        << "an image of one bounce has nothing of what a caustic lights";
    EXPECT_EQ(one.without(two).text(), "light of more than 1 bounce");
    EXPECT_EQ(two.without(one).text(), "");
    EXPECT_EQ(left_out_by_photons(0, 0.05f, needs).without(one).text(), "all light that bounces");
    const PathsLeftOut both = left_out_by_two_paths(PathsLeftOut::kAllBounces, needs);
    EXPECT_EQ(both.without(eye).text(), "") << "a part of what paths from the eye leave out";
    EXPECT_EQ(names(eye.without(both)), names(eye));
    EXPECT_EQ(names(both.without(all)), std::set<std::string>{"delta_light_caustics_in_mirrors"});
}

TEST(LeftOut, TheNarrowestGlossIsFoundInTheScene) {
    EXPECT_EQ(spot_scene("nothing").needs.least_glossy_alpha, std::numeric_limits<float>::infinity());
    EXPECT_EQ(spot_scene("mirror").needs.least_glossy_alpha, std::numeric_limits<float>::infinity());
    Scene scene = spot_scene("nothing");
    scene.materials[0] = mirror(0.3f);
    finish_scene(scene);
    EXPECT_FLOAT_EQ(scene.needs.least_glossy_alpha, 0.09f);
}

}  // namespace
}  // namespace photond::left_out_test
